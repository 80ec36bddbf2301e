#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# An 11520 x 2160 float TIFF through the optimal filter to 3840 x 2160, file to file, beside `vips resize` of the
# same size, run in turns; and the peak memory at that height and at four times it.
#
#   strips_bench.sh TRIAD [RUNS]
set -euo pipefail
triad=${1:?name the triad program}
runs=${2:-7}
folder=$(mktemp -d)
trap 'rm -rf -- "$folder"' EXIT
cd -- "$folder"

# noise HEIGHT FILE: a picture that no shortcut fits.
noise() {
  local band
  for band in 1 2 3; do vips gaussnoise "band$band.v" 11520 "$1" --mean .5 --sigma .2 --seed "$band"; done
  vips bandjoin 'band1.v band2.v band3.v' "$2[compression=none]"
  rm -f band?.v
}

# seconds COMMAND...: the wall time of a command.
seconds() {
  local start end
  start=$(date +%s%N)
  "$@" >/dev/null
  end=$(date +%s%N)
  awk -v ns=$((end - start)) 'BEGIN { printf "%.3f\n", ns / 1e9 }'
}

median() { sort -n | awk '{ v[NR] = $1 } END { print (v[int((NR + 1) / 2)] + v[int(NR / 2) + 1]) / 2 }'; }

# peak COMMAND...: the largest resident size, in MB of 10^6 bytes.
peak() { /usr/bin/time -f %M -o kb.txt "$@" >/dev/null && awk '{ printf "%.0f\n", $1 * 1.024e-3 }' kb.txt; }

filter() { "$triad" run "$1" --cells 3x1 --threads 2 platt:range=clip,engine=fir,taps=31 -o out.tif --compression none; }
resize() { vips resize "$1" out-vips.tif 0.33333333 --vscale 1 --kernel lanczos3 --vips-concurrency 2; }
copy() { cat -- "$1" >copy.bin; }

noise 2160 in.tif
filter in.tif && resize in.tif && copy in.tif  # once before the clock runs
for ((i = 0; i < runs; ++i)); do
  seconds filter in.tif >>triad.txt
  seconds resize in.tif >>vips.txt
  seconds copy in.tif >>copy.txt
done
a=$(median <triad.txt) b=$(median <vips.txt) c=$(median <copy.txt)
printf '11520x2160 -> 3840x2160, median of %s runs in turns:\n' "$runs"
printf '  triad run platt:range=clip,engine=fir,taps=31   %6.3f s\n  vips resize lanczos3                 %6.3f s\n' "$a" "$b"
printf '  copy of the input file               %6.3f s\n' "$c"
awk -v a="$a" -v b="$b" -v c="$c" 'BEGIN { printf "  triad / vips %.2f (goal 1.5), triad / copy %.2f\n", a / b, a / c }'
low=$(peak "$triad" run in.tif --cells 3x1 --threads 2 platt:range=clip,engine=fir,taps=31 -o out.tif --compression none)
noise 8640 tall.tif
high=$(peak "$triad" run tall.tif --cells 3x1 --threads 2 platt:range=clip,engine=fir,taps=31 -o out.tif --compression none)
awk -v l="$low" -v h="$high" \
  'BEGIN { printf "  peak memory %d MB at 2160 rows, %d MB at 8640: ratio %.3f (goals: 400 MB, 1.05)\n", l, h, h / l }'

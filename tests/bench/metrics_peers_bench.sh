#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Comparisons from file to score, with two threads, beside the tools that have the same metric, in turns: vips dE76 and
# dE00 (which write the map, as triad does with --map), ImageMagick's compare and idiff. And a copy of both files.
#
#   metrics_peers_bench.sh TRIAD [RUNS]
set -euo pipefail
source "$(dirname -- "${BASH_SOURCE[0]}")/bench.bash"
triad=$(realpath -- "${1:?name the triad program}")
runs=${2:-7}
need metrics_peers_bench vips compare idiff
cd -- "$folder"
export VIPS_CONCURRENCY=2 MAGICK_THREAD_LIMIT=2 OMP_NUM_THREADS=2

# noise WIDTH HEIGHT SEED FILE: linear light, all of it above 0.
noise() {
  local band
  for band in 1 2 3; do vips gaussnoise "band$band.v" "$1" "$2" --mean .5 --sigma .08 --seed $((band + $3)); done
  vips bandjoin 'band1.v band2.v band3.v' rgb.v
  vips copy rgb.v "$4[compression=none]" --interpretation scrgb
  rm -f band?.v rgb.v
}

# seconds FILE COMMAND...: appends the wall time of a command and what it took of the processors. Idiff and compare say by
# their status that pictures differ.
seconds() {
  local TIMEFORMAT='%R %U %S'
  { time "${@:2}" >/dev/null 2>&1 || true; } 2>&1 | awk '{ print $1, $2 + $3 }' >>"$1"
}
# median FILE COLUMN
median() {
  awk -v c="$2" '{ print $c }' "$1" | sort -n |
    awk '{ v[NR] = $1 } END { printf "%.3f", (v[int((NR + 1) / 2)] + v[int(NR / 2) + 1]) / 2 }'
}

score() { "$triad" compare test.tif --ref reference.tif -m "$1" --threads 2 "${@:2}"; }
copy() { cat -- test.tif reference.tif >copy.bin; }

# beside NAME METRIC COMMAND...: one line of the table.
beside() {
  local run file
  rm -f ./*.txt
  score "$2" >/dev/null && seconds warm.txt "${@:3}"  # once before the clock runs
  for ((run = 0; run < runs; ++run)); do
    seconds triad.txt score "$2"
    seconds map.txt score "$2" --map map.tif
    seconds peer.txt "${@:3}"
    seconds copy.txt copy
  done
  printf '%-11s' "$2"
  for file in triad map peer copy; do
    [[ $file != peer ]] || printf '   %-20s' "$1"
    printf '  %7s %7s' "$(median "$file.txt" 1)" "$(median "$file.txt" 2)"
  done
  awk -v t="$(median triad.txt 1)" -v p="$(median peer.txt 1)" -v u="$(median triad.txt 2)" -v q="$(median peer.txt 2)" \
    'BEGIN { printf "   triad / peer %.2f (processors %.2f)\n", t / p, u / q }'
}

for size in 1920x1080 3840x2160; do
  noise "${size%x*}" "${size#*x}" 0 test.tif
  noise "${size%x*}" "${size#*x}" 9 reference.tif
  vips dE00 test.tif reference.tif map.v
  printf '%s: seconds by the clock and of the processors, median of %s runs in turns\n' "$size" "$runs"
  printf 'mean CIEDE2000: vips %s, %s\n' "$(vips avg map.v)" "$(score ciede2000 | tail -1)"
  printf '%-11s  %15s  %15s   %-20s  %15s  %15s\n' metric triad 'with a map' peer '' copy
  beside 'vips dE76' cie76 vips dE76 test.tif reference.tif map.v
  beside 'vips dE00' ciede2000 vips dE00 test.tif reference.tif map.v
  beside 'compare -metric RMSE' error compare -metric RMSE test.tif reference.tif null:
  beside 'idiff -a' error idiff -a test.tif reference.tif
  beside 'idiff -a' relmse-tev idiff -a test.tif reference.tif
done

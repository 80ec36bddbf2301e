#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Comparisons from file to score, with two threads, beside the tools that have the same metric, in turns: vips dE76 and
# dE00 (which write the map, as triad does with --map), ImageMagick's compare and idiff. And a copy of both files.
# What a program needs to start (its libraries, above all: OpenImageIO's for triad and idiff) is measured on pictures of
# 16x16, and the second ratio is without it: what reading and evaluating the pictures takes. Last, a sequence of frames,
# which triad compares in one call.
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

# in_turns SIZE METRIC COMMAND...: the medians of triad, triad with a map, the command and a copy, as start_ or whole_
# triad, map, peer and copy, each "SECONDS PROCESSOR-SECONDS".
in_turns() {
  local into=$1 metric=$2 run file
  shift 2
  rm -f ./*.txt
  score "$metric" >/dev/null && seconds warm.txt "$@"  # once before the clock runs
  for ((run = 0; run < runs; ++run)); do
    seconds triad.txt score "$metric"
    seconds map.txt score "$metric" --map map.tif
    seconds peer.txt "$@"
    seconds copy.txt copy
  done
  for file in triad map peer copy; do
    printf -v "${into}_$file" '%s %s' "$(median "$file.txt" 1)" "$(median "$file.txt" 2)"
  done
}

# beside NAME METRIC COMMAND...: one line of the table.
beside() {
  local name=$1 start_triad start_map start_peer start_copy whole_triad whole_map whole_peer whole_copy
  shift
  ln -sf tiny-test.tif test.tif
  ln -sf tiny-reference.tif reference.tif
  in_turns start "$@"
  ln -sf full-test.tif test.tif
  ln -sf full-reference.tif reference.tif
  in_turns whole "$@"
  # shellcheck disable=SC2086  # two numbers each
  printf '%-11s  %7s %7s  %7s %7s   %-20s  %7s %7s  %7s %7s' "$1" $whole_triad $whole_map "$name" $whole_peer $whole_copy
  awk -v t="$whole_triad $start_triad" -v p="$whole_peer $start_peer" 'BEGIN {
    split(t, a, " "); split(p, b, " ")
    printf "   triad / peer %.2f, without the start (%.2f and %.2f s) %.2f\n", a[1] / b[1], a[3], b[3], (a[1] - a[3]) / (b[1] - b[3])
  }'
}

noise 16 16 0 tiny-test.tif
noise 16 16 9 tiny-reference.tif
for size in 1920x1080 3840x2160; do
  noise "${size%x*}" "${size#*x}" 0 full-test.tif
  noise "${size%x*}" "${size#*x}" 9 full-reference.tif
  vips dE00 full-test.tif full-reference.tif map.v
  printf '%s: seconds by the clock and of the processors, median of %s runs in turns\n' "$size" "$runs"
  printf 'mean CIEDE2000: vips %s, %s\n' "$(vips avg map.v)" \
    "$("$triad" compare full-test.tif --ref full-reference.tif -m ciede2000 | tail -1)"
  printf '%-11s  %15s  %15s   %-20s  %15s  %15s\n' metric triad 'with a map' peer '' copy
  beside 'vips dE76' cie76 vips dE76 test.tif reference.tif map.v
  beside 'vips dE00' ciede2000 vips dE00 test.tif reference.tif map.v
  beside 'compare -metric RMSE' error compare -metric RMSE test.tif reference.tif null:
  beside 'idiff -a' error idiff -a test.tif reference.tif
  beside 'idiff -a' relmse-tev idiff -a test.tif reference.tif
done

frames=12
mkdir -p frames references
noise 1920 1080 0 full-test.tif
noise 1920 1080 9 full-reference.tif
for ((n = 1; n <= frames; ++n)); do
  cp full-test.tif "frames/f.$(printf %04d "$n").tif"
  cp full-reference.tif "references/f.$(printf %04d "$n").tif"
done
sequence() { "$triad" compare 'frames/f.####.tif' --ref 'references/f.####.tif' -m error --threads 2; }
each_frame() {
  local n
  for ((n = 1; n <= frames; ++n)); do
    "$@" "frames/f.$(printf %04d "$n").tif" "references/f.$(printf %04d "$n").tif" "${last[@]}" || true
  done
}
rm -f ./*.txt
for ((run = 0; run < runs; ++run)); do
  seconds triad.txt sequence
  last=(null:)
  seconds compare.txt each_frame compare -metric RMSE
  last=()
  seconds idiff.txt each_frame idiff -a
done
printf '%s frames of 1920x1080, seconds: triad compare, one call %s, compare -metric RMSE for each %s, idiff -a for each %s\n' \
  "$frames" "$(median triad.txt 1)" "$(median compare.txt 1)" "$(median idiff.txt 1)"

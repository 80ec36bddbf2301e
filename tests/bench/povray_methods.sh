#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# pov1 and pov2 beside POV-Ray 3.7's own methods 1 and 2, on the strokes at 400 x 225: samples taken, and how far the
# pictures are apart. Ours see the scene through POV-Ray's picture of it at many times the size, without antialiasing.
#
#   povray_methods.sh TRIAD [THRESHOLD] [N]   (THRESHOLD as 0.3, with its 0)
#
# A sample of a picture is the pixel that it lies in, so the large pictures are made such that the places asked for are
# the centres of their pixels: 5 n times the size for a grid of n x n, n odd; 16 times the size, and moved by half of a
# small pixel, for corners and what is halfway between them.
#
# What is made equal: POV-Ray 3.7 divides a pixel once less than its +R says, as its level is 1 too low from the start
# (tracetask.cpp), so +R3 is depth=2. Its blocks are larger than the picture, or it would take samples on their borders
# twice; what is left of that is a row and a column beyond the picture for method 1. It does not share what lies between
# the corners with the next pixel, so for method 2 both our samples are said, and the samples if each pixel took its
# own, which must agree.
#
# Fails unless samples agree within 10% and pictures within an RMSE of .02.
set -euo pipefail
shopt -s inherit_errexit
triad=$(realpath -- "${1:?name the triad program}")
threshold=${2:-0.3}
n=${3:-3}
here=$(cd -- "$(dirname -- "$0")" && pwd)
scenes=$(realpath -- "$here/../../data/scenes")
width=400 height=225
((n % 2 == 1 && n >= 3 && n <= 5)) || {
  printf 'povray_methods: N is %s; it must be 3 or 5\n' "$n" >&2
  exit 2
}

source "$here/bench.bash"
need povray_methods povray jq
cd -- "$folder"

# draw SCENE OUT TIMES OPTION...: by POV-Ray.
draw() {
  quiet povray "+I$1" "+L$scenes" -D -GD -GR -GF -GW +WT2 "+W$((width * $3))" "+H$((height * $3))" -J \
    Antialias_Gamma=2.5 Render_Block_Size=512 +FE "+O$2" "${@:4}"
}

# statistic NAME: of the picture drawn last.
statistic() { sed -n "s/.*$1: *\([0-9]*\).*/\1/p" log.txt | head -n 1; }

# ours LARGE STRATEGY OUT: samples.
ours() {
  quiet "$triad" render "$1" -o "$3" --size "${width}x$height" --strategy "$2" --aov reasons --json facts.json
  jq -r .samples facts.json
}

rmse() { "$triad" compare "$1" --ref "$2" -m error --json - | jq -r '.results[0].scores.rmse'; }

failed=0
# report METHOD COUNTED OURS POV-RAY RMSE
report() {
  awk -v method="$1" -v counted="$2" -v ours="$3" -v theirs="$4" -v rmse="$5" 'BEGIN {
    printf "%-32s %-24s %9d %9d  %+7.3f%%  %.5f\n", method, counted, ours, theirs, 100 * (ours / theirs - 1), rmse }'
}
judge() {
  awk -v ours="$1" -v theirs="$2" -v rmse="$3" \
    'BEGIN { ratio = ours / theirs; exit !(ratio >= .9 && ratio <= 1.1 && rmse <= .02) }' || failed=1
}

times=16
printf '#version 3.7;\n#include "strokes.pov"\n#declare Half = 1 / %d;\n' "$((2 * times))" >moved.pov
cat >>moved.pov <<'END'
camera { orthographic location <-Half, Half, -1000> look_at <-Half, Half, 0> right x * 400 up y * 225 }
END
draw strokes.pov grids.exr "$((5 * n))" -A
draw moved.pov corners.exr "$times" -A

printf '%-32s %-24s %9s %9s  %8s  %s\n' method counted ours POV-Ray '' RMSE
draw strokes.pov method1.exr 1 "+A$threshold" +AM1 "+R$n"
theirs=$(($(statistic Pixels) + $(statistic Samples)))
samples=$(ours grids.exr "pov1:n=$n,threshold=$threshold" pov1.exr)
apart=$(rmse pov1.exr method1.exr)
report "pov1:n=$n and +AM1 +R$n" 'all samples' "$samples" "$theirs" "$apart"
judge "$samples" "$theirs" "$apart"

for depth in 2 3; do
  draw strokes.pov method2.exr 1 "+A$threshold" +AM2 "+R$((depth + 1))"
  pixels=$(statistic Pixels)
  theirs=$((pixels + $(statistic Samples)))
  samples=$(ours corners.exr "pov2:depth=$depth,threshold=$threshold" pov2.exr)
  apart=$(rmse pov2.exr method2.exr)
  report "pov2:depth=$depth and +AM2 +R$((depth + 1))" 'shared by pixels' "$samples" "$theirs" "$apart"
  # The mean of reason.points, which is the last channel of the file and so its last four bytes.
  quiet "$triad" run pov2.exr "box:x=$width,y=$height" -o mean.exr --compression none --depth float
  own=$(tail -c 4 mean.exr | od -An -tf4 | awk -v n="$((width * height))" -v corners="$pixels" \
    '{ printf "%d", ($1 - 4) * n + corners + .5 }')
  report "" 'each pixel for itself' "$own" "$theirs" "$apart"
  judge "$own" "$theirs" "$apart"
done
exit "$failed"

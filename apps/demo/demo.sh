#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# demo.sh TRIAD TOP OUT: renders data/scenes/strokes.pov with POV-Ray, makes a picture for a display from it in
# six ways, and judges each against the wide render that it was made from and against the ground truth.
set -euo pipefail
export LC_ALL=C  # numbers with a point

readonly triad=$1 top=$2 out=$3
readonly methods=(control box subpixel clipped unbounded regularised)
declare -A title=(
  [control]='control: one sample a pixel'
  [box]='box: three samples averaged'
  [subpixel]='a sample for each subpixel'
  [clipped]='Platt 2000, clipped to 0 ... 1'
  [unbounded]='Platt 2000, unbounded'
  [regularised]='platt as it is by default'
)
# The filter of 2000 as its author has it: nothing but the least error, on a row whose ends meet.
readonly optimum='platt:engine=fft,lambda=0,flat-field=free,edge=wrap'
declare -A stage=(
  [box]='box:x=3'
  [subpixel]=subpixel
  [clipped]="$optimum,range=clip"
  [unbounded]="$optimum,range=unbounded"
  [regularised]=platt
)

die() {
  printf 'demo: %s\n' "$1" >&2
  exit 1
}

# timed COMMAND...: runs it; elapsed_s is the time it took.
timed() {
  local start=$EPOCHREALTIME
  "$@"
  elapsed_s=$(jq -n "$EPOCHREALTIME - $start")
}

# render NAME WIDTH HEIGHT: linear half EXR, one ray through the middle of each pixel.
render() {
  timed povray "+I$top/data/scenes/strokes.pov" -D -V -J -A "+WT$(nproc)" "+W$2" "+H$3" +FE \
    "+O$1.exr" >povray.log 2>&1 || {
    cat povray.log >&2
    die "POV-Ray could not render strokes.pov at $2x$3"
  }
}

# score WHERE TEST LABEL: one number of a report.
score() {
  jq -e --arg test "$2.exr" --arg label "$3" \
    'first(.results[] | select(.test == $test and .label == $label) | .scores.rmse)' "$1.json"
}

# round NUMBER [DIGITS]: significant digits for people.
round() { printf "%.${2:-3}g" "$1"; }

# times A B: how the error A compares with the error B, in words.
times() {
  local ratio
  ratio=$(jq -n --argjson a "$1" --argjson b "$2" 'if $a < $b then $b / $a else $a / $b end')
  if jq -en "$1 < $2" >/dev/null; then
    printf '%s times less than' "$(round "$ratio" 2)"
  else
    printf '%s times more than' "$(round "$ratio" 2)"
  fi
}

mkdir -p -- "$out"
cd -- "$out"

printf 'Rendering strokes.pov with POV-Ray: 400x225, 1200x225, 4800x2700\n'
render control 400 225
declare -A seconds=([control]=$elapsed_s)
render wide 1200 225
wide_s=$elapsed_s
render truth 4800 2700
# The ground truth has 12x12 samples a pixel; here averaged to the cells of a wide render, and to pixels.
"$triad" run truth.exr --cells 12x12 box:x=4,y=12 -o truth-wide.exr --depth float
"$triad" run truth.exr --cells 12x12 box:x=12,y=12 write:truth-pixels.exr -o truth-pixels.png --depth float

printf 'Making the pictures\n'
"$triad" run control.exr -o control.png
for method in "${methods[@]:1}"; do
  timed "$triad" run wide.exr --cells 3x1 "${stage[$method]}" -o "$method.exr" --depth float
  seconds[$method]=$(jq -n "$wide_s + $elapsed_s")
  "$triad" run "$method.exr" -o "$method.png"
done

printf 'Judging them\n'
# As the filter sees a row: its ends meet, and no pixel is left out.
readonly judge=edge=wrap,border=0
pictures=("${methods[@]/%/.exr}")
for reference in wide truth-wide; do
  "$triad" compare "${pictures[@]}" --ref "$reference.exr" --ref-cells 3x1 \
    -m "display:$judge,range=clip@shown" -m "display:$judge,range=unbounded@asked" --json "$reference.json" >/dev/null
done
"$triad" compare "${pictures[@]}" --ref truth-pixels.exr -m error@plain --json truth-pixels.json >/dev/null

povray "+I$top/data/scenes/comparison.pov" -D -V -A -J +W1824 +H1096 +FN8 +Ocomparison.png >povray.log 2>&1 || {
  cat povray.log >&2
  die 'POV-Ray could not lay out comparison.png'
}
rm -f povray.log

printf '\n%-31s %8s | %21s | %21s | %9s\n' '' '' 'against the wide' 'against the truth' 'RMSE, to'
printf '%-31s %8s | %10s %10s | %10s %10s | %9s\n' 'error seen at 40 ppd' 'seconds' 'shown' 'unbounded' 'shown' \
  'unbounded' 'its pixels'
printf '%s\n' '-----------------------------------------+-----------------------+-----------------------+-----------'
for method in "${methods[@]}"; do
  printf '%-31s %8.3f | %10.5f %10.5f | %10.5f %10.5f | %9.5f\n' "${title[$method]}" "${seconds[$method]}" \
    "$(score wide "$method" shown)" "$(score wide "$method" asked)" \
    "$(score truth-wide "$method" shown)" "$(score truth-wide "$method" asked)" \
    "$(score truth-pixels "$method" plain)"
done

best=$(jq -r '[.results[] | select(.label == "asked")] | min_by(.scores.rmse) | .test' wide.json)
[[ $best == unbounded.exr ]] ||
  die "$best has a lower error than the unbounded optimum, which cannot be: something is broken"
box_shown=$(score wide box shown)
truth_box=$(score truth-wide box shown)
best_shown=$(jq -r '[.results[] | select(.label == "shown")] | min_by(.scores.rmse) | .test' truth-wide.json)
best_shown=${best_shown%.exr}
fold -s -w 110 <<END

Judged by the picture it was made from, and allowed any light it asks for, the optimal filter errs least of \
all, as theory says it must: $(round "$(score wide unbounded asked)"), \
$(times "$(score wide unbounded asked)" "$(score wide box asked)") the plain average of three samples \
($(round "$(score wide box asked)")). A display has no light below 0 or above 1. Clipped to what it can show, the \
same filter errs $(round "$(score wide clipped shown)"), \
$(times "$(score wide clipped shown)" "$box_shown") the average; one sample for each subpixel errs \
$(times "$(score wide subpixel shown)" "$box_shown") it, one sample for each pixel \
$(times "$(score wide control shown)" "$box_shown") it, and the regularised filter, clipped too, \
$(times "$(score wide regularised shown)" "$box_shown") it. Against the ground truth of 144 samples a pixel, \
where the three samples a pixel that all filters were given count as errors themselves, the average errs \
$(round "$truth_box") and the unbounded optimum $(round "$(score truth-wide unbounded asked)"); of what a display \
can show, the least is $(round "$(score truth-wide "$best_shown" shown)") ("${title[$best_shown]}").

The pictures are in $out; comparison.png shows a part of each, enlarged.
END

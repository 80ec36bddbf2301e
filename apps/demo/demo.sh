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
  [regularised]='platt: the best within 0 ... 1'
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
  "$@" || return
  elapsed_s=$(jq -n "$EPOCHREALTIME - $start")
}

# render NAME WIDTH HEIGHT: linear half EXR, one ray through the middle of each pixel.
render() {
  timed povray +Istrokes.pov -D -V -J -A "+WT$(nproc)" "+W$2" "+H$3" +FE \
    "+O$1.exr" >povray.log 2>&1 || {
    cat povray.log >&2
    die "POV-Ray could not render strokes.pov at $2x$3"
  }
}

# error_of[REFERENCE METHOD LABEL]: all the numbers of the reports; one that is missing ends the script (set -u).
declare -A error_of
read_report() {
  local test label rmse
  while IFS=$'\t' read -r test label rmse; do
    error_of["$1 ${test%.exr} $label"]=$rmse
  done < <(jq -r '.results[] | [.test, .label, .scores.rmse] | @tsv' "$1.json")
}

# round NUMBER: for people.
round() { printf '%.3g' "$1"; }

# times A B: how the error A compares with the error B, in words.
times() {
  local ratio
  ratio=$(jq -n "[$1 / $2, $2 / $1] | max | if . < 10 then . * 10 | round / 10 else round end")
  if jq -en "$1 < $2" >/dev/null; then
    printf '%s times less than' "$ratio"
  else
    printf '%s times more than' "$ratio"
  fi
}

mkdir -p -- "$out"
cd -- "$out"
# POV-Ray reads blanks in a path as the end of it.
cp -- "$top"/data/scenes/{strokes,comparison}.pov .

printf 'Rendering strokes.pov with POV-Ray: 400x225, 1200x225, 4800x2700\n'
render control 400 225
declare -A render_s=([control]=$elapsed_s) filter_s=([control]=0)
render wide 1200 225
wide_s=$elapsed_s
render truth 4800 2700
# The ground truth has 12x12 samples a pixel; here averaged to the cells of a wide render, and to pixels.
"$triad" run truth.exr --cells 12x12 box:x=4,y=12 -o truth-wide.exr --depth float
"$triad" run truth.exr --cells 12x12 box:x=12,y=12 -o truth-pixels.exr --depth float
"$triad" run truth-pixels.exr -o truth-pixels.png

printf 'Making the pictures\n'
"$triad" run control.exr -o control.png
for method in "${methods[@]:1}"; do
  "$triad" run wide.exr --cells 3x1 "${stage[$method]}" -o "$method.exr" --depth float --json run.json
  render_s[$method]=$wide_s
  filter_s[$method]=$(jq '.runs[0].seconds' run.json)  # from the first read to the last rename
  # What the unbounded filter asks for has no picture of its own: clipped, it is the one above it.
  [[ $method == unbounded ]] || "$triad" run "$method.exr" -o "$method.png"
done

printf 'Judging them\n'
# As the filter sees a row: its ends meet, and no pixel is left out.
readonly judge=edge=wrap,border=0
pictures=("${methods[@]/%/.exr}")
for reference in wide truth-wide; do
  "$triad" compare "${pictures[@]}" --ref "$reference.exr" --ref-cells 3x1 \
    -m "display:$judge,range=clip@shown" -m "display:$judge,range=unbounded@asked" --json "$reference.json" >/dev/null
  read_report "$reference"
done
"$triad" compare "${pictures[@]}" --ref truth-pixels.exr -m error@plain --json truth-pixels.json >/dev/null
read_report truth-pixels

povray +Icomparison.pov -D -V -A -J +W1824 +H1096 +FN8 +Ocomparison.png >povray.log 2>&1 || {
  cat povray.log >&2
  die 'POV-Ray could not lay out comparison.png'
}
rm -f povray.log run.json strokes.pov comparison.pov

printf '\n%-31s %13s | %19s | %19s | %9s\n' '' 'seconds' 'against the wide' 'against the truth' 'RMSE, to'
printf '%-31s %6s %6s | %9s %9s | %9s %9s | %9s\n' 'error seen at 40 ppd' render filter shown unbounded shown \
  unbounded 'its pixels'
printf '%s\n' '---------------------------------------------+---------------------+---------------------+-----------'
for method in "${methods[@]}"; do
  printf '%-31s %6.3f %6.3f | %9.5f %9.5f | %9.5f %9.5f | %9.5f\n' "${title[$method]}" \
    "${render_s[$method]}" "${filter_s[$method]}" \
    "${error_of[wide $method shown]}" "${error_of[wide $method asked]}" \
    "${error_of[truth-wide $method shown]}" "${error_of[truth-wide $method asked]}" \
    "${error_of[truth-pixels $method plain]}"
done

# least REFERENCE LABEL: the method with the least error.
least() {
  local method best=control
  for method in "${methods[@]}"; do
    if jq -en "${error_of[$1 $method $2]} < ${error_of[$1 $best $2]}" >/dev/null; then
      best=$method
    fi
  done
  printf '%s' "$best"
}
best=$(least wide asked)
[[ $best == unbounded ]] ||
  die "'${title[$best]}' has a lower error than the unbounded optimum, which cannot be: something is broken"
best_shown=$(least truth-wide shown)
box_shown=${error_of[wide box shown]}
truth_box=${error_of[truth-wide box shown]}
fold -s -w 110 <<END

Judged by the picture it was made from, and allowed any light it asks for, the optimal filter errs least of \
all, as theory says it must: $(round "${error_of[wide unbounded asked]}"), \
$(times "${error_of[wide unbounded asked]}" "${error_of[wide box asked]}") the plain average of three samples \
($(round "${error_of[wide box asked]}")). A display has no light below 0 or above 1. Clipped to what it can show, the \
same filter errs $(round "${error_of[wide clipped shown]}"), \
$(times "${error_of[wide clipped shown]}" "$box_shown") the average; one sample for each subpixel errs \
$(times "${error_of[wide subpixel shown]}" "$box_shown") it, one sample for each pixel \
$(times "${error_of[wide control shown]}" "$box_shown") it, and the regularised filter, clipped too, \
$(times "${error_of[wide regularised shown]}" "$box_shown") it. Against the ground truth of 144 samples a pixel, \
where the three samples a pixel that all filters were given count as errors themselves, the average errs \
$(round "$truth_box") and the unbounded optimum $(round "${error_of[truth-wide unbounded asked]}"); of what a display \
can show, the least is $(round "${error_of[truth-wide $best_shown shown]}") ("${title[$best_shown]}").

The pictures are in $out;
comparison.png shows a part of each, enlarged.
END

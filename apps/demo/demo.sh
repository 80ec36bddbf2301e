#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# demo.sh TRIAD TOP OUT: renders four bundled scenes with Triad and data/scenes/strokes.pov with POV-Ray, makes
# pictures for a display from them in six ways, judges each against the wide render that it was made from and against
# the ground truth, and shows all in a page. What an earlier run made is used again where nothing that it comes from has changed.
set -euo pipefail
export LC_ALL=C  # numbers with a point

readonly triad=$1 top=$2 out=$3
readonly own_scenes=(high-contrast-1 high-contrast-2 high-contrast-3 high-contrast-4)
readonly scenes=("${own_scenes[@]}" strokes)
readonly renders=(control wide truth)
readonly methods=(control box subpixel clipped unbounded optimum)
declare -A title=(
  [control]='control: one sample a pixel'
  [box]='box: three samples averaged'
  [subpixel]='a sample for each subpixel'
  [clipped]='Platt 2000, clipped to 0 ... 1'
  [unbounded]='Platt 2000, unbounded'
  [optimum]='platt: the best within 0 ... 1'
)
# The filter of 2000 as its author has it: nothing but the least error, on a row whose ends meet.
readonly optimum='platt:engine=fft,lambda=0,flat-field=free,edge=wrap'
declare -A stage=(
  [box]='box:x=3'
  [subpixel]=subpixel
  [clipped]="$optimum,range=clip"
  [unbounded]="$optimum,range=unbounded"
  [optimum]=platt
)
# The two parts that comparison.png enlarges: left and upper edges in pixels, of 74 x 36 and of 74 x 27.
declare -A parts=(
  [high-contrast-1]='22,93,263,150'
  [high-contrast-2]='12,40,90,136'
  [high-contrast-3]='30,60,230,60'
  [high-contrast-4]='160,30,160,100'
  [strokes]='67,93,12,155'
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

# povray_to LOG ARGUMENT...: POV-Ray, quiet unless it fails.
povray_to() {
  local log=$1
  shift
  povray -D -V -J "+WT$(nproc)" "$@" >"$log" 2>&1 || {
    tail -n 20 -- "$log" >&2
    die "POV-Ray failed over $scene: povray $*"
  }
  rm -f -- "$log"
}

# render NAME: control.exr, wide.exr or truth.exr of $scene.
render() {
  if [[ $scene == strokes ]]; then
    # Linear half EXR, one ray through the middle of each pixel. The ground truth has 12x12 samples a pixel.
    local -A size=([control]='400 225' [wide]='1200 225' [truth]='4800 2700')
    povray_to povray.log +Istrokes.pov -A "+W${size[$1]% *}" "+H${size[$1]#* }" +FE "+O$1.exr"
    return
  fi
  # The ground truth is made of cells, with 128 samples in each.
  local -A how=(
    [control]='--strategy control'
    [wide]='--strategy control --cells 3x1'
    [truth]='--strategy sobol-owen:spp=128 --cells 3x1 --json truth.json'
  )
  # shellcheck disable=SC2086  # words without blanks of their own
  "$triad" render "$scene" -o "$1.exr" --size 400x225 ${how[$1]} >/dev/null
}

readonly program=("$triad" "${triad%/bin/*}"/lib/libtriad.so.*)

# unchanged STAMP: whether every file that it lists is as it was.
unchanged() { [[ -f $1 ]] && sha256sum --check --status -- "$1" 2>/dev/null; }

# stamp STAMP FILE...: lists the files and what is in them, by which unchanged() knows them.
stamp() {
  sha256sum -- "${@:2}" >"$1.new"
  mv -- "$1.new" "$1"
}

render_scene() {
  if unchanged renders.sha256; then
    printf '%s: the renders of an earlier run are still good\n' "$scene"
    return
  fi
  local files=("$top/apps/demo/demo.sh" "${renders[@]/%/.exr}" render-seconds.json)
  if [[ $scene == strokes ]]; then
    printf '%s: rendering with POV-Ray\n' "$scene"
    cp -- "$top/data/scenes/strokes.pov" .  # POV-Ray reads blanks in a path as the end of it
    files+=("$(command -v povray)" "$top/data/scenes/strokes.pov")
  else
    printf '%s: rendering with Triad\n' "$scene"
    files+=("${program[@]}" "$top/data/scenes/$scene.gltf" truth.json)
  fi
  rm -f -- renders.sha256
  local name seconds='{}'
  for name in "${renders[@]}"; do
    timed render "$name"
    seconds=$(jq -n "$seconds + {$name: $elapsed_s}")
  done
  printf '%s\n' "$seconds" >render-seconds.json
  stamp renders.sha256 "${files[@]}"
}

make_pictures() {
  local method seconds='{"control":0}'
  "$triad" run control.exr -o control.png
  for method in "${methods[@]:1}"; do
    "$triad" run wide.exr --cells 3x1 "${stage[$method]}" -o "$method.exr" --depth float --json run.json
    # From the first read to the last rename.
    seconds=$(jq "$seconds + {$method: .runs[0].seconds}" run.json)
    # What the unbounded filter asks for has no picture of its own: clipped, it is the one above it.
    [[ $method == unbounded ]] || "$triad" run "$method.exr" -o "$method.png"
  done
  printf '%s\n' "$seconds" >filter-seconds.json
  # The ground truth, averaged to the cells of a wide render, and to pixels.
  if [[ $scene == strokes ]]; then
    "$triad" run truth.exr --cells 12x12 box:x=4,y=12 -o truth-wide.exr --depth float
  else
    cp -- truth.exr truth-wide.exr
  fi
  "$triad" run truth-wide.exr --cells 3x1 box:x=3 -o truth-pixels.exr --depth float
  "$triad" run truth-pixels.exr -o truth-pixels.png
  rm -f -- run.json
}

judge() {
  # As the filter sees a row: its ends meet, and no pixel is left out.
  local view=edge=wrap,border=0 reference pictures=("${methods[@]/%/.exr}")
  for reference in wide truth-wide; do
    "$triad" compare "${pictures[@]}" --ref "$reference.exr" --ref-cells 3x1 \
      -m "display:$view,range=clip@shown" -m "display:$view,range=unbounded@asked" --json "$reference.json" >/dev/null
  done
  "$triad" compare "${pictures[@]}" --ref truth-pixels.exr -m error@plain --json truth-pixels.json >/dev/null
}

enlarge() {
  local at
  IFS=, read -ra at <<<"${parts[$scene]}"
  cp -- "$top/data/scenes/comparison.pov" .
  povray_to povray.log +Icomparison.pov -A +W1824 +H1096 +FN8 +Ocomparison.png "Declare=Left_1=${at[0]}" \
    "Declare=Upper_1=${at[1]}" "Declare=Left_2=${at[2]}" "Declare=Upper_2=${at[3]}"
  rm -f -- comparison.pov
}

judge_scene() {
  if unchanged results.sha256; then
    printf '%s: so are its pictures and their errors\n' "$scene"
    return
  fi
  printf '%s: filtering and judging\n' "$scene"
  rm -f -- results.sha256
  make_pictures
  judge
  enlarge
  stamp results.sha256 "$top/apps/demo/demo.sh" "$top/data/scenes/comparison.pov" "${program[@]}" \
    "${triad%/bin/*}"/plugins/*.triad.so "${renders[@]/%/.exr}" "${methods[@]/%/.exr}" ./*.png \
    {wide,truth-wide,truth-pixels,filter-seconds}.json
}

# Numbers of the scenes, by 'SCENE METHOD' or 'SCENE REFERENCE METHOD LABEL'; one that is missing ends the script
# (set -u).
declare -A render_s filter_s error_of
read_results() {
  local method reference test label value
  while IFS=$'\t' read -r method value; do
    filter_s["$scene $method"]=$value
    render_s["$scene $method"]=$(jq .wide render-seconds.json)
  done < <(jq -r 'to_entries[] | [.key, .value] | @tsv' filter-seconds.json)
  render_s["$scene control"]=$(jq .control render-seconds.json)
  for reference in wide truth-wide truth-pixels; do
    while IFS=$'\t' read -r test label value; do
      error_of["$scene $reference ${test%.exr} $label"]=$value
    done < <(jq -r '.results[] | [.test, .label, .scores.rmse] | @tsv' "$reference.json")
  done
  local best
  best=$(least wide asked)
  [[ $best == unbounded ]] || die "$scene: '${title[$best]}' has a lower error than the unbounded optimum, which \
cannot be: something is broken"
}

# least REFERENCE LABEL: the method with the least error in $scene.
least() {
  local method
  for method in "${methods[@]}"; do
    printf '%s %s\n' "${error_of[$scene $1 $method $2]}" "$method"
  done | sort -g | sed -n '1s/.* //p'
}

for scene in "${scenes[@]}"; do
  mkdir -p -- "$out/$scene"
  cd -- "$out/$scene"
  render_scene
  judge_scene
  read_results
done

# All scenes' pictures beside their ground truths, as a page.
cd -- "$out"
for scene in "${scenes[@]}"; do
  jq --arg folder "$scene/" '.results[] | .test = $folder + .test | .reference = $folder + .reference' \
    "$scene/truth-wide.json"
done | jq -s '{results: .}' >report.json
"$triad" report report.json -o report.html --ref-cells 3x1 >/dev/null
rm -f -- report.json

about() {
  if [[ $scene == strokes ]]; then
    printf 'bright strokes, thin lines, shapes and letters; rendered by POV-Ray'
  else
    "$triad" list scenes --json | jq -j --arg name "$scene" '.scenes[] | select(.id == $name) | .summary'
  fi
}

printf '\n%-31s %13s | %17s | %17s | %8s\n' '' 'seconds' 'against the wide' 'against the truth' 'RMSE, to'
printf '%-31s %6s %6s | %7s %9s | %7s %9s | %8s\n' 'error seen at 40 ppd' render filter shown unbounded shown \
  unbounded 'pixels'
for scene in "${scenes[@]}"; do
  printf '%s\n' '---------------------------------------------+-------------------+-------------------+---------'
  printf '%s: %s\n' "$scene" "$(about)" | fold -s -w 100
  for method in "${methods[@]}"; do
    printf ' %-30s %6.3f %6.3f | %7.5f %9.5f | %7.5f %9.5f | %8.5f\n' "${title[$method]}" \
      "${render_s[$scene $method]}" "${filter_s[$scene $method]}" \
      "${error_of[$scene wide $method shown]}" "${error_of[$scene wide $method asked]}" \
      "${error_of[$scene truth-wide $method shown]}" "${error_of[$scene truth-wide $method asked]}" \
      "${error_of[$scene truth-pixels $method plain]}"
  done
done

# times REFERENCE METHOD LABEL: the least and the greatest ratio, over the scenes, of a method's error to that of
# the plain average as it is shown.
times() {
  for scene in "${scenes[@]}"; do
    printf '%s %s\n' "${error_of[$scene $1 $2 $3]}" "${error_of[$scene $1 box shown]}"
  done | awk '{ print $1 / $2 }' | sort -g | sed -n '1p;$p' | xargs printf '%.2g to %.2g'
}
truths=()
for scene in "${own_scenes[@]}"; do
  truths+=("$out/$scene/truth.json")
done
fold -s -w 100 <<END

All errors below are multiples of that of the plain average of three samples, from the scene where they are least \
to the one where they are greatest. Judged by the picture it was made from, and allowed any light it asks for, the \
optimal filter errs least of all, as theory says it must: $(times wide unbounded asked). A display has no light \
below 0 or above 1. Clipped to what it can show, the same filter errs $(times wide clipped shown); one sample for \
each subpixel errs $(times wide subpixel shown), one sample for each pixel $(times wide control shown), and the \
displayable optimum, platt by default, $(times wide optimum shown). Against the ground truth, where the three samples \
a pixel that all filters were given count as errors themselves, the clipped optimum errs \
$(times truth-wide clipped shown), one sample for each subpixel $(times truth-wide subpixel shown), one for each \
pixel $(times truth-wide control shown) and the displayable optimum $(times truth-wide optimum shown). Triad's \
ground truths have estimated errors of their own of at most \
$(jq -s 'map(.rmse) | max' "${truths[@]}" | xargs printf '%.2g') (RMSE of a cell).

The pictures are in $out;
each scene's comparison.png shows two parts of them, enlarged.
All of them side by side, as a panel's emitters and as an eye sees them, in any browser:
$out/report.html
END

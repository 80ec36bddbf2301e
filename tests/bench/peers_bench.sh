#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The diffuse Cornell box at 400 x 400 on two threads: seconds to the same error, beside Blender's Cycles with global
# light and with direct light only, and beside POV-Ray with direct light only. Geometry, lamp, materials and camera
# come from the same file for each; a renderer that is not installed is left out.
#
#   peers_bench.sh TRIAD [RUNS] [REFERENCE_SPP] [SCENE]
#
# Errors are RMSE over linear pixels against the same renderer's own picture of REFERENCE_SPP samples, over the whole
# picture (where the lamp's rim, 15 times as bright as white, decides) and without the rows that the lamp is in.
# Seconds are what each says that drawing took, without its start, reading, preparing and writing: triad render
# --json, Cycles' "Render time (without synchronization)", POV-Ray's "Trace Time".
set -euo pipefail
triad=$(realpath -- "${1:?name the triad program}")
runs=${2:-3}
reference_spp=${3:-1024}
here=$(cd -- "$(dirname -- "$0")" && pwd)
scene=$(realpath -- "${4:-$here/../../data/scenes/cornell.gltf}")
size=400 bounces=8
below_lamp=0,60,$size,$((size - 60)) # the lamp ends in row 55
# Where samples lie: as many in each pixel, and for direct light, where the lamp's rim is most of the error, more of
# them where the halves of a pixel's samples differ.
uniform=sobol-owen:spp=64
adaptive_common=batch=0,power=0,spp=1024
adaptive=(threshold=.3,least=8 threshold=.2,least=8 threshold=.15,least=8 threshold=.1,least=8 threshold=.1,least=16
  threshold=.05,least=16)
cycles_spp=(4 8 16 32 64 128)
# POV-Ray: spotlights along each side of the lamp, and the depth of its adaptive subdivision of pixels. That serves it
# best: the same error by jittered lights and as many samples in each pixel takes it ten times as long.
povray_parts=(2 3 4) povray_depths=(3 4 5 6)
threshold=0.3

source "$here/bench.bash"
need peers_bench python3 jq
cd -- "$folder"

# draw_triad CONTEST STRATEGY SEED OUT: seconds.
draw_triad() {
  local what=(--bounces "$bounces")
  [[ $1 == global ]] || what=(--effects area-light)
  quiet "$triad" render "$scene" -o "$4" --size "${size}x$size" --strategy "$2" --seed "$3" --threads 2 "${what[@]}" \
    --json facts.json
  jq -r .seconds.render facts.json
}

# draw_cycles CONTEST SEED OUT=SPP...: seconds, a line for each.
draw_cycles() {
  local depth=$bounces
  [[ $1 == global ]] || depth=0
  quiet blender -b --factory-startup --python-exit-code 3 --debug-cycles -P "$here/peers_scene.py" -- \
    "$scene" "$2" "$depth" "$size" "${@:3}"
  sed -n 's/.*Render time (without synchronization): //p' log.txt
}

# draw_povray PARTS THRESHOLD DEPTH OUT: seconds.
draw_povray() {
  quiet povray +Ibox.pov "Declare=Parts=$1" -D -GD -GR -GF -GW +WT2 "+W$size" "+H$size" "+A$2" +AM2 "+R$3" -J +FE "+O$4"
  sed -n 's/.*Trace Time:.*(\([0-9.]*\) seconds).*/\1/p' log.txt | head -n 1
}

rmse() { "$triad" compare "$@" -m error --json - | jq -r '.results[0].scores.rmse'; }

# record CONTEST RENDERER FAMILY SETTING SECONDS OUT REFERENCE
record() {
  local whole below
  whole=$(rmse "$6" --ref "$7")
  below=$(rmse "$6" --ref "$7" --crop "$below_lamp")
  printf '%s\t%s\t%s\t%s\t%s\t%s\t%s\t%s\n' "$1" "$2" "$3" "$4" "$run" "$5" "$whole" "$below" >>records.tsv
}

# blocks OUT: the means of 20 x 20 squares as EXR, where noise is small and pixels' edges do not matter.
blocks() { quiet "$triad" run "$1" box:x=20,y=20 -o "blocks-$1" --compression none --depth float; }

have_cycles=false have_povray=false
if command -v blender >/dev/null; then have_cycles=true; else echo 'blender is not installed: Cycles is left out'; fi
if command -v povray >/dev/null; then have_povray=true; else echo 'povray is not installed: it is left out'; fi

# References, of a seed that no other picture has.
for contest in global direct; do
  draw_triad "$contest" "sobol-owen:spp=$reference_spp" 1000 "triad-$contest-reference.exr" >/dev/null
  blocks "triad-$contest-reference.exr"
  if $have_cycles; then
    draw_cycles "$contest" 1000 "$PWD/cycles-$contest-reference.exr=$reference_spp" >/dev/null
    blocks "cycles-$contest-reference.exr"
  fi
done
if $have_povray; then
  quiet python3 "$here/peers_scene.py" povray "$scene" box.pov
  draw_povray 8 0.03 7 povray-direct-reference.exr >/dev/null
  blocks povray-direct-reference.exr
fi

for ((run = 1; run <= runs; ++run)); do
  for contest in global direct; do
    seconds=$(draw_triad "$contest" "$uniform" "$run" out.exr)
    record "$contest" triad "${uniform%=*}" "${uniform##*=}" "$seconds" out.exr "triad-$contest-reference.exr"
    if [[ $contest == direct ]]; then
      for settings in "${adaptive[@]}"; do
        seconds=$(draw_triad direct "variance:$settings,$adaptive_common" "$run" out.exr)
        record direct triad "variance:${settings%=*}" "${settings##*=}" "$seconds" out.exr triad-direct-reference.exr
      done
    fi
    $have_cycles || continue
    outputs=()
    for spp in "${cycles_spp[@]}"; do outputs+=("$PWD/cycles-$spp.exr=$spp"); done
    draw_cycles "$contest" "$run" "${outputs[@]}" >seconds.txt
    for spp in "${cycles_spp[@]}"; do
      read -r seconds <&3
      record "$contest" Cycles spp "$spp" "$seconds" "cycles-$spp.exr" "cycles-$contest-reference.exr"
    done 3<seconds.txt
  done
  $have_povray || continue
  for parts in "${povray_parts[@]}"; do
    for depth in "${povray_depths[@]}"; do
      seconds=$(draw_povray "$parts" "$threshold" "$depth" out.exr)
      record direct POV-Ray "lights=${parts}x$parts,depth" "$depth" "$seconds" out.exr povray-direct-reference.exr
    done
  done
done
printf 'variance: with %s in each\n' "$adaptive_common"
python3 "$here/peers_table.py" records.tsv .

#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Structural similarity of two PNG files on two threads, file to score, beside other programs on the same files, run in
# turns: scikit-image's structural_similarity, the same formula out of OpenCV's GaussianBlur in float32, and
# ImageMagick 7's compare -metric SSIM. What is not installed is left out. Prints each one's score and median seconds.
#
#   ssim_peers_bench.sh TRIAD [RUNS] [SIZE...]
#
# scikit-image and OpenCV are timed from within Python, reading included, its own start left out; Triad's seconds
# include its start. OpenCV's blur reads the edge mirrored, so that its mean over all but 5 pixels is the same score.
set -euo pipefail
triad=$(realpath -- "${1:?name the triad program}")
runs=${2:-5}
sizes=("${@:3}")
((${#sizes[@]})) || sizes=(1920x1080 3840x2160)
here=$(cd -- "$(dirname -- "$0")" && pwd)
source "$here/bench.bash"
python=/usr/bin/python3 # the one that Debian's packages belong to
need ssim_peers_bench "$python" vips
cd -- "$folder"

cat >peer.py <<'END'
import sys, time
name, test, reference = sys.argv[1:]
import numpy as np
if name == "opencv":
    import cv2
    cv2.setNumThreads(2)
    read = lambda path: cv2.imread(path, cv2.IMREAD_COLOR).astype(np.float32) / 255
    blur = lambda v: cv2.GaussianBlur(v, (11, 11), 1.5, borderType=cv2.BORDER_REFLECT)
    def score(x, y):
        mx, my = blur(x), blur(y)
        vx, vy, c = blur(x * x) - mx * mx, blur(y * y) - my * my, blur(x * y) - mx * my
        s = (2 * mx * my + 1e-4) * (2 * c + 9e-4) / ((mx * mx + my * my + 1e-4) * (vx + vy + 9e-4))
        return s[5:-5, 5:-5].mean(dtype=np.float64)
else:
    import imageio
    from skimage.metrics import structural_similarity
    read = lambda path: imageio.imread(path)[..., :3].astype(np.float32) / 255
    def score(x, y):
        return structural_similarity(x, y, channel_axis=2, gaussian_weights=True, sigma=1.5,
                                     use_sample_covariance=False, data_range=1)
start = time.perf_counter()
value = score(read(test), read(reference))
print(f"{value:.6f} {time.perf_counter() - start:.4f}")
END

# Each prints its score and its seconds.
run_triad() {
  local start end score
  start=$(date +%s%N)
  score=$("$triad" compare test.png --ref reference.png -m ssim --threads 2 --csv - | tail -n 1)
  end=$(date +%s%N)
  awk -v line="$score" -v ns=$((end - start)) 'BEGIN { split(line, f, ","); printf "%.6f %.4f\n", f[6], ns / 1e9 }'
}
run_magick() {
  local start end score
  start=$(date +%s%N)
  score=$(magick -limit thread 2 compare -metric SSIM test.png reference.png null: 2>&1 || true)
  end=$(date +%s%N)
  awk -v s="$score" -v ns=$((end - start)) 'BEGIN { printf "%.6f %.4f\n", s, ns / 1e9 }'
}
run_scikit-image() { "$python" peer.py scikit-image test.png reference.png; }
run_opencv() { "$python" peer.py opencv test.png reference.png; }

programs=(triad)
"$python" -c 'import skimage, imageio' 2>/dev/null && programs+=(scikit-image)
"$python" -c 'import cv2' 2>/dev/null && programs+=(opencv)
command -v magick >/dev/null && programs+=(magick)

for size in "${sizes[@]}"; do
  for picture in test reference; do
    for band in 1 2 3; do
      vips perlin "band$band.v" "${size%x*}" "${size#*x}" --cell-size 64 --seed "$band"
      vips gaussnoise noise.v "${size%x*}" "${size#*x}" --sigma "$([[ $picture == test ]] && echo 6 || echo 2)" \
        --mean 0 --seed "$band"
      vips linear "band$band.v" scaled.v 100 128
      vips add scaled.v noise.v "channel$band.v"
    done
    vips bandjoin 'channel1.v channel2.v channel3.v' joined.v
    vips cast joined.v "$picture.png[compression=1]" uchar
  done
  rm -f times.*
  for program in "${programs[@]}"; do "run_$program" >/dev/null; done # once before the clock counts
  for ((i = 0; i < runs; ++i)); do
    for program in "${programs[@]}"; do "run_$program" >>"times.$program"; done
  done
  printf '%s RGB, 8 bits, two threads, median of %s runs in turns:\n' "$size" "$runs"
  for program in "${programs[@]}"; do
    sort -k 2 -n "times.$program" | awk -v name="$program" \
      '{ score = $1; s[NR] = $2 } END { printf "  %-14s ssim %.6f  %7.3f s\n", name, score, s[int((NR + 1) / 2)] }'
  done
done

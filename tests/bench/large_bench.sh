#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Peak memory of comparisons of very large pictures: 16384 pixels wide and 4096 or 16384 high, 8-bit TIFF, by FLIP with
# exact percentiles and by the other metrics that stream. Takes some 2 GB of the temporary folder.
#
#   large_bench.sh TRIAD
set -euo pipefail
source "$(dirname -- "${BASH_SOURCE[0]}")/bench.bash"
triad=$(realpath -- "${1:?name the triad program}")
need large_bench vips /usr/bin/time
cd -- "$folder"
export TMPDIR=$folder

# noise HEIGHT SEED FILE
noise() {
  local band
  for band in 1 2 3; do vips gaussnoise "band$band.v" 16384 "$1" --mean 128 --sigma 40 --seed $((band + $2)); done
  vips bandjoin 'band1.v band2.v band3.v' rgb.v
  vips cast rgb.v codes.v uchar
  vips copy codes.v "$3" --interpretation srgb
  rm -f -- *.v
}

printf '%-12s %-28s %10s %9s\n' size metric 'peak, MB' seconds
for height in 4096 16384; do
  noise "$height" 10 test.tif
  noise "$height" 20 reference.tif
  for metric in flip flip:mode=hdr,start=-2,stop=2,count=3 ssim ms-ssim ciede2000 relmse-tev error; do
    /usr/bin/time -f '%M %e' -o measured "$triad" compare test.tif --ref reference.tif -m "$metric" --pool p95 >/dev/null
    printf '%-12s %-28s %10d %9.1f\n' "16384x$height" "${metric%%,*}" \
      $(awk '{ print int($1 / 1024), $2 }' measured)
  done
done

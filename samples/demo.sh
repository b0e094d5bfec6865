#!/bin/sh
# SPDX-License-Identifier: MIT
# From a fresh clone to a picture: installs what is needed, builds, converts the bundled part and
# renders it.
set -eu
cd "$(dirname "$0")/.."
samples/install.sh

cmake --preset release
cmake --build --preset release

mkdir -p build/demo
phongsplat=build/release/phongsplat
$phongsplat convert samples/models/part.obj build/demo/part.glb --tolerance 0.2% \
    --report build/demo/part.json --overwrite --quiet
$phongsplat render build/demo/part.glb build/demo/part.png --overwrite \
    --azimuth 55 --elevation 33 --distance 0.95

# field NAME prints the field's value in the report, rounded NAME the same with three digits.
field() {
    sed -n "s/^ *\"$1\": \(.*[^,]\),*\$/\1/p" build/demo/part.json
}
rounded() {
    printf '%.3g' "$(field "$1")"
}
echo
echo "samples/models/part.obj, $(field triangles) triangles, became build/demo/part.glb:"
echo "  $(field splats) splats, by number of clip lines $(field splats_by_clip_lines), $(field bytes) bytes, $(rounded seconds) s"
echo "  greatest distance $(rounded max_distance_percent) % of the diagonal (tolerance $(field tolerance_percent) %)"
echo "  normals off by $(rounded rms_normal_degrees) degrees (root mean square), $(field uncovered_samples) samples uncovered"
echo "All figures: build/demo/part.json. The picture: $PWD/build/demo/part.png"
echo "In a window: $phongsplat view build/demo/part.glb"

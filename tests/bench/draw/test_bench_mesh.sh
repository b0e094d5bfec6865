# SPDX-License-Identifier: MIT
# Tests the benchmarks that draw a mesh, too: they print a row for each draw method, and phong splats of a smooth model come
# nearer to the mesh's image than the other modes do, so that lights, cameras and materials must agree.
. "$SOURCE_DIR/tests/support/cli.sh"
torus=$SOURCE_DIR/samples/models/torus.off
run "$PHONGSPLAT" convert "$torus" torus.glb -t 2
expect_success

run "$BENCH_DRAW" --mesh "$torus" --size 64 --mode phong --frames 1 --warm-up 0 torus.glb
expect_success
for who in ours "lower bound" sprites mesh; do expect_output "torus.glb .* phong \| $who \|"; done

# A stand-in for gltfpack, which keeps the mesh: its pictures are no worse than those of splats at any ratio, so that it is asked
# for fewer triangles down to a thousandth. What it does with the file says that it was asked in gltfpack's own words.
tiled=$SOURCE_DIR/samples/models/tiled.glb
cat >gltfpack <<EOF
#!/bin/sh
[ "\$1" = -v ] && echo "stand-in 1" && exit
[ "\$1 \$3 \$5 \$6 \$7 \$8" = "-i -o -sv -se 1 -si" ] && echo "\$9" >>ratios.txt && cp "$tiled" "\$4"
EOF
chmod +x gltfpack
run "$PHONGSPLAT" convert "$tiled" tiled.glb -t 4
expect_code '[09]' # 9: so large splats cannot keep its texture in place, which does not matter here
run "$BENCH_DRAW" --mesh "$tiled" --gltfpack ./gltfpack --size 64 --mode phong --frames 1 --warm-up 0 tiled.glb
expect_code 0
for who in ours mesh gltfpack; do expect_output "tiled.glb .* phong \| $who \|"; done
grep -Eq '^gltfpack: ([0-9]+) of \1 triangles, picture error 0\.[0-9]+ %, splats [1-9]' stderr.txt || fail "the simplified mesh: $(cat stderr.txt)"
[ "$(head -n 1 ratios.txt)" = 1 ] || fail "ratios: $(cat ratios.txt)"
awk 'END { if (!($1 < 0.00105)) exit 1 }' ratios.txt || fail "the last ratio: $(cat ratios.txt)"
run "$BENCH_DRAW" --mesh "$tiled" --gltfpack ./absent tiled.glb
expect_code 1
grep -q 'absent: cannot be run' stderr.txt || fail "an absent program: $(cat stderr.txt)"
run "$BENCH_DRAW" --gltfpack ./gltfpack tiled.glb
expect_code 2

run "$BENCH_QUALITY" --size 256 --frames 1 "$torus" torus.glb
expect_success
expect_output '^\| torus.glb \|'
# The errors inside the outline were measured as 4.4, 8.7 and 11.5 %. A wrong light or normal gives phong 6 %.
sed -n 's/^| torus.glb .*(\(.*\)) .*(\(.*\)) .*(\(.*\)) .*/\1 \2 \3/p' stdout.txt >errors.txt
awk '{ if (NF != 3 || !($1 < 6 && $1 * 1.5 < $2 && $2 < $3)) exit 1 }' errors.txt ||
    fail "errors of phong, gaussian, flat: $(cat errors.txt)"
echo "$checks checks"

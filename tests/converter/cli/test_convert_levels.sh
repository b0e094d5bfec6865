# SPDX-License-Identifier: MIT
# test_convert_levels.sh - tests levels of detail on the command line: convert writes them, inspect lists them, render draws
# one.
. "$SOURCE_DIR/tests/support/cli.sh"

run "$PHONGSPLAT" convert "$SOURCE_DIR/samples/models/torus.off" torus.glb -t 1.2 --effort 0 --levels 5%
expect_success
expect_output '^torus.glb: level 1: [0-9]+ splats, tolerance 5 %, distance 5 %, rms normal [0-9.]+ degrees, outline [0-9.]+ %$'
run "$PHONGSPLAT" inspect torus.glb
expect_success
expect_output '^level of detail +splats +distance +normals +outline$'
expect_output '^1 +[0-9]+ +[0-9.]+ +[0-9.]+.* +[0-9.]+$'
run "$PHONGSPLAT" inspect torus.glb --format json
node -e 'const { levels } = JSON.parse(require("fs").readFileSync("stdout.txt"));
    if (levels.length != 2 || levels[0].splats <= levels[1].splats || levels[0].distance >= levels[1].distance) process.exit(1)' || fail "levels"
for level in 0 1 2; do
    run "$PHONGSPLAT" render torus.glb $level.png --size 40x40 --level $level
    expect_success
done
cmp 1.png 2.png || fail "the coarsest level does not stand for those beyond it"
if cmp -s 0.png 1.png; then fail "a coarser level is drawn as the finest"; fi

# Six faces take six splats at any tolerance.
write_cube cube.obj
run "$PHONGSPLAT" convert cube.obj plain.glb -t 2
run "$PHONGSPLAT" convert cube.obj cube.glb -t 2 --levels 4
expect_success
expect_output '^cube.glb: no coarser level has at most four fifths of the splats$'
cmp plain.glb cube.glb || fail "levels change a file that has none"

for wrong in 1 17 x 21% 1%,1% 2%,1%; do
    run "$PHONGSPLAT" convert cube.obj wrong.glb --levels $wrong
    expect_error 1 "levels"
done
run "$PHONGSPLAT" convert cube.obj wrong.glb --levels 3 --bytes 9000
expect_error 1 "not together with bytes"
run "$PHONGSPLAT" convert cube.obj wrong.glb --level-textures bake
expect_error 1 "only together with levels"

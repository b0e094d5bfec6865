# SPDX-License-Identifier: MIT
# render: sizes, backgrounds and modes of the PNGs it writes.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out
write_cube cube.obj
run "$PHONGSPLAT" convert cube.obj cube.glb -t 2
expect_success

# draw OPTIONS...: renders and leaves width, height, channels, and the RGBA of corner and centre in
# the variable picture.
draw() {
    run "$PHONGSPLAT" render cube.glb out/x.png -w --software "$@"
    expect_success
    picture=$(node - out/x.png <<'JS'
const p = require(process.env.SOURCE_DIR + '/tests/support/png.js')(process.argv[2]);
console.log(p.width, p.height, p.channels, p.at(0, 0).join(), p.at(p.width >> 1, p.height >> 1).join());
JS
)
}

draw --size 64x48
case "$picture" in '64 48 3 255,255,255 '*) ;; *) fail "white background: $picture" ;; esac
white=${picture##* }
[ "$white" != 255,255,255 ] || fail "nothing was drawn"
draw --size 31x47 --background 102030 --supersample 1
case "$picture" in '31 47 3 16,32,48 '*) ;; *) fail "coloured background: $picture" ;; esac
draw --size 64x48 --background=1,2,3
case "$picture" in '64 48 3 1,2,3 '*) ;; *) fail "coloured background: $picture" ;; esac

# Transparent: alpha 0 in the corner, 1 in the middle, where the colour is that over white.
draw --size 64x48 --background transparent
[ "$picture" = "64 48 4 0,0,0,0 $white,255" ] || fail "transparent background: $picture, $white"

# Straight on, the cube's faces are flat: every mode shades them alike.
for mode in phong gaussian flat; do
    draw --size 64x64 --azimuth 0 --elevation 0 --mode $mode
    [ "${front:=$picture}" = "$picture" ] || fail "$mode: $picture instead of $front"
done
# The debug views show what they say: the normal of that face is (0, 0, 1), its colour that of a mesh without any, 0.8; one splat covers it.
for shown in normal=128,128,255 unlit=231,231,231 overdraw=0,0,128; do
    draw --size 64x64 --azimuth 0 --elevation 0 --shading "${shown%%=*}"
    [ "${picture##* }" = "${shown#*=}" ] || fail "$shown: $picture"
done
# From above, the light meets the top at the same angle; from the side below it does not matter
# which way is around: 360 degrees more are the same picture.
draw --size 64x64 --azimuth 360 --elevation 0
[ "$front" = "$picture" ] || fail "a full turn: $picture instead of $front"

# Far away the cube is small: the middle is drawn, a quarter of the way out is not.
draw --size 64x64 --distance 8
[ "${picture##* }" != 255,255,255 ] || fail "distance 8: nothing was drawn"

# Large pictures are drawn in tiles of 3072 samples, here two, on either side of x = 384 or y = 384. Against
# a single tile of fewer samples only edges may differ, by the steps of the average (1/8 and 1/7 of the contrast).
for size in 400x60 60x400; do
    draw --size $size --distance 0.2 --supersample 7
    mv out/x.png out/single.png
    draw --size $size --distance 0.2 --supersample 8
    node - out/single.png out/x.png <<'JS' || fail "tiles do not make the whole picture"
const [a, b] = process.argv.slice(2).map(require(process.env.SOURCE_DIR + '/tests/support/png.js'));
let edges = 0, colours = new Set();
for (let y = 0; y < a.height; ++y)
    for (let x = 0; x < a.width; ++x) {
        const off = Math.max(...a.at(x, y).map((v, i) => Math.abs(v - b.at(x, y)[i])));
        if (off > 255 / 4) throw Error(`${x}, ${y}: ${a.at(x, y)} and ${b.at(x, y)}`);
        edges += off > 2;
        colours.add(b.at(x, y).join());
    }
if (edges > 0.03 * a.width * a.height) throw Error(edges + ' pixels differ');
if (colours.size < 3) throw Error('there is nothing to see');
JS
done
rm out/single.png

# No graphics: one line, whatever the driver has to say.
for setting in __EGL_VENDOR_LIBRARY_FILENAMES LIBGL_DRIVERS_PATH; do
    run env $setting=/nonexistent "$PHONGSPLAT" render cube.glb out/none.png --software
    expect_error 6 'cube.glb: EGL '
    expect_files x.png
done

run "$PHONGSPLAT" render cube.glb - --size 16x16 --software
[ "$(head -c 4 stdout.txt | tail -c 3)" = PNG ] || fail "standard output is not a PNG"
echo "$checks checks passed"

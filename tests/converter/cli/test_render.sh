# SPDX-License-Identifier: MIT
# test_render.sh - tests of render: sizes, backgrounds and modes of its PNGs.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out
write_cube cube.obj
run "$PHONGSPLAT" convert cube.obj cube.glb -t 2
expect_success

# draw OPTIONS...: renders, and stores width, height, channels and the RGBA of the corner and of the
# centre in the variable picture.
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

# With a transparent background, alpha is 0 in the corner and 1 in the middle, whose colour is that
# over white.
draw --size 64x48 --background transparent
[ "$picture" = "64 48 4 0,0,0,0 $white,255" ] || fail "transparent background: $picture, $white"

# Seen straight on, the cube's face is flat, so that every mode shades it alike.
for mode in phong gaussian flat; do
    draw --size 64x64 --azimuth 0 --elevation 0 --mode $mode
    [ "${front:=$picture}" = "$picture" ] || fail "$mode: $picture instead of $front"
done
# The debug views show values of that face: its normal (0, 0, 1), its colour 0.8, which is that of a
# mesh without any, and one splat on each pixel.
for shown in normal=128,128,255 unlit=231,231,231 overdraw=0,0,128; do
    draw --size 64x64 --azimuth 0 --elevation 0 --shading "${shown%%=*}"
    [ "${picture##* }" = "${shown#*=}" ] || fail "$shown: $picture"
done
# An azimuth of 360 degrees gives the same picture as 0.
draw --size 64x64 --azimuth 360 --elevation 0
[ "$front" = "$picture" ] || fail "a full turn: $picture instead of $front"

# From far away the cube is small: the centre shows it, and a quarter of the way out does not.
draw --size 64x64 --distance 8
[ "${picture##* }" != 255,255,255 ] || fail "distance 8: nothing was drawn"

# Large pictures are drawn in tiles of 3072 samples, here two, on either side of x = 384 or y = 384.
# A single tile of fewer samples may differ only at edges, by the steps of the average (1/8 and 1/7
# of the contrast).
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

# A mesh is drawn as triangles, in any format: its picture is that of its splats but for edges.
draw --size 64x48
mv out/x.png out/splats.png
run "$PHONGSPLAT" render cube.obj out/mesh.png --size 64x48 --software
expect_success
node - out/splats.png out/mesh.png <<'JS' || fail "the mesh is not drawn as its splats are"
const [a, b] = process.argv.slice(2).map(require(process.env.SOURCE_DIR + '/tests/support/png.js'));
let edges = 0, shown = 0;
for (let y = 0; y < a.height; ++y)
    for (let x = 0; x < a.width; ++x) {
        const off = Math.max(...a.at(x, y).map((v, i) => Math.abs(v - b.at(x, y)[i])));
        edges += off > 2;
        shown += b.at(x, y).join() !== '255,255,255';
    }
if (shown < 500) throw Error('there is nothing to see');
if (edges > 0.1 * shown) throw Error(`${edges} of ${shown} pixels differ`);
JS
for model in still-life.glb scan.xyz; do
    run "$PHONGSPLAT" render "$SOURCE_DIR/samples/models/$model" out/mesh.png -w --size 64x48 --software --background 000000
    expect_success
    node -e 'const p = require(process.env.SOURCE_DIR + "/tests/support/png.js")("out/mesh.png"); let shown = 0;
        for (let i = 0; i < 3072; ++i) shown += Math.max(...p.at(i % 64, i >> 6)) > 0;
        if (shown < 200) throw Error(shown + " pixels")' || fail "$model: nothing to see"
done
for option in '--shading normal' '--mode flat' --shadows --no-filter '--time 1' '--animation 0'; do
    run "$PHONGSPLAT" render cube.obj out/none.png $option --software
    expect_error 1 'is for splats, not for a mesh'
done
echo 'f 1 2' >bad.obj
run "$PHONGSPLAT" render bad.obj out/none.png --software
expect_error 3 'bad.obj: line 1'
mv out/splats.png out/x.png
rm out/mesh.png

# Poses of an animation, by index and by name: the ball is up after half a second of `bounce`, so that where it lay there is
# the background, and back at the end and after it. The camera is the same at all times.
run "$PHONGSPLAT" convert "$SOURCE_DIR/samples/models/clockwork.glb" clockwork.glb -t 2 --effort 0 --no-creases -q
expect_success
for pose in '--animation bounce' '--animation 1 --time 0.5' '--animation bounce --time 1' '--animation 1 --time 77' '--time 0.25' '--animation tick --time 0.25'; do
    run "$PHONGSPLAT" render clockwork.glb out/pose.png -w --software --size 160x120 $pose
    expect_success
    mv out/pose.png "pose$(echo "$pose" | tr -d ' ')".png
done
cmp pose--animationbounce.png pose--animationbounce--time1.png || fail "a bounce does not end where it begins"
cmp pose--animationbounce.png pose--animation1--time77.png || fail "after its end an animation does not stand still"
cmp pose--time0.25.png pose--animationtick--time0.25.png || fail "the first animation is not the default"
! cmp -s pose--animationbounce.png pose--animation1--time0.5.png || fail "nothing moves"
node - <<'JS' || fail "the stand moves, or the ball does not"
const read = name => require(process.env.SOURCE_DIR + '/tests/support/png.js')(name);
const low = read('pose--animationbounce.png'), high = read('pose--animation1--time0.5.png');
const red = ([r, g, b]) => r > 1.5 * b, rows = p => { let sum = 0, n = 0, left = [];
    for (let i = 0; i < 19200; ++i) if (red(p.at(i % 160, i / 160 | 0))) i % 160 < 75 ? left.push(i) : (sum += i / 160 | 0, ++n);
    return { middle: sum / n, left }; };
const a = rows(low), b = rows(high);
if (!(a.middle - b.middle > 15)) throw Error(`${a.middle} ${b.middle}`);
if (!a.left.length || a.left.join() !== b.left.join()) throw Error('the bob has moved');
JS
for pose in '--animation fall' '--animation 3' '--animation -1' '--animation 1x' '--animation ='; do
    run "$PHONGSPLAT" render clockwork.glb out/none.png --software $pose
    expect_error 1 'animation: the file has no such animation'
done
run "$PHONGSPLAT" render cube.glb out/none.png --software --time 0
expect_error 1 'time: the file has no such animation'
run "$PHONGSPLAT" render clockwork.glb out/none.png --software --time nan
expect_error 1 'time'

# Without graphics there is one line of error, whatever the driver prints.
for setting in __EGL_VENDOR_LIBRARY_FILENAMES LIBGL_DRIVERS_PATH; do
    run env $setting=/nonexistent "$PHONGSPLAT" render cube.glb out/none.png --software
    expect_error 6 'cube.glb: EGL '
    expect_files x.png
done

run "$PHONGSPLAT" render cube.glb - --size 16x16 --software
[ "$(head -c 4 stdout.txt | tail -c 3)" = PNG ] || fail "standard output is not a PNG"
echo "$checks checks passed"

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
const zlib = require('zlib'), png = require('fs').readFileSync(process.argv[2]);
let data = [], header;
for (let i = 8; i < png.length;) {
    const size = png.readUInt32BE(i), type = png.toString('latin1', i + 4, i + 8), body = png.subarray(i + 8, i + 8 + size);
    if (type === 'IHDR') header = body;
    if (type === 'IDAT') data.push(body);
    i += size + 12;
}
const w = header.readUInt32BE(0), h = header.readUInt32BE(4), n = header[9] === 6 ? 4 : 3;
const raw = zlib.inflateSync(Buffer.concat(data)), stride = w * n, rows = [];
for (let y = 0; y < h; ++y) {
    const filter = raw[y * (stride + 1)], row = raw.subarray(y * (stride + 1) + 1, (y + 1) * (stride + 1));
    const up = rows[y - 1] || Buffer.alloc(stride);
    for (let i = 0; i < stride; ++i) {
        const a = i < n ? 0 : row[i - n], b = up[i], c = i < n ? 0 : up[i - n];
        const p = a + b - c, pa = Math.abs(p - a), pb = Math.abs(p - b), pc = Math.abs(p - c);
        const paeth = pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
        row[i] += [0, a, b, (a + b) >> 1, paeth][filter];
    }
    rows.push(row);
}
const at = (x, y) => [...rows[y].subarray(x * n, x * n + n)].join(',');
console.log(w, h, n, at(0, 0), at(w >> 1, h >> 1));
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
# From above, the light meets the top at the same angle; from the side below it does not matter
# which way is around: 360 degrees more are the same picture.
draw --size 64x64 --azimuth 360 --elevation 0
[ "$front" = "$picture" ] || fail "a full turn: $picture instead of $front"

# Far away the cube is small: the middle is drawn, a quarter of the way out is not.
draw --size 64x64 --distance 8
[ "${picture##* }" != 255,255,255 ] || fail "distance 8: nothing was drawn"

run "$PHONGSPLAT" render cube.glb - --size 16x16 --software
[ "$(head -c 4 stdout.txt | tail -c 3)" = PNG ] || fail "standard output is not a PNG"
echo "$checks checks passed"

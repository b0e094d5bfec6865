# SPDX-License-Identifier: MIT
# test_render_tiles.sh - tests of render with a tileset: a cube, and two smaller ones that take its place.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out tiles
write_cube cube.obj
# part NAME SIZE X: writes the cube with half sides of SIZE and its middle at X.
part() {
    awk -v size="$2" -v x="$3" '$1 == "v" { print "v", size * (2 * $2 - 1) + x, size * (2 * $3 - 1), size * (2 * $4 - 1); next } { print }' cube.obj >part.obj
    run "$PHONGSPLAT" convert part.obj "tiles/$1.glb" -t 2 --effort 0
    expect_success
}
# The children are smaller and set apart, so that pictures tell which tiles are drawn.
part whole 1 0
part half1 0.3 0.7
part half-1 0.3 -0.7

# tileset CHILD: writes tiles/tileset.json, whose second child has this content.
tileset() {
    cat > tiles/tileset.json <<JSON
{"asset": {"version": "1.1"}, "geometricError": 10, "root": {"geometricError": 0.2, "refine": "REPLACE",
 "boundingVolume": {"box": [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]}, "content": {"uri": "whole.glb"}, "children": [
  {"geometricError": 0.01, "boundingVolume": {"box": [0.7, 0, 0, 0.3, 0, 0, 0, 0.3, 0, 0, 0, 0.3]}, "content": {"uri": "half1.glb"}},
  {"geometricError": 0.01, "boundingVolume": {"box": [-0.7, 0, 0, 0.3, 0, 0, 0, 0.3, 0, 0, 0, 0.3]}, "content": {"uri": "$1"}}]}}
JSON
}

# draw INPUT OPTIONS...: draws a row of pixels through the middle, and stores which are covered.
draw() {
    input=$1
    shift
    run "$PHONGSPLAT" render "$input" out/x.png -w --software --size 80x80 --azimuth 0 --elevation 0 "$@"
    expect_success
    row=$(node - out/x.png <<'JS'
const p = require(process.env.SOURCE_DIR + '/tests/support/png.js')(process.argv[2]);
console.log([...Array(p.width).keys()].map((x) => (p.at(x, p.height >> 1)[0] < 255 ? '#' : '.')).join('').replace(/(.)\1*/g, '$1'));
JS
)
}

tileset half-1.glb
# The cube's error is 0.2 of its half side: some 4 of 80 pixels.
draw tiles --pixels 10
[ "$row" = '.#.' ] || fail "a great error: $row"
draw tiles
[ "$row" = '.#.#.' ] || fail "the default of 1 pixel: $row"
draw tiles/tileset.json --pixels 0.01
[ "$row" = '.#.#.' ] || fail "an error less than that of any tile: $row"
# The error is told in pixels of the picture: of one of ten times as many across it is 40.
draw tiles --pixels 10 --size 800x800 --supersample 1
[ "$row" = '.#.#.' ] || fail "a large picture: $row"
draw tiles --pixels 10 --supersample 8
[ "$row" = '.#.' ] || fail "a fine average: $row"

# The same tileset as an archive, a ZIP of stored files.
node - tiles out/tiles.3tz <<'JS'
const fs = require('fs'), [, , from, to] = process.argv, parts = [], entries = [];
const crc = (bytes) => {
    let c = ~0;
    for (const byte of bytes) {
        c ^= byte;
        for (let k = 0; k < 8; ++k) c = (c >>> 1) ^ (c & 1 ? 0xedb88320 : 0);
    }
    return ~c >>> 0;
};
let at = 0;
for (const name of fs.readdirSync(from)) {
    const bytes = fs.readFileSync(`${from}/${name}`), fields = Buffer.alloc(26);
    fields.writeUInt16LE(20, 0);
    fields.writeUInt32LE(crc(bytes), 10);
    fields.writeUInt32LE(bytes.length, 14);
    fields.writeUInt32LE(bytes.length, 18);
    fields.writeUInt16LE(name.length, 22);
    const end = Buffer.alloc(14);
    end.writeUInt32LE(at, 10);
    entries.push(Buffer.from('PK\x01\x02\x14\0'), fields, end, Buffer.from(name));
    parts.push(Buffer.from('PK\x03\x04'), fields, Buffer.from(name), bytes);
    at += 30 + name.length + bytes.length;
}
const directory = Buffer.concat(entries), last = Buffer.alloc(18), count = entries.length / 4;
last.writeUInt16LE(count, 4);
last.writeUInt16LE(count, 6);
last.writeUInt32LE(directory.length, 8);
last.writeUInt32LE(at, 12);
fs.writeFileSync(to, Buffer.concat([...parts, directory, Buffer.from('PK\x05\x06'), last]));
JS
draw out/tiles.3tz
[ "$row" = '.#.#.' ] || fail "an archive: $row"

tileset none.glb
run "$PHONGSPLAT" render tiles out/y.png
expect_error 2 'tiles: none.glb: '
[ ! -e out/y.png ] || fail 'a picture with a hole was written'
draw tiles --pixels 10 # which does not want it
printf 'glTF?' > tiles/none.glb
run "$PHONGSPLAT" render tiles out/y.png
expect_error 3 'none.glb: the file ends within the GLB header'
tileset ../cube.glb
run "$PHONGSPLAT" render tiles out/y.png
expect_error 4 'the uri ../cube.glb is refused: it leaves its directory'
run "$PHONGSPLAT" render out out/y.png
expect_error 2 'out: '
tileset half-1.glb
run "$PHONGSPLAT" render tiles out/y.png --time 1
expect_error 1 'time: the file has no such animation'
for input in tiles/whole.glb cube.obj; do
    run "$PHONGSPLAT" render $input out/y.png --pixels 2
    expect_error 1 'pixels: is for a tileset'
done
echo "$checks checks passed"

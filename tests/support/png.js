// SPDX-License-Identifier: MIT
// Reads the PNGs that we write (8 bits, RGB or RGBA, not interlaced): {width, height, channels, at(x, y)}.
'use strict';
const fs = require('fs'), zlib = require('zlib');

function chunks(file) {
    const found = [];
    for (let i = 8; i < file.length; i += file.readUInt32BE(i) + 12)
        found.push({type: file.toString('latin1', i + 4, i + 8), body: file.subarray(i + 8, i + 8 + file.readUInt32BE(i))});
    return found;
}

// PNG specification, section 9.
function unfilter(row, up, filter, n) {
    for (let i = 0; i < row.length; ++i) {
        const a = i < n ? 0 : row[i - n], b = up[i], c = i < n ? 0 : up[i - n];
        const p = a + b - c, pa = Math.abs(p - a), pb = Math.abs(p - b), pc = Math.abs(p - c);
        const paeth = pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
        row[i] += [0, a, b, (a + b) >> 1, paeth][filter];
    }
}

module.exports = path => {
    const all = chunks(fs.readFileSync(path)), header = all.find(c => c.type === 'IHDR').body;
    const width = header.readUInt32BE(0), height = header.readUInt32BE(4), channels = header[9] === 6 ? 4 : 3;
    const raw = zlib.inflateSync(Buffer.concat(all.filter(c => c.type === 'IDAT').map(c => c.body)));
    const stride = width * channels, rows = [];
    for (let y = 0; y < height; ++y) {
        const row = raw.subarray(y * (stride + 1) + 1, (y + 1) * (stride + 1));
        unfilter(row, rows[y - 1] || Buffer.alloc(stride), raw[y * (stride + 1)], channels);
        rows.push(row);
    }
    return {width, height, channels, at: (x, y) => [...rows[y].subarray(x * channels, (x + 1) * channels)]};
};

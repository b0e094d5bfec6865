// SPDX-License-Identifier: MIT
//
// bench_textures.mjs - compares textured files at equal bytes and equal pictures: those of `phongsplat
// convert` and meshes simplified by gltfpack, both with the source's images and with smaller ones.
//
//     npm install --prefix DIRECTORY gltfpack@1.3.0 sharp@0.34
//     node tests/bench/bench_textures.mjs --modules DIRECTORY --phongsplat PROGRAM [options] MODEL...
//
//     --tolerances LIST   of conversions, in percent; 1,0.5,0.2,0.1
//     --ratios LIST       of triangles that gltfpack keeps (-cc -sv -se 1 -si RATIO); 1 to 0.05
//     --scales LIST       of the sides of images, the same for both kinds of files; 1,0.5,0.25
//     --size PIXELS       of the pictures that `phongsplat compare --software` takes; 1024
//     --csv FILE          all measurements
//
// A picture's error is that of base colours without light: PSNR where both pictures are, in dB, and
// SSIM over all that either covers, which counts outlines too. sharp makes the smaller images, of
// the same format: JPEG of quality 90, or PNG.
//
// The first table of a model has the files with all of their images. Its last columns are our bytes
// without images divided by gltfpack's at equal PSNR and at equal SSIM, and the second table has, for
// our best files of any scale, PSNR and SSIM of gltfpack's best at equal bytes in total. Both are
// read off the other ladder's best files, between which the logarithm of bytes is interpolated; "<"
// and ">" mark what lies outside of it.
import { execFileSync, spawnSync } from 'node:child_process';
import { appendFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { basename, join, resolve } from 'node:path';

const BREAKS_PROMISE = 9; // the exit code of a conversion whose file the tables may show all the same

const options = { tolerances: '1,0.5,0.2,0.1', ratios: '1,0.7,0.5,0.35,0.25,0.18,0.12,0.08,0.05', scales: '1,0.5,0.25', size: '1024' }, models = [];
for (let i = 2; i < process.argv.length; ++i)
    if (process.argv[i].startsWith('--')) options[process.argv[i].slice(2)] = process.argv[++i];
    else models.push(process.argv[i]);
if (!options.modules || !options.phongsplat || !models.length) throw new Error('--modules, --phongsplat and a model are needed');
const numbers = (text) => text.split(',').map(Number), folder = mkdtempSync(join(tmpdir(), 'bench_textures.'));
const sharp = createRequire(join(resolve(options.modules), 'index.js'))('sharp'), gltfpack = join(resolve(options.modules), 'node_modules/.bin/gltfpack');

// ---- files -----------------------------------------------------------------------------------

function readGlb(path) {
    const bytes = readFileSync(path), size = bytes.readUInt32LE(12);
    return { json: JSON.parse(bytes.toString('utf8', 20, 20 + size)), bin: bytes.subarray(28 + size) };
}

const padded = (bytes, filler) => Buffer.concat([bytes, Buffer.alloc((4 - bytes.length % 4) % 4, filler)]);

function writeGlb(path, json, bin) {
    const text = padded(Buffer.from(JSON.stringify(json)), ' '), head = Buffer.alloc(20), between = Buffer.alloc(8);
    head.write('glTF');
    head.writeUInt32LE(2, 4);
    head.writeUInt32LE(28 + text.length + bin.length, 8);
    head.writeUInt32LE(text.length, 12);
    head.write('JSON', 16);
    between.writeUInt32LE(bin.length);
    between.write('BIN\0', 4);
    writeFileSync(path, Buffer.concat([head, text, between, bin]));
}

/** The bytes of images in a file. */
function imageBytes(path) {
    const { json } = readGlb(path);
    return (json.images ?? []).reduce((sum, image) => sum + json.bufferViews[image.bufferView].byteLength, 0);
}

/** Writes a copy of a file with smaller images. */
async function shrink(from, to, scale) {
    const { json, bin } = readGlb(from), images = new Map((json.images ?? []).map((image) => [image.bufferView, image])), parts = [];
    let offset = 0;
    for (const [index, view] of json.bufferViews.entries()) {
        const place = view.extensions?.EXT_meshopt_compression ?? view, start = place.byteOffset ?? 0, image = images.get(index);
        if (place.buffer !== 0) continue;
        let bytes = bin.subarray(start, start + place.byteLength);
        if (image) {
            const { width, height } = await sharp(bytes).metadata(), made = sharp(bytes).resize(Math.max(1, Math.round(width * scale)), Math.max(1, Math.round(height * scale)), { fit: 'fill' });
            bytes = await (image.mimeType === 'image/jpeg' ? made.jpeg({ quality: 90 }) : made.png({ compressionLevel: 9 })).toBuffer();
        }
        place.byteOffset = offset;
        place.byteLength = bytes.length;
        parts.push(padded(bytes, 0));
        offset += parts.at(-1).length;
    }
    json.buffers[0].byteLength = offset;
    writeGlb(to, json, Buffer.concat(parts));
}

// ---- measurements ----------------------------------------------------------------------------

/** The files of one kind: setting, bytes in total and of images, PSNR and SSIM. */
async function climb(model, kind, settings, make) {
    const made = join(folder, 'made.glb'), shrunk = join(folder, 'shrunk.glb'), report = join(folder, 'report.json'), files = [];
    for (const setting of settings) {
        make(setting, made);
        if (!readGlb(made).json.meshes) break; // gltfpack has collapsed all
        for (const scale of numbers(options.scales)) {
            const path = scale === 1 ? made : shrunk;
            if (scale !== 1) await shrink(made, shrunk, scale);
            execFileSync(options.phongsplat, ['compare', model, path, '--size', options.size, '--software', '--samples', '1000', '--report', report, '-w', '-q']);
            const measured = JSON.parse(readFileSync(report, 'utf8')), images = imageBytes(path), found = findErrors(measured);
            const file = { setting, scale, elements: measured.elements, bytes: readFileSync(path).length, images, ...found };
            files.push(file);
            if (options.csv) appendFileSync(options.csv, `${basename(model)},${kind},${setting},${scale},${file.elements},${file.bytes},${images},${file.psnr},${file.ssim}\n`);
        }
    }
    return files;
}

/** Finds the errors of base colours anywhere in a report. */
function findErrors(report) {
    if (report?.base_color_inside_psnr_db !== undefined) return { psnr: report.base_color_inside_psnr_db, ssim: report.base_color_ssim };
    for (const value of Object.values(report ?? {})) {
        const found = typeof value === 'object' ? findErrors(value) : undefined;
        if (found) return found;
    }
    return undefined;
}

function convert(model, tolerance, path) {
    const { status } = spawnSync(options.phongsplat, ['convert', model, path, '-t', `${tolerance}%`, '-w', '-q']);
    if (status !== 0 && status !== BREAKS_PROMISE) throw new Error(`${model} at ${tolerance} %: exit code ${status}`);
}

function simplify(model, ratio, path) {
    execFileSync(gltfpack, ['-i', model, '-o', path, '-cc', '-sv', '-se', '1', '-si', String(ratio)], { stdio: 'ignore' });
}

// ---- ladders ---------------------------------------------------------------------------------

/** The files of which no smaller one is as good, the smallest first. */
function best(files, bytes, quality) {
    const sorted = [...files].sort((a, b) => bytes(a) - bytes(b) || quality(b) - quality(a)), kept = [];
    for (const file of sorted) if (!kept.length || quality(file) > quality(kept.at(-1))) kept.push(file);
    return kept;
}

/** y at x between points with growing x: interpolated, marked where x lies outside. */
function read(points, x) {
    const next = points.findIndex((p) => p[0] >= x);
    if (next === 0) return { y: points[0][1], mark: points[0][0] > x ? '<' : '' };
    if (next < 0) return { y: points.at(-1)[1], mark: '>' };
    const [a, b] = [points[next - 1], points[next]];
    return { y: a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]), mark: '' };
}

const withoutImages = (file) => file.bytes - file.images, total = (file) => file.bytes, row = (cells) => console.log(`| ${cells.join(' | ')} |`);
const psnr = (file) => file.psnr, ssim = (file) => file.ssim;

/** Our bytes without images over theirs at equal quality. Their smallest file may be better still, so that the ratio is
 *  greater, or their largest worse. */
function ratio(file, theirs, quality) {
    const { y, mark } = read(best(theirs, withoutImages, quality).map((f) => [quality(f), Math.log(withoutImages(f))]), quality(file));
    return `${{ '<': '> ', '>': '< ', '': '' }[mark]}${(withoutImages(file) / Math.exp(y)).toFixed(2)}`;
}

/** Their quality at our bytes. */
function rival(file, theirs, quality, digits) {
    const { y, mark } = read(best(theirs, total, quality).map((f) => [Math.log(total(f)), quality(f)]), Math.log(total(file)));
    return mark === '<' ? 'none as small' : `${mark === '>' ? '≥ ' : ''}${y.toFixed(digits)}`;
}

function print(name, ours, theirs) {
    const [full, fullTheirs] = [ours, theirs].map((files) => files.filter((file) => file.scale === 1));
    row(['file', 'splats or triangles', 'base colour, dB', 'SSIM', 'bytes without images', 'with images', '÷ at equal dB', '÷ at equal SSIM']);
    row(['---', ...Array(7).fill('--:')]);
    for (const f of full) row([`${name}, ${f.setting} %`, f.elements, f.psnr.toFixed(2), f.ssim.toFixed(4), withoutImages(f), f.bytes, ratio(f, fullTheirs, psnr), ratio(f, fullTheirs, ssim)]);
    for (const f of fullTheirs) row([`${name}, gltfpack ${f.setting}`, f.elements, f.psnr.toFixed(2), f.ssim.toFixed(4), withoutImages(f), f.bytes, '', '']);
    console.log();
    row(['our file', 'images', 'bytes in total', 'dB', "gltfpack's", 'SSIM', "gltfpack's"]);
    row(['---', ...Array(6).fill('--:')]);
    for (const f of new Set([...best(ours, total, psnr), ...best(ours, total, ssim)].sort((a, b) => total(a) - total(b))))
        row([`${name}, ${f.setting} %`, f.scale, f.bytes, f.psnr.toFixed(2), rival(f, theirs, psnr, 2), f.ssim.toFixed(4), rival(f, theirs, ssim, 4)]);
    console.log();
}

if (options.csv) writeFileSync(options.csv, 'model,kind,tolerance_or_ratio,scale,elements,bytes,image_bytes,base_color_psnr_db,base_color_ssim\n');
try {
    for (const model of models) {
        const ours = await climb(model, 'splats', numbers(options.tolerances), (tolerance, path) => convert(model, tolerance, path));
        const theirs = await climb(model, 'gltfpack', numbers(options.ratios), (ratio, path) => simplify(model, ratio, path));
        print(basename(model).replace(/\.\w+$/, ''), ours, theirs);
    }
} finally {
    rmSync(folder, { recursive: true });
}

// SPDX-License-Identifier: MIT
//
// level_list.js - what a file says of the levels of a mesh (section 3.13), with the checks and the
// messages of runtime/asset/level.c.
import { EXTENSION } from './decode.js';

const MEMBERS = { distance: Infinity, normal: 180, outline: Infinity }; // each error's greatest value

/** @returns the extension's object of a primitive, undefined where it holds no splats. */
export const splatsOf = (primitive) => primitive.extensions?.[EXTENSION];

const text = (x) => (x === Infinity ? 'inf' : String(Number(x.toPrecision(6))));

function checkNumber(value, name, fail) {
    if (typeof value !== 'number') fail(`: ${name} must be a number`);
    if (!Number.isFinite(value)) fail(`: ${name} is too large for a number`);
}

/** Checks the mesh of a coarser level. before: the mesh of the level before. */
function checkMesh(json, finest, before, index, fail) {
    const { meshes } = json, mesh = meshes[index], own = (at) => meshes[at].primitives.filter(splatsOf);
    const count = (at) => own(at).reduce((sum, { attributes }) => sum + (json.accessors?.[attributes?.POSITION]?.count ?? 0), 0);
    if (index === finest || own(index).some((primitive) => splatsOf(primitive).levels !== undefined)) fail(' is a mesh with levels of its own');
    if (!own(index).length || mesh.extensions?.[EXTENSION]?.mesh !== undefined) fail(' is a mesh without splats of its own');
    if (count(index) >= count(before)) fail(' has no fewer splats than the level before');
}

function readMesh(json, finest, before, { mesh }, fail) {
    if (!before) {
        if (mesh !== undefined) fail(' is the mesh itself and names none');
        return finest;
    }
    const last = json.meshes.length - 1;
    if (mesh === undefined) fail(': mesh is missing');
    checkNumber(mesh, 'mesh', fail);
    if (!Number.isInteger(mesh) || mesh < 0 || mesh > last) fail(`: mesh must be an integer from 0 to ${last}`);
    checkMesh(json, finest, before.mesh, mesh, fail);
    return mesh;
}

/** @returns the errors of a level, none of which may be less than that of the level before. */
function readErrors(before, level, fail) {
    return Object.fromEntries(Object.entries(MEMBERS).map(([name, most]) => {
        const value = level[name], least = before?.[name] ?? 0;
        if (value === undefined) fail(`: ${name} is missing`);
        checkNumber(value, name, fail);
        if (!(value >= least && value <= most)) fail(`: ${name} must be ${text(least)} to ${text(most)}`);
        return [name, value];
    }));
}

/** @returns where a level's positions are in the space of the finest one. */
function readPlace(before, level, fail) {
    const { scale = 1, translation = [0, 0, 0] } = level;
    if (!before && ('scale' in level || 'translation' in level)) fail(' is the mesh itself and has no place of its own');
    checkNumber(scale, 'scale', fail);
    if (!(scale > 0)) fail(' has a scale that is not above 0');
    if (!Array.isArray(translation)) fail(': translation must be an array');
    if (translation.length !== 3) fail(': translation must have 3 numbers');
    for (const x of translation) checkNumber(x, 'translation', fail);
    return { scale, translation };
}

/** @returns { mesh, distance, normal, outline, scale, translation } of each level of a mesh, the finest
 *  first; none where the file states no levels. Throws where it breaks a rule of section 3.13. */
export function readLevels(json, mesh) {
    const [first, ...others] = json.meshes[mesh].primitives.filter(splatsOf).map((primitive) => splatsOf(primitive).levels), levels = [];
    if (others.some((list) => list !== undefined)) throw new Error(`${EXTENSION}: levels belong to the first primitive of splats of a mesh`);
    if (first === undefined) return levels;
    if (!Array.isArray(first)) throw new Error(`${EXTENSION}: levels must be an array`);
    if (!first.length) throw new Error(`${EXTENSION}: the levels of mesh ${mesh} are an empty list`);
    for (const [k, level] of first.entries()) {
        const fail = (cause) => { throw new Error(`${EXTENSION}: level ${k} of mesh ${mesh}${cause}`); }, before = levels[k - 1];
        if (typeof level !== 'object' || level === null || Array.isArray(level)) fail(': an object is expected');
        levels.push({ mesh: readMesh(json, mesh, before, level, fail), ...readErrors(before, level, fail), ...readPlace(before, level, fail) });
    }
    return levels;
}

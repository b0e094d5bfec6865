// SPDX-License-Identifier: MIT
//
// programs.js - the materials of the splat passes: which macros a batch needs in a view, as
// runtime/gl/gl_program.c chooses them, and the uniforms of one draw.
import {
    AddEquation, CustomBlending, DoubleSide, FrontSide, GLSL3, LessDepth, LessEqualDepth, Matrix3, Matrix4, NoBlending, OneFactor,
    RawShaderMaterial, Vector2, Vector3,
} from 'three';
import { shaders } from './shaders.js';

export const PASS = { visibility: 0, normals: 1, parameters: 3 };

export const PRELUDE = 'precision highp float;\nprecision highp int;\nprecision highp sampler2D;\n';

/** The textures of a material by slot (psplat_texture_slot): uniform, macro, and the property of
 *  three's material. */
const SLOTS = [
    ['u_base_map', 'BASE_MAP', 'map'],
    ['u_surface_map', 'SURFACE_MAP', 'roughnessMap'],
    ['u_normal_map', 'NORMAL_MAP', 'normalMap'],
    ['u_occlusion_map', 'OCCLUSION_MAP', 'aoMap'],
    ['u_emissive_map', 'EMISSIVE_MAP', 'emissiveMap'],
];

/** @returns the texture of a slot where it applies: section 3.11 ignores those of other sets. */
function mapOf(batch, material, property) {
    if (!batch.texcoords) return null;
    const texture = material[property] ?? (property === 'roughnessMap' ? material.metalnessMap : null);
    return texture && texture.channel === 0 && texture.image ? texture : null;
}

/** @returns what of a material reaches the render targets. */
export function surfaceOf(material) {
    const isUnlit = !!material.isMeshBasicMaterial;
    return {
        color: material.color,
        emissive: material.emissive,
        emissiveIntensity: material.emissive ? material.emissiveIntensity : 0,
        metallic: material.metalness ?? 0,
        roughness: material.roughness ?? 1,
        unlit: isUnlit ? 1 : 0,
    };
}

function isSameColor(a, b) {
    return a.color.equals(b.color);
}

function isSameSurface(a, b) {
    const black = !a.emissiveIntensity && !b.emissiveIntensity;
    return a.metallic === b.metallic && a.roughness === b.roughness && a.unlit === b.unlit &&
        (black || (a.emissiveIntensity === b.emissiveIntensity && a.emissive.equals(b.emissive)));
}

/** @returns which render targets batches need: what differs between splats or materials.
 *  drawn: { batch, material }, one at least. */
export function differences(drawn) {
    const first = surfaceOf(drawn[0].material), differ = { colors: false, materials: false, occlusion: false };
    for (const { batch, material } of drawn) {
        const surface = surfaceOf(material);
        const has = (property) => !!mapOf(batch, material, property);
        differ.occlusion ||= batch.hasSurface || has('aoMap');
        differ.materials ||= differ.occlusion || batch.hasEmissive || has('roughnessMap') || has('emissiveMap') ||
            surface.unlit === 1 || !isSameSurface(first, surface);
        differ.colors ||= differ.materials || batch.hasColor || batch.hasGradient || has('map') || !isSameColor(first, surface);
    }
    return differ;
}

/** @returns the macros of a batch's pass. view: pass, isCurved, isBoxed (of flat splats that lines cut), isNear, isTwoSided, counts, isHalf,
 *  differ (of differences()), packs (the depth of shadow maps as colours: '', 'depth', 'distance'),
 *  isReversed, isOwned (the visibility pass writes the object's number). */
function definesOf(batch, material, view) {
    const { pass, isCurved, differ } = view, isFlat = !isCurved, isNormals = pass === PASS.normals;
    const isTwoSided = view.isTwoSided && (isNormals || (isCurved && pass === PASS.visibility));
    // Fragments know of seams only where they are weighed.
    const seams = isNormals && !view.counts ? batch.seamLines : 0, lines = batch.clipLines - batch.seamLines + seams;
    const d = { PASS: pass, CLIP_COUNT: lines, CLIP_TYPE: ['none', 'float', 'vec2', 'vec3', 'vec4'][lines], LINE_COUNT: batch.clipLines, SEAM_COUNT: seams };
    d.LINE_TYPE = batch.hasBends ? 'vec4' : 'vec3';
    d.WEIGHT_FLOOR = view.isHalf ? '1e-3' : '1e-30';
    d.HALF_TARGETS = view.isHalf;
    d.BENDS = batch.hasBends;
    d.WIDE = batch.isWide;
    d.SHAPE = batch.hasShape;
    d.FIELD = isNormals;
    d.GAMMA = batch.hasGamma && (isNormals || (isCurved ? !batch.hasShape : false));
    d.NEAR = isFlat && pass === PASS.visibility && view.isNear;
    d.TWO_SIDED = isTwoSided;
    d.FILTER = isFlat && isNormals;
    d.TANGENT = batch.isCurved && isFlat && !batch.hasShape;
    d.COUNT = isNormals && view.counts;
    d.POWER = isNormals && batch.exponent !== 2 && !d.COUNT;
    d.COLORS = isNormals && differ.colors;
    d.MATERIALS = isNormals && differ.materials;
    d.OCCLUSION = isNormals && differ.occlusion;
    d.FINISH = d.COLORS && batch.finish !== 0;
    d.COLOR = d.COLORS && batch.hasColor && !d.FINISH;
    d.MASK = !!batch.texcoords && material.alphaTest > 0 && pass !== PASS.parameters;
    const isUsed = [d.COLORS || d.MASK, d.MATERIALS, isNormals, d.OCCLUSION, d.MATERIALS];
    let hasMaps = false, isMoved = false;
    SLOTS.forEach(([, macro, property], k) => {
        const texture = isUsed[k] ? mapOf(batch, material, property) : null;
        d[macro] = !!texture;
        hasMaps ||= !!texture;
        isMoved ||= !!texture && !isIdentity(texture);
    });
    d.TEXTURED = d.MASK || hasMaps;
    d.TEXCOORD_BEND = d.TEXTURED && batch.hasTexcoordBend;
    d.MAP_TRANSFORM = isMoved;
    d.PACKS = { '': 0, depth: 1, distance: 2 }[view.packs ?? ''];
    d.REVERSED = !!view.isReversed;
    d.OWNED = !!view.isOwned;
    d.FADE = false;
    d.PART = 0;
    d.BOX = !!view.isBoxed;
    return d;
}

function isIdentity(texture) {
    if (texture.matrixAutoUpdate) texture.updateMatrix();
    const e = texture.matrix.elements;
    return e[0] === 1 && e[1] === 0 && e[3] === 0 && e[4] === 1 && e[6] === 0 && e[7] === 0;
}

// The last words of the shaders, which are three's business: reversed depth, and the shadow maps of
// releases before 182, which hold depths or distances as colours.
const VERTEX_END = `
void main() {
splat_main();
#if REVERSED
gl_Position.z = 0.5 * (gl_Position.w - gl_Position.z);
#endif
}
`;
const FRAGMENT_END = `
#if PACKS
layout(location = 0) out vec4 o_packed;
uniform mat4 u_unproject;
uniform vec2 u_near_far;
uniform vec3 u_half_viewport;
vec4 pack(float v) {
float u = clamp(v, 0.0, 1.0 - 1.0 / 4294967296.0) * 256.0;
vec4 bytes;
for (int i = 0; i < 3; ++i) { bytes[i] = floor(u) / 255.0; u = fract(u) * 256.0; }
bytes[3] = u / 256.0;
return bytes;
}
#endif
#if OWNED
layout(location = 0) out vec4 o_owner;
uniform vec2 u_owner;
#endif
void main() {
splat_main();
#if OWNED
o_owner = vec4(u_owner, 0.0, 1.0);
#endif
#if PACKS
#if CURVED
float depth = gl_FragDepth;
#else
float depth = gl_FragCoord.z;
#endif
#if PACKS == 2
vec4 eye = u_unproject * vec4(mod(gl_FragCoord.xy, 2.0 * u_half_viewport.xy), depth, 1.0);
depth = (length(eye.xyz / eye.w) - u_near_far.x) / (u_near_far.y - u_near_far.x);
#endif
o_packed = pack(depth);
#endif
}
`;

function sourceOf(defines, isCurved) {
    const head = Object.entries(defines).map(([key, value]) => `#define ${key} ${typeof value === 'boolean' ? +value : value}\n`).join('');
    const start = PRELUDE + head + `#define CURVED ${+isCurved}\n` + shaders['layout.h'] + '#define main splat_main\n', end = '#undef main\n';
    const vertex = shaders['texels.glsl'] + shaders['splat_data.glsl'] + shaders['shift.glsl'] + shaders[isCurved ? 'curved.vert' : 'splat.vert'];
    const fragment = shaders['texels.glsl'] + (defines.TEXTURED ? shaders['maps.glsl'] : '') + shaders['sums.glsl'] + shaders[isCurved ? 'curved.frag' : 'splat.frag'];
    return [start + vertex + end + VERTEX_END, start + fragment + end + FRAGMENT_END];
}

function makeUniforms(batch) {
    const names = {
        u_splats: batch.splats, u_clips: batch.clips ?? batch.splats, u_finishes: batch.finishes, u_texcoords: batch.texcoords, u_finish: batch.finishUniform,
        u_modelview: new Matrix4(), u_projection: new Matrix4(), u_unproject: new Matrix4(),
        u_normal_matrix: new Matrix3(), u_ray: new Matrix3(), u_half_viewport: new Vector3(), u_shift: new Vector3(),
        u_view_direction: new Vector3(), u_depth_range: new Vector2(0.5, 0.5), u_unstretch: 1, u_first_index: 0, u_apart: 0,
        u_kernel: new Vector2(-batch.sharpness, 0.5 * batch.exponent), u_base_color: new Vector3(), u_emissive: new Vector3(),
        u_surface: new Vector3(), u_map_strength: new Vector2(), u_mask: new Vector2(), u_near_far: new Vector2(), u_owner: new Vector2(),
        u_map_transform: Array.from({ length: 2 * SLOTS.length }, () => new Vector3()),
    };
    for (const [name] of SLOTS) names[name] = null;
    return Object.fromEntries(Object.entries(names).map(([name, value]) => [name, { value }]));
}

/** One pass of one batch in one variant. */
export class SplatMaterial extends RawShaderMaterial {
    constructor(batch, material, view) {
        const defines = definesOf(batch, material, view), [vertexShader, fragmentShader] = sourceOf(defines, view.isCurved);
        const isDepth = view.pass === PASS.visibility, adds = view.pass === PASS.normals;
        super({ name: 'PhongSplats', glslVersion: GLSL3, vertexShader, fragmentShader, uniforms: makeUniforms(batch) });
        this.colorWrite = !isDepth || defines.PACKS > 0 || defines.OWNED;
        this.depthWrite = !adds;
        this.depthFunc = adds ? LessEqualDepth : LessDepth;
        this.blending = adds ? CustomBlending : NoBlending;
        this.blendEquation = AddEquation;
        this.blendSrc = this.blendDst = OneFactor;
        this.side = !view.isTwoSided && !view.isCurved ? FrontSide : DoubleSide;
        if (view.isReversed && view.isCurved) this.uniforms.u_depth_range.value.set(-0.5, 0.5);
        this.toneMapped = false;
    }

    /** Sets the uniforms of a material (sections 3.10 and 3.11). */
    use(batch, material) {
        const u = this.uniforms, surface = surfaceOf(material);
        u.u_base_color.value.set(surface.color.r, surface.color.g, surface.color.b);
        if (surface.emissive) u.u_emissive.value.set(surface.emissive.r, surface.emissive.g, surface.emissive.b).multiplyScalar(surface.emissiveIntensity);
        u.u_surface.value.set(surface.metallic, surface.roughness, surface.unlit);
        u.u_mask.value.set(material.opacity, material.alphaTest);
        u.u_map_strength.value.set(material.normalScale?.x ?? 1, material.aoMapIntensity ?? 1);
        SLOTS.forEach(([name, , property], k) => {
            const texture = mapOf(batch, material, property);
            u[name].value = texture;
            if (!texture) return;
            isIdentity(texture);
            const e = texture.matrix.elements;
            u.u_map_transform.value[2 * k].set(e[0], e[3], e[6]);
            u.u_map_transform.value[2 * k + 1].set(e[1], e[4], e[7]);
        });
        this.uniformsNeedUpdate = true;
    }
}

/** @returns a number that is another one wherever definesOf() is, of the same batch. */
function keyOf(batch, material, view) {
    const { differ } = view, bits = [
        view.pass & 1, view.pass & 2, view.isCurved, view.isBoxed, view.isNear, view.isTwoSided, view.counts, view.isHalf, differ.colors, differ.materials, differ.occlusion,
        view.packs === 'depth', view.packs === 'distance', view.isReversed, view.isOwned, batch.texcoords && material.alphaTest > 0,
    ];
    let key = 1;
    for (const bit of bits) key = 2 * key + (bit ? 1 : 0);
    if (!batch.texcoords) return key;
    for (const [, , property] of SLOTS) {
        const texture = mapOf(batch, material, property);
        key = 3 * key + (!texture ? 0 : isIdentity(texture) ? 1 : 2);
    }
    return key;
}

/** @returns the material of a batch's pass, which is made once for each variant. */
export function findMaterial(batch, material, view) {
    const key = keyOf(batch, material, view);
    batch.variants ??= new Map();
    if (!batch.variants.has(key)) batch.variants.set(key, new SplatMaterial(batch, material, view));
    return batch.variants.get(key);
}

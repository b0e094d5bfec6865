// SPDX-License-Identifier: MIT
//
// resolve.js - makes one of three's own materials the resolve pass of splats: a rectangle on the
// screen whose fragments take position, normal and surface from the render targets, and are then
// lit, shadowed, fogged and tone mapped as any other's. What three's vertex shaders hand on
// (varyings) is computed here at each fragment, by three's own chunks where there are any.
import { Matrix4, ShaderChunk, Vector2, Vector4 } from 'three';

export const FLAGS = { colors: 1, materials: 2, occlusion: 4, half: 8 };

/** The rectangle's corners are vertices 0 to 3 of the geometry, whose positions say where the model
 *  is and have no part in this. */
export const VERTEX = `
uniform vec4 psRect;
void main() {
    vec2 side = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(mix(psRect.xy, psRect.zw, side), 0.0, 1.0);
}
`;

/** What three's vertex shaders would hand on, as variables. */
const HANDED_ON = { vViewPosition: 'vec3', vFogDepth: 'float', vClipPosition: 'vec3', vWorldPosition: 'vec3', vNormal: 'vec3', vFragDepth: 'float', vIsPerspective: 'float' };

/** Whether a pixel is the object's: its own splat is the nearest there. Number 0 has no others beside it. */
export const OWNED = `
uniform highp sampler2D psOwners;
uniform highp float psNumber;
bool psIsOwned(ivec2 at) {
    return psNumber == 0.0 || dot(floor(texelFetch(psOwners, at, 0).rg * 255.0 + 0.5), vec2(1.0, 256.0)) == psNumber;
}
`;

const DECLARATIONS = `
uniform highp sampler2D psTarget0, psTarget1, psTarget2, psTarget3, psDepth;
uniform highp int psFlags;
${OWNED}uniform mat4 psUnproject, psCamera;
uniform vec2 psToHost, psOrigin;
uniform float psTolerance;
#define HAS_NORMAL
`;

/** The point is lifted off the surface by a texel and a half of the shadow map, and more where three
 *  filters over more of them, so that a slope within a texel casts no shadow, and by the distance
 *  that splats of one surface lie apart (shading.glsl does the same). At a concave crease the normal
 *  of one face leads along the other, which would cast a shadow within the texels that three filters
 *  over, so that the point is lifted off both. */
const SHADOWS = `
#if defined( USE_SHADOWMAP ) && NUM_DIR_LIGHT_SHADOWS > 0
uniform mat4 directionalShadowMatrix[ NUM_DIR_LIGHT_SHADOWS ];
#endif
#if NUM_SPOT_LIGHT_COORDS > 0
uniform mat4 spotLightMatrix[ NUM_SPOT_LIGHT_COORDS ];
#endif
#if defined( USE_SHADOWMAP ) && NUM_POINT_LIGHT_SHADOWS > 0
uniform mat4 pointShadowMatrix[ NUM_POINT_LIGHT_SHADOWS ];
#endif
#ifdef USE_REVERSED_DEPTH_BUFFER
#define PS_TO_LIGHT 1.0
#else
#define PS_TO_LIGHT -1.0
#endif
/** Off the surface, and off the one beside it where that faces the light, too. */
vec3 psOff(vec3 normal, vec3 next, vec3 toLight) {
    return dot(next, toLight) > 0.0 ? (normal + next) / (1.0 + dot(normal, next)) : normal;
}
/** The normal of a next pixel on another face, or the pixel's own. */
vec3 psNextNormal(ivec2 at, float z, vec3 normal) {
    vec3 point = psPoint(at, z), found = normal;
    float least = 0.95;
    for (int k = 0; k < 4; ++k) {
        ivec2 next = at + ivec2(k == 0 ? 1 : k == 1 ? -1 : 0, k == 2 ? 1 : k == 3 ? -1 : 0);
        vec4 sum = texelFetch(psTarget0, next, 0);
        if (!(sum.a > 0.0)) continue;
        float size = distance(psPoint(next, z), point), cosine = dot(normalize(sum.xyz), normal);
        if (cosine >= least || cosine < -0.9 || distance(psPoint(next, psDepthAt(next, sum.a)), point) > 8.0 * size) continue;
        least = cosine;
        found = normalize(sum.xyz);
    }
    return found;
}
vec3 psLift(vec3 normal, vec3 next, float bias, mat4 m, vec2 size, float radius, vec4 at) {
    vec4 p = m * at;
    vec3 x = vec3(m[0].x, m[1].x, m[2].x), z = vec3(m[0].z, m[1].z, m[2].z), w = vec3(m[0].w, m[1].w, m[2].w);
    float texels = length(x - w * (p.x / p.w)) * size.x / abs(p.w);
    return psOff(normal, next, PS_TO_LIGHT * (z - w * (p.z / p.w))) * (bias + (1.5 + radius) / max(texels, 1e-30) + psTolerance);
}
vec3 psLiftOfPoint(vec3 normal, vec3 next, float bias, mat4 m, vec2 size, float radius, vec4 at) {
    vec3 away = (m * at).xyz;
    return psOff(normal, next, -away) * (bias + (1.5 + radius) * 2.0 * length(away) / size.x + psTolerance);
}
`;

/** What the targets hold of a pixel, in eye space. */
const POINTS = `
float psDepthAt(ivec2 at, float weight) {
    return (psFlags & ${FLAGS.half}) != 0 ? texelFetch(psDepth, at, 0).r : texelFetch(psTarget1, at, 0).r / weight;
}
vec3 psPoint(ivec2 at, float z) {
    vec4 p = psUnproject * vec4(vec2(at) + 0.5, z, 1.0);
    return p.xyz / p.w;
}
`;

/** With alphaToCoverage, how much of a pixel splats cover; where its centre is not covered, the pixel is like one beside it
 *  whose centre is. */
const COVERAGE = `
#ifdef ALPHA_TO_COVERAGE
uniform highp sampler2D psFine;
uniform bool psIsSmooth;
float psCoverage(ivec2 at) {
    float count = 0.0;
    for (int k = 0; k < 4; ++k) count += texelFetch(psFine, 2 * at + ivec2(k & 1, k >> 1), 0).r < 1.0 ? 0.25 : 0.0;
    return count;
}
bool psIsCovered(ivec2 at) {
    return texelFetch(psDepth, at, 0).r < 1.0 && texelFetch(psTarget0, at, 0).a > 0.0;
}
ivec2 psCoveredBeside(ivec2 at) {
    if (psIsCovered(at)) return at;
    for (int k = 0; k < 4; ++k) {
        ivec2 next = at + ivec2(k == 0 ? 1 : k == 1 ? -1 : 0, k == 2 ? 1 : k == 3 ? -1 : 0);
        if (psIsCovered(next)) return next;
    }
    for (int k = 0; k < 4; ++k) {
        ivec2 next = at + 2 * ivec2(k & 1, k >> 1) - 1;
        if (psIsCovered(next)) return next;
    }
    return at;
}
#endif
`;

const START = `
void main() {
    ivec2 psAt = ivec2(gl_FragCoord.xy - psOrigin);
    float psShare = 1.0;
#ifdef ALPHA_TO_COVERAGE
    if (psIsSmooth) {
        psShare = psCoverage(psAt);
        if (psShare == 0.0) {
            if (!psIsCovered(psAt)) discard;
            psShare = 0.25; // the two resolutions round differently
        } else psAt = psCoveredBeside(psAt);
    }
#endif
    vec4 psSum = texelFetch(psTarget0, psAt, 0), psOther = texelFetch(psTarget1, psAt, 0);
    float psBehind = texelFetch(psDepth, psAt, 0).r;
    if (!(psBehind < 1.0 && psSum.a > 0.0) || !psIsOwned(psAt)) discard;
    float psScale = 1.0 / psSum.a;
    float psZ = (psFlags & ${FLAGS.half}) != 0 ? psBehind : psOther.r * psScale;
    vec3 psColor = vec3(1.0), psEmissive = vec3(0.0), psSurface = vec3(0.0);
    if ((psFlags & ${FLAGS.colors}) != 0) {
        vec4 psSums = texelFetch(psTarget2, psAt, 0) * psScale;
        psColor = psSums.rgb;
        psSurface.x = psSums.a;
    }
    if ((psFlags & ${FLAGS.materials}) != 0) {
        vec4 psSums = texelFetch(psTarget3, psAt, 0) * psScale;
        psEmissive = psSums.rgb;
        psSurface.yz = vec2(psSums.a, psOther.g * psScale);
    }
    vec4 mvPosition = psUnproject * vec4(vec2(psAt) + 0.5, psZ, 1.0);
    mvPosition /= mvPosition.w;
    vec4 worldPosition = psCamera * mvPosition;
    float psLength = dot(psSum.xyz, psSum.xyz);
    vec3 transformedNormal = psLength > 0.0 ? psSum.xyz * inversesqrt(psLength) : vec3(0.0, 0.0, 1.0);
    float psHostDepth = psZ * psToHost.x + psToHost.y;
    gl_FragDepth = psHostDepth;
    vViewPosition = -mvPosition.xyz;
    vClipPosition = -mvPosition.xyz;
    vFogDepth = -mvPosition.z;
    vWorldPosition = worldPosition.xyz;
    vNormal = transformedNormal;
    vFragDepth = 1.0 - mvPosition.z;
    vIsPerspective = isOrthographic ? 0.0 : 1.0;
`;

const NEXT = `
#ifdef USE_SHADOWMAP
vec3 psNext = mat3(psCamera) * psNextNormal(psAt, psZ, transformedNormal);
#else
vec3 psNext = vec3(0.0);
#endif
`;

/** three derives a roughness from how nonPerturbedNormal changes from pixel to pixel; at creases,
 *  where normals jump, that would shine, so it is constant here. */
const CHUNKS = {
    map_fragment: `if ((psFlags & ${FLAGS.colors}) != 0) diffuseColor.rgb = psColor;
diffuseColor.a *= psShare;`,
    roughnessmap_fragment: `float roughnessFactor = (psFlags & ${FLAGS.materials}) != 0 ? psSurface.y : roughness;`,
    metalnessmap_fragment: `float metalnessFactor = (psFlags & ${FLAGS.materials}) != 0 ? psSurface.x : metalness;`,
    emissivemap_fragment: `if ((psFlags & ${FLAGS.materials}) != 0) totalEmissiveRadiance = psEmissive;`,
    normal_fragment_begin: `float faceDirection = 1.0;
vec3 normal = transformedNormal;
#ifdef USE_ANISOTROPY
mat3 tbn = mat3( 1.0 );
#endif
vec3 nonPerturbedNormal = vec3( 0.0, 0.0, 1.0 );`,
    clearcoat_normal_fragment_begin: `#ifdef USE_CLEARCOAT
vec3 clearcoatNormal = transformedNormal;
#endif`,
    aomap_fragment: `if ((psFlags & ${FLAGS.occlusion}) != 0) {
float ambientOcclusion = psOther.b * psScale;
reflectedLight.indirectDiffuse *= ambientOcclusion;
#if defined( USE_ENVMAP ) && defined( STANDARD )
reflectedLight.indirectSpecular *= computeSpecularOcclusion( saturate( dot( normal, normalize( vViewPosition ) ) ), ambientOcclusion, material.roughness );
#endif
}`,
    opaque_fragment: `if ((psFlags & ${FLAGS.materials}) != 0) outgoingLight = mix( outgoingLight, psColor, psSurface.z );
#include <opaque_fragment>`,
    logdepthbuf_fragment: `#include <logdepthbuf_fragment>
if ( isOrthographic ) gl_FragDepth = psHostDepth;`,
    color_fragment: '', alphamap_fragment: '', alphatest_fragment: '', alphahash_fragment: '', normal_fragment_maps: '',
    clearcoat_normal_fragment_maps: '',
};

function expand(source) {
    return source.replace(/^[ \t]*#include +<([\w\d./]+)>/gm, (_, name) => expand(ShaderChunk[name]));
}

/** @returns three's chunk that finds where a point lies in shadow maps, with our lift. */
function shadowCoordinates() {
    let chunk = ShaderChunk.shadowmap_vertex;
    for (const [kind, matrix, lift] of [['directionalLight', 'directionalShadow', 'psLift'], ['spotLight', 'spotLight', 'psLift'], ['pointLight', 'pointShadow', 'psLiftOfPoint']]) {
        const shadow = `${kind}Shadows[ i ]`;
        chunk = chunk.replaceAll(`shadowWorldNormal * ${shadow}.shadowNormalBias`,
            `${lift}( shadowWorldNormal, psNext, ${shadow}.shadowNormalBias, ${matrix}Matrix[ i ], ${shadow}.shadowMapSize, ${shadow}.shadowRadius, worldPosition )`);
    }
    return chunk;
}

/** @returns the fragment shader of one of three's materials as a resolve pass. */
export function resolveFragment(source) {
    const hasShadows = source.includes('<shadowmap_pars_fragment>');
    let text = source;
    for (const [name, chunk] of Object.entries(CHUNKS)) text = text.replace(`#include <${name}>`, () => chunk);
    text = expand(text).replace(/^([ \t]*)(?:flat\s+)?varying\s+(?:highp\s+|mediump\s+|lowp\s+)?(\w+)\s+(\w+)/gm,
        (_, space, type, name) => (HANDED_ON[name] ? `${space}const int psNo_${name} = 0` : `${space}${type} ${name}`));
    text = text.replace('void main() {', () => COVERAGE + (hasShadows ? POINTS + SHADOWS + START + NEXT + expand(shadowCoordinates()) : START));
    const handed = Object.entries(HANDED_ON).map(([name, type]) => `${type} ${name};\n`).join('');
    return DECLARATIONS + handed + text;
}

const uniformsOf = new WeakMap();

/** @returns the uniforms of a material's resolve pass. The material becomes one at first: it must
 *  not be that of an ordinary mesh. */
export function resolveUniforms(material) {
    if (uniformsOf.has(material)) return uniformsOf.get(material);
    const names = {
        psTarget0: null, psTarget1: null, psTarget2: null, psTarget3: null, psDepth: null, psFlags: 0, psUnproject: new Matrix4(), psCamera: new Matrix4(),
        psToHost: new Vector2(), psOrigin: new Vector2(), psRect: new Vector4(), psTolerance: 0, psOwners: null, psNumber: 0, psFine: null, psIsSmooth: false,
    };
    const uniforms = Object.fromEntries(Object.entries(names).map(([name, value]) => [name, { value }]));
    uniformsOf.set(material, uniforms);
    const before = material.onBeforeCompile, key = material.customProgramCacheKey;
    material.onBeforeCompile = (shader, renderer) => {
        before.call(material, shader, renderer);
        Object.assign(shader.uniforms, uniforms);
        shader.vertexShader = VERTEX;
        shader.fragmentShader = resolveFragment(shader.fragmentShader);
    };
    material.customProgramCacheKey = () => `PhongSplats ${before} ${key.call(material)}`;
    material.needsUpdate = true;
    return uniforms;
}

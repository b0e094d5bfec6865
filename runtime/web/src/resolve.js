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

const DECLARATIONS = `
uniform highp sampler2D psTarget0, psTarget1, psTarget2, psTarget3, psDepth;
uniform highp int psFlags;
uniform mat4 psUnproject, psCamera;
uniform vec2 psToHost, psOrigin;
uniform float psTolerance;
#define HAS_NORMAL
`;

/** The point is lifted off the surface by a texel and a half of the shadow map, and more where three
 *  filters over more of them, so that a slope within a texel casts no shadow, and by the distance
 *  that splats of one surface lie apart (shading.glsl does the same). */
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
float psLift(mat4 m, vec2 size, float radius, vec4 at) {
    vec4 p = m * at;
    vec3 x = vec3(m[0].x, m[1].x, m[2].x), w = vec3(m[0].w, m[1].w, m[2].w);
    float texels = length(x - w * (p.x / p.w)) * size.x / abs(p.w);
    return (1.5 + radius) / max(texels, 1e-30) + psTolerance;
}
float psLiftOfPoint(mat4 m, vec2 size, float radius, vec4 at) {
    return (1.5 + radius) * 2.0 * length((m * at).xyz) / size.x + psTolerance;
}
`;

const START = `
void main() {
    ivec2 psAt = ivec2(gl_FragCoord.xy - psOrigin);
    vec4 psSum = texelFetch(psTarget0, psAt, 0), psOther = texelFetch(psTarget1, psAt, 0);
    float psBehind = texelFetch(psDepth, psAt, 0).r;
    if (!(psBehind < 1.0 && psSum.a > 0.0)) discard;
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

/** three derives a roughness from how nonPerturbedNormal changes from pixel to pixel; at creases,
 *  where normals jump, that would shine, so it is constant here. */
const CHUNKS = {
    map_fragment: `if ((psFlags & ${FLAGS.colors}) != 0) diffuseColor.rgb = psColor;`,
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
        const bias = `${kind}Shadows[ i ].shadowNormalBias`;
        chunk = chunk.replaceAll(bias, `( ${bias} + ${lift}( ${matrix}Matrix[ i ], ${kind}Shadows[ i ].shadowMapSize, ${kind}Shadows[ i ].shadowRadius, worldPosition ) )`);
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
    text = text.replace('void main() {', () => (hasShadows ? SHADOWS + START + expand(shadowCoordinates()) : START));
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
        psToHost: new Vector2(), psOrigin: new Vector2(), psRect: new Vector4(), psTolerance: 0,
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

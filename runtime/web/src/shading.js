// SPDX-License-Identifier: MIT
//
// shading.js - the shadings of the C runtime (shaders/resolve_*.glsl) as a material of splats, in
// place of one of three's: to see normals or overdraw, or to compare with the runtime.
import { FrontSide, GLSL3, LessEqualDepth, Matrix3, Matrix4, NoBlending, RawShaderMaterial, Vector2, Vector3, Vector4 } from 'three';
import { PRELUDE } from './programs.js';
import { OWNED, VERTEX } from './resolve.js';
import { shaders } from './shaders.js';

const READS_LIGHT = new Set(['lit', 'toon']), READS_COLOR = new Set(['lit', 'toon', 'unlit']);

/** The light of `phongsplat render`: from behind the camera, and ambient. */
const LIGHT = new Vector3(-0.15, 0.65, 0.85).normalize(), IRRADIANCE = 0.85 * Math.PI, AMBIENT = 0.12;

const END = `${OWNED}
void main() {
    if (!psIsOwned(ivec2(gl_FragCoord.xy) - u_origin)) discard;
    psMain();
}
`;

const SHADINGS = ['lit', 'unlit', 'toon', 'normal', 'depth', 'overdraw', 'splats'];

export class SplatShadingMaterial extends RawShaderMaterial {
    /** @param {'lit'|'unlit'|'toon'|'normal'|'depth'|'overdraw'|'splats'} shading */
    constructor(shading = 'normal') {
        if (!SHADINGS.includes(shading)) throw new Error(`PhongSplats: unknown shading ${shading}`);
        const file = shaders[`resolve_${shading}.glsl`], defines = {
            LIGHT_COUNT: READS_LIGHT.has(shading) ? 1 : 0, PUNCTUAL: 0, ENVIRONMENT: 0, SHADOWS: 0, AS_IS: 0, COLORS: 0, MATERIALS: 0, OCCLUSION: 0,
            HALF_TARGETS: 0, ENCODE: 1,
        };
        super({
            name: `PhongSplats ${shading}`, glslVersion: GLSL3, vertexShader: PRELUDE + VERTEX, defines, blending: NoBlending, depthFunc: LessEqualDepth,
            fragmentShader: PRELUDE + shaders['layout.h'] + shaders['shading.glsl'] + '#define main psMain\n' + shaders['resolve.frag'] + '#undef main\n' + file + END,
            uniforms: Object.fromEntries(Object.entries({
                psRect: new Vector4(), psOwners: null, psNumber: 0, u_target0: null, u_target1: null, u_target2: null, u_target3: null, u_depth: null, u_origin: new Vector2(),
                u_to_host: new Vector2(), u_base_color: new Vector3(1, 1, 1), u_emissive: new Vector3(), u_surface: new Vector3(),
                u_ray: new Matrix3(), u_unproject: new Matrix4(), u_planes: new Vector3(), u_ambient: new Vector3(AMBIENT, AMBIENT, AMBIENT),
                u_light_position: [new Vector4(LIGHT.x, LIGHT.y, LIGHT.z, 0)], u_light_color: [new Vector4(IRRADIANCE, IRRADIANCE, IRRADIANCE, 0)],
                u_light_axis: [LIGHT.clone().negate()], u_light_cone: [new Vector4(0, 1, -1, 0)],
            }).map(([name, value]) => [name, { value }])),
        });
        this.side = FrontSide;
        this.shading = shading;
        this.isSplatShading = true;
        this.toneMapped = false;
    }

    /** @returns which render targets it reads of those that splats differ in. */
    reads(differ) {
        const all = READS_LIGHT.has(this.shading), colors = READS_COLOR.has(this.shading);
        return { colors: colors && differ.colors, materials: all && differ.materials, occlusion: all && differ.occlusion };
    }

    /** Sets what is not a uniform; PhongSplats calls it before each draw. */
    choose(differ, isHalf, encodes) {
        const wanted = { COLORS: +differ.colors, MATERIALS: +differ.materials, OCCLUSION: +differ.occlusion, HALF_TARGETS: +isHalf, ENCODE: +encodes };
        for (const [name, value] of Object.entries(wanted)) {
            if (this.defines[name] === value) continue;
            this.defines[name] = value;
            this.needsUpdate = true;
        }
    }

    copy(source) {
        super.copy(source);
        this.shading = source.shading;
        return this;
    }
}

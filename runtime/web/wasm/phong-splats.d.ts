// SPDX-License-Identifier: MIT
/** 16 numbers, column by column. */
export type Matrix = ArrayLike<number> & Iterable<number>;
export type Color = [number, number, number];

/** A light with the units of KHR_lights_punctual, in scene space; angles in radians. Up to 8 lights, of which the first 4
 *  directional and spot lights may cast shadows. */
export interface Light {
    type?: 'directional' | 'point' | 'spot';
    /** linear, times intensity: pi lights a white surface that faces a directional light to 1 */
    color?: Color;
    direction?: Color;
    position?: Color;
    /** where the light ends; 0: nowhere */
    range?: number;
    innerAngle?: number;
    outerAngle?: number;
    castsShadow?: boolean;
}

export interface View {
    /** from scene to eye space: a rotation and a translation */
    view: Matrix;
    /** with GL's conventions, z from -w to w */
    projection: Matrix;
    shading?: 'lit' | 'unlit' | 'toon' | 'normal' | 'depth' | 'overdraw' | 'splats';
    /** the light of `phongsplat render` where none are given */
    lights?: Light[];
    /** radiance from all directions, linear */
    ambient?: Color;
    /** of the canvas, as it is stored */
    background?: [number, number, number, number];
    /** edge of a shadow map in texels; 0: 1024 */
    shadowSize?: number;
}

/** What the runtime refuses: `code` is its psplat_result, `message` its text. */
export class PhongSplatsError extends Error {
    code: number;
}

/** A model on the GPU. */
export interface Model {
    readonly splatCount: number;
    /** a box around all splats, its centre and its half diagonal */
    readonly min: Color;
    readonly max: Color;
    readonly center: Color;
    readonly radius: number;
    /** in the order of the file; durations in seconds */
    readonly animations: readonly { readonly name: string; readonly duration: number }[];
    /** A pose at rest; only models with animations have any. */
    createPose(): Pose;
    /** Frees the model and its poses. */
    dispose(): void;
}

/** Where the parts of a model are. An item is drawn in its pose. */
export interface Pose {
    /** Moves all to where it is at a time of an animation. For a loop pass `seconds % duration`. */
    set(animation: number, seconds: number): this;
    /** Moves all to where the file has it. */
    rest(): this;
    dispose(): void;
}

export type Item = Model | { model: Model; transform?: Matrix; pose?: Pose };

export class PhongSplatsRenderer {
    static create(canvas: HTMLCanvasElement | OffscreenCanvas, options?: {
        wasm?: URL | string | BufferSource | WebAssembly.Module;
        attributes?: WebGLContextAttributes;
    }): Promise<PhongSplatsRenderer>;
    readonly gl: WebGL2RenderingContext;
    /** @param bytes of a GLB, or of a glTF that holds all its data */
    open(bytes: BufferSource): Promise<Model>;
    /** Clears the canvas and draws into all of it. */
    draw(items: Item | Item[], view: View): void;
    dispose(): void;
}

export function lookAt(eye: Color, target: Color, up?: Color): number[];
/** @param degrees the vertical angle of view
 *  @param aspect width by height */
export function perspective(degrees: number, aspect: number, near: number, far: number): number[];

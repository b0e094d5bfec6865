// SPDX-License-Identifier: MIT
//
// splats.js - splats in three's scene graph. When three comes to draw the first object, the splat passes
// of all run first (shared.js), into render targets of their own (shaders/README.md), and then three draws the object
// itself: a rectangle whose material, one of three's, is the resolve pass (resolve.js).
import {
    Box3, BufferAttribute, BufferGeometry, Color, DoubleSide, FrontSide, Matrix4, Mesh, MeshStandardMaterial, Ray, REVISION, ShaderMaterial, Sphere,
    SRGBColorSpace, Vector2, Vector3, Vector4,
} from 'three';
import { Placement, screenRect, SplatCamera } from './camera.js';
import { WALL_SHIFT } from './decode.js';
import { findMaterial, PASS, surfaceOf } from './programs.js';
import { raycastSplats } from './raycast.js';
import { FLAGS, resolveUniforms } from './resolve.js';
import { takeFrame } from './shared.js';
import { disposeTargets } from './targets.js';

// How far a patch may be from its tangent plane where that is drawn in its place: in pixels, and as
// a part of the depth tolerance (batches.c).
const MAX_FLAT_PIXELS = 0.125, MAX_FLAT_TOLERANCE = 0.25;
// How many pixels a splat make rectangles pay, in Chromium's software.
const PIXELS_FOR_BOXES = 200;

/** Releases before this one keep shadow maps as colours, not as depths. */
const NATIVE_SHADOWS = 182;

const viewport = new Vector4(), rect = new Vector4(), corners = new Vector4(), size = new Vector2(), inverse = new Matrix4();
const localRay = new Ray(), camera2 = new SplatCamera(), white = { isMeshStandardMaterial: true, color: new Color(1, 1, 1) };

/** The geometry of a pass: nothing but a number of vertices. */
function bareGeometry(count) {
    const geometry = new BufferGeometry();
    geometry.setDrawRange(0, count);
    geometry.boundingSphere = new Sphere(new Vector3(), Infinity);
    return geometry;
}

/** The corners of a box, of which the first four are also the rectangle that is drawn. */
function boxGeometry(box) {
    const positions = new Float32Array(24), geometry = new BufferGeometry();
    for (let k = 0; k < 8; ++k) {
        positions.set([k & 1 ? box.max.x : box.min.x, k & 2 ? box.max.y : box.min.y, k & 4 ? box.max.z : box.min.z], 3 * k);
    }
    geometry.setAttribute('position', new BufferAttribute(positions, 3));
    geometry.setIndex([0, 1, 2, 2, 1, 3]);
    geometry.boundingBox = box.clone();
    geometry.boundingSphere = box.getBoundingSphere(new Sphere());
    return geometry;
}

/** What three draws for the object itself into a shadow map: nothing, its splats are there already. */
function hiddenMaterial() {
    const material = new ShaderMaterial({ vertexShader: 'void main() { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); }', fragmentShader: 'void main() { gl_FragColor = vec4(1.0); }' });
    material.colorWrite = material.depthWrite = false;
    return material;
}
const hiddenDepth = hiddenMaterial(), hiddenDistance = hiddenMaterial();

/** @returns whether a curved batch has to be drawn as such. */
function showsCurvature(batch, placement, camera) {
    return batch.isCurved && batch.sagitta > MAX_FLAT_TOLERANCE * batch.depthTolerance &&
        placement.pixels(batch.bounds, batch.sagitta, camera.width, camera.height) > MAX_FLAT_PIXELS;
}

/** @returns whether flat splats had better be drawn as rectangles around what clip lines leave of them than as triangles
 *  around all: where lines cut half of them or more and there are many pixels for each. That saves fragments at the cost
 *  of vertices. A box that is d across covers some d * d / 6 pixels of the square of what pixels() finds. */
function paysBoxes(batch, placement, camera) {
    if (2 * batch.cutCount < batch.count || batch.clipLines === batch.seamLines) return false;
    const across = batch.bounds.min.distanceTo(batch.bounds.max), part = 0.01;
    const pixels = placement.pixels(batch.bounds, part * across, camera.width, camera.height) / part;
    return pixels * pixels / 6 > PIXELS_FOR_BOXES * batch.count;
}

export class PhongSplats extends Mesh {
    /** @param batches what decodePrimitive returns, with materials of their own in `materials`
     *  where they do not all have the object's.
     *  @param material the object's: no ordinary mesh may have the same. */
    constructor(batches = [], material = new MeshStandardMaterial(), materials = null) {
        const box = new Box3();
        for (const batch of batches) box.union(batch.box);
        super(boxGeometry(box), material);
        this.type = 'PhongSplats';
        this.isPhongSplats = true;
        this.pictureSize = new Vector2(); // of the last picture that showed the object, pixels
        this.setBatches(batches, material, materials);
        this.customDepthMaterial = hiddenDepth;
        this.customDistanceMaterial = hiddenDistance; // of point lights
    }

    setBatches(batches, material, materials) {
        this.batches = batches;
        this.materials = materials;
        this.surfaceMaterial = material; // of batches, while a SplatShadingMaterial takes its place
        this.placements = batches.map(() => new Placement());
        this.passMeshes = [];
        this.splatCount = batches.reduce((sum, batch) => sum + batch.count, 0);
        for (const batch of batches) batch.geometries ??= { 3: bareGeometry(3 * batch.count), 6: bareGeometry(6 * batch.count) };
    }

    copy(source, recursive) {
        super.copy(source, recursive);
        this.setBatches(source.batches, source.surfaceMaterial, source.materials);
        this.customDepthMaterial = hiddenDepth;
        this.customDistanceMaterial = hiddenDistance; // of point lights
        return this;
    }

    /** @returns the material that says what a batch looks like. */
    materialOf(batch) {
        const own = this.materials?.[this.batches.indexOf(batch)];
        if (own) return own;
        if (!this.material.isSplatShading) this.surfaceMaterial = this.material;
        return this.surfaceMaterial.color ? this.surfaceMaterial : white;
    }

    isTwoSided(batch) {
        return this.materialOf(batch).side === DoubleSide;
    }

    // ---- drawing ---------------------------------------------------------------------------

    /** Places the batches in a view and adds them to its depths. Singular ones get no part in it. */
    place(camera, span) {
        this.isPlaced = this.batches.map((batch, k) => {
            const placement = this.placements[k], isPlaced = placement.set(this.matrixWorld, camera.view);
            const shift = 2 * batch.depthTolerance * (batch.isCurved ? WALL_SHIFT : 1); // at grazing angles
            if (isPlaced) span?.add(placement.modelview, camera.host, batch.bounds, shift * placement.scale);
            return isPlaced;
        });
    }

    project(camera) {
        this.batches.forEach((batch, k) => { if (this.isPlaced[k]) this.placements[k].project(camera.projection, batch.bounds); });
    }

    /** @returns the material of a batch's pass. */
    findPass(batch, k, camera, view) {
        const placement = this.placements[k], isCurved = showsCurvature(batch, placement, camera);
        const isBoxed = !isCurved && paysBoxes(batch, placement, camera);
        const pass = findMaterial(batch, this.materialOf(batch), { ...view, isCurved, isBoxed, isNear: placement.isNear, isTwoSided: view.isTwoSided ?? this.isTwoSided(batch) });
        pass.vertices = isCurved || isBoxed ? 6 : 3;
        return pass;
    }

    /** Makes a batch's pass ready to be drawn. Clones have the same passes. */
    prepare(pass, batch, k, camera) {
        pass.use(batch, this.materialOf(batch));
        camera.apply(pass.uniforms, this.placements[k], batch.depthTolerance);
    }

    /** Puts the batches of a pass into a scene of passes, with the object's number there. */
    addPass(scene, camera, view, order, number) {
        let first = 0;
        this.batches.forEach((batch, k) => {
            const index = first, pass = this.isPlaced[k] ? this.findPass(batch, k, camera, view) : null;
            first += batch.count;
            if (!pass) return;
            const mesh = (this.passMeshes[2 * k + order] ??= new Mesh());
            Object.assign(mesh, { geometry: batch.geometries[pass.vertices], material: pass, frustumCulled: false, renderOrder: order });
            mesh.matrixWorld.copy(this.matrixWorld);
            mesh.onBeforeRender = () => {
                this.prepare(pass, batch, k, camera);
                pass.uniforms.u_first_index.value = index;
                pass.uniforms.u_apart.value = view.pass === PASS.parameters ? 2 ** -14 : 0;
                pass.uniforms.u_owner.value.set((number & 255) / 255, (number >> 8) / 255);
            };
            scene.children.push(mesh);
        });
    }

    onBeforeRender(renderer, scene, camera, geometry, material) {
        // Under a scene's overrideMaterial there is nothing to draw: no other material can be a resolve pass.
        geometry.setDrawRange(0, material === this.material ? 6 : 0);
        if (material !== this.material) return;
        if (camera.viewport) viewport.copy(camera.viewport);
        else renderer.getCurrentViewport(viewport);
        this.pictureSize.set(viewport.z, viewport.w);
        if (this.parent?.isPhongSplatsLOD) this.parent.noteRenderer(camera, renderer);
        const { frame, id } = takeFrame(this, renderer, scene, camera, viewport);
        this.findRect(viewport.z, viewport.w, rect);
        // three turns front faces with the object's matrix; the rectangle is turned along.
        if ((this.matrixWorld.determinant() < 0) !== (this.material.side !== FrontSide && this.material.side !== DoubleSide)) rect.set(rect.z, rect.y, rect.x, rect.w);
        // Clones may follow each other with one material, whose uniforms three would not set again.
        renderer.setRenderTarget(renderer.getRenderTarget(), renderer.getActiveCubeFace(), renderer.getActiveMipmapLevel());
        if (camera.viewport) renderer.state.viewport(camera.viewport);
        const u = material.isSplatShading ? this.setShading(renderer, material, frame) : this.setResolve(material, frame, camera);
        u.psRect.value.copy(rect);
        u.psOwners.value = frame.owners.texture;
        u.psNumber.value = id;
        material.uniformsNeedUpdate = true;
    }

    /** Alpha that says how many samples are covered stays in them; where the background is opaque it becomes 1 again. */
    onAfterRender(renderer, scene, camera, geometry, material) {
        if (!material.alphaToCoverage || material !== this.material || material.isSplatShading) return;
        if (renderer.getClearAlpha() < 1 && !scene.background) return;
        const gl = renderer.getContext(), { colorWrite } = material;
        gl.colorMask(false, false, false, true);
        gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 1]);
        gl.colorMask(colorWrite, colorWrite, colorWrite, colorWrite);
    }

    /** Finds the pixels, -1 ... 1, that the splats may cover; none are 0, 0, 0, 0. */
    findRect(width, height, out) {
        out.set(1, 1, -1, -1);
        this.batches.forEach((batch, k) => {
            if (!this.isPlaced[k]) return;
            screenRect(this.placements[k].clip, batch.bounds, width, height, corners);
            out.set(Math.min(out.x, corners.x), Math.min(out.y, corners.y), Math.max(out.z, corners.z), Math.max(out.w, corners.w));
        });
        if (!(out.z > out.x && out.w > out.y)) out.set(0, 0, 0, 0);
    }

    /** @returns the uniforms of a material of three's as a resolve pass. */
    setResolve(material, frame, camera) {
        const u = resolveUniforms(material), { textures, depthTexture } = frame.target, { differ, isHalf, eye } = frame;
        for (let k = 0; k < 4; ++k) u[`psTarget${k}`].value = textures[k] ?? textures[0];
        u.psDepth.value = depthTexture;
        u.psFine.value = frame.fine?.depthTexture ?? depthTexture;
        u.psIsSmooth.value = !!frame.fine;
        u.psFlags.value = (differ.colors ? FLAGS.colors : 0) | (differ.materials ? FLAGS.materials : 0) | (differ.occlusion ? FLAGS.occlusion : 0) | (isHalf ? FLAGS.half : 0);
        u.psUnproject.value.copy(eye.unproject);
        u.psCamera.value.copy(camera.matrixWorld);
        u.psToHost.value.copy(eye.toHost);
        u.psOrigin.value.set(viewport.x, viewport.y);
        const scale = Math.cbrt(Math.abs(this.matrixWorld.determinant()));
        u.psTolerance.value = 2 * scale * this.batches.reduce((most, batch) => Math.max(most, batch.depthTolerance), 0);
        return u;
    }

    /** @returns the uniforms of a shading of the C runtime. */
    setShading(renderer, material, frame) {
        const u = material.uniforms, { textures, depthTexture } = frame.target, { eye } = frame;
        material.choose(material.reads(frame.differ), frame.isHalf, renderer.getRenderTarget() === null && renderer.outputColorSpace === SRGBColorSpace);
        for (let k = 0; k < 4; ++k) u[`u_target${k}`].value = textures[k] ?? textures[0];
        u.u_depth.value = depthTexture;
        u.u_origin.value.set(viewport.x, viewport.y);
        u.u_to_host.value.copy(eye.toHost);
        u.u_ray.value.copy(eye.ray);
        u.u_unproject.value.copy(eye.unproject);
        u.u_planes.value.copy(eye.planes);
        if (this.batches.length) {
            const surface = surfaceOf(this.materialOf(this.batches[0]));
            u.u_base_color.value.setFromColor(surface.color);
            u.u_surface.value.set(surface.metallic, surface.roughness, surface.unlit);
            if (surface.emissive) u.u_emissive.value.setFromColor(surface.emissive).multiplyScalar(surface.emissiveIntensity);
        }
        return u;
    }

    // ---- shadows ---------------------------------------------------------------------------

    /** Draws the splats into a shadow map; backs cast shadows too (section 5.6). Those of a light are
     *  shifted away from it by their tolerance, which keeps a surface from casting shadows on
     *  itself. */
    onBeforeShadow(renderer, object, camera, shadowCamera, geometry, depthMaterial) {
        const target = renderer.getRenderTarget(), isReversed = renderer.state.buffers.depth.getReversed?.() === true;
        const isOld = Number.parseInt(REVISION, 10) < NATIVE_SHADOWS;
        const isPoint = isOld && depthMaterial === hiddenDistance;
        size.set(target.width / (isPoint ? 4 : 1), target.height / (isPoint ? 2 : 1)); // old ones have the six faces side by side
        camera2.set(shadowCamera, size.x, size.y, isReversed);
        this.place(camera2, null); // with the depths that the shadow map has
        this.project(camera2);
        const view = { pass: PASS.visibility, differ: {}, isHalf: false, isTwoSided: true, isReversed, packs: isOld ? (isPoint ? 'distance' : 'depth') : '' };
        this.batches.forEach((batch, k) => {
            if (!this.isPlaced[k]) return;
            const material = this.findPass(batch, k, camera2, view);
            this.prepare(material, batch, k, camera2);
            material.uniforms.u_near_far.value.set(shadowCamera.near, shadowCamera.far);
            renderer.renderBufferDirect(shadowCamera, null, batch.geometries[material.vertices], material, this, null);
        });
    }

    // ---- the rest --------------------------------------------------------------------------

    raycast(raycaster, intersects) {
        if (this.geometry.boundingSphere.radius < 0) return;
        localRay.copy(raycaster.ray);
        inverse.copy(this.matrixWorld).invert();
        localRay.origin.applyMatrix4(inverse);
        localRay.direction.copy(raycaster.ray.direction).transformDirection(inverse);
        const found = raycastSplats(this.batches, localRay, (batch) => this.isTwoSided(batch));
        if (!found) return;
        const point = localRay.at(found.t, new Vector3()).applyMatrix4(this.matrixWorld);
        const distance = raycaster.ray.origin.distanceTo(point);
        if (distance < raycaster.near || distance > raycaster.far) return;
        intersects.push({ distance, point, object: this, normal: found.normal, face: { a: 0, b: 0, c: 0, normal: found.normal, materialIndex: 0 },
            faceIndex: null, batchIndex: this.batches.indexOf(found.batch), splatIndex: found.index, uv: new Vector2(found.u, found.v) });
    }

    /** Frees the splats' textures and programs, also those of clones, which share them. The material
     *  and its textures are the caller's. */
    dispose() {
        for (const batch of this.batches) {
            for (const texture of [batch.splats, batch.clips, batch.finishes, batch.texcoords]) texture?.dispose();
            for (const material of batch.variants?.values() ?? []) material.dispose();
            for (const geometry of Object.values(batch.geometries)) geometry.dispose();
        }
        this.geometry.dispose();
    }

    /** Frees what all splats share with one renderer. */
    static disposeTargets(renderer) {
        disposeTargets(renderer);
    }
}

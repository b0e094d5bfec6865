// SPDX-License-Identifier: MIT
//
// splats.js - splats in three's scene graph. When three comes to draw the object, the splat passes
// run first, into render targets of their own (shaders/README.md), and then three draws the object
// itself: a rectangle whose material, one of three's, is the resolve pass (resolve.js).
import {
    Box3, BufferAttribute, BufferGeometry, Camera, Color, DoubleSide, FrontSide, Matrix4, Mesh, MeshStandardMaterial, Ray, REVISION, Scene, ShaderMaterial, Sphere,
    SRGBColorSpace, Vector2, Vector3, Vector4,
} from 'three';
import { DepthSpan, Placement, screenRect, SplatCamera } from './camera.js';
import { differences, findMaterial, PASS, surfaceOf } from './programs.js';
import { raycastSplats } from './raycast.js';
import { FLAGS, resolveUniforms } from './resolve.js';
import { disposeTargets, findTarget, usesHalves } from './targets.js';

// How far a patch may be from its tangent plane where that is drawn in its place: in pixels, and as
// a part of the depth tolerance (batches.c).
const MAX_FLAT_PIXELS = 0.125, MAX_FLAT_TOLERANCE = 0.25;

/** Releases before this one keep shadow maps as colours, not as depths. */
const NATIVE_SHADOWS = 182;

const passes = new Scene(), passCamera = new Camera();
passes.matrixWorldAutoUpdate = false;
passCamera.matrixWorldAutoUpdate = false;

const viewport = new Vector4(), rect = new Vector4(), size = new Vector2(), clearColor = new Color(), inverse = new Matrix4();
const localRay = new Ray(), camera1 = new SplatCamera(), camera2 = new SplatCamera(), white = { isMeshStandardMaterial: true, color: new Color(1, 1, 1) };

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
        this.setBatches(batches, material, materials);
        this.customDepthMaterial = hiddenDepth;
        this.customDistanceMaterial = hiddenDistance; // of point lights
    }

    setBatches(batches, material, materials) {
        this.batches = batches;
        this.materials = materials;
        this.surfaceMaterial = material; // of batches, while a SplatShadingMaterial takes its place
        this.placements = batches.map(() => new Placement());
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

    /** Places the batches and fits the depth range to them. Singular ones get no part in it. */
    place(camera) {
        const span = new DepthSpan();
        this.isPlaced = this.batches.map((batch, k) => {
            const placement = this.placements[k], isPlaced = placement.set(this.matrixWorld, camera.view);
            if (isPlaced) span.add(placement.modelview, camera.host, batch.bounds, 2 * batch.depthTolerance * placement.scale);
            return isPlaced;
        });
        camera.fit(span.isEmpty ? null : span);
        this.batches.forEach((batch, k) => { if (this.isPlaced[k]) this.placements[k].project(camera.projection, batch.bounds); });
    }

    /** @returns the material of a batch's pass, ready to be drawn. */
    prepare(batch, k, camera, view) {
        const material = this.materialOf(batch), placement = this.placements[k];
        const isCurved = showsCurvature(batch, placement, camera);
        const pass = findMaterial(batch, material, { ...view, isCurved, isNear: placement.isNear, isTwoSided: view.isTwoSided ?? this.isTwoSided(batch) });
        pass.vertices = isCurved ? 6 : 3;
        pass.use(batch, material);
        camera.apply(pass.uniforms, placement, batch.depthTolerance);
        return pass;
    }

    /** Puts the batches of a pass into the scene of passes. */
    addPass(camera, view, order) {
        let first = 0;
        this.batches.forEach((batch, k) => {
            const index = first;
            first += batch.count;
            if (!this.isPlaced[k]) return;
            const material = this.prepare(batch, k, camera, view);
            material.uniforms.u_first_index.value = index;
            material.uniforms.u_apart.value = view.pass === PASS.parameters ? 2 ** -14 : 0;
            material.mesh ??= new Mesh(batch.geometries[material.vertices], material);
            material.mesh.frustumCulled = false;
            material.mesh.renderOrder = order;
            material.mesh.matrixWorld.copy(this.matrixWorld);
            passes.children.push(material.mesh);
        });
    }

    /** Runs the passes into a target, within the rectangle of `rect`. */
    drawPasses(renderer, target) {
        const old = { target: renderer.getRenderTarget(), face: renderer.getActiveCubeFace(), level: renderer.getActiveMipmapLevel(), alpha: renderer.getClearAlpha(),
            autoClear: renderer.autoClear, shadows: renderer.shadowMap.autoUpdate, xr: renderer.xr.enabled, reset: renderer.info.autoReset, tone: renderer.toneMapping };
        const depth = renderer.state.buffers.depth, isReversed = depth.getReversed?.() === true;
        renderer.getClearColor(clearColor);
        renderer.autoClear = true;
        renderer.shadowMap.autoUpdate = renderer.xr.enabled = renderer.info.autoReset = false;
        renderer.setClearColor(0, 0);
        if (isReversed) depth.setReversed(false);
        renderer.setRenderTarget(target);
        renderer.render(passes, passCamera);
        if (isReversed) depth.setReversed(true);
        renderer.setRenderTarget(old.target, old.face, old.level);
        renderer.setClearColor(clearColor, old.alpha);
        renderer.autoClear = old.autoClear;
        renderer.shadowMap.autoUpdate = old.shadows;
        renderer.xr.enabled = old.xr;
        renderer.info.autoReset = old.reset;
    }

    onBeforeRender(renderer, scene, camera, geometry, material) {
        // Under a scene's overrideMaterial there is nothing to draw: no other material can be a resolve pass.
        geometry.setDrawRange(0, material === this.material ? 6 : 0);
        if (material !== this.material) return;
        if (camera.viewport) viewport.copy(camera.viewport);
        else renderer.getCurrentViewport(viewport);
        const width = viewport.z, height = viewport.w, isHalf = usesHalves(renderer), isShading = !!material.isSplatShading;
        camera1.set(camera, width, height, renderer.state.buffers.depth.getReversed?.() === true);
        this.place(camera1);
        const all = this.batches.length ? differences(this.batches, (batch) => this.materialOf(batch)) : { colors: false };
        const differ = isShading ? material.reads(all) : all;
        const target = findTarget(renderer, differ.materials ? 4 : differ.colors ? 3 : 2, isHalf, width, height);
        if (this.findRect(width, height, target)) {
            const view = { pass: isShading && material.shading === 'splats' ? PASS.parameters : PASS.normals, differ, isHalf, counts: isShading && material.shading === 'overdraw' };
            if (view.pass === PASS.normals) this.addPass(camera1, { ...view, pass: PASS.visibility }, 0);
            this.addPass(camera1, view, 1);
            this.drawPasses(renderer, target);
            passes.children.length = 0;
            if (camera.viewport) renderer.state.viewport(camera.viewport);
        }
        if (isShading) this.setShading(renderer, material, target, differ, isHalf);
        else this.setResolve(material, target, camera, differ, isHalf);
    }

    /** Finds the pixels that the splats may cover. @returns whether there are any. */
    findRect(width, height, target) {
        const at = new Vector4();
        rect.set(1, 1, -1, -1);
        this.batches.forEach((batch, k) => {
            if (!this.isPlaced[k]) return;
            screenRect(this.placements[k].clip, batch.bounds, width, height, at);
            rect.set(Math.min(rect.x, at.x), Math.min(rect.y, at.y), Math.max(rect.z, at.z), Math.max(rect.w, at.w));
        });
        const isSeen = rect.z > rect.x && rect.w > rect.y;
        if (!isSeen) rect.set(0, 0, 0, 0);
        const x = Math.floor((0.5 * rect.x + 0.5) * width), y = Math.floor((0.5 * rect.y + 0.5) * height);
        target.viewport.set(0, 0, width, height);
        target.scissor.set(x, y, Math.ceil((0.5 * rect.z + 0.5) * width) - x, Math.ceil((0.5 * rect.w + 0.5) * height) - y);
        // three turns front faces with the object's matrix; the rectangle is turned along.
        if ((this.matrixWorld.determinant() < 0) !== (this.material.side !== FrontSide && this.material.side !== DoubleSide)) rect.set(rect.z, rect.y, rect.x, rect.w);
        return isSeen;
    }

    setResolve(material, target, camera, differ, isHalf) {
        const u = resolveUniforms(material), textures = target.textures;
        for (let k = 0; k < 4; ++k) u[`psTarget${k}`].value = textures[k] ?? textures[0];
        u.psDepth.value = target.depthTexture;
        u.psFlags.value = (differ.colors ? FLAGS.colors : 0) | (differ.materials ? FLAGS.materials : 0) | (differ.occlusion ? FLAGS.occlusion : 0) | (isHalf ? FLAGS.half : 0);
        u.psUnproject.value.copy(camera1.unproject);
        u.psCamera.value.copy(camera.matrixWorld);
        u.psToHost.value.copy(camera1.toHost);
        u.psOrigin.value.set(viewport.x, viewport.y);
        u.psRect.value.copy(rect);
        const scale = Math.cbrt(Math.abs(this.matrixWorld.determinant()));
        u.psTolerance.value = 2 * scale * this.batches.reduce((most, batch) => Math.max(most, batch.depthTolerance), 0);
    }

    setShading(renderer, material, target, differ, isHalf) {
        const u = material.uniforms, textures = target.textures;
        material.choose(differ, isHalf, renderer.getRenderTarget() === null && renderer.outputColorSpace === SRGBColorSpace);
        for (let k = 0; k < 4; ++k) u[`u_target${k}`].value = textures[k] ?? textures[0];
        u.u_depth.value = target.depthTexture;
        u.u_origin.value.set(viewport.x, viewport.y);
        u.u_to_host.value.copy(camera1.toHost);
        u.u_ray.value.copy(camera1.ray);
        u.u_unproject.value.copy(camera1.unproject);
        u.u_planes.value.copy(camera1.planes);
        u.psRect.value.copy(rect);
        if (this.batches.length) {
            const surface = surfaceOf(this.materialOf(this.batches[0]));
            u.u_base_color.value.setFromColor(surface.color);
            u.u_surface.value.set(surface.metallic, surface.roughness, surface.unlit);
            if (surface.emissive) u.u_emissive.value.setFromColor(surface.emissive).multiplyScalar(surface.emissiveIntensity);
        }
        material.uniformsNeedUpdate = true;
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
        this.place2(camera2);
        const view = { pass: PASS.visibility, differ: {}, isHalf: false, isTwoSided: true, isReversed, packs: isOld ? (isPoint ? 'distance' : 'depth') : '' };
        this.batches.forEach((batch, k) => {
            if (!this.isPlaced[k]) return;
            const material = this.prepare(batch, k, camera2, view);
            material.uniforms.u_near_far.value.set(shadowCamera.near, shadowCamera.far);
            renderer.renderBufferDirect(shadowCamera, null, batch.geometries[material.vertices], material, this, null);
        });
    }

    /** Like place(), with the depths that the shadow map has. */
    place2(camera) {
        this.isPlaced = this.batches.map((batch, k) => {
            const isPlaced = this.placements[k].set(this.matrixWorld, camera.view);
            if (isPlaced) this.placements[k].project(camera.projection, batch.bounds);
            return isPlaced;
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

// SPDX-License-Identifier: MIT
//
// shared.js - the splat passes of one render of three's, for all objects at once, so that splats of
// different objects blend where they touch, as the C runtime's do. The visibility pass also says
// which object has the nearest splat of a pixel: its material resolves the pixel.
import { Color, Scene, Camera, Vector4 } from 'three';
import { DepthSpan, SplatCamera } from './camera.js';
import { differences, PASS } from './programs.js';
import { findDepths, findTarget, usesHalves } from './targets.js';

const passes = new Scene(), passCamera = new Camera(), clearColor = new Color(), rect = new Vector4();
passes.matrixWorldAutoUpdate = false;
passCamera.matrixWorldAutoUpdate = false;

/** Shadings that do not blend splats, or count those of one object. */
const ALONE = new Set(['splats', 'overdraw']);

/** @returns whether an object may share its passes: what three would discard, or draw in another order
 *  than by depth, must not hide other objects. */
function canShare(object, renderer) {
    const { material } = object;
    return !material.transparent && material.visible && material.depthTest && material.depthWrite && material.colorWrite &&
        !material.clippingPlanes?.length && !renderer.clippingPlanes.length && !ALONE.has(material.shading);
}

/** @returns the objects that a render will draw together with one of them. */
function membersOf(object, renderer, scene, camera) {
    const members = [];
    if (!canShare(object, renderer)) return [object];
    scene.traverseVisible((other) => {
        if (other.isPhongSplats && other.batches.length && other.layers.test(camera.layers) && canShare(other, renderer)) members.push(other);
    });
    return members.includes(object) ? members : [object];
}

/** @returns whether three draws with several samples a pixel, and textures may be so large. */
function hasSamples(renderer, size) {
    const target = renderer.getRenderTarget(), samples = target ? target.samples : renderer.getContext().getContextAttributes()?.antialias ? 4 : 0;
    return samples > 0 && size <= renderer.capabilities.maxTextureSize;
}

/** What the last passes of a renderer have drawn. */
class Frame {
    constructor() {
        this.eye = new SplatCamera();
        this.fineEye = new SplatCamera(); // of as many pixels twice in each direction
        this.ids = new Map(); // of objects that three has not drawn since, from 1
    }

    /** @returns whether the targets hold an object as three is about to draw it. */
    holds(object, renderer, scene, camera) {
        return this.ids.has(object) && this.number === renderer.info.render.frame && this.scene === scene && this.camera === camera;
    }

    /** Draws the passes of an object and of those that it shares them with. */
    draw(object, renderer, scene, camera, viewport) {
        const members = membersOf(object, renderer, scene, camera), { eye } = this, width = viewport.z, height = viewport.w;
        eye.set(camera, width, height, renderer.state.buffers.depth.getReversed?.() === true);
        this.place(members);
        this.isHalf = usesHalves(renderer);
        this.differ = differencesOf(members);
        this.isShared = members.length > 1;
        const { target, owners } = findTarget(renderer, this.differ.materials ? 4 : this.differ.colors ? 3 : 2, this.isHalf, width, height);
        this.target = target;
        this.owners = owners;
        this.fine = members.some(({ material }) => material.alphaToCoverage) && hasSamples(renderer, 2 * Math.max(width, height)) ? findDepths(renderer, 2 * width, 2 * height) : null;
        if (this.findRect(members, width, height)) this.run(renderer, members);
        if (this.fine) this.runFine(renderer, members, camera, width, height);
        this.ids = new Map(members.map((member, k) => [member, k + 1]));
        Object.assign(this, { scene, camera, number: renderer.info.render.frame });
    }

    /** Places the batches and fits the depth range to them. */
    place(members) {
        const span = new DepthSpan();
        for (const member of members) member.place(this.eye, span);
        this.eye.fit(span.isEmpty ? null : span);
        for (const member of members) member.project(this.eye);
    }

    /** Finds the pixels that the splats may cover. @returns whether there are any. */
    findRect(members, width, height) {
        const all = new Vector4(1, 1, -1, -1);
        for (const member of members) {
            member.findRect(width, height, rect);
            if (rect.z > rect.x) all.set(Math.min(all.x, rect.x), Math.min(all.y, rect.y), Math.max(all.z, rect.z), Math.max(all.w, rect.w));
        }
        const isSeen = all.z > all.x && all.w > all.y;
        if (!isSeen) all.set(0, 0, 0, 0);
        const x = Math.floor((0.5 * all.x + 0.5) * width), y = Math.floor((0.5 * all.y + 0.5) * height);
        for (const target of [this.target, this.owners]) {
            target.viewport.set(0, 0, width, height);
            target.scissor.set(x, y, Math.ceil((0.5 * all.z + 0.5) * width) - x, Math.ceil((0.5 * all.w + 0.5) * height) - y);
        }
        return isSeen;
    }

    /** Runs the passes: one object's in one go, those of several with their owners first. */
    run(renderer, members) {
        const { material } = members[0], isShading = !!material.isSplatShading;
        const view = { pass: isShading && material.shading === 'splats' ? PASS.parameters : PASS.normals, differ: this.differ, isHalf: this.isHalf, counts: isShading && material.shading === 'overdraw' };
        const visibility = { ...view, pass: PASS.visibility, isOwned: this.isShared };
        const add = (pass, order) => members.forEach((member, k) => member.addPass(passes, this.eye, pass, order, k + 1));
        if (view.pass === PASS.normals) add(visibility, 0);
        if (this.isShared) this.render(renderer, this.owners, true);
        add(view, 1);
        this.render(renderer, this.target, !this.isShared);
    }

    /** Runs the visibility pass for a quarter of each pixel, which tells how much of it splats cover. */
    runFine(renderer, members, camera, width, height) {
        const { fine, fineEye, eye, target } = this, view = { pass: PASS.visibility, differ: this.differ, isHalf: this.isHalf };
        fineEye.set(camera, 2 * width, 2 * height, eye.isReversed);
        fineEye.fit(eye.span);
        fine.viewport.set(0, 0, 2 * width, 2 * height);
        fine.scissor.copy(target.scissor).multiplyScalar(2);
        members.forEach((member, k) => member.addPass(passes, fineEye, view, 0, k + 1));
        this.render(renderer, fine, true);
    }

    /** Draws the scene of passes into a target, and empties the scene. */
    render(renderer, target, clearsDepth) {
        const old = { target: renderer.getRenderTarget(), face: renderer.getActiveCubeFace(), level: renderer.getActiveMipmapLevel(), alpha: renderer.getClearAlpha(),
            autoClear: renderer.autoClear, depth: renderer.autoClearDepth, shadows: renderer.shadowMap.autoUpdate, xr: renderer.xr.enabled, reset: renderer.info.autoReset };
        const depth = renderer.state.buffers.depth, isReversed = depth.getReversed?.() === true;
        renderer.getClearColor(clearColor);
        renderer.autoClear = true;
        renderer.autoClearDepth = clearsDepth;
        renderer.shadowMap.autoUpdate = renderer.xr.enabled = renderer.info.autoReset = false;
        renderer.setClearColor(0, 0);
        if (isReversed) depth.setReversed(false);
        renderer.setRenderTarget(target);
        renderer.render(passes, passCamera);
        passes.children.length = 0;
        if (isReversed) depth.setReversed(true);
        renderer.setRenderTarget(old.target, old.face, old.level);
        renderer.setClearColor(clearColor, old.alpha);
        renderer.autoClear = old.autoClear;
        renderer.autoClearDepth = old.depth;
        renderer.shadowMap.autoUpdate = old.shadows;
        renderer.xr.enabled = old.xr;
        renderer.info.autoReset = old.reset;
    }
}

/** @returns which render targets objects need together. */
function differencesOf(members) {
    const batches = [], reads = { colors: false, materials: false, occlusion: false };
    for (const member of members) {
        for (const batch of member.batches) batches.push({ batch, material: member.materialOf(batch) });
        const own = member.material.isSplatShading ? member.material.reads({ colors: true, materials: true, occlusion: true }) : { colors: true, materials: true, occlusion: true };
        for (const key of Object.keys(reads)) reads[key] ||= own[key];
    }
    if (!batches.length) return { colors: false, materials: false, occlusion: false };
    const differ = differences(batches);
    return { colors: reads.colors && differ.colors, materials: reads.materials && differ.materials, occlusion: reads.occlusion && differ.occlusion };
}

const frames = new WeakMap();

/** @returns the frame whose targets hold an object, which three is about to draw, and the object's
 *  number among those of the frame; 0: it has the frame alone. */
export function takeFrame(object, renderer, scene, camera, viewport) {
    if (!frames.has(renderer)) frames.set(renderer, new Frame());
    const frame = frames.get(renderer);
    if (!frame.holds(object, renderer, scene, camera)) frame.draw(object, renderer, scene, camera, viewport);
    const id = frame.ids.get(object);
    frame.ids.delete(object);
    return { frame, id: frame.isShared ? id : 0 };
}

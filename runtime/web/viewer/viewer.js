// SPDX-License-Identifier: MIT
//
// viewer.js - shows splats, the mesh they come from, or both with a slider between them. The page's
// address may hold ?load=URL and a second one, &load=URL or &source=URL, &mode=MODE, and
// &three=DIRECTORY for a three.js of one's own. Which side a file is on follows from what it holds.
// A tileset (3D Tiles) takes the place of the splats: ?tileset=URL, or a .json among the files, with
// &pixels=ERROR and &tiles=DIRECTORY for a 3d-tiles-renderer of one's own. The first animation of a file plays in a loop.
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { RoomEnvironment } from 'three/addons/environments/RoomEnvironment.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MTLLoader } from 'three/addons/loaders/MTLLoader.js';
import { OBJLoader } from 'three/addons/loaders/OBJLoader.js';
import { PLYLoader } from 'three/addons/loaders/PLYLoader.js';
import { STLLoader } from 'three/addons/loaders/STLLoader.js';
import { GLTFPhongSplats, PhongSplats, PhongSplatsTiles, SplatShadingMaterial } from 'three-phong-splats';

const element = (id) => document.getElementById(id);
const view = element('view'), slider = element('slider'), query = new URLSearchParams(location.search);

// ---- the scene -------------------------------------------------------------------------------

const renderer = new THREE.WebGLRenderer({ antialias: true });
renderer.toneMapping = THREE.NeutralToneMapping;
renderer.setScissorTest(true);
view.prepend(renderer.domElement);
const scene = new THREE.Scene();
scene.background = new THREE.Color(0x30363f);
const pmrem = new THREE.PMREMGenerator(renderer);
scene.environment = pmrem.fromScene(new RoomEnvironment(), 0.04).texture;
scene.environmentIntensity = 0.45;
const camera = new THREE.PerspectiveCamera(35), sun = new THREE.DirectionalLight(0xffffff, 1.6);
scene.add(camera, sun, sun.target);
const controls = new OrbitControls(camera, renderer.domElement);
controls.addEventListener('change', requestFrame);
controls.addEventListener('change', () => { element('hover').textContent = ''; });

/** The two sides: what each shows, or null. */
const sides = { source: null, splats: null };

let isWaiting = false;
function requestFrame() {
    if (isWaiting) return;
    isWaiting = true;
    requestAnimationFrame((now) => {
        isWaiting = false;
        draw(now);
    });
}

/** Draws one side into columns x to x + width of the canvas. */
function drawSide(side, x, width) {
    if (width <= 0) return;
    for (const other of Object.values(sides)) if (other) other.root.visible = other === side;
    const { clientWidth, clientHeight } = renderer.domElement;
    renderer.setViewport(0, 0, clientWidth, clientHeight);
    renderer.setScissor(x, 0, width, clientHeight);
    renderer.render(scene, camera);
}

function draw(now = performance.now()) {
    advance(now);
    const width = view.clientWidth, height = view.clientHeight;
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    sun.position.set(-0.5, 1.2, 0.6).applyQuaternion(camera.quaternion).multiplyScalar(controls.maxDistance || 1).add(sun.target.position);
    if (sides.splats?.tiles) updateTiles(sides.splats);
    const hasBoth = !!(sides.source && sides.splats), border = hasBoth ? Math.round(width * slider.value) : sides.source ? width : 0;
    drawSide(sides.source, 0, border);
    drawSide(sides.splats, border, width - border);
    element('divider').style.left = `${border}px`;
}

/** Moves the camera so that all is seen, and puts its planes around it. */
function fit() {
    const box = new THREE.Box3();
    for (const side of Object.values(sides)) if (side) box.union(side.tiles ? boxOfTiles(side) : boxOfMotion(side));
    if (box.isEmpty()) return;
    const sphere = box.getBoundingSphere(new THREE.Sphere()), half = THREE.MathUtils.degToRad(0.5 * camera.fov);
    const distance = sphere.radius / Math.sin(Math.atan(Math.tan(half) * Math.min(1, view.clientWidth / view.clientHeight)));
    camera.position.set(0.45, 0.34, 0.82).normalize().multiplyScalar(distance).add(sphere.center);
    camera.near = distance / 1000;
    camera.far = distance * 20;
    controls.target.copy(sphere.center);
    controls.maxDistance = 10 * distance;
    sun.target.position.copy(sphere.center);
    controls.update();
    requestFrame();
}

// ---- animations ------------------------------------------------------------------------------

/** What moves, and how long it has; people who want little motion start it themselves. */
const motion = { seconds: 0, isPlaying: !matchMedia('(prefers-reduced-motion: reduce)').matches, last: null };

const movingSides = () => Object.values(sides).filter((side) => side?.mixer);

/** @returns whether an animation moves anything that is drawn: not one of a single moment, nor of a camera. Bones
 *  deform what is drawn elsewhere. */
function isMotion(root, { duration, tracks }) {
    const isDrawn = (object) => object.isMesh || object.isPoints || object.isLine || object.isBone || object.children.some(isDrawn);
    return duration > 0 && tracks.some(({ name }) => {
        const moved = THREE.PropertyBinding.findNode(root, THREE.PropertyBinding.parseTrackName(name).nodeName);
        return moved && isDrawn(moved);
    });
}

/** Moves both sides on to the time of a frame, and asks for the next one while they play. */
function advance(now) {
    const moving = movingSides();
    if (!moving.length || !motion.isPlaying) motion.last = null;
    else {
        motion.seconds += motion.last === null ? 0 : Math.max(now - motion.last, 0) / 1000;
        motion.last = now;
        requestFrame();
    }
    for (const { mixer } of moving) mixer.setTime(motion.seconds);
}

/** Plays the chosen animation of a side, in a loop; one that has fewer plays its last. */
function choose(side) {
    const { mixer, animations } = side, index = Math.min(element('clip').value, animations.length - 1);
    mixer.stopAllAction();
    side.clip = animations[Math.max(index, 0)];
    mixer.clipAction(side.clip).play();
}

/** Lists the animations of what is shown. */
function listMotion() {
    const moving = movingSides(), [most] = moving.map(({ animations }) => animations).sort((a, b) => b.length - a.length), clip = element('clip');
    element('motion').hidden = !most;
    clip.replaceChildren(...(most ?? []).map(({ name }, index) => new Option(name || `animation ${index}`, index)));
    clip.hidden = most?.length === 1;
    motion.seconds = 0;
    moving.forEach(choose);
    showMotion();
}

function showMotion() {
    element('play').textContent = motion.isPlaying ? 'Pause' : 'Play';
    requestFrame();
}

/** @returns the box of a side, at rest or over its whole animation. */
function boxOfMotion({ root, mixer, clip }) {
    const box = new THREE.Box3(), steps = mixer ? 32 : 0;
    for (let i = 0; i <= steps; ++i) {
        mixer?.setTime(clip.duration * i / (steps + 1));
        box.union(new THREE.Box3().setFromObject(root));
    }
    return box;
}

// ---- modes -----------------------------------------------------------------------------------

function setModeOf(root) {
    const mode = element('mode').value;
    root.traverse((object) => {
        if (!object.isPhongSplats) return;
        object.userData.material ??= object.material;
        if (object.material.isSplatShading) object.material.dispose();
        object.material = mode === 'three' ? object.userData.material : new SplatShadingMaterial(mode);
    });
}

function setMode() {
    const mode = element('mode').value;
    if (sides.splats?.tiles) sides.splats.tiles.forEachLoadedModel(setModeOf);
    else if (sides.splats) setModeOf(sides.splats.root);
    scene.overrideMaterial = null;
    sides.source?.root.traverse((object) => {
        if (!object.isMesh) return;
        object.userData.material ??= object.material;
        object.material = mode === 'normal' ? new THREE.MeshNormalMaterial({ side: THREE.DoubleSide }) : object.userData.material;
    });
    requestFrame();
}

// ---- files -----------------------------------------------------------------------------------

function fail(text) {
    element('error').textContent = text;
    element('error').hidden = !text;
}

/** @returns loaders; files: what was dropped by name, for glTF that refers to other files. */
function loadersFor(files) {
    const manager = new THREE.LoadingManager(), urls = [];
    manager.setURLModifier((url) => {
        const file = files.get(decodeURIComponent(url.split('/').pop()));
        if (!file || /^(data|blob):/.test(url)) return url;
        urls.push(URL.createObjectURL(file));
        return urls.at(-1);
    });
    const gltf = new GLTFLoader(manager).setMeshoptDecoder(MeshoptDecoder).register((parser) => new GLTFPhongSplats(parser));
    manager.onLoad = () => {
        urls.splice(0).forEach((url) => URL.revokeObjectURL(url));
        requestFrame(); // textures of OBJ files come late
    };
    return { gltf, obj: new OBJLoader(manager), mtl: new MTLLoader(manager) };
}

/** Reads an OBJ file, with its materials where they are at hand: among the files or at the address. */
async function parseObj(text, path, files, loaders) {
    const library = /^mtllib\s+(.+?)\s*$/m.exec(text)?.[1];
    if (!library || !(path || files.has(library))) return withStandardMaterial(loaders.obj.parse(text));
    try {
        const materials = await loaders.mtl.setPath(path).loadAsync(library);
        materials.preload();
        loaders.obj.setMaterials(materials);
    } catch (error) {
        fail(`${library}: ${error.message}`);
        return withStandardMaterial(loaders.obj.parse(text));
    }
    return loaders.obj.parse(text);
}

/** @returns the material of splats without one. */
function standardMaterial(more) {
    return new THREE.MeshStandardMaterial({ color: 0xffffff, metalness: 0, roughness: 1, side: THREE.DoubleSide, ...more });
}

/** OBJ files without materials get the one of splats without. */
function withStandardMaterial(root) {
    const plain = standardMaterial();
    root.traverse((object) => { if (object.isMesh) object.material = plain; });
    return root;
}

/** @returns the mesh of a PLY or an STL. */
function meshOf(geometry, needsIndex) {
    if (needsIndex && !geometry.index) throw new Error('it holds points and no triangles');
    const { color, normal } = geometry.attributes;
    return new THREE.Mesh(geometry, standardMaterial({ vertexColors: !!color, flatShading: !normal }));
}

async function parse(name, buffer, path, files) {
    const loaders = loadersFor(files);
    if (/\.ply$/i.test(name)) return { root: meshOf(new PLYLoader().parse(buffer), true), animations: [] };
    if (/\.stl$/i.test(name)) return { root: meshOf(new STLLoader().parse(buffer), false), animations: [] };
    if (/\.obj$/i.test(name)) return { root: await parseObj(new TextDecoder().decode(buffer), path, files, loaders), animations: [] };
    const { scene: root, animations } = await loaders.gltf.parseAsync(buffer, path);
    return { root, animations: animations.filter((animation) => isMotion(root, animation)) };
}

function count(root) {
    let splats = 0, triangles = 0;
    root.traverse((object) => {
        if (object.isPhongSplats) splats += object.splatCount;
        else if (object.isMesh) triangles += (object.geometry.index ?? object.geometry.attributes.position).count / 3;
    });
    return { splats, triangles: Math.round(triangles) };
}

function free(side) {
    side.root.removeFromParent();
    side.mixer?.stopAllAction();
    if (side.tiles) return side.tiles.dispose();
    side.root.traverse((object) => {
        if (object.isPhongSplats) object.dispose();
        else object.geometry?.dispose();
    });
}

/** Shows a file on the side that it belongs to. */
async function show(name, buffer, path, files) {
    const { root, animations } = await parse(name, buffer, path, files), { splats, triangles } = count(root), which = splats ? 'splats' : 'source';
    if (!splats && !triangles) throw new Error('it holds neither splats nor triangles');
    const lights = [];
    root.traverse((object) => object.isLight && lights.push(object));
    for (const light of lights) light.removeFromParent();
    smooth(root);
    put(which, { root, name, animations, mixer: animations.length ? new THREE.AnimationMixer(root) : null });
    const things = splats ? `${splats.toLocaleString('en')} splats` : `${triangles.toLocaleString('en')} triangles`;
    element(which).textContent = `${name}\n${buffer.byteLength.toLocaleString('en')} bytes\n${things}`;
}

/** Smooths outlines, as the mesh has them. */
function smooth(root) {
    root.traverse((object) => { if (object.isPhongSplats) object.material.alphaToCoverage = true; });
}

/** Puts what was loaded on a side, in place of what is there. */
function put(which, side) {
    if (sides[which]) free(sides[which]);
    sides[which] = side;
    scene.add(side.root);
    slider.hidden = element('divider').hidden = !(sides.source && sides.splats);
    element('tau').hidden = !sides.splats?.tiles;
    listMotion();
    element('hint').hidden = true;
}

async function showAll(entries, files) {
    fail('');
    for (const { name, load, path, url } of entries) {
        try {
            if (url) await showTileset(name, url, files);
            else await show(name, await load(), path, files);
        } catch (error) {
            console.info(error);
            fail(`${name}: ${error.message}`);
        }
    }
    setMode();
    fit();
}

function openFiles(list) {
    // Tilesets name files by paths, models by names.
    const files = new Map([...list].flatMap((file) => [[file.name, file], [file.relativePath ?? (file.webkitRelativePath || file.name), file]])), models = [...list].filter((file) => /\.(glb|gltf|obj|ply|stl)$/i.test(file.name)), tileset = findTileset(list);
    if (tileset) return showAll([tileset], files);
    if (!models.length) return fail(`${[...files.keys()].join(', ')}: not one of .glb, .gltf, .obj, .ply, .stl and tileset.json`);
    return showAll(models.map((file) => ({ name: file.name, load: () => file.arrayBuffer(), path: '' })), files);
}

async function fetchBytes(url) {
    const response = await fetch(url);
    if (!response.ok) throw new Error(`the server answers ${response.status} ${response.statusText}`);
    return response.arrayBuffer();
}

function openAddresses(addresses, tilesets) {
    return showAll(addresses.map((address) => {
        const url = new URL(address, location.href);
        if (tilesets.includes(address) || /\.json$/i.test(url.pathname)) return { name: tilesetName(url), url: url.href };
        return { name: decodeURIComponent(url.pathname.split('/').pop()), load: () => fetchBytes(url), path: new URL('.', url).href };
    }), new Map());
}

// ---- tilesets --------------------------------------------------------------------------------

/** Where the contents of dropped folders seem to be. */
const DROPPED = new URL('dropped/', location.href).href;

/** @returns the name of a tileset's directory where the file has none of its own. */
function tilesetName(url) {
    const [directory, file] = decodeURIComponent(url.pathname).split('/').slice(-2);
    return file === 'tileset.json' && directory ? `${directory}/${file}` : file;
}

/** @returns what showAll() takes for the outermost tileset.json of a list of files, or undefined. */
function findTileset(list) {
    const paths = [...list].map((file) => file.relativePath ?? file.webkitRelativePath ?? file.name).map((path, k) => path || list[k].name);
    const [path] = paths.filter((path) => /(^|[/])tileset\.json$/i.test(path)).sort((a, b) => a.split('/').length - b.split('/').length);
    return path === undefined ? undefined : { name: path, url: DROPPED + path };
}

/** The plugin that reads tiles from files that were dropped. */
class DroppedFiles {
    constructor(files) {
        this.files = files;
    }

    async fetchData(url) {
        if (!url.startsWith(DROPPED)) return fetch(url);
        const path = decodeURIComponent(url.slice(DROPPED.length)), file = this.files.get(path) ?? this.files.get(path.slice(path.lastIndexOf('/') + 1));
        return file ? new Response(file) : new Response(null, { status: 404, statusText: 'not among the files' });
    }
}

/** Opens a tileset; its tiles come as the camera wants them. */
async function showTileset(name, url, files) {
    const { TilesRenderer } = await import('3d-tiles-renderer/three').catch(() => { throw new Error('tilesets need the package 3d-tiles-renderer'); });
    const tiles = new TilesRenderer(url), loader = loadersFor(files).gltf, plugin = new PhongSplatsTiles(loader, { pixels: Number(element('pixels').value) });
    tiles.registerPlugin(plugin);
    if (files.size) tiles.registerPlugin(new DroppedFiles(files));
    tiles.group.rotation.x = -Math.PI / 2; // 3D Tiles have z up
    tiles.setCamera(camera);
    tiles.addEventListener('needs-update', requestFrame);
    tiles.addEventListener('load-error', ({ url, error }) => fail(`${String(url).split('/').pop()}: ${error.message}`));
    tiles.addEventListener('load-model', ({ scene: root }) => {
        smooth(root);
        setModeOf(root);
    });
    tiles.addEventListener('dispose-model', ({ scene: root }) => root.traverse((object) => { if (object.material?.isSplatShading) object.material.dispose(); }));
    const root = new Promise((resolve, reject) => {
        tiles.addEventListener('load-root-tileset', resolve);
        tiles.addEventListener('load-error', ({ tile, error }) => tile ?? reject(error));
    });
    tiles.setResolution(camera, 1, 1);
    tiles.update();
    await root;
    put('splats', { root: tiles.group, name, tiles, plugin });
}

function boxOfTiles({ tiles, root }) {
    const box = new THREE.Box3();
    tiles.getBoundingBox(box);
    root.updateMatrixWorld();
    return box.applyMatrix4(root.matrixWorld);
}

/** Chooses the tiles of a frame, and says which they are. */
function updateTiles({ tiles, plugin, name, root }) {
    const size = renderer.getDrawingBufferSize(new THREE.Vector2());
    camera.updateMatrixWorld();
    root.updateMatrixWorld();
    tiles.errorTarget = Number(element('pixels').value) || 1;
    tiles.setResolution(camera, size.x, size.y);
    tiles.update();
    const seen = plugin.describe();
    element('splats').textContent = `${name}\n${seen.splats.toLocaleString('en')} splats in ${seen.tiles} tiles${seen.waiting ? `, ${seen.waiting} to come` : ''}\n${seen.bytes.toLocaleString('en')} bytes of tiles`;
}

// ---- the distance under the pointer ----------------------------------------------------------

const ray = new THREE.Raycaster();
function hover(event) {
    if (!sides.source || !sides.splats || event.buttons) return;
    const bounds = renderer.domElement.getBoundingClientRect();
    ray.setFromCamera(new THREE.Vector2((event.clientX - bounds.left) / bounds.width * 2 - 1, 1 - (event.clientY - bounds.top) / bounds.height * 2), camera);
    const hits = Object.values(sides).map(({ root }) => {
        root.visible = true;
        return ray.intersectObject(root, true)[0];
    });
    const size = new THREE.Box3().setFromObject(sides.source.root).getSize(new THREE.Vector3()).length();
    const apart = hits[0] && hits[1] && `${(100 * hits[0].point.distanceTo(hits[1].point) / size).toPrecision(2)} % of the diagonal apart along the ray`;
    element('hover').textContent = apart || (hits[0] ? 'the source alone is here' : hits[1] ? 'splats alone are here' : '');
}

// ---- controls --------------------------------------------------------------------------------

element('open').addEventListener('click', () => element('file').click());
element('file').addEventListener('change', (event) => openFiles(event.target.files));
element('fit').addEventListener('click', fit);
element('play').addEventListener('click', () => {
    motion.isPlaying = !motion.isPlaying;
    showMotion();
});
element('clip').addEventListener('change', () => {
    motion.seconds = 0;
    movingSides().forEach(choose);
    requestFrame();
});
element('mode').addEventListener('change', setMode);
element('pixels').addEventListener('input', requestFrame);
slider.addEventListener('input', requestFrame);
renderer.domElement.addEventListener('pointermove', hover);
renderer.domElement.addEventListener('click', hover); // fingers do not hover
renderer.domElement.addEventListener('webglcontextrestored', () => {
    scene.environment = pmrem.fromScene(new RoomEnvironment(), 0.04).texture;
    requestFrame();
});
view.addEventListener('dragover', (event) => {
    event.preventDefault();
    view.classList.add('over');
});
view.addEventListener('dragleave', () => view.classList.remove('over'));
view.addEventListener('drop', (event) => {
    event.preventDefault();
    view.classList.remove('over');
    const entries = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry?.()).filter((entry) => entry);
    if (!entries.some((entry) => entry.isDirectory)) return openFiles(event.dataTransfer.files);
    return Promise.all(entries.map(filesOf)).then((files) => openFiles(files.flat()));
});
new ResizeObserver(requestFrame).observe(view);
addEventListener('pagehide', () => PhongSplats.disposeTargets(renderer));

/** @returns all files of a dropped folder, which have their paths as relativePath. */
async function filesOf(entry) {
    const ask = (f) => new Promise((resolve, reject) => { f(resolve, reject); });
    if (entry.isFile) return [Object.assign(await ask((resolve, reject) => entry.file(resolve, reject)), { relativePath: entry.fullPath.slice(1) })];
    const reader = entry.createReader(), files = [];
    for (let some; (some = await ask((resolve, reject) => reader.readEntries(resolve, reject))).length;) files.push(...(await Promise.all(some.map(filesOf))).flat());
    return files;
}

if (query.has('pixels')) element('pixels').value = query.get('pixels');
if (query.has('mode')) element('mode').value = query.get('mode');
/** @returns the files that page.mjs has put into the page. */
function filesInPage() {
    return [...document.querySelectorAll('script[type="model"]')].map((script) => {
        const bytes = Uint8Array.from(atob(script.textContent.trim()), (c) => c.charCodeAt(0));
        return new File([bytes], script.dataset.name);
    });
}

const tilesets = query.getAll('tileset'), addresses = [...tilesets, ...query.getAll('load'), ...query.getAll('source')];
const inPage = filesInPage();
await (inPage.length ? openFiles(inPage) : addresses.length ? openAddresses(addresses, tilesets) : draw());
/** For the console, and for scripts that drive the page. */
window.viewer = { renderer, scene, camera, controls, sides, motion, fit, requestFrame };
document.documentElement.dataset.ready = 'true';

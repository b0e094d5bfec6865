// SPDX-License-Identifier: MIT
//
// page.js - what the tests do in the browser. Node calls the functions of window.page; pixels go
// back as base64 of RGB, row 0 on top.
import * as THREE from 'three';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { RoomEnvironment } from 'three/addons/environments/RoomEnvironment.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { GLTFPhongSplats, PhongSplats, SplatShadingMaterial } from 'three-phong-splats';

const WIDTH = 960, HEIGHT = 720;
const LIGHT = new THREE.Vector3(-0.15, 0.65, 0.85); // of `phongsplat render`, in eye space

function makeRenderer(options = {}) {
    const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true, ...options });
    renderer.setPixelRatio(1);
    renderer.setSize(options.width ?? WIDTH, options.height ?? HEIGHT);
    renderer.setClearColor(0, 1);
    document.body.append(renderer.domElement);
    return renderer;
}

const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).register((parser) => new GLTFPhongSplats(parser));

const levelsLoader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).register((parser) => new GLTFPhongSplats(parser, { levels: true }));

/** Returns a camera from which a box is seen whole. */
function cameraFor(box, azimuth, elevation, closeness = 1, aspect = WIDTH / HEIGHT) {
    const sphere = box.getBoundingSphere(new THREE.Sphere()), camera = new THREE.PerspectiveCamera(27, aspect);
    const [a, e] = [azimuth, elevation].map(THREE.MathUtils.degToRad), distance = closeness * sphere.radius / Math.sin(THREE.MathUtils.degToRad(13.5));
    camera.position.set(Math.sin(a) * Math.cos(e), Math.sin(e), Math.cos(a) * Math.cos(e)).multiplyScalar(distance).add(sphere.center);
    camera.lookAt(sphere.center);
    camera.far = distance + 1.01 * sphere.radius;
    camera.near = Math.max(distance - 1.01 * sphere.radius, camera.far / 1000);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    return camera;
}

/** Adds the light of `phongsplat render`; three's ambient light is irradiance, ours radiance. */
function addLight(scene, camera) {
    const sun = new THREE.DirectionalLight(0xffffff, 0.85 * Math.PI);
    sun.position.copy(LIGHT).transformDirection(camera.matrixWorld);
    scene.add(sun, new THREE.AmbientLight(0xffffff, 0.12 * Math.PI));
    return sun;
}

/** Removes the lights that came with a file. */
function removeLights(root) {
    const lights = [];
    root.traverse((object) => object.isLight && lights.push(object));
    for (const light of lights) light.removeFromParent();
}

/** A splat model between three's meshes, on a floor: shadows both ways, an environment. isMesh: the
 *  source's triangles in its place. */
async function makeStage({ url, light = 'directional', environment = true, material = {}, type = THREE.PCFShadowMap }) {
    const renderer = makeRenderer({ width: 960, height: 720 }), scene = new THREE.Scene(), { scene: root } = await loader.loadAsync(url);
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = type;
    renderer.toneMapping = THREE.ACESFilmicToneMapping;
    removeLights(root);
    const box = new THREE.Box3().setFromObject(root), sphere = box.getBoundingSphere(new THREE.Sphere());
    root.position.sub(sphere.center).multiplyScalar(1 / sphere.radius);
    root.scale.setScalar(1 / sphere.radius);
    const bottom = (box.min.y - sphere.center.y) / sphere.radius;
    scene.add(root);
    scene.background = new THREE.Color(0.35, 0.4, 0.5);
    if (environment) {
        const pmrem = new THREE.PMREMGenerator(renderer);
        scene.environment = pmrem.fromScene(new RoomEnvironment(), 0.04).texture;
        scene.environmentIntensity = 0.5;
    }
    const meshes = [
        new THREE.Mesh(new THREE.PlaneGeometry(8, 8), new THREE.MeshStandardMaterial({ color: 0x998877, roughness: 0.9 })),
        new THREE.Mesh(new THREE.TorusKnotGeometry(0.18, 0.06, 128, 24), new THREE.MeshStandardMaterial({ color: 0xcc3322, roughness: 0.3 })),
        new THREE.Mesh(new THREE.BoxGeometry(0.3, 1.2, 0.3), new THREE.MeshStandardMaterial({ color: 0x3355aa, roughness: 0.5 })),
    ];
    meshes[0].rotation.x = -Math.PI / 2;
    meshes[0].position.y = bottom;
    meshes[1].position.set(-0.55, 1.0, 0.55);
    meshes[2].position.set(0.7, bottom + 0.6, 0.5);
    scene.add(...meshes);
    const lamp = { directional: () => new THREE.DirectionalLight(0xffffff, 3), spot: () => new THREE.SpotLight(0xffffff, 60, 0, 0.5), point: () => new THREE.PointLight(0xffffff, 60) }[light]();
    lamp.position.set(-1.6, 3.2, 2.0);
    lamp.castShadow = true;
    if (lamp.isDirectionalLight) {
        Object.assign(lamp.shadow.camera, { left: -2.5, right: 2.5, top: 2.5, bottom: -2.5, far: 10 });
        lamp.shadow.mapSize.set(1024, 1024);
    }
    scene.add(lamp);
    scene.traverse((object) => {
        if (!object.isMesh) return;
        object.castShadow = object.receiveShadow = true;
        if (object.material.isMeshStandardMaterial && root.getObjectById(object.id)) Object.assign(object.material, material);
    });
    const camera = new THREE.PerspectiveCamera(35, 960 / 720, 0.1, 50);
    camera.position.set(1.2, 1.5, 4.2);
    camera.lookAt(0, 0, 0);
    camera.updateMatrixWorld();
    return { renderer, scene, camera, root, lamp, meshes, bottom };
}

function eachSplats(root, f) {
    root.traverse((object) => object.isPhongSplats && f(object));
}

function pixels(renderer) {
    const gl = renderer.getContext(), { width, height } = renderer.domElement, rgba = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
    const rows = [];
    for (let y = height - 1; y >= 0; --y) {
        const row = [];
        for (let x = 0; x < width; ++x) for (let k = 0; k < 3; ++k) row.push(rgba[4 * (y * width + x) + k]);
        rows.push(String.fromCharCode(...row));
    }
    return { width, height, rgb: btoa(rows.join('')), png: renderer.domElement.toDataURL(), error: gl.getError() };
}

const shared = { renderer: null };
const rendererOf = () => (shared.renderer ??= makeRenderer());

window.page = {
    revision: THREE.REVISION,

    /** Draws a file by one of the runtime's shadings, or 'three' for three's material. */
    async draw({ url, shading, azimuth = 30, elevation = 20, closeness = 1, ortho = false, material = {} }) {
        const { scene: root } = await loader.loadAsync(url), scene = new THREE.Scene().add(root), renderer = rendererOf();
        let camera = cameraFor(new THREE.Box3().setFromObject(root), azimuth, elevation, closeness);
        if (ortho) camera = orthographic(camera, root);
        removeLights(root);
        addLight(scene, camera);
        let count = 0;
        eachSplats(root, (object) => {
            count += object.splatCount;
            if (shading !== 'three') object.material = new SplatShadingMaterial(shading);
            else Object.assign(object.material, material);
        });
        renderer.render(scene, camera);
        return { ...pixels(renderer), count, view: camera.matrixWorldInverse.elements, projection: camera.projectionMatrix.elements };
    },
};

function orthographic(camera, root) {
    const sphere = new THREE.Box3().setFromObject(root).getBoundingSphere(new THREE.Sphere()), r = sphere.radius;
    const flat = new THREE.OrthographicCamera(-r * WIDTH / HEIGHT, r * WIDTH / HEIGHT, r, -r, camera.near, camera.far);
    flat.position.copy(camera.position);
    flat.quaternion.copy(camera.quaternion);
    flat.updateMatrixWorld();
    return flat;
}

Object.assign(window, { THREE, makeStage, removeLights, PhongSplats, SplatShadingMaterial, loader, levelsLoader, makeRenderer, cameraFor, addLight, eachSplats, pixels, rendererOf });
document.title = 'ready';

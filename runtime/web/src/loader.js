// SPDX-License-Identifier: MIT
//
// loader.js - the plugin for three's GLTFLoader: meshes whose primitives are splats become
// PhongSplats.
import { Group, Matrix4, MeshStandardMaterial, Quaternion, Vector3 } from 'three';
import { decodePrimitive, EXTENSION } from './decode.js';
import { readLevels, splatsOf } from './level_list.js';
import { PhongSplatsLOD } from './levels.js';
import { PhongSplats } from './splats.js';

const INSTANCING = 'EXT_mesh_gpu_instancing';

const isSplats = (primitive) => splatsOf(primitive) !== undefined;

/** @returns whether a primitive has the extension's attributes but not its object (section 6.2). */
const isStripped = (primitive) => !isSplats(primitive) && Object.keys(primitive.attributes ?? {}).some((name) => name.includes(`${EXTENSION}:`));

export class GLTFPhongSplats {
    /** @param levels true: meshes with levels of detail become PhongSplatsLOD; else the finest is shown. */
    constructor(parser, { levels = false } = {}) {
        this.parser = parser;
        this.usesLevels = levels;
        this.name = EXTENSION;
        this.sets = new Map(); // by mesh: its batches and materials
        this.instances = new Map(); // by node: what EXT_mesh_gpu_instancing says of nodes with splats
    }

    /** three's hook before anything is loaded: takes instances of splats away from three's own plugin,
     *  which would make them an InstancedMesh. */
    beforeRoot() {
        const { json } = this.parser;
        (json.nodes ?? []).forEach((node, index) => {
            const instancing = node.extensions?.[INSTANCING], mesh = json.meshes?.[node.mesh];
            if (!instancing || !(mesh?.primitives.some(isSplats) || mesh?.extensions?.[EXTENSION])) return;
            this.instances.set(index, instancing.attributes);
            delete node.extensions[INSTANCING];
        });
        return null;
    }

    /** three's hook for the mesh of a node. @returns null for nodes without instances of splats. */
    createNodeMesh(index) {
        return this.instances.has(index) ? this.loadInstances(index, this.instances.get(index)) : null;
    }

    /** @returns a group of clones, which share what they draw. */
    async loadInstances(index, { TRANSLATION, ROTATION, SCALE }) {
        const load = (accessor) => (accessor === undefined ? null : this.parser.getDependency('accessor', accessor));
        const [mesh, ...parts] = await Promise.all([this.parser.getDependency('mesh', this.parser.json.nodes[index].mesh), load(TRANSLATION), load(ROTATION), load(SCALE)]);
        const [at, turn, size] = parts, group = new Group(), count = parts.find((part) => part)?.count ?? 0;
        const p = new Vector3(), q = new Quaternion(), s = new Vector3(1, 1, 1), matrix = new Matrix4();
        for (let i = 0; i < count; ++i) {
            if (at) p.fromBufferAttribute(at, i);
            if (turn) q.fromBufferAttribute(turn, i);
            if (size) s.fromBufferAttribute(size, i);
            const clone = mesh.clone();
            clone.applyMatrix4(matrix.compose(p, q, s));
            group.add(clone);
        }
        return group;
    }

    /** three's hook for meshes. @returns null for those that have nothing to do with splats. */
    loadMesh(index) {
        const { json } = this.parser, mesh = json.meshes[index], standsIn = mesh.extensions?.[EXTENSION]?.mesh;
        if (standsIn !== undefined) return this.loadStandIn(index, standsIn);
        if (mesh.primitives.some(isStripped)) {
            console.warn(`GLTFPhongSplats: mesh ${index} has the attributes of ${EXTENSION} but not its object, and is drawn as points`);
        }
        return mesh.primitives.some(isSplats) ? this.loadSplats(index) : null;
    }

    loadStandIn(index, splats) {
        const other = this.parser.json.meshes[splats];
        if (!other?.primitives.some(isSplats)) throw new Error(`${EXTENSION}: mesh ${index} stands in for mesh ${splats}, which has no splats`);
        return this.loadSplats(splats, this.parser.json.meshes[index]);
    }

    async loadSplats(index, named = this.parser.json.meshes[index]) {
        const { json } = this.parser, mesh = json.meshes[index];
        if (!json.extensionsUsed?.includes(EXTENSION)) throw new Error(`${EXTENSION}: extensionsUsed does not list it`);
        const levels = readLevels(json, index);
        const splats = this.usesLevels && levels.length > 1 ? await this.makeLevels(levels) : await this.makeSplats(index);
        splats.name = this.parser.createUniqueName(named.name || `mesh_${index}`);
        if (mesh.extras) splats.userData = { ...mesh.extras };
        const others = mesh.primitives.filter((primitive) => !isSplats(primitive));
        if (!others.length) return splats;
        json.meshes.push({ name: mesh.name, primitives: others });
        const group = new Group();
        group.add(splats, await this.parser.loadMesh(json.meshes.length - 1));
        return group;
    }

    async makeSplats(index) {
        if (!this.sets.has(index)) this.sets.set(index, this.loadSet(index, this.parser.json.meshes[index]));
        const { batches, material, materials } = await this.sets.get(index);
        return new PhongSplats(batches, material, materials);
    }

    /** @returns an object that shows one of the levels of a mesh, as readLevels tells them. */
    async makeLevels(levels) {
        return new PhongSplatsLOD(await Promise.all(levels.map(async ({ mesh, scale, translation, ...errors }) => {
            const object = await this.makeSplats(mesh);
            object.scale.setScalar(scale);
            object.position.fromArray(translation);
            return { object, ...errors };
        })));
    }

    async loadSet(index, mesh) {
        const own = mesh.primitives.filter(isSplats), load = (accessor) => this.parser.getDependency('accessor', accessor);
        const view = (bytes) => {
            const { byteStride, extensions } = this.parser.json.bufferViews?.[bytes] ?? {};
            if (byteStride !== undefined || extensions?.EXT_meshopt_compression) throw new Error('a stream is in a bufferView with a byteStride or a compression');
            return this.parser.getDependency('bufferView', bytes);
        };
        const decoded = await Promise.all(own.map(async (primitive, k) => {
            try {
                return await decodePrimitive(primitive, load, view);
            } catch (error) {
                throw new Error(`mesh ${index}, primitive ${mesh.primitives.indexOf(own[k])}: ${error.message}`, { cause: error });
            }
        }));
        const batches = decoded.flat(), indices = own.flatMap((primitive, k) => decoded[k].map(() => primitive.material)), made = new Map();
        for (const material of indices) if (!made.has(material)) made.set(material, await this.copyMaterial(material));
        const materials = indices.map((material) => made.get(material));
        const lit = materials.find((material) => !material.isMeshBasicMaterial) ?? materials[0];
        return made.size === 1 ? { batches, material: materials[0], materials: null } : { batches, material: lit.clone(), materials };
    }

    /** @returns a material of the splats' own, since it becomes a resolve pass. */
    async copyMaterial(index) {
        const material = index === undefined ? new MeshStandardMaterial({ metalness: 1 }) : (await this.parser.getDependency('material', index)).clone();
        const normal = index === undefined ? undefined : this.parser.json.materials[index].extensions?.[EXTENSION]?.normalTexture;
        if (normal) {
            await this.parser.assignTexture(material, 'normalMap', normal);
            material.normalScale?.setScalar(normal.scale ?? 1);
        }
        material.transparent = false; // splats are opaque
        material.depthWrite = true;
        return material;
    }
}

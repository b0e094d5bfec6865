// SPDX-License-Identifier: MIT
export { GLTFPhongSplats } from './loader.js';
export { PhongSplatsLOD } from './levels.js';
export { PhongSplats } from './splats.js';
export { SplatShadingMaterial } from './shading.js';
export { PhongSplatsTiles } from './tiles.js';

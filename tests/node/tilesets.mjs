// SPDX-License-Identifier: MIT
// tilesets.mjs - finds the tilesets under test, and walks over their tiles with those of external tilesets.
import { readFileSync, readdirSync } from 'node:fs';
import { delimiter, join } from 'node:path';

export function tilesetPaths() {
  const directories = (process.env.PHONGSPLAT_TILESETS ?? '').split(delimiter).filter(Boolean);
  return directories.flatMap((directory) => readdirSync(directory).sort().map((name) => join(directory, name)));
}

// Calls visit(tile, parent) with every tile that has a content of its own; the tiles of an external tileset take the place of
// the one that names it.
export function walk(directory, visit, name = 'tileset.json', parent = null) {
  const tileset = JSON.parse(readFileSync(join(directory, name), 'utf8'));
  const go = (tile, above) => {
    if (tile.content.uri.endsWith('.json')) return walk(directory, visit, tile.content.uri, above);
    visit(tile, above);
    for (const child of tile.children ?? []) go(child, tile);
    return tileset;
  };
  go(tileset.root, parent);
  return tileset;
}

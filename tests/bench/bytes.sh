#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# bytes.sh FILE.glb ... - prints a table of what the bytes of files of splats are: of the file, of its JSON, and of each
# attribute a splat, as `phongsplat inspect` has them; and splats, batches and splats a batch. PHONGSPLAT names the program.
set -eu
command -v node >/dev/null || { echo "node is not installed" >&2; exit 1; }
for file in "$@"; do "${PHONGSPLAT:-phongsplat}" inspect "$file" --format json; done | node -e '
const text = require("fs").readFileSync(0, "utf8"), files = text.split(/\n(?=\{)/).map(JSON.parse);
const short = (name) => name.replace("PSPLAT_surface_splats:", ""), names = [...new Set(files.flatMap((f) => f.attributes.map((a) => short(a.name))))];
const row = (cells) => console.log(`| ${cells.join(" | ")} |`);
row(["file", "bytes", "JSON", "splats", "batches", "attributes, bytes a splat", ...names]);
row(["---", ...Array(names.length + 5).fill("--:")]);
for (const f of files) {
    const stored = (name) => f.attributes.filter((a) => short(a.name) === name).reduce((sum, a) => sum + a.stored, 0);
    const part = (bytes) => (bytes / f.splats).toFixed(2);
    row([f.file.replace(/.*\//, ""), f.file_bytes, f.json_bytes, f.splats, f.batches.map((b) => b.splats).join(" + "), part(f.stored_bytes), ...names.map((name) => part(stored(name)))]);
}'

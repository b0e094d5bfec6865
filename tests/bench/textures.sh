#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# textures.sh MODEL ... - prints the tables of converter/notes/textures.md, for each model at 0.5 and 0.2 %, baked and
# kept: how far textures slide and what is mirrored or of another chart (`convert --report`), base colours without light
# and lit pictures beside the mesh (`compare --size 1024 --software`), and bytes (`inspect`). PHONGSPLAT names the program.
set -eu
command -v node >/dev/null || { echo "node is not installed" >&2; exit 1; }
program=${PHONGSPLAT:-phongsplat}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
trap 'exit 1' INT TERM
for model in "$@"; do
    for tolerance in 0.5 0.2; do
        for textures in bake keep; do
            # 9 is the exit code of a broken promise, which the table may show.
            "$program" convert "$model" "$scratch/a.glb" -w -q -t "$tolerance%" --textures "$textures" --report "$scratch/report.json" || [ $? -eq 9 ]
            "$program" compare "$model" "$scratch/a.glb" -w -q --samples 1000 --size 1024 --software --report "$scratch/compared.json"
            "$program" inspect "$scratch/a.glb" --format json >"$scratch/inspected.json"
            node - "$scratch" "$model" "$tolerance" "$textures" >>"$scratch/rows" <<'JS'
const [folder, model, tolerance, textures] = process.argv.slice(2), { readFileSync } = require("fs");
const read = (name) => JSON.parse(readFileSync(`${folder}/${name}.json`, "utf8"));
console.log(JSON.stringify({ model: model.replace(/.*\/|\.\w+$/g, ""), tolerance, textures, report: read("report"), compared: read("compared"), inspected: read("inspected") }));
JS
        done
    done
done
node - "$scratch/rows" <<'JS'
const rows = require("fs").readFileSync(process.argv[2], "utf8").trim().split("\n").map(JSON.parse), print = (cells) => console.log(`| ${cells.join(" | ")} |`);
const kept = rows.filter((r) => r.textures === "keep"), bakedOf = (r) => rows[rows.indexOf(r) - 1];
const images = (r) => r.inspected.image_bytes ?? 0, bare = (r) => r.inspected.file_bytes - images(r);
print(["model", "tolerance", "splats: baked", "kept", "slide at 95 %, of the tolerance", "in texels", "greatest slide, of the tolerance", "mirrored, foreign %"]);
for (const r of kept)
    print([r.model, `${r.tolerance} %`, bakedOf(r).inspected.splats, r.inspected.splats, (r.report.p95_texture_slide_percent / r.tolerance).toFixed(2), r.report.p95_texture_slide_texels.toFixed(2),
        (r.report.max_texture_slide_percent / r.tolerance).toPrecision(2), `${r.report.mirrored_texture_percent.toFixed(2)}, ${r.report.foreign_texture_percent.toFixed(2)}`]);
console.log();
print(["", "", "splats", "base colour, dB", "SSIM", "lit, %", "bytes", "with images"]);
for (const r of rows)
    print([`${r.model} ${r.tolerance} %`, r.textures, r.inspected.splats, r.compared.base_color_inside_psnr_db.toFixed(1), r.compared.base_color_ssim.toFixed(3), r.compared.image_difference_percent.toFixed(2), bare(r), images(r) ? r.inspected.file_bytes : ""]);
console.log();
print(["", "splats", "centre", "first order", "second order", "together", "file without images, kept", "baked"]);
for (const r of kept) {
    const of = (pattern) => r.inspected.attributes.filter((a) => pattern.test(a.name)).reduce((sum, a) => sum + a.stored, 0) / r.inspected.splats;
    print([`${r.model} ${r.tolerance} %`, r.inspected.splats, ...[/TEXCOORD_0$/, /TEXCOORD_[UV]$/, /TEXCOORD_(UU|UV|VV)$/, /TEXCOORD/].map((p) => of(p).toFixed(1)), bare(r), bare(bakedOf(r))]);
}
JS

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_tile.c - phongsplat tile: a mesh becomes a tileset, in levels of detail.
 */
#define _XOPEN_SOURCE 700

#include "base/json_writer.h"
#include "base/output.h"
#include "base/path.h"
#include "cli/command.h"
#include "cli/options.h"
#include "cli/output_folder.h"
#include "cli/progress.h"
#include "export/meshopt_codec.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "select/conversion.h"
#include "tiles/tile_block.h"
#include "tiles/tileset.h"
#include "verify/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct arguments {
    const char *input, *output, *report;
    psplat_conversion_options how;
    int textures; /* index into texture_names */
    int tile_splats;
    int overwrite, quiet;
} arguments;

/* What a run makes; free_product frees everything. */
typedef struct product {
    psplat_mesh mesh;
    psplat_tile_block block;
    psplat_output_folder folder;
    double diagonal, seconds;
} product;

static const char *const texture_names[] = {"bake", NULL};

static const char summary[] =
    "Converts a mesh or a point set (as of convert) to a tileset of 3D Tiles 1.1: levels of\n"
    "detail in OUT/tileset.json, with Phong splats in GLBs below OUT/tiles/.";

static const char notes[] =
    "A tile covers its part of the surface by itself, so that tiles of any levels show no\n"
    "cracks. Its geometricError is proven. The scene of a glTF file becomes one model, at\n"
    "rest and without cameras and lights. All of the mesh has to fit into memory; for\n"
    "one that does not: phongsplat tile plan --help, tile node --help, tile merge --help.\n\n"
    "OUT/ appears whole or not at all. With --overwrite a tileset that is there is replaced;\n"
    "a directory that holds anything else never is.";

/* Lists what is said of the tiles, then how they are converted, then the rest. */
static void list_options(psplat_option_list *list, arguments *a) {
    psplat_convert_desc *c = &a->how.convert;
    const psplat_option tiles[] = {
        psplat_option_shared("tolerance", &c->tolerance_percent),
        psplat_option_shared("normal-tolerance", &c->normal_tolerance_degrees),
        {0, "color-tolerance", PSPLAT_OPTION_PERCENT, &c->color_tolerance_percent, "PERCENT",
         "greatest root mean square error of a splat's colour over\nits part of the surface at the "
         "finest level, as of convert;\nthis and that of normals grow by the root of 2 from level "
         "to\nlevel",
         0.1, 100, NULL},
        {0, "textures", PSPLAT_OPTION_CHOICE, &a->textures, "bake",
         "textures become colours of splats (default; there is no\nother choice)", 0, 0,
         texture_names},
        psplat_option_shared("tile-splats", &a->tile_splats),
    };
    const psplat_option rest[] = {
        psplat_option_shared("seed", &c->seed),
        psplat_option_shared("report", &a->report),
        psplat_option_shared("overwrite", &a->overwrite),
        psplat_option_shared("quiet", &a->quiet),
    };
    psplat_options_add(list, tiles, sizeof tiles / sizeof *tiles);
    psplat_options_add_conversion(list, &a->how);
    psplat_options_add(list, rest, sizeof rest / sizeof *rest);
}

static psplat_parse parse(int argc, char **argv, arguments *a) {
    psplat_option_list list = {.count = 0};
    list_options(&list, a);
    const psplat_syntax syntax = {
        .command = "tile",
        .operands = "IN OUT/",
        .summary = summary,
        .notes = notes,
        .options = list.rows,
        .option_count = list.count,
        .slots = {&a->input, &a->output},
    };
    psplat_parse parsed = psplat_options_parse(&syntax, argc, argv);
    if (parsed != PSPLAT_PARSE_OK) return parsed;
    if (!strcmp(a->output, "-"))
        return psplat_options_refuse("tile", a->output, "a tileset is a directory");
    return psplat_options_check_conversion("tile", &a->how);
}

/* Returns the cell of all triangles of a mesh, and stores its diagonal. */
static psplat_tile_cell root_of(const psplat_mesh *mesh, double *diagonal) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i)
        for (size_t k = 0; k < 3; ++k) {
            double x = mesh->positions[3 * (size_t)mesh->triangles[i] + k] + mesh->origin[k];
            low[k] = fmin(low[k], x);
            high[k] = fmax(high[k], x);
        }
    *diagonal = hypot(hypot(high[0] - low[0], high[1] - low[1]), high[2] - low[2]);
    return psplat_tile_cell_root(low, high);
}

static psplat_result take_content(void *user, const psplat_tile *tile, const uint8_t *data,
                                  size_t size, psplat_error *error) {
    return psplat_output_folder_add(user, tile->content, data, size, error);
}

static psplat_result take_tileset(void *user, const char *name, const char *text, size_t size,
                                  psplat_error *error) {
    return psplat_output_folder_add(user, name, text, size, error);
}

static psplat_result add_tileset(product *p, psplat_error *error) {
    size_t *parents = malloc((p->block.tile_count + 1) * sizeof *parents);
    psplat_result result =
        parents ? psplat_tileset_arrange(p->block.tiles, p->block.tile_count, parents, error)
                : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    if (!result)
        result = psplat_tileset_write(p->block.tiles, p->block.tile_count, parents, 0, take_tileset,
                                      &p->folder, error);
    free(parents);
    return result;
}

/* Makes all files of the tileset. */
static psplat_result make(const arguments *a, product *p, psplat_error *error) {
    psplat_progress progress = psplat_progress_begin(a->quiet);
    psplat_convert_desc options = a->how.convert;
    options.progress = psplat_progress_show;
    options.user = &progress;
    psplat_progress_show(&progress, "reading", 0);
    psplat_result result = psplat_mesh_read(a->input, &p->mesh, error);
    if (!result) {
        const psplat_tile_cell root = root_of(&p->mesh, &p->diagonal);
        const psplat_tile_block_desc desc = {
            .mesh = &p->mesh,
            .root = &root,
            .convert = &options,
            .finest = -1,
            .most = (size_t)a->tile_splats,
            .codec = a->how.no_compress ? NULL : &psplat_meshopt_codec,
            .has_fallback = a->how.fallback == PSPLAT_FALLBACK_MESH,
            .write = take_content,
            .user = &p->folder,
        };
        result = psplat_tile_block_make(&desc, &p->block, error);
    }
    if (!result) result = add_tileset(p, error);
    psplat_progress_end(&progress);
    return result;
}

/* ---- what is said of it ---------------------------------------------------------------------- */

static void add_level(psplat_writer *json, const psplat_tile_level *level) {
    const psplat_report *r = &level->report;
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "level", (size_t)level->level);
    psplat_writer_number(json, "tolerance_percent", r->tolerance_percent);
    psplat_writer_number(json, "error", level->error);
    psplat_writer_count(json, "splats", level->splats);
    psplat_writer_count(json, "tiles", level->tiles);
    psplat_writer_count(json, "splats_of_tiles", level->tile_splats);
    psplat_writer_count(json, "bytes", level->bytes);
    psplat_writer_number(json, "max_distance_percent", r->max_distance_percent);
    psplat_writer_number(json, "bound_distance_splats_percent", r->bound_distance_splats_percent);
    psplat_writer_number(json, "rms_normal_degrees", r->rms_normal_degrees);
    psplat_writer_count(json, "uncovered_samples", r->uncovered_samples);
    psplat_writer_count(json, "verification_samples", r->verification_samples);
    psplat_writer_boolean(json, "kept", psplat_report_broken(r) == PSPLAT_PROMISE_COUNT);
    psplat_writer_close(json, '}');
}

static psplat_result write_report(const arguments *a, const product *p, psplat_error *error) {
    psplat_writer json = {0};
    size_t bytes = 0;
    for (size_t i = 0; i < p->block.tile_count; ++i) bytes += p->block.tiles[i].bytes;
    psplat_writer_open(&json, NULL, '{');
    psplat_writer_count(&json, "triangles", p->mesh.triangle_count);
    psplat_writer_count(&json, "tiles", p->block.tile_count);
    psplat_writer_count(&json, "bytes", bytes);
    psplat_writer_number(&json, "diagonal", p->diagonal);
    psplat_writer_number(&json, "seconds", p->seconds);
    psplat_writer_open(&json, "levels", '[');
    for (size_t i = 0; i < p->block.level_count; ++i) add_level(&json, &p->block.levels[i]);
    psplat_writer_close(&json, ']');
    psplat_writer_close(&json, '}');
    if (!psplat_writer_finish(&json))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the report");
    psplat_result result =
        psplat_output_write(a->report, json.text, json.size, a->overwrite, error);
    free(json.text);
    return result;
}

static void print_summary(const arguments *a, const product *p) {
    const psplat_tile_level *finest = &p->block.levels[p->block.level_count - 1];
    size_t bytes = 0;
    if (a->quiet || (a->report && !strcmp(a->report, "-"))) return;
    for (size_t i = 0; i < p->block.tile_count; ++i) bytes += p->block.tiles[i].bytes;
    printf("%s: %zu tiles in %zu levels, %zu splats at the finest, %zu bytes, error %.3g to %.3g, "
           "%.2f s\n",
           a->output, p->block.tile_count, p->block.level_count, finest->splats, bytes,
           finest->error, p->block.levels[0].error, p->seconds);
}

/* Returns whether any texture of a mesh would have been kept by convert. */
static int has_textures(const psplat_mesh *mesh) {
    return mesh->materials && mesh->materials->image_count > 0;
}

/* Prints a line about the first level that breaks a promise. Returns whether there is one. */
static int print_broken(const arguments *a, const product *p) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(a->input, shown);
    for (size_t i = 0; i < p->block.level_count; ++i) {
        const psplat_report *r = &p->block.levels[i].report;
        const double *at = r->places[0].position;
        if (psplat_report_broken(r) == PSPLAT_PROMISE_COUNT) continue;
        psplat_command_error("%s: at %.6g %.6g %.6g: level %d, of %.3g %%, breaks a promise of its "
                             "conversion; the output was written all the same",
                             shown, at[0], at[1], at[2], p->block.levels[i].level,
                             r->tolerance_percent);
        return 1;
    }
    return 0;
}

static int run(const arguments *a, product *p) {
    double start = psplat_progress_clock();
    psplat_error error = {0};
    const char *subject = NULL;
    psplat_result result = psplat_output_folder_check(a->input, a->output, a->overwrite, &error);
    if (!result && a->report)
        result = psplat_output_check(a->input, a->report, a->overwrite, &error);
    if (!result) {
        result = make(a, p, &error);
        subject = a->input;
    }
    if (!result) {
        result = psplat_output_folder_write(&p->folder, a->output, a->overwrite, &error);
        subject = NULL;
    }
    p->seconds = psplat_progress_clock() - start;
    if (!result && a->report) result = write_report(a, p, &error);
    if (result) return psplat_command_fail(subject, &error);
    if (has_textures(&p->mesh) && !a->quiet)
        psplat_command_error("%s: its textures are baked into colours of splats", a->input);
    print_summary(a, p);
    return print_broken(a, p) ? PSPLAT_EXIT_BROKEN : PSPLAT_EXIT_SUCCESS;
}

int psplat_command_tile(int argc, char **argv) {
    const char *name = argc > 1 ? argv[1] : "";
    arguments a = {0};
    if (!strcmp(name, "plan")) return psplat_command_tile_plan(argc - 1, argv + 1);
    if (!strcmp(name, "node")) return psplat_command_tile_node(argc - 1, argv + 1);
    if (!strcmp(name, "merge")) return psplat_command_tile_merge(argc - 1, argv + 1);
    psplat_parse parsed = parse(argc, argv, &a);
    if (parsed != PSPLAT_PARSE_OK) return (int)parsed;
    product p = {0};
    int code = run(&a, &p);
    psplat_mesh_free(&p.mesh);
    psplat_tile_block_free(&p.block);
    psplat_output_folder_free(&p.folder);
    return code;
}

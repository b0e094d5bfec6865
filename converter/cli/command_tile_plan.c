/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_tile_plan.c - phongsplat tile plan: a mesh that may be larger than memory is sorted into
 * blocks, which tasks will convert.
 */
#define _XOPEN_SOURCE 700 /* access */

#include "cli/command.h"
#include "cli/options.h"
#include "select/conversion.h"
#include "tiles/plan.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* The triangles of a block, and its apron, unless options say otherwise. Two blocks that are
 * converted at a time then take less than 2 GB. */
static const int usual_triangles = 500000;
static const double usual_apron_percent = 6.25;

typedef struct arguments {
    const char *input, *output, *precision;
    psplat_tile_options options;
    int block_triangles, tile_splats;
    double apron_percent;
    int fallback; /* index into fallback_names */
    int overwrite, quiet;
} arguments;

static const char *const fallback_names[] = {"points", "mesh", NULL};

static psplat_parse parse(int argc, char **argv, arguments *a) {
    psplat_convert_desc *c = &a->options.convert;
    const psplat_option options[] = {
        {'t', "tolerance", PSPLAT_OPTION_PERCENT, &c->tolerance_percent, "PERCENT",
         "greatest distance between splats and surface at the finest\nlevel, in % of the bounding "
         "box's diagonal: 0.5% or 0.5\n(default 0.5); it doubles from level to level",
         1e-5, 20, NULL},
        psplat_option_shared("normal-tolerance", &c->normal_tolerance_degrees),
        {0, "color-tolerance", PSPLAT_OPTION_PERCENT, &c->color_tolerance_percent, "PERCENT",
         "as of tile", 0.1, 100, NULL},
        psplat_option_shared("effort", &c->effort),
        psplat_option_shared("crease-angle", &c->crease_angle_degrees),
        psplat_option_shared("no-creases", &c->no_creases),
        {0, "constant-normals", PSPLAT_OPTION_FLAG, &c->constant_normals, NULL,
         "one normal a splat instead of a linear field", 0, 0, NULL},
        {0, "planar", PSPLAT_OPTION_FLAG, &c->planar, NULL, "flat splats alone", 0, 0, NULL},
        {0, "precision", PSPLAT_OPTION_TEXT, &a->precision, "P",
         "auto, float, or the greatest step of positions, as of\nconvert", 0, 0, NULL},
        {0, "no-compress", PSPLAT_OPTION_FLAG, &a->options.no_compress, NULL,
         "neither a stream nor EXT_meshopt_compression", 0, 0, NULL},
        {0, "fallback", PSPLAT_OPTION_CHOICE, &a->fallback, "points|mesh",
         "what viewers of 3D Tiles that know no splats show, as of\ntile", 0, 0, fallback_names},
        {0, "block-triangles", PSPLAT_OPTION_COUNT, &a->block_triangles, "N",
         "the most triangles of a block (default 500000); more take\nmore memory", 100, 1e8, NULL},
        {0, "apron", PSPLAT_OPTION_PERCENT, &a->apron_percent, "PERCENT",
         "what a block sees around its cell, in % of the cell's\nlongest side (default 6.25)", 0.1,
         100, NULL},
        {0, "tile-splats", PSPLAT_OPTION_COUNT, &a->tile_splats, "N",
         "halve the cell of a tile while it has more than N splats\n(default 1024)", 8, 1e9, NULL},
        psplat_option_shared("seed", &c->seed),
        psplat_option_shared("overwrite", &a->overwrite),
        psplat_option_shared("quiet", &a->quiet),
    };
    const psplat_syntax syntax = {
        .command = "tile plan",
        .operands = "IN OUT/",
        .summary =
            "Sorts the triangles of a mesh of any size into blocks, and writes how they\n"
            "become a tileset: OUT/plan, OUT/tasks (one a line), OUT/tasks-N (those of wave\n"
            "N, which need waves before alone), OUT/Makefile and OUT/work/.",
        .notes =
            "Binary STL and binary PLY are streamed; other files have to fit into memory.\n"
            "Textures are refused. Then `make -j2 -C OUT` builds OUT/tileset.json, or whatever\n"
            "else runs `phongsplat tile node OUT TASK` for each task and `phongsplat tile merge\n"
            "OUT` in the end. The Makefile calls this program by its path; make\n"
            "PHONGSPLAT=PATH calls another one. OUT/work/ may be deleted after that.\n\n"
            "A directory that has the same plan already stays as it is. With --overwrite "
            "another\nplan is replaced, with all that it and its tasks have made; a directory with "
            "anything\nelse is refused.",
        .options = options,
        .option_count = sizeof options / sizeof *options,
        .slots = {&a->input, &a->output},
    };
    psplat_parse parsed = psplat_options_parse(&syntax, argc, argv);
    if (parsed != PSPLAT_PARSE_OK) return parsed;
    if (!psplat_options_precision(a->precision, &c->precision))
        return psplat_options_refuse("tile plan", "precision",
                                     "neither auto, float nor a number of 0.001 to 0.5");
    if (c->no_creases && c->crease_angle_degrees > 0)
        return psplat_options_refuse("tile plan", "no-creases", "not together with crease-angle");
    return PSPLAT_PARSE_OK;
}

static void print_summary(const arguments *a, const psplat_tile_plan *plan) {
    size_t leaves = 0;
    for (size_t i = 0; i < plan->tasks.count; ++i) leaves += plan->tasks.list[i].leaf != SIZE_MAX;
    if (a->quiet) return;
    printf("%s: %" PRIu64 " triangles in %zu blocks, %zu tasks in %d waves\n", a->output,
           plan->leaves.triangles, leaves, plan->tasks.count,
           plan->tasks.list[plan->tasks.count - 1].wave + 1);
}

/* Stores what the Makefile calls: this program where it lies, or, where the system does not tell
 * that or a line of a Makefile cannot hold it, its usual name, which the shell looks up. */
static void name_program(char *program, size_t size) {
    if (!psplat_program_path(program, size) || strchr(program, '\n') || access(program, X_OK))
        snprintf(program, size, "phongsplat");
}

int psplat_command_tile_plan(int argc, char **argv) {
    arguments a = {.block_triangles = usual_triangles, .apron_percent = usual_apron_percent};
    char program[4096];
    psplat_error error = {0};
    psplat_tile_plan plan;
    psplat_parse parsed = parse(argc, argv, &a);
    if (parsed != PSPLAT_PARSE_OK) return (int)parsed;
    a.options.most_triangles = (uint64_t)a.block_triangles;
    a.options.most_splats = (uint64_t)a.tile_splats;
    a.options.apron = a.apron_percent / 100;
    a.options.has_fallback = a.fallback;
    name_program(program, sizeof program);
    if (psplat_tile_plan_make(a.input, &a.options, program, a.output, a.overwrite, &plan, &error))
        return psplat_command_fail(NULL, &error);
    print_summary(&a, &plan);
    psplat_tile_plan_free(&plan);
    return PSPLAT_EXIT_SUCCESS;
}

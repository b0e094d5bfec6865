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
    const char *input, *output;
    psplat_conversion_options how;
    int block_triangles, tile_splats;
    double apron_percent;
    int overwrite, quiet;
} arguments;

static const char summary[] =
    "Sorts the triangles of a mesh of any size into blocks, and writes how they\n"
    "become a tileset: OUT/plan, OUT/tasks (one a line), OUT/tasks-N (those of wave\n"
    "N, which need waves before alone), OUT/Makefile and OUT/work/.";

static const char notes[] =
    "Binary STL and binary PLY are streamed; other files have to fit into memory.\n"
    "Textures are refused. Then `make -j2 -C OUT` builds OUT/tileset.json, or whatever\n"
    "else runs `phongsplat tile node OUT TASK` for each task and `phongsplat tile merge\n"
    "OUT` in the end. The Makefile calls this program by its path; make\n"
    "PHONGSPLAT=PATH calls another one. OUT/work/ may be deleted after that.\n\n"
    "A directory that has the same plan already stays as it is. With --overwrite another\n"
    "plan is replaced, with all that it and its tasks have made; a directory with anything\n"
    "else is refused.";

/* Lists what is promised, then how blocks are converted, then what blocks and tiles are. */
static void list_options(psplat_option_list *list, arguments *a) {
    psplat_convert_desc *c = &a->how.convert;
    const psplat_option promises[] = {
        psplat_option_shared("tolerance", &c->tolerance_percent),
        psplat_option_shared("normal-tolerance", &c->normal_tolerance_degrees),
        {0, "color-tolerance", PSPLAT_OPTION_PERCENT, &c->color_tolerance_percent, "PERCENT",
         "as of tile", 0.1, 100, NULL},
    };
    const psplat_option blocks[] = {
        {0, "block-triangles", PSPLAT_OPTION_COUNT, &a->block_triangles, "N",
         "the most triangles of a block (default 500000); more take\nmore memory", 100, 1e8, NULL},
        {0, "apron", PSPLAT_OPTION_PERCENT, &a->apron_percent, "PERCENT",
         "what a block sees around its cell, in % of the cell's\nlongest side (default 6.25)", 0.1,
         100, NULL},
        psplat_option_shared("tile-splats", &a->tile_splats),
        psplat_option_shared("seed", &c->seed),
        psplat_option_shared("overwrite", &a->overwrite),
        psplat_option_shared("quiet", &a->quiet),
    };
    psplat_options_add(list, promises, sizeof promises / sizeof *promises);
    psplat_options_add_conversion(list, &a->how);
    psplat_options_add(list, blocks, sizeof blocks / sizeof *blocks);
}

static psplat_parse parse(int argc, char **argv, arguments *a) {
    psplat_option_list list = {.count = 0};
    list_options(&list, a);
    const psplat_syntax syntax = {
        .command = "tile plan",
        .operands = "IN OUT/",
        .summary = summary,
        .notes = notes,
        .options = list.rows,
        .option_count = list.count,
        .slots = {&a->input, &a->output},
    };
    psplat_parse parsed = psplat_options_parse(&syntax, argc, argv);
    if (parsed != PSPLAT_PARSE_OK) return parsed;
    return psplat_options_check_conversion("tile plan", &a->how);
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
    const psplat_tile_options options = {
        .convert = a.how.convert,
        .most_triangles = (uint64_t)a.block_triangles,
        .most_splats = (uint64_t)a.tile_splats,
        .apron = a.apron_percent / 100,
        .no_compress = a.how.no_compress,
        .has_fallback = a.how.fallback == PSPLAT_FALLBACK_MESH,
    };
    name_program(program, sizeof program);
    if (psplat_tile_plan_make(a.input, &options, program, a.output, a.overwrite, &plan, &error))
        return psplat_command_fail(NULL, &error);
    print_summary(&a, &plan);
    psplat_tile_plan_free(&plan);
    return PSPLAT_EXIT_SUCCESS;
}

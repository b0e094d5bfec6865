/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_tile_merge.c - phongsplat tile merge: finished tasks of a plan become a tileset.
 */
#include "cli/command.h"
#include "cli/options.h"
#include "tiles/merge.h"
#include "tiles/plan.h"

#include <stdio.h>

static psplat_parse parse(int argc, char **argv, const char **directory, int *quiet) {
    const psplat_option options[] = {psplat_option_shared("quiet", quiet)};
    const psplat_syntax syntax = {
        .command = "tile merge",
        .operands = "OUT/",
        .summary =
            "Writes OUT/tileset.json, and further files of JSON that it names, of the tiles\n"
            "that the tasks of the plan in OUT/ have made.",
        .notes = "All tasks have to be done: exit code 2 names those that are not.",
        .options = options,
        .option_count = sizeof options / sizeof *options,
        .slots = {directory},
    };
    return psplat_options_parse(&syntax, argc, argv);
}

int psplat_command_tile_merge(int argc, char **argv) {
    const char *directory = NULL;
    int quiet = 0;
    psplat_error error = {0};
    psplat_tile_plan plan = {0};
    psplat_tile_summary summary = {0};
    psplat_parse parsed = parse(argc, argv, &directory, &quiet);
    if (parsed != PSPLAT_PARSE_OK) return (int)parsed;
    psplat_result result = psplat_tile_plan_read(directory, &plan, &error);
    if (!result) result = psplat_tile_plan_check_input(&plan, &error);
    if (!result) result = psplat_tile_merge(&plan, directory, &summary, &error);
    psplat_tile_plan_free(&plan);
    if (result) return psplat_command_fail(NULL, &error);
    if (!quiet)
        printf("%s: %zu tiles in %zu levels, %zu splats, %zu of them at the finest, %zu bytes, "
               "error at the root %.3g\n",
               directory, summary.tiles, summary.levels, summary.splats, summary.finest_splats,
               summary.bytes, summary.error);
    return PSPLAT_EXIT_SUCCESS;
}

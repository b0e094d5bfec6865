/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_tile_merge.c - phongsplat tile merge: finished tasks of a plan become a tileset.
 */
#include "base/path.h"
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
        .notes =
            "All tasks have to be done: exit code 2 names those that are not. Where tasks broke\n"
            "promises of their conversions, the tileset is written, a line says how many, and\n"
            "the exit code is 9.",
        .options = options,
        .option_count = sizeof options / sizeof *options,
        .slots = {directory},
    };
    return psplat_options_parse(&syntax, argc, argv);
}

/* Prints how many tasks break which promise, and the place of the first, in one line. */
static void print_broken(const char *directory, const psplat_tile_summary *summary) {
    const psplat_tile_record *first = &summary->first_broken;
    const double *at = first->broken.position;
    char counts[256] = "", shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(directory, shown);
    for (size_t i = 0, length = 0; i < PSPLAT_PROMISE_COUNT; ++i)
        if (summary->broken[i])
            length += (size_t)snprintf(
                counts + length, sizeof counts - length, "%s%s: %zu", length ? ", " : "",
                psplat_tile_promise_name((psplat_promise)i), summary->broken[i]);
    psplat_command_error("%s: %zu tasks break promises of their conversions (%s), first %s at %.6g "
                         "%.6g %.6g at the level of %.3g %%; the tileset was written all the same",
                         shown, summary->broken_tasks, counts, first->task, at[0], at[1], at[2],
                         first->broken.tolerance_percent);
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
    if (!summary.broken_tasks) return PSPLAT_EXIT_SUCCESS;
    print_broken(directory, &summary);
    return PSPLAT_EXIT_BROKEN;
}

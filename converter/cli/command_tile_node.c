/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_tile_node.c - phongsplat tile node: one task of a plan becomes tiles.
 */
#include "base/path.h"
#include "cli/command.h"
#include "cli/options.h"
#include "cli/progress.h"
#include "tiles/plan.h"
#include "tiles/record.h"
#include "tiles/tile_node.h"

#include <stdio.h>

typedef struct arguments {
    const char *directory, *task;
    int quiet;
} arguments;

static psplat_parse parse(int argc, char **argv, arguments *a) {
    const psplat_option options[] = {psplat_option_shared("quiet", &a->quiet)};
    const psplat_syntax syntax = {
        .command = "tile node",
        .operands = "OUT/ TASK",
        .summary =
            "Runs one task of the plan that `tile plan` wrote to OUT/: a block of the surface\n"
            "becomes tiles below OUT/tiles/, and a record and a simplified mesh below\n"
            "OUT/work/.",
        .notes =
            "A task that is done already is left as it is. One that is killed leaves nothing\n"
            "half, and may be run again. Tasks may run at the same time, but those of a wave\n"
            "need all before it. Exit code 2 says that one which is needed is not done. A level\n"
            "that breaks a promise of its conversion costs a line and does not stop others; tile\n"
            "merge counts it.",
        .options = options,
        .option_count = sizeof options / sizeof *options,
        .slots = {&a->directory, &a->task},
    };
    return psplat_options_parse(&syntax, argc, argv);
}

static void print_summary(const arguments *a, const psplat_tile_run *run) {
    const psplat_tile_record *record = &run->record;
    size_t splats = 0;
    for (size_t i = 0; i < record->tile_count; ++i) splats += record->tiles[i].splats;
    if (a->quiet) return;
    if (run->was_done) {
        printf("%s: is done already\n", a->task);
        return;
    }
    printf("%s: %zu triangles with the apron, %zu tiles, %zu splats, simplified from %zu to %zu "
           "triangles\n",
           a->task, run->triangles, record->tile_count, splats, run->owned, run->simplified);
}

static void print_broken(const arguments *a, const psplat_tile_broken *broken) {
    const double *at = broken->position;
    psplat_command_error("%s: at %.6g %.6g %.6g: the level of %.3g %% breaks its promise of %s; "
                         "its tiles were written all the same",
                         a->task, at[0], at[1], at[2], broken->tolerance_percent,
                         psplat_tile_promise_name(broken->first));
}

static psplat_result run_task(const arguments *a, const psplat_tile_plan *plan,
                              psplat_tile_run *run, psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    size_t task = psplat_tile_tasks_find(&plan->tasks, a->task);
    psplat_path_shorten(a->task, shown);
    if (task == PSPLAT_NO_TASK)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "%s: is no task of the plan", shown);
    psplat_result result = psplat_tile_plan_check_input(plan, error);
    if (result) return result;
    psplat_progress progress = psplat_progress_begin(a->quiet);
    result =
        psplat_tile_node_run(plan, a->directory, task, psplat_progress_show, &progress, run, error);
    psplat_progress_end(&progress);
    return result;
}

int psplat_command_tile_node(int argc, char **argv) {
    arguments a = {0};
    psplat_error error = {0};
    psplat_tile_plan plan = {0};
    psplat_tile_run run = {0};
    psplat_parse parsed = parse(argc, argv, &a);
    if (parsed != PSPLAT_PARSE_OK) return (int)parsed;
    psplat_result result = psplat_tile_plan_read(a.directory, &plan, &error);
    if (!result) result = run_task(&a, &plan, &run, &error);
    int code = result ? psplat_command_fail(NULL, &error) : PSPLAT_EXIT_SUCCESS;
    if (!result) print_summary(&a, &run);
    if (!result && psplat_tile_is_broken(&run.record.broken)) print_broken(&a, &run.record.broken);
    psplat_tile_record_free(&run.record);
    psplat_tile_plan_free(&plan);
    return code;
}

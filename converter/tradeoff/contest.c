/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * contest.c - all rows of a journal timed together: how long opening takes, and how long frames do.
 */
#include "tradeoff.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { OPENINGS = 9 }; /* of each asset, in turn */

/* A row, and what it draws: each asset is opened for its first row alone. */
typedef struct racer {
    const psplat_setting *setting;
    psplat_specimen specimen;
    const psplat_specimen *shown;
    psplat_workbench *bench;
} racer;

typedef struct contest {
    psplat_journal *journal;
    psplat_workbench *bench;
    const psplat_folder *folder;
    racer *racers; /* journal->count */
    psplat_contestant *contestants;
    psplat_frame_times *times;
    double *seconds; /* OPENINGS of each row */
} contest;

char *psplat_contest_path(const psplat_folder *folder, const psplat_setting *setting) {
    psplat_text name = {0};
    psplat_text_add(&name, "assets/");
    if (setting->contender == PSPLAT_CONTENDER_GLTFPACK) psplat_text_add(&name, "plain-");
    psplat_setting_file(setting, &name);
    char *path = name.failed ? NULL : psplat_folder_path(folder, name.data);
    free(name.data);
    return path;
}

static psplat_result draw(void *self, const psplat_view *view, psplat_error *error) {
    const racer *r = self;
    if (r->setting->contender == PSPLAT_CONTENDER_MESH)
        return psplat_gallery_draw_original(r->bench->gallery, view, error);
    if (r->setting->contender == PSPLAT_CONTENDER_GLTFPACK)
        return psplat_gallery_draw_original(r->shown->gallery, view, error);
    psplat_view drawn = *view;
    const psplat_item item = {.model = r->shown->model};
    drawn.mode = r->setting->mode;
    drawn.no_filter = r->setting->no_filter;
    return psplat_draw(r->bench->renderer, &drawn, &item, 1, error);
}

static int shares_previous(const psplat_journal *j, size_t row) {
    return row && psplat_setting_shares_asset(&j->rows[row].setting, &j->rows[row - 1].setting);
}

static psplat_result open_specimen(const contest *c, size_t row, psplat_specimen *specimen,
                                   psplat_error *error) {
    const psplat_setting *setting = &c->journal->rows[row].setting;
    char *path = psplat_contest_path(c->folder, setting);
    if (!path) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    psplat_result result = psplat_specimen_open(specimen, c->bench, setting, path, error);
    free(path);
    return result;
}

/* A gallery of its own draws a simplified mesh; its own pictures are of no use here. */
static psplat_result hang(const contest *c, psplat_specimen *specimen, psplat_error *error) {
    const psplat_gallery_desc desc = {c->bench->host, specimen->original, 16};
    return specimen->original ? psplat_gallery_create(&desc, &specimen->gallery, error) : PSPLAT_OK;
}

static psplat_result open_all(contest *c, psplat_error *error) {
    psplat_result result = psplat_workbench_gallery(c->bench, error);
    for (size_t i = 0; i < c->journal->count && !result; ++i) {
        racer *r = &c->racers[i];
        *r = (racer){.setting = &c->journal->rows[i].setting, .bench = c->bench};
        c->contestants[i] = (psplat_contestant){draw, r};
        if (r->setting->contender == PSPLAT_CONTENDER_MESH) continue;
        r->shown = shares_previous(c->journal, i) ? c->racers[i - 1].shown : &r->specimen;
        if (r->shown != &r->specimen) continue;
        result = open_specimen(c, i, &r->specimen, error);
        if (!result) result = hang(c, &r->specimen, error);
    }
    return result;
}

/* ---- opening ------------------------------------------------------------------------------ */

static psplat_result time_opening(const contest *c, size_t row, double *seconds,
                                  psplat_error *error) {
    psplat_specimen specimen = {.asset = NULL};
    double start = psplat_timing_clock();
    psplat_result result = open_specimen(c, row, &specimen, error);
    *seconds = psplat_timing_clock() - start;
    psplat_specimen_close(&specimen);
    return result;
}

/* Of splats: what is opened of a mesh here is made for comparing, not for drawing. */
static psplat_result time_openings(contest *c, psplat_error *error) {
    psplat_journal *j = c->journal;
    psplat_result result = PSPLAT_OK;
    for (size_t round = 0; round < OPENINGS; ++round)
        for (size_t i = 0; i < j->count && !result; ++i)
            if (j->rows[i].setting.contender == PSPLAT_CONTENDER_SPLATS && !shares_previous(j, i))
                result = time_opening(c, i, &c->seconds[OPENINGS * i + round], error);
    for (size_t i = 0; i < j->count && !result; ++i) {
        double *load = &j->rows[i].values[PSPLAT_COLUMN_LOAD_MS];
        *load = NAN;
        if (j->rows[i].setting.contender != PSPLAT_CONTENDER_SPLATS) continue;
        *load = shares_previous(j, i)
                    ? j->rows[i - 1].values[PSPLAT_COLUMN_LOAD_MS]
                    : 1e3 * psplat_timing_quartiles(&c->seconds[OPENINGS * i], OPENINGS).median;
    }
    return result;
}

/* ---- frames ------------------------------------------------------------------------------- */

static void fill_quartiles(double *values, const psplat_quartiles *quartiles) {
    values[0] = quartiles->median;
    values[1] = quartiles->low;
    values[2] = quartiles->high;
}

static psplat_result time_frames(contest *c, int (*progress)(void *user, double fraction),
                                 void *user, psplat_error *error) {
    psplat_view views[PSPLAT_GALLERY_VIEWS];
    for (int i = 0; i < PSPLAT_GALLERY_VIEWS; ++i)
        views[i] = psplat_gallery_view(c->bench->gallery, i);
    const psplat_timing_desc desc = {.host = c->bench->host,
                                     .views = views,
                                     .view_count = PSPLAT_GALLERY_VIEWS,
                                     .contestants = c->contestants,
                                     .count = c->journal->count,
                                     .frames = c->journal->options.frames,
                                     .progress = progress,
                                     .user = user};
    psplat_result result = psplat_timing_run(&desc, c->times, error);
    for (size_t i = 0; i < c->journal->count && !result; ++i) {
        double *values = c->journal->rows[i].values;
        fill_quartiles(values + PSPLAT_COLUMN_CPU_MS, &c->times[i].cpu);
        fill_quartiles(values + PSPLAT_COLUMN_WALL_MS, &c->times[i].wall);
        fill_quartiles(values + PSPLAT_COLUMN_GPU_MS, &c->times[i].gpu);
    }
    return result;
}

psplat_result psplat_contest_run(psplat_journal *journal, psplat_workbench *bench,
                                 const psplat_folder *folder,
                                 int (*progress)(void *user, double fraction), void *user,
                                 psplat_error *error) {
    size_t count = journal->count;
    contest c = {.journal = journal, .bench = bench, .folder = folder};
    c.racers = calloc(count, sizeof *c.racers);
    c.contestants = calloc(count, sizeof *c.contestants);
    c.times = calloc(count, sizeof *c.times);
    c.seconds = calloc(OPENINGS * count, sizeof *c.seconds);
    psplat_result result =
        c.racers && c.contestants && c.times && c.seconds
            ? open_all(&c, error)
            : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu settings", count);
    if (!result) result = time_openings(&c, error);
    if (!result) result = time_frames(&c, progress, user, error);
    for (size_t i = 0; i < count && c.racers; ++i) psplat_specimen_close(&c.racers[i].specimen);
    free(c.racers);
    free(c.contestants);
    free(c.times);
    free(c.seconds);
    return result;
}

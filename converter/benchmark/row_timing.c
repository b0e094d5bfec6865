/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * row_timing.c - all rows of a table timed together: how long opening takes, and how long frames
 * do.
 */
#include "benchmark/row_timing.h"

#include "benchmark/frame_timing.h"
#include "benchmark/make_asset.h"
#include "benchmark/measured_asset.h"
#include "benchmark/sweep_context.h"
#include "table/row.h"
#include "table/setting.h"
#include "table/sweep_table.h"
#include "views/picture_views.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdlib.h>

/* Each asset is opened so often. */
enum { OPENINGS = 9 };

/* The standard error of what frames take, as a part of it, that suffices: settings that differ by
 * less are as fast as each other to any user. */
static const double precision = 0.05;

/* A row, and what it draws. Each asset is opened for its first row alone. */
typedef struct drawn_row {
    const psplat_setting *setting;
    psplat_measured_asset own;
    const psplat_measured_asset *shown; /* its own, or that of the row before */
    psplat_sweep_context *context;
} drawn_row;

typedef struct timing {
    psplat_sweep_table *table;
    psplat_sweep_context *context;
    const char *folder;
    drawn_row *rows; /* these three are of table->count */
    psplat_timed_frame *frames;
    psplat_frame_times *times;
    double *seconds; /* OPENINGS of each row */
} timing;

static psplat_result draw(void *self, const psplat_view *view, psplat_error *error) {
    const drawn_row *r = self;
    if (r->setting->competitor == PSPLAT_COMPETITOR_MESH)
        return psplat_picture_views_draw_source(r->context->views, view, error);
    if (r->setting->competitor == PSPLAT_COMPETITOR_GLTFPACK)
        return psplat_picture_views_draw_source(r->shown->views, view, error);
    psplat_view drawn = *view;
    const psplat_item item = {.model = r->shown->model};
    drawn.mode = r->setting->mode;
    return psplat_draw(r->context->renderer, &drawn, &item, 1, error);
}

static int shares_previous(const psplat_sweep_table *table, size_t row) {
    const psplat_row *rows = table->rows;
    return row && psplat_setting_shares_asset(&rows[row].setting, &rows[row - 1].setting);
}

static psplat_result open_asset(const timing *t, size_t row, psplat_measured_asset *asset,
                                psplat_error *error) {
    const psplat_setting *setting = &t->table->rows[row].setting;
    char *path = psplat_make_asset_path(t->folder, setting);
    if (!path) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    psplat_result result = psplat_measured_asset_open(asset, t->context, setting, path, error);
    free(path);
    return result;
}

/* A simplified mesh is drawn by picture views of its own, whose pictures are of no use here. */
static psplat_result make_views(const timing *t, psplat_measured_asset *asset,
                                psplat_error *error) {
    const psplat_picture_views_desc desc = {
        .host = t->context->host, .source = asset->source_mesh, .size = 16};
    return asset->source_mesh ? psplat_picture_views_create(&desc, &asset->views, error)
                              : PSPLAT_OK;
}

static psplat_result open_all(timing *t, psplat_error *error) {
    psplat_result result = psplat_sweep_context_views(t->context, error);
    for (size_t i = 0; i < t->table->count && !result; ++i) {
        drawn_row *r = &t->rows[i];
        *r = (drawn_row){.setting = &t->table->rows[i].setting, .context = t->context};
        t->frames[i] = (psplat_timed_frame){draw, r};
        if (r->setting->competitor == PSPLAT_COMPETITOR_MESH) continue;
        r->shown = shares_previous(t->table, i) ? t->rows[i - 1].shown : &r->own;
        if (r->shown != &r->own) continue;
        result = open_asset(t, i, &r->own, error);
        if (!result) result = make_views(t, &r->own, error);
    }
    return result;
}

/* ---- opening ------------------------------------------------------------------------------ */

static psplat_result time_opening(const timing *t, size_t row, double *seconds,
                                  psplat_error *error) {
    psplat_measured_asset asset = {.asset = NULL};
    double start = psplat_timing_clock();
    psplat_result result = open_asset(t, row, &asset, error);
    *seconds = psplat_timing_clock() - start;
    psplat_measured_asset_close(&asset);
    return result;
}

/* Only splats are opened: what is opened of a mesh here is made for comparing, not for drawing. */
static psplat_result time_openings(timing *t, psplat_error *error) {
    const psplat_sweep_table *table = t->table;
    psplat_result result = PSPLAT_OK;
    for (size_t round = 0; round < OPENINGS; ++round)
        for (size_t i = 0; i < table->count && !result; ++i)
            if (table->rows[i].setting.competitor == PSPLAT_COMPETITOR_SPLATS &&
                !shares_previous(table, i))
                result = time_opening(t, i, &t->seconds[OPENINGS * i + round], error);
    for (size_t i = 0; i < table->count && !result; ++i) {
        double *load = &table->rows[i].values[PSPLAT_COLUMN_LOAD_MS];
        *load = NAN;
        if (table->rows[i].setting.competitor != PSPLAT_COMPETITOR_SPLATS) continue;
        *load = shares_previous(table, i)
                    ? table->rows[i - 1].values[PSPLAT_COLUMN_LOAD_MS]
                    : 1e3 * psplat_timing_quartiles(&t->seconds[OPENINGS * i], OPENINGS).median;
    }
    return result;
}

/* ---- frames ------------------------------------------------------------------------------- */

static void fill_quartiles(double *values, const psplat_quartiles *quartiles) {
    values[0] = quartiles->median;
    values[1] = quartiles->low;
    values[2] = quartiles->high;
}

static psplat_result time_frames(timing *t, int (*progress)(void *user, double fraction),
                                 void *user, psplat_error *error) {
    const psplat_sweep_table *table = t->table;
    psplat_view views[PSPLAT_PICTURE_VIEWS];
    for (int i = 0; i < PSPLAT_PICTURE_VIEWS; ++i)
        views[i] = psplat_picture_views_at(t->context->views, i);
    const psplat_timing_desc desc = {.host = t->context->host,
                                     .views = views,
                                     .view_count = PSPLAT_PICTURE_VIEWS,
                                     .timed = t->frames,
                                     .count = table->count,
                                     .rounds = table->options.frames,
                                     .precision = precision,
                                     .progress = progress,
                                     .user = user};
    psplat_result result = psplat_timing_run(&desc, t->times, error);
    for (size_t i = 0; i < table->count && !result; ++i) {
        double *values = table->rows[i].values;
        values[PSPLAT_COLUMN_FRAMES] = t->times[i].frames;
        fill_quartiles(values + PSPLAT_COLUMN_CPU_MS, &t->times[i].cpu);
        fill_quartiles(values + PSPLAT_COLUMN_WALL_MS, &t->times[i].wall);
        fill_quartiles(values + PSPLAT_COLUMN_GPU_MS, &t->times[i].gpu);
    }
    return result;
}

static int is_timed(const psplat_row *row, psplat_column cost, int frames) {
    const double *values = row->values;
    double drawn = values[PSPLAT_COLUMN_FRAMES];
    const psplat_quartiles quartiles = {values[cost], values[cost + 1], values[cost + 2]};
    if (!(drawn > 0)) return 0;
    return drawn >= frames || (fmod(drawn, PSPLAT_PICTURE_VIEWS) == 0 &&
                               psplat_timing_is_precise(&quartiles, (size_t)drawn, precision));
}

int psplat_row_timing_is_done(const psplat_sweep_table *table) {
    psplat_column cost = psplat_rows_cost(table->rows, table->count);
    for (size_t i = 0; i < table->count; ++i)
        if (!is_timed(&table->rows[i], cost, table->options.frames)) return 0;
    return 1;
}

psplat_result psplat_row_timing_run(psplat_sweep_table *table, psplat_sweep_context *context,
                                    const char *folder,
                                    int (*progress)(void *user, double fraction), void *user,
                                    psplat_error *error) {
    size_t count = table->count;
    timing t = {.table = table, .context = context, .folder = folder};
    t.rows = calloc(count, sizeof *t.rows);
    t.frames = calloc(count, sizeof *t.frames);
    t.times = calloc(count, sizeof *t.times);
    t.seconds = calloc(OPENINGS * count, sizeof *t.seconds);
    psplat_result result =
        t.rows && t.frames && t.times && t.seconds
            ? open_all(&t, error)
            : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu settings", count);
    if (!result) result = time_openings(&t, error);
    if (!result) result = time_frames(&t, progress, user, error);
    for (size_t i = 0; i < count && t.rows; ++i) psplat_measured_asset_close(&t.rows[i].own);
    free(t.rows);
    free(t.frames);
    free(t.times);
    free(t.seconds);
    return result;
}

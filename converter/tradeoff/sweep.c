/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sweep.c - asset by asset is made and compared, and each row is kept in the table as soon as it is
 * measured. Then all are timed together. What the table has already is not measured again.
 */
#include "tradeoff/sweep.h"

#include "base/path.h"
#include "benchmark/gltfpack.h"
#include "benchmark/make_asset.h"
#include "benchmark/measured_asset.h"
#include "benchmark/row_timing.h"
#include "benchmark/sweep_context.h"
#include "benchmark/sweep_progress.h"
#include "table/folder.h"
#include "table/row.h"
#include "table/setting.h"
#include "table/sweep_options.h"
#include "table/sweep_table.h"
#include "table/text.h"
#include "tradeoff/charts.h"
#include "tradeoff/page.h"

#include <phongsplat/host.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct sweep {
    const psplat_sweep_desc *desc;
    psplat_sweep_table *table;
    psplat_sweep_counts *counts;
    psplat_sweep_context context;
    psplat_gltfpack gltfpack;
    psplat_sweep_progress progress;
} sweep;

static void warn(const sweep *s, const char *text) {
    if (s->desc->warn) s->desc->warn(s->desc->user, text);
}

/* ---- the table ---------------------------------------------------------------------------- */

/* Writes a text into the folder and frees it. */
static psplat_result write_text(const sweep *s, const char *name, psplat_text *text,
                                psplat_error *error) {
    psplat_result result = psplat_text_check(text, error);
    if (!result) result = psplat_folder_write(s->desc->folder, name, text->data, text->size, error);
    free(text->data);
    return result;
}

static psplat_result save(const sweep *s, psplat_error *error) {
    psplat_text text = {0};
    psplat_sweep_table_write(s->table, &text);
    return write_text(s, psplat_folder_table, &text, error);
}

/* Takes over the rows of an earlier sweep whose assets are still there; the first is the source. */
static psplat_result recall(const sweep *s, psplat_error *error) {
    const char *folder = s->desc->folder;
    char *data = NULL, shown[PSPLAT_SHOWN_PATH];
    size_t size = 0;
    psplat_error cause = {0};
    psplat_result result = psplat_folder_read(folder, psplat_folder_table, &data, &size, error);
    if (result) return result;
    result = psplat_sweep_table_recall(s->table, data, size, &cause);
    free(data);
    psplat_path_shorten(folder, shown);
    if (result)
        return psplat_fail(error, result, 0, "%s/%s: %.80s; --fresh starts over", shown,
                           psplat_folder_table, cause.text);
    for (size_t i = 1; i < s->table->count; ++i) {
        psplat_row *row = &s->table->rows[i], empty = psplat_row_empty(&row->setting);
        if (psplat_make_asset_is_done(folder, row)) continue;
        empty.key = row->key;
        *row = empty;
    }
    return PSPLAT_OK;
}

/* Only the time of the source needs measuring. */
static void fill_source(const sweep *s, psplat_row *row) {
    row->values[PSPLAT_COLUMN_BYTES] = (double)s->context.source_bytes;
    row->values[PSPLAT_COLUMN_ELEMENTS] = (double)s->context.mesh.triangle_count;
    row->is_measured = 1;
}

/* Counts the rows that draw the same asset, from first on. */
static size_t count_drawings(const psplat_sweep_table *table, size_t first) {
    size_t count = 1;
    while (first + count < table->count &&
           psplat_setting_shares_asset(&table->rows[first].setting,
                                       &table->rows[first + count].setting))
        ++count;
    return count;
}

/* Returns the first row of count that is measured, or NULL. */
static const psplat_row *find_measured(const psplat_row *rows, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (rows[i].is_measured) return &rows[i];
    return NULL;
}

static void plan_progress(sweep *s) {
    const psplat_sweep_table *table = s->table;
    for (size_t first = 0, count = 1; first < table->count; first += count) {
        const psplat_row *rows = &table->rows[first];
        count = count_drawings(table, first);
        if (!find_measured(rows, count)) {
            psplat_sweep_progress_plan(&s->progress, PSPLAT_TASK_MAKE, &rows->setting);
            psplat_sweep_progress_plan(&s->progress, PSPLAT_TASK_SHAPE, &rows->setting);
        }
        for (size_t i = 0; i < count; ++i) {
            psplat_sweep_progress_plan(&s->progress, PSPLAT_TASK_TIME, &rows->setting);
            if (!rows[i].is_measured)
                psplat_sweep_progress_plan(&s->progress, PSPLAT_TASK_PICTURE, &rows->setting);
        }
    }
}

static psplat_result plan(sweep *s, psplat_error *error) {
    psplat_sweep_table *t = s->table;
    const psplat_sweep_options *o = &t->options;
    s->context.size = o->size;
    s->context.crease_angle = o->no_creases ? HUGE_VAL : o->crease_angle;
    t->source_hash = s->context.source_hash;
    snprintf(t->graphics, sizeof t->graphics, "%s, %s", psplat_host_renderer(s->context.host),
             psplat_host_version(s->context.host));
    memcpy(t->gltfpack, s->gltfpack.version, sizeof t->gltfpack);
    psplat_result result = psplat_sweep_table_plan(t, error);
    if (!result && !s->desc->fresh) result = recall(s, error);
    if (result) return result;
    fill_source(s, &t->rows[0]);
    plan_progress(s);
    return PSPLAT_OK;
}

/* ---- measuring ---------------------------------------------------------------------------- */

/* Makes the asset of count rows and compares its shape. */
static psplat_result make(sweep *s, psplat_row *row, psplat_measured_asset *asset, const char *path,
                          psplat_error *error) {
    const psplat_asset_maker maker = {&s->context, s->desc->folder, &s->table->options,
                                      &s->gltfpack, &s->progress};
    psplat_result result = psplat_make_asset(&maker, row, error);
    if (!result)
        result = psplat_measured_asset_open(asset, &s->context, &row->setting, path, error);
    if (!result)
        result = psplat_sweep_progress_begin(&s->progress, PSPLAT_TASK_SHAPE, &row->setting, error);
    if (result) return result;
    return psplat_measured_asset_shape(asset, &s->context, s->table->options.samples, row, error);
}

static psplat_result measure_picture(sweep *s, const psplat_measured_asset *asset, psplat_row *row,
                                     psplat_error *error) {
    psplat_result result =
        psplat_sweep_progress_begin(&s->progress, PSPLAT_TASK_PICTURE, &row->setting, error);
    if (!result) result = psplat_measured_asset_picture(asset, &s->context, row, error);
    if (!result && row->setting.mode == PSPLAT_MODE_PHONG)
        result =
            psplat_measured_asset_show(asset, &s->context, &row->setting, s->desc->folder, error);
    if (result) return result;
    row->is_measured = 1;
    ++s->counts->measured;
    return save(s, error);
}

/* Measures those of count rows of one asset that are not measured yet. The asset was made, and its
 * shape compared, where any of them is. */
static psplat_result measure_asset(sweep *s, psplat_row *rows, size_t count, psplat_error *error) {
    psplat_measured_asset asset = {.asset = NULL};
    char *path = psplat_make_asset_path(s->desc->folder, &rows->setting);
    const psplat_row *known = find_measured(rows, count);
    psplat_result result = PSPLAT_OK;
    if (!path)
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    else if (known)
        result = psplat_measured_asset_open(&asset, &s->context, &rows->setting, path, error);
    else
        result = make(s, rows, &asset, path, error);
    if (!known) known = rows;
    for (size_t i = 0; i < count && !result; ++i) {
        if (rows[i].is_measured) continue;
        if (&rows[i] != known)
            memcpy(rows[i].values, known->values,
                   PSPLAT_FIRST_PICTURE_COLUMN * sizeof *rows->values);
        result = measure_picture(s, &asset, &rows[i], error);
    }
    psplat_measured_asset_close(&asset);
    free(path);
    return result;
}

/* A setting may fail while others go on: with too small a tolerance for the model, a program that
 * fails, a mesh that it left nothing of. */
static int is_of_setting(const psplat_setting *setting, psplat_result result) {
    if (setting->competitor == PSPLAT_COMPETITOR_SPLATS) return result == PSPLAT_ERROR_RANGE;
    return result != PSPLAT_ERROR_INTERRUPTED && result != PSPLAT_ERROR_MEMORY &&
           result != PSPLAT_ERROR_WRITE && result != PSPLAT_ERROR_GRAPHICS;
}

static void leave_out(sweep *s, size_t first, size_t count, const psplat_error *cause) {
    psplat_text text = {0};
    psplat_setting_describe(&s->table->rows[first].setting, &text);
    psplat_text_add(&text, ": left out: %s", cause->text);
    if (!text.failed) warn(s, text.data);
    free(text.data);
    psplat_sweep_table_remove(s->table, first, count);
}

static psplat_result measure_assets(sweep *s, psplat_error *error) {
    psplat_sweep_table *t = s->table;
    for (size_t first = 1, count; first < t->count; first += count) {
        psplat_row *rows = &t->rows[first];
        psplat_error cause = {0};
        size_t measured = 0;
        count = count_drawings(t, first);
        for (size_t i = 0; i < count; ++i) measured += rows[i].is_measured != 0;
        psplat_result result = measured < count ? measure_asset(s, rows, count, &cause) : PSPLAT_OK;
        if (!result) continue;
        if (!is_of_setting(&rows->setting, result)) {
            if (error) *error = cause;
            return result;
        }
        leave_out(s, first, count, &cause);
        count = 0;
    }
    return PSPLAT_OK;
}

/* Times all rows where any of them was not timed well enough. */
static psplat_result measure_times(sweep *s, psplat_error *error) {
    psplat_sweep_table *t = s->table;
    if (psplat_row_timing_is_done(t)) return PSPLAT_OK;
    psplat_result result =
        psplat_sweep_progress_begin(&s->progress, PSPLAT_TASK_TIME, &t->rows->setting, error);
    if (!result)
        result = psplat_row_timing_run(t, &s->context, s->desc->folder, psplat_sweep_progress_show,
                                       &s->progress, error);
    if (!result) s->counts->timed = t->count;
    return result;
}

/* ---- the whole ---------------------------------------------------------------------------- */

static psplat_result publish(const sweep *s, psplat_error *error) {
    psplat_text page = {0};
    char left_out[PSPLAT_CHARTS_CAUSE] = "";
    psplat_result result = psplat_charts_write(s->table, s->desc->folder, left_out, error);
    if (result) return result;
    if (*left_out) warn(s, left_out);
    psplat_page_write(s->table, s->desc->folder, !*left_out, &page);
    return write_text(s, "index.html", &page, error);
}

static void find_gltfpack(sweep *s) {
    const char *program = s->desc->gltfpack;
    if (program && !*program) return;
    s->gltfpack = psplat_gltfpack_find(program);
    if (program && !*s->gltfpack.version) warn(s, "gltfpack cannot be run; it is left out");
}

static psplat_result run(sweep *s, psplat_error *error) {
    psplat_result result = psplat_sweep_context_open(&s->context, error);
    if (!result) result = psplat_folder_open(s->desc->folder, error);
    if (result) return result;
    find_gltfpack(s);
    result = plan(s, error);
    if (!result && s->desc->fresh) result = save(s, error);
    if (!result) result = measure_assets(s, error);
    if (!result) result = measure_times(s, error);
    if (!result) result = save(s, error);
    return result ? result : publish(s, error);
}

psplat_result psplat_sweep_run(const psplat_sweep_desc *desc, psplat_sweep_table *table,
                               psplat_sweep_counts *counts, psplat_error *error) {
    sweep s = {.desc = desc, .table = table, .counts = counts};
    *table = (psplat_sweep_table){.options = desc->options, .source = desc->source};
    *counts = (psplat_sweep_counts){0};
    psplat_sweep_options_complete(&table->options);
    s.context = (psplat_sweep_context){.path = desc->source, .software = desc->software};
    s.progress = (psplat_sweep_progress){.report = desc->progress, .user = desc->user};
    psplat_result result = run(&s, error);
    psplat_sweep_context_close(&s.context);
    return result;
}

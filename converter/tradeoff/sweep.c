/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sweep.c - asset by asset: made, compared, and kept in the journal after each step; then all timed
 * together. What the journal has already, on equal stamps, is not measured again.
 */
#include "sweep.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char journal_name[] = "tradeoff.csv", page_name[] = "index.html";

static void warn(const psplat_sweep *s, const char *text) {
    if (s->desc->warn) s->desc->warn(s->desc->user, text);
}

/* ---- the journal -------------------------------------------------------------------------- */

static psplat_result save(const psplat_sweep *s, psplat_error *error) {
    psplat_text text = {0};
    psplat_journal_write(s->journal, &text);
    return psplat_make_text(s, journal_name, &text, error);
}

/* Charts and page say what the journal says, finished or not. */
static psplat_result publish(const psplat_sweep *s, psplat_error *error) {
    psplat_chart charts[PSPLAT_CHARTS];
    psplat_text text = {0};
    psplat_column cost = psplat_rows_cost(s->journal->rows, s->journal->count);
    size_t count = psplat_chart_list(cost, charts);
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < count && !result; ++i) {
        psplat_chart_write(&charts[i], s->journal, &text);
        result = psplat_make_text(s, charts[i].file, &text, error);
    }
    if (result) return result;
    psplat_page_write(s->journal, &text);
    return psplat_make_text(s, page_name, &text, error);
}

/* What was measured before; nothing where there is none or it is not wanted. */
static psplat_result read_journal(const psplat_sweep *s, psplat_journal *before,
                                  psplat_error *error) {
    char *data = NULL, shown[PSPLAT_SHOWN_PATH];
    size_t size = 0;
    psplat_error cause = {0};
    if (s->desc->fresh) return PSPLAT_OK;
    psplat_result result = psplat_folder_read(&s->folder, journal_name, &data, &size, error);
    if (result || !data) return result;
    result = psplat_journal_read(data, size, before, &cause);
    free(data);
    if (!result) return PSPLAT_OK;
    psplat_path_shorten(s->folder.path, shown);
    return psplat_fail(error, result, 0, "%s/%s: %.80s; --fresh starts over", shown, journal_name,
                       cause.text);
}

static const psplat_row *find(const psplat_journal *journal, const psplat_setting *setting) {
    for (size_t i = 0; i < journal->count; ++i)
        if (psplat_setting_is_same(&journal->rows[i].setting, setting)) return &journal->rows[i];
    return NULL;
}

/* Assets of settings that are no longer asked for. */
static void remove_dropped(const psplat_sweep *s, const psplat_journal *before) {
    for (size_t i = 0; i < before->count; ++i) {
        const psplat_setting *old = &before->rows[i].setting;
        int is_used = old->contender == PSPLAT_CONTENDER_MESH;
        for (size_t k = 0; k < s->journal->count && !is_used; ++k)
            is_used = psplat_setting_shares_asset(old, &s->journal->rows[k].setting);
        if (!is_used) psplat_make_remove(s, old);
    }
}

/* ---- planning ----------------------------------------------------------------------------- */

static uint64_t expected(const psplat_sweep *s, const psplat_row *row, psplat_group group) {
    return psplat_plan_stamp(s->journal, row, s->bench.stamp, group);
}

static int is_measured(const psplat_sweep *s, const psplat_row *row, psplat_group group) {
    return row->stamps[group] && row->stamps[group] == expected(s, row, group);
}

/* Takes over what holds still. Timings are judged at the end. */
static void take_over(const psplat_sweep *s, psplat_row *row, const psplat_row *old) {
    size_t bytes = 0;
    psplat_row_copy(row, old, PSPLAT_GROUP_MADE);
    int is_kept = is_measured(s, row, PSPLAT_GROUP_MADE);
    if (is_kept && row->setting.contender != PSPLAT_CONTENDER_MESH)
        is_kept = row->content && psplat_make_stamp(s, &row->setting, &bytes) == row->content;
    if (!is_kept) {
        psplat_row_forget(row, PSPLAT_GROUP_MADE);
        return;
    }
    for (int group = PSPLAT_GROUP_SHAPED; group <= PSPLAT_GROUP_TIMED; ++group) {
        psplat_row_copy(row, old, (psplat_group)group);
        if (group != PSPLAT_GROUP_TIMED && !is_measured(s, row, (psplat_group)group))
            psplat_row_forget(row, (psplat_group)group);
    }
}

/* The source needs no measuring but of its time. */
static void fill_source(const psplat_sweep *s, psplat_row *row) {
    row->values[PSPLAT_COLUMN_BYTES] = (double)s->bench.bytes;
    row->values[PSPLAT_COLUMN_ELEMENTS] = (double)s->bench.mesh.triangle_count;
    row->stamps[PSPLAT_GROUP_MADE] = expected(s, row, PSPLAT_GROUP_MADE);
}

static void plan_tasks(psplat_sweep *s, size_t row) {
    const psplat_row *r = &s->journal->rows[row];
    double *planned = s->estimate.planned;
    planned[PSPLAT_TASK_TIME] += s->journal->options.frames;
    if (r->setting.contender == PSPLAT_CONTENDER_MESH) return;
    if (!row || !psplat_setting_shares_asset(&r->setting, &r[-1].setting)) {
        if (!r->stamps[PSPLAT_GROUP_MADE])
            planned[psplat_make_task(&r->setting)] += psplat_make_share(&r->setting);
        if (!r->stamps[PSPLAT_GROUP_SHAPED]) ++planned[PSPLAT_TASK_SHAPE];
    }
    if (!r->stamps[PSPLAT_GROUP_PICTURED]) ++planned[PSPLAT_TASK_PICTURE];
}

/* Whether gltfpack's rows are part of it: it can be run, or was once. */
static psplat_result plan(psplat_sweep *s, const psplat_journal *before, psplat_error *error) {
    psplat_journal *j = s->journal;
    j->options = s->desc->options;
    psplat_tradeoff_options_inherit(&j->options, &before->options);
    const psplat_tradeoff_options defaults = psplat_tradeoff_options_default();
    psplat_tradeoff_options_inherit(&j->options, &defaults);
    s->bench.size = j->options.size;
    s->bench.crease_angle = j->options.no_creases ? HUGE_VAL : j->options.crease_angle;
    snprintf(j->source, sizeof j->source, "%s", s->desc->source);
    snprintf(j->graphics, sizeof j->graphics, "%s, %s", psplat_host_renderer(s->bench.host),
             psplat_host_version(s->bench.host));
    memcpy(j->gltfpack, *s->gltfpack.version ? s->gltfpack.version : before->gltfpack,
           sizeof j->gltfpack);
    psplat_result result =
        psplat_plan_rows(&j->options, *j->gltfpack != 0, &j->rows, &j->count, error);
    for (size_t i = 0; i < j->count && !result; ++i) {
        const psplat_row *old = find(before, &j->rows[i].setting);
        if (old) take_over(s, &j->rows[i], old);
        if (j->rows[i].setting.contender == PSPLAT_CONTENDER_MESH) fill_source(s, &j->rows[i]);
        plan_tasks(s, i);
    }
    return result;
}

/* ---- comparing ---------------------------------------------------------------------------- */

/* rows: count of one asset. */
static void share(psplat_row *rows, size_t count, psplat_group group) {
    for (size_t i = 1; i < count; ++i) psplat_row_copy(&rows[i], &rows[0], group);
}

static psplat_result measure_shape(psplat_sweep *s, const psplat_specimen *specimen,
                                   psplat_row *rows, size_t count, psplat_error *error) {
    if (is_measured(s, &rows[0], PSPLAT_GROUP_SHAPED)) return PSPLAT_OK;
    psplat_result result =
        psplat_task_begin(s, PSPLAT_TASK_SHAPE, 1, "comparing shapes", &rows[0], error);
    if (!result)
        result = psplat_specimen_shape(specimen, &s->bench, s->journal->options.samples, &rows[0],
                                       error);
    if (result) return result;
    rows[0].stamps[PSPLAT_GROUP_SHAPED] = expected(s, &rows[0], PSPLAT_GROUP_SHAPED);
    share(rows, count, PSPLAT_GROUP_SHAPED);
    ++s->counts->shapes;
    psplat_task_end(s);
    return save(s, error);
}

static psplat_result measure_picture(psplat_sweep *s, const psplat_specimen *specimen,
                                     psplat_row *row, psplat_error *error) {
    if (is_measured(s, row, PSPLAT_GROUP_PICTURED)) return PSPLAT_OK;
    psplat_result result =
        psplat_task_begin(s, PSPLAT_TASK_PICTURE, 1, "comparing pictures", row, error);
    if (!result)
        result = psplat_specimen_picture(specimen, &s->bench, s->journal->options.perceptual, row,
                                         error);
    if (result) return result;
    row->stamps[PSPLAT_GROUP_PICTURED] = expected(s, row, PSPLAT_GROUP_PICTURED);
    ++s->counts->pictures;
    psplat_task_end(s);
    return save(s, error);
}

static int is_complete(const psplat_sweep *s, const psplat_row *rows, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (!is_measured(s, &rows[i], PSPLAT_GROUP_SHAPED) ||
            !is_measured(s, &rows[i], PSPLAT_GROUP_PICTURED))
            return 0;
    return 1;
}

static psplat_result compare(psplat_sweep *s, psplat_row *rows, size_t count, psplat_error *error) {
    if (is_complete(s, rows, count)) return PSPLAT_OK;
    psplat_specimen specimen = {.asset = NULL};
    char *path = psplat_contest_path(&s->folder, &rows[0].setting);
    psplat_result result =
        path ? psplat_specimen_open(&specimen, &s->bench, &rows[0].setting, path, error)
             : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    free(path);
    if (!result) result = measure_shape(s, &specimen, rows, count, error);
    for (size_t i = 0; i < count && !result; ++i)
        result = measure_picture(s, &specimen, &rows[i], error);
    psplat_specimen_close(&specimen);
    return result;
}

/* ---- the whole ---------------------------------------------------------------------------- */

/* What a setting may fail with while others go on: too small a tolerance for the model, a program
 * that fails, a mesh that it left nothing of. */
static int is_of_setting(const psplat_setting *setting, psplat_result result) {
    if (setting->contender == PSPLAT_CONTENDER_SPLATS) return result == PSPLAT_ERROR_RANGE;
    return result != PSPLAT_ERROR_INTERRUPTED && result != PSPLAT_ERROR_MEMORY &&
           result != PSPLAT_ERROR_WRITE && result != PSPLAT_ERROR_GRAPHICS;
}

static void drop(psplat_sweep *s, size_t first, size_t count, const psplat_error *cause) {
    psplat_journal *j = s->journal;
    psplat_text text = {0};
    psplat_setting_describe(&j->rows[first].setting, &text);
    psplat_text_add(&text, ": left out: %s", cause->text);
    if (!text.failed) warn(s, text.data);
    free(text.data);
    memmove(&j->rows[first], &j->rows[first + count], (j->count - first - count) * sizeof *j->rows);
    j->count -= count;
}

/* The rows of one asset, from first on. */
static psplat_result measure_asset(psplat_sweep *s, size_t first, size_t count,
                                   psplat_error *error) {
    psplat_row *rows = &s->journal->rows[first];
    psplat_result result = PSPLAT_OK;
    if (rows[0].setting.contender == PSPLAT_CONTENDER_MESH) return PSPLAT_OK;
    if (!rows[0].stamps[PSPLAT_GROUP_MADE]) {
        result = psplat_make_asset(s, &rows[0], error);
        if (!result) share(rows, count, PSPLAT_GROUP_MADE);
        if (!result) result = save(s, error);
    }
    return result ? result : compare(s, rows, count, error);
}

static psplat_result measure_assets(psplat_sweep *s, psplat_error *error) {
    psplat_journal *j = s->journal;
    for (size_t first = 0, count = 1; first < j->count; first += count) {
        const psplat_setting *setting = &j->rows[first].setting;
        count = 1;
        while (first + count < j->count &&
               psplat_setting_shares_asset(setting, &j->rows[first + count].setting))
            ++count;
        psplat_error cause = {0};
        psplat_result result = measure_asset(s, first, count, &cause);
        if (result && !is_of_setting(setting, result)) {
            if (error) *error = cause;
            return result;
        }
        if (!result) continue;
        drop(s, first, count, &cause);
        count = 0;
    }
    return PSPLAT_OK;
}

static int is_timed(const psplat_sweep *s) {
    for (size_t i = 0; i < s->journal->count; ++i)
        if (!is_measured(s, &s->journal->rows[i], PSPLAT_GROUP_TIMED)) return 0;
    return 1;
}

static psplat_result measure_times(psplat_sweep *s, psplat_error *error) {
    psplat_journal *j = s->journal;
    if (is_timed(s)) return PSPLAT_OK;
    for (size_t i = 0; i < j->count; ++i) psplat_row_forget(&j->rows[i], PSPLAT_GROUP_TIMED);
    psplat_result result = publish(s, error);
    if (!result)
        result = psplat_task_begin(s, PSPLAT_TASK_TIME, (double)j->count * j->options.frames,
                                   "timing", NULL, error);
    if (!result) result = psplat_contest_run(j, &s->bench, &s->folder, psplat_task_show, s, error);
    if (result) return result;
    for (size_t i = 0; i < j->count; ++i)
        j->rows[i].stamps[PSPLAT_GROUP_TIMED] = expected(s, &j->rows[i], PSPLAT_GROUP_TIMED);
    s->counts->timings = j->count;
    psplat_task_end(s);
    return PSPLAT_OK;
}

static void find_gltfpack(psplat_sweep *s) {
    const char *program = s->desc->gltfpack;
    if (program && !*program) return;
    s->gltfpack = psplat_gltfpack_find(program);
    if (program && !*s->gltfpack.version) warn(s, "gltfpack cannot be run; it is left out");
}

static psplat_result run(psplat_sweep *s, psplat_journal *before, psplat_error *error) {
    psplat_result result = psplat_workbench_open(&s->bench, error);
    if (!result) result = psplat_folder_open(s->desc->directory, &s->folder, error);
    if (!result) result = read_journal(s, before, error);
    if (result) return result;
    find_gltfpack(s);
    result = plan(s, before, error);
    if (!result) result = measure_assets(s, error);
    if (!result) result = measure_times(s, error);
    if (!result) result = save(s, error);
    if (!result) result = publish(s, error);
    if (!result) remove_dropped(s, before);
    return result;
}

psplat_result psplat_sweep_run(const psplat_sweep_desc *desc, psplat_journal *journal,
                               psplat_sweep_counts *counts, psplat_error *error) {
    psplat_journal before = {.count = 0};
    psplat_sweep s = {.desc = desc, .journal = journal, .counts = counts, .folder = {.lock = -1}};
    *journal = (psplat_journal){.count = 0};
    *counts = (psplat_sweep_counts){.timings = 0};
    s.bench = (psplat_workbench){.path = desc->source, .software = desc->software};
    psplat_result result = run(&s, &before, error);
    psplat_journal_free(&before);
    psplat_workbench_close(&s.bench);
    psplat_folder_close(&s.folder);
    return result;
}

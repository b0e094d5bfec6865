/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * plan.c - the rows of a sweep, and the stamps that say whether what is known of them still holds.
 */
#include "tradeoff.h"

#include <stdlib.h>

/* Of one asset: each mode, with and without filter. */
static void plan_splats(psplat_row *rows, size_t *count, psplat_setting setting) {
    for (int mode = 0; mode < PSPLAT_DRAWN_MODES; ++mode)
        for (int no_filter = 0; no_filter < 2; ++no_filter) {
            setting.mode = (psplat_mode)mode;
            setting.no_filter = no_filter;
            rows[(*count)++] = psplat_row_empty(&setting);
        }
}

psplat_result psplat_plan_rows(const psplat_tradeoff_options *options, int with_gltfpack,
                               psplat_row **rows, size_t *count, psplat_error *error) {
    const size_t drawn = 2 * PSPLAT_DRAWN_MODES * PSPLAT_FIELD_COUNT * PSPLAT_PRECISION_COUNT;
    const psplat_setting source = {.contender = PSPLAT_CONTENDER_MESH};
    *count = 0;
    *rows = malloc((1 + drawn * options->tolerances.count + options->ratios.count) * sizeof **rows);
    if (!*rows) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for rows");
    (*rows)[(*count)++] = psplat_row_empty(&source);
    for (size_t i = 0; i < options->tolerances.count; ++i)
        for (int field = 0; field < PSPLAT_FIELD_COUNT; ++field)
            for (int precision = 0; precision < PSPLAT_PRECISION_COUNT; ++precision) {
                const psplat_setting setting = {.contender = PSPLAT_CONTENDER_SPLATS,
                                                .tolerance = options->tolerances.steps[i],
                                                .field = (psplat_normal_field)field,
                                                .precision = (psplat_stored_as)precision};
                plan_splats(*rows, count, setting);
            }
    for (size_t i = 0; i < options->ratios.count && with_gltfpack; ++i) {
        const psplat_setting setting = {.contender = PSPLAT_CONTENDER_GLTFPACK,
                                        .ratio =
                                            options->ratios.steps[options->ratios.count - 1 - i]};
        (*rows)[(*count)++] = psplat_row_empty(&setting);
    }
    return PSPLAT_OK;
}

/* ---- stamps ------------------------------------------------------------------------------- */

static uint64_t stamp_splats(uint64_t stamp, const psplat_tradeoff_options *o,
                             const psplat_setting *s) {
    const double numbers[] = {s->tolerance,        (double)s->field,     (double)s->precision,
                              o->normal_tolerance, o->crease_angle,      o->no_creases,
                              o->effort,           PSPLAT_VERSION_MAJOR, PSPLAT_VERSION_MINOR,
                              PSPLAT_VERSION_PATCH};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i)
        stamp = psplat_stamp_number(stamp, numbers[i]);
    return psplat_stamp_bytes(stamp, &o->seed, sizeof o->seed);
}

static uint64_t stamp_made(const psplat_journal *j, const psplat_setting *s, uint64_t source) {
    uint64_t stamp = psplat_stamp_bytes(PSPLAT_STAMP, &source, sizeof source);
    stamp = psplat_stamp_text(stamp, psplat_contender_names[s->contender]);
    if (s->contender == PSPLAT_CONTENDER_SPLATS) return stamp_splats(stamp, &j->options, s);
    stamp = psplat_stamp_number(stamp, s->ratio);
    stamp = psplat_stamp_number(stamp, j->options.crease_angle);
    return s->contender == PSPLAT_CONTENDER_GLTFPACK ? psplat_stamp_text(stamp, j->gltfpack)
                                                     : stamp;
}

static uint64_t stamp_asset(uint64_t stamp, const psplat_row *row) {
    stamp = psplat_stamp_bytes(stamp, &row->stamps[PSPLAT_GROUP_MADE], sizeof *row->stamps);
    return psplat_stamp_bytes(stamp, &row->content, sizeof row->content);
}

static uint64_t stamp_pictured(const psplat_journal *j, const psplat_row *row) {
    uint64_t stamp = psplat_stamp_text(stamp_asset(PSPLAT_STAMP, row), j->graphics);
    const double numbers[] = {j->options.size, j->options.perceptual, j->options.crease_angle,
                              (double)row->setting.mode, row->setting.no_filter};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i)
        stamp = psplat_stamp_number(stamp, numbers[i]);
    return stamp;
}

/* All rows took turns: each is part of what the others were timed with. */
static uint64_t stamp_timed(const psplat_journal *j) {
    uint64_t stamp = psplat_stamp_text(PSPLAT_STAMP, j->graphics);
    stamp = psplat_stamp_number(stamp, j->options.size);
    stamp = psplat_stamp_number(stamp, j->options.frames);
    for (size_t i = 0; i < j->count; ++i) stamp = stamp_asset(stamp, &j->rows[i]);
    return stamp;
}

uint64_t psplat_plan_stamp(const psplat_journal *journal, const psplat_row *row, uint64_t source,
                           psplat_group group) {
    const psplat_tradeoff_options *o = &journal->options;
    switch (group) {
    case PSPLAT_GROUP_MADE:
        return stamp_made(journal, &row->setting, source);
    case PSPLAT_GROUP_SHAPED:
        return psplat_stamp_number(psplat_stamp_number(stamp_asset(PSPLAT_STAMP, row), o->samples),
                                   o->crease_angle);
    case PSPLAT_GROUP_PICTURED:
        return stamp_pictured(journal, row);
    default:
        return stamp_timed(journal);
    }
}

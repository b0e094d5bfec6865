/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * advice.c - one setting for what somebody asks for.
 */
#include "tradeoff/advice.h"

#include "table/row.h"
#include "table/setting.h"
#include "tradeoff/pareto.h"

#include <phongsplat/phongsplat.h>

#include <math.h>

const char *const psplat_error_kind_names[] = {"distance", "normal", "image", "outline", NULL};

/* What differs by less is the same to whoever looks: times differ so between runs, and nobody sees
 * so little of a difference between pictures. */
static const double equal_time = 1.05, equal_difference = 1.03;

/* A front without limits is one of these two. */
static const psplat_column front_columns[] = {PSPLAT_COLUMN_BYTES, PSPLAT_COLUMN_DIFFERENCE};

static psplat_column column_of(psplat_error_kind kind) {
    static const psplat_column columns[] = {PSPLAT_COLUMN_DISTANCE_MAX, PSPLAT_COLUMN_NORMAL_RMS,
                                            PSPLAT_COLUMN_DIFFERENCE, PSPLAT_COLUMN_OUTLINE};
    return columns[kind];
}

/* These are the rows that are chosen from, and what they are chosen by. */
typedef struct choice {
    const psplat_row *rows;
    size_t count;
    const psplat_demand *limits;
    psplat_column error, cost;
    psplat_competitor competitor;
    int is_free; /* to leave the defaults of what the error does not see */
} choice;

static double value_of(const choice *c, size_t row, psplat_column column) {
    return c->rows[row].values[column];
}

/* Counts how many steps a setting is from the defaults. */
static int departures(const psplat_setting *s) {
    return (s->form != PSPLAT_FORM_USUAL) + (int)s->mode;
}

static int is_default_unseen(const choice *c, const psplat_setting *s) {
    if (c->limits->error <= 0 || c->limits->kind == PSPLAT_ERROR_KIND_IMAGE) return 1;
    return s->mode == PSPLAT_MODE_PHONG;
}

static double ratio(double value, double limit) {
    if (limit <= 0) return 0;
    return isnan(value) || value < 0 ? INFINITY : value / limit;
}

/* Returns the greatest ratio of a value to its limit, which is at most 1 where all are kept, and
 * infinite where a value is missing. */
static double miss(const choice *c, size_t row) {
    const psplat_demand *l = c->limits;
    double worst = ratio(value_of(c, row, c->error), l->error);
    worst = fmax(worst, ratio(value_of(c, row, PSPLAT_COLUMN_BYTES), l->bytes));
    return fmax(worst, ratio(value_of(c, row, c->cost), l->ms));
}

static int is_candidate(const choice *c, size_t row) {
    const psplat_setting *s = &c->rows[row].setting;
    return s->competitor == c->competitor && (c->is_free || is_default_unseen(c, s)) &&
           miss(c, row) <= 1;
}

/* A value that is missing or makes no sense is never the least. */
static double or_infinite(double value) {
    return isnan(value) || value < 0 ? INFINITY : value;
}

static double least(const choice *c, const size_t *rows, size_t count, psplat_column column) {
    double found = INFINITY;
    for (size_t i = 0; i < count; ++i)
        found = fmin(found, or_infinite(value_of(c, rows[i], column)));
    return found;
}

/* Keeps those whose value is at most factor times the least, and returns how many. */
static size_t narrow(const choice *c, size_t *rows, size_t count, psplat_column column,
                     double factor) {
    double most = least(c, rows, count, column) * factor;
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i)
        if (or_infinite(value_of(c, rows[i], column)) <= most) rows[kept++] = rows[i];
    return kept;
}

/* Chooses the nearest to the defaults of those that cost alike. */
static size_t choose_default(const choice *c, const size_t *candidates, size_t count) {
    size_t chosen = count ? candidates[0] : SIZE_MAX;
    for (size_t i = 1; i < count; ++i)
        if (departures(&c->rows[candidates[i]].setting) < departures(&c->rows[chosen].setting))
            chosen = candidates[i];
    return chosen;
}

/* Chooses the cheapest of the candidates, or the best. */
static size_t choose(const choice *c, size_t *candidates, size_t count) {
    if (c->limits->error <= 0)
        count = narrow(c, candidates, count, PSPLAT_COLUMN_DIFFERENCE, equal_difference);
    count = narrow(c, candidates, count, PSPLAT_COLUMN_BYTES, 1);
    count = narrow(c, candidates, count, c->cost, equal_time);
    return choose_default(c, candidates, count);
}

static size_t choose_fitting(const choice *c, size_t *candidates) {
    size_t count = 0;
    for (size_t i = 0; i < c->count; ++i)
        if (is_candidate(c, i)) candidates[count++] = i;
    return choose(c, candidates, count);
}

static size_t nearest_miss(const choice *c) {
    size_t nearest = SIZE_MAX;
    double smallest = INFINITY;
    for (size_t i = 0; i < c->count; ++i) {
        if (c->rows[i].setting.competitor != c->competitor || !(miss(c, i) < smallest)) continue;
        smallest = miss(c, i);
        nearest = i;
    }
    return nearest;
}

psplat_advice psplat_advise(const psplat_row *rows, size_t count, const psplat_demand *limits,
                            size_t *scratch) {
    psplat_advice advice = {.row = SIZE_MAX, .simplified = SIZE_MAX};
    choice c = {.rows = rows,
                .count = count,
                .limits = limits,
                .error = column_of(limits->kind),
                .cost = psplat_rows_cost(rows, count),
                .competitor = PSPLAT_COMPETITOR_SPLATS};
    for (c.is_free = 0; c.is_free < 2 && advice.row == SIZE_MAX; ++c.is_free)
        advice.row = choose_fitting(&c, scratch);
    advice.fits = advice.row != SIZE_MAX;
    if (!advice.fits) advice.row = nearest_miss(&c);
    c.competitor = PSPLAT_COMPETITOR_GLTFPACK;
    c.is_free = 1;
    advice.simplified = choose_fitting(&c, scratch);
    return advice;
}

/* ---- without limits ----------------------------------------------------------------------- */

/* Chooses how to draw the asset of a row: of those whose pictures differ alike, the fastest. */
static size_t choose_drawing(const choice *c, size_t row, size_t *candidates) {
    size_t count = 0;
    for (size_t i = 0; i < c->count; ++i)
        if (!isnan(value_of(c, i, PSPLAT_COLUMN_DIFFERENCE)) &&
            psplat_setting_shares_asset(&c->rows[i].setting, &c->rows[row].setting))
            candidates[count++] = i;
    count = narrow(c, candidates, count, PSPLAT_COLUMN_DIFFERENCE, equal_difference);
    count = narrow(c, candidates, count, c->cost, equal_time);
    return choose_default(c, candidates, count);
}

size_t psplat_advise_front(const psplat_row *rows, size_t count, size_t *order, uint8_t *is_front) {
    const choice c = {.rows = rows, .count = count, .cost = psplat_rows_cost(rows, count)};
    for (size_t i = 0; i < count; ++i)
        is_front[i] = rows[i].setting.competitor == PSPLAT_COMPETITOR_SPLATS &&
                      choose_drawing(&c, i, order) == i;
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < count && is_front[i]; ++k)
            if (is_front[k] && psplat_pareto_beats(&rows[k], &rows[i], front_columns, 2))
                is_front[i] = 0;
    return psplat_pareto_sort(rows, count, is_front, front_columns[0], order);
}

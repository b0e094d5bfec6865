/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * advice.h - recommends one setting within the user's limits.
 */
#ifndef PHONGSPLAT_TRADEOFF_ADVICE_H
#define PHONGSPLAT_TRADEOFF_ADVICE_H

#include "table/row.h"

typedef enum psplat_error_kind {
    PSPLAT_ERROR_KIND_DISTANCE = 0, /* greatest, two-sided, % of the diagonal */
    PSPLAT_ERROR_KIND_NORMAL,       /* root mean square, degrees */
    PSPLAT_ERROR_KIND_IMAGE,        /* mean difference, % of white */
    PSPLAT_ERROR_KIND_OUTLINE,      /* pixels that only one of both covers, % of the source's */
    PSPLAT_ERROR_KIND_COUNT
} psplat_error_kind;

extern const char *const psplat_error_kind_names[PSPLAT_ERROR_KIND_COUNT + 1]; /* NULL ends them */

typedef struct psplat_demand {
    psplat_error_kind kind;
    double error, bytes, ms; /* 0: no limit */
} psplat_demand;

typedef struct psplat_advice {
    size_t row;        /* SIZE_MAX: no row has the values that the choice needs */
    int fits;          /* 0: nothing keeps the limits, row is the nearest miss */
    size_t simplified; /* the smallest of gltfpack's meshes that keeps them; SIZE_MAX: none does */
} psplat_advice;

/* Chooses the cheapest setting - bytes, then ms - that keeps limits->error and the others, and
 * without a limit of the error the one with the least difference of images. Times that differ by
 * less than 5 %, and differences by less than 3 %, are equal: the default is taken then.
 *
 * What the error does not see stays at its default where that fits: pictures alone tell of modes.
 * The nearest miss is the setting whose greatest ratio of value to limit is the smallest. scratch
 * holds count numbers. */
psplat_advice psplat_advise(const psplat_row *rows, size_t count, const psplat_demand *limits,
                            size_t *scratch);

/* Finds what there is to choose between without limits: of each asset the best way to draw it - of
 * those whose pictures differ alike the fastest -, and of these the ones that no other beats in
 * bytes and difference of pictures. They go into order by ascending size; order and is_front have
 * room for count. Returns how many. */
size_t psplat_advise_front(const psplat_row *rows, size_t count, size_t *order, uint8_t *is_front);

#endif

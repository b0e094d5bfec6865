/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * schedule.c - how far a conversion is: its stages in their order, each with its share of the time.
 */
#include "converter.h"

#include <math.h>
#include <string.h>

/* Shares of the time of typical models at the default tolerance. */
static const struct stage {
    const char *name;
    double share;
} stages[] = {
    {"reading", 0.02},   {"finding creases", 0.02}, {"sampling", 0.03},  {"selecting splats", 0.29},
    {"improving", 0.28}, {"closing holes", 0.32},   {"verifying", 0.03}, {"writing", 0.01},
};

/* A search for a budget goes through all stages between these many times, as one. */
static const char *const searching = "searching", *const search_first = "finding creases",
                         *const search_end = "verifying";

double psplat_schedule_done(const char *stage, double fraction) {
    double before = 0;
    fraction = fmin(fmax(fraction, 0), 1);
    if (!strcmp(stage, searching)) {
        double begin = psplat_schedule_done(search_first, 0);
        return begin + fraction * (psplat_schedule_done(search_end, 0) - begin);
    }
    for (size_t i = 0; i < sizeof stages / sizeof *stages; ++i) {
        if (!strcmp(stages[i].name, stage)) return before + fraction * stages[i].share;
        before += stages[i].share;
    }
    return -1;
}

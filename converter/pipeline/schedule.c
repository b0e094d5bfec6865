/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * schedule.c - the stages of a conversion in their order, each with its share of the time.
 */
#include "pipeline/schedule.h"

#include <math.h>
#include <string.h>

/* The shares of the time that the stages take on typical models at the default tolerance: means of
 * seven conversions of scans, parts and textured models. */
static const struct stage {
    const char *name;
    double share;
} stages[] = {
    {"reading", 0.01},          {"finding creases", 0.02}, {"sampling", 0.02},
    {"selecting splats", 0.16}, {"improving", 0.17},       {"closing holes", 0.15},
    {"closing gaps", 0.18},     {"trimming", 0.08},        {"finishing", 0.13},
    {"verifying", 0.07},        {"writing", 0.01},
};

/* Stages that repeat others, from `first` up to `end`: the search for a budget, and the meshes of a
 * scene. Each takes the time of those that it repeats. */
static const struct loop {
    const char *name, *first, *end;
} loops[] = {
    {"searching", "finding creases", "verifying"},
    {"converting meshes", "finding creases", "writing"},
};

double psplat_schedule_done(const char *stage, double fraction) {
    double before = 0;
    fraction = fmin(fmax(fraction, 0), 1);
    for (size_t i = 0; i < sizeof loops / sizeof *loops; ++i) {
        if (strcmp(stage, loops[i].name) != 0) continue;
        double begin = psplat_schedule_done(loops[i].first, 0);
        return begin + fraction * (psplat_schedule_done(loops[i].end, 0) - begin);
    }
    for (size_t i = 0; i < sizeof stages / sizeof *stages; ++i) {
        if (!strcmp(stages[i].name, stage)) return before + fraction * stages[i].share;
        before += stages[i].share;
    }
    return -1;
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * trial.h - what a region would be as a splat; for those that make candidates.
 */
#ifndef PSPLAT_TRIAL_H
#define PSPLAT_TRIAL_H

#include "stages.h"

/* Where and how a candidate is made. */
typedef struct psplat_seedling {
    const psplat_surface *surface;
    const psplat_samples *samples;
    const psplat_limits *limits;
    psplat_growth *growth;
    uint32_t seed;     /* sample that must be covered, or PSPLAT_NONE */
    uint32_t triangle; /* at the metric's centre */
    psplat_metric metric;
    double gathered; /* reach up to which the neighbourhood is known in this metric */
    size_t relevant; /* samples of the neighbourhood that the region judged may hold */
    int recorded;    /* what the candidate covers stays on record as it is */
    int failed;      /* out of memory */
} psplat_seedling;

/* Spacings up to which a sample stands for the surface around it: blue noise leaves no larger gaps.
 */
#define PSPLAT_GREATEST_GAP 1.5

/* A seedling in the middle of a region, near a triangle; no one sample must be covered. */
psplat_seedling psplat_trial_at(const psplat_surface *surface, const psplat_samples *samples,
                                const psplat_limits *limits, psplat_growth *growth,
                                const psplat_region *region, uint32_t triangle);
/* Turns the metric: n and u are its first and last axes, lengths across both count 1 / stretch. */
void psplat_trial_turn(psplat_seedling *s, const double n[3], const double u[3], double stretch);
/* Knows the surroundings up to reach, unless they end before. 0 when out of memory. */
int psplat_trial_gather(psplat_seedling *s, double reach);
/* Knows the surroundings of a region. 0 when out of memory. */
int psplat_trial_surround(psplat_seedling *s, const psplat_region *region);

/* Creases inside the ellipse, on the side of the surface that the splat lies on. Returns their
 * number, in growth->segments, and how far they leave the plane. */
size_t psplat_trial_segments(const psplat_seedling *s, const psplat_region *region, double *height);
/* Samples that the region covers, into growth->chosen with their parameters: inside its ellipse
 * less the margin, within the tolerance, facing its way. Returns 0 where the seed is not among
 * them. */
size_t psplat_trial_cover(psplat_seedling *s, const psplat_region *region);
/* Fits the normal field to growth->chosen, without gradients where those would run wild or are not
 * wanted. Returns 0 where it errs by more than the limit. */
int psplat_trial_field(const psplat_seedling *s, const psplat_region *region, size_t count,
                       double field[5]);
/* trial_tint.c: whether the colours of growth->chosen are near enough to one that changes linearly.
 */
int psplat_trial_tint(const psplat_seedling *s, size_t count);
/* Whether the outline lies near the surface, going by samples. */
int psplat_trial_outline_near(const psplat_seedling *s, const psplat_region *region);
/* Whether all of a region is near the part of the mesh that is connected with the seed. The nearest
 * sample and its triangle mostly say so; only points that they are too far from ask the mesh. */
int psplat_trial_near_mesh(psplat_seedling *s, const psplat_region *region);
/* Makes growth->chosen (count of them, inside region) the candidate's own. */
void psplat_trial_adopt(psplat_seedling *s, const psplat_region *region, const double field[5],
                        size_t count, psplat_candidate *candidate);
/* Turns the frame so that the larger radius comes first. */
void psplat_trial_order_axes(psplat_region *region);

/* Gives the region lines, and makes it the candidate's if it is then as large as least_area or
 * covers more, keeps the limits, and covers what the candidate covers. Returns whether it did. */
int psplat_trial_accept(psplat_seedling *s, psplat_region *region, double least_area,
                        psplat_candidate *candidate);
/* widen.c: makes the candidate's ellipse as large as the limits allow, along both axes, then each,
 * up to `most` times, to within (most - 1) / 2^(steps - 1). */
void psplat_trial_widen(psplat_seedling *s, psplat_candidate *candidate, double most, int steps);

#endif

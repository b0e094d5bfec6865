/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * evaluate.h - the evaluation of a region as a splat: what it covers, and whether it keeps the
 * limits.
 *
 * All code that makes candidates uses it. psplat_evaluate always takes the same steps in the same
 * order: it chooses the clip lines that keep the region on its side of the creases, finds the
 * samples that it covers, checks whether one colour and one field of texture coordinates suit them,
 * checks whether all of the region is
 * near the surface, and fits the normal field. Where any reason will do, a region that is certain
 * to leave the surface is refused before its samples are looked at. It changes only the scratch and
 * the reach that the site records.
 */
#ifndef PHONGSPLAT_FIT_EVALUATE_H
#define PHONGSPLAT_FIT_EVALUATE_H

#include "base/region.h"
#include "features/neighborhood.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "fit/fit_context.h"

#include <phongsplat/splat.h>

/* ---- bounds that several files share; all were chosen by hand ------------------------------- */

/* The distance, in spacings, up to which a sample stands for the surface around it: blue noise
 * leaves no larger gaps. */
#define PSPLAT_GREATEST_GAP 1.5
/* The least cosine between a splat's normal and those of the samples that it covers: beyond,
 * homogeneous normals with third coordinate 1 grow without bound (BSK04 section 3). */
#define PSPLAT_LEAST_COVERED_COSINE 0.25
/* The same between the normal of a curved splat's surface and that of a sample beneath it: the
 * surface follows the samples. */
#define PSPLAT_LEAST_SURFACE_COSINE 0.87
/* The factor up to which a new candidate's radii grow once its samples are found, and the steps in
 * which that factor is searched. */
#define PSPLAT_GREATEST_NEW_GROWTH 1.4
enum { PSPLAT_NEW_GROWTH_STEPS = 3 };

/* ---- where regions are evaluated ------------------------------------------------------------ */

/* A place on the surface. Evaluations at one place share the samples gathered around it. */
typedef struct psplat_site {
    uint32_t seed;        /* The sample that a region here must cover; PSPLAT_NONE: any will do. */
    uint32_t triangle;    /* The triangle at the metric's centre. */
    psplat_metric metric; /* Samples are gathered in the order of their distances in it. */
    double gathered;      /* The reach up to which they are gathered; 0: none are yet. */
} psplat_site;

/* Returns a site in the middle of a region, near a triangle, that requires no seed. */
psplat_site psplat_site_of(const psplat_region *region, uint32_t triangle);
/* Turns the metric: its first axis is u and its last is n, both unit vectors. Lengths across both
 * count 1 / stretch. */
void psplat_site_turn(psplat_site *site, const double n[3], const double u[3], double stretch);
/* Gathers samples and creases within reach of the site into the scratch, unless they are there
 * already. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_site_gather(const psplat_fit_context *context, psplat_site *site,
                                 double reach);

/* ---- evaluation ----------------------------------------------------------------------------- */

typedef enum psplat_fit_status {
    PSPLAT_FIT_KEPT = 0, /* The region keeps all limits and demands. */
    PSPLAT_FIT_NO_GAIN,  /* It keeps the limits that were checked, but does not gain. */
    PSPLAT_FIT_CREASE_TOO_FAR,
    PSPLAT_FIT_TOO_MANY_LINES,
    PSPLAT_FIT_SAMPLES_LOST, /* It misses the seed, or a sample that it had to hold. */
    PSPLAT_FIT_COLORS_DIFFER,
    PSPLAT_FIT_TEXTURE_SLIDES,
    PSPLAT_FIT_LEAVES_SURFACE,
    PSPLAT_FIT_NORMALS_DIFFER,
    PSPLAT_FIT_MEMORY
} psplat_fit_status;

/* What a caller may leave out of an evaluation. */
enum {
    PSPLAT_SKIP_LINES = 1,  /* The region keeps the lines that it has. */
    PSPLAT_SKIP_COLORS = 2, /* and texture coordinates */
    PSPLAT_SKIP_NEARNESS = 4,
    PSPLAT_SKIP_NORMALS = 8,
    /* The region is a draft: its outline must be near samples instead of the mesh, and its lines
     * are not rounded to the precision. */
    PSPLAT_SKIP_EXACTNESS = 16
};

/* What is asked of a region besides the limits. A region gains if it is as large as least_area or
 * covers more than more_than samples. Where it does not gain, only those limits are checked that
 * tell a search how far it may reach. */
typedef struct psplat_demands {
    const double *inside; /* A point that all lines must keep; unused where lines are skipped. */
    const psplat_candidate *held; /* Its covered samples must stay inside and near; NULL: none. */
    int any_reason;    /* 1: a region that leaves the surface may be told so before other limits are
                          checked, or whether it gains; nearness must not be skipped */
    double least_area; /* HUGE_VAL: no area is large enough. */
    size_t more_than;  /* SIZE_MAX: no number of samples is large enough. */
    double reach; /* How far the surroundings reach from the site; 0: as far as the region needs. */
    size_t nearest; /* How many samples the surroundings have, if the site was the last to gather
                       any; 0: all that lie within the reach. */
    int skip;       /* The flags above, or'ed. */
} psplat_demands;

/* What a region would be as a splat. Where the status is neither KEPT nor NO_GAIN, only the region,
 * its lines and what was found before the failure are meaningful. */
typedef struct psplat_evaluation {
    psplat_fit_status status;
    psplat_region region;    /* with its lines */
    const uint32_t *covered; /* count indices into scratch->near.samples, until the next evaluation;
                                owned by the scratch */
    size_t count;
    double field[5];     /* x, y, alpha, beta, gamma; 0 where normals were skipped */
    double deviation;    /* greatest distance from a covered sample */
    double normal_error; /* greatest angle to a covered sample's normal, radians; 0 without a limit
                            of it */
} psplat_evaluation;

/* Evaluates a region at a site. It covers the samples that lie inside its ellipse less the margin,
 * within the tolerance of its plane, and whose normals face its way. */
psplat_evaluation psplat_evaluate(const psplat_fit_context *context, psplat_site *site,
                                  const psplat_region *region, const psplat_demands *demands);
/* Evaluates a region of the last resort. It gets lines that keep a point of it, it covers one
 * sample or none (PSPLAT_NONE), and no limit is checked. skip may be PSPLAT_SKIP_EXACTNESS. Fails
 * only with PSPLAT_FIT_MEMORY. */
psplat_evaluation psplat_evaluate_single_sample(const psplat_fit_context *context,
                                                psplat_site *site, const psplat_region *region,
                                                const double point[3], uint32_t sample, int skip);

/* Records the samples that the last evaluation covered, at least one, as those that the candidate
 * covers. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_candidate_record(const psplat_fit_context *context,
                                      const psplat_evaluation *evaluation,
                                      psplat_candidate *candidate);
/* Gives the candidate the region, field and deviation of the last evaluation, and its samples
 * unless keep_record is 1. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_candidate_set(const psplat_fit_context *context, const psplat_site *site,
                                   const psplat_evaluation *evaluation, int keep_record,
                                   psplat_candidate *candidate);
/* Evaluates a region in place of the candidate's, and gives it to the candidate where it holds all
 * samples that the candidate covers, keeps the limits, and is as large as least_area or (unless
 * keep_record is 1) covers more samples. Returns KEPT where it did. Why it did not is certain only
 * at a site with a seed and with a least_area of 0. */
psplat_fit_status psplat_candidate_replace(const psplat_fit_context *context, psplat_site *site,
                                           const psplat_region *region, double least_area,
                                           int keep_record, psplat_candidate *candidate);

/* Moves the covered sample that is nearest to a point to the front of candidate->covered. */
void psplat_candidate_put_nearest_first(const psplat_samples *samples, const double point[3],
                                        psplat_candidate *candidate);

/* ---- the steps of an evaluation, for evaluate.c only ---------------------------------------- */

/* evaluate_color.c: returns KEPT where the colours of the covered samples (count) are within the
 * tolerance of one colour that may change linearly, else COLORS_DIFFER. */
psplat_fit_status psplat_evaluate_colors(const psplat_fit_context *context, size_t count);
/* evaluate_texcoord.c: fits texture coordinates of a region to the samples that a candidate is
 * recorded to cover, at least one, and to those of its chart that lie a little beyond its rim, as
 * the last evaluation met them, which must have been one of this region. */
void psplat_evaluate_fit_texcoords(const psplat_fit_context *context, const psplat_region *region,
                                   const psplat_candidate *candidate, psplat_texcoord *fitted);
/* The same for the covered samples (count) of the last evaluation, and returns KEPT where the
 * texture slides nowhere there beyond its tolerance, else TEXTURE_SLIDES. */
psplat_fit_status psplat_evaluate_texcoords(const psplat_fit_context *context,
                                            const psplat_region *region, size_t count);
/* evaluate_near.c: returns KEPT where the region is within the tolerance of the surface that is
 * connected with the site, else LEAVES_SURFACE or MEMORY. With exact, points all over the region
 * are measured against the mesh, also those a little beyond borders of charts; else points of its
 * outline are measured against samples. */
psplat_fit_status psplat_evaluate_nearness(const psplat_fit_context *context,
                                           const psplat_region *region, int exact);
/* evaluate_normals.c: fits the normal field of an evaluation to its covered samples. The field has
 * no gradients where they are not wanted or not bounded. Returns KEPT or NORMALS_DIFFER. */
psplat_fit_status psplat_evaluate_normals(const psplat_fit_context *context,
                                          psplat_evaluation *evaluation);
/* scratch.c: makes room for all samples and creases gathered. Fails only with PSPLAT_ERROR_MEMORY.
 */
psplat_result psplat_scratch_reserve(psplat_scratch *scratch);

#endif

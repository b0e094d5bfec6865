/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * ray_holes.c - the search for rays that pass between splats.
 *
 * Two splats that overlap along the surface's normal may lie at different heights. A slanted ray
 * then passes the rim of the higher one and reaches the lower one where that has ended: the overlap
 * has to be the step between them times the tangent of the slant. So random rays are tried. All
 * rays of a point are tried at once against each splat nearby, and the mesh is asked only about
 * those that nothing meets.
 */
#include "measure/ray_holes.h"

#include "base/angle.h"
#include "base/random.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/samples.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The rays of a point: so many around it at each of these slants. */
enum { AROUND = 8, SLANTS = 3, RAYS = AROUND * SLANTS };

/* The ranges of cosines of the slants. Chosen by hand. */
static const double cosines[SLANTS + 1] = {PSPLAT_LEAST_SIGHT_COSINE, 0.3, 0.55, 1};

/* How far rays run to the eye, in diagonals: out of the box. */
static const double way_diagonals = 1.5;

/* The rays of one point, and which of them have met no splat yet. */
typedef struct bundle {
    const psplat_measured_splats *measured;
    psplat_sight sights[RAYS];
    double cosine[RAYS];
    uint32_t open; /* a bit for each */
} bundle;

/* Makes the rays of point i, which always are the same. */
static void make_rays(const psplat_ray_search *search, const psplat_samples *samples, size_t i,
                      bundle *b) {
    const double *normal = search->surface->face_normals + 3 * (size_t)samples->triangles[i];
    uint64_t random = search->seed ^ i;
    double u[3], v[3], turn = psplat_random_unit(&random);
    perpendicular3(u, normal);
    cross3(v, normal, u);
    for (int k = 0; k < RAYS; ++k) {
        int slant = k / AROUND;
        double angle = 2 * PSPLAT_PI * (turn + (k + psplat_random_unit(&random)) / AROUND);
        double part = psplat_random_unit(&random);
        double cosine = cosines[slant] + part * (cosines[slant + 1] - cosines[slant]);
        double sine = sqrt(max2(1 - cosine * cosine, 0)), *d = b->sights[k].direction;
        b->cosine[k] = cosine;
        memcpy(b->sights[k].point, samples->positions + 3 * i, sizeof b->sights[k].point);
        for (int c = 0; c < 3; ++c)
            d[c] = cosine * normal[c] + sine * (cos(angle) * u[c] + sin(angle) * v[c]);
    }
    b->open = (1u << RAYS) - 1;
}

static int visit_splat(void *user, uint32_t splat) {
    bundle *b = user;
    double height, uv[2];
    for (uint32_t k = 0; k < RAYS; ++k)
        if (b->open & (1u << k) &&
            psplat_sight_meets(&b->sights[k], &b->measured->regions[splat], 0, &height, uv) &&
            fabs(height) * b->cosine[k] <= b->measured->tolerance)
            b->open &= ~(1u << k);
    return !b->open;
}

/* Finds which rays of a point are holes. */
static psplat_result measure_point(const psplat_ray_search *search, const psplat_samples *samples,
                                   size_t i, uint32_t *open) {
    bundle b = {.measured = search->measured};
    double low[3], high[3], reach = b.measured->tolerance / PSPLAT_LEAST_SIGHT_COSINE;
    make_rays(search, samples, i, &b);
    for (int k = 0; k < 3; ++k) {
        low[k] = b.sights[0].point[k] - reach;
        high[k] = b.sights[0].point[k] + reach;
    }
    psplat_region_tree_visit_box(b.measured->region_tree, low, high, visit_splat, &b);
    psplat_result result = PSPLAT_OK;
    for (uint32_t k = 0; k < RAYS && b.open && !result; ++k) {
        int is_free = 1; /* and inner */
        if (!(b.open & (1u << k))) continue;
        result = psplat_sight_is_free(&b.sights[k], search->distance,
                                      way_diagonals * search->surface->diagonal, &is_free);
        if (!result && is_free)
            result = psplat_sight_is_inner(
                &b.sights[k], search->surface->face_normals + 3 * (size_t)samples->triangles[i],
                b.cosine[k], search->distance, b.measured->tolerance, &is_free);
        if (!is_free) b.open &= ~(1u << k);
    }
    *open = b.open;
    return result;
}

/* Makes the rays that were found again, in the order of their points. Returns 0 when out of memory.
 */
static int collect(const psplat_ray_search *search, const psplat_samples *samples,
                   const uint32_t *open, psplat_ray_holes *holes) {
    size_t count = 0;
    for (size_t i = 0; i < samples->count; ++i)
        for (uint32_t k = 0; k < RAYS; ++k) count += (open[i] >> k) & 1;
    holes->holes = malloc((count + 1) * sizeof *holes->holes);
    for (size_t i = 0; holes->holes && i < samples->count; ++i) {
        bundle b;
        if (!open[i]) continue;
        make_rays(search, samples, i, &b);
        for (uint32_t k = 0; k < RAYS; ++k)
            if ((open[i] >> k) & 1)
                holes->holes[holes->count++] =
                    (psplat_ray_hole){b.sights[k], b.cosine[k], samples->triangles[i]};
    }
    return holes->holes != NULL;
}

enum { BLOCK_POINTS = 256 }; /* that a thread takes at once */

psplat_result psplat_ray_holes_find(const psplat_ray_search *search, psplat_ray_holes *holes) {
    psplat_samples samples = {0};
    *holes = (psplat_ray_holes){0};
    psplat_result result =
        psplat_samples_draw_uniform(search->surface, search->points, search->seed, &samples, NULL);
    uint32_t *open = result ? NULL : calloc(samples.count + 1, sizeof *open);
    long end = open ? (long)samples.count : 0;
    int failed = !open;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, BLOCK_POINTS) reduction(| : failed)
#endif
    for (long i = 0; i < end; ++i)
        failed |= measure_point(search, &samples, (size_t)i, &open[i]) != PSPLAT_OK;
    if (!failed) failed = !collect(search, &samples, open, holes);
    free(open);
    psplat_samples_free(&samples);
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

void psplat_ray_holes_free(psplat_ray_holes *holes) {
    free(holes->holes);
    *holes = (psplat_ray_holes){0};
}

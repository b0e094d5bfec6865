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
    psplat_sight sights[RAYS];
    double cosine[RAYS];
    uint32_t open; /* a bit for each */
} bundle;

/* Makes the first rays of point i, which always are the same. */
static void make_rays(const psplat_ray_search *search, const psplat_samples *samples, size_t i,
                      int count, bundle *b) {
    const double *normal = search->surface->face_normals + 3 * (size_t)samples->triangles[i];
    uint64_t random = search->seed ^ i;
    double u[3], v[3], turn = psplat_random_unit(&random);
    perpendicular3(u, normal);
    cross3(v, normal, u);
    for (int k = 0; k < count; ++k) {
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
    b->open = (1u << count) - 1;
}

/* What a thread that looks at points knows. Points follow each other over the surface, so that it
 * keeps which splats last met all rays of a point, and those near the last points. The results do
 * not depend on it. */
enum { LIKELY = 4 };
typedef struct looker {
    const psplat_ray_search *search;
    const psplat_samples *samples;
    const double *bends;             /* of the regions */
    psplat_sight_cone cones[SLANTS]; /* of the rays of a slant and of all steeper ones */
    double reach;                    /* how far from its point a ray may meet a splat */
    uint32_t likely[LIKELY];
    int likely_count;
    double low[3], high[3]; /* a box, and the splats within reach of it */
    uint32_t *near;
    size_t near_count, near_capacity;
    int failed;
    /* At the point: */
    const double *point, *normal;
    int met; /* the first cone of which all rays are met */
} looker;

static int push_near(void *user, uint32_t splat) {
    looker *l = user;
    if (l->near_count == l->near_capacity) {
        size_t capacity = 2 * l->near_capacity + 64;
        uint32_t *near = realloc(l->near, capacity * sizeof *near);
        l->failed |= !near;
        if (!near) return 1;
        l->near = near;
        l->near_capacity = capacity;
    }
    l->near[l->near_count++] = splat;
    return 0;
}

/* Finds the splats near the point, and near those that may follow it. */
static void find_near(looker *l) {
    double low[3], high[3];
    int known = 1;
    for (int k = 0; k < 3; ++k) known &= l->point[k] >= l->low[k] && l->point[k] <= l->high[k];
    if (known) return;
    for (int k = 0; k < 3; ++k) {
        l->low[k] = l->point[k] - l->reach, low[k] = l->low[k] - l->reach;
        l->high[k] = l->point[k] + l->reach, high[k] = l->high[k] + l->reach;
    }
    l->near_count = 0;
    psplat_region_tree_visit_box(l->search->measured->region_tree, low, high, push_near, l);
}

/* Remembers a splat. */
static void put_first(looker *l, uint32_t splat) {
    int at = 0;
    while (at < l->likely_count && l->likely[at] != splat) ++at;
    if (at == l->likely_count && at < LIKELY) ++l->likely_count;
    if (at == LIKELY) --at;
    memmove(l->likely + 1, l->likely, (size_t)at * sizeof *l->likely);
    l->likely[0] = splat;
}

/* Finds whether a splat meets all rays of a cone that has not been met. Returns whether all cones
 * have been. */
static int meet_cones(looker *l, uint32_t splat) {
    const psplat_measured_splats *measured = l->search->measured;
    int met = psplat_sight_cones_meet(&measured->regions[splat], l->bends[splat], l->point,
                                      l->normal, measured->tolerance, l->cones, l->met);
    if (met < l->met) {
        l->met = met;
        put_first(l, splat);
    }
    return !l->met;
}

/* Finds the cones of which all rays are met. */
static void find_cones(looker *l) {
    l->met = SLANTS;
    for (int k = 0; k < l->likely_count; ++k)
        if (meet_cones(l, l->likely[k])) return;
    find_near(l);
    for (size_t k = 0; k < l->near_count; ++k)
        if (meet_cones(l, l->near[k])) return;
}

/* Closes the rays that meet a splat: psplat_sight_meets for all that are open, with what they share
 * found once. Always returns whether none is left. */
static int meet_splat(const looker *l, const psplat_region *region, bundle *b) {
    const double *h = region->hessian, *radius = region->radius;
    double from[3], slope[2], tolerance = l->search->measured->tolerance;
    sub3(from, l->point, region->center);
    double s = dot3(from, region->u), t = dot3(from, region->v);
    const double foot[2] = {s / radius[0], t / radius[1]};
    double most = 1 + l->reach / min2(radius[0], radius[1]);
    if (foot[0] * foot[0] + foot[1] * foot[1] > most * most) return 0;
    psplat_region_slope(region, foot, slope);
    double f0 = dot3(from, region->n) - psplat_region_height(region, foot);
    for (uint32_t k = 0; k < RAYS; ++k) {
        if (!(b->open & (1u << k))) continue;
        const double *d = b->sights[k].direction;
        double x = dot3(d, region->u), y = dot3(d, region->v);
        double f1 = dot3(d, region->n) - slope[0] * x - slope[1] * y;
        double f2 = -(h[0] * x * x + 2 * h[1] * x * y + h[2] * y * y) / 2;
        double square = f1 * f1 - 4 * f0 * f2;
        if (!(square > 0) || (f2 == 0 && f1 < 0)) continue;
        double rise = sqrt(square);
        double way = f1 > 0 ? -2 * f0 / (f1 + rise) : (rise - f1) / (2 * f2);
        const double uv[2] = {(s + way * x) / radius[0], (t + way * y) / radius[1]};
        if (fabs(way) * b->cosine[k] <= tolerance && psplat_region_contains(region, uv, 1, 0))
            b->open &= ~(1u << k);
    }
    return !b->open;
}

/* Closes the rays that meet splats: most meet one that meets all rays of a slant, or did so at a
 * point before. */
static void find_rays(const looker *l, bundle *b) {
    const psplat_region *regions = l->search->measured->regions;
    for (int k = 0; k < l->likely_count; ++k)
        if (meet_splat(l, &regions[l->likely[k]], b)) return;
    for (size_t k = 0; k < l->near_count; ++k)
        if (meet_splat(l, &regions[l->near[k]], b)) return;
}

/* Finds which rays of a point are holes. */
static psplat_result measure_point(looker *l, size_t i, uint32_t *open) {
    const psplat_ray_search *search = l->search;
    bundle b;
    l->point = l->samples->positions + 3 * i;
    if (!psplat_surface_owns(search->surface, l->point)) return PSPLAT_OK;
    l->normal = search->surface->face_normals + 3 * (size_t)l->samples->triangles[i];
    find_cones(l);
    if (l->failed) return PSPLAT_ERROR_MEMORY;
    if (!l->met) return PSPLAT_OK;
    make_rays(search, l->samples, i, AROUND * l->met, &b);
    find_rays(l, &b);
    psplat_result result = PSPLAT_OK;
    for (uint32_t k = 0; k < RAYS && b.open && !result; ++k) {
        int is_free; /* and inner, which few are, and which short ways tell */
        if (!(b.open & (1u << k))) continue;
        result = psplat_sight_is_inner(&b.sights[k], l->normal, b.cosine[k], search->distance,
                                       search->measured->tolerance, &is_free);
        if (!result && is_free)
            result = psplat_sight_is_free(&b.sights[k], search->distance,
                                          way_diagonals * search->surface->diagonal, &is_free);
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
        make_rays(search, samples, i, RAYS, &b);
        for (uint32_t k = 0; k < RAYS; ++k)
            if ((open[i] >> k) & 1)
                holes->holes[holes->count++] =
                    (psplat_ray_hole){b.sights[k], b.cosine[k], samples->triangles[i]};
    }
    return holes->holes != NULL;
}

/* Returns a looker that has seen nothing yet. */
static looker looker_of(const psplat_ray_search *search, const psplat_samples *samples,
                        const double *bends) {
    looker l = {.search = search,
                .samples = samples,
                .bends = bends,
                .reach = search->measured->tolerance / cosines[0],
                .low = {HUGE_VAL, HUGE_VAL, HUGE_VAL}};
    for (int k = 0; k < SLANTS; ++k) {
        l.cones[k].cosine = cosines[k];
        l.cones[k].sine = sqrt(1 - cosines[k] * cosines[k]);
    }
    return l;
}

enum { BLOCK_POINTS = 256 }; /* that a thread takes at once */

/* Finds which rays of each point are holes. */
static psplat_result measure_points(const psplat_ray_search *search, const psplat_samples *samples,
                                    const double *bends, uint32_t *open) {
    long end = (long)samples->count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel reduction(| : failed)
#endif
    {
        looker l = looker_of(search, samples, bends);
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, BLOCK_POINTS)
#endif
        for (long i = 0; i < end; ++i) failed |= measure_point(&l, (size_t)i, &open[i]) != 0;
        free(l.near);
    }
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

psplat_result psplat_ray_holes_find(const psplat_ray_search *search, psplat_ray_holes *holes) {
    psplat_samples samples = {0};
    *holes = (psplat_ray_holes){0};
    psplat_result result =
        psplat_samples_draw_uniform(search->surface, search->points, search->seed, &samples, NULL);
    size_t count = search->measured->count;
    uint32_t *open = result ? NULL : calloc(samples.count + 1, sizeof *open);
    double *bends = malloc((count + 1) * sizeof *bends);
    int failed = !open || !bends;
    for (size_t i = 0; !failed && i < count; ++i)
        bends[i] = psplat_region_bend(&search->measured->regions[i]);
    if (!failed) failed = measure_points(search, &samples, bends, open) != PSPLAT_OK;
    if (!failed) failed = !collect(search, &samples, open, holes);
    free(open);
    free(bends);
    psplat_samples_free(&samples);
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

void psplat_ray_holes_free(psplat_ray_holes *holes) {
    free(holes->holes);
    *holes = (psplat_ray_holes){0};
}

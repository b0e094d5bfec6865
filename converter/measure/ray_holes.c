/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * ray_holes.c - the search for rays that pass between splats.
 *
 * Two splats that overlap along the surface's normal may lie at different heights. A slanted ray
 * then passes the rim of the higher one, where that is flat or its wall too low, and reaches the
 * lower one where that has ended: the overlap has to be the rest of the step between them times the
 * tangent of the slant. So random rays are tried. All rays of a point are tried at once against
 * each splat close by, which most of them meet. Of those left, few see the surface, so that the
 * mesh is asked about these, and at last all splats along the way. Where only some regions matter,
 * rays that none of these would hide are left out.
 *
 * Cracks that are much narrower than the random points lie apart are found from the rims of splats,
 * which border every gap: points a little beyond a rim stand for the triangle that is nearest to
 * them, whose plane their rays are taken to see.
 */
#include "measure/ray_holes.h"

#include "base/angle.h"
#include "base/random.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/samples.h"
#include "measure/rim_points.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The rays of a point: so many around it at each slant. Points beyond rims, which gaps are close
 * to, have fewer. */
enum { AROUND = 8, AROUND_RIMS = 4, SLANTS = 4, RAYS = AROUND * (SLANTS - 1) };

/* The ranges of cosines of the slants, the flattest first, which only rays past rims have. Chosen
 * by hand. */
static const double cosines[SLANTS + 1] = {PSPLAT_FLATTEST_SIGHT_COSINE, PSPLAT_LEAST_SIGHT_COSINE,
                                           0.3, 0.55, 1};

/* How far rays run to the eye, in diagonals: out of the box. */
static const double way_diagonals = 1.5;

/* How far outside rims lie the points that rays pass there, in tolerances: gaps that are narrower
 * than the least are seen from very near alone. */
static const double least_rim_gap = 0.02, greatest_rim_gap = 0.5;

/* How much of the way from a face to the eye, in tolerances over the cosine, does not count where
 * the face stands for the surface around it, which may bend. */
static const double bend_tolerances = 0.25;

/* Splats that are no farther from a place than this are close, and are asked about all of its rays
 * at once. One that meets all rays of a cone meets the one along its axis within a tolerance, so
 * that all such are close, whatever has been looked at before. */
static const double close_tolerances = 1;
/* The splats that are close to any place of a box around one are found together, since the places
 * that follow mostly lie in that, too: half of its side, in tolerances. */
static const double around_tolerances = 4;

/* What rounding may make of lengths, in parts of them. */
static const double rounding = 1e-9;

/* Where rays pass, and the triangle that they see: of points of the surface, one that they lie on;
 * of points beyond rims, the nearest one. */
typedef struct place {
    double point[3];
    double lift; /* of the point over the triangle's plane, a length */
    uint32_t triangle;
    uint32_t open; /* a bit for each ray that is a hole */
} place;

/* The rays of one place, and which of them still may be holes. */
typedef struct bundle {
    psplat_sight sights[RAYS];
    double cosine[RAYS];
    uint32_t open; /* a bit for each */
} bundle;

/* A splat, and a sphere around its centre that holds it. */
typedef struct ball {
    double center[3], radius;
    double bend; /* of its region */
    uint32_t splat;
} ball;

/* The places of a search, and their rays' slants. */
typedef struct ray_plan {
    const psplat_ray_search *search;
    const ball *balls, *hiders; /* of all splats, and of the hiders, where only bends count */
    place *places;
    size_t count;
    const psplat_rim_point *rims; /* of each place; NULL: the places lie on the surface */
    const double *cosines;        /* slants + 1, the flattest first */
    int slants, around;           /* rays of each slant */
    double sectors[AROUND][2];    /* cosine and sine of where the sector of each of these begins */
    double half_sector;           /* the tangent of half of its angle */
} ray_plan;

static void divide_into_sectors(ray_plan *plan) {
    for (int k = 0; k < plan->around; ++k) {
        plan->sectors[k][0] = cos(2 * PSPLAT_PI * k / plan->around);
        plan->sectors[k][1] = sin(2 * PSPLAT_PI * k / plan->around);
    }
    plan->half_sector = tan(PSPLAT_PI / plan->around);
}

/* Turns a direction of a plane by the angle of another one. */
static void turn_by(double direction[2], double cosine, double sine) {
    double x = direction[0], y = direction[1];
    direction[0] = cosine * x - sine * y;
    direction[1] = sine * x + cosine * y;
}

/* Makes the first rays of place i, which always are the same. Within its sector a ray is turned by
 * an angle the tangent of half of which is uniform: that takes no sine. */
static void make_rays(const ray_plan *plan, size_t i, int count, bundle *b) {
    const place *at = &plan->places[i];
    const double *normal = plan->search->surface->face_normals + 3 * (size_t)at->triangle;
    uint64_t random = plan->search->seed ^ i;
    double u[3], v[3], turn = 2 * PSPLAT_PI * psplat_random_unit(&random);
    const double first[2] = {cos(turn), sin(turn)};
    perpendicular3(u, normal);
    cross3(v, normal, u);
    for (int k = 0; k < count; ++k) {
        const double *range = plan->cosines + k / plan->around;
        const double *sector = plan->sectors[k % plan->around];
        double half = plan->half_sector * psplat_random_unit(&random), to[2] = {first[0], first[1]};
        double cosine = range[0] + psplat_random_unit(&random) * (range[1] - range[0]);
        double sine = sqrt(max2(1 - cosine * cosine, 0)), *d = b->sights[k].direction;
        turn_by(to, sector[0], sector[1]);
        turn_by(to, (1 - half * half) / (1 + half * half), 2 * half / (1 + half * half));
        b->cosine[k] = cosine;
        for (int c = 0; c < 3; ++c)
            d[c] = cosine * normal[c] + sine * (to[0] * u[c] + to[1] * v[c]);
        along3(b->sights[k].point, at->point, -at->lift / cosine, d);
    }
    b->open = (1u << count) - 1;
}

/* Splats that rays may meet. */
typedef struct target {
    const psplat_measured_splats *measured; /* NULL: there are none */
    const ball *balls;
    double height; /* how far over or under the triangle they may be met */
    double reach;  /* how far from their point rays get to there, at most */
} target;

/* What a thread that looks at places knows. Places follow each other over the surface, so that it
 * keeps which splats last met all rays of a slant, and those near the last places. The results do
 * not depend on it. */
enum { LIKELY = 4 };
typedef struct looker {
    const ray_plan *plan;
    target splats, hiders;
    psplat_sight_cone cones[SLANTS]; /* of the rays of a slant and of all steeper ones */
    uint32_t likely[LIKELY];
    int likely_count;
    double low[3], high[3]; /* a box, and the splats that are close to its points */
    ball *near;
    size_t near_count, near_capacity;
    double far_of_hiders; /* how far from a place hiders may hide its rays, at most */
    uint32_t guess;       /* where the triangle beneath the last rim was found */
    int failed;
    /* At the place: */
    const double *point, *normal;
    double lift;
    int met; /* the first cone of which all rays are met */
} looker;

static int push_near(void *user, uint32_t splat) {
    looker *l = user;
    if (l->near_count == l->near_capacity) {
        size_t capacity = 2 * l->near_capacity + 64;
        ball *near = realloc(l->near, capacity * sizeof *near);
        l->failed |= !near;
        if (!near) return 1;
        l->near = near;
        l->near_capacity = capacity;
    }
    l->near[l->near_count++] = l->splats.balls[splat];
    return 0;
}

/* Finds the splats near the point, and near those that may follow it. */
static void find_near(looker *l) {
    double low[3], high[3], tolerance = l->splats.height;
    int known = 1;
    for (int k = 0; k < 3; ++k) known &= l->point[k] >= l->low[k] && l->point[k] <= l->high[k];
    if (known) return;
    for (int k = 0; k < 3; ++k) {
        double around = around_tolerances * tolerance, away = close_tolerances * tolerance;
        l->low[k] = l->point[k] - around, low[k] = l->low[k] - away;
        l->high[k] = l->point[k] + around, high[k] = l->high[k] + away;
    }
    l->near_count = 0;
    psplat_region_tree_visit_box(l->splats.measured->region_tree, low, high, push_near, l);
}

/* Returns whether a ball is close to the point. */
static int is_close(const looker *l, const ball *ball) {
    double most = ball->radius + close_tolerances * l->splats.height;
    return distance2_3(ball->center, l->point) <= most * most;
}

static int see_beside(void *user, uint32_t hider) {
    (void)hider;
    *(int *)user = 1;
    return 1;
}

/* Returns whether a hider may hide a ray of the point, where there are any. */
static int is_beside(const looker *l) {
    double low[3], high[3], far = l->far_of_hiders;
    int beside = 0;
    if (!l->hiders.measured) return 1;
    for (int k = 0; k < 3; ++k) low[k] = l->point[k] - far, high[k] = l->point[k] + far;
    psplat_region_tree_visit_box(l->hiders.measured->region_tree, low, high, see_beside, &beside);
    return beside;
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
    int met =
        psplat_sight_cones_meet(&l->splats.measured->regions[splat], l->splats.balls[splat].bend,
                                l->point, l->normal, l->splats.height, l->cones, l->met);
    if (met < l->met) {
        l->met = met;
        put_first(l, splat);
    }
    return !l->met;
}

/* Finds the cones of which all rays are met. */
static void find_cones(looker *l) {
    l->met = l->plan->slants;
    for (int k = 0; k < l->likely_count; ++k)
        if (meet_cones(l, l->likely[k])) return;
    find_near(l);
    for (size_t k = 0; k < l->near_count; ++k)
        if (is_close(l, &l->near[k]) && meet_cones(l, l->near[k].splat)) return;
}

/* Returns whether no ray gets to a surface within the reach, given the point's height over it and
 * its slope there. Along a ray the height changes by no more than f1 t + f2 t^2, with |f1| at most
 * the length of the surface's normal and |f2| at most half of the bend. */
static int is_too_high(double height, const double slope[2], double bend, double reach) {
    double steepest = sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
    return fabs(height) > (steepest + bend * reach / 2) * reach * (1 + rounding);
}

/* Returns whether a ray may meet something so far along. */
static int is_within(const looker *l, const target *t, const bundle *b, uint32_t k, double way) {
    return fabs(way * b->cosine[k] + l->lift) <= t->height && fabs(way) <= t->reach;
}

/* Returns those of the rays that meet a wall. */
static uint32_t find_at_wall(const looker *l, const target *t, const psplat_region *region,
                             uint32_t rays, const bundle *b) {
    uint32_t met = 0;
    for (uint32_t k = 0; k < RAYS; ++k) {
        double way, uv[2];
        if (!(rays & (1u << k))) continue;
        const psplat_sight *from = &b->sights[k];
        psplat_sight sight = {{l->point[0], l->point[1], l->point[2]},
                              {from->direction[0], from->direction[1], from->direction[2]}};
        if (psplat_sight_meets_wall(&sight, region, t->measured->wall, &way, uv) &&
            is_within(l, t, b, k, way))
            met |= 1u << k;
    }
    return met;
}

/* Returns those of the rays that meet a splat: psplat_sight_meets for all of them, with what they
 * share found once. */
static uint32_t find_meeting(const looker *l, const target *to, uint32_t splat, uint32_t rays,
                             const bundle *b) {
    const psplat_region *region = &to->measured->regions[splat];
    const double *h = region->hessian, *radius = region->radius;
    double from[3], slope[2];
    uint32_t met = 0;
    sub3(from, l->point, region->center);
    double s = dot3(from, region->u), t = dot3(from, region->v);
    const double foot[2] = {s / radius[0], t / radius[1]};
    double most = 1 + to->reach / min2(radius[0], radius[1]);
    if (foot[0] * foot[0] + foot[1] * foot[1] > most * most) return 0;
    psplat_region_slope(region, foot, slope);
    double f0 = dot3(from, region->n) - psplat_region_height(region, foot);
    if (is_too_high(max2(fabs(f0) - to->measured->wall, 0), slope, to->balls[splat].bend,
                    to->reach))
        return 0;
    for (uint32_t k = 0; k < RAYS; ++k) {
        if (!(rays & (1u << k))) continue;
        const double *d = b->sights[k].direction;
        double x = dot3(d, region->u), y = dot3(d, region->v);
        double f1 = dot3(d, region->n) - slope[0] * x - slope[1] * y;
        double f2 = -(h[0] * x * x + 2 * h[1] * x * y + h[2] * y * y) / 2;
        double square = f1 * f1 - 4 * f0 * f2;
        if (!(square > 0) || (f2 == 0 && f1 < 0)) continue;
        double rise = sqrt(square);
        double way = f1 > 0 ? -2 * f0 / (f1 + rise) : (rise - f1) / (2 * f2);
        const double uv[2] = {(s + way * x) / radius[0], (t + way * y) / radius[1]};
        if (is_within(l, to, b, k, way) && psplat_region_contains(region, uv, 1, 0)) met |= 1u << k;
    }
    return met | find_at_wall(l, to, region, rays & ~met, b);
}

/* Closes the rays that meet splats which are close to the place, or have met all rays of a slant
 * last. */
static void close_rays(const looker *l, bundle *b) {
    for (int k = 0; k < l->likely_count && b->open; ++k)
        b->open &= ~find_meeting(l, &l->splats, l->likely[k], b->open, b);
    for (size_t k = 0; k < l->near_count && b->open; ++k) {
        if (is_close(l, &l->near[k]))
            b->open &= ~find_meeting(l, &l->splats, l->near[k].splat, b->open, b);
    }
}

/* The search for a splat of a target that one ray meets. */
typedef struct meeting {
    const looker *looker;
    const target *target;
    const bundle *bundle;
    uint32_t ray; /* its bit */
    int is_met;
} meeting;

static int meet(void *user, uint32_t splat) {
    meeting *m = user;
    m->is_met = find_meeting(m->looker, m->target, splat, m->ray, m->bundle) != 0;
    return m->is_met;
}

/* Returns whether ray k meets a splat of a target. */
static int meets_any(const looker *l, const target *t, const bundle *b, uint32_t k) {
    const psplat_sight *sight = &b->sights[k];
    double from[3], to[3], away = t->height / b->cosine[k] * (1 + rounding);
    meeting m = {l, t, b, 1u << k, 0};
    along3(from, sight->point, -away, sight->direction);
    along3(to, sight->point, away, sight->direction);
    psplat_region_tree_visit_segment(t->measured->region_tree, from, to, t->measured->wall, meet,
                                     &m);
    return m.is_met;
}

/* Finds the triangle that is nearest to a place beyond a rim. */
static psplat_result find_triangle(looker *l, place *at) {
    const psplat_ray_search *search = l->plan->search;
    double nearest[3], d[3];
    psplat_result result =
        psplat_distance_nearest(search->distance, at->point, &l->guess, nearest, &at->triangle);
    if (result) return result;
    sub3(d, at->point, nearest);
    at->lift = dot3(d, search->surface->face_normals + 3 * (size_t)at->triangle);
    return PSPLAT_OK;
}

/* Stores whether a ray sees the surface from outside, inside of its outline. Few of the rays that
 * pass all close splats do, and of most others short ways tell. */
static psplat_result find_seeing(const looker *l, const psplat_sight *sight, double cosine,
                                 int *sees) {
    const psplat_distance *distance = l->plan->search->distance;
    double tolerance = l->splats.height, bend = bend_tolerances * tolerance / cosine, behind[3];
    psplat_sight from = *sight;
    psplat_result result = PSPLAT_OK;
    *sees = 1;
    if (l->plan->rims) {
        along3(behind, sight->point, -bend, sight->direction);
        along3(from.point, sight->point, bend, sight->direction);
        result = psplat_distance_meets(distance, from.point, behind, sees);
    }
    if (!result && *sees)
        result = psplat_sight_is_inner(sight, l->normal, cosine, distance, tolerance, sees);
    if (!result && *sees)
        result = psplat_sight_is_free(&from, distance,
                                      way_diagonals * l->plan->search->surface->diagonal, sees);
    return result;
}

/* Stores whether ray k, which meets no close splat, is a hole. Few hiders leave few rays, and are
 * asked first; as many as there are splats hide most rays, and are asked last. */
static psplat_result find_hole(const looker *l, const bundle *b, uint32_t k, int *is_hole) {
    const target *hiders = l->hiders.measured ? &l->hiders : NULL;
    int few = hiders && hiders->measured->count < l->splats.measured->count / 2;
    *is_hole = !few || meets_any(l, hiders, b, k);
    if (!*is_hole) return PSPLAT_OK;
    psplat_result result = find_seeing(l, &b->sights[k], b->cosine[k], is_hole);
    *is_hole = *is_hole && !meets_any(l, &l->splats, b, k) &&
               (!hiders || few || meets_any(l, hiders, b, k));
    return result;
}

/* Finds which rays of a place are holes. */
static psplat_result measure_place(looker *l, size_t i) {
    const psplat_surface *surface = l->plan->search->surface;
    place *at = &l->plan->places[i];
    psplat_result result = PSPLAT_OK;
    bundle b;
    l->point = at->point;
    if (!is_beside(l) || !psplat_surface_owns(surface, at->point)) return PSPLAT_OK;
    /* The triangle beneath a rim is found only where it is needed, since that takes long. */
    l->normal =
        l->plan->rims ? l->plan->rims[i].normal : surface->face_normals + 3 * (size_t)at->triangle;
    find_cones(l);
    if (l->failed) return PSPLAT_ERROR_MEMORY;
    if (l->met && l->plan->rims) result = find_triangle(l, at);
    if (result || !l->met) return result;
    l->normal = surface->face_normals + 3 * (size_t)at->triangle;
    l->lift = at->lift;
    l->hiders.reach = (l->hiders.height + fabs(l->lift)) / l->plan->cosines[0] * (1 + rounding);
    make_rays(l->plan, i, l->plan->around * l->met, &b);
    close_rays(l, &b);
    for (uint32_t k = 0; k < RAYS && !result; ++k) {
        int is_hole;
        if (!(b.open & (1u << k))) continue;
        result = find_hole(l, &b, k, &is_hole);
        at->open |= (uint32_t)is_hole << k;
    }
    return result;
}

/* Appends the rays that are holes, made again, in the order of their places. Returns 0 when out of
 * memory. */
static int collect(const ray_plan *plan, psplat_ray_holes *holes) {
    size_t count = holes->count;
    for (size_t i = 0; i < plan->count; ++i)
        for (uint32_t k = 0; k < RAYS; ++k) count += (plan->places[i].open >> k) & 1;
    psplat_ray_hole *all = realloc(holes->holes, (count + 1) * sizeof *all);
    if (!all) return 0;
    holes->holes = all;
    for (size_t i = 0; i < plan->count; ++i) {
        const place *at = &plan->places[i];
        bundle b;
        if (!at->open) continue;
        make_rays(plan, i, plan->around * plan->slants, &b);
        for (uint32_t k = 0; k < RAYS; ++k)
            if ((at->open >> k) & 1)
                all[holes->count++] = (psplat_ray_hole){b.sights[k], b.cosine[k], at->triangle};
    }
    return 1;
}

/* How many times farther than its gap a point beyond a rim may be: gaps are measured in the plane
 * of a splat, and surfaces are steeper. */
static const double steepest_gap = PSPLAT_STEEPEST_REACH;

/* Returns a looker that has seen nothing yet. A splat that has rims is within the tolerance of the
 * surface, so that points beyond these are within that and the gap, and hiders as much farther:
 * rays begin at the triangle beneath. */
static looker looker_of(const ray_plan *plan) {
    const psplat_measured_splats *splats = plan->search->measured, *hiders = plan->search->hiders;
    double reach = splats->tolerance / plan->cosines[0], hiding = PSPLAT_HIDING_TOLERANCES;
    double farther = hiding + (plan->rims ? 1 + steepest_gap * greatest_rim_gap : 0);
    looker l = {.plan = plan,
                .splats = {splats, plan->balls, splats->tolerance, reach},
                .hiders = {hiders, plan->hiders, hiding * splats->tolerance, 0},
                .far_of_hiders = farther * reach + (hiders ? hiders->wall : 0),
                .guess = PSPLAT_NONE,
                .low = {HUGE_VAL, HUGE_VAL, HUGE_VAL}};
    for (int k = 0; k < plan->slants; ++k) {
        double cosine = plan->cosines[k];
        l.cones[k] = (psplat_sight_cone){cosine, sqrt(1 - cosine * cosine)};
    }
    return l;
}

enum { BLOCK_PLACES = 256 }; /* that a thread takes at once */

/* Finds which rays of each place are holes, and appends them. */
static psplat_result measure_places(ray_plan *plan, psplat_ray_holes *holes) {
    divide_into_sectors(plan);
    long end = (long)plan->count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel reduction(| : failed)
#endif
    {
        looker l = looker_of(plan);
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, BLOCK_PLACES)
#endif
        for (long i = 0; i < end; ++i) failed |= measure_place(&l, (size_t)i) != PSPLAT_OK;
        free(l.near);
    }
    return !failed && collect(plan, holes) ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

/* Casts rays from random points of the surface. */
static psplat_result measure_points(ray_plan plan, psplat_ray_holes *holes) {
    const psplat_ray_search *search = plan.search;
    psplat_samples samples = {0};
    plan.cosines = cosines + 1, plan.slants = SLANTS - 1, plan.around = AROUND;
    psplat_result result =
        psplat_samples_draw_uniform(search->surface, search->points, search->seed, &samples, NULL);
    if (!result) plan.places = calloc(samples.count + 1, sizeof *plan.places);
    plan.count = plan.places ? samples.count : 0;
    for (size_t i = 0; i < plan.count; ++i) {
        memcpy(plan.places[i].point, samples.positions + 3 * i, sizeof plan.places[i].point);
        plan.places[i].triangle = samples.triangles[i];
    }
    psplat_samples_free(&samples);
    if (!result) result = plan.places ? measure_places(&plan, holes) : PSPLAT_ERROR_MEMORY;
    free(plan.places);
    return result;
}

/* Casts rays past the rims of the splats. */
static psplat_result measure_rims(ray_plan plan, psplat_ray_holes *holes) {
    const psplat_ray_search *search = plan.search;
    const psplat_rim_draw draw = {.regions = search->measured->regions,
                                  .count = search->measured->count,
                                  .spacing = search->rim_spacing,
                                  .least = least_rim_gap * search->measured->tolerance,
                                  .greatest = greatest_rim_gap * search->measured->tolerance,
                                  .seed = search->seed};
    psplat_rim_point *rims;
    plan.cosines = cosines, plan.slants = SLANTS, plan.around = AROUND_RIMS;
    psplat_result result = psplat_rim_points_draw(&draw, &rims, &plan.count);
    if (result) return result;
    plan.rims = rims;
    plan.places = calloc(plan.count + 1, sizeof *plan.places);
    for (size_t i = 0; plan.places && i < plan.count; ++i)
        memcpy(plan.places[i].point, rims[i].point, sizeof plan.places[i].point);
    result = plan.places ? measure_places(&plan, holes) : PSPLAT_ERROR_MEMORY;
    free(plan.places);
    free(rims);
    return result;
}

/* Returns the balls of splats, none for NULL. The caller frees them; NULL when out of memory. */
static ball *make_balls(const psplat_measured_splats *splats) {
    size_t count = splats ? splats->count : 0;
    ball *balls = malloc((count + 1) * sizeof *balls);
    for (size_t i = 0; balls && i < count; ++i) {
        const psplat_region *region = &splats->regions[i];
        balls[i] = (ball){.radius = psplat_region_reach(region),
                          .bend = psplat_region_bend(region),
                          .splat = (uint32_t)i};
        memcpy(balls[i].center, region->center, sizeof balls[i].center);
    }
    return balls;
}

psplat_result psplat_ray_holes_find(const psplat_ray_search *search, psplat_ray_holes *holes) {
    ball *balls = make_balls(search->measured), *hiders = make_balls(search->hiders);
    const ray_plan plan = {.search = search, .balls = balls, .hiders = hiders};
    psplat_result result = balls && hiders ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    *holes = (psplat_ray_holes){0};
    if (!result && search->points) result = measure_points(plan, holes);
    if (!result && search->rim_spacing > 0) result = measure_rims(plan, holes);
    free(balls);
    free(hiders);
    if (result) psplat_ray_holes_free(holes);
    return result;
}

int psplat_ray_hole_is_closed(const psplat_ray_hole *hole, const psplat_region *region,
                              double tolerance) {
    double height, uv[2];
    return psplat_sight_meets(&hole->sight, region, 0, 0, &height, uv) &&
           fabs(height) * hole->cosine <= tolerance;
}

int psplat_ray_hole_is_hidden(const psplat_ray_hole *hole, const psplat_region *region,
                              double tolerance, double wall) {
    double height, uv[2];
    return psplat_sight_meets(&hole->sight, region, wall, 0, &height, uv) &&
           fabs(height) * hole->cosine <= PSPLAT_HIDING_TOLERANCES * tolerance;
}

/* The search for a splat that hides a hole. */
typedef struct hider {
    const psplat_ray_hole *hole;
    const psplat_measured_splats *measured;
    int hides;
} hider;

static int visit_hiding(void *user, uint32_t splat) {
    hider *h = user;
    const psplat_measured_splats *measured = h->measured;
    h->hides = psplat_ray_hole_is_hidden(h->hole, &measured->regions[splat], measured->tolerance,
                                         measured->wall);
    return h->hides;
}

int psplat_ray_hole_shows(const psplat_ray_hole *hole, const psplat_measured_splats *measured) {
    double reach = PSPLAT_HIDING_TOLERANCES * measured->tolerance / hole->cosine, low[3], high[3];
    hider h = {hole, measured, 0};
    for (int k = 0; k < 3; ++k) {
        /* Walls leave the boxes of splats. */
        double away = reach * fabs(hole->sight.direction[k]) + measured->wall;
        low[k] = hole->sight.point[k] - away;
        high[k] = hole->sight.point[k] + away;
    }
    psplat_region_tree_visit_box(measured->region_tree, low, high, visit_hiding, &h);
    return !h.hides;
}

void psplat_ray_holes_free(psplat_ray_holes *holes) {
    free(holes->holes);
    *holes = (psplat_ray_holes){0};
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * verify.c - the verification of stored splats against the surface.
 *
 * It draws its own random samples of the surface, about a tolerance apart, and measures coverage,
 * normals and colours there. Holes between them are searched for without samples, down to a small
 * part of the tolerance. The distance is two-sided (Hausdorff distance): from samples and holes to
 * splats, and from each splat, bounded over all of it, to the mesh. Creases inside splats are found
 * without samples. Texture coordinates are compared with those of the samples. For each broken
 * promise it reports the worst places.
 */
#include "verify/verify.h"

#include "base/angle.h"
#include "base/region.h"
#include "base/region_distance.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/samples.h"
#include "features/surface.h"
#include "material/mipmap.h"
#include "measure/crease_crossings.h"
#include "measure/hidden_samples.h"
#include "measure/holes.h"
#include "measure/measured_splats.h"
#include "measure/point_blend.h"
#include "measure/splat_distance.h"
#include "measure/texture_slides.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"
#include "measure/color_errors.h"
#include "verify/observations.h"
#include "verify/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The number of samples for each splat, and the bounds of the number of all. Chosen by hand. */
enum { SAMPLES_PER_SPLAT = 100, LEAST_SAMPLES = 50000, MOST_SAMPLES = 1000000 };

/* The side of the cubes in each of which one hole is found, and the width below which parts of the
 * surface are not divided, in tolerances. Chosen by hand. */
static const double hole_side_tolerances = 1, least_hole_tolerances = 1.0 / 16;

/* The share of the textured samples at which textures may slide farther than promised: points of
 * small splats at poles of the coordinates, of which no polynomial of the second order is near, and
 * points between the samples that a fit has seen. The greatest share measured was 0.16 %, of a
 * conversion without local search. Chosen by hand. */
static const double spared_share = 0.005;

/* The same of looks: points beside the edges of what is painted, where splats of both sides blend.
 * Sparing 50 of 1000 costs checkered paint at 0.2 % 1.3 times the splats of no promise, sparing 20
 * took 2.9 times as many for a picture that looks the same. Chosen by hand. */
static const double spared_color_share = 0.05;

/* The part of a limit by which rounding may make measured angles exceed it. */
static const double rounding_slack = 1e-6;

/* ---- places ---------------------------------------------------------------------------------- */

/* The worst places of each promise, worst first, no two of them close together. */
typedef struct places {
    psplat_place worst[PSPLAT_PROMISE_COUNT][PSPLAT_MOST_PLACES];
    size_t count[PSPLAT_PROMISE_COUNT];
    double least_separation; /* of two places of one promise, a length */
    const double *origin;
} places;

static int is_near(const psplat_place *place, const double position[3], double distance) {
    double d[3];
    sub3(d, place->position, position);
    return length3(d) < distance;
}

/* Inserts a place, given in the mesh's centred coordinates. It replaces those near it that are less
 * bad, and is dropped where one near it is worse. */
static void add_place(places *p, psplat_promise promise, const double position[3], double value) {
    psplat_place *list = p->worst[promise], place = {.promise = promise, .value = value};
    size_t count = p->count[promise], at = 0, kept = 0;
    if (count == PSPLAT_MOST_PLACES && value <= list[count - 1].value) return;
    for (int k = 0; k < 3; ++k) place.position[k] = position[k] + p->origin[k];
    for (; at < count && list[at].value >= value; ++at)
        if (is_near(&list[at], place.position, p->least_separation)) return;
    for (size_t i = at; i < count; ++i)
        if (!is_near(&list[i], place.position, p->least_separation)) list[at + kept++] = list[i];
    if (at + kept == PSPLAT_MOST_PLACES) --kept;
    memmove(list + at + 1, list + at, kept * sizeof *list);
    list[at] = place;
    p->count[promise] = at + kept + 1;
}

/* Moves the worst places to the report. All broken promises get equal shares of its room, as far as
 * they have places. */
static void report_places(const places *p, psplat_report *report) {
    size_t left[PSPLAT_PROMISE_COUNT], shares[PSPLAT_PROMISE_COUNT] = {0};
    memcpy(left, p->count, sizeof left);
    for (size_t used = 0, more = 1; more && used < PSPLAT_MOST_PLACES;) {
        more = 0;
        for (int k = 0; k < PSPLAT_PROMISE_COUNT && used < PSPLAT_MOST_PLACES; ++k)
            if (left[k]) --left[k], ++shares[k], ++used, more = 1;
    }
    report->place_count = 0;
    for (int k = 0; k < PSPLAT_PROMISE_COUNT; ++k)
        for (size_t i = 0; i < shares[k]; ++i)
            report->places[report->place_count++] = p->worst[k][i];
}

static void set_promise(psplat_report *report, psplat_promise promise, double limit, double worst,
                        size_t broken) {
    report->promises[promise] = (psplat_kept){limit, worst, broken};
}

/* ---- surface to splats ---------------------------------------------------------------------- */

/* What is measured of the splats near one surface point. */
typedef struct probe {
    psplat_point_blend blend;
    double normal[3]; /* unit: the surface's, as normal maps turn it */
    double height;    /* least distance of the splats that cover it; HUGE_VAL: none does */
    double cosine;    /* greatest between the normal and the fields of these splats */
} probe;

static double cosine3(const double a[3], const double unit[3]) {
    return dot3(a, unit) / length3(a);
}

static int visit_splat(void *user, uint32_t index) {
    probe *p = user;
    const psplat_measured_splats *measured = p->blend.measured;
    double uvh[3], field[3];
    if (!psplat_measured_splats_near(measured, index, p->blend.point, p->blend.reach)) return 0;
    psplat_point_blend_add(&p->blend, index);
    psplat_region_local(&measured->regions[index], p->blend.point, uvh);
    if (!psplat_measured_splats_cover(measured, index, p->blend.normal, uvh)) return 0;
    p->height = min2(p->height, fabs(uvh[2]));
    psplat_blend_field_normal(&measured->fields[index], uvh, field);
    p->cosine = max2(p->cosine, cosine3(field, p->normal));
    return 0;
}

/* The measurements at each sample. Threads fill them in parallel, and they are summed in order
 * afterwards, so that sums do not depend on the number of threads. Angles are in degrees; they are
 * negative where there is no splat to measure. */
typedef struct measurements {
    double *distances;                /* from the nearest splat that covers it, else from any */
    double *own, *blended, *constant; /* angles: least of one splat; of blends (point_blend.h) */
    double *color, *flat_color;       /* root mean squares over the channels, % of sRGB's range */
    float *looks; /* x PSPLAT_LOOK_VALUES: what is shown (color_errors.h); NULL: not promised */
    uint8_t *uncovered;
} measurements;

static double angle_degrees(double cosine) {
    return acos(min2(max2(cosine, -1), 1)) / PSPLAT_DEGREE;
}

/* Returns the error of a blended colour, given as a weighted sum, from that of a sample: the root
 * mean square over the channels, in % of sRGB's range. Returns -1 where nothing is seen. */
static double color_error(const double sum[3], double weight, const double expected[3]) {
    double squares = 0;
    if (!(weight > 0)) return -1;
    for (int k = 0; k < 3; ++k) {
        double d = (double)psplat_srgb_of_linear((float)(sum[k] / weight)) -
                   (double)psplat_srgb_of_linear((float)expected[k]);
        squares += d * d;
    }
    return 100 * sqrt(squares / 3);
}

/* Finds the linear colour of a sample, with its material's factor. */
static void expected_color(const psplat_surface *surface, const psplat_samples *samples, size_t i,
                           double color[3]) {
    const psplat_mesh *mesh = surface->mesh;
    uint32_t group = mesh->groups ? mesh->groups[samples->triangles[i]] : 0;
    const psplat_material *material = group < mesh->source_material_count
                                          ? &mesh->source_materials[group].material
                                          : &mesh->material;
    for (size_t k = 0; k < 3; ++k) {
        color[k] = (double)material->base_color[k];
        if (samples->colors) color[k] *= (double)samples->colors[4 * i + k];
    }
}

static void measure_color(const psplat_point_blend *blend, const psplat_surface *surface,
                          const psplat_samples *samples, size_t i, measurements *m) {
    double expected[3];
    expected_color(surface, samples, i, expected);
    m->color[i] = color_error(blend->color, blend->weight, expected);
    m->flat_color[i] = color_error(blend->flat_color, blend->weight, expected);
}

static double nearest_distance(const psplat_measured_splats *measured, const double point[3]) {
    return psplat_region_nearest_distance(measured->regions, measured->count, measured->region_tree,
                                          measured->tolerance, point);
}

static void measure_sample(const psplat_surface *surface, const psplat_samples *samples, size_t i,
                           const psplat_measured_splats *measured, measurements *m) {
    probe p = {
        .blend = {.measured = measured, .reach = 2 * measured->tolerance, .limit = -HUGE_VAL},
        .height = HUGE_VAL,
        .cosine = -1};
    psplat_point_blend *blend = &p.blend;
    memcpy(blend->point, samples->positions + 3 * i, sizeof blend->point);
    const float *turned = samples->turned ? samples->turned : samples->normals;
    for (size_t k = 0; k < 3; ++k) blend->normal[k] = (double)samples->normals[3 * i + k];
    for (size_t k = 0; k < 3; ++k) p.normal[k] = (double)turned[3 * i + k];
    normalize3(blend->normal);
    normalize3(p.normal);
    psplat_region_tree_visit(measured->region_tree, blend->point, visit_splat, &p);
    int shows = dot3(blend->blended, blend->blended) > 0;
    m->uncovered[i] = p.height == HUGE_VAL;
    m->distances[i] = m->uncovered[i] ? nearest_distance(measured, blend->point) : p.height;
    m->own[i] = m->uncovered[i] ? -1 : angle_degrees(p.cosine);
    m->blended[i] = shows ? angle_degrees(cosine3(blend->blended, p.normal)) : -1;
    m->constant[i] = shows ? angle_degrees(cosine3(blend->constant, p.normal)) : -1;
    if (m->color) measure_color(blend, surface, samples, i, m);
    if (m->looks) psplat_blended_look(blend, m->looks + PSPLAT_LOOK_VALUES * i);
}

/* Returns the value that sorting would put at the index `at`, by Hoare's selection. Reorders
 * values.
 */
static double select_value(double *values, size_t count, size_t at) {
    for (size_t begin = 0, end = count; end - begin > 1;) {
        double pivot = values[begin + (end - 1 - begin) / 2];
        size_t i = begin, j = end - 1;
        for (;;) {
            while (values[i] < pivot) ++i;
            while (values[j] > pivot) --j;
            if (i >= j) break;
            double swap = values[i];
            values[i++] = values[j];
            values[j--] = swap;
        }
        if (at <= j)
            end = j + 1;
        else
            begin = j + 1;
    }
    return values[at];
}

/* Finds the root mean square and the 95th percentile of the errors that are not negative. Reorders
 * them. */
static void statistics(double *errors, size_t count, double *rms, double *p95) {
    size_t given = 0;
    double squares = 0;
    for (size_t i = 0; i < count; ++i) {
        if (errors[i] < 0) continue;
        squares += errors[i] * errors[i];
        errors[given++] = errors[i];
    }
    *rms = given ? sqrt(squares / (double)given) : 0;
    *p95 = given ? select_value(errors, given, (given - 1) * 95 / 100) : 0;
}

/* Returns the number of samples beyond a limit of values, unless it is but a small share of those
 * that are not negative, and what that share exceeds. */
static size_t count_far(const double *values, size_t count, double limit, double share,
                        double *exceeded) {
    double *given = malloc((count + 1) * sizeof *given);
    size_t measured = 0, far = 0;
    *exceeded = 0;
    if (!given) return SIZE_MAX;
    for (size_t i = 0; i < count; ++i)
        if (values[i] >= 0) given[measured++] = values[i], far += values[i] > limit;
    size_t spared = (size_t)(share * (double)measured);
    if (measured) *exceeded = select_value(given, measured, measured - 1 - spared);
    free(given);
    return far > spared ? far : 0;
}

/* ---- reports of what the samples measured ---------------------------------------------------- */

/* The state of one verification. */
typedef struct verifier {
    const psplat_verification *v;
    psplat_samples samples;
    psplat_measured_splats measured;
    places places;
    psplat_report *report;
    size_t far; /* the number of samples and splats beyond the tolerance */
} verifier;

/* Returns a length in % of the diagonal. */
static double percent(const verifier *r, double length) {
    return 100 * length / r->v->diagonal;
}

/* Measures the holes, which samples may have missed. Returns their greatest distance from a splat.
 */
static double measure_holes(verifier *r, const psplat_holes *holes) {
    double greatest = 0;
    for (size_t i = 0; i < holes->count; ++i) {
        const double *point = holes->points + 3 * i;
        double distance = nearest_distance(&r->measured, point);
        greatest = max2(greatest, distance);
        r->far += distance > r->measured.tolerance;
        add_place(&r->places, PSPLAT_PROMISE_COVERAGE, point, percent(r, distance));
        if (r->v->observations) psplat_observations_open(r->v->observations, point, distance);
    }
    return greatest;
}

/* Hands on what the samples measured. Returns 0 when out of memory. */
static int observe_samples(const verifier *r, const measurements *m, const psplat_holes *holes) {
    psplat_observations *o = r->v->observations;
    size_t count = r->samples.count;
    if (!o) return 1;
    if (!psplat_observations_allocate(o, r->v->splats->count, count, count + holes->count))
        return 0;
    memcpy(o->points, r->samples.positions, count * 3 * sizeof *o->points);
    memcpy(o->degrees, m->blended, count * sizeof *o->degrees);
    for (size_t i = 0; i < count; ++i)
        if (m->uncovered[i])
            psplat_observations_open(o, r->samples.positions + 3 * i, m->distances[i]);
    return 1;
}

static void report_coverage(verifier *r, const measurements *m, const psplat_holes *holes) {
    double squares = 0, open = measure_holes(r, holes), greatest = open;
    size_t count = r->samples.count, uncovered = 0;
    for (size_t i = 0; i < count; ++i) {
        double distance = m->distances[i];
        squares += distance * distance;
        greatest = max2(greatest, distance);
        r->far += distance > r->measured.tolerance;
        if (!m->uncovered[i]) continue;
        ++uncovered;
        open = max2(open, distance);
        add_place(&r->places, PSPLAT_PROMISE_COVERAGE, r->samples.positions + 3 * i,
                  percent(r, distance));
    }
    r->report->verification_samples = count;
    r->report->uncovered_samples = uncovered;
    r->report->max_distance_surface_percent = percent(r, greatest);
    r->report->rms_distance_percent = percent(r, sqrt(squares / max2((double)count, 1)));
    r->report->unproven_surface_percent = 100 * holes->unproven / r->v->surface->area;
    set_promise(r->report, PSPLAT_PROMISE_COVERAGE, r->v->tolerance_percent, percent(r, open),
                uncovered + holes->count);
}

static void report_normals(verifier *r, const measurements *m) {
    double greatest = 0, limit = r->v->normal_tolerance_degrees;
    size_t broken = 0;
    for (size_t i = 0; i < r->samples.count; ++i) {
        greatest = max2(greatest, m->own[i]);
        if (!(limit > 0) || m->own[i] <= limit * (1 + rounding_slack)) continue;
        ++broken;
        add_place(&r->places, PSPLAT_PROMISE_NORMAL, r->samples.positions + 3 * i, m->own[i]);
    }
    r->report->max_normal_degrees = greatest;
    set_promise(r->report, PSPLAT_PROMISE_NORMAL, limit, greatest, broken);
}

static void free_measurements(measurements *m) {
    double *lists[] = {m->distances, m->own, m->blended, m->constant, m->color, m->flat_color};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; ++i) free(lists[i]);
    free(m->looks);
    free(m->uncovered);
}

static int allocate_measurements(measurements *m, size_t count, int colors, int looks) {
    double **lists[] = {&m->distances, &m->own,   &m->blended,
                        &m->constant,  &m->color, &m->flat_color};
    int ok = 1;
    *m = (measurements){.uncovered = malloc(count + 1)};
    for (size_t i = 0; i < (colors ? 6u : 4u); ++i) {
        *lists[i] = malloc((count + 1) * sizeof **lists[i]);
        ok &= *lists[i] != NULL;
    }
    if (looks) m->looks = malloc((count + 1) * PSPLAT_LOOK_VALUES * sizeof *m->looks);
    return ok && m->uncovered && (m->looks || !looks);
}

static void report_blend_errors(verifier *r, const measurements *m) {
    size_t count = r->samples.count;
    psplat_report *report = r->report;
    statistics(m->blended, count, &report->rms_normal_degrees, &report->p95_normal_degrees);
    statistics(m->constant, count, &report->rms_normal_constant_degrees,
               &report->p95_normal_constant_degrees);
    report->rms_color_percent = report->p95_color_percent = 0;
    report->rms_color_constant_percent = report->p95_color_constant_percent = 0;
    if (!m->color) return;
    statistics(m->color, count, &report->rms_color_percent, &report->p95_color_percent);
    statistics(m->flat_color, count, &report->rms_color_constant_percent,
               &report->p95_color_constant_percent);
}

/* Reports where splats show other colours or finishes than the surface has. */
static psplat_result report_looks(verifier *r, const measurements *m) {
    size_t count = r->samples.count, seen = 0, beyond = 0;
    double rms, worst, limit = r->v->color_tolerance_percent, most = limit * (1 + rounding_slack);
    psplat_report *report = r->report;
    report->max_look_percent = report->p95_look_percent = report->look_beyond_percent = 0;
    set_promise(report, PSPLAT_PROMISE_COLOR, 0, 0, 0);
    if (!m->looks) return PSPLAT_OK;
    double *errors = malloc((count + 1) * sizeof *errors);
    psplat_result result = errors ? psplat_color_errors_find(r->v->surface, &r->samples, m->looks,
                                                             r->measured.tolerance, most, errors)
                                  : PSPLAT_ERROR_MEMORY;
    size_t broken = result ? SIZE_MAX : count_far(errors, count, most, spared_color_share, &worst);
    if (broken != SIZE_MAX) {
        for (size_t i = 0; i < count; ++i) {
            seen += errors[i] >= 0, beyond += errors[i] > most;
            report->max_look_percent = max2(report->max_look_percent, errors[i]);
            if (broken && errors[i] > most)
                add_place(&r->places, PSPLAT_PROMISE_COLOR, r->samples.positions + 3 * i,
                          errors[i]);
        }
        report->look_beyond_percent = 100 * (double)beyond / max2((double)seen, 1);
        set_promise(report, PSPLAT_PROMISE_COLOR, limit, worst, broken);
        statistics(errors, count, &rms, &report->p95_look_percent);
    }
    free(errors);
    return broken == SIZE_MAX ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

static psplat_result find_holes(verifier *r, psplat_holes *holes) {
    double tolerance = r->measured.tolerance;
    return psplat_holes_find(r->v->surface, &r->measured, hole_side_tolerances * tolerance,
                             least_hole_tolerances * tolerance, holes);
}

static psplat_result measure_surface(verifier *r) {
    measurements m;
    psplat_holes holes;
    psplat_result result = find_holes(r, &holes);
    if (result) return result;
    result = PSPLAT_ERROR_MEMORY;
    int looks = r->v->color_tolerance_percent > 0 && psplat_samples_have_look(&r->samples);
    if (allocate_measurements(&m, r->samples.count, r->samples.colors != NULL, looks)) {
        long end = (long)r->samples.count;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 1024)
#endif
        for (long i = 0; i < end; ++i)
            measure_sample(r->v->surface, &r->samples, (size_t)i, &r->measured, &m);
        if (observe_samples(r, &m, &holes)) result = PSPLAT_OK;
        report_coverage(r, &m, &holes);
        report_normals(r, &m);
        report_blend_errors(r, &m);
        if (!result) result = report_looks(r, &m);
    }
    free_measurements(&m);
    psplat_holes_free(&holes);
    return result;
}

/* ---- splats to surface ---------------------------------------------------------------------- */

static void report_distances(verifier *r, const psplat_splat_distance *far) {
    double greatest = 0, bound = 0;
    psplat_report *report = r->report;
    report->unproven_splats = 0;
    for (size_t s = 0; s < r->v->splats->count; ++s) {
        greatest = max2(greatest, far[s].found);
        bound = max2(bound, far[s].bound);
        if (r->v->observations) r->v->observations->bounds[s] = far[s].bound;
        report->unproven_splats += far[s].nearness == PSPLAT_NEARNESS_UNDECIDED;
        if (far[s].nearness != PSPLAT_NEARNESS_EXCEEDS) continue;
        ++r->far;
        add_place(&r->places, PSPLAT_PROMISE_DISTANCE, far[s].point, percent(r, far[s].found));
    }
    report->max_distance_splats_percent = percent(r, greatest);
    report->bound_distance_splats_percent = percent(r, bound);
    report->max_distance_percent =
        max2(report->max_distance_surface_percent, report->max_distance_splats_percent);
    set_promise(report, PSPLAT_PROMISE_DISTANCE, r->v->tolerance_percent,
                report->max_distance_percent, r->far);
}

static psplat_result measure_splats(verifier *r) {
    const psplat_splat_distance_desc desc = {.tolerance = r->measured.tolerance};
    psplat_splat_distance *far = malloc((r->v->splats->count + 1) * sizeof *far);
    if (!far) return PSPLAT_ERROR_MEMORY;
    long end = (long)r->v->splats->count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 16) reduction(| : failed)
#endif
    for (long i = 0; i < end; ++i)
        failed |= psplat_splat_distance_find(&r->measured.regions[i], r->v->distance, &desc,
                                             &far[i]) != PSPLAT_OK;
    if (!failed) report_distances(r, far);
    free(far);
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

/* ---- creases, and the whole verification ----------------------------------------------------- */

/* Drops the crossings that lie in the apron. *greatest becomes that of the others. */
static void drop_apron_crossings(const psplat_surface *surface, psplat_crease_crossing *crossings,
                                 size_t *count, double *greatest) {
    size_t kept = 0;
    *greatest = 0;
    for (size_t i = 0; i < *count; ++i) {
        if (!psplat_surface_owns(surface, crossings[i].point)) continue;
        *greatest = max2(*greatest, crossings[i].depth);
        crossings[kept++] = crossings[i];
    }
    *count = kept;
}

static psplat_result measure_creases(verifier *r) {
    psplat_crease_crossing *crossings;
    size_t count;
    double greatest;
    psplat_result result =
        psplat_crease_crossings_find(r->v->surface, &r->samples, &r->measured,
                                     r->measured.tolerance, 1, &crossings, &count, &greatest);
    if (result) return result;
    if (r->v->surface->owned) drop_apron_crossings(r->v->surface, crossings, &count, &greatest);
    for (size_t i = 0; i < count; ++i)
        add_place(&r->places, PSPLAT_PROMISE_CREASE, crossings[i].point,
                  percent(r, crossings[i].depth));
    set_promise(r->report, PSPLAT_PROMISE_CREASE, r->v->tolerance_percent, percent(r, greatest),
                count);
    free(crossings);
    return PSPLAT_OK;
}

/* ---- textures -------------------------------------------------------------------------------- */

/* Sums up the greatest and the 95 % slide, of lengths and of texels. Reorders both. */
static void sum_up_slides(verifier *r, psplat_texture_slides *slides) {
    psplat_report *report = r->report;
    size_t count = r->samples.count;
    double rms, length = 0, texels = 0;
    for (size_t i = 0; i < count; ++i) {
        length = max2(length, slides->lengths[i]);
        texels = max2(texels, slides->texels[i]);
    }
    report->max_texture_slide_percent = percent(r, length);
    report->max_texture_slide_texels = texels;
    statistics(slides->lengths, count, &rms, &length);
    report->p95_texture_slide_percent = percent(r, length);
    statistics(slides->texels, count, &rms, &report->p95_texture_slide_texels);
    report->mirrored_texture_percent = 100 * slides->mirrored;
    report->foreign_texture_percent = 100 * slides->foreign;
}

/* Returns what counts as the slide at a sample where the splats show other charts alone: the whole
 * of the mesh, or a side of its image. */
static double lost_slide(const verifier *r, size_t sample, int in_texels) {
    const psplat_kept_textures *kept =
        psplat_surface_kept_textures(r->v->surface, r->samples.triangles[sample]);
    return in_texels && kept ? max2(kept->texels[0], kept->texels[1]) : r->v->diagonal;
}

/* Stores the slides that the promise is about, in texels or as lengths, r->samples.count: where one
 * sees nothing of them, since what is shown looks the same or the sample is hidden, they count as
 * `most` at most. A length is the shorter one of the splat's own, and of the way to where the
 * surface has what the splat shows. */
static psplat_result find_promised_slides(const verifier *r, const psplat_texture_slides *slides,
                                          int in_texels, double most, double *values) {
    const psplat_verification *v = r->v;
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < r->samples.count && !result; ++i) {
        int hidden = !slides->seen[i] && !slides->lost[i];
        values[i] = in_texels ? slides->texels[i] : min2(slides->lengths[i], slides->ways[i]);
        if (slides->lost[i]) values[i] = lost_slide(r, i, in_texels);
        if (!hidden && values[i] > most)
            result = psplat_sample_is_hidden(v->surface, &r->samples, v->distance,
                                             r->measured.tolerance, i, &hidden);
        if (hidden) values[i] = min2(values[i], most);
    }
    return result;
}

/* Reports the samples at which one sees that a texture slides too far, and how far it does. */
static psplat_result report_slides(verifier *r, psplat_texture_slides *slides) {
    double limit = r->v->texture_tolerance_texels, unit = 1, worst;
    int in_texels = limit > 0;
    if (!in_texels) limit = r->v->tolerance_percent, unit = 100 / r->v->diagonal;
    double most = limit * (1 + rounding_slack);
    double *values = calloc(r->samples.count + 1, sizeof *values);
    psplat_result result = values ? find_promised_slides(r, slides, in_texels, limit / unit, values)
                                  : PSPLAT_ERROR_MEMORY;
    if (result) {
        free(values);
        return result;
    }
    size_t broken = count_far(values, r->samples.count, most / unit, spared_share, &worst);
    for (size_t i = 0; broken && broken != SIZE_MAX && i < r->samples.count; ++i)
        if (values[i] * unit > most)
            add_place(&r->places, PSPLAT_PROMISE_TEXTURE, r->samples.positions + 3 * i,
                      values[i] * unit);
    free(values);
    if (broken == SIZE_MAX) return PSPLAT_ERROR_MEMORY;
    set_promise(r->report, PSPLAT_PROMISE_TEXTURE, limit, worst * unit, broken);
    sum_up_slides(r, slides);
    return PSPLAT_OK;
}

static psplat_result measure_textures(verifier *r) {
    psplat_report *report = r->report;
    report->max_texture_slide_percent = report->p95_texture_slide_percent = 0;
    report->max_texture_slide_texels = report->p95_texture_slide_texels = 0;
    report->mirrored_texture_percent = report->foreign_texture_percent = 0;
    report->texture_tolerance_texels = 0;
    set_promise(report, PSPLAT_PROMISE_TEXTURE, 0, 0, 0);
    if (!r->samples.texcoords || !r->v->splats->texcoords) return PSPLAT_OK;
    psplat_texture_slides slides;
    psplat_result result =
        psplat_texture_slides_find(r->v->surface, &r->samples, r->v->splats, &r->measured, &slides);
    report->texture_tolerance_texels = r->v->texture_tolerance_texels;
    if (!result) result = report_slides(r, &slides);
    psplat_texture_slides_free(&slides);
    return result;
}

/* Returns how many samples are drawn: one for each square of the tolerance, within bounds. Where
 * colours are promised there are at least as many as these need. */
static size_t sample_count(const psplat_verification *v, double tolerance) {
    double wanted = max2((double)v->splats->count * SAMPLES_PER_SPLAT, LEAST_SAMPLES);
    wanted = max2(wanted, v->surface->area / (tolerance * tolerance));
    if (v->color_tolerance_percent > 0)
        wanted = max2(wanted, (double)psplat_color_point_count(v->surface, tolerance));
    return (size_t)min2(wanted, MOST_SAMPLES);
}

double psplat_verified_cover(double tolerance) {
    /* From the middle of a triangle to its corners it is at most 2/3 of the longest side. */
    return tolerance * (1 + rounding_slack) * (1 + least_hole_tolerances * 2 / 3);
}

double psplat_verified_open_reach(double tolerance) {
    /* A hole stands for the part of a triangle that it is in, whose sides are at most as long as
     * those of a cube, and one stands for all in a cube (measure/holes.c). */
    return tolerance * (1 + rounding_slack) * hole_side_tolerances * (1 + sqrt(3));
}

double psplat_verified_distance(const psplat_report *report) {
    const psplat_kept *coverage = &report->promises[PSPLAT_PROMISE_COVERAGE];
    double unit = report->diagonal / 100, tolerance = report->tolerance_percent * unit;
    double distance =
        max2(tolerance,
             max2(report->max_distance_percent, report->bound_distance_splats_percent) * unit);
    if (report->unproven_surface_percent > 0)
        distance = max2(distance, psplat_verified_cover(tolerance));
    if (coverage->broken)
        distance = max2(distance, coverage->worst * unit + psplat_verified_open_reach(tolerance));
    return distance;
}

psplat_result psplat_verify(const psplat_verification *v, psplat_report *report,
                            psplat_error *error) {
    double tolerance = v->tolerance_percent / 100 * v->diagonal;
    verifier r = {
        .v = v,
        .report = report,
        .places = {.least_separation = 2 * tolerance, .origin = v->surface->mesh->origin}};
    psplat_result result = psplat_samples_draw_uniform(v->surface, sample_count(v, tolerance),
                                                       v->seed, &r.samples, error);
    if (result) return result;
    psplat_samples_drop_apron(&r.samples, v->surface);
    result = psplat_measured_splats_create(v->splats, tolerance, PSPLAT_STEEPEST_REACH * tolerance,
                                           &r.measured);
    if (!result) result = measure_surface(&r);
    if (!result) result = measure_splats(&r);
    if (!result) result = measure_creases(&r);
    if (!result) result = measure_textures(&r);
    if (!result) report_places(&r.places, report);
    psplat_measured_splats_free(&r.measured);
    psplat_samples_free(&r.samples);
    return result ? psplat_fail(error, result, 0, "out of memory while verifying") : PSPLAT_OK;
}

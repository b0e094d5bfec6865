/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * own_fields.c - normal fields of curved splats that are not those of their shapes.
 *
 * The normals of a smooth-shaded mesh of few polygons are not those of its facets, to which shapes
 * are fitted. Where they differ by much, a field beside the shape (spec 3.4) shows the surface as
 * its author shaded it. The fields are fitted to what splats blend to, not each to the surface: at
 * random points the blend of all splats is to have the surface's shading normal. That is a least
 * squares problem of five unknowns a splat, which is solved splat after splat with the others as
 * they are (the method of Gauss and Seidel). On the grid of the file it goes on with integers, so
 * that neighbours make up for each other's rounding.
 */
#include "finish/own_fields.h"

#include "base/region.h"
#include "base/vector.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "fit/normal_field.h"
#include "mesh/mesh.h"
#include "finish/blend_points.h"
#include "select/conversion.h"
#include "select/precision.h"
#include "select/selection.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All of these were chosen by hand, those of bytes by the files of twelve models. */
/* The points for each splat, and how often all splats are fitted, before and after rounding. With
 * twice as many of either, errors fall by 1 or 2 % more. */
enum { POINTS_PER_SPLAT = 200, SWEEPS = 3 };
/* The weight by which a field is held to that of its shape, as a part of the trace of its system:
 * this over the number of points. It decides where a splat has few points. */
static const double prior_weight = 0.1;
/* The greatest sum of a field's slope at the centre and its gradient: far below the 20 of spec
 * (3a), beyond the 2.75 of shapes. */
static const double greatest_slope = 4;
/* The part of the mean squared error of a splat that a flat splat's field has to take to change:
 * most of them are 0, which takes no bytes. */
static const double least_flat_part = 0.05;
/* The part of the blended error (root mean square) that fields of their own have to take, and how
 * many times the part of the bytes that they add. A finer tolerance for as many bytes takes 0.4 to
 * 1.4 times that part of the error, and makes outlines better. */
static const double least_gain = 0.2, least_gain_of_bytes = 2;
/* The mean part of the tolerance that fits use from which on fields pay. Splats that lie on their
 * surface, as those of machined parts, have its normals but for the ends of fillets and rounding,
 * and a finer tolerance makes these better for as many bytes, and outlines with them. */
static const double least_used = 0.4;
/* The bytes of a curved splat's own field, and of splats without: of one without lines, of a line,
 * of colours and of texture coordinates. */
static const double field_bytes = 2.5, splat_bytes = 8.5, line_bytes = 4, color_bytes = 2,
                    texcoord_bytes = 10;
/* The step of fields in units of the error that is left (root mean square, radians), and its
 * bounds. Errors grow by 5 % from rounding then, and half the step takes 2 % more bytes. */
static const double step_part = 1, least_step = 1.0 / 1024, greatest_step = 0.25;
/* An offset of the user's seed, which gives the points random numbers of their own: the ASCII
 * letters of "fields". */
static const uint64_t fields_seed = 0x6669656c64730000u;

enum { UNKNOWNS = 5 }; /* x, y, alpha, beta, gamma */

typedef struct field_fit {
    psplat_blend_points points;
    const psplat_candidate *candidates;
    size_t count;
    double (*fields)[UNKNOWNS]; /* count */
    double (*sums)[3];          /* of each point: what splats blend to, of any length */
    double step;                /* that fields are multiples of; 0: of none */
    double least_flat_gain;     /* of the squared errors of a splat's points */
} field_fit;

/* The normal equations m f = right of a splat's field f. */
typedef struct field_system {
    double m[UNKNOWNS][UNKNOWNS], right[UNKNOWNS];
} field_system;

/* ---- blends ---------------------------------------------------------------------------------- */

static void field_of_shape(const psplat_region *r, double field[UNKNOWNS]) {
    const double shape[UNKNOWNS] = {-r->slope[0], -r->slope[1], -r->hessian[0] * r->radius[0],
                                    -r->hessian[2] * r->radius[1], -r->hessian[1] * r->radius[0]};
    memcpy(field, shape, sizeof shape);
}

/* Finds what a splat of this field adds to the blend at a hit. */
static void fragment(const psplat_region *region, const double field[UNKNOWNS],
                     const psplat_blend_hit *hit, double added[3]) {
    const double uv[2] = {(double)hit->uv[0], (double)hit->uv[1]};
    double xy[2], weight = (double)hit->weight;
    psplat_normal_field_at(field, region->radius, uv, xy);
    for (int k = 0; k < 3; ++k)
        added[k] = weight * (region->n[k] + xy[0] * region->u[k] + xy[1] * region->v[k]);
}

/* Adds a splat to the blends of its points, or takes it out with a sign of -1. */
static void add_splat(field_fit *f, size_t i, double sign) {
    for (size_t k = f->points.first[i]; k < f->points.first[i + 1]; ++k) {
        double added[3];
        fragment(&f->candidates[i].region, f->fields[i], &f->points.hits[k], added);
        mad3(f->sums[f->points.hits[k].point], sign, added);
    }
}

/* Returns the square of the angle between a blend and a unit normal, up to the fourth order. */
static double squared_error(const double blend[3], const double normal[3]) {
    double length = length3(blend);
    return length > 0 ? 2 - 2 * dot3(blend, normal) / length : 0;
}

/* Returns the sum of the squared errors of a splat's points with this field. It must have been
 * taken out of their blends. */
static double error_with(const field_fit *f, size_t i, const double field[UNKNOWNS]) {
    double sum = 0;
    for (size_t k = f->points.first[i]; k < f->points.first[i + 1]; ++k) {
        const psplat_blend_hit *hit = &f->points.hits[k];
        double blend[3];
        fragment(&f->candidates[i].region, field, hit, blend);
        mad3(blend, 1, f->sums[hit->point]);
        sum += squared_error(blend, f->points.normals[hit->point]);
    }
    return sum;
}

/* Returns the sum of the squared errors of all points. */
static double whole_error(const field_fit *f) {
    double sum = 0;
    for (size_t i = 0; i < f->points.count; ++i)
        sum += squared_error(f->sums[i], f->points.normals[i]);
    return sum;
}

/* ---- the field of one splat ------------------------------------------------------------------ */

/* Adds the equations of a hit, at which the part of the blend across the point's normal, over that
 * along it, is to be 0. The blend's part along the normal is taken as it is now. */
static void add_equations(const field_fit *f, size_t i, const psplat_blend_hit *hit,
                          field_system *system) {
    const psplat_region *r = &f->candidates[i].region;
    const double *normal = f->points.normals[hit->point];
    double u = (double)hit->uv[0], v = (double)hit->uv[1], ratio = r->radius[1] / r->radius[0];
    const double factors[UNKNOWNS][2] = {{1, 0}, {0, 1}, {u, 0}, {0, v}, {ratio * v, u}};
    double blend[3], rest[3], x = dot3(r->u, normal), y = dot3(r->v, normal);
    fragment(r, f->fields[i], hit, blend);
    mad3(blend, 1, f->sums[hit->point]);
    double along = dot3(blend, normal), share = (double)hit->weight / along;
    if (!(along > 0.1 * length3(blend))) return;
    for (int k = 0; k < 3; ++k) rest[k] = f->sums[hit->point][k] / along + share * r->n[k];
    double rest_along = dot3(rest, normal);
    double rest_u = dot3(rest, r->u) - rest_along * x, rest_v = dot3(rest, r->v) - rest_along * y;
    for (int j = 0; j < UNKNOWNS; ++j) { /* U and V are taken across the normal, too. */
        double a = share * (factors[j][0] * (1 - x * x) - factors[j][1] * x * y);
        double b = share * (factors[j][1] * (1 - y * y) - factors[j][0] * x * y);
        for (int k = 0; k < UNKNOWNS; ++k)
            system->m[j][k] += share * (a * factors[k][0] + b * factors[k][1]);
        system->right[j] -= share * (factors[j][0] * rest_u + factors[j][1] * rest_v);
    }
}

/* Finds the equations of a splat, which must have been taken out of the blends. They hold its field
 * a little to that of its shape; flat splats' fields to what they are. */
static void find_system(const field_fit *f, size_t i, field_system *system) {
    const psplat_region *region = &f->candidates[i].region;
    double held[UNKNOWNS], trace = 0;
    size_t first = f->points.first[i], end = f->points.first[i + 1];
    memset(system, 0, sizeof *system);
    for (size_t k = first; k < end; ++k) add_equations(f, i, &f->points.hits[k], system);
    memcpy(held, f->fields[i], sizeof held);
    if (psplat_region_is_curved(region)) field_of_shape(region, held);
    for (int j = 0; j < UNKNOWNS; ++j) trace += system->m[j][j];
    double weight = prior_weight * trace / (double)(end - first + 1);
    for (int j = 0; j < UNKNOWNS; ++j) {
        system->m[j][j] += weight;
        system->right[j] += weight * held[j];
    }
}

/* Solves the system by the factors L D L^T of its matrix. */
static void solve(const field_system *system, double x[UNKNOWNS]) {
    double m[UNKNOWNS][UNKNOWNS];
    memcpy(m, system->m, sizeof m);
    memcpy(x, system->right, UNKNOWNS * sizeof *x);
    for (int i = 0; i < UNKNOWNS; ++i) {
        for (int j = 0; j < i; ++j) {
            for (int k = 0; k < j; ++k) m[i][j] -= m[i][k] * m[j][k] * m[k][k];
            m[i][j] /= m[j][j];
        }
        for (int k = 0; k < i; ++k) m[i][i] -= m[i][k] * m[i][k] * m[k][k];
        for (int k = 0; k < i; ++k) x[i] -= m[i][k] * x[k];
    }
    for (int i = 0; i < UNKNOWNS; ++i) x[i] /= m[i][i];
    for (int i = UNKNOWNS; i-- > 0;)
        for (int k = i + 1; k < UNKNOWNS; ++k) x[i] -= m[k][i] * x[k];
}

static void round_field(double step, double field[UNKNOWNS]) {
    for (int k = 0; k < UNKNOWNS; ++k) field[k] = step * rint(field[k] / step);
}

/* Rounds the solution of a system and goes on, one step of one number at a time, as long as that
 * makes the error of the system smaller. */
static void descend(const field_system *system, double step, double field[UNKNOWNS]) {
    int moved = 1;
    round_field(step, field);
    while (moved) {
        moved = 0;
        for (int j = 0; j < UNKNOWNS; ++j) {
            double slope = -system->right[j], square = system->m[j][j] * step / 2;
            for (int k = 0; k < UNKNOWNS; ++k) slope += system->m[j][k] * field[k];
            if (!(fabs(slope) > square * (1 + 1e-9))) continue;
            field[j] += slope > 0 ? -step : step;
            moved = 1;
        }
    }
}

static int is_bounded(const psplat_region *r, const double f[UNKNOWNS]) {
    double ratio = r->radius[1] / r->radius[0];
    double gradient = f[2] * f[2] + f[3] * f[3] + f[4] * f[4] * (1 + ratio * ratio);
    return norm2(f[0], f[1]) + sqrt(gradient) <= greatest_slope; /* and no NaN */
}

/* Fits the field of one splat to the blends with the others as they are, if that makes them better.
 */
static void refit(field_fit *f, size_t i) {
    const psplat_region *region = &f->candidates[i].region;
    field_system system;
    double tried[UNKNOWNS];
    if (f->points.first[i] == f->points.first[i + 1]) return;
    add_splat(f, i, -1);
    find_system(f, i, &system);
    solve(&system, tried);
    if (is_bounded(region, tried)) {
        if (f->step > 0) descend(&system, f->step, tried);
        double gain = error_with(f, i, f->fields[i]) - error_with(f, i, tried);
        if (gain > (psplat_region_is_curved(region) ? 0 : f->least_flat_gain))
            memcpy(f->fields[i], tried, sizeof tried);
    }
    add_splat(f, i, 1);
}

/* ---- all fields ------------------------------------------------------------------------------ */

static void sweep(field_fit *f) {
    for (int round = 0; round < SWEEPS; ++round)
        for (size_t i = 0; i < f->count; ++i) refit(f, i);
}

/* Puts all fields on the grid, each by itself. */
static void round_all(field_fit *f, double step) {
    f->step = step;
    for (size_t i = 0; i < f->count; ++i) {
        add_splat(f, i, -1);
        round_field(step, f->fields[i]);
        add_splat(f, i, 1);
    }
}

/* Returns the part of a file's bytes that fields of their own add. */
static double added_part(const psplat_conversion *c) {
    double added = 0, bytes = 0;
    for (size_t i = 0; i < c->selection.count; ++i) {
        const psplat_region *region = &c->selection.candidates[i].region;
        bytes += splat_bytes + line_bytes * (region->line_count + region->seam_count);
        if (c->samples.colors) bytes += color_bytes;
        if (c->samples.texcoords) bytes += texcoord_bytes;
        if (psplat_region_is_curved(region)) added += field_bytes;
    }
    return bytes > 0 ? added / bytes : 0;
}

/* Returns whether a part of the error is worth the bytes. */
static int pays(const psplat_conversion *c, double gain) {
    return gain >= least_gain && gain >= least_gain_of_bytes * added_part(c);
}

/* Begins with the fields that splats have without. */
static int begin(psplat_conversion *c, field_fit *f) {
    f->candidates = c->selection.candidates;
    f->count = c->selection.count;
    f->fields = malloc((f->count + 1) * sizeof *f->fields);
    f->sums = calloc(f->points.count + 1, sizeof *f->sums);
    if (!f->fields || !f->sums) return 0;
    for (size_t i = 0; i < f->count; ++i) {
        memcpy(f->fields[i], f->candidates[i].field, sizeof f->fields[i]);
        if (psplat_region_is_curved(&f->candidates[i].region))
            field_of_shape(&f->candidates[i].region, f->fields[i]);
        add_splat(f, i, 1);
    }
    return 1;
}

/* Fits the fields, and stores them and their step where they pay. */
static void fit_fields(psplat_conversion *c, field_fit *f) {
    double before = whole_error(f);
    if (!f->count || !(before > 0)) return;
    f->least_flat_gain = least_flat_part * before / (double)f->count;
    sweep(f);
    double after = whole_error(f);
    if (!pays(c, 1 - sqrt(after / before))) return;
    double error = sqrt(after / (double)f->points.count);
    round_all(f, min2(max2(step_part * error, least_step), greatest_step));
    sweep(f);
    c->splats->precision.field_step = c->splats->precision.tilt_step = f->step;
    for (size_t i = 0; i < f->count; ++i)
        memcpy(c->selection.candidates[i].field, f->fields[i], sizeof f->fields[i]);
}

/* Returns whether some material is lit: else nobody sees a normal. */
static int is_lit(const psplat_mesh *mesh) {
    if (!mesh->source_material_count) return !mesh->material.unlit;
    for (size_t i = 0; i < mesh->source_material_count; ++i)
        if (!mesh->source_materials[i].material.unlit) return 1;
    return 0;
}

static int has_curved(const psplat_selection *selection) {
    for (size_t i = 0; i < selection->count; ++i)
        if (psplat_region_is_curved(&selection->candidates[i].region)) return 1;
    return 0;
}

/* Machined parts get none: the shapes that CAD programs triangulate have the normals, and beside
 * tangent edges fields that serve the whole blend err by more than those (test_tangent_edges).
 * Where the file has normals of its own they may be others than those of the shape, however well
 * splats follow that, and a few tangent edges say nothing about all the rest. Nor are the normals
 * those of the shapes where splats end at edges of facets (features/facet_edges.h). */
psplat_result psplat_fit_own_fields(psplat_conversion *c) {
    field_fit f = {.count = 0};
    if (!c->limits.precision || c->limits.constant_normals || c->limits.normal_tolerance > 0 ||
        c->samples.turned || !is_lit(c->surface.mesh) || !has_curved(&c->selection) ||
        (!c->surface.mesh->corner_normals && !c->surface.facet_edges &&
         (c->surface.tangent_edges || psplat_used_part(c) < least_used)))
        return PSPLAT_OK;
    psplat_result result =
        psplat_blend_points_draw(c, POINTS_PER_SPLAT, c->desc->seed + fields_seed, &f.points);
    if (result) return result;
    if (begin(c, &f))
        fit_fields(c, &f);
    else
        result = PSPLAT_ERROR_MEMORY;
    psplat_blend_points_free(&f.points);
    free(f.fields);
    free(f.sums);
    return result;
}

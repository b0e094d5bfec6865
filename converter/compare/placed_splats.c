/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * placed_splats.c - the splats of an asset with the transforms of its nodes applied.
 *
 * An affine map M turns the scaled axes of an ellipse into conjugate diameters of its image. The
 * axes U' and V' of the image come from the singular value decomposition (r_u' U', r_v' V') R = M
 * (r_u U, r_v V). Parameters become (u', v') = R (u, v), and so do clip lines and gradients.
 *
 * A curved splat is a graph of heights along N over its plane. Its image is a graph of heights
 * along the image of N, whatever that makes with the image of the plane: over the plane
 * perpendicular to it, to which the images of both axes are projected. What these rise along it
 * adds to the slopes. So every affine image of a curved region is a curved region, exactly.
 */
#include "compare/placed_splats.h"

#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "measure/measured_splats.h"
#include "mesh/mesh.h"
#include "splats/splats.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The transform of a batch, relative to the origin. Matrices are stored by columns. */
typedef struct transform {
    double linear[3][3];
    double normal[3][3]; /* spec 4: |det M3|^(1/3) M3^-T */
    double offset[3];
    double scale; /* |det M3|^(1/3) */
    int is_translation;
} transform;

static void apply(const double columns[3][3], const double v[3], double result[3]) {
    double sum[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) mad3(sum, v[k], columns[k]);
    memcpy(result, sum, sizeof sum);
}

/* Returns 0 where the matrix is singular or not finite. */
static int transform_of(const double model[16], const double origin[3], transform *m) {
    double largest = 0, unit[3][3], cofactors[3][3], determinant;
    m->is_translation = 1;
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k) {
            m->linear[c][k] = model[4 * c + k];
            m->is_translation &= m->linear[c][k] == (c == k);
            largest = max2(largest, fabs(m->linear[c][k]));
        }
    sub3(m->offset, model + 12, origin);
    if (!(largest > 0) || !isfinite(largest)) return 0;
    /* The matrix is scaled first, since the product of three tiny scales would underflow. */
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k) unit[c][k] = m->linear[c][k] / largest;
    for (int c = 0; c < 3; ++c) cross3(cofactors[c], unit[(c + 1) % 3], unit[(c + 2) % 3]);
    determinant = dot3(unit[0], cofactors[0]);
    if (determinant == 0) return 0;
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k)
            m->normal[c][k] = cbrt(fabs(determinant)) * cofactors[c][k] / determinant;
    m->scale = largest * cbrt(fabs(determinant));
    return 1;
}

/* Finds the orthogonal axes and radii of the ellipse with conjugate diameters a and b, and the rows
 * of R. region->n must be set. */
static void find_axes(const double a[3], const double b[3], psplat_region *region, double r[2][2]) {
    double aa = dot3(a, a), bb = dot3(b, b), angle = 0.5 * atan2(2 * dot3(a, b), aa - bb);
    double axis[3] = {0, 0, 0};
    mad3(axis, cos(angle), a); /* the longest image of a unit vector */
    mad3(axis, sin(angle), b);
    normalize3(axis);
    memcpy(region->u, axis, sizeof axis);
    cross3(region->v, region->n, region->u);
    const double *axes[2] = {region->u, region->v};
    for (int i = 0; i < 2; ++i) {
        double x = dot3(a, axes[i]), y = dot3(b, axes[i]);
        region->radius[i] = hypot(x, y);
        r[i][0] = x / region->radius[i], r[i][1] = y / region->radius[i];
    }
}

/* Applies R to coefficients of u and v. */
static void apply_rotation(const double r[2][2], double *u, double *v) {
    double x = *u, y = *v;
    *u = r[0][0] * x + r[0][1] * y;
    *v = r[1][0] * x + r[1][1] * y;
}

/* Returns the sum of r[i][a] * r[j][b] * form[a][b], the entry i, j of a quadratic form in new
 * parameters. */
static double turned_form(const double r[2][2], const double form[2][2], int i, int j) {
    double sum = 0;
    for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b) sum += r[i][a] * r[j][b] * form[a][b];
    return sum;
}

/* Finds the image of a curved region's frame and surface, given the images of its scaled axes, and
 * the rows of R. */
static void place_surface(const transform *m, double axes[2][3], psplat_region *region,
                          double r[2][2]) {
    const double *radius = region->radius, *h = region->hessian;
    apply(m->linear, region->n, region->n);
    double stretch = normalize3(region->n), rise[2], form[2][2];
    form[0][0] = stretch * h[0] * radius[0] * radius[0];
    form[0][1] = form[1][0] = stretch * h[1] * radius[0] * radius[1];
    form[1][1] = stretch * h[2] * radius[1] * radius[1];
    for (int i = 0; i < 2; ++i) {
        double along = dot3(axes[i], region->n);
        rise[i] = stretch * region->slope[i] * radius[i] + along;
        mad3(axes[i], -along, region->n);
    }
    find_axes(axes[0], axes[1], region, r);
    const double(*turn)[2] = (const double(*)[2])r, (*old)[2] = (const double(*)[2])form;
    apply_rotation(turn, &rise[0], &rise[1]);
    for (int i = 0; i < 2; ++i) region->slope[i] = rise[i] / radius[i];
    region->hessian[0] = turned_form(turn, old, 0, 0) / (radius[0] * radius[0]);
    region->hessian[1] = turned_form(turn, old, 0, 1) / (radius[0] * radius[1]);
    region->hessian[2] = turned_form(turn, old, 1, 1) / (radius[1] * radius[1]);
}

static void place(const transform *m, psplat_region *region, psplat_blend_field *field) {
    double axes[2][3], r[2][2];
    field->depth *= m->scale;
    if (!m->is_translation) {
        apply(m->linear, region->center, region->center);
        apply(m->linear, region->u, axes[0]);
        apply(m->linear, region->v, axes[1]);
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < 3; ++k) axes[i][k] *= region->radius[i];
        for (int i = 0; i < 3; ++i) apply(m->normal, field->normals[i], field->normals[i]);
        if (psplat_region_is_curved(region)) {
            place_surface(m, axes, region, r);
        } else {
            apply(m->normal, region->n, region->n);
            normalize3(region->n);
            find_axes(axes[0], axes[1], region, r);
        }
        for (uint32_t i = 0; i < region->line_count + region->seam_count; ++i)
            apply_rotation((const double(*)[2])r, &region->lines[i][0], &region->lines[i][1]);
        for (int k = 0; k < 3; ++k)
            apply_rotation((const double(*)[2])r, &field->normals[1][k], &field->normals[2][k]);
    }
    mad3(region->center, 1, m->offset);
}

static int is_valid(const psplat_region *region) {
    double sum = region->radius[0] + region->radius[1];
    for (int k = 0; k < 3; ++k) sum += fabs(region->center[k]);
    return isfinite(sum) && region->radius[0] > 0 && region->radius[1] > 0;
}

/* Appends the splats of a batch. A splat whose radius underflows to 0 draws nothing and is left
 * out. */
static psplat_result place_batch(const psplat_batch *batch, const double origin[3],
                                 psplat_placed_splats *placed) {
    transform m;
    psplat_run run = {.count = batch->splat_count,
                      .clip_lines = batch->clip_count,
                      .seam_lines = batch->seam_lines};
    psplat_splats stored = {.splats = (psplat_splat *)batch->splats,
                            .count = batch->splat_count,
                            .runs = &run,
                            .run_count = 1};
    psplat_region *regions;
    if (!transform_of(batch->model, origin, &m)) return PSPLAT_OK;
    regions = psplat_splat_regions(&stored);
    if (!regions) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < stored.count; ++i) {
        psplat_blend_field field = {.kernel = batch->kernel,
                                    .depth = (double)batch->depth_tolerance};
        psplat_blend_field_of(&stored.splats[i], &regions[i], &field);
        place(&m, &regions[i], &field);
        if (!is_valid(&regions[i])) continue;
        placed->depth = max2(placed->depth, field.depth);
        placed->splats.regions[placed->splats.count] = regions[i];
        placed->splats.fields[placed->splats.count++] = field;
    }
    free(regions);
    return PSPLAT_OK;
}

static psplat_result allocate(const psplat_asset *const *assets, size_t asset_count,
                              psplat_placed_splats *placed, psplat_error *error) {
    size_t count = 0;
    for (size_t a = 0; a < asset_count; ++a)
        for (size_t i = 0; i < psplat_asset_batch_count(assets[a]); ++i)
            count += psplat_asset_batch(assets[a], i)->splat_count;
    if (count >= PSPLAT_NONE)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "%zu splats are too many", count);
    placed->splats.regions = malloc((count + 1) * sizeof *placed->splats.regions);
    placed->splats.fields = malloc((count + 1) * sizeof *placed->splats.fields);
    if (placed->splats.regions && placed->splats.fields) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu splats", count);
}

psplat_result psplat_placed_splats_create(const psplat_asset *asset, const double origin[3],
                                          psplat_placed_splats *placed, psplat_error *error) {
    return psplat_placed_splats_create_all(&asset, 1, origin, placed, error);
}

psplat_result psplat_placed_splats_create_all(const psplat_asset *const *assets, size_t count,
                                              const double origin[3], psplat_placed_splats *placed,
                                              psplat_error *error) {
    *placed = (psplat_placed_splats){0};
    psplat_result result = allocate(assets, count, placed, error);
    for (size_t a = 0; a < count; ++a)
        for (size_t i = 0; !result && i < psplat_asset_batch_count(assets[a]); ++i)
            result = place_batch(psplat_asset_batch(assets[a], i), origin, placed);
    if (!result) {
        placed->region_tree =
            psplat_region_tree_create(placed->splats.regions, placed->splats.count, 0);
        if (!placed->region_tree) result = PSPLAT_ERROR_MEMORY;
    }
    if (!result) return PSPLAT_OK;
    psplat_placed_splats_free(placed);
    return result == PSPLAT_ERROR_MEMORY ? psplat_fail(error, result, 0, "no memory for the splats")
                                         : result;
}

psplat_result psplat_placed_splats_reach(psplat_placed_splats *placed, double reach) {
    psplat_measured_splats *splats = &placed->splats;
    psplat_region_tree_destroy(splats->region_tree);
    splats->tolerance = reach;
    splats->region_tree = psplat_region_tree_create(splats->regions, splats->count, reach);
    return splats->region_tree ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

void psplat_placed_splats_free(psplat_placed_splats *placed) {
    psplat_region_tree_destroy(placed->region_tree);
    psplat_measured_splats_free(&placed->splats);
    *placed = (psplat_placed_splats){0};
}

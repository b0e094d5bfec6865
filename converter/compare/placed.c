/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * placed.c - the splats of an asset where its nodes place them.
 *
 * An affine map M makes the two scaled axes conjugate diameters of the ellipse's image. With
 * (r_u' U', r_v' V') R = M (r_u U, r_v V), a singular value decomposition, U' and V' are its axes
 * and parameters become (u', v') = R (u, v): lines and gradients turn with them.
 */
#include "placed.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* A batch's transform, relative to the origin. Matrices by columns. */
typedef struct motion {
    double linear[3][3];
    double normal[3][3]; /* spec 4: |det M3|^(1/3) M3^-T */
    double offset[3];
    double scale; /* |det M3|^(1/3) */
    int moves_only;
} motion;

static void apply(const double columns[3][3], const double v[3], double result[3]) {
    double sum[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) mad3(sum, v[k], columns[k]);
    memcpy(result, sum, sizeof sum);
}

/* 0: singular, or beyond what a number holds. */
static int motion_of(const double model[16], const double origin[3], motion *m) {
    double largest = 0, unit[3][3], cofactors[3][3], determinant;
    m->moves_only = 1;
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k) {
            m->linear[c][k] = model[4 * c + k];
            m->moves_only &= m->linear[c][k] == (c == k);
            largest = max2(largest, fabs(m->linear[c][k]));
        }
    sub3(m->offset, model + 12, origin);
    if (!(largest > 0) || !isfinite(largest)) return 0;
    /* Products of three tiny scales would vanish. */
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

/* Orthogonal axes of the ellipse with conjugate diameters a and b, and the rows of R. The frame's n
 * is there already. */
static void find_axes(const double a[3], const double b[3], psplat_region *region, double r[2][2]) {
    double aa = dot3(a, a), bb = dot3(b, b), angle = 0.5 * atan2(2 * dot3(a, b), aa - bb);
    double axis[3] = {0, 0, 0};
    mad3(axis, cos(angle), a); /* the image of a unit vector that becomes longest */
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

/* Turns what is linear in (u, v) by R. */
static void turn(const double r[2][2], double *u, double *v) {
    double x = *u, y = *v;
    *u = r[0][0] * x + r[0][1] * y;
    *v = r[1][0] * x + r[1][1] * y;
}

static void place(const motion *m, psplat_region *region, psplat_field *field) {
    double axes[2][3], r[2][2];
    field->depth *= m->scale;
    if (!m->moves_only) {
        apply(m->linear, region->center, region->center);
        apply(m->linear, region->u, axes[0]);
        apply(m->linear, region->v, axes[1]);
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < 3; ++k) axes[i][k] *= region->radius[i];
        apply(m->normal, region->n, region->n);
        normalize3(region->n);
        for (int i = 0; i < 3; ++i) apply(m->normal, field->normals[i], field->normals[i]);
        find_axes(axes[0], axes[1], region, r);
        for (uint32_t i = 0; i < region->line_count; ++i)
            turn((const double(*)[2])r, &region->lines[i][0], &region->lines[i][1]);
        for (int k = 0; k < 3; ++k)
            turn((const double(*)[2])r, &field->normals[1][k], &field->normals[2][k]);
    }
    mad3(region->center, 1, m->offset);
}

static int is_sound(const psplat_region *region) {
    double sum = region->radius[0] + region->radius[1];
    for (int k = 0; k < 3; ++k) sum += fabs(region->center[k]);
    return isfinite(sum) && region->radius[0] > 0 && region->radius[1] > 0;
}

/* Appends a batch. A splat too thin for a number to hold draws nothing either. */
static psplat_result place_batch(const psplat_batch *batch, const double origin[3],
                                 psplat_placed *placed) {
    motion m;
    psplat_splats stored = {.splats = (psplat_splat *)batch->splats, .count = batch->splat_count};
    psplat_region *regions;
    if (!motion_of(batch->model, origin, &m)) return PSPLAT_OK;
    regions = psplat_splat_regions(&stored);
    if (!regions) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < stored.count; ++i) {
        psplat_field field = {.kernel = batch->kernel, .depth = (double)batch->depth_tolerance};
        psplat_field_of(&stored.splats[i], &regions[i], &field);
        place(&m, &regions[i], &field);
        if (!is_sound(&regions[i])) continue;
        placed->depth = max2(placed->depth, field.depth);
        placed->splats.regions[placed->splats.count] = regions[i];
        placed->splats.fields[placed->splats.count++] = field;
    }
    free(regions);
    return PSPLAT_OK;
}

static psplat_result allocate(const psplat_asset *asset, psplat_placed *placed,
                              psplat_error *error) {
    size_t count = 0;
    for (size_t i = 0; i < psplat_asset_batch_count(asset); ++i)
        count += psplat_asset_batch(asset, i)->splat_count;
    if (count >= PSPLAT_NONE)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "%zu splats are too many", count);
    placed->splats.regions = malloc((count + 1) * sizeof *placed->splats.regions);
    placed->splats.fields = malloc((count + 1) * sizeof *placed->splats.fields);
    if (placed->splats.regions && placed->splats.fields) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu splats", count);
}

psplat_result psplat_placed_create(const psplat_asset *asset, const double origin[3],
                                   psplat_placed *placed, psplat_error *error) {
    *placed = (psplat_placed){0};
    psplat_result result = allocate(asset, placed, error);
    for (size_t i = 0; !result && i < psplat_asset_batch_count(asset); ++i)
        result = place_batch(psplat_asset_batch(asset, i), origin, placed);
    if (!result) {
        placed->locator = psplat_locator_create(placed->splats.regions, placed->splats.count, 0);
        if (!placed->locator) result = PSPLAT_ERROR_MEMORY;
    }
    if (!result) return PSPLAT_OK;
    psplat_placed_free(placed);
    return result == PSPLAT_ERROR_MEMORY ? psplat_fail(error, result, 0, "no memory for the splats")
                                         : result;
}

psplat_result psplat_placed_reach(psplat_placed *placed, double reach) {
    psplat_measured *splats = &placed->splats;
    psplat_locator_destroy(splats->locator);
    splats->tolerance = reach;
    splats->locator = psplat_locator_create(splats->regions, splats->count, reach);
    return splats->locator ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

void psplat_placed_free(psplat_placed *placed) {
    psplat_locator_destroy(placed->locator);
    psplat_measured_free(&placed->splats);
    *placed = (psplat_placed){0};
}

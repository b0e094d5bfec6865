/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * khr_gaussians.c - splats as Gaussians of KHR_gaussian_splatting.
 *
 * That extension has no clip lines, no normals and no light. So a Gaussian gets the second moments
 * of what clip lines leave of its splat, and a colour with the light baked into it. Those of flat
 * splats are flat; those of curved ones are tilted as their surface is and as thick as that bends.
 */
#include "export/khr_gaussians.h"

#include "base/eigen.h"
#include "base/region.h"
#include "base/vector.h"
#include "material/mipmap.h"
#include "splats/splat_frame.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The sides of the polygon that stands for an ellipse, and the least thickness of a Gaussian, in
 * its second standard deviations. */
enum { SIDES = 64 };
static const double least_thickness = 0.01;

/* ---- shape ----------------------------------------------------------------------------------- */

/* Stores the means of u u, u v and v v over a polygon, by Green's theorem. Returns 0 where the
 * polygon has no area. */
static int polygon_moments(double (*p)[2], size_t count, double moments[3]) {
    double area = 0, sums[3] = {0, 0, 0};
    for (size_t i = 0; i < count; ++i) {
        const double *a = p[i], *b = p[(i + 1) % count];
        double cross = a[0] * b[1] - b[0] * a[1];
        area += cross / 2;
        sums[0] += cross * (a[0] * a[0] + a[0] * b[0] + b[0] * b[0]) / 12;
        sums[1] += cross * (a[0] * b[1] + 2 * a[0] * a[1] + 2 * b[0] * b[1] + b[0] * a[1]) / 24;
        sums[2] += cross * (a[1] * a[1] + a[1] * b[1] + b[1] * b[1]) / 12;
    }
    for (int k = 0; k < 3; ++k) moments[k] = sums[k] / area;
    return area > 0;
}

/* Stores the second moments of a region about its centre, squared lengths along u and v. A region
 * of which clip lines leave nothing gets those of its ellipse. */
static void region_moments(const psplat_region *region, double moments[3]) {
    double polygon[SIDES + PSPLAT_MAX_CLIP_LINES][2], a = region->radius[0], b = region->radius[1];
    size_t count = region->line_count
                       ? psplat_region_polygon(region, 1, polygon, sizeof polygon / sizeof *polygon)
                       : 0;
    if (count < 3 || !polygon_moments(polygon, count, moments)) {
        moments[0] = moments[2] = 0.25;
        moments[1] = 0;
    }
    moments[0] *= a * a;
    moments[1] *= a * b;
    moments[2] *= b * b;
}

/* Turns a rotation about its own z axis by an angle, radians. */
static void turn(const float q[4], double angle, float out[4]) {
    double s = sin(angle / 2), c = cos(angle / 2);
    double x = (double)q[0], y = (double)q[1], z = (double)q[2], w = (double)q[3];
    const double product[4] = {x * c + y * s, y * c - x * s, z * c + w * s, w * c - z * s};
    for (int k = 0; k < 4; ++k) out[k] = (float)product[k];
}

/* Adds a triangle's second moments of s, t and height about the centre, in the order of
 * psplat_eigen, times its signed area in (u, v), by Dunavant's (1985) rule of six points, which is
 * exact to the fourth degree. Returns that area. */
static double add_triangle(const psplat_region *region, const double a[2], const double b[2],
                           const double c[2], double sums[6]) {
    static const double weights[2] = {0.223381589678011, 0.109951743655322};
    static const double places[2] = {0.445948490915965, 0.091576213509771};
    double area = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
    for (int i = 0; i < 6; ++i) {
        double at[3], p[3], uv[2];
        for (int k = 0; k < 3; ++k) at[k] = k == i % 3 ? 1 - 2 * places[i / 3] : places[i / 3];
        for (int k = 0; k < 2; ++k) uv[k] = at[0] * a[k] + at[1] * b[k] + at[2] * c[k];
        p[0] = uv[0] * region->radius[0], p[1] = uv[1] * region->radius[1];
        p[2] = psplat_region_height(region, uv);
        for (int k = 0, entry = 0; k < 3; ++k)
            for (int l = k; l < 3; ++l) sums[entry++] += weights[i / 3] * area * p[k] * p[l];
    }
    return area;
}

/* Stores the second moments of a curved region's surface about its centre, in the order of
 * psplat_eigen. A region of which clip lines leave nothing gets those of its whole. */
static void surface_moments(const psplat_region *region, double moments[6]) {
    double polygon[SIDES + PSPLAT_MAX_CLIP_LINES][2], area = 0;
    psplat_region whole = *region;
    size_t count = psplat_region_polygon(region, 1, polygon, sizeof polygon / sizeof *polygon);
    whole.line_count = 0;
    if (count < 3)
        count = psplat_region_polygon(&whole, 1, polygon, sizeof polygon / sizeof *polygon);
    memset(moments, 0, 6 * sizeof *moments);
    for (size_t i = 2; i < count; ++i)
        area += add_triangle(region, polygon[0], polygon[i - 1], polygon[i], moments);
    for (int k = 0; k < 6 && area > 0; ++k) moments[k] /= area;
}

/* Aligns the Gaussian of a curved splat with the principal axes of its surface. */
static void set_curved_shape(const psplat_region *region, psplat_gaussian *g) {
    double moments[6], values[3], local[3][3], axes[3][3] = {{0}};
    surface_moments(region, moments);
    psplat_eigen(moments, values, local);
    /* The two longest first. The third follows from them, and has the side of the normal. */
    double side = local[2][0] * local[1][1] < local[2][1] * local[1][0] ? -1 : 1;
    for (int i = 0; i < 2; ++i) {
        double sign = i ? side : 1;
        mad3(axes[i], sign * local[2 - i][0], region->u);
        mad3(axes[i], sign * local[2 - i][1], region->v);
        mad3(axes[i], sign * local[2 - i][2], region->n);
    }
    cross3(axes[2], axes[0], axes[1]);
    psplat_quaternion_of_axes(axes[0], axes[1], axes[2], g->rotation);
    for (int i = 0; i < 3; ++i)
        g->scale[i] = (float)(PSPLAT_GAUSSIAN_WIDTH * sqrt(max2(values[2 - i], 0)));
    g->scale[2] = fmaxf(g->scale[2], (float)least_thickness * g->scale[1]);
}

/* Aligns the Gaussian with the principal axes of the moments. */
static void set_shape(const psplat_splat *splat, psplat_gaussian *g) {
    psplat_region region;
    double m[3];
    psplat_splat_region(splat, &region);
    if (psplat_region_is_curved(&region)) {
        set_curved_shape(&region, g);
        return;
    }
    region_moments(&region, m);
    double mean = (m[0] + m[2]) / 2, half = (m[0] - m[2]) / 2;
    double spread = sqrt(half * half + m[1] * m[1]);
    turn(splat->rotation, atan2(m[1], half) / 2, g->rotation);
    g->scale[0] = (float)(PSPLAT_GAUSSIAN_WIDTH * sqrt(mean + spread));
    g->scale[1] = (float)(PSPLAT_GAUSSIAN_WIDTH * sqrt(fmax(mean - spread, 0)));
    g->scale[2] = (float)least_thickness * g->scale[1];
}

/* ---- colour ---------------------------------------------------------------------------------- */

/* Returns the light that reaches a splat: Lambert's law for a directional light, and ambient light,
 * chosen by hand so that shapes stay readable. */
static double light(const psplat_splat *splat) {
    static const double to_light[3] = {0.302, 0.804, 0.512}, ambient = 0.35;
    double cosine = 0;
    for (int k = 0; k < 3; ++k) cosine += to_light[k] * (double)splat->normal[k];
    return ambient + (1 - ambient) * fmax(cosine, 0);
}

static void set_color(const psplat_splat *splat, const psplat_finish *finish,
                      const psplat_material *material, psplat_gaussian *g) {
    static const double degree_0 = 0.28209479177387814; /* 1 / (2 sqrt(pi)) */
    double lit = material->unlit ? 1 : light(splat) * (finish ? (double)finish->occlusion : 1);
    for (int k = 0; k < 3; ++k) {
        double emissive = finish ? (double)finish->emissive[k] : 1;
        double linear = lit * (double)material->base_color[k] * (double)splat->color[k];
        if (!material->unlit) linear += emissive * (double)material->emissive[k];
        double shown = (double)psplat_srgb_of_linear((float)fmin(linear, 1));
        g->harmonic[k] = (float)((shown - 0.5) / degree_0);
    }
}

psplat_result psplat_gaussians_make(const psplat_splats *splats, psplat_gaussian **gaussians,
                                    psplat_error *error) {
    psplat_gaussian *made = malloc((splats->count + 1) * sizeof *made);
    *gaussians = made;
    if (!made)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu Gaussians",
                           splats->count);
    size_t i = 0;
    for (size_t r = 0; r < splats->run_count; ++r)
        for (size_t end = i + splats->runs[r].count; i < end; ++i) {
            set_shape(&splats->splats[i], &made[i]);
            set_color(&splats->splats[i], splats->finishes ? &splats->finishes[i] : NULL,
                      &splats->materials[splats->runs[r].material], &made[i]);
        }
    return PSPLAT_OK;
}

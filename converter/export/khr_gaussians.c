/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * khr_gaussians.c - splats as flat Gaussians of KHR_gaussian_splatting.
 *
 * That extension has no clip lines, no normals and no light. So a Gaussian gets the second moments
 * of the area that clip lines leave of its splat, and a colour with the light baked into it.
 */
#include "export/khr_gaussians.h"

#include "base/region.h"
#include "material/mipmap.h"
#include "splats/splat_frame.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>

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
    enum { SIDES = 64 };
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

/* Aligns the Gaussian with the principal axes of the moments. Its thickness is a hundredth of the
 * smaller standard deviation. */
static void set_shape(const psplat_splat *splat, psplat_gaussian *g) {
    psplat_region region;
    double m[3];
    psplat_splat_region(splat, &region);
    region_moments(&region, m);
    double mean = (m[0] + m[2]) / 2, half = (m[0] - m[2]) / 2;
    double spread = sqrt(half * half + m[1] * m[1]);
    turn(splat->rotation, atan2(m[1], half) / 2, g->rotation);
    g->scale[0] = (float)(PSPLAT_GAUSSIAN_WIDTH * sqrt(mean + spread));
    g->scale[1] = (float)(PSPLAT_GAUSSIAN_WIDTH * sqrt(fmax(mean - spread, 0)));
    g->scale[2] = 0.01f * g->scale[1];
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

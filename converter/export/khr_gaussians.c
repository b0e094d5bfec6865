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
#include "material/source_materials.h"
#include "material/texture_sampling.h"
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
    psplat_splat_region(splat, 0, &region); /* Its colour ends at seams, too. */
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

/* ---- textures -------------------------------------------------------------------------------- */

/* The means of a material's textures over a splat, in linear light. */
typedef struct texture_means {
    float base_color[4], emissive[4];
    double occlusion;
} texture_means;

static const texture_means white = {{1, 1, 1, 1}, {1, 1, 1, 1}, 1};

/* The mipmaps of the images, those of colours and those of numbers; each has no levels until a
 * material needs it. */
typedef struct mipmaps {
    psplat_mipmap *of[2];
    size_t count;
} mipmaps;

static int is_color_slot(int slot) {
    return slot == PSPLAT_TEXTURE_BASE_COLOR || slot == PSPLAT_TEXTURE_EMISSIVE;
}

/* Builds what the textures need that colours are made of. Returns 0 where memory ran out. */
static int build_mipmaps(const psplat_splats *splats, const psplat_source_materials *sources,
                         mipmaps *m) {
    static const int slots[] = {PSPLAT_TEXTURE_BASE_COLOR, PSPLAT_TEXTURE_OCCLUSION,
                                PSPLAT_TEXTURE_EMISSIVE};
    if (!splats->texcoords || !sources) return 1;
    m->count = sources->image_count;
    for (int k = 0; k < 2; ++k) {
        m->of[k] = calloc(m->count + 1, sizeof *m->of[k]);
        if (!m->of[k]) return 0;
    }
    for (size_t i = 0; i < 3 * splats->material_count; ++i) {
        int slot = slots[i % 3], is_color = is_color_slot(slot);
        uint32_t image = splats->materials[i / 3].textures[slot].image;
        if (!image || image > m->count || m->of[is_color][image - 1].level_count) continue;
        if (psplat_mipmap_build(&sources->images[image - 1], is_color, &m->of[is_color][image - 1]))
            return 0;
    }
    return 1;
}

static void free_mipmaps(mipmaps *m) {
    for (int k = 0; k < 2; ++k) {
        for (size_t i = 0; i < m->count && m->of[k]; ++i) psplat_mipmap_free(&m->of[k][i]);
        free(m->of[k]);
    }
}

/* Stores the mean of a texture over a splat, where the material has one that can be read. */
static int average(const mipmaps *m, const psplat_material *material, int slot,
                   const psplat_texcoord *t, float rgba[4]) {
    const psplat_texture *texture = &material->textures[slot];
    const float *from[3] = {t->at, t->along_u, t->along_v};
    psplat_texture_info info = {.wrap = {texture->wrap[0], texture->wrap[1]},
                                .nearest = texture->nearest};
    double st[3][2], zero[2] = {0, 0}, origin[2];
    if (!texture->image || texture->image > m->count) return 0;
    const psplat_mipmap *mipmap = &m->of[is_color_slot(slot)][texture->image - 1];
    if (!mipmap->level_count) return 0;
    for (int k = 0; k < 6; ++k) info.transform[k] = (double)texture->transform[k];
    psplat_texture_transform(&info, zero, origin);
    for (int i = 0; i < 3; ++i) {
        const double uv[2] = {(double)from[i][0], (double)from[i][1]};
        psplat_texture_transform(&info, uv, st[i]);
        for (int k = 0; k < 2 && i; ++k) st[i][k] -= origin[k]; /* an axis, not a point */
    }
    psplat_texture_average(&info, mipmap, st[0], (const double(*)[2])st + 1, rgba);
    return 1;
}

static texture_means means_of(const mipmaps *m, const psplat_material *material,
                              const psplat_texcoord *t) {
    texture_means means = white;
    float rgba[4];
    average(m, material, PSPLAT_TEXTURE_BASE_COLOR, t, means.base_color);
    average(m, material, PSPLAT_TEXTURE_EMISSIVE, t, means.emissive);
    if (average(m, material, PSPLAT_TEXTURE_OCCLUSION, t, rgba))
        means.occlusion = 1 + (double)material->textures[PSPLAT_TEXTURE_OCCLUSION].strength *
                                  ((double)rgba[0] - 1);
    return means;
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
                      const psplat_material *material, const texture_means *means,
                      psplat_gaussian *g) {
    static const double degree_0 = 0.28209479177387814; /* 1 / (2 sqrt(pi)) */
    double occlusion = (finish ? (double)finish->occlusion : 1) * means->occlusion;
    double lit = material->unlit ? 1 : light(splat) * occlusion;
    for (int k = 0; k < 3; ++k) {
        double emissive = (finish ? (double)finish->emissive[k] : 1) * (double)means->emissive[k];
        double linear = lit * (double)material->base_color[k] * (double)splat->color[k] *
                        (double)means->base_color[k];
        if (!material->unlit) linear += emissive * (double)material->emissive[k];
        double shown = (double)psplat_srgb_of_linear((float)fmin(linear, 1));
        g->harmonic[k] = (float)((shown - 0.5) / degree_0);
    }
}

/* ---- all splats ------------------------------------------------------------------------------ */

static void make_all(const psplat_splats *splats, const mipmaps *m, psplat_gaussian *made) {
    size_t i = 0;
    for (size_t r = 0; r < splats->run_count; ++r)
        for (size_t end = i + splats->runs[r].count; i < end; ++i) {
            const psplat_run *run = &splats->runs[r];
            const psplat_material *material = &splats->materials[run->material];
            texture_means means = white;
            if (run->has_texcoord) means = means_of(m, material, &splats->texcoords[i]);
            set_shape(&splats->splats[i], &made[i]);
            set_color(&splats->splats[i], splats->finishes ? &splats->finishes[i] : NULL, material,
                      &means, &made[i]);
        }
}

psplat_result psplat_gaussians_make(const psplat_splats *splats,
                                    const psplat_source_materials *sources,
                                    psplat_gaussian **gaussians, psplat_error *error) {
    psplat_gaussian *made = malloc((splats->count + 1) * sizeof *made);
    mipmaps m = {0};
    int is_made = made && build_mipmaps(splats, sources, &m);
    if (is_made) make_all(splats, &m, made);
    free_mipmaps(&m);
    *gaussians = is_made ? made : NULL;
    if (is_made) return PSPLAT_OK;
    free(made);
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu Gaussians", splats->count);
}

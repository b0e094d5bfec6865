/* SPDX-License-Identifier: MIT
 *
 * prefilter.c - prefilters environment maps by importance sampling. Half vectors are drawn with the
 * density D(h) (n.h) at the points of a Hammersley sequence, and each sample reads the mipmap level
 * whose texels are about as large as the solid angle that the sample stands for (Karis 2013;
 * Krivanek and Colbert 2008).
 */
#include "renderer/prefilter.h"
#include "core/matrix.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>

/* Samples of each integral, and the greatest size in texels of the level that irradiance is summed
 * over. All are chosen by hand. */
enum { GLOSSY_SAMPLES = 96, SPLIT_SUM_SAMPLES = 512, IRRADIANCE_SIZE = 16 };

static const double pi = 3.14159265358979324;

/* ---- cubes ------------------------------------------------------------------------------- */

/* Each face has three rows: the directions in which s and t grow, and the outward direction (GL
 * 4.6, table 8.19). */
static const signed char faces[6][3][3] = {
    {{0, 0, -1}, {0, -1, 0}, {1, 0, 0}}, {{0, 0, 1}, {0, -1, 0}, {-1, 0, 0}},
    {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},   {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
    {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}},  {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}};

void psplat_cube_direction(int face, double x, double y, double direction[3]) {
    double s = 2.0 * x - 1.0, t = 2.0 * y - 1.0, length = sqrt(s * s + t * t + 1.0);
    for (int i = 0; i < 3; ++i)
        direction[i] = (s * faces[face][0][i] + t * faces[face][1][i] + faces[face][2][i]) / length;
}

/* Returns the face that a direction meets, and the point (x, y), 0 ... 1 each, where it does. */
static int face_of(const double d[3], double *x, double *y) {
    int axis = fabs(d[1]) > fabs(d[0]) ? 1 : 0;
    if (fabs(d[2]) > fabs(d[axis])) axis = 2;
    int face = 2 * axis + (d[axis] < 0.0);
    double s = 0.0, t = 0.0, scale = 0.5 / fabs(d[axis]);
    for (int i = 0; i < 3; ++i) {
        s += d[i] * faces[face][0][i];
        t += d[i] * faces[face][1][i];
    }
    *x = s * scale + 0.5;
    *y = t * scale + 0.5;
    return face;
}

/* Returns the bytes of a level. */
static size_t level_size(const psplat_cube *cube, int level) {
    size_t edge = (size_t)(cube->size >> level);
    return 6 * edge * edge * 3 * sizeof(float);
}

/* Samples a level by bilinear interpolation within a face; beyond the centres of its outermost
 * texels their values are repeated. */
static void sample_level(const psplat_cube *cube, int level, const double direction[3],
                         double rgb[3]) {
    int size = cube->size >> level;
    double x, y;
    int face = face_of(direction, &x, &y);
    double u = fmin(fmax(x * size - 0.5, 0.0), size - 1.0);
    double v = fmin(fmax(y * size - 0.5, 0.0), size - 1.0);
    int x0 = (int)u, y0 = (int)v, x1 = x0 + (x0 + 1 < size), y1 = y0 + (y0 + 1 < size);
    const float *texels = cube->levels[level] + (size_t)face * (size_t)size * (size_t)size * 3;
    const float *row0 = texels + (size_t)y0 * (size_t)size * 3;
    const float *row1 = texels + (size_t)y1 * (size_t)size * 3;
    u -= x0;
    v -= y0;
    for (int i = 0; i < 3; ++i) {
        double top = (double)row0[3 * x0 + i] * (1.0 - u) + (double)row0[3 * x1 + i] * u;
        double bottom = (double)row1[3 * x0 + i] * (1.0 - u) + (double)row1[3 * x1 + i] * u;
        rgb[i] = top * (1.0 - v) + bottom * v;
    }
}

/* Samples between two levels by linear interpolation. */
static void sample(const psplat_cube *cube, double level, const double direction[3],
                   double rgb[3]) {
    level = fmin(fmax(level, 0.0), cube->level_count - 1.0);
    int low = (int)level, high = low + (low + 1 < cube->level_count);
    double a[3], b[3];
    sample_level(cube, low, direction, a);
    sample_level(cube, high, direction, b);
    for (int i = 0; i < 3; ++i) rgb[i] = a[i] + (b[i] - a[i]) * (level - low);
}

/* Radiance is limited to this, so that no sum leaves the range of float. The limit does not show:
 * even if only one texel of the largest cube map has it, means are far above the largest half
 * float, which is all that the textures can store. */
static const float max_radiance = 1e30f;

/* Fills level 0 with the nearest texels where radiance has another size, which then is larger. */
static void fill_base(const psplat_cube *cube, const float *radiance, int size) {
    float *out = cube->levels[0];
    for (int face = 0; face < 6; ++face)
        for (int y = 0; y < cube->size; ++y)
            for (int x = 0; x < cube->size; ++x, out += 3) {
                int from_x = (2 * x + 1) * size / (2 * cube->size);
                int from_y = (2 * y + 1) * size / (2 * cube->size);
                size_t at =
                    ((size_t)face * (size_t)size + (size_t)from_y) * (size_t)size + (size_t)from_x;
                const float *texel = radiance + 3 * at;
                for (int i = 0; i < 3; ++i) out[i] = fminf(texel[i], max_radiance);
            }
}

/* Fills a level with the means of 2 x 2 texels of the level before it. */
static void halve(const psplat_cube *cube, int level) {
    size_t size = (size_t)(cube->size >> level), row = 2 * size * 3;
    const float *in = cube->levels[level - 1];
    float *out = cube->levels[level];
    for (size_t y = 0; y < 6 * size; ++y, in += row)
        for (size_t x = 0; x < size; ++x, in += 6)
            for (int i = 0; i < 3; ++i)
                *out++ =
                    0.25f * (in[i] + in[i + 3] + in[row + (size_t)i] + in[row + (size_t)i + 3]);
}

psplat_result psplat_cube_create(psplat_cube *cube, const psplat_allocator *allocator,
                                 const float *radiance, int size, psplat_error *error) {
    memset(cube, 0, sizeof *cube);
    cube->size = 1;
    while (2 * cube->size <= size) cube->size *= 2;
    for (int level = 0; cube->size >> level; ++level) {
        cube->levels[level] = psplat_resize(allocator, NULL, 0, level_size(cube, level));
        if (!cube->levels[level]) {
            psplat_cube_free(cube, allocator);
            return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a cube map of %d",
                               size);
        }
        cube->level_count = level + 1;
        if (level == 0)
            fill_base(cube, radiance, size);
        else
            halve(cube, level);
    }
    return PSPLAT_OK;
}

void psplat_cube_free(psplat_cube *cube, const psplat_allocator *allocator) {
    for (int level = 0; level < cube->level_count; ++level)
        psplat_resize(allocator, cube->levels[level], level_size(cube, level), 0);
    memset(cube, 0, sizeof *cube);
}

/* ---- integrals --------------------------------------------------------------------------- */

/* Sums over all texels of a small level, over each of which the cosine changes little. */
void psplat_cube_irradiance(const psplat_cube *cube, const double normal[3], float rgb[3]) {
    int level = 0;
    while (cube->size >> level > IRRADIANCE_SIZE) ++level;
    int size = cube->size >> level;
    const float *texel = cube->levels[level];
    double sum[3] = {0.0, 0.0, 0.0}, step = 1.0 / size;
    for (int face = 0; face < 6; ++face)
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x, texel += 3) {
                double l[3], s = (2 * x + 1) * step - 1.0, t = (2 * y + 1) * step - 1.0;
                psplat_cube_direction(face, (x + 0.5) * step, (y + 0.5) * step, l);
                double weight = fmax(psplat_dot3(l, normal), 0.0) * pow(s * s + t * t + 1.0, -1.5);
                for (int i = 0; i < 3; ++i) sum[i] += weight * (double)texel[i];
            }
    for (int i = 0; i < 3; ++i) rgb[i] = (float)(sum[i] * 4.0 * step * step);
}

/* Returns the i-th number of the van der Corput sequence: the bits of i in reverse order behind the
 * binary point. */
static double radical_inverse(unsigned i) {
    double value = 0.0;
    for (double digit = 0.5; i; i >>= 1, digit *= 0.5)
        if (i & 1) value += digit;
    return value;
}

/* Finds a half vector around the z axis at an azimuth, such that a share x of all half vectors lies
 * closer to the axis. Returns its cosine. */
static double half_vector(double x, double angle, double alpha, double h[3]) {
    double cosine2 = (1.0 - x) / (1.0 + (alpha * alpha - 1.0) * x);
    double cosine = sqrt(cosine2), sine = sqrt(fmax(1.0 - cosine2, 0.0));
    h[0] = sine * cos(angle);
    h[1] = sine * sin(angle);
    h[2] = cosine;
    return cosine;
}

/* Returns D of eq. (7) for the cosine n.h. */
static double distribution(double cosine, double alpha) {
    double a2 = alpha * alpha, d = cosine * cosine * (a2 - 1.0) + 1.0;
    return a2 / (pi * d * d);
}

void psplat_cube_mirror(const psplat_cube *cube, const double direction[3], int size,
                        float rgb[3]) {
    double value[3];
    sample(cube, log2((double)cube->size / size), direction, value);
    for (int k = 0; k < 3; ++k) rgb[k] = (float)value[k];
}

void psplat_cube_glossy(const psplat_cube *cube, const double direction[3], double alpha,
                        float rgb[3]) {
    double x[3], y[3], sum[3] = {0.0, 0.0, 0.0}, weights = 0.0;
    double texel = 4.0 * pi / (6.0 * cube->size * cube->size);
    psplat_matrix_basis(direction, x, y);
    for (int i = 0; i < GLOSSY_SAMPLES; ++i) {
        double h[3], l[3], value[3];
        double angle = 2.0 * pi * radical_inverse((unsigned)i);
        double cosine = half_vector((i + 0.5) / GLOSSY_SAMPLES, angle, alpha, h);
        double facing = 2.0 * cosine * cosine - 1.0; /* r.l */
        if (!(facing > 0.0)) continue;
        for (int k = 0; k < 3; ++k)
            l[k] = 2.0 * cosine * (h[0] * x[k] + h[1] * y[k]) + facing * direction[k];
        /* The density of l is D / 4. */
        double solid_angle = 4.0 / (GLOSSY_SAMPLES * distribution(cosine, alpha));
        sample(cube, 0.5 * log2(solid_angle / texel), l, value);
        for (int k = 0; k < 3; ++k) sum[k] += facing * value[k];
        weights += facing;
    }
    for (int k = 0; k < 3; ++k) rgb[k] = weights > 0.0 ? (float)(sum[k] / weights) : 0.0f;
}

/* Averages f_specular (n.l) over the density D (n.h) / (4 e.h), so that D cancels. Few half vectors
 * are far from n, but at grazing angles they count most: with x = 1 - y^2 they are drawn more
 * often, with a weight of 2 y. Half a turn is enough, because the other half is its mirror image.
 */
void psplat_split_sum(double cosine, double alpha, float ab[2]) {
    const double e[3] = {sqrt(fmax(1.0 - cosine * cosine, 0.0)), 0.0, cosine};
    double a = 0.0, b = 0.0, a2 = alpha * alpha;
    for (int i = 0; i < SPLIT_SUM_SAMPLES; ++i) {
        double y = 1.0 - (i + 0.5) / SPLIT_SUM_SAMPLES, h[3];
        double nh = half_vector(1.0 - y * y, pi * radical_inverse((unsigned)i), alpha, h);
        double eh = psplat_dot3(e, h);
        double nl = 2.0 * eh * nh - cosine;
        if (!(nl > 0.0) || !(eh > 0.0)) continue;
        double smith = 0.5 / (nl * sqrt(cosine * cosine * (1.0 - a2) + a2) +
                              cosine * sqrt(nl * nl * (1.0 - a2) + a2));
        double weight = 2.0 * y * 4.0 * smith * nl * eh / nh, fresnel = pow(1.0 - eh, 5.0);
        a += weight * (1.0 - fresnel);
        b += weight * fresnel;
    }
    ab[0] = (float)(a / SPLIT_SUM_SAMPLES);
    ab[1] = (float)(b / SPLIT_SUM_SAMPLES);
}

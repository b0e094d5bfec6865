/* SPDX-License-Identifier: MIT
 *
 * test_reference_curved_brute.c - tests the reference rasteriser on thousands of random curved
 * splats and views: its bounds lose no pixel, and it finds the same points as another way, which
 * solves no quadratic equation for the surface. In the splat's own coordinates (u, v, w), with w
 * the height over the plane in units of r_u, the ray of pixel (X, Y) is where two linear equations
 * hold, those that say that the clip space point C + u A + v B + w H projects to (X, Y). Where it
 * is over the ellipse, its height above the surface has at most one extremum, which a search
 * brackets; a root on each side of it is found by bisection. Where neither is a fragment, the
 * height at the near end of the way over the ellipse tells whether the ray meets the wall under the
 * rim.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "random_fixture.h"

/* ---- a random splat in a random view ------------------------------------------------------- */

/* Makes the columns of the rotation by a quaternion of any length. */
static void axes_of(const float q[4], double axes[3][3]) {
    double x = q[0], y = q[1], z = q[2], w = q[3], norm = x * x + y * y + z * z + w * w;
    double columns[3][3] = {
        {w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - y * w)},
        {2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)},
        {2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z}};
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i) axes[k][i] = columns[k][i] / norm;
}

/* Slopes and curvatures fulfil (1b). Every third splat takes its shape from its normal field. */
static void random_shape(psplat_splat *splat, int is_field, uint32_t *random) {
    double axes[3][3], slope[2] = {0, 0}, length = 0, scale = magnitude(random, 0.01, 1.2);
    axes_of(splat->rotation, axes);
    for (int k = 0; k < 3; ++k) splat->shape[2 + k] = (float)(scale * between(random, -1.4, 1.4));
    if (scene_random(random) < 0.1f) splat->shape[3] = splat->shape[4] = 0; /* a cylinder */
    if (is_field)
        for (int k = 0; k < 2; ++k) slope[k] = between(random, -0.4, 0.4);
    for (int i = 0; i < 3; ++i) {
        double n = axes[2][i] + slope[0] * axes[0][i] + slope[1] * axes[1][i];
        splat->normal[i] = (float)n;
        length += n * n;
    }
    for (int i = 0; i < 3; ++i) splat->normal[i] /= (float)sqrt(length);
    if (!is_field) return;
    memcpy(splat->gradient, splat->shape + 2, sizeof splat->gradient);
    scene_curve_splat(splat);
}

static void random_splat(psplat_splat *splat, uint32_t *random) {
    double length = 0, quaternion[4];
    for (int i = 0; i < 3; ++i) splat->center[i] = (float)between(random, -3, 3);
    for (int i = 0; i < 4; ++i) {
        quaternion[i] = between(random, -1, 1);
        length += quaternion[i] * quaternion[i];
    }
    for (int i = 0; i < 4; ++i) splat->rotation[i] = (float)(quaternion[i] / sqrt(length));
    splat->radius[0] = (float)magnitude(random, 0.05, 20);
    splat->radius[1] = splat->radius[0] * (float)magnitude(random, 0.01, 1);
    random_shape(splat, scene_random(random) < 0.33f, random);
    random_lines(splat, 1, random);
}

/* ---- the other way --------------------------------------------------------------------------- */

/* Computes the clip space images of r_u U, r_v V, r_u N and of the centre. */
static void clip_frame(const psplat_splat *splat, const double transform[16],
                       const psplat_view *view, double frame[4][4]) {
    double axes[3][3];
    axes_of(splat->rotation, axes);
    for (int k = 0; k < 4; ++k) {
        double from[4] = {0, 0, 0, k == 3}, scene_point[4], eye_point[4];
        for (int i = 0; i < 3; ++i)
            from[i] = k < 3 ? axes[k][i] * (double)splat->radius[k % 2] : (double)splat->center[i];
        apply(transform, from, scene_point);
        apply(view->view, scene_point, eye_point);
        apply(view->projection, eye_point, frame[k]);
    }
}

/* The points origin + s direction, in (u, v, w), and the splat. */
typedef struct line {
    const psplat_splat *splat;
    double (*frame)[4];
    double origin[3], direction[3];
} line;

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Returns the clip space coordinate i of a point or, where w is 0, of a direction. */
static double clip_of(double frame[4][4], const double p[3], double w, int i) {
    return p[0] * frame[0][i] + p[1] * frame[1][i] + p[2] * frame[2][i] + w * frame[3][i];
}

/* Finds the ray of a point (x, y) in normalised device coordinates. Each of x and y says that the
 * points of a plane n.p = -d project to it. The ray is the planes' common line, so directed that
 * window depth grows along it. */
static void set_line(line *ray, double x, double y) {
    const double at[2] = {x, y};
    double n[2][3], d[2], part[3];
    for (int k = 0; k < 2; ++k) {
        for (int i = 0; i < 3; ++i) n[k][i] = ray->frame[i][k] - at[k] * ray->frame[i][3];
        d[k] = ray->frame[3][k] - at[k] * ray->frame[3][3];
    }
    cross(n[0], n[1], ray->direction);
    double square = dot(ray->direction, ray->direction);
    for (int k = 0; k < 3; ++k) ray->origin[k] = 0;
    for (int k = 0; k < 2; ++k) {
        cross(k ? ray->direction : n[1], k ? n[0] : ray->direction, part);
        for (int i = 0; i < 3; ++i) ray->origin[i] -= d[k] * part[i] / square;
    }
    double *o = ray->origin, *to = ray->direction, length = sqrt(square);
    double growth = clip_of(ray->frame, to, 0, 2) * clip_of(ray->frame, o, 1, 3) -
                    clip_of(ray->frame, o, 1, 2) * clip_of(ray->frame, to, 0, 3);
    for (int i = 0; i < 3; ++i) to[i] *= copysign(1 / length, growth);
}

static void point_at(const line *ray, double s, double p[3]) {
    for (int i = 0; i < 3; ++i) p[i] = ray->origin[i] + s * ray->direction[i];
}

/* Returns the height above the surface in units of r_u, by eq. (1a) divided by r_u. */
static double height_at(const line *ray, double s) {
    const float *shape = ray->splat->shape;
    double p[3], q = (double)ray->splat->radius[1] / (double)ray->splat->radius[0];
    point_at(ray, s, p);
    double u = p[0], v = p[1];
    return p[2] + (double)shape[0] * u + (double)shape[2] * u * u / 2 +
           (double)shape[4] * q * u * v + q * (double)shape[1] * v +
           q * (double)shape[3] * v * v / 2;
}

/* Finds where the line is over the ellipse, whose rim is at two distances on either side of the
 * line's point next to the axis. Returns 0 where it never is. */
static int over_ellipse(const line *ray, double *low, double *high) {
    const double *o = ray->origin, *d = ray->direction;
    double square = d[0] * d[0] + d[1] * d[1], across = o[0] * d[1] - o[1] * d[0];
    double middle = -(o[0] * d[0] + o[1] * d[1]) / square;
    double half = sqrt(1 - across * across / square) / sqrt(square);
    *low = middle - half;
    *high = middle + half;
    return isfinite(half);
}

/* Returns a place between low and high where the height is extreme, by golden sections. sign is 1
 * for the greatest height and -1 for the least. */
static double extremum(const line *ray, double low, double high, double sign) {
    const double golden = 0.6180339887498949;
    for (int i = 0; i < 100; ++i) {
        double a = high - golden * (high - low), b = low + golden * (high - low);
        if (sign * height_at(ray, a) < sign * height_at(ray, b))
            low = a;
        else
            high = b;
    }
    return (low + high) / 2;
}

/* Bisects. Returns NaN where the height does not change its sign. */
static double root_between(const line *ray, double low, double high) {
    int is_above = height_at(ray, low) > 0;
    if ((height_at(ray, high) > 0) == is_above) return NAN;
    for (int i = 0; i < 100; ++i) {
        double middle = (low + high) / 2;
        if ((height_at(ray, middle) > 0) == is_above)
            low = middle;
        else
            high = middle;
    }
    return (low + high) / 2;
}

/* Returns whether the point at s is kept by the lines and lies between the planes. */
static int is_kept(const line *ray, double s, double *depth) {
    const psplat_splat *splat = ray->splat;
    double p[3];
    if (!isfinite(s)) return 0;
    point_at(ray, s, p);
    for (uint32_t k = 0; k < splat->clip_count; ++k) {
        double a = splat->clip[k][0], b = splat->clip[k][1], m = a * p[1] - b * p[0];
        if (a * p[0] + b * p[1] + (double)splat->clip[k][2] + (double)splat->bend[k] * m * m / 2 <
            0)
            return 0;
    }
    double z = clip_of(ray->frame, p, 1, 2), w = clip_of(ray->frame, p, 1, 3);
    *depth = 0.5 + 0.5 * z / w;
    return w > 0 && fabs(z / w) <= 1;
}

/* Returns whether the ray meets the wall, of this depth, where it comes over the ellipse. */
static int meets_wall(const line *ray, double low, double high, double wall) {
    double height = height_at(ray, low), step = 1e-6 * (high - low);
    return height < 0 && height > -wall && height_at(ray, low + step) < height;
}

/* Finds the nearest point that is a fragment, else one of the wall. Of the two parts into which the
 * extremum divides the way over the ellipse, the ray meets a front where its height falls. */
static int other_fragment(const line *ray, int cull, double wall, double *s, double *depth) {
    double low, high;
    if (!over_ellipse(ray, &low, &high)) return 0;
    double middle = (low + high) / 2;
    double chord = (height_at(ray, low) + height_at(ray, high)) / 2;
    double top = extremum(ray, low, high, height_at(ray, middle) > chord ? 1 : -1);
    double ends[3] = {low, top, high};
    for (int k = 0; k < 2; ++k) {
        *s = root_between(ray, ends[k], ends[k + 1]);
        if (cull && !(height_at(ray, ends[k]) > height_at(ray, ends[k + 1]))) continue;
        if (is_kept(ray, *s, depth)) return 1;
    }
    *s = low;
    return meets_wall(ray, low, high, wall) && is_kept(ray, low, depth) ? 2 : 0;
}

typedef struct tally {
    size_t covered, walls, skipped, splats;
} tally;

static void compare(const psplat_splat *splat, double wall, const double transform[16],
                    const psplat_view *view, const picture *p, tally *counts) {
    double frame[4][4];
    line ray = {.splat = splat, .frame = frame};
    size_t before = counts->covered;
    clip_frame(splat, transform, view, frame);
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        double s = 0, depth = 0, point[3];
        set_line(&ray, 2 * (i % WIDTH + 0.5) / WIDTH - 1, 2 * (i / WIDTH + 0.5) / HEIGHT - 1);
        int kept = other_fragment(&ray, view->culling == PSPLAT_CULL_ALWAYS, wall, &s, &depth);
        /* Pixels closer than double rounding to a tie are skipped; at a contour the points of rays
         * move with the root of what is rounded. */
        if (p->image.tie[i] < 1e-6 || p->image.depth_tie[i] < 1e-9) {
            ++counts->skipped;
            continue;
        }
        assert_int_equal(p->image.count[i], kept > 0);
        counts->covered += kept > 0;
        counts->walls += kept == 2;
        if (!kept) continue;
        point_at(&ray, s, point);
        for (int k = 0; k < 2; ++k) assert_near(p->image.uv[2 * i + k], point[k], 1e-6);
        assert_near(p->image.depth[i], depth, 1e-8);
    }
    counts->splats += counts->covered > before;
}

static void test_random_curved_splats(void **state) {
    (void)state;
    uint32_t random = 20060713;
    tally counts = {0};
    const int tries = 2500;
    for (int i = 0; i < tries; ++i) {
        scene s = scene_blank(1);
        double transform[16];
        random_splat(&s.splats[0], &random);
        s.depth_tolerance = i % 3 ? s.splats[0].radius[0] * (float)magnitude(&random, 1e-3, 4) : 0;
        random_transform(transform, &random);
        psplat_view view = random_view(&random, 1);
        view.no_filter = i % 2;
        psplat_asset *asset = scene_open(&s);
        picture p = picture_draw(asset, transform, &view);
        const psplat_splat *splat = &psplat_asset_batch(asset, 0)->splats[0];
        double wall = (double)s.depth_tolerance / 4 / (double)splat->radius[0];
        compare(splat, wall, transform, &view, &p, &counts);
        picture_free(&p);
        psplat_asset_destroy(asset);
        scene_free(&s);
    }
    print_message("%d splats, %zu seen, %zu pixels covered, %zu by walls, %zu skipped\n", tries,
                  counts.splats, counts.covered, counts.walls, counts.skipped);
    assert_true(counts.splats > 300 && counts.covered > 20000 && counts.walls > 1000);
    assert_true(counts.skipped * 100 < counts.covered);
}

int test_reference_curved_brute_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_random_curved_splats)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

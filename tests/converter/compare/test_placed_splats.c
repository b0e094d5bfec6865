/* SPDX-License-Identifier: MIT
 *
 * test_placed_splats.c - tests of splats placed by nodes, and of the nearest of them to a point.
 * Expected values are the definitions: transformed points and tangents, and distances over a dense
 * grid.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "compare_fixture.h"
#include "base/random.h"
#include "base/region.h"
#include "base/region_distance.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "compare/placed_splats.h"
#include "export/glb_writer.h"
#include "measure/measured_splats.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"

static const double none[3] = {0, 0, 0};

/* Makes a random affine map (4 x 4, by columns) that is far from singular. */
static void random_map(uint64_t *random, double matrix[16]) {
    double determinant, cofactor[3];
    memset(matrix, 0, 16 * sizeof *matrix);
    do {
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 3; ++k) matrix[4 * c + k] = 4 * psplat_random_unit(random) - 2;
        cross3(cofactor, matrix + 4, matrix + 8);
        determinant = dot3(matrix, cofactor);
    } while (fabs(determinant) < 0.5);
    for (int k = 0; k < 3; ++k) matrix[12 + k] = 10 * psplat_random_unit(random) - 5;
    matrix[15] = 1;
}

static void transform(const double m[16], const double p[3], double result[3]) {
    for (int k = 0; k < 3; ++k)
        result[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
}

/* Stores the transformed normal by its definition: perpendicular to the images of two vectors that
 * are perpendicular to it, on the side of its own image, and of the length that spec 4 gives. */
static void transform_normal(const double m[16], const double n[3], double result[3]) {
    double a[3], b[3], unit[3], images[3][3];
    const double *vectors[3] = {a, b, unit};
    memcpy(unit, n, sizeof unit);
    double length = normalize3(unit);
    perpendicular3(a, unit);
    cross3(b, unit, a);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            images[i][k] =
                m[k] * vectors[i][0] + m[4 + k] * vectors[i][1] + m[8 + k] * vectors[i][2];
    cross3(result, images[0], images[1]);
    double determinant = dot3(result, images[2]);
    double scale = length * cbrt(fabs(determinant)) / determinant;
    for (int k = 0; k < 3; ++k) result[k] *= scale;
}

static void point_of(const psplat_region *region, const double uv[2], double point[3]) {
    memcpy(point, region->center, 3 * sizeof *point);
    mad3(point, uv[0] * region->radius[0], region->u);
    mad3(point, uv[1] * region->radius[1], region->v);
}

static void assert_near3(const double a[3], const double b[3], double tolerance) {
    for (int k = 0; k < 3; ++k) assert_near(a[k], b[k], tolerance);
}

/* Returns the splats of a batch, which stay its own, in one run. */
static psplat_splats splats_of(const psplat_batch *batch, psplat_run *run) {
    *run = (psplat_run){.count = batch->splat_count,
                        .clip_lines = batch->clip_count,
                        .seam_lines = batch->seam_lines};
    return (psplat_splats){.splats = (psplat_splat *)batch->splats,
                           .count = batch->splat_count,
                           .runs = run,
                           .run_count = 1};
}

/* Asserts that a point is beyond a seam where its image is. Returns whether it is. */
static int check_beyond(const psplat_region *stored, const double uv[2],
                        const psplat_region *placed, const double image[2]) {
    int is_beyond = psplat_region_is_beyond_seam(stored, uv);
    assert_int_equal(placed->line_count, stored->line_count);
    assert_int_equal(placed->seam_count, stored->seam_count);
    assert_int_equal(psplat_region_is_beyond_seam(placed, image), is_beyond);
    return is_beyond;
}

/* Asserts that points, which of them the lines keep, and normals agree with the map. Returns how
 * many of the points are beyond a seam. */
static int check_placed(const psplat_region *stored, const psplat_blend_field *field,
                        const psplat_region *placed, const psplat_blend_field *placed_field,
                        const double m[16], uint64_t *random) {
    double right[3];
    int beyond = 0;
    assert_near(dot3(placed->u, placed->v), 0, 1e-12);
    assert_near(length3(placed->u), 1, 1e-12);
    assert_near(length3(placed->v), 1, 1e-12);
    cross3(right, placed->u, placed->v);
    assert_near3(right, placed->n, 1e-12);
    assert_true(placed->radius[0] >= placed->radius[1] * (1 - 1e-12));
    for (int i = 0; i < 20; ++i) {
        double uv[2], p[3], q[3], uvh[3], n[3], expected[3], seen[3];
        for (int k = 0; k < 2; ++k) uv[k] = 2.4 * psplat_random_unit(random) - 1.2;
        point_of(stored, uv, p);
        transform(m, p, q);
        psplat_region_local(placed, q, uvh);
        /* Rounding of coordinates of about 10 in units of radii of 0.02 and more. */
        assert_near(uvh[2], 0, 1e-12);
        assert_near(hypot(uvh[0], uvh[1]), hypot(uv[0], uv[1]), 1e-10);
        assert_int_equal(psplat_region_contains(placed, uvh, 1, 0),
                         psplat_region_contains(stored, uv, 1, 0));
        beyond += check_beyond(stored, uv, placed, uvh);
        psplat_blend_field_normal(field, uv, n);
        transform_normal(m, n, expected);
        psplat_blend_field_normal(placed_field, uvh, seen);
        assert_near3(seen, expected, 1e-9 * length3(expected));
    }
    return beyond;
}

static void test_transforms(void **state) {
    (void)state;
    uint64_t random = 3;
    int mirrored = 0, beyond = 0;
    for (uint32_t round = 0; round < 20; ++round) {
        double m[16], cofactor[3];
        scene s = scene_ellipses(30, 4, round + 1);
        s.seam_lines = round % 5;
        random_map(&random, m);
        cross3(cofactor, m + 4, m + 8);
        mirrored += dot3(m, cofactor) < 0;
        psplat_asset *asset = fixture_open(&s, m);
        psplat_placed_splats placed;
        assert_int_equal(psplat_placed_splats_create(asset, none, &placed, NULL), PSPLAT_OK);
        assert_int_equal(placed.splats.count, s.count);
        size_t at = 0;
        double scale = cbrt(fabs(dot3(m, cofactor)));
        assert_near(placed.depth, scale * (double)s.depth_tolerance, 1e-6 * scale);
        for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
            const psplat_batch *batch = psplat_asset_batch(asset, b);
            psplat_run run;
            psplat_splats stored = splats_of(batch, &run);
            psplat_measured_splats measured;
            assert_int_equal(batch->seam_lines,
                             s.seam_lines < batch->clip_count ? s.seam_lines : batch->clip_count);
            assert_int_equal(psplat_measured_splats_create(&stored, 1, 1, &measured), PSPLAT_OK);
            for (size_t i = 0; i < stored.count; ++i, ++at)
                beyond +=
                    check_placed(&measured.regions[i], &measured.fields[i],
                                 &placed.splats.regions[at], &placed.splats.fields[at], m, &random);
            psplat_measured_splats_free(&measured);
        }
        psplat_placed_splats_free(&placed);
        psplat_asset_destroy(asset);
        scene_free(&s);
    }
    assert_in_range(mirrored, 4, 16); /* out of 20 */
    assert_true(beyond > 1000);       /* out of 12,000 */
}

/* Stores the image of a surface's normal, of any length: the cross product of the images of both
 * tangents, on the side of the image of the normal. */
static void image_normal(const psplat_region *r, const double uv[2], const double m[16],
                         double result[3]) {
    double slope[2], tangents[3][3], images[3][3];
    psplat_region_slope(r, uv, slope);
    memcpy(tangents[0], r->u, sizeof tangents[0]);
    memcpy(tangents[1], r->v, sizeof tangents[1]);
    for (int k = 0; k < 2; ++k) mad3(tangents[k], slope[k], r->n);
    psplat_region_normal(r, uv, tangents[2]);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            images[i][k] =
                m[k] * tangents[i][0] + m[4 + k] * tangents[i][1] + m[8 + k] * tangents[i][2];
    cross3(result, images[0], images[1]);
    double side = dot3(result, images[2]) < 0 ? -1 : 1;
    for (int k = 0; k < 3; ++k) result[k] *= side;
    normalize3(result);
}

/* Curved splats under any affine map, mirrors among them, are curved splats again: points of the
 * surface, what the lines keep, and normals are the images. */
static void test_curved(void **state) {
    (void)state;
    uint64_t random = 21;
    for (uint32_t round = 0; round < 20; ++round) {
        double m[16];
        scene s = scene_ellipses(30, 4, round + 1);
        scene_curve(&s);
        s.seam_lines = round % 5;
        for (size_t i = 0; i < s.count; ++i)
            for (uint32_t k = 0; k < s.splats[i].clip_count; ++k)
                s.splats[i].bend[k] = (float)(4 * psplat_random_unit(&random) - 2);
        random_map(&random, m);
        psplat_asset *asset = fixture_open(&s, m);
        psplat_placed_splats placed;
        assert_int_equal(psplat_placed_splats_create(asset, none, &placed, NULL), PSPLAT_OK);
        assert_int_equal(placed.splats.count, s.count);
        size_t at = 0;
        for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
            const psplat_batch *batch = psplat_asset_batch(asset, b);
            psplat_run run;
            psplat_splats stored = splats_of(batch, &run);
            psplat_region *regions = psplat_splat_regions(&stored);
            assert_non_null(regions);
            for (size_t i = 0; i < 20 * stored.count; ++i) {
                const psplat_region *from = &regions[i / 20], *to = &placed.splats.regions[at];
                double uv[2], p[3], q[3], uvh[3], normal[3], expected[3];
                assert_true(psplat_region_is_curved(from));
                for (int k = 0; k < 2; ++k) uv[k] = 2.4 * psplat_random_unit(&random) - 1.2;
                psplat_region_point(from, uv, p);
                transform(m, p, q);
                psplat_region_local(to, q, uvh);
                /* Rounding of coordinates of about 10 in units of radii of 0.005 and more, and of
                 * heights that steep surfaces make of that. */
                assert_near(uvh[2], 0, 1e-11);
                assert_near(hypot(uvh[0], uvh[1]), hypot(uv[0], uv[1]), 1e-9);
                assert_int_equal(psplat_region_contains(to, uvh, 1, 0),
                                 psplat_region_contains(from, uv, 1, 0));
                check_beyond(from, uv, to, uvh);
                psplat_region_normal(to, uvh, normal);
                image_normal(from, uv, m, expected);
                assert_near3(normal, expected, 1e-8);
                psplat_blend_field_normal(&placed.splats.fields[at], uvh, normal);
                normalize3(normal); /* The field is that of the surface, rounded to floats. */
                assert_near3(normal, expected, 1e-5);
                at += i % 20 == 19;
            }
            free(regions);
        }
        psplat_placed_splats_free(&placed);
        psplat_asset_destroy(asset);
        scene_free(&s);
    }
}

/* Splats that convert writes come back bit by bit, also far from the origin. */
static void test_exact(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "part.obj");
    for (int k = 0; k < 3; ++k) f.mesh.origin[k] += 1e7 / 3;
    const psplat_convert_desc desc = {
        .tolerance_percent = 3, .effort = PSPLAT_EFFORT_NONE, .unverified = 1};
    psplat_splats splats = {0};
    psplat_placed_splats placed;
    psplat_asset *asset;
    uint8_t *glb;
    size_t size;
    assert_int_equal(psplat_convert(&f.mesh, &desc, &splats, NULL, NULL), PSPLAT_OK);
    assert_int_equal(psplat_glb_write(&splats, "part", NULL, &glb, &size, NULL), PSPLAT_OK);
    assert_int_equal(psplat_asset_open_memory(glb, size, NULL, &asset, NULL), PSPLAT_OK);
    free(glb);
    assert_int_equal(psplat_placed_splats_create(asset, f.mesh.origin, &placed, NULL), PSPLAT_OK);
    assert_int_equal(placed.splats.count, splats.count);
    for (size_t b = 0, at = 0; b < psplat_asset_batch_count(asset); ++b) {
        const psplat_batch *batch = psplat_asset_batch(asset, b);
        psplat_splats stored = {.splats = (psplat_splat *)batch->splats,
                                .count = batch->splat_count};
        psplat_measured_splats measured;
        assert_int_equal(psplat_measured_splats_create(&stored, 1, 1, &measured), PSPLAT_OK);
        assert_memory_equal(measured.regions, placed.splats.regions + at,
                            stored.count * sizeof *measured.regions);
        assert_memory_equal(measured.fields->normals, placed.splats.fields[at].normals,
                            sizeof measured.fields->normals);
        at += stored.count;
        psplat_measured_splats_free(&measured);
    }
    psplat_placed_splats_free(&placed);
    psplat_asset_destroy(asset);
    psplat_splats_free(&splats);
    fixture_free(&f);
}

/* ---- the nearest point ----------------------------------------------------------------------- */

/* steps of the grid of (u, v) along each axis */
enum { GRID = 150 };

static double brute_distance(const psplat_region *region, const double point[3]) {
    double least = HUGE_VAL;
    for (int i = -GRID; i <= GRID; ++i)
        for (int j = -GRID; j <= GRID; ++j) {
            double uv[2] = {(double)i / GRID, (double)j / GRID}, p[3];
            if (!psplat_region_contains(region, uv, 1, 0)) continue;
            point_of(region, uv, p);
            least = min2(least, distance2_3(p, point));
        }
    return sqrt(least);
}

/* The distance of a region is the least over a grid of its points, up to the spacing; beside a
 * circle it is exact. */
static void test_distance(void **state) {
    (void)state;
    uint64_t random = 9;
    scene s = scene_ellipses(40, 4, 5);
    psplat_splats stored = {.splats = s.splats, .count = s.count};
    psplat_region *regions = psplat_splat_regions(&stored);
    assert_non_null(regions);
    for (size_t i = 0; i < s.count; ++i) {
        double p[3];
        for (int k = 0; k < 3; ++k)
            p[k] = regions[i].center[k] +
                   3 * (psplat_random_unit(&random) - 0.5) * regions[i].radius[0];
        double found = psplat_region_distance(&regions[i], p),
               brute = brute_distance(&regions[i], p);
        /* The distance is never above that of the grid; it is below by at most the diagonal of a
         * cell, plus a cell at an outline. */
        assert_true(found <= brute * (1 + 1e-12));
        assert_true(found >= brute - 3 * regions[i].radius[0] / GRID);
    }
    free(regions);
    scene_free(&s);
}

static void test_distance_exact(void **state) {
    (void)state;
    psplat_region r = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {2, 2}};
    assert_near(psplat_region_distance(&r, (const double[]){0.5, 1, -3}), 3, 0);
    assert_near(psplat_region_distance(&r, (const double[]){5, 0, 4}), 5, 1e-14);
    assert_near(psplat_region_distance(&r, (const double[]){1e9, 0, 0}), 1e9 - 2, 1e-6);
    r.radius[0] = 1e4,
    r.radius[1] = 1; /* a needle: beyond its tip, beside it, off the middle of its side */
    assert_near(psplat_region_distance(&r, (const double[]){1e4 + 1, 0, 0}), 1, 1e-11);
    assert_near(psplat_region_distance(&r, (const double[]){0, 3, 0}), 2, 1e-14);
    r.radius[1] = 1e4;
    r.line_count = 2; /* u >= 1/2 and v >= 1/2 leave a quarter with a corner. */
    r.lines[0][0] = r.lines[1][1] = 1, r.lines[0][2] = r.lines[1][2] = -0.5;
    r.radius[0] = r.radius[1] = 2;
    assert_near(psplat_region_distance(&r, (const double[]){0, 0, 0}), sqrt(2), 1e-14);
    assert_near(psplat_region_distance(&r, (const double[]){0, 1.5, 0}), 1, 1e-14);
    /* The line cuts off the circle's nearest point; the end of the arc is nearest. */
    assert_near(psplat_region_distance(&r, (const double[]){0, 4, 0}), hypot(1, 4 - sqrt(3)),
                1e-14);
    r.lines[1][1] = -1, r.lines[1][2] = -0.5; /* v <= -1/2 */
    assert_near(psplat_region_distance(&r, (const double[]){0, 0, 0}), sqrt(2), 1e-14);
    r.lines[1][1] = 0, r.lines[1][0] = -1; /* no point has u <= -1/2 and u >= 1/2 */
    assert_true(isinf(psplat_region_distance(&r, (const double[]){0, 0, 0})));
}

/* The distance of the nearest splat is the least over all splats. */
static void test_nearest(void **state) {
    (void)state;
    uint64_t random = 4;
    scene s = scene_ellipses(400, 4, 8);
    psplat_splats stored = {.splats = s.splats, .count = s.count};
    psplat_region *regions = psplat_splat_regions(&stored);
    psplat_region_tree *region_tree = psplat_region_tree_create(regions, s.count, 0);
    assert_non_null(region_tree);
    for (int i = 0; i < 500; ++i) {
        double p[3], least = HUGE_VAL, far = i % 10 ? 2 : 100;
        for (int k = 0; k < 3; ++k) p[k] = far * (psplat_random_unit(&random) - 0.25);
        for (size_t r = 0; r < s.count; ++r)
            least = min2(least, psplat_region_distance(&regions[r], p));
        assert_near(psplat_region_nearest_distance(regions, s.count, region_tree, 0.01, p), least,
                    0);
    }
    assert_true(isinf(psplat_region_nearest_distance(regions, 0, region_tree, 0.01, none)));
    psplat_region_tree_destroy(region_tree);
    free(regions);
    scene_free(&s);
}

int test_placed_splats_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_transforms), cmocka_unit_test(test_exact),
        cmocka_unit_test(test_distance),   cmocka_unit_test(test_distance_exact),
        cmocka_unit_test(test_nearest),    cmocka_unit_test(test_curved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

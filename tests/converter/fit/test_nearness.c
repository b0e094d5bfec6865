/* SPDX-License-Identifier: MIT
 *
 * test_nearness.c - tests that what is near a proxy by the tolerance less its deviation is near the
 * mesh. The mesh is a square at height 0, and the proxy one at a known height.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/region.h"
#include "fit/fit_context.h"
#include "fit/nearness.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>

static const double tolerance = 1, deviation = 0.05;

static psplat_distance *square_at(double height) {
    double positions[12] = {-9, -9, height, 9, -9, height, 9, 9, height, -9, 9, height};
    uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    const psplat_mesh mesh = {
        .positions = positions, .triangles = triangles, .vertex_count = 4, .triangle_count = 2};
    psplat_distance *tree = psplat_distance_create(&mesh);
    assert_non_null(tree);
    return tree;
}

static int is_near(const psplat_limits *limits, double height) {
    const double point[3] = {0.5, 0.25, height};
    const psplat_region region = {
        .center = {0.5, 0.25, height}, .u = {1}, .v = {0, 1}, .n = {0, 0, 1}, .radius = {2, 1}};
    int point_near = -1, region_near = -1;
    uint32_t guess = UINT32_MAX;
    assert_int_equal(psplat_limits_point_near(limits, point, &guess, &point_near), PSPLAT_OK);
    assert_int_equal(psplat_limits_region_near(limits, &region, &region_near), PSPLAT_OK);
    assert_int_equal(point_near, region_near);
    return point_near;
}

/* Without a proxy the mesh decides; with one, nothing is near that is not near the mesh, and what
 * is nearer by twice the deviation is near. */
static void test_near_the_mesh(void **state) {
    (void)state;
    static const double heights[] = {0,    0.89,  -0.89, 0.91,  -0.91, 0.94,  -0.94,
                                     0.99, -0.99, 1.01,  -1.01, 1.06,  -1.06, -9};
    psplat_distance *mesh = square_at(0);
    for (int k = -1; k <= 1; ++k) {
        psplat_distance *proxy = square_at(k * deviation);
        for (size_t i = 0; i < sizeof heights / sizeof *heights; ++i) {
            psplat_limits limits = {.tolerance = tolerance, .distance = mesh};
            double height = fabs(heights[i]);
            assert_int_equal(is_near(&limits, heights[i]), height <= tolerance);
            limits.proxy = proxy;
            limits.proxy_deviation = deviation;
            int near = is_near(&limits, heights[i]);
            if (near && height > tolerance) fail_msg("%g is not near", heights[i]);
            if (!near && height < tolerance - 2 * deviation) fail_msg("%g is near", heights[i]);
        }
        psplat_distance_destroy(proxy);
    }
    psplat_distance_destroy(mesh);
}

/* The mesh is not asked where there is a proxy: it would take as long as without one. */
static void test_proxy_decides(void **state) {
    (void)state;
    psplat_distance *proxy = square_at(0), *none = square_at(100);
    psplat_limits limits = {
        .tolerance = tolerance, .distance = none, .proxy = proxy, .proxy_deviation = deviation};
    assert_true(is_near(&limits, 0.94));
    assert_false(is_near(&limits, 0.96));
    limits.distance = proxy;
    limits.proxy = none;
    assert_false(is_near(&limits, 0));
    psplat_distance_destroy(proxy);
    psplat_distance_destroy(none);
}

int test_nearness_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_near_the_mesh),
        cmocka_unit_test(test_proxy_decides),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

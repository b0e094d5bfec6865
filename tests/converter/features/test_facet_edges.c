/* SPDX-License-Identifier: MIT
 *
 * test_facet_edges.c - tests of edges between facets that are large beside the tolerance, on a ball
 * of few flat quadrangles, whose angles and widths are known.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "features/facet_edges.h"
#include "features/surface.h"
#include "shape_fixture.h"
#include "stage_fixture.h"

enum { ROWS = 10, SIDES = 16 };

static psplat_mesh make_ball(void) {
    double profile[ROWS + 1][2];
    for (int i = 0; i <= ROWS; ++i) {
        double turn = fixture_pi * i / ROWS;
        profile[i][0] = i % ROWS ? sin(turn) : 0;
        profile[i][1] = -cos(turn);
    }
    return shape_turned((const double(*)[2])profile, ROWS + 1, SIDES);
}

static psplat_surface build(const psplat_mesh *mesh, double tolerance) {
    const psplat_patch_bounds bounds = {.crease_angle = fixture_crease_angle,
                                        .facet_tolerance = tolerance};
    psplat_surface surface;
    assert_int_equal(psplat_surface_build_bounded(mesh, &bounds, &surface, NULL), PSPLAT_OK);
    return surface;
}

/* Returns the number of edges that are marked, and asserts that both of their triangles know. */
static size_t count_marked(const psplat_mesh *mesh, double tolerance) {
    psplat_surface surface = build(mesh, tolerance);
    size_t marked = 0, count = surface.facet_edges;
    for (size_t e = 0; e < 3 * mesh->triangle_count; ++e)
        marked += surface.creases[e] == PSPLAT_BOUND_FACET;
    assert_int_equal(marked, 2 * count);
    psplat_surface_free(&surface);
    return count;
}

/* All edges but the diagonals of the quadrangles are marked where the tolerance is small: each
 * quadrangle is a patch, and normals go on across. */
static void test_all(void **state) {
    (void)state;
    psplat_mesh mesh = make_ball();
    psplat_surface smooth = build(&mesh, 0), facets = build(&mesh, 0.005);
    size_t count;
    assert_int_equal(smooth.facet_edges, 0);
    assert_int_equal(smooth.patch_count, 1);
    assert_int_equal(facets.facet_edges, (ROWS - 1) * SIDES + ROWS * SIDES);
    assert_int_equal(facets.patch_count, ROWS * SIDES);
    assert_memory_equal(smooth.corner_normals, facets.corner_normals,
                        9 * mesh.triangle_count * sizeof(float));
    assert_int_equal(psplat_facets_count(&smooth, 0.005, &count), PSPLAT_OK);
    assert_int_equal(count, ROWS * SIDES);
    assert_int_equal(psplat_facets_count(&smooth, 10, &count), PSPLAT_OK);
    assert_int_equal(count, 0);
    psplat_surface_free(&smooth);
    psplat_surface_free(&facets);
    psplat_mesh_free(&mesh);
}

/* An edge of the equator is marked up to 20 / 16 of the angle over it, times the width of the rows
 * beside it: from the middle of one edge to that of the next. */
static void test_limit(void **state) {
    (void)state;
    psplat_mesh mesh = make_ball();
    const double turn = fixture_pi / ROWS, side = fixture_pi / SIDES;
    const double radial = (1 - cos(turn)) * cos(side), upright = sin(turn);
    const double limit = 2 * atan2(radial, upright) * hypot(radial, upright) * 20 / 16;
    /* Corners are rounded to floats at most, by which angles err by some 1e-7. */
    size_t below = count_marked(&mesh, limit * (1 - 1e-4));
    size_t above = count_marked(&mesh, limit * (1 + 1e-4));
    assert_int_equal(below - above, SIDES);
    assert_int_equal(count_marked(&mesh, 10), 0);
    psplat_mesh_free(&mesh);
}

/* Of two triangles beside an edge the narrower one counts. */
static void test_narrow(void **state) {
    (void)state;
    psplat_mesh mesh = {0};
    const double rise = 0.1;
    double left[4][3] = {{-0.1, 0, -0.1 * rise}, {0, 0, 0}, {0, 1, 0}, {-0.1, 1, -0.1 * rise}};
    double right[4][3] = {{0, 0, 0}, {1, 0, -rise}, {1, 1, -rise}, {0, 1, 0}};
    shape_quad(&mesh, left, 0);
    shape_quad(&mesh, right, 0);
    shape_weld(&mesh);
    const double limit = 2 * atan(rise) * 0.1 * hypot(1, rise) * 20 / 16;
    assert_int_equal(count_marked(&mesh, limit * (1 - 1e-4)), 1);
    assert_int_equal(count_marked(&mesh, limit * (1 + 1e-4)), 0);
    psplat_mesh_free(&mesh);
}

/* Where less than half of the edges that bend would be marked, nothing is counted as facets. */
static void test_share(void **state) {
    (void)state;
    psplat_mesh mesh = make_ball();
    psplat_surface surface = build(&mesh, 0);
    const size_t bent = (ROWS - 1) * SIDES + ROWS * SIDES;
    int some = 0, most = 0;
    for (double tolerance = 0.01; tolerance < 0.3; tolerance *= 1.02) {
        size_t count, marked = count_marked(&mesh, tolerance);
        assert_int_equal(psplat_facets_count(&surface, tolerance, &count), PSPLAT_OK);
        assert_int_equal(count > 0, 2 * marked >= bent);
        some += marked > 0 && 2 * marked < bent;
        most += 2 * marked >= bent;
    }
    assert_true(some > 0 && most > 0);
    psplat_surface_free(&surface);
    psplat_mesh_free(&mesh);
}

/* Edges of flat faces bound nothing, and creases stay creases. */
static void test_cube(void **state) {
    (void)state;
    psplat_mesh mesh = shape_cube(3);
    size_t count;
    psplat_surface surface = build(&mesh, 1e-3);
    assert_int_equal(surface.facet_edges, 0);
    assert_int_equal(surface.patch_count, 6);
    assert_int_equal(psplat_facets_count(&surface, 1e-3, &count), PSPLAT_OK);
    assert_int_equal(count, 0);
    psplat_surface_free(&surface);
    psplat_mesh_free(&mesh);
}

int test_facet_edges_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all),   cmocka_unit_test(test_limit), cmocka_unit_test(test_narrow),
        cmocka_unit_test(test_share), cmocka_unit_test(test_cube),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_slivers.c - tests of slivers: what stands on the surface or is folded over it, and is
 * thinner than what a splat may be off by, faces as the surface beside it; strips of fillets, and
 * steps that are higher, face their own way.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "appearance/alpha_mask.h"
#include "base/vector.h"
#include "features/surface.h"
#include "features/surface_build.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "shape_fixture.h"
#include "splats/splats.h"
#include "stage_fixture.h"
#include "verify/report.h"

enum { LINKS = 16 };

/* How far the vertices of the chain below lie above and below the sheet. */
static const double dent = 0.002;

/* Returns a square sheet of two halves: one has a chain of vertices along the middle, above and
 * below in turn, the other one edge. Triangles in the upright plane between them close the gap,
 * some the one way round and some the other, as a simplifier leaves them beside a border that it
 * has to keep. */
static psplat_mesh make_sheet(void) {
    psplat_mesh mesh = {0};
    const double left[2][3] = {{-1, 0, 0}, {-1, 1, 0}}, right[2][3] = {{1, 0, 0}, {1, 1, 0}};
    double chain[LINKS + 1][3];
    for (int i = 0; i <= LINKS; ++i) {
        chain[i][0] = 0;
        chain[i][1] = i / (double)LINKS;
        chain[i][2] = i % LINKS ? (i % 2 ? dent : -dent) : 0;
    }
    for (int i = 0; i < LINKS; ++i) shape_triangle(&mesh, left[0], chain[i], chain[i + 1]);
    shape_triangle(&mesh, left[0], chain[LINKS], left[1]);
    for (int i = 1; i < LINKS; ++i) shape_triangle(&mesh, chain[0], chain[i + 1], chain[i]);
    shape_triangle(&mesh, chain[0], right[0], right[1]);
    shape_triangle(&mesh, chain[0], right[1], chain[LINKS]);
    shape_weld(&mesh);
    return mesh;
}

static psplat_surface build(const psplat_mesh *mesh, double height) {
    const psplat_patch_bounds bounds = {.crease_angle = fixture_crease_angle,
                                        .sliver_height = height};
    psplat_surface surface;
    assert_int_equal(psplat_surface_build_bounded(mesh, &bounds, &surface, NULL), PSPLAT_OK);
    return surface;
}

/* The sheet is one patch that faces up, and has walls where slivers have to be lower. */
static void test_sheet(void **state) {
    (void)state;
    psplat_mesh mesh = make_sheet();
    psplat_surface flat = build(&mesh, 4 * dent), low = build(&mesh, dent / 100),
                   own = build(&mesh, 0);
    size_t walls = 0;
    for (size_t t = 0; t < mesh.triangle_count; ++t) {
        walls += fabs(own.face_normals[3 * t]) > 0.99;
        assert_true(flat.face_normals[3 * t + 2] > 0.99); /* the halves have slopes of 0.064 */
    }
    assert_int_equal(walls, LINKS - 1);
    assert_int_equal(flat.patch_count, 1);
    assert_int_equal(flat.crease_edges, 0);
    assert_true(own.patch_count > 2);
    assert_true(own.crease_edges > LINKS);
    assert_memory_equal(low.face_normals, own.face_normals,
                        3 * mesh.triangle_count * sizeof(double));
    assert_memory_equal(flat.face_areas, own.face_areas, mesh.triangle_count * sizeof(double));
    psplat_surface_free(&flat);
    psplat_surface_free(&low);
    psplat_surface_free(&own);
    psplat_mesh_free(&mesh);
}

/* Points of a sliver have its barycentric coordinates, whichever way it faces: along the normal of
 * the sheet, the walls have no area. */
static void test_barycentric(void **state) {
    (void)state;
    psplat_mesh mesh = make_sheet();
    psplat_surface surface = build(&mesh, 4 * dent);
    for (uint32_t t = 0; t < mesh.triangle_count; ++t) {
        const double weights[3] = {0.5, 0.375, 0.125};
        double point[3] = {0, 0, 0}, found[3];
        for (int k = 0; k < 3; ++k) mad3(point, weights[k], psplat_mesh_corner(&mesh, t, k));
        psplat_surface_barycentric(&surface, t, point, found);
        /* rounding of coordinates of 1, beside an altitude of 1e-3 or more */
        for (int k = 0; k < 3; ++k) assert_near(found[k], weights[k], 1e-11);
    }
    psplat_surface_free(&surface);
    psplat_mesh_free(&mesh);
}

/* The order of triangles does not matter. */
static void test_order(void **state) {
    (void)state;
    psplat_mesh mesh = make_sheet(), turned = make_sheet();
    size_t count = mesh.triangle_count;
    for (size_t t = 0; t < count; ++t)
        memcpy(turned.triangles + 3 * t, mesh.triangles + 3 * (count - 1 - t),
               3 * sizeof *mesh.triangles);
    psplat_surface a = build(&mesh, 4 * dent), b = build(&turned, 4 * dent);
    for (size_t t = 0; t < count; ++t)
        assert_memory_equal(a.face_normals + 3 * t, b.face_normals + 3 * (count - 1 - t),
                            3 * sizeof(double));
    psplat_surface_free(&a);
    psplat_surface_free(&b);
    psplat_mesh_free(&mesh);
    psplat_mesh_free(&turned);
}

/* Splats cover the sheet as if there were no slivers. With walls, each of them takes at least a
 * splat of its own. */
static void test_conversion(void **state) {
    (void)state;
    psplat_mesh mesh = make_sheet();
    const psplat_convert_desc desc = {.tolerance_percent =
                                          100 * 20 * 2 * dent / psplat_mesh_diagonal(&mesh),
                                      .precision = PSPLAT_USUAL_PRECISION};
    psplat_splats splats;
    psplat_report report;
    psplat_error error;
    if (psplat_convert(&mesh, &desc, &splats, &report, &error)) fail_msg("%s", error.text);
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
    assert_int_equal(report.crease_edges, 0);
    assert_in_range(splats.count, 1, 8); /* the sheet alone takes 2 to 4 */
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
}

/* The strips of a fillet that is lower than the limit altogether are slivers, and agree with each
 * other up to the edges of the bottom: they keep their normals. */
static void test_fillet(void **state) {
    (void)state;
    enum { SEGMENTS = 12, SIDES = 24 };
    const double fillet = 0.01, height = 0.02;
    double profile[SEGMENTS + 4][2] = {{0, 0}, {1, 0}};
    for (int i = 0; i <= SEGMENTS; ++i) {
        double turn = fixture_pi / 2 * i / SEGMENTS;
        profile[i + 2][0] = 1 - fillet + fillet * cos(turn);
        profile[i + 2][1] = 1 + fillet * sin(turn);
    }
    profile[SEGMENTS + 3][0] = 0;
    profile[SEGMENTS + 3][1] = 1 + fillet;
    psplat_mesh mesh = shape_turned((const double(*)[2])profile, SEGMENTS + 4, SIDES);
    psplat_surface settled = build(&mesh, height), own = build(&mesh, 0);
    assert_memory_equal(settled.face_normals, own.face_normals,
                        3 * mesh.triangle_count * sizeof(double));
    psplat_surface_free(&settled);
    psplat_surface_free(&own);
    psplat_mesh_free(&mesh);
}

/* A step vanishes where it is lower than the limit, and stays between two creases where it is not.
 */
static void test_step(void **state) {
    (void)state;
    const double heights[] = {0.009, 0.011};
    for (int i = 0; i < 2; ++i) {
        psplat_mesh mesh = {0};
        const double h = heights[i];
        double low[4][3] = {{-1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {-1, 1, 0}};
        double riser[4][3] = {{0, 0, 0}, {0, 0, h}, {0, 1, h}, {0, 1, 0}};
        double high[4][3] = {{0, 0, h}, {1, 0, h}, {1, 1, h}, {0, 1, h}};
        shape_quad(&mesh, low, 0);
        shape_quad(&mesh, riser, 0);
        shape_quad(&mesh, high, 0);
        shape_weld(&mesh);
        psplat_surface surface = build(&mesh, 0.01);
        assert_int_equal(surface.crease_edges, i ? 2 : 0);
        assert_int_equal(surface.patch_count, i ? 3 : 1);
        psplat_surface_free(&surface);
        psplat_mesh_free(&mesh);
    }
}

/* The faces of a thin wire go all around it: its ends, which are no slivers, lie across short
 * edges.
 */
static void test_wire(void **state) {
    (void)state;
    psplat_mesh mesh = shape_cube(1);
    for (size_t i = 0; i < mesh.vertex_count; ++i)
        for (size_t k = 0; k < 2; ++k) mesh.positions[3 * i + k] *= 0.002;
    psplat_surface settled = build(&mesh, 0.01), own = build(&mesh, 0);
    assert_memory_equal(settled.face_normals, own.face_normals,
                        3 * mesh.triangle_count * sizeof(double));
    assert_int_equal(settled.patch_count, 6);
    psplat_surface_free(&settled);
    psplat_surface_free(&own);
    psplat_mesh_free(&mesh);
}

/* A sliver beside nothing, and one beside slivers alone, face their own way. */
static void test_alone(void **state) {
    (void)state;
    psplat_mesh mesh = {0};
    double ribbon[4][3] = {{0, 0, 0}, {0, 0, 0.001}, {0, 1, 0.001}, {0, 1, 0}};
    shape_quad(&mesh, ribbon, 0);
    shape_weld(&mesh);
    psplat_surface surface = build(&mesh, 0.01);
    for (size_t t = 0; t < 2; ++t)
        assert_near(fabs(surface.face_normals[3 * t]), 1, 1e-12); /* unit */
    psplat_surface_free(&surface);
    psplat_mesh_free(&mesh);
}

int test_slivers_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sheet),  cmocka_unit_test(test_barycentric),
        cmocka_unit_test(test_order),  cmocka_unit_test(test_conversion),
        cmocka_unit_test(test_fillet), cmocka_unit_test(test_step),
        cmocka_unit_test(test_wire),   cmocka_unit_test(test_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

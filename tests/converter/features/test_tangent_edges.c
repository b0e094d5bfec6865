/* SPDX-License-Identifier: MIT
 *
 * test_tangent_edges.c - tests of tangent edges: where a wall goes over into a fillet, splats end,
 * but the surface stays smooth. The shapes are cans whose rim at the top is rounded, so that the
 * edges at both ends of the fillet are known; scans and figures have none.
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
#include "blend_fixture.h"
#include "features/surface.h"
#include "features/triangle_flood.h"
#include "measure/measured_splats.h"
#include "mesh/edges.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "shape_fixture.h"
#include "splats/splats.h"
#include "stage_fixture.h"
#include "verify/report.h"

enum { SIDES = 48, SEGMENTS = 12 };

/* Of the can: its radius, and the height at which the fillet begins. */
static const double radius = 1, wall = 1;
/* 0.2 % of the diagonal or so. Beyond a fillet of 0.2, normals are off by 14 degrees. */
static const double tolerance = 0.006;

/* Returns a can with a fillet of so many segments. */
static psplat_mesh make_can(double fillet, int segments, int sides) {
    double profile[80][2] = {{0, 0}, {radius, 0}};
    int count = 2;
    for (int i = 0; i <= segments; ++i, ++count) {
        double turn = fixture_pi / 2 * i / segments;
        profile[count][0] = radius - fillet + fillet * cos(turn);
        profile[count][1] = wall + fillet * sin(turn);
    }
    profile[count][0] = 0;
    profile[count][1] = wall + fillet;
    return shape_turned((const double(*)[2])profile, count + 1, sides);
}

static psplat_surface build(const psplat_mesh *mesh, double of_splats) {
    const psplat_patch_bounds bounds = {.crease_angle = fixture_crease_angle,
                                        .tolerance = of_splats};
    psplat_surface surface;
    assert_int_equal(psplat_surface_build_bounded(mesh, &bounds, &surface, NULL), PSPLAT_OK);
    return surface;
}

static size_t count_tangent_edges(const psplat_mesh *mesh, double of_splats) {
    psplat_surface surface = build(mesh, of_splats);
    size_t count = surface.tangent_edges;
    psplat_surface_free(&surface);
    return count;
}

/* Edges are marked at both ends of the fillet, on both of their triangles, and nowhere else. They
 * part wall, fillet and top, and normals go on across. */
static void test_both_ends(void **state) {
    (void)state;
    const double fillet = 0.2;
    psplat_mesh mesh = make_can(fillet, SEGMENTS, SIDES);
    psplat_surface surface = build(&mesh, tolerance), without = build(&mesh, 0);
    size_t low = 0, high = 0;
    for (uint32_t e = 0; e < 3 * mesh.triangle_count; ++e) {
        double along[3];
        if (surface.creases[e] != PSPLAT_BOUND_TANGENT) continue;
        const double *p = psplat_mesh_corner(&mesh, e / 3, (int)(e % 3));
        psplat_edge_vector(&mesh, e, along);
        assert_true(fabs(along[2]) < 1e-9); /* level; units of the can */
        low += fabs(p[2] - wall) < 1e-9;
        high += fabs(p[2] - wall - fillet) < 1e-9;
    }
    assert_int_equal(low, 2 * SIDES);
    assert_int_equal(high, 2 * SIDES);
    assert_int_equal(surface.tangent_edges, 2 * SIDES);
    assert_int_equal(surface.patch_count, 4);
    assert_int_equal(without.tangent_edges, 0);
    assert_int_equal(without.patch_count, 2);
    assert_int_equal(surface.crease_edges, without.crease_edges);
    assert_memory_equal(surface.corner_normals, without.corner_normals,
                        mesh.triangle_count * 9 * sizeof(float));
    psplat_surface_free(&surface);
    psplat_surface_free(&without);
    psplat_mesh_free(&mesh);
}

/* Normals beyond a fillet of radius R are off by sqrt(2 e / R), and from 8 degrees on that counts:
 * with these tolerances up to a radius of 0.616. */
static void test_radii(void **state) {
    (void)state;
    const double fillets[] = {0.1, 0.3, 0.59, 0.64};
    for (int i = 0; i < 4; ++i) {
        psplat_mesh mesh = make_can(fillets[i], 4 * SEGMENTS, SIDES);
        assert_int_equal(count_tangent_edges(&mesh, tolerance), fillets[i] > 0.6 ? 0 : 2 * SIDES);
        psplat_mesh_free(&mesh);
    }
}

/* A round part of few facets, which are as wide as what is straight, has no begin. */
static void test_coarse(void **state) {
    (void)state;
    const size_t expected[] = {0, 0, 2 * SIDES, 2 * SIDES};
    for (int i = 0; i < 4; ++i) {
        psplat_mesh mesh = make_can(0.2, 1 << i, SIDES);
        assert_int_equal(count_tangent_edges(&mesh, tolerance), expected[i]);
        psplat_mesh_free(&mesh);
    }
}

/* What rounding to floats far from the origin leaves is a tangent edge still; what noise of a tenth
 * of the edges' length leaves is none. */
static void test_noise(void **state) {
    (void)state;
    psplat_mesh mesh = make_can(0.2, SEGMENTS, SIDES);
    for (size_t i = 0; i < 3 * mesh.vertex_count; ++i)
        mesh.positions[i] = (double)(float)(mesh.positions[i] + 10) - 10;
    assert_int_equal(count_tangent_edges(&mesh, tolerance), 2 * SIDES);
    shape_noise(&mesh, 0.1 * shape_mean_edge(&mesh));
    assert_int_equal(count_tangent_edges(&mesh, tolerance), 0);
    psplat_mesh_free(&mesh);
}

/* What is round all over has none, at any tolerance. */
static void test_round_shapes(void **state) {
    (void)state;
    const char *models[] = {"sphere.ply", "torus.off", "cone.stl"};
    for (int i = 0; i < 3; ++i) {
        fixture f;
        fixture_model(&f, models[i]);
        for (double e = 1e-3; e < 0.05; e *= 1.5)
            assert_int_equal(count_tangent_edges(&f.mesh, e * psplat_mesh_diagonal(&f.mesh)), 0);
        fixture_free(&f);
    }
}

/* A short piece of a fillet is no chain: it takes six reaches, which are 0.29 here. */
static void test_short_chains(void **state) {
    (void)state;
    for (int wide = 0; wide < 2; ++wide) {
        psplat_mesh mesh = {0};
        double width = wide ? 0.35 : 0.25;
        for (int row = 0; row < 4; ++row)
            for (int i = -1; i < SEGMENTS; ++i) {
                double q[4][3];
                for (int k = 0; k < 4; ++k) {
                    double turn = fixture_pi / 2 * (i + (k == 1 || k == 2)) / SEGMENTS;
                    q[k][0] = i < 0 && (k == 0 || k == 3) ? -1 : 0.2 * sin(turn);
                    q[k][1] = width * (row + (k >= 2)) / 4;
                    q[k][2] = i < 0 ? 0 : 0.2 * cos(turn) - 0.2;
                }
                shape_quad(&mesh, q, 0);
            }
        shape_weld(&mesh);
        assert_int_equal(count_tangent_edges(&mesh, tolerance), wide ? 4 : 0);
        psplat_mesh_free(&mesh);
    }
}

/* What is beneath and around a splat goes on over tangent edges, with its texture. */
static void test_floods(void **state) {
    (void)state;
    psplat_mesh mesh = make_can(0.2, SEGMENTS, SIDES);
    psplat_surface surface = build(&mesh, tolerance);
    psplat_triangle_flood flood = {0};
    size_t found = 0;
    for (uint32_t e = 0; e < 3 * mesh.triangle_count; ++e) {
        psplat_region region = {.radius = {0.05, 0.05}};
        if (surface.creases[e] != PSPLAT_BOUND_TANGENT) continue;
        double along[3];
        psplat_edge_vector(&mesh, e, along);
        along3(region.center, psplat_mesh_corner(&mesh, e / 3, (int)(e % 3)), 0.5, along);
        memcpy(region.n, surface.face_normals + 3 * (size_t)(e / 3), sizeof region.n);
        memcpy(region.u, along, sizeof region.u);
        normalize3(region.u);
        cross3(region.v, region.n, region.u);
        assert_true(psplat_triangle_flood_beneath(&flood, &surface, &region, tolerance, e / 3));
        assert_true(psplat_triangle_flood_met(&flood, surface.neighbors[e]));
        assert_true(psplat_triangle_flood_around(&flood, &surface, &region, tolerance, e / 3));
        assert_true(psplat_triangle_flood_met(&flood, surface.neighbors[e]));
        ++found;
    }
    assert_int_equal(found, 4 * SIDES); /* either side of each edge */
    psplat_triangle_flood_free(&flood);
    psplat_surface_free(&surface);
    psplat_mesh_free(&mesh);
}

/* Returns the root mean square of the angles, in degrees, between the normals that splats blend to
 * and those of the wall, from half a reach below the fillet up to that. */
static double wall_error(const psplat_splats *splats, double fillet) {
    enum { AROUND = 500, ROWS = 8 };
    psplat_measured_splats measured;
    double reach = sqrt(2 * tolerance * fillet), squares = 0;
    assert_int_equal(psplat_measured_splats_create(splats, tolerance, 2 * tolerance, &measured),
                     PSPLAT_OK);
    for (int i = 0; i < AROUND * ROWS; ++i) {
        /* The middle of a side, where the prism has the normal of the cylinder. */
        double turn = 2 * fixture_pi * (i % SIDES + 0.5) / SIDES;
        double height = wall - 0.5 * reach * (i / AROUND + 0.5) / ROWS;
        double inside = cos(fixture_pi / SIDES);
        const double point[3] = {inside * cos(turn), inside * sin(turn), height};
        const double normal[3] = {cos(turn), sin(turn), 0};
        double angle = blend_normal_error(&measured, splats->origin, 2 * tolerance, point, normal);
        squares += angle * angle;
    }
    psplat_measured_splats_free(&measured);
    return sqrt(squares / (AROUND * ROWS));
}

/* Returns that error of a conversion of a can without its bottom, which has no crease. Without
 * creases there are no tangent edges either. */
static double convert_can(const psplat_mesh *mesh, double fillet, int no_creases) {
    double percent = 100 * tolerance / psplat_mesh_diagonal(mesh);
    const psplat_convert_desc desc = {.tolerance_percent = percent,
                                      .precision = PSPLAT_USUAL_PRECISION,
                                      .no_creases = no_creases,
                                      .effort = PSPLAT_EFFORT_NONE};
    psplat_splats splats;
    psplat_report report;
    psplat_error error;
    if (psplat_convert(mesh, &desc, &splats, &report, &error)) fail_msg("%s", error.text);
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
    assert_int_equal(report.tangent_edges, no_creases ? 0 : 2 * SIDES);
    double degrees = wall_error(&splats, fillet);
    psplat_splats_free(&splats);
    return degrees;
}

/* Splats of the fillet no longer show their normals on the wall: where they reach over the edge
 * they are off by up to 14 degrees, and the few that still lap over it by 0.4 tolerances are off by
 * 0.9, and by 1.2 where surfaces come nearer to the mesh when they are rounded. */
static void test_normals(void **state) {
    (void)state;
    const double fillet = 0.2;
    psplat_mesh mesh = make_can(fillet, SEGMENTS, SIDES);
    size_t kept = 0;
    for (size_t t = 0; t < mesh.triangle_count; ++t) {
        const uint32_t *v = mesh.triangles + 3 * t;
        double height = 0;
        for (int k = 0; k < 3; ++k) height += mesh.positions[3 * (size_t)v[k] + 2];
        if (height > 0) memmove(mesh.triangles + 3 * kept++, v, 3 * sizeof *v);
    }
    mesh.triangle_count = kept;
    double with = convert_can(&mesh, fillet, 0), without = convert_can(&mesh, fillet, 1);
    if (!(with < 1 && without > 2 * with))
        fail_msg("normals of the wall are off by %g degrees, by %g without", with, without);
    psplat_mesh_free(&mesh);
}

int test_tangent_edges_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_both_ends),    cmocka_unit_test(test_radii),
        cmocka_unit_test(test_coarse),       cmocka_unit_test(test_noise),
        cmocka_unit_test(test_round_shapes), cmocka_unit_test(test_short_chains),
        cmocka_unit_test(test_floods),       cmocka_unit_test(test_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

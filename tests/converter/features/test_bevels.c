/* SPDX-License-Identifier: MIT
 *
 * test_bevels.c - tests of tangent edges that the file's normals tell: two flat sides and a bevel
 * of one facet between them over which normals turn. Splats end at both edges of the bevel, so that
 * the flat sides are shaded as flat.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "appearance/alpha_mask.h"
#include "base/vector.h"
#include "blend_fixture.h"
#include "features/surface.h"
#include "measure/measured_splats.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "shape_fixture.h"
#include "splats/splats.h"
#include "stage_fixture.h"
#include "verify/report.h"

/* A sheet of two flat sides, as wide as this, with a bevel between, and this long in some rows. */
static const double side = 1, length = 4;
enum { ROWS = 5 };
/* Half a percent of the diagonal or so. */
static const double tolerance = 0.02;

/* How the file's normals are: none; those of the flat sides, between which they turn over the
 * bevel; and those of the sides turned towards the bevel by some degrees, as averages are. */
typedef enum sheet_normals { NO_NORMALS, FLAT_SIDES, TURNED_SIDES } sheet_normals;

typedef struct sheet {
    double points[4][2]; /* the profile */
    double turn;         /* radians between the sides */
    psplat_mesh mesh;
} sheet;

/* Returns the direction of the normal of a profile point, in radians. */
static double normal_angle(const sheet *s, int point, double turned) {
    return point < 2 ? turned : s->turn - turned;
}

/* Sets the normals of all corners: a vertex has one, so that edges are smooth. */
static void set_normals(sheet *s, double turned) {
    psplat_mesh *mesh = &s->mesh;
    mesh->corner_normals = malloc(9 * mesh->triangle_count * sizeof(float));
    assert_non_null(mesh->corner_normals);
    for (size_t c = 0; c < 3 * mesh->triangle_count; ++c) {
        const double *p = mesh->positions + 3 * (size_t)mesh->triangles[c];
        int nearest = 0;
        for (int i = 1; i < 4; ++i)
            if (hypot(p[0] + mesh->origin[0] - s->points[i][0],
                      p[2] + mesh->origin[2] - s->points[i][1]) <
                hypot(p[0] + mesh->origin[0] - s->points[nearest][0],
                      p[2] + mesh->origin[2] - s->points[nearest][1]))
                nearest = i;
        double angle = normal_angle(s, nearest, turned);
        mesh->corner_normals[3 * c] = (float)sin(angle);
        mesh->corner_normals[3 * c + 1] = 0;
        mesh->corner_normals[3 * c + 2] = (float)cos(angle);
    }
}

/* Adds one row of quadrangles between two profile points. */
static void add_row(psplat_mesh *mesh, const double from[2], const double to[2], int row) {
    double q[4][3];
    for (int k = 0; k < 4; ++k) {
        const double *p = k == 1 || k == 2 ? to : from;
        q[k][0] = p[0], q[k][2] = p[1];
        q[k][1] = length * (row + (k >= 2)) / ROWS;
    }
    shape_quad(mesh, q, row % 2);
}

/* Makes a sheet whose sides are turned against each other by so many degrees. The first one has
 * another row of edges at `support` before the bevel, where that is not 0. */
static sheet make_supported(double degrees, double width, sheet_normals normals, double turned,
                            double support) {
    sheet s = {.turn = degrees * fixture_pi / 180};
    const double steps[3] = {side, width, side}, turns[3] = {0, s.turn / 2, s.turn};
    for (int i = 0; i < 3; ++i) {
        s.points[i + 1][0] = s.points[i][0] + steps[i] * cos(turns[i]);
        s.points[i + 1][1] = s.points[i][1] - steps[i] * sin(turns[i]);
    }
    const double before[2] = {side - support, 0};
    for (int row = 0; row < ROWS; ++row) {
        if (support > 0) add_row(&s.mesh, s.points[0], before, row);
        add_row(&s.mesh, support > 0 ? before : s.points[0], s.points[1], row);
        for (int i = 1; i < 3; ++i) add_row(&s.mesh, s.points[i], s.points[i + 1], row);
    }
    shape_weld(&s.mesh);
    if (normals != NO_NORMALS)
        set_normals(&s, normals == TURNED_SIDES ? turned * fixture_pi / 180 : 0);
    return s;
}

static sheet make_sheet(double degrees, double width, sheet_normals normals, double turned) {
    return make_supported(degrees, width, normals, turned, 0);
}

/* Returns how many edges of a sheet are tangent edges, all of which run along the bevel. */
static size_t count_edges(const sheet *s) {
    const psplat_patch_bounds bounds = {.crease_angle = fixture_crease_angle,
                                        .tolerance = tolerance};
    psplat_surface surface;
    size_t marked = 0;
    assert_int_equal(psplat_surface_build_bounded(&s->mesh, &bounds, &surface, NULL), PSPLAT_OK);
    for (uint32_t e = 0; e < 3 * s->mesh.triangle_count; ++e) {
        double along[3];
        if (surface.creases[e] != PSPLAT_BOUND_TANGENT) continue;
        psplat_edge_vector(&s->mesh, e, along);
        assert_true(fabs(along[0]) + fabs(along[2]) < 1e-9); /* units of the sheet */
        ++marked;
    }
    assert_int_equal(marked, 2 * surface.tangent_edges);
    assert_int_equal(surface.patch_count, marked ? 3 : surface.crease_edges ? 3 : 1);
    psplat_surface_free(&surface);
    return marked / 2;
}

static size_t edges_of(double degrees, double width, sheet_normals normals, double turned) {
    sheet s = make_sheet(degrees, width, normals, turned);
    size_t count = count_edges(&s);
    psplat_mesh_free(&s.mesh);
    return count;
}

/* Both edges of a bevel are marked, up to a width of three tolerances and down to a fiftieth. */
static void test_widths(void **state) {
    (void)state;
    const double widths[] = {0.02, 0.3, 1, 2.9, 3.1, 10}; /* in tolerances */
    for (int i = 0; i < 6; ++i)
        assert_int_equal(edges_of(90, widths[i] * tolerance, FLAT_SIDES, 0),
                         widths[i] < 3 ? 2 * ROWS : 0);
}

/* A bevel counts from 16 degrees on. */
static void test_turns(void **state) {
    (void)state;
    const double degrees[] = {14, 18, 45, 100};
    for (int i = 0; i < 4; ++i)
        assert_int_equal(edges_of(degrees[i], 0.3 * tolerance, FLAT_SIDES, 0), i ? 2 * ROWS : 0);
}

/* The file's normals have to be those of the flat sides, within a degree: as far as they turn
 * there, splats are to turn with them. Without normals, edges of 45 degrees are creases and no
 * tangent edges. */
static void test_normals_decide(void **state) {
    (void)state;
    const double width = 2 * tolerance;
    assert_int_equal(edges_of(90, width, TURNED_SIDES, 0.8), 2 * ROWS);
    assert_int_equal(edges_of(90, width, TURNED_SIDES, 1.2), 0);
    assert_int_equal(edges_of(90, width, NO_NORMALS, 0), 0);
}

/* Edges of a flat side beside the bevel, as modellers add them so that normals stay flat, are none.
 */
static void test_support(void **state) {
    (void)state;
    sheet s = make_supported(90, 0.5 * tolerance, FLAT_SIDES, 0, 0.5 * tolerance);
    assert_int_equal(count_edges(&s), 2 * ROWS);
    psplat_mesh_free(&s.mesh);
}

/* ---- what it is for -------------------------------------------------------------------------- */

/* Returns the root mean square of the angles, in degrees, between the normals that splats blend to
 * and that of the first side, over all of it but a tolerance at its edges. */
static double side_error(const psplat_splats *splats) {
    enum { ACROSS = 60, ALONG = 200 };
    psplat_measured_splats measured;
    double squares = 0;
    assert_int_equal(psplat_measured_splats_create(splats, tolerance, 2 * tolerance, &measured),
                     PSPLAT_OK);
    for (int i = 0; i < ACROSS * ALONG; ++i) {
        double x = tolerance + (side - 2 * tolerance) * (i % ACROSS + 0.5) / ACROSS;
        double y = tolerance + (length - 2 * tolerance) * (i / ACROSS + 0.5) / ALONG;
        const double point[3] = {x, y, 0}, normal[3] = {0, 0, 1};
        double angle = blend_normal_error(&measured, splats->origin, 2 * tolerance, point, normal);
        squares += angle * angle;
    }
    psplat_measured_splats_free(&measured);
    return sqrt(squares / (ACROSS * ALONG));
}

static double convert_sheet(const sheet *s, int no_creases, size_t *count) {
    const psplat_convert_desc desc = {.tolerance_percent =
                                          100 * tolerance / psplat_mesh_diagonal(&s->mesh),
                                      .precision = PSPLAT_USUAL_PRECISION,
                                      .no_creases = no_creases,
                                      .effort = PSPLAT_EFFORT_NONE};
    psplat_splats splats;
    psplat_report report;
    psplat_error error;
    if (psplat_convert(&s->mesh, &desc, &splats, &report, &error)) fail_msg("%s", error.text);
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
    assert_int_equal(report.tangent_edges, no_creases ? 0 : 2 * ROWS);
    *count = splats.count;
    double degrees = side_error(&splats);
    psplat_splats_free(&splats);
    return degrees;
}

/* The flat sides are shaded as flat, by one splat each and a few along the bevel. Without tangent
 * edges parabolas round the corner off, and it takes more of them: sides err by 2.3 and 3 degrees.
 */
static void test_shading(void **state) {
    (void)state;
    const double widths[] = {2, 0.5}; /* in tolerances */
    for (int i = 0; i < 2; ++i) {
        size_t with_count, without_count;
        sheet s = make_sheet(90, widths[i] * tolerance, FLAT_SIDES, 0);
        double with = convert_sheet(&s, 0, &with_count);
        double without = convert_sheet(&s, 1, &without_count);
        if (!(with < 0.1 && without > 1))
            fail_msg("normals of a side are off by %g degrees, by %g without", with, without);
        assert_true(with_count < without_count);
        psplat_mesh_free(&s.mesh);
    }
}

int test_bevels_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_widths),         cmocka_unit_test(test_turns),
        cmocka_unit_test(test_normals_decide), cmocka_unit_test(test_support),
        cmocka_unit_test(test_shading),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

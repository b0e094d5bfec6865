/* SPDX-License-Identifier: MIT
 *
 * test_close_seams.c - tests of extending clip lines across a crease: afterwards two splats reach
 * the line where their planes meet, and no farther. The shape is a pair of squares that meet at a
 * known angle; expected distances are the intersection of the two planes.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "fit/fit_context.h"
#include "base/random.h"
#include "base/region.h"
#include "base/vector.h"
#include "fit/candidate.h"
#include "fit/clip_lines.h"
#include "fit/crease_segments.h"
#include "mesh/mesh.h"
#include "finish/close_seams.h"
#include "select/selection.h"

/* Two unit squares that meet along the v axis of a random frame. The first one lies in the plane of
 * the frame, and the second one is bent away from it. */
typedef struct roof {
    fixture f;
    double o[3], u[3], v[3], n[3]; /* frame of the first square; u = 0 is the crease */
    double u2[3], n2[3];           /* direction into the second square, and its normal */
    psplat_selection selection;
} roof;

static void place_square(double s, double t, double p[3]) {
    p[0] = s, p[1] = t, p[2] = 0;
}

/* Makes the squares; bend is the angle in radians by which the second one turns down (convex edge)
 * or, if negative, up (concave edge). */
static void make_roof(roof *r, double bend, uint64_t *random) {
    fixture_grid(&r->f, 2, 1, place_square);
    random_axes(random, r->u, r->v, r->n);
    for (int k = 0; k < 3; ++k) {
        r->o[k] = 10 * psplat_random_unit(random);
        r->u2[k] = cos(bend) * r->u[k] - sin(bend) * r->n[k];
        r->n2[k] = cos(bend) * r->n[k] + sin(bend) * r->u[k];
    }
    for (size_t i = 0; i < r->f.mesh.vertex_count; ++i) {
        double *p = r->f.mesh.positions + 3 * i, s = 2 * p[0] - 1, t = p[1] - 0.5;
        memcpy(p, r->o, sizeof r->o);
        mad3(p, s, s < 0 ? r->u : r->u2);
        mad3(p, t, r->v);
    }
    fixture_build(&r->f);
    fixture_sample(&r->f, 0.05); /* The flood over their clusters finds creases. */
    assert_int_equal(r->f.surface.patch_count, 2);
    r->selection = (psplat_selection){calloc(2, sizeof(psplat_candidate)), 2, 2};
    assert_non_null(r->selection.candidates);
}

/* Returns whether one side of the triangle is the crease. */
static int meets_ridge(const roof *r, uint32_t triangle) {
    for (size_t k = 0; k < 3; ++k) {
        size_t edge = 3 * (size_t)triangle + k;
        if (r->f.surface.creases[edge] && r->f.surface.neighbors[edge] != PSPLAT_NONE) return 1;
    }
    return 0;
}

/* Adds a splat on one of the squares, raised by height, with the clip line that psplat_clip_choose
 * finds. */
static void add_splat(roof *r, int second, double height) {
    psplat_candidate *candidate = &r->selection.candidates[second];
    const double *u = second ? r->u2 : r->u, *n = second ? r->n2 : r->n;
    psplat_region *region = &candidate->region;
    *region = (psplat_region){.radius = {0.45, 0.3}};
    memcpy(region->center, r->o, sizeof r->o);
    mad3(region->center, second ? 0.3 : -0.3, u);
    memcpy(region->u, u, sizeof r->u);
    memcpy(region->n, n, sizeof r->n);
    cross3(region->v, n, u);
    double seed[2] = {0, 0};
    for (candidate->triangle = 0; candidate->triangle < 4; ++candidate->triangle) {
        const double *face = r->f.surface.face_normals + 3 * (size_t)candidate->triangle;
        if (dot3(face, n) > 0.999 && meets_ridge(r, candidate->triangle)) break;
    }
    /* The borders are far away, so that the crease alone cuts the splat. */
    uint32_t edges[3];
    psplat_segment segments[3];
    size_t count = 0;
    for (uint32_t k = 0; k < 3; ++k) {
        edges[count] = 3 * candidate->triangle + k;
        count += r->f.surface.creases[edges[count]] &&
                 r->f.surface.neighbors[edges[count]] != PSPLAT_NONE;
    }
    count = psplat_segments_find(&r->f.surface, edges, count, region, 0.01, segments);
    assert_int_equal(count, 1);
    assert_int_equal(psplat_clip_choose(region, segments, count, seed, 1e-3, 0), 1);
    assert_int_equal(region->line_count, 1);
    mad3(region->center, height, n);
}

/* Returns how far the splat's line lies beyond the crease, in the splat's plane and at the middle
 * of the crease. */
static double reach_of(const roof *r, int second) {
    const psplat_region *region = &r->selection.candidates[second].region;
    double uvh[3];
    psplat_region_local(region, r->o, uvh);
    const double *line = region->lines[0];
    double rate = hypot(line[0] / region->radius[0], line[1] / region->radius[1]);
    return (line[0] * uvh[0] + line[1] * uvh[1] + line[2]) / rate;
}

/* Returns how far beyond the crease, in the first plane, the planes at these heights meet. */
static double meeting(double bend, double own, double other) {
    return (other - own * cos(bend)) / sin(bend);
}

static void join_and_check(double bend, double first, double second, uint64_t *random) {
    roof r;
    make_roof(&r, bend, random);
    add_splat(&r, 0, first);
    add_splat(&r, 1, second);
    psplat_limits limits = {
        .tolerance = 0.05, .crease_tolerance = 0.02, .crease_slack = 1e-3, .margin = 0.01};
    const psplat_fit_context context = fixture_context(&r.f, &limits, NULL);
    assert_int_equal(psplat_close_seams(&context, &r.selection), PSPLAT_OK);
    /* The second square's direction beyond the crease is -u2, along which the height over the first
     * plane grows by sin(bend). */
    double wanted[2] = {meeting(bend, first, second), meeting(bend, second, first)};
    for (int k = 0; k < 2; ++k) {
        double most = wanted[k] > 0 ? wanted[k] : 0; /* A line never moves inwards. */
        /* Lines may be found, and moved, a millionth of the ellipse too far. */
        assert_near(reach_of(&r, k), most, 2e-6);
    }
    psplat_selection_free(&r.selection);
    fixture_free(&r.f);
}

static void test_meet(void **state) {
    (void)state;
    uint64_t random = 3;
    const double bends[] = {fixture_pi / 2, fixture_pi / 3, -fixture_pi / 2, -fixture_pi / 4};
    for (int turn = 0; turn < 10; ++turn)
        for (size_t k = 0; k < sizeof bends / sizeof *bends; ++k) {
            join_and_check(bends[k], 0.01, 0.005, &random);
            join_and_check(bends[k], -0.01, 0.005, &random);
            join_and_check(bends[k], 0.01, -0.005, &random);
            join_and_check(bends[k], -0.01, -0.005, &random);
            join_and_check(bends[k], 0, 0, &random);
        }
}

/* Planes that almost agree meet far away or never: their lines are not extended to thin fins. A
 * splat of the other square that is farther away than the tolerance has no effect. */
static void test_stay(void **state) {
    (void)state;
    uint64_t random = 4;
    for (int shallow = 0; shallow < 2; ++shallow) {
        roof r;
        make_roof(&r, shallow ? 0.6 : fixture_pi / 2, &random);
        add_splat(&r, 0, 0);
        add_splat(&r, 1, shallow ? 0.049 : 0.051);
        psplat_limits limits = {.tolerance = 0.05, .crease_tolerance = 0.02, .crease_slack = 1e-3};
        const psplat_fit_context context = fixture_context(&r.f, &limits, NULL);
        assert_int_equal(psplat_close_seams(&context, &r.selection), PSPLAT_OK);
        /* The tolerance decides which splats are near, and half of it bounds the move of a line. */
        assert_near(reach_of(&r, 0), shallow ? 0.025 : 0, 2e-6);
        psplat_selection_free(&r.selection);
        fixture_free(&r.f);
    }
}

/* A bent line that reaches over the ends of its crease by 0.7 tolerances moves no farther than to
 * 0.8 there, although 0.2 are missing in the middle. */
static void test_bent_line(void **state) {
    (void)state;
    uint64_t random = 5;
    const double tolerance = 0.05, half = 0.3;
    roof r;
    make_roof(&r, fixture_pi / 2, &random);
    add_splat(&r, 0, 0);
    add_splat(&r, 1, 0.2 * tolerance);
    psplat_region *region = &r.selection.candidates[0].region;
    /* The line bulges out towards the ends of the crease, which the ellipse cuts at v = -half and
     * half. */
    double reach = 0.7 * tolerance / region->radius[0];
    region->radius[1] = half / sqrt(1 - pow(0.3 / region->radius[0], 2));
    region->bends[0] = 2 * reach / pow(half / region->radius[1], 2);
    psplat_limits limits = {.tolerance = tolerance, .crease_tolerance = 0.02};
    const psplat_fit_context context = fixture_context(&r.f, &limits, NULL);
    assert_int_equal(psplat_close_seams(&context, &r.selection), PSPLAT_OK);
    double greatest = 0, middle = 0;
    for (int i = -50; i <= 50; ++i) {
        double point[3], uvh[3], step = 1e-6;
        memcpy(point, r.o, sizeof point);
        mad3(point, half * i / 50.0, r.v);
        psplat_region_local(region, point, uvh);
        double value = psplat_region_line_value(region, 0, uvh), rate[2];
        for (int k = 0; k < 2; ++k) {
            double moved[2] = {uvh[0], uvh[1]};
            moved[k] += step;
            rate[k] =
                (psplat_region_line_value(region, 0, moved) - value) / step / region->radius[k];
        }
        value /= hypot(rate[0], rate[1]) * tolerance;
        greatest = fmax(greatest, value);
        if (!i) middle = value;
    }
    assert_near(greatest, 0.8, 0.01);
    assert_true(middle > 0.05 && middle < 0.15);
    psplat_selection_free(&r.selection);
    fixture_free(&r.f);
}

/* Asserts that the lines of two splats reach so far, in tolerances, over a border of a kind and
 * between two sides that are bent by an angle, though their surfaces meet there already. A shallow
 * border is one whose triangles are said to face one way. */
static void check_border(uint8_t bound, double bend, int is_shallow, double reach) {
    uint64_t random = 7;
    roof r;
    make_roof(&r, bend, &random);
    add_splat(&r, 0, 0);
    add_splat(&r, 1, 0);
    for (size_t e = 0; e < 3 * r.f.mesh.triangle_count; ++e)
        if (r.f.surface.creases[e] && r.f.surface.neighbors[e] != PSPLAT_NONE)
            r.f.surface.creases[e] = bound;
    for (size_t t = 0; t < r.f.mesh.triangle_count && is_shallow; ++t)
        memcpy(r.f.surface.face_normals + 3 * t, r.n, sizeof r.n);
    psplat_limits limits = {
        .tolerance = 0.05, .crease_tolerance = 0.02, .crease_slack = 1e-3, .margin = 0.01};
    const psplat_fit_context context = fixture_context(&r.f, &limits, NULL);
    assert_int_equal(psplat_close_seams(&context, &r.selection), PSPLAT_OK);
    /* Lines may be found, and moved, a millionth of the ellipse too far. */
    for (int k = 0; k < 2; ++k) assert_near(reach_of(&r, k), reach * limits.tolerance, 2e-6);
    psplat_selection_free(&r.selection);
    fixture_free(&r.f);
}

/* At a border of charts lines reach a little over it, since the texture of the other chart shows
 * there; at a tangent edge, where nothing shows, by two tolerances, but not where its two sides are
 * bent; at what is both, a little. */
static void test_chart_border(void **state) {
    (void)state;
    check_border(PSPLAT_BOUND_CHART, 0.6, 0, 0.4);
    check_border(PSPLAT_BOUND_TANGENT, 0.6, 1, 2);
    check_border(PSPLAT_BOUND_TANGENT, 0.6, 0, 0);
    check_border(PSPLAT_BOUND_CHART | PSPLAT_BOUND_TANGENT, 0.6, 0, 0.4);
}

int test_close_seams_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_chart_border),
        cmocka_unit_test(test_meet),
        cmocka_unit_test(test_stay),
        cmocka_unit_test(test_bent_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

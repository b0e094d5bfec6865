/* SPDX-License-Identifier: MIT
 *
 * test_clip_lines.c - tests of choosing clip lines (at most four) around a seed from creases:
 * convex and reflex corners, curved creases, and too many creases. The creases are polylines in the
 * plane of a splat of radius 2; expected counts and distances follow from their geometry.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "near.h"
#include "base/random.h"
#include "base/region.h"
#include "fit/clip_lines.h"
#include "fit/crease_segments.h"

static const double pi = 3.14159265358979323846;

/* Stores a chain of creases through the given points, joined by vertex ids, with the surface to its
 * left. Returns the index behind the last segment. */
static size_t chain(psplat_segment *segments, size_t begin, const double (*points)[2], size_t count,
                    int closed) {
    size_t edges = closed ? count : count - 1;
    for (size_t i = 0; i < edges; ++i) {
        size_t next = (i + 1) % count;
        psplat_segment *s = &segments[begin + i];
        *s = (psplat_segment){.vertex = {(uint32_t)(begin + i), (uint32_t)(begin + next)}};
        for (int k = 0; k < 2; ++k) s->a[k] = points[i][k], s->b[k] = points[next][k];
    }
    return begin + edges;
}

static psplat_region unit_region(void) {
    return (psplat_region){.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {2, 2}};
}

/* Returns by how much the region's lines keep a point, the least over all lines, in units of the
 * plane (2 per unit of u). */
static double kept_by(const psplat_region *r, double u, double v) {
    double least = 1e9;
    for (uint32_t i = 0; i < r->line_count; ++i) {
        double d = 2 * psplat_region_line_value(r, i, (const double[2]){u, v});
        if (d < least) least = d;
    }
    return least;
}

static void test_no_creases(void **state) {
    (void)state;
    psplat_region r = unit_region();
    double seed[2] = {0, 0};
    assert_int_equal(psplat_clip_choose(&r, NULL, 0, seed, 0.01, 0), 1);
    assert_int_equal(r.line_count, 0);
}

/* Ten collinear edges become one line that lies on them. */
static void test_straight_chain(void **state) {
    (void)state;
    psplat_segment s[10];
    double points[11][2], seed[2] = {0, 0.3};
    for (int i = 0; i < 11; ++i) points[i][0] = -1 + 0.2 * i, points[i][1] = -0.25;
    size_t count = chain(s, 0, (const double(*)[2])points, 11, 0);
    psplat_region r = unit_region();
    assert_int_equal(psplat_clip_choose(&r, s, count, seed, 0.01, 0), 1);
    assert_int_equal(r.line_count, 1);
    assert_near(r.lines[0][0], 0, 1e-12);
    assert_near(r.lines[0][1], 1, 1e-12);
    assert_near(r.lines[0][2], 0.25, 1e-12);
}

static void test_convex_corner(void **state) {
    (void)state;
    psplat_segment s[2];
    double points[3][2] = {{-0.4, 1}, {-0.4, -0.3}, {1, -0.3}}, seed[2] = {0, 0};
    size_t count = chain(s, 0, (const double(*)[2])points, 3, 0);
    psplat_region r = unit_region();
    assert_int_equal(psplat_clip_choose(&r, s, count, seed, 0.01, 0), 1);
    assert_int_equal(r.line_count, 2);
    assert_near(kept_by(&r, -0.4, 0), 0, 1e-12);
    assert_near(kept_by(&r, 0, -0.3), 0, 1e-12);
    assert_true(kept_by(&r, -0.41, 0) < 0 && kept_by(&r, 0, -0.31) < 0);
}

/* One line suffices around a reflex corner, since the other edge lies behind it. */
static void test_reflex_corner(void **state) {
    (void)state;
    double points[3][2] = {{0.1, -1}, {0.1, 0.2}, {1, 0.2}};
    double seeds[3][2] = {{-0.5, 0}, {0.4, 0.6}, {-0.2, 0.5}};
    for (int k = 0; k < 3; ++k) {
        psplat_segment s[2];
        size_t count = chain(s, 0, (const double(*)[2])points, 3, 0);
        psplat_region r = unit_region();
        assert_int_equal(psplat_clip_choose(&r, s, count, seeds[k], 0.01, 0), 1);
        assert_int_equal(r.line_count, 1);
        assert_true(kept_by(&r, seeds[k][0], seeds[k][1]) > 0);
        for (double t = 0; t <= 1; t += 0.125) {
            assert_true(kept_by(&r, 0.1, -1 + 1.2 * t) <= 0.01 + 1e-12);
            assert_true(kept_by(&r, 0.1 + 0.9 * t, 0.2) <= 0.01 + 1e-12);
        }
    }
}

/* A convex arc of many edges gets as few lines as the slack allows; no surface is lost, and none is
 * reached beyond the slack. */
static void test_curved_chain(void **state) {
    (void)state;
    enum { COUNT = 33 };
    psplat_segment s[COUNT];
    double points[COUNT][2], seed[2] = {0, 0.8};
    for (int i = 0; i < COUNT; ++i) {
        double t = pi * (1.25 + 0.5 * i / (COUNT - 1)); /* the lower quarter of a circle */
        points[i][0] = 0.9 * cos(t), points[i][1] = 0.9 + 0.9 * sin(t);
    }
    size_t count = chain(s, 0, (const double(*)[2])points, COUNT, 0);
    const double slack = 0.15;
    psplat_region r = unit_region();
    assert_int_equal(psplat_clip_choose(&r, s, count, seed, slack, 0), 1);
    /* A run of 47 degrees has a sagitta of 0.15; the run from the middle leaves both ends. */
    assert_int_equal(r.line_count, 3);
    for (int i = 0; i < COUNT; ++i) {
        double kept = kept_by(&r, points[i][0], points[i][1]);
        assert_true(kept >= -1e-12);
        assert_true(kept <= slack + 1e-12);
    }
    r = unit_region();
    /* four lines cannot follow the arc that closely */
    assert_int_equal(psplat_clip_choose(&r, s, count, seed, 0.001, 0), 0);
}

/* ---- bent lines ------------------------------------------------------------------------------ */

/* Makes a chain along part of a circle or parabola, turned by an angle about the origin. */
enum { ARC = 41 };
static size_t arc(psplat_segment *s, double turn, void (*place)(double t, double p[2])) {
    double points[ARC][2];
    for (int i = 0; i < ARC; ++i) {
        double p[2];
        place(2 * (double)i / (ARC - 1) - 1, p);
        points[i][0] = cos(turn) * p[0] - sin(turn) * p[1];
        points[i][1] = sin(turn) * p[0] + cos(turn) * p[1];
    }
    return chain(s, 0, (const double(*)[2])points, ARC, 0);
}

/* Returns how far lines keep points all along a chain, at most. */
static double most_kept(const psplat_region *r, const psplat_segment *s, size_t count) {
    double most = -1e9;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k <= 16; ++k) {
            double t = k / 16.0;
            double kept = kept_by(r, s[i].a[0] + t * (s[i].b[0] - s[i].a[0]),
                                  s[i].a[1] + t * (s[i].b[1] - s[i].a[1]));
            if (kept > most) most = kept;
        }
    return most;
}

/* Below the seed, bulging away from it and towards it; 40 edges have chords of sagitta 4e-5. */
static void place_bowl(double t, double p[2]) {
    p[0] = 0.9 * sin(0.7 * t), p[1] = 0.5 - 0.9 * cos(0.7 * t);
}

static void place_hill(double t, double p[2]) {
    p[0] = 0.9 * sin(0.7 * t), p[1] = -1.1 + 0.9 * cos(0.7 * t);
}

static void place_parabola(double t, double p[2]) {
    p[0] = 0.9 * t, p[1] = 0.6 * p[0] * p[0] - 0.4;
}

/* Arcs of 80 degrees of either sign, however turned, get one bent line. Where they bulge away from
 * the seed, straight lines would be more, or too many; where they bulge towards it, one straight
 * line does, but loses what is beside them. No point of the arc lies deeper inside than the slack,
 * and the seed stays inside. */
static void test_bent_arcs(void **state) {
    (void)state;
    void (*const places[])(double t, double p[2]) = {place_bowl, place_hill};
    const double seed[2] = {0, 0}, slack = 0.02;
    for (int shape = 0; shape < 2; ++shape)
        for (int i = 0; i < 12; ++i) {
            psplat_segment s[ARC];
            size_t count = arc(s, 2 * pi * i / 12 + 0.1, places[shape]);
            psplat_region bent = unit_region(), straight = unit_region();
            int chosen = psplat_clip_choose(&straight, s, count, seed, slack, 0);
            assert_int_equal(psplat_clip_choose(&bent, s, count, seed, slack, 1), 1);
            assert_true(kept_by(&bent, 0, 0) > 0);
            assert_true(most_kept(&bent, s, count) <= slack * (1 + 1e-6));
            assert_int_equal(bent.line_count, 1);
            if (!shape) assert_true(!chosen || straight.line_count > 2);
            if (shape) assert_int_equal(straight.line_count, 1);
            if (shape) assert_true(psplat_region_area(&bent) > 1.1 * psplat_region_area(&straight));
            assert_true(shape ? bent.bends[0] > 0 : bent.bends[0] < 0);
            for (uint32_t k = 0; k < straight.line_count; ++k) assert_near(straight.bends[k], 0, 0);
        }
}

/* A parabola is found as it is, from both of its ends and in all directions: the bend of
 * v >= 0.6 u^2 - 0.4 is -1.2. Chords of 0.045 leave it by 0.6 * 0.045^2 / 4 = 3e-4. */
static void test_parabola(void **state) {
    (void)state;
    const double seed[2] = {0, 0};
    for (int i = 0; i < 12; ++i) {
        psplat_segment s[ARC];
        double turn = 2 * pi * i / 12 + 0.1;
        size_t count = arc(s, turn, place_parabola);
        psplat_region r = unit_region();
        assert_int_equal(psplat_clip_choose(&r, s, count, seed, 0.003, 1), 1);
        assert_int_equal(r.line_count, 1);
        assert_near(r.bends[0], -1.2, 0.01);
        assert_near(r.lines[0][0], -sin(turn), 0.005);
        assert_near(r.lines[0][1], cos(turn), 0.005);
        assert_near(r.lines[0][2], 0.4, 0.002);
        assert_true(most_kept(&r, s, count) <= 0.003);
        psplat_region straight = unit_region();
        assert_int_equal(psplat_clip_choose(&straight, s, count, seed, 0.003, 0), 0);
    }
}

/* Random chains, rough and smooth: whatever is chosen keeps the seed and no point of the chain
 * beyond the slack, and bent lines do wherever straight ones do. */
static void test_random_chains(void **state) {
    (void)state;
    uint64_t random = 21;
    size_t chosen[2] = {0, 0};
    for (int trial = 0; trial < 2000; ++trial) {
        psplat_segment s[ARC];
        double points[ARC][2], turn = 0, at[2] = {-1.2, -0.2 - 0.6 * psplat_random_unit(&random)};
        double bend = 0.2 * psplat_random_unit(&random) - 0.1, seed[2] = {0, 0.1};
        double rough = trial % 2 ? 0.02 : 0.2, slack = 0.02 + 0.1 * psplat_random_unit(&random);
        turn = -10 * bend;
        for (int i = 0; i < ARC; ++i) {
            for (int k = 0; k < 2; ++k) points[i][k] = at[k];
            turn += bend + rough * (psplat_random_unit(&random) - 0.5);
            at[0] += 0.06 * cos(turn), at[1] += 0.06 * sin(turn);
        }
        size_t count = chain(s, 0, (const double(*)[2])points, ARC, 0);
        for (int may_bend = 0; may_bend < 2; ++may_bend) {
            psplat_region r = unit_region();
            if (!psplat_clip_choose(&r, s, count, seed, slack, may_bend)) continue;
            ++chosen[may_bend];
            assert_true(kept_by(&r, seed[0], seed[1]) >= -1e-8);
            assert_true(most_kept(&r, s, count) <= slack * (1 + 1e-3));
        }
    }
    print_message("chains with up to four lines: %zu straight, %zu bent of 2000\n", chosen[0],
                  chosen[1]);
    assert_true(chosen[1] > chosen[0]);
}

/* A pentagon around the seed would need five lines. */
static void test_too_many(void **state) {
    (void)state;
    for (size_t sides = 3; sides <= 6; ++sides) {
        psplat_segment s[6];
        double points[6][2], seed[2] = {0.05, 0.02};
        for (size_t i = 0; i < sides; ++i) {
            double t = 2 * pi * (double)i / (double)sides;
            points[i][0] = 0.7 * cos(t), points[i][1] = 0.7 * sin(t);
        }
        size_t count = chain(s, 0, (const double(*)[2])points, sides, 1);
        psplat_region r = unit_region();
        int chosen = psplat_clip_choose(&r, s, count, seed, 0.01, 0);
        assert_int_equal(chosen, sides <= PSPLAT_MAX_CLIP_LINES);
        assert_int_equal(r.line_count, chosen ? sides : 0);
    }
}

/* Two chains through one vertex give the same lines, in whatever order their segments come. */
static void test_order(void **state) {
    (void)state;
    enum { COUNT = 8 };
    psplat_segment s[COUNT], shuffled[COUNT];
    double points[5][2], seed[2] = {0, 0.1};
    for (int i = 0; i < 5; ++i) points[i][0] = -0.8 + 0.4 * i, points[i][1] = -0.3;
    chain(s, 0, (const double(*)[2])points, 5, 0);
    for (int i = 0; i < 5; ++i) points[i][0] = 0.4 * i, points[i][1] = -0.3 - 0.02 * points[i][0];
    chain(s, 4, (const double(*)[2])points, 5, 0);
    s[4].vertex[0] = s[2].vertex[0]; /* both begin at (0, -0.3) */
    psplat_region first = unit_region();
    assert_int_equal(psplat_clip_choose(&first, s, COUNT, seed, 0.01, 0), 1);
    uint64_t random = 9;
    for (int round = 0; round < 50; ++round) {
        for (size_t i = 0; i < COUNT; ++i) {
            size_t at = psplat_random_next(&random) % (i + 1);
            shuffled[i] = shuffled[at];
            shuffled[at] = s[i];
        }
        psplat_region r = unit_region();
        assert_int_equal(psplat_clip_choose(&r, shuffled, COUNT, seed, 0.01, 0), 1);
        assert_int_equal(r.line_count, first.line_count);
        assert_memory_equal(r.lines, first.lines, r.line_count * sizeof r.lines[0]);
    }
}

/* Makes the first count segments of a chain borders of charts. */
static void mark_charts(psplat_segment *segments, size_t count) {
    for (size_t i = 0; i < count; ++i) segments[i].is_chart = 1;
}

/* Returns the line that keeps a point by nothing, up to rounding: the one that stands there. */
static uint32_t line_at(const psplat_region *r, double u, double v) {
    for (uint32_t i = 0; i < r->line_count; ++i)
        if (fabs(psplat_region_line_value(r, i, (const double[2]){u, v})) < 1e-9) return i;
    fail_msg("no line stands at (%g, %g)", u, v);
    return 0;
}

/* A border of charts and a crease that meet at a corner get a line each, of which that at the
 * border alone is marked. Where both go on along one straight line, that is a crease's. */
static void test_chart_lines(void **state) {
    (void)state;
    psplat_segment s[4];
    const double corner[3][2] = {{-0.4, 1}, {-0.4, -0.3}, {1, -0.3}};
    const double straight[5][2] = {{-0.8, -0.3}, {-0.4, -0.3}, {0, -0.3}, {0.4, -0.3}, {0.8, -0.3}};
    const double seed[2] = {0, 0};
    psplat_region r = unit_region();
    size_t count = chain(s, 0, corner, 3, 0);
    for (int charts = 0; charts < 3; ++charts) {
        s[0].is_chart = charts > 0, s[1].is_chart = charts > 1;
        assert_int_equal(psplat_clip_choose(&r, s, count, seed, 0.01, 0), 1);
        assert_int_equal(r.line_count, 2);
        uint32_t first = line_at(&r, -0.4, 0.3), second = line_at(&r, 0.3, -0.3);
        assert_int_equal(r.chart_lines,
                         (charts > 0 ? 1u << first : 0) | (charts > 1 ? 1u << second : 0));
    }
    count = chain(s, 0, straight, 5, 0);
    for (size_t charts = 0; charts <= count; ++charts)
        for (int may_bend = 0; may_bend < 2; ++may_bend) {
            mark_charts(s, charts);
            assert_int_equal(psplat_clip_choose(&r, s, count, seed, 0.01, may_bend), 1);
            assert_int_equal(r.line_count, 1);
            assert_int_equal(r.chart_lines, charts == count);
        }
    assert_int_equal(psplat_clip_choose(&r, NULL, 0, seed, 0.01, 0), 1);
    assert_int_equal(r.chart_lines, 0); /* That of the region before is forgotten. */
}

int test_clip_lines_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_creases),    cmocka_unit_test(test_straight_chain),
        cmocka_unit_test(test_convex_corner), cmocka_unit_test(test_reflex_corner),
        cmocka_unit_test(test_curved_chain),  cmocka_unit_test(test_bent_arcs),
        cmocka_unit_test(test_parabola),      cmocka_unit_test(test_random_chains),
        cmocka_unit_test(test_too_many),      cmocka_unit_test(test_order),
        cmocka_unit_test(test_chart_lines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

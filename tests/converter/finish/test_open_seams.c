/* SPDX-License-Identifier: MIT
 *
 * test_open_seams.c - tests of clip lines that become seams: at borders of charts on smooth
 * surfaces they do, at creases and where the surface bends away they do not, and all of a splat
 * keeps the distance bound beyond its seams, too. The shapes are squares of 32 x 32 cells.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "charted_fixture.h"
#include "base/random.h"
#include "base/region.h"
#include "features/surface.h"
#include "fit/fit_context.h"
#include "select/conversion.h"
#include "select/greedy_cover.h"
#include "finish/open_seams.h"
#include "select/selection.h"

enum { CELLS = 32 };
static const psplat_kernel kernel = {2, 2};

/* ---- shapes ---------------------------------------------------------------------------------- */

static void place_dome(double s, double t, double p[3]) {
    place_square(s, t, p);
    p[2] = -0.3 * (p[0] * p[0] + p[1] * p[1]);
}

/* A dome with a crease of 70 degrees along y = 0. */
static void place_roof(double s, double t, double p[3]) {
    place_dome(s, t, p);
    p[2] -= 0.7 * fabs(p[1]);
}

/* Flat up to bend_at from the middle, and from there on bent down. */
static double bend_at, bend;
static void place_bent(double s, double t, double p[3]) {
    place_square(s, t, p);
    double x = max2(p[0] - bend_at, 0);
    p[2] = -bend * x * x / 2;
}

static double jump; /* of coordinates between charts */
static void set_coordinates(const double p[3], int chart, float uv[2]) {
    uv[0] = (float)(p[0] / 4 + jump * chart);
    uv[1] = (float)(p[1] / 4);
}

static void chart_halves(uint32_t triangle, const double p[3], float uv[2]) {
    set_coordinates(p, triangle / 2 % CELLS >= CELLS / 2, uv);
}

/* Borders of charts along x = 0, which the roof's crease meets, and along y = 1/8 beside it. */
static void chart_beside_crease(uint32_t triangle, const double p[3], float uv[2]) {
    int right = triangle / 2 % CELLS >= CELLS / 2, upper = triangle / 2 / CELLS >= CELLS / 2 + 2;
    set_coordinates(p, right + 2 * upper, uv);
}

/* A chart of its own for |x| and |y| below 5/16. */
static void chart_square(uint32_t triangle, const double p[3], float uv[2]) {
    int column = (int)(triangle / 2 % CELLS) - CELLS / 2,
        row = (int)(triangle / 2 / CELLS) - CELLS / 2;
    set_coordinates(p, column >= -5 && column < 5 && row >= -5 && row < 5, uv);
}

/* ---- selections ------------------------------------------------------------------------------ */

typedef struct stage {
    charted c;
    psplat_limits limits;
    psplat_fit_context context;
    psplat_selection selection;
    psplat_candidate *before; /* copies of the candidates, which own nothing */
} stage;

static void stage_begin(stage *s, double tolerance, void (*place)(double s, double t, double p[3]),
                        void (*chart)(uint32_t triangle, const double p[3], float uv[2])) {
    *s = (stage){.before = NULL};
    charted_make(&s->c, CELLS, place, chart);
    charted_build(&s->c, fixture_crease_angle);
    fixture_sample(&s->c.f, 0.01);
    s->limits = (psplat_limits){.tolerance = tolerance,
                                .crease_tolerance = 0.9 * tolerance,
                                .crease_slack = 0.3 * tolerance,
                                .margin = 0.4 * s->c.f.samples.spacing,
                                .proven = 1,
                                .distance = s->c.f.distance};
    s->context = fixture_context(&s->c.f, &s->limits, NULL);
}

/* Remembers the candidates as they are. */
static void remember(stage *s) {
    size_t bytes = s->selection.count * sizeof *s->before;
    free(s->before);
    s->before = malloc(bytes);
    assert_non_null(s->before);
    memcpy(s->before, s->selection.candidates, bytes);
}

static void cover(stage *s) {
    psplat_convert_desc desc = {.seed = 1};
    assert_int_equal(psplat_greedy_cover(&s->context, &desc, &s->selection, NULL), PSPLAT_OK);
    remember(s);
}

/* Opens the seams of candidates that were fitted as they are remembered. */
static void open_seams(stage *s) {
    psplat_region *fitted = malloc((s->selection.count + 1) * sizeof *fitted);
    assert_non_null(fitted);
    for (size_t i = 0; i < s->selection.count; ++i) fitted[i] = s->before[i].region;
    assert_int_equal(psplat_open_seams(&s->context, &kernel, fitted, &s->selection), PSPLAT_OK);
    free(fitted);
}

static void stage_end(stage *s) {
    free(s->before);
    psplat_selection_free(&s->selection);
    charted_free(&s->c);
}

static int count_bits(uint32_t bits) {
    int count = 0;
    for (; bits; bits &= bits - 1) ++count;
    return count;
}

/* Returns whether a line stands among those of a region, with the same bend. */
static int has_line(const psplat_region *region, uint32_t first, uint32_t count,
                    const double line[3], double bend_of_line) {
    for (uint32_t i = first; i < first + count; ++i)
        if (!memcmp(region->lines[i], line, sizeof region->lines[i]) &&
            region->bends[i] == bend_of_line)
            return 1;
    return 0;
}

/* ---- what lies beyond ------------------------------------------------------------------------ */

/* Asserts that random points of all regions are within the tolerance of the mesh, and that each
 * line that there was is a seam or cuts. Returns the number of points beyond seams. */
static size_t check_regions(const stage *s) {
    uint64_t random = 5;
    size_t beyond = 0;
    for (size_t i = 0; i < s->selection.count; ++i) {
        const psplat_region *r = &s->selection.candidates[i].region, *old = &s->before[i].region;
        assert_in_range(r->line_count + r->seam_count, old->line_count, PSPLAT_MAX_CLIP_LINES);
        for (uint32_t k = 0; k < old->line_count; ++k)
            assert_true(
                has_line(r, 0, r->line_count + r->seam_count, old->lines[k], old->bends[k]));
        for (int n = 0; n < 5000 && r->seam_count; ++n) {
            double p[3], uv[2];
            for (int k = 0; k < 2; ++k) uv[k] = 2 * psplat_random_unit(&random) - 1;
            if (!psplat_region_contains(r, uv, 1, 0) || !psplat_region_is_beyond_seam(r, uv))
                continue;
            int near = 0;
            psplat_region_point(r, uv, p);
            /* The bound is proven for all points, up to rounding. */
            assert_int_equal(psplat_distance_within(s->c.f.distance, p, 1,
                                                    s->limits.tolerance * (1 + 1e-9), &near),
                             PSPLAT_OK);
            assert_true(near);
            ++beyond;
        }
    }
    return beyond;
}

/* On a dome nearly all lines at the border become seams, and those at the rim of the square cut. */
static void test_dome(void **state) {
    (void)state;
    stage s;
    size_t charts = 0, others = 0, seams = 0, cuts = 0;
    jump = 0.5;
    stage_begin(&s, 0.02, place_dome, chart_halves);
    assert_int_equal(s.c.f.surface.chart_border_edges, CELLS);
    cover(&s);
    open_seams(&s);
    size_t beyond = check_regions(&s);
    print_message("%zu points beyond seams\n", beyond);
    assert_true(beyond > 200);
    for (size_t i = 0; i < s.selection.count; ++i) {
        const psplat_candidate *c = &s.selection.candidates[i];
        const psplat_region *old = &s.before[i].region;
        assert_int_equal(old->seam_count, 0);
        if (!c->taken) assert_memory_equal(&c->region, old, sizeof *old);
        if (!c->taken) continue;
        charts += (size_t)count_bits(old->chart_lines);
        others += old->line_count - (size_t)count_bits(old->chart_lines);
        seams += c->region.seam_count;
        cuts += c->region.line_count;
        for (uint32_t k = 0; k < old->line_count; ++k)
            if (!(old->chart_lines >> k & 1))
                assert_true(
                    has_line(&c->region, 0, c->region.line_count, old->lines[k], old->bends[k]));
    }
    print_message("%zu of %zu lines at borders of charts are seams; %zu lines cut\n", seams, charts,
                  cuts);
    assert_true(charts >= 4 && others > 4);
    assert_in_range(seams, charts - charts / 4, charts);
    assert_in_range(cuts, others, others + charts);
    stage_end(&s);
}

/* Beside a crease, splats do not go on over it, whether a border of charts meets it or lies beside
 * it, closer than their radii. */
static void test_creases(void **state) {
    (void)state;
    stage s;
    uint64_t random = 6;
    size_t seams = 0;
    jump = 0.5;
    stage_begin(&s, 0.02, place_roof, chart_beside_crease);
    assert_true(s.c.f.surface.crease_edges == CELLS);
    assert_true(s.c.f.surface.chart_border_edges == 2 * CELLS);
    cover(&s);
    open_seams(&s);
    size_t beyond = check_regions(&s);
    print_message("%zu points beyond seams\n", beyond);
    assert_true(beyond > 200);
    /* A line stands up to the slack, 0.3 tolerances, over its crease in the splat's plane, and a
     * crease may be beside it by one tolerance. */
    const double most = 1.3 * s.limits.tolerance;
    for (size_t i = 0; i < s.selection.count; ++i) {
        const psplat_candidate *c = &s.selection.candidates[i];
        int upper = c->triangle / 2 / CELLS >= CELLS / 2;
        seams += c->region.seam_count;
        for (int n = 0; n < 400 && c->region.seam_count; ++n) {
            double p[3], uv[2];
            for (int k = 0; k < 2; ++k) uv[k] = 2 * psplat_random_unit(&random) - 1;
            if (!psplat_region_contains(&c->region, uv, 1, 0)) continue;
            psplat_region_point(&c->region, uv, p);
            assert_true((upper ? p[1] : -p[1]) >= -most);
            assert_true(fabs(p[0]) <= 1 + most && fabs(p[1]) <= 1 + most);
        }
    }
    print_message("%zu seams\n", seams);
    assert_true(seams > 8);
    stage_end(&s);
}

/* ---- what stays ------------------------------------------------------------------------------ */

/* Nothing changes where there are no borders of charts, and where materials keep normal textures.
 */
static void test_left_alone(void **state) {
    (void)state;
    for (int has_normals = 0; has_normals < 2; ++has_normals) {
        stage s;
        jump = has_normals ? 0.5 : 0;
        stage_begin(&s, 0.03, place_dome, chart_halves);
        assert_int_equal(s.c.f.surface.chart_border_edges, has_normals ? CELLS : 0);
        cover(&s);
        for (int k = 0; k < 2 && has_normals; ++k)
            s.c.kept[k].textures[PSPLAT_TEXTURE_NORMAL].image = 1;
        open_seams(&s);
        assert_memory_equal(s.selection.candidates, s.before, s.selection.count * sizeof *s.before);
        /* Without the normal texture they would change. */
        for (int k = 0; k < 2; ++k) s.c.kept[k].textures[PSPLAT_TEXTURE_NORMAL].image = 0;
        open_seams(&s);
        assert_int_equal(
            memcmp(s.selection.candidates, s.before, s.selection.count * sizeof *s.before) != 0,
            has_normals);
        stage_end(&s);
    }
}

/* ---- surfaces that bend away ----------------------------------------------------------------- */

/* Adds a flat disc in the plane z = 0 with so many lines. */
static psplat_candidate *add_disc(stage *s, double x, double radius, uint32_t line_count,
                                  const double (*lines)[3]) {
    uint32_t column = (uint32_t)((x + 1) / 2 * CELLS);
    s->selection = (psplat_selection){calloc(1, sizeof(psplat_candidate)), 1, 1};
    assert_non_null(s->selection.candidates);
    psplat_candidate *c = s->selection.candidates;
    c->region = (psplat_region){.center = {x, 0, 0},
                                .u = {1, 0, 0},
                                .v = {0, 1, 0},
                                .n = {0, 0, 1},
                                .radius = {radius, radius},
                                .line_count = line_count};
    memcpy(c->region.lines, lines, line_count * sizeof *lines);
    c->triangle = 2 * (CELLS / 2 * CELLS + column);
    c->taken = 1;
    remember(s);
    return c;
}

/* Beyond the border the surface goes on by 0.1 and then bends down: the disc ends a little farther
 * on, at a line that stands behind its seam and is parallel to it. */
static void test_cut_beyond(void **state) {
    (void)state;
    stage s;
    const double line[1][3] = {{-1, 0, 0.5}}; /* x <= 0 */
    jump = 0.5;
    for (int bends = 0; bends < 2; ++bends) {
        bend_at = 0.1, bend = bends ? 8 : 0;
        stage_begin(&s, 0.02, place_bent, chart_halves);
        psplat_candidate *c = add_disc(&s, -0.3, 0.6, 1, line);
        open_seams(&s);
        const psplat_region *r = &c->region;
        assert_int_equal(r->seam_count, 1);
        assert_int_equal(r->line_count, bends);
        assert_memory_equal(r->lines[r->line_count], line, sizeof line);
        check_regions(&s);
        if (bends) {
            /* 0.3 from the middle the surface is 0.16 lower. */
            double x = (r->lines[0][2] - 0.5) * 0.6;
            assert_true(r->lines[0][0] == -1 && r->lines[0][1] == 0);
            assert_true(x > 0.75 * s.limits.tolerance && x < 0.2);
        }
        stage_end(&s);
    }
}

/* A seam stands where its line was fitted, at the border, and not where that was moved to; what
 * another line cuts off behind it begins no nearer than where it was moved to. */
static void test_moved_out(void **state) {
    (void)state;
    stage s;
    const double fitted[1][3] = {{-1, 0, 0.5}}; /* x <= 0 */
    const double moved = 0.65 * 0.02 / 0.6;     /* as far as lines are moved, in parameters */
    jump = 0.5;
    for (int bends = 0; bends < 2; ++bends) {
        bend_at = 0.1, bend = bends ? 8 : 0;
        stage_begin(&s, 0.02, place_bent, chart_halves);
        psplat_candidate *c = add_disc(&s, -0.3, 0.6, 1, fitted);
        c->region.lines[0][2] += moved;
        open_seams(&s);
        const psplat_region *r = &c->region;
        assert_int_equal(r->seam_count, 1);
        assert_int_equal(r->line_count, bends);
        assert_memory_equal(r->lines[r->line_count], fitted[0], sizeof fitted[0]);
        if (bends) assert_true(r->lines[0][2] >= fitted[0][2] + moved + 0.75 * 0.02 / 0.6 - 1e-9);
        stage_end(&s);
    }
}

/* A crease of 39 degrees along x = 1/8. */
static void place_edge(double s, double t, double p[3]) {
    place_square(s, t, p);
    p[2] = -0.8 * max2(p[0] - 0.125, 0);
}

/* A crease beyond the border ends the disc before it, though what little there is of the disc over
 * it would be near the surface, 0.012 off. */
static void test_crease_beyond(void **state) {
    (void)state;
    stage s;
    const double radius = 0.24, line[1][3] = {{-1, 0, 0.1 / radius}}; /* x <= 0 */
    jump = 0.5;
    stage_begin(&s, 0.02, place_edge, chart_halves);
    assert_int_equal(s.c.f.surface.crease_edges, CELLS);
    s.limits.margin = 1e-3; /* Most of the rim's samples count, and agree. */
    psplat_candidate *c = add_disc(&s, -0.1, radius, 1, line);
    open_seams(&s);
    const psplat_region *r = &c->region;
    assert_int_equal(r->seam_count, 1);
    assert_int_equal(r->line_count, 1);
    double x = (r->lines[0][2] - line[0][2]) * radius;
    assert_true(x > 0.75 * s.limits.tolerance && x < 0.125);
    check_regions(&s);
    stage_end(&s);
}

/* On a plane, a disc goes on where its normals are those of the plane, and ends beside the border
 * where they lean by 45 degrees there, and more beyond. */
static void test_normals(void **state) {
    (void)state;
    const double line[1][3] = {{-1, 0, 0.5}};
    jump = 0.5, bend = 0;
    for (int leans = 0; leans < 2; ++leans) {
        stage s;
        stage_begin(&s, 0.02, place_bent, chart_halves);
        psplat_candidate *c = add_disc(&s, -0.3, 0.6, 1, line);
        c->field[2] = leans ? 2 : 0;
        open_seams(&s);
        assert_int_equal(c->region.line_count, leans);
        /* It may go on by less than the spacing of samples, where there is none to tell. */
        double x = (c->region.lines[0][2] - line[0][2]) * 0.6;
        if (leans) assert_true(x < s.c.f.samples.spacing);
        stage_end(&s);
    }
}

/* Where a disc has four lines, there is none left for another one beyond: that towards the bend
 * stays, and the others become seams. */
static void test_most_lines(void **state) {
    (void)state;
    stage s;
    const double edge = 5.0 / 16 / 0.45;
    const double lines[4][3] = {{1, 0, edge}, {-1, 0, edge}, {0, 1, edge}, {0, -1, edge}};
    jump = 0.5;
    for (int bends = 0; bends < 2; ++bends) {
        bend_at = 5.0 / 16, bend = bends ? 8 : 0;
        stage_begin(&s, 0.01, place_bent, chart_square);
        /* Beyond the seams there is little more than the rim of the disc. */
        s.limits.margin = 1e-3;
        assert_int_equal(s.c.f.surface.chart_border_edges, 40);
        psplat_candidate *c = add_disc(&s, 0, 0.45, 4, lines);
        open_seams(&s);
        const psplat_region *r = &c->region;
        assert_int_equal(r->line_count + r->seam_count, 4);
        assert_int_equal(r->line_count, bends);
        if (bends) assert_memory_equal(r->lines[0], lines[1], sizeof lines[1]);
        for (int k = 0; k < 4; ++k)
            assert_true(has_line(r, r->line_count, r->seam_count, lines[k], 0) ||
                        (bends && k == 1));
        check_regions(&s);
        stage_end(&s);
    }
}

/* ---- threads --------------------------------------------------------------------------------- */

static void test_threads(void **state) {
    (void)state;
    stage s;
    jump = 0.5;
    stage_begin(&s, 0.01, place_roof, chart_beside_crease);
    cover(&s);
    size_t count = s.selection.count;
    psplat_region *first = malloc(count * sizeof *first);
    assert_non_null(first);
    fixture_threads(1);
    open_seams(&s);
    for (size_t i = 0; i < count; ++i) first[i] = s.selection.candidates[i].region;
    memcpy(s.selection.candidates, s.before, count * sizeof *s.before);
    fixture_threads(3);
    open_seams(&s);
    fixture_threads(0);
    for (size_t i = 0; i < count; ++i) {
        const psplat_region *r = &s.selection.candidates[i].region;
        assert_int_equal(r->line_count, first[i].line_count);
        assert_int_equal(r->seam_count, first[i].seam_count);
        assert_memory_equal(r->lines, first[i].lines, sizeof r->lines);
        assert_memory_equal(r->bends, first[i].bends, sizeof r->bends);
    }
    free(first);
    stage_end(&s);
}

int test_open_seams_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_dome),       cmocka_unit_test(test_creases),
        cmocka_unit_test(test_left_alone), cmocka_unit_test(test_moved_out),
        cmocka_unit_test(test_cut_beyond), cmocka_unit_test(test_crease_beyond),
        cmocka_unit_test(test_normals),    cmocka_unit_test(test_most_lines),
        cmocka_unit_test(test_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

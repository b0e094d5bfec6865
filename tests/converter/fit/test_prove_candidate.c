/* SPDX-License-Identifier: MIT
 *
 * test_prove_candidate.c - tests that what grows is proven: all of a candidate is near the mesh by
 * the division that the check makes, and it covers its seed, however far its draft went astray.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "charted_fixture.h"
#include "fit/candidate.h"
#include "fit/fit_context.h"
#include "fit/grow_candidate.h"
#include "fit/nearness.h"
#include "measure/splat_distance.h"

enum { SEEDS = 60 };

static int covers(const psplat_candidate *candidate, uint32_t sample) {
    for (size_t i = 0; i < candidate->covered_count; ++i)
        if (candidate->covered[i] == sample) return 1;
    return 0;
}

/* Grows candidates from all over a model whose drafts may use so much of the tolerance. Returns the
 * mean area of those that are at least as large as a disc of the last resort. */
static double grow_all(const fixture *f, psplat_limits limits, double draft_part) {
    psplat_scratch scratch = {0};
    double area = 0;
    limits.measured_tolerance = draft_part * limits.tolerance;
    const psplat_fit_context context = fixture_context(f, &limits, &scratch);
    const psplat_splat_distance_desc desc = {.tolerance = limits.tolerance * (1 + 1e-9)};
    for (size_t i = 0; i < SEEDS; ++i) {
        uint32_t seed = (uint32_t)(i * f->samples.count / SEEDS);
        psplat_candidate c;
        psplat_splat_distance measured;
        assert_int_equal(psplat_candidate_grow(&context, seed, &c), PSPLAT_OK);
        assert_true(covers(&c, seed));
        assert_int_equal(psplat_splat_distance_find(&c.region, f->distance, &desc, &measured),
                         PSPLAT_OK);
        assert_int_equal(measured.nearness, PSPLAT_NEARNESS_WITHIN);
        area += psplat_region_area(&c.region) / SEEDS;
        psplat_candidate_free(&c);
    }
    psplat_scratch_free(&scratch);
    return area;
}

/* Drafts of three times the tolerance are not near, so that nearly all have to shrink. */
static void test_proven(void **state) {
    (void)state;
    const struct {
        const char *name;
        double tolerance, spacing;
    } cases[] = {{"sphere.ply", 0.03, 0.015}, {"torus.off", 0.02, 0.01}, {"part.obj", 0.01, 0.01}};
    for (size_t m = 0; m < sizeof cases / sizeof *cases; ++m) {
        fixture f;
        fixture_model(&f, cases[m].name);
        fixture_sample(&f, cases[m].spacing);
        double tolerance = cases[m].tolerance * f.surface.diagonal;
        const psplat_limits limits = {.tolerance = tolerance,
                                      .crease_tolerance = 0.5 * tolerance,
                                      .crease_slack = 0.3 * tolerance,
                                      .margin = 0.2 * f.samples.spacing,
                                      .proven = 1,
                                      .distance = f.distance};
        double usual = grow_all(&f, limits, 0.95), astray = grow_all(&f, limits, 3);
        print_message("%s: mean areas %g, and %g of drafts gone astray\n", cases[m].name, usual,
                      astray);
        assert_true(usual > 10 * tolerance * tolerance);
        assert_true(astray > 0.1 * usual); /* they shrink; they do not end as discs */
        fixture_free(&f);
    }
}

/* ---- beyond borders of charts ----------------------------------------------------------------
 */

/* A square with a border of charts across its middle, and holes right of that. */
enum { CELLS = 32 };

static void chart_halves(uint32_t triangle, const double p[3], float uv[2]) {
    uv[0] = (float)(p[0] / 4 + (triangle / 2 % CELLS >= CELLS / 2 ? 0.5 : 0));
    uv[1] = (float)(p[1] / 4);
}

/* Leaves out the triangles of cells in so many columns right of the border but for the first, in
 * every second block of so many rows. */
static void cut_holes(charted *c, size_t columns, size_t rows) {
    psplat_mesh *mesh = &c->f.mesh;
    size_t kept = 0;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        size_t column = t / 2 % CELLS, row = t / 2 / CELLS;
        if (column > CELLS / 2 && column <= CELLS / 2 + columns && row / rows % 2) continue;
        memmove(mesh->triangles + 3 * kept, mesh->triangles + 3 * t, 3 * sizeof(uint32_t));
        memmove(mesh->corner_uvs[0] + 6 * kept, mesh->corner_uvs[0] + 6 * t, 6 * sizeof(float));
        ++kept;
    }
    mesh->triangle_count = kept;
}

/* Flat splats beside the border are near the surface as far beyond it as they will be seen, also
 * where holes lie between the points that drafts measure. Rounding to the grid proves that again,
 * and what fails there at every size becomes a small disc. */
static void test_beyond_charts(void **state) {
    (void)state;
    for (size_t columns = 2; columns <= 8; columns *= 2) {
        charted c;
        psplat_scratch scratch = {0};
        charted_make(&c, CELLS, place_square, chart_halves);
        cut_holes(&c, columns, columns);
        charted_build(&c, fixture_crease_angle);
        fixture_sample(&c.f, 0.02);
        const psplat_limits limits = {.tolerance = 0.02,
                                      .crease_tolerance = 0.01,
                                      .crease_slack = 0.006,
                                      .margin = 0.01,
                                      .proven = 1,
                                      .distance = c.f.distance};
        const psplat_fit_context context = fixture_context(&c.f, &limits, &scratch);
        size_t beside = 0;
        double area = 0;
        for (uint32_t seed = 0; seed < c.f.samples.count; seed += 11) {
            psplat_candidate candidate;
            int near;
            if (c.f.samples.positions[3 * (size_t)seed] > 0) continue;
            assert_int_equal(psplat_candidate_grow(&context, seed, &candidate), PSPLAT_OK);
            beside += candidate.region.chart_lines != 0;
            area = max2(area, psplat_region_area(&candidate.region));
            const psplat_region wide = psplat_region_beyond_charts(&candidate.region);
            assert_int_equal(psplat_limits_region_near(&limits, &wide, &near), PSPLAT_OK);
            assert_true(near);
            psplat_candidate_free(&candidate);
        }
        print_message("holes of %zu cells: %zu beside the border, the largest %g\n", columns,
                      beside, area);
        assert_true(beside > 10);
        assert_true(area > 0.2); /* of the half of 2 */
        psplat_scratch_free(&scratch);
        charted_free(&c);
    }
}

int test_prove_candidate_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_proven),
                                       cmocka_unit_test(test_beyond_charts)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_open_charts.c - tests of views of a surface in which borders of charts bound nothing. The
 * shape is a roof with a crease along x = 0, whose texture coordinates jump along y = 0, so that it
 * has four patches, of which the borders of charts divide two halves.
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
#include "features/clusters.h"
#include "features/neighborhood.h"
#include "features/open_charts.h"
#include "features/samples.h"
#include "features/surface.h"

enum { CELLS = 16 };

static void place_roof(double s, double t, double p[3]) {
    place_square(s, t, p);
    p[2] = -fabs(p[0]); /* 90 degrees between the halves */
}

static void chart_with_jump(uint32_t triangle, const double p[3], float uv[2]) {
    int is_upper = triangle / 2 / CELLS >= CELLS / 2;
    uv[0] = (float)(p[0] / 4);
    uv[1] = (float)(p[1] / 4 + (is_upper ? 0.5 : 0));
}

typedef struct stage {
    charted c;
    psplat_open_charts open;
} stage;

static void stage_begin(stage *s) {
    charted_make(&s->c, CELLS, place_roof, chart_with_jump);
    charted_build(&s->c, fixture_crease_angle);
    fixture_sample(&s->c.f, 0.02);
    assert_int_equal(s->c.f.surface.patch_count, 4);
    assert_int_equal(s->c.f.surface.chart_border_edges, CELLS);
    assert_int_equal(s->c.f.surface.crease_edges, CELLS);
}

static void stage_open(stage *s) {
    assert_int_equal(psplat_open_charts_create(&s->c.f.surface, &s->c.f.samples, &s->open), 1);
}

static void stage_end(stage *s) {
    psplat_open_charts_free(&s->open);
    charted_free(&s->c);
}

/* ---- lists ----------------------------------------------------------------------------------- */

static int is_neighbor(const psplat_clusters *c, uint32_t a, uint32_t b) {
    for (uint32_t at = c->first_neighbor[a]; at < c->first_neighbor[a + 1]; ++at)
        if (c->neighbors[at] == b) return 1;
    return 0;
}

static int is_listed(const psplat_clusters *c, uint32_t cluster, uint32_t edge) {
    for (uint32_t at = c->first_crease[cluster]; at < c->first_crease[cluster + 1]; ++at)
        if (c->creases[at] == edge) return 1;
    return 0;
}

/* All edges but borders of charts are what they were; across those, clusters are neighbours, and
 * they stand in no list of creases. */
static void test_lists(void **state) {
    (void)state;
    stage s;
    stage_begin(&s);
    stage_open(&s);
    const psplat_surface *closed = &s.c.f.surface;
    const psplat_clusters *c = &s.open.samples.clusters;
    size_t creases = 0, charts = 0;
    for (uint32_t e = 0; e < 3 * closed->mesh->triangle_count; ++e) {
        uint32_t of = c->of_triangles[e / 3];
        int is_chart = closed->creases[e] == PSPLAT_BOUND_CHART;
        assert_int_equal(s.open.surface.creases[e], is_chart ? 0 : closed->creases[e]);
        assert_int_equal(is_listed(c, of, e), s.open.surface.creases[e] != 0);
        creases += s.open.surface.creases[e] != 0;
        if (!is_chart) continue;
        ++charts;
        assert_true(is_neighbor(c, of, c->of_triangles[closed->neighbors[e]]));
        assert_false(
            is_neighbor(&s.c.f.samples.clusters, of, c->of_triangles[closed->neighbors[e]]));
    }
    assert_int_equal(charts, 2 * CELLS);
    assert_int_equal(creases, 2 * CELLS + 4 * CELLS); /* The crease's both sides, and the rim. */
    assert_int_equal(c->first_crease[c->count], creases);
    stage_end(&s);
}

/* ---- floods ---------------------------------------------------------------------------------- */

/* Counts the samples of a flood from x < 0 and y < 0, by the sign of y, and asserts that it does
 * not cross the crease. Counts the borders of charts and the creases that it meets. */
static void count_gathered(const fixture *f, const psplat_surface *surface,
                           const psplat_samples *samples, size_t counts[2], size_t *charts,
                           size_t *creases) {
    psplat_neighborhood near = {0};
    const psplat_metric metric = {.center = {-0.5, -0.1, -0.5},
                                  .rows = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    /* The triangle at (-0.5, -0.1), whose row and column follow from the grid. */
    uint32_t triangle = 2 * ((CELLS / 2 - 1) * CELLS + CELLS / 4);
    assert_int_equal(psplat_neighborhood_gather(&near, surface, samples, &metric, triangle, 3, 0),
                     1);
    counts[0] = counts[1] = *charts = *creases = 0;
    for (size_t i = 0; i < near.count; ++i) {
        uint32_t t = f->samples.triangles[near.samples[i].index];
        assert_true(t / 2 % CELLS < CELLS / 2);
        ++counts[t / 2 / CELLS >= CELLS / 2];
    }
    for (size_t i = 0; i < near.crease_count; ++i) {
        *charts += f->surface.creases[near.creases[i]] == PSPLAT_BOUND_CHART;
        *creases += f->surface.creases[near.creases[i]] == PSPLAT_BOUND_CREASE;
    }
    psplat_neighborhood_free(&near);
}

/* A flood stays in its half of the roof, and in the open view it goes on over the border of the
 * charts to the half's other part. */
static void test_floods(void **state) {
    (void)state;
    stage s;
    size_t closed[2], open[2], charts, creases, half[2] = {0, 0};
    stage_begin(&s);
    stage_open(&s);
    for (size_t i = 0; i < s.c.f.samples.count; ++i) {
        uint32_t t = s.c.f.samples.triangles[i];
        half[t / 2 / CELLS >= CELLS / 2] += t / 2 % CELLS < CELLS / 2;
    }
    count_gathered(&s.c.f, &s.c.f.surface, &s.c.f.samples, closed, &charts, &creases);
    assert_int_equal(closed[0], half[0]);
    assert_int_equal(closed[1], 0);
    assert_true(charts > 0 && creases > 0);
    count_gathered(&s.c.f, &s.open.surface, &s.open.samples, open, &charts, &creases);
    for (int k = 0; k < 2; ++k) assert_int_equal(open[k], half[k]);
    assert_int_equal(charts, 0);
    /* The half's side of the crease, and its rim: one whole side of the square, and half of two. */
    assert_true(creases >= 3 * CELLS);
    stage_end(&s);
}

/* ---- what stays ------------------------------------------------------------------------------ */

/* Copies count numbers. The caller frees them. */
static uint32_t *copy(const uint32_t *numbers, size_t count) {
    uint32_t *copied = malloc(count * sizeof *numbers);
    assert_non_null(copied);
    memcpy(copied, numbers, count * sizeof *numbers);
    return copied;
}

/* The views share all but edges and lists, which the surface and its samples keep unchanged, also
 * when the views are freed. */
static void test_rest_stays(void **state) {
    (void)state;
    stage s;
    stage_begin(&s);
    const psplat_surface surface = s.c.f.surface;
    const psplat_samples samples = s.c.f.samples;
    const psplat_clusters *c = &s.c.f.samples.clusters;
    size_t edges = 3 * surface.mesh->triangle_count, listed = c->first_crease[c->count],
           linked = c->first_neighbor[c->count];
    uint8_t *kinds = malloc(edges);
    assert_non_null(kinds);
    memcpy(kinds, surface.creases, edges);
    uint32_t *creases = copy(c->creases, listed), *neighbors = copy(c->neighbors, linked);
    stage_open(&s);
    psplat_surface shared = s.open.surface;
    psplat_samples seen = s.open.samples;
    assert_true(shared.creases != surface.creases);
    shared.creases = surface.creases;
    assert_memory_equal(&shared, &surface, sizeof shared);
    assert_true(seen.clusters.neighbors != c->neighbors && seen.clusters.creases != c->creases);
    seen.clusters.first_neighbor = c->first_neighbor, seen.clusters.neighbors = c->neighbors;
    seen.clusters.first_crease = c->first_crease, seen.clusters.creases = c->creases;
    assert_memory_equal(&seen, &samples, sizeof seen);
    psplat_open_charts_free(&s.open);
    assert_null(s.open.surface.creases);
    assert_null(s.open.samples.clusters.neighbors);
    assert_memory_equal(&s.c.f.surface, &surface, sizeof surface);
    assert_memory_equal(&s.c.f.samples, &samples, sizeof samples);
    assert_memory_equal(surface.creases, kinds, edges);
    assert_memory_equal(c->creases, creases, listed * sizeof *creases);
    assert_memory_equal(c->neighbors, neighbors, linked * sizeof *neighbors);
    free(kinds);
    free(creases);
    free(neighbors);
    stage_end(&s);
}

int test_open_charts_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lists),
        cmocka_unit_test(test_floods),
        cmocka_unit_test(test_rest_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_heatmap.c - tests of the heatmaps of distance and normal error. The shapes are square plates
 * at a known distance or angle, so that the colour of every pixel follows from the limits.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "agreement.h"
#include "compare/shape_errors.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "mesh/mesh.h"
#include "views/heatmap.h"
#include "views/legend.h"
#include "views/picture_views.h"
#include "views/picture_views_parts.h"

enum { SIZE = 64, PANELS = 5 };

static const uint8_t zero[3] = {0, 0, 4}, middle[3] = {186, 54, 85}, top[3] = {252, 255, 164},
                     cyan[3] = {0, 220, 220}, grey[3] = {48, 48, 48};

/* A two-sided square in the plane z = slope x + height. */
typedef struct plate {
    double positions[4][3];
    uint32_t triangles[2][3];
    psplat_mesh mesh;
    psplat_source_mesh *original;
} plate;

static void plate_make(plate *p, const double origin[3], double half, double slope, double height) {
    static const uint32_t triangles[2][3] = {{0, 1, 2}, {0, 2, 3}};
    static const double corners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    *p = (plate){
        .mesh = {.vertex_count = 4,
                 .triangle_count = 2,
                 .material = {.base_color = {1, 1, 1, 1}, .roughness = 1, .double_sided = 1}}};
    memcpy(p->triangles, triangles, sizeof triangles);
    for (int i = 0; i < 4; ++i) {
        p->positions[i][0] = half * corners[i][0];
        p->positions[i][1] = half * corners[i][1];
        p->positions[i][2] = slope * half * corners[i][0] + height;
    }
    p->mesh.positions = p->positions[0];
    p->mesh.triangles = p->triangles[0];
    memcpy(p->mesh.origin, origin, sizeof p->mesh.origin);
    assert_int_equal(psplat_source_mesh_create(&p->mesh, 0, &p->original, NULL), PSPLAT_OK);
}

static void plate_free(plate *p) {
    psplat_source_mesh_destroy(p->original);
}

typedef struct drawn {
    psplat_picture_views *views;
    uint8_t *pixels;
    int width, height;
    size_t counts[PANELS][5]; /* pixels of each panel that have one of the colours above */
} drawn;

static void check(psplat_result result, const psplat_error *error) {
    if (result) fail_msg("%s", error->text);
}

/* Returns whether the pixel has the colour, up to 2 steps of 255, since rounding may give a
 * neighbouring colour. */
static int has_color(const uint8_t *pixel, const uint8_t color[3]) {
    for (int c = 0; c < 3; ++c)
        if (abs(pixel[c] - color[c]) > 2) return 0;
    return 1;
}

static void count(drawn *d) {
    const uint8_t *const colors[5] = {zero, middle, top, cyan, grey};
    for (int i = 0; i < PANELS * SIZE * SIZE; ++i)
        for (int k = 0; k < 5; ++k)
            d->counts[i / SIZE % PANELS][k] += (size_t)has_color(d->pixels + 3 * i, colors[k]);
}

static drawn draw(gpu *g, const plate *source, const plate *target, int view,
                  const psplat_heatmap_limits *limits) {
    const psplat_picture_views_desc desc = {
        .host = g->host, .source = source->original, .size = SIZE};
    const psplat_pictured pictured = {.mesh = target->original};
    const psplat_shape_desc reach = {.reach = 100};
    psplat_shape_probe *probe;
    psplat_error error;
    drawn d = {0};
    check(psplat_picture_views_create(&desc, &d.views, &error), &error);
    check(
        psplat_shape_probe_create_mesh(source->original, target->original, &reach, &probe, &error),
        &error);
    check(psplat_picture_views_heatmap(d.views, &pictured, probe, view, limits, &d.pixels, &d.width,
                                       &d.height, &error),
          &error);
    assert_int_equal(d.width, PANELS * SIZE);
    assert_int_equal(d.height, SIZE + psplat_legend_height(SIZE));
    count(&d);
    psplat_shape_probe_destroy(probe);
    return d;
}

static size_t covered_in(const drawn *d, int view) {
    const uint8_t *picture =
        d->views->pictures + (size_t)view * psplat_picture_views_bytes(d->views);
    size_t covered = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) covered += picture[4 * i + 3] != 0;
    return covered;
}

static void drawn_free(drawn *d) {
    psplat_picture_views_destroy(d->views);
    free(d->pixels);
}

/* A larger plate lies at half of the distance limit: every pixel that shows the source has the
 * middle colour, and normals are those of the source. This holds from all sides, also far from the
 * origin. */
static void test_distance(void **state) {
    static const double origins[2][3] = {{0, 0, 0}, {1e6, -2e6, 1e6}};
    for (int i = 0; i < 2; ++i)
        for (int view = i; view < PSPLAT_PICTURE_VIEWS; view += 4) {
            plate source, target;
            plate_make(&source, origins[i], 1, 0, 0);
            plate_make(&target, origins[i], 2, 0, 0.02);
            double diagonal = 2 * sqrt(2);
            const psplat_heatmap_limits limits = {1, 100 * 0.04 / diagonal, 90};
            drawn d = draw(*state, &source, &target, view, &limits);
            size_t covered = covered_in(&d, view);
            assert_in_range(covered, 200, SIZE * SIZE);
            assert_int_equal(d.counts[3][1], covered);
            assert_int_equal(d.counts[3][4], SIZE * SIZE - covered);
            assert_int_equal(d.counts[4][0], covered);
            assert_int_equal(d.counts[4][4], SIZE * SIZE - covered);
            drawn_free(&d);
            plate_free(&source);
            plate_free(&target);
        }
}

/* A smaller plate is turned by half of the angle limit; nothing is seen beyond it. */
static void test_angle(void **state) {
    const double origin[3] = {0, 0, 0};
    plate source, target;
    plate_make(&source, origin, 1, 0, 0);
    plate_make(&target, origin, 0.5, tan(10 * CAMERA_PI / 180), 0);
    const psplat_heatmap_limits limits = {50, 0.001, 20};
    drawn d = draw(*state, &source, &target, 0, &limits);
    size_t covered = covered_in(&d, 0), seen = d.counts[4][1];
    /* The plate fills a quarter of the source, but for pixels at its edge. */
    assert_in_range(seen, covered / 5, covered / 3);
    assert_int_equal(seen + d.counts[4][3], covered);
    /* Nearly every pixel is beyond the distance limit. */
    assert_in_range(d.counts[3][2], covered * 9 / 10, covered);
    drawn_free(&d);
    plate_free(&source);
    plate_free(&target);
}

static void test_panels(void **state) {
    const double origin[3] = {0, 0, 0};
    plate source, target;
    plate_make(&source, origin, 1, 0, 0);
    plate_make(&target, origin, 0.5, 0, 0);
    /* With a picture limit of 0 each pixel is at either end of the scale. */
    const psplat_heatmap_limits limits = {0, 1, 1};
    drawn d = draw(*state, &source, &target, 2, &limits);
    const uint8_t *picture = d.views->pictures + 2 * psplat_picture_views_bytes(d.views);
    size_t source_only = 0;
    for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x) {
            const uint8_t *row = d.pixels + 3 * PANELS * SIZE * (SIZE - 1 - y);
            const uint8_t *a = picture + 4 * (y * SIZE + x),
                          *b = d.views->shown + 4 * (y * SIZE + x);
            assert_memory_equal(row + 3 * x, a, 3);
            assert_memory_equal(row + 3 * (SIZE + x), b, 3);
            source_only += a[3] && !b[3];
        }
    assert_true(source_only > 100);
    assert_int_equal(d.counts[2][2], source_only);
    assert_int_equal(d.counts[2][0], covered_in(&d, 2) - source_only);
    drawn_free(&d);
    plate_free(&source);
    plate_free(&target);
}

static void test_arguments(void **state) {
    gpu *g = *state;
    const double origin[3] = {0, 0, 0};
    plate p;
    plate_make(&p, origin, 1, 0, 0);
    const psplat_heatmap_limits limits = {1, 1, 1};
    drawn d = draw(g, &p, &p, 0, &limits);
    const psplat_pictured pictured = {.mesh = p.original}, nothing = {0};
    const psplat_shape_desc reach = {.reach = 1};
    psplat_shape_probe *probe;
    psplat_error error;
    check(psplat_shape_probe_create_mesh(p.original, p.original, &reach, &probe, &error), &error);
    const struct {
        const psplat_pictured *pictured;
        const psplat_shape_probe *probe;
        int view;
    } wrong[] = {{&pictured, probe, -1},
                 {&pictured, probe, PSPLAT_PICTURE_VIEWS},
                 {&pictured, NULL, 0},
                 {&nothing, probe, 0}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        uint8_t *pixels = (uint8_t *)&d;
        assert_int_equal(psplat_picture_views_heatmap(d.views, wrong[i].pictured, wrong[i].probe,
                                                      wrong[i].view, &limits, &pixels, &d.width,
                                                      &d.height, &error),
                         PSPLAT_ERROR_ARGUMENT);
        assert_null(pixels);
    }
    psplat_shape_probe_destroy(probe);
    drawn_free(&d);
    plate_free(&p);
}

int test_heatmap_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_distance),
        cmocka_unit_test(test_angle),
        cmocka_unit_test(test_panels),
        cmocka_unit_test(test_arguments),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", tests, gpu_setup_gles, gpu_teardown);
}

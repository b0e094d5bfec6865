/* SPDX-License-Identifier: MIT
 *
 * test_picture_views.c - tests of the views in which pictures are compared, of the source's
 * pictures, and of the errors of a mesh or of splats that are drawn in its place. Models are
 * bundled ones; expected values are the geometry of the icosahedron's axes, zero errors of the
 * source against itself, and the order of errors between finer and coarser splats.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "agreement.h"
#include "views/image_metrics.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "export/glb_writer.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "views/picture_views.h"
#include "views/picture_views_parts.h"
#include "near.h"

enum { SIZE = 96 };

static const double degree = CAMERA_PI / 180;

typedef struct pictured_source {
    psplat_mesh mesh;
    psplat_source_mesh *source;
    psplat_picture_views *views;
} pictured_source;

static void check(psplat_result result, const psplat_error *error) {
    if (result) fail_msg("%s", error->text);
}

static void open_source(pictured_source *r, const char *model) {
    char path[512];
    psplat_error error;
    *r = (pictured_source){0};
    snprintf(path, sizeof path, PSPLAT_SOURCE_DIR "/samples/models/%s", model);
    check(psplat_mesh_read(path, &r->mesh, &error), &error);
    check(psplat_source_mesh_create(&r->mesh, 0, &r->source, &error), &error);
}

static void open_views(gpu *g, pictured_source *r, int size) {
    const psplat_picture_views_desc desc = {.host = g->host, .source = r->source, .size = size};
    psplat_error error;
    check(psplat_picture_views_create(&desc, &r->views, &error), &error);
}

static void close_source(pictured_source *r) {
    psplat_picture_views_destroy(r->views);
    psplat_source_mesh_destroy(r->source);
    psplat_mesh_free(&r->mesh);
}

static const uint8_t *picture_at(const pictured_source *r, int view) {
    return r->views->pictures + (size_t)view * psplat_picture_views_bytes(r->views);
}

static psplat_picture_errors compare(const pictured_source *r, const psplat_pictured *pictured,
                                     int view) {
    psplat_picture_errors errors;
    psplat_error error;
    check(psplat_picture_views_compare(r->views, pictured, view, &errors, &error), &error);
    return errors;
}

/* ---- views ----------------------------------------------------------------------------------- */

static void sort3(double a[3]) {
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 2 - i; ++k)
            if (a[k] > a[k + 1]) {
                double t = a[k];
                a[k] = a[k + 1];
                a[k + 1] = t;
            }
}

static double angle_between(const double a[3], const double b[3]) {
    return acos(fmin(1, a[0] * b[0] + a[1] * b[1] + a[2] * b[2])) / degree;
}

/* Stores the direction from the source's centre to the view's eye. */
static void direction_of(const pictured_source *r, int index, double direction[3]) {
    psplat_view view = psplat_picture_views_at(r->views, index);
    for (int i = 0; i < 3; ++i) direction[i] = view.view[4 * i + 2];
}

static void test_views(void **state) {
    pictured_source r;
    double nearest = 180, directions[PSPLAT_PICTURE_VIEWS][3], parts[PSPLAT_PICTURE_VIEWS][3];
    open_source(&r, "cube.off");
    open_views(*state, &r, 16);
    for (int i = 0; i < PSPLAT_PICTURE_VIEWS; ++i) {
        direction_of(&r, i, directions[i]);
        for (int k = 0; k < 3; ++k) parts[i][k] = fabs(directions[i][k]);
        sort3(parts[i]);
        assert_true(acos(parts[i][2]) > 11 * degree); /* angle from the nearest axis */
        assert_true(asin(parts[i][0]) > 7 * degree);  /* angle from the nearest coordinate plane */
        for (int k = 0; k < i; ++k) {
            double angle = angle_between(directions[i], directions[k]);
            nearest = fmin(nearest, angle);
            /* The symmetries of a cube map no view close to another one, except to its opposite. */
            if (angle < 179) assert_true(angle_between(parts[i], parts[k]) > 7);
        }
    }
    assert_near(nearest, 63.4349, 0.001); /* degrees between neighbouring axes of an icosahedron */
    close_source(&r);
}

static void test_pictures(void **state) {
    static const char *const models[] = {"part.obj", "torus.off", "sphere.ply", "slab.ply"};
    for (size_t m = 0; m < sizeof models / sizeof *models; ++m) {
        pictured_source r;
        open_source(&r, models[m]);
        open_views(*state, &r, SIZE);
        for (int i = 0; i < PSPLAT_PICTURE_VIEWS; ++i) {
            const uint8_t *picture = picture_at(&r, i);
            int covered = 0;
            for (int y = 0; y < SIZE; ++y)
                for (int x = 0; x < SIZE; ++x) {
                    if (!picture[4 * (y * SIZE + x) + 3]) continue;
                    ++covered;
                    /* Each side has a margin of a fortieth of the picture. */
                    assert_true(x > 1 && y > 1 && x < SIZE - 2 && y < SIZE - 2);
                }
            assert_true(covered > SIZE * SIZE / 50);
            for (int k = 0; k < i; ++k)
                assert_memory_not_equal(picture, picture_at(&r, k), 4 * SIZE * SIZE);
        }
        close_source(&r);
    }
}

/* ---- pictures of meshes and of splats -------------------------------------------------------- */

static void test_itself(void **state) {
    pictured_source r;
    open_source(&r, "painted.glb");
    open_views(*state, &r, SIZE);
    const psplat_pictured pictured = {.mesh = r.source};
    for (int view = -1; view < 2; ++view) {
        psplat_picture_errors e = compare(&r, &pictured, view);
        assert_true(isinf(e.psnr));
        assert_near(e.ssim, 1, 1e-12);
        assert_near(e.difference + e.inside + e.missing + e.extra, 0, 0);
        assert_true(e.covered > 0);
    }
    close_source(&r);
}

static void test_far_away(void **state) {
    pictured_source here, there;
    static const double offset[3] = {1e6, -1e6, 2e6};
    open_source(&here, "torus.off");
    open_source(&there, "torus.off");
    psplat_source_mesh_destroy(there.source);
    for (int i = 0; i < 3; ++i) there.mesh.origin[i] += offset[i];
    assert_int_equal(psplat_source_mesh_create(&there.mesh, 0, &there.source, NULL), PSPLAT_OK);
    open_views(*state, &here, SIZE);
    open_views(*state, &there, SIZE);
    size_t moved = 0;
    int most = 0;
    for (int i = 0; i < PSPLAT_PICTURE_VIEWS; ++i) {
        const uint8_t *a = picture_at(&here, i), *b = picture_at(&there, i);
        for (int k = 0; k < 4 * SIZE * SIZE; k += 4) {
            if (a[k + 3] != b[k + 3]) ++moved;
            if (a[k + 3] && b[k + 3] && abs(a[k] - b[k]) > most) most = abs(a[k] - b[k]);
        }
    }
    /* The eye is off by 1e-10 there, so that practically no pixel centre is close enough to an edge
     * to change sides, and a colour differs by one rounding at most. */
    assert_int_equal(moved, 0);
    assert_in_range(most, 0, 1);
    /* A mesh that is moved by 2 % of the diagonal differs. */
    psplat_mesh moved_mesh = here.mesh;
    psplat_source_mesh *other;
    moved_mesh.origin[0] += 0.04 * here.source->radius;
    assert_int_equal(psplat_source_mesh_create(&moved_mesh, 0, &other, NULL), PSPLAT_OK);
    psplat_picture_errors e = compare(&here, &(psplat_pictured){.mesh = other}, -1);
    assert_true(e.missing > 1 && e.missing < 10 && fabs(e.extra - e.missing) < 1);
    assert_true(e.psnr < 25 && e.ssim < 0.95);
    psplat_source_mesh_destroy(other);
    close_source(&here);
    close_source(&there);
}

/* Returns a model of splats converted from the source. */
static psplat_model *convert(gpu *g, const pictured_source *r, double tolerance) {
    const psplat_convert_desc desc = {.tolerance_percent = tolerance, .effort = PSPLAT_EFFORT_NONE};
    psplat_splats splats;
    psplat_asset *asset;
    psplat_model *model;
    psplat_error error;
    uint8_t *data;
    size_t size;
    check(psplat_convert(&r->mesh, &desc, &splats, NULL, &error), &error);
    check(psplat_glb_write(&splats, NULL, NULL, &data, &size, &error), &error);
    check(psplat_asset_open_memory(data, size, NULL, &asset, &error), &error);
    check(psplat_model_create(g->renderer, asset, &model, &error), &error);
    psplat_asset_destroy(asset);
    psplat_splats_free(&splats);
    free(data);
    return model;
}

static void test_splats(void **state) {
    gpu *g = *state;
    pictured_source r;
    psplat_picture_errors e[3][2];
    open_source(&r, "torus.off");
    open_views(g, &r, SIZE);
    psplat_model *models[2] = {convert(g, &r, 3), convert(g, &r, 1)};
    for (int mode = 0; mode < 3; ++mode)
        for (int i = 0; i < 2; ++i) {
            const psplat_pictured pictured = {
                .renderer = g->renderer, .model = models[i], .mode = (psplat_mode)mode};
            e[mode][i] = compare(&r, &pictured, -1);
            print_message("mode %d, model %d: %5.2f dB, SSIM %.3f, %.2f (%.2f) %%, missing %.2f, "
                          "extra %.2f %%\n",
                          mode, i, e[mode][i].psnr, e[mode][i].ssim, e[mode][i].difference,
                          e[mode][i].inside, e[mode][i].missing, e[mode][i].extra);
            assert_true(e[mode][i].inside < e[mode][i].difference);
            assert_int_equal(e[mode][i].covered, e[0][0].covered);
        }
    /* Finer splats are nearer to the source, and so is each mode than the next one (BSK04 figure
     * 9). */
    for (int mode = 0; mode < 3; ++mode) {
        assert_true(e[mode][1].inside < e[mode][0].inside && e[mode][1].ssim > e[mode][0].ssim);
        assert_true(e[mode][1].extra < e[mode][0].extra && e[mode][1].psnr > e[mode][0].psnr);
    }
    for (int i = 0; i < 2; ++i)
        for (int mode = 1; mode < 3; ++mode)
            assert_true(e[mode - 1][i].inside < e[mode][i].inside &&
                        e[mode - 1][i].ssim > e[mode][i].ssim);
    /* The measures of single views add up to that of all views. */
    const psplat_pictured pictured = {.renderer = g->renderer, .model = models[1]};
    double missing = 0;
    size_t covered = 0;
    for (int i = 0; i < PSPLAT_PICTURE_VIEWS; ++i) {
        psplat_picture_errors one = compare(&r, &pictured, i);
        missing += one.missing * (double)one.covered;
        covered += one.covered;
    }
    assert_int_equal(covered, e[0][1].covered);
    assert_near(missing / (double)covered, e[0][1].missing, 1e-9);
    for (int i = 0; i < 2; ++i) psplat_model_destroy(g->renderer, models[i]);
    close_source(&r);
}

/* ---- the rest of the interface --------------------------------------------------------------- */

static void test_draw_original(void **state) {
    gpu *g = *state;
    pictured_source r;
    static const float nothing[4] = {0};
    static uint8_t drawn[4 * SIZE * SIZE];
    psplat_error error;
    open_source(&r, "part.obj");
    open_views(g, &r, SIZE);
    psplat_view view = psplat_picture_views_at(r.views, 3);
    check(psplat_host_begin(g->host, SIZE, SIZE, 0, nothing, &error), &error);
    check(psplat_picture_views_draw_source(r.views, &view, &error), &error);
    check(psplat_host_read_rgba8(g->host, drawn, &error), &error);
    assert_memory_equal(drawn, picture_at(&r, 3), sizeof drawn);
    view.lights[0].type = PSPLAT_LIGHT_SPOT;
    assert_int_equal(psplat_picture_views_draw_source(r.views, &view, &error),
                     PSPLAT_ERROR_ARGUMENT);
    close_source(&r);
}

static void test_arguments(void **state) {
    gpu *g = *state;
    pictured_source r;
    psplat_picture_errors errors;
    psplat_error error;
    open_source(&r, "cube.off");
    open_views(g, &r, 16);
    const psplat_pictured cube = {.mesh = r.source}, nothing = {.renderer = g->renderer};
    assert_int_equal(
        psplat_picture_views_compare(r.views, &cube, PSPLAT_PICTURE_VIEWS, &errors, &error),
        PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_picture_views_compare(r.views, &nothing, 0, &errors, &error),
                     PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_picture_views_compare(r.views, &cube, 0, &errors, &error), PSPLAT_OK);
    psplat_picture_views *none = r.views;
    const psplat_picture_views_desc descs[] = {{.source = r.source, .size = 16},
                                               {.host = g->host, .size = 16},
                                               {.host = g->host, .source = r.source, .size = -1},
                                               {.host = g->host, .source = r.source, .size = 8193}};
    for (size_t i = 0; i < sizeof descs / sizeof *descs; ++i) {
        assert_int_equal(psplat_picture_views_create(&descs[i], &none, &error),
                         PSPLAT_ERROR_ARGUMENT);
        assert_null(none);
    }
    psplat_picture_views_destroy(NULL);
    close_source(&r);
}

int test_picture_views_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_views),     cmocka_unit_test(test_pictures),
        cmocka_unit_test(test_itself),    cmocka_unit_test(test_far_away),
        cmocka_unit_test(test_splats),    cmocka_unit_test(test_draw_original),
        cmocka_unit_test(test_arguments),
    };
    /* test_mesh_renderer.c tests the calls of GL that these tests share. */
    const struct CMUnitTest again[] = {cmocka_unit_test(test_itself),
                                       cmocka_unit_test(test_draw_original)};
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", again, gpu_setup_gles, gpu_teardown);
}

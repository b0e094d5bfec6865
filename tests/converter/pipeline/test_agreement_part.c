/* SPDX-License-Identifier: MIT
 *
 * test_agreement_part.c - tests that the renderer agrees with the reference rasteriser on a real
 * conversion, that of the bundled machined part, in all modes and with the filter.
 */
#include "agreement.h"
#include "export/glb_writer.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"

#include <phongsplat/host.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

static psplat_asset *convert_part(double tolerance_percent) {
    psplat_mesh mesh;
    psplat_splats splats;
    psplat_asset *asset = NULL;
    uint8_t *data = NULL;
    size_t size = 0;
    psplat_error error;
    const psplat_convert_desc desc = {.tolerance_percent = tolerance_percent};
    assert_int_equal(psplat_mesh_read(PSPLAT_SOURCE_DIR "/samples/models/part.obj", &mesh, &error),
                     PSPLAT_OK);
    assert_int_equal(psplat_convert(&mesh, &desc, &splats, NULL, &error), PSPLAT_OK);
    assert_int_equal(psplat_glb_write(&splats, "part", NULL, &data, &size, &error), PSPLAT_OK);
    assert_int_equal(psplat_asset_open_memory(data, size, NULL, &asset, &error), PSPLAT_OK);
    free(data);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
    return asset;
}

/* Returns a view from outside, `distance` half diagonals away in the direction `from`, with most of
 * the part inside the picture. */
static psplat_view view_of(const psplat_asset *asset, const double from[3], double distance) {
    psplat_view view = camera_view(160, 120);
    double low[3], high[3], eye[3], middle[3], size2 = 0, from2 = 0;
    psplat_asset_bounds(asset, low, high);
    for (int i = 0; i < 3; ++i) {
        size2 += (high[i] - low[i]) * (high[i] - low[i]) / 4;
        from2 += from[i] * from[i];
    }
    double radius = sqrt(size2);
    for (int i = 0; i < 3; ++i) {
        middle[i] = (low[i] + high[i]) / 2;
        eye[i] = middle[i] + from[i] * distance * radius / sqrt(from2);
        view.lights[0].direction[i] = (float)-from[i];
        view.ambient[i] = 0.1f;
    }
    view.lights[0].direction[0] -= 1;
    camera_look(&view, eye, middle);
    camera_perspective(&view, 75 * distance, (distance - 1) * radius, (distance + 1) * radius);
    return view;
}

static void check(gpu *g, const psplat_asset *asset, const double from[3]) {
    /* The tolerances are those of test_agreement_curved.c, for splats as large as a fifth of their
     * distance: (2 / 5)^2 of epsilon. Window depth is off by 2.1e-6 in one pixel beside a contour,
     * where it changes by 0.02 to 0.04 to the next ones: by 5e-5 of a pixel. */
    const agreement_ties ties = {2e-4, 2e-6, 0.16};
    psplat_view view = view_of(asset, from, 4);
    agreement phong =
        agreement_measure_modes(g, asset, NULL, &view, 1u << PSPLAT_MODE_PHONG, 1, &ties);
    print_message("phong alone: covered %zu skipped %zu\n", phong.covered, phong.skipped);
    assert_true(phong.skipped * 5 < phong.covered); /* Most pixels must be compared. */
    /* Where splats lie in one plane it is undefined which one is nearest; the mode of parameters
     * skips such pixels. Beside contours depth changes much from pixel to pixel (thin pixels). */
    agreement a = agreement_measure_modes(g, asset, NULL, &view, AGREEMENT_ALL_MODES, 1, &ties);
    print_message("covered %zu skipped %zu mismatches %zu other %zu uv %.1e (thin %.1e) depth %.1e "
                  "(thin %.1e) color %.1e\n",
                  a.covered, a.skipped, a.mismatches, a.other, a.uv, a.thin_uv, a.depth,
                  a.thin_depth, a.color);
    /* The view fits the bounds of unclipped splats, which at this tolerance are much larger. */
    assert_true(a.covered > PSPLAT_MODE_COUNT * 1000);
    assert_int_equal(a.mismatches, 0);
    assert_int_equal(a.other, 0);
    assert_true(a.uv <= 5e-5 && a.thin_uv <= 5e-4);
    assert_true(a.depth <= 3e-6 && a.thin_depth <= 2e-5);
    assert_true(a.color <= 1e-4);
}

/* Tests the filter of spec 5.8, close up and from so far that splats are smaller than a pixel, with
 * creases between soft clip lines. */
static void check_filter(gpu *g, const psplat_asset *asset, const double from[3], double pixels) {
    const agreement_ties ties = {2e-4, 2e-6, 0.16};
    psplat_view view = view_of(asset, from, 6);
    view.no_filter = 0;
    view.projection[0] *= pixels / 150; /* of 150 pixels across */
    view.projection[5] *= pixels / 150;
    for (int mode = PSPLAT_MODE_PHONG; mode <= PSPLAT_MODE_GAUSSIAN; ++mode) {
        view.mode = (psplat_mode)mode;
        agreement a = agreement_measure(g, asset, NULL, &view, 1, &ties);
        print_message("filtered, %g px: covered %zu skipped %zu mismatches %zu depth %.1e "
                      "(thin %.1e) color %.1e\n",
                      pixels, a.covered, a.skipped, a.mismatches, a.depth, a.thin_depth, a.color);
        assert_true((double)a.covered > 0.04 * pixels * pixels && a.skipped * 3 < a.covered);
        assert_int_equal(a.mismatches, 0);
        /* Where a splat covers single pixels, its position error is multiplied by the depth per
         * pixel. */
        assert_true(a.depth <= 2e-6 && a.thin_depth <= 5e-6 && a.color <= 1e-4);
    }
}

static void test_filtered_part(void **state) {
    (void)state;
    gpu g = gpu_open(PSPLAT_API_GL);
    psplat_asset *asset = convert_part(2);
    const double pixels[] = {150, 40, 12};
    for (int k = 0; k < 3; ++k) {
        check_filter(&g, asset, (double[]){1, 2, 3}, pixels[k]);
        check_filter(&g, asset, (double[]){-3, 1, -1}, pixels[k]);
    }
    psplat_asset_destroy(asset);
    gpu_close(&g);
}

static void test_part(void **state) {
    (void)state;
    gpu g = gpu_open(PSPLAT_API_GL);
    psplat_asset *asset = convert_part(2);
    check(&g, asset, (double[]){1, 2, 3});
    check(&g, asset, (double[]){-3, 1, -1});
    check(&g, asset, (double[]){0.5, -3, 1});
    psplat_asset_destroy(asset);
    gpu_close(&g);
}

/* Tests that no splat of a coarser conversion is lost to single precision in any of many views:
 * large splats are close to the eye, and in some view a contour lies close beside a pixel. */
static void test_part_from_all_sides(void **state) {
    (void)state;
    gpu g = gpu_open(PSPLAT_API_GL);
    psplat_asset *asset = convert_part(2.8);
    const agreement_ties ties = {2e-4, 2e-6, 0.16};
    uint32_t seed = 5;
    agreement a = {0};
    for (int k = 0; k < 24; ++k) {
        double from[3];
        for (int i = 0; i < 3; ++i) from[i] = 2 * (double)scene_random(&seed) - 1;
        psplat_view view = view_of(asset, from, 4);
        agreement one =
            agreement_measure_modes(&g, asset, NULL, &view, 1u << PSPLAT_MODE_PARAMETERS, 1, &ties);
        agreement_add(&a, &one);
    }
    print_message("24 views: covered %zu skipped %zu mismatches %zu other %zu uv %.1e (thin %.1e) "
                  "depth %.1e (thin %.1e)\n",
                  a.covered, a.skipped, a.mismatches, a.other, a.uv, a.thin_uv, a.depth,
                  a.thin_depth);
    assert_true(a.skipped * 2 < a.covered);
    assert_int_equal(a.mismatches, 0);
    assert_int_equal(a.other, 0);
    assert_true(a.uv <= 5e-5 && a.thin_uv <= 5e-4);
    /* Window depth as in the near views of test_agreement_curved.c. */
    assert_true(a.depth <= 2e-6 && a.thin_depth <= 2e-5);
    psplat_asset_destroy(asset);
    gpu_close(&g);
}

int test_agreement_part_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_part),
                                       cmocka_unit_test(test_part_from_all_sides),
                                       cmocka_unit_test(test_filtered_part)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

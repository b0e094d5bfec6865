/* SPDX-License-Identifier: MIT
 *
 * test_alpha_mask.c - tests that an alpha mask cuts the mesh: hidden parts are gone, the cut is a
 * clean border, and splats end there. The masks are a disc, noise, and an image that is wholly
 * transparent; expected areas and radii are those of the disc.
 */
#include "appearance_fixture.h"

#include "features/surface_build.h"
#include "appearance/alpha_mask.h"
#include "features/surface.h"
#include "material/source_materials.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"
#include "near.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIZE = 128 };

/* Gives a disc whose radius is 0.7 of the square's half side, with an edge four texels wide. */
static void disc(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    double dx = (x + 0.5) / SIZE * 2 - 1, dy = (y + 0.5) / SIZE * 2 - 1;
    double alpha = 0.5 + (0.7 - hypot(dx, dy)) * SIZE / 8;
    rgba[0] = rgba[1] = rgba[2] = 200;
    rgba[3] = (uint8_t)(255 * fmin(fmax(alpha, 0), 1));
}

static void nothing(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)x, (void)y;
    memset(rgba, 0, 4);
}

static void noise(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    uint64_t random = (x * 2654435761u + y * 40503u + 7) * 6364136223846793005u;
    memset(rgba, 255, 3);
    rgba[3] = (uint8_t)(random >> 56);
}

static void make_masked(painted *p, size_t cells,
                        void (*pixel)(uint32_t x, uint32_t y, uint8_t rgba[4])) {
    painted_make(p, cells, SIZE, pixel);
    p->source_material.base_color =
        (psplat_texture_info){.image = &p->image, .wrap = {PSPLAT_WRAP_CLAMP, PSPLAT_WRAP_CLAMP}};
    p->source_material.is_masked = 1;
    p->source_material.alpha_cutoff = 0.5f;
}

static double area_of(const psplat_mesh *mesh) {
    psplat_surface surface;
    assert_int_equal(psplat_surface_build(mesh, PSPLAT_NO_CREASES, &surface, NULL), PSPLAT_OK);
    double area = surface.area;
    psplat_surface_free(&surface);
    return area;
}

/* Every border vertex lies on the circle, and every inner edge has two triangles, so that there are
 * no T-junctions. */
static void test_disc(void **state) {
    (void)state;
    for (size_t cells = 1; cells <= 3; ++cells) {
        painted p;
        psplat_mesh shown;
        size_t borders;
        make_masked(&p, cells, disc);
        p.mesh.both_sides = calloc(1, 1);
        p.mesh.both_sides_count = 1;
        assert_non_null(p.mesh.both_sides);
        p.mesh.both_sides[0] = cells > 1;
        assert_true(psplat_alpha_mask_is_needed(&p.mesh));
        assert_int_equal(psplat_alpha_mask_cut(&p.mesh, 0.05, &shown, NULL), PSPLAT_OK);
        assert_int_equal(psplat_mesh_shows_both_sides(&shown, 0), cells > 1);
        /* Chords of length 0.05 and texels of 1/64 change the disc's area by less than 0.01. */
        assert_near(area_of(&shown), 3.14159265 * 0.49, 0.01);
        uint32_t *pairs = malloc(3 * shown.triangle_count * sizeof *pairs);
        assert_non_null(pairs);
        assert_int_equal(psplat_edge_pairs(&shown, pairs, &borders), PSPLAT_OK);
        for (size_t e = 0; e < 3 * shown.triangle_count; ++e) {
            if (pairs[e] != PSPLAT_NONE) continue;
            const double *v = shown.positions + 3 * (size_t)shown.triangles[e];
            assert_near(hypot(v[0], v[1]), 0.7, 0.004); /* a quarter of a texel (1/64) */
        }
        /* Texture coordinates moved along with the vertices. */
        for (size_t i = 0; i < 3 * shown.triangle_count; ++i) {
            const double *v = shown.positions + 3 * (size_t)shown.triangles[i];
            assert_near(shown.corner_uvs[0][2 * i], (v[0] + 1) / 2, 1e-6);
            assert_near(shown.corner_uvs[0][2 * i + 1], (1 - v[1]) / 2, 1e-6);
        }
        free(pairs);
        psplat_mesh_free(&shown);
        painted_free(&p);
    }
}

static void test_none_and_all(void **state) {
    (void)state;
    painted p;
    psplat_mesh shown;
    make_masked(&p, 1, nothing);
    assert_int_equal(psplat_alpha_mask_cut(&p.mesh, 0.1, &shown, NULL), PSPLAT_ERROR_NO_SPLATS);
    assert_null(shown.positions);
    p.source_material.alpha_cutoff = 0;
    assert_int_equal(psplat_alpha_mask_cut(&p.mesh, 0.1, &shown, NULL), PSPLAT_OK);
    assert_int_equal(shown.triangle_count, 2); /* Nothing is divided. */
    assert_near(area_of(&shown), 4, 1e-12);
    psplat_mesh_free(&shown);
    p.source_material.is_masked = 0;
    assert_false(psplat_alpha_mask_is_needed(&p.mesh));
    painted_free(&p);
}

/* Cutting by a mask of noise ends, and leaves half of the area. */
static void test_noise(void **state) {
    (void)state;
    painted p;
    psplat_mesh shown;
    make_masked(&p, 1, noise);
    assert_int_equal(psplat_alpha_mask_cut(&p.mesh, 0.1, &shown, NULL), PSPLAT_OK);
    double area = area_of(&shown);
    assert_true(area > 1.2 && area < 2.8 && shown.triangle_count < 20000);
    psplat_mesh_free(&shown);
    painted_free(&p);
}

/* The promise holds for the visible part: no splat reaches beyond the disc by more than the
 * tolerance. */
static void test_splats(void **state) {
    (void)state;
    painted p;
    psplat_splats splats;
    psplat_report report;
    psplat_error error;
    const psplat_convert_desc desc = {.tolerance_percent = 1, .effort = PSPLAT_EFFORT_NONE};
    make_masked(&p, 1, disc);
    if (psplat_convert(&p.mesh, &desc, &splats, &report, &error)) fail_msg("%s", error.text);
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
    assert_int_equal(report.uncovered_samples, 0);
    assert_false(splats.has_color); /* Alpha that has cut the mesh is no colour any more. */
    assert_true(report.border_edges > 20);
    psplat_splats_free(&splats);
    painted_free(&p);
}

int test_alpha_mask_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_disc),
        cmocka_unit_test(test_none_and_all),
        cmocka_unit_test(test_noise),
        cmocka_unit_test(test_splats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

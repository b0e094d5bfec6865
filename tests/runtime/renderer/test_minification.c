/* SPDX-License-Identifier: MIT
 *
 * test_minification.c - tests that models that shrink to 16 pixels do not flicker under camera
 * motion below a pixel. The truth is the renderer's own picture at eight times the size (film.h).
 * Colours are compared in pixels that the model fills. Outlines have no partial coverage; they are
 * expected where they are without the filter.
 */
#include "agreement.h"
#include "detail.h"
#include "film.h"

#include <phongsplat/host.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#define MODEL 16 /* in pixels across */

typedef struct drawn {
    psplat_renderer *renderer;
    psplat_model *model;
} drawn;

static void draw(void *self, const psplat_view *view) {
    drawn *d = self;
    psplat_item item = {.model = d->model};
    assert_int_equal(psplat_draw(d->renderer, view, &item, 1, NULL), PSPLAT_OK);
}

static void report(const char *name, const film_figures *f) {
    print_message("%-16s change mean %.4f most %.3f, flicker mean %.4f most %.3f, error %.4f\n",
                  name, f->change, f->most_change, f->flicker, f->most_flicker, f->error);
}

/* Sampling can do no more than this: a pixel of an outline is there or not, by its centre. */
static void check_outline(const film_report *without, const film_report *with,
                          const film_report *truth) {
    assert_true(fabs(with->covered / truth->covered - 1) < 0.01);
    assert_true(fabs(with->outline.error - without->outline.error) < 1e-12);
    assert_true(with->outline.count > 100);
}

/* Measures the truth, the renderer without the filter, and the renderer with it. */
static void measure(gpu *g, scene s, film_figures result[3]) {
    static const char *const names[] = {" at 8 x 8", " without filter", " with filter"};
    film films[3];
    film_report reports[3];
    psplat_asset *asset = scene_open(&s);
    drawn d = {.renderer = g->renderer};
    assert_int_equal(psplat_model_create(g->renderer, asset, &d.model, NULL), PSPLAT_OK);
    for (int way = 0; way < 3; ++way) {
        films[way] = film_shoot(g->host, draw, &d, MODEL, way < 2, way ? 1 : FILM_FINER);
        reports[way] = film_compare(&films[way], &films[0]);
        result[way] = reports[way].inside;
        report(names[way], &result[way]);
    }
    check_outline(&reports[1], &reports[2], &reports[0]);
    for (int way = 0; way < 3; ++way) film_free(&films[way]);
    psplat_model_destroy(g->renderer, d.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* The picture is far nearer to the truth with the filter than without; the checkerboard, which
 * averages to grey, changes no more than it does in truth. */
static void test_checkered(void **state) {
    film_figures f[3];
    print_message("checkered sphere of 4000 splats, %d pixels across\n", MODEL);
    measure(*state, detail_checkered(), f);
    assert_true(f[0].count > 100 * (FILM_FRAMES - 1));
    assert_true(f[2].flicker * 5 < f[1].flicker);
    assert_true(f[2].most_flicker * 4 < f[1].most_flicker);
    assert_true(f[2].error * 4 < f[1].error);
    assert_true(f[2].change < 1.25 * f[0].change);
}

/* Normals average but highlights do not, and hiding is not filtered: the gain is smaller. */
static void test_bumpy(void **state) {
    film_figures f[3];
    print_message("sphere with bumps of 4000 splats, %d pixels across\n", MODEL);
    measure(*state, detail_bumpy(), f);
    assert_true(f[0].count > 100 * (FILM_FRAMES - 1));
    assert_true(f[2].flicker * 3 < f[1].flicker);
    assert_true(f[2].most_flicker < f[1].most_flicker);
    assert_true(f[2].error * 1.4 < f[1].error);
}

int test_minification_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_checkered),
        cmocka_unit_test(test_bumpy),
    };
    return cmocka_run_group_tests(tests, gpu_setup_gl, gpu_teardown);
}

/* SPDX-License-Identifier: MIT
 *
 * test_hidden_samples.c - tests which samples lie beneath another layer: a sheet that is laid back
 * over itself hides its lower layer from heights that reach the upper one, and nothing else.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "layers_fixture.h"
#include "stage_fixture.h"
#include "measure/hidden_samples.h"
#include "mesh/distance.h"

/* Returns how many samples are hidden by what lies up to a height above them; none of them may lie
 * elsewhere than on the lower layer. */
static size_t count_hidden(const fixture *f, const psplat_distance *distance, double height,
                           size_t *lower, size_t *hiding) {
    size_t hidden = 0;
    *lower = *hiding = 0;
    for (size_t i = 0; i < f->samples.count; ++i) {
        const double *normal = f->surface.face_normals + 3 * (size_t)f->samples.triangles[i];
        int is_lower =
            f->samples.positions[3 * i + 2] + f->mesh.origin[2] < 1e-6 && normal[2] > 0.5;
        int is_hidden;
        assert_int_equal(
            psplat_sample_is_hidden(&f->surface, &f->samples, distance, height, i, &is_hidden),
            PSPLAT_OK);
        if (is_hidden) assert_true(is_lower);
        /* What is hidden from above is what the upper layer hides, straight beneath. */
        int hides;
        assert_int_equal(psplat_sample_hides(&f->surface, &f->samples, distance, height, i, &hides),
                         PSPLAT_OK);
        if (hides) assert_true(!is_lower && normal[2] > 0.5);
        *hiding += hides != 0;
        hidden += is_hidden != 0;
        *lower += is_lower != 0;
    }
    return hidden;
}

static void test_layers(void **state) {
    (void)state;
    fixture f;
    size_t lower, hiding;
    fixture_layers(&f);
    psplat_distance *check = psplat_distance_create_check(&f.mesh);
    assert_non_null(check);
    const psplat_distance *trees[] = {f.distance, check};
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(count_hidden(&f, trees[i], 0.9 * layer_height, &lower, &hiding), 0);
        assert_int_equal(hiding, 0);
        assert_int_equal(count_hidden(&f, trees[i], 1.1 * layer_height, &lower, &hiding), lower);
        assert_true(lower > 100 && hiding > 100);
    }
    psplat_distance_destroy(check);
    fixture_free(&f);
}

int test_hidden_samples_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_layers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

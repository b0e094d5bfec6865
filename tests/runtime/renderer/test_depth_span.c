/* SPDX-License-Identifier: MIT
 *
 * test_depth_span.c - tests depth spans: what a view shows of a box lies between the planes of
 * the fitted projection, at the same place across the view, and nothing is fitted where the eye
 * is in the box. Views and boxes are random; expected positions come from projecting points of
 * the box.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>

#include <cmocka.h>

#include "renderer/depth_span.h"
#include "reference_view.h"

#include <math.h>
#include <string.h>

static uint32_t seed = 31u;

static double uniform(double low, double high) {
    return low + (high - low) * (double)scene_random(&seed);
}

/* Returns a view whose ratio of far to near is 2 to 1e8. A third of the views are parallel, a third
 * have no far plane. */
static psplat_view random_view(int kind) {
    psplat_view view = camera_view(100, 100);
    double eye[3], near = pow(10, uniform(-4, 1)), far = near * pow(10, uniform(0.3, 8));
    for (int i = 0; i < 3; ++i) eye[i] = uniform(-1, 1) * pow(10, uniform(-1, 3));
    camera_look(&view, eye, (double[]){uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)});
    if (kind == 0)
        camera_parallel(&view, pow(10, uniform(-1, 1)), near, far);
    else
        camera_perspective(&view, pow(10, uniform(1, 3)), near, far);
    if (kind == 2) {
        view.projection[10] = -1;
        view.projection[14] = -2 * near;
    }
    return view;
}

static void project(const psplat_view *view, const double projection[16], const double p[3],
                    double clip[4]) {
    double eye[3];
    for (int row = 0; row < 3; ++row)
        eye[row] = view->view[row] * p[0] + view->view[4 + row] * p[1] +
                   view->view[8 + row] * p[2] + view->view[12 + row];
    for (int row = 0; row < 4; ++row)
        clip[row] = projection[row] * eye[0] + projection[4 + row] * eye[1] +
                    projection[8 + row] * eye[2] + projection[12 + row];
}

static void check_points(const psplat_view *view, const psplat_depth_span *span, const float min[3],
                         const float max[3], size_t *seen) {
    double fitted[16], middle = psplat_depth_span_middle(span), half = psplat_depth_span_half(span);
    psplat_depth_span_project(span, view->projection, fitted);
    for (int k = 0; k < 20; ++k) {
        double p[3], before[4], after[4];
        for (int i = 0; i < 3; ++i)
            p[i] = (double)min[i] + ((double)max[i] - (double)min[i]) * uniform(0, 1);
        project(view, view->projection, p, before);
        project(view, fitted, p, after);
        for (int i = 0; i < 4; i += i == 1 ? 2 : 1) assert_true(after[i] == before[i]);
        double w = before[3], z = before[2] / w, left = fabs(before[0] / w),
               up = fabs(before[1] / w);
        if (!(w > 0 && left < 1 && up < 1 && fabs(z) < 1)) continue;
        ++*seen;
        assert_true(fabs(after[2]) <= w);
        /* The tolerance is 2^-24, the precision of the float that the result becomes. */
        assert_true(fabs(middle + half * after[2] / w - z) < 0x1p-24 * half + 1e-15);
    }
}

static void test_holds(void **state) {
    size_t seen = 0, fitted = 0;
    (void)state;
    for (int round = 0; round < 20000; ++round) {
        psplat_view view = random_view(round % 3);
        psplat_depth_span span = PSPLAT_SPAN_EMPTY;
        float min[3], max[3];
        for (int i = 0; i < 3; ++i) {
            min[i] = (float)uniform(-2, 1);
            max[i] = min[i] + (float)(round % 7 ? uniform(0, 1) : 0); /* some boxes are a point */
        }
        psplat_depth_span_add(&span, view.view, view.projection, min, max, 0);
        size_t before = seen;
        assert_true(span.low >= -1 && span.high <= 1);
        if (span.low < span.high) check_points(&view, &span, min, max, &seen);
        if (span.low < span.high) fitted += span.high - span.low < 0.02;
        if (!(span.low < span.high)) assert_int_equal(before, seen);
    }
    assert_true(seen > 50000 && fitted > 2000);
}

/* Boxes lie beside the view, behind the eye, and around it. */
static void test_beyond(void **state) {
    (void)state;
    psplat_view view = camera_view(100, 100);
    camera_perspective(&view, 100, 0.1, 10);
    const struct {
        float min[3], max[3];
        int is_seen, is_whole;
    } boxes[] = {{{-1, -1, -3}, {1, 1, -2}, 1, 0},  {{5, -1, -3}, {7, 1, -2}, 0, 0},
                 {{-1, -1, 2}, {1, 1, 3}, 0, 0},    {{-1, -1, -30}, {1, 1, -20}, 0, 0},
                 {{-1, -1, -1}, {1, 1, 1}, 1, 1},   {{-1, -1, -1}, {1, 1, 0}, 1, 1},
                 {{-1, -1, -30}, {1, 1, -2}, 1, 0}, {{0, 0, -3}, {0, 0, -3}, 1, 0}};
    for (size_t k = 0; k < sizeof boxes / sizeof *boxes; ++k) {
        psplat_depth_span span = PSPLAT_SPAN_EMPTY;
        psplat_depth_span_add(&span, view.view, view.projection, boxes[k].min, boxes[k].max, 0);
        assert_int_equal(span.low < span.high, boxes[k].is_seen);
        if (boxes[k].is_seen) assert_int_equal(span.low == -1 && span.high == 1, boxes[k].is_whole);
    }
}

/* The filter draws splats nearer than they are: twice the box's depth before it there is room, and
 * no more, unless the near plane comes first. Depths are linear here: 10 units are from -1 to 1. */
static void test_room_before(void **state) {
    (void)state;
    psplat_view view = camera_view(100, 100);
    camera_parallel(&view, 5, 0.1, 10.1);
    const struct {
        float near, far;
        double low;
    } boxes[] = {{7.1f, 8.1f, 0}, {9.1f, 9.6f, 0.6}, {3.1f, 4.1f, -0.8}, {2.1f, 3.1f, -1}};
    for (size_t k = 0; k < sizeof boxes / sizeof *boxes; ++k) {
        const float min[3] = {-1, -1, -boxes[k].far}, max[3] = {1, 1, -boxes[k].near};
        psplat_depth_span span = PSPLAT_SPAN_EMPTY;
        psplat_depth_span_add(&span, view.view, view.projection, min, max, 0);
        /* Below it a little for rounding: a 4096th of a depth of 2 at most. */
        assert_true(span.low <= boxes[k].low + 1e-6 && span.low >= boxes[k].low - 2.0 / 4096);
    }
}

/* What lies a shift behind the box along any view ray is before the span's end or the view's far
 * plane. */
static void test_shift(void **state) {
    size_t seen = 0;
    (void)state;
    for (int round = 0; round < 20000; ++round) {
        psplat_view view = random_view(round % 3);
        psplat_depth_span span = PSPLAT_SPAN_EMPTY;
        float min[3], max[3];
        double shift = pow(10, uniform(-3, 0.5)), eye[4], clip[4];
        for (int i = 0; i < 3; ++i) min[i] = (float)uniform(-2, 1), max[i] = min[i] + 0.5f;
        psplat_depth_span_add(&span, view.view, view.projection, min, max, shift);
        if (!(span.low < span.high)) continue;
        int is_parallel = view.projection[11] == 0;
        for (int corner = 0; corner < 8; ++corner) {
            for (int row = 0; row < 4; ++row) {
                eye[row] = view.view[12 + row];
                for (int axis = 0; axis < 3; ++axis)
                    eye[row] += view.view[4 * axis + row] *
                                (double)(corner >> axis & 1 ? max[axis] : min[axis]);
            }
            double length = sqrt(eye[0] * eye[0] + eye[1] * eye[1] + eye[2] * eye[2]);
            for (int i = 0; i < 3; ++i) eye[i] *= is_parallel ? 1 : 1 + shift / length;
            if (is_parallel) eye[2] -= shift;
            for (int row = 0; row < 4; ++row)
                clip[row] = view.projection[row] * eye[0] + view.projection[4 + row] * eye[1] +
                            view.projection[8 + row] * eye[2] + view.projection[12 + row];
            if (!(clip[3] > 0)) continue;
            assert_true(clip[2] / clip[3] <= span.high + 1e-12 || span.high == 1);
            seen += span.high < 1;
        }
    }
    assert_true(seen > 5000);
}

int test_depth_span_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_holds),
        cmocka_unit_test(test_room_before),
        cmocka_unit_test(test_shift),
        cmocka_unit_test(test_beyond),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_quantize.c - tests how splats are rounded to the steps of a file: rounding again changes
 * nothing, clip lines keep what they kept, surfaces and fields move by no more than a step, and
 * small splats have the grades of their radii. What of this comes back from a file is tested by
 * export/test_written_splats.c, whose random splats these are.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "writer_fixture.h"
#include "base/random.h"
#include "base/region.h"
#include "near.h"
#include "splats/octahedron.h"
#include "splats/quantize.h"
#include "splats/splat_frame.h"
#include "splats/splats.h"

static const double ulp = 0x1p-24; /* of single precision, relative */

/* Rounding a rounded splat changes no bit. */
static void test_snapped(void **state) {
    (void)state;
    for (int i = 0; i < 20; ++i) {
        written w = {.count = 500, .size = pow(10, i % 7 - 3), .has_slopes = 1, .has_gamma = 1};
        if (i % 3) w.curved = 31, w.has_bends = 1, w.has_shape = i % 3 == 2;
        w.precision = steps_of(w.size);
        w.precision.normal_bits = PSPLAT_OCTAHEDRON_LEAST_BITS + i % 11;
        w.has_gradients = 1;
        psplat_splats s = writer_splats(&w, (uint32_t)i + 1);
        psplat_splats again = s;
        again.splats = writer_memory(s.count, sizeof *s.splats);
        again.finishes = writer_memory(s.count, sizeof *s.finishes);
        memcpy(again.splats, s.splats, s.count * sizeof *s.splats);
        memcpy(again.finishes, s.finishes, s.count * sizeof *s.finishes);
        psplat_round_to_precision(&again);
        assert_memory_equal(again.splats, s.splats, s.count * sizeof *s.splats);
        assert_memory_equal(again.finishes, s.finishes, s.count * sizeof *s.finishes);
        free(again.splats);
        free(again.finishes);
        psplat_splats_free(&s);
    }
}

/* Half a turn leaves the ellipse as it is; gradients and lines along its axes change their sign. */
static void test_flipped(void **state) {
    (void)state;
    written w = {.count = 400, .size = 1, .has_gradients = 1};
    psplat_splats s = writer_splats(&w, 9);
    s.precision = steps_of(1);
    size_t flipped = 0;
    for (size_t i = 0; i < s.count; ++i) {
        psplat_region before, after;
        psplat_splats one = s;
        psplat_splat splat = s.splats[i];
        psplat_finish finish = s.finishes[i];
        psplat_run run = {.count = 1};
        one.splats = &splat, one.finishes = &finish, one.count = 1;
        one.runs = &run, one.run_count = 1;
        psplat_splat_region(&splat, 0, &before);
        psplat_round_to_precision(&one);
        psplat_splat_region(&splat, 0, &after);
        double along = 0;
        for (int k = 0; k < 3; ++k) along += before.u[k] * after.u[k];
        assert_true(fabs(along) > 0.999); /* half a step of 1/256 */
        flipped += along < 0;
        for (int k = 0; k < 3; ++k) {
            float sign = along < 0 ? -1.0f : 1.0f;
            assert_true(finish.color_u[k] == sign * s.finishes[i].color_u[k]);
            assert_true(finish.color_v[k] == sign * s.finishes[i].color_v[k]);
        }
        for (uint32_t l = 0; l < splat.clip_count; ++l) { /* The line stays in place. */
            double dot = 0;
            for (int k = 0; k < 2; ++k)
                dot += (double)splat.clip[l][k] * (double)s.splats[i].clip[l][k];
            assert_true(along < 0 ? dot < -0.99 : dot > 0.99);
        }
    }
    assert_in_range(flipped, s.count / 4, s.count - s.count / 4);
    psplat_splats_free(&s);
}

/* Rounded lines cut off nothing that the lines kept before, and reach no farther than a step and
 * their turn. */
static void test_lines_keep(void **state) {
    (void)state;
    written w = {.count = 300, .size = 1, .lines = 16};
    psplat_splats s = writer_splats(&w, 4);
    psplat_splat *before = writer_memory(s.count, sizeof *before);
    memcpy(before, s.splats, s.count * sizeof *before);
    s.precision = steps_of(1);
    psplat_round_to_precision(&s);
    for (size_t i = 0; i < s.count; ++i)
        for (int l = 0; l < 4; ++l)
            for (int a = 0; a < 72; ++a) {
                double sign = 0, u = cos(a * 0.0872664626), v = sin(a * 0.0872664626);
                const float *old = before[i].clip[l], *line = s.splats[i].clip[l];
                for (int k = 0; k < 2; ++k) sign += (double)old[k] * (double)line[k];
                double side = sign < 0 ? -1 : 1; /* The axes may have turned by half a circle. */
                double kept = (double)old[0] * u + (double)old[1] * v + (double)old[2];
                double now = side * ((double)line[0] * u + (double)line[1] * v) + (double)line[2];
                /* A line may lose a hundredth of its step (1/64), and rounding to float. */
                if (kept >= 0) assert_true(now >= -0.01 / 64 - 4 * ulp);
                /* A line through the ellipse moves by at most a step, and by its turn (half a step
                 * of the angle) to keep the ends of its chord; at the points tested the turn counts
                 * once more. */
                double turn = 1.5708 * s.precision.line_turn_step;
                if (fabsf(old[2]) < 1)
                    assert_true(now <= kept + s.precision.line_step + 2 * turn + 4 * ulp);
            }
    free(before);
    psplat_splats_free(&s);
}

/* Asserts that two floats are one but for four roundings. */
static void assert_close(float found, float expected) {
    assert_near((double)found, (double)expected, 4 * ulp * fabs((double)expected));
}

/* Rounding the second derivatives of a region moves each of alpha, beta and gamma by half a step at
 * most, and rounding the splat that is made of it moves them no more. */
static void test_shapes(void **state) {
    (void)state;
    const psplat_precision p = steps_of(1);
    const psplat_run run = {.count = 1, .is_curved = 1};
    uint32_t random = 3;
    for (int i = 0; i < 500; ++i) {
        double radius[2], hessian[3], rounded[3];
        for (int k = 0; k < 2; ++k)
            radius[k] = p.unit * exp(p.scale_step * floor(100 * (double)scene_random(&random)));
        if (radius[1] > radius[0]) radius[0] = radius[1];
        for (int k = 0; k < 3; ++k)
            hessian[k] = (2 * (double)scene_random(&random) - 1) / radius[0];
        memcpy(rounded, hessian, sizeof rounded);
        psplat_quantize_shape(&p, radius, rounded);
        const double lengths[3] = {radius[0], radius[0], radius[1]};
        for (int k = 0; k < 3; ++k)
            assert_near(rounded[k] * lengths[k], hessian[k] * lengths[k], 0.5001 * p.shape_step);
        psplat_splat splat = {.rotation = {0, 0, 0, 1},
                              .radius = {(float)radius[0], (float)radius[1]},
                              .normal = {0, 0, 1},
                              .shape = {0, 0, (float)(-rounded[0] * radius[0]),
                                        (float)(-rounded[2] * radius[1]),
                                        (float)(-rounded[1] * radius[0])}};
        psplat_splat again = splat;
        psplat_quantized_splat code;
        psplat_quantize_splat(&p, &run, &splat, &code);
        psplat_dequantize_splat(&p, &run, &code, &again);
        for (int k = 0; k < 5; ++k) assert_close(again.shape[k], splat.shape[k]);
        for (int k = 0; k < 3; ++k) assert_close(again.gradient[k], splat.shape[2 + k]);
    }
}

static double value_of(const double line[3], double bend, const double p[2]) {
    double along = line[0] * p[1] - line[1] * p[0];
    return line[0] * p[0] + line[1] * p[1] + line[2] + bend * along * along / 2;
}

/* Rounded bent lines cut off nothing of the unit disc that the lines keep, at whatever steps, and
 * rounding them again changes nothing. How far the border of what is kept moves outwards is less
 * than a step, what half a step of the turn and of the bend can move it, and the bound's own error,
 * which is a part of these. */
static void test_bent_lines_keep(void **state) {
    (void)state;
    uint32_t random = 11;
    for (int i = 0; i < 4000; ++i) {
        int exponent = 4 + (int)(8 * scene_random(&random));
        const psplat_precision p = {.line_step = 1 / pow(2, exponent),
                                    .line_turn_step = 1 / pow(2, exponent + 1),
                                    .bend_step = i % 4 ? 1.0 / 16 : 1 / pow(2, exponent - 1)};
        double angle = 6.2832 * (double)scene_random(&random), again[3];
        const double line[3] = {cos(angle), sin(angle), 2.4 * (double)scene_random(&random) - 1.2};
        double bend = 8 * (double)scene_random(&random) - 4, rounded[3], now = bend, twice;
        memcpy(rounded, line, sizeof line);
        psplat_quantize_line(&p, rounded, &now);
        assert_true(fabs(now) <= 4);
        memcpy(again, rounded, sizeof rounded);
        twice = now;
        psplat_quantize_line(&p, again, &twice);
        for (int k = 0; k < 3; ++k) assert_near(again[k], rounded[k], 1e-12);
        assert_near(twice, now, 0);
        double most = 0;
        for (int k = 0; k < 4096; ++k) {
            double r = k < 1024 ? 1 : sqrt((double)scene_random(&random));
            double t = k < 1024 ? k * 6.283185307 / 1024 : 6.2832 * (double)scene_random(&random);
            const double at[2] = {r * cos(t), r * sin(t)};
            double before = value_of(line, bend, at), after = value_of(rounded, now, at);
            if (before >= 0 && !(after >= -0.011 * p.line_step))
                fail_msg("%d: %g of bend %g is cut off at %g %g by %g", i, before, bend, at[0],
                         at[1], after);
            most = fmax(most, after - before);
        }
        double turn = 1.5708 * p.line_turn_step * (2 + 8);
        if (fabs(line[2]) < 0.9 && fabs(now) > 0)
            assert_true(most <= 1.1 * (p.line_step + turn + p.bend_step));
    }
}

/* The integers of small splats have the zeros at their end that their radii ask for, those of lines
 * far out, too, of which less would be kept as well; and to round them a third time changes
 * nothing.
 */
static void test_zeros(void **state) {
    (void)state;
    uint32_t random = 5, normals = 0, shapes = 0, lines = 0;
    const psplat_run run = {.count = 1, .clip_lines = 2, .is_curved = 1, .has_bends = 1};
    psplat_precision p = steps_of(3);
    p.turn_step = 1.0 / 256, p.normal_bits = 11;
    p.halving = (int)lrint(log(2) / p.scale_step);
    p.shape_grades = p.normal_grades = 3;
    for (int i = 0; i < 2000; ++i) {
        float turn = 3 * scene_random(&random), first = scene_random(&random) + 0.5f;
        psplat_splat splat = {.radius = {first, first * (0.3f + 0.7f * scene_random(&random))},
                              .rotation = {0.3f, -0.2f, 0.9327f * sinf(turn), 0.9327f * cosf(turn)},
                              .clip_count = 2};
        for (int k = 0; k < 2; ++k) {
            float angle = 6 * scene_random(&random);
            splat.clip[k][0] = cosf(angle), splat.clip[k][1] = sinf(angle);
            splat.clip[k][2] = 3 * scene_random(&random) - 1;
            splat.bend[k] = 7 * scene_random(&random) - 3.5f;
        }
        for (int k = 0; k < 3; ++k) splat.gradient[k] = splat.shape[2 + k] = scene_random(&random);
        psplat_quantized_splat code, again;
        p.reference = (int)lrint(log((double)first / p.unit) / p.scale_step) + 3 * p.halving;
        psplat_quantize_splat(&p, &run, &splat, &code);
        const double radius[2] = {p.unit * exp(p.scale_step * code.scale[0]),
                                  p.unit * exp(p.scale_step * code.scale[1])};
        double turns = code.turn * p.turn_step / psplat_precision_at(&p, radius).turn_step;
        assert_true(turns == rint(turns));
        for (int k = 0; k < 2; ++k) normals |= (uint32_t)code.normal[k];
        for (int k = 0; k < 3; ++k) shapes |= (uint32_t)code.shape[k];
        for (int k = 0; k < 3; ++k)
            lines |= (uint32_t)code.lines[0][k] | (uint32_t)code.lines[1][k];
        psplat_dequantize_splat(&p, &run, &code, &splat);
        psplat_quantize_splat(&p, &run, &splat, &again);
        /* Rounding may move a line in once, where nearer ones keep as much of the ellipse. */
        psplat_dequantize_splat(&p, &run, &again, &splat);
        psplat_quantize_splat(&p, &run, &splat, &code);
        assert_memory_equal(&code, &again, sizeof code);
    }
    assert_int_equal(normals & 15, 8);
    assert_int_equal(shapes & 15, 8);
    assert_int_equal(lines & 15, 8);
}

/* Fields just within the bound of spec (3a) stay within it when they are rounded, even by coarse
 * steps, and others are rounded to nothing but the nearest numbers. */
static void test_bounded_fields(void **state) {
    (void)state;
    const psplat_run run = {.count = 1};
    psplat_precision p = {.unit = 0.01,
                          .turn_step = 1.0 / 256,
                          .scale_step = 0.03,
                          .normal_bits = 12,
                          .line_step = 1.0 / 1024,
                          .line_turn_step = 1.0 / 1024};
    uint64_t seed = 11;
    int rounded_down = 0;
    for (int i = 0; i < 4000; ++i) {
        p.tilt_step = p.field_step = ldexp(1, -(i % 6));
        double f[5], sum = 0, ratio = 0.25 + 0.75 * psplat_random_unit(&seed);
        double wanted = i % 2 ? 19.85 : 10 * psplat_random_unit(&seed);
        for (int k = 0; k < 5; ++k) f[k] = psplat_random_unit(&seed) - 0.5;
        sum =
            hypot(f[0], f[1]) + sqrt(f[2] * f[2] + f[3] * f[3] + f[4] * f[4] * (1 + ratio * ratio));
        for (int k = 0; k < 5; ++k) f[k] *= wanted / sum;
        const double length = sqrt(1 + f[0] * f[0] + f[1] * f[1]);
        psplat_splat splat = {.rotation = {0, 0, 0, 1}, .radius = {2, (float)(2 * ratio)}};
        for (int k = 0; k < 3; ++k)
            splat.normal[k] = (float)((k < 2 ? f[k] : 1) / length),
            splat.gradient[k] = (float)f[2 + k];
        psplat_quantized_splat code;
        psplat_quantize_splat(&p, &run, &splat, &code);
        double found = exp((code.scale[1] - code.scale[0]) * p.scale_step);
        double slope =
            p.tilt_step * hypot(code.tilt[0], code.tilt[1]) +
            p.field_step *
                sqrt((double)code.field[0] * code.field[0] + (double)code.field[1] * code.field[1] +
                     (double)code.field[2] * code.field[2] * (1 + found * found));
        assert_true(slope < 20); /* the bound of spec (3a) */
        /* The turn rounds the axes by half of 1/256 of a half turn at most. */
        double move = wanted * 0.0062 * 2 + p.field_step * (0.5 + 1e-6);
        int is_near = 1;
        for (int k = 0; k < 3; ++k)
            is_near &= fabs(code.field[k] * p.field_step - f[2 + k]) <= move;
        if (i % 2 == 0) assert_true(is_near);
        rounded_down += !is_near;
    }
    assert_true(rounded_down > 10);
}

int test_quantize_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_snapped),         cmocka_unit_test(test_flipped),
        cmocka_unit_test(test_lines_keep),      cmocka_unit_test(test_shapes),
        cmocka_unit_test(test_bent_lines_keep), cmocka_unit_test(test_zeros),
        cmocka_unit_test(test_bounded_fields),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

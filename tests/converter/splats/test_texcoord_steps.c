/* SPDX-License-Identifier: MIT
 *
 * test_texcoord_steps.c - tests of the grid of texture coordinates: where they are moved to, how
 * far rounding moves a texture, and that coordinates follow the axes that rounding flips.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "near.h"
#include "writer_fixture.h"
#include "splats/quantize.h"
#include "splats/splat_frame.h"
#include "splats/texcoord_steps.h"

#include <math.h>
#include <string.h>

enum { COUNT = 200 };

/* Random splats whose texture has a density of 0.5 for each unit of length, turned at random. */
static psplat_splats textured_splats(float low, float high, int bends) {
    const written w = {.count = COUNT, .size = 1, .precision = usual_steps, .has_slopes = 1};
    written unrounded = w;
    uint32_t state = 11;
    unrounded.precision = (psplat_precision){0};
    psplat_splats s = writer_splats(&unrounded, 9);
    s.precision = w.precision;
    s.texcoords = writer_memory(s.count, sizeof *s.texcoords);
    for (size_t r = 0; r < s.run_count; ++r)
        s.runs[r].has_texcoord = 1, s.runs[r].has_texcoord_bend = bends;
    for (size_t i = 0; i < s.count; ++i) {
        psplat_texcoord *t = &s.texcoords[i];
        double angle = 6.28 * (double)scene_random(&state);
        const double radius[2] = {(double)s.splats[i].radius[0], (double)s.splats[i].radius[1]};
        for (int k = 0; k < 2; ++k) {
            t->at[k] = low + (high - low) * scene_random(&state);
            t->along_u[k] = (float)(0.5 * radius[0] * (k ? sin(angle) : cos(angle)));
            t->along_v[k] = (float)(0.5 * radius[1] * (k ? cos(angle) : -sin(angle)));
            t->along_uv[k] = bends ? t->along_u[k] / 8 : 0;
        }
    }
    return s;
}

static void test_moved_to_the_first_tile(void **state) {
    (void)state;
    static const struct {
        psplat_wrap wrap;
        float low, high;
    } cases[] = {
        {PSPLAT_WRAP_REPEAT, 0, 1}, {PSPLAT_WRAP_MIRROR, -1, 1}, {PSPLAT_WRAP_CLAMP, 7, 9}};
    for (size_t c = 0; c < 3; ++c) {
        psplat_splats s = textured_splats(7, 9, 0);
        psplat_texture *texture = &s.materials[0].textures[PSPLAT_TEXTURE_OCCLUSION];
        *texture = (psplat_texture){.image = 1, .wrap = {cases[c].wrap, PSPLAT_WRAP_CLAMP}};
        double before = (double)s.texcoords[3].at[0];
        psplat_texcoord_settle(&s, 1e-3, 0);
        double tiles = (before - (double)s.texcoords[3].at[0]) / (cases[c].wrap ? 2 : 1);
        assert_near(tiles, rint(tiles), 1e-6); /* of single precision at 9 */
        for (size_t i = 0; i < s.count; ++i) {
            assert_true(s.texcoords[i].at[0] >= cases[c].low);
            assert_true(s.texcoords[i].at[0] <= cases[c].high);
            assert_true(s.texcoords[i].at[1] >= 7); /* clamped along t */
        }
        psplat_splats_free(&s);
    }
}

/* Stores the coordinates at a point given in the mesh's units, whatever the axes of the splat. */
static void coordinates_at(const psplat_splat *splat, const psplat_texcoord *t,
                           const double point[3], double at[2]) {
    psplat_region region;
    double uv[2] = {0, 0};
    psplat_splat_region(splat, 0, &region);
    for (int k = 0; k < 3; ++k) {
        uv[0] += (point[k] - region.center[k]) * region.u[k] / region.radius[0];
        uv[1] += (point[k] - region.center[k]) * region.v[k] / region.radius[1];
    }
    for (int k = 0; k < 2; ++k)
        at[k] = (double)t->at[k] + uv[0] * (double)t->along_u[k] + uv[1] * (double)t->along_v[k] +
                uv[0] * uv[0] * (double)t->along_uu[k] + uv[0] * uv[1] * (double)t->along_uv[k] +
                uv[1] * uv[1] * (double)t->along_vv[k];
}

/* At the rim, coordinates move by no more than half a step of each number, whichever way the axes
 * point afterwards; and all steps together stay within the tolerance. */
static void test_rounding(void **state) {
    (void)state;
    const double length = 0.002, moved = 0.5 * length;
    psplat_splats s = textured_splats(0, 1, 1);
    psplat_precision *p = &s.precision, rest;
    size_t flipped = 0;
    psplat_texcoord_settle(&s, length, 0);
    assert_true(p->texcoord_step <= 0.25 * moved && p->texcoord_step > 0.05 * moved);
    assert_near(log2(p->texcoord_step), rint(log2(p->texcoord_step)), 0);
    assert_true(p->texcoord_slope_step <= 0.61 * moved && p->texcoord_bend_step <= 0.61 * moved);
    rest = *p;
    for (size_t i = 0; i < s.count; ++i) {
        psplat_quantized_splat code;
        psplat_splat rounded = s.splats[i];
        psplat_texcoord texcoord = s.texcoords[i];
        psplat_quantize_splat(&rest, &s.runs[s.splats[i].clip_count], &s.splats[i], &code);
        psplat_dequantize_splat(&rest, &s.runs[s.splats[i].clip_count], &code, &rounded);
        psplat_quantize_texcoord(p, &texcoord, code.flipped, &code.texcoord);
        psplat_dequantize_texcoord(p, &code.texcoord, &texcoord);
        flipped += code.flipped != 0;
        psplat_region region;
        psplat_splat_region(&s.splats[i], 0, &region);
        for (int corner = 0; corner < 4; ++corner) {
            double point[3], before[2], after[2];
            for (int k = 0; k < 3; ++k)
                point[k] = region.center[k] +
                           0.7 * (corner & 1 ? 1 : -1) * region.radius[0] * region.u[k] +
                           0.7 * (corner & 2 ? 1 : -1) * region.radius[1] * region.v[k];
            coordinates_at(&s.splats[i], &s.texcoords[i], point, before);
            /* Axes and radii that are rounded move coordinates too: those of the unrounded splat,
             * flipped where the rounding flips, tell what the integers alone do. */
            psplat_splat turned = s.splats[i];
            if (code.flipped) {
                const float q[4] = {s.splats[i].rotation[0], s.splats[i].rotation[1],
                                    s.splats[i].rotation[2], s.splats[i].rotation[3]};
                turned.rotation[0] = q[1], turned.rotation[1] = -q[0];
                turned.rotation[2] = q[3], turned.rotation[3] = -q[2];
            }
            coordinates_at(&turned, &texcoord, point, after);
            double most = 0.5 * p->texcoord_step + 0.7 * p->texcoord_slope_step +
                          0.75 * p->texcoord_bend_step + 1e-6;
            for (int k = 0; k < 2; ++k) assert_true(fabs(after[k] - before[k]) <= most);
        }
    }
    assert_true(flipped > COUNT / 8);
    psplat_splats_free(&s);
}

/* Coordinates that would take more than 24 bits keep their floats; a mesh without tolerance gets
 * the steps of bytes, and one of floats none. */
static void test_extremes(void **state) {
    (void)state;
    psplat_splats s = textured_splats(-1e6f, 1e6f, 0);
    s.materials[0].textures[0] =
        (psplat_texture){.image = 1, .wrap = {PSPLAT_WRAP_CLAMP, PSPLAT_WRAP_CLAMP}};
    psplat_texcoord_settle(&s, 1e-3, 0);
    assert_true(s.precision.texcoord_step == 0 && s.precision.texcoord_slope_step > 0);
    float at = s.texcoords[5].at[0];
    psplat_round_to_precision(&s);
    assert_true(s.texcoords[5].at[0] == at);
    psplat_splats_free(&s);
    s = textured_splats(0, 1, 1);
    psplat_texcoord_settle(&s, 0, 0);
    float slope = 0;
    for (size_t i = 0; i < s.count; ++i)
        for (int k = 0; k < 2; ++k)
            slope = fmaxf(
                slope, fmaxf(fabsf(s.texcoords[i].along_u[k]), fabsf(s.texcoords[i].along_v[k])));
    assert_near(s.precision.texcoord_slope_step, (double)slope / 127, 1e-12);
    s.precision = (psplat_precision){0};
    psplat_texcoord_settle(&s, 0, 0);
    assert_true(s.precision.texcoord_slope_step == 0);
    psplat_splats_free(&s);
}

int test_texcoord_steps_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_moved_to_the_first_tile),
        cmocka_unit_test(test_rounding),
        cmocka_unit_test(test_extremes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_texture_slides.c - tests of measuring how far textures slide: coordinates that are off by a
 * known amount, mirrored ones, and splats that reach over the border of a chart, or lie on several.
 * The shape is a square with one flat splat, or one for each half.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <math.h>
#include <cmocka.h>

#include "charted_fixture.h"
#include "measure/measured_splats.h"
#include "measure/texture_slides.h"
#include "splats/splats.h"

enum { CELLS = 8 };
static const double tolerance = 0.01;

/* By how much the right half's coordinates differ from x / 4 and y / 4. */
static double jump;

static void chart(uint32_t triangle, const double p[3], float uv[2]) {
    uv[0] = (float)(p[0] / 4 + (triangle / 2 % CELLS >= CELLS / 2 ? jump : 0));
    uv[1] = (float)(p[1] / 4);
}

typedef struct stage {
    charted c;
    psplat_splat splats[2];
    psplat_texcoord texcoords[2];
    psplat_run run;
    psplat_splats all;
    psplat_texture_slides slides;
} stage;

/* One disc over the square of radius 1, less its corners. */
static void stage_begin(stage *s, double by) {
    *s = (stage){.run = {.count = 1, .has_texcoord = 1}};
    jump = by;
    charted_make(&s->c, CELLS, place_square, chart);
    charted_build(&s->c, fixture_crease_angle);
    fixture_sample(&s->c.f, 0.02);
    for (int i = 0; i < 2; ++i) {
        s->splats[i] =
            (psplat_splat){.normal = {0, 0, 1}, .rotation = {0, 0, 0, 1}, .radius = {1, 1}};
        s->texcoords[i] = (psplat_texcoord){.along_u = {0.25f, 0}, .along_v = {0, 0.25f}};
    }
    s->all = (psplat_splats){.splats = s->splats,
                             .texcoords = s->texcoords,
                             .count = 1,
                             .runs = &s->run,
                             .run_count = 1,
                             .kernel = {2, 2}};
}

static void measure(stage *s) {
    psplat_measured_splats measured;
    s->all.count = s->run.count;
    assert_int_equal(psplat_measured_splats_create(&s->all, tolerance, tolerance, &measured),
                     PSPLAT_OK);
    assert_int_equal(psplat_texture_slides_find(&s->c.f.surface, &s->c.f.samples, &s->all,
                                                &measured, &s->slides),
                     PSPLAT_OK);
    psplat_measured_splats_free(&measured);
}

static void stage_end(stage *s) {
    psplat_texture_slides_free(&s->slides);
    charted_free(&s->c);
}

/* Asserts that all samples that the disc covers slide by this many texels, 25 of which are a unit
 * of length. */
static void assert_slides(const stage *s, double texels) {
    size_t covered = 0;
    for (size_t i = 0; i < s->c.f.samples.count; ++i) {
        const double *p = s->c.f.samples.positions + 3 * i;
        double r = hypot(p[0], p[1]);
        if (fabs(r - 1) < 1e-5) continue;
        if (r > 1) assert_true(s->slides.texels[i] < 0 && s->slides.lengths[i] < 0);
        if (r > 1) continue;
        ++covered;
        assert_near(s->slides.texels[i], texels, 1e-3);
        assert_near(s->slides.lengths[i], max2(texels - 0.25, 0) / 25, 1e-3);
    }
    assert_true(covered > 100);
}

static void test_errors(void **state) {
    (void)state;
    stage s;
    stage_begin(&s, 0);
    measure(&s);
    assert_slides(&s, 0);
    assert_true(s.slides.mirrored == 0 && s.slides.foreign == 0);
    psplat_texture_slides_free(&s.slides);
    s.texcoords[0].at[0] = 0.03f, s.texcoords[0].at[1] = -0.04f;
    measure(&s);
    assert_slides(&s, 5);
    psplat_texture_slides_free(&s.slides);
    s.texcoords[0].at[1] += 2; /* as many tiles, which do not repeat here */
    measure(&s);
    assert_slides(&s, hypot(3, 196));
    psplat_texture_slides_free(&s.slides);
    for (int k = 0; k < 2; ++k) s.c.kept[k].repeats[1] = 2;
    measure(&s);
    assert_slides(&s, 5);
    stage_end(&s);
}

/* A mirrored image shows, but for a strip within which it errs by a quarter of a texel at most:
 * with e texels for each unit of length across, those as far from the axis as 1 / (8 e), on both
 * sides. That much of a disc of radius 1 is about 4 / (8 e) of pi. A normal texture shows it there,
 * too. */
static void test_mirrored(void **state) {
    (void)state;
    for (int narrow = 0; narrow < 2; ++narrow) {
        double e = narrow ? 1 : 25;
        stage s;
        stage_begin(&s, 0);
        for (int k = 0; k < 2; ++k) s.c.kept[k].texels[1] = 4 * e;
        s.texcoords[0].along_v[1] *= -1;
        measure(&s);
        assert_near(s.slides.mirrored, 1 - 4 / (8 * e) / fixture_pi, 0.02); /* some 2000 samples */
        psplat_texture_slides_free(&s.slides);
        for (int k = 0; k < 2; ++k) s.c.kept[k].textures[PSPLAT_TEXTURE_NORMAL].image = 1;
        measure(&s);
        assert_near(s.slides.mirrored, 1, 0);
        psplat_texture_slides_free(&s.slides);
        s.run.has_texcoord = 0; /* It shows no texture at all. */
        measure(&s);
        assert_true(s.slides.mirrored == 0);
        for (size_t i = 0; i < s.c.f.samples.count; ++i) assert_true(s.slides.texels[i] < 0);
        stage_end(&s);
    }
}

/* A disc that covers more of the left chart is of that one: the right part is foreign, and slides
 * by nothing. Where a lighter splat of the right chart covers the same, that one is measured. */
static void test_foreign(void **state) {
    (void)state;
    stage s;
    stage_begin(&s, 0.5);
    s.splats[0].center[0] = -0.25f;
    s.texcoords[0].at[0] = -0.0625f;
    measure(&s);
    size_t right = 0, covered = 0;
    for (size_t i = 0; i < s.c.f.samples.count; ++i) {
        const double *p = s.c.f.samples.positions + 3 * i;
        int is_right = s.c.f.samples.triangles[i] / 2 % CELLS >= CELLS / 2;
        if (hypot(p[0] + 0.25, p[1]) > 1 - 1e-5) continue;
        ++covered;
        right += (size_t)is_right;
        if (is_right) assert_true(s.slides.texels[i] < 0);
        if (!is_right) assert_near(s.slides.texels[i], 0, 1e-3);
    }
    assert_near(s.slides.foreign, (double)right / (double)covered, 0.01); /* samples on the rim */
    psplat_texture_slides_free(&s.slides);
    s.run.count = 2;
    s.splats[1].center[0] = 0.75f; /* at 0 it weighs less than the other */
    s.texcoords[1].at[0] = 0.6875f + 0.01f;
    measure(&s);
    for (size_t i = 0; i < s.c.f.samples.count; ++i) {
        const double *p = s.c.f.samples.positions + 3 * i;
        if (s.c.f.samples.triangles[i] / 2 % CELLS >= CELLS / 2 &&
            hypot(p[0] - 0.75, p[1]) < 1 - 1e-5)
            assert_near(s.slides.texels[i], 1, 1e-3);
    }
    stage_end(&s);
}

/* The area beneath a splat decides which chart is its own, also where all samples lie on the other
 * side of the border, as may happen to few of them: what these show is foreign, and slides by
 * nothing. */
static void test_areas_decide(void **state) {
    (void)state;
    for (int area_is_left = 0; area_is_left < 2; ++area_is_left) {
        stage s;
        size_t left = 0, shown = 0;
        stage_begin(&s, 0.5);
        s.splats[0].center[0] = area_is_left ? -0.25f : 0.25f;
        s.texcoords[0].at[0] = area_is_left ? -0.0625f : 0.0625f + 0.5f;
        psplat_samples *samples = &s.c.f.samples;
        for (size_t i = 0; i < samples->count; ++i) { /* Only those of the right half stay. */
            if (samples->triangles[i] / 2 % CELLS < CELLS / 2) continue;
            memmove(samples->positions + 3 * left, samples->positions + 3 * i,
                    3 * sizeof *samples->positions);
            memmove(samples->normals + 3 * left, samples->normals + 3 * i,
                    3 * sizeof *samples->normals);
            memmove(samples->texcoords + 2 * left, samples->texcoords + 2 * i,
                    2 * sizeof *samples->texcoords);
            samples->triangles[left++] = samples->triangles[i];
        }
        samples->count = left;
        measure(&s);
        for (size_t i = 0; i < left; ++i) {
            shown += s.slides.texels[i] >= 0;
            assert_true(s.slides.texels[i] < 1e-3);
        }
        assert_near(s.slides.foreign, area_is_left, 0);
        assert_true(area_is_left ? shown == 0 : shown > 100);
        stage_end(&s);
    }
}

/* Plain or striped pixels for both materials. */
static void paint(stage *s, int plain, psplat_image *image) {
    assert_int_equal(psplat_image_allocate(image, 4, 4, NULL), PSPLAT_OK);
    for (size_t i = 0; i < 64; ++i) image->pixels[i] = (uint8_t)(plain ? 200 : 255 * (i / 16 % 2));
    for (int k = 0; k < 2; ++k) s->c.materials[k].base_color.image = image;
}

/* A disc of which two charts have a half each is of the one that it shows, whichever that is. What
 * it covers of the other is lost, unless that looks the same or another splat shows it. */
static void test_coordinates_decide(void **state) {
    (void)state;
    for (int shows_right = 0; shows_right < 2; ++shows_right)
        for (int kind = 0; kind < 3; ++kind) {
            psplat_image image;
            stage s;
            size_t own = 0, lost = 0, other = 0;
            stage_begin(&s, 0.5);
            paint(&s, kind == 1, &image);
            s.texcoords[0].at[0] = shows_right ? 0.5f : 0;
            /* The other chart is off by a stripe, too, a quarter of the image. */
            for (size_t i = 0; i < s.c.f.samples.count; ++i)
                if ((s.c.f.samples.triangles[i] / 2 % CELLS >= CELLS / 2) != shows_right)
                    s.c.f.samples.texcoords[2 * i + 1] += 0.25f;
            if (kind == 2) s.run.count = 2;
            s.splats[1].center[0] = shows_right ? -0.5f : 0.5f;
            s.texcoords[1].at[0] = shows_right ? -0.125f : 0.625f;
            s.texcoords[1].at[1] = 0.25f;
            measure(&s);
            for (size_t i = 0; i < s.c.f.samples.count; ++i) {
                const double *p = s.c.f.samples.positions + 3 * i;
                int is_right = s.c.f.samples.triangles[i] / 2 % CELLS >= CELLS / 2;
                if (hypot(p[0], p[1]) > 1 - 1e-5) continue;
                lost += s.slides.lost[i];
                if (fabs(p[0]) < tolerance) assert_int_equal(s.slides.lost[i], 0);
                other += is_right != shows_right;
                own += is_right == shows_right;
                if (kind == 1) continue; /* Where all looks the same it may be of either. */
                if (is_right != shows_right) {
                    assert_int_equal(s.slides.splats[i] == PSPLAT_NONE, s.slides.texels[i] < 0);
                    if (s.slides.splats[i] == 0) fail_msg("the disc is not of this chart");
                    if (s.slides.lost[i]) assert_true(s.slides.splats[i] == PSPLAT_NONE);
                    continue;
                }
                assert_int_equal(s.slides.lost[i], 0);
                assert_int_equal(s.slides.splats[i], 0);
                assert_near(s.slides.texels[i], 0, 1e-3);
            }
            assert_true(own > 100);
            if (kind == 0) assert_true(lost > other / 4);
            if (kind == 1) assert_int_equal(lost, 0);
            if (kind == 2) assert_true(lost < other / 4); /* around the corners of the lens */
            psplat_image_free(&image);
            stage_end(&s);
        }
}

/* A narrow splat that shows the left chart has less than a tenth of its area there. It is of that
 * chart while it reaches over the border by 1.4 tolerances, not by 1.6, unless a seam ends it
 * before. One that shows neither is of the right chart, which it has more of. */
static void test_narrow_strips(void **state) {
    (void)state;
    static const double reaches[4] = {0.014, 0.016, 0.014, 0.016};
    for (int kind = 0; kind < 4; ++kind) {
        stage s;
        size_t own[2] = {0, 0}, foreign[2] = {0, 0};
        double width = (reaches[kind] + 0.002) / 2;
        stage_begin(&s, 0.5);
        psplat_samples_free(&s.c.f.samples);
        assert_int_equal(
            psplat_samples_draw_uniform(&s.c.f.surface, 300000, 7, &s.c.f.samples, NULL),
            PSPLAT_OK);
        s.splats[0].center[0] = (float)(reaches[kind] - width);
        s.splats[0].radius[0] = (float)width, s.splats[0].radius[1] = 0.5f;
        s.texcoords[0].at[0] = (float)((reaches[kind] - width) / 4) + (kind == 2 ? 0.25f : 0);
        if (kind == 3) {
            s.run.clip_lines = s.run.seam_lines = 1;
            s.splats[0].clip_count = 1;
            s.splats[0].clip[0][0] = -1; /* Kept is what lies left of x = 0.013. */
            s.splats[0].clip[0][2] = (float)((0.013 - reaches[kind] + width) / width);
        }
        s.texcoords[0].along_u[0] = (float)(width / 4), s.texcoords[0].along_v[1] = 0.125f;
        measure(&s);
        for (size_t i = 0; i < s.c.f.samples.count; ++i) {
            const double *p = s.c.f.samples.positions + 3 * i;
            int is_right = s.c.f.samples.triangles[i] / 2 % CELLS >= CELLS / 2;
            if (hypot((p[0] - reaches[kind] + width) / width, p[1] / 0.5) > 1 - 1e-3) continue;
            ++*(s.slides.splats[i] == 0 ? &own[is_right] : &foreign[is_right]);
        }
        int is_right = kind == 1 || kind == 2;
        assert_int_equal(own[!is_right] + foreign[is_right], 0);
        assert_true(own[is_right] > 20 && foreign[!is_right] > 20);
        stage_end(&s);
    }
}

/* Of two splats of a chart the one that weighs more at a sample counts. */
static void test_heaviest(void **state) {
    (void)state;
    stage s;
    stage_begin(&s, 0);
    s.run.count = 2;
    s.splats[1].center[0] = 0.5f;
    s.texcoords[1].at[0] = 0.125f + 0.02f;
    measure(&s);
    for (size_t i = 0; i < s.c.f.samples.count; ++i) {
        const double *p = s.c.f.samples.positions + 3 * i;
        if (hypot(p[0], p[1]) > 0.99 || hypot(p[0] - 0.5, p[1]) > 0.99) continue;
        if (fabs(p[0] - 0.25) < 1e-3) continue; /* Both weigh the same. */
        assert_near(s.slides.texels[i], p[0] > 0.25 ? 2 : 0, 1e-3);
    }
    stage_end(&s);
}

/* A splat that shows one point of the image slides by its own diameter; on the surface that point
 * is as far away as it is. Where the image is plain, nobody sees either. */
static void test_ways_and_seen(void **state) {
    (void)state;
    psplat_image image;
    stage s;
    stage_begin(&s, 0);
    s.texcoords[0] = (psplat_texcoord){.at = {0}};
    for (int plain = 0; plain < 2; ++plain) {
        paint(&s, plain, &image);
        measure(&s);
        size_t seen = 0, own = 0;
        for (size_t i = 0; i < s.c.f.samples.count; ++i) {
            const double *p = s.c.f.samples.positions + 3 * i;
            if (s.slides.lengths[i] < 0) assert_true(s.slides.splats[i] == PSPLAT_NONE);
            if (s.slides.lengths[i] < 0) continue;
            ++own;
            seen += s.slides.seen[i];
            assert_int_equal(s.slides.splats[i], 0);
            assert_near(s.slides.ways[i], hypot(p[0], p[1]), 1e-4);
            if (hypot(p[0], p[1]) > 0.1) assert_near(s.slides.lengths[i], 2, 1e-6);
        }
        assert_true(own > 100);
        assert_true(plain ? seen == 0 : seen > own / 4);
        psplat_texture_slides_free(&s.slides);
        psplat_image_free(&image);
    }
    stage_end(&s);
}

/* A long splat beside the seam of a tube reaches over it by 0.016, which is more than the
 * tolerance. What is there is of another chart, though the tube goes on from the splat to there
 * around its back. */
static void test_around_a_neck(void **state) {
    (void)state;
    stage s = {.run = {.count = 1, .has_texcoord = 1}};
    const float half = 0.70710678f; /* u is z, v is -y and the normal is x. */
    charted_make_tube(&s.c);
    fixture_sample(&s.c.f, 0.01);
    s.splats[0] = (psplat_splat){.center = {(float)charted_tube_radius, 0, 0},
                                 .normal = {1, 0, 0},
                                 .rotation = {half, 0, half, 0},
                                 .radius = {0.45f, 0.056f}};
    s.texcoords[0] =
        (psplat_texcoord){.at = {(float)(1 - charted_tube_seam / (2 * fixture_pi)), 0},
                          .along_u = {0, 0.45f},
                          .along_v = {(float)(-0.056 / charted_tube_radius / (2 * fixture_pi)), 0}};
    s.all = (psplat_splats){.splats = s.splats,
                            .texcoords = s.texcoords,
                            .count = 1,
                            .runs = &s.run,
                            .run_count = 1,
                            .kernel = {2, 2}};
    measure(&s);
    size_t own = 0;
    for (size_t i = 0; i < s.c.f.samples.count; ++i) {
        own += s.slides.texels[i] >= 0;
        /* One texel is a hundredth of the way around. */
        assert_true(s.slides.texels[i] < 1);
    }
    assert_true(own > 100);
    assert_true(s.slides.foreign > 0.02);
    stage_end(&s);
}

/* The right half's coordinates differ from those of the left one for negative y: a border that ends
 * in the middle of the square, where both sides are one chart. */
static void chart_with_slit(uint32_t triangle, const double p[3], float uv[2]) {
    int is_right = triangle / 2 % CELLS >= CELLS / 2;
    uv[0] = (float)(p[0] / 4 + (is_right ? max2(-p[1], 0) / 2 : 0));
    uv[1] = (float)(p[1] / 4);
}

/* A splat to the left of the end of a border reaches over it by five tolerances. What is to the
 * right of it within one is that of a lighter splat that shows it, and slides where there is none,
 * or where it is beyond the seam of that; what is farther away slides. */
static void test_around_an_end(void **state) {
    (void)state;
    for (uint32_t kind = 0; kind < 3; ++kind) {
        int others = kind > 0, is_shown = kind == 1;
        stage s;
        size_t near = 0, far = 0, beyond_end = 0;
        stage_begin(&s, 0);
        charted_free(&s.c);
        charted_make(&s.c, CELLS, place_square, chart_with_slit);
        charted_build(&s.c, fixture_crease_angle);
        assert_int_equal(
            psplat_samples_draw_uniform(&s.c.f.surface, 100000, 1, &s.c.f.samples, NULL),
            PSPLAT_OK);
        s.run.count = 1 + (size_t)others;
        s.run.clip_lines = s.run.seam_lines = 1;
        for (int i = 0; i < 2; ++i) {
            s.splats[i].clip_count = 1;
            s.splats[i].clip[0][2] = 1; /* cuts nothing off */
        }
        /* Its seam is at x = 0.02. */
        if (kind == 2) s.splats[1].clip[0][0] = 1, s.splats[1].clip[0][2] = 0.84f / 0.9f;
        s.splats[0].center[0] = -0.3f, s.splats[0].center[1] = -0.1f;
        s.splats[0].radius[0] = 0.35f, s.splats[0].radius[1] = 0.6f;
        s.texcoords[0] = (psplat_texcoord){
            .at = {-0.3f / 4, -0.1f / 4}, .along_u = {0.35f / 4, 0}, .along_v = {0, 0.6f / 4}};
        s.splats[1].center[0] = 0.86f, s.splats[1].center[1] = -0.25f;
        s.splats[1].radius[0] = s.splats[1].radius[1] = 0.9f;
        s.texcoords[1] = (psplat_texcoord){
            .at = {0.215f + 0.125f, -0.0625f}, .along_u = {0.225f, 0}, .along_v = {-0.45f, 0.225f}};
        measure(&s);
        for (size_t i = 0; i < s.c.f.samples.count; ++i) {
            const double *p = s.c.f.samples.positions + 3 * i;
            double rim = hypot((p[0] + 0.3) / 0.35, (p[1] + 0.1) / 0.6);
            double texels = s.slides.texels[i];
            if (rim > 0.999 || fabs(p[0]) < 1e-4 || fabs(p[1]) < 0.06) continue;
            int is_right = p[0] > 0 && p[1] < 0;
            if (!is_right && !others) assert_near(texels, 0, 1e-3);
            beyond_end += p[0] > 0 && p[1] > 0;
            /* Elsewhere the second one weighs more. */
            if (!is_right || fabs(p[0] - tolerance) < 1e-4 || p[0] > 0.019 ||
                rim > hypot(p[0] - 0.86, p[1] + 0.25) / 0.9 - 1e-4)
                continue;
            int is_excused = is_shown && p[0] < tolerance;
            assert_int_equal(s.slides.splats[i], is_excused);
            assert_near(texels, is_excused ? 0 : -50 * p[1], 1e-3);
            if (p[0] < tolerance)
                ++near;
            else
                ++far;
        }
        assert_true(near > 10 && far > 10 && beyond_end > 10);
        if (kind < 2) assert_int_equal(s.slides.foreign > 0, is_shown);
        stage_end(&s);
    }
}

/* A disc with a seam at the border of charts is of the left chart: what lies beyond the seam does
 * not count, though it is six times as much. Without a seam it is of the right one. Where both look
 * the same, areas alone tell. */
static void test_beyond_seams(void **state) {
    (void)state;
    stage s;
    for (uint32_t kind = 0; kind < 4; ++kind) {
        size_t own[2] = {0, 0}, foreign = 0;
        uint32_t seams = kind % 2;
        psplat_image image;
        stage_begin(&s, 0.5);
        paint(&s, kind >= 2, &image);
        s.run.clip_lines = 1;
        s.run.seam_lines = seams;
        s.splats[0].center[0] = 0.6f;
        s.texcoords[0].at[0] = 0.15f;
        s.splats[0].clip_count = 1;
        /* Kept is what lies left of x = 0, where u = -0.6, or all. */
        s.splats[0].clip[0][0] = seams ? -1 : 0;
        s.splats[0].clip[0][2] = seams ? -0.6f : 1;
        measure(&s);
        for (size_t i = 0; i < s.c.f.samples.count; ++i) {
            const double *p = s.c.f.samples.positions + 3 * i;
            int is_right = s.c.f.samples.triangles[i] / 2 % CELLS >= CELLS / 2;
            if (hypot(p[0] - 0.6, p[1]) > 1 - 1e-5 || fabs(p[0]) < 1e-6) continue;
            own[is_right] += s.slides.texels[i] >= 0;
            foreign += s.slides.texels[i] < 0;
            if (s.slides.texels[i] >= 0) assert_near(s.slides.texels[i], is_right ? 50 : 0, 1e-3);
        }
        assert_true(foreign > 50);
        assert_true(own[seams ? 0 : 1] > 50);
        assert_int_equal(own[seams ? 1 : 0], 0);
        psplat_image_free(&image);
        stage_end(&s);
    }
}

/* A disc that is all of one chart has a seam through its middle all the same. What a lighter splat
 * shows decides beyond it, and the disc inside. */
static void test_light_beyond_seams(void **state) {
    (void)state;
    stage s;
    for (uint32_t seams = 0; seams < 2; ++seams) {
        stage_begin(&s, 0);
        s.run.count = 2;
        s.run.clip_lines = 1;
        s.run.seam_lines = seams;
        for (int i = 0; i < 2; ++i) {
            s.splats[i].clip_count = 1;
            s.splats[i].clip[0][2] = 1; /* cuts nothing off */
        }
        if (seams) s.splats[0].clip[0][0] = -1, s.splats[0].clip[0][2] = 0;
        s.splats[1].center[1] = 0.5f;
        s.texcoords[1].at[0] = 0.02f, s.texcoords[1].at[1] = 0.125f;
        measure(&s);
        size_t beyond = 0;
        for (size_t i = 0; i < s.c.f.samples.count; ++i) {
            const double *p = s.c.f.samples.positions + 3 * i;
            /* There the second splat weighs less, but more than a 256th of the first. */
            if (p[1] > 0.2 || p[1] < -0.2 || fabs(p[0]) > 0.6 || fabs(p[0]) < 1e-6) continue;
            int is_second = seams && p[0] > 0;
            beyond += (size_t)is_second;
            assert_int_equal(s.slides.splats[i], is_second);
            assert_near(s.slides.texels[i], is_second ? 2 : 0, 1e-3);
        }
        assert_int_equal(beyond > 20, seams);
        stage_end(&s);
    }
}

int test_texture_slides_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_errors),
        cmocka_unit_test(test_mirrored),
        cmocka_unit_test(test_foreign),
        cmocka_unit_test(test_narrow_strips),
        cmocka_unit_test(test_heaviest),
        cmocka_unit_test(test_areas_decide),
        cmocka_unit_test(test_coordinates_decide),
        cmocka_unit_test(test_around_an_end),
        cmocka_unit_test(test_around_a_neck),
        cmocka_unit_test(test_ways_and_seen),
        cmocka_unit_test(test_beyond_seams),
        cmocka_unit_test(test_light_beyond_seams),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_samples.c - tests of blue-noise samples (Poisson disk): they lie on their triangles, keep
 * their distance, leave no gap, and line the creases. The models are bundled ones; expected numbers
 * follow from areas and edge lengths.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <math.h>
#include <cmocka.h>

#include "near.h"
#include "features/surface_build.h"
#include "base/vector.h"
#include "features/surface.h"
#include "features/samples.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"

#define MODELS PSPLAT_SOURCE_DIR "/samples/models/"

typedef struct fixture {
    psplat_mesh mesh;
    psplat_surface surface;
    psplat_samples samples;
} fixture;

/* Draws samples of a model; spacing is in diagonals. */
static void draw(fixture *f, const char *path, double spacing, uint64_t seed) {
    psplat_error error;
    if (psplat_mesh_read(path, &f->mesh, &error)) fail_msg("%s", error.text);
    assert_int_equal(psplat_surface_build(&f->mesh, 0.5, &f->surface, NULL), PSPLAT_OK);
    spacing *= f->surface.diagonal;
    assert_int_equal(psplat_samples_draw(&f->surface, spacing, seed, &f->samples, NULL), PSPLAT_OK);
}

static void release(fixture *f) {
    psplat_samples_free(&f->samples);
    psplat_surface_free(&f->surface);
    psplat_mesh_free(&f->mesh);
}

static double distance_between(const psplat_samples *s, size_t a, size_t b) {
    double d[3];
    sub3(d, s->positions + 3 * a, s->positions + 3 * b);
    return length3(d);
}

static void test_on_triangles(void **state) {
    (void)state;
    fixture f;
    draw(&f, MODELS "part.obj", 0.01, 1);
    for (size_t i = 0; i < f.samples.count; ++i) {
        uint32_t t = f.samples.triangles[i];
        double d[3];
        sub3(d, f.samples.positions + 3 * i,
             f.mesh.positions + 3 * (size_t)f.mesh.triangles[3 * (size_t)t]);
        /* rounding of coordinates */
        assert_near(dot3(d, f.surface.face_normals + 3 * (size_t)t), 0, 1e-13 * f.surface.diagonal);
    }
    release(&f);
}

/* Each sample lies in the range of its triangle's cluster, and in the sphere of its block. */
static void test_blocks(void **state) {
    (void)state;
    fixture f;
    draw(&f, MODELS "part.obj", 0.01, 1);
    const psplat_samples *s = &f.samples;
    size_t small = 0;
    for (uint32_t c = 0; c < s->clusters.count; ++c) {
        uint32_t count = s->first[c + 1] - s->first[c];
        assert_int_equal(s->first_block[c + 1] - s->first_block[c],
                         (count + PSPLAT_BLOCK_SAMPLES - 1) / PSPLAT_BLOCK_SAMPLES);
        for (uint32_t i = s->first[c]; i < s->first[c + 1]; ++i) {
            const psplat_sphere *sphere =
                &s->blocks[s->first_block[c] + (i - s->first[c]) / PSPLAT_BLOCK_SAMPLES];
            assert_int_equal(s->clusters.of_triangles[s->triangles[i]], c);
            assert_true(sqrt(distance2_3(s->positions + 3 * (size_t)i, sphere->center)) <=
                        sphere->radius * (1 + 1e-12)); /* rounding of the root */
            small += sphere->radius < 3 * s->spacing;
        }
    }
    assert_int_equal(s->first[s->clusters.count], s->count);
    assert_true(small > s->count / 2); /* blocks follow a curve, so that they are small */
    release(&f);
}

/* Counts the samples that were appended to a cluster. */
static size_t count_appended(const psplat_samples *s, uint32_t cluster) {
    size_t count = 0;
    for (uint32_t i = s->last_appended[cluster]; i != PSPLAT_NONE;
         i = s->next_appended[i - s->drawn]) {
        assert_true(i >= s->drawn && i < s->count);
        assert_int_equal(s->clusters.of_triangles[s->triangles[i]], cluster);
        ++count;
    }
    return count;
}

/* On the sphere no two samples are closer than the spacing, and no point is farther than 1.3
 * spacings from a sample. */
static void test_blue_noise(void **state) {
    (void)state;
    fixture f;
    draw(&f, MODELS "sphere.ply", 0.03, 5);
    psplat_samples probes;
    assert_int_equal(psplat_samples_draw_uniform(&f.surface, 2000, 77, &probes, NULL), PSPLAT_OK);
    double spacing = f.samples.spacing, gap = 0;
    for (size_t i = 0; i < f.samples.count; ++i)
        for (size_t k = 0; k < i; ++k)
            assert_true(distance_between(&f.samples, i, k) >= spacing * (1 - 1e-12));
    for (size_t i = 0; i < probes.count; ++i) {
        double least = HUGE_VAL, d[3];
        for (size_t k = 0; k < f.samples.count; ++k) {
            sub3(d, probes.positions + 3 * i, f.samples.positions + 3 * k);
            least = min2(least, length3(d));
        }
        gap = max2(gap, least);
    }
    print_message("largest gap %.3f spacings, %zu samples\n", gap / spacing, f.samples.count);
    assert_true(gap < 1.3 * spacing);
    psplat_samples_free(&probes);
    release(&f);
}

/* Each of the cube's twelve edges is lined by samples of both its faces, including their ends. */
static void test_creases_lined(void **state) {
    (void)state;
    fixture f;
    draw(&f, MODELS "cube.off", 0.05, 2);
    double half = f.surface.diagonal / sqrt(3) / 2;
    size_t on_edges = 0, on_corners = 0;
    for (size_t i = 0; i < f.samples.count; ++i) {
        int sides = 0;
        for (size_t k = 0; k < 3; ++k)
            sides += fabs(fabs(f.samples.positions[3 * i + k]) - half) < 1e-9 * half;
        on_edges += sides >= 2;
        on_corners += sides == 3;
    }
    assert_int_equal(on_corners, 24);
    /* 24 sides of length 2 half have samples at spacing / 2, of which up to a third may be thinned
     * out. */
    size_t full = (size_t)(24 * 2 * half / (f.samples.spacing / 2));
    assert_in_range(on_edges, full * 2 / 3, full * 4 / 3 + 24);
    release(&f);
}

static void test_deterministic(void **state) {
    (void)state;
    fixture a, b, c;
    draw(&a, MODELS "cone.stl", 0.02, 3);
    draw(&b, MODELS "cone.stl", 0.02, 3);
    draw(&c, MODELS "cone.stl", 0.02, 4);
    assert_int_equal(a.samples.count, b.samples.count);
    assert_memory_equal(a.samples.positions, b.samples.positions,
                        a.samples.count * 3 * sizeof(double));
    assert_true(a.samples.count != c.samples.count ||
                memcmp(a.samples.positions, c.samples.positions,
                       a.samples.count * 3 * sizeof(double)) != 0);
    release(&a);
    release(&b);
    release(&c);
}

/* Appended samples follow the earlier ones, which keep their places; all of them are listed with
 * their triangles, each once. */
static void test_append(void **state) {
    (void)state;
    fixture f;
    draw(&f, MODELS "cube.off", 0.1, 1);
    psplat_samples extra;
    size_t before = f.samples.count;
    double *positions = malloc(before * 3 * sizeof(double));
    assert_non_null(positions);
    memcpy(positions, f.samples.positions, before * 3 * sizeof(double));
    assert_int_equal(psplat_samples_draw_uniform(&f.surface, 20, 9, &extra, NULL), PSPLAT_OK);
    assert_int_equal(
        psplat_samples_append(&f.samples, &f.surface, extra.positions, extra.triangles, 3, NULL),
        PSPLAT_OK);
    assert_int_equal(f.samples.count, before + 3);
    assert_memory_equal(f.samples.positions, positions, before * 3 * sizeof(double));
    for (size_t c = 0; c < 3; ++c) {
        assert_memory_equal(f.samples.positions + 3 * (before + c), extra.positions + 3 * c,
                            3 * sizeof(double));
        assert_memory_equal(f.samples.normals + 3 * (before + c), extra.normals + 3 * c,
                            3 * sizeof(float));
        assert_int_equal(f.samples.triangles[before + c], extra.triangles[c]);
    }
    for (size_t left = 3; left <= 3; --left) { /* 3, 2, 1, 0 are left of those appended */
        size_t listed = 0;
        psplat_samples_truncate(&f.samples, before + left);
        assert_int_equal(f.samples.count, before + left);
        for (uint32_t c = 0; c < f.samples.clusters.count; ++c)
            listed += count_appended(&f.samples, c);
        assert_int_equal(listed, left);
    }
    assert_memory_equal(f.samples.positions, positions, before * 3 * sizeof(double));
    free(positions);
    psplat_samples_free(&extra);
    release(&f);
}

/* A spacing so fine that 32 bits cannot count the samples is refused before any sample is drawn,
 * and so is a spacing of 0. */
static void test_too_many(void **state) {
    (void)state;
    fixture f;
    draw(&f, MODELS "cube.off", 0.1, 1);
    const double spacings[] = {1e-6, 1e-30, 1e-200, 0};
    for (size_t i = 0; i < sizeof spacings / sizeof *spacings; ++i) {
        psplat_samples samples;
        psplat_error error = {0};
        assert_int_equal(
            psplat_samples_draw(&f.surface, spacings[i] * f.surface.diagonal, 1, &samples, &error),
            PSPLAT_ERROR_RANGE);
        assert_int_equal(error.code, PSPLAT_ERROR_RANGE);
        assert_null(samples.positions);
    }
    release(&f);
}

/* A mesh much smaller than the spacing gets one sample. */
static void test_few(void **state) {
    (void)state;
    fixture f;
    draw(&f, MODELS "sphere.ply", 1000, 1);
    assert_int_equal(f.samples.count, 1);
    assert_int_equal(f.samples.first[f.samples.clusters.count], f.samples.count);
    assert_int_equal(psplat_samples_near_triangle(&f.samples, 7), 0);
    release(&f);
    draw(&f, MODELS "cube.off", 1000, 1);
    assert_true(f.samples.count >= 6); /* creases line each of the six faces */
    release(&f);
}

int test_samples_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_on_triangles),  cmocka_unit_test(test_blocks),
        cmocka_unit_test(test_blue_noise),    cmocka_unit_test(test_creases_lined),
        cmocka_unit_test(test_deterministic), cmocka_unit_test(test_append),
        cmocka_unit_test(test_too_many),      cmocka_unit_test(test_few),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

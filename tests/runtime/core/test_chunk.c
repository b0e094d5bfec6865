/* SPDX-License-Identifier: MIT
 *
 * test_chunk.c - tests the culling of chunks, groups of up to 256 splats: a chunk that is left
 * out could not have been visible, and on ordinary models many chunks are left out. Shapes are
 * random groups of splats, a sphere and a plane; visibility is computed by sampling points of
 * each splat.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/chunk.h"
#include "scene_asset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static uint32_t seed = 20041u;

static double uniform(double low, double high) {
    return low + (high - low) * (double)scene_random(&seed);
}

static void multiply(const double a[16], const double b[16], double out[16]) {
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) {
            out[4 * c + r] = 0;
            for (int k = 0; k < 4; ++k) out[4 * c + r] += a[4 * k + r] * b[4 * c + k];
        }
}

/* Computes the inverse of an affine matrix by cofactors. */
static void invert_affine(const double m[16], double out[16]) {
    double det = 0;
    memset(out, 0, 16 * sizeof *out);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            int a = (k + 1) % 3, b = (k + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            out[4 * i + k] = m[4 * a + c] * m[4 * b + d] - m[4 * a + d] * m[4 * b + c];
        }
    for (int k = 0; k < 3; ++k) det += m[4 * k] * out[k];
    for (int i = 0; i < 12; ++i) out[i] /= det;
    for (int i = 0; i < 3; ++i) {
        out[12 + i] = 0;
        for (int k = 0; k < 3; ++k) out[12 + i] -= out[4 * k + i] * m[12 + k];
    }
    out[15] = 1;
}

static double determinant(const double m[16]) {
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
           m[8] * (m[1] * m[6] - m[2] * m[5]);
}

/* Makes a random scale, shear and reflection that places the splats in front of the camera, beside
 * it or around it. */
static void random_modelview(double m[16]) {
    memset(m, 0, 16 * sizeof *m);
    do {
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) m[4 * c + r] = uniform(-1, 1);
    } while (fabs(determinant(m)) < 0.05);
    m[12] = uniform(-3, 3);
    m[13] = uniform(-3, 3);
    m[14] = uniform(-6, 2);
    m[15] = 1;
}

static void projection_of(int is_perspective, double m[16]) {
    const double near = 0.5, far = 6, zoom = is_perspective ? 1.5 : 0.4;
    memset(m, 0, 16 * sizeof *m);
    m[0] = zoom;
    m[5] = 1.3 * zoom;
    m[10] = is_perspective ? -(far + near) / (far - near) : -2 / (far - near);
    m[11] = is_perspective ? -1 : 0;
    m[14] = is_perspective ? -2 * far * near / (far - near) : -(far + near) / (far - near);
    m[15] = is_perspective ? 0 : 1;
}

/* Places splats around a point so that they face roughly in one direction. steepness bounds the
 * numbers of their shapes. */
static void random_splats(psplat_splat *splats, size_t count, double steepness) {
    double place[3], spread = uniform(0.02, 1);
    for (int i = 0; i < 3; ++i) place[i] = uniform(-1, 1);
    for (size_t k = 0; k < count; ++k) {
        psplat_splat *s = &splats[k];
        double length = 0;
        memset(s, 0, sizeof *s);
        for (int i = 0; i < 3; ++i) s->center[i] = (float)(place[i] + uniform(-0.2, 0.2));
        for (int i = 0; i < 4; ++i) s->rotation[i] = (float)((i == 3) + spread * uniform(-1, 1));
        for (int i = 0; i < 4; ++i) length += (double)s->rotation[i] * (double)s->rotation[i];
        for (int i = 0; i < 4; ++i) s->rotation[i] /= (float)sqrt(length);
        s->radius[0] = (float)uniform(0.01, 0.2);
        s->radius[1] = s->radius[0] * 0.5f;
        for (int i = 0; i < 5; ++i) s->shape[i] = (float)(steepness * uniform(-1, 1));
    }
}

static void rotate(const float q[4], const double v[3], double out[3]) {
    double x = q[0], y = q[1], z = q[2], w = q[3];
    const double m[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                         2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                         2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    for (int r = 0; r < 3; ++r)
        out[r] = m[3 * r] * v[0] + m[3 * r + 1] * v[1] + m[3 * r + 2] * v[2];
}

static void apply(const double modelview[16], const double v[3], double out[3]) {
    for (int r = 0; r < 3; ++r)
        out[r] = modelview[r] * v[0] + modelview[4 + r] * v[1] + modelview[8 + r] * v[2];
}

/* Finds the point of a splat at (u, v) by eq. (1a), and a normal of the surface there from two
 * tangents, in eye space, in which no normal is transformed. */
static void find_point(const psplat_splat *s, const double modelview[16], double u, double v,
                       double point[3], double normal[3]) {
    double axes[3][3], ru = s->radius[0], rv = s->radius[1], q = rv / ru;
    const double x = s->shape[0], y = s->shape[1];
    const double a = s->shape[2], b = s->shape[3], g = s->shape[4];
    for (int k = 0; k < 3; ++k) {
        double axis[3];
        rotate(s->rotation, (const double[3]){k == 0, k == 1, k == 2}, axis);
        apply(modelview, axis, axes[k]);
    }
    double h = -ru * (x * u + a * u * u / 2 + g * q * u * v + q * y * v + q * b * v * v / 2);
    double by_u = -ru * (x + a * u + g * q * v), by_v = -ru * q * (g * u + y + b * v);
    double center[3] = {s->center[0], s->center[1], s->center[2]}, du[3], dv[3];
    apply(modelview, center, point);
    for (int i = 0; i < 3; ++i) {
        point[i] += modelview[12 + i] + u * ru * axes[0][i] + v * rv * axes[1][i] + h * axes[2][i];
        du[i] = ru * axes[0][i] + by_u * axes[2][i];
        dv[i] = rv * axes[1][i] + by_v * axes[2][i];
    }
    for (int i = 0; i < 3; ++i)
        normal[i] = du[(i + 1) % 3] * dv[(i + 2) % 3] - du[(i + 2) % 3] * dv[(i + 1) % 3];
}

/* Returns whether one of 25 points of the splat is visible: inside the view, on a front side.
 * Unlike the tested code, this uses no object space. */
static int shows(const psplat_splat *s, const double modelview[16], const double projection[16],
                 int is_perspective, int is_culled) {
    for (int k = 0; k < 25; ++k) {
        double r = sqrt((k + 0.5) / 25), a = 2.4 * k, p[4] = {0, 0, 0, 1}, n[3], clip[4];
        find_point(s, modelview, r * cos(a), r * sin(a), p, n);
        double facing = is_perspective ? -(n[0] * p[0] + n[1] * p[1] + n[2] * p[2]) : n[2];
        if (is_culled && !(facing * determinant(modelview) > 0)) continue;
        for (int row = 0; row < 4; ++row) {
            clip[row] = 0;
            for (int c = 0; c < 4; ++c) clip[row] += projection[4 * c + row] * p[c];
        }
        if (fabs(clip[0]) <= clip[3] && fabs(clip[1]) <= clip[3] && fabs(clip[2]) <= clip[3])
            return 1;
    }
    return 0;
}

static void test_left_out(void **state) {
    (void)state;
    enum { COUNT = 40, ROUNDS = 20000 };
    psplat_splat splats[COUNT];
    const double margin[2] = {0, 0}, ahead[3] = {0, 0, -1}, none[3] = {0, 0, 0};
    int hidden = 0;
    for (int round = 0; round < ROUNDS; ++round) {
        int is_perspective = round & 1, is_culled = !(round & 2), seen = 0;
        double modelview[16], inverse[16], projection[16], clip[16];
        psplat_chunk chunk;
        psplat_chunk_view view;
        size_t count = round & 8 ? 1 : COUNT; /* of one splat the bounds are tight */
        random_splats(splats, count, round & 4 ? uniform(0, 1) : 0);
        random_modelview(modelview);
        projection_of(is_perspective, projection);
        multiply(projection, modelview, clip);
        invert_affine(modelview, inverse);
        psplat_chunks_find(splats, count, &chunk);
        psplat_chunk_view_set(&view, clip, inverse, margin, is_perspective,
                              is_perspective ? none : ahead, is_culled);
        if (psplat_chunk_is_visible(&chunk, &view)) continue;
        ++hidden;
        for (size_t k = 0; k < count; ++k)
            seen += shows(&splats[k], modelview, projection, is_perspective, is_culled);
        assert_int_equal(seen, 0);
    }
    print_message("%d of %d chunks left out\n", hidden, (int)ROUNDS);
    assert_true(hidden > ROUNDS / 4);
}

/* Returns whether a point of a sphere lies beside the view, by its clip coordinates. */
static int pokes_out(const double center[3], double radius, const double clip[16]) {
    for (int k = 0; k < 200; ++k) {
        double z = -1 + (k + 0.5) / 100, ring = sqrt(1 - z * z), c[4];
        const double p[3] = {center[0] + radius * ring * cos(2.4 * k),
                             center[1] + radius * ring * sin(2.4 * k), center[2] + radius * z};
        for (int row = 0; row < 4; ++row)
            c[row] =
                clip[row] * p[0] + clip[4 + row] * p[1] + clip[8 + row] * p[2] + clip[12 + row];
        if (fabs(c[0]) > c[3] || fabs(c[1]) > c[3]) return 1;
    }
    return 0;
}

/* What lies between the sides does not poke out of them. Of what does not, few spheres reach a side
 * between the points that are looked at. */
static void test_between_sides(void **state) {
    (void)state;
    enum { ROUNDS = 20000 };
    const double margin[2] = {0, 0}, ahead[3] = {0, 0, -1}, none[3] = {0, 0, 0};
    int between = 0, missed = 0;
    for (int round = 0; round < ROUNDS; ++round) {
        int is_perspective = round & 1;
        double modelview[16], inverse[16], projection[16], clip[16], center[3], radius;
        psplat_chunk_view view;
        random_modelview(modelview);
        projection_of(is_perspective, projection);
        multiply(projection, modelview, clip);
        invert_affine(modelview, inverse);
        psplat_chunk_view_set(&view, clip, inverse, margin, is_perspective,
                              is_perspective ? none : ahead, 0);
        for (int i = 0; i < 3; ++i) center[i] = (double)(float)uniform(-1, 1);
        radius = (double)(float)uniform(0.01, 0.5);
        const float c[3] = {(float)center[0], (float)center[1], (float)center[2]};
        int pokes = pokes_out(center, radius, clip);
        if (psplat_sphere_is_between_sides(c, (float)radius, &view)) {
            ++between;
            assert_false(pokes);
        } else {
            missed += !pokes;
        }
    }
    print_message("%d of %d between the sides, %d missed\n", between, (int)ROUNDS, missed);
    assert_true(between > ROUNDS / 20);
    assert_true(missed < between / 20);
}

/* The sphere encloses curved patches; rounding to float counts a millionth. */
static void test_enclosed(void **state) {
    (void)state;
    const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    double greatest = 0;
    for (int round = 0; round < 1000; ++round) {
        psplat_splat splat;
        psplat_chunk chunk;
        random_splats(&splat, 1, 1);
        psplat_chunks_find(&splat, 1, &chunk);
        for (int k = 0; k < 40; ++k) {
            double point[3], normal[3], square = 0, angle = 0.157 * k;
            find_point(&splat, identity, cos(angle), sin(angle), point, normal);
            for (int i = 0; i < 3; ++i)
                square +=
                    (point[i] - (double)chunk.center[i]) * (point[i] - (double)chunk.center[i]);
            greatest = fmax(greatest, sqrt(square) / (double)chunk.radius);
        }
    }
    print_message("patches reach to %.3f of their spheres\n", greatest);
    assert_true(greatest <= 1 + 1e-6 && greatest > 0.8);
}

static int cell_of(const psplat_splat *s) {
    int cell = 0;
    for (int i = 0; i < 3; ++i) cell = 6 * cell + (int)(2.99f * (s->center[i] + 1));
    return cell;
}

static int by_cell(const void *a, const void *b) {
    return cell_of(a) - cell_of(b);
}

/* Half of a sphere faces away; in spatial order most of that half is noticed. */
static void test_sphere(void **state) {
    (void)state;
    scene s = scene_sphere(50000, 1);
    qsort(s.splats, s.count, sizeof *s.splats, by_cell);
    size_t count = psplat_chunk_count(s.count), hidden = 0;
    assert_int_equal(count, (50000 + PSPLAT_CHUNK_SPLATS - 1) / PSPLAT_CHUNK_SPLATS);
    psplat_chunk *chunks = malloc(count * sizeof *chunks);
    assert_non_null(chunks);
    psplat_chunks_find(s.splats, s.count, chunks);
    const double modelview[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5, 1};
    const double margin[2] = {0, 0}, none[3] = {0, 0, 0};
    double inverse[16], projection[16], clip[16];
    projection_of(1, projection);
    multiply(projection, modelview, clip);
    invert_affine(modelview, inverse);
    for (int is_culled = 0; is_culled < 2; ++is_culled) {
        psplat_chunk_view view;
        psplat_chunk_view_set(&view, clip, inverse, margin, 1, none, is_culled);
        hidden = 0;
        for (size_t i = 0; i < count; ++i) hidden += !psplat_chunk_is_visible(&chunks[i], &view);
        if (!is_culled) assert_int_equal(hidden, 0);
    }
    print_message("%zu of %zu chunks turned away\n", hidden, count);
    assert_true(hidden > count / 4 && hidden < count / 2 + count / 10);
    free(chunks);
    scene_free(&s);
}

/* A plane that is mirrored and squashed keeps its front; from the other side its back is seen. */
static void test_sides(void **state) {
    (void)state;
    scene s = scene_disc(1);
    psplat_chunk chunk;
    psplat_chunks_find(s.splats, 1, &chunk);
    const double squash[3] = {1, 1e-3, 3}, margin[2] = {0, 0}, none[3] = {0, 0, 0};
    for (int mirror = 0; mirror < 2; ++mirror)
        for (int behind = 0; behind < 2; ++behind) {
            double modelview[16] = {0}, inverse[16], projection[16], clip[16];
            psplat_chunk_view view;
            for (int i = 0; i < 3; ++i) modelview[5 * i] = squash[i];
            if (mirror) modelview[0] = -1;
            if (behind) modelview[10] = -modelview[10];
            modelview[14] = -4;
            modelview[15] = 1;
            projection_of(1, projection);
            multiply(projection, modelview, clip);
            invert_affine(modelview, inverse);
            psplat_chunk_view_set(&view, clip, inverse, margin, 1, none, 1);
            assert_int_equal(psplat_chunk_is_visible(&chunk, &view), !behind);
        }
    scene_free(&s);
}

int test_chunk_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_left_out), cmocka_unit_test(test_between_sides),
        cmocka_unit_test(test_enclosed), cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_sides),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

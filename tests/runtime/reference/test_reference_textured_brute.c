/* SPDX-License-Identifier: MIT
 *
 * test_reference_textured_brute.c - tests textures of the reference rasteriser (spec 3.11) on
 * random splats, images and views against another way to find everything: texels weighed by tents
 * over the plane, mipmaps as integrals, and derivatives as differences between pictures that are
 * shifted by a little.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "textured_fixture.h"

/* ---- random splats -------------------------------------------------------------------------- */

static double between(uint32_t *random, double low, double high) {
    return low + (high - low) * (double)scene_random(random);
}

typedef struct study {
    plate p;
    psplat_view view;
    uint8_t texels[9 * 9 * 4];
    int width, height, wrap[2];
} study;

static void random_plate(study *s, uint32_t *random) {
    static const int wraps[] = {10497, 33071, 33648};
    static char sampler[2][60];
    s->p = disc();
    plate *p = &s->p;
    p->is_second = p->has_field = 1;
    double scale = pow(10, between(random, -1, 1));
    double *const terms[] = {p->at, p->u, p->v, p->uu, p->uv, p->vv};
    for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 2; ++k)
            terms[i][k] = (double)(float)(scale * between(random, -1, 1) * (i < 3 ? 1 : 0.3));
    for (int i = 0; i < 3; ++i) p->fields[i] = between(random, -1, 1);
    p->radii[1] = between(random, 0.3, 1);
    p->extension = scene_random(random) < 0.5f ? STILL : STILL ",\"curved\":true";
    for (int i = 0; i < 2; ++i) s->wrap[i] = (int)between(random, 0, 2.99);
    snprintf(sampler[0], sizeof sampler[0], "\"wrapS\":%d,\"wrapT\":%d", wraps[s->wrap[0]],
             wraps[s->wrap[1]]);
    p->sampler = sampler[0];
    p->material = "{\"doubleSided\":true,\"pbrMetallicRoughness\":{\"baseColorTexture\":{"
                  "\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0.3,-0.2],"
                  "\"rotation\":0.7,\"scale\":[1.25,0.8]}}}}}";
}

static void random_study(study *s, uint32_t *random) {
    random_plate(s, random);
    s->width = (int)between(random, 1, 9.99);
    s->height = (int)between(random, 1, 9.99);
    for (int i = 0; i < s->width * s->height * 4; ++i)
        s->texels[i] = (uint8_t)between(random, 0, 255.99);
    s->view = camera_view(SIZE, SIZE);
    s->view.shading = PSPLAT_SHADING_UNLIT;
    double eye[3], target[3];
    for (int i = 0; i < 3; ++i) {
        eye[i] = between(random, -3, 3);
        target[i] = between(random, -0.3, 0.3);
    }
    eye[2] += eye[2] > 0 ? 2 : -2;
    camera_look(&s->view, eye, target);
    if (scene_random(random) < 0.4f)
        camera_parallel(&s->view, between(random, 0.5, 2), -10, 20);
    else
        camera_perspective(&s->view, between(random, 20, 60), 0.1, 20);
}

/* Draws the study with all points moved by so many pixels. */
static picture draw_moved(const study *s, double x, double y) {
    const psplat_pixels image = {
        .rgba = s->texels, .width = (uint32_t)s->width, .height = (uint32_t)s->height};
    psplat_view view = s->view;
    for (int column = 0; column < 4; ++column) {
        double *m = view.projection + 4 * column;
        m[0] += 2 * x / SIZE * m[3];
        m[1] += 2 * y / SIZE * m[3];
    }
    return draw(&s->p, 1, &image, 1, NULL, &view);
}

/* Returns the image's coordinates at (u, v). */
static void image_at(const plate *p, double u, double v, double st[2]) {
    const double c = cos(0.7), s = sin(0.7);
    double t[2];
    for (int i = 0; i < 2; ++i)
        t[i] = p->at[i] + u * p->u[i] + v * p->v[i] + u * u * p->uu[i] + u * v * p->uv[i] +
               v * v * p->vv[i];
    st[0] = 0.3 + c * 1.25 * t[0] + s * 0.8 * t[1];
    st[1] = -0.2 - s * 1.25 * t[0] + c * 0.8 * t[1];
}

/* Returns the texel that shows at a whole number, found by walking towards the image. */
static int walk(int at, int size, int wrap) {
    if (wrap == 1) return at < 0 ? 0 : at >= size ? size - 1 : at;
    while (at < 0 || at >= size) {
        if (wrap == 0)
            at += at < 0 ? size : -size;
        else
            at = at < 0 ? -1 - at : 2 * size - 1 - at;
    }
    return at;
}

/* Returns the mean of the image over a texel of a level, as an integral over its square. */
static double texel_mean(const study *s, int x, int y, int width, int height) {
    double sum = 0, wide = (double)s->width / width, high = (double)s->height / height;
    for (int row = 0; row < s->height; ++row)
        for (int column = 0; column < s->width; ++column) {
            double a = fmin(column + 1, (x + 1) * wide) - fmax(column, x * wide);
            double b = fmin(row + 1, (y + 1) * high) - fmax(row, y * high);
            if (a <= 0 || b <= 0) continue;
            sum += a * b * decoded(s->texels[4 * (row * s->width + column)]);
        }
    return sum / (wide * high);
}

/* Returns the value between texels of a level, by the tent of each texel that reaches there. */
static double tents(const study *s, const double st[2], int level) {
    int width = s->width >> level ? s->width >> level : 1;
    int height = s->height >> level ? s->height >> level : 1;
    double x = st[0] * width - 0.5, y = st[1] * height - 0.5, sum = 0;
    for (int row = (int)y - 3; row <= (int)y + 3; ++row)
        for (int column = (int)x - 3; column <= (int)x + 3; ++column) {
            double a = 1 - fabs(x - column), b = 1 - fabs(y - row);
            if (a <= 0 || b <= 0) continue;
            sum += a * b *
                   texel_mean(s, walk(column, width, s->wrap[0]), walk(row, height, s->wrap[1]),
                              width, height);
        }
    return sum;
}

static double sampled(const study *s, const double st[2], double texels) {
    int most = (int)floor(log2(s->width > s->height ? s->width : s->height));
    double level = texels > 1 ? fmin(log2(texels), most) : 0;
    int below = (int)level;
    double finer = tents(s, st, below);
    return below < most ? finer + (level - below) * (tents(s, st, below + 1) - finer) : finer;
}

/* Where the level hardly changes: the differences are off by a part of 1e-5 where the surface is
 * not seen along its contour, and a level by little more. */
static size_t check_study(const study *s) {
    const double step = 1e-3;
    picture p = draw_moved(s, 0, 0);
    picture moved_by[4] = {draw_moved(s, step, 0), draw_moved(s, -step, 0), draw_moved(s, 0, step),
                           draw_moved(s, 0, -step)};
    size_t checked = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        int is_clear = p.image.tie[i] > 0.05 && p.image.count[i] == 1;
        if (!is_clear) continue;
        double st[2], at[4][2], most = 0;
        image_at(&s->p, p.image.uv[2 * i], p.image.uv[2 * i + 1], st);
        for (int k = 0; k < 4; ++k)
            image_at(&s->p, moved_by[k].image.uv[2 * i], moved_by[k].image.uv[2 * i + 1], at[k]);
        for (int k = 0; k < 4; k += 2)
            most = fmax(most, hypot((at[k][0] - at[k + 1][0]) * s->width,
                                    (at[k][1] - at[k + 1][1]) * s->height) /
                                  (2 * step));
        assert_near((double)p.image.color[4 * i], sampled(s, st, most), 1e-4);
        ++checked;
    }
    picture_free(&p);
    for (int k = 0; k < 4; ++k) picture_free(&moved_by[k]);
    return checked;
}

static void test_random(void **state) {
    (void)state;
    uint32_t random = 2024;
    size_t checked = 0;
    for (int i = 0; i < 60; ++i) {
        study s;
        random_study(&s, &random);
        checked += check_study(&s);
    }
    assert_true(checked > 3000);
}

/* ---- random normals ------------------------------------------------------------------------- */

/* Returns a random transform of the scene, which scales its axes apart and may mirror it. */
static void random_transform(double m[16], uint32_t *random) {
    double mirror = scene_random(random) < 0.5f ? -1 : 1;
    for (int i = 0; i < 16; ++i) m[i] = i % 5 == 0;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            m[4 * column + row] =
                (column ? 1 : mirror) * (between(random, -0.3, 0.3) + (row == column));
}

/* Finds the point in eye space that a pixel shows, from its depth. */
static void unproject(const psplat_view *view, int pixel, double depth, double p[3]) {
    const double *m = view->projection;
    const double at[2] = {middle(pixel % SIZE), middle(pixel / SIZE)};
    double z = 2 * depth - 1;
    p[2] = (m[14] - z * m[15]) / (z * m[11] - m[10]);
    double w = m[11] * p[2] + m[15];
    for (int i = 0; i < 2; ++i) p[i] = (at[i] * w - m[8 + i] * p[2] - m[12 + i]) / m[5 * i];
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalise(double a[3]) {
    double length = sqrt(dot(a, a));
    for (int i = 0; i < 3; ++i) a[i] /= length;
}

/* The changes of the point and of the image's coordinates to the next pixel to the right, and
 * above.
 */
typedef struct change {
    double p[2][3], st[2][2];
} change;

/* Turns a unit normal by eq. (4e), the change of the point with the image's coordinates being found
 * from both changes by pixels. Returns a measure of how well that is known, at most 1. */
static double turn(const change *c, double n[3]) {
    const double x = 2 * 200 / 255.0 - 1, y = 2 * 90 / 255.0 - 1, z = 2 * 230 / 255.0 - 1;
    double determinant = c->st[0][0] * c->st[1][1] - c->st[0][1] * c->st[1][0];
    double sizes = hypot(c->st[0][0], c->st[0][1]) * hypot(c->st[1][0], c->st[1][1]), t[3], b[3];
    for (int i = 0; i < 3; ++i) {
        t[i] = (c->st[1][1] * c->p[0][i] - c->st[0][1] * c->p[1][i]) / determinant;
        b[i] = (c->st[0][0] * c->p[1][i] - c->st[1][0] * c->p[0][i]) / determinant;
    }
    double along = dot(t, n), up = dot(b, n), size = sqrt(dot(b, b));
    for (int i = 0; i < 3; ++i) t[i] -= along * n[i];
    normalise(t);
    /* Green points against b, as far as b is perpendicular to the normal and to t. */
    double across = dot(t, b);
    for (int i = 0; i < 3; ++i) b[i] = -(b[i] - up * n[i] - across * t[i]);
    double left = sqrt(dot(b, b)) / size;
    normalise(b);
    for (int i = 0; i < 3; ++i) n[i] = x * t[i] + y * b[i] + z * n[i];
    normalise(n);
    return fmin(fabs(determinant) / sizes, left);
}

/* Draws the study moved by so many pixels, with its normal texture or without. */
static picture draw_bumps(const study *s, const double transform[16], double x, double y,
                          int is_bumpy) {
    const psplat_pixels image = {.rgba = leaning, .width = 1, .height = 1};
    psplat_view view = s->view;
    for (int column = 0; column < 4; ++column) {
        double *m = view.projection + 4 * column;
        m[0] += 2 * x / SIZE * m[3];
        m[1] += 2 * y / SIZE * m[3];
    }
    return draw(&s->p, 1, &image, (size_t)is_bumpy, transform, &view);
}

static size_t check_bumps(const study *s, const double transform[16]) {
    const double step = 1e-3, moves[4][2] = {{step, 0}, {-step, 0}, {0, step}, {0, -step}};
    picture smooth = draw_bumps(s, transform, 0, 0, 0), bumpy = draw_bumps(s, transform, 0, 0, 1);
    picture moved_by[4];
    size_t checked = 0;
    for (int k = 0; k < 4; ++k) moved_by[k] = draw_bumps(s, transform, moves[k][0], moves[k][1], 0);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        if (!(smooth.image.tie[i] > 0.2 && smooth.image.count[i])) continue;
        double at[4][2], p[4][3], n[3];
        change c;
        for (int k = 0; k < 4; ++k) {
            const psplat_reference_image *image = &moved_by[k].image;
            image_at(&s->p, image->uv[2 * i], image->uv[2 * i + 1], at[k]);
            psplat_view view = s->view;
            for (int column = 0; column < 4; ++column) {
                double *m = view.projection + 4 * column;
                for (int row = 0; row < 2; ++row) m[row] += 2 * moves[k][row] / SIZE * m[3];
            }
            unproject(&view, i, image->depth[i], p[k]);
        }
        for (int k = 0; k < 2; ++k) {
            for (int row = 0; row < 3; ++row) c.p[k][row] = p[2 * k][row] - p[2 * k + 1][row];
            for (int row = 0; row < 2; ++row) c.st[k][row] = at[2 * k][row] - at[2 * k + 1][row];
        }
        for (int row = 0; row < 3; ++row) n[row] = 2 * (double)smooth.image.color[4 * i + row] - 1;
        normalise(n);
        if (turn(&c, n) < 0.1) continue; /* where differences say little */
        for (int row = 0; row < 3; ++row)
            assert_near((double)bumpy.image.color[4 * i + row], 0.5 + 0.5 * n[row], 2e-4);
        ++checked;
    }
    picture_free(&smooth);
    picture_free(&bumpy);
    for (int k = 0; k < 4; ++k) picture_free(&moved_by[k]);
    return checked;
}

/* Fronts alone are drawn here; test_placed_normals has backs. */
static void test_random_normals(void **state) {
    (void)state;
    uint32_t random = 77;
    size_t checked = 0;
    for (int i = 0; i < 60; ++i) {
        study s;
        double transform[16];
        random_study(&s, &random);
        random_transform(transform, &random);
        s.p.material = "{\"normalTexture\":{\"index\":0,\"extensions\":{"
                       "\"KHR_texture_transform\":{\"offset\":[0.3,-0.2],\"rotation\":0.7,"
                       "\"scale\":[1.25,0.8]}}}}";
        s.view.shading = PSPLAT_SHADING_NORMAL;
        checked += check_bumps(&s, transform);
    }
    assert_true(checked > 3000);
}

int test_reference_textured_brute_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random),
        cmocka_unit_test(test_random_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

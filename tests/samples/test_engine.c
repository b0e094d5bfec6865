/* SPDX-License-Identifier: MIT
 *
 * test_engine.c - tests samples/engine on small assets, in both of its ways to draw: a red sphere
 * in its ring of brass, and green cubes around it. It checks the colours in the picture, where they
 * are and how many pixels have each, that splats of the floor's plane get the floor's light, and
 * that splats cast shadows on meshes.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "scene_asset.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 960, HEIGHT = 640 };

typedef enum hue { NEITHER, RED, GREEN, BRASS } hue;

static const char directory[] = PSPLAT_BINARY_DIR "/tests";

/* Writes and frees a scene. */
static void write_glb(const char *name, scene *s) {
    char path[1000];
    size_t size;
    snprintf(path, sizeof path, "%s/%s", directory, name);
    uint8_t *glb = scene_glb(s, &size);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(glb, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    free(glb);
    scene_free(s);
}

static void write_scene(const char *name, scene *s, float red, float green) {
    s->material.base_color[0] = red;
    s->material.base_color[1] = green;
    s->material.base_color[2] = 0;
    write_glb(name, s);
}

/* way is "" or "--deferred". */
static int run(const char *way, const char *first, const char *second, const char *out) {
    char command[4000];
    snprintf(command, sizeof command, "cd '%s' && '%s' %s %s %s %s 2>engine.txt >engine.out",
             directory, PSPLAT_ENGINE, way, first, second, out);
    return system(command);
}

static void read_picture(const char *name, uint8_t *rgb) {
    char path[1000], head[16] = "";
    snprintf(path, sizeof path, "%s/%s", directory, name);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fread(head, 1, 15, file), 15);
    assert_string_equal(head, "P6 960 640 255\n");
    assert_int_equal(fread(rgb, 3, WIDTH * HEIGHT, file), WIDTH * HEIGHT);
    assert_int_equal(fgetc(file), EOF);
    fclose(file);
}

/* Distinguishes colours by the ratios of channels, which light and shade do not change and
 * highlights only lessen. */
static hue hue_of(const uint8_t *p) {
    float red = p[0], green = p[1], blue = p[2];
    if (red > 40 && red > 1.6f * green) return RED;
    if (green > 40 && green > 1.6f * red) return GREEN;
    return red > 1.4f * blue ? BRASS : NEITHER;
}

static void try_picture(const char *way) {
    static uint8_t rgb[WIDTH * HEIGHT * 3];
    scene sphere = scene_sphere(300, 5.0f), cube = scene_cube(0.01f);
    sphere.origin[0] = 1e5; /* its place and size in the file do not matter */
    write_scene("engine_sphere.glb", &sphere, 0.8f, 0);
    write_scene("engine_cube.glb", &cube, 0, 0.8f);
    assert_int_equal(run(way, "engine_sphere.glb", "engine_cube.glb", "engine.ppm"), 0);
    read_picture("engine.ppm", rgb);

    int counts[4] = {0};
    for (int i = 0; i < WIDTH * HEIGHT; ++i) ++counts[hue_of(rgb + 3 * i)];
    /* The sphere of radius 0.8 at a distance of 7 shows pi (0.8 / 7 * 2.2 / 2 * 640)^2 = 20,000
     * pixels, of which the ring hides a fifth. Seven cubes of 0.75 above the floor show more than
     * that. */
    assert_in_range(counts[RED], 13000, 20000);
    assert_in_range(counts[BRASS], 3000, 8000);
    assert_in_range(counts[GREEN], 20000, 80000);

    /* Down the middle there are the sphere, the ring before it, and the sphere again, but nothing
     * of the ring behind it. */
    hue seen[64] = {NEITHER};
    int steps = 0;
    for (int y = 0; y < HEIGHT && steps < 62; ++y) {
        hue here = hue_of(rgb + 3 * (y * WIDTH + WIDTH / 2));
        if (here != seen[steps]) seen[++steps] = here;
    }
    const hue wanted[] = {NEITHER, RED, BRASS, RED, NEITHER};
    assert_true(steps >= 4);
    assert_memory_equal(seen, wanted, sizeof wanted);
}

static void test_picture(void **state) {
    (void)state;
    try_picture("");
    try_picture("--deferred");
}

/* ---- one light for meshes and splats --------------------------------------------------------- */

static void lay_disc(psplat_splat *splat, float y, float radius) {
    static const double u[3] = {0, 0, 1}, v[3] = {1, 0, 0};
    scene_set_axes(splat, u, v); /* it faces up */
    splat->normal[1] = 1;
    splat->normal[2] = 0;
    splat->center[1] = y;
    splat->radius[0] = splat->radius[1] = radius;
}

/* Writes a disc of the floor's kind that the engine places at a height above the floor. Two
 * specks make the asset 1.1 high, so that the engine leaves its size alone: it spans -0.45 to 0.65.
 */
static void write_patch(const char *name, float height, float radius, const float color[3]) {
    scene s = scene_blank(3);
    lay_disc(&s.splats[0], 0, 1e-4f);
    lay_disc(&s.splats[1], 1.1f, 1e-4f);
    lay_disc(&s.splats[2], 0.45f + height, radius);
    s.depth_tolerance = 5e-4f;
    s.material.roughness = 0.8f;
    memcpy(s.material.base_color, color, 3 * sizeof *color);
    write_glb(name, &s);
}

static void draw(const char *way, const char *first, const char *second, uint8_t *rgb) {
    assert_int_equal(run(way, first, second, "engine.ppm"), 0);
    read_picture("engine.ppm", rgb);
}

/* Discs of the floor's material two millimetres above it look as the floor does, in light and in
 * shadow: the deferred way lights both by the same pass. */
static void test_same_light(void **state) {
    (void)state;
    static const float slate[3] = {0.16f, 0.18f, 0.22f}, green[3] = {0, 0.8f, 0};
    static uint8_t floor[WIDTH * HEIGHT * 3], discs[WIDTH * HEIGHT * 3], mask[WIDTH * HEIGHT * 3];
    scene sphere = scene_sphere(300, 5.0f);
    write_scene("engine_ball.glb", &sphere, 0.8f, 0);
    write_patch("engine_under.glb", -0.1f, 0.9f, slate);
    write_patch("engine_discs.glb", 0.002f, 0.9f, slate);
    write_patch("engine_green.glb", 0.002f, 0.9f, green);
    draw("--deferred", "engine_ball.glb", "engine_under.glb", floor);
    draw("--deferred", "engine_ball.glb", "engine_discs.glb", discs);
    draw("--deferred", "engine_ball.glb", "engine_green.glb", mask);
    int seen = 0, dark = 0, differ = 0, edges = 0;
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i += 3) {
        if (hue_of(mask + i) != GREEN) continue;
        int most = 0;
        for (int k = 0; k < 3; ++k) {
            int by = abs(floor[i + k] - discs[i + k]);
            if (by > most) most = by;
        }
        ++seen;
        dark += floor[i] < 70;
        differ += most > 1;
        edges += most > 12;
    }
    print_message("%d pixels, %d in shadow, %d differ by more than a step, %d by more than 12\n",
                  seen, dark, differ, edges);
    assert_true(seen > 40000);
    assert_true(dark > 500);
    /* A step of 8 bits is rounding. Shadows are two millimetres elsewhere, less than a texel of the
     * map, so that pixels of their outlines differ. */
    assert_true(differ < seen / 100);
    assert_true(edges < seen / 500);
}

/* Without the sphere the floor is lighter where its shadow was. */
static void try_cast(const char *way) {
    static const float slate[3] = {0.16f, 0.18f, 0.22f};
    static uint8_t with[WIDTH * HEIGHT * 3], without[WIDTH * HEIGHT * 3];
    scene sphere = scene_sphere(300, 5.0f);
    write_scene("engine_ball.glb", &sphere, 0.8f, 0);
    write_patch("engine_specks.glb", -0.1f, 1e-4f, slate);
    draw(way, "engine_ball.glb", "engine_specks.glb", with);
    draw(way, "engine_specks.glb", "engine_specks.glb", without);
    int darker = 0, lighter = 0;
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i += 3) {
        if (hue_of(with + i) != NEITHER || hue_of(without + i) != NEITHER) continue;
        darker += with[i] + 15 < without[i];
        lighter += with[i] > without[i] + 15;
    }
    print_message("%d pixels are in the shadow of splats\n", darker);
    assert_true(darker > 3000);
    assert_true(lighter < 20); /* pixels of outlines, of which the samples mix several colours */
}

static void test_cast(void **state) {
    (void)state;
    try_cast("");
    try_cast("--deferred");
}

static void test_refusals(void **state) {
    (void)state;
    assert_int_not_equal(run("", "missing.glb", "missing.glb", "engine.ppm"), 0);
    assert_int_not_equal(run("", "", "", ""), 0);
    assert_int_not_equal(run("--other", "engine_cube.glb", "engine_cube.glb", "engine.ppm"), 0);
    assert_int_not_equal(run("", "engine_cube.glb", "engine_cube.glb", "missing/engine.ppm"), 0);
}

int test_engine_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_picture),
        cmocka_unit_test(test_same_light),
        cmocka_unit_test(test_cast),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_engine.c - tests samples/engine on small assets: a red sphere in its ring of brass, and
 * green cubes around it. It checks the colours in the picture, where they are and how many pixels
 * have each.
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

static void write_scene(const char *name, scene *s, float red, float green) {
    char path[1000];
    size_t size;
    s->material.base_color[0] = red;
    s->material.base_color[1] = green;
    s->material.base_color[2] = 0;
    snprintf(path, sizeof path, "%s/%s", directory, name);
    uint8_t *glb = scene_glb(s, &size);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(glb, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    free(glb);
    scene_free(s);
}

static int run(const char *first, const char *second, const char *out) {
    char command[4000];
    snprintf(command, sizeof command, "cd '%s' && '%s' %s %s %s 2>engine.txt >engine.out",
             directory, PSPLAT_ENGINE, first, second, out);
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

static void test_picture(void **state) {
    (void)state;
    static uint8_t rgb[WIDTH * HEIGHT * 3];
    scene sphere = scene_sphere(300, 5.0f), cube = scene_cube(0.01f);
    sphere.origin[0] = 1e5; /* its place and size in the file do not matter */
    write_scene("engine_sphere.glb", &sphere, 0.8f, 0);
    write_scene("engine_cube.glb", &cube, 0, 0.8f);
    assert_int_equal(run("engine_sphere.glb", "engine_cube.glb", "engine.ppm"), 0);
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

static void test_refusals(void **state) {
    (void)state;
    assert_int_not_equal(run("missing.glb", "missing.glb", "engine.ppm"), 0);
    assert_int_not_equal(run("", "", ""), 0);
    assert_int_not_equal(run("engine_cube.glb", "engine_cube.glb", "missing/engine.ppm"), 0);
}

int test_engine_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_picture),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_loader.c - tests opening and watching files on the worker thread, with small assets that are
 * written, replaced, broken and removed.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <viewer.h>

#include "scene_asset.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

typedef struct fixture {
    char directory[64], cube[96], ball[96], missing[96];
    loader *loader;
} fixture;

static void write_scene(const char *path, scene s) {
    size_t size;
    char part[128];
    uint8_t *glb = scene_glb(&s, &size);
    snprintf(part, sizeof part, "%s.part", path);
    FILE *file = fopen(part, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(glb, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(rename(part, path), 0);
    free(glb);
    scene_free(&s);
}

static void wake(void) {
}

static int set_up(void **state) {
    fixture *f = calloc(1, sizeof *f);
    strcpy(f->directory, "/tmp/phongsplat-XXXXXX");
    assert_non_null(mkdtemp(f->directory));
    snprintf(f->cube, sizeof f->cube, "%s/cube.glb", f->directory);
    snprintf(f->ball, sizeof f->ball, "%s/ball.glb", f->directory);
    snprintf(f->missing, sizeof f->missing, "%s/missing.glb", f->directory);
    write_scene(f->cube, scene_cube(1));
    write_scene(f->ball, scene_sphere(100, 1));
    f->loader = loader_create(wake, 0);
    assert_non_null(f->loader);
    *state = f;
    return 0;
}

static int tear_down(void **state) {
    fixture *f = *state;
    loader_destroy(f->loader);
    unlink(f->cube);
    unlink(f->ball);
    unlink(f->missing);
    assert_int_equal(rmdir(f->directory), 0);
    free(f);
    return 0;
}

/* Returns the next load and waits for it up to a minute. */
static load *next_load(const fixture *f) {
    for (int i = 0; i < 60000; ++i) {
        load *taken = loader_take(f->loader);
        if (taken) return taken;
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    }
    fail_msg("nothing was loaded");
    return NULL;
}

static void expect_file(const loaded_file *file, const char *path, size_t splats,
                        psplat_result code) {
    assert_string_equal(file->path, path);
    assert_int_equal(file->splat_count, splats);
    assert_int_equal(file->error.code, code);
    assert_true(!file->asset == (code != PSPLAT_OK));
}

static void test_a_set_is_opened_in_its_order(void **state) {
    const fixture *f = *state;
    const char *paths[] = {f->ball, f->missing, f->cube, f->ball};
    assert_int_equal(loader_open(f->loader, paths, 4), 1);
    load *l = next_load(f);
    assert_int_equal(l->is_reload, 0);
    assert_int_equal(l->count, 3); /* a path that is given twice is opened once */
    expect_file(&l->files[0], f->ball, 100, PSPLAT_OK);
    expect_file(&l->files[1], f->missing, 0, PSPLAT_ERROR_READ);
    expect_file(&l->files[2], f->cube, 6, PSPLAT_OK);
    assert_true(l->files[2].bounds.radius > 1.7 && l->files[2].bounds.radius < 1.8);
    load_destroy(l);
    assert_int_equal(loader_is_busy(f->loader), 0);
}

static void test_what_changes_is_opened_again(void **state) {
    const fixture *f = *state;
    const char *paths[] = {f->ball, f->missing, f->cube};
    assert_int_equal(loader_open(f->loader, paths, 3), 1);
    load_destroy(next_load(f));
    write_scene(f->cube, scene_sphere(7, 1));
    load *l = next_load(f);
    assert_int_equal(l->is_reload, 1);
    assert_int_equal(l->count, 1);
    expect_file(&l->files[0], f->cube, 7, PSPLAT_OK);
    load_destroy(l);
    write_scene(f->missing, scene_cube(1)); /* the missing file comes into being */
    l = next_load(f);
    assert_int_equal(l->count, 1);
    expect_file(&l->files[0], f->missing, 6, PSPLAT_OK);
    load_destroy(l);
    assert_int_equal(unlink(f->ball), 0);
    l = next_load(f);
    assert_int_equal(l->count, 1);
    expect_file(&l->files[0], f->ball, 0, PSPLAT_ERROR_READ);
    load_destroy(l);
}

static void test_reload_opens_all(void **state) {
    const fixture *f = *state;
    const char *paths[] = {f->ball, f->cube};
    assert_int_equal(loader_open(f->loader, paths, 2), 1);
    load_destroy(next_load(f));
    loader_reload(f->loader);
    load *l = next_load(f);
    assert_int_equal(l->is_reload, 1);
    assert_int_equal(l->count, 2);
    expect_file(&l->files[0], f->ball, 100, PSPLAT_OK);
    expect_file(&l->files[1], f->cube, 6, PSPLAT_OK);
    load_destroy(l);
}

/* A set of which nothing opens does not end the watch over the files that are shown. */
static void test_a_useless_set_changes_no_watch(void **state) {
    const fixture *f = *state;
    const char *cube = f->cube, *useless[] = {f->missing, f->directory};
    assert_int_equal(loader_open(f->loader, &cube, 1), 1);
    load_destroy(next_load(f));
    assert_int_equal(loader_open(f->loader, useless, 2), 1);
    load *l = next_load(f);
    assert_int_equal(l->count, 2);
    expect_file(&l->files[0], f->missing, 0, PSPLAT_ERROR_READ);
    expect_file(&l->files[1], f->directory, 0, PSPLAT_ERROR_READ);
    load_destroy(l);
    write_scene(f->cube, scene_sphere(7, 1));
    l = next_load(f);
    expect_file(&l->files[0], f->cube, 7, PSPLAT_OK);
    load_destroy(l);
}

/* Images are decoded on the worker; a file with one that cannot be is not opened. */
static void test_images_are_decoded(void **state) {
    const fixture *f = *state;
    scene s = scene_disc(1);
    scene_add_textures(&s); /* with an image of no format */
    write_scene(f->missing, s);
    const char *paths[] = {PSPLAT_SOURCE_DIR "/schema/textured.gltf", f->missing};
    assert_int_equal(loader_open(f->loader, paths, 2), 1);
    load *l = next_load(f);
    const loaded_file *good = &l->files[0], *bad = &l->files[1];
    assert_int_equal(good->error.code, PSPLAT_OK);
    assert_true(psplat_asset_image_count(good->asset) > 0);
    for (size_t i = 0; i < psplat_asset_image_count(good->asset); ++i)
        assert_true(good->images[i].width > 0 && good->images[i].rgba);
    assert_int_equal(bad->error.code, PSPLAT_ERROR_FORMAT);
    assert_non_null(strstr(bad->error.text, "image/x-raw"));
    assert_null(bad->asset);
    load_destroy(l);
}

/* A pipe without a writer would block the worker for ever. */
static void test_a_pipe_is_refused(void **state) {
    const fixture *f = *state;
    const char *path = f->missing;
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(loader_open(f->loader, &path, 1), 1);
    load *l = next_load(f);
    expect_file(&l->files[0], f->missing, 0, PSPLAT_ERROR_READ);
    load_destroy(l);
}

/* Loads that nobody took are freed with the loader; the leak checker would report them. */
static void test_ending_early_frees_everything(void **state) {
    fixture *f = *state;
    const char *paths[] = {f->ball, f->cube};
    for (int i = 0; i < 20; ++i) {
        loader *l = loader_create(wake, 0);
        assert_non_null(l);
        for (int k = 0; k < i; ++k) assert_int_equal(loader_open(l, paths, 2), 1);
        loader_destroy(l);
    }
    loader_destroy(NULL);
    load_destroy(NULL);
}

int test_loader_main(void) {
#define LOADER_TEST(function) cmocka_unit_test_setup_teardown(function, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        LOADER_TEST(test_a_set_is_opened_in_its_order),
        LOADER_TEST(test_what_changes_is_opened_again),
        LOADER_TEST(test_reload_opens_all),
        LOADER_TEST(test_a_useless_set_changes_no_watch),
        LOADER_TEST(test_a_pipe_is_refused),
        LOADER_TEST(test_images_are_decoded),
        LOADER_TEST(test_ending_early_frees_everything),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

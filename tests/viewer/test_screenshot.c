/* SPDX-License-Identifier: MIT
 *
 * test_screenshot.c - tests screenshots: they lie beside the asset with a number, never replace a
 * file, and are complete or absent, even when the process is killed or the disk is full.
 */
#define _GNU_SOURCE /* for O_TMPFILE */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <viewer.h>

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static int create(const char *asset, const char *text, char *path, size_t size) {
    return screenshot_create(asset, NULL, (const uint8_t *)text, strlen(text), path, size);
}

static void assert_name(const char *asset, const char *directory, int n, const char *expected) {
    char path[64];
    assert_int_equal(screenshot_name(asset, directory, n, path, sizeof path), 1);
    assert_string_equal(path, expected);
}

static void test_names(void **state) {
    (void)state;
    assert_name("part.glb", NULL, 1, "part-001.png");
    assert_name("some/where/part.glb", NULL, 12, "some/where/part-012.png");
    assert_name("/part.glb", NULL, 1234, "/part-1234.png");
    assert_name("some/where/part.glb", "pictures", 3, "pictures/part-003.png");
    assert_name("some/where/part.glb", ".", 3, "./part-003.png");
    /* Only the last dot of the name starts a suffix, and not one at its beginning. */
    assert_name("a.b/part", NULL, 1, "a.b/part-001.png");
    assert_name("a/part.v2.glb", NULL, 1, "a/part.v2-001.png");
    assert_name("a/.glb", NULL, 1, "a/.glb-001.png");
}

static void test_names_too_long_are_refused(void **state) {
    (void)state;
    char path[13] = "";
    assert_int_equal(screenshot_name("part.glb", NULL, 1, path, sizeof path), 1);
    assert_int_equal(screenshot_name("parts.glb", NULL, 1, path, sizeof path), 0);
    assert_int_equal(create("parts.glb", "", path, sizeof path), ENAMETOOLONG);
}

static void test_the_first_free_number_is_taken(void **state) {
    (void)state;
    char directory[] = "/tmp/phongsplat-XXXXXX", asset[64], path[64], expected[64];
    assert_non_null(mkdtemp(directory));
    snprintf(asset, sizeof asset, "%s/x.glb", directory);
    for (int n = 1; n <= 3; ++n) {
        assert_int_equal(create(asset, "kept", path, sizeof path), 0);
        snprintf(expected, sizeof expected, "%s/x-%03d.png", directory, n);
        assert_string_equal(path, expected);
    }
    /* A gap in the numbers is filled; existing files stay. */
    snprintf(expected, sizeof expected, "%s/x-002.png", directory);
    assert_int_equal(unlink(expected), 0);
    assert_int_equal(create(asset, "new", path, sizeof path), 0);
    assert_string_equal(path, expected);
    snprintf(expected, sizeof expected, "%s/x-003.png", directory);
    FILE *file = fopen(expected, "rb");
    char text[8] = "";
    assert_int_equal(fread(text, 1, sizeof text, file), 4);
    fclose(file);
    for (int n = 1; n <= 3; ++n) {
        snprintf(path, sizeof path, "%s/x-%03d.png", directory, n);
        assert_int_equal(unlink(path), 0);
    }
    assert_int_equal(rmdir(directory), 0);
    assert_int_equal(create(asset, "", path, sizeof path), ENOENT);
}

/* Removes the files in the directory and returns how many there were. All must have the size. */
static int empty(const char *directory, size_t size) {
    int count = 0;
    DIR *listing = opendir(directory);
    for (struct dirent *entry; (entry = readdir(listing));) {
        char path[sizeof entry->d_name + 64];
        struct stat status;
        snprintf(path, sizeof path, "%s/%s", directory, entry->d_name);
        assert_int_equal(stat(path, &status), 0);
        if (S_ISDIR(status.st_mode)) continue;
        assert_int_equal(status.st_size, size);
        assert_int_equal(unlink(path), 0);
        ++count;
    }
    closedir(listing);
    return count;
}

static uint8_t picture[1 << 20];

/* A process takes one screenshot after the other and is killed at a different time in each
 * round. */
static void test_killed_leaves_whole_pictures(void **state) {
    (void)state;
    char directory[] = "/tmp/phongsplat-XXXXXX", asset[64], path[64];
    assert_non_null(mkdtemp(directory));
    snprintf(asset, sizeof asset, "%s/x.glb", directory);
    int probe = open(directory, O_TMPFILE | O_WRONLY, 0600), pictures = 0;
    if (probe < 0) {
        rmdir(directory);
        skip(); /* this file system has no files without a name */
    }
    close(probe);
    for (useconds_t time = 0; time < 20; ++time) {
        pid_t child = fork();
        while (!child) screenshot_create(asset, NULL, picture, sizeof picture, path, sizeof path);
        usleep(5000 + 777 * time);
        assert_int_equal(kill(child, SIGKILL), 0);
        assert_int_equal(waitpid(child, NULL, 0), child);
        pictures += empty(directory, sizeof picture);
    }
    assert_true(pictures > 0);
    assert_int_equal(rmdir(directory), 0);
}

/* A file that outgrows its limit fails half-way, as on a full disk. */
static void test_partial_pictures_go(void **state) {
    (void)state;
    char directory[] = "/tmp/phongsplat-XXXXXX", asset[64], path[64];
    assert_non_null(mkdtemp(directory));
    snprintf(asset, sizeof asset, "%s/x.glb", directory);
    struct rlimit before, limit;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    limit = before;
    limit.rlim_cur = sizeof picture / 2;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    int cause = screenshot_create(asset, NULL, picture, sizeof picture, path, sizeof path);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_int_equal(cause, EFBIG);
    assert_int_equal(rmdir(directory), 0);
}

int test_screenshot_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_names_too_long_are_refused),
        cmocka_unit_test(test_the_first_free_number_is_taken),
        cmocka_unit_test(test_killed_leaves_whole_pictures),
        cmocka_unit_test(test_partial_pictures_go),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

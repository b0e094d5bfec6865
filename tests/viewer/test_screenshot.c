/* SPDX-License-Identifier: MIT
 * Names of screenshots: beside the asset, numbered, never one that exists. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <viewer.h>

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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
    /* Only the last dot of the name counts, and not one in front. */
    assert_name("a.b/part", NULL, 1, "a.b/part-001.png");
    assert_name("a/part.v2.glb", NULL, 1, "a/part.v2-001.png");
    assert_name("a/.glb", NULL, 1, "a/.glb-001.png");
}

static void test_names_too_long_are_refused(void **state) {
    (void)state;
    char path[13] = "";
    assert_int_equal(screenshot_name("part.glb", NULL, 1, path, sizeof path), 1);
    assert_int_equal(screenshot_name("parts.glb", NULL, 1, path, sizeof path), 0);
    assert_int_equal(screenshot_create("parts.glb", NULL, path, sizeof path), -1);
    assert_int_equal(errno, ENAMETOOLONG);
}

static void test_the_first_free_number_is_taken(void **state) {
    (void)state;
    char directory[] = "/tmp/phongsplat-XXXXXX", asset[64], path[64], expected[64];
    assert_non_null(mkdtemp(directory));
    snprintf(asset, sizeof asset, "%s/x.glb", directory);
    for (int n = 1; n <= 3; ++n) {
        int file = screenshot_create(asset, NULL, path, sizeof path);
        assert_true(file >= 0);
        assert_int_equal(write(file, "kept", 4), 4);
        close(file);
        snprintf(expected, sizeof expected, "%s/x-%03d.png", directory, n);
        assert_string_equal(path, expected);
    }
    /* A gap is filled, what is there stays. */
    snprintf(expected, sizeof expected, "%s/x-002.png", directory);
    assert_int_equal(unlink(expected), 0);
    close(screenshot_create(asset, NULL, path, sizeof path));
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
    assert_int_equal(screenshot_create(asset, NULL, path, sizeof path), -1);
    assert_int_equal(errno, ENOENT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_names_too_long_are_refused),
        cmocka_unit_test(test_the_first_free_number_is_taken),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

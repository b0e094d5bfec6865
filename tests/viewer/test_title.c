/* SPDX-License-Identifier: MIT
 *
 * test_title.c - tests the window's title for one, several and broken files.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <viewer.h>

#include <string.h>

static void assert_title(const viewer *v, const char *expected) {
    char text[512];
    title_write(v, text, sizeof text);
    assert_string_equal(text, expected);
}

static void test_titles(void **state) {
    (void)state;
    char one[] = "some/where/part.glb", two[] = "b.glb", three[] = "c.glb";
    shown_asset entries[5] = {
        {.path = one}, {.path = two}, {.path = three}, {.path = three}, {.path = three}};
    viewer v = {.settings = {.mode = 1, .shading = PSPLAT_SHADING_DEPTH}};
    assert_title(&v, "phongsplat");
    v.shown = (shown_assets){.entries = entries, .entry_count = 1, .splat_count = 1};
    assert_title(&v, "part.glb - 1 splat - gaussian, depth - phongsplat");
    v.frame_time = 0.01234;
    v.shown.splat_count = 999;
    assert_title(&v, "part.glb - 999 splats - gaussian, depth - 12.3 ms - phongsplat");
    v.shown.splat_count = 1234567;
    v.shown.entry_count = 3;
    entries[1].error.code = PSPLAT_ERROR_FORMAT;
    assert_title(&v, "part.glb, b.glb (broken), c.glb - 1,234,567 splats - gaussian, depth - "
                     "12.3 ms - phongsplat");
    v.shown.entry_count = 5;
    v.shown.splat_count = 1000;
    strcpy(v.shown.refused_path, "x/y.glb");
    assert_title(&v, "y.glb (broken) - part.glb, b.glb (broken), c.glb and 2 more - 1,000 splats - "
                     "gaussian, depth - 12.3 ms - phongsplat");
}

static void test_a_long_title_is_cut(void **state) {
    (void)state;
    char name[600], text[64];
    memset(name, 'n', sizeof name);
    name[sizeof name - 1] = 0;
    shown_asset entry = {.path = name};
    viewer v = {.shown = {.entries = &entry, .entry_count = 1}};
    title_write(&v, text, sizeof text);
    assert_int_equal(strlen(text), sizeof text - 1);
}

int test_title_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_titles),
        cmocka_unit_test(test_a_long_title_is_cut),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

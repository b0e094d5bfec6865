/* SPDX-License-Identifier: MIT
 *
 * test_scenes.c - scenes as they are owned: warnings that are said once.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "scenes.h"

static void test_warnings(void **state) {
    (void)state;
    psplat_scene scene = {0};
    for (int i = 0; i < 6; ++i) psplat_scene_warn(&scene, "%d animations are dropped", i / 2);
    assert_int_equal(scene.warning_count, 3);
    assert_string_equal(scene.warnings[2], "2 animations are dropped");
    char longest[1000];
    memset(longest, 'x', sizeof longest);
    longest[sizeof longest - 1] = 0;
    psplat_scene_warn(&scene, "%s", longest);
    assert_in_range(strlen(scene.warnings[3]), 100, 500); /* cut, not overrun */
    psplat_scene_free(&scene);
    assert_null(scene.warnings);
    psplat_scene_free(&scene);
    psplat_scene_free(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_warnings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

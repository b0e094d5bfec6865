/* SPDX-License-Identifier: MIT
 *
 * test_input.c - tests the table of keys: no key is bound twice, and its help is written with
 * characters that the font has.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <viewer.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <string.h>

static void test_no_key_is_bound_twice(void **state) {
    (void)state;
    for (size_t i = 0; i < key_binding_count; ++i)
        for (size_t k = 0; k < i && key_bindings[i].key; ++k)
            assert_false(key_bindings[i].key == key_bindings[k].key &&
                         key_bindings[i].modifiers == key_bindings[k].modifiers);
}

static void test_every_key_acts_and_every_line_has_both_parts(void **state) {
    (void)state;
    for (size_t i = 0; i < key_binding_count; ++i) {
        const key_binding *b = &key_bindings[i];
        assert_true(!b->key == !b->act);
        assert_true(!b->label == !b->help);
        assert_true(b->key || b->label);
        if (b->label) assert_true(strlen(b->label) <= 22 && strlen(b->help) <= 44);
    }
}

static int is_bound(void (*act)(viewer *v, int value), int value) {
    for (size_t i = 0; i < key_binding_count; ++i)
        if (key_bindings[i].act == act && key_bindings[i].value == value) return 1;
    return 0;
}

static void test_every_shading_has_a_key(void **state) {
    (void)state;
    assert_int_equal(names_count(shading_names), PSPLAT_SHADING_COUNT);
    const key_binding *lit = input_find(GLFW_KEY_1, 0);
    assert_non_null(lit);
    for (int i = 0; i < PSPLAT_SHADING_COUNT; ++i) assert_true(is_bound(lit->act, i));
}

static void test_locks_do_not_matter_and_modifiers_do(void **state) {
    (void)state;
    const key_binding *x = input_find(GLFW_KEY_X, 0);
    assert_non_null(x);
    assert_ptr_equal(input_find(GLFW_KEY_X, GLFW_MOD_CAPS_LOCK | GLFW_MOD_NUM_LOCK), x);
    assert_ptr_not_equal(input_find(GLFW_KEY_X, GLFW_MOD_SHIFT), x);
    assert_null(input_find(GLFW_KEY_X, GLFW_MOD_CONTROL));
    assert_null(input_find(GLFW_KEY_W, 0));
    assert_null(input_find(0, 0)); /* lines of the help without a key are not found */
    assert_null(input_find(GLFW_KEY_UNKNOWN, 0));
}

static void test_any_text_has_a_width(void **state) {
    (void)state;
    char every[256] = {0};
    for (int i = 0; i < 255; ++i) every[i] = (char)(i + 1);
    assert_int_equal(canvas_text_width(""), 0);
    assert_true(canvas_text_width("il") < canvas_text_width("WM"));
    assert_int_equal(canvas_text_width("\xc3\xa9\n\x7f"), canvas_text_width("????"));
    assert_in_range(canvas_text_width(every), 255 * 3, 255 * 9);
}

int test_input_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_key_is_bound_twice),
        cmocka_unit_test(test_every_key_acts_and_every_line_has_both_parts),
        cmocka_unit_test(test_every_shading_has_a_key),
        cmocka_unit_test(test_locks_do_not_matter_and_modifiers_do),
        cmocka_unit_test(test_any_text_has_a_width),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

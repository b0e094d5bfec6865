/* SPDX-License-Identifier: MIT
 *
 * test_html_page.c - tests of how models go into the viewer's page: base64, names, templates.
 */
#include "export/html_page.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

static const char template_text[] = "<title>Phong splats</title>|<!-- models -->\n|end";

static void expect_page(const psplat_page_model *models, size_t count, const char *expected) {
    char *page = NULL;
    size_t size = 0;
    psplat_error error;
    assert_int_equal(psplat_html_page(template_text, models, count, &page, &size, &error), 0);
    assert_string_equal(page, expected);
    assert_int_equal(size, strlen(expected));
    free(page);
}

/* The examples of RFC 4648, section 10, and the digits that are neither letters nor numbers. */
static void test_base64(void **state) {
    static const struct {
        const char *bytes, *text;
    } cases[] = {{"", ""},
                 {"f", "Zg=="},
                 {"fo", "Zm8="},
                 {"foo", "Zm9v"},
                 {"foob", "Zm9vYg=="},
                 {"fooba", "Zm9vYmE="},
                 {"foobar", "Zm9vYmFy"},
                 {"\xfb\xff\xbf", "+/+/"}};
    char expected[256];
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const psplat_page_model model = {"m.glb", cases[i].bytes, strlen(cases[i].bytes)};
        strcpy(expected, "<title>m.glb</title>|<script type=\"model\" data-name=\"m.glb\">");
        strcat(strcat(expected, cases[i].text), "</script>\n|end");
        expect_page(&model, 1, expected);
    }
}

/* Names stay text: no character of one ends the element or the attribute that it stands in. */
static void test_names(void **state) {
    const psplat_page_model models[] = {{"a</title></script><b c=\"&amp;'", "x", 1},
                                        {"<!-- models -->\n", "", 0}};
    (void)state;
    expect_page(models, 2,
                "<title>a&lt;/title&gt;&lt;/script&gt;&lt;b c=&quot;&amp;amp;'</title>|"
                "<script type=\"model\" data-name=\"a&lt;/title&gt;&lt;/script&gt;&lt;b "
                "c=&quot;&amp;amp;'\">eA==</script>\n"
                "<script type=\"model\" data-name=\"&lt;!-- models --&gt;\n\"></script>\n|end");
}

static void test_no_template(void **state) {
    static const char *const texts[] = {"", "<title>Phong splats</title>", "<!-- models -->\n",
                                        "<!-- models -->\n<title>Phong splats</title>"};
    const psplat_page_model model = {"m.glb", "", 0};
    char *page = NULL;
    size_t size;
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) {
        psplat_error error = {0};
        assert_int_equal(psplat_html_page(texts[i], &model, 1, &page, &size, &error),
                         PSPLAT_ERROR_GRAPHICS);
        assert_string_equal(error.text, "is not the viewer's page");
        assert_null(page);
    }
}

int test_html_page_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_base64),
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_no_template),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

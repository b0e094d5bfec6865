/* SPDX-License-Identifier: MIT
 *
 * test_page.c - tests that the HTML page is well-formed and complete for any names and numbers. The
 * tables are invented; a small XML reader checks the page.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "invented_table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include "tradeoff/charts.h"
#include "table/folder.h"
#include "tradeoff/page.h"
#include "table/row.h"
#include "table/setting.h"
#include "table/sweep_options.h"
#include "table/sweep_table.h"
#include "table/text.h"

/* ---- XML reader for elements, attributes, text and entities ---------------------------------- */

enum { MOST_DEPTH = 32 };

typedef struct markup {
    const char *at;
    char open[MOST_DEPTH][16];
    size_t depth, elements;
} markup;

static void skip_entity(markup *m) {
    size_t length = strcspn(m->at, ";");
    const char *const known[] = {"&amp", "&lt", "&gt", "&quot"};
    for (size_t i = 0; i < 4; ++i)
        if (strlen(known[i]) == length && !strncmp(m->at, known[i], length)) {
            m->at += length + 1;
            return;
        }
    fail_msg("no entity: %.20s", m->at);
}

static void skip_attributes(markup *m) {
    while (*m->at && !strchr("/>", *m->at)) {
        m->at += strspn(m->at, " \n");
        if (strchr("/>", *m->at)) return;
        m->at += strspn(m->at, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ-");
        assert_memory_equal(m->at, "=\"", 2);
        for (m->at += 2; *m->at != '"';) {
            assert_true(*m->at && *m->at != '<');
            if (*m->at == '&')
                skip_entity(m);
            else
                ++m->at;
        }
        ++m->at;
    }
}

static void read_element(markup *m) {
    int is_end = m->at[1] == '/';
    m->at += 1 + is_end;
    size_t length = strcspn(m->at, " \n/>");
    assert_true(length > 0 && length < 16);
    if (is_end) {
        assert_true(m->depth > 0);
        assert_memory_equal(m->open[--m->depth], m->at, length);
        m->at += length;
        assert_int_equal(*m->at++, '>');
        return;
    }
    assert_true(m->depth < MOST_DEPTH);
    memcpy(m->open[m->depth], m->at, length);
    m->open[m->depth++][length] = 0;
    m->at += length;
    ++m->elements;
    skip_attributes(m);
    if (*m->at == '/') --m->depth, ++m->at;
    assert_int_equal(*m->at++, '>');
}

static size_t assert_well_formed(const char *text) {
    markup m = {.at = text};
    while (*m.at) {
        if (*m.at == '<')
            read_element(&m);
        else if (*m.at == '&')
            skip_entity(&m);
        else {
            assert_true((unsigned char)*m.at >= 0x20 || *m.at == '\n');
            ++m.at;
        }
    }
    assert_int_equal(m.depth, 0);
    return m.elements;
}

/* ---- tests ---------------------------------------------------------------------------------- */

static size_t count_of(const char *text, const char *word) {
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, word)); at += strlen(word)) ++count;
    return count;
}

/* Makes a folder with charts such as gnuplot writes, and one picture, of 4 bytes. */
static void make_charts(char folder[32]) {
    static const char chart[] =
        "<?xml version=\"1.0\"?>\n<svg width=\"9\"><text>mark</text></svg>\n";
    strcpy(folder, "/tmp/phongsplat-page-XXXXXX");
    assert_non_null(mkdtemp(folder));
    for (size_t i = 0; i < PSPLAT_CHARTS; ++i)
        assert_int_equal(
            psplat_folder_write(folder, psplat_chart_files[i], chart, sizeof chart - 1, NULL),
            PSPLAT_OK);
    char pictures[64];
    snprintf(pictures, sizeof pictures, "%s/pictures", folder);
    assert_int_equal(mkdir(pictures, 0700), 0);
    assert_int_equal(
        psplat_folder_write(folder, "pictures/usual-0.5.png", "\377\001\200k", 4, NULL), PSPLAT_OK);
}

static void remove_charts(const char *folder) {
    char command[64];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    assert_int_equal(system(command), 0);
}

static void test_odd_values(void **state) {
    (void)state;
    psplat_sweep_table t = make_table(1);
    const double odd[] = {NAN, INFINITY, -INFINITY, 0, -5, 1e-300, 1e300};
    for (size_t i = 0; i < t.count; ++i)
        for (size_t k = 0; k < PSPLAT_COLUMN_COUNT; ++k) t.rows[i].values[k] = odd[(3 * i + k) % 7];
    size_t counts[] = {t.count, 1, 0}; /* all rows, the source alone, none */
    for (size_t i = 0; i < 3; ++i) {
        psplat_text page = {0};
        t.count = counts[i];
        psplat_page_write(&t, "/nowhere", 0, &page);
        assert_false(page.failed);
        assert_null(strstr(page.data, "nan"));
        free(page.data);
    }
    t.count = counts[0];
    psplat_sweep_table_free(&t);
}

static void test_page(void **state) {
    (void)state;
    char folder[32];
    psplat_sweep_table t = make_table(1);
    psplat_text page = {0};
    make_charts(folder);
    psplat_page_write(&t, folder, 1, &page);
    remove_charts(folder);
    assert_false(page.failed);
    /* Every setting has a row with the words of setting.c. */
    for (size_t i = 0; i < t.count; ++i) {
        psplat_text cell = {0};
        psplat_text_add(&cell, "<td>");
        psplat_setting_describe(&t.rows[i].setting, &cell);
        psplat_text_add(&cell, "</td>");
        if (!strstr(page.data, cell.data)) fail_msg("no row %s", cell.data);
        free(cell.data);
    }
    assert_int_equal(count_of(page.data, "<svg "), PSPLAT_CHARTS);
    assert_int_equal(count_of(page.data, "<table>"), 3);
    assert_int_equal(count_of(page.data, "<tr"), count_of(page.data, "</tr>"));
    assert_non_null(strstr(page.data, "&lt;p&amp;q&gt;.obj"));
    /* The page loads nothing and runs no script. */
    const char *const outside[] = {"<script", "<link", "@import", "url(", "href=", "http"};
    for (size_t i = 0; i < 6; ++i) assert_null(strstr(page.data, outside[i]));
    /* RFC 4648: the pictures are a part of it. */
    assert_int_equal(count_of(page.data, "<img"), 1);
    assert_non_null(strstr(page.data, "src=\"data:image/png;base64,/wGAaw==\"/>"
                                      "<figcaption>0.5 %, phong</figcaption>"));
    /* The reader accepts XML; void elements of HTML are removed for it. */
    for (char *at; (at = strstr(page.data, "<!doctype html>"));) memset(at, ' ', 15);
    for (char *at; (at = strstr(page.data, "<br>"));) memset(at, ' ', 4);
    for (char *at; (at = strstr(page.data, "<meta "));) memset(at, ' ', strcspn(at, ">") + 1);
    assert_true(assert_well_formed(page.data) > 1000);
    free(page.data);
    psplat_sweep_table_free(&t);
}

static void test_without_charts(void **state) {
    (void)state;
    psplat_sweep_table t = make_table(0);
    psplat_text page = {0};
    psplat_page_write(&t, "/nowhere", 0, &page);
    assert_null(strstr(page.data, "<svg"));
    assert_null(strstr(page.data, "Charts"));
    assert_non_null(strstr(page.data, "<h2>Files</h2>"));
    free(page.data);
    psplat_sweep_table_free(&t);
}

static void test_command(void **state) {
    (void)state;
    psplat_row row = splats_row(0.5, PSPLAT_FORM_FLOAT, PSPLAT_MODE_PHONG);
    psplat_sweep_options options = {.effort = 1, .seed = 3, .normal_tolerance = 5};
    psplat_text text = {0};
    psplat_setting_command(&row.setting, &options, "my models/it's.obj", &text);
    assert_string_equal(text.data,
                        "phongsplat convert 'my models/it'\\''s.obj' 'it'\\''s.glb' --tolerance "
                        "0.5% --precision float --normal-tolerance 5 --effort 1 --seed 3");
    free(text.data);
    text = (psplat_text){0};
    row.setting.form = PSPLAT_FORM_PLANAR;
    psplat_setting_command(&row.setting, &(psplat_sweep_options){.effort = 0}, "a.obj", &text);
    assert_string_equal(text.data, "phongsplat convert a.obj a.glb --tolerance 0.5% --planar");
    free(text.data);
}

static void test_figures(void **state) {
    (void)state;
    const struct {
        double number;
        const char *expected;
    } cases[] = {{1234567, "1,234,567"},
                 {999.6, "1,000"},
                 {123.4, "123"},
                 {12.345, "12.3"},
                 {9.999, "10.0"},
                 {1.2345, "1.23"},
                 {0.12345, "0.123"},
                 {0.012345, "0.0123"},
                 {1.2345e-5, "1.2e-05"},
                 {0, "0"},
                 {7, "7"},
                 {-1234, "-1,234"},
                 {NAN, "\xe2\x80\x93"},
                 {INFINITY, "\xe2\x88\x9e"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_text text = {0};
        psplat_text_figure(&text, cases[i].number);
        assert_string_equal(text.data, cases[i].expected);
        free(text.data);
    }
}

int test_page_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_page),           cmocka_unit_test(test_odd_values),
        cmocka_unit_test(test_without_charts), cmocka_unit_test(test_command),
        cmocka_unit_test(test_figures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 * Charts and page are well-formed, whole and small, whatever the names and the numbers. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "rows.h"

#include <stdio.h>

/* ---- a reader of XML that knows elements, attributes, text and entities ---------------------- */

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

static psplat_text draw(const psplat_journal *j, size_t chart) {
    psplat_chart charts[PSPLAT_CHARTS];
    psplat_text svg = {0};
    assert_int_equal(psplat_chart_list(psplat_rows_cost(j->rows, j->count), charts), PSPLAT_CHARTS);
    psplat_chart_write(&charts[chart], j, &svg);
    assert_false(svg.failed);
    assert_well_formed(svg.data);
    assert_null(strstr(svg.data, "nan"));
    assert_null(strstr(svg.data, "inf"));
    return svg;
}

static size_t count_of(const char *text, const char *word) {
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, word)); at += strlen(word)) ++count;
    return count;
}

static void test_charts(void **state) {
    (void)state;
    psplat_journal j = make_journal(1);
    for (size_t i = 0; i < PSPLAT_CHARTS; ++i) {
        psplat_text svg = draw(&j, i);
        assert_true(svg.size < 60000); /* bytes, to be committed */
        /* A title for each point: 60 settings of splats or 10 assets, 6 ratios; the source mesh is
         * a line in the third. */
        size_t points = i < 3 ? 66 : 16;
        assert_int_equal(count_of(svg.data, "<title>"), points + (i == 2));
        assert_non_null(strstr(svg.data, "&lt;p&amp;q&gt;.obj"));
        assert_non_null(strstr(svg.data, "Pareto front"));
        /* Twice the same is the same. */
        psplat_text again = draw(&j, i);
        assert_string_equal(svg.data, again.data);
        free(svg.data);
        free(again.data);
    }
    psplat_journal_free(&j);
}

/* Points lie within the frame, and the legend beside it. */
static void test_places(void **state) {
    (void)state;
    psplat_journal j = make_journal(1);
    psplat_text svg = draw(&j, 0);
    double x = 0, y = 0;
    size_t points = 0;
    for (const char *at = svg.data; (at = strstr(at, "<circle ")); ++at) {
        assert_int_equal(sscanf(at, "<circle cx=\"%lf\" cy=\"%lf\"", &x, &y), 2);
        int is_legend = x > 660;
        if (!is_legend) assert_true(x > 74 && x < 656 && y > 50 && y < 436);
        points += !is_legend;
    }
    assert_int_equal(points, 10); /* phong with the filter: linear and constant at 5 tolerances */
    free(svg.data);
    psplat_journal_free(&j);
}

static void test_odd_values(void **state) {
    (void)state;
    psplat_journal j = make_journal(1);
    const double odd[] = {NAN, INFINITY, -INFINITY, 0, -5, 1e-300, 1e300};
    for (size_t i = 0; i < j.count; ++i)
        for (size_t k = 0; k < PSPLAT_COLUMN_COUNT; ++k) j.rows[i].values[k] = odd[(3 * i + k) % 7];
    for (size_t i = 0; i < PSPLAT_CHARTS; ++i) free(draw(&j, i).data);
    j.count = 1; /* the source alone */
    for (size_t i = 0; i < PSPLAT_CHARTS; ++i) free(draw(&j, i).data);
    j.count = 0;
    for (size_t i = 0; i < PSPLAT_CHARTS; ++i) free(draw(&j, i).data);
    psplat_text page = {0};
    psplat_page_write(&j, &page);
    assert_false(page.failed);
    free(page.data);
    psplat_journal_free(&j);
}

static void test_page(void **state) {
    (void)state;
    psplat_journal j = make_journal(1);
    psplat_text page = {0};
    psplat_page_write(&j, &page);
    assert_false(page.failed);
    /* Every setting has its row, in the words of setting.c. */
    for (size_t i = 0; i < j.count; ++i) {
        psplat_text cell = {0};
        psplat_text_add(&cell, "<td>");
        psplat_setting_describe(&j.rows[i].setting, &cell);
        psplat_text_add(&cell, "</td>");
        if (!strstr(page.data, cell.data)) fail_msg("no row %s", cell.data);
        free(cell.data);
    }
    assert_int_equal(count_of(page.data, "<svg "), PSPLAT_CHARTS);
    assert_int_equal(count_of(page.data, "<table>"), 3);
    assert_int_equal(count_of(page.data, "<tr"), count_of(page.data, "</tr>"));
    /* Nothing is fetched and nothing runs. */
    const char *const outside[] = {"<script", "<link", "<img", "@import", "url(h", "href="};
    for (size_t i = 0; i < 6; ++i) assert_null(strstr(page.data, outside[i]));
    assert_int_equal(count_of(page.data, "http"), PSPLAT_CHARTS); /* SVG's name space */
    /* What the reader calls well-formed is XML; HTML's void elements are left out of it. */
    for (char *at; (at = strstr(page.data, "<!doctype html>"));) memset(at, ' ', 15);
    for (char *at; (at = strstr(page.data, "<br>"));) memset(at, ' ', 4);
    for (char *at; (at = strstr(page.data, "<meta "));) memset(at, ' ', strcspn(at, ">") + 1);
    assert_true(assert_well_formed(page.data) > 1000);
    free(page.data);
    psplat_journal_free(&j);
}

static void test_command(void **state) {
    (void)state;
    psplat_row row = splats_row(0.5, PSPLAT_FIELD_CONSTANT, PSPLAT_MODE_FLAT, 1);
    psplat_tradeoff_options options = {.effort = 1, .seed = 3, .normal_tolerance = 5};
    psplat_text text = {0};
    psplat_setting_command(&row.setting, &options, "my models/it's.obj", &text);
    assert_string_equal(text.data,
                        "phongsplat convert 'my models/it'\\''s.obj' 'it'\\''s.glb' --tolerance "
                        "0.5% --constant-normals --normal-tolerance 5 --effort 0 --seed 3"
                        " --precision float --no-compress");
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_charts),     cmocka_unit_test(test_places),
        cmocka_unit_test(test_odd_values), cmocka_unit_test(test_page),
        cmocka_unit_test(test_command),    cmocka_unit_test(test_figures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

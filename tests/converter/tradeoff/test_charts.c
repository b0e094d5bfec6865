/* SPDX-License-Identifier: MIT
 *
 * test_charts.c - tests of charts drawn by gnuplot where it is installed, and of the message where
 * it is missing or fails. The tables are invented.
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
#include <unistd.h>
#include "tradeoff/charts.h"
#include "table/folder.h"
#include "benchmark/subprocess.h"
#include "table/sweep_table.h"
#include "table/text.h"

static char place[64], saved_path[4096];

static int set_up(void **state) {
    (void)state;
    snprintf(saved_path, sizeof saved_path, "%s", getenv("PATH"));
    strcpy(place, "/tmp/phongsplat-it's-XXXXXX"); /* The quote must be escaped for gnuplot. */
    return mkdtemp(place) ? 0 : -1;
}

static int tear_down(void **state) {
    char command[128];
    (void)state;
    setenv("PATH", saved_path, 1);
    snprintf(command, sizeof command, "rm -rf \"%s\"", place);
    return system(command);
}

/* Replaces gnuplot by a shell script. */
static void fallback(const char *script) {
    char path[96], both[4200];
    snprintf(path, sizeof path, "%s/gnuplot", place);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "#!/bin/sh\n%s\n", script);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(chmod(path, 0700), 0);
    snprintf(both, sizeof both, "%s:%s", place, saved_path);
    setenv("PATH", both, 1);
}

/* Writes the table and draws it; left_out stays empty unless something failed. */
static void draw(const psplat_sweep_table *table, char left_out[PSPLAT_CHARTS_CAUSE]) {
    psplat_text text = {0};
    psplat_sweep_table_write(table, &text);
    assert_int_equal(psplat_folder_write(place, "tradeoff.csv", text.data, text.size, NULL),
                     PSPLAT_OK);
    free(text.data);
    assert_int_equal(psplat_charts_write(table, place, left_out, NULL), PSPLAT_OK);
}

/* Returns the text of a chart, or NULL. */
static char *read_chart(size_t chart) {
    char *svg = NULL;
    size_t size = 0;
    psplat_folder_read(place, psplat_chart_files[chart], &svg, &size, NULL);
    return svg;
}

static size_t count_of(const char *text, const char *word) {
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, word)); at += strlen(word)) ++count;
    return count;
}

static void skip_without_gnuplot(void) {
    const char *const arguments[] = {"gnuplot", "--version", NULL};
    if (psplat_subprocess_run(arguments, NULL, 0)) skip();
}

static void assert_all_drawn(const psplat_sweep_table *table) {
    char left_out[PSPLAT_CHARTS_CAUSE];
    draw(table, left_out);
    if (*left_out) fail_msg("%s", left_out);
    for (size_t i = 0; i < PSPLAT_CHARTS; ++i) {
        char *svg = read_chart(i);
        assert_non_null(svg);
        assert_non_null(strstr(svg, "</svg>"));
        free(svg);
    }
}

static void test_charts(void **state) {
    (void)state;
    skip_without_gnuplot();
    psplat_sweep_table t = make_table(1);
    assert_all_drawn(&t);
    for (size_t i = 0; i < PSPLAT_CHARTS; ++i) {
        char *svg = read_chart(i);
        assert_true(strlen(svg) < 60000); /* bytes; charts are committed to repositories */
        /* gnuplot does not escape a >. */
        assert_non_null(strstr(svg, "&lt;p&amp;q>.obj: "));
        assert_non_null(strstr(svg, "Pareto front"));
        assert_int_equal(count_of(svg, "<text>gltfpack</text>"), 1);
        assert_int_equal(count_of(svg, "<text>-si "), i == 1 ? 6 : count_of(svg, "<text>-si "));
        /* There is a label for each tolerance of phong splats, and the colours are those of Okabe
         * and Ito. */
        assert_int_equal(count_of(svg, " %</text>"), 5);
        assert_true(count_of(svg, "rgb(  0, 114, 178)") > 10);
        /* There are filled circles for five points and one in the legend. */
        assert_int_equal(count_of(svg, "#gpPt6'"), 6);
        assert_int_equal(count_of(svg, "<text>floats</text>"), 1);
        assert_int_equal(count_of(svg, "source mesh"), i == 2);
        free(svg);
    }
    psplat_sweep_table_free(&t);
}

/* Values without a logarithm are left out, and a chart without points is still a chart. */
static void test_odd_values(void **state) {
    (void)state;
    skip_without_gnuplot();
    psplat_sweep_table t = make_table(1);
    const double odd[] = {NAN, INFINITY, -INFINITY, 0, -5, 1e-300, 1e300};
    for (size_t i = 0; i < t.count; ++i)
        for (size_t k = 0; k < PSPLAT_COLUMN_COUNT; ++k) t.rows[i].values[k] = odd[(3 * i + k) % 7];
    size_t counts[] = {t.count, 1, 0}; /* all rows, the source alone, none */
    for (size_t i = 0; i < 3; ++i) {
        t.count = counts[i];
        assert_all_drawn(&t);
    }
    t.count = counts[0];
    psplat_sweep_table_free(&t);
}

static void assert_none_left(void) {
    char path[128];
    for (size_t i = 0; i < PSPLAT_CHARTS; ++i) {
        assert_null(read_chart(i));
        snprintf(path, sizeof path, "%s/.phongsplat-%s", place, psplat_chart_files[i]);
        assert_int_equal(access(path, F_OK), -1);
    }
    snprintf(path, sizeof path, "%s/charts.gp", place);
    assert_int_equal(access(path, F_OK), 0);
}

/* Charts of an earlier sweep are removed, since they would contradict the table. */
static void test_left_out(void **state) {
    (void)state;
    char left_out[PSPLAT_CHARTS_CAUSE];
    psplat_sweep_table t = make_table(0);
    psplat_folder_write(place, psplat_chart_files[1], "old", 3, NULL);
    setenv("PATH", "/nowhere", 1);
    draw(&t, left_out);
    assert_string_equal(left_out, "gnuplot cannot be run; charts are left out");
    assert_none_left();
    psplat_folder_write(place, psplat_chart_files[1], "old", 3, NULL);
    psplat_folder_write(place, ".phongsplat-error-bytes.svg", "half", 4, NULL);
    fallback("echo 'no such terminal'; exit 1");
    draw(&t, left_out);
    assert_string_equal(left_out, "charts are left out: gnuplot: no such terminal");
    assert_none_left();
    psplat_sweep_table_free(&t);
}

int test_charts_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_charts, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_odd_values, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_left_out, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_folder.c - tests of the directory of a sweep: it is made, recognised when it belongs to a
 * sweep, and otherwise refused.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "table/folder.h"

static char place[64]; /* a directory for this test */

static const char *inside(const char *name) {
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", place, name);
    return path;
}

static int set_up(void **state) {
    (void)state;
    strcpy(place, "/tmp/phongsplat-folder-XXXXXX");
    return mkdtemp(place) ? 0 : -1;
}

static int tear_down(void **state) {
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf %s", place);
    return system(command);
}

static void touch(const char *name) {
    FILE *file = fopen(inside(name), "wb");
    assert_non_null(file);
    fputs("content", file);
    fclose(file);
}

static void assert_opens(const char *name) {
    psplat_error error = {0};
    if (psplat_folder_open(inside(name), &error)) fail_msg("%s", error.text);
}

static void assert_refused(const char *name, const char *cause) {
    psplat_error error = {0};
    assert_int_equal(psplat_folder_open(inside(name), &error), PSPLAT_ERROR_WRITE);
    if (!strstr(error.text, cause)) fail_msg("'%s' instead of '%s'", error.text, cause);
}

static void test_made_and_found_again(void **state) {
    (void)state;
    assert_opens("new");
    assert_opens("new");
    assert_int_equal(access(inside("new/assets"), F_OK), 0);
    assert_int_equal(access(inside("new/tradeoff.csv"), F_OK), 0);
    mkdir(inside("empty"), 0777);
    assert_opens("empty");
    /* Files of the user in it stay. */
    touch("new/notes.txt");
    assert_opens("new");
    assert_int_equal(access(inside("new/notes.txt"), F_OK), 0);
}

static void test_others(void **state) {
    (void)state;
    mkdir(inside("full"), 0777);
    touch("full/thesis.tex");
    assert_refused("full", "is no directory of a sweep: it holds thesis.tex");
    mkdir(inside("dotted"), 0777);
    touch("dotted/.hidden");
    assert_refused("dotted", "it holds .hidden");
    mkdir(inside("nested"), 0777);
    mkdir(inside("nested/assets"), 0777);
    assert_refused("nested", "it holds assets");
    touch("file");
    assert_refused("file", "is not a directory");
    assert_refused("absent/deep", "cannot be made");
    assert_int_equal(access(inside("full/tradeoff.csv"), F_OK), -1); /* nothing was written */
    mkdir(inside("linked"), 0777); /* The table must not be a link to another place. */
    assert_int_equal(symlink("/dev/null", inside("linked/tradeoff.csv")), 0);
    assert_refused("linked", "it holds tradeoff.csv");
}

/* Leftover temporary files of a killed process do not make the directory count as the user's. */
static void test_leftovers(void **state) {
    (void)state;
    mkdir(inside("new"), 0777);
    touch("new/.phongsplat-12345-0.tmp");
    assert_opens("new");
    assert_opens("new");
}

static void test_files(void **state) {
    (void)state;
    char *data = NULL, *path = psplat_folder_path(inside("new"), "a.csv");
    size_t size = 0;
    assert_string_equal(path, inside("new/a.csv"));
    free(path);
    assert_opens("new");
    assert_int_equal(psplat_folder_read(inside("new"), "a.csv", &data, &size, NULL),
                     PSPLAT_ERROR_READ);
    assert_int_equal(psplat_folder_write(inside("new"), "a.csv", "a,b", 3, NULL), PSPLAT_OK);
    assert_int_equal(psplat_folder_write(inside("new"), "a.csv", "a,b,c", 5, NULL), PSPLAT_OK);
    assert_int_equal(psplat_folder_read(inside("new"), "a.csv", &data, &size, NULL), PSPLAT_OK);
    assert_int_equal(size, 5);
    assert_string_equal(data, "a,b,c");
    free(data);
    assert_int_equal(psplat_folder_read(inside("new"), "assets", &data, &size, NULL),
                     PSPLAT_ERROR_READ);
}

int test_folder_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_made_and_found_again, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_others, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_leftovers, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_files, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

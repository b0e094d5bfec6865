/* SPDX-License-Identifier: MIT
 *
 * The perceptual distance, by the program where it is installed and by stand-ins for it; skipped in
 * part without the program.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "butteraugli.h"
#include "near.h"

enum { SIZE = 64 };

static uint8_t first[3 * SIZE * SIZE], second[3 * SIZE * SIZE];
static const psplat_picture_pair pair = {{first, second}, SIZE, SIZE};

/* A directory for temporary files and, beside them, the stand-in. */
static char directory[256], saved_path[4096], saved_parent[200];

static int setup(void **state) {
    const char *parent = getenv("TMPDIR"), *path = getenv("PATH");
    (void)state;
    snprintf(saved_path, sizeof saved_path, "%s", path ? path : "");
    snprintf(saved_parent, sizeof saved_parent, "%s",
             parent && strlen(parent) < sizeof saved_parent ? parent : "/tmp");
    snprintf(directory, sizeof directory, "%s/psplat-look-XXXXXX", saved_parent);
    if (!mkdtemp(directory)) return -1;
    for (int i = 0; i < 3 * SIZE * SIZE; ++i) {
        first[i] = (uint8_t)(i / 3 % SIZE * 3);
        second[i] = (uint8_t)(first[i] + (i / 3 / SIZE % 8) * 4);
    }
    return setenv("TMPDIR", directory, 1);
}

static int teardown(void **state) {
    char path[512];
    (void)state;
    snprintf(path, sizeof path, "%s/butteraugli_main", directory);
    unlink(path);
    setenv("PATH", saved_path, 1);
    setenv("TMPDIR", saved_parent, 1);
    return rmdir(directory); /* fails where anything is left */
}

/* Puts a shell script in the place of the program. */
static void stand_in(const char *script) {
    char path[512], both[4600];
    snprintf(path, sizeof path, "%s/butteraugli_main", directory);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file, "#!/bin/sh\n%s\n", script);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(chmod(path, 0700), 0);
    snprintf(both, sizeof both, "/nowhere::%s:%s", directory, saved_path);
    setenv("PATH", both, 1);
}

static int entries(void) {
    int count = 0;
    DIR *d = opendir(directory);
    assert_non_null(d);
    while (readdir(d)) ++count;
    closedir(d);
    return count;
}

static void test_program(void **state) {
    double same, different, more;
    (void)state;
    psplat_error error = {0};
    const psplat_picture_pair alike = {{first, first}, SIZE, SIZE};
    assert_int_equal(psplat_butteraugli_measure(&alike, &same, &error), PSPLAT_OK);
    if (same < 0) skip();
    assert_near(same, 0, 0);
    assert_int_equal(psplat_butteraugli_measure(&pair, &different, &error), PSPLAT_OK);
    assert_true(different > 1); /* visible, as its authors define 1 */
    for (int i = 0; i < 3 * SIZE * SIZE; ++i)
        second[i] = (uint8_t)(first[i] + (i / 3 / SIZE % 8) * 8);
    assert_int_equal(psplat_butteraugli_measure(&pair, &more, &error), PSPLAT_OK);
    assert_true(more > different);
    assert_int_equal(entries(), 2); /* . and .. */
}

/* What it gets: two PNGs that it can open, the first picture first. */
static void test_stand_in(void **state) {
    double distance = 7;
    (void)state;
    psplat_error error = {0};
    stand_in(
        "a=$(wc -c <\"$1\") && b=$(wc -c <\"$2\") && head -c 4 \"$1\" | grep -q PNG || exit 1\n"
        "[ \"$a\" -gt 100 ] && [ \"$a\" != \"$b\" ] || exit 1\n"
        "echo 'a warning' >&2; echo 12.5; echo '3-norm: 3.062500'");
    assert_int_equal(psplat_butteraugli_measure(&pair, &distance, &error), PSPLAT_OK);
    assert_near(distance, 3.0625, 1e-15);
    assert_int_equal(entries(), 3); /* and the stand-in */
}

static void test_absent(void **state) {
    double distance = 7;
    (void)state;
    setenv("PATH", "/nowhere:", 1);
    assert_int_equal(psplat_butteraugli_measure(&pair, &distance, NULL), PSPLAT_OK);
    assert_true(distance < 0);
    unsetenv("PATH");
    assert_int_equal(psplat_butteraugli_measure(&pair, &distance, NULL), PSPLAT_OK);
    assert_true(distance < 0);
}

static void expect(const char *script, psplat_result code) {
    double distance = 7;
    psplat_error error = {0};
    stand_in(script);
    assert_int_equal(psplat_butteraugli_measure(&pair, &distance, &error), code);
    assert_int_equal(error.code, code);
    assert_true(distance < 0);
    assert_int_equal(entries(), 3);
}

static void test_failures(void **state) {
    (void)state;
    expect("echo '3-norm: 1'; exit 1", PSPLAT_ERROR_READ);
    expect("kill -9 $$", PSPLAT_ERROR_READ);
    expect("echo 1.5", PSPLAT_ERROR_READ);
    expect("echo '3-norm: nan'", PSPLAT_ERROR_READ);
    expect("head -c 100000 /dev/zero",
           PSPLAT_ERROR_READ); /* more than is kept, and no end of line */
    setenv("TMPDIR", "/nowhere", 1);
    expect("echo '3-norm: 1'", PSPLAT_ERROR_WRITE);
    char endless[5000];
    memset(endless, 'a', sizeof endless - 1);
    endless[sizeof endless - 1] = 0;
    setenv("TMPDIR", endless, 1);
    expect("echo '3-norm: 1'", PSPLAT_ERROR_WRITE);
    setenv("TMPDIR", directory, 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_program, setup, teardown),
        cmocka_unit_test_setup_teardown(test_stand_in, setup, teardown),
        cmocka_unit_test_setup_teardown(test_absent, setup, teardown),
        cmocka_unit_test_setup_teardown(test_failures, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

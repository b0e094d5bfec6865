/* SPDX-License-Identifier: MIT
 * The directory of a sweep: made, recognised, locked, cleaned of what killed processes left. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <tradeoff.h>

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static char place[64]; /* a directory of the test's own */

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
    psplat_folder folder;
    psplat_error error = {0};
    if (psplat_folder_open(inside(name), &folder, &error)) fail_msg("%s", error.text);
    psplat_folder_close(&folder);
}

static void assert_refused(const char *name, const char *cause) {
    psplat_folder folder;
    psplat_error error = {0};
    assert_int_equal(psplat_folder_open(inside(name), &folder, &error), PSPLAT_ERROR_WRITE);
    assert_null(folder.path);
    if (!strstr(error.text, cause)) fail_msg("'%s' instead of '%s'", error.text, cause);
}

static void test_made_and_found_again(void **state) {
    (void)state;
    assert_opens("new");
    assert_opens("new");
    assert_int_equal(access(inside("new/assets"), F_OK), 0);
    mkdir(inside("empty"), 0777);
    assert_opens("empty");
    /* What is the user's within it stays. */
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
    mkdir(inside("linked"), 0777); /* the mark must not be a link to somewhere else */
    assert_int_equal(symlink("/dev/null", inside("linked/.phongsplat-tradeoff")), 0);
    assert_refused("linked", "it holds .phongsplat-tradeoff");
}

static void test_leftovers(void **state) {
    (void)state;
    assert_opens("new");
    touch("new/.phongsplat-12345-0.tmp");
    touch("new/assets/.phongsplat-12345-gltfpack.glb");
    touch("new/assets/linear-1.glb");
    assert_opens("new");
    assert_int_not_equal(access(inside("new/.phongsplat-12345-0.tmp"), F_OK), 0);
    assert_int_not_equal(access(inside("new/assets/.phongsplat-12345-gltfpack.glb"), F_OK), 0);
    assert_int_equal(access(inside("new/assets/linear-1.glb"), F_OK), 0);
}

/* Another process holds it until it ends, however it ends. */
static void test_lock(void **state) {
    (void)state;
    int ends[2];
    char byte = 0;
    assert_int_equal(pipe(ends), 0);
    pid_t child = fork();
    if (!child) {
        psplat_folder folder;
        byte = psplat_folder_open(inside("shared"), &folder, NULL) ? 'x' : 'o';
        if (write(ends[1], &byte, 1) != 1) _exit(1);
        for (;;) pause();
    }
    assert_int_equal(read(ends[0], &byte, 1), 1);
    assert_int_equal(byte, 'o');
    assert_refused("shared", "another sweep is writing into it");
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    assert_opens("shared");
    close(ends[0]);
    close(ends[1]);
}

static void test_files(void **state) {
    (void)state;
    psplat_folder folder;
    char *data = NULL;
    size_t size = 0;
    assert_int_equal(psplat_folder_open(inside("new"), &folder, NULL), PSPLAT_OK);
    assert_int_equal(psplat_folder_read(&folder, "a.csv", &data, &size, NULL), PSPLAT_OK);
    assert_null(data);
    assert_true(psplat_folder_stamp(&folder, "a.csv", &size) == 0);
    assert_int_equal(psplat_folder_write(&folder, "a.csv", "a,b", 3, NULL), PSPLAT_OK);
    assert_int_equal(psplat_folder_write(&folder, "a.csv", "a,b,c", 5, NULL), PSPLAT_OK);
    assert_int_equal(psplat_folder_read(&folder, "a.csv", &data, &size, NULL), PSPLAT_OK);
    assert_int_equal(size, 5);
    assert_memory_equal(data, "a,b,c", 5);
    assert_true(psplat_folder_stamp(&folder, "a.csv", &size) ==
                psplat_stamp_bytes(PSPLAT_STAMP, "a,b,c", 5));
    free(data);
    assert_int_equal(psplat_folder_read(&folder, "assets", &data, &size, NULL), PSPLAT_ERROR_READ);
    psplat_folder_close(&folder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_made_and_found_again, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_others, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_leftovers, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_lock, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_files, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

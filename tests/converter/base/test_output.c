/* SPDX-License-Identifier: MIT
 *
 * test_output.c - tests that a file written by psplat_output_write is either whole or absent, with
 * and without permission to replace, under limits, signals and races between processes.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include "base/output.h"

static char directory[64];

static const char *inside(const char *name) {
    static char path[sizeof directory + 256]; /* room for the longest name in a directory */
    snprintf(path, sizeof path, "%s/%s", directory, name);
    return path;
}

static int set_up(void **state) {
    (void)state;
    strcpy(directory, "/tmp/phongsplat-output-XXXXXX");
    return mkdtemp(directory) ? 0 : -1;
}

static int tear_down(void **state) {
    (void)state;
    DIR *listing = opendir(directory);
    for (struct dirent *entry; (entry = readdir(listing));) remove(inside(entry->d_name));
    closedir(listing);
    return rmdir(directory);
}

/* Returns the number of entries other than . and .., among which a leftover temporary file would be
 * counted. */
static int count_entries(void) {
    int count = 0;
    DIR *listing = opendir(directory);
    while (readdir(listing)) ++count;
    closedir(listing);
    return count - 2;
}

static void assert_content(const char *name, const char *text) {
    char found[64] = {0};
    FILE *file = fopen(inside(name), "rb");
    assert_non_null(file);
    assert_int_equal(fread(found, 1, sizeof found - 1, file), strlen(text));
    fclose(file);
    assert_string_equal(found, text);
}

static psplat_result put(const char *name, const char *text, int overwrite, psplat_error *error) {
    return psplat_output_write(inside(name), text, strlen(text), overwrite, error);
}

static void test_writes_new_file(void **state) {
    (void)state;
    assert_int_equal(put("a", "first", 0, NULL), PSPLAT_OK);
    assert_content("a", "first");
    assert_int_equal(count_entries(), 1);
}

static void test_new_file_obeys_umask(void **state) {
    (void)state;
    mode_t before = umask(027);
    assert_int_equal(put("a", "x", 0, NULL), PSPLAT_OK);
    umask(before);
    struct stat status;
    assert_int_equal(stat(inside("a"), &status), 0);
    assert_int_equal(status.st_mode & 0777, 0640);
}

static void test_refuses_existing_file(void **state) {
    (void)state;
    psplat_error error = {0};
    assert_int_equal(put("a", "old", 0, NULL), PSPLAT_OK);
    assert_int_equal(put("a", "new", 0, &error), PSPLAT_ERROR_WRITE);
    assert_int_equal(error.code, PSPLAT_ERROR_WRITE);
    assert_non_null(strstr(error.text, inside("a")));
    assert_non_null(strstr(error.text, "exists already"));
    assert_content("a", "old");
    assert_int_equal(count_entries(), 1);
}

static void test_overwrite_keeps_permissions(void **state) {
    (void)state;
    assert_int_equal(put("a", "old", 0, NULL), PSPLAT_OK);
    assert_int_equal(chmod(inside("a"), 0600), 0);
    assert_int_equal(put("a", "new and longer", 1, NULL), PSPLAT_OK);
    assert_content("a", "new and longer");
    struct stat status;
    assert_int_equal(stat(inside("a"), &status), 0);
    assert_int_equal(status.st_mode & 0777, 0600);
    assert_int_equal(count_entries(), 1);
}

static void test_overwrite_follows_symbolic_link(void **state) {
    (void)state;
    assert_int_equal(put("target", "old", 0, NULL), PSPLAT_OK);
    assert_int_equal(symlink("target", inside("link")), 0);
    assert_int_equal(put("link", "new", 0, NULL), PSPLAT_ERROR_WRITE);
    assert_int_equal(put("link", "new", 1, NULL), PSPLAT_OK);
    assert_content("target", "new");
    struct stat status;
    assert_int_equal(lstat(inside("link"), &status), 0);
    assert_true(S_ISLNK(status.st_mode));
}

static void test_refuses_directory_and_missing_directory(void **state) {
    (void)state;
    psplat_error error = {0};
    assert_int_equal(psplat_output_write(directory, "x", 1, 1, &error), PSPLAT_ERROR_WRITE);
    assert_non_null(strstr(error.text, "directory"));
    assert_int_equal(put("none/a", "x", 1, &error), PSPLAT_ERROR_WRITE);
    assert_non_null(strstr(error.text, "No such file or directory"));
    assert_int_equal(put("a", "x", 0, NULL), PSPLAT_OK);
    assert_int_equal(put("a/b", "x", 1, &error), PSPLAT_ERROR_WRITE);
    assert_int_equal(count_entries(), 1);
}

static void test_full_device_is_an_error(void **state) {
    (void)state;
    psplat_error error = {0};
    assert_int_equal(psplat_output_write("/dev/full", "x", 1, 1, &error), PSPLAT_ERROR_WRITE);
    assert_non_null(strstr(error.text, "No space left on device"));
    struct stat status;
    assert_int_equal(stat("/dev/full", &status), 0);
    /* The device was written to, and not replaced by a file. */
    assert_true(S_ISCHR(status.st_mode));
}

/* A file that exceeds the size limit fails halfway, as on a full disk. */
static void test_partial_write_leaves_old_file(void **state) {
    (void)state;
    static char large[1 << 16];
    psplat_error error = {0};
    assert_int_equal(put("a", "old", 0, NULL), PSPLAT_OK);
    struct rlimit before, limit;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    limit = before;
    limit.rlim_cur = sizeof large / 2;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    psplat_result result = psplat_output_write(inside("a"), large, sizeof large, 1, &error);
    psplat_result fresh = psplat_output_write(inside("b"), large, sizeof large, 0, NULL);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_int_equal(result, PSPLAT_ERROR_WRITE);
    assert_int_equal(fresh, PSPLAT_ERROR_WRITE);
    assert_non_null(strstr(error.text, "File too large"));
    assert_content("a", "old");
    assert_int_equal(count_entries(), 1);
}

/* Eight processes create the same name at once: exactly one of them succeeds. */
static void test_race_has_one_winner(void **state) {
    (void)state;
    enum { PROCESSES = 8 };
    pid_t children[PROCESSES];
    for (int i = 0; i < PROCESSES; ++i) {
        children[i] = fork();
        if (!children[i]) _exit(put("race", "whole", 0, NULL) == PSPLAT_OK ? 0 : 1);
    }
    int winners = 0;
    for (int i = 0; i < PROCESSES; ++i) {
        int status = 0;
        assert_int_equal(waitpid(children[i], &status, 0), children[i]);
        assert_true(WIFEXITED(status));
        winners += WEXITSTATUS(status) == 0;
    }
    assert_int_equal(winners, 1);
    assert_content("race", "whole");
    assert_int_equal(count_entries(), 1);
}

/* A process that is stopped in the middle of its writes leaves whole files. */
static void test_signal_leaves_nothing_behind(void **state) {
    (void)state;
    static char large[1 << 20];
    pid_t child = fork();
    if (!child)
        for (;;) psplat_output_write(inside("a"), large, sizeof large, 1, NULL);
    struct timespec pause = {0, 50000000}; /* long enough for several writes */
    nanosleep(&pause, NULL);
    assert_int_equal(kill(child, SIGINT), 0);
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT);
    assert_int_equal(count_entries(), access(inside("a"), F_OK) ? 0 : 1);
    struct stat written;
    if (!stat(inside("a"), &written)) assert_int_equal(written.st_size, sizeof large);
}

static void test_refuses_missing_arguments(void **state) {
    (void)state;
    assert_int_equal(psplat_output_write(NULL, "x", 1, 0, NULL), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_output_write("", "x", 1, 0, NULL), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(put("empty", "", 0, NULL), PSPLAT_OK);
    assert_content("empty", "");
}

#define CASE(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int test_output_main(void) {
    const struct CMUnitTest tests[] = {
        CASE(test_writes_new_file),
        CASE(test_new_file_obeys_umask),
        CASE(test_refuses_existing_file),
        CASE(test_overwrite_keeps_permissions),
        CASE(test_overwrite_follows_symbolic_link),
        CASE(test_refuses_directory_and_missing_directory),
        CASE(test_full_device_is_an_error),
        CASE(test_partial_write_leaves_old_file),
        CASE(test_race_has_one_winner),
        CASE(test_signal_leaves_nothing_behind),
        CASE(test_refuses_missing_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

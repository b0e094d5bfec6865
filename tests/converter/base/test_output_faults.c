/* SPDX-License-Identifier: MIT
 *
 * test_output_faults.c - tests of psplat_output_write with faults in system calls. Each call that
 * changes a file fails in turn, and the process is killed before and after each: the output is
 * always the old or the new file, whole, and a leftover file disturbs no later write. The linker's
 * --wrap routes the calls through this file, so that the n-th call is known and no moment is
 * missed.
 */
#define _GNU_SOURCE /* O_TMPFILE */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include "base/output.h"

typedef enum fault { NO_FAULT, FAIL, KILL_BEFORE, KILL_AFTER } fault;

/* The fault, and the number of the call at which it occurs, from 1 on. */
static struct {
    fault kind;
    int at, calls, cause;
    int no_nameless; /* as on a file system without O_TMPFILE */
    int no_links;    /* as on a file system without hard links */
} plan;

static int begin_call(void) {
    ++plan.calls;
    if (plan.calls != plan.at) return 0;
    if (plan.kind == KILL_BEFORE) kill(getpid(), SIGKILL);
    if (plan.kind != FAIL) return 0;
    errno = plan.cause;
    return -1;
}

static long end_call(long result) {
    if (plan.calls == plan.at && plan.kind == KILL_AFTER) kill(getpid(), SIGKILL);
    return result;
}

#define WRAP(type, name, parameters, arguments)                                                    \
    type __real_##name parameters;                                                                 \
    type __wrap_##name parameters;                                                                 \
    type __wrap_##name parameters {                                                                \
        return begin_call() ? -1 : (type)end_call(__real_##name arguments);                        \
    }

WRAP(int, fsync, (int file), (file))
WRAP(int, fchmod, (int file, mode_t mode), (file, mode))
WRAP(int, rename, (const char *from, const char *to), (from, to))

int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...) {
    va_list rest;
    va_start(rest, flags);
    int mode = flags & O_WRONLY ? va_arg(rest, int) : 0;
    va_end(rest);
    if (begin_call()) return -1;
    if (plan.no_nameless && (flags & O_WRONLY) && (flags & O_DIRECTORY))
        return errno = EOPNOTSUPP, -1;
    return (int)end_call(__real_open(path, flags, mode));
}

/* Writes half of the bytes in each call, so that a fault can leave a part. */
ssize_t __real_write(int file, const void *data, size_t size);
ssize_t __wrap_write(int file, const void *data, size_t size);
ssize_t __wrap_write(int file, const void *data, size_t size) {
    if (begin_call()) return -1;
    return end_call(__real_write(file, data, size > 1 ? size / 2 : size));
}

int __real_link(const char *from, const char *to);
int __wrap_link(const char *from, const char *to);
int __wrap_link(const char *from, const char *to) {
    if (begin_call()) return -1;
    if (plan.no_links) return errno = EPERM, -1;
    return (int)end_call(__real_link(from, to));
}

int __real_linkat(int from, const char *old, int to, const char *new, int flags);
int __wrap_linkat(int from, const char *old, int to, const char *new, int flags);
int __wrap_linkat(int from, const char *old, int to, const char *new, int flags) {
    if (begin_call()) return -1;
    return (int)end_call(__real_linkat(from, old, to, new, flags));
}

/* ---- test directory -------------------------------------------------------------------------- */

static char directory[64], path[80];
static const char old_text[] = "the old file", new_text[] = "what is new and longer than the old";

/* Returns the number of entries besides the output, and removes all of them if asked. */
static int count_leftovers(int remove_all) {
    int count = 0;
    DIR *listing = opendir(directory);
    for (struct dirent *entry; (entry = readdir(listing));) {
        char name[sizeof directory + sizeof entry->d_name];
        snprintf(name, sizeof name, "%s/%s", directory, entry->d_name);
        if (entry->d_name[0] == '.' && strchr("./", entry->d_name[1])) continue; /* . and .. */
        if (entry->d_name[0] == '.') {
            assert_non_null(strstr(entry->d_name, ".phongsplat-")); /* the name that README gives */
            assert_non_null(strstr(entry->d_name, ".tmp"));
        }
        count += strcmp(name, path) != 0;
        if (remove_all) unlink(name);
    }
    closedir(listing);
    return count;
}

static void put_old(int is_there) {
    FILE *file = is_there ? fopen(path, "wb") : NULL;
    if (!file) return;
    fwrite(old_text, 1, sizeof old_text - 1, file);
    fclose(file);
}

/* Returns the state of the output: 'o'ld, 'n'ew, 'e'mpty, '-' for absent, or '?' for anything else.
 */
static char look(void) {
    char found[128] = {0};
    FILE *file = fopen(path, "rb");
    if (!file) return '-';
    size_t size = fread(found, 1, sizeof found - 1, file);
    fclose(file);
    if (!size) return 'e';
    return strcmp(found, new_text) == 0 ? 'n' : strcmp(found, old_text) == 0 ? 'o' : '?';
}

static int set_up(void **state) {
    (void)state;
    /* A file system in memory makes a thousand calls of fsync() fast. */
    const char *memory = "/dev/shm";
    snprintf(directory, sizeof directory, "%s/phongsplat-faults-XXXXXX",
             access(memory, W_OK | X_OK) ? "/tmp" : memory);
    if (!mkdtemp(directory)) return -1;
    snprintf(path, sizeof path, "%s/out.glb", directory);
    memset(&plan, 0, sizeof plan);
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    count_leftovers(1);
    return rmdir(directory);
}

static psplat_result put_new(int overwrite, psplat_error *error) {
    plan.calls = 0;
    return psplat_output_write(path, new_text, sizeof new_text - 1, overwrite, error);
}

static psplat_result put_new_undisturbed(int overwrite) {
    int at = plan.at;
    plan.at = 0;
    psplat_result result = put_new(overwrite, NULL);
    plan.at = at;
    return result;
}

/* Writes in a process of its own, and returns whether it was killed. */
static int put_new_killed(int overwrite) {
    pid_t child = fork();
    if (!child) _exit(put_new(overwrite, NULL) != PSPLAT_OK);
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    if (WIFEXITED(status)) assert_int_equal(WEXITSTATUS(status), 0);
    return WIFSIGNALED(status);
}

/* ---- failures -------------------------------------------------------------------------------- */

/* Makes the n-th call fail. The result is an error and the old file, or success and the new file,
 * and never a leftover. Returns whether there was an n-th call. */
static int fail_at(int n, int cause, int is_there) {
    plan.kind = FAIL, plan.at = n, plan.cause = cause;
    put_old(is_there);
    psplat_error error = {0};
    psplat_result result = put_new(is_there, &error);
    int calls = plan.calls;
    char found = look();
    if (result) {
        assert_int_equal(result, PSPLAT_ERROR_WRITE);
        assert_non_null(strstr(error.text, strerror(cause)));
        assert_int_equal(found, is_there ? 'o' : '-');
    } else {
        assert_int_equal(found, 'n');
    }
    assert_int_equal(count_leftovers(0), 0);
    assert_int_equal(put_new_undisturbed(1), PSPLAT_OK); /* the next write */
    assert_int_equal(look(), 'n');
    unlink(path);
    return n <= calls;
}

static int fail_each(int cause, int is_there) {
    int n = 1;
    while (fail_at(n, cause, is_there)) ++n;
    return n - 1;
}

static void test_each_call_fails(void **state) {
    (void)state;
    static const int causes[] = {ENOSPC, EIO, EDQUOT, EACCES};
    int tried = 0;
    for (size_t i = 0; i < sizeof causes / sizeof *causes; ++i)
        for (int is_there = 0; is_there < 2; ++is_there)
            for (plan.no_nameless = 0; plan.no_nameless < 2; ++plan.no_nameless)
                for (plan.no_links = 0; plan.no_links < 2; ++plan.no_links)
                    tried += fail_each(causes[i], is_there);
    /* Each of four causes in eight situations hits at least five calls: create, two writes, sync
     * and publish. */
    assert_true(tried >= 4 * 8 * 5);
}

static psplat_result put_two(const char *second, psplat_error *error) {
    const psplat_output_file files[] = {{path, new_text, sizeof new_text - 1},
                                        {second, old_text, sizeof old_text - 1}};
    plan.calls = 0;
    return psplat_output_write_all(files, 2, 0, error);
}

/* Of two new files either both are there or neither is, whichever call fails. */
static void test_two_or_none(void **state) {
    (void)state;
    char second[96];
    int failures = 0, n;
    snprintf(second, sizeof second, "%s/second.json", directory);
    plan.kind = FAIL, plan.cause = ENOSPC;
    for (plan.no_nameless = 0; plan.no_nameless < 2; ++plan.no_nameless)
        for (n = 1; n == 1 || n - 1 <= plan.calls; ++n) {
            plan.at = n;
            psplat_error error = {0};
            psplat_result result = put_two(second, &error);
            assert_int_equal(look(), result ? '-' : 'n');
            assert_int_equal(!access(second, F_OK), !result);
            assert_int_equal(count_leftovers(0), !result);
            failures += result != PSPLAT_OK;
            count_leftovers(1);
        }
    assert_true(failures > 5); /* of the named files alone two writes, a sync and a link each */
}

/* A signal during a call is no failure. */
static void test_interrupted_writes_go_on(void **state) {
    (void)state;
    plan.kind = FAIL, plan.cause = EINTR;
    for (plan.at = 2; plan.at < 4; ++plan.at) {
        assert_int_equal(put_new(0, NULL), PSPLAT_OK);
        assert_int_equal(look(), 'n');
        unlink(path);
    }
}

/* ---- kill -9 --------------------------------------------------------------------------------- */

/* The number of kills, one before and one after each call, and of the files that they left. */
typedef struct losses {
    int kills, leftovers;
} losses;

static int kill_at(int n, fault kind, int is_there, losses *l) {
    plan.kind = kind, plan.at = n;
    put_old(is_there);
    int is_killed = put_new_killed(is_there);
    char found = look();
    /* Only on a file system without links may the reserved name be seen empty. */
    int may_be_empty = plan.no_links && plan.no_nameless && !is_there;
    assert_true(found == 'n' || found == (is_there ? 'o' : '-') || (may_be_empty && found == 'e'));
    if (!is_killed) assert_int_equal(found, 'n');
    l->kills += is_killed;
    l->leftovers += count_leftovers(0);
    assert_int_equal(put_new_undisturbed(1), PSPLAT_OK); /* the next write */
    assert_int_equal(look(), 'n');
    count_leftovers(1);
    return is_killed;
}

static losses kill_each(int is_there) {
    losses l = {0, 0};
    for (fault kind = KILL_BEFORE; kind <= KILL_AFTER; ++kind)
        for (int n = 1; kill_at(n, kind, is_there, &l);) ++n;
    return l;
}

static int has_nameless_files(void) {
    int file = __real_open(directory, O_TMPFILE | O_WRONLY, 0600);
    if (file >= 0) close(file);
    return file >= 0;
}

/* With nameless files a new output leaves nothing behind; a replaced one leaves a whole file in the
 * instant before the rename. */
static void test_killed_at_each_call(void **state) {
    (void)state;
    if (!has_nameless_files()) skip();
    losses new = kill_each(0), replaced = kill_each(1);
    assert_true(new.kills >= 10 && replaced.kills >= 10);
    assert_int_equal(new.leftovers, 0);
    assert_int_equal(replaced.leftovers, 2); /* after linkat and before rename */
}

/* Without nameless files one temporary file is left, whose name README gives. */
static void test_killed_without_nameless_files(void **state) {
    (void)state;
    plan.no_nameless = 1;
    for (plan.no_links = 0; plan.no_links < 2; ++plan.no_links)
        for (int is_there = 0; is_there < 2; ++is_there) {
            losses l = kill_each(is_there);
            assert_true(l.kills >= 10 && l.leftovers > 0 && l.leftovers < l.kills);
        }
}

/* ---- several processes ----------------------------------------------------------------------- */

/* Eight processes replace the same file at once, or create it with permission to replace it: all of
 * them succeed. */
static void test_all_that_may_replace_succeed(void **state) {
    (void)state;
    enum { PROCESSES = 8, TIMES = 6 };
    pid_t children[PROCESSES];
    for (plan.no_nameless = 0; plan.no_nameless < 2; ++plan.no_nameless)
        for (int i = 0; i < PROCESSES; ++i) {
            children[i] = fork();
            for (int k = 0; !children[i] && k < TIMES; ++k) {
                if (put_new(1, NULL)) _exit(1);
                if (k % 3 == 0) unlink(path);
            }
            if (!children[i]) _exit(0);
            if (i < PROCESSES - 1) continue;
            for (int j = 0; j < PROCESSES; ++j) {
                int status = 0;
                assert_int_equal(waitpid(children[j], &status, 0), children[j]);
                assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
            }
            assert_true(look() == 'n' || look() == '-');
            assert_int_equal(count_leftovers(0), 0);
        }
}

#define CASE(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)

int test_output_faults_main(void) {
    const struct CMUnitTest tests[] = {
        CASE(test_each_call_fails),
        CASE(test_two_or_none),
        CASE(test_interrupted_writes_go_on),
        CASE(test_killed_at_each_call),
        CASE(test_killed_without_nameless_files),
        CASE(test_all_that_may_replace_succeed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

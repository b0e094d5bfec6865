/* SPDX-License-Identifier: MIT
 *
 * test_broken.c - tests of what convert reports about broken promises: exit code, message and
 * report. The linker's --wrap puts a function in front of psplat_convert that makes the report
 * claim such promises.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "cli/command.h"
#include "mesh/mesh.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

static psplat_promise broken = PSPLAT_PROMISE_COUNT;

psplat_result __real_psplat_convert(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                    psplat_splats *splats, psplat_report *report,
                                    psplat_error *error);
psplat_result __wrap_psplat_convert(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                    psplat_splats *splats, psplat_report *report,
                                    psplat_error *error);

psplat_result __wrap_psplat_convert(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                    psplat_splats *splats, psplat_report *report,
                                    psplat_error *error) {
    psplat_result result = __real_psplat_convert(mesh, desc, splats, report, error);
    if (broken == PSPLAT_PROMISE_COUNT || !report) return result;
    report->promises[broken] = (psplat_kept){2, 3.5, 41};
    report->places[0] =
        (psplat_place){.promise = broken, .position = {0.25, -1.5, 1e6}, .value = 3.5};
    report->place_count = 1;
    return result;
}

static char directory[] = "/tmp/psplat-broken-XXXXXX";

static int enter(void **state) {
    (void)state;
    return mkdtemp(directory) && !chdir(directory) ? 0 : -1;
}

static int leave(void **state) {
    (void)state;
    unlink("out.glb");
    unlink("out.json");
    unlink("stderr.txt");
    return chdir("/") || rmdir(directory);
}

/* Runs convert, and keeps its standard error. */
static int convert(const char *model, char *text, size_t size) {
    char input[512];
    snprintf(input, sizeof input, "%s/samples/models/%s", PSPLAT_SOURCE_DIR, model);
    const char *const list[] = {"convert", input, "out.glb", "-t2", "-qw", "--report", "out.json"};
    char *arguments[7];
    for (int i = 0; i < 7; ++i) arguments[i] = (char *)(uintptr_t)list[i];
    int kept = dup(STDERR_FILENO);
    assert_non_null(freopen("stderr.txt", "w", stderr));
    int code = psplat_command_convert(7, arguments);
    fflush(stderr);
    dup2(kept, STDERR_FILENO);
    close(kept);
    FILE *file = fopen("stderr.txt", "r");
    assert_non_null(file);
    text[fread(text, 1, size - 1, file)] = 0;
    fclose(file);
    return code;
}

static void test_kept(void **state) {
    (void)state;
    char text[1024];
    assert_int_equal(convert("cube.off", text, sizeof text), PSPLAT_EXIT_SUCCESS);
    assert_string_equal(text, "");
}

/* Each broken promise gives exit code 9 and one line with the place, the value, the limit and the
 * number. */
static void test_broken(void **state) {
    (void)state;
    static const char *const causes[PSPLAT_PROMISE_COUNT] = {
        [PSPLAT_PROMISE_COVERAGE] = "no splat covers the surface within 2 % (41 samples)",
        [PSPLAT_PROMISE_DISTANCE] = "a splat leaves the surface by 3.5 %, not 2 % (41 ",
        [PSPLAT_PROMISE_NORMAL] = "the normal errs by 3.5 degrees, not 2 (41 samples)",
        [PSPLAT_PROMISE_CREASE] = "a splat crosses a crease by 3.5 %, not 2 % (41 edges)",
        [PSPLAT_PROMISE_TEXTURE] = "a texture slides by 3.5 %, not 2 % (41 samples)",
        [PSPLAT_PROMISE_COLOR] = "colours err by 3.5 %, not 2 % (41 samples)"};
    for (int k = 0; k < PSPLAT_PROMISE_COUNT; ++k) {
        char text[1024];
        broken = (psplat_promise)k;
        unlink("out.glb");
        assert_int_equal(convert("cube.off", text, sizeof text), PSPLAT_EXIT_BROKEN);
        broken = PSPLAT_PROMISE_COUNT;
        assert_ptr_equal(strchr(text, '\n'), text + strlen(text) - 1);
        if (strncmp(text, "phongsplat: ", 12) || !strstr(text, "cube.off: at 0.25 -1.5 1e+06: ") ||
            !strstr(text, causes[k]) || !strstr(text, "the output was written"))
            fail_msg("%s", text);
        /* The output was written indeed, and the report agrees. */
        assert_int_equal(access("out.glb", R_OK), 0);
        FILE *file = fopen("out.json", "r");
        assert_non_null(file);
        char report[8192];
        report[fread(report, 1, sizeof report - 1, file)] = 0;
        fclose(file);
        assert_non_null(strstr(report, "\"kept\": false"));
        assert_non_null(strstr(report, "\"position\": [0.25, -1.5, 1000000]"));
    }
}

/* For a scene the line names the mesh and counts all meshes, and the report lists each mesh. */
static void test_broken_scene(void **state) {
    (void)state;
    char text[1024];
    broken = PSPLAT_PROMISE_DISTANCE;
    unlink("out.glb");
    assert_int_equal(convert("still-life.glb", text, sizeof text), PSPLAT_EXIT_BROKEN);
    broken = PSPLAT_PROMISE_COUNT;
    if (!strstr(text, "still-life.glb: mesh 0 'table' at 0.25 -1.5 1e+06: ") ||
        !strstr(text, "by 3.5 %, not 2 % (164 splats)"))
        fail_msg("%s", text);
    FILE *file = fopen("out.json", "r");
    assert_non_null(file);
    char report[32768];
    report[fread(report, 1, sizeof report - 1, file)] = 0;
    fclose(file);
    for (int i = 0; i < 4; ++i) {
        char place[64];
        snprintf(place, sizeof place, "\"mesh\": %d,\n      \"position\": [0.25", i);
        if (!strstr(report, place)) fail_msg("no %s in %s", place, report);
    }
}

int test_broken_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_kept), cmocka_unit_test(test_broken),
                                       cmocka_unit_test(test_broken_scene)};
    return cmocka_run_group_tests(tests, enter, leave);
}

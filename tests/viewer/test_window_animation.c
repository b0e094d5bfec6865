/* SPDX-License-Identifier: MIT
 *
 * test_window_animation.c - tests in the real window that animations play, pause and change.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "moving.h"
#include "window_fixture.h"

#include <stdlib.h>
#include <string.h>

/* Writes an asset with two animations: in the first it jumps far to the side at once and stays
 * there, in the second it jumps to the other side. */
static void write_jumping(const char *path) {
    static const float times[] = {0, 0.01f, 1000}, left[] = {-3, 0, 0, -9, 0, 0, -9, 0, 0};
    static const float right[] = {9, 0, 0, 9, 0, 0, 9, 0, 0};
    moving m = {0};
    moving_floats(&m, times, 3, 1);
    moving_floats(&m, left, 3, 3);
    moving_floats(&m, right, 3, 3);
    char *text = moving_text(
        &m, PSPLAT_SOURCE_DIR, "{\"mesh\":0}",
        "{\"name\":\"left\",\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
        "\"translation\"}}],\"samplers\":[{\"input\":16,\"output\":17,\"interpolation\":\"STEP\"}]}"
        ","
        "{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}],"
        "\"samplers\":[{\"input\":16,\"output\":18,\"interpolation\":\"STEP\"}]}");
    write_file(path, text, strlen(text));
    free(text);
}

static void test_pause_and_next(void **state) {
    fixture *f = *state;
    write_jumping(f->a);
    start(f, "--paused", f->a, NULL);
    picture paused = await_covered(f, "the asset is drawn", 50, ALL);
    program_key(&f->viewer, "k", 0);
    await_differences(f, "it plays", &paused, 50);
    picture left = await_still(f, "it has jumped");
    program_key(&f->viewer, "n", 0);
    await_differences(f, "the next one plays", &left, 50);
    program_key(&f->viewer, "n", 0);
    await_return(f, "and the first again", &left);
    free(paused.rgb);
    free(left.rgb);
    quit(f);
}

int test_window_animation_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_pause_and_next)};
    return window_run(tests, sizeof tests / sizeof *tests);
}

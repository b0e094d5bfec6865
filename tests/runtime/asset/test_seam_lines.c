/* SPDX-License-Identifier: MIT
 *
 * test_seam_lines.c - tests what the reader makes of seamLines (spec 3.1): a number of a primitive,
 * or one of each section of its stream; and what of it is refused, at which byte.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "document.h"

#include <phongsplat/phongsplat.h>

#include <stdlib.h>

/* Returns the streamed example with a member more beside its stream, whose sections have three
 * lines and four. */
static char *streamed(const char *member) {
    size_t size;
    char *text = document_read(PSPLAT_SOURCE_DIR "/schema/streamed.gltf", &size), both[64] = "";
    strcat(strcat(both, "\"stream\": 0, "), member);
    document_replace(&text, "\"stream\": 0", both);
    return text;
}

static psplat_asset *open_text(const char *text, const psplat_asset_desc *desc) {
    psplat_asset *asset = NULL;
    psplat_error error;
    if (psplat_asset_open_memory(text, strlen(text), desc, &asset, &error))
        fail_msg("%s", error.text);
    return asset;
}

/* Lines of splats are the same with and without, and none are seams where nothing is said. */
static void test_primitives(void **state) {
    (void)state;
    for (uint32_t seams = 0; seams <= 3; ++seams) {
        char *text = document_minimal(PSPLAT_SOURCE_DIR),
             member[] = "\"clipLines\": 2, \"seamLines\": 0";
        member[sizeof member - 2] = (char)('0' + seams % 3);
        if (seams < 3) document_replace(&text, "\"clipLines\": 2", member);
        for (int only_draws = 0; only_draws < 2; ++only_draws) {
            const psplat_asset_desc desc = {.only_draws = only_draws};
            psplat_asset *asset = open_text(text, &desc);
            const psplat_batch *whole = psplat_asset_batch(asset, 0);
            const psplat_batch *cut =
                psplat_asset_batch(asset, psplat_asset_batch_count(asset) - 1);
            assert_int_equal(whole->seam_lines, 0);
            assert_int_equal(cut->clip_count, 2);
            assert_int_equal(cut->seam_lines, seams % 3);
            if (!only_draws) assert_int_equal(cut->splats[0].clip_count, 2);
            psplat_asset_destroy(asset);
        }
        free(text);
    }
}

static void test_sections(void **state) {
    (void)state;
    char *text = streamed("\"seamLines\": [1, 4]"), *plain = streamed("\"seamColor\": 3");
    psplat_asset *asset = open_text(text, NULL), *without = open_text(plain, NULL);
    for (size_t i = 0; i < 2; ++i) {
        assert_int_equal(psplat_asset_batch(asset, i)->clip_count, i ? 4 : 3);
        assert_int_equal(psplat_asset_batch(asset, i)->seam_lines, i ? 4 : 1);
        assert_int_equal(psplat_asset_batch(without, i)->seam_lines, 0);
    }
    psplat_asset_destroy(asset);
    psplat_asset_destroy(without);
    free(text);
    free(plain);
}

/* Expects that text is refused with a code at the first occurrence of at. */
static void expect(const char *text, psplat_result code, const char *at) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    psplat_result result = psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error);
    if (result != code || error.offset != document_find(text, at))
        fail_msg("%s: result %d, %s at %zu", at, (int)result, error.text, error.offset);
    assert_non_null(strstr(error.text, "seamLines"));
}

static void test_refused(void **state) {
    (void)state;
    static const struct {
        const char *value;
        psplat_result code;
    } faults[] = {{"3", PSPLAT_ERROR_RANGE},    {"-1", PSPLAT_ERROR_RANGE},
                  {"0.5", PSPLAT_ERROR_RANGE},  {"\"1\"", PSPLAT_ERROR_FORMAT},
                  {"[1]", PSPLAT_ERROR_FORMAT}, {"true", PSPLAT_ERROR_FORMAT},
                  {"1e9", PSPLAT_ERROR_RANGE},  {"null", PSPLAT_ERROR_FORMAT}};
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
        char *text = document_minimal(PSPLAT_SOURCE_DIR), member[64] = "\"clipLines\": 2, ";
        char at[32] = "";
        strcat(strcat(at, faults[i].value), ", \"depth");
        strcat(strcat(strcat(member, "\"seamLines\": "), faults[i].value), ", \"depth");
        document_replace(&text, "\"clipLines\": 2, \"depth", member);
        expect(text, faults[i].code, at);
        free(text);
    }
}

static void test_refused_sections(void **state) {
    (void)state;
    static const struct {
        const char *member, *at;
        psplat_result code;
    } faults[] = {{"\"seamLines\": 1 ", "1 \n", PSPLAT_ERROR_FORMAT},
                  {"\"seamLines\": [2]", "[2]\n", PSPLAT_ERROR_FORMAT},
                  {"\"seamLines\": []", "[]\n", PSPLAT_ERROR_FORMAT},
                  {"\"seamLines\": [2, 2, 2]", "[2, 2, 2]", PSPLAT_ERROR_FORMAT},
                  {"\"seamLines\": [4, 2]", "4, 2]", PSPLAT_ERROR_RANGE},
                  {"\"seamLines\": [2, 5]", "5]\n", PSPLAT_ERROR_RANGE},
                  {"\"seamLines\": [-2, 2]", "-2, 2]", PSPLAT_ERROR_RANGE},
                  {"\"seamLines\": [2, {}]", "{}]", PSPLAT_ERROR_FORMAT}};
    for (size_t i = 0; i < sizeof faults / sizeof *faults; ++i) {
        char *text = streamed(faults[i].member);
        expect(text, faults[i].code, faults[i].at);
        free(text);
    }
}

int test_seam_lines_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_primitives),
        cmocka_unit_test(test_sections),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_refused_sections),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

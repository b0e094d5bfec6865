/* SPDX-License-Identifier: MIT
 *
 * test_fallback_link.c - tests fallback meshes, which stand in for splats where the extension is
 * not known (spec 6.1): the reader draws the splats in their place. Documents are the bundled one
 * with further meshes.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "document.h"

#include <phongsplat/phongsplat.h>

#include <stdlib.h>

#define POINTS "{ \"primitives\": [{ \"mode\": 0, \"attributes\": { \"POSITION\": 0 } }]"
#define FOR(object) POINTS ", \"extensions\": { \"PSPLAT_surface_splats\": " object " } }, "

/* Returns the bundled document with further meshes before its own. */
static char *document_with(const char *meshes) {
    char *text = document_minimal(PSPLAT_SOURCE_DIR), list[1024];
    snprintf(list, sizeof list, "\"meshes\": [%s", meshes);
    document_replace(&text, "\"meshes\": [", list);
    return text;
}

static void check_opens(const char *text, size_t batches, size_t primitives) {
    psplat_asset *asset = NULL;
    psplat_error error;
    if (psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error))
        fail_msg("%s (byte %zu)", error.text, error.offset);
    assert_int_equal(psplat_asset_batch_count(asset), batches);
    size_t found = 0;
    for (size_t i = 0; i < batches; ++i)
        found |= (size_t)1 << psplat_asset_batch(asset, i)->primitive;
    assert_int_equal(found, ((size_t)1 << primitives) - 1);
    psplat_asset_destroy(asset);
}

static void test_splats_in_place(void **state) {
    (void)state;
    char *text = document_with(FOR("{ \"mesh\": 1 }"));
    check_opens(text, 3, 3);
    /* Meshes are shared: two nodes refer to the fallback mesh, one to the mesh of splats. */
    document_replace(&text, "\"nodes\": [0]", "\"nodes\": [0, 1, 2]");
    document_replace(&text, "\"nodes\": [\n", "\"nodes\": [{ \"mesh\": 1 }, { \"mesh\": 0 },\n");
    check_opens(text, 9, 3);
    free(text);
    text = document_with(FOR("{ \"mesh\": 2 }") FOR("{ \"mesh\": 2, \"extras\": 1 }"));
    document_replace(&text, "\"nodes\": [0]", "\"nodes\": [0, 1]");
    document_replace(&text, "\"nodes\": [\n", "\"nodes\": [{ \"mesh\": 1 },\n");
    check_opens(text, 6, 3);
    free(text);
}

/* The transform is that of the node that refers to the fallback mesh. */
static void test_transform(void **state) {
    (void)state;
    char *text = document_with(FOR("{ \"mesh\": 1 }"));
    document_replace(&text, "\"mesh\": 0, \"name\"",
                     "\"translation\": [1, 2, 3], \"mesh\": 0, \"name\"");
    psplat_asset *asset = NULL;
    assert_int_equal(psplat_asset_open_memory(text, strlen(text), NULL, &asset, NULL), PSPLAT_OK);
    static const double origin[3] = {1, 2, 3};
    assert_memory_equal(psplat_asset_batch(asset, 0)->model + 12, origin, sizeof origin);
    psplat_asset_destroy(asset);
    free(text);
}

static void check_refused(char *text, psplat_result code, const char *at) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    psplat_result result = psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error);
    if (result != code || error.offset != document_find(text, at))
        fail_msg("%s: %s (byte %zu, expected %zu)", psplat_result_text(result), error.text,
                 error.offset, document_find(text, at));
    assert_null(asset);
    free(text);
}

static void test_refused(void **state) {
    (void)state;
    check_refused(document_with(FOR("{ \"mesh\": 2 }")), PSPLAT_ERROR_RANGE, "2 } } }");
    check_refused(document_with(FOR("{ \"mesh\": -1 }")), PSPLAT_ERROR_RANGE, "-1 } } }");
    check_refused(document_with(FOR("{ \"mesh\": \"1\" }")), PSPLAT_ERROR_FORMAT, "\"1\" } } }");
    check_refused(document_with(FOR("{ \"meshes\": 1 }")), PSPLAT_ERROR_FORMAT, "{ \"meshes\"");
    check_refused(document_with(FOR("7")), PSPLAT_ERROR_FORMAT, "7 } }");
    /* A mesh may not stand in for itself, for one without splats, or for another fallback mesh. */
    check_refused(document_with(FOR("{ \"mesh\": 0 }")), PSPLAT_ERROR_FORMAT, "0 } } }");
    check_refused(document_with(FOR("{ \"mesh\": 1 }") POINTS "}, "), PSPLAT_ERROR_FORMAT,
                  "1 } } }");
    check_refused(document_with(FOR("{ \"mesh\": 1 }") FOR("{ \"mesh\": 2 }")), PSPLAT_ERROR_FORMAT,
                  "1 } } }");
}

/* A fallback mesh may not have splats of its own, because they would never be drawn. */
static void test_splats_in_stand_in(void **state) {
    (void)state;
    char *text = document_with(POINTS " }, ");
    document_replace(&text, "\"materials\"", "\"other\": 0, \"materials\"");
    document_replace(&text, "      ]\n    }\n  ],\n  \"other\"",
                     "      ], \"extensions\": { \"PSPLAT_surface_splats\": { \"mesh\": 0 } }\n"
                     "    }\n  ],\n  \"other\"");
    check_refused(text, PSPLAT_ERROR_FORMAT, "{ \"mesh\": 0 } }");
}

/* A tool that drops both objects leaves a file without splats, and the error says why. */
static void test_stripped(void **state) {
    (void)state;
    char *text = document_with(POINTS "}, ");
    while (strstr(text, "\"PSPLAT_surface_splats\": {"))
        document_replace(&text, "\"PSPLAT_surface_splats\": {", "\"EXT_other\": {");
    check_refused(text, PSPLAT_ERROR_NO_SPLATS, "\"_PSPLAT_surface_splats:ROTATION");
}

int test_fallback_link_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_splats_in_place), cmocka_unit_test(test_transform),
        cmocka_unit_test(test_refused),         cmocka_unit_test(test_splats_in_stand_in),
        cmocka_unit_test(test_stripped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

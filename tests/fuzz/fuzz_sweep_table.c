/* SPDX-License-Identifier: MIT
 *
 * fuzz_sweep_table.c - reads any text as the table of a sweep and writes what is made of it: the
 * same rows again, the script of the charts and the page.
 */
#include "tradeoff/charts.h"
#include "tradeoff/page.h"
#include "table/sweep_options.h"
#include "table/sweep_table.h"
#include "table/text.h"
#include "fuzz.h"

#include <stdlib.h>
#include <string.h>

/* Returns the table that a sweep expects; the seeds have rows of it. */
static psplat_sweep_table planned(void) {
    psplat_sweep_table table = {.options = {.tolerances = {{2, 1}, 2}, .ratios = {{0.5}, 1}},
                                .source = "a <fuzz>&'.obj",
                                .graphics = "llvmpipe <fuzz>",
                                .gltfpack = "gltfpack 1.3"};
    psplat_sweep_options_complete(&table.options);
    FUZZ_DEMAND(!psplat_sweep_table_plan(&table, NULL));
    return table;
}

static psplat_text written(const psplat_sweep_table *table) {
    psplat_text text = {0};
    psplat_sweep_table_write(table, &text);
    FUZZ_DEMAND(!psplat_text_check(&text, NULL));
    return text;
}

/* A table that was read is written, read and written again: both texts must be equal. */
static void check_again(const psplat_sweep_table *table) {
    psplat_sweep_table copy = planned();
    psplat_error error = {0};
    psplat_text first = written(table);
    FUZZ_DEMAND(!psplat_sweep_table_recall(&copy, first.data, first.size, &error));
    psplat_text second = written(&copy);
    FUZZ_DEMAND(second.size == first.size && !memcmp(second.data, first.data, first.size));
    psplat_sweep_table_free(&copy);
    free(first.data);
    free(second.data);
}

/* Names must be text, not markup, and ranges of axes must be numbers. */
static void check_charts_and_page(const psplat_sweep_table *table) {
    psplat_text script = {0}, page = {0};
    psplat_charts_script(table, &script);
    psplat_page_write(table, "/nowhere", 0, &page);
    FUZZ_DEMAND(!psplat_text_check(&script, NULL) && !psplat_text_check(&page, NULL));
    FUZZ_DEMAND(!strstr(script.data, "nan") && !strstr(script.data, "inf"));
    FUZZ_DEMAND(!strstr(page.data, "<fuzz"));
    free(script.data);
    free(page.data);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_meter meter = {0};
    psplat_error error = {0};
    psplat_sweep_table table = planned();
    fuzz_meter_start(&meter);
    psplat_result result = psplat_sweep_table_recall(&table, (const char *)data, size, &error);
    if (result) {
        FUZZ_DEMAND(result == PSPLAT_ERROR_FORMAT && error.code == result && error.text[0]);
    } else {
        check_again(&table);
        check_charts_and_page(&table);
    }
    psplat_sweep_table_free(&table);
    fuzz_meter_stop(&meter, 2.0);
    return 0;
}

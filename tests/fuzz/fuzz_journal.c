/* SPDX-License-Identifier: MIT
 *
 * fuzz_journal.c - any text as the journal of a sweep, and what is made of it: the same text again,
 * charts and the page. Check sums, which no mutation would keep, are all 1.
 */
#include "fuzz.h"
#include "tradeoff.h"

#include <string.h>

/* The linker's name (--wrap). */
uint64_t __wrap_psplat_stamp_bytes(uint64_t stamp, const void *data, size_t size);

uint64_t __wrap_psplat_stamp_bytes(uint64_t stamp, const void *data, size_t size) {
    (void)stamp, (void)data, (void)size;
    return 1;
}

static psplat_text written(const psplat_journal *journal) {
    psplat_text text = {0};
    psplat_journal_write(journal, &text);
    FUZZ_DEMAND(!psplat_text_check(&text, NULL));
    return text;
}

/* What is read is written, read and written again alike. */
static void check_again(const psplat_journal *journal) {
    psplat_journal copy;
    psplat_error error = {0};
    psplat_text first = written(journal);
    psplat_result result = psplat_journal_read(first.data, first.size, &copy, &error);
    if (result) fprintf(stderr, "%s\n%s\n", error.text, first.data);
    FUZZ_DEMAND(!result && copy.count == journal->count);
    psplat_text second = written(&copy);
    FUZZ_DEMAND(second.size == first.size && !memcmp(second.data, first.data, first.size));
    psplat_journal_free(&copy);
    free(first.data);
    free(second.data);
}

/* A coordinate that is none, as printf writes it; names that look like it are left alone. */
static int holds_no_number(const psplat_journal *journal, const char *text) {
    static const char *const words[] = {"\"nan", "\"-nan", "\"inf", "\"-inf", " nan", " -nan",
                                        " inf",  " -inf",  ",nan",  ",-nan",  ",inf", ",-inf"};
    if (strstr(journal->source, "nan") || strstr(journal->source, "inf")) return 0;
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i)
        if (strstr(text, words[i])) return 1;
    return 0;
}

static void check_charts(const psplat_journal *journal) {
    psplat_chart charts[PSPLAT_CHARTS];
    size_t count = psplat_chart_list(psplat_rows_cost(journal->rows, journal->count), charts);
    for (size_t i = 0; i < count; ++i) {
        psplat_text svg = {0};
        psplat_chart_write(&charts[i], journal, &svg);
        FUZZ_DEMAND(!psplat_text_check(&svg, NULL));
        FUZZ_DEMAND(!holds_no_number(journal, svg.data) && !strstr(svg.data, "<fuzz"));
        free(svg.data);
    }
}

static void check_page(const psplat_journal *journal) {
    psplat_text page = {0};
    psplat_page_write(journal, &page);
    FUZZ_DEMAND(!psplat_text_check(&page, NULL));
    FUZZ_DEMAND(!strstr(page.data, "<fuzz")); /* of the seeds: names are text, not markup */
    free(page.data);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_meter meter = {0};
    psplat_journal journal;
    psplat_error error = {0};
    fuzz_meter_start(&meter);
    psplat_result result = psplat_journal_read((const char *)data, size, &journal, &error);
    if (result) {
        FUZZ_DEMAND(result == PSPLAT_ERROR_FORMAT && error.code == result && error.text[0]);
        return 0;
    }
    check_again(&journal);
    check_charts(&journal);
    check_page(&journal);
    psplat_journal_free(&journal);
    fuzz_meter_stop(&meter, 2.0);
    return 0;
}

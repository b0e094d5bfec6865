/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * record.c - what a finished task leaves, as text.
 */
#include "tiles/record.h"

#include "base/output.h"
#include "base/path.h"
#include "tiles/checked_text.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RECORD_VERSION = 3 };

static void add_tile(const psplat_tile *tile, psplat_checked_text *text) {
    psplat_checked_add(text, "tile r%s %d", tile->path, tile->level);
    psplat_checked_numbers(text, tile->region, 6);
    psplat_checked_numbers(text, tile->bounds, 6);
    psplat_checked_numbers(text, &tile->error, 1);
    psplat_checked_numbers(text, &tile->normal_error, 1);
    psplat_checked_numbers(text, tile->cone, 4);
    psplat_checked_add(text, " %zu %zu %s\n", tile->splats, tile->bytes, tile->content);
}

int psplat_tile_is_broken(const psplat_tile_broken *broken) {
    for (int i = 0; i < PSPLAT_PROMISE_COUNT; ++i)
        if (broken->promises[i]) return 1;
    return 0;
}

const char *psplat_tile_promise_name(psplat_promise promise) {
    static const char *const names[PSPLAT_PROMISE_COUNT] = {"coverage", "distance", "normals",
                                                            "creases",  "textures", "colors"};
    return names[promise];
}

static void add_broken(const psplat_tile_broken *broken, psplat_checked_text *text) {
    psplat_checked_add(text, "\nbroken");
    for (int i = 0; i < PSPLAT_PROMISE_COUNT; ++i)
        psplat_checked_add(text, " %d", broken->promises[i]);
    psplat_checked_add(text, " first %d", (int)broken->first);
    psplat_checked_numbers(text, broken->position, 3);
    psplat_checked_numbers(text, &broken->tolerance_percent, 1);
}

static void read_broken(psplat_words *words, psplat_tile_broken *broken) {
    psplat_words_expect(words, "broken");
    for (int i = 0; i < PSPLAT_PROMISE_COUNT; ++i)
        broken->promises[i] = psplat_words_count(words) != 0;
    psplat_words_expect(words, "first");
    uint64_t first = psplat_words_count(words);
    words->failed |= first >= PSPLAT_PROMISE_COUNT;
    broken->first = words->failed ? PSPLAT_PROMISE_COVERAGE : (psplat_promise)first;
    psplat_words_numbers(words, broken->position, 3);
    broken->tolerance_percent = psplat_words_number(words);
}

psplat_result psplat_tile_record_write(const psplat_tile_record *record, uint64_t plan,
                                       const char *path, psplat_error *error) {
    psplat_checked_text text = {0};
    psplat_checked_begin(&text, "record", RECORD_VERSION);
    psplat_checked_add(&text, "plan %" PRIu64 " task %s coarsest %d deviation", plan, record->task,
                       record->coarsest);
    psplat_checked_numbers(&text, &record->deviation, 1);
    add_broken(&record->broken, &text);
    psplat_checked_add(&text, "\ntiles %zu\n", record->tile_count);
    for (size_t i = 0; i < record->tile_count; ++i) add_tile(&record->tiles[i], &text);
    psplat_checked_end(&text);
    psplat_result result =
        text.failed ? psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for a record")
                    : psplat_output_write(path, text.text, text.size, 1, error);
    free(text.text);
    return result;
}

/* Copies a word that fits. */
static void take_word(psplat_words *words, char *to, size_t size) {
    const char *word = psplat_words_next(words);
    words->failed |= strlen(word) >= size;
    if (!words->failed) memcpy(to, word, strlen(word) + 1);
}

static void read_tile(psplat_words *words, psplat_tile *tile) {
    char name[PSPLAT_CELL_PATH + 1] = "r";
    psplat_words_expect(words, "tile");
    take_word(words, name, sizeof name);
    words->failed |= *name != 'r';
    memcpy(tile->path, name + 1, sizeof tile->path);
    tile->level = (int)psplat_words_count(words);
    psplat_words_numbers(words, tile->region, 6);
    psplat_words_numbers(words, tile->bounds, 6);
    tile->error = psplat_words_number(words);
    tile->normal_error = psplat_words_number(words);
    psplat_words_numbers(words, tile->cone, 4);
    tile->splats = (size_t)psplat_words_count(words);
    tile->bytes = (size_t)psplat_words_count(words);
    take_word(words, tile->content, sizeof tile->content);
}

static psplat_result read_record(psplat_words *words, uint64_t plan, const char *shown,
                                 psplat_tile_record *record, psplat_error *error) {
    psplat_words_expect(words, "plan");
    uint64_t own = psplat_words_count(words);
    if (!words->failed && own != plan)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0,
                           "%s: belongs to another plan; delete it to make it anew", shown);
    psplat_words_expect(words, "task");
    take_word(words, record->task, sizeof record->task);
    psplat_words_expect(words, "coarsest");
    record->coarsest = (int)psplat_words_count(words);
    psplat_words_expect(words, "deviation");
    record->deviation = psplat_words_number(words);
    read_broken(words, &record->broken);
    psplat_words_expect(words, "tiles");
    record->tile_count = (size_t)psplat_words_count(words);
    if (!words->failed) record->tiles = calloc(record->tile_count + 1, sizeof *record->tiles);
    if (!words->failed && !record->tiles)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for a record");
    for (size_t i = 0; i < record->tile_count && !words->failed; ++i)
        read_tile(words, &record->tiles[i]);
    if (!words->failed) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "%s: is no record of this program", shown);
}

psplat_result psplat_tile_record_read(const char *path, uint64_t plan, psplat_tile_record *record,
                                      psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_words words;
    *record = (psplat_tile_record){0};
    psplat_path_shorten(path, shown);
    psplat_result result = psplat_words_open(path, "record", RECORD_VERSION, &words, error);
    if (result) return result;
    result = read_record(&words, plan, shown, record, error);
    psplat_words_close(&words);
    if (result) psplat_tile_record_free(record);
    return result;
}

void psplat_tile_record_free(psplat_tile_record *record) {
    free(record->tiles);
    *record = (psplat_tile_record){0};
}

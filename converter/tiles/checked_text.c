/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * checked_text.c - small text files of words and numbers that are whole or refused.
 */
#include "tiles/checked_text.h"

#include "base/file_bytes.h"
#include "base/path.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The bytes of the last line: "end ", 16 digits and the end of the line. */
enum { LAST_LINE = 21 };

uint64_t psplat_hash_bytes(uint64_t hash, const void *data, size_t size) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3u;
    return hash;
}

/* ---- writing --------------------------------------------------------------------------------- */

static int reserve(psplat_checked_text *text, size_t more) {
    if (text->failed) return 0;
    if (text->size + more < text->capacity) return 1;
    size_t capacity = 2 * text->capacity + more + 256;
    char *larger = realloc(text->text, capacity);
    text->failed = !larger;
    if (!larger) return 0;
    text->text = larger;
    text->capacity = capacity;
    return 1;
}

void psplat_checked_add(psplat_checked_text *text, const char *format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    if (length >= 0 && reserve(text, (size_t)length + 1)) {
        vsnprintf(text->text + text->size, (size_t)length + 1, format, again);
        text->size += (size_t)length;
    }
    va_end(again);
    va_end(arguments);
}

void psplat_checked_numbers(psplat_checked_text *text, const double *numbers, size_t count) {
    for (size_t i = 0; i < count; ++i) psplat_checked_add(text, " %.17g", numbers[i]);
}

void psplat_checked_begin(psplat_checked_text *text, const char *kind, int version) {
    psplat_checked_add(text, "phongsplat tile %s %d\n", kind, version);
}

uint64_t psplat_checked_end(psplat_checked_text *text) {
    uint64_t hash = psplat_hash_bytes(PSPLAT_HASH_BEGIN, text->text, text->failed ? 0 : text->size);
    psplat_checked_add(text, "end %016" PRIx64 "\n", hash);
    return hash;
}

/* ---- reading --------------------------------------------------------------------------------- */

/* Checks the first line and the last one, and cuts the last one off. */
static psplat_result check(psplat_words *words, size_t size, const char *shown, const char *kind,
                           int version, psplat_error *error) {
    char begin[64], end[LAST_LINE + 1];
    snprintf(begin, sizeof begin, "phongsplat tile %s ", kind);
    if (strncmp(words->data, begin, strlen(begin)) != 0)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "%s: is no %s of tiles", shown, kind);
    words->cursor = words->data + strlen(begin);
    char *last = size > LAST_LINE ? words->data + size - LAST_LINE : words->data;
    char *number = psplat_words_next(words);
    if (!words->failed && atoi(number) != version)
        return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 0,
                           "%s: is of version %.12s, and this program knows %d", shown, number,
                           version);
    words->data[strlen(begin) + strlen(number)] = '\n'; /* where the word was ended */
    words->hash = psplat_hash_bytes(PSPLAT_HASH_BEGIN, words->data, (size_t)(last - words->data));
    snprintf(end, sizeof end, "end %016" PRIx64 "\n", words->hash);
    if (memcmp(last, end, words->data + size - last < LAST_LINE ? 1 : LAST_LINE) != 0)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0,
                           "%s: is not whole; delete it to make it anew", shown);
    *last = 0;
    return PSPLAT_OK;
}

psplat_result psplat_words_open(const char *path, const char *kind, int version,
                                psplat_words *words, psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    size_t size;
    *words = (psplat_words){0};
    psplat_path_shorten(path, shown);
    psplat_result result = psplat_file_read(path, &words->data, &size, error);
    if (!result) result = check(words, size, shown, kind, version, error);
    if (result) psplat_words_close(words);
    return result;
}

void psplat_words_close(psplat_words *words) {
    free(words->data);
    *words = (psplat_words){0};
}

char *psplat_words_next(psplat_words *words) {
    words->cursor += strspn(words->cursor, " \n");
    char *word = words->cursor;
    words->cursor += strcspn(word, " \n");
    if (*words->cursor) *words->cursor++ = 0;
    words->failed |= !*word;
    return word;
}

char *psplat_words_line(psplat_words *words) {
    words->cursor += strspn(words->cursor, " ");
    char *line = words->cursor;
    words->cursor += strcspn(line, "\n");
    if (*words->cursor) *words->cursor++ = 0;
    return line;
}

uint64_t psplat_words_count(psplat_words *words) {
    char *end, *word = psplat_words_next(words);
    uint64_t count = strtoull(word, &end, 10);
    words->failed |= end == word || *end;
    return words->failed ? 0 : count;
}

double psplat_words_number(psplat_words *words) {
    char *end, *word = psplat_words_next(words);
    double number = strtod(word, &end);
    words->failed |= end == word || *end;
    return words->failed ? 0 : number;
}

void psplat_words_numbers(psplat_words *words, double *numbers, size_t count) {
    for (size_t i = 0; i < count; ++i) numbers[i] = psplat_words_number(words);
}

void psplat_words_expect(psplat_words *words, const char *word) {
    words->failed |= strcmp(psplat_words_next(words), word) != 0;
}

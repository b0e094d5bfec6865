/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * checked_text.h - small text files of words and numbers that are whole or refused: plans of tiles
 * and records of tasks.
 *
 * The first line is "phongsplat tile KIND VERSION", the last "end HASH" of all before it.
 */
#ifndef PHONGSPLAT_TILES_CHECKED_TEXT_H
#define PHONGSPLAT_TILES_CHECKED_TEXT_H

#include <phongsplat/splat.h>

#include <stddef.h>
#include <stdint.h>

/* A text that grows; zero-initialise it. After a failed allocation all further calls do nothing. */
typedef struct psplat_checked_text {
    char *text; /* malloc'ed, owned by the caller */
    size_t size, capacity;
    int failed;
} psplat_checked_text;

/* Appends by printf. Numbers do not depend on the locale unless the program sets one. */
void psplat_checked_add(psplat_checked_text *text, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* Appends " X" for each number, so that it reads back as the same double. */
void psplat_checked_numbers(psplat_checked_text *text, const double *numbers, size_t count);

/* Begins a file of a kind and version. */
void psplat_checked_begin(psplat_checked_text *text, const char *kind, int version);

/* Ends the file and returns the hash of all before its last line. */
uint64_t psplat_checked_end(psplat_checked_text *text);

/* The words of a file, one after the other. */
typedef struct psplat_words {
    char *data;   /* malloc'ed */
    char *cursor; /* the next word */
    uint64_t hash;
    int failed; /* a word was not what it should be */
} psplat_words;

/* Reads a file of a kind and version. Errors: PSPLAT_ERROR_READ, PSPLAT_ERROR_FORMAT (another kind,
 * or not whole), PSPLAT_ERROR_UNSUPPORTED (another version), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_words_open(const char *path, const char *kind, int version,
                                psplat_words *words, psplat_error *error);

/* Returns the next word, or "" at the end, which sets failed. Words are separated by blanks. */
char *psplat_words_next(psplat_words *words);

/* Returns the rest of the line. */
char *psplat_words_line(psplat_words *words);

/* These set failed, and return or store 0, where the next word is not a number. */
uint64_t psplat_words_count(psplat_words *words);
double psplat_words_number(psplat_words *words);
void psplat_words_numbers(psplat_words *words, double *numbers, size_t count);

/* Sets failed unless the next word is this one. */
void psplat_words_expect(psplat_words *words, const char *word);

void psplat_words_close(psplat_words *words);

/* Continues a hash with some bytes (FNV-1a, 64 bits); PSPLAT_HASH_BEGIN is that of none. */
#define PSPLAT_HASH_BEGIN 0xcbf29ce484222325u
uint64_t psplat_hash_bytes(uint64_t hash, const void *data, size_t size);

#endif

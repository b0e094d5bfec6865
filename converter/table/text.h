/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * text.h - text that grows: the table, the script of the charts and the page are made of it.
 */
#ifndef PHONGSPLAT_TABLE_TEXT_H
#define PHONGSPLAT_TABLE_TEXT_H

#include <phongsplat/splat.h>

/* Zero-initialised. After a failed allocation further calls do nothing. */
typedef struct psplat_text {
    char *data; /* terminated, from malloc, owned by the caller; NULL while empty */
    size_t size, capacity;
    int failed;
} psplat_text;

void psplat_text_add(psplat_text *text, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;
/* Adds the shortest decimal that reads back as the same number, and nothing where it is NaN. */
void psplat_text_number(psplat_text *text, double number);
/* Adds a number for people: three significant digits with thousands apart ("1.23", "12.3",
 * "12,345"), or a dash for NaN. */
void psplat_text_figure(psplat_text *text, double number);
/* Adds raw text to XML: bytes that mean something there become entities, and control characters
 * become question marks. */
void psplat_text_escaped(psplat_text *text, const char *raw);
/* Adds raw text as one word of a shell's command line. */
void psplat_text_quoted(psplat_text *text, const char *raw);
/* Adds raw text between marks, and doubles the marks within it, as a cell of CSV (") and a string
 * of gnuplot (') want it. Control characters become question marks. */
void psplat_text_enclosed(psplat_text *text, const char *raw, char mark);
/* Adds the name of a file without its directory and without what follows its last dot. */
void psplat_text_stem(psplat_text *text, const char *path);
/* Fails with MEMORY where a call has failed. */
psplat_result psplat_text_check(const psplat_text *text, psplat_error *error);

#endif

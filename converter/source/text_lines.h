/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * text_lines.h - line reader: a cursor over the lines, tokens and numbers of a text file.
 */
#ifndef PHONGSPLAT_SOURCE_TEXT_LINES_H
#define PHONGSPLAT_SOURCE_TEXT_LINES_H

#include <phongsplat/splat.h>

#include "source/source_file.h"

/* A cursor over the text of a source, one line at a time. The newline at the end of the current
 * line is replaced by 0. */
typedef struct psplat_lines {
    psplat_source *source;
    char *line;    /* the current line */
    char *cursor;  /* where the next token of it starts */
    char *next;    /* the line after it */
    size_t number; /* of the current line, from 1 */
    char ended_by; /* the byte that 0 replaced */
} psplat_lines;

/* Returns a cursor before the first line. */
psplat_lines psplat_lines_begin(psplat_source *source);

/* Moves to the next line. Returns 0 at the end of the text. */
int psplat_lines_next(psplat_lines *lines);

/* Restores the newline of the current line. Call it before other code reads the text. */
void psplat_lines_end(psplat_lines *lines);

/* Returns the next token of the line and stores its length, or returns NULL at the end of the line.
 * Tokens are separated by blanks and do not end with a 0. */
char *psplat_lines_token(psplat_lines *lines, size_t *length);

/* These read the next token as a finite number within the range of single precision, or as a count.
 * what names it in errors: "path: line 7: the y coordinate ...". Errors: PSPLAT_ERROR_FORMAT,
 * PSPLAT_ERROR_RANGE. */
psplat_result psplat_lines_number(psplat_lines *lines, const char *what, double *value,
                                  psplat_error *error);
psplat_result psplat_lines_count(psplat_lines *lines, const char *what, size_t *value,
                                 psplat_error *error);

/* Fills in *error with "path: line 7: " and the printf-style rest. Returns code. */
psplat_result psplat_lines_fail(const psplat_lines *lines, psplat_error *error, psplat_result code,
                                const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 4, 5)))
#endif
    ;

#endif

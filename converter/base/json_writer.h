/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * json_writer.h - JSON writer (RFC 8259): text that grows in memory, with keys in the order of the
 * calls.
 *
 * The text is indented for people or compact for files, and does not depend on the locale.
 *
 *     psplat_writer json = {0};
 *     psplat_writer_open(&json, NULL, '{');
 *     psplat_writer_count(&json, "splats", 12);
 *     psplat_writer_close(&json, '}');
 *     if (!psplat_writer_finish(&json)) ... out of memory ...
 *     fwrite(json.text, 1, json.size, file);
 *     free(json.text);
 */
#ifndef PHONGSPLAT_BASE_JSON_WRITER_H
#define PHONGSPLAT_BASE_JSON_WRITER_H

#include <stddef.h>

/* Zero-initialise. After a failed allocation all further calls do nothing. */
typedef struct psplat_writer {
    char *text; /* malloc'ed, owned by the caller */
    size_t size, capacity;
    int depth;
    int has_member; /* the innermost object or array has a member already */
    int failed;
    int compact; /* set it before the first call to leave out white space */
} psplat_writer;

/* These begin and end an object ('{', '}') or an array ('[', ']'). In all functions key is NULL
 * inside arrays and at the root. */
void psplat_writer_open(psplat_writer *json, const char *key, char bracket);
void psplat_writer_close(psplat_writer *json, char bracket);
/* Writes a number that is an integer. */
void psplat_writer_count(psplat_writer *json, const char *key, size_t count);
/* These write the shortest decimal that reads back as the same double or, for _float and _floats,
 * as the same float. What is not finite becomes null, since JSON has no number for it. */
void psplat_writer_number(psplat_writer *json, const char *key, double number);
void psplat_writer_numbers(psplat_writer *json, const char *key, const double *numbers,
                           size_t count);
void psplat_writer_float(psplat_writer *json, const char *key, float number);
void psplat_writer_floats(psplat_writer *json, const char *key, const float *numbers, size_t count);
void psplat_writer_boolean(psplat_writer *json, const char *key, int value);
/* Writes a string. Bytes that are not UTF-8, which names of files may hold, become U+FFFD. */
void psplat_writer_string(psplat_writer *json, const char *key, const char *string);
/* Writes a value that is JSON already. */
void psplat_writer_raw(psplat_writer *json, const char *key, const char *value);

/* Ends the text, with a newline unless it is compact. Returns 0 if memory ran out; text is NULL
 * then. */
int psplat_writer_finish(psplat_writer *json);

#endif

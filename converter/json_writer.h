/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * json_writer.h - writing JSON, keys in the order of the calls: indented for people, compact for
 * files. The locale changes nothing.
 *
 *     psplat_writer json = {0};
 *     psplat_writer_open(&json, NULL, '{');
 *     psplat_writer_count(&json, "splats", 12);
 *     psplat_writer_close(&json, '}');
 *     if (!psplat_writer_finish(&json)) ... out of memory ...
 *     fwrite(json.text, 1, json.size, file);
 *     free(json.text);
 */
#ifndef PHONGSPLAT_JSON_WRITER_H
#define PHONGSPLAT_JSON_WRITER_H

#include <stddef.h>

/* Zero-initialised. After a failed allocation further calls do nothing. */
typedef struct psplat_writer {
    char *text; /* from malloc, owned by the caller */
    size_t size, capacity;
    int depth;
    int has_member; /* something precedes in the innermost object or array */
    int failed;
    int compact; /* to be set at first: no white space */
} psplat_writer;

/* key is NULL inside arrays and at the root. Bracket is '{' or '[', '}' or ']'. */
void psplat_writer_open(psplat_writer *json, const char *key, char bracket);
void psplat_writer_close(psplat_writer *json, char bracket);
void psplat_writer_count(psplat_writer *json, const char *key, size_t count);
/* The shortest decimal that reads back as the same number (of the _floats: as the same float); null
 * where not finite, for JSON has no other word for it. */
void psplat_writer_number(psplat_writer *json, const char *key, double number);
void psplat_writer_numbers(psplat_writer *json, const char *key, const double *numbers,
                           size_t count);
void psplat_writer_float(psplat_writer *json, const char *key, float number);
void psplat_writer_floats(psplat_writer *json, const char *key, const float *numbers, size_t count);
void psplat_writer_boolean(psplat_writer *json, const char *key, int value);
/* Bytes that are not UTF-8 become U+FFFD: names of files may hold any. */
void psplat_writer_string(psplat_writer *json, const char *key, const char *string);
/* A value that is JSON already. */
void psplat_writer_raw(psplat_writer *json, const char *key, const char *value);

/* Ends the text, with a newline unless it is compact. Returns 0 where memory ran out; text is then
 * NULL. */
int psplat_writer_finish(psplat_writer *json);

#endif

/* SPDX-License-Identifier: MIT
 * uri.h - the two kinds of URI a glTF buffer may have: base64 data, and a file below base_path. */
#ifndef PHONGSPLAT_URI_H
#define PHONGSPLAT_URI_H

#include "arena.h"

/* Index of the first base64 digit of "data:[type];base64,"; 0: the URI is not of the data scheme,
 * SIZE_MAX: it is, but not base64. */
size_t psplat_uri_data_start(const char *uri, size_t size);

/* Decodes base64 (padding optional) into out, which has room for size / 4 * 3 + 2 bytes. Returns
 * the number of bytes, or SIZE_MAX and in *wrong the index of the digit at fault. */
size_t psplat_uri_decode_base64(const char *digits, size_t size, uint8_t *out, size_t *wrong);

/* base_path/uri with percent escapes decoded, terminated, from the arena. NULL, and what is wrong
 * in *reason, unless the result is a relative path that stays below base_path. */
const char *psplat_uri_path(const char *base_path, const char *uri, size_t size,
                            psplat_arena *arena, const char **reason);

#endif

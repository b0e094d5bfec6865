/* SPDX-License-Identifier: MIT
 *
 * uri.h - the two kinds of URI that a glTF buffer may have: base64 data, and the relative path of a
 * file below base_path; and URIs of a tileset, which are relative to the file that they stand in.
 * URIs are not terminated by a zero.
 */
#ifndef PHONGSPLAT_CORE_URI_H
#define PHONGSPLAT_CORE_URI_H

#include "core/arena.h"

/* Returns the index of the first base64 digit behind "data:[type];base64,". Returns 0 where the URI
 * does not have the data scheme, and SIZE_MAX where it has it but is not base64. */
size_t psplat_uri_data_start(const char *uri, size_t size);

/* Decodes base64 (padding optional) into out, which has room for size / 4 * 3 + 2 bytes. Returns
 * the number of bytes. On an error it returns SIZE_MAX and stores the index of the first wrong
 * digit in *wrong. */
size_t psplat_uri_decode_base64(const char *digits, size_t size, uint8_t *out, size_t *wrong);

/* Returns the path base_path/uri with percent escapes decoded, terminated by a zero; the arena owns
 * it. Returns NULL and stores a constant text in *reason where memory runs out, an escape is
 * broken, or the URI is not a relative path that stays below base_path. */
const char *psplat_uri_path(const char *base_path, const char *uri, size_t size,
                            psplat_arena *arena, const char **reason);

/* Returns the path that a relative URI in the file at path `from` means, with percent escapes
 * decoded and without parts that are "." or ".."; the arena owns it. Paths are relative to the
 * directory of a tileset. Returns NULL and stores a constant text in *reason where an escape is
 * broken or the URI is no relative path of a file in that directory, and NULL in *reason where
 * memory runs out. */
const char *psplat_uri_resolve(const char *from, const char *uri, size_t size, psplat_arena *arena,
                               const char **reason);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * path.c - paths shortened for error messages.
 *
 * psplat_error.text ends after 240 bytes, and the cause of an error comes after the path. A path of
 * any length must leave room for it.
 */
#include "base/path.h"

#include <string.h>

/* Returns whether a byte continues a UTF-8 sequence. */
static int is_continuation(char byte) {
    return ((unsigned char)byte & 0xc0) == 0x80;
}

static void append(char *text, const char *bytes, size_t count) {
    size_t used = strlen(text);
    for (size_t i = 0; i < count; ++i) {
        unsigned char byte = (unsigned char)bytes[i];
        text[used + i] = byte < 0x20 || byte == 0x7f ? '?' : bytes[i];
    }
    text[used + count] = 0;
}

void psplat_path_shorten(const char *path, char shown[PSPLAT_SHOWN_PATH]) {
    static const char gap[] = "...";
    const size_t room = (PSPLAT_SHOWN_PATH - sizeof gap) / 2; /* bytes on each side of the gap */
    size_t length = strlen(path), head = length, tail = 0;
    if (length >= PSPLAT_SHOWN_PATH) {
        for (head = room; head && is_continuation(path[head]);) --head;
        for (tail = room; tail && is_continuation(path[length - tail]);) --tail;
    }
    shown[0] = 0;
    append(shown, path, head);
    if (head == length) return;
    append(shown, gap, sizeof gap - 1);
    append(shown, path + length - tail, tail);
}

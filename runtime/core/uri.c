/* SPDX-License-Identifier: MIT
 *
 * uri.c - data URIs (RFC 2397), base64 (RFC 4648) and relative paths (RFC 3986) with percent
 * escapes.
 */
#include "core/uri.h"

#include <string.h>

static int is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

static int is_digit(char c) {
    return c >= '0' && c <= '9';
}

size_t psplat_uri_data_start(const char *uri, size_t size) {
    static const char scheme[] = "data:", encoding[] = ";base64";
    const size_t length = sizeof encoding - 1;
    if (size < 5 || memcmp(uri, scheme, 5)) return 0;
    const char *comma = memchr(uri, ',', size);
    if (!comma || (size_t)(comma - uri) < 5 + length || memcmp(comma - length, encoding, length))
        return SIZE_MAX;
    return (size_t)(comma - uri) + 1;
}

/* Returns 0 ... 63, or -1 where c is not a base64 digit. */
static int base64_value(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (is_digit(c)) return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

size_t psplat_uri_decode_base64(const char *digits, size_t size, uint8_t *out, size_t *wrong) {
    uint8_t *start = out;
    uint32_t bits = 0;
    while (size && size % 4 == 0 && digits[size - 1] == '=' && digits[size - 2] == '=') size -= 2;
    if (size && size % 4 == 0 && digits[size - 1] == '=') --size;
    for (size_t i = 0; i < size; ++i) {
        int value = base64_value(digits[i]);
        if (value < 0 || (i == size - 1 && i % 4 == 0)) {
            *wrong = i;
            return SIZE_MAX;
        }
        bits = bits << 6 | (uint32_t)value;
        /* The second, third and fourth digit of each group complete a byte. */
        if (i % 4) *out++ = (uint8_t)(bits >> (6 - 2 * (i % 4)));
    }
    return (size_t)(out - start);
}

/* Returns 0 ... 15, or -1 where c is not a hexadecimal digit. */
static int hex_value(char c) {
    if (is_digit(c)) return c - '0';
    char lower = (char)(c | 0x20);
    return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

/* Decodes percent escapes into out and terminates it. Returns 0 on a broken escape or a zero byte.
 */
static int decode_percent(const char *uri, size_t size, char *out) {
    for (size_t i = 0; i < size; ++i) {
        char c = uri[i];
        if (c == '%') {
            int high = size - i > 2 ? hex_value(uri[i + 1]) : -1;
            int low = size - i > 2 ? hex_value(uri[i + 2]) : -1;
            if (high < 0 || low < 0) return 0;
            c = (char)(16 * high + low);
            i += 2;
        }
        if (!c) return 0;
        *out++ = c;
    }
    *out = 0;
    return 1;
}

static int has_scheme(const char *path) {
    if (!is_letter(*path)) return 0;
    while (is_letter(*path) || is_digit(*path) || (*path && strchr("+-.", *path))) ++path;
    return *path == ':';
}

static int has_parent_segment(const char *path) {
    for (;;) {
        size_t length = strcspn(path, "/");
        if (length == 2 && path[0] == '.' && path[1] == '.') return 1;
        if (!path[length]) return 0;
        path += length + 1;
    }
}

/* Returns why a path is not relative, or NULL where it is. */
static const char *refuse_absolute(const char *path) {
    if (!*path) return "it is empty";
    if (has_scheme(path)) return "its scheme is not data";
    if (*path == '/') return "it is absolute";
    /* Windows treats backslashes as slashes, so they could get around the checks of parts. */
    if (strchr(path, '\\')) return "it holds a backslash";
    return NULL;
}

/* Returns why a path is not allowed, or NULL where it is. */
static const char *refuse_path(const char *path) {
    const char *reason = refuse_absolute(path);
    if (reason) return reason;
    return has_parent_segment(path) ? "it leaves its directory" : NULL;
}

const char *psplat_uri_path(const char *base_path, const char *uri, size_t size,
                            psplat_arena *arena, const char **reason) {
    size_t base = strlen(base_path);
    char *path = size < SIZE_MAX - base - 2 ? psplat_arena_take(arena, base + size + 2, 1) : NULL;
    *reason = "no memory for it";
    if (!path) return NULL;
    memcpy(path, base_path, base);
    if (base && base_path[base - 1] != '/') path[base++] = '/';
    *reason = "its percent escapes are broken";
    if (!decode_percent(uri, size, path + base)) return NULL;
    *reason = refuse_path(path + base);
    return *reason ? NULL : path;
}

/* Appends the parts of a relative path to out, which holds length bytes of parts that end with
 * slashes, and terminates it. Returns why it is not allowed, or NULL where it is. */
static const char *append_parts(const char *path, char *out, size_t length) {
    for (;;) {
        size_t part = strcspn(path, "/");
        int is_last = !path[part], is_dot = part == 1 && path[0] == '.';
        if (part == 2 && path[0] == '.' && path[1] == '.') {
            if (!length) return "it leaves its directory";
            for (--length; length && out[length - 1] != '/';) --length;
            is_dot = 1;
        } else if (part && !is_dot) {
            memcpy(out + length, path, part);
            length += part;
            if (!is_last) out[length++] = '/';
        }
        if (is_last && (!part || is_dot)) return "it names a directory";
        if (is_last) break;
        path += part + 1;
    }
    out[length] = 0;
    return NULL;
}

const char *psplat_uri_resolve(const char *from, const char *uri, size_t size, psplat_arena *arena,
                               const char **reason) {
    const char *slash = strrchr(from, '/');
    size_t base = slash ? (size_t)(slash - from) + 1 : 0;
    int fits = size < (SIZE_MAX - base - 2) / 2;
    char *relative = fits ? psplat_arena_take(arena, size + 1, 1) : NULL;
    char *path = relative ? psplat_arena_take(arena, base + size + 1, 1) : NULL;
    *reason = NULL;
    if (!path) return NULL;
    *reason = "it has a query or a fragment";
    if (memchr(uri, '?', size) || memchr(uri, '#', size)) return NULL;
    *reason = "its percent escapes are broken";
    if (!decode_percent(uri, size, relative)) return NULL;
    *reason = has_scheme(relative) ? "it has a scheme" : refuse_absolute(relative);
    if (*reason) return NULL;
    memcpy(path, from, base);
    *reason = append_parts(relative, path, base);
    return *reason ? NULL : path;
}

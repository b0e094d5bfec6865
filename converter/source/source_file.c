/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * source_file.c - loading a source file and recognising its format by content.
 */
#include "source/source_file.h"

#include "base/file_bytes.h"
#include "base/path.h"
#include "source/obj_faces.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

/* The sizes of binary STL in bytes: the header with the triangle count, and a triangle. */
#define STL_HEADER 84
#define STL_TRIANGLE 50

static const char *skip_blanks(const char *text) {
    while (*text && isspace((unsigned char)*text)) ++text;
    return text;
}

static int starts_with(const char *text, const char *word) {
    return strncmp(text, word, strlen(word)) == 0;
}

static int starts_with_any_case(const char *text, const char *word) {
    while (*word && tolower((unsigned char)*text) == *word) ++text, ++word;
    return !*word;
}

/* Returns whether the first word is [ST][C][N][4][n]OFF, as geomview defines it. */
static int is_off(const char *text) {
    if (starts_with(text, "ST")) text += 2;
    text += *text == 'C';
    text += *text == 'N';
    text += *text == '4';
    text += *text == 'n';
    return starts_with(text, "OFF") && !isalnum((unsigned char)text[3]);
}

static int is_binary_stl(const psplat_source *source) {
    if (source->size < STL_HEADER) return 0;
    const unsigned char *count = (const unsigned char *)source->data + STL_HEADER - 4;
    uint64_t triangles = (uint64_t)count[0] | (uint64_t)count[1] << 8 | (uint64_t)count[2] << 16 |
                         (uint64_t)count[3] << 24;
    return source->size == STL_HEADER + STL_TRIANGLE * triangles;
}

/* Returns whether the first line that is neither empty nor a comment is a statement of OBJ, which
 * has no magic number. */
static int is_obj(const char *text) {
    static const char *const statements[] = {"v ", "v\t", "vn ",     "vt ",     "o ",
                                             "g ", "f ",  "mtllib ", "usemtl ", "s "};
    text = skip_blanks(text);
    while (*text == '#') {
        text += strcspn(text, "\n");
        text = skip_blanks(text);
    }
    for (size_t i = 0; i < sizeof statements / sizeof *statements; ++i)
        if (starts_with(text, statements[i])) return 1;
    return 0;
}

/* Returns text after blank lines and comments, as XYZ files have them. */
static const char *skip_comments(const char *text) {
    text = skip_blanks(text);
    while (*text == '#' || starts_with(text, "//")) {
        text += strcspn(text, "\n");
        text = skip_blanks(text);
    }
    return text;
}

/* Counts the numbers in a line and moves *text to its end. Returns 0 if the line holds anything
 * else. */
static size_t count_numbers(const char **text) {
    size_t numbers = 0;
    while (**text && **text != '\n' && **text != '#') {
        char *end;
        strtod(*text, &end);
        if (end == *text) return 0;
        *text = end + strspn(end, " \t\r,;");
        ++numbers;
    }
    return numbers;
}

/* Returns whether the first line that is neither empty nor a comment, or the one after the number
 * of points, holds numbers alone. XYZ has no magic number either. */
static int is_xyz(const char *text) {
    text = skip_comments(text);
    size_t numbers = count_numbers(&text);
    if (numbers == 1) {
        text = skip_comments(text);
        numbers = count_numbers(&text);
    }
    return numbers >= 3;
}

static psplat_source_format format_of_content(const psplat_source *source) {
    const char *text = source->data;
    if (starts_with(text, "glTF")) return PSPLAT_SOURCE_GLB;
    if (starts_with(text, "\xef\xbb\xbf")) text += 3;
    if (*skip_blanks(text) == '{') return PSPLAT_SOURCE_GLTF;
    if ((starts_with(text, "ply") || starts_with(text, "PLY")) && isspace((unsigned char)text[3]))
        return PSPLAT_SOURCE_PLY;
    if (is_off(text)) return PSPLAT_SOURCE_OFF;
    /* This test comes before "solid", since some binary files begin with that word, too. */
    if (is_binary_stl(source)) return PSPLAT_SOURCE_STL_BINARY;
    if (starts_with_any_case(skip_blanks(text), "solid")) return PSPLAT_SOURCE_STL_TEXT;
    if (is_obj(text)) return PSPLAT_SOURCE_OBJ;
    if (is_xyz(text)) return PSPLAT_SOURCE_XYZ;
    return PSPLAT_SOURCE_UNKNOWN;
}

static int has_extension(const char *path, const char *extension) {
    size_t length = strlen(path);
    size_t wanted = strlen(extension);
    if (length < wanted) return 0;
    for (size_t i = 0; i < wanted; ++i)
        if (tolower((unsigned char)path[length - wanted + i]) != extension[i]) return 0;
    return 1;
}

/* Recognises the format by content or, for formats without a magic number, by extension. Other
 * extensions only give a better error. */
static psplat_result recognise(psplat_source *source, psplat_error *error) {
    static const char *const magics[][2] = {
        {".ply", "ply"}, {".off", "OFF"}, {".glb", "glTF"}, {".gltf", "{"}};
    source->format = format_of_content(source);
    if (source->format) return PSPLAT_OK;
    if (has_extension(source->file, ".obj")) source->format = PSPLAT_SOURCE_OBJ;
    if (has_extension(source->file, ".stl")) source->format = PSPLAT_SOURCE_STL_BINARY;
    if (has_extension(source->file, ".xyz") || has_extension(source->file, ".pts") ||
        has_extension(source->file, ".asc"))
        source->format = PSPLAT_SOURCE_XYZ;
    if (source->format) return PSPLAT_OK;
    for (size_t i = 0; i < sizeof magics / sizeof *magics; ++i)
        if (has_extension(source->file, magics[i][0]))
            return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0,
                               "%s: byte 0: does not begin with '%s'", source->path, magics[i][1]);
    return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 0,
                       "%s: not a mesh this program reads (OBJ, PLY, OFF, STL, glTF, GLB, XYZ)",
                       source->path);
}

psplat_result psplat_source_load(const char *path, psplat_source *source, psplat_error *error) {
    *source = (psplat_source){.file = path};
    psplat_path_shorten(path, source->path);
    psplat_result result = psplat_file_read(path, &source->data, &source->size, error);
    if (result) return result;
    if (source->size == 0)
        result = psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "%s: the file is empty", source->path);
    if (!result) result = recognise(source, error);
    source->is_point_set = source->format == PSPLAT_SOURCE_XYZ;
    if (result) psplat_source_free(source);
    return result;
}

void psplat_source_free(psplat_source *source) {
    if (!source) return;
    free(source->data);
    free(source->positions);
    psplat_obj_faces_free(&source->obj);
    source->data = NULL;
    source->positions = NULL;
    source->size = 0;
}

int psplat_source_is_gltf(const psplat_source *source) {
    return source->format == PSPLAT_SOURCE_GLTF || source->format == PSPLAT_SOURCE_GLB;
}

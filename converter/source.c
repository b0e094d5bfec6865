/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * source.c - which format the content of a file is.
 */
#include "source.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

/* Binary STL: 80 bytes of header, the number of triangles, 50 bytes a triangle. */
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

/* [ST][C][N][4][n]OFF, as geomview defines the first word. */
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

/* OBJ has no magic: its first line that is neither empty nor a comment must be a statement. */
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

/* Moves over blank lines and comments of points as text. */
static const char *skip_comments(const char *text) {
    text = skip_blanks(text);
    while (*text == '#' || starts_with(text, "//")) {
        text += strcspn(text, "\n");
        text = skip_blanks(text);
    }
    return text;
}

/* Numbers in the line, moving text to its end; 0 where it holds something else. */
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

/* Points as text have no magic either: their first line that is neither empty nor a comment, or the
 * one after the number of points, holds numbers alone. */
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
    /* Before "solid": some binary files begin with that word. */
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

/* Of the extensions only these help where the content does not speak: the others have a magic. */
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
    psplat_result result = psplat_source_read_file(path, &source->data, &source->size, error);
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

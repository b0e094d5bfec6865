/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mtl.c - the material library of an OBJ, as a glTF material would say it:
 *
 *     Kd          base colour, meant for the screen (sRGB)   map_Kd    its texture, which it
 * multiplies Ke          emissive, sRGB                             map_Ke    its texture d, 1 - Tr
 * alpha; splats are opaque Ns          Phong's exponent: roughness^4 = 2 / (Ns + 2) (Walter et al.
 * 2007 section 5.2 of the widths of Phong's and Trowbridge-Reitz' distributions) Pr, Pm roughness,
 * metallic                        norm      normal map
 *
 * -s, -o and -clamp of textures are followed. What else a library says (ambient, specular colours,
 * bumps) is left out: people write it seldom as they mean it.
 */
#include "texture.h"

#include "source.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A library is text for people. */
enum { MOST_IMAGES = 1024, PATH_SIZE = 4096 };

typedef struct library {
    const psplat_source *obj;
    psplat_source text;
    psplat_lines lines;
    char directory[PATH_SIZE]; /* with a slash behind it, or empty */
    psplat_palette *palette;
    char **files;                /* of the palette's images */
    psplat_appearance *current;  /* NULL: a material that nothing uses */
    const psplat_material *base; /* what a material is where the library says nothing */
    psplat_result result;
} library;

/* ---- words and numbers
 * --------------------------------------------------------------------------------- */

static int is_word(const char *token, size_t length, const char *word) {
    return strlen(word) == length && memcmp(token, word, length) == 0;
}

/* The next number of the line; 0 where there is none. */
static int number(library *l, double *value) {
    size_t length;
    char *end, *token = psplat_lines_token(&l->lines, &length);
    if (!token) return 0;
    double read = strtod(token, &end);
    if (end != token + length || !isfinite(read)) return 0;
    *value = read;
    return 1;
}

/* What is left of the line, without blanks about it. */
static void rest_of_line(const library *l, char name[PATH_SIZE]) {
    static const char blanks[] = " \t\r\v\f";
    snprintf(name, PATH_SIZE, "%s", l->lines.cursor + strspn(l->lines.cursor, blanks));
    for (size_t n = strlen(name); n && strchr(blanks, name[n - 1]); --n) name[n - 1] = 0;
}

static float unit(double value) {
    return (float)fmin(fmax(value, 0), 1);
}

static void read_color(library *l, float *color) {
    double rgb[3];
    if (!number(l, &rgb[0])) return;
    rgb[1] = rgb[2] = rgb[0]; /* one number is a grey */
    if (number(l, &rgb[1])) number(l, &rgb[2]);
    for (int k = 0; k < 3; ++k) color[k] = psplat_linear_of_srgb(unit(rgb[k]));
}

static void read_alpha(library *l, int inverted) {
    double value;
    if (!number(l, &value)) return;
    float alpha = unit(inverted ? 1 - value : value);
    l->current->material.base_color[3] = alpha;
    l->current->is_blended = alpha < 1;
}

static void read_unit(library *l, float *out) {
    double value;
    if (number(l, &value)) *out = unit(value);
}

static void read_exponent(library *l, float *roughness) {
    double value;
    if (number(l, &value)) *roughness = unit(pow(2 / (fmax(value, 0) + 2), 0.25));
}

/* ---- textures -------------------------------------------------------------------------------- */

static char *copy_text(const char *text) {
    char *copy = malloc(strlen(text) + 1);
    if (copy) strcpy(copy, text);
    return copy;
}

/* Where a file beside the library is, or 0: it would leave the directory, or its name is too long.
 */
static int locate(const char *directory, const char *name, char path[PATH_SIZE]) {
    int length = snprintf(path, PATH_SIZE, "/%s/", name);
    if (length <= 2 || length >= PATH_SIZE || name[0] == '/') return 0;
    if (strstr(path, "/../") || strchr(name, ':')) return 0;
    length = snprintf(path, PATH_SIZE, "%s%s", directory, name);
    return length < PATH_SIZE;
}

/* Why a file is not read, for one warning. */
static void complain(char **problem, const char *name, const char *cause) {
    char shown[PSPLAT_SHOWN_PATH], text[400];
    psplat_path_shorten(name, shown);
    snprintf(text, sizeof text, "'%s': %s", shown, cause);
    *problem = copy_text(text);
}

static void load_image(library *l, const char *name, psplat_image *image) {
    char path[PATH_SIZE], *data = NULL;
    size_t size;
    psplat_error error;
    if (!locate(l->directory, name, path)) {
        complain(&image->problem, name, "a texture has to lie beside its library");
        return;
    }
    psplat_result result = psplat_source_read_file(path, &data, &size, &error);
    if (!result) result = psplat_image_decode(data, size, image, &error);
    free(data);
    if (result == PSPLAT_ERROR_MEMORY) l->result = result;
    if (result) complain(&image->problem, name, error.text);
}

static const psplat_image *image_of(library *l, const char *name) {
    psplat_palette *palette = l->palette;
    for (size_t i = 0; i < palette->image_count; ++i)
        if (!strcmp(l->files[i], name)) return &palette->images[i];
    if (palette->image_count == MOST_IMAGES) return NULL;
    char *copy = copy_text(name);
    if (!copy) {
        l->result = PSPLAT_ERROR_MEMORY;
        return NULL;
    }
    psplat_image *image = &palette->images[palette->image_count];
    l->files[palette->image_count++] = copy;
    load_image(l, name, image);
    return image;
}

/* What a texture's options say before its file's name. */
typedef struct options {
    double scale[3], offset[3], turbulence[3];
    int clamps;
} options;

/* One to three numbers. */
static void read_place(library *l, double place[3]) {
    for (int k = 0; k < 3; ++k) {
        char *rest = l->lines.cursor;
        if (number(l, &place[k])) continue;
        l->lines.cursor = rest;
        return;
    }
}

static void read_option(library *l, char *name, size_t length, options *o) {
    size_t word_length;
    if (is_word(name, length, "-s")) {
        read_place(l, o->scale);
    } else if (is_word(name, length, "-o")) {
        read_place(l, o->offset);
    } else if (is_word(name, length, "-t")) {
        read_place(l, o->turbulence);
    } else { /* all others have one argument, but one */
        char *word = psplat_lines_token(&l->lines, &word_length);
        if (is_word(name, length, "-clamp")) o->clamps = word && is_word(word, word_length, "on");
        if (is_word(name, length, "-mm")) psplat_lines_token(&l->lines, &word_length);
    }
}

static options read_options(library *l) {
    options o = {.scale = {1, 1, 1}};
    for (;;) {
        char *rest = l->lines.cursor;
        size_t length;
        char *token = psplat_lines_token(&l->lines, &length);
        if (!token || token[0] != '-') {
            l->lines.cursor = rest;
            return o;
        }
        read_option(l, token, length, &o);
    }
}

/* The same as a path. */
static void path_of_line(const library *l, char name[PATH_SIZE]) {
    rest_of_line(l, name);
    for (char *c = name; (c = strchr(c, '\\')) != NULL;) *c = '/';
    while (!strncmp(name, "./", 2)) memmove(name, name + 2, strlen(name + 2) + 1);
}

static void read_texture(library *l, psplat_texture *texture) {
    char name[PATH_SIZE];
    options o = read_options(l);
    path_of_line(l, name);
    *texture = (psplat_texture){.strength = 1};
    if (!name[0]) return;
    texture->image = image_of(l, name);
    if (o.clamps) texture->wrap[0] = texture->wrap[1] = PSPLAT_WRAP_CLAMP;
    /* Scale and offset are of v that runs upwards: 1 - t. */
    const double rows[6] = {o.scale[0], 0,          o.offset[0],
                            0,          o.scale[1], 1 - o.scale[1] - o.offset[1]};
    memcpy(texture->transform, rows, sizeof rows);
}

/* ---- statements ------------------------------------------------------------------------------ */

static void begin_material(library *l) {
    char name[PATH_SIZE];
    rest_of_line(l, name);
    l->current = NULL;
    for (size_t i = 0; i < l->obj->obj.name_count; ++i)
        if (!strcmp(l->obj->obj.names[i], name)) l->current = &l->palette->appearances[i];
    if (!l->current) return;
    l->current->material = *l->base;
    for (int k = 0; k < 3; ++k) l->current->material.base_color[k] = 1;
}

static void read_line(library *l) {
    size_t length;
    char *word = psplat_lines_token(&l->lines, &length);
    if (!word || word[0] == '#') return;
    if (is_word(word, length, "newmtl")) begin_material(l);
    psplat_appearance *a = l->current;
    if (!a) return;
    if (is_word(word, length, "Kd")) read_color(l, a->material.base_color);
    if (is_word(word, length, "Ke")) read_color(l, a->material.emissive);
    if (is_word(word, length, "d")) read_alpha(l, 0);
    if (is_word(word, length, "Tr")) read_alpha(l, 1);
    if (is_word(word, length, "Ns")) read_exponent(l, &a->material.roughness);
    if (is_word(word, length, "Pr")) read_unit(l, &a->material.roughness);
    if (is_word(word, length, "Pm")) read_unit(l, &a->material.metallic);
    if (is_word(word, length, "map_Kd")) read_texture(l, &a->base_color);
    if (is_word(word, length, "map_Ke")) {
        read_texture(l, &a->emissive);
        for (int k = 0; k < 3; ++k) /* a map alone shines as it is */
            if (!(a->material.emissive[k] > 0)) a->material.emissive[k] = 1;
    }
    if (is_word(word, length, "norm")) read_texture(l, &a->normal);
}

static void read_library(library *l) {
    char path[PATH_SIZE];
    const psplat_source *obj = l->obj;
    psplat_error error;
    const char *slash = strrchr(obj->file, '/');
    size_t length = slash ? (size_t)(slash - obj->file) + 1 : 0;
    if (length >= PATH_SIZE) return;
    memcpy(l->directory, obj->file, length);
    for (char *c = obj->obj.library; (c = strchr(c, '\\')) != NULL;) *c = '/';
    if (!locate(l->directory, obj->obj.library, path)) {
        complain(&l->palette->problem, obj->obj.library, "a library has to lie beside its OBJ");
        return;
    }
    l->result = psplat_source_read_file(path, &l->text.data, &l->text.size, &error);
    if (l->result) {
        if (l->result != PSPLAT_ERROR_MEMORY) l->result = PSPLAT_OK;
        complain(&l->palette->problem, obj->obj.library, error.text);
        return;
    }
    slash = strrchr(path, '/'); /* textures lie beside the library */
    l->directory[slash ? (size_t)(slash - path) + 1 : 0] = 0;
    if (slash) memcpy(l->directory, path, (size_t)(slash - path) + 1);
    l->lines = psplat_lines_begin(&l->text);
    while (!l->result && psplat_lines_next(&l->lines)) read_line(l);
}

psplat_result psplat_mtl_read(const psplat_source *source, const psplat_material *base,
                              psplat_palette *palette, psplat_error *error) {
    library l = {.obj = source, .palette = palette, .base = base};
    size_t count = source->obj.name_count;
    palette->appearances = calloc(count + 1, sizeof *palette->appearances);
    palette->images = calloc(MOST_IMAGES, sizeof *palette->images);
    l.files = calloc(MOST_IMAGES, sizeof *l.files);
    if (palette->appearances && palette->images && l.files) {
        palette->appearance_count = count + 1;
        for (size_t i = 0; i <= count; ++i) {
            palette->appearances[i].material = *base;
            if (i < count) palette->appearances[i].name = copy_text(source->obj.names[i]);
        }
        read_library(&l);
    } else {
        l.result = PSPLAT_ERROR_MEMORY;
    }
    for (size_t i = 0; i < palette->image_count; ++i) free(l.files[i]);
    free(l.files);
    psplat_source_free(&l.text);
    if (!l.result) return PSPLAT_OK;
    return psplat_fail(error, l.result, 0, "%s: out of memory for its materials", source->path);
}

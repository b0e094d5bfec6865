/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mtl.c - the reader of MTL files, the material libraries of OBJ files. A material becomes the glTF
 * material that is nearest to it:
 *
 *     Kd         base colour, sRGB
 *     map_Kd     texture of the base colour, multiplied by Kd
 *     Ke         emission, sRGB
 *     map_Ke     texture of the emission
 *     d          alpha; splats are drawn opaque
 *     Tr         1 - alpha, in materials without d, but see settle_alphas
 *     Ns         Phong's exponent: roughness^4 = 2 / (Ns + 2), where the widths of Phong's and
 *                Trowbridge and Reitz' distributions are equal (Walter et al. 2007 section 5.2)
 *     Pr, Pm     roughness, metalness
 *     norm       normal map
 *
 * The options -s, -o and -clamp of textures are read. Ambient and specular colours and bump maps
 * are ignored, since most files have values there that nobody chose.
 */
#include "import/mtl.h"

#include "base/file_bytes.h"
#include "base/path.h"
#include "material/image.h"
#include "material/mipmap.h"
#include "material/source_materials.h"
#include "source/source_file.h"
#include "source/text_lines.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_IMAGES = 1024, PATH_SIZE = 4096 }; /* further images are ignored */

/* What a material says about its alpha; negative where it says nothing. */
typedef struct alpha {
    float dissolve, transparency; /* d and Tr */
} alpha;

typedef struct library {
    const psplat_source *obj;
    psplat_source text;
    psplat_lines lines;
    char directory[PATH_SIZE]; /* ends with a slash, or is empty */
    psplat_source_materials *materials;
    char **files;                    /* names of the materials' images */
    psplat_source_material *current; /* NULL in a material that no face uses */
    alpha *alphas;                   /* by material */
    int means_transparent;           /* some Tr is not 1, so that Tr 1 is meant */
    const psplat_material *base;     /* values that the library does not set */
    psplat_result result;
} library;

/* ---- words and numbers ----------------------------------------------------------------------- */

static int is_word(const char *token, size_t length, const char *word) {
    return strlen(word) == length && memcmp(token, word, length) == 0;
}

/* Reads the next number of the line; returns 0 where there is none. */
static int number(library *l, double *value) {
    size_t length;
    char *end, *token = psplat_lines_token(&l->lines, &length);
    if (!token) return 0;
    double read = strtod(token, &end);
    if (end != token + length || !isfinite(read)) return 0;
    *value = read;
    return 1;
}

/* Copies the rest of the line without blanks at its ends. */
static void rest_of_line(const library *l, char name[PATH_SIZE]) {
    static const char blanks[] = " \t\r\v\f";
    snprintf(name, PATH_SIZE, "%s", l->lines.cursor + strspn(l->lines.cursor, blanks));
    for (size_t n = strlen(name); n && strchr(blanks, name[n - 1]); --n) name[n - 1] = 0;
}

static float clamp_unit(double value) {
    return (float)fmin(fmax(value, 0), 1);
}

static void read_color(library *l, float *color) {
    double rgb[3];
    if (!number(l, &rgb[0])) return;
    rgb[1] = rgb[2] = rgb[0]; /* one number is a grey */
    if (number(l, &rgb[1])) number(l, &rgb[2]);
    for (int k = 0; k < 3; ++k) color[k] = psplat_linear_of_srgb(clamp_unit(rgb[k]));
}

static alpha *current_alpha(const library *l) {
    return &l->alphas[l->current - l->materials->source_materials];
}

/* Reads Tr, also of materials that no face uses: it tells what the others mean. */
static void read_transparency(library *l) {
    double value;
    if (!number(l, &value)) return;
    l->means_transparent |= clamp_unit(value) < 1;
    if (l->current) current_alpha(l)->transparency = clamp_unit(value);
}

/* Some programs, old MeshLab for one, write Tr 1 for what is opaque. So d decides where a material
 * has both, and a library in which every Tr is 1 has nothing transparent. */
static void settle_alphas(library *l) {
    for (size_t i = 0; i < l->materials->source_material_count; ++i) {
        psplat_source_material *material = &l->materials->source_materials[i];
        alpha a = l->alphas[i];
        if (a.dissolve < 0 && a.transparency >= 0 && l->means_transparent)
            a.dissolve = 1 - a.transparency;
        if (a.dissolve < 0) continue;
        material->material.base_color[3] = a.dissolve;
        material->is_blended = a.dissolve < 1;
    }
}

static void read_factor(library *l, float *out) {
    double value;
    if (number(l, &value)) *out = clamp_unit(value);
}

static void read_exponent(library *l, float *roughness) {
    double value;
    if (number(l, &value)) *roughness = clamp_unit(pow(2 / (fmax(value, 0) + 2), 0.25));
}

/* ---- textures -------------------------------------------------------------------------------- */

static char *copy_text(const char *text) {
    char *copy = malloc(strlen(text) + 1);
    if (copy) strcpy(copy, text);
    return copy;
}

/* Stores the path of a file in the directory. Returns 0 where the name would leave the directory or
 * is too long. */
static int path_beside(const char *directory, const char *name, char path[PATH_SIZE]) {
    int length = snprintf(path, PATH_SIZE, "/%s/", name);
    if (length <= 2 || length >= PATH_SIZE || name[0] == '/') return 0;
    if (strstr(path, "/../") || strchr(name, ':')) return 0;
    length = snprintf(path, PATH_SIZE, "%s%s", directory, name);
    return length < PATH_SIZE;
}

/* Stores why a file is not read, which becomes a warning. */
static void set_problem(char **problem, const char *name, const char *cause) {
    char shown[PSPLAT_SHOWN_PATH], text[400];
    psplat_path_shorten(name, shown);
    snprintf(text, sizeof text, "'%s': %s", shown, cause);
    *problem = copy_text(text);
}

static void load_image(library *l, const char *name, psplat_image *image) {
    char path[PATH_SIZE], *data = NULL;
    size_t size;
    psplat_error error;
    if (!path_beside(l->directory, name, path)) {
        set_problem(&image->problem, name, "a texture has to lie beside its library");
        return;
    }
    psplat_result result = psplat_file_read(path, &data, &size, &error);
    if (!result) result = psplat_image_read(data, size, image, &error);
    free(data);
    if (!result) image->name = copy_text(name);
    if (result == PSPLAT_ERROR_MEMORY) l->result = result;
    if (result) set_problem(&image->problem, name, error.text);
}

static const psplat_image *image_of(library *l, const char *name) {
    psplat_source_materials *materials = l->materials;
    for (size_t i = 0; i < materials->image_count; ++i)
        if (!strcmp(l->files[i], name)) return &materials->images[i];
    if (materials->image_count == MAX_IMAGES) return NULL;
    char *copy = copy_text(name);
    if (!copy) {
        l->result = PSPLAT_ERROR_MEMORY;
        return NULL;
    }
    psplat_image *image = &materials->images[materials->image_count];
    l->files[materials->image_count++] = copy;
    load_image(l, name, image);
    return image;
}

/* The options that precede the file name of a texture. */
typedef struct options {
    double scale[3], offset[3], turbulence[3];
    int clamps;
} options;

/* Reads one to three numbers. */
static void read_vector(library *l, double vector[3]) {
    for (int k = 0; k < 3; ++k) {
        char *rest = l->lines.cursor;
        if (number(l, &vector[k])) continue;
        l->lines.cursor = rest;
        return;
    }
}

static void read_option(library *l, char *name, size_t length, options *o) {
    size_t word_length;
    if (is_word(name, length, "-s")) {
        read_vector(l, o->scale);
    } else if (is_word(name, length, "-o")) {
        read_vector(l, o->offset);
    } else if (is_word(name, length, "-t")) {
        read_vector(l, o->turbulence);
    } else { /* all others have one argument, except -mm, which has two */
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

/* Copies the rest of the line as a path with slashes and without a leading "./". */
static void path_of_line(const library *l, char name[PATH_SIZE]) {
    rest_of_line(l, name);
    for (char *c = name; (c = strchr(c, '\\')) != NULL;) *c = '/';
    while (!strncmp(name, "./", 2)) memmove(name, name + 2, strlen(name + 2) + 1);
}

static void read_texture(library *l, psplat_texture_info *texture) {
    char name[PATH_SIZE];
    options o = read_options(l);
    path_of_line(l, name);
    *texture = (psplat_texture_info){.strength = 1};
    if (!name[0]) return;
    texture->image = image_of(l, name);
    if (o.clamps) texture->wrap[0] = texture->wrap[1] = PSPLAT_WRAP_CLAMP;
    /* Scale and offset apply to v = 1 - t, which runs upwards. */
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
        if (!strcmp(l->obj->obj.names[i], name)) l->current = &l->materials->source_materials[i];
    if (!l->current) return;
    l->current->material = *l->base;
    for (int k = 0; k < 3; ++k) l->current->material.base_color[k] = 1;
    *current_alpha(l) = (alpha){-1, -1};
}

static void read_line(library *l) {
    size_t length;
    char *word = psplat_lines_token(&l->lines, &length);
    if (!word || word[0] == '#') return;
    if (is_word(word, length, "newmtl")) begin_material(l);
    if (is_word(word, length, "Tr")) read_transparency(l);
    psplat_source_material *a = l->current;
    if (!a) return;
    if (is_word(word, length, "Kd")) read_color(l, a->material.base_color);
    if (is_word(word, length, "Ke")) read_color(l, a->material.emissive);
    if (is_word(word, length, "d")) read_factor(l, &current_alpha(l)->dissolve);
    if (is_word(word, length, "Ns")) read_exponent(l, &a->material.roughness);
    if (is_word(word, length, "Pr")) read_factor(l, &a->material.roughness);
    if (is_word(word, length, "Pm")) read_factor(l, &a->material.metallic);
    if (is_word(word, length, "map_Kd")) read_texture(l, &a->base_color);
    if (is_word(word, length, "map_Ke")) {
        read_texture(l, &a->emissive);
        for (int k = 0; k < 3; ++k) /* a texture without Ke is not dimmed */
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
    if (!path_beside(l->directory, obj->obj.library, path)) {
        set_problem(&l->materials->problem, obj->obj.library,
                    "a library has to lie beside its OBJ");
        return;
    }
    l->result = psplat_file_read(path, &l->text.data, &l->text.size, &error);
    if (l->result) {
        if (l->result != PSPLAT_ERROR_MEMORY) l->result = PSPLAT_OK;
        set_problem(&l->materials->problem, obj->obj.library, error.text);
        return;
    }
    slash = strrchr(path, '/'); /* textures lie beside the library */
    l->directory[slash ? (size_t)(slash - path) + 1 : 0] = 0;
    if (slash) memcpy(l->directory, path, (size_t)(slash - path) + 1);
    l->lines = psplat_lines_begin(&l->text);
    while (!l->result && psplat_lines_next(&l->lines)) read_line(l);
    settle_alphas(l);
}

psplat_result psplat_mtl_read(const psplat_source *source, const psplat_material *base,
                              psplat_source_materials *materials, psplat_error *error) {
    library l = {.obj = source, .materials = materials, .base = base};
    size_t count = source->obj.name_count;
    materials->source_materials = calloc(count + 1, sizeof *materials->source_materials);
    materials->images = calloc(MAX_IMAGES, sizeof *materials->images);
    l.files = calloc(MAX_IMAGES, sizeof *l.files);
    l.alphas = calloc(count + 1, sizeof *l.alphas);
    if (materials->source_materials && materials->images && l.files && l.alphas) {
        materials->source_material_count = count + 1;
        for (size_t i = 0; i <= count; ++i) {
            materials->source_materials[i].material = *base;
            l.alphas[i] = (alpha){-1, -1};
            if (i < count) materials->source_materials[i].name = copy_text(source->obj.names[i]);
        }
        read_library(&l);
        psplat_source_materials_describe_textures(materials);
    } else {
        l.result = PSPLAT_ERROR_MEMORY;
    }
    for (size_t i = 0; i < materials->image_count; ++i) free(l.files[i]);
    free(l.files);
    free(l.alphas);
    psplat_source_free(&l.text);
    if (!l.result) return PSPLAT_OK;
    return psplat_fail(error, l.result, 0, "%s: out of memory for its materials", source->path);
}

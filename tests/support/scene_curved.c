/* SPDX-License-Identifier: MIT
 *
 * scene_curved.c - files of curved splats and of textured ones; see scene_curved.h.
 *
 * Splats of one number of clip lines and one kind are a primitive. Its rows are a buffer view of
 * their own, in which the attributes lie one after another. Images follow, one in each view.
 */
#include "scene_curved.h"

#include "base/json_writer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Where a splat has its surface from: it has none, its normal field, or SHAPE. */
enum { FLAT, FIELD, SHAPE, KINDS };

enum { PRIMITIVES = KINDS * (PSPLAT_MAX_CLIP_LINES + 1), MAX_ROW = 52, MAX_ATTRIBUTES = 18 };

typedef struct primitive {
    int kind;
    uint32_t lines;
    size_t count, first_byte;
    float low[3], high[3]; /* of the centres */
} primitive;

typedef struct attribute {
    const char *name;
    size_t components;
} attribute;

static void give_up(const char *what) {
    fprintf(stderr, "scene: %s\n", what);
    abort();
}

static int is_curved(const psplat_splat *splat) {
    int is = 0;
    for (int i = 0; i < 5; ++i) is |= splat->shape[i] != 0;
    return is;
}

int scene_is_curved(const scene *s) {
    int is = s->flat_is_curved;
    for (size_t i = 0; i < s->count; ++i) {
        is |= is_curved(&s->splats[i]);
        for (uint32_t k = 0; k < s->splats[i].clip_count; ++k) is |= s->splats[i].bend[k] != 0;
    }
    return is;
}

static int kind_of(const scene *s, const psplat_splat *splat) {
    psplat_splat field = *splat;
    double most = 0;
    if (!is_curved(splat)) return s->flat_is_curved ? SHAPE : FLAT;
    scene_curve_splat(&field);
    for (int i = 0; i < 5; ++i)
        most = fmax(most, fabs((double)field.shape[i] - (double)splat->shape[i]));
    if (most < 1e-5) return FIELD;
    if (splat->shape[0] != 0 || splat->shape[1] != 0) give_up("no file can say this shape");
    return SHAPE;
}

static int has_texcoord_bend(const scene *s) {
    int has = 0;
    for (size_t i = 0; s->texcoords && i < s->count; ++i)
        for (int k = 0; k < 2; ++k)
            has |= s->texcoords[i].along_uu[k] != 0 || s->texcoords[i].along_uv[k] != 0 ||
                   s->texcoords[i].along_vv[k] != 0;
    return has;
}

/* Lists the attributes of a primitive in the order in which put_row stores them. Returns their
 * number. */
static size_t attributes_of(const scene *s, const primitive *p, attribute list[MAX_ATTRIBUTES]) {
    static const char *const clips[PSPLAT_MAX_CLIP_LINES] = {
        "_PSPLAT_surface_splats:CLIP_0", "_PSPLAT_surface_splats:CLIP_1",
        "_PSPLAT_surface_splats:CLIP_2", "_PSPLAT_surface_splats:CLIP_3"};
    size_t n = 0;
    list[n++] = (attribute){"POSITION", 3};
    list[n++] = (attribute){"NORMAL", 3};
    list[n++] = (attribute){"_PSPLAT_surface_splats:ROTATION", 4};
    list[n++] = (attribute){"_PSPLAT_surface_splats:SCALE", 2};
    list[n++] = (attribute){"_PSPLAT_surface_splats:NORMAL_FIELD", 3};
    if (p->kind == SHAPE) list[n++] = (attribute){"_PSPLAT_surface_splats:SHAPE", 3};
    if (s->has_color) list[n++] = (attribute){"COLOR_0", 4};
    for (uint32_t k = 0; k < p->lines; ++k) list[n++] = (attribute){clips[k], 4};
    static const char *const texcoords[] = {
        "TEXCOORD_0",
        "_PSPLAT_surface_splats:TEXCOORD_U",
        "_PSPLAT_surface_splats:TEXCOORD_V",
        "_PSPLAT_surface_splats:TEXCOORD_UU",
        "_PSPLAT_surface_splats:TEXCOORD_UV",
        "_PSPLAT_surface_splats:TEXCOORD_VV",
    };
    size_t orders = !s->texcoords ? 0 : has_texcoord_bend(s) ? 6 : 3;
    for (size_t k = 0; k < orders; ++k) list[n++] = (attribute){texcoords[k], 2};
    return n;
}

static size_t row_of(const scene *s, const primitive *p) {
    attribute list[MAX_ATTRIBUTES];
    size_t n = attributes_of(s, p, list), floats = 0;
    for (size_t i = 0; i < n; ++i) floats += list[i].components;
    return floats;
}

static float *put(float *row, const float *values, size_t count) {
    memcpy(row, values, count * sizeof *values);
    return row + count;
}

static void put_row(const scene *s, const primitive *p, size_t index, float *row) {
    const psplat_splat *splat = &s->splats[index];
    row = put(row, splat->center, 3);
    row = put(row, splat->normal, 3);
    row = put(row, splat->rotation, 4);
    row = put(row, splat->radius, 2);
    row = put(row, splat->gradient, 3);
    if (p->kind == SHAPE) row = put(row, splat->shape + 2, 3);
    if (s->has_color) row = put(row, splat->color, 4);
    for (uint32_t k = 0; k < p->lines; ++k)
        row = put(put(row, splat->clip[k], 3), &splat->bend[k], 1);
    if (!s->texcoords) return;
    const psplat_texcoord *t = &s->texcoords[index];
    row = put(put(put(row, t->at, 2), t->along_u, 2), t->along_v, 2);
    if (has_texcoord_bend(s)) put(put(put(row, t->along_uu, 2), t->along_uv, 2), t->along_vv, 2);
}

static uint8_t *put_u32(uint8_t *out, size_t value) {
    for (int i = 0; i < 4; ++i) *out++ = (uint8_t)(value >> (8 * i));
    return out;
}

/* Stores floats as glTF does, the least byte first. */
static void put_floats(uint8_t *out, const float *values, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        for (int k = 0; k < 4; ++k) out[4 * i + (size_t)k] = (uint8_t)(bits >> (8 * k));
    }
}

static void note_center(primitive *p, const float center[3]) {
    for (int i = 0; i < 3; ++i) {
        p->low[i] = p->count ? fminf(p->low[i], center[i]) : center[i];
        p->high[i] = p->count ? fmaxf(p->high[i], center[i]) : center[i];
    }
}

/* Stores the rows of one primitive at bytes, which has room for them. */
static void fill(const scene *s, primitive *p, uint8_t *bytes) {
    size_t floats = row_of(s, p);
    for (size_t i = 0; i < s->count; ++i) {
        const psplat_splat *splat = &s->splats[i];
        float row[MAX_ROW];
        if (splat->clip_count != p->lines || kind_of(s, splat) != p->kind) continue;
        put_row(s, p, i, row);
        put_floats(bytes + p->count * floats * 4, row, floats);
        note_center(p, splat->center);
        ++p->count;
    }
}

static size_t image_bytes(const psplat_pixels *image) {
    return 8 + 4 * (size_t)image->width * image->height;
}

/* Stores the images after size bytes of rows. */
static uint8_t *add_images(const scene *s, uint8_t *bytes, size_t *size) {
    for (size_t i = 0; i < s->image_count; ++i) {
        const psplat_pixels *image = &s->images[i];
        bytes = realloc(bytes, *size + image_bytes(image));
        if (!bytes) give_up("out of memory");
        uint8_t *out = put_u32(put_u32(bytes + *size, image->width), image->height);
        memcpy(out, image->rgba, image_bytes(image) - 8);
        *size += image_bytes(image);
    }
    return bytes;
}

/* Returns the bytes of all rows. Primitives are in ascending order of their clip lines. */
static uint8_t *fill_all(const scene *s, primitive list[PRIMITIVES], size_t *count, size_t *size) {
    uint8_t *bytes = calloc(s->count ? s->count : 1, MAX_ROW * 4);
    if (!bytes) give_up("out of memory");
    *count = *size = 0;
    for (uint32_t lines = 0; lines <= PSPLAT_MAX_CLIP_LINES; ++lines)
        for (int kind = FLAT; kind < KINDS; ++kind) {
            primitive p = {.kind = kind, .lines = lines, .first_byte = *size};
            fill(s, &p, bytes + *size);
            if (!p.count) continue;
            *size += p.count * row_of(s, &p) * 4;
            list[(*count)++] = p;
        }
    return add_images(s, bytes, size);
}

/* ---- the document --------------------------------------------------------------------------- */

static void add_extension(psplat_writer *json, const scene *s, const primitive *p) {
    float extent[3];
    for (int i = 0; i < 3; ++i) extent[i] = p->high[i] - p->low[i];
    psplat_writer_open(json, "PSPLAT_surface_splats", '{');
    psplat_writer_count(json, "version", 3);
    psplat_writer_count(json, "clipLines", p->lines);
    if (s->seam_lines)
        psplat_writer_count(json, "seamLines", s->seam_lines < p->lines ? s->seam_lines : p->lines);
    psplat_writer_float(json, "depthTolerance", s->depth_tolerance);
    psplat_writer_floats(json, "positionExtent", extent, 3);
    if (p->kind != FLAT) psplat_writer_boolean(json, "curved", 1);
    psplat_writer_open(json, "kernel", '{');
    psplat_writer_float(json, "sharpness", s->kernel.sharpness);
    psplat_writer_float(json, "exponent", s->kernel.exponent);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
}

static void add_primitive(psplat_writer *json, const scene *s, const primitive *p,
                          size_t *accessor) {
    attribute list[MAX_ATTRIBUTES];
    size_t n = attributes_of(s, p, list);
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "mode", 0);
    psplat_writer_count(json, "material", 0);
    psplat_writer_open(json, "attributes", '{');
    for (size_t i = 0; i < n; ++i) psplat_writer_count(json, list[i].name, (*accessor)++);
    psplat_writer_close(json, '}');
    psplat_writer_open(json, "extensions", '{');
    add_extension(json, s, p);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
}

static void add_accessors(psplat_writer *json, const scene *s, const primitive *p, size_t view) {
    static const char *const types[] = {NULL, "SCALAR", "VEC2", "VEC3", "VEC4"};
    attribute list[MAX_ATTRIBUTES];
    size_t n = attributes_of(s, p, list), offset = 0;
    for (size_t i = 0; i < n; ++i) {
        psplat_writer_open(json, NULL, '{');
        psplat_writer_count(json, "bufferView", view);
        psplat_writer_count(json, "byteOffset", offset);
        psplat_writer_count(json, "componentType", 5126);
        psplat_writer_count(json, "count", p->count);
        psplat_writer_string(json, "type", types[list[i].components]);
        if (i == 0) psplat_writer_floats(json, "min", p->low, 3);
        if (i == 0) psplat_writer_floats(json, "max", p->high, 3);
        psplat_writer_close(json, '}');
        offset += list[i].components * 4;
    }
}

static void add_view(psplat_writer *json, const scene *s, const primitive *p) {
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "buffer", 0);
    psplat_writer_count(json, "byteOffset", p->first_byte);
    psplat_writer_count(json, "byteLength", p->count * row_of(s, p) * 4);
    psplat_writer_count(json, "byteStride", row_of(s, p) * 4);
    psplat_writer_close(json, '}');
}

/* Adds the use of an image; textures and their samplers have the numbers of their slots. */
static void add_texture(psplat_writer *json, const char *name, const psplat_material *m, int slot) {
    const psplat_texture *use = &m->textures[slot];
    const float *t = use->transform;
    if (!use->image) return;
    psplat_writer_open(json, name, '{');
    psplat_writer_count(json, "index", (size_t)slot);
    if (slot == PSPLAT_TEXTURE_NORMAL) psplat_writer_float(json, "scale", use->strength);
    if (slot == PSPLAT_TEXTURE_OCCLUSION) psplat_writer_float(json, "strength", use->strength);
    if (t[0] != 0 || t[1] != 0) {
        float size[2] = {hypotf(t[0], t[3]), hypotf(t[1], t[4])}, offset[2] = {t[2], t[5]};
        if (t[0] * t[4] < t[1] * t[3]) size[1] = -size[1];
        psplat_writer_open(json, "extensions", '{');
        psplat_writer_open(json, "KHR_texture_transform", '{');
        psplat_writer_floats(json, "offset", offset, 2);
        psplat_writer_float(json, "rotation", atan2f(-t[3], t[0]));
        psplat_writer_floats(json, "scale", size, 2);
        psplat_writer_close(json, '}');
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, '}');
}

/* Images are the last of so many bytes. */
static void add_image_views(psplat_writer *json, const scene *s, size_t bytes) {
    for (size_t i = 0; i < s->image_count; ++i) bytes -= image_bytes(&s->images[i]);
    for (size_t i = 0; i < s->image_count; ++i) {
        psplat_writer_open(json, NULL, '{');
        psplat_writer_count(json, "buffer", 0);
        psplat_writer_count(json, "byteOffset", bytes);
        psplat_writer_count(json, "byteLength", image_bytes(&s->images[i]));
        psplat_writer_close(json, '}');
        bytes += image_bytes(&s->images[i]);
    }
}

static void add_images_of(psplat_writer *json, const scene *s, size_t first_view) {
    static const size_t wraps[] = {10497, 33071, 33648};
    psplat_writer_open(json, "textures", '[');
    for (size_t i = 0; i < PSPLAT_TEXTURE_SLOTS; ++i) {
        uint32_t image = s->material.textures[i].image;
        psplat_writer_open(json, NULL, '{');
        psplat_writer_count(json, "source", image ? image - 1 : 0);
        psplat_writer_count(json, "sampler", i);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
    psplat_writer_open(json, "samplers", '[');
    for (size_t i = 0; i < PSPLAT_TEXTURE_SLOTS; ++i) {
        const psplat_texture *use = &s->material.textures[i];
        psplat_writer_open(json, NULL, '{');
        psplat_writer_count(json, "wrapS", wraps[use->wrap[0]]);
        psplat_writer_count(json, "wrapT", wraps[use->wrap[1]]);
        psplat_writer_count(json, "magFilter", use->nearest ? 9728 : 9729);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
    psplat_writer_open(json, "images", '[');
    for (size_t i = 0; i < s->image_count; ++i) {
        psplat_writer_open(json, NULL, '{');
        psplat_writer_count(json, "bufferView", first_view + i);
        psplat_writer_string(json, "mimeType", "image/x-raw");
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

static void add_material(psplat_writer *json, const psplat_material *m) {
    psplat_writer_open(json, "materials", '[');
    psplat_writer_open(json, NULL, '{');
    psplat_writer_open(json, "pbrMetallicRoughness", '{');
    psplat_writer_floats(json, "baseColorFactor", m->base_color, 4);
    psplat_writer_float(json, "metallicFactor", m->metallic);
    psplat_writer_float(json, "roughnessFactor", m->roughness);
    add_texture(json, "baseColorTexture", m, PSPLAT_TEXTURE_BASE_COLOR);
    add_texture(json, "metallicRoughnessTexture", m, PSPLAT_TEXTURE_METALLIC_ROUGHNESS);
    psplat_writer_close(json, '}');
    psplat_writer_floats(json, "emissiveFactor", m->emissive, 3);
    psplat_writer_boolean(json, "doubleSided", m->double_sided);
    add_texture(json, "occlusionTexture", m, PSPLAT_TEXTURE_OCCLUSION);
    add_texture(json, "emissiveTexture", m, PSPLAT_TEXTURE_EMISSIVE);
    if (m->alpha_cutoff > 0) {
        psplat_writer_string(json, "alphaMode", "MASK");
        psplat_writer_float(json, "alphaCutoff", m->alpha_cutoff);
    }
    psplat_writer_open(json, "extensions", '{');
    if (m->unlit) psplat_writer_raw(json, "KHR_materials_unlit", "{}");
    if (m->textures[PSPLAT_TEXTURE_NORMAL].image) {
        psplat_writer_open(json, "PSPLAT_surface_splats", '{');
        add_texture(json, "normalTexture", m, PSPLAT_TEXTURE_NORMAL);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
    psplat_writer_close(json, ']');
}

static void add_nodes(psplat_writer *json, const scene *s) {
    psplat_writer_raw(json, "asset", "{\"version\":\"2.0\"}");
    psplat_writer_raw(json, "extensionsUsed",
                      s->material.unlit ? "[\"PSPLAT_surface_splats\",\"KHR_materials_unlit\"]"
                                        : "[\"PSPLAT_surface_splats\"]");
    psplat_writer_count(json, "scene", 0);
    psplat_writer_raw(json, "scenes", "[{\"nodes\":[0]}]");
    psplat_writer_open(json, "nodes", '[');
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "mesh", 0);
    psplat_writer_numbers(json, "translation", s->origin, 3);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, ']');
}

static void write_document(psplat_writer *json, const scene *s, const primitive *list, size_t count,
                           size_t bytes) {
    size_t accessor = 0;
    psplat_writer_open(json, NULL, '{');
    add_nodes(json, s);
    psplat_writer_open(json, "meshes", '[');
    psplat_writer_open(json, NULL, '{');
    psplat_writer_open(json, "primitives", '[');
    for (size_t i = 0; i < count; ++i) add_primitive(json, s, &list[i], &accessor);
    psplat_writer_close(json, ']');
    psplat_writer_close(json, '}');
    psplat_writer_close(json, ']');
    add_material(json, &s->material);
    if (s->image_count) add_images_of(json, s, count);
    psplat_writer_open(json, "accessors", '[');
    for (size_t i = 0; i < count; ++i) add_accessors(json, s, &list[i], i);
    psplat_writer_close(json, ']');
    psplat_writer_open(json, "bufferViews", '[');
    for (size_t i = 0; i < count; ++i) add_view(json, s, &list[i]);
    add_image_views(json, s, bytes);
    psplat_writer_close(json, ']');
    psplat_writer_open(json, "buffers", '[');
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "byteLength", bytes);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, ']');
    psplat_writer_close(json, '}');
    if (!psplat_writer_finish(json)) give_up("out of memory");
}

/* The container is that of glTF 2.0 section 4.4. */
uint8_t *scene_curved_glb(const scene *s, size_t *size) {
    primitive list[PRIMITIVES];
    size_t count, bytes;
    psplat_writer json = {.compact = 1};
    uint8_t *rows = fill_all(s, list, &count, &bytes);
    write_document(&json, s, list, count, bytes);
    size_t text = (json.size + 3) / 4 * 4;
    *size = 12 + 8 + text + 8 + bytes;
    uint8_t *data = malloc(*size), *out = data;
    if (!data) give_up("out of memory");
    out = put_u32(put_u32(put_u32(out, 0x46546c67), 2), *size);
    out = put_u32(put_u32(out, text), 0x4e4f534a);
    memset(out, ' ', text);
    memcpy(out, json.text, json.size);
    out = put_u32(put_u32(out + text, bytes), 0x004e4942);
    memcpy(out, rows, bytes);
    free(json.text);
    free(rows);
    return data;
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * stand_in_file.c - meshes that stand in for splats as a file holds them.
 *
 * Where splats are integers, positions are integers in the same units, normals are bytes. Colours
 * always are: it is a stand-in.
 */
#include "stand_in_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POSITIONS = 0, NORMALS, COLORS, NORMAL_BITS = 8, UNSIGNED_INT = 5125 };

/* ---- numbers --------------------------------------------------------------------------------- */

static uint8_t *put(uint8_t *out, uint32_t value, size_t bytes) {
    for (size_t i = 0; i < bytes; ++i) *out++ = (uint8_t)(value >> (8 * i));
    return out;
}

static uint8_t *put_float(uint8_t *out, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return put(out, bits, 4);
}

/* A position in the space of the splats: what their POSITION is relative to, in their units. */
static void place(const psplat_sheet *sheet, const psplat_stand_in *s, size_t vertex,
                  float out[3]) {
    for (size_t k = 0; k < 3; ++k) {
        double value =
            (double)s->vertices[vertex].position[k] + (s->origin[k] - sheet->splats->origin[k]);
        if (sheet->codes)
            value = rint(value / sheet->splats->precision.unit) - (double)sheet->low[k];
        out[k] = (float)value;
    }
}

/* Shorts where they suffice: the mesh reaches a little beyond the centres of its splats. */
static void choose_types(const psplat_sheet *sheet, psplat_stand_in_sheet *file) {
    const psplat_stand_in *s = file->stand_in;
    int is_short = sheet->codes != NULL;
    for (size_t i = 0; i < s->vertex_count; ++i) {
        float position[3];
        place(sheet, s, i, position);
        for (int k = 0; k < 3; ++k) {
            file->low[k] = i ? fminf(file->low[k], position[k]) : position[k];
            file->high[k] = i ? fmaxf(file->high[k], position[k]) : position[k];
            is_short &= position[k] >= -32768 && position[k] <= 32767;
        }
    }
    file->position =
        (psplat_column){.type = is_short ? PSPLAT_TYPE_SHORT : PSPLAT_TYPE_FLOAT, .components = 3};
    file->normal = (psplat_column){.type = sheet->codes ? PSPLAT_TYPE_BYTE : PSPLAT_TYPE_FLOAT,
                                   .components = 3};
}

static void put_position(const psplat_sheet *sheet, const psplat_stand_in_sheet *file, size_t i,
                         uint8_t *out) {
    float position[3];
    place(sheet, file->stand_in, i, position);
    for (int k = 0; k < 3; ++k)
        out = file->position.type == PSPLAT_TYPE_FLOAT
                  ? put_float(out, position[k])
                  : put(out, (uint32_t)(int32_t)position[k], 2);
}

/* Bytes as the octahedral filter has them before decoding, or after it. */
static void put_normal(const psplat_stand_in_sheet *file, size_t i, int is_octahedral,
                       uint8_t *out) {
    const float *n = file->stand_in->vertices[i].normal;
    const double normal[3] = {(double)n[0], (double)n[1], (double)n[2]};
    int32_t code[2], decoded[3];
    if (file->normal.type == PSPLAT_TYPE_FLOAT) {
        for (int k = 0; k < 3; ++k) out = put_float(out, n[k]);
        return;
    }
    psplat_octahedron_encode(normal, NORMAL_BITS, code);
    psplat_octahedron_decode(code, NORMAL_BITS, decoded);
    for (int k = 0; k < 2; ++k) out = put(out, (uint32_t)(is_octahedral ? code : decoded)[k], 1);
    put(out, is_octahedral ? 127u : (uint32_t)decoded[2], 1);
}

static void put_color(const psplat_stand_in *s, size_t i, uint8_t *out) {
    const float *color = s->vertices[i].color;
    for (int k = 0; k < 4; ++k)
        out = put(out, (uint32_t)lrintf(255 * fminf(fmaxf(color[k], 0), 1)), 1);
}

/* ---- views ----------------------------------------------------------------------------------- */

static psplat_file_view *add_view(psplat_stand_in_file *file, size_t rows, size_t stride) {
    psplat_file_view *view = &file->views[file->view_count++];
    *view = (psplat_file_view){.stride = stride, .rows = rows, .capacity = rows};
    view->bytes = calloc(rows, stride);
    return view->bytes ? view : NULL;
}

static int add_vertices(psplat_stand_in_file *file, const psplat_sheet *sheet,
                        const psplat_stand_in_sheet *s, const psplat_codec *codec) {
    size_t count = s->stand_in->vertex_count;
    psplat_file_view *views[3] = {
        add_view(file, count, psplat_column_bytes(&s->position)),
        add_view(file, count, psplat_column_bytes(&s->normal)),
        s->stand_in->has_color ? add_view(file, count, 4) : NULL,
    };
    if (!views[POSITIONS] || !views[NORMALS] || (s->stand_in->has_color && !views[COLORS]))
        return 0;
    views[NORMALS]->is_octahedral = codec && s->normal.type != PSPLAT_TYPE_FLOAT;
    for (size_t i = 0; i < count; ++i) {
        put_position(sheet, s, i, views[POSITIONS]->bytes + i * views[POSITIONS]->stride);
        put_normal(s, i, views[NORMALS]->is_octahedral,
                   views[NORMALS]->bytes + i * views[NORMALS]->stride);
        if (views[COLORS]) put_color(s->stand_in, i, views[COLORS]->bytes + 4 * i);
    }
    return 1;
}

static size_t index_bytes(const psplat_stand_in *s) {
    return s->vertex_count <= UINT16_MAX ? 2 : 4;
}

static int add_indices(psplat_stand_in_file *file, const psplat_stand_in *s) {
    size_t bytes = index_bytes(s);
    psplat_file_view *view = add_view(file, s->index_count, bytes);
    for (size_t i = 0; i < s->index_count && view; ++i)
        put(view->bytes + i * bytes, s->indices[i], bytes);
    if (view) view->is_index = 1;
    return view != NULL;
}

static int compress(const psplat_codec *codec, const psplat_stand_in *s, psplat_file_view *view) {
    size_t bound = view->is_index ? codec->index_bound(s->index_count, s->vertex_count)
                                  : codec->bound(view->rows, view->stride);
    view->packed = malloc(bound + 3);
    if (!view->packed) return 0;
    view->packed_size =
        view->is_index ? codec->index_encode(view->packed, bound, s->indices, s->index_count)
                       : codec->encode(view->packed, bound, view->bytes, view->rows, view->stride);
    return view->packed_size > 0;
}

static int add_mesh(psplat_stand_in_file *file, const psplat_sheet *splats,
                    const psplat_codec *codec, psplat_stand_in_sheet *sheet) {
    const psplat_stand_in *s = sheet->stand_in;
    sheet->first_view = file->view_count;
    sheet->first_accessor = file->accessor_count;
    choose_types(splats, sheet);
    if (!add_vertices(file, splats, sheet, codec) || !add_indices(file, s)) return 0;
    file->accessor_count += 2 + (size_t)(s->has_color != 0) + s->part_count;
    for (size_t i = sheet->first_view; i < file->view_count && codec; ++i)
        if (!compress(codec, s, &file->views[i])) return 0;
    return 1;
}

psplat_result psplat_stand_in_file_make(const psplat_stand_in *stand_ins,
                                        const psplat_sheet *sheets, size_t mesh_count,
                                        const psplat_codec *codec, psplat_stand_in_file *file,
                                        psplat_error *error) {
    enum { MOST_VIEWS = 4 };
    *file = (psplat_stand_in_file){.mesh_count = mesh_count};
    file->sheets = calloc(mesh_count + 1, sizeof *file->sheets);
    file->views = calloc(MOST_VIEWS * mesh_count + 1, sizeof *file->views);
    int is_made = file->sheets && file->views;
    for (size_t i = 0; i < mesh_count && is_made; ++i) {
        if (!stand_ins[i].index_count || !sheets[i].splats->count) continue;
        file->sheets[i].stand_in = &stand_ins[i];
        is_made = add_mesh(file, &sheets[i], codec, &file->sheets[i]);
    }
    if (is_made) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the meshes that stand in");
}

void psplat_stand_in_file_free(psplat_stand_in_file *file) {
    for (size_t i = 0; i < file->view_count; ++i) {
        free(file->views[i].bytes);
        free(file->views[i].packed);
    }
    free(file->sheets);
    free(file->views);
    *file = (psplat_stand_in_file){0};
}

psplat_result psplat_stand_in_file_collect(const psplat_stand_in_file *file,
                                           const psplat_scene *scene, psplat_materials *materials) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < file->mesh_count; ++i) {
        const psplat_stand_in *s = file->sheets[i].stand_in;
        for (size_t k = 0; s && k < s->part_count && !result; ++k)
            result =
                psplat_materials_add(materials, scene, &s->parts[k].material, s->parts[k].group);
    }
    return result;
}

/* ---- JSON ------------------------------------------------------------------------------------ */

/* The accessor of a part's indices. */
static size_t index_accessor(const psplat_stand_in_sheet *sheet, size_t part) {
    return sheet->first_accessor + 2 + (size_t)(sheet->stand_in->has_color != 0) + part;
}

static void write_primitive(psplat_writer *json, const psplat_stand_in_sheet *sheet, size_t part,
                            size_t first_accessor, uint32_t material) {
    static const char *const names[] = {"POSITION", "NORMAL", "COLOR_0"};
    size_t count = sheet->stand_in->has_color ? 3 : 2;
    psplat_writer_open(json, NULL, '{');
    psplat_writer_open(json, "attributes", '{');
    for (size_t i = 0; i < count; ++i)
        psplat_writer_count(json, names[i], first_accessor + sheet->first_accessor + i);
    psplat_writer_close(json, '}');
    psplat_writer_count(json, "indices", first_accessor + index_accessor(sheet, part));
    if (material != PSPLAT_NO_INDEX) psplat_writer_count(json, "material", material);
    psplat_writer_close(json, '}');
}

void psplat_stand_in_file_write_mesh(psplat_writer *json, const psplat_stand_in_sheet *sheet,
                                     const psplat_scene *scene, const psplat_materials *materials,
                                     size_t first_accessor, size_t splat_mesh) {
    psplat_writer_open(json, "primitives", '[');
    for (size_t i = 0; i < sheet->stand_in->part_count; ++i) {
        const psplat_stand_in_part *part = &sheet->stand_in->parts[i];
        write_primitive(json, sheet, i, first_accessor,
                        psplat_materials_find(materials, scene, &part->material, part->group));
    }
    psplat_writer_close(json, ']');
    psplat_writer_open(json, "extensions", '{');
    psplat_writer_open(json, "PSPLAT_surface_splats", '{');
    psplat_writer_count(json, "mesh", splat_mesh);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
}

static void write_accessor(psplat_writer *json, size_t view, size_t offset, int type, size_t count,
                           const char *shape) {
    psplat_writer_count(json, "bufferView", view);
    if (offset) psplat_writer_count(json, "byteOffset", offset);
    psplat_writer_count(json, "componentType", (size_t)type);
    psplat_writer_count(json, "count", count);
    psplat_writer_string(json, "type", shape);
}

static void write_vertices(psplat_writer *json, const psplat_stand_in_sheet *sheet, size_t view) {
    size_t count = sheet->stand_in->vertex_count;
    psplat_writer_open(json, NULL, '{');
    write_accessor(json, view, 0, sheet->position.type, count, "VEC3");
    psplat_writer_floats(json, "min", sheet->low, 3);
    psplat_writer_floats(json, "max", sheet->high, 3);
    psplat_writer_close(json, '}');
    psplat_writer_open(json, NULL, '{');
    write_accessor(json, view + NORMALS, 0, sheet->normal.type, count, "VEC3");
    if (sheet->normal.type != PSPLAT_TYPE_FLOAT) psplat_writer_boolean(json, "normalized", 1);
    psplat_writer_close(json, '}');
    if (!sheet->stand_in->has_color) return;
    psplat_writer_open(json, NULL, '{');
    write_accessor(json, view + COLORS, 0, PSPLAT_TYPE_UNSIGNED_BYTE, count, "VEC4");
    psplat_writer_boolean(json, "normalized", 1);
    psplat_writer_close(json, '}');
}

void psplat_stand_in_file_write_accessors(psplat_writer *json, const psplat_stand_in_file *file,
                                          size_t first_view) {
    for (size_t i = 0; i < file->mesh_count; ++i) {
        const psplat_stand_in_sheet *sheet = &file->sheets[i];
        const psplat_stand_in *s = sheet->stand_in;
        if (!s) continue;
        size_t view = first_view + sheet->first_view, bytes = index_bytes(s);
        write_vertices(json, sheet, view);
        for (size_t k = 0; k < s->part_count; ++k) {
            psplat_writer_open(json, NULL, '{');
            write_accessor(json, view + (s->has_color ? 3 : 2), s->parts[k].first * bytes,
                           bytes == 2 ? PSPLAT_TYPE_UNSIGNED_SHORT : UNSIGNED_INT,
                           s->parts[k].count, "SCALAR");
            psplat_writer_close(json, '}');
        }
    }
}

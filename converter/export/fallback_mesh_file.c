/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * fallback_mesh_file.c - fallback meshes in a glTF file: buffer views, accessors, meshes.
 *
 * If the splats are quantized, positions are integers in the same units and normals are bytes.
 * Colours are always bytes: a fallback mesh need not be exact. Texture coordinates of 0 ... 1 are
 * shorts then, others floats.
 */
#include "export/fallback_mesh_file.h"

#include "base/json_writer.h"
#include "export/buffer_layout.h"
#include "export/fallback_mesh.h"
#include "export/material_json.h"
#include "export/meshopt_codec.h"
#include "export/splat_attributes.h"
#include "scene/scene.h"
#include "splats/octahedron.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POSITIONS = 0, NORMALS, COLORS, TEXCOORDS, VIEWS }; /* the order of a mesh's views */
enum { NORMAL_BITS = 8, UNSIGNED_INT = 5125 };             /* the latter is a glTF component type */

/* ---- numbers --------------------------------------------------------------------------------- */

static uint8_t *put_float(uint8_t *out, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return psplat_put_integer(out, bits, 4);
}

/* Converts the position of a vertex to the coordinates and units of the splats' POSITION. */
static void place(const psplat_attribute_table *table, const psplat_fallback_mesh *s, size_t vertex,
                  float out[3]) {
    for (size_t k = 0; k < 3; ++k) {
        double value =
            (double)s->vertices[vertex].position[k] + (s->origin[k] - table->splats->origin[k]);
        if (table->codes)
            value = rint(value / table->splats->precision.unit) - (double)table->low[k];
        out[k] = (float)value;
    }
}

/* Finds the bounds and chooses the types. Positions are shorts only if all of them fit: the mesh
 * reaches a little beyond the centres of its splats. */
static void choose_types(const psplat_attribute_table *table, psplat_fallback_table *stored) {
    const psplat_fallback_mesh *s = stored->fallback;
    int is_short = table->codes != NULL, is_unit = is_short;
    for (size_t i = 0; i < s->vertex_count; ++i) {
        float position[3];
        place(table, s, i, position);
        for (int k = 0; k < 3; ++k) {
            stored->low[k] = i ? fminf(stored->low[k], position[k]) : position[k];
            stored->high[k] = i ? fmaxf(stored->high[k], position[k]) : position[k];
            is_short &= position[k] >= -32768 && position[k] <= 32767;
        }
        for (int k = 0; k < 2; ++k)
            is_unit &= s->vertices[i].texcoord[k] >= 0 && s->vertices[i].texcoord[k] <= 1;
    }
    stored->position = (psplat_attribute_format){
        .type = is_short ? PSPLAT_TYPE_SHORT : PSPLAT_TYPE_FLOAT, .components = 3};
    stored->normal = (psplat_attribute_format){
        .type = table->codes ? PSPLAT_TYPE_BYTE : PSPLAT_TYPE_FLOAT, .components = 3};
    stored->texcoord = (psplat_attribute_format){
        .type = is_unit ? PSPLAT_TYPE_UNSIGNED_SHORT : PSPLAT_TYPE_FLOAT, .components = 2};
}

static void put_position(const psplat_attribute_table *table, const psplat_fallback_table *stored,
                         size_t i, uint8_t *out) {
    float position[3];
    place(table, stored->fallback, i, position);
    for (int k = 0; k < 3; ++k)
        out = stored->position.type == PSPLAT_TYPE_FLOAT
                  ? put_float(out, position[k])
                  : psplat_put_integer(out, (uint32_t)(int32_t)position[k], 2);
}

/* Writes a normal: as floats, as input of the octahedral filter, or as that filter decodes it. */
static void put_normal(const psplat_fallback_table *stored, size_t i, int is_octahedral,
                       uint8_t *out) {
    const float *n = stored->fallback->vertices[i].normal;
    const double normal[3] = {(double)n[0], (double)n[1], (double)n[2]};
    int32_t code[2], decoded[3];
    if (stored->normal.type == PSPLAT_TYPE_FLOAT) {
        for (int k = 0; k < 3; ++k) out = put_float(out, n[k]);
        return;
    }
    psplat_octahedron_encode(normal, NORMAL_BITS, code);
    psplat_octahedron_decode(code, NORMAL_BITS, decoded);
    for (int k = 0; k < 2; ++k)
        out = psplat_put_integer(out, (uint32_t)(is_octahedral ? code : decoded)[k], 1);
    psplat_put_integer(out, is_octahedral ? 127u : (uint32_t)decoded[2], 1);
}

static void put_color(const psplat_fallback_mesh *s, size_t i, uint8_t *out) {
    const float *color = s->vertices[i].color;
    for (int k = 0; k < 4; ++k)
        out = psplat_put_integer(out, (uint32_t)lrintf(255 * fminf(fmaxf(color[k], 0), 1)), 1);
}

static void put_texcoord(const psplat_fallback_table *stored, size_t i, uint8_t *out) {
    const float *texcoord = stored->fallback->vertices[i].texcoord;
    for (int k = 0; k < 2; ++k)
        out = stored->texcoord.type == PSPLAT_TYPE_FLOAT
                  ? put_float(out, texcoord[k])
                  : psplat_put_integer(out, (uint32_t)lrintf(65535 * texcoord[k]), 2);
}

/* ---- views ----------------------------------------------------------------------------------- */

static psplat_buffer_view *add_view(psplat_fallback_file *file, size_t rows, size_t stride) {
    psplat_buffer_view *view = &file->views[file->view_count++];
    *view = (psplat_buffer_view){.stride = stride, .rows = rows, .capacity = rows};
    view->bytes = calloc(rows, stride);
    return view->bytes ? view : NULL;
}

static int add_vertices(psplat_fallback_file *file, const psplat_attribute_table *table,
                        const psplat_fallback_table *s, const psplat_codec *codec) {
    size_t count = s->fallback->vertex_count;
    const size_t strides[VIEWS] = {
        [POSITIONS] = psplat_attribute_bytes(&s->position),
        [NORMALS] = psplat_attribute_bytes(&s->normal),
        [COLORS] = s->fallback->has_color ? 4 : 0,
        [TEXCOORDS] = s->fallback->has_texcoord ? psplat_attribute_bytes(&s->texcoord) : 0};
    uint8_t *rows[VIEWS] = {NULL};
    int is_octahedral = codec && s->normal.type != PSPLAT_TYPE_FLOAT;
    for (int i = 0; i < VIEWS; ++i) {
        psplat_buffer_view *view = strides[i] ? add_view(file, count, strides[i]) : NULL;
        if (strides[i] && !view) return 0;
        if (!view) continue;
        if (i == NORMALS && is_octahedral) view->filter = PSPLAT_FILTER_OCTAHEDRAL;
        rows[i] = view->bytes;
    }
    for (size_t i = 0; i < count; ++i) {
        put_position(table, s, i, rows[POSITIONS] + i * strides[POSITIONS]);
        put_normal(s, i, is_octahedral, rows[NORMALS] + i * strides[NORMALS]);
        if (rows[COLORS]) put_color(s->fallback, i, rows[COLORS] + i * strides[COLORS]);
        if (rows[TEXCOORDS]) put_texcoord(s, i, rows[TEXCOORDS] + i * strides[TEXCOORDS]);
    }
    return 1;
}

/* Returns the number of attributes of a mesh's vertices. */
static size_t attribute_count(const psplat_fallback_mesh *s) {
    return 2 + (size_t)(s->has_color != 0) + (size_t)(s->has_texcoord != 0);
}

static size_t index_bytes(const psplat_fallback_mesh *s) {
    return s->vertex_count <= UINT16_MAX ? 2 : 4;
}

static int add_indices(psplat_fallback_file *file, const psplat_fallback_mesh *s) {
    size_t bytes = index_bytes(s);
    psplat_buffer_view *view = add_view(file, s->index_count, bytes);
    for (size_t i = 0; i < s->index_count && view; ++i)
        psplat_put_integer(view->bytes + i * bytes, s->indices[i], bytes);
    if (view) view->kind = PSPLAT_VIEW_INDICES;
    return view != NULL;
}

static int compress(const psplat_codec *codec, const psplat_fallback_mesh *s,
                    psplat_buffer_view *view) {
    int is_index = view->kind == PSPLAT_VIEW_INDICES;
    size_t bound = is_index ? codec->index_bound(s->index_count, s->vertex_count)
                            : codec->bound(view->rows, view->stride);
    view->packed = malloc(bound + 3);
    if (!view->packed) return 0;
    view->packed_size =
        is_index ? codec->index_encode(view->packed, bound, s->indices, s->index_count)
                 : codec->encode(view->packed, bound, view->bytes, view->rows, view->stride);
    return view->packed_size > 0;
}

static int add_mesh(psplat_fallback_file *file, const psplat_attribute_table *table,
                    const psplat_codec *codec, psplat_fallback_table *stored) {
    const psplat_fallback_mesh *s = stored->fallback;
    stored->first_view = file->view_count;
    stored->first_accessor = file->accessor_count;
    choose_types(table, stored);
    if (!add_vertices(file, table, stored, codec) || !add_indices(file, s)) return 0;
    file->accessor_count += attribute_count(s) + s->primitive_count;
    for (size_t i = stored->first_view; i < file->view_count && codec; ++i)
        if (!compress(codec, s, &file->views[i])) return 0;
    return 1;
}

static int has_splats(const psplat_attribute_table *tables, size_t mesh_count) {
    for (size_t i = 0; i < mesh_count; ++i)
        if (tables[i].splats->count) return 1;
    return 0;
}

psplat_result psplat_fallback_file_make(const psplat_fallback_mesh *fallbacks,
                                        const psplat_attribute_table *tables, size_t mesh_count,
                                        const psplat_codec *codec, psplat_fallback_file *file,
                                        psplat_error *error) {
    enum { MAX_VIEWS = VIEWS + 1 };
    *file = (psplat_fallback_file){.mesh_count = mesh_count};
    file->tables = calloc(mesh_count + 1, sizeof *file->tables);
    file->views = calloc(MAX_VIEWS * mesh_count + 1, sizeof *file->views);
    int is_made = file->tables && file->views, needs_splats = has_splats(tables, mesh_count);
    for (size_t i = 0; i < mesh_count && is_made; ++i) {
        if (!fallbacks[i].index_count || (needs_splats && !tables[i].splats->count)) continue;
        file->tables[i].fallback = &fallbacks[i];
        is_made = add_mesh(file, &tables[i], codec, &file->tables[i]);
    }
    if (is_made) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the fallback meshes");
}

void psplat_fallback_file_free(psplat_fallback_file *file) {
    for (size_t i = 0; i < file->view_count; ++i) {
        free(file->views[i].bytes);
        free(file->views[i].packed);
    }
    free(file->tables);
    free(file->views);
    *file = (psplat_fallback_file){0};
}

psplat_result psplat_fallback_file_collect(const psplat_fallback_file *file,
                                           const psplat_scene *scene, psplat_materials *materials) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < file->mesh_count; ++i) {
        const psplat_fallback_mesh *s = file->tables[i].fallback;
        for (size_t k = 0; s && k < s->primitive_count && !result; ++k)
            result = psplat_materials_add(materials, scene, &s->primitives[k].material,
                                          s->primitives[k].group);
    }
    return result;
}

/* ---- JSON ------------------------------------------------------------------------------------ */

/* Returns the accessor of a primitive's indices, among those of all fallback meshes. */
static size_t index_accessor(const psplat_fallback_table *table, size_t primitive) {
    return table->first_accessor + attribute_count(table->fallback) + primitive;
}

static void write_primitive(psplat_writer *json, const psplat_fallback_table *table,
                            size_t primitive, size_t first_accessor, uint32_t material) {
    const psplat_fallback_mesh *s = table->fallback;
    size_t accessor = first_accessor + table->first_accessor;
    psplat_writer_open(json, NULL, '{');
    psplat_writer_open(json, "attributes", '{');
    psplat_writer_count(json, "POSITION", accessor++);
    psplat_writer_count(json, "NORMAL", accessor++);
    if (s->has_color) psplat_writer_count(json, "COLOR_0", accessor++);
    if (s->primitives[primitive].has_texcoord) psplat_writer_count(json, "TEXCOORD_0", accessor);
    psplat_writer_close(json, '}');
    psplat_writer_count(json, "indices", first_accessor + index_accessor(table, primitive));
    if (material != PSPLAT_NO_INDEX) psplat_writer_count(json, "material", material);
    psplat_writer_close(json, '}');
}

void psplat_fallback_file_write_mesh(psplat_writer *json, const psplat_fallback_table *table,
                                     const psplat_scene *scene, const psplat_materials *materials,
                                     size_t first_accessor, size_t splat_mesh) {
    psplat_writer_open(json, "primitives", '[');
    for (size_t i = 0; i < table->fallback->primitive_count; ++i) {
        const psplat_fallback_primitive *primitive = &table->fallback->primitives[i];
        write_primitive(
            json, table, i, first_accessor,
            psplat_materials_find(materials, scene, &primitive->material, primitive->group));
    }
    psplat_writer_close(json, ']');
    if (splat_mesh == PSPLAT_NO_INDEX) return;
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

static void write_vertices(psplat_writer *json, const psplat_fallback_table *table, size_t view) {
    size_t count = table->fallback->vertex_count;
    psplat_writer_open(json, NULL, '{');
    write_accessor(json, view, 0, table->position.type, count, "VEC3");
    psplat_writer_floats(json, "min", table->low, 3);
    psplat_writer_floats(json, "max", table->high, 3);
    psplat_writer_close(json, '}');
    psplat_writer_open(json, NULL, '{');
    write_accessor(json, view + NORMALS, 0, table->normal.type, count, "VEC3");
    if (table->normal.type != PSPLAT_TYPE_FLOAT) psplat_writer_boolean(json, "normalized", 1);
    psplat_writer_close(json, '}');
    view += COLORS;
    if (table->fallback->has_color) {
        psplat_writer_open(json, NULL, '{');
        write_accessor(json, view++, 0, PSPLAT_TYPE_UNSIGNED_BYTE, count, "VEC4");
        psplat_writer_boolean(json, "normalized", 1);
        psplat_writer_close(json, '}');
    }
    if (!table->fallback->has_texcoord) return;
    psplat_writer_open(json, NULL, '{');
    write_accessor(json, view, 0, table->texcoord.type, count, "VEC2");
    if (table->texcoord.type != PSPLAT_TYPE_FLOAT) psplat_writer_boolean(json, "normalized", 1);
    psplat_writer_close(json, '}');
}

void psplat_fallback_file_write_accessors(psplat_writer *json, const psplat_fallback_file *file,
                                          size_t first_view) {
    for (size_t i = 0; i < file->mesh_count; ++i) {
        const psplat_fallback_table *table = &file->tables[i];
        const psplat_fallback_mesh *s = table->fallback;
        if (!s) continue;
        size_t view = first_view + table->first_view, bytes = index_bytes(s);
        write_vertices(json, table, view);
        for (size_t k = 0; k < s->primitive_count; ++k) {
            psplat_writer_open(json, NULL, '{');
            write_accessor(json, view + attribute_count(s), s->primitives[k].first * bytes,
                           bytes == 2 ? PSPLAT_TYPE_UNSIGNED_SHORT : UNSIGNED_INT,
                           s->primitives[k].count, "SCALAR");
            psplat_writer_close(json, '}');
        }
    }
}

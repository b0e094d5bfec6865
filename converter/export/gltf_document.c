/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * gltf_document.c - the JSON of a glTF file of splats (spec 3), without values that are glTF's
 * defaults. Accessors are in the order of primitives and, within each, in that of attributes.
 */
#include "export/gltf_document.h"

#include "base/json_writer.h"
#include "export/animation_file.h"
#include "export/buffer_layout.h"
#include "export/fallback_mesh_file.h"
#include "export/graph_json.h"
#include "export/material_json.h"
#include "export/mesh_levels.h"
#include "export/splat_attributes.h"
#include "material/image.h"
#include "scene/scene.h"
#include "splats/splats.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char meshopt[] = "EXT_meshopt_compression", gaussian[] = "KHR_gaussian_splatting";

size_t psplat_buffer_view_bytes(const psplat_buffer_view *view) {
    return ((view->packed ? view->packed_size : view->rows * view->stride) + 3) / 4 * 4;
}

/* Returns the index of the first view of animations. */
static size_t animation_view(const psplat_buffer_layout *layout) {
    return layout->view_count + (layout->fallbacks ? layout->fallbacks->view_count : 0);
}

size_t psplat_document_view_count(const psplat_buffer_layout *layout) {
    return animation_view(layout) + (layout->animations ? layout->animations->view_count : 0);
}

const psplat_buffer_view *psplat_document_view(const psplat_buffer_layout *layout, size_t index) {
    size_t animations = animation_view(layout);
    if (index < layout->view_count) return &layout->views[index];
    return index < animations ? &layout->fallbacks->views[index - layout->view_count]
                              : &layout->animations->views[index - animations];
}

size_t psplat_image_view_bytes(const psplat_image *image) {
    return (image->size + 3) / 4 * 4;
}

static int is_packed(const psplat_buffer_layout *layout) {
    for (size_t i = 0; i < psplat_document_view_count(layout); ++i)
        if (psplat_document_view(layout, i)->packed) return 1;
    return 0;
}

static int is_quantized(const psplat_buffer_layout *layout) {
    for (size_t i = 0; i < layout->mesh_count; ++i)
        if (layout->tables[i].codes) return 1;
    return 0;
}

static int has_gaussians(const psplat_buffer_layout *layout) {
    for (size_t i = 0; i < layout->mesh_count; ++i)
        if (layout->tables[i].gaussians) return 1;
    return 0;
}

/* ---- primitives ----------------------------------------------------------------------------- */

static void add_attributes(psplat_writer *json, const psplat_primitive_layout *primitive,
                           size_t *accessor) {
    psplat_writer_open(json, "attributes", '{');
    for (size_t i = 0; i < PSPLAT_ATTRIBUTE_KINDS; ++i)
        if (primitive->formats[i].components)
            psplat_writer_count(json, psplat_attribute_names[i], (*accessor)++);
    psplat_writer_close(json, '}');
}

static void add_kernel(psplat_writer *json, const psplat_kernel *kernel) {
    if (kernel->sharpness == PSPLAT_DEFAULT_KERNEL_SHARPNESS &&
        kernel->exponent == PSPLAT_DEFAULT_KERNEL_EXPONENT)
        return;
    psplat_writer_open(json, "kernel", '{');
    psplat_writer_float(json, "sharpness", kernel->sharpness);
    psplat_writer_float(json, "exponent", kernel->exponent);
    psplat_writer_close(json, '}');
}

static int has_integers(const psplat_primitive_layout *primitive, size_t kind) {
    return primitive->formats[kind].components &&
           primitive->formats[kind].type != PSPLAT_TYPE_FLOAT;
}

static int has_bends(const psplat_primitive_layout *primitive) {
    for (size_t kind = PSPLAT_ATTRIBUTE_LINE; psplat_attribute_is_clip_line(kind); ++kind) {
        const psplat_attribute_format *format = &primitive->formats[kind];
        if (format->components > (format->type == PSPLAT_TYPE_FLOAT ? 3u : 2u)) return 1;
    }
    return 0;
}

/* Writes the ranges of those attributes that are integers (spec 3.9). */
static void add_ranges(psplat_writer *json, const psplat_attribute_table *table,
                       const psplat_primitive_layout *primitive) {
    psplat_quantization_ranges ranges;
    psplat_attribute_table_ranges(table, &ranges);
    if (has_integers(primitive, PSPLAT_ATTRIBUTE_SCALE))
        psplat_writer_floats(json, "scaleRange", ranges.scale, 2);
    if (has_integers(primitive, PSPLAT_ATTRIBUTE_TURN))
        psplat_writer_float(json, "turnRange", ranges.turn);
    if (has_integers(primitive, PSPLAT_ATTRIBUTE_TILT))
        psplat_writer_float(json, "tiltRange", ranges.tilt);
    if (has_integers(primitive, PSPLAT_ATTRIBUTE_SURFACE_TILT))
        psplat_writer_float(json, "tiltRange", ranges.surface_tilt);
    if (has_integers(primitive, PSPLAT_ATTRIBUTE_FIELD))
        psplat_writer_float(json, "fieldRange", ranges.field);
    if (has_integers(primitive, PSPLAT_ATTRIBUTE_SURFACE_FIELD))
        psplat_writer_float(json, "fieldRange", ranges.shape);
    if (has_integers(primitive, PSPLAT_ATTRIBUTE_SHAPE))
        psplat_writer_float(json, "shapeRange", ranges.shape);
    if (has_integers(primitive, PSPLAT_ATTRIBUTE_LINE))
        psplat_writer_floats(json, "clipRange", ranges.clip, 2);
    if (has_integers(primitive, PSPLAT_ATTRIBUTE_LINE) && has_bends(primitive))
        psplat_writer_float(json, "bendRange", ranges.bend);
    if (has_integers(primitive, PSPLAT_ATTRIBUTE_COLOR_U))
        psplat_writer_float(json, "colorRange", ranges.color);
    if (has_integers(primitive, PSPLAT_ATTRIBUTE_TEXCOORD_U))
        psplat_writer_float(json, "texcoordRange", ranges.texcoord);
    if (has_integers(primitive, PSPLAT_ATTRIBUTE_TEXCOORD_UU))
        psplat_writer_float(json, "texcoordBendRange", ranges.texcoord_bend);
}

static const psplat_fallback_table *fallback_of(const psplat_buffer_layout *layout, size_t mesh) {
    const psplat_fallback_table *table =
        layout->fallbacks && mesh < layout->finest_count ? &layout->fallbacks->tables[mesh] : NULL;
    return table && table->fallback ? table : NULL;
}

/* Returns the lowest version of the extension that has all that the primitive has, so that older
 * readers accept it. */
static size_t version_of(const psplat_buffer_layout *layout,
                         const psplat_primitive_layout *primitive) {
    int more = layout->tables[primitive->mesh].codes || fallback_of(layout, primitive->mesh);
    for (size_t i = PSPLAT_ATTRIBUTE_COLOR_U; i < PSPLAT_ATTRIBUTE_GAUSSIAN_ROTATION; ++i)
        more |= primitive->formats[i].components > 0;
    if (primitive->is_streamed) return 4;
    return primitive->is_curved || has_bends(primitive) || primitive->has_texcoord ? 3
           : more                                                                  ? 2
                                                                                   : 1;
}

/* Returns the index in the file of a mesh that has splats: as many before it have some. */
static size_t written_index(const psplat_buffer_layout *layout, size_t mesh) {
    size_t count = 0;
    for (size_t i = 0; i < mesh; ++i) count += layout->tables[i].splats->count > 0;
    return count;
}

/* The part of a step of positions by which shorter numbers of a node may move all of its splats,
 * and the part of lengths by which they may stretch them: half a bit of a float. What is proven of
 * splats has a hundredth of the tolerance to spare, and a step is at most half of the tolerance. */
static const double moved_part = 1.0 / 1024, stretched_part = 0x1p-25;

/* Returns the number of the fewest digits that differs by no more than that. */
static double shortened(double value, double difference) {
    char digits[40];
    double number = value;
    for (int precision = 0; precision <= 16; ++precision) {
        snprintf(digits, sizeof digits, "%.*e", precision, value);
        number = strtod(digits, NULL);
        if (fabs(number - value) <= difference) break;
    }
    return number;
}

/* Returns the transform from the coordinates in which a mesh's splats are stored to its own. Digits
 * that move no splat by what matters would be bytes for nothing. */
static psplat_dequantize_transform placement_of(const psplat_attribute_table *table,
                                                uint32_t low_bits) {
    psplat_dequantize_transform placement = {{0, 0, 0}, 1};
    const psplat_splats *splats = table->splats;
    double unit = splats->precision.unit;
    for (int k = 0; k < 3; ++k) placement.translation[k] = splats->origin[k];
    if (!table->codes) return placement;
    double scale = unit * (double)(1u << low_bits);
    placement.scale = shortened(scale, stretched_part * scale);
    for (int k = 0; k < 3; ++k)
        placement.translation[k] =
            shortened(splats->origin[k] + table->low[k] * unit, moved_part * unit);
    return placement;
}

/* Writes where the coordinates of a coarser level are in those of the finest. */
static void add_level_place(psplat_writer *json, const psplat_dequantize_transform *finest,
                            const psplat_dequantize_transform *coarser) {
    double translation[3];
    int is_moved = 0;
    for (int k = 0; k < 3; ++k) {
        translation[k] = (coarser->translation[k] - finest->translation[k]) / finest->scale;
        is_moved |= translation[k] != 0;
    }
    if (coarser->scale != finest->scale)
        psplat_writer_number(json, "scale", coarser->scale / finest->scale);
    if (is_moved) psplat_writer_numbers(json, "translation", translation, 3);
}

/* Rounds an error up to four digits, so that what is proven stays so. As a float it is written as
 * these digits. */
static float rounded_up(double error) {
    if (!(error > 0)) return 0;
    double digit = pow(10, floor(log10(error)) - 3);
    return (float)(ceil(error / digit * (1 - 1e-12)) * digit);
}

/* Writes the levels of detail of a mesh (spec 3.13). */
static void add_levels(psplat_writer *json, const psplat_buffer_layout *layout, size_t mesh) {
    const psplat_mesh_levels *levels = &layout->levels[mesh];
    psplat_dequantize_transform finest = placement_of(&layout->tables[mesh], layout->low_bits);
    psplat_writer_open(json, "levels", '[');
    for (size_t i = 0; i < levels->count; ++i) {
        const psplat_mesh_level_splats *level = &levels->list[i];
        psplat_writer_open(json, NULL, '{');
        if (i) {
            size_t coarser =
                psplat_leveled_scene_mesh(layout->levels, layout->finest_count, mesh, i);
            psplat_dequantize_transform place =
                placement_of(&layout->tables[coarser], layout->low_bits);
            psplat_writer_count(json, "mesh", written_index(layout, coarser));
            add_level_place(json, &finest, &place);
        }
        psplat_writer_float(json, "distance", rounded_up(level->distance / finest.scale));
        psplat_writer_float(json, "normal", rounded_up(level->normal));
        psplat_writer_float(json, "outline", rounded_up(level->outline / finest.scale));
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

/* Returns whether a primitive is the first of a mesh with levels, which states them. */
static int states_levels(const psplat_buffer_layout *layout,
                         const psplat_primitive_layout *primitive) {
    return layout->levels && primitive->mesh < layout->finest_count &&
           layout->levels[primitive->mesh].count > 1 &&
           (primitive == layout->primitives || primitive[-1].mesh != primitive->mesh);
}

/* States which lines are seams: a number, or one for each section of a stream. */
static void add_seams(psplat_writer *json, const psplat_primitive_layout *primitive) {
    size_t most = primitive->is_streamed ? 0 : primitive->seam_lines;
    for (size_t i = 0; i < primitive->section_count; ++i)
        if (primitive->section_seams[i] > most) most = primitive->section_seams[i];
    if (!most) return;
    if (!primitive->is_streamed) {
        psplat_writer_count(json, "seamLines", primitive->seam_lines);
        return;
    }
    psplat_writer_open(json, "seamLines", '[');
    for (size_t i = 0; i < primitive->section_count; ++i)
        psplat_writer_count(json, NULL, primitive->section_seams[i]);
    psplat_writer_close(json, ']');
}

static void add_splat_extension(psplat_writer *json, const psplat_buffer_layout *layout,
                                const psplat_primitive_layout *primitive) {
    const psplat_attribute_table *table = &layout->tables[primitive->mesh];
    float low[3], high[3], extent[3];
    double unit = table->codes ? table->splats->precision.unit : 1;
    psplat_buffer_layout_extent(layout, primitive, low, high);
    for (size_t i = 0; i < 3; ++i) extent[i] = (float)((double)high[i] - (double)low[i]);
    psplat_writer_open(json, "PSPLAT_surface_splats", '{');
    psplat_writer_count(json, "version", version_of(layout, primitive));
    if (primitive->is_streamed) {
        psplat_writer_count(json, "stream", primitive->stream);
        add_seams(json, primitive);
        add_ranges(json, table, primitive);
        if (states_levels(layout, primitive)) add_levels(json, layout, primitive->mesh);
        psplat_writer_close(json, '}');
        return;
    }
    psplat_writer_count(json, "clipLines", primitive->clip_lines);
    add_seams(json, primitive);
    psplat_writer_float(json, "depthTolerance", (float)((double)primitive->depth_tolerance / unit));
    psplat_writer_floats(json, "positionExtent", extent, 3);
    if (primitive->is_curved) psplat_writer_boolean(json, "curved", 1);
    add_ranges(json, table, primitive);
    add_kernel(json, &table->splats->kernel);
    if (states_levels(layout, primitive)) add_levels(json, layout, primitive->mesh);
    psplat_writer_close(json, '}');
}

/* Writes the extension object of the Gaussians, whose colours are not lit but shown as stored. */
static void add_gaussian_extension(psplat_writer *json) {
    psplat_writer_open(json, gaussian, '{');
    psplat_writer_string(json, "kernel", "ellipse");
    psplat_writer_string(json, "colorSpace", "srgb_rec709_display");
    psplat_writer_close(json, '}');
}

static void add_primitive(psplat_writer *json, const psplat_buffer_layout *layout, size_t index,
                          const psplat_scene *scene, const psplat_materials *materials,
                          size_t *accessor) {
    const psplat_primitive_layout *primitive = &layout->primitives[index];
    uint32_t material =
        psplat_materials_index(materials, scene, layout->tables[primitive->mesh].splats,
                               primitive->material, primitive->has_texcoord);
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "mode", 0);
    add_attributes(json, primitive, accessor);
    if (material != PSPLAT_NO_INDEX) psplat_writer_count(json, "material", material);
    psplat_writer_open(json, "extensions", '{');
    add_splat_extension(json, layout, primitive);
    if (layout->tables[primitive->mesh].gaussians) add_gaussian_extension(json);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
}

static void add_fallback_meshes(psplat_writer *json, const psplat_scene *scene,
                                const psplat_buffer_layout *layout,
                                const psplat_materials *materials, size_t accessor) {
    size_t splat_mesh = 0;
    for (size_t mesh = 0; mesh < layout->mesh_count; ++mesh) {
        const psplat_scene_mesh *from = &scene->meshes[mesh];
        const psplat_fallback_table *table = fallback_of(layout, mesh);
        if (table) {
            psplat_writer_open(json, NULL, '{');
            if (from->name) psplat_writer_string(json, "name", from->name);
            psplat_fallback_file_write_mesh(json, table, scene, materials, accessor,
                                            layout->tables[mesh].splats->count ? splat_mesh
                                                                               : PSPLAT_NO_INDEX);
            if (from->extras) psplat_writer_raw(json, "extras", from->extras);
            psplat_writer_close(json, '}');
        }
        splat_mesh += layout->tables[mesh].splats->count > 0;
    }
}

/* Writes the meshes that have splats, then the fallback meshes. */
static void add_meshes(psplat_writer *json, const psplat_scene *scene,
                       const psplat_buffer_layout *layout, const psplat_materials *materials) {
    size_t accessor = 0, primitive = 0;
    psplat_writer_open(json, "meshes", '[');
    for (size_t mesh = 0; mesh < layout->mesh_count; ++mesh) {
        const psplat_scene_mesh *from = &scene->meshes[mesh];
        if (primitive == layout->primitive_count || layout->primitives[primitive].mesh != mesh)
            continue;
        psplat_writer_open(json, NULL, '{');
        /* The node of a scene that was made for one mesh has its name. */
        if (from->name && !scene->is_made) psplat_writer_string(json, "name", from->name);
        psplat_writer_open(json, "primitives", '[');
        for (; primitive < layout->primitive_count && layout->primitives[primitive].mesh == mesh;
             ++primitive)
            add_primitive(json, layout, primitive, scene, materials, &accessor);
        psplat_writer_close(json, ']');
        if (from->extras && !fallback_of(layout, mesh))
            psplat_writer_raw(json, "extras", from->extras);
        psplat_writer_close(json, '}');
    }
    add_fallback_meshes(json, scene, layout, materials, accessor);
    psplat_writer_close(json, ']');
}

/* ---- accessors and views -------------------------------------------------------------------- */

static void add_accessor(psplat_writer *json, const psplat_buffer_layout *layout,
                         const psplat_primitive_layout *primitive, size_t kind) {
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    const psplat_attribute_format *format = &primitive->formats[kind];
    const psplat_attribute_place *place = &primitive->places[kind];
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "bufferView", place->view);
    if (place->offset) psplat_writer_count(json, "byteOffset", place->offset);
    psplat_writer_count(json, "componentType", (size_t)format->type);
    if (psplat_attribute_is_normalized(format, kind)) psplat_writer_boolean(json, "normalized", 1);
    psplat_writer_count(json, "count", primitive->count);
    psplat_writer_string(json, "type", types[format->components]);
    if (kind == PSPLAT_ATTRIBUTE_POSITION) {
        float low[3], high[3];
        psplat_buffer_layout_extent(layout, primitive, low, high);
        psplat_writer_floats(json, "min", low, 3);
        psplat_writer_floats(json, "max", high, 3);
    }
    psplat_writer_close(json, '}');
}

static void add_accessors(psplat_writer *json, const psplat_scene *scene,
                          const psplat_buffer_layout *layout) {
    psplat_writer_open(json, "accessors", '[');
    for (size_t i = 0; i < layout->primitive_count; ++i)
        for (size_t kind = 0; kind < PSPLAT_ATTRIBUTE_KINDS; ++kind)
            if (layout->primitives[i].formats[kind].components)
                add_accessor(json, layout, &layout->primitives[i], kind);
    if (layout->fallbacks)
        psplat_fallback_file_write_accessors(json, layout->fallbacks, layout->view_count);
    if (layout->animations)
        psplat_animation_file_write_accessors(json, layout->animations, scene,
                                              animation_view(layout));
    psplat_writer_close(json, ']');
}

/* Returns the index of the first accessor of animations. */
static size_t animation_accessor(const psplat_buffer_layout *layout) {
    size_t count = layout->fallbacks ? layout->fallbacks->accessor_count : 0;
    for (size_t i = 0; i < layout->primitive_count; ++i)
        for (size_t kind = 0; kind < PSPLAT_ATTRIBUTE_KINDS; ++kind)
            count += layout->primitives[i].formats[kind].components > 0;
    return count;
}

static void add_place(psplat_writer *json, size_t buffer, size_t offset, size_t bytes,
                      size_t stride) {
    psplat_writer_count(json, "buffer", buffer);
    if (offset) psplat_writer_count(json, "byteOffset", offset);
    psplat_writer_count(json, "byteLength", bytes);
    if (stride) psplat_writer_count(json, "byteStride", stride);
}

/* Writes a buffer view. EXT_meshopt_compression wants a compressed view to say where its bytes
 * would be in a second buffer, which is not stored. */
static void add_view(psplat_writer *json, const psplat_buffer_view *view, size_t offset,
                     size_t unpacked_offset) {
    enum { ARRAY_BUFFER = 34962, ELEMENT_ARRAY_BUFFER };
    static const char *const filters[] = {
        [PSPLAT_FILTER_OCTAHEDRAL] = "OCTAHEDRAL", [PSPLAT_FILTER_EXPONENTIAL] = "EXPONENTIAL"};
    size_t bytes = view->rows * view->stride;
    int is_vertices = view->kind == PSPLAT_VIEW_VERTICES,
        is_index = view->kind == PSPLAT_VIEW_INDICES;
    size_t stride = is_vertices ? view->stride : 0;
    psplat_writer_open(json, NULL, '{');
    if (view->packed)
        add_place(json, 1, unpacked_offset, bytes, stride);
    else
        add_place(json, 0, offset, bytes, stride);
    if (is_vertices || is_index)
        psplat_writer_count(json, "target", is_index ? ELEMENT_ARRAY_BUFFER : ARRAY_BUFFER);
    if (view->packed) {
        psplat_writer_open(json, "extensions", '{');
        psplat_writer_open(json, meshopt, '{');
        add_place(json, 0, offset, view->packed_size, view->stride);
        psplat_writer_string(json, "mode", is_index ? "TRIANGLES" : "ATTRIBUTES");
        psplat_writer_count(json, "count", view->rows);
        if (view->filter) psplat_writer_string(json, "filter", filters[view->filter]);
        psplat_writer_close(json, '}');
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, '}');
}

/* Writes a buffer view of an image, which nothing compresses. */
static void add_image_view(psplat_writer *json, const psplat_image *image, size_t offset) {
    psplat_writer_open(json, NULL, '{');
    add_place(json, 0, offset, image->size, 0);
    psplat_writer_close(json, '}');
}

static void add_views(psplat_writer *json, const psplat_scene *scene,
                      const psplat_buffer_layout *layout, const psplat_materials *materials) {
    size_t offset = 0, unpacked = 0;
    psplat_writer_open(json, "bufferViews", '[');
    for (size_t i = 0; i < psplat_document_view_count(layout); ++i) {
        const psplat_buffer_view *view = psplat_document_view(layout, i);
        add_view(json, view, offset, unpacked);
        offset += psplat_buffer_view_bytes(view);
        if (view->packed) unpacked += (view->rows * view->stride + 3) / 4 * 4;
    }
    for (size_t i = 0; i < materials->image_count; ++i) {
        const psplat_image *image = &scene->materials.images[materials->images[i]];
        add_image_view(json, image, offset);
        offset += psplat_image_view_bytes(image);
    }
    psplat_writer_close(json, ']');
    psplat_writer_open(json, "buffers", '[');
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "byteLength", offset);
    psplat_writer_close(json, '}');
    if (is_packed(layout)) {
        psplat_writer_open(json, NULL, '{');
        psplat_writer_count(json, "byteLength", unpacked);
        psplat_writer_open(json, "extensions", '{');
        psplat_writer_open(json, meshopt, '{');
        psplat_writer_boolean(json, "fallback", 1);
        psplat_writer_close(json, '}');
        psplat_writer_close(json, '}');
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

/* ---- the rest -------------------------------------------------------------------------------- */

/* Writes nodes and scenes. A node shows the fallback mesh, which refers to its splats, where there
 * is one. Returns 0 where memory ran out. */
static int add_graph(psplat_writer *json, const psplat_scene *scene,
                     const psplat_buffer_layout *layout) {
    size_t count = layout->mesh_count;
    psplat_dequantize_transform *placements = malloc((count + 1) * sizeof *placements);
    uint32_t *meshes = malloc((count + 1) * sizeof *meshes), written = 0;
    uint32_t fallback = (uint32_t)written_index(layout, count);
    for (size_t i = 0; i < count && placements && meshes; ++i) {
        placements[i] = placement_of(&layout->tables[i], layout->low_bits);
        meshes[i] = layout->tables[i].splats->count ? written++ : PSPLAT_NO_INDEX;
        if (fallback_of(layout, i)) meshes[i] = fallback++;
    }
    if (placements && meshes) psplat_graph_write(json, scene, placements, meshes);
    int is_written = placements && meshes;
    free(placements);
    free(meshes);
    return is_written;
}

static void add_extensions(psplat_writer *json, const psplat_scene *scene,
                           const psplat_buffer_layout *layout, const psplat_materials *materials) {
    int quantized = is_quantized(layout), packed = is_packed(layout);
    psplat_writer_open(json, "extensionsUsed", '[');
    if (layout->primitive_count) psplat_writer_string(json, NULL, "PSPLAT_surface_splats");
    if (quantized) psplat_writer_string(json, NULL, "KHR_mesh_quantization");
    if (packed) psplat_writer_string(json, NULL, meshopt);
    if (has_gaussians(layout)) psplat_writer_string(json, NULL, gaussian);
    psplat_materials_write_extensions(json, materials);
    if (scene->light_count) psplat_writer_string(json, NULL, "KHR_lights_punctual");
    psplat_writer_close(json, ']');
    if (!quantized && !packed) return;
    psplat_writer_open(json, "extensionsRequired", '[');
    if (quantized) psplat_writer_string(json, NULL, "KHR_mesh_quantization");
    if (packed) psplat_writer_string(json, NULL, meshopt);
    psplat_writer_close(json, ']');
}

static void add_asset(psplat_writer *json, const psplat_scene *scene) {
    psplat_writer_open(json, "asset", '{');
    psplat_writer_string(json, "version", "2.0");
    psplat_writer_string(json, "generator", "phongsplat 0.1.0");
    psplat_graph_write_asset(json, scene);
    psplat_writer_close(json, '}');
}

/* Fails where the file of an image that materials use is not known. */
static psplat_result check_images(const psplat_scene *scene, const psplat_materials *materials,
                                  psplat_error *error) {
    for (size_t i = 0; i < materials->image_count; ++i) {
        uint32_t image = materials->images[i];
        if (image >= scene->materials.image_count || !scene->materials.images[image].bytes)
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                               "a material has a texture of image %u, which the scene has not",
                               (unsigned)image);
    }
    return PSPLAT_OK;
}

psplat_result psplat_document_materials(const psplat_scene *scene,
                                        const psplat_buffer_layout *layout,
                                        psplat_materials *materials, psplat_error *error) {
    psplat_result result = psplat_materials_collect(scene, layout->tables[0].splats, materials);
    for (size_t i = 0; i < layout->mesh_count; ++i)
        materials->has_splats |= layout->tables[i].splats->count > 0;
    if (!result && layout->fallbacks)
        result = psplat_fallback_file_collect(layout->fallbacks, scene, materials);
    if (result) return psplat_fail(error, result, 0, "no memory for the materials");
    return check_images(scene, materials, error);
}

int psplat_document_write(psplat_writer *json, const psplat_scene *scene,
                          const psplat_buffer_layout *layout, const psplat_materials *materials) {
    psplat_writer_open(json, NULL, '{');
    add_asset(json, scene);
    add_extensions(json, scene, layout, materials);
    int is_written = add_graph(json, scene, layout);
    if (scene->light_count) {
        psplat_writer_open(json, "extensions", '{');
        psplat_graph_write_lights(json, scene);
        psplat_writer_close(json, '}');
    }
    add_meshes(json, scene, layout, materials);
    psplat_animation_file_write(json, scene, animation_accessor(layout));
    psplat_materials_write(json, materials, scene, psplat_document_view_count(layout));
    add_accessors(json, scene, layout);
    add_views(json, scene, layout, materials);
    psplat_writer_close(json, '}');
    return psplat_writer_finish(json) && is_written;
}

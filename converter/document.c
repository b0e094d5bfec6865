/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * document.c - the JSON of a file of splats (spec 3): what glTF takes for granted is left out.
 * Accessors are in the order of primitives and, in each, of columns.
 */
#include "document.h"

#include "graph.h"
#include "stand_in_file.h"

#include <math.h>
#include <stdlib.h>

static const char meshopt[] = "EXT_meshopt_compression", gaussian[] = "KHR_gaussian_splatting";

size_t psplat_file_view_bytes(const psplat_file_view *view) {
    return ((view->packed ? view->packed_size : view->rows * view->stride) + 3) / 4 * 4;
}

size_t psplat_document_view_count(const psplat_layout *layout) {
    return layout->view_count + (layout->stand_ins ? layout->stand_ins->view_count : 0);
}

const psplat_file_view *psplat_document_view(const psplat_layout *layout, size_t index) {
    return index < layout->view_count ? &layout->views[index]
                                      : &layout->stand_ins->views[index - layout->view_count];
}

static int is_packed(const psplat_layout *layout) {
    return layout->view_count && layout->views[0].packed;
}

static int is_quantised(const psplat_layout *layout) {
    for (size_t i = 0; i < layout->mesh_count; ++i)
        if (layout->sheets[i].codes) return 1;
    return 0;
}

static int has_gaussians(const psplat_layout *layout) {
    for (size_t i = 0; i < layout->mesh_count; ++i)
        if (layout->sheets[i].gaussians) return 1;
    return 0;
}

/* ---- primitives ----------------------------------------------------------------------------- */

static void add_attributes(psplat_writer *json, const psplat_part *part, size_t *accessor) {
    psplat_writer_open(json, "attributes", '{');
    for (size_t i = 0; i < PSPLAT_COLUMNS; ++i)
        if (part->columns[i].components)
            psplat_writer_count(json, psplat_column_names[i], (*accessor)++);
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

static int has_integers(const psplat_part *part, size_t kind) {
    return part->columns[kind].components && part->columns[kind].type != PSPLAT_TYPE_FLOAT;
}

/* Spec 3.9. */
static void add_ranges(psplat_writer *json, const psplat_sheet *sheet, const psplat_part *part) {
    psplat_ranges ranges;
    psplat_sheet_ranges(sheet, &ranges);
    if (has_integers(part, PSPLAT_COLUMN_SCALE))
        psplat_writer_floats(json, "scaleRange", ranges.scale, 2);
    if (has_integers(part, PSPLAT_COLUMN_TURN)) psplat_writer_float(json, "turnRange", ranges.turn);
    if (has_integers(part, PSPLAT_COLUMN_TILT)) psplat_writer_float(json, "tiltRange", ranges.tilt);
    if (has_integers(part, PSPLAT_COLUMN_FIELD))
        psplat_writer_float(json, "fieldRange", ranges.field);
    if (has_integers(part, PSPLAT_COLUMN_LINE))
        psplat_writer_floats(json, "clipRange", ranges.clip, 2);
    if (has_integers(part, PSPLAT_COLUMN_COLOR_U))
        psplat_writer_float(json, "colorRange", ranges.color);
}

static const psplat_stand_in_sheet *stand_in_of(const psplat_layout *layout, size_t mesh) {
    const psplat_stand_in_sheet *sheet =
        layout->stand_ins ? &layout->stand_ins->sheets[mesh] : NULL;
    return sheet && sheet->stand_in ? sheet : NULL;
}

/* Version 1 suffices for what it has. */
static size_t version_of(const psplat_layout *layout, const psplat_part *part) {
    int more = layout->sheets[part->mesh].codes || stand_in_of(layout, part->mesh);
    for (size_t i = PSPLAT_COLUMN_COLOR_U; i < PSPLAT_COLUMN_GAUSSIAN_ROTATION; ++i)
        more |= part->columns[i].components > 0;
    return more ? 2 : 1;
}

/* Of all splats of a part together. */
static void extent_of(const psplat_sheet *sheet, const psplat_part *part, float low[3],
                      float high[3]) {
    int any = 0;
    for (size_t class = 0; class <= PSPLAT_MAX_CLIP_LINES; ++class) {
        float from[3], to[3];
        if (!part->counts[class]) continue;
        psplat_sheet_extent(sheet, part->first[class], part->counts[class], from, to);
        for (int k = 0; k < 3; ++k) {
            low[k] = any ? fminf(low[k], from[k]) : from[k];
            high[k] = any ? fmaxf(high[k], to[k]) : to[k];
        }
        any = 1;
    }
}

static void add_object(psplat_writer *json, const psplat_layout *layout, const psplat_part *part) {
    const psplat_sheet *sheet = &layout->sheets[part->mesh];
    float low[3], high[3], extent[3];
    double unit = sheet->codes ? sheet->splats->precision.unit : 1;
    extent_of(sheet, part, low, high);
    for (size_t i = 0; i < 3; ++i) extent[i] = (float)((double)high[i] - (double)low[i]);
    psplat_writer_open(json, "PSPLAT_surface_splats", '{');
    psplat_writer_count(json, "version", version_of(layout, part));
    psplat_writer_count(json, "clipLines", part->clip_lines);
    psplat_writer_float(json, "depthTolerance", (float)((double)part->depth_tolerance / unit));
    psplat_writer_floats(json, "positionExtent", extent, 3);
    add_ranges(json, sheet, part);
    add_kernel(json, &sheet->splats->kernel);
    psplat_writer_close(json, '}');
}

/* The Gaussians' colours are as they are shown. */
static void add_gaussian(psplat_writer *json) {
    psplat_writer_open(json, gaussian, '{');
    psplat_writer_string(json, "kernel", "ellipse");
    psplat_writer_string(json, "colorSpace", "srgb_rec709_display");
    psplat_writer_close(json, '}');
}

static void add_primitive(psplat_writer *json, const psplat_layout *layout, size_t index,
                          const psplat_scene *scene, const psplat_materials *materials,
                          size_t *accessor) {
    const psplat_part *part = &layout->parts[index];
    uint32_t material =
        psplat_materials_index(materials, scene, layout->sheets[part->mesh].splats, part->material);
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "mode", 0);
    add_attributes(json, part, accessor);
    if (material != PSPLAT_NO_INDEX) psplat_writer_count(json, "material", material);
    psplat_writer_open(json, "extensions", '{');
    add_object(json, layout, part);
    if (layout->sheets[part->mesh].gaussians) add_gaussian(json);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
}

/* How many meshes have splats: those of them that stand in follow. */
static size_t count_splat_meshes(const psplat_layout *layout) {
    size_t count = 0;
    for (size_t i = 0; i < layout->mesh_count; ++i) count += layout->sheets[i].splats->count > 0;
    return count;
}

static void add_stand_ins(psplat_writer *json, const psplat_scene *scene,
                          const psplat_layout *layout, const psplat_materials *materials,
                          size_t accessor) {
    size_t splat_mesh = 0;
    for (size_t mesh = 0; mesh < layout->mesh_count; ++mesh) {
        const psplat_scene_mesh *from = &scene->meshes[mesh];
        const psplat_stand_in_sheet *sheet = stand_in_of(layout, mesh);
        if (sheet) {
            psplat_writer_open(json, NULL, '{');
            if (from->name) psplat_writer_string(json, "name", from->name);
            psplat_stand_in_file_write_mesh(json, sheet, scene, materials, accessor, splat_mesh);
            if (from->extras) psplat_writer_raw(json, "extras", from->extras);
            psplat_writer_close(json, '}');
        }
        splat_mesh += layout->sheets[mesh].splats->count > 0;
    }
}

/* Meshes without splats are none. */
static void add_meshes(psplat_writer *json, const psplat_scene *scene, const psplat_layout *layout,
                       const psplat_materials *materials) {
    size_t accessor = 0, part = 0;
    psplat_writer_open(json, "meshes", '[');
    for (size_t mesh = 0; mesh < layout->mesh_count; ++mesh) {
        const psplat_scene_mesh *from = &scene->meshes[mesh];
        if (part == layout->part_count || layout->parts[part].mesh != mesh) continue;
        psplat_writer_open(json, NULL, '{');
        if (from->name) psplat_writer_string(json, "name", from->name);
        psplat_writer_open(json, "primitives", '[');
        for (; part < layout->part_count && layout->parts[part].mesh == mesh; ++part)
            add_primitive(json, layout, part, scene, materials, &accessor);
        psplat_writer_close(json, ']');
        if (from->extras && !stand_in_of(layout, mesh))
            psplat_writer_raw(json, "extras", from->extras);
        psplat_writer_close(json, '}');
    }
    add_stand_ins(json, scene, layout, materials, accessor);
    psplat_writer_close(json, ']');
}

/* ---- accessors and views -------------------------------------------------------------------- */

static void add_accessor(psplat_writer *json, const psplat_layout *layout, const psplat_part *part,
                         size_t kind) {
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    const psplat_column *column = &part->columns[kind];
    const psplat_place_in_view *place = &part->places[kind];
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "bufferView", place->view);
    if (place->offset) psplat_writer_count(json, "byteOffset", place->offset);
    psplat_writer_count(json, "componentType", (size_t)column->type);
    if (psplat_column_is_normalized(column, kind)) psplat_writer_boolean(json, "normalized", 1);
    psplat_writer_count(json, "count", part->count);
    psplat_writer_string(json, "type", types[column->components]);
    if (kind == PSPLAT_COLUMN_POSITION) {
        float low[3], high[3];
        extent_of(&layout->sheets[part->mesh], part, low, high);
        psplat_writer_floats(json, "min", low, 3);
        psplat_writer_floats(json, "max", high, 3);
    }
    psplat_writer_close(json, '}');
}

static void add_accessors(psplat_writer *json, const psplat_layout *layout) {
    psplat_writer_open(json, "accessors", '[');
    for (size_t i = 0; i < layout->part_count; ++i)
        for (size_t kind = 0; kind < PSPLAT_COLUMNS; ++kind)
            if (layout->parts[i].columns[kind].components)
                add_accessor(json, layout, &layout->parts[i], kind);
    if (layout->stand_ins)
        psplat_stand_in_file_write_accessors(json, layout->stand_ins, layout->view_count);
    psplat_writer_close(json, ']');
}

static void add_place(psplat_writer *json, size_t buffer, size_t offset, size_t bytes,
                      size_t stride) {
    psplat_writer_count(json, "buffer", buffer);
    if (offset) psplat_writer_count(json, "byteOffset", offset);
    psplat_writer_count(json, "byteLength", bytes);
    if (stride) psplat_writer_count(json, "byteStride", stride);
}

/* A packed view says where it would be in a buffer that nobody stores. */
static void add_view(psplat_writer *json, const psplat_file_view *view, size_t offset,
                     size_t unpacked_offset) {
    enum { ARRAY_BUFFER = 34962, ELEMENT_ARRAY_BUFFER };
    size_t bytes = view->rows * view->stride, stride = view->is_index ? 0 : view->stride;
    psplat_writer_open(json, NULL, '{');
    if (view->packed)
        add_place(json, 1, unpacked_offset, bytes, stride);
    else
        add_place(json, 0, offset, bytes, stride);
    psplat_writer_count(json, "target", view->is_index ? ELEMENT_ARRAY_BUFFER : ARRAY_BUFFER);
    if (view->packed) {
        psplat_writer_open(json, "extensions", '{');
        psplat_writer_open(json, meshopt, '{');
        add_place(json, 0, offset, view->packed_size, view->stride);
        psplat_writer_string(json, "mode", view->is_index ? "TRIANGLES" : "ATTRIBUTES");
        psplat_writer_count(json, "count", view->rows);
        if (view->is_octahedral) psplat_writer_string(json, "filter", "OCTAHEDRAL");
        psplat_writer_close(json, '}');
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, '}');
}

static void add_views(psplat_writer *json, const psplat_layout *layout) {
    size_t offset = 0, unpacked = 0;
    psplat_writer_open(json, "bufferViews", '[');
    for (size_t i = 0; i < psplat_document_view_count(layout); ++i) {
        const psplat_file_view *view = psplat_document_view(layout, i);
        add_view(json, view, offset, unpacked);
        offset += psplat_file_view_bytes(view);
        unpacked += (view->rows * view->stride + 3) / 4 * 4;
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

static psplat_placement placement_of(const psplat_sheet *sheet) {
    psplat_placement placement = {{0, 0, 0}, 1};
    const psplat_splats *splats = sheet->splats;
    if (sheet->codes) placement.scale = splats->precision.unit;
    for (int k = 0; k < 3; ++k)
        placement.translation[k] =
            splats->origin[k] + (sheet->codes ? sheet->low[k] * placement.scale : 0);
    return placement;
}

/* Returns 0 where memory ran out. */
static int add_graph(psplat_writer *json, const psplat_scene *scene, const psplat_layout *layout) {
    size_t count = layout->mesh_count;
    psplat_placement *placements = malloc((count + 1) * sizeof *placements);
    uint32_t *meshes = malloc((count + 1) * sizeof *meshes), written = 0;
    uint32_t stand_in = (uint32_t)count_splat_meshes(layout);
    for (size_t i = 0; i < count && placements && meshes; ++i) {
        placements[i] = placement_of(&layout->sheets[i]);
        meshes[i] = layout->sheets[i].splats->count ? written++ : PSPLAT_NO_INDEX;
        if (stand_in_of(layout, i)) meshes[i] = stand_in++;
    }
    if (placements && meshes) psplat_graph_write(json, scene, placements, meshes);
    int is_written = placements && meshes;
    free(placements);
    free(meshes);
    return is_written;
}

static void add_extensions(psplat_writer *json, const psplat_scene *scene,
                           const psplat_layout *layout, const psplat_materials *materials) {
    int quantised = is_quantised(layout), packed = is_packed(layout);
    psplat_writer_open(json, "extensionsUsed", '[');
    psplat_writer_string(json, NULL, "PSPLAT_surface_splats");
    if (quantised) psplat_writer_string(json, NULL, "KHR_mesh_quantization");
    if (packed) psplat_writer_string(json, NULL, meshopt);
    if (has_gaussians(layout)) psplat_writer_string(json, NULL, gaussian);
    psplat_materials_write_extensions(json, materials);
    if (scene->light_count) psplat_writer_string(json, NULL, "KHR_lights_punctual");
    psplat_writer_close(json, ']');
    if (!quantised && !packed) return;
    psplat_writer_open(json, "extensionsRequired", '[');
    if (quantised) psplat_writer_string(json, NULL, "KHR_mesh_quantization");
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

/* Sets of splats of all meshes lie one after another. */
int psplat_document_write(psplat_writer *json, const psplat_scene *scene,
                          const psplat_layout *layout) {
    psplat_materials materials;
    int is_written = !psplat_materials_collect(scene, layout->sheets[0].splats, &materials);
    if (is_written && layout->stand_ins)
        is_written = !psplat_stand_in_file_collect(layout->stand_ins, scene, &materials);
    if (is_written) {
        psplat_writer_open(json, NULL, '{');
        add_asset(json, scene);
        add_extensions(json, scene, layout, &materials);
        is_written = add_graph(json, scene, layout);
        if (scene->light_count) {
            psplat_writer_open(json, "extensions", '{');
            psplat_graph_write_lights(json, scene);
            psplat_writer_close(json, '}');
        }
        add_meshes(json, scene, layout, &materials);
        psplat_materials_write(json, &materials);
        add_accessors(json, layout);
        add_views(json, layout);
        psplat_writer_close(json, '}');
    }
    psplat_materials_free(&materials);
    return psplat_writer_finish(json) && is_written;
}

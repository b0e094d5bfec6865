/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * glb.c - splats to a complete GLB (spec 3): the graph of their scene, one primitive per run,
 * unclipped first (BSK04 section 4.1). Only what a model needs is written: no NORMAL_FIELD
 * where every gradient of a primitive is 0, no gamma where every one is, no COLOR_0 where the
 * colour is uniform, no glTF default. Equal splats give equal bytes, whatever the locale and the
 * machine's byte order.
 */
#include "graph.h"
#include "materials.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS = 10 };
enum { FLOAT = 5126, UNSIGNED_SHORT = 5123 };

/* One attribute: components floats of each splat, from byte offset on. Colours are written as
 * normalized unsigned shorts: half the bytes of floats at an error of 2^-17, less than a tenth of
 * the smallest step of the 8-bit sRGB colours that most meshes carry. Three shorts would save
 * nothing, glTF aligns elements to 4 bytes. */
typedef struct column {
    const char *name;
    size_t offset;
    size_t components;
    int type;
} column;

#define CLIP_COLUMN(k)                                                                             \
    {                                                                                              \
        "_PSPLAT_surface_splats:CLIP_" #k, offsetof(psplat_splat, clip) + (k)*3 * sizeof(float),   \
            3, FLOAT                                                                               \
    }

enum { POSITION_COLUMN = 0, COLOR_COLUMN = 2, FIELD_COLUMN = 5, FIRST_CLIP_COLUMN = 6 };

static const column columns[COLUMNS] = {
    {"POSITION", offsetof(psplat_splat, center), 3, FLOAT},
    {"NORMAL", offsetof(psplat_splat, normal), 3, FLOAT},
    {"COLOR_0", offsetof(psplat_splat, color), 4, UNSIGNED_SHORT},
    {"_PSPLAT_surface_splats:ROTATION", offsetof(psplat_splat, rotation), 4, FLOAT},
    {"_PSPLAT_surface_splats:SCALE", offsetof(psplat_splat, radius), 2, FLOAT},
    {"_PSPLAT_surface_splats:NORMAL_FIELD", offsetof(psplat_splat, gradient), 3, FLOAT},
    CLIP_COLUMN(0),
    CLIP_COLUMN(1),
    CLIP_COLUMN(2),
    CLIP_COLUMN(3),
};

/* One primitive. */
typedef struct run {
    const psplat_splats *set;
    const psplat_splat *splats;
    size_t count;
    size_t clip_lines;
    uint32_t material; /* in the file, or PSPLAT_NO_INDEX */
    float depth_tolerance;
    size_t components[COLUMNS]; /* that are written of each column; 0: the column is left out */
    size_t column_count;
    float min[3], max[3];
} run;

/* All that is written. */
typedef struct document {
    const psplat_scene *scene;
    const psplat_splats *splats; /* by mesh of the scene */
    run *runs;                   /* of all meshes, one after the other */
    size_t run_count;
    uint32_t *meshes;             /* by mesh of the scene: its index in the file */
    psplat_placement *placements; /* by mesh of the scene */
    psplat_materials materials;
} document;

/* ---- runs --------------------------------------------------------------------------------- */

/* alpha, beta and gamma, or the first two, or none. */
static size_t field_components(const run *r) {
    size_t components = 0;
    for (size_t i = 0; i < r->count; ++i) {
        const float *gradient = r->splats[i].gradient;
        if (gradient[2] != 0.0f) return 3;
        if (gradient[0] != 0.0f || gradient[1] != 0.0f) components = 2;
    }
    return components;
}

static size_t run_components(const run *r, size_t index, const psplat_splats *splats) {
    if (index == FIELD_COLUMN) return field_components(r);
    int used = 1;
    if (index == COLOR_COLUMN) used = splats->has_color;
    if (index >= FIRST_CLIP_COLUMN) used = index - FIRST_CLIP_COLUMN < r->clip_lines;
    return used ? columns[index].components : 0;
}

static void run_measure(run *r, const psplat_splats *splats) {
    for (size_t i = 0; i < COLUMNS; ++i) {
        r->components[i] = run_components(r, i, splats);
        r->column_count += r->components[i] > 0;
    }
    for (size_t axis = 0; axis < 3; ++axis) {
        r->min[axis] = r->max[axis] = r->splats[0].center[axis];
        for (size_t i = 1; i < r->count; ++i) {
            float value = r->splats[i].center[axis];
            if (value < r->min[axis]) r->min[axis] = value;
            if (value > r->max[axis]) r->max[axis] = value;
        }
    }
}

static size_t column_bytes(const run *r, size_t index) {
    return r->count * r->components[index] * (columns[index].type == FLOAT ? 4 : 2);
}

static size_t run_bytes(const run *r) {
    size_t bytes = 0;
    for (size_t i = 0; i < COLUMNS; ++i) bytes += column_bytes(r, i);
    return bytes;
}

/* JSON has no word for infinity or not-a-number, and a reader would refuse them anyway. */
static int all_finite(const float *values, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (!isfinite(values[i])) return 0;
    return 1;
}

static psplat_result check_runs(const psplat_splats *splats, psplat_error *error) {
    size_t index = 0;
    for (size_t r = 0; r < splats->run_count; ++r) {
        const psplat_run *run = &splats->runs[r];
        if (!run->count || run->material >= splats->material_count ||
            run->clip_lines > PSPLAT_MAX_CLIP_LINES)
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                               "run %zu is empty or has a material or lines that there are not", r);
        for (size_t i = 0; i < run->count; ++i, ++index)
            if (index >= splats->count || splats->splats[index].clip_count != run->clip_lines)
                return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                                   "splat %zu has not the %u clip lines of run %zu", index,
                                   (unsigned)run->clip_lines, r);
    }
    if (index == splats->count) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "runs add up to %zu of %zu splats", index,
                       splats->count);
}

static psplat_result check_splats(const psplat_splats *splats, psplat_error *error) {
    if (!splats->count) return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "no splats to write");
    psplat_result result = check_runs(splats, error);
    if (result) return result;
    for (size_t i = 0; i < splats->count; ++i)
        for (size_t c = 0; c < COLUMNS; ++c) {
            const char *splat = (const char *)&splats->splats[i];
            float values[4];
            memcpy(values, splat + columns[c].offset, columns[c].components * sizeof(float));
            if (!all_finite(values, columns[c].components))
                return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "splat %zu: %s is not finite", i,
                                   columns[c].name);
        }
    return PSPLAT_OK;
}

/* ---- JSON --------------------------------------------------------------------------------- */

static void add_attributes(psplat_writer *json, const run *r, size_t accessor) {
    psplat_writer_open(json, "attributes", '{');
    for (size_t i = 0; i < COLUMNS; ++i)
        if (r->components[i]) psplat_writer_count(json, columns[i].name, accessor++);
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

static void add_primitive(psplat_writer *json, const run *r, size_t accessor) {
    float extent[3];
    for (size_t i = 0; i < 3; ++i) extent[i] = (float)((double)r->max[i] - (double)r->min[i]);
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "mode", 0);
    add_attributes(json, r, accessor);
    if (r->material != PSPLAT_NO_INDEX) psplat_writer_count(json, "material", r->material);
    psplat_writer_open(json, "extensions", '{');
    psplat_writer_open(json, "PSPLAT_surface_splats", '{');
    psplat_writer_count(json, "version", 1);
    psplat_writer_count(json, "clipLines", r->clip_lines);
    psplat_writer_float(json, "depthTolerance", r->depth_tolerance);
    psplat_writer_floats(json, "positionExtent", extent, 3);
    add_kernel(json, &r->set->kernel);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
}

/* runs: those of the mesh, and accessor the first of theirs. Returns the first after them. */
static size_t add_mesh(psplat_writer *json, const psplat_scene_mesh *mesh, const run *runs,
                       size_t run_count, size_t accessor) {
    psplat_writer_open(json, NULL, '{');
    if (mesh->name) psplat_writer_string(json, "name", mesh->name);
    psplat_writer_open(json, "primitives", '[');
    for (size_t i = 0; i < run_count; ++i) {
        add_primitive(json, &runs[i], accessor);
        accessor += runs[i].column_count;
    }
    psplat_writer_close(json, ']');
    if (mesh->extras) psplat_writer_raw(json, "extras", mesh->extras);
    psplat_writer_close(json, '}');
    return accessor;
}

static void add_meshes(psplat_writer *json, const document *d) {
    size_t accessor = 0, run = 0;
    psplat_writer_open(json, "meshes", '[');
    for (size_t i = 0; i < d->scene->mesh_count; ++i) {
        if (!d->splats[i].count) continue;
        accessor =
            add_mesh(json, &d->scene->meshes[i], d->runs + run, d->splats[i].run_count, accessor);
        run += d->splats[i].run_count;
    }
    psplat_writer_close(json, ']');
}

static void add_accessor(psplat_writer *json, const run *r, size_t index, size_t view) {
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    const column *c = &columns[index];
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "bufferView", view);
    psplat_writer_count(json, "componentType", (size_t)c->type);
    if (c->type != FLOAT) psplat_writer_boolean(json, "normalized", 1);
    psplat_writer_count(json, "count", r->count);
    psplat_writer_string(json, "type", types[r->components[index]]);
    if (index == POSITION_COLUMN) {
        psplat_writer_floats(json, "min", r->min, 3);
        psplat_writer_floats(json, "max", r->max, 3);
    }
    psplat_writer_close(json, '}');
}

static void add_view(psplat_writer *json, size_t offset, size_t bytes) {
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "buffer", 0);
    psplat_writer_count(json, "byteOffset", offset);
    psplat_writer_count(json, "byteLength", bytes);
    psplat_writer_count(json, "target", 34962); /* ARRAY_BUFFER */
    psplat_writer_close(json, '}');
}

/* One accessor with a view of its own for each column of each run. */
static void add_data(psplat_writer *json, const run *runs, size_t run_count) {
    size_t view = 0, offset = 0;
    psplat_writer_open(json, "accessors", '[');
    for (size_t i = 0; i < run_count; ++i)
        for (size_t c = 0; c < COLUMNS; ++c)
            if (runs[i].components[c]) add_accessor(json, &runs[i], c, view++);
    psplat_writer_close(json, ']');
    psplat_writer_open(json, "bufferViews", '[');
    for (size_t i = 0; i < run_count; ++i)
        for (size_t c = 0; c < COLUMNS; ++c) {
            size_t bytes = column_bytes(&runs[i], c);
            if (!bytes) continue;
            add_view(json, offset, bytes);
            offset += bytes;
        }
    psplat_writer_close(json, ']');
    psplat_writer_open(json, "buffers", '[');
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "byteLength", offset);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, ']');
}

static void add_extensions_used(psplat_writer *json, const document *d) {
    psplat_writer_open(json, "extensionsUsed", '[');
    psplat_writer_string(json, NULL, "PSPLAT_surface_splats");
    psplat_materials_write_extensions(json, &d->materials);
    if (d->scene->light_count) psplat_writer_string(json, NULL, "KHR_lights_punctual");
    psplat_writer_close(json, ']');
}

static void add_document(psplat_writer *json, const document *d) {
    psplat_writer_open(json, NULL, '{');
    psplat_writer_open(json, "asset", '{');
    psplat_writer_string(json, "version", "2.0");
    psplat_writer_string(json, "generator", "phongsplat 0.1.0");
    psplat_graph_write_asset(json, d->scene);
    psplat_writer_close(json, '}');
    add_extensions_used(json, d);
    psplat_graph_write(json, d->scene, d->placements, d->meshes);
    if (d->scene->light_count) {
        psplat_writer_open(json, "extensions", '{');
        psplat_graph_write_lights(json, d->scene);
        psplat_writer_close(json, '}');
    }
    add_meshes(json, d);
    psplat_materials_write(json, &d->materials);
    add_data(json, d->runs, d->run_count);
    psplat_writer_close(json, '}');
}

/* ---- bytes -------------------------------------------------------------------------------- */

static uint8_t *put_u32(uint8_t *out, uint32_t value) {
    for (int i = 0; i < 4; ++i) *out++ = (uint8_t)(value >> (8 * i));
    return out;
}

static uint8_t *put_value(uint8_t *out, float value, int type) {
    if (type == FLOAT) {
        uint32_t bits;
        memcpy(&bits, &value, sizeof bits);
        return put_u32(out, bits);
    }
    unsigned quantised = (unsigned)lrintf(fminf(fmaxf(value, 0.0f), 1.0f) * 65535.0f);
    *out++ = (uint8_t)quantised;
    *out++ = (uint8_t)(quantised >> 8);
    return out;
}

static uint8_t *put_run(uint8_t *out, const run *r) {
    for (size_t c = 0; c < COLUMNS; ++c) {
        if (!r->components[c]) continue;
        for (size_t i = 0; i < r->count; ++i) {
            float values[4];
            memcpy(values, (const char *)&r->splats[i] + columns[c].offset,
                   columns[c].components * sizeof(float));
            for (size_t k = 0; k < r->components[c]; ++k)
                out = put_value(out, values[k], columns[c].type);
        }
    }
    return out;
}

/* glTF 2.0 section 4.4: header, JSON chunk padded with spaces, BIN chunk. */
static psplat_result pack(const psplat_writer *json, const run *runs, size_t run_count,
                          uint8_t **data, size_t *size, psplat_error *error) {
    enum { HEADERS = 12 + 8 + 8, MAGIC = 0x46546c67, JSON = 0x4e4f534a, BIN = 0x004e4942 };
    size_t bytes = 0, json_size = (json->size + 3) / 4 * 4;
    for (size_t i = 0; i < run_count; ++i) bytes += run_bytes(&runs[i]);
    size_t total = HEADERS + json_size + bytes;
    if (total > UINT32_MAX)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "%zu bytes are more than the 4 GiB that a GLB can hold", total);
    uint8_t *out = malloc(total);
    if (!out) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu bytes", total);
    *data = out;
    *size = total;
    out = put_u32(put_u32(put_u32(out, MAGIC), 2), (uint32_t)total);
    out = put_u32(put_u32(out, (uint32_t)json_size), JSON);
    memset(out, ' ', json_size);
    memcpy(out, json->text, json->size);
    out = put_u32(put_u32(out + json_size, (uint32_t)bytes), BIN);
    for (size_t i = 0; i < run_count; ++i) out = put_run(out, &runs[i]);
    return PSPLAT_OK;
}

/* ---- the whole ---------------------------------------------------------------------------------
 */

static run *make_runs(const document *d, const psplat_splats *splats, run *out) {
    const psplat_splat *next = splats->splats;
    for (size_t i = 0; i < splats->run_count; ++i) {
        const psplat_run *from = &splats->runs[i];
        *out = (run){.set = splats,
                     .splats = next,
                     .count = from->count,
                     .clip_lines = from->clip_lines,
                     .depth_tolerance = from->depth_tolerance};
        out->material = psplat_materials_index(&d->materials, d->scene, splats, from->material);
        run_measure(out++, splats);
        next += from->count;
    }
    return out;
}

/* Everything but the JSON. */
static psplat_result prepare(document *d) {
    size_t count = d->scene->mesh_count, runs = 0;
    uint32_t written = 0;
    for (size_t i = 0; i < count; ++i) runs += d->splats[i].run_count;
    d->meshes = malloc((count + 1) * sizeof *d->meshes);
    d->placements = malloc((count + 1) * sizeof *d->placements);
    d->runs = malloc((runs + 1) * sizeof *d->runs);
    if (!d->meshes || !d->placements || !d->runs ||
        psplat_materials_collect(d->scene, d->splats, &d->materials))
        return PSPLAT_ERROR_MEMORY;
    run *next = d->runs;
    for (size_t i = 0; i < count; ++i) {
        const double *origin = d->splats[i].origin;
        d->meshes[i] = d->splats[i].count ? written++ : PSPLAT_NO_INDEX;
        d->placements[i] = (psplat_placement){{origin[0], origin[1], origin[2]}, 1};
        next = make_runs(d, &d->splats[i], next);
    }
    d->run_count = (size_t)(next - d->runs);
    return PSPLAT_OK;
}

static psplat_result check_all(const psplat_scene *scene, const psplat_splats *splats,
                               psplat_error *error) {
    size_t count = 0;
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < scene->mesh_count && !result; ++i) {
        if (splats[i].count || splats[i].run_count) result = check_splats(&splats[i], error);
        count += splats[i].count;
    }
    if (result || count) return result;
    return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "no splats to write");
}

psplat_result psplat_scene_write(const psplat_scene *scene, const psplat_splats *splats,
                                 uint8_t **data, size_t *size, psplat_error *error) {
    if (!scene || !splats || !data || !size)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "scene, splats, data and size are required");
    *data = NULL;
    *size = 0;
    psplat_result result = check_all(scene, splats, error);
    if (result) return result;
    document d = {.scene = scene, .splats = splats};
    psplat_writer json = {.compact = 1};
    result = prepare(&d);
    if (!result) add_document(&json, &d);
    if (result || !psplat_writer_finish(&json))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the JSON");
    else
        result = pack(&json, d.runs, d.run_count, data, size, error);
    free(json.text);
    free(d.runs);
    free(d.meshes);
    free(d.placements);
    psplat_materials_free(&d.materials);
    return result;
}

psplat_result psplat_glb_write(const psplat_splats *splats, const char *name, uint8_t **data,
                               size_t *size, psplat_error *error) {
    uint32_t root = 0;
    size_t length = name ? strlen(name) : 0;
    char *copy = calloc(length + 1, 1);
    if (!copy) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the name");
    if (length) memcpy(copy, name, length);
    psplat_scene_mesh mesh = {.name = length ? copy : NULL};
    psplat_scene_node node = {.name = mesh.name,
                              .rotation = {0, 0, 0, 1},
                              .scale = {1, 1, 1},
                              .camera = PSPLAT_NO_INDEX,
                              .light = PSPLAT_NO_INDEX};
    psplat_scene_view view = {.roots = &root, .root_count = 1};
    const psplat_scene scene = {.meshes = &mesh,
                                .mesh_count = 1,
                                .nodes = &node,
                                .node_count = 1,
                                .scenes = &view,
                                .scene_count = 1,
                                .is_made = 1};
    psplat_result result = psplat_scene_write(&scene, splats, data, size, error);
    free(copy);
    return result;
}

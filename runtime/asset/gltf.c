/* SPDX-License-Identifier: MIT
 *
 * gltf.c - the document's tables of buffers, views and accessors (glTF 2.0 section 3.6).
 */
#include "asset/gltf.h"

#define PSPLAT_MESHOPT "EXT_meshopt_compression"

/* The extensions that a file may require. Component types of splats are checked one by one; the
 * other things that KHR_mesh_quantization allows do not matter to splats. What extensions of
 * textures point to is for the host to decode. */
static const char *const known_extensions[] = {
    PSPLAT_EXTENSION,      "KHR_materials_unlit",   "KHR_materials_emissive_strength",
    "KHR_lights_punctual", "KHR_mesh_quantization", "KHR_texture_transform",
    "EXT_texture_webp",    "KHR_texture_basisu",    "MSFT_texture_dds",
};

size_t psplat_gltf_offset(const psplat_gltf *gltf, psplat_json_value value) {
    return psplat_json_offset(&gltf->json, value);
}

psplat_result psplat_gltf_table(psplat_gltf *gltf, psplat_json_value array, const char *what,
                                size_t entry_size, void **table, size_t *count) {
    psplat_result result = psplat_json_expect(&gltf->json, array, PSPLAT_JSON_ARRAY, what);
    if (result) return result;
    *count = array ? psplat_json_length(&gltf->json, array) : 0;
    *table = psplat_arena_take(gltf->scratch, *count, entry_size);
    if (*table) return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, psplat_gltf_offset(gltf, array),
                       "no memory for %zu %s", *count, what);
}

psplat_result psplat_gltf_index(const psplat_gltf *gltf, psplat_json_value value, const char *what,
                                size_t count, size_t *index) {
    *index = PSPLAT_NONE;
    if (value && !count)
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                           "%s is an index into nothing", what);
    return psplat_json_integer(&gltf->json, value, what, count - 1, index);
}

psplat_result psplat_gltf_require(const psplat_gltf *gltf, psplat_json_value object,
                                  psplat_json_value member, const char *what) {
    if (member) return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, object),
                       "%s is missing", what);
}

/* ---- asset and extensions ----------------------------------------------------------------- */

static psplat_result check_version(psplat_gltf *gltf, psplat_json_value asset) {
    static const char *const names[] = {"version", "minVersion"};
    psplat_json_value members[2];
    psplat_result result = psplat_gltf_require(gltf, 0, asset, "asset");
    if (!result) result = psplat_json_members(&gltf->json, asset, names, 2, members);
    if (!result) result = psplat_gltf_require(gltf, asset, members[0], "asset.version");
    for (size_t i = 0; i < 2 && !result; ++i) {
        if (!members[i]) continue;
        result = psplat_json_expect(&gltf->json, members[i], PSPLAT_JSON_STRING, names[i]);
        if (result) return result;
        const char *supported = i == 0 ? "2." : "2.0";
        if (!psplat_json_begins(&gltf->json, members[i], supported))
            result = psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED,
                                 psplat_gltf_offset(gltf, members[i]),
                                 "glTF %s does not begin with %s", names[i], supported);
    }
    return result;
}

/* A file that has no splats at all is not one of ours, whatever else it requires. */
static psplat_result fail_unknown_extension(psplat_gltf *gltf, psplat_json_value extension) {
    char *name = NULL;
    size_t size = 0;
    if (!gltf->is_listed)
        return psplat_fail(gltf->error, PSPLAT_ERROR_NO_SPLATS, 0,
                           "the file does not use the extension " PSPLAT_EXTENSION);
    psplat_result result = psplat_json_string(&gltf->json, extension, gltf->scratch, &name, &size);
    if (result) return result;
    return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, psplat_gltf_offset(gltf, extension),
                       "the file requires the extension %.100s", name);
}

static psplat_result check_required(psplat_gltf *gltf, psplat_json_value required) {
    psplat_result result =
        psplat_json_expect(&gltf->json, required, PSPLAT_JSON_ARRAY, "extensionsRequired");
    if (result || !required) return result;
    psplat_json_value extension = psplat_json_first(&gltf->json, required);
    for (; extension; extension = psplat_json_next(&gltf->json, required, extension)) {
        int known = 0;
        result =
            psplat_json_expect(&gltf->json, extension, PSPLAT_JSON_STRING, "an extension's name");
        if (result) return result;
        if (PSPLAT_MESHOPT_IS_BUILT)
            known = psplat_json_equals(&gltf->json, extension, PSPLAT_MESHOPT);
        for (size_t i = 0; i < sizeof known_extensions / sizeof *known_extensions; ++i)
            known |= psplat_json_equals(&gltf->json, extension, known_extensions[i]);
        if (!known) return fail_unknown_extension(gltf, extension);
    }
    return PSPLAT_OK;
}

static psplat_result check_used(psplat_gltf *gltf, psplat_json_value used) {
    psplat_result result =
        psplat_json_expect(&gltf->json, used, PSPLAT_JSON_ARRAY, "extensionsUsed");
    if (result || !used) return result;
    psplat_json_value name = psplat_json_first(&gltf->json, used);
    for (; name; name = psplat_json_next(&gltf->json, used, name)) {
        result = psplat_json_expect(&gltf->json, name, PSPLAT_JSON_STRING, "an extension's name");
        if (result) return result;
        gltf->is_listed |= psplat_json_equals(&gltf->json, name, PSPLAT_EXTENSION);
    }
    return PSPLAT_OK;
}

/* ---- tables ------------------------------------------------------------------------------- */

/* Finds the object of EXT_meshopt_compression among extensions; *object is 0 where there is
 * none. */
static psplat_result find_compression(psplat_gltf *gltf, psplat_json_value extensions,
                                      psplat_json_value *object) {
    static const char *const name[] = {PSPLAT_MESHOPT};
    *object = 0;
    return extensions ? psplat_json_members(&gltf->json, extensions, name, 1, object) : PSPLAT_OK;
}

static psplat_result parse_buffer(psplat_gltf *gltf, psplat_buffer *buffer) {
    static const char *const names[] = {"byteLength", "uri", "extensions"};
    static const char *const fallback[] = {"fallback"};
    psplat_json_value members[3], compression = 0, is_fallback = 0;
    psplat_result result = psplat_json_members(&gltf->json, buffer->json, names, 3, members);
    if (!result) result = psplat_gltf_require(gltf, buffer->json, members[0], "byteLength");
    if (!result)
        result = psplat_json_integer(&gltf->json, members[0], names[0], SIZE_MAX, &buffer->length);
    if (!result) result = psplat_json_expect(&gltf->json, members[1], PSPLAT_JSON_STRING, names[1]);
    if (!result) result = find_compression(gltf, members[2], &compression);
    if (!result && compression)
        result = psplat_json_members(&gltf->json, compression, fallback, 1, &is_fallback);
    if (!result)
        result = psplat_json_boolean(&gltf->json, is_fallback, fallback[0], &buffer->is_fallback);
    buffer->uri = members[1];
    return result;
}

static psplat_result parse_view(psplat_gltf *gltf, psplat_view_range *view) {
    static const char *const names[] = {"buffer", "byteLength", "byteOffset", "byteStride",
                                        "extensions"};
    psplat_json_value members[5];
    const psplat_json *json = &gltf->json;
    psplat_result result = psplat_json_members(json, view->json, names, 5, members);
    if (!result) result = psplat_gltf_require(gltf, view->json, members[0], "buffer");
    if (!result) result = psplat_gltf_require(gltf, view->json, members[1], "byteLength");
    if (!result)
        result = psplat_gltf_index(gltf, members[0], names[0], gltf->buffer_count, &view->buffer);
    if (!result) result = psplat_json_integer(json, members[1], names[1], SIZE_MAX, &view->length);
    if (!result) result = psplat_json_integer(json, members[2], names[2], SIZE_MAX, &view->offset);
    if (!result) result = psplat_json_integer(json, members[3], names[3], 252, &view->stride);
    if (!result && members[3] && (view->stride < 4 || view->stride % 4))
        result = psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, members[3]),
                             "byteStride must be a multiple of 4 from 4 to 252");
    return result ? result : find_compression(gltf, members[4], &view->compression);
}

static psplat_result parse_accessor_type(psplat_gltf *gltf, psplat_json_value value,
                                         size_t *components) {
    static const struct {
        const char *name;
        size_t components;
    } types[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                 {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
    psplat_result result = psplat_json_expect(&gltf->json, value, PSPLAT_JSON_STRING, "type");
    if (result) return result;
    for (size_t i = 0; i < sizeof types / sizeof *types; ++i) {
        /* A matrix of four components is no VEC4. A component count of 0 matches no attribute. */
        if (psplat_json_equals(&gltf->json, value, types[i].name)) {
            *components = i < 4 ? types[i].components : 0;
            return PSPLAT_OK;
        }
    }
    return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, value),
                       "type is not one of glTF's accessor types");
}

static psplat_result parse_accessor(psplat_gltf *gltf, psplat_accessor *accessor) {
    static const char *const names[] = {"componentType", "count",      "type",  "bufferView",
                                        "byteOffset",    "normalized", "sparse"};
    psplat_json_value members[7];
    const psplat_json *json = &gltf->json;
    psplat_result result = psplat_json_members(json, accessor->json, names, 7, members);
    for (size_t i = 0; i < 3 && !result; ++i)
        result = psplat_gltf_require(gltf, accessor->json, members[i], names[i]);
    if (!result)
        result = psplat_json_integer(json, members[0], names[0], 65535, &accessor->component_type);
    if (!result)
        result = psplat_json_integer(json, members[1], names[1], SIZE_MAX, &accessor->count);
    if (!result) result = parse_accessor_type(gltf, members[2], &accessor->components);
    if (!result)
        result = psplat_gltf_index(gltf, members[3], names[3], gltf->view_count, &accessor->view);
    if (!result)
        result = psplat_json_integer(json, members[4], names[4], SIZE_MAX, &accessor->offset);
    if (!result) result = psplat_json_boolean(json, members[5], names[5], &accessor->normalized);
    accessor->sparse = members[6];
    if (!result && accessor->count == 0)
        result = psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, members[1]),
                             "count must be at least 1");
    return result;
}

/* Each table has a loop of its own; a macro would hide more than it saves. */
static psplat_result parse_tables(psplat_gltf *gltf, const psplat_json_value arrays[3]) {
    void *table = NULL;
    psplat_result result = psplat_gltf_table(gltf, arrays[0], "buffers", sizeof *gltf->buffers,
                                             &table, &gltf->buffer_count);
    gltf->buffers = table;
    psplat_json_value value = 0;
    for (size_t i = 0; i < gltf->buffer_count && !result; ++i) {
        value = i ? psplat_json_next(&gltf->json, arrays[0], value)
                  : psplat_json_first(&gltf->json, arrays[0]);
        gltf->buffers[i].json = value;
        result = parse_buffer(gltf, &gltf->buffers[i]);
    }
    if (!result)
        result = psplat_gltf_table(gltf, arrays[1], "bufferViews", sizeof *gltf->views, &table,
                                   &gltf->view_count);
    gltf->views = table;
    for (size_t i = 0; i < gltf->view_count && !result; ++i) {
        value = i ? psplat_json_next(&gltf->json, arrays[1], value)
                  : psplat_json_first(&gltf->json, arrays[1]);
        gltf->views[i].json = value;
        result = parse_view(gltf, &gltf->views[i]);
    }
    if (!result)
        result = psplat_gltf_table(gltf, arrays[2], "accessors", sizeof *gltf->accessors, &table,
                                   &gltf->accessor_count);
    gltf->accessors = table;
    for (size_t i = 0; i < gltf->accessor_count && !result; ++i) {
        value = i ? psplat_json_next(&gltf->json, arrays[2], value)
                  : psplat_json_first(&gltf->json, arrays[2]);
        gltf->accessors[i].json = value;
        result = parse_accessor(gltf, &gltf->accessors[i]);
    }
    return result;
}

psplat_result psplat_gltf_parse(psplat_gltf *gltf) {
    static const char *const names[] = {"asset",          "extensionsRequired",
                                        "buffers",        "bufferViews",
                                        "accessors",      "materials",
                                        "meshes",         "nodes",
                                        "scenes",         "scene",
                                        "extensionsUsed", "textures",
                                        "samplers",       "images",
                                        "animations"};
    psplat_json_value members[15];
    psplat_result result = psplat_json_parse(&gltf->json, gltf->scratch);
    if (!result) result = psplat_json_members(&gltf->json, 0, names, 15, members);
    if (!result) result = check_version(gltf, members[0]);
    if (!result) result = check_used(gltf, members[10]);
    if (!result) result = check_required(gltf, members[1]);
    if (!result) result = parse_tables(gltf, members + 2);
    if (result) return result;
    gltf->json_materials = members[5];
    gltf->json_meshes = members[6];
    gltf->json_nodes = members[7];
    gltf->json_scenes = members[8];
    gltf->json_scene = members[9];
    gltf->json_textures = members[11];
    gltf->json_samplers = members[12];
    gltf->json_images = members[13];
    gltf->json_animations = members[14];
    return PSPLAT_OK;
}

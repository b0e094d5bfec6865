/* SPDX-License-Identifier: MIT
 *
 * primitive.c - finds which primitives of the meshes are splats (spec 3.1 and 6.2).
 */
#include "asset/gltf.h"
#include "asset/level.h"

enum { MODE, ATTRIBUTES, INDICES, TARGETS, MATERIAL, EXTENSIONS, MEMBERS };

static const char *const names[MEMBERS] = {"mode",    "attributes", "indices",
                                           "targets", "material",   "extensions"};

/* Finds the extension's object; it is 0 where there is none. */
static psplat_result find_extension(const psplat_gltf *gltf, psplat_json_value extensions,
                                    psplat_json_value *extension) {
    static const char *const name[] = {PSPLAT_EXTENSION};
    *extension = 0;
    return extensions ? psplat_json_members(&gltf->json, extensions, name, 1, extension)
                      : PSPLAT_OK;
}

/* Remembers the first primitive that has attributes of the extension but lost the extension's
 * object. */
static void note_stripped(psplat_gltf *gltf, psplat_json_value attributes) {
    if (psplat_json_type_of(&gltf->json, attributes) != PSPLAT_JSON_OBJECT) return;
    psplat_json_value key = psplat_json_first(&gltf->json, attributes);
    for (; key && !gltf->json_stripped; key = psplat_json_next(&gltf->json, attributes, key))
        if (psplat_json_begins(&gltf->json, key, "_" PSPLAT_EXTENSION ":") ||
            psplat_json_begins(&gltf->json, key, PSPLAT_EXTENSION ":"))
            gltf->json_stripped = key;
}

/* Checks that the primitive consists of points and has neither indices nor morph targets (spec
 * 3.1). */
static psplat_result check_members(const psplat_gltf *gltf, psplat_json_value primitive,
                                   const psplat_json_value *members) {
    size_t mode = 4; /* glTF's default: triangles */
    psplat_result result = psplat_json_integer(&gltf->json, members[MODE], "mode", 6, &mode);
    if (result) return result;
    psplat_json_value wrong = members[INDICES] ? members[INDICES] : members[TARGETS];
    if (mode != 0 || wrong)
        return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT,
                           psplat_gltf_offset(gltf, wrong           ? wrong
                                                    : members[MODE] ? members[MODE]
                                                                    : primitive),
                           "splats are primitives of mode 0 without indices and targets");
    if (!members[ATTRIBUTES])
        return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, primitive),
                           "attributes is missing");
    if (!gltf->is_listed)
        return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, primitive),
                           PSPLAT_EXTENSION " is used but not listed in extensionsUsed");
    return PSPLAT_OK;
}

static psplat_result parse_primitive(psplat_gltf *gltf, psplat_json_value primitive,
                                     psplat_mesh_sets *sets) {
    psplat_json_value members[MEMBERS], extension = 0;
    psplat_result result = psplat_json_members(&gltf->json, primitive, names, MEMBERS, members);
    if (!result) result = find_extension(gltf, members[EXTENSIONS], &extension);
    if (result) return result;
    if (!extension) {
        if (members[ATTRIBUTES]) note_stripped(gltf, members[ATTRIBUTES]);
        return PSPLAT_OK;
    }
    result = check_members(gltf, primitive, members);
    if (!result) result = psplat_levels_note(gltf, extension, sets);
    if (result) return result;
    return psplat_sets_parse(gltf, members[ATTRIBUTES], extension, members[MATERIAL]);
}

/* The sets of a mesh lie side by side in gltf->sets. */
static psplat_result parse_mesh(psplat_gltf *gltf, psplat_json_value mesh, psplat_mesh_sets *sets) {
    static const char *const members[] = {"primitives", "extensions"};
    psplat_json_value found[2];
    psplat_result result = psplat_json_members(&gltf->json, mesh, members, 2, found);
    if (!result) result = psplat_gltf_require(gltf, mesh, found[0], members[0]);
    if (!result) result = psplat_json_expect(&gltf->json, found[0], PSPLAT_JSON_ARRAY, members[0]);
    if (result) return result;
    sets->first_set = gltf->set_count;
    psplat_json_value array = found[0], primitive = psplat_json_first(&gltf->json, array);
    for (; primitive && !result; primitive = psplat_json_next(&gltf->json, array, primitive))
        result = parse_primitive(gltf, primitive, sets);
    sets->set_count = gltf->set_count - sets->first_set;
    for (size_t i = 0; i < sets->set_count; ++i)
        sets->splat_count += gltf->sets[sets->first_set + i].count;
    return result ? result : psplat_fallback_mesh_parse(gltf, found[1], sets);
}

static psplat_result fail_no_splats(const psplat_gltf *gltf) {
    if (gltf->json_stripped)
        return psplat_fail(gltf->error, PSPLAT_ERROR_NO_SPLATS,
                           psplat_gltf_offset(gltf, gltf->json_stripped),
                           "a primitive has the attributes of " PSPLAT_EXTENSION
                           " but not its extension object, which another tool must have dropped: "
                           "they are only points now");
    return psplat_fail(gltf->error, PSPLAT_ERROR_NO_SPLATS, 0,
                       "no primitive of the file has the extension " PSPLAT_EXTENSION);
}

psplat_result psplat_meshes_parse(psplat_gltf *gltf) {
    void *table = NULL;
    psplat_json_value array = gltf->json_meshes, mesh = 0;
    psplat_result result =
        psplat_gltf_table(gltf, array, "meshes", sizeof *gltf->meshes, &table, &gltf->mesh_count);
    gltf->meshes = table;
    for (size_t i = 0; i < gltf->mesh_count && !result; ++i) {
        mesh =
            i ? psplat_json_next(&gltf->json, array, mesh) : psplat_json_first(&gltf->json, array);
        result = parse_mesh(gltf, mesh, &gltf->meshes[i]);
    }
    if (!result && !gltf->set_count) result = fail_no_splats(gltf);
    if (!result) result = psplat_fallback_meshes_resolve(gltf);
    if (!result) result = psplat_levels_resolve(gltf);
    return result;
}

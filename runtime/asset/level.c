/* SPDX-License-Identifier: MIT
 *
 * level.c - the levels of detail of meshes (spec 3.13): lists of coarser meshes that show the same
 * surface, with their errors, and what an asset's levels are together.
 *
 * Lists do not chain: a mesh that is a coarser level of another has no list. In each, splats become
 * fewer and errors do not fall, so that a list ends and a coarser level is never better.
 */
#include "asset/level.h"
#include "core/matrix.h"

#include <math.h>

enum { MESH, DISTANCE, NORMAL, OUTLINE, SCALE, TRANSLATION, MEMBERS };

static const char *const names[MEMBERS] = {"mesh",    "distance", "normal",
                                           "outline", "scale",    "translation"};

/* A list and the element that is read. */
typedef struct level_list {
    psplat_gltf *gltf;
    size_t mesh, index; /* of the finest mesh; in the list */
    psplat_json_value element;
} level_list;

static psplat_result fail(const level_list *l, psplat_json_value at, psplat_result code,
                          const char *cause) {
    return psplat_fail(l->gltf->error, code, psplat_gltf_offset(l->gltf, at ? at : l->element),
                       "level %zu of mesh %zu %s", l->index, l->mesh, cause);
}

psplat_result psplat_levels_note(const psplat_gltf *gltf, psplat_json_value extension,
                                 psplat_mesh_sets *sets) {
    static const char *const member[] = {"levels"};
    psplat_json_value list = 0;
    psplat_result result = psplat_json_members(&gltf->json, extension, member, 1, &list);
    if (!result) result = psplat_json_expect(&gltf->json, list, PSPLAT_JSON_ARRAY, member[0]);
    if (result || !list) return result;
    if (gltf->set_count > sets->first_set)
        return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, list),
                           "levels belong to the first primitive of splats of a mesh");
    sets->json_levels = list;
    return PSPLAT_OK;
}

/* Reads an error, which must be stated, and at least that of the level before. */
static psplat_result read_error(const level_list *l, psplat_json_value value, const char *name,
                                double most, double before, double *error) {
    *error = 0;
    if (!value)
        return psplat_fail(l->gltf->error, PSPLAT_ERROR_FORMAT,
                           psplat_gltf_offset(l->gltf, l->element),
                           "level %zu of mesh %zu: %s is missing", l->index, l->mesh, name);
    psplat_result result = psplat_json_number(&l->gltf->json, value, name, error);
    if (result || (*error >= before && *error <= most)) return result;
    return psplat_fail(l->gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(l->gltf, value),
                       "level %zu of mesh %zu: %s must be %g to %g", l->index, l->mesh, name,
                       before, most);
}

static psplat_result read_errors(const level_list *l, const psplat_json_value *members,
                                 const psplat_mesh_level *before, psplat_mesh_level *level) {
    static const psplat_mesh_level none;
    if (!before) before = &none;
    psplat_result result = read_error(l, members[DISTANCE], names[DISTANCE], HUGE_VAL,
                                      before->distance, &level->distance);
    if (!result)
        result = read_error(l, members[NORMAL], names[NORMAL], 180, before->normal, &level->normal);
    if (!result)
        result = read_error(l, members[OUTLINE], names[OUTLINE], HUGE_VAL, before->outline,
                            &level->outline);
    return result;
}

/* Reads where a coarser level's POSITION is in the space of the finest. */
static psplat_result read_place(const level_list *l, const psplat_json_value *members,
                                psplat_mesh_level *level) {
    const psplat_json *json = &l->gltf->json;
    level->scale = 1;
    psplat_result result = psplat_json_number(json, members[SCALE], names[SCALE], &level->scale);
    if (!result && !(level->scale > 0))
        result = fail(l, members[SCALE], PSPLAT_ERROR_RANGE, "has a scale that is not above 0");
    if (!result && members[TRANSLATION])
        result = psplat_json_numbers(json, members[TRANSLATION], names[TRANSLATION], 3,
                                     level->translation);
    return result;
}

/* Checks the mesh of a coarser level. */
static psplat_result check_mesh(const level_list *l, psplat_json_value value, size_t before,
                                size_t mesh) {
    const psplat_mesh_sets *sets = &l->gltf->meshes[mesh];
    if (mesh == l->mesh || sets->json_levels)
        return fail(l, value, PSPLAT_ERROR_FORMAT, "is a mesh with levels of its own");
    if (!sets->set_count || sets->splat_mesh != PSPLAT_NONE)
        return fail(l, value, PSPLAT_ERROR_FORMAT, "is a mesh without splats of its own");
    if (sets->splat_count >= l->gltf->meshes[before].splat_count)
        return fail(l, value, PSPLAT_ERROR_FORMAT, "has no fewer splats than the level before");
    return PSPLAT_OK;
}

static psplat_result read_mesh(const level_list *l, psplat_json_value value,
                               psplat_mesh_level *level) {
    level->mesh = l->mesh;
    if (!l->index && value)
        return fail(l, value, PSPLAT_ERROR_FORMAT, "is the mesh itself and names none");
    if (!l->index) return PSPLAT_OK;
    psplat_result result = psplat_gltf_require(l->gltf, l->element, value, names[MESH]);
    if (!result)
        result = psplat_gltf_index(l->gltf, value, names[MESH], l->gltf->mesh_count, &level->mesh);
    return result ? result : check_mesh(l, value, level[-1].mesh, level->mesh);
}

static psplat_result read_level(const level_list *l, psplat_mesh_level *level) {
    psplat_json_value members[MEMBERS];
    psplat_result result = psplat_json_members(&l->gltf->json, l->element, names, MEMBERS, members);
    if (!result) result = read_mesh(l, members[MESH], level);
    if (!result) result = read_errors(l, members, l->index ? level - 1 : NULL, level);
    if (!result && !l->index && (members[SCALE] || members[TRANSLATION]))
        result = fail(l, 0, PSPLAT_ERROR_FORMAT, "is the mesh itself and has no place of its own");
    return result ? result : read_place(l, members, level);
}

static psplat_result read_list(psplat_gltf *gltf, size_t mesh) {
    psplat_mesh_sets *sets = &gltf->meshes[mesh];
    level_list l = {gltf, mesh, 0, 0};
    void *table = NULL;
    psplat_result result = psplat_gltf_table(gltf, sets->json_levels, "levels",
                                             sizeof *sets->levels, &table, &sets->level_count);
    sets->levels = table;
    if (!result && !sets->level_count)
        result = psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT,
                             psplat_gltf_offset(gltf, sets->json_levels),
                             "the levels of mesh %zu are an empty list", mesh);
    for (; l.index < sets->level_count && !result; ++l.index) {
        l.element = l.index ? psplat_json_next(&gltf->json, sets->json_levels, l.element)
                            : psplat_json_first(&gltf->json, sets->json_levels);
        result = read_level(&l, &sets->levels[l.index]);
    }
    return result;
}

psplat_result psplat_levels_resolve(psplat_gltf *gltf) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < gltf->mesh_count && !result; ++i)
        if (gltf->meshes[i].json_levels) result = read_list(gltf, i);
    for (size_t i = 0; i < gltf->mesh_count && !result; ++i) {
        psplat_mesh_sets *sets = &gltf->meshes[i];
        if (sets->splat_mesh == PSPLAT_NONE) continue;
        sets->levels = gltf->meshes[sets->splat_mesh].levels;
        sets->level_count = gltf->meshes[sets->splat_mesh].level_count;
    }
    return result;
}

/* ---- the levels of an asset ------------------------------------------------------------------ */

/* Returns the mesh that a node shows at a level, or NULL where it shows no splats. */
static const psplat_mesh_sets *shown_mesh(const psplat_gltf *gltf, const psplat_node *node) {
    if (!node->in_scene || node->mesh == PSPLAT_NONE) return NULL;
    const psplat_mesh_sets *mesh = &gltf->meshes[node->mesh];
    return mesh->set_count ? mesh : NULL;
}

size_t psplat_levels_count(const psplat_gltf *gltf) {
    size_t count = 1;
    for (size_t i = 0; i < gltf->node_count; ++i) {
        const psplat_mesh_sets *mesh = shown_mesh(gltf, &gltf->nodes[i]);
        if (mesh && mesh->level_count > count) count = mesh->level_count;
    }
    return count;
}

psplat_result psplat_levels_measure(const psplat_gltf *gltf, psplat_level *levels, size_t count) {
    for (size_t i = 0; i < gltf->node_count; ++i) {
        const psplat_mesh_sets *mesh = shown_mesh(gltf, &gltf->nodes[i]);
        if (!mesh || !mesh->level_count) continue;
        double stretch = psplat_matrix_stretch(gltf->nodes[i].world);
        for (size_t l = 0; l < mesh->level_count; ++l) {
            const psplat_mesh_level *from = &mesh->levels[l];
            levels[l].distance = fmax(levels[l].distance, stretch * from->distance);
            levels[l].normal = fmax(levels[l].normal, from->normal);
            levels[l].outline = fmax(levels[l].outline, stretch * from->outline);
            if (!isfinite(levels[l].distance) || !isfinite(levels[l].outline))
                return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE,
                                   psplat_gltf_offset(gltf, gltf->nodes[i].json),
                                   "a node's transform makes errors of levels greater than what a "
                                   "double can hold");
        }
    }
    /* A mesh is drawn at its last level where others have more. No error falls from level to level,
     * so that what the level before has is what such meshes leave. */
    for (size_t l = 1; l < count; ++l) {
        levels[l].distance = fmax(levels[l].distance, levels[l - 1].distance);
        levels[l].normal = fmax(levels[l].normal, levels[l - 1].normal);
        levels[l].outline = fmax(levels[l].outline, levels[l - 1].outline);
    }
    return PSPLAT_OK;
}

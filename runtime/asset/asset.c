/* SPDX-License-Identifier: MIT
 *
 * asset.c - the public asset: batches made of the sets of splats that the default scene shows.
 */
#include "asset/animation.h"
#include "asset/container.h"
#include "core/files.h"
#include "asset/gltf.h"
#include "asset/level.h"

#include <math.h>
#include <string.h>

/* A small file can place one mesh very often, so that the number of batches is limited. */
enum { MAX_BATCHES = 1 << 18 };
/* The numbers of clip lines that sets may have. */
enum { LINE_COUNTS = PSPLAT_MAX_CLIP_LINES + 1 };

struct psplat_asset {
    psplat_arena arena; /* also holds this struct */
    psplat_batch *batches;
    const psplat_packed **packed; /* one for each batch */
    psplat_rig rig;
    size_t *rig_nodes; /* of each batch, in rig; NULL without animations */
    psplat_level *levels;
    double (*places)[4]; /* of each batch: translation and scale within its node; NULL: none has */
    size_t batch_count;  /* of all levels; those of the finest come first, */
    size_t finest_count; /* so many */
    size_t level_count;
    const psplat_asset_image *images;
    size_t image_count;
};

/* ---- batches ------------------------------------------------------------------------------ */

void psplat_asset_enlarge(const psplat_batch *batch, const double m[16], double min[3],
                          double max[3]) {
    for (int row = 0; row < 3; ++row) {
        double low = m[12 + row], high = low;
        for (int k = 0; k < 3; ++k) {
            double a = m[k * 4 + row] * (double)batch->bounds_min[k];
            double b = m[k * 4 + row] * (double)batch->bounds_max[k];
            low += fmin(a, b);
            high += fmax(a, b);
        }
        min[row] = fmin(min[row], low);
        max[row] = fmax(max[row], high);
    }
}

/* One set of splats where a node places it, at some level. */
typedef struct placed_set {
    const psplat_node *node;
    size_t set, level;
    const psplat_mesh_level *place; /* NULL in the space of the node's mesh */
    int is_last;                    /* of the mesh's levels */
} placed_set;

static void place_batch(const psplat_asset *asset, size_t index, const double world[16],
                        double model[16]) {
    memcpy(model, world, 16 * sizeof *model);
    if (!asset->places) return;
    const double *place = asset->places[index];
    for (int row = 0; row < 3; ++row) {
        for (int k = 0; k < 3; ++k) model[12 + row] += world[4 * k + row] * place[k];
        for (int k = 0; k < 3; ++k) model[4 * k + row] *= place[3];
    }
}

static psplat_result add_batch(psplat_asset *asset, const psplat_gltf *gltf,
                               const placed_set *placed, size_t index) {
    const psplat_set *set = &gltf->sets[placed->set];
    const psplat_node *node = placed->node;
    asset->packed[index] = set->packed;
    if (asset->places) {
        double *place = asset->places[index];
        place[3] = placed->place ? placed->place->scale : 1;
        for (int k = 0; k < 3 && placed->place; ++k) place[k] = placed->place->translation[k];
    }
    if (asset->rig_nodes) asset->rig_nodes[index] = asset->rig.index_of[node - gltf->nodes];
    psplat_batch *batch = &asset->batches[index];
    *batch = (psplat_batch){
        .splats = set->splats,
        .finishes = set->finishes,
        .texcoords = set->texcoords,
        .splat_count = set->count,
        .clip_count = set->clip_count,
        .seam_lines = set->seam_lines,
        .primitive = (uint32_t)placed->set,
        .level = (uint32_t)placed->level,
        .last_level = (uint32_t)(placed->is_last ? asset->level_count - 1 : placed->level),
        .kernel = set->kernel,
        .depth_tolerance = set->depth_tolerance,
        .material = *set->material,
        .has_color = set->has_color,
        .has_gamma = set->has_gamma,
        .is_curved = set->is_curved,
        .has_shape = set->has_shape,
        .has_bends = set->has_bends,
        .has_color_gradient = set->has_color_gradient,
        .has_surface = set->has_surface,
        .has_emissive = set->has_emissive,
        .has_texcoord = set->has_texcoord,
        .has_texcoord_bend = set->has_texcoord_bend,
        .attributes = set->attributes,
        .attribute_count = set->attribute_count};
    place_batch(asset, index, node->world, batch->model);
    memcpy(batch->bounds_min, set->bounds_min, sizeof batch->bounds_min);
    memcpy(batch->bounds_max, set->bounds_max, sizeof batch->bounds_max);
    double min[3] = {INFINITY, INFINITY, INFINITY}, max[3] = {-INFINITY, -INFINITY, -INFINITY};
    psplat_asset_enlarge(batch, batch->model, min, max);
    for (int i = 0; i < 3; ++i)
        if (!isfinite(min[i]) || !isfinite(max[i]))
            return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE,
                               psplat_gltf_offset(gltf, node->json),
                               "a node's transform moves splats beyond what a double can hold");
    return PSPLAT_OK;
}

/* Returns the number of levels of a mesh, which is 1 where it states none. */
static size_t level_count_of(const psplat_mesh_sets *mesh) {
    return mesh->level_count ? mesh->level_count : 1;
}

/* Returns the sets of a mesh at one of its levels. */
static const psplat_mesh_sets *sets_at(const psplat_gltf *gltf, const psplat_mesh_sets *mesh,
                                       size_t level) {
    return level ? &gltf->meshes[mesh->levels[level].mesh] : mesh;
}

static psplat_result count_batches(const psplat_gltf *gltf, size_t *count) {
    for (size_t i = 0; i < gltf->node_count; ++i) {
        const psplat_node *node = &gltf->nodes[i];
        if (!node->in_scene || node->mesh == PSPLAT_NONE) continue;
        const psplat_mesh_sets *mesh = &gltf->meshes[node->mesh];
        for (size_t level = 0; level < level_count_of(mesh); ++level) {
            *count += sets_at(gltf, mesh, level)->set_count;
            if (*count > MAX_BATCHES)
                return psplat_fail(
                    gltf->error, PSPLAT_ERROR_UNSUPPORTED, psplat_gltf_offset(gltf, node->json),
                    "the nodes place more than %d primitives of splats", MAX_BATCHES);
        }
    }
    if (*count) return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_NO_SPLATS, 0,
                       "the file has splats, but no node of its scene shows them");
}

/* Takes memory for the batches of an asset and what belongs to each. */
static psplat_result reserve_batches(psplat_asset *asset, const psplat_gltf *gltf, size_t count) {
    psplat_arena *arena = &asset->arena;
    asset->level_count = psplat_levels_count(gltf);
    asset->levels = psplat_arena_take(arena, asset->level_count, sizeof *asset->levels);
    asset->batches = psplat_arena_take(arena, count, sizeof *asset->batches);
    asset->packed = psplat_arena_take(arena, count, sizeof *asset->packed);
    if (asset->rig.animation_count)
        asset->rig_nodes = psplat_arena_take(arena, count, sizeof *asset->rig_nodes);
    if (asset->level_count > 1)
        asset->places = psplat_arena_take(arena, count, sizeof *asset->places);
    if (asset->levels && asset->batches && asset->packed &&
        (!asset->rig.animation_count || asset->rig_nodes) &&
        (asset->level_count == 1 || asset->places))
        return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu batches", count);
}

/* Calls visit with every set of splats that the scene places, at each level that its mesh has. What
 * is done for a node does not depend on how many levels other meshes have. */
static psplat_result visit_placed(psplat_asset *asset, const psplat_gltf *gltf, size_t *slots,
                                  psplat_result (*visit)(psplat_asset *asset,
                                                         const psplat_gltf *gltf,
                                                         const placed_set *placed, size_t *slot)) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < gltf->node_count; ++i) {
        const psplat_node *node = &gltf->nodes[i];
        if (!node->in_scene || node->mesh == PSPLAT_NONE) continue;
        const psplat_mesh_sets *mesh = &gltf->meshes[node->mesh];
        for (size_t level = 0; level < level_count_of(mesh); ++level) {
            const psplat_mesh_sets *sets = sets_at(gltf, mesh, level);
            placed_set placed = {.node = node,
                                 .level = level,
                                 .place = level ? &mesh->levels[level] : NULL,
                                 .is_last = level + 1 == level_count_of(mesh)};
            for (size_t k = 0; k < sets->set_count && !result; ++k) {
                placed.set = sets->first_set + k;
                result = visit(asset, gltf, &placed,
                               &slots[level * LINE_COUNTS + gltf->sets[placed.set].clip_count]);
            }
        }
    }
    return result;
}

static psplat_result count_slot(psplat_asset *asset, const psplat_gltf *gltf,
                                const placed_set *placed, size_t *slot) {
    (void)asset;
    (void)gltf;
    (void)placed;
    ++slot[1];
    return PSPLAT_OK;
}

static psplat_result fill_slot(psplat_asset *asset, const psplat_gltf *gltf,
                               const placed_set *placed, size_t *slot) {
    return add_batch(asset, gltf, placed, (*slot)++);
}

/* Counts the splats of each level, once all batches are known: those that begin there, and those of
 * the level before that do not end with it. */
static void count_level_splats(psplat_asset *asset) {
    psplat_level *levels = asset->levels;
    for (size_t i = 0; i < asset->batch_count; ++i) {
        const psplat_batch *batch = &asset->batches[i];
        levels[batch->level].splat_count += batch->splat_count;
        /* What wraps around below 0 is added to what it is taken from. */
        if (batch->last_level + 1 < asset->level_count)
            levels[batch->last_level + 1].splat_count -= batch->splat_count;
    }
    for (size_t l = 1; l < asset->level_count; ++l)
        levels[l].splat_count += levels[l - 1].splat_count;
}

/* The finest level comes first. In each, unclipped sets come first (BSK04 section 4.1), then the
 * order is that of nodes and primitives: a counting sort by level and lines. */
static psplat_result make_batches(psplat_asset *asset, const psplat_gltf *gltf) {
    size_t count = 0, *slots = NULL;
    psplat_result result = count_batches(gltf, &count);
    if (!result) result = reserve_batches(asset, gltf, count);
    if (!result) result = psplat_levels_measure(gltf, asset->levels, asset->level_count);
    if (result) return result;
    size_t slot_count = asset->level_count * LINE_COUNTS;
    slots = psplat_arena_take(gltf->scratch, slot_count + 1, sizeof *slots);
    if (!slots)
        return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu batches", count);
    visit_placed(asset, gltf, slots, count_slot);
    for (size_t i = 0; i < slot_count; ++i) slots[i + 1] += slots[i];
    asset->batch_count = count;
    asset->finest_count = slots[LINE_COUNTS];
    result = visit_placed(asset, gltf, slots, fill_slot);
    count_level_splats(asset);
    return result;
}

/* ---- opening ------------------------------------------------------------------------------ */

/* The fields of a description, with defaults filled in. */
typedef struct opening {
    psplat_allocator allocator;
    psplat_files files;
    size_t max_size;
    int measures, only_draws;
} opening;

static opening resolve(const psplat_asset_desc *desc) {
    opening o = {.allocator = psplat_allocator_default(desc ? &desc->allocator : NULL),
                 .files = psplat_files_default(desc ? &desc->files : NULL),
                 .max_size = (size_t)1 << 31};
    if (desc && desc->max_file_size) o.max_size = desc->max_file_size;
    if (desc) o.measures = desc->measures;
    if (desc) o.only_draws = desc->only_draws;
    return o;
}

static psplat_result parse(psplat_asset *asset, psplat_gltf *gltf) {
    psplat_result result = psplat_gltf_parse(gltf);
    if (!result) result = psplat_materials_parse(gltf);
    if (!result) result = psplat_meshes_parse(gltf);
    if (!result) result = psplat_nodes_parse(gltf);
    if (!result) result = psplat_animations_parse(gltf, &asset->rig);
    asset->images = gltf->kept_images;
    asset->image_count = gltf->kept_image_count;
    if (!result) result = make_batches(asset, gltf);
    asset->rig.index_of = NULL; /* it lies in the scratch arena */
    return result;
}

static psplat_asset *create(const psplat_allocator *allocator, psplat_error *error) {
    psplat_arena arena = {.allocator = *allocator};
    psplat_asset *asset = psplat_arena_take(&arena, 1, sizeof *asset);
    if (asset)
        asset->arena = arena;
    else
        psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for an asset");
    return asset;
}

static psplat_result open_bytes(const uint8_t *data, size_t size, const opening *o,
                                const char *base_path, psplat_asset **out, psplat_error *error) {
    psplat_container container;
    psplat_result result = psplat_container_parse(data, size, &container, error);
    if (result) return result;
    psplat_asset *asset = create(&o->allocator, error);
    if (!asset) return PSPLAT_ERROR_MEMORY;
    psplat_arena scratch = {.allocator = o->allocator};
    psplat_gltf gltf = {.error = error,
                        .scratch = &scratch,
                        .kept = &asset->arena,
                        .json = {.text = (const char *)data + container.json_offset,
                                 .size = container.json_size,
                                 .base = container.json_offset,
                                 .error = error},
                        .files = o->files,
                        .base_path = base_path,
                        .file_budget = o->max_size - size,
                        .measures = o->measures,
                        .only_draws = o->only_draws,
                        .bin = container.bin_size ? data + container.bin_offset : NULL,
                        .bin_size = container.bin_size,
                        .bin_offset = container.bin_offset};
    result = parse(asset, &gltf);
    psplat_arena_release(&scratch);
    if (result)
        psplat_asset_destroy(asset);
    else
        *out = asset;
    return result;
}

psplat_result psplat_asset_open_memory(const void *data, size_t size, const psplat_asset_desc *desc,
                                       psplat_asset **asset, psplat_error *error) {
    if (asset) *asset = NULL;
    if (!asset || (!data && size))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "data and asset are required");
    opening o = resolve(desc);
    if (size > o.max_size)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "%zu bytes are more than the %zu allowed",
                           size, o.max_size);
    return open_bytes(data, size, &o, desc ? desc->base_path : NULL, asset, error);
}

/* Returns the length of a path's directory. Windows allows both slashes. */
static size_t directory_length(const char *path) {
    size_t length = 0;
    for (size_t i = 0; path[i]; ++i)
        if (path[i] == '/' || path[i] == '\\') length = i + 1;
    return length;
}

static psplat_result open_path(const char *path, const opening *o, psplat_arena *scratch,
                               psplat_asset **asset, psplat_error *error) {
    size_t length = directory_length(path), size = 0;
    char *directory = psplat_arena_take(scratch, length + 1, 1);
    if (!directory) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    memcpy(directory, path, length);
    void *data = NULL;
    psplat_result result =
        o->files.read(o->files.user, &scratch->allocator, path, o->max_size, &data, &size);
    if (!result) result = psplat_arena_adopt(scratch, data, size);
    if (result == PSPLAT_ERROR_RANGE)
        return psplat_fail(error, result, 0, "%.150s is larger than the %zu bytes allowed", path,
                           o->max_size);
    if (result)
        return psplat_fail(error, result, 0, "%s: %.150s", psplat_result_text(result), path);
    return open_bytes(data, size, o, directory, asset, error);
}

psplat_result psplat_asset_open(const char *path, const psplat_asset_desc *desc,
                                psplat_asset **asset, psplat_error *error) {
    if (asset) *asset = NULL;
    if (!asset || !path)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "path and asset are required");
    opening o = resolve(desc);
    psplat_arena scratch = {.allocator = o.allocator};
    psplat_result result = open_path(path, &o, &scratch, asset, error);
    psplat_arena_release(&scratch);
    return result;
}

void psplat_asset_destroy(psplat_asset *asset) {
    if (!asset) return;
    /* The asset lies in its own arena, so that the arena is copied out before it is released. */
    psplat_arena arena = asset->arena;
    psplat_arena_release(&arena);
}

size_t psplat_asset_batch_count(const psplat_asset *asset) {
    return asset ? asset->finest_count : 0;
}

size_t psplat_asset_all_batch_count(const psplat_asset *asset) {
    return asset ? asset->batch_count : 0;
}

size_t psplat_asset_level_count(const psplat_asset *asset) {
    return asset ? asset->level_count : 0;
}

const psplat_level *psplat_asset_get_level(const psplat_asset *asset, size_t index) {
    return index < psplat_asset_level_count(asset) ? &asset->levels[index] : NULL;
}

const psplat_batch *psplat_asset_batch(const psplat_asset *asset, size_t index) {
    return asset && index < asset->batch_count ? &asset->batches[index] : NULL;
}

size_t psplat_asset_image_count(const psplat_asset *asset) {
    return asset ? asset->image_count : 0;
}

const psplat_asset_image *psplat_asset_get_image(const psplat_asset *asset, size_t index) {
    return asset && index < asset->image_count ? &asset->images[index] : NULL;
}

size_t psplat_asset_animation_count(const psplat_asset *asset) {
    return asset ? asset->rig.animation_count : 0;
}

const psplat_animation *psplat_asset_get_animation(const psplat_asset *asset, size_t index) {
    return index < psplat_asset_animation_count(asset) ? &asset->rig.animations[index].info : NULL;
}

const psplat_rig *psplat_asset_rig(const psplat_asset *asset) {
    return &asset->rig;
}

void psplat_asset_place(const psplat_asset *asset, size_t batch, const double world[16],
                        double model[16]) {
    place_batch(asset, batch, world, model);
}

size_t psplat_asset_rig_node(const psplat_asset *asset, size_t batch) {
    return asset->rig_nodes[batch];
}

psplat_allocator psplat_asset_allocator(const psplat_asset *asset) {
    return asset->arena.allocator;
}

const psplat_packed *psplat_asset_packed(const psplat_asset *asset, size_t batch) {
    return asset->packed[batch];
}

void psplat_asset_bounds(const psplat_asset *asset, double min[3], double max[3]) {
    for (int i = 0; i < 3; ++i) {
        min[i] = INFINITY;
        max[i] = -INFINITY;
    }
    for (size_t i = 0; i < psplat_asset_batch_count(asset); ++i)
        psplat_asset_enlarge(&asset->batches[i], asset->batches[i].model, min, max);
}

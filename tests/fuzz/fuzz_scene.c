/* SPDX-License-Identifier: MIT
 *
 * fuzz_scene.c - reads any bytes as a glTF scene. For every scene that is read, it writes an asset
 * with the scene's graph and a splat for each mesh, which the runtime must be able to open.
 */
#include "mesh_input.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "export/glb_writer.h"
#include "mesh/mesh.h"
#include "scene/instances.h"
#include "scene/scene.h"
#include "splats/splats.h"

/* ---- what holds of scenes ------------------------------------------------------------------- */

static void check_index(uint32_t index, size_t count) {
    FUZZ_DEMAND(index == PSPLAT_NO_INDEX || index < count);
}

static void check_nodes(const psplat_scene *scene) {
    size_t children = 0;
    for (size_t i = 0; i < scene->node_count; ++i) {
        const psplat_scene_node *node = &scene->nodes[i];
        check_index(node->mesh, scene->mesh_count);
        check_index(node->camera, scene->camera_count);
        check_index(node->light, scene->light_count);
        for (size_t k = 0; k < node->child_count; ++k)
            FUZZ_DEMAND(node->children[k] < scene->node_count);
        children += node->child_count;
    }
    /* Each node has at most one parent, and there is a root. */
    FUZZ_DEMAND(children <= scene->node_count);
    for (size_t i = 0; i < scene->scene_count; ++i)
        for (size_t k = 0; k < scene->scenes[i].root_count; ++k)
            FUZZ_DEMAND(scene->scenes[i].roots[k] < scene->node_count);
    check_index(scene->default_scene, scene->scene_count);
}

static void check_track(const psplat_scene_track *track) {
    FUZZ_DEMAND(track->count && track->components != 2 && track->components <= 4);
    for (size_t i = 0; i < track->count * track->components; ++i)
        FUZZ_DEMAND(isfinite(track->values[i]));
    for (size_t i = 1; i < track->count && track->components == 1; ++i)
        FUZZ_DEMAND(track->values[i - 1] >= 0 && track->values[i] > track->values[i - 1]);
}

/* Animations refer to what there is, and to nodes without a matrix. */
static void check_animations(const psplat_scene *scene) {
    for (size_t i = 0; i < scene->track_count; ++i) check_track(&scene->tracks[i]);
    for (size_t i = 0; i < scene->animation_count; ++i) {
        const psplat_scene_animation *animation = &scene->animations[i];
        FUZZ_DEMAND(animation->channel_count);
        for (size_t k = 0; k < animation->sampler_count; ++k) {
            const psplat_scene_sampler *s = &animation->samplers[k];
            size_t each = s->interpolation == PSPLAT_SCENE_CUBICSPLINE ? 3 : 1;
            FUZZ_DEMAND(s->times < scene->track_count && s->values < scene->track_count);
            FUZZ_DEMAND(scene->tracks[s->times].components == 1);
            FUZZ_DEMAND(scene->tracks[s->values].count == each * scene->tracks[s->times].count);
        }
        for (size_t k = 0; k < animation->channel_count; ++k) {
            const psplat_scene_channel *channel = &animation->channels[k];
            FUZZ_DEMAND(channel->sampler < animation->sampler_count);
            FUZZ_DEMAND(channel->node < scene->node_count);
            FUZZ_DEMAND(scene->nodes[channel->node].is_animated);
            FUZZ_DEMAND(!scene->nodes[channel->node].has_matrix);
        }
    }
}

static void check_groups(const psplat_scene *scene) {
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        const psplat_mesh *mesh = &scene->meshes[i].mesh;
        for (size_t t = 0; t < mesh->triangle_count && mesh->source_materials; ++t)
            FUZZ_DEMAND(mesh->groups[t] < mesh->source_material_count);
    }
}

static void check_instances(const psplat_scene *scene) {
    psplat_instance *instances;
    size_t count;
    for (uint32_t i = 0; i <= scene->scene_count; ++i) {
        uint32_t index = i < scene->scene_count ? i : PSPLAT_NO_INDEX;
        if (psplat_scene_instances(scene, index, &instances, &count, NULL)) return;
        for (size_t k = 0; k < count; ++k)
            FUZZ_DEMAND(instances[k].mesh < scene->mesh_count && isfinite(instances[k].stretch) &&
                        instances[k].stretch > 0);
        free(instances);
    }
}

/* ---- what is written
 * ------------------------------------------------------------------------------ */

static const psplat_splat one_splat = {
    .normal = {0, 0, 1}, .rotation = {0, 0, 0, 1}, .radius = {1, 1}, .color = {1, 1, 1, 1}};
static const psplat_run one_run = {.count = 1, .depth_tolerance = 0.5f};

/* Makes the splats of a mesh: a single one, in the file as it is in memory. */
static psplat_splats fallback(const psplat_mesh *mesh, psplat_splat *splat, psplat_run *run,
                              psplat_material *material) {
    *splat = one_splat;
    *run = one_run;
    *material =
        mesh->source_materials ? mesh->source_materials[mesh->groups[0]].material : mesh->material;
    psplat_splats out = {
        .splats = splat,
        .count = 1,
        .runs = run,
        .run_count = 1,
        .materials = material,
        .material_count = 1,
        .kernel = {PSPLAT_DEFAULT_KERNEL_SHARPNESS, PSPLAT_DEFAULT_KERNEL_EXPONENT}};
    for (int k = 0; k < 3; ++k) out.origin[k] = mesh->origin[k];
    return out;
}

static void write_and_open(const psplat_scene *scene, const psplat_splats *splats) {
    uint8_t *data = NULL;
    size_t size = 0;
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    if (psplat_scene_write(scene, splats, NULL, &data, &size, &error)) return;
    psplat_result result = psplat_asset_open_memory(data, size, NULL, &asset, &error);
    /* A placement may move a mesh outside the range of floats, where its node almost did. */
    FUZZ_DEMAND(!result || result == PSPLAT_ERROR_RANGE || result == PSPLAT_ERROR_UNSUPPORTED);
    psplat_asset_destroy(asset);
    free(data);
}

static void use_scene(const psplat_scene *scene) {
    check_nodes(scene);
    check_animations(scene);
    check_groups(scene);
    check_instances(scene);
    size_t count = scene->mesh_count;
    psplat_splats *splats = calloc(count + 1, sizeof *splats);
    psplat_splat *each = calloc(count + 1, sizeof *each);
    psplat_run *runs = calloc(count + 1, sizeof *runs);
    psplat_material *materials = calloc(count + 1, sizeof *materials);
    for (size_t i = 0; splats && each && runs && materials && i < count; ++i)
        if (scene->meshes[i].mesh.triangle_count)
            splats[i] = fallback(&scene->meshes[i].mesh, &each[i], &runs[i], &materials[i]);
    if (splats && each && runs && materials) write_and_open(scene, splats);
    free(splats);
    free(each);
    free(runs);
    free(materials);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_read_scene(data, size, use_scene);
    return 0;
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * graph_json.c - the node graph of a scene as glTF JSON (glTF 2.0 sections 3.5 and 3.10,
 * KHR_lights_punctual). Nodes keep the indices of the source file, so that references to them stay
 * valid; the nodes that splats need are added after them.
 */
#include "export/graph_json.h"

#include "base/json_writer.h"
#include "scene/node_transform.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

static const double default_outer_cone = 0.7853981633974483; /* pi / 4, of KHR_lights_punctual */

/* ---- members of all objects ------------------------------------------------------------------ */

static void add_name(psplat_writer *json, const char *name) {
    if (name && *name) psplat_writer_string(json, "name", name);
}

static void add_extras(psplat_writer *json, const char *extras) {
    if (extras) psplat_writer_raw(json, "extras", extras);
}

static void add_indices(psplat_writer *json, const char *key, const uint32_t *indices, size_t count,
                        uint32_t last) {
    if (!count && last == PSPLAT_NO_INDEX) return; /* glTF has no empty arrays */
    psplat_writer_open(json, key, '[');
    for (size_t i = 0; i < count; ++i) psplat_writer_count(json, NULL, indices[i]);
    if (last != PSPLAT_NO_INDEX) psplat_writer_count(json, NULL, last);
    psplat_writer_close(json, ']');
}

static int all_are(const double *values, size_t count, double value) {
    for (size_t i = 0; i < count; ++i)
        if (values[i] != value) return 0;
    return 1;
}

static void add_numbers(psplat_writer *json, const char *key, const double *values, size_t count,
                        double default_value) {
    if (!all_are(values, count, default_value)) psplat_writer_numbers(json, key, values, count);
}

/* ---- nodes ----------------------------------------------------------------------------------- */

static int is_identity(const psplat_dequantize_transform *placement) {
    return placement->scale == 1 && all_are(placement->translation, 3, 0);
}

/* Returns whether nothing but the node's mesh depends on its transform. Animations replace that of
 * the nodes that they move. */
static int takes_placement(const psplat_scene *scene, const psplat_scene_node *node) {
    return scene->is_made ||
           (!node->name && !node->extras && !node->child_count && !node->is_animated &&
            node->camera == PSPLAT_NO_INDEX && node->light == PSPLAT_NO_INDEX);
}

/* Returns the node with the placement multiplied into its transform. The placement's scale is
 * uniform, so that it joins the node's own scale. */
static psplat_scene_node placed(const psplat_scene_node *node,
                                const psplat_dequantize_transform *placement) {
    psplat_scene_node out = *node;
    double local[16];
    psplat_scene_local(node, local);
    for (int row = 0; row < 3; ++row) {
        double sum = local[12 + row];
        for (int k = 0; k < 3; ++k) sum += local[4 * k + row] * placement->translation[k];
        (out.has_matrix ? out.matrix + 12 : out.translation)[row] = sum;
        out.scale[row] *= placement->scale;
    }
    for (int i = 0; i < 12 && out.has_matrix; ++i)
        if (i % 4 < 3) out.matrix[i] *= placement->scale;
    return out;
}

static void add_transform(psplat_writer *json, const psplat_scene_node *node) {
    static const double none[4] = {0, 0, 0, 1};
    if (node->has_matrix) {
        psplat_writer_numbers(json, "matrix", node->matrix, 16);
        return;
    }
    add_numbers(json, "translation", node->translation, 3, 0);
    if (memcmp(node->rotation, none, sizeof none) != 0)
        psplat_writer_numbers(json, "rotation", node->rotation, 4);
    add_numbers(json, "scale", node->scale, 3, 1);
}

static void add_light_of(psplat_writer *json, uint32_t light) {
    if (light == PSPLAT_NO_INDEX) return;
    psplat_writer_open(json, "extensions", '{');
    psplat_writer_open(json, "KHR_lights_punctual", '{');
    psplat_writer_count(json, "light", light);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
}

/* Writes a node. child is one more child beside the node's own, or PSPLAT_NO_INDEX. */
static void add_node(psplat_writer *json, const psplat_scene_node *node, uint32_t mesh,
                     uint32_t child) {
    psplat_writer_open(json, NULL, '{');
    add_name(json, node->name);
    add_transform(json, node);
    if (mesh != PSPLAT_NO_INDEX) psplat_writer_count(json, "mesh", mesh);
    if (node->camera != PSPLAT_NO_INDEX) psplat_writer_count(json, "camera", node->camera);
    add_indices(json, "children", node->children, node->child_count, child);
    add_light_of(json, node->light);
    add_extras(json, node->extras);
    psplat_writer_close(json, '}');
}

static void add_placement(psplat_writer *json, const psplat_dequantize_transform *placement,
                          uint32_t mesh) {
    const double scale[3] = {placement->scale, placement->scale, placement->scale};
    psplat_writer_open(json, NULL, '{');
    add_numbers(json, "translation", placement->translation, 3, 0);
    add_numbers(json, "scale", scale, 3, 1);
    psplat_writer_count(json, "mesh", mesh);
    psplat_writer_close(json, '}');
}

/* Returns the index in the file of the node's mesh, or PSPLAT_NO_INDEX. */
static uint32_t mesh_of(const psplat_scene_node *node, const uint32_t *meshes) {
    return node->mesh == PSPLAT_NO_INDEX ? PSPLAT_NO_INDEX : meshes[node->mesh];
}

static int needs_child(const psplat_scene *scene, const psplat_scene_node *node,
                       const psplat_dequantize_transform *placements, const uint32_t *meshes) {
    return mesh_of(node, meshes) != PSPLAT_NO_INDEX && !is_identity(&placements[node->mesh]) &&
           !takes_placement(scene, node);
}

static void add_nodes(psplat_writer *json, const psplat_scene *scene,
                      const psplat_dequantize_transform *placements, const uint32_t *meshes) {
    uint32_t next = (uint32_t)scene->node_count;
    psplat_writer_open(json, "nodes", '[');
    for (size_t i = 0; i < scene->node_count; ++i) {
        const psplat_scene_node *node = &scene->nodes[i];
        uint32_t mesh = mesh_of(node, meshes);
        if (mesh == PSPLAT_NO_INDEX) {
            add_node(json, node, PSPLAT_NO_INDEX, PSPLAT_NO_INDEX);
        } else if (needs_child(scene, node, placements, meshes)) {
            add_node(json, node, PSPLAT_NO_INDEX, next++);
        } else if (is_identity(&placements[node->mesh])) {
            add_node(json, node, mesh, PSPLAT_NO_INDEX);
        } else {
            const psplat_scene_node moved = placed(node, &placements[node->mesh]);
            add_node(json, &moved, mesh, PSPLAT_NO_INDEX);
        }
    }
    for (size_t i = 0; i < scene->node_count; ++i) {
        const psplat_scene_node *node = &scene->nodes[i];
        if (needs_child(scene, node, placements, meshes))
            add_placement(json, &placements[node->mesh], meshes[node->mesh]);
    }
    psplat_writer_close(json, ']');
}

/* ---- scenes, cameras, lights ----------------------------------------------------------------- */

static void add_views(psplat_writer *json, const psplat_scene *scene) {
    if (scene->default_scene != PSPLAT_NO_INDEX)
        psplat_writer_count(json, "scene", scene->default_scene);
    psplat_writer_open(json, "scenes", '[');
    for (size_t i = 0; i < scene->scene_count; ++i) {
        const psplat_scene_view *view = &scene->scenes[i];
        psplat_writer_open(json, NULL, '{');
        add_name(json, view->name);
        add_indices(json, "nodes", view->roots, view->root_count, PSPLAT_NO_INDEX);
        add_extras(json, view->extras);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

static void add_camera(psplat_writer *json, const psplat_scene_camera *camera) {
    const char *type = camera->is_orthographic ? "orthographic" : "perspective";
    psplat_writer_open(json, NULL, '{');
    add_name(json, camera->name);
    psplat_writer_string(json, "type", type);
    psplat_writer_open(json, type, '{');
    if (camera->is_orthographic) {
        psplat_writer_number(json, "xmag", camera->xmag);
        psplat_writer_number(json, "ymag", camera->ymag);
    } else {
        if (camera->aspect_ratio > 0)
            psplat_writer_number(json, "aspectRatio", camera->aspect_ratio);
        psplat_writer_number(json, "yfov", camera->yfov);
    }
    psplat_writer_number(json, "znear", camera->znear);
    if (camera->zfar > 0) psplat_writer_number(json, "zfar", camera->zfar);
    psplat_writer_close(json, '}');
    add_extras(json, camera->extras);
    psplat_writer_close(json, '}');
}

static void add_light(psplat_writer *json, const psplat_scene_light *light) {
    static const char *const types[] = {"directional", "point", "spot"};
    psplat_writer_open(json, NULL, '{');
    add_name(json, light->name);
    psplat_writer_string(json, "type", types[light->type]);
    add_numbers(json, "color", light->color, 3, 1);
    if (light->intensity != 1) psplat_writer_number(json, "intensity", light->intensity);
    if (light->range > 0) psplat_writer_number(json, "range", light->range);
    if (light->type == PSPLAT_SCENE_SPOT) {
        psplat_writer_open(json, "spot", '{');
        if (light->inner_cone != 0) psplat_writer_number(json, "innerConeAngle", light->inner_cone);
        /* tinygltf rounds its default. */
        if (fabs(light->outer_cone - default_outer_cone) > 1e-9)
            psplat_writer_number(json, "outerConeAngle", light->outer_cone);
        psplat_writer_close(json, '}');
    }
    add_extras(json, light->extras);
    psplat_writer_close(json, '}');
}

void psplat_graph_write_asset(psplat_writer *json, const psplat_scene *scene) {
    if (scene->copyright) psplat_writer_string(json, "copyright", scene->copyright);
    add_extras(json, scene->asset_extras);
}

void psplat_graph_write(psplat_writer *json, const psplat_scene *scene,
                        const psplat_dequantize_transform *placements, const uint32_t *meshes) {
    if (scene->scene_count) add_views(json, scene);
    if (scene->node_count) add_nodes(json, scene, placements, meshes);
    if (scene->camera_count) {
        psplat_writer_open(json, "cameras", '[');
        for (size_t i = 0; i < scene->camera_count; ++i) add_camera(json, &scene->cameras[i]);
        psplat_writer_close(json, ']');
    }
    add_extras(json, scene->extras);
}

void psplat_graph_write_lights(psplat_writer *json, const psplat_scene *scene) {
    if (!scene->light_count) return;
    psplat_writer_open(json, "KHR_lights_punctual", '{');
    psplat_writer_open(json, "lights", '[');
    for (size_t i = 0; i < scene->light_count; ++i) add_light(json, &scene->lights[i]);
    psplat_writer_close(json, ']');
    psplat_writer_close(json, '}');
}

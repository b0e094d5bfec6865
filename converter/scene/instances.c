/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * instances.c - mesh instances: the global transforms with which nodes place meshes.
 *
 * Transforms are multiplied along the tree of nodes (glTF 2.0 section 3.5) in double precision.
 */
#include "scene/instances.h"

#include "base/eigen.h"
#include "mesh/mesh.h"
#include "scene/node_transform.h"
#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

/* A transform flattens if its axes span less than this fraction of the volume that they would span
 * at right angles. They lie in a plane then, up to rounding. Flattened splats cannot be seen. */
static const double min_volume_fraction = 1e-14;

/* ---- matrices ------------------------------------------------------------------------------- */

static void multiply(const double a[16], const double b[16], double product[16]) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += a[4 * k + row] * b[4 * column + k];
            product[4 * column + row] = sum;
        }
}

static double determinant(const double m[16]) {
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
           m[8] * (m[1] * m[6] - m[2] * m[5]);
}

/* Returns the greatest singular value of the upper left 3 x 3: the square root of the greatest
 * eigenvalue of M^T M, scaled so that it does not over- or underflow. *flat is set if the matrix
 * maps space to a plane, line or point. */
static double stretch_of(const double matrix[16], int *flat) {
    double largest = 0, m[16], values[3], vectors[3][3], products[6];
    for (int i = 0; i < 12; ++i)
        if (i % 4 < 3) largest = fmax(largest, fabs(matrix[i]));
    *flat = 1;
    if (!(largest > 0)) return 0;
    for (int i = 0; i < 12; ++i) m[i] = matrix[i] / largest;
    for (int i = 0, at = 0; i < 3; ++i)
        for (int k = i; k < 3; ++k, ++at)
            products[at] =
                m[4 * i] * m[4 * k] + m[4 * i + 1] * m[4 * k + 1] + m[4 * i + 2] * m[4 * k + 2];
    psplat_eigen(products, values, vectors);
    double volume = sqrt(products[0]) * sqrt(products[3]) * sqrt(products[5]);
    *flat = !(fabs(determinant(m)) > min_volume_fraction * volume);
    return sqrt(values[2]) * largest;
}

/* ---- animated scales ------------------------------------------------------------------------- */

static void grow_scale(double scale[3], const float value[3]) {
    for (int k = 0; k < 3; ++k) scale[k] = fmax(scale[k], fabs((double)value[k]));
}

/* Stores for each node the greatest absolute scale along each axis that it has at rest or at a key
 * of an animation. */
static void find_scales(const psplat_scene *scene, double (*scales)[3]) {
    for (size_t i = 0; i < scene->node_count; ++i)
        for (int k = 0; k < 3; ++k) scales[i][k] = fabs(scene->nodes[i].scale[k]);
    for (size_t i = 0; i < scene->animation_count; ++i)
        for (size_t k = 0; k < scene->animations[i].channel_count; ++k) {
            const psplat_scene_channel *channel = &scene->animations[i].channels[k];
            const psplat_scene_sampler *sampler = &scene->animations[i].samplers[channel->sampler];
            const psplat_scene_track *track = &scene->tracks[sampler->values];
            int is_spline = sampler->interpolation == PSPLAT_SCENE_CUBICSPLINE;
            if (channel->path != PSPLAT_SCENE_SCALE) continue;
            for (size_t at = is_spline ? 1 : 0; at < track->count; at += is_spline ? 3 : 1)
                grow_scale(scales[channel->node], track->values + 3 * at);
        }
}

/* ---- traversal ------------------------------------------------------------------------------ */

typedef struct walk {
    const psplat_scene *scene;
    psplat_instance *instances; /* room for one of each node */
    double (*scales)[3];        /* of each node, as find_scales stores them */
    size_t count, flat;         /* instances listed, and instances left out as flat */
    uint32_t non_finite;        /* a node whose transform is not finite, or PSPLAT_NO_INDEX */
} walk;

/* Computes the local transform that a node has where its animations make it largest. */
static void grown_local(const walk *w, uint32_t index, double matrix[16]) {
    psplat_scene_node node = w->scene->nodes[index];
    for (int k = 0; k < 3 && node.is_animated; ++k) node.scale[k] = w->scales[index][k];
    psplat_scene_local(&node, matrix);
}

/* Lists the instances of a node and its children, which lie in the parent's transform at rest and
 * in the one where animations make it largest. The recursion is as deep as nodes are nested, 64 at
 * most. */
static void visit(walk *w, uint32_t index, const double parent[16], const double grown_parent[16]) {
    const psplat_scene_node *node = &w->scene->nodes[index];
    psplat_instance *instance = &w->instances[w->count];
    double local[16], global[16], grown[16];
    int flat;
    psplat_scene_local(node, local);
    multiply(parent, local, global);
    grown_local(w, index, local);
    multiply(grown_parent, local, grown);
    for (int i = 0; i < 16; ++i)
        if (!isfinite(global[i]) || !isfinite(grown[i])) w->non_finite = index;
    if (node->mesh != PSPLAT_NO_INDEX && w->scene->meshes[node->mesh].mesh.triangle_count) {
        instance->mesh = node->mesh;
        instance->node = index;
        instance->stretch = stretch_of(grown, &flat);
        memcpy(instance->matrix, global, sizeof global);
        w->flat += flat != 0;
        w->count += !flat;
    }
    for (size_t i = 0; i < node->child_count; ++i) visit(w, node->children[i], global, grown);
}

/* Lists the instances of all trees of nodes. */
static psplat_result visit_all(walk *w) {
    const psplat_scene *scene = w->scene;
    uint8_t *is_child = calloc(scene->node_count + 1, 1);
    if (!is_child) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < scene->node_count; ++i)
        for (size_t k = 0; k < scene->nodes[i].child_count; ++k)
            is_child[scene->nodes[i].children[k]] = 1;
    for (uint32_t i = 0; i < scene->node_count; ++i)
        if (!is_child[i]) visit(w, i, identity, identity);
    free(is_child);
    return PSPLAT_OK;
}

/* Lists the instances of one scene, or of all nodes for PSPLAT_NO_INDEX. */
static psplat_result walk_scene(walk *w, uint32_t index, psplat_error *error) {
    const psplat_scene *scene = w->scene;
    psplat_result result = PSPLAT_OK;
    w->non_finite = PSPLAT_NO_INDEX;
    w->instances = malloc((scene->node_count + 1) * sizeof *w->instances);
    w->scales = malloc((scene->node_count + 1) * sizeof *w->scales);
    if (w->scales) find_scales(scene, w->scales);
    if (!w->instances || !w->scales)
        result = PSPLAT_ERROR_MEMORY;
    else if (index == PSPLAT_NO_INDEX)
        result = visit_all(w);
    else
        for (size_t i = 0; i < scene->scenes[index].root_count; ++i)
            visit(w, scene->scenes[index].roots[i], identity, identity);
    free(w->scales);
    w->scales = NULL;
    if (!result) return PSPLAT_OK;
    free(w->instances);
    return psplat_fail(error, result, 0, "out of memory for %zu nodes", scene->node_count);
}

psplat_result psplat_scene_instances(const psplat_scene *scene, uint32_t index,
                                     psplat_instance **instances, size_t *count,
                                     psplat_error *error) {
    walk w = {.scene = scene};
    psplat_result result = walk_scene(&w, index, error);
    *instances = result ? NULL : w.instances;
    *count = result ? 0 : w.count;
    return result;
}

/* Fails if the shown scene has no triangles, since a viewer would have nothing to draw. */
static psplat_result check_shown(const psplat_scene *scene, const char *path, psplat_error *error) {
    psplat_instance *instances;
    size_t count;
    psplat_result result =
        psplat_scene_instances(scene, psplat_scene_shown(scene), &instances, &count, error);
    free(instances);
    if (result || count) return result;
    return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0,
                       "%s: the scene that it shows has no triangles", path);
}

psplat_result psplat_scene_check(psplat_scene *scene, const char *path, psplat_error *error) {
    walk w = {.scene = scene};
    psplat_result result = walk_scene(&w, PSPLAT_NO_INDEX, error);
    if (result) return result;
    free(w.instances);
    if (w.flat)
        psplat_scene_warn(scene,
                          "%zu nodes flatten their mesh by a scale of 0: splats that are "
                          "flattened are not drawn",
                          w.flat);
    if (w.non_finite == PSPLAT_NO_INDEX) return check_shown(scene, path, error);
    return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "%s: node %u: its transform is not finite",
                       path, w.non_finite);
}

uint32_t psplat_scene_shown(const psplat_scene *scene) {
    if (!scene->scene_count) return PSPLAT_NO_INDEX;
    return scene->default_scene == PSPLAT_NO_INDEX ? 0 : scene->default_scene;
}

/* ---- extent --------------------------------------------------------------------------------- */

double psplat_scene_diagonal(const psplat_scene *scene, const psplat_instance *instances,
                             size_t count) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t i = 0; i < count; ++i) {
        const psplat_mesh *mesh = &scene->meshes[instances[i].mesh].mesh;
        const double *m = instances[i].matrix;
        for (size_t v = 0; v < mesh->vertex_count; ++v) {
            double p[3];
            for (int k = 0; k < 3; ++k) p[k] = mesh->positions[3 * v + (size_t)k] + mesh->origin[k];
            for (int row = 0; row < 3; ++row) {
                double q = m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row];
                low[row] = q < low[row] ? q : low[row];
                high[row] = q > high[row] ? q : high[row];
            }
        }
    }
    if (!count) return 0;
    return hypot(hypot(high[0] - low[0], high[1] - low[1]), high[2] - low[2]);
}

/* Stores the lengths of the meshes of one scene that have none yet, and its diagonal. */
static psplat_result add_lengths(const psplat_scene *scene, uint32_t index, double *lengths,
                                 double *diagonal, psplat_error *error) {
    psplat_instance *instances;
    size_t count;
    double *stretches = calloc(scene->mesh_count + 1, sizeof *stretches);
    if (!stretches) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for meshes");
    psplat_result result = psplat_scene_instances(scene, index, &instances, &count, error);
    *diagonal = psplat_scene_diagonal(scene, instances, count);
    for (size_t i = 0; i < count; ++i)
        stretches[instances[i].mesh] = fmax(stretches[instances[i].mesh], instances[i].stretch);
    for (size_t i = 0; i < scene->mesh_count && !result; ++i)
        if (!(lengths[i] > 0) && stretches[i] > 0) lengths[i] = *diagonal / stretches[i];
    free(instances);
    free(stretches);
    return result;
}

psplat_result psplat_scene_lengths(const psplat_scene *scene, double *lengths, double *diagonal,
                                   psplat_error *error) {
    uint32_t shown = psplat_scene_shown(scene);
    double other;
    memset(lengths, 0, scene->mesh_count * sizeof *lengths);
    *diagonal = 0;
    if (scene->is_made && scene->mesh_count == 1)
        return PSPLAT_OK; /* the length of its own box is the same to the last bit */
    psplat_result result = add_lengths(scene, shown, lengths, diagonal, error);
    for (uint32_t i = 0; i < scene->scene_count && !result; ++i)
        if (i != shown) result = add_lengths(scene, i, lengths, &other, error);
    return result;
}

/* SPDX-License-Identifier: MIT
 *
 * node.c - the node tree (glTF 2.0 section 3.5). It must be a strict forest; its transforms are
 * composed in double precision, and the nodes that the default scene shows are marked. There is no
 * recursion, because a tree may be as deep as it has nodes.
 */
#include "asset/gltf.h"

#include <math.h>
#include <string.h>

enum { MESH, CHILDREN, MATRIX, TRANSLATION, ROTATION, SCALE, MEMBERS, MAX_NODES = 1 << 20 };

static const char *const names[MEMBERS] = {"mesh",        "children", "matrix",
                                           "translation", "rotation", "scale"};

static psplat_result parse_matrix(const psplat_gltf *gltf, psplat_json_value value,
                                  double matrix[16]) {
    psplat_result result = psplat_json_numbers(&gltf->json, value, "matrix", 16, matrix);
    if (result) return result;
    if (matrix[3] != 0 || matrix[7] != 0 || matrix[11] != 0 || matrix[15] != 1)
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                           "the last row of a node's matrix must be 0 0 0 1");
    return PSPLAT_OK;
}

static psplat_result normalise_rotation(const psplat_gltf *gltf, psplat_json_value value,
                                        double q[4]) {
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length >= 0.99 && length <= 1.01))
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                           "a node's rotation is not a unit quaternion");
    for (int i = 0; i < 4; ++i) q[i] /= length;
    return PSPLAT_OK;
}

void psplat_transform_compose(const psplat_transform *transform, double m[16]) {
    const double *q = transform->rotation;
    double x = q[0], y = q[1], z = q[2], w = q[3];
    const double rotation[9] = {
        1 - 2 * (y * y + z * z), 2 * (x * y + z * w),     2 * (x * z - y * w),
        2 * (x * y - z * w),     1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
        2 * (x * z + y * w),     2 * (y * z - x * w),     1 - 2 * (x * x + y * y)};
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            m[column * 4 + row] = rotation[column * 3 + row] * transform->scale[column];
    for (int row = 0; row < 3; ++row) m[12 + row] = transform->translation[row];
    for (int column = 0; column < 4; ++column) m[column * 4 + 3] = column == 3;
}

/* Reads the matrix, or the transform and the matrix that it makes. */
static psplat_result parse_transform(const psplat_gltf *gltf, const psplat_json_value *members,
                                     psplat_transform *transform, double matrix[16]) {
    *transform = (psplat_transform){{0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1}};
    int has_parts = members[TRANSLATION] || members[ROTATION] || members[SCALE];
    if (members[MATRIX] && has_parts)
        return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT,
                           psplat_gltf_offset(gltf, members[MATRIX]),
                           "a node has a matrix and also translation, rotation or scale");
    if (members[MATRIX]) return parse_matrix(gltf, members[MATRIX], matrix);
    const psplat_json *json = &gltf->json;
    psplat_result result =
        psplat_json_numbers(json, members[TRANSLATION], "translation", 3, transform->translation);
    if (!result)
        result = psplat_json_numbers(json, members[ROTATION], "rotation", 4, transform->rotation);
    if (!result && members[ROTATION])
        result = normalise_rotation(gltf, members[ROTATION], transform->rotation);
    if (!result) result = psplat_json_numbers(json, members[SCALE], "scale", 3, transform->scale);
    if (!result) psplat_transform_compose(transform, matrix);
    return result;
}

psplat_result psplat_node_transform(const psplat_gltf *gltf, size_t node,
                                    psplat_transform *transform, double matrix[16],
                                    int *has_matrix) {
    psplat_json_value members[MEMBERS];
    psplat_result result =
        psplat_json_members(&gltf->json, gltf->nodes[node].json, names, MEMBERS, members);
    if (result) return result;
    *has_matrix = members[MATRIX] != 0;
    return parse_transform(gltf, members, transform, matrix);
}

static psplat_result parse_children(psplat_gltf *gltf, size_t parent) {
    psplat_json_value children = gltf->nodes[parent].children;
    psplat_result result = psplat_json_expect(&gltf->json, children, PSPLAT_JSON_ARRAY, "children");
    if (result || !children) return result;
    psplat_json_value value = psplat_json_first(&gltf->json, children);
    for (; value; value = psplat_json_next(&gltf->json, children, value)) {
        size_t child = 0;
        result = psplat_gltf_index(gltf, value, "a child", gltf->node_count, &child);
        if (result) return result;
        if (gltf->nodes[child].parent != PSPLAT_NONE)
            return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                               "node %zu is a child twice", child);
        gltf->nodes[child].parent = parent;
    }
    return PSPLAT_OK;
}

static psplat_result parse_node(psplat_gltf *gltf, psplat_json_value value, psplat_node *node) {
    psplat_json_value members[MEMBERS];
    psplat_transform transform;
    node->json = value;
    node->parent = PSPLAT_NONE;
    psplat_result result = psplat_json_members(&gltf->json, value, names, MEMBERS, members);
    if (!result)
        result = psplat_gltf_index(gltf, members[MESH], "mesh", gltf->mesh_count, &node->mesh);
    if (!result) result = parse_transform(gltf, members, &transform, node->world);
    if (!result) node->children = members[CHILDREN];
    return result;
}

/* ---- the scene ---------------------------------------------------------------------------- */

/* Finds the JSON of the default scene: the one that "scene" names, else the first one, else 0. */
static psplat_result find_scene(const psplat_gltf *gltf, psplat_json_value *scene) {
    size_t index = 0;
    psplat_json_value array = gltf->json_scenes;
    *scene = 0;
    psplat_result result = psplat_json_expect(&gltf->json, array, PSPLAT_JSON_ARRAY, "scenes");
    size_t count = array && !result ? psplat_json_length(&gltf->json, array) : 0;
    if (!result && gltf->json_scene)
        result = psplat_gltf_index(gltf, gltf->json_scene, "scene", count, &index);
    if (result || !count) return result;
    *scene = psplat_json_first(&gltf->json, array);
    while (index--) *scene = psplat_json_next(&gltf->json, array, *scene);
    return PSPLAT_OK;
}

static psplat_result mark_root(psplat_gltf *gltf, psplat_json_value value) {
    size_t index = 0;
    psplat_result result =
        psplat_gltf_index(gltf, value, "a scene's node", gltf->node_count, &index);
    if (result) return result;
    psplat_node *node = &gltf->nodes[index];
    if (node->parent != PSPLAT_NONE || node->in_scene)
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                           "node %zu is %s", index,
                           node->in_scene ? "in the scene twice" : "not a root");
    node->in_scene = 1;
    return PSPLAT_OK;
}

/* A file without scenes shows all its roots. */
static psplat_result mark_roots(psplat_gltf *gltf) {
    static const char *const name[] = {"nodes"};
    psplat_json_value scene = 0, array = 0;
    psplat_result result = find_scene(gltf, &scene);
    if (result) return result;
    for (size_t i = 0; i < gltf->node_count && !scene; ++i)
        gltf->nodes[i].in_scene = gltf->nodes[i].parent == PSPLAT_NONE;
    if (!scene) return PSPLAT_OK;
    result = psplat_json_members(&gltf->json, scene, name, 1, &array);
    if (!result) result = psplat_json_expect(&gltf->json, array, PSPLAT_JSON_ARRAY, "nodes");
    psplat_json_value value = array && !result ? psplat_json_first(&gltf->json, array) : 0;
    for (; value && !result; value = psplat_json_next(&gltf->json, array, value))
        result = mark_root(gltf, value);
    return result;
}

/* ---- world transforms --------------------------------------------------------------------- */

/* Replaces local by parent * local; both are affine. */
static void multiply(const double parent[16], double local[16]) {
    double product[16];
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += parent[k * 4 + row] * local[column * 4 + k];
            product[column * 4 + row] = sum;
        }
    memcpy(local, product, sizeof product);
}

static psplat_result place(psplat_gltf *gltf, psplat_node *node) {
    if (node->parent != PSPLAT_NONE) {
        const psplat_node *parent = &gltf->nodes[node->parent];
        node->in_scene = parent->in_scene;
        multiply(parent->world, node->world);
    }
    for (int i = 0; i < 16; ++i)
        if (!isfinite(node->world[i]))
            return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE,
                               psplat_gltf_offset(gltf, node->json),
                               "a node's transform is not finite");
    return PSPLAT_OK;
}

/* Places parents before children, from a queue that every node enters at most once, because it has
 * at most one parent. A node that never enters lies on a cycle or below one. */
static psplat_result place_all(psplat_gltf *gltf, size_t *queue) {
    size_t queued = 0;
    for (size_t i = 0; i < gltf->node_count; ++i)
        if (gltf->nodes[i].parent == PSPLAT_NONE) queue[queued++] = i;
    for (size_t i = 0; i < queued; ++i) {
        psplat_node *node = &gltf->nodes[queue[i]];
        psplat_result result = place(gltf, node);
        if (result) return result;
        psplat_json_value children = node->children;
        psplat_json_value value = children ? psplat_json_first(&gltf->json, children) : 0;
        for (; value; value = psplat_json_next(&gltf->json, children, value)) {
            result = psplat_gltf_index(gltf, value, "a child", gltf->node_count, &queue[queued]);
            if (result) return result;
            ++queued;
        }
    }
    if (queued == gltf->node_count) return PSPLAT_OK;
    /* Every node on a cycle has children, so that at least one node keeps its mark. */
    size_t lost = 0;
    for (size_t i = 0; i < queued; ++i) gltf->nodes[queue[i]].children = 0;
    while (gltf->nodes[lost].children == 0) ++lost;
    return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE,
                       psplat_gltf_offset(gltf, gltf->nodes[lost].json),
                       "node %zu is its own ancestor or below one that is", lost);
}

psplat_result psplat_nodes_parse(psplat_gltf *gltf) {
    void *table = NULL;
    psplat_json_value array = gltf->json_nodes, value = 0;
    psplat_result result = psplat_json_expect(&gltf->json, array, PSPLAT_JSON_ARRAY, "nodes");
    if (!result && array && psplat_json_length(&gltf->json, array) > MAX_NODES)
        result = psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, psplat_gltf_offset(gltf, array),
                             "more than %d nodes", MAX_NODES);
    if (!result)
        result =
            psplat_gltf_table(gltf, array, "nodes", sizeof *gltf->nodes, &table, &gltf->node_count);
    gltf->nodes = table;
    for (size_t i = 0; i < gltf->node_count && !result; ++i) {
        value =
            i ? psplat_json_next(&gltf->json, array, value) : psplat_json_first(&gltf->json, array);
        result = parse_node(gltf, value, &gltf->nodes[i]);
    }
    for (size_t i = 0; i < gltf->node_count && !result; ++i) result = parse_children(gltf, i);
    if (!result) result = mark_roots(gltf);
    if (result) return result;
    size_t *queue = psplat_arena_take(gltf->scratch, gltf->node_count, sizeof *queue);
    if (!queue)
        return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu nodes",
                           gltf->node_count);
    return place_all(gltf, queue);
}

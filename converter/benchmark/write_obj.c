/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * write_obj.c - a mesh as OBJ, for a program that reads no other format, or to hand it normals.
 */
#include "benchmark/write_obj.h"

#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "mesh/mesh.h"
#include "table/text.h"

/* A normal that equals that of the corner before is not written again, for flat parts have many. */
typedef struct normals {
    const float *before;
    size_t count;
} normals;

static size_t add_normal(normals *n, const float normal[3], psplat_text *text) {
    int is_same = n->before && n->before[0] == normal[0] && n->before[1] == normal[1] &&
                  n->before[2] == normal[2];
    n->before = normal;
    if (is_same) return n->count;
    psplat_text_add(text, "vn %.9g %.9g %.9g\n", (double)normal[0], (double)normal[1],
                    (double)normal[2]);
    return ++n->count;
}

void psplat_write_obj(const psplat_source_mesh *source_mesh, psplat_text *text) {
    const psplat_mesh *mesh = source_mesh->mesh;
    const float *corners = source_mesh->surface.corner_normals;
    normals n = {NULL, 0};
    for (size_t i = 0; i < mesh->vertex_count; ++i)
        psplat_text_add(text, "v %.17g %.17g %.17g\n", mesh->origin[0] + mesh->positions[3 * i],
                        mesh->origin[1] + mesh->positions[3 * i + 1],
                        mesh->origin[2] + mesh->positions[3 * i + 2]);
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        size_t normal[3];
        for (size_t k = 0; k < 3; ++k) normal[k] = add_normal(&n, corners + 9 * t + 3 * k, text);
        const uint32_t *v = mesh->triangles + 3 * t;
        psplat_text_add(text, "f %u//%zu %u//%zu %u//%zu\n", v[0] + 1, normal[0], v[1] + 1,
                        normal[1], v[2] + 1, normal[2]);
    }
}

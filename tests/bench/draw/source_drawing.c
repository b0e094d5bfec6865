/* SPDX-License-Identifier: MIT
 *
 * source_drawing.c - the draw method of the source mesh; see source_drawing.h.
 */
#include "source_drawing.h"

#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "views/mesh_renderer.h"
#include "probe.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void require(psplat_result result, const char *what, const psplat_error *error) {
    if (!result) return;
    fprintf(stderr, "bench: %s: %s\n", what, error->text);
    exit(1);
}

/* Makes what is drawn of m->source. */
static void prepare(const char *path, mesh *m) {
    psplat_error error;
    require(psplat_source_mesh_create(&m->source, 0, &m->original, &error), path, &error);
    memcpy(m->center, m->original->center, sizeof m->center);
    m->radius = m->original->radius;
}

void mesh_read(const char *path, mesh *m) {
    psplat_error error;
    require(psplat_mesh_read(path, &m->source, &error), path, &error);
    prepare(path, m);
}

/* Returns the one group of all triangles, by which materials are told apart. */
static uint32_t group_of(const psplat_mesh *source) {
    uint32_t group = source->groups ? source->groups[0] : 0;
    for (size_t i = 1; source->groups && i < source->triangle_count; ++i) {
        if (source->groups[i] == group) continue;
        fprintf(stderr, "bench: only meshes of one material are simplified\n");
        exit(1);
    }
    return group;
}

void mesh_read_like(const char *path, const mesh *other, mesh *m) {
    psplat_error error;
    uint32_t group = group_of(&other->source);
    require(psplat_mesh_read(path, &m->source, &error), path, &error);
    for (size_t i = 0; m->source.groups && i < m->source.triangle_count; ++i)
        m->source.groups[i] = group;
    m->source.material = other->source.material;
    m->source.source_materials = other->source.source_materials;
    m->source.source_material_count = other->source.source_material_count;
    prepare(path, m);
}

void mesh_free(mesh *m) {
    psplat_source_mesh_destroy(m->original);
    psplat_mesh_free(&m->source);
}

static void draw(void *self, const psplat_view *view) {
    psplat_error error;
    require(psplat_mesh_renderer_draw(self, view, PSPLAT_MESH_RENDERER_LIGHT, &error), "mesh",
            &error);
}

static void destroy(void *self) {
    psplat_mesh_renderer_destroy(self);
}

draw_method draw_method_mesh(psplat_host *host, const mesh *m) {
    const psplat_mesh_renderer_desc desc = {probe_get_proc, host, m->original};
    psplat_mesh_renderer *facets = NULL;
    psplat_error error;
    require(psplat_mesh_renderer_create(&desc, &facets, &error), "mesh", &error);
    return (draw_method){"mesh", draw, destroy, facets, 0};
}

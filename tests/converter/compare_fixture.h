/* SPDX-License-Identifier: MIT
 *
 * compare_fixture.h - meshes of a few triangles, assets of a few splats, and a call that compares
 * them. Include it after cmocka.h.
 */
#ifndef PHONGSPLAT_TESTS_COMPARE_FIXTURE_H
#define PHONGSPLAT_TESTS_COMPARE_FIXTURE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vector.h"
#include "compare/shape_errors.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "near.h"
#include "scene_asset.h"

typedef struct fixture {
    psplat_mesh mesh;
    psplat_source_mesh *source;
} fixture;

/* Builds the surface again after the mesh was changed. */
static inline void fixture_finish(fixture *f) {
    psplat_error error = {0};
    psplat_source_mesh_destroy(f->source);
    if (psplat_source_mesh_create(&f->mesh, 0, &f->source, &error)) fail_msg("%s", error.text);
}

/* Makes a fixture of positions (vertex_count x 3) and triangles (triangle_count x 3 indices). */
static inline void fixture_mesh(fixture *f, const double *positions, size_t vertex_count,
                                const uint32_t *triangles, size_t triangle_count) {
    *f = (fixture){{.vertex_count = vertex_count, .triangle_count = triangle_count}, NULL};
    f->mesh.positions = malloc(vertex_count * 3 * sizeof(double));
    f->mesh.triangles = malloc(triangle_count * 3 * sizeof(uint32_t));
    assert_non_null(f->mesh.positions);
    assert_non_null(f->mesh.triangles);
    memcpy(f->mesh.positions, positions, vertex_count * 3 * sizeof(double));
    memcpy(f->mesh.triangles, triangles, triangle_count * 3 * sizeof(uint32_t));
    fixture_finish(f);
}

static inline void fixture_model(fixture *f, const char *name) {
    *f = (fixture){{0}, NULL};
    psplat_error error = {0};
    char path[512];
    snprintf(path, sizeof path, PSPLAT_SOURCE_DIR "/samples/models/%s", name);
    if (psplat_mesh_read(path, &f->mesh, &error)) fail_msg("%s", error.text);
    fixture_finish(f);
}

/* Makes the square 0 <= x, y <= 1 in the plane z = 0, which faces +z. */
static inline void fixture_square(fixture *f) {
    static const double positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    fixture_mesh(f, positions, 4, triangles, 2);
}

static inline void fixture_free(fixture *f) {
    psplat_source_mesh_destroy(f->source);
    psplat_mesh_free(&f->mesh);
}

/* Returns a scene of one splat that four clip lines cut to a rectangle in the plane z = height, and
 * that faces +z. */
static inline scene fixture_rectangle(double x0, double x1, double y0, double y1, double height) {
    scene s = scene_blank(1);
    psplat_splat *splat = &s.splats[0];
    double half[2] = {(x1 - x0) / 2, (y1 - y0) / 2}, radius = 2 * max2(half[0], half[1]);
    splat->center[0] = (float)((x0 + x1) / 2);
    splat->center[1] = (float)((y0 + y1) / 2);
    splat->center[2] = (float)height;
    for (int k = 0; k < 2; ++k) splat->radius[k] = (float)radius;
    splat->clip_count = 4;
    for (int i = 0; i < 4; ++i) {
        splat->clip[i][i / 2] = i % 2 ? -1 : 1;
        splat->clip[i][2] = (float)(half[i / 2] / radius);
    }
    return s;
}

/* Returns the scene's asset, placed by a node with this matrix (columns). */
static inline psplat_asset *fixture_open(const scene *s, const double matrix[16]) {
    size_t size, at = 0;
    uint8_t *glb = scene_glb(s, &size), *moved = calloc(1, size + 1024);
    char text[1024] = "\"matrix\":[";
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    uint32_t length;
    assert_non_null(moved);
    memcpy(&length, glb + 12, 4);
    for (int i = 0; i < 16; ++i)
        snprintf(text + strlen(text), 64, "%.17g%s", matrix[i], i < 15 ? "," : "],");
    while (strlen(text) % 4) strcat(text, " ");
    const char *node = strstr((const char *)glb + 20, "\"nodes\":[{");
    assert_non_null(node);
    at = (size_t)((const uint8_t *)node - glb) + strlen("\"nodes\":[{");
    memcpy(moved, glb, at);
    memcpy(moved + at, text, strlen(text));
    memcpy(moved + at + strlen(text), glb + at, size - at);
    /* A node has a matrix or a translation. */
    char *still = strstr((char *)moved + 20, ",\"translation\":[0,0,0]");
    if (still) memset(still, ' ', strlen(",\"translation\":[0,0,0]"));
    length += (uint32_t)strlen(text);
    size += strlen(text);
    memcpy(moved + 12, &length, 4);
    memcpy(moved + 8, &(uint32_t){(uint32_t)size}, 4);
    if (psplat_asset_open_memory(moved, size, NULL, &asset, &error)) fail_msg("%s", error.text);
    free(glb);
    free(moved);
    return asset;
}

/* The number of samples unless a test asks for another one. It is below the default for speed under
 * sanitizers. */
enum { FIXTURE_SAMPLES = 20000 };

static inline psplat_shape_desc fixture_desc(const psplat_shape_desc *desc) {
    psplat_shape_desc filled = desc ? *desc : (psplat_shape_desc){0};
    if (!filled.samples) filled.samples = FIXTURE_SAMPLES;
    return filled;
}

static inline psplat_shape_errors fixture_compare_asset(const fixture *f, const psplat_asset *asset,
                                                        const psplat_shape_desc *desc) {
    psplat_shape_errors errors;
    psplat_error error = {0};
    psplat_shape_desc filled = fixture_desc(desc);
    if (psplat_shape_compare(f->source, asset, &filled, &errors, &error))
        fail_msg("%s", error.text);
    return errors;
}

/* Compares the scene's splats with the mesh, and frees the scene. */
static inline psplat_shape_errors fixture_compare(const fixture *f, scene s,
                                                  const psplat_shape_desc *desc) {
    psplat_asset *asset = scene_open(&s);
    psplat_shape_errors errors = fixture_compare_asset(f, asset, desc);
    psplat_asset_destroy(asset);
    scene_free(&s);
    return errors;
}

static inline psplat_shape_errors fixture_compare_mesh(const fixture *f, const fixture *other,
                                                       const psplat_shape_desc *desc) {
    psplat_shape_errors errors;
    psplat_error error = {0};
    psplat_shape_desc filled = fixture_desc(desc);
    if (psplat_shape_compare_mesh(f->source, other->source, &filled, &errors, &error))
        fail_msg("%s", error.text);
    return errors;
}

#endif

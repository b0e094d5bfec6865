/* SPDX-License-Identifier: MIT
 *
 * appearance_fixture.h - a textured square, for tests of the appearance of a surface (base colour,
 * normal map, finish, emission). Include it after cmocka.h.
 */
#ifndef PHONGSPLAT_TESTS_APPEARANCE_FIXTURE_H
#define PHONGSPLAT_TESTS_APPEARANCE_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "material/image.h"
#include "material/source_materials.h"
#include "mesh/mesh.h"

/* A square from -1 to 1 in x and y that faces +z, divided into cells x cells x 2 triangles. Texture
 * coordinates run from (0, 0) at the upper left corner (-1, 1) to (1, 1) at the lower right corner
 * (1, -1). It has one source material. */
typedef struct painted {
    psplat_mesh mesh;
    psplat_source_material source_material;
    psplat_image image;
} painted;

static inline void painted_corner(painted *p, size_t corner, size_t cells, size_t x, size_t y) {
    float *uv = p->mesh.corner_uvs[0] + 2 * corner;
    p->mesh.triangles[corner] = (uint32_t)(y * (cells + 1) + x);
    uv[0] = (float)x / (float)cells;
    uv[1] = 1 - (float)y / (float)cells;
}

/* Makes the square with a size x size image; pixel gives each texel, and rows start at the upper
 * left. */
static inline void painted_make(painted *p, size_t cells, uint32_t size,
                                void (*pixel)(uint32_t x, uint32_t y, uint8_t rgba[4])) {
    *p = (painted){0};
    assert_int_equal(psplat_mesh_allocate(&p->mesh, (cells + 1) * (cells + 1), 2 * cells * cells,
                                          PSPLAT_MESH_UVS, NULL),
                     PSPLAT_OK);
    for (size_t i = 0; i < p->mesh.vertex_count; ++i) {
        p->mesh.positions[3 * i] = -1 + 2 * (double)(i % (cells + 1)) / (double)cells;
        p->mesh.positions[3 * i + 1] = -1 + 2 * (double)(i / (cells + 1)) / (double)cells;
    }
    for (size_t i = 0; i < cells * cells; ++i) {
        size_t x = i % cells, y = i / cells;
        painted_corner(p, 6 * i, cells, x, y);
        painted_corner(p, 6 * i + 1, cells, x + 1, y);
        painted_corner(p, 6 * i + 2, cells, x + 1, y + 1);
        painted_corner(p, 6 * i + 3, cells, x, y);
        painted_corner(p, 6 * i + 4, cells, x + 1, y + 1);
        painted_corner(p, 6 * i + 5, cells, x, y + 1);
    }
    assert_int_equal(psplat_image_allocate(&p->image, size, size, NULL), PSPLAT_OK);
    for (uint32_t i = 0; i < size * size; ++i)
        pixel(i % size, i / size, p->image.pixels + 4 * (size_t)i);
    p->source_material.material =
        (psplat_material){.base_color = {1, 1, 1, 1}, .metallic = 1, .roughness = 1};
    p->mesh.material = p->source_material.material;
    p->mesh.source_materials = &p->source_material;
    p->mesh.source_material_count = 1;
}

static inline void painted_free(painted *p) {
    psplat_image_free(&p->image);
    psplat_mesh_free(&p->mesh);
}

#endif

/* SPDX-License-Identifier: MIT
 *
 * charted_fixture.h - bent grids with texture coordinates, for tests of textures that splats keep.
 * Include it after stage_fixture.h.
 */
#ifndef PHONGSPLAT_TESTS_CHARTED_FIXTURE_H
#define PHONGSPLAT_TESTS_CHARTED_FIXTURE_H

#include "appearance/appearance.h"
#include "features/surface_build.h"
#include "material/source_materials.h"
#include "stage_fixture.h"

/* The image of a charted grid is this many texels wide and high. */
#define CHARTED_TEXELS 100.0

typedef struct charted {
    fixture f; /* Its surface has the appearance, which keeps one texture of each material. */
    psplat_appearance appearance;
    psplat_kept_textures kept[2];
    psplat_source_material materials[2];
} charted;

/* Makes a grid (fixture_grid); chart gives the coordinates of a corner of a triangle at a position.
 * Its surface is not built yet. */
static inline void charted_make(charted *c, uint32_t cells,
                                void (*place)(double s, double t, double p[3]),
                                void (*chart)(uint32_t triangle, const double p[3], float uv[2])) {
    *c = (charted){.appearance = {.kept_set = 0}};
    fixture_grid(&c->f, cells, cells, place);
    psplat_mesh *mesh = &c->f.mesh;
    mesh->corner_uvs[0] = malloc(6 * mesh->triangle_count * sizeof(float));
    assert_non_null(mesh->corner_uvs[0]);
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i)
        chart((uint32_t)(i / 3), mesh->positions + 3 * (size_t)mesh->triangles[i],
              mesh->corner_uvs[0] + 2 * i);
    for (int k = 0; k < 2; ++k)
        c->kept[k] = (psplat_kept_textures){.textures = {{.image = 1}},
                                            .texels = {CHARTED_TEXELS, CHARTED_TEXELS}};
    mesh->source_materials = c->materials;
    mesh->source_material_count = 2;
    c->appearance.mesh = mesh;
    c->appearance.kept = c->kept;
}

static inline void charted_build(charted *c, double crease_angle) {
    const psplat_patch_bounds bounds = {.crease_angle = crease_angle, .appearance = &c->appearance};
    assert_int_equal(psplat_surface_build_bounded(&c->f.mesh, &bounds, &c->f.surface, NULL),
                     PSPLAT_OK);
}

static inline void charted_free(charted *c) {
    fixture_free(&c->f);
}

/* Makes the surface the square from -1 to 1, in the plane z = 0. */
static inline void place_square(double s, double t, double p[3]) {
    p[0] = 2 * s - 1, p[1] = 2 * t - 1, p[2] = 0;
}

/* ---- a tube whose image is wound around it once -----------------------------------------------
 */

/* The columns of a tube's grid, its radius, its length, and the angle of its seam around the z axis
 * from x on. */
enum { CHARTED_TUBE_CELLS = 48 };
static const double charted_tube_radius = 0.2, charted_tube_length = 1.2;
static const double charted_tube_seam = 0.2;

static inline void place_tube(double s, double t, double p[3]) {
    double angle = charted_tube_seam + 2 * fixture_pi * s;
    p[0] = charted_tube_radius * cos(angle), p[1] = charted_tube_radius * sin(angle);
    p[2] = charted_tube_length * (t - 0.5);
}

/* s goes from 0 at the seam once around to 1, t is z. */
static inline void chart_tube(uint32_t triangle, const double p[3], float uv[2]) {
    double around = (atan2(p[1], p[0]) - charted_tube_seam) / (2 * fixture_pi);
    double column = (triangle / 2 % CHARTED_TUBE_CELLS + 0.5) / CHARTED_TUBE_CELLS;
    uv[0] = (float)(around + rint(column - around));
    uv[1] = (float)p[2];
}

/* Makes a tube that is closed at its seam, which is a border of charts, and builds its surface. */
static inline void charted_make_tube(charted *c) {
    charted_make(c, CHARTED_TUBE_CELLS, place_tube, chart_tube);
    uint32_t *corners = c->f.mesh.triangles, row = CHARTED_TUBE_CELLS + 1;
    for (size_t i = 0; i < 3 * c->f.mesh.triangle_count; ++i)
        if (corners[i] % row == CHARTED_TUBE_CELLS) corners[i] -= CHARTED_TUBE_CELLS;
    charted_build(c, fixture_crease_angle);
}

#endif

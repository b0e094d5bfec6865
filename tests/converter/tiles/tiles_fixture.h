/* SPDX-License-Identifier: MIT
 *
 * tiles_fixture.h - models, and the tiles of them opened by the runtime. Include it after cmocka.h.
 */
#ifndef PHONGSPLAT_TESTS_TILES_FIXTURE_H
#define PHONGSPLAT_TESTS_TILES_FIXTURE_H

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/vector.h"
#include "compare/placed_splats.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "export/meshopt_codec.h"
#include "import/read_mesh.h"
#include "mesh/clean.h"
#include "mesh/mesh.h"
#include "tiles/tile_block.h"
#include "tiles/tileset.h"

/* The tiles of a model, and what the runtime reads from their contents. */
typedef struct tiles_fixture {
    psplat_mesh mesh;
    psplat_source_mesh *source;
    psplat_tile_cell root;
    psplat_tile_block block;
    size_t *parents;
    psplat_asset **assets; /* in the order of block.tiles */
    psplat_placed_splats *placed;
    psplat_tile_cell *cells;
    size_t count;
    uint64_t hash; /* of all contents */
} tiles_fixture;

static inline void tiles_read_model(const char *name, psplat_mesh *mesh) {
    psplat_error error = {0};
    char path[512];
    snprintf(path, sizeof path, PSPLAT_SOURCE_DIR "/samples/models/%s", name);
    if (psplat_mesh_read(path, mesh, &error)) fail_msg("%s", error.text);
}

/* Makes a ball with bumps, of 2 * rings * rings * 2 triangles or so, 40 units beside the origin. */
static inline void tiles_make_bumpy(int rings, psplat_mesh *mesh) {
    size_t around = 2 * (size_t)rings, count = around * ((size_t)rings + 1), at = 0;
    psplat_error error = {0};
    *mesh = (psplat_mesh){0};
    assert_int_equal(psplat_mesh_allocate(mesh, count, 2 * around * (size_t)rings, 0, &error), 0);
    for (size_t i = 0; i <= (size_t)rings; ++i)
        for (size_t j = 0; j < around; ++j) {
            double a = 3.14159265358979 * (double)i / rings,
                   b = 3.14159265358979 * (double)j / rings;
            double r = 1 + 0.12 * sin(5 * b) * sin(a) * sin(a) * sin(4 * a);
            double *p = mesh->positions + 3 * (i * around + j);
            p[0] = 40 + r * sin(a) * cos(b), p[1] = 1.3 * r * cos(a), p[2] = -r * sin(a) * sin(b);
        }
    for (size_t i = 0; i < (size_t)rings; ++i)
        for (size_t j = 0; j < around; ++j) {
            size_t a = i * around + j, b = i * around + (j + 1) % around;
            const size_t six[] = {a, a + around, b + around, a, b + around, b};
            for (int k = 0; k < 6; ++k) mesh->triangles[at++] = (uint32_t)six[k];
        }
    if (psplat_mesh_clean(mesh, "bumpy", 0, &error)) fail_msg("%s", error.text);
}

static inline psplat_result tiles_take(void *user, const psplat_tile *tile, const uint8_t *data,
                                       size_t size, psplat_error *error) {
    tiles_fixture *f = user;
    assert_int_equal(tile->bytes, size);
    f->assets = realloc(f->assets, (f->count + 1) * sizeof *f->assets);
    assert_non_null(f->assets);
    f->assets[f->count] = NULL;
    for (size_t i = 0; i < size; ++i) f->hash = (f->hash ^ data[i]) * 0x100000001b3u;
    return psplat_asset_open_memory(data, size, NULL, &f->assets[f->count++], error);
}

static inline psplat_tile_cell tiles_root(const psplat_mesh *mesh) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i)
        for (size_t k = 0; k < 3; ++k) {
            double x = mesh->positions[3 * (size_t)mesh->triangles[i] + k] + mesh->origin[k];
            low[k] = fmin(low[k], x), high[k] = fmax(high[k], x);
        }
    return psplat_tile_cell_root(low, high);
}

/* Makes the tiles of f->mesh. most, path and has_fallback are those of the block. */
static inline void tiles_make(tiles_fixture *f, const psplat_convert_desc *options, size_t most,
                              const char *path, int has_fallback) {
    psplat_error error = {0};
    f->root = tiles_root(&f->mesh);
    const psplat_tile_block_desc desc = {.mesh = &f->mesh,
                                         .root = &f->root,
                                         .path = path,
                                         .convert = options,
                                         .finest = -1,
                                         .most = most,
                                         .codec = &psplat_meshopt_codec,
                                         .has_fallback = has_fallback,
                                         .write = tiles_take,
                                         .user = f};
    if (psplat_tile_block_make(&desc, &f->block, &error)) fail_msg("%s", error.text);
    assert_int_equal(f->count, f->block.tile_count);
    f->parents = malloc(f->count * sizeof *f->parents);
    f->placed = calloc(f->count, sizeof *f->placed);
    assert_non_null(f->parents);
    f->cells = calloc(f->count, sizeof *f->cells);
    assert_non_null(f->placed);
    assert_non_null(f->cells);
    psplat_tile *before = malloc(f->count * sizeof *before);
    assert_non_null(before);
    memcpy(before, f->block.tiles, f->count * sizeof *before);
    if (psplat_tileset_arrange(f->block.tiles, f->count, f->parents, &error))
        fail_msg("%s", error.text);
    for (size_t i = 0; i < f->count; ++i) {
        assert_string_equal(before[i].path, f->block.tiles[i].path); /* they come in this order */
        assert_true(psplat_tile_cell_find(&f->root, f->block.tiles[i].path, &f->cells[i]));
        assert_int_equal(
            psplat_placed_splats_create(f->assets[i], f->mesh.origin, &f->placed[i], &error),
            PSPLAT_OK);
        assert_int_equal(f->placed[i].splats.count, f->block.tiles[i].splats);
    }
    free(before);
    if (psplat_source_mesh_create(&f->mesh, 0, &f->source, &error)) fail_msg("%s", error.text);
}

/* Frees all but the mesh. */
static inline void tiles_clear(tiles_fixture *f) {
    for (size_t i = 0; i < f->count; ++i) {
        psplat_placed_splats_free(&f->placed[i]);
        psplat_asset_destroy(f->assets[i]);
    }
    free(f->assets);
    free(f->placed);
    free(f->cells);
    free(f->parents);
    psplat_source_mesh_destroy(f->source);
    psplat_tile_block_free(&f->block);
    const psplat_mesh mesh = f->mesh;
    *f = (tiles_fixture){.mesh = mesh};
}

static inline void tiles_free(tiles_fixture *f) {
    tiles_clear(f);
    psplat_mesh_free(&f->mesh);
}

/* Returns the level of a tile of the fixture. */
static inline const psplat_tile_level *tiles_level(const tiles_fixture *f, size_t tile) {
    return &f->block.levels[f->block.tiles[tile].level - f->block.levels[0].level];
}

/* Returns the tolerance of the conversion that a tile is from, a length. */
static inline double tiles_tolerance(const tiles_fixture *f, size_t tile) {
    const psplat_report *report = &tiles_level(f, tile)->report;
    return report->tolerance_percent / 100 * report->diagonal;
}

#endif

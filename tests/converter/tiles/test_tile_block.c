/* SPDX-License-Identifier: MIT
 *
 * Tests of blocks: those of a larger mesh cover their own cells and nothing else, together all of
 * it; contents are the same for any number of threads; fallback meshes are shared out; levels end.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "appearance/alpha_mask.h"
#include "base/region_distance.h"
#include "compare/surface_points.h"
#include "tiles/splat_extent.h"
#include "tiles_fixture.h"
#include "verify/verify.h"

#if defined(_OPENMP)
#include <omp.h>
#endif

/* FEW is so small that every mesh here is cut, however few splats it takes,
 * and ALL so large that none is. */
enum { MOST = 8, FEW = 3, ALL = 1000, SAMPLES = 20000 };

static const psplat_convert_desc quick = {
    .tolerance_percent = 2, .precision = 0.1, .effort = PSPLAT_EFFORT_NONE};
/* Fine enough for several splats across a half, so that those beside the middle are the fewer. */
static const psplat_convert_desc fine = {
    .tolerance_percent = 0.5, .precision = 0.1, .effort = PSPLAT_EFFORT_NONE};

/* Asserts that the finest tiles of a block cover all samples in its cell, within the tolerance, and
 * that each splat of them reaches the cell, which is grown by that. */
static void assert_covers_its_cell(const tiles_fixture *f, const psplat_tile_cell *cell,
                                   const psplat_surface_points *samples) {
    const psplat_tile_level *finest = &f->block.levels[f->block.level_count - 1];
    double tolerance = finest->report.tolerance_percent / 100 * finest->report.diagonal;
    double low[3], high[3], margin = psplat_verified_cover(tolerance);
    size_t inside = 0;
    for (size_t i = 0; i < samples->uniform; ++i) {
        double p[3], least = HUGE_VAL;
        along3(p, f->mesh.origin, 1, samples->points + 3 * i);
        if (!psplat_tile_cell_holds(cell, p)) continue;
        ++inside;
        for (size_t t = 0; t < f->count; ++t)
            if (f->block.tiles[t].level == finest->level && psplat_tile_cell_holds(&f->cells[t], p))
                least = psplat_region_nearest_distance(
                    f->placed[t].splats.regions, f->placed[t].splats.count,
                    f->placed[t].region_tree, tolerance, samples->points + 3 * i);
        assert_true(least <= tolerance * (1 + 1e-5));
    }
    assert_true(inside > 100);
    for (int k = 0; k < 3; ++k) {
        low[k] = cell->low[k] - f->mesh.origin[k] - margin * (1 + 1e-5);
        high[k] = cell->high[k] - f->mesh.origin[k] + margin * (1 + 1e-5);
    }
    for (size_t t = 0; t < f->count; ++t)
        for (size_t s = 0;
             f->block.tiles[t].level == finest->level && s < f->placed[t].splats.count; ++s)
            assert_true(psplat_splat_extent_meets(&f->placed[t].splats.regions[s], low, high));
}

static void blocks_cover_their_own_cells(void **state) {
    (void)state;
    tiles_fixture f = {0};
    const double shift[3] = {0, 0, 0};
    psplat_surface_points samples;
    size_t splats = 0, whole;
    tiles_make_bumpy(16, &f.mesh);
    tiles_make(&f, &fine, ALL, NULL, 0);
    whole = f.block.levels[f.block.level_count - 1].splats;
    assert_int_equal(psplat_surface_points_of_mesh(f.source, shift, SAMPLES, 3, &samples, NULL),
                     PSPLAT_OK);
    for (int half = 0; half < 2; ++half) {
        const char *const paths[] = {"0", "1"};
        psplat_tile_cell cell;
        tiles_clear(&f);
        tiles_make(&f, &fine, ALL, paths[half], 0);
        assert_true(psplat_tile_cell_find(&f.root, paths[half], &cell));
        assert_covers_its_cell(&f, &cell, &samples);
        splats += f.block.levels[f.block.level_count - 1].splats;
        for (size_t t = 0; t < f.count; ++t)
            assert_true(psplat_tile_path_is_in(f.block.tiles[t].path, paths[half]));
    }
    /* What each block leaves to the other is more than what both have. */
    assert_true(splats < whole + whole / 2);
    psplat_surface_points_free(&samples);
    tiles_free(&f);
}

static void contents_do_not_depend_on_the_number_of_threads(void **state) {
    (void)state;
    tiles_fixture f = {0};
    uint64_t hashes[2];
    tiles_make_bumpy(16, &f.mesh);
    for (int k = 0; k < 2; ++k) {
#if defined(_OPENMP)
        omp_set_num_threads(k ? 3 : 1);
#endif
        tiles_clear(&f);
        tiles_make(&f, &quick, FEW, NULL, 0);
        hashes[k] = f.hash;
        assert_true(f.count > 2);
    }
    assert_true(hashes[0] == hashes[1]);
    tiles_free(&f);
}

static int never(void *user, const psplat_tile_cell *cell) {
    (void)user;
    (void)cell;
    return 0;
}

static void cells_that_may_not_be_halved_stay_whole(void **state) {
    (void)state;
    psplat_mesh mesh;
    psplat_tile_block block;
    tiles_make_bumpy(12, &mesh);
    const psplat_tile_cell root = tiles_root(&mesh);
    const psplat_tile_block_desc desc = {.mesh = &mesh,
                                         .root = &root,
                                         .convert = &quick,
                                         .finest = 5,
                                         .most = MOST,
                                         .may_halve = never};
    assert_int_equal(psplat_tile_block_make(&desc, &block, NULL), PSPLAT_OK);
    assert_int_equal(block.tile_count, block.level_count);
    assert_int_equal(block.tiles[block.tile_count - 1].level, 5);
    assert_true(block.tiles[block.tile_count - 1].splats > MOST);
    psplat_tile_block_free(&block);
    psplat_mesh_free(&mesh);
}

/* Counts the triangles of a level's contents, by the indices of the meshes beside the splats. */
static void fallback_meshes_are_shared_out(void **state) {
    (void)state;
    tiles_fixture f = {0};
    size_t bytes = 0;
    tiles_make_bumpy(12, &f.mesh);
    tiles_make(&f, &quick, MOST, NULL, 0);
    for (size_t i = 0; i < f.count; ++i) bytes += f.block.tiles[i].bytes;
    tiles_clear(&f);
    tiles_make(&f, &quick, MOST, NULL, 1);
    for (size_t i = 0; i < f.count; ++i) {
        /* Triangles reach out of cells, and boxes hold them. */
        for (int k = 0; k < 3; ++k)
            assert_true(f.block.tiles[i].bounds[k] <= f.block.tiles[i].bounds[k + 3]);
        bytes -= f.block.tiles[i].bytes < bytes ? f.block.tiles[i].bytes : bytes;
    }
    assert_int_equal(bytes, 0); /* they take bytes */
    tiles_free(&f);
}

static psplat_result refuse(void *user, const psplat_tile *tile, const uint8_t *data, size_t size,
                            psplat_error *error) {
    (void)user;
    (void)tile;
    (void)data;
    (void)size;
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "the disk is full");
}

static void failures_end_a_block(void **state) {
    (void)state;
    psplat_mesh mesh;
    psplat_tile_block block;
    psplat_error error = {0};
    tiles_make_bumpy(8, &mesh);
    const psplat_tile_cell root = tiles_root(&mesh);
    psplat_tile_block_desc desc = {
        .mesh = &mesh, .root = &root, .convert = &quick, .finest = -1, .write = refuse};
    assert_int_equal(psplat_tile_block_make(&desc, &block, &error), PSPLAT_ERROR_WRITE);
    assert_string_equal(error.text, "the disk is full");
    assert_null(block.tiles);
    desc.path = "02";
    assert_int_equal(psplat_tile_block_make(&desc, &block, &error), PSPLAT_ERROR_ARGUMENT);
    psplat_mesh_free(&mesh);
}

/* A tolerance that is coarse for a block, since the source is large, is not what its splats have.
 */
static void errors_are_those_of_the_block(void **state) {
    (void)state;
    psplat_mesh mesh;
    psplat_tile_block block;
    psplat_error error = {0};
    tiles_make_bumpy(8, &mesh);
    const psplat_tile_cell root = tiles_root(&mesh);
    const double own = psplat_mesh_diagonal(&mesh);
    psplat_convert_desc convert = quick;
    convert.tolerance_percent = 10;
    convert.diagonal = 100 * own;
    const psplat_tile_block_desc desc = {
        .mesh = &mesh, .root = &root, .convert = &convert, .finest = -1, .deviation = 0.01 * own};
    assert_int_equal(psplat_tile_block_make(&desc, &block, &error), PSPLAT_OK);
    for (size_t i = 0; i < block.tile_count; ++i) {
        assert_true(block.tiles[i].error <= own);
        assert_true(block.tiles[i].error >= (0.2 + 0.01) * own);
    }
    psplat_tile_block_free(&block);
    psplat_mesh_free(&mesh);
}

int test_tile_block_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_cover_their_own_cells),
        cmocka_unit_test(contents_do_not_depend_on_the_number_of_threads),
        cmocka_unit_test(cells_that_may_not_be_halved_stay_whole),
        cmocka_unit_test(fallback_meshes_are_shared_out),
        cmocka_unit_test(failures_end_a_block),
        cmocka_unit_test(errors_are_those_of_the_block),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

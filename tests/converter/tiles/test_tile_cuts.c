/* SPDX-License-Identifier: MIT
 *
 * The exact tests of tiles, for a part with creases and for a smooth ball with bumps: whatever cut
 * of the tree is shown, each point of the surface is covered by the tile that owns it, each tile is
 * within its error, both ways, and cuts of several levels leave no more holes than their coarsest
 * one. What is measured is what the runtime reads from the contents, against CGAL's distances.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/random.h"
#include "base/region_distance.h"
#include "base/region_tree.h"
#include "compare/rays.h"
#include "compare/surface_points.h"
#include "measure/splat_distance.h"
#include "tiles_fixture.h"

enum { SAMPLES = 200000, CUTS = 50, RAY_CUTS = 3, RAYS = 10000 };

/* A model with the samples of its surface, and the tile of each level that owns each of them. */
typedef struct cuts_fixture {
    tiles_fixture tiles;
    psplat_surface_points samples;
    uint32_t *owners; /* level_count x samples.uniform; UINT32_MAX: none */
    uint8_t *covered; /* the same: whether the owner alone covers the sample */
} cuts_fixture;

static cuts_fixture models[2];

/* ---- coverage -------------------------------------------------------------------------------- */

/* The search for a splat that covers a point. */
typedef struct cover_search {
    const psplat_region *regions;
    double point[3], normal[3], tolerance;
    int is_covered;
} cover_search;

static int visit(void *user, uint32_t splat) {
    cover_search *s = user;
    double uvh[3], normal[3];
    psplat_region_local(&s->regions[splat], s->point, uvh);
    if (!(fabs(uvh[2]) <= s->tolerance)) return 0;
    /* Values of files are single precision. */
    if (!psplat_region_contains(&s->regions[splat], uvh, 1 + 1e-5, 1e-5)) return 0;
    psplat_region_normal(&s->regions[splat], uvh, normal);
    return s->is_covered = dot3(normal, s->normal) > 0;
}

static size_t owner_of(const tiles_fixture *f, int level, const double point[3]) {
    double p[3];
    size_t owner = UINT32_MAX, count = 0;
    along3(p, f->mesh.origin, 1, point);
    /* The origin was subtracted in double. All of a model is within 64 units of its file's. */
    psplat_tile_cell_settle(&f->root, 64, p);
    for (size_t i = 0; i < f->count; ++i)
        if (f->block.tiles[i].level == level && psplat_tile_cell_holds(&f->cells[i], p))
            owner = i, ++count;
    assert_true(count <= 1);
    return owner;
}

static void judge_samples(cuts_fixture *c) {
    tiles_fixture *f = &c->tiles;
    size_t count = c->samples.uniform;
    c->owners = malloc(f->block.level_count * count * sizeof *c->owners);
    c->covered = calloc(f->block.level_count * count, 1);
    assert_non_null(c->owners);
    assert_non_null(c->covered);
    for (size_t l = 0; l < f->block.level_count; ++l)
        for (size_t i = 0; i < count; ++i) {
            const double *p = c->samples.points + 3 * i;
            size_t owner = owner_of(f, f->block.levels[l].level, p);
            c->owners[l * count + i] = (uint32_t)owner;
            if (owner == UINT32_MAX) continue;
            cover_search s = {.regions = f->placed[owner].splats.regions,
                              .tolerance = tiles_tolerance(f, owner) * (1 + 1e-5)};
            memcpy(s.point, p, sizeof s.point);
            for (size_t k = 0; k < 3; ++k) s.normal[k] = (double)c->samples.normals[3 * i + k];
            psplat_region_tree_visit(f->placed[owner].splats.region_tree, p, visit, &s);
            c->covered[l * count + i] = (uint8_t)s.is_covered;
        }
}

static void make_model(cuts_fixture *c, double tolerance, size_t most) {
    const psplat_convert_desc options = {
        .tolerance_percent = tolerance, .precision = 0.1, .effort = PSPLAT_EFFORT_NONE};
    const double shift[3] = {0, 0, 0};
    tiles_make(&c->tiles, &options, most, NULL, 0);
    for (size_t i = 0; i < c->tiles.count; ++i)
        assert_int_equal(
            psplat_placed_splats_reach(&c->tiles.placed[i], 3 * tiles_tolerance(&c->tiles, i)),
            PSPLAT_OK);
    assert_int_equal(
        psplat_surface_points_of_mesh(c->tiles.source, shift, SAMPLES, 17, &c->samples, NULL),
        PSPLAT_OK);
    judge_samples(c);
}

static int set_up(void **state) {
    (void)state;
    tiles_read_model("part.obj", &models[0].tiles.mesh);
    make_model(&models[0], 1, 32);
    tiles_make_bumpy(24, &models[1].tiles.mesh);
    make_model(&models[1], 0.4, 24);
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        tiles_free(&models[m].tiles);
        psplat_surface_points_free(&models[m].samples);
        free(models[m].owners);
        free(models[m].covered);
    }
    return 0;
}

/* Marks the tiles of a random cut, from a tile down. */
static void cut_below(const tiles_fixture *f, size_t tile, double down, uint64_t *random,
                      uint8_t *shown) {
    size_t children = 0;
    for (size_t i = tile + 1; i < f->count; ++i) children += f->parents[i] == tile;
    if (!children || (tile && psplat_random_unit(random) >= down)) {
        shown[tile] = 1;
        return;
    }
    for (size_t i = tile + 1; i < f->count; ++i)
        if (f->parents[i] == tile) cut_below(f, i, down, random, shown);
}

static uint8_t *random_cut(const tiles_fixture *f, uint64_t seed) {
    uint8_t *shown = calloc(f->count, 1);
    assert_non_null(shown);
    cut_below(f, 0, 0.5, &seed, shown);
    return shown;
}

static void trees_have_several_levels_and_tiles(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        const tiles_fixture *f = &models[m].tiles;
        assert_true(f->block.level_count >= 3 && f->count >= 8);
        for (size_t i = 1; i < f->count; ++i) {
            const psplat_tile *tile = &f->block.tiles[i], *parent = &f->block.tiles[f->parents[i]];
            assert_true(tile->level == parent->level + 1);
            assert_true(tile->error <= parent->error);
            assert_true(psplat_tile_path_is_in(tile->path, parent->path));
        }
    }
}

/* A sample is in exactly one tile of a cut, and that one covers it. */
static void cuts_cover_each_sample_by_its_owner(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        const cuts_fixture *c = &models[m];
        size_t count = c->samples.uniform, levels = c->tiles.block.level_count, mixed = 0;
        for (uint64_t cut = 0; cut < CUTS; ++cut) {
            uint8_t *shown = random_cut(&c->tiles, cut);
            size_t uncovered = 0, used = 0;
            for (size_t l = 0; l < levels; ++l) {
                int is_used = 0;
                for (size_t i = 0; i < c->tiles.count; ++i)
                    is_used |=
                        shown[i] && c->tiles.block.tiles[i].level == c->tiles.block.levels[l].level;
                used += (size_t)is_used;
            }
            mixed += used > 1;
            for (size_t i = 0; i < count; ++i) {
                size_t owners = 0;
                for (size_t l = 0; l < levels; ++l) {
                    uint32_t owner = c->owners[l * count + i];
                    if (owner == UINT32_MAX || !shown[owner]) continue;
                    ++owners;
                    uncovered += !c->covered[l * count + i];
                }
                assert_int_equal(owners, 1);
            }
            assert_int_equal(uncovered, 0);
            free(shown);
        }
        assert_true(mixed > CUTS / 4);
    }
}

static void tiles_are_within_their_errors_both_ways(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        const cuts_fixture *c = &models[m];
        const tiles_fixture *f = &c->tiles;
        size_t count = c->samples.uniform;
        for (size_t i = 0; i < f->count; ++i)
            for (size_t s = 0; s < f->placed[i].splats.count; ++s) {
                const psplat_splat_distance_desc desc = {.tolerance = f->block.tiles[i].error};
                psplat_splat_distance far;
                assert_int_equal(psplat_splat_distance_find(&f->placed[i].splats.regions[s],
                                                            f->source->distance, &desc, &far),
                                 PSPLAT_OK);
                assert_int_equal(far.nearness, PSPLAT_NEARNESS_WITHIN);
            }
        for (size_t l = 0; l < f->block.level_count; ++l)
            for (size_t i = 0; i < count; i += 20) { /* Covering says more; this is simpler. */
                uint32_t owner = c->owners[l * count + i];
                const psplat_placed_splats *placed = &f->placed[owner];
                double error = f->block.tiles[owner].error;
                assert_true(psplat_region_nearest_distance(
                                placed->splats.regions, placed->splats.count, placed->region_tree,
                                error, c->samples.points + 3 * i) <= error);
            }
    }
}

/* Counts the rays that pass the tiles that are shown, within a length. */
static size_t count_missed(const tiles_fixture *f, const uint8_t *shown, double reach) {
    const psplat_asset **assets = malloc(f->count * sizeof *assets);
    const psplat_ray_desc desc = {
        .rays = RAYS, .seed = 5, .reach = 100 * reach / f->source->surface.diagonal};
    psplat_ray_errors errors;
    size_t count = 0;
    assert_non_null(assets);
    for (size_t i = 0; i < f->count; ++i)
        if (shown[i]) assets[count++] = f->assets[i];
    assert_int_equal(psplat_rays_compare_assets(f->source, assets, count, &desc, &errors, NULL),
                     PSPLAT_OK);
    free(assets);
    return errors.missed;
}

static void mixed_cuts_have_no_more_holes_than_their_coarsest_level(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        const tiles_fixture *f = &models[m].tiles;
        for (uint64_t cut = 1; cut <= RAY_CUTS; ++cut) {
            uint8_t *shown = random_cut(f, cut), *pure = calloc(f->count, 1);
            size_t coarsest = 0;
            assert_non_null(pure);
            while (!shown[coarsest]) ++coarsest;
            for (size_t i = 0; i < f->count; ++i)
                pure[i] = f->block.tiles[i].level == f->block.tiles[coarsest].level;
            double reach = tiles_tolerance(f, coarsest);
            size_t of_mixed = count_missed(f, shown, reach), of_pure = count_missed(f, pure, reach);
            if (of_mixed > of_pure)
                fail_msg("%zu of %d rays pass a cut, %zu its coarsest level", of_mixed, RAYS,
                         of_pure);
            free(shown);
            free(pure);
        }
    }
}

/* Returns whether numbers are equal but for the rounding of a reader to single precision, which
 * depends on the ranges that a file has. */
static int are_near(const double *a, const double *b, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (!(fabs(a[i] - b[i]) <= 1e-5 * fmax(fabs(a[i]), 0.01))) return 0;
    return 1;
}

/* Returns whether two regions are those of the same splat. A file may give splats lines that cut
 * nothing off behind their own, and who places a circle may turn its axes. Nodes place the integers
 * of each file to 1/1024 of a step, which is at most half a tolerance. */
static int is_same(const psplat_region *a, const psplat_region *b, double tolerance) {
    uint32_t lines = a->line_count < b->line_count ? a->line_count : b->line_count;
    double moved = 2 * 0.5 / 1024 * tolerance;
    if (distance2_3(a->center, b->center) > 3 * moved * moved || !are_near(a->n, b->n, 3) ||
        !are_near(a->radius, b->radius, 2))
        return 0;
    if (a->radius[0] - a->radius[1] < 1e-5 * a->radius[0]) return 1;
    return are_near(a->u, b->u, 3) && are_near(a->hessian, b->hessian, 3) &&
           are_near(a->lines[0], b->lines[0], 3 * lines) && are_near(a->bends, b->bends, lines);
}

/* Returns whether a tile of the same level before this one has a region, too. */
static int is_in_tile_before(const tiles_fixture *f, size_t tile, const psplat_region *region) {
    for (size_t i = 0; i < tile; ++i)
        for (size_t s = 0;
             f->block.tiles[i].level == f->block.tiles[tile].level && s < f->placed[i].splats.count;
             ++s)
            if (is_same(&f->placed[i].splats.regions[s], region, tiles_tolerance(f, tile)))
                return 1;
    return 0;
}

/* What several tiles of a level have is the same splat in all of them. */
static void splats_of_several_tiles_are_equal(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        const tiles_fixture *f = &models[m].tiles;
        for (size_t l = 0; l < f->block.level_count; ++l) {
            const psplat_tile_level *level = &f->block.levels[l];
            size_t distinct = 0, all = 0;
            for (size_t i = 0; i < f->count; ++i)
                for (size_t s = 0;
                     f->block.tiles[i].level == level->level && s < f->placed[i].splats.count;
                     ++s, ++all)
                    distinct += !is_in_tile_before(f, i, &f->placed[i].splats.regions[s]);
            assert_int_equal(distinct, level->splats);
            assert_int_equal(all, level->tile_splats);
        }
    }
}

int test_tile_cuts_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trees_have_several_levels_and_tiles),
        cmocka_unit_test(cuts_cover_each_sample_by_its_owner),
        cmocka_unit_test(tiles_are_within_their_errors_both_ways),
        cmocka_unit_test(mixed_cuts_have_no_more_holes_than_their_coarsest_level),
        cmocka_unit_test(splats_of_several_tiles_are_equal),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

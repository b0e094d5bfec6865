/* SPDX-License-Identifier: MIT
 *
 * The exact tests of tiles larger than memory: a ball with bumps and a terrain are planned into
 * several blocks, all tasks are run and merged, and what tileset.json says is held against the
 * source. Whatever cut is shown, each point of the source lies in one tile alone, whose splats are
 * within its error of it; splats are within their tile's error of the source; cuts of several
 * levels leave no more holes than their coarsest one.
 */
#define _XOPEN_SOURCE 700 /* nftw */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <phongsplat/tiles.h>

#include "base/random.h"
#include "base/region_distance.h"
#include "compare/rays.h"
#include "compare/surface_points.h"
#include "measure/splat_distance.h"
#include "tiles/merge.h"
#include "tiles/plan.h"
#include "tiles/record.h"
#include "tiles/tile_node.h"
#include "plan_fixture.h"
#include "tiles_fixture.h"

enum { SAMPLES = 30000, CUTS = 50, RAY_CUTS = 4, RAYS = 10000, MOST_TILES = 400, DEEPEST = 16 };

/* A tile as tileset.json has it, with what the runtime reads from its content. */
typedef struct plan_tile {
    char uri[PSPLAT_TILE_CONTENT];
    psplat_tile_cell cell;
    int level;
    size_t parent, children; /* SIZE_MAX: none; their number */
    double error;            /* stated by tileset.json */
    double own;              /* by the record of its task, which nothing has raised */
    psplat_asset *asset;
    psplat_placed_splats placed;
} plan_tile;

/* A source, the tileset of its plan, and the tiles that own each sample of the source. */
typedef struct plan_fixture {
    plan_place place;
    psplat_mesh mesh;
    psplat_source_mesh *source;
    psplat_tile_plan plan;
    psplat_tile_summary summary;
    size_t simplified; /* inner blocks that have fewer triangles than what they unite */
    plan_tile *tiles;  /* parents before children */
    size_t count;
    psplat_surface_points samples;
    uint32_t (*owners)[DEEPEST]; /* of each sample, from the root on; UINT32_MAX behind the last */
    uint8_t (*covered)[DEEPEST]; /* whether that tile has splats within its own error of it */
} plan_fixture;

static plan_fixture models[2];

/* ---- sources --------------------------------------------------------------------------------- */

/* Makes a terrain of 2 side side triangles with hills, a slope and a valley. Nothing of it is
 * smaller than the tolerances whose holes are counted: outlines of what a level leaves out look
 * like holes to rays. No side of a cell goes along edges, so that triangles cross borders. */
static void make_terrain(size_t side, psplat_mesh *mesh) {
    size_t row = side + 1, at = 0;
    psplat_error error = {0};
    *mesh = (psplat_mesh){0};
    assert_int_equal(psplat_mesh_allocate(mesh, row * row, 2 * side * side, 0, &error), 0);
    for (size_t i = 0; i < row * row; ++i) {
        double x = (double)(i % row) / (double)side, z = (double)(i / row) / (double)side;
        double hills = 0.04 * sin(7 * x + 1) * cos(6 * z) + 0.008 * sin(17 * x - 9 * z);
        double slope = 0.05 * tanh(14 * (x - 0.3 - 0.2 * z));
        double off = z - 0.65 + 0.1 * sin(5 * x), valley = -0.04 * exp(-150 * off * off);
        double *p = mesh->positions + 3 * i;
        p[0] = x, p[1] = hills + slope + valley, p[2] = z;
    }
    for (size_t i = 0; i < side * side; ++i) {
        size_t a = i / side * row + i % side, c = a + row;
        const size_t six[] = {a, c, a + 1, a + 1, c, c + 1};
        for (int k = 0; k < 6; ++k) mesh->triangles[at++] = (uint32_t)six[k];
    }
}

/* Writes the mesh, and takes what was written for the source, whose numbers are rounded. */
static void settle_source(plan_fixture *f) {
    psplat_error error = {0};
    plan_place_make(&f->place);
    plan_write_stl(&f->mesh, f->place.input);
    psplat_mesh_free(&f->mesh);
    if (psplat_mesh_read(f->place.input, &f->mesh, &error)) fail_msg("%s", error.text);
    if (psplat_mesh_clean(&f->mesh, "source", 0, &error)) fail_msg("%s", error.text);
    if (psplat_source_mesh_create(&f->mesh, 0, &f->source, &error)) fail_msg("%s", error.text);
}

/* ---- the tileset ----------------------------------------------------------------------------- */

static void build(plan_fixture *f, double tolerance, uint64_t triangles, uint64_t splats) {
    psplat_error error = {0};
    const psplat_tile_options options = {
        .convert = {.tolerance_percent = tolerance, .precision = 0.1, .effort = PSPLAT_EFFORT_NONE},
        .most_triangles = triangles,
        .most_splats = splats,
        .apron = 0.0625};
    if (psplat_tile_plan_make(f->place.input, &options, "phongsplat", f->place.output, 0, &f->plan,
                              &error))
        fail_msg("%s", error.text);
    for (size_t i = 0; i < f->plan.tasks.count; ++i) {
        psplat_tile_run run;
        if (psplat_tile_node_run(&f->plan, f->place.output, i, NULL, NULL, &run, &error))
            fail_msg("%s", error.text);
        f->simplified +=
            f->plan.tasks.list[i].leaf == SIZE_MAX && run.simplified && run.simplified < run.owned;
        psplat_tile_record_free(&run.record);
    }
    if (psplat_tile_merge(&f->plan, f->place.output, &f->summary, &error))
        fail_msg("%s", error.text);
}

/* Reads a file as text, which the caller frees. */
static char *read_text(const char *path) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    long size = ftell(file);
    char *text = calloc((size_t)size + 1, 1);
    assert_non_null(text);
    rewind(file);
    assert_int_equal(fread(text, 1, (size_t)size, file), size);
    fclose(file);
    return text;
}

/* Stores a number of the text at the place where its key begins. */
static double number_of(const char *text, const char *key) {
    const char *at = strstr(text, key);
    assert_non_null(at);
    return strtod(at + strlen(key), NULL);
}

/* Checks that the region that is stated is the cell that the name of the content tells. */
static void check_region(const plan_tile *tile, const char *text) {
    const double *low = tile->cell.low, *high = tile->cell.high;
    const double expected[6] = {low[0], -high[2], low[1], high[0], -low[2], high[1]}; /* Z up */
    const char *at = strstr(text, "\"region\":[");
    assert_non_null(at);
    at += strlen("\"region\":[");
    for (int k = 0; k < 6; ++k) {
        char *end;
        double value = strtod(at, &end);
        if (!(fabs(value - expected[k]) <= 1e-12 * fmax(1, fabs(expected[k])))) /* as printed */
            fail_msg("%s: region[%d] is %g instead of %g", tile->uri, k, value, expected[k]);
        at = end + 1;
    }
}

/* Reads a tile of tileset.json from the place of its error on. */
static void read_tile(plan_fixture *f, const char *text, size_t parent) {
    plan_tile *tile = &f->tiles[f->count++];
    const char *uri = strstr(text, "\"uri\":\"");
    assert_true(f->count < MOST_TILES);
    assert_non_null(uri);
    uri += strlen("\"uri\":\"");
    *tile = (plan_tile){.parent = parent, .error = number_of(text, "\"geometricError\":")};
    snprintf(tile->uri, sizeof tile->uri, "%.*s", (int)strcspn(uri, "\""), uri);
    char path[PSPLAT_CELL_PATH];
    const char *name = strstr(tile->uri, "-r");
    assert_non_null(name);
    snprintf(path, sizeof path, "%.*s", (int)strspn(name + 2, "01"), name + 2);
    assert_true(psplat_tile_cell_find(&f->plan.leaves.root, path, &tile->cell));
    tile->level = (int)number_of(text, "\"level\":");
    check_region(tile, text);
    if (parent != SIZE_MAX) ++f->tiles[parent].children;
}

/* Reads the tree of tileset.json, which has one file here. Braces nest as tiles do. */
static void read_tileset(plan_fixture *f) {
    static const char key[] = "\"geometricError\":";
    size_t open[64], depths[64], levels = 0, depth = 0;
    char path[128];
    snprintf(path, sizeof path, "%s/tileset.json", f->place.output);
    char *text = read_text(path), *root = strstr(text, "\"root\":");
    assert_non_null(root);
    f->tiles = calloc(MOST_TILES, sizeof *f->tiles);
    assert_non_null(f->tiles);
    for (const char *at = root; *at; ++at) {
        depth += *at == '{';
        depth -= *at == '}' && depth;
        if (strncmp(at, key, strlen(key)) != 0) continue;
        while (levels && depths[levels - 1] >= depth) --levels;
        assert_true(levels < 64);
        open[levels] = f->count;
        depths[levels] = depth;
        read_tile(f, at, levels ? open[levels - 1] : SIZE_MAX);
        ++levels;
    }
    free(text);
    assert_int_equal(f->count, f->summary.tiles);
}

/* Takes the errors that the tasks have stated. */
static void read_records(plan_fixture *f) {
    psplat_error error = {0};
    for (size_t i = 0; i < f->plan.tasks.count; ++i) {
        char path[192];
        psplat_tile_record record;
        snprintf(path, sizeof path, "%s/work/%s.record", f->place.output,
                 f->plan.tasks.list[i].name);
        if (psplat_tile_record_read(path, f->plan.hash, &record, &error))
            fail_msg("%s", error.text);
        for (size_t k = 0; k < record.tile_count; ++k)
            for (size_t t = 0; t < f->count; ++t)
                if (!strcmp(f->tiles[t].uri, record.tiles[k].content))
                    f->tiles[t].own = record.tiles[k].error;
        psplat_tile_record_free(&record);
    }
}

static void open_contents(plan_fixture *f) {
    psplat_error error = {0};
    for (size_t i = 0; i < f->count; ++i) {
        plan_tile *tile = &f->tiles[i];
        char path[192];
        snprintf(path, sizeof path, "%s/%s", f->place.output, tile->uri);
        if (psplat_asset_open(path, NULL, &tile->asset, &error)) fail_msg("%s", error.text);
        assert_int_equal(
            psplat_placed_splats_create(tile->asset, f->mesh.origin, &tile->placed, &error),
            PSPLAT_OK);
        assert_true(tile->own > 0);
    }
}

/* ---- samples --------------------------------------------------------------------------------- */

/* Lists the tiles that own a sample, from the root on. Each has one child at most that does, and
 * one at least if it has children. */
static void find_owners(plan_fixture *f, size_t sample) {
    double p[3];
    size_t last = 0, depth = 0;
    along3(p, f->mesh.origin, 1, f->samples.points + 3 * sample);
    /* The origin was subtracted in double. All of a model is within 64 units of its file's. */
    psplat_tile_cell_settle(&f->plan.leaves.root, 64, p);
    memset(f->owners[sample], 0xff, sizeof f->owners[sample]);
    assert_true(psplat_tile_cell_holds(&f->tiles[0].cell, p));
    f->owners[sample][depth++] = 0;
    while (f->tiles[last].children) {
        size_t next = 0, found = 0;
        for (size_t i = last + 1; i < f->count; ++i)
            if (f->tiles[i].parent == last && psplat_tile_cell_holds(&f->tiles[i].cell, p))
                next = i, ++found;
        if (found != 1)
            fail_msg("%zu children of %s own the sample at %g %g %g", found, f->tiles[last].uri,
                     p[0], p[1], p[2]);
        last = next;
        assert_true(depth < DEEPEST);
        f->owners[sample][depth++] = (uint32_t)last;
    }
}

static void judge_samples(plan_fixture *f) {
    const double shift[3] = {0, 0, 0};
    assert_int_equal(
        psplat_surface_points_of_mesh(f->source, shift, SAMPLES, 17, &f->samples, NULL), PSPLAT_OK);
    f->owners = malloc(f->samples.uniform * sizeof *f->owners);
    f->covered = calloc(f->samples.uniform, sizeof *f->covered);
    assert_non_null(f->owners);
    assert_non_null(f->covered);
    for (size_t i = 0; i < f->samples.uniform; ++i) {
        find_owners(f, i);
        for (size_t k = 0; k < DEEPEST && f->owners[i][k] != UINT32_MAX; ++k) {
            const plan_tile *tile = &f->tiles[f->owners[i][k]];
            f->covered[i][k] =
                psplat_region_nearest_distance(tile->placed.splats.regions,
                                               tile->placed.splats.count, tile->placed.region_tree,
                                               tile->own, f->samples.points + 3 * i) <= tile->own;
        }
    }
}

/* ---- fixture --------------------------------------------------------------------------------- */

static void finish_model(plan_fixture *f, double tolerance, uint64_t triangles, uint64_t splats) {
    settle_source(f);
    build(f, tolerance, triangles, splats);
    read_tileset(f);
    read_records(f);
    open_contents(f);
    judge_samples(f);
}

static int set_up(void **state) {
    (void)state;
    /* Tiles of so few splats that leaf blocks and inner blocks have several levels. */
    tiles_make_bumpy(27, &models[0].mesh);
    finish_model(&models[0], 0.5, 500, 12);
    make_terrain(37, &models[1].mesh);
    finish_model(&models[1], 0.3, 900, 12);
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        plan_fixture *f = &models[m];
        for (size_t i = 0; i < f->count; ++i) {
            psplat_placed_splats_free(&f->tiles[i].placed);
            psplat_asset_destroy(f->tiles[i].asset);
        }
        free(f->tiles);
        free(f->owners);
        free(f->covered);
        psplat_surface_points_free(&f->samples);
        psplat_source_mesh_destroy(f->source);
        psplat_mesh_free(&f->mesh);
        psplat_tile_plan_free(&f->plan);
        plan_place_remove(&f->place);
    }
    return 0;
}

/* ---- tests ----------------------------------------------------------------------------------- */

/* The models are what is to be tested: several blocks, two waves of inner ones, simplified meshes.
 */
static void plans_have_several_levels_of_blocks(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        const plan_fixture *f = &models[m];
        const psplat_tile_tasks *tasks = &f->plan.tasks;
        int deepest = 0;
        for (size_t i = 0; i < f->count; ++i)
            if (f->tiles[i].level > deepest) deepest = f->tiles[i].level;
        assert_true(f->plan.leaves.count >= 4 && tasks->list[tasks->count - 1].wave >= 2);
        assert_true(f->simplified >= 2);
        assert_true(deepest >= 4 && f->count >= 16);
    }
}

static void trees_are_accepted_by_the_runtime(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        char path[128];
        psplat_tiles *tiles = NULL;
        psplat_error error = {0};
        const psplat_tiles_desc desc = {.max_bytes = 0};
        snprintf(path, sizeof path, "%s/tileset.json", models[m].place.output);
        if (psplat_tiles_open(&desc, path, &tiles, &error)) fail_msg("%s", error.text);
        psplat_tiles_destroy(tiles, NULL);
    }
}

/* Regions of children lie in those of their parents, and no two children have a part in common.
 * That they leave nothing of the surface out is what find_owners asserts of all samples. */
static void errors_and_regions_nest(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        const plan_fixture *f = &models[m];
        for (size_t i = 0; i < f->count; ++i) {
            const plan_tile *tile = &f->tiles[i];
            assert_true(tile->error >= tile->own * (1 - 1e-12)); /* as printed */
            if (tile->parent == SIZE_MAX) continue;
            const plan_tile *parent = &f->tiles[tile->parent];
            assert_true(tile->error <= parent->error);
            assert_true(tile->level > parent->level);
            assert_true(psplat_tile_path_is_in(tile->cell.path, parent->cell.path));
            for (size_t k = i + 1; k < f->count; ++k)
                if (f->tiles[k].parent == tile->parent) {
                    assert_false(psplat_tile_path_is_in(tile->cell.path, f->tiles[k].cell.path));
                    assert_false(psplat_tile_path_is_in(f->tiles[k].cell.path, tile->cell.path));
                }
        }
    }
}

/* Marks the tiles of a random cut, from a tile down, none coarser than a level. */
static void cut_below(const plan_fixture *f, size_t tile, int coarsest, uint64_t *random,
                      uint8_t *shown) {
    if (!f->tiles[tile].children ||
        (f->tiles[tile].level >= coarsest && psplat_random_unit(random) >= 0.6)) {
        shown[tile] = 1;
        return;
    }
    for (size_t i = tile + 1; i < f->count; ++i)
        if (f->tiles[i].parent == tile) cut_below(f, i, coarsest, random, shown);
}

static uint8_t *random_cut(const plan_fixture *f, int coarsest, uint64_t seed) {
    uint8_t *shown = calloc(f->count, 1);
    assert_non_null(shown);
    cut_below(f, 0, coarsest, &seed, shown);
    return shown;
}

/* A sample is in exactly one tile of a cut, and that one has splats within its error of it. */
static void cuts_cover_each_sample_by_its_owner(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        const plan_fixture *f = &models[m];
        for (uint64_t cut = 0; cut < CUTS; ++cut) {
            uint8_t *shown = random_cut(f, 1, cut);
            size_t uncovered = 0;
            for (size_t i = 0; i < f->samples.uniform; ++i) {
                size_t owners = 0;
                for (size_t k = 0; k < DEEPEST && f->owners[i][k] != UINT32_MAX; ++k) {
                    if (!shown[f->owners[i][k]]) continue;
                    ++owners;
                    uncovered += !f->covered[i][k];
                }
                assert_int_equal(owners, 1);
            }
            if (uncovered)
                fail_msg("%zu of %zu samples of model %d are uncovered in cut %u", uncovered,
                         f->samples.uniform, m, (unsigned)cut);
            free(shown);
        }
    }
}

static void splats_are_within_the_errors_of_their_tiles(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        const plan_fixture *f = &models[m];
        for (size_t i = 0; i < f->count; ++i)
            for (size_t s = 0; s < f->tiles[i].placed.splats.count; ++s) {
                const psplat_splat_distance_desc desc = {.tolerance = f->tiles[i].own};
                psplat_splat_distance far;
                assert_int_equal(psplat_splat_distance_find(&f->tiles[i].placed.splats.regions[s],
                                                            f->source->distance, &desc, &far),
                                 PSPLAT_OK);
                if (far.nearness != PSPLAT_NEARNESS_WITHIN)
                    fail_msg("splat %zu of %s is farther than %g from the source", s,
                             f->tiles[i].uri, f->tiles[i].own);
            }
    }
}

/* Counts the rays that pass the tiles that are shown, within a length. */
static size_t count_missed(const plan_fixture *f, const uint8_t *shown, double reach) {
    const psplat_asset **assets = malloc(f->count * sizeof *assets);
    const psplat_ray_desc desc = {
        .rays = RAYS, .seed = 5, .reach = 100 * reach / f->source->surface.diagonal};
    psplat_ray_errors errors;
    size_t count = 0;
    assert_non_null(assets);
    for (size_t i = 0; i < f->count; ++i)
        if (shown[i]) assets[count++] = f->tiles[i].asset;
    assert_int_equal(psplat_rays_compare_assets(f->source, assets, count, &desc, &errors, NULL),
                     PSPLAT_OK);
    free(assets);
    return errors.missed;
}

/* Shows the coarsest tiles of a level or finer ones: branches may lack a level. */
static uint8_t *pure_cut(const plan_fixture *f, int level) {
    uint8_t *shown = calloc(f->count, 1);
    assert_non_null(shown);
    for (size_t i = 0; i < f->count; ++i) {
        const plan_tile *tile = &f->tiles[i];
        int is_below = tile->parent != SIZE_MAX && f->tiles[tile->parent].level >= level;
        shown[i] = !is_below && (tile->level >= level || !tile->children);
    }
    return shown;
}

static void mixed_cuts_have_no_more_holes_than_their_coarsest_level(void **state) {
    (void)state;
    for (int m = 0; m < 2; ++m) {
        const plan_fixture *f = &models[m];
        for (uint64_t cut = 1; cut <= RAY_CUTS; ++cut) {
            uint8_t *shown = random_cut(f, 1 + (int)(cut % 4), cut);
            int level = INT32_MAX;
            double reach = 0;
            for (size_t i = 0; i < f->count; ++i)
                if (shown[i] && f->tiles[i].level < level) level = f->tiles[i].level;
            for (size_t i = 0; i < f->count; ++i)
                if (shown[i] && f->tiles[i].level == level) reach = fmax(reach, f->tiles[i].own);
            uint8_t *pure = pure_cut(f, level);
            size_t of_mixed = count_missed(f, shown, reach), of_pure = count_missed(f, pure, reach);
            if (of_mixed > of_pure)
                fail_msg("%zu of %d rays pass cut %u of model %d, %zu its coarsest level %d",
                         of_mixed, RAYS, (unsigned)cut, m, of_pure, level);
            free(shown);
            free(pure);
        }
    }
}

int test_plan_cuts_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plans_have_several_levels_of_blocks),
        cmocka_unit_test(trees_are_accepted_by_the_runtime),
        cmocka_unit_test(errors_and_regions_nest),
        cmocka_unit_test(cuts_cover_each_sample_by_its_owner),
        cmocka_unit_test(splats_are_within_the_errors_of_their_tiles),
        cmocka_unit_test(mixed_cuts_have_no_more_holes_than_their_coarsest_level),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

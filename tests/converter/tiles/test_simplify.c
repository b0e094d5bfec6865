/* SPDX-License-Identifier: MIT
 *
 * test_simplify.c - tests that simplified meshes of blocks are within their deviation both ways, by
 * CGAL's distances, that blocks still fit together, and that files of them are whole or refused.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/random.h"
#include "base/vector.h"
#include "mesh/distance.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"
#include "mesh/weld.h"
#include "near.h"
#include "tiles/block_mesh.h"
#include "tiles/record.h"
#include "tiles/simplify.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Returns a part of a rough landscape with a cliff, from column first on, as a welded mesh. */
static psplat_mesh make_land(uint32_t first, uint32_t columns, uint32_t rows, int has_colors) {
    psplat_tile_soup soup = {.has_colors = has_colors};
    for (uint32_t i = 0; i < 2 * columns * rows; ++i) {
        static const uint32_t squares[2][3][2] = {{{0, 0}, {0, 1}, {1, 0}},
                                                  {{1, 0}, {0, 1}, {1, 1}}};
        uint32_t x = first + i / 2 % columns, z = i / 2 / columns;
        psplat_stream_triangle t = {0};
        for (uint32_t k = 0; k < 3; ++k) {
            double u = 0.01 * (x + squares[i % 2][k][0]), v = 0.01 * (z + squares[i % 2][k][1]);
            uint64_t seed =
                (uint64_t)((x + squares[i % 2][k][0]) * 1000 + z + squares[i % 2][k][1]);
            double cliff = u > 0.5 + 0.1 * sin(9 * v) ? 0.2 : 0;
            t.positions[3 * k] = u;
            t.positions[3 * k + 1] =
                0.1 * sin(6 * u) * cos(5 * v) + cliff + 2e-4 * psplat_random_unit(&seed);
            t.positions[3 * k + 2] = v;
            for (uint32_t c = 0; c < 4; ++c) t.colors[4 * k + c] = (float)(c < 3 ? u : 1);
        }
        assert_int_equal(psplat_tile_soup_add(&soup, &t), 0);
    }
    assert_int_equal(psplat_mesh_weld(&soup.mesh, NULL), PSPLAT_OK);
    return soup.mesh;
}

/* Asserts that random points of one mesh are within a distance of another. Returns the greatest. */
static double check_distance(const psplat_mesh *from, const psplat_mesh *to, double most) {
    psplat_distance *distance = psplat_distance_create_cgal(to);
    uint64_t seed = 5;
    double greatest = 0;
    assert_non_null(distance);
    for (uint32_t t = 0; t < from->triangle_count; ++t)
        for (int i = 0; i < 2; ++i) {
            double u = psplat_random_unit(&seed), v = psplat_random_unit(&seed) * (1 - u), p[3], d;
            for (int k = 0; k < 3; ++k)
                p[k] = (1 - u - v) * psplat_mesh_corner(from, t, 0)[k] +
                       u * psplat_mesh_corner(from, t, 1)[k] +
                       v * psplat_mesh_corner(from, t, 2)[k];
            assert_int_equal(psplat_distance_query(distance, p, 1, &d), PSPLAT_OK);
            greatest = fmax(greatest, d);
        }
    assert_true(greatest <= most * (1 + 1e-9)); /* rounding of CGAL's and ours */
    psplat_distance_destroy(distance);
    return greatest;
}

static size_t count_borders(const psplat_mesh *mesh) {
    size_t borders;
    uint32_t *pairs = malloc((3 * mesh->triangle_count + 1) * sizeof *pairs);
    assert_non_null(pairs);
    assert_int_equal(psplat_edge_pairs(mesh, pairs, &borders), PSPLAT_OK);
    free(pairs);
    return borders;
}

static void deviations_are_kept_both_ways(void **state) {
    (void)state;
    const double most[] = {5e-4, 2e-3, 2e-2};
    size_t last = 2 * 80 * 40;
    psplat_mesh land = make_land(0, 80, 40, 0);
    for (size_t i = 0; i < 3; ++i) {
        psplat_mesh simple;
        double deviation;
        assert_int_equal(psplat_tile_simplify(&land, most[i], 1, &simple, &deviation), PSPLAT_OK);
        assert_true(deviation > 0 && deviation <= most[i]);
        assert_true(simple.triangle_count < last);
        last = simple.triangle_count;
        double there = check_distance(&simple, &land, deviation);
        double back = check_distance(&land, &simple, deviation);
        assert_true(fmax(there, back) > 0.2 * deviation); /* The proof is no empty promise. */
        assert_int_equal(count_borders(&simple), 2 * (80 + 40));
        psplat_mesh_free(&simple);
    }
    assert_true(last < 1000); /* of 6,400; a lock of all would show here */
    psplat_mesh_free(&land);
}

/* Returns how many triangles of a landscape that are higher than this face downwards. */
static size_t count_folds(const psplat_mesh *land, double least) {
    size_t folds = 0;
    for (uint32_t t = 0; t < land->triangle_count; ++t) {
        double sides[3][3], normal[3], longest = 0;
        for (int i = 0; i < 3; ++i) {
            sub3(sides[i], psplat_mesh_corner(land, t, (i + 1) % 3),
                 psplat_mesh_corner(land, t, i));
            longest = fmax(longest, length3(sides[i]));
        }
        cross3(normal, sides[0], sides[1]);
        folds += normal[1] < 0 && length3(normal) > least * longest;
    }
    return folds;
}

/* The source has no triangle that faces downwards, and none is made, with borders or without. What
 * stays so that none is folded is little. Of both lands some are folded if nothing is done. */
static void nothing_is_folded_over(void **state) {
    (void)state;
    static const struct {
        uint32_t columns, rows;
        double most;
        int keeps_border;
        size_t enough; /* triangles of 2 * columns * rows */
    } cases[] = {{90, 120, 1e-3, 0, 4200}, {60, 120, 4e-3, 1, 1600}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_mesh land = make_land(0, cases[i].columns, cases[i].rows, 0), simple;
        double most = cases[i].most, deviation;
        assert_int_equal(
            psplat_tile_simplify(&land, most, cases[i].keeps_border, &simple, &deviation),
            PSPLAT_OK);
        size_t folds = count_folds(&simple, most);
        if (folds || simple.triangle_count > cases[i].enough)
            fail_msg("%zu of %zu triangles are folded at %g", folds, simple.triangle_count, most);
        psplat_mesh_free(&simple);
        psplat_mesh_free(&land);
    }
}

/* Two blocks that were simplified apart have no gap between them, and neither has a mesh that is
 * simplified in parts. */
static void blocks_fit_together(void **state) {
    (void)state;
    psplat_tile_soup both = {0};
    for (uint32_t i = 0; i < 2; ++i) {
        psplat_mesh land = make_land(60 * i, 60, 280, 0), simple;
        double deviation;
        assert_int_equal(psplat_tile_simplify(&land, 1e-3, 1, &simple, &deviation), PSPLAT_OK);
        assert_int_equal(psplat_tile_soup_add_mesh(&both, &simple), PSPLAT_OK);
        psplat_mesh_free(&land);
        psplat_mesh_free(&simple);
    }
    assert_int_equal(psplat_mesh_weld(&both.mesh, NULL), PSPLAT_OK);
    assert_true(both.mesh.triangle_count < 67200 / 3);
    assert_int_equal(count_borders(&both.mesh), 2 * (120 + 280));
    psplat_tile_soup_free(&both);
}

/* Asserts that all borders of a mesh lie on the rim of a land of so many columns and rows. Returns
 * how many edges they have. */
static size_t check_rim(const psplat_mesh *mesh, uint32_t columns, uint32_t rows) {
    const double most[2] = {0.01 * columns, 0.01 * rows};
    size_t borders, count = 0;
    uint32_t *pairs = malloc((3 * mesh->triangle_count + 1) * sizeof *pairs);
    assert_non_null(pairs);
    assert_int_equal(psplat_edge_pairs(mesh, pairs, &borders), PSPLAT_OK);
    for (size_t e = 0; e < 3 * mesh->triangle_count; ++e) {
        const uint32_t ends[2] = {mesh->triangles[e], mesh->triangles[e % 3 == 2 ? e - 2 : e + 1]};
        if (pairs[e] != PSPLAT_NONE) continue;
        ++count;
        for (int i = 0; i < 2; ++i) {
            double x = mesh->positions[3 * (size_t)ends[i]];
            double z = mesh->positions[3 * (size_t)ends[i] + 2];
            double in = fmin(fmin(x, most[0] - x), fmin(z, most[1] - z));
            if (!(in <= 1e-9)) /* rounding of sums of 0.01 */
                fail_msg("a border has a vertex at %g %g, %g inside of the rim", x, z, in);
        }
    }
    free(pairs);
    return count;
}

/* Where borders may be simplified, they have as few edges as the surface needs, but those of parts
 * and of what could not be simplified do not tear, and distances are kept. */
static void borders_are_simplified_without_gaps(void **state) {
    (void)state;
    const uint32_t sizes[3][2] = {{80, 40}, {80, 40}, {70, 240}}; /* the last in two parts */
    const double most[3] = {3e-3, 9e-3, 3e-3};
    for (int i = 0; i < 3; ++i) {
        psplat_mesh land = make_land(0, sizes[i][0], sizes[i][1], 0), simple;
        double deviation;
        assert_int_equal(psplat_tile_simplify(&land, most[i], 0, &simple, &deviation), PSPLAT_OK);
        assert_true(deviation > 0 && deviation <= most[i]);
        if (i < 2) {
            check_distance(&simple, &land, deviation);
            check_distance(&land, &simple, deviation);
        }
        size_t edges = check_rim(&simple, sizes[i][0], sizes[i][1]);
        /* The noise of the borders is far less than the deviation, their waves and cliffs are long:
         * some tens of edges are enough. */
        if (!(3 * edges <= 2 * (size_t)(sizes[i][0] + sizes[i][1])))
            fail_msg("%zu edges of borders are left at %g", edges, most[i]);
        psplat_mesh_free(&land);
        psplat_mesh_free(&simple);
    }
}

/* Vertices keep their colours, which change along x alone. */
static void colours_stay_where_they_are(void **state) {
    (void)state;
    psplat_mesh land = make_land(0, 80, 40, 1), simple;
    double deviation;
    assert_int_equal(psplat_tile_simplify(&land, 5e-4, 1, &simple, &deviation), PSPLAT_OK);
    assert_non_null(simple.corner_colors);
    for (size_t i = 0; i < 3 * simple.triangle_count; ++i) {
        double x = simple.positions[3 * (size_t)simple.triangles[i]];
        assert_near((double)simple.corner_colors[4 * i], x, 1e-7); /* Colours are floats. */
    }
    psplat_mesh_free(&land);
    psplat_mesh_free(&simple);
}

static void files_are_whole_or_refused(void **state) {
    (void)state;
    psplat_mesh land = make_land(0, 9, 7, 1), read;
    psplat_error error = {0};
    double deviation;
    assert_int_equal(psplat_tile_mesh_write(&land, 0.25, "block.mesh", &error), PSPLAT_OK);
    assert_int_equal(psplat_tile_mesh_read("block.mesh", &read, &deviation, &error), PSPLAT_OK);
    assert_near(deviation, 0.25, 0);
    assert_int_equal(read.triangle_count, land.triangle_count);
    assert_memory_equal(read.positions, land.positions, 3 * land.vertex_count * sizeof(double));
    assert_memory_equal(read.triangles, land.triangles, 3 * land.triangle_count * sizeof(uint32_t));
    assert_memory_equal(read.corner_colors, land.corner_colors,
                        12 * land.triangle_count * sizeof(float));
    psplat_mesh_free(&read);
    FILE *file = fopen("block.mesh", "r+b");
    assert_non_null(file);
    fseek(file, 1000, SEEK_SET);
    fputc(1 ^ fgetc(file), file);
    fclose(file);
    assert_int_equal(psplat_tile_mesh_read("block.mesh", &read, &deviation, &error),
                     PSPLAT_ERROR_FORMAT);
    assert_int_equal(truncate("block.mesh", 900), 0);
    assert_int_equal(psplat_tile_mesh_read("block.mesh", &read, &deviation, &error),
                     PSPLAT_ERROR_FORMAT);
    assert_int_equal(truncate("block.mesh", 9), 0);
    assert_int_equal(psplat_tile_mesh_read("block.mesh", &read, &deviation, &error),
                     PSPLAT_ERROR_FORMAT);
    psplat_mesh_free(&land);
}

static void records_read_back(void **state) {
    (void)state;
    psplat_tile tiles[2] = {
        {.path = "", .level = 3, .error = 0.1, .splats = 7, .bytes = 9, .content = "tiles/3-r.glb"},
        {.path = "01", .level = 2, .error = 1 / 3.0, .content = "tiles/2-r01.glb"}};
    for (int k = 0; k < 6; ++k) tiles[1].region[k] = tiles[1].bounds[k] = 1e-300 / (k + 3);
    const psplat_tile_record record = {
        .task = "r01", .coarsest = 3, .deviation = 1e-3, .tiles = tiles, .tile_count = 2};
    psplat_tile_record read;
    psplat_error error = {0};
    assert_int_equal(psplat_tile_record_write(&record, 77, "block.record", &error), PSPLAT_OK);
    assert_int_equal(psplat_tile_record_read("block.record", 77, &read, &error), PSPLAT_OK);
    assert_string_equal(read.task, "r01");
    assert_int_equal(read.coarsest, 3);
    assert_near(read.deviation, 1e-3, 0);
    assert_int_equal(read.tile_count, 2);
    for (int i = 0; i < 2; ++i) {
        assert_string_equal(read.tiles[i].path, tiles[i].path);
        assert_string_equal(read.tiles[i].content, tiles[i].content);
        assert_int_equal(read.tiles[i].level, tiles[i].level);
        assert_memory_equal(read.tiles[i].region, tiles[i].region, sizeof tiles[i].region);
        assert_memory_equal(read.tiles[i].bounds, tiles[i].bounds, sizeof tiles[i].bounds);
        assert_near(read.tiles[i].error, tiles[i].error, 0);
    }
    psplat_tile_record_free(&read);
    assert_int_equal(psplat_tile_record_read("block.record", 78, &read, &error),
                     PSPLAT_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "belongs to another plan"));
    assert_int_equal(truncate("block.record", 100), 0);
    assert_int_equal(psplat_tile_record_read("block.record", 77, &read, &error),
                     PSPLAT_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "is not whole"));
    FILE *file = fopen("block.record", "w");
    assert_non_null(file);
    fputs("phongsplat tile record 99\nend 0123456789abcdef\n", file);
    fclose(file);
    assert_int_equal(psplat_tile_record_read("block.record", 77, &read, &error),
                     PSPLAT_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.text, "is of version 99"));
}

int test_simplify_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(deviations_are_kept_both_ways),
        cmocka_unit_test(nothing_is_folded_over),
        cmocka_unit_test(blocks_fit_together),
        cmocka_unit_test(borders_are_simplified_without_gaps),
        cmocka_unit_test(colours_stay_where_they_are),
        cmocka_unit_test(files_are_whole_or_refused),
        cmocka_unit_test(records_read_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

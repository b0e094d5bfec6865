/* SPDX-License-Identifier: MIT
 *
 * test_sheets.c - tests of sheets that have a triangle on either side: which of both are kept, and
 * that either side is then a surface of its own. The shapes are grids of squares, each given once
 * for each side.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "material/source_materials.h"
#include "mesh/clean.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"
#include "mesh/weld.h"
#include "pipeline/convert.h"
#include "splats/splats.h"
#include "verify/report.h"

enum { CELLS = 3, CORNERS = CELLS + 1, SIDE = 2 * CELLS * CELLS };

/* Makes a square in the plane z = height of 2 CELLS^2 triangles, and behind these as many that face
 * the other way, in the same order. */
static psplat_mesh sheet(unsigned parts) {
    psplat_mesh mesh;
    assert_int_equal(psplat_mesh_allocate(&mesh, CORNERS * CORNERS, 2 * SIDE, parts, NULL),
                     PSPLAT_OK);
    for (size_t v = 0; v < CORNERS * CORNERS; ++v) {
        mesh.positions[3 * v] = (double)(v % CORNERS);
        mesh.positions[3 * v + 1] = (double)(v / CORNERS);
    }
    for (size_t c = 0; c < CELLS * CELLS; ++c) {
        uint32_t a = (uint32_t)(c / CELLS * CORNERS + c % CELLS), b = a + CORNERS;
        const uint32_t front[6] = {a, a + 1, b + 1, a, b + 1, b};
        const uint32_t back[6] = {a, b + 1, a + 1, b + 1, a, b};
        memcpy(mesh.triangles + 6 * c, front, sizeof front);
        memcpy(mesh.triangles + 3 * SIDE + 6 * c, back, sizeof back);
    }
    return mesh;
}

/* Drops what is repeated, of which so many triangles remain. Those of a sheet are one side or
 * several. */
static void drop_of(psplat_mesh *mesh, int has_material, size_t kept, int is_one_side) {
    int turned = -1, two_sides = -1;
    assert_int_equal(psplat_mesh_drop_repeated(mesh, has_material, &turned, &two_sides, NULL),
                     PSPLAT_OK);
    assert_int_equal(mesh->triangle_count, kept);
    assert_int_equal(turned, is_one_side);
    assert_int_equal(two_sides, kept > SIDE);
}

static void drop(psplat_mesh *mesh, size_t kept, int is_one_side) {
    drop_of(mesh, 1, kept, is_one_side);
}

static void set_group(psplat_mesh *mesh, size_t first, size_t end, uint32_t group) {
    for (size_t t = first; t < end; ++t) mesh->groups[t] = group;
}

/* One triangle of two is enough where both look the same, and where that is all that a group has.
 */
static void test_same(void **state) {
    (void)state;
    psplat_mesh mesh = sheet(0);
    drop(&mesh, SIDE, 1);
    assert_true(psplat_mesh_shows_both_sides(&mesh, 0));
    assert_false(psplat_mesh_shows_both_sides(&mesh, 1));
    psplat_mesh_free(&mesh);
    mesh = sheet(PSPLAT_MESH_GROUPS); /* the first row of both sides is of group 2 */
    set_group(&mesh, 0, 2 * CELLS, 2);
    set_group(&mesh, SIDE, SIDE + 2 * CELLS, 2);
    drop(&mesh, SIDE, 1);
    for (size_t group = 0; group < 4; ++group)
        assert_int_equal(psplat_mesh_shows_both_sides(&mesh, group), group % 2 == 0);
    psplat_mesh_free(&mesh);
}

/* Two materials, colours or textures are two sides. */
static void test_different(void **state) {
    (void)state;
    psplat_mesh mesh = sheet(PSPLAT_MESH_GROUPS);
    set_group(&mesh, SIDE, 2 * SIDE, 1);
    drop(&mesh, 2 * SIDE, 0);
    assert_false(psplat_mesh_shows_both_sides(&mesh, 0));
    assert_false(psplat_mesh_shows_both_sides(&mesh, 1));
    psplat_mesh_free(&mesh);
    mesh = sheet(PSPLAT_MESH_COLORS);
    mesh.corner_colors[4 * (3 * SIDE + 7)] = 0.01f; /* a corner of the third back triangle */
    drop(&mesh, 2 * SIDE, 0);
    psplat_mesh_free(&mesh);
    mesh = sheet(PSPLAT_MESH_GROUPS); /* what faces the same way is repeated, whatever it looks */
    memcpy(mesh.triangles + 3 * SIDE, mesh.triangles, 3 * SIDE * sizeof(uint32_t));
    set_group(&mesh, SIDE, 2 * SIDE, 1);
    drop(&mesh, SIDE, 0);
    assert_int_equal(mesh.dropped, SIDE);
    psplat_mesh_free(&mesh);
}

/* Texture coordinates matter where a texture of the material uses them. */
static void test_textures(void **state) {
    (void)state;
    const psplat_image image = {0};
    for (uint32_t used = 0; used < 2; ++used)
        for (unsigned set = 0; set < 2; ++set) {
            const psplat_source_material material = {
                .base_color = {.image = &image, .texcoord = used}};
            psplat_mesh mesh = sheet(PSPLAT_MESH_UVS << set);
            mesh.source_materials = &material, mesh.source_material_count = 1;
            /* The vertices have values of their own, in whichever order the corners are. */
            for (size_t i = 0; i < 6 * SIDE; ++i)
                mesh.corner_uvs[set][2 * i] = (float)mesh.positions[3 * (size_t)mesh.triangles[i]];
            float *value = &mesh.corner_uvs[set][2 * (3 * SIDE + 7)];
            *value += 0.001f; /* which nobody sees */
            drop(&mesh, SIDE, 1);
            psplat_mesh_free(&mesh);
            mesh = sheet(PSPLAT_MESH_UVS << set);
            mesh.source_materials = &material, mesh.source_material_count = 1;
            mesh.corner_uvs[set][2 * (3 * SIDE + 7)] = 0.01f;
            drop(&mesh, used == set ? 2 * SIDE : SIDE, used != set);
            psplat_mesh_free(&mesh);
        }
}

/* A double-sided material shows its first side from both, as renderers do. */
static void test_double_sided(void **state) {
    (void)state;
    for (uint32_t which = 0; which < 3; ++which) {
        psplat_source_material materials[2] = {{.is_masked = 0}, {.is_masked = 0}};
        psplat_mesh mesh = sheet(PSPLAT_MESH_GROUPS);
        if (which < 2) materials[which].material.double_sided = 1;
        mesh.source_materials = materials, mesh.source_material_count = 2;
        set_group(&mesh, SIDE, 2 * SIDE, 1);
        drop(&mesh, which < 2 ? SIDE : 2 * SIDE, which < 2);
        psplat_mesh_free(&mesh);
    }
}

/* A group that has triangles without a back, too, keeps the backs of others: it would be seen from
 * behind where those are. Not so where materials do not say which sides are seen, or both are. Here
 * the last row of the sheet has no backs, and is a group of its own or not. */
static void test_mixed_groups(void **state) {
    (void)state;
    enum { ROW = 2 * CELLS };
    for (uint32_t last_group = 0; last_group < 2; ++last_group)
        for (int says = 0; says < 2; ++says)
            for (int double_sided = 0; double_sided < 2; ++double_sided) {
                psplat_mesh mesh = sheet(PSPLAT_MESH_GROUPS);
                int keeps = says && !double_sided && !last_group;
                mesh.material.double_sided = double_sided;
                set_group(&mesh, SIDE - ROW, SIDE, last_group);
                mesh.triangle_count -= ROW;
                drop_of(&mesh, says, keeps ? 2 * SIDE - ROW : SIDE, !keeps);
                psplat_mesh_free(&mesh);
            }
}

/* ---- surfaces -------------------------------------------------------------------------------- */

static void check_pairs(const psplat_mesh *mesh) {
    uint32_t pairs[6 * SIDE];
    size_t borders, folds = 0;
    assert_int_equal(psplat_edge_pairs(mesh, pairs, &borders), PSPLAT_OK);
    assert_int_equal(borders, 0);
    for (uint32_t e = 0; e < 6 * SIDE; ++e) {
        assert_true(pairs[e] < 6 * SIDE);
        assert_int_equal(pairs[pairs[e]], e);
        assert_int_equal(psplat_edge_vertex(mesh, pairs[e], 0), psplat_edge_vertex(mesh, e, 1));
        assert_int_equal(psplat_edge_vertex(mesh, pairs[e], 1), psplat_edge_vertex(mesh, e, 0));
        folds += (e < 3 * SIDE) != (pairs[e] < 3 * SIDE);
    }
    assert_int_equal(folds, 2 * 4 * CELLS); /* at the border of the sheet alone */
}

/* Inside a sheet each side goes on, and at its border one becomes the other, in whichever order
 * triangles and their corners are. */
static void test_pairs(void **state) {
    (void)state;
    psplat_mesh mesh = sheet(0);
    check_pairs(&mesh);
    for (size_t t = 0; t < 2 * SIDE; ++t) {
        uint32_t *corners = mesh.triangles + 3 * t, first = corners[0];
        if (t % 3 != 1) continue;
        corners[0] = corners[1], corners[1] = corners[2], corners[2] = first;
    }
    check_pairs(&mesh);
    for (size_t t = 0; t < SIDE / 2; ++t) { /* each side backwards */
        uint32_t held[3];
        for (size_t side = 0; side < 2; ++side) {
            uint32_t *a = mesh.triangles + 3 * (side * SIDE + t);
            uint32_t *b = mesh.triangles + 3 * (side * SIDE + SIDE - 1 - t);
            memcpy(held, a, sizeof held);
            memcpy(a, b, sizeof held);
            memcpy(b, held, sizeof held);
        }
    }
    check_pairs(&mesh);
    psplat_mesh_free(&mesh);
}

/* A wall that stands on the border of a sheet goes on in that side which faces as it does. */
static void test_end_of_sheet(void **state) {
    (void)state;
    static const uint32_t triangles[3][3] = {{0, 1, 2}, {1, 0, 2}, {1, 0, 3}};
    for (size_t first = 0; first < 3; ++first) {
        psplat_mesh mesh;
        uint32_t pairs[9];
        size_t borders;
        assert_int_equal(psplat_mesh_allocate(&mesh, 4, 3, 0, NULL), PSPLAT_OK);
        for (size_t t = 0; t < 3; ++t)
            memcpy(mesh.triangles + 3 * ((t + first) % 3), triangles[t], sizeof triangles[t]);
        assert_int_equal(psplat_edge_pairs(&mesh, pairs, &borders), PSPLAT_OK);
        uint32_t front = 3 * (uint32_t)first, back = 3 * (uint32_t)((first + 1) % 3);
        uint32_t wall = 3 * (uint32_t)((first + 2) % 3);
        assert_int_equal(pairs[wall], front);
        assert_int_equal(pairs[front], wall);
        assert_int_equal(pairs[back], PSPLAT_NONE);
        psplat_mesh_free(&mesh);
    }
}

/* Four triangles at an edge that are no sheet go on nowhere. */
static void test_four_walls(void **state) {
    (void)state;
    psplat_mesh mesh;
    uint32_t pairs[12];
    size_t borders;
    assert_int_equal(psplat_mesh_allocate(&mesh, 6, 4, 0, NULL), PSPLAT_OK);
    const uint32_t walls[12] = {0, 1, 2, 1, 0, 3, 0, 1, 4, 1, 0, 5};
    memcpy(mesh.triangles, walls, sizeof walls);
    assert_int_equal(psplat_edge_pairs(&mesh, pairs, &borders), PSPLAT_OK);
    for (size_t t = 0; t < 4; ++t) assert_int_equal(pairs[3 * t], PSPLAT_NONE);
    mesh.triangles[5] = 2; /* one pair of twins, and two walls */
    assert_int_equal(psplat_edge_pairs(&mesh, pairs, &borders), PSPLAT_OK);
    for (size_t t = 0; t < 4; ++t) assert_int_equal(pairs[3 * t], PSPLAT_NONE);
    psplat_mesh_free(&mesh);
}

/* Materials of a file that does not say are seen from both sides where a mesh is open, but not
 * where it has its other sides. */
static void test_usual_materials(void **state) {
    (void)state;
    for (uint32_t last_group = 0; last_group < 2; ++last_group) {
        psplat_mesh mesh = sheet(PSPLAT_MESH_GROUPS);
        psplat_error error;
        set_group(&mesh, SIDE, 2 * SIDE, last_group);
        --mesh.triangle_count; /* which opens it */
        assert_int_equal(psplat_mesh_clean(&mesh, "sheet", 0, &error), PSPLAT_OK);
        assert_int_equal(mesh.material.double_sided, !last_group);
        psplat_mesh_free(&mesh);
    }
}

/* A sheet of two colours becomes a splat on either side, each of which faces its own way and has
 * its own material. */
static void test_converted(void **state) {
    (void)state;
    psplat_source_material materials[2] = {{.material = {.base_color = {1, 0, 0, 1}}},
                                           {.material = {.base_color = {0, 0, 1, 1}}}};
    psplat_mesh mesh = sheet(PSPLAT_MESH_GROUPS);
    psplat_splats splats = {0};
    psplat_report report = {0};
    psplat_error error;
    set_group(&mesh, SIDE, 2 * SIDE, 1);
    mesh.source_materials = materials, mesh.source_material_count = 2;
    assert_int_equal(psplat_mesh_clean(&mesh, "sheet", 1, &error), PSPLAT_OK);
    assert_int_equal(mesh.triangle_count, 2 * SIDE);
    const psplat_convert_desc desc = {.tolerance_percent = 0.5};
    if (psplat_convert(&mesh, &desc, &splats, &report, &error)) fail_msg("%s", error.text);
    assert_int_equal(splats.count, 2);
    assert_int_equal(splats.run_count, 2);
    size_t at = 0;
    for (size_t r = 0; r < 2; at += splats.runs[r++].count) {
        uint32_t material = splats.runs[r].material;
        assert_true((double)splats.splats[at].normal[2] * (material ? -1 : 1) > 0.99);
        assert_false(splats.materials[material].double_sided);
    }
    assert_int_not_equal(splats.runs[0].material, splats.runs[1].material);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
}

int test_sheets_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_textures),     cmocka_unit_test(test_double_sided),
        cmocka_unit_test(test_end_of_sheet), cmocka_unit_test(test_usual_materials),
        cmocka_unit_test(test_same),         cmocka_unit_test(test_different),
        cmocka_unit_test(test_mixed_groups), cmocka_unit_test(test_pairs),
        cmocka_unit_test(test_four_walls),   cmocka_unit_test(test_converted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

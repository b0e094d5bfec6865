/* SPDX-License-Identifier: MIT
 *
 * test_shells.c - tests that closed shells which face inwards are turned, with their normals, and
 * that cavities and rooms stay. The shapes are cubes of known edge length, in OBJ; expected values
 * are their volumes.
 */
#include "mesh_fixture.h"

#include "scene/scene.h"
#include "import/read_scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { TEXT = 16384 };

/* A file under construction. */
typedef struct obj {
    char text[TEXT];
    int vertices;
} obj;

/* Appends a cube about a centre on the x axis, of which only the first faces are written. */
static void add_cube(obj *o, double x, double half, int inward, int faces) {
    static const int quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                    {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int v = 0; v < 8; ++v)
        sprintf(o->text + strlen(o->text), "v %g %g %g\n", x + (v & 1 ? half : -half),
                v & 2 ? half : -half, v & 4 ? half : -half);
    for (int f = 0; f < faces; ++f) {
        strcat(o->text, "f");
        for (int k = 0; k < 4; ++k)
            sprintf(o->text + strlen(o->text), " %d",
                    o->vertices + quads[f][inward ? 3 - k : k] + 1);
        strcat(o->text, "\n");
    }
    o->vertices += 8;
}

/* Asserts the volume of what is read, and how many shells were turned and kept. */
static void check_shells(const obj *o, double volume, size_t turned, size_t rooms) {
    psplat_mesh mesh = read_text("shells.obj", o->text);
    assert_near(signed_volume(&mesh) / 6, volume, 1e-12 * fabs(volume)); /* sums, relative */
    assert_int_equal(mesh.turned_shells, turned);
    assert_int_equal(mesh.turned_triangles, 12 * turned);
    assert_int_equal(mesh.kept_rooms, rooms);
    psplat_mesh_free(&mesh);
}

static void test_turned(void **state) {
    (void)state;
    obj outward = {{0}, 0}, inward = outward, both = outward;
    add_cube(&outward, 5, 1, 0, 6);
    check_shells(&outward, 8, 0, 0);
    add_cube(&inward, 5, 1, 1, 6);
    check_shells(&inward, 8, 1, 0);
    /* Each shell is judged by itself. */
    add_cube(&both, 0, 1, 1, 6);
    add_cube(&both, 5, 1, 0, 6);
    add_cube(&both, 10, 0.5, 1, 6);
    check_shells(&both, 17, 2, 0);
}

static void test_cavities_and_rooms(void **state) {
    (void)state;
    obj cavity = {{0}, 0}, room = cavity, furnished = cavity, inverted = cavity, beside = cavity,
        corner = cavity;
    /* A hollow cube: its inner wall faces the hollow. */
    add_cube(&cavity, 0, 0.5, 1, 6);
    add_cube(&cavity, 0, 1, 0, 6);
    check_shells(&cavity, 7, 0, 0);
    /* A room with a body in it, or with an open box. */
    add_cube(&room, 0, 1, 1, 6);
    add_cube(&room, 0, 0.5, 0, 6);
    check_shells(&room, -7, 0, 1);
    add_cube(&furnished, 0, 1, 1, 6);
    add_cube(&furnished, 0, 0.5, 0, 5);
    psplat_mesh mesh = read_text("room.obj", furnished.text);
    assert_int_equal(mesh.turned_shells, 0);
    assert_int_equal(mesh.kept_rooms, 1);
    psplat_mesh_free(&mesh);
    /* A file that is inverted as a whole, with one part inside another. */
    add_cube(&inverted, 0, 1, 1, 6);
    add_cube(&inverted, 0, 0.5, 1, 6);
    check_shells(&inverted, 9, 2, 0);
    /* A part that the box does not hold, though they overlap. */
    add_cube(&beside, 0, 1, 1, 6);
    add_cube(&beside, 1.4, 0.5, 0, 6);
    check_shells(&beside, 9, 1, 0);
    /* A cube in a corner of the box of a tetrahedron that does not hold it. */
    strcat(corner.text, "v -1 -1 -1\nv 3 -1 -1\nv -1 3 -1\nv -1 -1 3\n"
                        "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n");
    corner.vertices = 4;
    add_cube(&corner, 2.5, 0.25, 0, 6);
    mesh = read_text("corner.obj", corner.text);
    assert_near(signed_volume(&mesh) / 6, 64.0 / 6 + 0.125, 1e-12);
    assert_int_equal(mesh.turned_triangles, 4);
    assert_int_equal(mesh.kept_rooms, 0);
    psplat_mesh_free(&mesh);
}

static void test_open_stays(void **state) {
    (void)state;
    obj box = {{0}, 0};
    add_cube(&box, 0, 1, 1, 5);
    psplat_mesh mesh = read_text("box.obj", box.text);
    assert_int_equal(mesh.turned_shells, 0);
    psplat_mesh_free(&mesh);
}

/* The normals of the file point inwards as the winding does: both are turned. */
static void test_normals_turn_too(void **state) {
    (void)state;
    psplat_mesh mesh = read_text("t.obj", "v 1 0 0\nv 0 1 0\nv 0 0 1\nv -1 -1 -1\nvn -1 0 0\n"
                                          "vn 0 -1 0\nvn 0 0 -1\nvn 1 1 1\n"
                                          "f 1//1 3//3 2//2\nf 1//1 2//2 4//4\n"
                                          "f 2//2 3//3 4//4\nf 3//3 1//1 4//4\n");
    assert_int_equal(mesh.turned_shells, 1);
    assert_true(signed_volume(&mesh) > 0);
    for (size_t c = 0; c < 12; ++c) { /* a normal points as its vertex lies, seen from the origin */
        const double *p = mesh.positions + 3 * (size_t)mesh.triangles[c];
        double along = 0;
        for (size_t k = 0; k < 3; ++k)
            along += (double)mesh.corner_normals[3 * c + k] * (p[k] + mesh.origin[k]);
        assert_true(along > 0.9);
    }
    psplat_mesh_free(&mesh);
}

/* What was turned is said. */
static void test_warned(void **state) {
    (void)state;
    obj inward = {{0}, 0};
    psplat_scene scene;
    psplat_error error = {0};
    add_cube(&inward, 0, 1, 1, 6);
    write_bytes("inward.obj", inward.text, strlen(inward.text));
    if (psplat_scene_read(fixture_path, "inward", &scene, &error)) fail_msg("%s", error.text);
    unlink(fixture_path);
    assert_int_equal(scene.warning_count, 1);
    assert_string_equal(scene.warnings[0],
                        "1 closed shells faced inwards and are turned (12 triangles)");
    psplat_scene_free(&scene);
}

int test_shells_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_turned),           cmocka_unit_test(test_cavities_and_rooms),
        cmocka_unit_test(test_open_stays),       cmocka_unit_test(test_warned),
        cmocka_unit_test(test_normals_turn_too),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

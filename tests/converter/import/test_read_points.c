/* SPDX-License-Identifier: MIT
 *
 * test_read_points.c - tests of reading points without faces from XYZ in its dialects, PLY, OFF
 * and OBJ, and of refusing broken files. The points are mostly the corners of a unit square.
 */
#include "mesh_fixture.h"
#include "mesh/mesh.h"

#include <math.h>
#include <string.h>
#include <stdio.h>

/* Asserts that the mesh has the four corners of a unit square. */
static void check_square(const psplat_mesh *mesh) {
    assert_int_equal(mesh->point_count, 4);
    assert_int_equal(mesh->vertex_count, 4);
    assert_int_equal(mesh->triangle_count, 2);
    for (int k = 0; k < 2; ++k) assert_near(mesh->origin[k], 0.5, 1e-15);
    for (size_t i = 0; i < 12; ++i) assert_near(fabs(mesh->points[i]), i % 3 == 2 ? 0 : 0.5, 1e-15);
}

static void test_dialects(void **state) {
    (void)state;
    static const struct {
        const char *name, *text;
    } files[] = {
        {"plain.xyz", "0 0 0\n1 0 0\n0 1 0\n1 1 0\n"},
        {"content.dat", "0 0 0\n1 0 0\n0 1 0\n1 1 0"},
        {"comments.xyz", "# a scan\n// of a table\n\n 0 0 0 # here\n1\t0 0\r\n0 1 0\n1 1 0\n\n"},
        {"commas.csv", "0,0,0\n1,0,0\n0, 1, 0\n1;1;0;\n"},
        {"count.pts", "4\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"},
        {"intensity.pts", "4\n0 0 0 -17\n1 0 0 3\n0 1 0 0.5\n1 1 0 9\n"},
        {"mark.asc", "\xef\xbb\xbf"
                     "0 0 0\n1 0 0\n0 1 0\n1 1 0\n"},
        {"twice.xyz", "0 0 0\n1 0 0\n0 1 0\n1 1 0\n"},
        {"points.off", "OFF\n4 0 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"},
        {"plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n"},
        {"elements.obj", "o scan\nv 0 0 0 1\nv 1 0 0 1\np 1 -1\nv 0 1 0 1\nv 1 1 0 1\np 3 4\n"},
        {"few_normals.obj", "vn 0 0 -1\nv 0 0 0\nv 1 0 \\\n0\nv 0 1 0\nv 1 1 0"},
        {"points.ply",
         "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty float y\n"
         "property float z\nproperty float confidence\nend_header\n"
         "0 0 0 1\n1 0 0 1\n0 1 0 1\n1 1 0 1\n"},
        {"zero.ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                     "property float z\nelement face 0\nproperty list uchar int vertex_indices\n"
                     "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"},
        {"camera.ply",
         "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
         "property float z\nelement camera 1\nproperty float f\nend_header\n"
         "0 0 0\n1 0 0\n0 1 0\n1 1 0\n50\n"},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        psplat_mesh mesh = read_text(files[i].name, files[i].text);
        check_square(&mesh);
        assert_null(mesh.corner_colors);
        psplat_mesh_free(&mesh);
    }
}

static void check_normals(const psplat_mesh *mesh, float z) {
    assert_non_null(mesh->corner_normals);
    for (size_t i = 0; i < 9 * mesh->triangle_count; ++i)
        assert_true(mesh->corner_normals[i] == (i % 3 == 2 ? z : 0));
}

/* Asserts the colour orange: sRGB 188 is half of the light to 8 bits, ((188/255 + 0.055) /
 * 1.055)^2.4. */
static void check_orange(const psplat_mesh *mesh) {
    assert_null(mesh->corner_colors); /* a uniform colour is in the material */
    assert_near((double)mesh->material.base_color[0], 1, 0);
    assert_near((double)mesh->material.base_color[1], 0.50289, 1e-4);
    assert_near((double)mesh->material.base_color[2], 0, 0);
}

/* The values of six columns decide what they are; normals may have any length and face down. */
static void test_columns(void **state) {
    (void)state;
    psplat_mesh mesh =
        read_text("normals.xyz", "0 0 0 0 0 -2\n1 0 0 0 0 -2\n0 1 0 0 0 -2\n1 1 0 0 0 -2\n");
    check_square(&mesh);
    check_normals(&mesh, -1);
    assert_true(mesh.corner_colors == NULL);
    psplat_mesh_free(&mesh);
    mesh = read_text("bytes.xyz", "0 0 0 255 188 0\n1 0 0 255 188 0\n0 1 0 255 188 0\n"
                                  "1 1 0 255 188 0\n");
    check_square(&mesh);
    check_orange(&mesh);
    psplat_mesh_free(&mesh);
    mesh = read_text("all.xyz", "0 0 0 0 0 1 255 188 0\n1 0 0 0 0 1 255 188 0\n"
                                "0 1 0 0 0 1 255 188 0\n1 1 0 0 0 1 255 188 0\n");
    check_square(&mesh);
    check_normals(&mesh, 1);
    check_orange(&mesh);
    psplat_mesh_free(&mesh);
    mesh = read_text("leica.pts", "4\n0 0 0 -99 255 188 0\n1 0 0 -99 255 188 0\n"
                                  "0 1 0 -99 255 188 0\n1 1 0 -99 255 188 0\n");
    check_square(&mesh);
    check_orange(&mesh);
    psplat_mesh_free(&mesh);
    mesh = read_text("colored.off",
                     "CNOFF\n4 0 0\n0 0 0 0 0 1 255 188 0 255\n1 0 0 0 0 1 255 188 0 255\n"
                     "0 1 0 0 0 1 255 188 0 255\n1 1 0 0 0 1 255 188 0 255\n");
    check_square(&mesh);
    check_normals(&mesh, 1);
    check_orange(&mesh);
    psplat_mesh_free(&mesh);
}

/* Normals of an OBJ follow the order of its vertices; colours are of 0 to 1, or of bytes. */
static void test_obj(void **state) {
    (void)state;
    psplat_mesh mesh = read_text(
        "scan.obj", "vn 0 0 -2\nv 0 0 0 1 0.7372549 0\nvn 0 0 -2\nv 1 0 0 1 0.7372549 0\n"
                    "vn 0 0 -2\nv 0 1 0 1 0.7372549 0\nvn 0 0 -2\nv 1 1 0 1 0.7372549 0\n");
    check_square(&mesh);
    check_normals(&mesh, -1);
    check_orange(&mesh);
    psplat_mesh_free(&mesh);
    mesh = read_text("bytes.obj", "v 0 0 0 255 188 0\nv 1 0 0 255 188 0\nv 0 1 0 255 188 0\n"
                                  "v 1 1 0 255 188 0\n");
    check_square(&mesh);
    check_orange(&mesh);
    psplat_mesh_free(&mesh);
    /* The first normal belongs to the first vertex, wherever it stands. */
    mesh = read_text("order.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n"
                                  "vn -1 0 5\nvn 1 0 5\nvn -1 0 5\nvn 1 0 5\n");
    check_square(&mesh);
    for (size_t c = 0; c < 3 * mesh.triangle_count; ++c) {
        double x = mesh.positions[3 * (size_t)mesh.triangles[c]];
        assert_true((mesh.corner_normals[3 * c] > 0) == (x > 0));
    }
    psplat_mesh_free(&mesh);
}

/* The corners at each point have its colour. */
static void test_colors(void **state) {
    (void)state;
    psplat_mesh mesh = read_text("ramp.xyz", "0 0 0 0 0 0\n1 0 0 255 0 0\n0 1 0 0 255 0\n"
                                             "1 1 0 255 255 0\n");
    check_square(&mesh);
    assert_non_null(mesh.corner_colors);
    for (size_t c = 0; c < 6; ++c) {
        const double *p = mesh.positions + 3 * (size_t)mesh.triangles[c];
        for (size_t k = 0; k < 2; ++k)
            assert_near((double)mesh.corner_colors[4 * c + k], p[k] + 0.5, 1e-15);
    }
    psplat_mesh_free(&mesh);
}

/* Both byte orders are tested, with normals. */
static void test_binary(void **state) {
    (void)state;
    static const float rows[4][6] = {
        {0, 0, 0, 0, 0, 1}, {1, 0, 0, 0, 0, 1}, {0, 1, 0, 0, 0, 1}, {1, 1, 0, 0, 0, 1}};
    for (int big = 0; big < 2; ++big) {
        char file[512];
        int size =
            snprintf(file, sizeof file,
                     "ply\nformat binary_%s_endian 1.0\nelement vertex 4\nproperty float x\n"
                     "property float y\nproperty float z\nproperty float nx\nproperty float ny\n"
                     "property float nz\nend_header\n",
                     big ? "big" : "little");
        for (size_t i = 0; i < 24; ++i) {
            uint32_t bits;
            memcpy(&bits, &rows[i / 6][i % 6], sizeof bits);
            for (int k = 0; k < 4; ++k) file[size++] = (char)(bits >> (big ? 24 - 8 * k : 8 * k));
        }
        psplat_mesh mesh = read_bytes("points.ply", file, (size_t)size);
        check_square(&mesh);
        check_normals(&mesh, 1);
        psplat_mesh_free(&mesh);
    }
}

static void test_refused(void **state) {
    (void)state;
    static const struct {
        const char *name, *text;
        psplat_result code;
        const char *cause;
    } cases[] = {
        {"a.xyz", "hello\n", PSPLAT_ERROR_FORMAT,
         "line 1: the number of points is not a count: 'hello'"},
        {"a.xyz", "x y z\n0 0 0\n", PSPLAT_ERROR_FORMAT,
         "line 1: the x coordinate is not a number: 'x'"},
        {"a.xyz", "0 0 0\n1 0\n", PSPLAT_ERROR_FORMAT,
         "line 2: 2 columns; 3, 4, 6, 7 or 9 are read"},
        {"a.xyz", "0 0 0\n1 0 0 0\n", PSPLAT_ERROR_FORMAT, "line 2: 4 columns, but 3 in line 1"},
        {"a.xyz", "0 0 0\n\n# c\n1 oh 0\n", PSPLAT_ERROR_FORMAT, "line 4: the y coordinate"},
        {"a.xyz", "0 0 0\n1 nan 0\n", PSPLAT_ERROR_RANGE, "line 2: the y coordinate is not finite"},
        {"a.xyz", "0 0 0\n1 0 1e999\n", PSPLAT_ERROR_RANGE, "line 2: the z coordinate"},
        {"a.xyz", "3\n0 0 0\n1 0 0\n", PSPLAT_ERROR_FORMAT,
         "line 3: 3 points were promised, the file has 2"},
        {"a.xyz", "0 0 0\n7\n", PSPLAT_ERROR_FORMAT, "line 2: one number instead of a point"},
        {"a.xyz", "-3\n0 0 0\n", PSPLAT_ERROR_FORMAT, "line 1: the number of points"},
        {"a.xyz", "# nothing\n", PSPLAT_ERROR_NO_SPLATS, "no points"},
        {"a.xyz", "1 2 3\n", PSPLAT_ERROR_NO_SPLATS, "all points are at one place"},
        {"a.xyz", "1 2 3\n1 2 3\n1 2 3\n", PSPLAT_ERROR_NO_SPLATS, "all points are at one place"},
        {"a.xyz", "1 2 3\n2 2 3\n", PSPLAT_ERROR_NO_SPLATS, "2 different points without normals"},
        {"a.xyz", "0 0 0\n1 1 1\n2 2 2\n3 3 3\n", PSPLAT_ERROR_NO_SPLATS,
         "4 different points without normals span no surface"},
        {"a.obj", "v 1 2 3\n", PSPLAT_ERROR_NO_SPLATS, "all points are at one place"},
        {"a.obj", "v 0 0 0 1 1 1\nv 1 0 0 1 red 1\n", PSPLAT_ERROR_FORMAT,
         "line 2: a component of the colour is not a number: 'red'"},
        {"a.off", "OFF\n1 0 0\n1 2 3\n", PSPLAT_ERROR_NO_SPLATS, "all points are at one place"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        refuse_text(cases[i].name, cases[i].text, cases[i].code, cases[i].cause);
    refuse_bytes("zero.xyz", "0 0 0\n1 0 \0 0\n", 15, PSPLAT_ERROR_FORMAT, "byte 10: a zero byte");
}

int test_read_points_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_dialects), cmocka_unit_test(test_columns),
        cmocka_unit_test(test_colors),   cmocka_unit_test(test_binary),
        cmocka_unit_test(test_refused),  cmocka_unit_test(test_obj),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

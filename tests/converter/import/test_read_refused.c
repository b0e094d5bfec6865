/* SPDX-License-Identifier: MIT
 *
 * test_read_refused.c - tests that every class of defective OBJ, PLY, OFF and STL is refused with
 * its code and a text that names the file, the place and the cause.
 */
#include "mesh_fixture.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"

#include <stdlib.h>
#include <string.h>
#include <stdio.h>

static void test_files(void **state) {
    (void)state;
    psplat_mesh mesh;
    psplat_error error = {0};
    snprintf(fixture_path, sizeof fixture_path, "%s/missing.obj", fixture_directory);
    assert_int_equal(psplat_mesh_read(fixture_path, &mesh, &error), PSPLAT_ERROR_READ);
    assert_non_null(strstr(error.text, "missing.obj: No such file"));
    assert_int_equal(psplat_mesh_read(fixture_directory, &mesh, &error), PSPLAT_ERROR_READ);
    assert_non_null(strstr(error.text, "directory"));
    assert_int_equal(psplat_mesh_read(NULL, &mesh, NULL), PSPLAT_ERROR_ARGUMENT);
    refuse_text("empty.obj", "", PSPLAT_ERROR_FORMAT, "empty");
    refuse_text("note.txt", "Dear reader,\n", PSPLAT_ERROR_UNSUPPORTED, "not a mesh");
    refuse_text("picture.png", "\x89PNG\r\n\x1a\n", PSPLAT_ERROR_UNSUPPORTED, "not a mesh");
    refuse_text("t.ply", "plx\n", PSPLAT_ERROR_FORMAT, "byte 0: does not begin with 'ply'");
    refuse_text("t.glb", "gltf", PSPLAT_ERROR_FORMAT, "byte 0: does not begin with 'glTF'");
}

static void test_too_large(void **state) {
    (void)state;
    /* A sparse file of 5 GiB is refused for its length before it is read. */
    write_bytes("large.obj", "v", 1);
    psplat_mesh mesh;
    psplat_error error = {0};
    if (truncate(fixture_path, 5ll << 30) == 0) {
        assert_int_equal(psplat_mesh_read(fixture_path, &mesh, &error), PSPLAT_ERROR_RANGE);
        assert_non_null(strstr(error.text, "4 GiB"));
    }
    unlink(fixture_path);
}

static void test_obj(void **state) {
    (void)state;
    static const struct {
        const char *text;
        psplat_result code;
        const char *cause;
    } cases[] = {
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\n", PSPLAT_ERROR_NO_SPLATS, "no face"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2\n", PSPLAT_ERROR_NO_SPLATS, "no face"},
        {"# empty\nvt 0 0\n", PSPLAT_ERROR_NO_SPLATS, "no face"},
        {"v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", PSPLAT_ERROR_NO_SPLATS, "no triangle has an area"},
        {"v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n", PSPLAT_ERROR_NO_SPLATS, "no triangle has an area"},
        {"v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n", PSPLAT_ERROR_FORMAT,
         "line 2: the z coordinate is missing"},
        {"v 0 0 0\nv 1 zero 0\n", PSPLAT_ERROR_FORMAT,
         "line 2: the y coordinate is not a number: 'zero'"},
        {"v 0 0 0x10\n", PSPLAT_ERROR_FORMAT, "line 1: the z coordinate is not a number: '0x10'"},
        {"v 0 nan 0\n", PSPLAT_ERROR_RANGE, "line 1: the y coordinate is not finite: 'nan'"},
        {"#\n\nv -inf 0 0\n", PSPLAT_ERROR_RANGE, "line 3: the x coordinate is not finite"},
        {"v 0 0 1e39\n", PSPLAT_ERROR_RANGE, "line 1: the z coordinate is not finite"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", PSPLAT_ERROR_RANGE,
         "line 4: vertex 4 does not exist"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", PSPLAT_ERROR_RANGE,
         "line 4: vertex 0 does not exist"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", PSPLAT_ERROR_RANGE,
         "line 4: vertex -4 does not exist"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", PSPLAT_ERROR_RANGE,
         "line 4: vertex"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -99999999999999999999\n", PSPLAT_ERROR_RANGE,
         "line 4: vertex"}, /* strtoll's least number, whose negative does not exist */
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//1 2//1 3//1\n", PSPLAT_ERROR_RANGE, "line 4: normal 1"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 3/1\n", PSPLAT_ERROR_RANGE,
         "line 4: texture coordinate 1"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", PSPLAT_ERROR_FORMAT,
         "line 4: the face has 2 corners"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3x\n", PSPLAT_ERROR_FORMAT,
         "line 4: '3x' is not a corner"},
        {"v 0 0 0\nvn 0 1\nv 1 0 0\n", PSPLAT_ERROR_FORMAT,
         "line 2: a component of the normal is missing"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        refuse_text("bad.obj", cases[i].text, cases[i].code, cases[i].cause);
    refuse_bytes("zero.obj", "v 0 0 0\nv 1\0 0 0\n", 17, PSPLAT_ERROR_FORMAT, "byte 11");
}

static void test_off(void **state) {
    (void)state;
    static const struct {
        const char *text;
        psplat_result code;
        const char *cause;
    } cases[] = {
        {"OFF\n", PSPLAT_ERROR_FORMAT, "ends before its counts"},
        {"OFF\n3 x 0\n", PSPLAT_ERROR_FORMAT, "line 2: the number of faces is not a count: 'x'"},
        {"OFF\n0 0 0\n", PSPLAT_ERROR_NO_SPLATS, "no points"},
        {"OFF\n3 0 0\n0 0 0\n1 0 0\n", PSPLAT_ERROR_FORMAT, "line 4: the file ends before"},
        {"OFF\n4000000000 1 0\n0 0 0\n", PSPLAT_ERROR_RANGE, "line 2: 4000000000 vertices"},
        {"OFF\n99999999999 1 0\n0 0 0\n", PSPLAT_ERROR_RANGE,
         "line 2: the number of vertices is too large"},
        {"OFF\n3 1 0\n0 0 0\n1 0 0\n", PSPLAT_ERROR_FORMAT,
         "line 4: the file ends before the last vertex"},
        {"OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", PSPLAT_ERROR_FORMAT,
         "line 6: the file ends before the last face"},
        {"OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n3 0 1 2\n", PSPLAT_ERROR_RANGE,
         "line 7: vertex 3 does not exist"},
        {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n", PSPLAT_ERROR_FORMAT,
         "line 6: the file ends before the index of a corner"},
        {"OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", PSPLAT_ERROR_RANGE,
         "line 4: the z coordinate"},
        {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", PSPLAT_ERROR_RANGE,
         "line 6: vertex 3 does not exist"},
        {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", PSPLAT_ERROR_FORMAT,
         "line 6: the index of a corner"},
        {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", PSPLAT_ERROR_RANGE,
         "line 6: a face of 2 corners"},
        {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4000000000 0 1\n", PSPLAT_ERROR_RANGE,
         "line 6: a face of"},
        {"4OFF\n3 1 0\n0 0 0 1\n", PSPLAT_ERROR_UNSUPPORTED, "line 1: only vertices of three"},
        {"OFF BINARY\n", PSPLAT_ERROR_UNSUPPORTED, "line 1: binary OFF"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        refuse_text("bad.off", cases[i].text, cases[i].code, cases[i].cause);
}

#define PLY_TEXT "ply\nformat ascii 1.0\nelement vertex 3\n"
#define PLY_XYZ "property float x\nproperty float y\nproperty float z\n"
#define PLY_FACE "element face 1\nproperty list uchar int vertex_index\nend_header\n"
#define PLY_ROWS "0 0 0\n1 0 0\n0 1 0\n"

static void test_ply(void **state) {
    (void)state;
    static const struct {
        const char *text;
        psplat_result code;
        const char *cause;
    } cases[] = {
        {"ply\nformat ascii 1.0\nelement vertex 3\n", PSPLAT_ERROR_FORMAT,
         "line 3: the file ends before 'end_header'"},
        {"ply\nformat utf8 1.0\nend_header\n", PSPLAT_ERROR_FORMAT,
         "line 2: 'utf8' is not a PLY encoding"},
        {PLY_TEXT "property flaot x\nend_header\n", PSPLAT_ERROR_FORMAT,
         "line 4: 'flaot' is not a PLY type"},
        {PLY_TEXT "nonsense\n", PSPLAT_ERROR_FORMAT, "line 4: 'nonsense' does not belong here"},
        {PLY_TEXT PLY_XYZ "end_header\n0 0 0\n1 0 0\n", PSPLAT_ERROR_FORMAT,
         "the file ends before vertex 2"},
        {PLY_TEXT PLY_XYZ "element face 1\nproperty int a\nend_header\n" PLY_ROWS "0\n",
         PSPLAT_ERROR_NO_SPLATS, "faces without corners"},
        {PLY_TEXT PLY_XYZ "element edge 1\nproperty int a\n" PLY_FACE, PSPLAT_ERROR_UNSUPPORTED,
         "line 9: element 'face' here"},
        {PLY_TEXT "property float x\nproperty float y\n" PLY_FACE, PSPLAT_ERROR_FORMAT,
         "no x, y and z"},
        {PLY_TEXT "property int x\n" PLY_FACE, PSPLAT_ERROR_UNSUPPORTED, "vertex property 'x'"},
        {PLY_TEXT PLY_XYZ "property list uchar int n\n" PLY_FACE, PSPLAT_ERROR_UNSUPPORTED,
         "vertex property 'n'"},
        {"ply\nformat ascii 1.0\nelement face 1\n", PSPLAT_ERROR_UNSUPPORTED,
         "line 3: element 'face'"},
        {PLY_TEXT PLY_XYZ PLY_FACE "0 0 0\n1 0 0\n", PSPLAT_ERROR_FORMAT,
         "the file ends before vertex 2"},
        {PLY_TEXT PLY_XYZ PLY_FACE PLY_ROWS, PSPLAT_ERROR_FORMAT, "the file ends before face 0"},
        {PLY_TEXT PLY_XYZ PLY_FACE "0 0 0\n1 inf 0\n", PSPLAT_ERROR_RANGE, "line 11: "},
        {PLY_TEXT PLY_XYZ PLY_FACE PLY_ROWS "3 0 1 3\n", PSPLAT_ERROR_RANGE,
         "line 13: face 0: a corner is not the index"},
        {PLY_TEXT PLY_XYZ PLY_FACE PLY_ROWS "3 0 1 -1\n", PSPLAT_ERROR_RANGE, "line 13: face 0"},
        {PLY_TEXT PLY_XYZ PLY_FACE PLY_ROWS "3 0 1\n", PSPLAT_ERROR_FORMAT,
         "line 13: a value is missing"},
        {PLY_TEXT PLY_XYZ PLY_FACE PLY_ROWS "2 0 1\n", PSPLAT_ERROR_RANGE,
         "line 13: face 0: fewer than 3"},
        {PLY_TEXT PLY_XYZ PLY_FACE "0 0 0 9\n1 0 0\n0 1 0\n3 0 1 2\n", PSPLAT_ERROR_FORMAT,
         "line 10: vertex 0: more values than properties"},
        {PLY_TEXT PLY_XYZ PLY_FACE PLY_ROWS "3 0 1 2 0\n", PSPLAT_ERROR_FORMAT,
         "line 13: face 0: more values"},
        {PLY_TEXT PLY_XYZ PLY_FACE PLY_ROWS "3.5 0 1 2 0\n", PSPLAT_ERROR_RANGE, "line 13: face 0"},
        {PLY_TEXT PLY_XYZ "property uchar red\n" PLY_FACE "0 0 0 1.5\n", PSPLAT_ERROR_FORMAT,
         "line 11: vertex 0: an integer property has another value"},
        {"ply\nformat ascii 1.0\nelement vertex 4000000000\n" PLY_XYZ PLY_FACE, PSPLAT_ERROR_RANGE,
         "4000000000 vertices"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        refuse_text("bad.ply", cases[i].text, cases[i].code, cases[i].cause);
}

/* A binary file that is cut at any length is refused, and never read beyond its end. */
static void test_ply_truncated(void **state) {
    (void)state;
    static const char header[] =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\n" PLY_XYZ PLY_FACE;
    size_t begin = sizeof header - 1;
    unsigned char data[sizeof header + 36 + 13] = {0};
    memcpy(data, header, begin);
    data[begin + 12 + 3] = data[begin + 24 + 7] = 0x3f; /* two coordinates of 0.5 */
    data[begin + 36] = 3;
    data[begin + 41] = 1;
    data[begin + 45] = 2;
    psplat_mesh mesh = read_bytes("whole.ply", data, begin + 49);
    assert_int_equal(mesh.triangle_count, 1);
    psplat_mesh_free(&mesh);
    for (size_t size = 4; size < begin; ++size) {
        /* The error depends on the word that is cut. */
        write_bytes("cut.ply", data, size);
        assert_int_not_equal(psplat_mesh_read(fixture_path, &mesh, NULL), PSPLAT_OK);
        unlink(fixture_path);
    }
    for (size_t size = begin; size < begin + 49; ++size)
        refuse_bytes("cut.ply", data, size, PSPLAT_ERROR_FORMAT,
                     "the file ends before the last row");
    data[begin + 45] = 3;
    refuse_bytes("index.ply", data, begin + 49, PSPLAT_ERROR_RANGE,
                 "face 0: a corner is not the index");
    memset(data + begin, 0xff, 4);
    refuse_bytes("nan.ply", data, begin + 49, PSPLAT_ERROR_RANGE,
                 "vertex 0: a coordinate is not finite");
}

static void test_stl(void **state) {
    (void)state;
    unsigned char data[84 + 50] = "binary";
    data[80] = 1;
    data[84 + 12 + 15] = data[84 + 12 + 31] = 0x3f;
    psplat_mesh mesh = read_bytes("whole.stl", data, sizeof data);
    assert_int_equal(mesh.triangle_count, 1);
    psplat_mesh_free(&mesh);
    refuse_bytes("cut.stl", data, sizeof data - 1, PSPLAT_ERROR_FORMAT,
                 "byte 80: 1 triangles need 134 bytes");
    refuse_bytes("cut.stl", data, 50, PSPLAT_ERROR_FORMAT, "byte 50: the file ends before");
    memset(data + 84 + 12 + 4, 0xff, 4);
    refuse_bytes("nan.stl", data, sizeof data, PSPLAT_ERROR_RANGE,
                 "byte 100: a coordinate of triangle 0");
    memset(data, 0, sizeof data);
    refuse_bytes("none.stl", data, 84, PSPLAT_ERROR_NO_SPLATS, "no triangle");

    refuse_text("t.stl", "solid t\nendsolid t\n", PSPLAT_ERROR_NO_SPLATS, "no triangle");
    refuse_text("t.stl", "solid t\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\n",
                PSPLAT_ERROR_FORMAT, "line 4: the file ends inside a facet");
    refuse_text("t.stl", "solid t\nfacet normal 0 0 0\nouter loop\nvertex 0 0 nan\n",
                PSPLAT_ERROR_RANGE, "line 4: the z coordinate is not finite");
    refuse_text("t.stl", "solid t\nfacet normal 0 0 0\nouter loop\nvertices 0 0 0\n",
                PSPLAT_ERROR_FORMAT, "line 4: 'vertex' expected");
    refuse_text("t.stl", "solid t\nfaces\n", PSPLAT_ERROR_FORMAT, "line 2: 'facet' expected");
    refuse_text("t.stl",
                "solid t\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                "vertex 0 1 0\nendloop\nendfacet\n",
                PSPLAT_ERROR_FORMAT, "line 8: the file ends before 'endsolid'");
}

static void test_many_corners(void **state) {
    (void)state;
    size_t size = 32 + 5000 * 2;
    char *text = malloc(size);
    assert_non_null(text);
    strcpy(text, "v 0 0 0\nf");
    for (int i = 0; i < 5000; ++i) strcat(text, " 1");
    refuse_text("many.obj", text, PSPLAT_ERROR_RANGE,
                "line 2: the face has more than 4096 corners");
    free(text);
}

int test_read_refused_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_files), cmocka_unit_test(test_too_large),
        cmocka_unit_test(test_obj),   cmocka_unit_test(test_off),
        cmocka_unit_test(test_ply),   cmocka_unit_test(test_ply_truncated),
        cmocka_unit_test(test_stl),   cmocka_unit_test(test_many_corners),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

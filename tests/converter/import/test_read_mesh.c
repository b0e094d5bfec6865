/* SPDX-License-Identifier: MIT
 *
 * test_read_mesh.c - tests of reading OBJ, PLY, OFF and STL, and of cleaning the mesh afterwards:
 * welding, dropping of repeated and flat triangles, polygons, normals and colours. The files are
 * small texts with meshes of known volume.
 */
#include "mesh_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "mesh/mesh.h"

static const char tetrahedron_obj[] = "# four faces\nmtllib missing.mtl\no t\nv 0 0 0\nv 1 0 0\n"
                                      "v 0 1 0\nv 0 0 1\nusemtl none\ns off\n"
                                      "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

static void check_tetrahedron(psplat_mesh *mesh) {
    assert_int_equal(mesh->vertex_count, 4);
    assert_int_equal(mesh->triangle_count, 4);
    assert_int_equal(mesh->dropped, 0);
    for (int k = 0; k < 3; ++k) assert_true(mesh->origin[k] == 0.5);
    assert_true(signed_volume(mesh) == 1); /* exact for halves */
    assert_int_equal(mesh->material.double_sided, 0);
    psplat_mesh_free(mesh);
    assert_null(mesh->positions);
}

static void test_obj(void **state) {
    (void)state;
    psplat_mesh mesh = read_text("t.obj", tetrahedron_obj);
    assert_null(mesh.corner_normals);
    assert_null(mesh.corner_colors);
    for (int i = 0; i < 4; ++i) assert_int_equal(mesh.groups[i], 0);
    assert_non_null(strstr(mesh.materials->problem, "missing.mtl"));
    check_tetrahedron(&mesh);
}

static void test_obj_dialects(void **state) {
    (void)state;
    /* Negative indices, texture coordinates, a continued line, carriage returns, and no newline at
     * the end. */
    psplat_mesh mesh =
        read_text("t.obj", "v 0 0 0\r\nv 1 0 0\r\nv 0 1 \\\r\n 0\r\nv 0 0 1\r\nvt 0 0\r\n"
                           "f -4/1 -2/1 -3/1\r\nf 1/1 2/1 4/1\r\nf 2 3 4\r\n"
                           "f -2/-1 -4/-1 -1/-1");
    check_tetrahedron(&mesh);
}

static void test_off(void **state) {
    (void)state;
    psplat_mesh mesh = read_text("t.off", "OFF 4 4 6 # counts beside the word\n# comment\n\n0 0 0\n"
                                          "1 0 0\n0 1 0 # y\n0 0 1\n3 0 2 1 255 0 0\n3 0 1 3\n"
                                          "3 1 2 3 0.5 0.5 0.5\n3 2 0 3\n");
    check_tetrahedron(&mesh);
    /* Vertices and faces may go on in the next line, and end with what is left of their last. */
    mesh = read_text("l.off", "OFF\n4\n4 6\n0 0\n0\n1 0 0\n0\n\n1\n0\n0 0 1\n3 0 2 \n1 255 0 0\n"
                              "3 0 1\n3\n3 1 2 3 0.5 0.5 0.5\n3\n2 0\n3\n");
    check_tetrahedron(&mesh);
}

static void test_ply_text(void **state) {
    (void)state;
    psplat_mesh mesh = read_text(
        "t.ply", "ply\ncomment before the format\nformat ascii 1.0\nobj_info end_header\n"
                 "element vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
                 "property int quality\nelement face 4\nproperty list uchar float texcoord\n"
                 "property list uint uint vertex_index\nproperty uchar flags\n"
                 "element edge 0\nproperty int vertex1\ncomment last\nend_header\n"
                 "0 0 0 7\n1 0 0 7\n0 1 0 7\n0 0 1 7\n"
                 "2 .5 .5 3 0 2 1 9\n0 3 0 1 3 9\n0 3 1 2 3 9\n0 3 2 0 3 9\n");
    check_tetrahedron(&mesh);
}

/* Bytes of a small file, in either byte order. */
typedef struct writer {
    uint8_t data[2048];
    size_t size;
    int big;
} writer;

static void put(writer *w, const void *value, size_t size) {
    const uint8_t *bytes = value;
    for (size_t i = 0; i < size; ++i) w->data[w->size++] = bytes[w->big ? size - 1 - i : i];
}

static void put_text(writer *w, const char *text) {
    memcpy(w->data + w->size, text, strlen(text));
    w->size += strlen(text);
}

static void put_u8(writer *w, unsigned value) {
    w->data[w->size++] = (uint8_t)value;
}

static void put_float(writer *w, double value) {
    float single = (float)value;
    put(w, &single, sizeof single);
}

static void put_u32(writer *w, uint32_t value) {
    put(w, &value, sizeof value);
}

static const double corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const uint32_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

static void check_ply_binary(int big) {
    writer w = {.big = big};
    put_text(&w, big ? "ply\nformat binary_big_endian 1.0\n"
                     : "ply\nformat binary_little_endian 1.0\n");
    put_text(&w, "element vertex 4\nproperty float x\nproperty float y\nproperty double z\n"
                 "element face 4\nproperty list ushort uint vertex_indices\n"
                 "property list uchar float texcoord\ncomment last\nend_header\n");
    for (int i = 0; i < 4; ++i) {
        put_float(&w, corners[i][0]);
        put_float(&w, corners[i][1]);
        put(&w, &corners[i][2], 8);
    }
    for (int i = 0; i < 4; ++i) {
        uint16_t three = 3;
        put(&w, &three, sizeof three);
        for (int k = 0; k < 3; ++k) put_u32(&w, faces[i][k]);
        put_u8(&w, 1);
        put_float(&w, 0.25);
    }
    psplat_mesh mesh = read_bytes("t.ply", w.data, w.size);
    check_tetrahedron(&mesh);
}

static void test_ply_binary(void **state) {
    (void)state;
    check_ply_binary(0);
    check_ply_binary(1);
}

static size_t make_stl(writer *w) {
    w->size = 80;
    memcpy(w->data, "solid, says this binary file", 28);
    put_u32(w, 4);
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < 3; ++k) put_float(w, 0);
        for (int k = 0; k < 9; ++k) put_float(w, corners[faces[i][k / 3]][k % 3]);
        put_u8(w, 0);
        put_u8(w, 0);
    }
    return w->size;
}

static void test_stl(void **state) {
    (void)state;
    writer w = {0};
    make_stl(&w);
    psplat_mesh mesh = read_bytes("t.stl", w.data, w.size);
    check_tetrahedron(&mesh);
    /* The content decides the format, and not the name. */
    mesh = read_bytes("t.obj", w.data, w.size);
    check_tetrahedron(&mesh);

    char text[2048] = "SOLID t\n";
    for (int i = 0; i < 4; ++i) {
        size_t used = strlen(text);
        const double *a = corners[faces[i][0]], *b = corners[faces[i][1]],
                     *c = corners[faces[i][2]];
        snprintf(text + used, sizeof text - used,
                 "facet normal 0 0 0\nouter loop\n vertex %g %g %g\n vertex %g %g %g\n"
                 " VERTEX %g %g %E\nendloop\nendfacet\n\n",
                 a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]);
    }
    strcat(text, "endsolid t\n");
    mesh = read_text("t.stl", text);
    check_tetrahedron(&mesh);
}

static void test_welding(void **state) {
    (void)state;
    /* Three triangles share no vertices, and -0 equals 0; the fourth has two corners in one place.
     */
    psplat_mesh mesh =
        read_text("w.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv -0 0 -0\nv 1 0 0\nv 0 0 1\n"
                           "v 0 1 0\nv 1 1 0\nv 1 0 0\nv 9 9 9\nv 2 0 0\n"
                           "f 1 2 3\nf 4 6 5\nf 7 9 8\nf 1 4 8\nf 2 2 3\nf 1 2 11\n");
    /* without the unused 9 9 9 and the 2 0 0 of the flat triangle */
    assert_int_equal(mesh.vertex_count, 5);
    assert_int_equal(mesh.triangle_count, 3);
    assert_int_equal(mesh.dropped, 3);               /* equal positions, equal indices, collinear */
    assert_int_equal(mesh.material.double_sided, 1); /* it has borders */
    for (size_t i = 0; i < 9; ++i) assert_true(mesh.triangles[i] < 5);
    psplat_mesh_free(&mesh);
}

/* Vertices that only dropped triangles use are no part of the mesh, nor of the box by which it is
 * centred. */
static void test_left_over(void **state) {
    (void)state;
    psplat_mesh mesh = read_text("l.obj", "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 9 9 9\nv 9 9 9\n"
                                          "f 1 2 3\nf 4 5 1\n");
    assert_int_equal(mesh.vertex_count, 3);
    assert_true(mesh.origin[0] == 1 && mesh.origin[1] == 1 && mesh.origin[2] == 0);
    psplat_mesh_free(&mesh);
    /* These vertices differ until 0.5 is subtracted: the face that becomes flat is dropped, and the
     * rest is joined. */
    mesh = read_text("r.off", "OFF\n6 5 0\n0 0 0\n1 0 0\n1 0 1e-45\n0.5 1 0\n1 1 1\n0 0 1\n"
                              "3 0 1 3\n3 2 3 1\n3 2 4 3\n3 0 3 5\n3 4 5 3\n");
    assert_int_equal(mesh.vertex_count, 5);
    assert_int_equal(mesh.triangle_count, 4);
    psplat_mesh_free(&mesh);
}

static void test_seams(void **state) {
    (void)state;
    /* The last face uses copies of its corners that differ by rounding to float. */
    psplat_mesh mesh = read_text("s.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1e-9 0 0\n"
                                          "v 0 1.00000001 0\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 6 5 4\n");
    assert_int_equal(mesh.vertex_count, 4);
    assert_int_equal(mesh.material.double_sided, 0);
    psplat_mesh_free(&mesh);
    /* With 1e-5 instead of 1e-9 the gap is intended. */
    mesh = read_text("s.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1e-5 0 0\n"
                              "v 0 1.00001 0\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 6 5 4\n");
    assert_int_equal(mesh.vertex_count, 6);
    assert_int_equal(mesh.material.double_sided, 1);
    psplat_mesh_free(&mesh);
}

static void test_non_manifold(void **state) {
    (void)state;
    /* One edge has five faces, one of them repeated and one flipped; OpenMesh's halfedge structure
     * would keep two. */
    psplat_mesh mesh = read_text("n.off", "OFF\n6 5 0\n0 0 0\n0 0 1\n1 0 0\n0 1 0\n-1 0 0\n0 -1 0\n"
                                          "3 0 1 2\n3 0 1 3\n3 1 0 4\n3 0 1 5\n3 0 1 5\n");
    assert_int_equal(mesh.triangle_count, 4);
    assert_int_equal(mesh.dropped, 1);
    assert_int_equal(mesh.vertex_count, 6);
    assert_int_equal(mesh.material.double_sided, 1);
    psplat_mesh_free(&mesh);
}

/* One exporter repeats every face of a tetrahedron, and another one writes both windings to make it
 * visible from inside. */
static void test_repeated(void **state) {
    (void)state;
    for (int turned = 0; turned < 2; ++turned) {
        char text[256];
        snprintf(text, sizeof text,
                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n%s",
                 turned ? "f 1 2 3\nf 4 2 1\nf 3 2 4\nf 1 3 4\n"
                        : "f 3 2 1\nf 1 2 4\nf 4 2 3\nf 3 1 4\n");
        psplat_mesh mesh = read_text("r.obj", text);
        assert_int_equal(mesh.triangle_count, 4);
        assert_int_equal(mesh.dropped, 4);
        assert_int_equal(mesh.material.double_sided, turned);
        assert_near(signed_volume(&mesh), 1, 1e-12); /* rounding */
        psplat_mesh_free(&mesh);
    }
}

static double area(const psplat_mesh *mesh) {
    double sum = 0;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *v = mesh->triangles + t * 3;
        const double *a = mesh->positions + (size_t)v[0] * 3,
                     *b = mesh->positions + (size_t)v[1] * 3,
                     *c = mesh->positions + (size_t)v[2] * 3;
        double z = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        /* All triangles have the polygon's orientation, so that none lies outside its outline. */
        assert_true(z > 0);
        sum += z / 2;
    }
    return sum;
}

static void test_concave_polygons(void **state) {
    (void)state;
    /* A polygon in the shape of an L begins at each of its corners in turn; a fan from most of them
     * would be wrong. */
    static const int l[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    for (int first = 0; first < 6; ++first) {
        char text[256] = "OFF\n6 1 0\n";
        for (int i = 0; i < 6; ++i) {
            size_t used = strlen(text);
            snprintf(text + used, sizeof text - used, "%d %d 5\n", l[(first + i) % 6][0],
                     l[(first + i) % 6][1]);
        }
        strcat(text, "6 0 1 2 3 4 5\n");
        psplat_mesh mesh = read_text("l.off", text);
        assert_int_equal(mesh.triangle_count, 4);
        assert_true(fabs(area(&mesh) - 3) < 1e-12); /* halves, summed in double */
        psplat_mesh_free(&mesh);
    }
}

static void test_normals_per_corner(void **state) {
    (void)state;
    /* One vertex has another normal in each face; the second face has none, and the third a zero
     * normal. */
    psplat_mesh mesh = read_text("n.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\nv -1 0 0\n"
                                          "vn 0 0 2\nvn 0 3 4\nvn 0 0 0\nf 1//1 2//1 3//2\n"
                                          "f 1 4 2\nf 1//3 3//1 5//2\n");
    static const float expected[9][3] = {{0, 0, 1}, {0, 0, 1}, {0, 0.6f, 0.8f},
                                         {0, 0, 0}, {0, 0, 0}, {0, 0, 0},
                                         {0, 0, 0}, {0, 0, 1}, {0, 0.6f, 0.8f}};
    assert_non_null(mesh.corner_normals);
    for (size_t i = 0; i < 27; ++i)
        assert_near((double)mesh.corner_normals[i], (double)expected[i / 3][i % 3],
                    1e-6); /* rounding */
    psplat_mesh_free(&mesh);
}

/* Writes a vertex line with or without a colour. */
static void add_vertex(char *text, double x, double y, double z, int colored) {
    sprintf(text + strlen(text), "v %.9g %.9g %.9g%s\n", x, y, z, colored ? " 0.5 0.5 0.5" : "");
}

/* OpenMesh reads files whose vertices have colours, and the others have a reader of their own. Both
 * read the same polygons and normals, also where a face names a vertex twice. */
static void test_obj_readers_agree(void **state) {
    (void)state;
    static const char faces[] = "vn 0 0 2\nvn 0 3 4\nvn 1 2 2\nvn -1 0.25 1\n"
                                "f 1//1 2//2 3//3 4//4\nf 1//2 3//1 3//4 5//2\nf 5 4//3 1\n"
                                "f 2//1 6//4 7//2 8//3 3//1\nf 6//-1 6//-2 7//-3 2//-4\n"
                                "f 1//1 1//2 3//3\nf -1 -2//1 -3//2\n";
    psplat_mesh meshes[2];
    for (int colored = 0; colored < 2; ++colored) {
        char text[2048] = "";
        for (int i = 0; i < 8; ++i)
            add_vertex(text, 0.1 * i * i, i % 3 + 0.7, 1.0 / (i + 3), colored);
        strcat(text, faces);
        meshes[colored] = read_text("n.obj", text);
    }
    const psplat_mesh *a = &meshes[0], *b = &meshes[1];
    assert_int_equal(a->triangle_count, b->triangle_count);
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->dropped, b->dropped);
    size_t corners = 3 * a->triangle_count;
    assert_memory_equal(a->triangles, b->triangles, corners * sizeof *a->triangles);
    assert_memory_equal(a->positions, b->positions, 3 * a->vertex_count * sizeof *a->positions);
    assert_memory_equal(a->corner_normals, b->corner_normals, 3 * corners * sizeof(float));
    psplat_mesh_free(&meshes[0]);
    psplat_mesh_free(&meshes[1]);
}

static void test_colors(void **state) {
    (void)state;
    /* sRGB 188 is 0.5029 in linear light (IEC 61966-2-1); alpha stays linear. */
    psplat_mesh mesh = read_text("c.off", "COFF\n4 2 0\n0 0 0 255 0 188 128\n1 0 0 0 0 0 255\n"
                                          "0 1 0 0 255 0 255\n1 1 0 0 0 0 0\n3 0 1 2\n3 1 3 2\n");
    assert_non_null(mesh.corner_colors);
    static const float first[4] = {1, 0, 0.5029f, 0.50196f};
    for (int k = 0; k < 4; ++k) assert_near((double)mesh.corner_colors[k], (double)first[k], 1e-4);
    assert_near((double)mesh.corner_colors[9], 1, 0); /* green of the third corner */
    assert_near((double)mesh.material.base_color[0], 1, 0);
    psplat_mesh_free(&mesh);
    /* A uniform colour becomes the base colour. */
    mesh = read_text("c.ply",
                     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                     "property float z\nproperty uchar red\nproperty uchar green\n"
                     "property uchar blue\nelement face 1\n"
                     "property list uchar int vertex_index\nend_header\n"
                     "0 0 0 188 0 255\n1 0 0 188 0 255\n0 1 0 188 0 255\n3 0 1 2\n");
    assert_null(mesh.corner_colors);
    assert_near((double)mesh.material.base_color[0], 0.5029, 1e-4);
    assert_near((double)mesh.material.base_color[2], 1, 0);
    psplat_mesh_free(&mesh);
}

static void test_off_with_everything(void **state) {
    (void)state;
    psplat_mesh mesh =
        read_text("e.off", "STCNOFF\n3 1 0\n0 0 0 0 0 2 1.0 0.0 0.0 0 0\n"
                           "1 0 0 0 0 2 1.0 0.0 0.0 1 0\n0 1 0 3 0 4 0.0 1.0 0.0 0 1\n"
                           "3 0 1 2\n");
    assert_non_null(mesh.corner_normals);
    assert_near((double)mesh.corner_normals[6], 0.6, 1e-6);
    assert_non_null(mesh.corner_colors);
    assert_near((double)mesh.corner_colors[8], 0, 0);
    assert_near((double)mesh.corner_colors[9], 1, 0);
    psplat_mesh_free(&mesh);
}

static void test_far_from_the_origin(void **state) {
    (void)state;
    /* Text has enough digits for a model at ten million times its size from the origin, and the
     * mesh keeps them. */
    psplat_mesh mesh = read_text("f.obj", "v 10000000 0 0\nv 10000001.25 0 0\nv 10000000 0.125 0\n"
                                          "f 1 2 3\n");
    assert_true(mesh.origin[0] == 10000000.625);
    assert_true(mesh.positions[0] == -0.625 && mesh.positions[3] == 0.625);
    psplat_mesh_free(&mesh);
    /* Tiny triangles are not taken for flat ones. */
    mesh = read_text("f.obj", "v 0 0 0\nv 1e-30 0 0\nv 0 1e-30 0\nf 1 2 3\n");
    assert_int_equal(mesh.triangle_count, 1);
    psplat_mesh_free(&mesh);
    /* A triangle a million million times as long as wide is not taken for flat either. */
    mesh = read_text("f.obj", "v 0 0 0\nv 1 0 0\nv 0.5 1e-12 0\nf 1 2 3\n");
    assert_int_equal(mesh.triangle_count, 1);
    psplat_mesh_free(&mesh);
}

int test_read_mesh_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_obj),
        cmocka_unit_test(test_obj_dialects),
        cmocka_unit_test(test_off),
        cmocka_unit_test(test_ply_text),
        cmocka_unit_test(test_ply_binary),
        cmocka_unit_test(test_stl),
        cmocka_unit_test(test_welding),
        cmocka_unit_test(test_left_over),
        cmocka_unit_test(test_seams),
        cmocka_unit_test(test_non_manifold),
        cmocka_unit_test(test_repeated),
        cmocka_unit_test(test_concave_polygons),
        cmocka_unit_test(test_normals_per_corner),
        cmocka_unit_test(test_obj_readers_agree),
        cmocka_unit_test(test_colors),
        cmocka_unit_test(test_off_with_everything),
        cmocka_unit_test(test_far_from_the_origin),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

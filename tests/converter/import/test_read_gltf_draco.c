/* SPDX-License-Identifier: MIT
 *
 * test_read_gltf_draco.c - tests of reading glTF with KHR_draco_mesh_compression: both methods,
 * with attributes of all kinds, beside what is not compressed, and everything that may be wrong.
 * The meshes are those of draco_encoder.h; most are the tetrahedron, whose volume is known.
 */
#include "gltf_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "import/draco_encoder.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"

#define DRACO "KHR_draco_mesh_compression"
#define REQUIRED "\"extensionsUsed\":[\"" DRACO "\"],\"extensionsRequired\":[\"" DRACO "\"],"
#define USED "\"extensionsUsed\":[\"" DRACO "\"],"
#define OF_VIEW(view, ids)                                                                         \
    "\"extensions\":{\"" DRACO "\":{\"bufferView\":" view ",\"attributes\":{" ids "}}}"

static const draco_attribute positions = {DRACO_POSITION, 3, 0, 0, points};
static const draco_mesh tetrahedron_mesh = {.triangles = faces,
                                            .triangle_count = 4,
                                            .vertex_count = 4,
                                            .attributes = &positions,
                                            .attribute_count = 1};

/* Adds bytes in a buffer view. */
static void add_bytes(gltf *g, const unsigned char *bytes, size_t size) {
    assert_true(g->size + size + 3 < sizeof g->buffer);
    append(g->views, sizeof g->views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}",
           *g->views ? "," : "", g->size, size);
    memcpy(g->buffer + g->size, bytes, size);
    g->size += (size + 3) / 4 * 4;
}

static void add_draco(gltf *g, const draco_mesh *mesh) {
    unsigned char bytes[1024];
    size_t size = draco_encode(mesh, bytes, sizeof bytes);
    assert_true(size > 0);
    add_bytes(g, bytes, size);
}

/* Adds an accessor without a buffer view. */
static void add_accessor(gltf *g, int component, const char *type, size_t count, const char *more) {
    append(g->accessors, sizeof g->accessors,
           "%s{\"componentType\":%d,\"type\":\"%s\",\"count\":%zu%s}", g->count++ ? "," : "",
           component, type, count, more);
}

/* Returns a file of the mesh, with positions alone. */
static const char *file_of(gltf *g, const draco_mesh *mesh) {
    *g = (gltf){0};
    add_draco(g, mesh);
    add_accessor(g, FLOAT, "VEC3", 4, "");
    add_accessor(g, USHORT, "SCALAR", 12, "");
    return finish(g, REQUIRED NODE "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
                                   "\"indices\":1," OF_VIEW("0", "\"POSITION\":0") "}]}]");
}

static void check_volume(const char *text, size_t triangles, double six_volumes, double tolerance) {
    psplat_mesh mesh = read_text("t.gltf", text);
    assert_int_equal(mesh.triangle_count, triangles);
    assert_int_equal(mesh.dropped, 0);
    assert_near(signed_volume(&mesh), six_volumes, tolerance);
    psplat_mesh_free(&mesh);
}

static void test_methods(void **state) {
    (void)state;
    gltf g;
    for (int edgebreaker = 0; edgebreaker < 2; ++edgebreaker)
        for (int metadata = 0; metadata < 2; ++metadata)
            for (int bits = 0; bits < 20; bits += 10) {
                draco_mesh mesh = tetrahedron_mesh;
                mesh.is_edgebreaker = edgebreaker;
                mesh.has_metadata = metadata;
                mesh.position_bits = bits;
                /* The corners are on the grid of 2^10 - 1 steps, but for rounding to floats. */
                check_volume(file_of(&g, &mesh), 4, 1, bits ? 1e-6 : 0);
            }
}

/* ---- attributes ------------------------------------------------------------------------------ */

static const float normals[4][3] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
static const unsigned char colors[4][4] = {
    {255, 0, 51, 255}, {0, 255, 102, 255}, {51, 0, 255, 255}, {204, 153, 0, 255}};
static const float uvs[4][2] = {{0, 0.25f}, {0.5f, 1}, {2, -3}, {0.125f, 0.75f}};

/* Returns which of the points the corner of a mesh is at. */
static size_t point_of(const psplat_mesh *mesh, size_t corner) {
    const double *p = mesh->positions + 3 * (size_t)mesh->triangles[corner];
    for (size_t i = 0; i < 4; ++i) {
        double away = 0;
        for (int k = 0; k < 3; ++k) away += fabs(p[k] + mesh->origin[k] - (double)points[i][k]);
        if (away < 1e-6) return i;
    }
    fail_msg("a corner is at none of the points");
    return 0;
}

static void check_attributes(const psplat_mesh *mesh) {
    assert_int_equal(mesh->triangle_count, 4);
    assert_non_null(mesh->corner_normals);
    assert_non_null(mesh->corner_colors);
    assert_non_null(mesh->corner_uvs[0]);
    for (size_t corner = 0; corner < 12; ++corner) {
        size_t i = point_of(mesh, corner);
        for (size_t k = 0; k < 3; ++k) {
            assert_near((double)mesh->corner_normals[3 * corner + k], (double)normals[i][k], 0);
            assert_near((double)mesh->corner_colors[4 * corner + k], (double)colors[i][k] / 255,
                        1e-6);
        }
        for (size_t k = 0; k < 2; ++k)
            assert_near((double)mesh->corner_uvs[0][2 * corner + k], (double)uvs[i][k], 0);
    }
}

#define ALL                                                                                        \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":2,\"COLOR_0\":3,"     \
    "\"TEXCOORD_0\":4},\"indices\":1,"

static void test_attributes(void **state) {
    (void)state;
    const draco_attribute all[] = {{DRACO_TEXCOORD, 2, 0, 0, uvs},
                                   {DRACO_COLOR, 4, 1, 1, colors},
                                   positions,
                                   {DRACO_NORMAL, 3, 0, 0, normals}};
    for (int edgebreaker = 0; edgebreaker < 2; ++edgebreaker) {
        draco_mesh from = tetrahedron_mesh;
        from.attributes = all, from.attribute_count = 4, from.is_edgebreaker = edgebreaker;
        gltf g = {0};
        add_draco(&g, &from);
        /* The counts are wrong, as those from before compression may be. */
        add_accessor(&g, FLOAT, "VEC3", 5, "");
        add_accessor(&g, UBYTE, "SCALAR", 3, "");
        add_accessor(&g, FLOAT, "VEC3", 7, "");
        add_accessor(&g, UBYTE, "VEC4", 9, ",\"normalized\":true");
        add_accessor(&g, FLOAT, "VEC2", 1, "");
        psplat_mesh mesh = read_text(
            "a.gltf",
            finish(&g, REQUIRED NODE ALL OF_VIEW("0", "\"TEXCOORD_0\":0,\"COLOR_0\":1,"
                                                      "\"POSITION\":2,\"NORMAL\":3") "}]}]"));
        check_attributes(&mesh);
        psplat_mesh_free(&mesh);
    }
}

/* Attributes that are not compressed stay where they are. Their order is that of the vertices. */
static void test_attributes_beside(void **state) {
    (void)state;
    const draco_attribute some[] = {positions, {DRACO_NORMAL, 3, 0, 0, normals}};
    draco_mesh from = tetrahedron_mesh;
    from.attributes = some, from.attribute_count = 2;
    gltf g = {0};
    add(&g, colors, sizeof colors, UBYTE, "VEC4", 4, ",\"normalized\":true");
    add(&g, uvs, sizeof uvs, FLOAT, "VEC2", 4, "");
    add_accessor(&g, FLOAT, "VEC3", 4, "");
    add_accessor(&g, USHORT, "SCALAR", 12, "");
    add_draco(&g, &from);
    psplat_mesh mesh = read_text(
        "b.gltf",
        finish(&g, REQUIRED NODE
               "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":2,\"NORMAL\":2,"
               "\"COLOR_0\":0,\"TEXCOORD_0\":1},\"indices\":3," OF_VIEW(
                   "2", "\"POSITION\":0,\"NORMAL\":1") "}]}]"));
    check_attributes(&mesh);
    psplat_mesh_free(&mesh);
}

/* ---- primitives ------------------------------------------------------------------------------ */

/* Primitives may share what is compressed, and may say that they are strips. */
static void test_shared(void **state) {
    (void)state;
    gltf g = {0};
    add_draco(&g, &tetrahedron_mesh);
    add_accessor(&g, FLOAT, "VEC3", 4, "");
    add_accessor(&g, USHORT, "SCALAR", 12, "");
    check_volume(
        finish(
            &g, REQUIRED SCENE
            "\"nodes\":[{\"children\":[1,2]},{\"mesh\":0},{\"mesh\":1,\"translation\":[5,0,0]}],"
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1," OF_VIEW(
                "0",
                "\"POSITION\":0") "}]},"
                                  "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,"
                                  "\"mode\":5," OF_VIEW("0", "\"POSITION\":0") "}]}]"),
        8, 2, 1e-12);
}

/* What is there without compression, too, is taken from there, unless the file requires the
 * extension. */
static void test_not_required(void **state) {
    (void)state;
    static const float larger[4][3] = {{0, 0, 0}, {3, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const char primitive[] =
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1," OF_VIEW(
            "2", "\"POSITION\":0") "}]}]";
    char rest[1024];
    for (int required = 0; required < 2; ++required) {
        gltf g = {0};
        add(&g, larger, sizeof larger, FLOAT, "VEC3", 4, "");
        add(&g, faces, sizeof faces, UBYTE, "SCALAR", 12, "");
        add_draco(&g, &tetrahedron_mesh);
        snprintf(rest, sizeof rest, "%s%s", required ? REQUIRED NODE : USED NODE, primitive);
        check_volume(finish(&g, rest), 4, required ? 1 : 3, 0);
    }
    gltf g = {0}; /* positions without bytes, and nothing that is required */
    add_draco(&g, &tetrahedron_mesh);
    add_accessor(&g, FLOAT, "VEC3", 4, "");
    add_accessor(&g, USHORT, "SCALAR", 12, "");
    check_volume(finish(&g, NODE "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
                                 "\"indices\":1," OF_VIEW("0", "\"POSITION\":0") "}]}]"),
                 4, 1, 0);
    g = (gltf){0}; /* indices alone without bytes */
    add(&g, larger, sizeof larger, FLOAT, "VEC3", 4, "");
    add_draco(&g, &tetrahedron_mesh);
    add_accessor(&g, USHORT, "SCALAR", 12, "");
    check_volume(finish(&g, NODE "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
                                 "\"indices\":1," OF_VIEW("1", "\"POSITION\":0") "}]}]"),
                 4, 1, 0);
}

/* ---- faults ---------------------------------------------------------------------------------- */

static void refuse_view(const unsigned char *bytes, size_t size, psplat_result code,
                        const char *message) {
    gltf g = {0};
    add_bytes(&g, bytes, size);
    add_accessor(&g, FLOAT, "VEC3", 4, "");
    add_accessor(&g, USHORT, "SCALAR", 12, "");
    refuse_text("f.gltf",
                finish(&g, REQUIRED NODE
                       "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
                       "\"indices\":1," OF_VIEW("0", "\"POSITION\":0") "}]}]"),
                code, message);
}

static void test_bad_bytes(void **state) {
    (void)state;
    for (int edgebreaker = 0; edgebreaker < 2; ++edgebreaker) {
        unsigned char bytes[1024], bad[1024];
        draco_mesh mesh = tetrahedron_mesh;
        mesh.is_edgebreaker = edgebreaker;
        size_t size = draco_encode(&mesh, bytes, sizeof bytes), counts = 11 + (size_t)edgebreaker;
        refuse_view(bytes, 4, PSPLAT_ERROR_FORMAT,
                    "bufferView 0: its bytes are not those of Draco");
        refuse_view(bytes, 10, PSPLAT_ERROR_FORMAT,
                    "bufferView 0: its compressed bytes end too early");
        for (size_t cut = 14; cut + 1 < size; cut += 7)
            refuse_view(bytes, cut, PSPLAT_ERROR_FORMAT,
                        "bufferView 0: its compressed bytes are damaged");
        memcpy(bad, bytes, size);
        bad[5] = 3;
        refuse_view(bad, size, PSPLAT_ERROR_UNSUPPORTED, "bufferView 0: Draco's version 3.2; 2.2");
        /* Counts that would take all memory: five bytes of seven bits each. */
        memcpy(bad, bytes, counts);
        memset(bad + counts, 0xff, 4);
        bad[counts + 4] = 0x0f;
        memcpy(bad + counts + 5, bytes + counts + 1, size - counts - 1);
        refuse_view(bad, size + 4, PSPLAT_ERROR_RANGE,
                    "bufferView 0: 4294967295 triangles or vertices cannot be in");
    }
    unsigned char bytes[1024];
    draco_mesh cloud = tetrahedron_mesh;
    cloud.is_cloud = 1;
    refuse_view(bytes, draco_encode(&cloud, bytes, sizeof bytes), PSPLAT_ERROR_FORMAT,
                "bufferView 0: Draco has no mesh there");
}

/* Refuses the tetrahedron with another extension's object, or another accessor. */
static void refuse_object(const char *accessor, const char *object, psplat_result code,
                          const char *message) {
    char rest[2048];
    gltf g = {0};
    add_draco(&g, &tetrahedron_mesh);
    append(g.accessors, sizeof g.accessors, "%s", accessor);
    g.count = 1;
    snprintf(rest, sizeof rest,
             REQUIRED NODE "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
                           "\"extensions\":{\"" DRACO "\":%s}}]}]",
             object);
    refuse_text("o.gltf", finish(&g, rest), code, message);
}

static void test_bad_objects(void **state) {
    (void)state;
    static const char good[] = "{\"componentType\":5126,\"type\":\"VEC3\",\"count\":4}";
    static const char of_view[] = "{\"bufferView\":0,\"attributes\":{\"POSITION\":0}}";
    refuse_object(good, "{\"bufferView\":0}", PSPLAT_ERROR_FORMAT,
                  "meshes[0].primitives[0]: its compression has no attributes");
    refuse_object(good, "{\"attributes\":{\"POSITION\":0}}", PSPLAT_ERROR_FORMAT,
                  "compressed bufferView is not an index");
    refuse_object(good, "{\"bufferView\":0.5,\"attributes\":{\"POSITION\":0}}", PSPLAT_ERROR_FORMAT,
                  "compressed bufferView is not an index");
    refuse_object(good, "{\"bufferView\":0,\"attributes\":{\"POSITION\":-1}}", PSPLAT_ERROR_FORMAT,
                  "compressed POSITION is not an index");
    refuse_object(good, "{\"bufferView\":1,\"attributes\":{\"POSITION\":0}}", PSPLAT_ERROR_RANGE,
                  "bufferView 1 does not exist");
    refuse_object(good, "{\"bufferView\":0,\"attributes\":{\"POSITION\":5}}", PSPLAT_ERROR_FORMAT,
                  "bufferView 0: compressed attribute 5 is not there, or not as its accessor says");
    refuse_object("{\"componentType\":5126,\"type\":\"VEC4\",\"count\":4}", of_view,
                  PSPLAT_ERROR_FORMAT, "compressed attribute 0 is not there, or not");
    refuse_object("{\"componentType\":5130,\"type\":\"VEC3\",\"count\":4}", of_view,
                  PSPLAT_ERROR_FORMAT, "values of compressed attribute 0 do not fit the type");
}

/* Two views of the same bytes decode them twice: a small file could do so a thousand times. */
static void test_bytes_used_twice(void **state) {
    (void)state;
    gltf g = {0};
    add_draco(&g, &tetrahedron_mesh);
    char view[sizeof g.views];
    snprintf(view, sizeof view, "%s", g.views);
    append(g.views, sizeof g.views, ",%s", view);
    add_accessor(&g, FLOAT, "VEC3", 4, "");
    refuse_text("w.gltf",
                finish(&g, REQUIRED NODE
                       "\"meshes\":[{\"primitives\":["
                       "{\"attributes\":{\"POSITION\":0}," OF_VIEW(
                           "0", "\"POSITION\":0") "},"
                                                  "{\"attributes\":{\"POSITION\":0}," OF_VIEW(
                                                      "1", "\"POSITION\":0") "}]}]"),
                PSPLAT_ERROR_RANGE, "bufferView 1: its compressed bytes are not its own");
}

/* Damaged bytes are refused, or give another mesh. */
static void test_damaged(void **state) {
    (void)state;
    for (int edgebreaker = 0; edgebreaker < 2; ++edgebreaker) {
        draco_mesh from = tetrahedron_mesh;
        from.is_edgebreaker = edgebreaker;
        gltf whole;
        size_t refused = 0;
        file_of(&whole, &from);
        for (size_t i = 0; i < whole.size; ++i)
            for (int bit = 0; bit < 8; bit += 3) {
                psplat_mesh mesh;
                gltf g = whole;
                g.buffer[i] ^= (unsigned char)(1 << bit);
                const char *text =
                    finish(&g, REQUIRED NODE
                           "\"meshes\":[{\"primitives\":[{\"attributes\":{"
                           "\"POSITION\":0},\"indices\":1," OF_VIEW("0", "\"POSITION\":0") "}]}]");
                write_bytes("d.gltf", text, strlen(text));
                refused += psplat_mesh_read(fixture_path, &mesh, NULL) != PSPLAT_OK;
                unlink(fixture_path);
                psplat_mesh_free(&mesh);
            }
        assert_true(refused > 0);
    }
}

int test_read_gltf_draco_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_methods),           cmocka_unit_test(test_attributes),
        cmocka_unit_test(test_attributes_beside), cmocka_unit_test(test_shared),
        cmocka_unit_test(test_not_required),      cmocka_unit_test(test_bad_bytes),
        cmocka_unit_test(test_bad_objects),       cmocka_unit_test(test_bytes_used_twice),
        cmocka_unit_test(test_damaged),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

/* SPDX-License-Identifier: MIT
 *
 * test_read_gltf_packed.c - tests of reading compact glTF: sparse accessors, KHR_mesh_quantization,
 * and EXT_meshopt_compression in all modes and with all filters. Each file is the same tetrahedron,
 * whose volume is known.
 */
#include "gltf_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <meshoptimizer.h>
#include "import/read_mesh.h"
#include "mesh/mesh.h"

#define PLAIN "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]"

static void check_volume(const char *text, double six_volumes, double tolerance) {
    psplat_mesh mesh = read_text("t.gltf", text);
    assert_int_equal(mesh.triangle_count, 4);
    assert_near(signed_volume(&mesh), six_volumes, tolerance);
    psplat_mesh_free(&mesh);
}

/* ---- sparse ---------------------------------------------------------------------------------- */

/* Returns a file whose accessor 0 has sparse positions: the base is in view 0 or absent, and the
 * indices and values are in views 1 and 2. */
static const char *sparse(gltf *g, int has_base, const char *count, const void *indices,
                          size_t index_count, int type, const float values[][3]) {
    size_t size = type == UBYTE ? 1 : type == USHORT ? 2 : 4;
    *g = (gltf){0};
    add(g, points, sizeof points, FLOAT, "VEC3", 4, "");
    add(g, indices, size * index_count, type, "SCALAR", index_count, "");
    add(g, values, 12 * index_count, FLOAT, "VEC3", index_count, "");
    g->accessors[0] = 0;
    append(g->accessors, sizeof g->accessors,
           "{%s\"componentType\":5126,\"type\":\"VEC3\",\"count\":%s,\"sparse\":{\"count\":%zu,"
           "\"indices\":{\"bufferView\":1,\"componentType\":%d},\"values\":{\"bufferView\":2}}}",
           has_base ? "\"bufferView\":0," : "", count, index_count, type);
    g->count = 3;
    append(g->views, sizeof g->views, ",{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":12}",
           g->size);
    append(g->accessors, sizeof g->accessors,
           ",{\"bufferView\":3,\"componentType\":5121,\"type\":\"SCALAR\",\"count\":12}");
    memcpy(g->buffer + g->size, faces, sizeof faces);
    g->size += sizeof faces;
    return finish(g, NODE PLAIN);
}

static void test_sparse(void **state) {
    (void)state;
    static const unsigned char one[1] = {1};
    static const uint16_t two[2] = {1, 3};
    static const uint32_t three[3] = {1, 2, 3};
    static const float wide[2][3] = {{3, 0, 0}, {0, 0, 5}};
    gltf g;
    check_volume(sparse(&g, 1, "4", one, 1, UBYTE, wide), 3, 1e-12);
    check_volume(sparse(&g, 1, "4", two, 2, USHORT, wide), 15, 1e-12);
    /* all others are zeros */
    check_volume(sparse(&g, 0, "4", three, 3, UINT, points + 1), 1, 1e-12);
    static const unsigned char beyond[1] = {4};
    refuse_text("t.gltf", sparse(&g, 1, "4", beyond, 1, UBYTE, wide), PSPLAT_ERROR_RANGE,
                "accessor 0: sparse element 4 does not exist");
    refuse_text("t.gltf", sparse(&g, 1, "4", three, 1, FLOAT, wide), PSPLAT_ERROR_FORMAT,
                "accessor 0: its sparse elements make no sense");
    /* No memory is requested for zeros that the file does not contain. */
    refuse_text("t.gltf", sparse(&g, 0, "4000000000", three, 3, UINT, points + 1),
                PSPLAT_ERROR_RANGE, "accessor 0: 4000000000 elements without a bufferView");
}

/* ---- integers -------------------------------------------------------------------------------- */

static void test_quantised(void **state) {
    (void)state;
    static const uint16_t steps[4][4] = {{7, 7, 7}, {1007, 7, 7}, {7, 1007, 7}, {7, 7, 1007}};
    static const int8_t parts[4][4] = {{0, 0, 0}, {127, 0, 0}, {0, 127, 0}, {0, 0, -127}};
    static const int8_t normals[4][4] = {{127, 0, 0}, {127, 0, 0}, {-127, 0, 0}, {0, 0, 127}};
    const char *required = "\"extensionsUsed\":[\"KHR_mesh_quantization\"],"
                           "\"extensionsRequired\":[\"KHR_mesh_quantization\"],";
    char rest[1024];
    /* Integers are steps of a node's scale. */
    gltf g = {0};
    add(&g, steps, sizeof steps, USHORT, "VEC3", 4, "");
    strcpy(strrchr(g.views, '}'), ",\"byteStride\":8}");
    add(&g, faces, sizeof faces, UBYTE, "SCALAR", 12, "");
    snprintf(rest, sizeof rest,
             "%s" SCENE "\"nodes\":[{\"mesh\":0,\"scale\":[0.001,0.001,0.001]}]," PLAIN, required);
    check_volume(finish(&g, rest), 1, 1e-12);
    /* Normalised shorts: the greatest value is 1, and a value below -1 becomes -1. */
    static const int16_t shorts[4][4] = {{0, 0, 0}, {32767, 0, 0}, {0, -32767, 0}, {0, 0, -32768}};
    g = (gltf){0};
    add(&g, shorts, sizeof shorts, SHORT, "VEC3", 4, ",\"normalized\":true");
    strcpy(strrchr(g.views, '}'), ",\"byteStride\":8}");
    add(&g, faces, sizeof faces, UBYTE, "SCALAR", 12, "");
    snprintf(rest, sizeof rest, "%s" SCENE "\"nodes\":[{\"mesh\":0}]," PLAIN, required);
    check_volume(finish(&g, rest), 1, 1e-12);
    /* Normalised integers are mirrored by their own values; normals are bytes. */
    g = (gltf){0};
    add(&g, parts, sizeof parts, BYTE, "VEC3", 4, ",\"normalized\":true");
    strcpy(strrchr(g.views, '}'), ",\"byteStride\":4}");
    add(&g, faces, sizeof faces, UBYTE, "SCALAR", 12, "");
    add(&g, normals, sizeof normals, BYTE, "VEC3", 4, ",\"normalized\":true");
    strcpy(strrchr(g.views, '}'), ",\"byteStride\":4}");
    snprintf(rest, sizeof rest,
             "%s" NODE "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
             "\"NORMAL\":2},\"indices\":1}]}]",
             required);
    psplat_mesh mesh = read_text("q.gltf", finish(&g, rest));
    assert_near(fabs(signed_volume(&mesh)), 1, 1e-12);
    assert_non_null(mesh.corner_normals);
    assert_near(fabs((double)mesh.corner_normals[0]), 1, 0);
    psplat_mesh_free(&mesh);
}

/* ---- compression ----------------------------------------------------------------------------- */

/* The header of a compressed view, which tests can falsify. */
typedef struct packed {
    const char *mode, *filter;
    size_t stride, count;
    const char *component_and_type;
} packed;

/* Adds compressed bytes to buffer 0, and a view of buffer 1, which has no bytes. */
static void add_packed(gltf *g, const unsigned char *bytes, size_t size, packed p) {
    const char *comma = g->count++ ? "," : "";
    append(g->views, sizeof g->views,
           "%s{\"buffer\":1,\"byteLength\":%zu,\"extensions\":{\"EXT_meshopt_compression\":{"
           "\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"byteStride\":%zu,\"count\":%zu,"
           "\"mode\":\"%s\"%s%s%s}}}",
           comma, p.stride * p.count, g->size, size, p.stride, p.count, p.mode,
           p.filter ? ",\"filter\":\"" : "", p.filter ? p.filter : "", p.filter ? "\"" : "");
    append(g->accessors, sizeof g->accessors, "%s{\"bufferView\":%d,\"count\":%zu,%s}", comma,
           g->count - 1, p.count, p.component_and_type);
    assert_true(g->size + size + 3 < sizeof g->buffer);
    memcpy(g->buffer + g->size, bytes, size);
    g->size += (size + 3) / 4 * 4;
}

static const char *finish_packed(gltf *g, const char *rest) {
    char all[4096];
    snprintf(all, sizeof all, "\"extensionsRequired\":[\"EXT_meshopt_compression\"],%s", rest);
    finish(g, all);
    g->text[strlen(g->text) - 2] = 0;
    append(g->text, sizeof g->text,
           ",{\"byteLength\":1000,\"extensions\":{\"EXT_meshopt_compression\":{\"fallback\":true}}}"
           "]}");
    return g->text;
}

static void add_positions(gltf *g) {
    unsigned char bytes[512];
    size_t size = meshopt_encodeVertexBuffer(bytes, sizeof bytes, points, 4, 12);
    assert_true(size > 0);
    add_packed(g, bytes, size,
               (packed){"ATTRIBUTES", NULL, 12, 4, "\"componentType\":5126,\"type\":\"VEC3\""});
}

/* Adds the indices; stride is 2 or 4 bytes. */
static void add_faces(gltf *g, int is_sequence, size_t stride) {
    unsigned char bytes[512];
    unsigned indices[12];
    for (int i = 0; i < 12; ++i) indices[i] = faces[i];
    size_t size = is_sequence ? meshopt_encodeIndexSequence(bytes, sizeof bytes, indices, 12)
                              : meshopt_encodeIndexBuffer(bytes, sizeof bytes, indices, 12);
    assert_true(size > 0);
    add_packed(g, bytes, size,
               (packed){is_sequence ? "INDICES" : "TRIANGLES", NULL, stride, 12,
                        stride == 2 ? "\"componentType\":5123,\"type\":\"SCALAR\""
                                    : "\"componentType\":5125,\"type\":\"SCALAR\""});
}

static void test_modes(void **state) {
    (void)state;
    for (int i = 0; i < 4; ++i) {
        gltf g = {0};
        add_positions(&g);
        add_faces(&g, i / 2, i % 2 ? 2 : 4);
        check_volume(finish_packed(&g, NODE PLAIN), 1, 1e-12);
    }
}

static void test_filters(void **state) {
    (void)state;
    static const float normals[4][4] = {{0, 0, 1}, {0, 0, -1}, {0, 1, 0}, {1, 0, 0}};
    static const float halves[4][4] = {{0.5f, 0, 0}, {0, 0.5f, 0}, {0, 0, 0.5f}, {0, 0, 0}};
    unsigned char bytes[512];
    float exponents[4][3];
    int8_t octahedra[4][4];
    gltf g = {0};
    meshopt_encodeFilterExp(exponents, 4, 12, 15, &points[0][0]);
    size_t size = meshopt_encodeVertexBuffer(bytes, sizeof bytes, exponents, 4, 12);
    add_packed(
        &g, bytes, size,
        (packed){"ATTRIBUTES", "EXPONENTIAL", 12, 4, "\"componentType\":5126,\"type\":\"VEC3\""});
    add_faces(&g, 0, 4);
    meshopt_encodeFilterOct(octahedra, 4, 4, 8, &normals[0][0]);
    size = meshopt_encodeVertexBuffer(bytes, sizeof bytes, octahedra, 4, 4);
    add_packed(&g, bytes, size,
               (packed){"ATTRIBUTES", "OCTAHEDRAL", 4, 4,
                        "\"componentType\":5120,\"type\":\"VEC3\",\"normalized\":true"});
    int16_t quaternions[4][4];
    /* an attribute that is decoded and then not used */
    meshopt_encodeFilterQuat(quaternions, 4, 8, 12, &halves[0][0]);
    size = meshopt_encodeVertexBuffer(bytes, sizeof bytes, quaternions, 4, 8);
    add_packed(&g, bytes, size,
               (packed){"ATTRIBUTES", "QUATERNION", 8, 4,
                        "\"componentType\":5122,\"type\":\"VEC4\",\"normalized\":true"});
    psplat_mesh mesh =
        read_text("f.gltf", finish_packed(&g, NODE "\"meshes\":[{\"primitives\":[{\"attributes\":{"
                                                   "\"POSITION\":0,\"NORMAL\":2,\"TANGENT\":3},"
                                                   "\"indices\":1}]}]"));
    assert_near(signed_volume(&mesh), 1, 1e-4); /* 15 bits of mantissa */
    assert_non_null(mesh.corner_normals);
    for (size_t k = 0; k < 3; ++k) /* the normal of vertex 0, in bytes */
        assert_near((double)mesh.corner_normals[k], k == 2, 0.01);
    assert_non_null(mesh.corner_tangents);
    psplat_mesh_free(&mesh);
}

/* The GLB has its BIN chunk after a buffer without bytes, and then before it. */
static void test_glb(void **state) {
    (void)state;
    gltf g = {0};
    add_positions(&g);
    add_faces(&g, 0, 2);
    char json[4096] = "", glb[8192];
    append(json, sizeof json,
           "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[\"EXT_meshopt_compression\"]"
           "," NODE PLAIN
           ",\"accessors\":[%s],\"bufferViews\":[%s],\"buffers\":[{\"byteLength\":%zu},"
           "{\"byteLength\":70000,\"extensions\":{\"EXT_meshopt_compression\":{\"fallback\":true}}"
           "}]}",
           g.accessors, g.views, g.size);
    while (strlen(json) % 4) append(json, sizeof json, " ");
    uint32_t length = (uint32_t)strlen(json), bin = (uint32_t)g.size;
    const uint32_t header[5] = {0x46546c67, 2, 28 + length + bin, length, 0x4e4f534a};
    const uint32_t chunk[2] = {bin, 0x004e4942};
    memcpy(glb, header, 20);
    memcpy(glb + 20, json, length);
    memcpy(glb + 20 + length, chunk, 8);
    memcpy(glb + 28 + length, g.buffer, bin);
    psplat_mesh mesh = read_bytes("c.glb", glb, header[2]);
    assert_near(signed_volume(&mesh), 1, 1e-12);
    psplat_mesh_free(&mesh);
}

#define UNINDEXED "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]"

/* Headers announce more than the memory or the bytes can hold; none may reach an assertion of the
 * decoder. */
static void test_refused(void **state) {
    (void)state;
    static const struct {
        packed view;
        size_t size;
        psplat_result code;
        const char *cause;
    } cases[] = {
        {{"ATTRIBUTES", NULL, 12, 4000000, ""}, 64, PSPLAT_ERROR_RANGE, "cannot be in 64"},
        {{"TRIANGLES", NULL, 4, 3000000, ""}, 64, PSPLAT_ERROR_RANGE, "cannot be in 64"},
        {{"INDICES", NULL, 4, 300, ""}, 64, PSPLAT_ERROR_RANGE, "300 elements cannot be in 64"},
        {{"TRIANGLES", NULL, 4, 4, ""}, 64, PSPLAT_ERROR_RANGE, "triangles are incomplete"},
        {{"TRIANGLES", NULL, 3, 3, ""}, 64, PSPLAT_ERROR_RANGE, "byteStride is out of range"},
        {{"ATTRIBUTES", NULL, 0, 4, ""}, 64, PSPLAT_ERROR_RANGE, "byteStride is out of range"},
        {{"ATTRIBUTES", NULL, 260, 4, ""}, 64, PSPLAT_ERROR_RANGE, "byteStride is out of range"},
        {{"ATTRIBUTES", "OCTAHEDRAL", 12, 4, ""}, 64, PSPLAT_ERROR_FORMAT, "its filter is"},
        {{"ATTRIBUTES", "QUATERNION", 4, 4, ""}, 64, PSPLAT_ERROR_FORMAT, "its filter is"},
        {{"ATTRIBUTES", "LANCZOS", 4, 4, ""}, 64, PSPLAT_ERROR_FORMAT, "its filter is"},
        {{"INDICES", "EXPONENTIAL", 4, 4, ""}, 64, PSPLAT_ERROR_FORMAT, "its filter is"},
        {{"POINTS", NULL, 4, 4, ""}, 64, PSPLAT_ERROR_FORMAT, "unknown compression mode"},
        {{"ATTRIBUTES", NULL, 12, 4, ""}, 64, PSPLAT_ERROR_FORMAT, "bytes are damaged"},
        {{"TRIANGLES", NULL, 4, 12, ""}, 64, PSPLAT_ERROR_FORMAT, "bytes are damaged"},
        {{"INDICES", NULL, 4, 12, ""}, 64, PSPLAT_ERROR_FORMAT, "bytes are damaged"},
    };
    static const unsigned char zeros[64];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        packed view = cases[i].view;
        view.component_and_type = "\"componentType\":5126,\"type\":\"VEC3\"";
        gltf g = {0};
        add_packed(&g, zeros, cases[i].size, view);
        refuse_text("r.gltf", finish_packed(&g, NODE UNINDEXED), cases[i].code, cases[i].cause);
    }
    /* Several views of the same bytes would multiply the memory needed. */
    gltf g = {0};
    add_positions(&g);
    size_t size = g.size;
    add_positions(&g);
    char *second = strstr(strstr(g.views, "byteOffset") + 1, "byteOffset");
    second[12] = '0', second[13] = ','; /* the digits after "byteOffset": */
    memmove(second + 14, strstr(second + 13, "\"byteLength"),
            strlen(strstr(second + 13, "\"byteLength")) + 1);
    g.size = size;
    refuse_text("r.gltf", finish_packed(&g, NODE UNINDEXED), PSPLAT_ERROR_RANGE, "are not its own");
}

/* Whatever a byte is changed to, the mesh is read or refused. */
static void test_damaged(void **state) {
    (void)state;
    gltf whole = {0};
    add_positions(&whole);
    add_faces(&whole, 0, 4);
    size_t refused = 0;
    for (size_t i = 0; i < whole.size; ++i)
        for (int bit = 0; bit < 8; bit += 3) {
            psplat_mesh mesh;
            gltf g = whole;
            g.buffer[i] ^= (unsigned char)(1 << bit);
            const char *text = finish_packed(&g, NODE PLAIN);
            write_bytes("d.gltf", text, strlen(text));
            refused += psplat_mesh_read(fixture_path, &mesh, NULL) != PSPLAT_OK;
            unlink(fixture_path);
            psplat_mesh_free(&mesh);
        }
    assert_true(refused > 0);
}

int test_read_gltf_packed_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sparse),  cmocka_unit_test(test_quantised),
        cmocka_unit_test(test_modes),   cmocka_unit_test(test_filters),
        cmocka_unit_test(test_glb),     cmocka_unit_test(test_refused),
        cmocka_unit_test(test_damaged),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

/* SPDX-License-Identifier: MIT
 *
 * test_read_gltf.c - tests of reading glTF and GLB: modes, index types, transforms, attributes,
 * materials, and what is refused. Each file is a small JSON with its buffer as a data URI, mostly a
 * tetrahedron, whose volume is known.
 */
#include "gltf_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "material/source_materials.h"
#include "mesh/mesh.h"

static void check_volume(const char *text, double six_volumes, size_t triangles) {
    psplat_mesh mesh = read_text("t.gltf", text);
    assert_int_equal(mesh.triangle_count, triangles);
    assert_near(signed_volume(&mesh), six_volumes, 1e-12 * fabs(six_volumes));
    psplat_mesh_free(&mesh);
}

static void test_index_types(void **state) {
    (void)state;
    uint16_t shorts[12];
    uint32_t ints[12];
    float unindexed[12][3];
    for (int i = 0; i < 12; ++i) {
        shorts[i] = faces[i];
        ints[i] = faces[i];
        memcpy(unindexed[i], points[faces[i]], sizeof unindexed[i]);
    }
    gltf g = tetrahedron();
    check_volume(finish(&g, NODE INDEXED), 1, 4);
    g = with_points();
    add(&g, shorts, sizeof shorts, USHORT, "SCALAR", 12, "");
    check_volume(finish(&g, NODE INDEXED), 1, 4);
    g = with_points();
    add(&g, ints, sizeof ints, UINT, "SCALAR", 12, "");
    check_volume(finish(&g, NODE INDEXED), 1, 4);
    g = (gltf){0};
    add(&g, unindexed, sizeof unindexed, FLOAT, "VEC3", 12, "");
    check_volume(
        finish(&g, NODE "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]"), 1, 4);
}

static void test_strips_and_fans(void **state) {
    (void)state;
    /* A closed tetrahedron as one strip, which alternation turns into 0 2 1, 1 2 3, 1 3 0, 0 3 2.
     */
    static const unsigned char strip[6] = {0, 2, 1, 3, 0, 2};
    gltf g = with_points();
    add(&g, strip, sizeof strip, UBYTE, "SCALAR", 6, "");
    check_volume(finish(&g, NODE "\"meshes\":[{\"primitives\":[{\"mode\":5,\"attributes\":{"
                                 "\"POSITION\":0},\"indices\":1}]}]"),
                 1, 4);
    /* A fan around vertex 0, and the opposite face; points and lines beside them are not drawn. */
    static const unsigned char fan[5] = {3, 1, 2, 0, 1}, cap[3] = {0, 2, 1};
    g = with_points();
    add(&g, fan, sizeof fan, UBYTE, "SCALAR", 5, "");
    add(&g, cap, sizeof cap, UBYTE, "SCALAR", 3, "");
    check_volume(finish(&g, NODE "\"meshes\":[{\"primitives\":["
                                 "{\"mode\":6,\"attributes\":{\"POSITION\":0},\"indices\":1},"
                                 "{\"mode\":1,\"attributes\":{\"POSITION\":0},\"indices\":1},"
                                 "{\"mode\":0,\"attributes\":{\"POSITION\":0}},"
                                 "{\"attributes\":{\"POSITION\":0},\"indices\":2}]}]"),
                 1, 4);
}

static void test_transforms(void **state) {
    (void)state;
    gltf g = tetrahedron();
    /* Two nested nodes scale by 2, below a mirroring one: the volume is 64 times as large, and
     * triangles still face outwards. */
    const char *text =
        finish(&g, SCENE "\"nodes\":[{\"children\":[1],\"scale\":[-2,2,2],\"rotation\":[0,0,1,0]},"
                         "{\"mesh\":0,\"matrix\":[2,0,0,0,0,2,0,0,0,0,2,0,1,2,3,1]}]," INDEXED);
    check_volume(text, 64, 4);
    psplat_mesh mesh = read_text("t.gltf", text);
    /* The child's x of 1 ... 3, times -2 and turned by 180 degrees about z, becomes 2 ... 6; y
     * becomes -2 x (2 ... 4). */
    static const double origin[3] = {4, -6, 8};
    for (int k = 0; k < 3; ++k) assert_near(mesh.origin[k], origin[k], 1e-12);
    psplat_mesh_free(&mesh);
    /* The mesh has two instances. */
    check_volume(finish(&g, "\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":[{\"mesh\":0},"
                            "{\"mesh\":0,\"translation\":[8,0,0]}]," INDEXED),
                 2, 8);
    /* Only the scene's nodes count; in a file without scenes all nodes count. */
    check_volume(
        finish(&g, SCENE "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[8,0,0]}]," INDEXED),
        1, 4);
    check_volume(finish(&g, INDEXED), 1, 4);
}

static void test_normals(void **state) {
    (void)state;
    /* A face with a normal at 45 degrees is stretched by 2 in x: the inverse transpose halves the
     * normal's x. The mirrored instance must turn the normal along with its winding. */
    static const float triangle[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    static const float normals[3][3] = {{1, 0, 1}, {0, 0, 0}, {0, 0, 1}};
    gltf g = {0};
    add(&g, triangle, sizeof triangle, FLOAT, "VEC3", 3, "");
    add(&g, normals, sizeof normals, FLOAT, "VEC3", 3, "");
    psplat_mesh mesh = read_text(
        "n.gltf",
        finish(&g, SCENE "\"nodes\":[{\"mesh\":0,\"scale\":[-2,1,1]}],\"meshes\":[{"
                         "\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]"));
    double length = sqrt(0.25 + 1);
    const double expected[9] = {-0.5 / length, 0, 1 / length, 0, 0, 1, 0, 0, 0};
    assert_non_null(mesh.corner_normals);
    for (int i = 0; i < 9; ++i) assert_near((double)mesh.corner_normals[i], expected[i], 1e-6);
    psplat_mesh_free(&mesh);
}

static void test_uvs_and_tangents(void **state) {
    (void)state;
    /* The first triangle has no area, so that the attributes of the second one move up with its
     * corners. The node mirrors, so that its second and third corner are exchanged and the
     * tangent's sign turns. Normalised unsigned shorts stand for 0 ... 1, and others for their
     * values (KHR_mesh_quantization). */
    static const float corners[6][3] = {{5, 5, 5}, {5, 5, 5}, {5, 5, 5},
                                        {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    static const float tangents[6][4] = {{0}, {0}, {0}, {1, 1, 0, 1}, {0, 1, 0, -1}, {1, 0, 0, 1}};
    static const uint16_t first[6][2] = {{0}, {0}, {0}, {65535, 0}, {0, 13107}, {0, 0}};
    static const uint16_t second[6][2] = {{0}, {0}, {0}, {7, 0}, {0, 3}, {0, 0}};
    gltf g = {0};
    add(&g, corners, sizeof corners, FLOAT, "VEC3", 6, "");
    add(&g, tangents, sizeof tangents, FLOAT, "VEC4", 6, "");
    add(&g, first, sizeof first, USHORT, "VEC2", 6, ",\"normalized\":true");
    add(&g, second, sizeof second, USHORT, "VEC2", 6, "");
    psplat_mesh mesh = read_text(
        "t.gltf", finish(&g, SCENE "\"nodes\":[{\"mesh\":0,\"scale\":[-2,1,1]}],\"meshes\":[{"
                                   "\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TANGENT\":1,"
                                   "\"TEXCOORD_0\":2,\"TEXCOORD_1\":3}}]}]"));
    assert_int_equal(mesh.triangle_count, 1);
    assert_non_null(mesh.corner_tangents);
    assert_non_null(mesh.corner_uvs[0]);
    assert_non_null(mesh.corner_uvs[1]);
    const float turned[12] = {-1, 0.5f, 0, -1, -1, 0, 0, -1, 0, 1, 0, 1};
    const double uvs[2][6] = {{1, 0, 0, 0, 0, 0.2}, {7, 0, 0, 0, 0, 3}};
    assert_memory_equal(mesh.corner_tangents, turned, sizeof turned);
    for (size_t i = 0; i < 12; ++i)
        assert_near((double)mesh.corner_uvs[i / 6][i % 6], uvs[i / 6][i % 6], 1e-7);
    psplat_mesh_free(&mesh);
}

/* A primitive without colours, normals and texture coordinates comes after one that has them, and
 * then before it. */
static void test_attributes_of_some(void **state) {
    (void)state;
    static const float normals[4][3] = {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
    static const float colors[4][3] = {{0.5f, 0, 0}, {0.5f, 0, 0}, {0.5f, 0, 0}, {0.5f, 0, 0}};
    static const float uvs[4][2] = {{2, 3}, {2, 3}, {2, 3}, {2, 3}};
    static const char *const orders[2] = {"1,0", "0,1"};
    for (size_t kind = 0; kind < 2; ++kind) {
        char nodes[512];
        gltf g = tetrahedron();
        add(&g, normals, sizeof normals, FLOAT, "VEC3", 4, "");
        add(&g, colors, sizeof colors, FLOAT, "VEC3", 4, "");
        add(&g, uvs, sizeof uvs, FLOAT, "VEC2", 4, "");
        snprintf(nodes, sizeof nodes,
                 "\"scenes\":[{\"nodes\":[%s]}],\"nodes\":[{\"mesh\":0,\"translation\":[9,0,0]},{"
                 "\"mesh\":1}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
                 "\"NORMAL\":2,\"COLOR_0\":3,\"TEXCOORD_0\":4},\"indices\":1}]},{\"primitives\":[{"
                 "\"attributes\":{\"POSITION\":0},\"indices\":1}]}]",
                 orders[kind]);
        psplat_mesh mesh = read_text("s.gltf", finish(&g, nodes));
        /* the first corners of either primitive */
        size_t with = kind ? 0 : 12, without = 12 - with;
        assert_int_equal(mesh.triangle_count, 8);
        assert_true(mesh.corner_normals[3 * with] == 1 && mesh.corner_normals[3 * without] == 0);
        assert_true(mesh.corner_colors[4 * with] == 0.5f && mesh.corner_colors[4 * without] == 1);
        assert_true(mesh.corner_uvs[0][2 * with] == 2 && mesh.corner_uvs[0][2 * without] == 0);
        assert_null(mesh.corner_uvs[1]);
        assert_null(mesh.corner_tangents);
        psplat_mesh_free(&mesh);
    }
}

static void test_colors(void **state) {
    (void)state;
    static const unsigned char bytes[16] = {255, 0, 51, 102, 0, 255, 0, 255, 0, 0, 255, 255};
    static const uint16_t shorts[12] = {65535, 0, 13107, 0, 0, 65535, 0, 0};
    static const float floats[12] = {1, 0, 0.2f, 0, 1, 0, 0, 2, -1};
    const char *rest = NODE "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
                            "\"COLOR_0\":2},\"indices\":1}]}]";
    for (int kind = 0; kind < 3; ++kind) {
        gltf g = tetrahedron();
        if (kind == 0) add(&g, bytes, 16, UBYTE, "VEC4", 4, ",\"normalized\":true");
        if (kind == 1) add(&g, shorts, 24, USHORT, "VEC3", 4, ",\"normalized\":true");
        if (kind == 2) add(&g, floats, 48, FLOAT, "VEC3", 4, "");
        psplat_mesh mesh = read_text("c.gltf", finish(&g, rest));
        assert_non_null(mesh.corner_colors);
        assert_near((double)mesh.corner_colors[0], 1, 0);
        assert_near((double)mesh.corner_colors[2], 0.2, 1e-6); /* linear values as stored */
        assert_near((double)mesh.corner_colors[3], kind == 0 ? 0.4 : 1, 1e-6);
        for (size_t i = 0; i < 48; ++i)
            assert_true(mesh.corner_colors[i] >= 0 && mesh.corner_colors[i] <= 1);
        psplat_mesh_free(&mesh);
    }
}

static void test_one_material(void **state) {
    (void)state;
    gltf g = tetrahedron();
    psplat_mesh mesh = read_text(
        "m.gltf",
        finish(
            &g, NODE
            "\"extensionsUsed\":[\"KHR_materials_unlit\"],\"materials\":[{\"doubleSided\":true,"
            "\"emissiveFactor\":[0,0.5,1],\"extensions\":{\"KHR_materials_unlit\":{}},"
            "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.1,0.2,0.3,0.4],"
            "\"metallicFactor\":0.25,\"roughnessFactor\":0.75}}],\"meshes\":[{"
            "\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}]"));
    for (int k = 0; k < 4; ++k)
        assert_near((double)mesh.material.base_color[k], 0.1 * (k + 1), 1e-7);
    assert_near((double)mesh.material.emissive[1], 0.5, 0);
    assert_near((double)mesh.material.metallic, 0.25, 0);
    assert_near((double)mesh.material.roughness, 0.75, 0);
    assert_int_equal(mesh.material.double_sided, 1);
    assert_int_equal(mesh.material.unlit, 1);
    for (int t = 0; t < 4; ++t) assert_int_equal(mesh.groups[t], 0);
    assert_null(mesh.corner_colors);
    psplat_mesh_free(&mesh);
}

/* PNGs of one texel, what differs between them: black, (255, 128, 0) with an alpha of 64, white,
 * and black with an alpha of 128. */
static const char *const texels[] = {"NgYGD4DwABBAEAgLvRWw", "P438DgAAAFwQHASVKQtg",
                                     "P4////fwAJ+wP99djxmg", "NgYGBoAAAAhQCBRcqBlw"};

/* Reads a material with KHR_materials_pbrSpecularGlossiness, whose textures are those texels and
 * one that is missing. */
static psplat_mesh read_specular(const char *alpha_mode, const char *extension) {
    gltf g = tetrahedron();
    char rest[4096] = NODE "\"extensionsUsed\":[\"KHR_materials_pbrSpecularGlossiness\"],";
    for (int i = 0; i < 4; ++i)
        append(rest, sizeof rest,
               "%s{\"uri\":\"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAA"
               "DUlEQVR42m%sAAAABJRU5ErkJggg==\"}",
               i ? "," : "\"images\":[", texels[i]);
    append(rest, sizeof rest, ",{\"uri\":\"missing.png\"}");
    for (int i = 0; i < 5; ++i)
        append(rest, sizeof rest, "%s{\"source\":%d}", i ? "," : "],\"textures\":[", i);
    append(rest, sizeof rest,
           "],\"materials\":[{\"alphaMode\":\"%s\",\"pbrMetallicRoughness\":{\"baseColorFactor\":["
           "0,1,0,1]},"
           "\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{%s}}}],"
           "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,"
           "\"material\":0}]}]",
           alpha_mode, extension);
    return read_text("m.gltf", finish(&g, rest));
}

/* What reflects 4 % is no metal, and what reflects alone is one; in between the brighter says more.
 * Factors multiply the means of textures. */
static void test_specular_glossiness(void **state) {
    (void)state;
    static const struct {
        const char *extension;
        double base[4], metallic, roughness;
    } cases[] = {
        {"\"diffuseFactor\":[0.5,0.25,0.1,0.8],\"specularFactor\":[0.04,0.04,0.04],"
         "\"glossinessFactor\":0.3",
         {0.5, 0.25, 0.1, 0.8},
         0,
         0.7},
        {"\"diffuseFactor\":[0,0,0,1],\"specularFactor\":[0.9,0.6,0.3],\"glossinessFactor\":1",
         {0.9, 0.6, 0.3, 1},
         1,
         0},
        {"\"diffuseTexture\":{\"index\":2},\"specularGlossinessTexture\":{\"index\":3}",
         {1 / 0.96, 1 / 0.96, 1 / 0.96, 1},
         0,
         1 - 128 / 255.0},
        {"\"diffuseTexture\":{\"index\":0},\"specularGlossinessTexture\":{\"index\":1},"
         "\"specularFactor\":[1,1,0.5],\"glossinessFactor\":0.5",
         {1, 1, 0.5, 1},
         1,
         1 - 32 / 255.0},
        {"", {1, 1, 1, 1}, 1, 0},
        {"\"diffuseTexture\":{\"index\":2},\"specularGlossinessTexture\":{\"index\":4}",
         {1, 1, 1, 1},
         0,
         0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_mesh mesh = read_specular("OPAQUE", cases[i].extension);
        assert_int_equal(mesh.source_material_count, 2); /* and the default one */
        const psplat_source_material *m = &mesh.source_materials[0];
        for (int k = 0; k < 4; ++k)
            assert_near((double)m->material.base_color[k], fmin(cases[i].base[k], 1), 1e-6);
        assert_near((double)m->material.metallic, cases[i].metallic, 1e-6);
        assert_near((double)m->material.roughness, cases[i].roughness, 1e-6);
        assert_null(m->metallic_roughness.image);
        if (i == 2) assert_true(m->base_color.image->pixels[0] == 255);
        if (i == 3) assert_true(m->base_color.image->pixels[1] == 128);
        if (i < 2) assert_null(m->base_color.image);
        if (i == 5) assert_true(m->base_color.image->pixels[0] == 255);
        psplat_mesh_free(&mesh);
    }
    /* The alpha of diffuse colours cuts, and not that of specular ones. */
    psplat_mesh mesh = read_specular("MASK", cases[3].extension);
    assert_true(mesh.source_materials[0].base_color.image->pixels[3] == 255);
    psplat_mesh_free(&mesh);
}

static void test_two_materials(void **state) {
    (void)state;
    /* The default material of glTF (white, metallic) stands beside a red one whose texture is
     * missing. */
    gltf g = tetrahedron();
    psplat_mesh mesh = read_text(
        "m.gltf",
        finish(
            &g, SCENE
            "\"nodes\":[{\"mesh\":0,\"children\":[1]},{\"mesh\":1,\"translation\":[4,0,0]}],"
            "\"images\":[{\"uri\":\"missing.png\"}],\"textures\":[{\"source\":0}],\"materials\":[{"
            "\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0,0,1],\"metallicFactor\":0,"
            "\"baseColorTexture\":{\"index\":0}}}],\"meshes\":["
            "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]},"
            "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]"));
    assert_int_equal(mesh.triangle_count, 8);
    assert_non_null(mesh.groups);
    assert_int_equal(mesh.groups[0], mesh.groups[3]);
    assert_int_not_equal(mesh.groups[3], mesh.groups[4]);
    assert_null(mesh.corner_colors);
    assert_int_equal(mesh.source_material_count, 2);
    const psplat_source_material *red = &mesh.source_materials[mesh.groups[0]];
    const psplat_source_material *white = &mesh.source_materials[mesh.groups[4]];
    assert_near((double)red->material.base_color[1], 0, 0);
    assert_near((double)white->material.base_color[1], 1, 0);
    assert_near((double)white->material.metallic, 1, 0);
    /* An image that cannot be read says why, and the factor is used without it. */
    assert_null(red->base_color.image->pixels);
    assert_non_null(strstr(red->base_color.image->problem, "missing.png"));
    assert_null(white->base_color.image);
    assert_near((double)mesh.material.metallic, 0, 0); /* the first material's */
    psplat_mesh_free(&mesh);
}

static void test_glb(void **state) {
    (void)state;
    static const char json[] =
        "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":"
        "{\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
        "\"type\":\"VEC3\",\"count\":3}],\"bufferViews\":[{\"buffer\":0,"
        "\"byteLength\":36}],\"buffers\":[{\"byteLength\":36}]}   ";
    unsigned char data[512] = "glTF";
    uint32_t length = (sizeof json - 1) / 4 * 4, total = 12 + 8 + length + 8 + 36, version = 2,
             size = 36;
    memcpy(data + 4, &version, 4);
    memcpy(data + 8, &total, 4);
    memcpy(data + 12, &length, 4);
    memcpy(data + 16, "JSON", 4);
    memcpy(data + 20, json, length);
    memcpy(data + 20 + length, &size, 4);
    memcpy(data + 24 + length, "BIN", 4);
    memcpy(data + 28 + length, points[1], 36); /* the last three points */
    psplat_mesh mesh = read_bytes("g.glb", data, total);
    assert_int_equal(mesh.triangle_count, 1);
    psplat_mesh_free(&mesh);
    data[29] = '}';
    refuse_bytes("g.glb", data, total, PSPLAT_ERROR_FORMAT,
                 "byte 29: '}' does not belong here in JSON");
    data[29] = '{', data[20] = '[';
    refuse_bytes("g.glb", data, total, PSPLAT_ERROR_FORMAT, "byte 28: ':' does not belong");
    data[20] = '{';
    refuse_bytes("g.glb", data, 10, PSPLAT_ERROR_FORMAT, "byte 10: the file ends");
    refuse_bytes("g.glb", data, total - 1, PSPLAT_ERROR_FORMAT, "byte 8: the header says");
    data[4] = 1;
    refuse_bytes("g.glb", data, total, PSPLAT_ERROR_UNSUPPORTED, "byte 4: GLB version 1");
    data[4] = 2;
    /* The chunk's length exceeds the file by its own header of eight bytes. */
    data[20 + length] = 44;
    refuse_bytes("g.glb", data, total, PSPLAT_ERROR_FORMAT,
                 "the BIN chunk is longer than the file");
    data[20 + length] = 36;
    data[14] = 1;
    refuse_bytes("g.glb", data, total, PSPLAT_ERROR_FORMAT, "byte 12: the JSON chunk");
}

static void test_refused(void **state) {
    (void)state;
    gltf g = tetrahedron();
    refuse_text("bad.gltf", "{\"asset\":{\"version\":\"2.0\"}}", PSPLAT_ERROR_NO_SPLATS,
                "no triangles");
    refuse_text("bad.gltf", finish(&g, NODE "\"extensionsRequired\":[\"EXT_shape\"]," INDEXED),
                PSPLAT_ERROR_UNSUPPORTED,
                "extensionsRequired: EXT_shape is not supported; export the model without it");
    refuse_text("bad.gltf", finish(&g, "\"scenes\":[{\"nodes\":[7]}],\"nodes\":[]," INDEXED),
                PSPLAT_ERROR_RANGE, "node 7 does not exist");
    refuse_text("bad.gltf", finish(&g, SCENE "\"nodes\":[{\"mesh\":3}]," INDEXED),
                PSPLAT_ERROR_RANGE, "mesh 3 does not exist");
    refuse_text("bad.gltf", finish(&g, SCENE "\"nodes\":[{\"mesh\":0,\"children\":[0]}]," INDEXED),
                PSPLAT_ERROR_FORMAT, "node 0");
    refuse_text("bad.gltf",
                finish(&g, SCENE "\"nodes\":[{\"mesh\":0,\"scale\":[1e300,1e300,1e300],"
                                 "\"children\":[1]},{\"scale\":[1e300,1,1]}]," INDEXED),
                PSPLAT_ERROR_RANGE, "not finite");
    refuse_text(
        "bad.gltf",
        finish(&g, NODE "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":9}}]}]"),
        PSPLAT_ERROR_RANGE, "accessor 9 does not exist");
    refuse_text("bad.gltf",
                finish(&g, NODE "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
                                "\"NORMAL\":1}}]}]"),
                PSPLAT_ERROR_FORMAT, "attribute NORMAL");
    refuse_text("bad.gltf",
                finish(&g, NODE "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
                                "\"indices\":1,\"material\":2}]}]"),
                PSPLAT_ERROR_RANGE, "material 2 does not exist");
    refuse_text("bad.gltf",
                finish(&g, NODE "\"meshes\":[{\"primitives\":[{\"mode\":1,\"attributes\":{"
                                "\"POSITION\":0}}]}]"),
                PSPLAT_ERROR_NO_SPLATS, "no triangles");
}

/* Errors of JSON have a place and a cause in words of their own. */
static void test_refused_json(void **state) {
    (void)state;
    static const struct {
        const char *text, *cause;
    } cases[] = {
        {"{\"asset\":", "line 1, column 10: the JSON ends before it is complete"},
        {"{\"asset\":{}\n,\n  x}", "line 3, column 3: 'x' does not belong here in JSON"},
        {"{\"asset\":tru3}", "line 1, column 13: '3' does not belong here in JSON"},
        {"{\"asset\":{} \x80}", "line 1, column 13: a byte of value 128 does not belong here"},
        {"{\"asset\":\"\\x\"}",
         "line 1, column 12: a string has an escape that JSON does not know"},
        {"{\"asset\":\"a\nb\"}", "line 1, column 12: a string has no end"},
        {"{\"asset\":\"\xff\"}", "line 1, column 11: a string is not UTF-8"},
        {"{\"asset\":1e999}", "a number is too large"},
        {"{\"scenes\":[]}", "asset: has no version"},
        {"{\"asset\":{\"version\":\"2.0\"},\"meshes\":{}}", "meshes: is not an array"},
        {"{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{},7]}", "nodes[1]: is not an object"},
        {"{\"asset\":{\"version\":\"2.0\"},\"accessors\":[{\"componentType\":5126,\"count\":1}]}",
         "accessors[0]: has no type"},
        {"{\"asset\":{\"version\":\"2.0\"},\"accessors\":[{\"componentType\":5126,\"count\":-1}]}",
         "accessors[0]: count is not a whole number from 0 on"},
        {"{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{}]}]}",
         "meshes[0].primitives[0]: has no attributes"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        refuse_text("bad.gltf", cases[i].text, PSPLAT_ERROR_FORMAT, cases[i].cause);
}

static void test_refused_accessors(void **state) {
    (void)state;
    static const unsigned char beyond[3] = {0, 1, 4}, zeros[400];
    static const float nan_points[9] = {0, 0, 0, 1, 0, 0, 0, NAN, 0};
    gltf g = with_points();
    add(&g, beyond, sizeof beyond, UBYTE, "SCALAR", 3, "");
    refuse_text("bad.gltf", finish(&g, NODE INDEXED), PSPLAT_ERROR_RANGE,
                "accessor 1: index 2 is vertex 4 of 4");
    g = with_points();
    add(&g, faces, sizeof faces, UBYTE, "SCALAR", 13, "");
    refuse_text("bad.gltf", finish(&g, NODE INDEXED), PSPLAT_ERROR_RANGE,
                "accessor 1: 13 elements do not fit");
    g = with_points();
    add(&g, faces, sizeof faces, UBYTE, "SCALAR", 12, ",\"byteOffset\":4294967295");
    refuse_text("bad.gltf", finish(&g, NODE INDEXED), PSPLAT_ERROR_RANGE, "accessor 1: ");
    g = with_points();
    add(&g, faces, sizeof faces, FLOAT, "SCALAR", 3, "");
    refuse_text("bad.gltf", finish(&g, NODE INDEXED), PSPLAT_ERROR_FORMAT,
                "accessor 1: not a type for indices");
    g = with_points();
    add(&g, zeros, sizeof zeros, UBYTE, "SCALAR", 12, "");
    g.size = 64;
    refuse_text("bad.gltf", finish(&g, NODE INDEXED), PSPLAT_ERROR_RANGE,
                "accessor 1: its bufferView ends beyond");
    g = (gltf){0};
    add(&g, nan_points, sizeof nan_points, FLOAT, "VEC3", 3, "");
    refuse_text(
        "bad.gltf",
        finish(&g, NODE "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]"),
        PSPLAT_ERROR_RANGE, "vertex 2: a coordinate is not finite");
    /* A missing buffer, a short one, and JSON nested too deeply for a recursive reader. */
    refuse_text("bad.gltf",
                "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":4,\"uri\":\"missing."
                "bin\"}]}",
                PSPLAT_ERROR_FORMAT, "missing.bin");
    /* A model may refer only to files beside it and below. */
    static const char *const outside[] = {"../bad.gltf", "a/../../bad.gltf", "%2e%2e/bad.gltf"};
    for (size_t i = 0; i < 3; ++i) {
        char text[128];
        snprintf(
            text, sizeof text,
            "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":4,\"uri\":\"%s\"}]}",
            outside[i]);
        refuse_text("bad.gltf", text, PSPLAT_ERROR_FORMAT, "leaves its directory");
    }
    refuse_text("bad.gltf",
                "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":400,"
                "\"uri\":\"data:application/octet-stream;base64,AAAA\"}]}",
                PSPLAT_ERROR_FORMAT, "");
    char deep[1024] = "{\"extras\":";
    memset(deep + strlen(deep), '[', 500);
    refuse_text("bad.gltf", deep, PSPLAT_ERROR_RANGE, "byte 73: JSON nested deeper");
}

int test_read_gltf_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_index_types),
        cmocka_unit_test(test_strips_and_fans),
        cmocka_unit_test(test_transforms),
        cmocka_unit_test(test_normals),
        cmocka_unit_test(test_uvs_and_tangents),
        cmocka_unit_test(test_attributes_of_some),
        cmocka_unit_test(test_colors),
        cmocka_unit_test(test_one_material),
        cmocka_unit_test(test_specular_glossiness),
        cmocka_unit_test(test_two_materials),
        cmocka_unit_test(test_glb),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_refused_accessors),
        cmocka_unit_test(test_refused_json),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

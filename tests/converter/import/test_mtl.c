/* SPDX-License-Identifier: MIT
 *
 * test_mtl.c - tests of OBJ materials (MTL): factors, textures and groups, and libraries or images
 * that are missing, broken or outside the model's directory. The shape is a square of two
 * triangles.
 */
#include "mesh_fixture.h"

#include "picture_bytes.h"
#include "import/read_scene.h"
#include "material/source_materials.h"
#include "mesh/mesh.h"
#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Two triangles side by side, whose materials each test defines. */
#define SQUARE                                                                                     \
    "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 0.25\n"
#define FACES "usemtl one\nf 1/1 2/2 3/3\nusemtl two words\nf 1/1 3/3 4/4\n"

static void put(const char *name, const void *data, size_t size) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", fixture_directory, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static void drop(const char *name) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", fixture_directory, name);
    remove(path);
}

static psplat_mesh read_with(const char *library, const char *obj) {
    put("m.mtl", library, strlen(library));
    psplat_mesh mesh = read_text("m.obj", obj);
    drop("m.mtl");
    return mesh;
}

static double srgb(double value) {
    return pow((value + 0.055) / 1.055, 2.4);
}

static void test_factors(void **state) {
    (void)state;
    psplat_mesh mesh =
        read_with("# comment\nnewmtl one \r\n Kd 0.5 1 0.25\r\nKe 0 0 1\nNs 0\nd 0.5\n"
                  "newmtl other\nKd 0 0 0\nnewmtl two words\nKd 0.5\nPr 0.125\nPm 1\n"
                  "Tr 0\nKd\nNs x\n",
                  SQUARE FACES);
    assert_int_equal(mesh.triangle_count, 2);
    assert_int_equal(mesh.source_material_count, 3);
    assert_null(mesh.materials->problem);
    const psplat_source_material *one = &mesh.source_materials[mesh.groups[0]];
    const psplat_source_material *two = &mesh.source_materials[mesh.groups[1]];
    assert_string_equal(one->name, "one");
    assert_string_equal(two->name, "two words");
    /* Tolerances here and below are for rounding to float. */
    assert_near(one->material.base_color[0], srgb(0.5), 1e-6);
    assert_near(one->material.base_color[1], 1, 1e-6);
    assert_near(one->material.base_color[3], 0.5, 0);
    assert_true(one->is_blended && !two->is_blended);
    assert_near(one->material.emissive[2], 1, 1e-6);
    assert_near(one->material.roughness, 1, 1e-6);
    assert_near(two->material.base_color[2], srgb(0.5), 1e-6);
    assert_near(two->material.roughness, 0.125, 0);
    assert_near(two->material.metallic, 1, 0);
    assert_int_equal(one->material.double_sided, 1); /* a square has a border */
    psplat_mesh_free(&mesh);
    mesh = read_with("newmtl one\nNs 30\n", SQUARE FACES);
    assert_near(mesh.source_materials[mesh.groups[0]].material.roughness, 0.5,
                1e-6); /* 2/32 = 0.5^4 */
    psplat_mesh_free(&mesh);
}

/* Tr 1 is transparent only where the library does not contradict it. */
static void test_transparency(void **state) {
    (void)state;
    static const struct {
        const char *library;
        double one, two; /* alphas */
    } cases[] = {
        {"newmtl one\nTr 1.0\nnewmtl two words\nTr 1.000000\n", 1, 1},
        {"newmtl one\nTr 1.0\nnewmtl two words\nTr 0\n", 0, 1},
        {"newmtl one\nTr 1.0\nnewmtl two words\nnewmtl unused\nTr 0.5\n", 0, 1},
        {"newmtl one\nd 1\nTr 1.0\nnewmtl two words\nTr 1.0\nd 1\n", 1, 1},
        {"newmtl one\nTr 1\nd 0.25\nnewmtl two words\nTr 0.25\n", 0.25, 0.75},
        {"newmtl one\nTr 0.5\nnewmtl two words\nTr 0.5\n", 0.5, 0.5},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_mesh mesh = read_with(cases[i].library, SQUARE FACES);
        const psplat_source_material *one = &mesh.materials->source_materials[0];
        assert_near(one[0].material.base_color[3], cases[i].one, 0);
        assert_near(one[1].material.base_color[3], cases[i].two, 0);
        assert_int_equal(one[0].is_blended, cases[i].one < 1);
        assert_int_equal(one[1].is_blended, cases[i].two < 1);
        psplat_mesh_free(&mesh);
    }
}

/* Texture coordinates run down the image, and belong to corners. */
static void test_texture(void **state) {
    (void)state;
    static const uint8_t pixels[2][3] = {{255, 0, 0}, {0, 0, 255}};
    size_t size;
    uint8_t *png = png_of(pixels, 1, 2, PNG_FORMAT_RGB, NULL, &size);
    put("a b.png", png, size);
    psplat_mesh mesh =
        read_with("newmtl one\nKd 1 1 1\nmap_Kd -clamp on -s 2 3 -o 0.5 .\\a b.png \n"
                  "newmtl two words\nmap_Kd -s 2 -bm 1 a b.png\n"
                  "map_Ke a b.png\nnorm -mm 0 1 a b.png\n",
                  SQUARE FACES);
    const psplat_source_material *one = &mesh.source_materials[mesh.groups[0]];
    const psplat_source_material *two = &mesh.source_materials[mesh.groups[1]];
    assert_int_equal(mesh.materials->image_count, 1);
    assert_ptr_equal(one->base_color.image, two->base_color.image);
    assert_int_equal(one->base_color.image->height, 2);
    assert_memory_equal(one->base_color.image->pixels, "\xff\0\0\xff\0\0\xff\xff", 8);
    assert_int_equal(one->base_color.wrap[1], PSPLAT_WRAP_CLAMP);
    assert_int_equal(two->base_color.wrap[1], PSPLAT_WRAP_REPEAT);
    assert_ptr_equal(two->normal.image, two->emissive.image);
    assert_near(two->material.emissive[0], 1, 0);
    /* v' = 3 v with t = 1 - v: t' = 1 - 3 (1 - t). */
    const double *rows = one->base_color.transform;
    assert_near(rows[0], 2, 0);
    assert_near(rows[2], 0.5, 0);
    assert_near(rows[4], 3, 0);
    assert_near(rows[5], -2, 0);
    assert_near(two->base_color.transform[4], 1, 0);
    /* The same as textures that splats may keep; the image is that of the file, byte by byte. */
    const psplat_texture *kept = one->material.textures;
    assert_int_equal(kept[PSPLAT_TEXTURE_BASE_COLOR].image, 1);
    assert_int_equal(kept[PSPLAT_TEXTURE_BASE_COLOR].wrap[1], PSPLAT_WRAP_CLAMP);
    assert_near(kept[PSPLAT_TEXTURE_BASE_COLOR].transform[5], -2, 0);
    assert_int_equal(kept[PSPLAT_TEXTURE_EMISSIVE].image, 0);
    assert_int_equal(two->material.textures[PSPLAT_TEXTURE_NORMAL].image, 1);
    assert_near(two->material.textures[PSPLAT_TEXTURE_NORMAL].transform[0], 0, 0); /* identity */
    assert_int_equal(one->base_color.image->size, size);
    assert_memory_equal(one->base_color.image->bytes, png, size);
    assert_string_equal(one->base_color.image->mime_type, "image/png");
    assert_string_equal(one->base_color.image->name, "a b.png");
    const float *uv = mesh.corner_uvs[0];
    assert_near(uv[0] + uv[2] + uv[4], 2, 0);
    assert_near(uv[1] + uv[3] + uv[5], 2, 0);
    assert_near(uv[7] + uv[9] + uv[11], 1 + 0 + 0.75, 0);
    psplat_mesh_free(&mesh);
    free(png);
    drop("a b.png");
}

/* Each unreadable image leaves the factor as it is, and the image says why. */
static void test_unreadable(void **state) {
    (void)state;
    static const char *const names[] = {"missing.png", "../up.png", "a/../../up.png",
                                        "/etc/passwd", "C:\\x.png", "broken.png"};
    put("broken.png", "\x89PNG\r\n\x1a\nnothing", 15);
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        char library[256];
        snprintf(library, sizeof library, "newmtl one\nKd 0 1 0\nmap_Kd %s\n", names[i]);
        psplat_mesh mesh = read_with(library, SQUARE FACES);
        const psplat_source_material *one = &mesh.source_materials[mesh.groups[0]];
        assert_null(one->base_color.image->pixels);
        assert_non_null(one->base_color.image->problem);
        assert_null(strchr(one->base_color.image->problem, '\n'));
        assert_near(one->material.base_color[1], 1, 1e-6);
        psplat_mesh_free(&mesh);
    }
    drop("broken.png");
}

static void test_warnings(void **state) {
    (void)state;
    static const char library[] = "newmtl one\nmap_Kd missing.png\nd 0.5\n"
                                  "newmtl two words\nmap_Kd missing.png\nnorm missing.png\n";
    psplat_scene scene;
    psplat_error error;
    put("m.mtl", library, sizeof library - 1);
    write_bytes("m.obj", SQUARE FACES, sizeof(SQUARE FACES) - 1);
    if (psplat_scene_read(fixture_path, NULL, &scene, &error)) fail_msg("%s", error.text);
    assert_int_equal(scene.warning_count, 2);
    assert_non_null(strstr(scene.warnings[0], "missing.png"));
    assert_string_equal(scene.warnings[1], "1 materials are transparent and drawn opaque");
    psplat_scene_free(&scene);
    drop("m.obj");
    drop("m.mtl");
}

/* Libraries are searched only beside the OBJ, and textures only beside the library. */
static void test_directories(void **state) {
    (void)state;
    char path[512];
    static const uint8_t pixel[3] = {1, 2, 3};
    size_t size;
    snprintf(path, sizeof path, "%s/sub", fixture_directory);
    assert_int_equal(mkdir(path, 0700), 0);
    uint8_t *png = png_of(pixel, 1, 1, PNG_FORMAT_RGB, NULL, &size);
    put("sub/t.png", png, size);
    free(png);
    static const char library[] = "newmtl one\nmap_Kd t.png\n";
    put("sub/l.mtl", library, sizeof library - 1);
    psplat_mesh mesh =
        read_text("m.obj", "mtllib sub\\l.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl one\nf 1 2 3\n");
    assert_null(mesh.materials->problem);
    assert_non_null(mesh.source_materials[mesh.groups[0]].base_color.image->pixels);
    assert_null(mesh.corner_uvs[0]); /* the file gives no texture coordinates */
    psplat_mesh_free(&mesh);
    mesh = read_text("m.obj", "mtllib ../l.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl one\nf 1 2 3\n");
    assert_non_null(strstr(mesh.materials->problem, "../l.mtl"));
    psplat_mesh_free(&mesh);
    drop("sub/t.png");
    drop("sub/l.mtl");
    drop("sub");
}

/* Equal materials become one group; faces before the first usemtl have a group of their own. */
static void test_groups(void **state) {
    (void)state;
    psplat_mesh mesh = read_with("newmtl one\nKd 1 0 0\nnewmtl two words\nKd 1 0 0\n",
                                 SQUARE "f 1 2 3\n" FACES "f 2 3 4\n");
    assert_int_equal(mesh.triangle_count, 3); /* the first triangle occurs twice */
    assert_int_equal(mesh.groups[0], 2);
    assert_int_equal(mesh.groups[1], 0);
    assert_int_equal(mesh.groups[2], 0);
    assert_near(mesh.source_materials[2].material.base_color[0], 0.8, 1e-6);
    psplat_mesh_free(&mesh);
    mesh = read_text("m.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl one\nf 1 2 3\n");
    assert_null(mesh.materials); /* without a library there are no materials */
    assert_null(mesh.groups);
    psplat_mesh_free(&mesh);
}

/* A corner that a face names twice counts once, with the texture coordinates that came first. */
static void test_repeated_corners(void **state) {
    (void)state;
    psplat_mesh mesh = read_with("newmtl one\n", SQUARE "usemtl one\nf 1/4 2/2 1/1 2/3 3/3\n"
                                                        "f 4 4 4\nf 4/2 1/4 3/3\n");
    assert_int_equal(mesh.triangle_count, 2);
    assert_int_equal(mesh.dropped, 1);
    double sum = 0, expected = (0 + 0.75) + (1 + 1) + (1 + 0) + (1 + 1) + (0 + 0.75) + (1 + 0);
    for (int i = 0; i < 12; ++i) sum += (double)mesh.corner_uvs[0][i];
    assert_near(sum, expected, 0);
    psplat_mesh_free(&mesh);
}

static void test_many_materials(void **state) {
    (void)state;
    enum { MATERIALS = 4097 };
    static char text[MATERIALS * 16 + 100] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n";
    size_t length = strlen(text);
    for (int i = 0; i < MATERIALS; ++i)
        length += (size_t)snprintf(text + length, sizeof text - length, "usemtl %d\n", i);
    refuse_bytes("m.obj", text, length, PSPLAT_ERROR_RANGE, "more than 4096 materials");
}

int test_mtl_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_factors),        cmocka_unit_test(test_transparency),
        cmocka_unit_test(test_texture),        cmocka_unit_test(test_unreadable),
        cmocka_unit_test(test_warnings),       cmocka_unit_test(test_directories),
        cmocka_unit_test(test_groups),         cmocka_unit_test(test_repeated_corners),
        cmocka_unit_test(test_many_materials),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

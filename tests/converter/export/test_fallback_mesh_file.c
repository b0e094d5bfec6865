/* SPDX-License-Identifier: MIT
 *
 * test_fallback_mesh_file.c - tests of files with fallback meshes (spec 6.1), in all precisions:
 * the runtime reads the splats, and a reader without the extension reads the mesh in the same
 * place. And of files of meshes alone, which pages show as the source.
 */
#include "mesh_fixture.h"
#include "export/alternatives.h"
#include "export/fallback_mesh.h"
#include "export/glb_writer.h"
#include "export/meshopt_codec.h"
#include "import/read_scene.h"
#include "mesh/mesh.h"
#include "pipeline/convert_scene.h"
#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct product {
    psplat_scene scene;
    psplat_splats *splats;
    psplat_fallback_mesh *fallbacks;
} product;

static void check(psplat_result result, const psplat_error *error) {
    if (result) fail_msg("%s", error->text);
}

static product make(const char *model, const psplat_convert_desc *desc) {
    product p = {.splats = NULL};
    psplat_error error = {0};
    char path[1024];
    snprintf(path, sizeof path, "%s/samples/models/%s", PSPLAT_SOURCE_DIR, model);
    check(psplat_scene_read(path, "model", &p.scene, &error), &error);
    p.splats = calloc(p.scene.mesh_count + 1, sizeof *p.splats);
    assert_non_null(p.splats);
    check(psplat_scene_convert(&p.scene, desc, p.splats, NULL, &error), &error);
    check(psplat_scene_fallback_meshes(&p.scene, desc, &p.fallbacks, &error), &error);
    return p;
}

static void product_free(product *p) {
    psplat_scene_splats_free(&p->scene, p->splats);
    psplat_scene_fallback_meshes_free(&p->scene, p->fallbacks);
    psplat_scene_free(&p->scene);
    free(p->splats);
}

static size_t count_triangles(const product *p) {
    size_t count = 0;
    for (size_t i = 0; i < p->scene.mesh_count; ++i) count += p->fallbacks[i].index_count / 3;
    return count;
}

/* Returns the number of splats that the runtime reads. */
static size_t draw(const uint8_t *data, size_t size) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    size_t count = 0;
    check(psplat_asset_open_memory(data, size, NULL, &asset, &error), &error);
    for (size_t i = 0; i < psplat_asset_batch_count(asset); ++i)
        count += psplat_asset_batch(asset, i)->splat_count;
    psplat_asset_destroy(asset);
    return count;
}

/* Asserts that each vertex in the file is where the fallback mesh has it, to within half a step of
 * positions along each axis and rounding to float, and that the numbers of triangles agree. */
static void check_mesh(const product *p, const psplat_mesh *found) {
    const psplat_fallback_mesh *s = &p->fallbacks[0];
    double tolerance = sqrt(3) * (p->splats[0].precision.unit / 2 + 1e-6);
    assert_int_equal(found->triangle_count, s->index_count / 3);
    for (size_t i = 0; i < found->vertex_count; ++i) {
        double nearest = HUGE_VAL;
        for (size_t k = 0; k < s->vertex_count; ++k) {
            double square = 0;
            for (size_t axis = 0; axis < 3; ++axis) {
                double x = found->positions[3 * i + axis] + found->origin[axis] - s->origin[axis] -
                           (double)s->vertices[k].position[axis];
                square += x * x;
            }
            if (square < nearest) nearest = square;
        }
        if (!(sqrt(nearest) <= tolerance)) fail_msg("vertex %zu is %g off", i, sqrt(nearest));
    }
}

static void check_file(const product *p, const psplat_codec *codec) {
    const psplat_write_desc plain = {.codec = codec};
    const psplat_write_desc with = {.codec = codec, .fallbacks = p->fallbacks};
    psplat_error error = {0};
    uint8_t *data = NULL, *alone = NULL;
    size_t size = 0, alone_size = 0;
    check(psplat_scene_write(&p->scene, p->splats, &with, &data, &size, &error), &error);
    check(psplat_scene_write(&p->scene, p->splats, &plain, &alone, &alone_size, &error), &error);
    assert_true(size > alone_size);
    assert_int_equal(draw(data, size), draw(alone, alone_size));
    psplat_mesh mesh = read_bytes("fallback.glb", data, size);
    assert_true(mesh.corner_normals != NULL);
    if (p->scene.mesh_count == 1) check_mesh(p, &mesh);
    psplat_mesh_free(&mesh);
    free(data);
    free(alone);
}

static void check_model(const char *model, double precision) {
    const psplat_convert_desc desc = {.tolerance_percent = 5,
                                      .precision = precision,
                                      .effort = PSPLAT_EFFORT_NONE,
                                      .unverified = 1};
    product p = make(model, &desc);
    assert_true(count_triangles(&p) > 0);
    check_file(&p, NULL);
    check_file(&p, &psplat_meshopt_codec);
    product_free(&p);
}

static void test_cube(void **state) {
    (void)state;
    check_model("cube.off", 0);
    check_model("cube.off", -1);
}

static void test_torus(void **state) {
    (void)state;
    check_model("torus.off", 0);
    check_model("torus.off", -1);
}

/* The scene has several meshes, materials and colours, and places one mesh twice. */
static void test_scene(void **state) {
    (void)state;
    check_model("painted.glb", 0);
}

/* Steps are so small that 16-bit integers cannot hold the mesh. */
static void test_small_steps(void **state) {
    (void)state;
    check_model("cube.off", 0.002);
}

static size_t count_scene_triangles(const psplat_scene *scene) {
    size_t count = 0;
    for (size_t i = 0; i < scene->mesh_count; ++i) count += scene->meshes[i].mesh.triangle_count;
    return count;
}

/* Stores the size of a mesh's box. */
static void size_of(const psplat_mesh *mesh, double size[3]) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t i = 0; i < 3 * mesh->vertex_count; ++i) {
        low[i % 3] = fmin(low[i % 3], mesh->positions[i]);
        high[i % 3] = fmax(high[i % 3], mesh->positions[i]);
    }
    for (int k = 0; k < 3; ++k) size[k] = high[k] - low[k];
}

/* Expects the same meshes with all their triangles, images and animations. Nodes place a mesh's
 * middle, so that sizes are compared; test_page.mjs looks where the meshes are. */
static void check_whole_scene(const psplat_scene *scene, const psplat_scene *found) {
    assert_int_equal(found->mesh_count, scene->mesh_count);
    assert_int_equal(count_scene_triangles(found), count_scene_triangles(scene));
    assert_int_equal(found->animation_count, scene->animation_count);
    assert_int_equal(found->materials.image_count, scene->materials.image_count);
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        double a[3], b[3];
        size_of(&scene->meshes[i].mesh, a);
        size_of(&found->meshes[i].mesh, b);
        for (int k = 0; k < 3; ++k) assert_true(fabs(a[k] - b[k]) <= 1e-6 * a[k]); /* floats */
    }
}

static void test_whole_meshes(void **state) {
    static const char *const models[] = {"torus.off", "slab.ply", "bracket.gltf", "tiled.glb",
                                         "clockwork.glb"};
    static const psplat_convert_desc desc = {.tolerance_percent = 5};
    (void)state;
    for (size_t i = 0; i < sizeof models / sizeof *models; ++i) {
        psplat_scene scene, found;
        psplat_fallback_mesh *whole = NULL;
        psplat_asset *asset = NULL;
        psplat_error error = {0};
        uint8_t *data = NULL;
        size_t size = 0;
        char path[1024];
        snprintf(path, sizeof path, "%s/samples/models/%s", PSPLAT_SOURCE_DIR, models[i]);
        check(psplat_scene_read(path, "model", &scene, &error), &error);
        check(psplat_scene_whole_meshes(&scene, &desc, &whole, &error), &error);
        check(psplat_scene_write_meshes(&scene, whole, &psplat_meshopt_codec, &data, &size, &error),
              &error);
        assert_true(psplat_asset_open_memory(data, size, NULL, &asset, &error) != PSPLAT_OK);
        /* Normal textures, of tiled.glb, are glTF's own where there are no splats. */
        const char *json = (const char *)data + 20; /* ended by a 0 of the next chunk's length */
        assert_null(strstr(json, "PSPLAT"));
        assert_int_equal(strstr(json, "\"normalTexture\"") != NULL,
                         strcmp(models[i], "tiled.glb") == 0);
        write_bytes("whole.glb", data, size);
        check(psplat_scene_read(fixture_path, "model", &found, &error), &error);
        unlink(fixture_path);
        check_whole_scene(&scene, &found);
        psplat_scene_fallback_meshes_free(&scene, whole);
        psplat_scene_free(&scene);
        psplat_scene_free(&found);
        free(data);
    }
}

int test_fallback_mesh_file_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cube),         cmocka_unit_test(test_torus),
        cmocka_unit_test(test_scene),        cmocka_unit_test(test_small_steps),
        cmocka_unit_test(test_whole_meshes),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

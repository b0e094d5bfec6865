/* SPDX-License-Identifier: MIT
 *
 * test_convert_scene.c - tests of converting all meshes of a scene: each mesh's tolerance follows
 * its size in the scene, progress is that of one conversion, failures name the mesh, and results
 * repeat. The scene has four meshes of a tetrahedron or lines, whose placements are known.
 */
#include "gltf_fixture.h"
#include "export/glb_writer.h"
#include "import/read_scene.h"
#include "pipeline/convert_scene.h"
#include "pipeline/schedule.h"
#include "scene/instances.h"
#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MESH(name)                                                                                 \
    "{\"name\":\"" name "\",\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}"
#define THREE                                                                                      \
    "\"meshes\":[" MESH("a") "," MESH("b") ",{\"primitives\":[{\"mode\":0,\"attributes\":{"        \
                                           "\"POSITION\":0}}]}," MESH("c") "]"

/* Returns a scene with mesh a twice, once stretched by 4 and mirrored, mesh b at a tenth of its
 * size, mesh c far away, and a mesh of lines between them. */
static psplat_scene make_scene(void) {
    psplat_scene scene;
    psplat_error error = {0};
    gltf g = tetrahedron();
    const char *text = finish(
        &g, "\"scenes\":[{\"nodes\":[0,1,2,3,4]}],\"nodes\":[{\"mesh\":0},{\"mesh\":0,"
            "\"scale\":[-4,1,1],\"translation\":[-2,0,0]},{\"mesh\":1,\"scale\":[0.1,0.1,0.1]},"
            "{\"mesh\":2},{\"mesh\":3,\"translation\":[0,20,0]}]," THREE);
    write_bytes("s.gltf", text, strlen(text));
    psplat_result result = psplat_scene_read(fixture_path, NULL, &scene, &error);
    unlink(fixture_path);
    if (result) fail_msg("%s", error.text);
    return scene;
}

/* Where an animation enlarges a node, the meshes below it are converted as finely as they are then
 * seen, also where nothing is seen of them at rest. Lengths are those of the box at rest. */
static void test_animated_scales(void **state) {
    (void)state;
    static const float times[2] = {0, 1}, scales[6] = {1, 1, 1, -4, 1, 2};
    static const float spline[18] = {99, 99, 99, 3, 3, 3, 99, 99, 99,
                                     99, 99, 99, 1, 1, 1, 99, 99, 99};
    psplat_scene scene;
    psplat_error error = {0};
    gltf g = tetrahedron();
    add(&g, times, sizeof times, FLOAT, "SCALAR", 2, "");
    add(&g, scales, sizeof scales, FLOAT, "VEC3", 2, "");
    add(&g, spline, sizeof spline, FLOAT, "VEC3", 6, "");
    const char *text = finish(
        &g, "\"scenes\":[{\"nodes\":[0,2,3]}],\"nodes\":[{\"children\":[1],\"scale\":[2,2,2]},"
            "{\"mesh\":0},{\"mesh\":1,\"scale\":[0,0,0]},{\"mesh\":3}]," THREE
            ",\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":1,\"path\":"
            "\"scale\"}},{\"sampler\":1,\"target\":{\"node\":2,\"path\":\"scale\"}},"
            "{\"sampler\":0,\"target\":{\"node\":3,\"path\":\"translation\"}}],\"samplers\":["
            "{\"input\":2,\"output\":3},{\"input\":2,\"output\":4,\"interpolation\":"
            "\"CUBICSPLINE\"}]}]");
    write_bytes("s.gltf", text, strlen(text));
    psplat_result result = psplat_scene_read(fixture_path, NULL, &scene, &error);
    unlink(fixture_path);
    if (result) fail_msg("%s", error.text);
    double lengths[4], diagonal;
    assert_int_equal(psplat_scene_lengths(&scene, lengths, &diagonal, &error), 0);
    assert_near(diagonal, 2 * sqrt(3), 1e-6); /* the first at rest */
    assert_near(lengths[0], diagonal / 8, 1e-6);
    assert_near(lengths[1], diagonal / 3, 1e-6);
    assert_near(lengths[3], diagonal, 1e-6);
    for (size_t i = 0; i < scene.warning_count; ++i)
        assert_null(strstr(scene.warnings[i], "flatten"));
    psplat_scene_free(&scene);
}

static void test_tolerances(void **state) {
    (void)state;
    psplat_scene scene = make_scene();
    psplat_splats splats[4] = {{0}};
    psplat_scene_report report;
    psplat_error error = {0};
    const psplat_convert_desc desc = {.tolerance_percent = 1};
    if (psplat_scene_convert(&scene, &desc, splats, &report, &error)) fail_msg("%s", error.text);
    /* x from -6 to 1, y from 0 to 21, z from 0 to 1 */
    double diagonal = sqrt(7 * 7 + 21 * 21 + 1), own = sqrt(3);
    const double lengths[4] = {diagonal / 4, diagonal * 10, 0, diagonal};
    assert_int_equal(report.mesh_count, 4);
    assert_near(report.total.diagonal, diagonal, 1e-12);
    assert_true(report.total.tolerance_percent == 1);
    for (size_t i = 0; i < 4; ++i) assert_near(report.meshes[i].diagonal, lengths[i], 1e-9);
    /* The small mesh gets 20 % of its own box, the upper limit, and not 128 %. */
    assert_near(report.meshes[1].tolerance_percent / 100 * lengths[1], 0.2 * own, 1e-12);
    assert_near(report.meshes[3].tolerance_percent, 1, 1e-15);
    assert_int_equal(report.total.splats, splats[0].count + splats[1].count + splats[3].count);
    assert_int_equal(splats[2].count, 0);
    assert_int_equal(report.total.triangles, 12);
    assert_int_equal(psplat_report_broken(&report.total), PSPLAT_PROMISE_COUNT);
    assert_true(report.total.promises[PSPLAT_PROMISE_DISTANCE].limit == 1);
    psplat_scene_splats_free(&scene, splats);
    psplat_scene_report_free(&report);
    psplat_scene_free(&scene);
}

/* The runtime shows splats where the nodes place the meshes. */
static void test_opened(void **state) {
    (void)state;
    psplat_scene scene = make_scene();
    psplat_splats splats[4] = {{0}};
    uint8_t *data[2];
    size_t size[2];
    psplat_asset *asset;
    psplat_error error = {0};
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(psplat_scene_convert(&scene, NULL, splats, NULL, NULL), PSPLAT_OK);
        assert_int_equal(psplat_scene_write(&scene, splats, NULL, &data[i], &size[i], NULL),
                         PSPLAT_OK);
        psplat_scene_splats_free(&scene, splats);
    }
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(data[0], data[1], size[0]);
    if (psplat_asset_open_memory(data[0], size[0], NULL, &asset, &error))
        fail_msg("%s", error.text);
    /* The centres of the tetrahedron's splats lie within its box as each node places it. */
    static const double low[4][3] = {{0, 0, 0}, {-6, 0, 0}, {0, 0, 0}, {0, 20, 0}};
    static const double high[4][3] = {{1, 1, 1}, {-2, 1, 1}, {0.1, 0.1, 0.1}, {1, 21, 1}};
    size_t inside[4] = {0}, centers = 0;
    for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
        const psplat_batch *batch = psplat_asset_batch(asset, b);
        for (size_t s = 0; s < batch->splat_count; ++s, ++centers)
            for (size_t i = 0; i < 4; ++i) {
                int is_inside = 1;
                for (int row = 0; row < 3; ++row) {
                    double x = batch->model[12 + row], margin = 0.02 * (high[i][row] - low[i][row]);
                    for (int k = 0; k < 3; ++k)
                        x += batch->model[4 * k + row] * (double)batch->splats[s].center[k];
                    is_inside &= x >= low[i][row] - margin && x <= high[i][row] + margin;
                }
                inside[i] += (size_t)is_inside;
            }
    }
    assert_int_equal(centers, 16);    /* four faces, four times */
    assert_in_range(inside[0], 4, 8); /* the small one's may lie there too */
    for (size_t i = 1; i < 4; ++i) assert_int_equal(inside[i], 4);
    psplat_asset_destroy(asset);
    free(data[0]);
    free(data[1]);
    psplat_scene_free(&scene);
}

typedef struct progress {
    double done;
    int calls, stop_at;
} progress;

static int watch(void *user, const char *stage, double fraction) {
    progress *p = user;
    double done = psplat_schedule_done(stage, fraction);
    if (done < p->done || done > 1) fail_msg("%s %g after %g", stage, fraction, p->done);
    p->done = done;
    return ++p->calls == p->stop_at;
}

/* Progress only increases, from the first mesh to the last. An interrupted conversion leaves
 * nothing and names the mesh at which it stopped. */
static void test_progress(void **state) {
    (void)state;
    psplat_scene scene = make_scene();
    psplat_splats splats[4] = {{0}};
    progress p = {0};
    psplat_convert_desc desc = {.tolerance_percent = 5, .progress = watch, .user = &p};
    psplat_scene_report report;
    assert_int_equal(psplat_scene_convert(&scene, &desc, splats, &report, NULL), PSPLAT_OK);
    assert_true(p.done > 0.9);
    psplat_scene_splats_free(&scene, splats);
    psplat_scene_report_free(&report);
    int calls = p.calls;
    const int stops[] = {1, calls / 2, calls};
    const char *const names[] = {"mesh 0 'a'", "mesh 1 'b'", "mesh 3 'c'"};
    for (size_t i = 0; i < 3; ++i) {
        psplat_error error = {0};
        p = (progress){.stop_at = stops[i]};
        assert_int_equal(psplat_scene_convert(&scene, &desc, splats, &report, &error),
                         PSPLAT_ERROR_INTERRUPTED);
        if (strncmp(error.text, names[i], strlen(names[i])) != 0) fail_msg("%s", error.text);
        for (size_t k = 0; k < 4; ++k) assert_null(splats[k].splats);
        assert_null(report.meshes);
    }
    psplat_scene_free(&scene);
}

static void test_arguments(void **state) {
    (void)state;
    psplat_scene scene = {0};
    psplat_splats splats;
    uint8_t *data;
    size_t size;
    psplat_scene_report report;
    assert_int_equal(psplat_scene_convert(NULL, NULL, &splats, NULL, NULL), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_scene_convert(&scene, NULL, NULL, NULL, NULL), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_scene_convert(&scene, NULL, &splats, &report, NULL), PSPLAT_OK);
    assert_int_equal(psplat_scene_write(&scene, &splats, NULL, &data, &size, NULL),
                     PSPLAT_ERROR_NO_SPLATS);
    psplat_scene_report_free(&report);
}

/* Only textures of another set than the one that is kept are baked, and warned of. */
static void test_warns_of_baked_textures(void **state) {
    (void)state;
    float uvs[2][6] = {{0, 0, 1, 0, 0, 1}, {0, 0, 1, 0, 0, 1}};
    uint32_t triangle[3] = {0, 1, 2};
    uint8_t pixel[4] = {0};
    psplat_image image = {.pixels = pixel, .width = 1, .height = 1};
    psplat_source_material material = {.base_color = {.image = &image},
                                       .normal = {.image = &image, .texcoord = 1}};
    psplat_source_materials materials = {&material, 1, &image, 1, NULL};
    psplat_scene_mesh mesh = {.mesh = {.triangles = triangle,
                                       .triangle_count = 1,
                                       .corner_uvs = {uvs[0], uvs[1]},
                                       .source_materials = &material,
                                       .source_material_count = 1}};
    psplat_scene scene = {.meshes = &mesh, .mesh_count = 1};
    psplat_source_materials_describe_textures(&materials);
    psplat_scene_warn_of_textures(&scene);
    assert_int_equal(scene.warning_count, 1);
    assert_non_null(strstr(scene.warnings[0], "1 textures use a second set"));
    material.normal.texcoord = 0;
    psplat_scene_warn_of_textures(&scene);
    assert_int_equal(scene.warning_count, 1);
    scene.meshes = NULL;
    scene.mesh_count = 0;
    psplat_scene_free(&scene);
}

int test_convert_scene_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_warns_of_baked_textures),
        cmocka_unit_test(test_animated_scales),
        cmocka_unit_test(test_tolerances),
        cmocka_unit_test(test_opened),
        cmocka_unit_test(test_progress),
        cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

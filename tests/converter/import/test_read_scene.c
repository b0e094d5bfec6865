/* SPDX-License-Identifier: MIT
 *
 * test_read_scene.c - tests of reading whole files as scenes: meshes, their instances and
 * placements, defective graphs, and warnings for what is dropped. Meshes are tetrahedra, whose
 * sizes are known.
 */
#include "gltf_fixture.h"
#include "import/read_scene.h"
#include "mesh/mesh.h"
#include "scene/instances.h"
#include "scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static psplat_scene scene_of(const char *text) {
    psplat_scene scene;
    psplat_error error = {0};
    write_bytes("s.gltf", text, strlen(text));
    psplat_result result = psplat_scene_read(fixture_path, NULL, &scene, &error);
    unlink(fixture_path);
    if (result) fail_msg("%s", error.text);
    return scene;
}

static void refuse_scene(const char *text, psplat_result code, const char *cause) {
    psplat_scene scene;
    psplat_error error = {0};
    write_bytes("s.gltf", text, strlen(text));
    psplat_result result = psplat_scene_read(fixture_path, NULL, &scene, &error);
    unlink(fixture_path);
    if (result != code || strncmp(error.text, fixture_path, strlen(fixture_path)) ||
        !strstr(error.text, cause))
        fail_msg("result %d instead of %d, and '%s' in: %s", (int)result, (int)code, cause,
                 error.text);
    assert_null(scene.nodes);
    assert_null(scene.meshes);
}

static void test_warnings(void **state) {
    (void)state;
    psplat_scene scene = {0};
    for (int i = 0; i < 6; ++i) psplat_scene_warn(&scene, "%d animations are dropped", i / 2);
    assert_int_equal(scene.warning_count, 3);
    assert_string_equal(scene.warnings[2], "2 animations are dropped");
    char longest[1000];
    memset(longest, 'x', sizeof longest);
    longest[sizeof longest - 1] = 0;
    psplat_scene_warn(&scene, "%s", longest);
    assert_in_range(strlen(scene.warnings[3]), 100, 500); /* cut off without an overrun */
    psplat_scene_free(&scene);
    assert_null(scene.warnings);
    psplat_scene_free(&scene);
    psplat_scene_free(NULL);
}

#define TWO_MESHES                                                                                 \
    "\"meshes\":[{\"name\":\"a\",\"extras\":[7],\"primitives\":[{\"attributes\":{\"POSITION\":0}," \
    "\"indices\":1,\"material\":1}]},{\"name\":\"b\",\"primitives\":[{\"attributes\":{"            \
    "\"POSITION\":0},\"indices\":1},{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0" \
    "}]}],\"materials\":[{\"name\":\"red\",\"extras\":{\"a\":1},\"pbrMetallicRoughness\":{"        \
    "\"baseColorFactor\":[1,0,0,1]}},{\"doubleSided\":true}]"

/* Each mesh has its own coordinates; its groups are indices of the file's materials. */
static void test_meshes(void **state) {
    (void)state;
    gltf g = tetrahedron();
    psplat_scene scene =
        scene_of(finish(&g, SCENE "\"nodes\":[{\"mesh\":1,\"scale\":[2,2,2],\"children\":[1]},"
                                  "{\"mesh\":0,\"translation\":[1,0,0]}]," TWO_MESHES));
    assert_int_equal(scene.mesh_count, 2);
    assert_string_equal(scene.meshes[0].name, "a");
    assert_string_equal(scene.meshes[0].extras, "[7]");
    assert_int_equal(scene.materials.source_material_count, 3);
    assert_string_equal(scene.materials.source_materials[0].name, "red");
    assert_string_equal(scene.materials.source_materials[0].extras, "{\"a\":1}");
    const psplat_mesh *a = &scene.meshes[0].mesh, *b = &scene.meshes[1].mesh;
    assert_near(signed_volume(a), 1, 1e-12);
    assert_ptr_equal(a->source_materials, scene.materials.source_materials);
    assert_int_equal(a->groups[0], 1);
    assert_int_equal(b->groups[0], 2); /* the default material */
    assert_true(a->origin[0] == 0.5 && b->origin[0] == 0.5);
    assert_int_equal(b->triangle_count, 4); /* the last four triangles repeat the first four */
    assert_int_equal(scene.warning_count, 0);
    psplat_scene_free(&scene);
}

/* ---- instances ------------------------------------------------------------------------------- */

static void test_instances(void **state) {
    (void)state;
    gltf g = tetrahedron();
    /* Two nodes, one mirrored and one sheared, lie below a turned and stretched node. The second
     * scene has one more node, and the last node is in no scene. */
    psplat_scene scene = scene_of(finish(
        &g, "\"scenes\":[{\"nodes\":[0]},{\"nodes\":[0,3]}],\"nodes\":[{\"children\":[1,2],"
            "\"scale\":[3,1,1],\"rotation\":[0,0,0.7071067811865476,0.7071067811865476]},"
            "{\"mesh\":0,\"scale\":[-1,1,1]},"
            "{\"mesh\":1,\"matrix\":[1,0,0,0,1,1,0,0,0,0,1,0,5,0,0,1]},"
            "{\"mesh\":0,\"translation\":[100,0,0]},{\"mesh\":1,\"scale\":[9,9,9]}]," TWO_MESHES));
    psplat_instance *instances;
    size_t count;
    assert_int_equal(psplat_scene_shown(&scene), 0);
    assert_int_equal(psplat_scene_instances(&scene, 0, &instances, &count, NULL), PSPLAT_OK);
    assert_int_equal(count, 2);
    assert_int_equal(instances[0].node, 1);
    assert_near(instances[0].stretch, 3, 1e-12);
    /* diag(3, 1, 1) times the shear [1 1; 0 1] is [3 3; 0 1], whose greatest singular value is the
     * greater root of s^4 - 19 s^2 + 9. */
    assert_near(instances[1].stretch, sqrt((19 + sqrt(325.0)) / 2), 1e-12);
    /* The first instance spans x -3 ... 0 and the second one 15 ... 18, both turned by 90 degrees;
     * y and z span 0 ... 1. */
    assert_near(psplat_scene_diagonal(&scene, instances, count), sqrt(21 * 21 + 1 + 1), 1e-12);
    free(instances);
    assert_int_equal(psplat_scene_instances(&scene, 1, &instances, &count, NULL), PSPLAT_OK);
    assert_int_equal(count, 3);
    free(instances);
    assert_int_equal(psplat_scene_instances(&scene, PSPLAT_NO_INDEX, &instances, &count, NULL),
                     PSPLAT_OK);
    assert_int_equal(count, 4);
    free(instances);
    psplat_scene_free(&scene);
}

/* The matrix of an instance is T R S; the matrix of this rotation has simple numbers. */
static void test_transform(void **state) {
    (void)state;
    static const double expected[16] = {0,    1.2,   1.6,  0, -0.8, 0.48, -0.36, 0,
                                        -1.8, -1.92, 1.44, 0, 5,    6,    7,     1};
    gltf g = tetrahedron();
    psplat_scene scene = scene_of(
        finish(&g, "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"translation\":[5,6,7],"
                   "\"rotation\":[0.1,-0.5,0.5,0.7],\"scale\":[2,1,3]}]," TWO_MESHES));
    psplat_instance *instances;
    size_t count;
    assert_int_equal(psplat_scene_instances(&scene, 0, &instances, &count, NULL), PSPLAT_OK);
    assert_int_equal(count, 1);
    for (int i = 0; i < 16; ++i) assert_near(instances[0].matrix[i], expected[i], 1e-15);
    free(instances);
    psplat_scene_free(&scene);
}

/* A node of scale 0 draws nothing: it has no instance, and one warning is given. Sizes that are
 * merely tiny are drawn. */
static void test_flattened(void **state) {
    (void)state;
    gltf g = tetrahedron();
    psplat_scene scene = scene_of(
        finish(&g, "\"scenes\":[{\"nodes\":[0,1,2,3]}],\"nodes\":[{\"mesh\":0,\"scale\":[0,0,0]},"
                   "{\"mesh\":0,\"scale\":[1,0,1],\"rotation\":[0.6,0,0,0.8]},"
                   "{\"mesh\":0,\"scale\":[1e-30,1e-30,1e-30]},"
                   "{\"mesh\":0,\"scale\":[1e-5,1,1]}]," TWO_MESHES));
    psplat_instance *instances;
    size_t count;
    assert_int_equal(psplat_scene_instances(&scene, 0, &instances, &count, NULL), PSPLAT_OK);
    assert_int_equal(count, 2);
    assert_near(instances[0].stretch, 1e-30, 1e-42);
    assert_int_equal(scene.warning_count, 1);
    assert_non_null(strstr(scene.warnings[0], "2 nodes flatten"));
    free(instances);
    psplat_scene_free(&scene);
}

/* ---- defective graphs ------------------------------------------------------------------------ */

/* Returns a chain of nodes with the mesh at its end. */
static const char *chain(gltf *g, int depth) {
    static char nodes[8192];
    nodes[0] = 0;
    append(nodes, sizeof nodes, SCENE "\"nodes\":[");
    for (int i = 1; i < depth; ++i)
        append(nodes, sizeof nodes, "{\"scale\":[2,1,1],\"children\":[%d]},", i);
    append(nodes, sizeof nodes, "{\"mesh\":0}]," TWO_MESHES);
    return finish(g, nodes);
}

static void test_depth(void **state) {
    (void)state;
    gltf g = tetrahedron();
    psplat_scene scene = scene_of(chain(&g, 64));
    psplat_instance *instances;
    size_t count;
    assert_int_equal(psplat_scene_instances(&scene, 0, &instances, &count, NULL), PSPLAT_OK);
    assert_int_equal(count, 1);
    assert_near(instances[0].stretch, ldexp(1, 63), 1);
    free(instances);
    psplat_scene_free(&scene);
    refuse_scene(chain(&g, 65), PSPLAT_ERROR_FORMAT, "node 64: nested deeper than 64");
}

static void test_refused(void **state) {
    (void)state;
    static const struct {
        const char *graph;
        psplat_result code;
        const char *cause;
    } cases[] = {
        {"\"nodes\":[{\"mesh\":0,\"children\":[0]}]", PSPLAT_ERROR_FORMAT, "node 0: nested"},
        {"\"nodes\":[{\"mesh\":0},{\"children\":[2]},{\"children\":[1]}]", PSPLAT_ERROR_FORMAT,
         "node 1: nested"},
        {"\"nodes\":[{\"children\":[2]},{\"children\":[2]},{\"mesh\":0}]", PSPLAT_ERROR_FORMAT,
         "node 2: is a child twice"},
        {"\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0,0]}]", PSPLAT_ERROR_FORMAT,
         "scene 0: node 0 is in it twice"},
        {"\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[1]}]", PSPLAT_ERROR_RANGE,
         "scene 0: node 1 does not exist"},
        {"\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[-1]}]", PSPLAT_ERROR_RANGE,
         "scene 0: a node is negative"},
        {"\"nodes\":[{\"mesh\":2}]", PSPLAT_ERROR_RANGE, "node 0: mesh 2 does not exist"},
        {"\"nodes\":[{\"camera\":0}]", PSPLAT_ERROR_RANGE, "node 0: camera 0 does not exist"},
        {"\"nodes\":[{\"children\":[1]}]", PSPLAT_ERROR_RANGE, "node 0: child 1 does not exist"},
        {"\"nodes\":[{\"mesh\":0,\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}]",
         PSPLAT_ERROR_RANGE, "node 0: light 0 does not exist"},
        {"\"nodes\":[{\"mesh\":0,\"extensions\":{\"KHR_lights_punctual\":{\"light\":\"x\"}}}]",
         PSPLAT_ERROR_RANGE, "node 0: light -2"},
        {"\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"scene\":1", PSPLAT_ERROR_RANGE,
         "scene 1 does not exist"},
        {"\"nodes\":[{\"mesh\":0,\"scale\":[1e200,1,1],\"children\":[1]},"
         "{\"mesh\":0,\"scale\":[1e200,1,1]}]",
         PSPLAT_ERROR_RANGE, "node 1: its transform is not finite"},
        {"\"nodes\":[{\"mesh\":0}],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{"
         "\"type\":\"neon\"}]}}",
         PSPLAT_ERROR_FORMAT, "light 0: type is 'neon'"},
        {"\"nodes\":[{\"mesh\":0}],\"extensionsRequired\":[\"EXT_unknown\"]",
         PSPLAT_ERROR_UNSUPPORTED, "EXT_unknown"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char rest[4096];
        gltf g = tetrahedron();
        snprintf(rest, sizeof rest, "%s," TWO_MESHES, cases[i].graph);
        refuse_scene(finish(&g, rest), cases[i].code, cases[i].cause);
    }
}

/* ---- roots that have a parent ---------------------------------------------------------------- */

/* Asserts that the scene has the roots, and the node the children. */
static void check_roots(const psplat_scene *scene, size_t view, size_t count, uint32_t first) {
    assert_int_equal(scene->scenes[view].root_count, count);
    assert_int_equal(scene->scenes[view].roots[0], first);
}

/* A root below another root is shown once, where its parents put it. */
static void test_roots_below_roots(void **state) {
    (void)state;
    gltf g = tetrahedron();
    const char *text =
        finish(&g, "\"scenes\":[{\"nodes\":[2,0,1]}],\"nodes\":[{\"children\":[1],"
                   "\"translation\":[8,0,0]},{\"children\":[2]},{\"mesh\":0}]," INDEXED);
    psplat_scene scene = scene_of(text);
    check_roots(&scene, 0, 1, 0);
    assert_int_equal(scene.warning_count, 1);
    assert_non_null(strstr(scene.warnings[0], "2 roots of scene 0 are children"));
    psplat_instance *instances;
    size_t count;
    assert_int_equal(psplat_scene_instances(&scene, 0, &instances, &count, NULL), PSPLAT_OK);
    assert_int_equal(count, 1);
    assert_near(instances[0].matrix[12], 8, 0);
    free(instances);
    psplat_scene_free(&scene);
    psplat_mesh mesh = read_text("t.gltf", text);
    assert_int_equal(mesh.triangle_count, 4);
    assert_near(mesh.origin[0], 8.5, 1e-12);
    psplat_mesh_free(&mesh);
}

/* A root whose parent the scene does not show leaves the parent, in all scenes. */
static void test_roots_of_hidden_parents(void **state) {
    (void)state;
    gltf g = tetrahedron();
    const char *text =
        finish(&g, "\"scenes\":[{\"nodes\":[1]},{\"nodes\":[0,1]}],\"nodes\":[{\"children\":[1,2],"
                   "\"translation\":[8,0,0]},{\"mesh\":0},{}]," INDEXED);
    psplat_scene scene = scene_of(text);
    check_roots(&scene, 0, 1, 1);
    check_roots(&scene, 1, 2, 0);
    assert_int_equal(scene.nodes[0].child_count, 1);
    assert_int_equal(scene.nodes[0].children[0], 2);
    assert_int_equal(scene.warning_count, 1);
    assert_non_null(strstr(scene.warnings[0], "scene 0 has node 1 as a root, a child of node 0"));
    psplat_scene_free(&scene);
    psplat_mesh mesh = read_text("t.gltf", text);
    assert_near(mesh.origin[0], 0.5, 1e-12);
    psplat_mesh_free(&mesh);
}

/* ---- dropped content ------------------------------------------------------------------------- */

static void test_dropped(void **state) {
    (void)state;
    static const float deltas[4][3] = {{0, 0, 0}, {2, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    gltf g = tetrahedron();
    add(&g, deltas, sizeof deltas, FLOAT, "VEC3", 4, "");
    psplat_scene scene = scene_of(finish(
        &g,
        "\"extensionsUsed\":[\"EXT_unknown\",\"KHR_mesh_quantization\"],"
        "\"nodes\":[{\"mesh\":0,\"skin\":0},{\"mesh\":1},{\"mesh\":2}],"
        "\"skins\":[{\"joints\":[1]}],\"animations\":[{\"channels\":[],\"samplers\":[]}],"
        "\"meshes\":[{\"name\":\"lines\",\"primitives\":[{\"mode\":1,\"attributes\":{"
        "\"POSITION\":0}}]},{\"weights\":[0.5],\"primitives\":[{\"attributes\":{\"POSITION\":0},"
        "\"indices\":1,\"extras\":1,\"targets\":[{\"POSITION\":2}]},"
        "{\"mode\":0,\"attributes\":{\"POSITION\":0}}]}," /* followed by a mesh that is a point */
        "{\"primitives\":[{\"attributes\":{\"POSITION\":0}},{\"attributes\":{}}]}]"));
    static const char *const expected[] = {
        "1 animations are dropped",
        "1 skins are dropped",
        "2 primitives of points or lines",
        "morph targets are dropped",
        "extras of 1 primitives",
        "extension EXT_unknown is not converted",
        "mesh 0 'lines' has no triangle with an area",
    };
    assert_int_equal(scene.warning_count, 7);
    for (size_t i = 0; i < 7; ++i)
        if (!strstr(scene.warnings[i], expected[i]))
            fail_msg("'%s' instead of '%s'", scene.warnings[i], expected[i]);
    /* Half of the target is added: the corner at x = 1 is at 2. */
    assert_near(signed_volume(&scene.meshes[1].mesh), 2, 1e-12);
    assert_int_equal(scene.meshes[0].mesh.triangle_count, 0);
    assert_int_equal(scene.node_count, 3);
    assert_int_equal(scene.nodes[0].mesh, 0);
    psplat_scene_free(&scene);
    g = tetrahedron();
    refuse_scene(finish(&g, "\"scenes\":[{}],\"nodes\":[{\"mesh\":0}]," INDEXED),
                 PSPLAT_ERROR_NO_SPLATS, "the scene that it shows has no triangles");
    refuse_scene(finish(&g, NODE "\"meshes\":[{\"primitives\":[{\"mode\":1,\"attributes\":{"
                                 "\"POSITION\":0}}]}]"),
                 PSPLAT_ERROR_NO_SPLATS, "no triangle has an area");
}

/* Texture coordinates that are no numbers become 0, with a warning. */
static void test_texcoords_that_are_no_numbers(void **state) {
    (void)state;
    static const float uvs[4][2] = {{0, 0}, {NAN, 0.5f}, {0.5f, INFINITY}, {1, 1}};
    gltf g = tetrahedron();
    add(&g, uvs, sizeof uvs, FLOAT, "VEC2", 4, "");
    psplat_scene scene =
        scene_of(finish(&g, "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
                            "\"TEXCOORD_0\":2},\"indices\":1}]}]"));
    const psplat_mesh *mesh = &scene.meshes[0].mesh;
    assert_int_equal(scene.warning_count, 1);
    assert_string_equal(scene.warnings[0], "6 texture coordinates are no numbers: they count as 0");
    for (size_t i = 0; i < 6 * mesh->triangle_count; ++i)
        assert_true(mesh->corner_uvs[0][i] == 0 || mesh->corner_uvs[0][i] == 1);
    psplat_scene_free(&scene);
}

int test_read_scene_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_warnings),
        cmocka_unit_test(test_meshes),
        cmocka_unit_test(test_instances),
        cmocka_unit_test(test_transform),
        cmocka_unit_test(test_flattened),
        cmocka_unit_test(test_depth),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_dropped),
        cmocka_unit_test(test_roots_below_roots),
        cmocka_unit_test(test_roots_of_hidden_parents),
        cmocka_unit_test(test_texcoords_that_are_no_numbers),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

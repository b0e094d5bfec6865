/* SPDX-License-Identifier: MIT
 *
 * test_graph_json.c - tests that scenes, nodes, cameras, lights, names and extras are written as
 * they were read. Expected values are the JSON texts.
 */
#include "gltf_fixture.h"
#include "base/json_writer.h"
#include "export/graph_json.h"
#include "import/read_scene.h"
#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>
#include <stdio.h>

static psplat_scene scene_of(const char *name, const char *text) {
    psplat_scene scene;
    psplat_error error = {0};
    write_bytes(name, text, strlen(text));
    psplat_result result = psplat_scene_read(fixture_path, "made", &scene, &error);
    unlink(fixture_path);
    if (result) fail_msg("%s", error.text);
    return scene;
}

/* Asserts the JSON of the graph with the same placement for each mesh; meshes keep their indices.
 */
static void check_graph(const psplat_scene *scene, psplat_dequantize_transform placement,
                        const char *expected) {
    psplat_dequantize_transform placements[4] = {placement, placement, placement, placement};
    const uint32_t meshes[4] = {0, 1, 2, 3};
    psplat_writer json = {.compact = 1};
    psplat_writer_open(&json, NULL, '{');
    psplat_writer_open(&json, "asset", '{');
    psplat_graph_write_asset(&json, scene);
    psplat_writer_close(&json, '}');
    psplat_graph_write(&json, scene, placements, meshes);
    psplat_writer_open(&json, "extensions", '{');
    psplat_graph_write_lights(&json, scene);
    psplat_writer_close(&json, '}');
    psplat_writer_close(&json, '}');
    assert_true(psplat_writer_finish(&json));
    char *text = calloc(json.size + 1, 1);
    assert_non_null(text);
    memcpy(text, json.text, json.size);
    assert_string_equal(text, expected);
    free(text);
    free(json.text);
}

#define MESHES "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]"

/* Nested and mirrored nodes, one mesh used twice, two scenes, both kinds of cameras, all lights,
 * names, and extras of every JSON type. The members are in the order in which they are written. */
#define NODES                                                                                      \
    "\"scene\":1,\"scenes\":[{\"name\":\"first\",\"nodes\":[0]},"                                  \
    "{\"nodes\":[0,4],\"extras\":[1,[2,{\"a\":null}],true,\"x\"]}],"                               \
    "\"nodes\":[{\"name\":\"root \\u00e4\\n\\\"\",\"translation\":[0.1,2,-3e-7],"                  \
    "\"rotation\":[0,0.6,0,0.8],\"scale\":[-1,2,1e+20],\"camera\":1,\"children\":[1,2],"           \
    "\"extras\":{\"deep\":{\"er\":[{}]},\"unicode\":\"\xe2\x82\xac\"}},"                           \
    "{\"matrix\":[1,0.5,0,0,0,1,0,0,0,0,-1,0,7,8,9,1],\"camera\":0,"                               \
    "\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}},\"extras\":3.25},"                     \
    "{\"children\":[3],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"                   \
    "{\"name\":\"leaf\",\"mesh\":0},{\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}}],"

#define CAMERAS                                                                                    \
    "\"cameras\":[{\"name\":\"wide\",\"type\":\"perspective\",\"perspective\":{"                   \
    "\"aspectRatio\":1.5,\"yfov\":0.7,\"znear\":0.01,\"zfar\":100},\"extras\":\"lens\"},"          \
    "{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":2,\"ymag\":3,\"znear\":0,\"zfar\":9}}," \
    "{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.7,\"znear\":0.01}}]"

#define LIGHTS                                                                                     \
    "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"name\":\"sun\","                      \
    "\"type\":\"directional\",\"color\":[1,0.5,0.25],\"intensity\":3,\"extras\":{\"k\":[]}},"      \
    "{\"type\":\"point\",\"range\":12.5},{\"type\":\"spot\",\"spot\":{"                            \
    "\"innerConeAngle\":0.1,\"outerConeAngle\":0.2}},{\"type\":\"spot\",\"spot\":{}}]}}"

#define ASSET "{\"asset\":{\"copyright\":\"(c) us\",\"extras\":[true]},"

static const psplat_dequantize_transform nowhere = {{0, 0, 0}, 1};

/* Returns the document around a tetrahedron; `rest` follows the asset. */
static const char *document(const char *rest) {
    static char text[16384];
    gltf g = tetrahedron();
    const char *made = finish(&g, rest), *after = strchr(made, '}') + 2;
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\",\"copyright\":\"(c) us\",\"extras\":[true]},%s",
             after);
    return text;
}

static void test_as_it_was(void **state) {
    (void)state;
    psplat_scene scene = scene_of(
        "g.gltf", document(NODES MESHES "," CAMERAS ",\"extras\":{\"z\":0},"
                                        "\"extensionsUsed\":[\"KHR_lights_punctual\"]," LIGHTS));
    /* tinygltf sorts the keys of extras; an escaped letter is written as UTF-8. */
    const char *expected =
        ASSET "\"scene\":1,\"scenes\":[{\"name\":\"first\",\"nodes\":[0]},"
              "{\"nodes\":[0,4],\"extras\":[1,[2,{\"a\":null}],true,\"x\"]}],"
              "\"nodes\":[{\"name\":\"root \xc3\xa4\\u000a\\u0022\",\"translation\":[0.1,2,-3e-07],"
              "\"rotation\":[0,0.6,0,0.8],\"scale\":[-1,2,1e+20],\"camera\":1,\"children\":[1,2],"
              "\"extras\":{\"deep\":{\"er\":[{}]},\"unicode\":\"\xe2\x82\xac\"}},"
              "{\"matrix\":[1,0.5,0,0,0,1,0,0,0,0,-1,0,7,8,9,1],\"camera\":0,"
              "\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}},\"extras\":3.25},"
              "{\"children\":[3],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
              "{\"name\":\"leaf\",\"mesh\":0},{\"extensions\":{\"KHR_lights_punctual\":{\"light\":"
              "1}}}]," CAMERAS ",\"extras\":{\"z\":0}," LIGHTS "}";
    check_graph(&scene, nowhere, expected);
    assert_int_equal(scene.warning_count, 0);
    psplat_scene_free(&scene);
}

/* A placement becomes a child node, unless it can be merged into the node without changing anything
 * else. */
static void test_placements(void **state) {
    (void)state;
    static const psplat_dequantize_transform placement = {{10, 20, 30}, 0.5};
    psplat_scene scene = scene_of(
        "p.gltf", document("\"nodes\":[{\"mesh\":0,\"children\":[2]},{\"mesh\":0,\"name\":\"n\","
                           "\"scale\":[-1,1,2]},{\"mesh\":0,\"translation\":[1,2,3],"
                           "\"rotation\":[0,0,1,0],\"scale\":[2,-4,8]},"
                           "{\"mesh\":0,\"matrix\":[2,0,0,0,1,4,0,0,0,0,8,0,1,2,3,1]},"
                           "{\"mesh\":0,\"extras\":0},{\"children\":[3]}],"
                           "\"scenes\":[{\"nodes\":[0,1,4,5]}]," MESHES));
    check_graph(
        &scene, placement,
        ASSET
        "\"scenes\":[{\"nodes\":[0,1,4,5]}],\"nodes\":[{\"children\":[2,6]},{\"name\":\"n\","
        "\"scale\":[-1,1,2],\"children\":[7]},"
        /* x: 1 - 2 x 10, y: 2 + 4 x 20, z: 3 + 8 x 30 */
        "{\"translation\":[-19,82,243],\"rotation\":[0,0,1,0],\"scale\":[1,-2,4],\"mesh\":0},"
        "{\"matrix\":[1,0,0,0,0.5,2,0,0,0,0,4,0,41,82,243,1],\"mesh\":0},"
        "{\"children\":[8],\"extras\":0},{\"children\":[3]},"
        "{\"translation\":[10,20,30],\"scale\":[0.5,0.5,0.5],\"mesh\":0},"
        "{\"translation\":[10,20,30],\"scale\":[0.5,0.5,0.5],\"mesh\":0},"
        "{\"translation\":[10,20,30],\"scale\":[0.5,0.5,0.5],\"mesh\":0}],\"extensions\":{}}");
    check_graph(&scene, nowhere,
                ASSET "\"scenes\":[{\"nodes\":[0,1,4,5]}],\"nodes\":[{\"mesh\":0,\"children\":[2]},"
                      "{\"name\":\"n\",\"scale\":[-1,1,2],\"mesh\":0},{\"translation\":[1,2,3],"
                      "\"rotation\":[0,0,1,0],\"scale\":[2,-4,8],\"mesh\":0},"
                      "{\"matrix\":[2,0,0,0,1,4,0,0,0,0,8,0,1,2,3,1],\"mesh\":0},"
                      "{\"mesh\":0,\"extras\":0},{\"children\":[3]}],\"extensions\":{}}");
    psplat_scene_free(&scene);
}

/* A file without a graph gets one node for each mesh, at the place of its splats. */
static void test_made(void **state) {
    (void)state;
    static const psplat_dequantize_transform placement = {{1, 2, 3}, 1};
    psplat_scene scene = scene_of("t.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    check_graph(
        &scene, placement,
        "{\"asset\":{},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"name\":\"made\","
        "\"translation\":[1,2,3],\"mesh\":0}],\"extensions\":{}}");
    psplat_scene_free(&scene);
    scene = scene_of("m.gltf", document(MESHES));
    check_graph(&scene, nowhere,
                ASSET "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
                      "\"extensions\":{}}");
    psplat_scene_free(&scene);
}

int test_graph_json_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_as_it_was),
        cmocka_unit_test(test_placements),
        cmocka_unit_test(test_made),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

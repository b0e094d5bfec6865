/* SPDX-License-Identifier: MIT
 *
 * test_tileset_file.c - tests what is read of a tileset.json, and that bad ones are refused with
 * their place and cause.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <stdlib.h>
#include <cmocka.h>

#include "tiles_fixture.h"

#include "core/matrix.h"
#include "core/uri.h"

static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

/* ---- reading ------------------------------------------------------------------------------- */

static psplat_result read_at(const char *text, size_t size, const char *path,
                             const psplat_tile_file *referrer, psplat_tileset *tileset,
                             psplat_error *error) {
    psplat_tileset_place place = {.path = path,
                                  .referrer = referrer,
                                  .error = HUGE_VAL,
                                  .allocator = psplat_allocator_default(NULL)};
    memcpy(place.transform, identity, sizeof identity);
    return psplat_tileset_read(text, size, &place, tileset, error);
}

static psplat_tileset read_good(const char *text, const char *path) {
    psplat_tileset tileset;
    psplat_error error = {0};
    psplat_result result = read_at(text, strlen(text), path, NULL, &tileset, &error);
    if (result) print_error("%s at byte %zu\n", error.text, error.offset);
    assert_int_equal(result, PSPLAT_OK);
    return tileset;
}

static void release(psplat_tileset *tileset) {
    psplat_arena_release(&tileset->kept);
    psplat_arena_release(&tileset->scratch);
}

#define HEAD "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":9,\"root\":"
#define BOX "\"boundingVolume\":{\"box\":[1,2,3, 4,0,0, 0,5,0, 0,0,6]}"
#define TILE "{\"refine\":\"REPLACE\",\"geometricError\":8," BOX ",\"content\":{\"uri\":\"a.glb\"}"
#define CHILD "{\"geometricError\":4," BOX ",\"content\":{\"uri\":\"b.glb\"}}"

/* A point (x, y, z) of the tileset is (x, z, -y) here. */
static void test_volumes(void **state) {
    (void)state;
    psplat_tileset t = read_good(HEAD TILE "}}", "tileset.json");
    assert_int_equal(t.node_count, 1);
    const psplat_tile_volume *v = &t.nodes[0].volume;
    const double center[3] = {1, 3, -2}, half[3] = {4, 6, 5};
    for (int i = 0; i < 3; ++i) {
        const double direction[3] = {i == 0, i == 1, i == 2};
        assert_near(v->center[i], center[i], 0);
        assert_near(psplat_tile_reach(v, direction), half[i], 2e-5); /* it is grown by 1e-6 */
    }
    assert_near(t.nodes[0].error, 8, 0);
    assert_string_equal(t.contents[0].path, "a.glb");
    release(&t);
    t = read_good(HEAD "{\"refine\":\"REPLACE\",\"geometricError\":8,"
                       "\"boundingVolume\":{\"sphere\":[1,2,3,4]},\"content\":{\"uri\":\"a.glb\"},"
                       "\"transform\":[0,2,0,0, -2,0,0,0, 0,0,2,0, 10,20,30,1]}}",
                  "tileset.json");
    v = &t.nodes[0].volume; /* (1, 2, 3) becomes (-4 + 10, 2 + 20, 6 + 30), z up */
    assert_near(v->center[0], 6, 1e-12);
    assert_near(v->center[1], 36, 1e-12);
    assert_near(v->center[2], -22, 1e-12);
    assert_near(psplat_tile_radius(v), 8, 1e-4);
    assert_near(t.nodes[0].error, 16, 1e-12);
    release(&t);
}

/* Random points of random boxes under random transforms are in the volume, and points that are off
 * the box along its axes are as far away as they are off. */
static void test_random_volumes(void **state) {
    (void)state;
    uint32_t random = 2463534242u;
    for (int i = 0; i < 2000; ++i) {
        double box[12], m[16] = {0}, y_up[16];
        for (int k = 0; k < 12; ++k) box[k] = 2 * (double)scene_random(&random) - 1;
        cross3(box + 3, box + 6, box + 9);
        cross3(box + 3, box + 9, box + 6);
        if (i % 5 == 0) memset(box + 9, 0, 3 * sizeof *box); /* flat */
        if (i % 20 == 0) memset(box + 6, 0, 3 * sizeof *box);
        if (i % 40 == 0) memset(box + 3, 0, 3 * sizeof *box);
        for (int k = 0; k < 16; ++k) m[k] = identity[k];
        if (i % 2)
            for (int k = 0; k < 15; ++k)
                if (k % 4 != 3) m[k] = 4 * (double)scene_random(&random) - 2;
        psplat_tile_transform_y_up(m, y_up);
        psplat_tile_volume v;
        psplat_tile_volume_box(box, y_up, &v);
        for (int axis = 0; axis < 3; ++axis) {
            assert_near(psplat_dot3(v.axis[axis], v.axis[axis]), 1, 1e-9);
            assert_near(psplat_dot3(v.axis[axis], v.axis[(axis + 1) % 3]), 0, 2e-6);
        }
        for (int k = 0; k < 20; ++k) {
            double p[3], q[3], r[3], at[3];
            for (int j = 0; j < 3; ++j) at[j] = 2 * (double)scene_random(&random) - 1;
            if (k < 3) at[k] = 1;
            for (int j = 0; j < 3; ++j)
                p[j] = box[j] + at[0] * box[3 + j] + at[1] * box[6 + j] + at[2] * box[9 + j];
            for (int j = 0; j < 3; ++j)
                q[j] = m[j] * p[0] + m[4 + j] * p[1] + m[8 + j] * p[2] + m[12 + j];
            psplat_tile_y_up(q, r);
            assert_near(psplat_tile_distance(&v, r), 0, 0);
            if (i % 2) continue;
            for (int j = 0; j < 3; ++j) r[j] = v.center[j] + (v.half[k % 3] + 2) * v.axis[k % 3][j];
            assert_near(psplat_tile_distance(&v, r), 2, 1e-5);
        }
    }
}

/* Points of a region of the ellipsoid are in its sphere. */
static void test_regions(void **state) {
    (void)state;
    const double a = 6378137.0, b = 6356752.3142451793;
    uint32_t random = 2463534242u;
    for (int i = 0; i < 500; ++i) {
        double size = pow(10, -6 * (double)scene_random(&random)), g[6];
        g[0] = 6 * (double)scene_random(&random) - 3;
        g[1] = 1.5 * (2 * (double)scene_random(&random) - 1);
        g[2] = g[0] + size;
        g[3] = fmin(g[1] + size, 1.57);
        g[4] = -100;
        g[5] = 1000 * (double)scene_random(&random);
        double east = g[2];
        if (g[2] > 3.14159265) g[2] -= 2 * 3.14159265358979323846; /* over the date line */
        psplat_tile_volume v;
        psplat_tile_volume_region(g, &v);
        for (int k = 0; k < 50; ++k) {
            double s = k & 1 ? 1 : (double)scene_random(&random);
            double u = k & 2 ? 0 : (double)scene_random(&random);
            double longitude = g[0] + s * (east - g[0]), latitude = g[1] + u * (g[3] - g[1]);
            double h = k & 4 ? g[5] : g[4], n = a * a / hypot(a * cos(latitude), b * sin(latitude));
            const double z_up[3] = {(n + h) * cos(latitude) * cos(longitude),
                                    (n + h) * cos(latitude) * sin(longitude),
                                    (b * b / (a * a) * n + h) * sin(latitude)};
            double p[3];
            psplat_tile_y_up(z_up, p);
            assert_near(psplat_tile_distance(&v, p), 0, 0);
        }
        if (i % 50 == 0) { /* most of the earth */
            const double most[6] = {-3, -1.5, 3, 1.5, 0, 10}, middle[3] = {6378137, 0, 0};
            psplat_tile_volume_region(most, &v);
            assert_near(psplat_tile_distance(&v, middle), 0, 0);
        }
        double way = 6.4e6 * size * 1.5 + 1100; /* it is not much larger than the region */
        assert_true(psplat_tile_radius(&v) < fmin(fmax(way, i % 50 ? 0 : 6.5e6), 6.5e6));
    }
}

/* Transforms of tiles follow one another, and are those of contents between spaces with y up. */
static void test_transforms(void **state) {
    (void)state;
    psplat_tileset t =
        read_good(HEAD TILE ",\"transform\":[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,7,1],\"children\":["
                            "{\"geometricError\":4," BOX ",\"content\":{\"uri\":\"b.glb\"},"
                            "\"transform\":[0,1,0,0, -1,0,0,0, 0,0,1,0, 0,0,0,1]}, " CHILD "]}}",
                  "tileset.json");
    assert_int_equal(t.node_count, 3);
    /* 7 up along z is 7 along y; a quarter turn around z is one around y. */
    const double *first = t.transforms[t.nodes[0].transform];
    const double *second = t.transforms[t.nodes[1].transform];
    assert_near(first[13], 7, 0);
    assert_near(first[0] + first[5] + first[10], 3, 0);
    const double turned[16] = {0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 7, 0, 1};
    for (int i = 0; i < 16; ++i) assert_near(second[i], turned[i], 1e-15);
    assert_int_equal(t.nodes[2].transform, t.nodes[0].transform);
    release(&t);
    t = read_good(HEAD TILE "}}", "tileset.json");
    assert_memory_equal(t.transforms[t.nodes[0].transform], identity, sizeof identity);
    release(&t);
}

/* Children lie side by side, those of tiles without contents in the place of these. */
static void test_shapes(void **state) {
    (void)state;
    psplat_tileset t = read_good(
        HEAD TILE ",\"children\":[" CHILD ",{\"geometricError\":5," BOX
                  ",\"refine\":\"ADD\",\"children\":[" CHILD ",{\"geometricError\":1," BOX
                  ",\"contents\":[{\"uri\":\"c%41.glb\"},{\"uri\":\"d/../e.glb\"}]}]}," CHILD "]}}",
        "tileset.json");
    assert_int_equal(t.node_count, 5);
    assert_int_equal(t.nodes[0].first_child, 1);
    assert_int_equal(t.nodes[0].child_count, 4);
    for (int i = 1; i < 5; ++i) assert_int_equal(t.nodes[i].parent, 0);
    assert_int_equal(t.nodes[3].content_count, 2);
    assert_string_equal(t.contents[t.nodes[3].first_content].path, "cA.glb");
    assert_string_equal(t.contents[t.nodes[3].first_content + 1].path, "e.glb");
    release(&t);
    t = read_good(HEAD "{\"refine\":\"ADD\",\"geometricError\":8," BOX ",\"children\":[" CHILD
                       "," CHILD "]}}",
                  "a/b/tileset.json");
    assert_int_equal(t.node_count, 3);
    assert_int_equal(t.nodes[0].content_count, 0);
    assert_string_equal(t.contents[0].path, "a/b/b.glb");
    release(&t);
}

static void test_extras(void **state) {
    (void)state;
    psplat_tileset t = read_good(
        HEAD TILE ",\"extras\":{\"mine\":[],\"phongsplat\":{\"splats\":77,\"level\":3,"
                  "\"cone\":[0,0,1,0.5]}},\"children\":[" CHILD ",{\"geometricError\":4," BOX
                  ",\"content\":{\"uri\":\"b.glb\"},\"extras\":\"of others\","
                  "\"transform\":[1,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1]}]}}",
        "tileset.json");
    assert_int_equal(t.nodes[0].splats, 77);
    const double cone[4] = {0, 1, 0, 0.5};
    for (int i = 0; i < 4; ++i) assert_near(t.nodes[0].cone[i], cone[i], 1e-15);
    assert_int_equal(t.nodes[1].splats, 0);
    assert_true(t.nodes[1].cone[3] < -1 && t.nodes[2].cone[3] < -1);
    release(&t);
}

/* ---- refusals ------------------------------------------------------------------------------- */

/* A text in which @ stands before the byte that the error has to name. */
typedef struct refusal {
    psplat_result result;
    const char *text, *cause;
} refusal;

static void expect_refusal(const refusal *r, const psplat_tile_file *referrer) {
    char *text = malloc(strlen(r->text) + 1);
    psplat_tileset tileset;
    psplat_error error = {0};
    const char *mark = strchr(r->text, '@');
    assert_non_null(text);
    assert_non_null(mark);
    size_t at = (size_t)(mark - r->text);
    memcpy(text, r->text, at);
    strcpy(text + at, mark + 1);
    psplat_result result = read_at(text, strlen(text), "x/y.json", referrer, &tileset, &error);
    if (result != r->result || error.offset != at || !strstr(error.text, r->cause) ||
        strncmp(error.text, "x/y.json: ", 10)) {
        print_error("%s\nis refused as %d: %s at %zu, not as %d: %s at %zu\n", text, (int)result,
                    error.text, error.offset, (int)r->result, r->cause, at);
        fail();
    }
    free(text);
}

#define ROOT(members) HEAD "{\"refine\":\"REPLACE\",\"geometricError\":8," members "}}"
#define LEAF(members) HEAD TILE "," members "}}"

static const refusal refusals[] = {
    {PSPLAT_ERROR_FORMAT, "@", "JSON"},
    {PSPLAT_ERROR_FORMAT, "@{}", "asset is missing"},
    {PSPLAT_ERROR_FORMAT, "{\"asset\":@{}}", "version is missing"},
    {PSPLAT_ERROR_UNSUPPORTED, "{\"asset\":{\"version\":@\"0.0\"}}", "neither 1.0 nor 1.1"},
    {PSPLAT_ERROR_UNSUPPORTED, "{\"asset\":{\"version\":\"1.0\",\"gltfUpAxis\":@\"Z\"}}", "not Y"},
    {PSPLAT_ERROR_UNSUPPORTED,
     "{\"asset\":{\"version\":\"1.1\"},\"extensionsRequired\":[@\"3DTILES_bounding_volume_S2\"]}",
     "requires an extension"},
    {PSPLAT_ERROR_FORMAT, "@{\"asset\":{\"version\":\"1.1\"}}", "geometricError is missing"},
    {PSPLAT_ERROR_FORMAT, "@{\"asset\":{\"version\":\"1.1\"},\"geometricError\":1}",
     "root is missing"},
    {PSPLAT_ERROR_FORMAT, HEAD "@7}", "an object is expected"},
    {PSPLAT_ERROR_FORMAT, HEAD "@{}}", "boundingVolume is missing"},
    {PSPLAT_ERROR_FORMAT, HEAD "@{" BOX "}}", "neither content nor children"},
    {PSPLAT_ERROR_FORMAT, HEAD "@{" BOX ",\"content\":{\"uri\":\"a.glb\"}}}",
     "geometricError is missing"},
    {PSPLAT_ERROR_FORMAT, HEAD "@{" BOX ",\"content\":{\"uri\":\"a.glb\"},\"geometricError\":1}}",
     "refine"},
    {PSPLAT_ERROR_FORMAT, ROOT(BOX ",\"children\":@[]"), "children is empty"},
    {PSPLAT_ERROR_FORMAT, ROOT(BOX ",\"children\":@{}"), "children must be an array"},
    {PSPLAT_ERROR_FORMAT, ROOT(BOX ",\"children\":[@{}]"), "boundingVolume is missing"},
    {PSPLAT_ERROR_FORMAT, ROOT(BOX ",\"children\":[@null]"), "an object is expected"},
    {PSPLAT_ERROR_FORMAT, ROOT(BOX ",\"content\":@{}"), "no uri"},
    {PSPLAT_ERROR_FORMAT, ROOT(BOX ",\"content\":{\"uri\":@7}"), "string"},
    {PSPLAT_ERROR_FORMAT, ROOT(BOX ",\"contents\":@[]"), "contents is empty"},
    /* Errors that grow downwards, also through tiles without content and through scales. */
    {PSPLAT_ERROR_RANGE,
     LEAF("\"children\":[{" BOX ",\"geometricError\":@8.1,\"content\":{\"uri\":\"b.glb\"}}]"),
     "grows downwards: 8.1 is more than 8"},
    {PSPLAT_ERROR_RANGE,
     LEAF("\"children\":[{" BOX ",\"geometricError\":3,\"children\":[{" BOX
          ",\"geometricError\":@4,\"content\":{\"uri\":\"b.glb\"}}]}]"),
     "grows downwards: 4 is more than 3"},
    {PSPLAT_ERROR_RANGE,
     LEAF("\"children\":[{" BOX ",\"geometricError\":@4.1,\"content\":{\"uri\":\"b.glb\"},"
          "\"transform\":[1,0,0,0, 0,2,0,0, 0,0,1,0, 0,0,0,1]}]"),
     "grows downwards: 8.2 is more than 8"},
    {PSPLAT_ERROR_RANGE,
     HEAD "{\"refine\":\"REPLACE\"," BOX ",\"geometricError\":@-1,"
          "\"content\":{\"uri\":\"a.glb\"}}}",
     "geometricError is negative"},
    {PSPLAT_ERROR_RANGE,
     HEAD "{\"refine\":\"REPLACE\"," BOX ",\"geometricError\":@1e999,"
          "\"content\":{\"uri\":\"a.glb\"}}}",
     "too large"},
    {PSPLAT_ERROR_FORMAT, HEAD "{\"refine\":\"REPLACE\"," BOX ",\"geometricError\":@NaN}}", "JSON"},
    /* Transforms. */
    {PSPLAT_ERROR_RANGE, LEAF("\"transform\":@[1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1]"), "singular"},
    {PSPLAT_ERROR_RANGE, LEAF("\"transform\":@[1,0,0,0, 0,1,0,0, 0,0,1,1, 0,0,0,1]"), "last row"},
    {PSPLAT_ERROR_RANGE, LEAF("\"transform\":@[1,0,0,0, 0,1,0,0, 0,0,1]"), "16 numbers"},
    {PSPLAT_ERROR_RANGE, LEAF("\"transform\":@[1e200,0,0,0, 0,1e200,0,0, 0,0,1e200,0, 0,0,0,1]"),
     "not finite"},
    /* Volumes. */
    {PSPLAT_ERROR_UNSUPPORTED, ROOT("\"boundingVolume\":@{},\"content\":{\"uri\":\"a.glb\"}"),
     "neither box nor sphere"},
    {PSPLAT_ERROR_RANGE,
     ROOT("\"boundingVolume\":{\"box\":@[1,2]},\"content\":{\"uri\":\"a.glb\"}"), "12 numbers"},
    {PSPLAT_ERROR_RANGE,
     ROOT("\"boundingVolume\":{\"sphere\":@[0,0,0,-1]},\"content\":{\"uri\":\"a.glb\"}"),
     "negative"},
    {PSPLAT_ERROR_RANGE,
     ROOT("\"boundingVolume\":@{\"sphere\":[0,0,0,1e200]},\"content\":{\"uri\":\"a.glb\"}"),
     "too large"},
    {PSPLAT_ERROR_RANGE,
     ROOT("\"boundingVolume\":{\"region\":@[0,1,1,0,0,0]},\"content\":{\"uri\":\"a.glb\"}"),
     "south above its north"},
    {PSPLAT_ERROR_RANGE,
     ROOT("\"boundingVolume\":{\"region\":@[0,0,1,2,0,0]},\"content\":{\"uri\":\"a.glb\"}"),
     "not on the ellipsoid"},
    /* What is not read. */
    {PSPLAT_ERROR_UNSUPPORTED,
     HEAD "{\"refine\":@\"ADD\",\"geometricError\":8," BOX ",\"content\":{\"uri\":\"a.glb\"},"
          "\"children\":[" CHILD "]}}",
     "refine ADD"},
    {PSPLAT_ERROR_FORMAT,
     LEAF("\"children\":[{\"geometricError\":1," BOX
          ",\"content\":{\"uri\":\"a.glb\"},\"refine\":@\"add\"}]"),
     "neither REPLACE nor ADD"},
    {PSPLAT_ERROR_UNSUPPORTED, LEAF("\"implicitTiling\":@{}"), "implicitTiling"},
    {PSPLAT_ERROR_UNSUPPORTED, LEAF("\"viewerRequestVolume\":@{}"), "viewerRequestVolume"},
    {PSPLAT_ERROR_UNSUPPORTED,
     HEAD "@{\"refine\":\"REPLACE\",\"geometricError\":8," BOX ",\"content\":{\"uri\":\"a.json\"},"
          "\"children\":[" CHILD "]}}",
     "external tileset beside children"},
    {PSPLAT_ERROR_FORMAT,
     HEAD "@{\"refine\":\"REPLACE\",\"geometricError\":8," BOX
          ",\"content\":{\"uri\":\"a.glb\"},\"contents\":[]}}",
     "both content and contents"},
    {PSPLAT_ERROR_RANGE, LEAF("\"extras\":{\"phongsplat\":{\"cone\":@[0,0,2,0]}}"), "cone"},
    {PSPLAT_ERROR_RANGE, LEAF("\"extras\":{\"phongsplat\":{\"splats\":@-1}}"), "splats"},
    {PSPLAT_ERROR_FORMAT, LEAF("@\"geometricError\":3"), "occurs twice"},
    {PSPLAT_ERROR_UNSUPPORTED, ROOT(BOX ",\"content\":{\"uri\":@\"../../a.glb\"}"),
     "leaves its directory"},
    {PSPLAT_ERROR_UNSUPPORTED, ROOT(BOX ",\"content\":{\"uri\":@\"https://a.org/a.glb\"}"),
     "a scheme"},
};

static void test_refusals(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof refusals / sizeof *refusals; ++i)
        expect_refusal(&refusals[i], NULL);
}

/* Circles of files, and external tilesets without content. */
static void test_circles(void **state) {
    (void)state;
    const psplat_tile_file root = {"tileset.json", NULL}, other = {"a.json", &root};
    const psplat_tile_file self = {"x/y.json", &other}, below = {"b.json", &self};
    expect_refusal(&(refusal){PSPLAT_ERROR_FORMAT, "@" HEAD TILE "}}", "refers to itself"}, &below);
    expect_refusal(&(refusal){PSPLAT_ERROR_UNSUPPORTED,
                              HEAD "@{\"refine\":\"REPLACE\",\"geometricError\":8," BOX
                                   ",\"children\":[" CHILD "]}}",
                              "external tileset has no content"},
                   &other);
    psplat_tile_file chain[PSPLAT_TILE_MAX_FILES_DEEP + 1];
    for (int i = 0; i <= PSPLAT_TILE_MAX_FILES_DEEP; ++i)
        chain[i] = (psplat_tile_file){"z.json", i ? &chain[i - 1] : NULL};
    expect_refusal(&(refusal){PSPLAT_ERROR_UNSUPPORTED, "@" HEAD TILE "}}", "too many tilesets"},
                   &chain[PSPLAT_TILE_MAX_FILES_DEEP]);
}

/* Tiles that are nested too deep for the JSON reader. */
static void test_depth(void **state) {
    (void)state;
    for (int deep = 29; deep < 34; deep += 4) {
        world_text text = {0};
        text_put(&text, HEAD);
        for (int i = 0; i < deep; ++i)
            text_put(&text, TILE "%s", i + 1 < deep ? ",\"children\":[" : "");
        for (int i = 0; i < deep; ++i) text_put(&text, i + 1 < deep ? "}]" : "}}");
        psplat_tileset t;
        psplat_error error = {0};
        psplat_result result = read_at(text.data, text.size, "t.json", NULL, &t, &error);
        assert_int_equal(result, deep < 31 ? PSPLAT_OK : PSPLAT_ERROR_UNSUPPORTED);
        if (result)
            assert_true(error.offset > 0);
        else
            assert_int_equal(t.node_count, deep);
        if (!result) release(&t);
        free(text.data);
    }
}

static void test_uris(void **state) {
    (void)state;
    static const struct {
        const char *from, *uri, *path; /* path NULL: refused */
    } cases[] = {
        {"tileset.json", "a.glb", "a.glb"},
        {"tileset.json", "./t//a.glb", "t/a.glb"},
        {"x/y/z.json", "a.glb", "x/y/a.glb"},
        {"x/y/z.json", "../t/a%20b.glb", "x/t/a b.glb"},
        {"x/y/z.json", "../../t/../a.glb", "a.glb"},
        {"x/y/z.json", "../../../a.glb", NULL},
        {"x/y/z.json", "%2e%2e/%2e./..%2Fa.glb", NULL},
        {"x/y/z.json", "a/../../../../x/a.glb", NULL},
        {"tileset.json", "..", NULL},
        {"tileset.json", "", NULL},
        {"tileset.json", "a/", NULL},
        {"tileset.json", ".", NULL},
        {"tileset.json", "a/..", NULL},
        {"tileset.json", "/etc/passwd", NULL},
        {"tileset.json", "%2Fetc/passwd", NULL},
        {"tileset.json", "http://x/a.glb", NULL},
        {"tileset.json", "data:,x", NULL},
        {"tileset.json", "c:/a.glb", NULL},
        {"tileset.json", "a\\b.glb", NULL},
        {"tileset.json", "a%5Cb.glb", NULL},
        {"tileset.json", "a.glb?v=1", NULL},
        {"tileset.json", "a.glb#x", NULL},
        {"tileset.json", "a%3Fb.glb", "a?b.glb"},
        {"tileset.json", "a%0", NULL},
        {"tileset.json", "a%00b", NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_arena arena = {.allocator = psplat_allocator_default(NULL)};
        const char *reason = NULL;
        const char *path =
            psplat_uri_resolve(cases[i].from, cases[i].uri, strlen(cases[i].uri), &arena, &reason);
        if (cases[i].path) {
            assert_non_null(path);
            assert_string_equal(path, cases[i].path);
        } else {
            if (path) print_error("%s in %s is %s\n", cases[i].uri, cases[i].from, path);
            assert_null(path);
            assert_non_null(reason);
        }
        psplat_arena_release(&arena);
    }
}

/* ---- opening --------------------------------------------------------------------------------- */

static void test_opening(void **state) {
    (void)state;
    world w = {0};
    psplat_error error = {0};
    psplat_tiles *tiles = (psplat_tiles *)&w;
    psplat_tiles_desc desc = {.source = {.read = world_read, .user = &w}};
    assert_int_equal(psplat_tiles_open(&desc, "dir/tileset.json", &tiles, &error),
                     PSPLAT_ERROR_READ);
    assert_null(tiles);
    assert_non_null(strstr(error.text, "dir/tileset.json"));
    assert_int_equal(psplat_tiles_open(&desc, NULL, &tiles, &error), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_tiles_open(NULL, "/no/such/file", &tiles, &error), PSPLAT_ERROR_READ);
    desc.max_requests = 100000;
    assert_int_equal(psplat_tiles_open(&desc, "a", &tiles, &error), PSPLAT_ERROR_ARGUMENT);
    desc.max_requests = 0;
    desc.fade_seconds = -1;
    assert_int_equal(psplat_tiles_open(&desc, "a", &tiles, &error), PSPLAT_ERROR_ARGUMENT);
    desc.fade_seconds = 0;
    text_put(world_add_file(&w, "tileset.json"), "%s", HEAD TILE "}}");
    assert_int_equal(psplat_tiles_open(&desc, "dir/tileset.json", &tiles, &error), PSPLAT_OK);
    double min[3], max[3];
    psplat_tiles_bounds(tiles, min, max);
    const double low[3] = {-3, -3, -7}, high[3] = {5, 9, 3};
    for (int i = 0; i < 3; ++i) {
        assert_near(min[i], low[i], 1e-4);
        assert_near(max[i], high[i], 1e-4);
    }
    assert_int_equal(psplat_tiles_describe(tiles).tiles, 1);
    assert_int_equal(psplat_tiles_describe(NULL).tiles, 0);
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

/* The default source is stdio. */
static void test_stdio(void **state) {
    (void)state;
    const char *path = PSPLAT_BINARY_DIR "/test_tileset.json";
    FILE *file = fopen(path, "wb");
    psplat_tiles *tiles = NULL;
    assert_non_null(file);
    fputs(HEAD TILE "}}", file);
    for (int i = 0; i < 100000; ++i) fputc('\n', file); /* more than one read */
    fclose(file);
    assert_int_equal(psplat_tiles_open(NULL, path, &tiles, NULL), PSPLAT_OK);
    psplat_tiles_destroy(tiles, NULL);
    remove(path);
}

int test_tileset_file_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_volumes),  cmocka_unit_test(test_random_volumes),
        cmocka_unit_test(test_regions),  cmocka_unit_test(test_transforms),
        cmocka_unit_test(test_shapes),   cmocka_unit_test(test_extras),
        cmocka_unit_test(test_refusals), cmocka_unit_test(test_circles),
        cmocka_unit_test(test_depth),    cmocka_unit_test(test_uris),
        cmocka_unit_test(test_opening),  cmocka_unit_test(test_stdio),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

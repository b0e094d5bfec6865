/* SPDX-License-Identifier: MIT
 *
 * test_asset_textured.c - tests what section 3.11 of the specification adds to files: texture
 * coordinates of splats, textures of their materials, and images, which are kept as they are.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "document.h"
#include "packed.h"

#include <math.h>
#include <phongsplat/phongsplat.h>
#include <stdlib.h>

#define HEAD(version)                                                                              \
    "\"version\":" version ",\"clipLines\":0,\"depthTolerance\":0,\"positionExtent\":[0,0,0]"
#define TEXTURE(index) "{\"index\":" #index "}"
/* Base64 of the bytes 1 2 3, of the signature of a PNG, of "\xff\xd8\xff" and of "RIFF1234WEBP". */
#define BYTES "data:application/octet-stream;base64,AQID"
#define PNG "data:;base64,iVBORw0KGgo="
#define JPEG "data:;base64,/9j/"
#define WEBP "data:;base64,UklGRjEyMzRXRUJQ"
#define BASE_COLOR(info) "{\"pbrMetallicRoughness\":{\"baseColorTexture\":" info "}}"
#define ONE_IMAGE "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"" PNG "\"}]"

/* ---- documents ------------------------------------------------------------------------------ */

static psplat_asset *open_text(char *text, const psplat_asset_desc *desc) {
    psplat_asset *asset = NULL;
    psplat_error error;
    if (psplat_asset_open_memory(text, strlen(text), desc, &asset, &error))
        fail_msg("%s (byte %zu)", error.text, error.offset);
    free(text);
    return asset;
}

static psplat_asset *open_packed(const packed *p) {
    return open_text(packed_text(p), NULL);
}

/* Expects an error with the code, at the first occurrence of the word in the text. */
static void refuse_text(char *text, psplat_result code, const char *word, const char *says) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    psplat_result result = psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error);
    if (result != code || (word && error.offset != document_find(text, word)) ||
        !strstr(error.text, says))
        fail_msg("%s (byte %zu): %s", psplat_result_text(result), error.offset, error.text);
    assert_null(asset);
    free(text);
}

static void refuse(const packed *p, psplat_result code, const char *word, const char *says) {
    refuse_text(packed_text(p), code, word, says);
}

static const double at_values[2] = {0.25, 0.75};

/* Returns a splat with texture coordinates, a material and what else the document has. */
static packed textured(const char *material, const char *members) {
    packed p = packed_default();
    p.extension = HEAD("3");
    p.attributes[4] = (packed_attribute){"TEXCOORD_0", PACKED_FLOAT, 2, 0, at_values};
    p.material = material;
    p.members = members;
    return p;
}

static void assert_near(double found, double expected, double tolerance) {
    if (!(fabs(found - expected) <= tolerance)) fail_msg("%.17g, expected %.17g", found, expected);
}

static void assert_pair(const float found[2], double s, double t) {
    assert_near((double)found[0], s, 0);
    assert_near((double)found[1], t, 0);
}

/* ---- coordinates ---------------------------------------------------------------------------- */

static const double slopes[2][2] = {{64, -127}, {127, 0}};
static const double bends[3][2] = {{-32767, 1}, {2, 3}, {4, 5}};

/* Adds coordinates of the first and of the second order, as integers. */
static void add_orders(packed *p, int is_second) {
    p->attributes[5] = (packed_attribute){"TEXCOORD_U", PACKED_BYTE, 2, 0, slopes[0]};
    p->attributes[6] = (packed_attribute){"TEXCOORD_V", PACKED_BYTE, 2, 0, slopes[1]};
    if (!is_second) return;
    p->attributes[7] = (packed_attribute){"TEXCOORD_UU", PACKED_SHORT, 2, 0, bends[0]};
    p->attributes[8] = (packed_attribute){"TEXCOORD_UV", PACKED_SHORT, 2, 0, bends[1]};
    p->attributes[9] = (packed_attribute){"TEXCOORD_VV", PACKED_SHORT, 2, 0, bends[2]};
}

static void test_coordinates(void **state) {
    (void)state;
    packed p = textured(NULL, NULL);
    psplat_asset *asset = open_packed(&p);
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    assert_true(batch->has_texcoord && !batch->has_texcoord_bend);
    assert_pair(batch->texcoords->at, 0.25, 0.75);
    assert_pair(batch->texcoords->along_u, 0, 0);
    psplat_asset_destroy(asset);
    add_orders(&p, 1);
    p.extension = HEAD("3") ",\"texcoordRange\":0.5,\"texcoordBendRange\":0.25";
    asset = open_packed(&p);
    batch = psplat_asset_batch(asset, 0);
    const psplat_texcoord *t = batch->texcoords;
    assert_true(batch->has_texcoord && batch->has_texcoord_bend);
    assert_pair(t->at, 0.25, 0.75);
    assert_pair(t->along_u, (double)(64.0f / 127.0f * 0.5f), -0.5);
    assert_pair(t->along_v, 0.5, 0);
    assert_pair(t->along_uu, -0.25, (double)(1.0f / 32767.0f * 0.25f));
    assert_pair(t->along_uv, (double)(2.0f / 32767.0f * 0.25f), (double)(3.0f / 32767.0f * 0.25f));
    assert_pair(t->along_vv, (double)(4.0f / 32767.0f * 0.25f), (double)(5.0f / 32767.0f * 0.25f));
    psplat_asset_destroy(asset);
}

/* TEXCOORD_0 has every form of KHR_mesh_quantization; plain integers are taken as they are. */
static void test_forms(void **state) {
    (void)state;
    static const struct {
        int type, is_plain;
        double stored[2], expected[2];
    } forms[] = {{PACKED_UNSIGNED_BYTE, 0, {255, 51}, {1, 0.2f}},
                 {PACKED_UNSIGNED_SHORT, 0, {65535, 13107}, {1, 0.2f}},
                 {PACKED_SHORT, 0, {-32767, 32767}, {-1, 1}},
                 {PACKED_BYTE, 0, {-128, 127}, {-1, 1}},
                 {PACKED_SHORT, 1, {-3, 700}, {-3, 700}},
                 {PACKED_UNSIGNED_BYTE, 1, {0, 200}, {0, 200}}};
    for (size_t i = 0; i < sizeof forms / sizeof *forms; ++i) {
        packed p = textured(NULL, NULL);
        p.attributes[4] =
            (packed_attribute){"TEXCOORD_0", forms[i].type, 2, forms[i].is_plain, forms[i].stored};
        psplat_asset *asset = open_packed(&p);
        assert_pair(psplat_asset_batch(asset, 0)->texcoords->at, forms[i].expected[0],
                    forms[i].expected[1]);
        psplat_asset_destroy(asset);
    }
}

/* Older versions know no texture coordinates: what they take for one of many unknown attributes
 * stays unread, and what only version 3 can mean is refused. */
static void test_versions(void **state) {
    (void)state;
    packed p = textured("{\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":"
                        "{\"baseColorTexture\":{\"index\":0}}}",
                        ONE_IMAGE);
    p.extension = HEAD("2");
    psplat_asset *asset = open_packed(&p);
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    assert_true(!batch->has_texcoord && !batch->texcoords && batch->material.alpha_cutoff == 0);
    assert_int_equal(batch->material.textures[0].image, 0);
    assert_int_equal(psplat_asset_image_count(asset), 0);
    psplat_asset_destroy(asset);
    add_orders(&p, 0);
    refuse(&p, PSPLAT_ERROR_UNSUPPORTED, NULL, "is of version 3");
}

static void test_refused_coordinates(void **state) {
    (void)state;
    packed p = textured(NULL, NULL);
    add_orders(&p, 0);
    refuse(&p, PSPLAT_ERROR_FORMAT, NULL, "texcoordRange");
    p.extension = HEAD("3") ",\"texcoordRange\":0";
    refuse(&p, PSPLAT_ERROR_RANGE, NULL, "greater than 0");
    p.extension = HEAD("3") ",\"texcoordRange\":1";
    p.attributes[6].name = "TEXCOORD_UV";
    refuse(&p, PSPLAT_ERROR_FORMAT, NULL, "TEXCOORD_V is missing");
    p.attributes[6] = (packed_attribute){0};
    refuse(&p, PSPLAT_ERROR_FORMAT, NULL, "TEXCOORD_V is missing");
    p.attributes[4].name = "TEXCOORD_V";
    refuse(&p, PSPLAT_ERROR_FORMAT, NULL, "TEXCOORD_0 is missing");
    p = textured(NULL, NULL);
    add_orders(&p, 1);
    p.extension = HEAD("3") ",\"texcoordRange\":1";
    refuse(&p, PSPLAT_ERROR_FORMAT, NULL, "texcoordBendRange");
    p.attributes[9] = (packed_attribute){0};
    refuse(&p, PSPLAT_ERROR_FORMAT, NULL, "TEXCOORD_VV is missing");
    static const double infinite[3] = {0, INFINITY, 0};
    p = textured(NULL, NULL);
    p.attributes[4].values = infinite;
    refuse(&p, PSPLAT_ERROR_RANGE, NULL, "splat 0: TEXCOORD_0 is not finite");
    p.attributes[4].components = 3;
    refuse(&p, PSPLAT_ERROR_UNSUPPORTED, NULL, "must be VEC2");
}

/* ---- materials ------------------------------------------------------------------------------ */

static psplat_material material_of(const psplat_asset *asset) {
    return psplat_asset_batch(asset, 0)->material;
}

/* All five slots, each with an image of its own, of which the order is that of the slots; images
 * that none of them uses are not kept. */
static void test_slots(void **state) {
    (void)state;
    static const char material[] =
        "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":4},"
        "\"metallicRoughnessTexture\":{\"index\":3}},"
        "\"normalTexture\":{\"index\":5},"
        "\"occlusionTexture\":{\"index\":1,\"strength\":0.5},\"emissiveTexture\":{\"index\":0},"
        "\"extensions\":{\"PSPLAT_surface_splats\":"
        "{\"normalTexture\":{\"index\":2,\"scale\":-2}}}}";
    static const char members[] =
        "\"textures\":[{\"source\":0},{\"source\":1},{\"source\":2},{\"source\":3,\"sampler\":0},"
        "{\"source\":4},{\"source\":5}],"
        "\"samplers\":[{\"wrapS\":33071,\"wrapT\":33648,\"magFilter\":9728}],"
        "\"images\":[{\"uri\":\"" BYTES "\",\"name\":\"glow\"},"
        "{\"uri\":\"" BYTES "\",\"mimeType\":\"image/odd\"},{\"uri\":\"" PNG "\"},"
        "{\"uri\":\"" JPEG "\"},{\"uri\":\"" WEBP "\"},{\"uri\":\"missing.png\"}]";
    packed p = textured(material, members);
    psplat_asset *asset = open_packed(&p);
    psplat_material found = material_of(asset);
    static const char *const types[] = {"image/webp", "image/jpeg", "image/png", "image/odd", ""};
    assert_int_equal(psplat_asset_image_count(asset), 5);
    for (size_t i = 0; i < 5; ++i) {
        assert_int_equal(found.textures[i].image, i + 1);
        assert_string_equal(psplat_asset_get_image(asset, i)->mime_type, types[i]);
    }
    const psplat_asset_image *glow = psplat_asset_get_image(asset, 4);
    assert_int_equal(glow->size, 3);
    assert_memory_equal(glow->data, "\1\2\3", 3);
    assert_string_equal(glow->name, "glow");
    assert_string_equal(psplat_asset_get_image(asset, 3)->name, "");
    assert_null(psplat_asset_get_image(asset, 5));
    assert_near((double)found.textures[PSPLAT_TEXTURE_OCCLUSION].strength, 0.5, 0);
    assert_near((double)found.textures[PSPLAT_TEXTURE_NORMAL].strength, -2, 0);
    assert_int_equal(found.textures[1].wrap[0], PSPLAT_WRAP_CLAMP);
    assert_int_equal(found.textures[1].wrap[1], PSPLAT_WRAP_MIRROR);
    assert_true(found.textures[1].nearest && !found.textures[0].nearest);
    assert_int_equal(found.textures[0].wrap[0], PSPLAT_WRAP_REPEAT);
    assert_true(found.alpha_cutoff == 0);
    psplat_asset_destroy(asset);
}

/* Without texture coordinates, no texture is read and nothing is masked. */
static void test_untextured(void **state) {
    (void)state;
    packed p = textured("{\"alphaMode\":\"MASK\",\"emissiveTexture\":{\"index\":7}}", NULL);
    p.attributes[4] = (packed_attribute){0};
    psplat_asset *asset = open_packed(&p);
    assert_int_equal(material_of(asset).textures[PSPLAT_TEXTURE_EMISSIVE].image, 0);
    assert_true(material_of(asset).alpha_cutoff == 0);
    assert_false(psplat_asset_batch(asset, 0)->has_texcoord);
    psplat_asset_destroy(asset);
    assert_int_equal(psplat_asset_image_count(NULL), 0);
    assert_null(psplat_asset_get_image(NULL, 0));
}

static void test_alpha(void **state) {
    (void)state;
    static const struct {
        const char *material;
        double cutoff;
    } cases[] = {{"{\"alphaMode\":\"MASK\"}", 0.5},
                 {"{\"alphaMode\":\"MASK\",\"alphaCutoff\":0.25}", 0.25},
                 {"{\"alphaMode\":\"BLEND\",\"alphaCutoff\":0.25}", 0},
                 {"{\"alphaCutoff\":0.25}", 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        packed p = textured(cases[i].material, NULL);
        psplat_asset *asset = open_packed(&p);
        assert_near((double)material_of(asset).alpha_cutoff, cases[i].cutoff, 0);
        psplat_asset_destroy(asset);
    }
    packed p = textured("{\"alphaCutoff\":-1}", NULL);
    refuse(&p, PSPLAT_ERROR_RANGE, "-1}", "alphaCutoff");
}

/* The rows of translation x rotation x scale; a rotation by a quarter turn takes (1, 0) to
 * (0, -1). */
static void test_transform(void **state) {
    (void)state;
    packed p = textured(BASE_COLOR("{\"index\":0,\"extensions\":{\"KHR_texture_transform\":{"
                                   "\"offset\":[0.5,0.25],\"rotation\":1.5707963267948966,"
                                   "\"scale\":[2,3]}}}"),
                        ONE_IMAGE);
    psplat_asset *asset = open_packed(&p);
    static const double rows[6] = {0, 3, 0.5, -2, 0, 0.25};
    for (size_t i = 0; i < 6; ++i) /* the cosine of the rounded angle is 6e-17 */
        assert_near((double)material_of(asset).textures[0].transform[i], rows[i], 1e-15);
    psplat_asset_destroy(asset);
}

/* A texture of another set of coordinates is left out, whoever says so, and its image with it. */
static void test_other_sets(void **state) {
    (void)state;
    static const struct {
        const char *material;
        size_t images;
    } cases[] = {{BASE_COLOR("{\"index\":0,\"texCoord\":1}"), 0},
                 {BASE_COLOR("{\"index\":0,\"texCoord\":1,\"extensions\":"
                             "{\"KHR_texture_transform\":{\"texCoord\":0}}}"),
                  1},
                 {BASE_COLOR("{\"index\":0,\"extensions\":"
                             "{\"KHR_texture_transform\":{\"texCoord\":2}}}"),
                  0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        packed p = textured(cases[i].material, ONE_IMAGE);
        psplat_asset *asset = open_packed(&p);
        assert_int_equal(material_of(asset).textures[0].image, cases[i].images);
        assert_int_equal(psplat_asset_image_count(asset), cases[i].images);
        psplat_asset_destroy(asset);
    }
}

/* Where a texture has no plain source, those of extensions are taken; where it has one, not. */
static void test_sources(void **state) {
    (void)state;
    static const struct {
        const char *texture;
        const char *type; /* of the image that is kept; NULL: none is */
    } cases[] = {
        {"{\"extensions\":{\"EXT_texture_webp\":{\"source\":1}}}", "image/webp"},
        {"{\"extensions\":{\"KHR_texture_basisu\":{\"source\":1}}}", "image/webp"},
        {"{\"extensions\":{\"MSFT_texture_dds\":{\"source\":1}}}", "image/webp"},
        {"{\"source\":0,\"extensions\":{\"EXT_texture_webp\":{\"source\":1}}}", "image/png"},
        {"{\"extensions\":{\"EXT_other\":{\"source\":1}}}", NULL},
        {"{}", NULL}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char members[300];
        snprintf(members, sizeof members,
                 "\"textures\":[%s],\"images\":[{\"uri\":\"" PNG "\"},{\"uri\":\"" WEBP "\"}]",
                 cases[i].texture);
        packed p = textured(BASE_COLOR(TEXTURE(0)), members);
        psplat_asset *asset = open_packed(&p);
        assert_int_equal(psplat_asset_image_count(asset), cases[i].type != NULL);
        assert_int_equal(material_of(asset).textures[0].image, cases[i].type != NULL);
        if (cases[i].type)
            assert_string_equal(psplat_asset_get_image(asset, 0)->mime_type, cases[i].type);
        psplat_asset_destroy(asset);
    }
}

static void test_refused_textures(void **state) {
    (void)state;
    static const struct {
        const char *material, *members, *word, *says;
        psplat_result code;
    } cases[] = {
        {BASE_COLOR("{}"), ONE_IMAGE, "{}}}", "index is missing", PSPLAT_ERROR_FORMAT},
        {BASE_COLOR("{\"index\":1}"), ONE_IMAGE, "1}}}", "from 0 to 0", PSPLAT_ERROR_RANGE},
        {BASE_COLOR("{\"index\":0,\"texCoord\":-1}"), ONE_IMAGE, "-1}}}", "texCoord",
         PSPLAT_ERROR_RANGE},
        {BASE_COLOR(TEXTURE(0)), "\"textures\":[]", "0}}}", "into nothing", PSPLAT_ERROR_RANGE},
        {BASE_COLOR(TEXTURE(0)), "\"textures\":[{\"source\":3}],\"images\":[{}]", "3}]", "source",
         PSPLAT_ERROR_RANGE},
        {BASE_COLOR(TEXTURE(0)), "\"textures\":[{\"sampler\":3}],\"samplers\":[{}]", "3}]",
         "sampler", PSPLAT_ERROR_RANGE},
        {BASE_COLOR(TEXTURE(0)), "\"samplers\":[{\"wrapT\":7}]", "7}]", "wrapT",
         PSPLAT_ERROR_RANGE},
        {BASE_COLOR(TEXTURE(0)), "\"samplers\":[{\"magFilter\":7}]", "7}]", "magFilter",
         PSPLAT_ERROR_RANGE},
        {"{\"occlusionTexture\":{\"index\":0,\"strength\":1.5}}", ONE_IMAGE, "1.5", "strength",
         PSPLAT_ERROR_RANGE},
        {"{\"normalTexture\":{\"index\":0,\"scale\":1e39}}", ONE_IMAGE, "1e39", "scale",
         PSPLAT_ERROR_RANGE},
        {"{\"extensions\":{\"PSPLAT_surface_splats\":{}}}", ONE_IMAGE, "{}}}", "normalTexture",
         PSPLAT_ERROR_FORMAT},
        {BASE_COLOR("{\"index\":0,\"extensions\":{\"KHR_texture_transform\":"
                    "{\"scale\":[1e39,1]}}}"),
         ONE_IMAGE, "{\"scale", "float", PSPLAT_ERROR_RANGE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        packed p = textured(cases[i].material, cases[i].members);
        refuse(&p, cases[i].code, cases[i].word, cases[i].says);
    }
}

/* ---- images --------------------------------------------------------------------------------- */

static void test_refused_images(void **state) {
    (void)state;
    static const struct {
        const char *image, *word, *says;
        psplat_result code;
    } cases[] = {
        {"{}", "{}]", "either uri or bufferView", PSPLAT_ERROR_FORMAT},
        {"{\"uri\":\"a\",\"bufferView\":0}", "{\"uri\":\"a", "either", PSPLAT_ERROR_FORMAT},
        {"{\"uri\":1}", "1}]", "uri must be a string", PSPLAT_ERROR_FORMAT},
        {"{\"bufferView\":9}", "9}]", "bufferView", PSPLAT_ERROR_RANGE},
        {"{\"uri\":\"data:;base64,?\"}", "?\"}]", "not base64", PSPLAT_ERROR_FORMAT},
        {"{\"uri\":\"data:;base64,\"}", "{\"uri\":\"data:;base64,\"}", "no bytes",
         PSPLAT_ERROR_RANGE},
        {"{\"uri\":\"a.png\"}", "\"a.png", "an image cannot be loaded: no directory",
         PSPLAT_ERROR_UNSUPPORTED},
        {"{\"uri\":\"" PNG "\",\"mimeType\":3}", "3}]", "mimeType", PSPLAT_ERROR_FORMAT},
        {"{\"uri\":\"" PNG "\",\"name\":[]}", "[]}]", "name", PSPLAT_ERROR_FORMAT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char members[300];
        snprintf(members, sizeof members, "\"textures\":[{\"source\":0}],\"images\":[%s]",
                 cases[i].image);
        packed p = textured(BASE_COLOR(TEXTURE(0)), members);
        refuse(&p, cases[i].code, cases[i].word, cases[i].says);
    }
}

/* The bytes of a view are copied, so that they outlive the file's. */
static void test_views(void **state) {
    (void)state;
    packed p = textured(BASE_COLOR(TEXTURE(0)),
                        "\"textures\":[{\"source\":0}],\"images\":[{\"bufferView\":4}]");
    psplat_asset *asset = open_packed(&p);
    const psplat_asset_image *image = psplat_asset_get_image(asset, 0);
    const float expected[2] = {0.25f, 0.75f}; /* on machines that store floats as files do */
    assert_int_equal(image->size, 8);
    assert_memory_equal(image->data, expected, 8);
    assert_string_equal(image->mime_type, "");
    psplat_asset_destroy(asset);
}

static void test_views_that_leave(void **state) {
    (void)state;
    packed p = textured(BASE_COLOR(TEXTURE(0)),
                        "\"textures\":[{\"source\":0}],\"images\":[{\"bufferView\":4}]");
    p.attributes[4].name = "_EXTRA"; /* is written with the prefix, so that nobody reads it */
    p.attributes[5] = (packed_attribute){"TEXCOORD_0", PACKED_FLOAT, 2, 0, at_values};
    char *text = packed_text(&p);
    document_replace(&text, "\"byteOffset\":48,\"byteLength\":8",
                     "\"byteOffset\":48,\"byteLength\":80");
    refuse_text(text, PSPLAT_ERROR_RANGE, "{\"buffer\":0,\"byteOffset\":48",
                "an image: the bufferView leaves its buffer");
}

/* Images may share bytes, but a small file must not fill the memory that way: ten images of all 56
 * bytes are too many. Five textures use five images; two materials use ten. */
static void test_shared_bytes(void **state) {
    (void)state;
    char members[1000], *out = members;
    out += sprintf(out, "\"textures\":[");
    for (int i = 0; i < 10; ++i) out += sprintf(out, "%s{\"source\":%d}", i ? "," : "", i);
    out += sprintf(out, "],\"images\":[");
    for (int i = 0; i < 10; ++i) out += sprintf(out, "%s{\"bufferView\":5}", i ? "," : "");
    sprintf(out, "]");
    char materials[1000], *end = materials;
    for (int i = 0; i < 10; i += 5)
        end += sprintf(end,
                       "%s{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":%d},"
                       "\"metallicRoughnessTexture\":{\"index\":%d}},\"normalTexture\":"
                       "{\"index\":%d},\"occlusionTexture\":{\"index\":%d},"
                       "\"emissiveTexture\":{\"index\":%d}}",
                       i ? "," : "", i, i + 1, i + 2, i + 3, i + 4);
    packed p = textured(materials, members);
    /* The view of all bytes; a node shows the second primitive, which is the first again. */
    char *text = packed_text(&p);
    document_replace(&text, "\"byteOffset\":48,\"byteLength\":8,\"byteStride\":8}]",
                     "\"byteOffset\":48,\"byteLength\":8,\"byteStride\":8},"
                     "{\"buffer\":0,\"byteLength\":56}]");
    psplat_asset *asset = open_text(strdup(text), NULL);
    assert_int_equal(psplat_asset_image_count(asset), 5);
    psplat_asset_destroy(asset);
    char *primitive = strstr(text, "{\"mode\":0"), *last = strstr(text, "]}],\"materials");
    assert_true(primitive && last);
    size_t length = (size_t)(last - primitive), size = strlen(text);
    char *twice = malloc(size + length + 2);
    assert_non_null(twice);
    sprintf(twice, "%.*s,%.*s%s", (int)(last - text), text, (int)length, primitive, last);
    free(text);
    document_replace(&twice, "\"material\":0", "\"material\":1");
    refuse_text(twice, PSPLAT_ERROR_RANGE, NULL, "too many times over");
}

/* ---- files beside the document -------------------------------------------------------------- */

/* Reads "d/a b.png", which holds "XYZ", and nothing else. */
static psplat_result read_one(void *user, const psplat_allocator *allocator, const char *path,
                              size_t max_size, void **data, size_t *size) {
    size_t *largest = user;
    *largest = max_size;
    if (strcmp(path, "d/a b.png")) return PSPLAT_ERROR_READ;
    if (max_size < 3) return PSPLAT_ERROR_RANGE;
    *data = allocator->resize(allocator->user, NULL, 0, 3);
    if (!*data) return PSPLAT_ERROR_MEMORY;
    memcpy(*data, "XYZ", 3);
    *size = 3;
    return PSPLAT_OK;
}

static void test_files(void **state) {
    (void)state;
    size_t largest = 0;
    packed p = textured(BASE_COLOR(TEXTURE(0)),
                        "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"a%20b.png\"}]");
    psplat_asset_desc desc = {.base_path = "d", .files = {read_one, &largest}};
    psplat_asset *asset = open_text(packed_text(&p), &desc);
    const psplat_asset_image *image = psplat_asset_get_image(asset, 0);
    assert_int_equal(image->size, 3);
    assert_memory_equal(image->data, "XYZ", 3);
    assert_string_equal(image->name, "d/a b.png");
    psplat_asset_destroy(asset);
    char *text = packed_text(&p);
    psplat_error error;
    desc.max_file_size = strlen(text) + 2;
    assert_int_equal(psplat_asset_open_memory(text, strlen(text), &desc, &asset, &error),
                     PSPLAT_ERROR_RANGE);
    assert_int_equal(largest, 2);
    assert_non_null(strstr(error.text, "an image cannot be loaded from d/a b.png"));
    desc = (psplat_asset_desc){.base_path = "e", .files = {read_one, &largest}};
    assert_int_equal(psplat_asset_open_memory(text, strlen(text), &desc, &asset, &error),
                     PSPLAT_ERROR_READ);
    free(text);
}

/* ---- the example of the specification ------------------------------------------------------- */

static void test_example(void **state) {
    (void)state;
    psplat_asset *asset = NULL;
    psplat_error error;
    const char *path = PSPLAT_SOURCE_DIR "/schema/textured.gltf";
    if (psplat_asset_open(path, NULL, &asset, &error)) fail_msg("%s", error.text);
    const psplat_batch *flat = psplat_asset_batch(asset, 0), *bent = psplat_asset_batch(asset, 1);
    assert_true(flat->has_texcoord && !flat->has_texcoord_bend && bent->has_texcoord_bend);
    assert_pair(flat->texcoords[1].at, 0.5, 0.5);
    assert_pair(flat->texcoords[1].along_u, -0.5, 0);
    assert_pair(flat->texcoords[1].along_v, 0, -0.5);
    const psplat_texcoord *t = bent->texcoords;
    for (int i = 0; i < 2; ++i) /* the table gives so many digits */
        assert_near((double)t->at[i] + (double)t->along_v[i] + (double)t->along_vv[i],
                    (const double[]){0.50001, 0.0630}[i], 3e-5);
    assert_near((double)t->along_uv[0], 0.125, 0);
    assert_near((double)t->along_uv[1], -0.0315, 1e-5);
    assert_true(flat->material.textures[PSPLAT_TEXTURE_BASE_COLOR].nearest);
    assert_true(flat->material.textures[PSPLAT_TEXTURE_NORMAL].strength == 0.5f);
    const psplat_texture *moved = &bent->material.textures[PSPLAT_TEXTURE_BASE_COLOR];
    const float rows[6] = {2, 0, 0.25f, 0, 3, 0};
    for (int i = 0; i < 6; ++i) assert_true(moved->transform[i] == rows[i]);
    assert_int_equal(moved->image, flat->material.textures[PSPLAT_TEXTURE_BASE_COLOR].image);
    assert_int_equal(psplat_asset_image_count(asset), 2);
    assert_string_equal(psplat_asset_get_image(asset, 1)->name, "normals");
    psplat_asset_destroy(asset);
}

/* ---- memory --------------------------------------------------------------------------------- */

/* Lets the allocation fail that is the first after so many. */
typedef struct budget {
    size_t left;
    size_t held; /* bytes */
} budget;

static void *limited_resize(void *user, void *memory, size_t old_size, size_t new_size) {
    budget *b = user;
    if (!new_size) {
        b->held -= old_size;
        free(memory);
        return NULL;
    }
    if (!b->left) return NULL;
    --b->left;
    void *block = realloc(memory, new_size);
    if (block) b->held += new_size - old_size;
    return block;
}

static void test_out_of_memory(void **state) {
    (void)state;
    packed p = textured("{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}},"
                        "\"emissiveTexture\":{\"index\":1}}",
                        "\"textures\":[{\"source\":0},{\"source\":1}],"
                        "\"images\":[{\"uri\":\"" PNG "\",\"name\":\"n\"},{\"bufferView\":4}]");
    char *text = packed_text(&p);
    psplat_result result = PSPLAT_ERROR_MEMORY;
    for (int only_draws = 0; only_draws < 2; ++only_draws)
        for (size_t left = 0; result || !left; ++left) {
            budget b = {left, 0};
            psplat_asset_desc desc = {.allocator = {limited_resize, &b}, .only_draws = only_draws};
            psplat_asset *asset = NULL;
            psplat_error error = {0};
            result = psplat_asset_open_memory(text, strlen(text), &desc, &asset, &error);
            if (result && result != PSPLAT_ERROR_MEMORY) fail_msg("%s", error.text);
            psplat_asset_destroy(asset);
            assert_int_equal(b.held, 0);
        }
    free(text);
}

/* Assets that only draw keep images and materials as others do. */
static void test_only_draws(void **state) {
    (void)state;
    packed p = textured(BASE_COLOR(TEXTURE(0)), ONE_IMAGE);
    psplat_asset_desc desc = {.only_draws = 1};
    psplat_asset *asset = open_text(packed_text(&p), &desc);
    const psplat_batch *batch = psplat_asset_batch(asset, 0);
    assert_true(!batch->texcoords && batch->has_texcoord && batch->material.textures[0].image == 1);
    assert_int_equal(psplat_asset_get_image(asset, 0)->size, 8);
    psplat_asset_destroy(asset);
}

int test_asset_textured_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_coordinates),
        cmocka_unit_test(test_forms),
        cmocka_unit_test(test_versions),
        cmocka_unit_test(test_refused_coordinates),
        cmocka_unit_test(test_slots),
        cmocka_unit_test(test_untextured),
        cmocka_unit_test(test_alpha),
        cmocka_unit_test(test_transform),
        cmocka_unit_test(test_other_sets),
        cmocka_unit_test(test_sources),
        cmocka_unit_test(test_refused_textures),
        cmocka_unit_test(test_refused_images),
        cmocka_unit_test(test_views),
        cmocka_unit_test(test_views_that_leave),
        cmocka_unit_test(test_shared_bytes),
        cmocka_unit_test(test_files),
        cmocka_unit_test(test_out_of_memory),
        cmocka_unit_test(test_only_draws),
        cmocka_unit_test(test_example),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

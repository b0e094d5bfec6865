/* SPDX-License-Identifier: MIT
 *
 * textured_fixture.h - assets of one or two textured splats, and their pictures by the reference.
 * Include this file after cmocka.h.
 */
#ifndef PHONGSPLAT_TEST_TEXTURED_FIXTURE_H
#define PHONGSPLAT_TEST_TEXTURED_FIXTURE_H

#include "near.h"
#include "packed.h"
#include "reference_view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIZE 32
#define FLOAT_STEP 1.2e-7 /* colours are returned as floats of at most 1 */
#define HEAD "\"version\":3,\"clipLines\":0,\"depthTolerance\":0"
#define STILL HEAD ",\"positionExtent\":[0,0,0]"
#define IMAGE "{\"uri\":\"data:;base64,AQID\"}"

/* ---- documents ------------------------------------------------------------------------------ */

/* Splats in one primitive; every array has room for two. */
typedef struct plate {
    double positions[6], normals[6], rotations[8], radii[4];
    double at[4], u[4], v[4], uu[4], uv[4], vv[4], fields[6], colors[8], orm[6], emissive[6];
    int is_second, has_field, has_colors, has_orm, has_emissive;
    const char *extension, *material, *sampler;
} plate;

/* Returns a disc of radius 1 in the plane z = 0 with T = (u, v) and an unlit material with a base
 * colour texture. */
static inline plate disc(void) {
    plate p = {.radii = {1, 1, 1, 1},
               .u = {1, 0, 1, 0},
               .v = {0, 1, 0, 1},
               .colors = {1, 1, 1, 1, 1, 1, 1, 1},
               .extension = STILL,
               .material = "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}},"
                           "\"extensions\":{\"KHR_materials_unlit\":{}}}",
               .sampler = ""};
    for (int i = 0; i < 2; ++i) p.normals[3 * i + 2] = p.rotations[4 * i + 3] = 1;
    return p;
}

static inline psplat_asset *open_plate(const plate *p, size_t count) {
    const packed_attribute all[] = {
        {"POSITION", PACKED_FLOAT, 3, 0, p->positions},
        {"NORMAL", PACKED_FLOAT, 3, 0, p->normals},
        {"ROTATION", PACKED_FLOAT, 4, 0, p->rotations},
        {"SCALE", PACKED_FLOAT, 2, 0, p->radii},
        {"TEXCOORD_0", PACKED_FLOAT, 2, 0, p->at},
        {"TEXCOORD_U", PACKED_FLOAT, 2, 0, p->u},
        {"TEXCOORD_V", PACKED_FLOAT, 2, 0, p->v},
        {p->is_second ? "TEXCOORD_UU" : NULL, PACKED_FLOAT, 2, 0, p->uu},
        {p->is_second ? "TEXCOORD_UV" : NULL, PACKED_FLOAT, 2, 0, p->uv},
        {p->is_second ? "TEXCOORD_VV" : NULL, PACKED_FLOAT, 2, 0, p->vv},
        {p->has_field ? "NORMAL_FIELD" : NULL, PACKED_FLOAT, 3, 0, p->fields},
        {p->has_colors ? "COLOR_0" : NULL, PACKED_FLOAT, 4, 0, p->colors},
        {p->has_orm ? "OCCLUSION_ROUGHNESS_METALLIC" : NULL, PACKED_FLOAT, 3, 0, p->orm},
        {p->has_emissive ? "EMISSIVE" : NULL, PACKED_FLOAT, 3, 0, p->emissive}};
    char members[400];
    packed document = packed_default();
    size_t used = 0;
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        if (all[i].name) document.attributes[used++] = all[i];
    snprintf(members, sizeof members,
             "\"textures\":[{\"source\":0,\"sampler\":0},{\"source\":1,\"sampler\":0},"
             "{\"source\":2,\"sampler\":0},{\"source\":3,\"sampler\":0},"
             "{\"source\":4,\"sampler\":0}],\"samplers\":[{%s}],"
             "\"images\":[" IMAGE "," IMAGE "," IMAGE "," IMAGE "," IMAGE "]",
             p->sampler);
    document.count = count;
    document.extension = p->extension;
    document.material = p->material;
    document.members = members;
    char *text = packed_text(&document);
    psplat_asset *asset = NULL;
    psplat_error error;
    if (psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error))
        fail_msg("%s", error.text);
    free(text);
    return asset;
}

/* ---- pictures ------------------------------------------------------------------------------- */

/* The splats' plane z = 0 from -1 to 1. */
static inline psplat_view front_view(void) {
    psplat_view view = camera_view(SIZE, SIZE);
    camera_look(&view, (double[]){0, 0, 20}, (double[]){0, 0, 0});
    camera_parallel(&view, 1, 10, 30);
    view.shading = PSPLAT_SHADING_UNLIT;
    return view;
}

/* Returns the scene's x, or y, at the middle of a pixel of front_view. */
static inline double middle(int pixel) {
    return 2 * (pixel + 0.5) / SIZE - 1;
}

static inline picture draw(const plate *p, size_t count, const psplat_pixels *images,
                           size_t image_count, const double transform[16],
                           const psplat_view *view) {
    psplat_asset *asset = open_plate(p, count);
    psplat_reference_scene scene = {.asset = asset, .images = images, .image_count = image_count};
    if (transform) memcpy(scene.transform, transform, sizeof scene.transform);
    picture drawn = picture_of_scene(&scene, view);
    psplat_asset_destroy(asset);
    return drawn;
}

/* Calls check with the first colour of every covered pixel and its T = (x, y) of a disc. */
static inline void each(const picture *p, double (*expected)(double x, double y),
                        double tolerance) {
    size_t covered = 0;
    for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x) {
            int at = y * SIZE + x;
            if (!p->image.count[at]) continue;
            ++covered;
            assert_near((double)p->image.color[4 * at], expected(middle(x), middle(y)), tolerance);
        }
    assert_true(covered > SIZE * SIZE / 2);
}

/* Returns an sRGB-encoded byte in linear light. */
static inline double decoded(int encoded) {
    double x = encoded / 255.0;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

static const uint8_t leaning[4] = {200, 90, 230, 255}; /* to the right and down */
static const uint8_t black_white[8] = {0, 0, 0, 255, 255, 255, 255, 255};

#endif

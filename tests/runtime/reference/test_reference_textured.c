/* SPDX-License-Identifier: MIT
 *
 * test_reference_textured.c - tests textures of the reference rasteriser (spec 3.11) against closed
 * forms, and on random splats, images and views against another way to find everything: texels
 * weighed by tents over the plane, mipmaps as integrals, and derivatives as differences between
 * pictures that are shifted by a little.
 */
#include "reference_view.h"

#include "packed.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "near.h"

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
static plate disc(void) {
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

static psplat_asset *open_plate(const plate *p, size_t count) {
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
static psplat_view front_view(void) {
    psplat_view view = camera_view(SIZE, SIZE);
    camera_look(&view, (double[]){0, 0, 20}, (double[]){0, 0, 0});
    camera_parallel(&view, 1, 10, 30);
    view.shading = PSPLAT_SHADING_UNLIT;
    return view;
}

/* Returns the scene's x, or y, at the middle of a pixel of front_view. */
static double middle(int pixel) {
    return 2 * (pixel + 0.5) / SIZE - 1;
}

static picture draw(const plate *p, size_t count, const psplat_pixels *images, size_t image_count,
                    const double transform[16], const psplat_view *view) {
    psplat_asset *asset = open_plate(p, count);
    psplat_reference_scene scene = {.asset = asset, .images = images, .image_count = image_count};
    if (transform) memcpy(scene.transform, transform, sizeof scene.transform);
    picture drawn = picture_of_scene(&scene, view);
    psplat_asset_destroy(asset);
    return drawn;
}

/* Calls check with the first colour of every covered pixel and its T = (x, y) of a disc. */
static void each(const picture *p, double (*expected)(double x, double y), double tolerance) {
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

/* ---- samplers ------------------------------------------------------------------------------- */

static const uint8_t black_white[8] = {0, 0, 0, 255, 255, 255, 255, 255};

static double clamped(double x, double y) {
    (void)y;
    return fmin(fmax(2 * (2 * x) - 0.5, 0), 1);
}

/* Texels 0 1 0 1 ..., of which the first has its middle at 0. */
static double repeated(double x, double y) {
    double at = 2 * (2 * x) - 0.5;
    (void)y;
    return 1 - fabs(at - 2 * floor(at / 2) - 1);
}

/* Texels 0 1 1 0 0 1 1 0 ... */
static double mirrored(double x, double y) {
    double at = 2 * (2 * x) - 0.5, rest = at - 4 * floor(at / 4);
    (void)y;
    return rest < 1 ? rest : rest < 2 ? 1 : rest < 3 ? 3 - rest : 0;
}

static double squares(double x, double y) {
    (void)y;
    return fabs(fmod(floor(2 * (2 * x)), 2));
}

static void check_sampler(const char *sampler, double (*expected)(double x, double y)) {
    const psplat_pixels image = {.rgba = black_white, .width = 2, .height = 1};
    psplat_view view = front_view();
    plate p = disc();
    p.sampler = sampler;
    p.u[0] = 2;
    picture drawn = draw(&p, 1, &image, 1, NULL, &view);
    /* Floats of (u, v), of which a picture holds 1e-16, and of the colour. */
    each(&drawn, expected, FLOAT_STEP);
    picture_free(&drawn);
}

static void test_wraps(void **state) {
    (void)state;
    check_sampler("\"wrapS\":33071", clamped);
    check_sampler("", repeated);
    check_sampler("\"wrapS\":33648", mirrored);
    check_sampler("\"magFilter\":9728", squares);
}

/* The upper left corner of an image is at (0, 0): the rows of the image go down, V goes down. */
static double rows_down(double x, double y) {
    (void)x;
    return y < 0.25 ? 0 : y > 0.75 ? 1 : 2 * (y - 0.25);
}

static void test_rows(void **state) {
    (void)state;
    const psplat_pixels image = {.rgba = black_white, .width = 1, .height = 2};
    psplat_view view = front_view();
    plate p = disc();
    p.sampler = "\"wrapT\":33071";
    picture drawn = draw(&p, 1, &image, 1, NULL, &view);
    each(&drawn, rows_down, FLOAT_STEP);
    picture_free(&drawn);
}

/* T' = (0.5 + 3 y', ...) with the quarter turn that takes (1, 0) to (0, -1). */
static double moved(double x, double y) {
    (void)x;
    return fmin(fmax(2 * (0.25 + 1.5 * y) - 0.5, 0), 1);
}

static void test_transform(void **state) {
    (void)state;
    const psplat_pixels image = {.rgba = black_white, .width = 2, .height = 1};
    psplat_view view = front_view();
    plate p = disc();
    p.sampler = "\"wrapS\":33071";
    p.material = "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"extensions\":{"
                 "\"KHR_texture_transform\":{\"offset\":[0.25,7],\"rotation\":1.5707963267948966,"
                 "\"scale\":[2,1.5]}}}},\"extensions\":{\"KHR_materials_unlit\":{}}}";
    picture drawn = draw(&p, 1, &image, 1, NULL, &view);
    each(&drawn, moved, 2 * FLOAT_STEP);
    picture_free(&drawn);
}

/* ---- minification --------------------------------------------------------------------------- */

static double half(double x, double y) {
    (void)x, (void)y;
    return 0.5;
}

static double three_quarters(double x, double y) {
    double s = 64 * x * 4 - 0.5;
    (void)y;
    /* Level 1/2 is halfway between the texels, of which every other is white, and their mean. */
    return 0.5 * (1 - fabs(s - 2 * floor(s / 2) - 1)) + 0.25;
}

/* A board of 8 x 8 squares: where a pixel spans two texels, it shows their mean in linear light. */
static void test_board(void **state) {
    (void)state;
    uint8_t board[8 * 8 * 4];
    for (int i = 0; i < 64; ++i) memset(board + 4 * i, (i / 8 + i) % 2 ? 255 : 0, 4);
    const psplat_pixels image = {.rgba = board, .width = 8, .height = 8};
    psplat_view view = front_view();
    for (double scale = 1; scale < 20; scale *= 3) {
        plate p = disc();
        p.u[0] = p.v[1] = scale * SIZE / 8;
        picture drawn = draw(&p, 1, &image, 1, NULL, &view);
        each(&drawn, half, FLOAT_STEP);
        picture_free(&drawn);
    }
}

/* Between two levels: a pixel spans the square root of two texels. The larger of both derivatives
 * counts. */
static void test_levels(void **state) {
    (void)state;
    uint8_t stripes[16];
    for (int i = 0; i < 4; ++i) memset(stripes + 4 * i, i % 2 ? 255 : 0, 4);
    const psplat_pixels image = {.rgba = stripes, .width = 4, .height = 1};
    psplat_view view = front_view();
    view.width = view.height = SIZE;
    plate p = disc();
    /* 4 texels times 64 over half of SIZE pixels are 16 texels a pixel; the view is enlarged. */
    p.u[0] = 64;
    camera_parallel(&view, sqrt(2) / 16, 10, 30);
    picture drawn = draw(&p, 1, &image, 1, NULL, &view);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double x = middle(i % SIZE) * sqrt(2) / 16;
        assert_near((double)drawn.image.color[4 * i], three_quarters(x, 0), 4e-7);
    }
    picture_free(&drawn);
}

/* ---- materials ------------------------------------------------------------------------------ */

static double decoded(int encoded) {
    double x = encoded / 255.0;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

/* Constant textures multiply what the splat and the material say, as eq. (4d) says. */
static void test_finish(void **state) {
    (void)state;
    const psplat_pixels absent = {.rgba = NULL};
    static const uint8_t texels[4][4] = {
        {200, 100, 50, 255}, {9, 120, 220, 255}, {90, 7, 7, 255}, {30, 60, 240, 255}};
    psplat_pixels images[4];
    for (int i = 0; i < 4; ++i)
        images[i] = (psplat_pixels){.rgba = texels[i], .width = 1, .height = 1};
    psplat_view view = front_view();
    view.shading = PSPLAT_SHADING_LIT;
    for (int k = 0; k < 3; ++k) view.ambient[k] = 0.3f;
    plate p = disc();
    p.has_orm = p.has_emissive = p.has_colors = 1;
    double color[4] = {0.9, 0.8, 0.7, 1}, orm[3] = {0.5, 0.75, 0.625};
    memcpy(p.colors, color, sizeof color);
    memcpy(p.orm, orm, sizeof orm);
    for (int k = 0; k < 3; ++k) p.emissive[k] = 0.25;
    p.material =
        "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},\"metallicFactor\":0.8,"
        "\"metallicRoughnessTexture\":{\"index\":1}},"
        "\"occlusionTexture\":{\"index\":2,\"strength\":0.6},\"emissiveFactor\":[1,1,1],"
        "\"emissiveTexture\":{\"index\":3}}";
    picture textured = draw(&p, 1, images, 4, NULL, &view);
    picture bare = draw(&p, 1, &absent, 1, NULL, &view);
    for (int k = 0; k < 3; ++k) {
        p.colors[k] *= decoded(texels[0][k]);
        p.emissive[k] *= decoded(texels[3][k]);
    }
    p.orm[0] *= 1 + 0.6 * (90 / 255.0 - 1);
    p.orm[1] *= 120 / 255.0;
    p.orm[2] *= 220 / 255.0;
    picture expected = draw(&p, 1, &absent, 1, NULL, &view);
    double difference = 0;
    for (int i = 0; i < 4 * SIZE * SIZE; ++i) {
        /* The factors of the second asset are rounded to floats. */
        assert_near((double)textured.image.color[i], (double)expected.image.color[i], 4e-7);
        difference =
            fmax(difference, fabs((double)(bare.image.color[i] - expected.image.color[i])));
    }
    assert_true(difference > 0.1);
    picture_free(&textured);
    picture_free(&bare);
    picture_free(&expected);
}

/* ---- normals -------------------------------------------------------------------------------- */

static const uint8_t leaning[4] = {200, 90, 230, 255}; /* to the right and down */

/* Expects the normal of the middle of the plate to be along n, under a transform of the scene. */
static void check_normal(const plate *from, const double transform[16], const psplat_view *view,
                         const double n[3]) {
    const psplat_pixels image = {.rgba = leaning, .width = 1, .height = 1};
    plate p = *from;
    picture drawn = draw(&p, 1, &image, 1, transform, view);
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const float *found = drawn.image.color + 4 * (SIZE / 2 * SIZE + SIZE / 2);
    for (int i = 0; i < 3; ++i)
        assert_near((double)found[i], 0.5 + 0.5 * n[i] / length, 2 * FLOAT_STEP);
    picture_free(&drawn);
}

/* A normal map leans with the image, however the image lies on the surface, mirrored or not. */
static void test_normals(void **state) {
    (void)state;
    double x = 2 * 200 / 255.0 - 1, y = 2 * 90 / 255.0 - 1, z = 2 * 230 / 255.0 - 1;
    const struct {
        double u[2], v[2], normal[3];
    } charts[] = {
        {{1, 0}, {0, -1}, {x, y, z}},   /* upright: V goes down, and green goes up */
        {{-1, 0}, {0, -1}, {-x, y, z}}, /* mirrored */
        {{1, 0}, {0, 1}, {x, -y, z}},   /* upside down and mirrored */
        {{0, 1}, {1, 0}, {-y, x, z}},   /* turned */
        {{0, -1}, {1, 0}, {y, x, z}},   /* turned and mirrored */
        /* S1 = 3 u + 3 v and S2 = -v / 2: where S2 stays, only u changes, so that t is x, and b is
         * y although S1 changes along it. */
        {{3, 0}, {3, -0.5}, {x, y, z}},
        {{1, 1}, {1, 1}, {0, 0, 1}}, /* no plane */
        {{0, 0}, {0, 0}, {0, 0, 1}},
    };
    psplat_view view = front_view();
    view.shading = PSPLAT_SHADING_NORMAL;
    for (size_t i = 0; i < sizeof charts / sizeof *charts; ++i) {
        plate p = disc();
        p.material = "{\"normalTexture\":{\"index\":0}}";
        memcpy(p.u, charts[i].u, sizeof charts[i].u);
        memcpy(p.v, charts[i].v, sizeof charts[i].v);
        check_normal(&p, NULL, &view, charts[i].normal);
    }
    plate p = disc();
    p.material = "{\"normalTexture\":{\"index\":0,\"scale\":0.5}}";
    p.v[1] = -1;
    check_normal(&p, NULL, &view, (double[]){x / 2, y / 2, z});
    /* A quarter turn of the image: what was right is down. */
    p.material = "{\"normalTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":"
                 "{\"rotation\":1.5707963267948966}}}}";
    check_normal(&p, NULL, &view, (double[]){y, -x, z});
}

/* A mirrored node mirrors what the map shows, another scale of x changes its slope, and from behind
 * all of it is negated. */
static void test_placed_normals(void **state) {
    (void)state;
    double x = 2 * 200 / 255.0 - 1, y = 2 * 90 / 255.0 - 1, z = 2 * 230 / 255.0 - 1;
    const double mirror[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const double wide[16] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    psplat_view view = front_view();
    view.shading = PSPLAT_SHADING_NORMAL;
    plate p = disc();
    p.v[1] = -1;
    p.material = "{\"doubleSided\":true,\"normalTexture\":{\"index\":0}}";
    check_normal(&p, mirror, &view, (double[]){-x, y, z});
    check_normal(&p, wide, &view, (double[]){x, y, z}); /* tangents are made unit */
    camera_look(&view, (double[]){0, 0, -20}, (double[]){0, 0, 0});
    /* The eye sees -x to its right and -z before it. */
    check_normal(&p, NULL, &view, (double[]){x, -y, z});
}

/* On a curved surface that rises towards +x, the tangent rises too. */
static void test_curved_normal(void **state) {
    (void)state;
    double x = 2 * 200 / 255.0 - 1, y = 2 * 90 / 255.0 - 1, z = 2 * 230 / 255.0 - 1;
    psplat_view view = front_view();
    view.shading = PSPLAT_SHADING_NORMAL;
    const psplat_pixels image = {.rgba = leaning, .width = 1, .height = 1};
    plate p = disc();
    p.v[1] = -1;
    p.material = "{\"normalTexture\":{\"index\":0}}";
    p.has_field = 1;
    p.fields[0] = -0.8; /* h = 0.4 u^2 */
    p.extension = STILL ",\"curved\":true";
    picture drawn = draw(&p, 1, &image, 1, NULL, &view);
    for (int px = SIZE / 4; px < 3 * SIZE / 4; ++px) {
        double slope = 0.8 * middle(px), c = 1 / sqrt(1 + slope * slope), s = slope * c;
        const double n[3] = {x * c - z * s, y, x * s + z * c};
        double length = sqrt(x * x + y * y + z * z);
        for (int i = 0; i < 3; ++i)
            assert_near((double)drawn.image.color[4 * (SIZE / 2 * SIZE + px) + i],
                        0.5 + 0.5 * n[i] / length, 2 * FLOAT_STEP);
    }
    picture_free(&drawn);
}

/* ---- masks ---------------------------------------------------------------------------------- */

#define MASKED(cutoff)                                                                             \
    "{\"alphaMode\":\"MASK\",\"alphaCutoff\":" cutoff ",\"doubleSided\":true,"                     \
    "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}},"                               \
    "\"extensions\":{\"KHR_materials_unlit\":{}}}"

/* Alpha grows from 0 to 1 between x = 0.25 and 0.75; what is behind shows where it is below the
 * cutoff. The splat behind has its texture coordinates where alpha is 1. */
static void test_mask(void **state) {
    (void)state;
    static const uint8_t texels[8] = {255, 255, 255, 0, 255, 255, 255, 255};
    const psplat_pixels image = {.rgba = texels, .width = 2, .height = 1};
    psplat_view view = front_view();
    plate p = disc();
    p.extension = HEAD ",\"positionExtent\":[0,0,1]";
    p.material = MASKED("0.25");
    p.sampler = "\"wrapS\":33071";
    p.has_colors = 1;
    p.colors[3] = 0.5; /* so that the texture's alpha has to be a half, where x is 0.5 */
    p.positions[5] = -1;
    p.radii[0] = p.radii[1] = 3, p.radii[2] = p.radii[3] = 3;
    p.u[0] = 3, p.v[1] = 3;
    p.at[2] = 1, p.u[2] = p.v[3] = 0;
    for (int k = 4; k < 7; ++k) p.colors[k] = 0.125;
    picture drawn = draw(&p, 2, &image, 1, NULL, &view);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double alpha = 0.5 * fmin(fmax(2 * middle(i % SIZE) - 0.5, 0), 1);
        int is_there = alpha >= 0.25;
        assert_int_equal(drawn.image.count[i], 1);
        assert_int_equal(drawn.image.splat[i], is_there ? 0 : 1);
        assert_near((double)drawn.image.color[4 * i], is_there ? 1 : 0.125, FLOAT_STEP);
        assert_near(drawn.image.alpha_tie[i], fabs(alpha - 0.25), 1e-6);
    }
    picture_free(&drawn);
    p.material = MASKED("1.5");
    drawn = draw(&p, 2, &image, 1, NULL, &view);
    assert_int_equal(picture_covered(&drawn), 0);
    picture_free(&drawn);
}

/* A masked splat between light and plane casts its shadow where it is there. Light comes from
 * above, and the eye looks up from below at the two-sided plane at z = -1. */
static void test_masked_shadow(void **state) {
    (void)state;
    static const uint8_t texels[8] = {255, 255, 255, 0, 255, 255, 255, 255};
    const psplat_pixels image = {.rgba = texels, .width = 2, .height = 1};
    psplat_view view = front_view();
    view.shading = PSPLAT_SHADING_LIT;
    view.culling = PSPLAT_CULL_NEVER;
    camera_look(&view, (double[]){0, 0, 20}, (double[]){0, 0, 0});
    view.lights[0].casts_shadow = 1;
    view.lights[0].direction[0] = 1; /* from the left and above: shadows lie 1 to the right */
    view.lights[0].direction[1] = 0;
    view.lights[0].direction[2] = -1;
    plate p = disc();
    p.extension = "\"version\":3,\"clipLines\":0,\"depthTolerance\":0.01,"
                  "\"positionExtent\":[0,0,1]";
    p.material = "{\"alphaMode\":\"MASK\",\"doubleSided\":true,"
                 "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}";
    p.sampler = "\"wrapS\":33071,\"magFilter\":9728";
    p.positions[5] = -1;
    p.radii[0] = p.radii[1] = 0.75, p.radii[2] = p.radii[3] = 4;
    p.u[0] = 0.75, p.at[0] = 0.5; /* there where x >= 0 */
    p.at[2] = 1, p.u[2] = p.v[3] = 0;
    picture drawn = draw(&p, 2, &image, 1, NULL, &view);
    size_t dark = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double x = middle(i % SIZE), y = middle(i / SIZE);
        if (drawn.image.splat[i] != 1) continue;
        double from = x - 1; /* where the light passed the first splat */
        int is_dark = from >= 0 && from * from + y * y <= 0.75 * 0.75;
        assert_true((drawn.image.color[4 * i] == 0) == is_dark);
        if (is_dark) ++dark;
    }
    assert_int_equal(dark, 0); /* x >= 1 is outside the view: the left half casts none */
    picture_free(&drawn);
    p.u[0] = -0.75; /* there where x <= 0 */
    drawn = draw(&p, 2, &image, 1, NULL, &view);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double from = middle(i % SIZE) - 1, y = middle(i / SIZE);
        if (drawn.image.splat[i] != 1) continue;
        int is_dark = from <= 0 && from * from + y * y <= 0.75 * 0.75;
        assert_true((drawn.image.color[4 * i] == 0) == is_dark);
        if (is_dark) ++dark;
    }
    assert_true(dark > 20);
    picture_free(&drawn);
}

/* ---- modes and the filter ------------------------------------------------------------------- */

/* The comparison modes show the texture of the whole splat: its mean where the splat spans the
 * image, and the texel at the centre where it spans little of it. */
static void test_modes(void **state) {
    (void)state;
    const psplat_pixels image = {.rgba = black_white, .width = 2, .height = 1};
    const psplat_mode modes[] = {PSPLAT_MODE_GAUSSIAN, PSPLAT_MODE_FLAT};
    const double slopes[] = {1, 0.5 * 1.4142135623730951, 0.1}, shown[] = {0.5, 0.75, 1};
    for (int m = 0; m < 2; ++m)
        for (int i = 0; i < 3; ++i) {
            psplat_view view = front_view();
            view.mode = modes[m];
            plate p = disc();
            p.at[0] = 0.75;
            p.u[0] = slopes[i], p.v[1] = 0;
            picture drawn = draw(&p, 1, &image, 1, NULL, &view);
            for (int k = 0; k < SIZE * SIZE; ++k)
                if (drawn.image.count[k])
                    assert_near((double)drawn.image.color[4 * k], shown[i], 4e-7);
            picture_free(&drawn);
        }
}

/* A splat of a tenth of a pixel is drawn as wide as a pixel, and so is its part of the image: two
 * of four texels, whose mean is black on the left, where all four together are grey. */
static void test_widened(void **state) {
    (void)state;
    uint8_t texels[16];
    for (int i = 0; i < 4; ++i) memset(texels + 4 * i, i < 2 ? 0 : 255, 4);
    const psplat_pixels image = {.rgba = texels, .width = 4, .height = 1};
    psplat_view view = front_view();
    view.no_filter = 0;
    plate p = disc();
    double pixel = 2.0 / SIZE, center = middle(SIZE / 2);
    p.extension = "\"version\":3,\"clipLines\":0,\"depthTolerance\":5,\"positionExtent\":"
                  "[0.03125,0.03125,1]";
    p.sampler = "\"wrapS\":33071";
    p.positions[0] = p.positions[1] = center;
    p.positions[5] = -1;
    p.radii[0] = p.radii[1] = pixel / 10, p.radii[2] = p.radii[3] = 100;
    p.at[0] = 0.25, p.u[0] = 0.5, p.v[1] = 0;
    p.at[2] = 0.875, p.u[2] = p.v[3] = 0;
    picture drawn = draw(&p, 2, &image, 1, NULL, &view);
    int at = SIZE / 2 * SIZE + SIZE / 2;
    assert_int_equal(drawn.image.count[at], 2);
    double behind = exp(-2 * 2 * center * center / 1e4), before = 0.01;
    assert_near((double)drawn.image.color[4 * at], behind / (behind + before), 1e-6);
    picture_free(&drawn);
}

/* ---- random splats -------------------------------------------------------------------------- */

static double between(uint32_t *random, double low, double high) {
    return low + (high - low) * (double)scene_random(random);
}

typedef struct study {
    plate p;
    psplat_view view;
    uint8_t texels[9 * 9 * 4];
    int width, height, wrap[2];
} study;

static void random_plate(study *s, uint32_t *random) {
    static const int wraps[] = {10497, 33071, 33648};
    static char sampler[2][60];
    s->p = disc();
    plate *p = &s->p;
    p->is_second = p->has_field = 1;
    double scale = pow(10, between(random, -1, 1));
    double *const terms[] = {p->at, p->u, p->v, p->uu, p->uv, p->vv};
    for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 2; ++k)
            terms[i][k] = (double)(float)(scale * between(random, -1, 1) * (i < 3 ? 1 : 0.3));
    for (int i = 0; i < 3; ++i) p->fields[i] = between(random, -1, 1);
    p->radii[1] = between(random, 0.3, 1);
    p->extension = scene_random(random) < 0.5f ? STILL : STILL ",\"curved\":true";
    for (int i = 0; i < 2; ++i) s->wrap[i] = (int)between(random, 0, 2.99);
    snprintf(sampler[0], sizeof sampler[0], "\"wrapS\":%d,\"wrapT\":%d", wraps[s->wrap[0]],
             wraps[s->wrap[1]]);
    p->sampler = sampler[0];
    p->material = "{\"doubleSided\":true,\"pbrMetallicRoughness\":{\"baseColorTexture\":{"
                  "\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0.3,-0.2],"
                  "\"rotation\":0.7,\"scale\":[1.25,0.8]}}}}}";
}

static void random_study(study *s, uint32_t *random) {
    random_plate(s, random);
    s->width = (int)between(random, 1, 9.99);
    s->height = (int)between(random, 1, 9.99);
    for (int i = 0; i < s->width * s->height * 4; ++i)
        s->texels[i] = (uint8_t)between(random, 0, 255.99);
    s->view = camera_view(SIZE, SIZE);
    s->view.shading = PSPLAT_SHADING_UNLIT;
    double eye[3], target[3];
    for (int i = 0; i < 3; ++i) {
        eye[i] = between(random, -3, 3);
        target[i] = between(random, -0.3, 0.3);
    }
    eye[2] += eye[2] > 0 ? 2 : -2;
    camera_look(&s->view, eye, target);
    if (scene_random(random) < 0.4f)
        camera_parallel(&s->view, between(random, 0.5, 2), -10, 20);
    else
        camera_perspective(&s->view, between(random, 20, 60), 0.1, 20);
}

/* Draws the study with all points moved by so many pixels. */
static picture draw_moved(const study *s, double x, double y) {
    const psplat_pixels image = {
        .rgba = s->texels, .width = (uint32_t)s->width, .height = (uint32_t)s->height};
    psplat_view view = s->view;
    for (int column = 0; column < 4; ++column) {
        double *m = view.projection + 4 * column;
        m[0] += 2 * x / SIZE * m[3];
        m[1] += 2 * y / SIZE * m[3];
    }
    return draw(&s->p, 1, &image, 1, NULL, &view);
}

/* Returns the image's coordinates at (u, v). */
static void image_at(const plate *p, double u, double v, double st[2]) {
    const double c = cos(0.7), s = sin(0.7);
    double t[2];
    for (int i = 0; i < 2; ++i)
        t[i] = p->at[i] + u * p->u[i] + v * p->v[i] + u * u * p->uu[i] + u * v * p->uv[i] +
               v * v * p->vv[i];
    st[0] = 0.3 + c * 1.25 * t[0] + s * 0.8 * t[1];
    st[1] = -0.2 - s * 1.25 * t[0] + c * 0.8 * t[1];
}

/* Returns the texel that shows at a whole number, found by walking towards the image. */
static int walk(int at, int size, int wrap) {
    if (wrap == 1) return at < 0 ? 0 : at >= size ? size - 1 : at;
    while (at < 0 || at >= size) {
        if (wrap == 0)
            at += at < 0 ? size : -size;
        else
            at = at < 0 ? -1 - at : 2 * size - 1 - at;
    }
    return at;
}

/* Returns the mean of the image over a texel of a level, as an integral over its square. */
static double texel_mean(const study *s, int x, int y, int width, int height) {
    double sum = 0, wide = (double)s->width / width, high = (double)s->height / height;
    for (int row = 0; row < s->height; ++row)
        for (int column = 0; column < s->width; ++column) {
            double a = fmin(column + 1, (x + 1) * wide) - fmax(column, x * wide);
            double b = fmin(row + 1, (y + 1) * high) - fmax(row, y * high);
            if (a <= 0 || b <= 0) continue;
            sum += a * b * decoded(s->texels[4 * (row * s->width + column)]);
        }
    return sum / (wide * high);
}

/* Returns the value between texels of a level, by the tent of each texel that reaches there. */
static double tents(const study *s, const double st[2], int level) {
    int width = s->width >> level ? s->width >> level : 1;
    int height = s->height >> level ? s->height >> level : 1;
    double x = st[0] * width - 0.5, y = st[1] * height - 0.5, sum = 0;
    for (int row = (int)y - 3; row <= (int)y + 3; ++row)
        for (int column = (int)x - 3; column <= (int)x + 3; ++column) {
            double a = 1 - fabs(x - column), b = 1 - fabs(y - row);
            if (a <= 0 || b <= 0) continue;
            sum += a * b *
                   texel_mean(s, walk(column, width, s->wrap[0]), walk(row, height, s->wrap[1]),
                              width, height);
        }
    return sum;
}

static double sampled(const study *s, const double st[2], double texels) {
    int most = (int)floor(log2(s->width > s->height ? s->width : s->height));
    double level = texels > 1 ? fmin(log2(texels), most) : 0;
    int below = (int)level;
    double finer = tents(s, st, below);
    return below < most ? finer + (level - below) * (tents(s, st, below + 1) - finer) : finer;
}

/* Where the level hardly changes: the differences are off by a part of 1e-5 where the surface is
 * not seen along its contour, and a level by little more. */
static size_t check_study(const study *s) {
    const double step = 1e-3;
    picture p = draw_moved(s, 0, 0);
    picture moved_by[4] = {draw_moved(s, step, 0), draw_moved(s, -step, 0), draw_moved(s, 0, step),
                           draw_moved(s, 0, -step)};
    size_t checked = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        int is_clear = p.image.tie[i] > 0.05 && p.image.count[i] == 1;
        if (!is_clear) continue;
        double st[2], at[4][2], most = 0;
        image_at(&s->p, p.image.uv[2 * i], p.image.uv[2 * i + 1], st);
        for (int k = 0; k < 4; ++k)
            image_at(&s->p, moved_by[k].image.uv[2 * i], moved_by[k].image.uv[2 * i + 1], at[k]);
        for (int k = 0; k < 4; k += 2)
            most = fmax(most, hypot((at[k][0] - at[k + 1][0]) * s->width,
                                    (at[k][1] - at[k + 1][1]) * s->height) /
                                  (2 * step));
        assert_near((double)p.image.color[4 * i], sampled(s, st, most), 1e-4);
        ++checked;
    }
    picture_free(&p);
    for (int k = 0; k < 4; ++k) picture_free(&moved_by[k]);
    return checked;
}

static void test_random(void **state) {
    (void)state;
    uint32_t random = 2024;
    size_t checked = 0;
    for (int i = 0; i < 60; ++i) {
        study s;
        random_study(&s, &random);
        checked += check_study(&s);
    }
    assert_true(checked > 3000);
}

/* ---- random normals ------------------------------------------------------------------------- */

/* Returns a random transform of the scene, which scales its axes apart and may mirror it. */
static void random_transform(double m[16], uint32_t *random) {
    double mirror = scene_random(random) < 0.5f ? -1 : 1;
    for (int i = 0; i < 16; ++i) m[i] = i % 5 == 0;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            m[4 * column + row] =
                (column ? 1 : mirror) * (between(random, -0.3, 0.3) + (row == column));
}

/* Finds the point in eye space that a pixel shows, from its depth. */
static void unproject(const psplat_view *view, int pixel, double depth, double p[3]) {
    const double *m = view->projection;
    const double at[2] = {middle(pixel % SIZE), middle(pixel / SIZE)};
    double z = 2 * depth - 1;
    p[2] = (m[14] - z * m[15]) / (z * m[11] - m[10]);
    double w = m[11] * p[2] + m[15];
    for (int i = 0; i < 2; ++i) p[i] = (at[i] * w - m[8 + i] * p[2] - m[12 + i]) / m[5 * i];
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalise(double a[3]) {
    double length = sqrt(dot(a, a));
    for (int i = 0; i < 3; ++i) a[i] /= length;
}

/* The changes of the point and of the image's coordinates to the next pixel to the right, and
 * above.
 */
typedef struct change {
    double p[2][3], st[2][2];
} change;

/* Turns a unit normal by eq. (4e), the change of the point with the image's coordinates being found
 * from both changes by pixels. Returns a measure of how well that is known, at most 1. */
static double turn(const change *c, double n[3]) {
    const double x = 2 * 200 / 255.0 - 1, y = 2 * 90 / 255.0 - 1, z = 2 * 230 / 255.0 - 1;
    double determinant = c->st[0][0] * c->st[1][1] - c->st[0][1] * c->st[1][0];
    double sizes = hypot(c->st[0][0], c->st[0][1]) * hypot(c->st[1][0], c->st[1][1]), t[3], b[3];
    for (int i = 0; i < 3; ++i) {
        t[i] = (c->st[1][1] * c->p[0][i] - c->st[0][1] * c->p[1][i]) / determinant;
        b[i] = (c->st[0][0] * c->p[1][i] - c->st[1][0] * c->p[0][i]) / determinant;
    }
    double along = dot(t, n), up = dot(b, n), size = sqrt(dot(b, b));
    for (int i = 0; i < 3; ++i) t[i] -= along * n[i];
    normalise(t);
    /* Green points against b, as far as b is perpendicular to the normal and to t. */
    double across = dot(t, b);
    for (int i = 0; i < 3; ++i) b[i] = -(b[i] - up * n[i] - across * t[i]);
    double left = sqrt(dot(b, b)) / size;
    normalise(b);
    for (int i = 0; i < 3; ++i) n[i] = x * t[i] + y * b[i] + z * n[i];
    normalise(n);
    return fmin(fabs(determinant) / sizes, left);
}

/* Draws the study moved by so many pixels, with its normal texture or without. */
static picture draw_bumps(const study *s, const double transform[16], double x, double y,
                          int is_bumpy) {
    const psplat_pixels image = {.rgba = leaning, .width = 1, .height = 1};
    psplat_view view = s->view;
    for (int column = 0; column < 4; ++column) {
        double *m = view.projection + 4 * column;
        m[0] += 2 * x / SIZE * m[3];
        m[1] += 2 * y / SIZE * m[3];
    }
    return draw(&s->p, 1, &image, (size_t)is_bumpy, transform, &view);
}

static size_t check_bumps(const study *s, const double transform[16]) {
    const double step = 1e-3, moves[4][2] = {{step, 0}, {-step, 0}, {0, step}, {0, -step}};
    picture smooth = draw_bumps(s, transform, 0, 0, 0), bumpy = draw_bumps(s, transform, 0, 0, 1);
    picture moved_by[4];
    size_t checked = 0;
    for (int k = 0; k < 4; ++k) moved_by[k] = draw_bumps(s, transform, moves[k][0], moves[k][1], 0);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        if (!(smooth.image.tie[i] > 0.2 && smooth.image.count[i])) continue;
        double at[4][2], p[4][3], n[3];
        change c;
        for (int k = 0; k < 4; ++k) {
            const psplat_reference_image *image = &moved_by[k].image;
            image_at(&s->p, image->uv[2 * i], image->uv[2 * i + 1], at[k]);
            psplat_view view = s->view;
            for (int column = 0; column < 4; ++column) {
                double *m = view.projection + 4 * column;
                for (int row = 0; row < 2; ++row) m[row] += 2 * moves[k][row] / SIZE * m[3];
            }
            unproject(&view, i, image->depth[i], p[k]);
        }
        for (int k = 0; k < 2; ++k) {
            for (int row = 0; row < 3; ++row) c.p[k][row] = p[2 * k][row] - p[2 * k + 1][row];
            for (int row = 0; row < 2; ++row) c.st[k][row] = at[2 * k][row] - at[2 * k + 1][row];
        }
        for (int row = 0; row < 3; ++row) n[row] = 2 * (double)smooth.image.color[4 * i + row] - 1;
        normalise(n);
        if (turn(&c, n) < 0.1) continue; /* where differences say little */
        for (int row = 0; row < 3; ++row)
            assert_near((double)bumpy.image.color[4 * i + row], 0.5 + 0.5 * n[row], 2e-4);
        ++checked;
    }
    picture_free(&smooth);
    picture_free(&bumpy);
    for (int k = 0; k < 4; ++k) picture_free(&moved_by[k]);
    return checked;
}

/* Fronts alone are drawn here; test_placed_normals has backs. */
static void test_random_normals(void **state) {
    (void)state;
    uint32_t random = 77;
    size_t checked = 0;
    for (int i = 0; i < 60; ++i) {
        study s;
        double transform[16];
        random_study(&s, &random);
        random_transform(transform, &random);
        s.p.material = "{\"normalTexture\":{\"index\":0,\"extensions\":{"
                       "\"KHR_texture_transform\":{\"offset\":[0.3,-0.2],\"rotation\":0.7,"
                       "\"scale\":[1.25,0.8]}}}}";
        s.view.shading = PSPLAT_SHADING_NORMAL;
        checked += check_bumps(&s, transform);
    }
    assert_true(checked > 3000);
}

/* ---- what is left out ----------------------------------------------------------------------- */

static void test_absent_images(void **state) {
    (void)state;
    const psplat_pixels none = {.width = 1, .height = 1, .texture = 7};
    psplat_view view = front_view();
    plate p = disc();
    picture drawn = draw(&p, 1, &none, 1, NULL, &view);
    assert_true(drawn.image.color[4 * (SIZE / 2 * SIZE + SIZE / 2)] == 1);
    picture_free(&drawn);
    psplat_asset *asset = open_plate(&p, 1);
    float color[4 * SIZE * SIZE];
    psplat_reference_image image = {.color = color};
    psplat_error error;
    const psplat_pixels empty = {.rgba = black_white};
    psplat_reference_scene scene = {.asset = asset, .images = &empty, .image_count = 1};
    assert_int_equal(psplat_reference_draw(&scene, &view, &image, &error), PSPLAT_ERROR_ARGUMENT);
    scene.images = NULL;
    assert_int_equal(psplat_reference_draw(&scene, &view, &image, &error), PSPLAT_ERROR_ARGUMENT);
    psplat_asset_destroy(asset);
}

int test_reference_textured_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_wraps),          cmocka_unit_test(test_rows),
        cmocka_unit_test(test_transform),      cmocka_unit_test(test_board),
        cmocka_unit_test(test_levels),         cmocka_unit_test(test_finish),
        cmocka_unit_test(test_normals),        cmocka_unit_test(test_placed_normals),
        cmocka_unit_test(test_curved_normal),  cmocka_unit_test(test_mask),
        cmocka_unit_test(test_masked_shadow),  cmocka_unit_test(test_modes),
        cmocka_unit_test(test_widened),        cmocka_unit_test(test_random),
        cmocka_unit_test(test_random_normals), cmocka_unit_test(test_absent_images),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

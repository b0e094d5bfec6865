/* SPDX-License-Identifier: MIT
 *
 * scene_asset.c - ready-made scenes; see scene_asset.h.
 */
#include "scene_asset.h"

#include "export/glb_writer.h"
#include "scene_curved.h"
#include "splats/splats.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (memory) return memory;
    fprintf(stderr, "scene: out of memory\n");
    abort();
}

scene scene_blank(size_t count) {
    scene s = {.count = count,
               .material = {.base_color = {1, 1, 1, 1}, .roughness = 0.5f},
               .kernel = {PSPLAT_DEFAULT_KERNEL_SHARPNESS, PSPLAT_DEFAULT_KERNEL_EXPONENT},
               .depth_tolerance = 0.01f};
    s.splats = allocate(count, sizeof *s.splats);
    for (size_t i = 0; i < count; ++i)
        s.splats[i] = (psplat_splat){
            .rotation = {0, 0, 0, 1}, .radius = {1, 1}, .normal = {0, 0, 1}, .color = {1, 1, 1, 1}};
    return s;
}

scene scene_disc(float radius) {
    scene s = scene_blank(1);
    s.splats[0].radius[0] = s.splats[0].radius[1] = radius;
    s.depth_tolerance = 0.01f * radius;
    return s;
}

static void cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static void normalise(double a[3]) {
    double length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    for (int i = 0; i < 3; ++i) a[i] /= length;
}

/* Makes two orthogonal unit axes across the unit vector n, turned about it by angle. */
static void make_axes(const double n[3], double angle, double u[3], double v[3]) {
    double a[3], b[3], helper[3] = {0, 0, 0};
    helper[fabs(n[0]) < 0.6 ? 0 : 1] = 1;
    cross(helper, n, a);
    normalise(a);
    cross(n, a, b);
    for (int i = 0; i < 3; ++i) u[i] = cos(angle) * a[i] + sin(angle) * b[i];
    cross(n, u, v);
}

/* Computes the quaternion of the matrix with columns u, v, u x v. The branch with the largest
 * component keeps the divisor away from 0. */
void scene_set_axes(psplat_splat *splat, const double u[3], const double v[3]) {
    double n[3], q[4];
    cross(u, v, n);
    double square[4] = {1 + u[0] - v[1] - n[2], 1 - u[0] + v[1] - n[2], 1 - u[0] - v[1] + n[2],
                        1 + u[0] + v[1] + n[2]};
    int k = 0;
    for (int i = 1; i < 4; ++i)
        if (square[i] > square[k]) k = i;
    double products[4][4] = {{square[0], u[1] + v[0], u[2] + n[0], v[2] - n[1]},
                             {u[1] + v[0], square[1], v[2] + n[1], n[0] - u[2]},
                             {u[2] + n[0], v[2] + n[1], square[2], u[1] - v[0]},
                             {v[2] - n[1], n[0] - u[2], u[1] - v[0], square[3]}};
    double scale = 0.5 / sqrt(square[k]);
    for (int i = 0; i < 4; ++i) q[i] = products[k][i] * scale;
    for (int i = 0; i < 4; ++i) splat->rotation[i] = (float)q[i];
}

void scene_curve_splat(psplat_splat *splat) {
    const double x = splat->rotation[0], y = splat->rotation[1], z = splat->rotation[2];
    const double w = splat->rotation[3], s = 2 / (x * x + y * y + z * z + w * w);
    const double axes[3][3] = {{1 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)},
                               {s * (x * y - z * w), 1 - s * (x * x + z * z), s * (y * z + x * w)},
                               {s * (x * z + y * w), s * (y * z - x * w), 1 - s * (x * x + y * y)}};
    double local[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i) local[k] += (double)splat->normal[i] * axes[k][i];
    for (int k = 0; k < 2; ++k) splat->shape[k] = (float)(local[k] / local[2]);
    for (int k = 0; k < 3; ++k) splat->shape[2 + k] = splat->gradient[k];
}

void scene_curve(scene *s) {
    for (size_t i = 0; i < s->count; ++i) scene_curve_splat(&s->splats[i]);
}

static void set_normal(psplat_splat *splat, const double n[3]) {
    for (int i = 0; i < 3; ++i) splat->normal[i] = (float)n[i];
}

/* With the centre c on a sphere of radius R around zero, the point c + r (u U + v V) of the tangent
 * plane has the direction N + (r/R) u U + (r/R) v V: the sphere's normals are a linear field. */
scene scene_sphere(size_t count, float radius) {
    scene s = scene_blank(count);
    const double golden_angle = 2.399963229728653;
    /* A Fibonacci lattice of cell area A has no point further than 0.9 sqrt(A) from its lattice. */
    double splat_radius = 0.9 * sqrt(4 * 3.14159265358979323846 / (double)count) * (double)radius;
    for (size_t i = 0; i < count; ++i) {
        double z = 1 - (2 * (double)i + 1) / (double)count;
        double ring = sqrt(1 - z * z), angle = golden_angle * (double)i;
        double n[3] = {ring * cos(angle), ring * sin(angle), z}, u[3], v[3];
        make_axes(n, 0, u, v);
        scene_set_axes(&s.splats[i], u, v);
        set_normal(&s.splats[i], n);
        for (int k = 0; k < 3; ++k) s.splats[i].center[k] = (float)(n[k] * (double)radius);
        for (int k = 0; k < 2; ++k) {
            s.splats[i].radius[k] = (float)splat_radius;
            s.splats[i].gradient[k] = (float)(splat_radius / (double)radius);
        }
    }
    s.depth_tolerance = 0.02f * radius;
    return s;
}

scene scene_cube(float half) {
    scene s = scene_blank(6);
    /* More than sqrt(2) times half, so that the corners are inside. */
    const float radius = half * 1.5f;
    for (size_t i = 0; i < 6; ++i) {
        double n[3] = {0, 0, 0}, u[3] = {0, 0, 0}, v[3];
        n[i / 2] = i % 2 ? -1 : 1;
        u[(i / 2 + 1) % 3] = 1;
        cross(n, u, v);
        scene_set_axes(&s.splats[i], u, v);
        set_normal(&s.splats[i], n);
        for (int k = 0; k < 3; ++k) s.splats[i].center[k] = (float)n[k] * half;
        s.splats[i].radius[0] = s.splats[i].radius[1] = radius;
        s.splats[i].clip_count = 4;
        for (int k = 0; k < 4; ++k) {
            s.splats[i].clip[k][k / 2] = k % 2 ? -1.0f : 1.0f;
            s.splats[i].clip[k][2] = half / radius;
        }
    }
    s.depth_tolerance = 0.01f * half;
    return s;
}

float scene_random(uint32_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return (float)(*state >> 8) / 16777215.0f;
}

static double between(uint32_t *state, double low, double high) {
    return low + (high - low) * (double)scene_random(state);
}

static void random_ellipse(psplat_splat *splat, uint32_t clip_count, uint32_t *state) {
    double n[3], u[3], v[3], normal[3];
    for (int i = 0; i < 3; ++i) n[i] = between(state, -1, 1) + 1e-3;
    normalise(n);
    make_axes(n, between(state, 0, 6.28), u, v);
    scene_set_axes(splat, u, v);
    for (int i = 0; i < 3; ++i) normal[i] = n[i] + between(state, -0.4, 0.4);
    normalise(normal);
    set_normal(splat, normal);
    for (int i = 0; i < 3; ++i) splat->center[i] = (float)between(state, -1, 1);
    splat->radius[0] = (float)between(state, 0.05, 0.3);
    splat->radius[1] = splat->radius[0] * (float)between(state, 0.1, 1);
    for (int i = 0; i < 3; ++i) splat->gradient[i] = (float)between(state, -0.5, 0.5);
    for (int i = 0; i < 3; ++i) splat->color[i] = scene_random(state);
    splat->clip_count = clip_count;
    for (uint32_t k = 0; k < clip_count; ++k) {
        double angle = between(state, 0, 6.28);
        splat->clip[k][0] = (float)cos(angle);
        splat->clip[k][1] = (float)sin(angle);
        splat->clip[k][2] = (float)between(state, 0.1, 0.8);
    }
}

scene scene_ellipses(size_t count, uint32_t max_clip_lines, uint32_t seed) {
    scene s = scene_blank(count);
    uint32_t state = seed * 2654435761u + 1;
    if (state == 0) state = 1;
    for (size_t i = 0; i < count; ++i)
        random_ellipse(&s.splats[i], (uint32_t)(i % (max_clip_lines + 1)), &state);
    s.has_color = 1;
    return s;
}

uint8_t *scene_glb(const scene *s, size_t *size) {
    if (scene_is_curved(s) || s->texcoords || s->seam_lines) return scene_curved_glb(s, size);
    psplat_splats splats = {.kernel = s->kernel,
                            .has_color = s->has_color,
                            .materials = (psplat_material[]){s->material},
                            .material_count = 1};
    psplat_run runs[PSPLAT_MAX_CLIP_LINES + 1];
    splats.runs = runs;
    memcpy(splats.origin, s->origin, sizeof splats.origin);
    splats.splats = allocate(s->count ? s->count : 1, sizeof *splats.splats);
    for (uint32_t lines = 0; lines <= PSPLAT_MAX_CLIP_LINES; ++lines) {
        psplat_run run = {.clip_lines = lines, .depth_tolerance = s->depth_tolerance};
        for (size_t i = 0; i < s->count; ++i)
            if (s->splats[i].clip_count == lines) {
                splats.splats[splats.count++] = s->splats[i];
                ++run.count;
            }
        if (run.count) runs[splats.run_count++] = run;
    }
    psplat_error error;
    uint8_t *data = NULL;
    if (psplat_glb_write(&splats, "scene", NULL, &data, size, &error)) {
        fprintf(stderr, "scene: %s\n", error.text);
        abort();
    }
    free(splats.splats);
    return data;
}

psplat_asset *scene_open(const scene *s) {
    size_t size = 0;
    uint8_t *data = scene_glb(s, &size);
    psplat_asset *asset = NULL;
    psplat_error error;
    if (psplat_asset_open_memory(data, size, NULL, &asset, &error)) {
        fprintf(stderr, "scene: %s (byte %zu)\n", error.text, error.offset);
        abort();
    }
    free(data);
    return asset;
}

void scene_add_textures(scene *s) {
    static const uint8_t rgba[16] = {255, 128, 0,  255, 100, 150, 200, 255,
                                     20,  200, 90, 255, 128, 128, 255, 255};
    static const psplat_pixels image = {.rgba = rgba, .width = 2, .height = 2};
    s->texcoords = allocate(s->count, sizeof *s->texcoords);
    for (size_t i = 0; i < s->count; ++i)
        s->texcoords[i] =
            (psplat_texcoord){.at = {0.1f * (float)i, 0.5f}, .along_u = {1, 0}, .along_v = {0, 1}};
    s->images = &image;
    s->image_count = 1;
    for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot)
        s->material.textures[slot] = (psplat_texture){.image = 1, .strength = 1};
}

/* An image in a file of scene_curved.h: width and height of four bytes each, and the pixels. */
static psplat_pixels decode_image(const psplat_asset_image *image) {
    const uint8_t *bytes = image->data;
    psplat_pixels pixels = {.rgba = bytes + 8};
    for (int i = 3; i >= 0; --i) {
        pixels.width = pixels.width << 8 | bytes[i];
        pixels.height = pixels.height << 8 | bytes[4 + i];
    }
    return pixels;
}

static psplat_result load_image(void *user, const psplat_asset_image *image, int is_srgb,
                                psplat_pixels *pixels, psplat_error *error) {
    (void)user, (void)is_srgb, (void)error;
    *pixels = decode_image(image);
    return PSPLAT_OK;
}

psplat_images scene_images(void) {
    return (psplat_images){.load = load_image};
}

psplat_pixels scene_pixels(const psplat_asset *asset, size_t image) {
    return decode_image(psplat_asset_get_image(asset, image));
}

void scene_free(scene *s) {
    free(s->splats);
    free(s->texcoords);
    *s = (scene){0};
}

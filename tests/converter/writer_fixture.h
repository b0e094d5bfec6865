/* SPDX-License-Identifier: MIT
 *
 * writer_fixture.h - splats with everything that the writer can store, written and read again. A
 * splat is recognised by its place on a grid, in whatever order it comes back.
 */
#ifndef PHONGSPLAT_TESTS_WRITER_FIXTURE_H
#define PHONGSPLAT_TESTS_WRITER_FIXTURE_H

#include "base/region.h"
#include "export/glb_writer.h"
#include "scene/scene.h"
#include "splats/quantize.h"
#include "splats/splat_frame.h"
#include "splats/splats.h"
#include "scene_asset.h"

#include <math.h>
#include <string.h>

enum { GRID = 60000 }; /* steps along an edge of the box */

/* A description of the splats to be made. */
typedef struct written {
    size_t count;
    double size;      /* edge length of the box of centres */
    double origin[3]; /* of the mesh */
    psplat_precision precision;
    float darkest;     /* least colour value, where there are colours */
    double least_part; /* least ratio of the second radius to the first; 0 stands for 0.1 */
    unsigned lines;    /* bit n allows n clip lines; 0 allows all */
    unsigned curved;   /* bit n gives the splats of n clip lines a curved surface */
    int has_shape;     /* of their own, beside the normal field */
    int has_bends;     /* of every second line */
    int has_color, has_slopes, has_gamma;
    int has_gradients, has_surface, has_emissive; /* spec 3.10 */
} written;

static const psplat_precision usual_steps = {.unit = 1.0 / GRID,
                                             .scale_step = 0.04,
                                             .turn_step = 1.0 / 256,
                                             .line_turn_step = 1.0 / 128,
                                             .tilt_step = 1.0 / 512,
                                             .field_step = 1.0 / 512,
                                             .shape_step = 1.0 / 256,
                                             .bend_step = 1.0 / 16,
                                             .line_step = 1.0 / 64,
                                             .normal_bits = 11};

/* Returns the usual quantization steps for a box of this size. */
static inline psplat_precision steps_of(double size) {
    psplat_precision p = usual_steps;
    p.unit *= size;
    return p;
}

static inline void *writer_memory(size_t count, size_t size) {
    void *memory = calloc(count ? count : 1, size);
    assert_non_null(memory);
    return memory;
}

static inline psplat_finish random_finish(const written *w, uint32_t *state) {
    psplat_finish f = {.occlusion = 1, .roughness = 1, .metallic = 1, .emissive = {1, 1, 1}};
    for (int k = 0; k < 3 && w->has_gradients; ++k) {
        f.color_u[k] = 0.4f * (scene_random(state) - 0.5f);
        f.color_v[k] = 0.4f * (scene_random(state) - 0.5f);
    }
    if (w->has_surface) {
        f.occlusion = scene_random(state);
        f.roughness = scene_random(state);
        f.metallic = scene_random(state);
    }
    for (int k = 0; k < 3 && w->has_emissive; ++k) f.emissive[k] = scene_random(state);
    return f;
}

static inline void put_on_grid(const written *w, size_t index, psplat_splat *s, uint32_t *state) {
    const double at[3] = {(double)(index % GRID) / GRID, (double)(index / GRID) / GRID,
                          rint((double)scene_random(state) * GRID) / GRID};
    for (int k = 0; k < 3; ++k) s->center[k] = (float)(at[k] * w->size);
    double part = w->least_part > 0 ? w->least_part : 0.1;
    double radius = (double)s->radius[0] * w->size;
    s->radius[0] = (float)radius;
    s->radius[1] = (float)(radius * pow(part, (double)scene_random(state)));
    for (int k = 0; k < 3; ++k)
        s->color[k] = w->has_color ? w->darkest + (1 - w->darkest) * s->color[k] : 1;
    if (!w->has_gamma) s->gradient[2] = 0;
    if (w->has_slopes) return;
    psplat_region region;
    psplat_splat_region(s, 0, &region);
    for (int k = 0; k < 3; ++k) {
        s->normal[k] = (float)region.n[k];
        s->gradient[k] = 0;
    }
}

/* Gives a splat a random surface. Without a shape of its own its field becomes that of it. */
static inline void put_shape(const written *w, psplat_splat *s, uint32_t *state) {
    psplat_region region;
    psplat_splat_region(s, 0, &region);
    for (int k = 0; k < 5; ++k) s->shape[k] = scene_random(state) - 0.5f;
    if (w->has_shape) {
        s->shape[0] = s->shape[1] = 0;
        return;
    }
    double normal[3], length = 0;
    for (int k = 0; k < 3; ++k) {
        normal[k] =
            region.n[k] + (double)s->shape[0] * region.u[k] + (double)s->shape[1] * region.v[k];
        length += normal[k] * normal[k];
    }
    for (int k = 0; k < 3; ++k) s->normal[k] = (float)(normal[k] / sqrt(length));
    memcpy(s->gradient, s->shape + 2, sizeof s->gradient);
}

/* Returns random splats in runs of one clip class each, rounded to the precision where there is
 * one. */
static inline psplat_splats writer_splats(const written *w, uint32_t seed) {
    scene all = scene_ellipses(w->count, PSPLAT_MAX_CLIP_LINES, seed);
    psplat_splats s = {.count = w->count,
                       .material_count = 1,
                       .kernel = all.kernel,
                       .has_color = w->has_color,
                       .precision = w->precision};
    uint32_t state = seed + 1;
    s.splats = writer_memory(w->count, sizeof *s.splats);
    s.runs = writer_memory(PSPLAT_MAX_CLIP_LINES + 1, sizeof *s.runs);
    s.materials = writer_memory(1, sizeof *s.materials);
    s.materials[0] = all.material;
    memcpy(s.origin, w->origin, sizeof s.origin);
    if (w->has_gradients || w->has_surface || w->has_emissive)
        s.finishes = writer_memory(w->count, sizeof *s.finishes);
    size_t count = 0;
    for (uint32_t lines = 0; lines <= PSPLAT_MAX_CLIP_LINES; ++lines) {
        int curved = w->curved >> lines & 1;
        psplat_run run = {.clip_lines = lines,
                          .depth_tolerance = (float)(w->size / 128),
                          .is_curved = curved,
                          .has_shape = curved && w->has_shape,
                          .has_bends = w->has_bends};
        for (size_t i = 0; i < w->count; ++i) {
            psplat_splat *to = &s.splats[count];
            uint32_t has = all.splats[i].clip_count;
            while (w->lines && !(w->lines >> has & 1)) has = (has + 1) % 5;
            if (has != lines) continue;
            *to = all.splats[i];
            for (uint32_t k = has; k < PSPLAT_MAX_CLIP_LINES; ++k)
                memset(to->clip[k], 0, sizeof to->clip[k]);
            for (uint32_t k = to->clip_count; k < has; ++k) to->clip[k][1] = 1;
            to->clip_count = has;
            put_on_grid(w, count, to, &state);
            if (curved) put_shape(w, to, &state);
            for (uint32_t k = 1; k < has && w->has_bends; k += 2)
                to->bend[k] = 8 * scene_random(&state) - 4;
            if (s.finishes) s.finishes[count] = random_finish(w, &state);
            ++count;
            ++run.count;
        }
        if (run.count) s.runs[s.run_count++] = run;
    }
    scene_free(&all);
    psplat_round_to_precision(&s);
    return s;
}

/* Returns a scene of `meshes` meshes, each at a node of its own. */
static inline psplat_scene writer_scene(size_t meshes) {
    psplat_scene scene = {.mesh_count = meshes, .node_count = meshes, .scene_count = 1};
    scene.meshes = writer_memory(meshes, sizeof *scene.meshes);
    scene.nodes = writer_memory(meshes, sizeof *scene.nodes);
    scene.scenes = writer_memory(1, sizeof *scene.scenes);
    scene.scenes->roots = writer_memory(meshes, sizeof *scene.scenes->roots);
    scene.scenes->root_count = meshes;
    scene.is_made = 1;
    for (uint32_t i = 0; i < meshes; ++i) {
        scene.nodes[i] = (psplat_scene_node){.rotation = {0, 0, 0, 1},
                                             .scale = {1, 1, 1},
                                             .mesh = i,
                                             .camera = PSPLAT_NO_INDEX,
                                             .light = PSPLAT_NO_INDEX};
        scene.scenes->roots[i] = i;
    }
    return scene;
}

/* Returns the file (GLB), which the caller frees. */
static inline uint8_t *writer_file(const psplat_splats *splats, size_t meshes,
                                   const psplat_write_desc *desc, size_t *size) {
    psplat_scene scene = writer_scene(meshes);
    uint8_t *data = NULL;
    psplat_error error = {0};
    if (psplat_scene_write(&scene, splats, desc, &data, size, &error)) fail_msg("%s", error.text);
    psplat_scene_free(&scene);
    return data;
}

static inline psplat_asset *writer_open(const uint8_t *data, size_t size) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    if (psplat_asset_open_memory(data, size, NULL, &asset, &error)) fail_msg("%s", error.text);
    return asset;
}

/* Returns the JSON chunk as a string, which the caller frees. */
static inline char *writer_json(const uint8_t *data) {
    size_t size = data[12] | (size_t)data[13] << 8 | (size_t)data[14] << 16;
    char *text = writer_memory(size + 1, 1);
    memcpy(text, data + 20, size);
    return text;
}

#endif

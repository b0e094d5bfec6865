/* SPDX-License-Identifier: MIT
 *
 * write_scenes.c - writes a GLB of each scene of tests/support into the directory named by the
 * first argument, and compressed ones into that of the second, if any, for the tests in this
 * directory.
 */
#include "export/glb_writer.h"
#include "export/meshopt_codec.h"
#include "splats/splats.h"
#include "scene_asset.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failed;

static void write_file(const char *directory, const char *name, const uint8_t *data, size_t size) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s.glb", directory, name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file)) {
        fprintf(stderr, "cannot write %s\n", path);
        failed = 1;
    }
}

static void write_scene(const char *directory, const char *name, scene s) {
    size_t size = 0;
    uint8_t *data = scene_glb(&s, &size);
    write_file(directory, name, data, size);
    free(data);
    scene_free(&s);
}

/* Makes a scene with everything that a file may hold: colours, a kernel, an origin and each
 * material factor. */
static scene decorated(void) {
    scene s = scene_ellipses(60, 4, 3);
    s.material = (psplat_material){.base_color = {0.1f, 0.2f, 0.3f, 1},
                                   .emissive = {0.5f, 1.0f / 3, 3},
                                   .metallic = 0.25f,
                                   .roughness = 0.7f,
                                   .double_sided = 1};
    s.kernel = (psplat_kernel){1.5f, 3};
    s.origin[0] = 1e6 + 0.125;
    s.origin[2] = -0.1;
    return s;
}

static scene unlit(void) {
    scene s = scene_sphere(50, 1e-3f);
    s.material.unlit = 1;
    s.material.emissive[0] = 2;
    return s;
}

static scene default_material(void) {
    scene s = scene_disc(0.1f);
    s.material.metallic = s.material.roughness = 1;
    return s;
}

/* What write_all varies: the attributes of spec 3.10, curved surfaces, bends and seams. */
enum {
    GRADIENTS = 1,
    SURFACE = 2,
    EMISSIVE = 4,
    CURVED = 8,
    OWN_SHAPE = 16,
    BENT = 32,
    SEAMS = 64
};
enum { SPLATS = 100 };

static void vary(psplat_finish *f, unsigned bits, uint32_t *state) {
    *f = (psplat_finish){.occlusion = 1, .roughness = 1, .metallic = 1, .emissive = {1, 1, 1}};
    for (int k = 0; k < 3 && bits & GRADIENTS; ++k) {
        f->color_u[k] = scene_random(state) - 0.5f;
        f->color_v[k] = scene_random(state) - 0.5f;
    }
    if (bits & SURFACE) f->occlusion = f->metallic = scene_random(state);
    if (bits & EMISSIVE) f->emissive[1] = scene_random(state);
}

/* Curves a splat, whose normal is then that of its axes, and bends its lines. */
static void curve(psplat_splat *s, unsigned bits, uint32_t *state) {
    const float *q = s->rotation;
    const float normal[3] = {2 * (q[0] * q[2] + q[1] * q[3]), 2 * (q[1] * q[2] - q[0] * q[3]),
                             1 - 2 * (q[0] * q[0] + q[1] * q[1])};
    memcpy(s->normal, normal, sizeof normal);
    for (int k = 0; k < 3; ++k) {
        if (bits & CURVED) s->shape[2 + k] = scene_random(state) - 0.5f;
        s->gradient[k] = bits & OWN_SHAPE ? scene_random(state) - 0.5f : s->shape[2 + k];
    }
    for (uint32_t k = 0; k < s->clip_count && bits & BENT; ++k)
        s->bend[k] = 6 * scene_random(state) - 3;
}

/* Splats have all numbers of clip lines, in as many runs. */
static void write_all(const char *directory, const char *name, unsigned bits,
                      const psplat_precision *precision, const psplat_codec *codec) {
    uint32_t state = 5;
    scene all = scene_ellipses(SPLATS, PSPLAT_MAX_CLIP_LINES, 4);
    psplat_splat sorted[SPLATS];
    psplat_finish finishes[SPLATS];
    psplat_run runs[PSPLAT_MAX_CLIP_LINES + 1] = {{0}};
    psplat_splats splats = {.splats = sorted,
                            .finishes = finishes,
                            .runs = runs,
                            .run_count = PSPLAT_MAX_CLIP_LINES + 1,
                            .materials = &all.material,
                            .material_count = 1,
                            .kernel = all.kernel,
                            .has_color = bits & GRADIENTS,
                            .precision = *precision};
    for (uint32_t lines = 0; lines <= PSPLAT_MAX_CLIP_LINES; ++lines)
        for (size_t i = lines; i < SPLATS; i += PSPLAT_MAX_CLIP_LINES + 1) {
            runs[lines].clip_lines = lines;
            runs[lines].count++;
            runs[lines].depth_tolerance = 0.01f;
            runs[lines].is_curved = (bits & CURVED) != 0;
            runs[lines].has_shape = (bits & OWN_SHAPE) != 0;
            runs[lines].has_bends = (bits & BENT) != 0;
            /* Those of one line have none, and those of four have three. */
            runs[lines].seam_lines = bits & SEAMS && lines ? lines - 1 : 0;
            vary(&finishes[splats.count], bits, &state);
            sorted[splats.count] = all.splats[i];
            if (bits & (CURVED | BENT)) curve(&sorted[splats.count], bits, &state);
            ++splats.count;
        }
    const psplat_write_desc desc = {.codec = codec};
    uint8_t *data = NULL;
    size_t size = 0;
    psplat_error error;
    if (psplat_glb_write(&splats, NULL, &desc, &data, &size, &error)) {
        fprintf(stderr, "%s: %s\n", name, error.text);
        failed = 1;
    } else
        write_file(directory, name, data, size);
    free(data);
    scene_free(&all);
}

static const psplat_precision floats, shorts = {.unit = 1.0 / 20000,
                                                .scale_step = 0.04,
                                                .turn_step = 1.0 / 256,
                                                .line_turn_step = 1.0 / 256,
                                                .tilt_step = 1.0 / 512,
                                                .field_step = 1.0 / 512,
                                                .shape_step = 1.0 / 2048,
                                                .line_step = 1.0 / 128,
                                                .bend_step = 1.0 / 64,
                                                .normal_bits = 11};

static const psplat_precision bytes = {.unit = 1.0 / 100,
                                       .scale_step = 0.04,
                                       .turn_step = 1.0 / 16,
                                       .line_turn_step = 1.0 / 16,
                                       .tilt_step = 1.0 / 64,
                                       .field_step = 1.0 / 64,
                                       .shape_step = 1.0 / 128,
                                       .line_step = 1.0 / 16,
                                       .bend_step = 1.0 / 16,
                                       .normal_bits = 8};

/* Writes splats in each precision and, where there is a folder for them, compressed ones. */
static void write_variants(char **folders, int folder_count, const char *what, unsigned bits) {
    static const struct {
        const char *name;
        const psplat_precision *precision;
    } variants[] = {{"float", &floats}, {"short", &shorts}, {"byte", &bytes}};
    for (size_t i = 0; i < sizeof variants / sizeof *variants; ++i) {
        char name[40];
        snprintf(name, sizeof name, "%s_%u_%s", what, bits, variants[i].name);
        write_all(folders[0], name, bits, variants[i].precision, NULL);
#ifdef PSPLAT_MESHOPTIMIZER
        if (folder_count == 2)
            write_all(folders[1], name, bits, variants[i].precision, &psplat_meshopt_codec);
#endif
    }
    (void)folder_count;
}

int main(int argc, char **argv) {
    static const unsigned curved[] = {CURVED,
                                      CURVED | OWN_SHAPE,
                                      BENT,
                                      CURVED | BENT,
                                      SEAMS,
                                      CURVED | BENT | SEAMS,
                                      CURVED | OWN_SHAPE | BENT | GRADIENTS | SURFACE | EMISSIVE};
    if (argc != 2 && argc != 3) return 2;
    write_scene(argv[1], "disc", scene_disc(1));
    write_scene(argv[1], "sphere", scene_sphere(500, 1));
    write_scene(argv[1], "cube", scene_cube(1));
    write_scene(argv[1], "ellipses", scene_ellipses(200, 4, 1));
    write_scene(argv[1], "decorated", decorated());
    write_scene(argv[1], "unlit", unlit());
    write_scene(argv[1], "default_material", default_material());
    for (unsigned bits = 1; bits < CURVED; ++bits)
        write_variants(argv + 1, argc - 1, "finishes", bits);
    for (size_t i = 0; i < sizeof curved / sizeof *curved; ++i)
        write_variants(argv + 1, argc - 1, "curved", curved[i]);
    return failed;
}

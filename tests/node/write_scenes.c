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

/* Writes every attribute of spec 3.10. Bits name those that vary: colour gradients, surface,
 * emissive. Splats have all numbers of clip lines, in as many runs. */
enum { SPLATS = 100 };

static void vary(psplat_finish *f, unsigned bits, uint32_t *state) {
    *f = (psplat_finish){.occlusion = 1, .roughness = 1, .metallic = 1, .emissive = {1, 1, 1}};
    for (int k = 0; k < 3 && bits & 1; ++k) {
        f->color_u[k] = scene_random(state) - 0.5f;
        f->color_v[k] = scene_random(state) - 0.5f;
    }
    if (bits & 2) f->occlusion = f->metallic = scene_random(state);
    if (bits & 4) f->emissive[1] = scene_random(state);
}

static void write_finishes(const char *directory, const char *name, unsigned bits,
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
                            .has_color = bits & 1,
                            .precision = *precision};
    for (uint32_t lines = 0; lines <= PSPLAT_MAX_CLIP_LINES; ++lines)
        for (size_t i = lines; i < SPLATS; i += PSPLAT_MAX_CLIP_LINES + 1) {
            runs[lines].clip_lines = lines;
            runs[lines].count++;
            vary(&finishes[splats.count], bits, &state);
            sorted[splats.count++] = all.splats[i];
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
                                                .line_step = 1.0 / 128,
                                                .normal_bits = 11};

static const psplat_precision bytes = {.unit = 1.0 / 100,
                                       .scale_step = 0.04,
                                       .turn_step = 1.0 / 16,
                                       .line_turn_step = 1.0 / 16,
                                       .tilt_step = 1.0 / 64,
                                       .field_step = 1.0 / 64,
                                       .line_step = 1.0 / 16,
                                       .normal_bits = 8};

int main(int argc, char **argv) {
    if (argc != 2 && argc != 3) return 2;
    write_scene(argv[1], "disc", scene_disc(1));
    write_scene(argv[1], "sphere", scene_sphere(500, 1));
    write_scene(argv[1], "cube", scene_cube(1));
    write_scene(argv[1], "ellipses", scene_ellipses(200, 4, 1));
    write_scene(argv[1], "decorated", decorated());
    write_scene(argv[1], "unlit", unlit());
    write_scene(argv[1], "default_material", default_material());
    for (unsigned bits = 1; bits < 8; ++bits) {
        char name[32];
        snprintf(name, sizeof name, "finishes_%u_float", bits);
        write_finishes(argv[1], name, bits, &floats, NULL);
        snprintf(name, sizeof name, "finishes_%u_short", bits);
        write_finishes(argv[1], name, bits, &shorts, NULL);
        snprintf(name, sizeof name, "finishes_%u_byte", bits);
        write_finishes(argv[1], name, bits, &bytes, NULL);
#ifdef PSPLAT_MESHOPTIMIZER
        if (argc == 3) write_finishes(argv[2], name, bits, &bytes, &psplat_meshopt_codec);
        snprintf(name, sizeof name, "finishes_%u_short", bits);
        if (argc == 3) write_finishes(argv[2], name, bits, &shorts, &psplat_meshopt_codec);
        snprintf(name, sizeof name, "finishes_%u_float", bits);
        if (argc == 3) write_finishes(argv[2], name, bits, &floats, &psplat_meshopt_codec);
#endif
    }
    return failed;
}

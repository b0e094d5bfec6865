/* SPDX-License-Identifier: MIT
 *
 * environment.c - image-based lighting: bakes the integrals of the split sum, eq. (9), into three
 * textures, as BSK04 section 4 precomputes lighting for each normal. prefilter.c integrates, this
 * file uploads.
 */
#include "renderer/frame.h"
#include "gl/gl_state.h"
#include "core/memory.h"
#include "renderer/prefilter.h"

#include <math.h>

/* Sizes of the textures in texels along an edge, chosen by hand. */
enum {
    DIFFUSE_SIZE = 16,
    GLOSSY_SIZE = 64,
    GLOSSY_LEVELS = 5, /* the last one has 4 texels */
    SPLIT_SUM_SIZE = PSPLAT_SPLIT_SUM_SIZE,
    MAX_SIZE = 1024, /* of psplat_environment_desc */
    FACE_FLOATS = 4 * GLOSSY_SIZE * GLOSSY_SIZE
};

static const float largest_half = 65504.0f;

/* Fills one RGBA face of size x size texels. level is that of the glossy map, or -1 for the diffuse
 * map. Level 0 is a mirror, because the lobe of the least alpha is narrower than a texel. */
static void fill_face(const psplat_cube *cube, int face, int size, int level, float *out) {
    double alpha = (double)level / (GLOSSY_LEVELS - 1);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x, out += 4) {
            double direction[3];
            psplat_cube_direction(face, (x + 0.5) / size, (y + 0.5) / size, direction);
            if (level < 0)
                psplat_cube_irradiance(cube, direction, out);
            else if (level == 0)
                psplat_cube_mirror(cube, direction, GLOSSY_SIZE, out);
            else
                psplat_cube_glossy(cube, direction, alpha * alpha, out);
            for (int i = 0; i < 3; ++i) out[i] = fminf(out[i], largest_half);
            out[3] = 1.0f;
        }
}

static void upload_face(const psplat_gl *gl, int face, int level, int size, const float *texels) {
    gl->TexSubImage2D(GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)face, level, 0, 0, size, size,
                      GL_RGBA, GL_FLOAT, texels);
}

static psplat_result make_diffuse(psplat_renderer *renderer, const psplat_cube *cube,
                                  float *staging, psplat_gl_texture *texture, psplat_error *error) {
    psplat_gl_texture_desc desc = {.texel = PSPLAT_TEXEL_RGBA16F,
                                   .width = DIFFUSE_SIZE,
                                   .height = DIFFUSE_SIZE,
                                   .is_cube = 1,
                                   .is_linear = 1};
    psplat_result result = psplat_gl_texture_create(&renderer->gl, &renderer->memory.environments,
                                                    &desc, texture, error);
    for (int face = 0; face < 6 && result == PSPLAT_OK; ++face) {
        fill_face(cube, face, DIFFUSE_SIZE, -1, staging);
        upload_face(&renderer->gl, face, 0, DIFFUSE_SIZE, staging);
    }
    return result;
}

static psplat_result make_glossy(psplat_renderer *renderer, const psplat_cube *cube, float *staging,
                                 psplat_gl_texture *texture, psplat_error *error) {
    psplat_gl_texture_desc desc = {.texel = PSPLAT_TEXEL_RGBA16F,
                                   .width = GLOSSY_SIZE,
                                   .height = GLOSSY_SIZE,
                                   .levels = GLOSSY_LEVELS,
                                   .is_cube = 1,
                                   .is_linear = 1};
    psplat_result result = psplat_gl_texture_create(&renderer->gl, &renderer->memory.environments,
                                                    &desc, texture, error);
    for (int level = 0; level < GLOSSY_LEVELS && result == PSPLAT_OK; ++level)
        for (int face = 0; face < 6; ++face) {
            fill_face(cube, face, GLOSSY_SIZE >> level, level, staging);
            upload_face(&renderer->gl, face, level, GLOSSY_SIZE >> level, staging);
        }
    return result;
}

/* Makes the table of a and b. Its first and last texels are for n.e and roughness of 0 and 1. */
static psplat_result make_split_sum(psplat_renderer *renderer, float *staging,
                                    psplat_gl_texture *texture, psplat_error *error) {
    psplat_gl_texture_desc desc = {.texel = PSPLAT_TEXEL_RG16F,
                                   .width = SPLIT_SUM_SIZE,
                                   .height = SPLIT_SUM_SIZE,
                                   .is_linear = 1};
    psplat_result result = psplat_gl_texture_create(&renderer->gl, &renderer->memory.environments,
                                                    &desc, texture, error);
    if (result != PSPLAT_OK) return result;
    for (int y = 0; y < SPLIT_SUM_SIZE; ++y)
        for (int x = 0; x < SPLIT_SUM_SIZE; ++x) {
            double roughness = y / (SPLIT_SUM_SIZE - 1.0), root = x / (SPLIT_SUM_SIZE - 1.0);
            psplat_split_sum(fmax(root * root, 1e-4), fmax(roughness * roughness, 0.002),
                             staging + 2 * (y * SPLIT_SUM_SIZE + x));
        }
    renderer->gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, SPLIT_SUM_SIZE, SPLIT_SUM_SIZE, GL_RG,
                               GL_FLOAT, staging);
    return PSPLAT_OK;
}

static psplat_result make_textures(psplat_renderer *renderer, const psplat_cube *cube,
                                   float *staging, psplat_environment *environment,
                                   psplat_error *error) {
    psplat_gl_state state;
    psplat_result result = psplat_gl_state_take(&state, &renderer->gl, PSPLAT_UNIT_COUNT, error);
    if (result != PSPLAT_OK) return result;
    psplat_gl_errors(&renderer->gl, NULL);
    result = make_diffuse(renderer, cube, staging, &environment->diffuse, error);
    if (result == PSPLAT_OK)
        result = make_glossy(renderer, cube, staging, &environment->glossy, error);
    if (result == PSPLAT_OK)
        result = make_split_sum(renderer, staging, &environment->split_sum, error);
    if (result == PSPLAT_OK) result = psplat_gl_errors(&renderer->gl, error);
    psplat_gl_state_restore(&state, &renderer->gl);
    environment->glossy_levels = GLOSSY_LEVELS - 1;
    return result;
}

/* Prefilters the radiance on the CPU and uploads the result. */
static psplat_result fill(psplat_renderer *renderer, const psplat_environment_desc *desc,
                          psplat_environment *environment, psplat_error *error) {
    psplat_cube cube;
    size_t size = FACE_FLOATS * sizeof(float);
    float *staging = psplat_allocate(&renderer->allocator, 1, size);
    if (!staging) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a face");
    psplat_result result =
        psplat_cube_create(&cube, &renderer->allocator, desc->radiance, desc->size, error);
    if (result == PSPLAT_OK) {
        result = make_textures(renderer, &cube, staging, environment, error);
        psplat_cube_free(&cube, &renderer->allocator);
    }
    psplat_resize(&renderer->allocator, staging, size, 0);
    return psplat_gl_finish(&renderer->gl, result, error);
}

static psplat_result check(const psplat_environment_desc *desc, psplat_error *error) {
    if (desc->size < 1 || desc->size > MAX_SIZE)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "a cube map of %d texels is outside 1 ... %d", desc->size, MAX_SIZE);
    size_t count = 18 * (size_t)desc->size * (size_t)desc->size;
    for (size_t i = 0; i < count; ++i)
        if (!(desc->radiance[i] >= 0.0f) || !isfinite(desc->radiance[i]))
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                               "radiance %zu of the cube map is negative or not finite", i);
    return PSPLAT_OK;
}

psplat_result psplat_environment_create(psplat_renderer *renderer,
                                        const psplat_environment_desc *desc,
                                        psplat_environment **environment, psplat_error *error) {
    if (environment) *environment = NULL;
    if (!renderer || !desc || !desc->radiance || !environment)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "renderer, desc, its radiance and environment must not be NULL");
    psplat_result result = check(desc, error);
    if (result != PSPLAT_OK) return result;
    psplat_environment *made = psplat_allocate(&renderer->allocator, 1, sizeof *made);
    if (!made) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for an environment");
    result = fill(renderer, desc, made, error);
    if (result != PSPLAT_OK) {
        psplat_environment_destroy(renderer, made);
        return result;
    }
    *environment = made;
    return PSPLAT_OK;
}

void psplat_environment_destroy(psplat_renderer *renderer, psplat_environment *environment) {
    if (!renderer || !environment) return;
    psplat_gl_texture_delete(&renderer->gl, &environment->diffuse);
    psplat_gl_texture_delete(&renderer->gl, &environment->glossy);
    psplat_gl_texture_delete(&renderer->gl, &environment->split_sum);
    psplat_resize(&renderer->allocator, environment, sizeof *environment, 0);
}

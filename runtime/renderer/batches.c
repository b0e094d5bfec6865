/* SPDX-License-Identifier: MIT
 *
 * batches.c - draws the splats of one pass, batch by batch: chooses for each the shader variant
 * that has what the batch needs and nothing else, sets its uniforms, and leaves out the chunks that
 * lie outside the view or turn their backs to it (core/chunk.h). A curved batch whose curvature
 * does not show is drawn as ellipses, as flat ones are.
 */
#include "renderer/frame.h"
#include "core/matrix.h"

#include <string.h>

/* By how much of the depth range, in normalised device coordinates, the shading `splats` moves
 * splats apart: some hundred times the rounding of depths, and some thousandths of a percent of the
 * model where the planes lie close around it. */
static const float splats_apart = 6.1035156e-5f; /* 2^-14 */

/* ---- uniforms ---------------------------------------------------------------------------- */

void psplat_frame_use_material(const psplat_gl *gl, const psplat_program *program,
                               const psplat_material *material) {
    const float surface[3] = {material->metallic, material->roughness, material->unlit ? 1.f : 0.f};
    gl->Uniform3fv(program->base_color, 1, material->base_color);
    gl->Uniform3fv(program->emissive, 1, material->emissive);
    gl->Uniform3fv(program->surface, 1, surface);
}

/* Sets the current program's uniforms of textures and binds those that it reads. */
static void use_maps(const psplat_gl *gl, const psplat_program *program,
                     const psplat_model_batch *batch) {
    const psplat_material *material = &batch->material;
    float rows[PSPLAT_MAP_COUNT][6];
    if (!(program->key.options & PSPLAT_OPTION_TEXTURED)) return;
    gl->Uniform2f(program->map_strength, material->textures[PSPLAT_TEXTURE_NORMAL].strength,
                  material->textures[PSPLAT_TEXTURE_OCCLUSION].strength);
    gl->Uniform2f(program->mask, material->base_color[3], material->alpha_cutoff);
    psplat_gl_texture_bind(gl, PSPLAT_UNIT_TEXCOORDS, &batch->texcoords, GL_TEXTURE_2D);
    for (GLuint slot = 0; slot < PSPLAT_MAP_COUNT; ++slot) {
        memcpy(rows[slot], material->textures[slot].transform, sizeof rows[slot]);
        if (!(program->key.options & (unsigned)PSPLAT_OPTION_BASE_MAP << slot)) continue;
        gl->ActiveTexture(GL_TEXTURE0 + PSPLAT_UNIT_MAPS + slot);
        gl->BindTexture(GL_TEXTURE_2D, batch->maps[slot]);
        gl->BindSampler(PSPLAT_UNIT_MAPS + slot, batch->samplers[slot]);
    }
    if (program->key.options & PSPLAT_OPTION_MAP_TRANSFORM)
        gl->Uniform3fv(program->map_transform, 2 * PSPLAT_MAP_COUNT, rows[0]);
}

static void use_environment(const psplat_frame *f, const psplat_program *program) {
    const psplat_gl *gl = &f->renderer->gl;
    const psplat_environment *environment = f->view->environment;
    float eye_to_scene[9];
    for (int i = 0; i < 9; ++i) /* the transpose is the inverse, because views are rigid */
        eye_to_scene[i] = (float)f->view->view[(i % 3) * 4 + i / 3];
    gl->UniformMatrix3fv(program->eye_to_scene, 1, GL_FALSE, eye_to_scene);
    gl->Uniform1f(program->glossy_levels, environment->glossy_levels);
    psplat_gl_texture_bind(gl, PSPLAT_UNIT_DIFFUSE, &environment->diffuse, GL_TEXTURE_CUBE_MAP);
    psplat_gl_texture_bind(gl, PSPLAT_UNIT_GLOSSY, &environment->glossy, GL_TEXTURE_CUBE_MAP);
    psplat_gl_texture_bind(gl, PSPLAT_UNIT_SPLIT_SUM, &environment->split_sum, GL_TEXTURE_2D);
}

void psplat_frame_use_light(const psplat_frame *f, const psplat_program *program) {
    const psplat_gl *gl = &f->renderer->gl;
    gl->UniformMatrix3fv(program->ray, 1, GL_FALSE, f->camera.ray);
    gl->UniformMatrix4fv(program->unproject, 1, GL_FALSE, f->camera.unproject);
    gl->Uniform3fv(program->ambient, 1, f->view->ambient);
    psplat_lights_use(&f->lights, gl, program);
    if (f->key.options & PSPLAT_OPTION_ENVIRONMENT) use_environment(f, program);
    if (f->key.options & PSPLAT_OPTION_SHADOWS)
        psplat_shadows_use(&f->renderer->shadows, gl, program);
}

/* Sets the uniforms that depend on the camera and on the batch's place in it. */
static void use_placement(const psplat_gl *gl, const psplat_program *program,
                          const psplat_camera *camera, const psplat_placement *placement) {
    const float direction[3] = {(float)camera->direction[0], (float)camera->direction[1],
                                (float)camera->direction[2]};
    float clip[16];
    psplat_matrix_to_float(placement->clip, 16, clip);
    gl->UniformMatrix4fv(program->clip_matrix, 1, GL_FALSE, clip);
    gl->UniformMatrix4fv(program->projection, 1, GL_FALSE, camera->projection_float);
    gl->UniformMatrix4fv(program->modelview, 1, GL_FALSE, placement->modelview);
    gl->UniformMatrix3fv(program->normal_matrix, 1, GL_FALSE, placement->normal);
    gl->Uniform3fv(program->shift, 1, placement->shift);
    gl->Uniform3fv(program->view_direction, 1, direction);
    gl->Uniform3fv(program->half_viewport, 1, camera->half_viewport);
    gl->UniformMatrix3fv(program->ray, 1, GL_FALSE, camera->ray);
    gl->Uniform2f(program->depth_range, camera->depth_range[0], camera->depth_range[1]);
    gl->Uniform1f(program->unstretch, placement->unstretch);
}

/* ---- one batch --------------------------------------------------------------------------- */

/* How far a patch may be from its tangent plane where that is drawn in its place: in pixels (spec
 * 5.1), and as a part of the depth tolerance, within which splats of one surface lie anyway. */
#define MAX_FLAT_PIXELS 0.125
#define MAX_FLAT_TOLERANCE 0.25

/* Returns 1 where a curved batch has to be drawn as such in this view. */
static int shows_curvature(const psplat_model_batch *batch, const psplat_camera *camera,
                           const psplat_placement *placement) {
    double sagitta = (double)batch->sagitta;
    return batch->is_curved && sagitta > MAX_FLAT_TOLERANCE * (double)batch->depth_tolerance &&
           psplat_camera_pixels(camera, placement->clip, batch->bounds_min, batch->bounds_max,
                                sagitta) > MAX_FLAT_PIXELS;
}

/* Returns the PSPLAT_OPTION_ bits that the batch asks for. */
static unsigned options_of(const psplat_model_batch *batch, const psplat_placement *placement,
                           int is_culled, int is_curved) {
    unsigned options = batch->textures;
    if (batch->is_curved) options |= is_curved ? PSPLAT_OPTION_CURVED : PSPLAT_OPTION_TANGENT;
    if (batch->has_shape) options |= PSPLAT_OPTION_SHAPE;
    if (batch->has_bends) options |= PSPLAT_OPTION_BENDS;
    if (batch->has_color || batch->has_gamma) options |= PSPLAT_OPTION_WIDE;
    if (batch->has_color) options |= PSPLAT_OPTION_COLOR;
    if (batch->has_gamma) options |= PSPLAT_OPTION_GAMMA;
    if (batch->finish) options |= PSPLAT_OPTION_FINISH;
    if (placement->is_near) options |= PSPLAT_OPTION_NEAR;
    if (!is_culled) options |= PSPLAT_OPTION_TWO_SIDED;
    if (batch->kernel.exponent != 2.0f) options |= PSPLAT_OPTION_POWER;
    return options;
}

/* Lets the hardware cull backs: on llvmpipe this took 5 % (10k splats) to 20 % (100k) less CPU time
 * than dropping splats in the vertex stage. */
static void set_culling(const psplat_gl *gl, int is_culled, int is_mirrored) {
    gl->FrontFace(is_mirrored ? GL_CW : GL_CCW);
    if (is_culled)
        gl->Enable(GL_CULL_FACE);
    else
        gl->Disable(GL_CULL_FACE);
}

static void draw_run(const psplat_gl *gl, GLsizei first, GLsizei end, int vertices) {
    if (end > first) gl->DrawArrays(GL_TRIANGLES, vertices * first, vertices * (end - first));
}

/* Draws the chunks that may be visible, each run of consecutive ones with one call, and enters them
 * in the frame's extent. vertices is the number of a splat's vertices. */
static void draw_chunks(psplat_frame *f, const psplat_model_batch *batch,
                        const psplat_placement *placement, int vertices) {
    const psplat_gl *gl = &f->renderer->gl;
    const psplat_chunk_view *view = &placement->chunk_view;
    GLsizei count = batch->splat_count, first = 0, end = 0;
    for (GLsizei at = 0; at < count; at += PSPLAT_CHUNK_SPLATS) {
        const psplat_chunk *chunk = &batch->chunks[at / PSPLAT_CHUNK_SPLATS];
        if (psplat_chunk_is_visible(chunk, view)) {
            psplat_screen_extent_add(&f->extent, chunk->center, chunk->radius, placement->clip,
                                     f->view->width, f->view->height);
            end = at + PSPLAT_CHUNK_SPLATS < count ? at + PSPLAT_CHUNK_SPLATS : count;
            continue;
        }
        draw_run(gl, first, end, vertices);
        first = end = at + PSPLAT_CHUNK_SPLATS;
    }
    draw_run(gl, first, end, vertices);
}

static psplat_result draw_batch(psplat_frame *f, const psplat_model_batch *batch,
                                const psplat_camera *camera, const psplat_placement *placement,
                                psplat_program_key key, unsigned first_index) {
    psplat_renderer *renderer = f->renderer;
    const psplat_gl *gl = &renderer->gl;
    int is_culled = placement->chunk_view.is_culled;
    int is_curved = shows_curvature(batch, camera, placement);
    key.options |= options_of(batch, placement, is_culled, is_curved);
    key.clip_count = (int)batch->clip_count;
    const psplat_program *program = NULL;
    psplat_result result = psplat_programs_find(&renderer->programs, gl, &renderer->allocator, key,
                                                &program, f->error);
    if (result != PSPLAT_OK) return result;
    gl->UseProgram(program->id);
    use_placement(gl, program, camera, placement);
    if (key.pass != PSPLAT_PASS_VISIBILITY) {
        psplat_frame_use_material(gl, program, &batch->material);
        gl->Uniform1i(program->first_index, (GLint)(first_index & 0x7fffffffu));
        gl->Uniform1f(program->apart, key.shading == PSPLAT_SHADING_SPLATS ? splats_apart : 0.0f);
        gl->Uniform1i(program->finish,
                      (GLint)(batch->finish | (batch->has_color ? PSPLAT_FINISH_COLOR : 0u)));
        gl->Uniform2f(program->kernel, -batch->kernel.sharpness, 0.5f * batch->kernel.exponent);
    }
    if (key.pass == PSPLAT_PASS_RADIANCE) psplat_frame_use_light(f, program);
    set_culling(gl, is_culled && !is_curved, placement->is_mirrored);
    psplat_gl_texture_bind(gl, PSPLAT_UNIT_SPLATS, &batch->splats, GL_TEXTURE_2D);
    psplat_gl_texture_bind(gl, PSPLAT_UNIT_CLIPS, &batch->clips, GL_TEXTURE_2D);
    if (batch->finish)
        psplat_gl_texture_bind(gl, PSPLAT_UNIT_FINISHES, &batch->finishes, GL_TEXTURE_2D);
    use_maps(gl, program, batch);
    draw_chunks(f, batch, placement, is_curved ? 6 : 3);
    return PSPLAT_OK;
}

static int is_culled(psplat_culling culling, const psplat_material *material) {
    return culling == PSPLAT_CULL_ALWAYS ||
           (culling == PSPLAT_CULL_BY_MATERIAL && !material->double_sided);
}

psplat_result psplat_frame_draw_batches(psplat_frame *f, const psplat_camera *camera,
                                        psplat_program_key key, psplat_culling culling) {
    unsigned first_index = 0; /* may wrap, because instances have no limit */
    f->extent = (psplat_screen_extent){0, 0, 0, 0};
    for (size_t i = 0; i < f->item_count; ++i) {
        const psplat_item *item = &f->items[i];
        for (size_t k = 0; k < item->model->batch_count; ++k) {
            const psplat_model_batch *batch = &item->model->batches[k];
            const psplat_placement_desc desc = {
                .transform = item->transform,
                .model = psplat_item_matrix(item, k),
                .depth_tolerance = (double)batch->depth_tolerance,
                .bounds_min = batch->bounds_min,
                .bounds_max = batch->bounds_max,
                .is_culled = is_culled(culling, &batch->material),
            };
            psplat_placement placement;
            psplat_result result = PSPLAT_OK;
            if (psplat_camera_place(camera, &desc, &placement))
                result = draw_batch(f, batch, camera, &placement, key, first_index);
            if (result != PSPLAT_OK) return result;
            first_index += (unsigned)batch->splat_count;
        }
    }
    return PSPLAT_OK;
}

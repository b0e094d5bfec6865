/* SPDX-License-Identifier: MIT
 *
 * batches.c - places the batches of all items in a camera, and draws the splats of a pass. It
 * leaves out the chunks that lie outside the view or turn their backs to it (core/chunk.h);
 * instances.c makes calls of the rest, each of which draws what many items show of a batch. For
 * each batch it chooses the shader variant that has what the batch needs and nothing else, and sets
 * its uniforms. A curved batch whose curvature does not show is drawn as ellipses, as flat ones
 * are.
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
    if (!(program->key.options & PSPLAT_OPTIONS_TEXTURED)) return;
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

/* Sets the uniforms that depend on the camera. */
static void use_camera(const psplat_gl *gl, const psplat_program *program,
                       const psplat_camera *camera) {
    const float direction[3] = {(float)camera->direction[0], (float)camera->direction[1],
                                (float)camera->direction[2]};
    gl->UniformMatrix4fv(program->projection, 1, GL_FALSE, camera->projection_float);
    gl->Uniform3fv(program->shift, 1, camera->shift);
    gl->Uniform3fv(program->view_direction, 1, direction);
    gl->Uniform3fv(program->half_viewport, 1, camera->half_viewport);
    gl->UniformMatrix3fv(program->ray, 1, GL_FALSE, camera->ray);
    gl->Uniform2f(program->depth_range, camera->depth_range[0], camera->depth_range[1]);
}

/* ---- placing ----------------------------------------------------------------------------- */

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

/* Adds a chunk to the last run, or begins another where it does not follow it or is not as much in
 * the view. */
static int add_chunk(psplat_renderer *renderer, psplat_placed *placed, const psplat_run *chunk) {
    psplat_list *runs = &renderer->instances.runs;
    psplat_run *last = runs->count ? (psplat_run *)runs->items + runs->count - 1 : NULL;
    if (placed->run_count && last->end == chunk->first &&
        last->is_between_sides == chunk->is_between_sides) {
        last->end = chunk->end;
        return 1;
    }
    psplat_run *run = psplat_list_add(runs, &renderer->allocator, sizeof *run);
    if (!run) return 0;
    *run = *chunk;
    ++placed->run_count;
    return 1;
}

/* How many pixels a splat of a chunk has to have in the chunk's extent so that its own extent is
 * worth its price: some 50 ns, for which a pixel or two are resolved in software. */
enum { PIXELS_PER_SPHERE = 100 };

/* Enters a chunk in the frame's extent and, where the camera is the view's own and not a light's,
 * marks its blocks, splat by splat where those are large. */
static void mark_chunk(psplat_frame *f, const psplat_camera *camera,
                       const psplat_model_batch *batch, GLsizei first, GLsizei end,
                       const double clip[16]) {
    int width = camera->width, height = camera->height;
    const psplat_chunk *chunk = &batch->chunks[first / PSPLAT_CHUNK_SPLATS];
    psplat_screen_extent e =
        psplat_screen_extent_of(chunk->center, chunk->radius, clip, width, height);
    psplat_screen_extent_join(&f->extent, &e);
    if (camera != &f->camera) return;
    double pixels = (double)(e.x1 - e.x0) * (e.y1 - e.y0);
    if (!batch->spheres || pixels < (double)PIXELS_PER_SPHERE * (end - first)) {
        psplat_marked_blocks_add(&f->blocks, &e);
        return;
    }
    for (GLsizei i = first; i < end; ++i) {
        const float *sphere = batch->spheres + 4 * (size_t)i;
        e = psplat_screen_extent_of(sphere, sphere[3], clip, width, height);
        psplat_marked_blocks_add(&f->blocks, &e);
    }
}

/* Returns 1 where all splats of a chunk lie between the four sides of the view. The sphere around
 * them all may reach far beyond large splats. */
static int is_between_sides(const psplat_model_batch *batch, GLsizei first, GLsizei end,
                            const psplat_chunk_view *view) {
    const psplat_chunk *chunk = &batch->chunks[first / PSPLAT_CHUNK_SPLATS];
    if (psplat_sphere_is_between_sides(chunk->center, chunk->radius, view)) return 1;
    if (!batch->spheres) return 0;
    for (GLsizei i = first; i < end; ++i) {
        const float *sphere = batch->spheres + 4 * (size_t)i;
        if (!psplat_sphere_is_between_sides(sphere, sphere[3], view)) return 0;
    }
    return 1;
}

/* Finds the runs of chunks that may be visible and enters them in the frame's extent. Returns 0
 * where memory runs out. */
static int find_runs(psplat_frame *f, const psplat_camera *camera, psplat_placed *placed,
                     const psplat_placement *placement) {
    const psplat_model_batch *batch = placed->batch;
    const psplat_chunk_view *chunk_view = &placement->chunk_view;
    GLsizei count = batch->splat_count;
    /* Whether the vertex shader drops splats: those that are turned away or of another part. */
    int drops = placed->is_curved && (chunk_view->is_culled || batch->clip_count > 0);
    placed->first_run = f->renderer->instances.runs.count;
    placed->run_count = 0;
    for (GLsizei at = 0; at < count; at += PSPLAT_CHUNK_SPLATS) {
        const psplat_chunk *chunk = &batch->chunks[at / PSPLAT_CHUNK_SPLATS];
        if (!psplat_chunk_is_visible(chunk, chunk_view)) continue;
        GLsizei end = count - at < PSPLAT_CHUNK_SPLATS ? count : at + PSPLAT_CHUNK_SPLATS;
        mark_chunk(f, camera, batch, at, end, placement->clip);
        int is_between = drops && is_between_sides(batch, at, end, chunk_view);
        const psplat_run run = {at, end, is_between};
        if (!add_chunk(f->renderer, placed, &run)) return 0;
    }
    return 1;
}

static void set_instance(psplat_instance *instance, const psplat_placement *placement,
                         const psplat_item *item, unsigned first_index) {
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column)
            instance->modelview[4 * row + column] = placement->modelview[4 * column + row];
        for (int column = 0; column < 3; ++column)
            instance->normal[4 * row + column] = placement->normal[3 * column + row];
    }
    instance->normal[3] = placement->epsilon;
    instance->normal[7] = placement->unstretch;
    instance->normal[11] = 1.0f - item->fade;
    instance->first[0] = 0;
    instance->first[1] = (GLint)(first_index & ~PSPLAT_CUT_BY_SIDE);
}

/* Adds a batch to what is drawn, unless none of it can be seen. Returns 0 where memory runs out. */
static int add_placed(psplat_frame *f, const psplat_camera *camera, const psplat_item *item,
                      const psplat_model_batch *batch, const psplat_placement *placement,
                      unsigned first_index) {
    psplat_renderer *renderer = f->renderer;
    psplat_list *list = &renderer->instances.placed;
    psplat_placed *placed = psplat_list_add(list, &renderer->allocator, sizeof *placed);
    if (!placed) return 0;
    placed->batch = batch;
    placed->is_curved = shows_curvature(batch, camera, placement);
    if (!find_runs(f, camera, placed, placement)) return 0;
    if (!placed->run_count) {
        --list->count;
        return 1;
    }
    placed->is_culled = placement->chunk_view.is_culled;
    placed->is_mirrored = placement->is_mirrored;
    placed->is_faded = psplat_item_is_faded(item);
    placed->options = options_of(batch, placement, placed->is_culled, placed->is_curved);
    placed->key = batch->number << 5 | (unsigned)placed->is_faded << 4 |
                  (unsigned)!!placed->is_curved << 3 | (unsigned)!!placement->is_near << 2 |
                  (unsigned)!!placed->is_culled << 1 | (unsigned)!!placed->is_mirrored;
    set_instance(&placed->instance, placement, item, first_index);
    return 1;
}

static int is_culled(psplat_culling culling, const psplat_material *material) {
    return culling == PSPLAT_CULL_ALWAYS ||
           (culling == PSPLAT_CULL_BY_MATERIAL && !material->double_sided);
}

/* Places the batches of an item. Returns 0 where memory runs out. */
static int add_item(psplat_frame *f, const psplat_camera *camera, psplat_culling culling,
                    const psplat_item *item, unsigned *first_index) {
    psplat_placement placement;
    int is_placed = 0;
    for (size_t k = 0; k < item->model->batch_count; ++k) {
        const psplat_model_batch *batch = &item->model->batches[k];
        double modelview[16];
        if (!psplat_item_shows(item, k)) continue;
        if (psplat_item_is_drawn(item) && !psplat_item_shares_place(item, k)) {
            psplat_camera_modelview(camera->view, item->transform, psplat_item_matrix(item, k),
                                    modelview);
            is_placed = psplat_camera_place(camera, modelview, &placement);
        }
        if (is_placed) {
            const psplat_placement_desc desc = {(double)batch->depth_tolerance, batch->bounds_min,
                                                batch->bounds_max,
                                                is_culled(culling, &batch->material)};
            psplat_camera_place_batch(&desc, &placement);
            if (!add_placed(f, camera, item, batch, &placement, *first_index)) return 0;
        }
        *first_index += (unsigned)batch->splat_count;
    }
    return 1;
}

psplat_result psplat_frame_place(psplat_frame *f, const psplat_camera *camera,
                                 psplat_culling culling, int keeps_order) {
    psplat_renderer *renderer = f->renderer;
    unsigned first_index = 0; /* may wrap, because instances have no limit */
    int has_memory = 1;
    f->extent = (psplat_screen_extent){0, 0, 0, 0};
    psplat_marked_blocks_clear(&f->blocks, f->view->width, f->view->height);
    renderer->instances.placed.count = renderer->instances.runs.count = 0;
    for (size_t i = 0; i < f->item_count && has_memory; ++i)
        has_memory = add_item(f, camera, culling, &f->items[i], &first_index);
    if (!has_memory)
        return psplat_fail(f->error, PSPLAT_ERROR_MEMORY, 0, "no memory to place %zu items",
                           f->item_count);
    return psplat_instances_make(&renderer->instances, &renderer->gl, &renderer->allocator,
                                 keeps_order, f->error);
}

/* ---- drawing ----------------------------------------------------------------------------- */

/* Lets the hardware cull backs: on llvmpipe this took 5 % (10k splats) to 20 % (100k) less CPU time
 * than dropping splats in the vertex stage. */
static void set_culling(const psplat_gl *gl, int is_culled, int is_mirrored) {
    gl->FrontFace(is_mirrored ? GL_CW : GL_CCW);
    if (is_culled)
        gl->Enable(GL_CULL_FACE);
    else
        gl->Disable(GL_CULL_FACE);
}

/* Makes current the program that draws a batch, with its uniforms and textures. */
static psplat_result use_batch(psplat_frame *f, const psplat_camera *camera,
                               const psplat_placed *placed, psplat_program_key key) {
    psplat_renderer *renderer = f->renderer;
    const psplat_gl *gl = &renderer->gl;
    const psplat_model_batch *batch = placed->batch;
    key.options |= placed->options;
    key.is_faded = placed->is_faded;
    key.clip_count = (int)batch->clip_count;
    key.seam_count = (int)batch->seam_lines;
    const psplat_program *program = NULL;
    psplat_result result = psplat_programs_find(&renderer->programs, gl, &renderer->allocator, key,
                                                &program, f->error);
    if (result != PSPLAT_OK) return result;
    gl->UseProgram(program->id);
    use_camera(gl, program, camera);
    if (key.pass != PSPLAT_PASS_VISIBILITY) {
        psplat_frame_use_material(gl, program, &batch->material);
        gl->Uniform1f(program->apart, key.shading == PSPLAT_SHADING_SPLATS ? splats_apart : 0.0f);
        gl->Uniform1i(program->finish,
                      (GLint)(batch->finish | (batch->has_color ? PSPLAT_FINISH_COLOR : 0u)));
        gl->Uniform2f(program->kernel, -batch->kernel.sharpness, 0.5f * batch->kernel.exponent);
    }
    if (key.pass == PSPLAT_PASS_RADIANCE) psplat_frame_use_light(f, program);
    set_culling(gl, placed->is_culled && !placed->is_curved, placed->is_mirrored);
    psplat_gl_texture_bind(gl, PSPLAT_UNIT_SPLATS, &batch->splats, GL_TEXTURE_2D);
    psplat_gl_texture_bind(gl, PSPLAT_UNIT_CLIPS, &batch->clips, GL_TEXTURE_2D);
    if (batch->finish)
        psplat_gl_texture_bind(gl, PSPLAT_UNIT_FINISHES, &batch->finishes, GL_TEXTURE_2D);
    use_maps(gl, program, batch);
    return PSPLAT_OK;
}

/* Draws calls of one batch with one program. */
static psplat_result draw_calls(psplat_frame *f, const psplat_camera *camera,
                                psplat_program_key key, const psplat_call *calls, size_t count) {
    psplat_instances *in = &f->renderer->instances;
    const psplat_gl *gl = &f->renderer->gl;
    const psplat_placed *placed = (const psplat_placed *)in->placed.items + calls->placed;
    GLsizei vertices = placed->is_curved || key.is_boxed ? 6 : 3; /* of a splat */
    psplat_result result = use_batch(f, camera, placed, key);
    for (size_t i = 0; i < count && result == PSPLAT_OK; ++i) {
        const psplat_call *call = &calls[i];
        if (i == 0 || call->first_instance != call[-1].first_instance)
            psplat_instances_use(in, gl, call->first_instance);
        gl->DrawArraysInstanced(GL_TRIANGLES, vertices * call->first, vertices * call->count,
                                call->instance_count);
    }
    return result;
}

/* Returns how many pixels of the frame's extent there are for each splat. */
static double pixels_a_splat(const psplat_frame *f) {
    const psplat_instances *in = &f->renderer->instances;
    const psplat_call *calls = in->calls.items;
    const psplat_screen_extent *extent = &f->extent;
    double splats = 0, pixels = (double)(extent->x1 - extent->x0) * (extent->y1 - extent->y0);
    for (size_t i = 0; i < in->calls.count; ++i)
        splats += (double)calls[i].count * calls[i].instance_count;
    return splats > 0 ? pixels / splats : 0;
}

/* How many of these pixels make parts and boxes pay: they save fragments at the cost of vertices.
 * In software boxes do from 10 to 20 on for a machined part whose triangles cover four times what
 * its boxes do. */
static const double pixels_for_parts = 600, pixels_for_boxes = 20;

/* Returns 1 where flat splats are drawn as rectangles around what clip lines leave of them, not as
 * triangles around all: where lines, seams among them, cut half of the batch or more. */
static int is_boxed(const psplat_placed *placed, double pixels) {
    const psplat_model_batch *batch = placed->batch;
    return !placed->is_curved && batch->clip_count > batch->seam_lines &&
           2 * (size_t)batch->uncut_count <= (size_t)batch->splat_count &&
           pixels > pixels_for_boxes;
}

/* Returns the part of a batch to draw first. Where a quarter of a curved batch or more is not cut
 * by its lines, a program without lines draws that part and another one the rest: fragments of the
 * first are cheaper, and each of the two drops what is not its own at the cost of vertices. Where
 * the nearest splat wins, splats keep their order and are drawn by one program. So are those that
 * seams alone cut, where these do not matter. */
static int first_part(const psplat_frame *f, const psplat_placed *placed, psplat_program_key key,
                      double pixels) {
    const psplat_model_batch *batch = placed->batch;
    if (!placed->is_curved || !batch->uncut_count ||
        !(f->blends || key.pass == PSPLAT_PASS_VISIBILITY))
        return PSPLAT_PART_ALL;
    key.seam_count = (int)batch->seam_lines;
    if (batch->seam_lines == batch->clip_count && !psplat_program_has_seams(&key))
        return PSPLAT_PART_ALL;
    int is_enough = 4 * (size_t)batch->uncut_count >= (size_t)batch->splat_count;
    return is_enough && pixels > pixels_for_parts ? PSPLAT_PART_UNCUT : PSPLAT_PART_ALL;
}

psplat_result psplat_frame_draw_placed(psplat_frame *f, const psplat_camera *camera,
                                       psplat_program_key key) {
    const psplat_instances *in = &f->renderer->instances;
    const psplat_placed *all = in->placed.items;
    const psplat_call *calls = in->calls.items;
    double pixels = pixels_a_splat(f);
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0, end; i < in->calls.count && result == PSPLAT_OK; i = end) {
        const psplat_placed *placed = &all[calls[i].placed];
        for (end = i + 1; end < in->calls.count; ++end)
            if (all[calls[end].placed].key != placed->key) break;
        key.is_boxed = is_boxed(placed, pixels);
        int has_cut = placed->batch->uncut_count < placed->batch->splat_count;
        key.part = first_part(f, placed, key, pixels);
        result = draw_calls(f, camera, key, calls + i, end - i);
        if (result != PSPLAT_OK || key.part == PSPLAT_PART_ALL || !has_cut) continue;
        key.part = PSPLAT_PART_CUT;
        result = draw_calls(f, camera, key, calls + i, end - i);
    }
    return result;
}

psplat_result psplat_frame_draw_batches(psplat_frame *f, const psplat_camera *camera,
                                        psplat_program_key key, psplat_culling culling) {
    psplat_result result = psplat_frame_place(f, camera, culling, 0);
    return result == PSPLAT_OK ? psplat_frame_draw_placed(f, camera, key) : result;
}

/* SPDX-License-Identifier: MIT
 *
 * draw.c - psplat_draw: checks its arguments, chooses shader variants and runs the passes of a
 * frame, which are those of BSK04 section 4 with deferred shading (BHZK05).
 *
 *   shadows      draws the depth of all splats as lights see them, where a light casts shadows
 *   visibility   draws the depth of all splats, shifted away from the eye by epsilon (spec 5.3)
 *   attributes   adds weighted normals, colours and depths of the splats up to that depth (5.4)
 *   resolve      divides each covered pixel by its weight, shades it and writes it (5.5, 5.6)
 *
 * In modes that show the nearest splat alone, one pass with a depth test of its own replaces
 * visibility and attributes. What all batches have in common is a uniform of the resolve pass:
 * colours and materials have render targets only where they differ and the shading reads them.
 */
#include "renderer/frame.h"
#include "gl/gl_state.h"
#include "core/matrix.h"

#include <math.h>

/* Pixels around what splats may cover that are cleared, too: shaders/README.md lets shadings look
 * so far. */
enum { CLEARED_AROUND = 16 };
enum { MAX_SHADOW_SIZE = 8192 }; /* texels along an edge of a shadow map, as phongsplat.h says */

/* ---- what differs between batches -------------------------------------------------------- */

static int same_color(const psplat_material *a, const psplat_material *b) {
    return a->base_color[0] == b->base_color[0] && a->base_color[1] == b->base_color[1] &&
           a->base_color[2] == b->base_color[2];
}

static int same_surface(const psplat_material *a, const psplat_material *b) {
    return a->metallic == b->metallic && a->roughness == b->roughness;
}

static int same_emission(const psplat_material *a, const psplat_material *b) {
    return a->emissive[0] == b->emissive[0] && a->emissive[1] == b->emissive[1] &&
           a->emissive[2] == b->emissive[2] && !a->unlit == !b->unlit;
}

/* Returns the material of the first batch that is drawn; every level of a model has one. */
static const psplat_material *first_material(const psplat_frame *f) {
    size_t first = 0, k = 0;
    while (first + 1 < f->item_count && !psplat_item_is_drawn(&f->items[first])) ++first;
    while (!psplat_item_shows(&f->items[first], k)) ++k;
    return &f->items[first].model->batches[k].material;
}

/* Returns the options for what differs between splats or between the materials of batches: those of
 * PSPLAT_OPTIONS_TARGETS. */
static unsigned differences(const psplat_frame *f) {
    const psplat_material *first = first_material(f);
    unsigned options = 0;
    for (size_t i = 0; i < f->item_count; ++i) {
        const psplat_model *model = f->items[i].model;
        size_t count = psplat_item_is_drawn(&f->items[i]) ? model->batch_count : 0;
        for (size_t k = 0; k < count; ++k) {
            const psplat_model_batch *batch = &model->batches[k];
            if (!psplat_item_shows(&f->items[i], k)) continue;
            const unsigned surface_maps = PSPLAT_OPTION_SURFACE_MAP | PSPLAT_OPTION_OCCLUSION_MAP;
            if (batch->has_color || batch->finish & PSPLAT_FINISH_GRADIENT ||
                batch->textures & PSPLAT_OPTION_BASE_MAP || !same_color(first, &batch->material))
                options |= PSPLAT_OPTION_COLORS;
            if (batch->finish & PSPLAT_FINISH_SURFACE || batch->textures & surface_maps ||
                !same_surface(first, &batch->material))
                options |= PSPLAT_OPTION_MATERIALS;
            if (batch->finish & PSPLAT_FINISH_EMISSIVE ||
                batch->textures & PSPLAT_OPTION_EMISSIVE_MAP ||
                !same_emission(first, &batch->material))
                options |= PSPLAT_OPTION_EMISSIVE;
            if (batch->finish & PSPLAT_FINISH_SURFACE ||
                batch->textures & PSPLAT_OPTION_OCCLUSION_MAP)
                options |= PSPLAT_OPTION_OCCLUSION;
        }
    }
    return options;
}

/* Returns the number of texture units that the frame changes: textures of materials have units of
 * their own. */
static GLuint unit_count(const psplat_frame *f) {
    for (size_t i = 0; i < f->item_count; ++i)
        for (size_t k = 0; k < f->items[i].model->batch_count; ++k)
            if (psplat_item_shows(&f->items[i], k) &&
                f->items[i].model->batches[k].textures & PSPLAT_OPTIONS_MAPS)
                return PSPLAT_UNIT_COUNT_MAPS;
    return PSPLAT_UNIT_COUNT;
}

/* ---- choice of passes and shader variants -------------------------------------------------- */

/* Chooses the attribute pass. Splats of the mode GAUSSIAN are lit one by one (spec 5.7). Those of
 * the mode FLAT are too, but each pixel shows one of them, so that lighting pixels in the resolve
 * pass gives the same. Shadings without light blend normals in every mode, as PHONG does. */
static void choose_pass(psplat_frame *f) {
    const psplat_view *view = f->view;
    psplat_program_key *key = &f->key;
    int is_parameters = view->mode == PSPLAT_MODE_PARAMETERS;
    key->pass = PSPLAT_PASS_NORMALS;
    key->shading = psplat_frame_shading(f);
    if (is_parameters || key->shading == PSPLAT_SHADING_SPLATS)
        key->pass = PSPLAT_PASS_PARAMETERS;
    else if (view->mode == PSPLAT_MODE_PHONG)
        key->options |= PSPLAT_OPTION_FIELD;
    else if (view->mode == PSPLAT_MODE_GAUSSIAN && key->shading == PSPLAT_SHADING_LIT && !key->host)
        key->pass = PSPLAT_PASS_RADIANCE;
    if (is_parameters || key->pass == PSPLAT_PASS_RADIANCE) key->options |= PSPLAT_OPTION_AS_IS;
    f->blends = view->mode != PSPLAT_MODE_FLAT && key->pass != PSPLAT_PASS_PARAMETERS;
}

/* Chooses the options that all batches share; batches add their own when they are drawn. */
static void choose_options(psplat_frame *f) {
    const psplat_view *view = f->view;
    psplat_program_key *key = &f->key;
    if (!f->blends || key->shading == PSPLAT_SHADING_OVERDRAW) key->options |= PSPLAT_OPTION_COUNT;
    if (f->blends && !view->no_filter) key->options |= PSPLAT_OPTION_FILTER;
    if (!view->linear_output && view->mode != PSPLAT_MODE_PARAMETERS)
        key->options |= PSPLAT_OPTION_ENCODE;
    if (key->pass == PSPLAT_PASS_NORMALS && psplat_shading_reads_color(key->shading)) {
        unsigned differ = differences(f);
        key->options |= differ & PSPLAT_OPTION_COLORS;
        if (psplat_frame_reads_material(f)) key->options |= differ;
    }
    if (!psplat_shading_reads_light(key->shading) || key->pass == PSPLAT_PASS_PARAMETERS) return;
    if (key->host && !psplat_frame_reads_material(f)) return;
    key->light_count = f->lights.count;
    if (f->lights.has_punctual) key->options |= PSPLAT_OPTION_PUNCTUAL;
    if (f->lights.shadow_count) key->options |= PSPLAT_OPTION_SHADOWS;
    if (view->environment) key->options |= PSPLAT_OPTION_ENVIRONMENT;
}

/* Adds the depths at which the view shows an item. */
static void add_depths(const psplat_view *view, const psplat_item *item, psplat_depth_span *span) {
    double modelview[16], scale = 0.0;
    if (!psplat_item_is_drawn(item)) return;
    for (size_t k = 0; k < item->model->batch_count; ++k) {
        const psplat_model_batch *batch = &item->model->batches[k];
        if (!psplat_item_shows(item, k)) continue;
        if (!psplat_item_shares_place(item, k)) {
            psplat_camera_modelview(view->view, item->transform, psplat_item_matrix(item, k),
                                    modelview);
            scale = cbrt(fabs(psplat_matrix_determinant3(modelview)));
        }
        /* Epsilon of eq. (5) is at most twice the tolerance, at grazing angles, and that of walls.
         */
        double epsilon = 2.0 * (double)batch->depth_tolerance * scale;
        if (batch->is_curved) epsilon *= PSPLAT_WALL_SHIFT;
        psplat_depth_span_add(span, modelview, view->projection, batch->bounds_min,
                              batch->bounds_max, epsilon);
    }
}

/* Returns the depths at which the view shows splats, or all of the view where it shows none. */
static psplat_depth_span find_span(const psplat_frame *f) {
    psplat_depth_span span = PSPLAT_SPAN_EMPTY;
    for (size_t i = 0; i < f->item_count; ++i) add_depths(f->view, &f->items[i], &span);
    return span.low < span.high ? span : PSPLAT_SPAN_WHOLE;
}

static psplat_result prepare(psplat_frame *f) {
    const psplat_view *view = f->view;
    float range[2];
    psplat_frame_find_depth_range(f, range);
    for (int i = 0; i < 2; ++i) f->depth_range[i] = (double)range[i];
    const psplat_depth_span span = view->depth_only ? PSPLAT_SPAN_WHOLE : find_span(f);
    const psplat_camera_desc desc = {.view = view->view,
                                     .projection = view->projection,
                                     .width = view->width,
                                     .height = view->height,
                                     .depth_range = {range[0], range[1]},
                                     .span = &span};
    psplat_result result = psplat_frame_find_resolve(f);
    if (result != PSPLAT_OK) return result;
    psplat_lights_set(&f->lights, view);
    choose_pass(f);
    choose_options(f);
    return psplat_camera_set(&f->camera, &desc, f->error);
}

/* ---- passes ------------------------------------------------------------------------------ */

static void set_writes(const psplat_gl *gl, GLboolean color, GLboolean depth, GLenum depth_func) {
    gl->ColorMask(color, color, color, color);
    gl->DepthMask(depth);
    gl->DepthFunc(depth_func);
}

static int target_count(unsigned options) {
    const unsigned colors = PSPLAT_OPTION_COLORS | PSPLAT_OPTION_MATERIALS;
    if (options & PSPLAT_OPTION_EMISSIVE) return PSPLAT_TARGET_COUNT_EMISSIVE;
    return options & colors ? PSPLAT_TARGET_COUNT_COLORS : PSPLAT_TARGET_COUNT;
}

/* Returns the numbers a pixel that the second target holds (layout.h). */
static int depth_numbers(unsigned options) {
    if (options & PSPLAT_OPTION_OCCLUSION) return 3;
    return options & (PSPLAT_OPTION_MATERIALS | PSPLAT_OPTION_EMISSIVE) ? 2 : 1;
}

/* Clears the targets where splats may be and shadings look: alone there where that is less than
 * half of the view. A host's resolve function may look anywhere. */
static void clear_targets(const psplat_frame *f, const psplat_gl_state *state, int colors) {
    static const float zeros[4] = {0}, one = 1.0f;
    const psplat_gl *gl = &f->renderer->gl;
    const psplat_screen_extent *extent = &f->extent;
    GLsizei width = extent->x1 - extent->x0 + 2 * CLEARED_AROUND;
    GLsizei height = extent->y1 - extent->y0 + 2 * CLEARED_AROUND;
    double half = 0.5 * f->view->width * f->view->height;
    int is_part = state->knows_scissor_box && !f->key.host && (double)width * (double)height < half;
    if (is_part) {
        psplat_render_targets_invalidate(&f->renderer->targets, gl);
        gl->Enable(GL_SCISSOR_TEST);
        gl->Scissor(extent->x0 - CLEARED_AROUND, extent->y0 - CLEARED_AROUND, width, height);
    }
    for (int i = 0; i < colors; ++i) gl->ClearBufferfv(GL_COLOR, i, zeros);
    gl->ClearBufferfv(GL_DEPTH, 0, &one);
    if (is_part) gl->Disable(GL_SCISSOR_TEST);
}

static psplat_result bind_target(const psplat_frame *f, const psplat_gl_state *state) {
    psplat_renderer *renderer = f->renderer;
    psplat_gl *gl = &renderer->gl;
    int colors = target_count(f->key.options), numbers = depth_numbers(f->key.options);
    psplat_result result =
        psplat_render_targets_bind(&renderer->targets, gl, &renderer->memory.targets,
                                   f->view->width, f->view->height, colors, numbers, f->error);
    if (result != PSPLAT_OK) return result;
    gl->Viewport(0, 0, f->view->width, f->view->height);
    set_writes(gl, GL_TRUE, GL_TRUE, GL_LESS);
    clear_targets(f, state, colors);
    gl->Enable(GL_DEPTH_TEST);
    return PSPLAT_OK;
}

static psplat_result draw_splats(psplat_frame *f) {
    const psplat_gl *gl = &f->renderer->gl;
    if (!f->blends) return psplat_frame_draw_placed(f, &f->camera, f->key);
    const psplat_program_key visibility = {.pass = PSPLAT_PASS_VISIBILITY};
    set_writes(gl, GL_FALSE, GL_TRUE, GL_LESS);
    psplat_result result = psplat_frame_draw_placed(f, &f->camera, visibility);
    if (result != PSPLAT_OK) return result;
    set_writes(gl, GL_TRUE, GL_FALSE, GL_LEQUAL);
    gl->Enable(GL_BLEND);
    gl->BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ONE);
    gl->BlendEquationSeparate(GL_FUNC_ADD, GL_FUNC_ADD);
    return psplat_frame_draw_placed(f, &f->camera, f->key);
}

/* Draws the view where splats may be, with a triangle for each rectangle of marked blocks. */
static void draw_blocks(const psplat_frame *f) {
    const psplat_gl *gl = &f->renderer->gl;
    psplat_marked_blocks blocks = f->blocks;
    for (;;) {
        const psplat_screen_extent e = psplat_marked_blocks_take(&blocks, &f->extent);
        if (!(e.x0 < e.x1)) return;
        gl->Viewport(f->view->x + e.x0, f->view->y + e.y0, e.x1 - e.x0, e.y1 - e.y0);
        gl->DrawArrays(GL_TRIANGLES, 0, 3);
    }
}

static psplat_result resolve(const psplat_frame *f, const psplat_gl_state *state) {
    psplat_renderer *renderer = f->renderer;
    const psplat_gl *gl = &renderer->gl;
    const psplat_view *view = f->view;
    const psplat_render_target *target = renderer->targets.current;
    psplat_program_key key = f->key;
    key.is_resolve = 1;
    const psplat_program *program = NULL;
    psplat_result result = psplat_programs_find(&renderer->programs, gl, &renderer->allocator, key,
                                                &program, f->error);
    if (result != PSPLAT_OK) return result;

    psplat_gl_state_bind_host(state, gl);
    gl->Disable(GL_BLEND);
    gl->Disable(GL_CULL_FACE);
    gl->Enable(GL_DEPTH_TEST);
    set_writes(gl, GL_TRUE, GL_TRUE, GL_LEQUAL);
    gl->UseProgram(program->id);
    if (!(key.options & PSPLAT_OPTION_AS_IS)) psplat_frame_use_light(f, program);
    psplat_frame_use_material(gl, program, first_material(f));
    if (key.host) psplat_frame_use_resolve(f, program);
    gl->Uniform3fv(program->planes, 1, f->camera.planes);
    gl->Uniform2i(program->origin, view->x, view->y);
    gl->Uniform2f(program->to_host, f->camera.to_host[0], f->camera.to_host[1]);
    for (int i = 0; i < target->color_count; ++i)
        psplat_gl_texture_bind(gl, (GLenum)i, &target->colors[i], GL_TEXTURE_2D);
    psplat_gl_texture_bind(gl, PSPLAT_UNIT_DEPTH, &target->depth, GL_TEXTURE_2D);
    draw_blocks(f);
    return PSPLAT_OK;
}

/* ---- psplat_draw ------------------------------------------------------------------------- */

static psplat_result check_light(const psplat_light *light, int index, psplat_error *error) {
    if ((unsigned)light->type > PSPLAT_LIGHT_SPOT)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "light %d has unknown type %d", index,
                           (int)light->type);
    for (int i = 0; i < 3; ++i)
        if (!(light->color[i] >= 0.0f) || !isfinite(light->color[i]))
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                               "light %d has a colour that is negative or not finite", index);
    double outer = psplat_light_outer_angle(light), inner = (double)light->inner_angle;
    if (light->type == PSPLAT_LIGHT_SPOT && !(inner >= 0.0 && inner < outer && outer < 1.5708))
        return psplat_fail(
            error, PSPLAT_ERROR_ARGUMENT, 0,
            "light %d has cone angles of %g and %g, not 0 <= inner < outer <= pi / 2", index, inner,
            outer);
    return PSPLAT_OK;
}

static psplat_result check_view(const psplat_renderer *renderer, const psplat_view *view,
                                psplat_error *error) {
    int most = renderer->gl.max_texture_size, shadow = most / PSPLAT_SHADOW_COUNT;
    if (shadow > MAX_SHADOW_SIZE) shadow = MAX_SHADOW_SIZE;
    if (view->width < 1 || view->height < 1 || view->width > most || view->height > most)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "a view of %d x %d pixels is outside 1 ... %d", view->width,
                           view->height, most);
    if ((unsigned)view->mode >= PSPLAT_MODE_COUNT ||
        (unsigned)view->shading >= PSPLAT_SHADING_COUNT ||
        (unsigned)view->culling > PSPLAT_CULL_ALWAYS)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "unknown mode %d, shading %d or culling %d", (int)view->mode,
                           (int)view->shading, (int)view->culling);
    if (view->light_count < 0 || view->light_count > PSPLAT_MAX_LIGHTS)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "%d lights are outside 0 ... %d",
                           view->light_count, PSPLAT_MAX_LIGHTS);
    if (view->shadow_size && (view->shadow_size < 16 || view->shadow_size > shadow))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "a shadow map of %d texels is outside 16 ... %d", view->shadow_size,
                           shadow);
    for (int i = 0; i < view->light_count; ++i) {
        psplat_result result = check_light(&view->lights[i], i, error);
        if (result != PSPLAT_OK) return result;
    }
    return psplat_frame_check_host(view, error);
}

static psplat_result check(const psplat_renderer *renderer, const psplat_view *view,
                           const psplat_item *items, size_t item_count, psplat_error *error) {
    if (!renderer || !view || (!items && item_count))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "renderer, view and items must not be NULL");
    for (size_t i = 0; i < item_count; ++i) {
        if (!items[i].model)
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "item %zu has no model", i);
        if (!(items[i].fade >= 0.0f))
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                               "item %zu has a fade of %g, which is not 0 or more", i,
                               (double)items[i].fade);
        size_t batches = items[i].model->batch_count;
        if (items[i].pose && (!psplat_pose_matrix(items[i].pose, batches - 1) ||
                              psplat_pose_matrix(items[i].pose, batches)))
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                               "item %zu has a pose of another asset than its model", i);
    }
    return check_view(renderer, view, error);
}

/* Draws what the view shows. Where the nearest splat wins, the first wins of those that are equally
 * near. */
static psplat_result draw_view(psplat_frame *f, const psplat_gl_state *state) {
    psplat_result result = psplat_frame_place(f, &f->camera, f->view->culling, !f->blends);
    if (result == PSPLAT_OK) result = bind_target(f, state);
    if (result != PSPLAT_OK || !(f->extent.x0 < f->extent.x1)) return result;
    result = draw_splats(f);
    return result == PSPLAT_OK ? resolve(f, state) : result;
}

static psplat_result draw_passes(psplat_frame *f, const psplat_gl_state *state) {
    if (f->view->depth_only) return psplat_frame_draw_depth(f, state);
    psplat_result result = PSPLAT_OK;
    if (f->key.options & PSPLAT_OPTION_SHADOWS) result = psplat_frame_draw_shadows(f);
    return result == PSPLAT_OK ? draw_view(f, state) : result;
}

static psplat_result draw_frame(psplat_frame *f) {
    const psplat_gl *gl = &f->renderer->gl;
    psplat_gl_state state;
    psplat_result result = psplat_frame_take_state(f, &state, unit_count(f));
    if (result != PSPLAT_OK) return result;
    gl->BindVertexArray(f->renderer->vertex_array);
    gl->CullFace(GL_BACK);
    result = draw_passes(f, &state);
    psplat_gl_state_restore(&state, gl);
    return result;
}

static int draws_any(const psplat_item *items, size_t item_count) {
    size_t i = 0;
    while (i < item_count && !psplat_item_is_drawn(&items[i])) ++i;
    return i < item_count;
}

psplat_result psplat_draw(psplat_renderer *renderer, const psplat_view *view,
                          const psplat_item *items, size_t item_count, psplat_error *error) {
    psplat_result result = check(renderer, view, items, item_count, error);
    if (result != PSPLAT_OK) return result;
    if (!draws_any(items, item_count)) return psplat_frame_ask_for_loss(renderer, error);
    psplat_frame f = {.renderer = renderer,
                      .view = view,
                      .items = items,
                      .item_count = item_count,
                      .error = error};
    result = prepare(&f);
    if (result == PSPLAT_OK) result = draw_frame(&f);
    return psplat_frame_finish(&f, result);
}

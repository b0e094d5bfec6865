/* SPDX-License-Identifier: MIT
 *
 * host_pass.c - what a frame shares with the host: its GL state by the renderer's policy, its own
 * resolve function, and its shadow maps.
 */
#include "renderer/frame.h"

#include <math.h>

psplat_result psplat_frame_check_host(const psplat_view *view, psplat_error *error) {
    const psplat_resolve *resolve = view->resolve;
    if (resolve && (!resolve->source || (unsigned)resolve->reads > PSPLAT_READS_NORMAL))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           resolve->source ? "the resolve function reads something unknown"
                                           : "the resolve function has no source");
    for (int i = 0; i < 2; ++i)
        if (!isfinite(view->host.depth_range[i]))
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "the depth range is not finite");
    return PSPLAT_OK;
}

/* ---- state ------------------------------------------------------------------------------- */

static int resets(const psplat_renderer *renderer) {
    return renderer->state == PSPLAT_STATE_HOST_RESETS;
}

void psplat_frame_find_depth_range(const psplat_frame *f, float range[2]) {
    const float *told = f->view->host.depth_range;
    range[0] = 0.0f;
    range[1] = 1.0f;
    if (!resets(f->renderer)) {
        f->renderer->gl.GetFloatv(GL_DEPTH_RANGE, range);
    } else if (told[0] != 0.0f || told[1] != 0.0f) {
        range[0] = told[0];
        range[1] = told[1];
    }
}

psplat_result psplat_frame_take_state(const psplat_frame *f, psplat_gl_state *state,
                                      GLuint unit_count) {
    const psplat_gl *gl = &f->renderer->gl;
    const psplat_view *view = f->view;
    const GLint viewport[4] = {view->x, view->y, view->width, view->height};
    if (!resets(f->renderer)) return psplat_gl_state_take(state, gl, unit_count, f->error);
    if (gl->is_lost) return PSPLAT_ERROR_GRAPHICS; /* psplat_gl_finish says why */
    psplat_gl_state_assume(state, gl, unit_count, &view->host, viewport);
    return PSPLAT_OK;
}

psplat_result psplat_frame_finish(const psplat_frame *f, psplat_result result) {
    psplat_gl *gl = &f->renderer->gl;
    if (resets(f->renderer) && result == PSPLAT_OK) return PSPLAT_OK;
    return psplat_gl_finish(gl, result, f->error);
}

psplat_result psplat_frame_ask_for_loss(psplat_renderer *renderer, psplat_error *error) {
    psplat_gl *gl = &renderer->gl;
    if (resets(renderer) && !gl->is_lost) psplat_gl_errors(gl, NULL);
    return psplat_gl_finish(gl, PSPLAT_OK, error);
}

/* ---- the host's resolve function --------------------------------------------------------- */

static const psplat_resolve *resolve_of(const psplat_view *view) {
    return view->mode == PSPLAT_MODE_PARAMETERS || view->depth_only ? NULL : view->resolve;
}

psplat_result psplat_frame_find_resolve(psplat_frame *f) {
    const psplat_resolve *resolve = resolve_of(f->view);
    psplat_renderer *renderer = f->renderer;
    if (!resolve) return PSPLAT_OK;
    return psplat_programs_find_host(&renderer->programs, &renderer->gl, &renderer->allocator,
                                     resolve, &f->key.host, f->error);
}

int psplat_frame_shading(const psplat_frame *f) {
    const psplat_resolve *resolve = resolve_of(f->view);
    if (resolve)
        return resolve->reads == PSPLAT_READS_NORMAL ? PSPLAT_SHADING_NORMAL : PSPLAT_SHADING_LIT;
    return f->view->mode == PSPLAT_MODE_PARAMETERS ? PSPLAT_SHADING_LIT : (int)f->view->shading;
}

int psplat_frame_reads_material(const psplat_frame *f) {
    const psplat_resolve *resolve = resolve_of(f->view);
    return psplat_shading_reads_light(psplat_frame_shading(f)) &&
           !(resolve && resolve->reads == PSPLAT_READS_COLOR);
}

void psplat_frame_use_resolve(const psplat_frame *f, const psplat_program *program) {
    const psplat_resolve *resolve = f->view->resolve;
    if (resolve->use) resolve->use(resolve->user, program->id, program->is_new);
}

/* ---- shadow maps of the host ------------------------------------------------------------- */

psplat_result psplat_frame_draw_depth(psplat_frame *f, const psplat_gl_state *state) {
    const psplat_gl *gl = &f->renderer->gl;
    const psplat_view *view = f->view;
    const psplat_program_key key = {.pass = PSPLAT_PASS_VISIBILITY};
    psplat_gl_state_bind_host(state, gl);
    gl->Viewport(view->x, view->y, view->width, view->height);
    gl->ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    gl->DepthMask(GL_TRUE);
    gl->DepthFunc(GL_LESS);
    gl->Enable(GL_DEPTH_TEST);
    return psplat_frame_draw_batches(f, &f->camera, key, view->culling);
}

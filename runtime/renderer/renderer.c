/* SPDX-License-Identifier: MIT
 *
 * renderer.c - creates and destroys the renderer and reports its memory. draw.c draws with it.
 */
#include "renderer/renderer.h"
#include "core/memory.h"

psplat_result psplat_renderer_create(const psplat_renderer_desc *desc, psplat_renderer **renderer,
                                     psplat_error *error) {
    if (renderer) *renderer = NULL;
    if (!desc || !desc->get_proc || !renderer)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "desc, its get_proc and renderer must not be NULL");
    psplat_renderer *made = psplat_allocate(&desc->allocator, 1, sizeof *made);
    if (!made) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a renderer");
    made->allocator = desc->allocator;
    made->images = desc->images;
    made->state = desc->state;
    psplat_result result = psplat_gl_load(&made->gl, desc->get_proc, desc->user, error);
    if (result != PSPLAT_OK) {
        psplat_resize(&desc->allocator, made, sizeof *made, 0);
        return result;
    }
    if (desc->half_targets) made->gl.half_targets = 1;
    made->gl.GenVertexArrays(1, &made->vertex_array);
    *renderer = made;
    return PSPLAT_OK;
}

psplat_memory psplat_renderer_memory(const psplat_renderer *renderer) {
    return renderer ? renderer->memory : (psplat_memory){0};
}

void psplat_renderer_destroy(psplat_renderer *renderer) {
    if (!renderer) return;
    psplat_allocator allocator = renderer->allocator;
    psplat_programs_destroy(&renderer->programs, &renderer->gl, &allocator);
    psplat_render_targets_destroy(&renderer->targets, &renderer->gl);
    psplat_shadows_destroy(&renderer->shadows, &renderer->gl);
    psplat_gl_samplers_delete(&renderer->samplers, &renderer->gl);
    psplat_instances_destroy(&renderer->instances, &renderer->gl, &allocator);
    renderer->gl.DeleteVertexArrays(1, &renderer->vertex_array);
    psplat_resize(&allocator, renderer, sizeof *renderer, 0);
}

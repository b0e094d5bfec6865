/* SPDX-License-Identifier: MIT
 *
 * shadow_map.c - see shadow_map.h.
 */
#include "shadow_map.h"

#include <math.h>
#include <string.h>

static const char fragment_source[] = "#version 330 core\n"
                                      "void main() {}\n";

/* Half the width of what the map covers, and its depths, around the origin. */
static const double reach = 5, near = 2, far = 18;

int shadow_map_make(shadow_map *s, const engine_gl *gl) {
    static const GLenum none = GL_NONE;
    gl->GenTextures(1, &s->texture);
    shadow_map_bind(s, gl);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, SHADOW_SIZE, SHADOW_SIZE, 0,
                   GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, NULL);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl->GenFramebuffers(1, &s->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, s->framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, s->texture, 0);
    gl->DrawBuffers(1, &none);
    gl->ReadBuffer(GL_NONE);
    return paint_make(&s->paint, gl, fragment_source);
}

void shadow_map_aim(shadow_map *s, const float direction[3]) {
    double eye[3], length = 0;
    for (int i = 0; i < 3; ++i) length += (double)direction[i] * (double)direction[i];
    for (int i = 0; i < 3; ++i) eye[i] = -10 * (double)direction[i] / sqrt(length);
    s->view = matrix_look(eye, (const double[3]){0, 0, 0});
    s->projection = matrix_parallel(reach, near, far);
}

/* Meshes lie two steps and their slope deeper in the map, so that they do not shade themselves; of
 * splats phongsplat moves each by its own tolerance. */
void shadow_map_begin(const shadow_map *s, const engine_gl *gl) {
    matrix clip = matrix_multiply(&s->projection, &s->view);
    gl->BindFramebuffer(GL_FRAMEBUFFER, s->framebuffer);
    gl->Viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
    gl->Enable(GL_DEPTH_TEST);
    gl->Clear(GL_DEPTH_BUFFER_BIT);
    gl->Enable(GL_POLYGON_OFFSET_FILL);
    gl->PolygonOffset(2, 2);
    paint_use(&s->paint, gl, &clip);
}

psplat_result shadow_map_draw_splats(const shadow_map *s, psplat_renderer *renderer,
                                     const psplat_item *items, size_t count, psplat_error *error) {
    psplat_view view = {.width = SHADOW_SIZE, .height = SHADOW_SIZE};
    view.depth_only = 1;
    view.culling = PSPLAT_CULL_NEVER; /* backs cast shadows too */
    view.host.framebuffer = s->framebuffer;
    memcpy(view.view, s->view.m, sizeof view.view);
    memcpy(view.projection, s->projection.m, sizeof view.projection);
    return psplat_draw(renderer, &view, items, count, error);
}

void shadow_map_bind(const shadow_map *s, const engine_gl *gl) {
    gl->ActiveTexture(GL_TEXTURE0 + SHADOW_UNIT);
    gl->BindTexture(GL_TEXTURE_2D, s->texture);
}

void shadow_map_matrix(const shadow_map *s, const matrix *to_world, float out[16]) {
    const matrix to_map = {
        {[0] = 0.5, [5] = 0.5, [10] = 0.5, [12] = 0.5, [13] = 0.5, [14] = 0.5, [15] = 1}};
    matrix m = matrix_multiply(&s->view, to_world);
    m = matrix_multiply(&s->projection, &m);
    m = matrix_multiply(&to_map, &m);
    matrix_to_float(&m, out);
}

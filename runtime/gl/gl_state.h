/* SPDX-License-Identifier: MIT
 *
 * gl_state.h - saves and restores the host's GL state that drawing and uploading change, or leaves
 * GL's initial values where the host resets what it needs. Reading and restoring together take
 * about 2 us with Mesa, so all of it is read each frame; in a browser, where the GL may be another
 * process, a read can wait for all that was drawn before.
 *
 * State per draw buffer or viewport (glEnablei, glColorMaski, glBlendFunci, glViewportIndexed) is
 * read and restored as that of number 0. The depth range is left alone, because depth is written in
 * the host's own range.
 */
#ifndef PHONGSPLAT_GL_GL_STATE_H
#define PHONGSPLAT_GL_GL_STATE_H

#include "gl/gl_api.h"
#include "layout.h"

#include <phongsplat/phongsplat.h>

#define PSPLAT_GL_CAPABILITY_COUNT 24

typedef struct psplat_gl_state {
    GLboolean capabilities[PSPLAT_GL_CAPABILITY_COUNT];
    GLboolean color_mask[4], depth_mask;
    GLint draw_framebuffer, program, vertex_array, array_buffer;
    GLint viewport[4], scissor_box[4];
    int knows_scissor_box; /* 0: scissor_box is not known, and must not be changed */
    GLint blend_func[4], blend_equation[2];
    GLint depth_func, cull_face, front_face, polygon_mode[2];
    GLint active_texture;
    GLuint unit_count; /* texture units that are kept */
    GLint textures[PSPLAT_UNIT_COUNT_MAPS], cubes[PSPLAT_UNIT_COUNT_MAPS];
    GLint samplers[PSPLAT_UNIT_COUNT_MAPS];
    GLint unpack_buffer, unpack[5]; /* pixel unpacking, in the order of gl_state.c */
} psplat_gl_state;

/* Reads the state, then sets the state that every pass and upload starts from: all capabilities off
 * except seamless cube maps, filled polygons, no samplers, tight unpacking from client memory. Of
 * the texture units the first unit_count are kept: PSPLAT_UNIT_COUNT, or PSPLAT_UNIT_COUNT_MAPS
 * where textures of materials are drawn. Fails only with PSPLAT_ERROR_GRAPHICS where GL does not
 * answer, because no context is current or it is lost; then nothing has changed and nothing is to
 * be restored. */
psplat_result psplat_gl_state_take(psplat_gl_state *state, const psplat_gl *gl, GLuint unit_count,
                                   psplat_error *error);

/* Fills the state with GL's initial values instead of reading it, except what known tells, then
 * sets the state that passes start from, as psplat_gl_state_take does. viewport is x, y, width and
 * height of what is left behind. psplat_gl_state_restore then leaves those values. */
void psplat_gl_state_assume(psplat_gl_state *state, const psplat_gl *gl, GLuint unit_count,
                            const psplat_host_state *known, const GLint viewport[4]);

/* Binds the host's framebuffer and restores its scissor test, for the resolve pass. The viewport
 * stays as it is. */
void psplat_gl_state_bind_host(const psplat_gl_state *state, const psplat_gl *gl);

/* Restores all of the host's state, or leaves what was assumed. */
void psplat_gl_state_restore(const psplat_gl_state *state, const psplat_gl *gl);

#endif

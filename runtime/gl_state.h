/* SPDX-License-Identifier: MIT
 *
 * gl_state.h - the host's GL state that drawing and uploading change, to be put back afterwards.
 * Both together take about 2 us with Mesa, so that all of it is read each frame.
 *
 * State per draw buffer or viewport (glEnablei, glColorMaski, glBlendFunci, glViewportIndexed) is
 * read and put back through number 0. The depth range is not touched: depth is written in the
 * host's own range.
 */
#ifndef PHONGSPLAT_GL_STATE_H
#define PHONGSPLAT_GL_STATE_H

#include "gl_api.h"
#include "layout.h"

#define PSPLAT_GL_CAPABILITY_COUNT 23

typedef struct psplat_gl_state {
    GLboolean capabilities[PSPLAT_GL_CAPABILITY_COUNT];
    GLboolean color_mask[4], depth_mask;
    GLint draw_framebuffer, program, vertex_array;
    GLint viewport[4];
    GLint blend_func[4], blend_equation[2];
    GLint depth_func, cull_face, front_face, polygon_mode[2];
    GLint active_texture;
    GLint textures[PSPLAT_UNIT_COUNT], cubes[PSPLAT_UNIT_COUNT], samplers[PSPLAT_UNIT_COUNT];
    GLint unpack_buffer, unpack[5];
} psplat_gl_state;

/* Reads the state, then sets what every pass and upload starts from: all capabilities off but
 * seamless cube maps, filled polygons, no samplers, tight unpacking from client memory. Errors:
 * GRAPHICS where GL gives no answer, as no context is current or it is lost; nothing is changed
 * then, and nothing to be restored. */
psplat_result psplat_gl_state_take(psplat_gl_state *state, const psplat_gl *gl,
                                   psplat_error *error);

/* Puts the host's framebuffer, viewport offset aside, and its scissor test back, for the resolve.
 */
void psplat_gl_state_bind_host(const psplat_gl_state *state, const psplat_gl *gl);

void psplat_gl_state_restore(const psplat_gl_state *state, const psplat_gl *gl);

#endif

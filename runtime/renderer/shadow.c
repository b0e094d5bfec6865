/* SPDX-License-Identifier: MIT
 *
 * shadow.c - the texture and the framebuffer of the shadow maps, and the uniforms by which shaders
 * read them. shadow_pass.c draws into them.
 */
#include "renderer/shadow.h"

#include <string.h>

/* Makes a framebuffer with a depth buffer alone and returns its status. Both the draw and the read
 * buffer are set to none, because GL 3.3 calls a framebuffer incomplete that lacks the colour
 * buffer it reads from (section 4.4.4; ARB_ES2_compatibility lifts this). */
static GLenum make_framebuffer(psplat_shadows *shadows, const psplat_gl *gl) {
    static const GLenum none = GL_NONE;
    GLint host = 0;
    gl->GenFramebuffers(1, &shadows->framebuffer);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, shadows->framebuffer);
    gl->FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D,
                             shadows->maps.id, 0);
    gl->DrawBuffers(1, &none);
    gl->GetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &host);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, shadows->framebuffer);
    gl->ReadBuffer(GL_NONE);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, (GLuint)host);
    return gl->CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER);
}

psplat_result psplat_shadows_bind(psplat_shadows *shadows, psplat_gl *gl, size_t *ledger, int size,
                                  int count, psplat_error *error) {
    if (shadows->size != size || shadows->count < count) psplat_shadows_destroy(shadows, gl);
    if (shadows->framebuffer) {
        gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, shadows->framebuffer);
        return PSPLAT_OK;
    }
    psplat_gl_errors(gl, NULL);
    psplat_gl_texture_desc desc = {.texel = PSPLAT_TEXEL_DEPTH32F,
                                   .width = size * count,
                                   .height = size,
                                   .is_linear = 1,
                                   .compares = 1};
    psplat_result result = psplat_gl_texture_create(gl, ledger, &desc, &shadows->maps, error);
    if (result != PSPLAT_OK) return result;
    shadows->size = size;
    shadows->count = count;
    GLenum status = make_framebuffer(shadows, gl);
    if (status == GL_FRAMEBUFFER_COMPLETE) return PSPLAT_OK;
    psplat_shadows_destroy(shadows, gl);
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0,
                       "shadow maps of %d x %d texels are refused (status 0x%x)", size, size,
                       status);
}

void psplat_shadows_destroy(psplat_shadows *shadows, const psplat_gl *gl) {
    gl->DeleteFramebuffers(1, &shadows->framebuffer);
    psplat_gl_texture_delete(gl, &shadows->maps);
    memset(shadows, 0, sizeof *shadows);
}

void psplat_shadows_use(const psplat_shadows *shadows, const psplat_gl *gl,
                        const psplat_program *program) {
    psplat_gl_texture_bind(gl, PSPLAT_UNIT_SHADOWS, &shadows->maps, GL_TEXTURE_2D);
    gl->UniformMatrix4fv(program->shadow_matrix, shadows->count, GL_FALSE, shadows->matrices[0]);
    gl->Uniform2f(program->shadow_scale, 1.0f / (float)shadows->count, shadows->lift);
}

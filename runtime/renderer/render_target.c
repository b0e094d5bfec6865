/* SPDX-License-Identifier: MIT
 *
 * render_target.c - makes and keeps float render targets. They are RGBA32F, because 16 bits lose
 * precision where many splats meet in a pixel, and RGBA16F only where the host wants that or the
 * context cannot blend 32 bits (psplat_gl.half_targets).
 */
#include "renderer/render_target.h"

#include <string.h>

/* Makes a texture of the target's size and attaches it to the bound framebuffer. Depth has 32-bit
 * floats, whose steps near 1 are those of a 24-bit buffer and finer everywhere else. */
static psplat_result add_texture(const psplat_render_target *target, psplat_gl *gl, size_t *ledger,
                                 psplat_texel texel, GLenum attachment, psplat_gl_texture *texture,
                                 psplat_error *error) {
    psplat_gl_texture_desc desc = {
        .texel = texel, .width = target->width, .height = target->height};
    psplat_result result = psplat_gl_texture_create(gl, ledger, &desc, texture, error);
    if (result == PSPLAT_OK)
        gl->FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture->id, 0);
    return result;
}

/* Returns the format of a colour texture; the second one has no more channels than needed. */
static psplat_texel texel_of(const psplat_render_target *target, const psplat_gl *gl, int index) {
    if (index != 1 || target->numbers > 2)
        return gl->half_targets ? PSPLAT_TEXEL_RGBA16F : PSPLAT_TEXEL_RGBA32F;
    if (target->numbers > 1) return gl->half_targets ? PSPLAT_TEXEL_RG16F : PSPLAT_TEXEL_RG32F;
    return gl->half_targets ? PSPLAT_TEXEL_R16F : PSPLAT_TEXEL_R32F;
}

/* Makes the textures that are missing. The target's framebuffer is bound. */
static psplat_result complete(psplat_render_target *target, psplat_gl *gl, size_t *ledger,
                              int color_count, psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    if (!target->depth.id)
        result = add_texture(target, gl, ledger, PSPLAT_TEXEL_DEPTH32F, GL_DEPTH_ATTACHMENT,
                             &target->depth, error);
    for (; result == PSPLAT_OK && target->color_count < color_count; ++target->color_count)
        result = add_texture(target, gl, ledger, texel_of(target, gl, target->color_count),
                             GL_COLOR_ATTACHMENT0 + (GLenum)target->color_count,
                             &target->colors[target->color_count], error);
    return result;
}

static psplat_result check_status(const psplat_render_target *target, const psplat_gl *gl,
                                  psplat_error *error) {
    GLenum status = gl->CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER);
    if (status == GL_FRAMEBUFFER_COMPLETE) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0,
                       "float targets of %d x %d pixels are refused (status 0x%x)", target->width,
                       target->height, status);
}

static void destroy(psplat_render_target *target, const psplat_gl *gl) {
    gl->DeleteFramebuffers(1, &target->framebuffer);
    for (int i = 0; i < PSPLAT_TARGET_COUNT_EMISSIVE; ++i)
        psplat_gl_texture_delete(gl, &target->colors[i]);
    psplat_gl_texture_delete(gl, &target->depth);
    memset(target, 0, sizeof *target);
}

static psplat_result bind(psplat_render_target *target, psplat_gl *gl, size_t *ledger,
                          int color_count, psplat_error *error) {
    static const GLenum buffers[PSPLAT_TARGET_COUNT_EMISSIVE] = {
        GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT0 + 1, GL_COLOR_ATTACHMENT0 + 2,
        GL_COLOR_ATTACHMENT0 + 3};
    if (!target->framebuffer) gl->GenFramebuffers(1, &target->framebuffer);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, target->framebuffer);

    int is_new = target->color_count < color_count;
    if (is_new) psplat_gl_errors(gl, NULL);
    psplat_result result = complete(target, gl, ledger, color_count, error);
    gl->DrawBuffers(color_count, buffers);
    if (result == PSPLAT_OK && is_new) result = check_status(target, gl, error);
    if (result != PSPLAT_OK) destroy(target, gl);
    return result;
}

/* Returns the target that has this size, or else the one whose last use is longest ago. */
static psplat_render_target *choose(psplat_render_targets *targets, int width, int height) {
    psplat_render_target *chosen = &targets->list[0];
    for (int i = 0; i < PSPLAT_TARGET_SIZES; ++i) {
        psplat_render_target *target = &targets->list[i];
        if (target->width == width && target->height == height) return target;
        if (targets->clock - target->used > targets->clock - chosen->used) chosen = target;
    }
    return chosen;
}

static void destroy_idle(psplat_render_targets *targets, const psplat_gl *gl) {
    for (int i = 0; i < PSPLAT_TARGET_SIZES; ++i) {
        psplat_render_target *target = &targets->list[i];
        if (target->framebuffer && targets->clock - target->used > PSPLAT_TARGET_IDLE)
            destroy(target, gl);
    }
}

psplat_result psplat_render_targets_bind(psplat_render_targets *targets, psplat_gl *gl,
                                         size_t *ledger, int width, int height, int color_count,
                                         int numbers, psplat_error *error) {
    ++targets->clock;
    psplat_render_target *target = choose(targets, width, height);
    if (target->width != width || target->height != height || target->numbers < numbers)
        destroy(target, gl);
    if (target->numbers < numbers) target->numbers = numbers;
    target->width = width;
    target->height = height;
    target->used = targets->clock;
    targets->current = target;
    destroy_idle(targets, gl);
    return bind(target, gl, ledger, color_count, error);
}

void psplat_render_targets_invalidate(const psplat_render_targets *targets, const psplat_gl *gl) {
    GLenum attachments[PSPLAT_TARGET_COUNT_EMISSIVE + 1] = {GL_DEPTH_ATTACHMENT};
    int count = targets->current->color_count;
    for (int i = 0; i < count; ++i) attachments[i + 1] = GL_COLOR_ATTACHMENT0 + (GLenum)i;
    if (gl->InvalidateFramebuffer)
        gl->InvalidateFramebuffer(GL_DRAW_FRAMEBUFFER, count + 1, attachments);
}

void psplat_render_targets_destroy(psplat_render_targets *targets, const psplat_gl *gl) {
    for (int i = 0; i < PSPLAT_TARGET_SIZES; ++i) destroy(&targets->list[i], gl);
}

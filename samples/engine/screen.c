/* SPDX-License-Identifier: MIT
 *
 * screen.c - the framebuffer that the engine draws into; see screen.h.
 */
#include "screen.h"

#include <stdio.h>
#include <stdlib.h>

static void attach(const engine_gl *gl, GLenum attachment, GLenum format, GLsizei samples) {
    GLuint renderbuffer;
    gl->GenRenderbuffers(1, &renderbuffer);
    gl->BindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
    gl->RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, SCREEN_WIDTH,
                                       SCREEN_HEIGHT);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, renderbuffer);
}

screen screen_make(const engine_gl *gl) {
    screen s = {0};
    gl->GenFramebuffers(1, &s.one);
    gl->GenFramebuffers(1, &s.many);
    gl->BindFramebuffer(GL_FRAMEBUFFER, s.one);
    attach(gl, GL_COLOR_ATTACHMENT0, GL_SRGB8_ALPHA8, 0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, s.many);
    attach(gl, GL_COLOR_ATTACHMENT0, GL_SRGB8_ALPHA8, SCREEN_SAMPLES);
    attach(gl, GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT24, SCREEN_SAMPLES);
    return s;
}

static void begin(const engine_gl *gl, GLuint framebuffer) {
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl->Viewport(0, 0, SCREEN_WIDTH, SCREEN_HEIGHT);
    gl->ClearColor(0.35f, 0.42f, 0.52f, 1);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void screen_begin(screen *s, const engine_gl *gl) {
    s->is_plain = 0;
    begin(gl, s->many);
}

void screen_begin_plain(screen *s, const engine_gl *gl) {
    s->is_plain = 1;
    begin(gl, s->one);
}

int screen_save(const screen *s, const engine_gl *gl, const char *path) {
    const int size = SCREEN_WIDTH * SCREEN_HEIGHT * 4;
    unsigned char *rgba = malloc((size_t)size);
    FILE *file = rgba ? fopen(path, "wb") : NULL;
    if (!file) return free(rgba), 0;
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, s->many);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, s->one);
    if (!s->is_plain)
        gl->BlitFramebuffer(0, 0, SCREEN_WIDTH, SCREEN_HEIGHT, 0, 0, SCREEN_WIDTH, SCREEN_HEIGHT,
                            GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, s->one);
    gl->ReadPixels(0, 0, SCREEN_WIDTH, SCREEN_HEIGHT, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    fprintf(file, "P6 %d %d 255\n", SCREEN_WIDTH, SCREEN_HEIGHT);
    for (int y = SCREEN_HEIGHT - 1; y >= 0; --y)
        for (int x = 0; x < SCREEN_WIDTH; ++x)
            fwrite(rgba + 4 * (y * SCREEN_WIDTH + x), 1, 3, file);
    free(rgba);
    int is_written = !ferror(file);
    return !fclose(file) && is_written;
}

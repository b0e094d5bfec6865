/* SPDX-License-Identifier: MIT
 *
 * screen.h - what the engine draws into: a framebuffer of four samples a pixel that encodes sRGB,
 * and the picture file that stands for a window here.
 */
#ifndef ENGINE_SCREEN_H
#define ENGINE_SCREEN_H

#include "engine_gl.h"

enum { SCREEN_WIDTH = 960, SCREEN_HEIGHT = 640, SCREEN_SAMPLES = 4 };

typedef struct screen {
    GLuint many, one; /* framebuffers: many with samples, one resolved */
    int is_plain;     /* 1: the last frame was drawn into `one` */
} screen;

screen screen_make(const engine_gl *gl);
/* Clears the framebuffer of four samples and leaves it bound, or the one without. */
void screen_begin(screen *s, const engine_gl *gl);
void screen_begin_plain(screen *s, const engine_gl *gl);
/* Writes a PPM; returns 0 on failure. */
int screen_save(const screen *s, const engine_gl *gl, const char *path);

#endif

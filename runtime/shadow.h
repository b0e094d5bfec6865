/* SPDX-License-Identifier: MIT
 *
 * shadow.h - depth maps as lights see the splats, side by side in one texture.
 */
#ifndef PHONGSPLAT_SHADOW_H
#define PHONGSPLAT_SHADOW_H

#include "program.h"
#include "texture.h"

typedef struct psplat_shadows {
    GLuint framebuffer;
    psplat_texture maps;
    float lift;      /* off the surface, of what is compared with the maps */
    int size, count; /* texels along an edge of each; how many there are */
    float matrices[PSPLAT_SHADOW_COUNT][16]; /* eye space of the view to the map: 0 ... 1 each */
} psplat_shadows;

void psplat_shadows_destroy(psplat_shadows *shadows, const psplat_gl *gl);

/* To the current program. */
void psplat_shadows_use(const psplat_shadows *shadows, const psplat_gl *gl,
                        const psplat_program *program);

#endif

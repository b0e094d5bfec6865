/* SPDX-License-Identifier: MIT
 *
 * shadow.h - shadow maps: the depth of all splats as lights see them. The maps of a view lie side
 * by side in one texture, in the order of psplat_lights.casters.
 */
#ifndef PHONGSPLAT_RENDERER_SHADOW_H
#define PHONGSPLAT_RENDERER_SHADOW_H

#include "gl/gl_program.h"
#include "gl/gl_texture.h"

typedef struct psplat_shadows {
    GLuint framebuffer;
    psplat_gl_texture maps;
    float lift;      /* distance in scene units by which points are lifted off their surface before
                        they are compared with the maps */
    int size, count; /* texels along an edge of a map; number of maps in the texture */
    float matrices[PSPLAT_SHADOW_COUNT][16]; /* eye space of the view to a map's 0 ... 1 */
} psplat_shadows;

/* Makes count maps of size x size texels unless the texture already has that size and at least as
 * many, and leaves their framebuffer bound for drawing. The texture's bytes are added to *ledger.
 * On failure there are no maps. Errors: GRAPHICS, MEMORY. */
psplat_result psplat_shadows_bind(psplat_shadows *shadows, psplat_gl *gl, size_t *ledger, int size,
                                  int count, psplat_error *error);

/* Deletes the maps. Zeros are accepted. */
void psplat_shadows_destroy(psplat_shadows *shadows, const psplat_gl *gl);

/* Binds the maps for sampling and sets the current program's uniforms for them. */
void psplat_shadows_use(const psplat_shadows *shadows, const psplat_gl *gl,
                        const psplat_program *program);

#endif

/* SPDX-License-Identifier: MIT
 *
 * texels.glsl - where splats lie in the textures that layout.h lists, and what is read there by
 * vertex shaders and by fragments alike.
 *
 * gl_program.c defines WIDE, SHAPE, FINISH and CLIP_COUNT.
 */

/* Returns the column and the row of a splat in the textures, counted in splats. */
ivec2 place_of(int splat) {
    const int bits = PSPLAT_SPLAT_ROW_BITS(WIDE, SHAPE);
    return ivec2(splat & ((1 << bits) - 1), splat >> bits);
}

#if FINISH
uniform highp sampler2D u_finishes;
uniform int u_finish; /* PSPLAT_FINISH_ bits */

/* Returns the first texel of the finish of a splat at place. */
ivec2 finish_texel_of(ivec2 place) {
    int surface = u_finish & PSPLAT_FINISH_SURFACE;
    int emissive = (u_finish & PSPLAT_FINISH_EMISSIVE) / PSPLAT_FINISH_EMISSIVE;
    int gradient = (u_finish & PSPLAT_FINISH_GRADIENT) / PSPLAT_FINISH_GRADIENT;
    return ivec2(place.x * (surface + emissive + 2 * gradient), place.y);
}

/* Reads occlusion with roughness and metallic, and emission; what the batch has not stays as it is.
 * Moves texel on to what follows. */
void read_surface(inout ivec2 texel, inout vec3 surface, inout vec3 emissive) {
    if ((u_finish & PSPLAT_FINISH_SURFACE) > 0) {
        surface = texelFetch(u_finishes, texel, 0).rgb;
        ++texel.x;
    }
    if ((u_finish & PSPLAT_FINISH_EMISSIVE) > 0) {
        emissive = texelFetch(u_finishes, texel, 0).rgb;
        ++texel.x;
    }
}
#endif

/* Whether fragments of curved splats read their surface themselves. Some GLs have only 15 vectors
 * for varyings, of which gl_FragCoord takes 1; four lines and a whole finish would take 15 more. */
#define READS_SURFACE (FINISH == 1 && CLIP_COUNT == 4)

/* SPDX-License-Identifier: MIT
 *
 * pack.c - packs splats for the GPU: 48 bytes a splat, 16 more where it has a colour or a gamma,
 * and 12 for each clip line and for each further value that varies over the splat.
 */
#include "asset/pack.h"
#include "layout.h"

#include <math.h>

enum { NARROW = 4 * PSPLAT_SPLAT_TEXELS, WIDE = NARROW + 4 };

psplat_packing psplat_packing_of(const psplat_batch *batch) {
    unsigned surface = batch->has_surface ? PSPLAT_FINISH_SURFACE : 0u;
    unsigned emissive = batch->has_emissive ? PSPLAT_FINISH_EMISSIVE : 0u;
    unsigned gradient = batch->has_color_gradient ? PSPLAT_FINISH_GRADIENT : 0u;
    return (psplat_packing){.splat_floats = batch->has_color || batch->has_gamma ? WIDE : NARROW,
                            .clip_floats = 3 * (int)batch->clip_count,
                            .finish_floats = 3 * (!!surface + !!emissive + (gradient ? 2 : 0)),
                            .finish = surface | emissive | gradient};
}

psplat_packed *psplat_packed_reserve(psplat_arena *arena, const psplat_packing *packing,
                                     size_t splat_count) {
    const int floats[] = {packing->splat_floats, packing->clip_floats, packing->finish_floats};
    psplat_packed *packed = psplat_arena_take(arena, 1, sizeof *packed);
    if (!packed) return NULL;
    float **arrays[] = {&packed->splats, &packed->clips, &packed->finishes};
    for (size_t i = 0; i < 3; ++i) {
        if (!floats[i]) continue;
        *arrays[i] = psplat_arena_reserve(arena, splat_count, (size_t)floats[i] * sizeof(float));
        if (!*arrays[i]) return NULL;
    }
    packed->chunks =
        psplat_arena_reserve(arena, psplat_chunk_count(splat_count), sizeof *packed->chunks);
    return packed->chunks ? packed : NULL;
}

static void pack_splat(const psplat_splat *splat, float *out) {
    const float *q = splat->rotation;
    double length2 = 0.0;
    for (int i = 0; i < 4; ++i) length2 += (double)q[i] * (double)q[i];
    double x = q[0], y = q[1], z = q[2], w = q[3];
    const double axes[3][3] = {
        /* The rotation matrix times length2. */
        {length2 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
        {2 * (x * y - w * z), length2 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
        {2 * (x * z + w * y), 2 * (y * z - w * x), length2 - 2 * (x * x + y * y)}};
    double local[3]; /* the normal in U, V, N (spec 3.5, eq. 3) */
    for (int i = 0; i < 3; ++i)
        local[i] = splat->normal[0] * axes[i][0] + splat->normal[1] * axes[i][1] +
                   splat->normal[2] * axes[i][2];

    double scale = sqrt((double)splat->radius[0] / length2), height = 1 / local[2];
    for (int i = 0; i < 3; ++i) out[i] = splat->center[i];
    out[3] = splat->radius[1] / splat->radius[0];
    for (int i = 0; i < 4; ++i) out[4 + i] = (float)(q[i] * scale);
    out[8] = (float)(local[0] * height);
    out[9] = (float)(local[1] * height);
    out[10] = splat->gradient[0];
    out[11] = splat->gradient[1];
}

void psplat_pack_splats(const psplat_packing *packing, const psplat_splat *splats, size_t count,
                        float *out) {
    for (size_t i = 0; i < count; ++i, out += packing->splat_floats) {
        pack_splat(&splats[i], out);
        if (packing->splat_floats == NARROW) continue;
        for (int k = 0; k < 3; ++k) out[NARROW + k] = splats[i].color[k];
        out[NARROW + 3] = splats[i].gradient[2];
    }
}

void psplat_pack_clips(const psplat_packing *packing, const psplat_splat *splats, size_t count,
                       float *out) {
    for (size_t i = 0; i < count; ++i)
        for (int line = 0; line < packing->clip_floats / 3; ++line)
            for (int k = 0; k < 3; ++k) *out++ = splats[i].clip[line][k];
}

static float *put_texel(float *out, const float texel[3]) {
    for (int i = 0; i < 3; ++i) out[i] = texel[i];
    return out + 3;
}

void psplat_pack_finishes(const psplat_packing *packing, const psplat_finish *finishes,
                          size_t count, float *out) {
    for (size_t i = 0; i < count; ++i) {
        const psplat_finish *finish = &finishes[i];
        const float surface[3] = {finish->occlusion, finish->roughness, finish->metallic};
        if (packing->finish & PSPLAT_FINISH_SURFACE) out = put_texel(out, surface);
        if (packing->finish & PSPLAT_FINISH_EMISSIVE) out = put_texel(out, finish->emissive);
        if (!(packing->finish & PSPLAT_FINISH_GRADIENT)) continue;
        out = put_texel(out, finish->color_u);
        out = put_texel(out, finish->color_v);
    }
}

/* SPDX-License-Identifier: MIT
 *
 * pack.c - packs splats for the GPU: 48 bytes a splat, 16 more where it has a colour or a gamma and
 * where it has a shape of its own, 12 for each clip line (16 for bent ones), 12 for each further
 * value that varies over the splat, and 24 for texture coordinates (48 with their second order; a
 * third more beside colours).
 */
#include "asset/pack.h"
#include "layout.h"

#include <math.h>

enum { NARROW = 4 * PSPLAT_SPLAT_TEXELS };

psplat_packing psplat_packing_of(const psplat_batch *batch) {
    unsigned surface = batch->has_surface ? PSPLAT_FINISH_SURFACE : 0u;
    unsigned emissive = batch->has_emissive ? PSPLAT_FINISH_EMISSIVE : 0u;
    unsigned gradient = batch->has_color_gradient ? PSPLAT_FINISH_GRADIENT : 0u;
    int is_wide = batch->has_color || batch->has_gamma;
    int has_shape = batch->is_curved && batch->has_shape;
    int line_floats = batch->has_bends ? 4 : 3, channels = batch->has_color ? 4 : 3;
    int texcoord_texels = !batch->has_texcoord ? 0 : batch->has_texcoord_bend ? 4 : 2;
    return (psplat_packing){.splat_floats = NARROW + 4 * (is_wide + has_shape),
                            .clip_floats = line_floats * (int)batch->clip_count,
                            .finish_floats = 3 * (!!surface + !!emissive + (gradient ? 2 : 0)),
                            .texcoord_floats = channels * texcoord_texels,
                            .line_floats = line_floats,
                            .texcoord_channels = channels,
                            .is_curved = !!batch->is_curved,
                            .wide_at = is_wide ? NARROW : 0,
                            .shape_at = has_shape ? NARROW + 4 * is_wide : 0,
                            .row_splats = 1 << PSPLAT_SPLAT_ROW_BITS(is_wide, has_shape),
                            .finish = surface | emissive | gradient};
}

psplat_packed *psplat_packed_reserve(psplat_arena *arena, const psplat_packing *packing,
                                     size_t splat_count) {
    const int floats[] = {packing->splat_floats, packing->clip_floats, packing->finish_floats,
                          packing->texcoord_floats};
    psplat_packed *packed = psplat_arena_take(arena, 1, sizeof *packed);
    if (!packed) return NULL;
    float **arrays[] = {&packed->splats, &packed->clips, &packed->finishes, &packed->texcoords};
    for (size_t i = 0; i < sizeof floats / sizeof *floats; ++i) {
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
        if (packing->wide_at) {
            for (int k = 0; k < 3; ++k) out[packing->wide_at + k] = splats[i].color[k];
            out[packing->wide_at + 3] = splats[i].gradient[2];
        }
        if (packing->shape_at) {
            for (int k = 0; k < 3; ++k) out[packing->shape_at + k] = splats[i].shape[2 + k];
            out[packing->shape_at + 3] = 0.0f;
        }
    }
}

/* Half the largest eigenvalue, in magnitude, of the Hessian of (1a) over the unit disc. */
static float sagitta_of(const psplat_packing *packing, const float *splat) {
    const float *q = splat + 4,
                *second = packing->shape_at ? splat + packing->shape_at : splat + 10;
    float radius = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    float gamma = packing->shape_at  ? second[2]
                  : packing->wide_at ? splat[packing->wide_at + 3]
                                     : 0.0f;
    float a = second[0], b = splat[3] * gamma, c = splat[3] * second[1];
    float root = sqrtf(0.25f * (a - c) * (a - c) + b * b);
    return 0.5f * radius * (fabsf(0.5f * (a + c)) + root);
}

float psplat_packed_sagitta(const psplat_packing *packing, const float *splats, size_t count) {
    float most = 0.0f;
    for (size_t i = 0; packing->is_curved && i < count; ++i)
        most = fmaxf(most, sagitta_of(packing, splats + i * (size_t)packing->splat_floats));
    return most;
}

void psplat_packed_spheres(const psplat_packing *packing, const float *splats, size_t count,
                           float *spheres) {
    for (size_t i = 0; i < count; ++i) {
        const float *splat = splats + i * (size_t)packing->splat_floats, *q = splat + 4;
        float radius = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], height = 0.0f;
        if (packing->is_curved && !packing->shape_at) height = radius * hypotf(splat[8], splat[9]);
        if (packing->is_curved) height += sagitta_of(packing, splat);
        for (int k = 0; k < 3; ++k) spheres[4 * i + (size_t)k] = splat[k];
        spheres[4 * i + 3] = 1.00001f * hypotf(radius, height); /* rounded outwards */
    }
}

static int is_cut(const psplat_packing *packing, const float *lines) {
    for (int i = 0; i < packing->clip_floats; i += packing->line_floats)
        if (lines[i] != 1.0f || lines[i + 1] != 0.0f || lines[i + 2] != 1.0f ||
            (packing->line_floats == 4 && lines[i + 3] != 0.0f))
            return 1;
    return 0;
}

size_t psplat_packed_uncut(const psplat_packing *packing, const float *clips, size_t count) {
    size_t uncut = 0;
    for (size_t i = 0; i < count; ++i)
        uncut += !is_cut(packing, clips + i * (size_t)packing->clip_floats);
    return uncut;
}

void psplat_pack_clips(const psplat_packing *packing, const psplat_splat *splats, size_t count,
                       float *out) {
    for (size_t i = 0; i < count; ++i)
        for (int line = 0; line < packing->clip_floats / packing->line_floats; ++line) {
            for (int k = 0; k < 3; ++k) *out++ = splats[i].clip[line][k];
            if (packing->line_floats == 4) *out++ = splats[i].bend[line];
        }
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

void psplat_pack_texcoords(const psplat_packing *packing, const psplat_splat *splats,
                           const psplat_texcoord *texcoords, size_t count, float *out) {
    int channels = packing->texcoord_channels, numbers = packing->texcoord_floats / channels * 3;
    for (size_t i = 0; i < count; ++i) {
        const psplat_texcoord *t = &texcoords[i];
        const float values[] = {t->at[0],       t->at[1],       t->along_u[0],  t->along_u[1],
                                t->along_v[0],  t->along_v[1],  t->along_uu[0], t->along_uu[1],
                                t->along_uv[0], t->along_uv[1], t->along_vv[0], t->along_vv[1]};
        for (int k = 0; k < numbers; k += 3) {
            out = put_texel(out, values + k);
            if (channels == 4) *out++ = splats[i].color[3];
        }
    }
}

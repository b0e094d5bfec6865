/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * fold.c - what is the same in all splats of a material goes into the material, so that nothing is
 * stored per splat that does not vary.
 */
#include "stages.h"

#include <stdlib.h>
#include <string.h>

/* Values that differ by less are the same: textures of one colour, averaged in different places. */
static const float same = 1e-4f;

enum { COLOR = 4, FINISH = 3, EMISSIVE = 3, VALUES = COLOR + FINISH + EMISSIVE + 6 };

/* Of all values of a splat: least and greatest in one material. The last six are gradients. */
typedef struct span {
    float low[VALUES], high[VALUES];
    int seen;
} span;

static void values_of(const psplat_splats *splats, size_t i, float values[VALUES]) {
    memcpy(values, splats->splats[i].color, COLOR * sizeof *values);
    for (int k = COLOR; k < VALUES; ++k) values[k] = k < VALUES - 6 ? 1 : 0;
    if (!splats->finishes) return;
    const psplat_finish *finish = &splats->finishes[i];
    values[COLOR] = finish->occlusion;
    values[COLOR + 1] = finish->roughness;
    values[COLOR + 2] = finish->metallic;
    memcpy(values + COLOR + FINISH, finish->emissive, EMISSIVE * sizeof *values);
    memcpy(values + VALUES - 6, finish->color_u, 3 * sizeof *values);
    memcpy(values + VALUES - 3, finish->color_v, 3 * sizeof *values);
}

static void extend(span *s, const float values[VALUES]) {
    for (int k = 0; k < VALUES; ++k) {
        if (!s->seen || values[k] < s->low[k]) s->low[k] = values[k];
        if (!s->seen || values[k] > s->high[k]) s->high[k] = values[k];
    }
    s->seen = 1;
}

static int is_constant(const span *s, int first, int count) {
    for (int k = first; k < first + count; ++k)
        if (s->high[k] - s->low[k] > same) return 0;
    return 1;
}

/* Calls visit with each splat of each material. */
static void each(psplat_splats *splats, span *spans,
                 void (*visit)(psplat_splats *splats, size_t i, span *s)) {
    for (size_t run = 0, i = 0; run < splats->run_count; ++run)
        for (size_t end = i + splats->runs[run].count; i < end; ++i)
            visit(splats, i, &spans[splats->runs[run].material]);
}

static void measure(psplat_splats *splats, size_t i, span *s) {
    float values[VALUES];
    values_of(splats, i, values);
    extend(s, values);
}

/* Where it changes over a splat, it stays the splat's. */
static int color_folds(const span *s) {
    for (int k = VALUES - 6; k < VALUES; ++k)
        if (s->low[k] < -same || s->high[k] > same) return 0;
    return is_constant(s, 0, COLOR);
}

static void fold_material(const span *s, psplat_material *material) {
    const int shine = COLOR + 1, glow = COLOR + FINISH;
    if (!s->seen) return;
    for (int k = 0; k < 4 && color_folds(s); ++k) material->base_color[k] *= s->high[k];
    if (is_constant(s, shine, 1)) material->roughness *= s->high[shine];
    if (is_constant(s, shine + 1, 1)) material->metallic *= s->high[shine + 1];
    for (int k = 0; k < 3 && is_constant(s, glow, EMISSIVE); ++k)
        material->emissive[k] *= s->high[glow + k];
}

static void fold_splat(psplat_splats *splats, size_t i, span *s) {
    psplat_finish *finish = splats->finishes ? &splats->finishes[i] : NULL;
    for (int k = 0; k < 4 && color_folds(s); ++k) splats->splats[i].color[k] = 1;
    if (!finish) return;
    if (is_constant(s, COLOR + 1, 1)) finish->roughness = 1;
    if (is_constant(s, COLOR + 2, 1)) finish->metallic = 1;
    for (int k = 0; k < 3 && is_constant(s, COLOR + FINISH, EMISSIVE); ++k) finish->emissive[k] = 1;
}

/* Whether something is left: values other than 1, gradients other than 0. */
static void find_rest(psplat_splats *splats, size_t i, span *s) {
    float values[VALUES];
    values_of(splats, i, values);
    for (int k = 0; k < VALUES; ++k) {
        float rest = values[k] - (k < VALUES - 6 ? 1 : 0);
        if (rest < -same || rest > same) s->high[k] = 2;
    }
}

/* Forgets what no splat of any material needs. */
static void drop(psplat_splats *splats, const span *spans) {
    int colors = 0, finishes = 0;
    for (size_t m = 0; m < splats->material_count; ++m)
        for (int k = 0; k < VALUES; ++k) *(k < COLOR ? &colors : &finishes) |= spans[m].high[k] > 1;
    splats->has_color = colors;
    if (finishes) return;
    free(splats->finishes);
    splats->finishes = NULL;
}

psplat_result psplat_fold(psplat_splats *splats) {
    span *spans = calloc(splats->material_count + 1, sizeof *spans);
    if (!spans) return PSPLAT_ERROR_MEMORY;
    each(splats, spans, measure);
    for (size_t m = 0; m < splats->material_count; ++m)
        fold_material(&spans[m], &splats->materials[m]);
    each(splats, spans, fold_splat);
    memset(spans, 0, splats->material_count * sizeof *spans);
    each(splats, spans, find_rest);
    drop(splats, spans);
    free(spans);
    return PSPLAT_OK;
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * hoist_constants.c - moves values that all splats of a material share into the material.
 *
 * It finds the range of every colour and finish value over the splats of each material. A value
 * whose range is next to nothing multiplies the material's factor and becomes 1 in the splats.
 * Attributes that no splat needs afterwards are dropped, so that a file stores only what varies.
 */
#include "splats/hoist_constants.h"

#include "splats/splats.h"

#include <stdlib.h>
#include <string.h>

/* Values (parts of 1) that differ by no more than this count as equal. A texture of one colour
 * gives values that differ by less when it is averaged in different places. Chosen by hand. */
static const float equal_tolerance = 1e-4f;

/* The numbers of a splat's values of each kind. The gradients come last. */
enum {
    COLOR = 4,
    FINISH = 3,
    EMISSIVE = 3,
    GRADIENTS = 6,
    VALUES = COLOR + FINISH + EMISSIVE + GRADIENTS
};

/* The least and the greatest of each value over the splats of one material. */
typedef struct span {
    float low[VALUES], high[VALUES];
    int seen;
} span;

/* Returns what a value is where it changes nothing: 1 for factors, 0 for gradients. */
static float neutral_value(int k) {
    return k < VALUES - GRADIENTS ? 1 : 0;
}

static void values_of(const psplat_splats *splats, size_t i, float values[VALUES]) {
    memcpy(values, splats->splats[i].color, COLOR * sizeof *values);
    for (int k = COLOR; k < VALUES; ++k) values[k] = neutral_value(k);
    if (!splats->finishes) return;
    const psplat_finish *finish = &splats->finishes[i];
    values[COLOR] = finish->occlusion;
    values[COLOR + 1] = finish->roughness;
    values[COLOR + 2] = finish->metallic;
    memcpy(values + COLOR + FINISH, finish->emissive, EMISSIVE * sizeof *values);
    memcpy(values + VALUES - GRADIENTS, finish->color_u, 3 * sizeof *values);
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
        if (s->high[k] - s->low[k] > equal_tolerance) return 0;
    return 1;
}

/* Calls visit for each splat, with the span of its material. */
static void for_each_splat(psplat_splats *splats, span *spans,
                           void (*visit)(psplat_splats *splats, size_t i, span *s)) {
    for (size_t run = 0, i = 0; run < splats->run_count; ++run)
        for (size_t end = i + splats->runs[run].count; i < end; ++i)
            visit(splats, i, &spans[splats->runs[run].material]);
}

static void extend_by_splat(psplat_splats *splats, size_t i, span *s) {
    float values[VALUES];
    values_of(splats, i, values);
    extend(s, values);
}

/* Returns whether the colour can go into the material. It must be the same in all splats, and it
 * must not change over any of them. */
static int color_folds(const span *s) {
    for (int k = VALUES - GRADIENTS; k < VALUES; ++k)
        if (s->low[k] < -equal_tolerance || s->high[k] > equal_tolerance) return 0;
    return is_constant(s, 0, COLOR);
}

static void fold_material(const span *s, psplat_material *material) {
    const int roughness = COLOR + 1, metallic = COLOR + 2, emissive = COLOR + FINISH;
    if (!s->seen) return;
    for (int k = 0; k < 4 && color_folds(s); ++k) material->base_color[k] *= s->high[k];
    if (is_constant(s, roughness, 1)) material->roughness *= s->high[roughness];
    if (is_constant(s, metallic, 1)) material->metallic *= s->high[metallic];
    for (int k = 0; k < 3 && is_constant(s, emissive, EMISSIVE); ++k)
        material->emissive[k] *= s->high[emissive + k];
}

static void fold_splat(psplat_splats *splats, size_t i, span *s) {
    psplat_finish *finish = splats->finishes ? &splats->finishes[i] : NULL;
    for (int k = 0; k < 4 && color_folds(s); ++k) splats->splats[i].color[k] = 1;
    if (!finish) return;
    if (is_constant(s, COLOR + 1, 1)) finish->roughness = 1;
    if (is_constant(s, COLOR + 2, 1)) finish->metallic = 1;
    for (int k = 0; k < 3 && is_constant(s, COLOR + FINISH, EMISSIVE); ++k) finish->emissive[k] = 1;
}

/* Marks, by a greatest value of 2, the values of a material that are not neutral in a splat. */
static void find_remaining(psplat_splats *splats, size_t i, span *s) {
    float values[VALUES];
    values_of(splats, i, values);
    for (int k = 0; k < VALUES; ++k) {
        float remaining = values[k] - neutral_value(k);
        if (remaining < -equal_tolerance || remaining > equal_tolerance) s->high[k] = 2;
    }
}

/* Drops the colours, the finishes, or both, where they are neutral in all splats. */
static void drop_unused(psplat_splats *splats, const span *spans) {
    int colors = 0, finishes = 0;
    for (size_t m = 0; m < splats->material_count; ++m)
        for (int k = 0; k < VALUES; ++k) *(k < COLOR ? &colors : &finishes) |= spans[m].high[k] > 1;
    splats->has_color = colors;
    if (finishes) return;
    free(splats->finishes);
    splats->finishes = NULL;
}

psplat_result psplat_hoist_constants(psplat_splats *splats) {
    span *spans = calloc(splats->material_count + 1, sizeof *spans);
    if (!spans) return PSPLAT_ERROR_MEMORY;
    for_each_splat(splats, spans, extend_by_splat);
    for (size_t m = 0; m < splats->material_count; ++m)
        fold_material(&spans[m], &splats->materials[m]);
    for_each_splat(splats, spans, fold_splat);
    memset(spans, 0, splats->material_count * sizeof *spans);
    for_each_splat(splats, spans, find_remaining);
    drop_unused(splats, spans);
    free(spans);
    return PSPLAT_OK;
}

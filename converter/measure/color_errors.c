/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * color_errors.c - how far the blended look of splats is from that of the surface.
 *
 * Along the edge of a painted area splats of both sides blend, and the edge lies a little beside
 * where it was, as outlines do. So a sample whose own look is missed asks its neighbours, which a
 * hash grid finds: what lies between the looks on both sides of an edge within reach is right.
 */
#include "measure/color_errors.h"

#include "appearance/appearance.h"
#include "base/vector.h"
#include "features/samples.h"
#include "features/surface.h"
#include "material/mipmap.h"
#include "measure/point_blend.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The bounds of the number of points. A share of wrong ones of 50 of 1000 is known to 2 % of itself
 * with the least number, and to 1 % with the greatest. Chosen by hand. */
enum { LEAST_POINTS = 50000, MOST_POINTS = 250000 };

int psplat_samples_have_look(const psplat_samples *samples) {
    return samples->colors || samples->finishes || samples->emissive;
}

size_t psplat_color_point_count(const psplat_surface *surface, double tolerance) {
    double wanted = surface->area / (tolerance * tolerance);
    if (surface->appearance) wanted = max2(wanted, psplat_appearance_texels(surface->appearance));
    return (size_t)min2(max2(wanted, LEAST_POINTS), MOST_POINTS);
}

void psplat_blended_look(const psplat_point_blend *blend, float look[PSPLAT_LOOK_VALUES]) {
    for (int k = 0; k < PSPLAT_LOOK_VALUES; ++k) {
        double sum = k < 3 ? blend->color[k] : blend->finish[k - PSPLAT_LOOK_EMISSIVE];
        look[k] = blend->weight > 0 ? (float)(sum / blend->weight) : -1;
    }
}

void psplat_expected_look(const psplat_surface *surface, const psplat_samples *samples, size_t i,
                          float look[PSPLAT_LOOK_VALUES]) {
    const psplat_mesh *mesh = surface->mesh;
    uint32_t group = mesh->groups ? mesh->groups[samples->triangles[i]] : 0;
    const psplat_material *m = group < mesh->source_material_count
                                   ? &mesh->source_materials[group].material
                                   : &mesh->material;
    memset(look, 0, PSPLAT_LOOK_VALUES * sizeof *look);
    for (size_t k = 0; k < 3; ++k)
        look[k] = m->base_color[k] * (samples->colors ? samples->colors[4 * i + k] : 1);
    if (m->unlit) return;
    for (size_t k = 0; k < 3; ++k)
        look[PSPLAT_LOOK_EMISSIVE + k] =
            m->emissive[k] * (samples->emissive ? samples->emissive[3 * i + k] : 1);
    look[PSPLAT_LOOK_ROUGHNESS] =
        m->roughness * (samples->finishes ? samples->finishes[3 * i + 1] : 1);
    look[PSPLAT_LOOK_METALLIC] =
        m->metallic * (samples->finishes ? samples->finishes[3 * i + 2] : 1);
}

static double color_difference(const float a[3], const float b[3]) {
    double squares = 0;
    for (int k = 0; k < 3; ++k) {
        double d = (double)psplat_srgb_of_linear(a[k]) - (double)psplat_srgb_of_linear(b[k]);
        squares += d * d;
    }
    return sqrt(squares / 3);
}

double psplat_look_difference(const float a[PSPLAT_LOOK_VALUES],
                              const float b[PSPLAT_LOOK_VALUES]) {
    double greatest = color_difference(a + PSPLAT_LOOK_BASE, b + PSPLAT_LOOK_BASE);
    if (memcmp(a + PSPLAT_LOOK_EMISSIVE, b + PSPLAT_LOOK_EMISSIVE, 3 * sizeof *a) != 0)
        greatest =
            max2(greatest, color_difference(a + PSPLAT_LOOK_EMISSIVE, b + PSPLAT_LOOK_EMISSIVE));
    for (int k = PSPLAT_LOOK_ROUGHNESS; k <= PSPLAT_LOOK_METALLIC; ++k)
        greatest = max2(greatest, fabs((double)a[k] - (double)b[k]));
    return 100 * greatest;
}

/* ---- neighbours ------------------------------------------------------------------------------ */

/* A hash grid over samples whose cells are as wide as the reach. Chains end with PSPLAT_NONE. */
typedef struct look_grid {
    const psplat_samples *samples;
    uint32_t *heads, *nexts;
    size_t mask;
    double cell;
} look_grid;

static void cell_of(const look_grid *grid, const double p[3], int64_t cell[3]) {
    for (int k = 0; k < 3; ++k) cell[k] = (int64_t)floor(p[k] / grid->cell);
}

static size_t slot_of(const look_grid *grid, const int64_t cell[3]) {
    uint64_t h = (uint64_t)cell[0] * 0x8da6b343u ^ (uint64_t)cell[1] * 0xd8163841u ^
                 (uint64_t)cell[2] * 0xcb1ab31fu;
    return (size_t)(h ^ (h >> 29)) & grid->mask;
}

static void free_grid(look_grid *grid) {
    free(grid->heads);
    free(grid->nexts);
}

static int build_grid(const psplat_samples *samples, double reach, look_grid *grid) {
    size_t size = 1024;
    while (size < samples->count) size *= 2;
    *grid = (look_grid){.samples = samples, .mask = size - 1, .cell = reach};
    grid->heads = malloc(size * sizeof *grid->heads);
    grid->nexts = malloc((samples->count + 1) * sizeof *grid->nexts);
    if (!grid->heads || !grid->nexts) return 0;
    memset(grid->heads, 0xff, size * sizeof *grid->heads);
    for (size_t i = samples->count; i-- > 0;) {
        int64_t cell[3];
        cell_of(grid, samples->positions + 3 * i, cell);
        size_t slot = slot_of(grid, cell);
        grid->nexts[i] = grid->heads[slot];
        grid->heads[slot] = (uint32_t)i;
    }
    return 1;
}

/* ---- errors ---------------------------------------------------------------------------------- */

/* Returns the difference between what is shown and the mixture of two looks that is nearest to it
 * in linear light. */
static double mixture_difference(const float *shown, const float *own, const float *other) {
    double along = 0, length = 0;
    float mixed[PSPLAT_LOOK_VALUES];
    for (int k = 0; k < PSPLAT_LOOK_VALUES; ++k) {
        double d = (double)other[k] - (double)own[k];
        along += d * ((double)shown[k] - (double)own[k]);
        length += d * d;
    }
    double part = length > 0 ? min2(max2(along / length, 0), 1) : 0;
    for (int k = 0; k < PSPLAT_LOOK_VALUES; ++k)
        mixed[k] = (float)((1 - part) * (double)own[k] + part * (double)other[k]);
    return psplat_look_difference(shown, mixed);
}

/* Returns whether sample b may stand for sample a. */
static int is_neighbor(const psplat_samples *s, size_t a, size_t b, double reach) {
    double d[3], cosine = 0;
    sub3(d, s->positions + 3 * a, s->positions + 3 * b);
    for (size_t k = 0; k < 3; ++k)
        cosine += (double)s->normals[3 * a + k] * (double)s->normals[3 * b + k];
    return dot3(d, d) <= reach * reach && cosine > 0;
}

/* Returns the least difference to a mixture with a neighbour, given that to the sample's own look.
 * Stops at one within the limit. */
static double neighbors_error(const psplat_surface *surface, const look_grid *grid, size_t i,
                              const float *shown, const float *own, double limit, double error) {
    const psplat_samples *samples = grid->samples;
    int64_t base[3], cell[3];
    cell_of(grid, samples->positions + 3 * i, base);
    for (int n = 0; n < 27; ++n) {
        cell[0] = base[0] + n % 3 - 1, cell[1] = base[1] + n / 3 % 3 - 1,
        cell[2] = base[2] + n / 9 - 1;
        for (uint32_t k = grid->heads[slot_of(grid, cell)]; k != PSPLAT_NONE; k = grid->nexts[k]) {
            float other[PSPLAT_LOOK_VALUES];
            if (error <= limit) return error;
            if (k == i || !is_neighbor(samples, i, k, grid->cell)) continue;
            psplat_expected_look(surface, samples, k, other);
            error = min2(error, mixture_difference(shown, own, other));
        }
    }
    return error;
}

psplat_result psplat_color_errors_find(const psplat_surface *surface, const psplat_samples *samples,
                                       const float *shown, double reach, double limit,
                                       double *errors) {
    look_grid grid;
    int ok = build_grid(samples, reach, &grid);
    long end = ok ? (long)samples->count : 0;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 1024)
#endif
    for (long i = 0; i < end; ++i) {
        const float *seen = shown + PSPLAT_LOOK_VALUES * (size_t)i;
        float own[PSPLAT_LOOK_VALUES];
        errors[i] = -1;
        if (seen[0] < 0) continue;
        psplat_expected_look(surface, samples, (size_t)i, own);
        errors[i] = psplat_look_difference(seen, own);
        if (errors[i] > limit)
            errors[i] = neighbors_error(surface, &grid, (size_t)i, seen, own, limit, errors[i]);
    }
    free_grid(&grid);
    return ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

/* Extends a range by the look of a sample. */
static void extend_range(const psplat_samples *samples, size_t i, float *range) {
    float look[PSPLAT_LOOK_VALUES] = {0};
    if (samples->colors) memcpy(look, samples->colors + 4 * i, 3 * sizeof *look);
    if (samples->emissive)
        memcpy(look + PSPLAT_LOOK_EMISSIVE, samples->emissive + 3 * i, 3 * sizeof *look);
    if (samples->finishes)
        memcpy(look + PSPLAT_LOOK_ROUGHNESS, samples->finishes + 3 * i + 1, 2 * sizeof *look);
    for (int k = 0; k < PSPLAT_LOOK_VALUES; ++k) {
        float value = k < PSPLAT_LOOK_ROUGHNESS ? psplat_srgb_of_linear(look[k]) : look[k];
        range[k] = fminf(range[k], value);
        range[PSPLAT_LOOK_VALUES + k] = fmaxf(range[PSPLAT_LOOK_VALUES + k], value);
    }
}

static void find_range(const look_grid *grid, size_t i, float *range) {
    int64_t base[3], cell[3];
    for (int k = 0; k < PSPLAT_LOOK_VALUES; ++k)
        range[k] = HUGE_VALF, range[PSPLAT_LOOK_VALUES + k] = -HUGE_VALF;
    extend_range(grid->samples, i, range);
    cell_of(grid, grid->samples->positions + 3 * i, base);
    for (int n = 0; n < 27; ++n) {
        cell[0] = base[0] + n % 3 - 1, cell[1] = base[1] + n / 3 % 3 - 1,
        cell[2] = base[2] + n / 9 - 1;
        for (uint32_t k = grid->heads[slot_of(grid, cell)]; k != PSPLAT_NONE; k = grid->nexts[k])
            if (is_neighbor(grid->samples, i, k, grid->cell)) extend_range(grid->samples, k, range);
    }
}

psplat_result psplat_color_ranges_find(const psplat_samples *samples, double reach,
                                       const uint32_t *indices, size_t count, float *ranges) {
    look_grid grid;
    int ok = build_grid(samples, reach, &grid);
    long end = ok ? (long)count : 0;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 256)
#endif
    for (long i = 0; i < end; ++i)
        find_range(&grid, indices[i], ranges + 2 * PSPLAT_LOOK_VALUES * (size_t)i);
    free_grid(&grid);
    return ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

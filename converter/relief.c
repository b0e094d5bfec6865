/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * relief.c - how much edges bend, how rough the surface is around them, and normals without noise.
 *
 * Noise of the vertices bends edges both ways, the curvature of a part mostly one way: what convex
 * and concave bends have in common is the estimate of noise. Bends over the crease angle are left
 * out of it, or creases would count as noise.
 *
 * Noise is removed by robust anisotropic diffusion (Black, Sapiro, Marimont, Heeger 1998) of the
 * normals from triangle to triangle, whose scale is that estimate: what bends by much more than the
 * noise around it is an outlier, across which nothing flows. A mesh without noise stays as it is.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Loops over fewer than this are not worth waiting for other threads. */
enum { LEAST_SHARED = 50000 };

/* Rounds of averaging, and of diffusion: each reaches one triangle further. Five of the latter
 * smooth over some twenty triangles; more would make facets of what is round. */
enum { AVERAGINGS = 4, DIFFUSIONS = 5 };

/* Bends of this many times the noise pass half of what a flat edge passes. */
static const double outlier = 1.3;
/* Bends over this (50 degrees) say nothing about noise. */
static const double noise_limit = 0.873;
/* Most that counts as noise, so that right angles survive, and least that is worth removing. */
static const double most_noise = 0.44;
static const double least_noise = 0.007;

/* Mean over the edges around a triangle. */
typedef struct energy {
    float convex, concave; /* squared bends */
    float count;           /* edges that these are of */
} energy;

/* Angle between the normals of the triangles at an edge, positive where the surface is convex. */
static double signed_bend(const psplat_surface *surface, const double *normals, uint32_t edge) {
    const double *a = normals + 3 * (size_t)(edge / 3);
    const double *b = normals + 3 * (size_t)surface->neighbors[edge];
    double along[3], axis[3], step[3];
    if (dot3(a, a) == 0 || dot3(b, b) == 0) return 0; /* a triangle without area */
    psplat_edge_vector(surface->mesh, edge, along);
    cross3(axis, a, b);
    sub3(step, b, a);
    double chord = length3(step); /* twice the sine of half the angle */
    double bend = chord < 0.2 ? chord * (1 + chord * chord / 24) : 2 * asin(min2(chord / 2, 1));
    return dot3(axis, along) < 0 ? -bend : bend;
}

static void measure_bends(const psplat_surface *surface, const double *normals, float *bends) {
    uint32_t count = (uint32_t)(3 * surface->mesh->triangle_count);
#pragma omp parallel for schedule(static) if (count >= LEAST_SHARED)
    for (uint32_t e = 0; e < count; ++e)
        bends[e] =
            surface->neighbors[e] == PSPLAT_NONE ? 0 : (float)signed_bend(surface, normals, e);
}

static energy energy_of(const psplat_surface *surface, const float *bends, uint32_t triangle,
                        double limit) {
    energy sum = {0, 0, 0};
    for (uint32_t e = 3 * triangle; e < 3 * triangle + 3; ++e) {
        float bend = bends[e];
        if (surface->neighbors[e] == PSPLAT_NONE || fabs((double)bend) >= limit) continue;
        if (bend > 0)
            sum.convex += bend * bend;
        else
            sum.concave += bend * bend;
        sum.count += 1;
    }
    return sum;
}

static energy average(const psplat_surface *surface, const energy *from, uint32_t triangle) {
    energy sum = from[triangle];
    float parts = 1;
    for (uint32_t e = 3 * triangle; e < 3 * triangle + 3; ++e) {
        if (surface->neighbors[e] == PSPLAT_NONE) continue;
        const energy *other = from + surface->neighbors[e];
        sum.convex += other->convex, sum.concave += other->concave, sum.count += other->count;
        parts += 1;
    }
    return (energy){sum.convex / parts, sum.concave / parts, sum.count / parts};
}

/* Mean energies around each triangle, in *energies; spare takes the steps between. */
static void measure_energies(const psplat_surface *surface, const float *bends, double limit,
                             energy **energies, energy **spare) {
    uint32_t count = (uint32_t)surface->mesh->triangle_count;
#pragma omp parallel for schedule(static) if (count >= LEAST_SHARED)
    for (uint32_t t = 0; t < count; ++t) (*energies)[t] = energy_of(surface, bends, t, limit);
    for (int round = 0; round < AVERAGINGS; ++round) {
        const energy *from = *energies;
        energy *to = *spare;
#pragma omp parallel for schedule(static) if (count >= LEAST_SHARED)
        for (uint32_t t = 0; t < count; ++t) to[t] = average(surface, from, t);
        *spare = *energies;
        *energies = to;
    }
}

static double root_mean(double sum, double count) {
    return count > 0 ? sqrt(sum / count) : 0;
}

/* Standard deviation of what was cut off at limit and then had this one; at most most_noise. The
 * form is ours: exact at both ends, within 5 % of a normal distribution's up to half of the limit,
 * where most_noise lies. */
static double untruncated(double deviation, double limit) {
    double x = deviation / limit, rest = 1 - 3 * x * x;
    double full = rest > 0 ? limit * x / sqrt(sqrt(rest)) : most_noise;
    return min2(full, most_noise);
}

static void diffuse_normal(const psplat_surface *surface, const double *from, const float *scale,
                           uint32_t triangle, double normal[3]) {
    const double *own = from + 3 * (size_t)triangle;
    for (int k = 0; k < 3; ++k) normal[k] = surface->face_areas[triangle] * own[k];
    for (uint32_t e = 3 * triangle; e < 3 * triangle + 3; ++e) {
        uint32_t next = surface->neighbors[e];
        if (next == PSPLAT_NONE) continue;
        double s = (double)(scale[triangle] > scale[next] ? scale[triangle] : scale[next]);
        if (s < least_noise) continue;
        double step[3];
        sub3(step, from + 3 * (size_t)next, own);
        double flow = exp(-dot3(step, step) / (2 * s * s));
        mad3(normal, flow * surface->face_areas[next], from + 3 * (size_t)next);
    }
    normalize3(normal);
}

static void diffuse(const psplat_surface *surface, psplat_relief *relief, const float *scale,
                    double *spare) {
    uint32_t count = (uint32_t)surface->mesh->triangle_count;
    memcpy(relief->normals, surface->face_normals, 3 * (size_t)count * sizeof *spare);
    for (int round = 0; round < DIFFUSIONS; ++round) {
#pragma omp parallel for schedule(static) if (count >= LEAST_SHARED)
        for (uint32_t t = 0; t < count; ++t)
            diffuse_normal(surface, relief->normals, scale, t, spare + 3 * (size_t)t);
        memcpy(relief->normals, spare, 3 * (size_t)count * sizeof *spare);
    }
}

static double noise_of(const energy *e) {
    return root_mean(2 * (double)(e->convex < e->concave ? e->convex : e->concave),
                     (double)e->count);
}

static void measure(const psplat_surface *surface, double limit, psplat_relief *relief,
                    energy *energies, energy *spare, double *spare_normals) {
    size_t count = surface->mesh->triangle_count;
    float *scale = relief->roughness; /* until that is known */
    measure_bends(surface, surface->face_normals, relief->bends);
    measure_energies(surface, relief->bends, noise_limit, &energies, &spare);
    for (size_t t = 0; t < count; ++t) {
        double noise = untruncated(noise_of(energies + t), noise_limit);
        scale[t] = (float)(outlier * noise);
    }
    measure_energies(surface, relief->bends, limit, &energies, &spare);
    for (size_t t = 0; t < count; ++t) relief->noise[t] = (float)noise_of(energies + t);
    diffuse(surface, relief, scale, spare_normals);
    measure_bends(surface, relief->normals, relief->calm_bends);
    measure_energies(surface, relief->calm_bends, limit, &energies, &spare);
    for (size_t t = 0; t < count; ++t)
        relief->roughness[t] = (float)root_mean(
            (double)energies[t].convex + (double)energies[t].concave, (double)energies[t].count);
}

psplat_result psplat_relief_measure(const psplat_surface *surface, double crease_angle,
                                    psplat_relief *relief) {
    size_t count = surface->mesh->triangle_count;
    energy *energies = malloc(2 * count * sizeof *energies);
    double *spare = malloc(3 * count * sizeof *spare);
    *relief = (psplat_relief){.bends = malloc(3 * count * sizeof *relief->bends),
                              .noise = malloc(count * sizeof *relief->noise),
                              .normals = malloc(3 * count * sizeof *relief->normals),
                              .calm_bends = malloc(3 * count * sizeof *relief->calm_bends),
                              .roughness = malloc(count * sizeof *relief->roughness)};
    int allocated = energies && spare && relief->bends && relief->noise && relief->normals &&
                    relief->calm_bends && relief->roughness;
    if (allocated) measure(surface, crease_angle, relief, energies, energies + count, spare);
    free(energies);
    free(spare);
    return allocated ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

void psplat_relief_free(psplat_relief *relief) {
    free(relief->bends);
    free(relief->noise);
    free(relief->normals);
    free(relief->calm_bends);
    free(relief->roughness);
    *relief = (psplat_relief){0};
}

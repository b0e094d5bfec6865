/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * curvature.c - signed dihedral angles of edges, noise and roughness, and normals without noise.
 *
 * Noise of the vertices makes edges convex and concave alike, while the curvature of a part makes
 * most edges one of them. The part that convex and concave angles have in common is therefore the
 * estimate of noise. Angles over a limit are left out of it, or creases would count as noise.
 *
 * Noise is removed from the normals by robust anisotropic diffusion (Black, Sapiro, Marimont,
 * Heeger 1998) from triangle to triangle, whose scale is that estimate. An edge with a much greater
 * angle than the noise around it is an outlier, across which nothing flows. A mesh without noise
 * stays as it is.
 */
#include "features/curvature.h"

#include "base/vector.h"
#include "features/surface.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rounds of averaging and of diffusion. Each round reaches one triangle further. Five rounds of
 * diffusion smooth over some twenty triangles; more would make facets of round shapes. */
enum { AVERAGING_ROUNDS = 4, DIFFUSION_ROUNDS = 5 };

/* The scale of the diffusion, in standard deviations of the noise. At an angle of this many
 * standard deviations the flow is exp(-1/2) of that across a flat edge. Chosen by hand. */
static const double diffusion_scale_noises = 1.3;
/* Angles over this (radians, 50 degrees) are left out of the scale of the diffusion. */
static const double max_noisy_angle = 0.873;
/* The greatest noise that is assumed, so that right angles survive, and the least scale of the
 * diffusion at which it is worth its time, both in radians. */
static const double max_noise = 0.44;
static const double min_diffusion_scale = 0.007;

/* Sums, or means of sums, over the edges around a triangle. */
typedef struct energy {
    float convex, concave; /* squared angles, of convex and of concave edges */
    float count;           /* the number of these edges */
} energy;

/* Returns the signed dihedral angle of an edge that has a neighbour. */
static double signed_dihedral(const psplat_surface *surface, const double *normals, uint32_t edge) {
    const double *a = normals + 3 * (size_t)(edge / 3);
    const double *b = normals + 3 * (size_t)surface->neighbors[edge];
    double along[3], axis[3], step[3];
    if (dot3(a, a) == 0 || dot3(b, b) == 0) return 0; /* a triangle without area */
    psplat_edge_vector(surface->mesh, edge, along);
    cross3(axis, a, b);
    sub3(step, b, a);
    double chord = length3(step); /* twice the sine of half the angle */
    double angle = chord < 0.2 ? chord * (1 + chord * chord / 24) : 2 * asin(min2(chord / 2, 1));
    return dot3(axis, along) < 0 ? -angle : angle;
}

static void measure_angles(const psplat_surface *surface, const double *normals, float *angles) {
    uint32_t count = (uint32_t)(3 * surface->mesh->triangle_count);
#pragma omp parallel for schedule(static) if (count >= PSPLAT_MIN_PARALLEL_COUNT)
    for (uint32_t e = 0; e < count; ++e)
        angles[e] =
            surface->neighbors[e] == PSPLAT_NONE ? 0 : (float)signed_dihedral(surface, normals, e);
}

static energy angle_energy(const psplat_surface *surface, const float *angles, uint32_t triangle,
                           double limit) {
    energy sum = {0, 0, 0};
    for (uint32_t e = 3 * triangle; e < 3 * triangle + 3; ++e) {
        float angle = angles[e];
        if (surface->neighbors[e] == PSPLAT_NONE || fabs((double)angle) >= limit) continue;
        if (angle > 0)
            sum.convex += angle * angle;
        else
            sum.concave += angle * angle;
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

/* Measures the energy of each triangle and averages it over the triangles around. The result is in
 * *energies; *spare is scratch memory, and both may be swapped. */
static void measure_energies(const psplat_surface *surface, const float *angles, double limit,
                             energy **energies, energy **spare) {
    uint32_t count = (uint32_t)surface->mesh->triangle_count;
#pragma omp parallel for schedule(static) if (count >= PSPLAT_MIN_PARALLEL_COUNT)
    for (uint32_t t = 0; t < count; ++t) (*energies)[t] = angle_energy(surface, angles, t, limit);
    for (int round = 0; round < AVERAGING_ROUNDS; ++round) {
        const energy *from = *energies;
        energy *to = *spare;
#pragma omp parallel for schedule(static) if (count >= PSPLAT_MIN_PARALLEL_COUNT)
        for (uint32_t t = 0; t < count; ++t) to[t] = average(surface, from, t);
        *spare = *energies;
        *energies = to;
    }
}

static double root_mean(double sum, double count) {
    return count > 0 ? sqrt(sum / count) : 0;
}

/* Returns the standard deviation of a distribution that has this deviation after values over limit
 * were left out, but at most max_noise. The formula is our own: it is exact at both ends, and
 * within 5 % of a normal distribution up to half of the limit, where max_noise lies. */
static double untruncated_deviation(double deviation, double limit) {
    double x = deviation / limit, rest = 1 - 3 * x * x;
    double full = rest > 0 ? limit * x / sqrt(sqrt(rest)) : max_noise;
    return min2(full, max_noise);
}

/* Computes the normal of a triangle after one round of diffusion. scale is in radians. */
static void diffuse_normal(const psplat_surface *surface, const double *from, const float *scale,
                           uint32_t triangle, double normal[3]) {
    const double *own = from + 3 * (size_t)triangle;
    int flows = 0;
    for (int k = 0; k < 3; ++k) normal[k] = surface->face_areas[triangle] * own[k];
    for (uint32_t e = 3 * triangle; e < 3 * triangle + 3; ++e) {
        uint32_t next = surface->neighbors[e];
        if (next == PSPLAT_NONE) continue;
        double s = (double)(scale[triangle] > scale[next] ? scale[triangle] : scale[next]);
        if (s < min_diffusion_scale) continue;
        double step[3];
        sub3(step, from + 3 * (size_t)next, own);
        double flow = exp(-dot3(step, step) / (2 * s * s));
        mad3(normal, flow * surface->face_areas[next], from + 3 * (size_t)next);
        flows = 1;
    }
    if (flows)
        normalize3(normal);
    else
        memcpy(normal, own, 3 * sizeof *normal);
}

/* Fills in smooth_normals; spare has room for as many. */
static void diffuse(const psplat_surface *surface, psplat_curvature *curvature, const float *scale,
                    double *spare) {
    uint32_t count = (uint32_t)surface->mesh->triangle_count;
    const double *from = surface->face_normals;
    double *to = curvature->smooth_normals, *other = spare;
    _Static_assert(DIFFUSION_ROUNDS % 2 == 1, "the last round writes smooth_normals");
    for (int round = 0; round < DIFFUSION_ROUNDS; ++round) {
#pragma omp parallel for schedule(static) if (count >= PSPLAT_MIN_PARALLEL_COUNT)
        for (uint32_t t = 0; t < count; ++t)
            diffuse_normal(surface, from, scale, t, to + 3 * (size_t)t);
        double *written = to;
        to = other, other = written, from = written;
    }
}

/* Returns the root mean square of the angles that noise makes: convex and concave ones have the
 * lesser of both energies each. */
static double noise_of(const energy *e) {
    return root_mean(2 * (double)(e->convex < e->concave ? e->convex : e->concave),
                     (double)e->count);
}

/* The memory of energies, which nothing needs while normals are diffused. */
typedef union scratch {
    energy *energies; /* triangle_count x 2 */
    double *normals;  /* triangle_count x 3 */
    void *memory;
} scratch;

static void measure(const psplat_surface *surface, double limit, psplat_curvature *curvature,
                    scratch memory) {
    size_t count = surface->mesh->triangle_count;
    energy *energies = memory.energies, *spare = memory.energies + count;
    float *scale = curvature->roughness; /* this array is free until roughness is measured */
    measure_angles(surface, surface->face_normals, curvature->angles);
    measure_energies(surface, curvature->angles, max_noisy_angle, &energies, &spare);
    for (size_t t = 0; t < count; ++t) {
        double noise = untruncated_deviation(noise_of(energies + t), max_noisy_angle);
        scale[t] = (float)(diffusion_scale_noises * noise);
    }
    measure_energies(surface, curvature->angles, limit, &energies, &spare);
    for (size_t t = 0; t < count; ++t) curvature->noise[t] = (float)noise_of(energies + t);
    diffuse(surface, curvature, scale, memory.normals);
    measure_angles(surface, curvature->smooth_normals, curvature->smooth_angles);
    measure_energies(surface, curvature->smooth_angles, limit, &energies, &spare);
    for (size_t t = 0; t < count; ++t)
        curvature->roughness[t] = (float)root_mean(
            (double)energies[t].convex + (double)energies[t].concave, (double)energies[t].count);
}

psplat_result psplat_curvature_measure(const psplat_surface *surface, double crease_angle,
                                       psplat_curvature *curvature) {
    size_t count = surface->mesh->triangle_count;
    const size_t sizes[2] = {2 * sizeof(energy), 3 * sizeof(double)};
    scratch memory = {.memory = malloc(count * (sizes[0] > sizes[1] ? sizes[0] : sizes[1]))};
    *curvature =
        (psplat_curvature){.angles = malloc(3 * count * sizeof *curvature->angles),
                           .noise = malloc(count * sizeof *curvature->noise),
                           .smooth_normals = malloc(3 * count * sizeof *curvature->smooth_normals),
                           .smooth_angles = malloc(3 * count * sizeof *curvature->smooth_angles),
                           .roughness = malloc(count * sizeof *curvature->roughness)};
    int allocated = memory.memory && curvature->angles && curvature->noise &&
                    curvature->smooth_normals && curvature->smooth_angles && curvature->roughness;
    if (allocated) measure(surface, crease_angle, curvature, memory);
    free(memory.memory);
    return allocated ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

void psplat_curvature_free(psplat_curvature *curvature) {
    free(curvature->angles);
    free(curvature->noise);
    free(curvature->smooth_normals);
    free(curvature->smooth_angles);
    free(curvature->roughness);
    *curvature = (psplat_curvature){0};
}

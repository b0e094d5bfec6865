/* SPDX-License-Identifier: MIT
 *
 * stage_fixture.h - meshes for tests of single stages of the conversion: bent grids, and models
 * from files, in any orientation and place. Include it after cmocka.h.
 */
#ifndef PHONGSPLAT_TESTS_STAGE_FIXTURE_H
#define PHONGSPLAT_TESTS_STAGE_FIXTURE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if defined(_OPENMP)
#include <omp.h>
#endif

#include "near.h"
#include "features/surface_build.h"
#include "base/random.h"
#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/surface.h"
#include "fit/candidate.h"
#include "fit/fit_context.h"
#include "features/samples.h"
#include "import/read_mesh.h"
#include "measure/measured_splats.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"
#include "select/local_search.h"
#include "select/selection.h"
#include "splats/splats.h"

static const double fixture_pi = 3.14159265358979323846;
static const double fixture_crease_angle = 30 * 3.14159265358979323846 / 180;

typedef struct fixture {
    psplat_mesh mesh;
    psplat_surface surface;
    psplat_samples samples;    /* empty until fixture_sample */
    psplat_distance *distance; /* NULL until fixture_sample */
} fixture;

static inline void fixture_free(fixture *f) {
    psplat_distance_destroy(f->distance);
    psplat_samples_free(&f->samples);
    psplat_surface_free(&f->surface);
    psplat_mesh_free(&f->mesh);
}

/* Limits the number of threads that stages use; 0 stands for as many as there are cores. */
static inline void fixture_threads(int count) {
#if defined(_OPENMP)
    omp_set_num_threads(count ? count : omp_get_num_procs());
#else
    (void)count;
#endif
}

static inline void fixture_build(fixture *f) {
    assert_int_equal(psplat_surface_build(&f->mesh, fixture_crease_angle, &f->surface, NULL),
                     PSPLAT_OK);
}

static inline void fixture_model(fixture *f, const char *name) {
    psplat_error error;
    char path[512];
    *f = (fixture){0};
    snprintf(path, sizeof path, PSPLAT_SOURCE_DIR "/samples/models/%s", name);
    if (psplat_mesh_read(path, &f->mesh, &error)) fail_msg("%s", error.text);
    fixture_build(f);
}

/* Makes columns x rows squares of two triangles each; place gives the point at s and t, both in 0
 * ... 1. The surface is not built yet. */
static inline void fixture_grid(fixture *f, uint32_t columns, uint32_t rows,
                                void (*place)(double s, double t, double p[3])) {
    *f = (fixture){0};
    f->mesh.vertex_count = (size_t)(columns + 1) * (rows + 1);
    f->mesh.triangle_count = (size_t)2 * columns * rows;
    f->mesh.positions = malloc(f->mesh.vertex_count * 3 * sizeof(double));
    f->mesh.triangles = malloc(f->mesh.triangle_count * 3 * sizeof(uint32_t));
    assert_non_null(f->mesh.positions);
    assert_non_null(f->mesh.triangles);
    double *p = f->mesh.positions;
    for (uint32_t y = 0; y <= rows; ++y)
        for (uint32_t x = 0; x <= columns; ++x, p += 3)
            place((double)x / (double)columns, (double)y / (double)rows, p);
    uint32_t *t = f->mesh.triangles;
    for (uint32_t y = 0; y < rows; ++y)
        for (uint32_t x = 0; x < columns; ++x, t += 6) {
            uint32_t a = y * (columns + 1) + x, c = a + columns + 1;
            uint32_t two[6] = {a, a + 1, c + 1, a, c + 1, c};
            memcpy(t, two, sizeof two);
        }
}

/* A point, and whether a visited splat covers it. */
typedef struct fixture_probe {
    const psplat_measured_splats *measured;
    const double *point;
    double normal[3];
    int covered;
} fixture_probe;

static inline int fixture_visit(void *user, uint32_t splat) {
    fixture_probe *p = user;
    double uvh[3];
    psplat_region_local(&p->measured->regions[splat], p->point, uvh);
    return p->covered = psplat_measured_splats_cover(p->measured, splat, p->normal, uvh);
}

/* Marks the samples that no splat covers with 1, and returns their number. */
static inline size_t fixture_open(const psplat_samples *samples, const psplat_splats *splats,
                                  double tolerance, uint8_t *open) {
    psplat_measured_splats measured;
    size_t count = 0;
    assert_int_equal(psplat_measured_splats_create(splats, tolerance, tolerance, &measured),
                     PSPLAT_OK);
    for (size_t i = 0; i < samples->count; ++i) {
        fixture_probe p = {&measured, samples->positions + 3 * i, {0, 0, 0}, 0};
        for (size_t k = 0; k < 3; ++k) p.normal[k] = (double)samples->normals[3 * i + k];
        psplat_region_tree_visit(measured.region_tree, p.point, fixture_visit, &p);
        open[i] = !p.covered;
        count += open[i];
    }
    psplat_measured_splats_free(&measured);
    return count;
}

/* Draws samples and builds the distance search; spacing is in diagonals of the mesh. */
static inline void fixture_sample(fixture *f, double spacing) {
    f->distance = psplat_distance_create_connected(&f->mesh, f->surface.neighbors);
    assert_non_null(f->distance);
    assert_int_equal(
        psplat_samples_draw(&f->surface, spacing * f->surface.diagonal, 1, &f->samples, NULL),
        PSPLAT_OK);
}

/* Asserts that points all over a region are within the tolerance of a mesh. */
static inline void fixture_assert_near(const psplat_region *region, const psplat_distance *distance,
                                       double tolerance) {
    double points[PSPLAT_REGION_POINTS][3];
    size_t count = psplat_region_points(region, points);
    int near = 0;
    assert_int_equal(
        psplat_distance_within(distance, points[0], count, tolerance * (1 + 1e-9), &near),
        PSPLAT_OK);
    assert_int_equal(near, 1);
}

/* Returns the context in which candidates on a fixture are fitted. */
static inline psplat_fit_context fixture_context(const fixture *f, const psplat_limits *limits,
                                                 psplat_scratch *scratch) {
    return (psplat_fit_context){&f->surface, &f->samples, limits, scratch};
}

/* Improves a selection by local search; with `strict` it changes only what saves candidates.
 * Samples are neighbours of those before and after them. */
static inline psplat_result fixture_exchange(psplat_selection *selection, size_t count,
                                             size_t focus, size_t moves, uint64_t seed,
                                             int strict) {
    psplat_samples samples = {.count = count};
    samples.positions = calloc(3 * count + 1, sizeof(double));
    assert_non_null(samples.positions);
    for (size_t i = 0; i < count; ++i) samples.positions[3 * i] = (double)i;
    psplat_local_search_desc what = {&samples, moves, focus, 0, seed, strict, NULL};
    psplat_result result = psplat_local_search(selection, &what);
    free(samples.positions);
    return result;
}

static inline psplat_result fixture_improve(psplat_selection *selection, size_t count, size_t focus,
                                            size_t moves, uint64_t seed) {
    return fixture_exchange(selection, count, focus, moves, seed, 0);
}

/* Makes a random right-handed orthonormal frame. */
static inline void random_axes(uint64_t *random, double u[3], double v[3], double n[3]) {
    double q[4], length = 0;
    for (int k = 0; k < 4; ++k) {
        q[k] = 2 * psplat_random_unit(random) - 1;
        length += q[k] * q[k];
    }
    for (int k = 0; k < 4; ++k) q[k] /= sqrt(length);
    double x = q[0], y = q[1], z = q[2], w = q[3];
    u[0] = 1 - 2 * (y * y + z * z), u[1] = 2 * (x * y + z * w), u[2] = 2 * (x * z - y * w);
    v[0] = 2 * (x * y - z * w), v[1] = 1 - 2 * (x * x + z * z), v[2] = 2 * (y * z + x * w);
    cross3(n, u, v);
}

/* Stores the point of a region at (u, v), in radii, and at a height above its plane. */
static inline void region_point(const psplat_region *region, double u, double v, double height,
                                double p[3]) {
    memcpy(p, region->center, 3 * sizeof(double));
    mad3(p, u * region->radius[0], region->u);
    mad3(p, v * region->radius[1], region->v);
    mad3(p, height, region->n);
}

#endif

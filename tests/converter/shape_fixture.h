/* SPDX-License-Identifier: MIT
 *
 * shape_fixture.h - closed shapes with known creases, noise, and counts of the creases and patches
 * found. Include it after stage_fixture.h.
 */
#ifndef PHONGSPLAT_TESTS_SHAPE_FIXTURE_H
#define PHONGSPLAT_TESTS_SHAPE_FIXTURE_H

#include "features/surface_build.h"
#include "base/random.h"
#include "base/vector.h"
#include "features/surface.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"
#include "mesh/weld.h"
#include "stage_fixture.h"

/* Adds a triangle with three vertices of its own; welding joins the vertices later. */
static inline void shape_triangle(psplat_mesh *mesh, const double a[3], const double b[3],
                                  const double c[3]) {
    size_t v = mesh->vertex_count, t = mesh->triangle_count++;
    mesh->vertex_count += 3;
    if ((t & (t + 1)) == 0) { /* The arrays are full at 1, 3, 7, 15, ... triangles. */
        size_t room = 2 * t + 1;
        mesh->positions = realloc(mesh->positions, 9 * room * sizeof(double));
        mesh->triangles = realloc(mesh->triangles, 3 * room * sizeof(uint32_t));
    }
    assert_non_null(mesh->positions);
    assert_non_null(mesh->triangles);
    const double *corners[3] = {a, b, c};
    for (size_t k = 0; k < 3; ++k) {
        memcpy(mesh->positions + 3 * (v + k), corners[k], 3 * sizeof(double));
        mesh->triangles[3 * t + k] = (uint32_t)(v + k);
    }
}

/* Adds a quadrangle, which is split along one diagonal or, with `other`, along the other one. */
static inline void shape_quad(psplat_mesh *mesh, double q[4][3], int other) {
    if (other) {
        shape_triangle(mesh, q[0], q[1], q[3]);
        shape_triangle(mesh, q[1], q[2], q[3]);
    } else {
        shape_triangle(mesh, q[0], q[1], q[2]);
        shape_triangle(mesh, q[0], q[2], q[3]);
    }
}

static inline void shape_weld(psplat_mesh *mesh) {
    assert_int_equal(psplat_mesh_weld(mesh, NULL), PSPLAT_OK);
}

/* Returns a cube from -1 to 1 with n x n squares on each face. */
static inline psplat_mesh shape_cube(int n) {
    static const int corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    psplat_mesh mesh = {0};
    for (int face = 0; face < 6; ++face)
        for (int i = 0; i < n * n; ++i) {
            double q[4][3];
            int axis = face / 2, front = face % 2;
            for (int k = 0; k < 4; ++k) {
                double u = 2.0 * (i % n + corners[k][0]) / n - 1;
                double v = 2.0 * (i / n + corners[k][1]) / n - 1;
                q[k][axis] = front ? 1 : -1;
                q[k][(axis + 1) % 3] = front ? u : v;
                q[k][(axis + 2) % 3] = front ? v : u;
            }
            shape_quad(&mesh, q, (i + i / n) % 2);
        }
    shape_weld(&mesh);
    return mesh;
}

/* Returns a profile of count points (radius, height), turned about z in `sides` steps. A radius of
 * 0 closes the shape; the profile runs upwards on the outside. */
static inline psplat_mesh shape_turned(const double (*profile)[2], int count, int sides) {
    psplat_mesh mesh = {0};
    for (int j = 0; j + 1 < count; ++j)
        for (int i = 0; i < sides; ++i) {
            double q[4][3];
            for (int k = 0; k < 4; ++k) {
                const double *p = profile[j + (k >= 2)];
                double turn = 2 * fixture_pi * ((i + (k == 1 || k == 2)) % sides) / sides;
                q[k][0] = p[0] > 0 ? p[0] * cos(turn) : 0;
                q[k][1] = p[0] > 0 ? p[0] * sin(turn) : 0;
                q[k][2] = p[1];
            }
            shape_quad(&mesh, q, (i + j) % 2);
        }
    shape_weld(&mesh);
    return mesh;
}

/* Adds normally distributed noise to all coordinates (Box and Muller 1958). */
static inline void shape_noise(psplat_mesh *mesh, double deviation) {
    uint64_t random = 7;
    for (size_t i = 0; i < 3 * mesh->vertex_count; ++i) {
        double u = 1 - psplat_random_unit(&random), v = psplat_random_unit(&random);
        mesh->positions[i] += deviation * sqrt(-2 * log(u)) * cos(2 * fixture_pi * v);
    }
}

static inline double shape_mean_edge(const psplat_mesh *mesh) {
    double sum = 0, along[3];
    for (uint32_t e = 0; e < 3 * mesh->triangle_count; ++e) {
        psplat_edge_vector(mesh, e, along);
        sum += length3(along);
    }
    return sum / (3 * (double)mesh->triangle_count);
}

/* Gives all corners of each triangle the same normal, as a flat-shaded export does. */
static inline void shape_flat_normals(psplat_mesh *mesh) {
    mesh->corner_normals = malloc(mesh->triangle_count * 9 * sizeof(float));
    assert_non_null(mesh->corner_normals);
    for (size_t c = 0; c < 3 * mesh->triangle_count; ++c) {
        const double *p[3];
        double ab[3], ac[3], n[3];
        for (size_t k = 0; k < 3; ++k)
            p[k] = mesh->positions + 3 * (size_t)mesh->triangles[c - c % 3 + k];
        sub3(ab, p[1], p[0]);
        sub3(ac, p[2], p[0]);
        cross3(n, ab, ac);
        normalize3(n);
        for (size_t k = 0; k < 3; ++k) mesh->corner_normals[3 * c + k] = (float)n[k];
    }
}

static inline psplat_surface shape_surface(const psplat_mesh *mesh, double degrees) {
    psplat_surface surface;
    assert_int_equal(psplat_surface_build(mesh, degrees * fixture_pi / 180, &surface, NULL),
                     PSPLAT_OK);
    return surface;
}

#endif

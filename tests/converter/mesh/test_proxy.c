/* SPDX-License-Identifier: MIT
 *
 * test_proxy.c - tests that a proxy of a mesh is where its deviation says, against distances to
 * all triangles at many points, and that nothing is proven beside holes and folds.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/random.h"
#include "base/vector.h"
#include "mesh/distance.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"
#include "mesh/proxy.h"
#include "near.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- meshes ---------------------------------------------------------------------------------- */

/* Stores the point of a surface at u, v from 0 to 1. */
typedef void place_point(double u, double v, uint64_t *seed, double p[3]);

/* Returns n x n squares of two triangles each. A closed one ends where it begins, both ways. */
static psplat_mesh make_grid(uint32_t n, place_point *place, int closed, double scale) {
    uint32_t row = closed ? n : n + 1;
    psplat_mesh mesh = {.vertex_count = (size_t)row * row, .triangle_count = 2 * (size_t)n * n};
    uint64_t seed = 7;
    mesh.positions = malloc(3 * mesh.vertex_count * sizeof(double));
    mesh.triangles = malloc(3 * mesh.triangle_count * sizeof(uint32_t));
    assert_non_null(mesh.positions);
    assert_non_null(mesh.triangles);
    for (size_t v = 0; v < mesh.vertex_count; ++v) {
        double *p = mesh.positions + 3 * v;
        place((double)(v % row) / n, (double)(v / row) / n, &seed, p);
        for (int k = 0; k < 3; ++k) p[k] *= scale;
    }
    for (uint32_t i = 0; i < n * n; ++i) {
        uint32_t x = i % n, y = i / n, right = (x + 1) % row, above = (y + 1) % row;
        uint32_t a = y * row + x, b = y * row + right, c = above * row + right, d = above * row + x;
        const uint32_t square[6] = {a, b, c, a, c, d};
        memcpy(mesh.triangles + 6 * (size_t)i, square, sizeof square);
    }
    return mesh;
}

/* Appends a copy of the mesh that is moved along z. */
static void add_copy(psplat_mesh *mesh, double z) {
    size_t vertices = mesh->vertex_count, triangles = mesh->triangle_count;
    mesh->positions = realloc(mesh->positions, 6 * vertices * sizeof(double));
    mesh->triangles = realloc(mesh->triangles, 6 * triangles * sizeof(uint32_t));
    assert_non_null(mesh->positions);
    assert_non_null(mesh->triangles);
    for (size_t i = 0; i < 3 * vertices; ++i)
        mesh->positions[3 * vertices + i] = mesh->positions[i] + (i % 3 == 2 ? z : 0);
    for (size_t i = 0; i < 3 * triangles; ++i)
        mesh->triangles[3 * triangles + i] = mesh->triangles[i] + (uint32_t)vertices;
    mesh->vertex_count *= 2;
    mesh->triangle_count *= 2;
}

/* A hill with a straight border, seen from above, and a little noise. */
static void place_hill(double u, double v, uint64_t *seed, double p[3]) {
    p[0] = u, p[1] = v;
    p[2] = 0.1 * sin(3 * u + 1) * cos(2 * v) + 1e-5 * psplat_random_unit(seed);
}

/* A round patch whose border bends within the patch. */
static void place_disc(double u, double v, uint64_t *seed, double p[3]) {
    double x = 2 * u - 1, y = 2 * v - 1;
    (void)seed;
    p[0] = x * sqrt(1 - y * y / 2), p[1] = y * sqrt(1 - x * x / 2);
    p[2] = 0.2 * (p[0] * p[0] + p[1] * p[1]);
}

static void place_torus(double u, double v, uint64_t *seed, double p[3]) {
    const double turn = 6.283185307179586;
    double radius = 1 + 0.4 * cos(turn * v);
    (void)seed;
    p[0] = radius * cos(turn * u), p[1] = radius * sin(turn * u), p[2] = 0.4 * sin(turn * v);
}

/* Noise that no triangle can stand for. */
static void place_noise(double u, double v, uint64_t *seed, double p[3]) {
    p[0] = u, p[1] = v, p[2] = 0.1 * psplat_random_unit(seed);
}

static void free_mesh(psplat_mesh *mesh) {
    psplat_mesh_free(mesh);
}

/* Returns the triangles across edges, or PSPLAT_NONE; the caller frees them. */
static uint32_t *neighbors_of(const psplat_mesh *mesh) {
    size_t borders;
    uint32_t *neighbors = malloc(3 * mesh->triangle_count * sizeof *neighbors);
    assert_non_null(neighbors);
    assert_int_equal(psplat_edge_pairs(mesh, neighbors, &borders), PSPLAT_OK);
    for (size_t e = 0; e < 3 * mesh->triangle_count; ++e)
        if (neighbors[e] != PSPLAT_NONE) neighbors[e] /= 3;
    return neighbors;
}

/* ---- proxies of whole meshes ----------------------------------------------------------------- */

/* Returns the greatest distance of points of one mesh to another, at a lattice of points of each
 * triangle. */
static double greatest_distance(const psplat_mesh *from, const psplat_mesh *to) {
    enum { STEPS = 6 };
    psplat_distance *tree = psplat_distance_create(to);
    double greatest = 0, distance;
    assert_non_null(tree);
    for (uint32_t t = 0; t < from->triangle_count; ++t)
        for (int i = 0; i <= STEPS; ++i)
            for (int k = 0; i + k <= STEPS; ++k) {
                double p[3] = {0, 0, 0};
                mad3(p, (double)i / STEPS, psplat_mesh_corner(from, t, 0));
                mad3(p, (double)k / STEPS, psplat_mesh_corner(from, t, 1));
                mad3(p, (double)(STEPS - i - k) / STEPS, psplat_mesh_corner(from, t, 2));
                assert_int_equal(psplat_distance_query(tree, p, 1, &distance), PSPLAT_OK);
                greatest = fmax(greatest, distance);
            }
    psplat_distance_destroy(tree);
    return greatest;
}

/* Asserts that the mesh has a proxy of at most a part of its triangles, and that the proxy lies
 * within its deviation of the mesh. size is the mesh's, for rounding. */
static void check_proxy(psplat_mesh *mesh, double most, double part, double size) {
    psplat_proxy proxy;
    assert_int_equal(psplat_proxy_build(mesh, most, 3, &proxy), PSPLAT_OK);
    assert_true(proxy.mesh.triangle_count > 0);
    assert_true((double)proxy.mesh.triangle_count <= part * (double)mesh->triangle_count);
    assert_true(proxy.deviation > 0 && proxy.deviation <= most);
    double found = greatest_distance(&proxy.mesh, mesh);
    assert_true(found <= proxy.deviation + 1e-12 * size);
    assert_true(found > 0.3 * proxy.deviation); /* the bound is no wild guess */
    /* Nothing of the mesh is left out that fits would miss: a gap between two proven triangles is
     * about as wide as they deviate. */
    assert_true(greatest_distance(mesh, &proxy.mesh) < 3 * most);
    size_t count = proxy.mesh.triangle_count;
    psplat_proxy_free(&proxy);
    double gain = (double)mesh->triangle_count / (double)count;
    assert_int_equal(psplat_proxy_build(mesh, most, 1.01 * gain, &proxy), PSPLAT_OK);
    assert_int_equal(proxy.mesh.triangle_count, 0); /* one that gains less is none */
    free_mesh(mesh);
}

static void test_within_deviation(void **state) {
    (void)state;
    psplat_mesh hill = make_grid(60, place_hill, 0, 1), disc = make_grid(60, place_disc, 0, 1),
                torus = make_grid(70, place_torus, 1, 1);
    check_proxy(&hill, 0.003, 0.15, 1);
    check_proxy(&disc, 0.004, 0.33, 2);
    check_proxy(&torus, 0.01, 0.33, 3);
}

/* Scales at which squares and cubes of lengths leave single precision. */
static void test_scales(void **state) {
    (void)state;
    psplat_mesh tiny = make_grid(60, place_hill, 0, 1e-20),
                huge = make_grid(60, place_hill, 0, 1e20);
    check_proxy(&tiny, 0.003e-20, 0.15, 1e-20);
    check_proxy(&huge, 0.003e20, 0.15, 1e20);
}

/* Two sheets that are nearer to each other than the deviation may be are two sheets. */
static void test_sheets(void **state) {
    (void)state;
    psplat_mesh sheets = make_grid(60, place_hill, 0, 1);
    add_copy(&sheets, 0.001);
    check_proxy(&sheets, 0.003, 0.15, 1);
}

static void test_falls_back(void **state) {
    (void)state;
    psplat_proxy proxy;
    psplat_mesh noise = make_grid(40, place_noise, 0, 1), points = make_grid(40, place_hill, 0, 1);
    assert_int_equal(psplat_proxy_build(&noise, 0.003, 3, &proxy), PSPLAT_OK);
    assert_int_equal(proxy.mesh.triangle_count, 0);
    psplat_proxy_free(&proxy);
    points.point_count = 1; /* the points themselves count as the surface */
    assert_int_equal(psplat_proxy_build(&points, 0.003, 3, &proxy), PSPLAT_OK);
    assert_int_equal(proxy.mesh.triangle_count, 0);
    points.point_count = 0;
    free_mesh(&noise);
    free_mesh(&points);
}

/* ---- single triangles ------------------------------------------------------------------------ */

/* Returns the bound for the triangle of the vertices 0, 1 and 2. */
static double bound_of(const double *positions, size_t vertices, const uint32_t *triangles,
                       size_t count, double most) {
    static const uint32_t corners[3] = {0, 1, 2};
    double deviation;
    uint32_t visited[64] = {0}, start = 0;
    psplat_mesh mesh = {.vertex_count = vertices, .triangle_count = count};
    mesh.positions = malloc(3 * vertices * sizeof(double));
    mesh.triangles = malloc(3 * count * sizeof(uint32_t));
    assert_non_null(mesh.positions);
    assert_non_null(mesh.triangles);
    memcpy(mesh.positions, positions, 3 * vertices * sizeof(double));
    memcpy(mesh.triangles, triangles, 3 * count * sizeof(uint32_t));
    while (mesh.triangles[start]) ++start;
    uint32_t *neighbors = neighbors_of(&mesh);
    psplat_proxy_search search = {
        .source = &mesh, .neighbors = neighbors, .most = most, .visited = visited, .stamp = 1};
    assert_int_equal(psplat_proxy_bound(&search, corners, start / 3, &deviation), PSPLAT_OK);
    free(search.stack);
    free(neighbors);
    free_mesh(&mesh);
    return deviation;
}

/* A square pyramid of height h over the triangle 0 1 2 and another one, at whose common side its
 * tip is. */
static void test_pyramid(void **state) {
    (void)state;
    static const uint32_t triangles[] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
    const double h = 0.01;
    double p[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, h};
    assert_near(bound_of(p, 5, triangles, 4, 0.02), h, 1e-15); /* coordinates, rounded */
    assert_true(isinf(bound_of(p, 5, triangles, 4, 0.9 * h)));
    p[14] = -h;
    assert_near(bound_of(p, 5, triangles, 4, 0.02), h, 1e-15);
    /* Beyond the triangle only what is clipped away is higher. */
    p[12] = 0.25, p[13] = 0.75; /* the edge from 1 to the tip leaves at two thirds */
    assert_near(bound_of(p, 5, triangles, 4, 0.02), 2 * h / 3, 1e-15);
}

/* Without one of the triangles below it, a triangle is not near the mesh. */
static void test_hole(void **state) {
    (void)state;
    static const uint32_t triangles[] = {0, 1, 4, 2, 3, 4, 3, 0, 4};
    const double p[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 0.01};
    assert_true(isinf(bound_of(p, 5, triangles, 3, 0.02)));
}

/* The mesh goes once around the triangle, but not below it. */
static void test_ring(void **state) {
    (void)state;
    static const uint32_t triangles[] = {0, 3, 1, 1, 3, 4, 1, 4, 2, 2, 4, 5, 2, 5, 0, 0, 5, 3};
    const double p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, -1, -1, 0, 3, -1, 0, -1, 3, 0};
    assert_true(isinf(bound_of(p, 6, triangles, 6, 0.02)));
}

/* A fold covers each point twice beside the fold's own border, where it ends. */
static void test_fold(void **state) {
    (void)state;
    static const uint32_t triangles[] = {0, 3, 4, 0, 4, 5};
    const double p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 3, 0.01, 3, -1, 0.01, -1, 3, 0.02};
    assert_true(isinf(bound_of(p, 6, triangles, 2, 0.05)));
}

/* The border of the mesh runs beside the side from 0 to 1, by `away` outside or inside of it. */
static double border_bound(double away, double height, double most) {
    static const uint32_t triangles[] = {0, 3, 2, 3, 1, 2};
    const double p[] = {0, 0, 0, 1, 0, 0, 0.5, 1, 0, 0.5, away, height};
    return bound_of(p, 4, triangles, 2, most);
}

static void test_border(void **state) {
    (void)state;
    const double away = 0.01, height = 0.005;
    /* A point of the strip may have the border across at twice its width. */
    assert_near(border_bound(away, height, 0.03), sqrt(4 * away * away + height * height), 1e-15);
    assert_true(isinf(border_bound(away, height, 0.02)));
    /* Where the mesh reaches over the side, height alone counts, clipped to the triangle. */
    double over = border_bound(-away, height, 0.03);
    assert_true(over <= height && over > 0.9 * height);
    /* A border far outside is no matter. */
    assert_true(border_bound(-0.5, 0, 0.03) <= 1e-15);
    /* A border far inside leaves the triangle uncovered. */
    assert_true(isinf(border_bound(0.2, 0, 0.03)));
}

/* At an obtuse corner the farthest point of the strip has no border across. */
static void test_obtuse_border(void **state) {
    (void)state;
    static const uint32_t triangles[] = {0, 3, 2, 3, 1, 2};
    const double away = 0.01;
    const double p[] = {0, 0, 0, 1, 0, 0, -2, 0.5, 0, 0.5, away, 0};
    double slope = sqrt(2 * 2 + 0.5 * 0.5) / 0.5; /* one over the sine at corner 0 */
    assert_near(bound_of(p, 4, triangles, 2, 0.06), slope * away, 1e-14);
}

/* The border beside a side has a gap that is as wide as a tenth of the side. */
static void test_broken_border(void **state) {
    (void)state;
    static const uint32_t triangles[] = {0, 3, 2, 4, 1, 2};
    const double p[] = {0, 0, 0, 1, 0, 0, 0.5, 1, 0, 0.45, 0.005, 0, 0.55, 0.005, 0};
    assert_true(isinf(bound_of(p, 5, triangles, 2, 0.03)));
}

static void test_flat_triangle(void **state) {
    (void)state;
    static const uint32_t triangles[] = {0, 3, 2, 3, 1, 2};
    const double p[] = {0, 0, 0, 1, 0, 0, 0.5, 0, 0, 0.5, 0.1, 0};
    assert_true(isinf(bound_of(p, 4, triangles, 2, 0.3)));
}

int test_proxy_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_within_deviation),
        cmocka_unit_test(test_scales),
        cmocka_unit_test(test_sheets),
        cmocka_unit_test(test_falls_back),
        cmocka_unit_test(test_pyramid),
        cmocka_unit_test(test_hole),
        cmocka_unit_test(test_ring),
        cmocka_unit_test(test_fold),
        cmocka_unit_test(test_border),
        cmocka_unit_test(test_obtuse_border),
        cmocka_unit_test(test_broken_border),
        cmocka_unit_test(test_flat_triangle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

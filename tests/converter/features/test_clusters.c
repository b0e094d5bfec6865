/* SPDX-License-Identifier: MIT
 *
 * test_clusters.c - tests of the partition of surfaces into clusters, against brute force.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "base/vector.h"
#include "features/clusters.h"
#include "features/surface_build.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"

#define MODELS PSPLAT_SOURCE_DIR "/samples/models/"

/* Returns whether b is listed as a neighbour of a. */
static int is_neighbor(const psplat_clusters *c, uint32_t a, uint32_t b) {
    for (uint32_t at = c->first_neighbor[a]; at < c->first_neighbor[a + 1]; ++at)
        if (c->neighbors[at] == b) return 1;
    return 0;
}

/* Each triangle is in a cluster, inside its sphere. Edges lead to the same cluster or to a
 * neighbour, and creases are listed by their cluster. */
static void check_edges(const psplat_surface *surface, const psplat_clusters *c) {
    size_t creases = 0;
    for (uint32_t e = 0; e < 3 * surface->mesh->triangle_count; ++e) {
        uint32_t of = c->of_triangles[e / 3], listed = 0;
        const double *p = psplat_mesh_corner(surface->mesh, e / 3, (int)(e % 3));
        assert_true(of < c->count);
        assert_true(sqrt(distance2_3(p, c->spheres[of].center)) <=
                    c->spheres[of].radius * (1 + 1e-12)); /* rounding of the root */
        for (uint32_t at = c->first_crease[of]; at < c->first_crease[of + 1]; ++at)
            listed += c->creases[at] == e;
        assert_int_equal(listed, surface->creases[e] != 0);
        creases += listed;
        if (surface->creases[e]) continue;
        uint32_t across = c->of_triangles[surface->neighbors[e]];
        assert_int_equal(is_neighbor(c, of, across), across != of);
    }
    assert_int_equal(c->first_crease[c->count], creases);
}

/* Triangles of a cluster are connected over edges that are no creases: a flood from the first one
 * that stays in the cluster meets all. */
static void check_connected(const psplat_surface *surface, const psplat_clusters *c) {
    size_t triangles = surface->mesh->triangle_count, met = 0;
    uint8_t *seen = calloc(triangles, 1), *started = calloc(c->count, 1);
    uint32_t *stack = malloc(triangles * sizeof *stack);
    assert_true(seen && started && stack);
    for (uint32_t t = 0; t < triangles; ++t) {
        uint32_t of = c->of_triangles[t], count = 0;
        if (started[of]) continue;
        started[of] = seen[t] = 1;
        for (stack[count++] = t; count;) {
            uint32_t at = stack[--count];
            ++met;
            for (uint32_t k = 0; k < 3; ++k) {
                uint32_t next = surface->neighbors[3 * at + k];
                if (surface->creases[3 * at + k] || c->of_triangles[next] != of || seen[next])
                    continue;
                seen[next] = 1;
                stack[count++] = next;
            }
        }
    }
    assert_int_equal(met, triangles);
    free(seen);
    free(started);
    free(stack);
}

static void check(const char *path, double size_diagonals, size_t most) {
    psplat_mesh mesh;
    psplat_surface surface;
    psplat_clusters c;
    psplat_error error;
    if (psplat_mesh_read(path, &mesh, &error)) fail_msg("%s", error.text);
    assert_int_equal(psplat_surface_build(&mesh, 0.5, &surface, NULL), PSPLAT_OK);
    assert_int_equal(psplat_clusters_build(&surface, size_diagonals * surface.diagonal, &c), 1);
    assert_true(c.count >= surface.patch_count && c.count <= most);
    for (uint32_t i = 0; i < c.count; ++i) {
        if (c.triangles[i] != PSPLAT_NONE)
            assert_int_equal(c.of_triangles[c.triangles[i]], i);
        else /* Corners lie within the size of one of them, so the half diagonal of their box does.
              */
            assert_true(c.spheres[i].radius <= 2 * size_diagonals * surface.diagonal);
    }
    check_edges(&surface, &c);
    check_connected(&surface, &c);
    psplat_clusters_free(&c);
    psplat_surface_free(&surface);
    psplat_mesh_free(&mesh);
}

static void test_partition(void **state) {
    (void)state;
    check(MODELS "part.obj", 0.02, 9000);
    check(MODELS "part.obj", 0.2, 100);
    check(MODELS "torus.off", 0.05, 1000);
}

/* With a size of 0 each triangle is a cluster; with one larger than the mesh, each patch is. */
static void test_extremes(void **state) {
    (void)state;
    psplat_mesh mesh;
    psplat_surface surface;
    psplat_clusters c;
    assert_int_equal(psplat_mesh_read(MODELS "cube.off", &mesh, NULL), PSPLAT_OK);
    assert_int_equal(psplat_surface_build(&mesh, 0.5, &surface, NULL), PSPLAT_OK);
    assert_int_equal(psplat_clusters_build(&surface, 0, &c), 1);
    assert_int_equal(c.count, mesh.triangle_count);
    psplat_clusters_free(&c);
    assert_int_equal(psplat_clusters_build(&surface, 10 * surface.diagonal, &c), 1);
    assert_int_equal(c.count, surface.patch_count);
    assert_int_equal(c.first_neighbor[c.count], 0);
    psplat_clusters_free(&c);
    psplat_surface_free(&surface);
    psplat_mesh_free(&mesh);
}

int test_clusters_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_partition),
        cmocka_unit_test(test_extremes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

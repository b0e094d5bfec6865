/* SPDX-License-Identifier: MIT
 *
 * test_surface.c - tests of building the surface: connectivity, creases, patches and normals of the
 * bundled models and of difficult meshes. Expected counts are those of the models' geometry.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "near.h"
#include "features/surface_build.h"
#include "base/random.h"
#include "base/vector.h"
#include "features/surface.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"

#define MODELS PSPLAT_SOURCE_DIR "/samples/models/"

static const double crease_angle = 30 * 3.14159265358979323846 / 180;

static psplat_mesh read_model(const char *path) {
    psplat_mesh mesh;
    psplat_error error;
    if (psplat_mesh_read(path, &mesh, &error)) fail_msg("%s", error.text);
    return mesh;
}

static psplat_surface build(const psplat_mesh *mesh) {
    psplat_surface surface;
    assert_int_equal(psplat_surface_build(mesh, crease_angle, &surface, NULL), PSPLAT_OK);
    return surface;
}

static void test_cube(void **state) {
    (void)state;
    psplat_mesh mesh = read_model(MODELS "cube.off");
    psplat_surface s = build(&mesh);
    assert_int_equal(s.patch_count, 6);
    assert_int_equal(s.crease_edges, 12);
    assert_int_equal(s.border_edges, 0);
    for (size_t corner = 0; corner < 3 * mesh.triangle_count; ++corner)
        for (size_t k = 0; k < 3; ++k) /* No normal is averaged over an edge of the cube. */
            assert_near((double)s.corner_normals[3 * corner + k],
                        s.face_normals[3 * (corner / 3) + k], 1e-7); /* float normals */
    psplat_surface_free(&s);
    psplat_mesh_free(&mesh);
}

static void test_smooth(void **state) {
    (void)state;
    const char *paths[] = {MODELS "sphere.ply", MODELS "torus.off"};
    for (int i = 0; i < 2; ++i) {
        psplat_mesh mesh = read_model(paths[i]);
        psplat_surface s = build(&mesh);
        assert_int_equal(s.patch_count, 1);
        assert_int_equal(s.crease_edges, 0);
        assert_int_equal(s.border_edges, 0);
        psplat_surface_free(&s);
        psplat_mesh_free(&mesh);
    }
}

/* Noise of half the mesh's edge length bends many edges by more than the crease angle; none of them
 * is a crease. */
static void test_noise(void **state) {
    (void)state;
    psplat_mesh mesh = read_model(MODELS "sphere.ply");
    const double *a = mesh.positions + 3 * (size_t)mesh.triangles[0];
    double edge[3];
    sub3(edge, mesh.positions + 3 * (size_t)mesh.triangles[1], a);
    uint64_t random = 1;
    double amplitude = 0.2 * length3(edge);
    for (size_t i = 0; i < 3 * mesh.vertex_count; ++i)
        mesh.positions[i] += amplitude * (2 * psplat_random_unit(&random) - 1);
    free(mesh.corner_normals);
    mesh.corner_normals = NULL;
    psplat_surface s = build(&mesh);
    size_t sharp = 0;
    for (uint32_t e = 0; e < 3 * mesh.triangle_count; ++e) {
        const double *n = s.face_normals;
        sharp += dot3(n + 3 * (size_t)(e / 3), n + 3 * (size_t)s.neighbors[e]) < cos(crease_angle);
    }
    print_message("noise: %zu half-edges over the crease angle, %zu creases\n", sharp,
                  s.crease_edges);
    assert_true(sharp > 500);
    assert_int_equal(s.patch_count, 1);
    assert_true(s.crease_edges < sharp / 20);
    psplat_surface_free(&s);
    psplat_mesh_free(&mesh);
}

/* The ridge of a tent flattens towards one end. This crease that ends inside the surface is kept,
 * and does not cut the patch in two. */
static void test_dart(void **state) {
    (void)state;
    enum { N = 21 };
    psplat_mesh mesh = {.vertex_count = N * N, .triangle_count = 2 * (N - 1) * (N - 1)};
    mesh.positions = malloc(N * N * 3 * sizeof(double));
    mesh.triangles = malloc(mesh.triangle_count * 3 * sizeof(uint32_t));
    assert_non_null(mesh.positions);
    assert_non_null(mesh.triangles);
    for (int i = 0; i < N * N; ++i) {
        double x = 0.2 * (i % N - N / 2), y = i / N, slope = y < 14 ? 0.8 * (1 - y / 14) : 0;
        double p[3] = {x, y, -slope * fabs(x)};
        for (int k = 0; k < 3; ++k) mesh.positions[3 * i + k] = p[k];
    }
    uint32_t *t = mesh.triangles;
    for (uint32_t y = 0; y + 1 < N; ++y)
        for (uint32_t x = 0; x + 1 < N; ++x, t += 6) {
            uint32_t a = y * N + x, b = a + 1, c = a + N, d = c + 1;
            uint32_t two[6] = {a, b, d, a, d, c};
            for (int k = 0; k < 6; ++k) t[k] = two[k];
        }
    psplat_surface s = build(&mesh);
    assert_int_equal(s.patch_count, 1);
    assert_int_equal(s.border_edges, 4 * (N - 1));
    assert_in_range(s.crease_edges, 6, 14);
    for (uint32_t e = 0; e < 3 * mesh.triangle_count; ++e) {
        uint32_t a = mesh.triangles[e], b = mesh.triangles[e % 3 == 2 ? e - 2 : e + 1];
        if (!s.creases[e] || s.neighbors[e] == PSPLAT_NONE) continue;
        assert_near(mesh.positions[3 * (size_t)a], 0, 0); /* on the ridge */
        assert_near(mesh.positions[3 * (size_t)b], 0, 0);
    }
    psplat_surface_free(&s);
    psplat_mesh_free(&mesh);
}

/* Three sheets share one edge, and two triangles have opposite orientations: all their edges are
 * creases, and nothing is joined across them. */
static void test_broken(void **state) {
    (void)state;
    double positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 0.5, 0, 1, 2, 1, 0};
    uint32_t triangles[] = {0, 1, 2, 1, 0, 3, 0, 1, 4, 1, 2, 5, 1, 2, 5};
    psplat_mesh mesh = {
        .positions = positions, .triangles = triangles, .vertex_count = 6, .triangle_count = 5};
    psplat_surface s = build(&mesh);
    for (uint32_t e = 0; e < 15; ++e) {
        assert_int_equal(s.neighbors[e], PSPLAT_NONE);
        assert_int_equal(s.creases[e], 1);
    }
    assert_int_equal(s.patch_count, 5);
    psplat_surface_free(&s);
}

/* Without creases only borders bound a patch; neither angles nor groups do. */
static void test_no_creases(void **state) {
    (void)state;
    psplat_mesh mesh = read_model(MODELS "part.obj");
    mesh.groups = calloc(mesh.triangle_count, sizeof *mesh.groups);
    assert_non_null(mesh.groups);
    mesh.groups[0] = 1;
    psplat_surface s;
    assert_int_equal(psplat_surface_build(&mesh, PSPLAT_NO_CREASES, &s, NULL), PSPLAT_OK);
    assert_int_equal(s.crease_edges, 0);
    assert_int_equal(s.patch_count, 1);
    psplat_surface_free(&s);
    s = build(&mesh);
    assert_true(s.crease_edges > 100);
    assert_true(s.patch_count > 5);
    psplat_surface_free(&s);
    psplat_mesh_free(&mesh);
}

/* Two counts are refused: no triangles, and more than 32-bit indices of edges can number. */
static void test_counts(void **state) {
    (void)state;
    psplat_surface s;
    psplat_error error = {0};
    psplat_mesh none = {.triangle_count = 0}, many = {.triangle_count = (size_t)0x55555555};
    assert_int_equal(psplat_surface_build(&none, crease_angle, &s, &error), PSPLAT_ERROR_NO_SPLATS);
    assert_int_equal(psplat_surface_build(&many, crease_angle, &s, &error), PSPLAT_ERROR_RANGE);
    assert_int_equal(error.code, PSPLAT_ERROR_RANGE);
    assert_null(s.face_normals);
    psplat_surface_free(&s);
}

/* The same cube at sizes and places far from 1: measures scale, and counts stay. */
static void test_scales(void **state) {
    (void)state;
    const double scales[] = {1e-9, 1, 1e9}, offsets[] = {0, 1e6};
    for (int i = 0; i < 6; ++i) {
        double scale = scales[i / 2], offset = offsets[i % 2];
        psplat_mesh mesh = read_model(MODELS "cube.off");
        psplat_surface before = build(&mesh);
        for (size_t k = 0; k < 3 * mesh.vertex_count; ++k)
            mesh.positions[k] = scale * (mesh.positions[k] + offset);
        psplat_surface after = build(&mesh);
        assert_int_equal(after.patch_count, 6);
        assert_int_equal(after.crease_edges, 12);
        /* An offset of 1e6 leaves ten digits. */
        assert_near(after.diagonal / scale, before.diagonal, 1e-9);
        assert_near(after.area / (scale * scale), before.area, 1e-8);
        psplat_surface_free(&before);
        psplat_surface_free(&after);
        psplat_mesh_free(&mesh);
    }
}

/* Normals of a file that lean by 87 degrees turn back to 58.7, the same way, and others stay as
 * they are. */
static void test_leaning_normals(void **state) {
    (void)state;
    const double leans[] = {0.05, 0.55}, kept[] = {0.52, 0.55};
    psplat_mesh mesh = read_model(MODELS "cube.off");
    size_t corners = 3 * mesh.triangle_count;
    mesh.corner_normals = malloc(3 * corners * sizeof(float));
    assert_non_null(mesh.corner_normals);
    psplat_surface flat = build(&mesh);
    for (int i = 0; i < 2; ++i) {
        for (size_t c = 0; c < corners; ++c) {
            const double *n = flat.face_normals + 3 * (c / 3);
            for (size_t k = 0; k < 3; ++k) /* leaning along the next axis */
                mesh.corner_normals[3 * c + k] =
                    (float)(leans[i] * n[k] + sqrt(1 - leans[i] * leans[i]) * n[(k + 1) % 3]);
        }
        psplat_surface s = build(&mesh);
        for (size_t c = 0; c < corners; ++c) {
            const double *n = flat.face_normals + 3 * (c / 3);
            for (size_t k = 0; k < 3; ++k)
                assert_near((double)s.corner_normals[3 * c + k],
                            kept[i] * n[k] + sqrt(1 - kept[i] * kept[i]) * n[(k + 1) % 3],
                            2e-7); /* float normals */
        }
        psplat_surface_free(&s);
    }
    psplat_surface_free(&flat);
    psplat_mesh_free(&mesh);
}

int test_surface_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cube),
        cmocka_unit_test(test_smooth),
        cmocka_unit_test(test_noise),
        cmocka_unit_test(test_dart),
        cmocka_unit_test(test_broken),
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_scales),
        cmocka_unit_test(test_no_creases),
        cmocka_unit_test(test_leaning_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

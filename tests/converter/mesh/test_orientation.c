/* SPDX-License-Identifier: MIT
 *
 * test_orientation.c - tests that triangles of mixed orientation are made consistent. Every
 * component gets one orientation; the file decides its front by its normals or by most of its area,
 * and else a closed component faces outwards. The shapes are bundled models with triangles flipped
 * at random, nested shells, an open sheet and a Moebius strip; expected values are the volumes and
 * counts of the unflipped mesh.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <stdio.h>
#include <cmocka.h>

#include "features/surface_build.h"
#include "base/random.h"
#include "base/vector.h"
#include "features/surface.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "mesh/orientation.h"
#include "stage_fixture.h"

static psplat_mesh read_model(const char *name) {
    psplat_mesh mesh;
    psplat_error error;
    char path[512];
    snprintf(path, sizeof path, PSPLAT_SOURCE_DIR "/samples/models/%s", name);
    if (psplat_mesh_read(path, &mesh, &error)) fail_msg("%s", error.text);
    return mesh;
}

static void drop_normals(psplat_mesh *mesh) {
    free(mesh->corner_normals);
    mesh->corner_normals = NULL;
}

/* Flips a triangle as an exporter with mixed winding does: normals and colours stay at their
 * vertices. */
static void flip(psplat_mesh *mesh, size_t triangle) {
    uint32_t *t = mesh->triangles + 3 * triangle, vertex = t[1];
    t[1] = t[2], t[2] = vertex;
    for (size_t k = 0; k < 3 && mesh->corner_normals; ++k) {
        float *n = mesh->corner_normals + 9 * triangle + 3 + k, held = n[0];
        n[0] = n[3], n[3] = held;
    }
}

static int orient(psplat_mesh *mesh) {
    int consistent = -1;
    assert_int_equal(psplat_mesh_orient(mesh, &consistent, NULL), PSPLAT_OK);
    return consistent;
}

static double volume(const psplat_mesh *mesh) {
    double sum = 0, c[3];
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const double *p[3];
        for (size_t k = 0; k < 3; ++k)
            p[k] = mesh->positions + 3 * (size_t)mesh->triangles[3 * t + k];
        cross3(c, p[1], p[2]);
        sum += dot3(p[0], c) / 6;
    }
    return sum;
}

/* Half of the triangles are flipped at random, with and without normals in the file. The outer side
 * becomes the front, and only the real borders and creases bound patches. */
static void test_random_flips(void **state) {
    (void)state;
    const char *names[] = {"sphere.ply", "torus.off", "cube.off", "part.obj"};
    for (int i = 0; i < 8; ++i) {
        psplat_mesh mesh = read_model(names[i / 2]);
        if (i % 2) drop_normals(&mesh);
        psplat_surface before, after;
        assert_int_equal(psplat_surface_build(&mesh, fixture_crease_angle, &before, NULL), 0);
        double expected = volume(&mesh);
        uint64_t random = 5;
        for (size_t t = 0; t < mesh.triangle_count; ++t)
            if (psplat_random_unit(&random) < 0.5) flip(&mesh, t);
        assert_int_equal(orient(&mesh), 1);
        /* relative, sums in another order */
        assert_near(volume(&mesh), expected, 1e-12 * fabs(expected));
        assert_int_equal(psplat_surface_build(&mesh, fixture_crease_angle, &after, NULL), 0);
        assert_int_equal(after.patch_count, before.patch_count);
        assert_int_equal(after.crease_edges, before.crease_edges);
        psplat_surface_free(&before);
        psplat_surface_free(&after);
        psplat_mesh_free(&mesh);
    }
}

/* The corners of a turned triangle keep their attributes. */
static void test_corners_move_along(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("sphere.ply");
    assert_non_null(mesh.corner_normals);
    mesh.corner_colors = malloc(mesh.triangle_count * 12 * sizeof(float));
    assert_non_null(mesh.corner_colors);
    for (size_t t = 0; t < mesh.triangle_count; t += 3) flip(&mesh, t);
    for (size_t c = 0; c < 3 * mesh.triangle_count; ++c)
        for (size_t k = 0; k < 4; ++k)
            mesh.corner_colors[4 * c + k] = (float)(mesh.triangles[c] % 1000 + k);
    assert_int_equal(orient(&mesh), 1);
    for (size_t c = 0; c < 3 * mesh.triangle_count; ++c) {
        double p[3];
        memcpy(p, mesh.positions + 3 * (size_t)mesh.triangles[c], sizeof p);
        double length = normalize3(p);
        assert_true(length > 0);
        for (size_t k = 0; k < 3; ++k) /* the file's floats */
            assert_near((double)mesh.corner_normals[3 * c + k], p[k], 1e-6);
        for (size_t k = 0; k < 4; ++k)
            assert_near((double)mesh.corner_colors[4 * c + k],
                        (double)(mesh.triangles[c] % 1000 + k), 0);
    }
    psplat_mesh_free(&mesh);
}

/* Two shells of which the inner one faces inwards form a wall. One flipped triangle in each is
 * repaired, but the inner shell is not turned outwards. */
static void test_inner_wall(void **state) {
    (void)state;
    psplat_mesh one = read_model("torus.off"), two = {0};
    size_t vertices = one.vertex_count, triangles = one.triangle_count;
    assert_int_equal(psplat_mesh_allocate(&two, 2 * vertices, 2 * triangles, 0, NULL), PSPLAT_OK);
    for (size_t i = 0; i < 3 * vertices; ++i) {
        two.positions[i] = one.positions[i];
        two.positions[3 * vertices + i] = 0.5 * one.positions[i];
    }
    for (size_t i = 0; i < 3 * triangles; ++i) {
        two.triangles[i] = one.triangles[i];
        two.triangles[3 * triangles + i] = (uint32_t)vertices + one.triangles[i];
    }
    for (size_t t = triangles; t < 2 * triangles; ++t) flip(&two, t);
    flip(&two, 7);
    flip(&two, triangles + 7);
    assert_int_equal(orient(&two), 1);
    double expected = volume(&one) * (1 - 0.125);
    assert_near(volume(&two), expected, 1e-12 * expected); /* relative, sums in another order */
    psplat_mesh_free(&one);
    psplat_mesh_free(&two);
}

/* A model is inside out, but its normals point outwards: the winding is taken for the error. */
static void test_normals_decide(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("sphere.ply");
    double expected = volume(&mesh);
    for (size_t t = 0; t < mesh.triangle_count; ++t) flip(&mesh, t);
    assert_near(volume(&mesh), -expected, 1e-12 * expected); /* relative, sums in another order */
    assert_int_equal(orient(&mesh), 1);
    assert_near(volume(&mesh), expected, 1e-12 * expected);
    /* Without normals the file's orientation stays. */
    for (size_t t = 0; t < mesh.triangle_count; ++t) flip(&mesh, t);
    drop_normals(&mesh);
    assert_int_equal(orient(&mesh), 1);
    assert_near(volume(&mesh), -expected, 1e-12 * expected);
    psplat_mesh_free(&mesh);
}

static void place_plane(double s, double t, double p[3]) {
    p[0] = s, p[1] = t, p[2] = 0;
}

/* An open sheet keeps the side that most of its triangles had. */
static void test_open_majority(void **state) {
    (void)state;
    for (int wrong = 0; wrong < 2; ++wrong) {
        fixture f;
        fixture_grid(&f, 10, 10, place_plane);
        for (size_t t = 0; t < f.mesh.triangle_count; ++t)
            if ((t % 10 == 3) != wrong) flip(&f.mesh, t);
        assert_int_equal(orient(&f.mesh), 1);
        fixture_build(&f);
        assert_int_equal(f.surface.patch_count, 1);
        assert_int_equal(f.surface.crease_edges, 0);
        for (size_t t = 0; t < f.mesh.triangle_count; ++t) /* rounding of unit vectors */
            assert_near(f.surface.face_normals[3 * t + 2], wrong ? -1 : 1, 1e-12);
        fixture_free(&f);
    }
}

static void place_moebius(double s, double t, double p[3]) {
    double turn = 2 * fixture_pi * s, width = 0.5 * (t - 0.5);
    p[0] = (1 + width * cos(turn / 2)) * cos(turn);
    p[1] = (1 + width * cos(turn / 2)) * sin(turn);
    p[2] = width * sin(turn / 2);
}

/* A Moebius strip has no front: one line across it remains, on which triangles of opposite sides
 * meet. */
static void test_moebius(void **state) {
    (void)state;
    enum { COLUMNS = 40, ROWS = 4 };
    fixture f;
    fixture_grid(&f, COLUMNS, ROWS, place_moebius);
    for (size_t i = 0; i < 3 * f.mesh.triangle_count; ++i) {
        uint32_t v = f.mesh.triangles[i]; /* The last column is the first one upside down. */
        if (v % (COLUMNS + 1) == COLUMNS)
            f.mesh.triangles[i] = (ROWS - v / (COLUMNS + 1)) * (COLUMNS + 1);
    }
    assert_int_equal(orient(&f.mesh), 0);
    fixture_build(&f);
    size_t disagree = 0;
    for (size_t e = 0; e < 3 * f.mesh.triangle_count; ++e)
        disagree += f.surface.neighbors[e] == PSPLAT_NONE;
    assert_int_equal(f.surface.border_edges, 2 * COLUMNS);
    /* At least one line from border to border is counted, once for each side, and at most a jagged
     * one, which is three times as long. */
    assert_in_range(disagree - f.surface.border_edges, 2 * ROWS, 6 * ROWS);
    fixture_free(&f);
}

int test_orientation_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_flips),  cmocka_unit_test(test_corners_move_along),
        cmocka_unit_test(test_inner_wall),    cmocka_unit_test(test_normals_decide),
        cmocka_unit_test(test_open_majority), cmocka_unit_test(test_moebius),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_authored_normals.c - tests of normals given by the file: where they mark hard and smooth
 * edges, and where they are not usable (flat-shaded, random, missing or backward). The shape is
 * mostly a roof of two halves that meet at a known angle.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "shape_fixture.h"
#include "features/surface_build.h"
#include "base/random.h"
#include "features/surface.h"
#include "mesh/mesh.h"

static double roof_slope;

static void place_roof(double s, double t, double p[3]) {
    p[0] = 2 * s - 1, p[1] = 2 * t, p[2] = -roof_slope * fabs(2 * s - 1);
}

/* Makes 20 x 20 squares whose two halves meet at an angle of `degrees`. */
static void make_roof(fixture *f, double degrees) {
    roof_slope = tan(degrees / 2 * fixture_pi / 180);
    fixture_grid(f, 20, 20, place_roof);
}

/* Sets all normals to one direction, which makes every edge smooth. */
static void set_normals(psplat_mesh *mesh, const float n[3]) {
    mesh->corner_normals = malloc(mesh->triangle_count * 9 * sizeof(float));
    assert_non_null(mesh->corner_normals);
    for (size_t c = 0; c < 3 * mesh->triangle_count; ++c)
        memcpy(mesh->corner_normals + 3 * c, n, 3 * sizeof(float));
}

static const float up[3] = {0, 0, 1};

/* A bend of 12 degrees is smooth, unless the file has two normals along it. */
static void test_hard_edge(void **state) {
    (void)state;
    for (int authored = 0; authored < 2; ++authored) {
        fixture f;
        make_roof(&f, 12);
        if (authored) shape_flat_normals(&f.mesh);
        fixture_build(&f);
        assert_int_equal(f.surface.patch_count, authored ? 2 : 1);
        assert_int_equal(f.surface.crease_edges, authored ? 20 : 0);
        fixture_free(&f);
    }
}

/* Where the file's normals agree, an edge of 45 degrees is smooth. One of 90 degrees is a crease,
 * because a splat could not follow it, but its normals are kept. */
static void test_smooth_edge(void **state) {
    (void)state;
    for (int sharp = 0; sharp < 2; ++sharp) {
        fixture f;
        make_roof(&f, sharp ? 90 : 45);
        set_normals(&f.mesh, up);
        fixture_build(&f);
        assert_int_equal(f.surface.patch_count, sharp ? 2 : 1);
        assert_int_equal(f.surface.crease_edges, sharp ? 20 : 0);
        assert_memory_equal(f.surface.corner_normals, f.mesh.corner_normals,
                            f.mesh.triangle_count * 9 * sizeof(float));
        fixture_free(&f);
    }
}

/* A ridge fades out. Its last edge, which has two normals at one end only, belongs to the crease;
 * an edge beside it with two normals at one end does not become a crease. */
static void test_dart(void **state) {
    (void)state;
    fixture f;
    make_roof(&f, 12);
    set_normals(&f.mesh, up);
    for (size_t c = 0; c < 3 * f.mesh.triangle_count; ++c) {
        uint32_t v = f.mesh.triangles[c];
        int right = 0; /* whether the triangle is on the right of the ridge */
        for (size_t k = 0; k < 3; ++k) right |= f.mesh.triangles[c - c % 3 + k] % 21 > 10;
        if (v % 21 != 10 || v / 21 > 7 || !right) continue;
        f.mesh.corner_normals[3 * c] = 0.6f; /* along the ridge up to its eighth vertex */
        f.mesh.corner_normals[3 * c + 2] = 0.8f;
    }
    fixture_build(&f);
    assert_int_equal(f.surface.patch_count, 1);
    /* Seven edges, and the last one on which the ridge fades. */
    assert_int_equal(f.surface.crease_edges, 8);
    fixture_free(&f);
}

/* A sphere with one normal for each triangle is smooth: its normals are averaged, as if the file
 * had none. */
static void test_flat_shaded(void **state) {
    (void)state;
    static const char *const names[] = {"sphere.ply", "torus.off"};
    for (int i = 0; i < 2; ++i) {
        fixture f;
        fixture_model(&f, names[i]);
        free(f.mesh.corner_normals);
        f.mesh.corner_normals = NULL;
        psplat_surface plain = shape_surface(&f.mesh, 30), flat;
        shape_flat_normals(&f.mesh);
        flat = shape_surface(&f.mesh, 30);
        assert_int_equal(flat.patch_count, 1);
        assert_int_equal(flat.crease_edges, 0);
        assert_memory_equal(flat.corner_normals, plain.corner_normals,
                            f.mesh.triangle_count * 9 * sizeof(float));
        psplat_surface_free(&plain);
        psplat_surface_free(&flat);
        fixture_free(&f);
    }
}

/* A box with one normal for each triangle keeps its creases. */
static void test_flat_box(void **state) {
    (void)state;
    for (int n = 1; n <= 10; n += 9) {
        psplat_mesh mesh = shape_cube(n);
        shape_flat_normals(&mesh);
        psplat_surface s = shape_surface(&mesh, 30);
        assert_int_equal(s.patch_count, 6);
        assert_int_equal(s.crease_edges, 12 * n);
        psplat_surface_free(&s);
        psplat_mesh_free(&mesh);
    }
}

/* Where normals are random, zero or backward, the surface is the same as for a file without
 * normals. */
static void test_garbage(void **state) {
    (void)state;
    for (int kind = 0; kind < 3; ++kind) {
        fixture f;
        make_roof(&f, 40);
        psplat_surface plain = shape_surface(&f.mesh, 30);
        set_normals(&f.mesh, up);
        uint64_t random = 3;
        for (size_t i = 0; i < 9 * f.mesh.triangle_count; ++i) {
            float value = kind == 0 ? (float)(2 * psplat_random_unit(&random) - 1) : 0;
            f.mesh.corner_normals[i] = kind == 2 ? -f.mesh.corner_normals[i] : value;
        }
        fixture_build(&f);
        assert_int_equal(f.surface.patch_count, 2);
        assert_memory_equal(f.surface.creases, plain.creases, 3 * f.mesh.triangle_count);
        assert_memory_equal(f.surface.corner_normals, plain.corner_normals,
                            f.mesh.triangle_count * 9 * sizeof(float));
        psplat_surface_free(&plain);
        fixture_free(&f);
    }
}

/* A corner with no normal, and one with a backward normal, get the average around them; the other
 * corners keep theirs. */
static void test_missing_corners(void **state) {
    (void)state;
    fixture f;
    make_roof(&f, 0);
    const float tilted[3] = {0.6f, 0, 0.8f};
    set_normals(&f.mesh, tilted);
    memset(f.mesh.corner_normals + 3 * 301, 0, 3 * sizeof(float));
    f.mesh.corner_normals[3 * 601 + 2] = -0.8f;
    fixture_build(&f);
    assert_int_equal(f.surface.patch_count, 1);
    for (size_t c = 0; c < 3 * f.mesh.triangle_count; ++c) {
        int averaged = c == 301 || c == 601; /* the average of a plane is up */
        for (size_t k = 0; k < 3; ++k)
            assert_near((double)f.surface.corner_normals[3 * c + k],
                        (double)(averaged ? up[k] : tilted[k]), 1e-6); /* float normals */
    }
    fixture_free(&f);
}

/* A flat-shaded sphere does not affect whether the normals of the roof beside it are used. */
static void test_components(void **state) {
    (void)state;
    fixture roof, sphere;
    make_roof(&roof, 12);
    fixture_model(&sphere, "sphere.ply");
    psplat_mesh both = {0};
    const psplat_mesh *parts[2] = {&roof.mesh, &sphere.mesh};
    size_t vertices = roof.mesh.vertex_count + sphere.mesh.vertex_count;
    size_t triangles = roof.mesh.triangle_count + sphere.mesh.triangle_count;
    assert_int_equal(psplat_mesh_allocate(&both, vertices, triangles, 0, NULL), PSPLAT_OK);
    size_t v = 0, t = 0;
    for (int i = 0; i < 2; ++i) {
        memcpy(both.positions + 3 * v, parts[i]->positions,
               3 * parts[i]->vertex_count * sizeof(double));
        for (size_t k = 0; k < 3 * parts[i]->triangle_count; ++k)
            both.triangles[3 * t + k] = (uint32_t)v + parts[i]->triangles[k];
        v += parts[i]->vertex_count, t += parts[i]->triangle_count;
    }
    shape_flat_normals(&both);
    psplat_surface s = shape_surface(&both, 30);
    assert_int_equal(s.patch_count, 3); /* two halves and the sphere */
    assert_int_equal(s.crease_edges, 20);
    psplat_surface_free(&s);
    psplat_mesh_free(&both);
    fixture_free(&roof);
    fixture_free(&sphere);
}

/* Without creases the file's normals bound no patch, but they are kept. */
static void test_no_creases(void **state) {
    (void)state;
    fixture f;
    make_roof(&f, 90);
    shape_flat_normals(&f.mesh);
    assert_int_equal(psplat_surface_build(&f.mesh, PSPLAT_NO_CREASES, &f.surface, NULL), PSPLAT_OK);
    assert_int_equal(f.surface.patch_count, 1);
    assert_memory_equal(f.surface.corner_normals, f.mesh.corner_normals,
                        f.mesh.triangle_count * 9 * sizeof(float));
    fixture_free(&f);
}

int test_authored_normals_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hard_edge),
        cmocka_unit_test(test_smooth_edge),
        cmocka_unit_test(test_dart),
        cmocka_unit_test(test_flat_shaded),
        cmocka_unit_test(test_flat_box),
        cmocka_unit_test(test_garbage),
        cmocka_unit_test(test_missing_corners),
        cmocka_unit_test(test_components),
        cmocka_unit_test(test_no_creases),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

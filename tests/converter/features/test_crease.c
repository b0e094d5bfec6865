/* SPDX-License-Identifier: MIT
 *
 * test_crease.c - tests of crease detection: which edges are creases, and which are not, on noisy
 * and coarse meshes, fillets, creases that fade out, tips, and unusual angles. The shapes have
 * known edges; expected values are their numbers of creases and patches.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <stdlib.h>
#include <cmocka.h>

#include "shape_fixture.h"
#include "base/vector.h"
#include "features/surface.h"
#include "mesh/mesh.h"

static void expect(const psplat_mesh *mesh, double degrees, size_t patches, size_t creases) {
    psplat_surface s = shape_surface(mesh, degrees);
    assert_int_equal(s.patch_count, patches);
    assert_int_equal(s.crease_edges, creases);
    psplat_surface_free(&s);
}

/* Returns whether a point of the cube without noise lies on one of its edges. */
static int is_on_edge(const double p[3]) {
    int extreme = 0;
    for (int k = 0; k < 3; ++k) extreme += fabs(p[k]) > 1 - 1e-9;
    return extreme >= 2;
}

/* All twelve edges of a noisy cube are found completely, and no other edges. Noise is up to 10 % of
 * the mesh's edges, which bends triangles by 16 degrees, or a part of the diagonal. */
static void test_noisy_cube(void **state) {
    (void)state;
    const struct {
        int n;
        double of_edge, of_diagonal;
    } cases[] = {{8, 0, 0.001}, {8, 0, 0.005}, {8, 0, 0.01}, {20, 0, 0.001}, {8, 0.02, 0},
                 {8, 0.1, 0},   {20, 0.02, 0}, {20, 0.1, 0}, {30, 0.05, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_mesh clean = shape_cube(cases[i].n), noisy = shape_cube(cases[i].n);
        shape_noise(&noisy,
                    cases[i].of_edge * shape_mean_edge(&clean) + cases[i].of_diagonal * sqrt(12));
        psplat_surface s = shape_surface(&noisy, 30);
        assert_int_equal(s.patch_count, 6);
        assert_int_equal(s.crease_edges, 12 * cases[i].n);
        for (uint32_t e = 0; e < 3 * clean.triangle_count; ++e) {
            uint32_t next = e % 3 == 2 ? e - 2 : e + 1;
            if (!s.creases[e]) continue;
            assert_true(is_on_edge(clean.positions + 3 * (size_t)clean.triangles[e]));
            assert_true(is_on_edge(clean.positions + 3 * (size_t)clean.triangles[next]));
        }
        psplat_surface_free(&s);
        psplat_mesh_free(&clean);
        psplat_mesh_free(&noisy);
    }
}

/* No noise makes a crease on a sphere, even with a fifth of the edge length, at which half of the
 * edges bend by more than the crease angle. */
static void test_noisy_sphere(void **state) {
    (void)state;
    const double parts[] = {0.02, 0.1, 0.2};
    for (int i = 0; i < 3; ++i) {
        fixture f;
        fixture_model(&f, "sphere.ply");
        free(f.mesh.corner_normals);
        f.mesh.corner_normals = NULL;
        shape_noise(&f.mesh, parts[i] * shape_mean_edge(&f.mesh));
        expect(&f.mesh, 30, 1, 0);
        fixture_free(&f);
    }
}

/* The angle between the faces of a prism decides whether its edges are creases. */
static void test_prisms(void **state) {
    (void)state;
    static const double profile[4][2] = {{0, -1}, {1, -1}, {1, 1}, {0, 1}};
    for (int sides = 4; sides < 40; ++sides) {
        psplat_mesh mesh = shape_turned(profile, 4, sides);
        size_t n = (size_t)sides;
        double bend = 360.0 / sides;
        expect(&mesh, bend - 1, n + 2, 3 * n);
        /* Eight faces are too few to tell a round side from faces that end in the creases of the
         * caps. */
        if (sides > 8) expect(&mesh, bend + 1, 3, 2 * n);
        psplat_mesh_free(&mesh);
    }
}

/* A box with edges of 90 degrees has a fillet or a chamfer all around its top. */
static void test_fillets(void **state) {
    (void)state;
    enum { SIDES = 48 };
    for (int segments = 1; segments <= 16; segments *= 2) {
        double profile[40][2] = {{0, 0}, {1, 0}};
        int count = 2;
        for (int i = 0; i <= segments; ++i, ++count) {
            double turn = fixture_pi / 2 * i / segments;
            profile[count][0] = 0.8 + 0.2 * cos(turn);
            profile[count][1] = 1 + 0.2 * sin(turn);
        }
        ++count; /* the middle of the top */
        profile[count - 1][0] = 0;
        profile[count - 1][1] = 1.2;
        psplat_mesh mesh = shape_turned((const double(*)[2])profile, count, SIDES);
        if (segments == 1) /* both edges of the chamfer, and that of the bottom */
            expect(&mesh, 30, 4, 3 * SIDES);
        if (segments >= 4) expect(&mesh, 30, 2, SIDES);
        psplat_mesh_free(&mesh);
    }
}

/* The rim of a cone is a crease; no crease leads to its tip. */
static void test_cones(void **state) {
    (void)state;
    for (int sides = 16; sides <= 64; sides *= 2) {
        double profile[12][2] = {{0, 0}};
        for (int i = 0; i <= 10; ++i) {
            profile[1 + i][0] = 1 - 0.1 * i;
            profile[1 + i][1] = 0.3 * i;
        }
        profile[11][0] = 0;
        psplat_mesh mesh = shape_turned((const double(*)[2])profile, 12, sides);
        expect(&mesh, 30, 2, (size_t)sides);
        psplat_mesh_free(&mesh);
    }
}

static void place_dart(double s, double t, double p[3]) {
    double slope = t < 0.7 ? 0.8 * (1 - t / 0.7) : 0;
    p[0] = 2 * s - 1, p[1] = 2 * t, p[2] = -slope * fabs(2 * s - 1);
}

enum { ROUNDINGS = 4, FACETS = 2 * (ROUNDINGS + 2) };

/* Places a profile with a bend of 45 degrees in its middle: a face, narrow strips that bend by 9
 * degrees each, the bend, more such strips, and a face. */
static void place_rounded_faces(double s, double t, double p[3]) {
    int facets = (int)lrint(s * FACETS);
    double x = 0, z = 0, turn = 0;
    for (int i = 0; i < facets; ++i) {
        int from_middle = i < FACETS / 2 ? FACETS / 2 - 1 - i : i - FACETS / 2;
        double width = from_middle >= 1 && from_middle <= ROUNDINGS ? 0.3 : 1;
        int joint = i < FACETS / 2 ? from_middle : from_middle + 1; /* 0 for the middle */
        x += width * cos(turn), z -= width * sin(turn);
        turn += (joint == 0 ? 45 : joint <= ROUNDINGS ? 9 : 0) * fixture_pi / 180;
    }
    p[0] = x, p[1] = 8 * t, p[2] = z;
}

/* A coarse mesh bends much in one place and little in others. The large bend is a crease, although
 * the normals extrapolated over the small bends would agree at it. */
static void test_two_kinds_of_bends(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, FACETS, 2, place_rounded_faces);
    fixture_build(&f);
    assert_int_equal(f.surface.crease_edges, 2);
    for (uint32_t e = 0; e < 3 * f.mesh.triangle_count; ++e)
        if (f.surface.creases[e] && f.surface.neighbors[e] != PSPLAT_NONE)
            assert_int_equal(f.mesh.triangles[e] % (FACETS + 1), FACETS / 2);
    fixture_free(&f);
}

/* A crease that fades out is followed until it bends by less than a third of the crease angle;
 * beyond its end the surface is one patch. Noise shortens the crease. */
static void test_dart(void **state) {
    (void)state;
    for (int noisy = 0; noisy < 2; ++noisy) {
        fixture f;
        fixture_grid(&f, 40, 40, place_dart);
        if (noisy) shape_noise(&f.mesh, 0.03 * shape_mean_edge(&f.mesh));
        fixture_build(&f);
        assert_int_equal(f.surface.patch_count, 1);
        double reach = 0;
        for (uint32_t e = 0; e < 3 * f.mesh.triangle_count; ++e) {
            if (!f.surface.creases[e] || f.surface.neighbors[e] == PSPLAT_NONE) continue;
            assert_int_equal(f.mesh.triangles[e] % 41, 20); /* on the ridge */
            reach = max2(reach, f.mesh.positions[3 * (size_t)f.mesh.triangles[e] + 1]);
        }
        /* The ridge bends by 2 atan(slope): 30 degrees at y = 0.93, and 10 degrees at 1.25. */
        assert_in_range((int)(1000 * reach), noisy ? 650 : 1150, 1300);
        fixture_free(&f);
    }
}

/* Twenty strips of 18 degrees end at the caps of a cylinder. They bend by more than a third of the
 * crease angle, but they branch off the caps' creases instead of continuing them, and are no
 * creases. */
static void test_no_spurs(void **state) {
    (void)state;
    double profile[14][2] = {{0, -1}};
    for (int i = 0; i <= 10; ++i) profile[1 + i][0] = 1, profile[1 + i][1] = -1 + 0.2 * i;
    profile[12][1] = 1;
    psplat_mesh mesh = shape_turned((const double(*)[2])profile, 13, 20);
    expect(&mesh, 30, 3, 40);
    psplat_mesh_free(&mesh);
}

/* The crease angles lie at both ends of their range, and on both sides of the 90 degrees of a cube.
 */
static void test_extreme_angles(void **state) {
    (void)state;
    psplat_mesh mesh = shape_cube(4);
    expect(&mesh, 89.9, 6, 48);
    expect(&mesh, 90.1, 1, 0);
    expect(&mesh, 179.9, 1, 0);
    expect(&mesh, 0.1, 6, 48);
    psplat_mesh_free(&mesh);
    /* two triangles folded flat onto each other, and a single one */
    double positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.1, 0.8, 0};
    uint32_t triangles[] = {0, 1, 2, 1, 0, 3};
    psplat_mesh fold = {
        .positions = positions, .triangles = triangles, .vertex_count = 4, .triangle_count = 2};
    expect(&fold, 30, 2, 1);
    expect(&fold, 179.9, 2, 1);
    fold.triangle_count = 1;
    expect(&fold, 30, 1, 0);
}

/* A triangle without area, such as one that closes a T-junction, makes no crease. */
static void test_flat_triangle(void **state) {
    (void)state;
    double positions[] = {0, 0, 0, 2, 0, 0, 1, 2, 0, 1, 0, 0, 1, -2, 0};
    uint32_t triangles[] = {0, 1, 2, 1, 0, 3, 0, 4, 3, 3, 4, 1};
    psplat_mesh mesh = {
        .positions = positions, .triangles = triangles, .vertex_count = 5, .triangle_count = 4};
    expect(&mesh, 30, 1, 0);
}

/* The same edges of a noisy part are found at every size and place. */
static void test_noisy_scales(void **state) {
    (void)state;
    const double scales[] = {1e-9, 1e9}, offset = 1e6;
    for (int i = 0; i < 2; ++i) {
        psplat_mesh mesh = shape_cube(8);
        shape_noise(&mesh, 0.2 * shape_mean_edge(&mesh));
        psplat_surface before = shape_surface(&mesh, 30);
        for (size_t k = 0; k < 3 * mesh.vertex_count; ++k)
            mesh.positions[k] = scales[i] * (mesh.positions[k] + offset);
        psplat_surface after = shape_surface(&mesh, 30);
        assert_true(before.crease_edges > 48);
        assert_memory_equal(before.creases, after.creases, 3 * mesh.triangle_count);
        psplat_surface_free(&before);
        psplat_surface_free(&after);
        psplat_mesh_free(&mesh);
    }
}

/* Each face of the bundled part is one patch, its holes are not cut into strips, and an edge that
 * bends by only 28 degrees is found because it is connected to sharper creases. */
static void test_part(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "part.obj");
    assert_int_equal(f.surface.patch_count, 14);
    assert_in_range(f.surface.crease_edges, 709, 750); /* 709 edges bend by 30 degrees or more */
    fixture_free(&f);
}

int test_crease_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_noisy_cube),   cmocka_unit_test(test_noisy_sphere),
        cmocka_unit_test(test_prisms),       cmocka_unit_test(test_fillets),
        cmocka_unit_test(test_cones),        cmocka_unit_test(test_dart),
        cmocka_unit_test(test_no_spurs),     cmocka_unit_test(test_extreme_angles),
        cmocka_unit_test(test_noisy_scales), cmocka_unit_test(test_flat_triangle),
        cmocka_unit_test(test_part),         cmocka_unit_test(test_two_kinds_of_bends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

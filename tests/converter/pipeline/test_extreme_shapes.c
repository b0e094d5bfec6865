/* SPDX-License-Identifier: MIT
 *
 * test_extreme_shapes.c - tests that input which is hardly a surface, or hardly fits splats, is
 * converted correctly: every point is covered by a splat of its own side, and every splat is near
 * the surface. The shapes are non-manifold, flipped, intersecting, tiny or have difficult corners;
 * the measure is the brute force of extreme_fixture.h.
 */
#include "mesh_fixture.h"

#include "extreme_fixture.h"
#include "base/random.h"
#include "base/region.h"
#include "base/vector.h"

#include <math.h>
#include <string.h>

/* ---- defective meshes ------------------------------------------------------------------------ */

/* Three sheets share one edge. */
static void test_three_sheets(void **state) {
    (void)state;
    shape s = {0};
    uint32_t a = shape_vertex(&s, 0, 0, 0), b = shape_vertex(&s, 0, 0, 1);
    for (int i = 0; i < 3; ++i) {
        double x = cos(2.1 * i), y = sin(2.1 * i);
        uint32_t c = shape_vertex(&s, x, y, 1), d = shape_vertex(&s, x, y, 0);
        shape_quad(&s, a, b, c, d);
    }
    extreme e = extreme_right("three sheets on an edge", &s, 1);
    assert_true(e.splats.count >= 3 && e.splats.count <= 12);
    extreme_free(&e);
}

/* Two tents touch at their tips. */
static void test_bowtie(void **state) {
    (void)state;
    shape s = {0};
    uint32_t tip = shape_vertex(&s, 0, 0, 0);
    uint32_t up = shape_ring(&s, 5, 1, 1);
    shape_fan(&s, tip, up, 5);
    uint32_t down = shape_ring(&s, 5, 1, -1);
    shape_fan(&s, tip, down, 5);
    extreme e = extreme_right("two tents on one vertex", &s, 1);
    extreme_free(&e);
}

/* Each corner has a vertex of its own, and each face occurs twice. */
static void test_duplicates(void **state) {
    (void)state;
    shape box = {0}, s = {0};
    static const double low[3] = {0, 0, 0}, high[3] = {2, 1, 1};
    shape_box(&box, low, high);
    for (size_t i = 0; i < 2 * box.triangle_count; ++i) {
        uint32_t v[3];
        for (int k = 0; k < 3; ++k) {
            const double *p = box.vertices[box.triangles[i % box.triangle_count][k]];
            v[k] = shape_vertex(&s, p[0], p[1], p[2]);
        }
        shape_triangle(&s, v[0], v[1], v[2]);
    }
    shape_free(&box);
    extreme e = extreme_right("vertices and faces twice", &s, 1);
    extreme_free(&e);
}

static void place_sphere(double s, double t, double p[3]) {
    double theta = extreme_pi * t, phi = 2 * extreme_pi * s;
    p[0] = sin(theta) * cos(phi), p[1] = sin(theta) * sin(phi), p[2] = -cos(theta);
    if (s == 1) p[0] = sin(theta), p[1] = 0;
    if (t == 0 || t == 1) p[0] = p[1] = 0;
    if (t == 1) p[2] = 1;
}

/* Half of a sphere's triangles face inwards; all splats must face outwards. */
static void test_flipped(void **state) {
    (void)state;
    shape s = {0};
    uint64_t random = 5;
    shape_grid(&s, 32, 16, place_sphere);
    for (size_t i = 0; i < s.triangle_count; ++i) {
        uint32_t *t = s.triangles[i], held = t[1];
        if (psplat_random_next(&random) & 1) t[1] = t[2], t[2] = held;
    }
    extreme e = extreme_right("half of the faces flipped", &s, 2);
    for (size_t i = 0; i < e.splats.count; ++i)
        assert_true(dot3(e.regions[i].n, e.regions[i].center) > 0);
    assert_true(e.splats.count < 100); /* without flips there are 60 to 70 */
    extreme_free(&e);
}

/* Two boxes intersect; both stay whole. */
static void test_intersecting(void **state) {
    (void)state;
    shape s = {0};
    static const double a[2][3] = {{0, 0, 0}, {3, 1, 1}}, b[2][3] = {{1, -1, 0.25}, {2, 2, 0.75}};
    shape_box(&s, a[0], a[1]);
    shape_box(&s, b[0], b[1]);
    extreme e = extreme_right("boxes through each other", &s, 1);
    assert_true(e.splats.count <= 36);
    extreme_free(&e);
}

/* A box contains a hollow, whose faces point inwards, and stands beside another box. */
static void test_shells(void **state) {
    (void)state;
    shape s = {0};
    static const double a[2][3] = {{0, 0, 0}, {1, 1, 1}};
    /* x exchanged: faces inwards */
    static const double b[2][3] = {{0.8, 0.2, 0.2}, {0.2, 0.8, 0.8}};
    static const double c[2][3] = {{1.01, 0, 0}, {1.5, 1, 1}}; /* a tolerance away */
    shape_box(&s, a[0], a[1]);
    shape_box(&s, b[0], b[1]);
    shape_box(&s, c[0], c[1]);
    extreme e = extreme_right("shells a tolerance apart", &s, 0.5);
    size_t inwards = 0;
    for (size_t i = 0; i < e.splats.count; ++i) {
        double p[3], middle[3] = {0.5, 0.5, 0.5}, d[3];
        memcpy(p, e.regions[i].center, sizeof p);
        mad3(p, 1, e.mesh.origin);
        sub3(d, p, middle);
        inwards += fabs(d[0]) < 0.31 && fabs(d[1]) < 0.31 && fabs(d[2]) < 0.31 &&
                   dot3(d, e.regions[i].n) < 0;
    }
    assert_true(inwards >= 6);
    assert_true(e.splats.count <= 36);
    extreme_free(&e);
}

/* ---- the smallest meshes --------------------------------------------------------------------- */

static void test_triangle(void **state) {
    (void)state;
    shape s = {0};
    shape_vertex(&s, 0, 0, 0);
    shape_vertex(&s, 1, 0, 0);
    shape_vertex(&s, 0.3, 0.7, 0.2);
    shape_triangle(&s, 0, 1, 2);
    extreme e = extreme_right("one triangle", &s, 0.5);
    assert_int_equal(e.splats.count, 1);
    assert_int_equal(e.report.splats_by_clip_lines[3], 1);
    extreme_free(&e);
}

static void test_tetrahedron(void **state) {
    (void)state;
    shape s = {0};
    uint32_t tip = shape_vertex(&s, 0.1, 0, 1), ring = shape_ring(&s, 3, 1, 0);
    shape_fan(&s, tip, ring, 3);
    shape_triangle(&s, ring, ring + 2, ring + 1);
    extreme e = extreme_right("corners of a tetrahedron", &s, 0.5);
    assert_int_equal(e.splats.count, 4);
    extreme_free(&e);
}

/* ---- corners --------------------------------------------------------------------------------- */

/* A cube lacks one of its eight parts: three reflex edges meet in a corner, and three faces have a
 * reflex corner in their plane. */
static void test_reflex(void **state) {
    (void)state;
    shape s = {0};
    static const double grid[3] = {0, 1, 2};
    uint32_t v[27];
    for (int i = 0; i < 27; ++i) v[i] = shape_vertex(&s, grid[i % 3], grid[i / 3 % 3], grid[i / 9]);
    for (int axis = 0; axis < 3; ++axis) {
        int step[3] = {axis == 0   ? 1
                       : axis == 1 ? 3
                                   : 9,
                       axis == 0   ? 3
                       : axis == 1 ? 9
                                   : 1,
                       axis == 0   ? 9
                       : axis == 1 ? 1
                                   : 3};
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < 2; ++k) {
                int cell = i * step[1] + k * step[2], missing = i == 1 && k == 1;
                uint32_t a = v[cell], b = v[cell + step[1]], c = v[cell + step[1] + step[2]];
                uint32_t d = v[cell + step[2]];
                shape_quad(&s, a, d, c, b); /* the near side, which faces back */
                int far = (missing ? 1 : 2) * step[0];
                shape_quad(&s, v[cell + far], v[cell + step[1] + far],
                           v[cell + step[1] + step[2] + far], v[cell + step[2] + far]);
            }
    }
    extreme e = extreme_right("reflex corner", &s, 0.5);
    /* three squares, three L shapes of two splats each, and three sides */
    assert_true(e.splats.count <= 15);
    extreme_free(&e);
}

/* Three ridges and three valleys meet at the tip of a star. */
static void test_star(void **state) {
    (void)state;
    shape s = {0};
    uint32_t tip = shape_vertex(&s, 0, 0, 1.5), ring = 1;
    for (int i = 0; i < 6; ++i) {
        double angle = extreme_pi / 3 * i, radius = i % 2 ? 0.2 : 1;
        shape_vertex(&s, radius * cos(angle), radius * sin(angle), 0);
    }
    shape_fan(&s, tip, ring, 6);
    extreme e = extreme_right("tip of a star", &s, 0.5);
    assert_int_equal(e.report.crease_edges, 6);
    assert_int_equal(e.splats.count, 6);
    extreme_free(&e);
}

/* ---- sizes and places ------------------------------------------------------------------------ */

static void place_bump(double s, double t, double p[3]) {
    p[0] = 1.9 * s, p[1] = 1.3 * t;
    p[2] = 0.23 * sin(4.1 * s + 0.7) * cos(3.3 * t + 0.2) + 0.11 * s * t;
}

/* Returns a bent sheet without symmetries, where rounding would have to choose between equals. Its
 * coordinates have 28 bits behind the point, so that an offset of 2^23 does not change them. */
static shape make_sheet(double scale, double offset) {
    shape s = {0};
    shape_grid(&s, 23, 17, place_bump);
    for (size_t i = 0; i < s.vertex_count; ++i)
        for (int k = 0; k < 3; ++k)
            s.vertices[i][k] = floor(s.vertices[i][k] * 0x1p28) * 0x1p-28 * scale + offset;
    return s;
}

/* Asserts that the splats are the same, in the same order, but for scale and offset. */
static void check_scaled(const char *name, const extreme *e, const extreme *first, double scale,
                         double offset) {
    double size = first->report.diagonal * scale, most = 0;
    assert_int_equal(e->splats.count, first->splats.count);
    for (size_t i = 0; i < e->splats.count; ++i) {
        const psplat_region *r = &e->regions[i], *q = &first->regions[i];
        assert_int_equal(r->line_count, q->line_count);
        for (int k = 0; k < 3; ++k) {
            most = max2(most, fabs(r->center[k] - q->center[k] * scale) / size);
            most = max2(most, fabs(r->n[k] - q->n[k]));
            assert_near(e->mesh.origin[k], first->mesh.origin[k] * scale + offset, 1e-8 * size);
        }
        for (int k = 0; k < 2; ++k)
            most = max2(most, fabs(r->radius[k] - q->radius[k] * scale) / size);
    }
    extreme_at_most(name, most, "of the size, the splats differ", 1e-5);
}

/* After scaling by powers of two, or moving by 2^23 sizes, all numbers differ in their exponents
 * only, and so do the splats. Other scales round, which may decide between splats of equal value.
 */
static void test_scales(void **state) {
    (void)state;
    static const struct {
        const char *name;
        double scale, offset;
        int exact;
    } cases[] = {{"an open sheet", 1, 0, 1},
                 {"scaled by 2^-30", 0x1p-30, 0, 1},
                 {"scaled by 2^30", 0x1p30, 0, 1},
                 {"moved by 2^23", 1, 0x1p23, 1},
                 {"scaled by 1e-9", 1e-9, 0, 0},
                 {"scaled by 1e9", 1e9, 0, 0},
                 {"scaled by 2^-30, moved by 2^-7", 0x1p-30, 0x1p-7, 1}};
    extreme first = {0};
    double first_count = 1;
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        shape s = make_sheet(cases[c].scale, cases[c].offset);
        extreme e = extreme_right(cases[c].name, &s, 2);
        if (c == 0) {
            first = e;
            first_count = (double)e.splats.count;
            continue;
        }
        if (cases[c].exact)
            check_scaled(cases[c].name, &e, &first, cases[c].scale, cases[c].offset);
        else
            extreme_at_most(cases[c].name, fabs((double)e.splats.count / first_count - 1),
                            "of the splats more or fewer, or two", max2(0.1, 2 / first_count));
        extreme_free(&e);
    }
    extreme_free(&first);
}

int test_extreme_shapes_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_three_sheets), cmocka_unit_test(test_bowtie),
        cmocka_unit_test(test_duplicates),   cmocka_unit_test(test_flipped),
        cmocka_unit_test(test_intersecting), cmocka_unit_test(test_shells),
        cmocka_unit_test(test_triangle),     cmocka_unit_test(test_tetrahedron),
        cmocka_unit_test(test_reflex),       cmocka_unit_test(test_star),
        cmocka_unit_test(test_scales),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

/* SPDX-License-Identifier: MIT
 *
 * test_points_to_mesh.c - tests of reconstructing a mesh from points, and of converting it to
 * splats. Point sets are drawn from known surfaces (spheres, sheets, a cube, a quadric), so that
 * triangle counts, areas and normals are known. The mesh goes through every point.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "features/surface_build.h"
#include "base/random.h"
#include "base/region.h"
#include "base/vector.h"
#include "features/surface.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "points/points.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

/* A point set under construction, with room for `capacity` points. */
typedef struct cloud {
    psplat_points points;
    size_t capacity;
} cloud;

static void add(cloud *c, const double p[3], const double n[3]) {
    psplat_points *s = &c->points;
    if (s->count == c->capacity) {
        c->capacity = 2 * c->capacity + 1024;
        s->positions = realloc(s->positions, c->capacity * 3 * sizeof(double));
        s->normals = realloc(s->normals, c->capacity * 3 * sizeof(float));
        assert_non_null(s->positions);
        assert_non_null(s->normals);
    }
    memcpy(s->positions + 3 * s->count, p, 3 * sizeof(double));
    for (size_t k = 0; k < 3; ++k) s->normals[3 * s->count + k] = (float)n[k];
    ++s->count;
}

static void drop_normals(cloud *c) {
    free(c->points.normals);
    c->points.normals = NULL;
}

static void random_direction(uint64_t *random, double n[3]) {
    double length;
    do {
        for (int k = 0; k < 3; ++k) n[k] = 2 * psplat_random_unit(random) - 1;
        length = length3(n);
    } while (length > 1 || length < 0.01);
    normalize3(n);
}

/* Returns random points of the unit sphere, except those above z = top. */
static cloud make_sphere(size_t count, double top) {
    cloud c = {0};
    uint64_t random = 7;
    while (c.points.count < count) {
        double n[3];
        random_direction(&random, n);
        if (n[2] <= top) add(&c, n, n);
    }
    return c;
}

static psplat_mesh connect(const cloud *c) {
    psplat_mesh mesh;
    psplat_error error;
    if (psplat_mesh_from_points(&c->points, &mesh, &error)) fail_msg("%s", error.text);
    assert_int_equal(mesh.point_count, c->points.count);
    return mesh;
}

static size_t border_edges(const psplat_mesh *mesh) {
    size_t borders;
    uint32_t *pairs = malloc(3 * mesh->triangle_count * sizeof *pairs);
    assert_non_null(pairs);
    assert_int_equal(psplat_edge_pairs(mesh, pairs, &borders), PSPLAT_OK);
    free(pairs);
    return borders;
}

/* Counts border edges whose two ends lie within `half` of the centre in x and y. */
static size_t inner_borders(const psplat_mesh *mesh, double half) {
    size_t borders, inner = 0, edges = 3 * mesh->triangle_count;
    uint32_t *pairs = malloc(edges * sizeof *pairs);
    assert_non_null(pairs);
    assert_int_equal(psplat_edge_pairs(mesh, pairs, &borders), PSPLAT_OK);
    for (size_t e = 0; e < edges; ++e) {
        const double *a = mesh->positions + 3 * (size_t)mesh->triangles[e];
        const double *b = mesh->positions + 3 * (size_t)mesh->triangles[e % 3 == 2 ? e - 2 : e + 1];
        double reach = max2(max2(fabs(a[0]), fabs(a[1])), max2(fabs(b[0]), fabs(b[1])));
        inner += pairs[e] == PSPLAT_NONE && reach < half;
    }
    free(pairs);
    return inner;
}

static const double *corner(const psplat_mesh *mesh, size_t triangle, size_t k) {
    return mesh->positions + 3 * (size_t)mesh->triangles[3 * triangle + k];
}

static void face_normal(const psplat_mesh *mesh, size_t triangle, double n[3]) {
    double a[3], b[3];
    sub3(a, corner(mesh, triangle, 1), corner(mesh, triangle, 0));
    sub3(b, corner(mesh, triangle, 2), corner(mesh, triangle, 0));
    cross3(n, a, b);
    normalize3(n);
}

/* Asserts that every point is a corner of the triangle to which it belongs, so that none was moved
 * or lost. */
static void check_points(const cloud *c, const psplat_mesh *mesh, double tolerance) {
    for (size_t i = 0; i < mesh->point_count; ++i) {
        double least = HUGE_VAL;
        assert_true(mesh->point_triangles[i] < mesh->triangle_count);
        for (size_t k = 0; k < 3; ++k) {
            double d[3];
            sub3(d, corner(mesh, mesh->point_triangles[i], k), c->points.positions + 3 * i);
            mad3(d, 1, mesh->origin);
            least = min2(least, length3(d));
        }
        assert_near(least, 0, tolerance);
    }
}

/* Points of a sphere give a closed mesh through every point that faces outwards, whether normals
 * point outwards, inwards, either way, or are missing. */
static void test_sphere(void **state) {
    (void)state;
    enum { OUTWARDS, INWARDS, MIXED, NONE };
    for (int normals = OUTWARDS; normals <= NONE; ++normals) {
        cloud c = make_sphere(2000, 1);
        uint64_t random = 3;
        for (size_t i = 0; i < c.points.count; ++i) {
            int turned =
                normals == INWARDS || (normals == MIXED && (psplat_random_next(&random) & 1));
            for (size_t k = 0; k < 3 && turned; ++k)
                c.points.normals[3 * i + k] = -c.points.normals[3 * i + k];
        }
        if (normals == NONE) drop_normals(&c);
        psplat_mesh mesh = connect(&c);
        double side = normals == INWARDS ? -1 : 1;
        /* Euler's formula for genus 0 */
        assert_int_equal(mesh.triangle_count, 2 * c.points.count - 4);
        assert_int_equal(border_edges(&mesh), 0);
        assert_int_equal(mesh.material.double_sided, 0);
        check_points(&c, &mesh, 1e-15);
        for (size_t t = 0; t < mesh.triangle_count; ++t) {
            double n[3], out[3];
            face_normal(&mesh, t, n);
            memcpy(out, corner(&mesh, t, 0), sizeof out);
            mad3(out, 1, mesh.origin);
            assert_true(side * dot3(n, out) > 0);
            for (size_t k = 0; k < 3; ++k) {
                memcpy(out, corner(&mesh, t, k), sizeof out);
                mad3(out, 1, mesh.origin);
                /* estimated normals, or the given floats */
                double tolerance = normals == NONE ? 0.01 : 1e-6;
                for (size_t a = 0; a < 3; ++a)
                    assert_near((double)mesh.corner_normals[9 * t + 3 * k + a], side * out[a],
                                tolerance);
            }
        }
        psplat_mesh_free(&mesh);
        psplat_points_free(&c.points);
    }
}

/* Point sets of extreme size or place give the same triangles. */
static void test_scale(void **state) {
    (void)state;
    static const struct {
        double scale, offset;
    } cases[] = {{1, 0}, {1e-9, 0}, {1e9, 0}, {1e-30, 0}, {1e30, 0}, {1, 1e7}, {1e-9, 1e-2}};
    psplat_mesh first = {0};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        cloud c = make_sphere(500, 1);
        for (size_t k = 0; k < 3 * c.points.count; ++k) {
            /* Offsets round the coordinates to 2^-29 of the radius; all cases are rounded alike. */
            double rounded = (c.points.positions[k] + 0x1p24) - 0x1p24;
            c.points.positions[k] = rounded * cases[i].scale + cases[i].offset;
        }
        psplat_mesh mesh = connect(&c);
        if (i == 0) {
            first = mesh;
        } else {
            assert_int_equal(mesh.triangle_count, first.triangle_count);
            if (cases[i].offset == 0)
                assert_memory_equal(mesh.triangles, first.triangles,
                                    3 * first.triangle_count * sizeof(uint32_t));
            for (size_t k = 0; k < 3; ++k)
                assert_near(mesh.origin[k], first.origin[k] * cases[i].scale + cases[i].offset,
                            1e-6 * cases[i].scale + 1e-9 * cases[i].offset);
            psplat_mesh_free(&mesh);
        }
        psplat_points_free(&c.points);
    }
    psplat_mesh_free(&first);
}

static double area_of(const psplat_mesh *mesh) {
    double sum = 0;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        double a[3], b[3], n[3];
        sub3(a, corner(mesh, t, 1), corner(mesh, t, 0));
        sub3(b, corner(mesh, t, 2), corner(mesh, t, 0));
        cross3(n, a, b);
        sum += length3(n) / 2;
    }
    return sum;
}

/* A gap wider than four times the spacing stays a hole, and no other hole appears. */
static void test_hole(void **state) {
    (void)state;
    cloud c = make_sphere(3000, 0.9); /* The hole is 0.87 wide; the spacing is 0.06. */
    psplat_mesh mesh = connect(&c);
    /* There is one rim, with about as many edges as spacings fit around it. */
    size_t borders = border_edges(&mesh);
    assert_in_range(borders, 20, 80);
    assert_near(area_of(&mesh), 4 * fixture_pi * 0.95, 0.02 * 4 * fixture_pi);
    assert_int_equal(mesh.material.double_sided, 1);
    check_points(&c, &mesh, 1e-15);
    psplat_mesh_free(&mesh);
    psplat_points_free(&c.points);
}

/* Points on one face in two densities, ten times apart by area, give one sheet without gaps. */
static void test_densities(void **state) {
    (void)state;
    cloud c = {0};
    uint64_t random = 5;
    static const double up[3] = {0, 0, 1};
    for (size_t i = 0; i < 6000; ++i) {
        double p[3] = {psplat_random_unit(&random), psplat_random_unit(&random), 0};
        if (p[0] < 0.5 || i % 10 == 0) add(&c, p, up);
    }
    psplat_mesh mesh = connect(&c);
    assert_near(area_of(&mesh), 1, 0.06); /* No point lies exactly on the rim. */
    assert_int_equal(inner_borders(&mesh, 0.35), 0);
    psplat_mesh_free(&mesh);
    psplat_points_free(&c.points);
}

/* Points lie off the sphere by a third of their spacing. They still give one closed, smooth surface
 * that faces outwards, with better normals than those of its triangles; each point belongs to a
 * triangle nearby. */
static void test_noise(void **state) {
    (void)state;
    cloud c = make_sphere(3000, 1);
    uint64_t random = 11;
    double spacing = sqrt(4 * fixture_pi / 3000);
    for (size_t i = 0; i < c.points.count; ++i) {
        double noise = -6; /* the sum of twelve uniform numbers is about normally distributed */
        for (int k = 0; k < 12; ++k) noise += psplat_random_unit(&random);
        for (size_t k = 0; k < 3; ++k) c.points.positions[3 * i + k] *= 1 + 0.3 * spacing * noise;
    }
    drop_normals(&c);
    psplat_mesh mesh = connect(&c);
    double squares = 0;
    assert_int_equal(border_edges(&mesh), 0);
    for (size_t t = 0; t < mesh.triangle_count; ++t) {
        double n[3], p[3];
        face_normal(&mesh, t, n);
        for (size_t k = 0; k < 3; ++k) {
            memcpy(p, corner(&mesh, t, k), sizeof p);
            mad3(p, 1, mesh.origin);
            assert_near(normalize3(p), 1, 0.3 * spacing); /* points are up to 4 times as far */
            assert_true(dot3(n, p) > 0.7);
            double cosine = 0;
            for (size_t a = 0; a < 3; ++a)
                cosine += (double)mesh.corner_normals[9 * t + 3 * k + a] * p[a];
            squares += 2 * (1 - cosine);
        }
    }
    double rms = sqrt(squares / (3 * (double)mesh.triangle_count));
    /* Noise alone turns faces by 0.3 spacings over a spacing, 17 degrees. */
    assert_true(rms < 3 * fixture_pi / 180);
    for (size_t i = 0; i < mesh.point_count; ++i) {
        double d[3];
        sub3(d, corner(&mesh, mesh.point_triangles[i], 0), mesh.points + 3 * i);
        assert_true(length3(d) < 4 * spacing);
    }
    psplat_mesh_free(&mesh);
    psplat_points_free(&c.points);
}

/* The points lie on a grid on a cube. Those on its edges have the normal of one face, if any. Every
 * edge is found, and normals up to the edges are those of the faces. */
static void test_cube(void **state) {
    (void)state;
    enum { STEPS = 16 };
    for (int normals = 0; normals < 2; ++normals) {
        cloud c = {0};
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < 2 * (STEPS + 1) * (STEPS + 1); ++i) {
                double p[3], n[3] = {0, 0, 0};
                p[axis] = n[axis] = i % 2 ? 1 : -1;
                p[(axis + 1) % 3] = 2.0 * (i / 2 % (STEPS + 1)) / STEPS - 1;
                p[(axis + 2) % 3] = 2.0 * (i / 2 / (STEPS + 1)) / STEPS - 1;
                add(&c, p, n);
            }
        if (!normals) drop_normals(&c);
        psplat_mesh mesh = connect(&c);
        psplat_surface surface;
        assert_int_equal(psplat_surface_build(&mesh, fixture_crease_angle, &surface, NULL),
                         PSPLAT_OK);
        assert_int_equal(surface.patch_count, 6);
        assert_int_equal(surface.crease_edges, 12 * STEPS);
        assert_int_equal(surface.border_edges, 0);
        for (size_t i = 0; i < 9 * mesh.triangle_count; ++i)
            assert_near((double)surface.corner_normals[i],
                        surface.face_normals[3 * (i / 9) + i % 3], 1e-3);
        psplat_surface_free(&surface);
        psplat_mesh_free(&mesh);
        psplat_points_free(&c.points);
    }
}

/* Estimated normals are exact where the surface is a quadric, at its rim too. */
static void test_estimated(void **state) {
    (void)state;
    cloud c = {0};
    uint64_t random = 13;
    static const double none[3] = {0, 0, 0};
    for (size_t i = 0; i < 2000; ++i) {
        double x = 2 * psplat_random_unit(&random) - 1, y = 2 * psplat_random_unit(&random) - 1;
        double p[3] = {x, y, 0.3 * x * x - 0.2 * x * y + 0.1 * y};
        add(&c, p, none);
    }
    drop_normals(&c);
    psplat_mesh mesh = connect(&c);
    size_t off = 0;
    for (size_t i = 0; i < 3 * mesh.triangle_count; ++i) {
        const double *p = mesh.positions + 3 * (size_t)mesh.triangles[i];
        double x = p[0] + mesh.origin[0], y = p[1] + mesh.origin[1], cosine = 0;
        double n[3] = {-0.6 * x + 0.2 * y, 0.2 * x - 0.1, 1};
        normalize3(n);
        for (size_t k = 0; k < 3; ++k) cosine += (double)mesh.corner_normals[3 * i + k] * n[k];
        assert_true(fabs(cosine) > cos(2 * fixture_pi / 180));
        off += fabs(cosine) < cos(0.2 * fixture_pi / 180);
    }
    assert_true(off * 20 < mesh.triangle_count);
    psplat_mesh_free(&mesh);
    psplat_points_free(&c.points);
}

/* Repeated points, exactly equal or different in the last digit of a float, become one vertex, but
 * all of them stay points. */
static void test_duplicates(void **state) {
    (void)state;
    cloud c = make_sphere(1000, 1);
    for (size_t i = 0; i < 500; ++i) {
        double p[3], n[3];
        for (size_t k = 0; k < 3; ++k) {
            n[k] = (double)c.points.normals[3 * i + k];
            p[k] = c.points.positions[3 * i + k] * (i % 2 ? 1 : 1 + 1e-8);
        }
        add(&c, p, n);
    }
    psplat_mesh mesh = connect(&c);
    assert_int_equal(mesh.vertex_count, 1000);
    assert_int_equal(mesh.triangle_count, 1996);
    check_points(&c, &mesh, 2e-8);
    psplat_mesh_free(&mesh);
    psplat_points_free(&c.points);
}

/* The two sides of a plate, a third as thick as its points are apart, stay separate: they give two
 * sheets that face opposite ways. */
static void test_sheets(void **state) {
    (void)state;
    cloud c = {0};
    uint64_t random = 9;
    for (size_t i = 0; i < 4000; ++i) {
        double z = i % 2 ? 1 : -1, n[3] = {0, 0, z};
        double p[3] = {psplat_random_unit(&random), psplat_random_unit(&random), 0.0035 * z};
        add(&c, p, n);
    }
    psplat_mesh mesh = connect(&c);
    size_t mixed = 0, folded = 0;
    double area[2] = {0, 0};
    for (size_t t = 0; t < mesh.triangle_count; ++t) {
        double a[3], b[3], n[3], z[3];
        sub3(a, corner(&mesh, t, 1), corner(&mesh, t, 0));
        sub3(b, corner(&mesh, t, 2), corner(&mesh, t, 0));
        cross3(n, a, b);
        for (size_t k = 0; k < 3; ++k) z[k] = corner(&mesh, t, k)[2];
        if (z[0] != z[1] || z[1] != z[2]) {
            ++mixed;
            continue;
        }
        folded += n[2] * z[0] <= 0;
        area[z[0] > 0] += length3(n) / 2;
    }
    assert_near(area[0], 1, 0.06); /* No point lies exactly on the rim. */
    assert_near(area[1], 1, 0.06);
    assert_int_equal(mixed, 0);
    assert_int_equal(folded, 0);
    psplat_mesh_free(&mesh);
    psplat_points_free(&c.points);
}

/* Points that no surface reaches get a small surface of their own, in the plane of their normal. */
static void test_alone(void **state) {
    (void)state;
    cloud c = {0};
    static const double line[4][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 0, 0}};
    static const double up[3] = {0, 0, 2};
    for (size_t i = 0; i < 4; ++i) add(&c, line[i], up);
    psplat_mesh mesh = connect(&c);
    assert_int_equal(mesh.triangle_count, 12);
    check_points(&c, &mesh, 1e-15);
    for (size_t t = 0; t < 12; ++t) {
        double n[3];
        face_normal(&mesh, t, n);
        assert_near(n[2], 1, 1e-15);
    }
    psplat_mesh_free(&mesh);
    psplat_points_free(&c.points);
}

static void test_refused(void **state) {
    (void)state;
    psplat_mesh mesh;
    psplat_error error;
    double positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    psplat_points points = {.positions = positions, .count = 0};
    assert_int_equal(psplat_mesh_from_points(&points, &mesh, &error), PSPLAT_ERROR_NO_SPLATS);
    assert_string_equal(error.text, "no points");
    points.count = 2;
    assert_int_equal(psplat_mesh_from_points(&points, &mesh, &error), PSPLAT_ERROR_NO_SPLATS);
    assert_null(mesh.positions);
    points.count = 3;
    assert_int_equal(psplat_mesh_from_points(&points, &mesh, &error), PSPLAT_OK);
    assert_int_equal(mesh.triangle_count, 1);
    psplat_mesh_free(&mesh);
    positions[4] = NAN;
    assert_int_equal(psplat_mesh_from_points(&points, &mesh, &error), PSPLAT_ERROR_RANGE);
    assert_string_equal(error.text, "point 1: a coordinate is not finite");
}

/* Points deviate from a line by so little that the square of it is 0: no surface is found, and no
 * other failure occurs. */
static void test_nearly_on_a_line(void **state) {
    (void)state;
    psplat_mesh mesh;
    psplat_error error;
    double positions[12] = {1e-321, 0, 0, 3e-5, 0, 8.207e-304, 1, 0, 8.208e-304, 1e-289, 2e-307, 0};
    psplat_points points = {.positions = positions, .count = 4};
    assert_int_equal(psplat_mesh_from_points(&points, &mesh, &error), PSPLAT_ERROR_NO_SPLATS);
}

/* ---- conversion ----------------------------------------------------------------------------- */

static psplat_splats convert(const psplat_mesh *mesh, double percent, psplat_report *report) {
    psplat_splats splats;
    psplat_error error;
    psplat_convert_desc desc = {.tolerance_percent = percent};
    if (psplat_convert(mesh, &desc, &splats, report, &error)) fail_msg("%s", error.text);
    return splats;
}

/* Returns whether some splat that faces along n covers p within the tolerance. */
static int is_covered(const psplat_region *regions, size_t count, const double p[3],
                      const double n[3], double tolerance) {
    for (size_t i = 0; i < count; ++i) {
        double uvh[3];
        psplat_region_local(&regions[i], p, uvh);
        if (fabs(uvh[2]) <= tolerance && dot3(regions[i].n, n) > 0 &&
            psplat_region_contains(&regions[i], uvh, 1 + 1e-6, 1e-6))
            return 1;
    }
    return 0;
}

/* Splats cover every point of the set, and none reaches into its hole farther than the points
 * around it are apart. */
static void test_converted(void **state) {
    (void)state;
    for (int normals = 0; normals < 2; ++normals) {
        cloud c = make_sphere(3000, 0.9);
        double *directions = malloc(c.points.count * 3 * sizeof(double));
        assert_non_null(directions);
        memcpy(directions, c.points.positions, c.points.count * 3 * sizeof(double));
        if (!normals) drop_normals(&c);
        psplat_mesh mesh = connect(&c);
        psplat_report report = {0};
        psplat_splats splats = convert(&mesh, 2, &report);
        psplat_region *regions = psplat_splat_regions(&splats);
        assert_non_null(regions);
        double tolerance = 0.02 * report.diagonal * (1 + 1e-6);
        for (size_t i = 0; i < mesh.point_count; ++i)
            assert_true(is_covered(regions, splats.count, mesh.points + 3 * i, directions + 3 * i,
                                   tolerance));
        /* The hole is a cap of 26 degrees around the pole. */
        uint64_t random = 1;
        for (size_t i = 0; i < 1000; ++i) {
            double n[3], p[3];
            random_direction(&random, n);
            if (n[2] < cos(0.3)) continue; /* 17 degrees: inside the hole, 0.15 from its rim */
            sub3(p, n, mesh.origin);
            assert_false(is_covered(regions, splats.count, p, n, tolerance));
        }
        assert_int_equal(report.uncovered_samples, 0);
        assert_true(report.max_distance_percent <= 2);
        print_message("%zu splats, rms normal %.2f degrees\n", splats.count,
                      report.rms_normal_degrees);
        free(directions);
        free(regions);
        psplat_splats_free(&splats);
        psplat_mesh_free(&mesh);
        psplat_points_free(&c.points);
    }
}

/* Points of a line belong to a triangle beside its end, and lie farther from it than a splat
 * reaches. The cover of such points took seed after seed, without end. */
static void test_line_beside_triangle(void **state) {
    (void)state;
    cloud c = {0};
    psplat_report report = {0};
    const double up[3] = {0, 0, 1};
    for (int i = 0; i < 10; ++i) {
        const double p[3] = {0.073 * i, 0, 0};
        add(&c, p, up);
    }
    for (int i = 0; i < 2; ++i) {
        const double p[3] = {0.676 + 0.074 * i, -0.073, 0.2};
        add(&c, p, up);
    }
    free(c.points.normals);
    c.points.normals = NULL;
    psplat_mesh mesh = connect(&c);
    psplat_splats splats = convert(&mesh, 0.5, &report);
    assert_true(splats.count > 0 && splats.count <= 2 * c.points.count);
    assert_int_equal(report.uncovered_samples, 0);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
    psplat_points_free(&c.points);
}

/* The same points give the same bytes. */
static void test_repeated(void **state) {
    (void)state;
    cloud c = make_sphere(1500, 1);
    psplat_mesh a = connect(&c), b = connect(&c);
    assert_int_equal(a.triangle_count, b.triangle_count);
    assert_memory_equal(a.triangles, b.triangles, 3 * a.triangle_count * sizeof(uint32_t));
    assert_memory_equal(a.positions, b.positions, 3 * a.vertex_count * sizeof(double));
    assert_memory_equal(a.point_triangles, b.point_triangles, a.point_count * sizeof(uint32_t));
    psplat_mesh_free(&a);
    psplat_mesh_free(&b);
    psplat_points_free(&c.points);
}

int test_points_to_mesh_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_scale),
        cmocka_unit_test(test_hole),
        cmocka_unit_test(test_noise),
        cmocka_unit_test(test_estimated),
        cmocka_unit_test(test_cube),
        cmocka_unit_test(test_densities),
        cmocka_unit_test(test_duplicates),
        cmocka_unit_test(test_sheets),
        cmocka_unit_test(test_alone),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_converted),
        cmocka_unit_test(test_repeated),
        cmocka_unit_test(test_nearly_on_a_line),
        cmocka_unit_test(test_line_beside_triangle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

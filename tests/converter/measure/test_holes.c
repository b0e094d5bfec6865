/* SPDX-License-Identifier: MIT
 *
 * test_holes.c - tests of finding holes between splats. Shapes are flat meshes covered by discs
 * that leave holes of known place and width; every hole must be found, and every point found must
 * be open.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "base/random.h"
#include "base/region.h"
#include "base/vector.h"
#include "fit/candidate.h"
#include "measure/holes.h"
#include "measure/measured_splats.h"
#include "select/selection.h"
#include "select/sort_splats.h"
#include "splats/splats.h"

static const double tolerance = 0.05;

/* A flat mesh, turned and moved, and discs in its plane; (x, y) are coordinates in that plane. */
typedef struct scene {
    fixture f;
    double origin[3], x[3], y[3], n[3];
    psplat_selection discs;
    psplat_splats splats;
    psplat_measured_splats measured;
    psplat_holes holes;
} scene;

static double width, height; /* size of the mesh, whose centre is the origin */
static void place_level(double s, double t, double p[3]) {
    p[0] = width * (s - 0.5), p[1] = height * (t - 0.5), p[2] = 0;
}

/* Begins a scene; random NULL leaves it unturned. */
static void scene_begin(scene *s, double w, double h, uint32_t columns, uint32_t rows,
                        uint64_t *random) {
    *s = (scene){.x = {1, 0, 0}, .y = {0, 1, 0}, .n = {0, 0, 1}};
    width = w, height = h;
    fixture_grid(&s->f, columns, rows, place_level);
    if (random) {
        random_axes(random, s->x, s->y, s->n);
        for (int k = 0; k < 3; ++k) s->origin[k] = 2 * psplat_random_unit(random) - 1;
    }
    for (size_t i = 0; i < s->f.mesh.vertex_count; ++i) {
        double *p = s->f.mesh.positions + 3 * i, a = p[0], b = p[1];
        memcpy(p, s->origin, sizeof s->origin);
        mad3(p, a, s->x);
        mad3(p, b, s->y);
    }
    fixture_build(&s->f);
}

static void scene_end(scene *s) {
    psplat_holes_free(&s->holes);
    psplat_measured_splats_free(&s->measured);
    psplat_splats_free(&s->splats);
    psplat_selection_free(&s->discs);
    fixture_free(&s->f);
}

/* Adds a disc whose u axis is turned by an angle, and that faces up (side 1) or down (-1). */
static psplat_region *add_disc(scene *s, double a, double b, double radius, double angle,
                               int side) {
    psplat_candidate c = {.taken = 1, .color = {1, 1, 1, 1}, .region.radius = {radius, radius}};
    psplat_region *r = &c.region;
    memcpy(r->center, s->origin, sizeof s->origin);
    mad3(r->center, a, s->x);
    mad3(r->center, b, s->y);
    mad3(r->u, cos(angle), s->x);
    mad3(r->u, sin(angle), s->y);
    mad3(r->n, side, s->n);
    cross3(r->v, r->n, r->u);
    assert_int_equal(psplat_selection_push(&s->discs, &c), 1);
    return &s->discs.candidates[s->discs.count - 1].region;
}

/* Returns whether no splat covers a point with the normal of the mesh; it asks all splats. */
static int is_open(const scene *s, const double p[3]) {
    for (uint32_t i = 0; i < s->splats.count; ++i) {
        double uvh[3];
        psplat_region_local(&s->measured.regions[i], p, uvh);
        if (psplat_measured_splats_cover(&s->measured, i, s->n, uvh)) return 0;
    }
    return 1;
}

/* Finds the holes, and asserts that each is open and lies on its triangle, and that they are
 * ordered by triangles. */
static size_t find(scene *s, double coarse, double fine) {
    psplat_holes_free(&s->holes);
    psplat_measured_splats_free(&s->measured);
    assert_int_equal(psplat_sort_splats(&s->discs, &(psplat_sort_desc){0}, &s->splats), PSPLAT_OK);
    assert_int_equal(psplat_measured_splats_create(&s->splats, tolerance, tolerance, &s->measured),
                     PSPLAT_OK);
    assert_int_equal(psplat_holes_find(&s->f.surface, &s->measured, coarse, fine, &s->holes),
                     PSPLAT_OK);
    for (size_t i = 0; i < s->holes.count && !s->f.mesh.point_count; ++i) {
        const double *p = s->holes.points + 3 * i;
        const uint32_t *t = s->f.mesh.triangles + 3 * (size_t)s->holes.triangles[i];
        const double *at = s->f.mesh.positions;
        assert_true(is_open(s, p));
        /* rounding of coordinates of 4 */
        assert_near(point_triangle_distance2(p, at + 3 * (size_t)t[0], at + 3 * (size_t)t[1],
                                             at + 3 * (size_t)t[2]),
                    0, 1e-28);
        assert_true(!i || s->holes.triangles[i] >= s->holes.triangles[i - 1]);
    }
    return s->holes.count;
}

/* Stores a hole's coordinates in the plane of the mesh. */
static void local_hole(const scene *s, size_t i, double xy[2]) {
    double d[3];
    sub3(d, s->holes.points + 3 * i, s->origin);
    xy[0] = dot3(d, s->x), xy[1] = dot3(d, s->y);
}

/* ---- covered --------------------------------------------------------------------------------- */

/* A square lies under one disc, then under a disc that lines cut to the square itself, then under a
 * disc that is a little too small for its corners. */
static void test_square(void **state) {
    (void)state;
    uint64_t random = 3;
    for (uint32_t turn = 0; turn < 10; ++turn) {
        scene s;
        scene_begin(&s, 4, 4, 1 + turn % 3, 1 + turn % 2, &random);
        add_disc(&s, 0, 0, sqrt(8) * 1.00001, 0.3 * turn, 1);
        assert_int_equal(find(&s, 0.2, 0.001), 0);
        scene_end(&s);
        scene_begin(&s, 4, 4, 1 + turn % 3, 1 + turn % 2, &random);
        psplat_region *r = add_disc(&s, 0, 0, 3, 0, 1);
        r->line_count = 4;
        for (int i = 0; i < 4; ++i) {
            r->lines[i][i / 2] = i % 2 ? 1 : -1;
            r->lines[i][2] = 2.0 / 3;
        }
        assert_int_equal(find(&s, 0.2, 0.001), 0);
        scene_end(&s);
        scene_begin(&s, 4, 4, 1, 1, &random);
        add_disc(&s, 0, 0, sqrt(8) - 0.05, 0, 1); /* leaves corners 0.05 high */
        int corners = 0;
        assert_true(find(&s, 0.2, 0.005) >= 4);
        for (size_t i = 0; i < s.holes.count; ++i) {
            double xy[2];
            local_hole(&s, i, xy);
            assert_true(hypot(xy[0], xy[1]) > sqrt(8) - 0.05);
            corners |= 1 << ((xy[0] > 0) + 2 * (xy[1] > 0));
        }
        assert_int_equal(corners, 15);
        scene_end(&s);
    }
}

/* A splat of the other side covers nothing, nor does one that is farther away than the tolerance.
 */
static void test_sides(void **state) {
    (void)state;
    scene s;
    scene_begin(&s, 2, 2, 1, 1, NULL);
    add_disc(&s, 0, 0, 3, 0, -1);
    size_t open = find(&s, 0.1, 0.01);
    assert_true((double)open >= 4 / (0.1 * 0.1)); /* one in each cube that the square meets */
    psplat_region *r = add_disc(&s, 0, 0, 3, 0, 1);
    r->center[2] = 1.01 * tolerance;
    assert_int_equal(find(&s, 0.1, 0.01), open);
    s.discs.candidates[1].region.center[2] = 0.99 * tolerance;
    assert_int_equal(find(&s, 0.1, 0.01), 0);
    scene_end(&s);
}

/* A square faces up, but the normals of one of its corners down, as where a surface is folded:
 * where they cancel each other, the triangle's own normal counts, and one of two splats that face
 * either way covers that, too. */
static void test_no_normal(void **state) {
    (void)state;
    scene s;
    scene_begin(&s, 2, 2, 1, 1, NULL);
    for (size_t corner = 0; corner < 6; ++corner)
        if (s.f.mesh.triangles[corner] == s.f.mesh.triangles[0])
            s.f.surface.corner_normals[3 * corner + 2] = -1;
    add_disc(&s, 0, 0, 3, 0, 1);
    add_disc(&s, 0, 0, 3, 0, -1);
    assert_int_equal(find(&s, 4, 0.01), 0);
    s.discs.candidates[0].taken = 0;
    assert_true(find(&s, 4, 0.01) > 0);
    scene_end(&s);
}

/* ---- gaps of known width --------------------------------------------------------------------- */

/* Adds two discs that parallel lines cut so that they leave a slit, at an angle and at a distance
 * from the middle. */
static void add_slit(scene *s, double angle, double offset, double gap) {
    for (int side = 0; side < 2; ++side) {
        psplat_region *r = add_disc(s, 0, 0, 4, angle, 1);
        double sign = side ? 1 : -1;
        r->line_count = 1;
        r->lines[0][0] = sign;
        r->lines[0][2] = -(sign * offset + gap / 2) / 4;
    }
}

/* Asserts that each point along the slit is at most a cube's edge from a hole, or a cube's diagonal
 * more where another hole of the same cube was kept. */
static void check_along(const scene *s, double angle, double offset, double coarse) {
    for (double t = -3; t < 3; t += 0.37 * coarse) {
        double x = offset * cos(angle) - t * sin(angle), y = offset * sin(angle) + t * cos(angle);
        double least = HUGE_VAL;
        if (fabs(x) > 2 || fabs(y) > 2) continue;
        for (size_t i = 0; i < s->holes.count; ++i) {
            double xy[2];
            local_hole(s, i, xy);
            least = min2(least, hypot(xy[0] - x, xy[1] - y));
        }
        assert_true(least <= (1 + sqrt(3)) * coarse);
    }
}

/* A triangle part no wider than `fine` around a point of the slit has its middle within two thirds
 * of that, so that a slit of twice `fine` is found in each part of size `coarse`, in any direction.
 * A narrower slit may be missed, but every point found lies in it. */
static void test_slits(void **state) {
    (void)state;
    const double coarse = 0.25, fine = 1.0 / 128;
    const double gaps[] = {4 * fine, 2 * fine, fine / 4};
    uint64_t random = 8;
    for (uint32_t turn = 0; turn < 24; ++turn)
        for (size_t g = 0; g < 3; ++g) {
            scene s;
            double angle = fixture_pi * (turn % 5 ? psplat_random_unit(&random) : turn / 20.0);
            double offset = turn % 4 ? 1.8 * psplat_random_unit(&random) : 0;
            scene_begin(&s, 4, 4, 1 + turn % 4, 1 + turn % 3, &random);
            add_slit(&s, angle, offset, gaps[g]);
            size_t count = find(&s, coarse, fine);
            if (g < 2) assert_true(count > 0);
            for (size_t i = 0; i < count; ++i) {
                double xy[2];
                local_hole(&s, i, xy);
                /* clip lines in floats, for a radius of 4 */
                assert_near(xy[0] * cos(angle) + xy[1] * sin(angle), offset, gaps[g] / 2 + 1e-6);
            }
            if (g < 2) check_along(&s, angle, offset, coarse);
            scene_end(&s);
        }
}

/* Two discs lie side by side over a band: their circles meet at y = +-sqrt(1.2^2 - 1), beyond which
 * the band has a notch on each side. */
static void test_notch(void **state) {
    (void)state;
    const double meet = sqrt(1.2 * 1.2 - 1);
    uint64_t random = 2;
    for (int turn = 0; turn < 10; ++turn)
        for (int open = 0; open < 2; ++open) {
            scene s;
            double half = meet + (open ? 0.05 : -1e-5), widest = 1 - sqrt(1.44 - half * half);
            int sides[2] = {0, 0};
            scene_begin(&s, 3.8, 2 * half, 1, 1, &random);
            for (int k = -1; k <= 1; k += 2) add_disc(&s, k, 0, 1.2, 0.5 * turn, 1);
            size_t count = find(&s, 0.2, 0.01);
            assert_int_equal(count > 0, open);
            for (size_t i = 0; i < count; ++i) {
                double xy[2];
                local_hole(&s, i, xy);
                assert_true(fabs(xy[1]) > meet && fabs(xy[0]) < widest);
                sides[xy[1] > 0] = 1;
            }
            assert_int_equal(sides[0] + sides[1], 2 * open);
            scene_end(&s);
        }
}

/* ---- many splats ----------------------------------------------------------------------------- */

/* Adds a square of some triangles under `across` by `across` overlapping discs, of which every
 * `missing`-th is left out. */
static void add_lattice(scene *s, uint32_t across, uint32_t missing, uint32_t first) {
    double step = 4.0 / across;
    for (uint32_t i = 0; i < across * across; ++i)
        if ((i + missing - first) % missing)
            add_disc(s, step * (i % across + 0.5) - 2, step * (i / across + 0.5) - 2, 0.72 * step,
                     0.1 * i, 1);
}

static void test_one_lost(void **state) {
    (void)state;
    enum { ACROSS = 24, ALL = ACROSS * ACROSS };
    const double step = 4.0 / ACROSS;
    uint64_t random = 21;
    for (int turn = 0; turn < 6; ++turn) {
        uint32_t lost = (uint32_t)(psplat_random_next(&random) % ALL);
        scene s;
        scene_begin(&s, 4, 4, 1, 1, &random);
        add_lattice(&s, ACROSS, ALL, lost);
        assert_int_equal(s.discs.count, ALL - 1);
        size_t count = find(&s, step, step / 32);
        assert_true(count > 0);
        for (size_t i = 0; i < count; ++i) {
            double xy[2];
            local_hole(&s, i, xy);
            double dx = xy[0] - (step * (lost % ACROSS + 0.5) - 2);
            double dy = xy[1] - (step * (lost / ACROSS + 0.5) - 2);
            assert_true(hypot(dx, dy) < 0.72 * step);
        }
        add_disc(&s, step * (lost % ACROSS + 0.5) - 2, step * (lost / ACROSS + 0.5) - 2,
                 0.72 * step, 0, 1);
        assert_int_equal(find(&s, step, step / 32), 0);
        scene_end(&s);
    }
}

/* The holes and their order do not depend on the number of threads. */
static void test_threads(void **state) {
    (void)state;
    uint64_t random = 4;
    scene s;
    scene_begin(&s, 4, 4, 40, 40, &random);
    add_lattice(&s, 24, 5, 2);
    fixture_threads(1);
    assert_true(find(&s, 0.05, 0.005) > 100);
    psplat_holes one = s.holes;
    s.holes = (psplat_holes){0};
    for (int threads = 2; threads <= 5; ++threads) {
        fixture_threads(threads);
        assert_int_equal(find(&s, 0.05, 0.005), one.count);
        assert_memory_equal(s.holes.points, one.points, one.count * 3 * sizeof *one.points);
        assert_memory_equal(s.holes.triangles, one.triangles, one.count * sizeof *one.triangles);
    }
    fixture_threads(0);
    psplat_holes_free(&one);
    scene_end(&s);
}

/* A search that remembers the last one finds what one finds that does not, whatever discs come, go
 * or change. */
static void test_memory(void **state) {
    (void)state;
    enum { TURNS = 60, ACROSS = 12 };
    const double step = 4.0 / ACROSS;
    uint64_t random = 5;
    size_t some = 0, none = 0;
    scene s;
    psplat_hole_memory memory = {0};
    scene_begin(&s, 4, 4, 60, 60, &random);
    add_lattice(&s, ACROSS, ACROSS * ACROSS, 0);
    for (int turn = 0; turn < TURNS; ++turn) {
        psplat_candidate *discs = s.discs.candidates;
        size_t count = find(&s, 0.05, 0.005);
        psplat_holes holes;
        assert_int_equal(
            psplat_holes_find_changed(&s.f.surface, &s.measured, 0.05, 0.005, &memory, &holes),
            PSPLAT_OK);
        assert_int_equal(holes.count, count);
        if (count) {
            assert_memory_equal(holes.points, s.holes.points, count * 3 * sizeof(double));
            assert_memory_equal(holes.triangles, s.holes.triangles, count * sizeof(uint32_t));
        }
        psplat_holes_free(&holes);
        *(count ? &some : &none) += 1;
        size_t at = psplat_random_next(&random) % s.discs.count;
        if (turn % 6 == 5) { /* All come back. */
            while (s.discs.count) psplat_candidate_free(&s.discs.candidates[--s.discs.count]);
            add_lattice(&s, ACROSS, ACROSS * ACROSS, 0);
            add_disc(&s, step / 2 - 2, step / 2 - 2, 0.72 * step, 0, 1); /* which was left out */
        } else if (turn % 2) { /* One becomes smaller, as if it were another. */
            discs[at].region.radius[0] = discs[at].region.radius[1] *= 0.9;
        } else { /* One goes. */
            psplat_candidate_free(&discs[at]);
            discs[at] = discs[--s.discs.count];
        }
    }
    assert_true(some > 10 && none >= TURNS / 6 - 1);
    psplat_hole_memory_free(&memory);
    scene_end(&s);
}

/* ---- point sets ------------------------------------------------------------------------------ */

/* The triangles are covered, and points beside them are open where they are farther away than the
 * tolerance. */
static void test_points(void **state) {
    (void)state;
    enum { POINTS = 600 };
    uint64_t random = 31;
    scene s;
    size_t open = 0;
    scene_begin(&s, 4, 4, 1, 1, &random);
    s.f.mesh.points = malloc(POINTS * 3 * sizeof(double));
    s.f.mesh.point_triangles = calloc(POINTS, sizeof(uint32_t));
    assert_non_null(s.f.mesh.points);
    assert_non_null(s.f.mesh.point_triangles);
    s.f.mesh.point_count = POINTS;
    for (size_t i = 0; i < POINTS; ++i) {
        double *p = s.f.mesh.points + 3 * i, x = 4 * psplat_random_unit(&random) - 2;
        double y = 4 * psplat_random_unit(&random) - 2;
        memcpy(p, s.origin, sizeof s.origin);
        mad3(p, x, s.x);
        mad3(p, y, s.y);
        mad3(p, i % 7 ? (i % 2 ? 0.9 : -0.9) * tolerance : 1.1 * tolerance, s.n);
        s.f.mesh.point_triangles[i] = x < y;
        open += i % 7 == 0;
    }
    add_disc(&s, 0, 0, 3, 0, 1);
    assert_int_equal(find(&s, 1e-9, 0.01), open); /* No two points are in one cube. */
    for (size_t i = 0; i < open; ++i) {
        for (size_t k = 0; k < 3; ++k) /* a mean of three equal values */
            assert_near(s.holes.points[3 * i + k], s.f.mesh.points[21 * i + k], 1e-15);
        assert_int_equal(s.holes.triangles[i], s.f.mesh.point_triangles[7 * i]);
    }
    scene_end(&s);
}

int test_holes_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_square),    cmocka_unit_test(test_sides),
        cmocka_unit_test(test_no_normal), cmocka_unit_test(test_slits),
        cmocka_unit_test(test_notch),     cmocka_unit_test(test_one_lost),
        cmocka_unit_test(test_threads),   cmocka_unit_test(test_points),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_triangle_tree.c - the trees of triangles of fits and of checks against CGAL's and against
 * all triangles, on seeded random meshes of several kinds and at several scales.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "base/random.h"
#include "base/vector.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"
#include "mesh/morton_tree.h"
#include "mesh/triangle_tree.h"

/* How far distances may differ, in parts of the coordinates' size: some roundings, and the height
 * below which a triangle counts as its edges. */
static const double rounding = 1e-13, flat_height = 2e-8;

enum { KINDS = 5, QUERIES = 300 };

/* A mesh with its own arrays, and how large its coordinates are. */
typedef struct scene {
    psplat_mesh mesh;
    double scale, offset;
    uint64_t random;
    uint32_t guess; /* a place near some point asked before; PSPLAT_NONE at first */
} scene;

static double between(uint64_t *random, double low, double high) {
    return low + (high - low) * psplat_random_unit(random);
}

static void set_corner(scene *s, size_t triangle, int corner, const double p[3]) {
    for (int k = 0; k < 3; ++k)
        s->mesh.positions[9 * triangle + 3 * (size_t)corner + (size_t)k] =
            s->offset + s->scale * p[k];
}

/* Small triangles near a wave; large ones anywhere; needles; some that are a point or an edge; and
 * each twice. */
static void place_triangle(scene *s, int kind, size_t triangle) {
    uint64_t *random = &s->random;
    double middle[3], p[3];
    for (int k = 0; k < 3; ++k) middle[k] = between(random, -1, 1);
    if (kind == 0) middle[2] = 0.3 * sin(3 * middle[0]) * cos(2 * middle[1]);
    for (int corner = 0; corner < 3; ++corner) {
        double size = kind == 1 ? 1 : 0.1;
        if (kind == 3 && triangle % 3 == 0) size = 0;
        for (int k = 0; k < 3; ++k) p[k] = middle[k] + size * between(random, -1, 1);
        if (kind == 2) /* a needle along x, a ten thousandth as wide */
            for (int k = 1; k < 3; ++k) p[k] = middle[k] + 1e-5 * between(random, -1, 1);
        if (kind == 3 && triangle % 3 == 1) p[1] = middle[1], p[2] = middle[2];
        set_corner(s, triangle, corner, p);
    }
    if (kind == 4 && triangle % 2)
        memcpy(s->mesh.positions + 9 * triangle, s->mesh.positions + 9 * (triangle - 1),
               9 * sizeof(double));
}

static scene make_scene(int kind, size_t count, double scale, double offset) {
    scene s = {
        .scale = scale, .offset = offset, .random = 7 + (uint64_t)kind, .guess = PSPLAT_NONE};
    s.mesh.triangle_count = count;
    s.mesh.vertex_count = 3 * count;
    s.mesh.positions = malloc(9 * count * sizeof *s.mesh.positions);
    s.mesh.triangles = malloc(3 * count * sizeof *s.mesh.triangles);
    assert_true(s.mesh.positions && s.mesh.triangles);
    for (uint32_t i = 0; i < 3 * count; ++i) s.mesh.triangles[i] = i;
    for (size_t t = 0; t < count; ++t) place_triangle(&s, kind, t);
    return s;
}

static void free_scene(scene *s) {
    free(s->mesh.positions);
    free(s->mesh.triangles);
}

static void random_point(scene *s, double far, double p[3]) {
    for (int k = 0; k < 3; ++k) p[k] = s->offset + s->scale * between(&s->random, -far, far);
}

static double size_of(const scene *s) {
    return s->offset + 10 * s->scale;
}

/* Returns the distance of a point by measuring all triangles. */
static double distance_of_all(const scene *s, const double point[3]) {
    double least = HUGE_VAL;
    for (size_t t = 0; t < s->mesh.triangle_count; ++t) {
        const double *corners = s->mesh.positions + 9 * t;
        least = min2(least, point_triangle_distance2(point, corners, corners + 3, corners + 6));
    }
    return sqrt(least);
}

/* ---- each query ----------------------------------------------------------------------------- */

static void compare_distance(scene *s, const psplat_distance *own, const psplat_distance *cgal,
                             int has_needles) {
    double point[3], there[3], expected, found, another,
        slack = rounding * size_of(s) + flat_height * s->scale;
    uint32_t triangle;
    int within;
    random_point(s, psplat_random_unit(&s->random) < 0.8 ? 1.2 : 9, point);
    expected = distance_of_all(s, point);
    assert_int_equal(psplat_distance_query(own, point, 1, &found), PSPLAT_OK);
    assert_true(fabs(found - expected) <= slack);
    assert_int_equal(psplat_distance_query(cgal, point, 1, &another), PSPLAT_OK);
    assert_true(has_needles || fabs(found - another) <= slack);
    uint32_t none = PSPLAT_NONE, near = s->guess, other;
    double same[3];
    assert_int_equal(psplat_distance_nearest(own, point, &none, there, &triangle), PSPLAT_OK);
    assert_int_equal(psplat_distance_nearest(own, point, &near, same, &other), PSPLAT_OK);
    assert_int_equal(other, triangle);
    assert_memory_equal(same, there, sizeof there);
    assert_true(fabs(sqrt(distance2_3(point, there)) - expected) <= slack);
    const double *corners = s->mesh.positions + 9 * (size_t)triangle;
    double on = sqrt(point_triangle_distance2(there, corners, corners + 3, corners + 6));
    assert_true(on <= slack);
    const double factors[] = {0.5, 0.999, 1.001, 2};
    for (size_t i = 0; i < sizeof factors / sizeof *factors; ++i) {
        double limit = factors[i] * expected;
        if (fabs(limit - expected) <= slack) continue;
        assert_int_equal(psplat_distance_within(own, point, 1, limit, &within), PSPLAT_OK);
        assert_int_equal(within, factors[i] > 1);
        /* What was near the points before is asked first, and changes nothing. */
        assert_int_equal(psplat_distance_is_within(own, point, limit, &s->guess, &within),
                         PSPLAT_OK);
        assert_int_equal(within, factors[i] > 1);
    }
}

/* Both may differ where a segment passes an edge by a few roundings, which random ones do not. */
static int compare_segment(scene *s, const psplat_distance *own, const psplat_distance *cgal) {
    double from[3], to[3];
    int expected, found;
    random_point(s, 1.5, from);
    random_point(s, 1.5, to);
    if (psplat_random_unit(&s->random) < 0.3) to[0] = from[0], to[1] = from[1];
    assert_int_equal(psplat_distance_meets(cgal, from, to, &expected), PSPLAT_OK);
    assert_int_equal(psplat_distance_meets(own, from, to, &found), PSPLAT_OK);
    assert_int_equal(found, expected);
    return found;
}

/* The triangles that a visit met. */
typedef struct visited {
    const psplat_triangle_tree *tree; /* NULL: places are triangles */
    uint8_t *met;
    size_t count;
} visited;

static int visit(void *user, uint32_t place) {
    visited *v = user;
    uint32_t triangle = v->tree ? v->tree->triangles[place] : place;
    assert_int_equal(v->met[triangle], 0);
    v->met[triangle] = 1;
    ++v->count;
    return 0;
}

static int stop(void *user, uint32_t place) {
    (void)place;
    return ++*(int *)user == 2;
}

/* Visits a box in the tree of fits or else in that of checks. */
static void visit_box(const psplat_triangle_tree *tree, const psplat_morton_tree *check,
                      const double low[3], const double high[3],
                      int (*visitor)(void *user, uint32_t place), void *user) {
    if (tree)
        psplat_triangle_tree_visit_box(tree, low, high, visitor, user);
    else
        psplat_morton_tree_visit_box(check, low, high, visitor, user);
}

/* Asserts that a visit meets just the triangles whose boxes meet the box. */
static void compare_box(scene *s, const psplat_triangle_tree *tree,
                        const psplat_morton_tree *check) {
    double low[3], high[3];
    size_t expected = 0;
    visited v = {.tree = tree, .met = calloc(s->mesh.triangle_count, 1)};
    assert_non_null(v.met);
    random_point(s, 1, low);
    for (int k = 0; k < 3; ++k) high[k] = low[k] + s->scale * between(&s->random, 0, 0.7);
    visit_box(tree, check, low, high, visit, &v);
    for (size_t t = 0; t < s->mesh.triangle_count; ++t) {
        int meets = 1;
        for (int k = 0; k < 3; ++k) {
            const double *p = s->mesh.positions + 9 * t + k;
            meets &= min2(min2(p[0], p[3]), p[6]) <= high[k];
            meets &= max2(max2(p[0], p[3]), p[6]) >= low[k];
        }
        expected += (size_t)meets;
        if (meets) assert_int_equal(v.met[t], 1);
    }
    assert_int_equal(v.count, expected);
    int visits = 0;
    visit_box(tree, check, low, high, stop, &visits);
    assert_int_equal(visits, expected < 2 ? expected : 2);
    free(v.met);
}

/* Compares all queries with CGAL's, which takes no needles: it loses half of the digits of
 * distances and refuses segments. Returns how many segments met a triangle. */
static size_t compare_all(scene *s, int has_needles) {
    psplat_distance *own = psplat_distance_create(&s->mesh);
    psplat_distance *check = psplat_distance_create_check(&s->mesh);
    psplat_morton_tree *check_tree = psplat_morton_tree_create(&s->mesh);
    psplat_distance *cgal = psplat_distance_create_cgal(&s->mesh);
    size_t met = 0;
    assert_true(own && check && check_tree && cgal);
    assert_true(psplat_distance_tree(own) && !psplat_distance_tree(cgal));
    assert_null(psplat_distance_tree(check));
    for (int i = 0; i < QUERIES; ++i) {
        compare_distance(s, i % 2 ? own : check, cgal, has_needles);
        if (!has_needles) met += (size_t)compare_segment(s, i % 2 ? own : check, cgal);
        compare_box(s, i % 2 ? psplat_distance_tree(own) : NULL, check_tree);
    }
    psplat_distance_destroy(own);
    psplat_distance_destroy(check);
    psplat_morton_tree_destroy(check_tree);
    psplat_distance_destroy(cgal);
    return met;
}

static void test_against_cgal(void **state) {
    (void)state;
    const double scales[] = {1, 1e-9, 1e9};
    size_t met = 0;
    for (int kind = 0; kind < KINDS; ++kind) {
        const size_t counts[] = {1, 5, 17, 65, 700};
        for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
            scene s = make_scene(kind, counts[i], scales[i % 3], 0);
            met += compare_all(&s, kind == 2 || kind == 3);
            free_scene(&s);
        }
        scene s = make_scene(kind, 700, 1, 1e7);
        met += compare_all(&s, kind == 2 || kind == 3);
        free_scene(&s);
    }
    assert_in_range(met, 200, KINDS * 6 * QUERIES / 2);
}

/* ---- ties, neighbours, nothing -------------------------------------------------------------- */

/* Of triangles that exist twice, the first is found, from whichever guess. */
static void test_ties(void **state) {
    (void)state;
    scene s = make_scene(4, 400, 1, 0);
    psplat_triangle_tree *tree = psplat_triangle_tree_create(&s.mesh, NULL);
    assert_non_null(tree);
    for (uint32_t i = 0; i < 400; ++i) {
        double point[3];
        random_point(&s, 1.2, point);
        psplat_tree_nearest first = {.distance2 = HUGE_VAL, .place = PSPLAT_NONE};
        psplat_tree_nearest guessed = {.distance2 = HUGE_VAL, .place = i};
        psplat_triangle_tree_nearest(tree, point, &first);
        psplat_triangle_tree_nearest(tree, point, &guessed);
        assert_int_equal(first.place, guessed.place);
        assert_int_equal(tree->triangles[first.place] % 2, 0);
        assert_memory_equal(first.point, guessed.point, sizeof first.point);
        /* A limit just below leaves none. */
        psplat_tree_nearest none = {.distance2 = first.distance2 * (1 - 1e-12), .place = i};
        psplat_triangle_tree_nearest(tree, point, &none);
        assert_int_equal(none.place, PSPLAT_NONE);
    }
    psplat_triangle_tree_destroy(tree);
    free_scene(&s);
}

static void test_neighbors(void **state) {
    (void)state;
    scene s = make_scene(0, 100, 1, 0);
    uint32_t neighbors[300];
    for (uint32_t i = 0; i < 300; ++i) neighbors[i] = i % 3 ? (i / 3 + i) % 100 : PSPLAT_NONE;
    psplat_triangle_tree *tree = psplat_triangle_tree_create(&s.mesh, neighbors);
    assert_non_null(tree);
    for (size_t i = 0; i < 300; ++i) {
        uint32_t expected = neighbors[3 * tree->triangles[i / 3] + i % 3];
        uint32_t place = tree->neighbors[i];
        assert_int_equal(place == PSPLAT_NONE ? place : tree->triangles[place], expected);
    }
    psplat_triangle_tree_destroy(tree);
    free_scene(&s);
}

/* Strips lie side by side, and begin anywhere along a line that is half as long again as they are.
 * Boxes that divide them by where they begin overlap for most of their length; those that divide
 * them side by side do not. */
static void test_strips(void **state) {
    (void)state;
    enum { STRIPS = 256 };
    scene s = make_scene(0, STRIPS, 1, 0);
    double area = 0;
    for (size_t i = 0; i < STRIPS; ++i) {
        double begin = between(&s.random, 0, 1.5), at = (double)i / STRIPS;
        const double corners[3][3] = {
            {begin, at, 0}, {begin + 1, at, 0}, {begin + 1, at + 1.0 / STRIPS, 0}};
        for (int corner = 0; corner < 3; ++corner) set_corner(&s, i, corner, corners[corner]);
    }
    psplat_triangle_tree *tree = psplat_triangle_tree_create(&s.mesh, NULL);
    assert_non_null(tree);
    for (size_t i = 0; i < STRIPS / (PSPLAT_TREE_LEAF * PSPLAT_TREE_PARTS); ++i)
        for (int part = 0; part < PSPLAT_TREE_PARTS; ++part) {
            const psplat_tree_node *node = &tree->nodes[i];
            double x = (double)(node->high[0][part] - node->low[0][part]) / tree->scale;
            double y = (double)(node->high[1][part] - node->low[1][part]) / tree->scale;
            area += x * y;
        }
    print_message("boxes of strips have an area of %.2f\n", area);
    assert_true(area <= 2.5); /* that of the rectangle around all strips */
    psplat_triangle_tree_destroy(tree);
    free_scene(&s);
}

static void test_nothing(void **state) {
    (void)state;
    psplat_mesh mesh = {0};
    psplat_triangle_tree *tree = psplat_triangle_tree_create(&mesh, NULL);
    assert_non_null(tree);
    const double a[3] = {0, 0, 0}, b[3] = {1, 1, 1};
    uint32_t place = PSPLAT_NONE;
    psplat_tree_nearest none = {.distance2 = HUGE_VAL, .place = PSPLAT_NONE};
    psplat_triangle_tree_nearest(tree, a, &none);
    assert_int_equal(none.place, PSPLAT_NONE);
    assert_int_equal(psplat_triangle_tree_is_within(tree, a, 5, &place), 0);
    assert_int_equal(psplat_triangle_tree_meets(tree, a, b), 0);
    psplat_triangle_tree_destroy(tree);
}

/* A point so far away that squares in single precision would overflow still finds a triangle. */
static void test_far_away(void **state) {
    (void)state;
    scene s = make_scene(0, 50, 1e-9, 0);
    psplat_triangle_tree *tree = psplat_triangle_tree_create(&s.mesh, NULL);
    assert_non_null(tree);
    const double point[3] = {1e15, -1e15, 1e15};
    psplat_tree_nearest nearest = {.distance2 = HUGE_VAL, .place = PSPLAT_NONE};
    psplat_triangle_tree_nearest(tree, point, &nearest);
    assert_int_not_equal(nearest.place, PSPLAT_NONE);
    assert_true(fabs(sqrt(nearest.distance2 / 3) / 1e15 - 1) < 1e-12);
    psplat_triangle_tree_destroy(tree);
    free_scene(&s);
}

int test_triangle_tree_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_against_cgal), cmocka_unit_test(test_ties),
        cmocka_unit_test(test_neighbors),    cmocka_unit_test(test_strips),
        cmocka_unit_test(test_nothing),      cmocka_unit_test(test_far_away),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

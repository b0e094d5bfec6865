/* SPDX-License-Identifier: MIT
 *
 * test_hausdorff.c - tests of the greatest distances (one-sided Hausdorff distances) against those
 * that CGAL finds between the same triangles, for a cube with a broken splat and for converted
 * models. Splats become polygons for CGAL. Three deviations are allowed, all of them lengths.
 * CGAL's value is up to its bound too small, and never below the bound. A polygon of 64 sides lies
 * inside its ellipse by up to (1 - cos(pi / 64)) radii. The maximum over N points may miss the true
 * one by the radius of the largest hole between the points, since a distance changes by no more
 * than the way gone. Among N random points on an area A about (A / a) (N a / A)^2 exp(-N a / A)
 * discs of area a are expected to be empty (Hall, Introduction to the Theory of Coverage Processes,
 * 1988, section 3.3): 0.002 of them for a = 2 ln(N) A / N and N = 10,000.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "compare_fixture.h"
#include "hausdorff.h"
#include "base/region.h"
#include "base/vector.h"
#include "compare/placed_splats.h"
#include "compare/shape_errors.h"
#include "compare/source_mesh_parts.h"
#include "export/glb_writer.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"

static const double pi = 3.14159265358979323846;
/* CGAL's error bound, % of the diagonal */
static const double bound = 0.5;

/* number of points sampled by the converter and by CGAL, each */
enum { POINTS = 10000 };
enum { SIDES = 64, CORNERS = 2 * SIDES + PSPLAT_MAX_CLIP_LINES, RINGS = 6 };

/* Splats as triangles. */
typedef struct polygons {
    double *points;
    uint32_t *triangles;
    size_t point_count, triangle_count;
    double error; /* greatest distance of a polygon from its ellipse */
    double area;
} polygons;

/* Returns how far triangles between rings leave a region: its rim and bent lines are chords, and
 * its surface bends between their corners. */
static double error_of(const psplat_region *region) {
    double most = max2(region->radius[0], region->radius[1]), side = most / RINGS;
    double error = (1 - cos(pi / SIDES)) * most;
    for (uint32_t i = 0; i < region->line_count; ++i) /* four chords of a line of 2 at most */
        error = max2(error, fabs(region->bends[i]) * 0.5 * 0.5 / 8 * most);
    return error + psplat_region_bend(region) * 2 * side * side / 8;
}

/* Stores the corners of a region's outline. What lines make of it is divided as finely as arcs are,
 * since the surface bends beneath. Returns their number. */
static size_t outline_of(const psplat_region *region, double corners[CORNERS][2]) {
    double coarse[CORNERS][2];
    size_t count = psplat_region_polygon(region, 1, coarse, CORNERS), fine = 0;
    for (size_t i = 0; i < count; ++i) {
        const double *a = coarse[i], *b = coarse[(i + 1) % count];
        int parts = (int)ceil(hypot(b[0] - a[0], b[1] - a[1]) * SIDES / (2 * pi) - 1e-9);
        for (int k = 0; k < parts; ++k, ++fine) {
            assert_true(fine < CORNERS);
            for (int c = 0; c < 2; ++c) corners[fine][c] = a[c] + (b[c] - a[c]) * k / parts;
        }
    }
    return fine;
}

/* Adds a region as rings of triangles around the middle of its outline. */
static void add_region(const psplat_region *region, polygons *p) {
    double corners[CORNERS][2], middle[2] = {0, 0};
    size_t count = outline_of(region, corners);
    uint32_t first = (uint32_t)p->point_count, around = (uint32_t)count;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) middle[k] += corners[i][k] / (double)count;
    for (size_t i = 0; i < (RINGS + 1) * count; ++i) {
        double t = 1 - (double)(i / count) / RINGS, uv[2];
        for (int k = 0; k < 2; ++k) uv[k] = middle[k] + t * (corners[i % count][k] - middle[k]);
        psplat_region_point(region, uv, p->points + 3 * p->point_count++);
    }
    for (uint32_t i = 0; i < RINGS * around; ++i) {
        uint32_t next = i % around + 1 < around ? i + 1 : i + 1 - around;
        const uint32_t two[6] = {first + i, first + next,          first + next + around,
                                 first + i, first + next + around, first + i + around};
        memcpy(p->triangles + 3 * p->triangle_count, two, sizeof two);
        p->triangle_count += 2;
    }
    p->error = max2(p->error, error_of(region));
    p->area += psplat_region_area(region);
}

static polygons polygons_of(const psplat_asset *asset, const double origin[3]) {
    polygons p = {0};
    psplat_placed_splats placed;
    assert_int_equal(psplat_placed_splats_create(asset, origin, &placed, NULL), PSPLAT_OK);
    p.points = malloc(placed.splats.count * (RINGS + 1) * CORNERS * 3 * sizeof *p.points);
    p.triangles = malloc(placed.splats.count * RINGS * CORNERS * 6 * sizeof *p.triangles);
    assert_non_null(p.points);
    assert_non_null(p.triangles);
    for (size_t i = 0; i < placed.splats.count; ++i) add_region(&placed.splats.regions[i], &p);
    psplat_placed_splats_free(&placed);
    return p;
}

static double hole_radius(double area, size_t samples) {
    return sqrt(2 * log((double)samples) / (double)samples * area / pi);
}

/* Asserts that the converter's distance and CGAL's two (all in %) agree; the others are lengths. */
static void agree(double ours, double bounded, double sampled, double hole, double error,
                  double diagonal) {
    hole *= 100 / diagonal, error *= 100 / diagonal;
    assert_true(bounded >= 0 && sampled >= 0);
    /* The converter's distance is one of a point on the surface, hence never too great. */
    assert_true(ours <= bounded + bound + error);
    if (bounded > bound) assert_true(ours >= bounded - hole - error);
    /* Either sampling misses the points between its own. */
    assert_near(ours, sampled, hole + error);
}

/* Compares both directions, and stores the greatest distance that CGAL finds, in %. */
static void check(const fixture *f, const psplat_asset *asset, double *most) {
    const psplat_shape_desc desc = {.samples = POINTS};
    psplat_shape_errors e = fixture_compare_asset(f, asset, &desc);
    polygons p = polygons_of(asset, f->mesh.origin);
    const hausdorff_soup source = {f->mesh.positions, f->mesh.vertex_count, f->mesh.triangles,
                                   f->mesh.triangle_count};
    const hausdorff_soup splats = {p.points, p.point_count, p.triangles, p.triangle_count};
    double scale = 100 / e.diagonal, surface = f->source->surface.area;
    double outward = scale * hausdorff_bounded(&source, &splats, bound / scale);
    double inward = scale * hausdorff_bounded(&splats, &source, bound / scale);
    agree(e.outward.max, outward, scale * hausdorff_sampled(&source, &splats, desc.samples),
          hole_radius(surface, desc.samples), p.error, e.diagonal);
    agree(e.inward.max, inward, scale * hausdorff_sampled(&splats, &source, desc.samples),
          hole_radius(p.area, desc.samples), p.error, e.diagonal);
    *most = max2(outward, inward);
    free(p.points);
    free(p.triangles);
}

/* One splat of a cube is moved outwards, and then another one is cut in half. */
static void test_cube(void **state) {
    (void)state;
    fixture f;
    double most;
    fixture_model(&f, "cube.off");
    double half = f.source->surface.diagonal / sqrt(12);
    for (int broken = 0; broken < 3; ++broken) {
        scene s = scene_cube((float)half);
        for (int k = 0; k < 3; ++k) s.origin[k] = f.mesh.origin[k];
        if (broken == 1)
            for (int k = 0; k < 3; ++k) s.splats[0].center[k] *= 1.3f;
        if (broken == 2) s.splats[0].clip[0][2] = 0;
        psplat_asset *asset = scene_open(&s);
        check(&f, asset, &most);
        psplat_asset_destroy(asset);
        scene_free(&s);
        /* The middle of the moved face is 0.3 half edges from its place. The half that was cut off
         * is open, and its middle is half an edge from the next splats. */
        const double expected[] = {bound, 100 * 0.3 / sqrt(12), 100 * 0.5 / sqrt(12)};
        assert_near(most, expected[broken], bound + 1e-4);
    }
    fixture_free(&f);
}

/* Compares a coarse conversion of a model. */
static void check_converted(const char *name, double tolerance) {
    fixture f;
    psplat_splats splats = {0};
    psplat_asset *asset;
    uint8_t *glb;
    size_t size;
    double most;
    const psplat_convert_desc desc = {
        .tolerance_percent = tolerance, .effort = PSPLAT_EFFORT_NONE, .unverified = 1};
    fixture_model(&f, name);
    assert_int_equal(psplat_convert(&f.mesh, &desc, &splats, NULL, NULL), PSPLAT_OK);
    assert_int_equal(psplat_glb_write(&splats, NULL, NULL, &glb, &size, NULL), PSPLAT_OK);
    assert_int_equal(psplat_asset_open_memory(glb, size, NULL, &asset, NULL), PSPLAT_OK);
    check(&f, asset, &most);
    /* Splats do use their tolerance, so that the distances compared are not 0. */
    assert_true(most > tolerance / 2);
    psplat_asset_destroy(asset);
    psplat_splats_free(&splats);
    free(glb);
    fixture_free(&f);
}

static void test_sphere(void **state) {
    (void)state;
    check_converted("sphere.ply", 3);
}

static void test_torus(void **state) {
    (void)state;
    check_converted("torus.off", 3);
}

static void test_part(void **state) {
    (void)state;
    check_converted("part.obj", 3);
}

int test_hausdorff_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cube),
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_torus),
        cmocka_unit_test(test_part),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

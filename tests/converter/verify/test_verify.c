/* SPDX-License-Identifier: MIT
 *
 * test_verify.c - tests of the verification that follows a conversion: distances, coverage, normals
 * and promises. The shape is a cube with six splats made by hand, which are then removed, moved,
 * turned or uncut by known amounts.
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
#include "base/region.h"
#include "base/vector.h"
#include "features/surface.h"
#include "fit/candidate.h"
#include "features/samples.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"
#include "select/selection.h"
#include "select/sort_splats.h"
#include "splats/splats.h"
#include "verify/report.h"
#include "verify/verify.h"

enum { SAMPLES = 50000 }; /* the least number that is drawn */

static const double degrees = 180 / 3.14159265358979323846;
/* A few roundings of float coordinates, in half edges. */
static const double single = 1e-6;

/* A cube and its six splats, each a face that four lines cut. */
typedef struct cube {
    fixture f;
    psplat_splats splats;
    double half;
    double tolerance;
    double normal_tolerance; /* degrees; 0 stands for no tolerance */
} cube;

static void make_cube(cube *c) {
    *c = (cube){0};
    psplat_candidate faces[6];
    fixture_model(&c->f, "cube.off");
    c->half = c->f.surface.diagonal / sqrt(12);
    c->tolerance = 0.02 * c->f.surface.diagonal;
    for (int i = 0; i < 6; ++i) {
        faces[i] =
            (psplat_candidate){.region = {.line_count = 4}, .color = {1, 1, 1, 1}, .taken = 1};
        psplat_region *r = &faces[i].region;
        double side = i % 2 ? -1 : 1;
        r->n[i / 2] = side;
        r->u[(i / 2 + 1) % 3] = 1;
        cross3(r->v, r->n, r->u);
        mad3(r->center, c->half, r->n);
        for (int k = 0; k < 2; ++k) r->radius[k] = 1.5 * c->half;
        for (int k = 0; k < 4; ++k) {
            r->lines[k][k / 2] = k % 2 ? -1 : 1;
            r->lines[k][2] = 1 / 1.5;
        }
    }
    psplat_selection selection = {faces, 6, 6};
    c->splats = (psplat_splats){
        .kernel = {PSPLAT_DEFAULT_KERNEL_SHARPNESS, PSPLAT_DEFAULT_KERNEL_EXPONENT}};
    const psplat_sort_desc storing = {0};
    assert_int_equal(psplat_sort_splats(&selection, &storing, &c->splats), PSPLAT_OK);
}

static void free_cube(cube *c) {
    psplat_splats_free(&c->splats);
    fixture_free(&c->f);
}

static psplat_report verify(const cube *c) {
    psplat_report r = {0};
    psplat_distance *distance = psplat_distance_create(&c->f.mesh);
    assert_non_null(distance);
    const psplat_verification verification = {.surface = &c->f.surface,
                                              .splats = &c->splats,
                                              .distance = distance,
                                              .tolerance_percent =
                                                  100 * c->tolerance / c->f.surface.diagonal,
                                              .diagonal = c->f.surface.diagonal,
                                              .normal_tolerance_degrees = c->normal_tolerance,
                                              .seed = 5};
    assert_int_equal(psplat_verify(&verification, &r, NULL), PSPLAT_OK);
    psplat_distance_destroy(distance);
    return r;
}

/* Converts % of the diagonal to half edges. */
static double in_halves(const cube *c, double percent) {
    return percent / 100 * c->f.surface.diagonal / c->half;
}

/* Asserts that a report names `broken` as its only broken promise (PSPLAT_PROMISE_COUNT: none), and
 * lists its places in order of their values. */
static void assert_kept(const psplat_report *r, psplat_promise broken) {
    for (int k = 0; k < PSPLAT_PROMISE_COUNT; ++k)
        assert_int_equal(r->promises[k].broken > 0, k == (int)broken);
    assert_int_equal(psplat_report_broken(r), broken);
    assert_int_equal(r->place_count > 0, broken != PSPLAT_PROMISE_COUNT);
    for (size_t i = 0; i < r->place_count; ++i) {
        assert_int_equal(r->places[i].promise, broken);
        assert_true(i == 0 || r->places[i].value <= r->places[i - 1].value);
    }
}

static void test_perfect(void **state) {
    (void)state;
    cube c;
    make_cube(&c);
    psplat_report r = verify(&c);
    assert_in_range(r.verification_samples, SAMPLES - 1, SAMPLES + 1);
    assert_int_equal(r.uncovered_samples, 0);
    assert_near(in_halves(&c, r.max_distance_percent), 0, single);
    assert_true(r.bound_distance_splats_percent >= r.max_distance_splats_percent);
    assert_true(r.bound_distance_splats_percent <=
                100 * c.tolerance / c.f.surface.diagonal * (1 + 2e-6));
    assert_int_equal(r.unproven_splats, 0);
    assert_near(r.unproven_surface_percent, 0, 1e-12);
    assert_near(r.rms_normal_degrees, 0, 1e-4); /* degrees; rounding to float gives 1e-5 */
    assert_near(r.p95_normal_degrees, 0, 1e-4);
    assert_near(r.max_normal_degrees, 0, 1e-4);
    assert_kept(&r, PSPLAT_PROMISE_COUNT);
    free_cube(&c);
}

/* Without the splat of one face, a sixth of the surface is open, and the middle of that face is
 * half an edge from the next splat. */
static void test_missing(void **state) {
    (void)state;
    for (size_t gone = 0; gone < 6; ++gone) {
        cube c;
        make_cube(&c);
        c.splats.splats[gone] = c.splats.splats[5];
        c.splats.count = 5;
        psplat_report r = verify(&c);
        double share = (double)r.uncovered_samples / (double)r.verification_samples;
        /* Each triangle gets its share of samples up to one, and samples at the edges may belong to
         * the neighbour by rounding to float. */
        assert_near(share, 1.0 / 6, 10.0 / SAMPLES);
        /* Of 8333 samples on a face the nearest to its middle is about 0.01 edges from it. */
        assert_near(in_halves(&c, r.max_distance_surface_percent), 1, 0.05);
        assert_near(in_halves(&c, r.max_distance_splats_percent), 0, single);
        assert_true(r.max_distance_percent == r.max_distance_surface_percent);
        /* The distance x to the nearest edge has the density 8 (1 - x) / 4 over 0 ... 1, whose mean
         * square is 1 / 6. */
        assert_near(in_halves(&c, r.rms_distance_percent), sqrt(1.0 / 36), 0.01);
        assert_near(r.rms_normal_degrees, 0, 1e-4); /* over covered samples */
        /* Holes count as well as samples: one in each square of the tolerance, or two where squares
         * are cut. */
        size_t holes = r.promises[PSPLAT_PROMISE_COVERAGE].broken - r.uncovered_samples;
        double squares = pow(2 * c.half / c.tolerance, 2);
        assert_in_range(holes, (size_t)(0.5 * squares), (size_t)(2 * squares));
        /* Open samples farther than the tolerance from a splat break the promise of distance as
         * well, but the places listed are those of coverage, and the first one is near the middle
         * of the face. */
        assert_int_equal(psplat_report_broken(&r), PSPLAT_PROMISE_COVERAGE);
        assert_int_equal(r.place_count, PSPLAT_MOST_PLACES);
        double middle[3];
        for (int k = 0; k < 3; ++k) middle[k] = r.places[0].position[k] - c.f.mesh.origin[k];
        assert_near(length3(middle) / c.half, 1, 0.01);
        assert_near(r.places[0].value, r.promises[PSPLAT_PROMISE_COVERAGE].worst, 0);
        free_cube(&c);
    }
}

/* The samples of the missing face are marked, and no others. */
static void test_marks(void **state) {
    (void)state;
    cube c;
    make_cube(&c);
    psplat_samples samples;
    assert_int_equal(psplat_samples_draw_uniform(&c.f.surface, 5000, 3, &samples, NULL), PSPLAT_OK);
    uint8_t *open = malloc(samples.count);
    assert_non_null(open);
    size_t count, marked = 0;
    const float *gone = c.splats.splats[5].center;
    c.splats.count = 5;
    count = fixture_open(&samples, &c.splats, c.tolerance, open);
    for (size_t i = 0; i < samples.count; ++i) {
        double along = 0;
        for (size_t k = 0; k < 3; ++k) along += samples.positions[3 * i + k] * (double)gone[k];
        int inside = along > (1 - 1e-9) * c.half * c.half;
        assert_int_equal(open[i], inside);
        marked += open[i];
    }
    assert_int_equal(count, marked);
    assert_true(count > 0);
    free(open);
    psplat_samples_free(&samples);
    free_cube(&c);
}

/* Moves a face's splat along its normal, by parts of the half edge. */
static void move_splat(cube *c, double by) {
    psplat_splat *s = &c->splats.splats[2];
    for (int k = 0; k < 3; ++k) s->center[k] *= (float)(1 + by);
}

static void test_moved(void **state) {
    (void)state;
    const double moves[] = {0.03, 0.06, 0.2, -0.03, -0.06, -0.2};
    for (size_t i = 0; i < sizeof moves / sizeof *moves; ++i) {
        cube c;
        make_cube(&c);
        move_splat(&c, moves[i]);
        psplat_report r = verify(&c);
        double d = fabs(moves[i]), limit = c.tolerance / c.half; /* 0.069 */
        assert_near(in_halves(&c, r.max_distance_surface_percent), d, single);
        assert_near(in_halves(&c, r.max_distance_splats_percent), d, single);
        double share = (double)r.uncovered_samples / (double)r.verification_samples;
        assert_near(share, d > limit ? 1.0 / 6 : 0, 10.0 / SAMPLES);
        const psplat_kept *kept = r.promises;
        assert_int_equal(kept[PSPLAT_PROMISE_COVERAGE].broken > 0, d > limit);
        assert_int_equal(kept[PSPLAT_PROMISE_DISTANCE].broken > 0, d > limit);
        assert_near(in_halves(&c, kept[PSPLAT_PROMISE_DISTANCE].worst), d, single);
        free_cube(&c);
    }
}

/* A splat that faces inwards covers nothing, however near it is. */
static void test_inside_out(void **state) {
    (void)state;
    cube c;
    make_cube(&c);
    float *q = c.splats.splats[4].rotation, before[4];
    memcpy(before, q, sizeof before);
    /* Half a turn about its own u axis multiplies the quaternion by i. */
    q[0] = before[3], q[1] = before[2], q[2] = -before[1], q[3] = -before[0];
    psplat_report r = verify(&c);
    assert_near((double)r.uncovered_samples / (double)r.verification_samples, 1.0 / 6,
                10.0 / SAMPLES);
    assert_near(in_halves(&c, r.max_distance_percent), 0, single);
    free_cube(&c);
}

/* First every normal is turned by the same angle, then correct normals get a gradient. */
static void test_normals(void **state) {
    (void)state;
    cube c;
    make_cube(&c);
    psplat_region *regions = psplat_splat_regions(&c.splats);
    assert_non_null(regions);
    const double turn = 7 / degrees;
    for (size_t i = 0; i < 6; ++i)
        for (int k = 0; k < 3; ++k)
            c.splats.splats[i].normal[k] =
                (float)(cos(turn) * regions[i].n[k] + sin(turn) * regions[i].u[k]);
    psplat_report r = verify(&c);
    assert_near(r.rms_normal_degrees, 7, 1e-4);
    assert_near(r.rms_normal_constant_degrees, 7, 1e-4);
    assert_near(r.p95_normal_degrees, 7, 1e-4);

    const double slope = 0.3;
    for (size_t i = 0; i < 6; ++i) {
        for (int k = 0; k < 3; ++k) c.splats.splats[i].normal[k] = (float)regions[i].n[k];
        c.splats.splats[i].gradient[0] = (float)slope;
    }
    r = verify(&c);
    double squares = 0;
    enum { STEPS = 2000 };
    for (int i = 0; i < STEPS; ++i) {
        double u = ((i + 0.5) / STEPS * 2 - 1) / 1.5; /* the face ends at u = 1 / 1.5 */
        squares += pow(atan(slope * u) * degrees, 2) / STEPS;
    }
    /* 50000 samples give the mean square to 1 %, and its root to half of that. */
    assert_near(r.rms_normal_degrees, sqrt(squares), 0.01 * sqrt(squares));
    assert_near(r.p95_normal_degrees, atan(slope * 0.95 / 1.5) * degrees, 0.1);
    assert_near(r.rms_normal_constant_degrees, 0, 1e-4);

    /* The same slope acts across: gamma u along v. The radii are equal, so that x changes with v
     * alike, and the slope grows with the distance from the middle of the face. */
    for (size_t i = 0; i < 6; ++i) {
        c.splats.splats[i].gradient[0] = 0;
        c.splats.splats[i].gradient[2] = (float)slope;
    }
    r = verify(&c);
    squares = 0;
    enum { ROWS = 200 };
    for (int i = 0; i < ROWS * ROWS; ++i) {
        double u = ((i % ROWS + 0.5) / ROWS * 2 - 1) / 1.5;
        double v = ((i / ROWS + 0.5) / ROWS * 2 - 1) / 1.5;
        squares += pow(atan(slope * hypot(u, v)) * degrees, 2) / (ROWS * ROWS);
    }
    assert_near(r.rms_normal_degrees, sqrt(squares), 0.01 * sqrt(squares));
    free(regions);
    free_cube(&c);
}

/* The field of one face leans more and more towards its rim, so that it is known where it exceeds
 * the tolerance; the places must lie there. */
static void test_normal_promise(void **state) {
    (void)state;
    cube c;
    make_cube(&c);
    const double slope = 0.3, rim = atan(slope / 1.5) * degrees; /* 11.3 degrees */
    c.splats.splats[1].gradient[0] = (float)slope;
    psplat_report r = verify(&c);
    assert_near(r.max_normal_degrees, rim, 0.01); /* Some sample is that close to the rim. */
    assert_kept(&r, PSPLAT_PROMISE_COUNT);        /* Nothing was promised. */
    assert_true(r.promises[PSPLAT_PROMISE_NORMAL].limit == 0);
    c.normal_tolerance = rim + 0.001;
    r = verify(&c);
    assert_kept(&r, PSPLAT_PROMISE_COUNT);
    c.normal_tolerance = 0.5 * rim;
    r = verify(&c);
    assert_kept(&r, PSPLAT_PROMISE_NORMAL);
    /* The tangent grows faster than the angle: samples beyond |u| = 0.49 of the rim, on one face in
     * six. */
    double u = tan(0.5 * rim / degrees) / tan(rim / degrees);
    assert_near((double)r.promises[PSPLAT_PROMISE_NORMAL].broken / SAMPLES, (1 - u) / 6, 0.002);
    assert_near(r.promises[PSPLAT_PROMISE_NORMAL].limit, 0.5 * rim, 0);
    for (size_t i = 0; i < r.place_count; ++i)
        assert_true(r.places[i].value > 0.5 * rim && r.places[i].value < rim * (1 + single));
    /* A second splat over the same face has correct normals and keeps the promise for both. */
    psplat_splat seven[7];
    memcpy(seven, c.splats.splats, 6 * sizeof *seven);
    seven[6] = seven[1];
    seven[6].gradient[0] = 0;
    psplat_splats more = c.splats, own = c.splats;
    more.splats = seven, more.count = 7;
    c.splats = more;
    r = verify(&c);
    c.splats = own;
    assert_kept(&r, PSPLAT_PROMISE_COUNT);
    free_cube(&c);
}

/* Without one of its lines a face's splat reaches over that edge by half an edge: the ellipse ends
 * at 1.5 times the face. At right angles to the next face, it is as far from the surface. */
static void test_crease_promise(void **state) {
    (void)state;
    cube c;
    make_cube(&c);
    psplat_region *regions = psplat_splat_regions(&c.splats);
    assert_non_null(regions);
    for (size_t over = 0; over < 2; ++over) {
        /* in half edges; the tolerance is 0.069 */
        double reach = over ? 0.08 : 0.06;
        c.splats.splats[3].clip[2][2] = (float)((1 + reach) / 1.5);
        psplat_report r = verify(&c);
        const psplat_kept *crease = &r.promises[PSPLAT_PROMISE_CREASE];
        assert_near(in_halves(&c, crease->worst), reach, 2 * single);
        assert_near(in_halves(&c, crease->limit), c.tolerance / c.half, single);
        assert_int_equal(crease->broken, over);
        assert_int_equal(r.promises[PSPLAT_PROMISE_DISTANCE].broken, over);
        if (!over) continue;
        /* The place is on the crease, the edge of that face in the line's direction. */
        const psplat_place *place = &r.places[r.place_count - 1];
        assert_int_equal(place->promise, PSPLAT_PROMISE_CREASE);
        double d[3], on_v;
        for (int k = 0; k < 3; ++k)
            d[k] = place->position[k] - c.f.mesh.origin[k] - regions[3].center[k];
        on_v = dot3(d, regions[3].v) / c.half;
        assert_near(fabs(on_v), 1, single);
        assert_near(dot3(d, regions[3].n) / c.half, 0, single);
    }
    free(regions);
    free_cube(&c);
}

/* Two squares face up, the small one above the large one by a quarter of the tolerance. The splat
 * of the large one crosses the border of the small one, which belongs to another sheet and breaks
 * no promise. */
static void test_crease_of_another_sheet(void **state) {
    (void)state;
    const double height = 0.005;
    fixture f = {0};
    static const double at[8][2] = {{-1, -1},       {1, -1},       {1, 1},       {-1, 1},
                                    {-0.05, -0.05}, {0.05, -0.05}, {0.05, 0.05}, {-0.05, 0.05}};
    static const uint32_t triangles[12] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
    f.mesh = (psplat_mesh){.positions = calloc(24, sizeof(double)),
                           .triangles = malloc(sizeof triangles),
                           .vertex_count = 8,
                           .triangle_count = 4};
    for (size_t i = 0; i < 8; ++i) {
        f.mesh.positions[3 * i] = at[i][0], f.mesh.positions[3 * i + 1] = at[i][1];
        f.mesh.positions[3 * i + 2] = i < 4 ? 0 : height;
    }
    memcpy(f.mesh.triangles, triangles, sizeof triangles);
    fixture_build(&f);
    psplat_candidate candidate = {
        .region = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {1.5, 1.5}},
        .color = {1, 1, 1, 1},
        .taken = 1};
    candidate.region.line_count = 4;
    for (int k = 0; k < 4; ++k) {
        candidate.region.lines[k][k / 2] = k % 2 ? -1 : 1;
        candidate.region.lines[k][2] = 1 / 1.5;
    }
    cube c = {.f = f, .tolerance = 4 * height};
    psplat_selection selection = {&candidate, 1, 1};
    c.splats = (psplat_splats){
        .kernel = {PSPLAT_DEFAULT_KERNEL_SHARPNESS, PSPLAT_DEFAULT_KERNEL_EXPONENT}};
    const psplat_sort_desc storing = {0};
    assert_int_equal(psplat_sort_splats(&selection, &storing, &c.splats), PSPLAT_OK);
    psplat_report r = verify(&c);
    assert_kept(&r, PSPLAT_PROMISE_COUNT);
    free_cube(&c);
}

/* Sizes and places far from 1 do not change measures in percent. */
static void test_scales(void **state) {
    (void)state;
    const double scales[] = {1e-9, 1e9};
    for (size_t s = 0; s < 2; ++s) {
        cube c;
        make_cube(&c);
        for (size_t i = 0; i < 3 * c.f.mesh.vertex_count; ++i) c.f.mesh.positions[i] *= scales[s];
        psplat_surface_free(&c.f.surface);
        fixture_build(&c.f);
        for (size_t i = 0; i < 6; ++i)
            for (int k = 0; k < 3; ++k) {
                c.splats.splats[i].center[k] *= (float)scales[s];
                if (k < 2) c.splats.splats[i].radius[k] *= (float)scales[s];
            }
        c.half *= scales[s], c.tolerance *= scales[s];
        move_splat(&c, 0.05);
        psplat_report r = verify(&c);
        assert_near(in_halves(&c, r.max_distance_surface_percent), 0.05, single);
        assert_near(in_halves(&c, r.max_distance_splats_percent), 0.05, single);
        assert_int_equal(r.uncovered_samples, 0);
        free_cube(&c);
    }
}

/* A saddle 2 wide, of curvatures -0.3 and 0.2. */
static void place_saddle(double s, double t, double p[3]) {
    p[0] = 2 * s - 1, p[1] = 2 * t - 1, p[2] = -0.15 * p[0] * p[0] + 0.1 * p[1] * p[1];
}

/* One curved splat that four lines cut to the square is the saddle itself, up to what its triangles
 * sag: 0.3 / 8 of the square of their sides. Without its shape it leaves the surface by 0.15 in the
 * middles of two borders and covers less. */
static void test_curved(void **state) {
    (void)state;
    enum { CELLS = 24 };
    for (int flat = 0; flat < 2; ++flat) {
        cube c = {.half = 1};
        psplat_splat splat = {.rotation = {0, 0, 0, 1},
                              .radius = {1.5f, 1.5f},
                              .normal = {0, 0, 1},
                              .gradient = {0.45f, -0.3f, 0},
                              .color = {1, 1, 1, 1},
                              .clip_count = 4};
        for (int i = 0; i < 4; ++i) {
            splat.clip[i][i / 2] = i % 2 ? -1 : 1;
            splat.clip[i][2] = (float)(1 / 1.5);
        }
        for (int i = 0; i < 2 && !flat; ++i) splat.shape[2 + i] = splat.gradient[i];
        psplat_run run = {.count = 1, .clip_lines = 4, .is_curved = !flat};
        fixture_grid(&c.f, CELLS, CELLS, place_saddle);
        fixture_build(&c.f);
        c.tolerance = 0.01;
        c.splats = (psplat_splats){
            .splats = &splat, .count = 1, .runs = &run, .run_count = 1, .kernel = {2, 2}};
        psplat_report r = verify(&c);
        double sag = 0.3 / 8 * 4 / (CELLS * CELLS);
        if (flat) {
            assert_true(r.uncovered_samples > r.verification_samples / 4);
            assert_near(in_halves(&c, r.max_distance_surface_percent), 0.15, 0.01);
        } else {
            assert_int_equal(r.uncovered_samples, 0);
            assert_true(in_halves(&c, r.max_distance_percent) <= 2 * sag);
            /* Normals of corners on the border are those of half a cell inside. */
            assert_true(r.max_normal_degrees < (0.3 + 0.2) / CELLS * degrees);
            assert_kept(&r, PSPLAT_PROMISE_COUNT);
        }
        fixture_free(&c.f);
    }
}

int test_verify_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_curved),
        cmocka_unit_test(test_perfect),
        cmocka_unit_test(test_missing),
        cmocka_unit_test(test_marks),
        cmocka_unit_test(test_moved),
        cmocka_unit_test(test_inside_out),
        cmocka_unit_test(test_normals),
        cmocka_unit_test(test_scales),
        cmocka_unit_test(test_normal_promise),
        cmocka_unit_test(test_crease_promise),
        cmocka_unit_test(test_crease_of_another_sheet),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

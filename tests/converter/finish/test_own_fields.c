/* SPDX-License-Identifier: MIT
 *
 * test_own_fields.c - tests of normal fields beside shapes: a field that the surface's shading has
 * is found, one conversion of few smooth polygons gets fields that are much nearer to its normals
 * than those of its shapes, and conversions that do not need them, or must not have them, get none.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <math.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "base/vector.h"
#include "fit/candidate.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "finish/blend_points.h"
#include "select/conversion.h"
#include "finish/own_fields.h"
#include "splats/splats.h"
#include "verify/report.h"

/* The slopes of the shading normals of the square: of x along x, of y along y, of both across. */
static const double along_x = 0.3, along_y = -0.2, across = 0.1;

static void place_square(double s, double t, double p[3]) {
    p[0] = 2 * s - 1, p[1] = 2 * t - 1, p[2] = 0;
}

static void square_normal(const double p[3], double n[3]) {
    n[0] = along_x * p[0] + across * p[1];
    n[1] = across * p[0] + along_y * p[1];
    n[2] = 1;
}

static void place_bowl(double s, double t, double p[3]) {
    place_square(s, t, p);
    p[2] = 0.4 * (p[0] * p[0] + p[1] * p[1]) + 0.1 * p[0] * p[0] * p[0];
}

static void bowl_normal(const double p[3], double n[3]) {
    n[0] = -0.8 * p[0] - 0.3 * p[0] * p[0];
    n[1] = -0.8 * p[1];
    n[2] = 1;
}

/* Gives a mesh the normals of a surface, as its file would have them. */
static void author_normals(psplat_mesh *mesh, void (*find)(const double p[3], double n[3])) {
    mesh->corner_normals = malloc(9 * mesh->triangle_count * sizeof(float));
    assert_non_null(mesh->corner_normals);
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        double n[3];
        find(mesh->positions + 3 * (size_t)mesh->triangles[i], n);
        normalize3(n);
        for (size_t k = 0; k < 3; ++k) mesh->corner_normals[3 * i + k] = (float)n[k];
    }
}

static const double tolerance = 0.01;

/* A conversion of the square by these candidates, all taken. */
typedef struct stage {
    fixture f;
    psplat_convert_desc desc;
    psplat_splats splats;
    psplat_candidate candidates[2];
    psplat_conversion c;
} stage;

static void begin(stage *s, size_t count) {
    *s = (stage){.desc = {.seed = 1}};
    fixture_grid(&s->f, 32, 32, place_square);
    author_normals(&s->f.mesh, square_normal);
    fixture_build(&s->f);
    s->splats.precision = (psplat_precision){.unit = 1e-3, .field_step = 0.1, .tilt_step = 0.1};
    for (size_t i = 0; i < count; ++i) {
        psplat_candidate *candidate = &s->candidates[i];
        candidate->taken = 1;
        candidate->deviation = 0.5 * tolerance;
        candidate->covered_count = 1;
        candidate->region = (psplat_region){.center = {0.1 - 0.6 * (double)i, 0.05, 0},
                                            .u = {1, 0, 0},
                                            .v = {0, 1, 0},
                                            .n = {0, 0, 1},
                                            .radius = {1.5, 1.2},
                                            .hessian = {0.002, 0, -0.001}};
    }
    s->c = (psplat_conversion){.desc = &s->desc,
                               .surface = s->f.surface,
                               .selection = {s->candidates, count, count},
                               .limits = {.precision = &s->splats.precision},
                               .kernel = {4, 2},
                               .splats = &s->splats,
                               .tolerance = tolerance};
}

/* The greatest difference between the field of a candidate and that of the square's shading. */
static double field_error(const psplat_candidate *candidate) {
    const psplat_region *r = &candidate->region;
    double n[3], greatest = 0;
    square_normal(r->center, n);
    const double expected[5] = {n[0], n[1], along_x * r->radius[0], along_y * r->radius[1],
                                across * r->radius[0]};
    for (int k = 0; k < 5; ++k) greatest = fmax(greatest, fabs(candidate->field[k] - expected[k]));
    return greatest;
}

static int is_on_grid(const double *field, double step) {
    for (int k = 0; k < 5; ++k)
        if (fabs(field[k] / step - rint(field[k] / step)) > 1e-9) return 0;
    return 1;
}

/* One splat gets the field of the shading. With 200 points, the weight that holds it to that of its
 * shape pulls by 1.5 % of what the two differ by, which is 0.45 at most; rounding adds half a step,
 * which is the error that is left: about half of that pull. */
static void test_one_field(void **state) {
    (void)state;
    stage s;
    begin(&s, 1);
    assert_true(field_error(&s.candidates[0]) > 0.2);
    assert_int_equal(psplat_fit_own_fields(&s.c), PSPLAT_OK);
    print_message("field off by %.2e, step %.2e\n", field_error(&s.candidates[0]),
                  s.splats.precision.field_step);
    assert_true(field_error(&s.candidates[0]) < 8e-3);
    assert_true(s.splats.precision.field_step < 4e-3);
    assert_true(s.splats.precision.tilt_step == s.splats.precision.field_step);
    assert_true(is_on_grid(s.candidates[0].field, s.splats.precision.field_step));
    assert_true(s.candidates[0].region.hessian[0] == 0.002); /* The shape stays. */
    fixture_free(&s.f);
}

/* Where the shading is that of the shape, there is nothing to gain, and nothing changes. */
static void test_no_gain(void **state) {
    (void)state;
    stage s;
    begin(&s, 1);
    s.candidates[0].region.center[0] = s.candidates[0].region.center[1] = 0;
    s.candidates[0].region.hessian[0] = -along_x;
    s.candidates[0].region.hessian[1] = -across;
    s.candidates[0].region.hessian[2] = -along_y;
    s.c.tolerance = 1; /* The shape leaves the square, but not its normals. */
    s.candidates[0].deviation = 0.5;
    assert_int_equal(psplat_fit_own_fields(&s.c), PSPLAT_OK);
    for (int k = 0; k < 5; ++k) assert_true(s.candidates[0].field[k] == 0);
    assert_true(s.splats.precision.field_step == 0.1);
    fixture_free(&s.f);
}

/* Splats that lie on the surface, or on one with tangent edges, stay as they are, unless the file
 * has normals of its own, which may be others than those of the surface. */
static void test_machined(void **state) {
    (void)state;
    stage s;
    for (int kind = 0; kind < 4; ++kind) {
        int authored = kind % 2;
        begin(&s, 1);
        if (kind < 2) s.candidates[0].deviation = 0.1 * tolerance;
        if (kind >= 2) s.c.surface.tangent_edges = 2;
        if (!authored) {
            free(s.f.mesh.corner_normals); /* The surface has taken its normals. */
            s.f.mesh.corner_normals = NULL;
        }
        assert_int_equal(psplat_fit_own_fields(&s.c), PSPLAT_OK);
        for (int k = 0; k < 5 && !authored; ++k) assert_true(s.candidates[0].field[k] == 0);
        if (authored) assert_true(field_error(&s.candidates[0]) < 8e-3); /* as above */
        fixture_free(&s.f);
    }
}

/* Points know the splats that blend there, where in them, and by which weight. */
static void test_points(void **state) {
    (void)state;
    stage s;
    psplat_blend_points p;
    begin(&s, 2);
    s.candidates[0].region.radius[0] = s.candidates[0].region.radius[1] = 0.5;
    s.candidates[1].region.radius[0] = s.candidates[1].region.radius[1] = 0.25;
    assert_int_equal(psplat_blend_points_draw(&s.c, 5000, 7, &p), PSPLAT_OK);
    assert_true(p.count > 9000 && p.count < 11000);
    for (size_t i = 0; i < 2; ++i) {
        double hits = (double)(p.first[i + 1] - p.first[i]), r = s.candidates[i].region.radius[0];
        double expected = fixture_pi * r * r / 4 * (double)p.count;
        /* Five standard deviations of a binomial distribution. */
        assert_near(hits, expected, 5 * sqrt(expected));
        for (size_t k = p.first[i]; k < p.first[i + 1]; ++k) {
            const psplat_blend_hit *hit = &p.hits[k];
            double u = (double)hit->uv[0], v = (double)hit->uv[1], n[3], q[3];
            assert_true(u * u + v * v <= 1 + 1e-6);
            assert_near((double)hit->weight, exp(-4 * (u * u + v * v)), 1e-6);
            region_point(&s.candidates[i].region, u, v, 0, q);
            square_normal(q, n);
            normalize3(n);
            /* Heights times slopes move hits by 4e-4 at most, and normals are interpolated. */
            assert_near(dot3(n, p.normals[hit->point]), 1, 1e-5);
        }
    }
    psplat_blend_points_free(&p);
    fixture_free(&s.f);
}

/* ---- whole conversions ----------------------------------------------------------------------- */

static void make_bowl(fixture *f) {
    fixture_grid(f, 8, 8, place_bowl);
    author_normals(&f->mesh, bowl_normal);
}

static psplat_splats convert(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                             psplat_report *report) {
    psplat_splats splats;
    psplat_error error;
    if (psplat_convert(mesh, desc, &splats, report, &error)) fail_msg("%s", error.text);
    return splats;
}

static const psplat_convert_desc usual = {
    .tolerance_percent = 0.2, .precision = PSPLAT_USUAL_PRECISION, .effort = PSPLAT_EFFORT_NONE};

/* Returns the number of splats with a field beside a shape. */
static size_t own_fields(const psplat_splats *splats) {
    size_t count = 0;
    for (size_t i = 0; i < splats->run_count; ++i)
        if (splats->runs[i].has_shape) count += splats->runs[i].count;
    return count;
}

/* Makes the fields of all curved splats those of their shapes. */
static void drop_fields(psplat_splats *splats) {
    psplat_region *regions = psplat_splat_regions(splats);
    assert_non_null(regions);
    for (size_t run = 0, i = 0; run < splats->run_count; ++run)
        for (size_t end = i + splats->runs[run].count; i < end; ++i) {
            if (!splats->runs[run].has_shape) continue;
            memcpy(splats->splats[i].gradient, splats->splats[i].shape + 2, 3 * sizeof(float));
            for (int k = 0; k < 3; ++k) splats->splats[i].normal[k] = (float)regions[i].n[k];
        }
    free(regions);
}

/* A smooth-shaded bowl of few polygons gets fields of its own. All promises are kept, and the
 * fields, as they are stored, take a fifth of the error at least, which is what they have to gain
 * to be chosen; the fit saw other points, for which 0.05 is allowed. */
static void test_bowl(void **state) {
    (void)state;
    fixture f;
    psplat_report with = {0}, without = {0};
    psplat_error error;
    make_bowl(&f);
    psplat_splats splats = convert(&f.mesh, &usual, &with);
    assert_int_equal(psplat_report_broken(&with), PSPLAT_PROMISE_COUNT);
    assert_true(own_fields(&splats) > 0);
    drop_fields(&splats);
    if (psplat_convert_verify(&f.mesh, &usual, &splats, &without, &error))
        fail_msg("%s", error.text);
    print_message("%zu splats, normals off by %.2f and without fields of their own by %.2f\n",
                  with.splats, with.rms_normal_degrees, without.rms_normal_degrees);
    assert_true(with.rms_normal_degrees < 0.85 * without.rms_normal_degrees);
    assert_true(with.max_distance_percent <= 0.2);
    psplat_splats_free(&splats);
    psplat_mesh_free(&f.mesh);
}

/* The number of threads does not matter. */
static void test_threads(void **state) {
    (void)state;
    fixture f;
    psplat_report report;
    make_bowl(&f);
    fixture_threads(1);
    psplat_splats one = convert(&f.mesh, &usual, &report);
    fixture_threads(3);
    psplat_splats three = convert(&f.mesh, &usual, &report);
    fixture_threads(0);
    assert_true(own_fields(&one) > 0);
    assert_int_equal(one.count, three.count);
    assert_memory_equal(one.splats, three.splats, one.count * sizeof *one.splats);
    psplat_splats_free(&one);
    psplat_splats_free(&three);
    psplat_mesh_free(&f.mesh);
}

/* Splats that are flat, of floats, with bounded or constant normals, or unlit have no fields beside
 * shapes; the same conversion without any of these has some. */
static void test_none(void **state) {
    (void)state;
    for (int i = 0; i < 6; ++i) {
        fixture f;
        psplat_report report;
        psplat_convert_desc desc = usual;
        make_bowl(&f);
        desc.tolerance_percent = 0.3; /* of constant normals a finer one takes many splats */
        desc.planar = i == 0;
        if (i == 1) desc.precision = 0;
        if (i == 2) desc.normal_tolerance_degrees = 30;
        desc.constant_normals = i == 3;
        f.mesh.material.unlit = i == 4;
        psplat_splats splats = convert(&f.mesh, &desc, &report);
        assert_int_equal(own_fields(&splats) > 0, i == 5);
        psplat_splats_free(&splats);
        psplat_mesh_free(&f.mesh);
    }
}

/* On a torus of many polygons, the surface's own normals are worth no bytes. */
static void test_fine_mesh(void **state) {
    (void)state;
    fixture f;
    psplat_report report;
    psplat_convert_desc desc = usual;
    desc.tolerance_percent = 0.5;
    fixture_model(&f, "torus.off");
    psplat_splats splats = convert(&f.mesh, &desc, &report);
    assert_int_equal(own_fields(&splats), 0);
    psplat_splats_free(&splats);
    fixture_free(&f);
}

int test_own_fields_main(void);
int test_own_fields_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one_field), cmocka_unit_test(test_no_gain),
        cmocka_unit_test(test_machined),  cmocka_unit_test(test_points),
        cmocka_unit_test(test_bowl),      cmocka_unit_test(test_threads),
        cmocka_unit_test(test_none),      cmocka_unit_test(test_fine_mesh)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

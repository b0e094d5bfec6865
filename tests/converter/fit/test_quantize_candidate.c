/* SPDX-License-Identifier: MIT
 *
 * test_quantize_candidate.c - tests of splats rounded to the grid of a file. They lie on the grid,
 * they keep their promises at every precision, and neither scale nor place of a model changes them.
 * Curved ones come nearer to the mesh where limits say so. The shapes are a part, a cone, a torus
 * and a thin plate.
 */
#include "mesh_fixture.h"

#include "stage_fixture.h"

#include "base/random.h"
#include "fit/candidate.h"
#include "fit/fit_context.h"
#include "fit/grow_candidate.h"
#include "fit/quantize_candidate.h"
#include "import/read_mesh.h"
#include "measure/measured_splats.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/octahedron.h"
#include "splats/quantize.h"
#include "splats/splats.h"
#include "verify/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <stdio.h>

static void read_model(const char *name, psplat_mesh *mesh) {
    psplat_error error;
    char path[512];
    snprintf(path, sizeof path, PSPLAT_SOURCE_DIR "/samples/models/%s", name);
    if (psplat_mesh_read(path, mesh, &error)) fail_msg("%s", error.text);
}

static psplat_splats convert(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                             psplat_report *report) {
    psplat_splats splats;
    psplat_error error;
    if (psplat_convert(mesh, desc, &splats, report, &error)) fail_msg("%s", error.text);
    return splats;
}

/* ---- promises ------------------------------------------------------------------------------ */

static void keeps_promises(const char *name, const psplat_convert_desc *desc) {
    psplat_mesh mesh;
    psplat_report report;
    read_model(name, &mesh);
    psplat_splats splats = convert(&mesh, desc, &report);
    assert_true(splats.precision.unit > 0);
    psplat_promise broken = psplat_report_broken(&report);
    if (broken != PSPLAT_PROMISE_COUNT)
        fail_msg("%s at %g %%, precision %g: promise %d, %g of %g", name, desc->tolerance_percent,
                 desc->precision, (int)broken, report.promises[broken].worst,
                 report.promises[broken].limit);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
}

/* The creases of the part meet at all angles, the cone has a tip, and the plate is about as thin as
 * the tolerance is wide. */
static void test_promises(void **state) {
    (void)state;
    static const struct {
        const char *name;
        double precision;
    } cases[] = {{"part.obj", 0.3},
                 {"cone.stl", PSPLAT_USUAL_PRECISION},
                 {"cone.stl", 0.3},
                 {"cone.stl", PSPLAT_GREATEST_PRECISION},
                 {"plate.stl", PSPLAT_USUAL_PRECISION},
                 {"plate.stl", 0.3}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        keeps_promises(cases[i].name, &(psplat_convert_desc){.tolerance_percent = 3,
                                                             .effort = PSPLAT_EFFORT_NONE,
                                                             .precision = cases[i].precision});
}

/* The normal tolerance is checked with rounded normals. */
static void test_normals(void **state) {
    (void)state;
    keeps_promises("sphere.ply", &(psplat_convert_desc){.tolerance_percent = 3,
                                                        .effort = PSPLAT_EFFORT_NONE,
                                                        .normal_tolerance_degrees = 8,
                                                        .precision = PSPLAT_USUAL_PRECISION});
}

/* ---- grid ---------------------------------------------------------------------------------- */

static void assert_same_code(const psplat_quantized_splat *a, const psplat_quantized_splat *b) {
    assert_memory_equal(a->position, b->position, sizeof a->position);
    assert_memory_equal(a->normal, b->normal, sizeof a->normal);
    assert_int_equal(a->turn, b->turn);
    assert_memory_equal(a->tilt, b->tilt, sizeof a->tilt);
    assert_memory_equal(a->scale, b->scale, sizeof a->scale);
    assert_memory_equal(a->field, b->field, sizeof a->field);
    assert_memory_equal(a->lines, b->lines, sizeof a->lines);
}

/* Rounding a splat that lies on the grid changes no bit. */
static void test_on_grid(void **state) {
    (void)state;
    psplat_mesh mesh;
    read_model("cone.stl", &mesh);
    const psplat_convert_desc desc = {.tolerance_percent = 2,
                                      .effort = PSPLAT_EFFORT_NONE,
                                      .unverified = 1,
                                      .precision = PSPLAT_USUAL_PRECISION};
    psplat_splats splats = convert(&mesh, &desc, NULL);
    size_t size = splats.count * sizeof *splats.splats, lines = 0;
    psplat_splat *before = malloc(size);
    assert_non_null(before);
    memcpy(before, splats.splats, size);
    psplat_round_to_precision(&splats);
    for (size_t i = 0; i < splats.count; ++i) {
        assert_memory_equal(&before[i], &splats.splats[i], sizeof *before);
        lines += before[i].clip_count;
    }
    assert_true(lines > 0);
    free(before);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
}

/* The precision of the limits rounds a region's lines and field as in the stored splat, so that a
 * candidate is evaluated as it will be stored. The test cuts the ellipse by random lines in all
 * directions. */
static void test_rounded_once(void **state) {
    (void)state;
    const psplat_precision precision = {.unit = 1e-3,
                                        .scale_step = 0.04,
                                        .turn_step = 1.0 / 256,
                                        .tilt_step = 1.0 / 64,
                                        .field_step = 1.0 / 64,
                                        .line_step = 1.0 / 256,
                                        .line_turn_step = 1.0 / 512,
                                        .normal_bits = 8};
    uint64_t random = 7;
    for (int i = 0; i < 1000; ++i) {
        double angle = 2 * fixture_pi * psplat_random_unit(&random), again[3], field[5], twice[5];
        double line[3] = {cos(angle), sin(angle), 1.9 * psplat_random_unit(&random) - 0.95},
               kept[3], bend = 0;
        memcpy(kept, line, sizeof kept);
        psplat_quantize_line(&precision, line, &bend);
        memcpy(again, line, sizeof again);
        psplat_quantize_line(&precision, again, &bend);
        /* in units of the ellipse */
        for (int k = 0; k < 3; ++k) assert_near(again[k], line[k], 1e-12);
        for (int k = 0; k < 64; ++k) { /* A point that was kept is not cut off. */
            double a = 2 * fixture_pi * k / 64, x = cos(a), y = sin(a);
            if (kept[0] * x + kept[1] * y + kept[2] >= 0)
                assert_true(line[0] * x + line[1] * y + line[2] >= -0.011 * precision.line_step);
        }
        for (int k = 0; k < 5; ++k) field[k] = 2 * psplat_random_unit(&random) - 1;
        memcpy(twice, field, sizeof twice);
        psplat_quantize_field(&precision, field);
        for (int k = 0; k < 5; ++k) assert_true(fabs(field[k] - twice[k]) <= 0.5001 / 64);
        memcpy(twice, field, sizeof twice);
        psplat_quantize_field(&precision, twice);
        assert_memory_equal(twice, field, sizeof field);
    }
}

/* ---- scale and place ----------------------------------------------------------------------- */

static const psplat_run flat = {.count = 1};

static void assert_same_codes(const psplat_splats *a, const psplat_splats *b) {
    assert_int_equal(a->count, b->count);
    for (size_t i = 0; i < a->count; ++i) {
        psplat_quantized_splat left, right;
        psplat_quantize_splat(&a->precision, &flat, &a->splats[i], &left);
        psplat_quantize_splat(&b->precision, &flat, &b->splats[i], &right);
        assert_same_code(&left, &right);
    }
}

/* A model scaled by a power of two has the same integers with another unit. */
static void test_scale(void **state) {
    (void)state;
    static const double scales[] = {0x1p-30, 0x1p30}; /* about 1e-9 and 1e9 */
    const psplat_convert_desc desc = {.tolerance_percent = 3,
                                      .effort = PSPLAT_EFFORT_NONE,
                                      .unverified = 1,
                                      .precision = PSPLAT_USUAL_PRECISION};
    psplat_mesh mesh;
    read_model("cone.stl", &mesh);
    psplat_splats splats = convert(&mesh, &desc, NULL);
    for (size_t k = 0; k < 2; ++k) {
        psplat_mesh scaled;
        read_model("cone.stl", &scaled);
        for (size_t i = 0; i < 3 * scaled.vertex_count; ++i) scaled.positions[i] *= scales[k];
        psplat_splats other = convert(&scaled, &desc, NULL);
        assert_near(other.precision.unit / scales[k], splats.precision.unit,
                    1e-5 * splats.precision.unit);
        assert_same_codes(&splats, &other);
        psplat_splats_free(&other);
        psplat_mesh_free(&scaled);
    }
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
}

/* A model far from the origin has the same integers with another origin. Offsets and vertices are
 * whole numbers, so that the file loses no digit of the vertices. */
static void test_place(void **state) {
    (void)state;
    static const double offsets[] = {0, 40960000.0};
    psplat_splats splats[2];
    for (int k = 0; k < 2; ++k) {
        char text[512];
        size_t used = 0;
        static const int corners[6][3] = {{4, 0, 0},  {-4, 0, 0}, {0, 3, 0},
                                          {0, -3, 0}, {0, 0, 2},  {0, 0, -2}};
        static const int faces[8][3] = {{1, 3, 5}, {3, 2, 5}, {2, 4, 5}, {4, 1, 5},
                                        {3, 1, 6}, {2, 3, 6}, {4, 2, 6}, {1, 4, 6}};
        for (int i = 0; i < 6; ++i)
            used += (size_t)snprintf(text + used, sizeof text - used, "v %.0f %.0f %.0f\n",
                                     corners[i][0] + offsets[k], corners[i][1] - offsets[k],
                                     corners[i][2] + offsets[k]);
        for (int i = 0; i < 8; ++i)
            used += (size_t)snprintf(text + used, sizeof text - used, "f %d %d %d\n", faces[i][0],
                                     faces[i][1], faces[i][2]);
        psplat_mesh mesh = read_text("far.obj", text);
        const psplat_convert_desc desc = {.tolerance_percent = 2,
                                          .effort = PSPLAT_EFFORT_NONE,
                                          .precision = PSPLAT_USUAL_PRECISION};
        psplat_report report;
        splats[k] = convert(&mesh, &desc, &report);
        assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
        psplat_mesh_free(&mesh);
    }
    assert_same_codes(&splats[0], &splats[1]);
    for (int k = 0; k < 2; ++k) psplat_splats_free(&splats[k]);
}

/* ---- the torus --------------------------------------------------------------------------------
 */

/* Samples the torus, and stores limits of a part of its diagonal and a fine grid. */
static void begin_torus(fixture *f, double part, psplat_limits *limits,
                        psplat_precision *precision) {
    fixture_model(f, "torus.off");
    fixture_sample(f, 0.01);
    double tolerance = part * f->surface.diagonal;
    *limits = (psplat_limits){.tolerance = tolerance,
                              .crease_tolerance = 0.5 * tolerance,
                              .crease_slack = 0.3 * tolerance,
                              .margin = 0.2 * f->samples.spacing,
                              .distance = f->distance};
    *precision = (psplat_precision){.unit = 0.02 * tolerance,
                                    .scale_step = 0.01,
                                    .turn_step = 1.0 / 1024,
                                    .tilt_step = 1.0 / 256,
                                    .field_step = 1.0 / 64,
                                    .shape_step = 1.0 / 256,
                                    .bend_step = 1.0 / 64,
                                    .line_step = 1.0 / 256,
                                    .line_turn_step = 1.0 / 512,
                                    .normal_bits = 12};
}

/* ---- grades ---------------------------------------------------------------------------------- */

/* Makes splats have coarser steps the smaller they are, from a radius on. */
static void add_grades(psplat_precision *precision, double radius) {
    precision->halving = (int)lrint(log(2) / precision->scale_step);
    precision->reference = (int)(log(radius / precision->unit) / precision->scale_step);
    precision->shape_grades = 3;
    precision->normal_grades = precision->normal_bits - 6;
}

/* Fails unless the axes and radii of a region are on the grid of its radii (spec 3.12). */
static void assert_graded(const psplat_precision *precision, const psplat_region *region) {
    const psplat_precision at = psplat_precision_at(precision, region->radius);
    double axes[3][3];
    int32_t code[2];
    psplat_octahedron_encode_coarsely(region->n, at.normal_bits, at.normal_shift, code);
    psplat_quantized_axes(&at, code, region->u, axes);
    for (int k = 0; k < 2; ++k) { /* in steps */
        double steps = log(region->radius[k] / at.unit) / at.scale_step;
        assert_near(steps, rint(steps), 1e-6);
    }
    assert_near(fabs(dot3(axes[0], region->u)), 1, 1e-9);
    assert_near(dot3(axes[2], region->n), 1, 1e-9);
}

/* Candidates are moved to the steps of the radii that they end with, whatever radii were tried
 * before. On so coarse a grid many have to try several, and one of a thousand would take the steps
 * of others if it could. */
static void test_graded(void **state) {
    (void)state;
    enum { COUNT = 3000 };
    fixture f;
    psplat_scratch scratch = {0};
    psplat_limits limits;
    psplat_precision precision;
    begin_torus(&f, 0.004, &limits, &precision);
    precision.unit = 0.35 * limits.tolerance;
    precision.scale_step = 0.04;
    precision.turn_step = 1.0 / 256;
    precision.shape_step = 1.0 / 64;
    precision.normal_bits = 8;
    add_grades(&precision, 0.2 * f.surface.diagonal);
    int smaller = 0;
    for (size_t i = 0; i < COUNT; ++i) {
        psplat_candidate c;
        limits.precision = NULL;
        const psplat_fit_context context = fixture_context(&f, &limits, &scratch);
        uint32_t seed = (uint32_t)(i * f.samples.count / COUNT);
        assert_int_equal(psplat_candidate_grow(&context, seed, &c), PSPLAT_OK);
        double before = c.region.radius[0];
        limits.precision = &precision;
        assert_int_equal(psplat_quantize_candidate(&context, &c), PSPLAT_OK);
        assert_graded(&precision, &c.region);
        smaller += c.region.radius[0] < before;
        psplat_candidate_free(&c);
    }
    assert_true(smaller > COUNT / 8);
    psplat_scratch_free(&scratch);
    fixture_free(&f);
}

/* ---- candidates that must stay whole --------------------------------------------------------- */

/* Grows candidates on the torus and moves them to a grid. Returns how many fit there; these cover
 * the samples that they did, and the others have not changed. */
static size_t move_whole(const fixture *f, psplat_limits limits, const psplat_precision *precision,
                         size_t count) {
    psplat_scratch scratch = {0};
    size_t fitting = 0;
    for (size_t i = 0; i < count; ++i) {
        psplat_candidate c;
        int fits;
        limits.precision = NULL;
        const psplat_fit_context context = fixture_context(f, &limits, &scratch);
        uint32_t seed = (uint32_t)(i * f->samples.count / count);
        assert_int_equal(psplat_candidate_grow(&context, seed, &c), PSPLAT_OK);
        const psplat_candidate before = c;
        limits.precision = precision;
        assert_int_equal(psplat_quantize_whole_candidate(&context, &c, &fits), PSPLAT_OK);
        assert_int_equal(c.covered_count, before.covered_count);
        if (!fits) assert_memory_equal(&c.region, &before.region, sizeof c.region);
        for (int k = 0; fits && k < 3; ++k) /* in units of the grid */
            assert_near(c.region.center[k] / precision->unit,
                        rint(c.region.center[k] / precision->unit), 1e-6);
        fitting += (size_t)fits;
        psplat_candidate_free(&c);
    }
    psplat_scratch_free(&scratch);
    return fitting;
}

/* Nearly all candidates fit on a fine grid, and few on one whose points are four
 * tolerances apart.
 */
static void test_whole(void **state) {
    (void)state;
    fixture f;
    psplat_limits limits;
    psplat_precision precision;
    begin_torus(&f, 0.01, &limits, &precision);
    double tolerance = limits.tolerance;
    assert_true(move_whole(&f, limits, &precision, 30) >= 24);
    precision.normal_bits = 4;
    precision.unit = 4 * tolerance;
    assert_true(move_whole(&f, limits, &precision, 30) <= 10);
    fixture_free(&f);
}

/* How far points of curved regions are outside of the mesh, in tolerances. */
typedef struct heights {
    double sum, outer_squares;
    size_t count;
} heights;

static void add_heights(const fixture *f, const psplat_region *region, double tolerance,
                        heights *h) {
    double points[PSPLAT_REGION_POINTS][3];
    uint32_t guess = PSPLAT_NONE, triangle;
    size_t count = psplat_region_points(region, points);
    for (size_t i = 0; i < count; ++i) {
        double nearest[3], way[3];
        assert_int_equal(
            psplat_distance_nearest(f->distance, points[i], &guess, nearest, &triangle), PSPLAT_OK);
        sub3(way, points[i], nearest);
        double height = dot3(way, f->surface.face_normals + 3 * (size_t)triangle) / tolerance;
        h->sum += height;
        if (height > 0) h->outer_squares += height * height;
    }
    h->count += count;
}

/* With a pull, surfaces come nearer to the mesh, the more so outside, beneath all of the ellipse.
 */
static void test_pull(void **state) {
    (void)state;
    enum { COUNT = 60 };
    fixture f;
    psplat_limits limits;
    psplat_precision precision;
    psplat_scratch scratch = {0};
    heights of[2] = {{.count = 0}};
    int fitting = 0;
    begin_torus(&f, 0.01, &limits, &precision);
    for (int i = 0; i < 2 * COUNT; ++i) {
        psplat_candidate c;
        int fits;
        limits.precision = NULL;
        const psplat_fit_context context = fixture_context(&f, &limits, &scratch);
        assert_int_equal(psplat_candidate_grow(
                             &context, (uint32_t)((size_t)(i / 2) * f.samples.count / COUNT), &c),
                         PSPLAT_OK);
        limits.precision = &precision;
        limits.mesh_pull = i % 2;
        assert_true(psplat_region_is_curved(&c.region));
        assert_int_equal(psplat_quantize_whole_candidate(&context, &c, &fits), PSPLAT_OK);
        fitting += fits;
        add_heights(&f, &c.region, limits.tolerance, &of[i % 2]);
        psplat_candidate_free(&c);
    }
    assert_true(fitting >= 1.6 * COUNT); /* The others stay as they are. */
    assert_int_equal(of[0].count, of[1].count);
    double count = (double)of[0].count, fall = (of[0].sum - of[1].sum) / count;
    print_message("mean squares outside %.4f -> %.4f, lower by %.4f\n", of[0].outer_squares / count,
                  of[1].outer_squares / count, fall);
    /* The surfaces have six numbers, so that they follow the pull in part. */
    assert_true(of[1].outer_squares < 0.87 * of[0].outer_squares);
    assert_true(fall > 0.03); /* It is 0.024 with equal pulls to both sides. */
    psplat_scratch_free(&scratch);
    fixture_free(&f);
}

/* A conversion whose fits use much of the tolerance asks for the pull. */
static void test_pull_of_conversion(void **state) {
    (void)state;
    fixture f;
    psplat_report report;
    psplat_measured_splats measured;
    heights h = {.count = 0};
    const psplat_convert_desc desc = {.tolerance_percent = 0.3,
                                      .effort = PSPLAT_EFFORT_NONE,
                                      .precision = PSPLAT_USUAL_PRECISION};
    fixture_model(&f, "torus.off");
    fixture_sample(&f, 0.02); /* which makes the tree that heights are asked from */
    psplat_splats splats = convert(&f.mesh, &desc, &report);
    double tolerance = 0.003 * f.surface.diagonal;
    assert_int_equal(psplat_measured_splats_create(&splats, tolerance, 0, &measured), PSPLAT_OK);
    for (size_t i = 0; i < measured.count; ++i)
        add_heights(&f, &measured.regions[i], tolerance, &h);
    print_message("%zu splats, mean height %.4f\n", measured.count, h.sum / (double)h.count);
    assert_true(h.sum < 0.11 * (double)h.count); /* It is 0.147 without, and 0.078 with it. */
    psplat_measured_splats_free(&measured);
    psplat_splats_free(&splats);
    fixture_free(&f);
}

/* ---- the last resort ------------------------------------------------------------------------- */

/* Candidates that cover no sample become small discs at their centres, with all of it within the
 * tolerance on the coarsest grid that is chosen, and on a fine one, where discs are smaller than
 * those for which places are searched at first. The torus deviates from its planes by less than
 * 1e-3 of the tolerance over so small discs. */
static void make_discs(double unit, int normal_bits, double size) {
    enum { DISCS = 500 };
    fixture f;
    psplat_scratch scratch = {0};
    fixture_model(&f, "torus.off");
    fixture_sample(&f, 0.01);
    double tolerance = 0.0003 * f.surface.diagonal;
    psplat_precision precision = {.unit = unit * tolerance,
                                  .scale_step = 0.04,
                                  .turn_step = 1.0 / 256,
                                  .normal_bits = normal_bits};
    double height = 0;
    add_grades(&precision, 4 * tolerance);
    const psplat_limits limits = {.tolerance = tolerance,
                                  .crease_tolerance = 0.5 * tolerance,
                                  .crease_slack = 0.3 * tolerance,
                                  .distance = f.distance,
                                  .precision = &precision};
    const psplat_fit_context context = fixture_context(&f, &limits, &scratch);
    for (size_t i = 0; i < DISCS; ++i) {
        size_t sample = i * f.samples.count / DISCS;
        psplat_candidate c = {.taken = 1, .triangle = f.samples.triangles[sample]};
        memcpy(c.region.center, f.samples.positions + 3 * sample, sizeof c.region.center);
        c.region.u[0] = c.region.v[1] = c.region.n[2] = 1;
        c.region.radius[0] = c.region.radius[1] = size * tolerance;
        assert_int_equal(psplat_quantize_candidate(&context, &c), PSPLAT_OK);
        fixture_assert_near(&c.region, f.distance, tolerance);
        assert_graded(&precision, &c.region);
        double way[3];
        sub3(way, c.region.center, f.samples.positions + 3 * sample);
        height += dot3(way, c.region.n) / tolerance / DISCS;
        psplat_candidate_free(&c);
    }
    print_message("discs lie %.3f tolerances too high\n", height);
    assert_true(fabs(height) < 0.4 * unit); /* Neither all too high nor all too low. */
    psplat_scratch_free(&scratch);
    fixture_free(&f);
}

static void test_discs(void **state) {
    (void)state;
    make_discs(0.35, 8, 2);
    make_discs(0.02, 12, 0.01);
}

int test_quantize_candidate_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_promises), cmocka_unit_test(test_normals),
        cmocka_unit_test(test_on_grid),  cmocka_unit_test(test_rounded_once),
        cmocka_unit_test(test_scale),    cmocka_unit_test(test_place),
        cmocka_unit_test(test_graded),   cmocka_unit_test(test_whole),
        cmocka_unit_test(test_pull),     cmocka_unit_test(test_pull_of_conversion),
        cmocka_unit_test(test_discs),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

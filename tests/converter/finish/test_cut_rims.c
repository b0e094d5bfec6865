/* SPDX-License-Identifier: MIT
 *
 * test_cut_rims.c - tests of cutting rims off where they show beside outlines: seen by parallel
 * rays, which know nothing of rims, outlines are narrower, and nothing opens.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "closing_fixture.h"
#include "base/random.h"
#include "finish/close_rays.h"
#include "finish/cut_rims.h"
#include "finish/trim_splats.h"
#include "measure/ray_meeting.h"

/* What parallel rays from several sides see. */
typedef struct view {
    size_t seen;    /* rays that meet the mesh */
    size_t missing; /* of these, those that meet no splat */
    size_t extra;   /* those that meet a splat and not the mesh */
} view;

static int meets_any(const closing *r, const psplat_sight *sight) {
    for (size_t i = 0; i < r->c.selection.count; ++i) {
        double height, uv[2];
        if (psplat_sight_meets(sight, &r->c.selection.candidates[i].region, 0, 0, &height, uv))
            return 1;
    }
    return 0;
}

static view look(const closing *r) {
    enum { VIEWS = 12, SIDE = 150 };
    const psplat_mesh *mesh = r->c.surface.mesh;
    double radius = r->c.diagonal / 2, middle[3] = {0, 0, 0};
    uint64_t random = 7;
    view v = {0};
    for (size_t i = 0; i < mesh->vertex_count; ++i)
        mad3(middle, 1 / (double)mesh->vertex_count, mesh->positions + 3 * i);
    for (int k = 0; k < VIEWS; ++k) {
        double z = 2 * psplat_random_unit(&random) - 1, a = 7 * psplat_random_unit(&random);
        double d[3] = {sqrt(1 - z * z) * cos(a), sqrt(1 - z * z) * sin(a), z}, x[3], y[3];
        perpendicular3(x, d);
        cross3(y, d, x);
        for (int i = 0; i < SIDE * SIDE; ++i) {
            psplat_sight sight = {{middle[0], middle[1], middle[2]}, {d[0], d[1], d[2]}};
            double from[3], to[3];
            int met;
            mad3(sight.point, radius * (2.0 * (i % SIDE) / SIDE - 1), x);
            mad3(sight.point, radius * (2.0 * (i / SIDE) / SIDE - 1), y);
            along3(from, sight.point, 2 * radius, d);
            along3(to, sight.point, -2 * radius, d);
            assert_int_equal(psplat_distance_meets(r->f.distance, from, to, &met), PSPLAT_OK);
            int drawn = meets_any(r, &sight);
            v.seen += (size_t)met;
            v.missing += met && !drawn;
            v.extra += !met && drawn;
        }
    }
    return v;
}

/* Returns how many samples no candidate is recorded to cover, and asserts that the candidates cover
 * those that they are recorded to. */
static size_t count_uncovered(const closing *r) {
    uint32_t *covers = psplat_selection_count_covers(&r->c.selection, r->c.samples.count);
    size_t uncovered = 0;
    assert_non_null(covers);
    for (size_t i = 0; i < r->c.samples.count; ++i) uncovered += !covers[i];
    free(covers);
    for (size_t i = 0; i < r->c.selection.count; ++i) {
        const psplat_candidate *candidate = &r->c.selection.candidates[i];
        for (size_t k = 0; k < candidate->covered_count; ++k) {
            size_t sample = candidate->covered[k];
            double uvh[3];
            psplat_region_local(&candidate->region, r->c.samples.positions + 3 * sample, uvh);
            /* The slack is what rounding may do. */
            assert_true(psplat_region_contains(&candidate->region, uvh, 1 + 1e-6, 1e-6));
        }
    }
    return uncovered;
}

/* Returns how many slanted rays pass between the splats as they are, and under their walls. */
static size_t count_open_rays(const closing *r) {
    size_t shown;
    return count_rays(r, copy_regions(r), 0.5, 99, &shown);
}

/* Asserts that a region has at most another line, out where a splat weighs little, and is as it was
 * but for that. Returns whether it has. */
static int check_line(const psplat_region *before, const psplat_region *after) {
    psplat_region expected = *before;
    int cut = after->line_count > before->line_count;
    if (cut) {
        const double *line = after->lines[before->line_count];
        assert_true(line[2] >= 0.8 * norm2(line[0], line[1]) - 1e-9);
        psplat_region_add_line(&expected, line, 0);
    }
    assert_memory_equal(&expected, after, sizeof expected);
    return cut;
}

/* Begins with splats that are trimmed, of the sphere stretched to the shape of a horn, or of a
 * model. */
static void begin(closing *r, const char *name, double tolerance, double spacing,
                  double precision) {
    fixture model;
    fixture_model(&model, name ? name : "sphere.ply");
    if (!name) {
        psplat_surface_free(&model.surface);
        for (size_t i = 0; i < 3 * model.mesh.vertex_count; ++i)
            if (i % 3) model.mesh.positions[i] *= 0.2;
        free(model.mesh.corner_normals);
        model.mesh.corner_normals = NULL;
        fixture_build(&model);
    }
    closing_begin_with(r, &model, tolerance, spacing, 0, precision);
    assert_int_equal(psplat_close_rays(&r->c, NULL), PSPLAT_OK);
    assert_int_equal(psplat_trim_splats(&r->c, NULL), PSPLAT_OK);
}

/* Returns how far a rim stands off that the last line of a region has cut off, a length. */
static double stand_off_beyond(const closing *r, const psplat_region *region) {
    enum { SIDES = 64 };
    double most = 0;
    for (int i = 0; i < SIDES; ++i) {
        const double uv[2] = {cos(2 * fixture_pi * i / SIDES), sin(2 * fixture_pi * i / SIDES)};
        double point[3], distance;
        if (psplat_region_line_value(region, region->line_count - 1, uv) >= 0) continue;
        psplat_region_point(region, uv, point);
        assert_int_equal(psplat_distance_query(r->f.distance, point, 1, &distance), PSPLAT_OK);
        most = fmax(most, distance);
    }
    return most;
}

/* A horn: a quarter of the splats at most are cut, outlines have less too much, and over all cases
 * err less, samples stay covered, and hardly more rays pass. */
static void test_horn(void **state) {
    (void)state;
    static const double cases[][3] = {/* tolerance, spacing, precision */
                                      {0.005, 0.01, 0},
                                      {0.005, 0.01, 0.1},
                                      {0.002, 0.006, 0},
                                      {0.002, 0.006, 0.1}};
    size_t errors[2] = {0, 0};    /* before and after */
    size_t opened[2] = {0, 0};    /* rays that pass, before and after */
    double stand_off[2] = {0, 0}; /* beyond lines, and at the other sides of splats, tolerances */
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        closing r;
        begin(&r, NULL, cases[i][0], cases[i][1], cases[i][2]);
        size_t count = r.c.selection.count, cut = 0, open = count_open_rays(&r);
        size_t uncovered = count_uncovered(&r);
        const view before = look(&r);
        psplat_region *old = copy_regions(&r);
        size_t *recorded = malloc((count + 1) * sizeof *recorded);
        assert_non_null(recorded);
        for (size_t k = 0; k < count; ++k) recorded[k] = r.c.selection.candidates[k].covered_count;
        assert_int_equal(psplat_cut_rims(&r.c), PSPLAT_OK);
        const view after = look(&r);
        size_t now = count_open_rays(&r);
        assert_int_equal(r.c.selection.count, count);
        for (size_t k = 0; k < count; ++k) {
            const psplat_candidate *candidate = &r.c.selection.candidates[k];
            int is_cut = check_line(&old[k], &candidate->region);
            cut += (size_t)is_cut;
            if (!is_cut) {
                assert_int_equal(candidate->covered_count, recorded[k]);
                continue;
            }
            psplat_region mirrored = candidate->region;
            double *line = mirrored.lines[mirrored.line_count - 1];
            line[0] = -line[0], line[1] = -line[1];
            stand_off[0] += stand_off_beyond(&r, &candidate->region) / r.c.tolerance;
            stand_off[1] += stand_off_beyond(&r, &mirrored) / r.c.tolerance;
        }
        free(recorded);
        print_message("%zu of %zu cut, %zu rays seen, extra %zu -> %zu, missing %zu -> %zu, open "
                      "%zu -> %zu\n",
                      cut, count, before.seen, before.extra, after.extra, before.missing,
                      after.missing, open, now);
        assert_true(cut > 0 && 4 * cut <= count);
        assert_true(after.extra < before.extra);
        errors[0] += before.extra + before.missing;
        errors[1] += after.extra + after.missing;
        opened[0] += open;
        opened[1] += now;
        assert_int_equal(count_uncovered(&r), uncovered);
        free(old);
        closing_end(&r);
    }
    /* The rays of the stage are others; 480,000 are tried in each case. */
    assert_true(opened[1] <= opened[0] + opened[0] / 8 + 4);
    /* A rim that is gone may leave one that is too far inside, so that single horns may lose. */
    print_message("errors of outlines %zu -> %zu\n", errors[0], errors[1]);
    assert_true(100 * errors[1] < 99 * errors[0]);
    print_message("stand-off beyond lines %.2f, at other sides %.2f\n", stand_off[0], stand_off[1]);
    assert_true(stand_off[0] > stand_off[1]);
}

/* What is cut off of the splats of a part stands off: those of its flat faces stay as they are. */
static void test_part(void **state) {
    (void)state;
    closing r;
    size_t kept = 0;
    begin(&r, "part.obj", 0.005, 0.01, 0.1);
    psplat_region *old = copy_regions(&r);
    assert_int_equal(psplat_cut_rims(&r.c), PSPLAT_OK);
    for (size_t i = 0; i < r.c.selection.count; ++i) {
        const psplat_region *region = &r.c.selection.candidates[i].region;
        if (check_line(&old[i], region))
            assert_true(stand_off_beyond(&r, region) > 0.2 * r.c.tolerance);
        else
            ++kept;
    }
    assert_true(4 * kept >= 3 * r.c.selection.count);
    free(old);
    closing_end(&r);
}

static psplat_result cut(closing *r) {
    return psplat_cut_rims(&r->c);
}

/* The result does not depend on the number of threads. */
static void test_threads(void **state) {
    (void)state;
    check_threads(cut);
}

int test_cut_rims_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_horn),
        cmocka_unit_test(test_part),
        cmocka_unit_test(test_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_mend_creases.c - tests of splats that reach too far over creases: on a cube whose splats
 * lost their lines, none does so afterwards, and fresh samples find nothing open. What such a splat
 * alone covers it keeps. Where all end at the edges, or show nothing but their own material beyond
 * them, nothing changes.
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
#include "base/region_tree.h"
#include "features/samples.h"
#include "fit/fit_context.h"
#include "measure/crease_crossings.h"
#include "measure/measured_splats.h"
#include "select/conversion.h"
#include "select/fill_holes.h"
#include "select/greedy_cover.h"
#include "finish/mend_creases.h"
#include "select/selection.h"
#include "splats/splats.h"

typedef struct mended {
    fixture f;
    psplat_convert_desc desc;
    psplat_conversion c;
    psplat_splats splats;
} mended;

/* Covers the mesh of a fixture with splats that end at its creases and borders. */
static void cover(mended *r, double spacing, double tolerance) {
    fixture_sample(&r->f, spacing);
    r->c = (psplat_conversion){.desc = &r->desc,
                               .surface = r->f.surface,
                               .samples = r->f.samples,
                               .distance = r->f.distance,
                               .splats = &r->splats,
                               .tolerance = tolerance,
                               .limits = {.tolerance = 0.98 * tolerance,
                                          .crease_tolerance = 0.5 * tolerance,
                                          .crease_slack = 0.3 * tolerance,
                                          .distance = r->f.distance}};
    const psplat_fit_context context = psplat_conversion_context(&r->c);
    assert_int_equal(psplat_greedy_cover(&context, &r->desc, &r->c.selection, NULL), PSPLAT_OK);
    psplat_selection_drop_untaken(&r->c.selection);
    assert_int_equal(psplat_fill_holes(&r->c, NULL), PSPLAT_OK);
    psplat_selection_drop_untaken(&r->c.selection);
}

/* Covers the cube, of diagonal sqrt(3). */
static void begin(mended *r) {
    *r = (mended){0};
    fixture_model(&r->f, "cube.off");
    cover(r, 0.02, 0.005 * r->f.surface.diagonal);
}

static void end(mended *r) {
    psplat_splats_free(&r->splats);
    psplat_selection_free(&r->c.selection);
    psplat_hole_memory_free(&r->c.hole_memory);
    r->f.samples = r->c.samples;
    fixture_free(&r->f);
}

/* Returns how many creases lie deeper than the tolerance in splats of their own sheet. Stores how
 * many of 50,000 fresh samples no splat covers. */
static size_t count_crossings(const mended *r, size_t *open) {
    enum { PROBES = 50000 };
    const psplat_selection *s = &r->c.selection;
    psplat_measured_splats measured = {.count = s->count, .tolerance = r->c.tolerance};
    psplat_crease_crossing *crossings;
    psplat_samples probes;
    size_t count;
    double greatest;
    measured.regions = malloc(s->count * sizeof *measured.regions);
    assert_non_null(measured.regions);
    for (size_t i = 0; i < s->count; ++i) measured.regions[i] = s->candidates[i].region;
    measured.region_tree = psplat_region_tree_create(measured.regions, s->count,
                                                     PSPLAT_STEEPEST_REACH * measured.tolerance);
    assert_non_null(measured.region_tree);
    assert_int_equal(psplat_samples_draw_uniform(&r->c.surface, PROBES, 7, &probes, NULL),
                     PSPLAT_OK);
    assert_int_equal(psplat_crease_crossings_find(&r->c.surface, &probes, &measured, r->c.tolerance,
                                                  1, &crossings, &count, &greatest),
                     PSPLAT_OK);
    *open = 0;
    for (size_t i = 0; i < probes.count; ++i) {
        int covered = 0;
        for (uint32_t k = 0; k < s->count && !covered; ++k) {
            double uvh[3], n[3];
            for (int c = 0; c < 3; ++c) n[c] = (double)probes.normals[3 * i + (size_t)c];
            psplat_region_local(&measured.regions[k], probes.positions + 3 * i, uvh);
            covered = psplat_measured_splats_cover(&measured, k, n, uvh);
        }
        *open += !covered;
    }
    psplat_samples_free(&probes);
    free(crossings);
    psplat_measured_splats_free(&measured);
    return count;
}

/* Returns a copy of the regions of all candidates, which the caller frees. */
static psplat_region *regions_of(const mended *r) {
    const psplat_selection *selection = &r->c.selection;
    psplat_region *regions = malloc(selection->count * sizeof *regions);
    assert_non_null(regions);
    for (size_t i = 0; i < selection->count; ++i) regions[i] = selection->candidates[i].region;
    return regions;
}

/* Splats that lost their lines reach far over the edges, until they have been mended. */
static void test_lost_lines(void **state) {
    (void)state;
    mended r;
    size_t open;
    begin(&r);
    for (size_t i = 0; i < r.c.selection.count; i += 2)
        r.c.selection.candidates[i].region.line_count = 0;
    assert_true(count_crossings(&r, &open) > 0);
    assert_int_equal(psplat_mend_creases(&r.c, NULL), PSPLAT_OK);
    assert_int_equal(count_crossings(&r, &open), 0);
    assert_int_equal(open, 0);
    end(&r);
}

/* Splats that end at the edges stay as they are. */
static void test_whole(void **state) {
    (void)state;
    mended r;
    size_t open;
    begin(&r);
    size_t count = r.c.selection.count;
    psplat_region *regions = regions_of(&r);
    assert_int_equal(count_crossings(&r, &open), 0);
    assert_int_equal(psplat_mend_creases(&r.c, NULL), PSPLAT_OK);
    assert_int_equal(r.c.selection.count, count);
    for (size_t i = 0; i < count; ++i)
        assert_memory_equal(&regions[i], &r.c.selection.candidates[i].region, sizeof *regions);
    free(regions);
    end(&r);
}

/* A splat beside a crease that no line could cut from it gets smaller, and others take its place.
 */
static void test_shrinks(void **state) {
    (void)state;
    mended r;
    size_t open;
    begin(&r);
    psplat_region *region = &r.c.selection.candidates[0].region;
    const double width = region->radius[0];
    region->line_count = 0;
    region->radius[0] *= 3; /* beyond the cube */
    assert_true(count_crossings(&r, &open) > 0);
    assert_int_equal(psplat_mend_creases(&r.c, NULL), PSPLAT_OK);
    assert_int_equal(count_crossings(&r, &open), 0);
    assert_int_equal(open, 0);
    for (size_t i = 0; i < r.c.selection.count; ++i)
        assert_true(r.c.selection.candidates[i].region.radius[0] < 2.9 * width);
    end(&r);
}

/* Returns the place in a candidate's list of the sample that is farthest from its centre, in radii.
 */
static size_t farthest(const mended *r, const psplat_candidate *candidate) {
    double most = -1;
    size_t found = 0;
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        double uvh[3];
        psplat_region_local(&candidate->region,
                            r->c.samples.positions + 3 * (size_t)candidate->covered[i], uvh);
        double away2 = uvh[0] * uvh[0] + uvh[1] * uvh[1];
        if (away2 > most) most = away2, found = i;
    }
    return found;
}

/* A splat that reaches over all edges of a side of the cube, at a corner of which it alone covers a
 * sample, shrinks towards that: none has to grow there in its place, which would be as large. */
static void test_keeps_own(void **state) {
    (void)state;
    mended r;
    size_t open;
    begin(&r);
    psplat_candidate *first = &r.c.selection.candidates[0], own;
    double radius = first->region.radius[0];
    size_t count = r.c.selection.count, at = farthest(&r, first);
    uint32_t sample = first->covered[at];
    assert_true(psplat_candidate_copy(first, &own));
    first->covered[at] = first->covered[--first->covered_count];
    own.covered[0] = sample, own.covered_count = 1;
    own.region.line_count = 0;
    assert_true(psplat_selection_push(&r.c.selection, &own));
    assert_true(count_crossings(&r, &open) > 0);
    assert_int_equal(psplat_mend_creases(&r.c, NULL), PSPLAT_OK);
    assert_int_equal(count_crossings(&r, &open), 0);
    assert_int_equal(r.c.selection.count, count + 1);
    assert_true(r.c.selection.candidates[count].region.radius[0] < 0.9 * radius);
    end(&r);
}

/* A square, and above the half of it where x < 0 another one, of which the splats end at x = 0. The
 * bridge between them is as good as none. */
static void place_lid(double s, double t, double p[3]) {
    int column = (int)(3 * s + 0.5);
    p[0] = column == 3 ? 0 : column == 1 ? 1 : -1;
    p[1] = 2 * t - 1;
    p[2] = column < 2 ? 0 : 0.01;
}

/* Without its lines a splat of the upper square reaches over the lower one, which shows as much. It
 * stays as it is where both are of the second of two materials, but not where the lower one is of
 * the first. */
static void test_own_material(void **state) {
    (void)state;
    psplat_source_material materials[2] = {{.material = {.base_color = {1, 0, 0, 1}}},
                                           {.material = {.base_color = {0, 1, 0, 1}}}};
    for (uint32_t lower = 0; lower < 2; ++lower) {
        mended r = {0};
        uint32_t groups[] = {lower, lower, 1, 1};
        fixture_grid(&r.f, 3, 1, place_lid);
        memcpy(r.f.mesh.triangles + 6, r.f.mesh.triangles + 12, 6 * sizeof(uint32_t));
        r.f.mesh.triangle_count = 4;
        r.f.mesh.groups = groups;
        r.f.mesh.source_materials = materials, r.f.mesh.source_material_count = 2;
        fixture_build(&r.f);
        cover(&r, 0.05, 0.03);
        size_t count = r.c.selection.count;
        for (size_t i = 0; i < count; ++i) {
            psplat_candidate *candidate = &r.c.selection.candidates[i];
            if (candidate->triangle < 2) continue;
            candidate->region.line_count = 0;
            candidate->region.center[0] = -0.3;
            candidate->region.radius[0] = candidate->region.radius[1] = 0.5;
        }
        psplat_region *regions = regions_of(&r);
        assert_int_equal(psplat_mend_creases(&r.c, NULL), PSPLAT_OK);
        int same = r.c.selection.count == count;
        for (size_t i = 0; i < count && same; ++i)
            same = !memcmp(&regions[i], &r.c.selection.candidates[i].region, sizeof *regions);
        assert_int_equal(same, lower == 1);
        free(regions);
        r.f.mesh.groups = NULL;
        r.f.mesh.source_materials = NULL, r.f.mesh.source_material_count = 0;
        end(&r);
    }
}

/* Of splats whose lines have been moved out, those that reach too far over creases now get their
 * old regions back, and the others keep what they have. */
static void test_taken_back(void **state) {
    (void)state;
    mended r;
    size_t open;
    begin(&r);
    size_t count = r.c.selection.count;
    psplat_region *regions = regions_of(&r);
    assert_true(count >= 2);
    for (size_t i = 0; i < count; ++i) {
        psplat_region *region = &r.c.selection.candidates[i].region;
        double reach = (i % 2 ? 0.5 : 3) * r.c.tolerance; /* 3 tolerances are too far */
        for (uint32_t k = 0; k < region->line_count; ++k)
            region->lines[k][2] += reach / region->radius[1];
    }
    assert_true(count_crossings(&r, &open) > 0);
    assert_int_equal(psplat_take_back_crossings(&r.c, regions), PSPLAT_OK);
    assert_int_equal(count_crossings(&r, &open), 0);
    for (size_t i = 0; i < count; ++i) {
        int is_old = !memcmp(&regions[i], &r.c.selection.candidates[i].region, sizeof *regions);
        assert_int_equal(is_old, regions[i].line_count == 0 || i % 2 == 0);
    }
    free(regions);
    end(&r);
}

int test_mend_creases_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lost_lines),   cmocka_unit_test(test_whole),
        cmocka_unit_test(test_shrinks),      cmocka_unit_test(test_keeps_own),
        cmocka_unit_test(test_own_material), cmocka_unit_test(test_taken_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_sort_splats.c - tests of storing candidates as splats and reading them back: rotations,
 * normals, clip lines, and the order in a file. Expected values are the candidates themselves and
 * the Morton order of their centres.
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
#include "select/selection.h"
#include "select/sort_splats.h"
#include "splats/splats.h"

/* Rounding to float, twice each: of the quaternion and of the vectors that it rotates. */
static const double single = 4 * 0x1p-24;

static const psplat_sort_desc coloured = {.has_color = 1}, plain;

static psplat_splats store(psplat_candidate *candidates, size_t count) {
    psplat_splats splats = {0};
    psplat_selection selection = {candidates, count, count};
    assert_int_equal(psplat_sort_splats(&selection, &coloured, &splats), PSPLAT_OK);
    assert_int_equal(splats.count, count);
    return splats;
}

/* Stores one candidate with these axes, and compares the axes that come back. */
static void check_axes(const double u[3], const double v[3], const double n[3]) {
    psplat_candidate candidate = {.region = {.radius = {2, 1}}, .taken = 1};
    memcpy(candidate.region.u, u, 3 * sizeof(double));
    memcpy(candidate.region.v, v, 3 * sizeof(double));
    memcpy(candidate.region.n, n, 3 * sizeof(double));
    psplat_splats splats = store(&candidate, 1);
    const float *q = splats.splats->rotation;
    double length = 0;
    for (int k = 0; k < 4; ++k) length += (double)q[k] * (double)q[k];
    assert_near(length, 1, single);
    assert_true(q[3] >= 0);
    psplat_region *region = psplat_splat_regions(&splats);
    assert_non_null(region);
    for (int k = 0; k < 3; ++k) {
        assert_near(region->u[k], u[k], single);
        assert_near(region->v[k], v[k], single);
        assert_near(region->n[k], n[k], single);
    }
    free(region);
    psplat_splats_free(&splats);
}

/* Checks axes that are turned by an angle about a unit axis (Rodrigues' formula). */
static void check_turn(const double axis[3], double angle) {
    double axes[3][3];
    for (int i = 0; i < 3; ++i) {
        double e[3] = {0, 0, 0}, across[3];
        e[i] = 1;
        cross3(across, axis, e);
        for (int k = 0; k < 3; ++k)
            axes[i][k] = cos(angle) * e[k] + sin(angle) * across[k] +
                         (1 - cos(angle)) * dot3(axis, e) * axis[k];
    }
    check_axes(axes[0], axes[1], axes[2]);
}

static void test_rotations(void **state) {
    (void)state;
    uint64_t random = 21;
    for (int i = 0; i < 500; ++i) {
        double u[3], v[3], n[3];
        random_axes(&random, u, v, n);
        check_axes(u, v, n);
        /* Turns about random axes by just less or more than half a turn, where w changes its sign.
         */
        const double beside[] = {0, 1e-3, -1e-3, 1e-7, -1e-7, 1e-15};
        for (size_t k = 0; k < sizeof beside / sizeof *beside; ++k)
            check_turn(n, fixture_pi + beside[k]);
        check_turn(n, 1e-9);
    }
}

/* The 24 rotations of a cube have components, such as w, that are exactly zero or equal. */
static void test_cube_rotations(void **state) {
    (void)state;
    size_t turns = 0;
    for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 6; ++k) {
            double u[3] = {0, 0, 0}, v[3] = {0, 0, 0}, n[3];
            u[i / 2] = i % 2 ? -1 : 1;
            v[k / 2] = k % 2 ? -1 : 1;
            if (i / 2 == k / 2) continue;
            cross3(n, u, v);
            check_axes(u, v, n);
            ++turns;
        }
    assert_int_equal(turns, 24);
}

static void random_candidate(psplat_candidate *c, uint64_t *random) {
    *c = (psplat_candidate){.region = {.radius = {0}}, .taken = 1};
    psplat_region *r = &c->region;
    random_axes(random, r->u, r->v, r->n);
    for (int k = 0; k < 3; ++k) r->center[k] = 2 * psplat_random_unit(random) - 1;
    r->radius[1] = 0.1 + psplat_random_unit(random);
    r->radius[0] = r->radius[1] + psplat_random_unit(random);
    for (int k = 0; k < 4; ++k) c->field[k] = 2 * psplat_random_unit(random) - 1;
    for (int k = 0; k < 4; ++k) c->color[k] = (float)psplat_random_unit(random);
    r->line_count = (uint32_t)(psplat_random_next(random) % 5);
    for (uint32_t i = 0; i < r->line_count; ++i) {
        double angle = 2 * fixture_pi * psplat_random_unit(random);
        r->lines[i][0] = cos(angle), r->lines[i][1] = sin(angle);
        r->lines[i][2] = 2 * psplat_random_unit(random) - 1;
    }
}

static void compare(const psplat_candidate *c, const psplat_region *back, const psplat_splat *s) {
    const psplat_region *r = &c->region;
    for (int k = 0; k < 3; ++k) assert_near(back->center[k], r->center[k], single);
    for (int k = 0; k < 2; ++k) assert_near(back->radius[k], r->radius[k], 2 * single);
    assert_int_equal(back->line_count, r->line_count);
    for (uint32_t i = 0; i < PSPLAT_MAX_CLIP_LINES; ++i)
        for (int k = 0; k < 3; ++k) {
            if (i < r->line_count)
                assert_near(back->lines[i][k], r->lines[i][k], single);
            else
                assert_true(s->clip[i][k] == 0); /* No line of an earlier splat is left. */
        }
    double n[3] = {(double)s->normal[0], (double)s->normal[1], (double)s->normal[2]};
    /* The stored normal determines x and y by spec 3.5; |field| < 1, so that the division loses
     * little. */
    assert_near(length3(n), 1, single);
    assert_near(dot3(n, r->u) / dot3(n, r->n), c->field[0], 8 * single);
    assert_near(dot3(n, r->v) / dot3(n, r->n), c->field[1], 8 * single);
    for (int k = 0; k < 3; ++k) assert_near((double)s->gradient[k], c->field[2 + k], single);
    assert_memory_equal(s->color, c->color, sizeof c->color);
}

static void test_round_trip(void **state) {
    (void)state;
    enum { COUNT = 200 };
    static psplat_candidate candidates[COUNT];
    uint64_t random = 22;
    size_t classes[PSPLAT_MAX_CLIP_LINES + 1] = {0}, matched = 0;
    for (int i = 0; i < COUNT; ++i) {
        random_candidate(&candidates[i], &random);
        classes[candidates[i].region.line_count]++;
    }
    psplat_splats splats = store(candidates, COUNT);
    psplat_region *back = psplat_splat_regions(&splats);
    assert_non_null(back);
    assert_int_equal(splats.has_color, 1);
    assert_int_equal(splats.run_count, PSPLAT_MAX_CLIP_LINES + 1);
    for (uint32_t k = 0; k <= PSPLAT_MAX_CLIP_LINES; ++k) {
        assert_int_equal(splats.runs[k].clip_lines, k);
        assert_int_equal(splats.runs[k].count, classes[k]);
    }
    for (size_t i = 0; i < COUNT; ++i) {
        if (i) assert_true(splats.splats[i].clip_count >= splats.splats[i - 1].clip_count);
        for (size_t k = 0; k < COUNT; ++k) {
            double d[3];
            sub3(d, back[i].center, candidates[k].region.center);
            if (length3(d) > 1e-6) continue;
            compare(&candidates[k], &back[i], &splats.splats[i]);
            ++matched;
        }
    }
    assert_int_equal(matched, COUNT);
    free(back);
    psplat_splats_free(&splats);
}

/* Compares all lines of a region, seams behind those that cut, with those that come back. */
static void compare_seams(const psplat_region *r, const psplat_region *back) {
    assert_int_equal(back->line_count, r->line_count);
    assert_int_equal(back->seam_count, r->seam_count);
    for (uint32_t i = 0; i < r->line_count + r->seam_count; ++i) {
        for (int k = 0; k < 3; ++k) assert_near(back->lines[i][k], r->lines[i][k], single);
        assert_near(back->bends[i], r->bends[i], single);
    }
}

/* Seams come back with their bends, behind the lines that cut. Splats are sorted by all of their
 * lines, and then by their seams, and runs tell the number of both. */
static void test_seams(void **state) {
    (void)state;
    enum { COUNT = 200 };
    static psplat_candidate candidates[COUNT];
    uint64_t random = 23;
    size_t matched = 0;
    for (int i = 0; i < COUNT; ++i) {
        random_candidate(&candidates[i], &random);
        psplat_region *r = &candidates[i].region;
        for (uint32_t k = 0; k < r->line_count; ++k) r->bends[k] = psplat_random_unit(&random);
        r->seam_count = (uint32_t)(psplat_random_next(&random) % (r->line_count + 1));
        r->line_count -= r->seam_count;
    }
    psplat_splats splats = store(candidates, COUNT);
    psplat_region *back = psplat_splat_regions(&splats);
    assert_non_null(back);
    assert_int_equal(splats.run_count, 15); /* 0 ... n seams of n lines, which are 0 ... 4 */
    for (size_t run = 0, i = 0; run < splats.run_count; ++run) {
        const psplat_run *r = &splats.runs[run];
        if (run)
            assert_true(8 * r->clip_lines + r->seam_lines >
                        8 * r[-1].clip_lines + r[-1].seam_lines);
        for (size_t end = i + r->count; i < end; ++i)
            assert_int_equal(splats.splats[i].clip_count, r->clip_lines);
    }
    for (size_t i = 0; i < COUNT; ++i)
        for (size_t k = 0; k < COUNT; ++k) {
            double d[3];
            sub3(d, back[i].center, candidates[k].region.center);
            if (length3(d) > 1e-6) continue;
            compare_seams(&candidates[k].region, &back[i]);
            ++matched;
        }
    assert_int_equal(matched, COUNT);
    free(back);
    psplat_splats_free(&splats);
}

/* Inside a class, centres on a grid of 8^3 come in Morton order: x is the lowest bit of each group
 * of three. */
static void test_morton(void **state) {
    (void)state;
    enum { SIDE = 8, COUNT = SIDE * SIDE * SIDE };
    static psplat_candidate candidates[2 * COUNT];
    const double scales[] = {1, 1e-9, 1e9, 1e-37, 1e37};
    for (size_t s = 0; s < sizeof scales / sizeof *scales; ++s) {
        for (uint32_t i = 0; i < 2 * COUNT; ++i) {
            /* 3001 is coprime to COUNT, so that each place occurs once, out of order. */
            uint32_t at = i * 3001 % COUNT;
            psplat_region r = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {1, 1}};
            for (int k = 0; k < 3; ++k) r.center[k] = scales[s] * ((double)(at >> 3 * k & 7) - 3);
            r.line_count = i < COUNT ? 2 : 0;
            r.lines[0][0] = r.lines[1][1] = 1;
            candidates[i] = (psplat_candidate){.region = r, .taken = 1};
        }
        psplat_splats splats = store(candidates, 2 * COUNT);
        assert_int_equal(splats.run_count, 2);
        assert_int_equal(splats.runs[0].count, COUNT);
        assert_int_equal(splats.runs[1].count, COUNT);
        for (uint32_t i = 0; i < 2 * COUNT; ++i) {
            uint32_t code = 0;
            for (int k = 0; k < 3; ++k) {
                double x = (double)splats.splats[i].center[k] / scales[s] + 3;
                uint32_t cell = (uint32_t)(x + 0.5);
                for (int bit = 0; bit < 3; ++bit) code |= (cell >> bit & 1) << (3 * bit + k);
            }
            assert_int_equal(code, i % COUNT);
        }
        psplat_splats_free(&splats);
    }
}

/* Splats are grouped in runs of equal number of clip lines, depth tolerance and material, each with
 * these values. */
static void test_runs(void **state) {
    (void)state;
    enum { COUNT = 12 };
    static const uint32_t groups[] = {1, 0, 2};
    psplat_candidate candidates[COUNT];
    for (uint32_t i = 0; i < COUNT; ++i) {
        candidates[i] = (psplat_candidate){
            .region = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {1, 1}},
            .triangle = i % 3,
            .is_flat = (int)(i / 3 % 2),
            .taken = 1};
        if (i >= 6) candidates[i].region.line_count = 1, candidates[i].region.lines[0][0] = 1;
    }
    psplat_splats splats = {0};
    psplat_selection selection = {candidates, COUNT, COUNT};
    const psplat_sort_desc storing = {
        .depth_tolerance = 1, .flat_depth_tolerance = 0.1f, .groups = groups};
    assert_int_equal(psplat_sort_splats(&selection, &storing, &splats), PSPLAT_OK);
    assert_int_equal(splats.run_count, COUNT);
    for (uint32_t i = 0; i < COUNT; ++i) {
        const psplat_run *run = &splats.runs[i];
        assert_int_equal(run->count, 1);
        assert_int_equal(run->clip_lines, i / 6);
        assert_int_equal(run->material, i % 3);
        assert_true(run->depth_tolerance == (i / 3 % 2 ? 1 : 0.1f));
    }
    psplat_splats_free(&splats);
}

/* Texture coordinates stay with their splats. Runs tell whether their material keeps textures, and
 * whether any of their splats has the second order. */
static void test_texcoords(void **state) {
    (void)state;
    enum { COUNT = 6 };
    static const uint32_t groups[] = {2, 1, 0};
    /* The third is a ramp of colours along t: its coordinates count, though s shows no texels. */
    const psplat_kept_textures kept[3] = {{.textures = {{.image = 1}}, .texels = {8, 8}},
                                          {.texels = {0}},
                                          {.textures = {{.image = 2}}, .texels = {0, 8}}};
    psplat_candidate candidates[COUNT];
    for (uint32_t i = 0; i < COUNT; ++i)
        candidates[i] = (psplat_candidate){
            .region =
                {.center = {i}, .u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {1, 1}},
            .texcoord = {.at = {(float)i, 1}, .along_vv = {0, i == 3 ? 1.0f : 0}},
            .triangle = i % 3,
            .taken = 1};
    psplat_splats splats = {0};
    psplat_selection selection = {candidates, COUNT, COUNT};
    const psplat_sort_desc storing = {.groups = groups, .kept = kept};
    assert_int_equal(psplat_sort_splats(&selection, &storing, &splats), PSPLAT_OK);
    assert_int_equal(splats.run_count, 3);
    for (uint32_t r = 0; r < 3; ++r) {
        assert_int_equal(splats.runs[r].material, r);
        assert_int_equal(splats.runs[r].has_texcoord, r != 1);
        assert_int_equal(splats.runs[r].has_texcoord_bend, r == 2); /* that of candidate 3 */
    }
    for (uint32_t i = 0; i < COUNT; ++i)
        assert_true(splats.texcoords[i].at[0] == splats.splats[i].center[0]);
    const psplat_sort_desc none = {.groups = groups};
    assert_int_equal(psplat_sort_splats(&selection, &none, &splats), PSPLAT_OK);
    assert_null(splats.texcoords);
    assert_int_equal(splats.runs[0].has_texcoord, 0);
    psplat_splats_free(&splats);
}

/* Returns a candidate in a plane of its own, whose field is that of its surface. */
static psplat_candidate curved_candidate(uint32_t lines, double bend) {
    psplat_candidate c = {.region = {.u = {1, 0, 0},
                                     .v = {0, 1, 0},
                                     .n = {0, 0, 1},
                                     .radius = {2, 0.5},
                                     .line_count = lines,
                                     .hessian = {0.25, 0.125, -0.5}},
                          .field = {0, 0, -0.5, 0.25, -0.25},
                          .taken = 1};
    for (uint32_t i = 0; i < lines; ++i) c.region.lines[i][0] = 1;
    if (lines) c.region.bends[lines - 1] = bend;
    return c;
}

/* Curved splats have runs of their own behind the plane ones of as many lines. Their gradients
 * follow from the Hessian A, B, C by the signs and lengths of spec 3.4: alpha = -A r_u, beta =
 * -C r_v, gamma = -B r_u. */
static void test_curved_runs(void **state) {
    (void)state;
    psplat_candidate candidates[] = {curved_candidate(1, 0.5), curved_candidate(0, 0),
                                     curved_candidate(0, 0), curved_candidate(0, 0)};
    memset(candidates[3].region.hessian, 0, sizeof candidates[3].region.hessian);
    candidates[3].is_flat = 1;
    candidates[2].region.slope[0] = 0.125;
    candidates[2].field[0] = -0.125;
    candidates[2].field[2] *= 1 + 1e-7; /* rounded to float */
    psplat_splats splats = {0};
    psplat_selection selection = {candidates, 4, 4};
    const psplat_sort_desc storing = {.depth_tolerance = 1, .flat_depth_tolerance = 0.1f};
    assert_int_equal(psplat_sort_splats(&selection, &storing, &splats), PSPLAT_OK);
    assert_int_equal(splats.run_count, 3);
    const psplat_run *flat = splats.runs, *plain_lines = flat + 1, *bent = flat + 2;
    assert_true(!flat->is_curved && flat->depth_tolerance == 0.1f && flat->count == 1);
    assert_true(plain_lines->is_curved && !plain_lines->has_shape && !plain_lines->has_bends);
    assert_true(plain_lines->depth_tolerance == 1 && plain_lines->count == 2);
    assert_true(bent->is_curved && bent->has_bends && bent->clip_lines == 1);
    for (int i = 1; i < 4; ++i) {
        static const float shape[3] = {-0.5f, 0.25f, -0.25f};
        assert_memory_equal(splats.splats[i].shape + 2, shape, sizeof shape);
        assert_memory_equal(splats.splats[i].gradient, shape, sizeof shape);
    }
    assert_true(splats.splats[0].shape[2] == 0 && splats.splats[3].bend[0] == 0.5f);
    assert_true(splats.splats[1].shape[0] + splats.splats[2].shape[0] == -0.125f);
    psplat_splats_free(&splats);
}

/* A field that is not that of the surface gives all splats of its run shapes of their own. */
static void test_own_shapes(void **state) {
    (void)state;
    for (int k = 0; k < 5; ++k) {
        psplat_candidate candidates[] = {curved_candidate(0, 0), curved_candidate(0, 0)};
        candidates[1].field[k] += 1e-3;
        psplat_splats splats = store(candidates, 2);
        assert_int_equal(splats.run_count, 1);
        assert_true(splats.runs->is_curved && splats.runs->has_shape);
        for (int i = 0; i < 2; ++i)
            assert_true(splats.splats[i].shape[0] == 0 && splats.splats[i].shape[2] == -0.5f);
        psplat_splats_free(&splats);
    }
}

/* No candidates, and candidates that are all in one place, also have a defined order. */
static void test_degenerate(void **state) {
    (void)state;
    psplat_candidate same[5];
    psplat_splats splats = store(same, 0);
    psplat_splats_free(&splats);
    for (int i = 0; i < 5; ++i) {
        same[i] = (psplat_candidate){
            .region = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {1, 1}},
            .color = {(float)i, 0, 0, 1},
            .taken = 1};
    }
    splats = store(same, 5);
    /* The sort is stable. */
    for (int i = 0; i < 5; ++i) assert_near((double)splats.splats[i].color[0], i, 0);
    /* Storing again replaces the earlier splats. */
    psplat_selection fewer = {same, 2, 5};
    assert_int_equal(psplat_sort_splats(&fewer, &plain, &splats), PSPLAT_OK);
    assert_int_equal(splats.count, 2);
    assert_int_equal(splats.run_count, 1);
    assert_int_equal(splats.runs[0].count, 2);
    assert_int_equal(splats.has_color, 0);
    psplat_splats_free(&splats);
}

int test_sort_splats_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rotations),  cmocka_unit_test(test_cube_rotations),
        cmocka_unit_test(test_round_trip), cmocka_unit_test(test_morton),
        cmocka_unit_test(test_runs),       cmocka_unit_test(test_texcoords),
        cmocka_unit_test(test_degenerate), cmocka_unit_test(test_curved_runs),
        cmocka_unit_test(test_own_shapes), cmocka_unit_test(test_seams),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

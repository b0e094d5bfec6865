/* SPDX-License-Identifier: MIT
 *
 * test_agreement_curved.c - tests that the renderer draws curved splats and bent clip lines as the
 * reference rasteriser does: random ones of all kinds in all kinds of views, modes and transforms,
 * on GL and GLES, and where renderers usually fail.
 */
#include <phongsplat/host.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "extreme_view.h"

enum { WIDTH = 160, HEIGHT = 120 };

/* ---- scenes ---------------------------------------------------------------------------------- */

/* What the splats of a scene are. */
enum { CURVED = 1, OWN_SHAPE = 2, BENT = 4 };

static float random_in(uint32_t *state, float most) {
    return (2 * scene_random(state) - 1) * most;
}

/* Gives splats curvatures of up to steepness in the units of their radii: bowls, humps, saddles and
 * cylinders. */
static void curve(scene *s, unsigned kind, float steepness, uint32_t seed) {
    for (size_t i = 0; i < s->count; ++i) {
        psplat_splat *splat = &s->splats[i];
        for (int k = 0; k < 3; ++k) splat->gradient[k] = random_in(&seed, steepness);
        if (i % 7 == 0) splat->gradient[i % 2] = splat->gradient[2] = 0; /* a cylinder */
        if (kind & CURVED) scene_curve_splat(splat);
        if (kind & OWN_SHAPE) {
            splat->shape[0] = splat->shape[1] = 0;
            for (int k = 0; k < 3; ++k) splat->shape[2 + k] = random_in(&seed, steepness);
        }
        for (uint32_t k = 0; k < splat->clip_count && kind & BENT; ++k)
            splat->bend[k] = random_in(&seed, 4);
    }
}

static scene ellipses(unsigned kind, uint32_t seed) {
    scene s = scene_ellipses(250, 4, seed);
    curve(&s, kind, 1.5f, seed + 1);
    return s;
}

/* Returns a sphere of curved splats, so large that each shows its curvature. */
static scene sphere(size_t count) {
    scene s = scene_sphere(count, 1);
    scene_curve(&s);
    s.depth_tolerance = 0.004f;
    return s;
}

/* ---- comparisons ----------------------------------------------------------------------------- */

static psplat_view view_from(double x, double y, double z) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    const float light[3] = {1, 0.5f, 2}, color[3] = {2.5f, 2, 1.5f};
    camera_look(&view, (double[]){x, y, z}, (double[]){0, 0, 0});
    camera_perspective(&view, 120, 0.3, 10);
    for (int i = 0; i < 3; ++i) {
        view.lights[0].direction[i] = -light[i];
        view.lights[0].color[i] = color[i];
        view.ambient[i] = 0.1f;
    }
    return view;
}

/* What may differ: ties and window depth. The ties are those of test_agreement.c. Epsilon is added
 * at each fragment of curved splats and errs less than that of flat ones, which are shifted at
 * their corners, but in near views. Beside a contour (u, v) and depth change most with a pixel's
 * position error; in near and in parallel views that counts most. */
typedef struct tolerances {
    agreement_ties ties;
    double depth;
} tolerances;

static const tolerances ordinary = {{2e-4, 2e-6, 1e-3}, 1e-6};
static const tolerances steep = {{2e-4, 2e-6, 1e-3}, 2e-6};
static const tolerances close_up = {{2e-4, 2e-6, 0.1}, 2e-6};

/* The other bounds of test_agreement.c. */
#define BOUND_UV 5e-5
#define BOUND_THIN_UV 5e-4
#define BOUND_THIN_DEPTH 2e-5
#define BOUND_FLOAT 2e-4

static void assert_agrees(const char *name, const agreement *a, const tolerances *allowed) {
    print_message("%-30s covered %6zu skipped %4zu mismatches %zu other %zu uv %.1e (thin %.1e) "
                  "depth %.1e (thin %.1e) color %.1e\n",
                  name, a->covered, a->skipped, a->mismatches, a->other, a->uv, a->thin_uv,
                  a->depth, a->thin_depth, a->color);
    assert_true(a->covered > 1000);
    assert_true(a->skipped * 10 < a->covered);
    assert_int_equal(a->mismatches, 0);
    assert_int_equal(a->other, 0);
    assert_true(a->uv <= BOUND_UV);
    assert_true(a->depth <= allowed->depth);
    assert_true(a->thin_uv <= BOUND_THIN_UV);
    assert_true(a->thin_depth <= BOUND_THIN_DEPTH);
    assert_true(a->color <= BOUND_FLOAT);
}

/* Compares all modes. */
static void check(gpu *g, const char *name, const scene *s, const double transform[16],
                  psplat_view view, const tolerances *allowed) {
    psplat_asset *asset = scene_open(s);
    agreement all =
        agreement_measure_modes(g, asset, transform, &view, AGREEMENT_ALL_MODES, 1, &allowed->ties);
    psplat_asset_destroy(asset);
    assert_agrees(name, &all, allowed);
}

static void check_views(gpu *g, const char *name, const scene *s, int is_flat) {
    psplat_view view = view_from(1, 2, 3);
    print_message("%s\n", name);
    check(g, " perspective", s, NULL, view, is_flat ? &close_up : &ordinary);
    camera_parallel(&view, 1.6, 1, 8);
    check(g, " parallel", s, NULL, view, is_flat ? &close_up : &steep);
    check(g, " close", s, NULL, view_from(-0.9, 1.2, -1.1), is_flat ? &close_up : &close_up);
}

static void test_sphere(void **state) {
    scene s = sphere(100);
    s.material.metallic = 0.3f;
    check_views(*state, "sphere of 100 curved splats", &s, 0);
    scene_free(&s);
}

/* Walls of 2.5 % of the scene. Near views would tell more of what epsilon errs there
 * by than of walls. */
static void test_walls(void **state) {
    scene s = ellipses(CURVED | BENT, 19);
    s.depth_tolerance = 0.1f;
    for (s.material.double_sided = 0; s.material.double_sided < 2; ++s.material.double_sided) {
        psplat_view view = view_from(1, 2, 3);
        print_message("curved, high walls, %d-sided\n", 1 + (int)s.material.double_sided);
        check(*state, " perspective", &s, NULL, view, &ordinary);
        camera_parallel(&view, 1.6, 1, 8);
        check(*state, " parallel", &s, NULL, view, &steep);
    }
    scene_free(&s);
}

/* A hill over the upper edge of the view, of which the view shows nothing but the lower half of its
 * wall, outside of any sphere that just holds the hill. */
static void test_wall_alone(void **state) {
    gpu *g = *state;
    scene s = scene_disc(1);
    s.splats[0].radius[0] = s.splats[0].radius[1] = 0.05f;
    scene_set_axes(&s.splats[0], (double[]){1, 0, 0}, (double[]){0, 0, -1});
    for (int i = 0; i < 3; ++i) s.splats[0].normal[i] = i == 1;
    s.splats[0].center[1] = 0.75f;
    s.splats[0].gradient[0] = s.splats[0].gradient[1] = 2; /* the rim is 0.05 lower */
    scene_curve(&s);
    s.depth_tolerance = 0.19f; /* less than four sagittas, or it would be drawn as a disc */
    psplat_asset *asset = scene_open(&s);
    psplat_view view = view_from(0, 0, 3);
    camera_look(&view, (double[]){0, 0.665, 3}, (double[]){0, 0.665, 0});
    camera_parallel(&view, 0.01, 1, 8);
    agreement a = agreement_measure_modes(g, asset, NULL, &view, 1u << PSPLAT_MODE_PARAMETERS, 1,
                                          &steep.ties);
    print_message("wall alone: covered %zu skipped %zu uv %.1e\n", a.covered, a.skipped, a.uv);
    assert_true(a.covered > 100);
    assert_int_equal(a.mismatches, 0);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

static void test_curved(void **state) {
    scene s = ellipses(CURVED, 7);
    check_views(*state, "curved, 0 to 4 clip lines", &s, 0);
    s.material.double_sided = 1;
    s.kernel = (psplat_kernel){4, 1.5f};
    check_views(*state, "two-sided", &s, 0);
    s.has_color = 0;
    check(*state, " without colours", &s, NULL, view_from(1, 2, 3), &ordinary);
    scene_free(&s);
}

static void test_own_shapes(void **state) {
    scene s = ellipses(CURVED | OWN_SHAPE, 8);
    check_views(*state, "shapes of their own", &s, 0);
    s.has_color = 0;
    s.material.double_sided = 1;
    check(*state, " two-sided, without colours", &s, NULL, view_from(1, 2, 3), &ordinary);
    scene_free(&s);
}

/* Both decide by the primitive, not by a splat's shape, which surface a splat has. */
static void test_flat_among_curved(void **state) {
    scene s = ellipses(CURVED | OWN_SHAPE, 8);
    for (size_t i = 0; i < s.count; i += 3) memset(s.splats[i].shape, 0, sizeof s.splats[i].shape);
    s.flat_is_curved = 1;
    check_views(*state, "flat splats among curved ones", &s, 0);
    psplat_view view = view_from(2.5, 5, 7.5);
    view.no_filter = 0;
    camera_perspective(&view, 120, 1, 100);
    check(*state, " small, with the filter", &s, NULL, view, &ordinary);
    scene_free(&s);
}

static void test_bent(void **state) {
    scene s = ellipses(CURVED | BENT, 9), plain = ellipses(BENT, 10);
    check_views(*state, "curved, with bent clip lines", &s, 0);
    check_views(*state, "flat, with bent clip lines", &plain, 1);
    scene_free(&s);
    scene_free(&plain);
}

/* Bent lines of splats of 3 to a tenth of a pixel are softened by their own gradients (spec 5.8),
 * with the bounds of test_agreement_filter.c for slanted splats. */
static void test_bent_filter(void **state) {
    const agreement_ties ties = {2e-4, 2e-6, 0.015};
    scene s = ellipses(BENT, 10);
    psplat_asset *asset = scene_open(&s);
    for (int distance = 2; distance <= 8; distance *= 2) {
        psplat_view view = view_from(distance, 2 * distance, 3 * distance);
        view.no_filter = 0;
        camera_perspective(&view, 120, 1, 100);
        agreement a = agreement_measure(*state, asset, NULL, &view, 1, &ties);
        print_message("filtered, from %2d: covered %zu skipped %zu depth %.1e color %.1e\n",
                      distance, a.covered, a.skipped, a.depth, a.color);
        assert_true(a.covered > 20 && a.skipped * 4 < a.covered);
        assert_int_equal(a.mismatches, 0);
        assert_true(a.depth <= 2e-5 && a.color <= 2e-4);
    }
    psplat_asset_destroy(asset);
    scene_free(&s);
}

static void test_transforms(void **state) {
    const double stretched[16] = {1.2, 0, 0, 0, 0.3, 0.7, 0, 0, 0, 0.2, 1, 0, 0.1, 0, 0, 1};
    const double mirrored[16] = {0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const double flattened[16] = {1, 0, 0, 0, 0, -0.2, 0, 0, 0, 0.3, 1.5, 0, 0, 0, 0, 1};
    scene s = ellipses(CURVED | BENT, 11), ball = sphere(100);
    print_message("transforms\n");
    check(*state, " stretched, sheared", &s, stretched, view_from(2, 2, 3), &ordinary);
    check(*state, " mirrored", &s, mirrored, view_from(2, 2, 3), &ordinary);
    check(*state, " flattened and mirrored", &s, flattened, view_from(2, 2, 3), &ordinary);
    check(*state, " stretched sphere", &ball, stretched, view_from(2, 2, 3), &ordinary);
    check(*state, " mirrored sphere", &ball, mirrored, view_from(2, 2, 3), &ordinary);
    s.material.double_sided = 1;
    check(*state, " two-sided and mirrored", &s, mirrored, view_from(2, 2, 3), &ordinary);
    scene_free(&s);
    scene_free(&ball);
}

static void test_far_from_origin(void **state) {
    scene s = sphere(100);
    const double at[3] = {1e6, -2e6, 3e6};
    for (int i = 0; i < 3; ++i) s.origin[i] = at[i];
    psplat_view view = view_from(1, 2, 3);
    camera_look(&view, (double[]){at[0] + 1, at[1] + 2, at[2] + 3}, at);
    check(*state, "far from the origin", &s, NULL, view, &ordinary);
    scene_free(&s);
}

/* ---- what is drawn as flat ---------------------------------------------------------------------
 */

/* Patches that nowhere leave their tangent planes by an eighth of a pixel are drawn as ellipses. A
 * pixel is undecided where the reference's patch is nearer to an edge than that, and a depth
 * differs by what the patch is high. */
static void test_flat_patches(void **state) {
    const tolerances eighth = {{0.13, 2e-6, 0.2}, 2e-3};
    gpu *g = *state;
    for (int kind = CURVED; kind <= (CURVED | OWN_SHAPE); kind += OWN_SHAPE) {
        scene s = scene_ellipses(100, 0, 12);
        curve(&s, (unsigned)kind, 0.003f, 5);
        s.depth_tolerance = 0; /* there are no walls, and heights matter */
        psplat_asset *asset = scene_open(&s);
        psplat_view view = view_from(1, 2, 3);
        agreement a = agreement_measure_modes(g, asset, NULL, &view, 1u << PSPLAT_MODE_PARAMETERS,
                                              1, &eighth.ties);
        print_message("flat patches: covered %zu skipped %zu mismatches %zu other %zu uv %.1e "
                      "depth %.1e\n",
                      a.covered, a.skipped, a.mismatches, a.other, a.uv, a.depth);
        assert_true(a.covered > 1000 && a.skipped * 4 < a.covered * 3);
        assert_int_equal(a.mismatches, 0);
        assert_true(a.uv > 1e-4 && a.uv < 0.1); /* it is not the patch that is drawn */
        psplat_asset_destroy(asset);
        scene_free(&s);
    }
}

/* ---- extremes -------------------------------------------------------------------------------- */

/* Returns one splat with this Hessian of its field, turned so that N is along n and U along u. */
static extreme single(double radius, const float gradient[3], const double u[3],
                      const double v[3]) {
    extreme e = extreme_of(scene_disc(1));
    psplat_splat *splat = &e.s.splats[0];
    scene_set_axes(splat, u, v);
    for (int i = 0; i < 3; ++i)
        splat->normal[i] =
            (float)(u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
    splat->radius[0] = splat->radius[1] = (float)radius;
    for (int k = 0; k < 3; ++k) splat->gradient[k] = gradient[k];
    scene_curve(&e.s);
    return e;
}

static const double axis_x[3] = {1, 0, 0}, axis_y[3] = {0, 1, 0}, back[3] = {0, 0, -1};
static const float bowl[3] = {-1.2f, -0.9f, 0.1f}, hump[3] = {1.2f, 0.9f, 0.1f};
static const float saddle[3] = {1.5f, -1.5f, 0.4f}, cylinder[3] = {1.8f, 0, 0};
static const float *const forms[] = {bowl, hump, saddle, cylinder};
static const char *const names[] = {"bowl", "hump", "saddle", "cylinder"};

/* Draws each form as one side and as both, which shows other roots. */
static void check_forms(gpu *g, const char *what, double radius, const double u[3],
                        const double v[3], void (*change)(extreme *e), extreme_bounds bounds) {
    for (int form = 0; form < 4; ++form)
        for (int sides = 1; sides <= 2; ++sides) {
            char name[80];
            extreme e = single(radius, forms[form], u, v);
            snprintf(name, sizeof name, "%s, %s, %d", what, names[form], sides);
            e.s.material.double_sided = sides == 2;
            extreme_bounds here = bounds;
            if (sides == 1) here.least = 0; /* of some only the back is in the view */
            if (change) change(&e);
            extreme_check(g, name, &e, here);
        }
}

/* Rays along the plane graze humps and meet bowls twice. */
static void test_edge_on(void **state) {
    const double angle = 89.9 * CAMERA_PI / 180, v[3] = {0, cos(angle), sin(angle)};
    check_forms(*state, "edge-on", 1, axis_x, v, NULL,
                (extreme_bounds){.thin_uv = 5e-4, .least = 250});
}

static void to_near_plane(extreme *e) {
    e->s.splats[0].center[0] = 0.5f;
    e->s.splats[0].center[2] = 4.5f;
}

static void test_near_crossing(void **state) {
    check_forms(*state, "through the near plane", 2, back, axis_y, to_near_plane,
                (extreme_bounds){.thin_uv = 5e-4, .least = 5000});
}

static void around_eye(extreme *e) {
    e->s.splats[0].center[1] = -0.01f;
    e->s.splats[0].center[2] = 5;
}

/* A part of the patch is a hundred times nearer to the eye than the patch is large, and depth there
 * counts distances of 1e-6 of the patch a hundred times. */
static void test_eye_inside(void **state) {
    check_forms(*state, "the eye inside", 10, axis_x, back, around_eye,
                (extreme_bounds){.thin_uv = 5e-4, .depth = 5e-5, .least = 4000});
}

static void far_outside(extreme *e) {
    e->s.splats[0].center[0] = 4;
    e->s.splats[0].center[1] = 2.5f;
}

static void test_huge(void **state) {
    check_forms(*state, "its centre far outside", 6, axis_x, axis_y, far_outside,
                (extreme_bounds){.thin_uv = 5e-4, .least = 10000});
}

static void test_needles(void **state) {
    extreme e = single(3, saddle, (double[]){0.8, 0.6, 0}, (double[]){-0.6, 0.8, 0});
    e.s.splats[0].radius[1] = 0.01f;
    extreme_check(*state, "3 x 0.01, a saddle", &e,
                  (extreme_bounds){.thin_uv = 1e-3, .least = 4 * 20});
}

static void far_over_near(extreme *e) {
    camera_perspective(&e->view, 120, 1e-3, 1e4);
}

static void test_far_over_near(void **state) {
    check_forms(*state, "far / near = 1e7", 1, axis_x, axis_y, far_over_near,
                (extreme_bounds){.thin_uv = 5e-4, .least = 4000});
}

static void parallel(extreme *e) {
    camera_parallel(&e->view, 1.2, 0.1, 20);
}

static void test_parallel(void **state) {
    const double angle = 70 * CAMERA_PI / 180, v[3] = {0, cos(angle), sin(angle)};
    check_forms(*state, "parallel, slanted", 1, axis_x, v, parallel,
                (extreme_bounds){.thin_uv = 5e-4, .least = 4000});
}

static void test_odd_projections(void **state) {
    for (int kind = 0; kind < 3; ++kind) {
        extreme e = extreme_of(sphere(60));
        double *p = e.view.projection;
        e.s.material.double_sided = 0;
        camera_perspective(&e.view, 120, 1, 20);
        if (kind == 0) p[10] = -1, p[14] = -2; /* the far plane is at infinity */
        if (kind == 1) p[0] = -p[0];
        if (kind == 2) {
            const double x = p[0], y = p[5];
            p[0] = p[5] = 0;
            p[1] = x;
            p[4] = -y;
            p[8] = 0.2;
            p[9] = -0.1;
            for (int i = 0; i < 16; ++i) p[i] *= 3;
        }
        extreme_check(*state,
                      kind ? kind == 1 ? "mirrored" : "off the axis, turned, times 3"
                           : "far plane at infinity",
                      &e, (extreme_bounds){.thin_uv = 5e-4, .least = 4 * 1500});
    }
}

int test_agreement_curved_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_curved),
        cmocka_unit_test(test_walls),
        cmocka_unit_test(test_wall_alone),
        cmocka_unit_test(test_flat_among_curved),
        cmocka_unit_test(test_own_shapes),
        cmocka_unit_test(test_bent),
        cmocka_unit_test(test_transforms),
        cmocka_unit_test(test_far_from_origin),
        cmocka_unit_test(test_bent_filter),
        cmocka_unit_test(test_flat_patches),
        cmocka_unit_test(test_edge_on),
        cmocka_unit_test(test_near_crossing),
        cmocka_unit_test(test_eye_inside),
        cmocka_unit_test(test_huge),
        cmocka_unit_test(test_needles),
        cmocka_unit_test(test_far_over_near),
        cmocka_unit_test(test_parallel),
        cmocka_unit_test(test_odd_projections),
    };
    const struct CMUnitTest gles_tests[] = {
        cmocka_unit_test(test_curved),
        cmocka_unit_test(test_walls),
        cmocka_unit_test(test_flat_among_curved),
        cmocka_unit_test(test_bent),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", gles_tests, gpu_setup_gles, gpu_teardown);
}

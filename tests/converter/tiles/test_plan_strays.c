/* SPDX-License-Identifier: MIT
 *
 * test_plan_strays.c - plans of sources that are not what blocks are made for: parts that lie ever
 * farther away, so that each block above another is larger than it many times, and leaves in which
 * no triangle has an area.
 */
#define _XOPEN_SOURCE 700 /* nftw */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>

#include "base/random.h"
#include "base/vector.h"
#include "plan_fixture.h"
#include "tiles/merge.h"
#include "tiles/plan.h"
#include "tiles/tile_node.h"

enum { PARTS = 14, SIDE = 7, LINE_TRIANGLES = 3000 };

static plan_place place;

static int set_up(void **state) {
    (void)state;
    plan_place_make(&place);
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    plan_place_remove(&place);
    return 0;
}

/* Stores a bumpy square of 2 SIDE SIDE triangles from these on. */
static void put_square(double x, double z, double size, psplat_mesh *mesh, size_t *triangle) {
    for (size_t i = 0; i < 2 * SIDE * SIDE; ++i) {
        static const int corners[6][2] = {{0, 0}, {0, 1}, {1, 0}, {1, 0}, {0, 1}, {1, 1}};
        for (size_t k = 0; k < 3; ++k) {
            const int *corner = corners[3 * (i % 2) + k];
            double u = (double)(i / 2 % SIDE + (size_t)corner[0]) / SIDE;
            double v = (double)(i / 2 / SIDE + (size_t)corner[1]) / SIDE;
            double *p = mesh->positions + 9 * *triangle + 3 * k;
            p[0] = x + size * u, p[1] = 0.08 * size * sin(6 * u) * cos(5 * v), p[2] = z + size * v;
        }
        ++*triangle;
    }
}

static psplat_mesh make_soup(size_t triangles) {
    psplat_mesh mesh;
    assert_int_equal(psplat_mesh_allocate(&mesh, 3 * triangles, triangles, 0, NULL), PSPLAT_OK);
    for (uint32_t i = 0; i < 3 * triangles; ++i) mesh.triangles[i] = i;
    return mesh;
}

static void make_plan(psplat_mesh *mesh, double tolerance, uint64_t triangles,
                      psplat_tile_plan *plan) {
    psplat_error error = {0};
    const psplat_tile_options options = {
        .convert = {.tolerance_percent = tolerance, .precision = 0.1, .effort = PSPLAT_EFFORT_NONE},
        .most_triangles = triangles,
        .apron = 0.0625};
    plan_write_stl(mesh, place.input);
    psplat_mesh_free(mesh);
    if (psplat_tile_plan_make(place.input, &options, "phongsplat", place.output, 0, plan, &error))
        fail_msg("%s", error.text);
}

static psplat_tile_run run_task(const psplat_tile_plan *plan, size_t task) {
    psplat_error error = {0};
    psplat_tile_run run;
    if (psplat_tile_node_run(plan, place.output, task, NULL, NULL, &run, &error))
        fail_msg("%s", error.text);
    return run;
}

/* Each part is twice as far away and as large as the one before, so that blocks form a chain, in
 * which tolerances double, too. They begin with 15 % of the whole. Errors are a fifth of what a
 * block has, the coarsest tolerance of any level, and a little more for its simplified mesh. */
static void far_parts_do_not_spoil_errors(void **state) {
    (void)state;
    psplat_mesh mesh = make_soup(2 * SIDE * SIDE * PARTS);
    psplat_tile_plan plan;
    psplat_tile_summary summary;
    psplat_error error = {0};
    size_t at = 0;
    for (int i = 0; i < PARTS; ++i)
        put_square(ldexp(1.5, i), ldexp(0.1, i), ldexp(0.4, i), &mesh, &at);
    make_plan(&mesh, 15, 2 * SIDE * SIDE, &plan);
    assert_true(plan.tasks.list[plan.tasks.count - 1].wave >= PARTS / 2);
    for (size_t i = 0; i < plan.tasks.count; ++i) {
        psplat_tile_run run = run_task(&plan, i);
        const psplat_tile_task *task = &plan.tasks.list[i];
        double diagonal[3];
        sub3(diagonal, task->high, task->low);
        /* 5 % of twice the coarsest tolerance, which is 20 % of the diagonal. */
        if (!(run.record.deviation <= 0.02 * length3(diagonal) * (1 + 1e-12)))
            fail_msg("%s deviates by %g of its diagonal", task->name,
                     run.record.deviation / length3(diagonal));
        psplat_tile_record_free(&run.record);
    }
    if (psplat_tile_merge(&plan, place.output, &summary, &error)) fail_msg("%s", error.text);
    if (!(summary.error <= 0.25 * plan.diagonal))
        fail_msg("the root errs by %g of the diagonal", summary.error / plan.diagonal);
    psplat_tile_plan_free(&plan);
}

/* Triangles on one line have no area, but each of them is the nearest to what others cover there. A
 * leaf of them takes no time: nothing of it is simplified or handed on. */
static void triangles_without_area_are_not_handed_on(void **state) {
    (void)state;
    psplat_mesh mesh = make_soup(2 * SIDE * SIDE + LINE_TRIANGLES);
    psplat_tile_plan plan;
    size_t at = 0, empty = 0;
    uint64_t seed = 7;
    put_square(0, 0, 1, &mesh, &at);
    for (size_t i = 0; i < LINE_TRIANGLES; ++i, ++at) {
        double from = 3 + 0.5 * psplat_random_unit(&seed), length = psplat_random_unit(&seed);
        for (int k = 0; k < 3; ++k) {
            mesh.positions[9 * at + 3 * (size_t)k] = from + 0.05 * k * length;
            mesh.positions[9 * at + 3 * (size_t)k + 2] = 0.5;
        }
    }
    make_plan(&mesh, 1, 1000, &plan);
    for (size_t i = 0; i < plan.tasks.count; ++i) {
        psplat_tile_run run = run_task(&plan, i);
        const psplat_tile_task *task = &plan.tasks.list[i];
        if (task->leaf != SIZE_MAX && task->low[0] > 2) {
            assert_int_equal(run.simplified, 0);
            assert_int_equal(run.record.tile_count, 0);
            empty += run.owned;
        }
        psplat_tile_record_free(&run.record);
    }
    assert_int_equal(empty, LINE_TRIANGLES);
    psplat_tile_plan_free(&plan);
}

int test_plan_strays_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(far_parts_do_not_spoil_errors, set_up, tear_down),
        cmocka_unit_test_setup_teardown(triangles_without_area_are_not_handed_on, set_up,
                                        tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

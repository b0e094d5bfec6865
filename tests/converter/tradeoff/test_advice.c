/* SPDX-License-Identifier: MIT
 *
 * test_advice.c - tests of the setting that is recommended for limits of error, size and time. The
 * tables are invented, so that the best row is known.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <cmocka.h>

#include "tradeoff/advice.h"
#include "table/row.h"
#include "table/setting.h"
#include "table/sweep_table.h"
#include "invented_table.h"

static psplat_advice advise(const psplat_sweep_table *table, psplat_demand demand) {
    size_t scratch[128];
    assert_true(table->count <= 128);
    return psplat_advise(table->rows, table->count, &demand, scratch);
}

static const psplat_setting *setting_of(const psplat_sweep_table *table, psplat_advice advice) {
    assert_true(advice.row < table->count);
    return &table->rows[advice.row].setting;
}

static void assert_setting(const psplat_sweep_table *table, psplat_demand demand, double tolerance,
                           psplat_form form, psplat_mode mode) {
    psplat_advice advice = advise(table, demand);
    const psplat_setting *s = setting_of(table, advice);
    assert_true(advice.fits);
    assert_true(s->tolerance == tolerance);
    assert_int_equal(s->form, form);
    assert_int_equal(s->mode, mode);
}

/* Distances are 0.97 of the tolerance; floats take more bytes, and splats drawn flat less time. */
static void test_error_limits(void **state) {
    (void)state;
    psplat_sweep_table j = make_table(1);
    /* A distance does not depend on modes, so that the default stays, although others are cheaper.
     */
    assert_setting(&j, (psplat_demand){PSPLAT_ERROR_KIND_DISTANCE, 0.5, 0, 0}, 0.5,
                   PSPLAT_FORM_USUAL, PSPLAT_MODE_PHONG);
    assert_setting(&j, (psplat_demand){PSPLAT_ERROR_KIND_DISTANCE, 0.48, 0, 0}, 0.2,
                   PSPLAT_FORM_USUAL, PSPLAT_MODE_PHONG);
    /* Normal errors: 4 degrees at 1 %, with floats 3.6, which are not needed. */
    assert_setting(&j, (psplat_demand){PSPLAT_ERROR_KIND_NORMAL, 4.1, 0, 0}, 1, PSPLAT_FORM_USUAL,
                   PSPLAT_MODE_PHONG);
    /* Picture errors: 1.2 % at 1 %. Outlines err by a sixth of a distance, and do not tell of modes
     * either. */
    assert_setting(&j, (psplat_demand){PSPLAT_ERROR_KIND_IMAGE, 1.25, 0, 0}, 1, PSPLAT_FORM_USUAL,
                   PSPLAT_MODE_PHONG);
    assert_setting(&j, (psplat_demand){PSPLAT_ERROR_KIND_OUTLINE, 0.1, 0, 0}, 0.5,
                   PSPLAT_FORM_USUAL, PSPLAT_MODE_PHONG);
    psplat_sweep_table_free(&j);
}

static void test_budgets(void **state) {
    (void)state;
    psplat_sweep_table j = make_table(0);
    /* The finest setting that fits; at 1 % it takes 120 splats of 12 bytes and 2,000 more. Floats
     * are 10 % better, where there are bytes for them. */
    assert_setting(&j, (psplat_demand){.bytes = 3440}, 1, PSPLAT_FORM_USUAL, PSPLAT_MODE_PHONG);
    assert_setting(&j, (psplat_demand){.bytes = 1e9}, 0.1, PSPLAT_FORM_FLOAT, PSPLAT_MODE_PHONG);
    assert_setting(&j, (psplat_demand){.ms = 1e9}, 0.1, PSPLAT_FORM_FLOAT, PSPLAT_MODE_PHONG);
    /* With two limits the tighter one decides. */
    assert_setting(&j, (psplat_demand){.bytes = 3440, .ms = 1e9}, 1, PSPLAT_FORM_USUAL,
                   PSPLAT_MODE_PHONG);
    /* Phong takes 6 n^0.2 ms, and flat 3 n^0.2 ms: where only flat is fast enough, flat is
     * recommended. */
    double fastest = INFINITY;
    for (size_t i = 0; i < j.count; ++i)
        if (j.rows[i].setting.mode == PSPLAT_MODE_PHONG && j.rows[i].setting.competitor)
            fastest = fmin(fastest, j.rows[i].values[PSPLAT_COLUMN_CPU_MS]);
    psplat_advice advice = advise(&j, (psplat_demand){.ms = 0.9 * fastest});
    assert_true(advice.fits);
    assert_int_not_equal(setting_of(&j, advice)->mode, PSPLAT_MODE_PHONG);
    /* A distance is demanded within that time, for which the default mode is too slow. */
    advice = advise(&j, (psplat_demand){PSPLAT_ERROR_KIND_DISTANCE, 2, 0, 0.9 * fastest});
    assert_true(advice.fits);
    assert_int_not_equal(setting_of(&j, advice)->mode, PSPLAT_MODE_PHONG);
    psplat_sweep_table_free(&j);
}

static void test_nearest_miss(void **state) {
    (void)state;
    psplat_sweep_table j = make_table(0);
    psplat_advice advice = advise(&j, (psplat_demand){PSPLAT_ERROR_KIND_DISTANCE, 0.01, 0, 0});
    assert_false(advice.fits);
    assert_true(setting_of(&j, advice)->tolerance == 0.1);
    advice = advise(&j, (psplat_demand){.bytes = 10});
    assert_false(advice.fits);
    assert_true(setting_of(&j, advice)->tolerance == 2);
    assert_int_equal(setting_of(&j, advice)->form, PSPLAT_FORM_USUAL);
    psplat_sweep_table_free(&j);
}

/* Times within 5 % count as equal, and the default is taken. */
static void test_noise(void **state) {
    (void)state;
    psplat_row rows[3] = {plain_row(100, 2, 1), plain_row(100, 2, 1.04), plain_row(110, 1, 0.5)};
    rows[0].setting.mode = PSPLAT_MODE_FLAT;
    const psplat_sweep_table j = {.rows = rows, .count = 3};
    assert_int_equal(advise(&j, (psplat_demand){PSPLAT_ERROR_KIND_IMAGE, 2, 0, 0}).row, 1);
    rows[1].values[PSPLAT_COLUMN_CPU_MS] = 1.06;
    assert_int_equal(advise(&j, (psplat_demand){PSPLAT_ERROR_KIND_IMAGE, 2, 0, 0}).row, 0);
    assert_int_equal(advise(&j, (psplat_demand){PSPLAT_ERROR_KIND_IMAGE, 1, 0, 0}).row, 2);
    /* Differences within 3 % count as equal, and the smaller file is taken. */
    rows[0] = plain_row(200, 2, 1);
    rows[1] = plain_row(100, 2.059, 1);
    rows[2] = plain_row(90, 2.061, 1);
    assert_int_equal(advise(&j, (psplat_demand){.bytes = 1000}).row, 1);
}

static void test_missing_values(void **state) {
    (void)state;
    psplat_row rows[3] = {plain_row(100, NAN, 1), plain_row(200, 2, NAN), plain_row(300, 4, 3)};
    const psplat_sweep_table j = {.rows = rows, .count = 3};
    /* A value that is unknown, or makes no sense, satisfies no limit. */
    assert_int_equal(advise(&j, (psplat_demand){PSPLAT_ERROR_KIND_IMAGE, 3, 0, 0}).row, 1);
    assert_int_equal(advise(&j, (psplat_demand){.ms = 5}).row, 2);
    rows[0].values[PSPLAT_COLUMN_DIFFERENCE] = -1;
    assert_int_equal(advise(&j, (psplat_demand){.ms = 5}).row, 2);
    rows[2].values[PSPLAT_COLUMN_DIFFERENCE] = INFINITY;
    psplat_advice advice = advise(&j, (psplat_demand){PSPLAT_ERROR_KIND_IMAGE, 3, 0, 5});
    assert_false(advice.fits);
    assert_true(advice.row == SIZE_MAX); /* no row has both values */
    const psplat_sweep_table empty = {.count = 0};
    assert_true(advise(&empty, (psplat_demand){.bytes = 5}).row == SIZE_MAX);
}

/* The smallest gltfpack row that keeps the limits is named as well. */
static void test_simplified(void **state) {
    (void)state;
    psplat_sweep_table j = make_table(1);
    psplat_advice advice = advise(&j, (psplat_demand){PSPLAT_ERROR_KIND_DISTANCE, 0.2, 0, 0});
    assert_true(advice.simplified < j.count);
    const psplat_row *row = &j.rows[advice.simplified];
    assert_int_equal(row->setting.competitor, PSPLAT_COMPETITOR_GLTFPACK);
    /* its distance is 0.97 / 6; the next ratio's, 0.97 / 3, is too large */
    assert_true(row->setting.ratio == 0.2);
    advice = advise(&j, (psplat_demand){PSPLAT_ERROR_KIND_DISTANCE, 1e-6, 0, 0});
    assert_true(advice.simplified == SIZE_MAX);
    psplat_sweep_table_free(&j);
}

/* Without limits, each asset has at most one row, drawn in the best way. */
static void test_front(void **state) {
    (void)state;
    psplat_sweep_table j = make_table(1);
    size_t order[128];
    uint8_t is_front[128];
    size_t count = psplat_advise_front(j.rows, j.count, order, is_front);
    /* What convert writes beats floats except where these are the most accurate. */
    assert_int_equal(count, 6);
    for (size_t i = 0; i < count; ++i) {
        const psplat_setting *s = &j.rows[order[i]].setting;
        assert_int_equal(s->competitor, PSPLAT_COMPETITOR_SPLATS);
        assert_int_equal(s->mode, PSPLAT_MODE_PHONG);
        assert_int_equal(s->form, i < 5 ? PSPLAT_FORM_USUAL : PSPLAT_FORM_FLOAT);
        assert_true(is_front[order[i]]);
        assert_true(!i || j.rows[order[i]].values[PSPLAT_COLUMN_BYTES] >
                              j.rows[order[i - 1]].values[PSPLAT_COLUMN_BYTES]);
    }
    psplat_sweep_table_free(&j);
    /* Flat looks half a percent better and takes longer, so that phong is taken; then it looks 4 %
     * better and is taken. */
    psplat_row rows[2] = {plain_row(100, 2, 1), plain_row(100, 1.99, 1.5)};
    rows[1].setting.mode = PSPLAT_MODE_FLAT;
    assert_int_equal(psplat_advise_front(rows, 2, order, is_front), 1);
    assert_int_equal(order[0], 0);
    rows[1].values[PSPLAT_COLUMN_DIFFERENCE] = 1.92;
    assert_int_equal(psplat_advise_front(rows, 2, order, is_front), 1);
    assert_int_equal(order[0], 1);
    rows[0].values[PSPLAT_COLUMN_DIFFERENCE] = rows[1].values[PSPLAT_COLUMN_DIFFERENCE] = NAN;
    assert_int_equal(psplat_advise_front(rows, 2, order, is_front), 0);
}

int test_advice_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_error_limits),   cmocka_unit_test(test_budgets),
        cmocka_unit_test(test_nearest_miss),   cmocka_unit_test(test_noise),
        cmocka_unit_test(test_missing_values), cmocka_unit_test(test_simplified),
        cmocka_unit_test(test_front),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_wire_width.c - tests of the width of wires: tubes of known diameter, straight, bent and of
 * two widths, and shapes that are no wires. Expected widths are those of prisms of as many sides.
 */
#include "tube_fixture.h"

#include "mesh/wire_width.h"

/* Appends a box with one corner at (0, 0, z). */
static void add_box(obj *o, double x, double y, double height, double z) {
    static const int quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                    {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    char *end = o->text + strlen(o->text);
    for (int v = 0; v < 8; ++v)
        end += sprintf(end, "v %g %g %g\n", v & 1 ? x : 0, v & 2 ? y : 0, z + (v & 4 ? height : 0));
    for (int f = 0; f < 6; ++f)
        end += sprintf(end, "f %d %d %d %d\n", o->vertices + quads[f][0] + 1,
                       o->vertices + quads[f][1] + 1, o->vertices + quads[f][2] + 1,
                       o->vertices + quads[f][3] + 1);
    o->vertices += 8;
}

static double width_of(const obj *o) {
    psplat_mesh mesh = read_text("wires.obj", o->text);
    double width = 0;
    assert_int_equal(psplat_mesh_wire_width(&mesh, &width), PSPLAT_OK);
    psplat_mesh_free(&mesh);
    return width;
}

/* Returns the area of a prism's sides and ends over the integral of its mean curvature: its edges
 * turn by 2 pi in all along its length, and those of its ends by pi / 2 each. */
static double prism_width(double radius, double length) {
    double side = 2 * radius * sin(tube_pi / TUBE_SIDES);
    double end = TUBE_SIDES * radius * radius * sin(2 * tube_pi / TUBE_SIDES) / 2;
    return (TUBE_SIDES * side * length + 2 * end) /
           (tube_pi * length + TUBE_SIDES * side * tube_pi / 2);
}

static void test_tubes(void **state) {
    (void)state;
    obj straight = {{0}, 0}, fine = straight, bent = straight;
    add_tube(&straight, 0.01, 1, 0, 1, 0);
    add_tube(&fine, 0.01, 1, 0, 40, 0);
    add_tube(&bent, 0.01, 1, 3, 40, 0);
    double expected = prism_width(0.01, 1);
    assert_near(expected, 0.02, 0.001);                          /* about the diameter */
    assert_near(width_of(&straight), expected, 1e-6 * expected); /* of the text's digits */
    assert_near(width_of(&fine), expected, 1e-6 * expected);
    /* A bend changes neither area nor curvature but for the steps of the rings. */
    assert_near(width_of(&bent), expected, 0.01 * expected);
}

/* Of two widths, that of the narrower wires counts where these have half of the area. */
static void test_two_widths(void **state) {
    (void)state;
    obj narrow = {{0}, 0}, wide = narrow;
    add_tube(&narrow, 0.01, 3, 0, 1, 0);
    add_tube(&narrow, 0.02, 1, 0, 1, 1);
    add_tube(&wide, 0.01, 1, 0, 1, 0);
    add_tube(&wide, 0.02, 3, 0, 1, 1);
    assert_near(width_of(&narrow), prism_width(0.01, 3), 1e-8);
    assert_near(width_of(&wide), prism_width(0.02, 3), 1e-8);
}

/* A thin plate five times as long as wide is a wire, whose width is of the order of the plate's. */
static void test_slat(void **state) {
    (void)state;
    obj slat = {{0}, 0};
    add_box(&slat, 1, 0.2, 0.001, 0);
    double area = 2 * (0.2 + 0.001 + 0.0002), curvature = tube_pi * (1 + 0.2 + 0.001);
    assert_near(width_of(&slat), area / curvature, 1e-9);
}

/* Plates, balls of few sides and cubes are no wires, and neither are wires that have less than half
 * of the area. */
static void test_others(void **state) {
    (void)state;
    obj plate = {{0}, 0}, cube = plate, both = plate;
    add_box(&plate, 1, 0.5, 0.001, 0);
    add_box(&cube, 1, 1, 1, 0);
    add_box(&both, 0.3, 0.3, 0.3, 1);
    add_tube(&both, 0.01, 1, 0, 1, 0);
    assert_true(width_of(&plate) == HUGE_VAL);
    assert_true(width_of(&cube) == HUGE_VAL);
    assert_true(width_of(&both) == HUGE_VAL);
}

/* A tube that faces inwards, as the inside of a hollow one does, is concave. */
static void test_inside(void **state) {
    (void)state;
    obj inside = {{0}, 0};
    add_tube(&inside, 0.01, 1, 0, 1, 0);
    psplat_mesh mesh = read_text("wires.obj", inside.text);
    double width = 0;
    for (size_t t = 0; t < mesh.triangle_count; ++t) { /* It faces inwards now. */
        uint32_t held = mesh.triangles[3 * t];
        mesh.triangles[3 * t] = mesh.triangles[3 * t + 1];
        mesh.triangles[3 * t + 1] = held;
    }
    assert_int_equal(psplat_mesh_wire_width(&mesh, &width), PSPLAT_OK);
    assert_true(width == HUGE_VAL);
    psplat_mesh_free(&mesh);
}

int test_wire_width_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tubes),  cmocka_unit_test(test_two_widths),
        cmocka_unit_test(test_slat),   cmocka_unit_test(test_others),
        cmocka_unit_test(test_inside),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

/* SPDX-License-Identifier: MIT
 *
 * part.c - the machined part: a bearing block on a stepped base.
 *
 * Seen from above, in units of the bore's axis at (0, 0):
 *
 *      bite ) ____________________ notch
 *         _)         \            |
 *        |  .--.      \ step      |____   <- reflex corner
 *        | |boss)      |               |
 *        |  '--'      /         ()     |   <- countersunk hole
 *        |___________/_________________)   <- rounded corner
 *
 * Flat, cylindrical, conical and blended faces; convex, concave and curved creases; where the blend
 * of the boss turns round its two back corners, the crease is an arc of an ellipse that ends
 * nowhere flat.
 */
#include "generate.h"

#include <math.h>

#define STEP 0.125 /* target edge length */

/* The heights of the part's faces. Walls have vertices at all of them, so that neighbours of
 * different heights fit. */
static const double floor_z = 0, ledge_z = 0.6, base_z = 1.1, boss_z = 2.5;

static const double bore_radius = 0.55, boss_radius = 1.1, boss_back = -1.25, blend = 0.3;
static const double sink_z = 0.36, sink_radius = 0.62, hole_radius = 0.38;
static const double hole_center[2] = {2.9, -0.9};
static const double left = -2.0, right = 4.1, half_width = 2.1;
static const double step_radius = 2.35, corner_radius = 1.2, bite_radius = 0.95;
static const double notch_x = 3.0, notch_y = 0.75;

static int rows_for(double height) {
    int rows = (int)floor(fabs(height) / STEP + 0.5);
    return rows < 1 ? 1 : rows;
}

/* Adds the band between two outlines of equal count: a's points lie at height za and b's at zb.
 * Where b is above a, the faces look to the right of the direction of travel. is_open leaves the
 * last segment out. */
static void add_band(solid *s, const outline *a, double za, const outline *b, double zb,
                     int is_open) {
    for (size_t i = 0; i + (size_t)is_open < a->count; ++i) {
        size_t j = (i + 1) % a->count;
        solid_quad(s, solid_vertex(s, a->points[i][0], a->points[i][1], za),
                   solid_vertex(s, a->points[j][0], a->points[j][1], za),
                   solid_vertex(s, b->points[j][0], b->points[j][1], zb),
                   solid_vertex(s, b->points[i][0], b->points[i][1], zb));
    }
}

/* Adds an upright wall over an outline from z0 up to z1. */
static void add_wall(solid *s, const outline *o, double z0, double z1, int is_open) {
    int rows = rows_for(z1 - z0);
    for (int row = 0; row < rows; ++row) {
        double low = z0 + (z1 - z0) * row / rows;
        double high = row + 1 == rows ? z1 : z0 + (z1 - z0) * (row + 1) / rows;
        add_band(s, o, low, o, high, is_open);
    }
}

/* Adds the inside of a hole: a wall that looks the other way. */
static void add_bore(solid *s, const outline *o, double z0, double z1) {
    int rows = rows_for(z1 - z0);
    for (int row = rows; row > 0; --row) {
        double high = row == rows ? z1 : z0 + (z1 - z0) * row / rows;
        double low = row == 1 ? z0 : z0 + (z1 - z0) * (row - 1) / rows;
        add_band(s, o, high, o, low, 0);
    }
}

static outline circle(double x, double y, double radius, double step) {
    outline o = {0};
    outline_arc(&o, x, y, radius, 0, 2 * PI, step);
    --o.count; /* the last point repeats the first */
    return o;
}

/* Builds the outline of the base in two stretches that meet at the ends of the step. */
static outline base_right(double end_x) {
    outline o = {0};
    outline_point(&o, end_x, -half_width);
    outline_line(&o, right - corner_radius, -half_width, STEP);
    outline_arc(&o, right - corner_radius, -half_width + corner_radius, corner_radius, -PI / 2, 0,
                STEP);
    outline_line(&o, right, notch_y, STEP);
    outline_line(&o, notch_x, notch_y, STEP);
    outline_line(&o, notch_x, half_width, STEP);
    outline_line(&o, end_x, half_width, STEP);
    return o;
}

static outline base_left(double end_x) {
    outline o = {0};
    outline_point(&o, end_x, half_width);
    outline_line(&o, left + bite_radius, half_width, STEP);
    outline_arc(&o, left, half_width, bite_radius, 0, -PI / 2, STEP);
    outline_line(&o, left, -half_width, STEP);
    outline_line(&o, end_x, -half_width, STEP);
    return o;
}

/* Builds the arc of the step from its lower end to its upper one; its ends are exactly where the
 * base's outline has them. */
static outline step_arc(double end_x) {
    outline o = {0};
    double angle = atan2(half_width, end_x);
    outline_arc(&o, 0, 0, step_radius, -angle, angle, STEP);
    o.points[0][0] = o.points[o.count - 1][0] = end_x;
    o.points[0][1] = -half_width;
    o.points[o.count - 1][1] = half_width;
    return o;
}

static outline boss_outline(void) {
    outline o = {0};
    outline_point(&o, boss_back, -boss_radius);
    outline_line(&o, 0, -boss_radius, STEP);
    outline_arc(&o, 0, 0, boss_radius, -PI / 2, PI / 2, STEP);
    outline_line(&o, boss_back, boss_radius, STEP);
    outline_line(&o, boss_back, -boss_radius, STEP);
    --o.count;
    return o;
}

static outline copy(const outline *o) {
    outline c = {0};
    for (size_t i = 0; i < o->count; ++i) outline_point(&c, o->points[i][0], o->points[i][1]);
    return c;
}

/* Returns a followed by b (backwards if reversed), without b's end points. */
static outline joined(const outline *a, const outline *b, int reversed) {
    outline o = {0};
    for (size_t i = 0; i < a->count; ++i) outline_point(&o, a->points[i][0], a->points[i][1]);
    for (size_t i = 1; i + 1 < b->count; ++i) {
        const double *p = b->points[reversed ? b->count - 1 - i : i];
        outline_point(&o, p[0], p[1]);
    }
    return o;
}

/* Adds a quarter round from the wall to the top and returns the outline of the rest of the top. */
static outline add_blend(solid *s, const outline *o) {
    int rows = rows_for(blend * PI / 2) + 1;
    outline below = copy(o);
    for (int row = 1; row <= rows; ++row) {
        double a = PI / 2 * (row - 1) / rows, b = PI / 2 * row / rows;
        outline above = outline_inset(o, row == rows ? blend : blend * (1 - cos(b)));
        double za = row == 1 ? boss_z - blend : boss_z - blend + blend * sin(a);
        double zb = row == rows ? boss_z : boss_z - blend + blend * sin(b);
        add_band(s, &below, za, &above, zb, 0);
        outline_free(&below);
        below = above;
    }
    return below;
}

static void add_boss(solid *s, const outline *boss, const outline *bore) {
    add_wall(s, boss, base_z, boss_z - blend, 0);
    outline top = add_blend(s, boss);
    solid_face(s, &top, bore, 1, boss_z, STEP, 1);
    outline_free(&top);
    add_bore(s, bore, floor_z, boss_z);
}

static void add_hole(solid *s, const outline *hole, const outline *sink) {
    add_bore(s, hole, floor_z, sink_z);
    int rows = rows_for(hypot(ledge_z - sink_z, sink_radius - hole_radius));
    outline above = copy(sink);
    for (int row = 1; row <= rows; ++row) {
        double t0 = (double)(row - 1) / rows, t1 = (double)row / rows;
        outline below = copy(sink);
        for (size_t i = 0; i < below.count; ++i)
            for (int k = 0; k < 2; ++k)
                below.points[i][k] = row == rows
                                         ? hole->points[i][k]
                                         : sink->points[i][k] * (1 - t1) + hole->points[i][k] * t1;
        double z0 = row == 1 ? ledge_z : ledge_z + (sink_z - ledge_z) * t0;
        double z1 = row == rows ? sink_z : ledge_z + (sink_z - ledge_z) * t1;
        add_band(s, &above, z0, &below, z1, 0);
        outline_free(&above);
        above = below;
    }
    outline_free(&above);
}

static void add_base(solid *s, const outline *boss, const outline *bore, const outline *hole,
                     const outline *sink) {
    double end_x = sqrt(step_radius * step_radius - half_width * half_width);
    outline east = base_right(end_x), west = base_left(end_x), arc = step_arc(end_x);
    outline whole = joined(&east, &west, 0);
    outline ledge = joined(&east, &arc, 1);
    outline plateau = joined(&west, &arc, 0);
    outline holes[2] = {*bore, *hole};
    add_wall(s, &east, floor_z, ledge_z, 1);
    add_wall(s, &west, floor_z, ledge_z, 1);
    add_wall(s, &west, ledge_z, base_z, 1);
    add_wall(s, &arc, ledge_z, base_z, 1);
    solid_face(s, &ledge, sink, 1, ledge_z, STEP, 1);
    solid_face(s, &plateau, boss, 1, base_z, STEP, 1);
    solid_face(s, &whole, holes, 2, floor_z, STEP, 0);
    outline_free(&east);
    outline_free(&west);
    outline_free(&arc);
    outline_free(&whole);
    outline_free(&ledge);
    outline_free(&plateau);
}

/* Turns the part, which is built standing on the x-y plane, so that y is up as in glTF. */
static void stand_up(solid *s) {
    for (size_t i = 0; i < s->vertex_count; ++i) {
        double *p = s->positions[i], y = p[1];
        p[1] = p[2];
        p[2] = -y;
    }
}

solid make_part(void) {
    solid s = {0};
    outline boss = boss_outline();
    outline bore = circle(0, 0, bore_radius, STEP * 0.8);
    /* Both rims of the countersink have the same number of points, so that a cone lies between
     * them. */
    outline sink = circle(hole_center[0], hole_center[1], sink_radius, STEP * 0.9);
    outline hole =
        circle(hole_center[0], hole_center[1], hole_radius, STEP * 0.9 * hole_radius / sink_radius);
    add_base(&s, &boss, &bore, &hole, &sink);
    add_boss(&s, &boss, &bore);
    add_hole(&s, &hole, &sink);
    outline_free(&boss);
    outline_free(&bore);
    outline_free(&hole);
    outline_free(&sink);
    stand_up(&s);
    return s;
}

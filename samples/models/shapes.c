/* SPDX-License-Identifier: MIT
 *
 * shapes.c - the simple models: box, sphere, torus, cone, bracket, and the two pieces of the
 * painted model.
 */
#include "generate.h"

#include <math.h>
#include <stdlib.h>

/* Adds a prism over a polygon with count corners (counter-clockwise); its caps are cut into the
 * given triangles. */
static void add_prism(solid *s, const double (*corners)[2], size_t count, double z0, double z1,
                      const uint32_t (*caps)[3], size_t cap_count) {
    uint32_t low[8], high[8];
    for (size_t i = 0; i < count; ++i) {
        low[i] = solid_vertex(s, corners[i][0], corners[i][1], z0);
        high[i] = solid_vertex(s, corners[i][0], corners[i][1], z1);
    }
    for (size_t i = 0; i < count; ++i) {
        size_t j = (i + 1) % count;
        solid_quad(s, low[i], low[j], high[j], high[i]);
    }
    for (size_t i = 0; i < cap_count; ++i) {
        solid_triangle(s, high[caps[i][0]], high[caps[i][1]], high[caps[i][2]]);
        solid_triangle(s, low[caps[i][0]], low[caps[i][2]], low[caps[i][1]]);
    }
}

solid make_box(double x, double y, double z) {
    solid s = {0};
    double corners[4][2] = {{-x / 2, -y / 2}, {x / 2, -y / 2}, {x / 2, y / 2}, {-x / 2, y / 2}};
    static const uint32_t caps[2][3] = {{0, 1, 2}, {0, 2, 3}};
    add_prism(&s, (const double(*)[2])corners, 4, -z / 2, z / 2, caps, 2);
    return s;
}

solid make_bracket(void) {
    solid s = {0};
    static const double corners[6][2] = {{0, 0}, {3, 0}, {3, 0.6}, {0.6, 0.6}, {0.6, 2}, {0, 2}};
    static const uint32_t caps[4][3] = {{0, 1, 3}, {1, 2, 3}, {0, 3, 5}, {3, 4, 5}};
    add_prism(&s, corners, 6, 0, 1.5, caps, 4);
    return s;
}

/* ---- sphere --------------------------------------------------------------------------------- */

static uint32_t sphere_vertex(solid *s, const double a[3], const double b[3]) {
    double p[3], length = 0;
    for (int k = 0; k < 3; ++k) {
        p[k] = a[k] + b[k]; /* both triangles at the edge get the same sum: addition commutes */
        length += p[k] * p[k];
    }
    length = sqrt(length);
    return solid_vertex(s, p[0] / length, p[1] / length, p[2] / length);
}

static solid subdivide(const solid *s) {
    solid finer = {0};
    for (size_t i = 0; i < s->triangle_count; ++i) {
        const uint32_t *t = s->triangles[i];
        uint32_t v[3], m[3];
        for (int k = 0; k < 3; ++k) {
            const double *p = s->positions[t[k]];
            v[k] = solid_vertex(&finer, p[0], p[1], p[2]);
            m[k] = sphere_vertex(&finer, p, s->positions[t[(k + 1) % 3]]);
        }
        for (int k = 0; k < 3; ++k) solid_triangle(&finer, v[k], m[k], m[(k + 2) % 3]);
        solid_triangle(&finer, m[0], m[1], m[2]);
    }
    return finer;
}

static solid make_icosahedron(void) {
    solid s = {0};
    static const uint32_t faces[20][3] = {
        {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
        {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
        {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    /* The corners of golden rectangles. */
    double a = 1 / sqrt(1 + (3 + sqrt(5)) / 2), b = a * (1 + sqrt(5)) / 2;
    for (int axis = 0; axis < 3; ++axis)
        for (int k = 0; k < 4; ++k) {
            double p[3];
            p[axis] = k % 2 ? a : -a;
            p[(axis + 1) % 3] = k / 2 ? -b : b;
            p[(axis + 2) % 3] = 0;
            solid_vertex(&s, p[0], p[1], p[2]);
        }
    for (int i = 0; i < 20; ++i) solid_triangle(&s, faces[i][0], faces[i][1], faces[i][2]);
    return s;
}

/* The sphere has authored normals: on the unit sphere they equal the positions. */
solid make_sphere(int subdivisions) {
    solid s = make_icosahedron();
    for (int i = 0; i < subdivisions; ++i) {
        solid finer = subdivide(&s);
        solid_free(&s);
        s = finer;
    }
    s.normals = resize(NULL, s.vertex_count * sizeof *s.normals);
    for (size_t i = 0; i < s.vertex_count; ++i)
        for (int k = 0; k < 3; ++k) s.normals[i][k] = (float)s.positions[i][k];
    return s;
}

/* ---- grids: surfaces over (u, v) ------------------------------------------------------------ */

solid make_torus(double major, double minor, int segments, int sides) {
    solid s = {0};
    for (int i = 0; i < segments; ++i)
        for (int j = 0; j < sides; ++j) {
            uint32_t v[4];
            for (int k = 0; k < 4; ++k) {
                double u = 2 * PI * ((i + (k == 1 || k == 2)) % segments) / segments;
                double w = 2 * PI * ((j + (k >= 2)) % sides) / sides;
                double r = major + minor * cos(w);
                v[k] = solid_vertex(&s, r * cos(u), r * sin(u), minor * sin(w));
            }
            solid_quad(&s, v[0], v[1], v[2], v[3]);
        }
    return s;
}

/* Makes points without triangles, evenly spread (a golden-angle spiral) over an ellipsoid without
 * its upper end. */
solid make_scan(double x, double y, double z, int count) {
    solid s = {0};
    s.normals = resize(NULL, (size_t)count * sizeof *s.normals);
    for (int i = 0; i < count; ++i) {
        double h = -1 + 1.8 * (i + 0.5) / count, r = sqrt(1 - h * h),
               angle = i * PI * (3 - sqrt(5));
        double n[3] = {r * cos(angle) / x, r * sin(angle) / y, h / z};
        double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        uint32_t v = solid_vertex(&s, x * r * cos(angle), y * r * sin(angle), z * h);
        for (int k = 0; k < 3; ++k) s.normals[v][k] = (float)(n[k] / length);
    }
    return s;
}

/* Adds rings of a cone or a disc, from radius r0 at height z0 to radius r1 at height z1. */
static void add_rings(solid *s, double r0, double z0, double r1, double z1, int segments,
                      int rings) {
    for (int ring = 0; ring < rings; ++ring)
        for (int i = 0; i < segments; ++i) {
            uint32_t v[4];
            for (int k = 0; k < 4; ++k) {
                double angle = 2 * PI * ((i + (k == 1 || k == 2)) % segments) / segments;
                double t = (double)(ring + (k >= 2)) / rings;
                double r = r0 + (r1 - r0) * t;
                v[k] = solid_vertex(s, r * cos(angle), r * sin(angle), z0 + (z1 - z0) * t);
            }
            solid_quad(s, v[0], v[1], v[2], v[3]);
        }
}

solid make_cone(double radius, double height, int segments) {
    solid s = {0};
    add_rings(&s, radius, 0, 0, height, segments, segments / 6);
    add_rings(&s, 0, 0, radius, 0, segments, segments / 8);
    return s;
}

/* ---- the painted piece ---------------------------------------------------------------------- */

/* Makes a surface of revolution row by row. Its seam is there twice, so that texture coordinates
 * can run from 0 to 1; for that, positions are added directly instead of being joined. */
static solid make_lathe(const double (*profile)[2], int rows, int segments) {
    solid s = {0};
    size_t count = (size_t)rows * (size_t)(segments + 1);
    s.vertex_count = s.vertex_capacity = count;
    s.positions = resize(NULL, count * sizeof *s.positions);
    s.texcoords = resize(NULL, count * sizeof *s.texcoords);
    for (int row = 0; row < rows; ++row)
        for (int i = 0; i <= segments; ++i) {
            size_t v = (size_t)row * (size_t)(segments + 1) + (size_t)i;
            double angle = 2 * PI * (i % segments) / segments;
            s.positions[v][0] = profile[row][0] * cos(angle);
            s.positions[v][1] = profile[row][1];
            s.positions[v][2] = -profile[row][0] * sin(angle);
            s.texcoords[v][0] = (float)i / (float)segments;
            s.texcoords[v][1] = 1 - (float)row / (float)(rows - 1);
        }
    for (int row = 0; row + 1 < rows; ++row)
        for (int i = 0; i < segments; ++i) {
            uint32_t v = (uint32_t)(row * (segments + 1) + i), w = v + (uint32_t)segments + 1;
            solid_triangle(&s, v, v + 1, w + 1);
            solid_triangle(&s, v, w + 1, w);
        }
    return s;
}

solid make_vase(void) {
    enum { ROWS = 25 };
    double profile[ROWS][2];
    for (int row = 0; row < ROWS; ++row) {
        double t = (double)row / (ROWS - 1);
        profile[row][0] = 0.45 + 0.25 * sin(PI * (1.5 * t + 0.15));
        profile[row][1] = 1.6 * t;
    }
    return make_lathe((const double(*)[2])profile, ROWS, 48);
}

solid make_ribbon(void) {
    solid s = make_torus(0.62, 0.09, 40, 12);
    s.colors = resize(NULL, s.vertex_count * sizeof *s.colors);
    for (size_t i = 0; i < s.vertex_count; ++i) {
        double angle = atan2(s.positions[i][1], s.positions[i][0]);
        for (int k = 0; k < 3; ++k)
            s.colors[i][k] = (uint8_t)(128.5 + 126 * cos(angle - 2 * PI * k / 3));
        s.colors[i][3] = 255;
    }
    return s;
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * outline.c - outlines of a mesh and of splats on a grid. Both are scattered as points that are
 * nearer to each other than cells are wide, so that each covers every cell that it meets, and what
 * that adds to one outline it adds to the other.
 */
#include "measure/outline.h"

#include "base/region.h"
#include "base/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DIRECTIONS = 12, CELLS = 384 };
enum { OF_MESH = 1, OF_SPLATS = 2 };
static const double grid_radii = 1.5;        /* half the grid, in radii of the bounding sphere */
static const double cells_apart = 0.5;       /* points */
static const double greatest_stretch = 4.2;  /* of a surface over its plane (spec 3.4) */
static const double golden_angle = 2.399963; /* radians: the directions lie on a spiral */

/* A view: the axes of the picture in cells. */
typedef struct grid {
    double x[3], y[3], center[3];
    uint8_t *cells; /* CELLS x CELLS, OF_MESH and OF_SPLATS */
} grid;

static void find_sphere(const psplat_mesh *mesh, double center[3], double *radius) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    *radius = 0;
    for (size_t i = 0; i < 3 * mesh->vertex_count; ++i) {
        low[i % 3] = fmin(low[i % 3], mesh->positions[i]);
        high[i % 3] = fmax(high[i % 3], mesh->positions[i]);
    }
    for (int k = 0; k < 3; ++k) center[k] = (low[k] + high[k]) / 2;
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        double d[3];
        sub3(d, mesh->positions + 3 * i, center);
        *radius = fmax(*radius, sqrt(dot3(d, d)));
    }
}

/* Sets the axes of a direction of a half sphere, since from behind outlines are the same. */
static void set_axes(grid *g, int direction, double cells_per_length) {
    double height = (direction + 0.5) / DIRECTIONS, angle = direction * golden_angle;
    double ring = sqrt(1 - height * height);
    const double x[3] = {-sin(angle), cos(angle), 0};
    const double y[3] = {-cos(angle) * height, -sin(angle) * height, ring};
    for (int k = 0; k < 3; ++k) {
        g->x[k] = cells_per_length * x[k];
        g->y[k] = cells_per_length * y[k];
    }
}

static void project(const grid *g, const double point[3], double at[2]) {
    double d[3];
    sub3(d, point, g->center);
    at[0] = dot3(d, g->x) + CELLS / 2.0;
    at[1] = dot3(d, g->y) + CELLS / 2.0;
}

static void mark(const grid *g, const double at[2], uint8_t what) {
    if (!(at[0] >= 0 && at[0] < CELLS && at[1] >= 0 && at[1] < CELLS)) return;
    g->cells[(size_t)at[1] * CELLS + (size_t)at[0]] |= what;
}

static int steps_of(double cells) {
    return (int)ceil(fmin(cells / cells_apart, 4 * CELLS)) + 1;
}

static double distance_of(const double a[2], const double b[2]) {
    return hypot(b[0] - a[0], b[1] - a[1]);
}

/* Marks rows of points that are parallel to the longest side, so that slivers take few. */
static void mark_triangle(const grid *g, const psplat_mesh *mesh, size_t triangle) {
    double at[3][2], sides[3];
    int longest = 0;
    for (int k = 0; k < 3; ++k)
        project(g, mesh->positions + 3 * (size_t)mesh->triangles[3 * triangle + (size_t)k], at[k]);
    for (int k = 0; k < 3; ++k) {
        sides[k] = distance_of(at[k], at[(k + 1) % 3]);
        if (sides[k] > sides[longest]) longest = k;
    }
    const double *a = at[longest], *b = at[(longest + 1) % 3], *apex = at[(longest + 2) % 3];
    int rows = steps_of(fmin(sides[(longest + 1) % 3], sides[(longest + 2) % 3]));
    for (int i = 0; i <= rows; ++i) {
        double t = (double)i / rows;
        int columns = steps_of(sides[longest] * (1 - t));
        for (int k = 0; k <= columns; ++k) {
            double u = (1 - t) * k / columns, v = 1 - t - u;
            const double p[2] = {u * a[0] + v * b[0] + t * apex[0],
                                 u * a[1] + v * b[1] + t * apex[1]};
            mark(g, p, OF_MESH);
        }
    }
}

static void mark_splat(const grid *g, const psplat_region *region) {
    double cells = sqrt(dot3(g->x, g->x));
    double slope =
        hypot(region->slope[0], region->slope[1]) + psplat_region_bend(region) * region->radius[0];
    double stretch = fmin(sqrt(1 + slope * slope), greatest_stretch);
    int steps[2];
    for (int k = 0; k < 2; ++k) steps[k] = steps_of(2 * region->radius[k] * cells * stretch);
    for (int i = 0; i <= steps[0]; ++i)
        for (int k = 0; k <= steps[1]; ++k) {
            const double uv[2] = {2.0 * i / steps[0] - 1, 2.0 * k / steps[1] - 1};
            double point[3], at[2];
            if (!psplat_region_contains(region, uv, 1, 0)) continue;
            psplat_region_point(region, uv, point);
            project(g, point, at);
            mark(g, at, OF_SPLATS);
        }
}

/* Returns the error in cells. */
static double measure_direction(const grid *g, const psplat_mesh *mesh,
                                const psplat_region *regions, size_t count) {
    size_t covered = 0, different = 0;
    for (size_t i = 0; i < mesh->triangle_count; ++i) mark_triangle(g, mesh, i);
    for (size_t i = 0; i < count; ++i) mark_splat(g, &regions[i]);
    for (size_t i = 0; i < (size_t)CELLS * CELLS; ++i) {
        covered += (g->cells[i] & OF_MESH) != 0;
        different += g->cells[i] == OF_MESH || g->cells[i] == OF_SPLATS;
    }
    return covered ? (double)different / (4 * sqrt((double)covered)) : 0;
}

psplat_result psplat_outline_measure(const psplat_mesh *mesh, const psplat_splats *splats,
                                     double *outline, psplat_error *error) {
    double center[3], radius, errors[DIRECTIONS] = {0};
    psplat_region *regions = psplat_splat_regions(splats);
    uint8_t *cells = calloc(DIRECTIONS, (size_t)CELLS * CELLS);
    *outline = 0;
    find_sphere(mesh, center, &radius);
    double cells_per_length = radius > 0 ? CELLS / (2 * grid_radii * radius) : 0;
    if (!regions || !cells) {
        free(regions);
        free(cells);
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while measuring outlines");
    }
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < DIRECTIONS; ++i) {
        grid g = {.cells = cells + (size_t)i * CELLS * CELLS};
        memcpy(g.center, center, sizeof g.center);
        set_axes(&g, i, cells_per_length);
        errors[i] = measure_direction(&g, mesh, regions, splats->count);
    }
    for (int i = 0; i < DIRECTIONS && cells_per_length > 0; ++i)
        *outline += errors[i] / (DIRECTIONS * cells_per_length);
    free(regions);
    free(cells);
    return PSPLAT_OK;
}

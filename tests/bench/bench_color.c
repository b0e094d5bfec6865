/* SPDX-License-Identifier: MIT
 *
 * bench_color.c - measures what colours that change over each splat are worth: the same model gets
 * constant and linear colours at several bounds of the colour's error.
 *
 *     bench_color [--effort N] [--tolerance PERCENT] [--bounds N] [MODEL...]
 *
 * The first model is a sphere of smooth colours; the given ones follow.
 *
 * Errors are those of the blended base colour, root mean square and 95th percentile, in percent of
 * sRGB's range. One column of bytes counts the colours alone, 3 a splat, or 9 with both gradients;
 * the other adds 12 a splat for everything else. Files of other precisions differ by the same
 * factor in both columns. "chosen" is what the converter picks by itself.
 */
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 48, BOUNDS = 4 };
static const double pi = 3.14159265358979323846;
static const double bounds[BOUNDS] = {20, 10, 5, 2.5};
enum { SHAPE_BYTES = 12, COLOR_BYTES = 3, CHANGE_BYTES = 6 };

static void check(psplat_result result, const psplat_error *error) {
    if (result == PSPLAT_OK) return;
    fprintf(stderr, "bench_color: %s\n", error->text);
    exit(1);
}

/* ---- a sphere of smooth colours ------------------------------------------------------------- */

static void put_vertex(psplat_mesh *mesh, size_t row, size_t column) {
    double theta = pi * (double)row / STEPS, phi = pi * (double)column / STEPS;
    double *p = mesh->positions + 3 * (row * 2 * STEPS + column);
    p[0] = sin(theta) * cos(phi), p[1] = cos(theta), p[2] = sin(theta) * sin(phi);
}

static void put_triangle(psplat_mesh *mesh, size_t a, size_t b, size_t c) {
    const size_t vertices[3] = {a, b, c};
    for (size_t i = 0; i < 3; ++i) {
        size_t corner = 3 * mesh->triangle_count + i;
        const double *p = mesh->positions + 3 * vertices[i];
        float *color = mesh->corner_colors + 4 * corner;
        mesh->triangles[corner] = (uint32_t)vertices[i];
        color[0] = (float)(0.5 + 0.45 * p[0]), color[1] = (float)(0.5 + 0.45 * p[1] * p[2]);
        color[2] = (float)(0.5 + 0.45 * sin(3 * p[1])), color[3] = 1;
    }
    ++mesh->triangle_count;
}

static void make_sphere(psplat_mesh *mesh) {
    size_t vertices = (STEPS + 1) * 2 * STEPS, triangles = 4 * STEPS * STEPS;
    *mesh = (psplat_mesh){.vertex_count = vertices,
                          .material = {.base_color = {1, 1, 1, 1}, .roughness = 0.5f}};
    mesh->positions = calloc(3 * vertices, sizeof *mesh->positions);
    mesh->triangles = calloc(3 * triangles, sizeof *mesh->triangles);
    mesh->corner_colors = calloc(12 * triangles, sizeof *mesh->corner_colors);
    if (!mesh->positions || !mesh->triangles || !mesh->corner_colors) abort();
    for (size_t row = 0; row <= STEPS; ++row)
        for (size_t column = 0; column < 2 * STEPS; ++column) put_vertex(mesh, row, column);
    for (size_t row = 0; row < STEPS; ++row)
        for (size_t column = 0; column < 2 * STEPS; ++column) {
            size_t next = (column + 1) % (2 * STEPS), a = row * 2 * STEPS, b = a + 2 * STEPS;
            /* The first and the last row are the poles, where all vertices are one. */
            if (row == 0) put_triangle(mesh, 0, b + next, b + column);
            if (row > 0) put_triangle(mesh, a + column, a + next, b + column);
            if (row > 0 && row < STEPS - 1) put_triangle(mesh, a + next, b + next, b + column);
        }
}

/* ---- measuring ------------------------------------------------------------------------------ */

typedef struct options {
    double tolerance;
    int effort, bounds;
} options;

/* Converts once and measures errors and sizes. Returns whether the colours change over splats. */
static int measure(const psplat_mesh *mesh, const options *o, double bound,
                   psplat_color_field field, int print) {
    const psplat_convert_desc desc = {.tolerance_percent = o->tolerance,
                                      .color_tolerance_percent = bound,
                                      .color_field = field,
                                      .effort = o->effort ? o->effort : PSPLAT_EFFORT_NONE,
                                      .unverified = !print};
    psplat_splats splats;
    psplat_report r;
    psplat_error error;
    check(psplat_convert(mesh, &desc, &splats, &r, &error), &error);
    int changes = 0;
    for (size_t i = 0; i < splats.count && splats.finishes; ++i)
        for (int k = 0; k < 3; ++k) {
            changes |= splats.finishes[i].color_u[k] < 0 || splats.finishes[i].color_u[k] > 0;
            changes |= splats.finishes[i].color_v[k] < 0 || splats.finishes[i].color_v[k] > 0;
        }
    size_t color = splats.count * (size_t)(COLOR_BYTES + (changes ? CHANGE_BYTES : 0));
    if (print)
        printf(" %6zu %7.2f %7.2f %8zu %8zu |", splats.count, r.rms_color_percent,
               r.p95_color_percent, color, color + splats.count * SHAPE_BYTES);
    psplat_splats_free(&splats);
    return changes;
}

static void report(const char *name, const psplat_mesh *mesh, const options *o) {
    for (int i = 0; i < o->bounds; ++i) {
        printf("%-16.16s %5g |", name, bounds[i]);
        fflush(stdout);
        measure(mesh, o, bounds[i], PSPLAT_COLOR_FIELD_CONSTANT, 1);
        fflush(stdout);
        measure(mesh, o, bounds[i], PSPLAT_COLOR_FIELD_LINEAR, 1);
        fflush(stdout);
        int chosen = measure(mesh, o, bounds[i], PSPLAT_COLOR_FIELD_CHOSEN, 0);
        printf(" %s\n", chosen ? "linear" : "constant");
    }
}

static const char *file_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

int main(int argc, char **argv) {
    options o = {.tolerance = 0.5, .effort = PSPLAT_DEFAULT_EFFORT, .bounds = BOUNDS};
    psplat_mesh mesh;
    int at = 1;
    for (; at + 1 < argc && !strncmp(argv[at], "--", 2); at += 2) {
        if (!strcmp(argv[at], "--effort")) o.effort = atoi(argv[at + 1]);
        if (!strcmp(argv[at], "--bounds") && atoi(argv[at + 1]) < BOUNDS)
            o.bounds = atoi(argv[at + 1]);
        if (!strcmp(argv[at], "--tolerance")) o.tolerance = atof(argv[at + 1]);
    }
    printf(
        "%-22s | constant: splats, rms, p95, bytes of | linear: the same                     |\n"
        "%-16s %5s | colours, of all                      |                                      "
        "| chosen\n",
        "", "model", "bound");
    make_sphere(&mesh);
    report("sphere", &mesh, &o);
    psplat_mesh_free(&mesh);
    for (; at < argc; ++at) {
        psplat_error error;
        check(psplat_mesh_read(argv[at], &mesh, &error), &error);
        report(file_of(argv[at]), &mesh, &o);
        psplat_mesh_free(&mesh);
    }
    return 0;
}

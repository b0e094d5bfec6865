/* SPDX-License-Identifier: MIT
 *
 * formats.c - writes OBJ, OFF, PLY, STL and XYZ. Text has six digits after the point. Binary files
 * are little-endian on every machine.
 */
#include "generate.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static int finish(FILE *file) {
    int failed = ferror(file);
    return fclose(file) || failed ? -1 : 0;
}

/* Removes the sign of a zero: what differs from zero only by rounding becomes zero. */
static double tidy(double x) {
    return fabs(x) < 1e-12 ? 0.0 : x;
}

static void print_positions(FILE *file, const char *prefix, const solid *s) {
    for (size_t i = 0; i < s->vertex_count; ++i) {
        const double *p = s->positions[i];
        fprintf(file, "%s%.7g %.7g %.7g\n", prefix, tidy(p[0]), tidy(p[1]), tidy(p[2]));
    }
}

int write_obj(const char *path, const solid *s) {
    FILE *file = fopen(path, "wb");
    if (!file) return -1;
    print_positions(file, "v ", s);
    for (size_t i = 0; i < s->triangle_count; ++i) {
        const uint32_t *t = s->triangles[i];
        fprintf(file, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
    }
    return finish(file);
}

static void print_triangles(FILE *file, const solid *s) {
    for (size_t i = 0; i < s->triangle_count; ++i) {
        const uint32_t *t = s->triangles[i];
        fprintf(file, "3 %u %u %u\n", t[0], t[1], t[2]);
    }
}

int write_off(const char *path, const solid *s) {
    FILE *file = fopen(path, "wb");
    if (!file) return -1;
    fprintf(file, "OFF\n%zu %zu 0\n", s->vertex_count, s->triangle_count);
    print_positions(file, "", s);
    print_triangles(file, s);
    return finish(file);
}

static void print_ply_header(FILE *file, const solid *s, const char *encoding) {
    fprintf(file, "ply\nformat %s 1.0\nelement vertex %zu\n", encoding, s->vertex_count);
    fputs("property float x\nproperty float y\nproperty float z\n", file);
    if (s->normals) fputs("property float nx\nproperty float ny\nproperty float nz\n", file);
    fprintf(file, "element face %zu\nproperty list uchar int vertex_indices\nend_header\n",
            s->triangle_count);
}

int write_ply_text(const char *path, const solid *s) {
    FILE *file = fopen(path, "wb");
    if (!file) return -1;
    print_ply_header(file, s, "ascii");
    print_positions(file, "", s);
    print_triangles(file, s);
    return finish(file);
}

static void put_u32(FILE *file, uint32_t value) {
    for (int i = 0; i < 4; ++i) fputc((int)(value >> (8 * i) & 255), file);
}

static void put_float(FILE *file, double value) {
    float single = (float)tidy(value);
    uint32_t bits;
    memcpy(&bits, &single, sizeof bits);
    put_u32(file, bits);
}

int write_ply_binary(const char *path, const solid *s) {
    FILE *file = fopen(path, "wb");
    if (!file) return -1;
    print_ply_header(file, s, "binary_little_endian");
    for (size_t i = 0; i < s->vertex_count; ++i) {
        for (int k = 0; k < 3; ++k) put_float(file, s->positions[i][k]);
        for (int k = 0; k < 3 && s->normals; ++k) put_float(file, (double)s->normals[i][k]);
    }
    for (size_t i = 0; i < s->triangle_count; ++i) {
        fputc(3, file);
        for (int k = 0; k < 3; ++k) put_u32(file, s->triangles[i][k]);
    }
    return finish(file);
}

static void normal_of(const solid *s, const uint32_t t[3], double n[3]) {
    const double *a = s->positions[t[0]], *b = s->positions[t[1]], *c = s->positions[t[2]];
    double length = 0;
    for (int k = 0; k < 3; ++k) {
        int u = (k + 1) % 3, v = (k + 2) % 3;
        n[k] = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
        length += n[k] * n[k];
    }
    for (int k = 0; k < 3; ++k) n[k] /= sqrt(length);
}

int write_stl_binary(const char *path, const solid *s) {
    FILE *file = fopen(path, "wb");
    if (!file) return -1;
    char header[80] = "phongsplat sample model";
    fwrite(header, 1, sizeof header, file);
    put_u32(file, (uint32_t)s->triangle_count);
    for (size_t i = 0; i < s->triangle_count; ++i) {
        const uint32_t *t = s->triangles[i];
        double n[3];
        normal_of(s, t, n);
        for (int k = 0; k < 3; ++k) put_float(file, n[k]);
        for (int k = 0; k < 9; ++k) put_float(file, s->positions[t[k / 3]][k % 3]);
        fputc(0, file);
        fputc(0, file);
    }
    return finish(file);
}

int write_stl_text(const char *path, const solid *s) {
    FILE *file = fopen(path, "wb");
    if (!file) return -1;
    fputs("solid phongsplat\n", file);
    for (size_t i = 0; i < s->triangle_count; ++i) {
        const uint32_t *t = s->triangles[i];
        double n[3];
        normal_of(s, t, n);
        fprintf(file, "facet normal %.7g %.7g %.7g\n outer loop\n", tidy(n[0]), tidy(n[1]),
                tidy(n[2]));
        for (int k = 0; k < 3; ++k) {
            const double *p = s->positions[t[k]];
            fprintf(file, "  vertex %.7g %.7g %.7g\n", tidy(p[0]), tidy(p[1]), tidy(p[2]));
        }
        fputs(" endloop\nendfacet\n", file);
    }
    fputs("endsolid phongsplat\n", file);
    return finish(file);
}

int write_xyz(const char *path, const solid *s) {
    FILE *file = fopen(path, "wb");
    if (!file) return -1;
    fputs("# x y z nx ny nz\n", file);
    for (size_t i = 0; i < s->vertex_count; ++i) {
        const double *p = s->positions[i];
        const float *n = s->normals[i];
        fprintf(file, "%.7g %.7g %.7g %.4f %.4f %.4f\n", tidy(p[0]), tidy(p[1]), tidy(p[2]),
                (double)n[0], (double)n[1], (double)n[2]);
    }
    return finish(file);
}

/* SPDX-License-Identifier: MIT
 *
 * solid.c - a mesh under construction. Looking a position up is linear in the number of vertices,
 * which is enough for models of this size.
 */
#include "generate.h"

#include <stdio.h>
#include <stdlib.h>

void *resize(void *memory, size_t size) {
    void *larger = realloc(memory, size);
    if (!larger) {
        fputs("generate_models: out of memory\n", stderr);
        exit(1);
    }
    return larger;
}

uint32_t solid_vertex(solid *s, double x, double y, double z) {
    /* Searches the newest vertices first, because a patch mostly meets the points it has just
     * made. */
    for (size_t i = s->vertex_count; i-- > 0;) {
        const double *p = s->positions[i];
        if (p[0] == x && p[1] == y && p[2] == z) return (uint32_t)i;
    }
    if (s->vertex_count == s->vertex_capacity) {
        s->vertex_capacity = s->vertex_capacity * 2 + 64;
        s->positions = resize(s->positions, s->vertex_capacity * sizeof *s->positions);
    }
    double *p = s->positions[s->vertex_count];
    p[0] = x;
    p[1] = y;
    p[2] = z;
    return (uint32_t)s->vertex_count++;
}

void solid_triangle(solid *s, uint32_t a, uint32_t b, uint32_t c) {
    if (a == b || b == c || c == a) return; /* a triangle at a pole has two equal corners */
    if (s->triangle_count == s->triangle_capacity) {
        s->triangle_capacity = s->triangle_capacity * 2 + 64;
        s->triangles = resize(s->triangles, s->triangle_capacity * sizeof *s->triangles);
    }
    uint32_t *t = s->triangles[s->triangle_count++];
    t[0] = a;
    t[1] = b;
    t[2] = c;
}

static double squared_distance(const solid *s, uint32_t a, uint32_t b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        double d = s->positions[a][k] - s->positions[b][k];
        sum += d * d;
    }
    return sum;
}

/* Cuts along the shorter diagonal. The margin keeps the choice the same where both are equal but
 * for rounding. */
void solid_quad(solid *s, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    if (squared_distance(s, a, c) <= squared_distance(s, b, d) * (1 + 1e-6)) {
        solid_triangle(s, a, b, c);
        solid_triangle(s, a, c, d);
    } else {
        solid_triangle(s, a, b, d);
        solid_triangle(s, b, c, d);
    }
}

void solid_free(solid *s) {
    free(s->positions);
    free(s->normals);
    free(s->texcoords);
    free(s->colors);
    free(s->triangles);
    *s = (solid){0};
}

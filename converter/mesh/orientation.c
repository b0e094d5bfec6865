/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * orientation.c - consistent orientation of the triangles of each component.
 *
 * A flipped triangle would otherwise bound a patch. The orientation of one triangle is propagated
 * across paired edges (mesh/edges.h; flood fill). Then the front of the component is chosen:
 * the side that the normals of the file point to, or else the side that three quarters of its area
 * had already, or else, of a closed component, the outer side. A component that the file orients
 * consistently therefore stays as it is, for example an inner wall whose front is inside. One-sided
 * surfaces (Moebius) keep a line of edges whose triangles disagree.
 */
#include "mesh/orientation.h"

#include "base/vector.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The mean agreement with the file's normals, and the fraction of the area, from which they decide
 * about the front. Chosen by hand. */
static const double min_normal_agreement = 0.5;
static const double min_area_majority = 0.75;

typedef struct flood {
    psplat_mesh *mesh;
    uint32_t *pairs; /* psplat_edge_pairs */
    uint32_t *queue; /* triangles, component after component */
    uint8_t *state;  /* of each triangle: KEPT, FLIPPED or UNSEEN */
} flood;

enum { KEPT = 0, FLIPPED = 1, UNSEEN = 2 };

/* Sums over a component, with its triangles oriented as the flood fill left them. */
typedef struct component {
    double area, flipped_area;
    double agreement; /* area x mean cosine between the file's normals and those of the triangles */
    double volume;    /* positive if the front is outside */
    int closed;
} component;

static uint32_t edge_start(const psplat_mesh *mesh, uint32_t edge) {
    return mesh->triangles[edge];
}

static void enqueue(flood *f, uint32_t triangle, int state, size_t *end) {
    f->state[triangle] = (uint8_t)state;
    f->queue[(*end)++] = triangle;
}

/* Fills the queue from begin on with the component of seed; returns its end. */
static size_t flood_component(flood *f, uint32_t seed, size_t begin) {
    size_t end = begin;
    enqueue(f, seed, KEPT, &end);
    for (size_t at = begin; at < end; ++at) {
        uint32_t triangle = f->queue[at];
        for (uint32_t e = 3 * triangle; e < 3 * triangle + 3; ++e) {
            uint32_t pair = f->pairs[e];
            if (pair == PSPLAT_NONE || f->state[pair / 3] != UNSEEN) continue;
            int agree = edge_start(f->mesh, e) != edge_start(f->mesh, pair);
            enqueue(f, pair / 3, agree ? f->state[triangle] : !f->state[triangle], &end);
        }
    }
    return end;
}

/* Returns the mean cosine between the file's normals at the corners and the triangle's normal. */
static double normal_agreement(const psplat_mesh *mesh, uint32_t triangle, const double normal[3]) {
    double sum = 0;
    for (size_t corner = 0; mesh->corner_normals && corner < 3; ++corner) {
        const float *n = mesh->corner_normals + 9 * (size_t)triangle + 3 * corner;
        for (int k = 0; k < 3; ++k) sum += (double)n[k] * normal[k] / 3;
    }
    return sum;
}

static component measure_component(const flood *f, size_t begin, size_t end) {
    const psplat_mesh *mesh = f->mesh;
    component c = {.closed = 1};
    const double *origin =
        mesh->positions + 3 * (size_t)mesh->triangles[3 * (size_t)f->queue[begin]];
    for (size_t at = begin; at < end; ++at) {
        uint32_t t = f->queue[at];
        double p[3][3], ab[3], ac[3], normal[3], sign = f->state[t] ? -1 : 1;
        for (size_t k = 0; k < 3; ++k)
            sub3(p[k], mesh->positions + 3 * (size_t)mesh->triangles[3 * (size_t)t + k], origin);
        sub3(ab, p[1], p[0]);
        sub3(ac, p[2], p[0]);
        cross3(normal, ab, ac);
        c.volume += sign * dot3(normal, p[0]);
        double area = normalize3(normal);
        c.area += area;
        c.flipped_area += f->state[t] ? area : 0;
        c.agreement += sign * area * normal_agreement(mesh, t, normal);
        for (uint32_t e = 3 * t; e < 3 * t + 3; ++e) c.closed &= f->pairs[e] != PSPLAT_NONE;
    }
    return c;
}

/* Returns whether the flood fill made the back of a component its front. Triangles through a point
 * set had no orientation before, so that only normals and volume count. */
static int is_inverted(const component *c, int is_point_set) {
    if (fabs(c->agreement) > min_normal_agreement * c->area) return c->agreement < 0;
    if (is_point_set) return c->volume < 0;
    if (c->flipped_area <= (1 - min_area_majority) * c->area) return 0;
    if (c->flipped_area >= min_area_majority * c->area) return 1;
    return c->closed ? c->volume < 0 : c->flipped_area > 0.5 * c->area;
}

static void swap_floats(float *a, float *b, size_t count) {
    for (size_t k = 0; k < count; ++k) {
        float held = a[k];
        a[k] = b[k], b[k] = held;
    }
}

static void flip(psplat_mesh *mesh, uint32_t triangle) {
    uint32_t *t = mesh->triangles + 3 * (size_t)triangle, held = t[1];
    t[1] = t[2], t[2] = held;
    psplat_corners arrays[PSPLAT_CORNER_ARRAYS];
    size_t count = psplat_mesh_corners(mesh, arrays);
    for (size_t i = 0; i < count; ++i) {
        size_t components = arrays[i].components;
        float *corners = arrays[i].values + 3 * components * (size_t)triangle;
        swap_floats(corners + components, corners + 2 * components, components);
    }
}

static void orient_components(flood *f) {
    uint32_t count = (uint32_t)f->mesh->triangle_count;
    size_t begin = 0;
    memset(f->state, UNSEEN, count);
    for (uint32_t seed = 0; seed < count; ++seed) {
        if (f->state[seed] != UNSEEN) continue;
        size_t end = flood_component(f, seed, begin);
        component c = measure_component(f, begin, end);
        if (is_inverted(&c, f->mesh->point_count > 0))
            for (size_t at = begin; at < end; ++at) f->state[f->queue[at]] ^= 1;
        begin = end;
    }
}

/* Returns whether the two triangles of every edge now run along it in opposite directions. */
static int is_consistent(const flood *f) {
    for (uint32_t e = 0; e < 3 * f->mesh->triangle_count; ++e) {
        uint32_t pair = f->pairs[e];
        if (pair == PSPLAT_NONE) continue;
        int agree = edge_start(f->mesh, e) != edge_start(f->mesh, pair);
        if (agree != (f->state[e / 3] == f->state[pair / 3])) return 0;
    }
    return 1;
}

psplat_result psplat_mesh_orient(psplat_mesh *mesh, int *consistent, psplat_error *error) {
    size_t count = mesh->triangle_count, borders;
    flood f = {.mesh = mesh,
               .pairs = malloc((count + 1) * 3 * sizeof *f.pairs),
               .queue = malloc((count + 1) * sizeof *f.queue),
               .state = malloc(count + 1)};
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (f.pairs && f.queue && f.state) result = psplat_edge_pairs(mesh, f.pairs, &borders);
    if (!result) {
        orient_components(&f);
        *consistent = is_consistent(&f);
        for (uint32_t t = 0; t < count; ++t)
            if (f.state[t]) flip(mesh, t);
    } else {
        psplat_fail(error, result, 0, "out of memory while orienting %zu triangles", count);
    }
    free(f.pairs);
    free(f.queue);
    free(f.state);
    return result;
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * shells.c - closed shells that face inwards are turned outwards.
 *
 * A shell is a component whose every edge has two triangles that agree about the front. Its signed
 * volume says which side that is. Nobody wants to look at a body from inside, so that a shell of
 * negative volume is an error of the file, with two exceptions: the wall of a cavity faces the
 * empty space inside a body, and a room, or a sky, is seen from inside where other things stand in
 * it. One shell lies inside another if the other winds around one of its points (Jacobson, Kavan,
 * Sorkine: Robust Inside-Outside Segmentation using Generalized Winding Numbers, 2013).
 */
#include "mesh/shells.h"

#include "base/vector.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>

/* A volume below this fraction of area times diameter is taken for none: rounding stays some
 * orders below it, and a sheet with two sides has no inside. Chosen by hand. */
static const double min_volume = 1e-9;

static const double pi = 3.14159265358979323846;

typedef struct shell {
    size_t begin, end; /* its triangles in the order of shells */
    double low[3], high[3];
    double volume; /* negative if it faces inwards, 0 if it is open or too thin to tell */
    int is_turned;
} shell;

typedef struct shells {
    psplat_mesh *mesh;
    uint32_t *pairs, *order; /* psplat_edge_pairs; triangles, component after component */
    uint8_t *seen;           /* of each triangle */
    shell *list;
    size_t count;
} shells;

/* ---- components ------------------------------------------------------------------------------ */

/* Adds the component of a triangle to the order; returns where it ends. */
static size_t flood(shells *s, uint32_t seed, size_t begin) {
    size_t end = begin;
    s->order[end++] = seed;
    s->seen[seed] = 1;
    for (size_t at = begin; at < end; ++at)
        for (uint32_t e = 3 * s->order[at], last = e + 3; e < last; ++e) {
            uint32_t pair = s->pairs[e];
            if (pair == PSPLAT_NONE || s->seen[pair / 3]) continue;
            s->seen[pair / 3] = 1;
            s->order[end++] = pair / 3;
        }
    return end;
}

/* Returns whether all three edges have another triangle that runs along them the other way. */
static int is_surrounded(const shells *s, uint32_t triangle) {
    for (uint32_t e = 3 * triangle; e < 3 * triangle + 3; ++e)
        if (s->pairs[e] == PSPLAT_NONE || s->mesh->triangles[e] == s->mesh->triangles[s->pairs[e]])
            return 0;
    return 1;
}

/* Sums a component relative to one of its corners, for the sake of precision. */
static shell measure(const shells *s, size_t begin, size_t end) {
    shell out = {.begin = begin, .end = end};
    double area = 0;
    int is_closed = 1;
    const double *origin = psplat_mesh_corner(s->mesh, s->order[begin], 0);
    for (int k = 0; k < 3; ++k) out.low[k] = out.high[k] = origin[k];
    for (size_t at = begin; at < end; ++at) {
        double p[3][3], ab[3], ac[3], normal[3];
        for (int corner = 0; corner < 3; ++corner) {
            const double *point = psplat_mesh_corner(s->mesh, s->order[at], corner);
            sub3(p[corner], point, origin);
            for (int k = 0; k < 3; ++k) {
                out.low[k] = min2(out.low[k], point[k]);
                out.high[k] = max2(out.high[k], point[k]);
            }
        }
        sub3(ab, p[1], p[0]);
        sub3(ac, p[2], p[0]);
        cross3(normal, ab, ac);
        out.volume += dot3(normal, p[0]) / 6;
        area += length3(normal) / 2;
        is_closed = is_closed && is_surrounded(s, s->order[at]);
    }
    double diameter = sqrt(distance2_3(out.low, out.high));
    if (!is_closed || fabs(out.volume) <= min_volume * area * diameter) out.volume = 0;
    return out;
}

static int list_shells(shells *s) {
    size_t count = s->mesh->triangle_count, begin = 0, capacity = 0;
    for (uint32_t seed = 0; seed < count; ++seed) {
        if (s->seen[seed]) continue;
        if (s->count == capacity) {
            capacity = 2 * capacity + 16;
            shell *larger = realloc(s->list, capacity * sizeof *larger);
            if (!larger) return 0;
            s->list = larger;
        }
        size_t end = flood(s, seed, begin);
        s->list[s->count++] = measure(s, begin, end);
        begin = end;
    }
    return 1;
}

/* ---- which side, and what is inside -----------------------------------------------------------
 */

static int has_box_inside(const shell *outer, const shell *inner) {
    for (int k = 0; k < 3; ++k)
        if (inner->low[k] < outer->low[k] || inner->high[k] > outer->high[k]) return 0;
    return 1;
}

/* Returns the solid angle of a triangle, positive from behind its front (van Oosterom, Strackee:
 * The Solid Angle of a Plane Triangle, 1983). */
static double solid_angle(const psplat_mesh *mesh, uint32_t triangle, const double from[3]) {
    double p[3][3], length[3], c[3];
    for (int k = 0; k < 3; ++k) {
        sub3(p[k], psplat_mesh_corner(mesh, triangle, k), from);
        length[k] = length3(p[k]);
    }
    cross3(c, p[1], p[2]);
    double below = length[0] * length[1] * length[2] + dot3(p[0], p[1]) * length[2] +
                   dot3(p[1], p[2]) * length[0] + dot3(p[2], p[0]) * length[1];
    return 2 * atan2(dot3(p[0], c), below);
}

/* Returns whether a shell winds around the middle of the first triangle of another part. */
static int winds_around(const shells *s, const shell *outer, const shell *inner) {
    double middle[3] = {0, 0, 0}, sum = 0;
    if (!has_box_inside(outer, inner)) return 0;
    for (int k = 0; k < 3; ++k)
        mad3(middle, 1.0 / 3, psplat_mesh_corner(s->mesh, s->order[inner->begin], k));
    for (size_t at = outer->begin; at < outer->end; ++at)
        sum += solid_angle(s->mesh, s->order[at], middle);
    return fabs(sum) > 2 * pi; /* half of a full turn, 4 pi */
}

/* Returns whether a shell is the wall of a hollow in a body. */
static int is_cavity(const shells *s, const shell *inner) {
    for (size_t i = 0; i < s->count; ++i)
        if (s->list[i].volume > 0 && winds_around(s, &s->list[i], inner)) return 1;
    return 0;
}

/* Returns whether something stands inside a shell that is no inverted body like itself. */
static int is_room(const shells *s, const shell *outer) {
    for (size_t i = 0; i < s->count; ++i)
        if (s->list[i].volume >= 0 && winds_around(s, outer, &s->list[i])) return 1;
    return s->mesh->holds_parts;
}

/* ---- turning --------------------------------------------------------------------------------- */

static void swap_floats(float *a, float *b, size_t count) {
    for (size_t k = 0; k < count; ++k) {
        float held = a[k];
        a[k] = b[k], b[k] = held;
    }
}

/* Turns a triangle over, with its normals; the sign of tangents keeps their bitangents. */
static void turn(psplat_mesh *mesh, uint32_t triangle) {
    uint32_t *t = mesh->triangles + 3 * (size_t)triangle, held = t[1];
    t[1] = t[2], t[2] = held;
    psplat_corners arrays[PSPLAT_CORNER_ARRAYS];
    size_t count = psplat_mesh_corners(mesh, arrays), first = 3 * (size_t)triangle;
    for (size_t i = 0; i < count; ++i) {
        size_t components = arrays[i].components;
        float *corners = arrays[i].values + components * first;
        swap_floats(corners + components, corners + 2 * components, components);
    }
    for (size_t k = 0; k < 9 && mesh->corner_normals; ++k)
        mesh->corner_normals[3 * first + k] = -mesh->corner_normals[3 * first + k];
    for (size_t k = 0; k < 3 && mesh->corner_tangents; ++k)
        mesh->corner_tangents[4 * (first + k) + 3] *= -1;
}

/* All shells are judged as the file has them, before any is turned. */
static void turn_inward(shells *s) {
    psplat_mesh *mesh = s->mesh;
    for (size_t i = 0; i < s->count; ++i) {
        shell *a = &s->list[i];
        if (!(a->volume < 0) || is_cavity(s, a)) continue;
        if (is_room(s, a)) {
            ++mesh->kept_rooms;
            continue;
        }
        ++mesh->turned_shells;
        mesh->turned_triangles += a->end - a->begin;
        a->is_turned = 1;
    }
    for (size_t i = 0; i < s->count; ++i)
        for (size_t at = s->list[i].begin; s->list[i].is_turned && at < s->list[i].end; ++at)
            turn(mesh, s->order[at]);
}

psplat_result psplat_mesh_turn_shells(psplat_mesh *mesh, psplat_error *error) {
    size_t count = mesh->triangle_count, borders;
    shells s = {.mesh = mesh,
                .pairs = malloc((count + 1) * 3 * sizeof *s.pairs),
                .order = malloc((count + 1) * sizeof *s.order),
                .seen = calloc(count + 1, 1)};
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (s.pairs && s.order && s.seen) result = psplat_edge_pairs(mesh, s.pairs, &borders);
    if (!result && !list_shells(&s)) result = PSPLAT_ERROR_MEMORY;
    if (!result)
        turn_inward(&s);
    else
        psplat_fail(error, result, 0, "out of memory for the shells of %zu triangles", count);
    free(s.pairs);
    free(s.order);
    free(s.seen);
    free(s.list);
    return result;
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mask.c - alpha masks as geometry (glTF 2.0 section 3.9.4, MASK): what the mask hides is cut away,
 * so that its edge is a border of the mesh as any other, and clip lines follow it.
 *
 * First triangles that the edge crosses are divided until their edges are short: all edges of such
 * a triangle in the middle, their neighbours where an edge was (red and green refinement, Bank et
 * al. 1983), so that no vertex comes to lie on an edge. Then they are cut along a straight line
 * each, between the places on their edges where the mask's edge really is. Vertices, alphas and
 * places are the same on both sides of an edge, wherever texture coordinates are.
 */
#include "mask.h"

#include "vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FINEST_GRID = 64, BISECTIONS = 10, MOST_PASSES = 24 };
/* Refining ends before a mask of noise fills the memory. */
static const size_t most_triangles = 4000000;

/* ---- alpha ----------------------------------------------------------------------------------- */

/* A mesh on its way, and the mask on it. */
typedef struct cutter {
    psplat_mesh mesh;
    psplat_paint
        paint; /* of that mesh; without a diameter: alpha has to be that of a place alone */
    double step;
} cutter;

static const psplat_appearance *mask_of(const psplat_mesh *mesh, size_t triangle) {
    size_t group = mesh->groups ? mesh->groups[triangle] : 0;
    if (group >= mesh->appearance_count || !mesh->appearances[group].is_masked) return NULL;
    return &mesh->appearances[group];
}

static int shows(const cutter *c, uint32_t triangle, const double weights[3]) {
    const psplat_appearance *mask = mask_of(&c->mesh, triangle);
    return !mask || psplat_paint_alpha(&c->paint, triangle, weights) >= (double)mask->alpha_cutoff;
}

static double edge_length(const psplat_mesh *mesh, size_t triangle, size_t k) {
    const uint32_t *t = mesh->triangles + 3 * triangle;
    double d[3];
    sub3(d, mesh->positions + 3 * (size_t)t[(k + 1) % 3], mesh->positions + 3 * (size_t)t[k]);
    return length3(d);
}

/* Whether the mask's edge crosses a triangle, by a grid of places as fine as the step. */
static int is_crossed(const cutter *c, uint32_t triangle) {
    double longest = 0;
    if (!mask_of(&c->mesh, triangle)) return 0;
    for (size_t k = 0; k < 3; ++k) longest = max2(longest, edge_length(&c->mesh, triangle, k));
    int n = (int)min2(max2(ceil(longest / c->step), 1), FINEST_GRID), first = -1;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n - i; ++j) {
            const double weights[3] = {(double)i / n, (double)j / n, (double)(n - i - j) / n};
            int shown = shows(c, triangle, weights);
            if (first >= 0 && shown != first) return 1;
            first = shown;
        }
    return 0;
}

/* ---- corners --------------------------------------------------------------------------------- */

static unsigned parts_of(const psplat_mesh *mesh) {
    unsigned parts = (mesh->corner_normals ? PSPLAT_MESH_NORMALS : 0u) |
                     (mesh->corner_colors ? PSPLAT_MESH_COLORS : 0u) |
                     (mesh->corner_tangents ? PSPLAT_MESH_TANGENTS : 0u) |
                     (mesh->groups ? PSPLAT_MESH_GROUPS : 0u);
    for (unsigned i = 0; i < PSPLAT_TEXCOORDS; ++i)
        if (mesh->corner_uvs[i]) parts |= PSPLAT_MESH_UVS << i;
    return parts;
}

/* An empty mesh like another, but for its size. */
static psplat_result make_like(const psplat_mesh *mesh, size_t vertices, size_t triangles,
                               psplat_mesh *made, psplat_error *error) {
    psplat_result result = psplat_mesh_allocate(made, vertices, triangles, parts_of(mesh), error);
    if (result) return result;
    memcpy(made->origin, mesh->origin, sizeof made->origin);
    made->material = mesh->material;
    made->appearances = mesh->appearances;
    made->appearance_count = mesh->appearance_count;
    made->dropped = mesh->dropped;
    made->both_sides = mesh->both_sides;
    return PSPLAT_OK;
}

/* What lives on a corner, at a place of a triangle. */
static void put_corner(psplat_mesh *to, size_t corner, const psplat_mesh *from, size_t triangle,
                       const double weights[3]) {
    psplat_corners in[PSPLAT_CORNER_ARRAYS], out[PSPLAT_CORNER_ARRAYS];
    size_t count = psplat_mesh_corners(from, in);
    psplat_mesh_corners(to, out);
    for (size_t a = 0; a < count; ++a)
        for (size_t k = 0; k < in[a].components; ++k) {
            double sum = 0;
            for (size_t i = 0; i < 3; ++i)
                if (weights[i] != 0) /* what a corner lacks may be no number */
                    sum += weights[i] *
                           (double)in[a].values[(3 * triangle + i) * in[a].components + k];
            out[a].values[corner * in[a].components + k] = (float)sum;
        }
}

/* A triangle of three places in another. */
static void put_triangle(psplat_mesh *to, size_t target, const psplat_mesh *from, size_t triangle,
                         const double weights[3][3], const uint32_t vertices[3]) {
    for (size_t i = 0; i < 3; ++i) {
        to->triangles[3 * target + i] = vertices[i];
        put_corner(to, 3 * target + i, from, triangle, weights[i]);
    }
    if (to->groups) to->groups[target] = from->groups[triangle];
}

/* ---- refining -------------------------------------------------------------------------------- */

/* Edges to be divided, by their ends, and the vertices in their middle; open addressing. */
typedef struct marks {
    struct mark {
        uint32_t low, high, middle;
    } * slots;
    size_t size, count; /* size is a power of two */
} marks;

static struct mark *find_mark(const marks *m, const psplat_mesh *mesh, size_t triangle, size_t k) {
    const uint32_t *t = mesh->triangles + 3 * triangle;
    uint32_t a = t[k], b = t[(k + 1) % 3], low = a < b ? a : b, high = a < b ? b : a;
    uint64_t hash = ((uint64_t)low << 32 | high) * 0x9e3779b97f4a7c15u;
    size_t slot = (size_t)(hash >> 32) & (m->size - 1);
    while (m->slots[slot].middle && (m->slots[slot].low != low || m->slots[slot].high != high))
        slot = (slot + 1) & (m->size - 1);
    struct mark *mark = &m->slots[slot];
    if (!mark->middle) mark->low = low, mark->high = high;
    return mark;
}

/* Marks long edges of triangles that the mask's edge crosses. */
static int mark_edges(const cutter *c, marks *m) {
    const psplat_mesh *mesh = &c->mesh;
    uint8_t *crossed = malloc(mesh->triangle_count + 1);
    size_t count = 0;
    if (!crossed) return 0;
    long end = (long)mesh->triangle_count;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 64)
#endif
    for (long t = 0; t < end; ++t) crossed[t] = (uint8_t)is_crossed(c, (uint32_t)t);
    for (size_t t = 0; t < mesh->triangle_count; ++t) count += crossed[t];
    for (m->size = 16; m->size < 8 * count; m->size *= 2) continue;
    m->slots = calloc(m->size, sizeof *m->slots);
    for (size_t t = 0; m->slots && t < mesh->triangle_count; ++t)
        for (size_t k = 0; crossed[t] && k < 3; ++k) {
            if (edge_length(mesh, t, k) <= c->step) continue;
            struct mark *mark = find_mark(m, mesh, t, k);
            /* No vertex 0 is in the middle of others: 0 is a free slot. */
            if (!mark->middle) mark->middle = (uint32_t)(mesh->vertex_count + m->count++);
        }
    free(crossed);
    return m->slots != NULL;
}

/* Divides one triangle, whose edges have these vertices in their middles (0: none). Returns how
 * many come of it. */
static size_t divide(psplat_mesh *to, size_t target, const psplat_mesh *from, size_t triangle,
                     const uint32_t middles[3]) {
    /* By the marked edges, as bits: places, 0 1 2 corners, 3 4 5 the edges' middles. */
    static const uint8_t patterns[8][4][3] = {
        {{0, 1, 2}},
        {{0, 3, 2}, {3, 1, 2}},
        {{1, 4, 0}, {4, 2, 0}},
        {{3, 1, 4}, {0, 3, 4}, {0, 4, 2}},
        {{2, 5, 1}, {5, 0, 1}},
        {{5, 0, 3}, {2, 5, 3}, {2, 3, 1}},
        {{4, 2, 5}, {1, 4, 5}, {1, 5, 0}},
        {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}},
    };
    static const uint8_t counts[8] = {1, 2, 2, 3, 2, 3, 3, 4};
    static const double places[6][3] = {{1, 0, 0},     {0, 1, 0},     {0, 0, 1},
                                        {0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}};
    unsigned marked = (middles[0] ? 1u : 0u) | (middles[1] ? 2u : 0u) | (middles[2] ? 4u : 0u);
    for (size_t i = 0; to && i < counts[marked]; ++i) {
        double weights[3][3];
        uint32_t vertices[3];
        for (size_t k = 0; k < 3; ++k) {
            uint8_t place = patterns[marked][i][k];
            memcpy(weights[k], places[place], sizeof weights[k]);
            vertices[k] = place < 3 ? from->triangles[3 * triangle + place] : middles[place - 3];
        }
        put_triangle(to, target + i, from, triangle, (const double(*)[3])weights, vertices);
    }
    return counts[marked];
}

/* Divides all triangles into `to`, or, where that is NULL, counts what would come of it. */
static size_t divide_all(const psplat_mesh *from, const marks *m, psplat_mesh *to) {
    size_t count = 0;
    for (size_t t = 0; t < from->triangle_count; ++t) {
        uint32_t middles[3];
        for (size_t k = 0; k < 3; ++k) middles[k] = find_mark(m, from, t, k)->middle;
        count += divide(to, count, from, t, middles);
    }
    return count;
}

static void place_middles(const marks *m, psplat_mesh *mesh) {
    for (size_t i = 0; i < m->size; ++i) {
        const struct mark *mark = &m->slots[i];
        if (!mark->middle) continue;
        for (size_t k = 0; k < 3; ++k)
            mesh->positions[3 * (size_t)mark->middle + k] =
                (mesh->positions[3 * (size_t)mark->low + k] +
                 mesh->positions[3 * (size_t)mark->high + k]) /
                2;
    }
}

/* One pass. *done: nothing is left to be divided. */
static psplat_result refine(cutter *c, int *done, psplat_error *error) {
    marks m = {0};
    psplat_mesh finer;
    psplat_result result = PSPLAT_OK;
    if (!mark_edges(c, &m))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while cutting a mask");
    size_t count = divide_all(&c->mesh, &m, NULL);
    *done = m.count == 0 || count > most_triangles;
    if (!*done) result = make_like(&c->mesh, c->mesh.vertex_count + m.count, count, &finer, error);
    if (!*done && !result) {
        memcpy(finer.positions, c->mesh.positions, 3 * c->mesh.vertex_count * sizeof(double));
        place_middles(&m, &finer);
        divide_all(&c->mesh, &m, &finer);
        psplat_mesh_free(&c->mesh);
        c->mesh = finer;
    }
    free(m.slots);
    return result;
}

/* ---- cutting --------------------------------------------------------------------------------- */

/* A corner of what is left of a triangle. */
typedef struct place {
    double weights[3], position[3];
} place;

static place corner_place(const psplat_mesh *mesh, size_t triangle, size_t k) {
    place p = {.weights = {k == 0, k == 1, k == 2}};
    memcpy(p.position, mesh->positions + 3 * (size_t)mesh->triangles[3 * triangle + k],
           sizeof p.position);
    return p;
}

/* Where the mask's edge meets that of a triangle, which begins on one side of it and ends on the
 * other. Looked for from the end of lower number, so that the neighbour finds the same. */
static place edge_place(const cutter *c, uint32_t triangle, size_t k, int from_shows) {
    size_t ends[2] = {k, (k + 1) % 3};
    const uint32_t *t = c->mesh.triangles + 3 * (size_t)triangle;
    if (t[ends[0]] > t[ends[1]]) {
        size_t swap = ends[0];
        ends[0] = ends[1], ends[1] = swap;
        from_shows = !from_shows;
    }
    double low = 0, high = 1;
    place p = {{0}, {0}};
    for (int i = 0; i < BISECTIONS; ++i) {
        double middle = (low + high) / 2;
        p.weights[ends[0]] = 1 - middle, p.weights[ends[1]] = middle;
        if (shows(c, triangle, p.weights) == from_shows)
            low = middle;
        else
            high = middle;
    }
    double at = (low + high) / 2;
    p.weights[ends[0]] = 1 - at, p.weights[ends[1]] = at;
    const double *a = c->mesh.positions + 3 * (size_t)t[ends[0]];
    const double *b = c->mesh.positions + 3 * (size_t)t[ends[1]];
    for (int axis = 0; axis < 3; ++axis) p.position[axis] = a[axis] + at * (b[axis] - a[axis]);
    return p;
}

/* What the mask shows of a triangle, as a polygon of up to four places. */
static size_t shown_part(const cutter *c, uint32_t triangle, place polygon[4]) {
    int shown[3];
    size_t count = 0;
    for (size_t k = 0; k < 3; ++k) {
        place corner = corner_place(&c->mesh, triangle, k);
        shown[k] = shows(c, triangle, corner.weights);
    }
    for (size_t k = 0; k < 3; ++k) {
        if (shown[k]) polygon[count++] = corner_place(&c->mesh, triangle, k);
        if (shown[k] != shown[(k + 1) % 3]) polygon[count++] = edge_place(c, triangle, k, shown[k]);
    }
    return count;
}

/* Cuts all triangles into `to`, each with vertices of its own, or counts. */
static size_t cut_all(const cutter *c, psplat_mesh *to) {
    size_t count = 0;
    for (uint32_t t = 0; t < c->mesh.triangle_count; ++t) {
        place polygon[4];
        size_t corners = shown_part(c, t, polygon);
        for (size_t i = 2; i < corners; ++i, ++count) {
            const place *fan[3] = {&polygon[0], &polygon[i - 1], &polygon[i]};
            double weights[3][3];
            uint32_t vertices[3];
            for (size_t k = 0; to && k < 3; ++k) {
                memcpy(weights[k], fan[k]->weights, sizeof weights[k]);
                vertices[k] = (uint32_t)(3 * count + k);
                memcpy(to->positions + 3 * (size_t)vertices[k], fan[k]->position,
                       sizeof fan[k]->position);
            }
            if (to) put_triangle(to, count, &c->mesh, t, (const double(*)[3])weights, vertices);
        }
    }
    return count;
}

static psplat_result cut(cutter *c, psplat_mesh *shown, psplat_error *error) {
    size_t count = cut_all(c, NULL);
    if (count == 0)
        return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0,
                           "the alpha mask hides all of the mesh");
    psplat_result result = make_like(&c->mesh, 3 * count, count, shown, error);
    if (result) return result;
    cut_all(c, shown);
    result = psplat_mesh_weld(shown, error);
    psplat_mesh_drop_flat(shown);
    if (result) psplat_mesh_free(shown);
    return result;
}

/* ---- all of it ------------------------------------------------------------------------------- */

int psplat_mask_is_needed(const psplat_mesh *mesh) {
    for (size_t t = 0; t < mesh->triangle_count; ++t)
        if (mask_of(mesh, t)) return 1;
    return 0;
}

psplat_result psplat_mask_cut(const psplat_mesh *mesh, double step, psplat_mesh *shown,
                              psplat_error *error) {
    static const double corners[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    cutter c = {.step = step};
    *shown = (psplat_mesh){0};
    psplat_result result =
        make_like(mesh, mesh->vertex_count, mesh->triangle_count, &c.mesh, error);
    if (result) return result;
    memcpy(c.mesh.positions, mesh->positions, 3 * mesh->vertex_count * sizeof(double));
    for (size_t t = 0; t < mesh->triangle_count; ++t)
        put_triangle(&c.mesh, t, mesh, t, corners, mesh->triangles + 3 * t);
    if (psplat_paint_build(&c.mesh, 0, &c.paint))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while cutting a mask");
    for (int pass = 0, done = 0; !result && !done && pass < MOST_PASSES; ++pass)
        result = refine(&c, &done, error);
    if (!result) result = cut(&c, shown, error);
    psplat_paint_free(&c.paint);
    psplat_mesh_free(&c.mesh);
    return result;
}

double psplat_mask_diagonal(const psplat_mesh *mesh) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    double extent[3];
    for (size_t i = 0; i < 3 * mesh->vertex_count; ++i) {
        low[i % 3] = min2(low[i % 3], mesh->positions[i]);
        high[i % 3] = max2(high[i % 3], mesh->positions[i]);
    }
    sub3(extent, high, low);
    return mesh->vertex_count ? length3(extent) : 0;
}

psplat_result psplat_mask_apply(psplat_mesh *mesh, double step_percent, psplat_error *error) {
    psplat_mesh shown;
    if (!psplat_mask_is_needed(mesh)) return PSPLAT_OK;
    double step = step_percent / 100 * psplat_mask_diagonal(mesh);
    psplat_result result = psplat_mask_cut(mesh, step, &shown, error);
    if (result) return result;
    shown.palette = mesh->palette;
    mesh->palette = NULL;
    psplat_mesh_free(mesh);
    *mesh = shown;
    return PSPLAT_OK;
}

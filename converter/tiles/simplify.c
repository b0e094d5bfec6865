/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * simplify.c - a mesh of fewer triangles with the same border, proven both ways.
 *
 * meshoptimizer collapses edges (Garland, Heckbert: Surface Simplification Using Quadric Error
 * Metrics, 1997) and bounds nothing, so that the result is proven: each of its triangles by
 * psplat_proxy_bound, and each triangle of the source against it by convexity. What cannot be
 * proven freezes the triangles of the source there, and so does what is folded; the rest is
 * simplified once more with the border of the frozen part locked. So the result has no gaps, unlike
 * a proxy (mesh/proxy.h), of which only distances are asked.
 *
 * Large meshes are simplified in parts with locked borders.
 */
#include "tiles/simplify.h"

#include "base/vector.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"
#include "mesh/proxy.h"
#include "mesh/triangle_tree.h"
#include "mesh/weld.h"
#include "tiles/block_mesh.h"

#include <math.h>
#include <meshoptimizer.h>
#include <stdlib.h>
#include <string.h>

/* The parts of the greatest deviation that the simplifier may use by its own estimate, round after
 * round. Chosen by hand: with more, too much cannot be proven. */
static const double simplified_parts[] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.4, 0.3, 0.2};
enum { ROUNDS = sizeof simplified_parts / sizeof *simplified_parts, STRAINED_ROUND = 3 };

/* The most rounds in which folded triangles freeze what lies around them, with so many rings of
 * triangles. Then they are taken, so that meshes whose sides lie nearer to each other than the
 * deviation are simplified all the same. */
enum { FOLD_ROUNDS = 6, FOLD_RINGS = 2 };

/* The part of the greatest deviation of the first of two steps. */
static const double first_step = 0.2;

/* The most triangles of a part that is simplified by itself, so that what cannot be proven
 * somewhere does not hold up the rest. Edges between parts stay for the next block to simplify. */
enum { PART_TRIANGLES = 1 << 15 };

/* Where parts are halved, from the lower end on. Blocks are halved in the middle: locked borders of
 * blocks lie within parts of the block above. */
static const double lower_share = 0.41;

/* How often a triangle of the source is quartered for its proof. */
enum { MOST_QUARTERINGS = 6 };

/* The least cosine between a simplified triangle's normal and that of the source beside it. Folded
 * and standing triangles may be as near the source as others, but no splat that covers the surface
 * beside them faces as they do. */
static const double least_facing = 0.2;

/* Where the two vertices are that each vertex is locked by, from it along the first axis and the
 * second one, in sides of the box that holds all others. */
static const double anchor_offset = 1.5;

/* The edges of some triangles that belong to an odd number of them, as keys in order. */
typedef struct odd_edges {
    uint64_t *keys;
    size_t count;
} odd_edges;

typedef struct simplifier {
    const psplat_mesh *source;
    const uint8_t *is_cut; /* of each vertex of the source: it stays, as an end of an edge that
                              other parts have too, but borders are simplified; NULL: they stay */
    double most, deviation;
    float *unit;              /* positions of the source in its box from 0 to 1 */
    double size;              /* the longest side of that box */
    uint32_t *neighbors;      /* the triangles across edges of the source */
    uint32_t *starts;         /* of each vertex, a triangle of the source that has it */
    uint8_t *frozen, *unmade; /* of each triangle of the source: it stays; it could not be proven */
    uint32_t *indices;        /* of the result */
    size_t count;             /* of its triangles */
    odd_edges odd;            /* of the source */
    int is_strained;          /* proofs failed until less was simplified */
    psplat_proxy_search search;
    psplat_triangle_tree *tree; /* of the source; NULL before the first round */
} simplifier;

/* ---- edges ----------------------------------------------------------------------------------- */

static int compare_keys(const void *left, const void *right) {
    const uint64_t *a = left, *b = right;
    return (*a > *b) - (*a < *b);
}

static uint64_t edge_key(uint64_t a, uint64_t b) {
    return a < b ? a << 32 | b : b << 32 | a;
}

static uint32_t key_end(uint64_t key, int end) {
    return (uint32_t)(end ? key : key >> 32);
}

static psplat_result find_odd_edges(const uint32_t *triangles, size_t count, odd_edges *odd) {
    odd->keys = malloc((3 * count + 1) * sizeof *odd->keys);
    odd->count = 0;
    if (!odd->keys) return PSPLAT_ERROR_MEMORY;
    for (size_t e = 0; e < 3 * count; ++e) {
        odd->keys[e] = edge_key(triangles[e], triangles[e % 3 == 2 ? e - 2 : e + 1]);
    }
    qsort(odd->keys, 3 * count, sizeof *odd->keys, compare_keys);
    for (size_t begin = 0, end; begin < 3 * count; begin = end) {
        for (end = begin; end < 3 * count && odd->keys[end] == odd->keys[begin];) ++end;
        if ((end - begin) % 2) odd->keys[odd->count++] = odd->keys[begin];
    }
    return PSPLAT_OK;
}

static int has_key(const odd_edges *odd, uint64_t key) {
    return bsearch(&key, odd->keys, odd->count, sizeof key, compare_keys) != NULL;
}

/* ---- preparation ----------------------------------------------------------------------------- */

static int set_unit_positions(simplifier *s) {
    const psplat_mesh *mesh = s->source;
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    size_t sets = s->is_cut ? 3 : 1; /* of vertices: with two that lock each */
    s->unit = malloc((3 * sets * mesh->vertex_count + 1) * sizeof *s->unit);
    if (!s->unit) return 0;
    for (size_t i = 0; i < 3 * mesh->vertex_count; ++i) {
        low[i % 3] = min2(low[i % 3], mesh->positions[i]);
        high[i % 3] = max2(high[i % 3], mesh->positions[i]);
    }
    for (int k = 0; k < 3; ++k) s->size = max2(s->size, high[k] - low[k]);
    for (size_t i = 0; i < 3 * mesh->vertex_count && s->size > 0; ++i)
        s->unit[i] = (float)((mesh->positions[i] - low[i % 3]) / s->size);
    for (size_t i = 3 * mesh->vertex_count; i < 3 * sets * mesh->vertex_count && s->size > 0; ++i) {
        size_t anchor = i / 3 - mesh->vertex_count;
        s->unit[i] = s->unit[3 * (anchor / 2) + i % 3];
        if (i % 3 == anchor % 2) s->unit[i] += (float)anchor_offset;
    }
    return 1;
}

static psplat_result prepare(simplifier *s) {
    const psplat_mesh *mesh = s->source;
    size_t edges = 3 * mesh->triangle_count, borders;
    s->neighbors = malloc((edges + 1) * sizeof *s->neighbors);
    s->starts = malloc((mesh->vertex_count + 1) * sizeof *s->starts);
    s->frozen = calloc(mesh->triangle_count + 1, 1);
    s->unmade = calloc(mesh->triangle_count + 1, 1);
    s->indices = malloc((edges + 3 * mesh->vertex_count + 1) * sizeof *s->indices);
    s->search.visited = calloc(mesh->triangle_count + 1, sizeof *s->search.visited);
    if (!s->neighbors || !s->starts || !s->frozen || !s->unmade || !s->indices ||
        !s->search.visited || !set_unit_positions(s))
        return PSPLAT_ERROR_MEMORY;
    psplat_result result = psplat_edge_pairs(mesh, s->neighbors, &borders);
    if (!result) result = find_odd_edges(mesh->triangles, mesh->triangle_count, &s->odd);
    for (size_t e = 0; e < edges && !result; ++e)
        if (s->neighbors[e] != PSPLAT_NONE) s->neighbors[e] /= 3;
    for (uint32_t i = 0; i < edges; ++i) s->starts[mesh->triangles[i]] = i / 3;
    s->search.source = mesh;
    s->search.neighbors = s->neighbors;
    s->search.most = s->most;
    return result;
}

/* ---- simplification -------------------------------------------------------------------------- */

/* Marks the vertices that have to stay where borders are simplified: those on cuts and at frozen
 * triangles. A triangle with two of them could vanish along a border that it has, and the edge
 * between them with it: its third one stays, too. */
static void find_locked(const simplifier *s, uint8_t *locked) {
    const psplat_mesh *mesh = s->source;
    memcpy(locked, s->is_cut, mesh->vertex_count);
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i)
        if (s->frozen[i / 3]) locked[mesh->triangles[i]] = 1;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *corners = mesh->triangles + 3 * t, *across = s->neighbors + 3 * t;
        int has_border = 0, count = 0;
        for (int k = 0; k < 3; ++k) {
            has_border |= across[k] == PSPLAT_NONE;
            count += locked[corners[k]] == 1;
        }
        for (int k = 0; k < 3 && has_border && count == 2; ++k)
            if (!locked[corners[k]]) locked[corners[k]] = 2;
    }
}

/* Appends a triangle to each vertex that has to stay: the simplifier moves no vertex at which more
 * than one border passes. Returns the number of triangles. */
static size_t append_anchors(const simplifier *s, const uint8_t *locked, size_t count,
                             uint32_t *triangles) {
    size_t vertices = s->source->vertex_count;
    for (size_t v = 0; v < vertices; ++v) {
        if (!locked[v]) continue;
        triangles[3 * count] = (uint32_t)v;
        triangles[3 * count + 1] = (uint32_t)(vertices + 2 * v);
        triangles[3 * count++ + 2] = (uint32_t)(vertices + 2 * v + 1);
    }
    return count;
}

static void drop_anchors(simplifier *s) {
    size_t kept = 0;
    for (size_t t = 0; t < s->count; ++t) {
        const uint32_t *corners = s->indices + 3 * t;
        uint32_t vertices = (uint32_t)s->source->vertex_count;
        if (corners[0] < vertices && corners[1] < vertices && corners[2] < vertices)
            memmove(s->indices + 3 * kept++, corners, 3 * sizeof *corners);
    }
    s->count = kept;
}

/* Simplifies triangles with borders that stay, or with all but what is locked. */
static void run_simplifier(simplifier *s, const uint32_t *triangles, size_t count, double part) {
    size_t vertices = (s->is_cut ? 3 : 1) * s->source->vertex_count, stride = 3 * sizeof *s->unit;
    double extent = s->is_cut ? (double)meshopt_simplifyScale(s->unit, vertices, stride) : 1;
    s->count = meshopt_simplify(s->indices, triangles, 3 * count, s->unit, vertices, stride, 0,
                                (float)(part * s->most / s->size / extent),
                                s->is_cut ? 0 : meshopt_SimplifyLockBorder, NULL) /
               3;
}

static psplat_result simplify(simplifier *s, double part) {
    const psplat_mesh *mesh = s->source;
    size_t count = 0;
    uint32_t *unfrozen =
        malloc((3 * mesh->triangle_count + 3 * mesh->vertex_count + 1) * sizeof *unfrozen);
    uint8_t *locked = calloc(mesh->vertex_count + 1, 1);
    if (!unfrozen || !locked) {
        free(unfrozen);
        free(locked);
        return PSPLAT_ERROR_MEMORY;
    }
    for (size_t t = 0; t < mesh->triangle_count; ++t)
        if (!s->frozen[t])
            memcpy(unfrozen + 3 * count++, mesh->triangles + 3 * t, 3 * sizeof *unfrozen);
    if (s->is_cut) {
        find_locked(s, locked);
        count = append_anchors(s, locked, count, unfrozen);
    }
    run_simplifier(s, unfrozen, count, part);
    if (s->is_cut) drop_anchors(s);
    free(unfrozen);
    free(locked);
    return PSPLAT_OK;
}

/* Appends the frozen triangles to the simplified ones. */
static void append_frozen(simplifier *s) {
    for (size_t t = 0; t < s->source->triangle_count; ++t)
        if (s->frozen[t])
            memcpy(s->indices + 3 * s->count++, s->source->triangles + 3 * t,
                   3 * sizeof *s->indices);
}

/* ---- proofs ---------------------------------------------------------------------------------- */

/* What a round left to do, in triangles. */
typedef struct failures {
    size_t unproven, folded;
} failures;

/* Returns whether an edge of the source that one triangle has, or an odd number, has to stay. */
static int is_kept(const simplifier *s, uint64_t key) {
    return !s->is_cut || (s->is_cut[key_end(key, 0)] && s->is_cut[key_end(key, 1)]);
}

/* Checks that edges that have to stay are there, and that the result has no borders but between
 * vertices of the source's: none is torn open beside frozen triangles. */
static psplat_result check_edges(const simplifier *s, int *fits) {
    odd_edges result;
    uint8_t *is_border = calloc(s->source->vertex_count + 1, 1);
    *fits = 1;
    if (find_odd_edges(s->indices, s->count, &result) || !is_border) {
        free(result.keys);
        free(is_border);
        return PSPLAT_ERROR_MEMORY;
    }
    for (size_t i = 0; i < s->odd.count; ++i) {
        uint64_t key = s->odd.keys[i];
        is_border[key_end(key, 0)] = is_border[key_end(key, 1)] = 1;
        if (is_kept(s, key)) *fits &= has_key(&result, key);
    }
    for (size_t i = 0; i < result.count; ++i) {
        uint64_t key = result.keys[i];
        *fits &= s->is_cut ? is_border[key_end(key, 0)] && is_border[key_end(key, 1)]
                           : has_key(&s->odd, key);
    }
    free(result.keys);
    free(is_border);
    return PSPLAT_OK;
}

/* Returns the greatest distance of the corners from one triangle, which bounds that of all points
 * between them since a triangle is convex; of quarters where it is more than most; or HUGE_VAL. */
static double bound_of(const psplat_triangle_tree *tree, double corners[3][3], double most,
                       int quarterings, uint32_t *place) {
    psplat_tree_nearest nearest = {.distance2 = HUGE_VAL, .place = *place};
    double middle[3], greatest2 = 0, bound = 0;
    for (int k = 0; k < 3; ++k) middle[k] = (corners[0][k] + corners[1][k] + corners[2][k]) / 3;
    psplat_triangle_tree_nearest(tree, middle, &nearest);
    *place = nearest.place;
    if (nearest.place == PSPLAT_NONE || nearest.distance2 > most * most) return HUGE_VAL;
    for (int i = 0; i < 3; ++i)
        greatest2 =
            max2(greatest2,
                 point_triangle_distance2(corners[i], psplat_tree_corner(tree, nearest.place, 0),
                                          psplat_tree_corner(tree, nearest.place, 1),
                                          psplat_tree_corner(tree, nearest.place, 2)));
    if (greatest2 <= most * most) return sqrt(greatest2);
    if (!quarterings) return HUGE_VAL;
    double halves[3][3], quarters[4][3][3];
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            halves[i][k] = 0.5 * corners[i][k] + 0.5 * corners[(i + 1) % 3][k];
    for (int i = 0; i < 3; ++i) {
        memcpy(quarters[i][0], corners[i], sizeof halves[i]);
        memcpy(quarters[i][1], halves[i], sizeof halves[i]);
        memcpy(quarters[i][2], halves[(i + 2) % 3], sizeof halves[i]);
        memcpy(quarters[3][i], halves[i], sizeof halves[i]);
    }
    for (int i = 0; i < 4 && bound <= most; ++i) {
        uint32_t near = *place;
        bound = max2(bound, bound_of(tree, quarters[i], most, quarterings - 1, &near));
    }
    return bound;
}

/* Bounds the distance of a triangle with these vertices of the source from a tree's. */
static double bound_of_corners(const simplifier *s, const psplat_triangle_tree *tree,
                               const uint32_t vertices[3], uint32_t *place) {
    double corners[3][3];
    for (int i = 0; i < 3; ++i)
        memcpy(corners[i], s->source->positions + 3 * (size_t)vertices[i], sizeof corners[i]);
    return bound_of(tree, corners, s->most, MOST_QUARTERINGS, place);
}

/* Stores the normal of a triangle, twice as long as its area. */
static void area_vector(const double *a, const double *b, const double *c, double normal[3]) {
    double ab[3], ac[3];
    sub3(ab, b, a);
    sub3(ac, c, a);
    cross3(normal, ab, ac);
}

/* Returns whether the triangle of the source that is nearest to a point faces along a normal. */
static int source_faces(const simplifier *s, const double point[3], const double normal[3],
                        uint32_t *place) {
    psplat_tree_nearest nearest = {.distance2 = HUGE_VAL, .place = *place};
    double other[3];
    psplat_triangle_tree_nearest(s->tree, point, &nearest);
    *place = nearest.place;
    area_vector(psplat_tree_corner(s->tree, nearest.place, 0),
                psplat_tree_corner(s->tree, nearest.place, 1),
                psplat_tree_corner(s->tree, nearest.place, 2), other);
    return dot3(other, normal) >= least_facing * length3(other) * length3(normal);
}

/* Returns whether a triangle is folded: higher than the greatest deviation, and facing otherwise
 * than the source beside its middle and between that and each of its corners. */
static int is_folded(const simplifier *s, const uint32_t vertices[3], uint32_t *place) {
    const double *corners[3];
    double normal[3], middle[3], longest = 0;
    for (int i = 0; i < 3; ++i) corners[i] = s->source->positions + 3 * (size_t)vertices[i];
    for (int i = 0; i < 3; ++i) {
        double side[3];
        sub3(side, corners[(i + 1) % 3], corners[i]);
        longest = max2(longest, length3(side));
    }
    area_vector(corners[0], corners[1], corners[2], normal);
    if (length3(normal) <= longest * s->most) return 0;
    for (int k = 0; k < 3; ++k) middle[k] = (corners[0][k] + corners[1][k] + corners[2][k]) / 3;
    if (source_faces(s, middle, normal, place)) return 0;
    for (int i = 0; i < 3; ++i) {
        double between[3];
        for (int k = 0; k < 3; ++k) between[k] = 0.5 * middle[k] + 0.5 * corners[i][k];
        if (source_faces(s, between, normal, place)) return 0;
    }
    return 1;
}

/* Proves that the simplified triangles, which come first, are near the source, and looks for folded
 * ones if unfolds is 1. What the projection along a normal does not prove, as of slivers, quarters
 * may. */
static psplat_result prove_result(simplifier *s, size_t simplified, int unfolds, failures *left) {
    uint32_t place = PSPLAT_NONE;
    if (!s->tree) s->tree = psplat_triangle_tree_create(s->source, NULL);
    if (!s->tree) return PSPLAT_ERROR_MEMORY;
    for (size_t t = 0; t < simplified; ++t) {
        const uint32_t *corners = s->indices + 3 * t;
        double deviation;
        ++s->search.stamp;
        if (psplat_proxy_bound(&s->search, corners, s->starts[corners[0]], &deviation))
            return PSPLAT_ERROR_MEMORY;
        if (!(deviation <= s->most)) deviation = bound_of_corners(s, s->tree, corners, &place);
        int is_unproven = !(deviation <= s->most);
        int has_fold = !is_unproven && unfolds && is_folded(s, corners, &place);
        if (!is_unproven) s->deviation = max2(s->deviation, deviation);
        if (!is_unproven && !has_fold) continue;
        left->unproven += (size_t)is_unproven;
        left->folded += (size_t)has_fold;
        for (size_t i = 0; i < s->search.count; ++i) s->unmade[s->search.stack[i]] = 1;
        for (int k = 0; k < 3; ++k) s->unmade[s->starts[corners[k]]] = 1;
    }
    return PSPLAT_OK;
}

/* Proves that the source is near the result. */
static psplat_result prove_source(simplifier *s, failures *left) {
    const psplat_mesh *mesh = s->source;
    const psplat_mesh result = {.positions = mesh->positions,
                                .vertex_count = mesh->vertex_count,
                                .triangles = s->indices,
                                .triangle_count = s->count};
    psplat_triangle_tree *tree = psplat_triangle_tree_create(&result, NULL);
    if (!tree) return PSPLAT_ERROR_MEMORY;
    uint32_t place = PSPLAT_NONE;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        if (s->frozen[t]) continue;
        double bound = bound_of_corners(s, tree, mesh->triangles + 3 * t, &place);
        s->deviation = max2(s->deviation, min2(bound, s->most));
        if (bound > s->most) s->unmade[t] = 1;
        left->unproven += bound > s->most;
    }
    psplat_triangle_tree_destroy(tree);
    return PSPLAT_OK;
}

/* Freezes what has to stay, with so many rings of triangles around it. */
static void freeze(simplifier *s, int rings) {
    size_t count = s->source->triangle_count;
    for (int ring = 0; ring < rings; ++ring) {
        for (size_t t = 0; t < count; ++t)
            for (size_t k = 0; k < 3 && s->unmade[t] == 1 + ring; ++k) {
                uint32_t across = s->neighbors[3 * t + k];
                if (across != PSPLAT_NONE && !s->unmade[across])
                    s->unmade[across] = (uint8_t)(2 + ring);
            }
    }
    for (size_t t = 0; t < count; ++t) s->frozen[t] |= s->unmade[t] != 0;
    memset(s->unmade, 0, count);
}

/* Runs a round, which looks for folded triangles if unfolds is 1. */
static psplat_result run_round(simplifier *s, double part, int unfolds, failures *left) {
    *left = (failures){0};
    s->deviation = 0;
    psplat_result result = simplify(s, part);
    if (result) return result;
    size_t simplified = s->count;
    append_frozen(s);
    result = prove_result(s, simplified, unfolds, left);
    if (!result) result = prove_source(s, left);
    return result;
}

static psplat_result run_rounds(simplifier *s) {
    const psplat_mesh *mesh = s->source;
    failures left = {.unproven = 1};
    int round = 0, fold_rounds = 0, fits = 0;
    while (round < ROUNDS && (left.unproven || left.folded)) {
        psplat_result result =
            run_round(s, simplified_parts[round], fold_rounds < FOLD_ROUNDS, &left);
        if (result) return result;
        s->is_strained = round >= STRAINED_ROUND;
        if (left.unproven)
            freeze(s, ++round);
        else if (left.folded)
            freeze(s, FOLD_RINGS), ++fold_rounds;
    }
    if (!left.unproven && check_edges(s, &fits)) return PSPLAT_ERROR_MEMORY;
    if (fits) return PSPLAT_OK;
    memset(s->frozen, 1, mesh->triangle_count); /* Everything stays. */
    s->count = 0;
    s->deviation = 0;
    append_frozen(s);
    return PSPLAT_OK;
}

/* ---- result ---------------------------------------------------------------------------------- */

/* Stores the colour that a vertex has at some corner of the source. */
static void store_color(const simplifier *s, uint32_t vertex, float color[4]) {
    size_t corner = 3 * (size_t)s->starts[vertex];
    while (s->source->triangles[corner] != vertex) ++corner;
    memcpy(color, s->source->corner_colors + 4 * corner, 4 * sizeof *color);
}

/* Stores the result, and which of its vertices stay if is_cut is not NULL. */
static psplat_result store(const simplifier *s, psplat_mesh *simple, uint8_t *is_cut) {
    size_t vertices = 0;
    uint32_t *numbers = malloc((s->source->vertex_count + 1) * sizeof *numbers);
    psplat_result result =
        numbers ? psplat_mesh_allocate(simple, s->source->vertex_count, s->count,
                                       s->source->corner_colors ? PSPLAT_MESH_COLORS : 0, NULL)
                : PSPLAT_ERROR_MEMORY;
    if (result) {
        free(numbers);
        return PSPLAT_ERROR_MEMORY;
    }
    memset(numbers, 0xff, s->source->vertex_count * sizeof *numbers);
    for (size_t i = 0; i < 3 * s->count; ++i) {
        uint32_t vertex = s->indices[i];
        if (numbers[vertex] == PSPLAT_NONE) {
            numbers[vertex] = (uint32_t)vertices;
            if (is_cut) is_cut[vertices] = s->is_cut[vertex];
            memcpy(simple->positions + 3 * vertices++, s->source->positions + 3 * (size_t)vertex,
                   3 * sizeof *simple->positions);
        }
        simple->triangles[i] = numbers[vertex];
        if (simple->corner_colors) store_color(s, vertex, simple->corner_colors + 4 * i);
    }
    free(numbers);
    simple->vertex_count = vertices;
    return PSPLAT_OK;
}

/* A part of a mesh. */
typedef struct piece {
    psplat_mesh mesh;
    uint8_t *is_cut; /* of each vertex, or NULL, as in simplifier */
    double deviation;
    int is_strained;
} piece;

static void piece_free(piece *p) {
    psplat_mesh_free(&p->mesh);
    free(p->is_cut);
    *p = (piece){0};
}

static psplat_result make_simple(simplifier *s, piece *simple) {
    psplat_result result = prepare(s);
    if (!result && s->source->triangle_count && s->size > 0) result = run_rounds(s);
    if (s->is_cut) simple->is_cut = calloc(s->source->vertex_count + 1, 1);
    if (s->is_cut && !simple->is_cut) result = PSPLAT_ERROR_MEMORY;
    if (!result) result = store(s, &simple->mesh, simple->is_cut);
    simple->deviation = s->deviation;
    simple->is_strained = s->is_strained;
    return result;
}

/* Simplifies a part of a mesh as psplat_tile_simplify does. */
static psplat_result simplify_part(const piece *source, double most, piece *simple) {
    simplifier s = {.source = &source->mesh, .is_cut = source->is_cut, .most = most};
    *simple = (piece){0};
    psplat_result result = make_simple(&s, simple);
    if (result) piece_free(simple);
    free(s.unit);
    free(s.neighbors);
    free(s.starts);
    free(s.frozen);
    free(s.unmade);
    free(s.indices);
    free(s.odd.keys);
    free(s.search.visited);
    free(s.search.stack);
    psplat_triangle_tree_destroy(s.tree);
    return result;
}

/* ---- parts ----------------------------------------------------------------------------------- */

/* A mesh whose triangles are put into parts. */
typedef struct parts {
    const psplat_mesh *source;
    double most, deviation;
    uint32_t *order, *spare; /* triangles */
    psplat_tile_soup soup;   /* the simplified parts */
    odd_edges odd;           /* of the source, where borders are simplified */
} parts;

/* Stores a place near the middle of the longest side of the box of some triangles' first corners,
 * and its axis. Returns 0 where that box is a point. */
static int halve_box(const parts *p, size_t begin, size_t end, int *axis, double *middle) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t i = begin; i < end; ++i) {
        const double *at = psplat_mesh_corner(p->source, p->order[i], 0);
        for (int k = 0; k < 3; ++k) {
            low[k] = min2(low[k], at[k]);
            high[k] = max2(high[k], at[k]);
        }
    }
    *axis = 0;
    for (int k = 1; k < 3; ++k)
        if (high[k] - low[k] > high[*axis] - low[*axis]) *axis = k;
    *middle = lower_share * high[*axis] + (1 - lower_share) * low[*axis];
    return low[*axis] < *middle && *middle <= high[*axis];
}

/* Moves the triangles below a middle before the others, in order. Returns how many they are. */
static size_t halve(parts *p, size_t begin, size_t end, int axis, double middle) {
    size_t lower = 0, upper = 0;
    for (size_t i = begin; i < end; ++i) {
        uint32_t t = p->order[i];
        if (psplat_mesh_corner(p->source, t, 0)[axis] < middle)
            p->order[begin + lower++] = t;
        else
            p->spare[upper++] = t;
    }
    memcpy(p->order + begin + lower, p->spare, upper * sizeof *p->spare);
    return lower;
}

/* Simplifies a part in two steps, where one step may do less because it cannot be proven: the
 * second begins with what the first, of a smaller deviation, has proven. */
static psplat_result simplify_in_steps(const piece *part, double most, piece *simple) {
    piece first;
    psplat_result result = simplify_part(part, first_step * most, &first);
    if (result) return result;
    result = simplify_part(&first, most - first.deviation, simple);
    simple->deviation += first.deviation;
    piece_free(&first);
    return result;
}

/* Simplifies a part in one step or in two, whichever leaves fewer triangles. */
static psplat_result simplify_well(parts *p, const piece *part, piece *simple) {
    piece other = {0};
    psplat_result result = simplify_part(part, p->most, simple);
    if (!result && simple->is_strained) {
        result = simplify_in_steps(part, p->most, &other);
        if (!result && other.mesh.triangle_count < simple->mesh.triangle_count) {
            piece swap = *simple;
            *simple = other;
            other = swap;
        }
    }
    piece_free(&other);
    if (!result) p->deviation = max2(p->deviation, simple->deviation);
    return result;
}

/* Marks the vertices of a part, which has the triangles from begin on, that lie on borders of it
 * which are none of the source. */
static psplat_result mark_cuts(const parts *p, size_t begin, piece *part) {
    size_t corners = 3 * part->mesh.triangle_count;
    const uint32_t *of_part = part->mesh.triangles;
    uint32_t *of_source = malloc((part->mesh.vertex_count + 1) * sizeof *of_source);
    odd_edges odd = {0};
    part->is_cut = calloc(part->mesh.vertex_count + 1, 1);
    psplat_result result = of_source && part->is_cut
                               ? find_odd_edges(of_part, part->mesh.triangle_count, &odd)
                               : PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < corners && !result; ++i)
        of_source[of_part[i]] = p->source->triangles[3 * (size_t)p->order[begin + i / 3] + i % 3];
    for (size_t i = 0; i < odd.count && !result; ++i) {
        uint32_t ends[2] = {key_end(odd.keys[i], 0), key_end(odd.keys[i], 1)};
        if (!has_key(&p->odd, edge_key(of_source[ends[0]], of_source[ends[1]])))
            part->is_cut[ends[0]] = part->is_cut[ends[1]] = 1;
    }
    free(of_source);
    free(odd.keys);
    return result;
}

/* Adds the simplified mesh of the triangles from begin to end. */
static psplat_result add_part(parts *p, size_t begin, size_t end) {
    psplat_tile_soup soup = {.has_colors = p->source->corner_colors != NULL};
    piece part = {0}, simple = {0};
    psplat_result result = PSPLAT_OK;
    for (size_t i = begin; i < end && !result; ++i)
        result = psplat_tile_soup_add_triangle(&soup, p->source, p->order[i]);
    if (!result) result = psplat_mesh_weld(&soup.mesh, NULL);
    part.mesh = soup.mesh;
    if (!result && p->odd.keys) result = mark_cuts(p, begin, &part);
    if (!result) result = simplify_well(p, &part, &simple);
    if (!result) result = psplat_tile_soup_add_mesh(&p->soup, &simple.mesh);
    piece_free(&simple);
    piece_free(&part);
    return result;
}

/* Simplifies the triangles from begin to end in parts of few enough. */
static psplat_result add_parts(parts *p, size_t begin, size_t end) {
    double middle;
    int axis;
    if (end - begin <= PART_TRIANGLES || !halve_box(p, begin, end, &axis, &middle))
        return add_part(p, begin, end);
    size_t lower = halve(p, begin, end, axis, middle);
    psplat_result result = add_parts(p, begin, begin + lower);
    return result ? result : add_parts(p, begin + lower, end);
}

psplat_result psplat_tile_simplify(const psplat_mesh *source, double most, int keeps_border,
                                   psplat_mesh *simple, double *deviation) {
    parts p = {.source = source, .most = most, .soup.has_colors = source->corner_colors != NULL};
    size_t count = source->triangle_count;
    *simple = (psplat_mesh){0};
    *deviation = 0;
    p.order = malloc((count + 1) * sizeof *p.order);
    p.spare = malloc((count + 1) * sizeof *p.spare);
    psplat_result result = p.order && p.spare ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    if (!result && !keeps_border) result = find_odd_edges(source->triangles, count, &p.odd);
    for (uint32_t t = 0; t < count && !result; ++t) p.order[t] = t;
    if (!result && count) result = add_parts(&p, 0, count);
    if (!result && count) result = psplat_mesh_weld(&p.soup.mesh, NULL);
    free(p.order);
    free(p.spare);
    free(p.odd.keys);
    if (!result) {
        *simple = p.soup.mesh;
        *deviation = p.deviation;
        p.soup.mesh = (psplat_mesh){0};
        memcpy(simple->origin, source->origin, sizeof simple->origin);
        simple->material = source->material;
    }
    psplat_tile_soup_free(&p.soup);
    return result;
}

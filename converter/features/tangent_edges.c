/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tangent_edges.c - tangent edges: where a straight part of a surface goes over into a round one.
 *
 * A splat of a fillet may reach on over the wall beside it for as long as it stays within the
 * tolerance e. Its normals turn on there while the wall's do not, so that they are off by up to
 * sqrt(2 e / R) for a fillet of radius R: 16 degrees where R is 25 tolerances. A finer tolerance
 * helps little, by its root alone, and rims of such splats show as dark scallops along the fillet.
 * So splats end at tangent edges as they do at borders of charts: neighbours overlap a little, and
 * normals are averaged across.
 *
 * An edge is judged by the two straight walks (geodesics) that leave its middle at a right angle.
 */
#include "features/tangent_edges.h"

#include "base/angle.h"
#include "base/vector.h"
#include "features/crease_follow.h"
#include "features/surface.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All of these were chosen by hand, on machined parts that have tangent edges and on scans and
 * figures that are to have none. */
/* The least error of normals beyond an edge that is marked. */
static const double least_error = 8 * PSPLAT_DEGREE;
/* The least and the greatest dihedral angle of such an edge, radians: of a smaller one rounding
 * decides, and a greater one is seen as an edge. */
static const double least_dihedral = 1e-3, greatest_dihedral = 0.4;
/* The surface is straight where its normals turn by less than these shares of the edge's dihedral
 * angle and of the least error. */
static const double straight_share = 0.25, straight_error_share = 0.05;
/* How far it has to be straight, in reaches and in facets of the other side: a round part that
 * consists of few facets is straight over each. */
static const double straight_reaches = 2.1, straight_facets = 1.75;
/* How far the other side is looked at, in reaches and facets, and the greatest error (root mean
 * square) of its normals from a constant rate of turning, in parts of how far they turn. */
static const double turning_reaches = 1.2, greatest_residual = 0.1;
enum { TURNING_FACETS = 3 };
/* How far it is looked at at most, in the greatest reach there may be. */
static const double most_facets_reaches = 3;
/* The part of the turning over the first facet that the edge itself has to do. At the begin of a
 * round part it does half of it. */
static const double least_dihedral_share = 0.2;
/* The factor from one length to the next, smaller one, over which turning is measured. */
static const double length_factor = 0.8;
/* Edges belong to one chain where they go on by at most this angle, and chains that are shorter,
 * in reaches, are dropped. */
static const double greatest_chain_angle = 25 * PSPLAT_DEGREE, least_chain_reaches = 6;

/* The most facets of a walk, and the most triangles. Facets are triangles in a row of one normal.
 */
enum { MOST_FACETS = 64, MOST_STEPS = 512 };
/* The difference of angles, radians, up to which triangles in a row are one facet. */
static const double facet_angle = 1e-5;

/* ---- walks ----------------------------------------------------------------------------------- */

/* A walk along a geodesic. */
typedef struct walker {
    const psplat_surface *surface;
    uint32_t triangle, entry; /* where it is, and the edge through which it came */
    double at[3], ahead[3];   /* a point of that edge, and the unit direction */
    double length;            /* so far */
} walker;

/* Returns the edge of the triangle across that runs along an edge. */
static uint32_t edge_across(const psplat_surface *surface, uint32_t edge) {
    uint32_t begin = psplat_edge_vertex(surface->mesh, edge, 0);
    uint32_t end = psplat_edge_vertex(surface->mesh, edge, 1), first = 3 * surface->neighbors[edge];
    for (uint32_t e = first; e < first + 2; ++e)
        if (psplat_edge_vertex(surface->mesh, e, 0) == end &&
            psplat_edge_vertex(surface->mesh, e, 1) == begin)
            return e;
    return first + 2;
}

static const double *edge_begin(const psplat_surface *surface, uint32_t edge) {
    return psplat_mesh_corner(surface->mesh, edge / 3, (int)(edge % 3));
}

static const double *face_normal(const psplat_surface *surface, uint32_t triangle) {
    return surface->face_normals + 3 * (size_t)triangle;
}

/* Starts at the middle of an edge, into its triangle and at a right angle. */
static walker begin_walk(const psplat_surface *surface, uint32_t edge) {
    walker w = {.surface = surface, .triangle = edge / 3, .entry = edge};
    double along[3];
    psplat_edge_vector(surface->mesh, edge, along);
    along3(w.at, edge_begin(surface, edge), 0.5, along);
    cross3(w.ahead, face_normal(surface, w.triangle), along);
    normalize3(w.ahead);
    return w;
}

/* Finds the edge through which the walk leaves its triangle. Returns how far ahead that is;
 * HUGE_VAL where the triangle has no width. */
static double find_exit(const walker *w, uint32_t *exit) {
    double least = HUGE_VAL;
    for (uint32_t e = 3 * w->triangle; e < 3 * w->triangle + 3; ++e) {
        double along[3], inward[3], from[3];
        if (e == w->entry) continue;
        psplat_edge_vector(w->surface->mesh, e, along);
        cross3(inward, face_normal(w->surface, w->triangle), along);
        sub3(from, w->at, edge_begin(w->surface, e));
        double approach = -dot3(w->ahead, inward);
        if (!(approach > 0)) continue;
        double distance = max2(dot3(from, inward) / approach, 0);
        if (distance < least) least = distance, *exit = e;
    }
    return least;
}

/* Turns the direction about an edge from its triangle into the one across. */
static void turn_over(walker *w, uint32_t edge) {
    double along[3], out[3], into[3], ahead[3] = {0, 0, 0};
    psplat_edge_vector(w->surface->mesh, edge, along);
    normalize3(along);
    cross3(out, along, face_normal(w->surface, w->triangle));
    cross3(into, along, face_normal(w->surface, w->surface->neighbors[edge]));
    mad3(ahead, dot3(w->ahead, along), along);
    mad3(ahead, dot3(w->ahead, out), into);
    normalize3(ahead);
    memcpy(w->ahead, ahead, sizeof ahead);
}

/* Goes on to the next triangle. Returns 0, at the far side of its own one, where a crease or border
 * ends the walk. */
static int walk_on(walker *w) {
    uint32_t exit = PSPLAT_NONE;
    double distance = find_exit(w, &exit);
    if (exit == PSPLAT_NONE || !(distance < HUGE_VAL)) return 0;
    w->length += distance;
    mad3(w->at, distance, w->ahead);
    if (w->surface->neighbors[exit] == PSPLAT_NONE ||
        (w->surface->creases[exit] & PSPLAT_BOUND_CREASE))
        return 0;
    turn_over(w, exit);
    w->entry = edge_across(w->surface, exit);
    w->triangle = w->entry / 3;
    return 1;
}

/* ---- the two sides of an edge ---------------------------------------------------------------- */

/* An edge with the frame in which normals are measured: that of the straight side. */
typedef struct place {
    const psplat_surface *surface;
    uint32_t edge;                 /* of the straight side */
    double straight[3], across[3]; /* unit: the normal of that side, and the way out of it */
    double tolerance;
} place;

/* A part of a walk over which the normal is one. */
typedef struct facet {
    double begin, end, angle; /* lengths, and by how far the normal is turned, radians */
} facet;

typedef struct turning {
    facet facets[MOST_FACETS];
    int count;
    double length;
} turning;

static double angle_of(const place *p, uint32_t triangle) {
    const double *n = face_normal(p->surface, triangle);
    return atan2(dot3(n, p->across), dot3(n, p->straight));
}

/* Returns how far, at most `most`, the surface is straight on the straight side. */
static double straight_length(const place *p, double greatest_angle, double most) {
    walker w = begin_walk(p->surface, p->edge);
    for (int step = 0; step < MOST_STEPS && w.length < most; ++step) {
        if (fabs(angle_of(p, w.triangle)) > greatest_angle || !walk_on(&w)) break;
    }
    return w.length;
}

/* Finds how the surface turns on the other side, at most `most` far. */
static void find_turning(const place *p, double most, turning *t) {
    walker w = begin_walk(p->surface, edge_across(p->surface, p->edge));
    t->count = 0;
    for (int step = 0, goes_on = 1; goes_on && step < MOST_STEPS && w.length < most; ++step) {
        double begin = w.length, angle = angle_of(p, w.triangle);
        goes_on = walk_on(&w);
        facet *last = t->count ? &t->facets[t->count - 1] : NULL;
        if (last && fabs(last->angle - angle) < facet_angle)
            last->end = w.length;
        else if (t->count < MOST_FACETS)
            t->facets[t->count++] = (facet){begin, w.length, angle};
        else
            break;
    }
    t->length = t->count ? t->facets[t->count - 1].end : 0;
}

/* Finds the rate at which normals turn over a length, one over a length. Returns the root mean
 * square of what they differ from that. */
static double fit_rate(const turning *t, double length, double *rate) {
    double products = 0, squares = 0, rest = 0;
    for (int i = 0; i < t->count && t->facets[i].begin < length; ++i) {
        const facet *f = &t->facets[i];
        double end = min2(f->end, length), middle = (f->begin + end) / 2, weight = end - f->begin;
        products += weight * middle * f->angle;
        squares += weight * middle * middle;
    }
    *rate = squares > 0 ? products / squares : 0;
    for (int i = 0; i < t->count && t->facets[i].begin < length; ++i) {
        const facet *f = &t->facets[i];
        double end = min2(f->end, length), middle = (f->begin + end) / 2;
        double error = f->angle - *rate * middle;
        rest += (end - f->begin) * error * error;
    }
    return sqrt(rest / length);
}

/* Returns how far splats would reach over the edge of a place, a length; 0 where it is no tangent
 * edge whose straight side is that of the place. */
static double find_reach(const place *p) {
    double dihedral = fabs(angle_of(p, p->surface->neighbors[p->edge]));
    if (dihedral < least_dihedral || dihedral > greatest_dihedral) return 0;
    /* The greatest reach is that at the least error. */
    double most = 2 * p->tolerance / least_error;
    double straight =
        straight_length(p, min2(straight_share * dihedral, straight_error_share * least_error),
                        straight_reaches * most);
    /* Errors are less than a radian, so that the reach is at least this. */
    if (straight < straight_reaches * 2 * p->tolerance) return 0;
    turning t;
    find_turning(p, most_facets_reaches * most, &t);
    if (t.count < TURNING_FACETS) return 0;
    double least = t.facets[TURNING_FACETS - 1].end;
    if (!(least > 0) || straight < straight_facets / TURNING_FACETS * least) return 0;
    for (double length = t.length; length > least; length *= length_factor) {
        double rate, residual = fit_rate(&t, length, &rate), turn = fabs(rate);
        double reach = sqrt(2 * p->tolerance / turn), error = sqrt(2 * p->tolerance * turn);
        if (!(error >= least_error) || length < turning_reaches * reach) continue;
        if (residual > greatest_residual * turn * length) continue;
        if (dihedral < least_dihedral_share * turn * t.facets[0].end) continue;
        return straight < straight_reaches * reach ? 0 : reach;
    }
    return 0;
}

/* The same for either side of an edge. */
static double reach_over(const psplat_surface *surface, uint32_t edge, double tolerance) {
    const uint32_t sides[2] = {edge, edge_across(surface, edge)};
    for (int k = 0; k < 2; ++k) {
        place p = {.surface = surface, .edge = sides[k], .tolerance = tolerance};
        double along[3];
        memcpy(p.straight, face_normal(surface, sides[k] / 3), sizeof p.straight);
        psplat_edge_vector(surface->mesh, sides[k], along);
        cross3(p.across, along, p.straight);
        normalize3(p.across);
        double reach = find_reach(&p);
        if (reach > 0) return reach;
    }
    return 0;
}

/* ---- chains ---------------------------------------------------------------------------------- */

/* An edge that may be marked; chains are a union-find forest over them. */
typedef struct link {
    uint32_t edge, parent;
    double reach;                /* over this edge */
    double length, reach_length; /* of the chain at its root: of all, and times their reaches */
} link;

/* One end of a link. */
typedef struct link_end {
    uint32_t vertex, link;
    double outward[3]; /* unit, along the edge */
} link_end;

static int compare_ends(const void *left, const void *right) {
    const link_end *a = left, *b = right;
    if (a->vertex != b->vertex) return a->vertex < b->vertex ? -1 : 1;
    return a->link < b->link ? -1 : a->link > b->link;
}

static uint32_t find_root(link *links, uint32_t i) {
    while (links[i].parent != i) i = links[i].parent = links[links[i].parent].parent;
    return i;
}

/* Joins links whose edges go on from one to the other. ends has room for two of each. */
static void join_links(const psplat_mesh *mesh, link *links, uint32_t count, link_end *ends) {
    double straight = cos(greatest_chain_angle);
    for (uint32_t i = 0; i < count; ++i) {
        double along[3];
        psplat_edge_vector(mesh, links[i].edge, along);
        normalize3(along);
        for (int k = 0; k < 2; ++k) {
            link_end *end = &ends[2 * i + (uint32_t)k];
            *end = (link_end){.vertex = psplat_edge_vertex(mesh, links[i].edge, k), .link = i};
            mad3(end->outward, k ? 1 : -1, along);
        }
    }
    qsort(ends, 2 * (size_t)count, sizeof *ends, compare_ends);
    for (size_t i = 0; i < 2 * (size_t)count; ++i)
        for (size_t k = i + 1; k < 2 * (size_t)count && ends[k].vertex == ends[i].vertex; ++k)
            if (-dot3(ends[i].outward, ends[k].outward) >= straight)
                links[find_root(links, ends[i].link)].parent = find_root(links, ends[k].link);
}

/* Marks the links of chains that are long enough. */
static void mark_chains(psplat_surface *surface, link *links, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) {
        double along[3];
        psplat_edge_vector(surface->mesh, links[i].edge, along);
        link *root = &links[find_root(links, i)];
        root->length += length3(along);
        root->reach_length += length3(along) * links[i].reach;
    }
    for (uint32_t i = 0; i < count; ++i) {
        const link *root = &links[find_root(links, i)];
        if (root->length * root->length < least_chain_reaches * root->reach_length) continue;
        psplat_crease_set(surface, links[i].edge, PSPLAT_BOUND_TANGENT);
        ++surface->tangent_edges;
    }
}

psplat_result psplat_tangent_edges_mark(psplat_surface *surface, double tolerance) {
    uint32_t edges = (uint32_t)(3 * surface->mesh->triangle_count), count = 0;
    surface->tangent_edges = 0;
    if (!(tolerance > 0)) return PSPLAT_OK;
    float *reaches = calloc(edges, sizeof *reaches);
    if (!reaches) return PSPLAT_ERROR_MEMORY;
#pragma omp parallel for schedule(dynamic, 4096) if (edges >= PSPLAT_MIN_PARALLEL_COUNT)
    for (uint32_t e = 0; e < edges; ++e)
        if (surface->neighbors[e] != PSPLAT_NONE && e / 3 < surface->neighbors[e] &&
            !surface->creases[e])
            reaches[e] = (float)reach_over(surface, e, tolerance);
    for (uint32_t e = 0; e < edges; ++e) count += reaches[e] > 0;
    link *links = malloc(((size_t)count + 1) * sizeof *links);
    link_end *ends = malloc((2 * (size_t)count + 1) * sizeof *ends);
    uint32_t at = 0;
    for (uint32_t e = 0; links && ends && e < edges; ++e)
        if (reaches[e] > 0)
            links[at] = (link){.edge = e, .parent = at, .reach = (double)reaches[e]}, ++at;
    if (links && ends) {
        join_links(surface->mesh, links, count, ends);
        mark_chains(surface, links, count);
    }
    psplat_result result = links && ends ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    free(links);
    free(ends);
    free(reaches);
    return result;
}

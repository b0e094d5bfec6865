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
 *
 * Models for games have narrow bevels of a facet or two, and the file's normals make them round:
 * those of flat faces are the faces' own, and they turn over the bevel. No facets tell where such a
 * bevel begins, but its normals do. Without these edges a parabola that is within the tolerance
 * rounds the corner off on both sides, over some 8 e / tan(a / 2) at an angle a between the faces,
 * so that all of a beam is shaded as if it were a log.
 */
#include "features/tangent_edges.h"

#include "base/angle.h"
#include "base/vector.h"
#include "features/authored_normals.h"
#include "features/crease_follow.h"
#include "features/surface.h"
#include "features/surface_walk.h"
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
/* Of bevels by the file's normals: flat is where these are within this of the face's, which is more
 * than rounding to bytes leaves, and for so far, in tolerances. With 8 degrees figures of few
 * polygons had hundreds of such edges, for nothing. */
static const double flat_angle = 1 * PSPLAT_DEGREE, flat_tolerances = 2;
/* How wide bevels are at most, in tolerances, and by how much normals turn at least: a splat over
 * both sides errs by half of that. Wider ones are covered well enough without an edge. */
static const double widest_bevel_tolerances = 3, least_bevel_turn = 16 * PSPLAT_DEGREE;
/* The reach over their edges, in tolerances. */
static const double bevel_reach_tolerances = 1;
/* Edges belong to one chain where they go on by at most this angle, and chains that are shorter,
 * in reaches, are dropped. */
static const double greatest_chain_angle = 25 * PSPLAT_DEGREE, least_chain_reaches = 6;

/* The most facets of a walk, and the most triangles. Facets are triangles in a row of one normal.
 */
enum { MOST_FACETS = 64, MOST_STEPS = 512 };
/* The difference of angles, radians, up to which triangles in a row are one facet. */
static const double facet_angle = 1e-5;

/* ---- the two sides of an edge ---------------------------------------------------------------- */

/* An edge with the frame in which normals are measured: that of the straight side. */
typedef struct place {
    const psplat_surface *surface;
    const uint8_t *authored;       /* psplat_authored_read */
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

static const double *face_normal(const psplat_surface *surface, uint32_t triangle) {
    return surface->face_normals + 3 * (size_t)triangle;
}

static double angle_of_normal(const place *p, const double n[3]) {
    return atan2(dot3(n, p->across), dot3(n, p->straight));
}

static double angle_of(const place *p, uint32_t triangle) {
    return angle_of_normal(p, face_normal(p->surface, triangle));
}

/* Returns how far, at most `most`, the surface is straight on the straight side. */
static double straight_length(const place *p, double greatest_angle, double most) {
    psplat_surface_walk w = psplat_surface_walk_begin(p->surface, p->edge);
    for (int step = 0; step < MOST_STEPS && w.length < most; ++step) {
        if (fabs(angle_of(p, w.triangle)) > greatest_angle || !psplat_surface_walk_on(&w)) break;
    }
    return w.length;
}

/* Starts the walk on the other side. */
static psplat_surface_walk begin_across(const place *p) {
    return psplat_surface_walk_begin(p->surface, psplat_surface_edge_across(p->surface, p->edge));
}

/* Finds how the surface turns on the other side, at most `most` far. */
static void find_turning(const place *p, double most, turning *t) {
    psplat_surface_walk w = begin_across(p);
    t->count = 0;
    for (int step = 0, goes_on = 1; goes_on && step < MOST_STEPS && w.length < most; ++step) {
        double begin = w.length, angle = angle_of(p, w.triangle);
        goes_on = psplat_surface_walk_on(&w);
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

/* ---- bevels by the file's normals ------------------------------------------------------------ */

/* Finds the file's unit normal at a point of an edge of a triangle. Returns 0 where it has none. */
static int authored_normal(const place *p, uint32_t edge, const double at[3], double normal[3]) {
    const psplat_mesh *mesh = p->surface->mesh;
    const uint32_t ends[2] = {edge, edge % 3 == 2 ? edge - 2 : edge + 1};
    const float *normals[2];
    double along[3], from[3];
    for (int k = 0; k < 2; ++k) {
        if (!(p->authored[ends[k]] & PSPLAT_AUTHORED_NORMAL)) return 0;
        normals[k] = mesh->corner_normals + 3 * (size_t)ends[k];
    }
    psplat_edge_vector(mesh, edge, along);
    sub3(from, at, psplat_mesh_corner(mesh, edge / 3, (int)(edge % 3)));
    double part = dot3(from, along) / dot3(along, along);
    for (int k = 0; k < 3; ++k)
        normal[k] = (1 - part) * (double)normals[0][k] + part * (double)normals[1][k];
    return normalize3(normal) >= PSPLAT_LEAST_NORMAL;
}

/* Finds the file's normals where a walk enters its triangle and where it leaves it. Returns the
 * length between; -1 where there is no way out or no such normal. */
static double step_normals(const place *p, const psplat_surface_walk *w, double first[3],
                           double last[3]) {
    uint32_t exit;
    double end[3], length = psplat_surface_walk_exit(w, &exit);
    if (exit == PSPLAT_NONE) return -1;
    along3(end, w->at, length, w->ahead);
    return authored_normal(p, w->entry, w->at, first) && authored_normal(p, exit, end, last)
               ? length
               : -1;
}

/* Returns whether the file's normals are that of the straight side's face for a length. */
static int is_authored_straight(const place *p, double length) {
    psplat_surface_walk w = psplat_surface_walk_begin(p->surface, p->edge);
    double least_cosine = cos(flat_angle);
    for (int step = 0; step < MOST_STEPS; ++step) {
        double first[3], last[3], further = step_normals(p, &w, first, last);
        if (!(further >= 0) ||
            min2(dot3(first, p->straight), dot3(last, p->straight)) < least_cosine)
            return 0;
        if (w.length + further >= length) return 1;
        if (!psplat_surface_walk_on(&w)) return 0;
    }
    return 0;
}

/* Returns the angle between two directions that are given as angles. */
static double angle_between(double a, double b) {
    return fabs(remainder(a - b, 2 * PSPLAT_PI));
}

/* Returns by which angle the file's normals turn over a bevel that begins at the edge, up to where
 * they are straight again, or to a crease; 0 where there is none. */
static double bevel_turn(const place *p) {
    psplat_surface_walk w = begin_across(p);
    double turned = 0, end = 0; /* what they have turned by at the end of the bevel so far */
    int step = 0;
    for (; step < MOST_STEPS; ++step) {
        double first[3], last[3], length = step_normals(p, &w, first, last);
        if (!(length >= 0)) return 0;
        double from = angle_of_normal(p, first), to = angle_of_normal(p, last);
        if (step == 0 && length > 0 && angle_between(from, to) <= flat_angle) return 0;
        if (max2(angle_between(from, turned), angle_between(to, turned)) > flat_angle)
            turned = to, end = w.length + length;
        if (end > widest_bevel_tolerances * p->tolerance) return 0;
        if (w.length + length - end >= flat_tolerances * p->tolerance) break;
        if (!psplat_surface_walk_on(&w)) break;
    }
    return step < MOST_STEPS ? fabs(turned) : 0;
}

/* Returns the reach that chains of the edges of bevels are measured in, a length; 0 where no bevel
 * begins at the edge whose straight side is that of the place. */
static double find_bevel_reach(const place *p) {
    if (!(p->authored[p->edge] & PSPLAT_AUTHORED_SMOOTH)) return 0;
    if (!is_authored_straight(p, flat_tolerances * p->tolerance)) return 0;
    return bevel_turn(p) >= least_bevel_turn ? bevel_reach_tolerances * p->tolerance : 0;
}

/* ---- either side ----------------------------------------------------------------------------- */

/* Returns how far splats would reach over an edge, a length; 0 where it is no tangent edge. */
static double reach_over(const psplat_surface *surface, const uint8_t *authored, uint32_t edge,
                         double tolerance) {
    const uint32_t sides[2] = {edge, psplat_surface_edge_across(surface, edge)};
    for (int k = 0; k < 2; ++k) {
        place p = {
            .surface = surface, .authored = authored, .edge = sides[k], .tolerance = tolerance};
        double along[3];
        memcpy(p.straight, face_normal(surface, sides[k] / 3), sizeof p.straight);
        psplat_edge_vector(surface->mesh, sides[k], along);
        cross3(p.across, along, p.straight);
        normalize3(p.across);
        double reach = find_reach(&p);
        if (!(reach > 0)) reach = find_bevel_reach(&p);
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

psplat_result psplat_tangent_edges_mark(psplat_surface *surface, const uint8_t *authored,
                                        double tolerance) {
    uint32_t edges = (uint32_t)(3 * surface->mesh->triangle_count), count = 0;
    surface->tangent_edges = 0;
    if (!(tolerance > 0)) return PSPLAT_OK;
    float *reaches = calloc(edges, sizeof *reaches);
    if (!reaches) return PSPLAT_ERROR_MEMORY;
#pragma omp parallel for schedule(dynamic, 4096) if (edges >= PSPLAT_MIN_PARALLEL_COUNT)
    for (uint32_t e = 0; e < edges; ++e)
        if (surface->neighbors[e] != PSPLAT_NONE && e / 3 < surface->neighbors[e] &&
            !surface->creases[e])
            reaches[e] = (float)reach_over(surface, authored, e, tolerance);
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

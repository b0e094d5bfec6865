/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * surface.h - the analysed mesh: neighbours, creases, smooth patches and corner normals.
 */
#ifndef PHONGSPLAT_FEATURES_SURFACE_H
#define PHONGSPLAT_FEATURES_SURFACE_H

#include <phongsplat/splat.h>

#include "appearance/appearance.h"
#include "mesh/mesh.h"

#include <stdint.h>

/* The least number of triangles or edges for which a loop is shared between threads. Shorter loops
 * take less time than waiting for the threads. Chosen by hand. */
enum { PSPLAT_MIN_PARALLEL_COUNT = 50000 };

/* What an edge bounds. Splats end at all kinds; normals are averaged across the smooth ones, which
 * are all but the first. */
enum {
    PSPLAT_BOUND_CREASE = 1,  /* sharp, a border, non-manifold, inconsistently oriented, or between
                                 two groups */
    PSPLAT_BOUND_CHART = 2,   /* smooth, but texture coordinates jump or mirror (chart_borders.h) */
    PSPLAT_BOUND_TANGENT = 4, /* smooth, but the curvature jumps, or a bevel begins
                                 (tangent_edges.h) */
    PSPLAT_BOUND_FACET = 8    /* smooth, but of facets that stand out (facet_edges.h) */
};

/* A mesh with what is known about its surface. Edge 3 t + k of triangle t runs from its corner k to
 * its corner (k + 1) % 3. Creases, borders of charts, tangent edges and edges of facets bound the
 * patches. */
typedef struct psplat_surface {
    const psplat_mesh *mesh;
    const psplat_appearance *appearance; /* set by the caller so that samples are baked; or NULL */
    double *face_normals;                /* triangle_count x 3, unit; of slivers, of those beside */
    double *face_areas;                  /* triangle_count */
    uint32_t *neighbors;   /* triangle_count x 3: triangle across the edge, or PSPLAT_NONE */
    uint8_t *creases;      /* triangle_count x 3: PSPLAT_BOUND_..., or 0 inside patches */
    uint32_t *patches;     /* triangle_count ids 0 ... patch_count - 1 */
    float *corner_normals; /* triangle_count x 9: the file's, or averaged within patches; none leans
                              from its triangle's by more than 58.7 degrees */
    /* triangle_count x 6: the changes of the kept texture coordinates s and t with the position, on
     * the triangle's plane, one over a length; NULL where no textures are kept */
    float *texcoord_slopes;
    size_t patch_count;
    size_t crease_edges; /* without borders */
    size_t border_edges;
    size_t chart_border_edges; /* that are no creases */
    size_t tangent_edges;      /* that are neither */
    size_t facet_edges;        /* that are none of these */
    double roughness;          /* root mean square of the dihedral angles inside patches, radians */
    double area;
    double diagonal; /* of the bounding box of used vertices */
    /* The lower and the upper corner of the box whose part of the surface splats are to cover, in
     * the mesh's centred coordinates; set by the caller. What lies outside is an apron: it bounds
     * what splats may reach. NULL: all is to be covered. */
    const double *owned;
} psplat_surface;

/* Returns whether splats are to cover a point of the surface. */
static inline int psplat_surface_owns(const psplat_surface *surface, const double point[3]) {
    const double *box = surface->owned;
    for (int k = 0; box && k < 3; ++k)
        if (!(point[k] >= box[k] && point[k] <= box[k + 3])) return 0;
    return 1;
}

void psplat_surface_free(psplat_surface *surface);

/* Returns whether any triangle keeps textures, so that texture coordinates are fitted. */
int psplat_surface_has_texcoords(const psplat_surface *surface);

/* Returns whether the material of a triangle keeps textures (appearance.h). */
int psplat_surface_keeps_textures(const psplat_surface *surface, uint32_t triangle);

/* Returns what a material keeps whose group a triangle has; NULL where it keeps no textures. */
const psplat_kept_textures *psplat_surface_kept_textures(const psplat_surface *surface,
                                                         uint32_t triangle);

/* Stores the kept texture coordinates that are interpolated at barycentric coordinates of a
 * triangle; 0 where it keeps no textures. */
void psplat_surface_texcoord(const psplat_surface *surface, uint32_t triangle,
                             const double barycentric[3], float texcoord[2]);

/* Stores the barycentric coordinates of a point of a triangle, clamped to the triangle. */
void psplat_surface_barycentric(const psplat_surface *surface, uint32_t triangle,
                                const double point[3], double barycentric[3]);

/* Where the normals of corners cancel each other, so that what is interpolated is no longer than
 * this, the normal is that of the triangle. */
#define PSPLAT_LEAST_NORMAL 1e-9

/* Stores the unit normal that is interpolated at barycentric coordinates of a triangle. */
void psplat_surface_normal(const psplat_surface *surface, uint32_t triangle,
                           const double barycentric[3], float normal[3]);

#endif

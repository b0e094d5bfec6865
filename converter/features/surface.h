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

/* A mesh with what is known about its surface. Edge 3 t + k of triangle t runs from its corner k to
 * its corner (k + 1) % 3. Crease edges bound the smooth patches: an edge is a crease if it is
 * sharp, a border, non-manifold, inconsistently oriented, or between two groups. */
typedef struct psplat_surface {
    const psplat_mesh *mesh;
    const psplat_appearance *appearance; /* set by the caller so that samples are baked; or NULL */
    double *face_normals;                /* triangle_count x 3, unit */
    double *face_areas;                  /* triangle_count */
    uint32_t *neighbors;   /* triangle_count x 3: triangle across the edge, or PSPLAT_NONE */
    uint8_t *creases;      /* triangle_count x 3 flags */
    uint32_t *patches;     /* triangle_count ids 0 ... patch_count - 1 */
    float *corner_normals; /* triangle_count x 9: the file's, or averaged within patches */
    size_t patch_count;
    size_t crease_edges; /* without borders */
    size_t border_edges;
    double roughness; /* root mean square of the dihedral angles inside patches, radians */
    double area;
    double diagonal; /* of the bounding box of used vertices */
} psplat_surface;

void psplat_surface_free(psplat_surface *surface);

/* Stores the barycentric coordinates of a point of a triangle, clamped to the triangle. */
void psplat_surface_barycentric(const psplat_surface *surface, uint32_t triangle,
                                const double point[3], double barycentric[3]);

/* Stores the unit normal that is interpolated at barycentric coordinates of a triangle. */
void psplat_surface_normal(const psplat_surface *surface, uint32_t triangle,
                           const double barycentric[3], float normal[3]);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_classify.h - classification of one edge as crease, weak or smooth.
 */
#ifndef PHONGSPLAT_FEATURES_CREASE_CLASSIFY_H
#define PHONGSPLAT_FEATURES_CREASE_CLASSIFY_H

#include "features/curvature.h"
#include "features/surface.h"

#include <stdint.h>

/* The kinds of edges, from smooth to crease. Kinds from PSPLAT_EDGE_PROBABLE on are creases; those
 * before can become creases when one reaches them (crease_follow.h). */
typedef enum psplat_edge_kind {
    PSPLAT_EDGE_SMOOTH = 0,
    PSPLAT_EDGE_UNTESTED,  /* COLLINEAR, WEAK or SMOOTH; decided when a crease reaches it */
    PSPLAT_EDGE_COLLINEAR, /* a crease where it continues one without turning much */
    PSPLAT_EDGE_WEAK,      /* a crease where it touches one */
    PSPLAT_EDGE_PROBABLE,  /* a crease that may be noise: long chains of such edges stay */
    PSPLAT_EDGE_SHARP,     /* a crease without noise: chains of moderate length stay */
    PSPLAT_EDGE_AUTHORED   /* a crease by groups or normals of the file: stays at any length */
} psplat_edge_kind;

/* Classifies an edge that has a neighbour as SMOOTH, UNTESTED (its angle without noise is
 * weak_angle or more), PROBABLE or SHARP. Angles in radians. */
psplat_edge_kind psplat_crease_classify(const psplat_surface *surface,
                                        const psplat_curvature *curvature, uint32_t edge,
                                        double crease_angle, double weak_angle);

/* Classifies an UNTESTED edge as SMOOTH, COLLINEAR or WEAK. */
psplat_edge_kind psplat_crease_classify_weak(const psplat_surface *surface,
                                             const psplat_curvature *curvature, uint32_t edge,
                                             double crease_angle, double weak_angle);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * folds.h - which points are near the creases of a surface.
 */
#ifndef PHONGSPLAT_FOLDS_H
#define PHONGSPLAT_FOLDS_H

#include "stages.h"

/* Edges across which normals jump: creases, and where more than two triangles meet or two disagree
 * about their sides. Borders are none. */
typedef struct psplat_folds {
    const psplat_mesh *mesh;
    uint32_t *edges; /* 3 * triangle + k */
    size_t count;
    psplat_locator *locator;
    double width;
} psplat_folds;

/* MEMORY is the only failure. surface must outlive the folds. */
psplat_result psplat_folds_create(const psplat_surface *surface, double width, psplat_folds *folds);
/* Whether a point lies within the width of one. */
int psplat_folds_near(const psplat_folds *folds, const double point[3]);
void psplat_folds_free(psplat_folds *folds);

#endif

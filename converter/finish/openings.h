/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * openings.h - holes and rays that pass between splats which a step has made smaller, and the
 * splats that closed them before.
 */
#ifndef PHONGSPLAT_FINISH_OPENINGS_H
#define PHONGSPLAT_FINISH_OPENINGS_H

#include <phongsplat/splat.h>

#include "measure/measured_splats.h"
#include "measure/ray_holes.h"
#include "select/conversion.h"

#include <stddef.h>
#include <stdint.h>

/* How far above or below a splat, in tolerances, a point may lie to be on the same surface. */
#define PSPLAT_SAME_SURFACE_TOLERANCES 2.0

/* A ray that meets nothing where it sees the surface, or a hole. */
typedef struct psplat_opening {
    const psplat_ray_hole *ray; /* NULL: it is a hole */
    double point[3], normal[3]; /* of the hole, and of the surface there */
    int is_inside_seams;        /* 1: what lies beyond seams does not close the hole */
} psplat_opening;

/* What a step has done to a splat. */
typedef struct psplat_smaller {
    double worth; /* of being smaller: of several splats, the one is enlarged that is worth least */
    int is_smaller; /* 1 also of one that is left out, and not taken any more */
} psplat_smaller;

/* A selection of which a step has made some splats smaller. */
typedef struct psplat_shrunk {
    psplat_conversion *c;
    /* The regions of all candidates as they were; no fields; owned. Its tree finds those on whose
     * surface a point is; walls are less high than that. Its wall, 0 at first, is that of which
     * splats get back what stops a ray.
     */
    psplat_measured_splats before;
    psplat_smaller *splats; /* one for each of these; owned, all 0 at first */
    /* Gives a splat back what closes an opening. Returns whether that changes it. May clear
     * is_smaller. */
    int (*give_back)(void *user, uint32_t splat, const psplat_opening *opening);
    void *user;
} psplat_shrunk;

/* Copies the regions of all candidates, before they change. psplat_shrunk_free frees what *shrunk
 * owns, also where this fails. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_shrunk_begin(psplat_conversion *c, psplat_shrunk *shrunk);

/* Returns the indices of all candidates, those of greatest worth first, and of equal ones in their
 * order. The caller frees them; NULL when out of memory. */
uint32_t *psplat_shrunk_order(const psplat_shrunk *shrunk);

/* Returns whether any splat is smaller. */
int psplat_shrunk_is_any(const psplat_shrunk *shrunk);

/* Gives splats back what closes the rays and the holes that they have opened. Walls under rims stop
 * rays, and what still hides that there is one closes it; of splats with seams, what lies inside of
 * these has to be closed by such, too. A splat that is left out is smaller and not taken. Fails
 * only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_shrunk_close(psplat_shrunk *shrunk);

void psplat_shrunk_free(psplat_shrunk *shrunk);

#endif

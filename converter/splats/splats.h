/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splats.h - the splats of one mesh, sorted and grouped as a file holds them.
 */
#ifndef PHONGSPLAT_SPLATS_SPLATS_H
#define PHONGSPLAT_SPLATS_SPLATS_H

#include <phongsplat/splat.h>

#include "base/region.h"

#include <stdint.h>

/* Consecutive splats that may become one primitive. */
typedef struct psplat_run {
    size_t count;
    uint32_t clip_lines;   /* the number of clip lines that each splat has */
    uint32_t seam_lines;   /* how many of these, the last ones, are seams (spec 3.6) */
    uint32_t material;     /* index into the materials */
    float depth_tolerance; /* epsilon of spec 5.3, in the mesh's units */
    int is_curved;         /* 0: the shape of every splat is 0 */
    int has_shape;         /* 1: the splats are curved, and their fields are not those of their
                              shapes, of which x and y are 0 (spec 3.4) */
    int has_bends;         /* 0: every clip line is straight */
    int has_texcoord; /* 1: the splats have texture coordinates, and the material its textures */
    int has_texcoord_bend; /* 1: of the second order */
} psplat_run;

/* The steps of the grid on which a file holds splats: each value is an integer times a step. All
 * are 0 where the file holds floats. */
typedef struct psplat_precision {
    double unit;       /* of positions, in the mesh's units; the node of the file scales by it */
    double scale_step; /* of the natural logarithm of radii */
    double turn_step, line_turn_step; /* half turns: one over a whole number */
    double tilt_step, field_step;     /* slopes of normal fields that move no surface */
    double shape_step;                /* slopes of surfaces, and of the fields that are theirs; 0
                                         where no run is curved */
    double line_step;                 /* parts of the ellipse: one over a whole number */
    double bend_step;                 /* of the bends of lines; 0 where all are straight */
    double texcoord_step;             /* of texture coordinates: a power of two; 0 where no run has
                                         them, or they are floats of no grid */
    double texcoord_slope_step;       /* of their change over a radius */
    double texcoord_bend_step;        /* of its second order; 0 where none is written */
    int normal_bits;                  /* of each of the two octahedral coordinates of N, 4 ... 14 */
    /* Small splats have coarser steps: a bit less for each halving of their radius (spec 3.12). The
     * steps of turns and lines are powers of two then. */
    int halving;       /* steps of radii in a halving; 0: all splats have the same steps */
    int reference;     /* radius from which on splats have these steps, as an integer */
    int shape_grades;  /* the most bits that second derivatives may have less */
    int normal_grades; /* the same of normals */
    int normal_shift;  /* the bits that normals have less; 0 but from psplat_precision_at */
    int line_shift;    /* the bits that lines have less; 0 but from psplat_precision_at */
} psplat_precision;

/* The splats of one mesh. They are sorted by their number of clip lines, and then of seams; then
 * come plane splats of flat surfaces, other plane ones and curved ones; then they are sorted by
 * material, and then in spatial order. Splats of flat surfaces lie on them and need next to no
 * depth tolerance. Each group but for the spatial order is a run. */
typedef struct psplat_splats {
    psplat_splat *splats;
    psplat_finish *finishes; /* count (spec 3.10); NULL where all are neutral */
    psplat_texcoord
        *texcoords; /* count (spec 3.11), 0 in runs without; NULL where no run has them */
    size_t count;
    psplat_run *runs; /* their counts add up to count */
    size_t run_count;
    psplat_material *materials; /* by index of the mesh's source_materials; at least one */
    size_t material_count;
    psplat_kernel kernel;
    int has_color;    /* 0: color is 1 1 1 1 in every splat */
    double origin[3]; /* the node of the file translates by it */
    psplat_precision precision;
} psplat_splats;

/* Frees all that splats owns, and zeroes it. */
void psplat_splats_free(psplat_splats *splats);

/* Returns the regions of the splats, in double precision: count of them, malloc'ed and owned
 * by the caller; NULL when out of memory. Splats beyond the last run have no seams. */
psplat_region *psplat_splat_regions(const psplat_splats *splats);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * conversion.h - the options of a conversion, and the data that its stages share.
 */
#ifndef PHONGSPLAT_SELECT_CONVERSION_H
#define PHONGSPLAT_SELECT_CONVERSION_H

#include <phongsplat/splat.h>

#include "appearance/appearance.h"
#include "features/samples.h"
#include "features/surface.h"
#include "fit/fit_context.h"
#include "measure/holes.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"
#include "select/selection.h"
#include "splats/splats.h"

#include <stdint.h>

/* The step of positions, in tolerances, that convert uses by default where splats lie on the
 * surface, since it makes files small. */
#define PSPLAT_USUAL_PRECISION 0.1

/* The greatest step of positions, in tolerances. With a larger one, a small splat next to a point
 * might find no centre near enough to keep the tolerance. */
#define PSPLAT_GREATEST_PRECISION 0.5

/* How colours change over a splat that has them (spec 3.10). */
typedef enum psplat_color_field {
    PSPLAT_COLOR_FIELD_CHOSEN = 0, /* linear where the colour tolerance is at most 6 %, and beyond
                                    * that where colours are smooth (select/color_field.h) */
    PSPLAT_COLOR_FIELD_CONSTANT,
    PSPLAT_COLOR_FIELD_LINEAR
} psplat_color_field;

/* The least effort (select/effort.h). It is not 0, since zeros are the defaults; the command line
 * calls it 0. */
enum { PSPLAT_EFFORT_NONE = -1 };

/* The greatest effort, and the one where none is given. */
enum { PSPLAT_GREATEST_EFFORT = 9, PSPLAT_DEFAULT_EFFORT = 4 };

/* The tolerance where none is given, in % of the bounding-box diagonal: a pixel where a model is
 * some 500 of them across. Of 0.5, 0.4, 0.3 and 0.2 it is the one at which bytes times the error of
 * pictures are least on the Duck, fandisk and part.obj, and within 3 % of least on the bunny; at
 * 0.5 outlines and highlights of machined parts waver visibly. */
#define PSPLAT_DEFAULT_TOLERANCE_PERCENT 0.2

/* The options of a conversion. Zeros are the defaults. */
typedef struct psplat_convert_desc {
    double tolerance_percent;        /* epsilon in % of the bounding-box diagonal; 0 means
                                        PSPLAT_DEFAULT_TOLERANCE_PERCENT */
    double normal_tolerance_degrees; /* greatest error of the normal field; 0 means unbounded */
    double crease_angle_degrees;     /* dihedral angle from which an edge is a crease, unless it is
                                      * noise; doubled where the file's normals agree; 0 means 30 */
    int no_creases;                  /* 1: only borders and non-manifold edges bound splats */
    double precision;                /* step of positions, in tolerances, where splats lie on the
                                        surface; up to 3.5 of it where they err by much of the
                                        tolerance (select/precision.h); at most
                                        PSPLAT_GREATEST_PRECISION; 0: all values are floats */
    int constant_normals;            /* 1: fields without gradients, as Gaussian splats have */
    double color_tolerance_percent;  /* greatest root mean square of a splat's colour error over its
                                      * samples, in % of sRGB's range; 100: unbounded; 0 means 10,
                                      * times the root of epsilon over 0.5 %: 6.3 at 0.2 % */
    psplat_color_field color_field;
    int effort;      /* 1 ... 9: how long splats are improved, as convert's --effort; or
                      * PSPLAT_EFFORT_NONE; 0 means PSPLAT_DEFAULT_EFFORT */
    uint64_t seed;   /* of all random choices */
    int unverified;  /* 1: a report gets counts only; psplat_convert_verify adds the rest */
    double diagonal; /* the length that all percentages are of, in the mesh's units, where the mesh
                      * is a part of something larger; the tolerance is then at most 20 % of the
                      * mesh's own diagonal; 0: that of its own bounding box */
    /* Called now and then with the stage's name and the fraction 0 ... 1 of it that is done. A
     * return other than 0 stops the conversion with PSPLAT_ERROR_INTERRUPTED. May be NULL. */
    int (*progress)(void *user, const char *stage, double fraction);
    void *user;
    int bake_textures; /* 1: textures become colours and finishes of splats; 0: splats get texture
                          coordinates where the mesh has them, and materials keep their textures */
    double texture_tolerance_texels; /* greatest error of texture coordinates, in texels of the
                                        largest texture of the material; 0: as far as the texture
                                        slides by epsilon over the surface */
    int planar; /* 1: flat splats alone, as in the paper of 2004; 0: curved where that needs fewer
                 */
    /* The lower and the upper corner (x, y, z each) of the box whose part of the mesh splats are to
     * cover, in the coordinates of the mesh's file, where the mesh is a part of something larger:
     * what lies outside is an apron, which bounds what splats may reach. No splat is made for it,
     * and neither holes nor errors are looked for there. NULL: all of the mesh. */
    const double *owned;
    /* 1: positions may need more than 16 bits, since the splats will be written in parts; else
     * such splats are not rounded to a grid. */
    int is_written_in_parts;
    /* 1: narrow wires may become as wide as the tolerance lets them, as in levels of detail, which
     * are seen from where that is a pixel; 0: they are fitted to a part of their width */
    int has_coarse_wires;
} psplat_convert_desc;

/* The data that the stages of a conversion share. */
typedef struct psplat_conversion {
    const psplat_convert_desc *desc;
    psplat_mesh shown; /* the mesh without what alpha masks hide; empty where it has no masks */
    psplat_surface surface;
    psplat_appearance appearance;
    psplat_samples samples;
    psplat_limits limits;
    psplat_distance *distance; /* to the mesh; NULL unless is_fitted */
    psplat_distance *proxy;    /* to its proxy, which fits ask instead; NULL where none pays */
    double proxy_deviation;    /* of the proxy (mesh/proxy.h), a length */
    int is_fitted;      /* set before psplat_conversion_begin: splats will be fitted, for which
                           the mesh gets a tree and, if it is large, a proxy */
    int ends_at_facets; /* set before psplat_conversion_begin: splats end at edges between facets
                           that are large beside the tolerance (features/facet_edges.h) */
    psplat_selection selection;
    psplat_hole_memory hole_memory; /* of psplat_fill_holes */
    psplat_splats *splats;          /* the result; not owned */
    double tolerance;               /* of fits, in the mesh's units: percent of diagonal, or less
                                       where the mesh consists of narrow wires */
    psplat_kernel kernel;           /* that splats blend with */
    float (*color_ranges)[16];      /* of limits */
    double finest;     /* sample spacing that is fine enough for any surface, a length */
    double percent;    /* the tolerance that is promised, in % of diagonal */
    double wire_width; /* of the mesh (mesh/wire_width.h) */
    double diagonal;
    double owned[6]; /* desc->owned in the mesh's centred coordinates */
} psplat_conversion;

/* Builds all of c that does not depend on samples: surface, limits and appearance. c holds desc and
 * splats; mesh must outlive c. psplat_conversion_free must follow, even where this fails. Errors:
 * ARGUMENT (an effort out of range), MEMORY, INTERRUPTED, NO_SPLATS, RANGE (too large a mesh, too
 * small a tolerance). */
psplat_result psplat_conversion_begin(psplat_conversion *c, const psplat_mesh *mesh,
                                      psplat_error *error);

/* Frees what only fits need: selection, samples and trees. */
void psplat_conversion_free_fit(psplat_conversion *c);

/* Frees all but the splats. */
void psplat_conversion_free(psplat_conversion *c);

/* Returns the context of fits to the surface and samples of a conversion, without scratch memory.
 */
psplat_fit_context psplat_conversion_context(const psplat_conversion *c);

/* Reports progress to desc->progress. Returns whether the conversion is to stop. */
int psplat_conversion_interrupted(const psplat_convert_desc *desc, const char *stage,
                                  double fraction);

#endif

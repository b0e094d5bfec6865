/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * compare.h - an asset, or another mesh, against the mesh that it stands for: distances, normals
 * and coverage on samples of both (shape), and pictures of both from fixed views (gallery).
 *
 * Nothing here knows how the asset was made: what is measured is what its file says. Lengths are
 * percent of the source's bounding-box diagonal, angles degrees, unless a name says otherwise.
 */
#ifndef PHONGSPLAT_COMPARE_H
#define PHONGSPLAT_COMPARE_H

#include "converter.h"

#include <phongsplat/host.h>
#include <phongsplat/phongsplat.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- original.c: the mesh that is compared with -----------------------------------------------
 */

/* A mesh with what measuring it takes: creases, normals as the converter gives them, and a tree of
 * its triangles. Opaque. */
typedef struct psplat_original psplat_original;

/* crease_angle_degrees as in psplat_convert_desc (0: 30). The mesh must outlive the source. Errors:
 * MEMORY, RANGE. */
psplat_result psplat_original_create(const psplat_mesh *mesh, double crease_angle_degrees,
                                     psplat_original **original, psplat_error *error);
void psplat_original_destroy(psplat_original *original); /* NULL is accepted */

/* ---- shape.c: distances, normals, coverage --------------------------------------------------- */

/* Of area-weighted samples. */
typedef struct psplat_spread {
    double max, rms, p95;
} psplat_spread;

typedef struct psplat_shape_errors {
    double diagonal;       /* of the source, in its units: 100 % of every distance */
    size_t elements;       /* splats, or triangles of another mesh */
    size_t source_samples; /* points of the source, and of what is compared with it */
    size_t target_samples;
    psplat_spread outward;       /* from source points to the nearest point of the target: one-sided
                                    Hausdorff distance, %, where max is a lower bound by sampling */
    psplat_spread inward;        /* from target points to the nearest point of the source */
    psplat_spread distance;      /* two-sided: max is the greater one; rms and p95 of both sides'
                                    samples, each side weighing one half */
    psplat_spread normal;        /* blended normal against the source's, degrees, where covered */
    psplat_spread face_normal;   /* the same away from creases */
    psplat_spread crease_normal; /* and within crease_width of one */
    double crease_width;         /* %, as used */
    double crease_area;          /* % of the source's area within crease_width of a crease */
    double uncovered_area; /* % of the source's area where a look along its normal, from either
                              side within reach, meets no front side of the target */
    double overhang_area;  /* % of the target's area that is farther than reach / 2 from the
                              source */
    double reach;          /* %, as used */
} psplat_shape_errors;

/* Zeros are the defaults. */
typedef struct psplat_shape_desc {
    size_t samples; /* on either side; 0: 200,000 */
    uint64_t seed;
    double reach; /* %; 0: twice the greatest depth tolerance of the asset (spec 5.3), 1 % for
                     a mesh */
    double crease_width; /* %; 0: reach */
} psplat_shape_desc;

/* Measures an asset whose scene space is the source file's. Errors: ARGUMENT, MEMORY, RANGE. */
psplat_result psplat_shape_compare(const psplat_original *source, const psplat_asset *asset,
                                   const psplat_shape_desc *desc, psplat_shape_errors *errors,
                                   psplat_error *error);
/* The same for another mesh, as a mesh simplifier leaves it. */
psplat_result psplat_shape_compare_mesh(const psplat_original *source,
                                        const psplat_original *target,
                                        const psplat_shape_desc *desc, psplat_shape_errors *errors,
                                        psplat_error *error);

/* What a place of the source is like in the target, for maps of where errors sit. */
typedef struct psplat_shape_probe psplat_shape_probe;
psplat_result psplat_shape_probe_create(const psplat_original *source, const psplat_asset *asset,
                                        const psplat_shape_desc *desc, psplat_shape_probe **probe,
                                        psplat_error *error);
/* The same for another mesh, which must outlive the probe. */
psplat_result psplat_shape_probe_create_mesh(const psplat_original *source,
                                             const psplat_original *target,
                                             const psplat_shape_desc *desc,
                                             psplat_shape_probe **probe, psplat_error *error);
/* point: in the coordinates of the source's file, on its surface but for rounding. *distance to the
 * nearest point of the target, %; *angle of the blended normal, degrees, negative: not covered. */
void psplat_shape_probe_at(const psplat_shape_probe *probe, const double point[3],
                           const double normal[3], double *distance, double *angle);
void psplat_shape_probe_destroy(psplat_shape_probe *probe); /* NULL is accepted */

/* ---- context.c: what pictures are drawn in ----------------------------------------------------
 */

/* GL where there is one, GLES where that is all. software: Mesa's rasteriser. Errors: those of
 * psplat_host_create. */
psplat_result psplat_context_create(int software, psplat_host **host, psplat_error *error);

/* ---- gallery.c: pictures of the source, and of what stands for it ------------------------------
 */

/* Views from the corners of an icosahedron, turned so that none looks along an axis (views.c); a
 * camera as psplat_viewpoint_fit places it around the source's bounding sphere and a twentieth
 * more, for what sticks out in an exhibit, with its light. */
#define PSPLAT_GALLERY_VIEWS 12

typedef struct psplat_gallery psplat_gallery;

typedef struct psplat_gallery_desc {
    psplat_host *host; /* its context is current in every call; GL or GLES */
    const psplat_original *source;
    int size; /* pictures are size x size pixels, at most 8192; 0: 512 */
} psplat_gallery_desc;

/* Draws the source, lit per pixel with the lights and the material that splats get, from all views.
 * host and source must outlive it. The host's framebuffer is used, here and below, and GL's state
 * is to be at its defaults. Errors: ARGUMENT, MEMORY, GRAPHICS. */
psplat_result psplat_gallery_create(const psplat_gallery_desc *desc, psplat_gallery **gallery,
                                    psplat_error *error);
void psplat_gallery_destroy(psplat_gallery *gallery); /* NULL is accepted */
/* A view of the gallery, 0 ... PSPLAT_GALLERY_VIEWS - 1, for drawing with psplat_draw. */
psplat_view psplat_gallery_view(const psplat_gallery *gallery, int view);

/* Of pictures as shown: sRGB-encoded, 8 bits a channel, black where nothing is. */
typedef struct psplat_picture_errors {
    double psnr;       /* dB, of the pixels that either picture covers; INFINITY where they agree */
    double ssim;       /* Wang et al. 2004, luma, 11 x 11 Gaussian windows, mean over the windows
                          centred on pixels that either covers; 1: alike */
    double difference; /* mean absolute, % of white, of the pixels that either covers */
    double inside;     /* the same of those that both cover */
    double missing;    /* pixels that only the source covers, % of those that it covers */
    double extra;      /* pixels that it does not cover, the same; 100 where it covers none */
    double distant; /* mean absolute, % of white, at an eighth of the size, of the pixels that the
                       source fills and the exhibit covers there; the source as it should look,
                       its full size averaged in linear light */
    double perceptual; /* butteraugli's 3-norm (butteraugli.c) of the whole picture where
                          butteraugli_main is installed, negative elsewhere or where it was not
                          asked for */
    size_t covered;    /* pixels that the source covers */
} psplat_picture_errors;

/* What is drawn instead of the source: item and mode of a renderer of the host's context, or,
 * where mesh is given, another mesh, drawn as the source is. */
typedef struct psplat_exhibit {
    psplat_renderer *renderer;
    psplat_model *model;
    psplat_mode mode;
    int no_filter;
    const psplat_original *mesh;
} psplat_exhibit;

/* Errors of one view, or, where view is negative, of all of them as one long picture (covered
 * added up). perceptual: whether to ask for that too. Errors: ARGUMENT, MEMORY, GRAPHICS, and of
 * butteraugli_main WRITE (no temporary file) and READ (it fails). */
psplat_result psplat_gallery_compare(psplat_gallery *gallery, const psplat_exhibit *exhibit,
                                     int view, int perceptual, psplat_picture_errors *errors,
                                     psplat_error *error);

/* Five panels of size x size pixels side by side, 8-bit RGB, row 0 on top, from malloc: the source,
 * the exhibit, the difference of both, the distance and the normal error of what is seen of the
 * source. Colours run from black (0) over violet and orange to pale yellow (the limits and more).
 * Cyan: not covered, as the probe says; dark grey: nothing is there. Errors: ARGUMENT, MEMORY,
 * GRAPHICS; *pixels is NULL then. */
typedef struct psplat_heatmap_limits {
    double difference; /* % of white */
    double distance;   /* % */
    double angle;      /* degrees */
} psplat_heatmap_limits;
psplat_result psplat_gallery_heatmap(psplat_gallery *gallery, const psplat_exhibit *exhibit,
                                     const psplat_shape_probe *probe, int view,
                                     const psplat_heatmap_limits *limits, uint8_t **pixels,
                                     int *width, int *height, psplat_error *error);

/* Draws the source itself into the framebuffer that is bound, for timing it beside splats. Errors:
 * ARGUMENT (light other than directional, shadows), MEMORY, GRAPHICS. */
psplat_result psplat_gallery_draw_original(psplat_gallery *gallery, const psplat_view *view,
                                           psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif

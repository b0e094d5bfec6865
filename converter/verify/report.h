/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * report.h - the report of a conversion: what it promised and what was measured, as numbers and as
 * JSON.
 */
#ifndef PHONGSPLAT_VERIFY_REPORT_H
#define PHONGSPLAT_VERIFY_REPORT_H

#include <phongsplat/splat.h>

#include "scene/scene.h"

#include <stdint.h>

/* What a conversion promises about its splats, each cut by its clip lines. Verification proves
 * coverage and distance, piece by piece of the surface and of each splat, and measures normals on
 * samples of the surface other than those that were fitted. A promise is broken where a point was
 * found that breaks it; where neither such a point nor a proof was found, the report says so. The
 * limits allow for single precision. A splat covers a surface point that lies over or
 * under it by at most the tolerance and whose normal is on the same side as its own. */
typedef enum psplat_promise {
    PSPLAT_PROMISE_COVERAGE, /* each surface point is covered by a splat */
    PSPLAT_PROMISE_DISTANCE, /* each point of a splat is within the tolerance of the surface, and
                                each surface point is within it of a splat (Hausdorff distance) */
    PSPLAT_PROMISE_NORMAL,   /* each covered surface point has, among the splats that cover it, one
                                whose own normal field there is within the normal tolerance of the
                                surface's (interpolated) normal; the blended normal may differ */
    PSPLAT_PROMISE_CREASE,   /* no crease or border of the sheet that a splat covers lies inside the
                                splat by more than the tolerance, where what the splat shows beyond
                                it is seen to be wrong (measure/crease_spill.h; splats of
                                neighbouring patches meet a little beyond their crease, or cracks
                                would show) */
    PSPLAT_PROMISE_TEXTURE,  /* at 995 of 1000 surface points, the textures of the splat that weighs
                                most there, of those of its chart that cover it, slide over the
                                surface by no more than the tolerance, or than a number of texels;
                                of an error in texels a quarter does not count as sliding
                                (measure/texture_slides.h), nor does any that nobody sees: what is
                                shown looks the same, or another layer of the surface lies above the
                                point within the tolerance (measure/hidden_samples.h). A point that
                                only splats of other charts cover counts as one that slides by the
                                whole diagonal, or a side of the image, where one sees that and the
                                borders of its chart are farther away than the tolerance */
    PSPLAT_PROMISE_COLOR,    /* at 950 of 1000 surface points, what was baked of textures or comes
                                from vertices (base colour, emissive, roughness, metallic) is shown
                                within the colour tolerance, as it is within the tolerance of that
                                point (measure/color_errors.h) */
    PSPLAT_PROMISE_COUNT
} psplat_promise;

/* How one promise was kept. */
typedef struct psplat_kept {
    double limit; /* degrees for normals, % of a range for colours, texels for textures whose
                     tolerance is in texels, else % of the diagonal; 0: the promise was not given,
                     as for normals without a tolerance, for textures where none is kept, and for
                     colours without any */
    double worst; /* the greatest value found, in the same unit; for coverage, the greatest distance
                     of an uncovered point from the nearest splat, which may lie beside the point;
                     for textures and colours, the value that 5 or 50 of 1000 samples
                     exceed */
    size_t broken; /* the number of samples, holes, splats or crease edges beyond the limit */
} psplat_kept;

/* The greatest number of places in a report. */
#define PSPLAT_MOST_PLACES 16

/* A place where a promise is broken. */
typedef struct psplat_place {
    psplat_promise promise;
    double position[3]; /* in the coordinates of the mesh's file */
    double value;       /* found there, in the unit of its promise */
    uint32_t mesh;      /* index in the scene; 0 where there is only one */
} psplat_place;

/* What was counted in a conversion, and what was measured on samples of the surface other than
 * those that were fitted. Percentages of lengths are of the diagonal. */
typedef struct psplat_report {
    size_t splats;
    size_t splats_by_clip_lines[PSPLAT_MAX_CLIP_LINES + 1];
    size_t triangles, patches, crease_edges, border_edges;
    size_t chart_border_edges;   /* smooth edges at which kept texture coordinates jump or mirror */
    size_t tangent_edges;        /* smooth edges at which splats end since the curvature jumps */
    size_t facet_edges;          /* smooth edges at which splats end since facets are large */
    size_t samples;              /* fitted */
    size_t verification_samples; /* measured */
    size_t bytes;                /* of the file written */
    double seconds;              /* wall clock, reading and writing included */
    size_t peak_memory_bytes;    /* of the process */
    double diagonal;             /* of the bounding box, in the mesh's units */
    double tolerance_percent;
    double max_distance_percent;          /* two-sided: the greater of the next two */
    double max_distance_surface_percent;  /* from the surface to the nearest splat that covers it,
                                             along that splat's normal; where none does, to any */
    double max_distance_splats_percent;   /* from the splats to the surface */
    double bound_distance_splats_percent; /* proven: no point of a splat is farther away */
    size_t unproven_splats; /* whose bound exceeds the tolerance, though no point found does */
    double unproven_surface_percent; /* of the area: the part where coverage was neither proven nor
                                        seen to be broken */
    double rms_distance_percent;     /* from the surface to splats, as above */
    double rms_normal_degrees;       /* angle from the blended normal to the surface's */
    double p95_normal_degrees;
    double rms_normal_constant_degrees; /* the same with gradients set to 0 */
    double p95_normal_constant_degrees;
    /* The difference of the blended base colour from the surface's, over R, G and B, in % of the
     * range of sRGB; 0 where the mesh has neither textures nor colours of vertices. */
    double rms_color_percent;
    double p95_color_percent;
    double rms_color_constant_percent; /* the same with gradients set to 0 */
    double p95_color_constant_percent;
    /* The errors of PSPLAT_PROMISE_COLOR, in % of a range; 0 where nothing is baked. */
    double max_look_percent;
    double p95_look_percent;
    double look_beyond_percent; /* of the samples: their error is beyond the tolerance */
    /* How far kept textures slide over the surface, in % of the diagonal and in texels, as for
     * PSPLAT_PROMISE_TEXTURE; 0 where none is kept. */
    double max_texture_slide_percent;
    double p95_texture_slide_percent;
    double max_texture_slide_texels;
    double p95_texture_slide_texels;
    double mirrored_texture_percent; /* of the textured area: the splat that weighs most there shows
                                        the image the other way round, where one sees that
                                        (measure/texture_slides.h) */
    double foreign_texture_percent;  /* the same, where that splat is of another chart */
    double texture_tolerance_texels; /* the limit of PSPLAT_PROMISE_TEXTURE is in texels; 0: it is
                                        in % of the diagonal */
    double max_normal_degrees; /* as for PSPLAT_PROMISE_NORMAL, whether that was given or not */
    size_t uncovered_samples;  /* among verification_samples */
    psplat_kept promises[PSPLAT_PROMISE_COUNT];
    psplat_place places[PSPLAT_MOST_PLACES]; /* the worst of each broken promise, by promise */
    size_t place_count;
} psplat_report;

/* Returns the promise that is broken at the report's first place, or PSPLAT_PROMISE_COUNT where all
 * are kept. */
psplat_promise psplat_report_broken(const psplat_report *report);

/* Writes a report as one JSON object with the fields of psplat_report as keys. *text is malloc'ed
 * and owned by the caller; it has *size bytes and no terminator. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_report_json(const psplat_report *report, char **text, size_t *size,
                                 psplat_error *error);

/* The reports of a scene. Percentages are of the diagonal of the shown scene's bounding box, and of
 * errors as the instance that stretches a mesh most shows them. So one bound holds wherever a mesh
 * is shown. */
typedef struct psplat_scene_report {
    psplat_report total;   /* sums, greatest errors, root mean squares over all samples; p95 values
                              are the greatest of all meshes */
    psplat_report *meshes; /* by mesh of the scene; zeros for meshes without splats */
    size_t mesh_count;
} psplat_scene_report;

/* Frees the reports of the meshes, and zeroes report. */
void psplat_scene_report_free(psplat_scene_report *report);

/* Writes the total as psplat_report_json does. Where the scene has several meshes, each place gets
 * a "mesh", and "meshes" holds the index, the name and the report of each mesh that has splats. */
psplat_result psplat_scene_report_json(const psplat_scene *scene, const psplat_scene_report *report,
                                       char **text, size_t *size, psplat_error *error);

#endif

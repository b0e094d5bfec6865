/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * conversion.c - the start of a conversion: options become limits in the mesh's units, and the
 * surface is built.
 */
#include "select/conversion.h"

#include "appearance/alpha_mask.h"
#include "appearance/appearance.h"
#include "base/angle.h"
#include "base/vector.h"
#include "features/samples.h"
#include "features/surface.h"
#include "features/surface_build.h"
#include "fit/fit_context.h"
#include "mesh/distance.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"
#include "mesh/proxy.h"
#include "mesh/wire_width.h"
#include "select/selection.h"

#include <math.h>
#include <stdlib.h>

/* The greatest tolerance of a mesh that is a part of something larger, in % of its own diagonal. A
 * coarser one would leave nothing to be recognised, and save next to nothing. Chosen by hand. */
static const double coarsest_own_percent = 20;
/* The tolerance of a mesh of wires (mesh/wire_width.h) as a part of their width, and how many times
 * finer than what is asked for it is at most. With half of the width the outlines of a tube are a
 * quarter too wide, with a quarter of it 6 %. Chosen by hand. */
static const double wire_part = 0.25, most_wire_refinement = 8;
static const double default_crease_angle_degrees = 30;
/* The tolerance of colours at the second tolerance. Tuned on the textures of spot and Duck: all
 * that people would name is still there, with edges that are a little frayed. */
static const double default_color_tolerance_percent = 10, default_color_at_percent = 0.5;
/* The colour tolerance (parts of sRGB's range) up to which colours are linear whatever is painted.
 * They take three times the bytes of constant ones, and up to here they save as much in splats.
 * Tuned with bench_color on pictures and on smooth colours. */
static const double linear_color_tolerance = 0.06;

/* The next eight were chosen by hand. */
/* The part of the tolerance that proven fits may use; the rest is for rounding to single precision.
 */
static const double fitted_part = 0.99;
/* The part that drafts may use, which are measured at points only. Between these points they may
 * leave the surface a little more, and one that does has to shrink until its proof holds. */
static const double measured_part = 0.95;
/* The part of the tolerance of texture coordinates that fits may use; the rest is for points
 * between samples and for rounding. */
static const double texture_part = 0.8;
/* The part of a tolerance of normals that fits of curved splats may use. */
static const double curved_normal_part = 0.95;
/* How far creases may leave the plane of a splat, and how far a splat may reach over them, in parts
 * of the tolerance. They are smaller than 1, since creases are the lines that the eye follows. */
static const double crease_tolerance_part = 0.5;
static const double crease_slack_part = 0.3;
/* The finest sample spacing at a tolerance of 1 %, in % of the diagonal. Splats on a surface of
 * curvature radius R are about sqrt(R tolerance) wide, and some fifteen samples across one suffice.
 */
static const double spacing_percent = 0.5;
/* The altitude, in tolerances, below which slivers do not say where the surface faces. Splats may
 * leave the surface by that much sixteen times over. Chosen by hand. */
static const double sliver_tolerances = 1.0 / 16;
/* The longest edges of triangles along the edge of an alpha mask, in tolerances. */
static const double mask_step_tolerances = 2;

/* The greatest deviation of a proxy of the mesh, in tolerances, which fits lose. */
static const double proxy_part = 0.05;
/* The least number of triangles of a mesh that gets a proxy, and of the mesh for each of the proxy.
 * With four times fewer triangles the proxy takes longer than it saves. Chosen by hand. */
enum { LEAST_PROXIED = 20000 };
static const double least_proxy_gain = 8;

/* The diagonal below which a mesh is refused, in its units. The finest lengths of splats are some
 * 1e-5 of it, and files have them as floats, whose least normal one is 1.2e-38. */
static const double least_diagonal = 1e-32;

/* The number of samples beyond which a tolerance is refused, before they fill the memory. */
static const double most_samples = 16e6;

/* Returns the tolerance, in % of the diagonal, that makes splats as small as a tolerance of normals
 * does. Its factor was chosen by hand. */
static double normal_tolerance_percent(double degrees) {
    return 0.005 * degrees * degrees;
}

int psplat_conversion_interrupted(const psplat_convert_desc *desc, const char *stage,
                                  double fraction) {
    return desc->progress && desc->progress(desc->user, stage, fraction);
}

static double tolerance_percent(const psplat_convert_desc *desc) {
    return desc->tolerance_percent > 0 ? desc->tolerance_percent : PSPLAT_DEFAULT_TOLERANCE_PERCENT;
}

/* Returns the tolerance of colours in parts of sRGB's range; 0 where it is unbounded. The default
 * follows the tolerance of distances: who sees a surface from near enough to see finer distances
 * sees more of its texture too. */
static double color_tolerance(const psplat_convert_desc *desc, double percent) {
    double color_percent = desc->color_tolerance_percent;
    if (!(color_percent > 0))
        color_percent = default_color_tolerance_percent * sqrt(percent / default_color_at_percent);
    return color_percent < 100 ? color_percent / 100 : 0;
}

/* Returns whether colours have no gradients, given the tolerance of colours (0: unbounded), unless
 * psplat_color_field_choose finds them smooth. */
static int has_constant_colors(const psplat_convert_desc *desc, double tolerance) {
    if (desc->color_field != PSPLAT_COLOR_FIELD_CHOSEN)
        return desc->color_field == PSPLAT_COLOR_FIELD_CONSTANT;
    return !(tolerance > 0) || tolerance > linear_color_tolerance;
}

/* Sets diagonal, percent and tolerance. Returns the tolerance in % of the mesh's own diagonal. */
static double set_tolerance(psplat_conversion *c, double own) {
    double whole = c->desc->diagonal;
    c->diagonal = whole > 0 ? whole : own;
    c->percent = tolerance_percent(c->desc);
    if (whole > 0) c->percent = fmin(c->percent, coarsest_own_percent * own / whole);
    double promised = c->percent / 100 * c->diagonal;
    c->tolerance = promised;
    if (wire_part * c->wire_width < promised)
        c->tolerance = fmax(wire_part * c->wire_width, promised / most_wire_refinement);
    double part = c->tolerance < promised ? c->tolerance / promised : 1;
    return part * c->percent * (c->diagonal / own);
}

/* Returns the part of the tolerance of normals that fits may use. The normals of curved splats bend
 * away between the last samples and the rim. */
static double normal_part(const psplat_convert_desc *desc) {
    return desc->planar ? 1 : curved_normal_part;
}

/* Bounds texture coordinates where textures are kept: by a length, or by texels. */
static void set_texture_limits(psplat_conversion *c) {
    double texels = c->desc->texture_tolerance_texels;
    if (!psplat_surface_has_texcoords(&c->surface)) return;
    c->limits.texture_tolerance = texels > 0 ? 0 : texture_part * c->tolerance;
    c->limits.texture_tolerance_texels = texels > 0 ? texture_part * texels : 0;
}

/* Returns the mean length of a texel on the surface: the root of the area over that in texels;
 * HUGE_VAL where no textures are kept. */
static double texel_length(const psplat_surface *surface) {
    double area = 0, texels = 0;
    for (uint32_t t = 0; t < surface->mesh->triangle_count; ++t) {
        const psplat_kept_textures *kept = psplat_surface_kept_textures(surface, t);
        const float *slopes = surface->texcoord_slopes + 6 * (size_t)t;
        double changes[2][3], cross[3];
        if (!kept) continue;
        for (int k = 0; k < 2; ++k)
            for (int c = 0; c < 3; ++c) changes[k][c] = kept->texels[k] * (double)slopes[3 * k + c];
        cross3(cross, changes[0], changes[1]);
        area += surface->face_areas[t];
        texels += surface->face_areas[t] * length3(cross);
    }
    return texels > 0 ? sqrt(area / texels) : HUGE_VAL;
}

static psplat_result set_limits(psplat_conversion *c, psplat_error *error) {
    if (c->surface.diagonal < least_diagonal)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "the mesh is %g across; it must be at least %g, so that splats fit into "
                           "floats",
                           c->surface.diagonal, least_diagonal);
    double degrees = c->desc->normal_tolerance_degrees,
           effective_percent = set_tolerance(c, c->surface.diagonal);
    double color_limit = color_tolerance(c->desc, c->percent);
    if (degrees > 0) effective_percent = fmin(effective_percent, normal_tolerance_percent(degrees));
    if (c->desc->texture_tolerance_texels > 0) /* It makes splats as small as a distance does. */
        effective_percent =
            fmin(effective_percent, 100 * c->desc->texture_tolerance_texels *
                                        texel_length(&c->surface) / c->surface.diagonal);
    double spacing = spacing_percent / 100 * c->surface.diagonal * sqrt(effective_percent);
    c->finest = spacing;
    c->limits =
        (psplat_limits){.tolerance = fitted_part * c->tolerance,
                        .measured_tolerance = measured_part * c->tolerance,
                        .proven = 1,
                        .crease_tolerance = crease_tolerance_part * c->tolerance,
                        .crease_slack = crease_slack_part * c->tolerance,
                        .normal_tolerance = normal_part(c->desc) *
                                            c->desc->normal_tolerance_degrees * PSPLAT_DEGREE,
                        .constant_normals = c->desc->constant_normals,
                        .planar = c->desc->planar,
                        .color_tolerance = color_limit,
                        .constant_colors = has_constant_colors(c->desc, color_limit)};
    set_texture_limits(c);
    double expected = c->surface.area / (spacing * spacing);
    if (!(expected <= most_samples) && c->wire_width < HUGE_VAL) {
        c->wire_width = HUGE_VAL; /* Wires are not worth a refusal. */
        return set_limits(c, error);
    }
    if (!(expected <= most_samples))
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "a tolerance of %g %% needs %.3g million samples, more than %g million",
                           c->percent, expected / 1e6, most_samples / 1e6);
    c->limits.proxy = c->proxy;
    c->limits.proxy_deviation = c->proxy_deviation;
    if (!c->is_fitted) return PSPLAT_OK; /* The verification has a tree of its own. */
    c->limits.distance = c->distance =
        psplat_distance_create_connected(c->surface.mesh, c->surface.neighbors);
    if (c->distance) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "the mesh's tree does not fit into memory");
}

/* Builds the tree of a proxy with the triangles across its edges, which proofs walk over. */
static psplat_result build_proxy_tree(psplat_conversion *c, const psplat_mesh *proxy) {
    size_t edges = 3 * proxy->triangle_count, borders;
    uint32_t *across = malloc((edges + 1) * sizeof *across);
    psplat_result result =
        across ? psplat_edge_pairs(proxy, across, &borders) : PSPLAT_ERROR_MEMORY;
    for (size_t e = 0; e < edges && !result; ++e) {
        uint32_t pair = across[e];
        if (pair == PSPLAT_NONE || pair < e) continue;
        /* Triangles that run their common edge the same way disagree about their front. */
        int agree = proxy->triangles[e] != proxy->triangles[pair];
        across[e] = agree ? pair / 3 : PSPLAT_NONE;
        across[pair] = agree ? (uint32_t)(e / 3) : PSPLAT_NONE;
    }
    if (!result) c->proxy = psplat_distance_create_connected(proxy, across);
    free(across);
    return c->proxy ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

/* Simplifies a large mesh for the many distances that fits ask for, if that pays. This comes before
 * the surface is built, while there is memory. */
static psplat_result build_proxy(psplat_conversion *c, const psplat_mesh *mesh,
                                 psplat_error *error) {
    psplat_proxy proxy;
    if (!c->is_fitted || mesh->triangle_count < LEAST_PROXIED) return PSPLAT_OK;
    set_tolerance(c, psplat_mesh_diagonal(mesh));
    if (!(c->tolerance > 0)) return PSPLAT_OK;
    psplat_result result =
        psplat_proxy_build(mesh, proxy_part * c->tolerance, least_proxy_gain, &proxy);
    if (!result && proxy.mesh.triangle_count) {
        c->proxy_deviation = proxy.deviation;
        result = build_proxy_tree(c, &proxy.mesh);
    }
    psplat_proxy_free(&proxy);
    if (!result) return PSPLAT_OK;
    return psplat_fail(error, result, 0, "a simplified mesh does not fit into memory");
}

/* Replaces the mesh by what its alpha masks leave of it. The edge of a mask is cut in straight
 * pieces that are as long as the distance between two points within the promised tolerance of one.
 */
static psplat_result apply_alpha_mask(psplat_conversion *c, const psplat_mesh **mesh,
                                      psplat_error *error) {
    if (!psplat_alpha_mask_is_needed(*mesh)) return PSPLAT_OK;
    double whole = c->desc->diagonal > 0 ? c->desc->diagonal : psplat_mesh_diagonal(*mesh);
    double step = mask_step_tolerances * tolerance_percent(c->desc) / 100 * whole;
    psplat_result result = psplat_alpha_mask_cut(*mesh, step, &c->shown, error);
    *mesh = &c->shown;
    return result;
}

static psplat_result measure_wires(psplat_conversion *c, const psplat_mesh *mesh,
                                   psplat_error *error) {
    c->wire_width = HUGE_VAL;
    if (c->desc->has_coarse_wires) return PSPLAT_OK;
    psplat_result result = psplat_mesh_wire_width(mesh, &c->wire_width);
    if (!result) return PSPLAT_OK;
    return psplat_fail(error, result, 0, "the edges of the mesh do not fit into memory");
}

/* Builds the appearance before the surface, which ends splats where kept textures have borders. */
static psplat_result build_appearance(psplat_conversion *c, const psplat_mesh *mesh,
                                      psplat_error *error) {
    psplat_result result =
        psplat_appearance_build(mesh, 0, !c->desc->bake_textures, &c->appearance);
    if (!result) return PSPLAT_OK;
    return psplat_fail(error, result, 0, "the textures do not fit into memory");
}

/* Returns what bounds patches. Splats are not to end at tangent edges where they are flat, which
 * are off on the round side alike, and where without creases only borders bound them. */
static psplat_patch_bounds patch_bounds(psplat_conversion *c, const psplat_mesh *mesh) {
    const psplat_convert_desc *desc = c->desc;
    double degrees =
        desc->crease_angle_degrees > 0 ? desc->crease_angle_degrees : default_crease_angle_degrees;
    set_tolerance(c, psplat_mesh_diagonal(mesh));
    return (psplat_patch_bounds){.crease_angle =
                                     desc->no_creases ? PSPLAT_NO_CREASES : degrees * PSPLAT_DEGREE,
                                 .appearance = &c->appearance,
                                 .tolerance = desc->planar || desc->no_creases ? 0 : c->tolerance,
                                 .facet_tolerance = c->ends_at_facets ? c->tolerance : 0,
                                 .sliver_height = sliver_tolerances * c->tolerance};
}

static void set_owned(psplat_conversion *c) {
    for (int k = 0; k < 6 && c->desc->owned; ++k)
        c->owned[k] = c->desc->owned[k] - c->surface.mesh->origin[k % 3];
    if (c->desc->owned) c->surface.owned = c->owned;
}

psplat_result psplat_conversion_begin(psplat_conversion *c, const psplat_mesh *mesh,
                                      psplat_error *error) {
    const psplat_convert_desc *desc = c->desc;
    if (desc->effort < PSPLAT_EFFORT_NONE || desc->effort > PSPLAT_GREATEST_EFFORT)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "an effort of %d; %d is the greatest",
                           desc->effort, PSPLAT_GREATEST_EFFORT);
    if (psplat_conversion_interrupted(desc, "finding creases", 0))
        return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
    psplat_result result = apply_alpha_mask(c, &mesh, error);
    if (!result) result = measure_wires(c, mesh, error);
    if (!result) result = build_appearance(c, mesh, error);
    if (!result) result = build_proxy(c, mesh, error);
    if (!result) {
        const psplat_patch_bounds bounds = patch_bounds(c, mesh);
        result = psplat_surface_build_bounded(mesh, &bounds, &c->surface, error);
    }
    if (!result) result = set_limits(c, error);
    /* What is averaged over is no wider than what a colour may be off by. */
    c->appearance.diameter = fmin(c->finest, c->tolerance);
    set_owned(c);
    return result;
}

void psplat_conversion_free_fit(psplat_conversion *c) {
    psplat_selection_free(&c->selection);
    psplat_samples_free(&c->samples);
    psplat_hole_memory_free(&c->hole_memory);
    free(c->color_ranges);
    c->color_ranges = NULL;
    psplat_distance_destroy(c->distance);
    psplat_distance_destroy(c->proxy);
    c->distance = c->proxy = NULL;
}

void psplat_conversion_free(psplat_conversion *c) {
    psplat_conversion_free_fit(c);
    psplat_appearance_free(&c->appearance);
    psplat_surface_free(&c->surface);
    psplat_mesh_free(&c->shown);
}

psplat_fit_context psplat_conversion_context(const psplat_conversion *c) {
    return (psplat_fit_context){&c->surface, &c->samples, &c->limits, NULL};
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * convert.c - the whole conversion: surface, samples, selection, repair, report.
 */
#include "mask.h"
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

static const double degree = 3.141592653589793 / 180;
static const double default_tolerance_percent = 0.5;
/* Of a part of something larger, its own diagonal: a coarser tolerance would leave nothing to be
 * recognised, and gain next to nothing. */
static const double coarsest_part_percent = 20;
static const double default_crease_angle_degrees = 30;
/* Of spot's and Duck's textures all that people would name is there, with edges a little frayed. */
static const double default_color_tolerance_percent = 10;
/* Colours that change over a splat take three times the bytes. Up to this tolerance they save as
 * much in splats on pictures and on smooth colours alike (bench_color). */
static const double linear_color_tolerance = 0.06;

/* Part of the tolerance that fitting may use; the rest is for single precision. */
static const double fitted_part = 0.99;
/* Creases are the lines that the eye follows: what they may leave the surface by, and how far a
 * splat may reach over them, in parts of the tolerance. */
static const double crease_part = 0.5;
static const double crease_slack_part = 0.3;
/* Splats that leave the surface by less than this part count as flat: they may hide what lies
 * behind them by hardly more, so that faces do not shine through each other at their corners. */
static const double flat_part = 0.02;
/* Finest sample spacing in percent of the diagonal at a tolerance of 1 %: splats of a surface of
 * radius R are about sqrt(R tolerance) wide, and some fifteen samples across describe one. A
 * tolerance of normals asks for splats as small as a distance of so much would. */
static const double spacing_percent = 0.5;
static double normal_tolerance_percent(double degrees) {
    return 0.005 * degrees * degrees;
}
/* Edges of triangles along masks, in tolerances. */
static const double mask_steps = 2;
/* Beyond this a tolerance is refused, before the samples fill the memory. */
static const double most_samples = 16e6;
/* Rounds of improving for each effort, and moves in each for every splat: more candidates to choose
 * from gain more than more moves do. */
enum { DEFAULT_EFFORT = 2, EFFORTS = 10, MOVES = 5 };
static const int rounds_of_effort[EFFORTS] = {0, 1, 2, 3, 4, 6, 9, 13, 18, 25};

static const uint64_t improve_seed = 0x696d70726f766500u;
static const uint64_t verify_seed = 0x7665726966790000u;

static double tolerance_percent(const psplat_convert_desc *desc) {
    return desc->tolerance_percent > 0 ? desc->tolerance_percent : default_tolerance_percent;
}

/* Of colours in sRGB, 0 ... 1; 0: none. What is seen from near enough to tell distances of half the
 * default apart shows more of its texture too. */
static double color_tolerance(const psplat_convert_desc *desc, double percent) {
    double of_color = desc->color_tolerance_percent;
    if (!(of_color > 0))
        of_color = default_color_tolerance_percent * sqrt(percent / default_tolerance_percent);
    return of_color < 100 ? of_color / 100 : 0;
}

/* tolerance: of colours, 0: none. */
static int has_constant_colors(const psplat_convert_desc *desc, double tolerance) {
    if (desc->color_field != PSPLAT_COLOR_FIELD_CHOSEN)
        return desc->color_field == PSPLAT_COLOR_FIELD_CONSTANT;
    return !(tolerance > 0) || tolerance > linear_color_tolerance;
}

static int interrupted(const psplat_convert_desc *desc, const char *stage, double fraction) {
    return desc->progress && desc->progress(desc->user, stage, fraction);
}

int psplat_improving_rounds(const psplat_convert_desc *desc) {
    return rounds_of_effort[desc->effort > 0 ? desc->effort - 1 : DEFAULT_EFFORT];
}

/* What percentages are of, and the tolerance in them. Returns the tolerance in percent of the
 * mesh's own diagonal. */
static double set_tolerance(psplat_conversion *c) {
    double own = c->surface.diagonal, whole = c->desc->diagonal;
    c->diagonal = whole > 0 ? whole : own;
    c->percent = tolerance_percent(c->desc);
    if (whole > 0) c->percent = fmin(c->percent, coarsest_part_percent * own / whole);
    c->tolerance = c->percent / 100 * c->diagonal;
    return c->percent * (c->diagonal / own);
}

static psplat_result set_limits(psplat_conversion *c, psplat_error *error) {
    double degrees = c->desc->normal_tolerance_degrees, fine = set_tolerance(c);
    double of_color = color_tolerance(c->desc, c->percent);
    if (degrees > 0) fine = fmin(fine, normal_tolerance_percent(degrees));
    double spacing = spacing_percent / 100 * c->surface.diagonal * sqrt(fine);
    c->finest = spacing;
    c->limits = (psplat_limits){.tolerance = fitted_part * c->tolerance,
                                .crease_tolerance = crease_part * c->tolerance,
                                .crease_slack = crease_slack_part * c->tolerance,
                                .normal_tolerance = c->desc->normal_tolerance_degrees * degree,
                                .constant_normals = c->desc->constant_normals,
                                .color_tolerance = of_color,
                                .constant_colors = has_constant_colors(c->desc, of_color)};
    double expected = c->surface.area / (spacing * spacing);
    if (!(expected <= most_samples))
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "a tolerance of %g %% needs %.3g million samples, more than %g million",
                           c->percent, expected / 1e6, most_samples / 1e6);
    c->limits.distance = c->distance = psplat_distance_create(c->surface.mesh);
    if (c->distance) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "the mesh's tree does not fit into memory");
}

/* Greatest distance between two overlapping splats of one surface, along their normal. */
static float depth_tolerance(const psplat_conversion *c) {
    double deviation = 0;
    for (size_t i = 0; i < c->selection.count; ++i)
        deviation = fmax(deviation, c->selection.candidates[i].deviation);
    return (float)fmax(2 * deviation, 0.25 * c->tolerance);
}

static psplat_result store(psplat_conversion *c, psplat_error *error) {
    const psplat_mesh *mesh = c->surface.mesh;
    const psplat_storing storing = {.depth_tolerance = depth_tolerance(c),
                                    .flat_depth_tolerance = (float)(2 * flat_part * c->tolerance),
                                    .groups = mesh->appearances ? mesh->groups : NULL,
                                    .has_color = c->samples.colors != NULL,
                                    .has_finish = c->samples.colors || c->samples.finishes ||
                                                  c->samples.emissive};
    size_t materials = mesh->appearances ? mesh->appearance_count : 1;
    c->splats->materials = malloc((materials + 1) * sizeof *c->splats->materials);
    if (!c->splats->materials || psplat_store_splats(&c->selection, &storing, c->splats))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while storing splats");
    c->splats->material_count = materials;
    for (size_t i = 0; i < materials; ++i) {
        c->splats->materials[i] =
            mesh->appearances ? mesh->appearances[i].material : mesh->material;
        c->splats->materials[i].double_sided |= mesh->both_sides;
    }
    if (psplat_fold(c->splats))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while storing splats");
    psplat_precision_apply(c->splats);
    return PSPLAT_OK;
}

/* Grows candidates beside those taken, a random sample of each for every seed. */
static psplat_result grow_pool(psplat_conversion *c, uint64_t seed) {
    size_t count = 0;
    uint32_t *seeds = malloc((c->selection.count + 1) * sizeof *seeds);
    if (!seeds) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < c->selection.count; ++i) {
        const psplat_candidate *candidate = &c->selection.candidates[i];
        if (candidate->taken && candidate->covered_count)
            seeds[count++] =
                candidate->covered[psplat_random_next(&seed) % candidate->covered_count];
    }
    psplat_result result =
        psplat_selection_grow(&c->surface, &c->samples, &c->limits, seeds, count, &c->selection);
    free(seeds);
    return result;
}

static psplat_result improve(psplat_conversion *c, psplat_error *error) {
    int rounds = psplat_improving_rounds(c->desc);
    psplat_improvement what = {.samples = &c->samples, .focus = c->samples.count};
    psplat_result result = psplat_improve(&c->selection, &what);
    for (int round = 0; round < rounds && !result; ++round) {
        if (interrupted(c->desc, "improving", (double)round / rounds))
            return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
        what.seed = c->desc->seed + improve_seed + (uint64_t)round;
        what.moves = MOVES * psplat_selection_taken(&c->selection);
        what.axis = round % 3;
        result = grow_pool(c, what.seed);
        if (!result) result = psplat_relax(c);
        if (!result) result = psplat_improve(&c->selection, &what);
    }
    if (!result) return PSPLAT_OK;
    return psplat_fail(error, result, 0, "out of memory while improving the selection");
}

/* Moves the selection to the grid of the file, and closes what holes that leaves. */
static psplat_result quantise(psplat_conversion *c, psplat_error *error) {
    const psplat_improvement drop = {.samples = &c->samples, .focus = c->samples.count};
    c->splats->precision = psplat_precision_choose(c);
    if (!(c->splats->precision.unit > 0)) return PSPLAT_OK;
    c->limits.precision = &c->splats->precision;
    psplat_selection_settle(&c->selection);
    psplat_result result = psplat_repair_holes(c, error);
    if (!result && psplat_improve(&c->selection, &drop))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while rounding splats");
    return result;
}

static psplat_result select_splats(psplat_conversion *c, psplat_error *error) {
    psplat_result result =
        psplat_select_cover(&c->surface, &c->samples, &c->limits, c->desc, &c->selection, error);
    if (!result) result = improve(c, error);
    if (!result) result = psplat_repair_holes(c, error);
    if (!result) result = quantise(c, error);
    if (result) return result;
    psplat_selection_settle(&c->selection);
    if (psplat_join_lines(&c->surface, &c->limits, &c->selection))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while joining splats");
    if (psplat_tint(&c->samples, !c->limits.constant_colors, &c->selection))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while colouring splats");
    return store(c, error);
}

static void fill_splats(const psplat_conversion *c, const psplat_mesh *mesh) {
    c->splats->kernel =
        (psplat_kernel){PSPLAT_DEFAULT_KERNEL_SHARPNESS, PSPLAT_DEFAULT_KERNEL_EXPONENT};
    for (int k = 0; k < 3; ++k) c->splats->origin[k] = mesh->origin[k];
}

static void count_for_report(const psplat_conversion *c, psplat_report *report) {
    report->splats = c->splats->count;
    memset(report->splats_by_clip_lines, 0, sizeof report->splats_by_clip_lines);
    for (size_t i = 0; i < c->splats->run_count; ++i)
        report->splats_by_clip_lines[c->splats->runs[i].clip_lines] += c->splats->runs[i].count;
    report->triangles = c->surface.mesh->triangle_count;
    report->patches = c->surface.patch_count;
    report->crease_edges = c->surface.crease_edges;
    report->border_edges = c->surface.border_edges;
    report->samples = c->samples.count;
    report->diagonal = c->diagonal;
    report->tolerance_percent = c->percent;
}

static psplat_result verify(const psplat_conversion *c, psplat_report *report,
                            psplat_error *error) {
    if (interrupted(c->desc, "verifying", 0))
        return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
    const psplat_verification verification = {
        .surface = &c->surface,
        .splats = c->splats,
        .distance = c->distance,
        .tolerance_percent = c->percent,
        .diagonal = c->diagonal,
        .normal_tolerance_degrees = c->desc->normal_tolerance_degrees,
        .seed = c->desc->seed + verify_seed,
    };
    return psplat_verify(&verification, report, error);
}

/* The mesh without what its masks hide; straight pieces of a mask's edge are as long as may be
 * between points that lie within the tolerance of each other. */
static psplat_result show(psplat_conversion *c, const psplat_mesh **mesh, psplat_error *error) {
    if (!psplat_mask_is_needed(*mesh)) return PSPLAT_OK;
    double whole = c->desc->diagonal > 0 ? c->desc->diagonal : psplat_mask_diagonal(*mesh);
    double step = mask_steps * tolerance_percent(c->desc) / 100 * whole;
    psplat_result result = psplat_mask_cut(*mesh, step, &c->shown, error);
    *mesh = &c->shown;
    return result;
}

psplat_result psplat_conversion_begin(psplat_conversion *c, const psplat_mesh *mesh,
                                      psplat_error *error) {
    const psplat_convert_desc *desc = c->desc;
    double degrees =
        desc->crease_angle_degrees > 0 ? desc->crease_angle_degrees : default_crease_angle_degrees;
    if (interrupted(desc, "finding creases", 0))
        return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
    double crease_angle = desc->no_creases ? PSPLAT_NO_CREASES : degrees * degree;
    psplat_result result = show(c, &mesh, error);
    if (!result) result = psplat_surface_build(mesh, crease_angle, &c->surface, error);
    if (!result) result = set_limits(c, error);
    if (result) return result;
    c->surface.paint = &c->paint;
    if (!psplat_paint_build(mesh, c->finest, &c->paint)) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "the textures do not fit into memory");
}

static psplat_result run(psplat_conversion *c, const psplat_mesh *mesh, psplat_report *report,
                         psplat_error *error) {
    const psplat_convert_desc *desc = c->desc;
    psplat_result result = psplat_conversion_begin(c, mesh, error);
    if (result) return result;
    if (interrupted(desc, "sampling", 0))
        return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
    result = psplat_sample(c, error);
    if (!result) result = select_splats(c, error);
    if (result) return result;
    fill_splats(c, mesh);
    if (!report) return PSPLAT_OK;
    count_for_report(c, report);
    return desc->unverified ? PSPLAT_OK : verify(c, report, error);
}

void psplat_conversion_free(psplat_conversion *c) {
    psplat_selection_free(&c->selection);
    psplat_samples_free(&c->samples);
    psplat_distance_destroy(c->distance);
    psplat_paint_free(&c->paint);
    psplat_surface_free(&c->surface);
    psplat_mesh_free(&c->shown);
}

static const psplat_convert_desc defaults;

psplat_result psplat_convert(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                             psplat_splats *splats, psplat_report *report, psplat_error *error) {
    if (!mesh || !splats)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "mesh and splats must not be NULL");
    *splats = (psplat_splats){0};
    psplat_conversion c = {.desc = desc ? desc : &defaults, .splats = splats};
    psplat_result result = run(&c, mesh, report, error);
    psplat_conversion_free(&c);
    if (result) psplat_splats_free(splats);
    return result;
}

psplat_result psplat_convert_verify(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                    const psplat_splats *splats, psplat_report *report,
                                    psplat_error *error) {
    if (!mesh || !splats || !report)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "mesh, splats and report must not be NULL");
    psplat_splats measured = *splats; /* not changed, but conversions hold what they make */
    psplat_conversion c = {.desc = desc ? desc : &defaults, .splats = &measured};
    psplat_result result = psplat_conversion_begin(&c, mesh, error);
    if (!result) result = verify(&c, report, error);
    psplat_conversion_free(&c);
    return result;
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * convert.c - the whole conversion of a mesh: surface, samples, greedy cover, local search, filling
 * of holes, quantization, closing of seams, colours, and verification.
 */
#include "pipeline/convert.h"

#include "base/random.h"
#include "features/facet_edges.h"
#include "fit/candidate.h"
#include "fit/color_fit.h"
#include "fit/fit_context.h"
#include "fit/texture_candidates.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"
#include "finish/close_cracks.h"
#include "finish/close_rays.h"
#include "finish/close_seams.h"
#include "finish/cut_rims.h"
#include "select/color_field.h"
#include "select/conversion.h"
#include "finish/depth_tolerance.h"
#include "select/effort.h"
#include "select/fill_holes.h"
#include "select/greedy_cover.h"
#include "select/local_search.h"
#include "finish/mend_colors.h"
#include "finish/mend_creases.h"
#include "finish/mend_textures.h"
#include "finish/open_seams.h"
#include "finish/own_fields.h"
#include "select/precision.h"
#include "select/relax.h"
#include "select/sample_spacing.h"
#include "select/selection.h"
#include "select/sort_splats.h"
#include "finish/trim_splats.h"
#include "splats/hoist_constants.h"
#include "splats/quantize.h"
#include "splats/splats.h"
#include "verify/observations.h"
#include "verify/report.h"
#include "verify/verify.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The moves of the local search in a round, for each splat. More candidates to choose from gain
 * more than more moves do. Chosen by hand. */
enum { MOVES_PER_SPLAT = 5 };
/* The pool grows in the first of every so many rounds of the local search: candidates of relaxation
 * alone save as many splats a round, in half of the time. Chosen by hand. */
enum { GROWING_ROUNDS = 4 };
/* The sharpness of the blending kernel (spec 3.7). At a rim weights end with e^-4 = 0.018 instead
 * of the default's 0.14, so that rims do not show; of 2, 3, 4 and 6 it gave the greatest SSIM of
 * pictures of curved splats, with normals as good. */
static const float kernel_sharpness = 4;

/* The steps of positions that are tried where the wanted one breaks a promise, in parts of it; 0
 * stands for floats. Chosen by hand. */
enum { FINER_GRIDS = 2 };
static const double finer_parts[FINER_GRIDS] = {0.25, 0};

/* The splats for each facet of a mesh from which on splats end at the edges of facets, and at most
 * so many where they do. These have three lines or four and take up to twice the bytes of others.
 * Both are of the greedy cover, which improving makes smaller, and were chosen by hand. */
static const double most_splats_per_facet = 1.5, most_by_facets = 4;

/* Offsets of the user's seed, which give the local search and the verification random numbers of
 * their own. They are the ASCII letters of "improve" and "verify". */
static const uint64_t improve_seed = 0x696d70726f766500u;
static const uint64_t verify_seed = 0x7665726966790000u;

static psplat_result store_splats(psplat_conversion *c, psplat_error *error) {
    const psplat_mesh *mesh = c->surface.mesh;
    psplat_sort_desc storing = {.groups = mesh->source_materials ? mesh->groups : NULL,
                                .kept = c->appearance.kept,
                                .has_color = c->samples.colors != NULL,
                                .has_finish = c->samples.colors || c->samples.finishes ||
                                              c->samples.emissive};
    size_t materials = mesh->source_materials ? mesh->source_material_count : 1;
    c->splats->materials = malloc((materials + 1) * sizeof *c->splats->materials);
    if (!c->splats->materials ||
        psplat_depth_tolerances_choose(c, &storing.depth_tolerance,
                                       &storing.flat_depth_tolerance) ||
        psplat_sort_splats(&c->selection, &storing, c->splats))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while storing splats");
    c->splats->material_count = materials;
    for (size_t i = 0; i < materials; ++i) {
        c->splats->materials[i] =
            mesh->source_materials ? mesh->source_materials[i].material : mesh->material;
        c->splats->materials[i].double_sided |= psplat_mesh_shows_both_sides(mesh, i);
        psplat_appearance_settle_textures(&c->appearance, i, &c->splats->materials[i]);
    }
    if (psplat_hoist_constants(c->splats))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while storing splats");
    psplat_precision_settle_texcoords(c);
    psplat_round_to_precision(c->splats);
    return PSPLAT_OK;
}

/* Grows a candidate around a random sample of each taken one. */
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
    const psplat_fit_context context = psplat_conversion_context(c);
    psplat_result result = psplat_selection_grow(&context, seeds, count, &c->selection);
    free(seeds);
    return result;
}

/* Replaces the selection by a smaller one, in rounds that relax it and search locally, and some of
 * which grow the pool before. */
static psplat_result improve(psplat_conversion *c, psplat_error *error) {
    int rounds = psplat_effort_of(c->desc).search_rounds;
    psplat_local_search_desc what = {
        .samples = &c->samples, .focus = c->samples.count, .surface = &c->surface};
    psplat_result result = psplat_local_search(&c->selection, &what);
    for (int round = 0; round < rounds && !result; ++round) {
        if (psplat_conversion_interrupted(c->desc, "improving", (double)round / rounds))
            return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
        what.seed = c->desc->seed + improve_seed + (uint64_t)round;
        what.moves = MOVES_PER_SPLAT * psplat_selection_taken(&c->selection);
        what.axis = round % 3;
        if (round % GROWING_ROUNDS == 0) result = grow_pool(c, what.seed);
        if (!result) result = psplat_relax(c);
        if (!result) result = psplat_local_search(&c->selection, &what);
    }
    if (!result) return PSPLAT_OK;
    return psplat_fail(error, result, 0, "%s while improving the selection",
                       psplat_result_text(result));
}

/* Moves the selection to the grid of the file, and fills the holes that this opens. */
static psplat_result quantize(psplat_conversion *c, psplat_error *error) {
    const psplat_local_search_desc drop = {
        .samples = &c->samples, .focus = c->samples.count, .surface = &c->surface};
    c->splats->precision = psplat_precision_choose(c);
    if (!(c->splats->precision.unit > 0)) return PSPLAT_OK;
    c->limits.precision = &c->splats->precision;
    /* What laps over a tangent edge is to keep the shape of its own side (test_tangent_edges). */
    c->limits.mesh_pull = c->surface.tangent_edges ? 0 : psplat_coarseness(c);
    psplat_selection_drop_untaken(&c->selection);
    psplat_result result = psplat_fill_holes(c, error);
    if (!result && psplat_local_search(&c->selection, &drop))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while rounding splats");
    return result;
}

/* Draws the samples, which tell whether colours are linear. Splats of such colours are larger and
 * need fewer. */
static psplat_result draw_samples(psplat_conversion *c, psplat_error *error) {
    int had_constant = c->limits.constant_colors;
    psplat_result result = psplat_draw_samples_for_limits(c, error);
    if (result) return result;
    if (psplat_color_field_choose(c))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while sampling");
    return had_constant && !c->limits.constant_colors ? psplat_draw_samples_for_limits(c, error)
                                                      : PSPLAT_OK;
}

/* Begins a conversion, up to the samples that splats are to cover. */
static psplat_result begin_covering(psplat_conversion *c, const psplat_mesh *mesh,
                                    psplat_error *error) {
    psplat_result result = psplat_conversion_begin(c, mesh, error);
    if (result) return result;
    if (psplat_conversion_interrupted(c->desc, "sampling", 0))
        return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
    return draw_samples(c, error);
}

/* Counts the facets that splats may end at; 0 where they may not. */
static psplat_result count_facets(const psplat_conversion *c, size_t *facets, psplat_error *error) {
    if (c->desc->no_creases || !psplat_facets_count(&c->surface, c->tolerance, facets))
        return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while sampling");
}

/* Covers all samples of a mesh. Where that takes many more splats than the mesh has facets, they
 * end at the facets' edges, unless that takes as many. */
static psplat_result cover_samples(psplat_conversion *c, const psplat_mesh *mesh,
                                   psplat_error *error) {
    enum { OVER_ALL, BY_FACETS, OVER_ALL_AFTER_ALL, WAYS };
    const psplat_conversion before = *c;
    psplat_result result = PSPLAT_OK;
    size_t facets = 0;
    int is_whole = 0;
    for (int way = OVER_ALL; way < WAYS && !is_whole && !result; ++way) {
        if (way != OVER_ALL) psplat_conversion_free(c), *c = before;
        c->ends_at_facets = way == BY_FACETS;
        result = begin_covering(c, mesh, error);
        if (!result && way == OVER_ALL) result = count_facets(c, &facets, error);
        const psplat_fit_context context = psplat_conversion_context(c);
        const double share = way == BY_FACETS ? most_by_facets : most_splats_per_facet;
        size_t most =
            facets && way != OVER_ALL_AFTER_ALL ? (size_t)(share * (double)facets) : SIZE_MAX;
        if (!result)
            result =
                psplat_greedy_cover_by(&context, c->desc, most, &c->selection, &is_whole, error);
    }
    return result;
}

/* Covers the surface by splats of floats: all of a conversion that does not depend on the grid. */
static psplat_result cover(psplat_conversion *c, const psplat_mesh *mesh, psplat_error *error) {
    psplat_result result = cover_samples(c, mesh, error);
    if (!result) result = improve(c, error);
    return result ? result : psplat_fill_holes(c, error);
}

/* Returns a copy of the regions of all candidates; NULL when out of memory. */
static psplat_region *copy_regions(const psplat_selection *selection) {
    psplat_region *regions = malloc((selection->count + 1) * sizeof *regions);
    for (size_t i = 0; regions && i < selection->count; ++i)
        regions[i] = selection->candidates[i].region;
    return regions;
}

/* Moves the lines of splats out to those beside them, where they keep the promises of creases and
 * of textures, and lets splats go on beyond borders of charts, where they keep that of creases. */
static psplat_result join(psplat_conversion *c) {
    const psplat_fit_context context = psplat_conversion_context(c);
    psplat_region *fitted = copy_regions(&c->selection), *closed = NULL;
    psplat_result result =
        fitted ? psplat_close_seams(&context, &c->selection) : PSPLAT_ERROR_MEMORY;
    if (!result) result = psplat_close_cracks(c);
    if (!result) result = psplat_take_back_crossings(c, fitted);
    if (!result) result = psplat_take_back_slides(c, fitted);
    if (!result && c->surface.chart_border_edges) {
        closed = copy_regions(&c->selection);
        result = closed ? psplat_open_seams(&context, &c->kernel, fitted, &c->selection)
                        : PSPLAT_ERROR_MEMORY;
        if (!result) result = psplat_take_back_crossings(c, closed);
    }
    free(fitted);
    free(closed);
    return result;
}

/* Makes the splats of the file from those that cover the surface. */
static psplat_result complete(psplat_conversion *c, psplat_error *error) {
    const psplat_fit_context context = psplat_conversion_context(c);
    psplat_result result = quantize(c, error);
    if (result) return result;
    psplat_selection_drop_untaken(&c->selection);
    if (!c->selection.count)
        return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "%s",
                           c->desc->owned ? "nothing of the mesh in its block has an area"
                                          : "nothing of the mesh has an area");
    result = psplat_mend_colors(c, 0, error);
    if (!result) result = psplat_mend_textures(c, 0, error);
    if (!result) result = psplat_close_rays(c, error);
    if (!result) result = psplat_trim_splats(c, error);
    if (!result) result = psplat_mend_colors(c, 1, error);
    if (!result) result = psplat_mend_textures(c, 1, error);
    if (!result) result = psplat_mend_creases(c, error);
    if (result) return result;
    if (join(c))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while joining splats");
    if (psplat_cut_rims(c))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while cutting rims");
    if (psplat_fit_colors(&c->samples, !c->limits.constant_colors, c->selection.candidates,
                          c->selection.count))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while colouring splats");
    if (psplat_fit_texcoords(&context, c->selection.candidates, c->selection.count))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while texturing splats");
    if (psplat_fit_own_fields(c))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while shading splats");
    return store_splats(c, error);
}

static void fill_splats(const psplat_conversion *c) {
    c->splats->kernel = c->kernel;
    for (int k = 0; k < 3; ++k) c->splats->origin[k] = c->surface.mesh->origin[k];
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
    report->chart_border_edges = c->surface.chart_border_edges;
    report->tangent_edges = c->surface.tangent_edges;
    report->facet_edges = c->surface.facet_edges;
    report->samples = c->samples.count;
    report->diagonal = c->diagonal;
    report->tolerance_percent = c->percent;
}

static psplat_result verify(const psplat_conversion *c, psplat_report *report,
                            psplat_observations *observations, psplat_error *error) {
    if (psplat_conversion_interrupted(c->desc, "verifying", 0))
        return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
    /* The fit's own tree would hide its faults. */
    psplat_distance *distance = psplat_distance_create_check(c->surface.mesh);
    if (!distance)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory to verify distances");
    const psplat_verification verification = {
        .surface = &c->surface,
        .splats = c->splats,
        .distance = distance,
        .tolerance_percent = c->percent,
        .diagonal = c->diagonal,
        .normal_tolerance_degrees = c->desc->normal_tolerance_degrees,
        .texture_tolerance_texels = c->desc->texture_tolerance_texels,
        .color_tolerance_percent = 100 * c->limits.color_tolerance,
        .seed = c->desc->seed + verify_seed,
        .observations = observations,
    };
    psplat_result result = psplat_verify(&verification, report, error);
    psplat_distance_destroy(distance);
    return result;
}

static psplat_result convert(psplat_conversion *c, const psplat_mesh *mesh, psplat_report *report,
                             psplat_observations *observations, psplat_error *error) {
    psplat_result result = cover(c, mesh, error);
    if (!result) result = complete(c, error);
    if (result) return result;
    fill_splats(c);
    if (!report) return PSPLAT_OK;
    count_for_report(c, report);
    psplat_conversion_free_fit(
        c); /* The verification has a tree of its own, as large as all that. */
    return c->desc->unverified ? PSPLAT_OK : verify(c, report, observations, error);
}

static const psplat_convert_desc defaults;

static psplat_conversion begin_conversion(const psplat_convert_desc *desc, psplat_splats *splats) {
    *splats = (psplat_splats){0};
    return (psplat_conversion){.desc = desc,
                               .splats = splats,
                               .is_fitted = 1,
                               .kernel = {kernel_sharpness, PSPLAT_DEFAULT_KERNEL_EXPONENT}};
}

static psplat_result convert_once(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                  psplat_splats *splats, psplat_report *report,
                                  psplat_observations *observations, psplat_error *error) {
    psplat_conversion c = begin_conversion(desc, splats);
    psplat_result result = convert(&c, mesh, report, observations, error);
    psplat_conversion_free(&c);
    if (result) psplat_splats_free(splats);
    return result;
}

/* ---- drafts ---------------------------------------------------------------------------------- */

struct psplat_draft {
    psplat_convert_desc desc;
    psplat_conversion conversion; /* as it was when the surface was covered */
    psplat_selection covering;    /* a copy of its selection, which it has no more */
    size_t sample_count;
    psplat_limits limits;
    psplat_splats splats; /* what the covering stored; of no use to anyone else */
};

psplat_result psplat_draft_create(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                  psplat_draft **draft, psplat_error *error) {
    psplat_draft *d = calloc(1, sizeof *d);
    *draft = NULL;
    if (!d) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a conversion");
    d->desc = desc ? *desc : defaults;
    d->conversion = begin_conversion(&d->desc, &d->splats);
    psplat_result result = cover(&d->conversion, mesh, error);
    if (result) {
        psplat_draft_destroy(d);
        return result;
    }
    psplat_selection_drop_untaken(&d->conversion.selection);
    d->covering = d->conversion.selection;
    d->conversion.selection = (psplat_selection){0};
    d->sample_count = d->conversion.samples.count;
    d->limits = d->conversion.limits;
    *draft = d;
    return PSPLAT_OK;
}

void psplat_draft_destroy(psplat_draft *draft) {
    if (!draft) return;
    psplat_conversion_free(&draft->conversion);
    psplat_selection_free(&draft->covering);
    psplat_splats_free(&draft->splats);
    free(draft);
}

/* Undoes what completing the draft has changed. */
static void restore(psplat_draft *draft) {
    psplat_conversion *c = &draft->conversion;
    psplat_selection_free(&c->selection);
    psplat_samples_truncate(&c->samples, draft->sample_count);
    psplat_hole_memory_free(&c->hole_memory); /* It only spares a search what it knows already. */
    free(c->color_ranges);
    c->color_ranges = NULL;
    c->limits = draft->limits;
    c->desc = &draft->desc;
    c->splats = &draft->splats;
}

/* Completes a draft on the grid of a desc, and leaves the draft as it was. */
static psplat_result complete_draft(psplat_draft *draft, const psplat_convert_desc *desc,
                                    psplat_splats *splats, psplat_report *report,
                                    psplat_error *error) {
    psplat_conversion *c = &draft->conversion;
    *splats = (psplat_splats){0};
    c->desc = desc;
    c->splats = splats;
    psplat_result result = psplat_selection_copy(&draft->covering, &c->selection);
    if (result) psplat_fail(error, result, 0, "no memory for the selection");
    if (!result) result = complete(c, error);
    if (!result) fill_splats(c);
    if (!result && report) {
        count_for_report(c, report);
        if (!desc->unverified) result = verify(c, report, NULL, error);
    }
    restore(draft);
    if (result) psplat_splats_free(splats);
    return result;
}

/* ---- grids ----------------------------------------------------------------------------------- */

/* What is converted: a mesh, or a draft of it where that is not NULL. */
typedef struct original {
    const psplat_mesh *mesh;
    psplat_draft *draft;
} original;

static psplat_result convert_original(const original *from, const psplat_convert_desc *desc,
                                      psplat_splats *splats, psplat_report *report,
                                      psplat_observations *observations, psplat_error *error) {
    return from->draft ? complete_draft(from->draft, desc, splats, report, error)
                       : convert_once(from->mesh, desc, splats, report, observations, error);
}

/* Returns the number of samples, splats and crease edges at which promises are broken that a finer
 * grid may keep. It hardly moves textures, which are fitted on the grid, nor what colours show. */
static size_t broken_count(const psplat_report *report) {
    size_t count = 0;
    for (int k = 0; k < PSPLAT_PROMISE_COUNT; ++k)
        if (k != PSPLAT_PROMISE_TEXTURE && k != PSPLAT_PROMISE_COLOR)
            count += report->promises[k].broken;
    return count;
}

/* Converts again on finer grids, and at last with floats, while promises are broken. What breaks
 * fewest stays, the coarser one of equals. */
static psplat_result refine_grid(const original *from, const psplat_convert_desc *desc,
                                 psplat_splats *splats, psplat_report *report,
                                 psplat_observations *observations, psplat_error *error) {
    for (int i = 0; i < FINER_GRIDS && broken_count(report); ++i) {
        psplat_convert_desc finer = *desc;
        psplat_splats other;
        psplat_report other_report = *report;
        psplat_observations seen = {0};
        finer.precision *= finer_parts[i];
        psplat_result result = convert_original(from, &finer, &other, &other_report,
                                                observations ? &seen : NULL, error);
        if (result) {
            psplat_observations_free(&seen);
            return result;
        }
        if (broken_count(&other_report) < broken_count(report)) {
            psplat_splats swap = *splats;
            *splats = other, other = swap;
            *report = other_report;
            if (observations) {
                psplat_observations_free(observations);
                *observations = seen, seen = (psplat_observations){0};
            }
        }
        psplat_observations_free(&seen);
        psplat_splats_free(&other);
    }
    return PSPLAT_OK;
}

/* Converts, and on finer grids where promises are broken. */
static psplat_result convert_and_refine(const original *from, const psplat_convert_desc *desc,
                                        psplat_splats *splats, psplat_report *report,
                                        psplat_observations *observations, psplat_error *error) {
    psplat_result result = convert_original(from, desc, splats, report, observations, error);
    if (result || !report || desc->unverified || !(splats->precision.unit > 0)) return result;
    result = refine_grid(from, desc, splats, report, observations, error);
    if (result) psplat_splats_free(splats);
    return result;
}

psplat_result psplat_convert_observed(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                      psplat_splats *splats, psplat_report *report,
                                      psplat_observations *observations, psplat_error *error) {
    const original from = {.mesh = mesh};
    if (!mesh || !splats)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "mesh and splats must not be NULL");
    return convert_and_refine(&from, desc ? desc : &defaults, splats, report, observations, error);
}

psplat_result psplat_draft_convert(psplat_draft *draft, double precision, psplat_splats *splats,
                                   psplat_report *report, psplat_error *error) {
    const original from = {.draft = draft};
    psplat_convert_desc desc = draft->desc;
    desc.precision = precision;
    return convert_and_refine(&from, &desc, splats, report, NULL, error);
}

psplat_result psplat_convert(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                             psplat_splats *splats, psplat_report *report, psplat_error *error) {
    return psplat_convert_observed(mesh, desc, splats, report, NULL, error);
}

psplat_result psplat_convert_verify(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                    const psplat_splats *splats, psplat_report *report,
                                    psplat_error *error) {
    if (!mesh || !splats || !report)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "mesh, splats and report must not be NULL");
    psplat_splats measured = *splats; /* They stay unchanged, but c.splats is not const. */
    psplat_conversion c = {.desc = desc ? desc : &defaults, .splats = &measured};
    psplat_result result = psplat_conversion_begin(&c, mesh, error);
    if (!result) result = verify(&c, report, NULL, error);
    psplat_conversion_free(&c);
    return result;
}

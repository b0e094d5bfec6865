/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * budget.c - the search for the smallest tolerance whose splats keep a budget of splats or bytes.
 *
 * Both numbers grow about as a power of 1 / tolerance, with an exponent between 1 / 2 (long
 * cylinders) and 1 (surfaces curved in both directions). So the search is a secant method in
 * logarithms. Its steps stay inside the bracket between the finest tolerance that fitted and the
 * coarsest that did not. The numbers are not quite monotone: the result is the last tolerance that
 * was found to fit.
 */
#include "pipeline/budget.h"

#include "export/glb_writer.h"
#include "pipeline/convert_scene.h"
#include "pipeline/schedule.h"
#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All of these were chosen by hand. */
/* The number of conversions after which a search that found a fit ends, and the one that progress
 * is estimated with. */
enum { MOST_CONVERSIONS = 10, USUAL_CONVERSIONS = 5 };
/* The first tolerance tried, in % of the diagonal. */
static const double first_percent = 1;
/* The share of the budget whose use ends the search, and the share that each step aims at. */
static const double good_share = 0.97, aimed_share = 0.985;
/* The greatest step without a bracket, and the width of the bracket at which the search ends, as
 * ratios of tolerances. */
static const double greatest_step_ratio = 10, least_bracket_ratio = 1.01;
/* The step, as a ratio of tolerances, after which a model of unchanged cost counts as flat: a finer
 * tolerance would gain nothing. Over a ratio of 8 wires may be fitted to one part of their width
 * (select/conversion.c). */
static const double flat_step_ratio = 9;
/* The least distance of a secant step from the bracket's ends, as a part of the bracket. */
static const double least_bracket_part = 0.1;

/* A tolerance that was tried: the logarithms of it, in %, and of its cost as a part of the budget.
 */
typedef struct attempt {
    double tolerance, cost;
    int tried;
} attempt;

/* The state of the search. */

typedef struct search {
    const psplat_scene *scene;
    const psplat_convert_desc *desc;
    const psplat_budget *budget;
    psplat_splats *best, *tried; /* by mesh of the scene */
    psplat_scene_report best_report;
    double best_percent;
    attempt fits, exceeds; /* the ends of the bracket */
    attempt coarser;       /* the attempt that fitted before `fits` */
    double coarsest;       /* log of the greatest tolerance, in % */
    size_t needed;         /* splats or bytes of the last attempt */
    int conversions;
    double done; /* the progress shown last */
} search;

/* ---- one conversion -------------------------------------------------------------------------- */

/* Shows the search as one stage, which takes about the usual number of conversions. */
static int show_progress(void *user, const char *stage, double fraction) {
    search *s = user;
    double part = psplat_schedule_done(stage, fraction), conversions = s->conversions;
    double expected = fmax(USUAL_CONVERSIONS, conversions + 2);
    if (part >= 0) s->done = fmax(s->done, (conversions + part) / expected);
    return s->desc->progress(s->desc->user, "searching", s->done);
}

static size_t count_splats(const search *s, const psplat_splats *splats) {
    size_t count = 0;
    for (size_t i = 0; i < s->scene->mesh_count; ++i) count += splats[i].count;
    return count;
}

/* Finds the cost of the splats tried as a part of the budget, above 1 where they exceed it. */
static psplat_result measure_cost(search *s, double *cost, psplat_error *error) {
    const psplat_budget *budget = s->budget;
    s->needed = count_splats(s, s->tried);
    *cost = budget->splats ? (double)s->needed / (double)budget->splats : 0;
    if (!budget->bytes || *cost > 1) return PSPLAT_OK;
    uint8_t *data = NULL;
    size_t size = 0;
    psplat_result result =
        psplat_scene_write(s->scene, s->tried, budget->written, &data, &size, error);
    free(data);
    if (result) return result;
    double bytes = (double)size / (double)budget->bytes;
    if (bytes > 1) s->needed = size;
    *cost = fmax(*cost, bytes);
    return PSPLAT_OK;
}

static void keep_best(search *s, psplat_scene_report *report, double percent) {
    psplat_scene_report old = s->best_report;
    psplat_scene_splats_free(s->scene, s->best);
    memcpy(s->best, s->tried, s->scene->mesh_count * sizeof *s->best);
    memset(s->tried, 0, s->scene->mesh_count * sizeof *s->tried);
    s->best_report = *report;
    s->best_percent = percent;
    *report = old;
}

/* Converts with exp(tolerance) percent and moves an end of the bracket there. */
static psplat_result attempt_tolerance(search *s, double tolerance, psplat_error *error) {
    psplat_convert_desc desc = *s->desc;
    psplat_scene_report report = {0};
    double cost = 0;
    desc.tolerance_percent = exp(tolerance);
    desc.unverified = 1;
    if (desc.progress) desc.progress = show_progress, desc.user = s;
    psplat_result result = psplat_scene_convert(s->scene, &desc, s->tried, &report, error);
    ++s->conversions;
    if (!result) result = measure_cost(s, &cost, error);
    if (!result && cost <= 1) {
        s->coarser = s->fits;
        s->fits = (attempt){tolerance, log(cost), 1};
        keep_best(s, &report, desc.tolerance_percent);
    } else if (!result) {
        s->exceeds = (attempt){tolerance, log(cost), 1};
    } else if (result == PSPLAT_ERROR_RANGE && s->fits.tried) {
        /* The tolerance is too fine to be sampled: it exceeds the budget by an unknown factor. */
        s->exceeds = (attempt){tolerance, HUGE_VAL, 1};
        result = PSPLAT_OK;
    }
    psplat_scene_splats_free(s->scene, s->tried);
    psplat_scene_report_free(&report);
    return result;
}

/* ---- the next tolerance ---------------------------------------------------------------------- */

/* Returns whether the cost did not change with the last step that fitted. */
static int is_unchanged(const search *s) {
    return s->coarser.tried && s->coarser.cost == s->fits.cost;
}

/* Steps from an attempt as if cost were proportional to 1 / tolerance, by at most the greatest
 * step. Steps double with each conversion, since costs change less where a model is flat. */
static double extrapolate(const search *s, const attempt *from) {
    double step = ldexp(from->cost - log(aimed_share), s->conversions - 1),
           most = log(greatest_step_ratio);
    if (from == &s->fits && is_unchanged(s)) step = -log(flat_step_ratio);
    double next = from->tolerance + fmax(fmin(step, most), -most);
    return fmin(fmax(next, log(PSPLAT_BUDGET_FINEST)), s->coarsest);
}

/* Returns a tolerance inside the bracket: the secant's, or the middle where a cost is unknown. */
static double interpolate(const search *s) {
    const attempt *f = &s->fits, *e = &s->exceeds;
    double t = isfinite(e->cost) ? (log(aimed_share) - f->cost) / (e->cost - f->cost) : 0.5;
    t = fmin(fmax(t, least_bracket_part), 1 - least_bracket_part);
    return f->tolerance + t * (e->tolerance - f->tolerance);
}

/* Chooses the next tolerance. Returns 0 where the search is at its end. */
static int choose_next(const search *s, double *next) {
    const attempt *f = &s->fits, *e = &s->exceeds;
    if (s->conversions >= MOST_CONVERSIONS && f->tried) return 0;
    if (f->tried && f->cost >= log(good_share)) return 0;
    if (f->tried && e->tried) {
        *next = interpolate(s);
        return f->tolerance - e->tolerance > log(least_bracket_ratio);
    }
    double finer = s->coarser.tolerance - f->tolerance;
    if (is_unchanged(s) && finer >= log(flat_step_ratio) * (1 - 1e-9)) return 0;
    const attempt *from = f->tried ? f : e;
    *next = extrapolate(s, from);
    return *next != from->tolerance;
}

/* ---- the search ------------------------------------------------------------------------------ */

static psplat_result run(search *s, psplat_error *error) {
    double next = fmin(log(first_percent), s->coarsest);
    psplat_result result = PSPLAT_OK;
    do {
        result = attempt_tolerance(s, next, error);
    } while (!result && choose_next(s, &next));
    return result;
}

static psplat_result fail_budget(const search *s, size_t *needed, psplat_error *error) {
    const psplat_budget *budget = s->budget;
    int is_splats = budget->splats && s->needed > budget->splats;
    *needed = s->needed;
    return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                       "a tolerance of %.3g %% takes %zu %s, more than the budget of %zu",
                       exp(s->exceeds.tolerance), s->needed, is_splats ? "splats" : "bytes",
                       is_splats ? budget->splats : budget->bytes);
}

/* Verifies the best splats where a report is wanted, and moves both to the caller. */
static psplat_result finish(search *s, psplat_splats *splats, psplat_scene_report *report,
                            psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    psplat_convert_desc desc = *s->desc;
    desc.tolerance_percent = s->best_percent;
    if (report) result = psplat_scene_verify(s->scene, &desc, s->best, &s->best_report, error);
    if (result) return result;
    memcpy(splats, s->best, s->scene->mesh_count * sizeof *splats);
    memset(s->best, 0, s->scene->mesh_count * sizeof *s->best);
    if (!report) return PSPLAT_OK;
    *report = s->best_report;
    s->best_report = (psplat_scene_report){0};
    return PSPLAT_OK;
}

psplat_result psplat_scene_convert_budget(const psplat_scene *scene,
                                          const psplat_convert_desc *desc,
                                          const psplat_budget *budget, psplat_splats *splats,
                                          psplat_scene_report *report, size_t *needed,
                                          psplat_error *error) {
    static const psplat_convert_desc defaults;
    if (!scene || !budget || !splats || !needed || (!budget->splats && !budget->bytes))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "scene, budget, splats or needed are NULL, or the budget is empty");
    *needed = 0;
    if (report) *report = (psplat_scene_report){0};
    search s = {.scene = scene, .desc = desc ? desc : &defaults, .budget = budget};
    double coarsest = s.desc->tolerance_percent;
    s.coarsest = log(coarsest > 0 ? coarsest : PSPLAT_BUDGET_COARSEST);
    s.best = calloc(scene->mesh_count + 1, sizeof *s.best);
    s.tried = calloc(scene->mesh_count + 1, sizeof *s.tried);
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (s.best && s.tried)
        result = run(&s, error);
    else
        psplat_fail(error, result, 0, "out of memory for %zu meshes", scene->mesh_count);
    if (!result)
        result = s.fits.tried ? finish(&s, splats, report, error) : fail_budget(&s, needed, error);
    psplat_scene_splats_free(scene, s.best);
    psplat_scene_report_free(&s.best_report);
    free(s.best);
    free(s.tried);
    return result;
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * budget.c - the smallest tolerance whose splats keep a budget of splats or bytes.
 *
 * Both grow about as a power of 1 / tolerance, between 1 / 2 (long cylinders) and 1 (surfaces bent
 * both ways), so the search is a secant in logarithms, kept inside the bracket of the coarsest
 * tolerance that was too fine and the finest that fitted. The counts are not quite monotone: the
 * best is the finest tolerance seen to fit.
 */
#include "scenes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CONVERSIONS = 10, USUAL_CONVERSIONS = 5 };

static const double first_percent = 1;
/* Using this part of the budget is good enough, and aiming a little higher gets there. */
static const double enough = 0.97, aim = 0.985;
/* Greatest step without a bracket, and least width of the bracket, as ratios of tolerances. */
static const double greatest_step = 8, least_width = 1.01;
/* A model that costs the same after this step is flat: finer tolerances gain nothing. */
static const double flat_step = 4;
/* A secant may not come closer to the bracket's ends than this part of it. */
static const double least_part = 0.1;

/* A tolerance that was tried: logarithms of it and of what it costs as a part of the budget. */
typedef struct attempt {
    double tolerance, cost;
    int tried;
} attempt;

typedef struct search {
    const psplat_scene *scene;
    const psplat_convert_desc *desc;
    const psplat_budget *budget;
    psplat_splats *best, *tried; /* by mesh of the scene */
    psplat_scene_report best_report;
    double best_percent;
    attempt fits, exceeds; /* the ends of the bracket */
    attempt coarser;       /* fitted before fits did */
    double coarsest;       /* log of percent */
    size_t needed;         /* of the budget, by the attempt that exceeds it */
    int conversions;
    double done; /* progress shown last */
} search;

/* ---- one conversion ---------------------------------------------------------------------------
 */

/* The whole search is one stage, of about as many conversions as it usually takes. */
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

/* What the splats take of the budget: a ratio, above 1 where it is exceeded. */
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
        /* Finer than what can be sampled: as if it cost too much, by an unknown factor. */
        s->exceeds = (attempt){tolerance, HUGE_VAL, 1};
        result = PSPLAT_OK;
    }
    psplat_scene_splats_free(s->scene, s->tried);
    psplat_scene_report_free(&report);
    return result;
}

/* ---- where to try next --------------------------------------------------------------------------
 */

/* Cost did not change with the last step that fitted. */
static int is_unchanged(const search *s) {
    return s->coarser.tried && s->coarser.cost == s->fits.cost;
}

/* From an attempt along cost ~ 1 / tolerance, by at most the greatest step; farther each time, for
 * where the model is flat it costs less. */
static double extrapolate(const search *s, const attempt *from) {
    double step = ldexp(from->cost - log(aim), s->conversions - 1), most = log(greatest_step);
    if (from == &s->fits && is_unchanged(s)) step = -log(flat_step);
    double next = from->tolerance + fmax(fmin(step, most), -most);
    return fmin(fmax(next, log(PSPLAT_BUDGET_FINEST)), s->coarsest);
}

static double interpolate(const search *s) {
    const attempt *f = &s->fits, *e = &s->exceeds;
    double t = isfinite(e->cost) ? (log(aim) - f->cost) / (e->cost - f->cost) : 0.5;
    t = fmin(fmax(t, least_part), 1 - least_part);
    return f->tolerance + t * (e->tolerance - f->tolerance);
}

/* 0 where the search is at its end. */
static int choose_next(const search *s, double *next) {
    const attempt *f = &s->fits, *e = &s->exceeds;
    if (s->conversions >= MOST_CONVERSIONS && f->tried) return 0;
    if (f->tried && f->cost >= log(enough)) return 0;
    if (f->tried && e->tried) {
        *next = interpolate(s);
        return f->tolerance - e->tolerance > log(least_width);
    }
    double finer = s->coarser.tolerance - f->tolerance;
    if (is_unchanged(s) && finer >= log(flat_step) * (1 - 1e-9)) return 0;
    const attempt *from = f->tried ? f : e;
    *next = extrapolate(s, from);
    return *next != from->tolerance;
}

/* ---- the search
 * ---------------------------------------------------------------------------------- */

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

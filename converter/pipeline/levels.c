/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * levels.c - makes levels of detail: conversion after conversion with greater tolerances, of which
 * each mesh keeps those that have fewer splats.
 */
#include "pipeline/levels.h"

#include "appearance/alpha_mask.h"
#include "export/mesh_levels.h"
#include "measure/outline.h"
#include "mesh/mesh.h"
#include "pipeline/convert_scene.h"
#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"
#include "verify/verify.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A level is kept where it has at most this part of the splats of the one before. Chosen by hand:
 * flat faces take as many splats at any tolerance. */
static const double most_splats_kept = 0.8;
/* The greatest tolerance, in %: as much as a mesh of its own size can have. */
static const double coarsest_percent = 20;
static const double step_ratio = 2;
/* The step of alpha masks, in % of the diagonal, as where pictures are compared. */
static const double mask_step_percent = 0.25;

/* ---- errors ---------------------------------------------------------------------------------- */

static psplat_result measure_outline(const psplat_mesh *mesh, const psplat_splats *splats,
                                     double *outline, psplat_error *error) {
    psplat_mesh shown = {0};
    if (!psplat_alpha_mask_is_needed(mesh))
        return psplat_outline_measure(mesh, splats, outline, error);
    double step = mask_step_percent / 100 * psplat_mesh_diagonal(mesh);
    psplat_result result = psplat_alpha_mask_cut(mesh, step, &shown, error);
    if (!result) result = psplat_outline_measure(&shown, splats, outline, error);
    psplat_mesh_free(&shown);
    return result;
}

/* Fills the errors of a level, which are at least those of the one before. */
static psplat_result measure_level(const psplat_mesh *mesh, const psplat_splats *splats,
                                   const psplat_report *report,
                                   const psplat_mesh_level_splats *before,
                                   psplat_mesh_level_splats *level, psplat_error *error) {
    level->tolerance = report->tolerance_percent;
    level->distance = psplat_verified_distance(report);
    level->normal = report->rms_normal_degrees;
    psplat_result result = measure_outline(mesh, splats, &level->outline, error);
    if (result || !before) return result;
    level->distance = fmax(level->distance, before->distance);
    level->normal = fmax(level->normal, before->normal);
    level->outline = fmax(level->outline, before->outline);
    return PSPLAT_OK;
}

/* ---- levels of all meshes -------------------------------------------------------------------- */

typedef struct level_work {
    const psplat_scene *scene;
    psplat_convert_desc desc;
    const psplat_levels_desc *wanted;
    const psplat_splats *finest;
    psplat_mesh_levels *levels;
    size_t made; /* levels of the mesh that has the most */
} level_work;

static size_t coarsest_count(const level_work *w, size_t mesh) {
    const psplat_mesh_levels *levels = &w->levels[mesh];
    return levels->count > 1 ? levels->list[levels->count - 1].splats.count : w->finest[mesh].count;
}

static psplat_result add_finest(level_work *w, const psplat_scene_report *report,
                                psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < w->scene->mesh_count && !result; ++i) {
        psplat_mesh_levels *levels = &w->levels[i];
        if (!w->finest[i].count) continue;
        levels->list = calloc(PSPLAT_MOST_LEVELS, sizeof *levels->list);
        if (!levels->list) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
        levels->count = 1;
        result = measure_level(&w->scene->meshes[i].mesh, &w->finest[i], &report->meshes[i], NULL,
                               levels->list, error);
    }
    return result;
}

/* Keeps what one conversion made of the meshes for which it pays. */
static psplat_result keep(level_work *w, psplat_splats *tried, const psplat_scene_report *report,
                          psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < w->scene->mesh_count && !result; ++i) {
        psplat_mesh_levels *levels = &w->levels[i];
        double most = most_splats_kept * (double)coarsest_count(w, i);
        if (!tried[i].count || (double)tried[i].count > most || levels->count == w->wanted->most)
            continue;
        psplat_mesh_level_splats *level = &levels->list[levels->count];
        result = measure_level(&w->scene->meshes[i].mesh, &tried[i], &report->meshes[i], level - 1,
                               level, error);
        level->splats = tried[i];
        tried[i] = (psplat_splats){.splats = NULL};
        ++levels->count;
        if (levels->count > w->made) w->made = levels->count;
    }
    return result;
}

static psplat_result attempt(level_work *w, psplat_error *error) {
    psplat_scene_report report = {0};
    psplat_splats *tried = calloc(w->scene->mesh_count + 1, sizeof *tried);
    if (!tried) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    psplat_result result = psplat_scene_convert(w->scene, &w->desc, tried, &report, error);
    if (!result) result = keep(w, tried, &report, error);
    psplat_scene_splats_free(w->scene, tried);
    psplat_scene_report_free(&report);
    free(tried);
    return result;
}

/* Returns whether a mesh has enough splats for a coarser level. */
static int is_worthwhile(const level_work *w) {
    for (size_t i = 0; i < w->scene->mesh_count; ++i)
        if (coarsest_count(w, i) > PSPLAT_LEAST_LEVEL_SPLATS) return 1;
    return 0;
}

static psplat_result make_all(level_work *w, psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; !result && w->made < w->wanted->most; ++i) {
        double given = i < PSPLAT_MOST_LEVELS ? w->wanted->tolerances[i] : 0;
        if (!(given > 0) && w->wanted->tolerances[0] > 0) break;
        if (!(given > 0) && !is_worthwhile(w)) break;
        double next = given > 0 ? given : step_ratio * w->desc.tolerance_percent;
        if (next > coarsest_percent) break;
        w->desc.tolerance_percent = next;
        w->desc.has_coarse_wires = 1;
        result = attempt(w, error);
    }
    return result;
}

psplat_result psplat_scene_levels(const psplat_scene *scene, const psplat_convert_desc *desc,
                                  const psplat_levels_desc *wanted, const psplat_splats *splats,
                                  const psplat_scene_report *report, psplat_mesh_levels **levels,
                                  psplat_error *error) {
    *levels = NULL;
    if (wanted->most < 2 || wanted->most > PSPLAT_MOST_LEVELS)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "levels must be 2 to %d",
                           PSPLAT_MOST_LEVELS);
    level_work w = {.scene = scene, .desc = *desc, .wanted = wanted, .finest = splats, .made = 1};
    w.desc.tolerance_percent = report->total.tolerance_percent;
    w.desc.unverified = 0;
    w.levels = calloc(scene->mesh_count + 1, sizeof *w.levels);
    if (!w.levels) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    psplat_result result = add_finest(&w, report, error);
    if (!result) result = make_all(&w, error);
    if (result)
        psplat_mesh_levels_free(scene, w.levels);
    else
        *levels = w.levels;
    return result;
}

void psplat_mesh_levels_free(const psplat_scene *scene, psplat_mesh_levels *levels) {
    for (size_t i = 0; levels && i < scene->mesh_count; ++i) {
        for (size_t k = 0; k < levels[i].count; ++k) psplat_splats_free(&levels[i].list[k].splats);
        free(levels[i].list);
    }
    free(levels);
}

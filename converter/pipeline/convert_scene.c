/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * convert_scene.c - the conversion of all meshes of a scene to splats, and their common report.
 *
 * Each mesh is converted once, however many nodes show it. The promises hold where a mesh is shown:
 * a node that stretches a mesh stretches its errors. So the tolerance of a mesh is the scene's
 * divided by the greatest stretch.
 */
#include "pipeline/convert_scene.h"

#include "appearance/appearance.h"
#include "base/path.h"
#include "material/source_materials.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "pipeline/schedule.h"
#include "scene/instances.h"
#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- one report of many ---------------------------------------------------------------------- */

static void add_counts(psplat_report *total, const psplat_report *part) {
    total->splats += part->splats;
    for (int i = 0; i <= PSPLAT_MAX_CLIP_LINES; ++i)
        total->splats_by_clip_lines[i] += part->splats_by_clip_lines[i];
    total->triangles += part->triangles;
    total->patches += part->patches;
    total->crease_edges += part->crease_edges;
    total->border_edges += part->border_edges;
    total->chart_border_edges += part->chart_border_edges;
    total->tangent_edges += part->tangent_edges;
    total->facet_edges += part->facet_edges;
    total->samples += part->samples;
    total->uncovered_samples += part->uncovered_samples;
}

/* Returns the root mean square over the samples of both, and that of the one exactly where the
 * other has no samples. */
static double join_rms(double a, size_t samples_of_a, double b, size_t samples_of_b) {
    if (!samples_of_a) return b;
    double count = (double)samples_of_a + (double)samples_of_b;
    return count > 0 ? sqrt((a * a * (double)samples_of_a + b * b * (double)samples_of_b) / count)
                     : 0;
}

static void raise_to(double *total, double part) {
    *total = fmax(*total, part);
}

static void add_errors(psplat_report *total, const psplat_report *part) {
    size_t before = total->verification_samples, more = part->verification_samples;
    raise_to(&total->max_distance_percent, part->max_distance_percent);
    raise_to(&total->max_distance_surface_percent, part->max_distance_surface_percent);
    raise_to(&total->max_distance_splats_percent, part->max_distance_splats_percent);
    raise_to(&total->bound_distance_splats_percent, part->bound_distance_splats_percent);
    raise_to(&total->unproven_surface_percent, part->unproven_surface_percent);
    total->unproven_splats += part->unproven_splats;
    raise_to(&total->p95_normal_degrees, part->p95_normal_degrees);
    raise_to(&total->p95_normal_constant_degrees, part->p95_normal_constant_degrees);
    raise_to(&total->max_normal_degrees, part->max_normal_degrees);
    total->rms_distance_percent =
        join_rms(total->rms_distance_percent, before, part->rms_distance_percent, more);
    total->rms_normal_degrees =
        join_rms(total->rms_normal_degrees, before, part->rms_normal_degrees, more);
    total->rms_normal_constant_degrees = join_rms(total->rms_normal_constant_degrees, before,
                                                  part->rms_normal_constant_degrees, more);
    raise_to(&total->max_texture_slide_percent, part->max_texture_slide_percent);
    raise_to(&total->p95_texture_slide_percent, part->p95_texture_slide_percent);
    raise_to(&total->max_texture_slide_texels, part->max_texture_slide_texels);
    raise_to(&total->p95_texture_slide_texels, part->p95_texture_slide_texels);
    raise_to(&total->mirrored_texture_percent, part->mirrored_texture_percent);
    raise_to(&total->foreign_texture_percent, part->foreign_texture_percent);
    raise_to(&total->texture_tolerance_texels, part->texture_tolerance_texels);
    raise_to(&total->max_look_percent, part->max_look_percent);
    raise_to(&total->p95_look_percent, part->p95_look_percent);
    raise_to(&total->look_beyond_percent, part->look_beyond_percent);
    raise_to(&total->p95_color_percent, part->p95_color_percent);
    raise_to(&total->p95_color_constant_percent, part->p95_color_constant_percent);
    total->rms_color_percent =
        join_rms(total->rms_color_percent, before, part->rms_color_percent, more);
    total->rms_color_constant_percent =
        join_rms(total->rms_color_constant_percent, before, part->rms_color_constant_percent, more);
    total->verification_samples += more;
}

static void add_promises(psplat_report *total, const psplat_report *part) {
    for (int i = 0; i < PSPLAT_PROMISE_COUNT; ++i) {
        raise_to(&total->promises[i].limit, part->promises[i].limit);
        raise_to(&total->promises[i].worst, part->promises[i].worst);
        total->promises[i].broken += part->promises[i].broken;
    }
}

/* Inserts a place in the order of promises, and for each promise the worst first. Where the report
 * is full, the last place is dropped. */
static void add_place(psplat_report *total, const psplat_place *place, uint32_t mesh) {
    size_t at = total->place_count;
    while (at > 0 && (total->places[at - 1].promise > place->promise ||
                      (total->places[at - 1].promise == place->promise &&
                       total->places[at - 1].value < place->value)))
        --at;
    if (at == PSPLAT_MOST_PLACES) return;
    size_t kept =
        total->place_count < PSPLAT_MOST_PLACES ? total->place_count++ : PSPLAT_MOST_PLACES - 1;
    memmove(total->places + at + 1, total->places + at, (kept - at) * sizeof *total->places);
    total->places[at] = *place;
    total->places[at].mesh = mesh;
}

static void join_reports(const psplat_convert_desc *desc, double diagonal,
                         psplat_scene_report *report) {
    psplat_report *total = &report->total;
    *total = (psplat_report){.diagonal = diagonal};
    for (uint32_t i = 0; i < report->mesh_count; ++i) {
        psplat_report *part = &report->meshes[i];
        if (!part->splats) continue;
        add_counts(total, part);
        add_errors(total, part);
        add_promises(total, part);
        for (size_t k = 0; k < part->place_count; ++k) {
            part->places[k].mesh = i;
            add_place(total, &part->places[k], i);
        }
        raise_to(&total->tolerance_percent, part->tolerance_percent);
        if (!(diagonal > 0)) raise_to(&total->diagonal, part->diagonal);
    }
    /* The tolerances of meshes that are small beside the scene are smaller than the scene's. */
    if (desc->tolerance_percent > 0) total->tolerance_percent = desc->tolerance_percent;
}

void psplat_scene_report_free(psplat_scene_report *report) {
    free(report->meshes);
    *report = (psplat_scene_report){0};
}

/* ---- one mesh after another ------------------------------------------------------------------ */

/* The state of a conversion or a verification of all meshes. */
typedef struct scene_work {
    const psplat_scene *scene;
    psplat_convert_desc desc; /* of the current mesh */
    const psplat_convert_desc *scene_desc;
    double *lengths; /* per mesh: the length that its percentages are of, or 0: its own diagonal */
    double diagonal; /* of the shown scene; 0 where it shows nothing */
    double *shares;  /* per mesh: its share of the time */
    double before, now; /* the shares of the meshes before, and of the current one */
} scene_work;

/* Shows all meshes as one stage. */
static int show_progress(void *user, const char *stage, double fraction) {
    scene_work *w = user;
    double part = psplat_schedule_done(stage, fraction);
    return w->scene_desc->progress(w->scene_desc->user, "converting meshes",
                                   w->before + fmax(part, 0) * w->now);
}

static size_t count_meshes(const psplat_scene *scene) {
    size_t count = 0;
    for (size_t i = 0; i < scene->mesh_count; ++i)
        count += scene->meshes[i].mesh.triangle_count > 0;
    return count;
}

/* Estimates the share of the time of each mesh: it grows with the number of triangles, on top of
 * what a conversion of any mesh takes, which is worth 1000 triangles. */
static void share_time(scene_work *w) {
    static const double least = 1000;
    double sum = 0;
    for (size_t i = 0; i < w->scene->mesh_count; ++i) {
        double triangles = (double)w->scene->meshes[i].mesh.triangle_count;
        w->shares[i] = triangles > 0 ? least + triangles : 0;
        sum += w->shares[i];
    }
    for (size_t i = 0; i < w->scene->mesh_count; ++i) w->shares[i] /= sum;
}

static psplat_result begin(scene_work *w, const psplat_scene *scene,
                           const psplat_convert_desc *desc, psplat_error *error) {
    static const psplat_convert_desc defaults;
    *w = (scene_work){.scene = scene, .scene_desc = desc ? desc : &defaults};
    w->lengths = malloc((scene->mesh_count + 1) * sizeof *w->lengths);
    w->shares = malloc((scene->mesh_count + 1) * sizeof *w->shares);
    if (!w->lengths || !w->shares)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for %zu meshes",
                           scene->mesh_count);
    w->desc = *w->scene_desc;
    if (w->desc.progress && count_meshes(scene) > 1) {
        w->desc.progress = show_progress;
        w->desc.user = w;
    }
    share_time(w);
    return psplat_scene_lengths(scene, w->lengths, &w->diagonal, error);
}

static void end(scene_work *w) {
    free(w->lengths);
    free(w->shares);
}

static void select_mesh(scene_work *w, size_t mesh) {
    w->before += w->now;
    w->now = w->shares[mesh];
    w->desc.diagonal = w->lengths[mesh];
}

/* Puts the mesh's name before the error's text, where there are several meshes. */
static psplat_result name_mesh(const scene_work *w, size_t mesh, psplat_error *error) {
    if (!error || count_meshes(w->scene) < 2) return error ? error->code : PSPLAT_OK;
    char label[PSPLAT_SHOWN_PATH];
    psplat_error cause = *error;
    psplat_scene_label(w->scene, mesh, label);
    return psplat_fail(error, cause.code, cause.offset, "%s: %s", label, cause.text);
}

/* Returns how many textures of the materials of a mesh use another set of coordinates than the one
 * that it keeps. */
static size_t count_other_sets(const psplat_mesh *mesh) {
    uint32_t kept = psplat_appearance_set_to_keep(mesh);
    size_t count = 0, materials = mesh->source_material_count;
    uint8_t *used = kept == PSPLAT_NONE ? NULL : calloc(materials + 1, 1);
    for (size_t t = 0; used && t < mesh->triangle_count; ++t)
        if (!mesh->groups || mesh->groups[t] < materials)
            used[mesh->groups ? mesh->groups[t] : 0] = 1;
    for (size_t i = 0; used && i < materials; ++i)
        for (psplat_texture_slot slot = 0; used[i] && slot < PSPLAT_TEXTURE_SLOTS; ++slot) {
            const psplat_source_material *m = &mesh->source_materials[i];
            count += psplat_appearance_may_keep(mesh, m, slot) &&
                     psplat_source_texture(m, slot)->texcoord != kept;
        }
    free(used);
    return count;
}

void psplat_scene_warn_of_textures(psplat_scene *scene) {
    size_t count = 0;
    for (size_t i = 0; i < scene->mesh_count; ++i)
        count += count_other_sets(&scene->meshes[i].mesh);
    if (count)
        psplat_scene_warn(
            scene, "%zu textures use a second set of texture coordinates: they are baked", count);
}

void psplat_scene_splats_free(const psplat_scene *scene, psplat_splats *splats) {
    for (size_t i = 0; splats && i < scene->mesh_count; ++i) psplat_splats_free(&splats[i]);
}

static psplat_result convert_meshes(scene_work *w, psplat_splats *splats, psplat_report *reports,
                                    psplat_error *error) {
    for (size_t i = 0; i < w->scene->mesh_count; ++i) {
        const psplat_mesh *mesh = &w->scene->meshes[i].mesh;
        if (!mesh->triangle_count) continue;
        select_mesh(w, i);
        psplat_result result =
            psplat_convert(mesh, &w->desc, &splats[i], reports ? &reports[i] : NULL, error);
        if (result) {
            name_mesh(w, i, error);
            return result;
        }
    }
    return PSPLAT_OK;
}

psplat_result psplat_scene_convert(const psplat_scene *scene, const psplat_convert_desc *desc,
                                   psplat_splats *splats, psplat_scene_report *report,
                                   psplat_error *error) {
    scene_work w;
    if (!scene || !splats)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "scene and splats must not be NULL");
    if (report) {
        *report = (psplat_scene_report){.mesh_count = scene->mesh_count};
        report->meshes = calloc(scene->mesh_count + 1, sizeof *report->meshes);
        if (!report->meshes)
            return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for the report");
    }
    psplat_result result = begin(&w, scene, desc, error);
    if (!result) result = convert_meshes(&w, splats, report ? report->meshes : NULL, error);
    if (!result && report) join_reports(w.scene_desc, w.diagonal, report);
    if (result) psplat_scene_splats_free(scene, splats);
    if (result && report) psplat_scene_report_free(report);
    end(&w);
    return result;
}

psplat_result psplat_scene_verify(const psplat_scene *scene, const psplat_convert_desc *desc,
                                  const psplat_splats *splats, psplat_scene_report *report,
                                  psplat_error *error) {
    scene_work w;
    psplat_result result = begin(&w, scene, desc, error);
    for (size_t i = 0; i < scene->mesh_count && !result; ++i) {
        if (!splats[i].count) continue;
        select_mesh(&w, i);
        result = psplat_convert_verify(&scene->meshes[i].mesh, &w.desc, &splats[i],
                                       &report->meshes[i], error);
        if (result) name_mesh(&w, i, error);
    }
    if (!result) join_reports(w.scene_desc, w.diagonal, report);
    end(&w);
    return result;
}

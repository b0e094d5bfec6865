/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * report.c - the report as JSON.
 *
 * The keys are the names of psplat_report's fields. They must not change, since programs read them.
 */
#include "verify/report.h"

#include "base/json_writer.h"
#include "scene/scene.h"

/* Adds the values that only a conversion as a whole has, not one of its meshes. */
static void add_cost(psplat_writer *json, const psplat_report *report) {
    psplat_writer_count(json, "bytes", report->bytes);
    psplat_writer_number(json, "seconds", report->seconds);
    psplat_writer_count(json, "peak_memory_bytes", report->peak_memory_bytes);
}

static void add_splats(psplat_writer *json, const psplat_report *report) {
    double by_clip_lines[PSPLAT_MAX_CLIP_LINES + 1];
    for (int i = 0; i <= PSPLAT_MAX_CLIP_LINES; ++i)
        by_clip_lines[i] = (double)report->splats_by_clip_lines[i];
    psplat_writer_count(json, "splats", report->splats);
    psplat_writer_numbers(json, "splats_by_clip_lines", by_clip_lines, PSPLAT_MAX_CLIP_LINES + 1);
}

static void add_surface(psplat_writer *json, const psplat_report *report) {
    psplat_writer_count(json, "triangles", report->triangles);
    psplat_writer_count(json, "patches", report->patches);
    psplat_writer_count(json, "crease_edges", report->crease_edges);
    psplat_writer_count(json, "border_edges", report->border_edges);
    psplat_writer_count(json, "chart_border_edges", report->chart_border_edges);
    psplat_writer_count(json, "tangent_edges", report->tangent_edges);
    psplat_writer_count(json, "facet_edges", report->facet_edges);
    psplat_writer_count(json, "samples", report->samples);
    psplat_writer_count(json, "verification_samples", report->verification_samples);
    psplat_writer_number(json, "diagonal", report->diagonal);
}

static void add_errors(psplat_writer *json, const psplat_report *report) {
    psplat_writer_number(json, "tolerance_percent", report->tolerance_percent);
    psplat_writer_number(json, "max_distance_percent", report->max_distance_percent);
    psplat_writer_number(json, "max_distance_surface_percent",
                         report->max_distance_surface_percent);
    psplat_writer_number(json, "max_distance_splats_percent", report->max_distance_splats_percent);
    psplat_writer_number(json, "bound_distance_splats_percent",
                         report->bound_distance_splats_percent);
    psplat_writer_count(json, "unproven_splats", report->unproven_splats);
    psplat_writer_number(json, "unproven_surface_percent", report->unproven_surface_percent);
    psplat_writer_number(json, "rms_distance_percent", report->rms_distance_percent);
    psplat_writer_number(json, "rms_normal_degrees", report->rms_normal_degrees);
    psplat_writer_number(json, "p95_normal_degrees", report->p95_normal_degrees);
    psplat_writer_number(json, "rms_normal_constant_degrees", report->rms_normal_constant_degrees);
    psplat_writer_number(json, "p95_normal_constant_degrees", report->p95_normal_constant_degrees);
    psplat_writer_number(json, "max_normal_degrees", report->max_normal_degrees);
    psplat_writer_number(json, "rms_color_percent", report->rms_color_percent);
    psplat_writer_number(json, "p95_color_percent", report->p95_color_percent);
    psplat_writer_number(json, "rms_color_constant_percent", report->rms_color_constant_percent);
    psplat_writer_number(json, "p95_color_constant_percent", report->p95_color_constant_percent);
    psplat_writer_number(json, "max_look_percent", report->max_look_percent);
    psplat_writer_number(json, "p95_look_percent", report->p95_look_percent);
    psplat_writer_number(json, "look_beyond_percent", report->look_beyond_percent);
    psplat_writer_count(json, "uncovered_samples", report->uncovered_samples);
}

static void add_textures(psplat_writer *json, const psplat_report *report) {
    psplat_writer_number(json, "max_texture_slide_percent", report->max_texture_slide_percent);
    psplat_writer_number(json, "p95_texture_slide_percent", report->p95_texture_slide_percent);
    psplat_writer_number(json, "max_texture_slide_texels", report->max_texture_slide_texels);
    psplat_writer_number(json, "p95_texture_slide_texels", report->p95_texture_slide_texels);
    psplat_writer_number(json, "mirrored_texture_percent", report->mirrored_texture_percent);
    psplat_writer_number(json, "foreign_texture_percent", report->foreign_texture_percent);
    psplat_writer_number(json, "texture_tolerance_texels", report->texture_tolerance_texels);
}

static const char *const promise_names[PSPLAT_PROMISE_COUNT] = {
    [PSPLAT_PROMISE_COVERAGE] = "coverage", [PSPLAT_PROMISE_DISTANCE] = "distance",
    [PSPLAT_PROMISE_NORMAL] = "normal",     [PSPLAT_PROMISE_CREASE] = "crease",
    [PSPLAT_PROMISE_TEXTURE] = "texture",   [PSPLAT_PROMISE_COLOR] = "color",
};

/* Adds how each promise was kept. One that was not given has no limit and cannot be broken. */
static void add_promises(psplat_writer *json, const psplat_report *report) {
    psplat_writer_boolean(json, "kept", psplat_report_broken(report) == PSPLAT_PROMISE_COUNT);
    psplat_writer_open(json, "promises", '{');
    for (int i = 0; i < PSPLAT_PROMISE_COUNT; ++i) {
        const psplat_kept *kept = &report->promises[i];
        psplat_writer_open(json, promise_names[i], '{');
        psplat_writer_boolean(json, "given", kept->limit > 0);
        psplat_writer_boolean(json, "kept", !kept->broken);
        psplat_writer_number(json, "limit", kept->limit);
        psplat_writer_number(json, "worst", kept->worst);
        psplat_writer_count(json, "broken", kept->broken);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, '}');
}

static void add_places(psplat_writer *json, const psplat_report *report, int several) {
    psplat_writer_open(json, "places", '[');
    for (size_t i = 0; i < report->place_count; ++i) {
        const psplat_place *place = &report->places[i];
        psplat_writer_open(json, NULL, '{');
        psplat_writer_string(json, "promise", promise_names[place->promise]);
        if (several) psplat_writer_count(json, "mesh", place->mesh);
        psplat_writer_numbers(json, "position", place->position, 3);
        psplat_writer_number(json, "value", place->value);
        psplat_writer_number(json, "limit", report->promises[place->promise].limit);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

/* Adds all but the counts of splats and the cost. several: 1 where each place names its mesh. */
static void add_report(psplat_writer *json, const psplat_report *report, int several) {
    add_surface(json, report);
    add_errors(json, report);
    add_textures(json, report);
    add_promises(json, report);
    add_places(json, report, several);
}

static void add_meshes(psplat_writer *json, const psplat_scene *scene,
                       const psplat_scene_report *report) {
    psplat_writer_open(json, "meshes", '[');
    for (size_t i = 0; i < report->mesh_count; ++i) {
        if (!report->meshes[i].splats) continue;
        psplat_writer_open(json, NULL, '{');
        psplat_writer_count(json, "mesh", i);
        if (scene->meshes[i].name) psplat_writer_string(json, "name", scene->meshes[i].name);
        add_splats(json, &report->meshes[i]);
        add_report(json, &report->meshes[i], 0);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

static psplat_result finish(psplat_writer *json, char **text, size_t *size, psplat_error *error) {
    if (!psplat_writer_finish(json))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the report");
    *text = json->text;
    *size = json->size;
    return PSPLAT_OK;
}

psplat_result psplat_report_json(const psplat_report *report, char **text, size_t *size,
                                 psplat_error *error) {
    psplat_writer json = {0};
    psplat_writer_open(&json, NULL, '{');
    add_splats(&json, report);
    add_cost(&json, report);
    add_report(&json, report, 0);
    psplat_writer_close(&json, '}');
    return finish(&json, text, size, error);
}

psplat_result psplat_scene_report_json(const psplat_scene *scene, const psplat_scene_report *report,
                                       char **text, size_t *size, psplat_error *error) {
    int several = scene->mesh_count > 1;
    psplat_writer json = {0};
    psplat_writer_open(&json, NULL, '{');
    add_splats(&json, &report->total);
    add_cost(&json, &report->total);
    add_report(&json, &report->total, several);
    if (several) add_meshes(&json, scene, report);
    psplat_writer_close(&json, '}');
    return finish(&json, text, size, error);
}

psplat_promise psplat_report_broken(const psplat_report *report) {
    return report->place_count ? report->places[0].promise : PSPLAT_PROMISE_COUNT;
}

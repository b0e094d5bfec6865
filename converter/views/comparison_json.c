/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * comparison_json.c - the results of a comparison as JSON.
 */
#include "views/comparison_json.h"

#include "base/json_writer.h"
#include "compare/rays.h"
#include "compare/shape_errors.h"
#include "compare/statistics.h"
#include "views/image_metrics.h"
#include "views/picture_views.h"

#include <stdio.h>

/* Writes name_max_unit, name_rms_unit and name_p95_unit. */
static void add_statistics(psplat_writer *json, const char *name, const char *unit,
                           const psplat_statistics *statistics) {
    const char *const kinds[] = {"max", "rms", "p95"};
    const double values[] = {statistics->max, statistics->rms, statistics->p95};
    for (int i = 0; i < 3; ++i) {
        char key[64];
        snprintf(key, sizeof key, "%s_%s_%s", name, kinds[i], unit);
        psplat_writer_number(json, key, values[i]);
    }
}

static void add_shape(psplat_writer *json, const psplat_shape_errors *e) {
    psplat_writer_count(json, "elements", e->elements);
    psplat_writer_count(json, "source_samples", e->source_samples);
    psplat_writer_count(json, "target_samples", e->target_samples);
    psplat_writer_number(json, "diagonal", e->diagonal);
    psplat_writer_number(json, "reach_percent", e->reach);
    psplat_writer_number(json, "crease_width_percent", e->crease_width);
    add_statistics(json, "outward", "percent", &e->outward);
    add_statistics(json, "inward", "percent", &e->inward);
    add_statistics(json, "distance", "percent", &e->distance);
    add_statistics(json, "normal", "degrees", &e->normal);
    add_statistics(json, "face_normal", "degrees", &e->face_normal);
    add_statistics(json, "crease_normal", "degrees", &e->crease_normal);
    psplat_writer_number(json, "uncovered_area_percent", e->uncovered_area);
    psplat_writer_number(json, "overhang_area_percent", e->overhang_area);
    psplat_writer_number(json, "crease_area_percent", e->crease_area);
}

static void add_vector(psplat_writer *json, const char *key, const double v[3]) {
    psplat_writer_open(json, key, '[');
    for (int k = 0; k < 3; ++k) psplat_writer_number(json, NULL, v[k]);
    psplat_writer_close(json, ']');
}

static void add_places(psplat_writer *json, const psplat_ray_errors *r) {
    psplat_writer_open(json, "places", '[');
    for (size_t i = 0; i < r->place_count; ++i) {
        psplat_writer_open(json, NULL, '{');
        add_vector(json, "point", r->places[i].point);
        add_vector(json, "direction", r->places[i].direction);
        psplat_writer_number(json, "cosine", r->places[i].cosine);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

static void add_rays(psplat_writer *json, const psplat_ray_errors *r) {
    psplat_writer_open(json, "rays", '{');
    psplat_writer_count(json, "count", r->count);
    psplat_writer_count(json, "missed", r->missed);
    psplat_writer_number(json, "missed_percent", psplat_rays_missed_percent(r));
    psplat_writer_count(json, "open", r->open);
    psplat_writer_count(json, "hidden", r->hidden);
    psplat_writer_count(json, "outline", r->outline);
    psplat_writer_number(json, "reach_percent", r->reach);
    psplat_writer_open(json, "ranges", '[');
    for (int i = 0; i < PSPLAT_RAY_RANGES; ++i) {
        psplat_writer_open(json, NULL, '{');
        psplat_writer_number(json, "least_cosine", psplat_rays_least_cosine(i));
        psplat_writer_count(json, "count", r->range_count[i]);
        psplat_writer_count(json, "missed", r->range_missed[i]);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
    add_places(json, r);
    psplat_writer_close(json, '}');
}

/* Writes the errors of pictures with keys that begin with prefix. */
static void add_picture(psplat_writer *json, const char *prefix, const psplat_picture_errors *p) {
    const struct {
        const char *name;
        double value;
    } fields[] = {
        {"psnr_db", p->psnr},
        {"inside_psnr_db", p->inside_psnr},
        {"ssim", p->ssim},
        {"difference_percent", p->difference},
        {"inside_percent", p->inside},
        {"distant_percent", p->distant},
        {"missing_percent", p->missing},
        {"extra_percent", p->extra},
        {"covered", (double)p->covered},
        {"interior_holes", (double)p->interior_holes},
    };
    for (size_t i = 0; i < sizeof fields / sizeof *fields; ++i) {
        char key[64];
        snprintf(key, sizeof key, "%s%s", prefix, fields[i].name);
        psplat_writer_number(json, key, fields[i].value);
    }
}

static void add_pictures(psplat_writer *json, const psplat_comparison *c) {
    static const char *const modes[] = {"phong", "gaussian", "flat"};
    psplat_writer_count(json, "image_size", (size_t)c->size);
    psplat_writer_count(json, "image_erosion", (size_t)c->erosion);
    if (!c->is_mesh) {
        psplat_writer_string(json, "mode", modes[c->mode]);
        psplat_writer_boolean(json, "filter", !c->no_filter);
    }
    add_picture(json, "image_", &c->picture);
    psplat_writer_open(json, "views", '[');
    for (int i = 0; i < PSPLAT_PICTURE_VIEWS; ++i) {
        psplat_writer_open(json, NULL, '{');
        add_picture(json, "", &c->views[i]);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
    if (c->has_base_color) add_picture(json, "base_color_", &c->base_color);
}

psplat_result psplat_comparison_json(const psplat_comparison *c, char **text, size_t *size,
                                     psplat_error *error) {
    psplat_writer json = {0};
    psplat_writer_open(&json, NULL, '{');
    psplat_writer_string(&json, "source", c->source);
    psplat_writer_string(&json, "target", c->target);
    psplat_writer_string(&json, "kind", c->is_mesh ? "triangles" : "splats");
    psplat_writer_count(&json, "source_triangles", c->source_triangles);
    add_shape(&json, &c->shape);
    add_rays(&json, &c->rays);
    if (c->has_pictures) add_pictures(&json, c);
    psplat_writer_number(&json, "seconds", c->seconds);
    psplat_writer_close(&json, '}');
    if (!psplat_writer_finish(&json))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the report");
    *text = json.text;
    *size = json.size;
    return PSPLAT_OK;
}

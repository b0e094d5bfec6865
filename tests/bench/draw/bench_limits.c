/* SPDX-License-Identifier: MIT
 *
 * bench_limits.c - how far the renderer can be driven: each quantity is doubled, or halved, for as
 * long as the picture is what the reference rasteriser, in double precision, draws of the same
 * scene or of one that should look the same and is not extreme.
 *
 *     bench_limits [--markdown] [--steps N]     N: of each quantity at most
 *
 * A picture is right where both cover the same pixels and colours differ by less than a step of 8
 * bits; pixels within 2e-4 of an edge, or 1e-6 of the image, are not looked at, nor those within a
 * tenth of epsilon of the visibility limit.
 */
#include "agreement.h"
#include "scene_asset.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct trial {
    scene s, truth; /* truth.count is 0 where the truth is s itself */
    psplat_view view, truth_view;
} trial;

/* Looks from z = 5 along -z. */
static trial trial_of(scene s) {
    trial t = {.s = s, .view = camera_view(160, 120)};
    t.view.lights[0].direction[0] = -1;
    camera_look(&t.view, (double[]){0, 0, 5}, (double[]){0, 0, 0});
    camera_perspective(&t.view, 200, 1, 20);
    return t;
}

static trial ball(void) {
    return trial_of(scene_sphere(300, 1));
}

/* Makes a white disc x before a red one, which should not be visible. */
static trial sheets(double x, float tolerance) {
    trial t = trial_of(scene_blank(2));
    t.s.has_color = 1;
    t.s.depth_tolerance = tolerance;
    t.s.splats[1].center[2] = (float)-x;
    t.s.splats[1].color[1] = t.s.splats[1].color[2] = 0;
    t.truth = scene_disc(1);
    return t;
}

static trial disc(void) {
    trial t = trial_of(scene_disc(1));
    t.s.material.double_sided = 1;
    return t;
}

static void see_from(trial *t, double distance) {
    camera_look(&t->view, (double[]){0, 0, distance}, (double[]){0, 0, 0});
    camera_perspective(&t->view, 40 * distance, distance / 2, distance * 2);
}

/* ---- what is varied ------------------------------------------------------------------------- */

static trial at_origin_distance(double x) {
    trial t = ball();
    t.truth = scene_sphere(300, 1);
    t.truth_view = t.view;
    camera_look(&t.truth_view, (double[]){1, 2, 4}, (double[]){0, 0, 0});
    for (int i = 0; i < 3; ++i) t.s.origin[i] = floor(x / sqrt(3));
    camera_look(&t.view, (double[]){t.s.origin[0] + 1, t.s.origin[1] + 2, t.s.origin[2] + 4},
                t.s.origin);
    return t;
}

static trial at_eye_distance(double x) {
    trial t = sheets(0.01, 0.002f);
    see_from(&t, x);
    t.truth_view = t.view;
    return t;
}

static trial over_near(double x) {
    trial t = sheets(0.01, 0.002f);
    camera_perspective(&t.view, 200, 5 / x, 5 * x);
    t.truth_view = t.view;
    return t;
}

static trial in_unit(double x) {
    trial t = ball();
    for (size_t i = 0; i < t.s.count; ++i) {
        for (int k = 0; k < 3; ++k) t.s.splats[i].center[k] *= (float)x;
        for (int k = 0; k < 2; ++k) t.s.splats[i].radius[k] *= (float)x;
    }
    t.s.depth_tolerance *= (float)x;
    camera_look(&t.view, (double[]){0, 0, 5 * x}, (double[]){0, 0, 0});
    camera_perspective(&t.view, 200, x, 20 * x);
    return t;
}

static trial with_aspect(double x) {
    trial t = disc();
    scene_set_axes(&t.s.splats[0], (double[]){0.8, 0.6, 0}, (double[]){-0.6, 0.8, 0});
    t.s.splats[0].radius[0] = (float)(5.0 / 200 * x);
    t.s.splats[0].radius[1] = 5.0f / 200;
    return t;
}

static trial at_angle(double x) {
    trial t = disc();
    double angle = x * CAMERA_PI / 180, v[3] = {0, sin(angle), cos(angle)};
    scene_set_axes(&t.s.splats[0], (double[]){1, 0, 0}, v);
    for (int i = 0; i < 3; ++i) t.s.splats[0].normal[i] = (float)(i == 1 ? -v[2] : i ? v[1] : 0);
    t.s.splats[0].center[1] = (float)(0.5 / 200 * 5); /* on a row of pixel centres */
    return t;
}

static trial of_pixels(double x) {
    trial t = disc();
    t.view.width = t.view.height = 15;
    camera_perspective(&t.view, 5 * x, 1, 20);
    return t;
}

static trial of_pixels_filtered(double x) {
    trial t = of_pixels(x);
    t.view.no_filter = 0;
    return t;
}

static trial of_width(double x) {
    trial t = ball();
    t.view.width = (int)x;
    t.view.height = 3;
    camera_perspective(&t.view, 2 * x, 1, 20);
    return t;
}

static trial with_focal(double x) {
    trial t = trial_of(scene_sphere(300, 1));
    t.s.material.double_sided = 1;
    camera_look(&t.view, (double[]){0.2, 0.1, 0.05}, (double[]){0.3, 0.3, -1});
    camera_perspective(&t.view, 160 * x, 1e-3, 20);
    return t;
}

static trial with_gap(double x) {
    trial t = sheets(x, 0);
    see_from(&t, 1);
    t.truth_view = t.view;
    return t;
}

typedef struct quantity {
    const char *name, *unit;
    trial (*make)(double x);
    double first, factor, last; /* last: the farthest value tried */
} quantity;

static const quantity quantities[] = {
    {"distance of the model from the origin", "radii", at_origin_distance, 1, 2, 1e15},
    {"distance of the eye, focal length alike, gap 0.01", "radii", at_eye_distance, 4, 2, 1e9},
    {"distance of eye and far plane over the near one's", "", over_near, 2, 2, 1e15},
    {"unit of the asset", "of a size", in_unit, 1, 2, 1e30},
    {"unit of the asset", "of a size", in_unit, 1, 0.5, 1e-30},
    {"aspect of a splat, two pixels thin", "", with_aspect, 2, 2, 1e9},
    {"angle between splat and view ray", "degrees", at_angle, 10, 0.5, 1e-6},
    {"radius of a splat, no filter", "pixels", of_pixels, 0.9, 0.5, 1e-9},
    {"radius of a splat, filtered", "pixels", of_pixels_filtered, 0.9, 0.5, 1e-9},
    {"width of the image", "pixels", of_width, 128, 2, 16384},
    {"focal length over the image's width", "", with_focal, 1, 0.5, 1e-6},
    {"gap of two surfaces, epsilon 0", "of the distance", with_gap, 0.1, 0.5, 1e-9},
};

/* ---- measuring ------------------------------------------------------------------------------ */

/* Draws and returns the renderer's colours and coverage. */
static float *draw(gpu *g, const psplat_asset *asset, const psplat_view *view) {
    psplat_error error;
    psplat_item item = {.model = NULL};
    float *rgba = malloc(sizeof *rgba * 4 * (size_t)view->width * (size_t)view->height);
    if (!rgba || psplat_model_create(g->renderer, asset, &item.model, &error) ||
        psplat_host_begin(g->host, view->width, view->height, 1, (float[4]){0}, &error) ||
        psplat_draw(g->renderer, view, &item, 1, &error) ||
        psplat_host_read_float(g->host, rgba, &error)) {
        fprintf(stderr, "bench_limits: a picture could not be drawn\n");
        exit(1);
    }
    psplat_model_destroy(g->renderer, item.model);
    return rgba;
}

static int is_alike(const float *rgba, const picture *p, double edge) {
    int seen = 0;
    for (int i = 0; i < p->width * p->height; ++i) {
        if (p->image.tie[i] < edge || p->image.epsilon_tie[i] < 0.1) continue;
        for (int k = 0; k < 4; ++k)
            if (!(fabsf(rgba[4 * i + k] - p->image.color[4 * i + k]) < 1.0f / 255)) return 0;
        seen += p->image.count[i] > 0;
    }
    return seen > 0;
}

static int is_right(gpu *g, const quantity *q, double x) {
    trial t = q->make(x);
    int is_small = q->make == of_pixels || q->make == of_pixels_filtered;
    psplat_asset *asset = scene_open(&t.s), *truth = t.truth.count ? scene_open(&t.truth) : NULL;
    picture p = picture_draw(truth ? truth : asset, NULL, truth ? &t.truth_view : &t.view);
    float *rgba = draw(g, asset, &t.view);
    int result = is_alike(rgba, &p, is_small ? 1e-12 : fmax(2e-4, t.view.width * 1e-6));
    free(rgba);
    picture_free(&p);
    psplat_asset_destroy(truth);
    psplat_asset_destroy(asset);
    if (truth) scene_free(&t.truth);
    scene_free(&t.s);
    return result;
}

static double drive(gpu *g, const quantity *q, int steps) {
    double last = 0, x = q->first;
    for (int i = 0; i < steps && (q->factor > 1 ? x <= q->last : x >= q->last); ++i) {
        if (!is_right(g, q, x)) break;
        last = x;
        x *= q->factor;
    }
    return last;
}

static void print(const quantity *q, double last, int markdown) {
    double next = last * q->factor;
    const char *more = (q->factor > 1 ? next > q->last : next < q->last) ? " and more" : "";
    printf(markdown ? "| %s | %.2g%s | %s |\n" : "%-52s %8.2g%-9s %s\n", q->name, last, more,
           q->unit);
}

int main(int argc, char **argv) {
    int markdown = 0, steps = 1000;
    for (int i = 1; i < argc; ++i)
        if (!strcmp(argv[i], "--markdown")) {
            markdown = 1;
        } else if (!strcmp(argv[i], "--steps") && i + 1 < argc) {
            steps = atoi(argv[++i]);
        } else {
            fprintf(stderr, "bench_limits: the head of bench_limits.c tells what it takes\n");
            return 1;
        }
    gpu g = gpu_open(PSPLAT_API_GL);
    if (markdown) printf("| quantity | right as far as | |\n|---|--:|---|\n");
    for (size_t i = 0; i < sizeof quantities / sizeof *quantities; ++i)
        print(&quantities[i], drive(&g, &quantities[i], steps), markdown);
    gpu_close(&g);
    return 0;
}

/* SPDX-License-Identifier: MIT
 *
 * agreement.c - draws with the renderer and with the reference rasteriser and compares the pixels;
 * see agreement.h.
 */
#include "agreement.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(psplat_result result, const psplat_error *error) {
    if (!result) return;
    fprintf(stderr, "agreement: %s\n", error->text);
    abort();
}

gpu gpu_open(psplat_api api) {
    gpu g;
    psplat_error error;
    check(psplat_host_create(api, 0, &g.host, &error), &error);
    psplat_renderer_desc desc = {
        .get_proc = psplat_host_get_proc, .user = g.host, .images = scene_images()};
    check(psplat_renderer_create(&desc, &g.renderer, &error), &error);
    return g;
}

void gpu_close(gpu *g) {
    psplat_renderer_destroy(g->renderer);
    psplat_host_destroy(g->host);
}

static int setup(psplat_api api, void **state) {
    static gpu g;
    g = gpu_open(api);
    printf("%s, %s\n", psplat_host_renderer(g.host), psplat_host_version(g.host));
    *state = &g;
    return 0;
}

int gpu_setup_gl(void **state) {
    return setup(PSPLAT_API_GL, state);
}

int gpu_setup_gles(void **state) {
    return setup(PSPLAT_API_GLES, state);
}

int gpu_teardown(void **state) {
    gpu_close(*state);
    return 0;
}

/* What the renderer drew of a view, as floats. */
typedef struct drawn {
    float *color, *depth;
} drawn;

static void read_bytes(gpu *g, float *color, size_t count) {
    psplat_error error;
    uint8_t *bytes = malloc(count);
    check(psplat_host_read_rgba8(g->host, bytes, &error), &error);
    for (size_t i = 0; i < count; ++i) color[i] = (float)bytes[i] / 255;
    free(bytes);
}

static drawn draw(gpu *g, const psplat_reference_scene *scene, const psplat_view *from,
                  int is_float) {
    const float clear[4] = {0, 0, 0, 0};
    psplat_view view = *from;
    size_t pixels = (size_t)view.width * (size_t)view.height;
    drawn d = {malloc(pixels * 4 * sizeof(float)), malloc(pixels * sizeof(float))};
    psplat_item item = {.model = NULL};
    psplat_environment *environment = NULL;
    psplat_error error;
    memcpy(item.transform, scene->transform, sizeof item.transform);
    if (scene->environment)
        check(psplat_environment_create(g->renderer, scene->environment, &environment, &error),
              &error);
    view.environment = environment;
    check(psplat_model_create(g->renderer, scene->asset, &item.model, &error), &error);
    check(psplat_host_begin(g->host, view.width, view.height, is_float, clear, &error), &error);
    check(psplat_draw(g->renderer, &view, &item, 1, &error), &error);
    if (is_float)
        check(psplat_host_read_float(g->host, d.color, &error), &error);
    else
        read_bytes(g, d.color, pixels * 4);
    check(psplat_host_read_depth(g->host, d.depth, &error), &error);
    psplat_model_destroy(g->renderer, item.model);
    psplat_environment_destroy(g->renderer, environment);
    return d;
}

static double difference(const float *a, const float *b, int count) {
    double most = 0;
    for (int i = 0; i < count; ++i) {
        double d = fabs((double)a[i] - (double)b[i]);
        most = d <= most ? most : d; /* a NaN replaces every number */
    }
    return most;
}

static int shows(const picture *p, int x, int y, int32_t splat) {
    return x >= 0 && y >= 0 && x < p->width && y < p->height &&
           p->image.splat[y * p->width + x] == splat;
}

/* Returns whether a pixel's nearest splat shows in none or only one direction beside the pixel. */
static int is_thin(const picture *p, int x, int y) {
    int32_t splat = p->image.splat[y * p->width + x];
    return splat < 0 || !((shows(p, x - 1, y, splat) || shows(p, x + 1, y, splat)) &&
                          (shows(p, x, y - 1, splat) || shows(p, x, y + 1, splat)));
}

/* Moves a view's picture by pixels to the right and up. */
static psplat_view moved(const psplat_view *from, double right, double up) {
    psplat_view view = *from;
    for (int i = 0; i < 4; ++i) {
        view.projection[4 * i] += 2 * right / view.width * from->projection[4 * i + 3];
        view.projection[4 * i + 1] += 2 * up / view.height * from->projection[4 * i + 3];
    }
    return view;
}

/* Marks pixels which show another splat, or (u, v) that are further than a pixel's change of 1
 * away, in a picture that is moved by step pixels. */
static void mark_changes(const picture *p, const picture *other, double step, uint8_t *marks) {
    for (int at = 0; at < p->width * p->height; ++at) {
        const double *here = p->image.uv + 2 * at, *there = other->image.uv + 2 * at;
        double change = fmax(fabs(there[0] - here[0]), fabs(there[1] - here[1]));
        marks[at] |= p->image.splat[at] != other->image.splat[at] || !(change <= step);
    }
}

/* The reference's pictures a part of a pixel to the right of a view's and above it. */
typedef struct neighbours {
    picture pictures[2];
} neighbours;

/* As short as the distance to a contour that is no tie, in pixels. */
static const double neighbour_step = 1.0 / 4096;

static neighbours neighbours_of(const psplat_reference_scene *scene, const psplat_view *view) {
    neighbours n;
    for (int upwards = 0; upwards < 2; ++upwards) {
        psplat_view from = moved(view, upwards ? 0 : neighbour_step, upwards ? neighbour_step : 0);
        from.mode = PSPLAT_MODE_PARAMETERS; /* which shades nothing */
        n.pictures[upwards] = picture_of_scene(scene, &from);
    }
    return n;
}

static void neighbours_free(neighbours *n) {
    for (int i = 0; i < 2; ++i) picture_free(&n->pictures[i]);
}

/* Returns a mark for each pixel that counts for agreement.thin_uv and thin_depth: none without
 * neighbours. The caller frees them. */
static uint8_t *thin_pixels(const picture *p, const neighbours *n) {
    uint8_t *marks = calloc((size_t)p->width, (size_t)p->height);
    if (!n) return marks;
    for (int y = 0; y < p->height; ++y)
        for (int x = 0; x < p->width; ++x) marks[y * p->width + x] = (uint8_t)is_thin(p, x, y);
    for (int i = 0; i < 2; ++i) mark_changes(p, &n->pictures[i], neighbour_step, marks);
    return marks;
}

static void compare_pixel(const drawn *d, const picture *p, size_t at, int thin, psplat_mode mode,
                          agreement *result) {
    const float *ours = d->color + 4 * at, *theirs = p->image.color + 4 * at;
    int covered = p->image.count[at] > 0;
    if ((ours[3] > 0) != covered) {
        ++result->mismatches;
        return;
    }
    if (!covered) return;
    agreement here = {.color = 0};
    *(thin ? &here.thin_depth : &here.depth) = fabs((double)d->depth[at] - p->image.depth[at]);
    if (mode != PSPLAT_MODE_PARAMETERS)
        here.color = difference(ours, theirs, 3);
    else if (difference(ours + 2, theirs + 2, 1) < 0.5)
        *(thin ? &here.thin_uv : &here.uv) = difference(ours, theirs, 2);
    else
        here.other = 1;
    agreement_add(result, &here);
}

agreement agreement_measure(gpu *g, const psplat_asset *asset, const double transform[16],
                            const psplat_view *view, int is_float, const agreement_ties *ties) {
    psplat_reference_scene scene = {.asset = asset};
    if (transform) memcpy(scene.transform, transform, sizeof scene.transform);
    return agreement_measure_scene(g, &scene, view, is_float, ties);
}

/* Compares one mode. Without neighbours no pixel is thin. */
static agreement measure(gpu *g, const psplat_reference_scene *scene, const psplat_view *view,
                         int is_float, const agreement_ties *ties, const neighbours *n) {
    agreement result = {0};
    picture p = picture_of_scene(scene, view);
    drawn d = draw(g, scene, view, is_float);
    uint8_t *thin = thin_pixels(&p, n);
    size_t pixels = (size_t)p.width * (size_t)p.height;
    for (size_t at = 0; at < pixels; ++at) {
        result.covered += p.image.count[at] > 0;
        if (p.image.tie[at] < ties->edge || p.image.depth_tie[at] < ties->depth ||
            p.image.epsilon_tie[at] < ties->epsilon)
            ++result.skipped;
        else
            compare_pixel(&d, &p, at, thin[at], view->mode, &result);
    }
    free(thin);
    picture_free(&p);
    free(d.color);
    free(d.depth);
    return result;
}

agreement agreement_measure_scene(gpu *g, const psplat_reference_scene *scene,
                                  const psplat_view *view, int is_float,
                                  const agreement_ties *ties) {
    return measure(g, scene, view, is_float, ties, NULL);
}

agreement agreement_measure_modes(gpu *g, const psplat_asset *asset, const double transform[16],
                                  const psplat_view *view, unsigned modes, int is_float,
                                  const agreement_ties *ties) {
    psplat_reference_scene scene = {.asset = asset};
    if (transform) memcpy(scene.transform, transform, sizeof scene.transform);
    neighbours n = neighbours_of(&scene, view);
    psplat_view from = *view;
    agreement all = {0};
    for (int mode = 0; mode < PSPLAT_MODE_COUNT; ++mode) {
        if (!(modes >> mode & 1)) continue;
        from.mode = (psplat_mode)mode;
        agreement one = measure(g, &scene, &from, is_float, ties, &n);
        agreement_add(&all, &one);
    }
    neighbours_free(&n);
    return all;
}

static double larger(double a, double b) {
    return b <= a ? a : b;
}

void agreement_add(agreement *total, const agreement *a) {
    total->covered += a->covered;
    total->skipped += a->skipped;
    total->mismatches += a->mismatches;
    total->other += a->other;
    total->color = larger(total->color, a->color);
    total->uv = larger(total->uv, a->uv);
    total->depth = larger(total->depth, a->depth);
    total->thin_uv = larger(total->thin_uv, a->thin_uv);
    total->thin_depth = larger(total->thin_depth, a->thin_depth);
}

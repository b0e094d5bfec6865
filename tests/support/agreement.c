/* SPDX-License-Identifier: MIT
 *
 * agreement.c - draws with the renderer and with the reference rasteriser and compares the pixels;
 * see agreement.h.
 */
#include "agreement.h"

#include <GL/glcorearb.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(psplat_result result, const psplat_error *error) {
    if (!result) return;
    fprintf(stderr, "agreement: %s\n", error->text);
    abort();
}

static PFNGLGETFLOATVPROC get_float;

static void APIENTRY get_float_isotropic(GLenum name, GLfloat *value) {
    get_float(name, value);
    if (name == GL_MAX_TEXTURE_MAX_ANISOTROPY) *value = 1;
}

/* Loads what a host loads, but of a GL that filters textures without anisotropy, which GLs may
 * choose freely, and the reference has not. */
static void *get_isotropic_proc(void *host, const char *name) {
    void *address = psplat_host_get_proc(host, name);
    void (*isotropic)(GLenum, GLfloat *) = get_float_isotropic;
    if (strcmp(name, "glGetFloatv")) return address;
    memcpy(&get_float, &address, sizeof get_float);
    memcpy(&address, &isotropic, sizeof address);
    return address;
}

/* Returns the step of the grid to which the GL rounds the places of vertices, in pixels. */
static double vertex_step_of(psplat_host *host) {
    void *address = psplat_host_get_proc(host, "glGetIntegerv");
    PFNGLGETINTEGERVPROC get_integer;
    GLint bits = 0;
    memcpy(&get_integer, &address, sizeof get_integer);
    get_integer(GL_SUBPIXEL_BITS, &bits);
    return ldexp(1, -bits);
}

gpu gpu_open(psplat_api api) {
    const int software = !getenv("PSPLAT_TEST_GPU");
    gpu g;
    psplat_error error;
    check(psplat_host_create(api, software, &g.host, &error), &error);
    if (!software && strstr(psplat_host_renderer(g.host), "llvmpipe")) {
        fprintf(stderr, "agreement: PSPLAT_TEST_GPU is set, but EGL offers no GPU\n");
        abort();
    }
    g.vertex_step = software ? 0 : vertex_step_of(g.host);
    psplat_renderer_desc desc = {
        .get_proc = get_isotropic_proc, .user = g.host, .images = scene_images()};
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

/* The nearest splats a part of a pixel to the right of a view's and above it. */
typedef struct neighbours {
    picture pictures[2];
} neighbours;

/* As short as the distance to a contour that is no tie, in pixels. */
static const double neighbour_step = 1.0 / 4096;

static neighbours neighbours_of(const psplat_reference_scene *scene, const psplat_view *view) {
    neighbours n;
    for (int upwards = 0; upwards < 2; ++upwards) {
        psplat_view from = moved(view, upwards ? 0 : neighbour_step, upwards ? neighbour_step : 0);
        n.pictures[upwards] = picture_of_nearest(scene, &from);
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

/* ---- what rounded vertices may change ---------------------------------------------------------
 */

enum { SHIFTS = 4 };

/* The reference's pictures moved by the step of a GPU's grid of vertices, towards each corner. */
typedef struct shifted {
    picture pictures[SHIFTS];
    int count; /* 0: vertices are not rounded */
} shifted;

static shifted shifted_of(const gpu *g, const psplat_reference_scene *scene,
                          const psplat_view *view) {
    shifted s = {.count = g->vertex_step > 0 ? SHIFTS : 0};
    for (int i = 0; i < s.count; ++i) {
        psplat_view from = moved(view, i & 1 ? g->vertex_step : -g->vertex_step,
                                 i & 2 ? g->vertex_step : -g->vertex_step);
        s.pictures[i] = picture_of_scene(scene, &from);
    }
    return s;
}

static void shifted_free(shifted *s) {
    for (int i = 0; i < s->count; ++i) picture_free(&s->pictures[i]);
}

/* Returns the greatest change of a pixel's depth between the picture and those moved. */
static double depth_change(const picture *p, const shifted *s, size_t at) {
    double change = 0;
    for (int i = 0; i < s->count; ++i)
        change = fmax(change, fabs(s->pictures[i].image.depth[at] - p->image.depth[at]));
    return change;
}

/* Returns whether rounding may change which splats a pixel shows: two of them may come nearer to
 * each other, each by the change of its depth. */
static int may_change(const picture *p, const shifted *s, size_t at, const agreement_ties *ties) {
    int may = s->count && p->image.depth_tie[at] < ties->depth + 2 * depth_change(p, s, at);
    for (int i = 0; i < s->count; ++i) {
        const psplat_reference_image *image = &s->pictures[i].image;
        may |= image->count[at] != p->image.count[at] || image->splat[at] != p->image.splat[at] ||
               image->epsilon_tie[at] < ties->epsilon;
    }
    return may;
}

/* Returns by how much numbers of a pixel's colour differ beyond what rounding may change. */
static double color_beyond(const float *ours, const picture *p, const shifted *s, size_t at,
                           int count) {
    const float *theirs = p->image.color + 4 * at;
    double change = 0;
    for (int i = 0; i < s->count; ++i)
        change = fmax(change, difference(s->pictures[i].image.color + 4 * at, theirs, count));
    double d = difference(ours, theirs, count) - change;
    return d < 0 ? 0 : d; /* a NaN stays one */
}

static double depth_beyond(double ours, const picture *p, const shifted *s, size_t at) {
    double d = fabs(ours - p->image.depth[at]) - depth_change(p, s, at);
    return d < 0 ? 0 : d;
}

/* ---- pixels -----------------------------------------------------------------------------------
 */

/* What a pixel is compared by. */
typedef struct comparison {
    drawn drawn;
    picture picture;
    shifted shifted;
    uint8_t *thin;
    psplat_mode mode;
} comparison;

static void compare_pixel(const comparison *c, size_t at, agreement *result) {
    const float *ours = c->drawn.color + 4 * at, *theirs = c->picture.image.color + 4 * at;
    int covered = c->picture.image.count[at] > 0, thin = c->thin[at];
    if ((ours[3] > 0) != covered) {
        ++result->mismatches;
        return;
    }
    if (!covered) return;
    agreement here = {.color = 0};
    *(thin ? &here.thin_depth : &here.depth) =
        depth_beyond((double)c->drawn.depth[at], &c->picture, &c->shifted, at);
    if (c->mode != PSPLAT_MODE_PARAMETERS)
        here.color = color_beyond(ours, &c->picture, &c->shifted, at, 3);
    else if (difference(ours + 2, theirs + 2, 1) < 0.5)
        *(thin ? &here.thin_uv : &here.uv) = color_beyond(ours, &c->picture, &c->shifted, at, 2);
    else
        here.other = 1;
    agreement_add(result, &here);
}

/* Returns whether a decision for a pixel is too close to call. */
static int is_tie(const comparison *c, const agreement_ties *ties, size_t at) {
    const psplat_reference_image *image = &c->picture.image;
    return image->tie[at] < ties->edge || image->depth_tie[at] < ties->depth ||
           image->epsilon_tie[at] < ties->epsilon;
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
    comparison c = {.drawn = draw(g, scene, view, is_float),
                    .picture = picture_of_scene(scene, view),
                    .shifted = shifted_of(g, scene, view),
                    .mode = view->mode};
    c.thin = thin_pixels(&c.picture, n);
    size_t pixels = (size_t)view->width * (size_t)view->height;
    for (size_t at = 0; at < pixels; ++at) {
        result.covered += c.picture.image.count[at] > 0;
        if (is_tie(&c, ties, at))
            ++result.skipped;
        else if (may_change(&c.picture, &c.shifted, at, ties))
            ++result.left_out;
        else
            compare_pixel(&c, at, &result);
    }
    if (2 * result.left_out > result.covered)
        printf("agreement: %zu pixels of %zu may change with rounded vertices\n", result.left_out,
               result.covered);
    free(c.thin);
    shifted_free(&c.shifted);
    picture_free(&c.picture);
    free(c.drawn.color);
    free(c.drawn.depth);
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
    total->left_out += a->left_out;
    total->mismatches += a->mismatches;
    total->other += a->other;
    total->color = larger(total->color, a->color);
    total->uv = larger(total->uv, a->uv);
    total->depth = larger(total->depth, a->depth);
    total->thin_uv = larger(total->thin_uv, a->thin_uv);
    total->thin_depth = larger(total->thin_depth, a->thin_depth);
}

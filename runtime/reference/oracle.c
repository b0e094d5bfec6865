/* SPDX-License-Identifier: MIT
 * Spec 5.3 to 5.7: what becomes of the fragments of a pixel. Two passes over all splats, as the
 * specification words it: the first finds how far each pixel sees, the second sums what it sees. */
#include "oracle.h"

#include <math.h>
#include <stdlib.h>

typedef struct pixel {
    double limit;   /* fragments with t up to here contribute (5.3) */
    double nearest; /* least t, its splat and its fragment */
    int32_t nearest_splat;
    double u, v;
    uint32_t count;
    double edge_tie, depth_tie, epsilon_tie;
    /* The sums of eq. (6); radiance is that of the comparison modes (5.7). */
    double weight, depth, normal[3], radiance[3];
    psplat_oracle_surface surface;
} pixel;

typedef struct drawing {
    const psplat_asset *asset;
    const psplat_view *view;
    double transform[16];
    psplat_oracle_camera camera;
    psplat_oracle_light light;
    int blends; /* 0 in the modes that show the nearest splat alone */
    int ties;   /* somebody asked for them */
    pixel *pixels;
} drawing;

/* What is done with each splat of a pass. */
typedef struct visit {
    const psplat_batch *batch;
    const psplat_splat *splat;
    const psplat_oracle_space *space;
    psplat_oracle_splat placed;
    int32_t index; /* over all batches */
    int cull;
} visit;

/* A visitor is shown the splat's plane at each pixel that the splat may touch. */
typedef void (*visitor)(drawing *d, const visit *at, const psplat_oracle_ray *ray,
                        const psplat_oracle_fragment *f, pixel *p);

static void visit_pixels(drawing *d, const visit *at, visitor call) {
    psplat_oracle_box box = psplat_oracle_camera_bounds(&d->camera, &at->placed);
    for (int y = box.y0; y < box.y1; ++y)
        for (int x = box.x0; x < box.x1; ++x) {
            psplat_oracle_ray ray;
            psplat_oracle_fragment f;
            psplat_oracle_camera_ray(&d->camera, x + 0.5, y + 0.5, &ray);
            if (psplat_oracle_fragment_find(&d->camera, &at->placed, &ray, &f))
                call(d, at, &ray, &f, &d->pixels[(size_t)y * (size_t)d->view->width + (size_t)x]);
        }
}

static void visit_splats(drawing *d, visitor call) {
    int32_t first = 0;
    for (size_t b = 0; b < psplat_asset_batch_count(d->asset); ++b) {
        const psplat_batch *batch = psplat_asset_batch(d->asset, b);
        psplat_oracle_space space;
        visit at = {.batch = batch, .space = &space};
        at.cull = d->view->culling == PSPLAT_CULL_BY_MATERIAL
                      ? !batch->material.double_sided
                      : d->view->culling == PSPLAT_CULL_ALWAYS;
        int drawn = psplat_oracle_place_batch(batch, d->transform, d->view->view, &space);
        for (size_t i = 0; drawn && i < batch->splat_count; ++i) {
            at.splat = &batch->splats[i];
            at.index = first + (int32_t)i;
            psplat_oracle_place_splat(at.splat, batch->clip_count, &space, &at.placed);
            psplat_oracle_camera_face(&d->camera, &space, &at.placed);
            visit_pixels(d, &at, call);
        }
        first += (int32_t)batch->splat_count;
    }
}

/* ---- 5.3: visibility ------------------------------------------------------------------------ */

static void find_visible(drawing *d, const visit *at, const psplat_oracle_ray *ray,
                         const psplat_oracle_fragment *f, pixel *p) {
    (void)ray;
    if (!psplat_oracle_fragment_exists(&at->placed, f, at->cull)) return;
    p->limit = fmin(p->limit, f->t + (d->blends ? at->placed.epsilon : 0));
    if (!(f->t < p->nearest)) return;
    p->nearest = f->t;
    p->nearest_splat = at->index;
    p->u = f->u;
    p->v = f->v;
}

/* ---- 5.4 and 5.7: blending ------------------------------------------------------------------ */

/* Eq. (4); above 0, so that a covered pixel stays covered where a sharp kernel underflows. */
static double kernel_weight(const psplat_kernel *kernel, double r) {
    return fmax(exp(-(double)kernel->sharpness * pow(r, kernel->exponent)), 1e-300);
}

static psplat_oracle_surface surface_of(const psplat_splat *splat,
                                        const psplat_material *material) {
    psplat_oracle_surface surface = {.metallic = material->metallic,
                                     .roughness = material->roughness,
                                     .unlit = material->unlit != 0};
    for (int i = 0; i < 3; ++i) {
        surface.base[i] = (double)material->base_color[i] * (double)splat->color[i];
        surface.emissive[i] = material->emissive[i];
    }
    return surface;
}

static void add_surface(psplat_oracle_surface *sum, double weight,
                        const psplat_oracle_surface *surface) {
    for (int i = 0; i < 3; ++i) {
        sum->base[i] += weight * surface->base[i];
        sum->emissive[i] += weight * surface->emissive[i];
    }
    sum->metallic += weight * surface->metallic;
    sum->roughness += weight * surface->roughness;
    sum->unlit += weight * surface->unlit;
}

static void to_eye_of(const psplat_oracle_ray *ray, double to_eye[3]) {
    for (int i = 0; i < 3; ++i) to_eye[i] = -ray->direction[i] / ray->length;
}

static void contribute(drawing *d, const visit *at, const psplat_oracle_ray *ray,
                       const psplat_oracle_fragment *f, pixel *p) {
    double weight = d->blends ? kernel_weight(&at->batch->kernel, f->r) : 1;
    double sign = at->placed.cosine > -0.5 ? 1 : -1, normal[3], to_eye[3], radiance[3];
    psplat_oracle_surface surface = surface_of(at->splat, &at->batch->material);
    p->weight += weight;
    p->depth += weight * f->depth;
    ++p->count;
    if (d->view->mode == PSPLAT_MODE_PHONG) {
        for (int i = 0; i < 3; ++i)
            p->normal[i] += weight * sign *
                            (at->placed.normal[0][i] + f->u * at->placed.normal[1][i] +
                             f->v * at->placed.normal[2][i]);
        add_surface(&p->surface, weight, &surface);
        return;
    }
    to_eye_of(ray, to_eye);
    for (int i = 0; i < 3; ++i) normal[i] = sign * at->placed.normal[0][i];
    psplat_oracle_normalise(normal);
    psplat_oracle_shade(&surface, &d->light, normal, to_eye, radiance);
    for (int i = 0; i < 3; ++i) p->radiance[i] += weight * radiance[i];
}

/* How near the decisions about this fragment are, for psplat_reference_image. */
static void note_ties(drawing *d, const visit *at, const psplat_oracle_ray *ray,
                      const psplat_oracle_fragment *f, int exists, pixel *p) {
    const double close =
        0.01; /* a fragment that clearly fails one test decides nothing by others */
    double limit[3], w = 0, behind = f->t - p->limit;
    if (exists && at->index != p->nearest_splat) {
        psplat_oracle_along(ray->origin, p->limit / ray->length, ray->direction, limit);
        double difference = psplat_oracle_camera_depth(&d->camera, limit, &w) - f->depth;
        p->depth_tie = fmin(p->depth_tie, fabs(difference));
        if (d->blends && at->space->epsilon > 0)
            p->epsilon_tie = fmin(p->epsilon_tie, fabs(behind) / (2 * at->space->epsilon));
    }
    if (behind > 0) return; /* hidden: its edges do not show */
    psplat_oracle_margins margins =
        psplat_oracle_fragment_margins(&d->camera, &at->placed, ray, f, at->cull);
    if (margins.depth > -close) p->edge_tie = fmin(p->edge_tie, fabs(margins.edge));
    if (margins.edge > -close) p->depth_tie = fmin(p->depth_tie, fabs(margins.depth));
}

static void blend_visible(drawing *d, const visit *at, const psplat_oracle_ray *ray,
                          const psplat_oracle_fragment *f, pixel *p) {
    int exists = psplat_oracle_fragment_exists(&at->placed, f, at->cull);
    if (d->ties) note_ties(d, at, ray, f, exists, p);
    int chosen = d->blends ? f->t <= p->limit : at->index == p->nearest_splat;
    if (exists && chosen) contribute(d, at, ray, f, p);
}

/* ---- 5.5 and 5.6: the image ----------------------------------------------------------------- */

/* The pixel's normal, lit once. */
static void shade_blended(const drawing *d, const pixel *p, const psplat_oracle_ray *ray,
                          double radiance[3]) {
    double to_eye[3];
    to_eye_of(ray, to_eye);
    int opposed = !(psplat_oracle_length(p->normal) > 0); /* normals that sum to 0 face the eye */
    double normal[3];
    for (int i = 0; i < 3; ++i) normal[i] = opposed ? to_eye[i] : p->normal[i];
    psplat_oracle_normalise(normal);
    psplat_oracle_surface surface = {.metallic = 0};
    add_surface(&surface, 1 / p->weight, &p->surface);
    psplat_oracle_shade(&surface, &d->light, normal, to_eye, radiance);
}

static void write_color(const drawing *d, const pixel *p, const psplat_oracle_ray *ray,
                        float color[4]) {
    double radiance[3] = {0, 0, 0};
    for (int i = 0; i < 4; ++i) color[i] = 0;
    if (!p->count) return;
    color[3] = 1;
    if (d->view->mode == PSPLAT_MODE_PARAMETERS) {
        color[0] = (float)p->u;
        color[1] = (float)p->v;
        color[2] = (float)p->nearest_splat;
        return;
    }
    if (d->view->mode == PSPLAT_MODE_PHONG)
        shade_blended(d, p, ray, radiance);
    else
        for (int i = 0; i < 3; ++i) radiance[i] = p->radiance[i] / p->weight;
    for (int i = 0; i < 3; ++i)
        color[i] =
            (float)(d->view->linear_output ? radiance[i] : psplat_oracle_encode(radiance[i]));
}

static void write_pixel(const drawing *d, int x, int y, psplat_reference_image *image) {
    size_t at = (size_t)y * (size_t)d->view->width + (size_t)x;
    const pixel *p = &d->pixels[at];
    psplat_oracle_ray ray;
    psplat_oracle_camera_ray(&d->camera, x + 0.5, y + 0.5, &ray);
    if (image->color) write_color(d, p, &ray, image->color + 4 * at);
    if (image->depth) image->depth[at] = p->count ? p->depth / p->weight : 1;
    if (image->uv) {
        image->uv[2 * at] = p->u;
        image->uv[2 * at + 1] = p->v;
    }
    if (image->splat) image->splat[at] = p->nearest_splat;
    if (image->count) image->count[at] = p->count;
    if (image->tie) image->tie[at] = p->edge_tie;
    if (image->depth_tie) image->depth_tie[at] = p->depth_tie;
    if (image->epsilon_tie) image->epsilon_tie[at] = p->epsilon_tie;
}

/* ---- psplat_reference_draw ------------------------------------------------------------------ */

static psplat_result prepare(drawing *d, const double transform[16], psplat_error *error) {
    const psplat_view *view = d->view;
    if (view->width < 1 || view->height < 1)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "the image is %d x %d pixels",
                           view->width, view->height);
    if ((unsigned)view->mode >= PSPLAT_MODE_COUNT || (unsigned)view->culling > PSPLAT_CULL_ALWAYS)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "unknown mode %d or culling %d",
                           (int)view->mode, (int)view->culling);
    if (!psplat_oracle_camera_set(&d->camera, view))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "the view or projection matrix is singular or not finite");
    psplat_oracle_light_set(&d->light, view);
    d->blends = view->mode == PSPLAT_MODE_PHONG || view->mode == PSPLAT_MODE_GAUSSIAN;
    for (int i = 0; i < 16; ++i) d->transform[i] = transform ? transform[i] : i % 5 == 0;
    d->pixels = calloc((size_t)view->width * (size_t)view->height, sizeof *d->pixels);
    if (!d->pixels)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %d x %d pixels",
                           view->width, view->height);
    return PSPLAT_OK;
}

static void clear(drawing *d) {
    size_t count = (size_t)d->view->width * (size_t)d->view->height;
    for (size_t i = 0; i < count; ++i) {
        pixel *p = &d->pixels[i];
        p->limit = p->nearest = HUGE_VAL;
        p->nearest_splat = -1;
        p->edge_tie = p->depth_tie = p->epsilon_tie = 1;
    }
}

psplat_result psplat_reference_draw(const psplat_asset *asset, const double transform[16],
                                    const psplat_view *view, psplat_reference_image *image,
                                    psplat_error *error) {
    drawing d = {.asset = asset, .view = view};
    if (!asset || !view || !image)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "asset, view or image is NULL");
    psplat_result result = prepare(&d, transform, error);
    if (result) return result;
    d.ties = image->tie || image->depth_tie || image->epsilon_tie;
    clear(&d);
    visit_splats(&d, find_visible);
    visit_splats(&d, blend_visible);
    for (int y = 0; y < view->height; ++y)
        for (int x = 0; x < view->width; ++x) write_pixel(&d, x, y, image);
    free(d.pixels);
    return PSPLAT_OK;
}

/* SPDX-License-Identifier: MIT
 *
 * oracle.c - the reference rasteriser's frame (spec 5): two passes over all splats, as the
 * specification words them. The first finds each pixel's visibility limit (5.3), the second sums
 * the splats up to it (5.4). psplat_reference_draw checks its arguments and runs both.
 */
#include "reference/oracle.h"

#include <math.h>
#include <string.h>

/* ---- splats and pixels ----------------------------------------------------------------------- */

typedef void (*splat_visitor)(psplat_oracle_drawing *d, const psplat_oracle_visit *at);

static int is_culled(const psplat_view *view, const psplat_batch *batch) {
    return view->culling == PSPLAT_CULL_BY_MATERIAL ? !batch->material.double_sided
                                                    : view->culling == PSPLAT_CULL_ALWAYS;
}

/* Places every splat of the scene in eye space and calls a function with it, in draw order. */
static void visit_splats(psplat_oracle_drawing *d, splat_visitor call) {
    int32_t first = 0;
    for (size_t b = 0; b < psplat_asset_batch_count(d->scene->asset); ++b) {
        const psplat_batch *batch = psplat_asset_batch(d->scene->asset, b);
        psplat_oracle_space space;
        psplat_oracle_visit at = {.batch = batch, .space = &space};
        at.cull = is_culled(d->view, batch);
        int drawn = psplat_oracle_place_batch(batch, d->transform, d->view->view, &space);
        for (size_t i = 0; drawn && i < batch->splat_count; ++i) {
            at.splat = &batch->splats[i];
            at.index = first + (int32_t)i;
            psplat_oracle_place_splat(at.splat, batch->clip_count, &space, &at.placed);
            psplat_oracle_camera_face(&d->camera, &at.placed);
            psplat_oracle_mask_set(&at.placed.mask, d, batch, i);
            psplat_oracle_filter_set(&at.filter, &d->camera, &at.placed,
                                     d->blends && !d->view->no_filter);
            call(d, &at);
        }
        first += (int32_t)batch->splat_count;
    }
}

/* Called with a splat and one of the pixels that it may touch. */
typedef void (*pixel_visitor)(psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                              const psplat_oracle_sight *sight, psplat_oracle_pixel *p);

/* Returns the pixels that the splat may touch, as it is and as the filter widens it. */
static psplat_oracle_box box_of(const psplat_oracle_drawing *d, const psplat_oracle_visit *at) {
    double frame[3][4];
    if (at->placed.is_curved) return psplat_oracle_camera_curved_bounds(&d->camera, &at->placed);
    psplat_oracle_camera_frame(&d->camera, &at->placed, frame);
    psplat_oracle_box box = psplat_oracle_camera_bounds(&d->camera, frame);
    if (!at->filter.is_on) return box;
    memcpy(frame, at->filter.frame, sizeof frame);
    for (int i = 0; i < 3; ++i) frame[i][2] -= 2 * at->filter.nearer * frame[i][3];
    psplat_oracle_box wide = psplat_oracle_camera_bounds(&d->camera, frame);
    if (box.x0 >= box.x1 || box.y0 >= box.y1) return wide;
    if (wide.x0 >= wide.x1 || wide.y0 >= wide.y1) return box;
    return (psplat_oracle_box){
        wide.x0 < box.x0 ? wide.x0 : box.x0, wide.x1 > box.x1 ? wide.x1 : box.x1,
        wide.y0 < box.y0 ? wide.y0 : box.y0, wide.y1 > box.y1 ? wide.y1 : box.y1};
}

static void visit_pixels(psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                         pixel_visitor call) {
    psplat_oracle_ray ray;
    psplat_oracle_meeting meeting;
    psplat_oracle_sight sight = {&d->camera, &at->placed, &at->filter, &ray, &meeting, at->cull};
    psplat_oracle_box box = box_of(d, at);
    for (int y = box.y0; y < box.y1; ++y)
        for (int x = box.x0; x < box.x1; ++x) {
            psplat_oracle_camera_ray(&d->camera, x + 0.5, y + 0.5, &ray);
            psplat_oracle_meet(&d->camera, &at->placed, &ray, at->cull, &meeting);
            call(d, at, &sight, &d->pixels[(size_t)y * (size_t)d->view->width + (size_t)x]);
        }
}

/* ---- passes ---------------------------------------------------------------------------------- */

static int is_masked(const psplat_oracle_sight *sight, const psplat_oracle_fragment *f) {
    double steps[2][2];
    const psplat_oracle_mask *mask = &sight->splat->mask;
    if (!(mask->cutoff > 0)) return 0;
    psplat_oracle_find_steps(sight->camera, sight->splat, sight->ray, f, steps);
    return psplat_oracle_mask_margin(mask, f->u, f->v, steps) < 0;
}

/* First pass: lowers the pixel's visibility limit, and keeps the nearest fragment. */
static void see(psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                const psplat_oracle_sight *sight, psplat_oracle_pixel *p) {
    const psplat_oracle_fragment *f = psplat_oracle_met(sight->meeting);
    if (!f || is_masked(sight, f)) return;
    double limit = d->blends ? psplat_oracle_fragment_limit(&at->placed, sight->ray, f) : f->t;
    p->limit = fmin(p->limit, limit);
    if (!(f->t < p->nearest)) return;
    p->nearest = f->t;
    p->nearest_splat = at->index;
    p->u = f->u;
    p->v = f->v;
}

static void blend(psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                  const psplat_oracle_sight *sight, psplat_oracle_pixel *p) {
    psplat_oracle_blend(d, at, sight, p);
}

static void find_visible(psplat_oracle_drawing *d, const psplat_oracle_visit *at) {
    visit_pixels(d, at, see);
}

static void blend_visible(psplat_oracle_drawing *d, const psplat_oracle_visit *at) {
    visit_pixels(d, at, blend);
}

static void collect_caster(psplat_oracle_drawing *d, const psplat_oracle_visit *at) {
    d->lighting.casters[d->lighting.caster_count++] = at->placed;
}

/* ---- psplat_reference_draw ------------------------------------------------------------------- */

static psplat_result check_lights(const psplat_view *view, psplat_error *error) {
    if (view->light_count < 0 || view->light_count > PSPLAT_MAX_LIGHTS)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "%d lights are not 0 ... %d",
                           view->light_count, PSPLAT_MAX_LIGHTS);
    for (int i = 0; i < view->light_count; ++i)
        if ((unsigned)view->lights[i].type > PSPLAT_LIGHT_SPOT)
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "light %d is of unknown type %d", i,
                               (int)view->lights[i].type);
    return PSPLAT_OK;
}

static psplat_result check(const psplat_view *view, const psplat_environment_desc *environment,
                           psplat_error *error) {
    int shading = (int)view->shading;
    if (view->width < 1 || view->height < 1)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "the image is %d x %d pixels",
                           view->width, view->height);
    if ((unsigned)view->mode >= PSPLAT_MODE_COUNT || (unsigned)view->culling > PSPLAT_CULL_ALWAYS ||
        (unsigned)view->shading >= PSPLAT_SHADING_COUNT)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "unknown mode %d, culling %d or shading %d", (int)view->mode,
                           (int)view->culling, shading);
    if (shading == PSPLAT_SHADING_TOON || shading == PSPLAT_SHADING_SPLATS ||
        (shading == PSPLAT_SHADING_OVERDRAW && !view->linear_output))
        return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 0,
                           "the reference does not define the colours of shading %d", shading);
    if (environment && (!environment->radiance || environment->size < 1))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "the environment has no texels");
    return check_lights(view, error);
}

static void clear(psplat_oracle_drawing *d) {
    size_t count = (size_t)d->view->width * (size_t)d->view->height;
    for (size_t i = 0; i < count; ++i) {
        psplat_oracle_pixel *p = &d->pixels[i];
        p->limit = p->nearest = HUGE_VAL;
        p->nearest_splat = -1;
        p->edge_tie = p->depth_tie = p->epsilon_tie = p->alpha_tie = 1;
    }
}

static psplat_result prepare(psplat_oracle_drawing *d, psplat_error *error) {
    const psplat_view *view = d->view;
    int is_identity = 1;
    if (!psplat_oracle_camera_set(&d->camera, view))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "the view or projection matrix is singular or not finite");
    psplat_oracle_lighting_set(&d->lighting, view, d->scene->environment);
    d->blends = view->mode == PSPLAT_MODE_PHONG || view->mode == PSPLAT_MODE_GAUSSIAN;
    for (int i = 0; i < 16; ++i) is_identity &= d->scene->transform[i] == 0;
    for (int i = 0; i < 16; ++i)
        d->transform[i] = is_identity ? i % 5 == 0 : d->scene->transform[i];
    d->pixels =
        psplat_oracle_allocate((size_t)view->width * (size_t)view->height, sizeof *d->pixels);
    size_t casters = 0, batches = psplat_asset_batch_count(d->scene->asset);
    for (size_t b = 0; psplat_oracle_lighting_has_shadows(&d->lighting) && b < batches; ++b)
        casters += psplat_asset_batch(d->scene->asset, b)->splat_count;
    d->lighting.casters = psplat_oracle_allocate(casters, sizeof *d->lighting.casters);
    if (!d->pixels || !d->lighting.casters)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %d x %d pixels",
                           view->width, view->height);
    clear(d);
    return psplat_oracle_images_make(d, error);
}

static void draw(psplat_oracle_drawing *d, psplat_reference_image *image) {
    d->ties = image->tie || image->depth_tie || image->epsilon_tie || image->alpha_tie;
    if (psplat_oracle_lighting_has_shadows(&d->lighting)) visit_splats(d, collect_caster);
    visit_splats(d, find_visible);
    if (d->ties || image->color || image->depth || image->count) visit_splats(d, blend_visible);
    for (int y = 0; y < d->view->height; ++y)
        for (int x = 0; x < d->view->width; ++x) psplat_oracle_resolve(d, x, y, image);
}

psplat_result psplat_reference_draw(const psplat_reference_scene *scene, const psplat_view *view,
                                    psplat_reference_image *image, psplat_error *error) {
    psplat_oracle_drawing d = {.scene = scene, .view = view};
    if (!scene || !scene->asset || !view || !image)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "scene, asset, view or image is NULL");
    const psplat_batch *first = psplat_asset_batch(scene->asset, 0);
    if (first && !first->splats)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "the asset was opened to draw alone");
    psplat_result result = check(view, scene->environment, error);
    if (!result) result = prepare(&d, error);
    if (!result) draw(&d, image);
    psplat_oracle_images_free(&d);
    psplat_oracle_release(d.pixels);
    psplat_oracle_release(d.lighting.casters);
    return result;
}

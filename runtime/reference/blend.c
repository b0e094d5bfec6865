/* SPDX-License-Identifier: MIT
 *
 * blend.c - the weighted sums over the splats that contribute to a pixel (spec 5.4, and 5.7 for the
 * comparison modes), and the ties: how near each decision about a pixel was to the opposite.
 */
#include "reference/oracle.h"

#include <math.h>
#include <string.h>

/* Returns the kernel of eq. (4) times the filter's factor. It is always above 0, so that a covered
 * pixel stays covered where a sharp kernel underflows or a splat is seen along its plane. */
static double weight_of(const psplat_kernel *kernel, const psplat_oracle_share *share) {
    double psi = exp(-(double)kernel->sharpness * pow(share->r, kernel->exponent));
    return fmax(psi * share->factor, 1e-300);
}

/* Returns the splat's finish (spec 3.10). Where none is stored it is one that changes nothing. */
static psplat_finish finish_of(const psplat_oracle_visit *at) {
    if (at->batch->finishes) return at->batch->finishes[at->splat - at->batch->splats];
    return (psplat_finish){.occlusion = 1, .roughness = 1, .metallic = 1, .emissive = {1, 1, 1}};
}

/* Returns the material at (u, v) of the splat, by eq. (4a) and (4b). */
static psplat_oracle_surface surface_of(const psplat_oracle_visit *at, double u, double v) {
    const psplat_material *material = &at->batch->material;
    const psplat_finish finish = finish_of(at);
    psplat_oracle_surface surface = {
        .metallic = (double)material->metallic * (double)finish.metallic,
        .roughness = (double)material->roughness * (double)finish.roughness,
        .occlusion = (double)finish.occlusion,
        .unlit = material->unlit != 0};
    for (int i = 0; i < 3; ++i) {
        double color = (double)at->splat->color[i] + u * (double)finish.color_u[i] +
                       v * (double)finish.color_v[i];
        surface.base[i] = (double)material->base_color[i] * fmin(fmax(color, 0), 1);
        surface.emissive[i] = (double)material->emissive[i] * (double)finish.emissive[i];
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
    sum->occlusion += weight * surface->occlusion;
    sum->unlit += weight * surface->unlit;
}

/* Returns 1 where splats are lit one by one, as those of the modes GAUSSIAN and FLAT are. */
static int is_lit_alone(const psplat_view *view) {
    return view->mode != PSPLAT_MODE_PHONG && view->shading == PSPLAT_SHADING_LIT;
}

/* Applies the material's textures at (u, v). Where splats do not vary, they are those of the whole
 * splat: its radii take the place of the pixel, and its normal stays as it is (5.7). */
static void apply_textures(const psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                           const psplat_oracle_share *share, int bends,
                           psplat_oracle_surface *surface, double normal[3]) {
    double u = bends ? share->u : 0, v = bends ? share->v : 0, steps[2][2] = {{1, 0}, {0, 1}};
    psplat_oracle_coordinates c;
    if (!at->batch->texcoords) return;
    if (bends) memcpy(steps, share->steps, sizeof steps);
    psplat_oracle_coordinates_set(&c, &at->batch->texcoords[at->splat - at->batch->splats], u, v,
                                  steps);
    psplat_oracle_texture_surface(d, &at->batch->material, &c, surface);
    if (bends) psplat_oracle_texture_normal(d, &at->batch->material, &at->placed, &c, u, v, normal);
}

/* Adds the splat's terms to the sums of eq. (6). Only in Phong mode do its normal and its colour
 * vary over the splat. Beyond a seam its normal keeps the whole weight, unless a texture turns it
 * (3.6). */
static void contribute(const psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                       const psplat_oracle_ray *ray, const psplat_oracle_share *share,
                       psplat_oracle_pixel *p) {
    int bends = d->view->mode == PSPLAT_MODE_PHONG;
    double whole = d->blends ? weight_of(&at->batch->kernel, share) : 1;
    double weight = d->blends ? whole * share->seam : whole;
    if (bends && psplat_oracle_turns_normals(d, at->batch)) whole = weight;
    double normal[3], radiance[3];
    double u = bends ? share->u : 0, v = bends ? share->v : 0;
    psplat_oracle_surface surface = surface_of(at, u, v);
    p->weight += weight;
    p->depth += weight * share->depth;
    ++p->count;
    for (int i = 0; i < 3; ++i)
        normal[i] =
            at->placed.normal[0][i] + u * at->placed.normal[1][i] + v * at->placed.normal[2][i];
    apply_textures(d, at, share, bends, &surface, normal);
    psplat_oracle_face_normal(&at->placed, ray, share->seen, normal);
    for (int i = 0; i < 3; ++i) p->normal[i] += whole * normal[i];
    add_surface(&p->surface, weight, &surface);
    if (!is_lit_alone(d->view)) return;
    psplat_oracle_show(d, ray, share->t, &surface, normal, radiance);
    for (int i = 0; i < 3; ++i) p->radiance[i] += weight * radiance[i];
}

/* ---- ties ------------------------------------------------------------------------------------ */

/* A fragment that fails one test by more than this margin is not there, however near it is to
 * passing the other test. It is in (u, v) or pixels for edges and in window depth for planes, and
 * chosen by hand. */
static const double clear_failure = 0.01;

static void note_margins(const psplat_oracle_margins *margins, psplat_oracle_pixel *p) {
    if (margins->depth > -clear_failure) p->edge_tie = fmin(p->edge_tie, fabs(margins->edge));
    if (margins->edge > -clear_failure) p->depth_tie = fmin(p->depth_tie, fabs(margins->depth));
}

/* How much more transparent than the cutoff a fragment is that no renderer takes for opaque; in
 * parts of alpha, and chosen by hand. */
static const double clear_transparency = 0.1;

/* Notes how near a point that is not clearly beyond an edge is to being masked. */
static void note_opacity(const psplat_oracle_margins *margins, double opacity,
                         psplat_oracle_pixel *p) {
    if (margins->edge > -clear_failure && margins->depth > -clear_failure)
        p->alpha_tie = fmin(p->alpha_tie, fabs(opacity));
}

static double opacity_of(const psplat_oracle_sight *sight, const psplat_oracle_fragment *f) {
    double steps[2][2];
    if (!(sight->splat->mask.cutoff > 0) || f->is_missed) return 1;
    psplat_oracle_find_steps(sight->camera, sight->splat, sight->ray, f, steps);
    return psplat_oracle_mask_margin(&sight->splat->mask, f->u, f->v, steps);
}

/* Notes the margins of points that set the visibility limit, or would set it if edges were
 * elsewhere, and of what is not hidden beyond it. */
static void note_points(const psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                        const psplat_oracle_sight *sight, psplat_oracle_pixel *p) {
    const double rounding = 1e-12;
    for (int i = 0; i < sight->meeting->count; ++i) {
        const psplat_oracle_fragment *f = &sight->meeting->points[i];
        double limit = d->blends ? psplat_oracle_fragment_limit(&at->placed, sight->ray, f) : f->t;
        int is_shown = !at->filter.is_on && f->t <= p->limit; /* hidden edges do not show */
        if (!is_shown && limit > p->limit + rounding * fabs(p->limit)) continue;
        double opacity = opacity_of(sight, f);
        if (opacity < -clear_transparency) continue;
        psplat_oracle_margins margins =
            psplat_oracle_fragment_margins(&d->camera, &at->placed, sight->ray, f, at->cull);
        note_margins(&margins, p);
        note_opacity(&margins, opacity, p);
    }
}

/* Notes how near the limit is to the far plane, because a limit beyond it may count as none (5.3).
 */
static void note_far_limit(const psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                           const psplat_oracle_ray *ray, psplat_oracle_pixel *p) {
    if (!d->blends || !isfinite(p->limit) || !(at->space->epsilon > 0)) return;
    double before = psplat_oracle_camera_reach(&d->camera, ray, 1) - p->limit;
    p->epsilon_tie = fmin(p->epsilon_tie, fmax(before, 0) / (2 * at->space->epsilon));
}

/* Notes how near a splat that covers the pixel is to the visibility limit. */
static void note_limit(const psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                       const psplat_oracle_ray *ray, const psplat_oracle_share *share,
                       psplat_oracle_pixel *p) {
    double limit[3], w = 0;
    if (!isfinite(p->limit)) return;
    /* The nearest fragment always lies before the limit, so nothing about it is close. */
    if (at->index == p->nearest_splat && share->tested <= p->nearest) return;
    psplat_oracle_along(ray->origin, p->limit / ray->length, ray->direction, limit);
    double difference =
        psplat_oracle_camera_depth(&d->camera, limit, &w) + at->filter.nearer - share->depth;
    p->depth_tie = fmin(p->depth_tie, fabs(difference));
    if (d->blends && at->space->epsilon > 0)
        p->epsilon_tie =
            fmin(p->epsilon_tie, fabs(share->tested - p->limit) / (2 * at->space->epsilon));
}

void psplat_oracle_blend(const psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                         const psplat_oracle_sight *sight, psplat_oracle_pixel *p) {
    psplat_oracle_share share;
    psplat_oracle_margins margins;
    int exists = psplat_oracle_filter_share(sight, &share, d->ties ? &margins : NULL);
    double opacity =
        exists ? psplat_oracle_mask_margin(&at->placed.mask, share.u, share.v, share.steps) : 1;
    if (d->ties) {
        note_points(d, at, sight, p);
        note_far_limit(d, at, sight->ray, p);
        note_margins(&at->filter.margins, p);
        if (exists && opacity >= -clear_transparency) note_limit(d, at, sight->ray, &share, p);
        if (share.tested <= p->limit) note_margins(&margins, p);
        if (exists && share.tested <= p->limit) p->alpha_tie = fmin(p->alpha_tie, fabs(opacity));
    }
    /* Where the ray meets no splat, what the filter adds beside splats does not count (5.8). */
    int chosen =
        d->blends ? isfinite(p->limit) && share.tested <= p->limit : at->index == p->nearest_splat;
    if (!exists || !chosen || !(opacity >= 0)) return;
    contribute(d, at, sight->ray, &share, p);
    if (d->ties && d->blends) p->edge_tie = fmin(p->edge_tie, share.seam_margin);
}

/* SPDX-License-Identifier: MIT
 * Spec 5.4 and 5.7: the sums over what contributes to a pixel, and how near the decisions were. */
#include "oracle.h"

#include <math.h>

/* Eq. (4) times the filter's factor; above 0, so that a covered pixel stays covered where a sharp
 * kernel underflows or a splat is seen along its plane. */
static double weight_of(const psplat_kernel *kernel, const psplat_oracle_share *share) {
    double psi = exp(-(double)kernel->sharpness * pow(share->r, kernel->exponent));
    return fmax(psi * share->factor, 1e-300);
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

static int bends(const psplat_oracle_drawing *d) {
    return d->view->mode == PSPLAT_MODE_PHONG;
}

static void contribute(const psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                       const psplat_oracle_ray *ray, const psplat_oracle_share *share,
                       psplat_oracle_pixel *p) {
    double weight = d->blends ? weight_of(&at->batch->kernel, share) : 1;
    double sign = at->placed.cosine > -0.5 ? 1 : -1, normal[3], shown[3];
    psplat_oracle_surface surface = surface_of(at->splat, &at->batch->material);
    p->weight += weight;
    p->depth += weight * share->depth;
    ++p->count;
    for (int i = 0; i < 3; ++i)
        normal[i] =
            sign * (at->placed.normal[0][i] + (bends(d) ? share->u * at->placed.normal[1][i] +
                                                              share->v * at->placed.normal[2][i]
                                                        : 0));
    if (bends(d)) {
        for (int i = 0; i < 3; ++i) p->normal[i] += weight * normal[i];
        add_surface(&p->surface, weight, &surface);
        return;
    }
    psplat_oracle_show(d, ray, share->t, &surface, normal, shown);
    for (int i = 0; i < 3; ++i) p->radiance[i] += weight * shown[i];
}

/* ---- ties ------------------------------------------------------------------------------------ */

/* A fragment that clearly fails one test decides nothing by others. */
static const double close = 0.01;

static void note_margins(const psplat_oracle_margins *margins, psplat_oracle_pixel *p) {
    if (margins->depth > -close) p->edge_tie = fmin(p->edge_tie, fabs(margins->edge));
    if (margins->edge > -close) p->depth_tie = fmin(p->depth_tie, fabs(margins->depth));
}

/* What the visibility limit is, or would be if an edge were elsewhere. */
static void note_visibility(const psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                            const psplat_oracle_sight *sight, psplat_oracle_pixel *p) {
    const double rounding = 1e-12;
    const psplat_oracle_fragment *f = sight->fragment;
    if (!f || f->t + (d->blends ? at->placed.epsilon : 0) > p->limit * (1 + rounding)) return;
    psplat_oracle_margins margins =
        psplat_oracle_fragment_margins(&d->camera, &at->placed, sight->ray, f, at->cull);
    note_margins(&margins, p);
}

/* How near what exists is to the limit. */
static void note_limit(const psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                       const psplat_oracle_ray *ray, const psplat_oracle_share *share,
                       psplat_oracle_pixel *p) {
    double limit[3], w = 0;
    if (!isfinite(p->limit)) return;
    /* The nearest fragment always lies before the limit, which is not before it. */
    if (at->index == p->nearest_splat && share->t <= p->nearest) return;
    psplat_oracle_along(ray->origin, p->limit / ray->length, ray->direction, limit);
    double difference = psplat_oracle_camera_depth(&d->camera, limit, &w) - share->depth;
    p->depth_tie = fmin(p->depth_tie, fabs(difference));
    if (d->blends && at->space->epsilon > 0)
        p->epsilon_tie = fmin(p->epsilon_tie, fabs(share->t - p->limit) / (2 * at->space->epsilon));
}

void psplat_oracle_blend(const psplat_oracle_drawing *d, const psplat_oracle_visit *at,
                         const psplat_oracle_sight *sight, psplat_oracle_pixel *p) {
    psplat_oracle_share share;
    psplat_oracle_margins margins;
    int exists = psplat_oracle_filter_share(sight, &share, d->ties ? &margins : NULL);
    if (d->ties) {
        note_visibility(d, at, sight, p);
        if (exists) note_limit(d, at, sight->ray, &share, p);
        if (share.t <= p->limit) note_margins(&margins, p); /* hidden edges do not show */
    }
    int chosen = d->blends ? share.t <= p->limit : at->index == p->nearest_splat;
    if (exists && chosen) contribute(d, at, sight->ray, &share, p);
}

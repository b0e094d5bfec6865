/* SPDX-License-Identifier: MIT
 *
 * resolve.c - the colour and depth of a pixel once its sums are complete (spec 5.5, 5.6), and the
 * debug shadings that psplat_shading offers.
 */
#include "reference/oracle.h"

#include <math.h>

static void point_at(const psplat_oracle_ray *ray, double t, double point[3]) {
    psplat_oracle_along(ray->origin, t / ray->length, ray->direction, point);
}

/* Returns 1 at the near plane and 0 at the far one; between them it is linear in the distance from
 * the eye's plane. */
static double nearness(const psplat_oracle_camera *camera, const psplat_oracle_ray *ray, double t) {
    double at[3], near[3], far[3];
    point_at(ray, t, at);
    point_at(ray, psplat_oracle_camera_reach(camera, ray, 0), near);
    point_at(ray, psplat_oracle_camera_reach(camera, ray, 1), far);
    return (far[2] - at[2]) / (far[2] - near[2]);
}

void psplat_oracle_show(const psplat_oracle_drawing *d, const psplat_oracle_ray *ray, double t,
                        const psplat_oracle_surface *surface, const double normal[3],
                        double shown[3]) {
    double to_eye[3], unit[3], point[3];
    for (int i = 0; i < 3; ++i) to_eye[i] = -ray->direction[i] / ray->length;
    int opposed = !(psplat_oracle_length(normal) > 0); /* normals that sum to 0 face the eye */
    for (int i = 0; i < 3; ++i) unit[i] = opposed ? to_eye[i] : normal[i];
    psplat_oracle_normalise(unit);
    if (d->view->shading == PSPLAT_SHADING_UNLIT) {
        for (int i = 0; i < 3; ++i) shown[i] = surface->base[i];
    } else if (d->view->shading == PSPLAT_SHADING_NORMAL) {
        for (int i = 0; i < 3; ++i) shown[i] = 0.5 + 0.5 * unit[i];
    } else {
        point_at(ray, t, point);
        psplat_oracle_shade(surface, &d->lighting, point, unit, to_eye, shown);
    }
}

/* Finds what a covered pixel shows, before sRGB encoding. */
static void show_pixel(const psplat_oracle_drawing *d, const psplat_oracle_pixel *p,
                       const psplat_oracle_ray *ray, double shown[3]) {
    double t = psplat_oracle_camera_reach(&d->camera, ray, p->depth / p->weight);
    psplat_oracle_surface mean = p->surface;
    double *numbers[] = {&mean.metallic, &mean.roughness, &mean.unlit, &mean.occlusion};
    for (int i = 0; i < 4; ++i) *numbers[i] /= p->weight;
    for (int i = 0; i < 3; ++i) {
        mean.base[i] /= p->weight;
        mean.emissive[i] /= p->weight;
    }
    if (d->view->shading == PSPLAT_SHADING_DEPTH)
        for (int i = 0; i < 3; ++i) shown[i] = nearness(&d->camera, ray, t);
    else if (d->view->shading == PSPLAT_SHADING_OVERDRAW)
        for (int i = 0; i < 3; ++i) shown[i] = p->count;
    else if (d->view->mode == PSPLAT_MODE_PHONG || d->view->shading != PSPLAT_SHADING_LIT)
        psplat_oracle_show(d, ray, t, &mean, p->normal, shown);
    else
        for (int i = 0; i < 3; ++i) shown[i] = p->radiance[i] / p->weight;
}

/* Returns 1 for the shadings that are colours. Those that are numbers are written as they are. */
static int is_encoded(const psplat_view *view) {
    return !view->linear_output &&
           (view->shading == PSPLAT_SHADING_LIT || view->shading == PSPLAT_SHADING_UNLIT);
}

static void write_color(const psplat_oracle_drawing *d, const psplat_oracle_pixel *p,
                        const psplat_oracle_ray *ray, float color[4]) {
    double shown[3] = {p->u, p->v, p->nearest_splat};
    for (int i = 0; i < 4; ++i) color[i] = 0;
    if (!p->count) return;
    int is_raw = d->view->mode == PSPLAT_MODE_PARAMETERS;
    if (!is_raw) show_pixel(d, p, ray, shown);
    for (int i = 0; i < 3; ++i)
        color[i] =
            (float)(!is_raw && is_encoded(d->view) ? psplat_oracle_encode(shown[i]) : shown[i]);
    color[3] = 1;
}

void psplat_oracle_resolve(const psplat_oracle_drawing *d, int x, int y,
                           psplat_reference_image *image) {
    size_t at = (size_t)y * (size_t)d->view->width + (size_t)x;
    const psplat_oracle_pixel *p = &d->pixels[at];
    psplat_oracle_ray ray;
    psplat_oracle_camera_ray(&d->camera, x + 0.5, y + 0.5, &ray);
    if (image->color) write_color(d, p, &ray, image->color + 4 * at);
    /* Splats that the filter widens may reach beyond the far plane. */
    if (image->depth) image->depth[at] = p->count ? fmin(p->depth / p->weight, 1) : 1;
    if (image->uv) {
        image->uv[2 * at] = p->u;
        image->uv[2 * at + 1] = p->v;
    }
    if (image->splat) image->splat[at] = p->nearest_splat;
    if (image->count) image->count[at] = p->count;
    if (image->tie) image->tie[at] = p->edge_tie;
    if (image->depth_tie) image->depth_tie[at] = p->depth_tie;
    if (image->epsilon_tie) image->epsilon_tie[at] = p->epsilon_tie;
    if (image->alpha_tie) image->alpha_tie[at] = p->alpha_tie;
}

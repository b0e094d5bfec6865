/* SPDX-License-Identifier: MIT
 *
 * tile_view.c - planes, depths and scales of a view in the space of a tileset.
 */
#include "tileset/tile_view.h"

#include "core/matrix.h"

#include <math.h>
#include <string.h>

/* By how much sums of products of cosines may be off; far above rounding. */
static const double rounding = 1e-6;

/* Pixels by which splats may be drawn beyond their bounds: the filter widens them to one. */
enum { MARGIN = 1 };

static psplat_result check(const psplat_tiles_view *view, psplat_error *error) {
    if (!view || !view->view)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "view must not be NULL");
    if (view->view->width < 1 || view->view->height < 1)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "a view of %d x %d pixels",
                           view->view->width, view->view->height);
    if ((unsigned)view->view->culling > PSPLAT_CULL_ALWAYS)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "unknown culling %d",
                           (int)view->view->culling);
    if (!(view->pixels >= 0) || !isfinite(view->pixels) || !isfinite(view->seconds))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "pixels or seconds are negative or not finite");
    return PSPLAT_OK;
}

static int is_zero(const double m[16]) {
    for (int i = 0; i < 16; ++i)
        if (m[i] != 0.0) return 0;
    return 1;
}

static void find_planes(psplat_tile_camera *camera, const double clip[16],
                        const psplat_view *view) {
    const double grow[3] = {1.0 + 2.0 * MARGIN / view->width, 1.0 + 2.0 * MARGIN / view->height,
                            1.0};
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side)
            for (int i = 0; i < 4; ++i)
                camera->planes[2 * axis + side][i] =
                    grow[axis] * clip[4 * i + 3] + (side ? -1.0 : 1.0) * clip[4 * i + axis];
    for (int i = 0; i < 4; ++i) camera->depth[i] = clip[4 * i + 3];
}

/* Returns the greatest singular value of the part of a projection that makes pixels of lengths
 * along the image plane. */
static double find_focal(const double p[16], const psplat_view *view) {
    double a = 0.5 * view->width * p[0], b = 0.5 * view->width * p[4];
    double c = 0.5 * view->height * p[1], d = 0.5 * view->height * p[5];
    double sum = 0.5 * (a * a + b * b + c * c + d * d);
    double half = 0.5 * (a * a + b * b - c * c - d * d), mixed = a * c + b * d;
    return sqrt(sum + sqrt(half * half + mixed * mixed));
}

/* Returns the least cosine between the direction in which w grows and the rays through the corners
 * of the view, or 0. */
static double find_least_cosine(const double p[16], const double inverse[16]) {
    const double g[3] = {p[3], p[7], p[11]};
    double least = 1.0, length = sqrt(psplat_dot3(g, g));
    for (int corner = 0; corner < 4; ++corner) {
        double ray[3], x = corner & 1 ? 1.0 : -1.0, y = corner & 2 ? 1.0 : -1.0;
        for (int i = 0; i < 3; ++i)
            ray[i] = x * inverse[i] + y * inverse[4 + i] + inverse[8 + i] + inverse[12 + i];
        double cosine = psplat_dot3(g, ray) / (length * sqrt(psplat_dot3(ray, ray)));
        least = cosine < least ? cosine : least;
    }
    return least > 0.0 ? least : 0.0;
}

static void find_scales(psplat_tile_camera *camera, const psplat_view *view,
                        const double inverse[16], const double modelview[16]) {
    const double *p = view->projection, g[3] = {p[3], p[7], p[11]};
    double near = 1.0 / (inverse[15] - inverse[11]);
    camera->focal = find_focal(p, view) * psplat_tile_stretch(modelview);
    camera->area = (double)view->width * view->height;
    camera->near = camera->slant = 0.0;
    if (!camera->is_perspective) return;
    camera->near = near > 0.0 && isfinite(near) ? near : 0.0;
    camera->slant = (1.0 - rounding) * sqrt(psplat_dot3(g, g)) * find_least_cosine(p, inverse) *
                    psplat_tile_shrink(modelview);
}

/* Finds the eye, or the direction of all view rays, which P^-1 gives the z axis. */
static void find_eye(psplat_tile_camera *camera, const double inverse[16],
                     const double modelview_inverse[16]) {
    double length2 = 0.0;
    for (int i = 0; i < 3; ++i) {
        camera->eye[i] = modelview_inverse[12 + i];
        camera->direction[i] = 0.0;
        for (int k = 0; k < 3; ++k)
            camera->direction[i] += modelview_inverse[4 * k + i] * inverse[8 + k];
        length2 += camera->direction[i] * camera->direction[i];
    }
    for (int i = 0; i < 3; ++i) camera->direction[i] /= length2 > 0.0 ? sqrt(length2) : 1.0;
}

static int casts_shadows(const psplat_view *view) {
    int casts = 0;
    for (int i = 0; i < view->light_count && i < PSPLAT_MAX_LIGHTS; ++i)
        casts |= view->lights[i].casts_shadow;
    return casts;
}

psplat_result psplat_tile_camera_set(psplat_tile_camera *camera, const psplat_tiles_view *view,
                                     psplat_error *error) {
    double inverse[16], modelview[16], modelview_inverse[16], clip[16];
    psplat_result result = check(view, error);
    if (result != PSPLAT_OK) return result;
    const psplat_view *v = view->view;
    const double *p = v->projection;
    if (is_zero(view->transform))
        memcpy(modelview, v->view, sizeof modelview);
    else
        psplat_matrix_multiply(v->view, view->transform, modelview);
    if (!psplat_matrix_invert(p, inverse) || !psplat_matrix_invert(modelview, modelview_inverse))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "view, projection or transform has no inverse");
    psplat_matrix_multiply(p, modelview, clip);
    for (int i = 0; i < 16; ++i)
        if (!isfinite(clip[i]))
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "a matrix is not finite");
    /* Backs cast shadows, too. */
    camera->culling = casts_shadows(v) ? PSPLAT_CULL_NEVER : v->culling;
    camera->is_perspective = p[3] != 0.0 || p[7] != 0.0 || p[11] != 0.0;
    find_planes(camera, clip, v);
    find_scales(camera, v, inverse, modelview);
    find_eye(camera, inverse, modelview_inverse);
    return PSPLAT_OK;
}

int psplat_tile_camera_sees(const psplat_tile_camera *camera, const psplat_tile_volume *volume) {
    for (int i = 0; i < 6; ++i) {
        const double *p = camera->planes[i];
        if (psplat_dot3(p, volume->center) + p[3] < -psplat_tile_reach(volume, p)) return 0;
    }
    return 1;
}

/* The same test as that of chunks (core/chunk.c): of all rays through the sphere around the volume
 * and all normals of the cone, no cosine between them is below 0. */
int psplat_tile_camera_sees_backs(const psplat_tile_camera *camera,
                                  const psplat_tile_volume *volume, const double cone[4]) {
    double ray[3], spread = 0.0;
    if (cone[3] < 0.0) return 0;
    for (int i = 0; i < 3; ++i)
        ray[i] = camera->is_perspective ? volume->center[i] - camera->eye[i] : camera->direction[i];
    double length = sqrt(psplat_dot3(ray, ray));
    if (camera->is_perspective) spread = psplat_tile_radius(volume) / length;
    double cosine = psplat_dot3(ray, cone) / length;
    if (!(cosine > 0.0) || !(spread < 1.0)) return 0;
    double sines = sqrt(fmax(1.0 - cosine * cosine, 0.0) * fmax(1.0 - cone[3] * cone[3], 0.0));
    return cosine * cone[3] - sines > spread + rounding;
}

double psplat_tile_camera_scale(const psplat_tile_camera *camera,
                                const psplat_tile_volume *volume) {
    double w = psplat_dot3(camera->depth, volume->center) + camera->depth[3] -
               psplat_tile_reach(volume, camera->depth);
    w = fmax(w, camera->near);
    if (camera->slant > 0.0) w = fmax(w, camera->slant * psplat_tile_distance(volume, camera->eye));
    return w > 0.0 ? camera->focal / w : HUGE_VAL;
}

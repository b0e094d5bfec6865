/* SPDX-License-Identifier: MIT
 *
 * camera.c - computes view rays, unprojection and depth conversion from a projection matrix, and
 * the matrices of batches in a view.
 */
#include "renderer/camera.h"
#include "core/matrix.h"

#include <math.h>
#include <string.h>

/* Finds the matrix from (x, y, 1) to the ray through that point of the viewport. The point on the
 * far plane, P^-1 (ndc x, ndc y, 1, 1), is linear in x and y. The eye is at 0, so the first three
 * coordinates of that point are the ray, also where the far plane is at infinity. Orthographic rays
 * all have the direction that P^-1 gives the z axis. */
static void find_rays(psplat_camera *camera, const double inverse[16], int width, int height) {
    for (int i = 0; i < 3; ++i) {
        double x = camera->is_perspective ? inverse[i] : 0.0;
        double y = camera->is_perspective ? inverse[4 + i] : 0.0;
        double center = inverse[8 + i] + (camera->is_perspective ? inverse[12 + i] : 0.0);
        camera->ray[i] = (float)(x * 2.0 / width);
        camera->ray[3 + i] = (float)(y * 2.0 / height);
        camera->ray[6 + i] = (float)(center - x - y);
    }
}

/* Computes the matrix from pixels and window depth to eye space, by way of normalised device
 * coordinates, and the numbers that depend on the viewport alone. */
static void find_unproject(psplat_camera *camera, const double inverse[16],
                           const psplat_camera_desc *desc) {
    double near = desc->depth_range[0], far = desc->depth_range[1];
    double range = far != near ? far - near : 1.0, product[16];
    const double to_device[16] = {[0] = 2.0 / desc->width,
                                  [5] = 2.0 / desc->height,
                                  [10] = 2.0 / range,
                                  [12] = -1.0,
                                  [13] = -1.0,
                                  [14] = -1.0 - 2.0 * near / range,
                                  [15] = 1.0};
    psplat_matrix_multiply(inverse, to_device, product);
    psplat_matrix_to_float(product, 16, camera->unproject);
    camera->width = desc->width;
    camera->height = desc->height;
    camera->half_viewport[0] = 0.5f * (float)desc->width;
    camera->half_viewport[1] = 0.5f * (float)desc->height;
    camera->half_viewport[2] = camera->depth_range[0] = (float)(0.5 * (far - near));
    camera->depth_range[1] = (float)(0.5 * (far + near));
    camera->margin[0] = 2.0 / desc->width;
    camera->margin[1] = 2.0 / desc->height;
}

/* Finds the distances of the host's near and far plane from the eye. */
static void find_planes(psplat_camera *camera, const double inverse[16]) {
    double near = -(inverse[14] - inverse[10]) / (inverse[15] - inverse[11]);
    double far = -(inverse[14] + inverse[10]) / (inverse[15] + inverse[11]);
    int is_finite = isfinite(far) && far > near;
    camera->planes[0] = (float)near;
    camera->planes[1] = is_finite ? (float)(1.0 / (far - near)) : 0.0f;
    camera->planes[2] = is_finite ? 1.0f : 0.0f;
}

/* Finds the linear map from our window depths to the host's. With the depth range's middle c and
 * half its length r, both are c + r z; z of the host's projection is the span's middle plus its
 * half times z of ours. */
static void find_to_host(psplat_camera *camera, const psplat_depth_span *span,
                         const float range[2]) {
    double near = range[0], far = range[1], center = 0.5 * (far + near), reach = 0.5 * (far - near);
    double half = psplat_depth_span_half(span);
    camera->to_host[0] = (float)half;
    camera->to_host[1] = (float)(center + reach * psplat_depth_span_middle(span) - half * center);
}

psplat_result psplat_camera_set(psplat_camera *camera, const psplat_camera_desc *desc,
                                psplat_error *error) {
    const psplat_depth_span whole = PSPLAT_SPAN_WHOLE, *span = desc->span ? desc->span : &whole;
    double inverse[16], *p = camera->projection;
    if (!psplat_matrix_invert(desc->projection, inverse))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "the projection has no inverse");
    find_planes(camera, inverse);
    find_to_host(camera, span, desc->depth_range);
    psplat_depth_span_project(span, desc->projection, p);
    if (!psplat_matrix_invert(p, inverse))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "the projection has no inverse");
    memcpy(camera->view, desc->view, sizeof camera->view);
    camera->is_perspective = p[3] != 0.0 || p[7] != 0.0 || p[11] != 0.0;
    camera->is_mirrored = p[0] * p[5] - p[4] * p[1] < 0.0;
    psplat_matrix_to_float(p, 16, camera->projection_float);
    find_rays(camera, inverse, desc->width, desc->height);
    for (int i = 0; i < 3; ++i)
        camera->direction[i] = camera->is_perspective ? 0.0 : inverse[8 + i];
    camera->shift[0] = (float)(camera->is_perspective ? -p[14] : -p[10]);
    camera->shift[1] = camera->is_perspective ? 1.0f : 0.0f;
    camera->shift[2] = 0.0f;
    find_unproject(camera, inverse, desc);
    return PSPLAT_OK;
}

/* Returns 1 where a corner of the box is not in front of the near plane. */
static int crosses_near(const double clip[16], const float min[3], const float max[3]) {
    for (int corner = 0; corner < 8; ++corner) {
        double x = corner & 1 ? max[0] : min[0];
        double y = corner & 2 ? max[1] : min[1];
        double z = corner & 4 ? max[2] : min[2];
        double clip_z = clip[2] * x + clip[6] * y + clip[10] * z + clip[14];
        double clip_w = clip[3] * x + clip[7] * y + clip[11] * z + clip[15];
        if (!(clip_z + clip_w > 0.0)) return 1;
    }
    return 0;
}

/* Between -1 and 1, x / w changes by at most (dx + dw) / w where x changes by dx and w by dw. */
double psplat_camera_pixels(const psplat_camera *camera, const double clip[16], const float min[3],
                            const float max[3], double length) {
    double rows[4] = {0.0}, least = HUGE_VAL;
    for (int row = 0; row < 4; ++row) {
        for (int axis = 0; axis < 3; ++axis)
            rows[row] += clip[4 * axis + row] * clip[4 * axis + row];
        rows[row] = length * sqrt(rows[row]);
    }
    for (int corner = 0; corner < 8; ++corner) {
        double w = clip[15];
        for (int axis = 0; axis < 3; ++axis)
            w += clip[4 * axis + 3] * (double)(corner >> axis & 1 ? max[axis] : min[axis]);
        least = fmin(least, w - rows[3]);
    }
    if (!(least > 0.0)) return HUGE_VAL;
    double x = (double)camera->half_viewport[0] * (rows[0] + rows[3]);
    double y = (double)camera->half_viewport[1] * (rows[1] + rows[3]);
    return sqrt(x * x + y * y) / least;
}

static int is_zero(const double m[16]) {
    for (int i = 0; i < 16; ++i)
        if (m[i] != 0.0) return 0;
    return 1;
}

void psplat_camera_compose(const double transform[16], const double model[16], double scene[16]) {
    if (is_zero(transform))
        memcpy(scene, model, 16 * sizeof *scene);
    else
        psplat_matrix_multiply(transform, model, scene);
}

void psplat_camera_modelview(const double view[16], const double transform[16],
                             const double model[16], double modelview[16]) {
    double scene[16];
    psplat_camera_compose(transform, model, scene);
    psplat_matrix_multiply(view, scene, modelview);
}

int psplat_camera_place(const psplat_camera *camera, const double modelview[16],
                        psplat_placement *placement) {
    double normal[9], inverse[16], *clip = placement->clip;
    psplat_matrix_multiply(camera->projection, modelview, clip);
    double det = psplat_matrix_determinant3(modelview);
    if (det == 0.0 || !isfinite(det) || !psplat_matrix_invert(modelview, inverse)) return 0;

    psplat_matrix_normal(modelview, det, normal);
    psplat_matrix_to_float(modelview, 16, placement->modelview);
    psplat_matrix_to_float(normal, 9, placement->normal);
    placement->scale = cbrt(fabs(det));
    placement->unstretch = (float)(1.0 / placement->scale);
    placement->is_mirrored = (det < 0.0) != camera->is_mirrored;
    psplat_chunk_view_set(&placement->chunk_view, clip, inverse, camera->margin,
                          camera->is_perspective, camera->direction, 0);
    return 1;
}

void psplat_camera_place_batch(const psplat_placement_desc *desc, psplat_placement *placement) {
    /* A lower bound avoids 0 / 0 where the eye is at a corner of a splat's triangle. */
    placement->epsilon = fmaxf((float)(desc->depth_tolerance * placement->scale), 1e-30f);
    placement->is_near = crosses_near(placement->clip, desc->bounds_min, desc->bounds_max);
    placement->chunk_view.is_culled = desc->is_culled;
}

/* SPDX-License-Identifier: MIT
 *
 * chunk.c - bounding spheres and normal cones of chunks, and the tests against a view. Which side
 * of a splat the eye sees is the sign of N . (eye - c). Affine maps keep that sign where normals
 * are transformed as spec 4 says, so the test is done in object space whatever the model matrix is.
 */
#include "core/chunk.h"

#include "core/matrix.h"

#include <math.h>

size_t psplat_chunk_count(size_t splat_count) {
    return (splat_count + PSPLAT_CHUNK_SPLATS - 1) / PSPLAT_CHUNK_SPLATS;
}

/* Finds N of a splat, of length 1. */
static void normal_of(const psplat_splat *splat, double normal[3]) {
    double x = splat->rotation[0], y = splat->rotation[1];
    double z = splat->rotation[2], w = splat->rotation[3];
    normal[0] = 2.0 * (x * z + w * y);
    normal[1] = 2.0 * (y * z - w * x);
    normal[2] = w * w + z * z - x * x - y * y;
    double scale = 1.0 / (x * x + y * y + z * z + w * w);
    for (int i = 0; i < 3; ++i) normal[i] *= scale;
}

static int is_curved(const psplat_splat *splat) {
    const float *shape = splat->shape;
    return shape[0] != 0.0f || shape[1] != 0.0f || shape[2] != 0.0f || shape[3] != 0.0f ||
           shape[4] != 0.0f;
}

/* Returns bounds over the disc of the slope at the centre and of its change, by (1b). */
static void slopes_of(const psplat_splat *splat, double *center, double *change) {
    double q = (double)splat->radius[1] / (double)splat->radius[0];
    const float *s = splat->shape;
    double alpha = s[2], beta = s[3], gamma = s[4];
    *center = hypot((double)s[0], (double)s[1]);
    *change = sqrt(alpha * alpha + beta * beta + gamma * gamma * (1.0 + q * q));
}

/* Returns the radius of a sphere around the splat's centre that encloses the splat. */
static float reach_of(const psplat_splat *splat) {
    double center, change;
    if (!is_curved(splat)) return splat->radius[0];
    slopes_of(splat, &center, &change);
    return (float)((double)splat->radius[0] * hypot(1.0, center + 0.5 * change));
}

/* Finds a sphere around the middle of the centres' bounding box. Comparisons take the place of fmin
 * and fmax, which are function calls, because there are millions of splats. */
static void find_sphere(const psplat_splat *splats, size_t count, psplat_chunk *chunk) {
    float min[3], max[3], largest = 0.0f;
    double square = 0.0;
    for (int i = 0; i < 3; ++i) min[i] = max[i] = splats[0].center[i];
    for (size_t k = 0; k < count; ++k) {
        for (int i = 0; i < 3; ++i) {
            float x = splats[k].center[i];
            min[i] = x < min[i] ? x : min[i];
            max[i] = x > max[i] ? x : max[i];
        }
        float reach = reach_of(&splats[k]);
        if (reach > largest) largest = reach;
    }
    for (int i = 0; i < 3; ++i) chunk->center[i] = (float)(0.5 * ((double)min[i] + (double)max[i]));
    for (size_t k = 0; k < count; ++k) {
        double d[3];
        for (int i = 0; i < 3; ++i) d[i] = (double)splats[k].center[i] - (double)chunk->center[i];
        double d2 = psplat_dot3(d, d);
        square = d2 > square ? d2 : square;
    }
    double radius = sqrt(square) + (double)largest;
    chunk->radius = (float)(radius * (1.0 + 1e-6)); /* rounded outwards */
}

/* Returns the least cosine between an axis and a unit normal of a splat, given that with N. Normals
 * lean away from N by up to the angle of the greatest slope. */
static double least_cosine(const psplat_splat *splat, double cosine) {
    double center, change;
    if (!is_curved(splat)) return cosine;
    slopes_of(splat, &center, &change);
    double slope = center + change, sine = sqrt(fmax(1.0 - cosine * cosine, 0.0));
    double least = (cosine - sine * slope) / hypot(1.0, slope);
    return cosine < 0.0 || least < 0.0 ? -1.0 : least;
}

/* Finds the cone around the mean normal. */
static void find_cone(const psplat_splat *splats, size_t count, psplat_chunk *chunk) {
    double axis[3] = {0.0, 0.0, 0.0}, normals[PSPLAT_CHUNK_SPLATS][3], cosine = 1.0;
    for (size_t k = 0; k < count; ++k) {
        normal_of(&splats[k], normals[k]);
        for (int i = 0; i < 3; ++i) axis[i] += normals[k][i];
    }
    double length = sqrt(psplat_dot3(axis, axis));
    for (int i = 0; i < 3; ++i) axis[i] = length > 0.0 ? axis[i] / length : 0.0;
    for (size_t k = 0; k < count; ++k) {
        double c = least_cosine(&splats[k], psplat_dot3(axis, normals[k]));
        cosine = c < cosine ? c : cosine;
    }
    for (int i = 0; i < 3; ++i) chunk->axis[i] = (float)axis[i];
    chunk->cosine = (float)(cosine - 1e-6); /* rounded outwards */
}

void psplat_chunks_find(const psplat_splat *splats, size_t splat_count, psplat_chunk *chunks) {
    for (size_t first = 0; first < splat_count; first += PSPLAT_CHUNK_SPLATS, ++chunks) {
        size_t count = splat_count - first;
        if (count > PSPLAT_CHUNK_SPLATS) count = PSPLAT_CHUNK_SPLATS;
        find_sphere(splats + first, count, chunks);
        find_cone(splats + first, count, chunks);
    }
}

/* ---- views ------------------------------------------------------------------------------- */

static void normalise_plane(double plane[4]) {
    double length = sqrt(psplat_dot3(plane, plane));
    double scale = length > 0.0 ? 1.0 / length : 0.0;
    for (int i = 0; i < 4; ++i) plane[i] *= scale;
}

void psplat_chunk_view_set(psplat_chunk_view *view, const double clip[16],
                           const double modelview_inverse[16], const double margin[2],
                           int is_perspective, const double direction[3], int is_culled) {
    const double grow[3] = {1.0 + margin[0], 1.0 + margin[1], 1.0};
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) {
            double *plane = view->planes[2 * axis + side], sign = side ? -1.0 : 1.0;
            for (int i = 0; i < 4; ++i)
                plane[i] = grow[axis] * clip[4 * i + 3] + sign * clip[4 * i + axis];
            normalise_plane(plane);
        }
    double length2 = 0.0;
    for (int i = 0; i < 3; ++i) {
        view->eye[i] = modelview_inverse[12 + i];
        view->direction[i] = 0.0;
        for (int k = 0; k < 3; ++k)
            view->direction[i] += modelview_inverse[4 * k + i] * direction[k];
        length2 += view->direction[i] * view->direction[i];
    }
    for (int i = 0; i < 3; ++i) view->direction[i] /= length2 > 0.0 ? sqrt(length2) : 1.0;
    view->is_perspective = is_perspective;
    view->is_culled = is_culled;
}

/* Returns 1 where all splats of the chunk are seen from behind. Let theta be the cone's angle and
 * phi the angle between its axis and the view ray through the sphere's centre. The least cosine
 * between a normal and that ray is cos(phi + theta). For rays through other points of the sphere it
 * is less by at most the sphere's radius over its distance. */
static int is_seen_from_behind(const psplat_chunk *chunk, const psplat_chunk_view *view) {
    const double rounding = 1e-4; /* of cosines, which are float; chosen by hand */
    double ray[3], axis[3], ray_spread = 0.0, cos_theta = (double)chunk->cosine;
    if (cos_theta < 0.0) return 0;
    for (int i = 0; i < 3; ++i) {
        axis[i] = chunk->axis[i];
        ray[i] =
            view->is_perspective ? (double)chunk->center[i] - view->eye[i] : view->direction[i];
    }
    double length = sqrt(psplat_dot3(ray, ray));
    if (view->is_perspective) ray_spread = (double)chunk->radius / length;
    double cos_phi = psplat_dot3(ray, axis) / length;
    if (!(cos_phi > 0.0) || !(ray_spread < 1.0)) return 0;
    double sines =
        sqrt(fmax(1.0 - cos_phi * cos_phi, 0.0) * fmax(1.0 - cos_theta * cos_theta, 0.0));
    return cos_phi * cos_theta - sines > ray_spread + rounding;
}

/* Returns how far a point is inside of a plane. */
static double distance_inside(const double plane[4], const float point[3]) {
    const double p[3] = {point[0], point[1], point[2]};
    return psplat_dot3(plane, p) + plane[3];
}

int psplat_chunk_is_visible(const psplat_chunk *chunk, const psplat_chunk_view *view) {
    for (int i = 0; i < 6; ++i)
        if (distance_inside(view->planes[i], chunk->center) < -(double)chunk->radius) return 0;
    return !view->is_culled || !is_seen_from_behind(chunk, view);
}

int psplat_sphere_is_between_sides(const float center[3], float radius,
                                   const psplat_chunk_view *view) {
    for (int i = 0; i < 4; ++i)
        if (!(distance_inside(view->planes[i], center) >= (double)radius)) return 0;
    return 1;
}

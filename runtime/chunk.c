/* SPDX-License-Identifier: MIT
 *
 * Chunks. The facing of a splat is the sign of N . (eye - c), which no affine map with the normals'
 * own transformation (spec 4) changes: so it is judged in object space whatever the model matrix.
 */
#include "chunk.h"

#include <math.h>

size_t psplat_chunk_count(size_t splat_count) {
    return (splat_count + PSPLAT_CHUNK_SPLATS - 1) / PSPLAT_CHUNK_SPLATS;
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* N of a splat, of length 1. */
static void normal_of(const psplat_splat *splat, double normal[3]) {
    double x = splat->rotation[0], y = splat->rotation[1];
    double z = splat->rotation[2], w = splat->rotation[3];
    normal[0] = 2.0 * (x * z + w * y);
    normal[1] = 2.0 * (y * z - w * x);
    normal[2] = w * w + z * z - x * x - y * y;
    double scale = 1.0 / (x * x + y * y + z * z + w * w);
    for (int i = 0; i < 3; ++i) normal[i] *= scale;
}

/* Comparisons, not fmin and fmax: these are calls, and there are millions of splats. */
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
        if (splats[k].radius[0] > largest) largest = splats[k].radius[0];
    }
    for (int i = 0; i < 3; ++i) chunk->center[i] = (float)(0.5 * ((double)min[i] + (double)max[i]));
    for (size_t k = 0; k < count; ++k) {
        double d[3];
        for (int i = 0; i < 3; ++i) d[i] = (double)splats[k].center[i] - (double)chunk->center[i];
        double d2 = dot(d, d);
        square = d2 > square ? d2 : square;
    }
    double radius = sqrt(square) + (double)largest;
    chunk->radius = (float)(radius * (1.0 + 1e-6)); /* rounded outwards */
}

static void find_cone(const psplat_splat *splats, size_t count, psplat_chunk *chunk) {
    double axis[3] = {0.0, 0.0, 0.0}, normals[PSPLAT_CHUNK_SPLATS][3], cosine = 1.0;
    for (size_t k = 0; k < count; ++k) {
        normal_of(&splats[k], normals[k]);
        for (int i = 0; i < 3; ++i) axis[i] += normals[k][i];
    }
    double length = sqrt(dot(axis, axis));
    for (int i = 0; i < 3; ++i) axis[i] = length > 0.0 ? axis[i] / length : 0.0;
    for (size_t k = 0; k < count; ++k) {
        double c = dot(axis, normals[k]);
        cosine = c < cosine ? c : cosine;
    }
    for (int i = 0; i < 3; ++i) chunk->axis[i] = (float)axis[i];
    chunk->cosine = (float)(cosine - 1e-6);
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
    double length = sqrt(dot(plane, plane));
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

/* All splats of the chunk are seen from behind: with theta the cone's angle, phi that between its
 * axis and the view ray of the sphere's centre, the least cosine of a normal with that ray is
 * cos(phi + theta); the sphere's radius over its distance is what the rays of its points may take
 * from it. */
static int is_behind(const psplat_chunk *chunk, const psplat_chunk_view *view) {
    const double slack = 1e-4;
    double ray[3], axis[3], share = 0.0, theta = (double)chunk->cosine;
    if (theta < 0.0) return 0;
    for (int i = 0; i < 3; ++i) {
        axis[i] = chunk->axis[i];
        ray[i] =
            view->is_perspective ? (double)chunk->center[i] - view->eye[i] : view->direction[i];
    }
    double length = sqrt(dot(ray, ray));
    if (view->is_perspective) share = (double)chunk->radius / length;
    double phi = dot(ray, axis) / length;
    if (!(phi > 0.0) || !(share < 1.0)) return 0;
    double sines = sqrt(fmax(1.0 - phi * phi, 0.0) * fmax(1.0 - theta * theta, 0.0));
    return phi * theta - sines > share + slack;
}

int psplat_chunk_is_visible(const psplat_chunk *chunk, const psplat_chunk_view *view) {
    for (int i = 0; i < 6; ++i) {
        const double *p = view->planes[i];
        double center[3] = {chunk->center[0], chunk->center[1], chunk->center[2]};
        if (dot(p, center) + p[3] < -(double)chunk->radius) return 0;
    }
    return !view->is_culled || !is_behind(chunk, view);
}

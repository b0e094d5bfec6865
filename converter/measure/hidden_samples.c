/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * hidden_samples.c - samples on layers of a surface that lie close beneath another layer.
 */
#include "measure/hidden_samples.h"

#include "base/vector.h"
#include "features/samples.h"
#include "features/surface.h"
#include "mesh/distance.h"

/* The height, in parts of the greatest, above which a layer is another one and not the sample's own
 * triangle, on which rounding puts it a little too high or low. Chosen by hand. */
static const double least_height_part = 0.01;

/* Stores whether a front is met on the way from one height above a sample's triangle to another. */
static psplat_result meets(const psplat_surface *surface, const psplat_samples *samples,
                           const psplat_distance *distance, size_t sample, double begin, double end,
                           int *found) {
    const double *point = samples->positions + 3 * sample;
    const double *normal = surface->face_normals + 3 * (size_t)samples->triangles[sample];
    double from[3], to[3];
    along3(from, point, begin, normal);
    along3(to, point, end, normal);
    return psplat_distance_meets(distance, from, to, found);
}

psplat_result psplat_sample_is_hidden(const psplat_surface *surface, const psplat_samples *samples,
                                      const psplat_distance *distance, double height, size_t sample,
                                      int *hidden) {
    return meets(surface, samples, distance, sample, height, least_height_part * height, hidden);
}

psplat_result psplat_sample_hides(const psplat_surface *surface, const psplat_samples *samples,
                                  const psplat_distance *distance, double depth, size_t sample,
                                  int *hides) {
    return meets(surface, samples, distance, sample, -least_height_part * depth, -depth, hides);
}

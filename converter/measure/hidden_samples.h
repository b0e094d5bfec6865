/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * hidden_samples.h - samples on layers of a surface that lie close beneath another layer.
 */
#ifndef PHONGSPLAT_MEASURE_HIDDEN_SAMPLES_H
#define PHONGSPLAT_MEASURE_HIDDEN_SAMPLES_H

#include <phongsplat/splat.h>

#include "features/samples.h"
#include "features/surface.h"
#include "mesh/distance.h"

#include <stddef.h>

/* Stores in *hidden whether a sample, by its index, lies beneath another layer: whether a triangle
 * whose front faces its side lies above it, along the normal of its own triangle, by no more than a
 * height, a length, and by more than rounding. Plates, badges and hoses of game assets have such
 * layers. A picture of the source shows the upper one there, so that none tells whether the lower
 * one is right. */
psplat_result psplat_sample_is_hidden(const psplat_surface *surface, const psplat_samples *samples,
                                      const psplat_distance *distance, double height, size_t sample,
                                      int *hidden);

/* Stores in *hides whether another layer lies beneath a sample, of which the front faces the
 * sample's side, too: the same the other way round. */
psplat_result psplat_sample_hides(const psplat_surface *surface, const psplat_samples *samples,
                                  const psplat_distance *distance, double depth, size_t sample,
                                  int *hides);

#endif

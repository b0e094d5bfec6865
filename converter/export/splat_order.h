/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_order.h - the order of splats in a file: any one is right, and some take fewer bytes.
 */
#ifndef PHONGSPLAT_EXPORT_SPLAT_ORDER_H
#define PHONGSPLAT_EXPORT_SPLAT_ORDER_H

#include "export/splat_attributes.h"

#include <stddef.h>
#include <stdint.h>

/* Sorts the indices of some splats of a table along a Hilbert curve (Skilling: Programming the
 * Hilbert curve, 2004), so that most have near ones before them. Returns 0 where memory ran out. */
int psplat_order_along_curve(const psplat_attribute_table *table, uint32_t *order, size_t count);

/* Changes such an order to one in which the accessors beside a stream, whose positions lack so many
 * low bits, take fewer bytes once they are compressed: a splat follows one from which its bytes
 * differ by little. Positions count, and normals a little, and, where texcoords is 1, coarse
 * texture coordinates. Returns 0 where memory ran out. */
int psplat_order_shorten(const psplat_attribute_table *table, uint32_t low_bits, int texcoords,
                         uint32_t *order, size_t count);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * octahedron.h - octahedral encoding of unit vectors in two integers (Cigolle et al. 2014).
 *
 * A code holds the coordinates x, y of a point on the unfolded octahedron, as the octahedral filter
 * of EXT_meshopt_compression stores them. Codes of up to 8 bits for each coordinate are decoded to
 * bytes, longer ones to shorts.
 */
#ifndef PHONGSPLAT_SPLATS_OCTAHEDRON_H
#define PHONGSPLAT_SPLATS_OCTAHEDRON_H

#include <stdint.h>

/* The least and the greatest number of bits that each coordinate of a code may have. */
#define PSPLAT_OCTAHEDRON_LEAST_BITS 4
#define PSPLAT_OCTAHEDRON_MOST_BITS 14

/* Finds the code whose decoded vector is nearest to a unit vector. */
void psplat_octahedron_encode(const double normal[3], int bits, int32_t code[2]);

/* Does the same with codes whose lowest `shift` bits are 0. */
void psplat_octahedron_encode_coarsely(const double normal[3], int bits, int shift,
                                       int32_t code[2]);

/* Returns whether a code lies inside its range and every decoder makes the same integers of it. */
int psplat_octahedron_is_code(const int32_t code[2], int bits);

/* Decodes to normalized integers of 8 bits (bits <= 8) or 16 bits, as a reader of the file does. */
void psplat_octahedron_decode(const int32_t code[2], int bits, int32_t normal[3]);

/* Decodes to a unit vector: the direction of the integers above. */
void psplat_octahedron_normal(const int32_t code[2], int bits, double normal[3]);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * random.h - seeded pseudo-random numbers (splitmix64), the same on every machine.
 */
#ifndef PHONGSPLAT_BASE_RANDOM_H
#define PHONGSPLAT_BASE_RANDOM_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Returns the next 64 random bits by splitmix64 (Steele, Lea, Flood 2014). *state is the seed at
 * first; every seed is good, and different seeds give different streams. */
uint64_t psplat_random_next(uint64_t *state);

/* Returns a uniform random number x with 0 <= x < 1. */
double psplat_random_unit(uint64_t *state);

#ifdef __cplusplus
}
#endif
#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * quantize_candidate.h - the move of a candidate to the grid of the file's integers.
 */
#ifndef PHONGSPLAT_FIT_QUANTIZE_CANDIDATE_H
#define PHONGSPLAT_FIT_QUANTIZE_CANDIDATE_H

#include "fit/candidate.h"
#include "fit/fit_context.h"

#include <phongsplat/splat.h>

/* Moves a candidate to the grid of the limits' precision, as little as the limits allow. It may
 * then cover fewer samples. In the worst case it becomes a disc that covers one of its samples
 * alone; PSPLAT_GREATEST_PRECISION bounds how far from it. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_quantize_candidate(const psplat_fit_context *context,
                                        psplat_candidate *candidate);

/* Moves a candidate that covers a sample to the grid where it can go on to cover all of its
 * samples, and stores whether it can. Else it stays where it is. */
psplat_result psplat_quantize_whole_candidate(const psplat_fit_context *context,
                                              psplat_candidate *candidate, int *fits);

#endif

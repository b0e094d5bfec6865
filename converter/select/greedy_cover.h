/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * greedy_cover.h - greedy set cover: candidates that together cover every sample.
 */
#ifndef PHONGSPLAT_SELECT_GREEDY_COVER_H
#define PHONGSPLAT_SELECT_GREEDY_COVER_H

#include <phongsplat/splat.h>

#include "fit/fit_context.h"
#include "select/conversion.h"
#include "select/selection.h"

/* Takes candidates of the selection, and grows new ones, until every sample is covered: a greedy
 * set cover over a growing pool (Wu, Kobbelt 2004, section 4). Candidates that are taken already
 * stay. Errors: MEMORY, INTERRUPTED. */
psplat_result psplat_greedy_cover(const psplat_fit_context *context,
                                  const psplat_convert_desc *desc, psplat_selection *selection,
                                  psplat_error *error);

/* Does the same, but ends once more than `most` candidates are taken. *is_whole: whether every
 * sample is covered. */
psplat_result psplat_greedy_cover_by(const psplat_fit_context *context,
                                     const psplat_convert_desc *desc, size_t most,
                                     psplat_selection *selection, int *is_whole,
                                     psplat_error *error);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * close_seams.h - the closing of cracks between splats on both sides of a crease.
 */
#ifndef PHONGSPLAT_FINISH_CLOSE_SEAMS_H
#define PHONGSPLAT_FINISH_CLOSE_SEAMS_H

#include <phongsplat/splat.h>

#include "fit/fit_context.h"
#include "select/selection.h"

/* Moves the clip lines of all candidates out to where their planes meet those of the candidates
 * across the crease, so that no crack is left between them. All candidates must be taken. The
 * clusters of the context's samples tell where creases are. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_close_seams(const psplat_fit_context *context, psplat_selection *selection);

#endif

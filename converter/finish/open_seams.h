/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * open_seams.h - clip lines along borders of charts become seams.
 */
#ifndef PHONGSPLAT_FINISH_OPEN_SEAMS_H
#define PHONGSPLAT_FINISH_OPEN_SEAMS_H

#include <phongsplat/splat.h>

#include "fit/fit_context.h"
#include "select/selection.h"

/* Turns the clip lines of taken candidates that stand at borders of charts into seams (spec 3.6),
 * as far as what they cut off keeps the limits, or some of it, which another line then ends.
 * kernel is that of the splats. fitted has the region of each candidate before its lines were moved
 * out to close gaps: a seam stands where its line was fitted, so that the texture ends at the
 * border, since what goes on beyond leaves no gap. Candidates are on their grid already. Does
 * nothing where the surface has no borders of charts, and to materials that keep normal textures,
 * whose normals end with them. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_open_seams(const psplat_fit_context *context, const psplat_kernel *kernel,
                                const psplat_region *fitted, psplat_selection *selection);

#endif

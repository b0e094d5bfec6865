/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texture_candidates.h - the texture coordinates of the candidates that are taken.
 */
#ifndef PHONGSPLAT_FIT_TEXTURE_CANDIDATES_H
#define PHONGSPLAT_FIT_TEXTURE_CANDIDATES_H

#include <phongsplat/splat.h>

#include "fit/candidate.h"
#include "fit/fit_context.h"

#include <stddef.h>

/* Gives each taken one of count candidates the texture coordinates that fit its surroundings best,
 * as psplat_evaluate_texcoords does, where its material keeps textures, else 0. A disc of the last
 * resort gets those of the triangle of the sample that it covers or, where it covers none, of its
 * own. They are moved by the whole tiles that change nothing (psplat_kept_textures), so that those
 * of the centre are from 0 up to these. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_fit_texcoords(const psplat_fit_context *context, psplat_candidate *candidates,
                                   size_t count);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * prove_taken.h - the proof that all of each taken candidate is near the surface.
 */
#ifndef PHONGSPLAT_SELECT_PROVE_TAKEN_H
#define PHONGSPLAT_SELECT_PROVE_TAKEN_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

/* Proves each taken candidate (psplat_prove_candidate), on all cores, within the limits of proven
 * fits (psplat_conversion_set_proven). Those that change may leave holes. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_prove_taken(psplat_conversion *c);

#endif

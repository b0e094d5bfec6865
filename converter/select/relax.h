/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * relax.h - Lloyd-like relaxation: candidates around the samples for which taken ones are needed.
 */
#ifndef PHONGSPLAT_SELECT_RELAX_H
#define PHONGSPLAT_SELECT_RELAX_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

/* Adds candidates to the pool, not taken: one around the samples that each taken candidate alone
 * covers, and one around those that each two neighbours alone cover, where the limits allow it.
 * Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_relax(psplat_conversion *c);

#endif

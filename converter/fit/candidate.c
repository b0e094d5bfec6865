/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * candidate.c - a possible splat owns the list of the samples that it covers.
 */
#include "fit/candidate.h"

#include <stdlib.h>

void psplat_candidate_free(psplat_candidate *candidate) {
    free(candidate->covered);
    *candidate = (psplat_candidate){0};
}

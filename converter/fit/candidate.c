/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * candidate.c - a possible splat owns the list of the samples that it covers.
 */
#include "fit/candidate.h"

#include <stdlib.h>
#include <string.h>

int psplat_candidate_copy(const psplat_candidate *from, psplat_candidate *to) {
    size_t bytes = from->covered_count * sizeof *from->covered;
    *to = *from;
    to->covered = malloc(bytes + 1);
    if (to->covered && bytes) memcpy(to->covered, from->covered, bytes);
    return to->covered != NULL;
}

void psplat_candidate_free(psplat_candidate *candidate) {
    free(candidate->covered);
    *candidate = (psplat_candidate){0};
}

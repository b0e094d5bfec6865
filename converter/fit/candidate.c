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

int psplat_candidate_add_covered(psplat_candidate *candidate, uint32_t sample) {
    size_t count = candidate->covered_count;
    uint32_t *covered = realloc(candidate->covered, (count + 1) * sizeof *covered);
    if (!covered) return 0;
    covered[count] = sample;
    candidate->covered = covered;
    candidate->covered_count = count + 1;
    return 1;
}

void psplat_candidate_free(psplat_candidate *candidate) {
    free(candidate->covered);
    *candidate = (psplat_candidate){0};
}

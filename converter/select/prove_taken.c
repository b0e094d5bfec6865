/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * prove_taken.c - the proof that all of each taken candidate is near the surface.
 *
 * A proof takes about as long as ten evaluations. So candidates of the pool are measured at points
 * only, and those that are taken are proven, each once.
 */
#include "select/prove_taken.h"

#include "fit/candidate.h"
#include "fit/fit_context.h"
#include "fit/prove_candidate.h"
#include "select/conversion.h"
#include "select/selection.h"

static psplat_result prove(const psplat_fit_context *context, size_t index, void *user) {
    psplat_candidate *candidate = &((psplat_selection *)user)->candidates[index];
    if (!candidate->taken || candidate->proven) return PSPLAT_OK;
    return psplat_prove_candidate(context, candidate);
}

psplat_result psplat_prove_taken(psplat_conversion *c) {
    const psplat_fit_context context = psplat_conversion_context(c);
    return psplat_fit_each(&context, c->selection.count, prove, &c->selection);
}

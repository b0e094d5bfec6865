/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * convert.h - the whole conversion of a mesh to splats.
 */
#ifndef PHONGSPLAT_PIPELINE_CONVERT_H
#define PHONGSPLAT_PIPELINE_CONVERT_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/observations.h"
#include "verify/report.h"

/* Converts a mesh to splats, which psplat_splats_free frees. It is deterministic: equal input and
 * desc give equal splats. desc and report may be NULL. Errors: ARGUMENT, MEMORY, INTERRUPTED,
 * NO_SPLATS, RANGE (too large a mesh, too small a tolerance); splats is empty then. */
psplat_result psplat_convert(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                             psplat_splats *splats, psplat_report *report, psplat_error *error);

/* The same, and stores what the verification measured at each splat and sample, which
 * psplat_observations_free frees, also after an error. report must not be NULL and desc->unverified
 * not be set where observations are wanted; they are zero-initialised. */
psplat_result psplat_convert_observed(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                      psplat_splats *splats, psplat_report *report,
                                      psplat_observations *observations, psplat_error *error);

/* A conversion as far as it does not depend on precision: the surface is covered, which takes half
 * of the time, and conversions with several precisions go on from there. */
typedef struct psplat_draft psplat_draft;

/* Begins a conversion; desc->precision does not matter. mesh must outlive *draft, which the caller
 * frees with psplat_draft_destroy. Errors are those of psplat_convert; *draft is NULL then. */
psplat_result psplat_draft_create(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                  psplat_draft **draft, psplat_error *error);

/* Gives the splats and the report of psplat_convert with this precision, and leaves the draft as it
 * was, also after an error. One thread at a time may do that. Errors are those of psplat_convert.
 */
psplat_result psplat_draft_convert(psplat_draft *draft, double precision, psplat_splats *splats,
                                   psplat_report *report, psplat_error *error);

void psplat_draft_destroy(psplat_draft *draft); /* NULL is accepted */

/* Measures splats that psplat_convert made of mesh and desc, and fills what it left out of report
 * because of desc->unverified. Errors are those of psplat_convert. */
psplat_result psplat_convert_verify(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                    const psplat_splats *splats, psplat_report *report,
                                    psplat_error *error);

#endif

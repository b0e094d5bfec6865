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

/* Measures splats that psplat_convert made of mesh and desc, and fills what it left out of report
 * because of desc->unverified. Errors are those of psplat_convert. */
psplat_result psplat_convert_verify(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                    const psplat_splats *splats, psplat_report *report,
                                    psplat_error *error);

#endif

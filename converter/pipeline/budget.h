/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * budget.h - the search for the smallest tolerance whose splats keep a budget of splats or bytes.
 */
#ifndef PHONGSPLAT_PIPELINE_BUDGET_H
#define PHONGSPLAT_PIPELINE_BUDGET_H

#include <phongsplat/splat.h>

#include "export/glb_writer.h"
#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

/* The limits of a conversion's result. At least one of splats and bytes must not be 0. */
typedef struct psplat_budget {
    size_t splats;                    /* of all meshes, at most; 0: any number */
    size_t bytes;                     /* of the complete GLB, at most; 0: any number */
    const psplat_write_desc *written; /* the options of the GLB's psplat_scene_write; may be NULL */
} psplat_budget;

/* The tolerances, in %, between which psplat_scene_convert_budget searches. */
#define PSPLAT_BUDGET_COARSEST 20.0

#define PSPLAT_BUDGET_FINEST 0.01

/* Finds nearly the smallest tolerance whose splats keep the budget: it stops when 97 % of the
 * budget are used, or after some ten conversions. Returns the splats and the report (may be NULL)
 * of that tolerance as psplat_scene_convert does; the tolerance is report->total.tolerance_percent.
 * desc->tolerance_percent is the greatest tolerance tried; 0 means PSPLAT_BUDGET_COARSEST. *needed
 * becomes 0. Where even the greatest tolerance needs more than the budget, the result is
 * PSPLAT_ERROR_RANGE, and *needed is the number of splats, or of bytes where only these do not fit.
 * Other errors are ARGUMENT and those of psplat_scene_convert. */
psplat_result psplat_scene_convert_budget(const psplat_scene *scene,
                                          const psplat_convert_desc *desc,
                                          const psplat_budget *budget, psplat_splats *splats,
                                          psplat_scene_report *report, size_t *needed,
                                          psplat_error *error);

#endif

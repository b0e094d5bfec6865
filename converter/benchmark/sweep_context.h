/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sweep_context.h - what measuring takes: the source, a graphics context, and what is made of both
 * when it is first needed.
 */
#ifndef PHONGSPLAT_BENCHMARK_SWEEP_CONTEXT_H
#define PHONGSPLAT_BENCHMARK_SWEEP_CONTEXT_H

#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "views/picture_views.h"
#include "views/picture_views_parts.h"

#include <phongsplat/phongsplat.h>
#include <phongsplat/host.h>

typedef struct psplat_sweep_context {
    const char *path;    /* these four are the caller's to set */
    int size;            /* of pictures, pixels */
    int software;        /* 1: draw with Mesa's software rasteriser */
    double crease_angle; /* degrees; HUGE_VAL: no creases */
    psplat_mesh mesh;
    uint64_t source_hash; /* of the source's bytes and of what was read from them */
    size_t source_bytes;
    psplat_source_mesh *source_mesh; /* NULL until psplat_sweep_context_source_mesh */
    psplat_host *host;
    psplat_renderer *renderer;
    psplat_picture_views *views; /* NULL until psplat_sweep_context_views */
    psplat_draft *draft;         /* NULL until psplat_sweep_context_draft */
    double draft_tolerance;      /* %, of draft */
    double draft_seconds;        /* that draft took */
} psplat_sweep_context;

/* Reads the source and makes a graphics context. */
psplat_result psplat_sweep_context_open(psplat_sweep_context *context, psplat_error *error);
void psplat_sweep_context_close(psplat_sweep_context *context);
psplat_result psplat_sweep_context_source_mesh(psplat_sweep_context *context, psplat_error *error);
psplat_result psplat_sweep_context_views(psplat_sweep_context *context, psplat_error *error);

/* Makes the draft of a conversion, unless it is there already. All descs of a sweep are the same
 * but for their tolerances and precisions. Errors are those of psplat_draft_create. */
psplat_result psplat_sweep_context_draft(psplat_sweep_context *context,
                                         const psplat_convert_desc *desc, psplat_error *error);
void psplat_sweep_context_drop_draft(psplat_sweep_context *context);

#endif

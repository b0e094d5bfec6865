/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * measured_asset.h - an asset of a sweep, opened: compared by shape and by pictures.
 */
#ifndef PHONGSPLAT_BENCHMARK_MEASURED_ASSET_H
#define PHONGSPLAT_BENCHMARK_MEASURED_ASSET_H

#include "benchmark/sweep_context.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "mesh/mesh.h"
#include "table/row.h"
#include "table/setting.h"
#include "views/picture_views.h"
#include "views/picture_views_parts.h"

#include <phongsplat/phongsplat.h>

/* Zero-initialised. */
typedef struct psplat_measured_asset {
    psplat_asset *asset; /* these are of splats */
    psplat_model *model;
    psplat_renderer *renderer; /* of the context */
    psplat_mesh mesh;          /* these are of gltfpack */
    psplat_source_mesh *source_mesh;
    psplat_picture_views *views; /* draws it for timing */
} psplat_measured_asset;

/* Opens a file of splats, or of a mesh. */
psplat_result psplat_measured_asset_open(psplat_measured_asset *asset,
                                         psplat_sweep_context *context,
                                         const psplat_setting *setting, const char *path,
                                         psplat_error *error);
void psplat_measured_asset_close(psplat_measured_asset *asset);
/* Fills the values of the row that compare/shape_errors.h measures. */
psplat_result psplat_measured_asset_shape(const psplat_measured_asset *asset,
                                          psplat_sweep_context *context, int samples,
                                          psplat_row *row, psplat_error *error);
/* Fills the values of pictures (views/image_metrics.h), drawn as the row's setting says. */
psplat_result psplat_measured_asset_picture(const psplat_measured_asset *asset,
                                            psplat_sweep_context *context, psplat_row *row,
                                            psplat_error *error);

/* Writes one view of the asset and the same of the source into the folder, for the page. */
psplat_result psplat_measured_asset_show(const psplat_measured_asset *asset,
                                         psplat_sweep_context *context,
                                         const psplat_setting *setting, const char *folder,
                                         psplat_error *error);

#endif

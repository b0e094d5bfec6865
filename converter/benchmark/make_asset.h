/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * make_asset.h - the assets of a sweep: splats as `phongsplat convert` makes them, simplified
 * meshes as gltfpack does.
 */
#ifndef PHONGSPLAT_BENCHMARK_MAKE_ASSET_H
#define PHONGSPLAT_BENCHMARK_MAKE_ASSET_H

#include "benchmark/gltfpack.h"
#include "benchmark/sweep_context.h"
#include "benchmark/sweep_progress.h"
#include "table/row.h"
#include "table/setting.h"
#include "table/sweep_options.h"

#include <phongsplat/splat.h>

/* These are what making takes; all of it is the caller's. */
typedef struct psplat_asset_maker {
    psplat_sweep_context *context;
    const char *folder;
    const psplat_sweep_options *options;
    const psplat_gltfpack *gltfpack;
    psplat_sweep_progress *progress;
} psplat_asset_maker;

/* Converts or simplifies, and fills the values up to PSPLAT_COLUMN_BROKEN. Errors other than
 * MEMORY, WRITE, and INTERRUPTED are the setting's own. */
psplat_result psplat_make_asset(const psplat_asset_maker *maker, psplat_row *row,
                                psplat_error *error);
/* Returns the path of an asset in the folder, from malloc, or NULL where memory ran out. Of
 * gltfpack's two files it is that of the one that can be read (see psplat_gltfpack_run). */
char *psplat_make_asset_path(const char *folder, const psplat_setting *setting);
/* Tells whether the asset of a row exists and has the size that the row says. */
int psplat_make_asset_is_done(const char *folder, const psplat_row *row);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * measured_asset.c - an asset of a sweep, opened: compared by shape and by pictures.
 */
#include "benchmark/measured_asset.h"

#include "benchmark/sweep_context.h"
#include "compare/shape_errors.h"
#include "compare/source_mesh.h"
#include "compare/statistics.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "table/folder.h"
#include "table/row.h"
#include "table/setting.h"
#include "table/text.h"
#include "views/image_metrics.h"
#include "views/picture_views.h"

#include <phongsplat/phongsplat.h>

#include <stdlib.h>

/* The view that the page shows: from the front, 36 degrees from the left and 24 from above. */
enum { SHOWN_VIEW = 6 };

static psplat_result open_splats(psplat_measured_asset *opened, psplat_sweep_context *context,
                                 const char *path, psplat_error *error) {
    psplat_result result = psplat_asset_open(path, NULL, &opened->asset, error);
    if (result) return result;
    opened->renderer = context->renderer;
    return psplat_model_create(context->renderer, opened->asset, &opened->model, error);
}

psplat_result psplat_measured_asset_open(psplat_measured_asset *opened,
                                         psplat_sweep_context *context,
                                         const psplat_setting *setting, const char *path,
                                         psplat_error *error) {
    if (setting->competitor == PSPLAT_COMPETITOR_SPLATS)
        return open_splats(opened, context, path, error);
    psplat_result result = psplat_mesh_read(path, &opened->mesh, error);
    /* The shape is what is compared. glTF gives a file without materials a default of its own,
     * which is not that of a source without any. */
    opened->mesh.material = context->mesh.material;
    if (!context->mesh.source_material_count) opened->mesh.source_material_count = 0;
    return result ? result
                  : psplat_source_mesh_create(&opened->mesh, context->crease_angle,
                                              &opened->source_mesh, error);
}

void psplat_measured_asset_close(psplat_measured_asset *opened) {
    if (opened->renderer) psplat_model_destroy(opened->renderer, opened->model);
    psplat_asset_destroy(opened->asset);
    psplat_picture_views_destroy(opened->views);
    psplat_source_mesh_destroy(opened->source_mesh);
    psplat_mesh_free(&opened->mesh);
    *opened = (psplat_measured_asset){.asset = NULL};
}

static void fill_spread(double *values, const psplat_statistics *spread) {
    values[0] = spread->max;
    values[1] = spread->rms;
    values[2] = spread->p95;
}

static void fill_shape(psplat_row *row, const psplat_shape_errors *errors) {
    double *values = row->values;
    fill_spread(values + PSPLAT_COLUMN_DISTANCE_MAX, &errors->distance);
    fill_spread(values + PSPLAT_COLUMN_OUTWARD_MAX, &errors->outward);
    fill_spread(values + PSPLAT_COLUMN_INWARD_MAX, &errors->inward);
    fill_spread(values + PSPLAT_COLUMN_NORMAL_MAX, &errors->normal);
    fill_spread(values + PSPLAT_COLUMN_FACE_NORMAL_MAX, &errors->face_normal);
    fill_spread(values + PSPLAT_COLUMN_CREASE_NORMAL_MAX, &errors->crease_normal);
    values[PSPLAT_COLUMN_CREASE_AREA] = errors->crease_area;
    values[PSPLAT_COLUMN_CREASE_WIDTH] = errors->crease_width;
    values[PSPLAT_COLUMN_UNCOVERED_AREA] = errors->uncovered_area;
    values[PSPLAT_COLUMN_OVERHANG_AREA] = errors->overhang_area;
    values[PSPLAT_COLUMN_REACH] = errors->reach;
    values[PSPLAT_COLUMN_SOURCE_SAMPLES] = (double)errors->source_samples;
    values[PSPLAT_COLUMN_TARGET_SAMPLES] = (double)errors->target_samples;
}

psplat_result psplat_measured_asset_shape(const psplat_measured_asset *opened,
                                          psplat_sweep_context *context, int samples,
                                          psplat_row *row, psplat_error *error) {
    const psplat_shape_desc desc = {.samples = (size_t)samples};
    psplat_shape_errors errors = {0};
    psplat_result result = psplat_sweep_context_source_mesh(context, error);
    if (result) return result;
    result = opened->asset
                 ? psplat_shape_compare(context->source_mesh, opened->asset, &desc, &errors, error)
                 : psplat_shape_compare_mesh(context->source_mesh, opened->source_mesh, &desc,
                                             &errors, error);
    if (!result) fill_shape(row, &errors);
    return result;
}

static psplat_pictured pictured_of(const psplat_measured_asset *opened,
                                   const psplat_setting *setting) {
    return (psplat_pictured){.renderer = opened->renderer,
                             .model = opened->model,
                             .mode = setting->mode,
                             .mesh = opened->source_mesh};
}

psplat_result psplat_measured_asset_picture(const psplat_measured_asset *opened,
                                            psplat_sweep_context *context, psplat_row *row,
                                            psplat_error *error) {
    const psplat_pictured pictured = pictured_of(opened, &row->setting);
    psplat_picture_errors errors = {0};
    psplat_result result = psplat_sweep_context_views(context, error);
    if (!result)
        result = psplat_picture_views_compare(context->views, &pictured, -1, &errors, error);
    if (result) return result;
    double *values = row->values;
    values[PSPLAT_COLUMN_PSNR] = errors.psnr;
    values[PSPLAT_COLUMN_SSIM] = errors.ssim;
    values[PSPLAT_COLUMN_DIFFERENCE] = errors.difference;
    values[PSPLAT_COLUMN_INSIDE] = errors.inside;
    values[PSPLAT_COLUMN_DISTANT] = errors.distant;
    values[PSPLAT_COLUMN_MISSING] = errors.missing;
    values[PSPLAT_COLUMN_EXTRA] = errors.extra;
    values[PSPLAT_COLUMN_OUTLINE] = errors.missing + errors.extra;
    values[PSPLAT_COLUMN_COVERED] = (double)errors.covered;
    return PSPLAT_OK;
}

/* Draws what is pictured, or the source, into a file of the folder. */
static psplat_result draw(psplat_sweep_context *context, const psplat_pictured *pictured,
                          const char *folder, const psplat_setting *setting, psplat_error *error) {
    psplat_text name = {0};
    uint8_t *png = NULL;
    size_t size = 0;
    psplat_setting_picture(setting, &name);
    psplat_result result = psplat_text_check(&name, error);
    if (!result)
        result = psplat_picture_views_png(context->views, pictured, SHOWN_VIEW, &png, &size, error);
    if (!result) result = psplat_folder_write(folder, name.data, png, size, error);
    free(png);
    free(name.data);
    return result;
}

psplat_result psplat_measured_asset_show(const psplat_measured_asset *opened,
                                         psplat_sweep_context *context,
                                         const psplat_setting *setting, const char *folder,
                                         psplat_error *error) {
    static const psplat_setting source = {.competitor = PSPLAT_COMPETITOR_MESH};
    const psplat_pictured pictured = pictured_of(opened, setting);
    psplat_result result = psplat_sweep_context_views(context, error);
    if (!result) result = draw(context, NULL, folder, &source, error);
    return result ? result : draw(context, &pictured, folder, setting, error);
}

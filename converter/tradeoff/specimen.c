/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * specimen.c - an asset of a sweep, opened: compared by shape and by pictures.
 */
#include "tradeoff.h"

#include <math.h>

static psplat_result open_splats(psplat_specimen *specimen, psplat_workbench *bench,
                                 const char *path, psplat_error *error) {
    psplat_result result = psplat_asset_open(path, NULL, &specimen->asset, error);
    if (result) return result;
    specimen->renderer = bench->renderer;
    return psplat_model_create(bench->renderer, specimen->asset, &specimen->model, error);
}

psplat_result psplat_specimen_open(psplat_specimen *specimen, psplat_workbench *bench,
                                   const psplat_setting *setting, const char *path,
                                   psplat_error *error) {
    if (setting->contender == PSPLAT_CONTENDER_SPLATS)
        return open_splats(specimen, bench, path, error);
    psplat_result result = psplat_mesh_read(path, &specimen->mesh, error);
    /* It is the shape that is compared: a file without a material gets another format's default. */
    specimen->mesh.material = bench->mesh.material;
    return result ? result
                  : psplat_original_create(&specimen->mesh, bench->crease_angle,
                                           &specimen->original, error);
}

void psplat_specimen_close(psplat_specimen *specimen) {
    if (specimen->renderer) psplat_model_destroy(specimen->renderer, specimen->model);
    psplat_asset_destroy(specimen->asset);
    psplat_gallery_destroy(specimen->gallery);
    psplat_original_destroy(specimen->original);
    psplat_mesh_free(&specimen->mesh);
    *specimen = (psplat_specimen){.asset = NULL};
}

static void fill_spread(double *values, const psplat_spread *spread) {
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

psplat_result psplat_specimen_shape(const psplat_specimen *specimen, psplat_workbench *bench,
                                    int samples, psplat_row *row, psplat_error *error) {
    const psplat_shape_desc desc = {.samples = (size_t)samples};
    psplat_shape_errors errors = {0};
    psplat_result result = psplat_workbench_original(bench, error);
    if (result) return result;
    result =
        specimen->asset
            ? psplat_shape_compare(bench->original, specimen->asset, &desc, &errors, error)
            : psplat_shape_compare_mesh(bench->original, specimen->original, &desc, &errors, error);
    if (!result) fill_shape(row, &errors);
    return result;
}

psplat_result psplat_specimen_picture(const psplat_specimen *specimen, psplat_workbench *bench,
                                      int perceptual, psplat_row *row, psplat_error *error) {
    const psplat_exhibit exhibit = {.renderer = specimen->renderer,
                                    .model = specimen->model,
                                    .mode = row->setting.mode,
                                    .no_filter = row->setting.no_filter,
                                    .mesh = specimen->original};
    psplat_picture_errors errors = {0};
    psplat_result result = psplat_workbench_gallery(bench, error);
    if (!result)
        result = psplat_gallery_compare(bench->gallery, &exhibit, -1, perceptual, &errors, error);
    if (result) return result;
    double *values = row->values;
    values[PSPLAT_COLUMN_PSNR] = errors.psnr;
    values[PSPLAT_COLUMN_SSIM] = errors.ssim;
    values[PSPLAT_COLUMN_DIFFERENCE] = errors.difference;
    values[PSPLAT_COLUMN_INSIDE] = errors.inside;
    values[PSPLAT_COLUMN_DISTANT] = errors.distant;
    values[PSPLAT_COLUMN_MISSING] = errors.missing;
    values[PSPLAT_COLUMN_EXTRA] = errors.extra;
    values[PSPLAT_COLUMN_PERCEPTUAL] = errors.perceptual < 0 ? NAN : errors.perceptual;
    values[PSPLAT_COLUMN_COVERED] = (double)errors.covered;
    return PSPLAT_OK;
}

/* SPDX-License-Identifier: MIT
 * libFuzzer target: any bytes as an asset. Beyond what the sanitizers see, it checks the promises
 * of phongsplat.h on whatever opens. Built with -DPHONGSPLAT_FUZZ=ON and clang; start it on a
 * directory that holds minimal.gltf and a few GLBs. */
#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void demand(int condition) {
    if (!condition) abort();
}

static void check_splat(const psplat_splat *splat, uint32_t clip_count) {
    demand(splat->clip_count == clip_count);
    demand(splat->radius[0] >= splat->radius[1] && splat->radius[1] > 0);
    for (int i = 0; i < 3; ++i) demand(isfinite(splat->center[i]) && isfinite(splat->normal[i]));
    for (int i = 0; i < 4; ++i) demand(isfinite(splat->rotation[i]) && isfinite(splat->color[i]));
    for (uint32_t k = 0; k < clip_count; ++k)
        demand(splat->clip[k][0] != 0 || splat->clip[k][1] != 0);
}

static void check_batch(const psplat_batch *batch) {
    demand(batch->splat_count > 0 && batch->clip_count <= PSPLAT_MAX_CLIP_LINES);
    demand(batch->depth_tolerance >= 0 && batch->kernel.sharpness > 0);
    for (int i = 0; i < 16; ++i) demand(isfinite(batch->model[i]));
    for (int i = 0; i < 3; ++i) demand(batch->bounds_min[i] <= batch->bounds_max[i]);
    for (size_t i = 0; i < batch->splat_count; ++i)
        check_splat(&batch->splats[i], batch->clip_count);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    psplat_result result = psplat_asset_open_memory(data, size, NULL, &asset, &error);
    demand((result == PSPLAT_OK) == (asset != NULL));
    if (result) {
        demand(error.code == result && error.text[0] && error.offset <= size);
        return 0;
    }
    size_t count = psplat_asset_batch_count(asset);
    demand(count > 0);
    for (size_t i = 0; i < count && i < 16; ++i) check_batch(psplat_asset_batch(asset, i));
    double min[3], max[3];
    psplat_asset_bounds(asset, min, max);
    for (int i = 0; i < 3; ++i) demand(isfinite(min[i]) && isfinite(max[i]) && min[i] <= max[i]);
    psplat_asset_destroy(asset);
    return 0;
}

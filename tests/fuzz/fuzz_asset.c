/* SPDX-License-Identifier: MIT
 *
 * fuzz_asset.c - reads any bytes as an asset. Besides what the sanitizers check, it demands what
 * phongsplat.h promises of every asset that opens, and the bounds on memory and time for every
 * input. External buffers and images are the input itself: each uri names it whose first letter
 * does not stand for a failure. A hash of the bytes chooses which inputs are opened by name, have
 * no directory, or run out of memory.
 */
#include "fuzz.h"

#include <math.h>
#include <string.h>

typedef struct input {
    const uint8_t *data;
    size_t size;
    size_t served; /* bytes handed out as external buffers and images */
} input;

/* ---- files -------------------------------------------------------------------------------- */

/* Returns whether a path is absolute or has two dots as a part. */
static int leaves_directory(const char *path) {
    size_t length = strlen(path);
    return path[0] == '/' || strstr(path, "/../") || !strncmp(path, "../", 3) ||
           !strcmp(path, "..") || (length >= 3 && !strcmp(path + length - 3, "/.."));
}

/* dir/r..., dir/m... and dir/e... stand for files that cannot be read, take too much memory, or are
 * empty. */
static psplat_result read_input(void *user, const psplat_allocator *allocator, const char *path,
                                size_t max_size, void **data, size_t *size) {
    input *in = user;
    FUZZ_DEMAND(!strncmp(path, "dir/", 4) && !leaves_directory(path + 4));
    if (path[4] == 'r') return PSPLAT_ERROR_READ;
    if (path[4] == 'm') return PSPLAT_ERROR_MEMORY;
    if (in->size > max_size) return PSPLAT_ERROR_RANGE;
    size_t wanted = path[4] == 'e' ? 0 : in->size;
    void *copy = wanted ? allocator->resize(allocator->user, NULL, 0, wanted) : NULL;
    if (wanted && !copy) return PSPLAT_ERROR_MEMORY;
    if (wanted) memcpy(copy, in->data, wanted);
    in->served += wanted;
    *data = copy;
    *size = wanted;
    return PSPLAT_OK;
}

/* ---- promises ----------------------------------------------------------------------------- */

/* Computes FNV-1a, by Fowler, Noll and Vo. */
static uint32_t hash_of(const uint8_t *data, size_t size) {
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < size; ++i) hash = (hash ^ data[i]) * 16777619u;
    return hash ^ hash >> 16;
}

/* Checks spec 3.4: a plane where nothing says otherwise, else a surface that is not too steep,
 * which is that of the field or has no slope at its centre. */
static void check_shape(const psplat_splat *splat, const psplat_batch *batch) {
    double s[5], q = (double)splat->radius[1] / (double)splat->radius[0];
    for (int k = 0; k < 5; ++k) s[k] = (double)splat->shape[k];
    for (int k = 0; k < 5; ++k) FUZZ_DEMAND(batch->is_curved || splat->shape[k] == 0);
    FUZZ_DEMAND(batch->is_curved || !batch->has_shape);
    FUZZ_DEMAND(hypot(s[0], s[1]) + sqrt(s[2] * s[2] + s[3] * s[3] + s[4] * s[4] * (1 + q * q)) <=
                4 * (1 + 1e-12));
    if (!batch->is_curved) return;
    for (int k = 0; k < 2; ++k) FUZZ_DEMAND(!batch->has_shape || splat->shape[k] == 0);
    for (int k = 0; k < 3; ++k)
        FUZZ_DEMAND(batch->has_shape || splat->shape[2 + k] == splat->gradient[k]);
}

static void check_splat(const psplat_splat *splat, const psplat_batch *batch) {
    FUZZ_DEMAND(splat->clip_count == batch->clip_count);
    FUZZ_DEMAND(splat->radius[0] >= splat->radius[1] && splat->radius[1] > 0);
    for (int i = 0; i < 3; ++i) {
        FUZZ_DEMAND(isfinite(splat->normal[i]) && isfinite(splat->gradient[i]));
        FUZZ_DEMAND(splat->center[i] >= batch->bounds_min[i]);
        FUZZ_DEMAND(splat->center[i] <= batch->bounds_max[i]);
    }
    for (int i = 0; i < 4; ++i) {
        FUZZ_DEMAND(isfinite(splat->rotation[i]));
        FUZZ_DEMAND(splat->color[i] >= 0 && splat->color[i] <= 1);
        FUZZ_DEMAND(batch->has_color || splat->color[i] == 1);
    }
    FUZZ_DEMAND(batch->has_gamma || splat->gradient[2] == 0);
    check_shape(splat, batch);
    for (uint32_t k = 0; k < PSPLAT_MAX_CLIP_LINES; ++k) {
        int is_line = splat->clip[k][0] != 0 || splat->clip[k][1] != 0;
        FUZZ_DEMAND(is_line == (k < splat->clip_count));
        FUZZ_DEMAND(isfinite(splat->clip[k][2]));
        FUZZ_DEMAND(fabsf(splat->bend[k]) <= 4 && (is_line || splat->bend[k] == 0));
        FUZZ_DEMAND(batch->has_bends || splat->bend[k] == 0);
    }
}

static int is_part(float value) {
    return value >= 0 && value <= 1;
}

static void check_finish(const psplat_finish *finish, const psplat_batch *batch) {
    FUZZ_DEMAND(is_part(finish->occlusion) && is_part(finish->roughness));
    FUZZ_DEMAND(is_part(finish->metallic));
    FUZZ_DEMAND(batch->has_surface ||
                (finish->occlusion == 1 && finish->roughness == 1 && finish->metallic == 1));
    for (int i = 0; i < 3; ++i) {
        FUZZ_DEMAND(is_part(finish->emissive[i]));
        FUZZ_DEMAND(batch->has_emissive || finish->emissive[i] == 1);
        FUZZ_DEMAND(isfinite(finish->color_u[i]) && isfinite(finish->color_v[i]));
        FUZZ_DEMAND(batch->has_color_gradient ||
                    (finish->color_u[i] == 0 && finish->color_v[i] == 0));
    }
}

static void check_texcoord(const psplat_texcoord *t, const psplat_batch *batch) {
    const float *const terms[] = {t->at,       t->along_u,  t->along_v,
                                  t->along_uu, t->along_uv, t->along_vv};
    for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 2; ++k) {
            FUZZ_DEMAND(isfinite(terms[i][k]));
            FUZZ_DEMAND(i < 3 || batch->has_texcoord_bend || terms[i][k] == 0);
        }
}

static void check_textures(const psplat_batch *batch, const psplat_asset *asset) {
    const psplat_material *material = &batch->material;
    FUZZ_DEMAND(material->alpha_cutoff >= 0 && isfinite(material->alpha_cutoff));
    FUZZ_DEMAND(batch->has_texcoord || material->alpha_cutoff == 0);
    for (int i = 0; i < PSPLAT_TEXTURE_SLOTS; ++i) {
        const psplat_texture *texture = &material->textures[i];
        FUZZ_DEMAND(texture->image <= psplat_asset_image_count(asset));
        FUZZ_DEMAND(!texture->image || batch->has_texcoord);
        FUZZ_DEMAND(isfinite(texture->strength));
        for (int k = 0; k < 6; ++k) FUZZ_DEMAND(isfinite(texture->transform[k]));
        for (int k = 0; k < 2; ++k) FUZZ_DEMAND((unsigned)texture->wrap[k] <= PSPLAT_WRAP_MIRROR);
    }
}

/* Reads all bytes and texts of the images, so that the sanitizers see where they end. */
static void check_images(const psplat_asset *asset) {
    size_t count = psplat_asset_image_count(asset);
    FUZZ_DEMAND(!psplat_asset_get_image(asset, count));
    for (size_t i = 0; i < count; ++i) {
        const psplat_asset_image *image = psplat_asset_get_image(asset, i);
        FUZZ_DEMAND(image->data && image->size);
        FUZZ_DEMAND(hash_of(image->data, image->size) || strlen(image->name) < SIZE_MAX);
        FUZZ_DEMAND(strlen(image->mime_type) < SIZE_MAX);
    }
}

static void check_material(const psplat_material *material) {
    for (int i = 0; i < 4; ++i)
        FUZZ_DEMAND(material->base_color[i] >= 0 && material->base_color[i] <= 1);
    for (int i = 0; i < 3; ++i)
        FUZZ_DEMAND(material->emissive[i] >= 0 && isfinite(material->emissive[i]));
    FUZZ_DEMAND(material->metallic >= 0 && material->metallic <= 1);
    FUZZ_DEMAND(material->roughness >= 0 && material->roughness <= 1);
}

static void check_batch(const psplat_batch *batch, const psplat_asset *asset) {
    FUZZ_DEMAND(batch->splat_count > 0 && batch->clip_count <= PSPLAT_MAX_CLIP_LINES);
    FUZZ_DEMAND(batch->seam_lines <= batch->clip_count);
    FUZZ_DEMAND(batch->depth_tolerance >= 0 && isfinite(batch->depth_tolerance));
    FUZZ_DEMAND(batch->kernel.sharpness > 0 && isfinite(batch->kernel.sharpness));
    FUZZ_DEMAND(batch->kernel.exponent > 0 && isfinite(batch->kernel.exponent));
    FUZZ_DEMAND(batch->attribute_count >= 4 + batch->clip_count);
    check_material(&batch->material);
    check_textures(batch, asset);
    FUZZ_DEMAND((batch->has_texcoord && batch->splats) == (batch->texcoords != NULL));
    for (int i = 0; i < 16; ++i) FUZZ_DEMAND(isfinite(batch->model[i]));
    for (int i = 0; i < 3; ++i)
        FUZZ_DEMAND(isfinite(batch->bounds_min[i]) && isfinite(batch->bounds_max[i]));
    int varies = batch->has_surface || batch->has_emissive || batch->has_color_gradient;
    FUZZ_DEMAND((varies && batch->splats) == (batch->finishes != NULL));
    for (size_t i = 0; batch->splats && i < batch->splat_count; ++i) {
        check_splat(&batch->splats[i], batch);
        if (batch->finishes) check_finish(&batch->finishes[i], batch);
        if (batch->texcoords) check_texcoord(&batch->texcoords[i], batch);
    }
}

/* Plays each animation: at its ends, beyond them and in between. Where a pose is refused it is at
 * rest. */
static void check_animations(const psplat_asset *asset) {
    size_t count = psplat_asset_animation_count(asset);
    psplat_pose *pose = NULL;
    FUZZ_DEMAND(!psplat_asset_get_animation(asset, count));
    if (psplat_pose_create(asset, &pose, NULL)) return; /* the allocator may fail */
    for (size_t i = 0; i < count && i < 16; ++i) {
        const psplat_animation *animation = psplat_asset_get_animation(asset, i);
        FUZZ_DEMAND(animation->duration >= 0 && isfinite(animation->duration));
        FUZZ_DEMAND(strlen(animation->name) < SIZE_MAX);
        for (int part = -1; part < 10; ++part) {
            psplat_error error = {0};
            psplat_result result = psplat_pose_set(pose, i, animation->duration * part / 8, &error);
            FUZZ_DEMAND(!result || (result == PSPLAT_ERROR_RANGE && error.text[0]));
            for (int k = 0; k < 16; ++k) FUZZ_DEMAND(isfinite(psplat_pose_matrix(pose, 0)[k]));
        }
    }
    psplat_pose_destroy(pose);
}

/* Errors do not fall from level to level. */
static void check_levels(const psplat_asset *asset) {
    size_t count = psplat_asset_level_count(asset);
    FUZZ_DEMAND(count > 0 && !psplat_asset_get_level(asset, count));
    for (size_t i = 0; i < count; ++i) {
        const psplat_level *level = psplat_asset_get_level(asset, i), *finer = i ? level - 1 : NULL;
        FUZZ_DEMAND(level->distance >= 0 && isfinite(level->distance));
        FUZZ_DEMAND(level->normal >= 0 && level->normal <= 180);
        FUZZ_DEMAND(level->outline >= 0 && isfinite(level->outline));
        FUZZ_DEMAND(level->splat_count > 0);
        FUZZ_DEMAND(!i ||
                    (level->distance >= finer->distance && level->normal >= finer->normal &&
                     level->outline >= finer->outline && level->splat_count < finer->splat_count));
    }
}

static void check_asset(const psplat_asset *asset) {
    size_t count = psplat_asset_all_batch_count(asset), finest = psplat_asset_batch_count(asset);
    FUZZ_DEMAND(finest > 0 && finest <= count && !psplat_asset_batch(asset, count));
    check_levels(asset);
    for (size_t i = 0; i < count; ++i) {
        const psplat_batch *batch = psplat_asset_batch(asset, i), *before = i ? batch - 1 : NULL;
        FUZZ_DEMAND((batch->level == 0) == (i < finest));
        FUZZ_DEMAND(batch->level <= batch->last_level &&
                    batch->last_level < psplat_asset_level_count(asset));
        FUZZ_DEMAND(!i || before->level < batch->level ||
                    (before->level == batch->level && before->clip_count <= batch->clip_count));
        if (i < 16) check_batch(batch, asset); /* further instances share their splats */
    }
    check_images(asset);
    check_animations(asset);
    double min[3], max[3];
    psplat_asset_bounds(asset, min, max);
    for (int i = 0; i < 3; ++i)
        FUZZ_DEMAND(isfinite(min[i]) && isfinite(max[i]) && min[i] <= max[i]);
}

enum { MOST_BYTES = 1 << 16, CHUNK = 256 /* splats decoded at once by an asset that draws */ };

static int is_compressed(const input *in) {
    static const char name[] = "EXT_meshopt_compression";
    for (size_t i = 0; i + sizeof name <= in->size; ++i)
        if (!memcmp(in->data + i, name, sizeof name - 1)) return 1;
    return 0;
}

/* Returns the bound on memory. It allows 128 bytes for each byte of the file and of the files that
 * it names, tables of empty objects being the densest. Where views are compressed it adds as many
 * bytes as a file may have and the largest splats for each 8 of them. Then come the batches: a node
 * that shows a mesh takes at least 11 bytes of JSON, a primitive of splats 200, so that half a file
 * of each makes the most batches. */
static size_t memory_promised(const input *in) {
    size_t most = (in->size / 22) * (in->size / 400), limit = (size_t)1 << 18;
    size_t splat = sizeof(psplat_splat) + sizeof(psplat_finish) + sizeof(psplat_texcoord);
    size_t decoded = MOST_BYTES + MOST_BYTES / 8 * splat;
    return 4096 + 128 * (in->size + in->served) + (is_compressed(in) ? decoded : 0) +
           (most < limit ? most : limit) * sizeof(psplat_batch);
}

enum { BY_NAME, NO_DIRECTORY, NO_MEMORY, WAYS = 16, MOST_ALLOCATIONS = 32 };

static psplat_result open_one(const input *in, const psplat_asset_desc *desc, uint32_t way,
                              psplat_asset **asset, psplat_error *error) {
    if (way == BY_NAME) return psplat_asset_open("dir/asset", desc, asset, error);
    return psplat_asset_open_memory(in->data, in->size, desc, asset, error);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    uint32_t hash = hash_of(data, size), way = hash % WAYS;
    fuzz_meter meter = {.fail_at = way == NO_MEMORY ? 1 + hash / WAYS % MOST_ALLOCATIONS : 0};
    input in = {data, size, 0};
    psplat_asset_desc desc = {.allocator = fuzz_meter_allocator(&meter),
                              .files = {read_input, &in},
                              .base_path = way == NO_DIRECTORY ? NULL : "dir",
                              .max_file_size = MOST_BYTES,
                              .measures = (int)(hash >> 8 & 1),
                              .only_draws = (int)(hash >> 9 & 1)};
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    fuzz_meter_start(&meter);
    psplat_result result = open_one(&in, &desc, way, &asset, &error);
    fuzz_meter_stop(&meter, 1.0);
    FUZZ_DEMAND((result == PSPLAT_OK) == (asset != NULL));
    size_t chunk =
        CHUNK * (sizeof(psplat_splat) + sizeof(psplat_finish) + sizeof(psplat_texcoord) + 64);
    FUZZ_DEMAND(meter.peak <= memory_promised(&in) + (desc.only_draws ? chunk : 0));
    if (asset)
        check_asset(asset);
    else
        FUZZ_DEMAND(error.code == result && error.text[0] && error.offset <= size);
    psplat_asset_destroy(asset);
    FUZZ_DEMAND(meter.bytes == 0);
    return 0;
}

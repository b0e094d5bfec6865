/* SPDX-License-Identifier: MIT
 *
 * buffer.c - a buffer's bytes, loaded when first used (glTF 2.0 section 3.6.1), and those of an
 * image that has a uri of its own.
 */
#include "asset/gltf.h"
#include "core/uri.h"

#include <stdint.h>
#include <string.h>

static const char *name_of(const psplat_buffer *buffer) {
    return buffer->is_image ? "an image" : "a buffer";
}

/* What a buffer holds is copied while the asset is opened; an image is kept as it is. */
static psplat_arena *arena_of(const psplat_gltf *gltf, const psplat_buffer *buffer) {
    return buffer->is_image ? gltf->kept : gltf->scratch;
}

static psplat_result fail_buffer(const psplat_gltf *gltf, const psplat_buffer *buffer,
                                 psplat_result code, const char *reason) {
    psplat_json_value at = buffer->uri ? buffer->uri : buffer->json;
    return psplat_fail(gltf->error, code, psplat_gltf_offset(gltf, at), "%s cannot be loaded: %s",
                       name_of(buffer), reason);
}

static psplat_result load_bin(psplat_gltf *gltf, psplat_buffer *buffer, size_t *size) {
    if (buffer->is_fallback)
        return fail_buffer(gltf, buffer, PSPLAT_ERROR_UNSUPPORTED,
                           "it is an empty fallback of EXT_meshopt_compression");
    if (buffer != gltf->buffers || !gltf->bin)
        return fail_buffer(gltf, buffer, PSPLAT_ERROR_UNSUPPORTED,
                           "it has no uri and is not the BIN chunk");
    buffer->data = gltf->bin;
    buffer->origin = gltf->bin_offset;
    *size = gltf->bin_size;
    return PSPLAT_OK;
}

static psplat_result load_base64(psplat_gltf *gltf, psplat_buffer *buffer, const char *uri,
                                 size_t uri_size, size_t *size) {
    size_t start = psplat_uri_data_start(uri, uri_size), wrong = 0;
    if (start == SIZE_MAX)
        return fail_buffer(gltf, buffer, PSPLAT_ERROR_UNSUPPORTED,
                           "its data URI is not encoded as base64");
    uint8_t *data = psplat_arena_reserve(arena_of(gltf, buffer), (uri_size - start) / 4 * 3 + 2, 1);
    if (!data) return fail_buffer(gltf, buffer, PSPLAT_ERROR_MEMORY, "out of memory");
    /* The data begin after the opening quotation mark. The offset is exact unless the URI holds
     * JSON escapes, of which some tools write \/. */
    buffer->origin = psplat_gltf_offset(gltf, buffer->uri) + 1 + start;
    buffer->is_base64 = 1;
    buffer->data = data;
    *size = psplat_uri_decode_base64(uri + start, uri_size - start, data, &wrong);
    if (*size != SIZE_MAX) return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, buffer->origin + wrong,
                       "a data URI holds something that is not base64");
}

static psplat_result load_file(psplat_gltf *gltf, psplat_buffer *buffer, const char *uri,
                               size_t uri_size, size_t *size) {
    const char *reason = NULL;
    if (!gltf->base_path)
        return fail_buffer(gltf, buffer, PSPLAT_ERROR_UNSUPPORTED,
                           "no directory was given to look for files in");
    psplat_arena *arena = arena_of(gltf, buffer);
    const char *path = psplat_uri_path(gltf->base_path, uri, uri_size, arena, &reason);
    if (!path) return fail_buffer(gltf, buffer, PSPLAT_ERROR_UNSUPPORTED, reason);
    void *data = NULL;
    psplat_result result =
        gltf->files.read(gltf->files.user, &arena->allocator, path, gltf->file_budget, &data, size);
    if (!result) result = psplat_arena_adopt(arena, data, *size);
    if (result)
        return psplat_fail(gltf->error, result, psplat_gltf_offset(gltf, buffer->uri),
                           "%s cannot be loaded from %.150s: %s", name_of(buffer), path,
                           result == PSPLAT_ERROR_RANGE ? "it is larger than allowed"
                                                        : psplat_result_text(result));
    gltf->file_budget -= *size < gltf->file_budget ? *size : gltf->file_budget;
    buffer->data = data;
    buffer->path = path;
    return PSPLAT_OK;
}

psplat_result psplat_buffer_load_uri(psplat_gltf *gltf, psplat_buffer *buffer, size_t *size) {
    char *uri = NULL;
    size_t uri_size = 0;
    psplat_result result =
        psplat_json_string(&gltf->json, buffer->uri, gltf->scratch, &uri, &uri_size);
    if (result) return result;
    if (psplat_uri_data_start(uri, uri_size)) return load_base64(gltf, buffer, uri, uri_size, size);
    return load_file(gltf, buffer, uri, uri_size, size);
}

psplat_result psplat_buffer_load(psplat_gltf *gltf, psplat_buffer *buffer) {
    if (buffer->data) return PSPLAT_OK;
    size_t size = 0;
    psplat_result result =
        buffer->uri ? psplat_buffer_load_uri(gltf, buffer, &size) : load_bin(gltf, buffer, &size);
    if (result) return result;
    if (size < buffer->length)
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, buffer->json),
                           "a buffer announces %zu bytes, %zu are there", buffer->length, size);
    gltf->loaded_bytes += buffer->length;
    return PSPLAT_OK;
}

size_t psplat_buffer_offset(const psplat_buffer *buffer, size_t position) {
    if (buffer->is_decoded) return buffer->origin;
    /* Base64 writes three bytes with four digits; this is the digit in which the byte begins. */
    return buffer->origin + (buffer->is_base64 ? position / 3 * 4 + position % 3 : position);
}

/* No product or sum wraps, whatever the width of size_t. */
int psplat_gltf_decodes_too_much(const psplat_gltf *gltf, size_t bytes) {
    size_t loaded = gltf->loaded_bytes - gltf->decoded_bytes;
    if (bytes > SIZE_MAX - gltf->decoded_bytes) return 1;
    size_t all = gltf->decoded_bytes + bytes, times = all / PSPLAT_MOST_FROM_A_BYTE;
    return times > loaded || (times == loaded && all % PSPLAT_MOST_FROM_A_BYTE);
}

/* SPDX-License-Identifier: MIT
 *
 * image.c - the bytes of images (glTF 2.0 section 3.8.2), kept as they are for the host to decode.
 */
#include "asset/gltf.h"

#include <string.h>

/* ---- types -------------------------------------------------------------------------------- */

/* Returns the MIME type that the first bytes of an image show, or "". */
static const char *sniff(const uint8_t *data, size_t size) {
    static const struct {
        const char *type;
        size_t offset, size;
        const char *bytes;
    } signs[] = {{"image/png", 0, 8, "\x89PNG\r\n\x1a\n"},
                 {"image/jpeg", 0, 3, "\xff\xd8\xff"},
                 {"image/webp", 8, 4, "WEBP"},
                 {"image/ktx2", 0, 8, "\xabKTX 20\xbb"},
                 {"image/vnd-ms.dds", 0, 4, "DDS "}};
    for (size_t i = 0; i < sizeof signs / sizeof *signs; ++i)
        if (size >= signs[i].offset + signs[i].size &&
            !memcmp(data + signs[i].offset, signs[i].bytes, signs[i].size))
            return signs[i].type;
    return "";
}

/* ---- bytes -------------------------------------------------------------------------------- */

/* Views may overlap, but not so often that a small file fills the memory: images may take eight
 * times the bytes that are there. */
static psplat_result check_total(psplat_gltf *gltf, const psplat_image_entry *image, size_t size) {
    if (gltf->image_bytes / 8 + size / 8 <= gltf->loaded_bytes) {
        gltf->image_bytes += size;
        return PSPLAT_OK;
    }
    return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, image->json),
                       "the file's images use its %zu bytes of data too many times over",
                       gltf->loaded_bytes);
}

static psplat_result copy_view(psplat_gltf *gltf, const psplat_image_entry *image, size_t index,
                               psplat_asset_image *out) {
    psplat_view_range *view = &gltf->views[index];
    const psplat_buffer *buffer = NULL;
    size_t start = 0;
    psplat_result result = psplat_view_load(gltf, view, "an image", &buffer, &start);
    if (!result) result = check_total(gltf, image, view->length);
    if (result) return result;
    void *data = psplat_arena_reserve(gltf->kept, view->length, 1);
    if (!data)
        return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, psplat_gltf_offset(gltf, image->json),
                           "no memory for an image of %zu bytes", view->length);
    memcpy(data, buffer->data + start, view->length);
    out->data = data;
    out->size = view->length;
    return PSPLAT_OK;
}

static psplat_result load_uri(psplat_gltf *gltf, const psplat_image_entry *image,
                              psplat_json_value uri, psplat_asset_image *out) {
    psplat_buffer buffer = {.json = image->json, .uri = uri, .is_image = 1};
    psplat_result result = psplat_buffer_load_uri(gltf, &buffer, &out->size);
    out->data = buffer.data;
    if (buffer.path && !*out->name) out->name = buffer.path;
    return result;
}

/* ---- the image ---------------------------------------------------------------------------- */

static psplat_result parse_text(psplat_gltf *gltf, psplat_json_value value, const char *what,
                                const char **text) {
    char *string = NULL;
    size_t size = 0;
    *text = "";
    if (!value) return PSPLAT_OK;
    psplat_result result = psplat_json_expect(&gltf->json, value, PSPLAT_JSON_STRING, what);
    if (!result) result = psplat_json_string(&gltf->json, value, gltf->kept, &string, &size);
    if (!result) *text = string;
    return result;
}

/* Exactly one of uri and bufferView says where the bytes are. */
static psplat_result load(psplat_gltf *gltf, const psplat_image_entry *image, psplat_json_value uri,
                          psplat_json_value view, psplat_asset_image *out) {
    size_t index = PSPLAT_NONE;
    if (!uri == !view)
        return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, image->json),
                           "an image has either uri or bufferView");
    psplat_result result = psplat_json_expect(&gltf->json, uri, PSPLAT_JSON_STRING, "uri");
    if (!result) result = psplat_gltf_index(gltf, view, "bufferView", gltf->view_count, &index);
    if (result) return result;
    result = uri ? load_uri(gltf, image, uri, out) : copy_view(gltf, image, index, out);
    if (result || out->size) return result;
    return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, image->json),
                       "an image has no bytes");
}

static psplat_result read_image(psplat_gltf *gltf, const psplat_image_entry *image,
                                psplat_asset_image *out) {
    static const char *const names[] = {"uri", "bufferView", "mimeType", "name"};
    psplat_json_value members[4];
    psplat_result result = psplat_json_members(&gltf->json, image->json, names, 4, members);
    if (!result) result = parse_text(gltf, members[2], names[2], &out->mime_type);
    if (!result) result = parse_text(gltf, members[3], names[3], &out->name);
    if (!result) result = load(gltf, image, members[0], members[1], out);
    if (!result && !*out->mime_type) out->mime_type = sniff(out->data, out->size);
    return result;
}

psplat_result psplat_image_keep(psplat_gltf *gltf, psplat_image_entry *image) {
    if (image->kept) return PSPLAT_OK;
    if (!gltf->kept_images)
        gltf->kept_images =
            psplat_arena_take(gltf->kept, gltf->image_count, sizeof *gltf->kept_images);
    if (!gltf->kept_images)
        return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, psplat_gltf_offset(gltf, image->json),
                           "no memory for %zu images", gltf->image_count);
    psplat_result result = read_image(gltf, image, &gltf->kept_images[gltf->kept_image_count]);
    if (!result) image->kept = (uint32_t)++gltf->kept_image_count;
    return result;
}

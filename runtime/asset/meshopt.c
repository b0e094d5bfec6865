/* SPDX-License-Identifier: MIT
 *
 * meshopt.c - buffer views compressed by EXT_meshopt_compression. Only views in the mode for
 * attributes are decoded, each when first used; the mode and the bytes of views that no splat uses
 * are not looked at. Every number is checked before memory is requested. A byte of the format
 * expands to at most 64, so that a small file cannot make the reader allocate much.
 */
#include "asset/gltf.h"

#ifdef PSPLAT_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

enum {
    FIRST_BYTE = 0xa0,
    MAX_STRIDE = 256,
    MAX_BLOCK = 256, /* elements in a block */
    BLOCK_BYTES = 8192,
    GROUP = 16 /* elements in a group */
};

typedef enum filter {
    FILTER_NONE,
    FILTER_OCTAHEDRAL,
    FILTER_QUATERNION,
    FILTER_EXPONENTIAL
} filter;

/* The members of the extension's object. */
typedef struct stream {
    psplat_json_value json;
    size_t buffer, offset, length; /* where the compressed bytes are */
    size_t stride, count;
    filter filter;
} stream;

static psplat_result fail(const psplat_gltf *gltf, const stream *s, psplat_result code,
                          const char *what) {
    return psplat_fail(gltf->error, code, psplat_gltf_offset(gltf, s->json),
                       "a compressed bufferView %s", what);
}

/* ---- the object ---------------------------------------------------------------------------- */

static psplat_result parse_filter(const psplat_gltf *gltf, psplat_json_value value, stream *s) {
    static const char *const names[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
    s->filter = FILTER_NONE;
    if (!value) return PSPLAT_OK;
    psplat_result result = psplat_json_expect(&gltf->json, value, PSPLAT_JSON_STRING, "filter");
    if (result) return result;
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (psplat_json_equals(&gltf->json, value, names[i])) {
            s->filter = (filter)i;
            return PSPLAT_OK;
        }
    return fail(gltf, s, PSPLAT_ERROR_UNSUPPORTED, "has a filter that is not known");
}

static psplat_result parse_mode(const psplat_gltf *gltf, psplat_json_value value, const stream *s) {
    psplat_result result = psplat_json_expect(&gltf->json, value, PSPLAT_JSON_STRING, "mode");
    if (result || psplat_json_equals(&gltf->json, value, "ATTRIBUTES")) return result;
    return fail(gltf, s, PSPLAT_ERROR_UNSUPPORTED, "of splats is not of mode ATTRIBUTES");
}

static psplat_result parse_stream(const psplat_gltf *gltf, const psplat_view_range *view,
                                  stream *s) {
    static const char *const names[] = {"buffer", "byteLength", "byteStride", "count",
                                        "mode",   "byteOffset", "filter"};
    psplat_json_value members[7];
    const psplat_json *json = &gltf->json;
    *s = (stream){.json = view->compression};
    psplat_result result = psplat_json_members(json, s->json, names, 7, members);
    for (size_t i = 0; i < 5 && !result; ++i)
        result = psplat_gltf_require(gltf, s->json, members[i], names[i]);
    if (!result)
        result = psplat_gltf_index(gltf, members[0], names[0], gltf->buffer_count, &s->buffer);
    if (!result) result = psplat_json_integer(json, members[1], names[1], SIZE_MAX, &s->length);
    if (!result) result = psplat_json_integer(json, members[2], names[2], MAX_STRIDE, &s->stride);
    if (!result) result = psplat_json_integer(json, members[3], names[3], SIZE_MAX, &s->count);
    if (!result) result = parse_mode(gltf, members[4], s);
    if (!result) result = psplat_json_integer(json, members[5], names[5], SIZE_MAX, &s->offset);
    return result ? result : parse_filter(gltf, members[6], s);
}

/* ---- checks -------------------------------------------------------------------------------- */

static psplat_result check_layout(const psplat_gltf *gltf, const psplat_view_range *view,
                                  const stream *s) {
    if (!s->stride || s->stride % 4 || (view->stride && view->stride != s->stride))
        return fail(gltf, s, PSPLAT_ERROR_RANGE,
                    "has a byteStride that is not its own or not a multiple of 4");
    if (!s->count || view->length / s->stride != s->count || view->length % s->stride)
        return fail(gltf, s, PSPLAT_ERROR_RANGE, "has a count that does not make its byteLength");
    if ((s->filter == FILTER_OCTAHEDRAL && s->stride > 8) ||
        (s->filter == FILTER_QUATERNION && s->stride != 8))
        return fail(gltf, s, PSPLAT_ERROR_RANGE, "has a filter that is not for its byteStride");
    return PSPLAT_OK;
}

static psplat_result check_size(const psplat_gltf *gltf, const psplat_view_range *view,
                                const stream *s) {
    size_t buffer_length = gltf->buffers[s->buffer].length;
    if (s->offset > buffer_length || s->length > buffer_length - s->offset)
        return fail(gltf, s, PSPLAT_ERROR_RANGE, "leaves its buffer");
    if (view->length / PSPLAT_MOST_FROM_A_BYTE > s->length)
        return fail(gltf, s, PSPLAT_ERROR_RANGE, "announces more than its bytes can hold");
    if (view->length > gltf->file_budget)
        return fail(gltf, s, PSPLAT_ERROR_RANGE, "is larger than allowed");
    return PSPLAT_OK;
}

/* ---- decoding ------------------------------------------------------------------------------ */

#ifdef PSPLAT_MESHOPTIMIZER
static int decode(const stream *s, const uint8_t *bytes, void *out) {
    if (!s->length || bytes[0] != FIRST_BYTE ||
        meshopt_decodeVertexBuffer(out, s->count, s->stride, bytes, s->length))
        return 0;
    switch (s->filter) {
    case FILTER_NONE:
        break;
    case FILTER_OCTAHEDRAL:
        meshopt_decodeFilterOct(out, s->count, s->stride);
        break;
    case FILTER_QUATERNION:
        meshopt_decodeFilterQuat(out, s->count, s->stride);
        break;
    case FILTER_EXPONENTIAL:
        meshopt_decodeFilterExp(out, s->count, s->stride);
        break;
    }
    return 1;
}
#else
static int decode(const stream *s, const uint8_t *bytes, void *out) {
    (void)s, (void)bytes, (void)out;
    return 0;
}
#endif

/* ---- sizes ---------------------------------------------------------------------------------- */

/* Returns the bytes that a group of 16 differences takes: none, or 2, 4 or 8 bits each.
 * Where all bits of a place are 1, the difference follows as a whole byte instead. */
static size_t group_size(unsigned kind, const uint8_t *bytes) {
    size_t fixed = kind == 3 ? 16 : 4 * kind, more = 0;
    unsigned bits = 2 * kind, all = (1u << bits) - 1;
    for (size_t i = 0; (kind == 1 || kind == 2) && i < fixed; ++i)
        for (unsigned shift = 0; shift < 8; shift += bits) more += (bytes[i] >> shift & all) == all;
    return fixed + more;
}

/* Returns the bytes that one byte of each element of a block takes: two bits for each group, then
 * the groups. The stream is known to be complete, because it has been decoded. */
static size_t plane_size(const uint8_t *bytes, size_t count) {
    size_t groups = (count + GROUP - 1) / GROUP, size = (groups + 3) / 4;
    for (size_t i = 0; i < groups; ++i)
        size += group_size(bytes[i / 4] >> (2 * (i % 4)) & 3, bytes + size);
    return size;
}

static psplat_result measure(psplat_gltf *gltf, psplat_view_range *view, const stream *s,
                             const uint8_t *bytes) {
    size_t block = BLOCK_BYTES / s->stride / GROUP * GROUP;
    if (block > MAX_BLOCK) block = MAX_BLOCK;
    view->planes = psplat_arena_take(gltf->scratch, s->stride, sizeof *view->planes);
    if (!view->planes) return fail(gltf, s, PSPLAT_ERROR_MEMORY, "leaves no memory to measure it");
    ++bytes;
    for (size_t first = 0; first < s->count; first += block) {
        size_t count = s->count - first < block ? s->count - first : block;
        for (size_t i = 0; i < s->stride; ++i) {
            size_t size = plane_size(bytes, count);
            view->planes[i] += size;
            bytes += size;
        }
    }
    return PSPLAT_OK;
}

/* ---- the view ------------------------------------------------------------------------------- */

/* Several views may share their compressed bytes, but not so often that they fill the memory. */
static psplat_result check_total(const psplat_gltf *gltf, const psplat_view_range *view,
                                 const stream *s) {
    if (!psplat_gltf_decodes_too_much(gltf, view->length)) return PSPLAT_OK;
    return fail(gltf, s, PSPLAT_ERROR_RANGE, "uses the file's bytes too many times over");
}

/* Makes a buffer that owns the decoded bytes; errors in it are told at the offset of the compressed
 * ones. */
static psplat_result decode_view(psplat_gltf *gltf, psplat_view_range *view, const stream *s) {
    psplat_buffer *source = &gltf->buffers[s->buffer];
    psplat_result result = psplat_buffer_load(gltf, source);
    if (!result) result = check_total(gltf, view, s);
    if (result) return result;
    uint8_t *data = psplat_arena_reserve(gltf->scratch, view->length, 1);
    psplat_buffer *decoded = psplat_arena_take(gltf->scratch, 1, sizeof *decoded);
    if (!data || !decoded)
        return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, psplat_gltf_offset(gltf, s->json),
                           "no memory for a bufferView of %zu bytes", view->length);
    *decoded = (psplat_buffer){.json = view->json,
                               .length = view->length,
                               .data = data,
                               .origin = psplat_buffer_offset(source, s->offset),
                               .path = source->path,
                               .is_decoded = 1};
    if (!decode(s, source->data + s->offset, data))
        return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, decoded->origin,
                           "the bytes of a compressed bufferView are damaged");
    gltf->file_budget -= view->length;
    gltf->loaded_bytes += view->length;
    gltf->decoded_bytes += view->length;
    view->decoded = decoded;
    return gltf->measures ? measure(gltf, view, s, source->data + s->offset) : PSPLAT_OK;
}

psplat_result psplat_meshopt_load(psplat_gltf *gltf, psplat_view_range *view) {
    stream s;
    if (view->decoded) return PSPLAT_OK;
    psplat_result result = parse_stream(gltf, view, &s);
    if (!result) result = check_layout(gltf, view, &s);
    if (!result) result = check_size(gltf, view, &s);
    return result ? result : decode_view(gltf, view, &s);
}

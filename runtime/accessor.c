/* SPDX-License-Identifier: MIT
 * Accessors as floats (glTF 2.0 sections 3.6.2 and 3.11). */
#include "gltf.h"

#include <math.h>
#include <string.h>

static size_t component_size(size_t type) {
    switch (type) {
    case PSPLAT_BYTE:
    case PSPLAT_UNSIGNED_BYTE:
        return 1;
    case PSPLAT_SHORT:
    case PSPLAT_UNSIGNED_SHORT:
        return 2;
    default:
        return 4;
    }
}

/* Type, components and count against what the attribute may be. */
static psplat_result check_type(const psplat_gltf *gltf, const psplat_accessor *accessor,
                                const psplat_attribute_type *type, size_t count) {
    size_t at = psplat_gltf_offset(gltf, accessor->json);
    size_t component = accessor->component_type;
    int allowed = component >= PSPLAT_BYTE && component <= PSPLAT_FLOAT &&
                  (type->component_types >> (component - PSPLAT_BYTE) & 1);
    if (!allowed)
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, at,
                           "%s: component type %zu is none of those the extension allows",
                           type->name, component);
    if (component != PSPLAT_FLOAT && !accessor->normalized)
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, at,
                           "%s: integers must be normalized", type->name);
    size_t low = type->min_components, high = type->max_components;
    if (accessor->components < low || accessor->components > high)
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, at,
                           low == high ? "%s: must be VEC%zu" : "%s: must be VEC%zu or VEC%zu",
                           type->name, low, high);
    if (count != PSPLAT_NONE && accessor->count != count)
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, at,
                           "%s: has %zu elements, POSITION has %zu", type->name, accessor->count,
                           count);
    if (accessor->sparse)
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED,
                           psplat_gltf_offset(gltf, accessor->sparse),
                           "%s: sparse accessors are not read", type->name);
    if (accessor->view == PSPLAT_NONE)
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, at,
                           "%s: an accessor without bufferView holds only zeros", type->name);
    return PSPLAT_OK;
}

/* Whether count elements fit into size bytes from offset on; every term may be anything. */
static int fits(size_t offset, size_t element, size_t stride, size_t count, size_t size) {
    if (offset > size || element > size - offset) return 0;
    return count - 1 <= (size - offset - element) / stride;
}

/* Alignment and range; sums cannot overflow once the view lies within its buffer. */
static psplat_result check_range(const psplat_gltf *gltf, const psplat_accessor *accessor,
                                 const psplat_view_range *view, size_t element, size_t stride,
                                 const char *name) {
    size_t at = psplat_gltf_offset(gltf, accessor->json);
    size_t component = component_size(accessor->component_type);
    size_t buffer_length = gltf->buffers[view->buffer].length;
    if (view->offset > buffer_length || view->length > buffer_length - view->offset)
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, view->json),
                           "%s: the bufferView leaves its buffer of %zu bytes", name,
                           buffer_length);
    if (stride < element)
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, view->json),
                           "%s: byteStride %zu is less than an element's %zu bytes", name, stride,
                           element);
    if (!fits(accessor->offset, element, stride, accessor->count, view->length))
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, at,
                           "%s: %zu elements leave their bufferView of %zu bytes", name,
                           accessor->count, view->length);
    if (accessor->offset % component || (view->offset + accessor->offset) % component)
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, at,
                           "%s: its bytes are not aligned to its components", name);
    return PSPLAT_OK;
}

psplat_result psplat_reader_open(psplat_gltf *gltf, psplat_json_value value,
                                 const psplat_attribute_type *type, size_t count,
                                 psplat_reader *reader) {
    size_t index = 0;
    psplat_result result = psplat_gltf_index(gltf, value, type->name, gltf->accessor_count, &index);
    if (result) return result;
    const psplat_accessor *accessor = &gltf->accessors[index];
    result = check_type(gltf, accessor, type, count);
    if (result) return result;
    const psplat_view_range *view = &gltf->views[accessor->view];
    psplat_buffer *buffer = &gltf->buffers[view->buffer];
    size_t element = accessor->components * component_size(accessor->component_type);
    size_t stride = view->stride ? view->stride : element;
    result = check_range(gltf, accessor, view, element, stride, type->name);
    if (!result) result = psplat_buffer_load(gltf, buffer);
    if (result) return result;
    *reader = (psplat_reader){.buffer = buffer,
                              .start = view->offset + accessor->offset,
                              .stride = stride,
                              .components = accessor->components,
                              .component_type = accessor->component_type,
                              .count = accessor->count};
    return PSPLAT_OK;
}

/* ---- values: glTF 2.0 section 3.6.2.2, whatever the machine's byte order and integers are -----
 */

static float float_at(const uint8_t *bytes) {
    uint32_t bits = (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
                    (uint32_t)bytes[3] << 24;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static uint32_t short_at(const uint8_t *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8;
}

static float byte_value(const uint8_t *bytes) {
    return fmaxf((float)((int32_t)(bytes[0] ^ 0x80u) - 0x80) / 127.0f, -1.0f);
}

static float unsigned_byte_value(const uint8_t *bytes) {
    return (float)bytes[0] / 255.0f;
}

static float short_value(const uint8_t *bytes) {
    return fmaxf((float)((int32_t)(short_at(bytes) ^ 0x8000u) - 0x8000) / 32767.0f, -1.0f);
}

static float unsigned_short_value(const uint8_t *bytes) {
    return (float)short_at(bytes) / 65535.0f;
}

/* Inlined, so that the loops know value and size: reading is what opening a large asset takes. */
static inline void read_as(const psplat_reader *reader, size_t first, size_t count,
                           float (*value)(const uint8_t *), size_t size, float *values) {
    const uint8_t *bytes = reader->buffer->data + reader->start + first * reader->stride;
    size_t components = reader->components, stride = reader->stride;
    if (stride == components * size) { /* tightly packed: as one element */
        components *= count;
        count = 1;
    }
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < components; ++k)
            values[i * components + k] = value(bytes + i * stride + k * size);
}

void psplat_reader_get(const psplat_reader *reader, size_t first, size_t count, float *values) {
    switch (reader->component_type) {
    case PSPLAT_BYTE:
        read_as(reader, first, count, byte_value, 1, values);
        break;
    case PSPLAT_UNSIGNED_BYTE:
        read_as(reader, first, count, unsigned_byte_value, 1, values);
        break;
    case PSPLAT_SHORT:
        read_as(reader, first, count, short_value, 2, values);
        break;
    case PSPLAT_UNSIGNED_SHORT:
        read_as(reader, first, count, unsigned_short_value, 2, values);
        break;
    default:
        read_as(reader, first, count, float_at, 4, values);
    }
}

size_t psplat_reader_bytes(const psplat_reader *reader) {
    return reader->count * reader->components * component_size(reader->component_type);
}

/* SPDX-License-Identifier: MIT
 *
 * accessor.c - accessors of a glTF document, checked and read as floats (glTF 2.0 sections 3.6.2
 * and 3.11).
 */
#include "asset/gltf.h"

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

/* Returns whether the component type and the number of components are those of a form of the
 * attribute. */
static int is_typed(const psplat_attribute_form *form, size_t component_type) {
    return form->version && component_type >= PSPLAT_BYTE && component_type <= PSPLAT_FLOAT &&
           (form->component_types >> (component_type - PSPLAT_BYTE) & 1);
}

/* Returns the form that an accessor has, or NULL where its component type is not allowed. *low and
 * *high become the least and the greatest number of components that this component type allows, 0
 * where it allows none. */
static const psplat_attribute_form *find_form(const psplat_attribute_type *type,
                                              const psplat_accessor *accessor, size_t *low,
                                              size_t *high) {
    const psplat_attribute_form *found = NULL;
    *low = *high = 0;
    for (size_t i = 0; i < sizeof type->forms / sizeof *type->forms; ++i) {
        const psplat_attribute_form *form = &type->forms[i];
        if (!is_typed(form, accessor->component_type)) continue;
        if (!*low || form->min_components < *low) *low = form->min_components;
        if (form->max_components > *high) *high = form->max_components;
        if (accessor->components >= form->min_components &&
            accessor->components <= form->max_components)
            found = form;
    }
    return found;
}

static psplat_result check_form(const psplat_gltf *gltf, const psplat_accessor *accessor,
                                const psplat_attribute_type *type, size_t version) {
    static const char *const names[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    size_t at = psplat_gltf_offset(gltf, accessor->json), low, high;
    const psplat_attribute_form *form = find_form(type, accessor, &low, &high);
    if (!low)
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, at,
                           "%s: component type %zu is none of those that are allowed", type->name,
                           accessor->component_type);
    if (!form)
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, at,
                           low == high ? "%s: must be %s" : "%s: must be %s or %s", type->name,
                           names[low - 1], names[high - 1]);
    if (form->version > version)
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, at,
                           "%s: %s of component type %zu is of version %zu of " PSPLAT_EXTENSION
                           ", the primitive states %zu",
                           type->name, names[accessor->components - 1], accessor->component_type,
                           form->version, version);
    if (accessor->component_type != PSPLAT_FLOAT && !accessor->normalized && !form->is_plain)
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, at,
                           "%s: integers must be normalized", type->name);
    return PSPLAT_OK;
}

/* Checks what does not depend on the attribute. A count of PSPLAT_NONE accepts any count. */
static psplat_result check_elements(const psplat_gltf *gltf, const psplat_accessor *accessor,
                                    const char *name, size_t count) {
    size_t at = psplat_gltf_offset(gltf, accessor->json);
    if (count != PSPLAT_NONE && accessor->count != count)
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, at,
                           "%s: has %zu elements, POSITION has %zu", name, accessor->count, count);
    if (accessor->sparse)
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED,
                           psplat_gltf_offset(gltf, accessor->sparse),
                           "%s: sparse accessors are not read", name);
    if (accessor->view == PSPLAT_NONE)
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, at,
                           "%s: an accessor without bufferView holds only zeros", name);
    return PSPLAT_OK;
}

/* Returns whether count elements fit into size bytes from offset on. No sum overflows here, however
 * large the terms are. */
static int fits(size_t offset, size_t element, size_t stride, size_t count, size_t size) {
    if (offset > size || element > size - offset) return 0;
    return count - 1 <= (size - offset - element) / stride;
}

/* A compressed view has bytes of its own, apart from those of its buffer. */
static int is_compressed(const psplat_view_range *view) {
    return view->compression && PSPLAT_MESHOPT_IS_BUILT;
}

static psplat_result check_view(const psplat_gltf *gltf, const psplat_view_range *view,
                                const char *what) {
    size_t buffer_length = gltf->buffers[view->buffer].length;
    if (view->offset <= buffer_length && view->length <= buffer_length - view->offset)
        return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, view->json),
                       "%s: the bufferView leaves its buffer of %zu bytes", what, buffer_length);
}

/* Checks alignment and range. The sums cannot overflow once the view lies within its buffer. */
static psplat_result check_range(const psplat_gltf *gltf, const psplat_accessor *accessor,
                                 const psplat_view_range *view, size_t element, size_t stride,
                                 const char *name) {
    size_t at = psplat_gltf_offset(gltf, accessor->json);
    size_t component = component_size(accessor->component_type);
    psplat_result result = check_view(gltf, view, name);
    if (result) return result;
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

psplat_result psplat_view_load(psplat_gltf *gltf, psplat_view_range *view, const char *what,
                               const psplat_buffer **buffer, size_t *start) {
    psplat_result result = check_view(gltf, view, what);
    if (!result)
        result = is_compressed(view) ? psplat_meshopt_load(gltf, view)
                                     : psplat_buffer_load(gltf, &gltf->buffers[view->buffer]);
    *buffer = is_compressed(view) ? view->decoded : &gltf->buffers[view->buffer];
    *start = is_compressed(view) ? 0 : view->offset;
    return result;
}

psplat_result psplat_reader_open(psplat_gltf *gltf, psplat_json_value value,
                                 const psplat_attribute_type *type, size_t version, size_t count,
                                 psplat_reader *reader) {
    size_t index = 0, start = 0;
    psplat_result result = psplat_gltf_index(gltf, value, type->name, gltf->accessor_count, &index);
    if (result) return result;
    const psplat_accessor *accessor = &gltf->accessors[index];
    result = check_form(gltf, accessor, type, version);
    if (!result) result = check_elements(gltf, accessor, type->name, count);
    if (result) return result;
    psplat_view_range *view = &gltf->views[accessor->view];
    const psplat_buffer *buffer = NULL;
    size_t element = accessor->components * component_size(accessor->component_type);
    size_t stride = view->stride ? view->stride : element;
    result = check_range(gltf, accessor, view, element, stride, type->name);
    if (!result) result = psplat_view_load(gltf, view, type->name, &buffer, &start);
    if (result) return result;
    *reader = (psplat_reader){.buffer = buffer,
                              .view = view,
                              .start = start + accessor->offset,
                              .stride = stride,
                              .components = accessor->components,
                              .component_type = accessor->component_type,
                              .normalized = accessor->normalized,
                              .count = accessor->count};
    return PSPLAT_OK;
}

/* ---- values: whatever the machine's byte order and integers are ----------------------------- */

static float float_at(const uint8_t *bytes) {
    uint32_t bits = (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
                    (uint32_t)bytes[3] << 24;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static uint32_t bits_at(const uint8_t *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8;
}

static float byte_at(const uint8_t *bytes) {
    return (float)((int32_t)(bytes[0] ^ 0x80u) - 0x80);
}

static float unsigned_byte_at(const uint8_t *bytes) {
    return (float)bytes[0];
}

static float short_at(const uint8_t *bytes) {
    return (float)((int32_t)(bits_at(bytes) ^ 0x8000u) - 0x8000);
}

static float unsigned_short_at(const uint8_t *bytes) {
    return (float)bits_at(bytes);
}

typedef float read_value(const uint8_t *bytes);

/* This function and the next are inlined, so that the loops know value, size and components at
 * compile time. Opening a large asset spends most of its time reading here. */
static inline void read_elements(const uint8_t *bytes, size_t stride, size_t count,
                                 size_t components, read_value *value, size_t size, float *values) {
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < components; ++k)
            values[i * components + k] = value(bytes + i * stride + k * size);
}

static inline void read_as(const psplat_reader *reader, size_t first, size_t count,
                           read_value *value, size_t size, float *values) {
    const uint8_t *bytes = reader->buffer->data + reader->start + first * reader->stride;
    size_t stride = reader->stride, components = reader->components;
    if (stride == components * size) /* tightly packed: read as elements of one component */
        read_elements(bytes, size, count * components, 1, value, size, values);
    else if (components == 1)
        read_elements(bytes, stride, count, 1, value, size, values);
    else if (components == 2)
        read_elements(bytes, stride, count, 2, value, size, values);
    else if (components == 3)
        read_elements(bytes, stride, count, 3, value, size, values);
    else
        read_elements(bytes, stride, count, 4, value, size, values);
}

/* Returns the number that normalized integers are divided by (glTF 2.0 section 3.6.2.2), or 0 where
 * integers are taken as they are. */
static float largest_integer(const psplat_reader *reader) {
    static const float largest[] = {127, 255, 32767, 65535};
    if (!reader->normalized || reader->component_type == PSPLAT_FLOAT) return 0;
    return largest[reader->component_type - PSPLAT_BYTE];
}

void psplat_reader_get(const psplat_reader *reader, size_t first, size_t count, float *values) {
    float largest = largest_integer(reader);
    switch (reader->component_type) {
    case PSPLAT_BYTE:
        read_as(reader, first, count, byte_at, 1, values);
        break;
    case PSPLAT_UNSIGNED_BYTE:
        read_as(reader, first, count, unsigned_byte_at, 1, values);
        break;
    case PSPLAT_SHORT:
        read_as(reader, first, count, short_at, 2, values);
        break;
    case PSPLAT_UNSIGNED_SHORT:
        read_as(reader, first, count, unsigned_short_at, 2, values);
        break;
    default:
        read_as(reader, first, count, float_at, 4, values);
    }
    for (size_t i = 0; largest > 0 && i < count * reader->components; ++i) {
        float value = values[i] / largest;
        values[i] = value < -1 ? -1 : value; /* the least integer has no positive counterpart */
    }
}

size_t psplat_reader_bytes(const psplat_reader *reader) {
    return reader->count * reader->components * component_size(reader->component_type);
}

/* In a compressed view, the bytes at the same place in each element are stored together. */
size_t psplat_reader_stored(const psplat_reader *reader) {
    const psplat_view_range *view = reader->view;
    if (reader->is_streamed) return reader->streamed;
    if (!view->decoded) return psplat_reader_bytes(reader);
    if (!view->planes) return 0;
    size_t element = reader->components * component_size(reader->component_type), sum = 0;
    for (size_t i = 0; i < element; ++i) sum += view->planes[(reader->start + i) % reader->stride];
    double part = (double)reader->count * (double)reader->stride / (double)view->length;
    return (size_t)((double)sum * part + 0.5);
}

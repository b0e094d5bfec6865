/* SPDX-License-Identifier: MIT
 *
 * packed.h - documents of one primitive of splats with attributes of any type, as text with a data
 * URI: for what psplat_scene_write does not write, or should not.
 */
#ifndef PHONGSPLAT_TEST_PACKED_H
#define PHONGSPLAT_TEST_PACKED_H

#include <stddef.h>

/* Component types of glTF 2.0. */
enum {
    PACKED_BYTE = 5120,
    PACKED_UNSIGNED_BYTE = 5121,
    PACKED_SHORT = 5122,
    PACKED_UNSIGNED_SHORT = 5123,
    PACKED_FLOAT = 5126
};

enum { PACKED_MAX_ATTRIBUTES = 14 };

/* Of EXT_meshopt_compression. */
typedef enum packed_filter {
    PACKED_NONE = 0,
    PACKED_OCTAHEDRAL,
    PACKED_QUATERNION,
    PACKED_EXPONENTIAL
} packed_filter;

typedef struct packed_attribute {
    const char *name; /* without "_PSPLAT_surface_splats:", which all but three get; NULL: none */
    int component_type, components, is_plain; /* is_plain: integers are not normalized */
    const double *values; /* packed.count times components: what is stored, or where filtered what
                             it is to be, from -1 to 1 but for EXPONENTIAL */
} packed_attribute;

/* Splats that need nothing but what a test is about; see packed_default. */
typedef struct packed {
    size_t count; /* splats */
    packed_attribute attributes[PACKED_MAX_ATTRIBUTES];
    const char *extension; /* members of the extension object, "version" first */
    const char *material;  /* an object; NULL: none */
    int is_compressed;     /* each view by EXT_meshopt_compression */
    packed_filter filters[PACKED_MAX_ATTRIBUTES]; /* of the attributes, where compressed */
    size_t repeat; /* elements are stored as often, so that views are long; 0: once */
} packed;

/* One splat of version 2 at zero, of radius 1 in the plane z = 0, all floats: its first four
 * attributes are POSITION, NORMAL, ROTATION and SCALE. */
packed packed_default(void);

/* Whether documents can be compressed: the build has the library. */
int packed_can_compress(void);

/* The document (malloc, owned by the caller). */
char *packed_text(const packed *p);

#endif

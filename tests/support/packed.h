/* SPDX-License-Identifier: MIT
 *
 * packed.h - writes documents of one primitive of splats with attributes of any type, as text with
 * a data URI. They contain what psplat_scene_write does not write, or should not.
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

enum { PACKED_MAX_ATTRIBUTES = 16 };

/* Filters of EXT_meshopt_compression. */
typedef enum packed_filter {
    PACKED_NONE = 0,
    PACKED_OCTAHEDRAL,
    PACKED_QUATERNION,
    PACKED_EXPONENTIAL
} packed_filter;

typedef struct packed_attribute {
    /* Without "_PSPLAT_surface_splats:", which is added to all that are not of glTF itself; NULL
     * ends the list. */
    const char *name;
    int component_type, components, is_plain; /* is_plain: integers are not normalized */
    /* Holds packed.count times components values as they are stored; where filtered, the values to
     * be stored, from -1 to 1 except for EXPONENTIAL. */
    const double *values;
} packed_attribute;

/* Splats that need only what a test is about; see packed_default. */
typedef struct packed {
    size_t count; /* splats */
    packed_attribute attributes[PACKED_MAX_ATTRIBUTES];
    const char *extension; /* members of the extension object; "version" is the first */
    const char *material;  /* an object, or NULL */
    const char *members;   /* further members of the document, or NULL */
    int is_compressed;     /* each view is compressed with EXT_meshopt_compression */
    packed_filter filters[PACKED_MAX_ATTRIBUTES]; /* one for each attribute, where compressed */
    size_t repeat; /* how often elements are stored, so that views become long; 0: once */
} packed;

/* Returns one splat of version 2 at the origin, of radius 1 in the plane z = 0, all floats. Its
 * first four attributes are POSITION, NORMAL, ROTATION and SCALE. */
packed packed_default(void);

/* Returns whether documents can be compressed, that is, whether the build has the library. */
int packed_can_compress(void);

/* Returns the document, allocated with malloc and owned by the caller. */
char *packed_text(const packed *p);

#endif

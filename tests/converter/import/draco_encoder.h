/* SPDX-License-Identifier: MIT
 *
 * draco_encoder.h - Draco's encoder for tests, behind a C function.
 */
#ifndef PHONGSPLAT_TESTS_DRACO_ENCODER_H
#define PHONGSPLAT_TESTS_DRACO_ENCODER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { DRACO_POSITION, DRACO_NORMAL, DRACO_COLOR, DRACO_TEXCOORD, DRACO_GENERIC };

/* An attribute of all vertices, of floats or of bytes from 0 to 255, which may stand for 0 to 1. */
typedef struct draco_attribute {
    int kind, components, are_bytes, are_normalized;
    const void *values; /* vertex_count times components */
} draco_attribute;

/* A mesh. Attributes get the unique ids 0, 1 and so on. */
typedef struct draco_mesh {
    const unsigned char *triangles; /* three vertices each */
    size_t triangle_count, vertex_count;
    const draco_attribute *attributes;
    int attribute_count;
    int is_edgebreaker; /* else sequential, which keeps the order of vertices */
    int has_metadata;
    int position_bits; /* 0: not rounded */
    int is_cloud;      /* of points, without triangles */
} draco_mesh;

/* Stores the mesh in Draco's format. Returns the bytes' count, or 0 where that fails. */
size_t draco_encode(const draco_mesh *mesh, unsigned char *bytes, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif

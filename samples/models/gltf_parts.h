/* SPDX-License-Identifier: MIT
 *
 * gltf_parts.h - the pieces that glTF files are put together from: bytes, accessors, chunks.
 */
#ifndef PHONGSPLAT_SAMPLES_GLTF_PARTS_H
#define PHONGSPLAT_SAMPLES_GLTF_PARTS_H

#include "generate.h"

typedef struct bytes {
    uint8_t *data;
    size_t size;
} bytes;

void put(bytes *b, const void *data, size_t size);
void pad(bytes *b, char with); /* fills up to a multiple of 4 */
/* Appends as printf does, at most 1023 characters. */
void print(bytes *b, const char *format, ...);

/* The buffer and what describes it in the JSON. */
typedef struct scene {
    bytes buffer, views, accessors;
    int view_count, accessor_count;
} scene;

/* Makes a view of the buffer's bytes from begin to its present end and returns the view's index. A
 * target of 0 is not written. */
int add_view(scene *g, size_t begin, int target);
/* Each of these adds an accessor with a view of its own and returns the accessor's index. */
int add_positions(scene *g, const solid *s);
int add_normals(scene *g, const solid *s);
int add_texcoords(scene *g, const solid *s);
int add_colors(scene *g, const solid *s);
int add_indices(scene *g, const solid *s);
/* Adds count elements of 1, 3 or 4 components for an animation. Those of one component are times,
 * in ascending order. */
int add_numbers(scene *g, const double *values, size_t count, int components);
/* Prints accessors, bufferViews, and buffers up to its uri or its end. */
void print_tables(bytes *json, const scene *g);
/* Writes a GLB file. Unlike print_tables it adds nothing to json, which must be complete. */
int write_glb(const char *path, bytes *json, const scene *g);
int write_file(const char *path, const bytes *b);
void free_scene(scene *g, bytes *json);

#endif

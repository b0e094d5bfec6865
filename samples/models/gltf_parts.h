/* SPDX-License-Identifier: MIT
 *
 * gltf_parts.h - what the glTF files are put together from: bytes, accessors, chunks.
 */
#ifndef PHONGSPLAT_SAMPLES_GLTF_PARTS_H
#define PHONGSPLAT_SAMPLES_GLTF_PARTS_H

#include "generate.h"

typedef struct bytes {
    uint8_t *data;
    size_t size;
} bytes;

void put(bytes *b, const void *data, size_t size);
void pad(bytes *b, char with); /* to a multiple of 4 */
/* printf, at most 1023 characters. */
void print(bytes *b, const char *format, ...);

/* The buffer and what describes it in the JSON. */
typedef struct scene {
    bytes buffer, views, accessors;
    int view_count, accessor_count;
} scene;

/* What follows begin in the buffer becomes a view; target 0: of no kind. Returns its index. */
int add_view(scene *g, size_t begin, int target);
/* Each an accessor with a view of its own; they return its index. */
int add_positions(scene *g, const solid *s);
int add_texcoords(scene *g, const solid *s);
int add_colors(scene *g, const solid *s);
int add_indices(scene *g, const solid *s);
/* accessors, bufferViews, and buffers up to its uri or end. */
void print_tables(bytes *json, const scene *g);
/* Closes no brackets: json is whole. */
int write_glb(const char *path, bytes *json, const scene *g);
int write_file(const char *path, const bytes *b);
void free_scene(scene *g, bytes *json);

#endif

/* SPDX-License-Identifier: MIT
 *
 * moving.h - makes animated documents of schema/minimal.gltf: its mesh 0 has three batches of
 * splats, and a test adds the nodes, the numbers and the animations that it is about.
 *
 *     moving m = {0};
 *     int times = moving_floats(&m, (float[]){0, 1}, 2, 1);
 *     char *text = moving_text(&m, source_dir, "{\"mesh\":0}", "{\"channels\":...}");
 */
#ifndef PHONGSPLAT_TEST_MOVING_H
#define PHONGSPLAT_TEST_MOVING_H

#include <stddef.h>

enum { MOVING_FIRST = 16 }; /* the accessor that is added first */

typedef struct moving {
    unsigned char bytes[4096];
    size_t size;
    char accessors[4096];
    int count;
} moving;

/* Adds an accessor of count elements of 1, 3 or 4 components and returns its index. `more` is JSON
 * that goes into the accessor, such as ",\"normalized\":true". */
int moving_add(moving *m, const void *data, size_t size, int component_type, size_t count,
               int components, const char *more);
int moving_floats(moving *m, const float *values, size_t count, int components);

/* Returns the document, allocated with malloc and owned by the caller. `nodes` are the elements of
 * "nodes", of which the first is the root, `animations` those of "animations". */
char *moving_text(const moving *m, const char *source_dir, const char *nodes,
                  const char *animations);

#endif

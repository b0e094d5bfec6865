/* SPDX-License-Identifier: MIT
 *
 * instances.h - what the items of a frame are drawn as: instances in a vertex buffer, and calls
 * that draw many of them at once. frame.h says who makes them, instances.c how.
 */
#ifndef PHONGSPLAT_RENDERER_INSTANCES_H
#define PHONGSPLAT_RENDERER_INSTANCES_H

#include "gl/gl_api.h"

#include <phongsplat/phongsplat.h>

/* A bit of psplat_instance.first[1]: a side of the view may cut the run. */
#define PSPLAT_CUT_BY_SIDE 0x80000000u

/* A run of consecutive splats of a batch as an item places it: the vertex attributes of layout.h.
 */
typedef struct psplat_instance {
    float modelview[12]; /* object to eye space, three rows */
    float
        normal[12]; /* three rows of 3, followed by: epsilon; unstretch (psplat_placement); 1 - fade
                     */
    GLint first[2]; /* the run's first splat; that of the batch, counted over all batches, with
                       PSPLAT_CUT_BY_SIDE */
} psplat_instance;

/* Consecutive splats of a batch that may be visible: first ... end - 1. */
typedef struct psplat_run {
    GLsizei first, end;
    int is_between_sides; /* 1: the splats lie between the four sides of the view */
} psplat_run;

/* A batch as an item places it in a view. */
typedef struct psplat_placed {
    const struct psplat_model_batch *batch;
    uint64_t key;     /* those with the same key can be drawn by one call */
    unsigned options; /* PSPLAT_OPTION_ bits that the batch asks for in this place */
    int is_curved, is_culled, is_mirrored; /* as psplat_placement and draw_batch() have them */
    int is_faded;                          /* 1: weights are multiplied by the item's 1 - fade */
    size_t first_run, run_count;
    psplat_instance instance; /* of all of its splats */
} psplat_placed;

/* A call that draws `count` splats, from `first` on, of each of instance_count instances. */
typedef struct psplat_call {
    size_t placed; /* the first of those that it draws, which tells what they have in common */
    GLsizei first, count;
    size_t first_instance;
    GLsizei instance_count;
} psplat_call;

/* A list that grows. Its memory is kept between frames. */
typedef struct psplat_list {
    void *items;
    size_t count, capacity; /* items */
} psplat_list;

typedef struct psplat_instances {
    psplat_list placed;    /* of psplat_placed, in the order of items and their batches */
    psplat_list runs;      /* of psplat_run */
    psplat_list order;     /* of size_t: indices of placed, in drawing order, and room to sort */
    psplat_list instances; /* of psplat_instance */
    psplat_list calls;     /* of psplat_call, in drawing order */
    GLuint buffer;         /* holds the instances */
    size_t buffer_size;    /* bytes up to which GL has shown that it has the memory */
    int has_attributes;    /* 1: the vertex array has its attributes enabled */
} psplat_instances;

/* Makes room for one more item of `size` bytes and returns its place, or NULL where memory runs
 * out. The item is not cleared. */
void *psplat_list_add(psplat_list *list, const psplat_allocator *allocator, size_t size);

/* Sorts what has been placed, makes instances and calls of it, and uploads the instances to the
 * buffer, which stays bound. Where keeps_order is 1 splats are drawn in the order of items, batches
 * and splats, where it is 0 in any order. Errors: MEMORY, GRAPHICS. */
psplat_result psplat_instances_make(psplat_instances *in, psplat_gl *gl,
                                    const psplat_allocator *allocator, int keeps_order,
                                    psplat_error *error);

/* Lets the attributes of the bound vertex array begin at an instance of the bound buffer. */
void psplat_instances_use(psplat_instances *in, const psplat_gl *gl, size_t instance);

/* Deletes the buffer and frees all memory. */
void psplat_instances_destroy(psplat_instances *in, const psplat_gl *gl,
                              const psplat_allocator *allocator);

#endif

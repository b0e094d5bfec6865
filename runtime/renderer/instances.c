/* SPDX-License-Identifier: MIT
 *
 * instances.c - sorts what a frame's items show by what draws it, so that programs and textures
 * change from batch to batch and not from item to item, and makes of each batch few calls that draw
 * the instances of all items.
 *
 * A call draws equally many splats of each instance, but culling leaves each item runs of its own.
 * Runs are therefore cut into pieces of 2^k chunks and a rest of less than a chunk, and pieces of
 * one length, from wherever they are in a batch, are drawn together.
 */
#include "renderer/instances.h"
#include "core/chunk.h"
#include "core/memory.h"
#include "layout.h"

#include <string.h>

/* ---- lists ------------------------------------------------------------------------------- */

static int reserve(psplat_list *list, const psplat_allocator *allocator, size_t count,
                   size_t size) {
    if (count <= list->capacity) return 1;
    size_t capacity = list->capacity ? list->capacity : 16;
    while (capacity < count) capacity *= 2;
    void *items = psplat_resize(allocator, list->items, list->capacity * size, capacity * size);
    if (!items) return 0;
    list->items = items;
    list->capacity = capacity;
    return 1;
}

void *psplat_list_add(psplat_list *list, const psplat_allocator *allocator, size_t size) {
    if (!reserve(list, allocator, list->count + 1, size)) return NULL;
    return (char *)list->items + size * list->count++;
}

static void free_list(psplat_list *list, const psplat_allocator *allocator, size_t size) {
    if (list->items) psplat_resize(allocator, list->items, list->capacity * size, 0);
    memset(list, 0, sizeof *list);
}

/* ---- order ------------------------------------------------------------------------------- */

static uint64_t key_at(const psplat_instances *in, size_t index) {
    return ((const psplat_placed *)in->placed.items)[index].key;
}

/* Merges the sorted runs [0, half) and [half, count) of indices into another array. */
static void merge(const psplat_instances *in, const size_t *from, size_t half, size_t count,
                  size_t *to) {
    size_t left = 0, right = half;
    for (size_t i = 0; i < count; ++i) {
        int takes_left =
            right == count || (left < half && key_at(in, from[left]) <= key_at(in, from[right]));
        to[i] = takes_left ? from[left++] : from[right++];
    }
}

/* Sorts indices by key and keeps the order of equal ones. other has room for as many. Returns the
 * array that holds the result. */
static size_t *sort(const psplat_instances *in, size_t *order, size_t *other, size_t count) {
    for (size_t half = 1; half < count; half *= 2) {
        for (size_t at = 0; at < count; at += 2 * half) {
            size_t here = count - at < 2 * half ? count - at : 2 * half;
            merge(in, order + at, here < half ? here : half, here, other + at);
        }
        size_t *swapped = order;
        order = other;
        other = swapped;
    }
    return order;
}

/* Returns 1 where keys rise from one to the next, or where none occurs twice: then sorting would
 * bring nothing together. */
static int is_sorted(const psplat_instances *in, size_t count) {
    for (size_t i = 1; i < count; ++i)
        if (key_at(in, i) < key_at(in, i - 1)) return 0;
    return 1;
}

static int has_repeats(const psplat_instances *in, const size_t *order, size_t count) {
    for (size_t i = 1; i < count; ++i)
        if (key_at(in, order[i]) == key_at(in, order[i - 1])) return 1;
    return 0;
}

/* Returns the indices of what was placed in the order in which it is drawn, or NULL where memory
 * runs out. Where no two things can be drawn together, theirs is kept. */
static const size_t *find_order(psplat_instances *in, const psplat_allocator *allocator,
                                int keeps_order) {
    size_t count = in->placed.count;
    if (!reserve(&in->order, allocator, 2 * count, sizeof(size_t))) return NULL;
    size_t *order = in->order.items, *sorted = order;
    for (size_t i = 0; i < count; ++i) order[i] = i;
    if (keeps_order || is_sorted(in, count)) return order;
    sorted = sort(in, order, order + count, count);
    if (has_repeats(in, sorted, count)) return sorted;
    for (size_t i = 0; i < count; ++i) order[i] = i;
    return order;
}

/* ---- instances and calls ------------------------------------------------------------------- */

typedef struct maker {
    psplat_instances *in;
    const psplat_allocator *allocator;
    size_t group_calls; /* calls of earlier groups, which draw something else */
} maker;

/* Adds an instance that begins at a splat of a run. */
static int add_instance(maker *m, const psplat_placed *placed, const psplat_run *run,
                        GLsizei first) {
    psplat_instance *made = psplat_list_add(&m->in->instances, m->allocator, sizeof *made);
    if (!made) return 0;
    *made = placed->instance;
    made->first[0] = first;
    if (!run->is_between_sides)
        made->first[1] = (GLint)((GLuint)made->first[1] | PSPLAT_CUT_BY_SIDE);
    return 1;
}

/* Lets the last instance be drawn, by the last call where that draws as many splats from the same
 * one on of the instances before it. */
static int add_call(maker *m, size_t placed, GLsizei first, GLsizei count) {
    psplat_list *calls = &m->in->calls;
    size_t instance = m->in->instances.count - 1;
    if (calls->count > m->group_calls) {
        psplat_call *last = (psplat_call *)calls->items + calls->count - 1;
        if (last->first == first && last->count == count &&
            last->first_instance + (size_t)last->instance_count == instance) {
            ++last->instance_count;
            return 1;
        }
    }
    psplat_call *made = psplat_list_add(calls, m->allocator, sizeof *made);
    if (!made) return 0;
    *made = (psplat_call){placed, first, count, instance, 1};
    return 1;
}

/* Adds runs of one placed batch in their order, with an instance wherever they become ones that a
 * side of the view may cut, or cease to be. Leaves out those of a kind: 0 or 1; -1: none. */
static int add_runs(maker *m, size_t index, int without) {
    const psplat_placed *placed = (const psplat_placed *)m->in->placed.items + index;
    int kind = -1;
    for (size_t i = 0; i < placed->run_count; ++i) {
        const psplat_run run = ((const psplat_run *)m->in->runs.items)[placed->first_run + i];
        if (run.is_between_sides == without) continue;
        if (run.is_between_sides != kind && !add_instance(m, placed, &run, 0)) return 0;
        if (!add_call(m, index, run.first, run.end - run.first)) return 0;
        kind = run.is_between_sides;
    }
    return 1;
}

/* Adds the runs of one placed batch: where their order is free those of each kind together. */
static int add_whole(maker *m, size_t index, int keeps_order) {
    return keeps_order ? add_runs(m, index, -1) : add_runs(m, index, 0) && add_runs(m, index, 1);
}

/* Adds those pieces of a placed batch that have `chunks` chunks, a power of two, or with 0 the
 * rests of runs. */
static int add_pieces(maker *m, size_t index, GLsizei chunks) {
    const psplat_placed *placed = (const psplat_placed *)m->in->placed.items + index;
    for (size_t i = 0; i < placed->run_count; ++i) {
        const psplat_run run = ((const psplat_run *)m->in->runs.items)[placed->first_run + i];
        GLsizei whole = (run.end - run.first) / PSPLAT_CHUNK_SPLATS;
        GLsizei count = chunks ? chunks * PSPLAT_CHUNK_SPLATS
                               : run.end - run.first - whole * PSPLAT_CHUNK_SPLATS;
        GLsizei before = chunks ? whole - whole % (2 * chunks) : whole;
        if (chunks ? !(whole & chunks) : count == 0) continue;
        if (!add_instance(m, placed, &run, run.first + before * PSPLAT_CHUNK_SPLATS) ||
            !add_call(m, index, 0, count))
            return 0;
    }
    return 1;
}

/* Returns the greatest power of two that is at most the number of chunks of the group's longest
 * run; 0 where no run has a chunk. */
static GLsizei longest_piece(const maker *m, const size_t *order, size_t count) {
    GLsizei most = 0, piece = 1;
    for (size_t i = 0; i < count; ++i) {
        const psplat_placed *placed = (const psplat_placed *)m->in->placed.items + order[i];
        const psplat_run *runs = (const psplat_run *)m->in->runs.items + placed->first_run;
        for (size_t k = 0; k < placed->run_count; ++k) {
            GLsizei chunks = (runs[k].end - runs[k].first) / PSPLAT_CHUNK_SPLATS;
            most = chunks > most ? chunks : most;
        }
    }
    if (!most) return 0;
    while (piece <= most / 2) piece *= 2;
    return piece;
}

/* Adds what has the same key: count indices of placed batches. */
static int add_group(maker *m, const size_t *order, size_t count, int keeps_order) {
    m->group_calls = m->in->calls.count;
    if (count == 1 || keeps_order) {
        for (size_t i = 0; i < count; ++i)
            if (!add_whole(m, order[i], keeps_order)) return 0;
        return 1;
    }
    GLsizei chunks = longest_piece(m, order, count);
    for (;; chunks /= 2) {
        for (size_t i = 0; i < count; ++i)
            if (!add_pieces(m, order[i], chunks)) return 0;
        if (!chunks) return 1;
    }
}

/* The buffer is allocated anew for each upload, so that GL need not wait until the last one has
 * been read. Where the list of instances grew, GL is asked whether it had the memory: seldom,
 * because the list doubles, and in a browser the answer takes long. */
static psplat_result upload(psplat_instances *in, psplat_gl *gl, psplat_error *error) {
    size_t size = in->instances.count * sizeof(psplat_instance);
    if (!in->buffer) gl->GenBuffers(1, &in->buffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, in->buffer);
    int grows = size > in->buffer_size;
    if (grows) psplat_gl_errors(gl, NULL);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)size, in->instances.items, GL_STREAM_DRAW);
    if (!grows) return PSPLAT_OK;
    psplat_result result = psplat_gl_errors(gl, error);
    if (result == PSPLAT_OK) in->buffer_size = in->instances.capacity * sizeof(psplat_instance);
    return result;
}

psplat_result psplat_instances_make(psplat_instances *in, psplat_gl *gl,
                                    const psplat_allocator *allocator, int keeps_order,
                                    psplat_error *error) {
    maker m = {in, allocator, 0};
    in->instances.count = in->calls.count = 0;
    if (!in->placed.count) return PSPLAT_OK;
    const size_t *order = find_order(in, allocator, keeps_order);
    int has_memory = order != NULL;
    for (size_t i = 0, end; has_memory && i < in->placed.count; i = end) {
        for (end = i + 1; end < in->placed.count; ++end)
            if (key_at(in, order[end]) != key_at(in, order[i])) break;
        has_memory = add_group(&m, order + i, end - i, keeps_order);
    }
    if (!has_memory)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory to sort what items show");
    return upload(in, gl, error);
}

/* ---- the vertex array ---------------------------------------------------------------------- */

static void enable_attributes(const psplat_gl *gl) {
    for (GLuint i = 0; i < PSPLAT_ATTRIBUTE_COUNT; ++i) {
        gl->EnableVertexAttribArray(i);
        gl->VertexAttribDivisor(i, 1);
    }
}

void psplat_instances_use(psplat_instances *in, const psplat_gl *gl, size_t instance) {
    const GLsizei stride = sizeof(psplat_instance);
    size_t offset = instance * sizeof(psplat_instance);
    if (!in->has_attributes) enable_attributes(gl);
    in->has_attributes = 1;
    for (GLuint i = 0; i < PSPLAT_ATTRIBUTE_FIRST; ++i)
        gl->VertexAttribPointer(i, 4, GL_FLOAT, GL_FALSE, stride,
                                (const void *)(uintptr_t)(offset + i * 4 * sizeof(float)));
    gl->VertexAttribIPointer(PSPLAT_ATTRIBUTE_FIRST, 2, GL_INT, stride,
                             (const void *)(uintptr_t)(offset + offsetof(psplat_instance, first)));
}

void psplat_instances_destroy(psplat_instances *in, const psplat_gl *gl,
                              const psplat_allocator *allocator) {
    gl->DeleteBuffers(1, &in->buffer);
    free_list(&in->placed, allocator, sizeof(psplat_placed));
    free_list(&in->runs, allocator, sizeof(psplat_run));
    free_list(&in->order, allocator, sizeof(size_t));
    free_list(&in->instances, allocator, sizeof(psplat_instance));
    free_list(&in->calls, allocator, sizeof(psplat_call));
    memset(in, 0, sizeof *in);
}

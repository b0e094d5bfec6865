/* SPDX-License-Identifier: MIT
 *
 * host_source.h - the resolve functions that hosts have given (psplat_resolve): copies of their
 * texts, each with a number that stands for it in the keys of programs.
 */
#ifndef PHONGSPLAT_GL_HOST_SOURCE_H
#define PHONGSPLAT_GL_HOST_SOURCE_H

#include <phongsplat/phongsplat.h>

enum { PSPLAT_HOST_SOURCES = 16 }; /* that are kept, as phongsplat.h promises */

typedef struct psplat_host_source {
    char *text; /* zero-terminated; NULL: the entry is free */
    size_t size;
    int filters_light;
    unsigned number; /* > 0, never used again for another text */
    unsigned used;   /* value of psplat_host_sources.clock at its last use */
} psplat_host_source;

typedef struct psplat_host_sources {
    psplat_host_source list[PSPLAT_HOST_SOURCES];
    unsigned clock, last_number;
} psplat_host_sources;

/* Finds the entry of a resolve function, or takes a copy of its text. *dropped is the number of the
 * entry that had to make room, whose programs are of no use any more, or 0. Returns NULL where
 * memory runs out; then nothing has changed and *dropped is 0. */
const psplat_host_source *psplat_host_sources_find(psplat_host_sources *sources,
                                                   const psplat_allocator *allocator,
                                                   const psplat_resolve *resolve,
                                                   unsigned *dropped);

/* Returns the entry of a number that was not dropped. */
const psplat_host_source *psplat_host_sources_get(const psplat_host_sources *sources,
                                                  unsigned number);

/* Frees all texts. */
void psplat_host_sources_free(psplat_host_sources *sources, const psplat_allocator *allocator);

#endif

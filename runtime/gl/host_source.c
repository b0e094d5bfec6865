/* SPDX-License-Identifier: MIT
 *
 * host_source.c - keeps the texts of hosts' resolve functions; the one whose last use is longest
 * ago makes room for a new one.
 */
#include "gl/host_source.h"
#include "core/memory.h"

#include <string.h>

static int is_same(const psplat_host_source *source, const psplat_resolve *resolve) {
    return source->text && source->filters_light == !!resolve->filters_light &&
           strcmp(source->text, resolve->source) == 0;
}

static void drop(psplat_host_source *source, const psplat_allocator *allocator) {
    if (source->text) psplat_resize(allocator, source->text, source->size, 0);
    memset(source, 0, sizeof *source);
}

/* Returns a free entry, or else the one whose last use is longest ago. */
static psplat_host_source *choose(psplat_host_sources *sources) {
    psplat_host_source *chosen = &sources->list[0];
    for (int i = 0; i < PSPLAT_HOST_SOURCES; ++i) {
        psplat_host_source *source = &sources->list[i];
        if (!source->text) return source;
        if (sources->clock - source->used > sources->clock - chosen->used) chosen = source;
    }
    return chosen;
}

const psplat_host_source *psplat_host_sources_find(psplat_host_sources *sources,
                                                   const psplat_allocator *allocator,
                                                   const psplat_resolve *resolve,
                                                   unsigned *dropped) {
    *dropped = 0;
    ++sources->clock;
    for (int i = 0; i < PSPLAT_HOST_SOURCES; ++i)
        if (is_same(&sources->list[i], resolve)) {
            sources->list[i].used = sources->clock;
            return &sources->list[i];
        }
    size_t size = strlen(resolve->source) + 1;
    char *text = psplat_allocate(allocator, size, 1);
    if (!text) return NULL;
    memcpy(text, resolve->source, size);
    psplat_host_source *source = choose(sources);
    *dropped = source->number;
    drop(source, allocator);
    *source = (psplat_host_source){.text = text,
                                   .size = size,
                                   .filters_light = !!resolve->filters_light,
                                   .number = ++sources->last_number,
                                   .used = sources->clock};
    return source;
}

const psplat_host_source *psplat_host_sources_get(const psplat_host_sources *sources,
                                                  unsigned number) {
    int i = 0;
    while (i < PSPLAT_HOST_SOURCES - 1 && sources->list[i].number != number) ++i;
    return &sources->list[i];
}

void psplat_host_sources_free(psplat_host_sources *sources, const psplat_allocator *allocator) {
    for (int i = 0; i < PSPLAT_HOST_SOURCES; ++i) drop(&sources->list[i], allocator);
}

/* SPDX-License-Identifier: MIT
 *
 * background_loader.c - a thread that opens assets; see background_loader.h.
 */
#include "background_loader.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

enum { MOST = 16 };

struct loader {
    pthread_t thread;
    const char *const *paths;
    psplat_asset *assets[MOST];
    psplat_error errors[MOST];
    int count, taken;
    atomic_int opened; /* the thread no longer touches assets and errors below this index */
};

static void *open_all(void *argument) {
    loader *l = argument;
    const psplat_asset_desc desc = {.only_draws = 1};
    for (int i = 0; i < l->count; ++i) {
        psplat_asset_open(l->paths[i], &desc, &l->assets[i], &l->errors[i]);
        atomic_store(&l->opened, i + 1);
    }
    return NULL;
}

loader *loader_start(const char *const *paths, int count) {
    loader *l = count <= MOST ? calloc(1, sizeof *l) : NULL;
    if (!l) return NULL;
    l->paths = paths;
    l->count = count;
    if (pthread_create(&l->thread, NULL, open_all, l) == 0) return l;
    free(l);
    return NULL;
}

psplat_asset *loader_take(loader *l, psplat_error *error) {
    if (l->taken == atomic_load(&l->opened)) return NULL;
    *error = l->errors[l->taken];
    return l->assets[l->taken++];
}

void loader_stop(loader *l) {
    if (!l) return;
    pthread_join(l->thread, NULL);
    for (int i = l->taken; i < l->count; ++i) psplat_asset_destroy(l->assets[i]);
    free(l);
}

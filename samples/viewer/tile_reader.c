/* SPDX-License-Identifier: MIT
 *
 * tile_reader.c - worker threads that read the tiles that a tileset wants and hand them in, which
 * also decodes them, so that the window waits for neither. The lock protects the queue and two
 * flags; psplat_tiles_supply and psplat_tiles_fail may be called on any thread.
 */
#define _POSIX_C_SOURCE 200809L

#include "viewer.h"

#include <phongsplat/tiles.h>

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { THREADS = 2, CAPACITY = TILE_REQUESTS };

struct tile_reader {
    psplat_tiles *tiles;
    char *directory; /* of the tileset, with a slash at the end, or "" */
    void (*wake)(void);
    pthread_t threads[THREADS];
    int thread_count;
    pthread_mutex_t lock;
    pthread_cond_t changed; /* signals a request or is_ending */
    psplat_tile_request queue[CAPACITY];
    size_t first, count; /* of the queue, a ring */
    int has_news, is_ending;
};

/* Reads size bytes from offset on, or up to the end where size is 0. Returns NULL where they cannot
 * be read; the caller frees them. */
static uint8_t *read_range(const char *path, uint64_t offset, uint64_t *size) {
    FILE *file = fopen(path, "rb");
    uint8_t *bytes = NULL;
    if (!file) return NULL;
    if (!*size && !fseek(file, 0, SEEK_END)) {
        long end = ftell(file);
        *size = end > 0 && (uint64_t)end > offset ? (uint64_t)end - offset : 0;
    }
    if (*size && !fseek(file, (long)offset, SEEK_SET)) bytes = malloc(*size);
    if (bytes && fread(bytes, 1, *size, file) != *size) {
        free(bytes);
        bytes = NULL;
    }
    fclose(file);
    return bytes;
}

static void read_tile(const tile_reader *r, const psplat_tile_request *request) {
    size_t length = strlen(r->directory) + strlen(request->path) + 1;
    char *path = malloc(length);
    uint64_t size = request->size;
    if (path) snprintf(path, length, "%s%s", r->directory, request->path);
    uint8_t *bytes = path ? read_range(path, request->offset, &size) : NULL;
    if (bytes)
        psplat_tiles_supply(r->tiles, request->tile, bytes, size, NULL);
    else
        psplat_tiles_fail(r->tiles, request->tile, path != NULL);
    free(bytes);
    free(path);
}

static void *work(void *user) {
    tile_reader *r = user;
    pthread_mutex_lock(&r->lock);
    while (!r->is_ending) {
        if (!r->count) {
            pthread_cond_wait(&r->changed, &r->lock);
            continue;
        }
        psplat_tile_request request = r->queue[r->first];
        r->first = (r->first + 1) % CAPACITY;
        --r->count;
        pthread_mutex_unlock(&r->lock);
        read_tile(r, &request);
        pthread_mutex_lock(&r->lock);
        r->has_news = 1;
        r->wake();
    }
    pthread_mutex_unlock(&r->lock);
    return NULL;
}

tile_reader *tile_reader_create(psplat_tiles *tiles, const char *path, void (*wake)(void)) {
    tile_reader *r = calloc(1, sizeof *r);
    if (!r) return NULL;
    const char *slash = strrchr(path, '/');
    r->tiles = tiles;
    r->wake = wake;
    r->directory = strndup(path, slash ? (size_t)(slash + 1 - path) : 0);
    pthread_mutex_init(&r->lock, NULL);
    pthread_cond_init(&r->changed, NULL);
    while (r->directory && r->thread_count < THREADS &&
           !pthread_create(&r->threads[r->thread_count], NULL, work, r))
        ++r->thread_count;
    if (r->thread_count) return r;
    tile_reader_destroy(r);
    return NULL;
}

void tile_reader_destroy(tile_reader *r) {
    if (!r) return;
    pthread_mutex_lock(&r->lock);
    r->is_ending = 1;
    pthread_cond_broadcast(&r->changed);
    pthread_mutex_unlock(&r->lock);
    for (int i = 0; i < r->thread_count; ++i) pthread_join(r->threads[i], NULL);
    pthread_cond_destroy(&r->changed);
    pthread_mutex_destroy(&r->lock);
    free(r->directory);
    free(r);
}

void tile_reader_feed(tile_reader *r) {
    psplat_tile_request requests[CAPACITY];
    pthread_mutex_lock(&r->lock);
    size_t room = CAPACITY - r->count;
    pthread_mutex_unlock(&r->lock);
    /* Only this thread adds to the queue, so that the room does not shrink. */
    size_t count = psplat_tiles_wanted(r->tiles, requests, room);
    pthread_mutex_lock(&r->lock);
    for (size_t i = 0; i < count; ++i) r->queue[(r->first + r->count++) % CAPACITY] = requests[i];
    pthread_cond_broadcast(&r->changed);
    pthread_mutex_unlock(&r->lock);
}

int tile_reader_has_news(tile_reader *r) {
    pthread_mutex_lock(&r->lock);
    int has_news = r->has_news;
    r->has_news = 0;
    pthread_mutex_unlock(&r->lock);
    return has_news;
}

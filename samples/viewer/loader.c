/* SPDX-License-Identifier: MIT
 *
 * loader.c - a worker thread that opens assets and checks whether their files change, so that the
 * window never waits for a disk. The lock protects what both threads use: the request, the finished
 * loads and two flags. Only the worker uses the list of watched files.
 */
#define _POSIX_C_SOURCE 200809L

#include "viewer.h"

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* The time between two checks of the files. A file is loaded when two checks find it the same, so
 * that a file that is still being written is left alone. */
enum { POLL_MILLISECONDS = 100 };

/* How long tiles take to replace others. */
#define FADE_SECONDS 0.25

/* What the file system says about a file; all zeros where there is no such file. */
typedef struct stamp {
    long long seconds, nanoseconds, size;
    unsigned long long inode;
} stamp;

typedef struct watched_file {
    char *path;
    stamp opened; /* when the file was last opened */
    stamp seen;   /* at the latest check */
} watched_file;

typedef struct path_list {
    char **paths;
    size_t count;
} path_list;

struct loader {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t changed; /* signals request, wants_reload or is_ending */
    void (*wake)(void);
    path_list request; /* count 0: no request */
    load *finished;    /* oldest first */
    int is_opening;    /* a requested set is being opened */
    int wants_reload;
    int is_ending;
    size_t max_bytes;      /* of tiles */
    watched_file *watched; /* used by the worker alone */
    size_t watched_count;
};

/* ---- paths and stamps --------------------------------------------------------------------- */

static void free_paths(path_list *list) {
    for (size_t i = 0; i < list->count; ++i) free(list->paths[i]);
    free(list->paths);
    *list = (path_list){0};
}

/* Leaves out paths that occur twice, as they would put the same model twice in one place. */
static int copy_paths(const char *const *paths, size_t count, path_list *list) {
    *list = (path_list){.paths = calloc(count, sizeof *list->paths)};
    if (!list->paths) return 0;
    for (size_t i = 0; i < count; ++i) {
        size_t k = 0;
        while (k < list->count && strcmp(list->paths[k], paths[i])) ++k;
        if (k < list->count) continue;
        list->paths[list->count] = strdup(paths[i]);
        if (!list->paths[list->count++]) return free_paths(list), 0;
    }
    return 1;
}

static stamp stamp_of(const char *path) {
    struct stat status;
    char tileset[MAX_PATH];
    if (tileset_path(path, tileset, sizeof tileset)) path = tileset;
    if (stat(path, &status)) return (stamp){0};
    return (stamp){status.st_mtim.tv_sec, status.st_mtim.tv_nsec, status.st_size, status.st_ino};
}

static int stamps_equal(const stamp *a, const stamp *b) {
    return a->seconds == b->seconds && a->nanoseconds == b->nanoseconds && a->size == b->size &&
           a->inode == b->inode;
}

/* ---- opening ------------------------------------------------------------------------------ */

/* The runtime cannot tell why a file is not readable, and reading a pipe may never end; so files
 * are checked first. */
psplat_result loader_check(const char *path, psplat_error *error) {
    struct stat status;
    char tileset[MAX_PATH];
    int is_directory = !stat(path, &status) && S_ISDIR(status.st_mode);
    if (tileset_path(path, tileset, sizeof tileset)) path = tileset;
    if (is_directory && access(path, F_OK))
        return psplat_fail(error, PSPLAT_ERROR_READ, 0, "is a directory without tileset.json");
    if (stat(path, &status) || access(path, R_OK))
        return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s", strerror(errno));
    if (!S_ISREG(status.st_mode)) return psplat_fail(error, PSPLAT_ERROR_READ, 0, "is not a file");
    return PSPLAT_OK;
}

static void open_tileset(const char *path, size_t max_bytes, loaded_file *file) {
    const psplat_tiles_desc desc = {
        .max_bytes = max_bytes, .max_requests = TILE_REQUESTS, .fade_seconds = FADE_SECONDS};
    double min[3], max[3], square = 0;
    if (psplat_tiles_open(&desc, path, &file->tiles, &file->error)) return;
    psplat_tiles_bounds(file->tiles, min, max);
    for (int i = 0; i < 3; ++i) {
        file->bounds.center[i] = 0.5 * (min[i] + max[i]);
        square += 0.25 * (max[i] - min[i]) * (max[i] - min[i]);
    }
    file->bounds.radius = sqrt(square);
}

static int open_file(const char *path, size_t max_bytes, loaded_file *file) {
    char tileset[MAX_PATH];
    file->path = strdup(path);
    if (!file->path) return 0;
    if (loader_check(path, &file->error)) return 1;
    if (tileset_path(path, tileset, sizeof tileset))
        return open_tileset(tileset, max_bytes, file), 1;
    if (psplat_asset_open(path, NULL, &file->asset, &file->error)) return 1;
    if (decoded_images_make(file)) {
        decoded_images_free(file);
        psplat_asset_destroy(file->asset);
        file->asset = NULL;
        return 1;
    }
    file->bounds = bounds_of(file->asset);
    for (size_t i = 0; i < psplat_asset_batch_count(file->asset); ++i)
        file->splat_count += psplat_asset_batch(file->asset, i)->splat_count;
    return 1;
}

/* Returns NULL when out of memory; the models that are shown then stay. */
static load *open_files(const path_list *list, size_t max_bytes, int is_reload) {
    load *result = calloc(1, sizeof *result);
    if (!result) return NULL;
    result->is_reload = is_reload;
    result->files = calloc(list->count, sizeof *result->files);
    if (result->files)
        while (result->count < list->count &&
               open_file(list->paths[result->count], max_bytes, &result->files[result->count]))
            ++result->count;
    if (result->files && result->count == list->count) return result;
    load_destroy(result);
    return NULL;
}

void load_destroy(load *l) {
    if (!l) return;
    for (size_t i = 0; i < l->count; ++i) {
        decoded_images_free(&l->files[i]);
        psplat_asset_destroy(l->files[i].asset);
        psplat_tiles_destroy(l->files[i].tiles, NULL); /* nothing of it is uploaded yet */
        free(l->files[i].path);
    }
    free(l->files);
    free(l);
}

/* ---- watching ----------------------------------------------------------------------------- */

static void free_watched(loader *l) {
    for (size_t i = 0; i < l->watched_count; ++i) free(l->watched[i].path);
    free(l->watched);
    l->watched = NULL;
    l->watched_count = 0;
}

static int has_success(const load *opened) {
    for (size_t i = 0; i < opened->count; ++i)
        if (opened->files[i].asset || opened->files[i].tiles) return 1;
    return 0;
}

/* Takes over the paths of list. The stamps were taken before the files were opened. */
static void watch(loader *l, path_list *list, const stamp *stamps) {
    watched_file *files = calloc(list->count, sizeof *files);
    if (!files) return;
    free_watched(l);
    for (size_t i = 0; i < list->count; ++i)
        files[i] = (watched_file){list->paths[i], stamps[i], stamps[i]};
    l->watched = files;
    l->watched_count = list->count;
    free(list->paths);
    *list = (path_list){0};
}

/* Returns the paths, not copied, of files that have changed since they were opened and have come to
 * rest. */
static path_list changed_files(loader *l, int all) {
    path_list list = {.paths = calloc(l->watched_count ? l->watched_count : 1, sizeof *list.paths)};
    for (size_t i = 0; i < l->watched_count && list.paths; ++i) {
        watched_file *file = &l->watched[i];
        stamp now = stamp_of(file->path);
        int is_new = !stamps_equal(&now, &file->opened), rests = stamps_equal(&now, &file->seen);
        file->seen = now;
        if (!all && !(is_new && rests)) continue;
        file->opened = now;
        list.paths[list.count++] = file->path;
    }
    return list;
}

/* ---- the worker --------------------------------------------------------------------------- */

static void finish(loader *l, load *opened) {
    if (opened) {
        load **last = &l->finished;
        while (*last) last = &(*last)->next;
        *last = opened;
    }
    l->wake();
}

/* This and the next function are called, and return, with the lock held. */
static void open_request(loader *l) {
    path_list list = l->request;
    l->request = (path_list){0};
    l->is_opening = 1;
    pthread_mutex_unlock(&l->lock);
    stamp *stamps = calloc(list.count, sizeof *stamps);
    for (size_t i = 0; i < list.count && stamps; ++i) stamps[i] = stamp_of(list.paths[i]);
    load *opened = open_files(&list, l->max_bytes, 0);
    if (stamps && opened && has_success(opened)) watch(l, &list, stamps);
    free_paths(&list);
    free(stamps);
    pthread_mutex_lock(&l->lock);
    l->is_opening = 0;
    finish(l, opened);
}

static void open_changed(loader *l) {
    int all = l->wants_reload;
    l->wants_reload = 0;
    pthread_mutex_unlock(&l->lock);
    path_list list = changed_files(l, all);
    load *opened = list.count ? open_files(&list, l->max_bytes, 1) : NULL;
    free(list.paths);
    pthread_mutex_lock(&l->lock);
    if (opened) finish(l, opened);
}

static void wait_a_moment(loader *l) {
    struct timespec end;
    clock_gettime(CLOCK_REALTIME, &end);
    end.tv_nsec += POLL_MILLISECONDS * 1000000L;
    end.tv_sec += end.tv_nsec / 1000000000L;
    end.tv_nsec %= 1000000000L;
    pthread_cond_timedwait(&l->changed, &l->lock, &end);
}

static void *work(void *user) {
    loader *l = user;
    pthread_mutex_lock(&l->lock);
    while (!l->is_ending) {
        if (l->request.count)
            open_request(l);
        else
            open_changed(l);
        if (!l->request.count && !l->wants_reload && !l->is_ending) wait_a_moment(l);
    }
    pthread_mutex_unlock(&l->lock);
    return NULL;
}

/* ---- the main thread's side ---------------------------------------------------------------- */

loader *loader_create(void (*wake)(void), size_t max_bytes) {
    loader *l = calloc(1, sizeof *l);
    if (!l) return NULL;
    l->wake = wake;
    l->max_bytes = max_bytes;
    pthread_mutex_init(&l->lock, NULL);
    pthread_cond_init(&l->changed, NULL);
    if (!pthread_create(&l->thread, NULL, work, l)) return l;
    pthread_cond_destroy(&l->changed);
    pthread_mutex_destroy(&l->lock);
    free(l);
    return NULL;
}

void loader_destroy(loader *l) {
    if (!l) return;
    pthread_mutex_lock(&l->lock);
    l->is_ending = 1;
    pthread_cond_signal(&l->changed);
    pthread_mutex_unlock(&l->lock);
    pthread_join(l->thread, NULL);
    for (load *next; l->finished; l->finished = next) {
        next = l->finished->next;
        load_destroy(l->finished);
    }
    free_paths(&l->request);
    free_watched(l);
    pthread_cond_destroy(&l->changed);
    pthread_mutex_destroy(&l->lock);
    free(l);
}

int loader_open(loader *l, const char *const *paths, size_t count) {
    path_list list;
    if (!copy_paths(paths, count, &list)) return 0;
    pthread_mutex_lock(&l->lock);
    free_paths(&l->request);
    l->request = list;
    pthread_cond_signal(&l->changed);
    pthread_mutex_unlock(&l->lock);
    return 1;
}

void loader_reload(loader *l) {
    pthread_mutex_lock(&l->lock);
    l->wants_reload = 1;
    pthread_cond_signal(&l->changed);
    pthread_mutex_unlock(&l->lock);
}

int loader_is_busy(loader *l) {
    pthread_mutex_lock(&l->lock);
    int is_busy = l->is_opening || l->request.count;
    pthread_mutex_unlock(&l->lock);
    return is_busy;
}

load *loader_take(loader *l) {
    pthread_mutex_lock(&l->lock);
    load *taken = l->finished;
    if (taken) l->finished = taken->next;
    pthread_mutex_unlock(&l->lock);
    if (taken) taken->next = NULL;
    return taken;
}

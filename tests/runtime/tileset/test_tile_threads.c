/* SPDX-License-Identifier: MIT
 *
 * test_tile_threads.c - tests that tiles are supplied by several threads while frames go on.
 * tests/tsan.sh looks for races here.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <stdlib.h>
#include <cmocka.h>

#include "tiles_fixture.h"

#include <pthread.h>
#include <sched.h>

enum { THREADS = 4, QUEUE = 64 };

/* Requests on their way to the threads, and an allocator that all of them use. */
typedef struct pool {
    const world *w;
    psplat_tiles *tiles;
    pthread_mutex_t mutex;
    pthread_cond_t wake, served;
    psplat_tile_request queue[QUEUE];
    size_t count, supplied, refused, pending; /* pending: not served yet */
    uint32_t random;
    int is_over;
    _Atomic size_t bytes; /* of the allocator */
} pool;

static void *pool_resize(void *user, void *memory, size_t old_size, size_t new_size) {
    pool *p = user;
    atomic_fetch_add(&p->bytes, new_size - old_size);
    if (new_size) return realloc(memory, new_size);
    free(memory);
    return NULL;
}

/* Takes a request out of the queue, any of them. Returns 0 where there is none any more. */
static int take(pool *p, psplat_tile_request *request, float *chance) {
    pthread_mutex_lock(&p->mutex);
    while (!p->count && !p->is_over) pthread_cond_wait(&p->wake, &p->mutex);
    int is_there = p->count > 0;
    *chance = scene_random(&p->random);
    if (is_there) {
        size_t at = (size_t)(scene_random(&p->random) * (float)p->count) % p->count;
        *request = p->queue[at];
        p->queue[at] = p->queue[--p->count];
    }
    pthread_mutex_unlock(&p->mutex);
    return is_there;
}

static void *serve(void *user) {
    pool *p = user;
    psplat_tile_request request;
    float chance;
    while (take(p, &request, &chance)) {
        psplat_error error = {0};
        if (chance < 0.1f) sched_yield();
        psplat_result result = PSPLAT_ERROR_READ;
        if (chance < 0.05f)
            psplat_tiles_fail(p->tiles, request.tile, 0);
        else
            result = world_supply(p->w, p->tiles, request.tile, request.path, &error);
        pthread_mutex_lock(&p->mutex);
        p->supplied += result == PSPLAT_OK;
        p->refused += result == PSPLAT_ERROR_MEMORY;
        --p->pending;
        pthread_cond_signal(&p->served);
        pthread_mutex_unlock(&p->mutex);
    }
    return NULL;
}

static void put(pool *p, const psplat_tile_request *requests, size_t count) {
    pthread_mutex_lock(&p->mutex);
    for (size_t i = 0; i < count; ++i) p->queue[p->count++] = requests[i];
    p->pending += count;
    pthread_cond_broadcast(&p->wake);
    pthread_mutex_unlock(&p->mutex);
}

/* Waits until the threads have served everything, however few turns they get. */
static void wait_for_all(pool *p) {
    pthread_mutex_lock(&p->mutex);
    while (p->pending) pthread_cond_wait(&p->served, &p->mutex);
    pthread_mutex_unlock(&p->mutex);
}

static void fly(pool *p, size_t max_bytes, int frames) {
    pthread_t threads[THREADS];
    for (int i = 0; i < THREADS; ++i) assert_int_equal(pthread_create(&threads[i], 0, serve, p), 0);
    for (int frame = 0; frame < frames; ++frame) {
        psplat_tile_request requests[QUEUE / 2];
        psplat_view view = {.width = 640, .height = 480};
        double angle = 0.02 * frame;
        view_perspective(&view, 0.5, 0.01, 100);
        view_look_at(&view, (double[]){6 * cos(angle), 1, 4 * sin(angle)}, (double[]){0, 0, 0});
        const psplat_tiles_view v = {.view = &view, .pixels = 4};
        assert_int_equal(psplat_tiles_select(p->tiles, &v, NULL), PSPLAT_OK);
        put(p, requests, psplat_tiles_wanted(p->tiles, requests, QUEUE / 2));
        assert_int_equal(psplat_tiles_upload(p->tiles, NULL, 100000, NULL), PSPLAT_OK);
        psplat_tiles_state s = psplat_tiles_describe(p->tiles);
        assert_true(s.bytes <= max_bytes);
        if (frame % 8 == 7) wait_for_all(p);
        sched_yield();
    }
    pthread_mutex_lock(&p->mutex);
    p->is_over = 1;
    pthread_cond_broadcast(&p->wake);
    pthread_mutex_unlock(&p->mutex);
    for (int i = 0; i < THREADS; ++i) pthread_join(threads[i], NULL);
}

static void run(size_t max_bytes, int frames) {
    world w = {.depth = 9, .external_depth = 4, .missing = 0.15f, .early = 0.05f, .has_extras = 1};
    world_make_tree(&w);
    pool p = {.w = &w,
              .mutex = PTHREAD_MUTEX_INITIALIZER,
              .wake = PTHREAD_COND_INITIALIZER,
              .served = PTHREAD_COND_INITIALIZER,
              .random = 2463534242u};
    p.tiles = world_open(&w, (psplat_tiles_desc){.allocator = {pool_resize, &p},
                                                 .max_bytes = max_bytes,
                                                 .max_requests = QUEUE / 2});
    fly(&p, max_bytes, frames);
    psplat_tiles_state s = psplat_tiles_describe(p.tiles);
    print_message("%zu tiles supplied by %d threads, %zu not for want of room; %zu of %zu there\n",
                  p.supplied, THREADS, p.refused, s.resident, s.tiles);
    assert_true(p.supplied > 20 && s.drawn > 0);
    psplat_tiles_destroy(p.tiles, NULL);
    assert_int_equal(atomic_load(&p.bytes), 0);
    world_free(&w);
}

static void test_threads_supply(void **state) {
    (void)state;
    run((size_t)64 << 20, 600);
    run(1200000, 600);
}

int test_tile_threads_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_threads_supply)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

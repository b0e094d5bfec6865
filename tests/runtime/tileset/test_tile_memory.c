/* SPDX-License-Identifier: MIT
 *
 * test_tile_memory.c - tests what is in memory: budgets with a host that fails, delays and
 * reorders, eviction, cross-fades, failing allocators, requests that are handled wrongly.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <stdlib.h>
#include <cmocka.h>

#include "tiles_fixture.h"

#include "tileset/show.h"

static world make_world(int depth, int external_depth) {
    world w = {.depth = depth,
               .external_depth = external_depth,
               .missing = 0.15f,
               .early = 0.05f,
               .has_extras = 1};
    world_make_tree(&w);
    return w;
}

/* A view from outside of all of the tileset. */
static psplat_view view_all(void) {
    psplat_view view = {.width = 400, .height = 300};
    view_perspective(&view, 0.5, 0.01, 100);
    view_look_at(&view, (double[]){9, 4, 7}, (double[]){0, 0, 0});
    return view;
}

/* ---- a host that does its worst ---------------------------------------------------------------
 */

enum { PENDING = 64 };

typedef struct bad_host {
    const world *w;
    psplat_tile_request pending[PENDING];
    size_t count;
    uint32_t random;
    size_t failed_finally, requested;
} bad_host;

/* Deals with some of the requests, in any order: most are supplied, some fail for now, few for
 * good, some with wrong bytes. */
static void bad_host_step(bad_host *h, psplat_tiles *tiles, size_t most) {
    size_t room = PENDING - h->count;
    size_t got = psplat_tiles_wanted(tiles, h->pending + h->count, room < most ? room : most);
    h->count += got;
    h->requested += got;
    for (size_t i = 0; h->count && i < most; ++i) {
        float chance = scene_random(&h->random);
        size_t at = (size_t)(scene_random(&h->random) * (float)h->count) % h->count;
        psplat_tile_request request = h->pending[at];
        if (chance < 0.3f) continue; /* later */
        h->pending[at] = h->pending[--h->count];
        if (chance < 0.4f) {
            psplat_tiles_fail(tiles, request.tile, 0);
        } else if (chance < 0.402f) {
            psplat_tiles_fail(tiles, request.tile, 1);
            ++h->failed_finally;
        } else if (chance < 0.404f) {
            assert_int_not_equal(psplat_tiles_supply(tiles, request.tile, "wrong", 5, NULL),
                                 PSPLAT_OK);
            ++h->failed_finally;
        } else {
            world_supply(h->w, tiles, request.tile, request.path, NULL);
        }
    }
}

/* ---- what always holds ------------------------------------------------------------------------
 */

static int is_newer(const psplat_tiles *t, uint32_t node, uint32_t than) {
    while (than != PSPLAT_TILE_NONE && than != node) than = t->uses[than].newer;
    return than == node;
}

/* Walks the list of tiles in memory: each is older than the one above it. */
static void check_list(const psplat_tiles *t) {
    size_t resident = 0, bytes = 0;
    uint32_t last = PSPLAT_TILE_NONE;
    for (uint32_t node = t->newest; node != PSPLAT_TILE_NONE; node = t->uses[node].older) {
        uint32_t parent = t->nodes[node].parent;
        assert_int_equal(t->uses[node].newer, last);
        assert_true(t->uses[node].is_listed && t->uses[node].uploaded);
        resident += (size_t)psplat_tile_is_ready(t, node);
        if (parent != PSPLAT_TILE_NONE && t->nodes[parent].content_count) {
            assert_true(psplat_tile_is_ready(t, parent));
            assert_true(is_newer(t, parent, node));
        }
        for (uint32_t i = 0; i < t->nodes[node].content_count; ++i)
            bytes += t->loads[t->nodes[node].first_content + i].bytes;
        last = node;
    }
    assert_int_equal(t->oldest, last);
    assert_int_equal(resident, t->resident);
    for (size_t i = 0; i < t->max_requests; ++i) bytes += atomic_load(&t->slots[i].bytes);
    assert_int_equal(bytes, atomic_load(&t->bytes));
}

/* Items are models that exist. */
static void check_items(const psplat_tiles *t) {
    size_t count = 0, splats = 0;
    const psplat_item *items = psplat_tiles_items(t, &count);
    for (size_t i = 0; i < count; ++i) {
        splats += mock_describe(items[i].model).splat_count; /* the sanitizer knows freed ones */
        assert_true(items[i].fade >= 0 && items[i].fade < 1);
    }
    assert_int_equal(psplat_tiles_describe(t).splats, splats);
}

/* ---- budgets ----------------------------------------------------------------------------------
 */

static void fly(size_t max_bytes, size_t max_requests, size_t *evicted) {
    world w = make_world(10, 4);
    const psplat_tiles_desc desc = {.max_bytes = max_bytes, .max_requests = max_requests};
    psplat_tiles *tiles = world_open(&w, desc);
    bad_host host = {.w = &w, .random = 77};
    uint32_t random = 13;
    double angle = 0;
    size_t most = 0, resident = 0;
    for (int frame = 0; frame < 1500; ++frame) {
        psplat_view view = {.width = 640, .height = 480};
        view_perspective(&view, 0.5, 0.01, 100);
        angle += 0.02;
        const double eye[3] = {5 * cos(angle), 0.8 + 0.5 * sin(3 * angle), 3 * sin(angle)};
        view_look_at(&view, eye, (double[]){2 * sin(2 * angle), 0, 0});
        if (frame % 100 == 50) view = view_random(&random); /* a jump */
        const psplat_tiles_view v = {.view = &view, .pixels = 2, .max_splats = 3000};
        assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
        bad_host_step(&host, tiles, 6);
        assert_true(atomic_load(&tiles->bytes) <= max_bytes);
        assert_int_equal(psplat_tiles_upload(tiles, NULL, 4096, NULL), PSPLAT_OK);
        psplat_tiles_state s = psplat_tiles_describe(tiles);
        assert_true(s.bytes <= max_bytes && s.splats <= 3000);
        assert_true(s.under_way + s.waiting <= tiles->max_requests);
        check_items(tiles);
        check_list(tiles);
        if (s.resident < resident) *evicted += resident - s.resident;
        resident = s.resident;
        most = s.bytes > most ? s.bytes : most;
    }
    psplat_tiles_state s = psplat_tiles_describe(tiles);
    assert_int_equal(s.failed, host.failed_finally);
    print_message("max_bytes %zu: %zu requests, %zu bytes at most, %zu of %zu tiles at the end\n",
                  max_bytes, host.requested, most, s.resident, s.tiles);
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

static void test_budgets(void **state) {
    (void)state;
    size_t evicted = 0;
    fly(12000000, 16, &evicted);
    fly(2500000, 16, &evicted);
    fly(1000000, 3, &evicted);
    fly(400000, 16, &evicted);
    assert_true(evicted > 50);
}

/* A view that needs more than there is room for comes to rest: nothing is loaded in turns. */
static void test_rest(void **state) {
    (void)state;
    world w = make_world(9, 3);
    psplat_view view = view_all();
    size_t last = 0;
    for (size_t max_bytes = 250000; max_bytes < 8000000; max_bytes += max_bytes / 2) {
        psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){.max_bytes = max_bytes});
        const psplat_tiles_view v = {.view = &view, .pixels = 0.5};
        size_t requests = world_settle(&w, tiles, &v);
        psplat_tiles_state s = psplat_tiles_describe(tiles);
        assert_int_equal(s.missing, 0);
        assert_true(s.drawn >= last);
        assert_true(requests < 3 * s.tiles);
        for (int i = 0; i < 300; ++i) {
            psplat_tile_request request;
            assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
            assert_int_equal(psplat_tiles_wanted(tiles, &request, 1), 0);
            assert_int_equal(psplat_tiles_upload(tiles, NULL, 0, NULL), PSPLAT_OK);
        }
        last = s.drawn;
        psplat_tiles_destroy(tiles, NULL);
    }
    assert_true(last > 30);
    world_free(&w);
}

/* The root alone does not fit: it counts as a file that cannot be read. */
static void check_no_room(size_t max_bytes) {
    world w = make_world(3, 0);
    psplat_view view = view_all();
    const psplat_tiles_view v = {.view = &view};
    psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){.max_bytes = max_bytes});
    for (int i = 0; i < 20; ++i) {
        psplat_tile_request request;
        assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
        if (!psplat_tiles_wanted(tiles, &request, 1)) continue;
        psplat_error error = {0};
        assert_int_equal(world_supply(&w, tiles, request.tile, request.path, &error),
                         PSPLAT_ERROR_MEMORY);
        assert_true(error.text[0]);
    }
    psplat_tiles_state s = psplat_tiles_describe(tiles);
    assert_int_equal(s.failed, 1);
    assert_int_equal(s.drawn, 0);
    assert_int_equal(s.bytes, 0);
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

static void test_no_room(void **state) {
    (void)state;
    check_no_room(1000);
    check_no_room(30000); /* which decoding takes step by step */
    check_no_room(70000);
}

/* What was used last stays: after a look at one end and then at the other, what has to go is of the
 * first end, and the root is never gone. */
static void test_eviction(void **state) {
    (void)state;
    world w = make_world(8, 0);
    psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){.max_bytes = 1200000});
    psplat_view view = {.width = 400, .height = 300};
    const psplat_tiles_view v = {.view = &view, .pixels = 4};
    view_perspective(&view, 0.5, 0.01, 100);
    for (int end = 0; end < 6; ++end) {
        double x = end % 2 ? 5.5 : -5.5;
        view_look_at(&view, (double[]){x, 0.5, 0}, (double[]){2 * x, 0, 0.5});
        view_look_at(&view, (double[]){x, 0.5, 0}, (double[]){0, 0, 0.5});
        world_settle(&w, tiles, &v);
        assert_true(psplat_tile_is_ready(tiles, 0));
        check_list(tiles);
        uint32_t used = tiles->uses[tiles->newest].used;
        assert_int_equal(used, tiles->frame);
        for (uint32_t n = tiles->newest; n != PSPLAT_TILE_NONE; n = tiles->uses[n].older) {
            assert_true(tiles->uses[n].used <= used);
            used = tiles->uses[n].used;
        }
    }
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

/* When the view turns, what was replaced stays so: tiles that come into view are there already. */
static void test_turning(void **state) {
    (void)state;
    world w = make_world(9, 3);
    psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){0});
    psplat_view view = {.width = 400, .height = 300};
    const psplat_tiles_view v = {.view = &view, .pixels = 3};
    size_t kept = 0, came = 0;
    view_perspective(&view, 0.4, 0.01, 100);
    for (int i = 0; i < 60; ++i) {
        const double eye[3] = {0.5, 0.8, 3.5};
        view_look_at(&view, eye, (double[]){0.1 * i - 3, 0.2, 0});
        if (i % 2 == 0) {
            world_settle(&w, tiles, &v);
            continue;
        }
        uint32_t last = tiles->frame;
        assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
        for (uint32_t node = 0; node < tiles->node_count; ++node) {
            const psplat_tile_use *use = &tiles->uses[node];
            if (use->looked != tiles->frame || !use->is_visible) continue;
            came += use->shown == tiles->frame && use->used == tiles->frame && !use->refined;
            if (tiles->nodes[node].child_count == 0 || psplat_tile_pixels(tiles, node) <= 3)
                continue;
            if (use->refined != tiles->frame) assert_true(use->refined != last);
            kept += use->refined == tiles->frame;
        }
    }
    print_message("%zu tiles stayed replaced\n", kept);
    assert_true(kept > 500 && came > 0);
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

/* ---- cross-fades ------------------------------------------------------------------------------
 */

/* Returns the weight of a tile's item, 0 where it has none. */
static double weight_of(const psplat_tiles *t, uint32_t node) {
    size_t count = 0;
    const psplat_item *items = psplat_tiles_items(t, &count);
    for (size_t i = 0; i < count; ++i)
        if (items[i].model == t->loads[t->nodes[node].first_content].model)
            return 1 - (double)items[i].fade;
    return 0;
}

/* The weights from the root to each tile below which nothing is drawn add up to 1. Returns the
 * number of tiles that are neither whole nor absent. */
static size_t check_weights(const psplat_tiles *t, uint32_t node, double above) {
    const psplat_tile_node *n = &t->nodes[node];
    double own = weight_of(t, node);
    size_t fading = own > 0 && own < 1;
    int goes_on = 0;
    for (uint32_t i = 0; i < n->child_count; ++i) {
        uint32_t child = n->first_child + i;
        if (t->uses[child].shown != t->frame) continue;
        goes_on = 1;
        fading += check_weights(t, child, above + own);
    }
    if (!goes_on && t->uses[node].mix < 1) assert_near(above + own, 1, 1e-5);
    return fading;
}

static void test_fades(void **state) {
    (void)state;
    world w = make_world(8, 0);
    psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){.fade_seconds = 1});
    psplat_view view = view_all();
    psplat_tiles_view v = {.view = &view, .pixels = 0.5};
    world_settle(&w, tiles, &v);
    size_t faded = 0, frames = 0;
    for (int i = 0; i < 400; ++i) {
        v.seconds = 0.05 * i;
        v.pixels = i / 40 % 2 ? 1 : 8; /* for two seconds each */
        v.max_splats = i < 200 ? 0 : 300;
        view_look_at(&view, (double[]){9 - 0.01 * i, 4, 7}, (double[]){0.003 * i, 0, 0});
        assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
        size_t fading = check_weights(tiles, 0, 0);
        psplat_tiles_state s = psplat_tiles_describe(tiles);
        assert_true(!v.max_splats || s.splats <= v.max_splats);
        check_items(tiles);
        if (i % 40 > 38 && i < 200) assert_true(fading < s.drawn);
        faded += fading;
        frames += fading > 0;
        assert_int_equal(psplat_tiles_upload(tiles, NULL, 0, NULL), PSPLAT_OK);
    }
    print_message("%zu items faded in %zu of 400 frames\n", faded, frames);
    assert_true(frames > 50 && frames < 390 && faded > 500);
    /* Nothing moves: a second later all is whole. */
    for (int i = 0; i < 25; ++i) {
        v.seconds += 0.05;
        assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
    }
    assert_int_equal(check_weights(tiles, 0, 0), 0);
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

/* ---- memory that runs out ----------------------------------------------------------------------
 */

/* Opens, draws a few frames and closes. Returns 0 where the tileset did not open. */
static int run_once(world *w, ledger *l) {
    psplat_error error = {0};
    psplat_tiles *tiles = NULL;
    psplat_tile_request requests[8];
    psplat_view view = view_all();
    const psplat_tiles_view v = {.view = &view, .pixels = 4};
    const psplat_tiles_desc desc = {.allocator = ledger_allocator(l),
                                    .source = {.read = world_read, .user = w}};
    psplat_result result = psplat_tiles_open(&desc, "dir/tileset.json", &tiles, &error);
    assert_int_equal(result == PSPLAT_OK, tiles != NULL);
    if (!tiles) assert_int_equal(result, PSPLAT_ERROR_MEMORY);
    if (!tiles) assert_true(error.text[0]);
    if (tiles) tiles->models = &mock_models;
    for (int i = 0; tiles && i < 40; ++i) {
        result = psplat_tiles_select(tiles, &v, NULL);
        assert_true(result == PSPLAT_OK || result == PSPLAT_ERROR_MEMORY);
        size_t count = psplat_tiles_wanted(tiles, requests, 8);
        for (size_t k = 0; k < count; ++k) {
            result = world_supply(w, tiles, requests[k].tile, requests[k].path, &error);
            assert_true(result == PSPLAT_OK || result == PSPLAT_ERROR_MEMORY);
        }
        assert_int_equal(psplat_tiles_upload(tiles, NULL, SIZE_MAX, NULL), PSPLAT_OK);
    }
    if (tiles) { /* what failed once was asked for again */
        psplat_tiles_state s = psplat_tiles_describe(tiles);
        assert_true(s.drawn > 4);
        assert_int_equal(s.missing + s.failed, 0);
        check_list(tiles);
    }
    psplat_tiles_destroy(tiles, NULL);
    assert_int_equal(l->bytes, 0);
    return result == PSPLAT_OK;
}

static void test_no_memory(void **state) {
    (void)state;
    world w = make_world(4, 2);
    ledger good = {.fail_at = -1};
    assert_int_equal(run_once(&w, &good), 1);
    print_message("%d allocations\n", good.calls);
    assert_true(good.calls > 100);
    for (int i = 0; i < good.calls; ++i) {
        ledger l = {.fail_at = i};
        run_once(&w, &l);
        assert_true(l.calls > i);
    }
    world_free(&w);
}

/* Frames allocate nothing once as many tiles were drawn before. */
static void test_steady_frames(void **state) {
    (void)state;
    world w = make_world(8, 3);
    ledger l = {.fail_at = -1};
    psplat_tiles *tiles =
        world_open(&w, (psplat_tiles_desc){.allocator = ledger_allocator(&l), .fade_seconds = 0.2});
    psplat_view view = view_all();
    psplat_tiles_view v = {.view = &view, .pixels = 0.1};
    world_settle(&w, tiles, &v);
    int calls = 0;
    for (int i = -300; i < 300; ++i) {
        if (i == 0) calls = l.calls;
        v.pixels = 0.1 * (1 + (i + 300) % 20);
        v.seconds = 0.02 * i + 10;
        view_look_at(&view, (double[]){9 - 0.03 * (i < 0 ? i + 300 : i), 4, 7},
                     (double[]){0, 0, 0});
        assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
        psplat_tile_request request;
        assert_int_equal(psplat_tiles_wanted(tiles, &request, 1), 0);
        assert_int_equal(psplat_tiles_upload(tiles, NULL, 0, NULL), PSPLAT_OK);
    }
    assert_int_equal(l.calls, calls);
    psplat_tiles_destroy(tiles, NULL);
    assert_int_equal(l.bytes, 0);
    world_free(&w);
}

/* ---- requests handled wrongly ------------------------------------------------------------------
 */

static void test_stale_requests(void **state) {
    (void)state;
    world w = make_world(3, 0);
    psplat_view view = view_all();
    const psplat_tiles_view v = {.view = &view, .pixels = 0.5};
    psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){0});
    psplat_tile_request request, again;
    assert_int_equal(psplat_tiles_supply(tiles, 0, "", 0, NULL), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_tiles_supply(NULL, 0, "", 0, NULL), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_tiles_wanted(tiles, &request, 1), 0);
    assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
    assert_int_equal(psplat_tiles_wanted(tiles, &request, 1), 1);
    assert_string_equal(request.path, "t/n.glb");
    assert_int_equal(psplat_tiles_wanted(tiles, &again, 1), 0);
    assert_int_equal(psplat_tiles_describe(tiles).under_way, 1);
    for (uint64_t wrong = 1; wrong < 40; ++wrong) {
        psplat_tiles_fail(tiles, request.tile + wrong, 1);
        psplat_tiles_fail(tiles, request.tile + (wrong << 32), 1);
        psplat_tiles_fail(tiles, request.tile ^ (wrong << 40), 1);
    }
    assert_int_equal(psplat_tiles_supply(tiles, request.tile, NULL, 5, NULL),
                     PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(world_supply(&w, tiles, request.tile, request.path, NULL), PSPLAT_OK);
    assert_int_equal(world_supply(&w, tiles, request.tile, request.path, NULL),
                     PSPLAT_ERROR_ARGUMENT);
    psplat_tiles_fail(tiles, request.tile, 1);
    assert_int_equal(psplat_tiles_describe(tiles).waiting, 1);
    assert_int_equal(psplat_tiles_upload(tiles, NULL, 0, NULL), PSPLAT_OK);
    assert_int_equal(psplat_tiles_describe(tiles).resident, 1);
    assert_int_equal(world_supply(&w, tiles, request.tile, request.path, NULL),
                     PSPLAT_ERROR_ARGUMENT);
    /* A request that fails is made again after 1, 2, 4 frames, and a slot counts its requests. */
    for (int i = 0; i < 3; ++i) {
        for (int frames = 0;; ++frames) {
            assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
            if (!psplat_tiles_wanted(tiles, &again, 1)) continue;
            assert_true(again.tile != request.tile);
            break;
        }
        psplat_tiles_fail(tiles, again.tile, 0);
    }
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

/* A file that is wrong is never requested again; the tile above it stays. */
static void test_wrong_files(void **state) {
    (void)state;
    for (int external = 0; external < 3; external += 2) {
        world w = make_world(4, external);
        psplat_view view = view_all();
        const psplat_tiles_view v = {.view = &view, .pixels = 0.5};
        psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){0});
        size_t wrong = 0;
        for (int i = 0; i < 30; ++i) {
            psplat_tile_request requests[16];
            psplat_error error = {0};
            assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
            size_t count = psplat_tiles_wanted(tiles, requests, 16);
            for (size_t k = 0; k < count; ++k) {
                const char *path = requests[k].path;
                int is_root = !strcmp(path, "t/n.glb"), is_json = strstr(path, ".json") != NULL;
                if (is_root || (external && !is_json)) {
                    world_supply(&w, tiles, requests[k].tile, path, NULL);
                    continue;
                }
                assert_int_equal(psplat_tiles_supply(tiles, requests[k].tile, "{}", 2, &error),
                                 PSPLAT_ERROR_FORMAT);
                assert_true(!is_json || strstr(error.text, path));
                ++wrong;
            }
            assert_int_equal(psplat_tiles_upload(tiles, NULL, SIZE_MAX, NULL), PSPLAT_OK);
        }
        psplat_tiles_state s = psplat_tiles_describe(tiles);
        assert_true(wrong > 0 && wrong < 5);
        assert_int_equal(s.failed, wrong);
        assert_true(s.drawn > 0 && s.missing > 0);
        psplat_tiles_destroy(tiles, NULL);
        world_free(&w);
    }
}

static psplat_result mock_result; /* with which mock_fail fails */

static psplat_result mock_fail(psplat_renderer *renderer, const psplat_asset *asset,
                               psplat_model **model, psplat_error *error) {
    if (!mock_result) return mock_create(renderer, asset, model, error);
    return psplat_fail(error, mock_result, 0, "as the test wants");
}

/* Frames until a tileset of one tile has drawn it, with a request in each frame that wants one. */
static int frames_until_drawn(const world *w, psplat_tiles *tiles, const psplat_tiles_view *v) {
    for (int frame = 1; frame < 20; ++frame) {
        psplat_tile_request request;
        assert_int_equal(psplat_tiles_select(tiles, v, NULL), PSPLAT_OK);
        if (psplat_tiles_describe(tiles).drawn) return frame;
        if (psplat_tiles_wanted(tiles, &request, 1))
            assert_int_equal(world_supply(w, tiles, request.tile, request.path, NULL), PSPLAT_OK);
        psplat_result result = psplat_tiles_upload(tiles, NULL, 0, NULL);
        assert_int_equal(result, psplat_tiles_describe(tiles).waiting ? PSPLAT_OK : mock_result);
    }
    return 20;
}

/* Where the upload fails for want of memory the tile is asked for again, where the file is too much
 * for this GL it is not; where there is no room it is asked for again when there is. */
static void test_failing_uploads(void **state) {
    (void)state;
    static const psplat_tile_models models = {mock_fail, mock_destroy, mock_describe};
    static const psplat_result results[] = {PSPLAT_ERROR_MEMORY, PSPLAT_ERROR_GRAPHICS,
                                            PSPLAT_ERROR_ARGUMENT, PSPLAT_ERROR_RANGE, PSPLAT_OK};
    world w = make_world(0, 0);
    psplat_view view = view_all();
    const psplat_tiles_view v = {.view = &view};
    for (int i = 0; i < 5; ++i) {
        psplat_tile_request request;
        psplat_error error = {0};
        psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){.max_bytes = 100000});
        tiles->models = &models;
        assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
        assert_int_equal(psplat_tiles_wanted(tiles, &request, 1), 1);
        assert_int_equal(world_supply(&w, tiles, request.tile, request.path, NULL), PSPLAT_OK);
        mock_result = results[i];
        size_t taken = tiles->max_bytes - atomic_load(&tiles->bytes);
        if (!mock_result) assert_true(psplat_tiles_take_bytes(tiles, taken));
        assert_int_equal(psplat_tiles_upload(tiles, NULL, 0, &error), mock_result);
        assert_int_equal(error.text[0] != 0, mock_result != PSPLAT_OK);
        if (!mock_result) psplat_tiles_give_bytes(tiles, taken);
        mock_result = PSPLAT_OK;
        assert_int_equal(psplat_tiles_describe(tiles).bytes, 0);
        int is_final = results[i] == PSPLAT_ERROR_RANGE;
        assert_int_equal(psplat_tiles_describe(tiles).failed, is_final);
        assert_int_equal(frames_until_drawn(&w, tiles, &v) < 20, !is_final);
        psplat_tiles_destroy(tiles, NULL);
    }
    assert_int_equal(psplat_tiles_upload(NULL, NULL, 0, NULL), PSPLAT_ERROR_ARGUMENT);
    world_free(&w);
}

/* What is still on its way when a tileset is destroyed is forgotten. */
static void test_destroy_early(void **state) {
    (void)state;
    world w = make_world(4, 2);
    psplat_view view = view_all();
    const psplat_tiles_view v = {.view = &view, .pixels = 0.5};
    for (int rounds = 0; rounds < 8; ++rounds) {
        ledger l = {.fail_at = -1};
        psplat_tiles *tiles =
            world_open(&w, (psplat_tiles_desc){.allocator = ledger_allocator(&l)});
        for (int i = 0; i <= rounds; ++i) {
            psplat_tile_request requests[16];
            assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
            size_t count = psplat_tiles_wanted(tiles, requests, 16);
            for (size_t k = 0; k < count - (i == rounds && count > 1); ++k)
                world_supply(&w, tiles, requests[k].tile, requests[k].path, NULL);
            if (i < rounds) psplat_tiles_upload(tiles, NULL, SIZE_MAX, NULL);
        }
        psplat_tiles_destroy(tiles, NULL);
        assert_int_equal(l.bytes, 0);
    }
    psplat_tiles_destroy(NULL, NULL);
    world_free(&w);
}

int test_tile_memory_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_budgets),        cmocka_unit_test(test_rest),
        cmocka_unit_test(test_no_room),        cmocka_unit_test(test_eviction),
        cmocka_unit_test(test_turning),        cmocka_unit_test(test_fades),
        cmocka_unit_test(test_no_memory),      cmocka_unit_test(test_steady_frames),
        cmocka_unit_test(test_stale_requests), cmocka_unit_test(test_wrong_files),
        cmocka_unit_test(test_destroy_early),  cmocka_unit_test(test_failing_uploads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

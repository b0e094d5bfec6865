/* SPDX-License-Identifier: MIT
 *
 * select.c - chooses the tiles of a frame, best first, and what is wanted for the next ones.
 */
#include "tileset/show.h"
#include "tileset/slots.h"

#include <math.h>

/* A tile that was replaced stays so down to this part of the greatest error. */
static const double hysteresis = 0.9;

static const double pi = 3.14159265358979323846;

typedef struct selection {
    psplat_tiles *tiles;
    psplat_tile_camera camera;
    double pixels;
    size_t max_splats;
} selection;

/* ---- the heap of tiles that are too coarse -------------------------------------------------- */

static int is_better(const psplat_tile_candidate *a, const psplat_tile_candidate *b) {
    return a->gain > b->gain || (a->gain == b->gain && a->node < b->node);
}

static void push(psplat_tiles *tiles, psplat_tile_candidate candidate) {
    psplat_tile_candidate *heap = tiles->heap;
    size_t at = tiles->heap_count++;
    for (; at && is_better(&candidate, &heap[(at - 1) / 2]); at = (at - 1) / 2)
        heap[at] = heap[(at - 1) / 2];
    heap[at] = candidate;
}

static psplat_tile_candidate pop(psplat_tiles *tiles) {
    psplat_tile_candidate *heap = tiles->heap, best = heap[0], last = heap[--tiles->heap_count];
    size_t at = 0, count = tiles->heap_count;
    for (size_t child = 1; child < count; child = 2 * at + 1) {
        if (child + 1 < count && is_better(&heap[child + 1], &heap[child])) ++child;
        if (!is_better(&heap[child], &last)) break;
        heap[at] = heap[child];
        at = child;
    }
    heap[at] = last;
    return best;
}

/* ---- what replacing a tile costs and gains -------------------------------------------------- */

/* Tiles whose number of splats is not known are taken to have those of the tile above. */
static double splats_of(const psplat_tiles *tiles, uint32_t node) {
    const psplat_tile_node *n = &tiles->nodes[node];
    if (!n->splats && n->parent != PSPLAT_TILE_NONE) n = &tiles->nodes[n->parent];
    return n->splats;
}

static double added_splats(const psplat_tiles *tiles, uint32_t node) {
    const psplat_tile_node *n = &tiles->nodes[node];
    double added = -splats_of(tiles, node);
    for (uint32_t i = 0; i < n->child_count; ++i) added += splats_of(tiles, n->first_child + i);
    return added;
}

/* Returns coverage x error removed / splats added. */
static double gain_of(const selection *s, uint32_t node) {
    const psplat_tiles *tiles = s->tiles;
    const psplat_tile_use *use = &tiles->uses[node];
    double radius = psplat_tile_radius(&tiles->nodes[node].volume) * use->scale;
    double area = fmin(pi * radius * radius, s->camera.area);
    double removed = (tiles->nodes[node].error - use->child_error) * use->scale;
    return area * removed / fmax(added_splats(tiles, node), 1.0);
}

/* Takes a visible tile into the choice, as one that may be replaced if it is too coarse. */
static void choose(const selection *s, uint32_t node) {
    psplat_tiles *tiles = s->tiles;
    int was_refined = tiles->uses[node].refined + 1 == tiles->frame;
    double most = s->pixels * (was_refined ? hysteresis : 1.0);
    if (!(psplat_tile_pixels(tiles, node) > most)) return;
    if (tiles->nodes[node].child_count)
        push(tiles, (psplat_tile_candidate){gain_of(s, node), node});
    else if (psplat_tile_pixels(tiles, node) > s->pixels)
        ++tiles->state.leaves;
}

/* ---- replacing ------------------------------------------------------------------------------ */

static int has_failed(const psplat_tiles *tiles, uint32_t node) {
    const psplat_tile_node *n = &tiles->nodes[node];
    for (uint32_t i = 0; i < n->content_count; ++i)
        if (tiles->loads[n->first_content + i].progress == PSPLAT_TILE_FAILED) return 1;
    return 0;
}

static void want(psplat_tiles *tiles, double priority, uint32_t node,
                 psplat_tile_family_kind kind) {
    tiles->families[tiles->family_count++] = (psplat_tile_family){priority, node, kind};
}

/* Counts what keeps a tile from being replaced; a tile that stays so by hysteresis alone is not too
 * coarse. */
static void keep(const selection *s, uint32_t node, size_t *count) {
    if (psplat_tile_pixels(s->tiles, node) > s->pixels) ++*count;
}

/* What replacing a tile by its visible children takes. */
typedef struct replacement {
    double added;        /* splats */
    int missing, failed; /* children that are not on the GPU, or will never be */
    int aside;           /* children that are beside the view */
} replacement;

static replacement look_at_children(const selection *s, uint32_t node) {
    psplat_tiles *tiles = s->tiles;
    const psplat_tile_node *n = &tiles->nodes[node];
    replacement r = {.added = -splats_of(tiles, node)};
    for (uint32_t child = n->first_child; child < n->first_child + n->child_count; ++child) {
        psplat_tile_look(tiles, &s->camera, child);
        r.aside |= tiles->uses[child].is_aside;
        if (!tiles->uses[child].is_visible) continue;
        r.added += splats_of(tiles, child);
        r.missing |= !psplat_tile_is_ready(tiles, child);
        r.failed |= has_failed(tiles, child);
    }
    return r;
}

/* Replaces a tile by its visible children, or finds what is in the way of that. */
static void refine(const selection *s, psplat_tile_candidate candidate) {
    psplat_tiles *tiles = s->tiles;
    uint32_t node = candidate.node;
    const psplat_tile_node *n = &tiles->nodes[node];
    replacement r = look_at_children(s, node);
    if (s->max_splats && (double)tiles->cut_splats + r.added > (double)s->max_splats) {
        keep(s, node, &tiles->state.over_budget);
        return;
    }
    if (r.missing) {
        keep(s, node, &tiles->state.missing);
        if (!r.failed) want(tiles, candidate.gain, node, PSPLAT_FAMILY_CHILDREN);
        return;
    }
    tiles->cut_splats = (size_t)((double)tiles->cut_splats + r.added);
    tiles->uses[node].refined = tiles->frame;
    /* Later than all that is visible, and in the order of what it is beside. */
    if (r.aside) want(tiles, -1.0 / (1.0 + candidate.gain), node, PSPLAT_FAMILY_ASIDE);
    for (uint32_t child = n->first_child; child < n->first_child + n->child_count; ++child)
        if (tiles->uses[child].is_visible) choose(s, child);
}

/* A tile without contents stands for its children, each of which is drawn as soon as it is there.
 */
static void start_at_children(const selection *s) {
    psplat_tiles *tiles = s->tiles;
    const psplat_tile_node *root = &tiles->nodes[0];
    tiles->uses[0].refined = tiles->frame;
    for (uint32_t i = 0; i < root->child_count; ++i) {
        uint32_t child = root->first_child + i;
        psplat_tile_look(tiles, &s->camera, child);
        if (!tiles->uses[child].is_visible) continue;
        if (!psplat_tile_is_ready(tiles, child)) {
            if (!has_failed(tiles, child)) want(tiles, HUGE_VAL, child, PSPLAT_FAMILY_ALONE);
            continue;
        }
        tiles->cut_splats += tiles->nodes[child].splats;
        choose(s, child);
    }
}

static void find_cut(const selection *s) {
    psplat_tiles *tiles = s->tiles;
    psplat_tile_look(tiles, &s->camera, 0);
    if (!tiles->uses[0].is_visible) return;
    if (!tiles->nodes[0].content_count) {
        start_at_children(s);
    } else if (psplat_tile_is_ready(tiles, 0)) {
        tiles->cut_splats = tiles->nodes[0].splats;
        choose(s, 0);
    } else if (!has_failed(tiles, 0)) {
        want(tiles, HUGE_VAL, 0, PSPLAT_FAMILY_ALONE);
    }
    while (tiles->heap_count) refine(s, pop(tiles));
}

/* ---- what is wanted ------------------------------------------------------------------------- */

static size_t bytes_of(const psplat_tiles *tiles, uint32_t node) {
    const psplat_tile_node *n = &tiles->nodes[node];
    size_t bytes = 0;
    for (uint32_t i = 0; i < n->content_count; ++i)
        bytes += tiles->loads[n->first_content + i].bytes;
    return bytes;
}

/* Returns the bytes that a tile takes beside those that are used already. */
static size_t bytes_needed(const psplat_tiles *tiles, uint32_t node) {
    const psplat_tile_node *n = &tiles->nodes[node];
    size_t bytes = 0;
    if (tiles->uses[node].used == tiles->frame) return 0;
    for (uint32_t i = 0; i < n->content_count; ++i) {
        uint32_t content = n->first_content + i;
        int is_there = tiles->loads[content].progress == PSPLAT_TILE_UPLOADED;
        bytes +=
            is_there ? tiles->loads[content].bytes : psplat_tile_expected_bytes(tiles, content);
    }
    return bytes;
}

/* Returns the children of a family's tile, and in *end the one behind the last of them, or this
 * tile alone. */
static uint32_t family_begin(const psplat_tiles *tiles, const psplat_tile_family *family,
                             uint32_t *end) {
    const psplat_tile_node *n = &tiles->nodes[family->node];
    int is_alone = family->kind == PSPLAT_FAMILY_ALONE;
    *end = is_alone ? family->node + 1 : n->first_child + n->child_count;
    return is_alone ? family->node : n->first_child;
}

static int is_in_family(const psplat_tiles *tiles, const psplat_tile_family *family,
                        uint32_t node) {
    const psplat_tile_use *use = &tiles->uses[node];
    if (family->kind == PSPLAT_FAMILY_ASIDE) return use->is_aside && !has_failed(tiles, node);
    return family->kind == PSPLAT_FAMILY_ALONE || use->is_visible;
}

static size_t family_bytes(const psplat_tiles *tiles, const psplat_tile_family *family) {
    uint32_t end, node = family_begin(tiles, family, &end);
    size_t bytes = 0;
    for (; node < end; ++node)
        if (is_in_family(tiles, family, node)) bytes += bytes_needed(tiles, node);
    return bytes;
}

/* Adds what a tile lacks to the requests, and keeps what it has. */
static void request(psplat_tiles *tiles, uint32_t node, double priority) {
    const psplat_tile_node *n = &tiles->nodes[node];
    tiles->uses[node].used = tiles->frame;
    psplat_tile_touch(tiles, node);
    for (uint32_t i = 0; i < n->content_count; ++i) {
        uint32_t content = n->first_content + i;
        psplat_tile_load *load = &tiles->loads[content];
        load->priority = priority;
        if (load->progress == PSPLAT_TILE_ABSENT && load->again <= tiles->frame)
            tiles->requests[tiles->request_count++] = content;
    }
}

static void request_family(psplat_tiles *tiles, const psplat_tile_family *family) {
    uint32_t end, node = family_begin(tiles, family, &end);
    for (; node < end; ++node)
        if (is_in_family(tiles, family, node)) request(tiles, node, family->priority);
}

static int is_sooner(const psplat_tile_family *a, const psplat_tile_family *b) {
    return a->priority > b->priority || (a->priority == b->priority && a->node < b->node);
}

/* Lets the family at a place of a heap with the last one on top sink. */
static void sink(psplat_tile_family *heap, size_t count, size_t at) {
    psplat_tile_family family = heap[at];
    for (size_t child = 2 * at + 1; child < count; child = 2 * at + 1) {
        if (child + 1 < count && is_sooner(&heap[child], &heap[child + 1])) ++child;
        if (!is_sooner(&family, &heap[child])) break;
        heap[at] = heap[child];
        at = child;
    }
    heap[at] = family;
}

/* Heapsort, since that of the C library may allocate. */
static void sort_families(psplat_tile_family *families, size_t count) {
    for (size_t i = count / 2; i-- > 0;) sink(families, count, i);
    for (size_t i = count; i-- > 1;) {
        psplat_tile_family last = families[0];
        families[0] = families[i];
        families[i] = last;
        sink(families, i, 0);
    }
}

/* Requests families as long as they fit into memory beside what is used. */
static void request_families(const selection *s) {
    psplat_tiles *tiles = s->tiles;
    size_t planned = tiles->pinned, i = 0;
    sort_families(tiles->families, tiles->family_count);
    for (; i < tiles->family_count; ++i) {
        size_t bytes = family_bytes(tiles, &tiles->families[i]);
        if (planned > tiles->max_bytes || bytes > tiles->max_bytes - planned) break;
        planned += bytes;
        request_family(tiles, &tiles->families[i]);
    }
    for (; i < tiles->family_count; ++i) {
        const psplat_tile_family *family = &tiles->families[i];
        if (family->kind != PSPLAT_FAMILY_CHILDREN) continue;
        if (!(psplat_tile_pixels(tiles, family->node) > s->pixels)) continue;
        --tiles->state.missing;
        ++tiles->state.over_budget;
    }
}

/* Tiles above others become newer than these, so that the oldest tile is one without tiles in
 * memory below it. */
static void touch_shown(psplat_tiles *tiles) {
    for (size_t i = tiles->shown_count; i-- > 0;) psplat_tile_touch(tiles, tiles->shown[i]);
}

static void count_pinned(psplat_tiles *tiles) {
    tiles->pinned = 0;
    for (size_t i = 0; i < tiles->shown_count; ++i)
        tiles->pinned += bytes_of(tiles, tiles->shown[i]);
}

/* ---- the public functions ------------------------------------------------------------------- */

static void begin(psplat_tiles *tiles) {
    tiles->heap_count = tiles->family_count = tiles->shown_count = 0;
    tiles->request_count = tiles->next_request = tiles->item_count = tiles->cut_splats = 0;
    tiles->state = (psplat_tiles_state){0};
}

psplat_result psplat_tiles_select(psplat_tiles *tiles, const psplat_tiles_view *view,
                                  psplat_error *error) {
    if (!tiles) return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "tiles must not be NULL");
    selection s = {.tiles = tiles};
    begin(tiles);
    psplat_result result = psplat_tile_camera_set(&s.camera, view, error);
    if (result) return result;
    s.pixels = view->pixels > 0 ? view->pixels : 1.0;
    s.max_splats = view->max_splats;
    ++tiles->frame;
    psplat_tile_slots_collect(tiles);
    find_cut(&s);
    result = psplat_tiles_show(tiles, &s.camera, view, error);
    if (result) return result;
    count_pinned(tiles);
    request_families(&s);
    touch_shown(tiles);
    return PSPLAT_OK;
}

size_t psplat_tiles_wanted(psplat_tiles *tiles, psplat_tile_request *requests, size_t capacity) {
    size_t count = 0;
    if (!tiles || !requests) return 0;
    size_t planned = psplat_tile_slots_outstanding(tiles) + atomic_load(&tiles->bytes);
    for (; count < capacity && tiles->next_request < tiles->request_count; ++count) {
        uint32_t index = tiles->requests[tiles->next_request];
        const psplat_tile_content *content = &tiles->contents[index];
        size_t bytes = psplat_tile_expected_bytes(tiles, index);
        psplat_tile_slot *slot = psplat_tile_slot_find(tiles);
        if (!slot || planned + bytes > tiles->max_bytes) break;
        planned += bytes;
        ++tiles->next_request;
        requests[count] =
            (psplat_tile_request){.tile = psplat_tile_slot_begin(slot, index, bytes),
                                  .path = tiles->archive.name ? tiles->archive.name : content->path,
                                  .offset = content->offset,
                                  .size = content->size,
                                  .priority = tiles->loads[index].priority};
    }
    return count;
}

const psplat_item *psplat_tiles_items(const psplat_tiles *tiles, size_t *count) {
    *count = tiles ? tiles->item_count : 0;
    return tiles ? tiles->items : NULL;
}

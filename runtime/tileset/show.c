/* SPDX-License-Identifier: MIT
 *
 * show.c - items and cross-fades. Each tile that was replaced has a mix from 0 (it is drawn) to 1
 * (its children are), which runs towards what was chosen. The weights of all tiles over one place
 * add up to 1.
 */
#include "tileset/show.h"

#include "core/matrix.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>

/* Pixels of a unit of length where the eye is inside a volume; greater than any that matter. */
static const double most_scale = 1e100;

/* Tiles of less weight than this are not drawn. */
static const float least_weight = 1e-6f;

/* ---- looking ------------------------------------------------------------------------------- */

/* Materials of a tile that was never in memory are taken to be those of the tile above it. */
static int may_hide_backs(const psplat_tiles *tiles, const psplat_tile_camera *camera,
                          uint32_t node) {
    psplat_tile_sides sides = tiles->uses[node].sides;
    uint32_t parent = tiles->nodes[node].parent;
    if (camera->culling != PSPLAT_CULL_BY_MATERIAL) return camera->culling == PSPLAT_CULL_ALWAYS;
    if (sides == PSPLAT_SIDES_UNKNOWN && parent != PSPLAT_TILE_NONE)
        sides = tiles->uses[parent].sides;
    return sides == PSPLAT_SIDES_SINGLE;
}

void psplat_tile_look(psplat_tiles *tiles, const psplat_tile_camera *camera, uint32_t node) {
    const psplat_tile_volume *volume = &tiles->nodes[node].volume;
    psplat_tile_use *use = &tiles->uses[node];
    if (use->looked == tiles->frame) return;
    use->looked = tiles->frame;
    use->is_aside = !psplat_tile_camera_sees(camera, volume);
    use->is_visible = !use->is_aside && !(may_hide_backs(tiles, camera, node) &&
                                          psplat_tile_camera_sees_backs(camera, volume, use->cone));
    use->scale = use->is_visible ? fmin(psplat_tile_camera_scale(camera, volume), most_scale) : 0.0;
    if (!use->is_visible) ++tiles->state.culled;
}

double psplat_tile_pixels(const psplat_tiles *tiles, uint32_t node) {
    return tiles->nodes[node].error * tiles->uses[node].scale;
}

/* ---- items --------------------------------------------------------------------------------- */

static int reserve_items(psplat_tiles *tiles, size_t count) {
    size_t to = tiles->item_capacity + tiles->item_capacity / 2, size = sizeof *tiles->items;
    if (count <= tiles->item_capacity) return 1;
    to = to < count + 64 ? count + 64 : to;
    psplat_item *items =
        psplat_resize(&tiles->allocator, tiles->items, tiles->item_capacity * size, to * size);
    if (!items) return 0;
    tiles->items = items;
    tiles->item_capacity = to;
    return 1;
}

static int is_zero(const double m[16]) {
    for (int i = 0; i < 16; ++i)
        if (m[i] != 0.0) return 0;
    return 1;
}

/* Appends the contents of a tile with a weight. */
static int add_items(psplat_tiles *tiles, const psplat_tiles_view *view, uint32_t node,
                     float weight) {
    const psplat_tile_node *n = &tiles->nodes[node];
    const double *own = tiles->transforms[n->transform];
    double transform[16];
    if (!reserve_items(tiles, tiles->item_count + n->content_count)) return 0;
    if (is_zero(view->transform))
        memcpy(transform, own, sizeof transform);
    else
        psplat_matrix_multiply(view->transform, own, transform);
    for (uint32_t i = 0; i < n->content_count; ++i) {
        const psplat_tile_load *load = &tiles->loads[n->first_content + i];
        psplat_item *item = &tiles->items[tiles->item_count++];
        memset(item, 0, sizeof *item);
        item->model = load->model;
        item->fade = 1.0f - weight;
        memcpy(item->transform, transform, sizeof transform);
        tiles->state.splats += load->splats;
    }
    ++tiles->state.drawn;
    return 1;
}

/* ---- fading -------------------------------------------------------------------------------- */

/* Moves a tile's mix towards where it shall be by a part of the way from 0 to 1. What was not shown
 * in the last frame does not fade. */
static void mix(psplat_tiles *tiles, uint32_t node, double step) {
    psplat_tile_use *use = &tiles->uses[node];
    float target = use->refined == tiles->frame ? 1.0f : 0.0f;
    double change = (double)target - (double)use->mix;
    int is_new = use->shown != tiles->frame && use->shown + 1 != tiles->frame;
    if (is_new || !tiles->nodes[node].content_count || fabs(change) <= step + (double)least_weight)
        use->mix = target;
    else
        use->mix += (float)copysign(step, change);
}

static void show_children(psplat_tiles *tiles, const psplat_tile_camera *camera, uint32_t node) {
    const psplat_tile_node *n = &tiles->nodes[node];
    const psplat_tile_use *use = &tiles->uses[node];
    for (uint32_t i = 0; i < n->child_count; ++i) {
        uint32_t child = n->first_child + i;
        psplat_tile_look(tiles, camera, child);
        if (!tiles->uses[child].is_visible || !psplat_tile_is_ready(tiles, child)) continue;
        tiles->uses[child].weight = use->weight * use->mix;
        tiles->shown[tiles->shown_count++] = child;
    }
}

/* Returns 1 where a tile was chosen: it was not replaced, and the one above it was. */
static int is_chosen(const psplat_tiles *tiles, uint32_t node) {
    uint32_t parent = tiles->nodes[node].parent;
    return tiles->uses[node].refined != tiles->frame &&
           (parent == PSPLAT_TILE_NONE || tiles->uses[parent].refined == tiles->frame);
}

static int show(psplat_tiles *tiles, const psplat_tile_camera *camera,
                const psplat_tiles_view *view, double step) {
    const psplat_tile_use *root = &tiles->uses[0];
    tiles->shown_count = tiles->item_count = tiles->state.drawn = tiles->state.splats = 0;
    tiles->state.error_pixels = 0;
    if (!root->is_visible) return 1;
    if (tiles->nodes[0].content_count && !psplat_tile_is_ready(tiles, 0)) return 1;
    tiles->uses[0].weight = 1.0f;
    tiles->shown[tiles->shown_count++] = 0;
    for (size_t i = 0; i < tiles->shown_count; ++i) {
        uint32_t node = tiles->shown[i];
        psplat_tile_use *use = &tiles->uses[node];
        mix(tiles, node, step);
        use->used = use->shown = tiles->frame;
        float weight = use->weight * (1.0f - use->mix);
        if (weight >= least_weight && !add_items(tiles, view, node, weight)) return 0;
        if (is_chosen(tiles, node) && tiles->nodes[node].content_count)
            tiles->state.error_pixels =
                fmax(tiles->state.error_pixels, psplat_tile_pixels(tiles, node));
        if (use->mix > 0.0f) show_children(tiles, camera, node);
    }
    return 1;
}

psplat_result psplat_tiles_show(psplat_tiles *tiles, const psplat_tile_camera *camera,
                                const psplat_tiles_view *view, psplat_error *error) {
    double passed = fmax(view->seconds - tiles->seconds, 0.0);
    double step = tiles->fade_seconds > 0 ? passed / tiles->fade_seconds : 1.0;
    int is_done = show(tiles, camera, view, step);
    /* Fading draws more than was chosen; where that is too much, nothing fades. */
    if (is_done && view->max_splats && tiles->state.splats > view->max_splats)
        is_done = show(tiles, camera, view, 1.0);
    tiles->seconds = view->seconds;
    if (is_done) return PSPLAT_OK;
    tiles->item_count = tiles->shown_count = 0;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the items of tiles");
}

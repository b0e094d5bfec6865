/* SPDX-License-Identifier: MIT
 *
 * tree.c - the tables of the tree, which grow with each external tileset, and the list of tiles in
 * memory.
 */
#include "tileset/tree.h"

#include "core/memory.h"
#include "tileset/cone.h"

#include <math.h>
#include <string.h>

/* ---- growing ------------------------------------------------------------------------------- */

/* A table: the address of the pointer to it, the size of an entry. */
typedef struct table {
    void *at;
    size_t size;
} table;

static table find_table(psplat_tiles *t, enum psplat_tile_table which) {
    const table tables[PSPLAT_TILE_TABLES] = {
        [PSPLAT_TABLE_NODES] = {&t->nodes, sizeof *t->nodes},
        [PSPLAT_TABLE_USES] = {&t->uses, sizeof *t->uses},
        [PSPLAT_TABLE_HEAP] = {&t->heap, sizeof *t->heap},
        [PSPLAT_TABLE_FAMILIES] = {&t->families, sizeof *t->families},
        [PSPLAT_TABLE_SHOWN] = {&t->shown, sizeof *t->shown},
        [PSPLAT_TABLE_CONTENTS] = {&t->contents, sizeof *t->contents},
        [PSPLAT_TABLE_LOADS] = {&t->loads, sizeof *t->loads},
        [PSPLAT_TABLE_REQUESTS] = {&t->requests, sizeof *t->requests},
        [PSPLAT_TABLE_TRANSFORMS] = {&t->transforms, sizeof *t->transforms},
        [PSPLAT_TABLE_KEPT] = {&t->kept, sizeof *t->kept}};
    return tables[which];
}

/* Changes a table to have room for so many entries; 0 frees it. */
static int resize_table(psplat_tiles *t, enum psplat_tile_table which, size_t entries) {
    table own = find_table(t, which);
    void *block = NULL;
    memcpy(&block, own.at, sizeof block);
    if (entries > SIZE_MAX / own.size) return 0;
    if (!entries && !block) return 1;
    block =
        psplat_resize(&t->allocator, block, t->capacities[which] * own.size, entries * own.size);
    if (entries && !block) return 0;
    memcpy(own.at, &block, sizeof block);
    t->capacities[which] = entries;
    return 1;
}

/* Makes room in tables for count entries, and for half as many more than there were. */
static int reserve_tables(psplat_tiles *t, enum psplat_tile_table first,
                          enum psplat_tile_table last, size_t count) {
    for (unsigned i = first; i <= (unsigned)last; ++i) {
        size_t more = t->capacities[i] + t->capacities[i] / 2;
        if (count > t->capacities[i] &&
            !resize_table(t, (enum psplat_tile_table)i, more < count ? count : more))
            return 0;
    }
    return 1;
}

static int reserve(psplat_tiles *t, const psplat_tileset *tileset) {
    return reserve_tables(t, PSPLAT_TABLE_NODES, PSPLAT_TABLE_SHOWN,
                          t->node_count + tileset->node_count) &&
           reserve_tables(t, PSPLAT_TABLE_CONTENTS, PSPLAT_TABLE_REQUESTS,
                          t->content_count + tileset->content_count) &&
           reserve_tables(t, PSPLAT_TABLE_TRANSFORMS, PSPLAT_TABLE_TRANSFORMS,
                          t->transform_count + tileset->transform_count) &&
           reserve_tables(t, PSPLAT_TABLE_KEPT, PSPLAT_TABLE_KEPT, t->file_count + 1);
}

/* ---- grafting ------------------------------------------------------------------------------ */

static void add_contents(psplat_tiles *t, const psplat_tileset *tileset, uint32_t shift) {
    for (size_t i = 0; i < tileset->content_count; ++i) {
        psplat_tile_content *content = &t->contents[t->content_count];
        *content = tileset->contents[i];
        content->node += shift;
        t->loads[t->content_count++] = (psplat_tile_load){.progress = PSPLAT_TILE_ABSENT};
    }
}

/* Copies a tile to a place below a parent. Numbers of other tiles and of contents are shifted. */
static void add_node(psplat_tiles *t, const psplat_tile_node *node, uint32_t to, uint32_t parent,
                     uint32_t shift, uint32_t content) {
    psplat_tile_node *copy = &t->nodes[to];
    *copy = *node;
    copy->parent = parent;
    copy->first_child += shift;
    copy->first_content += content;
    copy->transform += (uint32_t)t->transform_count;
    t->uses[to] = (psplat_tile_use){.newer = PSPLAT_TILE_NONE, .older = PSPLAT_TILE_NONE};
}

/* Finds what a tile knows of the tiles below it from its children. */
static void sum_up(psplat_tiles *t, uint32_t index) {
    const psplat_tile_node *node = &t->nodes[index];
    psplat_tile_use *use = &t->uses[index];
    memcpy(use->cone, node->cone, sizeof use->cone);
    use->child_error = 0.0;
    for (uint32_t i = 0; i < node->child_count; ++i) {
        uint32_t child = node->first_child + i;
        use->child_error = fmax(use->child_error, t->nodes[child].error);
        psplat_tile_cone_add(use->cone, t->uses[child].cone);
    }
    if (node->content_count && t->contents[node->first_content].is_tileset) use->cone[3] = -2.0;
}

psplat_result psplat_tiles_graft(psplat_tiles *t, psplat_tileset *tileset, uint32_t node,
                                 psplat_error *error) {
    if (t->node_count + tileset->node_count > PSPLAT_TILE_MAX_COUNT)
        return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 0, "there are more than %d tiles",
                           PSPLAT_TILE_MAX_COUNT);
    if (!reserve(t, tileset))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu tiles",
                           tileset->node_count);
    /* The root of the file takes the place of the tile that referred to it, so that all others have
     * numbers that are one lower. */
    uint32_t content = (uint32_t)t->content_count, base = (uint32_t)t->node_count;
    int is_first = node == PSPLAT_TILE_NONE;
    uint32_t shift = is_first ? 0 : base - 1, place = is_first ? 0 : node;
    uint32_t above = is_first ? PSPLAT_TILE_NONE : t->nodes[node].parent;
    add_contents(t, tileset, shift);
    add_node(t, &tileset->nodes[0], place, above, shift, content);
    for (uint32_t i = 1; i < tileset->node_count; ++i) {
        uint32_t parent = tileset->nodes[i].parent;
        add_node(t, &tileset->nodes[i], i + shift, parent ? parent + shift : place, shift, content);
    }
    for (uint32_t i = 0; i < t->nodes[place].content_count; ++i)
        t->contents[content + i].node = place;
    t->node_count += tileset->node_count - !is_first;
    memcpy(t->transforms + t->transform_count, tileset->transforms,
           tileset->transform_count * sizeof *t->transforms);
    t->transform_count += tileset->transform_count;
    for (size_t i = t->node_count; i-- > base;) sum_up(t, (uint32_t)i);
    for (uint32_t i = place; i != PSPLAT_TILE_NONE; i = t->nodes[i].parent) sum_up(t, i);
    t->kept[t->file_count++] = tileset->kept;
    psplat_arena_release(&tileset->scratch);
    return PSPLAT_OK;
}

int psplat_tile_is_ready(const psplat_tiles *tiles, uint32_t node) {
    const psplat_tile_node *n = &tiles->nodes[node];
    return n->content_count && tiles->uses[node].uploaded == n->content_count;
}

void psplat_tiles_free_tree(psplat_tiles *t) {
    for (size_t i = 0; i < t->file_count; ++i) psplat_arena_release(&t->kept[i]);
    for (unsigned i = 0; i < PSPLAT_TILE_TABLES; ++i) resize_table(t, (enum psplat_tile_table)i, 0);
}

/* ---- the list of tiles in memory ----------------------------------------------------------- */

void psplat_tile_unlist(psplat_tiles *t, uint32_t node) {
    psplat_tile_use *use = &t->uses[node];
    if (!use->is_listed) return;
    *(use->newer == PSPLAT_TILE_NONE ? &t->newest : &t->uses[use->newer].older) = use->older;
    *(use->older == PSPLAT_TILE_NONE ? &t->oldest : &t->uses[use->older].newer) = use->newer;
    use->is_listed = 0;
}

/* Puts a tile behind a newer one, or first where that is PSPLAT_TILE_NONE. */
static void insert_behind(psplat_tiles *t, uint32_t node, uint32_t newer) {
    psplat_tile_use *use = &t->uses[node];
    uint32_t *at = newer == PSPLAT_TILE_NONE ? &t->newest : &t->uses[newer].older;
    use->newer = newer;
    use->older = *at;
    *(use->older == PSPLAT_TILE_NONE ? &t->oldest : &t->uses[use->older].newer) = node;
    *at = node;
    use->is_listed = 1;
}

void psplat_tile_touch(psplat_tiles *t, uint32_t node) {
    if (!t->uses[node].is_listed || t->newest == node) return;
    psplat_tile_unlist(t, node);
    insert_behind(t, node, PSPLAT_TILE_NONE);
}

void psplat_tile_enlist(psplat_tiles *t, uint32_t node) {
    uint32_t parent = t->nodes[node].parent;
    if (t->uses[node].is_listed) return;
    int has_parent = parent != PSPLAT_TILE_NONE && t->uses[parent].is_listed;
    insert_behind(t, node, has_parent ? parent : PSPLAT_TILE_NONE);
}

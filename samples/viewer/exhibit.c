/* SPDX-License-Identifier: MIT
 *
 * exhibit.c - the models that are shown, and which errors there are to tell of.
 */
#include "viewer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *exhibit_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

/* ---- placing ------------------------------------------------------------------------------ */

/* Scaled to radius 1 and moved to x on the row. */
static void place_on_row(const sphere *from, double x, double transform[16], sphere *to) {
    double scale = from->radius > 0 ? 1 / from->radius : 1;
    *to = (sphere){{x, 0, 0}, from->radius * scale};
    memset(transform, 0, 16 * sizeof *transform);
    for (int i = 0; i < 3; ++i) {
        transform[i * 5] = scale;
        transform[12 + i] = to->center[i] - scale * from->center[i];
    }
    transform[15] = 1;
}

/* Around both; not the least, but exact where one lies within the other. */
static void join(sphere *a, const sphere *b) {
    double offset[3], square = 0;
    for (int i = 0; i < 3; ++i) {
        offset[i] = b->center[i] - a->center[i];
        square += offset[i] * offset[i];
    }
    double distance = sqrt(square);
    if (distance + b->radius <= a->radius) return;
    if (distance + a->radius <= b->radius) {
        *a = *b;
        return;
    }
    double radius = 0.5 * (distance + a->radius + b->radius);
    for (int i = 0; i < 3; ++i) a->center[i] += (radius - a->radius) / distance * offset[i];
    a->radius = radius;
}

void exhibit_arrange(exhibit *e) {
    e->item_count = e->splat_count = 0;
    e->bounds = (sphere){.radius = 0};
    for (size_t i = 0; i < e->entry_count; ++i) {
        const exhibit_entry *entry = &e->entries[i];
        if (!entry->model) continue;
        psplat_item *item = &e->items[e->item_count];
        sphere bounds = entry->bounds;
        *item = (psplat_item){.model = entry->model};
        if (e->is_side_by_side)
            place_on_row(&entry->bounds, 2.1 * (double)e->item_count, item->transform, &bounds);
        if (e->item_count++)
            join(&e->bounds, &bounds);
        else
            e->bounds = bounds;
        e->splat_count += entry->splat_count;
    }
}

/* ---- loads -------------------------------------------------------------------------------- */

static void free_entries(exhibit *e, exhibit_entry *entries, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        psplat_model_destroy(e->renderer, entries[i].model);
        free(entries[i].path);
    }
    free(entries);
}

/* Replaces the entry's model where the file could be opened, else notes the error. */
static void update_entry(exhibit *e, exhibit_entry *entry, const loaded_file *file) {
    psplat_model *model = NULL;
    entry->error = file->error;
    if (!file->asset || psplat_model_create(e->renderer, file->asset, &model, &entry->error))
        return;
    psplat_model_destroy(e->renderer, entry->model);
    entry->model = model;
    entry->bounds = file->bounds;
    entry->splat_count = file->splat_count;
    entry->error = (psplat_error){0};
}

static exhibit_change reload(exhibit *e, const load *l) {
    for (size_t i = 0; i < l->count; ++i)
        for (size_t k = 0; k < e->entry_count; ++k)
            if (!strcmp(e->entries[k].path, l->files[i].path))
                update_entry(e, &e->entries[k], &l->files[i]);
    *e->refused_path = 0;
    exhibit_arrange(e);
    return EXHIBIT_RELOADED;
}

static exhibit_change refuse(exhibit *e, const char *path, const psplat_error *error) {
    snprintf(e->refused_path, sizeof e->refused_path, "%s", path);
    e->refused = *error;
    return EXHIBIT_RELOADED;
}

/* A set of which nothing can be shown changes nothing. */
static exhibit_change replace(exhibit *e, const load *l) {
    exhibit_entry *entries = calloc(l->count, sizeof *entries);
    psplat_item *items = calloc(l->count, sizeof *items);
    size_t shown = 0;
    for (size_t i = 0; i < l->count && entries && items; ++i) {
        update_entry(e, &entries[i], &l->files[i]);
        entries[i].path = l->files[i].path;
        l->files[i].path = NULL;
        shown += entries[i].model != NULL;
    }
    if (!shown) {
        psplat_error memory = {.code = PSPLAT_ERROR_MEMORY};
        int is_ready = entries && items;
        exhibit_change change = refuse(e, is_ready ? entries[0].path : l->files[0].path,
                                       is_ready ? &entries[0].error : &memory);
        free_entries(e, entries, is_ready ? l->count : 0);
        free(items);
        return change;
    }
    free_entries(e, e->entries, e->entry_count);
    free(e->items);
    e->entries = entries;
    e->items = items;
    e->entry_count = l->count;
    *e->refused_path = 0;
    exhibit_arrange(e);
    return EXHIBIT_OPENED;
}

exhibit_change exhibit_take(exhibit *e, load *l) {
    exhibit_change change = l->is_reload ? reload(e, l) : replace(e, l);
    load_destroy(l);
    return change;
}

void exhibit_clear(exhibit *e) {
    free_entries(e, e->entries, e->entry_count);
    free(e->items);
    *e = (exhibit){.renderer = e->renderer};
}

const psplat_error *exhibit_error(const exhibit *e, const char **path) {
    *path = e->refused_path;
    if (*e->refused_path) return &e->refused;
    for (size_t i = 0; i < e->entry_count; ++i)
        if (e->entries[i].error.code) {
            *path = e->entries[i].path;
            return &e->entries[i].error;
        }
    return NULL;
}

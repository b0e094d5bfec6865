/* SPDX-License-Identifier: MIT
 *
 * animation.c - plays animations: every file plays the one of the chosen index, again and again.
 */
#include "viewer.h"

#include <math.h>

int animation_count(const shown_assets *s) {
    size_t most = 0;
    for (size_t i = 0; i < s->entry_count; ++i) {
        size_t count = psplat_asset_animation_count(s->entries[i].asset);
        most = count > most ? count : most;
    }
    return (int)most;
}

int animation_is_playing(const viewer *v) {
    return !v->settings.is_paused && animation_count(&v->shown) > 0;
}

const char *animation_name(const shown_assets *s, int index) {
    for (size_t i = 0; i < s->entry_count; ++i) {
        const psplat_animation *animation =
            psplat_asset_get_animation(s->entries[i].asset, (size_t)index);
        if (animation && *animation->name) return animation->name;
    }
    return "without a name";
}

/* A file without the animation is at rest, as is one whose numbers are too large for its pose. */
void animation_pose(shown_assets *s, int index, double seconds) {
    for (size_t i = 0; i < s->entry_count; ++i) {
        const shown_asset *entry = &s->entries[i];
        const psplat_animation *animation = psplat_asset_get_animation(entry->asset, (size_t)index);
        if (!entry->pose) continue;
        double time = animation && animation->duration > 0 ? fmod(seconds, animation->duration) : 0;
        if (!animation || psplat_pose_set(entry->pose, (size_t)index, time, NULL))
            psplat_pose_rest(entry->pose);
    }
}

void animation_advance(viewer *v, double now) {
    if (animation_is_playing(v)) {
        v->played += now - v->play_time;
        animation_pose(&v->shown, v->animation, v->played);
        v->needs_redraw = 1;
    }
    v->play_time = now;
}

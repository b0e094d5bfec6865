/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texture_repeats.c - how far texture coordinates may move without changing what a material shows.
 */
#include "material/texture_repeats.h"

#include <math.h>
#include <string.h>

void psplat_texture_move(const psplat_texture *texture, int axis, double move[2]) {
    static const float none[6];
    int is_identity = memcmp(texture->transform, none, sizeof none) == 0;
    for (int k = 0; k < 2; ++k)
        move[k] = is_identity ? k == axis : (double)texture->transform[3 * k + axis];
}

/* Returns whether a texture stays the same where coordinates move by so many units of an axis. */
static int repeats_after(const psplat_texture *texture, int axis, int units) {
    double move[2];
    psplat_texture_move(texture, axis, move);
    for (int k = 0; k < 2; ++k) {
        double periods = units * move[k] / (texture->wrap[k] == PSPLAT_WRAP_MIRROR ? 2 : 1);
        if (texture->wrap[k] == PSPLAT_WRAP_CLAMP ? periods != 0 : periods != rint(periods))
            return 0;
    }
    return 1;
}

int psplat_textures_repeat(const psplat_texture textures[PSPLAT_TEXTURE_SLOTS], int axis) {
    for (int units = 1; units <= 2; ++units) {
        int all = 1;
        for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot)
            if (textures[slot].image) all &= repeats_after(&textures[slot], axis, units);
        if (all) return units;
    }
    return 0;
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * effort.c - the rounds that each effort buys.
 */
#include "select/effort.h"

/* The rounds of PSPLAT_EFFORT_NONE, and of efforts from 1 on. Without a
 * search splats overlap more, so that rays find fewer gaps between them. Chosen by hand. */
static const psplat_effort none = {0, 1};
static const psplat_effort efforts[PSPLAT_GREATEST_EFFORT] = {
    {1, 2}, {2, 3}, {3, 4}, {4, 4}, {6, 4}, {9, 4}, {13, 4}, {18, 4}, {25, 4}};

psplat_effort psplat_effort_of(const psplat_convert_desc *desc) {
    int effort = desc->effort ? desc->effort : PSPLAT_DEFAULT_EFFORT;
    return effort == PSPLAT_EFFORT_NONE ? none : efforts[effort - 1];
}

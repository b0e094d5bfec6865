/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * stamp.c - FNV-1a (Fowler, Noll, Vo): tells changed files and options apart, no more than that.
 */
#include "tradeoff.h"

#include <string.h>

uint64_t psplat_stamp_bytes(uint64_t stamp, const void *data, size_t size) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; ++i) stamp = (stamp ^ bytes[i]) * UINT64_C(0x100000001b3);
    return stamp ? stamp : 1;
}

/* Both zeros are one number. */
uint64_t psplat_stamp_number(uint64_t stamp, double number) {
    double value = number == 0 ? 0 : number;
    return psplat_stamp_bytes(stamp, &value, sizeof value);
}

/* With its end, so that "ab" "c" and "a" "bc" differ. */
uint64_t psplat_stamp_text(uint64_t stamp, const char *text) {
    return psplat_stamp_bytes(stamp, text, strlen(text) + 1);
}

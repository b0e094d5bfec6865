/* SPDX-License-Identifier: MIT
 *
 * memory.c - the reference rasteriser's memory, which comes from the C library.
 */
#include "reference/oracle.h"

#include <stdlib.h>

void *psplat_oracle_allocate(size_t count, size_t size) {
    return calloc(count ? count : 1, size);
}

void psplat_oracle_release(void *memory) {
    free(memory);
}

/* SPDX-License-Identifier: MIT
 *
 * table_rows.h - a sphere of splats as integers (spec 3.9), 20 bytes each in one interleaved view,
 * in spatial order: what files of the converter are like, at any size and in no time.
 */
#ifndef PHONGSPLAT_BENCH_ROWS_H
#define PHONGSPLAT_BENCH_ROWS_H

#include <stddef.h>
#include <stdint.h>

/* A GLB (malloc, owned by the caller) with the view as it is or by EXT_meshopt_compression; NULL
 * where the build lacks the library. Ends the program where there is no memory. */
uint8_t *rows_glb(size_t splat_count, int is_compressed, size_t *size);

#endif

/* SPDX-License-Identifier: MIT
 *
 * table_rows.h - a sphere of splats as integers (spec 3.9), 20 bytes each in one interleaved view,
 * in spatial order. It resembles files of the converter and is made at once in any size.
 */
#ifndef PHONGSPLAT_BENCH_TABLE_ROWS_H
#define PHONGSPLAT_BENCH_TABLE_ROWS_H

#include <stddef.h>
#include <stdint.h>

/* Returns a GLB, allocated with malloc and owned by the caller, whose view is uncompressed or
 * compressed with EXT_meshopt_compression. Returns NULL where the build lacks the library. Ends the
 * program where there is no memory. */
uint8_t *rows_glb(size_t splat_count, int is_compressed, size_t *size);

#endif

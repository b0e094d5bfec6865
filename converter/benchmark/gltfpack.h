/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * gltfpack.h - runs gltfpack, a mesh simplifier, on the source.
 */
#ifndef PHONGSPLAT_BENCHMARK_GLTFPACK_H
#define PHONGSPLAT_BENCHMARK_GLTFPACK_H

#include <phongsplat/splat.h>

/* gltfpack of meshoptimizer, which simplifies with attributes in mind (-sv) to a ratio of the
 * triangles (-si) at whatever error it takes (-se 1). */
typedef struct psplat_gltfpack {
    const char *program; /* as given, or "gltfpack" */
    char version[128];   /* as it calls itself; "": cannot be run */
} psplat_gltfpack;

/* Looks for a program; NULL stands for the one in PATH, if there is one. */
psplat_gltfpack psplat_gltfpack_find(const char *program);
/* Tells whether it reads the format of a file, by the name's extension. */
int psplat_gltfpack_reads(const char *path);
/* Writes a file with further options, NULL at the end: "-cc" for its bytes; "-noq" for a file
 * without extensions of the same triangles. output must end in .glb. Fails with READ. */
psplat_result psplat_gltfpack_run(const psplat_gltfpack *gltfpack, const char *input, double ratio,
                                  const char *const *options, const char *output,
                                  psplat_error *error);

#endif

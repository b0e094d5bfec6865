/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * triangle_stream.h - the triangles of a file one after the other, in bounded memory.
 *
 * Binary STL and binary PLY are mapped and never held as a whole. Other files are read as
 * import/read_mesh.h does, so that they have to fit into memory.
 */
#ifndef PHONGSPLAT_IMPORT_TRIANGLE_STREAM_H
#define PHONGSPLAT_IMPORT_TRIANGLE_STREAM_H

#include <phongsplat/splat.h>

#include <stddef.h>
#include <stdint.h>

/* A triangle in the coordinates of the file. */
typedef struct psplat_stream_triangle {
    double positions[9]; /* of three corners */
    float normals[9];    /* unit length or 0 0 0; set where the stream has_normals */
    float colors[12];    /* linear RGBA; set where the stream has_colors */
} psplat_stream_triangle;

/* Triangles of a file in its order, polygons split as other readers do. */
typedef struct psplat_triangle_stream psplat_triangle_stream;

/* What all triangles of a stream have in common. */
typedef struct psplat_stream_content {
    int has_normals, has_colors;
    int is_single;            /* positions have single precision */
    int is_mapped;            /* the file is streamed; else it is in memory */
    int has_material;         /* material is the file's; else colours say what it is */
    psplat_material material; /* factors common to all triangles, if has_material */
} psplat_stream_content;

/* Opens a file before its first triangle. Errors are those of psplat_mesh_read, and
 * PSPLAT_ERROR_UNSUPPORTED for a mesh with textures. */
psplat_result psplat_triangle_stream_open(const char *path, psplat_triangle_stream **stream,
                                          psplat_error *error);

const psplat_stream_content *psplat_triangle_stream_content(const psplat_triangle_stream *stream);

/* Stores the next triangle and sets *got, or clears it after the last one. Errors:
 * PSPLAT_ERROR_FORMAT (the file ends too early), PSPLAT_ERROR_RANGE (an index, a coordinate),
 * PSPLAT_ERROR_MEMORY. They name file and byte. */
psplat_result psplat_triangle_stream_next(psplat_triangle_stream *stream,
                                          psplat_stream_triangle *triangle, int *got,
                                          psplat_error *error);

/* Goes back to before the first triangle. */
void psplat_triangle_stream_rewind(psplat_triangle_stream *stream);

void psplat_triangle_stream_close(psplat_triangle_stream *stream);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * source_file.h - a source file in memory, and the recognition of its format.
 */
#ifndef PHONGSPLAT_SOURCE_SOURCE_FILE_H
#define PHONGSPLAT_SOURCE_SOURCE_FILE_H

#include <phongsplat/splat.h>

#include "base/path.h"
#include "source/obj_faces.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The formats that are read. */
typedef enum psplat_source_format {
    PSPLAT_SOURCE_UNKNOWN = 0,
    PSPLAT_SOURCE_OBJ,
    PSPLAT_SOURCE_PLY,
    PSPLAT_SOURCE_OFF,
    PSPLAT_SOURCE_STL_TEXT,
    PSPLAT_SOURCE_STL_BINARY,
    PSPLAT_SOURCE_GLTF,
    PSPLAT_SOURCE_GLB,
    PSPLAT_SOURCE_XYZ
} psplat_source_format;

/* A file, and what the checks have found out about it. Zero-initialise; psplat_source_free releases
 * it. */
typedef struct psplat_source {
    const char *file;             /* its path as the caller gave it */
    char path[PSPLAT_SHOWN_PATH]; /* the same, shortened for messages */
    char *data;                   /* the whole file with a 0 byte after it */
    size_t size;
    psplat_source_format format;
    size_t vertices;      /* in the file */
    size_t faces;         /* in the file, less the dropped ones */
    size_t normals;       /* in an OBJ */
    size_t dropped;       /* faces with fewer than three different vertices */
    int has_colors;       /* every vertex has a colour */
    int is_point_set;     /* vertices alone, no faces */
    double *positions;    /* vertices x 3, if the file has more than single precision; or NULL */
    psplat_obj_faces obj; /* of an OBJ */
} psplat_source;

/* Loads a whole file and recognises its format by its content or, if that fails, by its extension.
 * Errors: PSPLAT_ERROR_READ, PSPLAT_ERROR_RANGE (too large), PSPLAT_ERROR_FORMAT (empty, or not the
 * format of its extension), PSPLAT_ERROR_UNSUPPORTED, PSPLAT_ERROR_MEMORY. */
psplat_result psplat_source_load(const char *path, psplat_source *source, psplat_error *error);

/* Frees the content and all that the checks have stored. */
void psplat_source_free(psplat_source *source);

/* Returns whether the file is a .gltf or a .glb. */
int psplat_source_is_gltf(const psplat_source *source);

#ifdef __cplusplus
}
#endif
#endif

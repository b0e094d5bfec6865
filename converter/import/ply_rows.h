/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * ply_rows.h - the header of a binary PLY file, and its rows, read where they lie.
 */
#ifndef PHONGSPLAT_IMPORT_PLY_ROWS_H
#define PHONGSPLAT_IMPORT_PLY_ROWS_H

#include <stddef.h>
#include <stdint.h>

/* The types of PLY; their order is that of check_ply.c. */
typedef enum psplat_ply_type {
    PSPLAT_PLY_INT8,
    PSPLAT_PLY_UINT8,
    PSPLAT_PLY_INT16,
    PSPLAT_PLY_UINT16,
    PSPLAT_PLY_INT32,
    PSPLAT_PLY_UINT32,
    PSPLAT_PLY_FLOAT32,
    PSPLAT_PLY_FLOAT64,
    PSPLAT_PLY_TYPES
} psplat_ply_type;

enum { PSPLAT_PLY_PROPERTIES = 32 };

/* A property of faces. */
typedef struct psplat_ply_property {
    psplat_ply_type type, count_type;
    int is_list, is_corners;
} psplat_ply_property;

/* Where rows lie and what is in them. Offsets within a vertex are -1 for what it lacks. */
typedef struct psplat_ply_rows {
    int is_big;                           /* big endian */
    size_t vertices, faces;               /* numbers of rows */
    size_t first_vertex;                  /* the offset of the first vertex in the file */
    size_t vertex_size;                   /* bytes of each */
    psplat_ply_type scalars;              /* of x, y and z: FLOAT32 or FLOAT64 */
    int position[3], normal[3], color[4]; /* floats of normals; bytes of red, green, blue, alpha */
    size_t property_count;
    psplat_ply_property properties[PSPLAT_PLY_PROPERTIES]; /* of faces */
} psplat_ply_rows;

/* Reads the header at the begin of size bytes. Returns 0 unless the file is a binary PLY whose rows
 * can be read in place: vertices, then faces; x, y and z of one floating type; normals, if any, as
 * floats and colours as bytes; vertices without lists that all lie in the file; one list of
 * corners. Other files, malformed ones too, are for the ordinary reader. */
int psplat_ply_rows_open(const char *data, size_t size, psplat_ply_rows *rows);

/* Returns the bytes of a type. */
size_t psplat_ply_size(psplat_ply_type type);

/* Returns the number of a type that lies at data. */
double psplat_ply_value(const psplat_ply_rows *rows, psplat_ply_type type, const char *data);

#endif

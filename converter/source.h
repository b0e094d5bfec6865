/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * source.h - what mesh.c and its readers share: a file in memory, the checks that run over it
 * before a library parses it, and the raw mesh that comes out.
 *
 * OpenMesh reads leniently: a missing number repeats the one before, a header that promises too
 * much is believed, some broken headers never end. So each of its formats has a strict pass of our
 * own first (check_*), which names line or byte of what is wrong, counts what a complete reading
 * must yield, and blanks what OpenMesh would stumble over. The library then reads the same bytes.
 */
#ifndef PHONGSPLAT_SOURCE_H
#define PHONGSPLAT_SOURCE_H

#include "scenes.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Limits of what is read: an index and two bits fit into 32 bits, a byte offset into 32. */
#define PSPLAT_MAX_SOURCE_BYTES 0xffffffffu
#define PSPLAT_MAX_TRIANGLES 0x3fffffffu
#define PSPLAT_MAX_VERTICES 0x7ffffffeu
#define PSPLAT_MAX_CORNERS 4096u /* of one polygon */
#define PSPLAT_MAX_OBJ_MATERIALS 4096

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

/* What an OBJ says of its faces beside their vertices, as its check reads it: OpenMesh is told
 * nothing of materials, since it would open whatever file they name. Of a vertex that a face names
 * several times only the first corner counts, as OpenMesh has it. */
typedef struct psplat_obj_faces {
    float *texcoords; /* texcoord_count x 2, as in the file: v runs upwards */
    size_t texcoord_count, texcoord_capacity;
    uint32_t *corners; /* of the faces kept: texture coordinate, or UINT32_MAX */
    size_t corner_count, corner_capacity;
    uint32_t
        *groups; /* of each face kept: number of its material's name; name_count: it has none */
    size_t face_count, face_capacity;
    char **names; /* as usemtl has them, malloc'ed */
    size_t name_count;
    char *library; /* the first mtllib, malloc'ed, or NULL */
    uint32_t group;
} psplat_obj_faces;

/* A file and what the checks found out about it. Zero-initialise; psplat_source_free releases. */
typedef struct psplat_source {
    const char *file;             /* its path as the caller gave it */
    char path[PSPLAT_SHOWN_PATH]; /* the same for messages */
    char *data;                   /* the whole file with a 0 byte after it */
    size_t size;
    psplat_source_format format;
    size_t vertices;   /* in the file */
    size_t faces;      /* in the file, less the dropped ones */
    size_t dropped;    /* faces with fewer than three different vertices */
    int has_colors;    /* every vertex has a colour */
    int is_point_set;  /* vertices alone, no faces */
    double *positions; /* vertices x 3, where the file says more than single precision; or NULL */
    psplat_obj_faces obj; /* of an OBJ */
} psplat_source;

/* source.c: loads the whole file (READ, RANGE, MEMORY; FORMAT where it is empty) and recognises its
 * format by content, then by extension (UNSUPPORTED). */
psplat_result psplat_source_load(const char *path, psplat_source *source, psplat_error *error);
void psplat_source_free(psplat_source *source);

int psplat_source_is_gltf(const psplat_source *source);

/* bytes.c: a whole file, the source itself or an external buffer of a .gltf (READ, RANGE, MEMORY).
 * *data is malloc'ed, with a 0 byte after *size bytes. */
psplat_result psplat_source_read_file(const char *path, char **data, size_t *size,
                                      psplat_error *error);

/* check_obj.c, check_off.c, check_ply.c, check_stl.c: fill the counts of source, or fail with the
 * line (text) or byte (binary) of what is wrong. */
psplat_result psplat_check_obj(psplat_source *source, psplat_error *error);
psplat_result psplat_check_off(psplat_source *source, psplat_error *error);
psplat_result psplat_check_ply(psplat_source *source, psplat_error *error);
psplat_result psplat_check_stl(psplat_source *source, psplat_error *error);

/* obj_faces.c: what check_obj.c has seen: a texture coordinate, a corner that has one (or
 * UINT32_MAX), the end of a face that is kept (and how many corners it had), or is not, names. Line
 * ends may be in names. MEMORY; RANGE, without a text: too many materials. */
psplat_result psplat_obj_texcoord(psplat_obj_faces *faces, double u, double v, psplat_error *error);
psplat_result psplat_obj_corner(psplat_obj_faces *faces, uint32_t texcoord, psplat_error *error);
psplat_result psplat_obj_face(psplat_obj_faces *faces, psplat_error *error);
psplat_result psplat_obj_material(psplat_obj_faces *faces, const char *name, psplat_error *error);
psplat_result psplat_obj_library(psplat_obj_faces *faces, const char *name, psplat_error *error);
/* Coordinates of a corner in an image, as glTF has them: t runs downwards. 0 0 where it has none.
 */
void psplat_obj_uv(const psplat_obj_faces *faces, size_t corner, float uv[2]);
void psplat_obj_faces_free(psplat_obj_faces *faces);

/* mtl.c: the appearances of an OBJ, by the numbers of its materials' names, then that of faces
 * without one; images beside the library. Files that cannot be read leave problems in the palette
 * and its images. base: what a material is where the library says nothing. MEMORY. */
psplat_result psplat_mtl_read(const psplat_source *source, const psplat_material *base,
                              psplat_palette *palette, psplat_error *error);

/* lines.c: a cursor over the text of a source, one line at a time. Lines end with a newline, which
 * is replaced by 0 while the line is the current one. */
typedef struct psplat_lines {
    psplat_source *source;
    char *line;    /* the current line */
    char *cursor;  /* where the next token of it starts */
    char *next;    /* the line after it */
    size_t number; /* of the current line, from 1 */
    char ended_by; /* the byte that 0 replaced */
} psplat_lines;

psplat_lines psplat_lines_begin(psplat_source *source);
/* Moves to the next line; returns 0 at the end. */
int psplat_lines_next(psplat_lines *lines);
/* Gives the current line its newline back; call it once before the text goes to somebody else. */
void psplat_lines_end(psplat_lines *lines);
/* Next token of the line, its length in *length, or NULL. Tokens are separated by blanks. */
char *psplat_lines_token(psplat_lines *lines, size_t *length);
/* Next token as a finite number that single precision can hold, or as a count. what names it in the
 * error: "path: line 7: the y coordinate ..." */
psplat_result psplat_lines_number(psplat_lines *lines, const char *what, double *value,
                                  psplat_error *error);
psplat_result psplat_lines_count(psplat_lines *lines, const char *what, size_t *value,
                                 psplat_error *error);
/* "path: line 7: " and the printf-style rest. */
psplat_result psplat_lines_fail(const psplat_lines *lines, psplat_error *error, psplat_result code,
                                const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 4, 5)))
#endif
    ;

/* rewrite.c: text or bytes that replace the content of a source. Zero-initialise; after a failure
 * free data. */
typedef struct psplat_rewrite {
    char *data;
    size_t size, capacity;
} psplat_rewrite;

psplat_result psplat_rewrite_bytes(psplat_rewrite *rewrite, const void *bytes, size_t size,
                                   psplat_error *error);
/* printf into it. */
psplat_result psplat_rewrite_text(psplat_rewrite *rewrite, psplat_error *error, const char *format,
                                  ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;
/* Puts it in the place of the source's content. */
void psplat_rewrite_replace(psplat_rewrite *rewrite, psplat_source *source);

/* polygon.c: splits the polygon with corners at points (count x 3) into count - 2 triangles of
 * corner numbers by clipping ears, so that concave polygons stay right. triangles holds (count - 2)
 * x 3. */
psplat_result psplat_polygon_triangulate(const double *points, size_t count, uint32_t *triangles,
                                         psplat_error *error);

/* The optional arrays of a mesh. */
#define PSPLAT_MESH_NORMALS 1u
#define PSPLAT_MESH_COLORS 2u
#define PSPLAT_MESH_GROUPS 4u
#define PSPLAT_MESH_TANGENTS 8u
#define PSPLAT_MESH_UVS 16u /* << which of them */

/* mesh.c: allocates the arrays of a mesh, zeroed; parts are the optional ones, or-ed. */
psplat_result psplat_mesh_allocate(psplat_mesh *mesh, size_t vertex_count, size_t triangle_count,
                                   unsigned parts, psplat_error *error);

/* What lives on corners, of any kind: whoever moves corners moves all of it. */
#define PSPLAT_CORNER_ARRAYS (3 + PSPLAT_TEXCOORDS)

typedef struct psplat_corners {
    float *values;
    size_t components; /* of each corner */
} psplat_corners;

/* mesh.c: those that the mesh has; returns their number. */
size_t psplat_mesh_corners(const psplat_mesh *mesh, psplat_corners arrays[PSPLAT_CORNER_ARRAYS]);

/* mesh.c: a raw mesh becomes what psplat_mesh_read promises; label names it in errors. Without
 * has_material it gets one that suits its colours and whether it is closed. */
psplat_result psplat_mesh_clean(psplat_mesh *mesh, const char *label, int has_material,
                                psplat_error *error);
/* The same from a loaded file. The mesh is freed by the caller also where it fails. */
psplat_result psplat_mesh_from_source(psplat_source *source, psplat_mesh *mesh,
                                      psplat_error *error);

/* weld.c, seam.c and orient.c: the steps between a raw mesh and what psplat_mesh_read promises, in
 * order. */
psplat_result psplat_mesh_weld(psplat_mesh *mesh, psplat_error *error);
/* Keeps one of several triangles with the same corners. *turned: some faced the other way, so that
 * both sides of what is kept were meant to be seen. */
psplat_result psplat_mesh_drop_repeated(psplat_mesh *mesh, int *turned, psplat_error *error);
/* Joins border vertices that differ by rounding alone. *closed: every edge has then exactly two
 * triangles. */
psplat_result psplat_mesh_close_seams(psplat_mesh *mesh, int *closed, psplat_error *error);
/* Orients the triangles of each component alike. *consistent: it could be done everywhere. */
psplat_result psplat_mesh_orient(psplat_mesh *mesh, int *consistent, psplat_error *error);
void psplat_mesh_drop_flat(psplat_mesh *mesh);

/* adapter_openmesh.cpp (OBJ, PLY, OFF, STL) and adapter_gltf.cpp (glTF, GLB) fill a raw mesh:
 * unwelded, not recentred, every index in range. Faces that the checks dropped are counted. */
psplat_result psplat_mesh_read_openmesh(const psplat_source *source, psplat_mesh *mesh,
                                        psplat_error *error);
psplat_result psplat_mesh_read_gltf(const psplat_source *source, psplat_mesh *mesh,
                                    psplat_error *error);

/* adapter_gltf.cpp: the same of each mesh of the scene, and all else that the scene has; freed by
 * the caller also where it fails. */
psplat_result psplat_scene_read_gltf(const psplat_source *source, psplat_scene *scene,
                                     psplat_error *error);

/* transform.c: refuses nodes that are nowhere, since their numbers overflow; warns of flattening.
 */
psplat_result psplat_scene_check(psplat_scene *scene, const char *path, psplat_error *error);

/* Point sets: adapter_openmesh.cpp (PLY and OFF without faces), and xyz.c, which checks as it
 * reads.
 */
psplat_result psplat_points_read_openmesh(const psplat_source *source, psplat_points *points,
                                          psplat_error *error);
psplat_result psplat_points_read_xyz(psplat_source *source, psplat_points *points,
                                     psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif

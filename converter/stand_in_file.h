/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * stand_in_file.h - meshes that stand in for splats as a file holds them: views, accessors, meshes
 * (spec 6.1). For the writer: columns.c, layout.c, stand_in_file.c, document.c, glb.c.
 */
#ifndef PHONGSPLAT_STAND_IN_FILE_H
#define PHONGSPLAT_STAND_IN_FILE_H

#include "layout.h"
#include "materials.h"
#include "stand_in.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One mesh. Its views follow one another: positions, normals, colours where there are any,
 * indices. Its accessors do likewise, with one for the indices of each part. */
typedef struct psplat_stand_in_sheet {
    const psplat_stand_in *stand_in; /* NULL: none */
    psplat_column position, normal;
    float low[3], high[3]; /* of positions as written */
    size_t first_view, first_accessor;
} psplat_stand_in_sheet;

/* Zero-initialised: none. */
typedef struct psplat_stand_in_file {
    psplat_stand_in_sheet *sheets; /* mesh_count, as there are sheets of splats */
    psplat_file_view *views;
    size_t mesh_count, view_count, accessor_count;
} psplat_stand_in_file;

/* Stores the stand-ins in the space of the splats of their meshes. codec NULL: not compressed.
 * Errors: MEMORY. psplat_stand_in_file_free also then. */
psplat_result psplat_stand_in_file_make(const psplat_stand_in *stand_ins,
                                        const psplat_sheet *sheets, size_t mesh_count,
                                        const psplat_codec *codec, psplat_stand_in_file *file,
                                        psplat_error *error);
void psplat_stand_in_file_free(psplat_stand_in_file *file);

/* Adds the materials of stand-ins. MEMORY. */
psplat_result psplat_stand_in_file_collect(const psplat_stand_in_file *file,
                                           const psplat_scene *scene, psplat_materials *materials);

/* Members of an element of "meshes". first_accessor: in the file, of all stand-ins; splat_mesh: the
 * index in the file of the mesh with the splats. */
void psplat_stand_in_file_write_mesh(psplat_writer *json, const psplat_stand_in_sheet *sheet,
                                     const psplat_scene *scene, const psplat_materials *materials,
                                     size_t first_accessor, size_t splat_mesh);
/* Elements of "accessors". first_view: in the file, of all stand-ins. */
void psplat_stand_in_file_write_accessors(psplat_writer *json, const psplat_stand_in_file *file,
                                          size_t first_view);

#ifdef __cplusplus
}
#endif
#endif

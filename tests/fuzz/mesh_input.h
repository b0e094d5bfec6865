/* SPDX-License-Identifier: MIT
 *
 * mesh_input.h - the fuzz input as the content of files that psplat_mesh_read and psplat_scene_read
 * open, by a linker's wrap of psplat_file_read, and what holds of every mesh that is read.
 * Points that are read are checked and go no further, by a wrap of psplat_mesh_from_points:
 * connecting them takes a hundred times as long; see fuzz_cloud.c.
 */
#ifndef PHONGSPLAT_FUZZ_MESH_INPUT_H
#define PHONGSPLAT_FUZZ_MESH_INPUT_H

#include "fuzz.h"
#include "mesh/mesh.h"
#include "scene/scene.h"

/* Reads the input as a file of each of the names that its content leaves open, checks what comes
 * out, or that the error is told, and hands each mesh to use (may be NULL). */
void fuzz_read_mesh(const uint8_t *data, size_t size, void (*use)(const psplat_mesh *mesh));

/* The same of a whole scene; of glTF and GLB alone, since of other files a scene is what their mesh
 * is. */
void fuzz_read_scene(const uint8_t *data, size_t size, void (*use)(const psplat_scene *scene));

/* The promises of converter.h. */
void fuzz_check_mesh(const psplat_mesh *mesh);

#endif

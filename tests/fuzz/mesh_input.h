/* SPDX-License-Identifier: MIT
 *
 * mesh_input.h - makes the fuzz input the content of files that psplat_mesh_read and
 * psplat_scene_read open, by a linker's wrap of psplat_file_read, and checks what must hold for
 * every mesh that is read. Points that are read are checked but not connected, by a wrap of
 * psplat_mesh_from_points, because connecting them takes a hundred times as long; see
 * fuzz_cloud.c.
 */
#ifndef PHONGSPLAT_FUZZ_MESH_INPUT_H
#define PHONGSPLAT_FUZZ_MESH_INPUT_H

#include "fuzz.h"
#include "mesh/mesh.h"
#include "scene/scene.h"

/* Reads the input as a file of each of the names that its content permits. Checks the result, or
 * that the error is described, and hands each mesh to use (may be NULL). */
void fuzz_read_mesh(const uint8_t *data, size_t size, void (*use)(const psplat_mesh *mesh));

/* Does the same for whole scenes. Only glTF and GLB are read, since for other files a scene is the
 * same as their mesh. */
void fuzz_read_scene(const uint8_t *data, size_t size, void (*use)(const psplat_scene *scene));

/* Demands the promises of psplat_mesh_read (import/read_mesh.h). */
void fuzz_check_mesh(const psplat_mesh *mesh);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * animation_file.h - animations in a glTF file: buffer views, accessors and the animations
 * themselves (glTF 2.0 section 3.11).
 *
 * They lie behind the splats and the fallback meshes: each track is an accessor, in the order of
 * the scene, and tracks of as many components share a view.
 */
#ifndef PHONGSPLAT_EXPORT_ANIMATION_FILE_H
#define PHONGSPLAT_EXPORT_ANIMATION_FILE_H

#include "base/json_writer.h"
#include "export/buffer_layout.h"
#include "export/meshopt_codec.h"
#include "scene/scene.h"

#include <phongsplat/splat.h>

/* The animations of a file. A zero-initialised struct has none. */
typedef struct psplat_animation_file {
    psplat_attribute_place *places; /* of each track; view is an index into views */
    psplat_buffer_view views[3];    /* times, vectors, quaternions, as far as there are any */
    size_t view_count;
} psplat_animation_file;

/* Stores the tracks of a scene as floats. A codec of NULL leaves the views uncompressed. The caller
 * frees *file with psplat_animation_file_free, also after an error. Errors: MEMORY. */
psplat_result psplat_animation_file_make(const psplat_scene *scene, const psplat_codec *codec,
                                         psplat_animation_file *file, psplat_error *error);
void psplat_animation_file_free(psplat_animation_file *file);

/* Writes elements of "accessors". first_view is the index in the file of the first of the views. */
void psplat_animation_file_write_accessors(psplat_writer *json, const psplat_animation_file *file,
                                           const psplat_scene *scene, size_t first_view);

/* Writes the member "animations" of the root, if there are any. first_accessor is the index in the
 * file of the first track. */
void psplat_animation_file_write(psplat_writer *json, const psplat_scene *scene,
                                 size_t first_accessor);

#endif

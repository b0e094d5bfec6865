/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * scene.h - the scene graph of a source file: meshes, materials, nodes, cameras, lights and
 * animations.
 *
 * Strings are malloc'ed UTF-8, or NULL if the file has none. extras are JSON text of any kind.
 */
#ifndef PHONGSPLAT_SCENE_SCENE_H
#define PHONGSPLAT_SCENE_SCENE_H

#include "base/path.h"
#include "material/source_materials.h"
#include "mesh/mesh.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The index of no mesh, node, camera, light or scene. */
#define PSPLAT_NO_INDEX UINT32_MAX

/* A mesh in its own coordinates. */
typedef struct psplat_scene_mesh {
    psplat_mesh mesh; /* without triangles if nothing of it can become splats */
    char *name, *extras;
} psplat_scene_mesh;

/* A node of the graph. Its transform is a matrix, or translation, rotation and scale, as in the
 * file (glTF 2.0 section 3.5.3). */
typedef struct psplat_scene_node {
    char *name, *extras;
    int has_matrix;
    double matrix[16];                            /* column-major */
    double translation[3], rotation[4], scale[3]; /* 0 0 0, 0 0 0 1, 1 1 1 where not in the file */
    uint32_t mesh, camera, light;                 /* or PSPLAT_NO_INDEX */
    int is_animated;                              /* a channel moves it; then it has no matrix */
    uint32_t *children;
    size_t child_count;
} psplat_scene_node;

/* A camera (glTF 2.0 section 3.10). */
typedef struct psplat_scene_camera {
    char *name, *extras;
    int is_orthographic;
    double aspect_ratio, yfov; /* perspective; aspect ratio 0: not given */
    double xmag, ymag;         /* orthographic */
    double znear, zfar;        /* zfar 0: not given */
} psplat_scene_camera;

typedef enum psplat_scene_light_type {
    PSPLAT_SCENE_DIRECTIONAL = 0,
    PSPLAT_SCENE_POINT,
    PSPLAT_SCENE_SPOT
} psplat_scene_light_type;

/* A light (KHR_lights_punctual). */
typedef struct psplat_scene_light {
    char *name, *extras;
    psplat_scene_light_type type;
    double color[3], intensity;
    double range;                  /* 0: not given */
    double inner_cone, outer_cone; /* of spot lights */
} psplat_scene_light;

/* One of the scenes of the file: the trees of nodes that are shown together. */
typedef struct psplat_scene_view {
    char *name, *extras;
    uint32_t *roots; /* indices of nodes */
    size_t root_count;
} psplat_scene_view;

/* Numbers that samplers of animations read: times, or what a node's transform is at these. */
typedef struct psplat_scene_track {
    float *values;     /* count elements of so many components */
    size_t count;      /* at least 1 */
    size_t components; /* 1: times in seconds, which increase from 0 or more; 3; 4: quaternions */
} psplat_scene_track;

typedef enum psplat_scene_interpolation {
    PSPLAT_SCENE_LINEAR = 0,
    PSPLAT_SCENE_STEP,
    PSPLAT_SCENE_CUBICSPLINE
} psplat_scene_interpolation;

/* Two tracks and how to interpolate between their keys (glTF 2.0 appendix C). The values are as
 * many as the times, or three times as many where splines have tangents. */
typedef struct psplat_scene_sampler {
    uint32_t times, values;
    psplat_scene_interpolation interpolation;
} psplat_scene_sampler;

typedef enum psplat_scene_path {
    PSPLAT_SCENE_TRANSLATION = 0,
    PSPLAT_SCENE_ROTATION,
    PSPLAT_SCENE_SCALE
} psplat_scene_path;

/* What of which node a sampler moves. */
typedef struct psplat_scene_channel {
    uint32_t sampler, node;
    psplat_scene_path path;
} psplat_scene_channel;

/* An animation (glTF 2.0 section 3.11). */
typedef struct psplat_scene_animation {
    char *name, *extras;
    psplat_scene_sampler *samplers;
    size_t sampler_count;
    psplat_scene_channel *channels; /* no two of them move the same */
    size_t channel_count;           /* at least 1 */
} psplat_scene_animation;

/* All that is read from a file. It is empty if zero-initialised. */
typedef struct psplat_scene {
    psplat_scene_mesh *meshes;
    size_t mesh_count;
    psplat_source_materials materials; /* those of the file, then the default; groups index it */
    psplat_scene_node *nodes;          /* a forest of trees, at most 64 deep */
    size_t node_count;
    psplat_scene_camera *cameras;
    size_t camera_count;
    psplat_scene_light *lights;
    size_t light_count;
    psplat_scene_view *scenes;
    size_t scene_count;
    psplat_scene_animation *animations;
    size_t animation_count;
    psplat_scene_track *tracks; /* of all animations, which may share them */
    size_t track_count;
    uint32_t default_scene; /* or PSPLAT_NO_INDEX */
    int is_made;            /* the file has no graph, so that one node with one mesh was made */
    char *copyright, *asset_extras, *extras;
    char **warnings; /* one line each, without the name of the file */
    size_t warning_count;
} psplat_scene;

/* Frees all that the scene holds and makes it empty. */
void psplat_scene_free(psplat_scene *scene);

/* Adds a printf-style warning unless the scene has the same warning already. It is left out if
 * there is no memory. */
void psplat_scene_warn(psplat_scene *scene, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* Stores the name of a mesh for messages, such as "mesh 3 'Teapot'". */
void psplat_scene_label(const psplat_scene *scene, size_t mesh, char label[PSPLAT_SHOWN_PATH]);

#ifdef __cplusplus
}
#endif
#endif

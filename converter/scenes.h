/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * scenes.h - a whole file: meshes, what they look like, and the graph that places them.
 *
 *     psplat_scene_read -> psplat_scene_convert (each mesh) -> psplat_glb_write (the same graph)
 *
 * What an index names keeps its index: nodes, meshes, cameras, lights, scenes. What a scene holds
 * that splats cannot be or the converter does not know is dropped by a rule that README lists, with
 * one warning for each rule.
 */
#ifndef PHONGSPLAT_SCENES_H
#define PHONGSPLAT_SCENES_H

#include "converter.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PSPLAT_NO_INDEX UINT32_MAX

/* Strings are malloc'ed, UTF-8, or NULL: absent. extras is JSON of any kind. */

/* A mesh in its own coordinates, whoever places it. */
typedef struct psplat_scene_mesh {
    psplat_mesh mesh; /* no triangles: nothing of it can become splats */
    char *name, *extras;
} psplat_scene_mesh;

/* Either matrix or the rest, as the file has it; glTF 2.0 section 3.5.3. */
typedef struct psplat_scene_node {
    char *name, *extras;
    int has_matrix;
    double matrix[16];                            /* column-major */
    double translation[3], rotation[4], scale[3]; /* 0 0 0, 0 0 0 1, 1 1 1 where not in the file */
    uint32_t mesh, camera, light;                 /* or PSPLAT_NO_INDEX */
    uint32_t *children;
    size_t child_count;
} psplat_scene_node;

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

/* KHR_lights_punctual. */
typedef struct psplat_scene_light {
    char *name, *extras;
    psplat_scene_light_type type;
    double color[3], intensity;
    double range;                  /* 0: not given */
    double inner_cone, outer_cone; /* of spot lights */
} psplat_scene_light;

/* One of the file's scenes: what is shown together. */
typedef struct psplat_scene_view {
    char *name, *extras;
    uint32_t *roots; /* nodes */
    size_t root_count;
} psplat_scene_view;

/* Zero-initialised: empty. */
typedef struct psplat_scene {
    psplat_scene_mesh *meshes;
    size_t mesh_count;
    psplat_palette palette;   /* appearances by index of the file's materials, then the default
                                 material. Groups of meshes index it */
    psplat_scene_node *nodes; /* a strict forest, at most 64 deep */
    size_t node_count;
    psplat_scene_camera *cameras;
    size_t camera_count;
    psplat_scene_light *lights;
    size_t light_count;
    psplat_scene_view *scenes;
    size_t scene_count;
    uint32_t default_scene; /* PSPLAT_NO_INDEX: the file names none */
    int is_made; /* nodes and names are ours, since the file has no graph: one node with one mesh */
    char *copyright, *asset_extras, *extras;
    char **warnings; /* a line each, without the file's name */
    size_t warning_count;
} psplat_scene;

/* Reads any supported file (see psplat_mesh_read) with all of its meshes, nodes and appearances.
 * Each mesh is welded, oriented and recentred by itself. A file without a graph becomes one mesh
 * and one node, both called name. Errors are those of psplat_mesh_read; NO_SPLATS where the scene
 * that is shown has no triangle with area. */
psplat_result psplat_scene_read(const char *path, const char *name, psplat_scene *scene,
                                psplat_error *error);
void psplat_scene_free(psplat_scene *scene);

/* Adds a warning, once: printf-style. Without memory it is left out. */
void psplat_scene_warn(psplat_scene *scene, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* ---- graph.c, transform.c: where nodes stand ------------------------------------------------- */

/* The node's transform to that of its parent, column-major. */
void psplat_scene_local(const psplat_scene_node *node, double matrix[16]);

/* One appearance of a mesh in a scene. */
typedef struct psplat_instance {
    uint32_t mesh, node;
    double matrix[16]; /* global, column-major */
    double stretch;    /* greatest singular value of its upper left 3 x 3 */
} psplat_instance;

/* Where the scene of this index shows meshes, in the order of a walk from its roots; of index
 * PSPLAT_NO_INDEX where any node puts one. Left out are meshes without triangles, and instances
 * that their nodes flatten, since splats are not drawn so (spec 4). *instances is malloc'ed.
 * Errors: MEMORY. */
psplat_result psplat_scene_instances(const psplat_scene *scene, uint32_t index,
                                     psplat_instance **instances, size_t *count,
                                     psplat_error *error);

/* The index of the scene that a viewer shows at first; PSPLAT_NO_INDEX of files without scenes. */
uint32_t psplat_scene_shown(const psplat_scene *scene);

/* For each mesh of the scene the length that percentages of errors are of, in the mesh's own units:
 * the diagonal of the shown scene's box, divided by the greatest stretch of the mesh's instances
 * there. What only other scenes show takes theirs, and what none shows 0: the mesh's own box.
 * lengths: room for mesh_count. *diagonal: of the shown scene, or 0. Errors: MEMORY. */
psplat_result psplat_scene_lengths(const psplat_scene *scene, double *lengths, double *diagonal,
                                   psplat_error *error);

/* The diagonal of the box around the vertices of instances; 0 without any. */
double psplat_scene_diagonal(const psplat_scene *scene, const psplat_instance *instances,
                             size_t count);

/* ---- convert_scene.c: every mesh of a scene -------------------------------------------------- */

/* Percentages are of the diagonal of the shown scene's box, of errors that its instances stretch
 * most: so one bound holds wherever a mesh is shown. */
typedef struct psplat_scene_report {
    psplat_report total;   /* sums, greatest errors, means over all samples; p95 the greatest */
    psplat_report *meshes; /* by mesh of the scene; of those that have no splats zeros */
    size_t mesh_count;
} psplat_scene_report;

void psplat_scene_report_free(psplat_scene_report *report);

/* Converts each mesh with the same desc, whose diagonal is ignored. splats: by mesh, room for
 * mesh_count, zeroed; meshes without triangles leave theirs so. A mesh's tolerance is at most 20 %
 * of its own box. report may be NULL. Errors are those of psplat_convert and name the mesh; all
 * splats are free then. */
psplat_result psplat_scene_convert(const psplat_scene *scene, const psplat_convert_desc *desc,
                                   psplat_splats *splats, psplat_scene_report *report,
                                   psplat_error *error);

/* Fills what psplat_scene_convert with desc->unverified left out of its report. */
psplat_result psplat_scene_verify(const psplat_scene *scene, const psplat_convert_desc *desc,
                                  const psplat_splats *splats, psplat_scene_report *report,
                                  psplat_error *error);

/* report.c: psplat_report_json of the total; where the scene has several meshes, "mesh" in each of
 * the places, and "meshes": for each that has splats its index, its name and its own report. */
psplat_result psplat_scene_report_json(const psplat_scene *scene, const psplat_scene_report *report,
                                       char **text, size_t *size, psplat_error *error);

/* Frees the splats of all meshes, but not the array. */
void psplat_scene_splats_free(const psplat_scene *scene, psplat_splats *splats);

/* scenes.c: what messages call a mesh: "mesh 3 'Teapot'". */
void psplat_scene_label(const psplat_scene *scene, size_t mesh, char label[PSPLAT_SHOWN_PATH]);

/* ---- alternatives.c: for viewers that know no splats -------------------------------------------
 */

/* Coarse meshes (stand_in.h) of all that have triangles, as near to them as their splats are, by
 * mesh, in *stand_ins from malloc. desc: of the conversion, with the tolerance that it had; its
 * diagonal and progress are ignored. Errors: those of psplat_stand_in_make.
 * psplat_scene_stand_ins_free takes NULL. */
psplat_result psplat_scene_stand_ins(const psplat_scene *scene, const psplat_convert_desc *desc,
                                     struct psplat_stand_in **stand_ins, psplat_error *error);
void psplat_scene_stand_ins_free(const psplat_scene *scene, struct psplat_stand_in *stand_ins);

/* Gaussians (gaussian.h) of all splats, by mesh, in *gaussians from malloc. MEMORY.
 * psplat_scene_gaussians_free takes NULL. */
psplat_result psplat_scene_gaussians(const psplat_scene *scene, const psplat_splats *splats,
                                     struct psplat_gaussian ***gaussians, psplat_error *error);
void psplat_scene_gaussians_free(const psplat_scene *scene, struct psplat_gaussian **gaussians);

/* ---- glb.c: a scene of splats to a file --------------------------------------------------------
 */

/* Serialises the scene's graph with splats (by mesh) where its meshes were as a complete GLB (spec
 * 3) into *data, allocated with malloc and owned by the caller, in the layout that takes the fewest
 * bytes. desc may be NULL. Pure: no file is touched. */
psplat_result psplat_scene_write(const psplat_scene *scene, const psplat_splats *splats,
                                 const psplat_write_desc *desc, uint8_t **data, size_t *size,
                                 psplat_error *error);

/* ---- budget.c: the smallest error that fits -------------------------------------------------- */

typedef struct psplat_budget {
    size_t splats;                    /* of all meshes, at most; 0: any number */
    size_t bytes;                     /* of the complete GLB, at most; 0: any number */
    const psplat_write_desc *written; /* how psplat_scene_write makes it; may be NULL */
} psplat_budget;

/* The tolerances, in %, between which psplat_scene_convert_budget searches. */
#define PSPLAT_BUDGET_COARSEST 20.0
#define PSPLAT_BUDGET_FINEST 0.01

/* Finds the smallest tolerance whose splats keep the budget, up to 3 % of it or what some ten
 * conversions reach, and returns the splats and the report (may be NULL) of that tolerance, which
 * is in report->total.tolerance_percent; both as of psplat_scene_convert. desc->tolerance_percent
 * is the greatest that will do; 0 means PSPLAT_BUDGET_COARSEST. *needed becomes 0, or, where even
 * that tolerance needs more than the budget and RANGE is returned, how much: splats, or bytes where
 * their number is what does not fit. Other errors are those of psplat_scene_convert. */
psplat_result psplat_scene_convert_budget(const psplat_scene *scene,
                                          const psplat_convert_desc *desc,
                                          const psplat_budget *budget, psplat_splats *splats,
                                          psplat_scene_report *report, size_t *needed,
                                          psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif

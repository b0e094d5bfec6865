/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * converter.h - every stage of the converter, in the order in which data flows:
 *
 *     read -> features -> samples -> candidates and selection -> splats -> .glb -> verify
 *
 * One file = one stage, named by its noun. Stages return psplat_result and describe failures in a
 * psplat_error; nothing prints but the command line (main.c and command_*.c). Lengths are in the
 * units of the input, angles in radians unless a name says degrees. Structs are plain: whoever
 * fills one owns it, and *_free accepts a zero-initialised struct.
 */
#ifndef PHONGSPLAT_CONVERTER_H
#define PHONGSPLAT_CONVERTER_H

#include <phongsplat/splat.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- path.c: paths in messages ------------------------------------------------------------ */

#define PSPLAT_SHOWN_PATH 112

/* path as messages show it: control characters become question marks, and a long path loses its
 * middle, so that the cause behind it fits into a psplat_error. */
void psplat_path_shorten(const char *path, char shown[PSPLAT_SHOWN_PATH]);

/* ---- what a surface looks like ------------------------------------------------------------ */

/* Pixels of a texture as its file has them, 8 bits a channel, RGBA, the first row at the top. */
typedef struct psplat_image {
    uint8_t *pixels; /* height x width x 4; NULL: an image that could not be read, */
    char *problem;   /* and why, malloc'ed; or NULL: nothing asks for it */
    uint32_t width, height;
} psplat_image;

typedef enum psplat_wrap {
    PSPLAT_WRAP_REPEAT = 0,
    PSPLAT_WRAP_CLAMP,
    PSPLAT_WRAP_MIRROR
} psplat_wrap;

#define PSPLAT_TEXCOORDS 2

/* One use of an image by a material. Zeros: none. */
typedef struct psplat_texture {
    const psplat_image *image; /* owned by the scene; NULL: no texture */
    psplat_wrap wrap[2];       /* of s and t */
    int nearest;               /* texels have hard edges */
    uint32_t texcoord;         /* which of the mesh's, below PSPLAT_TEXCOORDS */
    double transform[6];       /* KHR_texture_transform: rows of a 2 x 3 matrix of (s, t, 1) */
    float strength;            /* normal scale or occlusion strength */
} psplat_texture;

/* A material of the source. Factors of textures that are baked are multiplied in by baking. */
typedef struct psplat_appearance {
    psplat_material material; /* factors */
    psplat_texture base_color, metallic_roughness, normal, occlusion, emissive;
    int is_masked; /* alphaMode MASK: */
    float alpha_cutoff;
    int is_blended; /* alphaMode BLEND; drawn opaque */
    char *name;     /* malloc'ed, or NULL */
    char *extras;   /* JSON, malloc'ed, or NULL */
} psplat_appearance;

/* What the meshes of a file look like. */
typedef struct psplat_palette {
    psplat_appearance *appearances;
    size_t appearance_count;
    psplat_image *images; /* that the appearances' textures point to */
    size_t image_count;
    char *problem; /* why a library of materials could not be read, malloc'ed; or NULL */
} psplat_palette;

/* Frees what palette holds. */
void psplat_palette_free(psplat_palette *palette);

/* ---- mesh.c: triangles as they were read ------------------------------------------------- */

/* Attributes live on corners (3 per triangle), so that a hard edge or a colour seam of the file
 * survives welding. Positions are relative to origin, which is subtracted in double. */
typedef struct psplat_mesh {
    double *positions;     /* vertex_count x 3 */
    uint32_t *triangles;   /* triangle_count x 3 vertex indices */
    float *corner_normals; /* triangle_count x 3 x 3 unit normals, 0 0 0 where a corner has none;
                            * or NULL: none in the file */
    float *corner_colors;  /* triangle_count x 3 x 4 linear RGBA, or NULL: uniform */
    uint32_t *groups;      /* triangle_count ids; edges between groups are creases; or NULL.
                            * Indices of appearances, where there are any */
    float *corner_uvs[PSPLAT_TEXCOORDS]; /* triangle_count x 3 x 2 texture coordinates; or NULL */
    float *corner_tangents; /* triangle_count x 3 x 4 (glTF 2.0 section 3.7.2.1); or NULL */
    size_t vertex_count;
    size_t triangle_count;
    double origin[3];
    psplat_material material;             /* factors common to all triangles */
    const psplat_appearance *appearances; /* by group, owned by the scene; NULL: material is all */
    size_t appearance_count;
    psplat_palette *palette; /* of psplat_mesh_read: owns the appearances; NULL: others do */
    size_t dropped;          /* triangles dropped as degenerate or repeated */
    int both_sides; /* some were there twice, facing both ways: double-sided, whatever the material
                     */
    /* Of a point set: all its points, and for each a triangle that it lies on or beside. The
     * triangles tell then which points are neighbours, and where the set has holes and ends;
     * distances are measured to the points as well. NULL for a mesh. */
    double *points;            /* point_count x 3 */
    uint32_t *point_triangles; /* point_count */
    size_t point_count;
} psplat_mesh;

/* Reads any supported file, chosen by its content first and its extension second (.obj .ply .off
 * .stl .gltf .glb .xyz .pts .asc). Checks indices and that every used coordinate is finite, welds
 * vertices of equal position, orients triangles alike, drops those without area, recentres. PLY and
 * OFF without faces and XYZ are point sets. Errors name the place; READ, FORMAT, RANGE,
 * UNSUPPORTED, NO_SPLATS (no triangle with area, or no surface through the points), MEMORY. */
psplat_result psplat_mesh_read(const char *path, psplat_mesh *mesh, psplat_error *error);
void psplat_mesh_free(psplat_mesh *mesh);

/* ---- points.c: points of a surface, without triangles ------------------------------------- */

typedef struct psplat_points {
    double *positions; /* count x 3 */
    float *normals;    /* count x 3, of any length (0: unknown) and either side; or NULL */
    float *colors;     /* count x 4 linear RGBA, or NULL */
    size_t count;
} psplat_points;

/* Connects points to a mesh through them; gaps of some four times the local spacing stay gaps. The
 * mesh's vertices are points as given, or, of a set that is noisier than 5 % of its spacing, where
 * quadrics through their neighbours put them; mesh->points are as given always. Normals that agree
 * on what is outside decide about it; otherwise they are lines without direction; without normals
 * they are estimated. Deterministic. Sets everything of the mesh but the material, double_sided
 * excepted. Errors: NO_SPLATS (no points, or none that span a surface), RANGE (not finite, too
 * many), MEMORY. */
psplat_result psplat_mesh_from_points(const psplat_points *points, psplat_mesh *mesh,
                                      psplat_error *error);
void psplat_points_free(psplat_points *points);

/* A step of positions, in tolerances, that makes files small. */
#define PSPLAT_USUAL_PRECISION 0.1
/* Beyond, a small splat next to a point would find no centre near enough to keep the tolerance. */
#define PSPLAT_GREATEST_PRECISION 0.5

/* ---- convert.c: the whole conversion ------------------------------------------------------ */

/* How colours change over a splat that has them (spec 3.10). */
typedef enum psplat_color_field {
    PSPLAT_COLOR_FIELD_CHOSEN =
        0, /* linear where colours are bound to 6 % or less: it pays there */
    PSPLAT_COLOR_FIELD_CONSTANT,
    PSPLAT_COLOR_FIELD_LINEAR
} psplat_color_field;

/* Zeros are the defaults. */
typedef struct psplat_convert_desc {
    double tolerance_percent;        /* epsilon in % of the bounding-box diagonal; 0 means 0.5 */
    double normal_tolerance_degrees; /* greatest error of the normal field; 0 means unbounded */
    double crease_angle_degrees; /* dihedral angle from which an edge is a crease, where it is not
                                  * noise; twice of it where the file's normals agree; 0: 30 */
    int no_creases;              /* 1: only borders and non-manifold edges bound splats */
    double precision; /* greatest step of positions in tolerances, to which all that is stored is
                         rounded, at most PSPLAT_GREATEST_PRECISION; 0: all floats */
    int constant_normals;           /* 1: fields without gradients, as Gaussian splats have */
    double color_tolerance_percent; /* greatest root mean square of a splat's colour error over its
                                     * samples, in % of sRGB's range; 100: unbounded; 0 means 10,
                                     * times the root of epsilon over 0.5 % */
    psplat_color_field color_field;
    int effort;      /* 1 ... 10: how long the selection is improved; 0 means the default, 3 */
    uint64_t seed;   /* of the sampling */
    int unverified;  /* 1: a report gets counts only; psplat_convert_verify adds the rest */
    double diagonal; /* that all percentages are of, where the mesh is a part of something larger,
                      * in units of the mesh; the tolerance is then at most 20 % of its own; 0: its
                      * own box's */
    /* Called now and then with the stage's name and its fraction done 0 ... 1; a return other than
     * 0 stops with INTERRUPTED. May be NULL. */
    int (*progress)(void *user, const char *stage, double fraction);
    void *user;
} psplat_convert_desc;

/* Consecutive splats that may become one primitive. */
typedef struct psplat_run {
    size_t count;
    uint32_t clip_lines; /* of each splat */
    uint32_t material;   /* index of the materials */
    float depth_tolerance;
} psplat_run;

/* How exactly a file holds splats: each value is an integer times a step. Zeros: floats. */
typedef struct psplat_precision {
    double unit;                      /* length of one step of positions; what the node scales by */
    double scale_step;                /* of the logarithm of radii */
    double turn_step, line_turn_step; /* half turns: one over a whole number */
    double tilt_step, field_step;     /* slopes */
    double line_step;                 /* parts of the ellipse: one over a whole number */
    int normal_bits;                  /* of each of the two octahedral coordinates of N, 4 ... 14 */
} psplat_precision;

/* The splats of one mesh in runs: sorted by clip_count; in each class first the flat ones, which
 * lie on their surface and need next to no depth tolerance, then the others; of those each material
 * for itself, in spatial order. */
typedef struct psplat_splats {
    psplat_splat *splats;
    psplat_finish *finishes; /* count; NULL: none (spec 3.10) */
    size_t count;
    psplat_run *runs; /* their counts add up to count */
    size_t run_count;
    psplat_material *materials; /* by index of the mesh's appearances; at least one */
    size_t material_count;
    psplat_kernel kernel;
    int has_color;    /* 0: color is 1 1 1 1 in every splat */
    double origin[3]; /* goes into the node's translation */
    psplat_precision precision;
} psplat_splats;

void psplat_splats_free(psplat_splats *splats);

/* What a conversion promises of its splats, each as its clip lines leave it. Whether it kept its
 * word is found out on samples of the surface other than those it worked with, and at 145 points of
 * each splat, the same that it worked with: between them some may be farther from the surface. The
 * limits allow for single precision. A splat covers a surface point that lies over or
 * under it by at most the tolerance and whose normal is on the same side as its own. */
typedef enum psplat_promise {
    PSPLAT_PROMISE_COVERAGE, /* each surface point is covered by a splat */
    PSPLAT_PROMISE_DISTANCE, /* each point of a splat is within the tolerance of the surface, and
                                each surface point of a splat */
    PSPLAT_PROMISE_NORMAL,   /* each covered surface point has, among the splats that cover it, one
                                whose own field there is within the normal tolerance of the
                                surface's (interpolated) normal; blending may differ */
    PSPLAT_PROMISE_CREASE,   /* no crease or border of the patch that a splat covers lies inside the
                                splat by more than the tolerance (those of neighbouring patches meet
                                a little beyond their crease, or cracks would show) */
    PSPLAT_PROMISE_COUNT
} psplat_promise;

/* How one promise was kept. */
typedef struct psplat_kept {
    double limit;  /* 0: not given, as that of normals without a tolerance. Degrees of normals,
                      else % of the diagonal */
    double worst;  /* greatest value found, in the same unit; of coverage the distance from the
                      farthest open point to the nearest splat, which may be near but beside it */
    size_t broken; /* samples, splats or crease edges beyond the limit */
} psplat_kept;

#define PSPLAT_MOST_PLACES 16

/* Where a promise is broken. */
typedef struct psplat_place {
    psplat_promise promise;
    double position[3]; /* in the coordinates of the mesh */
    double value;       /* found there, in the unit of its promise */
    uint32_t mesh;      /* of the scene; 0 where there is one alone */
} psplat_place;

/* What the converter measured, on samples of the surface other than those it fitted. */
typedef struct psplat_report {
    size_t splats;
    size_t splats_by_clip_lines[PSPLAT_MAX_CLIP_LINES + 1];
    size_t triangles, patches, crease_edges, border_edges;
    size_t samples;              /* fitted */
    size_t verification_samples; /* measured */
    size_t bytes;                /* of the file written */
    double seconds;              /* wall clock, reading and writing included */
    size_t peak_memory_bytes;    /* of the process */
    double diagonal;             /* that percentages are of: the bounding box's */
    double tolerance_percent;
    double max_distance_percent;         /* two-sided */
    double max_distance_surface_percent; /* surface to the nearest splat that covers it, along that
                                            splat's normal; to any splat where none does */
    double max_distance_splats_percent;  /* splats to surface */
    double rms_distance_percent;         /* surface to splats, as above */
    double rms_normal_degrees;           /* blended linear field against the surface's normal */
    double p95_normal_degrees;
    double rms_normal_constant_degrees; /* the same with gradients set to 0 */
    double p95_normal_constant_degrees;
    /* Blended base colour against the surface's, over R, G and B, in % of the range of sRGB; 0
     * where the mesh has neither textures nor colours of vertices. */
    double rms_color_percent;
    double p95_color_percent;
    double rms_color_constant_percent; /* the same with gradients set to 0 */
    double p95_color_constant_percent;
    double max_normal_degrees; /* as PSPLAT_PROMISE_NORMAL, whether promised or not */
    size_t uncovered_samples;  /* of verification_samples */
    psplat_kept promises[PSPLAT_PROMISE_COUNT];
    psplat_place places[PSPLAT_MOST_PLACES]; /* the worst of each broken promise, by promise */
    size_t place_count;
} psplat_report;

/* The promise that is broken at report's first place, or PSPLAT_PROMISE_COUNT: all are kept. */
psplat_promise psplat_report_broken(const psplat_report *report);

/* Mesh to splats. Deterministic: equal input and desc give equal splats. report may be NULL.
 * Errors: ARGUMENT, MEMORY, INTERRUPTED, NO_SPLATS, RANGE (too large a mesh, too small a
 * tolerance). */
psplat_result psplat_convert(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                             psplat_splats *splats, psplat_report *report, psplat_error *error);

/* Fills what psplat_convert with desc->unverified left out of its report on splats, which stand for
 * mesh and desc. The same errors. */
psplat_result psplat_convert_verify(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                    const psplat_splats *splats, psplat_report *report,
                                    psplat_error *error);

/* ---- schedule.c: how far a conversion is ---------------------------------------------------- */

/* Fraction 0 ... 1 of the time of a whole conversion that is usually spent when a stage, by the
 * name that desc.progress gets, is done to this fraction; negative for names that it does not know.
 */
double psplat_schedule_done(const char *stage, double fraction);

/* ---- columns.c, layout.c, document.c, glb.c: splats to a file ------------------------------- */

/* Makes views smaller: rows of equal size to bytes of mode ATTRIBUTES of EXT_meshopt_compression.
 */
typedef struct psplat_codec {
    /* How many bytes are enough. */
    size_t (*bound)(size_t rows, size_t stride);
    /* Returns how many there are; 0: failed. */
    size_t (*encode)(uint8_t *out, size_t capacity, const void *rows, size_t row_count,
                     size_t stride);
    /* The same of the indices of triangles, mode TRIANGLES. */
    size_t (*index_bound)(size_t index_count, size_t vertex_count);
    size_t (*index_encode)(uint8_t *out, size_t capacity, const uint32_t *indices,
                           size_t index_count);
} psplat_codec;

/* compress.c: by libmeshoptimizer. */
extern const psplat_codec psplat_meshopt_codec;

/* Zeros are the defaults. */
typedef struct psplat_write_desc {
    const psplat_codec *codec; /* NULL: not compressed */
    int unpadded;              /* 1: splats of few clip lines never join those of more (spec 3.6) */
    const struct psplat_stand_in *stand_ins; /* by mesh (stand_in.h); NULL: none */
    /* Of each splat of each mesh (gaussian.h), written beside ours; NULL: none. */
    const struct psplat_gaussian *const *gaussians;
} psplat_write_desc;

/* Serialises splats as a complete GLB (spec 3) into *data, allocated with malloc and owned by the
 * caller, neither compressed nor padded. Pure: no file is touched. name (may be NULL) becomes the
 * node's and the mesh's name. */
psplat_result psplat_glb_write(const psplat_splats *splats, const char *name, uint8_t **data,
                               size_t *size, psplat_error *error);
/* The same as desc says, for instance padded, as psplat_scene_write does. */
psplat_result psplat_glb_write_as(const psplat_splats *splats, const char *name,
                                  const psplat_write_desc *desc, uint8_t **data, size_t *size,
                                  psplat_error *error);

/* ---- report.c: the report as JSON --------------------------------------------------------- */

/* One object with the fields of psplat_report as keys, in *text, allocated with malloc and owned
 * by the caller; *size bytes, not terminated. */
psplat_result psplat_report_json(const psplat_report *report, char **text, size_t *size,
                                 psplat_error *error);

/* ---- output.c: files that are whole or absent --------------------------------------------- */

/* Writes size bytes to a file that has no name yet or a temporary one, syncs it and puts it in
 * place, so that path holds the old content or the new one and never a part, whatever ends the
 * process. overwrite 0 refuses an existing path. path "-" is standard output. Errors: WRITE, its
 * text naming path and cause. */
psplat_result psplat_output_write(const char *path, const void *data, size_t size, int overwrite,
                                  psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif

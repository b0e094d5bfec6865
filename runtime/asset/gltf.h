/* SPDX-License-Identifier: MIT
 *
 * gltf.h - what the reader knows of a glTF 2.0 document, in the order in which it finds it out:
 *
 *     gltf.c             the document: versions, extensions, buffers, views, accessors
 *     buffer.c           a buffer's bytes: BIN chunk, data URI or file
 *     meshopt.c          a view's bytes where they are compressed
 *     accessor.c         checked access to an accessor's elements as floats
 *     material.c         materials
 *     texture.c          textures of materials, and their samplers
 *     image.c            the bytes of images, which the asset keeps as they are
 *     primitive.c        meshes: which of their primitives are splats
 *     stream.c           splats in a coded stream
 *     fallback_link.c    fallback meshes for readers that know no splats
 *     level.c            levels of detail of meshes
 *     extension.c        the extension object of a primitive of splats
 *     attribute_types.c  names and forms of the attributes of splats
 *     splat_set.c        one primitive of splats and its attributes
 *     values.c           the values of these, decoded and checked
 *     unpack.c           turns integers among them into what they stand for
 *     surface.c          the surface of a splat: its bounds
 *     node.c             the node tree and its transforms
 *     animation.c        animations and the nodes that they move
 *     asset.c            the public asset made of all of these
 *
 * Every table is filled once, so that the work is linear in the size of the file. Indices and
 * integers in the tables have been checked; ranges of bytes are checked where they are used.
 */
#ifndef PHONGSPLAT_ASSET_GLTF_H
#define PHONGSPLAT_ASSET_GLTF_H

#include "core/json.h"
#include "asset/pack.h"

#define PSPLAT_EXTENSION "PSPLAT_surface_splats"
#define PSPLAT_EXTENSION_VERSION 4 /* the newest that is read; older ones are read, too */
#define PSPLAT_NONE SIZE_MAX

typedef struct psplat_buffer {
    psplat_json_value json, uri;
    size_t length;
    const uint8_t *data; /* NULL until it is loaded */
    size_t origin; /* offset of data[0] in the file; for base64, of the digit in which it begins */
    int is_base64;
    int is_decoded;   /* all of data was decompressed from bytes at origin */
    int is_fallback;  /* marked so by EXT_meshopt_compression: without a uri it has no bytes */
    int is_image;     /* an image beside the buffers: its bytes and path are kept with the asset */
    const char *path; /* path of an external file, whose offsets begin at its start; else NULL */
} psplat_buffer;

typedef struct psplat_view_range {
    psplat_json_value json, compression;   /* the object of EXT_meshopt_compression, or 0 */
    size_t buffer, offset, length, stride; /* in bytes; stride 0: tightly packed */
    psplat_buffer *decoded; /* all bytes of a compressed view; NULL until it is loaded */
    size_t *planes; /* stored bytes for each byte of the stride; NULL unless gltf.measures */
} psplat_view_range;

typedef struct psplat_accessor {
    psplat_json_value json, sparse;
    size_t view; /* index, or PSPLAT_NONE */
    size_t offset, count, components, component_type;
    int normalized;
} psplat_accessor;

/* The splats of one primitive. */
typedef struct psplat_set {
    psplat_splat *splats;       /* NULL where only packed is kept, */
    psplat_finish *finishes;    /* and where nothing varies over a splat */
    psplat_texcoord *texcoords; /* NULL as splats are, and where there are no coordinates */
    psplat_packed *packed;      /* what the GPU takes, in assets that only draw; else NULL */
    psplat_packing packing;     /* the layout of packed */
    size_t count;
    uint32_t clip_count;
    uint32_t seam_lines;               /* the last so many of the clip lines are seams */
    psplat_json_value json_seam_lines; /* beside a stream: that of each section; 0: no seams */
    psplat_kernel kernel;
    float depth_tolerance;
    const psplat_material *material; /* see psplat_material_get */
    float bounds_min[3], bounds_max[3];
    int has_color, has_gamma, has_color_gradient, has_surface, has_emissive;
    int is_curved, has_shape, has_bends, has_texcoord, has_texcoord_bend;
    size_t version;
    double scale_range[2]; /* first and last radius; zeros where not stated (spec 3.9) */
    float tilt_range, field_range, color_range, shape_range, bend_range, texcoord_range,
        texcoord_bend_range;
    float turn_range, clip_range[2]; /* 1 where not stated */
    psplat_attribute *attributes;    /* attribute_count of them, in the asset's arena */
    size_t attribute_count;
} psplat_set;

/* A level of detail of a mesh (spec 3.13). Errors are in units of the POSITION of the finest. */
typedef struct psplat_mesh_level {
    size_t mesh;
    double distance, normal, outline;
    double scale, translation[3]; /* from the level's POSITION to the finest's: scale first */
} psplat_mesh_level;

/* The sets of splats that are drawn where a node places this mesh. */
typedef struct psplat_mesh_sets {
    size_t first_set, set_count;
    size_t splat_count;        /* of the sets of the mesh itself */
    psplat_mesh_level *levels; /* level_count of them, the mesh itself first; NULL without any */
    size_t level_count;
    psplat_json_value json_levels; /* 0 where the mesh itself has no list */
    size_t splat_mesh; /* the mesh that this one is the fallback of (spec 6.1), or PSPLAT_NONE */
    psplat_json_value json_splat_mesh;
} psplat_mesh_sets;

typedef struct psplat_node {
    psplat_json_value json, children; /* children is 0 where there are none */
    size_t mesh, parent;              /* indices, or PSPLAT_NONE */
    double world[16];
    int in_scene;
} psplat_node;

/* The parts of a node's transform, in the order of glTF's T R S. */
typedef struct psplat_transform {
    double translation[3], rotation[4], scale[3]; /* rotation: a quaternion x, y, z, w */
} psplat_transform;

/* A material. Few of a file's are those of splats, so that each is made when it is first used. */
typedef struct psplat_material_entry {
    psplat_json_value json;
    const psplat_material *made[2]; /* without and with its textures; NULL until it is used */
} psplat_material_entry;

/* A glTF sampler, as far as splats follow it. */
typedef struct psplat_sampler {
    psplat_json_value json;
    psplat_wrap wrap[2];
    int nearest;
} psplat_sampler;

/* A glTF texture. */
typedef struct psplat_texture_entry {
    psplat_json_value json;
    size_t image, sampler; /* indices, or PSPLAT_NONE */
} psplat_texture_entry;

typedef struct psplat_image_entry {
    psplat_json_value json;
    uint32_t kept; /* 1 + the index in gltf->kept_images; 0 until a material uses the image */
} psplat_image_entry;

typedef struct psplat_gltf {
    psplat_error *error;
    psplat_arena *scratch; /* lives until the asset is open */
    psplat_arena *kept;    /* lives as long as the asset */
    psplat_json json;

    psplat_files files;
    const char *base_path; /* directory of external buffers; NULL: they are refused */
    size_t file_budget;    /* bytes that may still be loaded or decoded */
    const uint8_t *bin;    /* the BIN chunk, or NULL */
    size_t bin_size, bin_offset;
    size_t loaded_bytes;  /* of all buffers loaded so far */
    size_t decoded_bytes; /* of all compressed views decoded so far */
    size_t splat_total;   /* splats of all sets decoded so far */

    /* Members of the document; 0 where it has none of that name. */
    psplat_json_value json_materials, json_meshes, json_nodes, json_scenes, json_scene,
        json_textures, json_samplers, json_images, json_animations;
    /* The first attribute of the extension outside a primitive of splats, or 0. */
    psplat_json_value json_stripped;
    int is_listed;              /* whether extensionsUsed names the extension */
    int measures, only_draws;   /* as in psplat_asset_desc */
    psplat_splat *chunk_splats; /* of the chunk being decoded, where only_draws; else NULL */
    psplat_finish *chunk_finishes;
    psplat_texcoord *chunk_texcoords;
    struct psplat_stream_memory *stream; /* see stream.h; NULL until a primitive has a stream */

    psplat_buffer *buffers;
    psplat_view_range *views;
    psplat_accessor *accessors;
    psplat_material_entry *materials;
    psplat_texture_entry *textures; /* NULL, as are samplers and images, until splats have */
    psplat_sampler *samplers;       /* texture coordinates */
    psplat_image_entry *images;
    psplat_asset_image *kept_images; /* kept_image_count of them, in the asset's arena */
    psplat_mesh_sets *meshes;
    psplat_set *sets;
    psplat_node *nodes;
    size_t buffer_count, view_count, accessor_count, material_count, mesh_count, set_count,
        set_capacity, node_count, texture_count, sampler_count, image_count, kept_image_count;
    size_t image_bytes; /* of all kept images that lie in buffers */
} psplat_gltf;

/* Returns the offset of a value in the file, for psplat_fail. */
size_t psplat_gltf_offset(const psplat_gltf *gltf, psplat_json_value value);

/* Fails with FORMAT where the member of an object is missing, that is 0. */
psplat_result psplat_gltf_require(const psplat_gltf *gltf, psplat_json_value object,
                                  psplat_json_value member, const char *what);

/* Fills everything up to and including accessors. */
psplat_result psplat_gltf_parse(psplat_gltf *gltf);

/* Allocates a zeroed table with an entry for each element of array, which may be 0. Fails with
 * MEMORY, or with FORMAT where array is of another type. */
psplat_result psplat_gltf_table(psplat_gltf *gltf, psplat_json_value array, const char *what,
                                size_t entry_size, void **table, size_t *count);

/* Reads an optional index into a table of count entries; *index is PSPLAT_NONE where value is
 * absent. Fails with RANGE where the table has no such entry, FORMAT where value is no integer. */
psplat_result psplat_gltf_index(const psplat_gltf *gltf, psplat_json_value value, const char *what,
                                size_t count, size_t *index);

/* Makes buffer->data hold at least buffer->length bytes. */
psplat_result psplat_buffer_load(psplat_gltf *gltf, psplat_buffer *buffer);

/* Loads what the uri of a buffer or image names and stores its number of bytes in *size. */
psplat_result psplat_buffer_load_uri(psplat_gltf *gltf, psplat_buffer *buffer, size_t *size);

/* The most bytes that are decoded from a byte of a file. */
enum { PSPLAT_MOST_FROM_A_BYTE = 64 };

/* Returns whether so many bytes more than have been decoded so far would be more than
 * PSPLAT_MOST_FROM_A_BYTE for each byte that was loaded without decoding. */
int psplat_gltf_decodes_too_much(const psplat_gltf *gltf, size_t bytes);

/* Returns the offset, in the file or in the external one, of a byte position of a loaded buffer. */
size_t psplat_buffer_offset(const psplat_buffer *buffer, size_t position);

/* Says whether this build reads EXT_meshopt_compression, which needs libmeshoptimizer. */
#ifdef PSPLAT_MESHOPTIMIZER
enum { PSPLAT_MESHOPT_IS_BUILT = 1 };
#else
enum { PSPLAT_MESHOPT_IS_BUILT = 0 };
#endif

/* Decodes a compressed view into view->decoded. */
psplat_result psplat_meshopt_load(psplat_gltf *gltf, psplat_view_range *view);

/* Component types of glTF 2.0 section 3.6.2.2. */
enum {
    PSPLAT_BYTE = 5120,
    PSPLAT_UNSIGNED_BYTE = 5121,
    PSPLAT_SHORT = 5122,
    PSPLAT_UNSIGNED_SHORT = 5123,
    PSPLAT_UNSIGNED_INT = 5125,
    PSPLAT_FLOAT = 5126
};

/* One way to store an attribute (spec 3.2). */
typedef struct psplat_attribute_form {
    size_t version; /* the first version of the extension that allows it; 0: no form */
    size_t min_components, max_components;
    unsigned component_types; /* bit (t - PSPLAT_BYTE) stands for component type t */
    int is_plain;             /* integers may be used without being normalized */
} psplat_attribute_form;

typedef struct psplat_attribute_type {
    const char *name;
    psplat_attribute_form forms[4];
} psplat_attribute_type;

/* An accessor whose bytes are all inside its buffer. */
typedef struct psplat_reader {
    const psplat_buffer *buffer;
    const psplat_view_range *view;
    size_t start, stride, components, component_type, count;
    int normalized;
    int is_streamed; /* of floats decoded from a stream (stream.h); view is NULL then */
    size_t streamed; /* the bytes that they take in it */
} psplat_reader;

/* Checks accessor, an index in JSON, against type, version and count, where PSPLAT_NONE accepts any
 * count, and loads its buffer. */
psplat_result psplat_reader_open(psplat_gltf *gltf, psplat_json_value accessor,
                                 const psplat_attribute_type *type, size_t version, size_t count,
                                 psplat_reader *reader);

/* psplat_reader_bytes returns the bytes of all elements without the gaps between them,
 * psplat_reader_stored the bytes that they take in the file, compressed or not. */
size_t psplat_reader_bytes(const psplat_reader *reader);
size_t psplat_reader_stored(const psplat_reader *reader);

/* Checks that a view lies in its buffer and loads the buffer that holds its bytes, of which the
 * first is at *start. What names whom the view is for, in errors. */
psplat_result psplat_view_load(psplat_gltf *gltf, psplat_view_range *view, const char *what,
                               const psplat_buffer **buffer, size_t *start);

/* Reads elements first to first + count - 1 as floats, one after another. Signed normalized
 * integers become max(c / 127, -1) and so on (glTF 2.0 section 3.6.2.2), other integers stay as
 * they are. */
void psplat_reader_get(const psplat_reader *reader, size_t first, size_t count, float *values);

/* The attributes of a primitive of splats. */
enum {
    PSPLAT_POSITION = 0,
    PSPLAT_NORMAL,
    PSPLAT_COLOR,
    PSPLAT_ROTATION,
    PSPLAT_TURN,
    PSPLAT_TILT,
    PSPLAT_SCALE,
    PSPLAT_NORMAL_FIELD,
    PSPLAT_SHAPE,
    PSPLAT_FIRST_CLIP,
    PSPLAT_COLOR_U = PSPLAT_FIRST_CLIP + PSPLAT_MAX_CLIP_LINES,
    PSPLAT_FIRST_FINISH = PSPLAT_COLOR_U, /* this and what follows fill a psplat_finish */
    PSPLAT_COLOR_V,
    PSPLAT_ORM, /* occlusion, roughness, metallic */
    PSPLAT_EMISSIVE,
    PSPLAT_TEXCOORD,
    PSPLAT_FIRST_TEXCOORD = PSPLAT_TEXCOORD, /* this and all below fill a psplat_texcoord */
    PSPLAT_TEXCOORD_U,
    PSPLAT_TEXCOORD_V,
    PSPLAT_TEXCOORD_UU,
    PSPLAT_TEXCOORD_UV,
    PSPLAT_TEXCOORD_VV,
    PSPLAT_ATTRIBUTES
};

typedef struct psplat_readers {
    psplat_reader of[PSPLAT_ATTRIBUTES];
    int is_present[PSPLAT_ATTRIBUTES];
} psplat_readers;

/* The name of each attribute and the forms in which it may be stored; see attribute_types.c. */
extern const psplat_attribute_type psplat_attribute_types[PSPLAT_ATTRIBUTES];

/* What integers of radii stand for (spec 3.9): the product of one entry for the high byte and one
 * for the low byte. */
typedef struct psplat_radii {
    double high[256], low[256];
    float largest; /* the greatest integer */
} psplat_radii;

void psplat_radii_set(psplat_radii *radii, const double range[2], float largest);

/* These replace, in place, count elements that were read from integers by what the integers stand
 * for. A line grows from the two stored numbers to three, a bent one from three to four. */
void psplat_unpack_lines(float *values, size_t count, const float range[2]);
void psplat_unpack_bent_lines(float *values, size_t count, const float range[2], float bend_range);
void psplat_unpack_radii(float *values, size_t count, const psplat_radii *radii);
void psplat_unpack_scaled(float *values, size_t value_count, float range);

/* Makes unit quaternions of unit normals N and turns from -1 to 1 (spec 3.3). */
void psplat_unpack_turns(const float *normals, const float *turns, size_t count,
                         float *quaternions);

/* Decodes set->count splats into set->splats, finishes and texcoords and checks every value
 * (spec 3.3 to 3.8). Finds the set's bounds and stores the size of the box around the centres in
 * extent. */
psplat_result psplat_values_decode(const psplat_gltf *gltf, const psplat_readers *readers,
                                   psplat_set *set, double extent[3]);

psplat_result psplat_materials_parse(psplat_gltf *gltf);

/* Finds the material of an index, or glTF's default material where value is absent. It has textures
 * only where is_textured; then their images are kept. It lives until the asset is open. */
psplat_result psplat_material_get(psplat_gltf *gltf, psplat_json_value value, int is_textured,
                                  const psplat_material **material);

/* The textureInfo objects of a material, by slot; 0 where it has none. */
typedef struct psplat_texture_infos {
    psplat_json_value of[PSPLAT_TEXTURE_SLOTS];
} psplat_texture_infos;

/* Fills a material's textures and keeps their images. Textures of another set of coordinates than
 * TEXCOORD_0 are left out. */
psplat_result psplat_textures_get(psplat_gltf *gltf, const psplat_texture_infos *infos,
                                  psplat_material *material);

/* Keeps the bytes of an image, if they are not kept yet. */
psplat_result psplat_image_keep(psplat_gltf *gltf, psplat_image_entry *image);

/* Decodes every primitive of splats into gltf->sets. Fails with NO_SPLATS where there is none. */
psplat_result psplat_meshes_parse(psplat_gltf *gltf);

/* Finds whether a mesh, which has sets->set_count sets of its own, is the fallback of another mesh.
 * Its extensions may be 0. Fails with FORMAT or RANGE. */
psplat_result psplat_fallback_mesh_parse(psplat_gltf *gltf, psplat_json_value extensions,
                                         psplat_mesh_sets *sets);
/* Gives each fallback mesh the sets of the mesh that it stands in for. */
psplat_result psplat_fallback_meshes_resolve(psplat_gltf *gltf);

/* Parses the extension object; *extent becomes its positionExtent. Where *stream becomes the index
 * of a stream's view (spec 3.12) instead of 0, that holds the rest. */
psplat_result psplat_extension_parse(const psplat_gltf *gltf, psplat_json_value object,
                                     psplat_set *set, psplat_json_value *extent,
                                     psplat_json_value *stream);

/* Decodes the splats of one primitive into sets of gltf: one, or one for each section of a stream.
 * attributes, extension and material are its members; the last may be 0. */
psplat_result psplat_sets_parse(psplat_gltf *gltf, psplat_json_value attributes,
                                psplat_json_value extension, psplat_json_value material);

/* Fills the nodes and their world transforms and marks those that the default scene shows. */
psplat_result psplat_nodes_parse(psplat_gltf *gltf);

/* Reads the transform of a node once more, which psplat_nodes_parse has checked: its parts, or the
 * matrix where it has one, and then *has_matrix becomes 1. */
psplat_result psplat_node_transform(const psplat_gltf *gltf, size_t node,
                                    psplat_transform *transform, double matrix[16],
                                    int *has_matrix);

/* Composes translation, rotation and scale as T R S (glTF 2.0 section 3.5.3). */
void psplat_transform_compose(const psplat_transform *transform, double matrix[16]);

#endif

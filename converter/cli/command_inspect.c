/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_inspect.c - phongsplat inspect: lists what an asset holds, as a table or as JSON.
 *
 * Splats and bytes are counted once for each primitive, however often nodes place it.
 */
#include "base/json_writer.h"
#include "base/path.h"
#include "cli/command.h"
#include "cli/options.h"

#include <phongsplat/phongsplat.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { CLASSES = PSPLAT_MAX_CLIP_LINES + 1 }; /* of splats, by their number of clip lines */
/* There are twenty-three names of attributes, each with a few types and numbers of components. */
enum { MAX_ATTRIBUTES = 64 };

/* Sums over all primitives of an asset. */
typedef struct summary {
    size_t splats;
    size_t splats_by_clip_lines[CLASSES];
    size_t curved_splats, bent_splats;    /* the latter in primitives with bent clip lines */
    size_t attribute_bytes, stored_bytes; /* uncompressed, and in the file */
    size_t texcoord_bytes;                /* of all attributes of texture coordinates, stored */
    size_t image_bytes, json_bytes, file_bytes;
    psplat_attribute attributes[MAX_ATTRIBUTES];
    size_t attribute_count;
    double min[3], max[3];
} summary;

static psplat_parse parse(int argc, char **argv, const char **input, int *format) {
    const psplat_option options[] = {psplat_option_shared("format", format)};
    const psplat_syntax syntax = {
        .command = "inspect",
        .operands = "A.glb",
        .summary =
            "Shows what an asset (.glb or .gltf) holds: splats by number of clip lines, how\n"
            "many are curved, bytes by attribute, of the JSON and of images, bounds,\n"
            "materials with their textures.",
        .options = options,
        .option_count = 1,
        .slots = {input},
    };
    return psplat_options_parse(&syntax, argc, argv);
}

static const char *component_name(uint32_t type) {
    switch (type) {
    case 0:
        return "coded";
    case 5120:
        return "byte";
    case 5121:
        return "unsigned byte";
    case 5122:
        return "short";
    case 5123:
        return "unsigned short";
    default:
        return "float";
    }
}

/* Adds an attribute to the line of those with equal name, type and components. */
static void add_attribute(summary *s, const psplat_attribute *attribute) {
    s->attribute_bytes += attribute->bytes;
    s->stored_bytes += attribute->stored;
    if (strstr(attribute->name, "TEXCOORD")) s->texcoord_bytes += attribute->stored;
    for (size_t i = 0; i < s->attribute_count; ++i) {
        psplat_attribute *known = &s->attributes[i];
        if (strcmp(known->name, attribute->name) != 0 ||
            known->components != attribute->components ||
            known->component_type != attribute->component_type)
            continue;
        known->bytes += attribute->bytes;
        known->stored += attribute->stored;
        return;
    }
    if (s->attribute_count < MAX_ATTRIBUTES) s->attributes[s->attribute_count++] = *attribute;
}

/* Sums up an asset, each primitive once. Returns 0 where memory ran out. */
static int summarize(const psplat_asset *asset, summary *s) {
    size_t count = psplat_asset_batch_count(asset), highest = 0;
    for (size_t i = 0; i < count; ++i)
        if (psplat_asset_batch(asset, i)->primitive > highest)
            highest = psplat_asset_batch(asset, i)->primitive;
    unsigned char *is_seen = calloc(highest + 1, 1);
    if (!is_seen) return 0;
    for (size_t i = 0; i < count; ++i) {
        const psplat_batch *batch = psplat_asset_batch(asset, i);
        if (is_seen[batch->primitive]) continue;
        is_seen[batch->primitive] = 1;
        s->splats += batch->splat_count;
        s->splats_by_clip_lines[batch->clip_count] += batch->splat_count;
        s->curved_splats += batch->is_curved ? batch->splat_count : 0;
        s->bent_splats += batch->has_bends ? batch->splat_count : 0;
        for (size_t k = 0; k < batch->attribute_count; ++k) add_attribute(s, &batch->attributes[k]);
    }
    free(is_seen);
    for (size_t i = 0; i < psplat_asset_image_count(asset); ++i)
        s->image_bytes += psplat_asset_get_image(asset, i)->size;
    psplat_asset_bounds(asset, s->min, s->max);
    return 1;
}

/* Names the textures of a material and the image of each. */
static void print_textures(const psplat_material *m) {
    static const char *const names[] = {[PSPLAT_TEXTURE_BASE_COLOR] = "base colour",
                                        [PSPLAT_TEXTURE_METALLIC_ROUGHNESS] = "metallic-roughness",
                                        [PSPLAT_TEXTURE_NORMAL] = "normal",
                                        [PSPLAT_TEXTURE_OCCLUSION] = "occlusion",
                                        [PSPLAT_TEXTURE_EMISSIVE] = "emissive"};
    const char *between = "  textures: ";
    for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot) {
        if (!m->textures[slot].image) continue;
        printf("%s%s of image %u", between, names[slot], (unsigned)m->textures[slot].image - 1);
        between = ", ";
    }
    if (*between == ',') printf("\n");
}

/* Lists the images, whose names are those of the file. */
static void print_images(const psplat_asset *asset, const summary *s) {
    if (!psplat_asset_image_count(asset)) return;
    printf("\n%-36s %-16s %10s %10s\n", "image", "type", "", "in the file");
    for (size_t i = 0; i < psplat_asset_image_count(asset); ++i) {
        const psplat_asset_image *image = psplat_asset_get_image(asset, i);
        char name[PSPLAT_SHOWN_PATH], label[PSPLAT_SHOWN_PATH + 24];
        psplat_path_shorten(image->name, name);
        snprintf(label, sizeof label, "%zu %s", i, name);
        printf("%-36s %-16s %10s %11zu\n", label, image->mime_type, "", image->size);
    }
    printf("%-36s %-16s %10s %11zu\n", "together", "", "", s->image_bytes);
}

/* Lists the levels of detail, where there are several. */
static void print_levels(const psplat_asset *asset) {
    size_t count = psplat_asset_level_count(asset);
    if (count < 2) return;
    printf("\n%-22s %10s %12s %12s %12s\n", "level of detail", "splats", "distance", "normals",
           "outline");
    for (size_t i = 0; i < count; ++i) {
        const psplat_level *level = psplat_asset_get_level(asset, i);
        printf("%-22zu %10zu %12.4g %11.3g\302\260 %12.4g\n", i, level->splat_count,
               level->distance, level->normal, level->outline);
    }
}

static void print_animations(const psplat_asset *asset) {
    if (!psplat_asset_animation_count(asset)) return;
    printf("\n%-36s %10s %10s\n", "animation", "seconds", "channels");
    for (size_t i = 0; i < psplat_asset_animation_count(asset); ++i) {
        const psplat_animation *animation = psplat_asset_get_animation(asset, i);
        char name[PSPLAT_SHOWN_PATH], label[PSPLAT_SHOWN_PATH + 24];
        psplat_path_shorten(animation->name, name);
        snprintf(label, sizeof label, "%zu %s", i, name);
        printf("%-36s %10.6g %10zu\n", label, animation->duration, animation->channel_count);
    }
}

/* Returns what surface a batch's splats have, followed by a space; nothing for planes. */
static const char *surface_name(const psplat_batch *batch) {
    return !batch->is_curved ? "" : batch->has_shape ? "curved (by SHAPE) " : "curved ";
}

static void print_batch(const psplat_batch *b, size_t index) {
    const psplat_material *m = &b->material;
    char seams[32] = "";
    if (b->seam_lines) snprintf(seams, sizeof seams, " (%u of them seams)", b->seam_lines);
    printf("batch %zu: primitive %u, %zu %ssplats with %u %sclip lines%s, depth tolerance %.6g\n",
           index, b->primitive, b->splat_count, surface_name(b), b->clip_count,
           b->has_bends ? "bent " : "", seams, (double)b->depth_tolerance);
    printf(
        "  kernel exp(-%g r^%g), base colour %.3g %.3g %.3g %.3g%s, metallic %.3g, roughness %.3g"
        "%s%s\n",
        (double)b->kernel.sharpness, (double)b->kernel.exponent, (double)m->base_color[0],
        (double)m->base_color[1], (double)m->base_color[2], (double)m->base_color[3],
        b->has_color ? " times colours" : "", (double)m->metallic, (double)m->roughness,
        m->double_sided ? ", double-sided" : "", m->unlit ? ", unlit" : "");
    print_textures(m);
}

/* Returns the bytes of a GLB's JSON, or of all of another file, which is JSON itself. */
static size_t json_bytes_of(const char *path, size_t file_bytes) {
    unsigned char head[20] = {0};
    FILE *file = fopen(path, "rb");
    size_t found = file ? fread(head, 1, sizeof head, file) : 0;
    if (file) fclose(file);
    if (found < sizeof head || memcmp(head, "glTF", 4) != 0) return file_bytes;
    return head[12] | (size_t)head[13] << 8 | (size_t)head[14] << 16 | (size_t)head[15] << 24;
}

static void print_pretty(const char *path, const psplat_asset *asset, const summary *s) {
    printf("%s: %zu splats, %zu bytes of attributes\n\nclip lines      splats\n", path, s->splats,
           s->attribute_bytes);
    for (int i = 0; i < CLASSES; ++i)
        if (s->splats_by_clip_lines[i]) printf("%10d  %10zu\n", i, s->splats_by_clip_lines[i]);
    if (s->curved_splats) printf("    curved  %10zu\n", s->curved_splats);
    if (s->bent_splats) printf("bent lines  %10zu\n", s->bent_splats);
    printf("\n%-36s %-16s %10s %10s %10s\n", "attribute", "type", "bytes", "in the file",
           "a splat");
    for (size_t i = 0; i < s->attribute_count; ++i) {
        const psplat_attribute *a = &s->attributes[i];
        char type[32];
        snprintf(type, sizeof type, "%u %s", a->components, component_name(a->component_type));
        printf("%-36s %-16s %10zu %10zu %10.2f\n", a->name, type, a->bytes, a->stored,
               (double)a->stored / (double)s->splats);
    }
    printf("%-36s %-16s %10zu %10zu %10.2f\n", "together", "", s->attribute_bytes, s->stored_bytes,
           (double)s->stored_bytes / (double)s->splats);
    if (s->texcoord_bytes)
        printf("%-36s %-16s %10s %10zu %10.2f\n", "texture coordinates", "", "", s->texcoord_bytes,
               (double)s->texcoord_bytes / (double)s->splats);
    printf("%-36s %-16s %10s %10zu %10.2f\n", "JSON", "", "", s->json_bytes,
           (double)s->json_bytes / (double)s->splats);
    printf("%-36s %-16s %10s %10zu %10.2f\n", "file", "", "", s->file_bytes,
           (double)s->file_bytes / (double)s->splats);
    print_images(asset, s);
    print_animations(asset);
    print_levels(asset);
    printf("\nbounds  %.6g %.6g %.6g  to  %.6g %.6g %.6g\n\n", s->min[0], s->min[1], s->min[2],
           s->max[0], s->max[1], s->max[2]);
    for (size_t i = 0; i < psplat_asset_batch_count(asset); ++i)
        print_batch(psplat_asset_batch(asset, i), i);
}

static void write_attributes(psplat_writer *json, const summary *s) {
    psplat_writer_open(json, "attributes", '[');
    for (size_t i = 0; i < s->attribute_count; ++i) {
        const psplat_attribute *a = &s->attributes[i];
        psplat_writer_open(json, NULL, '{');
        psplat_writer_string(json, "name", a->name);
        psplat_writer_string(json, "component_type", component_name(a->component_type));
        psplat_writer_count(json, "components", a->components);
        psplat_writer_count(json, "bytes", a->bytes);
        psplat_writer_boolean(json, "is_compressed", a->is_compressed);
        psplat_writer_count(json, "stored", a->stored);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

static void write_floats(psplat_writer *json, const char *key, const float *values, size_t count) {
    double numbers[4];
    for (size_t i = 0; i < count; ++i) numbers[i] = (double)values[i];
    psplat_writer_numbers(json, key, numbers, count);
}

/* Writes the textures of a material by their names in glTF: the image of each. */
static void write_textures(psplat_writer *json, const psplat_material *material) {
    static const char *const names[] = {[PSPLAT_TEXTURE_BASE_COLOR] = "base_color",
                                        [PSPLAT_TEXTURE_METALLIC_ROUGHNESS] = "metallic_roughness",
                                        [PSPLAT_TEXTURE_NORMAL] = "normal",
                                        [PSPLAT_TEXTURE_OCCLUSION] = "occlusion",
                                        [PSPLAT_TEXTURE_EMISSIVE] = "emissive"};
    psplat_writer_open(json, "textures", '{');
    for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot)
        if (material->textures[slot].image)
            psplat_writer_count(json, names[slot], material->textures[slot].image - 1);
    psplat_writer_close(json, '}');
}

static void write_images(psplat_writer *json, const psplat_asset *asset) {
    psplat_writer_open(json, "images", '[');
    for (size_t i = 0; i < psplat_asset_image_count(asset); ++i) {
        const psplat_asset_image *image = psplat_asset_get_image(asset, i);
        psplat_writer_open(json, NULL, '{');
        psplat_writer_string(json, "name", image->name);
        psplat_writer_string(json, "mime_type", image->mime_type);
        psplat_writer_count(json, "bytes", image->size);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

static void write_animations(psplat_writer *json, const psplat_asset *asset) {
    psplat_writer_open(json, "animations", '[');
    for (size_t i = 0; i < psplat_asset_animation_count(asset); ++i) {
        const psplat_animation *animation = psplat_asset_get_animation(asset, i);
        psplat_writer_open(json, NULL, '{');
        psplat_writer_string(json, "name", animation->name);
        psplat_writer_number(json, "duration", animation->duration);
        psplat_writer_count(json, "channels", animation->channel_count);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

static void write_levels(psplat_writer *json, const psplat_asset *asset) {
    psplat_writer_open(json, "levels", '[');
    for (size_t i = 0; i < psplat_asset_level_count(asset); ++i) {
        const psplat_level *level = psplat_asset_get_level(asset, i);
        psplat_writer_open(json, NULL, '{');
        psplat_writer_count(json, "splats", level->splat_count);
        psplat_writer_number(json, "distance", level->distance);
        psplat_writer_number(json, "normal_degrees", level->normal);
        psplat_writer_number(json, "outline", level->outline);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

static void write_material(psplat_writer *json, const psplat_material *material) {
    psplat_writer_open(json, "material", '{');
    write_floats(json, "base_color", material->base_color, 4);
    write_floats(json, "emissive", material->emissive, 3);
    psplat_writer_number(json, "metallic", (double)material->metallic);
    psplat_writer_number(json, "roughness", (double)material->roughness);
    psplat_writer_boolean(json, "double_sided", material->double_sided);
    psplat_writer_boolean(json, "unlit", material->unlit);
    write_textures(json, material);
    psplat_writer_close(json, '}');
}

static void write_batches(psplat_writer *json, const psplat_asset *asset) {
    psplat_writer_open(json, "batches", '[');
    for (size_t i = 0; i < psplat_asset_batch_count(asset); ++i) {
        const psplat_batch *batch = psplat_asset_batch(asset, i);
        psplat_writer_open(json, NULL, '{');
        psplat_writer_count(json, "primitive", batch->primitive);
        psplat_writer_count(json, "splats", batch->splat_count);
        psplat_writer_count(json, "clip_lines", batch->clip_count);
        psplat_writer_count(json, "seam_lines", batch->seam_lines);
        psplat_writer_boolean(json, "is_curved", batch->is_curved);
        psplat_writer_boolean(json, "has_shape", batch->has_shape);
        psplat_writer_boolean(json, "has_bends", batch->has_bends);
        psplat_writer_number(json, "depth_tolerance", (double)batch->depth_tolerance);
        psplat_writer_number(json, "kernel_sharpness", (double)batch->kernel.sharpness);
        psplat_writer_number(json, "kernel_exponent", (double)batch->kernel.exponent);
        psplat_writer_boolean(json, "has_color", batch->has_color);
        psplat_writer_boolean(json, "has_texcoord", batch->has_texcoord);
        psplat_writer_boolean(json, "has_texcoord_bend", batch->has_texcoord_bend);
        psplat_writer_numbers(json, "model", batch->model, 16);
        write_material(json, &batch->material);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

/* Returns 0 where memory ran out. */
static int print_json(const char *path, const psplat_asset *asset, const summary *s) {
    psplat_writer json = {0};
    double by_clip_lines[CLASSES];
    for (int i = 0; i < CLASSES; ++i) by_clip_lines[i] = (double)s->splats_by_clip_lines[i];
    psplat_writer_open(&json, NULL, '{');
    psplat_writer_string(&json, "file", path);
    psplat_writer_count(&json, "splats", s->splats);
    psplat_writer_numbers(&json, "splats_by_clip_lines", by_clip_lines, CLASSES);
    psplat_writer_count(&json, "curved_splats", s->curved_splats);
    psplat_writer_count(&json, "bent_splats", s->bent_splats);
    psplat_writer_count(&json, "attribute_bytes", s->attribute_bytes);
    psplat_writer_count(&json, "stored_bytes", s->stored_bytes);
    psplat_writer_count(&json, "texcoord_bytes", s->texcoord_bytes);
    psplat_writer_count(&json, "image_bytes", s->image_bytes);
    psplat_writer_count(&json, "json_bytes", s->json_bytes);
    psplat_writer_count(&json, "file_bytes", s->file_bytes);
    write_attributes(&json, s);
    write_images(&json, asset);
    write_animations(&json, asset);
    if (psplat_asset_level_count(asset) > 1) write_levels(&json, asset);
    psplat_writer_numbers(&json, "bounds_min", s->min, 3);
    psplat_writer_numbers(&json, "bounds_max", s->max, 3);
    write_batches(&json, asset);
    psplat_writer_close(&json, '}');
    int is_whole = psplat_writer_finish(&json);
    if (is_whole) fwrite(json.text, 1, json.size, stdout);
    free(json.text);
    return is_whole;
}

int psplat_command_inspect(int argc, char **argv) {
    const char *input = NULL;
    int format = PSPLAT_FORMAT_PRETTY;
    psplat_parse parsed = parse(argc, argv, &input, &format);
    if (parsed != PSPLAT_PARSE_OK) return (int)parsed;
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    summary s = {0};
    const psplat_asset_desc desc = {.measures = 1};
    struct stat file;
    if (psplat_command_open(input, &desc, &asset, &error))
        return psplat_command_fail(input, &error);
    if (!stat(input, &file)) s.file_bytes = (size_t)file.st_size;
    s.json_bytes = json_bytes_of(input, s.file_bytes);
    int is_whole = summarize(asset, &s);
    if (is_whole && format == PSPLAT_FORMAT_PRETTY) print_pretty(input, asset, &s);
    if (is_whole && format == PSPLAT_FORMAT_JSON) is_whole = print_json(input, asset, &s);
    psplat_asset_destroy(asset);
    if (is_whole) return PSPLAT_EXIT_SUCCESS;
    psplat_fail(&error, PSPLAT_ERROR_MEMORY, 0, "no memory for the description");
    return psplat_command_fail(input, &error);
}

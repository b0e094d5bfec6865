/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * triangle_stream.c - the triangles of a file one after the other, in bounded memory.
 *
 * A mapped file counts as memory in use while its pages are resident, although the system takes
 * them back at need. So pages are dropped whenever some more of the file was read, and come back
 * from the system's cache if they are needed again.
 */
#define _DEFAULT_SOURCE /* madvise */

#include "import/triangle_stream.h"

#include "base/path.h"
#include "base/polygon.h"
#include "import/ply_rows.h"
#include "import/read_mesh.h"
#include "material/mipmap.h"
#include "material/source_materials.h"
#include "mesh/mesh.h"

#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* The bytes of a binary STL's header, with the count, and of each triangle. */
enum { STL_HEADER = 84, STL_TRIANGLE = 50 };
/* The triangles after which the pages of a mapped file are dropped. */
enum { DROP_TRIANGLES = 1 << 20 };

typedef enum kind { IN_MEMORY, STL, PLY } kind;

struct psplat_triangle_stream {
    kind kind;
    psplat_stream_content content;
    char path[PSPLAT_SHOWN_PATH];
    psplat_mesh mesh; /* IN_MEMORY */
    const char *data; /* mapped otherwise */
    size_t size;
    psplat_ply_rows ply;
    float linear[256];   /* of the bytes of colours */
    size_t next, offset; /* the next triangle or face, and where it lies */
    size_t read;         /* triangles since pages were dropped */
    uint32_t *corners;   /* of the current face, and what is left of its triangles */
    uint32_t *split;
    size_t left, corner_capacity;
};

/* ---- opening --------------------------------------------------------------------------------- */

static int is_stl(const char *data, size_t size) {
    if (size < STL_HEADER) return 0;
    const unsigned char *c = (const unsigned char *)data + STL_HEADER - 4;
    size_t count = (size_t)c[0] | (size_t)c[1] << 8 | (size_t)c[2] << 16 | (size_t)c[3] << 24;
    return count && size == STL_HEADER + STL_TRIANGLE * count;
}

static int has_textures(const psplat_source_material *m) {
    return m->base_color.image || m->metallic_roughness.image || m->normal.image ||
           m->occlusion.image || m->emissive.image;
}

/* Takes the materials of a mesh in memory: colours of groups become those of corners. */
static psplat_result take_materials(psplat_triangle_stream *s, psplat_error *error) {
    const psplat_mesh *mesh = &s->mesh;
    for (size_t i = 0; i < mesh->source_material_count; ++i)
        if (has_textures(&mesh->source_materials[i]))
            return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 0,
                               "%s: has textures, which blocks do not keep", s->path);
    s->content.has_material = 1;
    s->content.material = mesh->material;
    if (!mesh->groups || !mesh->source_material_count) return PSPLAT_OK;
    s->content.has_colors = 1;
    s->content.material = mesh->source_materials[mesh->groups[0]].material;
    for (int k = 0; k < 4; ++k) s->content.material.base_color[k] = 1;
    return PSPLAT_OK;
}

static psplat_result open_mesh(const char *path, psplat_triangle_stream *s, psplat_error *error) {
    psplat_result result = psplat_mesh_read(path, &s->mesh, error);
    if (result) return result;
    if (s->mesh.point_count)
        return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 0,
                           "%s: is a point set; blocks are made of triangles", s->path);
    s->kind = IN_MEMORY;
    s->content.has_normals = s->mesh.corner_normals != NULL;
    s->content.has_colors = s->mesh.corner_colors != NULL;
    return take_materials(s, error);
}

static void take_ply(psplat_triangle_stream *s) {
    s->kind = PLY;
    s->content.is_mapped = 1;
    s->content.is_single = s->ply.scalars == PSPLAT_PLY_FLOAT32;
    s->content.has_normals = s->ply.normal[0] >= 0;
    s->content.has_colors = s->ply.color[0] >= 0;
    for (int i = 1; i < 256; ++i) s->linear[i] = psplat_linear_of_srgb((float)i / 255.0f);
    s->linear[255] = 1;
}

/* Maps the file if it is of a kind that is streamed. */
static void map_file(const char *path, psplat_triangle_stream *s) {
    struct stat status;
    int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) return;
    if (!fstat(file, &status) && S_ISREG(status.st_mode) && status.st_size > 0) {
        s->size = (size_t)status.st_size;
        void *data = mmap(NULL, s->size, PROT_READ, MAP_SHARED, file, 0);
        s->data = data == MAP_FAILED ? NULL : data;
    }
    close(file);
    if (!s->data) return;
    if (psplat_ply_rows_open(s->data, s->size, &s->ply)) {
        take_ply(s);
    } else if (is_stl(s->data, s->size)) {
        s->kind = STL;
        s->content.is_single = s->content.is_mapped = 1;
    } else {
        munmap((void *)(uintptr_t)s->data, s->size);
        s->data = NULL;
    }
}

psplat_result psplat_triangle_stream_open(const char *path, psplat_triangle_stream **stream,
                                          psplat_error *error) {
    psplat_triangle_stream *s = calloc(1, sizeof *s);
    *stream = NULL;
    if (!s) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    psplat_path_shorten(path, s->path);
    map_file(path, s);
    psplat_result result = s->data ? PSPLAT_OK : open_mesh(path, s, error);
    if (result) {
        psplat_triangle_stream_close(s);
        return result;
    }
    psplat_triangle_stream_rewind(s);
    *stream = s;
    return PSPLAT_OK;
}

const psplat_stream_content *psplat_triangle_stream_content(const psplat_triangle_stream *stream) {
    return &stream->content;
}

void psplat_triangle_stream_rewind(psplat_triangle_stream *s) {
    s->next = s->left = 0;
    s->offset = s->kind == STL ? (size_t)STL_HEADER
                               : s->ply.first_vertex + s->ply.vertices * s->ply.vertex_size;
}

void psplat_triangle_stream_close(psplat_triangle_stream *s) {
    if (!s) return;
    if (s->data) munmap((void *)(uintptr_t)s->data, s->size);
    psplat_mesh_free(&s->mesh);
    free(s->corners);
    free(s->split);
    free(s);
}

/* ---- triangles ------------------------------------------------------------------------------- */

static psplat_result fail_at(const psplat_triangle_stream *s, size_t offset, psplat_result code,
                             const char *row, size_t index, const char *cause,
                             psplat_error *error) {
    return psplat_fail(error, code, offset, "%s: byte %zu: %s %zu: %s", s->path, offset, row, index,
                       cause);
}

static void next_in_memory(psplat_triangle_stream *s, psplat_stream_triangle *t) {
    const psplat_mesh *mesh = &s->mesh;
    uint32_t triangle = (uint32_t)s->next++;
    const float *factor = mesh->groups && mesh->source_material_count
                              ? mesh->source_materials[mesh->groups[triangle]].material.base_color
                              : NULL;
    for (size_t i = 0; i < 9; ++i)
        t->positions[i] =
            psplat_mesh_corner(mesh, triangle, (int)(i / 3))[i % 3] + mesh->origin[i % 3];
    if (s->content.has_normals)
        memcpy(t->normals, mesh->corner_normals + 9 * (size_t)triangle, sizeof t->normals);
    for (size_t i = 0; s->content.has_colors && i < 12; ++i)
        t->colors[i] = (mesh->corner_colors ? mesh->corner_colors[12 * (size_t)triangle + i] : 1) *
                       (factor ? factor[i % 4] : 1);
}

static psplat_result next_stl(psplat_triangle_stream *s, psplat_stream_triangle *t,
                              psplat_error *error) {
    static const psplat_ply_rows little = {0};
    size_t offset = s->offset + 12;
    for (size_t i = 0; i < 9; ++i) {
        t->positions[i] = psplat_ply_value(&little, PSPLAT_PLY_FLOAT32, s->data + offset + 4 * i);
        if (!isfinite(t->positions[i]))
            return fail_at(s, offset + 4 * i, PSPLAT_ERROR_RANGE, "triangle", s->next,
                           "a coordinate is not finite", error);
    }
    s->offset += STL_TRIANGLE;
    ++s->next;
    return PSPLAT_OK;
}

/* Stores what a vertex of a PLY file is at corner k of a triangle. */
static psplat_result take_vertex(psplat_triangle_stream *s, uint32_t vertex, size_t k,
                                 psplat_stream_triangle *t, psplat_error *error) {
    const psplat_ply_rows *ply = &s->ply;
    size_t offset = ply->first_vertex + vertex * ply->vertex_size;
    const char *row = s->data + offset;
    double normal[3] = {0, 0, 0};
    for (size_t i = 0; i < 3; ++i) {
        double value = psplat_ply_value(ply, ply->scalars, row + ply->position[i]);
        if (!isfinite(value))
            return fail_at(s, offset, PSPLAT_ERROR_RANGE, "vertex", vertex,
                           "a coordinate is not finite", error);
        t->positions[3 * k + i] = value;
        if (ply->normal[i] >= 0)
            normal[i] = psplat_ply_value(ply, PSPLAT_PLY_FLOAT32, row + ply->normal[i]);
    }
    double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (size_t i = 0; i < 3; ++i)
        t->normals[3 * k + i] = length > 0 && isfinite(length) ? (float)(normal[i] / length) : 0.0f;
    for (size_t i = 0; i < 4 && s->content.has_colors; ++i) {
        unsigned byte = ply->color[i] < 0 ? 255 : (unsigned char)row[ply->color[i]];
        t->colors[4 * k + i] = i < 3 ? s->linear[byte] : (float)byte / 255.0f;
    }
    return PSPLAT_OK;
}

/* Reads a number of a face and moves behind it. */
static int take_number(psplat_triangle_stream *s, psplat_ply_type type, double *value) {
    size_t size = psplat_ply_size(type);
    if (s->size - s->offset < size) return 0;
    *value = psplat_ply_value(&s->ply, type, s->data + s->offset);
    s->offset += size;
    return 1;
}

/* Makes room for a face of so many corners. */
static int reserve(psplat_triangle_stream *s, size_t count) {
    if (count <= s->corner_capacity) return 1;
    uint32_t *corners = realloc(s->corners, count * sizeof *corners);
    if (corners) s->corners = corners;
    uint32_t *split = realloc(s->split, 3 * count * sizeof *split);
    if (split) s->split = split;
    if (!corners || !split) return 0;
    s->corner_capacity = count;
    return 1;
}

static psplat_result split_face(psplat_triangle_stream *s, size_t count, psplat_error *error) {
    s->left = count - 2;
    for (uint32_t k = 0; k < 3; ++k) s->split[k] = k;
    if (count == 3) return PSPLAT_OK;
    psplat_stream_triangle t;
    double *points = malloc(3 * count * sizeof *points);
    psplat_result result = PSPLAT_OK;
    if (!points) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    for (size_t i = 0; i < count && !result; ++i) {
        result = take_vertex(s, s->corners[i], 0, &t, error);
        memcpy(points + 3 * i, t.positions, 3 * sizeof *points);
    }
    if (!result) result = psplat_polygon_triangulate(points, count, s->split, error);
    free(points);
    return result;
}

static psplat_result take_corners(psplat_triangle_stream *s, const psplat_ply_property *property,
                                  double count, psplat_error *error) {
    if (!(count >= 3) || count > (double)PSPLAT_MAX_CORNERS)
        return fail_at(s, s->offset, PSPLAT_ERROR_RANGE, "face", s->next,
                       "fewer than 3 or more than 4096 corners", error);
    if (!reserve(s, (size_t)count))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    for (size_t i = 0; i < (size_t)count; ++i) {
        double vertex;
        if (!take_number(s, property->type, &vertex))
            return fail_at(s, s->offset, PSPLAT_ERROR_FORMAT, "face", s->next,
                           "the file ends before the last row", error);
        if (!(vertex >= 0) || vertex >= (double)s->ply.vertices)
            return fail_at(s, s->offset, PSPLAT_ERROR_RANGE, "face", s->next,
                           "a corner is not the index of a vertex", error);
        s->corners[i] = (uint32_t)vertex;
    }
    return split_face(s, (size_t)count, error);
}

static psplat_result next_face(psplat_triangle_stream *s, psplat_error *error) {
    for (size_t i = 0; i < s->ply.property_count; ++i) {
        const psplat_ply_property *property = &s->ply.properties[i];
        psplat_result result = PSPLAT_OK;
        double count = 1, value;
        int whole = !property->is_list || take_number(s, property->count_type, &count);
        if (whole && property->is_corners) {
            result = take_corners(s, property, count, error);
        } else {
            for (double k = 0; k < count && whole; ++k)
                whole = take_number(s, property->type, &value);
        }
        if (!whole)
            return fail_at(s, s->offset, PSPLAT_ERROR_FORMAT, "face", s->next,
                           "the file ends before the last row", error);
        if (result) return result;
    }
    ++s->next;
    return PSPLAT_OK;
}

static psplat_result next_ply(psplat_triangle_stream *s, psplat_stream_triangle *t,
                              psplat_error *error) {
    psplat_result result = s->left ? PSPLAT_OK : next_face(s, error);
    if (result) return result;
    const uint32_t *split = s->split + 3 * --s->left;
    for (size_t k = 0; k < 3 && !result; ++k)
        result = take_vertex(s, s->corners[split[k]], k, t, error);
    return result;
}

/* Drops the pages of a mapped file now and then. */
static void drop_pages(psplat_triangle_stream *s) {
    if (++s->read < DROP_TRIANGLES) return;
    s->read = 0;
    madvise((void *)(uintptr_t)s->data, s->size, MADV_DONTNEED);
}

psplat_result psplat_triangle_stream_next(psplat_triangle_stream *s, psplat_stream_triangle *t,
                                          int *got, psplat_error *error) {
    *got = 1;
    switch (s->kind) {
    case STL:
        *got = s->offset < s->size;
        if (!*got) return PSPLAT_OK;
        drop_pages(s);
        return next_stl(s, t, error);
    case PLY:
        *got = s->left || s->next < s->ply.faces;
        if (!*got) return PSPLAT_OK;
        drop_pages(s);
        return next_ply(s, t, error);
    default:
        *got = s->next < s->mesh.triangle_count;
        if (*got) next_in_memory(s, t);
        return PSPLAT_OK;
    }
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * block_mesh.c - the meshes of blocks: gathered from triangles, and kept in files.
 *
 * A file holds a head and the arrays as they lie in memory: it is read on the kind of machine that
 * wrote it.
 */
#include "tiles/block_mesh.h"

#include "base/file_bytes.h"
#include "base/output.h"
#include "base/path.h"
#include "tiles/checked_text.h"

#include <stdlib.h>
#include <string.h>

/* ---- soup ------------------------------------------------------------------------------------ */

static int enlarge(void **array, size_t bytes) {
    void *larger = realloc(*array, bytes);
    if (larger) *array = larger;
    return larger != NULL;
}

static int reserve(psplat_tile_soup *soup) {
    psplat_mesh *mesh = &soup->mesh;
    if (mesh->triangle_count < soup->capacity) return 1;
    size_t n = soup->capacity + soup->capacity / 2 + 1024;
    void *arrays[4] = {mesh->positions, mesh->triangles, mesh->corner_normals, mesh->corner_colors};
    const size_t bytes[4] = {9 * sizeof(double), 3 * sizeof(uint32_t),
                             soup->has_normals ? 9 * sizeof(float) : 0,
                             soup->has_colors ? 12 * sizeof(float) : 0};
    int has_memory = n <= PSPLAT_MAX_TRIANGLES / 3;
    for (int i = 0; i < 4; ++i)
        if (bytes[i] && has_memory) has_memory = enlarge(&arrays[i], n * bytes[i]);
    mesh->positions = arrays[0];
    mesh->triangles = arrays[1];
    mesh->corner_normals = arrays[2];
    mesh->corner_colors = arrays[3];
    if (has_memory) soup->capacity = n;
    return has_memory;
}

int psplat_tile_soup_add(void *user, const psplat_stream_triangle *t) {
    psplat_tile_soup *soup = user;
    psplat_mesh *mesh = &soup->mesh;
    if (soup->reach && !psplat_tile_cell_meets_triangle(soup->reach, t->positions)) return 0;
    if (!reserve(soup)) return 1;
    size_t n = mesh->triangle_count++;
    memcpy(mesh->positions + 9 * n, t->positions, sizeof t->positions);
    for (size_t k = 0; k < 3; ++k) mesh->triangles[3 * n + k] = (uint32_t)(3 * n + k);
    if (soup->has_normals) memcpy(mesh->corner_normals + 9 * n, t->normals, sizeof t->normals);
    if (soup->has_colors) memcpy(mesh->corner_colors + 12 * n, t->colors, sizeof t->colors);
    mesh->vertex_count = 3 * mesh->triangle_count;
    return 0;
}

psplat_result psplat_tile_soup_add_triangle(psplat_tile_soup *soup, const psplat_mesh *mesh,
                                            uint32_t triangle) {
    psplat_stream_triangle t = {0};
    for (int k = 0; k < 3; ++k)
        memcpy(t.positions + 3 * k, psplat_mesh_corner(mesh, triangle, k), 3 * sizeof(double));
    if (mesh->corner_colors)
        memcpy(t.colors, mesh->corner_colors + 12 * (size_t)triangle, sizeof t.colors);
    return psplat_tile_soup_add(soup, &t) ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

psplat_result psplat_tile_soup_add_mesh(psplat_tile_soup *soup, const psplat_mesh *mesh) {
    psplat_result result = PSPLAT_OK;
    for (uint32_t t = 0; t < mesh->triangle_count && !result; ++t)
        result = psplat_tile_soup_add_triangle(soup, mesh, t);
    return result;
}

void psplat_tile_soup_free(psplat_tile_soup *soup) {
    psplat_mesh_free(&soup->mesh);
    *soup = (psplat_tile_soup){0};
}

/* ---- files ----------------------------------------------------------------------------------- */

/* What a file begins with. */
typedef struct head {
    char magic[8];
    uint64_t version, vertices, triangles, has_colors, hash; /* hash: of the arrays */
    double deviation;
} head;

static const char magic[8] = "psplatm";
enum { MESH_VERSION = 1 };

/* An array of the file. */
typedef struct part {
    void *data;
    size_t bytes;
} part;

static void list_parts(const psplat_mesh *mesh, part parts[3]) {
    parts[0] = (part){mesh->positions, 3 * mesh->vertex_count * sizeof(double)};
    parts[1] = (part){mesh->triangles, 3 * mesh->triangle_count * sizeof(uint32_t)};
    parts[2] = (part){mesh->corner_colors,
                      mesh->corner_colors ? 12 * mesh->triangle_count * sizeof(float) : 0};
}

psplat_result psplat_tile_mesh_write(const psplat_mesh *mesh, double deviation, const char *path,
                                     psplat_error *error) {
    part parts[3];
    list_parts(mesh, parts);
    head h = {.version = MESH_VERSION,
              .vertices = mesh->vertex_count,
              .triangles = mesh->triangle_count,
              .has_colors = mesh->corner_colors != NULL,
              .hash = PSPLAT_HASH_BEGIN,
              .deviation = deviation};
    size_t size = sizeof h;
    memcpy(h.magic, magic, sizeof magic);
    for (int i = 0; i < 3; ++i) size += parts[i].bytes;
    char *bytes = malloc(size), *to = bytes + sizeof h;
    if (!bytes) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    for (int i = 0; i < 3; ++i) {
        if (parts[i].bytes) memcpy(to, parts[i].data, parts[i].bytes);
        to += parts[i].bytes;
    }
    h.hash = psplat_hash_bytes(h.hash, bytes + sizeof h, size - sizeof h);
    memcpy(bytes, &h, sizeof h);
    psplat_result result = psplat_output_write(path, bytes, size, 1, error);
    free(bytes);
    return result;
}

/* Returns the bytes that a file with this head has after it, or SIZE_MAX. */
static size_t expected_bytes(const head *h) {
    if (memcmp(h->magic, magic, sizeof magic) != 0 || h->version != MESH_VERSION ||
        h->vertices > PSPLAT_MAX_VERTICES || h->triangles > PSPLAT_MAX_TRIANGLES)
        return SIZE_MAX;
    return 3 * (size_t)h->vertices * sizeof(double) + 3 * (size_t)h->triangles * sizeof(uint32_t) +
           (h->has_colors ? 12 * (size_t)h->triangles * sizeof(float) : 0);
}

psplat_result psplat_tile_mesh_read(const char *path, psplat_mesh *mesh, double *deviation,
                                    psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH], *data;
    size_t size;
    head h = {0};
    part parts[3];
    *mesh = (psplat_mesh){0};
    psplat_path_shorten(path, shown);
    psplat_result result = psplat_file_read(path, &data, &size, error);
    if (result) return result;
    if (size >= sizeof h) memcpy(&h, data, sizeof h);
    if (size < sizeof h || size - sizeof h != expected_bytes(&h) ||
        psplat_hash_bytes(PSPLAT_HASH_BEGIN, data + sizeof h, size - sizeof h) != h.hash)
        result = psplat_fail(error, PSPLAT_ERROR_FORMAT, 0,
                             "%s: is not whole; delete it and the record beside it", shown);
    if (!result)
        result = psplat_mesh_allocate(mesh, h.vertices, h.triangles,
                                      h.has_colors ? PSPLAT_MESH_COLORS : 0, error);
    const char *from = data + sizeof h;
    if (!result) list_parts(mesh, parts);
    for (int i = 0; i < 3 && !result; ++i) {
        if (parts[i].bytes) memcpy(parts[i].data, from, parts[i].bytes);
        from += parts[i].bytes;
    }
    for (size_t i = 0; i < 3 * mesh->triangle_count && !result; ++i)
        if (mesh->triangles[i] >= mesh->vertex_count)
            result = psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "%s: vertex out of range", shown);
    *deviation = h.deviation;
    free(data);
    if (result) psplat_mesh_free(mesh);
    return result;
}

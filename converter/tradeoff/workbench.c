/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * workbench.c - the source, a graphics context, and what comparing takes: each made when it is
 * first needed, so that a finished sweep is answered from its journal at once.
 */
#define _XOPEN_SOURCE 700

#include "mask.h"
#include "source.h"
#include "tradeoff.h"

#include <stdlib.h>
#include <sys/stat.h>

static uint64_t stamp_mesh(uint64_t stamp, const psplat_mesh *m) {
    const size_t corners = 3 * m->triangle_count;
    stamp = psplat_stamp_bytes(stamp, m->positions, 3 * m->vertex_count * sizeof *m->positions);
    stamp = psplat_stamp_bytes(stamp, m->triangles, corners * sizeof *m->triangles);
    if (m->corner_normals)
        stamp =
            psplat_stamp_bytes(stamp, m->corner_normals, 3 * corners * sizeof *m->corner_normals);
    if (m->corner_colors)
        stamp = psplat_stamp_bytes(stamp, m->corner_colors, 4 * corners * sizeof *m->corner_colors);
    return psplat_stamp_bytes(stamp, m->origin, sizeof m->origin);
}

/* It is read twice, and by other programs. */
static psplat_result check_source(const char *path, psplat_error *error) {
    struct stat status;
    char shown[PSPLAT_SHOWN_PATH];
    if (stat(path, &status) || S_ISREG(status.st_mode) || S_ISDIR(status.st_mode)) return PSPLAT_OK;
    psplat_path_shorten(path, shown);
    return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s: is not a file", shown);
}

/* The file's bytes, and what was read from it: a .gltf has its numbers in other files. */
static psplat_result stamp_source(psplat_workbench *bench, psplat_error *error) {
    char *data = NULL;
    psplat_result result = psplat_source_read_file(bench->path, &data, &bench->bytes, error);
    if (result) return result;
    bench->stamp = stamp_mesh(psplat_stamp_bytes(PSPLAT_STAMP, data, bench->bytes), &bench->mesh);
    free(data);
    return PSPLAT_OK;
}

static psplat_result open_graphics(psplat_workbench *bench, psplat_error *error) {
    psplat_result result = psplat_context_create(bench->software, &bench->host, error);
    const psplat_renderer_desc desc = {.get_proc = psplat_host_get_proc, .user = bench->host};
    return result ? result : psplat_renderer_create(&desc, &bench->renderer, error);
}

psplat_result psplat_workbench_open(psplat_workbench *bench, psplat_error *error) {
    psplat_result result = check_source(bench->path, error);
    if (!result) result = psplat_mesh_read(bench->path, &bench->mesh, error);
    if (!result) result = psplat_mask_apply(&bench->mesh, 0.25, error);
    if (!result) result = stamp_source(bench, error);
    return result ? result : open_graphics(bench, error);
}

void psplat_workbench_close(psplat_workbench *bench) {
    psplat_gallery_destroy(bench->gallery);
    psplat_renderer_destroy(bench->renderer);
    psplat_host_destroy(bench->host);
    psplat_original_destroy(bench->original);
    psplat_mesh_free(&bench->mesh);
}

psplat_result psplat_workbench_original(psplat_workbench *bench, psplat_error *error) {
    if (bench->original) return PSPLAT_OK;
    return psplat_original_create(&bench->mesh, bench->crease_angle, &bench->original, error);
}

psplat_result psplat_workbench_gallery(psplat_workbench *bench, psplat_error *error) {
    if (bench->gallery) return PSPLAT_OK;
    psplat_result result = psplat_workbench_original(bench, error);
    const psplat_gallery_desc desc = {bench->host, bench->original, bench->size};
    return result ? result : psplat_gallery_create(&desc, &bench->gallery, error);
}

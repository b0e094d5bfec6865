/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sweep_context.c - the source, a graphics context, and what comparing takes. What is slow to make
 * is made when it is first needed, so that a finished sweep is answered from its table at once.
 */
#define _XOPEN_SOURCE 700

#include "benchmark/sweep_context.h"

#include "appearance/alpha_mask.h"
#include "base/file_bytes.h"
#include "base/path.h"
#include "benchmark/frame_timing.h"
#include "compare/source_mesh.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "views/gl_context.h"
#include "views/image_loader.h"
#include "views/picture_views.h"

#include <phongsplat/phongsplat.h>
#include <phongsplat/host.h>

#include <stdlib.h>
#include <sys/stat.h>

/* FNV-1a (Fowler, Noll, Vo) tells changed sources apart. */
static uint64_t hash(uint64_t before, const void *data, size_t size) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; ++i) before = (before ^ bytes[i]) * UINT64_C(0x100000001b3);
    return before;
}

static uint64_t hash_mesh(uint64_t before, const psplat_mesh *m) {
    const size_t corners = 3 * m->triangle_count;
    before = hash(before, m->positions, 3 * m->vertex_count * sizeof *m->positions);
    before = hash(before, m->triangles, corners * sizeof *m->triangles);
    if (m->corner_normals)
        before = hash(before, m->corner_normals, 3 * corners * sizeof *m->corner_normals);
    if (m->corner_colors)
        before = hash(before, m->corner_colors, 4 * corners * sizeof *m->corner_colors);
    before = hash(before, &m->material, sizeof m->material);
    return hash(before, m->origin, sizeof m->origin);
}

/* A source is read twice, and by other programs, so it must be a file. */
static psplat_result check_source(const char *path, psplat_error *error) {
    struct stat status;
    char shown[PSPLAT_SHOWN_PATH];
    if (stat(path, &status) || S_ISREG(status.st_mode) || S_ISDIR(status.st_mode)) return PSPLAT_OK;
    psplat_path_shorten(path, shown);
    return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s: is not a file", shown);
}

/* The hash is of the mesh, too, for a .gltf and an .obj have parts of it in other files. */
static psplat_result hash_source(psplat_sweep_context *context, psplat_error *error) {
    char *data = NULL;
    psplat_result result = psplat_file_read(context->path, &data, &context->source_bytes, error);
    if (result) return result;
    context->source_hash =
        hash_mesh(hash(UINT64_C(0xcbf29ce484222325), data, context->source_bytes), &context->mesh);
    free(data);
    return PSPLAT_OK;
}

static psplat_result open_graphics(psplat_sweep_context *context, psplat_error *error) {
    psplat_result result = psplat_context_create(context->software, &context->host, error);
    const psplat_renderer_desc desc = {
        .get_proc = psplat_host_get_proc, .user = context->host, .images = psplat_image_loader()};
    return result ? result : psplat_renderer_create(&desc, &context->renderer, error);
}

psplat_result psplat_sweep_context_open(psplat_sweep_context *context, psplat_error *error) {
    psplat_result result = check_source(context->path, error);
    if (!result) result = psplat_mesh_read(context->path, &context->mesh, error);
    if (!result) result = psplat_alpha_mask_apply(&context->mesh, 0.25, error);
    if (!result) result = hash_source(context, error);
    return result ? result : open_graphics(context, error);
}

void psplat_sweep_context_close(psplat_sweep_context *context) {
    psplat_sweep_context_drop_draft(context);
    psplat_picture_views_destroy(context->views);
    psplat_renderer_destroy(context->renderer);
    psplat_host_destroy(context->host);
    psplat_source_mesh_destroy(context->source_mesh);
    psplat_mesh_free(&context->mesh);
}

psplat_result psplat_sweep_context_source_mesh(psplat_sweep_context *context, psplat_error *error) {
    if (context->source_mesh) return PSPLAT_OK;
    return psplat_source_mesh_create(&context->mesh, context->crease_angle, &context->source_mesh,
                                     error);
}

psplat_result psplat_sweep_context_views(psplat_sweep_context *context, psplat_error *error) {
    if (context->views) return PSPLAT_OK;
    psplat_result result = psplat_sweep_context_source_mesh(context, error);
    const psplat_picture_views_desc desc = {
        .host = context->host, .source = context->source_mesh, .size = context->size};
    return result ? result : psplat_picture_views_create(&desc, &context->views, error);
}

psplat_result psplat_sweep_context_draft(psplat_sweep_context *context,
                                         const psplat_convert_desc *desc, psplat_error *error) {
    if (context->draft && context->draft_tolerance == desc->tolerance_percent) return PSPLAT_OK;
    psplat_sweep_context_drop_draft(context);
    double start = psplat_timing_clock();
    psplat_result result = psplat_draft_create(&context->mesh, desc, &context->draft, error);
    context->draft_tolerance = desc->tolerance_percent;
    context->draft_seconds = psplat_timing_clock() - start;
    return result;
}

void psplat_sweep_context_drop_draft(psplat_sweep_context *context) {
    psplat_draft_destroy(context->draft);
    context->draft = NULL;
}

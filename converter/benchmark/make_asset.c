/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * make_asset.c - assets made and written into the folder.
 */
#define _XOPEN_SOURCE 700

#include "benchmark/make_asset.h"

#include "base/output.h"
#include "benchmark/frame_timing.h"
#include "benchmark/gltfpack.h"
#include "benchmark/sweep_context.h"
#include "benchmark/sweep_progress.h"
#include "benchmark/write_obj.h"
#include "export/glb_writer.h"
#include "export/meshopt_codec.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "table/folder.h"
#include "table/row.h"
#include "table/setting.h"
#include "table/sweep_options.h"
#include "table/text.h"
#include "verify/report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char source_name[] = "assets/source.obj";
/* Another program writes here first, for it may be killed. What it leaves then is overwritten. */
static const char draft_name[] = "assets/.phongsplat-gltfpack.glb";

static psplat_result fail_memory(psplat_error *error) {
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
}

/* ---- files -------------------------------------------------------------------------------- */

static char *make_path(const char *folder, const char *prefix, const psplat_setting *setting) {
    psplat_text name = {0};
    psplat_text_add(&name, "assets/%s", prefix);
    psplat_setting_file(setting, &name);
    char *path = name.failed ? NULL : psplat_folder_path(folder, name.data);
    free(name.data);
    return path;
}

static const char *plain_prefix(const psplat_setting *setting) {
    return setting->competitor == PSPLAT_COMPETITOR_GLTFPACK ? "plain-" : "";
}

char *psplat_make_asset_path(const char *folder, const psplat_setting *setting) {
    return make_path(folder, plain_prefix(setting), setting);
}

/* Returns how long a file is, or -1 where there is none. */
static double bytes_of(const char *folder, const char *prefix, const psplat_setting *setting) {
    struct stat status;
    char *path = make_path(folder, prefix, setting);
    int is_there = path && !stat(path, &status) && S_ISREG(status.st_mode);
    free(path);
    return is_there ? (double)status.st_size : -1;
}

int psplat_make_asset_is_done(const char *folder, const psplat_row *row) {
    return bytes_of(folder, "", &row->setting) == row->values[PSPLAT_COLUMN_BYTES] &&
           bytes_of(folder, plain_prefix(&row->setting), &row->setting) > 0;
}

/* ---- splats ------------------------------------------------------------------------------- */

/* The model is named as `phongsplat convert` names it, so that the bytes are those of that command.
 */
static psplat_result write_splats(const psplat_asset_maker *m, const psplat_setting *setting,
                                  const psplat_splats *splats, psplat_error *error) {
    const psplat_write_desc desc = {.codec = &psplat_meshopt_codec};
    uint8_t *data = NULL;
    size_t size = 0;
    psplat_text model = {0};
    psplat_text_stem(&model, m->context->path);
    char *path = make_path(m->folder, "", setting);
    psplat_result result = path && model.data ? PSPLAT_OK : fail_memory(error);
    if (!result) result = psplat_glb_write(splats, model.data, &desc, &data, &size, error);
    if (!result) result = psplat_output_write(path, data, size, 1, error);
    free(path);
    free(model.data);
    free(data);
    return result;
}

static psplat_convert_desc convert_desc(const psplat_asset_maker *m,
                                        const psplat_setting *setting) {
    const psplat_sweep_options *o = m->options;
    return (psplat_convert_desc){
        .tolerance_percent = setting->tolerance,
        .normal_tolerance_degrees = o->normal_tolerance,
        .crease_angle_degrees = o->crease_angle,
        .no_creases = o->no_creases,
        .precision = setting->form == PSPLAT_FORM_FLOAT ? 0 : PSPLAT_USUAL_PRECISION,
        .effort = o->effort,
        .seed = o->seed,
        .progress = psplat_sweep_progress_show_stage,
        .user = m->progress,
        .planar = setting->form == PSPLAT_FORM_PLANAR,
    };
}

/* Converts as psplat_convert does. Settings that differ in their precision alone share a draft, and
 * all that they share counts for each of them: *seconds is what the command takes. */
static psplat_result convert_setting(const psplat_asset_maker *m, const psplat_setting *setting,
                                     psplat_splats *splats, psplat_report *report, double *seconds,
                                     psplat_error *error) {
    psplat_sweep_context *context = m->context;
    const psplat_convert_desc desc = convert_desc(m, setting);
    psplat_result result = PSPLAT_OK;
    double before = 0, start;
    if (desc.planar) {
        psplat_sweep_context_drop_draft(context);
        start = psplat_timing_clock();
        result = psplat_convert(&context->mesh, &desc, splats, report, error);
    } else {
        result = psplat_sweep_context_draft(context, &desc, error);
        before = context->draft_seconds;
        start = psplat_timing_clock();
        if (!result)
            result = psplat_draft_convert(context->draft, desc.precision, splats, report, error);
    }
    *seconds = before + psplat_timing_clock() - start;
    return result;
}

static psplat_result convert(const psplat_asset_maker *m, psplat_row *row, psplat_error *error) {
    psplat_splats splats = {0};
    psplat_report report = {0};
    double seconds = 0;
    psplat_result result = convert_setting(m, &row->setting, &splats, &report, &seconds, error);
    double start = psplat_timing_clock();
    if (!result) result = write_splats(m, &row->setting, &splats, error);
    row->values[PSPLAT_COLUMN_CONVERT_S] = seconds + psplat_timing_clock() - start;
    row->values[PSPLAT_COLUMN_ELEMENTS] = (double)splats.count;
    row->values[PSPLAT_COLUMN_BROKEN] = 0;
    for (int i = 0; i < PSPLAT_PROMISE_COUNT; ++i)
        row->values[PSPLAT_COLUMN_BROKEN] += report.promises[i].broken > 0;
    psplat_splats_free(&splats);
    return result;
}

/* ---- simplified meshes -------------------------------------------------------------------- */

/* gltfpack reads the source where it knows the format and has normals to go by, else ours. */
static psplat_result find_input(const psplat_asset_maker *m, char **input, psplat_error *error) {
    psplat_sweep_context *context = m->context;
    int is_source = psplat_gltfpack_reads(context->path) && context->mesh.corner_normals;
    *input = is_source ? strdup(context->path) : psplat_folder_path(m->folder, source_name);
    if (!*input) return fail_memory(error);
    if (is_source) return PSPLAT_OK;
    psplat_text text = {0};
    psplat_result result = psplat_sweep_context_source_mesh(context, error);
    if (!result) psplat_write_obj(context->source_mesh, &text);
    if (!result) result = psplat_text_check(&text, error);
    if (!result) result = psplat_output_write(*input, text.data, text.size, 1, error);
    free(text.data);
    return result;
}

static psplat_result simplify_to(const psplat_asset_maker *m, const char *input,
                                 const psplat_setting *setting, int plain, psplat_error *error) {
    const char *const options[] = {plain ? "-noq" : "-cc", NULL};
    char *draft = psplat_folder_path(m->folder, draft_name);
    char *path = make_path(m->folder, plain ? plain_prefix(setting) : "", setting);
    psplat_result result = draft && path ? psplat_gltfpack_run(m->gltfpack, input, setting->ratio,
                                                               options, draft, error)
                                         : fail_memory(error);
    if (!result && rename(draft, path))
        result = psplat_fail(error, PSPLAT_ERROR_READ, 0, "gltfpack left no file");
    if (result && draft) unlink(draft);
    free(draft);
    free(path);
    return result;
}

static psplat_result count_triangles(const psplat_asset_maker *m, psplat_row *row,
                                     psplat_error *error) {
    psplat_mesh mesh = {0};
    char *path = psplat_make_asset_path(m->folder, &row->setting);
    psplat_result result = path ? psplat_mesh_read(path, &mesh, error) : fail_memory(error);
    row->values[PSPLAT_COLUMN_ELEMENTS] = (double)mesh.triangle_count;
    psplat_mesh_free(&mesh);
    free(path);
    return result;
}

static psplat_result simplify(const psplat_asset_maker *m, psplat_row *row, psplat_error *error) {
    char *input = NULL;
    psplat_result result = find_input(m, &input, error);
    double start = psplat_timing_clock();
    if (!result) result = simplify_to(m, input, &row->setting, 0, error);
    row->values[PSPLAT_COLUMN_CONVERT_S] = psplat_timing_clock() - start;
    if (!result) result = simplify_to(m, input, &row->setting, 1, error);
    if (!result) result = count_triangles(m, row, error);
    free(input);
    return result;
}

psplat_result psplat_make_asset(const psplat_asset_maker *maker, psplat_row *row,
                                psplat_error *error) {
    const psplat_setting *setting = &row->setting;
    psplat_result result =
        psplat_sweep_progress_begin(maker->progress, PSPLAT_TASK_MAKE, setting, error);
    if (result) return result;
    result = setting->competitor == PSPLAT_COMPETITOR_SPLATS ? convert(maker, row, error)
                                                             : simplify(maker, row, error);
    row->values[PSPLAT_COLUMN_BYTES] = bytes_of(maker->folder, "", setting);
    return result;
}

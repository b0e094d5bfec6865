/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * make.c - the assets of a sweep: splats as `phongsplat convert` makes them, simplified meshes as
 * gltfpack does.
 */
#define _XOPEN_SOURCE 700

#include "sweep.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char source_name[] = "assets/source.obj";

/* ---- files -------------------------------------------------------------------------------- */

/* Relative to the folder. */
static void asset_name(const psplat_setting *setting, const char *prefix, psplat_text *name) {
    psplat_text_add(name, "assets/%s", prefix);
    psplat_setting_file(setting, name);
}

/* Of what was made: of gltfpack's two files both. 0: not there. */
uint64_t psplat_make_stamp(const psplat_sweep *s, const psplat_setting *setting, size_t *bytes) {
    psplat_text name = {0};
    size_t plain_bytes = 0;
    asset_name(setting, "", &name);
    uint64_t stamp = name.failed ? 0 : psplat_folder_stamp(&s->folder, name.data, bytes);
    free(name.data);
    if (!stamp || setting->contender != PSPLAT_CONTENDER_GLTFPACK) return stamp;
    name = (psplat_text){.size = 0};
    asset_name(setting, "plain-", &name);
    uint64_t plain = name.failed ? 0 : psplat_folder_stamp(&s->folder, name.data, &plain_bytes);
    free(name.data);
    return plain ? psplat_stamp_bytes(stamp, &plain, sizeof plain) : 0;
}

static void remove_file(const psplat_sweep *s, const psplat_setting *setting, const char *prefix) {
    psplat_text name = {0};
    asset_name(setting, prefix, &name);
    char *path = name.failed ? NULL : psplat_folder_path(&s->folder, name.data);
    if (path) unlink(path);
    free(path);
    free(name.data);
}

void psplat_make_remove(const psplat_sweep *s, const psplat_setting *setting) {
    remove_file(s, setting, "");
    if (setting->contender == PSPLAT_CONTENDER_GLTFPACK) remove_file(s, setting, "plain-");
}

psplat_result psplat_make_text(const psplat_sweep *s, const char *name, psplat_text *text,
                               psplat_error *error) {
    psplat_result result = psplat_text_check(text, error);
    if (!result) result = psplat_folder_write(&s->folder, name, text->data, text->size, error);
    free(text->data);
    *text = (psplat_text){.size = 0};
    return result;
}

/* ---- making ------------------------------------------------------------------------------- */

double psplat_make_share(const psplat_setting *setting) {
    return setting->contender == PSPLAT_CONTENDER_SPLATS
               ? psplat_estimate_conversion(setting->tolerance)
               : 1;
}

psplat_task psplat_make_task(const psplat_setting *setting) {
    return setting->contender == PSPLAT_CONTENDER_SPLATS ? PSPLAT_TASK_CONVERT
                                                         : PSPLAT_TASK_SIMPLIFY;
}

/* As `phongsplat convert` names it, so that its bytes are those of that command. */
static char *model_name(const char *path) {
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    const char *dot = strrchr(base, '.');
    return strndup(base, dot && dot > base ? (size_t)(dot - base) : strlen(base));
}

static psplat_result write_splats(const psplat_sweep *s, const psplat_setting *setting,
                                  const psplat_splats *splats, psplat_error *error) {
    const psplat_write_desc desc = {0}; /* as convert --no-compress */
    uint8_t *data = NULL;
    size_t size = 0;
    char *model = model_name(s->desc->source);
    psplat_text name = {0};
    asset_name(setting, "", &name);
    psplat_result result = psplat_text_check(&name, error);
    if (!result) result = psplat_glb_write_as(splats, model, &desc, &data, &size, error);
    if (!result) result = psplat_folder_write(&s->folder, name.data, data, size, error);
    free(name.data);
    free(model);
    free(data);
    return result;
}

static psplat_result convert(psplat_sweep *s, psplat_row *row, psplat_error *error) {
    const psplat_tradeoff_options *o = &s->journal->options;
    const psplat_convert_desc desc = {
        .tolerance_percent = row->setting.tolerance,
        .normal_tolerance_degrees = o->normal_tolerance,
        .crease_angle_degrees = o->crease_angle,
        .no_creases = o->no_creases,
        .constant_normals = row->setting.field == PSPLAT_FIELD_CONSTANT,
        .effort = o->effort,
        .seed = o->seed,
        .progress = psplat_task_show_conversion,
        .user = s,
    };
    psplat_splats splats = {0};
    psplat_report report = {0};
    double start = psplat_timing_clock();
    psplat_result result = psplat_convert(&s->bench.mesh, &desc, &splats, &report, error);
    if (!result) result = write_splats(s, &row->setting, &splats, error);
    row->values[PSPLAT_COLUMN_CONVERT_S] = psplat_timing_clock() - start;
    row->values[PSPLAT_COLUMN_ELEMENTS] = (double)splats.count;
    row->values[PSPLAT_COLUMN_BROKEN] = 0;
    for (int i = 0; i < PSPLAT_PROMISE_COUNT; ++i)
        row->values[PSPLAT_COLUMN_BROKEN] += report.promises[i].broken > 0;
    psplat_splats_free(&splats);
    ++s->counts->conversions;
    return result;
}

/* What gltfpack reads: the source where it knows the format and has normals to go by, else ours. */
static psplat_result find_input(psplat_sweep *s, char **input, psplat_error *error) {
    const char *dot = strrchr(s->desc->source, '.');
    int is_known = dot && (!strcmp(dot, ".obj") || !strcmp(dot, ".gltf") || !strcmp(dot, ".glb"));
    *input = is_known && s->bench.mesh.corner_normals ? strdup(s->desc->source)
                                                      : psplat_folder_path(&s->folder, source_name);
    if (!*input) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    if (!strcmp(*input, s->desc->source)) return PSPLAT_OK;
    psplat_text text = {0};
    psplat_result result = psplat_workbench_original(&s->bench, error);
    if (result) return result;
    psplat_wavefront_write(s->bench.original, &text);
    return psplat_make_text(s, source_name, &text, error);
}

/* Through a temporary file: another program writes it, and may be killed. */
static psplat_result simplify_to(psplat_sweep *s, const char *input, const psplat_setting *setting,
                                 int plain, psplat_error *error) {
    char own[64];
    psplat_text name = {0};
    snprintf(own, sizeof own, "assets/.phongsplat-%ld-gltfpack.glb", (long)getpid());
    asset_name(setting, plain ? "plain-" : "", &name);
    char *temporary = psplat_folder_path(&s->folder, own);
    char *path = name.failed ? NULL : psplat_folder_path(&s->folder, name.data);
    psplat_result result =
        temporary && path
            ? psplat_gltfpack_run(&s->gltfpack, input, setting->ratio, plain, temporary, error)
            : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    if (!result && rename(temporary, path))
        result = psplat_fail(error, PSPLAT_ERROR_READ, 0, "gltfpack left no file");
    if (result && temporary) unlink(temporary);
    free(name.data);
    free(temporary);
    free(path);
    return result;
}

/* How many triangles are left. */
static psplat_result count_triangles(const psplat_sweep *s, psplat_row *row, psplat_error *error) {
    psplat_mesh mesh = {0};
    char *path = psplat_contest_path(&s->folder, &row->setting);
    psplat_result result = path
                               ? psplat_mesh_read(path, &mesh, error)
                               : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    row->values[PSPLAT_COLUMN_ELEMENTS] = (double)mesh.triangle_count;
    psplat_mesh_free(&mesh);
    free(path);
    return result;
}

static psplat_result simplify(psplat_sweep *s, psplat_row *row, psplat_error *error) {
    char *input = NULL;
    if (!*s->gltfpack.version)
        return psplat_fail(error, PSPLAT_ERROR_READ, 0, "gltfpack cannot be run any more");
    psplat_result result = find_input(s, &input, error);
    double start = psplat_timing_clock();
    if (!result) result = simplify_to(s, input, &row->setting, 0, error);
    row->values[PSPLAT_COLUMN_CONVERT_S] = psplat_timing_clock() - start;
    if (!result) result = simplify_to(s, input, &row->setting, 1, error);
    if (!result) result = count_triangles(s, row, error);
    free(input);
    ++s->counts->simplifications;
    return result;
}

psplat_result psplat_make_asset(psplat_sweep *s, psplat_row *row, psplat_error *error) {
    int is_splats = row->setting.contender == PSPLAT_CONTENDER_SPLATS;
    size_t bytes = 0;
    psplat_result result =
        psplat_task_begin(s, psplat_make_task(&row->setting), psplat_make_share(&row->setting),
                          is_splats ? "converting" : "simplifying", row, error);
    if (!result) result = is_splats ? convert(s, row, error) : simplify(s, row, error);
    if (result) return result;
    row->content = psplat_make_stamp(s, &row->setting, &bytes);
    row->values[PSPLAT_COLUMN_BYTES] = (double)bytes;
    row->stamps[PSPLAT_GROUP_MADE] =
        psplat_plan_stamp(s->journal, row, s->bench.stamp, PSPLAT_GROUP_MADE);
    psplat_task_end(s);
    return PSPLAT_OK;
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_convert.c - phongsplat convert: a mesh becomes an asset, and what was measured a report.
 */
#define _XOPEN_SOURCE 700

#include "command.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

typedef struct arguments {
    const char *input;
    const char *output;
    const char *report;
    double tolerance;
    double crease_angle;
    uint64_t seed;
    int overwrite;
    int quiet;
} arguments;

/* What the conversion makes; everything is freed by free_product. */
typedef struct product {
    psplat_mesh mesh;
    psplat_splats splats;
    psplat_report report;
    uint8_t *bytes;
    size_t size;
} product;

static psplat_parse parse(int argc, char **argv, arguments *a) {
    const psplat_option options[] = {
        {'i', "input", PSPLAT_OPTION_TEXT, &a->input, "IN", "the mesh, instead of the operand", 0,
         0, NULL},
        {'o', "output", PSPLAT_OPTION_TEXT, &a->output, "OUT.glb",
         "the asset, instead of the operand; - is standard output", 0, 0, NULL},
        {'t', "tolerance", PSPLAT_OPTION_PERCENT, &a->tolerance, "PERCENT",
         "greatest distance between splats and surface, in % of the\n"
         "bounding box's diagonal: 0.5% or 0.5 (default 0.5)",
         1e-4, 50, NULL},
        {0, "crease-angle", PSPLAT_OPTION_NUMBER, &a->crease_angle, "DEG",
         "angle between two faces from which their edge stays\nsharp (default 30)", 1, 180, NULL},
        {0, "seed", PSPLAT_OPTION_UNSIGNED, &a->seed, "N",
         "seed of the sampling (default 0); equal input, options\nand seed give equal bytes", 0, 0,
         NULL},
        {0, "report", PSPLAT_OPTION_TEXT, &a->report, "R.json",
         "write what was measured as JSON; - is standard output", 0, 0, NULL},
        {'w', "overwrite", PSPLAT_OPTION_FLAG, &a->overwrite, NULL,
         "replace OUT.glb and R.json where they exist", 0, 0, NULL},
        {'q', "quiet", PSPLAT_OPTION_FLAG, &a->quiet, NULL, "print errors only", 0, 0, NULL},
    };
    const char **const slots[] = {&a->input, &a->output};
    const psplat_syntax syntax = {
        .command = "convert",
        .operands = "IN OUT.glb",
        .summary = "Converts a mesh (OBJ, PLY, OFF, STL, glTF, GLB) to Phong splats in a GLB.",
        .notes = "OUT.glb is written whole or not at all.",
        .options = options,
        .option_count = sizeof options / sizeof *options,
        .slots = slots,
        .slot_count = 2,
    };
    return psplat_options_parse(&syntax, argc, argv);
}

static double seconds_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* VmHWM begins anew with each program; ru_maxrss, its portable relative, starts at what the shell
 * or test that started us once used. */
static size_t peak_memory(void) {
    struct rusage usage;
    size_t kilobytes = getrusage(RUSAGE_SELF, &usage) ? 0 : (size_t)usage.ru_maxrss;
    char line[128];
    FILE *status = fopen("/proc/self/status", "r");
    while (status && fgets(line, sizeof line, status))
        if (sscanf(line, "VmHWM: %zu", &kilobytes) == 1) break;
    if (status) fclose(status);
    return kilobytes * 1024;
}

static psplat_result check_outputs(const arguments *a, psplat_error *error) {
    psplat_result result = psplat_output_check(a->input, a->output, a->overwrite, error);
    if (result || !a->report) return result;
    if (psplat_output_is_same(a->report, a->output)) {
        char shown[PSPLAT_SHOWN_PATH];
        psplat_path_shorten(a->report, shown);
        return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s: is also the asset", shown);
    }
    return psplat_output_check(a->input, a->report, a->overwrite, error);
}

/* The file's name without directory and extension names the node and the mesh. */
static char *model_name(const char *path) {
    const char *slash = strrchr(path, '/');
    const char *base = slash ? slash + 1 : path;
    const char *dot = strrchr(base, '.');
    return strndup(base, dot && dot > base ? (size_t)(dot - base) : strlen(base));
}

/* What is about to be written must be something the runtime opens. */
static psplat_result check_asset(const product *p, psplat_error *error) {
    psplat_asset *asset = NULL;
    psplat_error refused = {0};
    size_t splats = 0;
    psplat_result result = psplat_asset_open_memory(p->bytes, p->size, NULL, &asset, &refused);
    if (result == PSPLAT_ERROR_MEMORY) return psplat_fail(error, result, 0, "%s", refused.text);
    if (result)
        return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "the runtime refuses the result: %.180s",
                           refused.text);
    for (size_t i = 0; i < psplat_asset_batch_count(asset); ++i)
        splats += psplat_asset_batch(asset, i)->splat_count;
    psplat_asset_destroy(asset);
    if (splats == p->splats.count) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%zu splats became %zu in the result",
                       p->splats.count, splats);
}

static psplat_result make(const arguments *a, product *p, psplat_error *error) {
    psplat_progress progress = psplat_progress_begin(a->quiet);
    psplat_convert_desc desc = {
        .tolerance_percent = a->tolerance,
        .crease_angle_degrees = a->crease_angle,
        .seed = a->seed,
        .progress = psplat_progress_show,
        .user = &progress,
    };
    char *name = model_name(a->input);
    psplat_progress_show(&progress, "reading", 0);
    psplat_result result = psplat_mesh_read(a->input, &p->mesh, error);
    if (!result) result = psplat_convert(&p->mesh, &desc, &p->splats, &p->report, error);
    psplat_progress_show(&progress, "writing", 0);
    if (!result) result = psplat_glb_write(&p->splats, name, &p->bytes, &p->size, error);
    if (!result) result = check_asset(p, error);
    psplat_progress_end(&progress);
    free(name);
    return result;
}

static psplat_result write_report(const arguments *a, const product *p, psplat_error *error) {
    char *text = NULL;
    size_t size = 0;
    psplat_result result = psplat_report_json(&p->report, &text, &size, error);
    if (!result) result = psplat_output_write(a->report, text, size, a->overwrite, error);
    free(text);
    return result;
}

/* By whatever name: "-", /dev/stdout, or the pipe that it is. */
static int is_standard_output(const char *path) {
    struct stat there, here;
    if (!path || !strcmp(path, "-")) return path != NULL;
    return !stat(path, &there) && !fstat(STDOUT_FILENO, &here) && there.st_dev == here.st_dev &&
           there.st_ino == here.st_ino;
}

/* What standard output carries is carried alone. */
static void print_summary(const arguments *a, const psplat_report *r) {
    if (a->quiet || is_standard_output(a->output) || is_standard_output(a->report)) return;
    printf("%s: %zu splats, %zu bytes, max distance %.3g %% (tolerance %.3g %%), rms normal %.3g "
           "degrees, %zu of %zu samples uncovered, %.2f s\n",
           a->output, r->splats, r->bytes, r->max_distance_percent, r->tolerance_percent,
           r->rms_normal_degrees, r->uncovered_samples, r->verification_samples, r->seconds);
}

static void free_product(product *p) {
    psplat_mesh_free(&p->mesh);
    psplat_splats_free(&p->splats);
    free(p->bytes);
}

int psplat_command_convert(int argc, char **argv) {
    arguments a = {0};
    psplat_parse parsed = parse(argc, argv, &a);
    if (parsed != PSPLAT_PARSE_OK)
        return parsed == PSPLAT_PARSE_HELP ? PSPLAT_EXIT_SUCCESS : PSPLAT_EXIT_USAGE;
    double start = seconds_now();
    product p = {0};
    psplat_error error = {0};
    const char *subject = NULL;
    psplat_result result = check_outputs(&a, &error);
    if (!result) {
        result = make(&a, &p, &error);
        subject = result == PSPLAT_ERROR_WRITE ? a.output : a.input;
    }
    if (!result) {
        result = psplat_output_write(a.output, p.bytes, p.size, a.overwrite, &error);
        subject = NULL;
    }
    p.report.bytes = p.size;
    p.report.seconds = seconds_now() - start;
    p.report.peak_memory_bytes = peak_memory();
    if (!result && a.report) result = write_report(&a, &p, &error);
    if (!result) print_summary(&a, &p.report);
    free_product(&p);
    return result ? psplat_command_fail(subject, &error) : PSPLAT_EXIT_SUCCESS;
}

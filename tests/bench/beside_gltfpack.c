/* SPDX-License-Identifier: MIT
 *
 * beside_gltfpack.c - options, models and conversions of benchmarks beside gltfpack.
 */
#include "beside_gltfpack.h"

#include "benchmark/subprocess.h"
#include "benchmark/write_obj.h"
#include "compare/source_mesh_parts.h"
#include "table/text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static _Noreturn void give_up(const char *subject, const char *cause) {
    fprintf(stderr, "benchmark: %s %s\n", subject, cause);
    exit(1);
}

void bench_check(psplat_result result, const psplat_error *error) {
    if (result != PSPLAT_OK) give_up("error:", error->text);
}

/* ---- options --------------------------------------------------------------------------------- */

bench_list bench_parse_list(const char *text) {
    const char *whole = text;
    bench_list l = {.count = 0};
    while (*text && l.count < BENCH_MOST) {
        char *end = NULL;
        l.values[l.count++] = strtod(text, &end);
        if (end == text || (*end && *end != ',')) give_up(whole, "is no list of numbers");
        text = *end ? end + 1 : end;
    }
    return l;
}

/* Takes an option and its value. Returns 0 where name is no option. */
static int take(bench_options *set, const char *name, const char *value) {
    if (strncmp(name, "--", 2) != 0) return 0;
    if (!value) give_up(name, "needs a value");
    if (!strcmp(name, "--gltfpack")) set->gltfpack = value;
    if (!strcmp(name, "--phongsplat")) set->phongsplat = value;
    if (!strcmp(name, "--folder")) set->folder = value;
    if (!strcmp(name, "--csv")) set->csv = value;
    if (!strcmp(name, "--tolerances")) set->tolerances = bench_parse_list(value);
    if (!strcmp(name, "--normal-tolerances")) set->normal_tolerances = bench_parse_list(value);
    if (!strcmp(name, "--ratios")) set->ratios = bench_parse_list(value);
    if (!strcmp(name, "--size") || !strcmp(name, "--sizes")) set->sizes = bench_parse_list(value);
    if (!strcmp(name, "--pass") && set->passed_count < BENCH_MOST)
        set->passed[set->passed_count++] = value;
    return 1;
}

void bench_parse(bench_options *set, const char *const *usual_models, int argc, char **argv) {
    const char *folder = getenv("PSPLAT_BENCH_MODELS");
    set->phongsplat = PSPLAT_PROGRAM;
    set->folder = folder ? folder : PSPLAT_SOURCE_DIR "/../shared/models";
    for (int i = 1; i < argc; ++i)
        if (take(set, argv[i], argv[i + 1]))
            ++i;
        else if (set->model_count < BENCH_MOST)
            set->models[set->model_count++] = argv[i];
    if (set->model_count) return;
    while (*usual_models && set->model_count < BENCH_MOST)
        set->models[set->model_count++] = *usual_models++;
}

FILE *bench_open_csv(const bench_options *set) {
    FILE *csv = set->csv ? fopen(set->csv, "w") : NULL;
    if (set->csv && !csv) give_up(set->csv, "cannot be written");
    return csv;
}

/* ---- models and files ------------------------------------------------------------------------ */

/* Returns the path of a model, for which there is place in path, or NULL where it is not there. */
static const char *find_model(const bench_options *set, const char *model, char path[1024]) {
    if (!access(model, R_OK)) return model;
    snprintf(path, 1024, "%s/%s", set->folder, model);
    return access(path, R_OK) ? NULL : path;
}

void bench_run_models(const bench_options *set,
                      void (*run)(void *user, const char *path, const char *name), void *user) {
    for (size_t i = 0; i < set->model_count; ++i) {
        char place[1024];
        const char *path = find_model(set, set->models[i], place);
        const char *slash = strrchr(set->models[i], '/');
        if (path)
            run(user, path, slash ? slash + 1 : set->models[i]);
        else
            fprintf(stderr, "benchmark: no %s\n", set->models[i]);
    }
}

double bench_bytes_of(const char *path) {
    struct stat status;
    return stat(path, &status) ? NAN : (double)status.st_size;
}

void bench_write_obj(const psplat_source_mesh *mesh, const char *path) {
    psplat_text text = {0};
    psplat_write_obj(mesh, &text);
    FILE *file = fopen(path, "wb");
    if (text.failed || !file || fwrite(text.data, 1, text.size, file) != text.size || fclose(file))
        give_up(path, "cannot be written");
    free(text.data);
}

int bench_convert(const bench_options *set, const char *model, double tolerance,
                  double normal_tolerance, const char *output) {
    char shape[40], normal[40], line[200] = "";
    const char *arguments[2 * BENCH_MOST] = {
        set->phongsplat, "convert", model, output, "-w", "-q", "-t", shape};
    size_t count = 8;
    snprintf(shape, sizeof shape, "%g%%", tolerance);
    snprintf(normal, sizeof normal, "%g", normal_tolerance);
    if (normal_tolerance > 0) {
        arguments[count++] = "--normal-tolerance";
        arguments[count++] = normal;
    }
    for (size_t i = 0; i < set->passed_count; ++i) arguments[count++] = set->passed[i];
    int code = psplat_subprocess_run(arguments, line, sizeof line);
    if (code == 0 || code == 9) return 1;
    fprintf(stderr, "benchmark: %s -t %s: exit code %d\n", model, shape, code);
    return 0;
}

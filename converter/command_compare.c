/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_compare.c - phongsplat compare: how far an asset, or another mesh, is from a mesh.
 */
#define _XOPEN_SOURCE 700

#include "command.h"
#include "comparison.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <time.h>

typedef struct arguments {
    const char *source;
    const char *target;
    const char *report;
    psplat_shape_desc shape;
    double crease_angle;
    int samples;
    int format;
    int overwrite;
    int quiet;
} arguments;

enum { FORMAT_PRETTY, FORMAT_JSON };

/* What is compared; everything is freed by free_subjects. */
typedef struct subjects {
    psplat_mesh source_mesh, target_mesh;
    psplat_original *source;
    psplat_original *target; /* or */
    psplat_asset *asset;
    psplat_comparison comparison;
} subjects;

static psplat_parse parse_options(const psplat_option *options, size_t count, arguments *a,
                                  int argc, char **argv) {
    const char **const slots[] = {&a->source, &a->target};
    const psplat_syntax syntax = {
        .command = "compare",
        .operands = "SOURCE A.glb",
        .summary =
            "Measures how an asset (.glb or .gltf) differs from the mesh that it stands for:\n"
            "distances both ways, normals after blending, what is not covered and what hangs\n"
            "over. Instead of an asset, A.glb may be another mesh.",
        .notes = "Lengths are in % of the bounding box's diagonal, angles in degrees.",
        .options = options,
        .option_count = count,
        .slots = slots,
        .slot_count = 2,
    };
    return psplat_options_parse(&syntax, argc, argv);
}

static psplat_parse parse(int argc, char **argv, arguments *a) {
    static const char *const formats[] = {"pretty", "json", NULL};
    const psplat_option options[] = {
        {0, "samples", PSPLAT_OPTION_COUNT, &a->samples, "N",
         "points to measure at on either side\n(default 200000)", 100, 1e8, NULL},
        {0, "reach", PSPLAT_OPTION_PERCENT, &a->shape.reach, "PERCENT",
         "how far along its normal a surface point is covered; what\n"
         "hangs over is farther than half of it (default: twice the\n"
         "asset's depth tolerance; of a mesh 1)",
         1e-4, 50, NULL},
        {0, "crease-width", PSPLAT_OPTION_PERCENT, &a->shape.crease_width, "PERCENT",
         "what is near a crease (default: the reach)", 1e-4, 50, NULL},
        {0, "crease-angle", PSPLAT_OPTION_NUMBER, &a->crease_angle, "DEG",
         "angle between two faces from which their edge is a\ncrease (default 30)", 1, 180, NULL},
        {0, "seed", PSPLAT_OPTION_UNSIGNED, &a->shape.seed, "N", "seed of the points (default 0)",
         0, 0, NULL},
        {0, "report", PSPLAT_OPTION_TEXT, &a->report, "R.json",
         "write what was measured as JSON; - is standard output", 0, 0, NULL},
        {0, "format", PSPLAT_OPTION_CHOICE, &a->format, "pretty|json",
         "of standard output (default pretty)", 0, 0, formats},
        {'w', "overwrite", PSPLAT_OPTION_FLAG, &a->overwrite, NULL,
         "replace R.json where it exists", 0, 0, NULL},
        {'q', "quiet", PSPLAT_OPTION_FLAG, &a->quiet, NULL, "print errors only", 0, 0, NULL},
    };
    return parse_options(options, sizeof options / sizeof *options, a, argc, argv);
}

static double seconds_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- reading ----------------------------------------------------------------------------------
 */

static psplat_result read_mesh(const char *path, double crease_angle, psplat_mesh *mesh,
                               psplat_original **original, psplat_error *error) {
    psplat_result result = psplat_mesh_read(path, mesh, error);
    return result ? result : psplat_original_create(mesh, crease_angle, original, error);
}

static int is_gltf(const char *path) {
    const char *dot = strrchr(path, '.');
    return dot && (!strcasecmp(dot, ".glb") || !strcasecmp(dot, ".gltf"));
}

/* An asset, or else a mesh: of glTF where it has no splats. */
static psplat_result read_target(const arguments *a, subjects *s, psplat_error *error) {
    psplat_result result = psplat_command_open(a->target, &s->asset, error);
    int is_mesh =
        result == PSPLAT_ERROR_NO_SPLATS || (result == PSPLAT_ERROR_FORMAT && !is_gltf(a->target));
    if (!is_mesh) return result;
    *error = (psplat_error){0};
    return read_mesh(a->target, a->crease_angle, &s->target_mesh, &s->target, error);
}

/* ---- comparing --------------------------------------------------------------------------------
 */

static psplat_result compare(const arguments *a, subjects *s, psplat_progress *progress,
                             psplat_error *error) {
    psplat_comparison *c = &s->comparison;
    double start = seconds_now();
    psplat_progress_show(progress, "measuring", 0);
    psplat_result result =
        s->target ? psplat_shape_compare_mesh(s->source, s->target, &a->shape, &c->shape, error)
                  : psplat_shape_compare(s->source, s->asset, &a->shape, &c->shape, error);
    c->source = a->source;
    c->target = a->target;
    c->source_triangles = s->source_mesh.triangle_count;
    c->is_mesh = s->target != NULL;
    c->seconds = seconds_now() - start;
    return result;
}

/* *path: what an error concerns; NULL where its text says so. */
static psplat_result work(const arguments *a, subjects *s, const char **path, psplat_error *error) {
    psplat_progress progress = psplat_progress_begin(a->quiet);
    *path = NULL;
    psplat_result result =
        a->report ? psplat_output_check(a->source, a->report, a->overwrite, error) : PSPLAT_OK;
    if (!result && a->report)
        result = psplat_output_check(a->target, a->report, a->overwrite, error);
    if (result) return result;
    *path = a->source;
    psplat_progress_show(&progress, "reading", 0);
    result = read_mesh(a->source, a->crease_angle, &s->source_mesh, &s->source, error);
    if (!result) {
        *path = a->target;
        result = read_target(a, s, error);
    }
    if (!result) result = compare(a, s, &progress, error);
    psplat_progress_end(&progress);
    return result;
}

/* The report, where it is on standard output, is there alone. */
static int prints(const arguments *a) {
    return !a->quiet && !(a->report && !strcmp(a->report, "-"));
}

static psplat_result write_report(const arguments *a, const psplat_comparison *comparison,
                                  psplat_error *error) {
    char *text = NULL;
    size_t size = 0;
    psplat_result result = psplat_comparison_json(comparison, &text, &size, error);
    if (!result && a->report)
        result = psplat_output_write(a->report, text, size, a->overwrite, error);
    if (!result && a->format == FORMAT_JSON && prints(a)) fwrite(text, 1, size, stdout);
    free(text);
    return result;
}

/* ---- the table --------------------------------------------------------------------------------
 */

static void print_spread(const char *name, const psplat_spread *spread, const char *unit) {
    printf("%-28s %9.4g %9.4g %9.4g %s\n", name, spread->max, spread->rms, spread->p95, unit);
}

static void print_table(const psplat_comparison *c) {
    const psplat_shape_errors *e = &c->shape;
    const char *kind = c->is_mesh ? "triangles" : "splats";
    char crease[64];
    printf("%s: %zu %s against %zu triangles of %s\n\n", c->target, e->elements, kind,
           c->source_triangles, c->source);
    printf("%-28s %9s %9s %9s\n", "", "max", "rms", "95 %");
    print_spread("source to target", &e->outward, "% of the diagonal");
    print_spread("target to source", &e->inward, "%");
    print_spread("both", &e->distance, "%");
    print_spread("normals", &e->normal, "degrees");
    print_spread("  on faces", &e->face_normal, "degrees");
    snprintf(crease, sizeof crease, "  within %.3g %% of creases", e->crease_width);
    print_spread(crease, &e->crease_normal, "degrees");
    printf("\nnot covered within %.3g %%: %.4g %% of the source's area\n", e->reach,
           e->uncovered_area);
    printf("hanging over by more than %.3g %%: %.4g %% of the area of %s\n", e->reach / 2,
           e->overhang_area, kind);
    printf("%.4g %% of the source's area is near creases\n", e->crease_area);
    printf("diagonal %.6g, %zu and %zu points, %.2f s\n", e->diagonal, e->source_samples,
           e->target_samples, c->seconds);
}

static void free_subjects(subjects *s) {
    psplat_original_destroy(s->source);
    psplat_original_destroy(s->target);
    psplat_asset_destroy(s->asset);
    psplat_mesh_free(&s->source_mesh);
    psplat_mesh_free(&s->target_mesh);
}

static int run(const arguments *a, subjects *s) {
    const char *path;
    psplat_error error = {0};
    psplat_result result = work(a, s, &path, &error);
    if (result) return psplat_command_fail(path, &error);
    result = write_report(a, &s->comparison, &error);
    if (result) return psplat_command_fail(NULL, &error);
    if (prints(a) && a->format == FORMAT_PRETTY) print_table(&s->comparison);
    return PSPLAT_EXIT_SUCCESS;
}

int psplat_command_compare(int argc, char **argv) {
    arguments a = {0};
    psplat_parse parsed = parse(argc, argv, &a);
    if (parsed != PSPLAT_PARSE_OK)
        return parsed == PSPLAT_PARSE_HELP ? PSPLAT_EXIT_SUCCESS : PSPLAT_EXIT_USAGE;
    a.shape.samples = (size_t)a.samples;
    subjects s = {0};
    int code = run(&a, &s);
    free_subjects(&s);
    return code;
}

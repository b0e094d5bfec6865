/* SPDX-License-Identifier: MIT
 *
 * bench_gltfpack.c - compares bytes at equal error: the files of `phongsplat convert` with those
 * that gltfpack (meshoptimizer's simplifier and compressor) needs to be as near to the same mesh.
 *
 *     npm install --prefix DIRECTORY gltfpack@1.3.0
 *     bench_gltfpack --gltfpack DIRECTORY/node_modules/.bin/gltfpack [options] [MODEL...]
 *
 *     --gltfpack PROGRAM         without it, the one in PATH
 *     --phongsplat PROGRAM       without it, the one of this build
 *     --tolerances LIST          in percent, separated by commas; 2,1,0.5,0.2,0.1
 *     --normal-tolerances LIST   in degrees; 0 stands for none; 0,15,10,5
 *     --ratios LIST              of triangles that gltfpack keeps; 1 to 0.002 by default
 *     --pass ARGUMENT            a further argument of phongsplat convert; may be repeated
 *     --folder DIRECTORY         with other models; without it, PSPLAT_BENCH_MODELS, or else the
 *                                folder shared/models beside the repository
 *     --csv FILE                 all measurements
 *
 * A model is the name of a file in the folder, or a path. Those that are not there are left out.
 * gltfpack gets -cc -sv -se 1 -si RATIO and reads the model itself where it can and the model has
 * normals; otherwise it reads the same triangles with the normals that the converter sees. The
 * files of both are opened and measured by the code of `phongsplat compare`: greatest two-sided
 * distance, and RMS error of the normals, which are blended where splats overlap.
 *
 * For each conversion the table tells how many bytes gltfpack needs for a greatest distance as
 * small, and for normals as good. Each is interpolated between the best of its files on logarithmic
 * axes; the greater of the two is what it needs for both. "<" means that even its smallest file is
 * as good, ">" that even its largest (all triangles) is not.
 */
#include "compare/shape_errors.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "benchmark/gltfpack.h"
#include "benchmark/subprocess.h"
#include "table/text.h"
#include "benchmark/write_obj.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MOST = 32, ARGUMENTS = 2 * MOST };
enum { SOURCE, PACKED, SPLATS, FILES };

typedef struct list {
    double values[MOST];
    size_t count;
} list;

typedef struct options {
    const char *gltfpack, *phongsplat, *folder, *csv;
    const char *passed[MOST], *models[MOST];
    size_t passed_count, model_count;
    list tolerances, normal_tolerances, ratios;
} options;

/* A measured file. Lengths are in percent of the diagonal, angles in degrees. */
typedef struct point {
    double setting, normal_setting; /* tolerances; of a mesh, the ratio and 0 */
    double elements, bytes, distance, normal;
} point;

typedef struct bench {
    options set;
    psplat_gltfpack gltfpack;
    char directory[64], files[FILES][96];
    FILE *csv;
    const char *path, *name;
    psplat_mesh mesh;
    psplat_source_mesh *original;
    point meshes[MOST]; /* files of gltfpack */
    size_t mesh_count;
} bench;

static void check(psplat_result result, const psplat_error *error) {
    if (result == PSPLAT_OK) return;
    fprintf(stderr, "bench_gltfpack: %s\n", error->text);
    exit(1);
}

static void name_files(bench *b) {
    static const char *const names[FILES] = {"source.obj", "packed.glb", "splats.glb"};
    for (size_t i = 0; i < FILES; ++i)
        snprintf(b->files[i], sizeof b->files[i], "%s/%s", b->directory, names[i]);
}

static void remove_files(const bench *b) {
    for (size_t i = 0; i < FILES; ++i) unlink(b->files[i]);
    rmdir(b->directory);
}

static double bytes_of(const char *path) {
    struct stat status;
    return stat(path, &status) ? NAN : (double)status.st_size;
}

/* ---- what was made --------------------------------------------------------------------------- */

static void measure(const psplat_shape_errors *errors, point *p) {
    p->elements = (double)errors->elements;
    p->distance = errors->distance.max;
    p->normal = errors->normal.rms;
}

static void measure_splats(const bench *b, const char *path, point *p) {
    const psplat_shape_desc desc = {0};
    psplat_shape_errors errors;
    psplat_asset *asset = NULL;
    psplat_error error;
    check(psplat_asset_open(path, NULL, &asset, &error), &error);
    check(psplat_shape_compare(b->original, asset, &desc, &errors, &error), &error);
    psplat_asset_destroy(asset);
    measure(&errors, p);
}

/* Returns 0 where nothing is left of the mesh. */
static int measure_mesh(const bench *b, const char *path, point *p) {
    const psplat_shape_desc desc = {0};
    psplat_shape_errors errors;
    psplat_mesh mesh = {0};
    psplat_source_mesh *original = NULL;
    psplat_error error;
    if (psplat_mesh_read(path, &mesh, &error)) return 0;
    check(psplat_source_mesh_create(&mesh, 0, &original, &error), &error);
    check(psplat_shape_compare_mesh(b->original, original, &desc, &errors, &error), &error);
    psplat_source_mesh_destroy(original);
    psplat_mesh_free(&mesh);
    measure(&errors, p);
    return 1;
}

static void record(const bench *b, const char *kind, const point *p) {
    if (!b->csv) return;
    fprintf(b->csv, "%s,%s,%g,%g,%.0f,%.0f,%.6g,%.6g\n", b->name, kind, p->setting,
            p->normal_setting, p->elements, p->bytes, p->distance, p->normal);
    fflush(b->csv);
}

/* ---- gltfpack -------------------------------------------------------------------------------- */

/* Returns the file that gltfpack reads. */
static const char *input_of(const bench *b) {
    if (psplat_gltfpack_reads(b->path) && b->mesh.corner_normals) return b->path;
    psplat_text text = {0};
    const char *path = b->files[SOURCE];
    psplat_write_obj(b->original, &text);
    FILE *file = fopen(path, "wb");
    if (text.failed || !file || fwrite(text.data, 1, text.size, file) != text.size ||
        fclose(file)) {
        fprintf(stderr, "bench_gltfpack: cannot write %s\n", path);
        exit(1);
    }
    free(text.data);
    return path;
}

static void simplify(bench *b) {
    const char *input = input_of(b);
    b->mesh_count = 0;
    for (size_t i = 0; i < b->set.ratios.count; ++i) {
        const char *packed = b->files[PACKED];
        point p = {.setting = b->set.ratios.values[i]};
        psplat_error error;
        check(psplat_gltfpack_run(&b->gltfpack, input, p.setting, 0, packed, &error), &error);
        p.bytes = bytes_of(packed);
        if (!measure_mesh(b, packed, &p)) continue;
        record(b, "gltfpack", &p);
        b->meshes[b->mesh_count++] = p;
        printf("| %s | %g | %.0f | %.0f | %.4g | %.3g |\n", b->name, p.setting, p.elements, p.bytes,
               p.distance, p.normal);
        fflush(stdout);
    }
}

static int compare_bytes(const void *left, const void *right) {
    const point *a = left, *b = right;
    return a->bytes < b->bytes ? -1 : a->bytes > b->bytes;
}

/* Returns the bytes that gltfpack needs for an error. meshes are in order of bytes. *end is '<' or
 * '>' where the error lies outside the range of its files. */
static double bytes_for(const point *meshes, size_t count, size_t offset, double error, char *end) {
    double bytes = meshes[0].bytes, best = INFINITY;
    *end = ' ';
    for (size_t i = 0; i < count; ++i) {
        double found = *(const double *)(const void *)((const char *)&meshes[i] + offset);
        if (found >= best) continue; /* it is larger and no better */
        if (found <= error) {
            if (i == 0) *end = '<';
            if (i == 0 || found <= 0 || error <= 0) return meshes[i].bytes;
            double t = log(best / error) / log(best / found);
            return exp(log(bytes) + t * log(meshes[i].bytes / bytes));
        }
        best = found;
        bytes = meshes[i].bytes;
    }
    *end = '>';
    return bytes;
}

/* ---- splats ---------------------------------------------------------------------------------- */

/* Returns whether a file was written. Exit code 9, a promise that is broken in places, is accepted,
 * because the table shows it. */
static int convert(const bench *b, const point *p, const char *output) {
    char tolerance[40], normal[40], line[200] = "";
    const char *arguments[ARGUMENTS] = {b->set.phongsplat, "convert", b->path, output, "-w", "-q"};
    size_t count = 6;
    snprintf(tolerance, sizeof tolerance, "%g%%", p->setting);
    snprintf(normal, sizeof normal, "%g", p->normal_setting);
    arguments[count++] = "-t";
    arguments[count++] = tolerance;
    if (p->normal_setting > 0) {
        arguments[count++] = "--normal-tolerance";
        arguments[count++] = normal;
    }
    for (size_t i = 0; i < b->set.passed_count; ++i) arguments[count++] = b->set.passed[i];
    int code = psplat_subprocess_run(arguments, line, sizeof line);
    if (code == 0 || code == 9) return 1;
    fprintf(stderr, "bench_gltfpack: %s -t %s: exit code %d\n", b->name, tolerance, code);
    return 0;
}

static void print_splats(const bench *b, const point *p) {
    char by_distance = ' ', by_normal = ' ';
    printf("| %s | %g | ", b->name, p->setting);
    if (p->normal_setting > 0) printf("%g", p->normal_setting);
    printf(" | %.0f | %.0f | %.1f | %.4g | %.3g |", p->elements, p->bytes, p->bytes / p->elements,
           p->distance, p->normal);
    if (b->mesh_count) {
        double distance = bytes_for(b->meshes, b->mesh_count, offsetof(point, distance),
                                    p->distance, &by_distance);
        double normal =
            bytes_for(b->meshes, b->mesh_count, offsetof(point, normal), p->normal, &by_normal);
        printf(" %c %.0f | %c %.0f | %.2f |", by_distance, distance, by_normal, normal,
               p->bytes / fmax(distance, normal));
    }
    printf("\n");
    fflush(stdout);
}

static void convert_all(bench *b) {
    const list *tolerances = &b->set.tolerances, *normals = &b->set.normal_tolerances;
    for (size_t i = 0; i < tolerances->count; ++i)
        for (size_t k = 0; k < normals->count; ++k) {
            const char *output = b->files[SPLATS];
            point p = {.setting = tolerances->values[i], .normal_setting = normals->values[k]};
            if (!convert(b, &p, output)) continue;
            p.bytes = bytes_of(output);
            measure_splats(b, output, &p);
            record(b, "splats", &p);
            print_splats(b, &p);
        }
}

/* ---- models ---------------------------------------------------------------------------------- */

static void run_model(bench *b) {
    psplat_error error;
    check(psplat_mesh_read(b->path, &b->mesh, &error), &error);
    check(psplat_source_mesh_create(&b->mesh, 0, &b->original, &error), &error);
    b->mesh_count = 0;
    if (*b->gltfpack.version) {
        printf("| gltfpack | ratio | triangles | bytes | distance %% | normals, degrees |\n"
               "|---|--:|--:|--:|--:|--:|\n");
        simplify(b);
        qsort(b->meshes, b->mesh_count, sizeof *b->meshes, compare_bytes);
        printf("\n");
    }
    printf("| phongsplat | tolerance %% | of normals | splats | bytes | a splat | distance %% | "
           "normals, degrees |%s\n|---|--:|--:|--:|--:|--:|--:|--:|%s\n",
           b->mesh_count ? " gltfpack's bytes for the distance | for the normals | ratio |" : "",
           b->mesh_count ? "--:|--:|--:|" : "");
    convert_all(b);
    printf("\n");
    psplat_source_mesh_destroy(b->original);
    psplat_mesh_free(&b->mesh);
}

/* Returns the path of a model, or NULL where it is not there. */
static const char *find_model(const options *set, const char *model) {
    static char path[1024];
    if (!access(model, R_OK)) return model;
    snprintf(path, sizeof path, "%s/%s", set->folder, model);
    return access(path, R_OK) ? NULL : path;
}

static void run_models(bench *b) {
    for (size_t i = 0; i < b->set.model_count; ++i) {
        b->path = find_model(&b->set, b->set.models[i]);
        const char *slash = strrchr(b->set.models[i], '/');
        b->name = slash ? slash + 1 : b->set.models[i];
        if (b->path)
            run_model(b);
        else
            fprintf(stderr, "bench_gltfpack: no %s\n", b->set.models[i]);
    }
}

/* ---- options --------------------------------------------------------------------------------- */

static list parse_list(const char *text) {
    list l = {.count = 0};
    while (*text && l.count < MOST) {
        char *end = NULL;
        l.values[l.count++] = strtod(text, &end);
        if (end == text || (*end && *end != ',')) {
            fprintf(stderr, "bench_gltfpack: %s is no list of numbers\n", text);
            exit(1);
        }
        text = *end ? end + 1 : end;
    }
    return l;
}

/* Takes an option and its value. Returns 0 where name is no option. */
static int take(options *set, const char *name, const char *value) {
    if (strncmp(name, "--", 2) != 0) return 0;
    if (!value) {
        fprintf(stderr, "bench_gltfpack: %s needs a value\n", name);
        exit(1);
    }
    if (!strcmp(name, "--gltfpack")) set->gltfpack = value;
    if (!strcmp(name, "--phongsplat")) set->phongsplat = value;
    if (!strcmp(name, "--folder")) set->folder = value;
    if (!strcmp(name, "--csv")) set->csv = value;
    if (!strcmp(name, "--tolerances")) set->tolerances = parse_list(value);
    if (!strcmp(name, "--normal-tolerances")) set->normal_tolerances = parse_list(value);
    if (!strcmp(name, "--ratios")) set->ratios = parse_list(value);
    if (!strcmp(name, "--pass") && set->passed_count < MOST)
        set->passed[set->passed_count++] = value;
    return 1;
}

static options parse(int argc, char **argv) {
    static const char *const defaults[] = {"fandisk.obj", "stanford-bunny.obj",
                                           PSPLAT_SOURCE_DIR "/samples/models/part.obj",
                                           PSPLAT_SOURCE_DIR "/samples/models/torus.off"};
    const char *folder = getenv("PSPLAT_BENCH_MODELS");
    options set = {.phongsplat = PSPLAT_PROGRAM,
                   .folder = folder ? folder : PSPLAT_SOURCE_DIR "/../shared/models",
                   .tolerances = parse_list("2,1,0.5,0.2,0.1"),
                   .normal_tolerances = parse_list("0,15,10,5"),
                   .ratios = parse_list("1,0.7,0.5,0.35,0.25,0.18,0.12,0.08,0.055,0.04,0.028,0.02,"
                                        "0.014,0.01,0.007,0.005,0.0035,0.002")};
    for (int i = 1; i < argc; ++i)
        if (take(&set, argv[i], argv[i + 1]))
            ++i;
        else if (set.model_count < MOST)
            set.models[set.model_count++] = argv[i];
    if (!set.model_count) {
        set.model_count = sizeof defaults / sizeof *defaults;
        memcpy(set.models, defaults, sizeof defaults);
    }
    return set;
}

int main(int argc, char **argv) {
    bench b = {.set = parse(argc, argv), .directory = "/tmp/bench_gltfpack.XXXXXX"};
    b.gltfpack = psplat_gltfpack_find(b.set.gltfpack);
    if (!*b.gltfpack.version)
        fprintf(stderr, "bench_gltfpack: gltfpack cannot be run; splats only\n");
    if (b.set.csv && !(b.csv = fopen(b.set.csv, "w"))) {
        fprintf(stderr, "bench_gltfpack: cannot write %s\n", b.set.csv);
        return 1;
    }
    if (b.csv)
        fprintf(b.csv, "model,kind,tolerance_or_ratio,normal_tolerance,elements,bytes,"
                       "distance_percent,normal_degrees\n");
    if (!mkdtemp(b.directory)) return 1;
    name_files(&b);
    printf("%s\n\n", b.gltfpack.version);
    run_models(&b);
    remove_files(&b);
    if (b.csv) fclose(b.csv);
    return 0;
}

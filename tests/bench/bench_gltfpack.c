/* SPDX-License-Identifier: MIT
 *
 * bench_gltfpack.c - compares bytes at equal error: the files of `phongsplat convert` with those
 * that a user would take instead, meshes simplified by gltfpack (meshoptimizer) and compressed.
 *
 *     npm install --prefix DIRECTORY gltfpack@1.3.0
 *     bench_gltfpack --gltfpack DIRECTORY/node_modules/.bin/gltfpack [options] [MODEL...]
 *
 *     --gltfpack PROGRAM         without it, the one in PATH
 *     --phongsplat PROGRAM       without it, the one of this build
 *     --tolerances LIST          in percent, separated by commas; 2,1,0.5,0.2,0.1
 *     --normal-tolerances LIST   in degrees; 0 stands for none; 0
 *     --ratios LIST              of triangles that gltfpack keeps; 1 to 0.002 by default
 *     --size PIXELS              of pictures; 512
 *     --pass ARGUMENT            a further argument of phongsplat convert; may be repeated
 *     --folder DIRECTORY         with other models; without it, PSPLAT_BENCH_MODELS, or else the
 *                                folder shared/models beside the repository
 *     --csv FILE                 all measurements
 *
 * A model is the name of a file in the folder, or a path. Those that are not there are left out.
 * gltfpack gets -sv -se 1 -si RATIO and reads the model itself where it can and the model has
 * normals; otherwise it reads the same triangles with the normals that the converter sees. Each
 * ratio gives a file of every rival:
 *
 *     -cc            gltfpack's default precision, 14 bits for positions and 8 for normals
 *     -cz -vp 12     its strongest compression, 12 bits for positions; the errors are those of -cc
 *                    -vp 12, which stores the same numbers in a way that we can read
 *     Draco          the same triangles in Draco's own format, 12 bits for positions and 8 for
 *                    normals, where draco_encoder and draco_decoder are installed (Debian's package
 *                    draco); a .glb would take about 1 kB more than is counted
 *
 * All files are opened and measured by the code of `phongsplat compare`: greatest and RMS two-sided
 * distance, RMS and 95th percentile of the angles between normals, which are blended where splats
 * overlap, and in 12 pictures the mean difference where either shows something and the pixels
 * that are missing or too much.
 *
 * Under each conversion the table has its bytes divided by those of each rival at an equal error,
 * interpolated between the rival's best files on logarithmic axes. ">" means that even the rival's
 * smallest file is as good, so that the ratio is greater; "<" that even its largest (all triangles)
 * is not. Seconds are CPU seconds of the programs that were run.
 *
 * Textured models are those of bench_textures.mjs.
 */
#include "beside_gltfpack.h"

#include "benchmark/gltfpack.h"
#include "benchmark/measured_asset.h"
#include "benchmark/subprocess.h"
#include "benchmark/sweep_context.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "table/row.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <phongsplat/phongsplat.h>

enum { SOURCE, PACKED, PLAIN, OBJ, DRACO, SPLATS, FILES };
enum { PACKED_CC, PACKED_CZ, PACKED_DRACO, RIVALS };
enum { DISTANCE_MAX, DISTANCE_RMS, NORMAL_RMS, NORMAL_P95, PICTURE, OUTLINE, ERRORS };

static const char *const rival_names[RIVALS] = {"-cc", "-cz -vp 12", "Draco"};
static const char *const error_names[ERRORS] = {
    "distance, greatest %", "RMS %",     "normals, RMS degrees",
    "95th percentile",      "picture %", "outline %"};

/* A measured file. Distances are in percent of the diagonal, angles in degrees, the difference of
 * pictures in percent of white, the outline in percent of the pixels that the source covers. */
typedef struct point {
    double setting, normal_setting; /* tolerances; of a mesh, the ratio and 0 */
    double elements, bytes, seconds, errors[ERRORS];
} point;

/* The files of one rival. */
typedef struct ladder {
    point files[BENCH_MOST];
    size_t count;
} ladder;

typedef struct bench {
    bench_options set;
    psplat_gltfpack gltfpack;
    char directory[64], files[FILES][96];
    FILE *csv;
    const char *path, *name;
    psplat_sweep_context context;
    ladder rivals[RIVALS];
} bench;

static void name_files(bench *b) {
    static const char *const names[FILES] = {"source.obj", "packed.glb", "plain.glb",
                                             "plain.obj",  "mesh.drc",   "splats.glb"};
    for (size_t i = 0; i < FILES; ++i)
        snprintf(b->files[i], sizeof b->files[i], "%s/%s", b->directory, names[i]);
}

static void remove_files(const bench *b) {
    for (size_t i = 0; i < FILES; ++i) unlink(b->files[i]);
    rmdir(b->directory);
}

/* Returns the CPU seconds of all programs that were run so far. */
static double seconds_of_programs(void) {
    struct rusage usage;
    getrusage(RUSAGE_CHILDREN, &usage);
    return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

/* ---- what was made --------------------------------------------------------------------------- */

static void take_errors(const psplat_row *row, point *p) {
    const double *values = row->values;
    p->errors[DISTANCE_MAX] = values[PSPLAT_COLUMN_DISTANCE_MAX];
    p->errors[DISTANCE_RMS] = values[PSPLAT_COLUMN_DISTANCE_RMS];
    p->errors[NORMAL_RMS] = values[PSPLAT_COLUMN_NORMAL_RMS];
    p->errors[NORMAL_P95] = values[PSPLAT_COLUMN_NORMAL_P95];
    p->errors[PICTURE] = values[PSPLAT_COLUMN_DIFFERENCE];
    p->errors[OUTLINE] = values[PSPLAT_COLUMN_MISSING] + values[PSPLAT_COLUMN_EXTRA];
}

/* Returns 0 where nothing is left of a mesh. */
static int measure(bench *b, const char *path, psplat_competitor competitor, point *p) {
    const psplat_setting setting = {.competitor = competitor};
    psplat_measured_asset opened = {.asset = NULL};
    psplat_row row = psplat_row_empty(&setting);
    psplat_error error;
    if (psplat_measured_asset_open(&opened, &b->context, &setting, path, &error)) {
        if (competitor == PSPLAT_COMPETITOR_SPLATS) bench_check(PSPLAT_ERROR_READ, &error);
        psplat_measured_asset_close(&opened);
        return 0;
    }
    bench_check(psplat_measured_asset_shape(&opened, &b->context, 0, &row, &error), &error);
    bench_check(psplat_measured_asset_picture(&opened, &b->context, &row, &error), &error);
    p->elements = opened.model ? (double)psplat_model_describe(opened.model).splat_count
                               : (double)opened.mesh.triangle_count;
    take_errors(&row, p);
    psplat_measured_asset_close(&opened);
    return 1;
}

static void record(const bench *b, const char *kind, const point *p) {
    if (!b->csv) return;
    fprintf(b->csv, "%s,%s,%g,%g,%.0f,%.0f,%.3f", b->name, kind, p->setting, p->normal_setting,
            p->elements, p->bytes, p->seconds);
    for (int i = 0; i < ERRORS; ++i) fprintf(b->csv, ",%.6g", p->errors[i]);
    fprintf(b->csv, "\n");
    fflush(b->csv);
}

static void print_errors(const point *p) {
    printf(" %.0f | %.0f | %.2f |", p->elements, p->bytes, p->seconds);
    for (int i = 0; i < ERRORS; ++i) printf(" %.3g |", p->errors[i]);
    printf("\n");
    fflush(stdout);
}

static void print_head(const char *kind, const char *setting, const char *element) {
    printf("| %s | %s | %s | bytes | CPU s |", kind, setting, element);
    for (int i = 0; i < ERRORS; ++i) printf(" %s |", error_names[i]);
    printf("\n|---|--:|--:|--:|--:|");
    for (int i = 0; i < ERRORS; ++i) printf("--:|");
    printf("\n");
}

/* ---- rivals ---------------------------------------------------------------------------------- */

/* Returns the file that gltfpack reads. */
static const char *input_of(bench *b) {
    psplat_error error;
    if (psplat_gltfpack_reads(b->path) && b->context.mesh.corner_normals) return b->path;
    bench_check(psplat_sweep_context_source_mesh(&b->context, &error), &error);
    bench_write_obj(b->context.source_mesh, b->files[SOURCE]);
    return b->files[SOURCE];
}

/* Returns the bytes of what gltfpack writes with these options. */
static double pack(const bench *b, const char *input, double ratio, const char *const *options,
                   const char *output) {
    psplat_error error;
    bench_check(psplat_gltfpack_run(&b->gltfpack, input, ratio, options, output, &error), &error);
    return bench_bytes_of(output);
}

/* Encodes the triangles of a file and decodes them again into OBJ. Returns the bytes, or NAN where
 * Draco is not installed or takes no mesh that is empty. */
static double encode_draco(const bench *b) {
    const char *const encode[] = {"draco_encoder", "-i", b->files[OBJ], "-o", b->files[DRACO],
                                  "-qp",           "12", "-qn",         "8",  NULL};
    const char *const decode[] = {"draco_decoder", "-i", b->files[DRACO], "-o",
                                  b->files[OBJ],   NULL};
    psplat_mesh mesh = {0};
    psplat_source_mesh *source_mesh = NULL;
    psplat_error error;
    if (psplat_mesh_read(b->files[PLAIN], &mesh, &error)) return NAN;
    bench_check(psplat_source_mesh_create(&mesh, b->context.crease_angle, &source_mesh, &error),
                &error);
    bench_write_obj(source_mesh, b->files[OBJ]);
    psplat_source_mesh_destroy(source_mesh);
    psplat_mesh_free(&mesh);
    if (psplat_subprocess_run(encode, NULL, 0)) return NAN;
    double bytes = bench_bytes_of(b->files[DRACO]);
    return psplat_subprocess_run(decode, NULL, 0) ? NAN : bytes;
}

/* Makes the file of a rival. *measured is the one to be read. */
static double make(const bench *b, int rival, const char *input, double ratio,
                   const char **measured) {
    static const char *const cc[] = {"-cc", NULL}, *const cz[] = {"-cz", "-vp", "12", NULL};
    static const char *const readable[] = {"-cc", "-vp", "12", NULL};
    static const char *const plain[] = {"-noq", NULL};
    *measured = b->files[rival == PACKED_DRACO ? OBJ : PACKED];
    if (rival == PACKED_CC) return pack(b, input, ratio, cc, b->files[PACKED]);
    if (rival == PACKED_DRACO) {
        pack(b, input, ratio, plain, b->files[PLAIN]);
        return encode_draco(b);
    }
    double bytes = pack(b, input, ratio, cz, b->files[PLAIN]);
    pack(b, input, ratio, readable, b->files[PACKED]);
    return bytes;
}

static void climb(bench *b, int rival, const char *input) {
    ladder *l = &b->rivals[rival];
    l->count = 0;
    for (size_t i = 0; i < b->set.ratios.count; ++i) {
        point p = {.setting = b->set.ratios.values[i]};
        const char *measured = NULL;
        double before = seconds_of_programs();
        p.bytes = make(b, rival, input, p.setting, &measured);
        p.seconds = seconds_of_programs() - before;
        if (isnan(p.bytes) || !measure(b, measured, PSPLAT_COMPETITOR_GLTFPACK, &p)) continue;
        record(b, rival_names[rival], &p);
        l->files[l->count++] = p;
        printf("| %s, %s | %g |", b->name, rival_names[rival], p.setting);
        print_errors(&p);
    }
}

static int compare_bytes(const void *left, const void *right) {
    const point *a = left, *b = right;
    return a->bytes < b->bytes ? -1 : a->bytes > b->bytes;
}

/* Returns the bytes that a rival needs for an error. Its files are in order of bytes. *end is '<'
 * or
 * '>' where the error lies outside the range of its files. */
static double bytes_for(const ladder *rival, int kind, double error, char *end) {
    const point *meshes = rival->files;
    double bytes = meshes[0].bytes, best = INFINITY;
    *end = ' ';
    for (size_t i = 0; i < rival->count; ++i) {
        double found = meshes[i].errors[kind];
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

static void print_ratios(const bench *b, const point *p) {
    for (int rival = 0; rival < RIVALS; ++rival) {
        const ladder *l = &b->rivals[rival];
        if (!l->count) continue;
        printf("| ÷ %s | | | | |", rival_names[rival]);
        for (int kind = 0; kind < ERRORS; ++kind) {
            char end = ' ';
            double ratio = p->bytes / bytes_for(l, kind, p->errors[kind], &end);
            printf(" %s%.2f |", end == '<' ? "> " : end == '>' ? "< " : "", ratio);
        }
        printf("\n");
    }
    fflush(stdout);
}

static void convert_all(bench *b) {
    const bench_list *tolerances = &b->set.tolerances, *normals = &b->set.normal_tolerances;
    for (size_t i = 0; i < tolerances->count; ++i)
        for (size_t k = 0; k < normals->count; ++k) {
            const char *output = b->files[SPLATS];
            point p = {.setting = tolerances->values[i], .normal_setting = normals->values[k]};
            double before = seconds_of_programs();
            if (!bench_convert(&b->set, b->path, p.setting, p.normal_setting, output)) continue;
            p.seconds = seconds_of_programs() - before;
            p.bytes = bench_bytes_of(output);
            measure(b, output, PSPLAT_COMPETITOR_SPLATS, &p);
            record(b, "splats", &p);
            printf("| %s | %g", b->name, p.setting);
            if (p.normal_setting > 0) printf(", %g degrees", p.normal_setting);
            printf(" |");
            print_errors(&p);
            print_ratios(b, &p);
        }
}

/* ---- models ---------------------------------------------------------------------------------- */

static void climb_all(bench *b) {
    const char *input = input_of(b);
    print_head("mesh", "ratio", "triangles");
    for (int rival = 0; rival < RIVALS; ++rival) {
        ladder *l = &b->rivals[rival];
        climb(b, rival, input);
        qsort(l->files, l->count, sizeof *l->files, compare_bytes);
    }
    printf("\n");
}

static void run_model(void *user, const char *path, const char *name) {
    bench *b = user;
    psplat_error error;
    b->name = name;
    b->path = path;
    b->context =
        (psplat_sweep_context){.path = path, .size = (int)b->set.sizes.values[0], .software = 1};
    bench_check(psplat_sweep_context_open(&b->context, &error), &error);
    if (*b->gltfpack.version) climb_all(b);
    print_head("phongsplat", "tolerance %", "splats");
    convert_all(b);
    printf("\n");
    psplat_sweep_context_close(&b->context);
}

/* ---- options --------------------------------------------------------------------------------- */

static bench_options parse(int argc, char **argv) {
    static const char *const models[] = {"fandisk.obj", "stanford-bunny.obj",
                                         PSPLAT_SOURCE_DIR "/samples/models/part.obj",
                                         PSPLAT_SOURCE_DIR "/samples/models/torus.off", NULL};
    bench_options set = {
        .tolerances = bench_parse_list("2,1,0.5,0.2,0.1"),
        .normal_tolerances = bench_parse_list("0"),
        .ratios = bench_parse_list("1,0.7,0.5,0.35,0.25,0.18,0.12,0.08,0.055,0.04,0.028,0.02,"
                                   "0.014,0.01,0.007,0.005,0.0035,0.002"),
        .sizes = bench_parse_list("512"),
    };
    bench_parse(&set, models, argc, argv);
    return set;
}

int main(int argc, char **argv) {
    bench b = {.set = parse(argc, argv), .directory = "/tmp/bench_gltfpack.XXXXXX"};
    b.gltfpack = psplat_gltfpack_find(b.set.gltfpack);
    if (!*b.gltfpack.version)
        fprintf(stderr, "bench_gltfpack: gltfpack cannot be run; splats only\n");
    b.csv = bench_open_csv(&b.set);
    if (b.csv)
        fprintf(b.csv, "model,kind,tolerance_or_ratio,normal_tolerance,elements,bytes,cpu_seconds,"
                       "distance_max_percent,distance_rms_percent,normal_rms_degrees,"
                       "normal_p95_degrees,picture_percent,outline_percent\n");
    if (!mkdtemp(b.directory)) return 1;
    name_files(&b);
    printf("%s\n\n", b.gltfpack.version);
    bench_run_models(&b.set, run_model, &b);
    remove_files(&b);
    if (b.csv) fclose(b.csv);
    return 0;
}

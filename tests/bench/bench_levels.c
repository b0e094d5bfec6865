/* SPDX-License-Identifier: MIT
 *
 * bench_levels.c - how levels of detail look from afar: pictures of splats and of meshes simplified
 * by gltfpack, at equal bytes, seen some 100 pixels across.
 *
 *     npm install --prefix DIRECTORY gltfpack@1.3.0
 *     bench_levels --gltfpack DIRECTORY/node_modules/.bin/gltfpack [options] [MODEL...]
 *
 *     --gltfpack PROGRAM         without it, the one in PATH
 *     --phongsplat PROGRAM       without it, the one of this build
 *     --tolerances LIST          in percent, separated by commas; 8,4,2,1,0.5,0.25
 *     --normal-tolerances LIST   in degrees; 0 stands for none; 0
 *     --ratios LIST              of triangles that gltfpack keeps; 0.5 to 0.001 by default
 *     --sizes LIST               of pictures, pixels, at most 4 of them; 100,200,400
 *     --pass ARGUMENT            a further argument of phongsplat convert; may be repeated
 *     --folder DIRECTORY         with other models; without it, PSPLAT_BENCH_MODELS, or else the
 *                                folder shared/models beside the repository
 *     --csv FILE                 all measurements
 *
 * Both are files as a user would have them: convert's, and those of gltfpack -cc -sv -se 1 -si
 * RATIO. Bytes are without those of images, which levels share. A mesh that gltfpack gets with its
 * images and without normals has those that our reader makes. Pictures are those of `phongsplat
 * compare`: 12 views, in each of which the source's bounding sphere fills the picture, against the
 * source at the same size, one sample a pixel. The outline is the pixels that are missing or too
 * much, in percent of those that the source covers.
 *
 * After each size follow the SSIM and the PSNR of a mesh of equal bytes, interpolated between
 * gltfpack's files on an axis of logarithms of bytes; "-" where all of them are larger or smaller.
 */
#include "beside_gltfpack.h"

#include "benchmark/gltfpack.h"
#include "benchmark/measured_asset.h"
#include "benchmark/sweep_context.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "table/row.h"
#include "views/picture_views.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <phongsplat/phongsplat.h>

enum { MOST_SIZES = 4 };
enum { SOURCE, PACKED, SPLATS, FILES };

/* A measured file, and its pictures of each size. */
typedef struct point {
    double setting, normal_setting; /* tolerances; of a mesh, the ratio and 0 */
    double elements, bytes;
    double distance_max, distance_rms, normal_rms; /* percent of the diagonal; degrees */
    psplat_picture_errors pictures[MOST_SIZES];
} point;

typedef struct bench {
    bench_options set;
    psplat_gltfpack gltfpack;
    char directory[64], files[FILES][96];
    FILE *csv;
    const char *path, *name;
    psplat_sweep_context context;
    psplat_picture_views *views[MOST_SIZES];
    double image_bytes;       /* of those that splats use */
    point meshes[BENCH_MOST]; /* in order of bytes */
    size_t mesh_count;
} bench;

/* ---- measuring ------------------------------------------------------------------------------- */

static double image_bytes_of(const psplat_asset *asset) {
    double bytes = 0;
    for (size_t i = 0; i < psplat_asset_image_count(asset); ++i)
        bytes += (double)psplat_asset_get_image(asset, i)->size;
    return bytes;
}

static void take_shape(const psplat_row *row, point *p) {
    p->distance_max = row->values[PSPLAT_COLUMN_DISTANCE_MAX];
    p->distance_rms = row->values[PSPLAT_COLUMN_DISTANCE_RMS];
    p->normal_rms = row->values[PSPLAT_COLUMN_NORMAL_RMS];
}

static void measure_pictures(bench *b, const psplat_measured_asset *opened, point *p) {
    const psplat_pictured pictured = {
        .renderer = opened->renderer, .model = opened->model, .mesh = opened->source_mesh};
    psplat_error error;
    for (size_t i = 0; i < b->set.sizes.count; ++i)
        bench_check(
            psplat_picture_views_compare(b->views[i], &pictured, -1, &p->pictures[i], &error),
            &error);
}

/* Returns 0 where nothing is left of a mesh. */
static int measure(bench *b, const char *path, psplat_competitor competitor, point *p) {
    enum { SAMPLES = 20000 };
    const psplat_setting setting = {.competitor = competitor};
    psplat_measured_asset opened = {.asset = NULL};
    psplat_row row = psplat_row_empty(&setting);
    psplat_error error;
    if (psplat_measured_asset_open(&opened, &b->context, &setting, path, &error)) {
        if (competitor == PSPLAT_COMPETITOR_SPLATS) bench_check(PSPLAT_ERROR_READ, &error);
        psplat_measured_asset_close(&opened);
        return 0;
    }
    bench_check(psplat_measured_asset_shape(&opened, &b->context, SAMPLES, &row, &error), &error);
    take_shape(&row, p);
    measure_pictures(b, &opened, p);
    p->elements = opened.model ? (double)psplat_model_describe(opened.model).splat_count
                               : (double)opened.mesh.triangle_count;
    if (opened.asset) b->image_bytes = image_bytes_of(opened.asset);
    psplat_measured_asset_close(&opened);
    return 1;
}

static void record(const bench *b, const char *kind, const point *p) {
    if (!b->csv) return;
    fprintf(b->csv, "%s,%s,%g,%g,%.0f,%.0f,%.5g,%.5g,%.5g", b->name, kind, p->setting,
            p->normal_setting, p->elements, p->bytes, p->distance_max, p->distance_rms,
            p->normal_rms);
    for (size_t i = 0; i < b->set.sizes.count; ++i) {
        const psplat_picture_errors *e = &p->pictures[i];
        fprintf(b->csv, ",%.5f,%.4f,%.4f,%.4f,%.4f,%zu", e->ssim, e->psnr, e->inside_psnr,
                e->missing, e->extra, e->covered);
    }
    fprintf(b->csv, "\n");
    fflush(b->csv);
}

/* ---- gltfpack -------------------------------------------------------------------------------- */

/* Returns the file that gltfpack reads: the model, or the same triangles with the normals that the
 * converter sees. Models with images are read as they are, since the triangles alone have none. */
static const char *input_of(bench *b) {
    psplat_error error;
    int is_whole = b->context.mesh.corner_normals || b->image_bytes > 0;
    if (psplat_gltfpack_reads(b->path) && is_whole) return b->path;
    bench_check(psplat_sweep_context_source_mesh(&b->context, &error), &error);
    bench_write_obj(b->context.source_mesh, b->files[SOURCE]);
    return b->files[SOURCE];
}

static int compare_bytes(const void *left, const void *right) {
    const point *a = left, *b = right;
    return a->bytes < b->bytes ? -1 : a->bytes > b->bytes;
}

/* Makes the meshes. gltfpack puts the images of what it reads into its files. */
static void pack_all(bench *b) {
    static const char *const cc[] = {"-cc", NULL};
    const char *input = input_of(b);
    psplat_error error;
    b->mesh_count = 0;
    for (size_t i = 0; i < b->set.ratios.count; ++i) {
        point p = {.setting = b->set.ratios.values[i]};
        bench_check(
            psplat_gltfpack_run(&b->gltfpack, input, p.setting, cc, b->files[PACKED], &error),
            &error);
        p.bytes = bench_bytes_of(b->files[PACKED]) - b->image_bytes;
        if (!measure(b, b->files[PACKED], PSPLAT_COMPETITOR_GLTFPACK, &p)) continue;
        record(b, "mesh", &p);
        b->meshes[b->mesh_count++] = p;
    }
    qsort(b->meshes, b->mesh_count, sizeof *b->meshes, compare_bytes);
}

/* Finds the mesh of equal bytes. Returns 0 where all are larger or smaller. */
static int mesh_at(const bench *b, double bytes, size_t size, double *ssim, double *psnr) {
    for (size_t i = 1; i < b->mesh_count; ++i) {
        const point *low = &b->meshes[i - 1], *high = &b->meshes[i];
        if (bytes < low->bytes || bytes > high->bytes || !(high->bytes > low->bytes)) continue;
        double t = log(bytes / low->bytes) / log(high->bytes / low->bytes);
        const psplat_picture_errors *from = &low->pictures[size], *to = &high->pictures[size];
        *ssim = from->ssim + t * (to->ssim - from->ssim);
        *psnr = from->psnr + t * (to->psnr - from->psnr);
        return 1;
    }
    return 0;
}

/* ---- splats ---------------------------------------------------------------------------------- */

static void print_head(const bench *b) {
    printf("| model | tolerance %% | normals | splats | bytes | distance max %% | RMS %% | normals "
           "RMS ° |");
    for (size_t i = 0; i < b->set.sizes.count; ++i)
        printf(" %g px: SSIM | mesh | PSNR | mesh | outline %% |", b->set.sizes.values[i]);
    printf("\n|---|");
    for (size_t i = 0; i < 7 + 5 * b->set.sizes.count; ++i) printf("--:|");
    printf("\n");
}

static void print_point(const bench *b, const point *p) {
    printf("| %s | %g | %g | %.0f | %.0f | %.3g | %.3g | %.3g |", b->name, p->setting,
           p->normal_setting, p->elements, p->bytes, p->distance_max, p->distance_rms,
           p->normal_rms);
    for (size_t i = 0; i < b->set.sizes.count; ++i) {
        const psplat_picture_errors *e = &p->pictures[i];
        double ssim, psnr;
        if (mesh_at(b, p->bytes, i, &ssim, &psnr))
            printf(" %.4f | %.4f | %.2f | %.2f | %.3g |", e->ssim, ssim, e->psnr, psnr,
                   e->missing + e->extra);
        else
            printf(" %.4f | - | %.2f | - | %.3g |", e->ssim, e->psnr, e->missing + e->extra);
    }
    printf("\n");
    fflush(stdout);
}

/* Converts at one tolerance. The first conversion tells which images the others share. */
static int convert_one(bench *b, size_t t, size_t n, point *p) {
    *p = (point){.setting = b->set.tolerances.values[t],
                 .normal_setting = b->set.normal_tolerances.values[n]};
    if (!bench_convert(&b->set, b->path, p->setting, p->normal_setting, b->files[SPLATS])) return 0;
    if (!measure(b, b->files[SPLATS], PSPLAT_COMPETITOR_SPLATS, p)) return 0;
    p->bytes = bench_bytes_of(b->files[SPLATS]) - b->image_bytes;
    record(b, "splats", p);
    return 1;
}

static void run_points(bench *b) {
    static point points[BENCH_MOST * BENCH_MOST];
    size_t count = 0;
    for (size_t n = 0; n < b->set.normal_tolerances.count; ++n)
        for (size_t t = 0; t < b->set.tolerances.count; ++t)
            count += (size_t)convert_one(b, t, n, &points[count]);
    if (*b->gltfpack.version) pack_all(b);
    for (size_t i = 0; i < count; ++i) print_point(b, &points[i]);
}

static void run_model(void *user, const char *path, const char *name) {
    bench *b = user;
    psplat_error error;
    b->name = name;
    b->path = path;
    b->context = (psplat_sweep_context){.path = path, .software = 1};
    b->image_bytes = 0;
    bench_check(psplat_sweep_context_open(&b->context, &error), &error);
    bench_check(psplat_sweep_context_source_mesh(&b->context, &error), &error);
    for (size_t i = 0; i < b->set.sizes.count; ++i) {
        const psplat_picture_views_desc desc = {.host = b->context.host,
                                                .source = b->context.source_mesh,
                                                .size = (int)b->set.sizes.values[i]};
        bench_check(psplat_picture_views_create(&desc, &b->views[i], &error), &error);
    }
    run_points(b);
    for (size_t i = 0; i < b->set.sizes.count; ++i) psplat_picture_views_destroy(b->views[i]);
    psplat_sweep_context_close(&b->context);
}

/* ---- options --------------------------------------------------------------------------------- */

static bench_options parse(int argc, char **argv) {
    static const char *const models[] = {"stanford-bunny.obj",
                                         "armadillo.obj",
                                         "rocker-arm.obj",
                                         "Duck.glb",
                                         "spot/spot.obj",
                                         "fandisk.obj",
                                         PSPLAT_SOURCE_DIR "/samples/models/part.obj",
                                         NULL};
    bench_options set = {
        .tolerances = bench_parse_list("8,4,2,1,0.5,0.25"),
        .normal_tolerances = bench_parse_list("0"),
        .ratios = bench_parse_list("0.5,0.3,0.2,0.14,0.1,0.07,0.05,0.035,0.025,0.018,0.012,0.008,"
                                   "0.005,0.0035,0.002,0.001"),
        .sizes = bench_parse_list("100,200,400"),
    };
    bench_parse(&set, models, argc, argv);
    if (set.sizes.count > MOST_SIZES) set.sizes.count = MOST_SIZES;
    return set;
}

static void begin_csv(bench *b) {
    fprintf(b->csv, "model,kind,tolerance_or_ratio,normal_tolerance,elements,bytes,"
                    "distance_max_percent,distance_rms_percent,normal_rms_degrees");
    for (size_t i = 0; i < b->set.sizes.count; ++i) {
        const double size = b->set.sizes.values[i];
        fprintf(b->csv, ",ssim_%g,psnr_%g,inside_psnr_%g,missing_%g,extra_%g,covered_%g", size,
                size, size, size, size, size);
    }
    fprintf(b->csv, "\n");
}

int main(int argc, char **argv) {
    static const char *const names[FILES] = {"source.obj", "packed.glb", "splats.glb"};
    bench b = {.set = parse(argc, argv), .directory = "/tmp/bench_levels.XXXXXX"};
    b.gltfpack = psplat_gltfpack_find(b.set.gltfpack);
    if (!*b.gltfpack.version)
        fprintf(stderr, "bench_levels: gltfpack cannot be run; splats only\n");
    b.csv = bench_open_csv(&b.set);
    if (b.csv) begin_csv(&b);
    if (!mkdtemp(b.directory)) return 1;
    for (size_t i = 0; i < FILES; ++i)
        snprintf(b.files[i], sizeof b.files[i], "%s/%s", b.directory, names[i]);
    printf("%s\n\n", b.gltfpack.version);
    print_head(&b);
    bench_run_models(&b.set, run_model, &b);
    for (size_t i = 0; i < FILES; ++i) unlink(b.files[i]);
    rmdir(b.directory);
    if (b.csv) fclose(b.csv);
    return 0;
}

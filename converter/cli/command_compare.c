/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_compare.c - phongsplat compare: how far an asset, or another mesh, is from a mesh.
 */
#define _XOPEN_SOURCE 700

#include "base/output.h"
#include "base/path.h"
#include "cli/command.h"
#include "cli/mesh_input.h"
#include "cli/options.h"
#include "cli/progress.h"
#include "compare/rays.h"
#include "compare/shape_errors.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "compare/statistics.h"
#include "mesh/mesh.h"
#include "table/setting.h"
#include "views/asset_pictures.h"
#include "views/comparison_json.h"
#include "views/gl_context.h"
#include "views/heatmap.h"
#include "views/image_metrics.h"
#include "views/picture_views.h"

#include <phongsplat/phongsplat.h>
#include <phongsplat/host.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SHOWN_PLACES = 3 }; /* in the table; the report has more */
enum { PATH_ROOM = 16 };   /* bytes of "/view_NN.png" and more */

typedef struct arguments {
    const char *source;
    const char *target;
    const char *report;
    const char *maps; /* directory of heat maps */
    psplat_shape_desc shape;
    psplat_ray_desc rays;
    double crease_angle;
    int samples;
    int format;
    int mode, no_filter, size;
    int no_images, software;
    int overwrite;
    int quiet;
} arguments;

/* The source, the target and what is measured; free_subjects frees everything. */
typedef struct subjects {
    psplat_mesh source_mesh, target_mesh;
    psplat_source_mesh *source;
    psplat_source_mesh *target; /* the target if it is a mesh, or NULL */
    psplat_asset *asset;        /* the target if it is an asset, or NULL */
    psplat_host *host;
    psplat_asset_pictures *pictures;
    psplat_shape_probe *probe;
    uint8_t *maps[PSPLAT_PICTURE_VIEWS]; /* PNG files */
    size_t map_sizes[PSPLAT_PICTURE_VIEWS];
    psplat_comparison comparison;
} subjects;

/* The limits of heat maps, chosen by hand: colours % of white, distances in units of the reach,
 * normals in degrees. */
static const double heatmap_difference = 20, heatmap_reaches = 0.25, heatmap_degrees = 20;

static psplat_parse check_combination(const arguments *a) {
    return a->no_images && a->maps
               ? psplat_options_refuse("compare", "heatmap", "not together with no-images")
               : PSPLAT_PARSE_OK;
}

static psplat_parse parse(int argc, char **argv, arguments *a) {
    const psplat_option options[] = {
        psplat_option_shared("samples", &a->samples),
        {0, "reach", PSPLAT_OPTION_PERCENT, &a->shape.reach, "PERCENT",
         "how far along its normal a surface point is covered; what\n"
         "hangs over is farther than half of it (default: twice the\n"
         "asset's depth tolerance; of a mesh 1)",
         1e-4, 50, NULL},
        {0, "ray-reach", PSPLAT_OPTION_PERCENT, &a->rays.reach, "PERCENT",
         "how near a surface point, times the cosine, a ray that sees\n"
         "it has to meet the splats (default: how far those are from\n"
         "the source at most, but between half of the asset's depth\n"
         "tolerance and all of it; of a mesh 0.25)",
         1e-4, 50, NULL},
        {0, "crease-width", PSPLAT_OPTION_PERCENT, &a->shape.crease_width, "PERCENT",
         "what is near a crease (default: the reach)", 1e-4, 50, NULL},
        psplat_option_shared("crease-angle", &a->crease_angle),
        psplat_option_shared("seed", &a->shape.seed),
        psplat_option_shared("mode", &a->mode),
        psplat_option_shared("no-filter", &a->no_filter),
        psplat_option_shared("size", &a->size),
        {0, "no-images", PSPLAT_OPTION_FLAG, &a->no_images, NULL,
         "draw nothing: no graphics context is needed", 0, 0, NULL},
        psplat_option_shared("software", &a->software),
        {0, "heatmap", PSPLAT_OPTION_TEXT, &a->maps, "DIR",
         "write maps of where the errors are: view_01.png ...\nview_12.png; DIR is made where its "
         "parent exists",
         0, 0, NULL},
        psplat_option_shared("report", &a->report),
        psplat_option_shared("format", &a->format),
        psplat_option_shared("overwrite", &a->overwrite),
        psplat_option_shared("quiet", &a->quiet),
    };
    const psplat_syntax syntax = {
        .command = "compare",
        .operands = "SOURCE A.glb",
        .summary =
            "Measures how an asset (.glb or .gltf) differs from the mesh that it stands for:\n"
            "distances both ways, normals after blending, what is not covered and what hangs\n"
            "over, rays that miss it, and holes in pictures. Instead of an asset, A.glb may be "
            "another mesh.",
        .notes = "Lengths are in % of the bounding box's diagonal, angles in degrees.",
        .options = options,
        .option_count = sizeof options / sizeof *options,
        .slots = {&a->source, &a->target},
    };
    psplat_parse parsed = psplat_options_parse(&syntax, argc, argv);
    return parsed == PSPLAT_PARSE_OK ? check_combination(a) : parsed;
}

/* ---- reading --------------------------------------------------------------------------------- */

/* Reads the target, which is a mesh if it is a glTF file without splats or another format. */
static psplat_result read_target(const arguments *a, subjects *s, psplat_error *error) {
    psplat_result result = psplat_command_open(a->target, NULL, &s->asset, error);
    if (!psplat_mesh_input_expected(a->target, result)) return result;
    *error = (psplat_error){0};
    return psplat_mesh_input_read(a->target, a->crease_angle, &s->target_mesh, &s->target, error);
}

/* ---- outputs --------------------------------------------------------------------------------- */

/* Returns DIR/view_NN.png, which the caller frees, or NULL where memory ran out. */
static char *map_path(const arguments *a, int view) {
    size_t size = strlen(a->maps) + PATH_ROOM;
    char *path = malloc(size);
    if (path) snprintf(path, size, "%s/view_%02d.png", a->maps, view + 1);
    return path;
}

static psplat_result check_output(const arguments *a, const char *path, psplat_error *error) {
    psplat_result result = psplat_output_check(a->source, path, a->overwrite, error);
    return result ? result : psplat_output_check(a->target, path, a->overwrite, error);
}

/* Checks the files of heat maps, or, if their directory does not exist, that it can be created. */
static psplat_result check_maps(const arguments *a, psplat_error *error) {
    struct stat status;
    if (stat(a->maps, &status)) return psplat_output_check(NULL, a->maps, 0, error);
    psplat_result result = PSPLAT_OK;
    for (int view = 0; view < PSPLAT_PICTURE_VIEWS && !result; ++view) {
        char *path = map_path(a, view);
        result = path ? check_output(a, path, error)
                      : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a name");
        free(path);
    }
    return result;
}

static psplat_result check_outputs(const arguments *a, psplat_error *error) {
    psplat_result result = a->report ? check_output(a, a->report, error) : PSPLAT_OK;
    return result || !a->maps ? result : check_maps(a, error);
}

static psplat_result make_directory(const char *path, psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    if (!mkdir(path, 0777) || errno == EEXIST) return PSPLAT_OK;
    int cause = errno;
    psplat_path_shorten(path, shown);
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s: cannot be created: %s", shown,
                       strerror(cause));
}

static psplat_result write_maps(const arguments *a, const subjects *s, psplat_error *error) {
    psplat_result result = make_directory(a->maps, error);
    for (int view = 0; view < PSPLAT_PICTURE_VIEWS && !result; ++view) {
        char *path = map_path(a, view);
        result =
            path ? psplat_output_write(path, s->maps[view], s->map_sizes[view], a->overwrite, error)
                 : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a name");
        free(path);
    }
    return result;
}

/* ---- comparison ------------------------------------------------------------------------------ */

/* Returns how rays are measured. An asset whose depth tolerance is half as large as splats are far
 * from the source, since layers lie close to each other, is asked for no more than it promises. */
static psplat_ray_desc ray_desc(const arguments *a, const subjects *s) {
    psplat_ray_desc rays = a->rays;
    double half_depth = s->comparison.shape.reach / 4;
    if (s->target || rays.reach > 0 || a->shape.reach > 0) return rays;
    rays.reach = fmin(fmax(s->comparison.shape.inward.max, half_depth), 2 * half_depth);
    return rays;
}

static psplat_result measure(const arguments *a, subjects *s, psplat_error *error) {
    psplat_shape_errors *shape = &s->comparison.shape;
    psplat_ray_errors *errors = &s->comparison.rays;
    psplat_result result =
        s->target ? psplat_shape_compare_mesh(s->source, s->target, &a->shape, shape, error)
                  : psplat_shape_compare(s->source, s->asset, &a->shape, shape, error);
    if (result) return result;
    const psplat_ray_desc rays = ray_desc(a, s);
    return s->target ? psplat_rays_compare_mesh(s->source, s->target, &rays, errors, error)
                     : psplat_rays_compare(s->source, s->asset, &rays, errors, error);
}

/* Returns how near an outline, in pixels, a pixel is no interior hole: as far as the reach of rays
 * allows outlines to move, and two more. The pictures show a little more than the sphere around the
 * source. */
static int erosion_of(const arguments *a, const subjects *s) {
    double reach = s->comparison.rays.reach / 100 * s->comparison.shape.diagonal;
    return 2 + (int)ceil(reach * a->size / (2 * s->source->radius));
}

static psplat_result create_pictures(const arguments *a, subjects *s, psplat_shading shading,
                                     psplat_asset_pictures **pictures, psplat_error *error) {
    const psplat_asset_pictures_desc desc = {.host = s->host,
                                             .source = s->source,
                                             .asset = s->asset,
                                             .mesh = s->target,
                                             .mode = (psplat_mode)a->mode,
                                             .no_filter = a->no_filter,
                                             .size = a->size,
                                             .shading = shading,
                                             .erosion = erosion_of(a, s)};
    return psplat_asset_pictures_create(&desc, pictures, error);
}

/* Returns whether the base colour of the source varies by more than its materials' factors. */
static int has_base_color(const psplat_mesh *mesh) {
    for (size_t i = 0; i < mesh->source_material_count; ++i)
        if (mesh->source_materials[i].base_color.image) return 1;
    return mesh->corner_colors != NULL;
}

/* Compares pictures without light, in which only colours differ. */
static psplat_result compare_base_color(const arguments *a, subjects *s, psplat_error *error) {
    psplat_asset_pictures *pictures = NULL;
    psplat_result result = create_pictures(a, s, PSPLAT_SHADING_UNLIT, &pictures, error);
    if (!result)
        result = psplat_asset_pictures_compare(pictures, -1, &s->comparison.base_color, error);
    psplat_asset_pictures_destroy(pictures);
    s->comparison.has_base_color = 1;
    return result;
}

/* Draws and compares the pictures. The fractions of the progress line were measured on a mechanical
 * part with default options. */
static psplat_result compare_pictures(const arguments *a, subjects *s, psplat_progress *progress,
                                      psplat_error *error) {
    psplat_comparison *c = &s->comparison;
    psplat_progress_show_done(progress, "drawing", 0.5);
    psplat_result result = psplat_context_create(a->software, &s->host, error);
    if (!result) result = create_pictures(a, s, PSPLAT_SHADING_LIT, &s->pictures, error);
    for (int view = 0; view < PSPLAT_PICTURE_VIEWS && !result; ++view) {
        psplat_progress_show_done(progress, "drawing", 0.6 + 0.02 * view);
        result = psplat_asset_pictures_compare(s->pictures, view, &c->views[view], error);
    }
    psplat_progress_show_done(progress, "comparing pictures", 0.85);
    if (!result) result = psplat_asset_pictures_compare(s->pictures, -1, &c->picture, error);
    if (!result && has_base_color(&s->source_mesh)) result = compare_base_color(a, s, error);
    c->has_pictures = 1;
    c->mode = (psplat_mode)a->mode;
    c->no_filter = a->no_filter;
    c->size = a->size;
    c->erosion = erosion_of(a, s);
    return result;
}

static psplat_result make_maps(const arguments *a, subjects *s, psplat_progress *progress,
                               psplat_error *error) {
    const psplat_heatmap_limits limits = {
        heatmap_difference, heatmap_reaches * s->comparison.shape.reach, heatmap_degrees};
    psplat_result result =
        s->target
            ? psplat_shape_probe_create_mesh(s->source, s->target, &a->shape, &s->probe, error)
            : psplat_shape_probe_create(s->source, s->asset, &a->shape, &s->probe, error);
    for (int view = 0; view < PSPLAT_PICTURE_VIEWS && !result; ++view) {
        psplat_progress_show_done(progress, "drawing maps",
                                  0.9 + 0.1 * view / PSPLAT_PICTURE_VIEWS);
        result = psplat_asset_pictures_map(s->pictures, s->probe, view, &limits, &s->maps[view],
                                           &s->map_sizes[view], error);
    }
    return result;
}

static psplat_result compare(const arguments *a, subjects *s, psplat_progress *progress,
                             psplat_error *error) {
    psplat_comparison *c = &s->comparison;
    double start = psplat_progress_clock();
    psplat_progress_show_done(progress, "measuring", 0.1);
    psplat_result result = measure(a, s, error);
    if (!result && !a->no_images) result = compare_pictures(a, s, progress, error);
    if (!result && a->maps) result = make_maps(a, s, progress, error);
    c->source = a->source;
    c->target = a->target;
    c->source_triangles = s->source_mesh.triangle_count;
    c->is_mesh = s->target != NULL;
    c->seconds = psplat_progress_clock() - start;
    return result;
}

/* Does all the work. *path is the file that an error concerns, or NULL where its text names it. */
static psplat_result work(const arguments *a, subjects *s, const char **path, psplat_error *error) {
    *path = NULL;
    psplat_result result = check_outputs(a, error);
    if (result) return result;
    psplat_progress progress = psplat_progress_begin(a->quiet);
    *path = a->source;
    psplat_progress_show_done(&progress, "reading", 0);
    result = psplat_mesh_input_read(a->source, a->crease_angle, &s->source_mesh, &s->source, error);
    if (!result) {
        *path = a->target;
        result = read_target(a, s, error);
    }
    if (!result) result = compare(a, s, &progress, error);
    psplat_progress_end(&progress);
    return result;
}

/* Returns whether to print results: not if the report takes standard output. */
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
    if (!result && a->format == PSPLAT_FORMAT_JSON && prints(a)) fwrite(text, 1, size, stdout);
    free(text);
    return result;
}

/* ---- the table ------------------------------------------------------------------------------- */

static void print_statistics(const char *name, const psplat_statistics *values, const char *unit) {
    printf("%-28s %9.4g %9.4g %9.4g %s\n", name, values->max, values->rms, values->p95, unit);
}

/* Returns the view with the least PSNR. */
static int worst_view(const psplat_comparison *c) {
    int worst = 0;
    for (int view = 1; view < PSPLAT_PICTURE_VIEWS; ++view)
        if (c->views[view].psnr < c->views[worst].psnr) worst = view;
    return worst;
}

static void print_pictures(const psplat_comparison *c) {
    const psplat_picture_errors *p = &c->picture;
    int worst = worst_view(c);
    printf("\n%d pictures of %d x %d%s%s: PSNR %.2f dB, SSIM %.4f, mean difference %.3g %% of "
           "white\n",
           PSPLAT_PICTURE_VIEWS, c->size, c->size, c->is_mesh ? "" : ", ",
           c->is_mesh ? "" : psplat_mode_names[c->mode], p->psnr, p->ssim, p->difference);
    if (c->has_base_color)
        printf("base colour, without light: PSNR %.2f dB, %.2f dB where both are, SSIM %.4f, mean "
               "difference %.3g %% of white\n",
               c->base_color.psnr, c->base_color.inside_psnr, c->base_color.ssim,
               c->base_color.difference);
    printf("from afar, an eighth as large: mean difference %.3g %% of white\n", p->distant);
    printf("outline: %.3g %% of %zu pixels missing, %.3g %% extra; worst view %d, %.2f dB\n",
           p->missing, p->covered, p->extra, worst + 1, c->views[worst].psnr);
    printf("interior holes: %zu pixels of the background, %d or more from outlines\n",
           p->interior_holes, c->erosion);
}

static void print_rays(const psplat_ray_errors *r) {
    printf("\nrays that see the source: %zu of %zu miss the target by more than %.3g %% over the "
           "cosine (%.3g %%)\n",
           r->missed, r->count, r->reach, psplat_rays_missed_percent(r));
    printf("  %zu of these show the background; not counted: %zu beside outlines, %zu hidden\n",
           r->open, r->outline, r->hidden);
    for (int i = PSPLAT_RAY_RANGES - 1; i >= 0; --i)
        printf("  at cosines of %.1f to %.1f: %zu of %zu\n", psplat_rays_least_cosine(i),
               psplat_rays_least_cosine(i + 1), r->range_missed[i], r->range_count[i]);
    for (size_t i = 0; i < r->place_count && i < SHOWN_PLACES; ++i) {
        const psplat_ray_place *p = &r->places[i];
        printf("  missed at %.6g %.6g %.6g, seen from %.3f %.3f %.3f, cosine %.2f\n", p->point[0],
               p->point[1], p->point[2], p->direction[0], p->direction[1], p->direction[2],
               p->cosine);
    }
}

static void print_table(const psplat_comparison *c) {
    const psplat_shape_errors *e = &c->shape;
    const char *kind = c->is_mesh ? "triangles" : "splats";
    char crease[64];
    printf("%s: %zu %s against %zu triangles of %s\n\n", c->target, e->elements, kind,
           c->source_triangles, c->source);
    printf("%-28s %9s %9s %9s\n", "", "max", "rms", "95 %");
    print_statistics("source to target", &e->outward, "% of the diagonal");
    print_statistics("target to source", &e->inward, "%");
    print_statistics("both", &e->distance, "%");
    print_statistics("normals", &e->normal, "degrees");
    print_statistics("  on faces", &e->face_normal, "degrees");
    snprintf(crease, sizeof crease, "  within %.3g %% of creases", e->crease_width);
    print_statistics(crease, &e->crease_normal, "degrees");
    printf("\nnot covered within %.3g %%: %.4g %% of the source's area\n", e->reach,
           e->uncovered_area);
    printf("hanging over by more than %.3g %%: %.4g %% of the area of %s\n", e->reach / 2,
           e->overhang_area, kind);
    printf("%.4g %% of the source's area is near creases\n", e->crease_area);
    print_rays(&c->rays);
    if (c->has_pictures) print_pictures(c);
    printf("\ndiagonal %.6g, %zu and %zu points, %.2f s\n", e->diagonal, e->source_samples,
           e->target_samples, c->seconds);
}

static void free_subjects(subjects *s) {
    for (int view = 0; view < PSPLAT_PICTURE_VIEWS; ++view) free(s->maps[view]);
    psplat_shape_probe_destroy(s->probe);
    psplat_asset_pictures_destroy(s->pictures);
    psplat_host_destroy(s->host);
    psplat_source_mesh_destroy(s->source);
    psplat_source_mesh_destroy(s->target);
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
    if (!result && a->maps) result = write_maps(a, s, &error);
    if (result) return psplat_command_fail(NULL, &error);
    if (prints(a) && a->format == PSPLAT_FORMAT_PRETTY) print_table(&s->comparison);
    return PSPLAT_EXIT_SUCCESS;
}

int psplat_command_compare(int argc, char **argv) {
    arguments a = {.size = 512};
    psplat_parse parsed = parse(argc, argv, &a);
    if (parsed != PSPLAT_PARSE_OK) return (int)parsed;
    a.shape.samples = (size_t)a.samples;
    a.rays.rays = (size_t)a.samples / 2;
    a.rays.seed = a.shape.seed;
    subjects s = {0};
    int code = run(&a, &s);
    free_subjects(&s);
    return code;
}

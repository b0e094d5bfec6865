/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_convert.c - phongsplat convert: a mesh becomes an asset, and what was measured a report.
 */
#define _XOPEN_SOURCE 700

#include "base/output.h"
#include "base/path.h"
#include "cli/command.h"
#include "cli/jobs.h"
#include "cli/options.h"
#include "cli/page.h"
#include "cli/progress.h"
#include "export/alternatives.h"
#include "export/fallback_mesh.h"
#include "export/glb_writer.h"
#include "export/khr_gaussians.h"
#include "export/mesh_levels.h"
#include "export/meshopt_codec.h"
#include "import/read_scene.h"
#include "material/shrink_images.h"
#include "pipeline/budget.h"
#include "pipeline/convert_scene.h"
#include "pipeline/levels.h"
#include "scene/instances.h"
#include "scene/scene.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

#include <phongsplat/phongsplat.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct arguments {
    const char *input;
    psplat_operands more; /* further inputs */
    const char *output;
    const char *report;
    const char *html;
    int html_source;
    psplat_conversion_options how;
    int splats, bytes;         /* budgets, or 0 */
    const char *levels;        /* as given, or NULL */
    psplat_levels_desc wanted; /* what it means */
    int level_textures;        /* index into texture_names */
    int textures;              /* index into texture_names */
    int texture_size;          /* greatest side of an image, or 0: any */
    int gaussian;
    int overwrite;
    int quiet;
    int jobs; /* at a time */
    int no_progress, no_summary;
} arguments;

/* The results of a conversion; free_product frees everything. */
typedef struct product {
    psplat_scene scene;
    psplat_splats *splats; /* by mesh of the scene */
    psplat_scene_report report;
    psplat_fallback_mesh *fallbacks; /* by mesh of the scene, or NULL */
    psplat_gaussian **gaussians;     /* by mesh of the scene, or NULL */
    psplat_mesh_levels *levels;      /* by mesh of the scene, or NULL */
    uint8_t *bytes;
    size_t size;
    psplat_page page; /* what --html takes */
    size_t page_size; /* bytes of the page that was written */
    size_t needed;    /* by the coarsest conversion if the budget is too small for it, else 0 */
} product;

/* Reads --levels: a number of levels, or tolerances of the coarser ones, separated by commas. A
 * single tolerance has its percent sign. Returns 0 where it is neither. */
static int parse_levels(arguments *a) {
    const char *text = a->levels;
    char *end = NULL;
    if (!strpbrk(text, ",%")) {
        unsigned long most = strtoul(text, &end, 10);
        a->wanted.most = *text >= '0' && *text <= '9' && !*end ? (size_t)most : 0;
        return a->wanted.most >= 2 && a->wanted.most <= PSPLAT_MOST_LEVELS;
    }
    for (size_t i = 0; i + 1 < PSPLAT_MOST_LEVELS; ++i) {
        double tolerance = strtod(text, &end);
        if (end == text || !(tolerance > (i ? a->wanted.tolerances[i - 1] : 0)) || tolerance > 20)
            return 0;
        a->wanted.tolerances[i] = tolerance;
        a->wanted.most = i + 2;
        text = *end == '%' ? end + 1 : end;
        if (!*text) return 1;
        if (*text++ != ',') return 0;
    }
    return 0;
}

enum { TEXTURES_KEEP, TEXTURES_BAKE };
static const char *const texture_names[] = {"keep", "bake", NULL};

static psplat_parse refuse(const char *option, const char *cause) {
    return psplat_options_refuse("convert", option, cause);
}

/* Checks what concerns several options together. */
static psplat_parse check_combination(arguments *a) {
    if (a->bytes && a->gaussian) return refuse("gaussian", "not together with bytes");
    if (a->bytes && a->how.fallback == PSPLAT_FALLBACK_MESH)
        return refuse("fallback mesh", "not together with bytes");
    if (a->level_textures && !a->levels)
        return refuse("level-textures", "only together with levels");
    if (a->levels && a->bytes) return refuse("levels", "not together with bytes");
    if (a->levels && !parse_levels(a))
        return refuse("levels",
                      "neither a number of 2 to 16 nor rising tolerances up to 20 %, such "
                      "as 1%,2%,4%");
    if (a->textures == TEXTURES_BAKE && a->how.convert.texture_tolerance_texels > 0)
        return refuse("texture-tolerance", "not together with textures bake");
    if (a->textures == TEXTURES_BAKE && a->texture_size)
        return refuse("texture-size", "not together with textures bake");
    if (a->html_source && !a->html) return refuse("html-source", "only together with html");
    if (a->splats && a->bytes)
        return refuse("splats", "not together with bytes: one budget at a time");
    return psplat_options_check_conversion("convert", &a->how);
}

static const char summary[] =
    "Converts a mesh or a point set (OBJ, PLY, OFF, STL, glTF, GLB, text) to Phong splats\n"
    "in a GLB, or several of them to OUT/NAME.glb each.";

static const char notes[] =
    "OUT.glb, PAGE.html and R.json are written whole and together, or none of them. Tolerances\n"
    "are promises, checked on samples other than those that were fitted; one that is broken\n"
    "gives exit code 9, and the report names the places.\n\n"
    "Of several inputs, each is converted whatever happens to the others, and R.json has an\n"
    "entry for each. The exit code is the greatest of those that wrote nothing, else 9 or 0.\n"
    "OUT/ is made where it does not exist.";

static void add_files_and_promises(psplat_option_list *list, arguments *a) {
    psplat_convert_desc *c = &a->how.convert;
    const psplat_option group[] = {
        {'i', "input", PSPLAT_OPTION_TEXT, &a->input, "IN", "the mesh, instead of the operand", 0,
         0, NULL},
        {'o', "output", PSPLAT_OPTION_TEXT, &a->output, "OUT.glb",
         "the asset, instead of the operand; - is standard output", 0, 0, NULL},
        {'t', "tolerance", PSPLAT_OPTION_PERCENT, &c->tolerance_percent, "PERCENT",
         "greatest distance between splats and surface, in % of the\n"
         "bounding box's diagonal: 0.2% or 0.2 (default 0.2; with a\n"
         "budget the greatest that will do, default 20)",
         1e-4, 50, NULL},
        psplat_option_shared("normal-tolerance", &c->normal_tolerance_degrees),
        {0, "color-tolerance", PSPLAT_OPTION_PERCENT, &c->color_tolerance_percent, "PERCENT",
         "greatest root mean square error of a splat's colour over\nits part of the surface, in % "
         "of sRGB's range; 100 does\nnot bound it (default 6.3 at a tolerance of 0.2 %, changing\n"
         "with its square root); a promise at 950 of 1000 points of what\nsplats blend to, and of "
         "emission, roughness and metallic, each\noff by no more than the tolerance over the "
         "surface;\nfiner paint may average out",
         0.1, 100, NULL},
    };
    psplat_options_add(list, group, sizeof group / sizeof *group);
}

static void add_textures(psplat_option_list *list, arguments *a) {
    psplat_convert_desc *c = &a->how.convert;
    const psplat_option group[] = {
        {0, "textures", PSPLAT_OPTION_CHOICE, &a->textures, "keep|bake",
         "keep: splats get texture coordinates where the mesh has\n"
         "them, and OUT.glb the images (default); bake: textures\n"
         "become colours of splats",
         0, 0, texture_names},
        {0, "texture-tolerance", PSPLAT_OPTION_NUMBER, &c->texture_tolerance_texels, "N",
         "greatest error of texture coordinates, in texels (default:\n"
         "a texture slides over the surface by at most the\ntolerance)",
         0.01, 1e4, NULL},
        {0, "texture-size", PSPLAT_OPTION_COUNT, &a->texture_size, "N",
         "halve images with a side of more than N texels until it\n"
         "has N at most; others are copied untouched (default: all\nare)",
         1, 65536, NULL},
    };
    psplat_options_add(list, group, sizeof group / sizeof *group);
}

static void add_budgets_and_levels(psplat_option_list *list, arguments *a) {
    const psplat_option group[] = {
        {0, "splats", PSPLAT_OPTION_COUNT, &a->splats, "N",
         "find the smallest tolerance that takes at most N splats:\na budget", 1, 1e9, NULL},
        {0, "bytes", PSPLAT_OPTION_COUNT, &a->bytes, "N",
         "find the smallest tolerance whose OUT.glb has at most N\nbytes with its images: a budget",
         1, 2e9, NULL},
        {0, "levels", PSPLAT_OPTION_TEXT, &a->levels, "N|LIST",
         "levels of detail: at most N in all, each with twice the\ntolerance, until some 32 splats "
         "are left; or the tolerances\nof the coarser ones, such as 1%,2%,4%",
         0, 0, NULL},
        {0, "level-textures", PSPLAT_OPTION_CHOICE, &a->level_textures, "keep|bake",
         "the textures of coarser levels, as --textures (default\nkeep); baked levels take about "
         "half the bytes",
         0, 0, texture_names},
    };
    psplat_options_add(list, group, sizeof group / sizeof *group);
}

static void add_outputs(psplat_option_list *list, arguments *a) {
    const psplat_option group[] = {
        {0, "gaussian", PSPLAT_OPTION_FLAG, &a->gaussian, NULL,
         "add attributes of KHR_gaussian_splatting: viewers of\n"
         "Gaussians show the shape, lit for good and without sharp\nedges",
         0, 0, NULL},
        {0, "html", PSPLAT_OPTION_TEXT, &a->html, "PAGE.html",
         "write the splats with a viewer as one page too, which a\nbrowser opens from disk; - is "
         "standard output",
         0, 0, NULL},
        {0, "html-source", PSPLAT_OPTION_FLAG, &a->html_source, NULL,
         "put the mesh into PAGE.html, too, and a slider between both:\na GLB without Draco, or an "
         "OBJ without materials, as it is,\nelse a GLB with all triangles and images",
         0, 0, NULL},
        psplat_option_shared("seed", &a->how.convert.seed),
        {'j', "jobs", PSPLAT_OPTION_COUNT, &a->jobs, "N",
         "with several inputs, convert N of them at a time\n(default 1)", 1, PSPLAT_MAX_JOBS, NULL},
        psplat_option_shared("report", &a->report),
        psplat_option_shared("overwrite", &a->overwrite),
        psplat_option_shared("quiet", &a->quiet),
    };
    psplat_options_add(list, group, sizeof group / sizeof *group);
}

static psplat_parse parse(int argc, char **argv, arguments *a) {
    psplat_option_list list = {.count = 0};
    add_files_and_promises(&list, a);
    add_textures(&list, a);
    add_budgets_and_levels(&list, a);
    psplat_options_add_conversion(&list, &a->how);
    add_outputs(&list, a);
    const psplat_syntax syntax = {
        .command = "convert",
        .operands = "IN OUT.glb | IN... OUT/",
        .summary = summary,
        .notes = notes,
        .options = list.rows,
        .option_count = list.count,
        .slots = {&a->input, &a->output},
        .more = &a->more,
    };
    psplat_parse parsed = psplat_options_parse(&syntax, argc, argv);
    return parsed == PSPLAT_PARSE_OK ? check_combination(a) : parsed;
}

/* Returns the peak of memory in use, bytes. VmHWM of Linux counts this program alone; ru_maxrss,
 * which other systems have too, begins with what the parent process used. */
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

/* Checks a file that is written besides another one, which is what the error calls it. */
static psplat_result check_besides(const arguments *a, const char *path, const char *other,
                                   const char *what, psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    if (!path) return PSPLAT_OK;
    psplat_path_shorten(path, shown);
    if (other && psplat_output_is_same(path, other))
        return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s: is also the %s", shown, what);
    return psplat_output_check(a->input, path, a->overwrite, error);
}

static psplat_result check_outputs(const arguments *a, psplat_error *error) {
    psplat_result result = psplat_output_check(a->input, a->output, a->overwrite, error);
    if (!result) result = check_besides(a, a->report, a->output, "asset", error);
    if (!result) result = check_besides(a, a->html, a->output, "asset", error);
    if (!result) result = check_besides(a, a->html, a->report, "report", error);
    return result;
}

/* Returns the file name without directory and extension, which names the node and the mesh; the
 * caller frees it. */
static char *model_name(const char *path) {
    const char *slash = strrchr(path, '/');
    const char *base = slash ? slash + 1 : path;
    const char *dot = strrchr(base, '.');
    return strndup(base, dot && dot > base ? (size_t)(dot - base) : strlen(base));
}

/* Counts the splats that the scene shows, once for every time that they are shown. */
static psplat_result count_shown(const product *p, size_t *count, psplat_error *error) {
    psplat_instance *instances;
    size_t instance_count;
    psplat_result result = psplat_scene_instances(&p->scene, psplat_scene_shown(&p->scene),
                                                  &instances, &instance_count, error);
    *count = 0;
    for (size_t i = 0; i < instance_count; ++i) *count += p->splats[instances[i].mesh].count;
    free(instances);
    return result;
}

/* Checks that the runtime opens the bytes that will be written. */
static psplat_result check_asset(const product *p, psplat_error *error) {
    psplat_asset *asset = NULL;
    psplat_error refused = {0};
    size_t splats = 0, expected;
    psplat_result result = psplat_asset_open_memory(p->bytes, p->size, NULL, &asset, &refused);
    if (result == PSPLAT_ERROR_MEMORY) return psplat_fail(error, result, 0, "%s", refused.text);
    if (result)
        return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "the runtime refuses the result: %.180s",
                           refused.text);
    for (size_t i = 0; i < psplat_asset_batch_count(asset); ++i)
        splats += psplat_asset_batch(asset, i)->splat_count;
    psplat_asset_destroy(asset);
    result = count_shown(p, &expected, error);
    if (result || splats == expected) return result;
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%zu splats became %zu in the result",
                       expected, splats);
}

static psplat_convert_desc describe(const arguments *a, psplat_progress *progress) {
    psplat_convert_desc desc = a->how.convert;
    desc.progress = psplat_progress_show;
    desc.user = progress;
    desc.bake_textures = a->textures == TEXTURES_BAKE;
    return desc;
}

static psplat_result convert(const arguments *a, const psplat_write_desc *written,
                             psplat_progress *progress, product *p, psplat_error *error) {
    const psplat_budget budget = {(size_t)a->splats, (size_t)a->bytes, written};
    const psplat_convert_desc desc = describe(a, progress);
    p->splats = calloc(p->scene.mesh_count + 1, sizeof *p->splats);
    if (!p->splats) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    if (!a->splats && !a->bytes)
        return psplat_scene_convert(&p->scene, &desc, p->splats, &p->report, error);
    return psplat_scene_convert_budget(&p->scene, &desc, &budget, p->splats, &p->report, &p->needed,
                                       error);
}

/* Makes the fallback meshes and Gaussians that were asked for. The meshes get the tolerance that
 * the splats have, also where a budget has chosen it. */
static psplat_result add_alternatives(const arguments *a, product *p, psplat_error *error) {
    psplat_convert_desc desc = describe(a, NULL);
    psplat_result result = PSPLAT_OK;
    desc.tolerance_percent = p->report.total.tolerance_percent;
    if (a->how.fallback == PSPLAT_FALLBACK_MESH)
        result = psplat_scene_fallback_meshes(&p->scene, &desc, &p->fallbacks, error);
    if (a->gaussian && !result)
        result = psplat_scene_gaussians(&p->scene, p->splats, &p->gaussians, error);
    return result;
}

/* Makes the mesh that the page shows beside the splats, with the textures that it has. */
static psplat_result add_source(const arguments *a, product *p, psplat_error *error) {
    psplat_convert_desc desc = describe(a, NULL);
    psplat_fallback_mesh *meshes = NULL;
    desc.tolerance_percent = p->report.total.tolerance_percent;
    desc.bake_textures = 0;
    psplat_result result = psplat_scene_whole_meshes(&p->scene, &desc, &meshes, error);
    if (!result)
        result = psplat_scene_write_meshes(&p->scene, meshes, &psplat_meshopt_codec, &p->page.mesh,
                                           &p->page.mesh_size, error);
    psplat_scene_fallback_meshes_free(&p->scene, meshes);
    return result;
}

static psplat_result add_levels(const arguments *a, psplat_progress *progress, product *p,
                                psplat_error *error) {
    psplat_convert_desc desc = describe(a, progress);
    if (!a->levels) return PSPLAT_OK;
    desc.bake_textures |= a->level_textures == TEXTURES_BAKE;
    return psplat_scene_levels(&p->scene, &desc, &a->wanted, p->splats, &p->report, &p->levels,
                               error);
}

static psplat_result make(const arguments *a, product *p, psplat_error *error) {
    psplat_progress progress = psplat_progress_begin(a->quiet || a->no_progress);
    char *name = model_name(a->input);
    psplat_write_desc written = {.codec = a->how.no_compress ? NULL : &psplat_meshopt_codec};
    psplat_progress_show(&progress, "reading", 0);
    psplat_result result = psplat_scene_read(a->input, name, &p->scene, error);
    if (!result && a->textures == TEXTURES_KEEP) psplat_scene_warn_of_textures(&p->scene);
    if (!result && a->texture_size)
        result = psplat_images_shrink(&p->scene.materials, (uint32_t)a->texture_size, error);
    if (!result) result = convert(a, &written, &progress, p, error);
    if (!result) result = add_levels(a, &progress, p, error);
    if (!result) result = add_alternatives(a, p, error);
    if (!result && psplat_page_wants_mesh(&p->page)) result = add_source(a, p, error);
    written.levels = p->levels;
    written.fallbacks = p->fallbacks;
    written.gaussians = (const psplat_gaussian *const *)p->gaussians;
    psplat_progress_show(&progress, "writing", 0);
    if (!result)
        result = psplat_scene_write(&p->scene, p->splats, &written, &p->bytes, &p->size, error);
    if (!result) result = check_asset(p, error);
    psplat_progress_end(&progress);
    free(name);
    return result;
}

/* Writes the asset, the page and the report, all or none. */
static psplat_result write_outputs(const arguments *a, product *p, psplat_error *error) {
    psplat_output_file files[3] = {{a->output, p->bytes, p->size}};
    size_t count = 1, report_size = 0;
    char *page = NULL, *report = NULL;
    psplat_result result = PSPLAT_OK;
    if (a->html) {
        result =
            psplat_page_make(&p->page, a->output, p->bytes, p->size, &page, &p->page_size, error);
        files[count++] = (psplat_output_file){a->html, page, p->page_size};
    }
    if (a->report && !result) {
        result = psplat_scene_report_json(&p->scene, &p->report, &report, &report_size, error);
        files[count++] = (psplat_output_file){a->report, report, report_size};
    }
    if (!result) result = psplat_output_write_all(files, count, a->overwrite, error);
    free(page);
    free(report);
    return result;
}

/* Returns whether a path is standard output: "-", /dev/stdout, or the pipe behind it. */
static int is_standard_output(const char *path) {
    struct stat there, here;
    if (!path || !strcmp(path, "-")) return path != NULL;
    return !stat(path, &there) && !fstat(STDOUT_FILENO, &here) && there.st_dev == here.st_dev &&
           there.st_ino == here.st_ino;
}

/* Prints a line about each coarser level: the splats of all meshes that have it, and their greatest
 * errors. */
static void print_levels(const arguments *a, const product *p) {
    for (size_t l = 1; l < PSPLAT_MOST_LEVELS; ++l) {
        size_t splats = 0;
        double tolerance = 0, distance = 0, normal = 0, outline = 0;
        for (size_t i = 0; i < p->scene.mesh_count; ++i) {
            const psplat_mesh_level_splats *level = &p->levels[i].list[l];
            if (l >= p->levels[i].count) continue;
            double percent = 100 / p->report.meshes[i].diagonal;
            splats += level->splats.count;
            tolerance = fmax(tolerance, level->tolerance);
            distance = fmax(distance, percent * level->distance);
            normal = fmax(normal, level->normal);
            outline = fmax(outline, percent * level->outline);
        }
        if (!splats && l == 1)
            printf("%s: no coarser level has at most four fifths of the splats\n", a->output);
        if (!splats) return;
        printf("%s: level %zu: %zu splats, tolerance %.3g %%, distance %.3g %%, rms normal %.3g "
               "degrees, outline %.3g %%\n",
               a->output, l, splats, tolerance, distance, normal, outline);
    }
}

/* Prints the summary, unless standard output takes a file. */
static void print_summary(const arguments *a, const product *p) {
    const psplat_report *r = &p->report.total;
    if (a->quiet || a->no_summary || is_standard_output(a->output) ||
        is_standard_output(a->report) || is_standard_output(a->html))
        return;
    printf("%s: %zu splats, %zu bytes, max distance %.3g %% (tolerance %.3g %%), rms normal %.3g "
           "degrees, %zu of %zu samples uncovered, %.2f s\n",
           a->output, r->splats, r->bytes, r->max_distance_percent, r->tolerance_percent,
           r->rms_normal_degrees, r->uncovered_samples, r->verification_samples, r->seconds);
    if (p->levels) print_levels(a, p);
    if (a->html) printf("%s: %zu bytes with the viewer\n", a->html, p->page_size);
}

/* Describes the first place where a promise of the conversion is broken. */
static void describe_broken(const psplat_place *place, const psplat_kept *kept, int texels,
                            char text[160]) {
    double value = place->value, limit = kept->limit;
    size_t broken = kept->broken;
    switch (place->promise) {
    case PSPLAT_PROMISE_COVERAGE:
        snprintf(text, 160, "no splat covers the surface within %.3g %% (%zu samples)", limit,
                 broken);
        break;
    case PSPLAT_PROMISE_DISTANCE:
        snprintf(text, 160, "a splat leaves the surface by %.3g %%, not %.3g %% (%zu splats)",
                 value, limit, broken);
        break;
    case PSPLAT_PROMISE_NORMAL:
        snprintf(text, 160, "the normal errs by %.3g degrees, not %.3g (%zu samples)", value, limit,
                 broken);
        break;
    case PSPLAT_PROMISE_COLOR:
        snprintf(text, 160, "colours err by %.3g %%, not %.3g %% (%zu samples)", value, limit,
                 broken);
        break;
    case PSPLAT_PROMISE_TEXTURE:
        snprintf(text, 160, "a texture slides by %.3g %s, not %.3g %s (%zu samples)", value,
                 texels ? "texels" : "%", limit, texels ? "texels" : "%", broken);
        break;
    default:
        snprintf(text, 160, "a splat crosses a crease by %.3g %%, not %.3g %% (%zu edges)", value,
                 limit, broken);
    }
}

/* Prints a line about the first broken promise; the report has all of them. */
static void print_broken(const arguments *a, const product *p) {
    const psplat_report *r = &p->report.total;
    const psplat_place *place = &r->places[0];
    const double *at = place->position;
    char shown[PSPLAT_SHOWN_PATH], text[160], mesh[PSPLAT_SHOWN_PATH] = "";
    describe_broken(place, &r->promises[place->promise], r->texture_tolerance_texels > 0, text);
    psplat_path_shorten(a->input, shown);
    if (p->scene.mesh_count > 1) psplat_scene_label(&p->scene, place->mesh, mesh);
    psplat_command_error("%s: %s%sat %.6g %.6g %.6g: %s; the output was written all the same",
                         shown, mesh, *mesh ? " " : "", at[0], at[1], at[2], text);
}

/* Prints what of the input is not in the output. */
static void print_warnings(const arguments *a, const psplat_scene *scene) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(a->input, shown);
    for (size_t i = 0; i < scene->warning_count && !a->quiet; ++i)
        psplat_command_error("%s: %s", shown, scene->warnings[i]);
}

static void free_product(product *p) {
    psplat_scene_fallback_meshes_free(&p->scene, p->fallbacks);
    psplat_scene_gaussians_free(&p->scene, p->gaussians);
    psplat_mesh_levels_free(&p->scene, p->levels);
    psplat_scene_splats_free(&p->scene, p->splats);
    free(p->splats);
    psplat_scene_free(&p->scene);
    psplat_scene_report_free(&p->report);
    psplat_page_close(&p->page);
    free(p->bytes);
}

/* Writes the report, or what went wrong, for the report of several inputs. */
static void take_notes(const product *p, psplat_result result, const psplat_error *error,
                       FILE *notes) {
    char *text = NULL;
    size_t size = 0;
    if (result)
        fputs(*error->text ? error->text : psplat_result_text(result), notes);
    else if (!psplat_scene_report_json(&p->scene, &p->report, &text, &size, NULL))
        fwrite(text, 1, size - 1, notes); /* without the last newline */
    free(text);
}

/* Converts one input. notes is NULL where it is the only one. */
static int run(const arguments *a, product *p, FILE *notes) {
    double start = psplat_progress_clock();
    psplat_error error = {0};
    const char *subject = NULL;
    psplat_result result = check_outputs(a, &error);
    if (!result && a->html)
        result = psplat_page_open(&p->page, a->html_source ? a->input : NULL, &error);
    if (!result) {
        result = make(a, p, &error);
        subject = result == PSPLAT_ERROR_WRITE ? a->output : a->input;
    }
    p->report.total.bytes = p->size;
    p->report.total.seconds = psplat_progress_clock() - start;
    p->report.total.peak_memory_bytes = peak_memory();
    if (!result) {
        result = write_outputs(a, p, &error);
        subject = NULL;
    }
    if (notes) take_notes(p, result, &error, notes);
    if (result) {
        int code = psplat_command_fail(subject, &error);
        return p->needed ? PSPLAT_EXIT_BUDGET : code;
    }
    print_warnings(a, &p->scene);
    print_summary(a, p);
    if (psplat_report_broken(&p->report.total) == PSPLAT_PROMISE_COUNT) return PSPLAT_EXIT_SUCCESS;
    print_broken(a, p);
    return PSPLAT_EXIT_BROKEN;
}

/* ---- several inputs -------------------------------------------------------------------------- */

static int ends_with_slash(const char *path) {
    return path[strlen(path) - 1] == '/';
}

static int is_directory(const char *path) {
    struct stat status;
    return !stat(path, &status) && S_ISDIR(status.st_mode);
}

/* Converts the input of one job; user is the arguments that all share. */
static int run_job(const void *user, const psplat_job *job, FILE *notes) {
    arguments a = *(const arguments *)user;
    a.input = job->input;
    a.output = job->output;
    a.no_summary = is_standard_output(a.report);
    a.no_progress = a.jobs > 1;
    a.report = NULL;
    product p = {0};
    int code = run(&a, &p, notes);
    free_product(&p);
    return code;
}

/* Checks, before anything is written, where the assets and the report shall go. */
static psplat_result check_several(const arguments *a, const psplat_jobs *jobs,
                                   psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; a->report && i < jobs->count && !result; ++i) {
        result = psplat_output_check(jobs->list[i].input, a->report, a->overwrite, error);
        if (result || !psplat_output_is_same(a->report, jobs->list[i].output)) continue;
        psplat_path_shorten(a->report, shown);
        result = psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s: is also an asset", shown);
    }
    if (result || is_directory(a->output) || !mkdir(a->output, 0777)) return result;
    psplat_path_shorten(a->output, shown);
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s: cannot be created: %s", shown,
                       strerror(errno));
}

static psplat_result report_several(const arguments *a, const psplat_jobs *jobs,
                                    psplat_error *error) {
    char *text = NULL;
    size_t size = 0;
    if (!a->report) return PSPLAT_OK;
    psplat_result result = psplat_jobs_report(jobs, &text, &size, error);
    if (!result) result = psplat_output_write(a->report, text, size, a->overwrite, error);
    free(text);
    return result;
}

static int run_several(const arguments *a) {
    psplat_error error = {0};
    psplat_jobs jobs = {0};
    const char **inputs = malloc((a->more.count + 1) * sizeof *inputs);
    if (!inputs) return PSPLAT_EXIT_MEMORY;
    inputs[0] = a->input;
    for (size_t i = 0; i < a->more.count; ++i) inputs[i + 1] = a->more.list[i];
    psplat_result result = psplat_jobs_make(inputs, a->more.count + 1, a->output, &jobs, &error);
    free(inputs);
    if (!result) result = check_several(a, &jobs, &error);
    if (!result) psplat_jobs_run(&jobs, a->jobs, run_job, a);
    if (!result) result = report_several(a, &jobs, &error);
    int code = result ? psplat_command_fail(NULL, &error) : psplat_jobs_code(&jobs);
    psplat_jobs_free(&jobs);
    return code;
}

int psplat_command_convert(int argc, char **argv) {
    arguments a = {.jobs = 1};
    psplat_parse parsed = parse(argc, argv, &a);
    if (parsed != PSPLAT_PARSE_OK) return (int)parsed;
    if (ends_with_slash(a.output) || (a.more.count && is_directory(a.output)))
        return a.html ? (int)refuse("html", "takes one input and OUT.glb, not a directory")
                      : run_several(&a);
    if (a.more.count)
        return (int)refuse(a.output,
                           "is one argument too many, or no directory for several inputs");
    product p = {0};
    int code = run(&a, &p, NULL);
    free_product(&p);
    return code;
}

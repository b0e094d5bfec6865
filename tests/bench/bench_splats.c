/* SPDX-License-Identifier: MIT
 *
 * bench_splats.c - prints tables of conversions: splats, errors, time and memory.
 *
 *     bench_splats [options] [MODEL...]     each model at each tolerance
 *     bench_splats --normals [MODEL...]     splats for a normal tolerance, linear against constant
 *     bench_splats --growth [MODEL]         time and memory while the model is subdivided
 *
 *     --tolerances LIST        in percent, separated by commas; 1,0.5,0.2,0.1
 *     --normal-tolerance DEG   a further bound; --normals takes a LIST, 10,5,2.5
 *     --effort N               0 ... 9, as for phongsplat convert
 *     --constant               fields without gradients
 *     --triangles N            --growth subdivides up to these; 1500000
 *     --limit SECONDS          a run that takes longer is given up; 600
 *     --folder DIRECTORY       with other models; without it, PSPLAT_BENCH_MODELS, or else the
 *                              folder shared/models beside the repository
 *     --markdown
 *
 * A model is sphere, torus, part, the name of a file in the folder, or a path. Those that are not
 * there are left out. Each run is a process of its own, so that peak memory is that of one run.
 */
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { MOST = 32 };

typedef struct options {
    const char *models[MOST];
    size_t model_count;
    double tolerances[MOST], normal_tolerances[MOST];
    size_t tolerance_count, normal_tolerance_count;
    const char *folder;
    size_t triangles;
    int effort, constant, limit, markdown, normals, growth;
} options;

static const char *const default_models[] = {
    "sphere",         "torus",         "part",       "fandisk.obj",     "stanford-bunny.obj",
    "rocker-arm.obj", "armadillo.obj", "teapot.obj", "featuretype.STL", "Duck.glb"};
static const char *const smooth_models[] = {"sphere", "torus", "rocker-arm.obj",
                                            "stanford-bunny.obj", "teapot.obj"};
static const char *const growth_models[] = {"armadillo.obj"};
/* A distance tolerance in percent that is too loose to bind where normals are measured. */
static const double loose_tolerance = 2;

/* ---- meshes -------------------------------------------------------------------------------- */

static void *allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (!memory) exit(1);
    return memory;
}

typedef struct edge {
    uint32_t low, high, corner;
} edge;

static int compare_edges(const void *left, const void *right) {
    const edge *a = left, *b = right;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    if (a->high != b->high) return a->high < b->high ? -1 : 1;
    return a->corner < b->corner ? -1 : a->corner > b->corner;
}

/* Appends the middle of each edge to the vertices. Stores for each corner the middle of the edge
 * that starts there. */
static void add_middles(psplat_mesh *mesh, uint32_t *middles) {
    size_t corners = 3 * mesh->triangle_count;
    edge *edges = allocate(corners, sizeof *edges);
    for (uint32_t i = 0; i < corners; ++i) {
        uint32_t a = mesh->triangles[i], b = mesh->triangles[i % 3 == 2 ? i - 2 : i + 1];
        edges[i] = (edge){a < b ? a : b, a < b ? b : a, i};
    }
    qsort(edges, corners, sizeof *edges, compare_edges);
    double *positions = allocate(mesh->vertex_count + corners, 3 * sizeof *positions);
    memcpy(positions, mesh->positions, mesh->vertex_count * 3 * sizeof *positions);
    for (size_t i = 0; i < corners; ++i) {
        int is_new = !i || edges[i].low != edges[i - 1].low || edges[i].high != edges[i - 1].high;
        const double *a = positions + 3 * (size_t)edges[i].low;
        const double *b = positions + 3 * (size_t)edges[i].high;
        for (size_t k = 0; k < 3 && is_new; ++k)
            positions[3 * mesh->vertex_count + k] = 0.5 * (a[k] + b[k]);
        if (is_new) ++mesh->vertex_count;
        middles[edges[i].corner] = (uint32_t)mesh->vertex_count - 1;
    }
    free(mesh->positions);
    free(edges);
    mesh->positions = positions;
}

/* Splits each triangle into four. What corners and triangles carry is dropped. */
static void subdivide(psplat_mesh *mesh) {
    uint32_t *middles = allocate(3 * mesh->triangle_count, sizeof *middles);
    uint32_t *triangles = allocate(12 * mesh->triangle_count, sizeof *triangles);
    add_middles(mesh, middles);
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *v = mesh->triangles + 3 * t, *m = middles + 3 * t;
        const uint32_t four[12] = {v[0], m[0], m[2], m[0], v[1], m[1],
                                   m[2], m[1], v[2], m[0], m[1], m[2]};
        memcpy(triangles + 12 * t, four, sizeof four);
    }
    free(mesh->triangles);
    free(middles);
    mesh->triangles = triangles;
    mesh->triangle_count *= 4;
    free(mesh->corner_normals);
    free(mesh->corner_colors);
    free(mesh->groups);
    mesh->corner_normals = mesh->corner_colors = NULL;
    mesh->groups = NULL;
}

/* Subdivides an octahedron to 32768 triangles and moves its vertices to the unit sphere. */
static void make_sphere(psplat_mesh *mesh) {
    static const double corners[6][3] = {{1, 0, 0},  {0, 1, 0}, {-1, 0, 0},
                                         {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    *mesh = (psplat_mesh){.positions = allocate(18, sizeof(double)),
                          .triangles = allocate(24, sizeof(uint32_t)),
                          .vertex_count = 6,
                          .triangle_count = 8};
    memcpy(mesh->positions, corners, sizeof corners);
    for (uint32_t t = 0; t < 8; ++t) {
        uint32_t a = t % 4, b = (t + 1) % 4, top = 4 + t / 4;
        const uint32_t corner[3] = {t < 4 ? a : b, t < 4 ? b : a, top};
        memcpy(mesh->triangles + 3 * t, corner, sizeof corner);
    }
    for (int i = 0; i < 6; ++i) {
        subdivide(mesh);
        for (size_t v = 0; v < mesh->vertex_count; ++v) {
            double *p = mesh->positions + 3 * v,
                   length = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
            for (int k = 0; k < 3; ++k) p[k] /= length;
        }
    }
}

/* Makes a torus of radii 1 and 0.4 with 36864 triangles. */
static void make_torus(psplat_mesh *mesh) {
    enum { RING = 192, TUBE = 96, COUNT = RING * TUBE };
    const double turn = 6.28318530717958648;
    *mesh = (psplat_mesh){.positions = allocate(COUNT, 3 * sizeof(double)),
                          .triangles = allocate(COUNT, 6 * sizeof(uint32_t)),
                          .vertex_count = COUNT,
                          .triangle_count = 2 * COUNT};
    for (uint32_t i = 0; i < COUNT; ++i) {
        uint32_t ring = i / TUBE, tube = i % TUBE;
        double s = turn * ring / RING, t = turn * tube / TUBE, *p = mesh->positions + 3 * (size_t)i;
        p[0] = (1 + 0.4 * cos(t)) * cos(s), p[1] = (1 + 0.4 * cos(t)) * sin(s), p[2] = 0.4 * sin(t);
        uint32_t a = i, b = (ring + 1) % RING * TUBE + tube, up = (tube + 1) % TUBE;
        uint32_t c = (ring + 1) % RING * TUBE + up, d = ring * TUBE + up;
        const uint32_t two[6] = {a, b, c, a, c, d};
        memcpy(mesh->triangles + 6 * (size_t)i, two, sizeof two);
    }
}

/* Writes the path of a model that is not made here. */
static void model_path(const options *o, const char *model, char *path, size_t size) {
    if (!strcmp(model, "part"))
        snprintf(path, size, "%s/samples/models/part.obj", PSPLAT_SOURCE_DIR);
    else if (strchr(model, '/') || !access(model, R_OK))
        snprintf(path, size, "%s", model);
    else
        snprintf(path, size, "%s/%s", o->folder, model);
}

/* Returns the model's name without the folder. */
static const char *model_name(const char *model) {
    const char *slash = strrchr(model, '/');
    return slash ? slash + 1 : model;
}

static int is_made(const char *model) {
    return !strcmp(model, "sphere") || !strcmp(model, "torus");
}

static int is_there(const options *o, const char *model) {
    char path[1024];
    model_path(o, model, path, sizeof path);
    return is_made(model) || !access(path, R_OK);
}

static psplat_result get_model(const options *o, const char *model, psplat_mesh *mesh,
                               psplat_error *error) {
    char path[1024];
    model_path(o, model, path, sizeof path);
    if (!is_made(model)) return psplat_mesh_read(path, mesh, error);
    if (!strcmp(model, "sphere"))
        make_sphere(mesh);
    else
        make_torus(mesh);
    return PSPLAT_OK;
}

/* ---- one run ------------------------------------------------------------------------------- */

typedef struct job {
    const char *model;
    int subdivisions;
    double tolerance, normal_tolerance;
    int constant;
} job;

static double seconds_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static size_t peak_memory(void) {
    size_t kilobytes = 0;
    char line[128];
    FILE *status = fopen("/proc/self/status", "r");
    while (status && fgets(line, sizeof line, status))
        if (sscanf(line, "VmHWM: %zu", &kilobytes) == 1) break;
    if (status) fclose(status);
    return kilobytes * 1024;
}

/* Converts and verifies; report's seconds are those of both, without reading. */
static psplat_result measure(const options *o, const job *j, psplat_report *report,
                             psplat_error *error) {
    psplat_mesh mesh;
    psplat_splats splats;
    psplat_result result = get_model(o, j->model, &mesh, error);
    if (result) return result;
    for (int i = 0; i < j->subdivisions; ++i) subdivide(&mesh);
    const psplat_convert_desc desc = {.tolerance_percent = j->tolerance,
                                      .normal_tolerance_degrees = j->normal_tolerance,
                                      .constant_normals = j->constant,
                                      .effort = o->effort ? o->effort : PSPLAT_EFFORT_NONE};
    double start = seconds_now();
    result = psplat_convert(&mesh, &desc, &splats, report, error);
    report->seconds = seconds_now() - start;
    report->peak_memory_bytes = peak_memory();
    if (!result) psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
    return result;
}

/* Runs a child process from start to end; its report goes through the pipe. */
static void run_child(const options *o, const job *j, int output) {
    psplat_report report = {0};
    psplat_error error = {0};
    alarm((unsigned)o->limit);
    if (measure(o, j, &report, &error)) {
        fprintf(stderr, "bench_splats: %s: %s\n", j->model, error.text);
        _exit(1);
    }
    ssize_t written = write(output, &report, sizeof report);
    _exit(written != (ssize_t)sizeof report);
}

/* Returns 1 where the run ended well and in time. */
static int run_job(const options *o, const job *j, psplat_report *report) {
    int ends[2], status = 0;
    size_t size = 0;
    fflush(stdout);
    if (pipe(ends)) return 0;
    pid_t child = fork();
    if (!child) run_child(o, j, ends[1]);
    close(ends[1]);
    for (ssize_t got = 1; child > 0 && got > 0 && size < sizeof *report; size += (size_t)got) {
        got = read(ends[0], (char *)report + size, sizeof *report - size);
        if (got < 0) break;
    }
    close(ends[0]);
    if (child < 0 || waitpid(child, &status, 0) != child) return 0;
    return size == sizeof *report && WIFEXITED(status) && !WEXITSTATUS(status);
}

/* ---- tables -------------------------------------------------------------------------------- */

typedef struct column {
    const char *head;
    int width; /* negative: aligned to the left */
} column;

typedef struct table {
    const column *columns;
    size_t count, at;
    int markdown;
} table;

static void put(table *t, const char *text) {
    const column *c = &t->columns[t->at];
    printf(t->markdown ? "| %*s " : "%*s  ", c->width, text);
    t->at = (t->at + 1) % t->count;
    if (!t->at) printf(t->markdown ? "|\n" : "\n");
}

static void put_number(table *t, const char *format, double number) {
    char text[64];
    snprintf(text, sizeof text, format, number);
    put(t, text);
}

static void put_head(table *t) {
    for (size_t i = 0; i < t->count; ++i) put(t, t->columns[i].head);
    for (size_t i = 0; i < t->count && t->markdown; ++i)
        put(t, t->columns[i].width < 0 ? "---" : "--:");
}

/* Fills the rest of a row that has no result. */
static void put_nothing(table *t) {
    while (t->at) put(t, "-");
}

static void put_lines(table *t, const psplat_report *r) {
    char text[96];
    const size_t *n = r->splats_by_clip_lines;
    snprintf(text, sizeof text, "%zu/%zu/%zu/%zu/%zu", n[0], n[1], n[2], n[3], n[4]);
    put(t, text);
}

static void put_promises(table *t, const psplat_report *r) {
    static const char *const names[] = {"coverage ", "distance ", "normal ", "crease "};
    char text[64] = "";
    for (int k = 0; k < PSPLAT_PROMISE_COUNT; ++k)
        if (r->promises[k].broken) strcat(text, names[k]);
    put(t, *text ? text : "none");
}

/* ---- the three questions -------------------------------------------------------------------- */

static void bench_models(const options *o) {
    static const column columns[] = {{"model", -18},       {"eps %", 5},    {"splats", 7},
                                     {"by lines 0-4", 24}, {"max/eps", 7},  {"uncovered", 9},
                                     {"RMS linear", 10},   {"constant", 8}, {"p95 linear", 10},
                                     {"constant", 8},      {"max deg", 7},  {"crease/eps", 10},
                                     {"broken", -10},      {"s", 7},        {"MB", 6}};
    table t = {columns, sizeof columns / sizeof *columns, 0, o->markdown};
    put_head(&t);
    for (size_t m = 0; m < o->model_count; ++m)
        for (size_t e = 0; e < o->tolerance_count; ++e) {
            psplat_report r;
            job j = {.model = o->models[m],
                     .tolerance = o->tolerances[e],
                     .normal_tolerance = o->normal_tolerance_count ? o->normal_tolerances[0] : 0,
                     .constant = o->constant};
            put(&t, model_name(j.model));
            put_number(&t, "%g", j.tolerance);
            if (!run_job(o, &j, &r)) {
                put_nothing(&t);
                continue;
            }
            put_number(&t, "%.0f", (double)r.splats);
            put_lines(&t, &r);
            put_number(&t, "%.3f", r.max_distance_percent / r.tolerance_percent);
            put_number(&t, "%.0f", (double)r.uncovered_samples);
            put_number(&t, "%.2f", r.rms_normal_degrees);
            put_number(&t, "%.2f", r.rms_normal_constant_degrees);
            put_number(&t, "%.2f", r.p95_normal_degrees);
            put_number(&t, "%.2f", r.p95_normal_constant_degrees);
            put_number(&t, "%.1f", r.max_normal_degrees);
            put_number(&t, "%.2f", r.promises[PSPLAT_PROMISE_CREASE].worst / r.tolerance_percent);
            put_promises(&t, &r);
            put_number(&t, "%.2f", r.seconds);
            put_number(&t, "%.0f", (double)r.peak_memory_bytes / 1e6);
        }
}

/* Compares linear with constant normals at normal tolerances. The distance tolerance is too loose
 * to bind, so that only the field counts. */
static void bench_normals(const options *o) {
    static const column columns[] = {{"model", -18}, {"degrees", 7}, {"linear", 7},
                                     {"max deg", 7}, {"s", 7},       {"constant", 8},
                                     {"max deg", 7}, {"s", 7},       {"constant/linear", 15}};
    table t = {columns, sizeof columns / sizeof *columns, 0, o->markdown};
    put_head(&t);
    for (size_t m = 0; m < o->model_count; ++m)
        for (size_t d = 0; d < o->normal_tolerance_count; ++d) {
            double splats[2] = {0, 0};
            put(&t, model_name(o->models[m]));
            put_number(&t, "%g", o->normal_tolerances[d]);
            for (int constant = 0; constant < 2; ++constant) {
                psplat_report r = {0};
                job j = {.model = o->models[m],
                         .tolerance = o->tolerances[0],
                         .normal_tolerance = o->normal_tolerances[d],
                         .constant = constant};
                int done = run_job(o, &j, &r);
                splats[constant] = (double)r.splats;
                put_number(&t, done ? "%.0f" : "-", splats[constant]);
                put_number(&t, done ? "%.2f" : "-", r.max_normal_degrees);
                put_number(&t, done ? "%.2f" : "-", r.seconds);
            }
            put_number(&t, splats[0] > 0 && splats[1] > 0 ? "%.2f" : "-", splats[1] / splats[0]);
        }
}

/* Measures time and memory against the number of triangles. */
static void bench_growth(const options *o) {
    static const column columns[] = {{"model", -18},      {"eps %", 5},  {"triangles", 9},
                                     {"samples", 8},      {"splats", 7}, {"s", 7},
                                     {"us/triangle", 11}, {"MB", 6}};
    table t = {columns, sizeof columns / sizeof *columns, 0, o->markdown};
    put_head(&t);
    for (size_t m = 0; m < o->model_count; ++m) {
        psplat_report r = {0};
        job j = {.model = o->models[m], .tolerance = o->tolerances[0], .constant = o->constant};
        for (int done = 1; done && 4 * r.triangles <= o->triangles; ++j.subdivisions) {
            done = run_job(o, &j, &r);
            put(&t, model_name(j.model));
            put_number(&t, "%g", j.tolerance);
            if (!done) {
                put_nothing(&t);
                break;
            }
            put_number(&t, "%.0f", (double)r.triangles);
            put_number(&t, "%.0f", (double)r.samples);
            put_number(&t, "%.0f", (double)r.splats);
            put_number(&t, "%.2f", r.seconds);
            put_number(&t, "%.2f", 1e6 * r.seconds / (double)r.triangles);
            put_number(&t, "%.0f", (double)r.peak_memory_bytes / 1e6);
        }
    }
}

/* ---- the command line ----------------------------------------------------------------------- */

static int fail(const char *what) {
    fprintf(stderr, "bench_splats: %s; the head of bench_splats.c tells what it takes\n", what);
    return 0;
}

static size_t read_list(const char *text, double numbers[MOST]) {
    size_t count = 0;
    for (char *end; *text && count < MOST; text = *end == ',' ? end + 1 : end) {
        numbers[count++] = strtod(text, &end);
        if (end == text || (*end && *end != ',') || !(numbers[count - 1] > 0)) return 0;
    }
    return count;
}

static int read_value(options *o, const char *name, const char *value) {
    if (!strcmp(name, "--tolerances")) {
        o->tolerance_count = read_list(value, o->tolerances);
        return o->tolerance_count > 0;
    }
    if (!strcmp(name, "--normal-tolerance")) {
        o->normal_tolerance_count = read_list(value, o->normal_tolerances);
        return o->normal_tolerance_count > 0;
    }
    if (!strcmp(name, "--folder"))
        o->folder = value;
    else if (!strcmp(name, "--effort"))
        o->effort = atoi(value);
    else if (!strcmp(name, "--limit"))
        o->limit = atoi(value);
    else if (!strcmp(name, "--triangles"))
        o->triangles = (size_t)strtoull(value, NULL, 10);
    else
        return 0;
    return o->effort >= 0 && o->effort <= 9 && o->limit > 0;
}

static int *find_flag(options *o, const char *name) {
    return !strcmp(name, "--markdown")   ? &o->markdown
           : !strcmp(name, "--normals")  ? &o->normals
           : !strcmp(name, "--growth")   ? &o->growth
           : !strcmp(name, "--constant") ? &o->constant
                                         : NULL;
}

static int read_arguments(options *o, int argc, char **argv) {
    for (int i = 1; i < argc; ++i) {
        int *flag = find_flag(o, argv[i]);
        if (flag) {
            *flag = 1;
        } else if (argv[i][0] == '-') {
            if (i + 1 == argc || !read_value(o, argv[i], argv[i + 1])) return fail(argv[i]);
            ++i;
        } else if (o->model_count == MOST || !is_there(o, argv[i])) {
            return fail(argv[i]);
        } else {
            o->models[o->model_count++] = argv[i];
        }
    }
    return 1;
}

static void add_defaults(options *o) {
    static const double tolerances[] = {1, 0.5, 0.2, 0.1}, degrees[] = {10, 5, 2.5};
    const char *const *models = o->normals  ? smooth_models
                                : o->growth ? growth_models
                                            : default_models;
    size_t count = o->normals ? 5 : o->growth ? 1 : 10;
    int is_chosen = o->model_count > 0;
    for (size_t i = 0; i < count && !is_chosen; ++i)
        if (is_there(o, models[i])) o->models[o->model_count++] = models[i];
    if (!o->tolerance_count && o->normals) o->tolerances[o->tolerance_count++] = loose_tolerance;
    if (!o->tolerance_count) {
        memcpy(o->tolerances, tolerances, sizeof tolerances);
        o->tolerance_count = 4;
    }
    if (!o->normal_tolerance_count && o->normals) {
        memcpy(o->normal_tolerances, degrees, sizeof degrees);
        o->normal_tolerance_count = 3;
    }
}

int main(int argc, char **argv) {
    const char *folder = getenv("PSPLAT_BENCH_MODELS");
    options o = {.folder = folder ? folder : PSPLAT_SOURCE_DIR "/../shared/models",
                 .effort = PSPLAT_DEFAULT_EFFORT,
                 .limit = 600,
                 .triangles = 1500000};
    if (!read_arguments(&o, argc, argv)) return 1;
    add_defaults(&o);
    if (o.normals)
        bench_normals(&o);
    else if (o.growth)
        bench_growth(&o);
    else
        bench_models(&o);
    return 0;
}

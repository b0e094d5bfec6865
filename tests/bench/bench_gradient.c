/* SPDX-License-Identifier: MIT
 *
 * bench_gradient.c - measures what the gradient of a normal field is worth: it compares constant
 * fields, the diagonal gradient of BSK04 eq. 2, and the full symmetric one of spec 3.5.
 *
 *     bench_gradient [MODEL...]
 *
 * The first models are a sphere, a torus and a saddle; the given ones follow. Each takes a minute.
 *
 * The first line of a model gives the errors of the normals, root mean square and 95th percentile
 * in degrees, that the three leave on the splats of a conversion at the default tolerance; each is
 * fitted to the same samples. Then come the splats that each needs for a greatest error. They are
 * counted by a simpler greedy cover without clip lines and with a loose distance tolerance, so that
 * only the field is compared: a splat takes the samples around an uncovered one, out to where the
 * bound breaks, in an ellipse whose axes are the directions of curvature. That is the best case for
 * a diagonal gradient.
 */
#include "features/surface_build.h"
#include "base/random.h"
#include "base/region.h"
#include "base/vector.h"
#include "features/surface.h"
#include "fit/normal_field.h"
#include "features/samples.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "splats/splats.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 20000, BISECTIONS = 7, BOUNDS = 3 };
typedef enum kind { CONSTANT, DIAGONAL, FULL, KINDS } kind;

static const double pi = 3.14159265358979323846;
static const double bounds[BOUNDS] = {10, 5, 2.5};
/* The distance tolerance in parts of the diagonal: so loose that the normals are what limits a
 * splat. */
static const double height_tolerance = 0.015;
static const double least_cosine = 0.25;
static const double greatest_stretch = 8;

static void check(psplat_result result, const psplat_error *error) {
    if (result == PSPLAT_OK) return;
    fprintf(stderr, "bench_gradient: %s\n", error ? error->text : psplat_result_text(result));
    exit(1);
}

static void *allocate(size_t count, size_t size) {
    void *memory = calloc(count + 1, size);
    if (!memory) check(PSPLAT_ERROR_MEMORY, NULL);
    return memory;
}

/* ---- fields -------------------------------------------------------------------------------- */

/* The samples of one splat: parameters and local normals, of the whole and of one axis. */
typedef struct chart {
    double (*uv)[2], (*xy)[2], (*axis_uv)[2], (*axis_xy)[2];
    uint32_t *chosen;
    size_t count;
    double radius[2];
} chart;

static chart chart_create(size_t capacity) {
    size_t pair = sizeof(double[2]);
    return (chart){allocate(capacity, pair),
                   allocate(capacity, pair),
                   allocate(capacity, pair),
                   allocate(capacity, pair),
                   allocate(capacity, sizeof(uint32_t)),
                   0,
                   {0, 0}};
}

static void chart_free(chart *c) {
    free(c->uv);
    free(c->xy);
    free(c->axis_uv);
    free(c->axis_xy);
    free(c->chosen);
}

/* Fits BSK04 eq. 3 and 4 separately: one fit uses neither v nor y, the other neither u nor x. */
static void fit_diagonal(const chart *c, double field[5]) {
    field[4] = 0;
    for (int axis = 0; axis < 2; ++axis) {
        double half[5];
        for (size_t i = 0; i < c->count; ++i)
            for (int k = 0; k < 2; ++k) {
                c->axis_uv[i][k] = k == axis ? c->uv[i][k] : 0;
                c->axis_xy[i][k] = k == axis ? c->xy[i][k] : 0;
            }
        psplat_fit_normal_field((const double(*)[2])c->axis_uv, (const double(*)[2])c->axis_xy,
                                c->count, c->radius, half);
        field[axis] = half[axis];
        field[2 + axis] = half[2 + axis];
    }
}

static void fit_field(const chart *c, kind kind, double field[5]) {
    memset(field, 0, 5 * sizeof *field);
    if (kind == DIAGONAL) fit_diagonal(c, field);
    if (kind == FULL)
        psplat_fit_normal_field((const double(*)[2])c->uv, (const double(*)[2])c->xy, c->count,
                                c->radius, field);
    for (size_t i = 0; kind == CONSTANT && i < c->count; ++i)
        for (int k = 0; k < 2; ++k) field[k] += c->xy[i][k] / (double)c->count;
}

/* Returns the degrees between sample i's normal and the field's. */
static double error_at(const chart *c, const double field[5], size_t i) {
    double found[3] = {0, 0, 1}, true_normal[3] = {c->xy[i][0], c->xy[i][1], 1}, across[3];
    psplat_normal_field_at(field, c->radius, c->uv[i], found);
    cross3(across, found, true_normal);
    return atan2(length3(across), dot3(found, true_normal)) * 180 / pi;
}

static double greatest_error(const chart *c, const double field[5]) {
    double greatest = 0;
    for (size_t i = 0; i < c->count; ++i) greatest = max2(greatest, error_at(c, field, i));
    return greatest;
}

/* ---- models -------------------------------------------------------------------------------- */

static void place_torus(double s, double t, double p[3]) {
    double ring = 1 + 0.4 * cos(2 * pi * t);
    p[0] = ring * cos(2 * pi * s), p[1] = ring * sin(2 * pi * s), p[2] = 0.4 * sin(2 * pi * t);
}

/* The sphere lacks its poles, where cells of a grid have no area. */
static void place_sphere(double s, double t, double p[3]) {
    double z = 1.9 * t - 0.95, ring = sqrt(1 - z * z);
    p[0] = ring * cos(2 * pi * s), p[1] = ring * sin(2 * pi * s), p[2] = z;
}

static void place_saddle(double s, double t, double p[3]) {
    p[0] = 2 * s - 1, p[1] = 2 * t - 1, p[2] = (p[0] * p[0] - p[1] * p[1]) / 2;
}

/* Makes a grid that may close on itself: vertices of equal position become one. */
static psplat_mesh make_grid(void (*place)(double s, double t, double p[3])) {
    enum { SIDE = 200, ROW = SIDE + 1 };
    psplat_mesh mesh = {.vertex_count = ROW * ROW,
                        .positions = allocate(ROW * ROW, sizeof(double[3])),
                        .triangles = allocate((size_t)2 * SIDE * SIDE, sizeof(uint32_t[3]))};
    for (int i = 0; i < ROW * ROW; ++i)
        place((double)(i % ROW) / SIDE, (double)(i / ROW) / SIDE, mesh.positions + 3 * i);
    int turns = place != place_saddle, closes = place == place_torus;
    for (uint32_t i = 0; i < SIDE * SIDE; ++i) {
        uint32_t x = i % SIDE, y = i / SIDE;
        uint32_t right = turns && x + 1 == SIDE ? 0 : x + 1,
                 up = closes && y + 1 == SIDE ? 0 : y + 1;
        uint32_t corners[2][3] = {{y * ROW + x, y * ROW + right, up * ROW + right},
                                  {y * ROW + x, up * ROW + right, up * ROW + x}};
        memcpy(mesh.triangles + 3 * mesh.triangle_count, corners, sizeof corners);
        mesh.triangle_count += 2;
    }
    return mesh;
}

typedef struct model {
    psplat_mesh mesh;
    psplat_surface surface;
    psplat_samples samples;
} model;

static void model_sample(model *m) {
    psplat_error error;
    check(psplat_surface_build(&m->mesh, pi / 6, &m->surface, &error), &error);
    double spacing = sqrt(m->surface.area / SAMPLES);
    check(psplat_samples_draw(&m->surface, spacing, 1, &m->samples, &error), &error);
}

static void model_free(model *m) {
    psplat_samples_free(&m->samples);
    psplat_surface_free(&m->surface);
    psplat_mesh_free(&m->mesh);
}

static uint32_t patch_of(const model *m, size_t sample) {
    return m->surface.patches[m->samples.triangles[sample]];
}

static void normal_of(const model *m, size_t sample, double normal[3]) {
    for (size_t k = 0; k < 3; ++k) normal[k] = (double)m->samples.normals[3 * sample + k];
}

/* Fills parameters and local normals of the chosen samples. Returns the range of their heights, or
 * HUGE_VAL where a normal turns away. */
static double chart_fill(const model *m, const psplat_region *region, chart *c) {
    double low = 0, high = 0;
    memcpy(c->radius, region->radius, sizeof c->radius);
    for (size_t i = 0; i < c->count; ++i) {
        double n[3], uvh[3];
        normal_of(m, c->chosen[i], n);
        psplat_region_local(region, m->samples.positions + 3 * (size_t)c->chosen[i], uvh);
        memcpy(c->uv[i], uvh, sizeof c->uv[i]);
        double cosine = dot3(n, region->n);
        if (cosine < least_cosine) return HUGE_VAL;
        c->xy[i][0] = dot3(n, region->u) / cosine, c->xy[i][1] = dot3(n, region->v) / cosine;
        low = min2(low, uvh[2]), high = max2(high, uvh[2]);
    }
    return (high - low) / 2;
}

/* ---- the splats of a conversion ------------------------------------------------------------ */

static void choose_inside(const model *m, const psplat_region *region, chart *c) {
    c->count = 0;
    for (size_t i = 0; i < m->samples.count; ++i) {
        double uvh[3], n[3];
        psplat_region_local(region, m->samples.positions + 3 * i, uvh);
        normal_of(m, i, n);
        if (fabs(uvh[2]) <= 0.005 * m->surface.diagonal && dot3(n, region->n) > least_cosine &&
            psplat_region_contains(region, uvh, 1, 0))
            c->chosen[c->count++] = (uint32_t)i;
    }
}

static int compare_doubles(const void *left, const void *right) {
    const double *a = left, *b = right;
    return *a < *b ? -1 : *a > *b;
}

static void print_errors(double *errors, size_t count) {
    double squares = 0;
    qsort(errors, count, sizeof *errors, compare_doubles);
    for (size_t i = 0; i < count; ++i) squares += errors[i] * errors[i];
    printf("  %6.2f %6.2f", sqrt(squares / (double)count), errors[(size_t)(0.95 * (double)count)]);
}

static void measure_conversion(const model *m, const char *name) {
    psplat_error error;
    psplat_splats splats;
    check(psplat_convert(&m->mesh, NULL, &splats, NULL, &error), &error);
    psplat_region *regions = psplat_splat_regions(&splats);
    if (!regions) check(PSPLAT_ERROR_MEMORY, NULL);
    chart c = chart_create(m->samples.count);
    double *errors[KINDS];
    size_t capacity = 16 * m->samples.count, count = 0;
    for (int k = 0; k < KINDS; ++k) errors[k] = allocate(capacity, sizeof(double));
    for (size_t i = 0; i < splats.count; ++i) {
        choose_inside(m, &regions[i], &c);
        chart_fill(m, &regions[i], &c);
        /* Too few to tell the fields apart. */
        if (c.count < 6 || count + c.count > capacity) continue;
        for (int k = 0; k < KINDS; ++k) {
            double field[5];
            fit_field(&c, (kind)k, field);
            for (size_t s = 0; s < c.count; ++s) errors[k][count + s] = error_at(&c, field, s);
        }
        count += c.count;
    }
    printf("%-16s %6zu splats ", name, splats.count);
    for (int k = 0; k < KINDS && count; ++k) print_errors(errors[k], count);
    printf("\n");
    for (int k = 0; k < KINDS; ++k) free(errors[k]);
    chart_free(&c);
    free(regions);
    psplat_splats_free(&splats);
}

/* ---- splats for a bound -------------------------------------------------------------------- */

/* A splat that grows around a sample: the axes of its metric, and the lengths of the metric's unit
 * along u and v. */
typedef struct growth {
    const model *m;
    kind kind;
    double bound; /* in degrees */
    size_t seed;
    double u[3], v[3], n[3], stretch[2];
} growth;

static double metric_distance(const growth *g, size_t sample) {
    double d[3];
    sub3(d, g->m->samples.positions + 3 * sample, g->m->samples.positions + 3 * g->seed);
    double u = dot3(d, g->u) / g->stretch[0], v = dot3(d, g->v) / g->stretch[1];
    return hypot(hypot(u, v), dot3(d, g->n) / g->stretch[0]);
}

static void choose_reach(const growth *g, double reach, chart *c) {
    c->count = 0;
    for (size_t i = 0; i < g->m->samples.count; ++i) {
        double n[3];
        normal_of(g->m, i, n);
        if (patch_of(g->m, i) == patch_of(g->m, g->seed) && dot3(n, g->n) > least_cosine &&
            metric_distance(g, i) <= reach)
            c->chosen[c->count++] = (uint32_t)i;
    }
}

/* Encloses the chosen samples by an ellipse whose axes are those of the metric, projected to the
 * plane across their mean normal. */
static psplat_region enclose(const growth *g, const chart *c) {
    psplat_region region = {.radius = {g->stretch[0], g->stretch[1]}};
    for (size_t i = 0; i < c->count; ++i) {
        double n[3];
        normal_of(g->m, c->chosen[i], n);
        mad3(region.n, 1, n);
        mad3(region.center, 1 / (double)c->count,
             g->m->samples.positions + 3 * (size_t)c->chosen[i]);
    }
    normalize3(region.n);
    cross3(region.v, region.n, g->u);
    normalize3(region.v);
    cross3(region.u, region.v, region.n);
    double reach = 0;
    for (size_t i = 0; i < c->count; ++i) {
        double uvh[3];
        psplat_region_local(&region, g->m->samples.positions + 3 * (size_t)c->chosen[i], uvh);
        reach = max2(reach, hypot(uvh[0], uvh[1]));
    }
    for (int k = 0; k < 2; ++k) region.radius[k] *= max2(reach, 1e-12);
    return region;
}

/* Returns whether a field of this kind keeps the bounds on the samples within reach. */
static int keeps(const growth *g, double reach, chart *c) {
    double field[5];
    choose_reach(g, reach, c);
    if (!c->count) return 0;
    psplat_region region = enclose(g, c);
    if (chart_fill(g->m, &region, c) > height_tolerance * g->m->surface.diagonal) return 0;
    fit_field(c, g->kind, field);
    return greatest_error(c, field) <= g->bound;
}

/* Finds the largest reach by doubling and bisection. Returns 0 where not even the seed's neighbours
 * keep the bounds. */
static double grow(const growth *g, chart *c) {
    double kept = 0, broken = 2 * g->m->samples.spacing;
    while (broken < g->m->surface.diagonal && keeps(g, broken, c)) kept = broken, broken *= 2;
    for (int step = 0; step < BISECTIONS; ++step) {
        double middle = (kept + broken) / 2;
        if (keeps(g, middle, c))
            kept = middle;
        else
            broken = middle;
    }
    return kept;
}

/* Turns the metric to the directions of curvature of the samples in the chart. The direction of the
 * lesser curvature comes first, so that the greater radius does. */
static void adapt(growth *g, const psplat_region *region, const chart *c) {
    double field[5];
    fit_field(c, FULL, field);
    double a = field[2] / c->radius[0], b = field[4] / c->radius[0], d = field[3] / c->radius[1];
    double turn = 0.5 * atan2(2 * b, a - d), spread = hypot((a - d) / 2, b), mean = (a + d) / 2;
    double first = fabs(mean + spread), second = fabs(mean - spread);
    if (first > second) turn += pi / 2;
    double ratio = sqrt(max2(first, second) / max2(min2(first, second), 1e-12 * (first + second)));
    if (!(ratio >= 1)) ratio = 1; /* there is no curvature at all */
    memcpy(g->n, region->n, sizeof g->n);
    for (int k = 0; k < 3; ++k) g->u[k] = cos(turn) * region->u[k] + sin(turn) * region->v[k];
    cross3(g->v, g->n, g->u);
    g->stretch[0] = min2(ratio, greatest_stretch), g->stretch[1] = 1;
}

/* Covers the samples that a splat around the seed can cover. Returns how many of them were
 * uncovered before. */
static size_t take(growth *g, chart *c, uint8_t *covered) {
    normal_of(g->m, g->seed, g->n);
    perpendicular3(g->u, g->n);
    cross3(g->v, g->n, g->u);
    g->stretch[0] = g->stretch[1] = 1;
    choose_reach(g, max2(grow(g, c), g->m->samples.spacing), c);
    psplat_region region = enclose(g, c);
    chart_fill(g->m, &region, c);
    if (c->count >= 6) {
        adapt(g, &region, c);
        choose_reach(g, grow(g, c), c);
    }
    size_t gained = !covered[g->seed];
    covered[g->seed] = 1;
    for (size_t i = 0; i < c->count; ++i) {
        gained += !covered[c->chosen[i]];
        covered[c->chosen[i]] = 1;
    }
    return gained;
}

static size_t count_splats(const model *m, kind kind, double bound) {
    growth g = {.m = m, .kind = kind, .bound = bound};
    chart c = chart_create(m->samples.count);
    uint8_t *covered = allocate(m->samples.count, 1);
    size_t open = m->samples.count, splats = 0;
    uint64_t random = 1;
    while (open) {
        g.seed = (size_t)(psplat_random_unit(&random) * (double)m->samples.count);
        while (covered[g.seed]) g.seed = (g.seed + 1) % m->samples.count;
        open -= take(&g, &c, covered);
        ++splats;
    }
    free(covered);
    chart_free(&c);
    return splats;
}

static void measure(model *m, const char *name) {
    model_sample(m);
    measure_conversion(m, name);
    for (int i = 0; i < BOUNDS; ++i) {
        printf("%-16s %4.1f degrees ", "", bounds[i]);
        for (int k = 0; k < KINDS; ++k) {
            printf("  %13zu", count_splats(m, (kind)k, bounds[i]));
            fflush(stdout);
        }
        printf("\n");
    }
    model_free(m);
}

int main(int argc, char **argv) {
    static void (*const places[])(double, double, double[3]) = {place_sphere, place_torus,
                                                                place_saddle};
    static const char *const names[] = {"sphere", "torus", "saddle"};
    printf("%34s%15s%15s\n", "constant", "diagonal", "full");
    for (int i = 0; i < 3; ++i) {
        model m = {.mesh = make_grid(places[i])};
        measure(&m, names[i]);
    }
    for (int i = 1; i < argc; ++i) {
        model m = {0};
        psplat_error error;
        const char *slash = strrchr(argv[i], '/');
        check(psplat_mesh_read(argv[i], &m.mesh, &error), &error);
        measure(&m, slash ? slash + 1 : argv[i]);
    }
    return 0;
}

/* SPDX-License-Identifier: MIT
 *
 * bench_selection.c - measures what exchange and relaxation save over the greedy cover, and what
 * united covariances save over summing samples anew.
 *
 *     bench_selection [--tolerance PERCENT] [MODEL...]
 *
 * The tolerance is 0.5 where none is given. Without models it takes samples/models/part.obj, and
 * fandisk.obj and stanford-bunny.obj of PSPLAT_BENCH_MODELS or else of the folder shared/models
 * beside the repository; those that are not there are left out.
 *
 * A row gives the number of splats and the CPU seconds of all threads, without sampling, for the
 * greedy cover, then with three rounds of exchange, each with a new random candidate for every
 * splat, and then with relaxation as well. Holes are not repaired in any of them.
 *
 * The line below it gives the microseconds to fit a plane to the samples that only two neighbours
 * of the last selection cover: by uniting the sums of their parts (without and with making these
 * sums, once for each part), and by summing up all samples of every pair. The planes must agree to
 * 1e-9 of the diagonal.
 */
#include "base/covariance.h"
#include "base/random.h"
#include "base/vector.h"
#include "fit/candidate.h"
#include "fit/fit_context.h"
#include "features/samples.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "select/conversion.h"
#include "select/greedy_cover.h"
#include "select/local_search.h"
#include "select/relax.h"
#include "select/sample_spacing.h"
#include "select/selection.h"
#include "splats/splats.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { ROUNDS = 3, MOVES = 5, REPEATS = 200 };

static void fail(const char *what, const char *why) {
    fprintf(stderr, "bench_selection: %s: %s\n", what, why);
    exit(1);
}

static void check(psplat_result result, const char *what) {
    if (result) fail(what, psplat_result_text(result));
}

static double cpu_seconds(void) {
    return (double)clock() / CLOCKS_PER_SEC;
}

/* ---- selections ------------------------------------------------------------------------------ */

/* Adds a candidate around a random sample of each splat. */
static void grow_pool(psplat_conversion *c, uint64_t random) {
    size_t count = 0;
    uint32_t *seeds = malloc((c->selection.count + 1) * sizeof *seeds);
    if (!seeds) fail("pool", "out of memory");
    for (size_t i = 0; i < c->selection.count; ++i) {
        const psplat_candidate *p = &c->selection.candidates[i];
        if (p->taken && p->covered_count)
            seeds[count++] = p->covered[psplat_random_next(&random) % p->covered_count];
    }
    const psplat_fit_context context = psplat_conversion_context(c);
    check(psplat_selection_grow(&context, seeds, count, &c->selection), "pool");
    free(seeds);
}

/* Selects anew and returns how many splats are taken. */
static size_t choose(psplat_conversion *c, int exchange, int relax) {
    psplat_local_search_desc what = {.samples = &c->samples, .focus = c->samples.count};
    psplat_selection_free(&c->selection);
    const psplat_fit_context context = psplat_conversion_context(c);
    check(psplat_greedy_cover(&context, c->desc, &c->selection, NULL), "cover");
    if (exchange) check(psplat_local_search(&c->selection, &what), "exchange");
    for (int round = 0; exchange && round < ROUNDS; ++round) {
        what.seed = 1000 + (uint64_t)round;
        what.moves = MOVES * psplat_selection_taken(&c->selection);
        what.axis = round % 3;
        grow_pool(c, what.seed);
        if (relax) check(psplat_relax(c), "relaxation");
        check(psplat_local_search(&c->selection, &what), "exchange");
    }
    return psplat_selection_taken(&c->selection);
}

/* ---- planes of pairs ------------------------------------------------------------------------- */

/* The samples that exactly one candidate (first == second) or exactly two cover, and the sums over
 * them. */
typedef struct part {
    uint32_t first, second, sample;
} part;

typedef struct group {
    const part *begin, *end;
    psplat_covariance sums; /* relative to the centre of the first candidate */
} group;

typedef struct groups {
    const psplat_conversion *c;
    part *parts;
    group *groups;
    const group **cells; /* one for each candidate, or NULL */
    size_t count, pairs;
} groups;

static int compare_parts(const void *left, const void *right) {
    const part *a = left, *b = right;
    if (a->first != b->first) return a->first < b->first ? -1 : 1;
    if (a->second != b->second) return a->second < b->second ? -1 : 1;
    return a->sample < b->sample ? -1 : a->sample > b->sample;
}

static int is_pair(const group *g) {
    return g->begin->first != g->begin->second;
}

static const double *origin_of(const groups *all, uint32_t candidate) {
    return all->c->selection.candidates[candidate].region.center;
}

static void add_samples(const groups *all, const group *g, const double origin[3],
                        psplat_covariance *sums) {
    const psplat_samples *samples = &all->c->samples;
    for (const part *at = g ? g->begin : NULL; g && at < g->end; ++at) {
        double p[3], n[3];
        sub3(p, samples->positions + 3 * (size_t)at->sample, origin);
        for (size_t k = 0; k < 3; ++k) n[k] = (double)samples->normals[3 * (size_t)at->sample + k];
        psplat_covariance_add(sums, p, n);
    }
}

static groups find_groups(const psplat_conversion *c) {
    size_t samples = c->samples.count, count = 0;
    uint32_t *covers = calloc(samples + 1, sizeof *covers);
    groups all = {.c = c,
                  .parts = calloc(samples + 1, sizeof *all.parts),
                  .groups = calloc(samples + 1, sizeof *all.groups),
                  .cells = calloc(c->selection.count + 1, sizeof *all.cells)};
    if (!covers || !all.parts || !all.groups || !all.cells) fail("pairs", "out of memory");
    for (uint32_t i = 0; i < c->selection.count; ++i) {
        const psplat_candidate *p = &c->selection.candidates[i];
        for (size_t k = 0; p->taken && k < p->covered_count; ++k) {
            part *at = &all.parts[p->covered[k]];
            if (!covers[p->covered[k]]++) *at = (part){i, i, p->covered[k]};
            at->second = i;
        }
    }
    for (size_t i = 0; i < samples; ++i)
        if (covers[i] == 1 || covers[i] == 2) all.parts[count++] = all.parts[i];
    qsort(all.parts, count, sizeof *all.parts, compare_parts);
    for (const part *at = all.parts; at < all.parts + count;) {
        group *g = &all.groups[all.count++];
        g->begin = at;
        while (at < all.parts + count && at->first == g->begin->first &&
               at->second == g->begin->second)
            ++at;
        g->end = at;
        if (is_pair(g))
            ++all.pairs;
        else
            all.cells[g->begin->first] = g;
    }
    free(covers);
    return all;
}

static void sum_up(groups *all) {
    for (size_t i = 0; i < all->count; ++i) {
        all->groups[i].sums = (psplat_covariance){0};
        add_samples(all, &all->groups[i], origin_of(all, all->groups[i].begin->first),
                    &all->groups[i].sums);
    }
}

/* Fits the planes of all pairs, relative to the centres of their first candidates. */
static void fit_pairs(const groups *all, int united, psplat_plane *planes) {
    for (size_t i = 0; i < all->count; ++i) {
        const group *pair = &all->groups[i];
        if (!is_pair(pair)) continue;
        uint32_t first = pair->begin->first, second = pair->begin->second;
        const group *cells[2] = {all->cells[first], all->cells[second]};
        psplat_covariance sums = {0};
        if (united) {
            sums = pair->sums;
            if (cells[0]) psplat_covariance_unite(&sums, &cells[0]->sums);
            if (cells[1]) {
                psplat_covariance moved = cells[1]->sums;
                double d[3];
                sub3(d, origin_of(all, first), origin_of(all, second));
                psplat_covariance_move(&moved, d);
                psplat_covariance_unite(&sums, &moved);
            }
        } else {
            add_samples(all, pair, origin_of(all, first), &sums);
            for (int k = 0; k < 2; ++k) add_samples(all, cells[k], origin_of(all, first), &sums);
        }
        psplat_covariance_fit(&sums, planes++);
    }
}

/* Returns the greatest distance between two planes, measured at the middle of the points and at the
 * end of their spread. */
static double difference(const psplat_plane *a, const psplat_plane *b) {
    double mean[3], normal[3];
    sub3(mean, a->mean, b->mean);
    sub3(normal, a->n, b->n);
    return max2(length3(mean), length3(normal) * sqrt(a->variance[0]));
}

/* ---- rows ----------------------------------------------------------------------------------- */

static void put_planes(const psplat_conversion *c, const char *name) {
    groups all = find_groups(c);
    psplat_plane *planes[2];
    double seconds[3] = {0}, greatest = 0; /* united, summed anew, and making the sums */
    for (int k = 0; k < 2; ++k)
        if (!(planes[k] = calloc(all.pairs + 1, sizeof **planes))) fail(name, "out of memory");
    for (int repeat = 0; repeat < REPEATS; ++repeat) {
        double start = cpu_seconds();
        sum_up(&all);
        seconds[2] += cpu_seconds() - start;
        for (int k = 0; k < 2; ++k) {
            start = cpu_seconds();
            fit_pairs(&all, !k, planes[k]);
            seconds[k] += cpu_seconds() - start;
        }
    }
    for (size_t i = 0; i < all.pairs; ++i)
        greatest = max2(greatest, difference(&planes[0][i], &planes[1][i]));
    if (greatest > 1e-9 * c->surface.diagonal) fail(name, "planes differ");
    double scale = 1e6 / REPEATS / (double)all.pairs, made = seconds[0] + seconds[2];
    if (all.pairs)
        printf("  planes of %zu pairs: united %.2f us (with the sums %.2f), anew %.2f us: "
               "%.1f times (%.1f)\n",
               all.pairs, scale * seconds[0], scale * made, scale * seconds[1],
               seconds[1] / seconds[0], seconds[1] / made);
    for (int k = 0; k < 2; ++k) free(planes[k]);
    free(all.parts);
    free(all.groups);
    free(all.cells);
}

static void bench(const char *path, double percent) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    psplat_mesh mesh;
    psplat_error error;
    psplat_splats splats = {0};
    const psplat_convert_desc desc = {.tolerance_percent = percent};
    psplat_conversion c = {.desc = &desc, .splats = &splats, .is_fitted = 1};
    if (psplat_mesh_read(path, &mesh, &error) || psplat_conversion_begin(&c, &mesh, &error) ||
        psplat_draw_samples_for_limits(&c, &error))
        fail(path, error.text);
    printf("%-20s %8zu", name, c.samples.count);
    for (int way = 0; way < 3; ++way) {
        double start = cpu_seconds();
        size_t taken = choose(&c, way > 0, way > 1);
        printf("  %8zu %7.2f", taken, cpu_seconds() - start);
    }
    printf("\n");
    put_planes(&c, name);
    fflush(stdout);
    psplat_conversion_free(&c);
    psplat_mesh_free(&mesh);
}

/* Measures a default model where it is there. */
static void bench_default(const char *folder, const char *name, double percent) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    if (!file) return;
    fclose(file);
    bench(path, percent);
}

int main(int argc, char **argv) {
    const char *folder = getenv("PSPLAT_BENCH_MODELS");
    double percent = 0.5;
    int first = 1;
    if (argc > 2 && !strcmp(argv[1], "--tolerance")) {
        percent = strtod(argv[2], NULL);
        first = 3;
    }
    if (!(percent > 0)) fail("--tolerance", "expects a positive number");
    printf("%-20s %8s  %16s  %16s  %16s\n", "splats and CPU s", "samples", "greedy", "+ exchange",
           "+ relaxation");
    for (int i = first; i < argc; ++i) bench(argv[i], percent);
    if (first < argc) return 0;
    if (!folder) folder = PSPLAT_SOURCE_DIR "/../shared/models";
    bench_default(PSPLAT_SOURCE_DIR "/samples/models", "part.obj", percent);
    bench_default(folder, "fandisk.obj", percent);
    bench_default(folder, "stanford-bunny.obj", percent);
    return 0;
}

/* SPDX-License-Identifier: MIT
 *
 * test_written_seams.c - tests of seams on their way through files: in floats, in integers and in
 * streams, each splat comes back with its lines, of which the seams are the last, and files state
 * seams only where there are some. Splats are the random ones of writer_fixture.h.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "near.h"
#include "export/glb_writer.h"
#include "export/meshopt_codec.h"
#include "splats/splats.h"
#include "writer_fixture.h"

/* How much a number of a line may differ: a few roundings of floats of up to 4. Lines on the grid
 * are 1/128 of a turn or more apart. */
static const double rounding = 1e-5;

/* Makes the last line of every third splat that has seams one that cuts nothing off. */
static void blunt_seams(psplat_splats *s) {
    static const float blunt[3] = {1, 0, 1};
    for (size_t run = 0, i = 0; run < s->run_count; ++run)
        for (size_t end = i + s->runs[run].count; i < end; ++i) {
            uint32_t last = s->splats[i].clip_count - 1;
            if (i % 3 || !s->runs[run].seam_lines) continue;
            memcpy(s->splats[i].clip[last], blunt, sizeof blunt);
            s->splats[i].bend[last] = 0;
        }
}

/* Divides the run of each number of lines among all numbers of seams, from `least` to `most`. */
static void add_seams(psplat_splats *s, uint32_t least, uint32_t most) {
    enum { MOST_RUNS = (PSPLAT_MAX_CLIP_LINES + 1) * (PSPLAT_MAX_CLIP_LINES + 1) };
    psplat_run *runs = writer_memory(MOST_RUNS, sizeof *runs);
    size_t count = 0;
    for (size_t i = 0; i < s->run_count; ++i) {
        const psplat_run run = s->runs[i];
        uint32_t first = least < run.clip_lines ? least : run.clip_lines;
        uint32_t last = most < run.clip_lines ? most : run.clip_lines;
        for (size_t left = run.count, seams = first; seams <= last; ++seams) {
            runs[count] = run;
            runs[count].seam_lines = (uint32_t)seams;
            runs[count].count = left / (last - seams + 1);
            left -= runs[count].count;
            count += runs[count].count > 0;
        }
    }
    free(s->runs);
    s->runs = runs;
    s->run_count = count;
    blunt_seams(s);
}

static uint32_t seams_of(const psplat_splats *s, size_t index) {
    const psplat_run *run = s->runs;
    for (; index >= run->count; ++run) index -= run->count;
    return run->seam_lines;
}

static size_t index_of(const written *w, const psplat_batch *batch, const psplat_splat *found) {
    double at[2];
    for (int k = 0; k < 2; ++k)
        at[k] = batch->model[12 + k] + batch->model[5 * k] * (double)found->center[k];
    double x = rint(at[0] / w->size * GRID), y = rint(at[1] / w->size * GRID);
    assert_true(x >= 0 && y >= 0 && x + y * GRID < (double)w->count);
    return (size_t)x + (size_t)y * GRID;
}

/* Returns the greatest difference of a number of two lines. */
static double difference(const psplat_splat *a, uint32_t i, const float line[3], float bend) {
    double most = fabs((double)a->bend[i] - (double)bend);
    for (int k = 0; k < 3; ++k) most = fmax(most, fabs((double)a->clip[i][k] - (double)line[k]));
    return most;
}

/* Asserts that the lines begin ... end - 1 of a splat that was read are the lines from `from` on of
 * another one, count of them, in any order, and padding behind them or, of seams, none. */
static void check_lines(const psplat_splat *found, uint32_t begin, uint32_t end,
                        const psplat_splat *expected, uint32_t from, uint32_t count) {
    static const float padding[3] = {1, 0, 1};
    unsigned met = 0;
    assert_true(end - begin >= count);
    for (uint32_t i = begin; i < end; ++i) {
        double least = HUGE_VAL;
        uint32_t nearest = 0;
        for (uint32_t k = from; k < from + count; ++k) {
            double d = difference(found, i, expected->clip[k], expected->bend[k]);
            if (met >> k & 1 || d >= least) continue;
            least = d, nearest = k;
        }
        if (i - begin >= count)
            least = difference(found, i, padding, 0);
        else
            met |= 1u << nearest;
        assert_true(least <= rounding);
    }
}

/* What a file did. */
typedef struct seen {
    size_t seam_batches, sections, streams, stated; /* stated: members seamLines */
    size_t padded;                                  /* splats that lack lines before their seams */
    size_t crossed; /* splats of which a seam has a smaller turn than a line that cuts */
} seen;

static double turn_of(const float line[3]) {
    double turn = atan2((double)line[1], (double)line[0]);
    return turn < 0 ? turn + 2 * 3.14159265358979323846 : turn;
}

/* Returns whether the smallest turn of the seams is less than the greatest of the other lines. */
static int is_crossed(const psplat_splat *s, uint32_t seams) {
    double least = HUGE_VAL, greatest = -HUGE_VAL;
    for (uint32_t i = 0; i < s->clip_count; ++i) {
        double turn = turn_of(s->clip[i]);
        if (i + seams < s->clip_count)
            greatest = fmax(greatest, turn);
        else
            least = fmin(least, turn);
    }
    return least < greatest - 1e-3;
}

static void check_batch(const written *w, const psplat_splats *s, const psplat_batch *batch,
                        uint8_t *met, seen *all) {
    uint32_t seams = batch->seam_lines;
    for (size_t i = 0; i < batch->splat_count; ++i) {
        const psplat_splat *found = &batch->splats[i];
        size_t index = index_of(w, batch, found);
        const psplat_splat *expected = &s->splats[index];
        assert_int_equal(met[index]++, 0);
        assert_int_equal(seams_of(s, index), seams);
        uint32_t cuts = expected->clip_count - seams, before = batch->clip_count - seams;
        assert_int_equal(found->clip_count, batch->clip_count);
        check_lines(found, 0, before, expected, 0, cuts);
        check_lines(found, before, batch->clip_count, expected, cuts, seams);
        all->padded += seams && before > cuts;
        all->crossed += seams && is_crossed(expected, seams);
    }
    all->seam_batches += seams > 0;
}

static size_t count_text(const char *text, const char *word) {
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, word)); at += strlen(word)) ++count;
    return count;
}

/* Returns how many numbers stand in the arrays seamLines of a file. */
static size_t count_listed(const char *text) {
    size_t count = 0;
    for (const char *at = text; (at = strstr(at, "\"seamLines\":["));) {
        const char *end = strchr(at, ']');
        assert_non_null(end);
        for (++count; at < end; ++at) count += *at == ',';
    }
    return count;
}

/* Writes splats to a file, reads it and asserts that all are there. */
static seen check(const written *w, const psplat_splats *s, const psplat_codec *codec) {
    const psplat_write_desc desc = {.codec = codec};
    seen all = {0};
    size_t size, total = 0;
    uint8_t *data = writer_file(s, 1, &desc, &size), *met = writer_memory(w->count, 1);
    char *json = writer_json(data);
    psplat_asset *asset = writer_open(data, size);
    for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
        check_batch(w, s, psplat_asset_batch(asset, b), met, &all);
        total += psplat_asset_batch(asset, b)->splat_count;
    }
    assert_int_equal(total, w->count);
    all.sections = psplat_asset_batch_count(asset);
    all.streams = count_text(json, "\"stream\":");
    all.stated = count_text(json, "\"seamLines\":");
    if (all.streams) /* Each section is a batch, and has a number where any of its stream has. */
        assert_int_equal(count_listed(json), all.stated ? all.sections : 0);
    else
        assert_int_equal(all.stated, all.seam_batches);
    psplat_asset_destroy(asset);
    free(json);
    free(met);
    free(data);
    return all;
}

/* Splats of all numbers of lines and seams; flat, curved, and both in one file. */
static void test_all_numbers(void **state) {
    (void)state;
    static const unsigned curved[] = {0, 31, 10};
    seen streamed = {0};
    for (size_t i = 0; i < 24; ++i) {
        const written w = {.count = i < 12 ? 60 : 700,
                           .size = 2,
                           .precision = i % 2 ? steps_of(2) : (psplat_precision){0},
                           .has_slopes = 1,
                           .curved = curved[i / 4 % 3],
                           .has_bends = i / 2 % 2,
                           .has_shape = 1};
        psplat_splats s = writer_splats(&w, (uint32_t)(40 + i));
        add_seams(&s, 0, PSPLAT_MAX_CLIP_LINES);
        const psplat_codec *codecs[2] = {NULL, &psplat_meshopt_codec};
        for (int k = 0; k < 2; ++k) {
            seen all = check(&w, &s, codecs[k]);
            assert_true(all.seam_batches > 0 && all.stated > 0 && all.crossed > 0);
            assert_int_equal(all.streams, k && i % 2);
            if (!all.streams) assert_int_equal(all.padded, 0);
            streamed.padded += all.streams ? all.padded : 0;
        }
        psplat_splats_free(&s);
    }
    /* Sections of streams hold splats of fewer lines, too. */
    assert_true(streamed.padded > 100);
}

/* A file whose splats have no seams does not state them, and one of seams alone states all. */
static void test_none_and_all(void **state) {
    (void)state;
    for (size_t i = 0; i < 8; ++i) {
        const written w = {.count = 90,
                           .size = 1,
                           .precision = i & 1 ? steps_of(1) : (psplat_precision){0},
                           .lines = 31 & ~1u,
                           .has_slopes = 1};
        psplat_splats s = writer_splats(&w, (uint32_t)(70 + i));
        uint32_t seams = i & 2 ? PSPLAT_MAX_CLIP_LINES : 0;
        add_seams(&s, seams, seams);
        seen all = check(&w, &s, i & 4 ? &psplat_meshopt_codec : NULL);
        assert_int_equal(all.stated > 0, seams > 0);
        assert_int_equal(all.seam_batches, seams ? all.sections : 0);
        psplat_splats_free(&s);
    }
}

/* Runs of more seams than lines are refused. */
static void test_too_many(void **state) {
    (void)state;
    const written w = {.count = 10, .size = 1, .lines = 1 << 2, .has_slopes = 1};
    psplat_splats s = writer_splats(&w, 9);
    for (uint32_t seams = 2; seams < 4; ++seams) {
        uint8_t *data = NULL;
        size_t size = 0;
        psplat_error error = {0};
        assert_int_equal(s.run_count, 1);
        s.runs[0].seam_lines = seams;
        psplat_result result = psplat_glb_write(&s, NULL, NULL, &data, &size, &error);
        assert_int_equal(result, seams > 2 ? PSPLAT_ERROR_ARGUMENT : PSPLAT_OK);
        free(data);
    }
    psplat_splats_free(&s);
}

int test_written_seams_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_numbers),
        cmocka_unit_test(test_none_and_all),
        cmocka_unit_test(test_too_many),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

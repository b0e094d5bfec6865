/* SPDX-License-Identifier: MIT
 *
 * test_blocks.c - tests that streamed triangles are those of the file, that the counting sort puts
 * each into the block that a search through all cells finds, and that tasks see all triangles that
 * reach into their aprons.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/random.h"
#include "import/triangle_stream.h"
#include "near.h"
#include "tiles/block_mesh.h"
#include "tiles/blocks.h"
#include "tiles/cell.h"
#include "tiles/tasks.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { GRID = 40, TRIANGLES = 2 * GRID * GRID, VERTICES = (GRID + 1) * (GRID + 1) };

static char directory[64], stl_file[96], ply_file[96], store_file[96], absent_file[96];

static int set_up(void **state) {
    (void)state;
    strcpy(directory, "/tmp/phongsplat-blocks-XXXXXX");
    if (!mkdtemp(directory)) return -1;
    snprintf(stl_file, sizeof stl_file, "%s/blocks.stl", directory);
    snprintf(ply_file, sizeof ply_file, "%s/blocks.ply", directory);
    snprintf(store_file, sizeof store_file, "%s/blocks.store", directory);
    snprintf(absent_file, sizeof absent_file, "%s/absent/store", directory);
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    remove(stl_file);
    remove(ply_file);
    remove(store_file);
    return rmdir(directory); /* which fails where a test has left something else */
}

/* A bumpy square of TRIANGLES triangles, more of them where x and z are small, with colours. */
typedef struct source {
    double vertices[VERTICES][3];
    unsigned char colors[VERTICES][4];
    uint32_t triangles[TRIANGLES][3];
} source;

/* Rounds to single precision. GCC 12 with -O2 leaves (double)(float) out where two such values that
 * it has just computed are stored side by side; a volatile one it has to keep. */
static double single(double value) {
    volatile float rounded = (float)value;
    return (double)rounded;
}

static source *make_source(void) {
    source *s = malloc(sizeof *s);
    uint64_t seed = 11;
    assert_non_null(s);
    for (uint32_t v = 0; v < VERTICES; ++v) {
        double x = (double)(v % (GRID + 1)) / GRID, z = (double)(v / (GRID + 1)) / GRID;
        s->vertices[v][0] = single(7 * x * x);
        s->vertices[v][1] = single(0.3 * sin(5 * x) + 0.05 * psplat_random_unit(&seed));
        s->vertices[v][2] = single(5 * z * z - 2);
        for (int k = 0; k < 4; ++k)
            s->colors[v][k] = (unsigned char)(psplat_random_next(&seed) >> 56);
    }
    for (uint32_t i = 0; i < GRID * GRID; ++i) {
        uint32_t a = i / GRID * (GRID + 1) + i % GRID, c = a + GRID + 1;
        const uint32_t square[2][3] = {{a, c, a + 1}, {a + 1, c, c + 1}};
        memcpy(s->triangles[2 * i], square, sizeof square);
    }
    return s;
}

static const double *corner(const source *s, size_t triangle, size_t k) {
    return s->vertices[s->triangles[triangle][k]];
}

/* ---- files ----------------------------------------------------------------------------------- */

static void put(FILE *file, const void *data, size_t size, int is_big) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; ++i) fputc(bytes[is_big ? size - 1 - i : i], file);
}

static void write_stl(const source *s, const char *path) {
    const char head[80] = "solid, says a binary file";
    uint32_t count = TRIANGLES;
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fwrite(head, 1, sizeof head, file);
    put(file, &count, sizeof count, 0);
    for (size_t t = 0; t < TRIANGLES; ++t) {
        float numbers[12] = {0};
        for (size_t i = 0; i < 9; ++i) numbers[3 + i] = (float)corner(s, t, i / 3)[i % 3];
        fwrite(numbers, sizeof *numbers, 12, file);
        fwrite("\0", 1, 2, file);
    }
    assert_int_equal(fclose(file), 0);
}

/* Writes a PLY with a property and a list that are not read, and pairs of triangles as squares
 * where has_squares is set. */
static void write_ply(const source *s, const char *path, int is_big, int is_double,
                      int has_squares) {
    FILE *file = fopen(path, "wb");
    const char *real = is_double ? "double" : "float";
    assert_non_null(file);
    fprintf(
        file,
        "ply\nformat binary_%s_endian 1.0\ncomment by a test\nelement vertex %d\nproperty %s x\n"
        "property %s y\nproperty %s z\nproperty short temperature\nproperty uchar red\nproperty "
        "uchar green\nproperty uchar blue\nproperty uchar alpha\nelement face %d\nproperty list "
        "uchar short flags\nproperty list uchar int vertex_indices\nend_header\n",
        is_big ? "big" : "little", VERTICES, real, real, real,
        has_squares ? TRIANGLES / 2 : TRIANGLES);
    for (size_t v = 0; v < VERTICES; ++v) {
        uint16_t temperature = 7;
        for (int k = 0; k < 3; ++k) {
            float single = (float)s->vertices[v][k];
            put(file, is_double ? (const void *)&s->vertices[v][k] : (const void *)&single,
                is_double ? sizeof(double) : sizeof single, is_big);
        }
        put(file, &temperature, sizeof temperature, is_big);
        fwrite(s->colors[v], 1, 4, file);
    }
    for (size_t t = 0; t < TRIANGLES; t += has_squares ? 2 : 1) {
        const uint32_t *a = s->triangles[t];
        const uint32_t square[4] = {a[0], a[1], s->triangles[t | 1][2], a[2]};
        uint16_t flag = 3;
        fputc(2, file);
        put(file, &flag, sizeof flag, is_big);
        put(file, &flag, sizeof flag, is_big);
        fputc(has_squares ? 4 : 3, file);
        for (int k = 0; k < (has_squares ? 4 : 3); ++k)
            put(file, has_squares ? &square[k] : &a[k], sizeof *a, is_big);
    }
    assert_int_equal(fclose(file), 0);
}

static psplat_triangle_stream *open_stream(const char *path) {
    psplat_triangle_stream *stream;
    psplat_error error = {0};
    if (psplat_triangle_stream_open(path, &stream, &error)) fail_msg("%s", error.text);
    return stream;
}

/* ---- streams --------------------------------------------------------------------------------- */

static void check_triangle(const source *s, size_t t, const psplat_stream_triangle *got,
                           int has_colors) {
    for (size_t i = 0; i < 9; ++i)
        assert_near(got->positions[i], corner(s, t, i / 3)[i % 3], 0); /* The file has all bits. */
    for (size_t i = 0; i < 12 && has_colors; ++i) {
        double byte = s->colors[s->triangles[t][i / 4]][i % 4] / 255.0;
        double linear = i % 4 == 3        ? byte
                        : byte <= 0.04045 ? byte / 12.92
                                          : pow((byte + 0.055) / 1.055, 2.4);
        assert_near((double)got->colors[i], linear, 1e-6); /* Colours are floats. */
    }
}

static void check_stream(const source *s, const char *path, int is_single, int has_colors) {
    psplat_triangle_stream *stream = open_stream(path);
    const psplat_stream_content *content = psplat_triangle_stream_content(stream);
    psplat_stream_triangle t;
    psplat_error error = {0};
    int got;
    assert_true(content->is_mapped);
    assert_int_equal(content->is_single, is_single);
    assert_int_equal(content->has_colors, has_colors);
    for (int pass = 0; pass < 2; ++pass) {
        for (size_t i = 0; i < TRIANGLES; ++i) {
            assert_int_equal(psplat_triangle_stream_next(stream, &t, &got, &error), PSPLAT_OK);
            assert_true(got);
            check_triangle(s, i, &t, has_colors);
        }
        assert_int_equal(psplat_triangle_stream_next(stream, &t, &got, &error), PSPLAT_OK);
        assert_false(got);
        psplat_triangle_stream_rewind(stream);
    }
    psplat_triangle_stream_close(stream);
}

static void streams_hold_the_triangles_of_files(void **state) {
    (void)state;
    source *s = make_source();
    write_stl(s, stl_file);
    check_stream(s, stl_file, 1, 0);
    for (int kind = 0; kind < 4; ++kind) {
        write_ply(s, ply_file, kind & 1, kind >> 1, 0);
        check_stream(s, ply_file, !(kind >> 1), 1);
    }
    free(s);
}

/* Squares are split; which diagonal they get is the triangulation's choice, so that areas of boxes
 * of corners stand for them. */
static void squares_become_two_triangles(void **state) {
    (void)state;
    source *s = make_source();
    psplat_stream_triangle t;
    psplat_error error = {0};
    size_t count = 0;
    double sum = 0, expected = 0;
    write_ply(s, ply_file, 0, 0, 1);
    psplat_triangle_stream *stream = open_stream(ply_file);
    for (int got = 1; got; count += (size_t)got) {
        assert_int_equal(psplat_triangle_stream_next(stream, &t, &got, &error), PSPLAT_OK);
        const double *p = t.positions; /* the area above the plane of x and z, which has a sign */
        if (got) sum += (p[3] - p[0]) * (p[8] - p[2]) - (p[6] - p[0]) * (p[5] - p[2]);
    }
    for (size_t i = 0; i < TRIANGLES; ++i) {
        const double *a = corner(s, i, 0), *b = corner(s, i, 1), *c = corner(s, i, 2);
        expected += (b[0] - a[0]) * (c[2] - a[2]) - (c[0] - a[0]) * (b[2] - a[2]);
    }
    assert_int_equal(count, TRIANGLES);
    assert_near(sum, expected, 1e-9); /* sums of 3,200 terms of size 1e-2 */
    psplat_triangle_stream_close(stream);
    free(s);
}

/* Refused streams say at which byte. */
static void broken_files_are_refused(void **state) {
    (void)state;
    source *s = make_source();
    psplat_stream_triangle t;
    psplat_error error = {0};
    int got = 1;
    s->triangles[700][1] = VERTICES; /* no vertex */
    write_ply(s, ply_file, 0, 0, 0);
    psplat_triangle_stream *stream = open_stream(ply_file);
    psplat_result result = PSPLAT_OK;
    while (got && !result) result = psplat_triangle_stream_next(stream, &t, &got, &error);
    assert_int_equal(result, PSPLAT_ERROR_RANGE);
    assert_non_null(strstr(error.text, "face 700: a corner is not the index of a vertex"));
    psplat_triangle_stream_close(stream);
    s->triangles[700][1] = 0;
    write_ply(s, ply_file, 0, 0, 0);
    assert_int_equal(truncate(ply_file, 60000), 0);
    stream = open_stream(ply_file);
    result = PSPLAT_OK;
    for (got = 1; got && !result;) result = psplat_triangle_stream_next(stream, &t, &got, &error);
    assert_int_equal(result, PSPLAT_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "the file ends before the last row"));
    psplat_triangle_stream_close(stream);
    free(s);
}

/* ---- the sort -------------------------------------------------------------------------------- */

/* The triangles of a block in the store, by their first corners' places in the source. */
typedef struct block_list {
    const source *source;
    size_t triangles[TRIANGLES];
    size_t count;
} block_list;

/* Finds a triangle by all of its corners. */
static int take(void *user, const psplat_stream_triangle *t) {
    block_list *list = user;
    size_t i =
        list->count ? list->triangles[list->count - 1] + 1 : 0; /* in the order of the file */
    for (; i < TRIANGLES; ++i) {
        size_t k = 0;
        while (k < 9 && t->positions[k] == corner(list->source, i, k / 3)[k % 3]) ++k;
        if (k == 9) break;
    }
    assert_true(i < TRIANGLES);
    list->triangles[list->count++] = i;
    return 0;
}

static void centroid_of(const source *s, size_t t, double c[3]) {
    for (int k = 0; k < 3; ++k)
        c[k] = (corner(s, t, 0)[k] + corner(s, t, 1)[k] + corner(s, t, 2)[k]) / 3;
}

/* Counts the triangles whose centroids a cell holds. */
static size_t count_held(const source *s, const psplat_tile_cell *cell) {
    size_t count = 0;
    for (size_t t = 0; t < TRIANGLES; ++t) {
        double c[3];
        centroid_of(s, t, c);
        count += (size_t)psplat_tile_cell_holds(cell, c);
    }
    return count;
}

static int meets(const source *s, size_t t, const psplat_tile_cell *cell) {
    double corners[9];
    for (size_t i = 0; i < 9; ++i) corners[i] = corner(s, t, i / 3)[i % 3];
    return psplat_tile_cell_meets_triangle(cell, corners);
}

static int is_met(const source *s, const psplat_tile_cell *cell) {
    for (size_t t = 0; t < TRIANGLES; ++t)
        if (meets(s, t, cell)) return 1;
    return 0;
}

/* Checks the blocks below a cell against a search through all triangles. Returns how many blocks
 * there are. */
static size_t check_cell(const source *s, const psplat_tile_leaves *leaves, size_t at, size_t most,
                         const psplat_tile_cell *cell) {
    size_t held = count_held(s, cell);
    if (held > most) {
        psplat_tile_cell lower = psplat_tile_cell_half(cell, 0),
                         upper = psplat_tile_cell_half(cell, 1);
        size_t count = check_cell(s, leaves, at, most, &lower);
        return count + check_cell(s, leaves, at + count, most, &upper);
    }
    if (!is_met(s, cell)) return 0;
    const psplat_tile_leaf *leaf = &leaves->leaves[at];
    block_list *list = calloc(1, sizeof *list);
    psplat_error error = {0};
    assert_non_null(list);
    assert_string_equal(leaf->path, cell->path);
    assert_int_equal(leaf->count, held);
    list->source = s;
    assert_int_equal(psplat_tile_leaf_read(leaves, at, store_file, take, list, &error), PSPLAT_OK);
    assert_int_equal(list->count, held);
    for (size_t i = 0; i < held; ++i) {
        double c[3];
        centroid_of(s, list->triangles[i], c);
        assert_true(psplat_tile_cell_holds(cell, c));
        for (size_t k = 0; k < 9; ++k) {
            double x = corner(s, list->triangles[i], k / 3)[k % 3];
            assert_true(x >= leaf->low[k % 3] && x <= leaf->high[k % 3]);
        }
    }
    free(list);
    return 1;
}

static psplat_tile_leaves sort_file(const char *path, uint64_t most) {
    psplat_tile_leaves leaves = {0};
    psplat_error error = {0};
    psplat_triangle_stream *stream = open_stream(path);
    if (psplat_tile_leaves_sort(stream, most, store_file, &leaves, &error))
        fail_msg("%s", error.text);
    psplat_triangle_stream_close(stream);
    return leaves;
}

static void check_blocks(const source *s, const uint64_t *sizes, size_t size_count) {
    write_stl(s, stl_file);
    for (size_t i = 0; i < size_count; ++i) {
        psplat_tile_leaves leaves = sort_file(stl_file, sizes[i]);
        uint64_t sum = 0;
        for (size_t k = 0; k < leaves.count; ++k) sum += leaves.leaves[k].count;
        assert_int_equal(sum, TRIANGLES);
        assert_int_equal(leaves.triangles, TRIANGLES);
        assert_int_equal(check_cell(s, &leaves, 0, sizes[i], &leaves.root), leaves.count);
        assert_false(leaves.is_closed);
        psplat_tile_leaves_free(&leaves);
    }
}

static void blocks_are_those_of_a_search(void **state) {
    (void)state;
    source *s = make_source();
    check_blocks(s, (const uint64_t[]){TRIANGLES, 1000, 130, 9}, 4);
    free(s);
}

/* A vertex that is far away puts all others into one cell of the first pass. */
static void far_points_do_not_fill_blocks(void **state) {
    (void)state;
    source *s = make_source();
    s->vertices[0][0] = 1e5;
    check_blocks(s, (const uint64_t[]){1000, 130}, 2);
    psplat_tile_leaves leaves = sort_file(stl_file, 130);
    assert_true(leaves.count >= TRIANGLES / 130);
    for (size_t i = 0; i < leaves.count; ++i) assert_true(leaves.leaves[i].count <= 130);
    psplat_tile_leaves_free(&leaves);
    free(s);
}

/* A closed surface is noticed while it streams, and one whose one triangle is turned is not. */
static void closed_surfaces_are_noticed(void **state) {
    (void)state;
    source *s = calloc(1, sizeof *s);
    assert_non_null(s);
    for (int is_turned = 0; is_turned < 2; ++is_turned) {
        for (uint32_t i = 0; i < TRIANGLES; ++i) { /* many tetrahedra */
            static const uint32_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
            for (uint32_t k = 0; k < 3; ++k)
                s->triangles[i][k] = (i / 4 * 4 + faces[i % 4][k]) % VERTICES;
        }
        for (uint32_t v = 0; v < VERTICES; ++v)
            for (uint32_t k = 0; k < 3; ++k) s->vertices[v][k] = v % 4 == k + 1 ? 1 + v / 4 : v / 4;
        if (is_turned) s->triangles[5][0] = s->triangles[5][1];
        write_stl(s, stl_file);
        psplat_tile_leaves leaves = sort_file(stl_file, 500);
        /* VERTICES is odd, so that the last tetrahedra share vertices: they are closed all the
         * same. */
        assert_int_equal(leaves.is_closed, !is_turned);
        psplat_tile_leaves_free(&leaves);
    }
    free(s);
}

static void stores_that_fail_are_told(void **state) {
    (void)state;
    source *s = make_source();
    psplat_tile_leaves leaves = {0};
    psplat_error error = {0};
    psplat_tile_soup soup = {0};
    write_stl(s, stl_file);
    psplat_triangle_stream *stream = open_stream(stl_file);
    assert_int_equal(psplat_tile_leaves_sort(stream, 500, absent_file, &leaves, &error),
                     PSPLAT_ERROR_WRITE);
    assert_non_null(strstr(error.text, "absent/store: cannot be created"));
    psplat_triangle_stream_close(stream);
    leaves = sort_file(stl_file, 500);
    assert_int_equal(truncate(store_file, 1000), 0);
    assert_int_equal(
        psplat_tile_leaf_read(&leaves, 0, store_file, psplat_tile_soup_add, &soup, &error),
        PSPLAT_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "blocks.store: ends before the triangles of block"));
    psplat_tile_soup_free(&soup);
    psplat_tile_leaves_free(&leaves);
    free(s);
}

/* ---- tasks ----------------------------------------------------------------------------------- */

/* Counts how often the block of a triangle is among the needs of a task, itself or below one. */
static size_t count_needs(const psplat_tile_tasks *tasks, const psplat_tile_leaves *leaves,
                          const psplat_tile_task *task, const double centroid[3]) {
    size_t count = 0;
    (void)leaves;
    for (size_t i = 0; i < task->need_count; ++i)
        count += (size_t)psplat_tile_cell_holds(&tasks->list[task->needs[i].task].cell, centroid);
    return count;
}

static void tasks_see_their_aprons(void **state) {
    (void)state;
    source *s = make_source();
    psplat_tile_tasks tasks;
    write_stl(s, stl_file);
    psplat_tile_leaves leaves = sort_file(stl_file, 130);
    assert_int_equal(psplat_tile_tasks_make(&leaves, 0.2, &tasks), PSPLAT_OK);
    assert_int_equal(tasks.count, 2 * leaves.count - 1);
    for (size_t i = 0; i < tasks.count; ++i) {
        const psplat_tile_task *task = &tasks.list[i];
        assert_int_equal(psplat_tile_tasks_find(&tasks, task->name), i);
        for (size_t t = 0; t < TRIANGLES; ++t) {
            double c[3];
            if (!meets(s, t, &task->reach)) continue;
            centroid_of(s, t, c);
            assert_int_equal(count_needs(&tasks, &leaves, task, c), 1);
        }
        for (size_t k = 0; k < task->need_count; ++k) {
            const psplat_tile_task *other = &tasks.list[task->needs[k].task];
            assert_true(task->needs[k].is_original ? other->leaf != SIZE_MAX
                                                   : other->wave < task->wave);
        }
    }
    assert_string_equal(tasks.list[tasks.count - 1].name, "r");
    psplat_tile_tasks_free(&tasks);
    psplat_tile_leaves_free(&leaves);
    free(s);
}

int test_blocks_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(streams_hold_the_triangles_of_files),
        cmocka_unit_test(squares_become_two_triangles),
        cmocka_unit_test(broken_files_are_refused),
        cmocka_unit_test(blocks_are_those_of_a_search),
        cmocka_unit_test(far_points_do_not_fill_blocks),
        cmocka_unit_test(closed_surfaces_are_noticed),
        cmocka_unit_test(stores_that_fail_are_told),
        cmocka_unit_test(tasks_see_their_aprons),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

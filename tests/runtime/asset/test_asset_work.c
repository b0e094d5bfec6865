/* SPDX-License-Identifier: MIT
 *
 * test_asset_work.c - counts what the reader does to open files that small changes make slow. The
 * reader is compiled with -fsanitize-coverage=trace-pc here, so that it calls a function of this
 * file at every basic block: a number that is the same on every run, unlike a time.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include <phongsplat/phongsplat.h>

#include <stdlib.h>

/* More levels than any file needs: with halved splats, 2^64 of them. */
enum { LEVELS = 64, NODES = 1000, LISTS = 100, PRIMITIVES = 40 };
/* The splats of the buffer. Readers refuse files that use theirs much more than once. */
enum { STORED = 8192 };

static uint64_t steps;

void __sanitizer_cov_trace_pc(void);
void __sanitizer_cov_trace_pc(void) {
    ++steps;
}

/* ---- documents ------------------------------------------------------------------------------- */

typedef struct text {
    char *bytes;
    size_t size, capacity;
} text;

static void add(text *t, const char *format, ...) {
    char line[1 << 14];
    va_list list;
    va_start(list, format);
    int length = vsnprintf(line, sizeof line, format, list);
    va_end(list);
    assert_in_range(length, 0, sizeof line - 1);
    if (t->size + (size_t)length >= t->capacity) {
        t->capacity = 2 * t->capacity + sizeof line;
        t->bytes = realloc(t->bytes, t->capacity);
        assert_non_null(t->bytes);
    }
    memcpy(t->bytes + t->size, line, (size_t)length + 1);
    t->size += (size_t)length;
}

/* Adds a primitive of count splats that lie on one another, and its list of levels if any. */
static void add_primitive(text *t, size_t count, const char *levels) {
    size_t first = 4 * (count - 1);
    add(t,
        "{\"mode\":0,\"attributes\":{\"POSITION\":%zu,\"NORMAL\":%zu,"
        "\"_PSPLAT_surface_splats:ROTATION\":%zu,\"_PSPLAT_surface_splats:SCALE\":%zu},"
        "\"extensions\":{\"PSPLAT_surface_splats\":{\"version\":1,\"clipLines\":0,"
        "\"depthTolerance\":0.01,\"positionExtent\":[0,0,0]%s}}}",
        first, first + 1, first + 2, first + 3, levels);
}

/* Adds accessors for 1 to most splats, and the buffer of these: position -1 0 0, normal 0 0 1, no
 * rotation, radii of 1. */
static void add_data(text *t, size_t most) {
    static const char *const types[4] = {"\"VEC3\",\"min\":[-1,0,0],\"max\":[-1,0,0]", "\"VEC3\"",
                                         "\"VEC4\"", "\"VEC2\""};
    static const int offsets[4] = {0, 12, 24, 40};
    add(t, "\"accessors\":[");
    for (size_t i = 0; i < 4 * most; ++i)
        add(t,
            "%s{\"bufferView\":0,\"byteOffset\":%d,\"componentType\":5126,\"count\":%zu,\"type\":"
            "%s}",
            i ? "," : "", offsets[i % 4], i / 4 + 1, types[i % 4]);
    add(t, "],\"bufferViews\":[{\"buffer\":0,\"byteLength\":%d,\"byteStride\":48}],", 48 * STORED);
    add(t, "\"buffers\":[{\"byteLength\":%d,\"uri\":\"data:application/octet-stream;base64,",
        48 * STORED);
    for (size_t i = 0; i < STORED; ++i)
        add(t, "AACAvwAAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAACAPwAAgD8AAIA/");
    add(t, "\"}]");
}

static text begin_document(void) {
    text t = {0};
    add(&t, "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"PSPLAT_surface_splats\"],");
    return t;
}

/* Adds nodes, all in the scene, which show these meshes in turn. */
static void add_nodes(text *t, size_t count, size_t meshes) {
    add(t, "\"scene\":0,\"scenes\":[{\"nodes\":[");
    for (size_t i = 0; i < count; ++i) add(t, "%s%zu", i ? "," : "", i);
    add(t, "]}],\"nodes\":[");
    for (size_t i = 0; i < count; ++i)
        add(t, "%s{\"mesh\":%zu}", i ? "," : "", i < meshes ? i : meshes - 1);
    add(t, "],");
}

/* Counts the steps of opening a document, which is freed, and the splats of its coarsest level. */
static uint64_t count_steps(text *t, size_t *coarsest) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    add(t, "}");
    steps = 0;
    if (psplat_asset_open_memory(t->bytes, t->size, NULL, &asset, &error))
        fail_msg("%s (byte %zu)", error.text, error.offset);
    uint64_t count = steps;
    size_t levels = psplat_asset_level_count(asset);
    *coarsest = (size_t)psplat_asset_get_level(asset, levels - 1)->splat_count;
    psplat_asset_destroy(asset);
    free(t->bytes);
    assert_true(count > 1000); /* or the reader was not compiled to count */
    return count;
}

/* ---- tests ----------------------------------------------------------------------------------- */

/* Counts the steps for a mesh of so many levels, of LEVELS splats down, and nodes of another mesh
 * with two levels. */
static uint64_t count_for_nodes(size_t levels, size_t nodes) {
    text t = begin_document(), list = {0};
    size_t coarsest;
    add_nodes(&t, nodes + 1, 2);
    add(&t, "\"meshes\":[{\"primitives\":[");
    add(&list, ",\"levels\":[{\"distance\":0,\"normal\":0,\"outline\":0}");
    for (size_t l = 1; l < levels; ++l)
        add(&list, ",{\"mesh\":%zu,\"distance\":%zu,\"normal\":1,\"outline\":1}", l + 1, l);
    add(&list, "]");
    add_primitive(&t, LEVELS, list.bytes);
    add(&t, "]},{\"primitives\":[");
    list.size = 0;
    add(&list,
        ",\"levels\":[{\"distance\":0,\"normal\":0,\"outline\":0},{\"mesh\":%zu,\"distance\":7,"
        "\"normal\":1,\"outline\":1}]",
        levels);
    add_primitive(&t, 3, list.bytes);
    add(&t, "]}");
    for (size_t l = 1; l < levels; ++l) {
        add(&t, ",{\"primitives\":[");
        add_primitive(&t, levels - l, "");
        add(&t, "]}");
    }
    add(&t, "],");
    add_data(&t, LEVELS);
    free(list.bytes);
    uint64_t count = count_steps(&t, &coarsest);
    assert_int_equal(coarsest, 1 + nodes);
    return count;
}

/* A node costs the same, however many levels another mesh has. */
static void nodes_do_not_pay_for_levels_of_others(void **state) {
    (void)state;
    uint64_t few = count_for_nodes(2, NODES) - count_for_nodes(2, 1);
    uint64_t many = count_for_nodes(LEVELS, NODES) - count_for_nodes(LEVELS, 1);
    if (many > few + few / 50) /* Numbers have up to two digits more in the file. */
        fail_msg("%d nodes take %llu steps beside %d levels, %llu beside 2", NODES - 1,
                 (unsigned long long)many, LEVELS, (unsigned long long)few);
}

/* Counts the steps for so many lists that name a mesh of so many primitives as their second level.
 */
static uint64_t count_for_lists(size_t lists, size_t primitives) {
    text t = begin_document();
    char list[128];
    size_t coarsest;
    add_nodes(&t, 1, 1);
    snprintf(list, sizeof list,
             ",\"levels\":[{\"distance\":0,\"normal\":0,\"outline\":0},{\"mesh\":%zu,"
             "\"distance\":1,\"normal\":1,\"outline\":1}]",
             lists);
    add(&t, "\"meshes\":[");
    for (size_t i = 0; i < lists; ++i) {
        add(&t, "{\"primitives\":[");
        add_primitive(&t, LEVELS, list);
        add(&t, "]},");
    }
    add(&t, "{\"primitives\":[");
    for (size_t i = 0; i < primitives; ++i) {
        if (i) add(&t, ",");
        add_primitive(&t, 1, "");
    }
    add(&t, "]}],");
    add_data(&t, LEVELS);
    uint64_t count = count_steps(&t, &coarsest);
    assert_int_equal(coarsest, primitives);
    return count;
}

/* A list costs the same, however many primitives the meshes have that it names. */
static void lists_do_not_pay_for_primitives_of_meshes(void **state) {
    (void)state;
    uint64_t few = count_for_lists(LISTS, 1) - count_for_lists(1, 1);
    uint64_t many = count_for_lists(LISTS, PRIMITIVES) - count_for_lists(1, PRIMITIVES);
    if (many > few + few / 50)
        fail_msg("%d lists take %llu steps beside %d primitives, %llu beside 1", LISTS - 1,
                 (unsigned long long)many, PRIMITIVES, (unsigned long long)few);
}

int test_asset_work_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nodes_do_not_pay_for_levels_of_others),
        cmocka_unit_test(lists_do_not_pay_for_primitives_of_meshes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_gl_program.c - tests the shader programs: their number is bounded, and all of them compile
 * and link, on GL and GLES.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl/gl_program.h"

#include <phongsplat/host.h>
#include <stdlib.h>
#include <string.h>

/* All options but those of textures, which have tests of their own. */
enum { ALL_OPTIONS = PSPLAT_OPTION_MASK - 1, MAX_KEYS = 80000 };

typedef struct key_list {
    psplat_program_key *keys;
    size_t count;
} key_list;

static int same(const psplat_program_key *a, const psplat_program_key *b) {
    return a->options == b->options && a->is_resolve == b->is_resolve && a->pass == b->pass &&
           a->clip_count == b->clip_count && a->seam_count == b->seam_count &&
           a->shading == b->shading && a->light_count == b->light_count &&
           a->is_faded == b->is_faded && a->part == b->part && a->is_boxed == b->is_boxed;
}

static int by_value(const void *a, const void *b) {
    return memcmp(a, b, sizeof(psplat_program_key));
}

/* Reduces a key and keeps it. */
static void add(key_list *list, psplat_program_key key) {
    assert_true(list->count < MAX_KEYS);
    list->keys[list->count] = psplat_program_key_reduce(key);
    /* Reducing twice changes nothing: a reduced key reduces to itself. */
    psplat_program_key again = psplat_program_key_reduce(list->keys[list->count]);
    assert_true(same(&again, &list->keys[list->count]));
    ++list->count;
}

static void keep_distinct(key_list *list) {
    size_t kept = 0;
    qsort(list->keys, list->count, sizeof *list->keys, by_value);
    for (size_t i = 0; i < list->count; ++i)
        if (kept == 0 || !same(&list->keys[kept - 1], &list->keys[i]))
            list->keys[kept++] = list->keys[i];
    list->count = kept;
}

/* Returns options among which are all that programs of this kind use. */
static unsigned possible_options(const psplat_program_key *key) {
    const unsigned only_splats =
        PSPLAT_OPTION_CURVED | PSPLAT_OPTION_TANGENT | PSPLAT_OPTION_SHAPE | PSPLAT_OPTION_BENDS;
    const unsigned only_resolve = PSPLAT_OPTION_ENCODE | PSPLAT_OPTION_AS_IS;
    const unsigned only_normals =
        PSPLAT_OPTIONS_TARGETS | PSPLAT_OPTION_COUNT | PSPLAT_OPTION_FIELD;
    if (key->is_resolve) return ALL_OPTIONS & ~only_splats;
    return ALL_OPTIONS & ~only_resolve &
           ~(key->pass == PSPLAT_PASS_RADIANCE ? only_normals : (unsigned)PSPLAT_OPTIONS_LIGHT);
}

/* Adds the distinct programs of one pass, clip count, shading and number of lights. */
static void add_options(key_list *list, psplat_program_key key) {
    size_t first = list->count;
    key_list part = {list->keys + first, 0};
    const unsigned possible = possible_options(&key);
    for (unsigned options = possible, is_last = 0; !is_last; options = (options - 1) & possible) {
        is_last = options == 0;
        key.options = options;
        psplat_program_key reduced = psplat_program_key_reduce(key);
        /* Keys that reducing leaves unchanged represent all keys that reduce to them. */
        if (reduced.options == options) add(&part, key);
    }
    list->count += part.count;
}

static key_list list_create(void) {
    key_list list = {malloc(MAX_KEYS * sizeof(psplat_program_key)), 0};
    assert_non_null(list.keys);
    memset(list.keys, 0, MAX_KEYS * sizeof *list.keys);
    return list;
}

/* ---- which programs are compiled ---------------------------------------------------------- */

enum { OPTION_BITS = 23, TRIPLES = OPTION_BITS * (OPTION_BITS - 1) * (OPTION_BITS - 2) / 6 };

/* For three options each: a bit for each of the eight ways in which they are on or off together. */
typedef struct triples {
    unsigned options[OPTION_BITS]; /* those that differ among the keys */
    size_t option_count;
    unsigned char seen[TRIPLES];
} triples;

static unsigned is_on(const psplat_program_key *key, unsigned option) {
    return (key->options & option) != 0;
}

/* Returns in how many triples the key shows something new, and notes that if it is kept. */
static size_t new_triples(triples *t, const psplat_program_key *key, int is_kept) {
    size_t count = 0, at = 0;
    for (size_t i = 0; i < t->option_count; ++i)
        for (size_t j = 0; j < i; ++j)
            for (size_t k = 0; k < j; ++k, ++at) {
                unsigned state = 1u << (4 * is_on(key, t->options[i]) +
                                        2 * is_on(key, t->options[j]) + is_on(key, t->options[k]));
                if (t->seen[at] & state) continue;
                ++count;
                if (is_kept) t->seen[at] = (unsigned char)(t->seen[at] | state);
            }
    return count;
}

static void find_options(triples *t, const key_list *part) {
    unsigned some = 0, all = ~0u;
    for (size_t i = 0; i < part->count; ++i) {
        some |= part->keys[i].options;
        all &= part->keys[i].options;
    }
    assert_int_equal(some >> OPTION_BITS, 0);
    for (int i = 0; i < OPTION_BITS; ++i)
        if ((some & ~all) >> i & 1) t->options[t->option_count++] = 1u << i;
}

/* Keeps the keys in which every three options are on and off in each way that some key has them,
 * first those that show most: lines of shaders hang on three options at most, besides the pass, the
 * number of clip lines, the shading and the lights. The first key has all options that it can. */
static void keep_triples(key_list *part) {
    static triples t;
    memset(&t, 0, sizeof t);
    find_options(&t, part);
    if (t.option_count < 3) return;
    size_t kept = 0;
    for (size_t wanted = TRIPLES; wanted > 0; wanted /= 2)
        for (size_t i = kept; i < part->count; ++i) {
            if (new_triples(&t, &part->keys[i], 0) < wanted) continue;
            new_triples(&t, &part->keys[i], 1);
            psplat_program_key key = part->keys[kept];
            part->keys[kept++] = part->keys[i];
            part->keys[i] = key;
        }
    part->count = kept;
}

/* Adds the programs of one pass, clip count, shading and number of lights that are compiled. */
static void add_triples(key_list *list, psplat_program_key key) {
    key_list part = {list->keys + list->count, 0};
    add_options(&part, key);
    keep_triples(&part);
    list->count += part.count;
}

/* Adds programs of flat splats that are drawn as boxes. Of their options these are the ones that
 * the vertex shader goes by. */
static void add_boxed(key_list *list, psplat_program_key key) {
    static const unsigned options[] = {
        0,
        PSPLAT_OPTION_FILTER | PSPLAT_OPTION_FIELD,
        PSPLAT_OPTION_FILTER | PSPLAT_OPTION_BENDS,
        PSPLAT_OPTION_BENDS | PSPLAT_OPTION_TANGENT,
        PSPLAT_OPTION_NEAR | PSPLAT_OPTION_TWO_SIDED | PSPLAT_OPTION_FIELD | PSPLAT_OPTION_GAMMA,
        PSPLAT_OPTION_FILTER | PSPLAT_OPTION_SHAPE | PSPLAT_OPTION_BASE_MAP | PSPLAT_OPTION_COLORS};
    key.is_boxed = 1;
    for (size_t i = 0; i < sizeof options / sizeof *options; ++i)
        for (key.seam_count = 0; key.seam_count < 2; ++key.seam_count) {
            key.options = options[i];
            add(list, psplat_program_key_reduce(key));
        }
}

/* Returns the keys of all passes and shadings, without lights and with as many as there may be; of
 * boxes those with the least and the most lines. Of programs that shade splats one by one, those
 * with clip lines are made only without lights. */
static key_list some_keys(int clip_step) {
    key_list list = list_create();
    for (int pass = PSPLAT_PASS_VISIBILITY; pass <= PSPLAT_PASS_PARAMETERS; ++pass)
        for (int clip = 0; clip <= PSPLAT_MAX_CLIP_LINES; clip += clip_step)
            add_triples(&list, (psplat_program_key){.pass = pass, .clip_count = clip});
    for (int pass = PSPLAT_PASS_VISIBILITY; pass <= PSPLAT_PASS_PARAMETERS; ++pass)
        for (int clip = 1; clip <= PSPLAT_MAX_CLIP_LINES; clip += PSPLAT_MAX_CLIP_LINES - 1)
            add_boxed(&list, (psplat_program_key){.pass = pass, .clip_count = clip});
    for (int lights = 0; lights <= PSPLAT_MAX_LIGHTS; lights += PSPLAT_MAX_LIGHTS) {
        psplat_program_key key = {.pass = PSPLAT_PASS_RADIANCE, .light_count = lights};
        add_triples(&list, key);
        key.is_resolve = 1;
        for (key.shading = 0; key.shading < PSPLAT_SHADING_COUNT; ++key.shading)
            add_triples(&list, key);
    }
    keep_distinct(&list);
    return list;
}

/* No scene can make more programs: an option that a program does not use makes no other program. */
static void test_bounded(void **state) {
    (void)state;
    size_t most = 0;
    for (int pass = PSPLAT_PASS_VISIBILITY; pass <= PSPLAT_PASS_PARAMETERS; ++pass) {
        key_list list = list_create();
        add_options(&list, (psplat_program_key){.pass = pass, .light_count = 1});
        keep_distinct(&list);
        print_message("pass %d: %zu programs for each number of clip lines\n", pass, list.count);
        if (list.count > most) most = list.count;
        free(list.keys);
    }
    /* Passes of normals have 5 programs for gammas, fields and attributes that are skipped. With
     * more targets there are five times these and 8 for colours and finishes. All of it is
     * multiplied by sides, filter and three weights, and by the kinds of surfaces: flat, tangent,
     * flat and curved with a shape of their own, curved. */
    assert_true(most <= (5 + 5 * 13) * 2 * 2 * 3 * 5);
}

static void test_no_use(void **state) {
    (void)state;
    psplat_program_key visible = {.pass = PSPLAT_PASS_VISIBILITY, .options = ~0u, .light_count = 3};
    visible = psplat_program_key_reduce(visible);
    assert_int_equal(visible.options,
                     PSPLAT_OPTION_WIDE | PSPLAT_OPTION_SHAPE | PSPLAT_OPTION_CURVED |
                         PSPLAT_OPTION_TWO_SIDED | PSPLAT_OPTION_MASK | PSPLAT_OPTION_BASE_MAP |
                         PSPLAT_OPTION_TEXCOORD_BEND | PSPLAT_OPTION_MAP_TRANSFORM);
    assert_int_equal(visible.light_count, 0);
    psplat_program_key depth = {.is_resolve = 1, .shading = PSPLAT_SHADING_DEPTH, .light_count = 3};
    depth.options = PSPLAT_OPTIONS_TARGETS | PSPLAT_OPTIONS_LIGHT;
    depth = psplat_program_key_reduce(depth);
    assert_int_equal(depth.options, 0);
    assert_int_equal(depth.light_count, 0);
    /* Where there are no weights nothing fades. */
    psplat_program_key faded = {.pass = PSPLAT_PASS_NORMALS, .is_faded = 1};
    assert_true(psplat_program_key_reduce(faded).is_faded);
    faded.options = PSPLAT_OPTION_COUNT;
    assert_false(psplat_program_key_reduce(faded).is_faded);
    faded.pass = PSPLAT_PASS_RADIANCE;
    assert_true(psplat_program_key_reduce(faded).is_faded);
    faded.pass = PSPLAT_PASS_VISIBILITY;
    assert_false(psplat_program_key_reduce(faded).is_faded);
    /* Only flat splats that a line cuts have boxes. */
    psplat_program_key boxed = {.pass = PSPLAT_PASS_NORMALS, .clip_count = 2, .is_boxed = 1};
    assert_true(psplat_program_key_reduce(boxed).is_boxed);
    boxed.seam_count = 1;
    assert_true(psplat_program_key_reduce(boxed).is_boxed);
    boxed.seam_count = 2;
    assert_false(psplat_program_key_reduce(boxed).is_boxed);
    boxed.seam_count = 0;
    boxed.options = PSPLAT_OPTION_CURVED;
    assert_false(psplat_program_key_reduce(boxed).is_boxed);
    boxed.options = 0;
    boxed.is_resolve = 1;
    assert_false(psplat_program_key_reduce(boxed).is_boxed);
    /* Colours that are written nowhere are a texel to skip. */
    psplat_program_key plain = {.pass = PSPLAT_PASS_NORMALS,
                                .options = PSPLAT_OPTION_WIDE | PSPLAT_OPTION_COLOR};
    assert_int_equal(psplat_program_key_reduce(plain).options, PSPLAT_OPTION_WIDE);
}

static void compile_all(psplat_api api, int clip_step) {
    psplat_host *host = NULL;
    psplat_error error = {0};
    psplat_gl gl;
    assert_int_equal(psplat_host_create(api, 1, &host, &error), PSPLAT_OK);
    assert_int_equal(psplat_gl_load(&gl, psplat_host_get_proc, host, &error), PSPLAT_OK);
    psplat_allocator allocator = {0};
    psplat_programs programs = {0};
    key_list list = some_keys(clip_step);
    for (size_t i = 0; i < list.count; ++i) {
        const psplat_program *program = NULL;
        psplat_result result =
            psplat_programs_find(&programs, &gl, &allocator, list.keys[i], &program, &error);
        if (result)
            fail_msg("options 0x%x of pass %d: %s", list.keys[i].options, list.keys[i].pass,
                     error.text);
        assert_true(same(&program->key, &list.keys[i]));
    }
    assert_int_equal(programs.count, list.count);
    print_message("%zu programs\n", programs.count);
    psplat_programs_destroy(&programs, &gl, &allocator);
    free(list.keys);
    psplat_host_destroy(host);
}

/* What a program does without: textures whose targets are not there, those of normals where nothing
 * shows a normal or splats have one each, and coordinates where there is no texture. */
static void test_no_textures(void **state) {
    (void)state;
    const unsigned all = PSPLAT_OPTIONS_MAPS | PSPLAT_OPTION_TEXCOORD_BEND;
    psplat_program_key key = {.pass = PSPLAT_PASS_NORMALS, .options = all | PSPLAT_OPTION_FIELD};
    const unsigned normals =
        PSPLAT_OPTION_FIELD | PSPLAT_OPTION_NORMAL_MAP | PSPLAT_OPTION_TEXCOORD_BEND;
    assert_int_equal(psplat_program_key_reduce(key).options, normals);
    key.shading = PSPLAT_SHADING_DEPTH;
    assert_int_equal(psplat_program_key_reduce(key).options, PSPLAT_OPTION_FIELD);
    key.shading = PSPLAT_SHADING_UNLIT;
    key.options |= PSPLAT_OPTION_COLORS;
    const unsigned colors = PSPLAT_OPTION_FIELD | PSPLAT_OPTION_COLORS | PSPLAT_OPTION_BASE_MAP |
                            PSPLAT_OPTION_TEXCOORD_BEND;
    assert_int_equal(psplat_program_key_reduce(key).options, colors);
    key = (psplat_program_key){.pass = PSPLAT_PASS_RADIANCE, .options = all};
    assert_int_equal(psplat_program_key_reduce(key).options,
                     all & ~(unsigned)PSPLAT_OPTION_NORMAL_MAP);
    key = (psplat_program_key){.pass = PSPLAT_PASS_VISIBILITY, .options = all};
    assert_int_equal(psplat_program_key_reduce(key).options, 0);
}

/* Compiles programs with each set of textures that differs in code, for all kinds of splats with
 * what takes most varyings, and with as little as there may be. */
static void compile_textured(psplat_api api) {
    static const unsigned kinds[] = {0, PSPLAT_OPTION_TANGENT, PSPLAT_OPTION_CURVED,
                                     PSPLAT_OPTION_CURVED | PSPLAT_OPTION_SHAPE};
    const unsigned most = PSPLAT_OPTION_FINISH | PSPLAT_OPTION_GAMMA | PSPLAT_OPTION_BENDS |
                          PSPLAT_OPTION_TWO_SIDED | PSPLAT_OPTION_FILTER | PSPLAT_OPTION_WIDE;
    psplat_host *host = NULL;
    psplat_error error = {0};
    psplat_gl gl;
    assert_int_equal(psplat_host_create(api, 1, &host, &error), PSPLAT_OK);
    assert_int_equal(psplat_gl_load(&gl, psplat_host_get_proc, host, &error), PSPLAT_OK);
    psplat_allocator allocator = {0};
    psplat_programs programs = {0};
    for (unsigned set = 0; set < 4 * 4 * 16; ++set) {
        unsigned maps = PSPLAT_OPTIONS_MAPS;
        if (!(set & 1)) maps = (unsigned)PSPLAT_OPTION_BASE_MAP << (set % 5);
        psplat_program_key key = {.pass = (int)(set / 64), .options = kinds[set / 16 % 4] | maps};
        key.options |= PSPLAT_OPTION_FIELD | PSPLAT_OPTIONS_TARGETS;
        if (set & 2) key.options |= PSPLAT_OPTION_MASK;
        if (set & 4) key.options |= PSPLAT_OPTION_TEXCOORD_BEND | PSPLAT_OPTION_MAP_TRANSFORM;
        if (set & 8) key.options |= most;
        key.is_faded = set & 8 ? 1 : 0;
        if (set & 8) key.clip_count = PSPLAT_MAX_CLIP_LINES;
        const psplat_program *program = NULL;
        psplat_result result =
            psplat_programs_find(&programs, &gl, &allocator, key, &program, &error);
        if (result) fail_msg("options 0x%x of pass %d: %s", key.options, key.pass, error.text);
    }
    print_message("%zu programs\n", programs.count);
    assert_true(programs.count > 100);
    psplat_programs_destroy(&programs, &gl, &allocator);
    psplat_host_destroy(host);
}

/* Passes without weights do not tell seams from lines that are not there, and where all lines are
 * seams they share the programs of splats without lines. */
static void test_seam_keys(void **state) {
    (void)state;
    static const struct {
        psplat_program_key key;
        int has_seams, clip_count, seam_count; /* reduced */
    } cases[] = {
        {{.pass = PSPLAT_PASS_NORMALS, .clip_count = 2, .seam_count = 1}, 1, 2, 1},
        {{.pass = PSPLAT_PASS_NORMALS, .clip_count = 2, .seam_count = 2}, 1, 2, 2},
        {{.pass = PSPLAT_PASS_NORMALS, .clip_count = 2}, 0, 2, 0},
        {{.pass = PSPLAT_PASS_RADIANCE, .clip_count = 3, .seam_count = 3}, 1, 3, 3},
        {{.pass = PSPLAT_PASS_VISIBILITY, .clip_count = 2, .seam_count = 1}, 0, 2, 1},
        {{.pass = PSPLAT_PASS_VISIBILITY, .clip_count = 2, .seam_count = 2}, 0, 0, 0},
        {{.pass = PSPLAT_PASS_PARAMETERS, .clip_count = 4, .seam_count = 4}, 0, 0, 0},
        {{.pass = PSPLAT_PASS_NORMALS,
          .options = PSPLAT_OPTION_COUNT,
          .clip_count = 2,
          .seam_count = 2},
         0,
         0,
         0},
        {{.pass = PSPLAT_PASS_NORMALS,
          .options = PSPLAT_OPTION_CURVED,
          .part = PSPLAT_PART_UNCUT,
          .clip_count = 2,
          .seam_count = 2},
         0,
         2,
         0},
        {{.is_resolve = 1, .clip_count = 2, .seam_count = 2}, 0, 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_program_key reduced = psplat_program_key_reduce(cases[i].key);
        psplat_program_key again = psplat_program_key_reduce(reduced);
        assert_true(same(&reduced, &again));
        assert_int_equal(psplat_program_has_seams(&reduced), cases[i].has_seams);
        assert_int_equal(reduced.clip_count, cases[i].clip_count);
        assert_int_equal(reduced.seam_count, cases[i].seam_count);
    }
}

/* Compiles programs with seams in all passes, of flat and curved splats, with as few varyings as
 * there may be and with most of them. */
static void compile_seams(psplat_api api) {
    static const unsigned kinds[] = {0, PSPLAT_OPTION_TANGENT, PSPLAT_OPTION_CURVED};
    static const int lines[][2] = {{1, 1}, {2, 1}, {3, 2}, {4, 1}, {4, 4}};
    const unsigned most = PSPLAT_OPTION_FINISH | PSPLAT_OPTION_GAMMA | PSPLAT_OPTION_BENDS |
                          PSPLAT_OPTION_TWO_SIDED | PSPLAT_OPTION_FILTER | PSPLAT_OPTION_WIDE |
                          PSPLAT_OPTION_FIELD | PSPLAT_OPTIONS_TARGETS | PSPLAT_OPTIONS_MAPS;
    psplat_host *host = NULL;
    psplat_error error = {0};
    psplat_gl gl;
    assert_int_equal(psplat_host_create(api, 1, &host, &error), PSPLAT_OK);
    assert_int_equal(psplat_gl_load(&gl, psplat_host_get_proc, host, &error), PSPLAT_OK);
    psplat_allocator allocator = {0};
    psplat_programs programs = {0};
    for (size_t set = 0; set < 4 * 3 * 2 * 5; ++set) {
        const int *counts = lines[set % 5];
        psplat_program_key key = {.pass = (int)(set / 30),
                                  .options = kinds[set / 10 % 3] | (set / 5 % 2 ? most : 0),
                                  .is_faded = set / 5 % 2,
                                  .clip_count = counts[0],
                                  .seam_count = counts[1]};
        const psplat_program *program = NULL;
        psplat_result result =
            psplat_programs_find(&programs, &gl, &allocator, key, &program, &error);
        if (result) fail_msg("options 0x%x of pass %d: %s", key.options, key.pass, error.text);
    }
    print_message("%zu programs\n", programs.count);
    psplat_programs_destroy(&programs, &gl, &allocator);
    psplat_host_destroy(host);
}

static void test_seams_gl(void **state) {
    (void)state;
    compile_seams(PSPLAT_API_GL);
}

static void test_seams_gles(void **state) {
    (void)state;
    compile_seams(PSPLAT_API_GLES);
}

static void test_textured_gl(void **state) {
    (void)state;
    compile_textured(PSPLAT_API_GL);
}

static void test_textured_gles(void **state) {
    (void)state;
    compile_textured(PSPLAT_API_GLES);
}

static void test_gl(void **state) {
    (void)state;
    compile_all(PSPLAT_API_GL, 1);
}

static void test_gles(void **state) {
    (void)state;
    compile_all(PSPLAT_API_GLES, 4); /* none and all: the others differ only in a vector's length */
}

int test_gl_program_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_seam_keys),   cmocka_unit_test(test_seams_gl),
        cmocka_unit_test(test_seams_gles),  cmocka_unit_test(test_bounded),
        cmocka_unit_test(test_no_use),      cmocka_unit_test(test_no_textures),
        cmocka_unit_test(test_textured_gl), cmocka_unit_test(test_textured_gles),
        cmocka_unit_test(test_gl),          cmocka_unit_test(test_gles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

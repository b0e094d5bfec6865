/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * plan.c - the plan of a tileset, as a file and as what `make` reads.
 */
#define _XOPEN_SOURCE 700 /* realpath */

#include "tiles/plan.h"

#include "base/output.h"
#include "base/path.h"
#include "base/vector.h"
#include "import/triangle_stream.h"
#include "mesh/clean.h"
#include "tiles/checked_text.h"
#include "tiles/plan_folder.h"
#include "tiles/tile_block.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* The version of plans and of what lies in work/. */
enum { PLAN_VERSION = 1 };
/* The most blocks of a plan that is read. */
enum { MOST_BLOCKS = 1 << 24 };
/* The parts of the input that its hash is of, and their bytes. */
enum { HASHED_PARTS = 64, HASHED_BYTES = 4096 };

static psplat_result fail_memory(psplat_error *error) {
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for the plan");
}

/* ---- the input ------------------------------------------------------------------------------- */

/* Stores size and hash of a file. Returns 0 where it cannot be read. */
static int identify(const char *path, uint64_t *size, uint64_t *hash) {
    char part[HASHED_BYTES];
    struct stat status;
    int file = open(path, O_RDONLY | O_CLOEXEC);
    int is_read = file >= 0 && !fstat(file, &status);
    *size = is_read ? (uint64_t)status.st_size : 0;
    *hash = PSPLAT_HASH_BEGIN;
    for (uint64_t i = 0; i < HASHED_PARTS && is_read; ++i) {
        uint64_t at = *size > HASHED_BYTES ? (*size - HASHED_BYTES) / (HASHED_PARTS - 1) * i : 0;
        ssize_t got = pread(file, part, sizeof part, (off_t)at);
        is_read = got >= 0;
        if (is_read) *hash = psplat_hash_bytes(*hash, part, (size_t)got);
    }
    if (file >= 0) close(file);
    return is_read;
}

psplat_result psplat_tile_plan_check_input(const psplat_tile_plan *plan, psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    uint64_t size, hash;
    if (!identify(plan->input, &size, &hash)) return PSPLAT_OK;
    if (size == plan->input_size && hash == plan->input_hash) return PSPLAT_OK;
    psplat_path_shorten(plan->input, shown);
    return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0,
                       "%s: has changed since it was planned; plan anew with --overwrite", shown);
}

/* ---- text ------------------------------------------------------------------------------------ */

/* Adds what makes two plans equal: the input and what was asked for. */
static void add_request(const psplat_tile_plan *plan, psplat_checked_text *text) {
    const psplat_tile_options *o = &plan->options;
    const psplat_convert_desc *c = &o->convert;
    const double numbers[] = {c->tolerance_percent,       c->normal_tolerance_degrees,
                              c->crease_angle_degrees,    c->precision,
                              c->color_tolerance_percent, o->apron};
    psplat_checked_add(text, "input %s\nsize %" PRIu64 " hash %" PRIu64 "\nnumbers", plan->input,
                       plan->input_size, plan->input_hash);
    psplat_checked_numbers(text, numbers, sizeof numbers / sizeof *numbers);
    psplat_checked_add(text,
                       "\nflags %d %d %d %d %d effort %d seed %" PRIu64 " most %" PRIu64
                       " splats %" PRIu64 "\n",
                       c->no_creases, c->constant_normals, c->planar, o->no_compress,
                       o->has_fallback, c->effort + 1, c->seed, o->most_triangles, o->most_splats);
}

static void add_material(const psplat_material *m, psplat_checked_text *text) {
    double numbers[9] = {0};
    for (int k = 0; k < 4; ++k) numbers[k] = (double)m->base_color[k];
    for (int k = 0; k < 3; ++k) numbers[4 + k] = (double)m->emissive[k];
    numbers[7] = (double)m->metallic;
    numbers[8] = (double)m->roughness;
    psplat_checked_add(text, "material");
    psplat_checked_numbers(text, numbers, 9);
    psplat_checked_add(text, " %d %d\n", m->double_sided, m->unlit);
}

static void add_leaves(const psplat_tile_leaves *leaves, psplat_checked_text *text) {
    psplat_checked_add(text, "root");
    psplat_checked_numbers(text, leaves->root.low, 3);
    psplat_checked_numbers(text, leaves->root.high, 3);
    psplat_checked_add(text, "\ntriangles %" PRIu64 " %d %d %d %d\nleaves %zu\n", leaves->triangles,
                       leaves->is_single, leaves->has_normals, leaves->has_colors,
                       leaves->is_closed, leaves->count);
    for (size_t i = 0; i < leaves->count; ++i) {
        const psplat_tile_leaf *leaf = &leaves->leaves[i];
        psplat_checked_add(text, "r%s %" PRIu64 " %" PRIu64, leaf->path, leaf->first, leaf->count);
        if (leaf->count) psplat_checked_numbers(text, leaf->low, 3);
        if (leaf->count) psplat_checked_numbers(text, leaf->high, 3);
        psplat_checked_add(text, "\n");
    }
}

/* Adds a line for each task with those that have to be finished before. They follow from the
 * leaves, and stand here for people and other programs. */
static void add_tasks(const psplat_tile_tasks *tasks, psplat_checked_text *text) {
    for (size_t i = 0; i < tasks->count; ++i) {
        const psplat_tile_task *task = &tasks->list[i];
        psplat_checked_add(text, "task %s wave %d needs", task->name, task->wave);
        for (size_t k = 0; k < task->need_count; ++k)
            if (!task->needs[k].is_original)
                psplat_checked_add(text, " %s", tasks->list[task->needs[k].task].name);
        psplat_checked_add(text, "\n");
    }
}

static void read_request(psplat_words *words, psplat_tile_plan *plan) {
    psplat_tile_options *o = &plan->options;
    psplat_convert_desc *c = &o->convert;
    int *flags[] = {&c->no_creases, &c->constant_normals, &c->planar, &o->no_compress,
                    &o->has_fallback};
    double *numbers[] = {&c->tolerance_percent,       &c->normal_tolerance_degrees,
                         &c->crease_angle_degrees,    &c->precision,
                         &c->color_tolerance_percent, &o->apron};
    psplat_words_expect(words, "input");
    plan->input = strdup(psplat_words_line(words));
    psplat_words_expect(words, "size");
    plan->input_size = psplat_words_count(words);
    psplat_words_expect(words, "hash");
    plan->input_hash = psplat_words_count(words);
    psplat_words_expect(words, "numbers");
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i)
        *numbers[i] = psplat_words_number(words);
    psplat_words_expect(words, "flags");
    for (size_t i = 0; i < sizeof flags / sizeof *flags; ++i)
        *flags[i] = psplat_words_count(words) != 0;
    psplat_words_expect(words, "effort");
    c->effort = (int)psplat_words_count(words) - 1;
    psplat_words_expect(words, "seed");
    c->seed = psplat_words_count(words);
    psplat_words_expect(words, "most");
    o->most_triangles = psplat_words_count(words);
    psplat_words_expect(words, "splats");
    o->most_splats = psplat_words_count(words);
}

static void read_material(psplat_words *words, psplat_material *m) {
    double numbers[9];
    psplat_words_expect(words, "material");
    psplat_words_numbers(words, numbers, 9);
    for (int k = 0; k < 4; ++k) m->base_color[k] = (float)numbers[k];
    for (int k = 0; k < 3; ++k) m->emissive[k] = (float)numbers[4 + k];
    m->metallic = (float)numbers[7];
    m->roughness = (float)numbers[8];
    m->double_sided = psplat_words_count(words) != 0;
    m->unlit = psplat_words_count(words) != 0;
}

static void read_leaf(psplat_words *words, psplat_tile_leaf *leaf) {
    const char *name = psplat_words_next(words);
    words->failed |= *name != 'r' || strlen(name) > PSPLAT_MOST_BLOCK_DEPTH + 1 ||
                     strspn(name + 1, "01") != strlen(name) - 1;
    if (words->failed) return;
    memcpy(leaf->path, name + 1, strlen(name));
    leaf->first = psplat_words_count(words);
    leaf->count = psplat_words_count(words);
    for (int k = 0; k < 3; ++k) leaf->low[k] = HUGE_VAL, leaf->high[k] = -HUGE_VAL;
    if (leaf->count) psplat_words_numbers(words, leaf->low, 3);
    if (leaf->count) psplat_words_numbers(words, leaf->high, 3);
}

/* Returns 0 when out of memory. */
static int read_leaves(psplat_words *words, psplat_tile_leaves *leaves) {
    double low[3], high[3];
    psplat_words_expect(words, "root");
    psplat_words_numbers(words, low, 3);
    psplat_words_numbers(words, high, 3);
    leaves->root = psplat_tile_cell_root(low, high);
    psplat_words_expect(words, "triangles");
    leaves->triangles = psplat_words_count(words);
    leaves->is_single = psplat_words_count(words) != 0;
    leaves->has_normals = psplat_words_count(words) != 0;
    leaves->has_colors = psplat_words_count(words) != 0;
    leaves->is_closed = psplat_words_count(words) != 0;
    psplat_words_expect(words, "leaves");
    leaves->count = (size_t)psplat_words_count(words);
    words->failed |= !leaves->count || leaves->count > MOST_BLOCKS;
    if (words->failed) return 1;
    leaves->leaves = calloc(leaves->count, sizeof *leaves->leaves);
    for (size_t i = 0; i < leaves->count && leaves->leaves && !words->failed; ++i) {
        read_leaf(words, &leaves->leaves[i]);
        words->failed |= i && strcmp(leaves->leaves[i - 1].path, leaves->leaves[i].path) >= 0;
    }
    return leaves->leaves != NULL;
}

/* Makes what follows from the leaves. */
static psplat_result complete(psplat_tile_plan *plan, psplat_error *error) {
    double d[3];
    sub3(d, plan->leaves.root.high, plan->leaves.root.low);
    plan->diagonal = length3(d);
    if (psplat_tile_tasks_make(&plan->leaves, plan->options.apron, &plan->tasks))
        return fail_memory(error);
    return PSPLAT_OK;
}

psplat_result psplat_tile_plan_read(const char *directory, psplat_tile_plan *plan,
                                    psplat_error *error) {
    char *path = psplat_tile_path(directory, "plan", "");
    char shown[PSPLAT_SHOWN_PATH];
    psplat_words words = {0};
    *plan = (psplat_tile_plan){0};
    if (!path) return fail_memory(error);
    psplat_path_shorten(path, shown);
    psplat_result result = psplat_words_open(path, "plan", PLAN_VERSION, &words, error);
    free(path);
    if (result) return result;
    plan->hash = words.hash;
    read_request(&words, plan);
    read_material(&words, &plan->material);
    int has_memory = plan->input && read_leaves(&words, &plan->leaves);
    if (!has_memory)
        result = fail_memory(error);
    else if (words.failed)
        result =
            psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "%s: is no plan of this program", shown);
    else
        result = complete(plan, error);
    psplat_words_close(&words);
    if (result) psplat_tile_plan_free(plan);
    return result;
}

void psplat_tile_plan_free(psplat_tile_plan *plan) {
    free(plan->input);
    psplat_tile_tasks_free(&plan->tasks);
    psplat_tile_leaves_free(&plan->leaves);
    *plan = (psplat_tile_plan){0};
}

/* ---- the directory --------------------------------------------------------------------------- */

static psplat_result write_text(const char *directory, const char *name, psplat_checked_text *text,
                                psplat_error *error) {
    char *path = text->failed ? NULL : psplat_tile_path(directory, name, "");
    psplat_result result =
        path ? psplat_output_write(path, text->text, text->size, 1, error) : fail_memory(error);
    free(path);
    free(text->text);
    *text = (psplat_checked_text){0};
    return result;
}

static psplat_result make_directory(const char *directory, const char *name, psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    struct stat status;
    char *path = psplat_tile_path(directory, name, "");
    if (!path) return fail_memory(error);
    int is_there = !mkdir(path, 0777) || (!stat(path, &status) && S_ISDIR(status.st_mode));
    int cause = errno;
    psplat_path_shorten(path, shown);
    free(path);
    if (is_there) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s: cannot be created: %s", shown,
                       strerror(cause));
}

/* Writes the names of all tasks, and of those of each wave. */
static psplat_result write_tasks(const psplat_tile_plan *plan, const char *directory,
                                 psplat_error *error) {
    psplat_checked_text all = {0}, wave = {0};
    char name[32];
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < plan->tasks.count && !result; ++i) {
        const psplat_tile_task *task = &plan->tasks.list[i];
        psplat_checked_add(&all, "%s\n", task->name);
        psplat_checked_add(&wave, "%s\n", task->name);
        if (i + 1 < plan->tasks.count && task[1].wave == task->wave) continue;
        snprintf(name, sizeof name, "tasks-%d", task->wave);
        result = write_text(directory, name, &wave, error);
    }
    free(wave.text);
    if (!result) return write_text(directory, "tasks", &all, error);
    free(all.text);
    return result;
}

/* Returns a path as make and, between quotes of its recipes, the shell take it, malloc'ed, or
 * NULL. */
static char *escape_for_make(const char *path) {
    char *escaped = malloc(3 * strlen(path) + 1), *to = escaped;
    for (; escaped && *path; ++path) {
        if (strchr("\"\\`", *path)) *to++ = '\\';             /* for the shell */
        if (*path == '$') to = memcpy(to, "\\$", 2), to += 2; /* \$$: for both */
        if (*path == '#') *to++ = '\\';
        *to++ = *path;
    }
    if (escaped) *to = 0;
    return escaped;
}

/* Writes what make needs. That a record is newer than another says nothing, so that prerequisites
 * are for the order alone. */
static psplat_result write_makefile(const psplat_tile_plan *plan, const char *program,
                                    const char *directory, psplat_error *error) {
    psplat_checked_text text = {0};
    char *escaped = escape_for_make(program);
    if (!escaped) return fail_memory(error);
    psplat_checked_add(
        &text,
        "# Written by phongsplat tile plan: make -j2 -C DIRECTORY builds the tileset.\n"
        "PHONGSPLAT ?= %s\n"
        "export OMP_NUM_THREADS ?= 1\n"
        "all: tileset.json\n"
        ".PHONY: all\n"
        "tileset.json:",
        escaped);
    free(escaped);
    for (size_t i = 0; i < plan->tasks.count; ++i)
        psplat_checked_add(&text, " work/%s.record", plan->tasks.list[i].name);
    psplat_checked_add(&text, "\n\t\"$(PHONGSPLAT)\" tile merge .\n"
                              "work/%%.record:\n\t\"$(PHONGSPLAT)\" tile node . $*\n");
    for (size_t i = 0; i < plan->tasks.count; ++i) {
        const psplat_tile_task *task = &plan->tasks.list[i];
        if (!task->wave) continue;
        psplat_checked_add(&text, "work/%s.record: |", task->name);
        for (size_t k = 0; k < task->need_count; ++k)
            if (!task->needs[k].is_original)
                psplat_checked_add(&text, " work/%s.record",
                                   plan->tasks.list[task->needs[k].task].name);
        for (int k = 0; k < 2; ++k)
            psplat_checked_add(&text, " work/%s.record", plan->tasks.list[task->children[k]].name);
        psplat_checked_add(&text, "\n");
    }
    return write_text(directory, "Makefile", &text, error);
}

static psplat_result write_plan(psplat_tile_plan *plan, const char *directory,
                                psplat_error *error) {
    psplat_checked_text text = {0};
    psplat_checked_begin(&text, "plan", PLAN_VERSION);
    add_request(plan, &text);
    add_material(&plan->material, &text);
    add_leaves(&plan->leaves, &text);
    add_tasks(&plan->tasks, &text);
    plan->hash = psplat_checked_end(&text);
    return write_text(directory, "plan", &text, error);
}

/* Gives options that are at their defaults the values that these mean, so that a plan with such a
 * value is the same as one without. */
static void resolve_defaults(psplat_tile_options *o) {
    psplat_convert_desc *c = &o->convert;
    if (!(c->tolerance_percent > 0)) c->tolerance_percent = PSPLAT_DEFAULT_TOLERANCE_PERCENT;
    if (!(c->crease_angle_degrees > 0)) c->crease_angle_degrees = 30;
    if (!c->effort) c->effort = PSPLAT_DEFAULT_EFFORT;
    if (!o->most_splats) o->most_splats = PSPLAT_MOST_TILE_SPLATS;
}

/* Returns whether two plans are of the same input and options. */
static int is_same_request(const psplat_tile_plan *a, const psplat_tile_plan *b) {
    psplat_checked_text left = {0}, right = {0};
    add_request(a, &left);
    add_request(b, &right);
    int is_same = !left.failed && !right.failed && !strcmp(left.text, right.text);
    free(left.text);
    free(right.text);
    return is_same;
}

/* Returns whether a file of a directory is there. */
static int has_file(const char *directory, const char *name) {
    struct stat status;
    char *path = psplat_tile_path(directory, name, "");
    int has = path && !stat(path, &status);
    free(path);
    return has;
}

static psplat_result refuse(const char *directory, const char *why, psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(directory, shown);
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s: %s", shown, why);
}

/* Returns whether the file `plan` of a directory begins as plans do, of whatever version. */
static int is_plan(const char *directory) {
    static const char begin[] = "phongsplat tile plan ";
    char line[sizeof begin] = "";
    char *path = psplat_tile_path(directory, "plan", "");
    FILE *file = path ? fopen(path, "rb") : NULL;
    int is_ours = file && fgets(line, sizeof line, file) && !strcmp(line, begin);
    if (file) fclose(file);
    free(path);
    return is_ours;
}

/* Refuses a directory that holds anything but a plan, and another plan unless that may be
 * overwritten. *is_done is set, and old is that plan, if it is the same and whole. */
static psplat_result check_directory(const psplat_tile_plan *plan, const char *directory,
                                     int overwrite, psplat_tile_plan *old, int *is_done,
                                     psplat_error *error) {
    psplat_error ignored = {0};
    *is_done = 0;
    if (!is_plan(directory)) {
        int is_empty = psplat_plan_folder_is_empty(directory);
        if (is_empty < 0 && errno == ENOTDIR) return refuse(directory, "is no directory", error);
        if (is_empty < 0) return refuse(directory, strerror(errno), error);
        if (is_empty) return PSPLAT_OK;
        return refuse(directory, "holds files that are not those of a plan", error);
    }
    int is_same = !psplat_tile_plan_read(directory, old, &ignored) && is_same_request(plan, old);
    *is_done = is_same && has_file(directory, "work/triangles");
    if (*is_done || overwrite) return PSPLAT_OK;
    if (is_same)
        return refuse(directory,
                      "holds this plan without work/triangles, which tasks need; --overwrite plans "
                      "anew and deletes its tileset",
                      error);
    return refuse(directory, "holds another plan; replace it with --overwrite", error);
}

static psplat_result sort_input(psplat_tile_plan *plan, const char *directory,
                                psplat_error *error) {
    psplat_triangle_stream *stream;
    char *store = psplat_tile_path(directory, "triangles", "");
    if (!store) return fail_memory(error);
    psplat_result result = psplat_triangle_stream_open(plan->input, &stream, error);
    if (!result) {
        const psplat_stream_content content = *psplat_triangle_stream_content(stream);
        float colors[1];
        const psplat_mesh colored = {.corner_colors = content.has_colors ? colors : NULL};
        result = psplat_tile_leaves_sort(stream, plan->options.most_triangles, store, &plan->leaves,
                                         error);
        plan->material = content.material;
        if (!content.has_material) {
            plan->material = psplat_mesh_usual_material(&colored);
            plan->material.double_sided = !plan->leaves.is_closed;
        }
    }
    psplat_triangle_stream_close(stream);
    free(store);
    return result;
}

/* Makes all files of a plan in a directory of their own. */
static psplat_result make_new(psplat_tile_plan *plan, const char *program, const char *directory,
                              psplat_error *error) {
    psplat_result result = sort_input(plan, directory, error);
    if (!result) result = complete(plan, error);
    if (!result) result = write_tasks(plan, directory, error);
    if (!result) result = write_makefile(plan, program, directory, error);
    return result ? result : write_plan(plan, directory, error);
}

/* Moves a file of the new plan to its place. */
static psplat_result move_file(const char *directory, const char *name, const char *folder,
                               psplat_error *error) {
    char *from = psplat_tile_path(directory, PSPLAT_NEW_PLAN "/", name);
    char *to = psplat_tile_path(directory, folder, name);
    psplat_result result = PSPLAT_OK;
    if (!from || !to)
        result = fail_memory(error);
    else if (rename(from, to))
        result = refuse(to, strerror(errno), error);
    free(from);
    free(to);
    return result;
}

/* Puts the new plan in place of what is there. The triangles come last: a plan without them counts
 * as not whole, so that this may be interrupted anywhere. */
static psplat_result put_in_place(const psplat_tile_plan *plan, const char *directory,
                                  psplat_error *error) {
    char name[32];
    psplat_result result = make_directory(directory, "work", error);
    if (!result) result = make_directory(directory, "tiles", error);
    if (result) return result;
    psplat_plan_folder_clear(directory);
    result = move_file(directory, "plan", "", error);
    if (!result) result = move_file(directory, "tasks", "", error);
    for (int wave = 0; wave <= plan->tasks.list[plan->tasks.count - 1].wave && !result; ++wave) {
        snprintf(name, sizeof name, "tasks-%d", wave);
        result = move_file(directory, name, "", error);
    }
    if (!result) result = move_file(directory, "Makefile", "", error);
    return result ? result : move_file(directory, "triangles", "work/", error);
}

/* Makes a plan beside the one that is there, and replaces that in the end. */
static psplat_result make_anew(psplat_tile_plan *plan, const char *program, const char *directory,
                               psplat_error *error) {
    int was_there = has_file(directory, "");
    char *fresh = psplat_tile_path(directory, PSPLAT_NEW_PLAN, "");
    psplat_result result = fresh ? make_directory(directory, "", error) : fail_memory(error);
    if (!result) result = make_directory(directory, PSPLAT_NEW_PLAN, error);
    if (!result) result = make_new(plan, program, fresh, error);
    if (!result) result = put_in_place(plan, directory, error);
    if (fresh) psplat_plan_folder_drop_new(directory);
    if (result && !was_there) rmdir(directory);
    free(fresh);
    return result;
}

psplat_result psplat_tile_plan_make(const char *input, const psplat_tile_options *options,
                                    const char *program, const char *directory, int overwrite,
                                    psplat_tile_plan *plan, psplat_error *error) {
    psplat_tile_plan old = {0};
    char shown[PSPLAT_SHOWN_PATH];
    int is_done = 0;
    *plan = (psplat_tile_plan){.options = *options};
    resolve_defaults(&plan->options);
    psplat_path_shorten(input, shown);
    plan->input = realpath(input, NULL);
    if (!plan->input || !identify(plan->input, &plan->input_size, &plan->input_hash)) {
        int cause = errno;
        psplat_tile_plan_free(plan);
        return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s: cannot be read: %s", shown,
                           strerror(cause));
    }
    psplat_result result = PSPLAT_OK;
    if (strchr(plan->input, '\n')) /* which ends a line of the plan */
        result = psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                             "%s: has a line break in its path, which plans do not take", shown);
    if (!result) result = check_directory(plan, directory, overwrite, &old, &is_done, error);
    if (!result && is_done) {
        psplat_tile_plan_free(plan);
        *plan = old;
        return PSPLAT_OK;
    }
    if (!result) result = make_anew(plan, program, directory, error);
    psplat_tile_plan_free(&old);
    if (result) psplat_tile_plan_free(plan);
    return result;
}

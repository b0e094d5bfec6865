/* SPDX-License-Identifier: MIT
 *
 * bench_open.c - what opening an asset and uploading it cost.
 *
 *     bench_open [--splats N] [--rounds N] [FILE.glb]...
 *
 * Without a file: a sphere of N splats (1000000) as floats, as integers and as compressed integers,
 * each in a file of its own, read from the system's cache. Each is opened with its splats and to
 * draw alone (psplat_asset_desc.only_draws), in turn. Milliseconds of CPU time, medians of the
 * rounds (9):
 *
 *     read    the file into memory
 *     parse   the rest of psplat_asset_open: JSON, decompression, checks, unpacking, and where
 *             the asset only draws, packing
 *     upload  in glTexImage2D and glTexSubImage2D
 *     pack    the rest of psplat_model_create
 *     finish  glFinish after it
 *
 * and the wall time of all that.
 */
#include "core/files.h"
#include "bench_gl.h"
#include "measure.h"
#include "table_rows.h"
#include "scene_asset.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MAX_ROUNDS = 1000 };

typedef enum phase { READ = 0, PARSE, UPLOAD, PACK, FINISH, TOTAL, WALL, PHASE_COUNT } phase;

static void fail(const char *what, const char *why) {
    fprintf(stderr, "bench_open: %s: %s\n", what, why);
    exit(1);
}

/* ---- what is timed from within -------------------------------------------------------------- */

static psplat_result read_file(void *user, const psplat_allocator *allocator, const char *path,
                               size_t max_size, void **data, size_t *size) {
    double *milliseconds = user;
    psplat_files files = psplat_files_default(NULL);
    instant start = measure_now();
    psplat_result result = files.read(files.user, allocator, path, max_size, data, size);
    *milliseconds += measure_since(start).cpu;
    return result;
}

/* The state is global, because GL functions have no user pointer. */
static struct {
    bench_gl gl;
    double milliseconds;
} upload;

static void PSPLAT_GL_CALL image(GLenum target, GLint level, GLint internal_format, GLsizei width,
                                 GLsizei height, GLint border, GLenum format, GLenum type,
                                 const void *pixels) {
    instant start = measure_now();
    upload.gl.base.TexImage2D(target, level, internal_format, width, height, border, format, type,
                              pixels);
    upload.milliseconds += measure_since(start).cpu;
}

static void PSPLAT_GL_CALL sub_image(GLenum target, GLint level, GLint x, GLint y, GLsizei width,
                                     GLsizei height, GLenum format, GLenum type,
                                     const void *pixels) {
    instant start = measure_now();
    upload.gl.base.TexSubImage2D(target, level, x, y, width, height, format, type, pixels);
    upload.milliseconds += measure_since(start).cpu;
}

static void *get_proc(void *user, const char *name) {
    void (*image_function)(void) = (void (*)(void))image;
    void (*sub_image_function)(void) = (void (*)(void))sub_image;
    void *address = NULL;
    if (strcmp(name, "glTexImage2D") == 0)
        memcpy(&address, &image_function, sizeof address);
    else if (strcmp(name, "glTexSubImage2D") == 0)
        memcpy(&address, &sub_image_function, sizeof address);
    else
        address = psplat_host_get_proc(user, name);
    return address;
}

/* ---- rounds
 * -------------------------------------------------------------------------------------- */

/* Returns the number of splats. */
static size_t run(psplat_renderer *renderer, const char *path, int only_draws,
                  double phases[PHASE_COUNT]) {
    psplat_asset *asset = NULL;
    psplat_model *model = NULL;
    psplat_error error;
    psplat_asset_desc desc = {.files = {read_file, &phases[READ]}, .only_draws = only_draws};
    phases[READ] = upload.milliseconds = 0;
    instant start = measure_now();
    if (psplat_asset_open(path, &desc, &asset, &error)) fail(path, error.text);
    double opened = measure_since(start).cpu;
    if (psplat_model_create(renderer, asset, &model, &error)) fail(path, error.text);
    double created = measure_since(start).cpu;
    upload.gl.Finish();
    instant total = measure_since(start);
    phases[PARSE] = opened - phases[READ];
    phases[UPLOAD] = upload.milliseconds;
    phases[PACK] = created - opened - upload.milliseconds;
    phases[FINISH] = total.cpu - created;
    phases[TOTAL] = total.cpu;
    phases[WALL] = total.wall;
    size_t splats = 0;
    for (size_t i = 0; i < psplat_asset_batch_count(asset); ++i)
        splats += psplat_asset_batch(asset, i)->splat_count;
    psplat_model_destroy(renderer, model);
    psplat_asset_destroy(asset);
    return splats;
}

static void run_rounds(psplat_renderer *renderer, const char *name, const char *path,
                       size_t rounds) {
    static double phases[2][PHASE_COUNT][MAX_ROUNDS];
    static const char *const kinds[2] = {"splats", "only draws"};
    size_t splats = 0;
    for (size_t round = 0; round < rounds; ++round)
        for (int kind = 0; kind < 2; ++kind) {
            double taken[PHASE_COUNT];
            splats = run(renderer, path, kind, taken);
            for (int i = 0; i < PHASE_COUNT; ++i) phases[kind][i][round] = taken[i];
        }
    for (int kind = 0; kind < 2; ++kind) {
        printf("| %s | %s | %zu |", name, kinds[kind], splats);
        for (int i = 0; i < PHASE_COUNT; ++i)
            printf(" %.1f |", measure_median(phases[kind][i], rounds));
        printf("\n");
    }
}

/* Writes the bytes to a file of their own, measures it and frees the bytes. bytes NULL: nothing
 * happens. */
static void run_bytes(psplat_renderer *renderer, const char *name, uint8_t *glb, size_t size,
                      size_t rounds) {
    char path[] = "/tmp/bench_open_XXXXXX";
    if (!glb) return;
    int descriptor = mkstemp(path);
    if (descriptor < 0) fail(path, "cannot be made");
    FILE *file = fdopen(descriptor, "wb");
    if (!file || fwrite(glb, 1, size, file) != size || fclose(file))
        fail(path, "cannot be written");
    free(glb);
    run_rounds(renderer, name, path, rounds);
    unlink(path);
}

static void run_spheres(psplat_renderer *renderer, size_t count, size_t rounds) {
    scene s = scene_sphere(count, 1.0f);
    size_t size = 0;
    uint8_t *glb = scene_glb(&s, &size);
    scene_free(&s);
    run_bytes(renderer, "floats", glb, size, rounds);
    glb = rows_glb(count, 0, &size);
    run_bytes(renderer, "integers", glb, size, rounds);
    glb = rows_glb(count, 1, &size);
    run_bytes(renderer, "compressed", glb, size, rounds);
}

int main(int argc, char **argv) {
    size_t splats = 1000000, rounds = 9;
    int i = 1;
    for (; i + 1 < argc && argv[i][0] == '-'; i += 2) {
        size_t value = strtoul(argv[i + 1], NULL, 10);
        if (strcmp(argv[i], "--splats") == 0 && value)
            splats = value;
        else if (strcmp(argv[i], "--rounds") == 0 && value && value <= MAX_ROUNDS)
            rounds = value;
        else
            fail(argv[i], "unknown, or its value out of range");
    }
    psplat_host *host = NULL;
    psplat_renderer *renderer = NULL;
    psplat_error error;
    if (psplat_host_create(PSPLAT_API_GL, 1, &host, &error)) fail("host", error.text);
    bench_gl_load(&upload.gl, psplat_host_get_proc, host);
    psplat_renderer_desc desc = {.get_proc = get_proc, .user = host};
    if (psplat_renderer_create(&desc, &renderer, &error)) fail("renderer", error.text);
    printf(
        "| file | asset | splats | read | parse | upload | pack | finish | CPU ms | wall ms |\n");
    printf("|---|---|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    if (i == argc) run_spheres(renderer, splats, rounds);
    for (; i < argc; ++i) run_rounds(renderer, argv[i], argv[i], rounds);
    psplat_renderer_destroy(renderer);
    psplat_host_destroy(host);
    return 0;
}

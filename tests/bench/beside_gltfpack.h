/* SPDX-License-Identifier: MIT
 *
 * beside_gltfpack.h - what benchmarks share that put files of `phongsplat convert` beside those of
 * gltfpack: options, models, conversions.
 */
#ifndef BESIDE_GLTFPACK_H
#define BESIDE_GLTFPACK_H

#include "compare/source_mesh.h"

#include <stddef.h>
#include <stdio.h>

#include <phongsplat/splat.h>

enum { BENCH_MOST = 32 };

typedef struct bench_list {
    double values[BENCH_MOST];
    size_t count;
} bench_list;

/* The command line. Texts are those of argv. */
typedef struct bench_options {
    const char *gltfpack;   /* --gltfpack PROGRAM, or NULL: the one in PATH */
    const char *phongsplat; /* --phongsplat PROGRAM */
    const char *folder;     /* --folder DIRECTORY, where models are that are no paths */
    const char *csv;        /* --csv FILE, or NULL */
    const char *passed[BENCH_MOST], *models[BENCH_MOST]; /* --pass ARGUMENT; operands */
    size_t passed_count, model_count;
    bench_list tolerances;        /* --tolerances, percent */
    bench_list normal_tolerances; /* --normal-tolerances, degrees; 0 stands for none */
    bench_list ratios;            /* --ratios of triangles that gltfpack keeps */
    bench_list sizes;             /* --size or --sizes of pictures, pixels */
} bench_options;

/* Prints the error and ends the program unless result is PSPLAT_OK. */
void bench_check(psplat_result result, const psplat_error *error);

/* Returns the numbers of a text that separates them by commas. Ends the program where it is none.
 */
bench_list bench_parse_list(const char *text);

/* Reads the command line over the usual options of a benchmark, whose models (a list that ends with
 * NULL) stand in for those of a command line without any. PSPLAT_BENCH_MODELS is the folder where
 * no option names one. Ends the program at an option without a value. */
void bench_parse(bench_options *set, const char *const *usual_models, int argc, char **argv);

/* Calls run for every model that is there, and names those that are not on standard error. name is
 * that of the file. */
void bench_run_models(const bench_options *set,
                      void (*run)(void *user, const char *path, const char *name), void *user);

/* Returns the file that --csv names, which the caller closes, or NULL without the option. Ends the
 * program where it cannot be written. */
FILE *bench_open_csv(const bench_options *set);

/* Runs convert. Returns whether a file was written. Exit code 9, a promise that is broken in
 * places, is accepted, because tables show it; others are printed. tolerance is in percent,
 * normal_tolerance in degrees, 0 for none. */
int bench_convert(const bench_options *set, const char *model, double tolerance,
                  double normal_tolerance, const char *output);

/* Returns the bytes of a file, or NAN where it is not there. */
double bench_bytes_of(const char *path);

/* Writes a mesh as OBJ. Ends the program where it cannot be written. */
void bench_write_obj(const psplat_source_mesh *mesh, const char *path);

#endif

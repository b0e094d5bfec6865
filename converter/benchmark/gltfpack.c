/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * gltfpack.c - meshoptimizer's simplifier, where it is installed, is what a user would take instead
 * of splats. It is run as a program, and its files are read as any other mesh.
 */
#include "benchmark/gltfpack.h"

#include "benchmark/subprocess.h"
#include "table/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The arguments that are always there, and room for options. */
enum { FIXED_ARGUMENTS = 10, ARGUMENTS = 24 };

psplat_gltfpack psplat_gltfpack_find(const char *program) {
    psplat_gltfpack found = {.program = program ? program : "gltfpack"};
    const char *const arguments[] = {found.program, "-v", NULL};
    int code = psplat_subprocess_run(arguments, found.version, sizeof found.version);
    if (code || !*found.version) *found.version = 0;
    return found;
}

int psplat_gltfpack_reads(const char *path) {
    const char *dot = strrchr(path, '.');
    return dot && (!strcmp(dot, ".obj") || !strcmp(dot, ".gltf") || !strcmp(dot, ".glb"));
}

/* Keeps a name that begins with a dash from being an option. */
static char *as_operand(const char *path) {
    size_t size = strlen(path) + 3;
    char *operand = malloc(size);
    if (operand) snprintf(operand, size, "%s%s", *path == '-' ? "./" : "", path);
    return operand;
}

psplat_result psplat_gltfpack_run(const psplat_gltfpack *gltfpack, const char *input, double ratio,
                                  const char *const *options, const char *output,
                                  psplat_error *error) {
    psplat_text number = {0};
    char line[160] = "", *from = as_operand(input), *to = as_operand(output);
    psplat_text_number(&number, ratio);
    psplat_result result =
        from && to ? psplat_text_check(&number, error)
                   : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a command line");
    if (!result) {
        const char *arguments[ARGUMENTS] = {
            gltfpack->program, "-i", from, "-o", to, "-sv", "-se", "1", "-si", number.data};
        for (size_t i = 0; options[i] && FIXED_ARGUMENTS + i + 1 < ARGUMENTS; ++i)
            arguments[FIXED_ARGUMENTS + i] = options[i];
        int code = psplat_subprocess_run(arguments, line, sizeof line);
        if (code)
            result = psplat_fail(error, PSPLAT_ERROR_READ, 0, "gltfpack -si %s: %s%.120s",
                                 number.data, *line ? "" : "failed without a word", line);
    }
    free(number.data);
    free(from);
    free(to);
    return result;
}

/* SPDX-License-Identifier: MIT
 *
 * simplified_drawing.c - looks for a simplified mesh of equal picture error; see
 * simplified_drawing.h.
 */
#include "simplified_drawing.h"

#include "benchmark/gltfpack.h"
#include "benchmark/write_obj.h"
#include "quality.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static const double least_ratio = 0.001, precision = 1.0 / 32;

typedef struct search {
    const simplified_desc *desc;
    psplat_gltfpack gltfpack;
    quality_reference reference;
    char directory[40], input[64], output[64];
} search;

static void fail(const char *what, const char *why) {
    fprintf(stderr, "bench: %s: %s\n", what, why);
    exit(1);
}

/* Writes the source with the normals that the converter sees, which are those of its pictures. */
static void write_source(const search *s) {
    psplat_text text = {0};
    psplat_write_obj(s->desc->source->original, &text);
    FILE *file = fopen(s->input, "wb");
    if (text.failed || !file || fwrite(text.data, 1, text.size, file) != text.size || fclose(file))
        fail(s->input, "cannot be written");
    free(text.data);
}

static double error_of(const search *s, const draw_method *method) {
    return quality_measure(s->desc->host, s->desc->subject, method, PSPLAT_MODE_PHONG,
                           &s->reference)
        .image;
}

/* Makes the mesh with this part of the triangles and returns its error. */
static double simplify(const search *s, double ratio, mesh *out) {
    static const char *const plain[] = {"-noq", NULL};
    psplat_error error;
    if (psplat_gltfpack_run(&s->gltfpack, s->input, ratio, plain, s->output, &error))
        fail("gltfpack", error.text);
    mesh_read_like(s->output, s->desc->source, out);
    draw_method drawn = draw_method_mesh(s->desc->host, out);
    double found = error_of(s, &drawn);
    draw_method_destroy(&drawn);
    return found;
}

/* Returns the error of a mesh that is not kept. */
static double try_ratio(const search *s, double ratio) {
    mesh tried;
    double error = simplify(s, ratio, &tried);
    mesh_free(&tried);
    return error;
}

/* Returns the part of the triangles that the error of the splats takes. */
static double bisect(const search *s, double splat_error) {
    double coarse = least_ratio, fine = 1.0;
    if (try_ratio(s, fine) > splat_error)
        fail("gltfpack", "even its finest mesh differs more from the source than the splats");
    while (fine > coarse * (1.0 + precision)) {
        double ratio = sqrt(coarse * fine);
        if (try_ratio(s, ratio) > splat_error)
            coarse = ratio;
        else
            fine = ratio;
    }
    return fine;
}

void simplified_read(const simplified_desc *desc, simplified *result) {
    search s = {.desc = desc,
                .gltfpack = psplat_gltfpack_find(desc->gltfpack),
                .directory = "/tmp/bench_draw.XXXXXX"};
    if (!*s.gltfpack.version) fail(desc->gltfpack, "cannot be run");
    if (!mkdtemp(s.directory)) fail(s.directory, "cannot be made");
    snprintf(s.input, sizeof s.input, "%s/source.obj", s.directory);
    snprintf(s.output, sizeof s.output, "%s/simple.glb", s.directory);
    write_source(&s);
    s.reference = quality_draw_mesh(desc->host, desc->subject, desc->source_drawing, desc->size);
    result->splat_error = error_of(&s, desc->splats);
    result->simplified_error = simplify(&s, bisect(&s, result->splat_error), &result->mesh);
    quality_free(&s.reference);
    remove(s.input);
    remove(s.output);
    rmdir(s.directory);
}

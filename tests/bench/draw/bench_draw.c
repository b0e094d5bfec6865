/* SPDX-License-Identifier: MIT
 *
 * bench_draw.c - what frames cost. In each mode the renderer ("ours") takes turns with
 *
 *     lower bound  its primitives drawn twice with a constant shader, without blending, float
 *                  targets and resolve pass: what is left is the cost of rasterising (probe.h)
 *     sprites      the papers' own method; in phong mode (sprites.c)
 *     mesh         the mesh that the model was made from, with --mesh; in phong mode (mesh.c)
 *
 * "generated" are the fragments that the primitives of the attribute pass cover, for each pixel
 * that shows the subject, "blended" those that are left of them. CPU time is that of all threads.
 * Without --hardware GL is drawn in software; GPU times are printed with it.
 */
#include "draw_options.h"
#include "interleaved_timing.h"
#include "table.h"
#ifdef BENCH_MESH
#include "source_drawing.h"
#endif

#include <stdio.h>
#include <stdlib.h>

/* The contestants of a subject: ours first. Counters of fragments take no part in the race. */
typedef struct field {
    contestant racing[RACE_MAX_CONTESTANTS];
    size_t count, phong_first; /* those from phong_first on draw nothing but phong */
    contestant counting[RACE_MAX_CONTESTANTS]; /* twin of racing; draw NULL: none */
} field;

static field field_make(psplat_host *host, const subject *s, const options *o) {
    const unsigned counted = PROBE_BOUND | PROBE_GENERATED;
    field f = {0};
    f.counting[f.count] = contestant_splats(host, s, counted);
    f.racing[f.count++] = contestant_splats(host, s, 0);
    f.racing[f.count++] = contestant_splats(host, s, PROBE_BOUND);
    f.phong_first = f.count;
    f.counting[f.count] = contestant_sprites(host, s, counted);
    f.racing[f.count++] = contestant_sprites(host, s, 0);
#ifdef BENCH_MESH
    if (o->mesh) {
        mesh m;
        mesh_read(o->mesh, &m);
        f.racing[f.count++] = contestant_mesh(host, &m);
        mesh_free(&m);
    }
#else
    if (o->mesh) {
        fprintf(stderr, "bench_draw: built without the converter, which reads meshes\n");
        exit(2);
    }
#endif
    return f;
}

static void field_free(field *f) {
    for (size_t i = 0; i < f->count; ++i) {
        contestant_destroy(&f->racing[i]);
        contestant_destroy(&f->counting[i]);
    }
}

static void count_fragments(psplat_host *host, const psplat_view *view, const field *f, size_t i,
                            table_row *row) {
    if (!f->counting[i].draw) return;
    double blended = race_frame(host, view, &f->racing[i], PROBE_FRAGMENTS).fragments;
    double covered = race_covered(host, view);
    double generated = race_frame(host, view, &f->counting[i], PROBE_FRAGMENTS).fragments;
    row->blended = covered > 0 ? blended / covered : 0;
    row->generated = covered > 0 ? generated / covered : 0;
}

static void run_mode(psplat_host *host, const subject *s, const options *o, const field *f,
                     const psplat_view *view) {
    race_result results[RACE_MAX_CONTESTANTS];
    size_t count = view->mode == PSPLAT_MODE_PHONG ? f->count : f->phong_first;
    race_run(host, view, f->racing, count, o->frames, o->warm_up, results);
    for (size_t i = 0; i < count; ++i) {
        table_row row = {
            s->name, s->splat_count, view->width, view->mode, f->racing[i].name, &results[i], 0, 0,
            0};
        count_fragments(host, view, f, i, &row);
        if (results[i].frame.cpu > 0) row.ratio = results[0].frame.cpu / results[i].frame.cpu;
        table_print(o, &row);
    }
}

static void run_subject(psplat_host *host, subject s, const options *o) {
    const double direction[3] = {0.3, 0.4, 1.0};
    field f = field_make(host, &s, o);
    for (size_t i = 0; i < o->size_count; ++i)
        for (size_t k = 0; k < o->mode_count; ++k) {
            psplat_view view = subject_view(&s, direction, o->sizes[i], o->lights);
            view.mode = o->modes[k];
            view.shading = o->shading;
            view.no_filter = o->no_filter;
            run_mode(host, &s, o, &f, &view);
        }
    field_free(&f);
    subject_close(&s);
}

int main(int argc, char **argv) {
    options o = options_parse(argc, argv);
    psplat_host *host = NULL;
    psplat_error error;
    if (psplat_host_create(PSPLAT_API_GL, !o.hardware, &host, &error)) {
        fprintf(stderr, "bench_draw: %s\n", error.text);
        return 1;
    }
    probe_open(host);
    table_head(&o, host);
    for (size_t i = 0; i < o.sphere_count; ++i) run_subject(host, subject_sphere(o.spheres[i]), &o);
    for (size_t i = 0; i < o.file_count; ++i) run_subject(host, subject_open(o.files[i]), &o);
    probe_close();
    psplat_host_destroy(host);
    return 0;
}

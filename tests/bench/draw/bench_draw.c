/* SPDX-License-Identifier: MIT
 *
 * bench_draw.c - measures what frames cost. In each mode the renderer ("ours") draws frames in turn
 * with these methods:
 *
 *     lower bound  its primitives drawn twice with a constant shader, without blending, float
 *                  targets and resolve pass: what is left is the cost of rasterising (probe.h)
 *     no textures  the same splats, where the file has images
 *     half targets the same splats with sums of 16 bits, with --half-targets
 *     sprites      the papers' own method; in phong mode (sprites.c)
 *     mesh         the mesh that the model was made from, with --mesh; in phong mode
 *                  (source_drawing.c)
 *     gltfpack     that mesh, simplified to the picture error of the splats, with --gltfpack; in
 *                  phong mode (simplified_drawing.c)
 *
 * "generated" counts the fragments that the primitives of the attribute pass cover, per pixel that
 * shows the subject; "blended" counts those of them that are blended. CPU time is that of all
 * threads.
 * Without --hardware GL is drawn in software; GPU times are printed with it.
 */
#include "draw_options.h"
#include "interleaved_timing.h"
#include "table.h"
#ifdef BENCH_MESH
#include "simplified_drawing.h"
#include "source_drawing.h"
#endif

#include <stdio.h>
#include <stdlib.h>

/* The draw methods of a subject, ours first. The methods that count fragments are not timed. */
typedef struct method_set {
    draw_method timed[TIMING_MAX_METHODS];
    size_t count, phong_first;               /* methods from phong_first on draw only phong */
    draw_method counted[TIMING_MAX_METHODS]; /* twins of timed; draw is NULL where there is none */
} method_set;

#ifdef BENCH_MESH
enum { PICTURE_SIZE = 512 }; /* pixels of the pictures by which meshes are simplified */

/* Adds the simplified mesh and says on stderr what it is. */
static void add_simplified(method_set *m, psplat_host *host, const subject *s, const options *o,
                           const mesh *source) {
    const simplified_desc desc = {.host = host,
                                  .subject = s,
                                  .splats = &m->timed[0],
                                  .source_drawing = &m->timed[m->count - 1],
                                  .source = source,
                                  .gltfpack = o->gltfpack,
                                  .size = PICTURE_SIZE};
    simplified found;
    simplified_read(&desc, &found);
    fprintf(stderr, "gltfpack: %zu of %zu triangles, picture error %.3f %%, splats %.3f %%\n",
            found.mesh.source.triangle_count, source->source.triangle_count, found.simplified_error,
            found.splat_error);
    m->timed[m->count] = draw_method_mesh(host, &found.mesh);
    m->timed[m->count++].name = "gltfpack";
    mesh_free(&found.mesh);
}

static void add_meshes(method_set *m, psplat_host *host, const subject *s, const options *o) {
    mesh source;
    mesh_read(o->mesh, &source);
    m->timed[m->count++] = draw_method_mesh(host, &source);
    if (o->gltfpack) add_simplified(m, host, s, o, &source);
    mesh_free(&source);
}
#else
static void add_meshes(method_set *m, psplat_host *host, const subject *s, const options *o) {
    (void)m, (void)host, (void)s, (void)o;
    fprintf(stderr, "bench_draw: built without the converter, which reads meshes\n");
    exit(2);
}
#endif

static method_set method_set_make(psplat_host *host, const subject *s, const options *o) {
    const unsigned counting_options = PROBE_BOUND | PROBE_GENERATED;
    method_set m = {0};
    m.counted[m.count] = draw_method_splats(host, s, counting_options);
    m.timed[m.count++] = draw_method_splats(host, s, 0);
    m.timed[m.count++] = draw_method_splats(host, s, PROBE_BOUND);
    if (psplat_asset_image_count(s->asset) > 0)
        m.timed[m.count++] = draw_method_untextured(host, s);
    if (o->half_targets) m.timed[m.count++] = draw_method_half(host, s);
    m.phong_first = m.count;
    m.counted[m.count] = draw_method_sprites(host, s, counting_options);
    m.timed[m.count++] = draw_method_sprites(host, s, 0);
    if (o->mesh) add_meshes(&m, host, s, o);
    return m;
}

static void method_set_free(method_set *m) {
    for (size_t i = 0; i < m->count; ++i) {
        draw_method_destroy(&m->timed[i]);
        draw_method_destroy(&m->counted[i]);
    }
}

static void count_fragments(psplat_host *host, const psplat_view *view, const method_set *m,
                            size_t i, table_row *row) {
    if (!m->counted[i].draw) return;
    double blended = timing_frame(host, view, &m->timed[i], PROBE_FRAGMENTS).fragments;
    double covered = timing_covered(host, view);
    double generated = timing_frame(host, view, &m->counted[i], PROBE_FRAGMENTS).fragments;
    row->blended = covered > 0 ? blended / covered : 0;
    row->generated = covered > 0 ? generated / covered : 0;
}

static void run_mode(psplat_host *host, const subject *s, const options *o, const method_set *m,
                     const psplat_view *view) {
    timing_result results[TIMING_MAX_METHODS];
    size_t count = view->mode == PSPLAT_MODE_PHONG ? m->count : m->phong_first;
    timing_run(host, view, m->timed, count, o->frames, o->warm_up, results);
    for (size_t i = 0; i < count; ++i) {
        table_row row = {
            s->name, s->splat_count, view->width, view->mode, m->timed[i].name, &results[i], 0, 0,
            0};
        count_fragments(host, view, m, i, &row);
        if (results[i].frame.cpu > 0) row.ratio = results[0].frame.cpu / results[i].frame.cpu;
        table_print(o, &row);
    }
}

static void run_subject(psplat_host *host, subject s, const options *o) {
    const double direction[3] = {0.3, 0.4, 1.0};
    method_set m = method_set_make(host, &s, o);
    for (size_t i = 0; i < o->size_count; ++i)
        for (size_t k = 0; k < o->mode_count; ++k) {
            psplat_view view = subject_view(&s, direction, o->sizes[i], o->lights);
            view.mode = o->modes[k];
            view.shading = o->shading;
            view.no_filter = o->no_filter;
            run_mode(host, &s, o, &m, &view);
        }
    method_set_free(&m);
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
    for (size_t i = 0; i < o.curved_count; ++i)
        run_subject(host, subject_curved_sphere(o.curved[i]), &o);
    for (size_t i = 0; i < o.file_count; ++i) run_subject(host, subject_open(o.files[i]), &o);
    probe_close();
    psplat_host_destroy(host);
    return 0;
}

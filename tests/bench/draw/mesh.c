/* SPDX-License-Identifier: MIT
 * The source mesh as a contestant; see mesh.h. */
#include "mesh.h"

#include "lighting.h"
#include "probe.h"
#include "shaders/shaders.h"

#include <math.h>
#include <stdlib.h>

typedef struct drawn {
    bench_gl gl;
    GLuint program, array, buffers[2];
    GLsizei index_count;
    double model[16];
    psplat_material material;
} drawn;

static void draw(void *self, const psplat_view *view) {
    drawn *d = self;
    const psplat_gl *gl = &d->gl.base;
    gl->Viewport(0, 0, view->width, view->height);
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_LESS);
    gl->FrontFace(GL_CCW);
    if (!lighting_two_sided(view, &d->material)) gl->Enable(GL_CULL_FACE);
    gl->UseProgram(d->program);
    lighting_place(&d->gl, d->program, view, d->model);
    lighting_light(&d->gl, d->program, view, &d->material);
    gl->BindVertexArray(d->array);
    d->gl.DrawElements(GL_TRIANGLES, d->index_count, BENCH_UNSIGNED_INT, NULL);
    gl->BindVertexArray(0);
    gl->Disable(GL_CULL_FACE);
    gl->Disable(GL_DEPTH_TEST);
}

static void destroy(void *self) {
    drawn *d = self;
    d->gl.base.DeleteProgram(d->program);
    d->gl.base.DeleteVertexArrays(1, &d->array);
    d->gl.DeleteBuffers(2, d->buffers);
    free(d);
}

static void upload(drawn *d, const mesh *m) {
    static const struct {
        GLint size;
        size_t offset;
    } layout[] = {{3, offsetof(mesh_vertex, position)},
                  {3, offsetof(mesh_vertex, normal)},
                  {4, offsetof(mesh_vertex, color)}};
    const psplat_gl *gl = &d->gl.base;
    gl->GenVertexArrays(1, &d->array);
    gl->BindVertexArray(d->array);
    d->gl.GenBuffers(2, d->buffers);
    gl->BindBuffer(BENCH_ARRAY_BUFFER, d->buffers[0]);
    d->gl.BufferData(BENCH_ARRAY_BUFFER, (BENCH_intptr)(m->vertex_count * sizeof *m->vertices),
                     m->vertices, BENCH_STATIC_DRAW);
    gl->BindBuffer(BENCH_ELEMENT_ARRAY_BUFFER, d->buffers[1]);
    d->gl.BufferData(BENCH_ELEMENT_ARRAY_BUFFER,
                     (BENCH_intptr)(3 * m->triangle_count * sizeof *m->indices), m->indices,
                     BENCH_STATIC_DRAW);
    for (GLuint i = 0; i < 3; ++i) {
        d->gl.EnableVertexAttribArray(i);
        d->gl.VertexAttribPointer(i, layout[i].size, GL_FLOAT, GL_FALSE, sizeof(mesh_vertex),
                                  (const void *)(uintptr_t)layout[i].offset);
    }
    gl->BindVertexArray(0);
}

contestant contestant_mesh(psplat_host *host, const mesh *m) {
    drawn *d = calloc(1, sizeof *d);
    if (!d) abort();
    bench_gl_load(&d->gl, probe_get_proc, host);
    d->program = bench_gl_program(&d->gl, "", bench_shader_light_glsl, bench_shader_mesh_vert,
                                  bench_shader_mesh_frag);
    d->index_count = (GLsizei)(3 * m->triangle_count);
    for (int i = 0; i < 16; i += 5) d->model[i] = 1;
    for (int i = 0; i < 3; ++i) d->model[12 + i] = m->origin[i];
    d->material = m->material;
    upload(d, m);
    return (contestant){"mesh", draw, destroy, d, 0};
}

void mesh_free(mesh *m) {
    free(m->vertices);
    free(m->indices);
    *m = (mesh){0};
}

void mesh_ball(const mesh *m, double center[3], double *radius) {
    double square = 0;
    for (int i = 0; i < 3; ++i) {
        float low = m->vertices[0].position[i], high = low;
        for (size_t k = 1; k < m->vertex_count; ++k) {
            low = fminf(low, m->vertices[k].position[i]);
            high = fmaxf(high, m->vertices[k].position[i]);
        }
        center[i] = m->origin[i] + 0.5 * ((double)low + (double)high);
    }
    for (size_t k = 0; k < m->vertex_count; ++k) {
        double sum = 0;
        for (int i = 0; i < 3; ++i) {
            double d = (double)m->vertices[k].position[i] + m->origin[i] - center[i];
            sum += d * d;
        }
        square = fmax(square, sum);
    }
    *radius = sqrt(square);
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * facets.c - a mesh drawn by GL. Its positions are relative to the mesh's origin, and matrices are
 * composed in double, so that a mesh far from the origin does not tremble beside its splats.
 */
#include "facets.h"
#include "facets_gl.h"
#include "original.h"
#include "vector.h"
#include "vertices.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

struct psplat_facets {
    psplat_facets_gl gl;
    GLuint programs[2]; /* by psplat_facets_output; 0: not yet made */
    GLuint array, buffers[2];
    GLsizei index_count;
    int has_color;
    double origin[3];
    psplat_material material;
};

/* ---- making ---------------------------------------------------------------------------------- */

static void set_attribute(const psplat_facets_gl *gl, GLuint index, size_t stride) {
    gl->EnableVertexAttribArray(index);
    gl->VertexAttribPointer(index, 3, GL_FLOAT, GL_FALSE, (GLsizei)stride,
                            (const void *)(uintptr_t)(3 * index * sizeof(float)));
}

static psplat_result upload(psplat_facets *f, const psplat_vertices *vertices,
                            psplat_error *error) {
    const psplat_facets_gl *gl = &f->gl;
    size_t stride = vertices->floats * sizeof *vertices->values;
    f->index_count = (GLsizei)vertices->index_count;
    f->has_color = vertices->floats > 6;
    (void)psplat_facets_gl_errors(gl, NULL); /* of others */
    gl->GenVertexArrays(1, &f->array);
    gl->BindVertexArray(f->array);
    gl->GenBuffers(2, f->buffers);
    gl->BindBuffer(GL_ARRAY_BUFFER, f->buffers[0]);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(vertices->count * stride), vertices->values,
                   GL_STATIC_DRAW);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, f->buffers[1]);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER,
                   (GLsizeiptr)(vertices->index_count * sizeof *vertices->indices),
                   vertices->indices, GL_STATIC_DRAW);
    for (GLuint i = 0; i < (f->has_color ? 3u : 2u); ++i) set_attribute(gl, i, stride);
    gl->BindVertexArray(0);
    gl->BindBuffer(GL_ARRAY_BUFFER, 0);
    return psplat_facets_gl_errors(gl, error);
}

static psplat_result fill(psplat_facets *f, const psplat_original *original, psplat_error *error) {
    psplat_vertices vertices = {0};
    if (original->mesh->triangle_count > INT_MAX / 3)
        return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "%zu triangles are too many for GL",
                           original->mesh->triangle_count);
    memcpy(f->origin, original->mesh->origin, sizeof f->origin);
    f->material = original->mesh->material;
    psplat_result result = psplat_vertices_unite(original, &vertices, error);
    if (!result) result = upload(f, &vertices, error);
    psplat_vertices_free(&vertices);
    return result;
}

psplat_result psplat_facets_create(const psplat_facets_desc *desc, psplat_facets **facets,
                                   psplat_error *error) {
    psplat_facets *f = calloc(1, sizeof *f);
    *facets = NULL;
    if (!f) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory to draw a mesh");
    psplat_result result = psplat_facets_gl_load(&f->gl, desc->get_proc, desc->user, error);
    if (result) { /* without its functions there is nothing to delete */
        free(f);
        return result;
    }
    result = psplat_facets_gl_program(&f->gl, 0, &f->programs[PSPLAT_FACETS_LIGHT], error);
    if (!result) result = fill(f, desc->original, error);
    if (result)
        psplat_facets_destroy(f);
    else
        *facets = f;
    return result;
}

void psplat_facets_destroy(psplat_facets *facets) {
    if (!facets) return;
    const psplat_facets_gl *gl = &facets->gl;
    for (int i = 0; i < 2; ++i) gl->DeleteProgram(facets->programs[i]);
    gl->DeleteVertexArrays(1, &facets->array);
    gl->DeleteBuffers(2, facets->buffers);
    free(facets);
}

/* ---- drawing --------------------------------------------------------------------------------- */

static void multiply(const double a[16], const double b[16], double product[16]) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += a[4 * k + row] * b[4 * column + k];
            product[4 * column + row] = sum;
        }
}

static void set_matrix(const psplat_facets_gl *gl, GLuint program, const char *name,
                       const double matrix[16]) {
    GLfloat values[16];
    for (int i = 0; i < 16; ++i) values[i] = (GLfloat)matrix[i];
    gl->UniformMatrix4fv(gl->GetUniformLocation(program, name), 1, GL_FALSE, values);
}

static void place(const psplat_facets *f, GLuint program, const psplat_view *view) {
    double model[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, modelview[16], clip[16];
    memcpy(model + 12, f->origin, sizeof f->origin);
    multiply(view->view, model, modelview);
    multiply(view->projection, modelview, clip);
    set_matrix(&f->gl, program, "u_modelview", modelview);
    set_matrix(&f->gl, program, "u_clip", clip);
    f->gl.Uniform1i(f->gl.GetUniformLocation(program, "u_parallel"), view->projection[15] > 0);
}

/* Towards a directional light, eye space. */
static void turn(const psplat_view *view, const float direction[3], GLfloat out[3]) {
    double eye[3] = {0, 0, 0};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) eye[i] -= view->view[4 * k + i] * (double)direction[k];
    normalize3(eye);
    for (int i = 0; i < 3; ++i) out[i] = (GLfloat)eye[i];
}

static void set_vectors(const psplat_facets *f, GLuint program, const char *name, GLsizei count,
                        const GLfloat *values) {
    f->gl.Uniform3fv(f->gl.GetUniformLocation(program, name), count, values);
}

static void light(const psplat_facets *f, GLuint program, const psplat_view *view) {
    GLfloat directions[3 * PSPLAT_MAX_LIGHTS], colors[3 * PSPLAT_MAX_LIGHTS];
    const psplat_material *m = &f->material;
    const GLfloat surface[3] = {m->metallic, m->roughness, m->unlit ? 1.f : 0.f};
    for (int i = 0; i < view->light_count; ++i) {
        turn(view, view->lights[i].direction, directions + 3 * i);
        memcpy(colors + 3 * i, view->lights[i].color, sizeof view->lights[i].color);
    }
    set_vectors(f, program, "u_light_directions", view->light_count, directions);
    set_vectors(f, program, "u_light_colors", view->light_count, colors);
    set_vectors(f, program, "u_ambient", 1, view->ambient);
    set_vectors(f, program, "u_base_color", 1, m->base_color);
    set_vectors(f, program, "u_emissive", 1, m->emissive);
    set_vectors(f, program, "u_surface", 1, surface);
    f->gl.Uniform1i(f->gl.GetUniformLocation(program, "u_light_count"), view->light_count);
    f->gl.Uniform1i(f->gl.GetUniformLocation(program, "u_linear_output"), view->linear_output);
}

static psplat_result check(const psplat_view *view, psplat_error *error) {
    int known =
        view->light_count >= 0 && view->light_count <= PSPLAT_MAX_LIGHTS && !view->environment;
    for (int i = 0; known && i < view->light_count; ++i)
        known = view->lights[i].type == PSPLAT_LIGHT_DIRECTIONAL && !view->lights[i].casts_shadow;
    if (known) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                       "meshes are drawn under directional lights without shadows alone");
}

static int is_two_sided(const psplat_facets *f, const psplat_view *view) {
    return view->culling == PSPLAT_CULL_NEVER ||
           (view->culling == PSPLAT_CULL_BY_MATERIAL && f->material.double_sided);
}

static void draw_triangles(const psplat_facets *f, int two_sided) {
    const psplat_facets_gl *gl = &f->gl;
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_LESS);
    gl->FrontFace(GL_CCW);
    gl->CullFace(GL_BACK);
    if (!two_sided) gl->Enable(GL_CULL_FACE);
    if (!f->has_color) gl->VertexAttrib3f(2, 1, 1, 1);
    gl->BindVertexArray(f->array);
    gl->DrawElements(GL_TRIANGLES, f->index_count, GL_UNSIGNED_INT, NULL);
    gl->BindVertexArray(0);
    gl->Disable(GL_CULL_FACE);
    gl->Disable(GL_DEPTH_TEST);
}

psplat_result psplat_facets_draw(psplat_facets *facets, const psplat_view *view,
                                 psplat_facets_output output, psplat_error *error) {
    const psplat_facets_gl *gl = &facets->gl;
    GLuint *program = &facets->programs[output];
    psplat_result result = check(view, error);
    if (!result && !*program)
        result = psplat_facets_gl_program(gl, output == PSPLAT_FACETS_NORMALS, program, error);
    if (result) return result;
    int two_sided = is_two_sided(facets, view);
    (void)psplat_facets_gl_errors(gl, NULL); /* of others */
    gl->Viewport(view->x, view->y, view->width, view->height);
    gl->UseProgram(*program);
    place(facets, *program, view);
    if (output == PSPLAT_FACETS_LIGHT) light(facets, *program, view);
    gl->Uniform1i(gl->GetUniformLocation(*program, "u_two_sided"), two_sided);
    draw_triangles(facets, two_sided);
    gl->UseProgram(0);
    return psplat_facets_gl_errors(gl, error);
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * facets.c - a mesh drawn by GL. Its positions are relative to the mesh's origin, and matrices are
 * composed in double, so that a mesh far from the origin does not tremble beside its splats.
 */
#include "facets.h"
#include "facets_gl.h"
#include "facets_paint.h"
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
    psplat_wall *walls; /* what is drawn at once: one for each group of the mesh */
    size_t wall_count;
    int has_color;
    double origin[3];
};

/* ---- making ---------------------------------------------------------------------------------- */

/* offset: floats before it in a vertex; moves behind the attribute. */
static void set_attribute(const psplat_facets_gl *gl, GLuint index, GLint components,
                          const psplat_vertices *vertices, size_t *offset) {
    gl->EnableVertexAttribArray(index);
    gl->VertexAttribPointer(index, components, GL_FLOAT, GL_FALSE,
                            (GLsizei)(vertices->floats * sizeof(float)),
                            (const void *)(uintptr_t)(*offset * sizeof(float)));
    *offset += (size_t)components;
}

static psplat_result upload(psplat_facets *f, const psplat_vertices *vertices,
                            psplat_error *error) {
    const psplat_facets_gl *gl = &f->gl;
    size_t stride = vertices->floats * sizeof *vertices->values, offset = 0;
    f->has_color = vertices->has_color;
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
    set_attribute(gl, 0, 3, vertices, &offset);
    set_attribute(gl, 1, 3, vertices, &offset);
    if (vertices->has_color) set_attribute(gl, 2, 3, vertices, &offset);
    if (vertices->has_texcoords) set_attribute(gl, 3, 4, vertices, &offset);
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
    psplat_result result = psplat_vertices_unite(original, &vertices, error);
    if (!result) result = upload(f, &vertices, error);
    if (!result)
        result = psplat_walls_create(&f->gl, original->mesh, &vertices, &f->walls, &f->wall_count,
                                     error);
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
    psplat_walls_destroy(gl, facets->walls, facets->wall_count);
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
    for (int i = 0; i < view->light_count; ++i) {
        turn(view, view->lights[i].direction, directions + 3 * i);
        memcpy(colors + 3 * i, view->lights[i].color, sizeof view->lights[i].color);
    }
    set_vectors(f, program, "u_light_directions", view->light_count, directions);
    set_vectors(f, program, "u_light_colors", view->light_count, colors);
    set_vectors(f, program, "u_ambient", 1, view->ambient);
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

static int is_two_sided(const psplat_wall *wall, const psplat_view *view) {
    return view->culling == PSPLAT_CULL_NEVER ||
           (view->culling == PSPLAT_CULL_BY_MATERIAL && wall->material.double_sided);
}

static void draw_walls(const psplat_facets *f, GLuint program, const psplat_view *view) {
    const psplat_facets_gl *gl = &f->gl;
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_LESS);
    gl->FrontFace(GL_CCW);
    gl->CullFace(GL_BACK);
    if (!f->has_color) gl->VertexAttrib3f(2, 1, 1, 1);
    gl->BindVertexArray(f->array);
    for (size_t i = 0; i < f->wall_count; ++i) {
        const psplat_wall *wall = &f->walls[i];
        int two_sided = is_two_sided(wall, view);
        (two_sided ? gl->Disable : gl->Enable)(GL_CULL_FACE);
        gl->Uniform1i(gl->GetUniformLocation(program, "u_two_sided"), two_sided);
        psplat_wall_bind(gl, wall, program);
        gl->DrawElements(GL_TRIANGLES, wall->index_count, GL_UNSIGNED_INT,
                         (const void *)(uintptr_t)(wall->first_index * sizeof(uint32_t)));
    }
    psplat_wall_unbind(gl);
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
    (void)psplat_facets_gl_errors(gl, NULL); /* of others */
    gl->Viewport(view->x, view->y, view->width, view->height);
    gl->UseProgram(*program);
    place(facets, *program, view);
    if (output == PSPLAT_FACETS_LIGHT) light(facets, *program, view);
    draw_walls(facets, *program, view);
    gl->UseProgram(0);
    return psplat_facets_gl_errors(gl, error);
}

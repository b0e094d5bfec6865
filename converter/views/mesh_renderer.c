/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh_renderer.c - the mesh renderer: draws a mesh with GL. Positions are relative to the mesh's
 * origin, and matrices are composed in double, so that a mesh far from the origin of the scene is
 * drawn as exactly as its splats.
 */
#include "views/mesh_renderer.h"

#include "base/vector.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "views/mesh_programs.h"
#include "views/mesh_textures.h"
#include "views/vertex_buffer.h"

#include <phongsplat/phongsplat.h>

#include <limits.h>
#include <stdlib.h>
#include <string.h>

struct psplat_mesh_renderer {
    psplat_mesh_programs gl;
    GLuint programs[2]; /* by psplat_mesh_renderer_output; 0 until it is needed */
    GLuint array, buffers[2];
    psplat_drawn_group *groups; /* one draw call for each */
    size_t group_count;
    int has_color;
    double origin[3];
};

/* ---- creation -------------------------------------------------------------------------------- */

/* Sets a vertex attribute that begins *offset floats into a vertex, and moves *offset behind it. */
static void set_attribute(const psplat_mesh_programs *gl, GLuint index, GLint components,
                          const psplat_vertex_buffer *vertices, size_t *offset) {
    gl->EnableVertexAttribArray(index);
    gl->VertexAttribPointer(index, components, GL_FLOAT, GL_FALSE,
                            (GLsizei)(vertices->floats * sizeof(float)),
                            (const void *)(uintptr_t)(*offset * sizeof(float)));
    *offset += (size_t)components;
}

static psplat_result upload(psplat_mesh_renderer *r, const psplat_vertex_buffer *vertices,
                            psplat_error *error) {
    const psplat_mesh_programs *gl = &r->gl;
    size_t stride = vertices->floats * sizeof *vertices->values, offset = 0;
    r->has_color = vertices->has_color;
    (void)psplat_mesh_programs_errors(gl, NULL); /* clears errors of earlier callers */
    gl->GenVertexArrays(1, &r->array);
    gl->BindVertexArray(r->array);
    gl->GenBuffers(2, r->buffers);
    gl->BindBuffer(GL_ARRAY_BUFFER, r->buffers[0]);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(vertices->count * stride), vertices->values,
                   GL_STATIC_DRAW);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, r->buffers[1]);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER,
                   (GLsizeiptr)(vertices->index_count * sizeof *vertices->indices),
                   vertices->indices, GL_STATIC_DRAW);
    set_attribute(gl, 0, 3, vertices, &offset);
    set_attribute(gl, 1, 3, vertices, &offset);
    if (vertices->has_color) set_attribute(gl, 2, 3, vertices, &offset);
    if (vertices->has_texcoords) set_attribute(gl, 3, 4, vertices, &offset);
    gl->BindVertexArray(0);
    gl->BindBuffer(GL_ARRAY_BUFFER, 0);
    return psplat_mesh_programs_errors(gl, error);
}

static psplat_result fill(psplat_mesh_renderer *r, const psplat_source_mesh *source,
                          psplat_error *error) {
    psplat_vertex_buffer vertices = {0};
    if (source->mesh->triangle_count > INT_MAX / 3)
        return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "%zu triangles are too many for GL",
                           source->mesh->triangle_count);
    memcpy(r->origin, source->mesh->origin, sizeof r->origin);
    psplat_result result = psplat_vertex_buffer_unite(source, &vertices, error);
    if (!result) result = upload(r, &vertices, error);
    if (!result)
        result = psplat_drawn_groups_create(&r->gl, source->mesh, &vertices, &r->groups,
                                            &r->group_count, error);
    psplat_vertex_buffer_free(&vertices);
    return result;
}

psplat_result psplat_mesh_renderer_create(const psplat_mesh_renderer_desc *desc,
                                          psplat_mesh_renderer **renderer, psplat_error *error) {
    psplat_mesh_renderer *r = calloc(1, sizeof *r);
    *renderer = NULL;
    if (!r) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory to draw a mesh");
    psplat_result result = psplat_mesh_programs_load(&r->gl, desc->get_proc, desc->user, error);
    if (result) { /* GL objects cannot be deleted without its functions */
        free(r);
        return result;
    }
    result =
        psplat_mesh_programs_program(&r->gl, 0, &r->programs[PSPLAT_MESH_RENDERER_LIGHT], error);
    if (!result) result = fill(r, desc->source, error);
    if (result)
        psplat_mesh_renderer_destroy(r);
    else
        *renderer = r;
    return result;
}

void psplat_mesh_renderer_destroy(psplat_mesh_renderer *renderer) {
    if (!renderer) return;
    const psplat_mesh_programs *gl = &renderer->gl;
    for (int i = 0; i < 2; ++i) gl->DeleteProgram(renderer->programs[i]);
    gl->DeleteVertexArrays(1, &renderer->array);
    gl->DeleteBuffers(2, renderer->buffers);
    psplat_drawn_groups_destroy(gl, renderer->groups, renderer->group_count);
    free(renderer);
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

static void set_matrix(const psplat_mesh_programs *gl, GLuint program, const char *name,
                       const double matrix[16]) {
    GLfloat values[16];
    for (int i = 0; i < 16; ++i) values[i] = (GLfloat)matrix[i];
    gl->UniformMatrix4fv(gl->GetUniformLocation(program, name), 1, GL_FALSE, values);
}

static void set_transforms(const psplat_mesh_renderer *r, GLuint program, const psplat_view *view) {
    double model[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, modelview[16], clip[16];
    memcpy(model + 12, r->origin, sizeof r->origin);
    multiply(view->view, model, modelview);
    multiply(view->projection, modelview, clip);
    set_matrix(&r->gl, program, "u_modelview", modelview);
    set_matrix(&r->gl, program, "u_clip", clip);
    r->gl.Uniform1i(r->gl.GetUniformLocation(program, "u_parallel"), view->projection[15] > 0);
}

/* Stores the unit vector towards a directional light, eye space. */
static void light_direction(const psplat_view *view, const float direction[3], GLfloat out[3]) {
    double eye[3] = {0, 0, 0};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) eye[i] -= view->view[4 * k + i] * (double)direction[k];
    normalize3(eye);
    for (int i = 0; i < 3; ++i) out[i] = (GLfloat)eye[i];
}

static void set_vectors(const psplat_mesh_renderer *r, GLuint program, const char *name,
                        GLsizei count, const GLfloat *values) {
    r->gl.Uniform3fv(r->gl.GetUniformLocation(program, name), count, values);
}

static void set_lights(const psplat_mesh_renderer *r, GLuint program, const psplat_view *view) {
    GLfloat directions[3 * PSPLAT_MAX_LIGHTS], colors[3 * PSPLAT_MAX_LIGHTS];
    for (int i = 0; i < view->light_count; ++i) {
        light_direction(view, view->lights[i].direction, directions + 3 * i);
        memcpy(colors + 3 * i, view->lights[i].color, sizeof view->lights[i].color);
    }
    set_vectors(r, program, "u_light_directions", view->light_count, directions);
    set_vectors(r, program, "u_light_colors", view->light_count, colors);
    set_vectors(r, program, "u_ambient", 1, view->ambient);
    r->gl.Uniform1i(r->gl.GetUniformLocation(program, "u_light_count"), view->light_count);
    r->gl.Uniform1i(r->gl.GetUniformLocation(program, "u_linear_output"), view->linear_output);
    r->gl.Uniform1i(r->gl.GetUniformLocation(program, "u_unlit"),
                    view->shading == PSPLAT_SHADING_UNLIT);
}

static psplat_result check(const psplat_view *view, psplat_error *error) {
    int known =
        view->light_count >= 0 && view->light_count <= PSPLAT_MAX_LIGHTS && !view->environment;
    for (int i = 0; known && i < view->light_count; ++i)
        known = view->lights[i].type == PSPLAT_LIGHT_DIRECTIONAL && !view->lights[i].casts_shadow;
    if (view->shading != PSPLAT_SHADING_LIT && view->shading != PSPLAT_SHADING_UNLIT)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "meshes are drawn lit or unlit");
    if (known) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                       "meshes are drawn under directional lights without shadows alone");
}

static int is_two_sided(const psplat_drawn_group *group, const psplat_view *view) {
    return view->culling == PSPLAT_CULL_NEVER ||
           (view->culling == PSPLAT_CULL_BY_MATERIAL && group->material.double_sided);
}

static void draw_groups(const psplat_mesh_renderer *r, GLuint program, const psplat_view *view) {
    const psplat_mesh_programs *gl = &r->gl;
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_LESS);
    gl->FrontFace(GL_CCW);
    gl->CullFace(GL_BACK);
    if (!r->has_color) gl->VertexAttrib3f(2, 1, 1, 1);
    gl->BindVertexArray(r->array);
    for (size_t i = 0; i < r->group_count; ++i) {
        const psplat_drawn_group *group = &r->groups[i];
        int two_sided = is_two_sided(group, view);
        (two_sided ? gl->Disable : gl->Enable)(GL_CULL_FACE);
        gl->Uniform1i(gl->GetUniformLocation(program, "u_two_sided"), two_sided);
        psplat_drawn_group_bind(gl, group, program);
        gl->DrawElements(GL_TRIANGLES, group->index_count, GL_UNSIGNED_INT,
                         (const void *)(uintptr_t)(group->first_index * sizeof(uint32_t)));
    }
    psplat_drawn_group_unbind(gl);
    gl->BindVertexArray(0);
    gl->Disable(GL_CULL_FACE);
    gl->Disable(GL_DEPTH_TEST);
}

psplat_result psplat_mesh_renderer_draw(psplat_mesh_renderer *renderer, const psplat_view *view,
                                        psplat_mesh_renderer_output output, psplat_error *error) {
    const psplat_mesh_programs *gl = &renderer->gl;
    GLuint *program = &renderer->programs[output];
    psplat_result result = check(view, error);
    if (!result && !*program)
        result = psplat_mesh_programs_program(gl, output == PSPLAT_MESH_RENDERER_NORMALS, program,
                                              error);
    if (result) return result;
    (void)psplat_mesh_programs_errors(gl, NULL); /* clears errors of earlier callers */
    gl->Viewport(view->x, view->y, view->width, view->height);
    gl->UseProgram(*program);
    set_transforms(renderer, *program, view);
    if (output == PSPLAT_MESH_RENDERER_LIGHT) set_lights(renderer, *program, view);
    draw_groups(renderer, *program, view);
    gl->UseProgram(0);
    return psplat_mesh_programs_errors(gl, error);
}

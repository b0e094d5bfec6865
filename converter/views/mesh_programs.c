/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh_programs.c - the GL functions and shader programs for drawing a mesh.
 */
#include "views/mesh_programs.h"

#include "views/shaders/compare_shaders.h"

#include <math.h>
#include <string.h>

/* The error flags that are read at most. A driver may hold one of each kind; a lost context returns
 * errors without end. */
enum { MAX_ERRORS = 32 };

psplat_result psplat_mesh_programs_load(psplat_mesh_programs *gl,
                                        void *(*get_proc)(void *user, const char *name), void *user,
                                        psplat_error *error) {
    void *address;
#define PSPLAT_MESH_GL_LOAD(type, name)                                                            \
    if (!(address = get_proc(user, "gl" #name)))                                                   \
        return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "the loader has no GL function gl%s",  \
                           #name);                                                                 \
    memcpy(&gl->name, &address, sizeof address);
    PSPLAT_MESH_GL_FUNCTIONS(PSPLAT_MESH_GL_LOAD)
#undef PSPLAT_MESH_GL_LOAD
    const char *version = (const char *)gl->GetString(GL_VERSION);
    if (!version) return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "no GL context is current");
    gl->is_es = strncmp(version, "OpenGL ES", 9) == 0;
    return PSPLAT_OK;
}

static psplat_result compile(const psplat_mesh_programs *gl, GLenum type, int normals,
                             const char *body, GLuint *shader, psplat_error *error) {
    const char *const sources[] = {
        gl->is_es ? "#version 300 es\nprecision highp float;\n"
                    "precision highp int;\n"
                  : "#version 330 core\n",
        normals ? "#define NORMALS 1\n" : "#define NORMALS 0\n",
        type == GL_FRAGMENT_SHADER ? psplat_compare_shader_light_glsl : "", body};
    char log[160] = "";
    GLint compiled = 0;
    *shader = gl->CreateShader(type);
    gl->ShaderSource(*shader, 4, sources, NULL);
    gl->CompileShader(*shader);
    gl->GetShaderiv(*shader, GL_COMPILE_STATUS, &compiled);
    if (compiled) return PSPLAT_OK;
    gl->GetShaderInfoLog(*shader, sizeof log, NULL, log);
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "a shader of meshes is refused: %s", log);
}

static psplat_result link_program(const psplat_mesh_programs *gl, const GLuint shaders[2],
                                  GLuint *program, psplat_error *error) {
    char log[160] = "";
    GLint linked = 0;
    *program = gl->CreateProgram();
    for (int i = 0; i < 2; ++i) gl->AttachShader(*program, shaders[i]);
    gl->LinkProgram(*program);
    gl->GetProgramiv(*program, GL_LINK_STATUS, &linked);
    if (linked) return PSPLAT_OK;
    gl->GetProgramInfoLog(*program, sizeof log, NULL, log);
    gl->DeleteProgram(*program);
    *program = 0;
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "a program of meshes is refused: %s", log);
}

psplat_result psplat_mesh_programs_program(const psplat_mesh_programs *gl, int normals,
                                           GLuint *program, psplat_error *error) {
    GLuint shaders[2] = {0, 0};
    psplat_result result =
        compile(gl, GL_VERTEX_SHADER, normals, psplat_compare_shader_mesh_vert, &shaders[0], error);
    if (!result)
        result = compile(gl, GL_FRAGMENT_SHADER, normals, psplat_compare_shader_mesh_frag,
                         &shaders[1], error);
    if (!result) result = link_program(gl, shaders, program, error);
    for (int i = 0; i < 2; ++i) gl->DeleteShader(shaders[i]);
    return result;
}

psplat_result psplat_mesh_programs_errors(const psplat_mesh_programs *gl, psplat_error *error) {
    GLenum first = gl->GetError();
    for (int i = 0; i < MAX_ERRORS && gl->GetError() != GL_NO_ERROR; ++i) {
    }
    if (first == GL_NO_ERROR) return PSPLAT_OK;
    if (first == GL_OUT_OF_MEMORY)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "GL has no memory for a mesh");
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "GL error 0x%x while drawing a mesh",
                       first);
}

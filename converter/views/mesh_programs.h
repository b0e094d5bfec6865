/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh_programs.h - the functions of GL 3.3 core and GLES 3.0 for drawing a mesh, and its shader
 * programs. The functions come from the same loader as those of the splat renderer.
 */
#ifndef PHONGSPLAT_VIEWS_MESH_PROGRAMS_H
#define PHONGSPLAT_VIEWS_MESH_PROGRAMS_H

#include <phongsplat/splat.h>

#include <GL/glcorearb.h>

#define PSPLAT_MESH_GL_FUNCTIONS(X)                                                                \
    X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                                                       \
    X(PFNGLATTACHSHADERPROC, AttachShader)                                                         \
    X(PFNGLBINDBUFFERPROC, BindBuffer)                                                             \
    X(PFNGLBINDTEXTUREPROC, BindTexture)                                                           \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                                                   \
    X(PFNGLBUFFERDATAPROC, BufferData)                                                             \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                                                       \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                                                       \
    X(PFNGLCREATESHADERPROC, CreateShader)                                                         \
    X(PFNGLCULLFACEPROC, CullFace)                                                                 \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                                                       \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                                       \
    X(PFNGLDELETESHADERPROC, DeleteShader)                                                         \
    X(PFNGLDELETETEXTURESPROC, DeleteTextures)                                                     \
    X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                                             \
    X(PFNGLDEPTHFUNCPROC, DepthFunc)                                                               \
    X(PFNGLDISABLEPROC, Disable)                                                                   \
    X(PFNGLDRAWELEMENTSPROC, DrawElements)                                                         \
    X(PFNGLENABLEPROC, Enable)                                                                     \
    X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray)                                   \
    X(PFNGLFRONTFACEPROC, FrontFace)                                                               \
    X(PFNGLGENBUFFERSPROC, GenBuffers)                                                             \
    X(PFNGLGENTEXTURESPROC, GenTextures)                                                           \
    X(PFNGLGENERATEMIPMAPPROC, GenerateMipmap)                                                     \
    X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                                                   \
    X(PFNGLGETERRORPROC, GetError)                                                                 \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                                               \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                                         \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                                                 \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                                           \
    X(PFNGLGETSTRINGPROC, GetString)                                                               \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                                             \
    X(PFNGLLINKPROGRAMPROC, LinkProgram)                                                           \
    X(PFNGLSHADERSOURCEPROC, ShaderSource)                                                         \
    X(PFNGLTEXIMAGE2DPROC, TexImage2D)                                                             \
    X(PFNGLTEXPARAMETERIPROC, TexParameteri)                                                       \
    X(PFNGLUNIFORM1IPROC, Uniform1i)                                                               \
    X(PFNGLUNIFORM1IVPROC, Uniform1iv)                                                             \
    X(PFNGLUNIFORM3FVPROC, Uniform3fv)                                                             \
    X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv)                                                 \
    X(PFNGLUSEPROGRAMPROC, UseProgram)                                                             \
    X(PFNGLVERTEXATTRIB3FPROC, VertexAttrib3f)                                                     \
    X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)                                           \
    X(PFNGLVIEWPORTPROC, Viewport)

typedef struct psplat_mesh_programs {
#define PSPLAT_MESH_GL_MEMBER(type, name) type name;
    PSPLAT_MESH_GL_FUNCTIONS(PSPLAT_MESH_GL_MEMBER)
#undef PSPLAT_MESH_GL_MEMBER
    int is_es;
} psplat_mesh_programs;

/* Loads the functions. Errors: GRAPHICS, which names the function that is missing. */
psplat_result psplat_mesh_programs_load(psplat_mesh_programs *gl,
                                        void *(*get_proc)(void *user, const char *name), void *user,
                                        psplat_error *error);

/* Creates a program that writes light, or normals. Errors: GRAPHICS with the message of the
 * compiler. */
psplat_result psplat_mesh_programs_program(const psplat_mesh_programs *gl, int normals,
                                           GLuint *program, psplat_error *error);

/* Clears all error flags of GL and reports the first one. Errors: MEMORY where GL is out of memory,
 * else GRAPHICS. */
psplat_result psplat_mesh_programs_errors(const psplat_mesh_programs *gl, psplat_error *error);

#endif

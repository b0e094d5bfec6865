/* SPDX-License-Identifier: MIT
 *
 * gl_api.h - the part of GL 3.3 core, GLES 3.0 and WebGL 2 that the runtime uses, as a table of
 * function pointers that is filled from the host's loader. So the runtime neither links GL nor
 * needs its headers.
 */
#ifndef PHONGSPLAT_GL_GL_API_H
#define PHONGSPLAT_GL_GL_API_H

#include <phongsplat/splat.h>

#include <stddef.h>

#if defined(_WIN32)
#define PSPLAT_GL_CALL __stdcall
#else
#define PSPLAT_GL_CALL
#endif

typedef unsigned int GLenum;
typedef unsigned int GLuint;
typedef unsigned int GLbitfield;
typedef int GLint;
typedef int GLsizei;
typedef ptrdiff_t GLsizeiptr;
typedef float GLfloat;
typedef char GLchar;
typedef unsigned char GLboolean;
typedef unsigned char GLubyte;

/* These values are those of the Khronos registry. */
enum {
    GL_FALSE = 0,
    GL_TRUE = 1,
    GL_NONE = 0,
    GL_NO_ERROR = 0,
    GL_ZERO = 0,
    GL_ONE = 1,
    GL_TRIANGLES = 0x0004,
    GL_LESS = 0x0201,
    GL_LEQUAL = 0x0203,
    GL_BACK = 0x0405,
    GL_FRONT_AND_BACK = 0x0408,
    GL_OUT_OF_MEMORY = 0x0505,
    GL_CONTEXT_LOST = 0x0507,
    GL_CW = 0x0900,
    GL_CCW = 0x0901,
    GL_POLYGON_MODE = 0x0B40,
    GL_POLYGON_SMOOTH = 0x0B41,
    GL_CULL_FACE = 0x0B44,
    GL_CULL_FACE_MODE = 0x0B45,
    GL_FRONT_FACE = 0x0B46,
    GL_DEPTH_TEST = 0x0B71,
    GL_DEPTH_WRITEMASK = 0x0B72,
    GL_DEPTH_FUNC = 0x0B74,
    GL_STENCIL_TEST = 0x0B90,
    GL_DEPTH_RANGE = 0x0B70,
    GL_VIEWPORT = 0x0BA2,
    GL_DITHER = 0x0BD0,
    GL_BLEND = 0x0BE2,
    GL_COLOR_LOGIC_OP = 0x0BF2,
    GL_SCISSOR_BOX = 0x0C10,
    GL_SCISSOR_TEST = 0x0C11,
    GL_COLOR_WRITEMASK = 0x0C23,
    GL_UNPACK_SWAP_BYTES = 0x0CF0,
    GL_UNPACK_ROW_LENGTH = 0x0CF2,
    GL_UNPACK_SKIP_ROWS = 0x0CF3,
    GL_UNPACK_SKIP_PIXELS = 0x0CF4,
    GL_UNPACK_ALIGNMENT = 0x0CF5,
    GL_PACK_ALIGNMENT = 0x0D05,
    GL_MAX_TEXTURE_SIZE = 0x0D33,
    GL_TEXTURE_2D = 0x0DE1,
    GL_UNSIGNED_BYTE = 0x1401,
    GL_INT = 0x1404,
    GL_FLOAT = 0x1406,
    GL_COLOR = 0x1800,
    GL_DEPTH = 0x1801,
    GL_DEPTH_COMPONENT = 0x1902,
    GL_RGB = 0x1907,
    GL_RGBA = 0x1908,
    GL_FILL = 0x1B02,
    GL_RENDERER = 0x1F01,
    GL_VERSION = 0x1F02,
    GL_EXTENSIONS = 0x1F03,
    GL_NEAREST = 0x2600,
    GL_LINEAR = 0x2601,
    GL_LINEAR_MIPMAP_LINEAR = 0x2703,
    GL_TEXTURE_MAG_FILTER = 0x2800,
    GL_TEXTURE_MIN_FILTER = 0x2801,
    GL_TEXTURE_WRAP_S = 0x2802,
    GL_TEXTURE_WRAP_T = 0x2803,
    GL_REPEAT = 0x2901,
    GL_CLIP_DISTANCE0 = 0x3000,
    GL_FUNC_ADD = 0x8006,
    GL_BLEND_EQUATION_RGB = 0x8009,
    GL_POLYGON_OFFSET_FILL = 0x8037,
    GL_RGBA8 = 0x8058,
    GL_TEXTURE_BINDING_2D = 0x8069,
    GL_SAMPLE_ALPHA_TO_COVERAGE = 0x809E,
    GL_SAMPLE_COVERAGE = 0x80A0,
    GL_BLEND_DST_RGB = 0x80C8,
    GL_BLEND_SRC_RGB = 0x80C9,
    GL_BLEND_DST_ALPHA = 0x80CA,
    GL_BLEND_SRC_ALPHA = 0x80CB,
    GL_CLAMP_TO_EDGE = 0x812F,
    GL_TEXTURE_MAX_LEVEL = 0x813D,
    GL_MAJOR_VERSION = 0x821B,
    GL_MINOR_VERSION = 0x821C,
    GL_NUM_EXTENSIONS = 0x821D,
    GL_MIRRORED_REPEAT = 0x8370,
    GL_TEXTURE0 = 0x84C0,
    GL_ACTIVE_TEXTURE = 0x84E0,
    GL_TEXTURE_MAX_ANISOTROPY = 0x84FE,
    GL_MAX_TEXTURE_MAX_ANISOTROPY = 0x84FF,
    GL_TEXTURE_CUBE_MAP = 0x8513,
    GL_TEXTURE_BINDING_CUBE_MAP = 0x8514,
    GL_TEXTURE_CUBE_MAP_POSITIVE_X = 0x8515,
    GL_VERTEX_ARRAY_BINDING = 0x85B5,
    GL_DEPTH_CLAMP = 0x864F,
    GL_RED = 0x1903,
    GL_RG = 0x8227,
    GL_R16F = 0x822D,
    GL_R32F = 0x822E,
    GL_RG16F = 0x822F,
    GL_RG32F = 0x8230,
    GL_RGBA32F = 0x8814,
    GL_RGB32F = 0x8815,
    GL_RGBA16F = 0x881A,
    GL_BLEND_EQUATION_ALPHA = 0x883D,
    GL_TEXTURE_COMPARE_MODE = 0x884C,
    GL_TEXTURE_COMPARE_FUNC = 0x884D,
    GL_COMPARE_REF_TO_TEXTURE = 0x884E,
    GL_TEXTURE_CUBE_MAP_SEAMLESS = 0x884F,
    GL_ARRAY_BUFFER = 0x8892,
    GL_ARRAY_BUFFER_BINDING = 0x8894,
    GL_STREAM_DRAW = 0x88E0,
    GL_PIXEL_UNPACK_BUFFER = 0x88EC,
    GL_PIXEL_UNPACK_BUFFER_BINDING = 0x88EF,
    GL_SAMPLER_BINDING = 0x8919,
    GL_FRAGMENT_SHADER = 0x8B30,
    GL_VERTEX_SHADER = 0x8B31,
    GL_COMPILE_STATUS = 0x8B81,
    GL_LINK_STATUS = 0x8B82,
    GL_CURRENT_PROGRAM = 0x8B8D,
    GL_SRGB8_ALPHA8 = 0x8C43,
    GL_RASTERIZER_DISCARD = 0x8C89,
    GL_DRAW_FRAMEBUFFER_BINDING = 0x8CA6,
    GL_READ_FRAMEBUFFER = 0x8CA8,
    GL_DRAW_FRAMEBUFFER = 0x8CA9,
    GL_READ_FRAMEBUFFER_BINDING = 0x8CAA,
    GL_DEPTH_COMPONENT32F = 0x8CAC,
    GL_FRAMEBUFFER_COMPLETE = 0x8CD5,
    GL_COLOR_ATTACHMENT0 = 0x8CE0,
    GL_DEPTH_ATTACHMENT = 0x8D00,
    GL_SAMPLE_MASK = 0x8E51,
    GL_PRIMITIVE_RESTART = 0x8F9D,
    GL_CONTEXT_LOST_WEBGL = 0x9242
};

/* Lists every function that must exist: X(return type, name without gl, parameters). */
#define PSPLAT_GL_FUNCTIONS(X)                                                                     \
    X(void, ActiveTexture, (GLenum unit))                                                          \
    X(void, AttachShader, (GLuint program, GLuint shader))                                         \
    X(void, BindBuffer, (GLenum target, GLuint buffer))                                            \
    X(void, BindFramebuffer, (GLenum target, GLuint framebuffer))                                  \
    X(void, BindSampler, (GLuint unit, GLuint sampler))                                            \
    X(void, BindTexture, (GLenum target, GLuint texture))                                          \
    X(void, BindVertexArray, (GLuint array))                                                       \
    X(void, BlendEquationSeparate, (GLenum rgb, GLenum alpha))                                     \
    X(void, BlendFuncSeparate, (GLenum src_rgb, GLenum dst_rgb, GLenum src_a, GLenum dst_a))       \
    X(void, BufferData, (GLenum target, GLsizeiptr size, const void *data, GLenum usage))          \
    X(GLenum, CheckFramebufferStatus, (GLenum target))                                             \
    X(void, ClearBufferfv, (GLenum buffer, GLint index, const GLfloat *value))                     \
    X(void, ColorMask, (GLboolean r, GLboolean g, GLboolean b, GLboolean a))                       \
    X(void, CompileShader, (GLuint shader))                                                        \
    X(GLuint, CreateProgram, (void))                                                               \
    X(GLuint, CreateShader, (GLenum type))                                                         \
    X(void, CullFace, (GLenum mode))                                                               \
    X(void, DeleteBuffers, (GLsizei count, const GLuint *buffers))                                 \
    X(void, DeleteFramebuffers, (GLsizei count, const GLuint *framebuffers))                       \
    X(void, DeleteProgram, (GLuint program))                                                       \
    X(void, DeleteSamplers, (GLsizei count, const GLuint *samplers))                               \
    X(void, DeleteShader, (GLuint shader))                                                         \
    X(void, DeleteTextures, (GLsizei count, const GLuint *textures))                               \
    X(void, DeleteVertexArrays, (GLsizei count, const GLuint *arrays))                             \
    X(void, DepthFunc, (GLenum func))                                                              \
    X(void, DepthMask, (GLboolean flag))                                                           \
    X(void, Disable, (GLenum capability))                                                          \
    X(void, DrawArrays, (GLenum mode, GLint first, GLsizei count))                                 \
    X(void, DrawArraysInstanced, (GLenum mode, GLint first, GLsizei count, GLsizei instances))     \
    X(void, DrawBuffers, (GLsizei count, const GLenum *buffers))                                   \
    X(void, Enable, (GLenum capability))                                                           \
    X(void, EnableVertexAttribArray, (GLuint index))                                               \
    X(void, FramebufferTexture2D,                                                                  \
      (GLenum target, GLenum attachment, GLenum texture_target, GLuint texture, GLint level))      \
    X(void, FrontFace, (GLenum mode))                                                              \
    X(void, GenBuffers, (GLsizei count, GLuint * buffers))                                         \
    X(void, GenFramebuffers, (GLsizei count, GLuint * framebuffers))                               \
    X(void, GenSamplers, (GLsizei count, GLuint * samplers))                                       \
    X(void, GenTextures, (GLsizei count, GLuint * textures))                                       \
    X(void, GenVertexArrays, (GLsizei count, GLuint * arrays))                                     \
    X(void, GenerateMipmap, (GLenum target))                                                       \
    X(void, GetBooleanv, (GLenum name, GLboolean * values))                                        \
    X(void, GetFloatv, (GLenum name, GLfloat * values))                                            \
    X(GLenum, GetError, (void))                                                                    \
    X(void, GetIntegerv, (GLenum name, GLint * values))                                            \
    X(void, GetProgramInfoLog, (GLuint program, GLsizei size, GLsizei * length, GLchar * log))     \
    X(void, GetProgramiv, (GLuint program, GLenum name, GLint * value))                            \
    X(void, GetShaderInfoLog, (GLuint shader, GLsizei size, GLsizei * length, GLchar * log))       \
    X(void, GetShaderiv, (GLuint shader, GLenum name, GLint * value))                              \
    X(const GLubyte *, GetString, (GLenum name))                                                   \
    X(const GLubyte *, GetStringi, (GLenum name, GLuint index))                                    \
    X(GLint, GetUniformLocation, (GLuint program, const GLchar *name))                             \
    X(GLboolean, IsEnabled, (GLenum capability))                                                   \
    X(void, LinkProgram, (GLuint program))                                                         \
    X(void, PixelStorei, (GLenum name, GLint value))                                               \
    X(void, ReadBuffer, (GLenum source))                                                           \
    X(void, SamplerParameteri, (GLuint sampler, GLenum name, GLint value))                         \
    X(void, Scissor, (GLint x, GLint y, GLsizei width, GLsizei height))                            \
    X(void, ShaderSource,                                                                          \
      (GLuint shader, GLsizei count, const GLchar *const *strings, const GLint *lengths))          \
    X(void, TexImage2D,                                                                            \
      (GLenum target, GLint level, GLint internal_format, GLsizei width, GLsizei height,           \
       GLint border, GLenum format, GLenum type, const void *pixels))                              \
    X(void, TexParameteri, (GLenum target, GLenum name, GLint value))                              \
    X(void, TexSubImage2D,                                                                         \
      (GLenum target, GLint level, GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, \
       GLenum type, const void *pixels))                                                           \
    X(void, Uniform1f, (GLint location, GLfloat x))                                                \
    X(void, Uniform1i, (GLint location, GLint x))                                                  \
    X(void, Uniform2f, (GLint location, GLfloat x, GLfloat y))                                     \
    X(void, Uniform2i, (GLint location, GLint x, GLint y))                                         \
    X(void, Uniform3fv, (GLint location, GLsizei count, const GLfloat *values))                    \
    X(void, Uniform4fv, (GLint location, GLsizei count, const GLfloat *values))                    \
    X(void, UniformMatrix3fv,                                                                      \
      (GLint location, GLsizei count, GLboolean transpose, const GLfloat *values))                 \
    X(void, UniformMatrix4fv,                                                                      \
      (GLint location, GLsizei count, GLboolean transpose, const GLfloat *values))                 \
    X(void, UseProgram, (GLuint program))                                                          \
    X(void, VertexAttribDivisor, (GLuint index, GLuint divisor))                                   \
    X(void, VertexAttribIPointer,                                                                  \
      (GLuint index, GLint size, GLenum type, GLsizei stride, const void *offset))                 \
    X(void, VertexAttribPointer,                                                                   \
      (GLuint index, GLint size, GLenum type, GLboolean normalized, GLsizei stride,                \
       const void *offset))                                                                        \
    X(void, Viewport, (GLint x, GLint y, GLsizei width, GLsizei height))

typedef struct psplat_gl {
#define PSPLAT_GL_MEMBER(type, name, parameters) type(PSPLAT_GL_CALL *name) parameters;
    PSPLAT_GL_FUNCTIONS(PSPLAT_GL_MEMBER)
#undef PSPLAT_GL_MEMBER
    void(PSPLAT_GL_CALL *PolygonMode)(GLenum face, GLenum mode); /* NULL on GLES */
    GLenum(PSPLAT_GL_CALL *GetGraphicsResetStatus)(void);        /* NULL without robustness */
    /* NULL before GL 4.3 without GL_ARB_invalidate_subdata, or where the loader has none */
    void(PSPLAT_GL_CALL *InvalidateFramebuffer)(GLenum target, GLsizei count,
                                                const GLenum *attachments);
    int is_es;        /* 1: GLES or WebGL */
    int is_lost;      /* 1: the context was lost, which never ends */
    int major, minor; /* version of the context */
    int half_targets; /* 1: RGBA16F is used, since the host wants it or RGBA32F cannot be drawn
                         to and blended */
    GLint max_texture_size; /* texels */
    GLint max_anisotropy;   /* of samplers; 1: there is none */
} psplat_gl;

/* Loads every function, then checks version and extensions of the current context. Fails only with
 * PSPLAT_ERROR_GRAPHICS; the text names the function, version or extension that is missing. */
psplat_result psplat_gl_load(psplat_gl *gl, void *(*get_proc)(void *user, const char *name),
                             void *user, psplat_error *error);

/* Returns 1 where the current context lists an extension. */
int psplat_gl_has_extension(const psplat_gl *gl, const char *name);

/* Reads and clears GL's error flags. Returns MEMORY where GL is out of memory, and GRAPHICS where
 * the context is lost, which gl remembers; other flags are ignored. Before the runtime makes
 * something it calls this with error NULL, which drops flags that the host left. */
psplat_result psplat_gl_errors(psplat_gl *gl, psplat_error *error);

/* Returns what a public function that used GL is to return: its result, or GRAPHICS where the
 * context was lost meanwhile. From then on no object is deleted, because the names died with the
 * context and may be those of objects in another context. */
psplat_result psplat_gl_finish(psplat_gl *gl, psplat_result result, psplat_error *error);

#endif

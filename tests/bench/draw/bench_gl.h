/* SPDX-License-Identifier: MIT
 *
 * bench_gl.h - the runtime's GL functions and those that only the benchmark calls.
 */
#ifndef PHONGSPLAT_BENCH_GL_H
#define PHONGSPLAT_BENCH_GL_H

#include "gl/gl_api.h"

#include <phongsplat/host.h>

typedef uint64_t BENCH_uint64;

enum {
    BENCH_POINTS = 0x0000,
    BENCH_UNSIGNED_INT = 0x1405,
    BENCH_PROGRAM_POINT_SIZE = 0x8642,
    BENCH_QUERY_RESULT = 0x8866,
    BENCH_ELEMENT_ARRAY_BUFFER = 0x8893,
    BENCH_STATIC_DRAW = 0x88E4,
    BENCH_TIME_ELAPSED = 0x88BF,
    BENCH_SAMPLES_PASSED = 0x8914,
    BENCH_SHADER_TYPE = 0x8B4F
};

/* The entries are X(return type, name without gl, parameters). */
#define BENCH_GL_FUNCTIONS(X)                                                                      \
    X(void, BeginQuery, (GLenum target, GLuint query))                                             \
    X(void, DeleteQueries, (GLsizei count, const GLuint *queries))                                 \
    X(void, DrawElements, (GLenum mode, GLsizei count, GLenum type, const void *indices))          \
    X(void, EndQuery, (GLenum target))                                                             \
    X(void, Finish, (void))                                                                        \
    X(void, GenQueries, (GLsizei count, GLuint * queries))                                         \
    X(void, GetQueryObjectui64v, (GLuint query, GLenum name, BENCH_uint64 * value))                \
    X(void, Uniform1f, (GLint location, GLfloat x))

typedef struct bench_gl {
    psplat_gl base;
#define BENCH_GL_MEMBER(type, name, parameters) type(PSPLAT_GL_CALL *name) parameters;
    BENCH_GL_FUNCTIONS(BENCH_GL_MEMBER)
#undef BENCH_GL_MEMBER
} bench_gl;

/* Loads the functions and ends the program where one is missing. The context is GL 3.3, whose core
 * has timer queries. */
void bench_gl_load(bench_gl *gl, void *(*get_proc)(void *user, const char *name), void *user);

/* Makes a program of GLSL 3.30. library precedes both vertex and fragment. Ends the program with
 * the compiler's message where it refuses one. */
GLuint bench_gl_program(const bench_gl *gl, const char *defines, const char *library,
                        const char *vertex, const char *fragment);

#endif

/* SPDX-License-Identifier: MIT
 *
 * bench_gl.c - GL functions and programs of the benchmark; see bench_gl.h.
 */
#include "bench_gl.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void load(void *function, void *address, const char *name) {
    if (!address) {
        fprintf(stderr, "bench: there is no %s\n", name);
        exit(1);
    }
    memcpy(function, &address, sizeof address);
}

void bench_gl_load(bench_gl *gl, void *(*get_proc)(void *user, const char *name), void *user) {
    psplat_error error;
    if (psplat_gl_load(&gl->base, get_proc, user, &error)) {
        fprintf(stderr, "bench: %s\n", error.text);
        exit(1);
    }
#define BENCH_GL_LOAD(type, name, parameters)                                                      \
    load(&gl->name, get_proc(user, "gl" #name), "gl" #name);
    BENCH_GL_FUNCTIONS(BENCH_GL_LOAD)
#undef BENCH_GL_LOAD
}

static GLuint compile(const psplat_gl *gl, GLenum type, const char *defines, const char *library,
                      const char *body) {
    const char *const sources[] = {"#version 330 core\n", defines, library, body};
    GLuint shader = gl->CreateShader(type);
    GLint compiled = 0;
    gl->ShaderSource(shader, 4, sources, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled) return shader;
    char log[1000] = "";
    gl->GetShaderInfoLog(shader, sizeof log, NULL, log);
    fprintf(stderr, "bench: shader refused: %s\n", log);
    exit(1);
}

GLuint bench_gl_program(const bench_gl *gl, const char *defines, const char *library,
                        const char *vertex, const char *fragment) {
    const psplat_gl *base = &gl->base;
    GLuint first = compile(base, GL_VERTEX_SHADER, defines, library, vertex);
    GLuint second = compile(base, GL_FRAGMENT_SHADER, defines, library, fragment);
    GLuint program = base->CreateProgram();
    GLint linked = 0;
    base->AttachShader(program, first);
    base->AttachShader(program, second);
    base->LinkProgram(program);
    base->GetProgramiv(program, GL_LINK_STATUS, &linked);
    base->DeleteShader(first);
    base->DeleteShader(second);
    if (linked) return program;
    char log[1000] = "";
    base->GetProgramInfoLog(program, sizeof log, NULL, log);
    fprintf(stderr, "bench: program refused: %s\n", log);
    exit(1);
}

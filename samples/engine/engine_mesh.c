/* SPDX-License-Identifier: MIT
 *
 * engine_mesh.c - the engine's own lit triangles; see engine_mesh.h.
 */
#include "engine_mesh.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

enum { SEGMENTS = 96, FLOATS = 6 }; /* FLOATS of a vertex: position and normal */

static const char vertex_source[] = "#version 330 core\n"
                                    "layout(location = 0) in vec3 position;\n"
                                    "layout(location = 1) in vec3 normal;\n"
                                    "uniform mat4 clip;\n"
                                    "out vec3 n, at;\n"
                                    "void main() {\n"
                                    "    n = normal;\n"
                                    "    at = position;\n"
                                    "    gl_Position = clip * vec4(position, 1.0);\n"
                                    "}\n";

static GLuint compile(const engine_gl *gl, GLenum type, const char *source) {
    GLuint shader = gl->CreateShader(type);
    gl->ShaderSource(shader, 1, &source, NULL);
    gl->CompileShader(shader);
    return shader;
}

GLuint program_make(const engine_gl *gl, const char *vertex, const char *fragment) {
    const GLuint shaders[2] = {compile(gl, GL_VERTEX_SHADER, vertex),
                               compile(gl, GL_FRAGMENT_SHADER, fragment)};
    GLuint program = gl->CreateProgram();
    GLint linked = GL_FALSE;
    for (int i = 0; i < 2; ++i) gl->AttachShader(program, shaders[i]);
    gl->LinkProgram(program);
    for (int i = 0; i < 2; ++i) gl->DeleteShader(shaders[i]);
    gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    return linked ? program : 0;
}

int paint_make(paint *p, const engine_gl *gl, const char *fragment) {
    p->program = program_make(gl, vertex_source, fragment);
    p->clip = gl->GetUniformLocation(p->program, "clip");
    p->color = gl->GetUniformLocation(p->program, "color");
    return p->program != 0;
}

void paint_use(const paint *p, const engine_gl *gl, const matrix *clip) {
    float values[16];
    matrix_to_float(clip, values);
    gl->UseProgram(p->program);
    gl->UniformMatrix4fv(p->clip, 1, GL_FALSE, values);
}

static float *put_ring(float *out, const float a[2], const float b[2]) {
    float length = hypotf(b[0] - a[0], b[1] - a[1]);
    float outward = (b[1] - a[1]) / length, upward = (a[0] - b[0]) / length;
    for (int i = 0; i < 6 * SEGMENTS; ++i) {
        static const int sides[6] = {0, 0, 1, 1, 0, 1}, ends[6] = {0, 1, 0, 0, 1, 1};
        float angle = 6.2831853f * (float)(i / 6 + sides[i % 6]) / SEGMENTS;
        const float *point = ends[i % 6] ? b : a;
        *out++ = cosf(angle) * point[0], *out++ = point[1], *out++ = sinf(angle) * point[0];
        *out++ = cosf(angle) * outward, *out++ = upward, *out++ = sinf(angle) * outward;
    }
    return out;
}

mesh mesh_lathe(const engine_gl *gl, const float (*outline)[2], int points) {
    mesh m = {.vertex_count = (points - 1) * 6 * SEGMENTS};
    const GLsizei stride = FLOATS * sizeof(float);
    float *vertices = malloc((size_t)m.vertex_count * (size_t)stride), *out = vertices;
    if (!vertices) return (mesh){0};
    for (int i = 0; i + 1 < points; ++i) out = put_ring(out, outline[i], outline[i + 1]);
    GLuint buffer;
    gl->GenVertexArrays(1, &m.array);
    gl->GenBuffers(1, &buffer);
    gl->BindVertexArray(m.array);
    gl->BindBuffer(GL_ARRAY_BUFFER, buffer);
    gl->BufferData(GL_ARRAY_BUFFER, m.vertex_count * stride, vertices, GL_STATIC_DRAW);
    gl->EnableVertexAttribArray(0);
    gl->EnableVertexAttribArray(1);
    gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, stride, NULL);
    gl->VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, stride, (const void *)(3 * sizeof(float)));
    free(vertices);
    return m;
}

void mesh_draw(const mesh *m, const engine_gl *gl, const paint *p, const float color[3]) {
    gl->Uniform3fv(p->color, 1, color);
    gl->BindVertexArray(m->array);
    gl->DrawArrays(GL_TRIANGLES, 0, m->vertex_count);
}

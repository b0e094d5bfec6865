/* SPDX-License-Identifier: MIT
 *
 * canvas.c - flat rectangles and text. The strokes of stb's font are rectangles too, so that a
 * whole overlay is one draw call.
 */
#include "viewer_gl.h"
#include "viewer.h"

#include <stb/stb_easy_font.h>
#include <stdlib.h>
#include <string.h>

typedef struct vertex {
    float x, y; /* in pixels from the upper left corner */
    uint8_t color[4];
} vertex;

struct canvas {
    gl gl;
    GLuint program, vertex_array, buffer;
    GLint size;
    int width, height;
    vertex *vertices;
    size_t count, capacity;
    int is_full; /* memory ran out; what comes after is not drawn */
};

static const char *const gl_prelude = "#version 330 core\n";
static const char *const gles_prelude = "#version 300 es\nprecision highp float;\n";

static const char *const vertex_source =
    "layout(location = 0) in vec2 position;\n"
    "layout(location = 1) in vec4 color;\n"
    "uniform vec2 size;\n"
    "out vec4 paint;\n"
    "void main() {\n"
    "    paint = color;\n"
    "    gl_Position = vec4(vec2(2, -2) * position / size + vec2(-1, 1), 0, 1);\n"
    "}\n";

/* Half a step of noise hides the bands of a dark gradient (Jimenez 2014, interleaved gradient
 * noise). Text does not need it but looks the same with it. */
static const char *const fragment_source =
    "in vec4 paint;\n"
    "out vec4 result;\n"
    "void main() {\n"
    "    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, "
    "0.00583715))));\n"
    "    result = vec4(paint.rgb + (noise - 0.5) / 255.0, paint.a);\n"
    "}\n";

static psplat_result load_gl(gl *gl, void *(*get_proc)(void *user, const char *name), void *user,
                             psplat_error *error) {
    void *address;
#define LOAD(type, member)                                                                         \
    address = get_proc(user, "gl" #member);                                                        \
    if (!address) return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "gl" #member " is missing"); \
    memcpy(&gl->member, &address, sizeof address);
    VIEWER_GL(LOAD)
#undef LOAD
    return PSPLAT_OK;
}

static GLuint compile(const gl *gl, GLenum stage, const char *source) {
    const char *version = (const char *)gl->GetString(GL_VERSION);
    int is_gles = version && !strncmp(version, "OpenGL ES", 9);
    const char *parts[] = {is_gles ? gles_prelude : gl_prelude, source};
    GLuint shader = gl->CreateShader(stage);
    gl->ShaderSource(shader, 2, parts, NULL);
    gl->CompileShader(shader);
    return shader;
}

/* A shader that does not compile does not link either, so that linking is the only check. */
static int build_program(canvas *c) {
    const gl *gl = &c->gl;
    GLuint shaders[] = {compile(gl, GL_VERTEX_SHADER, vertex_source),
                        compile(gl, GL_FRAGMENT_SHADER, fragment_source)};
    GLint is_linked = 0;
    c->program = gl->CreateProgram();
    for (int i = 0; i < 2; ++i) gl->AttachShader(c->program, shaders[i]);
    gl->LinkProgram(c->program);
    for (int i = 0; i < 2; ++i) gl->DeleteShader(shaders[i]);
    gl->GetProgramiv(c->program, GL_LINK_STATUS, &is_linked);
    c->size = gl->GetUniformLocation(c->program, "size");
    return is_linked;
}

static void make_vertex_array(canvas *c) {
    const gl *gl = &c->gl;
    gl->GenVertexArrays(1, &c->vertex_array);
    gl->GenBuffers(1, &c->buffer);
    gl->BindVertexArray(c->vertex_array);
    gl->BindBuffer(GL_ARRAY_BUFFER, c->buffer);
    const GLsizei stride = sizeof(vertex);
    gl->VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, stride, (void *)offsetof(vertex, x));
    gl->VertexAttribPointer(1, 4, GL_UNSIGNED_BYTE, GL_TRUE, stride,
                            (void *)offsetof(vertex, color));
    for (GLuint i = 0; i < 2; ++i) gl->EnableVertexAttribArray(i);
    gl->BindVertexArray(0);
}

canvas *canvas_create(void *(*get_proc)(void *user, const char *name), void *user,
                      psplat_error *error) {
    canvas *c = calloc(1, sizeof *c);
    if (!c) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the overlay"), NULL;
    if (load_gl(&c->gl, get_proc, user, error)) return free(c), NULL;
    make_vertex_array(c);
    if (build_program(c)) return c;
    psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "the overlay's shader was refused");
    canvas_destroy(c);
    return NULL;
}

void canvas_destroy(canvas *c) {
    if (!c) return;
    c->gl.DeleteProgram(c->program);
    c->gl.DeleteBuffers(1, &c->buffer);
    c->gl.DeleteVertexArrays(1, &c->vertex_array);
    free(c->vertices);
    free(c);
}

const gl *canvas_gl(const canvas *c) {
    return &c->gl;
}

/* ---- drawing ------------------------------------------------------------------------------ */

void canvas_begin(canvas *c, int width, int height) {
    c->width = width;
    c->height = height;
    c->count = 0;
    c->is_full = 0;
}

static int reserve(canvas *c, size_t count) {
    if (c->count + count <= c->capacity) return 1;
    size_t capacity = 2 * (c->count + count);
    vertex *grown = realloc(c->vertices, capacity * sizeof *grown);
    if (!grown) return c->is_full = 1, 0;
    c->vertices = grown;
    c->capacity = capacity;
    return 1;
}

void canvas_rectangle(canvas *c, int x, int y, int width, int height, uint32_t top,
                      uint32_t bottom) {
    static const int order[] = {0, 2, 1, 1, 2, 3};
    if (c->is_full || !reserve(c, 6)) return;
    for (int i = 0; i < 6; ++i) {
        int right = order[i] & 1, low = order[i] >> 1;
        vertex *v = &c->vertices[c->count++];
        v->x = (float)(x + right * width);
        v->y = (float)(y + low * height);
        for (int k = 0; k < 4; ++k) v->color[k] = (uint8_t)((low ? bottom : top) >> (24 - 8 * k));
    }
}

/* The font has only printable ASCII; for any other character it would read beyond its tables. */
static char printable(char c) {
    return c >= ' ' && c <= '~' ? c : '?';
}

int canvas_text_width(const char *text) {
    int width = 0;
    for (; *text; ++text) width += stb_easy_font_width((char[]){printable(*text), 0});
    return width;
}

void canvas_text(canvas *c, int x, int y, int size, uint32_t color, const char *text) {
    struct {
        float x, y, z;
        uint8_t color[4];
    } quads[32][4]; /* strokes of a glyph; corners clockwise from the upper left */
    for (; *text; ++text) {
        char glyph[] = {printable(*text), 0};
        int count = stb_easy_font_print(0, 0, glyph, NULL, quads, sizeof quads);
        for (int i = 0; i < count; ++i) {
            int left = (int)quads[i][0].x, top = (int)quads[i][0].y;
            canvas_rectangle(c, x + size * left, y + size * top, size * ((int)quads[i][2].x - left),
                             size * ((int)quads[i][2].y - top), color, color);
        }
        x += size * stb_easy_font_width(glyph);
    }
}

void canvas_end(canvas *c) {
    const gl *gl = &c->gl;
    gl->Viewport(0, 0, c->width, c->height);
    gl->Disable(GL_DEPTH_TEST);
    gl->Disable(GL_CULL_FACE);
    gl->Enable(GL_BLEND);
    gl->BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    gl->UseProgram(c->program);
    gl->Uniform2f(c->size, (float)c->width, (float)c->height);
    gl->BindVertexArray(c->vertex_array);
    gl->BindBuffer(GL_ARRAY_BUFFER, c->buffer);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(c->count * sizeof *c->vertices), c->vertices,
                   GL_STREAM_DRAW);
    gl->DrawArrays(GL_TRIANGLES, 0, (GLsizei)c->count);
    gl->BindVertexArray(0);
    gl->Disable(GL_BLEND);
}

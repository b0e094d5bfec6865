/* SPDX-License-Identifier: MIT
 *
 * sprites.c - the papers' own method (BSK04 section 4, BHZK05 sections 3 to 5): a point sprite for
 * each splat, a ray cast for each fragment, and replaced depths, in three passes with two float
 * targets. It does not support splats larger than the largest point, splats whose centre is outside
 * the view, several materials and orthographic views.
 */
#include "bench_shaders.h"
#include "draw_method.h"
#include "lighting.h"
#include "probe.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ATTRIBUTES = 9 };

/* Vertex attributes: seven vec3 and two vec4. */
typedef struct vertex {
    float center[3], u[3], v[3], field[4], color[4], clip[PSPLAT_MAX_CLIP_LINES][3];
} vertex;

typedef struct group {
    const psplat_batch *batch;
    GLuint buffer, array;
} group;

typedef struct sprites {
    bench_gl gl;
    group *groups;
    size_t group_count;
    /* By visibility, clip lines, filter, power. */
    GLuint programs[2][PSPLAT_MAX_CLIP_LINES + 1][2][2];
    GLuint resolve, screen;          /* screen: an empty vertex array */
    GLuint framebuffer, textures[3]; /* textures: normals, colours, depth */
    int width, height;
    int filter; /* FILTER of sprite.frag, used where the view filters */
} sprites;

/* ---- vertices -------------------------------------------------------------------------------- */

static void rotate(const float q[4], const double p[3], double out[3]) {
    double x = q[0], y = q[1], z = q[2], w = q[3], s = 2 / (x * x + y * y + z * z + w * w);
    const double rows[3][3] = {{1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)},
                               {s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)},
                               {s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)}};
    for (int i = 0; i < 3; ++i) out[i] = rows[i][0] * p[0] + rows[i][1] * p[1] + rows[i][2] * p[2];
}

static vertex vertex_of(const psplat_splat *splat) {
    vertex out = {.color = {splat->color[0], splat->color[1], splat->color[2], splat->gradient[2]}};
    double axes[3][3], local[3];
    for (int k = 0; k < 3; ++k) {
        double unit[3] = {k == 0, k == 1, k == 2};
        rotate(splat->rotation, unit, axes[k]);
        local[k] = 0;
        for (int i = 0; i < 3; ++i) local[k] += axes[k][i] * (double)splat->normal[i];
    }
    for (int i = 0; i < 3; ++i) {
        out.center[i] = splat->center[i];
        out.u[i] = (float)(axes[0][i] * (double)splat->radius[0]);
        out.v[i] = (float)(axes[1][i] * (double)splat->radius[1]);
    }
    for (int k = 0; k < 2; ++k) {
        out.field[k] = (float)(local[k] / local[2]);
        out.field[2 + k] = splat->gradient[k];
    }
    memcpy(out.clip, splat->clip, sizeof out.clip);
    return out;
}

static void set_attributes(const bench_gl *gl, uint32_t clip_count) {
    static const struct {
        GLint size;
        size_t offset;
    } layout[ATTRIBUTES] = {{3, offsetof(vertex, center)},  {3, offsetof(vertex, u)},
                            {3, offsetof(vertex, v)},       {4, offsetof(vertex, field)},
                            {4, offsetof(vertex, color)},   {3, offsetof(vertex, clip[0])},
                            {3, offsetof(vertex, clip[1])}, {3, offsetof(vertex, clip[2])},
                            {3, offsetof(vertex, clip[3])}};
    for (GLuint i = 0; i < 5 + clip_count; ++i) {
        gl->base.EnableVertexAttribArray(i);
        gl->base.VertexAttribPointer(i, layout[i].size, GL_FLOAT, GL_FALSE, sizeof(vertex),
                                     (const void *)(uintptr_t)layout[i].offset);
    }
}

static group make_group(const bench_gl *gl, const psplat_batch *batch) {
    group g = {.batch = batch};
    vertex *vertices = malloc(batch->splat_count * sizeof *vertices);
    if (!vertices) abort();
    for (size_t i = 0; i < batch->splat_count; ++i) vertices[i] = vertex_of(&batch->splats[i]);
    gl->base.GenVertexArrays(1, &g.array);
    gl->base.BindVertexArray(g.array);
    gl->base.GenBuffers(1, &g.buffer);
    gl->base.BindBuffer(GL_ARRAY_BUFFER, g.buffer);
    gl->base.BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(batch->splat_count * sizeof *vertices),
                        vertices, BENCH_STATIC_DRAW);
    set_attributes(gl, batch->clip_count);
    gl->base.BindVertexArray(0);
    free(vertices);
    return g;
}

/* ---- programs and targets -------------------------------------------------------------------- */

static GLuint program_of(sprites *s, int visibility, uint32_t clip_count, int filter, int power) {
    GLuint *program = &s->programs[visibility][clip_count][filter][power];
    if (*program) return *program;
    char defines[200];
    snprintf(defines, sizeof defines,
             "#define VISIBILITY %d\n#define CLIP_COUNT %d\n#define FILTER %d\n#define POWER %d\n",
             visibility, (int)clip_count, filter ? s->filter : 0, power);
    *program =
        bench_gl_program(&s->gl, defines, "", bench_shader_sprite_vert, bench_shader_sprite_frag);
    return *program;
}

static void make_resolve(sprites *s) {
    static const char *const samplers[] = {"u_normals", "u_colors", "u_depth"};
    const psplat_gl *gl = &s->gl.base;
    s->resolve = bench_gl_program(&s->gl, "", bench_shader_light_glsl, bench_shader_screen_vert,
                                  bench_shader_sprite_resolve_frag);
    gl->UseProgram(s->resolve);
    for (int i = 0; i < 3; ++i) gl->Uniform1i(gl->GetUniformLocation(s->resolve, samplers[i]), i);
    gl->GenVertexArrays(1, &s->screen);
}

static void make_targets(sprites *s, int width, int height) {
    static const GLenum buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT0 + 1};
    const psplat_gl *gl = &s->gl.base;
    gl->DeleteFramebuffers(1, &s->framebuffer);
    gl->DeleteTextures(3, s->textures);
    gl->GenFramebuffers(1, &s->framebuffer);
    gl->GenTextures(3, s->textures);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, s->framebuffer);
    for (int i = 0; i < 3; ++i) {
        gl->BindTexture(GL_TEXTURE_2D, s->textures[i]);
        gl->TexImage2D(GL_TEXTURE_2D, 0, i < 2 ? GL_RGBA32F : GL_DEPTH_COMPONENT32F, width, height,
                       0, i < 2 ? GL_RGBA : GL_DEPTH_COMPONENT, GL_FLOAT, NULL);
        gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        gl->FramebufferTexture2D(GL_DRAW_FRAMEBUFFER,
                                 i < 2 ? GL_COLOR_ATTACHMENT0 + (GLenum)i : GL_DEPTH_ATTACHMENT,
                                 GL_TEXTURE_2D, s->textures[i], 0);
    }
    gl->DrawBuffers(2, buffers);
    s->width = width;
    s->height = height;
}

/* ---- a frame --------------------------------------------------------------------------------- */

static void draw_groups(sprites *s, const psplat_view *view, int visibility) {
    const psplat_gl *gl = &s->gl.base;
    for (size_t i = 0; i < s->group_count; ++i) {
        const psplat_batch *batch = s->groups[i].batch;
        GLuint program = program_of(s, visibility, batch->clip_count, !view->no_filter,
                                    batch->kernel.exponent != 2.0f);
        gl->UseProgram(program);
        lighting_place(&s->gl, program, view, batch->model);
        lighting_ray(&s->gl, program, view);
        gl->Uniform1i(gl->GetUniformLocation(program, "u_two_sided"),
                      lighting_two_sided(view, &batch->material));
        gl->Uniform2f(gl->GetUniformLocation(program, "u_kernel"), -batch->kernel.sharpness,
                      0.5f * batch->kernel.exponent);
        gl->Uniform3fv(gl->GetUniformLocation(program, "u_base_color"), 1,
                       batch->material.base_color);
        s->gl.Uniform1f(gl->GetUniformLocation(program, "u_epsilon"), batch->depth_tolerance);
        gl->BindVertexArray(s->groups[i].array);
        gl->DrawArrays(BENCH_POINTS, 0, (GLsizei)batch->splat_count);
    }
}

static void draw_splats(sprites *s, const psplat_view *view) {
    static const float zeros[4] = {0}, one = 1;
    const psplat_gl *gl = &s->gl.base;
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, s->framebuffer);
    gl->Viewport(0, 0, view->width, view->height);
    for (int i = 0; i < 2; ++i) gl->ClearBufferfv(GL_COLOR, i, zeros);
    gl->ClearBufferfv(GL_DEPTH, 0, &one);
    gl->Enable(GL_DEPTH_TEST);
    gl->Enable(BENCH_PROGRAM_POINT_SIZE);
    gl->DepthFunc(GL_LESS);
    gl->ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    draw_groups(s, view, 1);
    gl->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl->DepthMask(GL_FALSE);
    gl->Enable(GL_BLEND);
    gl->BlendFuncSeparate(GL_ONE, GL_ONE, GL_ONE, GL_ONE);
    draw_groups(s, view, 0);
    gl->Disable(GL_BLEND);
    gl->DepthMask(GL_TRUE);
    gl->Disable(BENCH_PROGRAM_POINT_SIZE);
}

static void draw(void *self, const psplat_view *view) {
    sprites *s = self;
    const psplat_gl *gl = &s->gl.base;
    GLint host = 0;
    gl->GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &host);
    if (s->width != view->width || s->height != view->height)
        make_targets(s, view->width, view->height);
    draw_splats(s, view);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)host);
    gl->DepthFunc(GL_LEQUAL);
    gl->UseProgram(s->resolve);
    lighting_ray(&s->gl, s->resolve, view);
    lighting_light(&s->gl, s->resolve, view, &s->groups[0].batch->material);
    for (int i = 0; i < 3; ++i) {
        gl->ActiveTexture(GL_TEXTURE0 + (GLenum)i);
        gl->BindTexture(GL_TEXTURE_2D, s->textures[i]);
    }
    gl->BindVertexArray(s->screen);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->Disable(GL_DEPTH_TEST);
}

static void destroy(void *self) {
    sprites *s = self;
    const psplat_gl *gl = &s->gl.base;
    const GLuint *programs = &s->programs[0][0][0][0];
    for (size_t i = 0; i < sizeof s->programs / sizeof *programs; ++i)
        gl->DeleteProgram(programs[i]);
    gl->DeleteProgram(s->resolve);
    gl->DeleteVertexArrays(1, &s->screen);
    for (size_t i = 0; i < s->group_count; ++i) {
        gl->DeleteVertexArrays(1, &s->groups[i].array);
        s->gl.base.DeleteBuffers(1, &s->groups[i].buffer);
    }
    gl->DeleteFramebuffers(1, &s->framebuffer);
    gl->DeleteTextures(3, s->textures);
    free(s->groups);
    free(s);
}

static sprites *make(psplat_host *host, const subject *subject, int filter) {
    sprites *s = calloc(1, sizeof *s);
    if (!s) abort();
    s->filter = filter;
    s->group_count = psplat_asset_batch_count(subject->asset);
    s->groups = calloc(s->group_count, sizeof *s->groups);
    if (!s->groups) abort();
    bench_gl_load(&s->gl, probe_get_proc, host);
    for (size_t i = 0; i < s->group_count; ++i)
        s->groups[i] = make_group(&s->gl, psplat_asset_batch(subject->asset, i));
    make_resolve(s);
    return s;
}

draw_method draw_method_sprites(psplat_host *host, const subject *subject, unsigned options) {
    return (draw_method){"sprites", draw, destroy, make(host, subject, 1), options};
}

draw_method draw_method_sprites_plane(psplat_host *host, const subject *subject, unsigned options) {
    return (draw_method){"sprites, plane's depth", draw, destroy, make(host, subject, 2), options};
}

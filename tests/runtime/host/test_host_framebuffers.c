/* SPDX-License-Identifier: MIT
 *
 * test_host_framebuffers.c - tests splats among the host's own geometry in framebuffers of the
 * host's choice: colour and depth formats, several samples a pixel, views with an offset, scissor
 * boxes and depth ranges. A plane of the host cuts a sphere of splats; which of them a pixel must
 * show follows from the plane's equation and from the reference rasteriser.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "reference_view.h"
#include "gl_canvas.h"
#include "host_gl.h"
#include "near.h"
#include "scene_asset.h"

enum { FRAMEBUFFER_SRGB = 0x8DB9, SIZE = CANVAS_SIZE };

/* The host's plane is a square around a point, with the axes s and t and the given half length of a
 * side. */
static const double plane_point[3] = {0.05, -0.03, 0.1}, plane_s[3] = {0.8, 0, -0.6},
                    plane_t[3] = {0.36, 0.8, 0.48}, plane_extent = 1.5;
static const float blue[4] = {0, 0, 1, 1}, black[4] = {0, 0, 0, 0};

typedef struct world {
    psplat_api api;
    canvas *canvas;
    host_gl gl;
    scene scene;
    psplat_asset *asset;
    psplat_item item;
    psplat_view view;
    picture expected;
    GLuint plane_program;
    GLuint framebuffer, renderbuffers[2]; /* renderbuffers: colour, depth */
} world;

/* ---- the host's framebuffer ----------------------------------------------------------------- */

static void make_framebuffer(world *w, GLenum color, GLenum depth, int samples) {
    const host_gl *gl = &w->gl;
    GLenum attachment =
        depth == GL_DEPTH24_STENCIL8 ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT;
    const float one = 1;
    gl->GenFramebuffers(1, &w->framebuffer);
    gl->GenRenderbuffers(2, w->renderbuffers);
    gl->BindFramebuffer(GL_FRAMEBUFFER, w->framebuffer);
    gl->BindRenderbuffer(GL_RENDERBUFFER, w->renderbuffers[0]);
    gl->RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, color, SIZE, SIZE);
    gl->BindRenderbuffer(GL_RENDERBUFFER, w->renderbuffers[1]);
    gl->RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, depth, SIZE, SIZE);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                                w->renderbuffers[0]);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, w->renderbuffers[1]);
    assert_int_equal(gl->CheckFramebufferStatus(GL_FRAMEBUFFER), GL_FRAMEBUFFER_COMPLETE);
    gl->Viewport(0, 0, SIZE, SIZE);
    gl->ClearBufferfv(GL_COLOR, 0, black);
    gl->ClearBufferfv(GL_DEPTH, 0, &one);
}

static void free_framebuffer(world *w) {
    w->gl.DeleteFramebuffers(1, &w->framebuffer);
    w->gl.DeleteRenderbuffers(2, w->renderbuffers);
}

/* Reads the colour buffer as floats, as it is stored: sRGB stays encoded. */
static void read_pixels(const world *w, GLenum format, float *rgba) {
    static uint32_t packed[SIZE * SIZE];
    const uint8_t *bytes = (const uint8_t *)packed;
    if (format == GL_R11F_G11F_B10F || format == GL_RGBA16F) {
        w->gl.ReadPixels(0, 0, SIZE, SIZE, GL_RGBA, GL_FLOAT, rgba);
        return;
    }
    int ten = format == GL_RGB10_A2;
    w->gl.ReadPixels(0, 0, SIZE, SIZE, GL_RGBA,
                     ten ? GL_UNSIGNED_INT_2_10_10_10_REV : GL_UNSIGNED_BYTE, packed);
    for (int i = 0; i < SIZE * SIZE; ++i)
        for (int k = 0; k < 3; ++k)
            rgba[4 * i + k] =
                ten ? (float)(packed[i] >> (10 * k) & 1023) / 1023 : (float)bytes[4 * i + k] / 255;
}

/* ---- the host's plane ----------------------------------------------------------------------- */

static GLuint compile(const world *w, GLenum type, const char *body) {
    const char *sources[2] = {w->api == PSPLAT_API_GL ? "#version 330 core\n"
                                                      : "#version 300 es\nprecision highp float;\n",
                              body};
    GLuint shader = w->gl.CreateShader(type);
    w->gl.ShaderSource(shader, 2, sources, NULL);
    w->gl.CompileShader(shader);
    return shader;
}

static void make_plane(world *w) {
    GLint linked = 0;
    w->plane_program = w->gl.CreateProgram();
    w->gl.AttachShader(w->plane_program,
                       compile(w, GL_VERTEX_SHADER,
                               "uniform mat4 u_corners;\n"
                               "void main() { gl_Position = u_corners[gl_VertexID]; }\n"));
    w->gl.AttachShader(w->plane_program, compile(w, GL_FRAGMENT_SHADER,
                                                 "uniform vec4 u_color; out vec4 color;\n"
                                                 "void main() { color = u_color; }\n"));
    w->gl.LinkProgram(w->plane_program);
    w->gl.GetProgramiv(w->plane_program, GL_LINK_STATUS, &linked);
    assert_true(linked);
}

static void to_eye(const psplat_view *view, const double point[3], double w, double eye[3]) {
    for (int row = 0; row < 3; ++row) {
        eye[row] = view->view[12 + row] * w;
        for (int i = 0; i < 3; ++i) eye[row] += view->view[4 * i + row] * point[i];
    }
}

static void draw_plane(const world *w) {
    const host_gl *gl = &w->gl;
    float corners[16];
    GLuint array;
    for (int corner = 0; corner < 4; ++corner) {
        double s = (corner & 1 ? 1 : -1) * plane_extent, t = (corner & 2 ? 1 : -1) * plane_extent;
        double point[3], e[3];
        for (int i = 0; i < 3; ++i) point[i] = plane_point[i] + s * plane_s[i] + t * plane_t[i];
        to_eye(&w->view, point, 1, e);
        const double *p = w->view.projection;
        for (int i = 0; i < 4; ++i)
            corners[4 * corner + i] =
                (float)(p[i] * e[0] + p[4 + i] * e[1] + p[8 + i] * e[2] + p[12 + i]);
    }
    gl->GenVertexArrays(1, &array);
    gl->BindVertexArray(array);
    gl->Enable(GL_DEPTH_TEST);
    gl->UseProgram(w->plane_program);
    gl->UniformMatrix4fv(gl->GetUniformLocation(w->plane_program, "u_corners"), 1, GL_FALSE,
                         corners);
    gl->Uniform4fv(gl->GetUniformLocation(w->plane_program, "u_color"), 1, blue);
    gl->DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Returns the plane's window depth in a pixel, 2 outside the square. *edge is the distance to the
 * square's edge. */
static double plane_depth(const psplat_view *view, int x, int y, double *edge) {
    double point[3], s[3], t[3], normal[3], hit[3];
    to_eye(view, plane_point, 1, point);
    to_eye(view, plane_s, 0, s);
    to_eye(view, plane_t, 0, t);
    for (int i = 0; i < 3; ++i)
        normal[i] = s[(i + 1) % 3] * t[(i + 2) % 3] - s[(i + 2) % 3] * t[(i + 1) % 3];
    const double *p = view->projection;
    double ray[3] = {((2 * x + 1.0) / view->width - 1) / p[0],
                     ((2 * y + 1.0) / view->height - 1) / p[5], -1};
    double distance = dot(normal, point) / dot(normal, ray);
    for (int i = 0; i < 3; ++i) hit[i] = distance * ray[i] - point[i];
    *edge = plane_extent - fmax(fabs(dot(hit, s)), fabs(dot(hit, t)));
    if (*edge < 0) return 2;
    return 0.5 + 0.5 * (p[14] - p[10] * distance) / distance;
}

/* ---- who is seen ---------------------------------------------------------------------------- */

static double encode(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

typedef struct format {
    GLenum color, depth;
    int encodes;               /* the framebuffer is sRGB */
    double absolute, relative; /* tolerance of a colour channel: a step of the format */
    double depth_step;
} format;

/* Returns whether a pixel is too close to call: by the reference's own ties, or where sphere and
 * plane are closer than a depth step or 2e-6 of the depth range, the error of both in float32. The
 * plane's edge may be off by a thousandth of a pixel. */
static int is_tied(const world *w, const format *f, int at, double plane, double edge) {
    const psplat_reference_image *image = &w->expected.image;
    return image->tie[at] < 1e-4 || image->depth_tie[at] < 1e-6 || image->epsilon_tie[at] < 1e-4 ||
           fabs(image->depth[at] - plane) < f->depth_step + 2e-6 || fabs(edge) < 1e-4;
}

/* Compares every pixel and returns the number of pixels that show splats. */
static int expect_picture(const world *w, const format *f) {
    static float rgba[SIZE * SIZE * 4];
    int ties = 0, splats = 0, planes = 0;
    read_pixels(w, f->color, rgba);
    for (int at = 0; at < SIZE * SIZE; ++at) {
        double edge, plane = plane_depth(&w->view, at % SIZE, at / SIZE, &edge);
        const float *color = rgba + 4 * at, *wanted = w->expected.image.color + 4 * at;
        int is_covered = w->expected.image.count[at] > 0;
        int is_splat = is_covered && w->expected.image.depth[at] < plane;
        if (is_tied(w, f, at, plane, edge)) {
            ++ties;
            continue;
        }
        if (!is_splat) wanted = plane <= 1 ? blue : black;
        for (int k = 0; k < 3; ++k) {
            double value = f->encodes ? encode((double)wanted[k]) : (double)wanted[k];
            /* 2e-3 is the error of the renderer in float32 (test_agreement.c). */
            assert_near(color[k], value, f->absolute + f->relative * value + 2e-3);
        }
        splats += is_splat;
        planes += !is_splat && plane <= 1;
    }
    assert_true(ties < SIZE * SIZE / 50);
    assert_true(splats > 1000 && planes > 1000);
    return splats;
}

static void draw_splats(const world *w) {
    psplat_error error = {0};
    canvas_check(psplat_draw(w->canvas->renderer, &w->view, &w->item, 1, &error), &error);
}

/* Both orders of drawing give the same picture. */
static void expect_format(world *w, const format *f) {
    if (f->encodes && w->api == PSPLAT_API_GL) w->gl.Enable(FRAMEBUFFER_SRGB);
    for (int order = 0; order < 2; ++order) {
        make_framebuffer(w, f->color, f->depth, 0);
        if (order) draw_splats(w);
        draw_plane(w);
        if (!order) draw_splats(w);
        expect_picture(w, f);
        free_framebuffer(w);
    }
    if (f->encodes && w->api == PSPLAT_API_GL) w->gl.Disable(FRAMEBUFFER_SRGB);
}

static void test_colors(void **state) {
    static const format formats[] = {
        {GL_RGBA8, GL_DEPTH_COMPONENT24, 0, 0.5 / 255, 0, 0x1p-24},
        {GL_SRGB8_ALPHA8, GL_DEPTH_COMPONENT24, 1, 1.0 / 255, 0, 0x1p-24},
        {GL_RGB10_A2, GL_DEPTH_COMPONENT24, 0, 0.5 / 1023, 0, 0x1p-24},
        {GL_R11F_G11F_B10F, GL_DEPTH_COMPONENT24, 0, 0, 0x1p-5, 0x1p-24},
        {GL_RGBA16F, GL_DEPTH_COMPONENT24, 0, 0, 0x1p-10, 0x1p-24},
    };
    for (size_t i = 0; i < sizeof formats / sizeof *formats; ++i)
        expect_format(*state, &formats[i]);
}

static void test_depths(void **state) {
    static const format formats[] = {
        {GL_RGBA8, GL_DEPTH_COMPONENT16, 0, 0.5 / 255, 0, 0x1p-16},
        {GL_RGBA8, GL_DEPTH_COMPONENT24, 0, 0.5 / 255, 0, 0x1p-24},
        {GL_RGBA8, GL_DEPTH24_STENCIL8, 0, 0.5 / 255, 0, 0x1p-24},
        {GL_RGBA8, GL_DEPTH_COMPONENT32F, 0, 0.5 / 255, 0, 0},
    };
    for (size_t i = 0; i < sizeof formats / sizeof *formats; ++i)
        expect_format(*state, &formats[i]);
}

/* ---- several samples a pixel ---------------------------------------------------------------- */

/* Draws into a framebuffer of several samples, which the host then resolves. */
static void draw_resolved(world *w, int samples, int has_plane, float *rgba) {
    const host_gl *gl = &w->gl;
    make_framebuffer(w, GL_RGBA8, GL_DEPTH_COMPONENT24, samples);
    GLuint many = w->framebuffer, buffers[2] = {w->renderbuffers[0], w->renderbuffers[1]};
    if (has_plane) draw_plane(w);
    draw_splats(w);
    make_framebuffer(w, GL_RGBA8, GL_DEPTH_COMPONENT24, 0);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, many);
    gl->BlitFramebuffer(0, 0, SIZE, SIZE, 0, 0, SIZE, SIZE, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, w->framebuffer);
    read_pixels(w, GL_RGBA8, rgba);
    free_framebuffer(w);
    gl->DeleteFramebuffers(1, &many);
    gl->DeleteRenderbuffers(2, buffers);
}

/* Splats have one depth and colour a pixel, which all its samples take: alone they look as in a
 * framebuffer of one sample. The edges of the host's geometry against them stay smooth. */
static void test_samples(void **state) {
    static float one[SIZE * SIZE * 4], four[SIZE * SIZE * 4];
    world *w = *state;
    draw_resolved(w, 0, 0, one);
    draw_resolved(w, 4, 0, four);
    assert_memory_equal(one, four, sizeof one);

    draw_resolved(w, 0, 1, one);
    draw_resolved(w, 4, 1, four);
    int mixed = 0, equal = 0;
    for (int at = 0; at < SIZE * SIZE; ++at) {
        double edge, plane = plane_depth(&w->view, at % SIZE, at / SIZE, &edge);
        int is_covered = w->expected.image.count[at] > 0;
        int is_same = memcmp(one + 4 * at, four + 4 * at, 3 * sizeof *one) == 0;
        equal += is_same;
        mixed += !is_same;
        /* Half a pixel of the plane is some 0.02 units, or a depth of 0.01. */
        double gap = is_covered ? fabs(w->expected.image.depth[at] - plane) : 1;
        if (!is_same)
            assert_true(gap < 0.01 || fabs(edge) < 0.03 || w->expected.image.tie[at] < 1e-4);
    }
    assert_true(mixed > 60 && equal > SIZE * SIZE * 9 / 10);
}

/* ---- views, scissor boxes, depth ranges ----------------------------------------------------- */

/* A view with an offset shows the same picture at another place; pixels outside the view keep
 * colour and depth. */
static void test_offset(void **state) {
    world *w = *state;
    canvas *c = w->canvas;
    psplat_view view = w->view;
    view.width = view.height = SIZE / 2;
    canvas_draw(c, &view, &w->item, 1);
    float *first = malloc(sizeof c->color), *depth = malloc(sizeof c->depth);
    assert_true(first && depth);
    memcpy(first, c->color, sizeof c->color);
    memcpy(depth, c->depth, sizeof c->depth);
    view.x = 37;
    view.y = 21;
    canvas_draw(c, &view, &w->item, 1);
    assert_true(canvas_covered(c) > 500);
    for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x) {
            int is_inside = x >= 37 && y >= 21 && x < 37 + SIZE / 2 && y < 21 + SIZE / 2;
            int at = (y - 21) * SIZE + x - 37;
            const float *pixel = canvas_pixel(c, x, y);
            assert_memory_equal(pixel, is_inside ? first + 4 * at : black, sizeof black);
            assert_true(c->depth[y * SIZE + x] == (is_inside ? depth[at] : 1.0f));
        }
    free(first);
    free(depth);
}

/* A plane that the view cuts off looks the same up to the view's edge: no contour appears there. */
static void test_border(void **state) {
    world *w = *state;
    canvas *c = w->canvas;
    scene disc = scene_disc(3.0f);
    psplat_asset *asset = scene_open(&disc);
    psplat_item item = {.model = canvas_model(c, asset)};
    psplat_view view = camera_view(SIZE, SIZE);
    const double eye[3] = {0, 0, 2}, target[3] = {0, 0, 0};
    camera_look(&view, eye, target);
    camera_parallel(&view, 1.0, 1.0, 3.0);
    for (int shading = 0; shading < PSPLAT_SHADING_SPLATS; ++shading) {
        view.shading = (psplat_shading)shading;
        canvas_draw(c, &view, &item, 1);
        for (int at = 0; at < SIZE * SIZE; ++at)
            for (int k = 0; k < 4; ++k) assert_near(c->color[4 * at + k], c->color[k], 1e-4);
    }
    psplat_model_destroy(c->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&disc);
}

static void test_depth_range(void **state) {
    world *w = *state;
    canvas *c = w->canvas;
    canvas_draw(c, &w->view, &w->item, 1);
    float *depth = malloc(sizeof c->depth);
    assert_non_null(depth);
    memcpy(depth, c->depth, sizeof c->depth);
    w->gl.DepthRangef(0.25f, 0.75f);
    canvas_draw(c, &w->view, &w->item, 1);
    w->gl.DepthRangef(0, 1);
    for (int at = 0; at < SIZE * SIZE; ++at) {
        double wanted = c->color[4 * at + 3] > 0 ? 0.25 + 0.5 * (double)depth[at] : 1;
        assert_near(c->depth[at], wanted, 1e-6); /* the error of depths in test_agreement.c */
    }
    free(depth);
}

/* Near lights and contours need places in eye space, which are found from window depth. */
static void test_depth_range_of_places(void **state) {
    world *w = *state;
    canvas *c = w->canvas;
    static float colors[4 * SIZE * SIZE];
    psplat_view view = w->view;
    view.lights[1] = (psplat_light){.type = PSPLAT_LIGHT_POINT, .color = {1, 1, 1}};
    for (int i = 0; i < 3; ++i) view.lights[1].position[i] = 1.5;
    view.light_count = 2;
    const psplat_shading shadings[] = {PSPLAT_SHADING_LIT, PSPLAT_SHADING_TOON,
                                       PSPLAT_SHADING_DEPTH};
    for (int i = 0; i < 3; ++i) {
        int other = 0;
        view.shading = shadings[i];
        canvas_draw(c, &view, &w->item, 1);
        memcpy(colors, c->color, sizeof colors);
        w->gl.DepthRangef(0.25f, 0.75f);
        canvas_draw(c, &view, &w->item, 1);
        w->gl.DepthRangef(0, 1);
        for (int at = 0; at < 4 * SIZE * SIZE; ++at)
            other += fabsf(c->color[at] - colors[at]) > 1e-3f;
        /* Depths have fewer digits there, so that outlines between tones may move a little. */
        assert_true(other <= 4 * SIZE * SIZE / 500);
    }
}

/* The host's geometry lies at window depth 0.3 in the left half and at 0.7 in the right half, and a
 * scissor box leaves only the lower half. A disc at 0.5 must appear only in the lower right
 * quarter, and all other pixels must keep their colour and depth. */
static void test_host_pixels(void **state) {
    world *w = *state;
    canvas *c = w->canvas;
    const host_gl *gl = &w->gl;
    const double eye[3] = {0, 0, 2}, target[3] = {0, 0, 0};
    const float near_depth = 0.3f, far_depth = 0.7f, gray[4] = {0.5f, 0.5f, 0.5f, 0.25f};
    scene disc = scene_disc(0.8f);
    psplat_asset *asset = scene_open(&disc);
    psplat_item item = {.model = canvas_model(c, asset)};
    psplat_view view = camera_view(SIZE, SIZE);
    psplat_error error = {0};
    camera_look(&view, eye, target);
    camera_parallel(&view, 1.0, 1.0, 3.0);
    canvas_begin(c);
    gl->ClearBufferfv(GL_COLOR, 0, gray);
    gl->ClearBufferfv(GL_DEPTH, 0, &far_depth);
    gl->Enable(GL_SCISSOR_TEST);
    gl->Scissor(0, 0, SIZE / 2, SIZE);
    gl->ClearBufferfv(GL_DEPTH, 0, &near_depth);
    gl->Scissor(0, 0, SIZE, SIZE / 2);
    canvas_check(psplat_draw(c->renderer, &view, &item, 1, &error), &error);
    gl->Disable(GL_SCISSOR_TEST);
    canvas_read(c);
    int drawn = 0;
    for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x) {
            const float *p = canvas_pixel(c, x, y);
            float depth = c->depth[y * SIZE + x];
            int is_splat = p[3] == 1.0f;
            drawn += is_splat;
            if (x < SIZE / 2 || y >= SIZE / 2) assert_false(is_splat);
            if (is_splat) assert_near(depth, 0.5, 1e-6);
            if (!is_splat) assert_memory_equal(p, gray, sizeof gray);
            if (!is_splat) assert_true(depth == (x < SIZE / 2 ? near_depth : far_depth));
        }
    /* A quarter of the disc has pi 0.8^2 / 4 square units of 64^2 pixels each; the tolerance of 40
     * pixels is for the rim. */
    assert_true(abs(drawn - 2059) < 40);
    psplat_model_destroy(c->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&disc);
}

/* ---- fixtures ------------------------------------------------------------------------------- */

static int setup(void **state, psplat_api api) {
    const double eye[3] = {1.2, 0.9, 2.2}, target[3] = {0, 0, 0};
    world *w = calloc(1, sizeof *w);
    assert_non_null(w);
    w->api = api;
    w->canvas = canvas_create(api);
    w->gl = host_gl_of(w->canvas->host);
    w->scene = scene_sphere(500, 0.8f);
    for (int i = 0; i < 3; ++i) w->scene.material.base_color[i] = 0.5f;
    w->scene.material.double_sided = 1; /* the plane opens the sphere, whose inside is visible */
    w->asset = scene_open(&w->scene);
    w->item.model = canvas_model(w->canvas, w->asset);
    w->view = camera_view(SIZE, SIZE);
    w->view.no_filter = 0;
    for (int i = 0; i < 3; ++i) w->view.ambient[i] = 0.1f;
    camera_look(&w->view, eye, target);
    camera_perspective(&w->view, 150, 1, 6);
    w->expected = picture_draw(w->asset, NULL, &w->view);
    make_plane(w);
    *state = w;
    return 0;
}

static int setup_gl(void **state) {
    return setup(state, PSPLAT_API_GL);
}

static int setup_es(void **state) {
    return setup(state, PSPLAT_API_GLES);
}

static int teardown(void **state) {
    world *w = *state;
    psplat_model_destroy(w->canvas->renderer, w->item.model);
    canvas_destroy(w->canvas);
    picture_free(&w->expected);
    psplat_asset_destroy(w->asset);
    scene_free(&w->scene);
    free(w);
    return 0;
}

#define BOTH(test)                                                                                 \
    cmocka_unit_test_setup_teardown(test, setup_gl, teardown),                                     \
        cmocka_unit_test_setup_teardown(test, setup_es, teardown)

int test_host_framebuffers_main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(test_colors),
        BOTH(test_depths),
        BOTH(test_samples),
        BOTH(test_offset),
        BOTH(test_border),
        BOTH(test_depth_range),
        BOTH(test_depth_range_of_places),
        BOTH(test_host_pixels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

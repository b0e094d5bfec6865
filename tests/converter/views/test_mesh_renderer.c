/* SPDX-License-Identifier: MIT
 *
 * test_mesh_renderer.c - tests that the renderer of the source mesh shades as the renderer of
 * splats does. One splat's ellipse is compared with the square around it, which has the same
 * normals, material and lights, in GL and GLES. Faults injected into the GL loader test what the
 * renderer does with a context that refuses.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "agreement.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "mesh/mesh.h"
#include "views/mesh_renderer.h"
#include "host_gl.h"
#include "near.h"
#include "scene_asset.h"

enum { SIZE = 128, BYTES = 4 * SIZE * SIZE };

static const double half = 1.3; /* half edge of the square, in radii of the splat */

/* A splat, and the square around it as a mesh of two triangles. */
typedef struct plate {
    scene splat;
    double positions[4][3];
    uint32_t triangles[2][3];
    float colors[6][4];
    psplat_mesh mesh;
    psplat_source_mesh *original;
} plate;

/* Stores the splat's blended normal at (u, v), by the formula in splat.h; its length need not be 1.
 */
static void field_at(const psplat_splat *s, double u, double v, float normal[3]) {
    double q = (double)s->radius[1] / (double)s->radius[0], z = (double)s->normal[2];
    normal[0] = (float)((double)s->normal[0] / z + (double)s->gradient[0] * u +
                        (double)s->gradient[2] * q * v);
    normal[1] =
        (float)((double)s->normal[1] / z + (double)s->gradient[2] * u + (double)s->gradient[1] * v);
    normal[2] = 1;
}

/* Makes a splat with unit axes along x, y, z. The mesh gets the normals of its field, which need
 * not have unit length. */
static void plate_make(plate *p, const psplat_material *material, const double origin[3],
                       int colored) {
    static const int corners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    static const uint32_t triangles[2][3] = {{0, 1, 2}, {0, 2, 3}};
    *p = (plate){.splat = scene_disc(1)};
    psplat_splat *s = p->splat.splats;
    const psplat_splat bent = {.rotation = {0, 0, 0, 1},
                               .radius = {1, 0.7f},
                               .normal = {0.19611614f, -0.09805807f, 0.97565754f},
                               .gradient = {0.5f, -0.3f, 0.2f},
                               .color = {1, 1, 1, 1}};
    *s = bent;
    if (colored) s->color[0] = 0.8f, s->color[1] = 0.1f, s->color[2] = 0.3f;
    p->splat.has_color = colored;
    p->splat.material = *material;
    memcpy(p->splat.origin, origin, sizeof p->splat.origin);
    memcpy(p->triangles, triangles, sizeof triangles);
    for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 2; ++k)
            p->positions[i][k] = half * corners[i][k] * (double)s->radius[k];
    for (int i = 0; i < 6; ++i) memcpy(p->colors[i], s->color, sizeof s->color);
    p->mesh = (psplat_mesh){.positions = p->positions[0],
                            .triangles = p->triangles[0],
                            .corner_colors = colored ? p->colors[0] : NULL,
                            .vertex_count = 4,
                            .triangle_count = 2,
                            .material = *material};
    memcpy(p->mesh.origin, origin, sizeof p->mesh.origin);
    assert_int_equal(psplat_source_mesh_create(&p->mesh, 0, &p->original, NULL), PSPLAT_OK);
    for (int i = 0; i < 6; ++i) {
        const int *corner = corners[p->triangles[i / 3][i % 3]];
        field_at(s, half * corner[0], half * corner[1],
                 p->original->surface.corner_normals + 3 * i);
    }
}

static void plate_free(plate *p) {
    psplat_source_mesh_destroy(p->original);
    scene_free(&p->splat);
}

static psplat_view view_of(const double origin[3], const double direction[3]) {
    psplat_view view = camera_view(SIZE, SIZE);
    double eye[3];
    for (int i = 0; i < 3; ++i) eye[i] = origin[i] + direction[i];
    camera_look(&view, eye, origin);
    camera_perspective(&view, SIZE, 0.5, 20);
    view.linear_output = 0;
    view.no_filter = 1; /* The filter would widen outlines. */
    const float directions[3][3] = {{0.3f, -0.4f, -2}, {-1, 0.5f, -0.7f}, {0.2f, 0.1f, 1}};
    for (int k = 0; k < 3; ++k) {
        memcpy(view.lights[k].direction, directions[k], sizeof directions[k]);
        for (int c = 0; c < 3; ++c) view.lights[k].color[c] = 0.6f + 0.4f * (float)((k + c) % 3);
    }
    view.light_count = 3;
    for (int c = 0; c < 3; ++c) view.ambient[c] = 0.05f + 0.04f * (float)c;
    return view;
}

static void check(psplat_result result, const psplat_error *error) {
    if (result) fail_msg("%s", error->text);
}

static void begin(gpu *g, int is_float) {
    static const float nothing[4] = {0};
    psplat_error error;
    check(psplat_host_begin(g->host, SIZE, SIZE, is_float, nothing, &error), &error);
}

static psplat_mesh_renderer *renderer_of(gpu *g, const plate *p) {
    const psplat_mesh_renderer_desc desc = {psplat_host_get_proc, g->host, p->original};
    psplat_mesh_renderer *renderer;
    psplat_error error;
    check(psplat_mesh_renderer_create(&desc, &renderer, &error), &error);
    return renderer;
}

static void draw_both(gpu *g, const plate *p, const psplat_view *view, uint8_t *splat,
                      uint8_t *mesh) {
    psplat_error error;
    psplat_asset *asset = scene_open(&p->splat);
    psplat_model *model;
    check(psplat_model_create(g->renderer, asset, &model, &error), &error);
    begin(g, 0);
    check(psplat_draw(g->renderer, view, &(psplat_item){.model = model}, 1, &error), &error);
    check(psplat_host_read_rgba8(g->host, splat, &error), &error);
    psplat_model_destroy(g->renderer, model);
    psplat_asset_destroy(asset);
    psplat_mesh_renderer *renderer = renderer_of(g, p);
    begin(g, 0);
    check(psplat_mesh_renderer_draw(renderer, view, PSPLAT_MESH_RENDERER_LIGHT, &error), &error);
    check(psplat_host_read_rgba8(g->host, mesh, &error), &error);
    psplat_mesh_renderer_destroy(renderer);
}

/* ---- colours --------------------------------------------------------------------------------- */

typedef struct look {
    const char *name;
    psplat_material material;
    int colored;
    double direction[3];
    int expected; /* whether anything is drawn */
} look;

#define PLAIN                                                                                      \
    { 0.9f, 0.5f, 0.2f, 1 }
#define FRONT                                                                                      \
    { 1.5, -0.8, 2.2 }
#define BEHIND                                                                                     \
    { 0.4, 0.5, -2.5 }

static const look looks[] = {
    {"rough", {.base_color = PLAIN, .roughness = 1}, 0, FRONT, 1},
    {"shiny", {.base_color = PLAIN, .roughness = 0.3f}, 0, FRONT, 1},
    {"mirror-like",
     {.base_color = PLAIN, .metallic = 0.5f, .roughness = 0.02f},
     0,
     {-0.3, 0.1, 2.5},
     1},
    {"metallic", {.base_color = PLAIN, .metallic = 1, .roughness = 0.4f}, 0, FRONT, 1},
    {"emissive",
     {.base_color = PLAIN, .emissive = {0.1f, 0.3f, 2}, .roughness = 0.5f},
     0,
     FRONT,
     1},
    {"unlit", {.base_color = PLAIN, .roughness = 0.5f, .unlit = 1}, 0, FRONT, 1},
    {"coloured", {.base_color = PLAIN, .metallic = 0.2f, .roughness = 0.6f}, 1, FRONT, 1},
    {"unlit and coloured",
     {.base_color = PLAIN, .metallic = 0.2f, .roughness = 0.6f, .unlit = 1},
     1,
     FRONT,
     1},
    {"two-sided, front", {.base_color = PLAIN, .roughness = 0.5f, .double_sided = 1}, 0, FRONT, 1},
    {"two-sided, behind",
     {.base_color = PLAIN, .roughness = 0.5f, .double_sided = 1},
     1,
     BEHIND,
     1},
    {"single-sided, behind", {.base_color = PLAIN, .roughness = 0.5f}, 0, BEHIND, 0},
};

static void compare_look(gpu *g, const look *l, const psplat_view *view, const double origin[3]) {
    static uint8_t splat[BYTES], mesh[BYTES];
    size_t covered = 0, only = 0, square = 0;
    int most = 0, darkest = 255, brightest = 0;
    plate p;
    plate_make(&p, &l->material, origin, l->colored);
    draw_both(g, &p, view, splat, mesh);
    for (int i = 0; i < BYTES; i += 4) {
        square += mesh[i + 3] != 0;
        only += splat[i + 3] && !mesh[i + 3];
        if (!splat[i + 3] || !mesh[i + 3]) continue;
        ++covered;
        for (int c = 0; c < 3; ++c) {
            int d = abs(splat[i + c] - mesh[i + c]);
            if (d > most) most = d;
        }
        if (mesh[i] < darkest) darkest = mesh[i];
        if (mesh[i] > brightest) brightest = mesh[i];
    }
    print_message("%-20s %5zu pixels, red %3d ... %3d, difference %d / 255\n", l->name, covered,
                  darkest, brightest, most);
    if (!l->expected) assert_int_equal(covered + square, 0);
    if (l->expected) assert_in_range(covered, 1200, square);
    assert_int_equal(only, 0);
    /* One step of 8 bits, where the two programs round to either side. */
    assert_in_range(most, 0, 1);
    plate_free(&p);
}

static void test_colors(void **state) {
    const double origin[3] = {0, 0, 0};
    for (size_t i = 0; i < sizeof looks / sizeof *looks; ++i) {
        psplat_view view = view_of(origin, looks[i].direction);
        compare_look(*state, &looks[i], &view, origin);
    }
}

static void test_culling(void **state) {
    const double origin[3] = {0, 0, 0};
    look behind = looks[10], front = looks[8];
    psplat_view view = view_of(origin, behind.direction);
    view.culling = PSPLAT_CULL_NEVER;
    behind.expected = 1;
    compare_look(*state, &behind, &view, origin);
    view = view_of(origin, front.direction);
    view.culling = PSPLAT_CULL_ALWAYS;
    compare_look(*state, &front, &view, origin);
}

static void test_parallel(void **state) {
    const double origin[3] = {0, 0, 0}, direction[3] = FRONT;
    psplat_view view = view_of(origin, direction);
    camera_parallel(&view, 1.4, 0.5, 20);
    compare_look(*state, &looks[1], &view, origin);
}

static void test_far_away(void **state) {
    const double origin[3] = {1e6, -2e6, 3e6}, direction[3] = FRONT;
    psplat_view view = view_of(origin, direction);
    compare_look(*state, &looks[1], &view, origin);
}

static void test_viewport_and_linear_output(void **state) {
    gpu *g = *state;
    static float whole[BYTES];
    const double origin[3] = {0, 0, 0}, direction[3] = FRONT;
    psplat_view view = view_of(origin, direction);
    psplat_error error;
    plate p;
    plate_make(&p, &looks[4].material, origin, 0);
    psplat_mesh_renderer *renderer = renderer_of(g, &p);
    view.x = SIZE / 2;
    view.width = view.height = SIZE / 2;
    view.linear_output = 1;
    begin(g, 1);
    check(psplat_mesh_renderer_draw(renderer, &view, PSPLAT_MESH_RENDERER_LIGHT, &error), &error);
    check(psplat_host_read_float(g->host, whole, &error), &error);
    size_t covered = 0, bright = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        if (whole[4 * i + 3] == 0) continue;
        assert_true(i % SIZE >= SIZE / 2 && i / SIZE < SIZE / 2);
        ++covered;
        bright += whole[4 * i + 2] > 2; /* The emission is 2, to which the light is added. */
    }
    assert_in_range(covered, 500, SIZE * SIZE / 4);
    assert_int_equal(bright, covered);
    psplat_mesh_renderer_destroy(renderer);
    plate_free(&p);
}

/* ---- normals --------------------------------------------------------------------------------- */

static void test_normals(void **state) {
    gpu *g = *state;
    static float normals[BYTES];
    const double origin[3] = {0, 0, 0}, direction[3] = {0, 0, 3};
    psplat_view view = view_of(origin, direction); /* its axes are those of the scene */
    psplat_error error;
    plate p;
    plate_make(&p, &looks[0].material, origin, 0);
    psplat_mesh_renderer *renderer = renderer_of(g, &p);
    begin(g, 1);
    check(psplat_mesh_renderer_draw(renderer, &view, PSPLAT_MESH_RENDERER_NORMALS, &error), &error);
    check(psplat_host_read_float(g->host, normals, &error), &error);
    const psplat_splat *s = p.splat.splats;
    size_t covered = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        if (normals[4 * i + 3] == 0) continue;
        float expected[3];
        double x = 3 * (i % SIZE + 0.5 - SIZE / 2) / SIZE,
               y = 3 * (i / SIZE + 0.5 - SIZE / 2) / SIZE;
        field_at(s, x / (double)s->radius[0], y / (double)s->radius[1], expected);
        /* Rounding to float over three units, and the subpixels of the rasteriser (1/256). */
        for (int c = 0; c < 3; ++c)
            assert_near((double)normals[4 * i + c], (double)expected[c], 1e-3);
        ++covered;
    }
    assert_in_range(covered, 5000, 10000); /* 2.6 x 1.82 of 3 x 3 units */
    psplat_mesh_renderer_destroy(renderer);
    plate_free(&p);
}

/* ---- refusals -------------------------------------------------------------------------------- */

static void test_other_light(void **state) {
    gpu *g = *state;
    const double origin[3] = {0, 0, 0}, direction[3] = FRONT;
    plate p;
    plate_make(&p, &looks[0].material, origin, 0);
    psplat_mesh_renderer *renderer = renderer_of(g, &p);
    psplat_view view = view_of(origin, direction);
    psplat_error error;
    view.lights[1].type = PSPLAT_LIGHT_POINT;
    assert_int_equal(psplat_mesh_renderer_draw(renderer, &view, PSPLAT_MESH_RENDERER_LIGHT, &error),
                     PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(error.code, PSPLAT_ERROR_ARGUMENT);
    view.lights[1].type = PSPLAT_LIGHT_DIRECTIONAL;
    view.lights[2].casts_shadow = 1;
    assert_int_equal(psplat_mesh_renderer_draw(renderer, &view, PSPLAT_MESH_RENDERER_LIGHT, &error),
                     PSPLAT_ERROR_ARGUMENT);
    view.light_count = 2; /* Only the first two lights shine. */
    assert_int_equal(psplat_mesh_renderer_draw(renderer, &view, PSPLAT_MESH_RENDERER_LIGHT, &error),
                     PSPLAT_OK);
    view.light_count = PSPLAT_MAX_LIGHTS + 1;
    assert_int_equal(psplat_mesh_renderer_draw(renderer, &view, PSPLAT_MESH_RENDERER_LIGHT, &error),
                     PSPLAT_ERROR_ARGUMENT);
    psplat_mesh_renderer_destroy(renderer);
    plate_free(&p);
}

/* A function loader with faults. GL functions have no user pointer, hence a static object. */
static struct fault {
    psplat_host *host;
    const char *missing; /* name of a function that is absent */
    const char *refused; /* "shader", "program" or "version", which fails */
    unsigned error;      /* an error flag that is set after buffers were filled */
    int filled;
    PFNGLBUFFERDATAPROC buffer_data;
    PFNGLGETERRORPROC get_error;
    PFNGLGETSHADERIVPROC get_shader;
    PFNGLGETPROGRAMIVPROC get_program;
} fault;

static void APIENTRY fault_buffer_data(GLenum target, GLsizeiptr size, const void *data,
                                       GLenum usage) {
    fault.buffer_data(target, size, data, usage);
    fault.filled = 1;
}

static GLenum APIENTRY fault_get_error(void) {
    GLenum error = fault.filled ? fault.error : GL_NO_ERROR;
    fault.filled = 0;
    return error ? error : fault.get_error();
}

static void APIENTRY fault_get_shader(GLuint shader, GLenum name, GLint *value) {
    fault.get_shader(shader, name, value);
    if (fault.refused && strcmp(fault.refused, "shader") == 0) *value = 0;
}

static void APIENTRY fault_get_program(GLuint program, GLenum name, GLint *value) {
    fault.get_program(program, name, value);
    if (fault.refused && strcmp(fault.refused, "program") == 0) *value = 0;
}

static const GLubyte *APIENTRY fault_get_string(GLenum name) {
    (void)name;
    return NULL;
}

static void *replace(void *function, size_t size, void (*with)(void), void *address) {
    void *result;
    memcpy(function, &address, size);
    memcpy(&result, &with, sizeof result);
    return result;
}

#define REPLACE(member, with)                                                                      \
    replace(&fault.member, sizeof fault.member, (void (*)(void))with, address)

static void *fault_get_proc(void *user, const char *name) {
    void *address = psplat_host_get_proc(user, name);
    if (fault.missing && strcmp(name, fault.missing) == 0) return NULL;
    if (strcmp(name, "glBufferData") == 0) return REPLACE(buffer_data, fault_buffer_data);
    if (strcmp(name, "glGetError") == 0) return REPLACE(get_error, fault_get_error);
    if (strcmp(name, "glGetShaderiv") == 0) return REPLACE(get_shader, fault_get_shader);
    if (strcmp(name, "glGetProgramiv") == 0) return REPLACE(get_program, fault_get_program);
    if (strcmp(name, "glGetString") == 0 && fault.refused && strcmp(fault.refused, "version") == 0)
        return REPLACE(get_error, fault_get_string);
    return address;
}

static void expect_failure(gpu *g, const plate *p, psplat_result code, const char *words) {
    const psplat_mesh_renderer_desc desc = {fault_get_proc, g->host, p->original};
    psplat_mesh_renderer *renderer = (psplat_mesh_renderer *)&fault;
    psplat_error error = {0};
    assert_int_equal(psplat_mesh_renderer_create(&desc, &renderer, &error), code);
    assert_null(renderer);
    assert_int_equal(error.code, code);
    if (!strstr(error.text, words)) fail_msg("no '%s' in: %s", words, error.text);
    assert_int_equal(psplat_mesh_renderer_create(&desc, &renderer, NULL), code);
}

static void test_failures(void **state) {
    gpu *g = *state;
    const double origin[3] = {0, 0, 0};
    plate p;
    plate_make(&p, &looks[0].material, origin, 1);
    fault = (struct fault){.missing = "glDrawElements"};
    expect_failure(g, &p, PSPLAT_ERROR_GRAPHICS, "glDrawElements");
    fault = (struct fault){.missing = "glViewport"};
    expect_failure(g, &p, PSPLAT_ERROR_GRAPHICS, "glViewport");
    fault = (struct fault){.refused = "version"};
    expect_failure(g, &p, PSPLAT_ERROR_GRAPHICS, "no GL context");
    fault = (struct fault){.refused = "shader"};
    expect_failure(g, &p, PSPLAT_ERROR_GRAPHICS, "shader");
    fault = (struct fault){.refused = "program"};
    expect_failure(g, &p, PSPLAT_ERROR_GRAPHICS, "program");
    fault = (struct fault){.error = GL_OUT_OF_MEMORY};
    expect_failure(g, &p, PSPLAT_ERROR_MEMORY, "memory");
    fault = (struct fault){.error = GL_INVALID_OPERATION};
    expect_failure(g, &p, PSPLAT_ERROR_GRAPHICS, "0x502");
    fault = (struct fault){0};
    const psplat_mesh_renderer_desc desc = {fault_get_proc, g->host, p.original};
    psplat_mesh_renderer *renderer;
    assert_int_equal(psplat_mesh_renderer_create(&desc, &renderer, NULL), PSPLAT_OK);
    psplat_mesh_renderer_destroy(renderer);
    psplat_mesh_renderer_destroy(NULL);
    plate_free(&p);
}

int test_mesh_renderer_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_colors),
        cmocka_unit_test(test_culling),
        cmocka_unit_test(test_parallel),
        cmocka_unit_test(test_far_away),
        cmocka_unit_test(test_viewport_and_linear_output),
        cmocka_unit_test(test_normals),
        cmocka_unit_test(test_other_light),
        cmocka_unit_test(test_failures),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", tests, gpu_setup_gles, gpu_teardown);
}

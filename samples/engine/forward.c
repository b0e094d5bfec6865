/* SPDX-License-Identifier: MIT
 *
 * forward.c - see forward.h.
 */
#include "forward.h"

#include <string.h>

static const float ambient[3] = {0.16f, 0.17f, 0.2f};
/* The sky's faces +x -x +y -y +z -z: bright above, dark below. */
static const float sky_radiance[6 * 3] = {0.18f, 0.18f, 0.20f, 0.18f, 0.18f, 0.20f,
                                          0.40f, 0.45f, 0.55f, 0.08f, 0.08f, 0.07f,
                                          0.18f, 0.18f, 0.20f, 0.18f, 0.18f, 0.20f};

/* The framebuffer is sRGB and encodes the linear colour that is written. */
static const char mesh_source[] =
    "#version 330 core\n"
    "in vec3 n, at;\n"
    "uniform vec3 color, light, sun, ambient;\n"
    "uniform mat4 to_map;\n"
    "uniform sampler2DShadow map;\n"
    "out vec4 pixel;\n"
    "void main() {\n"
    "    float part = texture(map, (to_map * vec4(at, 1.0)).xyz);\n"
    "    vec3 lit = part * sun * max(-dot(normalize(n), normalize(light)), 0.0);\n"
    "    pixel = vec4(color * (lit / 3.14159 + ambient), 1.0);\n"
    "}\n";

/* The renderer's own light, of which the engine's shadow map lets a part through. The point is
 * lifted off the surface by about a texel of the map. */
static const char splat_source[] =
    "uniform mat4 to_map;\n"
    "uniform highp sampler2DShadow map;\n"
    "layout(location = 0) out vec4 o_color;\n"
    "float light_part(int light, vec3 position, vec3 normal) {\n"
    "    return texture(map, (to_map * vec4(position + 0.01 * normal, 1.0)).xyz);\n"
    "}\n"
    "void resolve(Pixel pixel) {\n"
    "    o_color = vec4(encode(shade(pixel.normal, pixel.window, pixel.color,\n"
    "                                pixel.emissive, pixel.surface)), 1.0);\n"
    "}\n";

int forward_make(forward *f, const engine_gl *gl, const frame *frame, psplat_renderer *renderer,
                 psplat_error *error) {
    const psplat_environment_desc sky = {.radiance = sky_radiance, .size = 1};
    f->gl = gl;
    f->frame = frame;
    if (!paint_make(&f->paint, gl, mesh_source)) {
        psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "GL refuses the shader of meshes");
        return 0;
    }
    f->light = gl->GetUniformLocation(f->paint.program, "light");
    f->sun = gl->GetUniformLocation(f->paint.program, "sun");
    f->ambient = gl->GetUniformLocation(f->paint.program, "ambient");
    f->to_map = gl->GetUniformLocation(f->paint.program, "to_map");
    f->map = gl->GetUniformLocation(f->paint.program, "map");
    return psplat_environment_create(renderer, &sky, &f->sky, error) == PSPLAT_OK;
}

void forward_free(forward *f, psplat_renderer *renderer) {
    psplat_environment_destroy(renderer, f->sky);
}

void forward_begin(const forward *f, screen *s) {
    const engine_gl *gl = f->gl;
    const matrix world = matrix_scale(1, 1, 1);
    matrix clip = matrix_multiply(&f->frame->projection, &f->frame->view);
    float to_map[16];
    screen_begin(s, gl);
    gl->Enable(GL_DEPTH_TEST);
    gl->Disable(GL_POLYGON_OFFSET_FILL);
    gl->Enable(GL_FRAMEBUFFER_SRGB);
    paint_use(&f->paint, gl, &clip);
    shadow_map_matrix(&f->frame->shadows, &world, to_map);
    shadow_map_bind(&f->frame->shadows, gl);
    gl->UniformMatrix4fv(f->to_map, 1, GL_FALSE, to_map);
    gl->Uniform1i(f->map, SHADOW_UNIT);
    gl->Uniform3fv(f->light, 1, f->frame->sun_direction);
    gl->Uniform3fv(f->sun, 1, f->frame->sun);
    gl->Uniform3fv(f->ambient, 1, ambient);
}

/* Sets the uniforms of splat_source. phongsplat makes a few programs of it and says when one is
 * new.
 */
static void use(void *user, unsigned program, int is_new) {
    forward *f = user;
    const engine_gl *gl = f->gl;
    matrix to_world = matrix_unlook(&f->frame->view);
    float to_map[16];
    if (is_new || program != f->splat_program) {
        f->splat_program = program;
        f->splat_to_map = gl->GetUniformLocation(program, "to_map");
        gl->Uniform1i(gl->GetUniformLocation(program, "map"), SHADOW_UNIT);
    }
    shadow_map_matrix(&f->frame->shadows, &to_world, to_map);
    gl->UniformMatrix4fv(f->splat_to_map, 1, GL_FALSE, to_map);
}

psplat_result forward_draw_splats(forward *f, psplat_renderer *renderer, const psplat_item *items,
                                  size_t count, psplat_error *error) {
    const psplat_resolve resolve = {
        .source = splat_source, .filters_light = 1, .use = use, .user = f};
    psplat_view view = {.width = SCREEN_WIDTH, .height = SCREEN_HEIGHT, .light_count = 1};
    view.linear_output = 1; /* the framebuffer encodes sRGB */
    view.resolve = &resolve;
    view.environment = f->sky;
    memcpy(view.view, f->frame->view.m, sizeof view.view);
    memcpy(view.projection, f->frame->projection.m, sizeof view.projection);
    memcpy(view.lights[0].direction, f->frame->sun_direction, sizeof view.lights[0].direction);
    memcpy(view.lights[0].color, f->frame->sun, sizeof view.lights[0].color);
    return psplat_draw(renderer, &view, items, count, error);
}

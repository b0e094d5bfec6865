/* SPDX-License-Identifier: MIT
 *
 * lighting.c - uniforms of the benchmark's own programs; see lighting.h.
 */
#include "lighting.h"

#include <math.h>

static GLint at(const bench_gl *gl, GLuint program, const char *name) {
    return gl->base.GetUniformLocation(program, name);
}

void lighting_place(const bench_gl *gl, GLuint program, const psplat_view *view,
                    const double model[16]) {
    float modelview[16], projection[16];
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += view->view[4 * k + row] * model[4 * column + k];
            modelview[4 * column + row] = (float)sum;
        }
    for (int i = 0; i < 16; ++i) projection[i] = (float)view->projection[i];
    gl->base.UniformMatrix4fv(at(gl, program, "u_modelview"), 1, GL_FALSE, modelview);
    gl->base.UniformMatrix4fv(at(gl, program, "u_projection"), 1, GL_FALSE, projection);
    gl->base.Uniform2f(at(gl, program, "u_viewport"), (float)view->width, (float)view->height);
}

void lighting_ray(const bench_gl *gl, GLuint program, const psplat_view *view) {
    double x = 1.0 / view->projection[0], y = 1.0 / view->projection[5];
    const float ray[9] = {(float)(2 * x / view->width),
                          0,
                          0,
                          0,
                          (float)(2 * y / view->height),
                          0,
                          (float)(x * (view->projection[8] - 1)),
                          (float)(y * (view->projection[9] - 1)),
                          -1};
    gl->base.UniformMatrix3fv(at(gl, program, "u_ray"), 1, GL_FALSE, ray);
}

static void set_lights(const bench_gl *gl, GLuint program, const psplat_view *view) {
    float directions[3 * PSPLAT_MAX_LIGHTS], colors[3 * PSPLAT_MAX_LIGHTS];
    for (int k = 0; k < view->light_count; ++k) {
        const psplat_light *light = &view->lights[k];
        double eye[3], square = 0;
        for (int i = 0; i < 3; ++i) {
            eye[i] = 0;
            for (int j = 0; j < 3; ++j)
                eye[i] -= view->view[4 * j + i] * (double)light->direction[j];
            square += eye[i] * eye[i];
        }
        for (int i = 0; i < 3; ++i) {
            directions[3 * k + i] = (float)(eye[i] / sqrt(square));
            colors[3 * k + i] = light->color[i];
        }
    }
    gl->base.Uniform3fv(at(gl, program, "u_light_directions"), view->light_count, directions);
    gl->base.Uniform3fv(at(gl, program, "u_light_colors"), view->light_count, colors);
    gl->base.Uniform1i(at(gl, program, "u_light_count"), view->light_count);
}

void lighting_light(const bench_gl *gl, GLuint program, const psplat_view *view,
                    const psplat_material *material) {
    const float surface[3] = {material->metallic, material->roughness, material->unlit ? 1.f : 0.f};
    set_lights(gl, program, view);
    gl->base.Uniform3fv(at(gl, program, "u_ambient"), 1, view->ambient);
    gl->base.Uniform3fv(at(gl, program, "u_base_color"), 1, material->base_color);
    gl->base.Uniform3fv(at(gl, program, "u_emissive"), 1, material->emissive);
    gl->base.Uniform3fv(at(gl, program, "u_surface"), 1, surface);
    gl->base.Uniform1i(at(gl, program, "u_linear_output"), view->linear_output);
    gl->base.Uniform1i(at(gl, program, "u_two_sided"), lighting_two_sided(view, material));
}

int lighting_two_sided(const psplat_view *view, const psplat_material *material) {
    return view->culling == PSPLAT_CULL_NEVER ||
           (view->culling == PSPLAT_CULL_BY_MATERIAL && material->double_sided);
}

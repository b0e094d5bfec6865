/* SPDX-License-Identifier: MIT
 *
 * deferred.c - see deferred.h.
 */
#include "deferred.h"

#include <math.h>
#include <string.h>

/* The G-buffer's third colour channel has no emission for meshes, and all of them are rough. */
static const char mesh_source[] = "#version 330 core\n"
                                  "in vec3 n;\n"
                                  "uniform mat4 view;\n"
                                  "uniform vec3 color;\n"
                                  "layout(location = 0) out vec4 normal;\n"
                                  "layout(location = 1) out vec4 albedo;\n"
                                  "layout(location = 2) out vec4 emission;\n"
                                  "void main() {\n"
                                  "    normal = vec4(0.5 + 0.5 * normalize(mat3(view) * n), 1.0);\n"
                                  "    albedo = vec4(color, 0.0);\n"
                                  "    emission = vec4(0.0, 0.0, 0.0, 0.8);\n"
                                  "}\n";

/* The same of splats: this is all that they need. */
static const char splat_source[] = "layout(location = 0) out vec4 normal;\n"
                                   "layout(location = 1) out vec4 albedo;\n"
                                   "layout(location = 2) out vec4 emission;\n"
                                   "void resolve(Pixel pixel) {\n"
                                   "    normal = vec4(0.5 + 0.5 * normalize(pixel.normal), 1.0);\n"
                                   "    albedo = vec4(pixel.color, pixel.surface.x);\n"
                                   "    emission = vec4(pixel.emissive, pixel.surface.y);\n"
                                   "}\n";

static const char whole_source[] =
    "#version 330 core\n"
    "void main() {\n"
    "    gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1);\n"
    "}\n";

/* All in eye space. The sun has the shadow map, the sky is brighter above, lamps end at a distance
 * of 1.5. */
static const char light_source[] =
    "#version 330 core\n"
    "uniform sampler2D g0, g1, g2, g3;\n"
    "uniform sampler2DShadow map;\n"
    "uniform vec4 lens; /* 1 / focal lengths; two entries of the projection */\n"
    "uniform mat4 to_map;\n"
    "uniform vec3 sun_direction, sun, up;\n"
    "uniform vec4 lamps[12]; /* place and warmth */\n"
    "out vec4 pixel;\n"
    "vec3 reflected(vec3 n, vec3 l, vec3 eye, vec3 diffuse, vec3 f0, float rough) {\n"
    "    vec3 h = normalize(l + eye);\n"
    "    float a = rough * rough, nh = max(dot(n, h), 0.0), d = nh * nh * (a * a - 1.0) + 1.0;\n"
    "    vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - max(dot(l, h), 0.0), 5.0);\n"
    "    float shine = a * a / (12.566 * d * d * mix(a, 1.0, max(dot(n, eye), 0.0)));\n"
    "    return max(dot(n, l), 0.0) * (diffuse * (1.0 - fresnel) / 3.14159 + fresnel * shine);\n"
    "}\n"
    "void main() {\n"
    "    ivec2 here = ivec2(gl_FragCoord.xy);\n"
    "    float depth = texelFetch(g3, here, 0).r;\n"
    "    if (depth == 1.0) discard;\n"
    "    vec3 n = normalize(2.0 * texelFetch(g0, here, 0).xyz - 1.0);\n"
    "    vec4 albedo = texelFetch(g1, here, 0), emission = texelFetch(g2, here, 0);\n"
    "    vec2 ndc = 2.0 * gl_FragCoord.xy / vec2(textureSize(g3, 0)) - 1.0;\n"
    "    float z = lens.w / (2.0 * depth - 1.0 + lens.z);\n"
    "    vec3 at = vec3(ndc * lens.xy * z, -z), eye = normalize(-at);\n"
    "    vec3 diffuse = albedo.rgb * (1.0 - albedo.a), f0 = mix(vec3(0.04), albedo.rgb, "
    "albedo.a);\n"
    "    float part = texture(map, (to_map * vec4(at + 0.01 * n, 1.0)).xyz);\n"
    "    vec3 sum = part * sun * reflected(n, -sun_direction, eye, diffuse, f0, emission.a);\n"
    "    sum += mix(vec3(0.05), vec3(0.2, 0.22, 0.26), 0.5 + 0.5 * dot(n, up)) * (diffuse + f0);\n"
    "    for (int i = 0; i < 12; ++i) {\n"
    "        vec3 l = lamps[i].xyz - at;\n"
    "        float far = length(l), fade = max(1.0 - far * far / 2.25, 0.0);\n"
    "        vec3 color = mix(vec3(0.35, 0.5, 0.8), vec3(1.0, 0.7, 0.4), lamps[i].w);\n"
    "        sum += color * 0.5 * fade * fade / (far * far + 0.01) *\n"
    "               reflected(n, l / far, eye, diffuse, f0, emission.a);\n"
    "    }\n"
    "    pixel = vec4(sum + emission.rgb, 1.0);\n"
    "}\n";

static const GLenum buffers[DEFERRED_COLORS] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1,
                                                GL_COLOR_ATTACHMENT2};

/* The units of the G-buffer's textures are the host's, as that of the shadow map. */
static GLenum unit_of(int texture) {
    return SHADOW_UNIT + 1 + (GLenum)texture;
}

static void make_gbuffer(deferred *d) {
    static const struct {
        GLint format;
        GLenum channels, type;
    } texels[DEFERRED_COLORS + 1] = {
        {GL_RGB10_A2, GL_RGBA, GL_UNSIGNED_BYTE},
        {GL_SRGB8_ALPHA8, GL_RGBA, GL_UNSIGNED_BYTE},
        {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE},
        {GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT},
    };
    const engine_gl *gl = d->gl;
    gl->GenFramebuffers(1, &d->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, d->framebuffer);
    gl->GenTextures(DEFERRED_COLORS + 1, d->textures);
    for (int i = 0; i <= DEFERRED_COLORS; ++i) {
        gl->ActiveTexture(GL_TEXTURE0 + unit_of(i));
        gl->BindTexture(GL_TEXTURE_2D, d->textures[i]);
        gl->TexImage2D(GL_TEXTURE_2D, 0, texels[i].format, SCREEN_WIDTH, SCREEN_HEIGHT, 0,
                       texels[i].channels, texels[i].type, NULL);
        gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        gl->FramebufferTexture2D(GL_FRAMEBUFFER,
                                 i < DEFERRED_COLORS ? buffers[i] : GL_DEPTH_ATTACHMENT,
                                 GL_TEXTURE_2D, d->textures[i], 0);
    }
    gl->DrawBuffers(DEFERRED_COLORS, buffers);
}

static int make_light(deferred *d) {
    static const char *const names[DEFERRED_COLORS + 1] = {"g0", "g1", "g2", "g3"};
    const engine_gl *gl = d->gl;
    d->light = program_make(gl, whole_source, light_source);
    if (!d->light) return 0;
    gl->UseProgram(d->light);
    for (int i = 0; i <= DEFERRED_COLORS; ++i)
        gl->Uniform1i(gl->GetUniformLocation(d->light, names[i]), (GLint)unit_of(i));
    gl->Uniform1i(gl->GetUniformLocation(d->light, "map"), SHADOW_UNIT);
    d->lens = gl->GetUniformLocation(d->light, "lens");
    d->to_map = gl->GetUniformLocation(d->light, "to_map");
    d->sun_direction = gl->GetUniformLocation(d->light, "sun_direction");
    d->sun = gl->GetUniformLocation(d->light, "sun");
    d->up = gl->GetUniformLocation(d->light, "up");
    d->lamps = gl->GetUniformLocation(d->light, "lamps");
    return 1;
}

int deferred_make(deferred *d, const engine_gl *gl, const frame *frame) {
    d->gl = gl;
    d->frame = frame;
    if (!paint_make(&d->paint, gl, mesh_source) || !make_light(d)) return 0;
    d->paint_view = gl->GetUniformLocation(d->paint.program, "view");
    gl->GenVertexArrays(1, &d->nothing);
    make_gbuffer(d);
    return 1;
}

void deferred_begin(const deferred *d, int clears) {
    const engine_gl *gl = d->gl;
    matrix clip = matrix_multiply(&d->frame->projection, &d->frame->view);
    float view[16];
    matrix_to_float(&d->frame->view, view);
    gl->BindFramebuffer(GL_FRAMEBUFFER, d->framebuffer);
    gl->Viewport(0, 0, SCREEN_WIDTH, SCREEN_HEIGHT);
    gl->ClearColor(0, 0, 0, 0);
    if (clears) gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    gl->Enable(GL_DEPTH_TEST);
    gl->Disable(GL_POLYGON_OFFSET_FILL);
    gl->Enable(GL_FRAMEBUFFER_SRGB); /* for the albedo */
    paint_use(&d->paint, gl, &clip);
    gl->UniformMatrix4fv(d->paint_view, 1, GL_FALSE, view);
}

psplat_result deferred_draw_splats(const deferred *d, psplat_renderer *renderer,
                                   const psplat_item *items, size_t count, psplat_error *error) {
    const psplat_resolve resolve = {.source = splat_source};
    psplat_view view = {.width = SCREEN_WIDTH, .height = SCREEN_HEIGHT, .resolve = &resolve};
    view.host.framebuffer = d->framebuffer;
    memcpy(view.view, d->frame->view.m, sizeof view.view);
    memcpy(view.projection, d->frame->projection.m, sizeof view.projection);
    return psplat_draw(renderer, &view, items, count, error);
}

/* Rotates a direction from world to eye space and makes it a unit vector. */
static void turn_to_eye(const deferred *d, const float direction[3], float out[3]) {
    double length = 0;
    for (int i = 0; i < 3; ++i) length += (double)direction[i] * (double)direction[i];
    for (int row = 0; row < 3; ++row) {
        double sum = 0;
        for (int i = 0; i < 3; ++i) sum += d->frame->view.m[4 * i + row] * (double)direction[i];
        out[row] = (float)(sum / sqrt(length));
    }
}

/* Lamps hang in a ring, warm and cold in turn. */
static void use_lamps(const deferred *d) {
    float lamps[DEFERRED_LAMPS][4];
    for (int i = 0; i < DEFERRED_LAMPS; ++i) {
        double angle = 6.283185307179586 * i / DEFERRED_LAMPS;
        const double at[4] = {1.9 * sin(angle), 0.55, 1.9 * cos(angle), 1};
        for (int row = 0; row < 3; ++row) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += d->frame->view.m[4 * k + row] * at[k];
            lamps[i][row] = (float)sum;
        }
        lamps[i][3] = (float)(i % 2);
    }
    d->gl->Uniform4fv(d->lamps, DEFERRED_LAMPS, lamps[0]);
}

void deferred_light(const deferred *d, screen *s) {
    static const float up[3] = {0, 1, 0};
    const engine_gl *gl = d->gl;
    const double *p = d->frame->projection.m;
    const float lens[4] = {(float)(1 / p[0]), (float)(1 / p[5]), (float)p[10], (float)p[14]};
    matrix to_world = matrix_unlook(&d->frame->view);
    float to_map[16], direction[3], eye_up[3];
    shadow_map_matrix(&d->frame->shadows, &to_world, to_map);
    turn_to_eye(d, d->frame->sun_direction, direction);
    turn_to_eye(d, up, eye_up);
    screen_begin_plain(s, gl);
    gl->Disable(GL_DEPTH_TEST);
    gl->Enable(GL_FRAMEBUFFER_SRGB);
    gl->UseProgram(d->light);
    gl->BindVertexArray(d->nothing);
    gl->Uniform4fv(d->lens, 1, lens);
    gl->UniformMatrix4fv(d->to_map, 1, GL_FALSE, to_map);
    gl->Uniform3fv(d->sun_direction, 1, direction);
    gl->Uniform3fv(d->sun, 1, d->frame->sun);
    gl->Uniform3fv(d->up, 1, eye_up);
    use_lamps(d);
    shadow_map_bind(&d->frame->shadows, gl);
    for (int i = 0; i <= DEFERRED_COLORS; ++i) {
        gl->ActiveTexture(GL_TEXTURE0 + unit_of(i));
        gl->BindTexture(GL_TEXTURE_2D, d->textures[i]);
    }
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

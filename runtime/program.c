/* SPDX-License-Identifier: MIT
 *
 * Shader programs. One source serves GL 3.3 core, GLES 3.0 and WebGL 2; they differ in the prelude.
 */
#include "program.h"
#include "shaders.h"

#include <stdio.h>

static const char prelude_gl[] = "#version 330 core\n";
static const char prelude_es[] = "#version 300 es\n"
                                 "precision highp float;\n"
                                 "precision highp int;\n"
                                 "precision highp sampler2D;\n";

static GLuint compile(const psplat_gl *gl, GLenum type, const char *defines, const char *library,
                      const char *body, psplat_error *error) {
    const GLchar *const sources[] = {gl->is_es ? prelude_es : prelude_gl, defines,
                                     psplat_shader_layout_h, library, body};
    GLuint shader = gl->CreateShader(type);
    GLint compiled = GL_FALSE;
    gl->ShaderSource(shader, sizeof sources / sizeof *sources, sources, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled) return shader;

    char log[200] = "";
    gl->GetShaderInfoLog(shader, sizeof log, NULL, log);
    psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "%s shader refused: %s",
                type == GL_VERTEX_SHADER ? "vertex" : "fragment", log);
    gl->DeleteShader(shader);
    return 0;
}

static GLuint link_shaders(const psplat_gl *gl, GLuint vertex, GLuint fragment,
                           psplat_error *error) {
    GLuint program = gl->CreateProgram();
    GLint linked = GL_FALSE;
    gl->AttachShader(program, vertex);
    gl->AttachShader(program, fragment);
    gl->LinkProgram(program);
    gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked) return program;

    char log[200] = "";
    gl->GetProgramInfoLog(program, sizeof log, NULL, log);
    psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "program refused: %s", log);
    gl->DeleteProgram(program);
    return 0;
}

GLuint psplat_program_build(const psplat_gl *gl, const char *defines, const char *vertex,
                            const char *library, const char *fragment, psplat_error *error) {
    GLuint first = compile(gl, GL_VERTEX_SHADER, defines, "", vertex, error);
    if (!first) return 0;
    GLuint second = compile(gl, GL_FRAGMENT_SHADER, defines, library, fragment, error);
    GLuint program = second ? link_shaders(gl, first, second, error) : 0;
    gl->DeleteShader(first);
    if (second) gl->DeleteShader(second);
    return program;
}

/* Units are constant, so they are set once. Makes the program current. */
static void find_uniforms(const psplat_gl *gl, psplat_program *program) {
    static const struct {
        const char *name;
        GLint unit;
    } samplers[] = {{"u_splats", PSPLAT_UNIT_SPLATS},
                    {"u_clips", PSPLAT_UNIT_CLIPS},
                    {"u_target0", 0},
                    {"u_target1", 1},
                    {"u_target2", 2},
                    {"u_target3", 3},
                    {"u_depth", PSPLAT_UNIT_DEPTH}};
#define PSPLAT_UNIFORM_FIND(name) program->name = gl->GetUniformLocation(program->id, "u_" #name);
    PSPLAT_UNIFORMS(PSPLAT_UNIFORM_FIND)
#undef PSPLAT_UNIFORM_FIND
    gl->UseProgram(program->id);
    for (size_t i = 0; i < sizeof samplers / sizeof *samplers; ++i)
        gl->Uniform1i(gl->GetUniformLocation(program->id, samplers[i].name), samplers[i].unit);
}

static const psplat_program *build(psplat_program *program, const psplat_gl *gl, int pass,
                                   uint32_t clip_count, unsigned options, const char *vertex,
                                   const char *fragment, psplat_error *error) {
    static const char *const clip_types[] = {"none", "float", "vec2", "vec3", "vec4"};
    char defines[400];
    /* Weights must stay above the least number of the targets. */
    snprintf(defines, sizeof defines,
             "#define PASS %d\n#define CLIP_COUNT %d\n#define CLIP_TYPE %s\n#define COLOR %d\n"
             "#define GAMMA %d\n#define MATERIALS %d\n#define NEAR %d\n#define POWER %d\n"
             "#define WEIGHT_FLOOR %s\n#define HALF_TARGETS %d\n",
             pass, (int)clip_count, clip_types[clip_count], !!(options & PSPLAT_OPTION_COLOR),
             !!(options & PSPLAT_OPTION_GAMMA), !!(options & PSPLAT_OPTION_MATERIALS),
             !!(options & PSPLAT_OPTION_NEAR), !!(options & PSPLAT_OPTION_POWER),
             gl->half_targets ? "1e-3" : "1e-30", gl->half_targets);
    program->id =
        psplat_program_build(gl, defines, vertex, psplat_shader_shading_glsl, fragment, error);
    if (!program->id) return NULL;
    find_uniforms(gl, program);
    return program;
}

const psplat_program *psplat_programs_splat(psplat_programs *programs, const psplat_gl *gl,
                                            int pass, uint32_t clip_count, unsigned options,
                                            psplat_error *error) {
    psplat_program *program = &programs->splat[pass][clip_count][options];
    if (program->id) return program;
    return build(program, gl, pass, clip_count, options, psplat_shader_splat_vert,
                 psplat_shader_splat_frag, error);
}

const psplat_program *psplat_programs_resolve(psplat_programs *programs, const psplat_gl *gl,
                                              int pass, unsigned options, psplat_error *error) {
    psplat_program *program = &programs->resolve[pass][!!(options & PSPLAT_OPTION_MATERIALS)];
    if (program->id) return program;
    return build(program, gl, pass, 0, options & PSPLAT_OPTION_MATERIALS,
                 psplat_shader_resolve_vert, psplat_shader_resolve_frag, error);
}

void psplat_programs_destroy(psplat_programs *programs, const psplat_gl *gl) {
    for (int pass = 0; pass < PSPLAT_PASS_COUNT; ++pass) {
        for (int clip = 0; clip <= PSPLAT_MAX_CLIP_LINES; ++clip)
            for (int set = 0; set < PSPLAT_OPTION_SETS; ++set)
                gl->DeleteProgram(programs->splat[pass][clip][set].id);
        for (int set = 0; set < 2; ++set) gl->DeleteProgram(programs->resolve[pass][set].id);
    }
}

/* SPDX-License-Identifier: MIT
 *
 * gl_program.c - compiles, links and keeps shader programs. GL 3.3 core, GLES 3.0 and WebGL 2 share
 * one source; only the prelude differs.
 */
#include "gl/gl_program.h"
#include "core/memory.h"
#include "shaders.h"

#include <stdio.h>
#include <string.h>

/* With depth that is said to be no less than a primitive's, GPUs keep their early depth test. */
#define CONSERVATIVE_DEPTH(name)                                                                   \
    "#ifdef GL_" name "_conservative_depth\n"                                                      \
    "#extension GL_" name "_conservative_depth : enable\n"                                         \
    "#endif\n"

static const char prelude_gl[] = "#version 330 core\n" CONSERVATIVE_DEPTH("ARB");
static const char prelude_es[] =
    "#version 300 es\n" CONSERVATIVE_DEPTH("EXT") "precision highp float;\n"
                                                  "precision highp int;\n"
                                                  "precision highp sampler2D;\n";

/* ---- shadings ---------------------------------------------------------------------------- */

enum { READS_NOTHING, READS_COLOR, READS_LIGHT };

#define DECLARE(name, file, reads) extern const char psplat_shader_resolve_##file##_glsl[];
PSPLAT_SHADINGS(DECLARE)
#undef DECLARE

static const struct {
    const char *source;
    int reads;
} shadings[PSPLAT_SHADING_COUNT] = {
#define SHADING(name, file, reads) {psplat_shader_resolve_##file##_glsl, READS_##reads},
    PSPLAT_SHADINGS(SHADING)
#undef SHADING
};

int psplat_shading_reads_color(int shading) {
    return shadings[shading].reads >= READS_COLOR;
}

int psplat_shading_reads_light(int shading) {
    return shadings[shading].reads == READS_LIGHT;
}

/* ---- keys -------------------------------------------------------------------------------- */

/* Returns the options of textures that a splat pass uses: of those of the material the ones whose
 * targets are there, and where splats may be masked the texture with their alphas. A shading that
 * shows neither light nor normals does without those of normals, and so do modes that light splats
 * with the normal of their centre (spec 5.7). */
static unsigned used_textures(const psplat_program_key *key) {
    unsigned given = key->options, used = 0;
    if (given & PSPLAT_OPTION_MASK) used |= PSPLAT_OPTION_MASK | PSPLAT_OPTION_BASE_MAP;
    if (key->pass == PSPLAT_PASS_RADIANCE)
        used |= PSPLAT_OPTIONS_MAPS & ~(unsigned)PSPLAT_OPTION_NORMAL_MAP;
    if (key->pass == PSPLAT_PASS_NORMALS) {
        if (given & PSPLAT_OPTIONS_TARGETS) used |= PSPLAT_OPTION_BASE_MAP;
        if (given & (PSPLAT_OPTION_MATERIALS | PSPLAT_OPTION_OCCLUSION | PSPLAT_OPTION_EMISSIVE))
            used |= PSPLAT_OPTION_SURFACE_MAP;
        if (given & PSPLAT_OPTION_EMISSIVE) used |= PSPLAT_OPTION_EMISSIVE_MAP;
        if (given & PSPLAT_OPTION_OCCLUSION) used |= PSPLAT_OPTION_OCCLUSION_MAP;
        int shows_normals =
            psplat_shading_reads_light(key->shading) || key->shading == PSPLAT_SHADING_NORMAL;
        if (shows_normals && given & PSPLAT_OPTION_FIELD) used |= PSPLAT_OPTION_NORMAL_MAP;
    }
    if (given & used & PSPLAT_OPTIONS_MAPS) used |= PSPLAT_OPTION_MAP_TRANSFORM;
    return given & used ? used | PSPLAT_OPTION_TEXCOORD_BEND : 0;
}

/* Returns the options that a splat pass uses. Curved splats are cut and turned fragment by
 * fragment in every pass, and not filtered (spec 5.8). */
static unsigned used_by_splats(const psplat_program_key *key) {
    unsigned used = PSPLAT_OPTION_WIDE | PSPLAT_OPTION_SHAPE | used_textures(key);
    if (key->clip_count > 0) used |= PSPLAT_OPTION_BENDS;
    if (key->options & PSPLAT_OPTION_CURVED)
        used |= PSPLAT_OPTION_CURVED | PSPLAT_OPTION_TWO_SIDED | PSPLAT_OPTION_GAMMA;
    else
        used |= PSPLAT_OPTION_TANGENT;
    if (key->pass == PSPLAT_PASS_VISIBILITY)
        return key->options & PSPLAT_OPTION_CURVED ? used : used | PSPLAT_OPTION_NEAR;
    if (key->pass == PSPLAT_PASS_PARAMETERS) return used;
    used |= PSPLAT_OPTION_TWO_SIDED | PSPLAT_OPTION_POWER;
    /* The field tells backs from splats that peek out behind a contour (spec 5.2). */
    if (key->options & PSPLAT_OPTION_TWO_SIDED) used |= PSPLAT_OPTION_GAMMA;
    if (!(key->options & PSPLAT_OPTION_CURVED)) used |= PSPLAT_OPTION_FILTER;
    const unsigned colors = PSPLAT_OPTION_COLOR | PSPLAT_OPTION_FINISH;
    if (key->pass == PSPLAT_PASS_RADIANCE) return used | colors | PSPLAT_OPTIONS_LIGHT;
    used |= PSPLAT_OPTION_FIELD | PSPLAT_OPTION_GAMMA | PSPLAT_OPTION_COUNT;
    if (key->options & PSPLAT_OPTIONS_TARGETS) used |= colors;
    return used | PSPLAT_OPTIONS_TARGETS;
}

/* Returns the options that the resolve pass uses. */
static unsigned used_by_resolve(const psplat_program_key *key) {
    unsigned used = PSPLAT_OPTION_ENCODE | PSPLAT_OPTION_AS_IS;
    if (key->options & PSPLAT_OPTION_AS_IS) return used;
    if (psplat_shading_reads_color(key->shading)) used |= PSPLAT_OPTIONS_TARGETS;
    if (psplat_shading_reads_light(key->shading)) used |= PSPLAT_OPTIONS_LIGHT;
    return used;
}

/* Adds options that others imply, and removes those that have no effect beside others. */
static unsigned normalise_options(unsigned options) {
    int is_field = options & PSPLAT_OPTION_CURVED ? !(options & PSPLAT_OPTION_SHAPE)
                                                  : (options & PSPLAT_OPTION_TWO_SIDED) != 0;
    if (options & PSPLAT_OPTION_SHAPE) options &= ~(unsigned)PSPLAT_OPTION_TANGENT;
    if (!(options & PSPLAT_OPTION_FIELD) && !is_field) options &= ~(unsigned)PSPLAT_OPTION_GAMMA;
    if (options & PSPLAT_OPTION_COUNT) options &= ~(unsigned)PSPLAT_OPTION_POWER;
    if (options & PSPLAT_OPTION_FINISH && options & PSPLAT_OPTION_COLOR)
        options = (options & ~(unsigned)PSPLAT_OPTION_COLOR) | PSPLAT_OPTION_WIDE;
    if (options & (PSPLAT_OPTION_OCCLUSION | PSPLAT_OPTION_EMISSIVE))
        options |= PSPLAT_OPTION_MATERIALS;
    if (options & PSPLAT_OPTION_MATERIALS) options |= PSPLAT_OPTION_COLORS;
    if (options & (PSPLAT_OPTION_COLOR | PSPLAT_OPTION_GAMMA)) options |= PSPLAT_OPTION_WIDE;
    return options;
}

int psplat_program_has_seams(const psplat_program_key *key) {
    int is_weighted = key->pass == PSPLAT_PASS_RADIANCE ||
                      (key->pass == PSPLAT_PASS_NORMALS && !(key->options & PSPLAT_OPTION_COUNT));
    return !key->is_resolve && key->seam_count > 0 && is_weighted;
}

/* Sets what follows from the numbers of lines: splats that nothing cuts have no seams, and where
 * all lines are seams a pass without weights knows of no line. */
static void reduce_lines(psplat_program_key *key) {
    if (key->is_resolve || !(key->options & PSPLAT_OPTION_CURVED)) key->part = PSPLAT_PART_ALL;
    if (key->is_resolve) key->pass = key->clip_count = 0;
    if (key->is_resolve || key->part == PSPLAT_PART_UNCUT) key->seam_count = 0;
    if (key->part == PSPLAT_PART_ALL && key->seam_count == key->clip_count &&
        !psplat_program_has_seams(key))
        key->clip_count = key->seam_count = 0;
    if (key->options & PSPLAT_OPTION_CURVED || key->clip_count == key->seam_count)
        key->is_boxed = 0;
}

psplat_program_key psplat_program_key_reduce(psplat_program_key key) {
    reduce_lines(&key);
    key.options &= key.is_resolve ? used_by_resolve(&key) : used_by_splats(&key);
    key.options = normalise_options(key.options);
    int shades = key.is_resolve ? !(key.options & PSPLAT_OPTION_AS_IS) &&
                                      psplat_shading_reads_light(key.shading)
                                : key.pass == PSPLAT_PASS_RADIANCE;
    if (!shades || key.light_count == 0) {
        key.light_count = 0;
        key.options &= ~(unsigned)(PSPLAT_OPTION_PUNCTUAL | PSPLAT_OPTION_SHADOWS);
    }
    if (!key.is_resolve || key.options & PSPLAT_OPTION_AS_IS) key.shading = 0, key.host = 0;
    if (key.is_resolve || key.options & PSPLAT_OPTION_COUNT ||
        (key.pass != PSPLAT_PASS_NORMALS && key.pass != PSPLAT_PASS_RADIANCE))
        key.is_faded = 0;
    return key;
}

static int is_same_key(const psplat_program_key *a, const psplat_program_key *b) {
    return a->options == b->options && a->is_resolve == b->is_resolve && a->pass == b->pass &&
           a->clip_count == b->clip_count && a->seam_count == b->seam_count &&
           a->is_faded == b->is_faded && a->part == b->part && a->is_boxed == b->is_boxed &&
           a->shading == b->shading && a->light_count == b->light_count && a->host == b->host;
}

/* ---- building ---------------------------------------------------------------------------- */

static GLuint compile(const psplat_gl *gl, GLenum type, const char *defines,
                      const char *const parts[PSPLAT_MAX_SHADER_PARTS], psplat_error *error) {
    enum { HEAD = 3 };
    const GLchar *sources[HEAD + PSPLAT_MAX_SHADER_PARTS] = {gl->is_es ? prelude_es : prelude_gl,
                                                             defines, psplat_shader_layout_h};
    GLsizei count = HEAD;
    for (int i = 0; i < PSPLAT_MAX_SHADER_PARTS && parts[i]; ++i) sources[count++] = parts[i];
    GLuint shader = gl->CreateShader(type);
    GLint compiled = GL_FALSE;
    gl->ShaderSource(shader, count, sources, NULL);
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

GLuint psplat_program_build(const psplat_gl *gl, const psplat_program_source *source,
                            psplat_error *error) {
    GLuint first = compile(gl, GL_VERTEX_SHADER, source->defines, source->vertex, error);
    if (!first) return 0;
    GLuint second = compile(gl, GL_FRAGMENT_SHADER, source->defines, source->fragment, error);
    GLuint program = second ? link_shaders(gl, first, second, error) : 0;
    gl->DeleteShader(first);
    if (second) gl->DeleteShader(second);
    return program;
}

/* Finds the locations of uniforms and sets those of samplers, whose texture units never change.
 * Makes the program current. */
static void find_uniforms(const psplat_gl *gl, psplat_program *program) {
    static const struct {
        const char *name;
        GLint unit;
    } samplers[] = {{"u_splats", PSPLAT_UNIT_SPLATS},
                    {"u_clips", PSPLAT_UNIT_CLIPS},
                    {"u_finishes", PSPLAT_UNIT_FINISHES},
                    {"u_texcoords", PSPLAT_UNIT_TEXCOORDS},
                    {"u_base_map", PSPLAT_UNIT_MAPS},
                    {"u_surface_map", PSPLAT_UNIT_MAPS + 1},
                    {"u_normal_map", PSPLAT_UNIT_MAPS + 2},
                    {"u_occlusion_map", PSPLAT_UNIT_MAPS + 3},
                    {"u_emissive_map", PSPLAT_UNIT_MAPS + 4},
                    {"u_target0", 0},
                    {"u_target1", 1},
                    {"u_target2", 2},
                    {"u_target3", 3},
                    {"u_depth", PSPLAT_UNIT_DEPTH},
                    {"u_shadows", PSPLAT_UNIT_SHADOWS},
                    {"u_diffuse", PSPLAT_UNIT_DIFFUSE},
                    {"u_glossy", PSPLAT_UNIT_GLOSSY},
                    {"u_split_sum", PSPLAT_UNIT_SPLIT_SUM}};
#define PSPLAT_UNIFORM_FIND(name) program->name = gl->GetUniformLocation(program->id, "u_" #name);
    PSPLAT_UNIFORMS(PSPLAT_UNIFORM_FIND)
#undef PSPLAT_UNIFORM_FIND
    gl->UseProgram(program->id);
    for (size_t i = 0; i < sizeof samplers / sizeof *samplers; ++i)
        gl->Uniform1i(gl->GetUniformLocation(program->id, samplers[i].name), samplers[i].unit);
}

/* Writes the macros of a variant, terminated by a zero. */
static void write_defines(const psplat_gl *gl, const psplat_program_key *key, char *out,
                          size_t size) {
    static const char *const clip_types[] = {"none", "float", "vec2", "vec3", "vec4"};
    static const struct {
        const char *name;
        unsigned option;
    } options[] = {
#define OPTION(name, value) {#name, value},
        PSPLAT_OPTIONS(OPTION)
#undef OPTION
    };
    /* A splat has LINE_COUNT lines, of which fragments know CLIP_COUNT; the last are seams. */
    int seam_count = psplat_program_has_seams(key) ? key->seam_count : 0;
    int clip_count = key->clip_count - key->seam_count + seam_count;
    if (key->part == PSPLAT_PART_UNCUT) clip_count = 0;
    /* Weights must stay above the least positive number that the targets can hold. */
    int used =
        snprintf(out, size,
                 "#define PASS %d\n#define CLIP_COUNT %d\n#define CLIP_TYPE %s\n"
                 "#define PART %d\n#define LINE_COUNT %d\n#define SEAM_COUNT %d\n"
                 "#define LINE_TYPE %s\n#define LIGHT_COUNT %d\n#define WEIGHT_FLOOR %s\n"
                 "#define HALF_TARGETS %d\n#define TEXTURED %d\n#define FADE %d\n#define BOX %d\n"
                 "#define INSTANCED\n",
                 key->pass, clip_count, clip_types[clip_count], key->part, key->clip_count,
                 seam_count, key->options & PSPLAT_OPTION_BENDS ? "vec4" : "vec3", key->light_count,
                 gl->half_targets ? "1e-3" : "1e-30", gl->half_targets,
                 !!(key->options & PSPLAT_OPTIONS_TEXTURED), key->is_faded, key->is_boxed);
    for (size_t i = 0; i < sizeof options / sizeof *options; ++i)
        used += snprintf(out + used, size - (size_t)used, "#define %s %d\n", options[i].name,
                         !!(key->options & options[i].option));
}

/* Adds the macros of a host's resolve function. They are not defined where there is none. */
static void add_host_defines(const psplat_host_source *host, char *defines, size_t size) {
    size_t used = strlen(defines);
    snprintf(defines + used, size - used, "#define HOST_RESOLVE 1\n%s",
             host->filters_light ? "#define HOST_LIGHT 1\n" : "");
}

/* Puts the shaders of a splat pass together. */
static psplat_program_source splat_source(const psplat_program_key *key, const char *defines) {
    psplat_program_source source = {.defines = defines};
    const char **vertex = source.vertex, **fragment = source.fragment;
    int is_curved = !!(key->options & PSPLAT_OPTION_CURVED);
    *vertex++ = *fragment++ = psplat_shader_texels_glsl;
    *vertex++ = psplat_shader_splat_data_glsl;
    *vertex++ = psplat_shader_shift_glsl;
    *vertex = is_curved ? psplat_shader_curved_vert : psplat_shader_splat_vert;
    if (key->pass == PSPLAT_PASS_RADIANCE) *fragment++ = psplat_shader_shading_glsl;
    if (key->options & PSPLAT_OPTIONS_TEXTURED) *fragment++ = psplat_shader_maps_glsl;
    *fragment++ = psplat_shader_sums_glsl;
    *fragment = is_curved ? psplat_shader_curved_frag : psplat_shader_splat_frag;
    return source;
}

static psplat_program_source resolve_source(const psplat_program_key *key, const char *defines) {
    int is_shaded = !(key->options & PSPLAT_OPTION_AS_IS);
    return (psplat_program_source){
        .defines = defines,
        .vertex = {psplat_shader_resolve_vert},
        .fragment = {psplat_shader_resolve_inputs_glsl, psplat_shader_shading_glsl,
                     psplat_shader_resolve_frag, is_shaded ? shadings[key->shading].source : NULL}};
}

/* Lines of the host's text are counted from 1, as its compiler's messages name them. */
static psplat_program_source host_source(const psplat_host_source *host, const char *defines) {
    return (psplat_program_source){
        .defines = defines,
        .vertex = {psplat_shader_resolve_vert},
        .fragment = {psplat_shader_resolve_inputs_glsl, psplat_shader_shading_glsl,
                     psplat_shader_resolve_frag, "#line 1\n", host->text}};
}

static int build(const psplat_programs *programs, const psplat_gl *gl, psplat_program *program,
                 psplat_error *error) {
    const psplat_program_key *key = &program->key;
    char defines[1500];
    write_defines(gl, key, defines, sizeof defines);
    psplat_program_source source;
    if (key->host) {
        const psplat_host_source *host = psplat_host_sources_get(&programs->hosts, key->host);
        add_host_defines(host, defines, sizeof defines);
        source = host_source(host, defines);
    } else {
        source = key->is_resolve ? resolve_source(key, defines) : splat_source(key, defines);
    }
    program->id = psplat_program_build(gl, &source, error);
    if (program->id) find_uniforms(gl, program);
    return program->id != 0;
}

/* ---- the list ---------------------------------------------------------------------------- */

/* Makes room for one more program. Returns 0 where memory runs out. */
static int reserve(psplat_programs *programs, const psplat_allocator *allocator) {
    if (programs->count < programs->capacity) return 1;
    size_t capacity = programs->capacity ? 2 * programs->capacity : 8;
    psplat_program *list = psplat_resize(
        allocator, programs->list, programs->capacity * sizeof *list, capacity * sizeof *list);
    if (!list) return 0;
    programs->list = list;
    programs->capacity = capacity;
    return 1;
}

psplat_result psplat_programs_find(psplat_programs *programs, const psplat_gl *gl,
                                   const psplat_allocator *allocator, psplat_program_key key,
                                   const psplat_program **program, psplat_error *error) {
    key = psplat_program_key_reduce(key);
    for (size_t i = 0; i < programs->count; ++i) {
        *program = &programs->list[i];
        if (!is_same_key(&programs->list[i].key, &key)) continue;
        programs->list[i].is_new = 0;
        return PSPLAT_OK;
    }
    if (!reserve(programs, allocator))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for another program");
    psplat_program *made = &programs->list[programs->count];
    memset(made, 0, sizeof *made);
    made->key = key;
    made->is_new = 1;
    if (!build(programs, gl, made, error)) return PSPLAT_ERROR_GRAPHICS;
    ++programs->count;
    *program = made;
    return PSPLAT_OK;
}

/* Deletes the programs of a host's resolve function. */
static void drop_host(psplat_programs *programs, const psplat_gl *gl, unsigned number) {
    size_t kept = 0;
    for (size_t i = 0; i < programs->count; ++i) {
        if (programs->list[i].key.host == number)
            gl->DeleteProgram(programs->list[i].id);
        else
            programs->list[kept++] = programs->list[i];
    }
    programs->count = kept;
}

psplat_result psplat_programs_find_host(psplat_programs *programs, const psplat_gl *gl,
                                        const psplat_allocator *allocator,
                                        const psplat_resolve *resolve, unsigned *number,
                                        psplat_error *error) {
    unsigned dropped = 0;
    const psplat_host_source *host =
        psplat_host_sources_find(&programs->hosts, allocator, resolve, &dropped);
    if (!host)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a resolve function");
    if (dropped) drop_host(programs, gl, dropped);
    *number = host->number;
    return PSPLAT_OK;
}

void psplat_programs_destroy(psplat_programs *programs, const psplat_gl *gl,
                             const psplat_allocator *allocator) {
    for (size_t i = 0; i < programs->count; ++i) gl->DeleteProgram(programs->list[i].id);
    if (programs->list)
        psplat_resize(allocator, programs->list, programs->capacity * sizeof *programs->list, 0);
    psplat_host_sources_free(&programs->hosts, allocator);
    memset(programs, 0, sizeof *programs);
}

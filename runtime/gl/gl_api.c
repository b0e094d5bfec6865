/* SPDX-License-Identifier: MIT
 *
 * gl_api.c - loads GL functions from the host's loader and checks the context. A context that lacks
 * something is refused here with the name of what is missing, so that nothing crashes later.
 */
#include "gl/gl_api.h"

#include <string.h>

/* Loads one function. ISO C has no cast from object to function pointers, but every platform with
 * such a loader represents both in the same way, so the bytes are copied. */
static int load(void *function, size_t size, void *(*get_proc)(void *user, const char *name),
                void *user, const char *name) {
    void *address = get_proc(user, name);
    memcpy(function, &address, size);
    return address != NULL;
}

static psplat_result load_functions(psplat_gl *gl, void *(*get_proc)(void *, const char *),
                                    void *user, psplat_error *error) {
#define PSPLAT_GL_LOAD(type, name, parameters)                                                     \
    if (!load(&gl->name, sizeof gl->name, get_proc, user, "gl" #name))                             \
        return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "the loader has no GL function gl%s",  \
                           #name);
    PSPLAT_GL_FUNCTIONS(PSPLAT_GL_LOAD)
#undef PSPLAT_GL_LOAD
    return PSPLAT_OK;
}

int psplat_gl_has_extension(const psplat_gl *gl, const char *name) {
    GLint count = 0;
    gl->GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; ++i) {
        const GLubyte *extension = gl->GetStringi(GL_EXTENSIONS, (GLuint)i);
        if (extension && strcmp((const char *)extension, name) == 0) return 1;
    }
    return 0;
}

static psplat_result check_version(psplat_gl *gl, psplat_error *error) {
    const char *version = (const char *)gl->GetString(GL_VERSION);
    if (!version) return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "no GL context is current");
    /* "OpenGL ES 3.2 ..." on GLES and WebGL, "3.3 ..." on GL. */
    gl->is_es = strncmp(version, "OpenGL ES", 9) == 0;
    gl->GetIntegerv(GL_MAJOR_VERSION, &gl->major);
    gl->GetIntegerv(GL_MINOR_VERSION, &gl->minor);
    int have = gl->major * 10 + gl->minor;
    if (have < (gl->is_es ? 30 : 33))
        return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "GL 3.3 or GLES 3.0 is needed, not %s",
                           version);
    return PSPLAT_OK;
}

/* Checks that floats can be drawn to and blended. GL 3.3 does so with 32 bits; GLES needs two
 * extensions for 32 bits and one for 16 bits. */
static psplat_result check_targets(psplat_gl *gl, psplat_error *error) {
    if (!gl->is_es) return PSPLAT_OK;
    int full = gl->major * 10 + gl->minor >= 32 ||
               psplat_gl_has_extension(gl, "GL_EXT_color_buffer_float");
    int half = full || psplat_gl_has_extension(gl, "GL_EXT_color_buffer_half_float");
    if (!half)
        return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0,
                           "float targets are needed: neither GL_EXT_color_buffer_float nor "
                           "GL_EXT_color_buffer_half_float");
    gl->half_targets = !full || !psplat_gl_has_extension(gl, "GL_EXT_float_blend");
    return PSPLAT_OK;
}

/* Returns the name of glGetGraphicsResetStatus in this context, or NULL. Loaders may return an
 * address for any name, so version and extensions decide. */
static const char *reset_status_name(const psplat_gl *gl) {
    if (gl->major * 10 + gl->minor >= (gl->is_es ? 32 : 45)) return "glGetGraphicsResetStatus";
    if (psplat_gl_has_extension(gl, "GL_KHR_robustness"))
        return gl->is_es ? "glGetGraphicsResetStatusKHR" : "glGetGraphicsResetStatus";
    if (psplat_gl_has_extension(gl, "GL_ARB_robustness")) return "glGetGraphicsResetStatusARB";
    if (psplat_gl_has_extension(gl, "GL_EXT_robustness")) return "glGetGraphicsResetStatusEXT";
    return NULL;
}

static int may_invalidate(const psplat_gl *gl) {
    return gl->is_es || gl->major * 10 + gl->minor >= 43 ||
           psplat_gl_has_extension(gl, "GL_ARB_invalidate_subdata");
}

/* Returns whether a context is that of Mesa's software rasteriser. */
static int is_software(const psplat_gl *gl) {
    const char *renderer = (const char *)gl->GetString(GL_RENDERER);
    return renderer && (!strncmp(renderer, "llvmpipe", 8) || !strncmp(renderer, "softpipe", 8));
}

/* Returns by how much longer than wide the part of an image may be that a sampler averages. WebGL
 * and GLES have an extension for that, GL too before 4.6. Mesa's software rasteriser (22.3) has it
 * too, but visits all texels of a long ellipse one by one, takes seconds for a frame, and with
 * gradients blurs magnified images and crashes on images of one texel. */
static GLint find_anisotropy(const psplat_gl *gl) {
    GLfloat most = 1.0f;
    if (is_software(gl)) return 1;
    if ((!gl->is_es && gl->major * 10 + gl->minor >= 46) ||
        psplat_gl_has_extension(gl, "GL_EXT_texture_filter_anisotropic") ||
        psplat_gl_has_extension(gl, "GL_ARB_texture_filter_anisotropic"))
        gl->GetFloatv(GL_MAX_TEXTURE_MAX_ANISOTROPY, &most);
    return most >= 1.0f ? (GLint)most : 1;
}

psplat_result psplat_gl_load(psplat_gl *gl, void *(*get_proc)(void *user, const char *name),
                             void *user, psplat_error *error) {
    memset(gl, 0, sizeof *gl);
    psplat_result result = load_functions(gl, get_proc, user, error);
    if (result == PSPLAT_OK) result = check_version(gl, error);
    if (result == PSPLAT_OK) result = check_targets(gl, error);
    if (result != PSPLAT_OK) return result;
    if (!gl->is_es &&
        !load(&gl->PolygonMode, sizeof gl->PolygonMode, get_proc, user, "glPolygonMode"))
        return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0,
                           "the loader has no GL function glPolygonMode");
    const char *name = reset_status_name(gl);
    if (name)
        load(&gl->GetGraphicsResetStatus, sizeof gl->GetGraphicsResetStatus, get_proc, user, name);
    if (may_invalidate(gl))
        load(&gl->InvalidateFramebuffer, sizeof gl->InvalidateFramebuffer, get_proc, user,
             "glInvalidateFramebuffer");
    gl->GetIntegerv(GL_MAX_TEXTURE_SIZE, &gl->max_texture_size);
    if (gl->max_texture_size < 1)
        return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "the GL context is lost");
    gl->max_anisotropy = find_anisotropy(gl);
    return PSPLAT_OK;
}

static void PSPLAT_GL_CALL keep_object(GLuint name) {
    (void)name;
}

static void PSPLAT_GL_CALL keep_objects(GLsizei count, const GLuint *names) {
    (void)count;
    (void)names;
}

/* Notes that the context is lost, and replaces the functions that delete objects. */
static void lose(psplat_gl *gl) {
    gl->is_lost = 1;
    gl->DeleteProgram = keep_object;
    gl->DeleteShader = keep_object;
    gl->DeleteBuffers = keep_objects;
    gl->DeleteFramebuffers = keep_objects;
    gl->DeleteSamplers = keep_objects;
    gl->DeleteTextures = keep_objects;
    gl->DeleteVertexArrays = keep_objects;
}

/* GL has at most one flag for each kind of error, of which GL 4.6 has six, so 16 reads clear them
 * all. */
psplat_result psplat_gl_errors(psplat_gl *gl, psplat_error *error) {
    int is_full = 0, is_lost = 0;
    for (int i = 0; i < 16; ++i) {
        GLenum flag = gl->GetError();
        if (flag == GL_NO_ERROR) break;
        if (flag == GL_OUT_OF_MEMORY) is_full = 1;
        if (flag == GL_CONTEXT_LOST || flag == GL_CONTEXT_LOST_WEBGL) is_lost = 1;
    }
    if (is_lost) lose(gl); /* some contexts report the loss only once */
    if (is_lost) return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "the GL context is lost");
    if (is_full) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "GL is out of memory");
    return PSPLAT_OK;
}

psplat_result psplat_gl_finish(psplat_gl *gl, psplat_result result, psplat_error *error) {
    if (!gl->is_lost && gl->GetGraphicsResetStatus && gl->GetGraphicsResetStatus() != GL_NO_ERROR)
        lose(gl);
    if (!gl->is_lost && result != PSPLAT_OK) psplat_gl_errors(gl, NULL);
    if (!gl->is_lost) return result;
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "the GL context is lost");
}

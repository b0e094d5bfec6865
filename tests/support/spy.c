/* SPDX-License-Identifier: MIT
 *
 * spy.c - the watching loader; see spy.h.
 */
#include "spy.h"

#include <GL/glcorearb.h>
#include <stdio.h>
#include <string.h>

/* These are missing in the headers of GLES. */
enum {
    SPY_GL_POLYGON_MODE = 0x0B40,
    SPY_GL_CONTEXT_LOST = 0x0507,
    SPY_GL_UNKNOWN_CONTEXT_RESET = 0x8255
};

enum { QUERY_INTEGER, QUERY_CAPABILITY, QUERY_TEXTURE, QUERY_SAMPLER };

/* ---- functions ------------------------------------------------------------------------------ */

/* The rows of spy_calls.h are expanded once for the functions' names ... */
#define SPY_VOID(name, parameters, arguments, before) FUNCTION_##name,
#define SPY_VALUE(type, none, name, parameters, arguments) FUNCTION_##name,
#define SPY_GEN(kind, name) FUNCTION_##name,
#define SPY_DELETE(kind, name) FUNCTION_##name,
#define SPY_OTHER(type, name, parameters) FUNCTION_##name,
enum {
#include "spy_calls.h"
    FUNCTION_COUNT
};
#undef SPY_VOID
#undef SPY_VALUE
#undef SPY_GEN
#undef SPY_DELETE
#undef SPY_OTHER
_Static_assert((int)FUNCTION_COUNT <= (int)SPY_FUNCTION_MAX, "spy.h holds all functions");

/* The spy is a thread's global, because GL functions have no argument that could name it. */
static _Thread_local spy *active;

/* ... and once for pointers to the real functions: real_Enable()(GL_BLEND). */
#define REAL(type, name, parameters)                                                               \
    typedef type(APIENTRY *type_##name) parameters;                                                \
    static inline type_##name real_##name(void) {                                                  \
        return (type_##name)active->real[FUNCTION_##name];                                         \
    }
#define SPY_VOID(name, parameters, arguments, before) REAL(void, name, parameters)
#define SPY_VALUE(type, none, name, parameters, arguments) REAL(type, name, parameters)
#define SPY_GEN(kind, name) REAL(void, name, (GLsizei count, GLuint * names))
#define SPY_DELETE(kind, name) REAL(void, name, (GLsizei count, const GLuint *names))
#define SPY_OTHER(type, name, parameters) REAL(type, name, parameters)
#include "spy_calls.h"
#undef SPY_VOID
#undef SPY_VALUE
#undef SPY_GEN
#undef SPY_DELETE
#undef SPY_OTHER

/* ---- what is watched ------------------------------------------------------------------------ */

static void trouble(const char *call, const char *text, unsigned number) {
    if (active->trouble[0]) return;
    snprintf(active->trouble, sizeof active->trouble, "gl%s: %s 0x%x", call, text, number);
}

static void read_value(const spy_touch *touch, int value[4]) {
    int unit = 0;
    memset(value, 0, 4 * sizeof *value);
    if (touch->query == QUERY_CAPABILITY) {
        value[0] = real_IsEnabled()(touch->name);
        return;
    }
    real_GetIntegerv()(GL_ACTIVE_TEXTURE, &unit);
    if (touch->query != QUERY_INTEGER) real_ActiveTexture()(touch->unit);
    real_GetIntegerv()(touch->name, value);
    if (touch->query != QUERY_INTEGER) real_ActiveTexture()((GLenum)unit);
}

static void touch(const char *call, unsigned query, GLenum name, unsigned unit) {
    for (int i = 0; i < active->touched_count; ++i) {
        const spy_touch *old = &active->touched[i];
        if (old->query == query && old->name == name && old->unit == unit) return;
    }
    if (active->touched_count == SPY_TOUCH_MAX) {
        trouble(call, "no room to remember state", name);
        return;
    }
    spy_touch *made = &active->touched[active->touched_count++];
    *made = (spy_touch){.call = call, .query = query, .name = name, .unit = unit};
    read_value(made, made->value);
}

static GLenum texture_binding(GLenum target) {
    return target == GL_TEXTURE_2D   ? GL_TEXTURE_BINDING_2D
           : target == GL_TEXTURE_3D ? GL_TEXTURE_BINDING_3D
           : target >= GL_TEXTURE_CUBE_MAP && target <= GL_TEXTURE_CUBE_MAP_NEGATIVE_Z
               ? GL_TEXTURE_BINDING_CUBE_MAP
               : 0;
}

static GLenum buffer_binding(GLenum target) {
    return target == GL_PIXEL_UNPACK_BUFFER ? GL_PIXEL_UNPACK_BUFFER_BINDING
           : target == GL_PIXEL_PACK_BUFFER ? GL_PIXEL_PACK_BUFFER_BINDING
           : target == GL_UNIFORM_BUFFER    ? GL_UNIFORM_BUFFER_BINDING
           : target == GL_ARRAY_BUFFER      ? GL_ARRAY_BUFFER_BINDING
                                            : 0;
}

static void touch_integer(const char *call, GLenum name) {
    if (!name) trouble(call, "sets state that no query is known for", name);
    touch(call, QUERY_INTEGER, name, 0);
}

static void touch_framebuffer(const char *call, GLenum target) {
    if (target != GL_READ_FRAMEBUFFER) touch_integer(call, GL_DRAW_FRAMEBUFFER_BINDING);
    if (target != GL_DRAW_FRAMEBUFFER) touch_integer(call, GL_READ_FRAMEBUFFER_BINDING);
}

static void touch_texture(const char *call, GLenum target) {
    int unit = 0;
    real_GetIntegerv()(GL_ACTIVE_TEXTURE, &unit);
    if (!texture_binding(target)) trouble(call, "binds to a target without a query", target);
    touch(call, QUERY_TEXTURE, texture_binding(target), (unsigned)unit);
}

static void must_own(const char *call, spy_object kind, GLuint name) {
    if (name >= SPY_NAME_MAX || !active->owned[kind][name])
        trouble(call, "changes an object that is not the runtime's:", name);
}

static void must_own_bound(const char *call, spy_object kind, GLenum binding) {
    int name = 0;
    real_GetIntegerv()(binding, &name);
    must_own(call, kind, (GLuint)name);
}

/* For capabilities of GL that pictures of software rasterisers do not show. */
static void must_be_off(const char *call, GLenum capability) {
    const char *version = (const char *)real_GetString()(GL_VERSION);
    int is_es = version && strncmp(version, "OpenGL ES", 9) == 0;
    if (!is_es && real_IsEnabled()(capability)) trouble(call, "draws with capability", capability);
}

static void born(spy_object kind, GLuint name) {
    if (name == 0) return;
    if (name >= SPY_NAME_MAX) {
        trouble("Gen", "made an object whose name is too large for the spy:", name);
        return;
    }
    active->owned[kind][name] = 1;
    ++active->live[kind];
    ++active->made;
}

static void died(const char *call, spy_object kind, GLuint name) {
    if (name == 0) return;
    must_own(call, kind, name);
    if (name >= SPY_NAME_MAX || !active->owned[kind][name]) return;
    active->owned[kind][name] = 0;
    --active->live[kind];
}

/* ---- faults --------------------------------------------------------------------------------- */

/* Counts a call. Returns 0 where the context is lost, so that the call must not be made. */
static int enter(void) {
    if (active->fault == SPY_FAULT_LOST && active->calls++ >= (size_t)active->at) {
        if (!active->has_told) active->error = SPY_GL_CONTEXT_LOST;
        return 0;
    }
    return 1;
}

static void count_query(const char *call) {
    if (!strncmp(call, "Get", 3) || !strncmp(call, "Is", 2) || !strncmp(call, "Check", 5))
        ++active->queries;
}

static int is_due(spy_fault fault) {
    return active->fault == fault && active->happened++ == active->at;
}

/* ---- stand-ins ------------------------------------------------------------------------------ */

#define NOTHING
#define INTEGER(name) touch_integer(call, name);
#define CAPABILITY(name) touch(call, QUERY_CAPABILITY, name, 0);
#define FRAMEBUFFER(target) touch_framebuffer(call, target);
#define TEXTURE(target) touch_texture(call, target);
#define SAMPLER(unit) touch(call, QUERY_SAMPLER, GL_SAMPLER_BINDING, GL_TEXTURE0 + unit);
#define BOUND(kind, name) must_own_bound(call, SPY_##kind, name);
#define OWN(kind, object) must_own(call, SPY_##kind, object);
#define OFF(capability) must_be_off(call, capability);

#define SPY_VOID(name, parameters, arguments, before)                                              \
    static void APIENTRY spy_##name parameters {                                                   \
        const char *call = #name;                                                                  \
        count_query(call);                                                                         \
        if (!enter()) return;                                                                      \
        before real_##name() arguments;                                                            \
    }
#define SPY_VALUE(type, none, name, parameters, arguments)                                         \
    static type APIENTRY spy_##name parameters {                                                   \
        count_query(#name);                                                                        \
        return enter() ? real_##name() arguments : none;                                           \
    }
#define SPY_GEN(kind, name)                                                                        \
    static void APIENTRY spy_##name(GLsizei count, GLuint *names) {                                \
        if (!enter()) return;                                                                      \
        real_##name()(count, names);                                                               \
        for (GLsizei i = 0; i < count; ++i) born(SPY_##kind, names[i]);                            \
    }
#define SPY_DELETE(kind, name)                                                                     \
    static void APIENTRY spy_##name(GLsizei count, const GLuint *names) {                          \
        if (!enter()) return;                                                                      \
        for (GLsizei i = 0; i < count; ++i) died(#name, SPY_##kind, names[i]);                     \
        real_##name()(count, names);                                                               \
    }
#define SPY_OTHER(type, name, parameters) static type APIENTRY spy_##name parameters;
#include "spy_calls.h"
#undef SPY_VOID
#undef SPY_VALUE
#undef SPY_GEN
#undef SPY_DELETE
#undef SPY_OTHER

static void spy_BufferData(GLenum target, GLsizeiptr size, const void *data, GLenum usage) {
    if (!enter()) return;
    must_own_bound("BufferData", SPY_BUFFER, buffer_binding(target));
    if (is_due(SPY_FAULT_BUFFER_MEMORY))
        active->error = GL_OUT_OF_MEMORY;
    else
        real_BufferData()(target, size, data, usage);
}

static GLenum spy_CheckFramebufferStatus(GLenum target) {
    count_query("CheckFramebufferStatus");
    if (!enter()) return 0;
    if (is_due(SPY_FAULT_FRAMEBUFFER)) return GL_FRAMEBUFFER_UNSUPPORTED;
    return real_CheckFramebufferStatus()(target);
}

static GLuint spy_CreateProgram(void) {
    GLuint program = enter() ? real_CreateProgram()() : 0;
    born(SPY_PROGRAM, program);
    return program;
}

static GLuint spy_CreateShader(GLenum type) {
    GLuint shader = enter() ? real_CreateShader()(type) : 0;
    born(SPY_SHADER, shader);
    return shader;
}

static void spy_DeleteProgram(GLuint program) {
    if (!enter()) return;
    died("DeleteProgram", SPY_PROGRAM, program);
    real_DeleteProgram()(program);
}

static void spy_DeleteShader(GLuint shader) {
    if (!enter()) return;
    died("DeleteShader", SPY_SHADER, shader);
    real_DeleteShader()(shader);
}

static GLenum spy_GetError(void) {
    count_query("GetError");
    GLenum error = active->error;
    active->error = GL_NO_ERROR;
    if (error == SPY_GL_CONTEXT_LOST) active->has_told = active->tells_once;
    return error ? error : real_GetError()();
}

static GLenum spy_GetGraphicsResetStatus(void) {
    count_query("GetGraphicsResetStatus");
    if (!enter()) return active->no_reset_status ? GL_NO_ERROR : SPY_GL_UNKNOWN_CONTEXT_RESET;
    return real_GetGraphicsResetStatus()();
}

static void spy_GetProgramiv(GLuint program, GLenum name, GLint *value) {
    count_query("GetProgramiv");
    if (!enter()) return;
    real_GetProgramiv()(program, name, value);
    if (name == GL_LINK_STATUS && is_due(SPY_FAULT_LINK)) *value = GL_FALSE;
}

static void spy_GetShaderiv(GLuint shader, GLenum name, GLint *value) {
    count_query("GetShaderiv");
    if (!enter()) return;
    real_GetShaderiv()(shader, name, value);
    if (name == GL_COMPILE_STATUS && is_due(SPY_FAULT_COMPILE)) *value = GL_FALSE;
}

static void spy_TexImage2D(GLenum target, GLint level, GLint internal_format, GLsizei width,
                           GLsizei height, GLint border, GLenum format, GLenum type,
                           const void *pixels) {
    if (!enter()) return;
    must_own_bound("TexImage2D", SPY_TEXTURE, texture_binding(target));
    if (is_due(SPY_FAULT_TEXTURE_MEMORY))
        active->error = GL_OUT_OF_MEMORY;
    else
        real_TexImage2D()(target, level, internal_format, width, height, border, format, type,
                          pixels);
}

static void spy_TexSubImage2D(GLenum target, GLint level, GLint x, GLint y, GLsizei width,
                              GLsizei height, GLenum format, GLenum type, const void *pixels) {
    if (!enter()) return;
    must_own_bound("TexSubImage2D", SPY_TEXTURE, texture_binding(target));
    if (is_due(SPY_FAULT_UPLOAD_MEMORY))
        active->error = GL_OUT_OF_MEMORY;
    else
        real_TexSubImage2D()(target, level, x, y, width, height, format, type, pixels);
}

/* ---- the loader ----------------------------------------------------------------------------- */

static const struct {
    const char *name;
    void (*function)(void);
} functions[FUNCTION_COUNT] = {
#define ROW(name) {"gl" #name, (void (*)(void))spy_##name},
#define SPY_VOID(name, parameters, arguments, before) ROW(name)
#define SPY_VALUE(type, none, name, parameters, arguments) ROW(name)
#define SPY_GEN(kind, name) ROW(name)
#define SPY_DELETE(kind, name) ROW(name)
#define SPY_OTHER(type, name, parameters) ROW(name)
#include "spy_calls.h"
};

/* Functions of extensions have the name of the core's function with three letters appended. */
static int is_named(const char *name, const char *core) {
    size_t length = strlen(core);
    const char *suffix = name + length;
    return strncmp(name, core, length) == 0 &&
           (!*suffix || !strcmp(suffix, "KHR") || !strcmp(suffix, "ARB") || !strcmp(suffix, "EXT"));
}

void *spy_get_proc(void *user, const char *name) {
    spy *s = user;
    spy_use(s);
    for (int i = 0; i < FUNCTION_COUNT; ++i) {
        if (!is_named(name, functions[i].name)) continue;
        void *address = s->get_proc(s->user, name), *fallback;
        memcpy(&s->real[i], &address, sizeof address);
        memcpy(&fallback, &functions[i].function, sizeof fallback);
        return address ? fallback : NULL;
    }
    snprintf(s->trouble, sizeof s->trouble, "%s has no row in tests/support/spy_calls.h", name);
    return NULL;
}

void spy_use(spy *s) {
    active = s;
}

void spy_begin(spy *s) {
    s->touched_count = 0;
}

const char *spy_changed(spy *s) {
    static _Thread_local char text[160];
    spy_use(s);
    for (int i = 0; i < s->touched_count; ++i) {
        const spy_touch *touched = &s->touched[i];
        int now[4];
        read_value(touched, now);
        if (memcmp(now, touched->value, sizeof now) == 0) continue;
        snprintf(text, sizeof text, "state 0x%x (unit 0x%x) was %d %d and is %d %d after gl%s",
                 touched->name, touched->unit, touched->value[0], touched->value[1], now[0], now[1],
                 touched->call);
        return text;
    }
    return NULL;
}

size_t spy_live(const spy *s) {
    size_t sum = 0;
    for (int i = 0; i < SPY_OBJECT_COUNT; ++i) sum += s->live[i];
    return sum;
}

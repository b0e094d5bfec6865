/* SPDX-License-Identifier: MIT
 *
 * probe.c - a GL loader that times passes and counts fragments; see probe.h.
 */
#include "probe.h"

#include <string.h>

enum { MAX_SPANS = 64 };

static struct {
    bench_gl gl; /* the host's own functions */
    unsigned options;
    GLint framebuffer; /* that of the host */
    GLuint wanted;     /* the framebuffer that the renderer bound last */
    GLboolean colors;  /* the last glColorMask */
    probe_pass pass;
    instant start;
    GLuint timers[MAX_SPANS], counters[MAX_SPANS];
    probe_pass spans[MAX_SPANS]; /* the pass of each timer and counter in use */
    size_t span_count;
    probe_report report;
} probe;

void probe_open(psplat_host *host) {
    bench_gl_load(&probe.gl, psplat_host_get_proc, host);
    probe.gl.GenQueries(MAX_SPANS, probe.timers);
    probe.gl.GenQueries(MAX_SPANS, probe.counters);
}

void probe_close(void) {
    probe.gl.DeleteQueries(MAX_SPANS, probe.timers);
    probe.gl.DeleteQueries(MAX_SPANS, probe.counters);
    memset(&probe, 0, sizeof probe);
}

/* ---- spans ----------------------------------------------------------------------------------- */

static void open_span(probe_pass pass) {
    probe.pass = pass;
    probe.start = measure_now();
    if (probe.span_count == MAX_SPANS) return; /* more passes than any frame has */
    probe.spans[probe.span_count] = pass;
    if (probe.options & PROBE_PASSES)
        probe.gl.BeginQuery(BENCH_TIME_ELAPSED, probe.timers[probe.span_count]);
    if (probe.options & PROBE_FRAGMENTS)
        probe.gl.BeginQuery(BENCH_SAMPLES_PASSED, probe.counters[probe.span_count]);
}

static void close_span(void) {
    if (probe.span_count < MAX_SPANS) {
        if (probe.options & PROBE_PASSES) probe.gl.EndQuery(BENCH_TIME_ELAPSED);
        if (probe.options & PROBE_FRAGMENTS) probe.gl.EndQuery(BENCH_SAMPLES_PASSED);
        ++probe.span_count;
    }
    probe.gl.Finish();
    measure_add(&probe.report.passes[probe.pass], measure_since(probe.start));
}

static probe_pass pass_of_draw(void) {
    if (probe.wanted == (GLuint)probe.framebuffer) return PROBE_RESOLVE;
    return probe.colors ? PROBE_ATTRIBUTES : PROBE_VISIBILITY;
}

static double result_of(GLuint query) {
    BENCH_uint64 value = 0;
    probe.gl.GetQueryObjectui64v(query, BENCH_QUERY_RESULT, &value);
    return (double)value;
}

void probe_begin(unsigned options) {
    probe.options = options;
    probe.gl.base.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &probe.framebuffer);
    probe.wanted = (GLuint)probe.framebuffer;
    probe.colors = GL_TRUE;
    probe.span_count = 0;
    memset(&probe.report, 0, sizeof probe.report);
    open_span(PROBE_CLEAR);
}

probe_report probe_end(void) {
    close_span();
    for (size_t i = 0; i < probe.span_count; ++i) {
        if (probe.options & PROBE_PASSES)
            probe.report.gpu[probe.spans[i]] += 1e-6 * result_of(probe.timers[i]);
        if ((probe.options & PROBE_FRAGMENTS) && probe.spans[i] == PROBE_ATTRIBUTES)
            probe.report.fragments += result_of(probe.counters[i]);
    }
    probe.options = 0;
    return probe.report;
}

/* ---- GL functions of the loader ------------------------------------------------------------- */

static void PSPLAT_GL_CALL bind_framebuffer(GLenum target, GLuint framebuffer) {
    if (target != GL_READ_FRAMEBUFFER) probe.wanted = framebuffer;
    probe.gl.base.BindFramebuffer(target, framebuffer);
}

static void PSPLAT_GL_CALL color_mask(GLboolean r, GLboolean g, GLboolean b, GLboolean a) {
    probe.colors = r || g || b || a;
    probe.gl.base.ColorMask(r, g, b, a);
}

static void PSPLAT_GL_CALL enable(GLenum capability) {
    if (capability == GL_BLEND && (probe.options & PROBE_BOUND)) return;
    if (capability == GL_DEPTH_TEST && (probe.options & PROBE_GENERATED)) return;
    probe.gl.base.Enable(capability);
}

static void PSPLAT_GL_CALL clear_buffer(GLenum buffer, GLint index, const GLfloat *value) {
    if (!(probe.options & PROBE_BOUND)) probe.gl.base.ClearBufferfv(buffer, index, value);
}

static void PSPLAT_GL_CALL shader_source(GLuint shader, GLsizei count, const GLchar *const *strings,
                                         const GLint *lengths) {
    static const char *const constant[] = {
        "#version 330 core\nlayout(location = 0) out vec4 o_color;\n"
        "void main() { o_color = vec4(1.0); }\n"};
    GLint type = 0;
    probe.gl.base.GetShaderiv(shader, BENCH_SHADER_TYPE, &type);
    if (type == GL_FRAGMENT_SHADER && (probe.options & PROBE_BOUND))
        probe.gl.base.ShaderSource(shader, 1, constant, NULL);
    else
        probe.gl.base.ShaderSource(shader, count, strings, lengths);
}

/* Returns whether to draw at all. */
static int before_draw(void) {
    probe_pass pass = pass_of_draw();
    if (probe.options & PROBE_BOUND) {
        if (pass == PROBE_RESOLVE) return 0;
        probe.gl.base.BindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)probe.framebuffer);
    }
    if ((probe.options & (PROBE_PASSES | PROBE_FRAGMENTS)) && pass != probe.pass) {
        close_span();
        open_span(pass);
    }
    return 1;
}

static void PSPLAT_GL_CALL draw_arrays(GLenum mode, GLint first, GLsizei count) {
    if (before_draw()) probe.gl.base.DrawArrays(mode, first, count);
}

static void PSPLAT_GL_CALL draw_instances(GLenum mode, GLint first, GLsizei count,
                                          GLsizei instances) {
    if (before_draw()) probe.gl.base.DrawArraysInstanced(mode, first, count, instances);
}

/* ISO C has no cast from function to object pointers. */
void *probe_get_proc(void *user, const char *name) {
    typedef void(PSPLAT_GL_CALL * function)(void);
    static const struct {
        const char *name;
        function address;
    } replaced[] = {{"glBindFramebuffer", (function)bind_framebuffer},
                    {"glColorMask", (function)color_mask},
                    {"glEnable", (function)enable},
                    {"glClearBufferfv", (function)clear_buffer},
                    {"glShaderSource", (function)shader_source},
                    {"glDrawArrays", (function)draw_arrays},
                    {"glDrawArraysInstanced", (function)draw_instances}};
    for (size_t i = 0; i < sizeof replaced / sizeof *replaced; ++i) {
        void *address = NULL;
        memcpy(&address, &replaced[i].address, sizeof address);
        if (strcmp(name, replaced[i].name) == 0) return address;
    }
    return psplat_host_get_proc(user, name);
}

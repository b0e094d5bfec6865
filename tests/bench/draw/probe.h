/* SPDX-License-Identifier: MIT
 *
 * probe.h - looks into a renderer from outside: a GL loader whose functions note when a pass ends
 * and the next begins, count fragments, or draw something cheaper than they are asked to.
 *
 * A pass is told by its draws: into the framebuffer that was bound when the frame began (resolve),
 * into another with colours masked (visibility) or not (attributes). What happens before the first
 * draw, clears above all, is a pass of its own. Between passes GL is finished, so that their times
 * do not mix; a frame takes a little longer so.
 *
 * GL functions have no user pointer: there is one probe in a process.
 */
#ifndef PHONGSPLAT_BENCH_PROBE_H
#define PHONGSPLAT_BENCH_PROBE_H

#include "bench_gl.h"
#include "measure.h"

typedef enum probe_pass {
    PROBE_CLEAR = 0,
    PROBE_VISIBILITY,
    PROBE_ATTRIBUTES,
    PROBE_RESOLVE,
    PROBE_PASS_COUNT
} probe_pass;

/* What the loader's functions do beside or instead of what they are asked to; or-ed together.
 *
 *     PASSES     time the passes
 *     FRAGMENTS  count the fragments that the attribute pass writes
 *     BOUND      the lower bound of drawing with these primitives: they are drawn twice, as asked,
 *                but into the host's framebuffer, with a constant fragment shader, without blending
 *                and without a resolve pass
 *     GENERATED  with BOUND and FRAGMENTS: no depth test, so that every fragment is counted that
 *                the primitives generate */
enum { PROBE_PASSES = 1, PROBE_FRAGMENTS = 2, PROBE_BOUND = 4, PROBE_GENERATED = 8 };

typedef struct probe_report {
    instant passes[PROBE_PASS_COUNT]; /* with PASSES */
    /* With PASSES: milliseconds by timer queries; 0: not measured. */
    double gpu[PROBE_PASS_COUNT];
    double fragments; /* with FRAGMENTS */
} probe_report;

/* Loads the functions that the probe itself calls. The host's context must be current. */
void probe_open(psplat_host *host);
void probe_close(void);

/* A loader to hand to a renderer; user is the host. Programs that were made while BOUND was set
 * keep their constant shaders. */
void *probe_get_proc(void *user, const char *name);

/* These two enclose a frame, with the host's framebuffer bound. probe_end waits until all is
 * drawn. */
void probe_begin(unsigned options);
probe_report probe_end(void);

#endif

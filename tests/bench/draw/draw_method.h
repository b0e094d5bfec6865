/* SPDX-License-Identifier: MIT
 *
 * draw_method.h - the methods to draw a subject that benchmarks compare. All draw into the
 * framebuffer that is bound and has been cleared.
 */
#ifndef PHONGSPLAT_BENCH_DRAW_METHOD_H
#define PHONGSPLAT_BENCH_DRAW_METHOD_H

#include "bench_gl.h"
#include "subject.h"

typedef struct draw_method {
    const char *name;
    void (*draw)(void *self, const psplat_view *view);
    void (*destroy)(void *self);
    void *self;       /* owned */
    unsigned options; /* options of the probe besides those that measure */
} draw_method;

/* Returns the renderer or, with PROBE_BOUND in options, the lower bound of drawing its
 * primitives. */
draw_method draw_method_splats(psplat_host *host, const subject *s, unsigned options);

/* Returns the renderer without a loader of images, so that it draws no textures. */
draw_method draw_method_untextured(psplat_host *host, const subject *s);

/* Returns the renderer with sums of 16 bits (psplat_renderer_desc.half_targets). */
draw_method draw_method_half(psplat_host *host, const subject *s);

/* Returns the papers' own method (BSK04, BHZK05). Sides, lights and filter follow the view; the
 * mode is always phong and lit. */
draw_method draw_method_sprites(psplat_host *host, const subject *s, unsigned options);

/* Returns the papers' own method with another reading of BHZK05: what the filter adds outside a
 * splat's ellipse has the depth of the splat's plane there instead of that of its centre. */
draw_method draw_method_sprites_plane(psplat_host *host, const subject *s, unsigned options);

void draw_method_destroy(draw_method *c);

#endif

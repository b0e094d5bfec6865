/* SPDX-License-Identifier: MIT
 *
 * draw_method.h - ways to draw a subject that are to be compared. All draw into the framebuffer
 * that is bound, which is cleared.
 */
#ifndef PHONGSPLAT_BENCH_CONTESTANT_H
#define PHONGSPLAT_BENCH_CONTESTANT_H

#include "bench_gl.h"
#include "subject.h"

typedef struct contestant {
    const char *name;
    void (*draw)(void *self, const psplat_view *view);
    void (*destroy)(void *self);
    void *self;       /* owned */
    unsigned options; /* of the probe, beside those that measure */
} contestant;

/* The renderer. With PROBE_BOUND in options: the lower bound of its primitives. */
contestant contestant_splats(psplat_host *host, const subject *s, unsigned options);

/* The papers' own method. Sides, lights and filter as the view says; always phong and lit. */
contestant contestant_sprites(psplat_host *host, const subject *s, unsigned options);

/* The same but for what the filter adds outside a splat's ellipse: it has the depth of the splat's
 * plane there, as BHZK05 can be read, not that of its centre. */
contestant contestant_sprites_plane(psplat_host *host, const subject *s, unsigned options);

void contestant_destroy(contestant *c);

#endif

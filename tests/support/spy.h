/* SPDX-License-Identifier: MIT
 *
 * spy.h - a loader between the runtime and a real context that watches and can misbehave.
 *
 * Of every call that sets context state it keeps what the state was before the first such call, so
 * that spy_changed can tell what was not put back; calls that change objects must act on objects
 * made through the spy. Each function is a row of spy_calls.h that says which of this it is: a
 * function without a row is refused, so that no leak goes unwatched. Objects alive are counted.
 *
 *     spy s = {.get_proc = psplat_host_get_proc, .user = host};
 *     psplat_renderer_desc desc = {.get_proc = spy_get_proc, .user = &s};
 *
 * A spy serves one thread; several threads may have one each.
 */
#ifndef PHONGSPLAT_TEST_SPY_H
#define PHONGSPLAT_TEST_SPY_H

#include <stddef.h>

typedef enum spy_object {
    SPY_TEXTURE = 0,
    SPY_FRAMEBUFFER,
    SPY_SAMPLER,
    SPY_VERTEX_ARRAY,
    SPY_BUFFER,
    SPY_PROGRAM,
    SPY_SHADER,
    SPY_OBJECT_COUNT
} spy_object;

/* What can go wrong. at counts opportunities, that is, calls of the named function, from 0. */
typedef enum spy_fault {
    SPY_FAULT_NONE = 0,
    SPY_FAULT_TEXTURE_MEMORY, /* glTexImage2D does nothing and sets GL_OUT_OF_MEMORY */
    SPY_FAULT_UPLOAD_MEMORY,  /* glTexSubImage2D does the same */
    SPY_FAULT_BUFFER_MEMORY,  /* glBufferData does the same */
    SPY_FAULT_FRAMEBUFFER,    /* glCheckFramebufferStatus says incomplete */
    SPY_FAULT_COMPILE,        /* GL_COMPILE_STATUS is false */
    SPY_FAULT_LINK,           /* GL_LINK_STATUS is false */
    /* From the at-th call of any function on, calls have no effect, queries store nothing, and
     * glGetError returns GL_CONTEXT_LOST. */
    SPY_FAULT_LOST,
    SPY_FAULT_COUNT
} spy_fault;

enum { SPY_TOUCH_MAX = 128, SPY_NAME_MAX = 1 << 15, SPY_FUNCTION_MAX = 96 };

/* A value of context state. */
typedef struct spy_touch {
    const char *call; /* the call that was about to set it */
    unsigned query;   /* a number of spy.c */
    unsigned name, unit;
    int value[4];
} spy_touch;

typedef struct spy {
    void *(*get_proc)(void *user, const char *name);
    void *user;
    spy_fault fault;
    int at;       /* when the fault happens */
    int happened; /* opportunities so far */
    /* 1: glGetGraphicsResetStatus does not tell a loss, only glGetError does */
    int no_reset_status;
    int tells_once; /* 1: glGetError tells it only the first time, as WebGL's does; */
    int has_told;   /* it has told it */
    void (*real[SPY_FUNCTION_MAX])(void);
    size_t live[SPY_OBJECT_COUNT];
    size_t made;    /* objects of all kinds that were ever made */
    size_t calls;   /* calls counted while the fault is SPY_FAULT_LOST */
    size_t queries; /* calls of functions that ask GL: glGet..., glIsEnabled, glCheck... */
    unsigned error; /* what the next glGetError returns */
    unsigned char owned[SPY_OBJECT_COUNT][SPY_NAME_MAX];
    spy_touch touched[SPY_TOUCH_MAX];
    int touched_count;
    char trouble[160]; /* the first forbidden thing that happened, or "" */
} spy;

void *spy_get_proc(void *user, const char *name);

/* Makes this the thread's spy, as spy_get_proc does, too. */
void spy_use(spy *s);

/* Forgets the state that was kept. */
void spy_begin(spy *s);

/* Compares everything set since spy_begin with its earlier value. Returns NULL where all is as
 * before, otherwise one sentence that is valid until the next call. */
const char *spy_changed(spy *s);

size_t spy_live(const spy *s); /* live objects of all kinds */

#endif

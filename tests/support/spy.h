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
    SPY_VERTEX_ARRAY,
    SPY_PROGRAM,
    SPY_SHADER,
    SPY_OBJECT_COUNT
} spy_object;

/* What can go wrong. at counts opportunities from 0: calls of the named function. */
typedef enum spy_fault {
    SPY_FAULT_NONE = 0,
    SPY_FAULT_TEXTURE_MEMORY, /* glTexImage2D does nothing and sets GL_OUT_OF_MEMORY */
    SPY_FAULT_UPLOAD_MEMORY,  /* glTexSubImage2D likewise */
    SPY_FAULT_FRAMEBUFFER,    /* glCheckFramebufferStatus is not satisfied */
    SPY_FAULT_COMPILE,        /* GL_COMPILE_STATUS is false */
    SPY_FAULT_LINK,           /* GL_LINK_STATUS is false */
    SPY_FAULT_LOST,           /* from the at-th call of any function on none has an effect, queries
                                 leave their results alone, and glGetError is GL_CONTEXT_LOST */
    SPY_FAULT_COUNT
} spy_fault;

enum { SPY_TOUCH_MAX = 128, SPY_NAME_MAX = 1 << 15, SPY_FUNCTION_MAX = 96 };

/* A value of context state. */
typedef struct spy_touch {
    const char *call; /* that was about to set it */
    unsigned query;   /* spy.c's */
    unsigned name, unit;
    int value[4];
} spy_touch;

typedef struct spy {
    void *(*get_proc)(void *user, const char *name);
    void *user;
    spy_fault fault;
    int at;              /* of the fault */
    int happened;        /* opportunities so far */
    int no_reset_status; /* 1: glGetGraphicsResetStatus says nothing of a loss, glGetError does */
    int tells_once;      /* 1: but only the first time, as WebGL's does; */
    int has_told;        /* that it did */
    void (*real[SPY_FUNCTION_MAX])(void);
    size_t live[SPY_OBJECT_COUNT];
    size_t made;    /* objects of all kinds, ever */
    size_t calls;   /* counted while the fault is SPY_FAULT_LOST */
    unsigned error; /* that the next glGetError returns */
    unsigned char owned[SPY_OBJECT_COUNT][SPY_NAME_MAX];
    spy_touch touched[SPY_TOUCH_MAX];
    int touched_count;
    char trouble[160]; /* the first thing that must not happen; "" if none did */
} spy;

void *spy_get_proc(void *user, const char *name);

/* Makes the spy that of this thread; spy_get_proc does too. */
void spy_use(spy *s);

/* Forgets what was touched. */
void spy_begin(spy *s);

/* Compares everything touched since spy_begin with what it was. Returns NULL where all is as it
 * was, otherwise one sentence, valid until the next call. */
const char *spy_changed(spy *s);

size_t spy_live(const spy *s); /* objects of all kinds */

#endif

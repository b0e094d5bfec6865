/* SPDX-License-Identifier: MIT */
#include "gl.h"

#include <string.h>

int engine_gl_load(engine_gl *gl, void *(*get_proc)(void *user, const char *name), void *user) {
    void *address;
#define ENGINE_GL_LOAD(type, name)                                                                 \
    address = get_proc(user, "gl" #name);                                                          \
    memcpy(&gl->name, &address, sizeof address);                                                   \
    if (!address) return 0;
    ENGINE_GL_FUNCTIONS(ENGINE_GL_LOAD)
#undef ENGINE_GL_LOAD
    return 1;
}

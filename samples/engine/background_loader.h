/* SPDX-License-Identifier: MIT
 *
 * background_loader.h - opens assets on a thread of its own, so that frames go on meanwhile.
 * Reading and checking a file is the slow part and needs no GL; the upload is for the thread that
 * draws.
 */
#ifndef ENGINE_BACKGROUND_LOADER_H
#define ENGINE_BACKGROUND_LOADER_H

#include <phongsplat/phongsplat.h>

typedef struct loader loader;

/* The paths must last as long as the loader. Returns NULL on failure. */
loader *loader_start(const char *const *paths, int count);

/* Returns the next asset in the order of the paths, owned by the caller, or NULL while none is open
 * yet. Where it could not be opened, *error is filled and its code is not 0. */
psplat_asset *loader_take(loader *l, psplat_error *error);

/* Waits for the thread and destroys assets that nobody took. NULL is accepted. */
void loader_stop(loader *l);

#endif

/* SPDX-License-Identifier: MIT
 *
 * background_loader.h - opens assets on a thread of its own, so that frames go on meanwhile.
 * Reading and checking a file is the slow part and needs no GL; the upload is for the thread that
 * draws.
 */
#ifndef ENGINE_LOADER_H
#define ENGINE_LOADER_H

#include <phongsplat/phongsplat.h>

typedef struct loader loader;

/* The paths must last as long as the loader. NULL on failure. */
loader *loader_start(const char *const *paths, int count);

/* The next asset in the order of the paths that is open, or NULL while there is none yet; *error is
 * filled, and its code not 0, where it could not be opened. The asset is the caller's. */
psplat_asset *loader_take(loader *l, psplat_error *error);

/* Waits for the thread; assets that nobody took are destroyed. NULL is accepted. */
void loader_stop(loader *l);

#endif

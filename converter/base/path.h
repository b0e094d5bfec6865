/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * path.h - paths shortened for error messages.
 */
#ifndef PHONGSPLAT_BASE_PATH_H
#define PHONGSPLAT_BASE_PATH_H

#ifdef __cplusplus
extern "C" {
#endif

/* The size in bytes of a shortened path with its 0. */
#define PSPLAT_SHOWN_PATH 112

/* Stores path as messages show it: control characters become question marks, and a long path loses
 * its middle, so that the cause after it still fits into a psplat_error. */
void psplat_path_shorten(const char *path, char shown[PSPLAT_SHOWN_PATH]);

#ifdef __cplusplus
}
#endif
#endif

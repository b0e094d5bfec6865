/* SPDX-License-Identifier: MIT
 *
 * settings.c - the names of modes, shadings and other choices.
 */
#include "viewer.h"

const char *const mode_names[] = {"phong", "gaussian", "flat", NULL};

const char *const shading_names[] = {
#define SHADING_NAME(constant, file, reads) #file,
    PSPLAT_SHADINGS(SHADING_NAME)
#undef SHADING_NAME
        NULL};

const char *const culling_names[] = {"as the material says", "never", "always", NULL};

const char *const backdrop_names[] = {"dark", "light", "black", "white", NULL};

int names_count(const char *const *names) {
    int count = 0;
    while (names[count]) ++count;
    return count;
}

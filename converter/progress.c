/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * progress.c - one line on the terminal, rewritten only when what it says changes.
 */
#define _XOPEN_SOURCE 700

#include "command.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

psplat_progress psplat_progress_begin(int quiet) {
    psplat_progress progress = {.enabled = !quiet && isatty(STDERR_FILENO), .percent = -1};
    return progress;
}

int psplat_progress_show(void *user, const char *stage, double fraction) {
    psplat_progress *progress = user;
    int percent = fraction > 0 ? (int)(100 * (fraction < 1 ? fraction : 1)) : 0;
    if (!progress->enabled) return 0;
    if (progress->stage && !strcmp(progress->stage, stage) && progress->percent == percent)
        return 0;
    progress->stage = stage;
    progress->percent = percent;
    fprintf(stderr, "\r\033[K%s %d %%", stage, percent);
    fflush(stderr);
    return 0;
}

void psplat_progress_end(psplat_progress *progress) {
    if (progress->enabled && progress->stage) fputs("\r\033[K", stderr);
    progress->stage = NULL;
}

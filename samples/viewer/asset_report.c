/* SPDX-License-Identifier: MIT
 *
 * asset_report.c - prints the error line and returns the exit code; the table in README.md explains
 * the codes.
 */
#include "viewer.h"

#include <stdio.h>

static const int exit_codes[PSPLAT_RESULT_COUNT] = {
    [PSPLAT_ERROR_ARGUMENT] = 1, [PSPLAT_ERROR_READ] = 2,        [PSPLAT_ERROR_FORMAT] = 3,
    [PSPLAT_ERROR_RANGE] = 3,    [PSPLAT_ERROR_NO_SPLATS] = 3,   [PSPLAT_ERROR_RESCALED] = 3,
    [PSPLAT_ERROR_GRAPHICS] = 6, [PSPLAT_ERROR_UNSUPPORTED] = 4, [PSPLAT_ERROR_WRITE] = 5,
    [PSPLAT_ERROR_MEMORY] = 7,   [PSPLAT_ERROR_INTERRUPTED] = 8,
};

int report_exit_code(psplat_result result) {
    return (unsigned)result < PSPLAT_RESULT_COUNT ? exit_codes[result] : 1;
}

int report_error(const char *subject, const psplat_error *error) {
    char line[1024], place[40] = "";
    if (error->offset) snprintf(place, sizeof place, "byte %zu: ", error->offset);
    snprintf(line, sizeof line, "%s%s%s%s", subject ? subject : "", subject ? ": " : "", place,
             *error->text ? error->text : psplat_result_text(error->code));
    for (char *c = line; *c; ++c)
        if ((unsigned char)*c < 0x20 || *c == 0x7f) *c = '?';
    fprintf(stderr, "phongsplat-viewer: %s\n", line);
    return report_exit_code(error->code);
}

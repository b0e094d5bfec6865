/* SPDX-License-Identifier: MIT
 *
 * error.c - the texts of results, and the function that fills psplat_error.
 */
#include <phongsplat/splat.h>

#include <stdarg.h>
#include <stdio.h>

static const char *const texts[PSPLAT_RESULT_COUNT] = {
    [PSPLAT_OK] = "success",
    [PSPLAT_ERROR_ARGUMENT] = "invalid argument",
    [PSPLAT_ERROR_MEMORY] = "out of memory",
    [PSPLAT_ERROR_READ] = "cannot read",
    [PSPLAT_ERROR_WRITE] = "cannot write",
    [PSPLAT_ERROR_FORMAT] = "malformed input",
    [PSPLAT_ERROR_RANGE] = "value out of range",
    [PSPLAT_ERROR_UNSUPPORTED] = "unsupported input",
    [PSPLAT_ERROR_NO_SPLATS] = "nothing to convert or draw",
    [PSPLAT_ERROR_RESCALED] = "positions were changed by another tool",
    [PSPLAT_ERROR_GRAPHICS] = "graphics failure",
    [PSPLAT_ERROR_INTERRUPTED] = "interrupted",
};

const char *psplat_result_text(psplat_result result) {
    unsigned index = (unsigned)result;
    return index < PSPLAT_RESULT_COUNT ? texts[index] : "unknown result";
}

psplat_result psplat_fail(psplat_error *error, psplat_result code, size_t offset,
                          const char *format, ...) {
    if (!error) return code;
    error->code = code;
    error->offset = offset;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    for (char *c = error->text; *c; ++c)
        if (*c == '\n' || *c == '\r') *c = ' ';
    return code;
}

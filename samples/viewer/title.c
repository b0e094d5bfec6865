/* SPDX-License-Identifier: MIT
 *
 * title.c - writes the window's title: files, number of splats, how they are drawn and how long a
 * frame takes.
 */
#include "viewer.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

typedef struct writer {
    char *text;
    size_t size, length;
} writer;

static void append(writer *w, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

static void append(writer *w, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    int written = vsnprintf(w->text + w->length, w->size - w->length, format, arguments);
    va_end(arguments);
    if (written > 0) w->length += (size_t)written;
    if (w->length >= w->size) w->length = w->size - 1;
}

/* Writes 1234567 as 1,234,567. */
static void append_count(writer *w, size_t count) {
    char digits[32];
    int length = snprintf(digits, sizeof digits, "%zu", count);
    for (int i = 0; i < length; ++i)
        append(w, "%s%c", i && (length - i) % 3 == 0 ? "," : "", digits[i]);
}

static void append_files(writer *w, const shown_assets *s, size_t splats) {
    for (size_t i = 0; i < s->entry_count && i < 3; ++i)
        append(w, "%s%s%s", i ? ", " : "", shown_asset_name(s->entries[i].path),
               s->entries[i].error.code ? " (broken)" : "");
    if (s->entry_count > 3) append(w, " and %zu more", s->entry_count - 3);
    append(w, " - ");
    append_count(w, splats);
    append(w, splats == 1 ? " splat" : " splats");
}

void title_write(const viewer *v, char *text, size_t size) {
    writer w = {text, size, 0};
    const settings *s = &v->settings;
    if (*v->shown.refused_path)
        append(&w, "%s (broken) - ", shown_asset_name(v->shown.refused_path));
    if (v->shown.entry_count) {
        append_files(&w, &v->shown, v->shown.splat_count + v->tiles_state.splats);
        append(&w, " - %s, %s", mode_names[s->mode], shading_names[s->shading]);
        if (v->frame_time > 0) append(&w, " - %.1f ms", 1e3 * v->frame_time);
        append(&w, " - ");
    }
    append(&w, "phongsplat");
}

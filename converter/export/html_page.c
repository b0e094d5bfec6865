/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * html_page.c - one HTML page with a viewer and models in it, as fillTemplate() of
 * runtime/web/page.mjs makes it: each model is a script element of base64, which has no character
 * that HTML gives a meaning.
 */
#include "export/html_page.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static const char title_mark[] = "<title>Phong splats</title>";
static const char models_mark[] = "<!-- models -->\n";

/* The page while it is written: first only counted, with bytes NULL, then stored. */
typedef struct writer {
    char *bytes;
    size_t size;
} writer;

static void put(writer *out, const char *text, size_t size) {
    if (out->bytes) memcpy(out->bytes + out->size, text, size);
    out->size += size;
}

static void put_text(writer *out, const char *text) {
    put(out, text, strlen(text));
}

/* Writes a text for an element or an attribute in double quotes. */
static void put_escaped(writer *out, const char *text) {
    for (; *text; ++text) {
        switch (*text) {
        case '&':
            put_text(out, "&amp;");
            break;
        case '<':
            put_text(out, "&lt;");
            break;
        case '>':
            put_text(out, "&gt;");
            break;
        case '"':
            put_text(out, "&quot;");
            break;
        default:
            put(out, text, 1);
        }
    }
}

/* Writes bytes as base64 (RFC 4648, section 4). */
static void put_base64(writer *out, const uint8_t *bytes, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    if (!out->bytes) {
        out->size += (size + 2) / 3 * 4;
        return;
    }
    for (size_t i = 0; i < size; i += 3) {
        size_t left = size - i;
        uint32_t bits = (uint32_t)bytes[i] << 16;
        if (left > 1) bits |= (uint32_t)bytes[i + 1] << 8;
        if (left > 2) bits |= bytes[i + 2];
        char group[4] = {digits[bits >> 18], digits[bits >> 12 & 63], '=', '='};
        if (left > 1) group[2] = digits[bits >> 6 & 63];
        if (left > 2) group[3] = digits[bits & 63];
        put(out, group, 4);
    }
}

static void put_models(writer *out, const psplat_page_model *models, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        put_text(out, "<script type=\"model\" data-name=\"");
        put_escaped(out, models[i].name);
        put_text(out, "\">");
        put_base64(out, models[i].bytes, models[i].size);
        put_text(out, "</script>\n");
    }
}

static void put_page(writer *out, const char *text, const psplat_page_model *models, size_t count) {
    const char *title = strstr(text, title_mark), *place = strstr(text, models_mark);
    put(out, text, (size_t)(title - text));
    put_text(out, "<title>");
    put_escaped(out, models[0].name);
    put_text(out, "</title>");
    text = title + strlen(title_mark);
    put(out, text, (size_t)(place - text));
    put_models(out, models, count);
    put_text(out, place + strlen(models_mark));
}

psplat_result psplat_html_check(const char *text, psplat_error *error) {
    const char *title = strstr(text, title_mark), *place = strstr(text, models_mark);
    if (title && place && title < place) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "is not the viewer's page");
}

psplat_result psplat_html_page(const char *text, const psplat_page_model *models,
                               size_t model_count, char **page, size_t *size, psplat_error *error) {
    writer out = {0};
    psplat_result result = psplat_html_check(text, error);
    if (result) return result;
    put_page(&out, text, models, model_count);
    out.bytes = malloc(out.size + 1);
    if (!out.bytes) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    out.size = 0;
    put_page(&out, text, models, model_count);
    out.bytes[out.size] = 0;
    *page = out.bytes;
    *size = out.size;
    return PSPLAT_OK;
}

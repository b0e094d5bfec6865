/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * html_page.h - one HTML page with a viewer and models in it, which opens from disk.
 */
#ifndef PHONGSPLAT_EXPORT_HTML_PAGE_H
#define PHONGSPLAT_EXPORT_HTML_PAGE_H

#include <phongsplat/splat.h>

#include <stddef.h>

/* A model for the page. The extension of its name, .glb, .gltf, .obj, .ply or .stl, tells the
 * viewer how to read it; the first model's name is the page's title. Names are UTF-8 and may hold
 * anything: what HTML gives a meaning is escaped. */
typedef struct psplat_page_model {
    const char *name;
    const void *bytes;
    size_t size;
} psplat_page_model;

/* Checks that a page is a template: that it has the title and the place for models that the page
 * `page.mjs --template` of runtime/web has. text ends with 0. Errors: PSPLAT_ERROR_GRAPHICS. */
psplat_result psplat_html_check(const char *text, psplat_error *error);

/* Puts models into a template. *page is malloc'ed, has a 0 after its *size bytes, and belongs to
 * the caller. Errors: PSPLAT_ERROR_GRAPHICS (not a template), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_html_page(const char *text, const psplat_page_model *models,
                               size_t model_count, char **page, size_t *size, psplat_error *error);

#endif

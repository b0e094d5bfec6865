/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * page.h - the page of `convert --html`: the viewer's template, which lies beside the program, and
 * what goes into it.
 */
#ifndef PHONGSPLAT_CLI_PAGE_H
#define PHONGSPLAT_CLI_PAGE_H

#include "source/source_file.h"

#include <phongsplat/splat.h>

#include <stddef.h>

/* What a page takes besides the asset. Zero-initialise; psplat_page_close releases it. */
typedef struct psplat_page {
    char *template;       /* the viewer's page, ended by a 0 */
    psplat_source source; /* the file of the mesh to show beside the splats, or empty */
    uint8_t *mesh;        /* that mesh as a GLB, where the viewer does not read the file, or NULL */
    size_t mesh_size;
} psplat_page;

/* Reads the template and, unless source is NULL, the source file. Errors: PSPLAT_ERROR_GRAPHICS (no
 * template beside this program or where installations have it, or not one), and those of
 * psplat_source_load. */
psplat_result psplat_page_open(psplat_page *page, const char *source, psplat_error *error);

/* Returns whether the page wants the source as a GLB, in psplat_page.mesh: a file that is a GLB is
 * shown as it is, unless Draco compressed it, and so is an OBJ that refers to no materials; the
 * viewer reads no other format, and a page has no second file. */
int psplat_page_wants_mesh(const psplat_page *page);

/* Makes the page of an asset. Models get the names of their files, with an extension by which the
 * viewer knows them. *text is malloc'ed and owned by the caller. Errors: PSPLAT_ERROR_MEMORY. */
psplat_result psplat_page_make(const psplat_page *page, const char *asset_path, const void *bytes,
                               size_t size, char **text, size_t *text_size, psplat_error *error);

void psplat_page_close(psplat_page *page);

#endif

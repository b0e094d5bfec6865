/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * document.h - the JSON of a file of splats. For the writer: columns.c, layout.c, document.c,
 * glb.c.
 */
#ifndef PHONGSPLAT_DOCUMENT_H
#define PHONGSPLAT_DOCUMENT_H

#include "json_writer.h"
#include "layout.h"
#include "scenes.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The views of a file: those of splats, then those of stand-ins. */
size_t psplat_document_view_count(const psplat_layout *layout);
const psplat_file_view *psplat_document_view(const psplat_layout *layout, size_t index);
/* Bytes of the binary chunk that a view takes. */
size_t psplat_file_view_bytes(const psplat_file_view *view);
/* The document, finished. The sheets' sets of splats lie one after another. 0 where memory ran out.
 */
int psplat_document_write(psplat_writer *json, const psplat_scene *scene,
                          const psplat_layout *layout);

#ifdef __cplusplus
}
#endif
#endif

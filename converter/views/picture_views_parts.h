/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * picture_views_parts.h - the members of psplat_picture_views, for the files of this room.
 */
#ifndef PHONGSPLAT_VIEWS_PICTURE_VIEWS_PARTS_H
#define PHONGSPLAT_VIEWS_PICTURE_VIEWS_PARTS_H

#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "views/mesh_renderer.h"
#include "views/picture_views.h"

#include <phongsplat/splat.h>
#include <phongsplat/host.h>

struct psplat_picture_views {
    psplat_host *host;                /* owned by the caller */
    const psplat_source_mesh *source; /* owned by the caller */
    int size;
    psplat_shading shading;
    psplat_mesh_renderer *source_renderer;
    uint8_t *pictures; /* of the source: RGBA, size x size from each view, row 0 at the bottom */
    int distant_size;
    uint8_t *distant; /* of the source, averaged to distant_size from each view (distant_view.h) */
    uint8_t *shown;   /* the last picture that psplat_picture_views_show has drawn */
};

/* Returns the bytes of a picture of size x size. */
size_t psplat_picture_views_bytes(const psplat_picture_views *views);
/* Makes the host's framebuffer of size x size pixels current and clears it to transparent black. */
psplat_result psplat_picture_views_begin(psplat_picture_views *views, int size, int is_float,
                                         psplat_error *error);
/* Draws what is pictured from a view into views->shown. */
psplat_result psplat_picture_views_show(psplat_picture_views *views,
                                        const psplat_pictured *pictured, int view,
                                        psplat_error *error);

#endif

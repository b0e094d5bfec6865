/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * gallery.h - what is inside a psplat_gallery, for the files beside it.
 */
#ifndef PHONGSPLAT_GALLERY_H
#define PHONGSPLAT_GALLERY_H

#include "compare.h"
#include "facets.h"

struct psplat_gallery {
    psplat_host *host;             /* the caller's, as is */
    const psplat_original *source; /* this */
    int size;
    psplat_facets *facets; /* the source */
    uint8_t *pictures;     /* RGBA of it, size x size from each view, row 0 at the bottom */
    int distant_size;
    uint8_t *distant; /* the same from far away, as it should look (distant.h) */
    uint8_t *shown;   /* one of the exhibit */
};

size_t psplat_gallery_bytes(const psplat_gallery *gallery); /* of a picture */
/* Clears the host's framebuffer of size x size pixels to nothing and makes it current. */
psplat_result psplat_gallery_begin(psplat_gallery *gallery, int size, int is_float,
                                   psplat_error *error);
/* Draws an exhibit from a view into gallery->shown. */
psplat_result psplat_gallery_show(psplat_gallery *gallery, const psplat_exhibit *exhibit, int view,
                                  psplat_error *error);
/* RGBA with row 0 at the bottom to RGB with row 0 on top, rows of stride pixels. */
void psplat_gallery_turn(const uint8_t *rgba, int size, uint8_t *rgb, size_t stride);

#endif

/* SPDX-License-Identifier: MIT
 *
 * film.h - films a small model under a camera that moves by a fraction of a pixel from frame to
 * frame, and measures how far the film is from the truth: the same film at several times the size,
 * averaged in linear light. Ends the program with a message where something fails.
 */
#ifndef PHONGSPLAT_TEST_FILM_H
#define PHONGSPLAT_TEST_FILM_H

#include <phongsplat/host.h>
#include <phongsplat/phongsplat.h>

enum { FILM_FRAMES = 16, FILM_BORDER = 4, FILM_FINER = 8 };

/* Frames as rows of pixels: the red channel, linear, over black. */
typedef struct film {
    int size; /* of a frame: the model's pixels across and a border on each side */
    double *value[FILM_FRAMES], *covered[FILM_FRAMES]; /* allocated with malloc; covered 0 ... 1 */
} film;

/* Draws a view into the bound framebuffer, as psplat_draw does. */
typedef void (*film_draw)(void *self, const psplat_view *view);

/* Films the unit sphere from +z, across pixels wide. In the course of the film the camera moves by
 * a pixel along x and by two thirds of one along y. finer is the number of pixels, in each
 * direction, that a pixel is averaged from. */
film film_shoot(psplat_host *host, film_draw draw, void *self, int across, int no_filter,
                int finer);
void film_free(film *f);

/* Flicker is how much more a pixel changes from one frame to the next than in the truth. */
typedef struct film_figures {
    double change, most_change;   /* change of a pixel between frames: mean and greatest */
    double flicker, most_flicker; /* how that differs from the truth's change */
    double error, squared_error;  /* difference from the truth: mean, and root of the mean square */
    size_t count;                 /* pairs of pixels compared */
} film_figures;

typedef struct film_report {
    film_figures inside; /* values of pixels that the model fills in the truth in both frames */
    /* Coverage of other pixels that the film or the truth covers, even in part. */
    film_figures outline;
    double covered; /* covered pixels a frame */
} film_report;

film_report film_compare(const film *f, const film *truth);

#endif

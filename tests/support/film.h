/* SPDX-License-Identifier: MIT
 *
 * film.h - a small model under a camera that moves by a fraction of a pixel from frame to frame,
 * and how far such a film is from the truth: the same at several times the size, averaged in linear
 * light. Ends the program with a message where something fails.
 */
#ifndef PHONGSPLAT_TEST_FILM_H
#define PHONGSPLAT_TEST_FILM_H

#include <phongsplat/host.h>
#include <phongsplat/phongsplat.h>

enum { FILM_FRAMES = 16, FILM_BORDER = 4, FILM_FINER = 8 };

/* Of pixels in rows; the red channel, linear, over black. */
typedef struct film {
    int size; /* of a frame: the model's pixels across and a border on each side */
    double *value[FILM_FRAMES], *covered[FILM_FRAMES]; /* malloc; covered 0 ... 1 */
} film;

/* Draws a view into the bound framebuffer, as psplat_draw does. */
typedef void (*film_draw)(void *self, const psplat_view *view);

/* The unit ball, across pixels wide, from +z; in the course of the film the camera moves by a pixel
 * along x and two thirds along y. finer: pixels that a pixel is averaged of, in each direction. */
film film_shoot(psplat_host *host, film_draw draw, void *self, int across, int no_filter,
                int finer);
void film_free(film *f);

/* Flicker is how much more than in truth a pixel changes from one frame to the next. */
typedef struct film_figures {
    double change, most_change;   /* of a pixel between frames: mean and most */
    double flicker, most_flicker; /* how that differs from the truth's */
    double error, squared_error;  /* difference from the truth: mean, and root of mean square */
    size_t count;                 /* of pairs of pixels */
} film_figures;

typedef struct film_report {
    film_figures inside;  /* values of pixels that the model fills in truth, in both frames */
    film_figures outline; /* coverage of others that the film or the truth covers, even in part */
    double covered;       /* pixels a frame */
} film_report;

film_report film_compare(const film *f, const film *truth);

#endif

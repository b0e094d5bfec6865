/* SPDX-License-Identifier: MIT
 *
 * subject.h - what is drawn and from where.
 */
#ifndef PHONGSPLAT_BENCH_SUBJECT_H
#define PHONGSPLAT_BENCH_SUBJECT_H

#include <phongsplat/phongsplat.h>

typedef struct subject {
    const char *name;
    psplat_asset *asset;
    double center[3], radius; /* of a ball around the splats' centres, scene space */
    double low[3], high[3];   /* of a box around them */
    size_t splat_count;
} subject;

/* A sphere of count splats in spatial order. */
subject subject_sphere(size_t count);
/* Ends the program with a message where the file cannot be opened. */
subject subject_open(const char *path);
void subject_close(subject *s);

/* The view that a square image of the subject's ball fills by 95 %, with an opening angle of 45
 * degrees, seen from the given direction; light_count white directional lights (1 ...
 * PSPLAT_MAX_LIGHTS) from around the eye, together of irradiance pi. */
psplat_view subject_view(const subject *s, const double direction[3], int size, int light_count);

#endif

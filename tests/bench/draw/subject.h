/* SPDX-License-Identifier: MIT
 *
 * subject.h - the subjects that benchmarks draw, and views of them.
 */
#ifndef PHONGSPLAT_BENCH_SUBJECT_H
#define PHONGSPLAT_BENCH_SUBJECT_H

#include <phongsplat/phongsplat.h>

typedef struct subject {
    const char *name;
    psplat_asset *asset;
    double center[3], radius; /* a sphere around the splats' centres, in scene space */
    double low[3], high[3];   /* a box around them */
    size_t splat_count;
} subject;

/* Makes a sphere of count splats in spatial order. */
subject subject_sphere(size_t count);
/* Makes one of curved splats, whose depth tolerance is a fifth of the height of each, about what it
 * is in conversions. */
subject subject_curved_sphere(size_t count);
/* Opens an asset; ends the program with a message where that fails. */
subject subject_open(const char *path);
void subject_close(subject *s);

/* Returns a view that the subject's sphere fills by 95 %: a square image with an opening angle of
 * 45 degrees, seen from the given direction. light_count white directional lights (1 ...
 * PSPLAT_MAX_LIGHTS) shine from around the eye, with a total irradiance of pi. */
psplat_view subject_view(const subject *s, const double direction[3], int size, int light_count);

#endif

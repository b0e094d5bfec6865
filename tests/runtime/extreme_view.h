/* SPDX-License-Identifier: MIT
 *
 * extreme_view.h - an extreme scene and its view, drawn by the renderer and by the reference
 * rasteriser. Include this file after cmocka.h.
 */
#ifndef PHONGSPLAT_TEST_EXTREME_VIEW_H
#define PHONGSPLAT_TEST_EXTREME_VIEW_H

#include "agreement.h"
#include "extreme.h"
#include "scene_asset.h"

#include <math.h>

typedef struct extreme {
    scene s;
    double transform[16]; /* zeros: the identity */
    psplat_view view;
} extreme;

/* Returns the scene, two-sided, seen from z = 5 along -z in 160 x 120 pixels with a focal length of
 * 120. */
static inline extreme extreme_of(scene s) {
    extreme e = {s, {0}, camera_view(160, 120)};
    e.s.material.double_sided = 1;
    e.view.lights[0].direction[0] = -1;
    camera_look(&e.view, (double[]){0, 0, 5}, (double[]){0, 0, 0});
    camera_perspective(&e.view, 120, 0.1, 20);
    return e;
}

/* The greatest differences allowed, in the units of agreement.h. Every one is checked; 0 stands for
 * the usual value named beside it. */
typedef struct extreme_bounds {
    double uv;           /* where splats show in neighbouring pixels too; 0: 5e-5 */
    double thin_uv;      /* elsewhere, where (u, v) may change by 1 or more a pixel */
    double depth;        /* 0: 1e-6; ten times as much in the other pixels */
    double color;        /* 0: 1e-4 */
    agreement_ties ties; /* zeros: as in test_agreement.c, but for closer views */
    size_t least;        /* the least number of covered and compared pixels of all modes together */
} extreme_bounds;

static inline double extreme_or(double value, double otherwise) {
    return value > 0 ? value : otherwise;
}

/* Draws every mode. */
static inline agreement extreme_measure(gpu *g, extreme *e, const agreement_ties *ties) {
    psplat_asset *asset = scene_open(&e->s);
    agreement a =
        agreement_measure_modes(g, asset, e->transform, &e->view, AGREEMENT_ALL_MODES, 1, ties);
    psplat_asset_destroy(asset);
    return a;
}

/* Draws and compares every mode, asserts the bounds and frees e's scene. */
static inline void extreme_check(gpu *g, const char *name, extreme *e, extreme_bounds bounds) {
    const agreement_ties none = {0}, usual = {2e-4, 2e-6, 0.02};
    int is_usual = memcmp(&bounds.ties, &none, sizeof none) == 0;
    agreement a = extreme_measure(g, e, is_usual ? &usual : &bounds.ties);
    scene_free(&e->s);
    double depth = extreme_or(bounds.depth, 1e-6);
    print_message("%s: %zu pixels, %zu of them not decided\n", name, a.covered, a.skipped);
    assert_true(a.covered - a.skipped >= bounds.least);
    extreme_at_most(name, (double)a.mismatches, "pixels covered by one alone", 0);
    assert_int_equal(a.other, 0);
    if (a.uv > 0 || !(bounds.thin_uv > 0))
        extreme_at_most(name, a.uv, "of a radius", extreme_or(bounds.uv, 5e-5));
    if (bounds.thin_uv > 0)
        extreme_at_most(name, a.thin_uv, "of a radius, in single pixels", bounds.thin_uv);
    assert_true(a.thin_uv <= bounds.thin_uv);
    extreme_at_most(name, a.depth, "of the depth range", depth);
    assert_true(a.thin_depth <= 10 * depth);
    extreme_at_most(name, a.color, "of white", extreme_or(bounds.color, 1e-4));
}

#endif

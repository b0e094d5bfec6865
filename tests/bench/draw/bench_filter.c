/* SPDX-License-Identifier: MIT
 *
 * bench_filter.c - compares the screen-space filter of spec 5.8 with the one of BHZK05 section 5.
 *
 *     bench_filter [--size N] [--finer N]
 *
 * Models full of detail (detail.h) are drawn N pixels across (16, 32 and 64) under a camera that
 * moves by a fraction of a pixel (film.h): by the renderer and by the papers' sprites, each with
 * its filter and without. The sprites are drawn in two methods, since the paper does not say which
 * depth its filter's disc has outside the ellipse (draw_method.h). The truth is the picture of the
 * same renderer without filter at N (8) times the size, averaged in linear light. In percent:
 *
 *     error    difference from the truth: mean, and root of the mean square
 *     flicker  how much more than in truth a pixel changes from frame to frame: mean and greatest
 *
 * "inside" compares linear values of pixels that the model fills in truth. "outline" compares the
 * coverage of the other pixels that the truth or the method covers. "covered" is the number of
 * covered pixels a frame, as a share of the truth's.
 */
#include "draw_method.h"
#include "detail.h"
#include "film.h"
#include "probe.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { METHODS = 3 }; /* the first two also draw without filter */

typedef struct detail {
    const char *name;
    scene (*make)(void);
} detail;

static const detail details[] = {{"checkered sphere", detail_checkered},
                                 {"bumpy sphere", detail_bumpy},
                                 {"torus", detail_torus},
                                 {"grazed plate", detail_plate}};

typedef struct settings {
    int sizes[3], size_count, finer;
} settings;

static void fail(const char *what, const char *why) {
    fprintf(stderr, "bench_filter: %s: %s\n", what, why);
    exit(2);
}

static settings parse(int argc, char **argv) {
    settings set = {{16, 32, 64}, 3, FILM_FINER};
    for (int i = 1; i < argc; i += 2) {
        long value = i + 1 < argc ? strtol(argv[i + 1], NULL, 10) : 0;
        if (strcmp(argv[i], "--size") == 0 && value > 0 && value <= 256) {
            set.sizes[0] = (int)value;
            set.size_count = 1;
        } else if (strcmp(argv[i], "--finer") == 0 && value > 0 && value <= 16) {
            set.finer = (int)value;
        } else {
            fail(argv[i], "unknown, or its value out of range");
        }
    }
    return set;
}

/* Compares a method with its own truth at one size. */
static void run_method(psplat_host *host, const draw_method *method, const char *model, int size,
                       int no_filter, const film *truth) {
    film f = film_shoot(host, method->draw, method->self, size, no_filter, 1);
    film_report r = film_compare(&f, truth), true_r = film_compare(truth, truth);
    printf("| %s | %d | %s%s | %.2f | %.2f | %.2f | %.1f | %.1f | %.1f | %.3f |\n", model, size,
           method->name, no_filter ? ", no filter" : "", 100 * r.inside.error,
           100 * r.inside.squared_error, 100 * r.inside.flicker, 100 * r.inside.most_flicker,
           100 * r.outline.error, 100 * r.outline.flicker, r.covered / true_r.covered);
    fflush(stdout);
    film_free(&f);
}

static void run_model(psplat_host *host, const detail *d, const settings *set) {
    scene s = d->make();
    subject drawn = {.name = d->name, .asset = scene_open(&s)};
    draw_method methods[METHODS] = {draw_method_splats(host, &drawn, 0),
                                    draw_method_sprites(host, &drawn, 0),
                                    draw_method_sprites_plane(host, &drawn, 0)};
    for (int i = 0; i < set->size_count; ++i)
        for (int k = 0; k < METHODS; ++k) {
            const draw_method *method = &methods[k];
            film truth = film_shoot(host, method->draw, method->self, set->sizes[i], 1, set->finer);
            run_method(host, method, d->name, set->sizes[i], 0, &truth);
            if (k < 2) run_method(host, method, d->name, set->sizes[i], 1, &truth);
            film_free(&truth);
        }
    for (int k = 0; k < METHODS; ++k) draw_method_destroy(&methods[k]);
    psplat_asset_destroy(drawn.asset);
    scene_free(&s);
}

int main(int argc, char **argv) {
    settings set = parse(argc, argv);
    psplat_host *host = NULL;
    psplat_error error;
    if (psplat_host_create(PSPLAT_API_GL, 1, &host, &error)) fail("host", error.text);
    probe_open(host);
    printf("%s; truth of %d x %d samples a pixel; percent\n\n", psplat_host_renderer(host),
           set.finer, set.finer);
    printf("| model | pixels | who | inside: error | rms | flicker | most | outline: error | "
           "flicker | covered |\n"
           "|---|--:|---|--:|--:|--:|--:|--:|--:|--:|\n");
    for (size_t i = 0; i < sizeof details / sizeof *details; ++i)
        run_model(host, &details[i], &set);
    probe_close();
    psplat_host_destroy(host);
    return 0;
}

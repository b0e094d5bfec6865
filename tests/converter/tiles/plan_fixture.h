/* SPDX-License-Identifier: MIT
 *
 * plan_fixture.h - a directory of a test's own for a source and the plan of it. Include it after
 * cmocka.h, with _XOPEN_SOURCE 700 for nftw.
 */
#ifndef PHONGSPLAT_TESTS_PLAN_FIXTURE_H
#define PHONGSPLAT_TESTS_PLAN_FIXTURE_H

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "mesh/mesh.h"

/* A directory, and in it the paths of a source and of a plan. */
typedef struct plan_place {
    char directory[64], input[80], output[80];
} plan_place;

static inline void plan_place_make(plan_place *place) {
    strcpy(place->directory, "/tmp/phongsplat-plan-XXXXXX");
    assert_non_null(mkdtemp(place->directory));
    snprintf(place->input, sizeof place->input, "%s/source.stl", place->directory);
    snprintf(place->output, sizeof place->output, "%s/out", place->directory);
}

static inline int plan_remove_entry(const char *path, const struct stat *status, int kind,
                                    struct FTW *at) {
    (void)status;
    (void)kind;
    (void)at;
    return remove(path);
}

/* Removes the directory with all that is in it. */
static inline void plan_place_remove(plan_place *place) {
    if (*place->directory) nftw(place->directory, plan_remove_entry, 16, FTW_DEPTH | FTW_PHYS);
    *place->directory = 0;
}

/* Writes a mesh as binary STL, whose numbers are single precision. */
static inline void plan_write_stl(const psplat_mesh *mesh, const char *path) {
    const char head[80] = "a source of tiles";
    uint32_t count = (uint32_t)mesh->triangle_count;
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fwrite(head, 1, sizeof head, file);
    fwrite(&count, sizeof count, 1, file);
    for (uint32_t t = 0; t < count; ++t) {
        float numbers[12] = {0};
        for (int i = 0; i < 9; ++i)
            numbers[3 + i] =
                (float)(psplat_mesh_corner(mesh, t, i / 3)[i % 3] + mesh->origin[i % 3]);
        fwrite(numbers, sizeof *numbers, 12, file);
        fwrite("\0", 1, 2, file);
    }
    assert_int_equal(fclose(file), 0);
}

#endif

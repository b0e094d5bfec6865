/* SPDX-License-Identifier: MIT
 *
 * mesh_fixture.h - a temporary directory for one test, files written into it, and meshes read from
 * them.
 */
#ifndef PHONGSPLAT_TESTS_MESH_FIXTURE_H
#define PHONGSPLAT_TESTS_MESH_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "near.h"

static char fixture_directory[256];
static char fixture_path[512];

static inline int make_directory(void **state) {
    (void)state;
    const char *parent = getenv("TMPDIR");
    snprintf(fixture_directory, sizeof fixture_directory, "%s/psplat-mesh-XXXXXX",
             parent && strlen(parent) < 200 ? parent : "/tmp");
    return mkdtemp(fixture_directory) ? 0 : -1;
}

static inline int remove_directory(void **state) {
    (void)state;
    return rmdir(fixture_directory);
}

/* Writes a file of this name, and leaves its path in fixture_path. */
static inline void write_bytes(const char *name, const void *data, size_t size) {
    snprintf(fixture_path, sizeof fixture_path, "%s/%s", fixture_directory, name);
    FILE *file = fopen(fixture_path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static inline psplat_mesh read_bytes(const char *name, const void *data, size_t size) {
    psplat_mesh mesh;
    psplat_error error = {0};
    write_bytes(name, data, size);
    psplat_result result = psplat_mesh_read(fixture_path, &mesh, &error);
    unlink(fixture_path);
    if (result) fail_msg("%s", error.text);
    return mesh;
}

static inline psplat_mesh read_text(const char *name, const char *text) {
    return read_bytes(name, text, strlen(text));
}

/* Asserts that reading the bytes fails with this code, and that the error text names the file, then
 * the place, then the cause. */
static inline void refuse_bytes(const char *name, const void *data, size_t size, psplat_result code,
                                const char *cause) {
    psplat_mesh mesh;
    psplat_error error = {0};
    write_bytes(name, data, size);
    psplat_result result = psplat_mesh_read(fixture_path, &mesh, &error);
    unlink(fixture_path);
    if (result != code || error.code != code)
        fail_msg("%s: result %d instead of %d: %s", name, (int)result, (int)code, error.text);
    if (strncmp(error.text, fixture_path, strlen(fixture_path)) != 0)
        fail_msg("the text does not begin with the path: %s", error.text);
    if (!strstr(error.text + strlen(fixture_path), cause))
        fail_msg("no '%s' in: %s", cause, error.text);
    assert_null(strchr(error.text, '\n'));
    /* A failed read must not leave a mesh behind. */
    assert_null(mesh.positions);
    assert_null(mesh.triangles);
}

static inline void refuse_text(const char *name, const char *text, psplat_result code,
                               const char *cause) {
    refuse_bytes(name, text, strlen(text), code, cause);
}

/* Returns six times the volume that the triangles enclose; it is positive where they face outwards.
 */
static inline double signed_volume(const psplat_mesh *mesh) {
    double sum = 0;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const double *a = mesh->positions + (size_t)mesh->triangles[t * 3] * 3;
        const double *b = mesh->positions + (size_t)mesh->triangles[t * 3 + 1] * 3;
        const double *c = mesh->positions + (size_t)mesh->triangles[t * 3 + 2] * 3;
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum;
}

#endif

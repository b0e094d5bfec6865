/* SPDX-License-Identifier: MIT
 *
 * mesh_input.c - files whose content is the fuzz input, and the promises of psplat_mesh_read; see
 * mesh_input.h.
 */
#include "mesh_input.h"

#include "import/read_mesh.h"
#include "import/read_scene.h"
#include "mesh/mesh.h"
#include "points/points.h"
#include "scene/scene.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const uint8_t *input;
static size_t input_size;

/* ---- files -------------------------------------------------------------------------------- */

/* These names are prescribed by the linker (--wrap). */
psplat_result __wrap_psplat_file_read(const char *path, char **data, size_t *size,
                                      psplat_error *error);

/* Every file is the input, except those whose name begins with r. */
psplat_result __wrap_psplat_file_read(const char *path, char **data, size_t *size,
                                      psplat_error *error) {
    const char *slash = strrchr(path, '/');
    FUZZ_DEMAND(!strstr(path, "/../"));
    if (slash && slash[1] == 'r')
        return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s: cannot be read", "input");
    char *copy = malloc(input_size + 1);
    if (!copy) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    memcpy(copy, input, input_size);
    copy[input_size] = 0;
    *data = copy;
    *size = input_size;
    return PSPLAT_OK;
}

/* ---- points -------------------------------------------------------------------------------- */

psplat_result __wrap_psplat_mesh_from_points(const psplat_points *points, psplat_mesh *mesh,
                                             psplat_error *error);

psplat_result __wrap_psplat_mesh_from_points(const psplat_points *points, psplat_mesh *mesh,
                                             psplat_error *error) {
    *mesh = (psplat_mesh){0};
    for (size_t i = 0; i < 3 * points->count; ++i) FUZZ_DEMAND(isfinite(points->positions[i]));
    for (size_t i = 0; i < 4 * points->count && points->colors; ++i)
        FUZZ_DEMAND(points->colors[i] >= 0 && points->colors[i] <= 1);
    /* Normals may have any length, also zero, but must be readable. */
    float sum = 0;
    for (size_t i = 0; i < 3 * points->count && points->normals; ++i) sum += points->normals[i];
    return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "%zu points of sum %g", points->count,
                       (double)sum);
}

/* ---- promises ----------------------------------------------------------------------------- */

/* The box of a mesh is centred on the origin, up to the rounding of one subtraction from the
 * earlier coordinates and of denormal numbers. The vertices of a point set are some of its
 * points. */
static void check_positions(const psplat_mesh *mesh) {
    double low[3] = {0, 0, 0}, high[3] = {0, 0, 0};
    for (size_t i = 0; i < 3 * mesh->vertex_count; ++i) {
        double value = mesh->positions[i];
        FUZZ_DEMAND(isfinite(value));
        if (i < 3 || value < low[i % 3]) low[i % 3] = value;
        if (i < 3 || value > high[i % 3]) high[i % 3] = value;
    }
    for (int k = 0; k < 3; ++k) {
        double size = fmax(high[k] - low[k], fabs(mesh->origin[k]));
        FUZZ_DEMAND(isfinite(mesh->origin[k]));
        FUZZ_DEMAND(mesh->points || fabs(high[k] + low[k]) <= 1e-12 * size + DBL_MIN);
    }
}

/* Every vertex belongs to a triangle. */
static void check_used(const psplat_mesh *mesh) {
    char *used = calloc(mesh->vertex_count, 1);
    if (!used) return;
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) used[mesh->triangles[i]] = 1;
    for (size_t i = 0; i < mesh->vertex_count; ++i) FUZZ_DEMAND(used[i]);
    free(used);
}

static int compare_positions(const void *a, const void *b) {
    const double *p = a, *q = b;
    for (int k = 0; k < 3; ++k)
        if (p[k] != q[k]) return p[k] < q[k] ? -1 : 1;
    return 0;
}

static void check_welded(const psplat_mesh *mesh) {
    size_t count = mesh->vertex_count;
    double *sorted = malloc((count + 1) * 3 * sizeof *sorted);
    if (!sorted) return;
    memcpy(sorted, mesh->positions, count * 3 * sizeof *sorted);
    qsort(sorted, count, 3 * sizeof *sorted, compare_positions);
    for (size_t i = 1; i < count; ++i)
        FUZZ_DEMAND(compare_positions(sorted + 3 * i - 3, sorted + 3 * i));
    free(sorted);
}

static void check_corners(const psplat_mesh *mesh) {
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *v = mesh->triangles + 3 * t;
        for (int k = 0; k < 3; ++k) FUZZ_DEMAND(v[k] < mesh->vertex_count);
        FUZZ_DEMAND(v[0] != v[1] && v[1] != v[2] && v[2] != v[0]);
    }
    for (size_t i = 0; mesh->corner_normals && i < 3 * mesh->triangle_count; ++i) {
        const float *n = mesh->corner_normals + 3 * i;
        double length = sqrt((double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] +
                             (double)n[2] * (double)n[2]);
        FUZZ_DEMAND(length == 0 || fabs(length - 1) < 1e-6); /* the rounding of single precision */
    }
    for (size_t i = 0; mesh->corner_colors && i < 12 * mesh->triangle_count; ++i)
        FUZZ_DEMAND(mesh->corner_colors[i] >= 0 && mesh->corner_colors[i] <= 1);
}

static void check_material(const psplat_material *material) {
    for (int k = 0; k < 4; ++k)
        FUZZ_DEMAND(material->base_color[k] >= 0 && material->base_color[k] <= 1);
    for (int k = 0; k < 3; ++k)
        FUZZ_DEMAND(material->emissive[k] >= 0 && isfinite(material->emissive[k]));
    FUZZ_DEMAND(material->metallic >= 0 && material->metallic <= 1);
    FUZZ_DEMAND(material->roughness >= 0 && material->roughness <= 1);
}

void fuzz_check_mesh(const psplat_mesh *mesh) {
    FUZZ_DEMAND(mesh->vertex_count >= 3 && mesh->triangle_count >= 1);
    check_positions(mesh);
    check_corners(mesh);
    if (!mesh->points) {
        check_welded(mesh);
        check_used(mesh);
    }
    FUZZ_DEMAND(!mesh->points == !mesh->point_count);
    for (size_t i = 0; i < 3 * mesh->point_count; ++i) FUZZ_DEMAND(isfinite(mesh->points[i]));
    for (size_t i = 0; i < mesh->point_count; ++i)
        FUZZ_DEMAND(mesh->point_triangles[i] < mesh->triangle_count);
}

/* ---- reading ------------------------------------------------------------------------------ */

static void check_error(psplat_result result, const psplat_error *error) {
    FUZZ_DEMAND(error->code == result && error->text[0] && error->offset <= input_size);
    FUZZ_DEMAND(result != PSPLAT_ERROR_ARGUMENT && result != PSPLAT_ERROR_MEMORY);
    FUZZ_DEMAND(!strpbrk(error->text, "\r\n"));
}

static psplat_result read_as(const char *name, void (*use)(const psplat_mesh *mesh)) {
    psplat_mesh mesh;
    psplat_error error = {0};
    psplat_result result = psplat_mesh_read(name, &mesh, &error);
    if (result) {
        check_error(result, &error);
        return result;
    }
    fuzz_check_mesh(&mesh);
    check_material(&mesh.material);
    if (use) use(&mesh);
    psplat_mesh_free(&mesh);
    return result;
}

void fuzz_read_mesh(const uint8_t *data, size_t size, void (*use)(const psplat_mesh *mesh)) {
    static const char *const names[] = {"input.obj", "input.stl", "input.xyz"};
    fuzz_meter meter = {0};
    input = data;
    input_size = size;
    fuzz_meter_start(&meter);
    psplat_result result = read_as("input", use);
    for (size_t i = 0; i < 3 && result == PSPLAT_ERROR_UNSUPPORTED && size < 256; ++i)
        read_as(names[i], use);
    fuzz_meter_stop(&meter, 2.0);
}

void fuzz_read_scene(const uint8_t *data, size_t size, void (*use)(const psplat_scene *scene)) {
    fuzz_meter meter = {0};
    psplat_scene scene;
    psplat_error error = {0};
    input = data;
    input_size = size;
    fuzz_meter_start(&meter);
    psplat_result result = psplat_scene_read("input", NULL, &scene, &error);
    if (result) {
        check_error(result, &error);
    } else {
        for (size_t i = 0; i < scene.mesh_count; ++i)
            if (scene.meshes[i].mesh.triangle_count) fuzz_check_mesh(&scene.meshes[i].mesh);
        use(&scene);
        psplat_scene_free(&scene);
    }
    fuzz_meter_stop(&meter, 2.0);
}

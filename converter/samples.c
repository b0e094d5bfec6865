/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * samples.c - oriented points of a surface.
 *
 * CGAL's random points of each triangle are thinned to blue noise (dart throwing: a sample stays if
 * none of its patch is within the spacing), which halves the gaps of random points at an equal
 * count. Creases get samples of their own, one row for each side, so that splats reach up to them.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Random points offered for each that stays; 5 leaves gaps under 1.3 spacings on a plane. */
static const double offered = 5;
/* Cosine between faces up to which one sample stands for both: not around the tip of a cone. */
static const double alike = 0.5;

typedef struct sample_buffer {
    psplat_samples samples;
    size_t capacity;
} sample_buffer;

/* Makes room in one array, which stays as it is where that fails. */
static int grow(float **values, size_t capacity, size_t components) {
    float *grown = realloc(*values, capacity * components * sizeof *grown);
    if (grown) *values = grown;
    return grown != NULL;
}

static int buffer_reserve(sample_buffer *buffer, size_t count, const psplat_paint *paint) {
    psplat_samples *s = &buffer->samples;
    if (count <= buffer->capacity && s->positions) return 1;
    size_t capacity = count + buffer->capacity / 2 + 64;
    double *positions = realloc(s->positions, capacity * 3 * sizeof *positions);
    if (positions) s->positions = positions;
    uint32_t *triangles = realloc(s->triangles, capacity * sizeof *triangles);
    if (triangles) s->triangles = triangles;
    int ok = positions && triangles && grow(&s->normals, capacity, 3);
    if (ok && paint && paint->has_color) ok = grow(&s->colors, capacity, 4);
    if (ok && paint && paint->has_normals) ok = grow(&s->turned, capacity, 3);
    if (ok && paint && paint->has_finish) ok = grow(&s->finishes, capacity, 3);
    if (ok && paint && paint->has_emissive) ok = grow(&s->emissive, capacity, 3);
    if (ok) buffer->capacity = capacity;
    return ok;
}

static const double *vertex(const psplat_mesh *mesh, uint32_t triangle, uint32_t corner) {
    return mesh->positions + 3 * (size_t)mesh->triangles[3 * (size_t)triangle + corner];
}

static void put(float *values, size_t index, size_t components, const float *value) {
    if (values) memcpy(values + index * components, value, components * sizeof *value);
}

static int buffer_push(sample_buffer *buffer, const psplat_surface *surface, uint32_t triangle,
                       const double p[3]) {
    psplat_samples *s = &buffer->samples;
    if (s->count == PSPLAT_NONE) return 0; /* indices of samples have 32 bits */
    if (!buffer_reserve(buffer, s->count + 1, surface->paint)) return 0;
    double weights[3];
    size_t index = s->count++;
    psplat_surface_barycentric(surface, triangle, p, weights);
    memcpy(s->positions + 3 * index, p, 3 * sizeof(double));
    psplat_surface_normal(surface, triangle, weights, s->normals + 3 * index);
    s->triangles[index] = triangle;
    if (!s->colors && !s->turned && !s->finishes && !s->emissive) return 1;
    psplat_shade shade;
    psplat_paint_shade(surface->paint, triangle, weights, s->normals + 3 * index, &shade);
    put(s->colors, index, 4, shade.color);
    put(s->turned, index, 3, shade.normal);
    put(s->finishes, index, 3, shade.finish);
    put(s->emissive, index, 3, shade.emissive);
    return 1;
}

/* ---- thinning ----------------------------------------------------------------------------- */

/* Hash grid over the samples accepted so far; chains end with PSPLAT_NONE. */
typedef struct thin_grid {
    uint32_t *heads, *nexts;
    size_t mask, capacity;
    double cell;
} thin_grid;

static int grid_create(thin_grid *grid, size_t expected, double cell) {
    size_t size = 1024;
    while (size < 2 * expected) size *= 2;
    *grid = (thin_grid){.mask = size - 1, .cell = cell};
    grid->heads = malloc(size * sizeof(uint32_t));
    if (!grid->heads) return 0;
    memset(grid->heads, 0xff, size * sizeof(uint32_t));
    return 1;
}

static void grid_free(thin_grid *grid) {
    free(grid->heads);
    free(grid->nexts);
}

static size_t grid_slot(const thin_grid *grid, const int64_t cell[3]) {
    uint64_t h = (uint64_t)cell[0] * 0x8da6b343u ^ (uint64_t)cell[1] * 0xd8163841u ^
                 (uint64_t)cell[2] * 0xcb1ab31fu;
    return (size_t)(h ^ (h >> 29)) & grid->mask;
}

static void grid_cell(const thin_grid *grid, const double p[3], int64_t cell[3]) {
    for (int k = 0; k < 3; ++k) cell[k] = (int64_t)floor(p[k] / grid->cell);
}

static int grid_add(thin_grid *grid, const psplat_samples *samples, uint32_t index) {
    if (index >= grid->capacity) {
        size_t capacity = 2 * (size_t)index + 1024;
        uint32_t *nexts = realloc(grid->nexts, capacity * sizeof *nexts);
        if (!nexts) return 0;
        grid->nexts = nexts;
        grid->capacity = capacity;
    }
    int64_t cell[3];
    grid_cell(grid, samples->positions + 3 * (size_t)index, cell);
    size_t slot = grid_slot(grid, cell);
    grid->nexts[index] = grid->heads[slot];
    grid->heads[slot] = index;
    return 1;
}

/* Whether an accepted sample of the same patch and side lies within radius (at most a cell). */
static int grid_crowded(const thin_grid *grid, const psplat_surface *surface,
                        const psplat_samples *samples, const double p[3], uint32_t triangle,
                        double radius) {
    int64_t base[3], cell[3];
    grid_cell(grid, p, base);
    const double *normal = surface->face_normals + 3 * (size_t)triangle;
    for (int n = 0; n < 27; ++n) {
        cell[0] = base[0] + n % 3 - 1, cell[1] = base[1] + n / 3 % 3 - 1,
        cell[2] = base[2] + n / 9 - 1;
        for (uint32_t i = grid->heads[grid_slot(grid, cell)]; i != PSPLAT_NONE;
             i = grid->nexts[i]) {
            uint32_t other = samples->triangles[i];
            double d[3];
            sub3(d, samples->positions + 3 * (size_t)i, p);
            if (dot3(d, d) < radius * radius &&
                surface->patches[other] == surface->patches[triangle] &&
                dot3(normal, surface->face_normals + 3 * (size_t)other) > alike)
                return 1;
        }
    }
    return 0;
}

/* ---- drawing ------------------------------------------------------------------------------ */

static int offer(sample_buffer *buffer, thin_grid *grid, const psplat_surface *surface,
                 uint32_t triangle, const double p[3], double radius) {
    if (grid_crowded(grid, surface, &buffer->samples, p, triangle, radius)) return 1;
    return buffer_push(buffer, surface, triangle, p) &&
           grid_add(grid, &buffer->samples, (uint32_t)(buffer->samples.count - 1));
}

/* Samples along crease edge k of a triangle, its first vertex included. */
static int offer_crease(sample_buffer *buffer, thin_grid *grid, const psplat_surface *surface,
                        uint32_t triangle, uint32_t k, double spacing) {
    const double *a = vertex(surface->mesh, triangle, k);
    const double *b = vertex(surface->mesh, triangle, (k + 1) % 3);
    double edge[3];
    sub3(edge, b, a);
    size_t steps = (size_t)ceil(length3(edge) / spacing) + 1;
    for (size_t i = 0; i <= steps; ++i) {
        double p[3];
        for (int c = 0; c < 3; ++c) p[c] = a[c] + edge[c] * (double)i / (double)steps;
        if (!offer(buffer, grid, surface, triangle, p, 0.7 * spacing)) return 0;
    }
    return 1;
}

static int offer_creases(sample_buffer *buffer, thin_grid *grid, const psplat_surface *surface,
                         double spacing) {
    for (uint32_t e = 0; e < 3 * surface->mesh->triangle_count; ++e)
        if (surface->creases[e] && !offer_crease(buffer, grid, surface, e / 3, e % 3, spacing))
            return 0;
    return 1;
}

/* A patch without creases that is much smaller than the spacing may have got none: it gets one, in
 * the middle of its first triangle. */
static int offer_missed(sample_buffer *buffer, const psplat_surface *surface) {
    uint8_t *seen = calloc(surface->patch_count + 1, 1);
    if (!seen) return 0;
    for (size_t i = 0; i < buffer->samples.count; ++i)
        seen[surface->patches[buffer->samples.triangles[i]]] = 1;
    int ok = 1;
    for (uint32_t t = 0; ok && t < surface->mesh->triangle_count; ++t) {
        if (seen[surface->patches[t]]) continue;
        seen[surface->patches[t]] = 1;
        double middle[3] = {0, 0, 0};
        for (uint32_t k = 0; k < 3; ++k) mad3(middle, 1.0 / 3, vertex(surface->mesh, t, k));
        ok = buffer_push(buffer, surface, t, middle);
    }
    free(seen);
    return ok;
}

/* The vertices of a coarse mesh, where it sticks out most between samples. */
static int offer_vertices(sample_buffer *buffer, thin_grid *grid, const psplat_surface *surface,
                          double spacing, double expected) {
    const psplat_mesh *mesh = surface->mesh;
    if ((double)mesh->vertex_count > expected) return 1;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t)
        for (uint32_t k = 0; k < 3; ++k)
            if (!offer(buffer, grid, surface, t, vertex(mesh, t, k), spacing)) return 0;
    return 1;
}

/* The points of a point set, thinned as other samples are. */
static int offer_points(sample_buffer *buffer, thin_grid *grid, const psplat_surface *surface,
                        double spacing) {
    const psplat_mesh *mesh = surface->mesh;
    for (size_t i = 0; i < mesh->point_count; ++i)
        if (!offer(buffer, grid, surface, mesh->point_triangles[i], mesh->points + 3 * i, spacing))
            return 0;
    return 1;
}

/* The points of a point set, or about `most` of them where there are more. */
static int push_points(sample_buffer *buffer, const psplat_surface *surface, size_t most,
                       uint64_t seed) {
    const psplat_mesh *mesh = surface->mesh;
    double part = (double)most / (double)(mesh->point_count + 1);
    for (size_t i = 0; i < mesh->point_count; ++i)
        if (psplat_random_unit(&seed) < part &&
            !buffer_push(buffer, surface, mesh->point_triangles[i], mesh->points + 3 * i))
            return 0;
    return 1;
}

typedef int take_points(void *user, uint32_t triangle, const double *points, size_t count);

/* Hands about `total` uniform random points of the surface to take, triangle by triangle: each gets
 * its share of the running area, rounded with one random offset. */
static int throw_points(const psplat_surface *surface, double total, uint64_t seed,
                        take_points *take, void *user) {
    double *points = NULL, area = 0, offset = psplat_random_unit(&seed);
    size_t capacity = 0;
    int ok = 1;
    for (uint32_t t = 0; ok && t < surface->mesh->triangle_count; ++t) {
        double before = floor(area / surface->area * total + offset);
        area += surface->face_areas[t];
        double after = floor(area / surface->area * total + offset);
        size_t count = after > before ? (size_t)(after - before) : 0;
        if (!count) continue;
        if (count > capacity) {
            double *grown = realloc(points, count * 3 * sizeof(double));
            if (!grown) {
                ok = 0;
                break;
            }
            points = grown;
            capacity = count;
        }
        uint32_t stream = (uint32_t)(psplat_random_next(&seed) >> 33);
        ok = !psplat_cgal_triangle_points(vertex(surface->mesh, t, 0), vertex(surface->mesh, t, 1),
                                          vertex(surface->mesh, t, 2), count, stream, points) &&
             take(user, t, points, count);
    }
    free(points);
    return ok;
}

typedef struct thinning {
    sample_buffer *buffer;
    thin_grid grid;
    const psplat_surface *surface;
    double spacing;
} thinning;

static int take_thinned(void *user, uint32_t triangle, const double *points, size_t count) {
    thinning *t = user;
    for (size_t i = 0; i < count; ++i)
        if (!offer(t->buffer, &t->grid, t->surface, triangle, points + 3 * i, t->spacing)) return 0;
    return 1;
}

static int take_all(void *user, uint32_t triangle, const double *points, size_t count) {
    thinning *t = user;
    for (size_t i = 0; i < count; ++i)
        if (!buffer_push(t->buffer, t->surface, triangle, points + 3 * i)) return 0;
    return 1;
}

/* ---- grouping ----------------------------------------------------------------------------- */

/* Lists the samples of each triangle, in their order. */
static int group(psplat_samples *s, size_t triangle_count) {
    free(s->first);
    free(s->order);
    s->first = calloc(triangle_count + 2, sizeof *s->first);
    s->order = malloc((s->count + 1) * sizeof *s->order);
    if (!s->first || !s->order) return 0;
    uint32_t *starts = s->first + 1; /* shifted by one, so that filling leaves first right */
    for (size_t i = 0; i < s->count; ++i) starts[s->triangles[i] + 1]++;
    for (size_t t = 0; t < triangle_count; ++t) starts[t + 1] += starts[t];
    for (uint32_t i = 0; i < s->count; ++i) s->order[starts[s->triangles[i]]++] = i;
    return 1;
}

static psplat_result finish(sample_buffer *buffer, int ok, const psplat_surface *surface,
                            psplat_samples *samples, psplat_error *error) {
    if (ok) ok = group(&buffer->samples, surface->mesh->triangle_count);
    *samples = buffer->samples;
    if (ok) return PSPLAT_OK;
    psplat_samples_free(samples);
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "the samples do not fit into memory");
}

psplat_result psplat_samples_draw(const psplat_surface *surface, double spacing, uint64_t seed,
                                  psplat_samples *samples, psplat_error *error) {
    sample_buffer buffer = {.samples = {.spacing = spacing}};
    thinning thin = {.buffer = &buffer, .surface = surface, .spacing = spacing};
    double expected = surface->area / (spacing * spacing);
    /* Also where an area of 0 over a spacing of 0 is no number. */
    if (!(expected < (double)PSPLAT_NONE))
        return *samples = buffer.samples,
               psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "%.3g samples are needed; the tolerance is too small", expected);
    int ok = grid_create(&thin.grid, (size_t)expected, spacing) &&
             buffer_reserve(&buffer, (size_t)expected, surface->paint) &&
             offer_creases(&buffer, &thin.grid, surface, spacing / 2) &&
             offer_vertices(&buffer, &thin.grid, surface, spacing / 4, expected) &&
             offer_points(&buffer, &thin.grid, surface, spacing) &&
             throw_points(surface, offered * expected, seed, take_thinned, &thin) &&
             offer_missed(&buffer, surface);
    grid_free(&thin.grid);
    return finish(&buffer, ok, surface, samples, error);
}

psplat_result psplat_samples_draw_uniform(const psplat_surface *surface, size_t count,
                                          uint64_t seed, psplat_samples *samples,
                                          psplat_error *error) {
    sample_buffer buffer = {0};
    thinning all = {.buffer = &buffer, .surface = surface};
    int ok = push_points(&buffer, surface, count, seed) &&
             throw_points(surface, (double)count, seed, take_all, &all);
    return finish(&buffer, ok, surface, samples, error);
}

psplat_result psplat_samples_append(psplat_samples *samples, const psplat_surface *surface,
                                    const double *points, const uint32_t *triangles, size_t count,
                                    psplat_error *error) {
    sample_buffer buffer = {.samples = *samples};
    int ok = count < PSPLAT_NONE - samples->count &&
             buffer_reserve(&buffer, samples->count + count, surface->paint);
    for (size_t i = 0; ok && i < count; ++i)
        ok = buffer_push(&buffer, surface, triangles[i], points + 3 * i);
    if (ok) ok = group(&buffer.samples, surface->mesh->triangle_count);
    *samples = buffer.samples;
    if (ok) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "the samples do not fit into memory");
}

void psplat_samples_free(psplat_samples *samples) {
    free(samples->positions);
    free(samples->normals);
    free(samples->colors);
    free(samples->turned);
    free(samples->finishes);
    free(samples->emissive);
    free(samples->triangles);
    free(samples->first);
    free(samples->order);
    *samples = (psplat_samples){0};
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * samples.c - oriented sample points of a surface: blue noise (Poisson disc) or uniform random.
 *
 * Random points of the triangles are thinned by dart throwing: a point becomes a sample if no
 * sample of its patch is within the spacing. At an equal count this halves the gaps of random
 * points. Creases get rows of samples of their own, one for each side, so that splats reach up to
 * them.
 */
#include "features/samples.h"

#include "appearance/appearance.h"
#include "base/morton.h"
#include "base/random.h"
#include "base/vector.h"
#include "features/surface.h"
#include "features/triangle_points.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The random points that are thrown for each sample that is expected. 5 leaves gaps of less than
 * 1.3 spacings on a plane. */
static const double darts_per_sample = 5;
/* The least cosine between the normals of two triangles of which one sample can stand for the
 * other. Around the tip of a cone it cannot. Chosen by hand. */
static const double same_side_cosine = 0.5;

typedef struct sample_buffer {
    psplat_samples samples;
    size_t capacity;
} sample_buffer;

/* Makes room in one array, which stays as it is on failure. Returns 0 then. */
static int grow(float **values, size_t capacity, size_t components) {
    float *grown = realloc(*values, capacity * components * sizeof *grown);
    if (grown) *values = grown;
    return grown != NULL;
}

static int buffer_reserve(sample_buffer *buffer, size_t count,
                          const psplat_appearance *appearance) {
    psplat_samples *s = &buffer->samples;
    if (count <= buffer->capacity && s->positions) return 1;
    size_t capacity = count + buffer->capacity / 2 + 64;
    double *positions = realloc(s->positions, capacity * 3 * sizeof *positions);
    if (positions) s->positions = positions;
    uint32_t *triangles = realloc(s->triangles, capacity * sizeof *triangles);
    if (triangles) s->triangles = triangles;
    int ok = positions && triangles && grow(&s->normals, capacity, 3);
    if (ok && appearance && appearance->has_color) ok = grow(&s->colors, capacity, 4);
    if (ok && appearance && appearance->has_normals) ok = grow(&s->turned, capacity, 3);
    if (ok && appearance && appearance->has_finish) ok = grow(&s->finishes, capacity, 3);
    if (ok && appearance && appearance->has_emissive) ok = grow(&s->emissive, capacity, 3);
    if (ok && appearance && appearance->kept) ok = grow(&s->texcoords, capacity, 2);
    if (ok) buffer->capacity = capacity;
    return ok;
}

static const double *vertex_position(const psplat_mesh *mesh, uint32_t triangle, uint32_t corner) {
    return mesh->positions + 3 * (size_t)mesh->triangles[3 * (size_t)triangle + corner];
}

static void store(float *values, size_t index, size_t components, const float *value) {
    if (values) memcpy(values + index * components, value, components * sizeof *value);
}

/* Appends a sample at a point of a triangle, with normal and baked values. Returns 0 on failure. */
static int buffer_push(sample_buffer *buffer, const psplat_surface *surface, uint32_t triangle,
                       const double p[3]) {
    psplat_samples *s = &buffer->samples;
    if (s->count == PSPLAT_NONE) return 0; /* indices of samples have 32 bits */
    if (!buffer_reserve(buffer, s->count + 1, surface->appearance)) return 0;
    double weights[3];
    size_t index = s->count++;
    psplat_surface_barycentric(surface, triangle, p, weights);
    memcpy(s->positions + 3 * index, p, 3 * sizeof(double));
    psplat_surface_normal(surface, triangle, weights, s->normals + 3 * index);
    s->triangles[index] = triangle;
    if (s->texcoords) psplat_surface_texcoord(surface, triangle, weights, s->texcoords + 2 * index);
    if (!s->colors && !s->turned && !s->finishes && !s->emissive) return 1;
    psplat_baked_point shade;
    psplat_appearance_bake(surface->appearance, triangle, weights, s->normals + 3 * index, &shade);
    store(s->colors, index, 4, shade.color);
    store(s->turned, index, 3, shade.normal);
    store(s->finishes, index, 3, shade.finish);
    store(s->emissive, index, 3, shade.emissive);
    return 1;
}

/* ---- thinning ----------------------------------------------------------------------------- */

/* A hash grid over the samples accepted so far. Chains end with PSPLAT_NONE. */
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

/* Returns whether an accepted sample of the same patch and side is within radius (at most a cell).
 */
static int grid_has_near(const thin_grid *grid, const psplat_surface *surface,
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
                dot3(normal, surface->face_normals + 3 * (size_t)other) > same_side_cosine)
                return 1;
        }
    }
    return 0;
}

/* ---- drawing ------------------------------------------------------------------------------ */

/* Makes a point a sample unless another is within radius. Returns 0 on failure, as all functions
 * below do. */
static int throw_dart(sample_buffer *buffer, thin_grid *grid, const psplat_surface *surface,
                      uint32_t triangle, const double p[3], double radius) {
    if (grid_has_near(grid, surface, &buffer->samples, p, triangle, radius)) return 1;
    return buffer_push(buffer, surface, triangle, p) &&
           grid_add(grid, &buffer->samples, (uint32_t)(buffer->samples.count - 1));
}

/* Samples crease edge k of a triangle on the side of the triangle, both ends included. */
static int sample_crease_edge(sample_buffer *buffer, thin_grid *grid, const psplat_surface *surface,
                              uint32_t triangle, uint32_t k, double spacing) {
    const double *a = vertex_position(surface->mesh, triangle, k);
    const double *b = vertex_position(surface->mesh, triangle, (k + 1) % 3);
    double edge[3];
    sub3(edge, b, a);
    size_t steps = (size_t)ceil(length3(edge) / spacing) + 1;
    for (size_t i = 0; i <= steps; ++i) {
        double p[3];
        for (int c = 0; c < 3; ++c) p[c] = a[c] + edge[c] * (double)i / (double)steps;
        if (!throw_dart(buffer, grid, surface, triangle, p, 0.7 * spacing)) return 0;
    }
    return 1;
}

static int sample_creases(sample_buffer *buffer, thin_grid *grid, const psplat_surface *surface,
                          double spacing) {
    for (uint32_t e = 0; e < 3 * surface->mesh->triangle_count; ++e)
        if (surface->creases[e] &&
            !sample_crease_edge(buffer, grid, surface, e / 3, e % 3, spacing))
            return 0;
    return 1;
}

/* Gives each patch without samples one in the middle of its first triangle. Patches much smaller
 * than the spacing may have got none. */
static int sample_empty_patches(sample_buffer *buffer, const psplat_surface *surface) {
    uint8_t *seen = calloc(surface->patch_count + 1, 1);
    if (!seen) return 0;
    for (size_t i = 0; i < buffer->samples.count; ++i)
        seen[surface->patches[buffer->samples.triangles[i]]] = 1;
    int ok = 1;
    for (uint32_t t = 0; ok && t < surface->mesh->triangle_count; ++t) {
        if (seen[surface->patches[t]]) continue;
        seen[surface->patches[t]] = 1;
        double middle[3] = {0, 0, 0};
        for (uint32_t k = 0; k < 3; ++k)
            mad3(middle, 1.0 / 3, vertex_position(surface->mesh, t, k));
        ok = buffer_push(buffer, surface, t, middle);
    }
    free(seen);
    return ok;
}

/* Samples the vertices of a mesh that has fewer of them than samples are expected. Its surface is
 * farthest from splats there. */
static int sample_vertices(sample_buffer *buffer, thin_grid *grid, const psplat_surface *surface,
                           double spacing, double expected) {
    const psplat_mesh *mesh = surface->mesh;
    if ((double)mesh->vertex_count > expected) return 1;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t)
        for (uint32_t k = 0; k < 3; ++k)
            if (!throw_dart(buffer, grid, surface, t, vertex_position(mesh, t, k), spacing))
                return 0;
    return 1;
}

/* Throws the points of a point set as darts. */
static int sample_points(sample_buffer *buffer, thin_grid *grid, const psplat_surface *surface,
                         double spacing) {
    const psplat_mesh *mesh = surface->mesh;
    for (size_t i = 0; i < mesh->point_count; ++i)
        if (!throw_dart(buffer, grid, surface, mesh->point_triangles[i], mesh->points + 3 * i,
                        spacing))
            return 0;
    return 1;
}

/* Appends the points of a point set, or a random subset of about `most` if there are more. */
static int push_point_subset(sample_buffer *buffer, const psplat_surface *surface, size_t most,
                             uint64_t seed) {
    const psplat_mesh *mesh = surface->mesh;
    double part = (double)most / (double)(mesh->point_count + 1);
    for (size_t i = 0; i < mesh->point_count; ++i)
        if (psplat_random_unit(&seed) < part &&
            !buffer_push(buffer, surface, mesh->point_triangles[i], mesh->points + 3 * i))
            return 0;
    return 1;
}

/* Receives random points of a triangle. Returns 0 on failure. */
typedef int take_points(void *user, uint32_t triangle, const double *points, size_t count);

/* Hands about `total` uniform random points of the surface to take, triangle by triangle. A
 * triangle gets points in proportion to its area. The running sum is rounded, with one random
 * offset, so that small triangles get their share. */
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
        ok = !psplat_triangle_points(vertex_position(surface->mesh, t, 0),
                                     vertex_position(surface->mesh, t, 1),
                                     vertex_position(surface->mesh, t, 2), count, stream, points) &&
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
        if (!throw_dart(t->buffer, &t->grid, t->surface, triangle, points + 3 * i, t->spacing))
            return 0;
    return 1;
}

static int take_all(void *user, uint32_t triangle, const double *points, size_t count) {
    thinning *t = user;
    for (size_t i = 0; i < count; ++i)
        if (!buffer_push(t->buffer, t->surface, triangle, points + 3 * i)) return 0;
    return 1;
}

/* ---- grouping ----------------------------------------------------------------------------- */

/* The size of clusters in spacings: a cluster then has about ten samples, and several
 * triangles of any scan. Floods took least time from 3 to 6. */
static const double cluster_size_spacings = 4;

/* A sample and where it goes: by its cluster, and within that along a Morton curve. */
typedef struct placed_sample {
    uint32_t cluster, code, index;
} placed_sample;

static int compare_places(const void *left, const void *right) {
    const placed_sample *a = left, *b = right;
    if (a->cluster != b->cluster) return a->cluster < b->cluster ? -1 : 1;
    if (a->code != b->code) return a->code < b->code ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

/* Sorts values of so many bytes each by the places. moved has room for all. */
static void permute(void *values, size_t size, const placed_sample *places, size_t count,
                    char *moved) {
    if (!values) return;
    for (size_t i = 0; i < count; ++i)
        memcpy(moved + i * size, (const char *)values + places[i].index * size, size);
    memcpy(values, moved, count * size);
}

static void permute_all(psplat_samples *s, const placed_sample *places, char *moved) {
    permute(s->positions, 3 * sizeof *s->positions, places, s->count, moved);
    permute(s->normals, 3 * sizeof *s->normals, places, s->count, moved);
    permute(s->colors, 4 * sizeof *s->colors, places, s->count, moved);
    permute(s->turned, 3 * sizeof *s->turned, places, s->count, moved);
    permute(s->finishes, 3 * sizeof *s->finishes, places, s->count, moved);
    permute(s->emissive, 3 * sizeof *s->emissive, places, s->count, moved);
    permute(s->texcoords, 2 * sizeof *s->texcoords, places, s->count, moved);
    permute(s->triangles, sizeof *s->triangles, places, s->count, moved);
}

static int sort_by_cluster(psplat_samples *s) {
    placed_sample *places = malloc((s->count + 1) * sizeof *places);
    char *moved = malloc((s->count + 1) * 3 * sizeof *s->positions);
    int ok = places && moved;
    for (uint32_t i = 0; ok && i < s->count; ++i) {
        uint32_t cluster = s->clusters.of_triangles[s->triangles[i]];
        const psplat_sphere *sphere = &s->clusters.spheres[cluster];
        const double *p = s->positions + 3 * (size_t)i;
        places[i] =
            (placed_sample){cluster, psplat_morton_code(p, sphere->center, sphere->radius), i};
    }
    if (ok) {
        qsort(places, s->count, sizeof *places, compare_places);
        permute_all(s, places, moved);
    }
    free(places);
    free(moved);
    return ok;
}

/* Finds the sphere around the samples begin ... end - 1. */
static psplat_sphere sphere_around(const psplat_samples *s, size_t begin, size_t end) {
    psplat_sphere sphere = {.radius = 0};
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t i = begin; i < end; ++i)
        for (size_t k = 0; k < 3; ++k) {
            low[k] = min2(low[k], s->positions[3 * i + k]);
            high[k] = max2(high[k], s->positions[3 * i + k]);
        }
    for (int k = 0; k < 3; ++k) sphere.center[k] = (low[k] + high[k]) / 2;
    for (size_t i = begin; i < end; ++i)
        sphere.radius = max2(sphere.radius, distance2_3(s->positions + 3 * i, sphere.center));
    sphere.radius = sqrt(sphere.radius);
    return sphere;
}

/* Finds the samples of each cluster, which are sorted by these, and their blocks. */
static int find_blocks(psplat_samples *s) {
    size_t clusters = s->clusters.count;
    s->first = calloc(clusters + 1, sizeof *s->first);
    s->first_block = calloc(clusters + 1, sizeof *s->first_block);
    s->last_appended = malloc((clusters + 1) * sizeof *s->last_appended);
    if (!s->first || !s->first_block || !s->last_appended) return 0;
    memset(s->last_appended, 0xff, (clusters + 1) * sizeof *s->last_appended);
    for (size_t i = 0; i < s->count; ++i) ++s->first[s->clusters.of_triangles[s->triangles[i]] + 1];
    for (size_t c = 0; c < clusters; ++c) {
        s->first_block[c + 1] =
            s->first_block[c] + (s->first[c + 1] + PSPLAT_BLOCK_SAMPLES - 1) / PSPLAT_BLOCK_SAMPLES;
        s->first[c + 1] += s->first[c];
    }
    s->blocks = malloc((s->first_block[clusters] + 1) * sizeof *s->blocks);
    for (size_t c = 0; s->blocks && c < clusters; ++c)
        for (uint32_t b = s->first_block[c]; b < s->first_block[c + 1]; ++b) {
            size_t begin = s->first[c] + (b - s->first_block[c]) * PSPLAT_BLOCK_SAMPLES;
            size_t end = begin + PSPLAT_BLOCK_SAMPLES;
            s->blocks[b] = sphere_around(s, begin, end < s->first[c + 1] ? end : s->first[c + 1]);
        }
    return s->blocks != NULL;
}

/* Gives the samples that were drawn their clusters. */
static int group(psplat_samples *s, const psplat_surface *surface) {
    s->drawn = s->count;
    return psplat_clusters_build(surface, cluster_size_spacings * s->spacing, &s->clusters) &&
           sort_by_cluster(s) && find_blocks(s);
}

/* Lists the samples from index first on, which were appended, with their clusters. */
static int list_appended(psplat_samples *s, size_t first) {
    uint32_t *next = realloc(s->next_appended, (s->count - s->drawn + 1) * sizeof *next);
    if (!next) return 0;
    s->next_appended = next;
    for (size_t i = first; i < s->count; ++i) {
        uint32_t *last = &s->last_appended[s->clusters.of_triangles[s->triangles[i]]];
        next[i - s->drawn] = *last;
        *last = (uint32_t)i;
    }
    return 1;
}

static psplat_result finish(sample_buffer *buffer, int ok, psplat_samples *samples,
                            psplat_error *error) {
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
    /* This also refuses NaN, which an area of 0 over a spacing of 0 gives. */
    if (!(expected < (double)PSPLAT_NONE))
        return *samples = buffer.samples,
               psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "%.3g samples are needed; the tolerance is too small", expected);
    int ok = grid_create(&thin.grid, (size_t)expected, spacing) &&
             buffer_reserve(&buffer, (size_t)expected, surface->appearance) &&
             sample_creases(&buffer, &thin.grid, surface, spacing / 2) &&
             sample_vertices(&buffer, &thin.grid, surface, spacing / 4, expected) &&
             sample_points(&buffer, &thin.grid, surface, spacing) &&
             throw_points(surface, darts_per_sample * expected, seed, take_thinned, &thin) &&
             sample_empty_patches(&buffer, surface);
    grid_free(&thin.grid);
    if (ok) ok = group(&buffer.samples, surface);
    return finish(&buffer, ok, samples, error);
}

psplat_result psplat_samples_draw_uniform(const psplat_surface *surface, size_t count,
                                          uint64_t seed, psplat_samples *samples,
                                          psplat_error *error) {
    sample_buffer buffer = {0};
    thinning all = {.buffer = &buffer, .surface = surface};
    int ok = push_point_subset(&buffer, surface, count, seed) &&
             throw_points(surface, (double)count, seed, take_all, &all);
    return finish(&buffer, ok, samples, error);
}

static void move_values(float *values, size_t to, size_t from, size_t components) {
    if (values)
        memmove(values + to * components, values + from * components, components * sizeof *values);
}

void psplat_samples_drop_apron(psplat_samples *s, const psplat_surface *surface) {
    size_t kept = 0;
    for (size_t i = 0; surface->owned && i < s->count; ++i) {
        if (!psplat_surface_owns(surface, s->positions + 3 * i)) continue;
        memmove(s->positions + 3 * kept, s->positions + 3 * i, 3 * sizeof *s->positions);
        move_values(s->normals, kept, i, 3);
        move_values(s->colors, kept, i, 4);
        move_values(s->turned, kept, i, 3);
        move_values(s->finishes, kept, i, 3);
        move_values(s->emissive, kept, i, 3);
        move_values(s->texcoords, kept, i, 2);
        s->triangles[kept++] = s->triangles[i];
    }
    if (surface->owned) s->count = kept;
}

psplat_result psplat_samples_append(psplat_samples *samples, const psplat_surface *surface,
                                    const double *points, const uint32_t *triangles, size_t count,
                                    psplat_error *error) {
    sample_buffer buffer = {.samples = *samples};
    int ok = count < PSPLAT_NONE - samples->count &&
             buffer_reserve(&buffer, samples->count + count, surface->appearance);
    for (size_t i = 0; ok && i < count; ++i)
        ok = buffer_push(&buffer, surface, triangles[i], points + 3 * i);
    if (ok) ok = list_appended(&buffer.samples, samples->count);
    *samples = buffer.samples;
    if (ok) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "the samples do not fit into memory");
}

void psplat_samples_truncate(psplat_samples *samples, size_t count) {
    while (samples->count > count) {
        size_t last = --samples->count;
        samples->last_appended[samples->clusters.of_triangles[samples->triangles[last]]] =
            samples->next_appended[last - samples->drawn];
    }
}

uint32_t psplat_samples_near_triangle(const psplat_samples *samples, uint32_t triangle) {
    uint32_t cluster = samples->clusters.of_triangles[triangle];
    uint32_t first = samples->first[cluster];
    return first < samples->first[cluster + 1] ? first : samples->last_appended[cluster];
}

void psplat_samples_free(psplat_samples *samples) {
    free(samples->positions);
    free(samples->normals);
    free(samples->colors);
    free(samples->turned);
    free(samples->finishes);
    free(samples->emissive);
    free(samples->texcoords);
    free(samples->triangles);
    psplat_clusters_free(&samples->clusters);
    free(samples->first);
    free(samples->first_block);
    free(samples->blocks);
    free(samples->last_appended);
    free(samples->next_appended);
    *samples = (psplat_samples){0};
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * weld.c - vertex welding, and dropping of degenerate and repeated triangles.
 *
 * Equal positions and equal triangles are found by hash tables with open addressing and linear
 * probing (Knuth, The Art of Computer Programming 3, section 6.4).
 */
#include "mesh/weld.h"

#include "material/source_materials.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A triangle is flat if twice its area, in squares of its longest edge, is at most this. It is the
 * rounding error of the products that the area is made of, some 2^-50. */
static const double flat_double_area = 1e-15;

static uint64_t hash_position(const double p[3]) {
    uint64_t hash = 0;
    for (int k = 0; k < 3; ++k) {
        uint64_t bits;
        memcpy(&bits, &p[k], sizeof bits);
        hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
    }
    return hash;
}

static size_t table_size(size_t entries) {
    size_t size = 16;
    while (size < entries * 2) size *= 2;
    return size;
}

/* Returns the new number of position p, which is the next one if p is not in the table. */
static uint32_t vertex_number(uint32_t *table, size_t size, double *positions, size_t *count,
                              const double p[3]) {
    size_t slot = hash_position(p) & (size - 1);
    while (table[slot] != PSPLAT_NONE) {
        const double *q = positions + (size_t)table[slot] * 3;
        if (p[0] == q[0] && p[1] == q[1] && p[2] == q[2]) return table[slot];
        slot = (slot + 1) & (size - 1);
    }
    table[slot] = (uint32_t)*count;
    memcpy(positions + *count * 3, p, 3 * sizeof(double));
    return (uint32_t)(*count)++;
}

static void move_triangle(psplat_mesh *mesh, size_t to, size_t from) {
    if (to == from) return;
    memcpy(mesh->triangles + to * 3, mesh->triangles + from * 3, 3 * sizeof(uint32_t));
    psplat_corners arrays[PSPLAT_CORNER_ARRAYS];
    size_t count = psplat_mesh_corners(mesh, arrays);
    for (size_t i = 0; i < count; ++i) {
        size_t floats = 3 * arrays[i].components;
        memcpy(arrays[i].values + to * floats, arrays[i].values + from * floats,
               floats * sizeof(float));
    }
    if (mesh->groups) mesh->groups[to] = mesh->groups[from];
}

/* Keeps the triangles for which keep returns other than 0, in order, and counts the others. */
static void filter(psplat_mesh *mesh, int (*keep)(const psplat_mesh *mesh, size_t triangle)) {
    size_t kept = 0;
    for (size_t t = 0; t < mesh->triangle_count; ++t)
        if (keep(mesh, t)) move_triangle(mesh, kept++, t);
    mesh->dropped += mesh->triangle_count - kept;
    mesh->triangle_count = kept;
}

static int has_three_vertices(const psplat_mesh *mesh, size_t triangle) {
    const uint32_t *t = mesh->triangles + triangle * 3;
    return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
}

/* Returns the length of a vector, also where its square leaves the range of doubles. */
static double safe_length(const double v[3]) {
    double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (square > 1e-280 && square < 1e280) return sqrt(square);
    return hypot(hypot(v[0], v[1]), v[2]);
}

static int has_area(const psplat_mesh *mesh, size_t triangle) {
    const uint32_t *t = mesh->triangles + triangle * 3;
    double e[3][3], longest = 0;
    for (size_t i = 0; i < 3; ++i) {
        const double *a = mesh->positions + (size_t)t[i] * 3;
        const double *b = mesh->positions + (size_t)t[(i + 1) % 3] * 3;
        for (int k = 0; k < 3; ++k) e[i][k] = b[k] - a[k];
        double length = safe_length(e[i]);
        if (length > longest) longest = length;
    }
    if (!(longest > 0)) return 0;
    /* Edges are scaled by the longest, so that models of no size under- or overflow. */
    for (size_t i = 0; i < 2; ++i)
        for (int k = 0; k < 3; ++k) e[i][k] /= longest;
    double x = e[0][1] * e[1][2] - e[0][2] * e[1][1];
    double y = e[0][2] * e[1][0] - e[0][0] * e[1][2];
    double z = e[0][0] * e[1][1] - e[0][1] * e[1][0];
    return sqrt(x * x + y * y + z * z) > flat_double_area;
}

psplat_result psplat_mesh_weld(psplat_mesh *mesh, psplat_error *error) {
    size_t size = table_size(mesh->vertex_count);
    uint32_t *table = malloc(size * sizeof *table);
    double *positions = malloc((mesh->vertex_count + 1) * 3 * sizeof *positions);
    if (!table || !positions) {
        free(table);
        free(positions);
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while welding");
    }
    memset(table, 0xff, size * sizeof *table);
    size_t count = 0;
    /* Vertices are numbered in the order of their first use. Those without use get no number. */
    for (size_t i = 0; i < mesh->triangle_count * 3; ++i) {
        const double *raw = mesh->positions + (size_t)mesh->triangles[i] * 3;
        double p[3] = {raw[0] + 0.0, raw[1] + 0.0, raw[2] + 0.0}; /* -0 becomes 0 */
        mesh->triangles[i] = vertex_number(table, size, positions, &count, p);
    }
    free(table);
    free(mesh->positions);
    mesh->positions = positions;
    mesh->vertex_count = count;
    filter(mesh, has_three_vertices);
    return PSPLAT_OK;
}

/* Returns 1 if two triangles have the same vertices in the same cyclic order, -1 if in the opposite
 * order, and 0 otherwise. */
static int compare_triangles(const uint32_t *a, const uint32_t *b) {
    for (int k = 0; k < 3; ++k) {
        if (a[0] != b[k]) continue;
        if (a[1] == b[(k + 1) % 3] && a[2] == b[(k + 2) % 3]) return 1;
        if (a[1] == b[(k + 2) % 3] && a[2] == b[(k + 1) % 3]) return -1;
    }
    return 0;
}

/* The hash does not depend on the order of the vertices. */
static uint64_t hash_triangle(const uint32_t *t) {
    uint64_t sum = (uint64_t)t[0] + t[1] + t[2], bits = t[0] ^ t[1] ^ t[2];
    uint64_t hash = (sum << 32 ^ bits) * 0x9e3779b97f4a7c15u;
    return hash ^ hash >> 32;
}

/* By how much colours and texture coordinates of two corners may differ and look the same: a step
 * of a byte, and less than a texel of an image of 512. Chosen by hand. */
static const double same_value = 1.0 / 512;

/* Returns whether the values of two triangles' corners at the same vertices are the same. */
static int are_values_same(const psplat_mesh *mesh, const float *values, size_t components,
                           size_t a, size_t b) {
    for (size_t i = 0; values && i < 3; ++i)
        for (size_t k = 0; k < 3; ++k) {
            if (mesh->triangles[3 * a + i] != mesh->triangles[3 * b + k]) continue;
            const float *x = values + (3 * a + i) * components;
            const float *y = values + (3 * b + k) * components;
            for (size_t c = 0; c < components; ++c)
                if (!(fabs((double)x[c] - (double)y[c]) <= same_value)) return 0;
        }
    return 1;
}

static uint32_t group_of(const psplat_mesh *mesh, size_t triangle) {
    return mesh->groups ? mesh->groups[triangle] : 0;
}

/* Returns the material of a group, or NULL where the mesh has none for its groups. */
static const psplat_source_material *material_of(const psplat_mesh *mesh, size_t group) {
    return group < mesh->source_material_count ? &mesh->source_materials[group] : NULL;
}

static int is_double_sided(const psplat_mesh *mesh, size_t group) {
    const psplat_source_material *material = material_of(mesh, group);
    return material ? material->material.double_sided : mesh->material.double_sided;
}

static int uses_set(const psplat_source_material *material, uint32_t set) {
    int uses = 0;
    for (int slot = 0; material && slot < PSPLAT_TEXTURE_SLOTS; ++slot) {
        const psplat_texture_info *texture =
            psplat_source_texture(material, (psplat_texture_slot)slot);
        uses |= texture->image && texture->texcoord == set;
    }
    return uses;
}

/* Returns whether two triangles of one group with the same vertices look the same. */
static int look_same(const psplat_mesh *mesh, size_t a, size_t b) {
    for (uint32_t set = 0; set < PSPLAT_TEXCOORDS; ++set)
        if (uses_set(material_of(mesh, group_of(mesh, a)), set) &&
            !are_values_same(mesh, mesh->corner_uvs[set], 2, a, b))
            return 0;
    return are_values_same(mesh, mesh->corner_colors, 4, a, b);
}

/* Returns whether two triangles that face opposite ways are two sides: they look different, and the
 * material of neither is seen from both sides, so that each hides the other. */
static int are_two_sides(const psplat_mesh *mesh, size_t a, size_t b) {
    size_t group_of_a = group_of(mesh, a), group_of_b = group_of(mesh, b);
    if (is_double_sided(mesh, group_of_a) || is_double_sided(mesh, group_of_b)) return 0;
    return group_of_a != group_of_b || !look_same(mesh, a, b);
}

/* The triangles so far, of several with the same vertices the first one of either way. */
typedef struct triangle_table {
    uint32_t *triangles;
    size_t size;
} triangle_table;

static void empty_table(triangle_table *table) {
    memset(table->triangles, 0xff, table->size * sizeof *table->triangles);
}

/* Finds a triangle of the table with the same vertices as t, in the order `way` (1 or -1) of
 * compare_triangles. Returns PSPLAT_NONE where there is none, and *slot is a free one then. */
static uint32_t find_triangle(const psplat_mesh *mesh, const triangle_table *table, size_t t,
                              int way, size_t *slot) {
    const uint32_t *triangle = mesh->triangles + 3 * t;
    *slot = hash_triangle(triangle) & (table->size - 1);
    for (; table->triangles[*slot] != PSPLAT_NONE; *slot = (*slot + 1) & (table->size - 1)) {
        uint32_t other = table->triangles[*slot];
        if (compare_triangles(triangle, mesh->triangles + 3 * (size_t)other) == way) return other;
    }
    return PSPLAT_NONE;
}

/* What is known of a group. */
typedef struct group {
    size_t alone; /* triangles that exist one way only */
    int keeps;    /* 1: those that exist both ways are kept both ways */
} group;

static size_t count_groups(const psplat_mesh *mesh) {
    size_t count = 1;
    for (size_t t = 0; t < mesh->triangle_count; ++t)
        if (group_of(mesh, t) >= count) count = (size_t)group_of(mesh, t) + 1;
    return count;
}

/* Finds the groups whose triangles are kept both ways: where these are two sides and, if materials
 * say which sides are seen, where a group has others that exist one way only. Those would be seen
 * from behind too, if the group became double-sided: through what lies before them, and where their
 * splats reach out of it. */
static void find_kept(const psplat_mesh *mesh, int has_material, triangle_table *table,
                      group *groups, size_t count) {
    empty_table(table);
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        size_t slot, free_slot;
        group *own = &groups[group_of(mesh, t)];
        if (find_triangle(mesh, table, t, 1, &free_slot) != PSPLAT_NONE) continue;
        uint32_t front = find_triangle(mesh, table, t, -1, &slot);
        if (front == PSPLAT_NONE) {
            ++own->alone;
        } else {
            group *other = &groups[group_of(mesh, front)];
            if (are_two_sides(mesh, t, front)) own->keeps = other->keeps = 1;
            --other->alone;
        }
        table->triangles[free_slot] = (uint32_t)t;
    }
    for (size_t g = 0; g < count && has_material; ++g)
        groups[g].keeps |= groups[g].alone > 0 && !is_double_sided(mesh, g);
}

/* Drops repeated triangles, and those that face the other way unless they are kept. Returns whether
 * some of these are. */
static int drop_repeated(psplat_mesh *mesh, triangle_table *table, const group *groups) {
    size_t kept = 0, slot;
    int keeps = 0;
    empty_table(table);
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        uint32_t front = find_triangle(mesh, table, t, -1, &slot);
        int is_kept = front == PSPLAT_NONE || groups[group_of(mesh, front)].keeps;
        if (!is_kept) mesh->both_sides[group_of(mesh, front)] = 1;
        if (!is_kept || find_triangle(mesh, table, t, 1, &slot) != PSPLAT_NONE) continue;
        keeps |= front != PSPLAT_NONE;
        table->triangles[slot] = (uint32_t)kept;
        move_triangle(mesh, kept++, t);
    }
    mesh->dropped += mesh->triangle_count - kept;
    mesh->triangle_count = kept;
    return keeps;
}

psplat_result psplat_mesh_drop_repeated(psplat_mesh *mesh, int has_material, int *turned,
                                        int *two_sides, psplat_error *error) {
    size_t count = count_groups(mesh);
    triangle_table table = {.size = table_size(mesh->triangle_count)};
    group *groups = calloc(count, sizeof *groups);
    table.triangles = malloc(table.size * sizeof *table.triangles);
    free(mesh->both_sides);
    mesh->both_sides = calloc(count, 1);
    mesh->both_sides_count = mesh->both_sides ? count : 0;
    *turned = *two_sides = 0;
    psplat_result result = PSPLAT_OK;
    if (groups && table.triangles && mesh->both_sides) {
        find_kept(mesh, has_material, &table, groups, count);
        *two_sides = drop_repeated(mesh, &table, groups);
    } else {
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for repeated triangles");
    }
    for (size_t g = 0; g < mesh->both_sides_count; ++g) *turned |= mesh->both_sides[g];
    free(table.triangles);
    free(groups);
    return result;
}

void psplat_mesh_drop_flat(psplat_mesh *mesh) {
    filter(mesh, has_area);
}

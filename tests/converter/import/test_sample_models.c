/* SPDX-License-Identifier: MIT
 *
 * test_sample_models.c - tests that the sample models in the repository are those that the
 * generator makes, that they are closed where they should be, and that the part has the features
 * for which it was made. Expected counts follow from the generator's shapes.
 */
#include "mesh_fixture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "import/read_mesh.h"
#include "mesh/mesh.h"

static const struct {
    const char *name;
    size_t vertices, triangles;
    int euler;  /* vertices - edges + triangles: 2 - 2 x genus for one closed piece */
    int closed; /* whether it is visible only from outside */
} models[] = {
    {"part.obj", 5961, 11926, -2, 1}, /* two through-holes */
    {"cube.off", 8, 12, 2, 1},
    {"sphere.ply", 2562, 5120, 2, 1},
    {"torus.off", 2048, 4096, 0, 1},
    {"cone.stl", 626, 1248, 2, 1},
    {"plate.stl", 8, 12, 2, 1},
    {"slab.ply", 8, 12, 2, 1},
    {"bracket.gltf", 12, 20, 2, 1},
    {"painted.glb", 2160, 4224, 0, 0},     /* an open tube, two rings */
    {"scan.xyz", 1200, 2386, 1, 0},        /* a bowl */
    {"still-life.glb", 3516, 7000, 16, 1}, /* a table, three cups, two pears, two dice */
    {"clockwork.glb", 348, 676, 10, 1},    /* three boxes, two balls */
    {"tiled.glb", 1298, 2592, 2, 1},
};

/* An edge and its two triangles. */
typedef struct edge {
    uint32_t low, high;
    uint32_t triangles[2];
    int uses;
} edge;

typedef struct half {
    uint32_t low, high, triangle;
} half;

static int compare_halves(const void *a, const void *b) {
    const half *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    if (x->high != y->high) return x->high < y->high ? -1 : 1;
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

static edge *make_edges(const psplat_mesh *mesh, size_t *count) {
    size_t half_count = mesh->triangle_count * 3;
    half *halves = malloc(half_count * sizeof *halves);
    edge *edges = calloc(half_count, sizeof *edges);
    assert_non_null(halves);
    assert_non_null(edges);
    for (size_t i = 0; i < half_count; ++i) {
        uint32_t a = mesh->triangles[i], b = mesh->triangles[i - i % 3 + (i + 1) % 3];
        halves[i] = (half){a < b ? a : b, a < b ? b : a, (uint32_t)(i / 3)};
    }
    qsort(halves, half_count, sizeof *halves, compare_halves);
    *count = 0;
    for (size_t i = 0; i < half_count; ++i) {
        int is_new =
            i == 0 || halves[i].low != halves[i - 1].low || halves[i].high != halves[i - 1].high;
        if (is_new) edges[(*count)++] = (edge){.low = halves[i].low, .high = halves[i].high};
        edge *e = &edges[*count - 1];
        if (e->uses < 2) e->triangles[e->uses] = halves[i].triangle;
        ++e->uses;
    }
    free(halves);
    return edges;
}

static psplat_mesh read_model(const char *directory, const char *name) {
    psplat_mesh mesh;
    psplat_error error = {0};
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    if (psplat_mesh_read(path, &mesh, &error)) fail_msg("%s", error.text);
    return mesh;
}

static psplat_mesh read_committed(const char *name) {
    return read_model(PSPLAT_SOURCE_DIR "/samples/models", name);
}

static void test_topology(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof models / sizeof *models; ++i) {
        psplat_mesh mesh = read_committed(models[i].name);
        size_t count;
        edge *edges = make_edges(&mesh, &count);
        assert_int_equal(mesh.vertex_count, models[i].vertices);
        assert_int_equal(mesh.triangle_count, models[i].triangles);
        assert_int_equal(mesh.dropped, 0);
        assert_int_equal((int)mesh.vertex_count - (int)count + (int)mesh.triangle_count,
                         models[i].euler);
        assert_int_equal(mesh.material.double_sided, !models[i].closed);
        for (size_t e = 0; e < count && models[i].closed; ++e) assert_int_equal(edges[e].uses, 2);
        if (models[i].closed) assert_true(signed_volume(&mesh) > 0);
        free(edges);
        psplat_mesh_free(&mesh);
    }
}

/* Compares a committed file with a newly generated one. Sines and cosines may differ in their last
 * digit between machines, and text has seven digits: 1e-5 of the size is far above both and far
 * below the length of an edge. */
static void compare(const char *name) {
    psplat_mesh old = read_committed(name), new = read_model(fixture_directory, name);
    double size = 0;
    assert_int_equal(old.vertex_count, new.vertex_count);
    assert_int_equal(old.triangle_count, new.triangle_count);
    for (size_t i = 0; i < old.triangle_count * 3; ++i)
        assert_int_equal(old.triangles[i], new.triangles[i]);
    for (size_t i = 0; i < old.vertex_count * 3; ++i) size = fmax(size, fabs(old.positions[i]));
    for (size_t i = 0; i < old.vertex_count * 3; ++i)
        assert_near(new.positions[i], old.positions[i], 1e-5 * size);
    for (int k = 0; k < 3; ++k) assert_near(new.origin[k], old.origin[k], 1e-5 * size);
    psplat_mesh_free(&old);
    psplat_mesh_free(&new);
}

static void test_regenerated(void **state) {
    (void)state;
    char command[1024];
    snprintf(command, sizeof command, "'%s/samples/generate_models' '%s'", PSPLAT_BINARY_DIR,
             fixture_directory);
    int failed = system(command);
    for (size_t i = 0; i < sizeof models / sizeof *models; ++i) {
        if (!failed) compare(models[i].name);
        snprintf(fixture_path, sizeof fixture_path, "%s/%s", fixture_directory, models[i].name);
        unlink(fixture_path);
    }
    assert_int_equal(failed, 0);
}

/* ---- known shapes ---------------------------------------------------------------------------- */

static void test_sphere(void **state) {
    (void)state;
    psplat_mesh mesh = read_committed("sphere.ply");
    assert_non_null(mesh.corner_normals);
    for (size_t i = 0; i < mesh.triangle_count * 3; ++i)
        for (size_t k = 0; k < 3; ++k) {
            double x = mesh.positions[(size_t)mesh.triangles[i] * 3 + k] + mesh.origin[k];
            assert_near((double)mesh.corner_normals[i * 3 + k], x, 2e-7); /* rounding to float */
        }
    /* The volume of a unit sphere, less what flat triangles cut off: less than 0.5 %. */
    assert_near(signed_volume(&mesh) / 6, 4.18879, 0.02);
    psplat_mesh_free(&mesh);
}

static void test_painted(void **state) {
    (void)state;
    psplat_mesh mesh = read_committed("painted.glb");
    assert_non_null(mesh.groups);
    assert_non_null(mesh.corner_colors);
    float least = 1, greatest = 0;
    for (size_t i = 0; i < mesh.triangle_count * 12; ++i) {
        least = fminf(least, mesh.corner_colors[i]);
        greatest = fmaxf(greatest, mesh.corner_colors[i]);
    }
    assert_true(least < 0.05f && greatest > 0.95f);
    psplat_mesh_free(&mesh);
}

/* ---- the part -------------------------------------------------------------------------------- */

typedef struct part {
    psplat_mesh mesh;
    edge *edges;
    size_t edge_count;
    double (*normals)[3]; /* unit normals of the triangles */
    /* for each vertex the number of edges that bend by more than 30 degrees */
    int *creases;
} part;

static void subtract(const part *p, uint32_t a, uint32_t b, double d[3]) {
    for (size_t k = 0; k < 3; ++k)
        d[k] = p->mesh.positions[(size_t)a * 3 + k] - p->mesh.positions[(size_t)b * 3 + k];
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double angle_between(const double a[3], const double b[3]) {
    double cosine = dot(a, b) / sqrt(dot(a, a) * dot(b, b));
    return acos(fmax(-1, fmin(1, cosine))) * 180 / 3.14159265358979;
}

static double dihedral(const part *p, const edge *e) {
    return angle_between(p->normals[e->triangles[0]], p->normals[e->triangles[1]]);
}

/* Returns whether the edge is convex: the second triangle's corner off the edge lies below the
 * plane of the first one. */
static int is_convex(const part *p, const edge *e) {
    const uint32_t *t = p->mesh.triangles + (size_t)e->triangles[1] * 3;
    double d[3];
    int k = 0;
    while (t[k] == e->low || t[k] == e->high) ++k;
    subtract(p, t[k], e->low, d);
    return dot(d, p->normals[e->triangles[0]]) < 0;
}

static part load_part(void) {
    part p = {.mesh = read_committed("part.obj")};
    p.edges = make_edges(&p.mesh, &p.edge_count);
    p.normals = malloc(p.mesh.triangle_count * sizeof *p.normals);
    p.creases = calloc(p.mesh.vertex_count, sizeof *p.creases);
    assert_non_null(p.normals);
    assert_non_null(p.creases);
    for (size_t t = 0; t < p.mesh.triangle_count; ++t) {
        const uint32_t *v = p.mesh.triangles + t * 3;
        double a[3], b[3], *n = p.normals[t];
        subtract(&p, v[1], v[0], a);
        subtract(&p, v[2], v[0], b);
        for (int k = 0; k < 3; ++k)
            n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        double length = sqrt(dot(n, n));
        for (int k = 0; k < 3; ++k) n[k] /= length;
    }
    for (size_t i = 0; i < p.edge_count; ++i) {
        int is_crease = dihedral(&p, &p.edges[i]) > 30;
        p.creases[p.edges[i].low] += is_crease;
        p.creases[p.edges[i].high] += is_crease;
    }
    return p;
}

static void free_part(part *p) {
    free(p->edges);
    free(p->normals);
    free(p->creases);
    psplat_mesh_free(&p->mesh);
}

/* Counts crease edges of one kind, and pairs of them that meet at a small angle at a vertex without
 * other creases, which are links of a curved crease. */
static void count_creases(const part *p, int convex, size_t *creases, size_t *bends) {
    double(*direction)[3] = calloc(p->mesh.vertex_count, sizeof *direction);
    assert_non_null(direction);
    *creases = *bends = 0;
    for (size_t i = 0; i < p->edge_count; ++i) {
        const edge *e = &p->edges[i];
        if (dihedral(p, e) <= 30 || is_convex(p, e) != convex) continue;
        ++*creases;
        for (int end = 0; end < 2; ++end) {
            uint32_t here = end ? e->high : e->low, there = end ? e->low : e->high;
            double d[3], *first = direction[here];
            subtract(p, there, here, d);
            if (p->creases[here] != 2) continue;
            double turn = dot(first, first) > 0 ? 180 - angle_between(first, d) : 0;
            *bends += turn > 2 && turn < 25;
            memcpy(first, d, sizeof d);
        }
    }
    free(direction);
}

static void test_part_creases(void **state) {
    (void)state;
    part p = load_part();
    size_t creases, bends;
    count_creases(&p, 1, &creases, &bends);
    assert_true(creases > 200 && bends > 80); /* outline, rims, the step's upper edge */
    count_creases(&p, 0, &creases, &bends);
    assert_true(creases > 80 && bends > 40); /* foot of the boss and of the step */
    free_part(&p);
}

static void test_part_corners(void **state) {
    (void)state;
    part p = load_part();
    size_t corners = 0, ends = 0;
    for (size_t v = 0; v < p.mesh.vertex_count; ++v) {
        corners += p.creases[v] == 3;
        ends += p.creases[v] == 1;
    }
    assert_true(corners >= 12);
    assert_true(ends >= 2); /* creases that run out into the blend */
    free_part(&p);
}

/* The test sums the interior angles at each corner of the flat faces that point up or down (y). */
static void test_part_reflex_corner(void **state) {
    (void)state;
    part p = load_part();
    double(*angles)[2] = calloc(p.mesh.vertex_count, sizeof *angles);
    assert_non_null(angles);
    for (size_t t = 0; t < p.mesh.triangle_count; ++t) {
        if (fabs(p.normals[t][1]) < 0.999999) continue;
        const uint32_t *v = p.mesh.triangles + t * 3;
        for (int k = 0; k < 3; ++k) {
            double a[3], b[3];
            subtract(&p, v[(k + 1) % 3], v[k], a);
            subtract(&p, v[(k + 2) % 3], v[k], b);
            angles[v[k]][p.normals[t][1] < 0] += angle_between(a, b);
        }
    }
    size_t up = 0, down = 0;
    for (size_t v = 0; v < p.mesh.vertex_count; ++v) {
        up += fabs(angles[v][0] - 270) < 0.01 && p.creases[v] >= 3;
        down += fabs(angles[v][1] - 270) < 0.01 && p.creases[v] >= 3;
    }
    assert_true(up >= 1 && down >= 1); /* the notch, from above and from below */
    free(angles);
    free_part(&p);
}

int test_sample_models_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_topology),
        cmocka_unit_test(test_regenerated),
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_painted),
        cmocka_unit_test(test_part_creases),
        cmocka_unit_test(test_part_corners),
        cmocka_unit_test(test_part_reflex_corner),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}

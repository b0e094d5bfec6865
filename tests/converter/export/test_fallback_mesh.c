/* SPDX-License-Identifier: MIT
 *
 * test_fallback_mesh.c - tests of simplified meshes for viewers that do not know the extension:
 * they stay within the tolerance of the surface, keep creases, and are closed where the source is.
 * The shapes are a cube, a torus and a textured square; expected values are their volumes and
 * counts.
 */
#include "appearance_fixture.h"
#include "stage_fixture.h"
#include "shape_fixture.h"
#include "base/vector.h"
#include "export/fallback_mesh.h"
#include "material/source_materials.h"
#include "mesh/mesh.h"
#include "select/conversion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static psplat_fallback_mesh make(const psplat_mesh *mesh, double percent) {
    const psplat_convert_desc desc = {.tolerance_percent = percent};
    psplat_fallback_mesh fallback;
    psplat_error error = {0};
    if (psplat_fallback_mesh_make(mesh, &desc, &fallback, &error)) fail_msg("%s", error.text);
    return fallback;
}

/* Stores corner k of triangle t in double. */
static void corner(const psplat_fallback_mesh *s, size_t t, size_t k, double out[3]) {
    for (size_t i = 0; i < 3; ++i) out[i] = (double)s->vertices[s->indices[3 * t + k]].position[i];
}

static void area_vector(const psplat_fallback_mesh *s, size_t t, double out[3]) {
    double a[3], b[3], c[3], ab[3], ac[3];
    corner(s, t, 0, a), corner(s, t, 1, b), corner(s, t, 2, c);
    for (int i = 0; i < 3; ++i) ab[i] = b[i] - a[i], ac[i] = c[i] - a[i];
    cross3(out, ab, ac);
    for (int i = 0; i < 3; ++i) out[i] *= 0.5;
}

static double primitive_area(const psplat_fallback_mesh *s,
                             const psplat_fallback_primitive *primitive) {
    double sum = 0;
    for (size_t t = primitive->first / 3; t < (primitive->first + primitive->count) / 3; ++t) {
        double area[3];
        area_vector(s, t, area);
        sum += sqrt(dot3(area, area));
    }
    return sum;
}

/* Returns six times the enclosed volume. */
static double volume(const psplat_fallback_mesh *s) {
    double sum = 0;
    for (size_t t = 0; t < s->index_count / 3; ++t) {
        double a[3], area[3];
        corner(s, t, 0, a);
        area_vector(s, t, area);
        sum += 2 * dot3(a, area);
    }
    return sum;
}

static void test_cube(void **state) {
    (void)state;
    psplat_mesh mesh = shape_cube(8);
    shape_weld(&mesh);
    psplat_fallback_mesh s = make(&mesh, 0.5);
    /* Of 768 triangles, 12 and some with ends on edges remain. */
    assert_true(s.index_count <= 3 * 40);
    assert_true(s.vertex_count <= 64);
    assert_int_equal(s.primitive_count, 1);
    assert_false(s.has_color);
    assert_true(fabs(volume(&s) - 6 * 8) < 1e-12);
    for (size_t t = 0; t < s.index_count / 3; ++t) { /* All three corners have the face's normal. */
        double area[3];
        area_vector(&s, t, area);
        for (size_t k = 0; k < 3; ++k) {
            const float *n = s.vertices[s.indices[3 * t + k]].normal;
            double cosine = 0;
            for (size_t i = 0; i < 3; ++i) cosine += (double)n[i] * area[i];
            assert_true(cosine >= (1 - 1e-6) * sqrt(dot3(area, area)));
        }
    }
    psplat_fallback_mesh_free(&s);
    psplat_mesh_free(&mesh);
}

/* At a tiny tolerance all triangles remain; the larger the tolerance, the fewer triangles remain,
 * each near the surface. */
static void test_torus(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "torus.off");
    psplat_fallback_mesh all = make(&f.mesh, 0.004);
    assert_int_equal(all.index_count, 3 * f.mesh.triangle_count);
    assert_int_equal(all.vertex_count, f.mesh.vertex_count);
    size_t before = all.index_count;
    double inside = volume(&all);
    for (int percent = 1; percent <= 4; percent *= 2) {
        double tolerance = 0.01 * percent * f.surface.diagonal;
        psplat_fallback_mesh s = make(&f.mesh, percent);
        assert_true(s.index_count < before && s.index_count > 60);
        before = s.index_count;
        /* At most a layer as thick as the tolerance is lost: 6 * area * tolerance. */
        assert_true(fabs(volume(&s) - inside) < 6 * f.surface.area * tolerance);
        psplat_fallback_mesh_free(&s);
    }
    assert_true(4 * before < all.index_count);
    psplat_fallback_mesh_free(&all);
    fixture_free(&f);
}

/* Vertices are numbered in the order in which indices refer to them, and each is used. */
static void test_order(void **state) {
    (void)state;
    fixture f;
    fixture_model(&f, "cone.stl");
    psplat_fallback_mesh s = make(&f.mesh, 1);
    uint32_t next = 0;
    for (size_t i = 0; i < s.index_count; ++i) {
        assert_true(s.indices[i] <= next);
        next += s.indices[i] == next;
    }
    assert_int_equal(next, s.vertex_count);
    psplat_fallback_mesh_free(&s);
    fixture_free(&f);
}

static void stripes(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)y;
    static const uint8_t red[4] = {255, 0, 0, 255}, green[4] = {0, 255, 0, 255};
    memcpy(rgba, x < 8 ? red : green, 4);
}

/* The square has two materials, one for each half, one of them with a texture: vertices get
 * colours. */
static void test_materials(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 8, 16, stripes);
    psplat_source_material source_materials[3] = {p.source_material, p.source_material,
                                                  p.source_material};
    source_materials[2].base_color =
        (psplat_texture_info){.image = &p.image,
                              .transform = {1, 0, 0, 0, 1, 0},
                              .strength = 1,
                              .wrap = {PSPLAT_WRAP_CLAMP, PSPLAT_WRAP_CLAMP}};
    p.mesh.source_materials = source_materials;
    p.mesh.source_material_count = 3;
    uint32_t *groups = malloc(p.mesh.triangle_count * sizeof *groups);
    for (size_t t = 0; t < p.mesh.triangle_count; ++t) groups[t] = t / 2 % 8 < 4 ? 2 : 0;
    free(p.mesh.groups);
    p.mesh.groups = groups;
    psplat_fallback_mesh s = make(&p.mesh, 0.5);
    assert_int_equal(s.primitive_count, 2);
    assert_int_equal(s.primitives[0].group, 0);
    assert_int_equal(s.primitives[1].group, 2);
    for (size_t i = 0; i < 2; ++i)
        assert_true(fabs(primitive_area(&s, &s.primitives[i]) - 2) < 1e-6);
    assert_true(s.index_count <= 3 * 8); /* Of 128 flat triangles few remain. */
    assert_true(s.has_color);
    for (size_t v = 0; v < s.vertex_count; ++v) {
        const psplat_fallback_vertex *vertex = &s.vertices[v];
        int is_painted = vertex->group == 2, is_edge = vertex->position[0] == 0;
        if (is_edge) continue; /* where the stripes meet */
        assert_true(fabsf(vertex->color[0] - 1) < 0.01f);
        assert_true(fabsf(vertex->color[1] - (is_painted ? 0.0f : 1.0f)) < 0.01f);
    }
    psplat_fallback_mesh_free(&s);
    painted_free(&p);
}

static void half_rough(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)y;
    rgba[0] = rgba[3] = 255, rgba[1] = x < 8 ? 102 : 153, rgba[2] = 51;
}

/* The roughness (green) and metalness (blue) of a texture become factors by their means, 1/2 and
 * 1/5. */
static void test_finish(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 8, 16, half_rough);
    p.source_material.material.roughness = 0.5f;
    p.source_material.metallic_roughness =
        (psplat_texture_info){.image = &p.image, .transform = {1, 0, 0, 0, 1, 0}};
    psplat_fallback_mesh s = make(&p.mesh, 0.5);
    assert_int_equal(s.primitive_count, 1);
    /* The texture repeats, and so do the footprints of vertices at its edges: both sides are equal.
     */
    assert_true(fabsf(s.primitives[0].material.roughness - 0.25f) < 1e-4f);
    assert_true(fabsf(s.primitives[0].material.metallic - 0.2f) < 1e-4f);
    psplat_fallback_mesh_free(&s);
    painted_free(&p);
}

/* Groups without materials do not divide the mesh. */
static void test_groups_alone(void **state) {
    (void)state;
    psplat_mesh mesh = shape_cube(2);
    shape_weld(&mesh);
    mesh.groups = malloc(mesh.triangle_count * sizeof *mesh.groups);
    for (uint32_t t = 0; t < mesh.triangle_count; ++t) mesh.groups[t] = 1000 + t % 2;
    psplat_fallback_mesh s = make(&mesh, 0.5);
    assert_int_equal(s.primitive_count, 1);
    assert_int_equal(s.primitives[0].group, 0);
    assert_int_equal(s.primitives[0].count, s.index_count);
    psplat_fallback_mesh_free(&s);
    psplat_mesh_free(&mesh);
}

/* Textures that are kept stay textures: vertices have their coordinates, and no colour is baked. */
static void test_texture_coordinates(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 4, 4, stripes);
    psplat_source_materials materials = {&p.source_material, 1, &p.image, 1, NULL};
    p.source_material.base_color = (psplat_texture_info){.image = &p.image, .nearest = 1};
    psplat_source_materials_describe_textures(&materials);
    psplat_fallback_mesh s = make(&p.mesh, 0.5);
    assert_true(s.has_texcoord && !s.has_color);
    assert_int_equal(s.primitive_count, 1);
    assert_true(s.primitives[0].has_texcoord);
    assert_int_equal(s.primitives[0].material.textures[PSPLAT_TEXTURE_BASE_COLOR].image, 1);
    assert_true(s.index_count >= 6 && s.vertex_count >= 4);
    for (size_t i = 0; i < s.vertex_count; ++i) {
        const psplat_fallback_vertex *v = &s.vertices[i];
        assert_true(v->texcoord[0] == (v->position[0] + 1) / 2);
        assert_true(v->texcoord[1] == 1 - (v->position[1] + 1) / 2);
    }
    psplat_fallback_mesh_free(&s);
    painted_free(&p);
}

int test_fallback_mesh_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cube),
        cmocka_unit_test(test_torus),
        cmocka_unit_test(test_order),
        cmocka_unit_test(test_materials),
        cmocka_unit_test(test_groups_alone),
        cmocka_unit_test(test_finish),
        cmocka_unit_test(test_texture_coordinates),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

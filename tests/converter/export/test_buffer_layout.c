/* SPDX-License-Identifier: MIT
 *
 * test_buffer_layout.c - tests of the layout of splats in a file's buffer: every splat is stored
 * once with its lines, nothing overlaps, and the smallest of all layouts is chosen. Splats are the
 * random ones of writer_fixture.h in integers, floats, and several formats.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "base/json_writer.h"
#include "export/splat_attributes.h"
#include "export/buffer_layout.h"
#include "export/glb_writer.h"
#include "export/gltf_document.h"
#include "export/meshopt_codec.h"
#include "scene/scene.h"
#include "splats/splats.h"
#include "writer_fixture.h"

enum { MESHES = 4 };

/* The splats to be laid out: integers, floats, nothing, and integers in other formats. */
typedef struct laid {
    psplat_splats splats[MESHES];
    psplat_attribute_table tables[MESHES];
    psplat_scene scene;
} laid;

/* Divides each run between two materials and two depth tolerances, which makes families of
 * primitives. */
static void divide_runs(psplat_splats *s) {
    psplat_run *runs = writer_memory(4 * s->run_count, sizeof *runs);
    size_t count = 0;
    for (size_t i = 0; i < s->run_count; ++i) {
        psplat_run run = s->runs[i];
        const size_t pieces[3] = {run.count / 3, run.count / 4,
                                  run.count - run.count / 3 - run.count / 4};
        for (uint32_t k = 0; k < 3; ++k) {
            run.count = pieces[k];
            run.material = k / 2;
            run.depth_tolerance = k == 1 ? 0.25f : 0.5f;
            if (pieces[k]) runs[count++] = run;
        }
    }
    free(s->runs);
    s->runs = runs;
    s->run_count = count;
    s->materials = realloc(s->materials, 2 * sizeof *s->materials);
    assert_non_null(s->materials);
    s->materials[1] = s->materials[0];
    s->materials[1].metallic = 1;
    s->material_count = 2;
}

/* Makes the splats; the tables point to them. */
static void lay(size_t count, laid *l) {
    const written kinds[MESHES] = {
        {.count = count, .size = 2, .precision = steps_of(2), .has_slopes = 1, .has_surface = 1},
        {.count = count / 2 + 1, .size = 1, .has_color = 1, .has_slopes = 1, .has_emissive = 1},
        {.count = 0, .size = 1},
        {.count = count / 3 + 1,
         .size = 1,
         .precision = steps_of(1),
         .has_color = 1,
         .has_gradients = 1}};
    *l = (laid){.scene = writer_scene(MESHES)};
    for (size_t i = 0; i < MESHES; ++i) {
        psplat_error error = {0};
        l->splats[i] = writer_splats(&kinds[i], (uint32_t)(20 + i));
        divide_runs(&l->splats[i]);
        if (psplat_attribute_table_fill(&l->splats[i], &l->tables[i], &error))
            fail_msg("%s", error.text);
    }
}

static void laid_free(laid *l) {
    for (size_t i = 0; i < MESHES; ++i) {
        psplat_attribute_table_free(&l->tables[i]);
        psplat_splats_free(&l->splats[i]);
    }
    psplat_scene_free(&l->scene);
}

static psplat_buffer_layout_plan plan_of(unsigned bits, double padding, const psplat_codec *codec) {
    return (psplat_buffer_layout_plan){.lines_apart = (bits & 1) != 0,
                                       .normals_apart = (bits & 2) != 0,
                                       .rows_alike = (bits & 4) != 0,
                                       .padding = padding,
                                       .codec = codec};
}

static psplat_buffer_layout make(laid *l, const psplat_buffer_layout_plan *plan) {
    psplat_buffer_layout layout = {.tables = l->tables, .mesh_count = MESHES};
    psplat_error error = {0};
    if (psplat_buffer_layout_make(plan, &layout, &error)) fail_msg("%s", error.text);
    return layout;
}

/* Returns the run of a splat. */
static const psplat_run *run_of(const psplat_splats *s, size_t index) {
    const psplat_run *run = s->runs;
    for (; index >= run->count; ++run) index -= run->count;
    return run;
}

/* ---- primitives ----------------------------------------------------------------------------- */

/* Asserts that each splat is in one primitive, with its mesh, material and tolerance, and with room
 * for its lines. */
static void check_primitives(const laid *l, const psplat_buffer_layout *layout) {
    uint8_t *seen[MESHES];
    for (size_t m = 0; m < MESHES; ++m) seen[m] = writer_memory(l->splats[m].count, 1);
    for (size_t p = 0; p < layout->primitive_count; ++p) {
        const psplat_primitive_layout *primitive = &layout->primitives[p];
        size_t count = 0;
        if (p && primitive[-1].mesh == primitive->mesh)
            assert_true(primitive[-1].clip_lines <= primitive->clip_lines);
        else if (p)
            assert_true(primitive[-1].mesh < primitive->mesh);
        for (size_t class = 0; class <= PSPLAT_MAX_CLIP_LINES; ++class) {
            count += primitive->counts[class];
            for (size_t i = 0; i < primitive->counts[class]; ++i) {
                size_t index = primitive->first[class] + i;
                const psplat_run *run = run_of(&l->splats[primitive->mesh], index);
                assert_int_equal(l->splats[primitive->mesh].splats[index].clip_count, class);
                assert_true(class <= primitive->clip_lines);
                assert_int_equal(run->material, primitive->material);
                assert_true(run->depth_tolerance == primitive->depth_tolerance);
                assert_int_equal(seen[primitive->mesh][index]++, 0);
            }
        }
        assert_true(count > 0);
        assert_int_equal(count, primitive->count);
        assert_true(primitive->counts[primitive->clip_lines] >
                    0); /* no primitive has more lines than a splat of it needs */
        for (size_t k = 0; k < PSPLAT_MAX_CLIP_LINES; ++k)
            assert_int_equal(primitive->formats[PSPLAT_ATTRIBUTE_LINE + k].components > 0,
                             k < primitive->clip_lines);
    }
    for (size_t m = 0; m < MESHES; ++m) {
        for (size_t i = 0; i < l->splats[m].count; ++i) assert_int_equal(seen[m][i], 1);
        free(seen[m]);
    }
}

/* ---- bytes ---------------------------------------------------------------------------------- */

/* Asserts that the elements of an attribute lie where they should, and only there. */
static void check_attribute(const laid *l, const psplat_buffer_layout *layout,
                            const psplat_primitive_layout *primitive, size_t kind,
                            uint8_t *const *taken) {
    const psplat_attribute_format *format = &primitive->formats[kind];
    const psplat_attribute_place *place = &primitive->places[kind];
    const psplat_buffer_view *view = &layout->views[place->view];
    size_t bytes = psplat_attribute_bytes(format), at = place->offset;
    assert_int_equal(view->stride % 4, 0);
    assert_int_equal(place->offset % 4, 0);
    for (size_t class = 0; class <= PSPLAT_MAX_CLIP_LINES; ++class)
        for (size_t i = 0; i < primitive->counts[class]; ++i, at += view->stride) {
            uint8_t expected[16] = {0};
            const psplat_attribute_table *table = &l->tables[primitive->mesh];
            assert_true(at + bytes <= view->rows * view->stride);
            if (view->filter == PSPLAT_FILTER_OCTAHEDRAL)
                psplat_attribute_table_put_octahedral(table, primitive->first[class] + i, expected);
            else
                psplat_attribute_table_put(table, kind, format, primitive->first[class] + i,
                                           expected);
            assert_memory_equal(view->bytes + at, expected, bytes);
            for (size_t k = 0; k < bytes; ++k) assert_int_equal(taken[place->view][at + k]++, 0);
        }
}

/* Asserts that every byte of every view belongs to one element, or is 0. */
static void check_bytes(const laid *l, const psplat_buffer_layout *layout) {
    uint8_t **taken = writer_memory(layout->view_count, sizeof *taken);
    for (size_t v = 0; v < layout->view_count; ++v)
        taken[v] = writer_memory(layout->views[v].rows, layout->views[v].stride);
    for (size_t p = 0; p < layout->primitive_count; ++p)
        for (size_t kind = 0; kind < PSPLAT_ATTRIBUTE_KINDS; ++kind)
            if (layout->primitives[p].formats[kind].components)
                check_attribute(l, layout, &layout->primitives[p], kind, taken);
    for (size_t v = 0; v < layout->view_count; ++v) {
        for (size_t i = 0; i < layout->views[v].rows * layout->views[v].stride; ++i)
            if (!taken[v][i]) assert_int_equal(layout->views[v].bytes[i], 0);
        free(taken[v]);
    }
    free(taken);
}

static void test_every_plan(void **state) {
    (void)state;
    static const size_t counts[] = {1, 2, 7, 60, 3000};
    static const double paddings[] = {0, 0.1, 1, HUGE_VAL};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
        laid l;
        lay(counts[c], &l);
        for (unsigned i = 0; i < 32; ++i) {
            const psplat_buffer_layout_plan plan =
                plan_of(i, paddings[i / 8], &psplat_meshopt_codec);
            psplat_buffer_layout layout = make(&l, &plan);
            check_primitives(&l, &layout);
            check_bytes(&l, &layout);
            psplat_buffer_layout_clear(&layout);
        }
        laid_free(&l);
    }
}

/* Where padding is free, a family is one primitive; where it is infinitely expensive, each class is
 * one. */
static void test_padding(void **state) {
    (void)state;
    laid l;
    lay(60, &l);
    psplat_buffer_layout_plan plan = plan_of(0, 0, NULL);
    psplat_buffer_layout layout = make(&l, &plan);
    assert_int_equal(layout.primitive_count, 3 * (MESHES - 1)); /* families of meshes with splats */
    psplat_buffer_layout_clear(&layout);
    plan.padding = HUGE_VAL;
    layout = make(&l, &plan);
    size_t runs = 0;
    for (size_t i = 0; i < MESHES; ++i) runs += l.splats[i].run_count;
    assert_int_equal(layout.primitive_count, runs);
    psplat_buffer_layout_clear(&layout);
    laid_free(&l);
}

/* Splats without clip lines are flat and the others curved, with a SHAPE. Returns the primitives
 * into which they go where padding is free. */
static size_t count_joined(size_t count, int has_shape, int flat_joins) {
    const written w = {.count = count,
                       .size = 1,
                       .precision = steps_of(1),
                       .has_slopes = 1,
                       .curved = 30,
                       .has_shape = has_shape};
    psplat_buffer_layout_plan plan = plan_of(0, 0, NULL);
    psplat_splats splats = writer_splats(&w, 5);
    psplat_attribute_table table;
    psplat_buffer_layout layout = {.tables = &table, .mesh_count = 1};
    psplat_error error = {0};
    plan.flat_joins = flat_joins;
    if (psplat_attribute_table_fill(&splats, &table, &error)) fail_msg("%s", error.text);
    if (psplat_buffer_layout_make(&plan, &layout, &error)) fail_msg("%s", error.text);
    size_t primitives = layout.primitive_count, flat = layout.primitives[0].counts[0];
    size_t joined = layout.primitives[0].counts[PSPLAT_LINE_CLASSES];
    assert_int_equal(primitives == 1 ? joined : flat, splats.runs[0].count);
    psplat_buffer_layout_clear(&layout);
    psplat_attribute_table_free(&table);
    psplat_splats_free(&splats);
    return primitives;
}

/* A few flat splats join curved ones where they keep their normals, which takes a SHAPE; many stay
 * alone, since curved primitives are slower to draw. */
static void test_flat_joins(void **state) {
    (void)state;
    assert_int_equal(count_joined(60, 1, 0), 2);
    assert_int_equal(count_joined(60, 1, 1), 1);
    assert_int_equal(count_joined(60, 0, 1), 2);
    assert_int_equal(count_joined(3000, 1, 1), 2);
}

/* ---- files ---------------------------------------------------------------------------------- */

/* Returns the size in bytes of the GLB of a plan. */
static size_t size_of(laid *l, const psplat_buffer_layout_plan *plan) {
    psplat_buffer_layout layout = make(l, plan);
    psplat_writer json = {.compact = 1};
    psplat_materials materials;
    assert_int_equal(psplat_document_materials(&l->scene, &layout, &materials, NULL), PSPLAT_OK);
    assert_true(psplat_document_write(&json, &l->scene, &layout, &materials));
    psplat_materials_free(&materials);
    size_t size = 28 + (json.size + 3) / 4 * 4;
    for (size_t v = 0; v < layout.view_count; ++v)
        size += psplat_buffer_view_bytes(&layout.views[v]);
    free(json.text);
    psplat_buffer_layout_clear(&layout);
    return size;
}

static void check_smallest(size_t count, const psplat_codec *codec) {
    const psplat_write_desc desc = {.codec = codec};
    laid l;
    lay(count, &l);
    size_t size, again_size, least = SIZE_MAX;
    uint8_t *data = writer_file(l.splats, MESHES, &desc, &size);
    uint8_t *again = writer_file(l.splats, MESHES, &desc, &again_size);
    assert_int_equal(again_size, size);
    assert_memory_equal(again, data, size); /* Equal input gives equal bytes. */
    for (unsigned bits = 0; bits < 8; ++bits) {
        if (bits & 2 && !codec) continue; /* The filter belongs to the compression. */
        const psplat_buffer_layout_plan plan = plan_of(bits, codec ? 0.1 : 1, codec);
        size_t other = size_of(&l, &plan);
        if (other < least) least = other;
    }
    if (codec)
        assert_true(size < least); /* by a stream */
    else
        assert_int_equal(size, least);
    psplat_asset *asset = writer_open(data, size);
    size_t splats = 0, expected = 0;
    for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b)
        splats += psplat_asset_batch(asset, b)->splat_count;
    for (size_t i = 0; i < MESHES; ++i) expected += l.splats[i].count;
    assert_int_equal(splats, expected);
    psplat_asset_destroy(asset);
    free(data);
    free(again);
    laid_free(&l);
}

static void test_smallest(void **state) {
    (void)state;
    static const size_t counts[] = {1, 30, 400, 4000};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
        check_smallest(counts[c], NULL);
        check_smallest(counts[c], &psplat_meshopt_codec);
    }
}

/* Splats that lie as close together as those of files do, within steps of bytes: the file is
 * smaller than any with a stream in an order along the curve and with a compressed accessor. */
static void test_short_orders(void **state) {
    (void)state;
    const psplat_write_desc desc = {.codec = &psplat_meshopt_codec};
    const written many = {.count = 1000, .size = 1, .precision = steps_of(1)};
    laid l = {.scene = writer_scene(MESHES)};
    size_t size, least = SIZE_MAX;
    l.splats[0] = writer_splats(&many, 8);
    for (size_t i = 0; i < many.count; ++i)
        for (int k = 0; k < 3; ++k) l.splats[0].splats[i].center[k] *= 0.0625f;
    assert_int_equal(psplat_attribute_table_fill(&l.splats[0], &l.tables[0], NULL), PSPLAT_OK);
    for (size_t i = 1; i < MESHES; ++i) l.tables[i].splats = &l.splats[i];
    for (uint32_t low_bits = 0; low_bits <= PSPLAT_MOST_LOW_BITS; ++low_bits) {
        const psplat_buffer_layout_plan plan = {
            .streams = 1, .low_bits = low_bits, .padding = 0.02, .codec = desc.codec};
        size_t other = size_of(&l, &plan);
        if (other < least) least = other;
    }
    free(writer_file(l.splats, MESHES, &desc, &size));
    assert_true(size < least);
    laid_free(&l);
}

int test_buffer_layout_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_plan),   cmocka_unit_test(test_padding),
        cmocka_unit_test(test_flat_joins),   cmocka_unit_test(test_smallest),
        cmocka_unit_test(test_short_orders),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

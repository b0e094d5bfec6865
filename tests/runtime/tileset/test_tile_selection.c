/* SPDX-License-Identifier: MIT
 *
 * test_tile_selection.c - tests which tiles a frame draws: errors, culling, budgets, hysteresis.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <stdlib.h>
#include <cmocka.h>

#include "tiles_fixture.h"

#include "tileset/cone.h"
#include "tileset/show.h"
#include "core/matrix.h"

enum { VIEWS = 1000 };

/* ---- what a cut has to be -------------------------------------------------------------------- */

typedef struct cut {
    size_t drawn, splats, over; /* tiles, their splats, those above tau */
} cut;

/* Walks down as far as tiles were replaced in this frame: every way to a leaf meets one drawn tile,
 * or a tile that is not visible. */
static void walk(const psplat_tiles *t, uint32_t node, double tau, cut *sum) {
    const psplat_tile_node *n = &t->nodes[node];
    const psplat_tile_use *use = &t->uses[node];
    assert_int_equal(use->looked, t->frame);
    if (!use->is_visible) return;
    if (use->refined == t->frame) {
        for (uint32_t i = 0; i < n->child_count; ++i) walk(t, n->first_child + i, tau, sum);
        return;
    }
    assert_true(psplat_tile_is_ready(t, node));
    ++sum->drawn;
    sum->splats += n->splats;
    sum->over += psplat_tile_pixels(t, node) > tau;
}

static int is_item_of(const psplat_tiles *t, const psplat_item *item, uint32_t node) {
    return t->loads[t->nodes[node].first_content].model == item->model;
}

/* Items are the drawn tiles, each once. */
static void check_items(const psplat_tiles *t, size_t drawn) {
    size_t count = 0, found = 0;
    const psplat_item *items = psplat_tiles_items(t, &count);
    assert_int_equal(count, drawn);
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < i; ++k) assert_ptr_not_equal(items[i].model, items[k].model);
    for (uint32_t node = 0; node < t->node_count; ++node) {
        if (t->uses[node].shown != t->frame || t->uses[node].refined == t->frame) continue;
        for (size_t i = 0; i < count; ++i) found += (size_t)is_item_of(t, &items[i], node);
    }
    assert_int_equal(found, drawn);
}

static cut check_cut(const psplat_tiles *t, double tau) {
    cut sum = {0};
    psplat_tiles_state state = psplat_tiles_describe(t);
    if (psplat_tile_is_ready(t, 0)) walk(t, 0, tau, &sum);
    assert_int_equal(state.drawn, sum.drawn);
    assert_int_equal(state.splats, sum.splats);
    assert_int_equal(state.missing + state.over_budget + state.leaves, sum.over);
    assert_true((state.error_pixels > tau) == (sum.over > 0));
    check_items(t, sum.drawn);
    return sum;
}

/* Random points of the box of each tile: those in the view lie in tiles that are visible. */
static void check_visible(const psplat_tiles *t, const psplat_tiles_view *view, uint32_t *random) {
    double clip[16];
    psplat_matrix_multiply(view->view->projection, view->view->view, clip);
    for (uint32_t node = 0; node < t->node_count; ++node) {
        if (t->uses[node].looked != t->frame || t->uses[node].is_visible) continue;
        for (int k = 0; k < 20; ++k) {
            const psplat_tile_volume *v = &t->nodes[node].volume;
            double p[3], c[4];
            for (int i = 0; i < 3; ++i) p[i] = v->center[i];
            for (int i = 0; i < 3; ++i) {
                double part = (2 * (double)scene_random(random) - 1) * v->half[i];
                for (int j = 0; j < 3; ++j) p[j] += part * v->axis[i][j];
            }
            for (int row = 0; row < 4; ++row)
                c[row] =
                    clip[row] * p[0] + clip[4 + row] * p[1] + clip[8 + row] * p[2] + clip[12 + row];
            assert_false(fabs(c[0]) <= c[3] && fabs(c[1]) <= c[3] && fabs(c[2]) <= c[3]);
        }
    }
}

static world make_world(int depth, int external_depth) {
    world w = {.depth = depth,
               .external_depth = external_depth,
               .missing = 0.15f,
               .early = 0.05f,
               .has_extras = 1,
               .random = 2463534242u};
    world_make_tree(&w);
    return w;
}

/* ---- tests ----------------------------------------------------------------------------------- */

static void test_cuts(void **state) {
    (void)state;
    world w = make_world(12, 5);
    psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){0});
    uint32_t random = 99;
    size_t drawn = 0, over = 0, empty = 0;
    for (int i = 0; i < VIEWS; ++i) {
        psplat_view view = view_random(&random);
        double tau = pow(2, 6 * (double)scene_random(&random) - 1);
        const psplat_tiles_view v = {.view = &view, .pixels = tau};
        if (i % 3 == 0)
            world_settle(&w, tiles, &v);
        else
            assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
        cut c = check_cut(tiles, tau);
        check_visible(tiles, &v, &random);
        if (i % 3 == 0) { /* all is there: only leaves are above tau */
            psplat_tiles_state s = psplat_tiles_describe(tiles);
            assert_int_equal(s.missing + s.over_budget, 0);
        }
        drawn += c.drawn;
        over += c.over;
        empty += !c.drawn;
    }
    print_message("%zu tiles known, %zu drawn in %d views, %zu above tau, %zu views empty\n",
                  tiles->node_count, drawn, VIEWS, over, empty);
    assert_true(drawn > 5 * VIEWS && over > 0 && empty < VIEWS / 2);
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

static void test_budget_of_splats(void **state) {
    (void)state;
    world w = make_world(8, 0);
    psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){0});
    uint32_t random = 5;
    size_t held = 0;
    for (int i = 0; i < 200; ++i) {
        psplat_view view = view_random(&random);
        const psplat_tiles_view v = {.view = &view, .pixels = 0.5, .max_splats = 20 + (size_t)i};
        world_settle(&w, tiles, &v);
        cut c = check_cut(tiles, 0.5);
        assert_true(c.splats <= v.max_splats);
        held += psplat_tiles_describe(tiles).over_budget > 0;
    }
    assert_true(held > 20);
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

/* With a budget the errors that remain are smaller than those of tiles chosen in another order: the
 * greatest error of a cut with as many splats as one without a budget has is that of it. */
static void test_best_first(void **state) {
    (void)state;
    world w = make_world(8, 0);
    psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){0});
    psplat_view view = {.width = 400, .height = 400};
    view_perspective(&view, 0.5, 0.01, 100);
    view_look_at(&view, (double[]){5, 2, 1}, (double[]){0, 0, 0});
    psplat_tiles_view v = {.view = &view, .pixels = 0.01};
    world_settle(&w, tiles, &v);
    double last = HUGE_VAL;
    for (size_t budget = 20; budget < 2000; budget *= 2) {
        v.max_splats = budget;
        assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
        psplat_tiles_state s = psplat_tiles_describe(tiles);
        assert_true(s.error_pixels <= last);
        last = s.error_pixels;
    }
    assert_true(last < 60); /* pixels; the root has 400 * 0.4 / 5 and more */
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

/* The eye goes away from a tile and comes back: it is replaced at tau and put back at 0.9 tau. */
static void test_hysteresis(void **state) {
    (void)state;
    world w = make_world(1, 0);
    psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){0});
    psplat_view view = {.width = 200, .height = 200};
    view_perspective(&view, 1, 0.01, 1000);
    /* 0.4 units take 0.4 * 100 / (distance - 4) pixels in front of the face x = 4. */
    const double pixels[] = {0.95, 0.99, 1.01, 0.99, 0.95, 0.91, 0.89, 0.95, 0.99, 1.01};
    const int refined[] = {0, 0, 1, 1, 1, 1, 0, 0, 0, 1};
    const double far = 4 + 40 / 0.5;
    view_look_at(&view, (double[]){far, 0, 0}, (double[]){0, 0, 0});
    psplat_tiles_view v = {.view = &view};
    v.pixels = 0.1;
    world_settle(&w, tiles, &v);
    v.pixels = 1;
    assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
    for (int i = 0; i < 10; ++i) {
        view_look_at(&view, (double[]){4 + 40 / pixels[i], 0, 0}, (double[]){0, 0, 0});
        assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
        assert_int_equal(tiles->uses[0].refined == tiles->frame, refined[i]);
        if (!refined[i]) assert_near(psplat_tiles_describe(tiles).error_pixels, pixels[i], 1e-4);
    }
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

/* Moves a point of the volume by a length along the image plane and measures the pixels. */
static double measure(const psplat_tiles_view *v, const double point[3], const double along[3]) {
    double modelview[16], clip[16], at[2][2];
    psplat_matrix_multiply(v->view->view, v->transform, modelview);
    psplat_matrix_multiply(v->view->projection, modelview, clip);
    for (int k = 0; k < 2; ++k) {
        double p[3], c[4];
        for (int i = 0; i < 3; ++i) p[i] = point[i] + (k ? along[i] : 0);
        for (int row = 0; row < 4; ++row)
            c[row] =
                clip[row] * p[0] + clip[4 + row] * p[1] + clip[8 + row] * p[2] + clip[12 + row];
        if (!(fabs(c[0]) <= c[3] && fabs(c[1]) <= c[3] && fabs(c[2]) <= c[3])) return -1;
        at[k][0] = 0.5 * v->view->width * c[0] / c[3];
        at[k][1] = 0.5 * v->view->height * c[1] / c[3];
    }
    return hypot(at[1][0] - at[0][0], at[1][1] - at[0][1]);
}

static psplat_tile_volume random_volume(uint32_t *random) {
    static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    double numbers[12];
    psplat_tile_volume volume;
    for (int i = 0; i < 12; ++i) numbers[i] = 2 * (double)scene_random(random) - 1;
    if (scene_random(random) < 0.3f) {
        numbers[3] = fabs(numbers[3]);
        psplat_tile_volume_sphere(numbers, identity, &volume);
    } else {
        cross3(numbers + 3, numbers + 6, numbers + 9);
        cross3(numbers + 3, numbers + 9, numbers + 6);
        psplat_tile_volume_box(numbers, identity, &volume);
    }
    return volume;
}

static void random_point(const psplat_tile_volume *volume, uint32_t *random, double p[3]) {
    double away[3];
    for (int i = 0; i < 3; ++i) {
        p[i] = volume->center[i];
        away[i] = 2 * (double)scene_random(random) - 1;
    }
    unit3(away);
    for (int i = 0; i < 3; ++i) {
        double part = (2 * (double)scene_random(random) - 1) * volume->half[i];
        for (int j = 0; j < 3; ++j) p[j] += part * volume->axis[i][j];
        p[i] += volume->round * away[i];
    }
}

/* A length that lies along the image plane at any visible point of a volume never takes more pixels
 * than the scale of the volume says; and at the nearest point about as many. */
static void test_scales(void **state) {
    (void)state;
    uint32_t random = 3;
    size_t measured = 0, tight = 0;
    for (int i = 0; i < 2000; ++i) {
        psplat_view view = view_random(&random);
        psplat_tiles_view v = {.view = &view};
        psplat_tile_camera camera;
        double scale = pow(10, 2 * (double)scene_random(&random) - 1), most = 0;
        for (int k = 0; k < 3; ++k) v.transform[5 * k] = scale;
        if (i % 4 == 0) v.transform[4] = v.transform[9] = 0.3 * scale; /* sheared */
        if (i % 4 == 1) v.transform[10] *= -0.5;                       /* mirrored, not uniform */
        v.transform[15] = 1;
        assert_int_equal(psplat_tile_camera_set(&camera, &v, NULL), PSPLAT_OK);
        psplat_tile_volume volume = random_volume(&random);
        double bound = psplat_tile_camera_scale(&camera, &volume), inverse[16], modelview[16];
        psplat_matrix_multiply(view.view, v.transform, modelview);
        assert_int_equal(psplat_matrix_invert(modelview, inverse), 1);
        for (int k = 0; k < 40; ++k) {
            double point[3], along[3], unit[2], length;
            random_point(&volume, &random, point);
            for (int j = 0; j < 2; ++j) unit[j] = 2 * (double)scene_random(&random) - 1;
            for (int j = 0; j < 3; ++j) along[j] = inverse[j] * unit[0] + inverse[4 + j] * unit[1];
            length = sqrt(psplat_dot3(along, along));
            for (int j = 0; j < 3; ++j) along[j] *= 1e-4 / length;
            double pixels = measure(&v, point, along) / 1e-4;
            if (pixels < 0) continue;
            assert_true(psplat_tile_camera_sees(&camera, &volume));
            assert_true(pixels <= bound * (1 + 1e-5));
            most = fmax(most, pixels);
            ++measured;
        }
        tight += i % 4 > 1 && most > 0.5 * bound; /* uniform transforms */
    }
    print_message("%zu lengths measured; %zu of 1000 volumes within half of their bound\n",
                  measured, tight);
    assert_true(measured > 10000 && tight > 200);
}

/* A disc around each normal of a cone: where the camera says that backs alone are seen, every point
 * of the volume has every normal turned away. */
static void test_cones(void **state) {
    (void)state;
    uint32_t random = 11;
    size_t hidden = 0, away = 0;
    for (int i = 0; i < 20000; ++i) {
        psplat_view view = view_random(&random);
        const psplat_tiles_view v = {.view = &view};
        psplat_tile_camera camera;
        assert_int_equal(psplat_tile_camera_set(&camera, &v, NULL), PSPLAT_OK);
        psplat_tile_volume volume = random_volume(&random);
        double cone[4], to_eye[3], normal[3], point[3];
        for (int k = 0; k < 3; ++k) cone[k] = 2 * (double)scene_random(&random) - 1;
        unit3(cone);
        cone[3] = (double)scene_random(&random);
        int is_hidden = psplat_tile_camera_sees_backs(&camera, &volume, cone), faces = 0;
        for (int k = 0; k < 30; ++k) {
            random_point(&volume, &random, point);
            for (int j = 0; j < 3; ++j) normal[j] = 2 * (double)scene_random(&random) - 1;
            unit3(normal);
            if (psplat_dot3(normal, cone) < cone[3]) memcpy(normal, cone, sizeof normal);
            for (int j = 0; j < 3; ++j)
                to_eye[j] = camera.is_perspective ? camera.eye[j] - point[j] : -camera.direction[j];
            faces |= psplat_dot3(to_eye, normal) > 0;
        }
        assert_false(is_hidden && faces);
        hidden += (size_t)is_hidden;
        away += !faces;
    }
    print_message("%zu of %zu volumes turned away are hidden\n", hidden, away);
    assert_true(hidden > 1000);
}

/* A tileset that is placed in the scene is drawn as one that stands there: by the same tiles, whose
 * items have the transform. */
static void test_placed_tilesets(void **state) {
    (void)state;
    world w = make_world(7, 3);
    psplat_tiles *tiles[2];
    uint32_t random = 2463534242u;
    size_t drawn = 0;
    for (int i = 0; i < 2; ++i) tiles[i] = world_open(&w, (psplat_tiles_desc){0});
    for (int i = 0; i < 60; ++i) {
        psplat_view view = view_random(&random), other = view;
        psplat_tiles_view v[2] = {{.view = &view, .pixels = 3}, {.view = &other, .pixels = 3}};
        const double turn[16] = {0, 0, -3, 0, 0, 3, 0, 0, 3, 0, 0, 0, 100, -20, 7, 1};
        double inverse[16];
        memcpy(v[1].transform, turn, sizeof turn);
        /* The eye moves along; its space stays as large as it is, so that the tileset is three
         * times as large in it. */
        for (int k = 0; k < 16; ++k)
            if (k % 4 < 3) view.view[k] *= k < 12 ? 3 : 1;
        assert_int_equal(psplat_matrix_invert(turn, inverse), 1);
        psplat_matrix_multiply(view.view, inverse, other.view);
        for (int k = 0; k < 2; ++k) world_settle(&w, tiles[k], &v[k]);
        psplat_tiles_state a = psplat_tiles_describe(tiles[0]), b = psplat_tiles_describe(tiles[1]);
        assert_int_equal(a.drawn, b.drawn);
        assert_int_equal(a.splats, b.splats);
        assert_near(a.error_pixels, b.error_pixels, 1e-6 * a.error_pixels);
        size_t count = 0;
        const psplat_item *items = psplat_tiles_items(tiles[1], &count);
        for (size_t k = 0; k < count; ++k)
            for (int j = 0; j < 16; ++j) assert_near(items[k].transform[j], turn[j], 1e-12);
        drawn += count;
    }
    assert_true(drawn > 500);
    for (int i = 0; i < 2; ++i) psplat_tiles_destroy(tiles[i], NULL);
    world_free(&w);
}

/* A root without a content: its children are drawn as soon as each is there. */
static void test_empty_root(void **state) {
    (void)state;
    world w = {0};
    world_make_glbs(&w);
    text_put(world_add_file(&w, "tileset.json"),
             "{\"asset\":{\"version\":\"1.0\"},\"geometricError\":9,\"root\":{\"refine\":\"ADD\","
             "\"geometricError\":5,\"boundingVolume\":{\"sphere\":[0,0,0,3]},\"children\":[");
    for (int i = 0; i < 3; ++i)
        text_put(&w.texts[0],
                 "%s{\"geometricError\":1,\"boundingVolume\":{\"sphere\":[%d,0,0,1]},"
                 "\"content\":{\"uri\":\"%d.glb\"}}",
                 i ? "," : "", 2 * i - 2, i);
    text_put(&w.texts[0], "]}}");
    psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){.fade_seconds = 1});
    psplat_view view = {.width = 300, .height = 300};
    view_perspective(&view, 0.5, 0.01, 100);
    view_look_at(&view, (double[]){0, 1, 20}, (double[]){0, 0, 0});
    const psplat_tiles_view v = {.view = &view};
    for (size_t i = 0; i <= 3; ++i) {
        psplat_tile_request request;
        size_t count = 0;
        assert_int_equal(psplat_tiles_select(tiles, &v, NULL), PSPLAT_OK);
        psplat_tiles_items(tiles, &count);
        assert_int_equal(count, i);
        if (i == 3) break;
        assert_int_equal(psplat_tiles_wanted(tiles, &request, 1), 1);
        assert_int_equal(world_supply(&w, tiles, request.tile, request.path, NULL), PSPLAT_OK);
        assert_int_equal(psplat_tiles_upload(tiles, NULL, 0, NULL), PSPLAT_OK);
    }
    assert_int_equal(psplat_tiles_describe(tiles).leaves, 3);
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

/* ---- backs ------------------------------------------------------------------------------------
 */

/* A root with two halves, whose normals look to +z and to -z of the host. */
static const char halves[] =
    "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":1,\"root\":{\"refine\":\"REPLACE\","
    "\"geometricError\":1,\"boundingVolume\":{\"sphere\":[0,0,0,2]},"
    "\"content\":{\"uri\":\"a.glb\"},\"extras\":{\"phongsplat\":{\"cone\":[0,-1,0,-1]}},"
    "\"children\":[{\"geometricError\":0.1,\"boundingVolume\":{\"sphere\":[0,0,0,1]},"
    "\"content\":{\"uri\":\"b.glb\"},\"extras\":{\"phongsplat\":{\"cone\":[0,-1,0,0.8]}}},"
    "{\"geometricError\":0.1,\"boundingVolume\":{\"sphere\":[0,0,0,1]},"
    "\"content\":{\"uri\":\"c.glb\"},\"extras\":{\"phongsplat\":{\"cone\":[0,1,0,0.8]}}}]}}";

/* Returns how many of the halves are drawn, and adds the requests to *requests. */
static size_t draw_halves(int is_double_sided, psplat_culling culling, size_t *requests) {
    world w = {0};
    scene s = scene_blank(3);
    s.material.double_sided = is_double_sided;
    for (int i = 0; i < WORLD_GLBS; ++i) w.glbs[i] = scene_glb(&s, &w.glb_sizes[i]);
    scene_free(&s);
    text_put(world_add_file(&w, "tileset.json"), "%s", halves);
    psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){0});
    psplat_view view = {.width = 300, .height = 300, .culling = culling};
    view_perspective(&view, 0.5, 0.01, 100);
    view_look_at(&view, (double[]){0.5, 1, 20}, (double[]){0, 0, 0});
    const psplat_tiles_view v = {.view = &view, .pixels = 2};
    *requests = world_settle(&w, tiles, &v);
    size_t drawn = psplat_tiles_describe(tiles).drawn;
    assert_true(psplat_tile_camera_sees_backs(&(psplat_tile_camera){.direction = {0, 0, -1}},
                                              &tiles->nodes[2].volume, tiles->uses[2].cone));
    assert_true(tiles->uses[0].cone[3] < 0); /* all normals there are */
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
    return drawn;
}

/* Only backs of single-sided materials are left out, and then they are not even read. */
static void test_backs(void **state) {
    (void)state;
    size_t requests = 0;
    assert_int_equal(draw_halves(0, PSPLAT_CULL_BY_MATERIAL, &requests), 1);
    assert_int_equal(requests, 2);
    assert_int_equal(draw_halves(1, PSPLAT_CULL_BY_MATERIAL, &requests), 2);
    assert_int_equal(requests, 3);
    assert_int_equal(draw_halves(0, PSPLAT_CULL_NEVER, &requests), 2);
    assert_int_equal(draw_halves(1, PSPLAT_CULL_ALWAYS, &requests), 1);
}

/* The cone around two holds all of both and is no wider than it has to be. */
static void test_cone_sums(void **state) {
    (void)state;
    uint32_t random = 2463534242u;
    for (int i = 0; i < 3000; ++i) {
        double cones[2][4], sum[4];
        for (int k = 0; k < 2; ++k) {
            for (int j = 0; j < 3; ++j) cones[k][j] = 2 * (double)scene_random(&random) - 1;
            unit3(cones[k]);
            cones[k][3] = cos(1.5 * (double)scene_random(&random));
        }
        if (i % 10 == 0) memcpy(cones[1], cones[0], 3 * sizeof *sum);
        memcpy(sum, cones[0], sizeof sum);
        psplat_tile_cone_add(sum, cones[1]);
        if (sum[3] < -1) continue;
        double half = acos(sum[3]), widest = 0;
        for (int k = 0; k < 2; ++k) {
            double between = acos(fmin(psplat_dot3(sum, cones[k]), 1));
            assert_true(between + acos(cones[k][3]) <= half + 1e-6);
            widest = fmax(widest, between + acos(cones[k][3]));
        }
        assert_near(widest, half, 1e-6);
        double none[4] = {0, 0, 1, -2};
        psplat_tile_cone_add(sum, none);
        assert_true(sum[3] < -1);
    }
}

/* Two runs of the same calls choose the same tiles and want the same. */
static void test_determinism(void **state) {
    (void)state;
    world w = make_world(8, 3);
    psplat_tiles *tiles[2];
    for (int i = 0; i < 2; ++i) tiles[i] = world_open(&w, (psplat_tiles_desc){.max_bytes = 300000});
    uint32_t random = 21;
    for (int i = 0; i < 200; ++i) {
        psplat_view view = view_random(&random);
        const psplat_tiles_view v = {.view = &view, .max_splats = 500};
        psplat_tile_request requests[2][4];
        size_t counts[2];
        for (int k = 0; k < 2; ++k) {
            assert_int_equal(psplat_tiles_select(tiles[k], &v, NULL), PSPLAT_OK);
            counts[k] = psplat_tiles_wanted(tiles[k], requests[k], 4);
            for (size_t j = 0; j < counts[k]; ++j)
                world_supply(&w, tiles[k], requests[k][j].tile, requests[k][j].path, NULL);
            assert_int_equal(psplat_tiles_upload(tiles[k], NULL, 1, NULL), PSPLAT_OK);
        }
        psplat_tiles_state a = psplat_tiles_describe(tiles[0]), b = psplat_tiles_describe(tiles[1]);
        assert_memory_equal(&a, &b, sizeof a);
        assert_int_equal(counts[0], counts[1]);
        for (size_t j = 0; j < counts[0]; ++j)
            assert_string_equal(requests[0][j].path, requests[1][j].path);
    }
    for (int i = 0; i < 2; ++i) psplat_tiles_destroy(tiles[i], NULL);
    world_free(&w);
}

/* Views that cannot be are refused, and then nothing is drawn. */
static void test_refused_views(void **state) {
    (void)state;
    world w = make_world(2, 0);
    psplat_tiles *tiles = world_open(&w, (psplat_tiles_desc){0});
    psplat_view good = {.width = 100, .height = 100};
    view_perspective(&good, 1, 0.01, 100);
    view_look_at(&good, (double[]){5, 5, 5}, (double[]){0, 0, 0});
    for (int i = 0; i < 7; ++i) {
        psplat_view view = good;
        psplat_tiles_view v = {.view = &view};
        psplat_error error = {0};
        size_t count = 1;
        if (i == 0) view.width = 0;
        if (i == 1) view.projection[0] = 0;
        if (i == 2) view.view[5] = NAN;
        if (i == 3) v.pixels = -1;
        if (i == 4) v.transform[0] = 1;
        if (i == 5) v.seconds = INFINITY;
        if (i == 6) v.view = NULL;
        world_settle(&w, tiles, &(psplat_tiles_view){.view = &good});
        psplat_tiles_items(tiles, &count);
        assert_true(count > 0);
        assert_int_equal(psplat_tiles_select(tiles, &v, &error), PSPLAT_ERROR_ARGUMENT);
        assert_true(error.text[0]);
        psplat_tiles_items(tiles, &count);
        assert_int_equal(count, 0);
    }
    psplat_tiles_destroy(tiles, NULL);
    world_free(&w);
}

int test_tile_selection_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cuts),
        cmocka_unit_test(test_budget_of_splats),
        cmocka_unit_test(test_best_first),
        cmocka_unit_test(test_hysteresis),
        cmocka_unit_test(test_scales),
        cmocka_unit_test(test_cones),
        cmocka_unit_test(test_placed_tilesets),
        cmocka_unit_test(test_empty_root),
        cmocka_unit_test(test_backs),
        cmocka_unit_test(test_cone_sums),
        cmocka_unit_test(test_determinism),
        cmocka_unit_test(test_refused_views),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

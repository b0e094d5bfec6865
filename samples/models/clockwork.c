/* SPDX-License-Identifier: MIT
 *
 * clockwork.c - a scene with animations: a pendulum that swings, a hand that ticks and a ball that
 * bounces on a stand, which turns. There is each kind of channel and of interpolation, a node
 * without a name that moves and has a mesh, and nodes that are moved through two others.
 */
#include "gltf_parts.h"

#include <math.h>

/* Stores the quaternion of a turn about one axis. */
static void turn(double *q, int axis, double degrees) {
    double half = degrees * PI / 360;
    for (int k = 0; k < 3; ++k) q[k] = k == axis ? sin(half) : 0;
    q[3] = cos(half);
}

static void print_sampler(bytes *json, const char *before, int times, int values,
                          const char *interpolation) {
    print(json, "%s{\"input\":%d,\"output\":%d,\"interpolation\":\"%s\"}", before, times, values,
          interpolation);
}

/* The pendulum swings by 25 degrees to either side, the hand goes 45 degrees each quarter of a
 * second. */
static void print_tick(bytes *json, scene *g) {
    enum { SWINGS = 9, TICKS = 9 };
    double times[SWINGS], swing[4 * SWINGS], tick[4 * TICKS];
    for (int i = 0; i < SWINGS; ++i) {
        times[i] = 0.25 * i;
        turn(swing + 4 * i, 2, 25 * sin(PI * times[i]));
    }
    for (int i = 0; i < TICKS; ++i) turn(tick + 4 * i, 2, -45 * i);
    int at = add_numbers(g, times, SWINGS, 1), swings = add_numbers(g, swing, SWINGS, 4);
    print(json, "{\"name\":\"tick\",\"samplers\":");
    print_sampler(json, "[", at, swings, "LINEAR");
    print_sampler(json, ",", at, add_numbers(g, tick, TICKS, 4), "STEP");
    print(json, "],\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"rotation\"}},"
                "{\"sampler\":1,\"target\":{\"node\":4,\"path\":\"rotation\"}}]}");
}

/* The ball rises by 1.2 within half a second and falls again: its path is a parabola, the tangents
 * at the ends of which are those of a throw. It is squashed where it is at rest. */
static void print_bounce(bytes *json, scene *g) {
    const double times[] = {0, 0.5, 1}, squashes[] = {0, 0.125, 0.875, 1};
    const double low = -1.25, rise = 1.2, speed = 4 * rise;
    const double path[] = {0, 0,      0, 0.6, low,        0, 0, speed, 0, /* up */
                           0, 0,      0, 0.6, low + rise, 0, 0, 0,     0,
                           0, -speed, 0, 0.6, low,        0, 0, 0,     0};
    const double scales[] = {0.3, 0.2, 0.3, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25, 0.3, 0.2, 0.3};
    int at = add_numbers(g, times, 3, 1), values = add_numbers(g, path, 9, 3);
    int squash = add_numbers(g, squashes, 4, 1);
    print(json, ",{\"name\":\"bounce\",\"samplers\":");
    print_sampler(json, "[", at, values, "CUBICSPLINE");
    print_sampler(json, ",", squash, add_numbers(g, scales, 4, 3), "LINEAR");
    print(json, "],\"channels\":[{\"sampler\":0,\"target\":{\"node\":5,\"path\":\"translation\"}},"
                "{\"sampler\":1,\"target\":{\"node\":5,\"path\":\"scale\"}}],"
                "\"extras\":{\"loops\":true}}");
}

/* All of it turns once, by quaternions every second of which has the other sign. */
static void print_turn(bytes *json, scene *g) {
    const double times[] = {0, 1, 2, 3, 4};
    double turns[4 * 5];
    for (int i = 0; i < 5; ++i) {
        turn(turns + 4 * i, 1, 90 * i);
        for (int k = 0; k < 4 && i % 2; ++k) turns[4 * i + k] *= -1;
    }
    int at = add_numbers(g, times, 5, 1), values = add_numbers(g, turns, 5, 4);
    print(json, ",{\"name\":\"turn\",\"samplers\":");
    print_sampler(json, "[", at, values, "LINEAR");
    print(json, "],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"rotation\"}}]}");
}

static void print_nodes(bytes *json) {
    print(json, ",\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                "\"nodes\":[{\"name\":\"clock\",\"children\":[1,2,4,5]},"
                "{\"name\":\"stand\",\"mesh\":0,\"translation\":[0,-1.6,0]},"
                "{\"name\":\"pendulum\",\"translation\":[-0.7,1,0],\"children\":[3,6]},"
                "{\"name\":\"bob\",\"mesh\":2,\"translation\":[0,-1.5,0],"
                "\"scale\":[0.3,0.3,0.3]},"
                "{\"name\":\"hand\",\"translation\":[0.6,0.7,0],\"children\":[7]},"
                "{\"mesh\":2,\"translation\":[0.6,-1.25,0],\"scale\":[0.25,0.25,0.25]},"
                "{\"mesh\":1,\"translation\":[0,-0.7,0]},"
                "{\"mesh\":3,\"translation\":[0,0.25,0]}]");
}

static void print_material(bytes *json, const char *before, const char *color) {
    print(json,
          "%s{\"pbrMetallicRoughness\":{\"baseColorFactor\":[%s,1],\"metallicFactor\":0.1,"
          "\"roughnessFactor\":0.5}}",
          before, color);
}

int write_clockwork(const char *path) {
    static const char *const names[4] = {"stand", "rod", "ball", "hand"};
    solid shapes[4] = {make_box(2.6, 0.2, 1), make_box(0.1, 1.4, 0.1), make_sphere(2),
                       make_box(0.16, 0.7, 0.08)};
    scene g = {0};
    bytes json = {0};
    print(&json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"phongsplat generate_models\"}");
    print_nodes(&json);
    print(&json, ",\"materials\":");
    print_material(&json, "[", "0.3,0.35,0.4");
    print_material(&json, ",", "0.8,0.65,0.3");
    print_material(&json, ",", "0.7,0.2,0.15");
    print_material(&json, ",", "0.1,0.1,0.1");
    print(&json, "],\"meshes\":");
    for (int i = 0; i < 4; ++i) {
        int positions = add_positions(&g, &shapes[i]), indices = add_indices(&g, &shapes[i]);
        print(&json,
              "%s{\"name\":\"%s\",\"primitives\":[{\"attributes\":{\"POSITION\":%d},"
              "\"indices\":%d,\"material\":%d}]}",
              i ? "," : "[", names[i], positions, indices, i);
    }
    print(&json, "],\"animations\":[");
    print_tick(&json, &g);
    print_bounce(&json, &g);
    print_turn(&json, &g);
    print(&json, "]");
    print_tables(&json, &g);
    print(&json, "}]}");
    int result = write_glb(path, &json, &g);
    free_scene(&g, &json);
    for (int i = 0; i < 4; ++i) solid_free(&shapes[i]);
    return result;
}

/* SPDX-License-Identifier: MIT
 *
 * still_life.c - a scene: cups, pears and dice on a round table under two lights. Meshes are placed
 * several times by nested, mirrored and stretched nodes, one of them with a matrix. Nodes have
 * names, extras, a camera and lights, and there is a second scene.
 */
#include "gltf_parts.h"

#include <math.h>
#include <stdlib.h>

/* ---- shapes --------------------------------------------------------------------------------- */

/* Makes a surface of revolution about y. The profile runs from the axis back to the axis, so that
 * the surface closes; its outside is on the right of the profile. */
static solid revolve(const double (*profile)[2], int rows, int segments) {
    solid s = {0};
    for (int row = 0; row + 1 < rows; ++row)
        for (int i = 0; i < segments; ++i) {
            uint32_t v[4];
            for (int k = 0; k < 4; ++k) {
                const double *p = profile[row + k / 2];
                double angle = 2 * PI * ((i + (k == 1 || k == 2)) % segments) / segments;
                v[k] = solid_vertex(&s, p[0] * cos(angle), p[1], -p[0] * sin(angle));
            }
            solid_quad(&s, v[0], v[1], v[2], v[3]);
        }
    return s;
}

/* Makes the table; its top shows the texture four times across. */
static solid make_table(void) {
    static const double profile[][2] = {{0, -0.2}, {1.5, -0.2}, {2.9, -0.2}, {3, -0.1},
                                        {3, 0},    {2, 0},      {1, 0},      {0, 0}};
    solid s = revolve(profile, 8, 48);
    s.texcoords = resize(NULL, s.vertex_count * sizeof *s.texcoords);
    for (size_t i = 0; i < s.vertex_count; ++i)
        for (int k = 0; k < 2; ++k) s.texcoords[i][k] = (float)(s.positions[i][2 * k] / 6 * 4 + 2);
    return s;
}

static solid make_cup(void) {
    enum { WALL = 10, ROWS = 2 * WALL + 2 };
    double profile[ROWS][2] = {{0, 0}};
    for (int i = 0; i < WALL; ++i) {
        double t = (double)i / (WALL - 1), radius = 0.32 + 0.23 * sin(1.4 * t);
        profile[1 + i][0] = radius;
        profile[1 + i][1] = t;
        profile[ROWS - 2 - i][0] = radius - 0.06;
        profile[ROWS - 2 - i][1] = 0.08 + 0.92 * t;
    }
    profile[ROWS - 1][1] = 0.08;
    return revolve((const double(*)[2])profile, ROWS, 32);
}

/* Makes a sphere with a leaning neck, so that it differs from its mirror image. */
static solid make_pear(void) {
    solid s = make_sphere(3);
    for (size_t i = 0; i < s.vertex_count; ++i) {
        double *p = s.positions[i], y = p[1], neck = 1 / (1 + exp(-5 * (y - 0.2)));
        double width = 0.5 * (1 - 0.5 * neck);
        p[0] = width * p[0] + 0.16 * neck * (y + 0.4);
        p[1] = 0.5 + 0.5 * y + 0.2 * neck;
        p[2] = width * p[2] * (1 + 0.15 * p[0]);
    }
    return s;
}

/* ---- the file ------------------------------------------------------------------------------- */

/* Adds a texture of planks, 32 x 32 pixels. */
static int add_planks(scene *g) {
    enum { SIZE = 32 };
    static uint8_t rgb[SIZE][SIZE][3];
    for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x) {
            int plank = x / 8, gap = x % 8 == 0, grain = (x * 7 + y * (3 + plank)) % 5;
            rgb[y][x][0] = (uint8_t)(gap ? 60 : 150 + 12 * (plank % 2) + 4 * grain);
            rgb[y][x][1] = (uint8_t)(gap ? 35 : 95 + 10 * (plank % 2) + 3 * grain);
            rgb[y][x][2] = (uint8_t)(gap ? 20 : 50 + 6 * (plank % 2) + 2 * grain);
        }
    size_t size, begin = g->buffer.size;
    uint8_t *png = make_png(&rgb[0][0][0], SIZE, SIZE, &size);
    put(&g->buffer, png, size);
    free(png);
    return add_view(g, begin, 0);
}

static void print_graph(bytes *json) {
    print(json, ",\"scene\":0,\"scenes\":[{\"name\":\"still life\",\"nodes\":[0,11,12],\"extras\":{"
                "\"painter\":\"nobody\",\"year\":2004}},{\"name\":\"spare\",\"nodes\":[14]}]");
    print(json,
          ",\"nodes\":[{\"name\":\"arrangement\",\"children\":[1,2,6,9,10],\"extras\":{"
          "\"tags\":[\"cups\",\"pears\",\"W\xc3\xbcrfel\",\"\\\"dice\\\"\"],\"size\":3.25}},"
          "{\"name\":\"table\",\"mesh\":0},"
          "{\"name\":\"tray\",\"translation\":[-0.9,0,-0.4],"
          "\"rotation\":[0,0.3826834323650898,0,0.9238795325112867],\"children\":[3,4,5]},"
          "{\"name\":\"cup\",\"mesh\":1,\"translation\":[-0.7,0,0.3],\"extras\":[1,null,true]},"
          "{\"name\":\"cup, larger and mirrored\",\"mesh\":1,\"translation\":[0.6,0,0],"
          "\"scale\":[-1.2,1.2,1.2]},");
    print(json, "{\"name\":\"beaker\",\"mesh\":1,\"translation\":[-0.1,0,-1],"
                "\"scale\":[0.7,1.9,0.7],\"children\":[13]},"
                "{\"name\":\"pears\",\"translation\":[1,0,0.5],\"children\":[7,8]},"
                "{\"name\":\"pear\",\"mesh\":2},"
                "{\"name\":\"pear, lying\",\"mesh\":2,"
                "\"matrix\":[-0.6,0.8,0,0, 0.8,0.6,0,0, 0,0,1,0, -0.6,0.3,0.9,1]},"
                "{\"mesh\":3,\"translation\":[0.2,0.25,1.5],"
                "\"rotation\":[0,0.19509032201612825,0,0.9807852804032304]},"
                "{\"mesh\":3,\"translation\":[0.25,0.75,1.5],"
                "\"rotation\":[0,0.5555702330196022,0,0.8314696123025452]},");
    print(json, "{\"name\":\"eye\",\"camera\":0,\"translation\":[0,3.2,6.4],"
                "\"rotation\":[-0.1950903220161282,0,0,0.9807852804032304]},"
                "{\"name\":\"window\",\"rotation\":[-0.4,0.2,0.1,0.8888194417315589],"
                "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
                "{\"name\":\"candle\",\"translation\":[0,1.1,0],"
                "\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}},"
                "{\"name\":\"spare cup\",\"mesh\":1,\"scale\":[0.5,0.5,0.5]}]");
}

static void print_looks(bytes *json, int view) {
    print(json, ",\"cameras\":[{\"name\":\"easel\",\"type\":\"perspective\",\"perspective\":{"
                "\"aspectRatio\":1.3333333333333333,\"yfov\":0.7,\"znear\":0.1,\"zfar\":100},"
                "\"extras\":{\"lens\":\"50 mm\"}}]");
    print(json, ",\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{"
                "\"KHR_lights_punctual\":{\"lights\":[{\"name\":\"sky\",\"type\":\"directional\","
                "\"color\":[0.9,0.95,1],\"intensity\":3},{\"name\":\"flame\",\"type\":\"point\","
                "\"color\":[1,0.7,0.4],\"intensity\":2,\"range\":8,\"extras\":{\"flickers\":false}"
                "}]}}");
    print(json,
          ",\"images\":[{\"bufferView\":%d,\"mimeType\":\"image/png\"}],"
          "\"textures\":[{\"source\":0}],\"materials\":["
          "{\"name\":\"planks\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},"
          "\"metallicFactor\":0,\"roughnessFactor\":0.7}},"
          "{\"name\":\"glaze\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.16,0.3,0.6,1],"
          "\"metallicFactor\":0.1,\"roughnessFactor\":0.25},\"extras\":{\"fired\":1280}},"
          "{\"name\":\"skin\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.62,0.12,1],"
          "\"metallicFactor\":0,\"roughnessFactor\":0.5}}]",
          view);
}

/* A material below 0 is not written. */
static void print_mesh(bytes *json, const char *before, const char *name, int positions,
                       int texcoords, int indices, int material) {
    print(json, "%s{\"name\":\"%s\",\"primitives\":[{\"attributes\":{\"POSITION\":%d", before, name,
          positions);
    if (texcoords >= 0) print(json, ",\"TEXCOORD_0\":%d", texcoords);
    print(json, "},\"indices\":%d", indices);
    if (material >= 0) print(json, ",\"material\":%d", material);
    print(json, "}]%s}", material == 2 ? ",\"extras\":{\"sort\":\"Conference\"}" : "");
}

int write_still_life(const char *path) {
    static const char *const names[4] = {"table", "cup", "pear", "die"};
    solid shapes[4] = {make_table(), make_cup(), make_pear(), make_box(0.5, 0.5, 0.5)};
    scene g = {0};
    bytes json = {0};
    print(&json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"phongsplat generate_models\","
                 "\"copyright\":\"MIT\",\"extras\":{\"made\":\"by a program\"}}");
    print_graph(&json);
    print_looks(&json, add_planks(&g));
    print(&json, ",\"meshes\":");
    for (int i = 0; i < 4; ++i) {
        int positions = add_positions(&g, &shapes[i]), indices = add_indices(&g, &shapes[i]);
        int texcoords = shapes[i].texcoords ? add_texcoords(&g, &shapes[i]) : -1;
        print_mesh(&json, i ? "," : "[", names[i], positions, texcoords, indices, i < 3 ? i : -1);
    }
    print(&json, "]");
    print_tables(&json, &g);
    print(&json, "}],\"extras\":{\"nested\":{\"deeper\":[[],{}]}}}");
    int result = write_glb(path, &json, &g);
    free_scene(&g, &json);
    for (int i = 0; i < 4; ++i) solid_free(&shapes[i]);
    return result;
}

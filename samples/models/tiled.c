/* SPDX-License-Identifier: MIT
 *
 * tiled.c - a tiled barrel with every texture that a glTF material has. Half of its side mirrors
 * the coordinates of the other, the images repeat, and KHR_texture_transform turns them.
 */
#include "gltf_parts.h"

#include <math.h>
#include <stdlib.h>

/* The images hold 2 x 2 tiles. */
enum { SIZE = 64, TILE = SIZE / 2, GROUT = 2, BEVEL = 4 };
enum { ROWS = 17, SEGMENTS = 48, RINGS = 6 };

typedef struct pixel {
    uint8_t rgb[3];
} pixel;

/* ---- the images ------------------------------------------------------------------------------ */

static int tile_of(int x, int y) {
    return y / TILE * 2 + x / TILE;
}

/* Returns the distance in pixels from the nearest edge of the tile. */
static int depth_of(int x, int y) {
    int dx = x % TILE < TILE / 2 ? x % TILE : TILE - 1 - x % TILE;
    int dy = y % TILE < TILE / 2 ? y % TILE : TILE - 1 - y % TILE;
    return dx < dy ? dx : dy;
}

/* Returns whether a pixel belongs to the letter F on the first tile, which shows how charts are
 * turned and mirrored. */
static int is_letter(int x, int y) {
    if (tile_of(x, y)) return 0;
    int stem = x >= 10 && x < 14 && y >= 7 && y < 25;
    int top = x >= 10 && x < 23 && y >= 7 && y < 11,
        middle = x >= 10 && x < 20 && y >= 14 && y < 18;
    return stem || top || middle;
}

static pixel base_color(int x, int y) {
    static const pixel tiles[4] = {
        {{236, 226, 200}}, {{32, 84, 140}}, {{200, 150, 60}}, {{240, 240, 244}}};
    if (depth_of(x, y) < GROUT) return (pixel){{110, 104, 96}};
    if (is_letter(x, y)) return (pixel){{160, 32, 40}};
    return tiles[tile_of(x, y)];
}

/* Occlusion in the grout; rough grout; the third tile is of metal. */
static pixel finish(int x, int y) {
    if (depth_of(x, y) < GROUT) return (pixel){{120, 235, 0}};
    return (pixel){{255, (uint8_t)(tile_of(x, y) == 1 ? 50 : 110), tile_of(x, y) == 2 ? 255 : 0}};
}

/* The edges of tiles are bevelled: x of a normal points right and y up. */
static pixel normal(int x, int y) {
    int left = x % TILE < BEVEL, right = x % TILE >= TILE - BEVEL;
    int top = y % TILE < BEVEL, bottom = y % TILE >= TILE - BEVEL;
    double across = 0.5 * (right - left), up = 0.5 * (top - bottom);
    double length = sqrt(1 + across * across + up * up), n[3] = {across, up, 1};
    pixel p;
    for (int k = 0; k < 3; ++k) p.rgb[k] = (uint8_t)(127.5 + 127.5 * n[k] / length + 0.5);
    return p;
}

/* A lamp in the middle of each fourth tile, where the base colour's is blue. */
static pixel emissive(int x, int y) {
    int dx = x % TILE - TILE / 2, dy = y % TILE - TILE / 2;
    if (tile_of(x, y) != 1 || dx * dx + dy * dy > 20) return (pixel){{0, 0, 0}};
    return (pixel){{255, 190, 90}};
}

static int add_image(scene *g, pixel (*at)(int x, int y)) {
    static uint8_t rgb[SIZE][SIZE][3];
    for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x) {
            pixel p = at(x, y);
            for (int k = 0; k < 3; ++k) rgb[y][x][k] = p.rgb[k];
        }
    size_t size, begin = g->buffer.size;
    uint8_t *png = make_png(&rgb[0][0][0], SIZE, SIZE, &size);
    put(&g->buffer, png, size);
    free(png);
    return add_view(g, begin, 0);
}

/* ---- the barrel ------------------------------------------------------------------------------ */

static uint32_t add_vertex(solid *s, const double position[3], const double direction[3], double u,
                           double v) {
    size_t i = s->vertex_count++;
    double length = sqrt(direction[0] * direction[0] + direction[1] * direction[1] +
                         direction[2] * direction[2]);
    for (int k = 0; k < 3; ++k) {
        s->positions[i][k] = position[k];
        s->normals[i][k] = (float)(direction[k] / length);
    }
    s->texcoords[i][0] = (float)u;
    s->texcoords[i][1] = (float)v;
    return (uint32_t)i;
}

static double angle_of(int segment) {
    return 2 * PI * (segment % SEGMENTS) / SEGMENTS;
}

static double radius_at(double t) {
    return 0.5 + 0.16 * sin(PI * t);
}

/* Adds the side. Along its second half the coordinates go back. */
static void add_side(solid *s) {
    for (int row = 0; row < ROWS; ++row)
        for (int i = 0; i <= SEGMENTS; ++i) {
            double t = (double)row / (ROWS - 1), c = cos(angle_of(i)), z = -sin(angle_of(i));
            double r = radius_at(t), slope = 0.16 * PI * cos(PI * t) / 1.4;
            double forth = 1 - fabs(1 - 2.0 * i / SEGMENTS);
            uint32_t v = add_vertex(s, (double[]){r * c, 1.4 * t - 0.7, r * z},
                                    (double[]){c, -slope, z}, 3 * forth, 2 * (1 - t));
            if (!row || !i) continue;
            uint32_t below = v - (SEGMENTS + 1);
            solid_triangle(s, below - 1, below, v);
            solid_triangle(s, below - 1, v, v - 1);
        }
}

/* Adds the lid, or the bottom where up is -1, with coordinates straight from above. */
static void add_cap(solid *s, double up) {
    double direction[3] = {0, up, 0};
    uint32_t center = add_vertex(s, (double[]){0, 0.7 * up, 0}, direction, 0.5, 0.5);
    for (int ring = 1; ring <= RINGS; ++ring)
        for (int i = 0; i < SEGMENTS; ++i) {
            double r = 0.5 * ring / RINGS, x = r * cos(angle_of(i)), z = -r * sin(angle_of(i));
            add_vertex(s, (double[]){x, 0.7 * up, z}, direction, 0.5 + 1.5 * x, 0.5 + 1.5 * up * z);
        }
    for (uint32_t ring = 0; ring < RINGS; ++ring)
        for (uint32_t i = 0; i < SEGMENTS; ++i) {
            uint32_t j = (i + 1) % SEGMENTS, outer = center + 1 + ring * SEGMENTS;
            uint32_t inner = outer - SEGMENTS;
            uint32_t a = ring ? inner + i : center, b = ring ? inner + j : center;
            uint32_t c = outer + (up > 0 ? i : j), d = outer + (up > 0 ? j : i);
            solid_triangle(s, up > 0 ? a : b, c, d);
            solid_triangle(s, up > 0 ? a : b, d, up > 0 ? b : a);
        }
}

static solid make_barrel(void) {
    enum { COUNT = ROWS * (SEGMENTS + 1) + 2 * (1 + RINGS * SEGMENTS) };
    solid s = {.vertex_capacity = COUNT,
               .positions = resize(NULL, COUNT * sizeof *s.positions),
               .normals = resize(NULL, COUNT * sizeof *s.normals),
               .texcoords = resize(NULL, COUNT * sizeof *s.texcoords)};
    add_side(&s);
    add_cap(&s, 1);
    add_cap(&s, -1);
    return s;
}

/* ---- the file -------------------------------------------------------------------------------- */

/* Prints a textureInfo; all but the lamps are turned by a right angle. */
static void print_texture(bytes *json, const char *name, int index, const char *more,
                          const char *transform) {
    print(json, "\"%s\":{\"index\":%d%s,\"extensions\":{\"KHR_texture_transform\":{%s}}}", name,
          index, more, transform);
}

static void print_material(bytes *json) {
    static const char *const turned = "\"offset\":[0,1],\"rotation\":1.5707964";
    print(json, ",\"materials\":[{\"name\":\"tiles\",\"emissiveFactor\":[1,1,1],"
                "\"pbrMetallicRoughness\":{");
    print_texture(json, "baseColorTexture", 0, "", turned);
    print(json, ",");
    print_texture(json, "metallicRoughnessTexture", 1, "", turned);
    print(json, "},");
    print_texture(json, "occlusionTexture", 1, ",\"strength\":0.8", turned);
    print(json, ",");
    print_texture(json, "normalTexture", 2, ",\"scale\":0.9", turned);
    print(json, ",");
    print_texture(json, "emissiveTexture", 3, "", "\"offset\":[0.5,0.5],\"scale\":[1,-1]");
    print(json, "}]");
}

static void print_images(bytes *json, const int views[4]) {
    static const char *const names[4] = {"base colour", "occlusion, roughness, metallic", "normal",
                                         "emissive"};
    print(json, ",\"images\":[");
    for (int i = 0; i < 4; ++i)
        print(json, "%s{\"name\":\"%s\",\"bufferView\":%d,\"mimeType\":\"image/png\"}",
              i ? "," : "", names[i], views[i]);
    print(json, "],\"textures\":[");
    for (int i = 0; i < 4; ++i) print(json, "%s{\"source\":%d}", i ? "," : "", i);
    print(json, "]");
}

int write_tiled_glb(const char *path) {
    scene g = {0};
    bytes json = {0};
    solid s = make_barrel();
    int positions = add_positions(&g, &s), normals = add_normals(&g, &s);
    int texcoords = add_texcoords(&g, &s), indices = add_indices(&g, &s);
    const int views[4] = {add_image(&g, base_color), add_image(&g, finish), add_image(&g, normal),
                          add_image(&g, emissive)};
    print(&json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"phongsplat generate_models\"}");
    print(&json, ",\"extensionsUsed\":[\"KHR_texture_transform\"]");
    print(&json, ",\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]");
    print_images(&json, views);
    print_material(&json);
    print(&json,
          ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d,"
          "\"TEXCOORD_0\":%d},\"indices\":%d,\"material\":0}]}]",
          positions, normals, texcoords, indices);
    print_tables(&json, &g);
    print(&json, "}]}");
    int result = write_glb(path, &json, &g);
    free_scene(&g, &json);
    solid_free(&s);
    return result;
}

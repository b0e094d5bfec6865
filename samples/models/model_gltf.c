/* SPDX-License-Identifier: MIT
 *
 * model_gltf.c - writes two models as glTF 2.0: the bracket as .gltf with its buffer as a data URI,
 * and the painted piece as .glb with a texture, vertex colours and a tree of nodes, one of which
 * mirrors.
 */
#include "gltf_parts.h"

#include <stdlib.h>

/* ---- .gltf with a data URI ------------------------------------------------------------------- */

static void print_base64(bytes *json, const bytes *b) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < b->size; i += 3) {
        uint32_t bits = 0;
        char text[4];
        for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < b->size ? b->data[i + k] : 0u);
        for (int k = 0; k < 4; ++k) text[k] = digits[bits >> (18 - 6 * k) & 63];
        for (size_t k = b->size - i; k < 3; ++k) text[k + 1] = '=';
        put(json, text, 4);
    }
}

int write_gltf(const char *path, const solid *s) {
    scene g = {0};
    bytes json = {0};
    int positions = add_positions(&g, s), indices = add_indices(&g, s);
    print(&json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"phongsplat generate_models\"}");
    print(&json, ",\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]");
    print(&json, ",\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.9,0.55,0.2,1],"
                 "\"metallicFactor\":0.1,\"roughnessFactor\":0.6}}]");
    print(&json,
          ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d},\"indices\":%d,"
          "\"material\":0}]}]",
          positions, indices);
    print_tables(&json, &g);
    print(&json, ",\"uri\":\"data:application/octet-stream;base64,");
    print_base64(&json, &g.buffer);
    print(&json, "\"}]}\n");
    int result = write_file(path, &json);
    free_scene(&g, &json);
    return result;
}

/* ---- .glb ----------------------------------------------------------------------------------- */

/* Adds a checkerboard whose squares change colour across the picture. */
static int add_texture(scene *g) {
    enum { SIZE = 64 };
    static uint8_t rgb[SIZE][SIZE][3];
    for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x) {
            int dark = (x / 8 + y / 8) % 2;
            rgb[y][x][0] = (uint8_t)(dark ? 30 : 250);
            rgb[y][x][1] = (uint8_t)(dark ? 60 + x : 240 - y);
            rgb[y][x][2] = (uint8_t)(dark ? 120 : 200 - x);
        }
    size_t size, begin = g->buffer.size;
    uint8_t *png = make_png(&rgb[0][0][0], SIZE, SIZE, &size);
    put(&g->buffer, png, size);
    free(png);
    return add_view(g, begin, 0);
}

static void print_painted(bytes *json, int view) {
    print(json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"phongsplat generate_models\"}");
    print(json, ",\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":["
                "{\"name\":\"piece\",\"rotation\":[0,0.3826834,0,0.9238795],\"children\":[1,2]},"
                "{\"name\":\"vase\",\"mesh\":0,\"translation\":[0,-0.8,0]},"
                "{\"name\":\"rings\",\"translation\":[0,0.1,0],\"children\":[3,4]},"
                "{\"name\":\"ring\",\"mesh\":1,\"rotation\":[0.7071068,0,0,0.7071068],"
                "\"translation\":[0,0.35,0]},"
                "{\"name\":\"mirrored ring\",\"mesh\":1,"
                "\"matrix\":[1.1,0,0,0, 0,0.3,1,0, 0,1,-0.3,0, 0,-0.45,0,1]}]");
    print(json,
          ",\"images\":[{\"bufferView\":%d,\"mimeType\":\"image/png\"}],"
          "\"textures\":[{\"source\":0}],\"materials\":["
          "{\"name\":\"checked\",\"doubleSided\":true,\"pbrMetallicRoughness\":{"
          "\"baseColorTexture\":{\"index\":0},\"metallicFactor\":0,\"roughnessFactor\":0.4}},"
          "{\"name\":\"painted\",\"pbrMetallicRoughness\":{"
          "\"baseColorFactor\":[0.9,0.9,0.9,1],\"metallicFactor\":0,\"roughnessFactor\":0.4}}]",
          view);
}

int write_painted_glb(const char *path, const solid *vase, const solid *ribbon) {
    scene g = {0};
    bytes json = {0};
    int vase_positions = add_positions(&g, vase), vase_texcoords = add_texcoords(&g, vase);
    int vase_indices = add_indices(&g, vase);
    int positions = add_positions(&g, ribbon), colors = add_colors(&g, ribbon);
    int indices = add_indices(&g, ribbon);
    print_painted(&json, add_texture(&g));
    print(&json,
          ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d,"
          "\"TEXCOORD_0\":%d},\"indices\":%d,\"material\":0}]},"
          "{\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"COLOR_0\":%d},"
          "\"indices\":%d,\"material\":1}]}]",
          vase_positions, vase_texcoords, vase_indices, positions, colors, indices);
    print_tables(&json, &g);
    print(&json, "}]}");
    int result = write_glb(path, &json, &g);
    free_scene(&g, &json);
    return result;
}

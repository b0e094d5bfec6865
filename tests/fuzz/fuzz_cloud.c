/* SPDX-License-Identifier: MIT
 *
 * fuzz_cloud.c - any coordinates as points that psplat_mesh_from_points connects. The low bits of
 * the first byte say whether there are normals and colours, and whether coordinates are single
 * precision, of any magnitude, or whole numbers of one byte, which fall on lines and grids.
 */
#include "mesh_input.h"

#include <string.h>

enum { HAS_NORMALS = 1, HAS_COLORS = 2, IS_GRID = 4, MOST_POINTS = 100 };

typedef struct cursor {
    const uint8_t *data;
    size_t size;
    int is_grid;
} cursor;

static float next_number(cursor *c) {
    float value = 0;
    if (c->is_grid) {
        value = (float)(int8_t)c->data[0];
        ++c->data;
        --c->size;
    } else {
        memcpy(&value, c->data, sizeof value);
        c->data += sizeof value;
        c->size -= sizeof value;
    }
    return value;
}

/* Colours are made of the number, whatever it is. */
static float color_of(float number) {
    return number > 0 ? number < 1 ? number : 1 : 0;
}

static void connect(const psplat_points *points) {
    psplat_mesh mesh;
    psplat_error error = {0};
    psplat_result result = psplat_mesh_from_points(points, &mesh, &error);
    if (result) {
        FUZZ_DEMAND(error.code == result && error.text[0]);
        FUZZ_DEMAND(result == PSPLAT_ERROR_NO_SPLATS || result == PSPLAT_ERROR_RANGE);
        return;
    }
    fuzz_check_mesh(&mesh);
    FUZZ_DEMAND(mesh.point_count == points->count);
    psplat_mesh_free(&mesh);
}

static void connect_coordinates(cursor c, int kind) {
    static double positions[3 * MOST_POINTS];
    static float normals[3 * MOST_POINTS], colors[4 * MOST_POINTS];
    size_t numbers = kind & HAS_NORMALS ? 6 : 3, width = c.is_grid ? 1 : sizeof(float);
    psplat_points points = {.positions = positions,
                            .normals = kind & HAS_NORMALS ? normals : NULL,
                            .colors = kind & HAS_COLORS ? colors : NULL};
    for (; c.size >= numbers * width && points.count < MOST_POINTS; ++points.count) {
        size_t i = points.count;
        for (size_t k = 0; k < 3; ++k) positions[3 * i + k] = (double)next_number(&c);
        for (size_t k = 0; k < 3 && points.normals; ++k) normals[3 * i + k] = next_number(&c);
        for (size_t k = 0; k < 4; ++k)
            colors[4 * i + k] = k < 3 ? color_of((float)positions[3 * i + k]) : 1;
    }
    connect(&points);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_meter meter = {0};
    if (!size) return 0;
    fuzz_meter_start(&meter);
    connect_coordinates((cursor){data + 1, size - 1, data[0] & IS_GRID}, data[0]);
    fuzz_meter_stop(&meter, 2.0);
    return 0;
}

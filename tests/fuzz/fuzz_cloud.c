/* SPDX-License-Identifier: MIT
 *
 * fuzz_cloud.c - takes any coordinates as points that psplat_mesh_from_points connects. The low
 * bits of the first byte say whether there are normals and colours, and whether numbers are of
 * single precision, of double precision, or whole numbers of a byte, which fall on lines and
 * grids.
 */
#include "mesh_input.h"

#include <string.h>
#include "mesh/mesh.h"
#include "points/points.h"

enum { HAS_NORMALS = 1, HAS_COLORS = 2, IS_GRID = 4, IS_DOUBLE = 8, MOST_POINTS = 100 };

typedef struct cursor {
    const uint8_t *data;
    size_t size;
    size_t width; /* bytes of a number */
} cursor;

static double next_number(cursor *c) {
    double wide = 0;
    float single = 0;
    if (c->width == sizeof wide)
        memcpy(&wide, c->data, sizeof wide);
    else if (c->width == sizeof single)
        memcpy(&single, c->data, sizeof single);
    else
        wide = (int8_t)c->data[0];
    c->data += c->width;
    c->size -= c->width;
    return c->width == sizeof single ? (double)single : wide;
}

/* Makes a colour of any number. */
static float color_of(double number) {
    return number > 0 ? number < 1 ? (float)number : 1 : 0;
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
    size_t numbers = kind & HAS_NORMALS ? 6 : 3;
    psplat_points points = {.positions = positions,
                            .normals = kind & HAS_NORMALS ? normals : NULL,
                            .colors = kind & HAS_COLORS ? colors : NULL};
    for (; c.size >= numbers * c.width && points.count < MOST_POINTS; ++points.count) {
        size_t i = points.count;
        for (size_t k = 0; k < 3; ++k) positions[3 * i + k] = next_number(&c);
        for (size_t k = 0; k < 3 && points.normals; ++k)
            normals[3 * i + k] = (float)next_number(&c);
        for (size_t k = 0; k < 4; ++k)
            colors[4 * i + k] = k < 3 ? color_of(positions[3 * i + k]) : 1;
    }
    connect(&points);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_meter meter = {0};
    if (!size) return 0;
    size_t width = data[0] & IS_GRID     ? sizeof(uint8_t)
                   : data[0] & IS_DOUBLE ? sizeof(double)
                                         : sizeof(float);
    fuzz_meter_start(&meter);
    connect_coordinates((cursor){data + 1, size - 1, width}, data[0]);
    fuzz_meter_stop(&meter, 2.0);
    return 0;
}

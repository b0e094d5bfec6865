/* SPDX-License-Identifier: MIT
 *
 * test_silhouette.c - tests of pictures by the reference rasteriser of a converted sphere and cube:
 * their outlines and depths agree with the exact shapes, within the tolerance of the conversion.
 */
#include "reference_view.h"
#include "export/glb_writer.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

enum { SIZE = 240 };

typedef struct shape {
    psplat_asset *asset;
    double half;      /* radius of the sphere, or half edge of the cube */
    double tolerance; /* of the conversion, in units of the model */
} shape;

static shape convert(const char *path, double percent) {
    psplat_mesh mesh;
    psplat_splats splats;
    psplat_report report;
    psplat_error error;
    psplat_convert_desc desc = {.tolerance_percent = percent};
    shape s = {0};
    uint8_t *data;
    size_t size;
    if (psplat_mesh_read(path, &mesh, &error)) fail_msg("%s", error.text);
    for (size_t i = 0; i < mesh.vertex_count; ++i) s.half = fmax(s.half, mesh.positions[3 * i]);
    assert_int_equal(psplat_convert(&mesh, &desc, &splats, &report, &error), PSPLAT_OK);
    s.tolerance = percent / 100 * report.diagonal;
    for (int k = 0; k < 3; ++k) splats.origin[k] = 0; /* centred on the scene's origin */
    assert_int_equal(psplat_glb_write(&splats, NULL, NULL, &data, &size, &error), PSPLAT_OK);
    assert_int_equal(psplat_asset_open_memory(data, size, NULL, &s.asset, &error), PSPLAT_OK);
    free(data);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
    return s;
}

/* Returns a parallel view along a direction, with half_view from the middle to the edge. */
static psplat_view view_along(const shape *s, const double from[3], double half_view) {
    psplat_view view = camera_view(SIZE, SIZE);
    double eye[3], target[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) eye[k] = 4 * s->half * from[k];
    camera_look(&view, eye, target);
    camera_parallel(&view, half_view, 0.5 * s->half, 12 * s->half);
    return view;
}

static void test_sphere(void **state) {
    (void)state;
    shape s = convert(PSPLAT_SOURCE_DIR "/samples/models/sphere.ply", 1);
    const double views[][3] = {{0, 0, 1}, {1, 0, 0}, {0.6, 0.64, -0.48}, {-0.36, -0.48, 0.8}};
    for (int v = 0; v < 4; ++v) {
        double half_view = 1.25 * s.half;
        psplat_view view = view_along(&s, views[v], half_view);
        picture p = picture_draw(s.asset, NULL, &view);
        size_t inside = 0, cracks = 0;
        for (int i = 0; i < SIZE * SIZE; ++i) {
            double x = (2 * (i % SIZE + 0.5) / SIZE - 1) * half_view;
            double y = (2 * (i / SIZE + 0.5) / SIZE - 1) * half_view, r = hypot(x, y);
            int covered = p.image.color[4 * i + 3] > 0;
            if (r > s.half + s.tolerance) assert_false(covered);
            /* The mesh lies up to 0.2 % of the radius inside the sphere. */
            if (r < 0.998 * s.half - s.tolerance) ++inside, cracks += !covered;
            if (r > 0.5 * s.half || !covered) continue;
            /* Depth runs from 0.5 to 12 half sizes; the surface leans by at most 30 degrees here.
             */
            double distance = 0.5 * s.half + p.image.depth[i] * 11.5 * s.half;
            double expected = 4 * s.half - sqrt(s.half * s.half - r * r);
            assert_true(fabs(distance - expected) <= 1.2 * s.tolerance + 0.002 * s.half);
        }
        print_message("%zu of %zu pixels are cracks\n", cracks, inside);
        /* Slanted views may pass between splats that overlap when seen from above. */
        assert_true(cracks * 2000 < inside);
        picture_free(&p);
    }
    psplat_asset_destroy(s.asset);
}

/* Faces and edges are exact to a hundredth of a pixel, whatever the tolerance. */
static void test_cube(void **state) {
    (void)state;
    shape s = convert(PSPLAT_SOURCE_DIR "/samples/models/cube.off", 1);
    const double views[][3] = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-1, 0, 0}};
    for (int v = 0; v < 4; ++v) {
        double half_view = 1.25 * s.half, pixel = 2 * half_view / SIZE;
        psplat_view view = view_along(&s, views[v], half_view);
        picture p = picture_draw(s.asset, NULL, &view);
        for (int i = 0; i < SIZE * SIZE; ++i) {
            double x = fabs((2 * (i % SIZE + 0.5) / SIZE - 1) * half_view);
            double y = fabs((2 * (i / SIZE + 0.5) / SIZE - 1) * half_view), r = fmax(x, y);
            int covered = p.image.color[4 * i + 3] > 0;
            if (r > s.half + 0.01 * pixel) assert_false(covered);
            if (r < s.half - 0.01 * pixel) assert_true(covered);
            if (!covered) continue;
            double distance = 0.5 * s.half + p.image.depth[i] * 11.5 * s.half;
            assert_true(fabs(distance - 3 * s.half) <= 1e-5 * s.half); /* centres are floats */
        }
        picture_free(&p);
    }
    psplat_asset_destroy(s.asset);
}

int test_silhouette_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_cube),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

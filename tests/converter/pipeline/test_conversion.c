/* SPDX-License-Identifier: MIT
 *
 * test_conversion.c - tests of whole conversions: the promises of the report, on bundled models and
 * on shapes whose splats are known (cube, sphere, triangle, two sheets), and the round trip through
 * a file.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <math.h>
#include <cmocka.h>

#include "near.h"
#include "base/region.h"
#include "base/vector.h"
#include "export/glb_writer.h"
#include "import/read_mesh.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "pipeline/schedule.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"
#include <phongsplat/phongsplat.h>

#define MODELS PSPLAT_SOURCE_DIR "/samples/models/"

static psplat_mesh read_model(const char *name) {
    psplat_mesh mesh;
    psplat_error error;
    char path[512];
    snprintf(path, sizeof path, MODELS "%s", name);
    if (psplat_mesh_read(path, &mesh, &error)) fail_msg("%s", error.text);
    return mesh;
}

static int planar; /* 1: splats are flat */

static psplat_splats convert(const psplat_mesh *mesh, double percent, psplat_report *report) {
    psplat_splats splats;
    psplat_error error;
    psplat_convert_desc desc = {.tolerance_percent = percent, .planar = planar};
    if (psplat_convert(mesh, &desc, &splats, report, &error)) fail_msg("%s", error.text);
    return splats;
}

/* Both distances are within the tolerance, and no sample is open, on every bundled model. */
static void test_promise(void **state) {
    (void)state;
    const struct {
        const char *name;
        double percent;
    } models[] = {{"part.obj", 4},  {"cube.off", 0.5},   {"sphere.ply", 1},
                  {"torus.off", 2}, {"cone.stl", 2},     {"plate.stl", 0.5},
                  {"slab.ply", 1},  {"bracket.gltf", 1}, {"painted.glb", 2}};
    for (size_t i = 0; i < sizeof models / sizeof *models; ++i) {
        psplat_mesh mesh = read_model(models[i].name);
        psplat_report r = {0};
        psplat_splats splats = convert(&mesh, models[i].percent, &r);
        print_message("%-12s %4zu splats, distance %.3f of %g %%, normal %.2f degrees, %zu of %zu "
                      "uncovered\n",
                      models[i].name, r.splats, r.max_distance_percent, models[i].percent,
                      r.rms_normal_degrees, r.uncovered_samples, r.verification_samples);
        assert_true(r.max_distance_percent <= models[i].percent);
        /* Holes are filled until fresh samples find none; a hole may still lie between those
         * samples, but not one sample in ten thousand may be open. */
        assert_true(r.uncovered_samples * 10000 <= r.verification_samples);
        assert_int_equal(r.splats, splats.count);
        psplat_splats_free(&splats);
        psplat_mesh_free(&mesh);
    }
}

/* A tolerance that would need too many samples for the memory is refused in advance. */
static void test_too_fine(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("cube.off");
    psplat_convert_desc desc = {.tolerance_percent = 1e-4};
    psplat_splats splats;
    psplat_error error;
    assert_int_equal(psplat_convert(&mesh, &desc, &splats, NULL, &error), PSPLAT_ERROR_RANGE);
    assert_non_null(strstr(error.text, "a tolerance of 0.0001 % needs"));
    assert_null(splats.splats);
    psplat_mesh_free(&mesh);
}

/* A cube becomes six splats with four lines, each a face up to rounding to float. */
static void test_cube(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("cube.off");
    psplat_report r = {0};
    psplat_splats splats = convert(&mesh, 0.5, &r);
    double half = r.diagonal / sqrt(3) / 2;
    assert_int_equal(splats.count, 6);
    assert_int_equal(splats.runs[0].clip_lines, 4);
    assert_int_equal(splats.runs[0].count, 6);
    psplat_region *regions = psplat_splat_regions(&splats);
    assert_non_null(regions);
    for (size_t i = 0; i < 6; ++i) {
        const psplat_region *s = &regions[i];
        double polygon[68][2], reach = 0;
        size_t corners = psplat_region_polygon(s, 1, polygon, 68);
        for (size_t k = 0; k < corners; ++k) {
            double p[3];
            memcpy(p, s->center, sizeof p);
            mad3(p, polygon[k][0] * s->radius[0], s->u);
            mad3(p, polygon[k][1] * s->radius[1], s->v);
            assert_near(dot3(p, s->n), half, 1e-6 * half); /* rounding to float */
            reach = max2(reach, length3(p));
        }
        assert_near(reach, half * sqrt(3), 1e-5 * half); /* the farthest corner is the cube's */
        for (int k = 0; k < 3; ++k) assert_near((double)splats.splats[i].gradient[k], 0, 1e-6);
    }
    assert_true(r.max_distance_percent < 1e-4);
    assert_true(r.rms_normal_degrees < 1e-4);
    free(regions);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
}

/* A cube whose normals are those of a ball keeps its sides, one splat each: normals that the shape
 * contradicts do not bend splats. */
static void test_smooth_cube(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("cube.off");
    psplat_report report = {0};
    mesh.corner_normals = malloc(9 * mesh.triangle_count * sizeof(float));
    assert_non_null(mesh.corner_normals);
    for (size_t i = 0; i < 3 * mesh.triangle_count; ++i) {
        double n[3];
        memcpy(n, mesh.positions + 3 * (size_t)mesh.triangles[i], sizeof n);
        normalize3(n);
        for (int k = 0; k < 3; ++k) mesh.corner_normals[3 * i + (size_t)k] = (float)n[k];
    }
    psplat_splats splats = convert(&mesh, 0.5, &report);
    assert_int_equal(splats.count, 6);
    assert_true(report.max_distance_percent <= 0.5);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
}

/* A cube takes a splat for each side also where its normals lean by 87 degrees: nothing that splats
 * cannot cover is left, for each point of which one would be made. */
static void test_leaning_normals(void **state) {
    (void)state;
    const double leans[] = {0.05, 0.55};
    psplat_mesh mesh = read_model("cube.off");
    mesh.corner_normals = malloc(9 * mesh.triangle_count * sizeof(float));
    assert_non_null(mesh.corner_normals);
    for (int lean = 0; lean < 2; ++lean) {
        psplat_report report = {0};
        for (size_t t = 0; t < mesh.triangle_count; ++t) {
            double sides[2][3], n[3];
            const double *a = psplat_mesh_corner(&mesh, (uint32_t)t, 0);
            for (int k = 0; k < 2; ++k)
                sub3(sides[k], psplat_mesh_corner(&mesh, (uint32_t)t, k + 1), a);
            cross3(n, sides[0], sides[1]);
            normalize3(n);
            for (size_t i = 0; i < 9; ++i)
                mesh.corner_normals[9 * t + i] =
                    (float)(leans[lean] * n[i % 3] +
                            sqrt(1 - leans[lean] * leans[lean]) * n[(i + 1) % 3]);
        }
        psplat_splats splats = convert(&mesh, 0.5, &report);
        assert_int_equal(splats.count, 6);
        assert_int_equal(report.uncovered_samples, 0);
        psplat_splats_free(&splats);
    }
    psplat_mesh_free(&mesh);
}

/* Every outline stays within the tolerance of the sphere, and the linear normal field follows its
 * normals better than a constant one. */
static void check_sphere(void) {
    psplat_mesh mesh = read_model("sphere.ply");
    psplat_report r = {0};
    psplat_splats splats = convert(&mesh, 1, &r);
    psplat_region *regions = psplat_splat_regions(&splats);
    assert_non_null(regions);
    double radius = length3(mesh.positions), tolerance = 0.01 * r.diagonal;
    for (size_t i = 0; i < splats.count; ++i) {
        double polygon[68][2];
        size_t corners = psplat_region_polygon(&regions[i], 1, polygon, 68);
        for (size_t k = 0; k < corners; ++k) {
            double p[3];
            psplat_region_point(&regions[i], polygon[k], p);
            /* The mesh itself lies 0.1 % inside the sphere. */
            assert_near(length3(p), radius, tolerance + 0.001 * radius);
        }
    }
    /* There is no crease: lines cut rims alone, one at most, of a quarter of the splats. */
    assert_int_equal(r.splats_by_clip_lines[0] + r.splats_by_clip_lines[1], splats.count);
    assert_true(4 * r.splats_by_clip_lines[1] <= splats.count);
    /* A curved splat's normals are those of its surface. Where an error of the fourth order uses
     * all of the tolerance t, slopes err by 6.5 t / r in the root mean square of the disc, 15
     * degrees at r = 0.85; blends are to stay below half of that. */
    print_message("planar %d: normals %.2f degrees, constant %.2f\n", planar, r.rms_normal_degrees,
                  r.rms_normal_constant_degrees);
    assert_true(r.rms_normal_degrees < (planar ? 0.5 : 7.5));
    assert_true(r.rms_normal_constant_degrees > (planar ? 10 : 2) * r.rms_normal_degrees);
    for (size_t i = 0; i < splats.count; ++i)
        assert_int_equal(psplat_region_is_curved(&regions[i]), !planar);
    free(regions);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
}

static void test_sphere(void **state) {
    (void)state;
    check_sphere();
    planar = 1;
    check_sphere();
    planar = 0;
}

/* Round shapes need at most half as many curved splats as flat ones, and a part with flat and round
 * sides fewer. Both kinds keep all promises; planar conversions have neither curved splats nor bent
 * lines. */
static void test_curved_saves(void **state) {
    (void)state;
    static const struct {
        const char *name;
        double percent, most; /* of the flat ones */
    } models[] = {{"sphere.ply", 0.5, 0.5}, {"torus.off", 1, 0.5}, {"part.obj", 1, 0.75}};
    for (size_t i = 0; i < sizeof models / sizeof *models; ++i) {
        psplat_mesh mesh = read_model(models[i].name);
        size_t counts[2];
        for (int k = 0; k < 2; ++k) {
            const psplat_convert_desc desc = {.tolerance_percent = models[i].percent,
                                              .precision = PSPLAT_USUAL_PRECISION,
                                              .planar = k};
            psplat_splats splats;
            psplat_report r;
            psplat_error error;
            size_t curved = 0, bent = 0;
            if (psplat_convert(&mesh, &desc, &splats, &r, &error)) fail_msg("%s", error.text);
            assert_int_equal(psplat_report_broken(&r), PSPLAT_PROMISE_COUNT);
            for (size_t n = 0; n < splats.count; ++n) {
                for (int c = 0; c < 5; ++c) curved += splats.splats[n].shape[c] != 0;
                for (int c = 0; c < PSPLAT_MAX_CLIP_LINES; ++c)
                    bent += splats.splats[n].bend[c] != 0;
            }
            assert_int_equal(curved > 0, !k);
            if (k) assert_int_equal(bent, 0);
            counts[k] = splats.count;
            psplat_splats_free(&splats);
        }
        print_message("%s: %zu curved splats, %zu flat ones\n", models[i].name, counts[0],
                      counts[1]);
        assert_true((double)counts[0] <= models[i].most * (double)counts[1]);
        psplat_mesh_free(&mesh);
    }
}

static void test_deterministic(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("cone.stl");
    psplat_splats a = convert(&mesh, 1, NULL), b = convert(&mesh, 1, NULL);
    assert_int_equal(a.count, b.count);
    assert_memory_equal(a.splats, b.splats, a.count * sizeof *a.splats);
    psplat_splats_free(&a);
    psplat_splats_free(&b);
    psplat_mesh_free(&mesh);
}

/* Scaling by a power of two changes only exponents, so that splats are the same but for their
 * scale. */
static void test_scale(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("cone.stl");
    psplat_splats plain = convert(&mesh, 2, NULL);
    const double scales[] = {0x1p-30, 0x1p30}; /* about 1e-9 and 1e9 */
    for (int s = 0; s < 2; ++s) {
        psplat_mesh scaled = read_model("cone.stl");
        for (size_t i = 0; i < 3 * scaled.vertex_count; ++i) scaled.positions[i] *= scales[s];
        psplat_splats splats = convert(&scaled, 2, NULL);
        assert_int_equal(splats.count, plain.count);
        for (size_t i = 0; i < splats.count; ++i) {
            double scale = scales[s], radius = (double)plain.splats[i].radius[0];
            for (int k = 0; k < 3; ++k)
                assert_near((double)splats.splats[i].center[k] / scale,
                            /* rounding to float */
                            (double)plain.splats[i].center[k], 1e-5 * radius);
            assert_near((double)splats.splats[i].radius[0] / scale, radius, 1e-5 * radius);
        }
        psplat_splats_free(&splats);
        psplat_mesh_free(&scaled);
    }
    psplat_splats_free(&plain);
    psplat_mesh_free(&mesh);
}

/* The three sides of a triangle are clip lines, and no splat reaches across them. */
static void test_triangle(void **state) {
    (void)state;
    double positions[] = {0, 0, 0, 3, 0, 0, 0, 1, 0};
    uint32_t triangles[] = {0, 1, 2};
    psplat_mesh mesh = {
        .positions = positions, .triangles = triangles, .vertex_count = 3, .triangle_count = 1};
    psplat_report r = {0};
    psplat_splats splats = convert(&mesh, 0.5, &r);
    assert_int_equal(splats.count, 1);
    assert_int_equal(splats.splats[0].clip_count, 3);
    assert_int_equal(r.uncovered_samples, 0);
    assert_true(r.max_distance_percent < 1e-4);
    psplat_splats_free(&splats);
}

/* Two sheets closer than the tolerance that face apart are each covered by splats of their own. */
static void test_double_sheet(void **state) {
    (void)state;
    double positions[] = {0, 0, 0,     4, 0, 0,     4, 3, 0,     0, 3, 0,
                          0, 0, -1e-3, 4, 0, -1e-3, 4, 3, -1e-3, 0, 3, -1e-3};
    uint32_t triangles[] = {0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6};
    psplat_mesh mesh = {
        .positions = positions, .triangles = triangles, .vertex_count = 8, .triangle_count = 4};
    psplat_report r = {0};
    psplat_splats splats = convert(&mesh, 0.5, &r);
    assert_int_equal(splats.count, 2);
    assert_int_equal(r.uncovered_samples, 0);
    assert_true(splats.splats[0].normal[2] * splats.splats[1].normal[2] < 0);
    psplat_splats_free(&splats);
}

typedef struct stopper {
    int calls, stop_at;
} stopper;

static int stop(void *user, const char *stage, double fraction) {
    stopper *s = user;
    assert_non_null(stage);
    assert_true(fraction >= 0 && fraction <= 1);
    return s->calls++ == s->stop_at;
}

static void test_interrupt(void **state) {
    (void)state;
    psplat_mesh mesh = read_model("cone.stl");
    for (int at = 0; at < 5; ++at) {
        stopper s = {0, at};
        psplat_convert_desc desc = {.tolerance_percent = 2, .progress = stop, .user = &s};
        psplat_splats splats;
        psplat_report report;
        psplat_error error;
        assert_int_equal(psplat_convert(&mesh, &desc, &splats, &report, &error),
                         PSPLAT_ERROR_INTERRUPTED);
        assert_int_equal(error.code, PSPLAT_ERROR_INTERRUPTED);
        assert_null(splats.splats);
        assert_int_equal(s.calls, at + 1);
    }
    psplat_mesh_free(&mesh);
}

/* Which stages a conversion has told of. */
typedef struct told {
    int improving, gaps, trimming, finishing, verifying;
    double done;
} told;

static int tell(void *user, const char *stage, double fraction) {
    told *t = user;
    double done = psplat_schedule_done(stage, fraction);
    if (done < 0) fail_msg("no share of the time is known for '%s'", stage);
    t->improving |= !strcmp(stage, "improving");
    t->gaps |= !strcmp(stage, "closing gaps");
    t->trimming |= !strcmp(stage, "trimming");
    t->finishing |= !strcmp(stage, "finishing");
    t->verifying |= !strcmp(stage, "verifying");
    t->done = fmax(t->done, done);
    return 0;
}

/* A conversion tells of its stages, of each of which the schedule knows the share, and the last one
 * of them leaves next to nothing to be done. */
static void test_stages_are_told(void **state) {
    (void)state;
    told t = {0};
    const psplat_convert_desc desc = {.tolerance_percent = 2, .progress = tell, .user = &t};
    psplat_splats splats;
    psplat_report report;
    psplat_mesh mesh = read_model("cone.stl");
    assert_int_equal(psplat_convert(&mesh, &desc, &splats, &report, NULL), PSPLAT_OK);
    assert_true(t.improving && t.gaps && t.trimming && t.finishing && t.verifying);
    assert_true(t.done > 0.9 && t.done < 1);
    psplat_splats_free(&splats);
    psplat_mesh_free(&mesh);
}

/* The default effort saves at least one splat of twenty on a torus; it is one of six. */
static void test_effort_saves_splats(void **state) {
    (void)state;
    const int efforts[] = {PSPLAT_EFFORT_NONE, PSPLAT_DEFAULT_EFFORT};
    size_t counts[2];
    psplat_mesh mesh = read_model("torus.off");
    for (size_t i = 0; i < 2; ++i) {
        const psplat_convert_desc desc = {.tolerance_percent = 0.5, .effort = efforts[i]};
        psplat_splats splats;
        assert_int_equal(psplat_convert(&mesh, &desc, &splats, NULL, NULL), PSPLAT_OK);
        counts[i] = splats.count;
        psplat_splats_free(&splats);
    }
    print_message("%zu splats without effort, %zu with the default one\n", counts[0], counts[1]);
    assert_true(20 * counts[1] <= 19 * counts[0]);
    psplat_mesh_free(&mesh);
}

/* Efforts end at 9, and the one below 0 stands for none: those beyond are refused by name. */
static void test_effort_out_of_range(void **state) {
    (void)state;
    const int efforts[] = {PSPLAT_EFFORT_NONE - 1, PSPLAT_GREATEST_EFFORT + 1};
    psplat_mesh mesh = read_model("cube.off");
    for (size_t i = 0; i < sizeof efforts / sizeof *efforts; ++i) {
        const psplat_convert_desc desc = {.tolerance_percent = 2, .effort = efforts[i]};
        psplat_splats splats;
        psplat_error error;
        assert_int_equal(psplat_convert(&mesh, &desc, &splats, NULL, &error),
                         PSPLAT_ERROR_ARGUMENT);
        assert_non_null(strstr(error.text, "effort"));
        assert_null(splats.splats);
    }
    psplat_mesh_free(&mesh);
}

/* Returns the splat with the centre, axes and lines of one that a file holds: flat and curved ones
 * are stored apart. */
static psplat_splat stored_as(const psplat_splats *splats, const psplat_splat *stored) {
    for (size_t i = 0; i < splats->count; ++i) {
        const psplat_splat *s = &splats->splats[i];
        if (!memcmp(s->center, stored->center, sizeof s->center) &&
            !memcmp(s->rotation, stored->rotation, sizeof s->rotation) &&
            !memcmp(s->radius, stored->radius, sizeof s->radius) &&
            !memcmp(s->clip, stored->clip, s->clip_count * sizeof *s->clip))
            return *s;
    }
    fail_msg("a stored splat is none of those converted");
    return (psplat_splat){.clip_count = 0};
}

/* Splats come back from a file bit by bit, and writing twice gives the same bytes. */
static void test_round_trip(void **state) {
    (void)state;
    const char *names[] = {"cone.stl", "painted.glb", "cube.off"};
    for (int i = 0; i < 3; ++i) {
        psplat_mesh mesh = read_model(names[i]);
        /* Splats without their scene are written without images. */
        const psplat_convert_desc desc = {
            .tolerance_percent = 2, .planar = planar, .bake_textures = 1};
        psplat_splats splats;
        assert_int_equal(psplat_convert(&mesh, &desc, &splats, NULL, NULL), PSPLAT_OK);
        uint8_t *data, *again;
        size_t size, size_again, at = 0;
        psplat_asset *asset;
        assert_int_equal(psplat_glb_write(&splats, "m", NULL, &data, &size, NULL), PSPLAT_OK);
        assert_int_equal(psplat_glb_write(&splats, "m", NULL, &again, &size_again, NULL),
                         PSPLAT_OK);
        assert_int_equal(size, size_again);
        assert_memory_equal(data, again, size);
        assert_int_equal(psplat_asset_open_memory(data, size, NULL, &asset, NULL), PSPLAT_OK);
        for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
            const psplat_batch *batch = psplat_asset_batch(asset, b);
            for (size_t k = 0; k < batch->splat_count; ++k, ++at) {
                psplat_splat expected = stored_as(&splats, &batch->splats[k]);
                /* padding lines that cut nothing off */
                while (expected.clip_count < batch->clip_count)
                    memcpy(expected.clip[expected.clip_count++], (float[]){1, 0, 1},
                           sizeof *expected.clip);
                if (splats.has_color) /* colours take 16 bits, all else is exact */
                    for (int c = 0; c < 4; ++c) {
                        assert_near((double)batch->splats[k].color[c], (double)expected.color[c],
                                    0.5 / 65535 + 1e-7);
                        expected.color[c] = batch->splats[k].color[c];
                    }
                /* The surface's slopes follow from the axes, which are rounded to floats. */
                for (int c = 0; c < 2; ++c) {
                    assert_near((double)batch->splats[k].shape[c], (double)expected.shape[c], 3e-7);
                    expected.shape[c] = batch->splats[k].shape[c];
                }
                assert_memory_equal(&batch->splats[k], &expected, sizeof expected);
            }
            for (int k = 0; k < 3; ++k) assert_near(batch->model[12 + k], mesh.origin[k], 0);
        }
        assert_int_equal(at, splats.count);
        psplat_asset_destroy(asset);
        free(data);
        free(again);
        psplat_splats_free(&splats);
        psplat_mesh_free(&mesh);
    }
}

int test_conversion_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_promise),
        cmocka_unit_test(test_too_fine),
        cmocka_unit_test(test_cube),
        cmocka_unit_test(test_smooth_cube),
        cmocka_unit_test(test_leaning_normals),
        cmocka_unit_test(test_sphere),
        cmocka_unit_test(test_curved_saves),
        cmocka_unit_test(test_deterministic),
        cmocka_unit_test(test_scale),
        cmocka_unit_test(test_triangle),
        cmocka_unit_test(test_double_sheet),
        cmocka_unit_test(test_interrupt),
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_stages_are_told),
        cmocka_unit_test(test_effort_saves_splats),
        cmocka_unit_test(test_effort_out_of_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * test_written_splats.c - tests that the runtime reads the splats which the writer stored. Floats
 * come back bit by bit; integers come back as the values to which the splats were rounded, up to
 * the roundings that each tolerance counts in ulp = 2^-24 (relative). The splats are the random
 * ones of writer_fixture.h, in boxes of edge length 1e-9 to 1e9.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "writer_fixture.h"
#include "export/glb_writer.h"
#include "export/meshopt_codec.h"
#include "splats/octahedron.h"
#include "splats/quantize.h"
#include "splats/splats.h"

static const double ulp = 0x1p-24;

static const psplat_write_desc compressed = {.codec = &psplat_meshopt_codec};
static const psplat_write_desc plain;

/* Returns the tolerance for normals behind the octahedral filter. Decoders round its shorts by
 * different instructions and may differ by a step in each component; bytes are equal
 * (test_octahedron.c). The axis u follows the normal. */
static double filtered(const psplat_precision *p) {
    return p->normal_bits > 8 ? 2 * sqrt(3) / 32767 : 0;
}

static void near_to(const char *what, size_t index, double found, double expected,
                    double tolerance) {
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("splat %zu, %s: %.17g, not %.17g within %g", index, what, found, expected,
                 tolerance);
}

static void compare(const char *what, size_t index, const float *found, const float *expected,
                    size_t count, double relative, double absolute) {
    for (size_t k = 0; k < count; ++k)
        near_to(what, index, (double)found[k], (double)expected[k],
                relative * fabs((double)expected[k]) + absolute);
}

/* Compares quaternions, of which q and -q are the same rotation. */
static void compare_rotations(size_t index, const float *found, const float *expected,
                              double tolerance) {
    double dot = 0;
    for (int k = 0; k < 4; ++k) dot += (double)found[k] * (double)expected[k];
    for (int k = 0; k < 4; ++k)
        near_to("rotation", index, (double)found[k] * (dot < 0 ? -1 : 1), (double)expected[k],
                tolerance);
}

/* Returns the index of the splat that belongs to this place of the grid. */
static size_t index_of(const written *w, const psplat_batch *batch, const psplat_splat *found,
                       double at[3]) {
    for (int k = 0; k < 3; ++k)
        at[k] = batch->model[12 + k] + batch->model[5 * k] * (double)found->center[k];
    double x = rint((at[0] - w->origin[0]) / w->size * GRID);
    double y = rint((at[1] - w->origin[1]) / w->size * GRID);
    size_t index = (size_t)x + (size_t)y * GRID;
    if (!(x >= 0 && y >= 0 && index < w->count)) fail_msg("a splat at %g %g", at[0], at[1]);
    return index;
}

/* Returns the line of a splat that is nearest to one: streams have them in an order of their own.
 */
static uint32_t nearest_line(const psplat_splat *splat, const float *line, float bend) {
    uint32_t nearest = 0;
    float least = HUGE_VALF;
    for (uint32_t k = 0; k < splat->clip_count; ++k) {
        float distance = fabsf(splat->bend[k] - bend);
        for (int i = 0; i < 3; ++i) distance += fabsf(splat->clip[k][i] - line[i]);
        if (!(distance < least)) continue;
        least = distance;
        nearest = k;
    }
    return nearest;
}

static void compare_lines(size_t index, const psplat_splat *found, const psplat_splat *expected,
                          int is_coded) {
    static const float padding[3] = {1, 0, 1};
    assert_true(found->clip_count >= expected->clip_count);
    for (uint32_t i = 0; i < found->clip_count; ++i) {
        const float *line = i < expected->clip_count ? expected->clip[i] : padding;
        uint32_t k = nearest_line(found, line, expected->bend[i]);
        /* The fraction of the range, the range and their product each round an angle (3 ulp of half
         * a turn), and the cosine rounds once in the writer and in the reader. The offset c rounds
         * likewise, and once more in the rounded splat. */
        compare("line", index, found->clip[k], line, 2, 0, is_coded ? (3 * 3.1416 + 2) * ulp : 0);
        compare("distance", index, found->clip[k] + 2, line + 2, 1, 4 * ulp * is_coded, 0);
        compare("bend", index, found->bend + k, expected->bend + i, 1, 4 * ulp * is_coded, 0);
    }
}

/* Colours in bytes are within half a step, and within 1 % of what the eye sees. */
static void compare_colors(size_t index, const psplat_splat *found, const psplat_splat *expected,
                           int is_coded) {
    for (size_t k = 0; k < 4; ++k) {
        double c = (double)expected->color[k], d = (double)found->color[k];
        near_to("colour", index, d, c, 0.5 / (is_coded ? 255 : 65535) + ulp);
        near_to("seen colour", index, pow(d, 1 / 2.4), pow(c, 1 / 2.4), 0.01);
    }
}

static void compare_finishes(size_t index, const psplat_finish *found,
                             const psplat_finish *expected, int is_coded, double range) {
    double step = is_coded ? 0.5 / 255 + ulp : 0,
           slope = is_coded ? range * (0.5 / 127 + 2 * ulp) : 0;
    compare("COLOR_U", index, found->color_u, expected->color_u, 3, 0, slope);
    compare("COLOR_V", index, found->color_v, expected->color_v, 3, 0, slope);
    compare("occlusion", index, &found->occlusion, &expected->occlusion, 1, 0, step);
    compare("roughness", index, &found->roughness, &expected->roughness, 1, 0, step);
    compare("metallic", index, &found->metallic, &expected->metallic, 1, 0, step);
    compare("emissive", index, found->emissive, expected->emissive, 3, 0, step);
}

/* unit is the length of a unit of the file. */
static void compare_splats(const written *w, size_t index, const psplat_splat *found,
                           const psplat_splat *expected, int is_packed, double unit) {
    int is_coded = w->precision.unit > 0;
    /* The two ends of the range, the fraction and the rounded radius each round; so does the step
     * of logarithms in a stream, of which radii are 14 at most here. */
    for (int k = 0; k < 2; ++k)
        near_to("radius", index, (double)found->radius[k] * unit, (double)expected->radius[k],
                (6 + 14 + 0.5) * ulp * is_coded * (double)expected->radius[k]);
    if (is_coded)
        compare_rotations(index, found->rotation, expected->rotation,
                          4 * ulp + filtered(&w->precision) / 2 * is_packed);
    else
        compare("rotation", index, found->rotation, expected->rotation, 4, 0, 0);
    /* The normal and the quaternion of the axes are floats: about four roundings, of which two
     * count twice. */
    compare("normal", index, found->normal, expected->normal, 3, 0,
            is_coded * 8 * ulp + is_packed * filtered(&w->precision));
    compare("gradient", index, found->gradient, expected->gradient, 3, is_coded * 4 * ulp, 0);
    /* In files of floats, x and y follow from the normal and the rotation; both are below 1. */
    compare("slope", index, found->shape, expected->shape, 2, is_coded * 4 * ulp,
            is_coded ? 0 : 16 * ulp);
    compare("shape", index, found->shape + 2, expected->shape + 2, 3, is_coded * 4 * ulp, 0);
    compare_lines(index, found, expected, is_coded);
    compare_colors(index, found, expected, is_coded);
}

static double color_range(const psplat_splats *s) {
    double range = 0;
    for (size_t i = 0; i < s->count && s->finishes; ++i)
        for (int k = 0; k < 3; ++k)
            range = fmax(range, fmax(fabs((double)s->finishes[i].color_u[k]),
                                     fabs((double)s->finishes[i].color_v[k])));
    return range;
}

/* Asserts that every splat comes back once. */
static void check_asset(const written *w, const psplat_splats *s, const psplat_asset *asset) {
    int is_coded = w->precision.unit > 0;
    uint8_t *seen = writer_memory(w->count, 1);
    double range = color_range(s);
    size_t total = 0;
    for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
        const psplat_batch *batch = psplat_asset_batch(asset, b);
        total += batch->splat_count;
        for (size_t i = 0; i < batch->splat_count; ++i) {
            double at[3];
            size_t index = index_of(w, batch, &batch->splats[i], at);
            assert_int_equal(seen[index]++, 0);
            /* The origin is rounded twice in double, or to digits that are at most 1/1024 of a step
             * off; the node's scale is rounded to digits by half an ulp, which moves what is at the
             * end of the grid. */
            for (int k = 0; k < 3; ++k)
                near_to("position", index, at[k], w->origin[k] + (double)s->splats[index].center[k],
                        is_coded * ulp * (fabs((double)s->splats[index].center[k]) + w->size) +
                            w->precision.unit / 1024 + 0x1p-51 * fabs(w->origin[k]));
            compare_splats(w, index, &batch->splats[i], &s->splats[index],
                           batch->attributes[0].is_compressed, batch->model[0]);
            if (batch->finishes)
                compare_finishes(index, &batch->finishes[i], &s->finishes[index], is_coded, range);
            else
                assert_true(!w->has_gradients && !w->has_surface && !w->has_emissive);
        }
        near_to("depth tolerance", b, (double)batch->depth_tolerance * batch->model[0],
                (double)s->runs[0].depth_tolerance, 2.5 * ulp * (double)s->runs[0].depth_tolerance);
    }
    assert_int_equal(total, w->count);
    free(seen);
}

static void check(const written *w, const psplat_write_desc *desc) {
    psplat_splats s = writer_splats(w, 5);
    size_t size;
    uint8_t *data = writer_file(&s, 1, desc, &size);
    psplat_asset *asset = writer_open(data, size);
    check_asset(w, &s, asset);
    psplat_asset_destroy(asset);
    free(data);
    psplat_splats_free(&s);
}

/* Checks a file of floats, one of integers, and a compressed one. */
static void check_all(written w) {
    const psplat_precision steps = w.precision.unit > 0 ? w.precision : steps_of(w.size);
    w.precision = (psplat_precision){0};
    check(&w, &plain);
    check(&w, &compressed);
    w.precision = steps;
    check(&w, &plain);
    check(&w, &compressed);
}

/* ---- attributes ----------------------------------------------------------------------------- */

/* Tests each set of optional attributes. */
static void test_attributes(void **state) {
    (void)state;
    for (int bits = 0; bits < 64; ++bits)
        check_all((written){.count = 60,
                            .size = 3,
                            .darkest = bits & 32 ? 0.5f : 0,
                            .has_color = bits & 1,
                            .has_slopes = (bits & 2) != 0,
                            .has_gamma = (bits & 2) != 0 && (bits & 32),
                            .has_gradients = (bits & 4) != 0,
                            .has_surface = (bits & 8) != 0,
                            .has_emissive = (bits & 16) != 0});
}

/* Tests curved splats beside plain ones, with fields that are those of their surfaces or not, and
 * with bent lines or straight ones only. */
static void test_curved(void **state) {
    (void)state;
    static const unsigned curved[] = {0, 1, 2, 5, 21, 31};
    for (int bits = 0; bits < 32; ++bits)
        for (size_t i = 0; i < sizeof curved / sizeof *curved; ++i)
            check_all((written){.count = 60,
                                .size = 3,
                                .curved = curved[i],
                                .has_shape = bits & 1,
                                .has_bends = (bits & 2) != 0,
                                .has_slopes = (bits & 4) != 0,
                                .has_gamma = (bits & 4) != 0 && (bits & 8),
                                .has_gradients = (bits & 16) != 0});
}

/* Tests each number of clip lines alone and together with each other number: a primitive of both
 * pads the splats with fewer lines. */
static void test_lines(void **state) {
    (void)state;
    for (unsigned lines = 1; lines < 32; ++lines)
        check_all((written){.count = 37, .size = 1, .lines = lines, .has_slopes = 1});
}

static void test_one(void **state) {
    (void)state;
    for (unsigned lines = 1; lines < 32; lines *= 2)
        check_all((written){.count = 1,
                            .size = 2,
                            .lines = lines,
                            .has_color = 1,
                            .has_slopes = 1,
                            .has_gradients = 1,
                            .has_surface = 1,
                            .has_emissive = 1});
}

/* There are more than 65536 splats, too many for 16-bit indices, in many blocks of the compression.
 */
static void test_many(void **state) {
    (void)state;
    written w = {.count = 66000, .size = 1, .has_color = 1};
    w.precision = steps_of(w.size);
    check(&w, &compressed);
}

/* ---- sizes ---------------------------------------------------------------------------------- */

static void test_sizes(void **state) {
    (void)state;
    for (int power = -9; power <= 9; power += 3)
        check_all((written){.count = 50, .size = pow(10, power), .has_slopes = 1, .has_color = 1});
}

/* The mesh is far from zero; the node's translation restores that in double. */
static void test_far(void **state) {
    (void)state;
    for (int power = -9; power <= 9; power += 9) {
        double size = pow(10, power);
        check_all((written){.count = 50,
                            .size = size,
                            .origin = {1e7 * size, -3e7 * size, size / 3},
                            .has_slopes = 1});
    }
}

/* Radii differ so much that bytes cannot hold their logarithms. */
static void test_thin(void **state) {
    (void)state;
    check_all((written){.count = 200, .size = 1, .least_part = 1e-6});
}

/* Returns the greatest length of the three numbers behind a key in a file's JSON. */
static size_t longest_number(const uint8_t *data, size_t size, const char *key) {
    size_t at = 0, longest = 0, length = strlen(key);
    while (at + length < size && memcmp(data + at, key, length) != 0) ++at;
    assert_true(at + length < size);
    for (at += length; at < size && data[at - 1] != ']'; ++at) {
        size_t digits = 0;
        while (at < size && data[at] != ',' && data[at] != ']') ++digits, ++at;
        if (digits > longest) longest = digits;
    }
    return longest;
}

/* A node has no more digits than splats need: 8 of a scale, behind "0." and zeros, and of a
 * translation those down to a thousandth of a step, 1e-7 of a third here. Doubles have up to 17
 * digits. */
static void test_digits(void **state) {
    (void)state;
    written w = {.count = 50, .size = 1.0 / 3, .origin = {1.0 / 7, -1.0 / 9, 1.0 / 3}};
    size_t size;
    w.precision = steps_of(w.size);
    psplat_splats s = writer_splats(&w, 5);
    uint8_t *data = writer_file(&s, 1, &plain, &size);
    assert_in_range(longest_number(data, size, "\"scale\":["), 2, 16);
    assert_in_range(longest_number(data, size, "\"translation\":["), 4, 12);
    free(data);
    psplat_splats_free(&s);
}

/* ---- steps ---------------------------------------------------------------------------------- */

/* Steps are such that columns need each of their types, bytes and shorts. */
static void test_steps(void **state) {
    (void)state;
    for (int i = 0; i < 16; ++i) {
        written w = {.count = 80, .size = 10, .has_slopes = 1, .has_gamma = 1};
        w.precision = steps_of(w.size);
        w.precision.normal_bits =
            i & 1 ? PSPLAT_OCTAHEDRON_MOST_BITS : PSPLAT_OCTAHEDRON_LEAST_BITS + i / 2;
        w.precision.turn_step = i & 2 ? 1.0 / 4 : 1.0 / 60000;
        w.precision.line_step = i & 4 ? 1.0 / 4 : 1.0 / 16384;
        w.precision.line_turn_step = i & 4 ? 1.0 / 8 : 1.0 / 16384;
        w.precision.tilt_step = w.precision.field_step = i & 8 ? 1.0 / 16 : 1.0 / 16384;
        w.precision.scale_step = i & 8 ? 0.04 : 1.0 / 1024;
        check_all(w);
    }
}

/* Values that integers cannot hold are refused and not clamped. */
static void test_too_fine(void **state) {
    (void)state;
    for (int i = 0; i < 9; ++i) {
        written w = {.count = 80, .size = 10, .has_slopes = 1, .least_part = 1e-3};
        if (i > 6) w.curved = 31, w.has_bends = 1;
        psplat_splats s = writer_splats(&w, 5);
        psplat_precision p = steps_of(w.size);
        if (i == 0) p.unit /= 2;
        if (i == 1) p.turn_step = 1.0 / 80000;
        if (i == 2) p.tilt_step = 1e-6;
        if (i == 3) p.field_step = 1e-6;
        if (i == 4) p.scale_step = 5e-5;
        if (i == 5) p.line_turn_step = 1.0 / 40000;
        for (size_t k = 0; k < s.count && i == 6; ++k) s.splats[k].center[2] += 1e6f;
        if (i == 7) p.shape_step = 1e-6;
        if (i == 8) p.bend_step = 1e-5;
        s.precision = p;
        uint8_t *data = NULL;
        size_t size = 1;
        psplat_error error = {0};
        if (psplat_glb_write(&s, NULL, NULL, &data, &size, &error) != PSPLAT_ERROR_RANGE)
            fail_msg("%d is written", i);
        assert_null(data);
        assert_int_equal(size, 0);
        psplat_splats_free(&s);
    }
}

/* Runs must say what their splats have, and integers need steps for it. */
static void test_wrong_runs(void **state) {
    (void)state;
    for (int i = 0; i < 6; ++i) {
        written w = {.count = 20, .size = 1, .curved = 31, .has_bends = 1};
        if (i >= 4) w.precision = steps_of(1);
        psplat_splats s = writer_splats(&w, 5);
        if (i == 0) s.runs[0].is_curved = 0;
        if (i == 1) s.runs[0].is_curved = 0, s.runs[0].has_shape = 1;
        if (i == 2) s.runs[3].has_bends = 0;
        if (i == 3) s.runs[1].count++;
        if (i == 4) s.precision.shape_step = 0;
        if (i == 5) s.precision.bend_step = 0;
        uint8_t *data = NULL;
        size_t size;
        psplat_error error = {0};
        if (psplat_glb_write(&s, NULL, NULL, &data, &size, &error) != PSPLAT_ERROR_ARGUMENT)
            fail_msg("%d is written", i);
        assert_null(data);
        psplat_splats_free(&s);
    }
}

/* The writer refuses values that are not finite, also in finishes. */
static void test_not_finite(void **state) {
    (void)state;
    written w = {.count = 5, .size = 1, .has_gradients = 1};
    for (int i = 0; i < 24; ++i) {
        psplat_splats s = writer_splats(&w, 5);
        if (i >= 12) s.precision = steps_of(1);
        ((float *)&s.finishes[3])[i % 12] = i & 1 ? INFINITY : NAN;
        uint8_t *data = NULL;
        size_t size;
        psplat_error error = {0};
        assert_int_equal(psplat_glb_write(&s, NULL, NULL, &data, &size, &error),
                         PSPLAT_ERROR_RANGE);
        assert_null(data);
        psplat_splats_free(&s);
    }
}

/* ---- grades ---------------------------------------------------------------------------------- */

/* Returns how many splats have coarser steps than the largest ones. */
static size_t count_coarser(const psplat_splats *s) {
    size_t coarser = 0;
    for (size_t i = 0; i < s->count; ++i) {
        const double radius[2] = {(double)s->splats[i].radius[0], (double)s->splats[i].radius[1]};
        coarser += psplat_precision_at(&s->precision, radius).line_shift > 0;
    }
    return coarser;
}

/* Splats whose steps follow from their radii come back from a file, too, and take fewer bytes than
 * the same splats with all bits. */
static void test_graded(void **state) {
    (void)state;
    for (int i = 0; i < 8; ++i) {
        written w = {.count = 300, .size = 3, .least_part = 0.01, .has_slopes = 1, .has_gamma = 1};
        w.curved = i & 1 ? 31 : 0;
        w.has_shape = (i & 2) != 0;
        w.has_bends = (i & 4) != 0;
        w.precision = steps_of(w.size);
        w.precision.turn_step = 1.0 / 256;
        w.precision.normal_bits = 11;
        psplat_splats s = writer_splats(&w, 5), fine = writer_splats(&w, 5);
        s.precision.halving = (int)lrint(log(2) / w.precision.scale_step);
        s.precision.shape_grades = 3;
        s.precision.normal_grades = 4;
        for (size_t k = 0; k < s.count; ++k)
            s.precision.reference = (int)fmax(
                s.precision.reference,
                log((double)s.splats[k].radius[0] / w.precision.unit) / w.precision.scale_step);
        s.precision.reference +=
            2 * s.precision.halving; /* all splats have two bits less or more */
        psplat_round_to_precision(&s);
        assert_int_equal(count_coarser(&s), w.count);
        size_t size, fine_size;
        uint8_t *data = writer_file(&s, 1, &compressed, &size);
        uint8_t *fine_data = writer_file(&fine, 1, &compressed, &fine_size);
        psplat_asset *asset = writer_open(data, size);
        check_asset(&w, &s, asset);
        assert_true(size + w.count < fine_size); /* by a byte a splat, and more */
        psplat_asset_destroy(asset);
        free(fine_data);
        free(data);
        psplat_splats_free(&s);
        psplat_splats_free(&fine);
    }
}

/* ---- writing again -------------------------------------------------------------------------- */

/* Returns the splats read from a file as those of a mesh, with one run for each batch, which may
 * have joined several runs. */
static psplat_splats splats_of(const psplat_asset *asset, const psplat_splats *original) {
    psplat_splats s = *original;
    s.splats = writer_memory(s.count, sizeof *s.splats);
    s.runs = writer_memory(s.run_count, sizeof *s.runs);
    s.run_count = psplat_asset_batch_count(asset);
    assert_true(s.run_count <= original->run_count);
    s.finishes = original->finishes ? writer_memory(s.count, sizeof *s.finishes) : NULL;
    size_t count = 0;
    for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
        const psplat_batch *batch = psplat_asset_batch(asset, b);
        s.runs[b] = (psplat_run){.count = (uint32_t)batch->splat_count,
                                 .clip_lines = batch->clip_count,
                                 .depth_tolerance = original->runs->depth_tolerance,
                                 .is_curved = batch->is_curved,
                                 .has_shape = batch->has_shape,
                                 .has_bends = batch->has_bends};
        for (int k = 0; k < 3; ++k) s.origin[k] = batch->model[12 + k];
        for (size_t i = 0; i < batch->splat_count; ++i, ++count) {
            psplat_splat *to = &s.splats[count];
            double unit = batch->model[0];
            *to = batch->splats[i];
            for (int k = 0; k < 3; ++k) to->center[k] = (float)((double)to->center[k] * unit);
            for (int k = 0; k < 2; ++k) to->radius[k] = (float)((double)to->radius[k] * unit);
            if (s.finishes) s.finishes[count] = batch->finishes[i];
        }
    }
    assert_int_equal(count, s.count);
    return s;
}

/* Writing again what was read gives the same bytes. */
static void test_written_again(void **state) {
    (void)state;
    for (int i = 0; i < 32; ++i) {
        written w = {.count = 300, .size = i & 4 ? 1e-5 : 40, .origin = {3e5, -0.1, 7}};
        w.curved = i & 8 ? 31 : 0;
        w.has_shape = w.has_bends = (i & 16) != 0;
        w.has_color = w.has_slopes = w.has_gradients = w.has_surface = w.has_emissive = 1;
        if (i & 1) w.precision = steps_of(w.size);
        const psplat_write_desc *desc = i & 2 ? &compressed : &plain;
        psplat_splats s = writer_splats(&w, 2);
        size_t size, again_size;
        uint8_t *data = writer_file(&s, 1, desc, &size);
        psplat_asset *asset = writer_open(data, size);
        psplat_splats again = splats_of(asset, &s);
        uint8_t *again_data = writer_file(&again, 1, desc, &again_size);
        assert_int_equal(again_size, size);
        assert_memory_equal(again_data, data, size);
        free(again_data);
        free(again.splats);
        free(again.runs);
        free(again.finishes);
        psplat_asset_destroy(asset);
        free(data);
        psplat_splats_free(&s);
    }
}

int test_written_splats_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_attributes),    cmocka_unit_test(test_curved),
        cmocka_unit_test(test_lines),         cmocka_unit_test(test_one),
        cmocka_unit_test(test_many),          cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_far),           cmocka_unit_test(test_digits),
        cmocka_unit_test(test_thin),          cmocka_unit_test(test_steps),
        cmocka_unit_test(test_too_fine),      cmocka_unit_test(test_not_finite),
        cmocka_unit_test(test_wrong_runs),    cmocka_unit_test(test_graded),
        cmocka_unit_test(test_written_again),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

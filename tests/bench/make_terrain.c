/* SPDX-License-Identifier: MIT
 *
 * make_terrain.c - terrains of any size as binary PLY, row by row in constant memory: ranges of
 * mountains, valleys between them, plains and cliffs of terraces.
 *
 *     make_terrain N [SEED] > terrain.ply      # 2 N N triangles over the unit square, Y up
 *
 * Heights are sums of gradient noise (Perlin: Improving Noise, 2002), ridged where mountains are
 * (Musgrave: Texturing and Modeling, chapter 16), as a function of the place alone: a larger N
 * samples the same terrain more finely. The least of the waves are some 40 cm on a side of 10 km.
 */
#include <inttypes.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OCTAVES = 13 };

static uint32_t hash(uint32_t x, uint32_t y, uint32_t seed) {
    uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca77u ^ seed * 0xc2b2ae3du;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return h ^ h >> 15;
}

/* Returns the product of the gradient at a point of the grid with the way from it. */
static double slope(uint32_t x, uint32_t y, uint32_t seed, double dx, double dy) {
    static const double directions[8][2] = {
        {1, 0},  {0.7071, 0.7071},   {0, 1},  {-0.7071, 0.7071},
        {-1, 0}, {-0.7071, -0.7071}, {0, -1}, {0.7071, -0.7071}};
    const double *d = directions[hash(x, y, seed) >> 29];
    return d[0] * dx + d[1] * dy;
}

static double fade(double t) {
    return t * t * t * (t * (6 * t - 15) + 10);
}

/* Returns noise from -1 to 1 whose waves have length 1. */
static double noise(double x, double y, uint32_t seed) {
    double floor_x = floor(x), floor_y = floor(y), dx = x - floor_x, dy = y - floor_y;
    uint32_t i = (uint32_t)(int64_t)floor_x, j = (uint32_t)(int64_t)floor_y;
    double u = fade(dx), v = fade(dy);
    double low = slope(i, j, seed, dx, dy) * (1 - u) + slope(i + 1, j, seed, dx - 1, dy) * u;
    double high =
        slope(i, j + 1, seed, dx, dy - 1) * (1 - u) + slope(i + 1, j + 1, seed, dx - 1, dy - 1) * u;
    return 1.5 * (low * (1 - v) + high * v);
}

/* Returns the height at a place of the unit square. */
static double height(double x, double y, uint32_t seed) {
    double range = 0.5 + 0.5 * noise(2.3 * x, 2.3 * y, seed + 100); /* 0: plain, 1: mountains */
    double sum = 0, amplitude = 1, frequency = 4, weight = 1;
    range = range * range;
    for (uint32_t o = 0; o < OCTAVES; ++o) {
        double ridge = 1 - fabs(noise(frequency * x, frequency * y, seed + o));
        ridge *= ridge * weight;
        weight = fmin(1, 2 * ridge);
        sum += amplitude * ridge;
        amplitude *= 0.48;
        frequency *= 2.03;
    }
    double at = range * sum * 0.09 + 0.01 * noise(3 * x + 7, 3 * y, seed + 50);
    /* Where a slow wave says so, heights gather in terraces with cliffs between them. */
    double terraced = fmax(0, noise(3 * x, 3 * y + 5, seed + 200)), step = 0.02;
    double level = at / step, part = level - floor(level);
    double cliff = (floor(level) + fade(fade(part))) * step;
    return at + fmin(1, 2 * terraced) * (cliff - at);
}

static void put_row(uint32_t row, uint32_t n, uint32_t seed, float *vertices) {
    for (uint32_t i = 0; i <= n; ++i) {
        double x = (double)i / n, y = (double)row / n;
        vertices[3 * i] = (float)x;
        vertices[3 * i + 1] = (float)height(x, y, seed);
        vertices[3 * i + 2] = (float)y;
    }
    fwrite(vertices, 3 * sizeof *vertices, n + 1, stdout);
}

/* Writes the triangles of a row of squares, seen from above counterclockwise. */
static void put_squares(uint32_t row, uint32_t n, unsigned char *faces) {
    unsigned char *to = faces;
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t a = row * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
        const uint32_t triangles[2][3] = {{a, c, b}, {b, c, d}};
        for (int t = 0; t < 2; ++t) {
            *to++ = 3;
            memcpy(to, triangles[t], sizeof triangles[t]);
            to += sizeof triangles[t];
        }
    }
    fwrite(faces, 1, (size_t)(to - faces), stdout);
}

int main(int argc, char **argv) {
    long size = argc > 1 ? atol(argv[1]) : 0;
    uint32_t seed = argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 10) : 1;
    if (argc > 3 || size < 1 || size > 40000) {
        fprintf(stderr, "usage: make_terrain N [SEED] > terrain.ply; N is 1 to 40000\n");
        return 1;
    }
    uint32_t n = (uint32_t)size;
    void *row = malloc(26 * (size_t)n + 64);
    if (!row) return 1;
    printf("ply\nformat binary_little_endian 1.0\nelement vertex %" PRIu64
           "\nproperty float x\nproperty float y\nproperty float z\nelement face %" PRIu64
           "\nproperty list uchar uint vertex_indices\nend_header\n",
           (uint64_t)(n + 1) * (n + 1), 2 * (uint64_t)n * n);
    for (uint32_t i = 0; i <= n; ++i) put_row(i, n, seed, row);
    for (uint32_t i = 0; i < n; ++i) put_squares(i, n, row);
    free(row);
    return fflush(stdout) || ferror(stdout);
}

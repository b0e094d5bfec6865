/* SPDX-License-Identifier: MIT
 *
 * flight_terrain.c - the waves, their splats, and the files of the tileset. x and z lie in the unit
 * square, y is up.
 */
#include "flight_terrain.h"

#include "scene_curved.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Waves of an octave are half as long and half as high as those of the octave before. */
enum { OCTAVES = TERRAIN_MAX_LEVEL + 5, WAVES = 3 };

/* Tiles below this level are in external tilesets. */
enum { EXTERNAL_LEVEL = 4 };

static const double greatest_height = 0.012;

/* Height, and its derivatives by x, z, xx, xz, zz. */
typedef struct place {
    double y, dx, dz, dxx, dxz, dzz;
} place;

static void give_up(const char *what) {
    fprintf(stderr, "bench_flight: %s\n", what);
    exit(2);
}

/* ---- the surface --------------------------------------------------------------------------- */

/* Returns the sum of the octaves below a number. Directions and phases follow from the golden
 * ratio, so that they look random. */
static place at(double x, double z, int octaves) {
    const double pi = 3.14159265358979323846;
    place p = {0};
    for (int i = 0; i < octaves * WAVES; ++i) {
        double turn = 2 * pi * fmod(0.618033988749895 * (i + 1), 1), f = pi * ldexp(2, i / WAVES);
        double a = f * cos(turn), b = f * sin(turn), height = greatest_height / ldexp(1, i / WAVES);
        double phase = a * x + b * z + 2.39996322972865 * i * i, s = height * sin(phase);
        double c = height * cos(phase);
        p.y += s;
        p.dx += a * c;
        p.dz += b * c;
        p.dxx -= a * a * s;
        p.dxz -= a * b * s;
        p.dzz -= b * b * s;
    }
    return p;
}

/* A level has the octaves whose waves are three splats long or longer. */
static int octaves_of(int level) {
    return level + 4;
}

double terrain_height(double x, double z) {
    return at(x, z, OCTAVES).y;
}

/* ---- splats -------------------------------------------------------------------------------- */

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalize(double v[3]) {
    double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; ++i) v[i] /= length;
}

/* The axes of a splat, N its normal. */
typedef struct frame {
    double u[3], v[3], n[3];
} frame;

static frame frame_of(const place *p) {
    frame f = {.u = {1, p->dx, 0}, .n = {-p->dx, 1, -p->dz}};
    normalize(f.u);
    normalize(f.n);
    f.v[0] = f.n[1] * f.u[2] - f.n[2] * f.u[1];
    f.v[1] = f.n[2] * f.u[0] - f.n[0] * f.u[2];
    f.v[2] = f.n[0] * f.u[1] - f.n[1] * f.u[0];
    return f;
}

/* Returns the curvature of the surface between two tangents. */
static double curvature(const place *p, const double a[3], const double b[3]) {
    double form = p->dxx * a[0] * b[0] + p->dxz * (a[0] * b[2] + a[2] * b[0]);
    return (form + p->dzz * a[2] * b[2]) / sqrt(1 + p->dx * p->dx + p->dz * p->dz);
}

/* Cuts a splat where axis (0: x, 2: z) is side x half from its centre. */
static void clip(psplat_splat *splat, const frame *f, double radius, int axis, double side,
                 double half) {
    double line[3] = {-side * radius * f->u[axis], -side * radius * f->v[axis], half};
    double length = hypot(line[0], line[1]);
    for (int i = 0; i < 3; ++i) splat->clip[splat->clip_count][i] = (float)(line[i] / length);
    ++splat->clip_count;
}

/* Makes the splat of the square of side size around (x, z), as the quadric that touches there. */
static void make_splat(psplat_splat *splat, double x, double z, double size, int octaves) {
    place p = at(x, z, octaves);
    frame f = frame_of(&p);
    double half = 0.62 * size; /* overlaps hide what neighbours differ by, of other levels too */
    double rise = half * (fabs(p.dx) + fabs(p.dz));
    double radius = 1.02 * sqrt(2 * half * half + rise * rise);
    const double center[3] = {x, p.y, z};
    scene_set_axes(splat, f.u, f.v);
    for (int i = 0; i < 3; ++i) {
        splat->center[i] = (float)center[i];
        splat->normal[i] = (float)f.n[i];
    }
    splat->radius[0] = splat->radius[1] = (float)radius;
    splat->gradient[0] = (float)(-radius * curvature(&p, f.u, f.u));
    splat->gradient[1] = (float)(-radius * curvature(&p, f.v, f.v));
    splat->gradient[2] = (float)(-radius * curvature(&p, f.u, f.v));
    splat->clip_count = 0;
    for (int side = -1; side <= 1; side += 2) {
        clip(splat, &f, radius, 0, side, half);
        clip(splat, &f, radius, 2, side, half);
    }
    scene_curve_splat(splat);
}

/* Returns how far the splat around (x, z) is from the surface, along y, a part (s, t) of its square
 * from its centre. */
static double error_at(double x, double z, double size, double s, double t, int octaves) {
    place p = at(x, z, octaves);
    double dx = s * size, dz = t * size;
    double quadric = p.y + p.dx * dx + p.dz * dz +
                     0.5 * (p.dxx * dx * dx + 2 * p.dxz * dx * dz + p.dzz * dz * dz);
    return fabs(quadric - terrain_height(x + dx, z + dz)) / sqrt(1 + p.dx * p.dx + p.dz * p.dz);
}

terrain terrain_make(int finest) {
    enum { PLACES = 4000 };
    terrain t = {.finest = finest};
    uint32_t random = 1;
    for (int level = 0; level <= finest; ++level) {
        double size = 1 / ldexp(TERRAIN_SIDE, level), most = 0;
        for (int i = 0; i < PLACES; ++i) {
            double x = (double)scene_random(&random), z = (double)scene_random(&random);
            double s = (double)scene_random(&random) - 0.5, u = (double)scene_random(&random) - 0.5;
            most = fmax(most, error_at(x, z, size, s, u, octaves_of(level)));
        }
        t.errors[level] = most;
    }
    return t;
}

size_t terrain_splats(const terrain *t) {
    return (size_t)TERRAIN_SPLATS << (2 * t->finest);
}

static uint8_t *tile_bytes(const terrain *t, int level, int i, int j, size_t *size) {
    scene s = scene_blank(TERRAIN_SPLATS);
    double cell = 1 / ldexp(TERRAIN_SIDE, level);
    for (int k = 0; k < TERRAIN_SPLATS; ++k)
        make_splat(&s.splats[k], (i * TERRAIN_SIDE + k % TERRAIN_SIDE + 0.5) * cell,
                   (j * TERRAIN_SIDE + k / TERRAIN_SIDE + 0.5) * cell, cell, octaves_of(level));
    s.depth_tolerance = (float)(2 * t->errors[level]);
    uint8_t *bytes = scene_curved_glb(&s, size);
    scene_free(&s);
    return bytes;
}

/* ---- tilesets ------------------------------------------------------------------------------ */

typedef struct text {
    char *data;
    size_t size, capacity;
} text;

static void append(text *to, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;

static void append(text *to, const char *format, ...) {
    va_list arguments;
    if (to->capacity - to->size < 400) to->data = realloc(to->data, to->capacity += 1 << 20);
    if (!to->data) give_up("no memory for a tileset");
    va_start(arguments, format);
    to->size += (size_t)vsnprintf(to->data + to->size, 400, format, arguments);
    va_end(arguments);
}

/* Appends the box of a tile, z up: sampled, with what octaves that were left out may add. */
static void append_volume(text *to, int level, int i, int j) {
    enum { SAMPLES = 8 };
    double side = ldexp(1, -level), low = INFINITY, high = -INFINITY;
    double more = 0.5 * WAVES * greatest_height / ldexp(1, octaves_of(level) - 1) + 0.05 * side;
    for (int k = 0; k <= SAMPLES * (SAMPLES + 1) + SAMPLES; ++k) {
        double x = (i + (double)(k % (SAMPLES + 1)) / SAMPLES) * side;
        double y = at(x, (j + (double)(k / (SAMPLES + 1)) / SAMPLES) * side, octaves_of(level)).y;
        low = fmin(low, y);
        high = fmax(high, y);
    }
    append(to, "\"boundingVolume\":{\"box\":[%.9g,%.9g,%.9g,%.9g,0,0,0,%.9g,0,0,0,%.9g]}",
           (i + 0.5) * side, -(j + 0.5) * side, 0.5 * (low + high), 0.52 * side, 0.52 * side,
           0.5 * (high - low) + more);
}

/* Appends a tile, with what is below it down to the level last and external tilesets there. */
static void append_tile(text *to, const terrain *t, int level, int i, int j, int last) {
    int is_external = level > last;
    append(to, "{");
    append_volume(to, level, i, j);
    append(to, ",\"geometricError\":%.9g,\"refine\":\"REPLACE\"", t->errors[level]);
    append(to, ",\"content\":{\"uri\":\"%d-%d-%d.%s\"}", level, i, j, is_external ? "json" : "glb");
    for (int k = 0; k < 4 && !is_external && level < t->finest; ++k) {
        append(to, k ? "," : ",\"children\":[");
        append_tile(to, t, level + 1, 2 * i + k % 2, 2 * j + k / 2, last);
        if (k == 3) append(to, "]");
    }
    append(to, "}");
}

/* Makes a tileset whose root is this tile. */
static uint8_t *tileset_bytes(const terrain *t, int level, int i, int j, size_t *size) {
    text to = {0};
    append(&to, "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":1,\"root\":");
    append_tile(&to, t, level, i, j, level ? t->finest : EXTERNAL_LEVEL);
    append(&to, "}");
    *size = to.size;
    return (uint8_t *)to.data;
}

uint8_t *terrain_file(const terrain *t, const char *path, size_t *size) {
    int level = 0, i = 0, j = 0, end = 0;
    if (!strcmp(path, "tileset.json")) return tileset_bytes(t, 0, 0, 0, size);
    if (sscanf(path, "%d-%d-%d.%n", &level, &i, &j, &end) != 3 || !end) give_up(path);
    if (!strcmp(path + end, "json")) return tileset_bytes(t, level, i, j, size);
    return tile_bytes(t, level, i, j, size);
}

/* ---- the mesh ------------------------------------------------------------------------------ */

void terrain_write_mesh(const char *path, int side) {
    FILE *file = fopen(path, "w");
    if (!file) give_up(path);
    for (int j = 0; j <= side; ++j)
        for (int i = 0; i <= side; ++i) {
            double x = (double)i / side, z = (double)j / side;
            fprintf(file, "v %.7f %.7f %.7f\n", x, terrain_height(x, z), z);
        }
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
            int a = j * (side + 1) + i + 1, b = a + side + 1;
            fprintf(file, "f %d %d %d\nf %d %d %d\n", a, b, a + 1, a + 1, b, b + 1);
        }
    if (fclose(file)) give_up(path);
}

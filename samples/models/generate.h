/* SPDX-License-Identifier: MIT
 *
 * generate.h - the parts of the program that makes the sample models: a growing mesh, flat faces
 * with holes, the machined part, and the file formats.
 */
#ifndef PHONGSPLAT_SAMPLES_GENERATE_H
#define PHONGSPLAT_SAMPLES_GENERATE_H

#include <stddef.h>
#include <stdint.h>

#define PI 3.14159265358979323846

/* ---- solid.c: a mesh under construction ----------------------------------------------------- */

/* A mesh in which vertices of exactly equal position are one vertex, so that patches built from the
 * same points are joined. normals, texcoords and colors are filled by models that have them, else
 * NULL. */
typedef struct solid {
    double (*positions)[3];
    float (*normals)[3];
    float (*texcoords)[2];
    uint8_t (*colors)[4];
    uint32_t (*triangles)[3];
    size_t vertex_count, triangle_count;
    size_t vertex_capacity, triangle_capacity;
} solid;

uint32_t solid_vertex(solid *s, double x, double y, double z);
void solid_triangle(solid *s, uint32_t a, uint32_t b, uint32_t c);
/* Corners counter-clockwise. */
void solid_quad(solid *s, uint32_t a, uint32_t b, uint32_t c, uint32_t d);
void solid_free(solid *s);
void *resize(void *memory, size_t size); /* a realloc that ends the program when out of memory */

/* ---- plane.c: outlines and the flat faces between them --------------------------------------- */

/* A closed polyline in the x-y plane, counter-clockwise; its first point is not repeated at the
 * end. */
typedef struct outline {
    double (*points)[2];
    size_t count;
} outline;

void outline_point(outline *o, double x, double y);
/* Adds a straight stretch from the last point to (x, y) in steps of about `step`. */
void outline_line(outline *o, double x, double y, double step);
/* Adds an arc around (cx, cy) from angle a to angle b (radians). The first point is left out where
 * the outline already ends there. */
void outline_arc(outline *o, double cx, double cy, double radius, double a, double b, double step);
/* Returns the outline moved inwards by distance, with mitred corners. */
outline outline_inset(const outline *o, double distance);
void outline_free(outline *o);

/* Triangulates the region inside outer and outside the holes with triangles of about `step`, at
 * height z, facing up or down. The segments of the outlines become edges of triangles; their points
 * should be `step` apart. */
void solid_face(solid *s, const outline *outer, const outline *holes, size_t hole_count, double z,
                double step, int up);

/* ---- part.c ------------------------------------------------------------------------------- */

solid make_part(void);

/* ---- shapes.c: the simple models ------------------------------------------------------------ */

solid make_box(double x, double y, double z);
solid make_sphere(int subdivisions);
solid make_torus(double major, double minor, int segments, int sides);
solid make_cone(double radius, double height, int segments);
solid make_bracket(void);
/* Makes points without triangles on an ellipsoid of radii x, y, z. */
solid make_scan(double x, double y, double z, int count);
solid make_vase(void);   /* open, with texture coordinates */
solid make_ribbon(void); /* a coloured ring */

/* ---- formats.c: each returns 0, or -1 where the file cannot be written ---------------------- */

int write_obj(const char *path, const solid *s);
int write_off(const char *path, const solid *s);
int write_ply_text(const char *path, const solid *s);
int write_ply_binary(const char *path, const solid *s);
int write_stl_binary(const char *path, const solid *s);
int write_stl_text(const char *path, const solid *s);
int write_xyz(const char *path, const solid *s); /* positions and normals */

/* ---- gltf.c ------------------------------------------------------------------------------- */

int write_gltf(const char *path, const solid *s);
/* Writes the painted piece: a textured vase and two coloured rings under a tree of nodes. */
int write_painted_glb(const char *path, const solid *vase, const solid *ribbon);

/* ---- tiled.c: a barrel with every texture of a material -------------------------------------- */

int write_tiled_glb(const char *path);

/* ---- still_life.c: a scene ------------------------------------------------------------------ */

int write_still_life(const char *path);

/* ---- clockwork.c: a scene that moves --------------------------------------------------------- */

int write_clockwork(const char *path);

/* ---- png.c: an RGB picture as PNG with stored deflate blocks; *size bytes, malloc'ed -------- */

uint8_t *make_png(const uint8_t *rgb, uint32_t width, uint32_t height, size_t *size);

#endif

/* SPDX-License-Identifier: MIT
 *
 * oracle.h - the stages of the reference rasteriser, in the order of schema/README.md sections 3
 * to 5. Private to runtime/reference; everything is double precision and in eye space, whose unit
 * is the scene's because views are rigid.
 */
#ifndef PHONGSPLAT_ORACLE_H
#define PHONGSPLAT_ORACLE_H

#include <phongsplat/reference.h>

/* ---- algebra.c ----------------------------------------------------------------------------- */

double psplat_oracle_dot(const double a[3], const double b[3]);
double psplat_oracle_length(const double a[3]);
void psplat_oracle_cross(const double a[3], const double b[3], double out[3]);
/* out = origin + s * direction */
void psplat_oracle_along(const double origin[3], double s, const double direction[3],
                         double out[3]);
/* Scales to length 1; a vector of length 0 stays 0. */
void psplat_oracle_normalise(double a[3]);
/* Column-major 4x4; out may be neither a nor b. */
void psplat_oracle_multiply(const double a[16], const double b[16], double out[16]);
/* out = m (v, w) */
void psplat_oracle_transform(const double m[16], const double v[3], double w, double out[4]);
/* Returns 0 where m has no finite inverse. */
int psplat_oracle_invert(const double m[16], double out[16]);

/* ---- place.c: sections 3 and 4 ------------------------------------------------------------ */

/* What a node's transform and the camera make of all splats of a batch. */
typedef struct psplat_oracle_space {
    double model_view[16];
    double normal_matrix[3][3]; /* |det M3|^(1/3) M3^-T, row by row */
    double epsilon;             /* |det M3|^(1/3) depthTolerance */
} psplat_oracle_space;

/* Returns 0 where the transform is singular and draws nothing. */
int psplat_oracle_place_batch(const psplat_batch *batch, const double transform[16],
                              const double view[16], psplat_oracle_space *space);

typedef struct psplat_oracle_splat {
    double center[3];
    double axis[2][3];      /* images of r_u U and r_v V: conjugate radii of the ellipse */
    double plane[3];        /* axis[0] x axis[1], not normalised */
    double parameter[2][3]; /* u = parameter[0].(q - c), v = parameter[1].(q - c): eq. (1) */
    double side[3];         /* unit image of N as a normal: the front */
    double normal[3][3];    /* n(u, v) = normal[0] + u normal[1] + v normal[2]: eq. (2) */
    double clip[PSPLAT_MAX_CLIP_LINES][3];
    uint32_t clip_count;
    double cosine, epsilon; /* eq. (5); set by psplat_oracle_camera_face */
} psplat_oracle_splat;

void psplat_oracle_place_splat(const psplat_splat *splat, uint32_t clip_count,
                               const psplat_oracle_space *space, psplat_oracle_splat *placed);

/* ---- ray.c: rays and bounds ------------------------------------------------------------ */

typedef struct psplat_oracle_camera {
    double projection[16];
    double eye[4];      /* homogeneous; w is 0 in parallel views */
    double pixel[3][4]; /* the point of pixel (x, y) on z = 0 is pixel[0] + x [1] + y [2] */
    int parallel;
    int width, height;
} psplat_oracle_camera;

/* Returns 0 where the projection has no inverse. */
int psplat_oracle_camera_set(psplat_oracle_camera *camera, const psplat_view *view);

/* The ray through (x, y) in pixels: points origin + s * direction; s grows away from the eye. */
typedef struct psplat_oracle_ray {
    double x, y;
    double origin[3], direction[3];
    double length; /* |direction|: s * length is the distance t of section 5.3 */
} psplat_oracle_ray;

void psplat_oracle_camera_ray(const psplat_oracle_camera *camera, double x, double y,
                              psplat_oracle_ray *ray);

/* Derivatives of a ray's origin and direction by x and by y. */
typedef struct psplat_oracle_ray_steps {
    double origin[2][3], direction[2][3];
} psplat_oracle_ray_steps;

void psplat_oracle_camera_ray_steps(const psplat_oracle_camera *camera,
                                    const psplat_oracle_ray *ray, psplat_oracle_ray_steps *steps);

/* Window depth 0 ... 1 and clip w of a point. */
double psplat_oracle_camera_depth(const psplat_oracle_camera *camera, const double point[3],
                                  double *w);

/* How the splat faces this camera, and its tolerance along the camera's rays: eq. (5). */
void psplat_oracle_camera_face(const psplat_oracle_camera *camera, const psplat_oracle_space *space,
                               psplat_oracle_splat *splat);

/* Pixels x0 <= x < x1, y0 <= y < y1 hold every fragment of the splat and one pixel around. */
typedef struct psplat_oracle_box {
    int x0, x1, y0, y1;
} psplat_oracle_box;

psplat_oracle_box psplat_oracle_camera_bounds(const psplat_oracle_camera *camera,
                                              const psplat_oracle_splat *splat);

/* ---- fragment.c: sections 5.1 and 5.2 ----------------------------------------------------- */

typedef struct psplat_oracle_fragment {
    double s, t, depth, u, v, r; /* s and t along the ray */
    double cosine;               /* of N' and the direction to the eye: > 0 seen from the front */
} psplat_oracle_fragment;

/* Finds where the ray meets the splat's plane in front of the eye; returns 0 where it does not. */
int psplat_oracle_fragment_find(const psplat_oracle_camera *camera,
                                const psplat_oracle_splat *splat, const psplat_oracle_ray *ray,
                                psplat_oracle_fragment *fragment);

/* Whether that point is a fragment: inside, kept, between near and far, on a visible side. */
int psplat_oracle_fragment_exists(const psplat_oracle_splat *splat,
                                  const psplat_oracle_fragment *fragment, int cull);

/* How far it is from being there (negative) or from not being there (positive): by its edges and
 * its side, and by the near and far plane. See psplat_reference_image.tie. */
typedef struct psplat_oracle_margins {
    double edge, depth;
} psplat_oracle_margins;

psplat_oracle_margins psplat_oracle_fragment_margins(const psplat_oracle_camera *camera,
                                                     const psplat_oracle_splat *splat,
                                                     const psplat_oracle_ray *ray,
                                                     const psplat_oracle_fragment *fragment,
                                                     int cull);

/* ---- shade.c: section 5.6 ----------------------------------------------------------------- */

/* The numbers of a material that vary over an image once colours are applied. */
typedef struct psplat_oracle_surface {
    double base[3], emissive[3];
    double metallic, roughness;
    double unlit; /* 0 ... 1 */
} psplat_oracle_surface;

typedef struct psplat_oracle_light {
    double direction[3]; /* unit, eye space */
    double irradiance[3], ambient[3];
} psplat_oracle_light;

void psplat_oracle_light_set(psplat_oracle_light *light, const psplat_view *view);

/* Eq. (7); normal and to_eye are unit vectors. */
void psplat_oracle_shade(const psplat_oracle_surface *surface, const psplat_oracle_light *light,
                         const double normal[3], const double to_eye[3], double radiance[3]);

/* The sRGB transfer function (IEC 61966-2-1), clamped to 0 ... 1. */
double psplat_oracle_encode(double linear);

#endif

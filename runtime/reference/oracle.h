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

/* Distance t along the ray to the point of a window depth. */
double psplat_oracle_camera_reach(const psplat_oracle_camera *camera, const psplat_oracle_ray *ray,
                                  double depth);

/* How the splat faces this camera, and its tolerance along the camera's rays: eq. (5). */
void psplat_oracle_camera_face(const psplat_oracle_camera *camera, const psplat_oracle_space *space,
                               psplat_oracle_splat *splat);

/* Clip coordinates: (u, v) has frame[0] + u frame[1] + v frame[2]. */
void psplat_oracle_camera_frame(const psplat_oracle_camera *camera,
                                const psplat_oracle_splat *splat, double frame[3][4]);

/* Pixels x0 <= x < x1, y0 <= y < y1 hold every fragment of the ellipse and one pixel around. */
typedef struct psplat_oracle_box {
    int x0, x1, y0, y1;
} psplat_oracle_box;

psplat_oracle_box psplat_oracle_camera_bounds(const psplat_oracle_camera *camera,
                                              double frame[3][4]);

/* ---- fragment.c: sections 5.1 and 5.2 ----------------------------------------------------- */

typedef struct psplat_oracle_fragment {
    double s, t, depth, u, v, r; /* s and t along the ray */
    double cosine;               /* of N' and the direction to the eye: > 0 seen from the front */
} psplat_oracle_fragment;

/* Finds where the ray meets the splat's plane in front of the eye; returns 0 where it does not. */
int psplat_oracle_fragment_find(const psplat_oracle_camera *camera,
                                const psplat_oracle_splat *splat, const psplat_oracle_ray *ray,
                                psplat_oracle_fragment *fragment);

/* How far along the ray other fragments contribute if this one is there (5.3). */
double psplat_oracle_fragment_limit(const psplat_oracle_splat *splat, const psplat_oracle_ray *ray,
                                    const psplat_oracle_fragment *fragment);

/* Whether that point is a fragment: inside, kept, between near and far, on a visible side. */
int psplat_oracle_fragment_exists(const psplat_oracle_splat *splat,
                                  const psplat_oracle_fragment *fragment, int cull);

/* A linear or distance function of (u, v) that decides by its sign: its value, or its distance from
 * 0 in pixels (to first order) where that is less. by_* are its derivatives by u and v. */
double psplat_oracle_edge(double value, double by_u, double by_v, double steps[2][2]);

/* How far something is from being there (negative) or from not being there (positive): by edges and
 * side, and by the near and far plane. See psplat_reference_image.tie. */
typedef struct psplat_oracle_margins {
    double edge, depth;
} psplat_oracle_margins;

psplat_oracle_margins psplat_oracle_fragment_margins(const psplat_oracle_camera *camera,
                                                     const psplat_oracle_splat *splat,
                                                     const psplat_oracle_ray *ray,
                                                     const psplat_oracle_fragment *fragment,
                                                     int cull);

/* ---- filter.c: section 5.8 ---------------------------------------------------------------- */

typedef struct psplat_oracle_filter {
    int is_on;                     /* 0: the splat as it is, s2 >= 1 in most cases */
    psplat_oracle_margins margins; /* of that decision, where it changes something; else 1 */
    double frame[3][4];            /* C'(u, v), see psplat_oracle_camera_frame */
    double jacobian[2][2];         /* J': of x (0) and y (1) in pixels by u and v */
    double determinant;            /* of J' */
    double ratio;                  /* det J / det J' */
    double softness;               /* t */
    double nearer; /* window depth that it lacks where it is compared with the limit */
} psplat_oracle_filter;

/* may_filter: 0 leaves the splat as it is. */
void psplat_oracle_filter_set(psplat_oracle_filter *filter, const psplat_oracle_camera *camera,
                              const psplat_oracle_splat *splat, int may_filter);

/* A splat at a pixel. */
typedef struct psplat_oracle_sight {
    const psplat_oracle_camera *camera;
    const psplat_oracle_splat *splat;
    const psplat_oracle_filter *filter;
    const psplat_oracle_ray *ray;
    const psplat_oracle_fragment *fragment; /* of its plane; NULL where the ray does not meet it */
    int cull;
} psplat_oracle_sight;

/* What a splat adds to a pixel, visibility apart. */
typedef struct psplat_oracle_share {
    double tested;   /* the distance that is compared with the limit */
    double t, depth; /* where it lies on the ray */
    double u, v, r;
    double factor; /* of the filter, 0 ... 1 */
} psplat_oracle_share;

/* Returns 0 where the splat adds nothing; tested is HUGE_VAL where its plane is not met. margins
 * may be NULL. */
int psplat_oracle_filter_share(const psplat_oracle_sight *sight, psplat_oracle_share *share,
                               psplat_oracle_margins *margins);

/* ---- shade.c: section 5.6 ----------------------------------------------------------------- */

/* The numbers of a material that vary over an image once colours are applied. */
typedef struct psplat_oracle_surface {
    double base[3], emissive[3];
    double metallic, roughness, occlusion;
    double unlit; /* 0 ... 1 */
} psplat_oracle_surface;

/* Trowbridge-Reitz (GGX) distribution of microfacet normals D, and the height-correlated Smith
 * masking and shadowing V, divided by 4 (n.l) (n.e). alpha is roughness squared, n.e >= 1e-4. */
double psplat_oracle_distribution(double normal_half, double alpha);
double psplat_oracle_visibility(double normal_light, double normal_eye, double alpha);

struct psplat_oracle_lighting;

/* Eq. (7) at a point; normal and to_eye are unit vectors. */
void psplat_oracle_shade(const psplat_oracle_surface *surface,
                         const struct psplat_oracle_lighting *lighting, const double point[3],
                         const double normal[3], const double to_eye[3], double radiance[3]);

/* The sRGB transfer function (IEC 61966-2-1), clamped to 0 ... 1. */
double psplat_oracle_encode(double linear);

/* ---- environment.c: eq. (9) --------------------------------------------------------------- */

typedef struct psplat_oracle_environment {
    const psplat_environment_desc *desc; /* NULL: none */
    double to_scene[3][3];               /* turns eye space into the cube's */
} psplat_oracle_environment;

void psplat_oracle_environment_add(const psplat_oracle_environment *environment,
                                   const psplat_oracle_surface *surface, const double normal[3],
                                   const double to_eye[3], double radiance[3]);

/* ---- light.c: eq. (8) and shadows --------------------------------------------------------- */

typedef struct psplat_oracle_light {
    psplat_light_type type;
    double color[3];
    double direction[3], position[3]; /* eye space; direction is unit and leads away from it */
    double range;                     /* 0: none */
    double cos_inner, cos_outer;
    int casts_shadow;
} psplat_oracle_light;

/* A splat that may stand in the light, and its batch's epsilon of eq. (5) before the slant. */
typedef struct psplat_oracle_caster {
    psplat_oracle_splat placed;
    double epsilon;
} psplat_oracle_caster;

typedef struct psplat_oracle_lighting {
    psplat_oracle_light lights[PSPLAT_MAX_LIGHTS];
    int count;
    double ambient[3];
    psplat_oracle_environment environment;
    psplat_oracle_caster *casters; /* caster_count of them, where a light casts shadows */
    size_t caster_count;
} psplat_oracle_lighting;

void psplat_oracle_lighting_set(psplat_oracle_lighting *lighting, const psplat_view *view,
                                const psplat_environment_desc *environment);
int psplat_oracle_lighting_has_shadows(const psplat_oracle_lighting *lighting);

/* The unit vector to the light and its irradiance at a point, shadows included. */
void psplat_oracle_light_at(const psplat_oracle_lighting *lighting,
                            const psplat_oracle_light *light, const double point[3],
                            double to_light[3], double irradiance[3]);

/* ---- what becomes of a pixel: blend.c and resolve.c --------------------------------------- */

typedef struct psplat_oracle_pixel {
    double limit;   /* what lies up to here along the ray contributes (5.3) */
    double nearest; /* least t, its splat and its fragment */
    int32_t nearest_splat;
    double u, v;
    uint32_t count;
    double edge_tie, depth_tie, epsilon_tie;
    /* The sums of eq. (6); radiance is that of the comparison modes (5.7). */
    double weight, depth, normal[3], radiance[3];
    psplat_oracle_surface surface;
} psplat_oracle_pixel;

typedef struct psplat_oracle_drawing {
    const psplat_reference_scene *scene;
    const psplat_view *view;
    double transform[16];
    psplat_oracle_camera camera;
    psplat_oracle_lighting lighting;
    int blends; /* 0 in the modes that show the nearest splat alone */
    int ties;   /* somebody asked for them */
    psplat_oracle_pixel *pixels;
} psplat_oracle_drawing;

/* A splat of a pass over all of them. */
typedef struct psplat_oracle_visit {
    const psplat_batch *batch;
    const psplat_splat *splat;
    const psplat_oracle_space *space;
    psplat_oracle_splat placed;
    psplat_oracle_filter filter;
    int32_t index; /* over all batches */
    int cull;
} psplat_oracle_visit;

/* Adds what the splat contributes to a pixel whose visibility is known (5.4 and 5.7), and notes how
 * near the decisions about it are. */
void psplat_oracle_blend(const psplat_oracle_drawing *drawing, const psplat_oracle_visit *visit,
                         const psplat_oracle_sight *sight, psplat_oracle_pixel *pixel);

/* What a normal, a material and a place on the ray are shown as: psplat_view.shading. */
void psplat_oracle_show(const psplat_oracle_drawing *drawing, const psplat_oracle_ray *ray,
                        double t, const psplat_oracle_surface *surface, const double normal[3],
                        double shown[3]);

/* Writes the pixel (x, y) once all sums are there (5.5 and 5.6). */
void psplat_oracle_resolve(const psplat_oracle_drawing *drawing, int x, int y,
                           psplat_reference_image *image);

#endif

/* SPDX-License-Identifier: MIT
 *
 * oracle.h - the stages of the reference rasteriser (the oracle of the tests), in the order of
 * schema/README.md sections 3 to 5. It is private to runtime/reference. Everything is in double
 * precision and in eye space, whose unit is the scene's because views are rigid. Vectors have 3
 * components and matrices are column-major unless a comment says otherwise; outputs may not
 * overlap inputs.
 */
#ifndef PHONGSPLAT_REFERENCE_ORACLE_H
#define PHONGSPLAT_REFERENCE_ORACLE_H

#include <phongsplat/reference.h>

#include <math.h>

/* ---- memory.c ------------------------------------------------------------------------------- */

/* Allocates zeroed elements, and at least one, so that NULL always means that memory ran out. */
void *psplat_oracle_allocate(size_t count, size_t size);
void psplat_oracle_release(void *memory); /* which may be NULL */

/* ---- algebra.c ----------------------------------------------------------------------------- */

#define PSPLAT_ORACLE_PI 3.14159265358979323846

/* What each pixel takes many times is inline. */
static inline double psplat_oracle_dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double psplat_oracle_length(const double a[3]) {
    return sqrt(psplat_oracle_dot(a, a));
}

void psplat_oracle_cross(const double a[3], const double b[3], double out[3]);

/* Computes origin + s * direction. out may be any of the inputs. */
static inline void psplat_oracle_along(const double origin[3], double s, const double direction[3],
                                       double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = origin[i] + s * direction[i];
}

/* Scales a vector to length 1. A vector of length 0 stays 0. */
void psplat_oracle_normalise(double a[3]);
/* Computes the product a b of 4 x 4 matrices. */
void psplat_oracle_multiply(const double a[16], const double b[16], double out[16]);

/* Computes m (v, w): w is 1 for a point and 0 for a direction. */
static inline void psplat_oracle_transform(const double m[16], const double v[3], double w,
                                           double out[4]) {
    for (int row = 0; row < 4; ++row)
        out[row] = m[row] * v[0] + m[4 + row] * v[1] + m[8 + row] * v[2] + m[12 + row] * w;
}

/* Inverts a 4 x 4 matrix. Returns 0 where m has no finite inverse. */
int psplat_oracle_invert(const double m[16], double out[16]);

/* ---- texture.c: images of section 3.11 ------------------------------------------------------ */

#define PSPLAT_ORACLE_LEVELS 17 /* of images of up to 65536 texels a side */

typedef struct psplat_oracle_level {
    int width, height;
    float *rgba; /* height x width x 4, linear light where they are colours, the first row at the
                    top */
} psplat_oracle_level;

typedef struct psplat_oracle_image {
    psplat_oracle_level levels[PSPLAT_ORACLE_LEVELS]; /* level_count of them, the finest first */
    int level_count;
} psplat_oracle_image;

/* Makes an image and its mipmaps, of which each halves the sides and rounds down, by means of
 * texels. Returns 0 where memory runs out. The caller frees the image in either case. */
int psplat_oracle_image_set(psplat_oracle_image *image, const psplat_pixels *pixels, int is_srgb);
void psplat_oracle_image_free(psplat_oracle_image *image);

/* Samples an image at its coordinates st, of which by[0] and by[1] are the derivatives by the
 * pixel's x and y: between four texels of the finest level where a pixel spans at most one texel,
 * else between these of two levels. */
void psplat_oracle_sample(const psplat_oracle_image *image, const psplat_texture *texture,
                          const double st[2], double by[2][2], double rgba[4]);

/* The texture coordinates at a point (u, v) of a splat: eq. (4c). */
typedef struct psplat_oracle_coordinates {
    double at[2];
    double by[2][2];    /* their derivatives by u (row 0) and by v (row 1) */
    double steps[2][2]; /* of (u, v) by the pixel's x (row 0) and y (row 1) */
} psplat_oracle_coordinates;

void psplat_oracle_coordinates_set(psplat_oracle_coordinates *coordinates,
                                   const psplat_texcoord *texcoord, double u, double v,
                                   double steps[2][2]);

/* What decides whether a fragment of a splat is masked away (section 3.11). */
typedef struct psplat_oracle_mask {
    double cutoff; /* 0: there is no mask */
    double alpha;  /* of the material's factor times that of the splat's colour */
    const psplat_texcoord *texcoord;
    const psplat_texture *texture; /* of base colours, with its image; the image may be NULL */
    const psplat_oracle_image *image;
} psplat_oracle_mask;

/* Returns how much more opaque a splat is at (u, v) than its material's cutoff; below 0, it is not
 * there. Returns 1 where there is no mask. */
double psplat_oracle_mask_margin(const psplat_oracle_mask *mask, double u, double v,
                                 double steps[2][2]);

/* ---- place.c: sections 3 and 4 ------------------------------------------------------------ */

/* The transform from a batch's object space to eye space, by which all of its splats are placed. */
typedef struct psplat_oracle_space {
    double model_view[16];
    double normal_matrix[3][3]; /* |det M3|^(1/3) M3^-T, row by row */
    double epsilon;             /* |det M3|^(1/3) depthTolerance */
    double depth_tolerance;
    int is_curved;       /* that of the batch, */
    uint32_t seam_count; /* and of its clip lines how many are seams */
} psplat_oracle_space;

/* Composes view, transform and the batch's model matrix. Returns 0 where their product is singular,
 * so that nothing is drawn (spec 4). */
int psplat_oracle_place_batch(const psplat_batch *batch, const double transform[16],
                              const double view[16], psplat_oracle_space *space);

/* From which side something is seen (5.2). */
typedef enum psplat_oracle_side {
    PSPLAT_ORACLE_FRONT,
    PSPLAT_ORACLE_BACK,
    PSPLAT_ORACLE_PEEKING /* a back that only peeks out behind a contour */
} psplat_oracle_side;

/* A splat in eye space. A point p is c + u axis[0] + v axis[1] + w axis[2]; the plane is w = 0, and
 * the surface of a curved splat is where f(u, v, w) is 0: eq. (1a) divided by r_u says that
 *
 *     f = w + slope.(u, v) + (bend[0] u^2 + 2 bend[1] u v + bend[2] v^2) / 2 */
typedef struct psplat_oracle_splat {
    double center[3];
    double axis[3][3]; /* images of r_u U, r_v V and r_u N; the first two are conjugate radii of the
                          ellipse */
    double plane[3];   /* axis[0] x axis[1], not normalised */
    double parameter[3][3]; /* u = parameter[0].(p - c), v = parameter[1].(p - c): eq. (1); where
                               the splat is curved, w = parameter[2].(p - c) */
    double side[3];         /* unit image of N as a normal; it points to the front */
    double normal[3][3];    /* n(u, v) = normal[0] + u normal[1] + v normal[2]: eq. (2) */
    double clip[PSPLAT_MAX_CLIP_LINES][4]; /* a, b, c and the bend of each line */
    uint32_t clip_count;                   /* those that cut the shape, of which */
    uint32_t line_count;                   /* the lines are the first; the others are seams */
    int is_curved; /* that of the batch: also where the surface is the plane */
    /* The surface's first and second derivatives, w by u and v. A flat splat has in bend those of
     * the surface to which its normal field belongs. */
    double slope[2], bend[3];
    double peek; /* in w: how deep a ray runs under the surface behind its contour at most (5.2) */
    double wall; /* in w: how far down the wall under the rim reaches (5.1); 0: there is none */
    /* How a flat splat is seen by the ray through its centre, and the direction of that, unit
     * length; set by psplat_oracle_camera_face. */
    psplat_oracle_side seen;
    double toward[3];
    double epsilon; /* that of the batch: eq. (5) before it is divided by a cosine */
    double cosine;  /* of the angle in eq. (5) at the centre; set by psplat_oracle_camera_face */
    psplat_oracle_mask mask; /* set by psplat_oracle_mask_set */
} psplat_oracle_splat;

/* Moves a stored splat with so many clip lines, seams among them, into eye space; cosine and mask
 * are left alone. */
void psplat_oracle_place_splat(const psplat_splat *splat, uint32_t line_count,
                               const psplat_oracle_space *space, psplat_oracle_splat *placed);

/* ---- ray.c: rays and bounds ------------------------------------------------------------ */

typedef struct psplat_oracle_camera {
    double projection[16];
    double eye[4];      /* homogeneous; w is 0 in parallel (orthographic) views */
    double pixel[3][4]; /* the point of pixel (x, y) on z = 0 is pixel[0] + x [1] + y [2] */
    int parallel;
    int width, height;
} psplat_oracle_camera;

/* Returns 0 where the projection has no inverse, or where it or the view is not finite. */
int psplat_oracle_camera_set(psplat_oracle_camera *camera, const psplat_view *view);

/* The ray through the window point (x, y) in pixels: its points are origin + s * direction, and s
 * grows away from the eye. */
typedef struct psplat_oracle_ray {
    double x, y;
    double origin[3], direction[3];
    double length; /* |direction|: s * length is the distance t of section 5.3 */
} psplat_oracle_ray;

void psplat_oracle_camera_ray(const psplat_oracle_camera *camera, double x, double y,
                              psplat_oracle_ray *ray);

/* The derivatives of a ray's origin and direction by x (index 0) and by y (index 1). */
typedef struct psplat_oracle_ray_steps {
    double origin[2][3], direction[2][3];
} psplat_oracle_ray_steps;

void psplat_oracle_camera_ray_steps(const psplat_oracle_camera *camera,
                                    const psplat_oracle_ray *ray, psplat_oracle_ray_steps *steps);

/* Returns the window depth of a point, 0 at the near and 1 at the far plane; *w becomes its w in
 * clip space. */
double psplat_oracle_camera_depth(const psplat_oracle_camera *camera, const double point[3],
                                  double *w);

/* Returns the distance t along the ray to its point of a window depth. */
double psplat_oracle_camera_reach(const psplat_oracle_camera *camera, const psplat_oracle_ray *ray,
                                  double depth);

/* Sets the splat's cosine, of the angle between N' and the direction from its centre to the eye,
 * and how a flat one is seen. */
void psplat_oracle_camera_face(const psplat_oracle_camera *camera, psplat_oracle_splat *splat);

/* Finds the splat in clip space: its point (u, v) is frame[0] + u frame[1] + v frame[2]. */
void psplat_oracle_camera_frame(const psplat_oracle_camera *camera,
                                const psplat_oracle_splat *splat, double frame[3][4]);

/* The pixels x0 <= x < x1, y0 <= y < y1. */
typedef struct psplat_oracle_box {
    int x0, x1, y0, y1;
} psplat_oracle_box;

/* Returns a box of pixels that holds every fragment of the ellipse of a frame, and one pixel around
 * them; it is empty (all 0) where the ellipse is outside the near and far plane. */
psplat_oracle_box psplat_oracle_camera_bounds(const psplat_oracle_camera *camera,
                                              double frame[3][4]);

/* Does the same for the surface of a curved splat. */
psplat_oracle_box psplat_oracle_camera_curved_bounds(const psplat_oracle_camera *camera,
                                                     const psplat_oracle_splat *splat);

/* ---- curve.c: the surfaces of sections 3.4 and 5.1, the lines of section 3.6
 * --------------------- */

/* The height f of a ray above the surface of a curved splat is F(s) = height[0] + height[1] (s -
 * s0)
 * + height[2] (s - s0)^2 at its parameter s. s0 is where the ray is nearest to the centre, so that
 * nothing cancels where the eye is far away. */
typedef struct psplat_oracle_crossing {
    double s0, origin[3], direction[3]; /* the ray at s0, in (u, v, w) */
    double height[3];
    double discriminant; /* D of section 5.1 */
} psplat_oracle_crossing;

void psplat_oracle_crossing_set(psplat_oracle_crossing *crossing, const psplat_oracle_splat *splat,
                                const double origin[3], const double direction[3]);

/* Returns the ray's parameter s where F is 0 and its slope is -sqrt(D), so that the ray meets the
 * front, or where is_back is 1 its slope is sqrt(D). It is not finite where there is no such root.
 */
double psplat_oracle_crossing_root(const psplat_oracle_crossing *crossing, int is_back);

/* Returns the ray's parameter s halfway between both roots, real or not; it is not finite where F
 * is linear. */
double psplat_oracle_crossing_middle(const psplat_oracle_crossing *crossing);

/* Returns the derivative of D where the ray's origin and direction move by these amounts. */
double psplat_oracle_crossing_change(const psplat_oracle_crossing *crossing,
                                     const psplat_oracle_splat *splat, const double origin[3],
                                     const double direction[3]);

/* Stores a normal of the splat's surface at (u, v) that points to its front, of any length: the
 * gradient of f in eye space, or the plane's normal. */
void psplat_oracle_surface_normal(const psplat_oracle_splat *splat, double u, double v,
                                  double normal[3]);

/* Returns 1 where a back only peeks out behind a contour (5.2): where a ray comes out of the convex
 * side of the surface, under which it has not been deep. Its height F has there the derivative
 * `first` and half of the second derivative `half_second`. */
int psplat_oracle_is_peeking(const psplat_oracle_splat *splat, double first, double half_second);

/* Returns the value of clip line k at (u, v), which is at least 0 where the line keeps the point
 * (eq. (3b)), and stores its derivatives by u and by v where slope is not NULL. */
double psplat_oracle_line_value(const psplat_oracle_splat *splat, uint32_t k, double u, double v,
                                double slope[2]);

/* Returns 1 where (u, v) is inside the ellipse and kept by all clip lines. */
int psplat_oracle_is_inside(const psplat_oracle_splat *splat, double u, double v);

/* How a ray goes into the cylinder on whose side the wall of a curved splat stands (5.1). */
typedef struct psplat_oracle_entry {
    double s; /* the ray's parameter there, or, where it passes by, next to the axis */
    /* What all are above 0 where the ray meets the wall, by u, v and w: how far from the cylinder's
     * side it passes the axis, how high over the wall's foot and how deep under the rim it goes in,
     * how steeply its height falls there, and how far within each clip line that is. */
    double margins[4 + PSPLAT_MAX_CLIP_LINES];
    uint32_t count; /* of them */
} psplat_oracle_entry;

void psplat_oracle_entry_set(psplat_oracle_entry *entry, const psplat_oracle_splat *splat,
                             const double origin[3], const double direction[3]);

/* Returns 1 where the ray meets the wall. */
int psplat_oracle_entry_meets(const psplat_oracle_entry *entry);

/* ---- fragment.c: sections 5.1 and 5.2 ----------------------------------------------------- */

/* A point where a ray meets a splat's surface, or misses it narrowly. */
typedef struct psplat_oracle_fragment {
    double s, t;    /* along the ray: its parameter, and the distance |direction| s */
    double depth;   /* window depth */
    double u, v, r; /* r is the length of (u, v) */
    double cosine;  /* of the surface's normal and the direction to the eye: > 0 where seen from the
                       front */
    int is_missed;  /* 1: the ray passes by a curved surface or its wall, and this is where it is
                       nearest */
    int is_wall;    /* 1: the point is one of the wall (5.1), with the normal at the rim */
    int is_peeking; /* 1: it is a back behind the contour (5.2) */
} psplat_oracle_fragment;

/* The points where a ray meets a splat in front of the eye, the nearest first, then that of the
 * wall, and none beyond the first that is a fragment. */
typedef struct psplat_oracle_meeting {
    psplat_oracle_fragment points[3];
    int count;     /* 0 ... 3 */
    int is_inside; /* 1: the last of them is a fragment */
} psplat_oracle_meeting;

/* Finds these points; where cull is 1, of a curved splat only the one seen from the front. */
void psplat_oracle_meet(const psplat_oracle_camera *camera, const psplat_oracle_splat *splat,
                        const psplat_oracle_ray *ray, int cull, psplat_oracle_meeting *meeting);

/* Returns the fragment, or NULL where there is none. */
const psplat_oracle_fragment *psplat_oracle_met(const psplat_oracle_meeting *meeting);

/* How many times its depth tolerance a wall does not hide (5.3). */
#define PSPLAT_ORACLE_WALL_SHIFT 8

/* Finds the derivatives of (u, v) by the pixel's x (steps[0]) and y (steps[1]), along the plane
 * that touches the surface, or the wall, at the fragment. Along a contour they are infinite. */
void psplat_oracle_find_steps(const psplat_oracle_camera *camera, const psplat_oracle_splat *splat,
                              const psplat_oracle_ray *ray, const psplat_oracle_fragment *fragment,
                              double steps[2][2]);

/* Returns the distance t up to which other fragments of the pixel contribute if this fragment
 * exists: one term of the minimum in eq. (5a). */
double psplat_oracle_fragment_limit(const psplat_oracle_splat *splat, const psplat_oracle_ray *ray,
                                    const psplat_oracle_fragment *fragment);

/* Returns from which side a fragment is seen. */
psplat_oracle_side psplat_oracle_fragment_side(const psplat_oracle_splat *splat,
                                               const psplat_oracle_fragment *fragment);

/* Turns the normal of a fragment that a ray sees from this side as 5.2 says: negates or mirrors it.
 */
void psplat_oracle_face_normal(const psplat_oracle_splat *splat, const psplat_oracle_ray *ray,
                               psplat_oracle_side side, double normal[3]);

/* Returns the margin of a decision by the sign of a function of (u, v): the function's value, or
 * its distance from 0 in pixels (to first order) where that is less. by_u and by_v are its
 * derivatives; steps are those of (u, v) by the pixel's x (row 0) and y (row 1). */
double psplat_oracle_edge(double value, double by_u, double by_v, double steps[2][2]);

/* Margins say how far a fragment is from the opposite decision about its existence: they are
 * positive where it exists, and one is negative where it does not. edge is the least margin to the
 * ellipse, the clip lines, the side, the contour of a curved surface and the ends of its wall (in
 * (u, v) or pixels), depth that to the near and the far plane (window depth). These are what
 * psplat_reference_image.tie and depth_tie are made of. */
typedef struct psplat_oracle_margins {
    double edge, depth;
} psplat_oracle_margins;

psplat_oracle_margins psplat_oracle_fragment_margins(const psplat_oracle_camera *camera,
                                                     const psplat_oracle_splat *splat,
                                                     const psplat_oracle_ray *ray,
                                                     const psplat_oracle_fragment *fragment,
                                                     int cull);

/* ---- filter.c: section 5.8 ---------------------------------------------------------------- */

/* A splat as the filter widens it. */
typedef struct psplat_oracle_filter {
    int is_on;                     /* 0: the splat is not filtered, mostly because s2 >= 1 */
    psplat_oracle_margins margins; /* of that decision where it matters, else 1 */
    double frame[3][4];            /* C'(u, v), as psplat_oracle_camera_frame finds it */
    double jacobian[2][2];         /* J': of x (0) and y (1) in pixels by u and v */
    double determinant;            /* of J' */
    double ratio;                  /* det J / det J' */
    double softness;               /* t: pixels over which clip lines are softened */
    double nearer; /* window depth that is subtracted where it is compared with the limit */
} psplat_oracle_filter;

/* Computes the filter of a splat. may_filter 0 turns it off; curved splats have none. */
void psplat_oracle_filter_set(psplat_oracle_filter *filter, const psplat_oracle_camera *camera,
                              const psplat_oracle_splat *splat, int may_filter);

/* A splat as the ray of one pixel meets it. */
typedef struct psplat_oracle_sight {
    const psplat_oracle_camera *camera;
    const psplat_oracle_splat *splat;
    const psplat_oracle_filter *filter;
    const psplat_oracle_ray *ray;
    const psplat_oracle_meeting *meeting;
    int cull; /* 1: backs are not seen */
} psplat_oracle_sight;

/* The contribution of a splat to a pixel where it is visible. */
typedef struct psplat_oracle_share {
    double tested;   /* the distance along the ray that is compared with the visibility limit */
    double t, depth; /* its distance along the ray and its window depth */
    double u, v, r;
    double factor;      /* by which the filter multiplies its weight, 0 ... 1 */
    double seam;        /* the factor s of what its material adds (3.6), up to 1 */
    double seam_margin; /* as in psplat_oracle_margins, to where s changes all at once */
    psplat_oracle_side seen;
    double steps[2][2]; /* of (u, v) by the pixel's x (row 0) and y (row 1) */
} psplat_oracle_share;

/* Finds what the splat adds. Returns 0 where it adds nothing; tested is HUGE_VAL where the ray does
 * not meet its plane. margins are those of the widened splat, -1 where it is not filtered; they may
 * be NULL. */
int psplat_oracle_filter_share(const psplat_oracle_sight *sight, psplat_oracle_share *share,
                               psplat_oracle_margins *margins);

/* ---- brdf.c: section 5.6 ------------------------------------------------------------------ */

/* Returns D, the Trowbridge-Reitz (GGX) distribution of microfacet normals, for n.h and alpha,
 * which is roughness squared. */
double psplat_oracle_distribution(double normal_half, double alpha);

/* Returns V, the height-correlated Smith masking and shadowing divided by 4 (n.l) (n.e), where n.e
 * is at least 1e-4. */
double psplat_oracle_visibility(double normal_light, double normal_eye, double alpha);

/* ---- shade.c: section 5.6 ----------------------------------------------------------------- */

/* The material of a surface point, or the mean of those that meet in a pixel. */
typedef struct psplat_oracle_surface {
    double base[3], emissive[3];
    double metallic, roughness, occlusion;
    double unlit; /* 0 ... 1 */
} psplat_oracle_surface;

struct psplat_oracle_lighting;

/* Computes the radiance of eq. (7) at a point; normal and to_eye are unit vectors. */
void psplat_oracle_shade(const psplat_oracle_surface *surface,
                         const struct psplat_oracle_lighting *lighting, const double point[3],
                         const double normal[3], const double to_eye[3], double radiance[3]);

/* Applies the sRGB transfer function (IEC 61966-2-1) to a linear value clamped to 0 ... 1. */
double psplat_oracle_encode(double linear);

/* ---- environment_light.c: eq. (9) --------------------------------------------------------- */

typedef struct psplat_oracle_environment {
    const psplat_environment_desc *desc; /* NULL: there is no environment */
    double to_scene[3][3];               /* rows of the rotation from eye space to the cube map's */
} psplat_oracle_environment;

/* Adds the environment's light to radiance, or nothing where there is no environment. */
void psplat_oracle_environment_add(const psplat_oracle_environment *environment,
                                   const psplat_oracle_surface *surface, const double normal[3],
                                   const double to_eye[3], double radiance[3]);

/* ---- light.c: eq. (8) and shadows --------------------------------------------------------- */

typedef struct psplat_oracle_light {
    psplat_light_type type;
    double color[3];
    double direction[3], position[3]; /* eye space; direction is the unit one in which it shines */
    double range;                     /* 0: its light ends nowhere */
    double cos_inner, cos_outer;      /* cosines of a spot light's cone angles */
    int casts_shadow;
} psplat_oracle_light;

typedef struct psplat_oracle_lighting {
    psplat_oracle_light lights[PSPLAT_MAX_LIGHTS];
    int count;
    double ambient[3];
    psplat_oracle_environment environment;
    psplat_oracle_splat *casters; /* caster_count of them where a light casts shadows */
    size_t caster_count;
} psplat_oracle_lighting;

/* Sets all but the casters, from a view and an environment, which may be NULL. */
void psplat_oracle_lighting_set(psplat_oracle_lighting *lighting, const psplat_view *view,
                                const psplat_environment_desc *environment);

/* Returns 1 where some light casts shadows. */
int psplat_oracle_lighting_has_shadows(const psplat_oracle_lighting *lighting);

/* Finds the unit vector to the light and its irradiance at a point, which is 0 in shadow. */
void psplat_oracle_light_at(const psplat_oracle_lighting *lighting,
                            const psplat_oracle_light *light, const double point[3],
                            double to_light[3], double irradiance[3]);

/* ---- blend.c and resolve.c: sections 5.4 to 5.7 ------------------------------------------- */

/* The state of a pixel between the passes. */
typedef struct psplat_oracle_pixel {
    double limit;          /* distance along the ray up to which splats contribute (5.3) */
    double nearest;        /* distance t of the nearest fragment; HUGE_VAL where there is none */
    int32_t nearest_splat; /* the index of its splat, or -1 */
    double u, v;           /* parameters of the nearest fragment */
    uint32_t count;        /* splats that contribute */
    double edge_tie, depth_tie, epsilon_tie, alpha_tie; /* as in psplat_reference_image */
    /* The sums of eq. (6); radiance is that of the comparison modes (5.7). */
    double weight, depth, normal[3], radiance[3];
    psplat_oracle_surface surface;
} psplat_oracle_pixel;

/* One call of psplat_reference_draw. */
typedef struct psplat_oracle_drawing {
    const psplat_reference_scene *scene;
    const psplat_view *view;
    double transform[16]; /* the scene's, or the identity */
    psplat_oracle_camera camera;
    psplat_oracle_lighting lighting;
    int blends;                  /* 0 in the modes that show the nearest splat alone */
    int ties;                    /* 1 where the image has an array for ties */
    psplat_oracle_pixel *pixels; /* width * height, row 0 at the bottom */
    psplat_oracle_image *images; /* two for each image of the scene: as numbers, as colours */
} psplat_oracle_drawing;

/* ---- textured.c: section 3.11 --------------------------------------------------------------- */

/* Makes the images that the scene's materials use. Fails with ARGUMENT or MEMORY; the caller frees
 * them in any case. */
psplat_result psplat_oracle_images_make(psplat_oracle_drawing *drawing, psplat_error *error);
void psplat_oracle_images_free(psplat_oracle_drawing *drawing);

void psplat_oracle_mask_set(psplat_oracle_mask *mask, const psplat_oracle_drawing *drawing,
                            const psplat_batch *batch, size_t index);

/* Multiplies a surface by the textures of its material (eq. (4d)). */
void psplat_oracle_texture_surface(const psplat_oracle_drawing *drawing,
                                   const psplat_material *material,
                                   const psplat_oracle_coordinates *coordinates,
                                   psplat_oracle_surface *surface);

/* Returns 1 where the normals of a batch are turned by a texture. */
int psplat_oracle_turns_normals(const psplat_oracle_drawing *drawing, const psplat_batch *batch);

/* Turns the normal of a splat's front at (u, v) by the material's normal texture (eq. (4e)). */
void psplat_oracle_texture_normal(const psplat_oracle_drawing *drawing,
                                  const psplat_material *material, const psplat_oracle_splat *splat,
                                  const psplat_oracle_coordinates *coordinates, double u, double v,
                                  double normal[3]);

/* A splat as a pass over all splats visits it. */
typedef struct psplat_oracle_visit {
    const psplat_batch *batch;
    const psplat_splat *splat;
    const psplat_oracle_space *space;
    psplat_oracle_splat placed;
    psplat_oracle_filter filter;
    int32_t index; /* counted over all batches */
    int cull;      /* 1: backs are not seen */
} psplat_oracle_visit;

/* Adds what the splat contributes to a pixel whose visibility limit is known (5.4 and 5.7), and
 * notes how near the decisions about it are to the opposite. */
void psplat_oracle_blend(const psplat_oracle_drawing *drawing, const psplat_oracle_visit *visit,
                         const psplat_oracle_sight *sight, psplat_oracle_pixel *pixel);

/* Finds the colour that psplat_view.shading (LIT, UNLIT or NORMAL) gives a normal of any length and
 * a material at the distance t along the ray. */
void psplat_oracle_show(const psplat_oracle_drawing *drawing, const psplat_oracle_ray *ray,
                        double t, const psplat_oracle_surface *surface, const double normal[3],
                        double shown[3]);

/* Writes the pixel (x, y) into the image's arrays once its sums are complete (5.5 and 5.6). */
void psplat_oracle_resolve(const psplat_oracle_drawing *drawing, int x, int y,
                           psplat_reference_image *image);

#endif

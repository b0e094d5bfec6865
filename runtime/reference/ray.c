/* SPDX-License-Identifier: MIT
 *
 * ray.c - the camera of the reference rasteriser: rays through pixels, found from the projection
 * matrix alone (spec 5), and the box of pixels that a splat may touch.
 *
 * In clip space the ray through normalised device coordinates (X, Y) consists of the points
 * w (X, Y, 0, 1) + z (0, 0, 1, 0). The inverse projection takes the first of the two vectors to a
 * point of the pixel and the second to the eye, which is at infinity in parallel views.
 */
#include "reference/oracle.h"

#include <math.h>
#include <string.h>

int psplat_oracle_camera_set(psplat_oracle_camera *camera, const psplat_view *view) {
    double inverse[16];
    for (int i = 0; i < 16; ++i)
        if (!isfinite(view->projection[i]) || !isfinite(view->view[i])) return 0;
    if (!psplat_oracle_invert(view->projection, inverse)) return 0;
    memcpy(camera->projection, view->projection, sizeof camera->projection);
    camera->width = view->width;
    camera->height = view->height;
    double step_x = 2.0 / view->width, step_y = 2.0 / view->height;
    for (int i = 0; i < 4; ++i) {
        camera->eye[i] = inverse[8 + i];
        camera->pixel[0][i] = inverse[12 + i] - inverse[i] - inverse[4 + i];
        camera->pixel[1][i] = step_x * inverse[i];
        camera->pixel[2][i] = step_y * inverse[4 + i];
    }
    camera->parallel = camera->eye[3] == 0;
    return 1;
}

/* Finds the homogeneous point of pixel (x, y) on the plane z = 0 of clip space. */
static void pixel_point(const psplat_oracle_camera *camera, double x, double y, double at[4]) {
    for (int i = 0; i < 4; ++i)
        at[i] = camera->pixel[0][i] + x * camera->pixel[1][i] + y * camera->pixel[2][i];
}

void psplat_oracle_camera_ray(const psplat_oracle_camera *camera, double x, double y,
                              psplat_oracle_ray *ray) {
    double at[4], scale = 0;
    pixel_point(camera, x, y, at);
    scale = 1 / (camera->parallel ? at[3] : camera->eye[3]);
    for (int i = 0; i < 3; ++i) {
        double eye = camera->eye[i] * scale;
        ray->origin[i] = camera->parallel ? at[i] * scale : eye;
        ray->direction[i] = camera->parallel ? eye : at[i] - at[3] * eye;
    }
    ray->x = x;
    ray->y = y;
    ray->length = psplat_oracle_length(ray->direction);
}

void psplat_oracle_camera_ray_steps(const psplat_oracle_camera *camera,
                                    const psplat_oracle_ray *ray, psplat_oracle_ray_steps *steps) {
    double at[4];
    pixel_point(camera, ray->x, ray->y, at);
    for (int k = 0; k < 2; ++k)
        for (int i = 0; i < 3; ++i) {
            double step = camera->pixel[k + 1][i], w = camera->pixel[k + 1][3];
            steps->origin[k][i] = camera->parallel ? (step - w * ray->origin[i]) / at[3] : 0;
            steps->direction[k][i] =
                camera->parallel ? -w * ray->direction[i] / at[3] : step - w * ray->origin[i];
        }
}

/* Returns how a flat splat is seen by a ray through its centre. The surface of its field lies under
 * the plane by half of what bend says. */
static psplat_oracle_side side_of(const psplat_oracle_splat *splat) {
    double d[3], normal[3];
    for (int k = 0; k < 3; ++k) {
        psplat_oracle_cross(splat->axis[(k + 1) % 3], splat->axis[(k + 2) % 3], normal);
        d[k] = psplat_oracle_dot(normal, splat->toward) / psplat_oracle_dot(normal, splat->axis[k]);
    }
    double bent = splat->bend[0] * d[0] * d[0] + 2 * splat->bend[1] * d[0] * d[1] +
                  splat->bend[2] * d[1] * d[1];
    if (!(d[2] > 0)) return PSPLAT_ORACLE_FRONT;
    return psplat_oracle_is_peeking(splat, d[2], bent / 2) ? PSPLAT_ORACLE_PEEKING
                                                           : PSPLAT_ORACLE_BACK;
}

void psplat_oracle_camera_face(const psplat_oracle_camera *camera, psplat_oracle_splat *splat) {
    psplat_oracle_ray ray;
    psplat_oracle_camera_ray(camera, 0, 0,
                             &ray); /* in parallel views all rays have one direction */
    for (int i = 0; i < 3; ++i)
        splat->toward[i] = camera->parallel ? ray.direction[i]
                                            : splat->center[i] - camera->eye[i] / camera->eye[3];
    psplat_oracle_normalise(splat->toward);
    splat->cosine = -psplat_oracle_dot(splat->side, splat->toward);
    splat->seen = side_of(splat);
}

double psplat_oracle_camera_depth(const psplat_oracle_camera *camera, const double point[3],
                                  double *w) {
    double clip[4];
    psplat_oracle_transform(camera->projection, point, 1, clip);
    *w = clip[3];
    return 0.5 + 0.5 * clip[2] / clip[3];
}

/* The points of one window depth are the plane z = k w of clip space, which the ray is intersected
 * with. */
double psplat_oracle_camera_reach(const psplat_oracle_camera *camera, const psplat_oracle_ray *ray,
                                  double depth) {
    double plane[4], k = 2 * depth - 1;
    for (int i = 0; i < 4; ++i)
        plane[i] = camera->projection[4 * i + 2] - k * camera->projection[4 * i + 3];
    double s = -(psplat_oracle_dot(plane, ray->origin) + plane[3]) /
               psplat_oracle_dot(plane, ray->direction);
    return s * ray->length;
}

void psplat_oracle_camera_frame(const psplat_oracle_camera *camera,
                                const psplat_oracle_splat *splat, double frame[3][4]) {
    psplat_oracle_transform(camera->projection, splat->center, 1, frame[0]);
    psplat_oracle_transform(camera->projection, splat->axis[0], 0, frame[1]);
    psplat_oracle_transform(camera->projection, splat->axis[1], 0, frame[2]);
}

/* ---- bounds --------------------------------------------------------------------------------- */

#define CORNERS 8
/* Rounding may make every edge of a polygon of n corners cross a plane, which leaves n / 2 * 3
 * corners: 8 become 12, and 12 become 18. */
#define MAX_CORNERS 18

typedef struct polygon {
    double corner[MAX_CORNERS][4]; /* clip space */
    int count;
} polygon;

/* Finds the octagon around the ellipse. Its bounds are the ellipse's at most 8 % wider, and need no
 * distinction of cases. */
static void octagon(double frame[3][4], polygon *out) {
    const double radius = 1 / cos(PSPLAT_ORACLE_PI / CORNERS);
    for (int k = 0; k < CORNERS; ++k) {
        double angle = 2 * PSPLAT_ORACLE_PI * k / CORNERS;
        double u = radius * cos(angle), v = radius * sin(angle);
        for (int i = 0; i < 4; ++i)
            out->corner[k][i] = frame[0][i] + u * frame[1][i] + v * frame[2][i];
    }
    out->count = CORNERS;
}

/* Clips the polygon to sign * z <= w (1 + slack) by the algorithm of Sutherland and Hodgman. The
 * slack keeps fragments close to the near or far plane, whose depth ties are wanted. */
static void clip_depth(polygon *shape, double sign) {
    const double slack = 1.0 / 65536;
    polygon kept = {.count = 0};
    for (int k = 0; k < shape->count; ++k) {
        const double *a = shape->corner[k], *b = shape->corner[(k + 1) % shape->count];
        double inside_a = a[3] * (1 + slack) - sign * a[2];
        double inside_b = b[3] * (1 + slack) - sign * b[2];
        if (inside_a >= 0) memcpy(kept.corner[kept.count++], a, sizeof kept.corner[0]);
        if ((inside_a >= 0) == (inside_b >= 0)) continue;
        double s = inside_a / (inside_a - inside_b);
        for (int i = 0; i < 4; ++i) kept.corner[kept.count][i] = a[i] + s * (b[i] - a[i]);
        ++kept.count;
    }
    *shape = kept;
}

/* Clamps a whole window coordinate to 0 ... size. */
static int pixel_of(double window, int size) {
    return (int)fmin(fmax(window, 0), size);
}

/* The bounds of polygons in window coordinates; low is above high where there are none. */
typedef struct extent {
    double low[2], high[2];
} extent;

/* Enlarges the bounds by what the near and the far plane leave of the polygon. */
static void enlarge(const psplat_oracle_camera *camera, polygon shape, extent *bounds) {
    const int size[2] = {camera->width, camera->height};
    clip_depth(&shape, -1);
    if (shape.count) clip_depth(&shape, 1);
    for (int k = 0; k < shape.count; ++k)
        for (int i = 0; i < 2; ++i) {
            const double *corner = shape.corner[k];
            /* w is 0 at the eye alone, and every pixel may see what is there. */
            double at = (0.5 + 0.5 * corner[i] / corner[3]) * size[i];
            int known = corner[3] > 0 && isfinite(at);
            bounds->low[i] = fmin(bounds->low[i], known ? at : 0);
            bounds->high[i] = fmax(bounds->high[i], known ? at : size[i]);
        }
}

static psplat_oracle_box box_of(const psplat_oracle_camera *camera, const extent *bounds) {
    const double margin_pixels = 1, *low = bounds->low, *high = bounds->high;
    if (!(low[0] <= high[0])) return (psplat_oracle_box){0, 0, 0, 0};
    return (psplat_oracle_box){pixel_of(floor(low[0] - margin_pixels), camera->width),
                               pixel_of(ceil(high[0] + margin_pixels), camera->width),
                               pixel_of(floor(low[1] - margin_pixels), camera->height),
                               pixel_of(ceil(high[1] + margin_pixels), camera->height)};
}

psplat_oracle_box psplat_oracle_camera_bounds(const psplat_oracle_camera *camera,
                                              double frame[3][4]) {
    extent bounds = {{HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}};
    polygon shape;
    octagon(frame, &shape);
    enlarge(camera, shape, &bounds);
    return box_of(camera, &bounds);
}

/* Finds the octagon at the height w over the tangent plane at the centre, which is that of the axes
 * r_u (U - x N) and r_v (V - y N). */
static void raised_octagon(const psplat_oracle_camera *camera, const psplat_oracle_splat *splat,
                           double w, polygon *out) {
    psplat_oracle_splat plane = *splat;
    double frame[3][4];
    psplat_oracle_along(splat->center, w, splat->axis[2], plane.center);
    for (int k = 0; k < 2; ++k)
        psplat_oracle_along(splat->axis[k], -splat->slope[k], splat->axis[2], plane.axis[k]);
    psplat_oracle_camera_frame(camera, &plane, frame);
    octagon(frame, out);
}

/* The surface and its wall lie in a prism between two octagons. What the near and the far plane
 * leave of the prism has its corners on its faces. */
psplat_oracle_box psplat_oracle_camera_curved_bounds(const psplat_oracle_camera *camera,
                                                     const psplat_oracle_splat *splat) {
    const double *b = splat->bend;
    double mean = (b[0] + b[2]) / 2, spread = hypot((b[0] - b[2]) / 2, b[1]);
    extent bounds = {{HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}};
    polygon low, high, face;
    raised_octagon(camera, splat, -fmax(mean + spread, 0) / 2 - splat->wall, &low);
    raised_octagon(camera, splat, -fmin(mean - spread, 0) / 2, &high);
    for (int k = 0; k < CORNERS; ++k) {
        int next = (k + 1) % CORNERS;
        const double *corners[4] = {low.corner[k], low.corner[next], high.corner[next],
                                    high.corner[k]};
        face.count = 4;
        for (int i = 0; i < 4; ++i) memcpy(face.corner[i], corners[i], sizeof face.corner[i]);
        enlarge(camera, face, &bounds);
    }
    enlarge(camera, low, &bounds);
    enlarge(camera, high, &bounds);
    return box_of(camera, &bounds);
}

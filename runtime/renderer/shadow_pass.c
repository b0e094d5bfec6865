/* SPDX-License-Identifier: MIT
 *
 * shadow_pass.c - draws the shadow maps (BHZK05 section 6): the visibility pass with each light as
 * the camera. Splats are shifted away from the light by epsilon, as in every visibility pass, and
 * this is the bias that keeps a surface from casting shadows on itself. A directional light gets a
 * parallel projection around all batches, a spot light a perspective one of its cone.
 */
#include "renderer/frame.h"
#include "core/matrix.h"

#include <math.h>
#include <string.h>

enum { DEFAULT_SIZE = 1024 }; /* edge of a shadow map in texels, as phongsplat.h promises */

typedef struct box {
    double min[3], max[3];
} box;

/* ---- the light's camera ------------------------------------------------------------------ */

/* Computes the view matrix of a camera at position that looks along direction. A direction of
 * length 0 counts as -z. */
static void look_along(const float direction[3], const double position[3], double view[16]) {
    double x[3], y[3], z[3], length = 0.0;
    for (int i = 0; i < 3; ++i) length += (double)direction[i] * (double)direction[i];
    length = length > 0.0 ? sqrt(length) : 1.0;
    for (int i = 0; i < 3; ++i) z[i] = -(double)direction[i] / length;
    if (z[0] == 0.0 && z[1] == 0.0 && z[2] == 0.0) z[2] = 1.0;
    psplat_matrix_basis(z, x, y);
    const double *rows[3] = {x, y, z};
    memset(view, 0, 16 * sizeof *view);
    view[15] = 1.0;
    for (int row = 0; row < 3; ++row)
        for (int i = 0; i < 3; ++i) {
            view[4 * i + row] = rows[row][i];
            view[12 + row] -= rows[row][i] * position[i];
        }
}

static size_t drawn_batches(const psplat_item *item) {
    return psplat_item_is_drawn(item) ? item->model->batch_count : 0;
}

/* Returns the axis-aligned bounding box of all batches that are drawn in the space that view leads
 * to. */
static box bounds_in(const psplat_frame *f, const double view[16]) {
    box b = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    for (size_t i = 0; i < f->item_count; ++i)
        for (size_t k = 0; k < drawn_batches(&f->items[i]); ++k) {
            const psplat_model_batch *batch = &f->items[i].model->batches[k];
            if (!psplat_item_shows(&f->items[i], k)) continue;
            double scene[16], m[16];
            psplat_camera_compose(f->items[i].transform, psplat_item_matrix(&f->items[i], k),
                                  scene);
            psplat_matrix_multiply(view, scene, m);
            for (int corner = 0; corner < 8; ++corner)
                for (int row = 0; row < 3; ++row) {
                    double at = m[12 + row];
                    for (int axis = 0; axis < 3; ++axis)
                        at += m[4 * axis + row] * (double)(corner >> axis & 1
                                                               ? batch->bounds_max[axis]
                                                               : batch->bounds_min[axis]);
                    b.min[row] = fmin(b.min[row], at);
                    b.max[row] = fmax(b.max[row], at);
                }
        }
    return b;
}

/* Moves the origin of the space to the middle of the box, so that coordinates that become float
 * stay as small as the scene, wherever it lies. */
static void center(box *b, double view[16]) {
    for (int row = 0; row < 3; ++row) {
        double middle = 0.5 * (b->min[row] + b->max[row]);
        view[12 + row] -= middle;
        b->min[row] -= middle;
        b->max[row] -= middle;
    }
}

/* Computes the projection of a directional light for a box that has its middle at the origin. The
 * map is two texels wider on each side, so that samples at the edge of the box lie in it. Returns
 * the width of a texel in scene units. */
static double parallel_projection(const box *b, int size, double projection[16]) {
    double extent = fmax(fmax(b->max[0] - b->min[0], b->max[1] - b->min[1]), 1e-30);
    double half = 0.5 * extent * size / (size - 4.0);
    double depth = fmax(b->max[2] - b->min[2], 1e-6 * extent);
    memset(projection, 0, 16 * sizeof *projection);
    projection[0] = projection[5] = 1.0 / half;
    projection[10] = -2.0 / (1.1 * depth);
    projection[15] = 1.0;
    return 2.0 * half / size;
}

/* Computes the projection of a spot light: its cone, two texels wider on each side, and between the
 * planes the part of the box in front of the light. Returns the width of a texel at distance 1. */
static double cone_projection(const box *b, double outer_angle, int size, double projection[16]) {
    double tangent = tan(fmin(outer_angle, 1.5)) * size / (size - 4.0);
    double far = fmax(-b->min[2], 1e-30) * 1.01, near = fmax(-b->max[2] * 0.99, 1e-3 * far);
    memset(projection, 0, 16 * sizeof *projection);
    projection[0] = projection[5] = 1.0 / tangent;
    projection[10] = -(far + near) / (far - near);
    projection[11] = -1.0;
    projection[14] = -2.0 * far * near / (far - near);
    return 2.0 * tangent / size;
}

/* ---- maps -------------------------------------------------------------------------------- */

/* Computes the matrix from eye space of the view, by way of the scene, to the map's coordinates
 * (0 ... 1 each) and window depth. */
static psplat_result find_matrix(const psplat_frame *f, const psplat_camera *light,
                                 float matrix[16]) {
    const double *range = f->depth_range;
    const double to_map[16] = {[0] = 0.5,  [5] = 0.5,  [10] = 0.5 * (range[1] - range[0]),
                               [12] = 0.5, [13] = 0.5, [14] = 0.5 * (range[0] + range[1]),
                               [15] = 1.0};
    double scene[16], a[16], b[16];
    if (!psplat_matrix_invert(f->view->view, scene))
        return psplat_fail(f->error, PSPLAT_ERROR_ARGUMENT, 0, "the view has no inverse");
    psplat_matrix_multiply(light->view, scene, a);
    psplat_matrix_multiply(light->projection, a, b);
    psplat_matrix_multiply(to_map, b, a);
    psplat_matrix_to_float(a, 16, matrix);
    return PSPLAT_OK;
}

static psplat_result draw_map(psplat_frame *f, int map, int size) {
    const psplat_gl *gl = &f->renderer->gl;
    int index = f->lights.casters[map];
    const psplat_light *light = &f->view->lights[index];
    const double origin[3] = {0.0, 0.0, 0.0};
    int is_spot = light->type == PSPLAT_LIGHT_SPOT;
    double view[16], projection[16];
    look_along(light->direction, is_spot ? light->position : origin, view);
    box b = bounds_in(f, view);
    if (!is_spot) center(&b, view);
    double texel = is_spot ? cone_projection(&b, psplat_light_outer_angle(light), size, projection)
                           : parallel_projection(&b, size, projection);
    f->lights.cone[index][3] = (float)texel;

    psplat_camera camera;
    const psplat_camera_desc desc = {
        .view = view,
        .projection = projection,
        .width = size,
        .height = size,
        .depth_range = {(float)f->depth_range[0], (float)f->depth_range[1]}};
    psplat_result result = psplat_camera_set(&camera, &desc, f->error);
    if (result == PSPLAT_OK) result = find_matrix(f, &camera, f->renderer->shadows.matrices[map]);
    if (result != PSPLAT_OK) return result;
    gl->Viewport(map * size, 0, size, size);
    /* Backs cast shadows too, or open surfaces would let light through from behind. */
    psplat_program_key key = {.pass = PSPLAT_PASS_VISIBILITY};
    return psplat_frame_draw_batches(f, &camera, key, PSPLAT_CULL_NEVER);
}

/* Returns the largest depth tolerance of all batches in scene units: epsilon of eq. (5) for a splat
 * that faces the light. */
static float largest_tolerance(const psplat_frame *f) {
    double most = 0.0;
    for (size_t i = 0; i < f->item_count; ++i)
        for (size_t k = 0; k < drawn_batches(&f->items[i]); ++k) {
            const psplat_model_batch *batch = &f->items[i].model->batches[k];
            if (!psplat_item_shows(&f->items[i], k)) continue;
            double scene[16];
            psplat_camera_compose(f->items[i].transform, psplat_item_matrix(&f->items[i], k),
                                  scene);
            double scale = cbrt(fabs(psplat_matrix_determinant3(scene)));
            most = fmax(most, scale * (double)batch->depth_tolerance);
        }
    return (float)most;
}

psplat_result psplat_frame_draw_shadows(psplat_frame *f) {
    static const float one = 1.0f;
    const psplat_gl *gl = &f->renderer->gl;
    int most = gl->max_texture_size / PSPLAT_SHADOW_COUNT;
    int size = f->view->shadow_size  ? f->view->shadow_size
               : most < DEFAULT_SIZE ? most
                                     : DEFAULT_SIZE;
    psplat_result result =
        psplat_shadows_bind(&f->renderer->shadows, &f->renderer->gl, &f->renderer->memory.shadows,
                            size, f->lights.shadow_count, f->error);
    if (result != PSPLAT_OK) return result;
    f->renderer->shadows.lift = 2.0f * largest_tolerance(f);
    gl->DepthMask(GL_TRUE);
    gl->DepthFunc(GL_LESS);
    gl->Enable(GL_DEPTH_TEST);
    gl->ClearBufferfv(GL_DEPTH, 0, &one);
    for (int map = 0; map < f->lights.shadow_count && result == PSPLAT_OK; ++map)
        result = draw_map(f, map, size);
    return result;
}

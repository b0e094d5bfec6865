/* SPDX-License-Identifier: MIT
 *
 * choose_level.c - chooses the level of detail of a model for a view, on the CPU.
 */
#include "renderer/renderer.h"
#include "core/matrix.h"
#include "renderer/camera.h"

#include <math.h>

/* Where normals err by so many degrees, the outline counts as it is. */
static const double usual_normal = 5.0;
/* The weight of normals beside outlines, and of the proven distance. */
static const double normal_exponent = 1.5, distance_weight = 0.25;
static const double default_tau = 0.5; /* pixels */

/* Returns by how many pixels the image of a length of eye space moves at most where it is parallel
 * to the picture, times the distance from the eye in perspective (w of clip space). */
static double pixels_at_one(const psplat_view *view) {
    const double *p = view->projection;
    double x = sqrt(p[0] * p[0] + p[4] * p[4] + p[8] * p[8]) * view->width;
    double y = sqrt(p[1] * p[1] + p[5] * p[5] + p[9] * p[9]) * view->height;
    return 0.5 * fmax(x, y);
}

/* Finds the least and the greatest w of clip space of the corners of a model's box. */
static void find_depths(const psplat_model *model, const psplat_view *view,
                        const double modelview[16], double *least, double *greatest) {
    const double *p = view->projection;
    *least = HUGE_VAL;
    *greatest = -HUGE_VAL;
    for (int corner = 0; corner < 8; ++corner) {
        double w = p[15];
        for (int row = 0; row < 3; ++row) {
            double eye = modelview[12 + row];
            for (int axis = 0; axis < 3; ++axis)
                eye += modelview[4 * axis + row] *
                       (corner >> axis & 1 ? model->bounds_max[axis] : model->bounds_min[axis]);
            w += p[4 * row + 3] * eye;
        }
        *least = fmin(*least, w);
        *greatest = fmax(*greatest, w);
    }
}

double psplat_level_error(const psplat_level *level, double pixels) {
    double outline = level->outline * pixels * pow(level->normal / usual_normal, normal_exponent);
    return fmax(distance_weight * level->distance * pixels, outline);
}

/* Returns the coarsest level whose error is at most tau, of those that are coarser than so many at
 * most less by the hysteresis. */
static uint32_t choose(const psplat_model *model, double pixels, double tau, double hysteresis,
                       uint32_t current) {
    uint32_t chosen = 0;
    for (uint32_t l = 1; l < model->level_count; ++l) {
        double most = l > current ? tau * (1.0 - hysteresis) : tau;
        if (!(psplat_level_error(&model->levels[l], pixels) <= most)) break;
        chosen = l;
    }
    return chosen;
}

uint32_t psplat_model_choose_level(const psplat_model *model, const psplat_view *view,
                                   const double transform[16], const psplat_level_choice *choice) {
    static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    static const double none[16];
    static const psplat_level_choice defaults;
    double modelview[16], least, greatest;
    if (!model || !view || model->level_count < 2) return 0;
    if (!choice) choice = &defaults;
    psplat_camera_modelview(view->view, transform ? transform : none, identity, modelview);
    find_depths(model, view, modelview, &least, &greatest);
    if (greatest <= 0.0) return (uint32_t)model->level_count - 1;
    if (!(least > 0.0)) return 0;
    double pixels = pixels_at_one(view) * psplat_matrix_stretch(modelview) / least;
    return choose(model, pixels, choice->tau > 0.0 ? choice->tau : default_tau, choice->hysteresis,
                  choice->hysteresis > 0.0 ? choice->current : UINT32_MAX);
}

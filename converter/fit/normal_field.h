/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * normal_field.h - the least-squares fit of the linear normal field of a splat (spec 3.5).
 */
#ifndef PHONGSPLAT_FIT_NORMAL_FIELD_H
#define PHONGSPLAT_FIT_NORMAL_FIELD_H

#include <stddef.h>

/* Fits the linear normal field (spec 3.5) of an ellipse with these radii to count >= 1 samples.
 * Where these leave it undetermined, it is the solution of least norm. uv: count x 2 parameters;
 * xy: count x 2 local normals with third coordinate 1; field: x, y, alpha, beta, gamma. The field
 * is the constant mean where a linear one would break the bound of spec 3.5. */
void psplat_fit_normal_field(const double (*uv)[2], const double (*xy)[2], size_t count,
                             const double radius[2], double field[5]);

/* Finds the local normal (x, y), with third coordinate 1, of a field at (u, v): spec eq. 2. */
void psplat_normal_field_at(const double field[5], const double radius[2], const double uv[2],
                            double xy[2]);

#endif

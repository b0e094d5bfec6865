/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * angle.h - pi and the degree, the unit of angles in options and reports; functions take radians.
 */
#ifndef PHONGSPLAT_BASE_ANGLE_H
#define PHONGSPLAT_BASE_ANGLE_H

#define PSPLAT_PI 3.14159265358979323846
#define PSPLAT_DEGREE (PSPLAT_PI / 180) /* radians */

#endif

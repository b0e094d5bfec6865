/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * schedule.h - the progress of a conversion, from its current stage.
 */
#ifndef PHONGSPLAT_PIPELINE_SCHEDULE_H
#define PHONGSPLAT_PIPELINE_SCHEDULE_H

/* Returns the part 0 ... 1 of the time of a whole conversion that is usually spent when this
 * fraction of a stage is done. stage is a name that desc.progress gets. Returns -1 for other names.
 */
double psplat_schedule_done(const char *stage, double fraction);

#endif

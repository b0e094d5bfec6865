/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * plan_folder.h - which files of a directory are those of a plan, so that no others are touched.
 */
#ifndef PHONGSPLAT_TILES_PLAN_FOLDER_H
#define PHONGSPLAT_TILES_PLAN_FOLDER_H

/* The folder in which a plan is made before it takes the place of another. */
#define PSPLAT_NEW_PLAN "work.new"

/* Returns "DIRECTORY/NAME" with a suffix, malloc'ed, or NULL when out of memory. */
char *psplat_tile_path(const char *directory, const char *name, const char *suffix);

/* Returns whether a directory has no entry but PSPLAT_NEW_PLAN, which a plan that was killed
 * leaves. A directory that is not there has none; -1: it cannot be read, and errno says why. */
int psplat_plan_folder_is_empty(const char *directory);

/* Deletes what a plan and its tasks have made, but the plan itself: the lists of tasks, the
 * Makefile, the tileset, and the files of work/ and tiles/ with the names that these have. */
void psplat_plan_folder_clear(const char *directory);

/* Deletes PSPLAT_NEW_PLAN. */
void psplat_plan_folder_drop_new(const char *directory);

#endif

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * setting.h - one way to convert a mesh and to draw what comes of it.
 */
#ifndef PHONGSPLAT_TABLE_SETTING_H
#define PHONGSPLAT_TABLE_SETTING_H

#include "table/sweep_options.h"
#include "table/text.h"

#include <phongsplat/phongsplat.h>

typedef enum psplat_competitor {
    PSPLAT_COMPETITOR_MESH = 0, /* the source itself */
    PSPLAT_COMPETITOR_SPLATS,
    PSPLAT_COMPETITOR_GLTFPACK /* a simplified mesh */
} psplat_competitor;

typedef enum psplat_normal_field {
    PSPLAT_FIELD_LINEAR = 0, /* Phong splats */
    PSPLAT_FIELD_CONSTANT,   /* one normal a splat */
    PSPLAT_FIELD_COUNT
} psplat_normal_field;

enum { PSPLAT_DRAWN_MODES = PSPLAT_MODE_PARAMETERS }; /* phong, gaussian, flat */

/* Fields that mean nothing to a competitor are 0. */
typedef struct psplat_setting {
    psplat_competitor competitor;
    double tolerance; /* %, of splats */
    double ratio;     /* of triangles kept, of gltfpack */
    psplat_normal_field field;
    int planar; /* as in psplat_convert_desc; 1 wherever normals are constant */
    psplat_mode mode;
    int no_filter;
} psplat_setting;

extern const char *const psplat_competitor_names[];              /* "mesh", "splats", "gltfpack" */
extern const char *const psplat_field_names[PSPLAT_FIELD_COUNT]; /* "linear", "constant" */
extern const char *const psplat_surface_names[2];                /* "curved", "planar" */
extern const char
    *const psplat_mode_names[PSPLAT_DRAWN_MODES + 1]; /* "phong", "gaussian", "flat", NULL */
extern const char *const psplat_filter_names[2];      /* "on", "off" */

/* Tells whether both draw the same file. */
int psplat_setting_shares_asset(const psplat_setting *a, const psplat_setting *b);
/* Adds "linear-0.5.glb", "planar-0.5.glb", "constant-0.5.glb" or "gltfpack-0.1.glb", and nothing
 * for the source. */
void psplat_setting_file(const psplat_setting *setting, psplat_text *text);
/* Adds "0.5 %, linear normals, phong, no filter", "0.5 %, planar splats, phong", "gltfpack -si 0.1"
 * or "source mesh". */
void psplat_setting_describe(const psplat_setting *setting, psplat_text *text);
/* Adds the command that makes the asset: "phongsplat convert part.obj part.glb --tolerance 0.5%".
 */
void psplat_setting_command(const psplat_setting *setting, const psplat_sweep_options *options,
                            const char *source, psplat_text *text);

#endif

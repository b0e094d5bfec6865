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

/* What a conversion differs in, besides its tolerance. */
typedef enum psplat_form {
    PSPLAT_FORM_USUAL = 0, /* what convert writes without options: curved splats, integers */
    PSPLAT_FORM_FLOAT,     /* --precision float */
    PSPLAT_FORM_PLANAR,    /* --planar */
    PSPLAT_FORM_COUNT
} psplat_form;

enum { PSPLAT_DRAWN_MODES = PSPLAT_MODE_PARAMETERS }; /* phong, gaussian, flat */

/* Fields that mean nothing to a competitor are 0. */
typedef struct psplat_setting {
    psplat_competitor competitor;
    double tolerance; /* %, of splats */
    double ratio;     /* of triangles kept, of gltfpack */
    psplat_form form;
    psplat_mode mode;
} psplat_setting;

extern const char *const psplat_competitor_names[];            /* "mesh", "splats", "gltfpack" */
extern const char *const psplat_form_names[PSPLAT_FORM_COUNT]; /* "usual", "float", "planar" */
extern const char
    *const psplat_mode_names[PSPLAT_DRAWN_MODES + 1]; /* "phong", "gaussian", "flat", NULL */

/* Tells whether both draw the same file. */
int psplat_setting_shares_asset(const psplat_setting *a, const psplat_setting *b);
/* Adds "usual-0.5.glb", "float-0.5.glb", "planar-0.5.glb" or "gltfpack-0.1.glb", and nothing for
 * the source. */
void psplat_setting_file(const psplat_setting *setting, psplat_text *text);
/* Adds the place of the picture of its asset in a sweep's directory: "pictures/usual-0.5.png", or
 * "pictures/source.png". */
void psplat_setting_picture(const psplat_setting *setting, psplat_text *text);
/* Adds what tells its asset from others: "0.5 %", "0.5 %, planar", "gltfpack -si 0.1" or "source
 * mesh". */
void psplat_setting_asset(const psplat_setting *setting, psplat_text *text);
/* Adds "0.5 %, phong", "0.5 %, planar, phong", "gltfpack -si 0.1" or "source mesh". */
void psplat_setting_describe(const psplat_setting *setting, psplat_text *text);
/* Adds the command that makes the asset: "phongsplat convert part.obj part.glb --tolerance 0.5%".
 */
void psplat_setting_command(const psplat_setting *setting, const psplat_sweep_options *options,
                            const char *source, psplat_text *text);

#endif

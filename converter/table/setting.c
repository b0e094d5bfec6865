/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * setting.c - one way to convert and draw: its names, its file, its command.
 */
#include "table/setting.h"

#include "table/sweep_options.h"
#include "table/text.h"

#include <stdlib.h>

const char *const psplat_competitor_names[] = {"mesh", "splats", "gltfpack"};
const char *const psplat_field_names[] = {"linear", "constant"};
const char *const psplat_surface_names[] = {"curved", "planar"};
const char *const psplat_mode_names[] = {"phong", "gaussian", "flat", NULL};
const char *const psplat_filter_names[] = {"on", "off"};

int psplat_setting_shares_asset(const psplat_setting *a, const psplat_setting *b) {
    return a->competitor == b->competitor && a->tolerance == b->tolerance && a->ratio == b->ratio &&
           a->field == b->field && a->planar == b->planar;
}

/* Planar splats with linear normals are what the curved ones are compared with. */
static int is_plain_planar(const psplat_setting *setting) {
    return setting->planar && setting->field == PSPLAT_FIELD_LINEAR;
}

void psplat_setting_file(const psplat_setting *setting, psplat_text *text) {
    if (setting->competitor == PSPLAT_COMPETITOR_MESH) return;
    int is_splats = setting->competitor == PSPLAT_COMPETITOR_SPLATS;
    const char *kind =
        is_plain_planar(setting) ? psplat_surface_names[1] : psplat_field_names[setting->field];
    psplat_text_add(text, "%s-", is_splats ? kind : "gltfpack");
    psplat_text_number(text, is_splats ? setting->tolerance : setting->ratio);
    psplat_text_add(text, ".glb");
}

void psplat_setting_describe(const psplat_setting *setting, psplat_text *text) {
    if (setting->competitor == PSPLAT_COMPETITOR_MESH) {
        psplat_text_add(text, "source mesh");
    } else if (setting->competitor == PSPLAT_COMPETITOR_GLTFPACK) {
        psplat_text_add(text, "gltfpack -si ");
        psplat_text_number(text, setting->ratio);
    } else {
        psplat_text_number(text, setting->tolerance);
        int is_planar = is_plain_planar(setting);
        psplat_text_add(text, " %%, %s %s, %s%s",
                        is_planar ? "planar" : psplat_field_names[setting->field],
                        is_planar ? "splats" : "normals", psplat_mode_names[setting->mode],
                        setting->no_filter ? ", no filter" : "");
    }
}

static void add_option(const char *name, double value, psplat_text *text) {
    if (value == 0) return;
    psplat_text_add(text, " --%s ", name);
    psplat_text_number(text, value);
}

/* Sweeps write floats without compression, as the last two options say. */
static void add_splat_options(const psplat_setting *setting, const psplat_sweep_options *options,
                              psplat_text *text) {
    psplat_text_add(text, " --tolerance ");
    psplat_text_number(text, setting->tolerance);
    psplat_text_add(text, "%%%s",
                    setting->field == PSPLAT_FIELD_CONSTANT ? " --constant-normals" : "");
    if (setting->planar) psplat_text_add(text, " --planar");
    add_option("normal-tolerance", options->normal_tolerance, text);
    add_option("crease-angle", options->crease_angle, text);
    if (options->no_creases) psplat_text_add(text, " --no-creases");
    if (options->effort)
        psplat_text_add(text, " --effort %d", options->effort > 0 ? options->effort : 0);
    if (options->seed) psplat_text_add(text, " --seed %llu", (unsigned long long)options->seed);
    psplat_text_add(text, " --precision float --no-compress");
}

void psplat_setting_command(const psplat_setting *setting, const psplat_sweep_options *options,
                            const char *source, psplat_text *text) {
    psplat_text stem = {0};
    int is_splats = setting->competitor == PSPLAT_COMPETITOR_SPLATS;
    psplat_text_stem(&stem, source);
    psplat_text_add(&stem, ".glb");
    psplat_text_add(text, is_splats ? "phongsplat convert " : "gltfpack -i ");
    psplat_text_quoted(text, source);
    psplat_text_add(text, is_splats ? " " : " -o ");
    psplat_text_quoted(text, stem.data ? stem.data : "");
    if (is_splats) {
        add_splat_options(setting, options, text);
    } else {
        psplat_text_add(text, " -cc -sv -se 1 -si ");
        psplat_text_number(text, setting->ratio);
    }
    text->failed |= stem.failed;
    free(stem.data);
}

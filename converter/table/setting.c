/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * setting.c - one way to convert and draw: its names, its file, its command.
 */
#include "table/setting.h"

#include "table/sweep_options.h"
#include "table/text.h"

#include <stdlib.h>

const char *const psplat_competitor_names[] = {"mesh", "splats", "gltfpack"};
const char *const psplat_form_names[] = {"usual", "float", "planar"};
const char *const psplat_mode_names[] = {"phong", "gaussian", "flat", NULL};

int psplat_setting_shares_asset(const psplat_setting *a, const psplat_setting *b) {
    return a->competitor == b->competitor && a->tolerance == b->tolerance && a->ratio == b->ratio &&
           a->form == b->form;
}

static void add_name(const psplat_setting *setting, psplat_text *text) {
    int is_splats = setting->competitor == PSPLAT_COMPETITOR_SPLATS;
    psplat_text_add(text, "%s-", is_splats ? psplat_form_names[setting->form] : "gltfpack");
    psplat_text_number(text, is_splats ? setting->tolerance : setting->ratio);
}

void psplat_setting_file(const psplat_setting *setting, psplat_text *text) {
    if (setting->competitor == PSPLAT_COMPETITOR_MESH) return;
    add_name(setting, text);
    psplat_text_add(text, ".glb");
}

void psplat_setting_picture(const psplat_setting *setting, psplat_text *text) {
    psplat_text_add(text, "pictures/");
    if (setting->competitor == PSPLAT_COMPETITOR_MESH)
        psplat_text_add(text, "source");
    else
        add_name(setting, text);
    psplat_text_add(text, ".png");
}

void psplat_setting_asset(const psplat_setting *setting, psplat_text *text) {
    if (setting->competitor == PSPLAT_COMPETITOR_MESH) {
        psplat_text_add(text, "source mesh");
    } else if (setting->competitor == PSPLAT_COMPETITOR_GLTFPACK) {
        psplat_text_add(text, "gltfpack -si ");
        psplat_text_number(text, setting->ratio);
    } else {
        psplat_text_number(text, setting->tolerance);
        psplat_text_add(text, " %%");
        if (setting->form) psplat_text_add(text, ", %s", psplat_form_names[setting->form]);
    }
}

void psplat_setting_describe(const psplat_setting *setting, psplat_text *text) {
    psplat_setting_asset(setting, text);
    if (setting->competitor == PSPLAT_COMPETITOR_SPLATS)
        psplat_text_add(text, ", %s", psplat_mode_names[setting->mode]);
}

static void add_option(const char *name, double value, psplat_text *text) {
    if (value == 0) return;
    psplat_text_add(text, " --%s ", name);
    psplat_text_number(text, value);
}

static void add_splat_options(const psplat_setting *setting, const psplat_sweep_options *options,
                              psplat_text *text) {
    psplat_text_add(text, " --tolerance ");
    psplat_text_number(text, setting->tolerance);
    psplat_text_add(text, "%%");
    if (setting->form == PSPLAT_FORM_FLOAT) psplat_text_add(text, " --precision float");
    if (setting->form == PSPLAT_FORM_PLANAR) psplat_text_add(text, " --planar");
    add_option("normal-tolerance", options->normal_tolerance, text);
    add_option("crease-angle", options->crease_angle, text);
    if (options->no_creases) psplat_text_add(text, " --no-creases");
    if (options->effort)
        psplat_text_add(text, " --effort %d", options->effort > 0 ? options->effort : 0);
    if (options->seed) psplat_text_add(text, " --seed %llu", (unsigned long long)options->seed);
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

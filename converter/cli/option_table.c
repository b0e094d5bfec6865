/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * option_table.c - the options that several commands take, so that each is the same everywhere.
 */
#include "cli/options.h"
#include "table/setting.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

const char *const psplat_format_names[] = {"pretty", "json", NULL};

static const psplat_option shared[] = {
    /* Options of conversion: */
    {0, "normal-tolerance", PSPLAT_OPTION_NUMBER, NULL, "DEG",
     "greatest angle between a surface point's normal and that of\n"
     "a splat covering it (default: not bounded)",
     0.1, 90, NULL},
    {0, "effort", PSPLAT_OPTION_EFFORT, NULL, "N",
     "how long to look for fewer splats and for gaps between\nthem (default 4)", 0, 9, NULL},
    {0, "crease-angle", PSPLAT_OPTION_NUMBER, NULL, "DEG",
     "angle between two faces from which their edge is a crease,\nwhich stays sharp (default 30)",
     1, 180, NULL},
    {0, "no-creases", PSPLAT_OPTION_FLAG, NULL, NULL,
     "no edge stays sharp but borders and where more than two\nfaces meet", 0, 0, NULL},
    {0, "seed", PSPLAT_OPTION_UNSIGNED, NULL, "N",
     "seed of the sampling (default 0); equal input, options\nand seed give equal results", 0, 0,
     NULL},
    /* Options of tilesets: */
    {'t', "tolerance", PSPLAT_OPTION_PERCENT, NULL, "PERCENT",
     "greatest distance between splats and surface at the finest\nlevel, in % of the bounding "
     "box's diagonal: 0.2% or 0.2\n(default 0.2); it doubles from level to level",
     1e-5, 20, NULL},
    {0, "tile-splats", PSPLAT_OPTION_COUNT, NULL, "N",
     "halve the cell of a tile while it has more than N splats\n(default 1024)", 8, 1e9, NULL},
    /* Options of drawing and measuring: */
    {0, "samples", PSPLAT_OPTION_COUNT, NULL, "N",
     "points to measure at on either side of a comparison\n(default 200000)", 100, 1e8, NULL},
    {0, "size", PSPLAT_OPTION_COUNT, NULL, "N", "draw pictures of N x N pixels (default 512)", 16,
     8192, NULL},
    {0, "mode", PSPLAT_OPTION_CHOICE, NULL, "phong|gaussian|flat",
     "how splats are drawn (default phong)", 0, 0, psplat_mode_names},
    {0, "no-filter", PSPLAT_OPTION_FLAG, NULL, NULL,
     "draw splats below a pixel as small as they are", 0, 0, NULL},
    {0, "software", PSPLAT_OPTION_FLAG, NULL, NULL, "draw with Mesa's software rasteriser", 0, 0,
     NULL},
    /* Options of output: */
    {0, "report", PSPLAT_OPTION_TEXT, NULL, "R.json",
     "write what was measured as JSON; - is standard output", 0, 0, NULL},
    {0, "format", PSPLAT_OPTION_CHOICE, NULL, "pretty|json",
     "how standard output is written (default pretty)", 0, 0, psplat_format_names},
    {'w', "overwrite", PSPLAT_OPTION_FLAG, NULL, NULL, "replace files that exist", 0, 0, NULL},
    {'q', "quiet", PSPLAT_OPTION_FLAG, NULL, NULL, "print neither progress nor a summary", 0, 0,
     NULL},
};

psplat_option psplat_option_shared(const char *name, void *value) {
    size_t i = 0, count = sizeof shared / sizeof *shared;
    while (i < count && strcmp(shared[i].name, name) != 0) ++i;
    assert(i < count);
    psplat_option option = shared[i];
    option.value = value;
    return option;
}

/* ---- options of conversion ------------------------------------------------------------------- */

static const char *const fallback_names[] = {
    [PSPLAT_FALLBACK_POINTS] = "points", [PSPLAT_FALLBACK_MESH] = "mesh", NULL};

void psplat_options_add_conversion(psplat_option_list *list, psplat_conversion_options *values) {
    psplat_convert_desc *c = &values->convert;
    const psplat_option group[] = {
        psplat_option_shared("effort", &c->effort),
        psplat_option_shared("crease-angle", &c->crease_angle_degrees),
        psplat_option_shared("no-creases", &c->no_creases),
        {0, "constant-normals", PSPLAT_OPTION_FLAG, &c->constant_normals, NULL,
         "one normal a splat instead of a linear field: smaller files\nthat need more splats for "
         "the same shading",
         0, 0, NULL},
        {0, "planar", PSPLAT_OPTION_FLAG, &c->planar, NULL,
         "flat splats alone, as in the paper of 2004, instead of\ncurved ones where these need "
         "fewer",
         0, 0, NULL},
        {0, "precision", PSPLAT_OPTION_TEXT, &values->precision, "P",
         "float: numbers keep all their bits; or the step of positions,\nin tolerances, 0.001 to "
         "0.5, where splats lie on the surface\n(default auto: what makes small files)",
         0, 0, NULL},
        {0, "no-compress", PSPLAT_OPTION_FLAG, &values->no_compress, NULL,
         "neither a stream nor EXT_meshopt_compression", 0, 0, NULL},
        {0, "fallback", PSPLAT_OPTION_CHOICE, &values->fallback, "points|mesh",
         "what viewers that know no splats show: a coloured point\n"
         "cloud (default), or a simplified mesh, which makes files\nlarger",
         0, 0, fallback_names},
    };
    psplat_options_add(list, group, sizeof group / sizeof *group);
}

/* Reads auto, float (0), or the greatest step of positions in units of the tolerance. Returns 0
 * where the text is none of these. */
static int read_precision(const char *text, double *precision) {
    char *end = NULL;
    *precision = PSPLAT_USUAL_PRECISION;
    if (!text || !strcmp(text, "auto")) return 1;
    if (!strcmp(text, "float")) {
        *precision = 0;
        return 1;
    }
    *precision = strtod(text, &end);
    return end != text && !*end && *precision >= 0.001 && *precision <= PSPLAT_GREATEST_PRECISION;
}

psplat_parse psplat_options_check_conversion(const char *command,
                                             psplat_conversion_options *values) {
    psplat_convert_desc *c = &values->convert;
    if (!read_precision(values->precision, &c->precision))
        return psplat_options_refuse(command, "precision",
                                     "neither auto, float nor a number of 0.001 to 0.5");
    if (c->no_creases && c->crease_angle_degrees > 0)
        return psplat_options_refuse(command, "no-creases", "not together with crease-angle");
    return PSPLAT_PARSE_OK;
}

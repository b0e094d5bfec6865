/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * option_table.c - the options that several commands take, so that each is the same everywhere.
 */
#include "cli/options.h"
#include "table/setting.h"

#include <assert.h>
#include <string.h>

const char *const psplat_format_names[] = {"pretty", "json", NULL};

static const psplat_option shared[] = {
    /* Options of conversion: */
    {0, "normal-tolerance", PSPLAT_OPTION_NUMBER, NULL, "DEG",
     "greatest angle between a surface point's normal and that of\n"
     "a splat covering it (default: not bounded)",
     0.1, 90, NULL},
    {0, "effort", PSPLAT_OPTION_EFFORT, NULL, "N", "how long to look for fewer splats (default 2)",
     0, 9, NULL},
    {0, "crease-angle", PSPLAT_OPTION_NUMBER, NULL, "DEG",
     "angle between two faces from which their edge is a crease,\nwhich stays sharp (default 30)",
     1, 180, NULL},
    {0, "no-creases", PSPLAT_OPTION_FLAG, NULL, NULL,
     "no edge stays sharp but borders and where more than two\nfaces meet", 0, 0, NULL},
    {0, "seed", PSPLAT_OPTION_UNSIGNED, NULL, "N",
     "seed of the sampling (default 0); equal input, options\nand seed give equal results", 0, 0,
     NULL},
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

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splats.c - the plane regions of the splats of one mesh, and how their memory is freed.
 */
#include "splats/splats.h"

#include "base/region.h"
#include "splats/splat_frame.h"

#include <stdlib.h>

psplat_region *psplat_splat_regions(const psplat_splats *splats) {
    psplat_region *regions = malloc((splats->count + 1) * sizeof *regions);
    for (size_t run = 0, i = 0; regions && i < splats->count; ++run) {
        size_t end = run < splats->run_count ? i + splats->runs[run].count : splats->count;
        uint32_t seams = run < splats->run_count ? splats->runs[run].seam_lines : 0;
        for (; i < end && i < splats->count; ++i)
            psplat_splat_region(&splats->splats[i], seams, &regions[i]);
    }
    return regions;
}

void psplat_splats_free(psplat_splats *splats) {
    free(splats->splats);
    free(splats->finishes);
    free(splats->texcoords);
    free(splats->runs);
    free(splats->materials);
    *splats = (psplat_splats){0};
}

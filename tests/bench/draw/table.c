/* SPDX-License-Identifier: MIT
 *
 * table.c - tables of measurements; see table.h.
 */
#include "table.h"

#include <stdio.h>
#include <string.h>

static const char *const passes[PROBE_PASS_COUNT] = {"clear", "visibility", "attributes",
                                                     "resolve"};

static void head_csv(void) {
    printf("subject,splats,pixels,mode,who,cpu_ms,wall_ms");
    for (int i = 0; i < PROBE_PASS_COUNT; ++i)
        printf(",%s_cpu_ms,%s_wall_ms,%s_gpu_ms", passes[i], passes[i], passes[i]);
    printf(",generated_per_pixel,blended_per_pixel,ours_over_it\n");
}

void table_head(const options *o, psplat_host *host) {
    if (o->csv) {
        head_csv();
        return;
    }
    printf("%s, %s; medians of %zu frames; %s shading, %d light%s, filter %s\n\n",
           psplat_host_renderer(host), psplat_host_version(host), o->frames,
           options_shading_name(o->shading), o->lights, o->lights > 1 ? "s" : "",
           o->no_filter ? "off" : "on");
    printf("| subject | splats | pixels | mode | who | CPU ms | wall ms | %s, %s, %s, %s: CPU ms%s "
           "| generated / px | blended / px | ours / it |\n",
           passes[0], passes[1], passes[2], passes[3], o->hardware ? " (GPU ms)" : "");
    printf("|---|--:|--:|---|---|--:|--:|---|--:|--:|--:|\n");
}

static void print_csv(const table_row *row) {
    const timing_result *r = row->result;
    printf("%s,%zu,%d,%s,%s,%.3f,%.3f", row->subject, row->splats, row->size,
           options_mode_name(row->mode), row->who, r->frame.cpu, r->frame.wall);
    for (int i = 0; i < PROBE_PASS_COUNT; ++i)
        printf(",%.3f,%.3f,%.3f", r->passes[i].cpu, r->passes[i].wall, r->gpu[i]);
    printf(",%.3f,%.3f,%.3f\n", row->generated, row->blended, row->ratio);
}

static void print_count(double value) {
    if (value > 0)
        printf(" %.2f |", value);
    else
        printf(" |");
}

/* A method that draws only into the host's framebuffer has a single pass. */
static void print_passes(const options *o, const timing_result *r) {
    int last = r->passes[PROBE_ATTRIBUTES].cpu > 0 ? PROBE_RESOLVE : PROBE_CLEAR;
    for (int i = 0; i <= last; ++i) {
        printf("%s%.1f", i ? ", " : " ", r->passes[i].cpu);
        if (o->hardware) printf(" (%.2f)", r->gpu[i]);
    }
    printf(" |");
}

void table_print(const options *o, const table_row *row) {
    const timing_result *r = row->result;
    if (o->csv) {
        print_csv(row);
        return;
    }
    printf("| %s | %zu | %d² | %s | %s | %.1f | %.1f |", row->subject, row->splats, row->size,
           options_mode_name(row->mode), row->who, r->frame.cpu, r->frame.wall);
    print_passes(o, r);
    print_count(row->generated);
    print_count(row->blended);
    print_count(row->ratio);
    printf("\n");
    fflush(stdout);
}

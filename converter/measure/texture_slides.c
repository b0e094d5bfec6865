/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texture_slides.c - how far textures slide over a surface where splats show them.
 *
 * Each sample meets the splats that cover it. These meetings are then looked at splat by splat: the
 * triangles beneath a splat are flooded up to creases and borders of charts, and one of the floods
 * that have much of the area beneath it, inside its seams, is the splat's own chart. So neither a
 * chart beyond a border nor another layer of the surface, closer than the tolerance, counts as what
 * the splat ought to show. Areas decide, not the samples, of which a narrow splat has few: these
 * may all happen to lie across the border. Where layers lie on each other, or a border runs through
 * the middle, several have about as much, and that is the splat's over which its coordinates slide
 * least: the others are other splats' to show. Where they slide over most of each of these, but not
 * over a narrower one, which the splat leaves by no more than it may, it is of that. Where no splat
 * of its chart covers it, a sample is lost.
 *
 * A border may end, or run around a neck, so that both of its sides are one chart. What a splat
 * covers across such a border, over which it may reach by the tolerance, is other splats' to show,
 * as if it were of another chart; but only where one of them does.
 */
#include "measure/texture_slides.h"

#include "appearance/appearance.h"
#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/chart_borders.h"
#include "features/samples.h"
#include "features/surface.h"
#include "features/triangle_flood.h"
#include "measure/measured_splats.h"
#include "measure/region_cell.h"
#include "mesh/mesh.h"
#include "splats/splat_texcoord.h"
#include "splats/splats.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The least aspect ratio of what a triangle shows of the image, in texels on the triangle's plane,
 * with which it shows that in some sense. Chosen by hand. */
static const double least_aspect = 0.02;

/* The least cosine between the normals of a sample and of a splat's surface with which the splat
 * shows the sample's place: around a sharp rim, the splats of one side lie within the tolerance of
 * the other side too. Chosen by hand. */
static const double least_shown_cosine = 0.5;

/* The share of the area of the largest chart beneath a splat from which on another one may be its
 * own. Chosen by hand. */
static const double least_area_share = 0.25;

/* The share of its samples up to which a texture may slide over a splat's own chart; beyond, a
 * smaller chart with a smaller share is its own. Chosen by hand. */
static const double most_own_share = 0.5;

/* How far a splat may reach over the borders of such a smaller chart, in tolerances: by one
 * (crease_crossings.h), and at corners by the root of two. */
static const double most_overhang = 1.5;

/* A sample that a splat covers. */
typedef struct meeting {
    uint32_t splat, sample;
    float weight;         /* of the splat there, as a part of the kernel's greatest */
    float length, texels; /* of the slide; negative where the splat is of another chart */
    float way;            /* psplat_texcoord_way */
    uint8_t mirrored, seen;
    uint8_t is_beyond; /* 1 beyond a seam of the splat */
    uint8_t is_across; /* 1 where a border stands between the splat's own side and here */
    uint8_t is_right;  /* 1 where the texture slides by no more than the tolerance, of any chart */
} meeting;

typedef struct meeting_list {
    meeting *items;
    size_t count, capacity;
    int failed;
} meeting_list;

/* What all measurements share. */
typedef struct slides_context {
    const psplat_surface *surface;
    const psplat_samples *samples;
    const psplat_splats *splats;
    const psplat_measured_splats *measured;
    uint8_t *textured; /* of each splat: 1 where it has texture coordinates */
    uint8_t *shown;    /* of each sample: 1 where some splat shows what the surface has there */
} slides_context;

/* ---- meetings -------------------------------------------------------------------------------- */

/* A sample that looks for the splats that cover it. */
typedef struct probe {
    const slides_context *context;
    meeting_list *list; /* of this thread */
    size_t sample;
    double normal[3];
} probe;

static void push_meeting(meeting_list *list, const meeting *item) {
    if (list->count == list->capacity) {
        size_t capacity = 2 * list->capacity + 256;
        meeting *items = realloc(list->items, capacity * sizeof *items);
        if (!items) {
            list->failed = 1;
            return;
        }
        list->items = items;
        list->capacity = capacity;
    }
    list->items[list->count++] = *item;
}

/* Returns whether a splat faces about the way of a sample's normal. */
static int faces(const psplat_region *region, const double normal[3], const double uvh[3]) {
    double own[3];
    if (!psplat_region_is_curved(region)) return dot3(normal, region->n) >= least_shown_cosine;
    psplat_region_normal(region, uvh, own);
    return dot3(normal, own) >= least_shown_cosine * length3(own);
}

static int visit_splat(void *user, uint32_t index) {
    const probe *p = user;
    const slides_context *c = p->context;
    const psplat_kernel *kernel = &c->splats->kernel;
    const double *point = c->samples->positions + 3 * p->sample;
    double uvh[3];
    if (!c->textured[index] || !psplat_measured_splats_near(c->measured, index, point, 0)) return 0;
    psplat_region_local(&c->measured->regions[index], point, uvh);
    if (!psplat_measured_splats_cover(c->measured, index, p->normal, uvh)) return 0;
    if (!faces(&c->measured->regions[index], p->normal, uvh)) return 0;
    double falloff = pow(hypot(uvh[0], uvh[1]), (double)kernel->exponent);
    double weight = exp(-(double)kernel->sharpness * falloff);
    int is_beyond = psplat_region_is_beyond_seam(&c->measured->regions[index], uvh);
    const meeting item = {.splat = index,
                          .sample = (uint32_t)p->sample,
                          .weight = (float)(is_beyond ? PSPLAT_SEAM_WEIGHT * weight : weight),
                          .is_beyond = (uint8_t)is_beyond};
    push_meeting(p->list, &item);
    return 0;
}

/* The samples that a thread takes at once. */
enum { BLOCK_SAMPLES = 4096 };

static void find_block(const slides_context *c, size_t begin, size_t end, meeting_list *list) {
    for (size_t i = begin; i < end; ++i) {
        probe p = {.context = c, .list = list, .sample = i};
        if (!psplat_surface_keeps_textures(c->surface, c->samples->triangles[i])) continue;
        for (size_t k = 0; k < 3; ++k) p.normal[k] = (double)c->samples->normals[3 * i + k];
        psplat_region_tree_visit(c->measured->region_tree, c->samples->positions + 3 * i,
                                 visit_splat, &p);
    }
}

/* Puts the meetings of all blocks, which are in the order of samples, in that of splats. first gets
 * the index of the first meeting of each splat, and that behind the last. */
static void group_by_splat(const meeting_list *blocks, size_t block_count, size_t splats,
                           size_t *first, meeting_list *all) {
    for (size_t b = 0; b < block_count; ++b) {
        all->count += blocks[b].count;
        all->failed |= blocks[b].failed;
        for (size_t i = 0; i < blocks[b].count; ++i) ++first[blocks[b].items[i].splat + 2];
    }
    all->items = malloc((all->count + 1) * sizeof *all->items);
    all->failed |= !all->items;
    for (size_t i = 0; i < splats; ++i) first[i + 2] += first[i + 1];
    for (size_t b = 0; b < block_count && all->items; ++b)
        for (size_t i = 0; i < blocks[b].count; ++i)
            all->items[first[blocks[b].items[i].splat + 1]++] = blocks[b].items[i];
}

/* Finds all meetings, by splat and then by sample. first has room for two indices more than there
 * are splats, which are 0. */
static void find_meetings(const slides_context *c, size_t *first, meeting_list *all) {
    size_t samples = c->samples->count, block_count = samples / BLOCK_SAMPLES + 1;
    meeting_list *blocks = calloc(block_count, sizeof *blocks);
    long end = blocks ? (long)block_count : 0;
    all->failed = !blocks;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 1)
#endif
    for (long b = 0; b < end; ++b) {
        size_t begin = (size_t)b * BLOCK_SAMPLES, behind = begin + BLOCK_SAMPLES;
        find_block(c, begin, behind < samples ? behind : samples, &blocks[b]);
    }
    if (blocks) group_by_splat(blocks, block_count, c->splats->count, first, all);
    for (long b = 0; b < end; ++b) free(blocks[b].items);
    free(blocks);
}

/* ---- one splat ------------------------------------------------------------------------------- */

/* Returns the sense in which a triangle shows the image: 1, -1 or, where it is next to a line
 * there, 0. */
static int sense_of_triangle(const psplat_surface *surface, const psplat_kept_textures *kept,
                             uint32_t triangle) {
    const float *slopes = surface->texcoord_slopes + 6 * (size_t)triangle;
    double changes[2][3], c[3];
    for (int k = 0; k < 2; ++k)
        for (int i = 0; i < 3; ++i) changes[k][i] = (double)slopes[3 * k + i] * kept->texels[k];
    cross3(c, changes[0], changes[1]);
    double area = dot3(c, surface->face_normals + 3 * (size_t)triangle);
    double least = least_aspect * (dot3(changes[0], changes[0]) + dot3(changes[1], changes[1]));
    least = max2(least, PSPLAT_LEAST_CHART_TEXELS / surface->face_areas[triangle]);
    return (area > least) - (area < -least);
}

/* Returns the length of the way from a sample over its triangle to where that has what a splat
 * shows there; FLT_MAX where it has that nowhere, and where the triangle is thinner than the
 * tolerance and ends before: what lies beyond need not go on like it. */
static double way_over_triangle(const slides_context *c, uint32_t triangle, uint32_t sample,
                                const double texels[2], const double error[2]) {
    const psplat_mesh *mesh = c->surface->mesh;
    const float *slopes = c->surface->texcoord_slopes + 6 * (size_t)triangle;
    double way = psplat_texcoord_way(slopes, texels, error), s[2][3], g[3], end[3], longest = 0;
    if (!(way < (double)FLT_MAX)) return (double)FLT_MAX;
    for (int k = 0; k < 6; ++k) s[k / 3][k % 3] = (double)slopes[k];
    g[0] = dot3(s[0], s[0]), g[1] = dot3(s[0], s[1]), g[2] = dot3(s[1], s[1]);
    double det = g[0] * g[2] - g[1] * g[1];
    memcpy(end, c->samples->positions + 3 * (size_t)sample, sizeof end);
    mad3(end, (g[2] * error[0] - g[1] * error[1]) / det, s[0]);
    mad3(end, (g[0] * error[1] - g[1] * error[0]) / det, s[1]);
    int is_inside = 1;
    for (int k = 0; k < 3; ++k) {
        double along[3], inward[3], from[3];
        const double *a = psplat_mesh_corner(mesh, triangle, k);
        sub3(along, psplat_mesh_corner(mesh, triangle, (k + 1) % 3), a);
        cross3(inward, c->surface->face_normals + 3 * (size_t)triangle, along);
        sub3(from, end, a);
        is_inside &= dot3(from, inward) >= 0; /* and not NaN */
        longest = max2(longest, length3(along));
    }
    double height = 2 * c->surface->face_areas[triangle] / longest;
    return is_inside || height >= c->measured->tolerance ? way : (double)FLT_MAX;
}

/* Returns whether a material keeps a normal texture: the tangents of that turn over where the image
 * is mirrored, also where no texel is out of its place. */
static int keeps_normal_texture(const psplat_kept_textures *kept) {
    return kept->textures[PSPLAT_TEXTURE_NORMAL].image != 0;
}

/* Measures what a splat shows at a sample of its own chart. */
static void measure(const slides_context *c, meeting *m) {
    const psplat_texcoord *texcoord = &c->splats->texcoords[m->splat];
    const psplat_region *region = &c->measured->regions[m->splat];
    uint32_t triangle = c->samples->triangles[m->sample];
    const psplat_kept_textures *kept = psplat_surface_kept_textures(c->surface, triangle);
    double uvh[3], error[2], shown[2], given[2];
    psplat_region_local(region, c->samples->positions + 3 * (size_t)m->sample, uvh);
    psplat_texcoord_at(texcoord, uvh, shown);
    for (int k = 0; k < 2; ++k) {
        given[k] = (double)c->samples->texcoords[2 * (size_t)m->sample + (size_t)k];
        error[k] = shown[k] - given[k];
        if (kept->repeats[k]) error[k] -= kept->repeats[k] * rint(error[k] / kept->repeats[k]);
    }
    psplat_slide slide = psplat_texcoord_slide(texcoord, region, uvh, kept->texels, error);
    m->length = (float)slide.length, m->texels = (float)slide.texels;
    m->way = (float)way_over_triangle(c, triangle, m->sample, kept->texels, error);
    m->seen = !(slide.texels <= 0) &&
              !psplat_appearance_shows_same(c->surface->appearance, triangle, shown, given);
    m->is_right = (double)min2(m->length, m->way) <= c->measured->tolerance;
    m->mirrored =
        (slide.texels > PSPLAT_LEAST_SLIDE_TEXELS || keeps_normal_texture(kept)) &&
        psplat_texcoord_sense(texcoord, uvh) * sense_of_triangle(c->surface, kept, triangle) < 0;
}

/* A chart beneath a splat. */
typedef struct chart {
    uint32_t triangle; /* one of it */
    double area;       /* beneath the splat, in units of its parameters */
} chart;

/* What finds the chart of one splat, and memory of one thread. */
typedef struct chart_search {
    const slides_context *context;
    const psplat_region *region;
    psplat_region inside;        /* the part of the region inside its seams */
    psplat_cell cell;            /* about that part */
    psplat_triangle_flood all;   /* what is beneath the splat, of all charts */
    psplat_triangle_flood chart; /* one of these */
    chart *charts;               /* all that have an area, chart_count */
    size_t chart_count, chart_capacity;
    uint32_t *borders; /* edges that bound its own chart, border_count */
    size_t border_count, border_capacity;
    double own[2][2]; /* own_count (u, v) on the splat's own side of these */
    int own_count;
} chart_search;

static void free_search(chart_search *search) {
    psplat_triangle_flood_free(&search->all);
    psplat_triangle_flood_free(&search->chart);
    free(search->charts);
    free(search->borders);
}

/* Returns 0 when out of memory. */
static int push_chart(chart_search *search, uint32_t triangle, double area) {
    if (search->chart_count == search->chart_capacity) {
        size_t capacity = 2 * search->chart_capacity + 16;
        chart *charts = realloc(search->charts, capacity * sizeof *charts);
        if (!charts) return 0;
        search->charts = charts;
        search->chart_capacity = capacity;
    }
    search->charts[search->chart_count++] = (chart){triangle, area};
    return 1;
}

/* Returns the area of a cell, in units of the parameters. */
static double cell_area(const psplat_cell *cell) {
    double twice = 0;
    for (size_t i = 0, last = cell->count - 1; i < cell->count; last = i++)
        twice += cell->corners[last][0] * cell->corners[i][1] -
                 cell->corners[last][1] * cell->corners[i][0];
    return twice / 2;
}

/* Returns whether a splat shows a triangle at (u, v): it faces about the same way there, and the
 * triangle's plane is within the tolerance. */
static int shows_triangle(const chart_search *search, uint32_t triangle, const double uv[2]) {
    const psplat_surface *surface = search->context->surface;
    const double *normal = surface->face_normals + 3 * (size_t)triangle;
    double point[3], to[3], uvh[3], upward = dot3(normal, search->region->n);
    if (!(upward > 0)) return 0;
    psplat_region_point(search->region, uv, point);
    sub3(to, psplat_mesh_corner(surface->mesh, triangle, 0), point);
    mad3(point, dot3(to, normal) / upward, search->region->n);
    psplat_region_local(search->region, point, uvh);
    return fabs(uvh[2]) <= search->context->measured->tolerance &&
           faces(search->region, normal, uvh);
}

/* Returns the area, in units of the parameters, of what a splat shows of a triangle inside its
 * seams, and stores the middle of that. */
static double area_of_triangle(const chart_search *search, uint32_t triangle, double mean[2]) {
    psplat_cell part = search->cell;
    double corners[3][3];
    for (int k = 0; k < 3; ++k)
        psplat_region_local(search->region,
                            psplat_mesh_corner(search->context->surface->mesh, triangle, k),
                            corners[k]);
    for (int k = 0; k < 3 && part.count; ++k) {
        const double *a = corners[k], *b = corners[(k + 1) % 3];
        psplat_cell_clip(&part,
                         (const double[3]){a[1] - b[1], b[0] - a[0], a[0] * b[1] - b[0] * a[1]});
    }
    if (!part.count) return 0;
    psplat_cell_mean(&part, mean);
    return shows_triangle(search, triangle, mean) ? cell_area(&part) : 0;
}

/* Takes the triangles of the last chart out of those that are beneath. Returns their area. */
static double take_chart(chart_search *search) {
    double area = 0, mean[2];
    for (size_t i = 0; i < search->chart.triangle_count; ++i) {
        area += area_of_triangle(search, search->chart.triangles[i], mean);
        psplat_triangle_flood_forget(&search->all, search->chart.triangles[i]);
    }
    return area;
}

/* Floods the chart beneath a splat from a triangle. Returns 0 when out of memory. */
static int flood_chart(chart_search *search, uint32_t triangle) {
    return psplat_triangle_flood_beneath(&search->chart, search->context->surface, search->region,
                                         search->context->measured->tolerance, triangle);
}

/* Floods all that is beneath a splat, of all charts, from its samples. Returns 0 when out of
 * memory. */
static int flood_all(chart_search *search, const meeting *meetings, size_t count) {
    const slides_context *c = search->context;
    search->region = &c->measured->regions[meetings[0].splat];
    search->inside = psplat_region_inside_seams(search->region);
    search->cell = psplat_cell_of_disc();
    psplat_cell_clip_by_rim(&search->inside, &search->cell);
    if (!psplat_triangle_flood_begin(&search->all, c->surface)) return 0;
    for (size_t i = 0; i < count; ++i)
        psplat_triangle_flood_add_beneath(&search->all, c->surface, search->region,
                                          c->measured->tolerance,
                                          c->samples->triangles[meetings[i].sample]);
    return 1;
}

/* Finds the charts that have an area beneath a splat. Returns 0 when out of memory. */
static int find_charts(chart_search *search, const meeting *meetings, size_t count) {
    search->chart_count = 0;
    if (!flood_all(search, meetings, count)) return 0;
    for (size_t i = 0; i < search->all.triangle_count; ++i) {
        uint32_t triangle = search->all.triangles[i];
        if (!psplat_triangle_flood_met(&search->all, triangle)) continue; /* It is of a chart. */
        if (!flood_chart(search, triangle)) return 0;
        double area = take_chart(search);
        if (area > 0 && !push_chart(search, triangle, area)) return 0;
    }
    return 1;
}

/* Returns the share of the meetings on the chart that was flooded last at which one sees that the
 * texture slides by more than the tolerance; 1 where there is none. */
static double share_that_slides(const chart_search *search, const meeting *meetings, size_t count) {
    const slides_context *c = search->context;
    size_t on_chart = 0, slides = 0;
    for (size_t i = 0; i < count; ++i) {
        meeting m = meetings[i];
        if (!psplat_triangle_flood_met(&search->chart, c->samples->triangles[m.sample])) continue;
        measure(c, &m);
        ++on_chart;
        slides += m.seen && (double)min2(m.length, m.way) > c->measured->tolerance;
    }
    return on_chart ? (double)slides / (double)on_chart : 1;
}

/* A chart that may be a splat's own. */
typedef struct own_chart {
    uint32_t triangle; /* one of it; PSPLAT_NONE: there is none */
    double area;       /* beneath the splat, in units of its parameters */
    double share;      /* of its samples at which the texture slides too far; 0 where there is no
                          other chart */
} own_chart;

/* Stores a point's place in the plane of a splat, in units of length. */
static void put_in_plane(const psplat_region *region, const double point[3], double flat[3]) {
    double d[3];
    sub3(d, point, region->center);
    flat[0] = dot3(d, region->u), flat[1] = dot3(d, region->v), flat[2] = 0;
}

/* Returns whether a sample lies farther from the chart that was flooded last than a splat reaches
 * over borders, in the plane of the splat. */
static int is_far_from_chart(const chart_search *search, const meeting *m) {
    const slides_context *c = search->context;
    double most = most_overhang * c->measured->tolerance, flat[3], corners[3][3];
    put_in_plane(search->region, c->samples->positions + 3 * (size_t)m->sample, flat);
    for (size_t i = 0; i < search->chart.triangle_count; ++i) {
        for (int k = 0; k < 3; ++k)
            put_in_plane(search->region,
                         psplat_mesh_corner(c->surface->mesh, search->chart.triangles[i], k),
                         corners[k]);
        if (point_triangle_distance2(flat, corners[0], corners[1], corners[2]) <= most * most)
            return 0;
    }
    return 1;
}

/* Returns whether a splat reaches over the borders of the chart that was flooded last by no more
 * than it may, inside its seams. */
static int keeps_to_chart(const chart_search *search, const meeting *meetings, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (!meetings[i].is_beyond &&
            !psplat_triangle_flood_met(&search->chart,
                                       search->context->samples->triangles[meetings[i].sample]) &&
            is_far_from_chart(search, &meetings[i]))
            return 0;
    return 1;
}

/* Finds the chart over which a splat's coordinates slide at the least share of samples, the largest
 * of equals: of the large ones, or of the small ones that may be its own. Returns 0 when out of
 * memory. */
static int find_least_sliding(chart_search *search, const meeting *meetings, size_t count,
                              int small, own_chart *found) {
    double most = 0;
    *found = (own_chart){PSPLAT_NONE, 0, HUGE_VAL};
    for (size_t i = 0; i < search->chart_count; ++i) most = max2(most, search->charts[i].area);
    for (size_t i = 0; i < search->chart_count; ++i) {
        const chart *tried = &search->charts[i];
        double share = 0;
        if ((tried->area < least_area_share * most) != small) continue;
        if (search->chart_count > 1 && !flood_chart(search, tried->triangle)) return 0;
        if (search->chart_count > 1) share = share_that_slides(search, meetings, count);
        if (share > found->share || (share == found->share && tried->area <= found->area) ||
            (small && (share >= most_own_share || !keeps_to_chart(search, meetings, count))))
            continue;
        *found = (own_chart){tried->triangle, tried->area, share};
    }
    return 1;
}

/* Finds a triangle of the chart that is a splat's own: PSPLAT_NONE where none has an area beneath
 * it. One of the large ones is, but a small one where the texture slides over most of these, and
 * not over most of that: a splat of a narrow strip reaches over its borders by the tolerance, and
 * has more of what lies there beneath it than of the strip. Returns 0 when out of memory. */
static int find_own_chart(chart_search *search, const meeting *meetings, size_t count,
                          uint32_t *own) {
    own_chart large, small = {PSPLAT_NONE, 0, HUGE_VAL};
    if (!find_charts(search, meetings, count) ||
        !find_least_sliding(search, meetings, count, 0, &large) ||
        (large.share > most_own_share && !find_least_sliding(search, meetings, count, 1, &small)))
        return 0;
    *own = small.triangle != PSPLAT_NONE ? small.triangle : large.triangle;
    return 1;
}

/* ---- borders that a chart goes around -------------------------------------------------------- */

/* Lists the borders of the chart that was flooded last which the splat faces. Returns 0 when out of
 * memory. */
static int find_borders(chart_search *search) {
    const psplat_surface *surface = search->context->surface;
    search->border_count = 0;
    for (size_t i = 0; i < search->chart.triangle_count; ++i) {
        uint32_t triangle = search->chart.triangles[i];
        if (!(dot3(surface->face_normals + 3 * (size_t)triangle, search->region->n) > 0)) continue;
        for (uint32_t edge = 3 * triangle; edge < 3 * triangle + 3; ++edge) {
            if (!(surface->creases[edge] & (PSPLAT_BOUND_CREASE | PSPLAT_BOUND_CHART)) ||
                surface->neighbors[edge] == PSPLAT_NONE)
                continue;
            if (search->border_count == search->border_capacity) {
                size_t capacity = 2 * search->border_capacity + 64;
                uint32_t *borders = realloc(search->borders, capacity * sizeof *borders);
                if (!borders) return 0;
                search->borders = borders;
                search->border_capacity = capacity;
            }
            search->borders[search->border_count++] = edge;
        }
    }
    return 1;
}

static void find_uv(const chart_search *search, const meeting *m, double uvh[3]) {
    psplat_region_local(search->region, search->context->samples->positions + 3 * (size_t)m->sample,
                        uvh);
}

/* Finds what is on a splat's own side: the middle of what it shows of its own chart, and the
 * heaviest of its meetings at which the texture stays in its place, since splats beside a border
 * may be narrower than they reach over it. */
static void find_own_side(chart_search *search, const meeting *meetings, size_t count) {
    const meeting *heaviest = NULL;
    double area = 0, sum[2] = {0, 0}, mean[2], uvh[3];
    search->own_count = 0;
    for (size_t i = 0; i < search->chart.triangle_count; ++i) {
        double part = area_of_triangle(search, search->chart.triangles[i], mean);
        area += part;
        for (int k = 0; k < 2 && part > 0; ++k) sum[k] += part * mean[k];
    }
    if (area > 0) {
        for (int k = 0; k < 2; ++k) search->own[search->own_count][k] = sum[k] / area;
        ++search->own_count;
    }
    for (size_t i = 0; i < count; ++i) {
        const meeting *m = &meetings[i];
        if (m->length >= 0 && m->is_right && (!heaviest || m->weight > heaviest->weight))
            heaviest = m;
    }
    if (!heaviest) return;
    find_uv(search, heaviest, uvh);
    memcpy(search->own[search->own_count++], uvh, sizeof search->own[0]);
}

/* Returns whether a border within the tolerance of a sample, of which the splat's (u, v) are given,
 * stands between that and the splat's own side. */
static int is_across_border(const chart_search *search, const double point[3], const double uv[2]) {
    const psplat_mesh *mesh = search->context->surface->mesh;
    double tolerance = search->context->measured->tolerance;
    for (size_t i = 0; i < search->border_count; ++i) {
        uint32_t triangle = search->borders[i] / 3;
        int k = (int)(search->borders[i] % 3);
        const double *a = psplat_mesh_corner(mesh, triangle, k);
        const double *b = psplat_mesh_corner(mesh, triangle, (k + 1) % 3);
        double from[3], to[3];
        if (point_segment_distance2(point, a, b) > tolerance * tolerance) continue;
        psplat_region_local(search->region, a, from);
        psplat_region_local(search->region, b, to);
        for (int side = 0; side < search->own_count; ++side)
            if (segments_cross2(search->own[side], uv, from, to)) return 1;
    }
    return 0;
}

/* Finds which of the measured meetings at which the texture slides too far are across a border.
 * Returns 0 when out of memory. */
static int find_across(chart_search *search, meeting *meetings, size_t count) {
    size_t too_far = 0;
    for (size_t i = 0; i < count; ++i) too_far += meetings[i].length >= 0 && !meetings[i].is_right;
    if (!too_far) return 1;
    if (!find_borders(search)) return 0;
    if (!search->border_count) return 1;
    find_own_side(search, meetings, count);
    for (size_t i = 0; i < count; ++i) {
        meeting *m = &meetings[i];
        double uvh[3];
        if (m->length < 0 || m->is_right) continue;
        find_uv(search, m, uvh);
        m->is_across = (uint8_t)is_across_border(
            search, search->context->samples->positions + 3 * (size_t)m->sample, uvh);
    }
    return 1;
}

/* Stores whether a splat that is not of a sample's chart shows other texels than the surface has
 * there. */
static void measure_foreign(const slides_context *c, const psplat_kept_textures *own, meeting *m) {
    uint32_t triangle = c->samples->triangles[m->sample];
    meeting as_own = *m;
    m->length = m->texels = -1;
    m->seen = 1;
    if (own != psplat_surface_kept_textures(c->surface, triangle)) return;
    measure(c, &as_own);
    m->seen = as_own.seen;
    m->is_right = as_own.is_right;
}

/* Measures the meetings of a splat. Lengths of those that do not belong to its own chart become
 * negative. Returns 0 when out of memory. */
static int measure_splat(chart_search *search, meeting *meetings, size_t count) {
    const slides_context *c = search->context;
    uint32_t own;
    if (!find_own_chart(search, meetings, count, &own)) return 0;
    if (own != PSPLAT_NONE && !flood_chart(search, own)) return 0;
    const psplat_kept_textures *kept =
        own != PSPLAT_NONE ? psplat_surface_kept_textures(c->surface, own) : NULL;
    for (size_t i = 0; i < count; ++i) {
        uint32_t triangle = c->samples->triangles[meetings[i].sample];
        if (own != PSPLAT_NONE && psplat_triangle_flood_met(&search->chart, triangle))
            measure(c, &meetings[i]);
        else
            measure_foreign(c, kept, &meetings[i]);
    }
    return find_across(search, meetings, count);
}

/* Measures all splats. first has the index of the first meeting of each of count splats, and that
 * behind the last. Returns 0 when out of memory. */
static int measure_splats(const slides_context *c, meeting *meetings, const size_t *first,
                          long count) {
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel reduction(| : failed)
#endif
    {
        chart_search search = {.context = c};
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, 16)
#endif
        for (long i = 0; i < count; ++i)
            if (first[i + 1] > first[i])
                failed |= !measure_splat(&search, meetings + first[i], first[i + 1] - first[i]);
        free_search(&search);
    }
    return !failed;
}

/* ---- all samples ----------------------------------------------------------------------------- */

/* Returns whether meeting i weighs more than another one; `other` is SIZE_MAX where there is none.
 */
static int weighs_more(const meeting_list *list, size_t i, size_t other) {
    return other == SIZE_MAX || list->items[i].weight > list->items[other].weight;
}

/* Finds the samples at which some splat shows what the surface has there. Beyond its seams a splat
 * shows next to nothing. */
static void find_shown(const slides_context *c, const meeting_list *list) {
    for (size_t i = 0; i < list->count; ++i) {
        const meeting *m = &list->items[i];
        c->shown[m->sample] |= m->is_right && !m->is_beyond;
    }
}

/* Finds the heaviest meeting of each sample, of all (0) and of those with splats of its chart (1).
 * What is across a border counts only where no splat shows what is there. */
static void find_heaviest(const slides_context *c, const meeting_list *list, size_t *heaviest[2]) {
    for (size_t i = 0; i < c->samples->count; ++i) heaviest[0][i] = heaviest[1][i] = SIZE_MAX;
    for (size_t i = 0; i < list->count; ++i) {
        const meeting *m = &list->items[i];
        int is_own = m->length >= 0 && !(m->is_across && c->shown[m->sample]);
        for (int own = 0; own <= is_own; ++own)
            if (weighs_more(list, i, heaviest[own][m->sample])) heaviest[own][m->sample] = i;
    }
}

/* Sums the meetings up by sample. heaviest has room for two indices for each sample. */
static void sum_up(const slides_context *c, const meeting_list *list, size_t *heaviest,
                   psplat_texture_slides *slides) {
    size_t samples = c->samples->count, *of[2] = {heaviest, heaviest + samples};
    double covered = 0, mirrored = 0, foreign = 0;
    find_shown(c, list);
    find_heaviest(c, list, of);
    for (size_t i = 0; i < samples; ++i) {
        slides->lengths[i] = of[1][i] == SIZE_MAX ? -1 : (double)list->items[of[1][i]].length;
        slides->texels[i] = of[1][i] == SIZE_MAX ? -1 : (double)list->items[of[1][i]].texels;
        slides->ways[i] = of[1][i] == SIZE_MAX ? -1 : (double)list->items[of[1][i]].way;
        slides->splats[i] = of[1][i] == SIZE_MAX ? PSPLAT_NONE : list->items[of[1][i]].splat;
        slides->seen[i] = of[1][i] != SIZE_MAX && list->items[of[1][i]].seen;
        slides->lost[i] = 0;
        if (of[0][i] == SIZE_MAX) continue;
        const meeting *m = &list->items[of[0][i]];
        slides->lost[i] = of[1][i] == SIZE_MAX && m->seen;
        ++covered;
        mirrored += m->mirrored && of[0][i] == of[1][i];
        foreign += of[0][i] != of[1][i];
    }
    slides->mirrored = covered > 0 ? mirrored / covered : 0;
    slides->foreign = covered > 0 ? foreign / covered : 0;
}

/* Stores whether a sample lies within the tolerance of a border of its chart. Returns 0 when out of
 * memory. */
static int find_near_border(const slides_context *c, size_t sample, psplat_triangle_flood *flood,
                            int *is_near) {
    const psplat_surface *surface = c->surface;
    const double *point = c->samples->positions + 3 * sample, tolerance = c->measured->tolerance;
    psplat_region around = {.radius = {0, 0}};
    memcpy(around.center, point, sizeof around.center);
    *is_near = 0;
    if (!psplat_triangle_flood_around(flood, surface, &around, tolerance,
                                      c->samples->triangles[sample]))
        return 0;
    for (size_t i = 0; i < flood->triangle_count && !*is_near; ++i)
        for (int k = 0; k < 3 && !*is_near; ++k) {
            uint32_t triangle = flood->triangles[i];
            if (!(surface->creases[3 * (size_t)triangle + (size_t)k] &
                  (PSPLAT_BOUND_CREASE | PSPLAT_BOUND_CHART)))
                continue;
            *is_near =
                point_segment_distance2(point, psplat_mesh_corner(surface->mesh, triangle, k),
                                        psplat_mesh_corner(surface->mesh, triangle, (k + 1) % 3)) <=
                tolerance * tolerance;
        }
    return 1;
}

/* Samples beside borders are not lost: splats may reach over these by the tolerance. Returns 0 when
 * out of memory. */
static int spare_borders(const slides_context *c, psplat_texture_slides *slides) {
    psplat_triangle_flood flood = {0};
    int ok = 1, is_near;
    for (size_t i = 0; i < c->samples->count && ok; ++i) {
        if (!slides->lost[i]) continue;
        ok = find_near_border(c, i, &flood, &is_near);
        slides->lost[i] = !is_near;
    }
    psplat_triangle_flood_free(&flood);
    return ok;
}

/* Marks the splats that have texture coordinates. */
static void mark_textured(const psplat_splats *splats, uint8_t *textured) {
    for (size_t run = 0, i = 0; run < splats->run_count; ++run)
        for (size_t end = i + splats->runs[run].count; i < end; ++i)
            textured[i] = splats->texcoords && splats->runs[run].has_texcoord;
}

psplat_result psplat_texture_slides_find(const psplat_surface *surface,
                                         const psplat_samples *samples, const psplat_splats *splats,
                                         const psplat_measured_splats *measured,
                                         psplat_texture_slides *slides) {
    slides_context c = {.surface = surface,
                        .samples = samples,
                        .splats = splats,
                        .measured = measured,
                        .textured = calloc(splats->count + 1, 1),
                        .shown = calloc(samples->count + 1, 1)};
    meeting_list list = {.items = NULL};
    size_t *first = calloc(splats->count + 2, sizeof *first);
    size_t *heaviest = malloc((2 * samples->count + 1) * sizeof *heaviest);
    *slides =
        (psplat_texture_slides){.lengths = malloc((samples->count + 1) * sizeof *slides->lengths),
                                .texels = malloc((samples->count + 1) * sizeof *slides->texels),
                                .ways = malloc((samples->count + 1) * sizeof *slides->ways),
                                .splats = malloc((samples->count + 1) * sizeof *slides->splats),
                                .seen = malloc(samples->count + 1),
                                .lost = malloc(samples->count + 1)};
    int ok = c.textured && c.shown && first && heaviest && slides->lengths && slides->texels &&
             slides->ways && slides->splats && slides->seen && slides->lost;
    if (ok) {
        mark_textured(splats, c.textured);
        find_meetings(&c, first, &list);
        ok = !list.failed && measure_splats(&c, list.items, first, (long)splats->count);
    }
    if (ok) sum_up(&c, &list, heaviest, slides);
    if (ok) ok = spare_borders(&c, slides);
    free(c.textured);
    free(c.shown);
    free(first);
    free(heaviest);
    free(list.items);
    return ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

void psplat_texture_slides_free(psplat_texture_slides *slides) {
    free(slides->lengths);
    free(slides->texels);
    free(slides->ways);
    free(slides->splats);
    free(slides->seen);
    free(slides->lost);
    *slides = (psplat_texture_slides){0};
}

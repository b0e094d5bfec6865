/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region_cell.c - convex polygons of a region's parameters, and how its rim cuts them: by tangents
 * and chords, so that they exceed the region by the second order of their size only.
 */
#include "measure/region_cell.h"

#include "base/vector.h"

#include <math.h>
#include <string.h>

enum { DISC_SIDES = 16 };

/* What lies beyond the rim by less, in units of the parameters, is not cut off. */
#define RIM_SLACK 1e-12

/* Sides that are shorter do not tell on which side of them anything lies: where cuts leave a corner
 * twice, rounding turns the side between. */
static const double least_edge = 1e-6;

psplat_cell psplat_cell_of_disc(void) {
    /* Cosines of 0, 1/8, 2/8, 3/8 and 4/8 of pi, enlarged so that the sides touch the disc. */
    static const double far = 1.0195911582083184 * (1 + RIM_SLACK);
    const double c[DISC_SIDES / 4 + 1] = {far, far * 0.9238795325112867, far * 0.7071067811865476,
                                          far * 0.3826834323650898, 0};
    psplat_cell cell;
    cell.count = DISC_SIDES;
    for (size_t i = 0; i < DISC_SIDES / 4; ++i) {
        const double u = c[i], v = c[DISC_SIDES / 4 - i];
        const double turns[4][2] = {{u, v}, {-v, u}, {-u, -v}, {v, -u}};
        for (size_t k = 0; k < 4; ++k)
            memcpy(cell.corners[i + k * DISC_SIDES / 4], turns[k], sizeof turns[k]);
    }
    return cell;
}

static double value_at(const double line[3], const double uv[2]) {
    return line[0] * uv[0] + line[1] * uv[1] + line[2];
}

void psplat_cell_clip(psplat_cell *cell, const double line[3]) {
    double values[PSPLAT_CELL_CORNERS], kept[PSPLAT_CELL_CORNERS][2];
    size_t count = 0, inside = 0;
    for (size_t i = 0; i < cell->count; ++i) {
        values[i] = value_at(line, cell->corners[i]);
        inside += values[i] >= 0;
    }
    if (inside == cell->count) return;
    for (size_t i = 0, last = cell->count - 1; i < cell->count && inside; last = i++) {
        const double *from = cell->corners[last], *to = cell->corners[i];
        if ((values[last] >= 0) != (values[i] >= 0) && count < PSPLAT_CELL_CORNERS) {
            double t = values[last] / (values[last] - values[i]);
            for (int k = 0; k < 2; ++k) kept[count][k] = from[k] + t * (to[k] - from[k]);
            ++count;
        }
        if (values[i] >= 0 && count < PSPLAT_CELL_CORNERS)
            memcpy(kept[count++], to, sizeof kept[0]);
    }
    memcpy(cell->corners, kept, count * sizeof kept[0]);
    cell->count = count;
}

void psplat_cell_box(const psplat_cell *cell, double low[2], double high[2]) {
    for (int k = 0; k < 2; ++k) low[k] = HUGE_VAL, high[k] = -HUGE_VAL;
    for (size_t i = 0; i < cell->count; ++i)
        for (int k = 0; k < 2; ++k) {
            low[k] = min2(low[k], cell->corners[i][k]);
            high[k] = max2(high[k], cell->corners[i][k]);
        }
}

/* Replaces a cell that has little room for more corners by the box around it. */
static void make_room(psplat_cell *c) {
    double low[2], high[2];
    if (c->count + 2 + PSPLAT_MAX_CLIP_LINES < PSPLAT_CELL_CORNERS) return;
    psplat_cell_box(c, low, high);
    const double box[4][2] = {
        {low[0], low[1]}, {high[0], low[1]}, {high[0], high[1]}, {low[0], high[1]}};
    memcpy(c->corners, box, sizeof box);
    c->count = 4;
}

void psplat_cell_mean(const psplat_cell *cell, double mean[2]) {
    mean[0] = mean[1] = 0;
    for (size_t i = 0; i < cell->count; ++i)
        for (int k = 0; k < 2; ++k) mean[k] += cell->corners[i][k];
    for (int k = 0; k < 2; ++k) mean[k] /= (double)cell->count;
}

/* Cuts a cell that reaches over the unit circle by the circle's tangent in its direction. */
static void clip_by_circle(psplat_cell *c) {
    double mean[2], farthest2 = 0;
    for (size_t i = 0; i < c->count; ++i) {
        const double *uv = c->corners[i];
        farthest2 = max2(farthest2, uv[0] * uv[0] + uv[1] * uv[1]);
    }
    if (farthest2 <= 1 + RIM_SLACK) return;
    psplat_cell_mean(c, mean);
    double length = sqrt(mean[0] * mean[0] + mean[1] * mean[1]);
    if (!(length > 0.25)) return; /* No tangent cuts much off. */
    psplat_cell_clip(c, (const double[3]){-mean[0] / length, -mean[1] / length, 1});
}

/* Stores the straight line that keeps what bent line i keeps of a cell. A line that bulges out is
 * concave, and keeps less than any tangent. One that bulges in keeps less than its chord, as far as
 * that reaches along it. */
static void straighten(const psplat_region *region, uint32_t i, const psplat_cell *c,
                       double straight[3]) {
    const double *line = region->lines[i];
    double length2 = line[0] * line[0] + line[1] * line[1], bend = region->bends[i] * length2 / 2;
    double low = HUGE_VAL, high = -HUGE_VAL, length = sqrt(length2);
    for (size_t k = 0; k < c->count; ++k) {
        double place = (line[0] * c->corners[k][1] - line[1] * c->corners[k][0]) / length;
        low = min2(low, place);
        high = max2(high, place);
    }
    /* The line's value is its straight part and bend m^2 with m the place. m^2 is at most
     * (low + high) m - low high between low and high, and at least 2 n m - n^2 for any n. */
    double first = low + high, last = -low * high;
    if (bend < 0) last = -0.25 * first * first;
    straight[0] = line[0] - bend * first * line[1] / length;
    straight[1] = line[1] + bend * first * line[0] / length;
    straight[2] = line[2] + bend * last;
}

void psplat_cell_clip_by_rim(const psplat_region *region, psplat_cell *cell) {
    make_room(cell);
    clip_by_circle(cell);
    for (uint32_t i = 0; i < region->line_count && cell->count; ++i) {
        double least = HUGE_VAL, line[3];
        for (size_t k = 0; k < cell->count; ++k)
            least = min2(least, psplat_region_line_value(region, i, cell->corners[k]));
        if (least >= -RIM_SLACK) continue;
        memcpy(line, region->lines[i], sizeof line);
        if (region->bends[i] != 0) straighten(region, i, cell, line);
        psplat_cell_clip(cell, line);
    }
}

int psplat_cell_holds_segment(const psplat_cell *cell, const double a[2], const double b[2],
                              double slack) {
    double begin = 0, end = 1;
    for (size_t i = 0; i < cell->count && begin < end; ++i) {
        const double *c = cell->corners[i], *d = cell->corners[(i + 1) % cell->count];
        double u = d[0] - c[0], v = d[1] - c[1], length = sqrt(u * u + v * v);
        if (length < least_edge) continue;
        double from = u * (a[1] - c[1]) - v * (a[0] - c[0]) - slack * length;
        double to = u * (b[1] - c[1]) - v * (b[0] - c[0]) - slack * length;
        if (from < 0 && to < 0) return 0;
        if (from < 0) begin = max2(begin, from / (from - to));
        if (to < 0) end = min2(end, from / (from - to));
    }
    return begin < end;
}

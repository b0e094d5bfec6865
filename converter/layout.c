/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * layout.c - where the attributes of splats lie in a file.
 *
 * Attributes lie interleaved, a row for each splat, and all primitives of equal rows share a view:
 * JSON is the larger part of a small file. For the same reason primitives of few clip lines are
 * padded with lines that cut nothing off and join those of more, where that takes fewer bytes.
 */
#include "layout.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* About what JSON takes for a primitive and for each of its attributes. */
enum { PRIMITIVE_BYTES = 260, ATTRIBUTE_BYTES = 130 };

enum { CLASSES = PSPLAT_MAX_CLIP_LINES + 1 };

/* ---- primitives ----------------------------------------------------------------------------- */

/* Splats of one material and depth tolerance, whichever runs they are in. */
typedef struct family {
    uint32_t material;
    float depth_tolerance;
    size_t first[CLASSES], count[CLASSES]; /* by clip lines */
} family;

static size_t find_families(const psplat_splats *splats, family *families) {
    size_t count = 0, first = 0;
    for (size_t i = 0; i < splats->run_count; ++i) {
        const psplat_run *run = &splats->runs[i];
        size_t f = 0;
        while (f < count && (families[f].material != run->material ||
                             families[f].depth_tolerance != run->depth_tolerance ||
                             families[f].count[run->clip_lines]))
            ++f;
        if (f == count)
            families[count++] =
                (family){.material = run->material, .depth_tolerance = run->depth_tolerance};
        families[f].first[run->clip_lines] = first;
        families[f].count[run->clip_lines] = run->count;
        first += run->count;
    }
    return count;
}

/* What it costs to write classes from ... to as one primitive. */
static double cost_of(const family *f, size_t from, size_t to, size_t line_bytes, double padding) {
    double cost = 0;
    int any = 0;
    for (size_t k = from; k <= to; ++k) {
        size_t lines = f->count[k] * (to - k);
        if (lines) cost += padding * (double)(lines * line_bytes);
        any |= f->count[k] > 0;
    }
    return any ? cost + PRIMITIVE_BYTES + (double)(6 + to) * ATTRIBUTE_BYTES : 0;
}

/* The cheapest way to cut the classes: a bit for each class that is the last of its primitive. */
static unsigned cheapest_cut(const family *f, size_t line_bytes, double padding) {
    unsigned best = (1u << CLASSES) - 1;
    double least = HUGE_VAL;
    for (unsigned cut = 1u << (CLASSES - 1); cut < 1u << CLASSES; ++cut) {
        double cost = 0;
        for (size_t k = 0, from = 0; k < CLASSES; ++k) {
            if (!(cut >> k & 1)) continue;
            size_t to = k;
            while (to > from && !f->count[to]) --to;
            cost += cost_of(f, from, to, line_bytes, padding);
            from = k + 1;
        }
        if (cost < least) least = cost, best = cut;
    }
    return best;
}

/* The columns that the splats of a part need together. */
static void set_columns(const psplat_sheet *sheet, psplat_part *part) {
    for (size_t class = 0; class < CLASSES; ++class) {
        psplat_column columns[PSPLAT_COLUMNS];
        psplat_sheet_columns(sheet, part->first[class], part->counts[class], part->clip_lines,
                             columns);
        for (size_t k = 0; k < PSPLAT_COLUMNS; ++k) {
            size_t components = part->columns[k].components;
            part->columns[k] = columns[k];
            if (components > columns[k].components) part->columns[k].components = components;
        }
    }
}

static void add_parts(psplat_layout *layout, size_t mesh, const family *f, unsigned cut) {
    psplat_part part = {
        .mesh = mesh, .material = f->material, .depth_tolerance = f->depth_tolerance};
    for (size_t class = 0; class < CLASSES; ++class) {
        part.first[class] = f->first[class];
        part.counts[class] = f->count[class];
        part.count += f->count[class];
        if (f->count[class]) part.clip_lines = class;
        if (!(cut >> class & 1) || !part.count) continue;
        set_columns(&layout->sheets[mesh], &part);
        layout->parts[layout->part_count++] = part;
        part = (psplat_part){
            .mesh = mesh, .material = f->material, .depth_tolerance = f->depth_tolerance};
    }
}

/* By clip lines, unclipped first (BSK04 section 4.1); equal ones stay in order. */
static void sort_parts(psplat_part *parts, size_t count) {
    for (size_t i = 1; i < count; ++i)
        for (size_t k = i; k > 0 && parts[k - 1].clip_lines > parts[k].clip_lines; --k) {
            psplat_part other = parts[k];
            parts[k] = parts[k - 1];
            parts[k - 1] = other;
        }
}

static int make_parts(psplat_layout *layout, size_t mesh, double padding) {
    const psplat_sheet *sheet = &layout->sheets[mesh];
    family *families = malloc((sheet->splats->run_count + 1) * sizeof *families);
    size_t first = layout->part_count;
    if (!families) return 0;
    size_t count = find_families(sheet->splats, families);
    size_t line_bytes = psplat_column_bytes(&sheet->columns[PSPLAT_COLUMN_LINE]);
    for (size_t i = 0; i < count; ++i)
        add_parts(layout, mesh, &families[i], cheapest_cut(&families[i], line_bytes, padding));
    sort_parts(layout->parts + first, layout->part_count - first);
    free(families);
    return 1;
}

/* ---- views ---------------------------------------------------------------------------------- */

/* Rows at the end of the view of such rows, which may be new. NULL where memory ran out. */
static uint8_t *add_rows(psplat_layout *layout, size_t stride, int is_octahedral, size_t rows,
                         psplat_place_in_view *place) {
    size_t i = 0;
    while (i < layout->view_count &&
           (layout->views[i].stride != stride || layout->views[i].is_octahedral != is_octahedral))
        ++i;
    psplat_file_view *view = &layout->views[i];
    if (i == layout->view_count) {
        *view = (psplat_file_view){.stride = stride, .is_octahedral = is_octahedral};
        layout->view_count++;
    }
    if (view->rows + rows > view->capacity) {
        size_t capacity = 2 * view->rows + rows;
        uint8_t *bytes = realloc(view->bytes, capacity * stride);
        if (!bytes) return NULL;
        view->bytes = bytes;
        view->capacity = capacity;
    }
    *place = (psplat_place_in_view){i, view->rows * stride};
    view->rows += rows;
    uint8_t *start = view->bytes + place->offset;
    memset(start, 0, rows * stride);
    return start;
}

/* Writes a column of a part, its elements stride apart. */
static void put_column(const psplat_layout *layout, const psplat_part *part, size_t kind,
                       int is_octahedral, uint8_t *out, size_t stride) {
    const psplat_sheet *sheet = &layout->sheets[part->mesh];
    for (size_t class = 0; class < CLASSES; ++class)
        for (size_t i = 0; i < part->counts[class]; ++i, out += stride)
            if (is_octahedral)
                psplat_sheet_put_octahedral(sheet, part->first[class] + i, out);
            else
                psplat_sheet_put(sheet, kind, &part->columns[kind], part->first[class] + i, out);
}

static int is_line(size_t kind) {
    return kind >= PSPLAT_COLUMN_LINE && kind < PSPLAT_COLUMN_COLOR_U;
}

static int is_apart(const psplat_layout_plan *plan, const psplat_sheet *sheet, size_t kind) {
    return (plan->lines_apart && is_line(kind)) ||
           (plan->normals_apart && sheet->codes && kind == PSPLAT_COLUMN_NORMAL);
}

/* A column in a view of its own. */
static int add_column(psplat_layout *layout, psplat_part *part, size_t kind) {
    int is_octahedral = !is_line(kind);
    size_t stride = psplat_column_bytes(&layout->sheets[part->mesh].columns[kind]);
    uint8_t *out = add_rows(layout, stride, is_octahedral, part->count, &part->places[kind]);
    if (out) put_column(layout, part, kind, is_octahedral, out, stride);
    return out != NULL;
}

/* Offsets of columns in rows that have room for all parts from first to last; returns a row's
 * bytes. */
static size_t row_of(const psplat_layout_plan *plan, const psplat_layout *layout, size_t first,
                     size_t last, size_t offsets[PSPLAT_COLUMNS]) {
    const psplat_sheet *sheet = &layout->sheets[layout->parts[first].mesh];
    size_t bytes = 0;
    for (size_t kind = 0; kind < PSPLAT_COLUMNS; ++kind) {
        psplat_column column = sheet->columns[kind];
        column.components = 0;
        for (size_t i = first; i <= last; ++i)
            if (layout->parts[i].columns[kind].components > column.components)
                column.components = layout->parts[i].columns[kind].components;
        offsets[kind] = bytes;
        if (!is_apart(plan, sheet, kind)) bytes += psplat_column_bytes(&column);
    }
    return bytes;
}

static int add_part(const psplat_layout_plan *plan, psplat_layout *layout, psplat_part *part,
                    size_t stride, const size_t offsets[PSPLAT_COLUMNS]) {
    psplat_place_in_view place;
    const psplat_sheet *sheet = &layout->sheets[part->mesh];
    uint8_t *rows = add_rows(layout, stride, 0, part->count, &place);
    for (size_t kind = 0; kind < PSPLAT_COLUMNS && rows; ++kind) {
        if (!part->columns[kind].components || is_apart(plan, sheet, kind)) continue;
        part->places[kind] = (psplat_place_in_view){place.view, place.offset + offsets[kind]};
        put_column(layout, part, kind, 0, rows + offsets[kind], stride);
    }
    return rows != NULL;
}

/* Rows of the parts of a mesh, then what stands apart. */
static int add_mesh(const psplat_layout_plan *plan, psplat_layout *layout, size_t first,
                    size_t last) {
    for (size_t i = first; i <= last; ++i) {
        size_t offsets[PSPLAT_COLUMNS], from = plan->rows_alike ? first : i;
        size_t stride = row_of(plan, layout, from, plan->rows_alike ? last : i, offsets);
        if (!add_part(plan, layout, &layout->parts[i], stride, offsets)) return 0;
    }
    for (size_t i = first; i <= last; ++i)
        for (size_t kind = 0; kind < PSPLAT_COLUMNS; ++kind) {
            psplat_part *part = &layout->parts[i];
            if (part->columns[kind].components &&
                is_apart(plan, &layout->sheets[part->mesh], kind) &&
                !add_column(layout, part, kind))
                return 0;
        }
    return 1;
}

static int compress(const psplat_codec *codec, psplat_file_view *view) {
    size_t bound = codec->bound(view->rows, view->stride);
    view->packed = malloc(bound + 3);
    if (!view->packed) return 0;
    view->packed_size = codec->encode(view->packed, bound, view->bytes, view->rows, view->stride);
    return view->packed_size > 0;
}

/* Room for the most parts and views that there can be. */
static int reserve(psplat_layout *layout) {
    size_t runs = 1;
    for (size_t i = 0; i < layout->mesh_count; ++i) runs += layout->sheets[i].splats->run_count;
    layout->parts = calloc(runs, sizeof *layout->parts);
    layout->views = calloc(3 * runs, sizeof *layout->views);
    return layout->parts && layout->views;
}

psplat_result psplat_layout_make(const psplat_layout_plan *plan, psplat_layout *layout,
                                 psplat_error *error) {
    int is_made = reserve(layout);
    for (size_t i = 0; i < layout->mesh_count && is_made; ++i) {
        size_t first = layout->part_count;
        is_made = make_parts(layout, i, plan->padding);
        if (is_made && layout->part_count > first)
            is_made = add_mesh(plan, layout, first, layout->part_count - 1);
    }
    for (size_t i = 0; i < layout->view_count && is_made && plan->codec; ++i)
        is_made = compress(plan->codec, &layout->views[i]);
    if (is_made) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the attributes");
}

void psplat_layout_clear(psplat_layout *layout) {
    for (size_t i = 0; i < layout->view_count; ++i) {
        free(layout->views[i].bytes);
        free(layout->views[i].packed);
    }
    free(layout->parts);
    free(layout->views);
    *layout = (psplat_layout){
        .sheets = layout->sheets, .mesh_count = layout->mesh_count, .stand_ins = layout->stand_ins};
}

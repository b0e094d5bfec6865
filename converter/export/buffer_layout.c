/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * buffer_layout.c - the primitives of a file and the buffer views that hold their attributes.
 *
 * Attributes are interleaved, one row for each splat, and primitives with rows of equal size share
 * a buffer view, because every view takes JSON and JSON is most of a small file. For the same
 * reason splats with few clip lines may join the primitive of those with more: their missing lines
 * are padded with lines that cut nothing off, where that takes fewer bytes than another primitive.
 * And a few flat splats may join the primitive of curved ones, with a shape that is 0.
 */
#include "export/buffer_layout.h"

#include "export/meshopt_codec.h"
#include "export/splat_attributes.h"
#include "export/splat_order.h"
#include "export/splat_stream.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Estimates of the JSON that a primitive and each of its attributes take, bytes, chosen by hand. */
enum { PRIMITIVE_BYTES = 260, ATTRIBUTE_BYTES = 130 };

/* How many flat splats may share a primitive with curved ones: fewer than FEW, or at most one of
 * SHARE splats. More would be slow to draw, since a curved splat costs more than a flat one. Chosen
 * by hand. */
enum { FEW = 32, SHARE = 10 };

enum { CLASSES = PSPLAT_LINE_CLASSES, PARTS = PSPLAT_PARTS }; /* of splats, by their clip lines */

/* ---- primitives ----------------------------------------------------------------------------- */

/* The runs of splats that may share a primitive: equal material, depth tolerance, kind of surface
 * and number of seams, all or none with texture coordinates, and at most one run of each number of
 * clip lines. Flat runs that joined a curved family are parts of their own. */
typedef struct family {
    uint32_t material;
    float depth_tolerance;
    uint32_t seam_lines;
    int is_streamed; /* a stream will hold it */
    int is_curved, has_shape, has_texcoord;
    int has_texcoord_bend; /* of some of them; that of the others is 0 */
    size_t first[PARTS], count[PARTS];
} family;

static size_t find_families(const psplat_splats *splats, family *families) {
    size_t count = 0, first = 0;
    for (size_t i = 0; i < splats->run_count; ++i) {
        const psplat_run *run = &splats->runs[i];
        size_t f = 0;
        while (f < count && (families[f].material != run->material ||
                             families[f].depth_tolerance != run->depth_tolerance ||
                             families[f].seam_lines != run->seam_lines ||
                             families[f].is_curved != run->is_curved ||
                             families[f].has_shape != run->has_shape ||
                             families[f].has_texcoord != run->has_texcoord ||
                             families[f].count[run->clip_lines]))
            ++f;
        if (f == count)
            families[count++] = (family){.material = run->material,
                                         .depth_tolerance = run->depth_tolerance,
                                         .seam_lines = run->seam_lines,
                                         .is_curved = run->is_curved,
                                         .has_shape = run->has_shape,
                                         .has_texcoord = run->has_texcoord};
        families[f].has_texcoord_bend |= run->has_texcoord_bend;
        families[f].first[run->clip_lines] = first;
        families[f].count[run->clip_lines] = run->count;
        first += run->count;
    }
    return count;
}

/* Returns whether nothing of the family's splats would change in a primitive of curved ones: with
 * SHAPE beside the field they keep their own; else their normals have to be those of the plane. */
static int fits_curved(const psplat_attribute_table *table, const family *flat,
                       const family *curved) {
    psplat_attribute_format formats[PSPLAT_ATTRIBUTE_KINDS];
    int fits = curved->has_shape || table->codes;
    for (size_t k = 0; k < CLASSES && fits && !curved->has_shape; ++k) {
        const psplat_run like = {.clip_lines = (uint32_t)k};
        psplat_attribute_table_formats(table, flat->first[k], flat->count[k], &like, formats);
        fits = !formats[PSPLAT_ATTRIBUTE_TILT].components &&
               !formats[PSPLAT_ATTRIBUTE_FIELD].components;
    }
    return fits;
}

/* Returns the splats of the classes from ... to: those of the family, or the flat ones that joined
 * it. */
static size_t count_of(const family *f, size_t from, size_t to, int joined) {
    size_t count = 0;
    for (size_t k = from; k <= to; ++k) count += f->count[k + (joined ? CLASSES : 0)];
    return count;
}

static int are_few(size_t flat, size_t curved) {
    return !flat || (curved && (flat < FEW || flat * SHARE <= flat + curved));
}

/* Moves flat families into curved ones, where those may hold them. Returns how many families are
 * left. */
static size_t join_families(const psplat_attribute_table *table, family *families, size_t count) {
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        const family flat = families[i];
        size_t to = flat.is_curved ? count : 0;
        for (; to < count; ++to) {
            const family *f = &families[to];
            if (f->is_curved && f->material == flat.material &&
                f->has_texcoord == flat.has_texcoord && f->seam_lines == flat.seam_lines &&
                f->depth_tolerance == flat.depth_tolerance && !count_of(f, 0, CLASSES - 1, 1) &&
                are_few(count_of(&flat, 0, CLASSES - 1, 0), count_of(f, 0, CLASSES - 1, 0)) &&
                fits_curved(table, &flat, f))
                break;
        }
        for (size_t k = 0; k < CLASSES && to < count; ++k) {
            families[to].first[CLASSES + k] = flat.first[k];
            families[to].count[CLASSES + k] = flat.count[k];
        }
        if (to < count) families[to].has_texcoord_bend |= flat.has_texcoord_bend;
        if (to == count) families[kept++] = flat;
    }
    return kept;
}

/* Estimates the bytes of writing the classes from ... to as one primitive: JSON and padding. */
static double cost_of(const family *f, size_t from, size_t to, size_t line_bytes, double padding) {
    size_t own = count_of(f, from, to, 0), joined = count_of(f, from, to, 1);
    double cost = 0;
    if (!are_few(joined, own)) return HUGE_VAL;
    /* Accessors would need the padding before the seams. */
    if (f->seam_lines && !f->is_streamed && own + joined > f->count[to] + f->count[CLASSES + to])
        return HUGE_VAL;
    for (size_t k = from; k <= to; ++k) {
        size_t lines = (f->count[k] + f->count[CLASSES + k]) * (to - k);
        if (lines) cost += padding * (double)(lines * line_bytes);
    }
    return own ? cost + PRIMITIVE_BYTES + (double)(6 + to) * ATTRIBUTE_BYTES : 0;
}

/* Finds the cheapest division of the classes into primitives by trying all of them. The result has
 * a bit set for each class that is the last of its primitive. */
static unsigned cheapest_cut(const family *f, size_t line_bytes, double padding) {
    unsigned best = (1u << CLASSES) - 1;
    double least = HUGE_VAL;
    for (unsigned cut = 1u << (CLASSES - 1); cut < 1u << CLASSES; ++cut) {
        double cost = 0;
        for (size_t k = 0, from = 0; k < CLASSES; ++k) {
            if (!(cut >> k & 1)) continue;
            size_t to = k;
            while (to > from && !f->count[to] && !f->count[CLASSES + to]) --to;
            cost += cost_of(f, from, to, line_bytes, padding);
            from = k + 1;
        }
        if (cost < least) least = cost, best = cut;
    }
    return best;
}

/* Sets the formats that hold all splats of a primitive. */
static void set_formats(const psplat_attribute_table *table, psplat_primitive_layout *primitive) {
    const psplat_run like = {.clip_lines = (uint32_t)primitive->clip_lines,
                             .is_curved = primitive->is_curved,
                             .has_shape = primitive->has_shape,
                             .has_texcoord = primitive->has_texcoord,
                             .has_texcoord_bend = primitive->has_texcoord_bend};
    for (size_t part = 0; part < PARTS; ++part) {
        psplat_attribute_format formats[PSPLAT_ATTRIBUTE_KINDS];
        psplat_attribute_table_formats(table, primitive->first[part], primitive->counts[part],
                                       &like, formats);
        for (size_t k = 0; k < PSPLAT_ATTRIBUTE_KINDS; ++k) {
            size_t components = primitive->formats[k].components;
            primitive->formats[k] = formats[k];
            if (components > formats[k].components) primitive->formats[k].components = components;
        }
    }
}

static void add_primitives(psplat_buffer_layout *layout, size_t mesh, const family *f,
                           unsigned cut) {
    const psplat_primitive_layout empty = {.mesh = mesh,
                                           .material = f->material,
                                           .depth_tolerance = f->depth_tolerance,
                                           .seam_lines = f->seam_lines,
                                           .is_curved = f->is_curved,
                                           .has_shape = f->has_shape,
                                           .has_texcoord = f->has_texcoord,
                                           .has_texcoord_bend = f->has_texcoord_bend};
    psplat_primitive_layout primitive = empty;
    for (size_t class = 0; class < CLASSES; ++class) {
        for (size_t part = class; part < PARTS; part += CLASSES) {
            primitive.first[part] = f->first[part];
            primitive.counts[part] = f->count[part];
            primitive.count += f->count[part];
            if (f->count[part]) primitive.clip_lines = class;
        }
        if (!(cut >> class & 1) || !primitive.count) continue;
        set_formats(&layout->tables[mesh], &primitive);
        layout->primitives[layout->primitive_count++] = primitive;
        primitive = empty;
    }
}

/* Sorts by clip lines, unclipped splats first (BSK04 section 4.1); the insertion sort is stable. */
static void sort_primitives(psplat_primitive_layout *primitives, size_t count) {
    for (size_t i = 1; i < count; ++i)
        for (size_t k = i; k > 0 && primitives[k - 1].clip_lines > primitives[k].clip_lines; --k) {
            psplat_primitive_layout other = primitives[k];
            primitives[k] = primitives[k - 1];
            primitives[k - 1] = other;
        }
}

/* Lists the splats of a primitive, in the order of its parts. */
static int list_splats(psplat_primitive_layout *primitive) {
    size_t at = 0;
    primitive->order = malloc(primitive->count * sizeof *primitive->order);
    if (!primitive->order) return 0;
    for (size_t part = 0; part < PARTS; ++part)
        for (size_t i = 0; i < primitive->counts[part]; ++i)
            primitive->order[at++] = (uint32_t)(primitive->first[part] + i);
    return 1;
}

static int make_primitives(const psplat_buffer_layout_plan *plan, psplat_buffer_layout *layout,
                           size_t mesh) {
    const psplat_attribute_table *table = &layout->tables[mesh];
    family *families = malloc((table->splats->run_count + 1) * sizeof *families);
    size_t first = layout->primitive_count;
    if (!families) return 0;
    size_t count = find_families(table->splats, families);
    for (size_t i = 0; i < count; ++i)
        families[i].is_streamed = plan->streams && psplat_stream_can_hold(table);
    if (plan->flat_joins) count = join_families(table, families, count);
    size_t line_bytes = psplat_attribute_bytes(&table->formats[PSPLAT_ATTRIBUTE_LINE]);
    for (size_t i = 0; i < count; ++i)
        add_primitives(layout, mesh, &families[i],
                       cheapest_cut(&families[i], line_bytes, plan->padding));
    sort_primitives(layout->primitives + first, layout->primitive_count - first);
    free(families);
    for (size_t i = first; i < layout->primitive_count; ++i)
        if (!list_splats(&layout->primitives[i])) return 0;
    return 1;
}

/* ---- streams -------------------------------------------------------------------------------- */

/* Returns whether the stream of a primitive holds a kind. A new kind must not come to lie between
 * these unless it does. */
static int is_in_stream(const psplat_primitive_layout *primitive, size_t kind) {
    return kind == PSPLAT_ATTRIBUTE_NORMAL ||
           (kind >= PSPLAT_ATTRIBUTE_ROTATION && kind < PSPLAT_ATTRIBUTE_COLOR_U) ||
           (primitive->streams_texcoords && kind >= PSPLAT_ATTRIBUTE_TEXCOORD_U &&
            kind <= PSPLAT_ATTRIBUTE_TEXCOORD_VV);
}

/* Brings the primitives that may share a stream with the first one next to it. Returns the end of
 * them. */
static size_t gather(psplat_buffer_layout *layout, size_t first) {
    psplat_primitive_layout *p = layout->primitives;
    size_t end = first + 1;
    for (size_t i = end; i < layout->primitive_count; ++i) {
        const psplat_primitive_layout other = p[i];
        if (other.material != p[first].material || other.has_texcoord != p[first].has_texcoord ||
            end - first == PSPLAT_MOST_SECTIONS)
            continue;
        memmove(&p[end + 1], &p[end], (i - end) * sizeof *p);
        p[end++] = other;
    }
    return end;
}

/* Brings the splats of a primitive into an order for a stream. */
static int sort_splats(const psplat_buffer_layout_plan *plan, const psplat_attribute_table *table,
                       int texcoords, psplat_primitive_layout *primitive) {
    return psplat_order_along_curve(table, primitive->order, primitive->count) &&
           (!plan->short_orders || psplat_order_shorten(table, plan->low_bits, texcoords,
                                                        primitive->order, primitive->count));
}

/* Adds the stream of the primitives from first to end - 1, each of which is a section. */
static int add_stream(const psplat_buffer_layout_plan *plan, psplat_buffer_layout *layout,
                      size_t first, size_t end) {
    psplat_section sections[PSPLAT_MOST_SECTIONS];
    psplat_primitive_layout *p = &layout->primitives[first];
    const psplat_attribute_table *table = &layout->tables[p->mesh];
    psplat_buffer_view view = {.stride = 1, .kind = PSPLAT_VIEW_STREAM};
    psplat_stream_desc desc = {layout->low_bits,
                               p->has_texcoord && psplat_stream_can_hold_texcoords(table)};
    for (size_t i = 0; i < end - first; ++i) {
        if (!sort_splats(plan, table, desc.holds_texcoords, &p[i])) return 0;
        sections[i] = (psplat_section){.order = p[i].order,
                                       .count = p[i].count,
                                       .clip_lines = p[i].clip_lines,
                                       .seam_lines = p[i].seam_lines,
                                       .depth_tolerance = p[i].depth_tolerance,
                                       .is_curved = p[i].is_curved,
                                       .has_shape = p[i].has_shape,
                                       .has_texcoord_bend = p[i].has_texcoord_bend};
    }
    int is_safe = 1;
    view.bytes = psplat_stream_encode(table, sections, end - first, &desc, &view.rows, &is_safe);
    if (!view.bytes && !is_safe) {
        desc.holds_texcoords = 0;
        view.bytes =
            psplat_stream_encode(table, sections, end - first, &desc, &view.rows, &is_safe);
    }
    if (!view.bytes) return 0;
    p->streams_texcoords = desc.holds_texcoords;
    p->is_streamed = 1;
    p->section_count = end - first;
    for (size_t i = 0; i < end - first; ++i) p->section_seams[i] = (uint8_t)p[i].seam_lines;
    p->stream = layout->view_count;
    layout->views[layout->view_count++] = view;
    return 1;
}

/* Adds the splats of a primitive, and its attributes that are not in the stream. */
static int join_primitive(psplat_primitive_layout *primitive,
                          const psplat_primitive_layout *other) {
    size_t count = primitive->count + other->count;
    uint32_t *order = realloc(primitive->order, count * sizeof *order);
    if (!order) return 0;
    memcpy(order + primitive->count, other->order, other->count * sizeof *order);
    primitive->order = order;
    primitive->count = count;
    primitive->has_texcoord_bend |= other->has_texcoord_bend;
    for (size_t k = 0; k < PSPLAT_ATTRIBUTE_KINDS; ++k)
        if (other->formats[k].components > primitive->formats[k].components)
            primitive->formats[k] = other->formats[k];
    return 1;
}

/* Returns the step of TEXCOORD_0 beside a stream. */
static double coarse_texcoord_step(const psplat_attribute_table *table) {
    return ldexp(table->splats->precision.texcoord_step,
                 (int)psplat_stream_texcoord_low_bits(table));
}

/* From how many splats on the TEXCOORD_0 beside a stream is smaller as floats for the exponential
 * filter, which takes a view of its own and JSON for that, than as bytes, whose steps are not those
 * of the stream. Read off files of 30 to 700 splats. */
enum { MANY_TEXCOORDS = 600 };

/* Returns the smallest type for the TEXCOORD_0 of a primitive beside a stream. Bytes need it to be
 * within 0 ... 1 or -1 ... 1. */
static int coarse_texcoord_type(const psplat_buffer_layout *layout, const psplat_codec *codec,
                                const psplat_primitive_layout *primitive) {
    const psplat_attribute_table *table = &layout->tables[primitive->mesh];
    double step = coarse_texcoord_step(table);
    int32_t low = 0, high = 0;
    for (size_t i = 0; i < primitive->count; ++i)
        for (int k = 0; k < 2; ++k) {
            int32_t at = psplat_stream_coarse_texcoord(table, primitive->order[i], k);
            if (at < low) low = at;
            if (at > high) high = at;
        }
    if ((codec && primitive->count >= MANY_TEXCOORDS) || high * step > 1 || low * step < -1)
        return PSPLAT_TYPE_FLOAT;
    return low < 0 ? PSPLAT_TYPE_BYTE : PSPLAT_TYPE_UNSIGNED_BYTE;
}

/* Leaves the formats of what is beside a stream. */
static void set_streamed_formats(const psplat_buffer_layout *layout, const psplat_codec *codec,
                                 psplat_primitive_layout *primitive) {
    psplat_attribute_format *position = &primitive->formats[PSPLAT_ATTRIBUTE_POSITION];
    float low[3], high[3];
    for (size_t k = 0; k < PSPLAT_ATTRIBUTE_KINDS; ++k)
        if (is_in_stream(primitive, k)) primitive->formats[k].components = 0;
    if (primitive->streams_texcoords)
        primitive->formats[PSPLAT_ATTRIBUTE_TEXCOORD].type =
            coarse_texcoord_type(layout, codec, primitive);
    psplat_buffer_layout_extent(layout, primitive, low, high);
    if (fmaxf(fmaxf(high[0], high[1]), high[2]) <= 255) position->type = PSPLAT_TYPE_UNSIGNED_BYTE;
}

/* Puts the primitives of a mesh, which begin at `first`, into as few with streams as there may be.
 */
static int make_streams(const psplat_buffer_layout_plan *plan, psplat_buffer_layout *layout,
                        size_t first) {
    for (; first < layout->primitive_count; ++first) {
        psplat_primitive_layout *p = &layout->primitives[first];
        size_t end = gather(layout, first);
        if (!add_stream(plan, layout, first, end)) return 0;
        while (end > first + 1) {
            if (!join_primitive(p, p + 1)) return 0;
            free(p[1].order);
            memmove(p + 1, p + 2, (--layout->primitive_count - first - 1) * sizeof *p);
            --end;
        }
        set_streamed_formats(layout, plan->codec, p);
    }
    return 1;
}

void psplat_buffer_layout_extent(const psplat_buffer_layout *layout,
                                 const psplat_primitive_layout *primitive, float low[3],
                                 float high[3]) {
    const psplat_attribute_table *table = &layout->tables[primitive->mesh];
    for (size_t i = 0; i < primitive->count; ++i)
        for (int k = 0; k < 3; ++k) {
            uint32_t index = primitive->order[i];
            float x = table->codes
                          ? (float)psplat_stream_coarse_position(table, index, k, layout->low_bits)
                          : table->splats->splats[index].center[k];
            if (!i || x < low[k]) low[k] = x;
            if (!i || x > high[k]) high[k] = x;
        }
}

/* ---- views ---------------------------------------------------------------------------------- */

/* Appends zeroed rows to the view for this stride and filter, which is made where there is none.
 * Returns the first row, or NULL where memory ran out. */
static uint8_t *add_rows(psplat_buffer_layout *layout, size_t stride, psplat_view_filter filter,
                         size_t rows, psplat_attribute_place *place) {
    size_t i = 0;
    while (i < layout->view_count &&
           (layout->views[i].stride != stride || layout->views[i].filter != filter ||
            layout->views[i].kind == PSPLAT_VIEW_STREAM))
        ++i;
    psplat_buffer_view *view = &layout->views[i];
    if (i == layout->view_count) {
        *view = (psplat_buffer_view){.stride = stride, .filter = filter};
        layout->view_count++;
    }
    if (view->rows + rows > view->capacity) {
        size_t capacity = 2 * view->rows + rows;
        uint8_t *bytes = realloc(view->bytes, capacity * stride);
        if (!bytes) return NULL;
        view->bytes = bytes;
        view->capacity = capacity;
    }
    *place = (psplat_attribute_place){i, view->rows * stride};
    view->rows += rows;
    uint8_t *start = view->bytes + place->offset;
    memset(start, 0, rows * stride);
    return start;
}

static void put_coarse_position(const psplat_attribute_table *table, size_t index,
                                uint32_t low_bits, const psplat_attribute_format *format,
                                uint8_t *out) {
    size_t bytes = format->type == PSPLAT_TYPE_UNSIGNED_BYTE ? 1 : 2;
    for (int k = 0; k < 3; ++k)
        out = psplat_put_integer(
            out, (uint32_t)psplat_stream_coarse_position(table, index, k, low_bits), bytes);
}

/* Writes a number of the TEXCOORD_0 beside a stream, so many of its steps. Normalized integers
 * stand for the multiple of the step that is nearest. */
static uint8_t *put_coarse_texcoord(double step, int32_t steps, int type, psplat_view_filter filter,
                                    uint8_t *out) {
    float value = (float)(steps * step);
    uint32_t bits = ((uint32_t)steps & 0xffffff) | (uint32_t)ilogb(step) << 24;
    if (type == PSPLAT_TYPE_UNSIGNED_BYTE)
        return psplat_put_integer(out, (uint32_t)lrintf(255 * value), 1);
    if (type == PSPLAT_TYPE_BYTE) return psplat_put_integer(out, (uint32_t)lrintf(127 * value), 1);
    if (filter != PSPLAT_FILTER_EXPONENTIAL) memcpy(&bits, &value, sizeof bits);
    return psplat_put_integer(out, bits, 4);
}

static void put_coarse_texcoords(const psplat_attribute_table *table, size_t index, int type,
                                 psplat_view_filter filter, uint8_t *out) {
    for (int k = 0; k < 2; ++k)
        out =
            put_coarse_texcoord(coarse_texcoord_step(table),
                                psplat_stream_coarse_texcoord(table, index, k), type, filter, out);
}

/* Writes an attribute of a primitive's splats, stride bytes apart. */
static void put_attribute(const psplat_buffer_layout *layout,
                          const psplat_primitive_layout *primitive, size_t kind,
                          psplat_view_filter filter, uint8_t *out, size_t stride) {
    const psplat_attribute_table *table = &layout->tables[primitive->mesh];
    const psplat_attribute_format *format = &primitive->formats[kind];
    for (size_t i = 0; i < primitive->count; ++i, out += stride) {
        uint32_t index = primitive->order[i];
        if (filter == PSPLAT_FILTER_OCTAHEDRAL)
            psplat_attribute_table_put_octahedral(table, index, out);
        else if (kind == PSPLAT_ATTRIBUTE_TEXCOORD && primitive->streams_texcoords)
            put_coarse_texcoords(table, index, format->type, filter, out);
        else if (filter == PSPLAT_FILTER_EXPONENTIAL)
            psplat_attribute_table_put_exponential(table, index, out);
        else if (kind == PSPLAT_ATTRIBUTE_POSITION && primitive->is_streamed)
            put_coarse_position(table, index, layout->low_bits, format, out);
        else
            psplat_attribute_table_put(table, kind, format, index, out);
    }
}

static int is_apart(const psplat_buffer_layout_plan *plan, const psplat_buffer_layout *layout,
                    const psplat_primitive_layout *primitive, size_t kind) {
    const psplat_attribute_table *table = &layout->tables[primitive->mesh];
    return (plan->lines_apart && psplat_attribute_is_clip_line(kind)) ||
           (plan->normals_apart && table->codes && kind == PSPLAT_ATTRIBUTE_NORMAL) ||
           (plan->codec && kind == PSPLAT_ATTRIBUTE_TEXCOORD &&
            primitive->formats[kind].type == PSPLAT_TYPE_FLOAT &&
            psplat_attribute_table_has_texcoord_grid(table));
}

/* Writes an attribute of a primitive into a view of its own. */
static int add_separate_attribute(psplat_buffer_layout *layout, psplat_primitive_layout *primitive,
                                  size_t kind) {
    psplat_view_filter filter = kind == PSPLAT_ATTRIBUTE_NORMAL     ? PSPLAT_FILTER_OCTAHEDRAL
                                : kind == PSPLAT_ATTRIBUTE_TEXCOORD ? PSPLAT_FILTER_EXPONENTIAL
                                                                    : PSPLAT_FILTER_NONE;
    size_t stride = psplat_attribute_bytes(&primitive->formats[kind]);
    uint8_t *out = add_rows(layout, stride, filter, primitive->count, &primitive->places[kind]);
    if (out) put_attribute(layout, primitive, kind, filter, out, stride);
    return out != NULL;
}

/* Returns whether an attribute takes the place of the kind before it: it has the same name, and a
 * primitive has only one of both. */
static int replaces_previous(size_t kind) {
    return kind == PSPLAT_ATTRIBUTE_SURFACE_TILT || kind == PSPLAT_ATTRIBUTE_SURFACE_FIELD;
}

/* Finds the offsets of attributes in rows that have room for those of all primitives from first to
 * last. Returns the bytes of such a row. */
static size_t row_of(const psplat_buffer_layout_plan *plan, const psplat_buffer_layout *layout,
                     size_t first, size_t last, size_t offsets[PSPLAT_ATTRIBUTE_KINDS]) {
    size_t bytes = 0;
    for (size_t kind = 0; kind < PSPLAT_ATTRIBUTE_KINDS; ++kind) {
        size_t element = 0;
        for (size_t i = first; i <= last; ++i) {
            const psplat_primitive_layout *primitive = &layout->primitives[i];
            size_t found = psplat_attribute_bytes(&primitive->formats[kind]);
            if (!is_apart(plan, layout, primitive, kind) && found > element) element = found;
        }
        offsets[kind] = replaces_previous(kind) ? offsets[kind - 1] : bytes;
        if (offsets[kind] + element > bytes) bytes = offsets[kind] + element;
    }
    return bytes;
}

static int add_rows_of(const psplat_buffer_layout_plan *plan, psplat_buffer_layout *layout,
                       psplat_primitive_layout *primitive, size_t stride,
                       const size_t offsets[PSPLAT_ATTRIBUTE_KINDS]) {
    psplat_attribute_place place;
    uint8_t *rows = add_rows(layout, stride, PSPLAT_FILTER_NONE, primitive->count, &place);
    for (size_t kind = 0; kind < PSPLAT_ATTRIBUTE_KINDS && rows; ++kind) {
        if (!primitive->formats[kind].components || is_apart(plan, layout, primitive, kind))
            continue;
        primitive->places[kind] =
            (psplat_attribute_place){place.view, place.offset + offsets[kind]};
        put_attribute(layout, primitive, kind, PSPLAT_FILTER_NONE, rows + offsets[kind], stride);
    }
    return rows != NULL;
}

/* Adds the interleaved rows of a mesh's primitives first, then the attributes with views of their
 * own. */
static int add_mesh(const psplat_buffer_layout_plan *plan, psplat_buffer_layout *layout,
                    size_t first, size_t last) {
    for (size_t i = first; i <= last; ++i) {
        size_t offsets[PSPLAT_ATTRIBUTE_KINDS], from = plan->rows_alike ? first : i;
        size_t stride = row_of(plan, layout, from, plan->rows_alike ? last : i, offsets);
        if (!add_rows_of(plan, layout, &layout->primitives[i], stride, offsets)) return 0;
    }
    for (size_t i = first; i <= last; ++i)
        for (size_t kind = 0; kind < PSPLAT_ATTRIBUTE_KINDS; ++kind) {
            psplat_primitive_layout *primitive = &layout->primitives[i];
            if (primitive->formats[kind].components && is_apart(plan, layout, primitive, kind) &&
                !add_separate_attribute(layout, primitive, kind))
                return 0;
        }
    return 1;
}

static int compress(const psplat_codec *codec, psplat_buffer_view *view) {
    size_t bound = codec->bound(view->rows, view->stride);
    view->packed = malloc(bound + 3);
    if (!view->packed) return 0;
    view->packed_size = codec->encode(view->packed, bound, view->bytes, view->rows, view->stride);
    return view->packed_size > 0;
}

/* Allocates the most primitives and views that there can be: each run may need one for its rows,
 * one for its normals, one for its texture coordinates and two for its lines, straight and bent, or
 * one for a stream. */
static int reserve(psplat_buffer_layout *layout) {
    size_t runs = 1;
    for (size_t i = 0; i < layout->mesh_count; ++i) runs += layout->tables[i].splats->run_count;
    layout->primitives = calloc(runs, sizeof *layout->primitives);
    layout->views = calloc(5 * runs, sizeof *layout->views);
    return layout->primitives && layout->views;
}

psplat_result psplat_buffer_layout_make(const psplat_buffer_layout_plan *plan,
                                        psplat_buffer_layout *layout, psplat_error *error) {
    int is_made = reserve(layout);
    layout->low_bits = plan->streams ? plan->low_bits : 0;
    for (size_t i = 0; i < layout->mesh_count && is_made; ++i) {
        size_t first = layout->primitive_count;
        is_made = make_primitives(plan, layout, i);
        if (is_made && plan->streams && psplat_stream_can_hold(&layout->tables[i]))
            is_made = make_streams(plan, layout, first);
        if (is_made && layout->primitive_count > first)
            is_made = add_mesh(plan, layout, first, layout->primitive_count - 1);
    }
    for (size_t i = 0; i < layout->view_count && is_made && plan->codec; ++i)
        if (layout->views[i].kind != PSPLAT_VIEW_STREAM)
            is_made = compress(plan->codec, &layout->views[i]);
    if (is_made) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the attributes");
}

void psplat_buffer_layout_clear(psplat_buffer_layout *layout) {
    for (size_t i = 0; i < layout->view_count; ++i) {
        free(layout->views[i].bytes);
        free(layout->views[i].packed);
    }
    for (size_t i = 0; i < layout->primitive_count; ++i) free(layout->primitives[i].order);
    free(layout->primitives);
    free(layout->views);
    *layout = (psplat_buffer_layout){.tables = layout->tables,
                                     .mesh_count = layout->mesh_count,
                                     .fallbacks = layout->fallbacks,
                                     .animations = layout->animations,
                                     .levels = layout->levels,
                                     .finest_count = layout->finest_count};
}

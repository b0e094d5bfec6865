/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_order.c - orders of splats that take few bytes.
 *
 * The codec of EXT_meshopt_compression stores each byte of a row as its difference to the row
 * before, in groups of sixteen rows: with two or four bits for each difference that fits, and a
 * byte more for each that does not. So the order is a path past all splats, and each of its steps
 * costs bits. It starts as a Hilbert curve, and as long as that saves bits, parts of it are turned
 * round and short ones are moved elsewhere (2-opt: Croes, 1958; Or-opt: Or, 1976), next to a splat
 * that is near. The stream gains a little from it as well, where normals are alike.
 */
#include "export/splat_order.h"

#include "export/splat_stream.h"
#include "mesh/mesh.h"

#include <stdlib.h>
#include <string.h>

/* ---- along a curve --------------------------------------------------------------------------- */

typedef struct order_entry {
    uint64_t place;
    uint32_t index;
} order_entry;

/* Returns the place of a point of 16 bits for each coordinate along a Hilbert curve. */
static uint64_t hilbert_place(uint32_t x[3]) {
    enum { BITS = 16 };
    uint64_t place = 0;
    for (uint32_t bit = 1u << (BITS - 1); bit > 1; bit >>= 1)
        for (int i = 0; i < 3; ++i) {
            uint32_t swapped = x[i] & bit ? 0 : (x[0] ^ x[i]) & (bit - 1);
            if (x[i] & bit) x[0] ^= bit - 1;
            x[0] ^= swapped;
            x[i] ^= swapped;
        }
    x[1] ^= x[0];
    x[2] ^= x[1];
    uint32_t all = 0;
    for (uint32_t bit = 1u << (BITS - 1); bit > 1; bit >>= 1)
        if (x[2] & bit) all ^= bit - 1;
    for (int bit = BITS - 1; bit >= 0; --bit)
        for (int i = 0; i < 3; ++i) place = place << 1 | ((x[i] ^ all) >> bit & 1);
    return place;
}

static int compare_places(const void *a, const void *b) {
    const order_entry *first = a, *second = b;
    if (first->place != second->place) return first->place < second->place ? -1 : 1;
    return (first->index > second->index) - (first->index < second->index);
}

int psplat_order_along_curve(const psplat_attribute_table *table, uint32_t *order, size_t count) {
    order_entry *entries = malloc((count + 1) * sizeof *entries);
    if (!entries) return 0;
    for (size_t i = 0; i < count; ++i) {
        uint32_t x[3];
        for (int k = 0; k < 3; ++k)
            x[k] = (uint32_t)(table->codes[order[i]].position[k] - table->low[k]);
        entries[i] = (order_entry){hilbert_place(x), order[i]};
    }
    qsort(entries, count, sizeof *entries, compare_places);
    for (size_t i = 0; i < count; ++i) order[i] = entries[i].index;
    free(entries);
    return 1;
}

/* ---- shorter --------------------------------------------------------------------------------- */

/* How many neighbours of each splat are known, next to which it may be moved, how far along the
 * curve they are looked for, and the most rounds; most paths are as short as they get after six. */
enum { NEIGHBORS = 8, WINDOW = 120, ROUNDS = 12 };
/* The most splats that are moved at once, and how far along the path a move may reach: that bounds
 * its time. */
enum { MOST_MOVED = 3, FARTHEST = 1000 };
/* The bytes of a splat in the rows of a file, a position's two for each coordinate and those of
 * texture coordinates, and the highest eight bits of both numbers of its normal. */
enum { STORED = 8, NORMAL = 2, ROW = STORED + NORMAL };

typedef struct row {
    uint8_t bytes[ROW];
    uint32_t index;
} row;

/* A path past rows. Places count along it. */
typedef struct tour {
    row *rows;                        /* count, in the order in which the path began */
    uint32_t *path;                   /* count: the row at each place */
    uint32_t *place;                  /* count: of each row */
    uint32_t (*neighbors)[NEIGHBORS]; /* of each row, PSPLAT_NONE behind the last */
    uint8_t *stirred; /* of each row: the path has changed near it since its moves were tried */
    size_t count;
    uint8_t stored_costs[256], normal_costs[256]; /* of the differences of bytes */
} tour;

/* Returns what a difference of bytes, of which the codec keeps the lowest eight bits, costs in half
 * bits. The numbers were chosen by hand: 0 and 1 fit two bits, but often lie in a group that takes
 * four; up to 7 fits four; all others take an escape and a byte. Up to 15 counts less than that,
 * since groups with many of these are stored as bytes. */
static uint8_t stored_cost(int difference) {
    int size = difference < 128 ? difference : 256 - difference;
    return size == 0 ? 6 : size == 1 ? 7 : size <= 7 ? 8 : size <= 15 ? 20 : 24;
}

/* Returns what a difference of normals costs, in half bits: half of its binary digits, since a
 * stream predicts a splat from the nearest of many, which mostly is another one. */
static uint8_t normal_cost(int difference) {
    uint8_t digits = 0;
    for (; difference; difference >>= 1) ++digits;
    return digits;
}

static void set_costs(tour *t) {
    for (int i = 0; i < 256; ++i) {
        t->stored_costs[i] = stored_cost(i);
        t->normal_costs[i] = normal_cost(i);
    }
}

/* Returns what it costs that one row follows another. It is the same the other way round. */
static int step_cost(const tour *t, const row *a, const row *b) {
    int cost = 0;
    for (int k = 0; k < STORED; ++k) cost += t->stored_costs[(uint8_t)(b->bytes[k] - a->bytes[k])];
    for (int k = STORED; k < ROW; ++k) cost += t->normal_costs[abs(b->bytes[k] - a->bytes[k])];
    return cost;
}

/* Marks the rows at two places that follow each other, and those near them: moves beside them may
 * pay again. */
static void stir(tour *t, long place) {
    for (long at = place > 0 ? place - 1 : 0; at <= place && at < (long)t->count; ++at) {
        const uint32_t row = t->path[at], *neighbors = t->neighbors[row];
        t->stirred[row] = 1;
        for (int k = 0; k < NEIGHBORS && neighbors[k] != PSPLAT_NONE; ++k)
            t->stirred[neighbors[k]] = 1;
    }
}

/* Returns what it costs that the row at one place follows that at another; 0 beyond the ends. */
static int cost_between(const tour *t, long a, long b) {
    long end = (long)t->count;
    if (a < 0 || b < 0 || a >= end || b >= end) return 0;
    return step_cost(t, &t->rows[t->path[a]], &t->rows[t->path[b]]);
}

/* Turns the part of the path from one place to another round. */
static void turn_round(tour *t, long first, long last) {
    for (; first <= last; ++first, --last) {
        uint32_t row = t->path[first];
        t->path[first] = t->path[last];
        t->path[last] = row;
        t->place[t->path[first]] = (uint32_t)first;
        t->place[row] = (uint32_t)last;
    }
}

/* Turns a part of the path round if that saves something. Returns whether it did. */
static int try_turn(tour *t, long first, long last) {
    if (first >= last) return 0;
    int gain = cost_between(t, first - 1, first) + cost_between(t, last, last + 1) -
               cost_between(t, first - 1, last) - cost_between(t, first, last + 1);
    if (gain <= 0) return 0;
    turn_round(t, first, last);
    stir(t, first);
    stir(t, last + 1);
    return 1;
}

/* Moves a part of the path to before the row at a place outside of it, one way round or the other,
 * if that saves something. Returns whether it did. */
static int try_move(tour *t, long first, long last, long before) {
    long end = (long)t->count, moved = last - first + 1;
    if (first < 0 || last >= end || (before >= first && before <= last + 1)) return 0;
    int gain = cost_between(t, first - 1, first) + cost_between(t, last, last + 1) -
               cost_between(t, first - 1, last + 1) + cost_between(t, before - 1, before);
    int straight = cost_between(t, before - 1, first) + cost_between(t, last, before);
    int turned = cost_between(t, before - 1, last) + cost_between(t, first, before);
    if (gain <= straight && gain <= turned) return 0;
    /* Both parts that change places are turned round together, then the other one again, and the
     * moved one unless it is to stay turned. */
    long begin = before < first ? before : first, stop = before < first ? last : before - 1;
    long to = before < first ? begin : stop - moved + 1;
    turn_round(t, begin, stop);
    if (before < first)
        turn_round(t, begin + moved, stop);
    else
        turn_round(t, begin, stop - moved);
    if (straight <= turned) turn_round(t, to, to + moved - 1);
    stir(t, to);
    stir(t, to + moved);
    stir(t, before < first ? stop + 1 : begin);
    return 1;
}

/* Returns whether two places are near enough along the path. */
static int are_within_reach(long a, long b) {
    return labs(a - b) <= FARTHEST;
}

/* Brings two rows next to each other if that saves something, by turning the path between them
 * round. Returns whether it did. */
static int join_by_turn(tour *t, uint32_t a, uint32_t b) {
    long i = (long)t->place[a], k = (long)t->place[b], first = i < k ? i : k, last = i < k ? k : i;
    if (!are_within_reach(i, k)) return 0;
    return try_turn(t, first + 1, last) || try_turn(t, first, last - 1);
}

/* Brings a row next to another one if that saves something, alone or with those before or after it.
 * Returns whether it did. */
static int join_by_move(tour *t, uint32_t a, uint32_t b) {
    for (int moved = 0; moved < MOST_MOVED; ++moved) {
        long i = (long)t->place[a], k = (long)t->place[b];
        if (!are_within_reach(i, k)) return 0;
        for (int after = 0; after <= 1; ++after)
            if (try_move(t, i, i + moved, k + after) ||
                (moved && try_move(t, i - moved, i, k + after)))
                return 1;
    }
    return 0;
}

/* Returns whether one row is likely to save something by coming next to another one: what is next
 * to it now costs more on one side. Moves that only save where they close the path behind them are
 * left out: trying them takes as long as all others do, for a tenth of a percent of the positions.
 */
static int may_gain(const tour *t, uint32_t a, uint32_t b) {
    long i = (long)t->place[a];
    int cost = step_cost(t, &t->rows[a], &t->rows[b]);
    return cost < cost_between(t, i - 1, i) || cost < cost_between(t, i, i + 1);
}

/* Shortens the path as long as that saves something, beside rows where it has changed. */
static void shorten(tour *t) {
    int improves = 1;
    memset(t->stirred, 1, t->count);
    for (int round = 0; round < ROUNDS && improves; ++round) {
        improves = 0;
        for (uint32_t a = 0; a < t->count; ++a) {
            if (!t->stirred[a]) continue;
            t->stirred[a] = 0;
            for (int k = 0; k < NEIGHBORS && t->neighbors[a][k] != PSPLAT_NONE; ++k) {
                uint32_t b = t->neighbors[a][k];
                if (!may_gain(t, a, b) && !may_gain(t, b, a)) continue;
                improves |= join_by_turn(t, a, b);
                improves |= join_by_move(t, a, b);
            }
        }
    }
}

/* Finds the rows beside which one costs least, of those that are near along the curve. */
static void find_neighbors(const tour *t, size_t of, uint32_t neighbors[NEIGHBORS]) {
    size_t first = of > WINDOW ? of - WINDOW : 0, found = 0;
    size_t end = of + WINDOW < t->count ? of + WINDOW + 1 : t->count;
    int costs[NEIGHBORS];
    for (size_t i = first; i < end; ++i) {
        int cost = step_cost(t, &t->rows[of], &t->rows[i]);
        if (i == of || (found == NEIGHBORS && cost >= costs[NEIGHBORS - 1])) continue;
        size_t at = found < NEIGHBORS ? found++ : NEIGHBORS - 1;
        for (; at && costs[at - 1] > cost; --at) {
            costs[at] = costs[at - 1];
            neighbors[at] = neighbors[at - 1];
        }
        costs[at] = cost;
        neighbors[at] = (uint32_t)i;
    }
    for (; found < NEIGHBORS; ++found) neighbors[found] = PSPLAT_NONE;
}

/* Texture coordinates that are bytes are 255ths, so that their steps beside a stream are four. What
 * a file has as other types or from other attributes, as colours, does not count. */
static row row_of(const psplat_attribute_table *table, uint32_t index, uint32_t low_bits,
                  int texcoords) {
    int normal_bits = table->splats->precision.normal_bits;
    row made = {.index = index};
    for (int k = 0; k < 3; ++k) {
        int32_t position = psplat_stream_coarse_position(table, index, k, low_bits);
        psplat_put_integer(made.bytes + 2 * k, (uint32_t)position, 2);
    }
    for (int k = 0; k < 2; ++k) {
        int32_t normal = table->codes[index].normal[k] + (1 << normal_bits) / 2;
        if (texcoords)
            made.bytes[6 + k] = (uint8_t)(4 * psplat_stream_coarse_texcoord(table, index, k));
        made.bytes[STORED + k] = (uint8_t)(normal_bits > 8 ? normal >> (normal_bits - 8) : normal);
    }
    return made;
}

int psplat_order_shorten(const psplat_attribute_table *table, uint32_t low_bits, int texcoords,
                         uint32_t *order, size_t count) {
    tour t = {.count = count};
    t.rows = malloc((count + 1) * sizeof *t.rows);
    t.path = malloc((count + 1) * sizeof *t.path);
    t.place = malloc((count + 1) * sizeof *t.place);
    t.neighbors = malloc((count + 1) * sizeof *t.neighbors);
    t.stirred = malloc(count + 1);
    int ok = t.rows && t.path && t.place && t.neighbors && t.stirred;
    for (size_t i = 0; ok && i < count; ++i) {
        t.rows[i] = row_of(table, order[i], low_bits, texcoords);
        t.path[i] = t.place[i] = (uint32_t)i;
    }
    set_costs(&t);
    for (size_t i = 0; ok && i < count; ++i) find_neighbors(&t, i, t.neighbors[i]);
    if (ok) shorten(&t);
    for (size_t i = 0; ok && i < count; ++i) order[i] = t.rows[t.path[i]].index;
    free(t.rows);
    free(t.path);
    free(t.place);
    free(t.neighbors);
    free(t.stirred);
    return ok;
}

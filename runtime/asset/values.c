/* SPDX-License-Identifier: MIT
 *
 * values.c - the values of a primitive's attributes, decoded and checked one by one (spec 3.3 to
 * 3.8). They are read in blocks that stay in the cache. Most of the time of opening a large asset
 * is spent here and in touching the memory of its splats for the first time, which happens once.
 */
#include "asset/gltf.h"
#include "asset/surface.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { BLOCK = 128, MAX_COMPONENTS = 4 };

typedef struct decoder {
    const psplat_gltf *gltf;
    const psplat_readers *readers;
    const psplat_set *set;
    psplat_splat blank;  /* values of what is not stored */
    size_t first, count; /* the splats of the block */
    size_t index;        /* the splat being decoded, counted in the primitive */
    float values[PSPLAT_ATTRIBUTES][BLOCK * MAX_COMPONENTS];
    size_t components[PSPLAT_ATTRIBUTES]; /* of each splat, once unpacked to floats */
    double cosines[BLOCK];                /* between NORMAL and N */
    psplat_radii radii;                   /* used where radii are integers */
    double low[3], high[3];               /* box of the splats */
    float center_low[3], center_high[3];  /* box of their centres */
} decoder;

static psplat_result fail_value(const decoder *d, size_t attribute, const char *what) {
    const psplat_reader *reader = &d->readers->of[attribute];
    const psplat_buffer *buffer = reader->buffer;
    size_t at = psplat_buffer_offset(buffer, reader->start + d->index * reader->stride);
    return psplat_fail(d->gltf->error, PSPLAT_ERROR_RANGE, at, "splat %zu%s%.80s: %s %s", d->index,
                       buffer->path ? " in " : "", buffer->path ? buffer->path : "",
                       psplat_attribute_types[attribute].name, what);
}

/* ---- blocks ------------------------------------------------------------------------------- */

/* Tests the exponents' bits without a branch, so that the compiler can test several values at
 * once. */
static int all_finite(const float *values, size_t count) {
    uint32_t found = 0;
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        found |= (bits & 0x7fffffffu) >= 0x7f800000u;
    }
    return !found;
}

static psplat_result fail_infinite(decoder *d, size_t attribute) {
    size_t i = 0;
    while (isfinite(d->values[attribute][i])) ++i;
    d->index = d->first + i / d->components[attribute];
    return fail_value(d, attribute, "is not finite");
}

/* Turns integers into the floats that they stand for (spec 3.9). */
static void unpack(decoder *d, size_t attribute) {
    const psplat_reader *reader = &d->readers->of[attribute];
    const psplat_set *set = d->set;
    float *values = d->values[attribute];
    if (reader->component_type == PSPLAT_FLOAT) return;
    if (attribute == PSPLAT_SCALE) psplat_unpack_radii(values, d->count, &d->radii);
    if (attribute >= PSPLAT_FIRST_CLIP && attribute < PSPLAT_COLOR_U) {
        if (reader->components == 2)
            psplat_unpack_lines(values, d->count, set->clip_range);
        else
            psplat_unpack_bent_lines(values, d->count, set->clip_range, set->bend_range);
    }
    if (attribute == PSPLAT_SHAPE) psplat_unpack_scaled(values, d->count * 3, set->shape_range);
    if (attribute == PSPLAT_TURN) psplat_unpack_scaled(values, d->count, set->turn_range);
    if (attribute == PSPLAT_TILT) psplat_unpack_scaled(values, d->count * 2, set->tilt_range);
    if (attribute == PSPLAT_NORMAL_FIELD)
        psplat_unpack_scaled(values, d->count * reader->components, set->field_range);
    if (attribute == PSPLAT_COLOR_U || attribute == PSPLAT_COLOR_V)
        psplat_unpack_scaled(values, d->count * reader->components, set->color_range);
    if (attribute == PSPLAT_TEXCOORD_U || attribute == PSPLAT_TEXCOORD_V)
        psplat_unpack_scaled(values, d->count * 2, set->texcoord_range);
    if (attribute >= PSPLAT_TEXCOORD_UU)
        psplat_unpack_scaled(values, d->count * 2, set->texcoord_bend_range);
}

/* Returns the number of components of an attribute once it is unpacked. */
static size_t unpacked_components(const psplat_reader *reader, size_t attribute) {
    if (attribute >= PSPLAT_FIRST_CLIP && attribute < PSPLAT_COLOR_U)
        return reader->components + (reader->component_type != PSPLAT_FLOAT);
    if (attribute == PSPLAT_ROTATION) return 4; /* made from a turn where it is not stored */
    return reader->components;
}

static psplat_result read_block(decoder *d) {
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES; ++i) {
        if (!d->readers->is_present[i]) continue;
        psplat_reader_get(&d->readers->of[i], d->first, d->count, d->values[i]);
        unpack(d, i);
        int is_float = d->readers->of[i].component_type == PSPLAT_FLOAT; /* integers are finite */
        if (is_float && !all_finite(d->values[i], d->count * d->components[i]))
            return fail_infinite(d, i);
    }
    return PSPLAT_OK;
}

/* Refuses lengths more than 1 % away from 1 (spec 3.3, 3.5) and normalises, but leaves values that
 * are unit up to float rounding as they are stored: a round trip changes no bit. */
static int normalise(float *values, size_t count) {
    double square = 0;
    for (size_t i = 0; i < count; ++i) square += (double)values[i] * (double)values[i];
    if (fabs(square - 1) <= 2 * (double)FLT_EPSILON)
        return 1; /* most floats end here, without a square root */
    double length = sqrt(square), scale = 1 / length;
    if (!(length >= 0.99 && length <= 1.01)) return 0;
    if (fabs(length - 1) > 2 * (double)FLT_EPSILON)
        for (size_t i = 0; i < count; ++i) values[i] = (float)((double)values[i] * scale);
    return 1;
}

static psplat_result normalise_block(decoder *d, size_t attribute, const char *what) {
    size_t components = d->components[attribute];
    for (size_t i = 0; i < d->count; ++i) {
        if (normalise(d->values[attribute] + i * components, components)) continue;
        d->index = d->first + i;
        return fail_value(d, attribute, what);
    }
    return PSPLAT_OK;
}

/* Makes rotations from TURN; NORMAL is then N (spec 3.3). */
static psplat_result turn_block(decoder *d) {
    const float *turns = d->values[PSPLAT_TURN];
    for (size_t i = 0; i < d->count; ++i)
        if (!(turns[i] >= -1 && turns[i] <= 1)) {
            d->index = d->first + i;
            return fail_value(d, PSPLAT_TURN, "is not from -1 to 1");
        }
    psplat_unpack_turns(d->values[PSPLAT_NORMAL], turns, d->count, d->values[PSPLAT_ROTATION]);
    return PSPLAT_OK;
}

/* Beside TURN, x and y of eq. (2) are stored and NORMAL is N (spec 3.5). */
static void tilt_block(decoder *d) {
    const float *rotations = d->values[PSPLAT_ROTATION], *tilts = d->values[PSPLAT_TILT];
    float *normals = d->values[PSPLAT_NORMAL];
    for (size_t i = 0; i < d->count; ++i) {
        double axes[3][3], x = (double)tilts[2 * i], y = (double)tilts[2 * i + 1];
        double scale = 1 / sqrt(1 + x * x + y * y);
        psplat_rotation_axes(rotations + 4 * i, axes);
        for (size_t k = 0; k < 3; ++k)
            normals[3 * i + k] =
                (float)(scale * ((double)normals[3 * i + k] + x * axes[0][k] + y * axes[1][k]));
        d->cosines[i] = scale;
    }
}

static void find_cosines(decoder *d) {
    const float *rotations = d->values[PSPLAT_ROTATION], *normals = d->values[PSPLAT_NORMAL];
    for (size_t i = 0; i < d->count; ++i) {
        double axes[3][3];
        psplat_rotation_axes(rotations + 4 * i, axes);
        d->cosines[i] = (double)normals[3 * i] * axes[2][0] +
                        (double)normals[3 * i + 1] * axes[2][1] +
                        (double)normals[3 * i + 2] * axes[2][2];
    }
}

/* Makes rotations and normals, and the cosine between each normal and N. */
static psplat_result make_frames(decoder *d) {
    int is_turned = d->readers->is_present[PSPLAT_TURN];
    psplat_result result = normalise_block(d, PSPLAT_NORMAL, "is not unit");
    if (!result)
        result = is_turned ? turn_block(d)
                           : normalise_block(d, PSPLAT_ROTATION, "is not a unit quaternion");
    if (result) return result;
    if (d->readers->is_present[PSPLAT_TILT])
        tilt_block(d);
    else
        find_cosines(d);
    return PSPLAT_OK;
}

/* Returns the values of an attribute of the splat being decoded. */
static const float *values_of(const decoder *d, size_t attribute) {
    return d->values[attribute] + (d->index - d->first) * d->components[attribute];
}

/* ---- splats ------------------------------------------------------------------------------- */

static psplat_result decode_frame(const decoder *d, psplat_splat *splat) {
    memcpy(splat->center, values_of(d, PSPLAT_POSITION), sizeof splat->center);
    memcpy(splat->radius, values_of(d, PSPLAT_SCALE), sizeof splat->radius);
    memcpy(splat->normal, values_of(d, PSPLAT_NORMAL), sizeof splat->normal);
    memcpy(splat->rotation, values_of(d, PSPLAT_ROTATION), sizeof splat->rotation);
    if (splat->radius[0] >= splat->radius[1] && splat->radius[1] > 0) return PSPLAT_OK;
    return fail_value(d, PSPLAT_SCALE, "is not two radii, the larger first, above 0");
}

/* Checks the bound of spec 3.5, eq. (3a), which keeps n(u, v) within 90 degrees of N, and finite,
 * all over the ellipse. Fields of two numbers may be older than the bound and are scaled down to
 * it. */
static psplat_result decode_gradient(const decoder *d, psplat_splat *splat, double cosine) {
    memcpy(splat->gradient, values_of(d, PSPLAT_NORMAL_FIELD),
           d->components[PSPLAT_NORMAL_FIELD] * sizeof *splat->gradient);
    double alpha = (double)splat->gradient[0], beta = (double)splat->gradient[1];
    double gamma = (double)splat->gradient[2];
    /* Fields are usually far from the bound; then no square root is needed, because neither term
     * exceeds 10. */
    if (cosine > 0.1 && alpha * alpha + beta * beta + 2 * gamma * gamma < 100) return PSPLAT_OK;
    double ratio = (double)splat->radius[1] / (double)splat->radius[0];
    double center = sqrt(fmax(1 / (cosine * cosine) - 1, 0));
    double change = sqrt(alpha * alpha + beta * beta + gamma * gamma * (1 + ratio * ratio));
    if (center + change <= 20) return PSPLAT_OK;
    if (d->components[PSPLAT_NORMAL_FIELD] == 3)
        return fail_value(d, PSPLAT_NORMAL_FIELD, "bends the normal by more than spec 3.5 allows");
    splat->gradient[0] = (float)(alpha * ((20 - center) / change));
    splat->gradient[1] = (float)(beta * ((20 - center) / change));
    return PSPLAT_OK;
}

static psplat_result decode_normals(const decoder *d, psplat_splat *splat) {
    double cosine = d->cosines[d->index - d->first];
    if (!(cosine >= 0.05))
        return fail_value(d, PSPLAT_NORMAL, "leaves the plane's normal N by more than acos 0.05");
    if (!d->readers->is_present[PSPLAT_NORMAL_FIELD]) return PSPLAT_OK;
    return decode_gradient(d, splat, cosine);
}

/* Sets the shape, of which x and y are those of the normal field unless it is stored, and checks
 * the bound of spec 3.4, eq. (1b). */
static psplat_result decode_shape(const decoder *d, psplat_splat *splat) {
    const int *is_present = d->readers->is_present;
    int is_stored = is_present[PSPLAT_SHAPE];
    memcpy(splat->shape + 2, is_stored ? values_of(d, PSPLAT_SHAPE) : splat->gradient,
           sizeof splat->gradient);
    if (is_present[PSPLAT_ROTATION] && !is_stored)
        psplat_surface_find_tilt(splat, splat->shape);
    else if (is_present[PSPLAT_TILT] && !is_stored)
        memcpy(splat->shape, values_of(d, PSPLAT_TILT), 2 * sizeof *splat->shape);
    if (psplat_surface_is_allowed(splat)) return PSPLAT_OK;
    return fail_value(d, is_stored ? PSPLAT_SHAPE : PSPLAT_NORMAL_FIELD,
                      "makes the surface steeper than spec 3.4 allows");
}

/* Returns whether all values are from 0 to 1, as those of COLOR_0, OCCLUSION_ROUGHNESS_METALLIC and
 * EMISSIVE must be. */
static int are_parts(const float *values, size_t count) {
    int are = 1;
    for (size_t i = 0; i < count; ++i) are &= values[i] >= 0 && values[i] <= 1;
    return are;
}

static psplat_result decode_color(const decoder *d, psplat_splat *splat) {
    if (!d->readers->is_present[PSPLAT_COLOR]) return PSPLAT_OK;
    memcpy(splat->color, values_of(d, PSPLAT_COLOR),
           d->components[PSPLAT_COLOR] * sizeof *splat->color);
    if (are_parts(splat->color, 4)) return PSPLAT_OK;
    return fail_value(d, PSPLAT_COLOR, "is not from 0 to 1");
}

static psplat_result decode_finish(const decoder *d, psplat_finish *finish) {
    const int *is_present = d->readers->is_present;
    *finish = (psplat_finish){.occlusion = 1, .roughness = 1, .metallic = 1, .emissive = {1, 1, 1}};
    if (is_present[PSPLAT_COLOR_U]) {
        memcpy(finish->color_u, values_of(d, PSPLAT_COLOR_U), sizeof finish->color_u);
        memcpy(finish->color_v, values_of(d, PSPLAT_COLOR_V), sizeof finish->color_v);
    }
    if (is_present[PSPLAT_ORM]) {
        const float *orm = values_of(d, PSPLAT_ORM);
        if (!are_parts(orm, 3)) return fail_value(d, PSPLAT_ORM, "is not from 0 to 1");
        finish->occlusion = orm[0];
        finish->roughness = orm[1];
        finish->metallic = orm[2];
    }
    if (!is_present[PSPLAT_EMISSIVE]) return PSPLAT_OK;
    memcpy(finish->emissive, values_of(d, PSPLAT_EMISSIVE), sizeof finish->emissive);
    if (are_parts(finish->emissive, 3)) return PSPLAT_OK;
    return fail_value(d, PSPLAT_EMISSIVE, "is not from 0 to 1");
}

static void decode_texcoord(const decoder *d, psplat_texcoord *texcoord) {
    const int *is_present = d->readers->is_present;
    float *const terms[] = {texcoord->at,       texcoord->along_u,  texcoord->along_v,
                            texcoord->along_uu, texcoord->along_uv, texcoord->along_vv};
    *texcoord = (psplat_texcoord){{0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}};
    for (size_t i = PSPLAT_FIRST_TEXCOORD; i < PSPLAT_ATTRIBUTES; ++i)
        if (is_present[i])
            memcpy(terms[i - PSPLAT_FIRST_TEXCOORD], values_of(d, i), sizeof texcoord->at);
}

static psplat_result decode_clip_lines(const decoder *d, psplat_splat *splat) {
    for (uint32_t i = 0; i < splat->clip_count; ++i) {
        float *line = splat->clip[i];
        memcpy(line, values_of(d, PSPLAT_FIRST_CLIP + i), sizeof splat->clip[i]);
        if (line[0] == 0 && line[1] == 0)
            return fail_value(d, PSPLAT_FIRST_CLIP + i, "is no line: a and b are 0");
        if (d->components[PSPLAT_FIRST_CLIP + i] == 3) continue;
        splat->bend[i] = values_of(d, PSPLAT_FIRST_CLIP + i)[3];
        if (!(fabsf(splat->bend[i]) <= 4))
            return fail_value(d, PSPLAT_FIRST_CLIP + i, "is bent by more than 4");
    }
    return PSPLAT_OK;
}

/* Enlarges the box of the centres. Returns whether the sphere of this radius around a splat's
 * centre lies in the box of the splats already, which for most splats spares the exact test. */
static int enlarge_centers(decoder *d, const psplat_splat *splat, double radius) {
    int is_inside = 1;
    for (size_t i = 0; i < 3; ++i) {
        double center = (double)splat->center[i];
        is_inside &= center - radius > d->low[i] && center + radius < d->high[i];
        if (splat->center[i] < d->center_low[i]) d->center_low[i] = splat->center[i];
        if (splat->center[i] > d->center_high[i]) d->center_high[i] = splat->center[i];
    }
    return is_inside;
}

/* Enlarges the box of the splats along an axis. */
static psplat_result enlarge_box(decoder *d, size_t axis, double low, double high) {
    if (high > (double)FLT_MAX || low < -(double)FLT_MAX)
        return fail_value(d, PSPLAT_SCALE, "makes the splat reach beyond what a float can hold");
    if (low < d->low[axis]) d->low[axis] = low;
    if (high > d->high[axis]) d->high[axis] = high;
    return PSPLAT_OK;
}

/* Enlarges the boxes by the centre and by the unclipped ellipse. */
static psplat_result enlarge_by_ellipse(decoder *d, const psplat_splat *splat) {
    double axes[3][3];
    psplat_result result = PSPLAT_OK;
    if (enlarge_centers(d, splat, (double)splat->radius[0] * (1 + 1e-6))) return PSPLAT_OK;
    psplat_rotation_axes(splat->rotation, axes);
    for (size_t i = 0; i < 3 && !result; ++i) {
        double center = (double)splat->center[i];
        double u = (double)splat->radius[0] * axes[0][i], v = (double)splat->radius[1] * axes[1][i];
        double reach = sqrt(u * u + v * v);
        result = enlarge_box(d, i, center - reach, center + reach);
    }
    return result;
}

/* Enlarges the boxes by the centre and by the unclipped surface. */
static psplat_result enlarge_by_surface(decoder *d, const psplat_splat *splat) {
    double low[3], high[3];
    psplat_result result = PSPLAT_OK;
    if (enlarge_centers(d, splat, (double)splat->radius[0] * PSPLAT_CURVED_REACH)) return PSPLAT_OK;
    psplat_surface_find_box(splat, low, high);
    for (size_t i = 0; i < 3 && !result; ++i) {
        double center = (double)splat->center[i];
        result = enlarge_box(d, i, center + low[i], center + high[i]);
    }
    return result;
}

static psplat_result decode_splat(decoder *d, psplat_splat *splat) {
    *splat = d->blank;
    psplat_result result = decode_frame(d, splat);
    if (!result) result = decode_normals(d, splat);
    if (!result && d->set->is_curved) result = decode_shape(d, splat);
    if (!result) result = decode_color(d, splat);
    if (!result) result = decode_clip_lines(d, splat);
    if (result) return result;
    return d->set->is_curved ? enlarge_by_surface(d, splat) : enlarge_by_ellipse(d, splat);
}

/* ---- the primitive ------------------------------------------------------------------------ */

/* Rounds the bounds outwards. */
static void store_bounds(const decoder *d, psplat_set *set, double extent[3]) {
    for (size_t i = 0; i < 3; ++i) {
        float low = (float)d->low[i], high = (float)d->high[i];
        if ((double)low > d->low[i]) low = nextafterf(low, -FLT_MAX);
        if ((double)high < d->high[i]) high = nextafterf(high, FLT_MAX);
        set->bounds_min[i] = low;
        set->bounds_max[i] = high;
        extent[i] = (double)d->center_high[i] - (double)d->center_low[i];
    }
}

/* What decoded splats become. */
typedef struct decoded {
    psplat_splat *splats;
    psplat_finish *finishes;    /* NULL where nothing varies over a splat */
    psplat_texcoord *texcoords; /* NULL where there are no texture coordinates */
} decoded;

/* Decodes a block to where its first splat is to be. */
static psplat_result decode_block(decoder *d, const decoded *out, size_t at) {
    psplat_result result = read_block(d);
    if (!result) result = make_frames(d);
    for (size_t i = 0; i < d->count && !result; ++i) {
        d->index = d->first + i;
        result = decode_splat(d, &out->splats[at + i]);
        if (!result && out->finishes) result = decode_finish(d, &out->finishes[at + i]);
        if (!result && out->texcoords) decode_texcoord(d, &out->texcoords[at + i]);
    }
    return result;
}

static void pack(const psplat_set *set, const decoded *from, size_t first, size_t count) {
    const psplat_packing *p = &set->packing;
    const psplat_packed *packed = set->packed;
    psplat_pack_splats(p, from->splats, count, packed->splats + first * (size_t)p->splat_floats);
    if (packed->clips)
        psplat_pack_clips(p, from->splats, count, packed->clips + first * (size_t)p->clip_floats);
    if (packed->finishes)
        psplat_pack_finishes(p, from->finishes, count,
                             packed->finishes + first * (size_t)p->finish_floats);
    if (packed->texcoords)
        psplat_pack_texcoords(p, from->splats, from->texcoords, count,
                              packed->texcoords + first * (size_t)p->texcoord_floats);
    psplat_chunks_find(from->splats, count, packed->chunks + first / PSPLAT_CHUNK_SPLATS);
}

/* Where splats are packed, they are decoded to a place that stays in the cache. */
static decoded place_of(const psplat_gltf *gltf, const psplat_set *set, size_t first) {
    int varies = set->has_color_gradient || set->has_surface || set->has_emissive;
    if (set->packed)
        return (decoded){gltf->chunk_splats, varies ? gltf->chunk_finishes : NULL,
                         set->has_texcoord ? gltf->chunk_texcoords : NULL};
    return (decoded){set->splats + first, set->finishes ? set->finishes + first : NULL,
                     set->texcoords ? set->texcoords + first : NULL};
}

static psplat_result decode_chunk(decoder *d, psplat_set *set, size_t first, size_t count) {
    const decoded out = place_of(d->gltf, set, first);
    for (size_t at = 0; at < count; at += d->count) {
        d->first = first + at;
        d->count = count - at < BLOCK ? count - at : BLOCK;
        psplat_result result = decode_block(d, &out, at);
        if (result) return result;
    }
    if (set->packed) pack(set, &out, first, count);
    return PSPLAT_OK;
}

psplat_result psplat_values_decode(const psplat_gltf *gltf, const psplat_readers *readers,
                                   psplat_set *set, double extent[3]) {
    decoder d;
    d.gltf = gltf;
    d.readers = readers;
    d.set = set;
    d.blank = (psplat_splat){.color = {1, 1, 1, 1}, .clip_count = set->clip_count};
    size_t scale_type = readers->of[PSPLAT_SCALE].component_type;
    if (scale_type != PSPLAT_FLOAT)
        psplat_radii_set(&d.radii, set->scale_range,
                         scale_type == PSPLAT_UNSIGNED_BYTE ? 255.0f : 65535.0f);
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES; ++i)
        d.components[i] = unpacked_components(&readers->of[i], i);
    for (size_t i = 0; i < 3; ++i) {
        d.low[i] = HUGE_VAL;
        d.high[i] = -HUGE_VAL;
        d.center_low[i] = FLT_MAX;
        d.center_high[i] = -FLT_MAX;
    }
    for (size_t first = 0; first < set->count; first += PSPLAT_CHUNK_SPLATS) {
        size_t count = set->count - first;
        if (count > PSPLAT_CHUNK_SPLATS) count = PSPLAT_CHUNK_SPLATS;
        psplat_result result = decode_chunk(&d, set, first, count);
        if (result) return result;
    }
    store_bounds(&d, set, extent);
    return PSPLAT_OK;
}

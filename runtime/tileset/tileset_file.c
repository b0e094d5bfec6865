/* SPDX-License-Identifier: MIT
 *
 * tileset_file.c - reads tileset.json and checks everything that it uses. Tiles are taken breadth
 * first, so that the children of each lie side by side.
 */
#include "tileset/tileset_file.h"

#include "core/json.h"
#include "core/matrix.h"
#include "core/uri.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* How much a child's error may exceed its parent's where both were scaled: rounding alone. */
static const double error_rounding = 1e-9;

enum tile_member {
    VOLUME,
    GEOMETRIC_ERROR,
    REFINE,
    TRANSFORM,
    CONTENT,
    CONTENTS,
    CHILDREN,
    VIEWER_REQUEST,
    IMPLICIT,
    EXTRAS,
    TILE_MEMBERS
};

static const char *const tile_names[TILE_MEMBERS] = {
    "boundingVolume", "geometricError",      "refine",         "transform", "content", "contents",
    "children",       "viewerRequestVolume", "implicitTiling", "extras"};

/* What a tile of the text hands down to its children. */
typedef struct inherited {
    uint32_t transform;
    double error;
    int adds;     /* 1: refine is ADD */
    int is_known; /* 0: nothing above says what refine is */
} inherited;

typedef struct reader {
    psplat_json json;
    psplat_tileset *out;
    const psplat_tileset_place *place;
    psplat_json_value *children; /* of each node */
    inherited *given;            /* of each node, to its children */
} reader;

/* ---- errors -------------------------------------------------------------------------------- */

static psplat_result refuse(const reader *r, psplat_result code, psplat_json_value value,
                            const char *text) {
    return psplat_fail(r->json.error, code, psplat_json_offset(&r->json, value), "%s", text);
}

static psplat_result no_memory(const reader *r) {
    return refuse(r, PSPLAT_ERROR_MEMORY, 0, "no memory for the tiles");
}

/* ---- volumes ------------------------------------------------------------------------------- */

static psplat_result check_region(const reader *r, psplat_json_value value, const double g[6]) {
    const double most = 1e-9 + pi; /* written with few digits */
    for (int i = 0; i < 4; ++i)
        if (!(fabs(g[i]) <= (i % 2 ? most / 2 : most)))
            return refuse(r, PSPLAT_ERROR_RANGE, value, "a region is not on the ellipsoid");
    if (!(g[1] <= g[3]) || !(g[4] <= g[5]) || !(fabs(g[4]) <= 1e7) || !(fabs(g[5]) <= 1e7))
        return refuse(r, PSPLAT_ERROR_RANGE, value,
                      "a region has its south above its north or no possible heights");
    return PSPLAT_OK;
}

static int is_finite_volume(const psplat_tile_volume *v) {
    double sum = psplat_tile_radius(v);
    for (int i = 0; i < 3; ++i) sum += fabs(v->center[i]);
    return sum < 1e150; /* squares of lengths stay finite */
}

static psplat_result read_volume(reader *r, psplat_json_value volume, const double transform[16],
                                 psplat_tile_volume *out) {
    static const char *const names[] = {"box", "sphere", "region"};
    double numbers[12] = {0};
    psplat_json_value m[3];
    psplat_result result = psplat_json_members(&r->json, volume, names, 3, m);
    if (result) return result;
    if (!m[0] && !m[1] && !m[2])
        return refuse(r, PSPLAT_ERROR_UNSUPPORTED, volume,
                      "boundingVolume has neither box nor sphere nor region");
    if (m[0]) {
        result = psplat_json_numbers(&r->json, m[0], "box", 12, numbers);
        if (!result) psplat_tile_volume_box(numbers, transform, out);
    } else if (m[1]) {
        result = psplat_json_numbers(&r->json, m[1], "sphere", 4, numbers);
        if (!result && numbers[3] < 0)
            return refuse(r, PSPLAT_ERROR_RANGE, m[1], "the radius of a sphere is negative");
        if (!result) psplat_tile_volume_sphere(numbers, transform, out);
    } else {
        result = psplat_json_numbers(&r->json, m[2], "region", 6, numbers);
        if (!result) result = check_region(r, m[2], numbers);
        if (!result) psplat_tile_volume_region(numbers, out);
    }
    if (!result && !is_finite_volume(out))
        return refuse(r, PSPLAT_ERROR_RANGE, volume, "a boundingVolume is too large");
    return result;
}

/* ---- transforms and errors ----------------------------------------------------------------- */

static psplat_result check_transform(const reader *r, psplat_json_value value, const double m[16]) {
    double inverse[16], det = psplat_matrix_determinant3(m);
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
        return refuse(r, PSPLAT_ERROR_RANGE, value, "the last row of a transform is not 0 0 0 1");
    if (det == 0 || !isfinite(det) || !psplat_matrix_invert(m, inverse))
        return refuse(r, PSPLAT_ERROR_RANGE, value, "a transform is singular or not finite");
    return PSPLAT_OK;
}

/* Sets *index to that of the transform of a tile: its own after that of the tile above it. */
static psplat_result read_transform(reader *r, psplat_json_value value, uint32_t above,
                                    uint32_t *index) {
    double z_up[16], y_up[16];
    psplat_tileset *out = r->out;
    *index = above;
    if (!value) return PSPLAT_OK;
    psplat_result result = psplat_json_numbers(&r->json, value, "transform", 16, z_up);
    if (!result) result = check_transform(r, value, z_up);
    if (result) return result;
    psplat_tile_transform_y_up(z_up, y_up);
    *index = (uint32_t)out->transform_count++;
    psplat_matrix_multiply(out->transforms[above], y_up, out->transforms[*index]);
    return check_transform(r, value, out->transforms[*index]);
}

static psplat_result read_error(reader *r, psplat_json_value tile, psplat_json_value value,
                                double scale, double most, double *error) {
    if (!value) return refuse(r, PSPLAT_ERROR_FORMAT, tile, "geometricError is missing");
    psplat_result result = psplat_json_number(&r->json, value, "geometricError", error);
    if (result) return result;
    if (*error < 0) return refuse(r, PSPLAT_ERROR_RANGE, value, "geometricError is negative");
    *error *= scale;
    if (!(*error < 1e150))
        return refuse(r, PSPLAT_ERROR_RANGE, value, "geometricError is too large");
    if (*error > most * (1 + error_rounding))
        return psplat_fail(r->json.error, PSPLAT_ERROR_RANGE, psplat_json_offset(&r->json, value),
                           "geometricError grows downwards: %g is more than %g of the tile above",
                           *error, most);
    *error = fmin(*error, most);
    return PSPLAT_OK;
}

/* ---- refinement and extras ------------------------------------------------------------------ */

static psplat_result read_refine(reader *r, psplat_json_value tile, psplat_json_value value,
                                 inherited *given) {
    psplat_result result = psplat_json_expect(&r->json, value, PSPLAT_JSON_STRING, "refine");
    if (result) return result;
    if (!value && !given->is_known)
        return refuse(r, PSPLAT_ERROR_FORMAT, tile, "refine of the root is missing");
    if (!value) return PSPLAT_OK;
    int adds = psplat_json_equals(&r->json, value, "ADD");
    if (!adds && !psplat_json_equals(&r->json, value, "REPLACE"))
        return refuse(r, PSPLAT_ERROR_FORMAT, value, "refine is neither REPLACE nor ADD");
    given->adds = adds;
    given->is_known = 1;
    return PSPLAT_OK;
}

/* The cone's axis is turned as normals are; where a transform is no similarity, angles change and
 * there is no cone. */
static psplat_result read_cone(reader *r, psplat_json_value value, const double m[16],
                               double cone[4]) {
    double numbers[4], axis[3], scale = psplat_tile_stretch(m);
    psplat_result result = psplat_json_numbers(&r->json, value, "cone", 4, numbers);
    if (result || !value) return result;
    if (!(fabs(sqrt(psplat_dot3(numbers, numbers)) - 1) < 1e-3) || !(fabs(numbers[3]) <= 1))
        return refuse(r, PSPLAT_ERROR_RANGE, value,
                      "cone is not a unit vector and a cosine from -1 to 1");
    if (!psplat_tile_is_similarity(m)) return PSPLAT_OK;
    psplat_tile_y_up(numbers, axis);
    double length = sqrt(psplat_dot3(axis, axis));
    for (int i = 0; i < 3; ++i)
        cone[i] = (m[i] * axis[0] + m[4 + i] * axis[1] + m[8 + i] * axis[2]) / (length * scale);
    cone[3] = numbers[3];
    return PSPLAT_OK;
}

/* Reads what our extras tell; extras of others may be anything. */
static psplat_result read_extras(reader *r, psplat_json_value extras, psplat_tile_node *node) {
    static const char *const outer[] = {"phongsplat"}, *const names[] = {"splats", "cone"};
    psplat_json_value own = 0, m[2];
    size_t splats = 0;
    node->cone[3] = -2;
    if (!extras || psplat_json_type_of(&r->json, extras) != PSPLAT_JSON_OBJECT) return PSPLAT_OK;
    psplat_result result = psplat_json_members(&r->json, extras, outer, 1, &own);
    if (result || !own) return result;
    result = psplat_json_members(&r->json, own, names, 2, m);
    if (!result) result = psplat_json_integer(&r->json, m[0], "splats", 0x7fffffff, &splats);
    node->splats = (uint32_t)splats;
    if (result) return result;
    return read_cone(r, m[1], r->out->transforms[node->transform], node->cone);
}

/* ---- contents ------------------------------------------------------------------------------ */

static int ends_with_json(const char *path) {
    size_t length = strlen(path);
    if (length < 5) return 0;
    const char *end = path + length - 5;
    return end[0] == '.' && (end[1] | 32) == 'j' && (end[2] | 32) == 's' && (end[3] | 32) == 'o' &&
           (end[4] | 32) == 'n';
}

/* Finds a content in the archive, if there is one. */
static psplat_result find_in_archive(reader *r, psplat_json_value uri,
                                     psplat_tile_content *content) {
    const psplat_tile_archive *archive = r->place->archive;
    if (!archive) return PSPLAT_OK;
    const psplat_tile_entry *entry = psplat_tile_archive_find(archive, content->path);
    if (!entry) return refuse(r, PSPLAT_ERROR_FORMAT, uri, "the archive has no such file");
    if (!entry->is_stored)
        return refuse(r, PSPLAT_ERROR_UNSUPPORTED, uri, "the archive holds this file compressed");
    content->offset = entry->offset;
    content->size = entry->span;
    content->stored = entry->size;
    return PSPLAT_OK;
}

static psplat_result read_content(reader *r, psplat_json_value value, uint32_t node) {
    static const char *const names[] = {"uri", "url"}; /* the second in drafts of 1.0 */
    psplat_json_value m[2];
    char *uri = NULL;
    size_t size = 0;
    const char *reason = NULL;
    psplat_result result = psplat_json_members(&r->json, value, names, 2, m);
    if (result) return result;
    psplat_json_value at = m[0] ? m[0] : m[1];
    if (!at) return refuse(r, PSPLAT_ERROR_FORMAT, value, "a content has no uri");
    result = psplat_json_string(&r->json, at, &r->out->scratch, &uri, &size);
    if (result) return result;
    const char *path = psplat_uri_resolve(r->out->file->path, uri, size, &r->out->kept, &reason);
    if (!path && !reason) return no_memory(r);
    if (!path)
        return psplat_fail(r->json.error, PSPLAT_ERROR_UNSUPPORTED,
                           psplat_json_offset(&r->json, at), "the uri %.80s is refused: %s", uri,
                           reason);
    psplat_tile_content *content = &r->out->contents[r->out->content_count++];
    *content = (psplat_tile_content){
        .path = path, .node = node, .is_tileset = ends_with_json(path), .file = r->out->file};
    return find_in_archive(r, at, content);
}

static psplat_result read_content_list(reader *r, psplat_json_value list, uint32_t node) {
    psplat_result result = psplat_json_expect(&r->json, list, PSPLAT_JSON_ARRAY, "contents");
    if (result) return result;
    if (!psplat_json_length(&r->json, list))
        return refuse(r, PSPLAT_ERROR_FORMAT, list, "contents is empty");
    psplat_json_value entry = psplat_json_first(&r->json, list);
    for (; entry && !result; entry = psplat_json_next(&r->json, list, entry))
        result = read_content(r, entry, node);
    return result;
}

/* Reads the contents of a tile. An external tileset stands alone and has its own children. */
static psplat_result read_contents(reader *r, psplat_json_value tile,
                                   const psplat_json_value m[TILE_MEMBERS], uint32_t node) {
    psplat_tileset *out = r->out;
    size_t first = out->content_count;
    psplat_result result = PSPLAT_OK;
    if (m[CONTENT] && m[CONTENTS])
        return refuse(r, PSPLAT_ERROR_FORMAT, tile, "a tile has both content and contents");
    if (m[CONTENT]) result = read_content(r, m[CONTENT], node);
    if (m[CONTENTS]) result = read_content_list(r, m[CONTENTS], node);
    out->nodes[node].first_content = (uint32_t)first;
    out->nodes[node].content_count = (uint32_t)(out->content_count - first);
    for (size_t i = first; i < out->content_count && !result; ++i)
        if (out->contents[i].is_tileset && (m[CHILDREN] || out->content_count - first > 1))
            return refuse(r, PSPLAT_ERROR_UNSUPPORTED, tile,
                          "a tile has an external tileset beside children or other contents");
    return result;
}

/* ---- tiles --------------------------------------------------------------------------------- */

static psplat_result check_members(reader *r, psplat_json_value tile,
                                   const psplat_json_value m[TILE_MEMBERS]) {
    if (m[IMPLICIT])
        return refuse(r, PSPLAT_ERROR_UNSUPPORTED, m[IMPLICIT], "implicitTiling is not read");
    if (m[VIEWER_REQUEST])
        return refuse(r, PSPLAT_ERROR_UNSUPPORTED, m[VIEWER_REQUEST],
                      "viewerRequestVolume is not read");
    if (!m[VOLUME]) return refuse(r, PSPLAT_ERROR_FORMAT, tile, "boundingVolume is missing");
    psplat_result result = psplat_json_expect(&r->json, m[CHILDREN], PSPLAT_JSON_ARRAY, "children");
    if (!result && m[CHILDREN] && !psplat_json_length(&r->json, m[CHILDREN]))
        return refuse(r, PSPLAT_ERROR_FORMAT, m[CHILDREN], "children is empty");
    if (!result && !m[CHILDREN] && !m[CONTENT] && !m[CONTENTS])
        return refuse(r, PSPLAT_ERROR_FORMAT, tile, "a tile has neither content nor children");
    return result;
}

/* Reads a tile into the next node, which counts only where the caller says so. */
static psplat_result read_tile(reader *r, psplat_json_value tile, inherited above,
                               psplat_json_value m[TILE_MEMBERS]) {
    psplat_tileset *out = r->out;
    uint32_t index = (uint32_t)out->node_count;
    psplat_tile_node *node = &out->nodes[index];
    memset(node, 0, sizeof *node);
    psplat_result result = psplat_json_members(&r->json, tile, tile_names, TILE_MEMBERS, m);
    if (!result) result = check_members(r, tile, m);
    if (!result) result = read_transform(r, m[TRANSFORM], above.transform, &node->transform);
    if (result) return result;
    const double *transform = out->transforms[node->transform];
    result = read_volume(r, m[VOLUME], transform, &node->volume);
    if (!result)
        result = read_error(r, tile, m[GEOMETRIC_ERROR], psplat_tile_stretch(transform),
                            above.error, &node->error);
    r->given[index] = above;
    r->given[index].transform = node->transform;
    r->given[index].error = node->error;
    if (!result) result = read_refine(r, tile, m[REFINE], &r->given[index]);
    if (!result) result = read_contents(r, tile, m, index);
    if (!result) result = read_extras(r, m[EXTRAS], node);
    if (!result && r->given[index].adds && node->content_count && m[CHILDREN])
        return refuse(r, PSPLAT_ERROR_UNSUPPORTED, m[REFINE] ? m[REFINE] : tile,
                      "refine ADD of a tile with a content is not read: coarse splats would blend "
                      "over fine ones");
    return result;
}

/* Appends the tiles of an array of children. In the place of a tile without content come its
 * children; the JSON reader bounds how often that happens. */
static psplat_result append_children(reader *r, psplat_json_value list, inherited above,
                                     uint32_t parent) {
    psplat_json_value m[TILE_MEMBERS], tile = psplat_json_first(&r->json, list);
    psplat_tileset *out = r->out;
    psplat_result result = PSPLAT_OK;
    for (; tile && !result; tile = psplat_json_next(&r->json, list, tile)) {
        size_t index = out->node_count;
        result = read_tile(r, tile, above, m);
        if (result) return result;
        if (!out->nodes[index].content_count) {
            result = append_children(r, m[CHILDREN], r->given[index], parent);
            continue;
        }
        out->nodes[index].parent = parent;
        r->children[index] = m[CHILDREN];
        ++out->node_count;
    }
    return result;
}

static psplat_result read_tree(reader *r, psplat_json_value root) {
    psplat_tileset *out = r->out;
    psplat_json_value m[TILE_MEMBERS];
    psplat_result result = read_tile(r, root, (inherited){.error = r->place->error}, m);
    if (result) return result;
    if (!out->nodes[0].content_count && r->place->referrer)
        return refuse(r, PSPLAT_ERROR_UNSUPPORTED, root,
                      "the root of an external tileset has no content");
    out->nodes[0].parent = PSPLAT_TILE_NONE;
    r->children[0] = m[CHILDREN];
    out->node_count = 1;
    for (size_t i = 0; i < out->node_count && !result; ++i) {
        size_t first = out->node_count;
        if (r->children[i]) result = append_children(r, r->children[i], r->given[i], (uint32_t)i);
        out->nodes[i].first_child = (uint32_t)first;
        out->nodes[i].child_count = (uint32_t)(out->node_count - first);
    }
    return result;
}

/* ---- files --------------------------------------------------------------------------------- */

static psplat_result check_asset(reader *r, psplat_json_value asset) {
    static const char *const names[] = {"version", "gltfUpAxis"};
    psplat_json_value m[2];
    if (!asset) return refuse(r, PSPLAT_ERROR_FORMAT, 0, "asset is missing");
    psplat_result result = psplat_json_members(&r->json, asset, names, 2, m);
    if (!result && !m[0]) return refuse(r, PSPLAT_ERROR_FORMAT, asset, "asset.version is missing");
    for (int i = 0; i < 2 && !result; ++i)
        result = psplat_json_expect(&r->json, m[i], PSPLAT_JSON_STRING, names[i]);
    if (result) return result;
    if (!psplat_json_equals(&r->json, m[0], "1.0") && !psplat_json_equals(&r->json, m[0], "1.1"))
        return refuse(r, PSPLAT_ERROR_UNSUPPORTED, m[0], "asset.version is neither 1.0 nor 1.1");
    if (m[1] && !psplat_json_equals(&r->json, m[1], "Y"))
        return refuse(r, PSPLAT_ERROR_UNSUPPORTED, m[1], "gltfUpAxis is not Y");
    return PSPLAT_OK;
}

static psplat_result check_required(reader *r, psplat_json_value list) {
    psplat_result result =
        psplat_json_expect(&r->json, list, PSPLAT_JSON_ARRAY, "extensionsRequired");
    if (result || !list) return result;
    psplat_json_value name = psplat_json_first(&r->json, list);
    for (; name; name = psplat_json_next(&r->json, list, name)) {
        result = psplat_json_expect(&r->json, name, PSPLAT_JSON_STRING, "an extension");
        if (result) return result;
        if (!psplat_json_equals(&r->json, name, "3DTILES_content_gltf"))
            return refuse(r, PSPLAT_ERROR_UNSUPPORTED, name,
                          "the tileset requires an extension that is not read");
    }
    return PSPLAT_OK;
}

static psplat_result check_circle(reader *r) {
    int deep = 1;
    for (const psplat_tile_file *f = r->place->referrer; f; f = f->referrer) {
        if (!strcmp(f->path, r->place->path))
            return refuse(r, PSPLAT_ERROR_FORMAT, 0, "the tileset refers to itself");
        if (++deep > PSPLAT_TILE_MAX_FILES_DEEP)
            return refuse(r, PSPLAT_ERROR_UNSUPPORTED, 0, "too many tilesets refer to one another");
    }
    return PSPLAT_OK;
}

/* Returns how many strings of the text equal a word: no fewer than members with that name. */
static size_t count_words(const psplat_json *json, const char *word) {
    size_t count = 0;
    for (psplat_json_value i = 0; i < json->tokens[0].beyond; ++i)
        count +=
            psplat_json_type_of(json, i) == PSPLAT_JSON_STRING && psplat_json_equals(json, i, word);
    return count;
}

/* Every tile has an error and every content a uri, or it is refused; one of each more is room for
 * the tile that is being read. */
static psplat_result reserve(reader *r) {
    psplat_tileset *out = r->out;
    size_t tiles = count_words(&r->json, "geometricError") + 1;
    size_t contents = count_words(&r->json, "uri") + count_words(&r->json, "url") + 1;
    size_t transforms = count_words(&r->json, "transform") + 1;
    if (tiles > PSPLAT_TILE_MAX_COUNT || contents > PSPLAT_TILE_MAX_COUNT)
        return refuse(r, PSPLAT_ERROR_UNSUPPORTED, 0, "the tileset has too many tiles");
    size_t path = strlen(r->place->path) + 1;
    char *copy = psplat_arena_take(&out->kept, path, 1);
    out->file = psplat_arena_take(&out->kept, 1, sizeof *out->file);
    out->nodes = psplat_arena_reserve(&out->scratch, tiles + 1, sizeof *out->nodes);
    out->contents = psplat_arena_reserve(&out->scratch, contents, sizeof *out->contents);
    out->transforms = psplat_arena_reserve(&out->scratch, transforms, sizeof *out->transforms);
    r->children = psplat_arena_reserve(&out->scratch, tiles + 1, sizeof *r->children);
    r->given = psplat_arena_reserve(&out->scratch, tiles + 1, sizeof *r->given);
    if (!copy || !out->file || !out->nodes || !out->contents || !out->transforms || !r->children ||
        !r->given)
        return no_memory(r);
    memcpy(copy, r->place->path, path);
    *out->file = (psplat_tile_file){.path = copy, .referrer = r->place->referrer};
    memcpy(out->transforms[out->transform_count++], r->place->transform, sizeof *out->transforms);
    return PSPLAT_OK;
}

static psplat_result read_file(reader *r) {
    static const char *const names[] = {"asset", "geometricError", "root", "extensionsRequired"};
    psplat_json_value m[4];
    double error = 0;
    psplat_result result = psplat_json_parse(&r->json, &r->out->scratch);
    if (!result) result = check_circle(r);
    if (!result) result = psplat_json_members(&r->json, 0, names, 4, m);
    if (!result) result = check_asset(r, m[0]);
    if (!result) result = check_required(r, m[3]);
    if (!result) result = read_error(r, 0, m[1], 1, HUGE_VAL, &error);
    if (!result && !m[2]) return refuse(r, PSPLAT_ERROR_FORMAT, 0, "root is missing");
    if (!result) result = reserve(r);
    if (!result) result = read_tree(r, m[2]);
    if (!result && !r->out->content_count)
        return refuse(r, PSPLAT_ERROR_NO_SPLATS, 0, "no tile has a content");
    return result;
}

/* Puts the path before the text of an error. */
static void name_file(psplat_error *error, const char *path) {
    char text[sizeof error->text];
    if (!error) return;
    memcpy(text, error->text, sizeof text);
    psplat_fail(error, error->code, error->offset, "%.100s: %.130s", path, text);
}

psplat_result psplat_tileset_read(const void *text, size_t size, const psplat_tileset_place *place,
                                  psplat_tileset *tileset, psplat_error *error) {
    reader r = {
        .json = {.text = text, .size = size, .error = error}, .out = tileset, .place = place};
    *tileset = (psplat_tileset){.kept = {.allocator = place->allocator},
                                .scratch = {.allocator = place->allocator}};
    psplat_result result = read_file(&r);
    if (!result) return PSPLAT_OK;
    psplat_arena_release(&tileset->kept);
    psplat_arena_release(&tileset->scratch);
    name_file(error, place->path);
    return result;
}

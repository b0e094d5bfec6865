/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * appearance.c - what splats keep of textures, and the baking of the others, of vertex colours and
 * of normal maps at points of a mesh.
 *
 * The disc around a point becomes an ellipse in each image, over which the texture is averaged.
 */
#include "appearance/appearance.h"

#include "base/vector.h"
#include "material/mipmap.h"
#include "material/source_materials.h"
#include "material/texture_repeats.h"
#include "material/texture_sampling.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The greatest difference of a channel, as images store it and as a part of its range, that counts
 * as none: five steps of a byte, which is what JPEG does to a plain colour. Chosen by hand. */
static const float least_seen_difference = 0.02f;

static int is_readable(const psplat_mesh *mesh, const psplat_texture_info *texture) {
    return texture->image && texture->image->pixels && texture->texcoord < PSPLAT_TEXCOORDS &&
           mesh->corner_uvs[texture->texcoord];
}

static size_t group_of(const psplat_mesh *mesh, size_t triangle) {
    return mesh->groups ? mesh->groups[triangle] : 0;
}

/* ---- what is kept ---------------------------------------------------------------------------- */

/* Returns whether a texture in this slot of the material shows: unlit materials show their base
 * colour alone, and nothing comes of an emissive texture times a factor of 0. */
static int shows(const psplat_material *m, psplat_texture_slot slot) {
    if (slot == PSPLAT_TEXTURE_BASE_COLOR) return 1;
    if (slot == PSPLAT_TEXTURE_EMISSIVE)
        return !m->unlit && (m->emissive[0] > 0 || m->emissive[1] > 0 || m->emissive[2] > 0);
    return !m->unlit;
}

int psplat_appearance_may_keep(const psplat_mesh *mesh, const psplat_source_material *material,
                               psplat_texture_slot slot) {
    return material->material.textures[slot].image != 0 && shows(&material->material, slot) &&
           is_readable(mesh, psplat_source_texture(material, slot));
}

uint32_t psplat_appearance_set_to_keep(const psplat_mesh *mesh) {
    size_t uses[2][PSPLAT_TEXCOORDS] = {{0}}; /* of base colours, and of other textures */
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        if (group_of(mesh, t) >= mesh->source_material_count) continue;
        const psplat_source_material *m = &mesh->source_materials[group_of(mesh, t)];
        for (psplat_texture_slot slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot)
            if (psplat_appearance_may_keep(mesh, m, slot))
                ++uses[slot != PSPLAT_TEXTURE_BASE_COLOR][psplat_source_texture(m, slot)->texcoord];
    }
    for (int others = 0; others < 2; ++others) {
        uint32_t most = 0;
        for (uint32_t set = 1; set < PSPLAT_TEXCOORDS; ++set)
            if (uses[others][set] > uses[others][most]) most = set;
        if (uses[others][most]) return most;
    }
    return PSPLAT_NONE;
}

/* Sums up what the textures that a material keeps have in common. */
static void measure_kept(const psplat_source_material *material, psplat_kept_textures *kept) {
    for (int axis = 0; axis < 2; ++axis) {
        kept->repeats[axis] = psplat_textures_repeat(kept->textures, axis);
        for (psplat_texture_slot slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot) {
            double move[2];
            if (!kept->textures[slot].image) continue;
            const psplat_image *image = psplat_source_texture(material, slot)->image;
            psplat_texture_move(&kept->textures[slot], axis, move);
            kept->texels[axis] =
                max2(kept->texels[axis], hypot(image->width * move[0], image->height * move[1]));
        }
    }
}

static void keep_textures(psplat_appearance *appearance, size_t group) {
    const psplat_source_material *m = &appearance->mesh->source_materials[group];
    psplat_kept_textures *kept = &appearance->kept[group];
    int any = 0;
    for (psplat_texture_slot slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot) {
        if (!psplat_appearance_may_keep(appearance->mesh, m, slot) ||
            psplat_source_texture(m, slot)->texcoord != appearance->kept_set)
            continue;
        kept->textures[slot] = m->material.textures[slot];
        any = 1;
    }
    if (any) measure_kept(m, kept);
}

const psplat_kept_textures *psplat_appearance_kept(const psplat_appearance *appearance,
                                                   uint32_t triangle) {
    size_t group = group_of(appearance->mesh, triangle);
    if (!appearance->kept || group >= appearance->mesh->source_material_count) return NULL;
    for (psplat_texture_slot slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot)
        if (appearance->kept[group].textures[slot].image) return &appearance->kept[group];
    return NULL;
}

int psplat_appearance_shows_same(const psplat_appearance *appearance, uint32_t triangle,
                                 const double a[2], const double b[2]) {
    const psplat_kept_textures *kept = psplat_appearance_kept(appearance, triangle);
    const psplat_source_material *m;
    if (!kept) return 1;
    m = &appearance->mesh->source_materials[group_of(appearance->mesh, triangle)];
    for (psplat_texture_slot slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot) {
        const psplat_texture_info *texture = psplat_source_texture(m, slot);
        double at[2][2];
        float shown[2][4];
        if (!kept->textures[slot].image) continue;
        if (!texture->image || !texture->image->pixels) return 0;
        for (int i = 0; i < 2; ++i) {
            psplat_texture_transform(texture, i ? b : a, at[i]);
            psplat_texture_stored(texture, at[i], shown[i]);
        }
        for (int k = 0; k < 4; ++k)
            if (!(fabsf(shown[0][k] - shown[1][k]) <= least_seen_difference)) return 0;
    }
    return 1;
}

void psplat_appearance_settle_textures(const psplat_appearance *appearance, size_t group,
                                       psplat_material *material) {
    static const psplat_texture none[PSPLAT_TEXTURE_SLOTS];
    int is_kept = appearance->kept && group < appearance->mesh->source_material_count;
    memcpy(material->textures, is_kept ? appearance->kept[group].textures : none, sizeof none);
}

/* ---- building -------------------------------------------------------------------------------- */

/* Finds the mipmap of a texture, and builds it unless another texture has needed it before. *found
 * is NULL if the texture cannot be read, or is kept. */
static psplat_result find_mipmap(psplat_appearance *appearance, size_t group,
                                 psplat_texture_slot slot, const psplat_mipmap **found) {
    const psplat_texture_info *texture =
        psplat_source_texture(&appearance->mesh->source_materials[group], slot);
    int is_srgb = slot == PSPLAT_TEXTURE_BASE_COLOR || slot == PSPLAT_TEXTURE_EMISSIVE;
    *found = NULL;
    if (!is_readable(appearance->mesh, texture)) return PSPLAT_OK;
    if (appearance->kept && (appearance->kept[group].textures[slot].image ||
                             !shows(&appearance->mesh->source_materials[group].material, slot)))
        return PSPLAT_OK;
    for (size_t i = 0; i < appearance->mipmap_count; ++i)
        if (appearance->mipmaps[i].image == texture->image &&
            appearance->mipmaps[i].is_srgb == is_srgb) {
            *found = &appearance->mipmaps[i];
            return PSPLAT_OK;
        }
    psplat_mipmap *mipmap = &appearance->mipmaps[appearance->mipmap_count];
    psplat_result result = psplat_mipmap_build(texture->image, is_srgb, mipmap);
    if (result) return result;
    ++appearance->mipmap_count;
    *found = mipmap;
    return PSPLAT_OK;
}

/* Prepares the textures of one material. */
static psplat_result add_textures(psplat_appearance *appearance, size_t group) {
    psplat_material_textures *textures = &appearance->material_textures[group];
    const psplat_mipmap **const slots[PSPLAT_TEXTURE_SLOTS] = {
        [PSPLAT_TEXTURE_BASE_COLOR] = &textures->base_color,
        [PSPLAT_TEXTURE_METALLIC_ROUGHNESS] = &textures->metallic_roughness,
        [PSPLAT_TEXTURE_NORMAL] = &textures->normal,
        [PSPLAT_TEXTURE_OCCLUSION] = &textures->occlusion,
        [PSPLAT_TEXTURE_EMISSIVE] = &textures->emissive};
    psplat_result result = PSPLAT_OK;
    if (appearance->kept) keep_textures(appearance, group);
    for (psplat_texture_slot slot = 0; !result && slot < PSPLAT_TEXTURE_SLOTS; ++slot)
        result = find_mipmap(appearance, group, slot, slots[slot]);
    appearance->has_color |= textures->base_color != NULL;
    appearance->has_normals |= textures->normal != NULL;
    appearance->has_finish |= textures->metallic_roughness != NULL || textures->occlusion != NULL;
    appearance->has_emissive |= textures->emissive != NULL;
    return result;
}

/* Allocates what there is of each of count materials. */
static psplat_result allocate(psplat_appearance *appearance, size_t count, uint8_t **used) {
    *used = calloc(count, 1);
    appearance->material_textures = calloc(count, sizeof *appearance->material_textures);
    appearance->mipmaps = calloc(PSPLAT_TEXTURE_SLOTS * count, sizeof *appearance->mipmaps);
    if (appearance->kept_set != PSPLAT_NONE)
        appearance->kept = calloc(count, sizeof *appearance->kept);
    return *used && appearance->material_textures && appearance->mipmaps &&
                   (appearance->kept || appearance->kept_set == PSPLAT_NONE)
               ? PSPLAT_OK
               : PSPLAT_ERROR_MEMORY;
}

psplat_result psplat_appearance_build(const psplat_mesh *mesh, double diameter, int keeps_textures,
                                      psplat_appearance *appearance) {
    size_t count = mesh->source_material_count;
    uint8_t *used;
    *appearance = (psplat_appearance){
        .mesh = mesh,
        .diameter = diameter,
        .has_color = mesh->corner_colors != NULL,
        .kept_set = keeps_textures ? psplat_appearance_set_to_keep(mesh) : PSPLAT_NONE};
    if (!count) return PSPLAT_OK;
    psplat_result result = allocate(appearance, count, &used);
    for (size_t t = 0; !result && t < mesh->triangle_count; ++t)
        if (group_of(mesh, t) < count) used[group_of(mesh, t)] = 1;
    for (size_t i = 0; !result && i < count; ++i)
        if (used[i]) result = add_textures(appearance, i);
    free(used);
    return result;
}

void psplat_appearance_free(psplat_appearance *appearance) {
    for (size_t i = 0; i < appearance->mipmap_count; ++i)
        psplat_mipmap_free(&appearance->mipmaps[i]);
    free(appearance->mipmaps);
    free(appearance->material_textures);
    free(appearance->kept);
    *appearance = (psplat_appearance){0};
}

/* ---- points --------------------------------------------------------------------------------- */

/* A point of a mesh where textures are read. */
typedef struct texture_point {
    const psplat_appearance *appearance;
    uint32_t triangle;
    const double *barycentric;
    double edges[2][3];   /* from the first corner to the others */
    double frame[2][3];   /* unit, in the triangle's plane */
    double inverse[2][2]; /* rows: barycentric coordinates 1 and 2 per length along the frame */
    double radius;        /* of the disc that is averaged over */
} texture_point;

static texture_point point_at(const psplat_appearance *appearance, uint32_t triangle,
                              const double barycentric[3]) {
    const psplat_mesh *mesh = appearance->mesh;
    const uint32_t *v = mesh->triangles + 3 * (size_t)triangle;
    texture_point p = {.appearance = appearance,
                       .triangle = triangle,
                       .barycentric = barycentric,
                       .radius = appearance->diameter / 2};
    for (int k = 0; k < 2; ++k)
        sub3(p.edges[k], mesh->positions + 3 * (size_t)v[k + 1],
             mesh->positions + 3 * (size_t)v[0]);
    /* In the frame the edges are (a, 0) and (b, c). */
    double a = length3(p.edges[0]);
    memcpy(p.frame[0], p.edges[0], sizeof p.frame[0]);
    normalize3(p.frame[0]);
    double b = dot3(p.edges[1], p.frame[0]);
    along3(p.frame[1], p.edges[1], -b, p.frame[0]);
    double c = length3(p.frame[1]);
    normalize3(p.frame[1]);
    if (a > 0 && c > 0) {
        p.inverse[0][0] = 1 / a, p.inverse[0][1] = -b / (a * c);
        p.inverse[1][1] = 1 / c;
    }
    return p;
}

/* Stores the image coordinates of a point, and in slopes[j] their derivatives along frame[j]. */
static void coordinates(const texture_point *p, const psplat_texture_info *texture, double st[2],
                        double slopes[2][2]) {
    const float *uvs = p->appearance->mesh->corner_uvs[texture->texcoord] + 6 * (size_t)p->triangle;
    double corners[3][2];
    for (int i = 0; i < 3; ++i) {
        const double uv[2] = {(double)uvs[2 * i], (double)uvs[2 * i + 1]};
        psplat_texture_transform(texture, uv, corners[i]);
    }
    for (int k = 0; k < 2; ++k) {
        st[k] = 0;
        for (int i = 0; i < 3; ++i) st[k] += p->barycentric[i] * corners[i][k];
        double d1 = corners[1][k] - corners[0][k], d2 = corners[2][k] - corners[0][k];
        for (int j = 0; j < 2; ++j) slopes[j][k] = d1 * p->inverse[0][j] + d2 * p->inverse[1][j];
    }
}

static void read_texture(const texture_point *p, const psplat_texture_info *texture,
                         const psplat_mipmap *mipmap, float rgba[4]) {
    double st[2], axes[2][2];
    coordinates(p, texture, st, axes);
    for (int j = 0; j < 2; ++j)
        for (int k = 0; k < 2; ++k) axes[j][k] *= p->radius;
    psplat_texture_average(texture, mipmap, st, (const double(*)[2])axes, rgba);
}

/* ---- normal maps ---------------------------------------------------------------------------- */

/* Stores the mean of the tangents at the corners. Returns the sign of the bitangent, or 0 if the
 * file has no tangents. */
static double authored_tangent(const texture_point *p, double tangent[3]) {
    const float *corners = p->appearance->mesh->corner_tangents;
    double sign = 0;
    memset(tangent, 0, 3 * sizeof(double));
    if (!corners) return 0;
    for (size_t i = 0; i < 3; ++i) {
        const float *t = corners + 12 * (size_t)p->triangle + 4 * i;
        for (int k = 0; k < 3; ++k) tangent[k] += p->barycentric[i] * (double)t[k];
        sign += p->barycentric[i] * (double)t[3];
    }
    return dot3(tangent, tangent) > 0 ? (sign < 0 ? -1 : 1) : 0;
}

/* Stores the direction in which s of the image grows on the triangle. Returns 1 if the triangle
 * shows the image as it is, with t running downwards, -1 if mirrored, and 0 if the triangle is a
 * line in the image. */
static double derived_tangent(const texture_point *p, const psplat_texture_info *texture,
                              double tangent[3]) {
    double st[2], slopes[2][2];
    coordinates(p, texture, st, slopes);
    double determinant = slopes[0][0] * slopes[1][1] - slopes[1][0] * slopes[0][1];
    memset(tangent, 0, 3 * sizeof(double));
    if (!(fabs(determinant) > 0) || !isfinite(determinant)) return 0;
    /* The tangent solves ds = 1, dt = 0. */
    mad3(tangent, slopes[1][1] / determinant, p->frame[0]);
    mad3(tangent, -slopes[0][1] / determinant, p->frame[1]);
    return determinant < 0 ? 1 : -1;
}

/* Turns a normal by the normal map (glTF 2.0 section 3.9.3), whose x is along the tangent and whose
 * y is up the image. If the file has no tangents, the frame is that of the triangle. MikkTSpace
 * would smooth it over vertices, but means of the map over samples would hardly differ. */
static void apply_normal_map(const texture_point *p, const psplat_texture_info *texture,
                             const psplat_mipmap *mipmap, float normal[3]) {
    float rgba[4];
    double n[3], t[3], b[3], turned[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) n[k] = (double)normal[k];
    double sign = authored_tangent(p, t);
    if (sign == 0) sign = derived_tangent(p, texture, t);
    if (sign == 0) return;
    mad3(t, -dot3(t, n), n);
    if (!(dot3(t, t) > 0)) return;
    normalize3(t);
    cross3(b, n, t);
    read_texture(p, texture, mipmap, rgba);
    double strength = (double)texture->strength;
    mad3(turned, strength * (2 * (double)rgba[0] - 1), t);
    mad3(turned, strength * sign * (2 * (double)rgba[1] - 1), b);
    mad3(turned, 2 * (double)rgba[2] - 1, n);
    if (!(dot3(turned, turned) > 0)) return;
    normalize3(turned);
    for (int k = 0; k < 3; ++k) normal[k] = (float)turned[k];
}

/* ---- baking --------------------------------------------------------------------------------- */

static const psplat_material_textures no_textures;

/* Returns the textures of a triangle, and its material, which is NULL if the mesh has none. */
static const psplat_material_textures *textures_of(const psplat_appearance *appearance,
                                                   uint32_t triangle,
                                                   const psplat_source_material **source_material) {
    size_t group = group_of(appearance->mesh, triangle);
    *source_material = NULL;
    if (group >= appearance->mesh->source_material_count) return &no_textures;
    *source_material = &appearance->mesh->source_materials[group];
    return &appearance->material_textures[group];
}

static void multiply_corner_color(const texture_point *p, float color[4]) {
    const float *corners = p->appearance->mesh->corner_colors;
    if (!corners) return;
    for (size_t k = 0; k < 4; ++k) {
        double sum = 0;
        for (size_t i = 0; i < 3; ++i)
            sum += p->barycentric[i] * (double)corners[12 * (size_t)p->triangle + 4 * i + k];
        color[k] *= (float)min2(max2(sum, 0), 1);
    }
}

void psplat_appearance_bake(const psplat_appearance *appearance, uint32_t triangle,
                            const double barycentric[3], const float normal[3],
                            psplat_baked_point *baked) {
    const psplat_source_material *a;
    const psplat_material_textures *textures = textures_of(appearance, triangle, &a);
    texture_point p = point_at(appearance, triangle, barycentric);
    float rgba[4];
    *baked =
        (psplat_baked_point){.color = {1, 1, 1, 1}, .finish = {1, 1, 1}, .emissive = {1, 1, 1}};
    memcpy(baked->normal, normal, sizeof baked->normal);
    if (textures->base_color) read_texture(&p, &a->base_color, textures->base_color, baked->color);
    multiply_corner_color(&p, baked->color);
    if (a && !a->is_blended) baked->color[3] = 1; /* glTF 2.0 section 3.9.4 */
    if (textures->normal) apply_normal_map(&p, &a->normal, textures->normal, baked->normal);
    if (textures->occlusion) {
        read_texture(&p, &a->occlusion, textures->occlusion, rgba);
        baked->finish[0] = 1 + a->occlusion.strength * (rgba[0] - 1);
    }
    if (textures->metallic_roughness) {
        read_texture(&p, &a->metallic_roughness, textures->metallic_roughness, rgba);
        baked->finish[1] = rgba[1], baked->finish[2] = rgba[2];
    }
    if (textures->emissive) {
        read_texture(&p, &a->emissive, textures->emissive, rgba);
        memcpy(baked->emissive, rgba, sizeof baked->emissive);
    }
}

double psplat_appearance_alpha(const psplat_appearance *appearance, uint32_t triangle,
                               const double barycentric[3]) {
    const psplat_source_material *a;
    const psplat_material_textures *textures = textures_of(appearance, triangle, &a);
    float color[4] = {1, 1, 1, 1};
    if (!a || !a->is_masked) return 1;
    texture_point p = point_at(appearance, triangle, barycentric);
    if (textures->base_color) read_texture(&p, &a->base_color, textures->base_color, color);
    multiply_corner_color(&p, color);
    return (double)color[3] * (double)a->material.base_color[3];
}

/* Returns how many texels of a texture a triangle shows. */
static double texels_of(const psplat_mesh *mesh, uint32_t triangle,
                        const psplat_texture_info *texture, const psplat_mipmap *mipmap) {
    if (!mipmap) return 0;
    const float *uvs = mesh->corner_uvs[texture->texcoord] + 6 * (size_t)triangle;
    double corners[3][2];
    for (int i = 0; i < 3; ++i) {
        const double uv[2] = {(double)uvs[2 * i], (double)uvs[2 * i + 1]};
        psplat_texture_transform(texture, uv, corners[i]);
    }
    double doubled = (corners[1][0] - corners[0][0]) * (corners[2][1] - corners[0][1]) -
                     (corners[2][0] - corners[0][0]) * (corners[1][1] - corners[0][1]);
    return fabs(doubled) / 2 * mipmap->image->width * mipmap->image->height;
}

double psplat_appearance_texels(const psplat_appearance *appearance) {
    const psplat_mesh *mesh = appearance->mesh;
    double sum = 0;
    for (uint32_t t = 0; mesh && t < mesh->triangle_count; ++t) {
        const psplat_source_material *m;
        const psplat_material_textures *textures = textures_of(appearance, t, &m);
        double most = mesh->corner_colors != NULL;
        if (m) {
            most = max2(most, texels_of(mesh, t, &m->base_color, textures->base_color));
            most = max2(most, texels_of(mesh, t, &m->emissive, textures->emissive));
            most = max2(most,
                        texels_of(mesh, t, &m->metallic_roughness, textures->metallic_roughness));
        }
        sum += isfinite(most) ? most : 0;
    }
    return sum;
}

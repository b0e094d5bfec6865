/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * paint.c - what a mesh looks like at each of its points.
 */
#include "paint.h"

#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* ---- building ------------------------------------------------------------------------------- */

static int is_readable(const psplat_mesh *mesh, const psplat_texture *texture) {
    return texture->image && texture->image->pixels && texture->texcoord < PSPLAT_TEXCOORDS &&
           mesh->corner_uvs[texture->texcoord];
}

/* The pyramid of an image, built where no other texture needed it before. */
static psplat_result pyramid_of(psplat_paint *paint, const psplat_texture *texture, int is_srgb,
                                const psplat_pyramid **found) {
    *found = NULL;
    if (!is_readable(paint->mesh, texture)) return PSPLAT_OK;
    for (size_t i = 0; i < paint->pyramid_count; ++i)
        if (paint->pyramids[i].image == texture->image && paint->pyramids[i].is_srgb == is_srgb) {
            *found = &paint->pyramids[i];
            return PSPLAT_OK;
        }
    psplat_pyramid *pyramid = &paint->pyramids[paint->pyramid_count];
    psplat_result result = psplat_pyramid_build(texture->image, is_srgb, pyramid);
    if (result) return result;
    ++paint->pyramid_count;
    *found = pyramid;
    return PSPLAT_OK;
}

static psplat_result add_coat(psplat_paint *paint, const psplat_appearance *a, psplat_coat *coat) {
    psplat_result result = pyramid_of(paint, &a->base_color, 1, &coat->base_color);
    if (!result) result = pyramid_of(paint, &a->emissive, 1, &coat->emissive);
    if (!result) result = pyramid_of(paint, &a->metallic_roughness, 0, &coat->metallic_roughness);
    if (!result) result = pyramid_of(paint, &a->occlusion, 0, &coat->occlusion);
    if (!result) result = pyramid_of(paint, &a->normal, 0, &coat->normal);
    paint->has_color |= coat->base_color != NULL;
    paint->has_normals |= coat->normal != NULL;
    paint->has_finish |= coat->metallic_roughness != NULL || coat->occlusion != NULL;
    paint->has_emissive |= coat->emissive != NULL;
    return result;
}

static size_t group_of(const psplat_mesh *mesh, size_t triangle) {
    return mesh->groups ? mesh->groups[triangle] : 0;
}

psplat_result psplat_paint_build(const psplat_mesh *mesh, double diameter, psplat_paint *paint) {
    size_t count = mesh->appearance_count;
    *paint = (psplat_paint){
        .mesh = mesh, .diameter = diameter, .has_color = mesh->corner_colors != NULL};
    if (!count) return PSPLAT_OK;
    uint8_t *used = calloc(count, 1);
    paint->coats = calloc(count, sizeof *paint->coats);
    paint->pyramids = calloc(5 * count, sizeof *paint->pyramids);
    psplat_result result =
        used && paint->coats && paint->pyramids ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    for (size_t t = 0; !result && t < mesh->triangle_count; ++t)
        if (group_of(mesh, t) < count) used[group_of(mesh, t)] = 1;
    for (size_t i = 0; !result && i < count; ++i)
        if (used[i]) result = add_coat(paint, &mesh->appearances[i], &paint->coats[i]);
    free(used);
    return result;
}

void psplat_paint_free(psplat_paint *paint) {
    for (size_t i = 0; i < paint->pyramid_count; ++i) psplat_pyramid_free(&paint->pyramids[i]);
    free(paint->pyramids);
    free(paint->coats);
    *paint = (psplat_paint){0};
}

/* ---- places --------------------------------------------------------------------------------- */

/* A place of a mesh, as its textures are asked. */
typedef struct place {
    const psplat_paint *paint;
    uint32_t triangle;
    const double *barycentric;
    double edges[2][3];   /* from the first corner to the others */
    double frame[2][3];   /* unit, in the triangle's plane */
    double inverse[2][2]; /* rows: barycentric coordinates 1 and 2 per length along the frame */
    double radius;
} place;

static place place_at(const psplat_paint *paint, uint32_t triangle, const double barycentric[3]) {
    const psplat_mesh *mesh = paint->mesh;
    const uint32_t *v = mesh->triangles + 3 * (size_t)triangle;
    place p = {.paint = paint,
               .triangle = triangle,
               .barycentric = barycentric,
               .radius = paint->diameter / 2};
    for (int k = 0; k < 2; ++k)
        sub3(p.edges[k], mesh->positions + 3 * (size_t)v[k + 1],
             mesh->positions + 3 * (size_t)v[0]);
    /* Edges are (a, 0) and (b, c) in the frame. */
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

/* Image coordinates of the place, and their change along the frame: columns of slopes. */
static void coordinates(const place *p, const psplat_texture *texture, double st[2],
                        double slopes[2][2]) {
    const float *uvs = p->paint->mesh->corner_uvs[texture->texcoord] + 6 * (size_t)p->triangle;
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

static void read_texture(const place *p, const psplat_texture *texture,
                         const psplat_pyramid *pyramid, float rgba[4]) {
    double st[2], axes[2][2];
    coordinates(p, texture, st, axes);
    for (int j = 0; j < 2; ++j)
        for (int k = 0; k < 2; ++k) axes[j][k] *= p->radius;
    psplat_texture_average(texture, pyramid, st, (const double(*)[2])axes, rgba);
}

/* ---- normal maps ---------------------------------------------------------------------------- */

/* Mean of corner tangents, and the sign of the frame; 0: there are none. */
static double given_tangent(const place *p, double tangent[3]) {
    const float *corners = p->paint->mesh->corner_tangents;
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

/* The direction in which the image's s grows on the triangle, and whether the image is seen as it
 * is (1) or mirrored (-1); t runs downwards. 0: the triangle is a line in the image. */
static double derived_tangent(const place *p, const psplat_texture *texture, double tangent[3]) {
    double st[2], slopes[2][2];
    coordinates(p, texture, st, slopes);
    double determinant = slopes[0][0] * slopes[1][1] - slopes[1][0] * slopes[0][1];
    memset(tangent, 0, 3 * sizeof(double));
    if (!(fabs(determinant) > 0) || !isfinite(determinant)) return 0;
    /* Solves ds = 1, dt = 0. */
    mad3(tangent, slopes[1][1] / determinant, p->frame[0]);
    mad3(tangent, -slopes[0][1] / determinant, p->frame[1]);
    return determinant < 0 ? 1 : -1;
}

/* The normal as the map turns it (glTF 2.0 section 3.9.3): x along the tangent, y up the image. The
 * frame is that of each triangle where the file has no tangents: MikkTSpace smooths them over
 * vertices, which the map's means over samples do not tell apart. */
static void turn_normal(const place *p, const psplat_texture *texture,
                        const psplat_pyramid *pyramid, float normal[3]) {
    float rgba[4];
    double n[3], t[3], b[3], turned[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) n[k] = (double)normal[k];
    double sign = given_tangent(p, t);
    if (sign == 0) sign = derived_tangent(p, texture, t);
    if (sign == 0) return;
    mad3(t, -dot3(t, n), n);
    if (!(dot3(t, t) > 0)) return;
    normalize3(t);
    cross3(b, n, t);
    read_texture(p, texture, pyramid, rgba);
    double strength = (double)texture->strength;
    mad3(turned, strength * (2 * (double)rgba[0] - 1), t);
    mad3(turned, strength * sign * (2 * (double)rgba[1] - 1), b);
    mad3(turned, 2 * (double)rgba[2] - 1, n);
    if (!(dot3(turned, turned) > 0)) return;
    normalize3(turned);
    for (int k = 0; k < 3; ++k) normal[k] = (float)turned[k];
}

/* ---- shades --------------------------------------------------------------------------------- */

static const psplat_coat no_coat;

static const psplat_coat *coat_of(const psplat_paint *paint, uint32_t triangle,
                                  const psplat_appearance **appearance) {
    size_t group = group_of(paint->mesh, triangle);
    *appearance = NULL;
    if (group >= paint->mesh->appearance_count) return &no_coat;
    *appearance = &paint->mesh->appearances[group];
    return &paint->coats[group];
}

static void multiply_corner_color(const place *p, float color[4]) {
    const float *corners = p->paint->mesh->corner_colors;
    if (!corners) return;
    for (size_t k = 0; k < 4; ++k) {
        double sum = 0;
        for (size_t i = 0; i < 3; ++i)
            sum += p->barycentric[i] * (double)corners[12 * (size_t)p->triangle + 4 * i + k];
        color[k] *= (float)min2(max2(sum, 0), 1);
    }
}

void psplat_paint_shade(const psplat_paint *paint, uint32_t triangle, const double barycentric[3],
                        const float normal[3], psplat_shade *shade) {
    const psplat_appearance *a;
    const psplat_coat *coat = coat_of(paint, triangle, &a);
    place p = place_at(paint, triangle, barycentric);
    float rgba[4];
    *shade = (psplat_shade){.color = {1, 1, 1, 1}, .finish = {1, 1, 1}, .emissive = {1, 1, 1}};
    memcpy(shade->normal, normal, sizeof shade->normal);
    if (coat->base_color) read_texture(&p, &a->base_color, coat->base_color, shade->color);
    multiply_corner_color(&p, shade->color);
    if (a && !a->is_blended) shade->color[3] = 1; /* glTF 2.0 section 3.9.4 */
    if (coat->normal) turn_normal(&p, &a->normal, coat->normal, shade->normal);
    if (coat->occlusion) {
        read_texture(&p, &a->occlusion, coat->occlusion, rgba);
        shade->finish[0] = 1 + a->occlusion.strength * (rgba[0] - 1);
    }
    if (coat->metallic_roughness) {
        read_texture(&p, &a->metallic_roughness, coat->metallic_roughness, rgba);
        shade->finish[1] = rgba[1], shade->finish[2] = rgba[2];
    }
    if (coat->emissive) {
        read_texture(&p, &a->emissive, coat->emissive, rgba);
        memcpy(shade->emissive, rgba, sizeof shade->emissive);
    }
}

double psplat_paint_alpha(const psplat_paint *paint, uint32_t triangle,
                          const double barycentric[3]) {
    const psplat_appearance *a;
    const psplat_coat *coat = coat_of(paint, triangle, &a);
    float color[4] = {1, 1, 1, 1};
    if (!a || !a->is_masked) return 1;
    place p = place_at(paint, triangle, barycentric);
    if (coat->base_color) read_texture(&p, &a->base_color, coat->base_color, color);
    multiply_corner_color(&p, color);
    return (double)color[3] * (double)a->material.base_color[3];
}

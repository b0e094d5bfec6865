/* SPDX-License-Identifier: MIT
 *
 * textured.c - what textures do to a fragment of a splat (spec 3.11): its colour and finish, its
 * normal, and whether it is masked away.
 */
#include "reference/oracle.h"

#include <math.h>
#include <string.h>

/* ---- the images of a scene ------------------------------------------------------------------- */

/* The images that are colours, and encoded as sRGB. */
static int is_srgb(psplat_texture_slot slot) {
    return slot == PSPLAT_TEXTURE_BASE_COLOR || slot == PSPLAT_TEXTURE_EMISSIVE;
}

/* Each image is there twice, as numbers and as colours. Returns NULL where there is no such image,
 * as for a slot without a texture. */
static psplat_oracle_image *image_of(const psplat_oracle_drawing *d,
                                     const psplat_material *material, psplat_texture_slot slot) {
    size_t image = material->textures[slot].image;
    if (!image || image > d->scene->image_count || !d->scene->images[image - 1].rgba) return NULL;
    return &d->images[2 * (image - 1) + (size_t)is_srgb(slot)];
}

static psplat_result make_images(const psplat_oracle_drawing *d, const psplat_material *material,
                                 psplat_error *error) {
    for (int i = 0; i < PSPLAT_TEXTURE_SLOTS; ++i) {
        psplat_texture_slot slot = (psplat_texture_slot)i;
        psplat_oracle_image *image = image_of(d, material, slot);
        if (!image || image->level_count) continue;
        const psplat_pixels *pixels = &d->scene->images[material->textures[slot].image - 1];
        if (pixels->width < 1 || pixels->height < 1 || pixels->width > 1 << 16 ||
            pixels->height > 1 << 16)
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                               "an image is %lu x %lu pixels, not 1 to 65536",
                               (unsigned long)pixels->width, (unsigned long)pixels->height);
        if (!psplat_oracle_image_set(image, pixels, is_srgb(slot)))
            return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for an image");
    }
    return PSPLAT_OK;
}

psplat_result psplat_oracle_images_make(psplat_oracle_drawing *d, psplat_error *error) {
    size_t count = d->scene->image_count;
    psplat_result result = PSPLAT_OK;
    if (!count) return PSPLAT_OK;
    if (!d->scene->images)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "%zu images are NULL", count);
    d->images = psplat_oracle_allocate(count, 2 * sizeof *d->images);
    if (!d->images)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu images", count);
    for (size_t b = 0; b < psplat_asset_batch_count(d->scene->asset) && !result; ++b) {
        const psplat_batch *batch = psplat_asset_batch(d->scene->asset, b);
        if (batch->texcoords) result = make_images(d, &batch->material, error);
    }
    return result;
}

void psplat_oracle_images_free(psplat_oracle_drawing *d) {
    for (size_t i = 0; d->images && i < 2 * d->scene->image_count; ++i)
        psplat_oracle_image_free(&d->images[i]);
    psplat_oracle_release(d->images);
}

/* ---- coordinates ----------------------------------------------------------------------------- */

void psplat_oracle_coordinates_set(psplat_oracle_coordinates *c, const psplat_texcoord *t, double u,
                                   double v, double steps[2][2]) {
    for (int i = 0; i < 2; ++i) {
        double along_u = t->along_u[i], along_v = t->along_v[i];
        double uu = t->along_uu[i], uv = t->along_uv[i], vv = t->along_vv[i];
        c->at[i] = t->at[i] + u * along_u + v * along_v + u * u * uu + u * v * uv + v * v * vv;
        c->by[0][i] = along_u + 2 * u * uu + v * uv;
        c->by[1][i] = along_v + u * uv + 2 * v * vv;
    }
    memcpy(c->steps, steps, sizeof c->steps);
}

/* Multiplies by the matrix of KHR_texture_transform; offset is 0 for what is no point. */
static void transform(const psplat_texture *texture, const double t[2], double offset,
                      double st[2]) {
    const float *m = texture->transform;
    int is_identity = 1;
    for (int i = 0; i < 6; ++i) is_identity &= m[i] == 0;
    for (int row = 0; row < 2; ++row, m += 3)
        st[row] = is_identity ? t[row]
                              : (double)m[0] * t[0] + (double)m[1] * t[1] + offset * (double)m[2];
}

/* Samples a texture; its values are rgba. */
static void sample(const psplat_oracle_image *image, const psplat_texture *texture,
                   const psplat_oracle_coordinates *c, double rgba[4]) {
    double st[2], by_uv[2][2], by[2][2];
    transform(texture, c->at, 1, st);
    for (int k = 0; k < 2; ++k) transform(texture, c->by[k], 0, by_uv[k]);
    for (int k = 0; k < 2; ++k)
        for (int i = 0; i < 2; ++i)
            by[k][i] = c->steps[k][0] * by_uv[0][i] + c->steps[k][1] * by_uv[1][i];
    psplat_oracle_sample(image, texture, st, by, rgba);
}

/* ---- masks ----------------------------------------------------------------------------------- */

void psplat_oracle_mask_set(psplat_oracle_mask *mask, const psplat_oracle_drawing *d,
                            const psplat_batch *batch, size_t index) {
    const psplat_material *material = &batch->material;
    *mask = (psplat_oracle_mask){.cutoff = 0};
    if (!batch->texcoords || !(material->alpha_cutoff > 0)) return;
    mask->cutoff = (double)material->alpha_cutoff;
    mask->alpha = (double)material->base_color[3] * (double)batch->splats[index].color[3];
    mask->texcoord = &batch->texcoords[index];
    mask->texture = &material->textures[PSPLAT_TEXTURE_BASE_COLOR];
    mask->image = image_of(d, material, PSPLAT_TEXTURE_BASE_COLOR);
}

double psplat_oracle_mask_margin(const psplat_oracle_mask *mask, double u, double v,
                                 double steps[2][2]) {
    psplat_oracle_coordinates c;
    double rgba[4] = {1, 1, 1, 1};
    if (!(mask->cutoff > 0)) return 1;
    psplat_oracle_coordinates_set(&c, mask->texcoord, u, v, steps);
    if (mask->image) sample(mask->image, mask->texture, &c, rgba);
    return mask->alpha * rgba[3] - mask->cutoff;
}

/* ---- colour and finish ----------------------------------------------------------------------- */

void psplat_oracle_texture_surface(const psplat_oracle_drawing *d, const psplat_material *material,
                                   const psplat_oracle_coordinates *c,
                                   psplat_oracle_surface *surface) {
    const psplat_texture *textures = material->textures;
    double values[PSPLAT_TEXTURE_SLOTS][4];
    for (int i = 0; i < PSPLAT_TEXTURE_SLOTS; ++i) {
        const psplat_oracle_image *image = image_of(d, material, (psplat_texture_slot)i);
        for (int k = 0; k < 4; ++k) values[i][k] = 1;
        if (image && i != PSPLAT_TEXTURE_NORMAL) sample(image, &textures[i], c, values[i]);
    }
    for (int k = 0; k < 3; ++k) {
        surface->base[k] *= values[PSPLAT_TEXTURE_BASE_COLOR][k];
        surface->emissive[k] *= values[PSPLAT_TEXTURE_EMISSIVE][k];
    }
    surface->roughness *= values[PSPLAT_TEXTURE_METALLIC_ROUGHNESS][1];
    surface->metallic *= values[PSPLAT_TEXTURE_METALLIC_ROUGHNESS][2];
    surface->occlusion *= 1 + (double)textures[PSPLAT_TEXTURE_OCCLUSION].strength *
                                  (values[PSPLAT_TEXTURE_OCCLUSION][0] - 1);
}

/* ---- normals --------------------------------------------------------------------------------- */

int psplat_oracle_turns_normals(const psplat_oracle_drawing *d, const psplat_batch *batch) {
    return batch->texcoords && image_of(d, &batch->material, PSPLAT_TEXTURE_NORMAL) != NULL;
}

/* Finds the change of the point with the image's coordinates, in the plane that touches the
 * surface. Returns 0 where the coordinates span no plane. */
static int find_tangents(const psplat_oracle_splat *splat, const psplat_texture *texture,
                         const psplat_oracle_coordinates *c, double u, double v,
                         double tangents[2][3]) {
    double by[2][2], along[2][3];
    const double *b = splat->bend;
    /* The surface's heights, of which the derivatives by u and v are these with a minus. */
    double slope[2] = {splat->slope[0] + b[0] * u + b[1] * v,
                       splat->slope[1] + b[1] * u + b[2] * v};
    for (int k = 0; k < 2; ++k) {
        transform(texture, c->by[k], 0, by[k]);
        psplat_oracle_along(splat->axis[k], splat->is_curved ? -slope[k] : 0, splat->axis[2],
                            along[k]);
    }
    double determinant = by[0][0] * by[1][1] - by[0][1] * by[1][0];
    if (determinant == 0 || !isfinite(determinant)) return 0;
    for (int i = 0; i < 3; ++i) {
        tangents[0][i] = (by[1][1] * along[0][i] - by[0][1] * along[1][i]) / determinant;
        tangents[1][i] = (by[0][0] * along[1][i] - by[1][0] * along[0][i]) / determinant;
    }
    return 1;
}

void psplat_oracle_texture_normal(const psplat_oracle_drawing *d, const psplat_material *material,
                                  const psplat_oracle_splat *splat,
                                  const psplat_oracle_coordinates *c, double u, double v,
                                  double normal[3]) {
    const psplat_texture *texture = &material->textures[PSPLAT_TEXTURE_NORMAL];
    const psplat_oracle_image *image = image_of(d, material, PSPLAT_TEXTURE_NORMAL);
    double tangents[2][3], unit[3], across[3], value[4];
    if (!image || !find_tangents(splat, texture, c, u, v, tangents)) return;
    double length = psplat_oracle_length(normal), *t = tangents[0];
    memcpy(unit, normal, sizeof unit);
    psplat_oracle_normalise(unit);
    psplat_oracle_along(t, -psplat_oracle_dot(t, unit), unit, t);
    psplat_oracle_normalise(t);
    psplat_oracle_cross(unit, t, across);
    if (!(psplat_oracle_length(across) > 0)) return;
    double up = psplat_oracle_dot(across, tangents[1]) < 0 ? 1 : -1;
    sample(image, texture, c, value);
    for (int i = 0; i < 3; ++i) value[i] = 2 * value[i] - 1;
    for (int i = 0; i < 2; ++i) value[i] *= (double)texture->strength;
    double scale = length / psplat_oracle_length(value);
    if (!isfinite(scale)) return;
    for (int i = 0; i < 3; ++i)
        normal[i] = scale * (value[0] * t[i] + value[1] * up * across[i] + value[2] * unit[i]);
}

/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * facets_paint.c - materials and textures for drawing a mesh. Colours are decoded by GL's sRGB
 * formats; minification is GL's own, trilinear.
 */
#include "facets_paint.h"

#include <stdlib.h>
#include <string.h>

static const psplat_texture *texture_of(const psplat_appearance *a, int slot) {
    const psplat_texture *textures[PSPLAT_WALL_TEXTURES] = {
        &a->base_color, &a->metallic_roughness, &a->normal, &a->occlusion, &a->emissive};
    return textures[slot];
}

static GLint wrap_of(psplat_wrap wrap) {
    if (wrap == PSPLAT_WRAP_CLAMP) return GL_CLAMP_TO_EDGE;
    return wrap == PSPLAT_WRAP_MIRROR ? GL_MIRRORED_REPEAT : GL_REPEAT;
}

static GLuint upload(const psplat_facets_gl *gl, const psplat_texture *texture, int is_color) {
    const psplat_image *image = texture->image;
    GLuint name;
    gl->GenTextures(1, &name);
    gl->BindTexture(GL_TEXTURE_2D, name);
    gl->TexImage2D(GL_TEXTURE_2D, 0, is_color ? GL_SRGB8_ALPHA8 : GL_RGBA8, (GLsizei)image->width,
                   (GLsizei)image->height, 0, GL_RGBA, GL_UNSIGNED_BYTE, image->pixels);
    gl->GenerateMipmap(GL_TEXTURE_2D);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap_of(texture->wrap[0]));
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap_of(texture->wrap[1]));
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER,
                      texture->nearest ? GL_NEAREST : GL_LINEAR);
    gl->BindTexture(GL_TEXTURE_2D, 0);
    return name;
}

static void set_texture(const psplat_facets_gl *gl, const psplat_mesh *mesh,
                        const psplat_texture *texture, int slot, psplat_wall *wall) {
    static const double none[6];
    int has_coordinates =
        texture->texcoord < PSPLAT_TEXCOORDS && mesh->corner_uvs[texture->texcoord];
    if (!texture->image || !texture->image->pixels || !has_coordinates) return;
    int same = memcmp(texture->transform, none, sizeof none) == 0;
    for (int row = 0; row < 2; ++row)
        for (int k = 0; k < 3; ++k)
            wall->transforms[slot][row][k] =
                same ? (row == k ? 1.f : 0.f) : (GLfloat)texture->transform[3 * row + k];
    wall->sets[slot] = (GLint)texture->texcoord;
    wall->textures[slot] = upload(gl, texture, slot == 0 || slot == 4);
    if (slot == 2) wall->strengths[0] = texture->strength;
    if (slot == 3) wall->strengths[1] = texture->strength;
}

psplat_result psplat_walls_create(const psplat_facets_gl *gl, const psplat_mesh *mesh,
                                  const psplat_vertices *vertices, psplat_wall **walls,
                                  size_t *count, psplat_error *error) {
    psplat_wall *made = calloc(vertices->range_count + 1, sizeof *made);
    *walls = made;
    *count = 0;
    if (!made) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a mesh's looks");
    for (size_t i = 0; i < vertices->range_count; ++i) {
        const psplat_range *range = &vertices->ranges[i];
        psplat_wall *wall = &made[(*count)++];
        wall->first_index = range->first;
        wall->index_count = (GLsizei)range->count;
        wall->material = mesh->material;
        for (int slot = 0; slot < PSPLAT_WALL_TEXTURES; ++slot) wall->sets[slot] = -1;
        if (!mesh->appearance_count) continue;
        const psplat_appearance *appearance = &mesh->appearances[range->group];
        wall->material = appearance->material;
        wall->material.double_sided |= mesh->both_sides;
        for (int slot = 0; slot < PSPLAT_WALL_TEXTURES; ++slot)
            set_texture(gl, mesh, texture_of(appearance, slot), slot, wall);
    }
    return psplat_facets_gl_errors(gl, error);
}

void psplat_walls_destroy(const psplat_facets_gl *gl, psplat_wall *walls, size_t count) {
    for (size_t i = 0; i < count; ++i) gl->DeleteTextures(PSPLAT_WALL_TEXTURES, walls[i].textures);
    free(walls);
}

void psplat_wall_bind(const psplat_facets_gl *gl, const psplat_wall *wall, GLuint program) {
    static const GLint units[PSPLAT_WALL_TEXTURES] = {0, 1, 2, 3, 4};
    const psplat_material *m = &wall->material;
    const GLfloat surface[3] = {m->metallic, m->roughness, m->unlit ? 1.f : 0.f};
    gl->Uniform3fv(gl->GetUniformLocation(program, "u_base_color"), 1, m->base_color);
    gl->Uniform3fv(gl->GetUniformLocation(program, "u_emissive"), 1, m->emissive);
    gl->Uniform3fv(gl->GetUniformLocation(program, "u_surface"), 1, surface);
    gl->Uniform3fv(gl->GetUniformLocation(program, "u_strengths"), 1, wall->strengths);
    gl->Uniform1iv(gl->GetUniformLocation(program, "u_textures"), PSPLAT_WALL_TEXTURES, units);
    gl->Uniform1iv(gl->GetUniformLocation(program, "u_sets"), PSPLAT_WALL_TEXTURES, wall->sets);
    gl->Uniform3fv(gl->GetUniformLocation(program, "u_transforms"), 2 * PSPLAT_WALL_TEXTURES,
                   &wall->transforms[0][0][0]);
    for (GLuint i = 0; i < PSPLAT_WALL_TEXTURES; ++i) {
        gl->ActiveTexture(GL_TEXTURE0 + i);
        gl->BindTexture(GL_TEXTURE_2D, wall->textures[i]);
    }
}

void psplat_wall_unbind(const psplat_facets_gl *gl) {
    for (GLuint i = PSPLAT_WALL_TEXTURES; i-- > 0;) {
        gl->ActiveTexture(GL_TEXTURE0 + i);
        gl->BindTexture(GL_TEXTURE_2D, 0);
    }
}

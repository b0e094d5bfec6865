/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh_textures.c - the materials and textures of a mesh on the GPU. GL's sRGB formats decode
 * colours; textures are filtered trilinearly with GL's own mipmaps.
 */
#include "views/mesh_textures.h"

#include "material/image.h"
#include "material/source_materials.h"
#include "mesh/mesh.h"
#include "views/mesh_programs.h"
#include "views/vertex_buffer.h"

#include <stdlib.h>
#include <string.h>

static const psplat_texture_info *texture_of(const psplat_source_material *a, int slot) {
    const psplat_texture_info *textures[PSPLAT_MATERIAL_TEXTURES] = {
        &a->base_color, &a->metallic_roughness, &a->normal, &a->occlusion, &a->emissive};
    return textures[slot];
}

static GLint wrap_of(psplat_wrap wrap) {
    if (wrap == PSPLAT_WRAP_CLAMP) return GL_CLAMP_TO_EDGE;
    return wrap == PSPLAT_WRAP_MIRROR ? GL_MIRRORED_REPEAT : GL_REPEAT;
}

static GLuint upload(const psplat_mesh_programs *gl, const psplat_texture_info *texture,
                     int is_color) {
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

static void set_texture(const psplat_mesh_programs *gl, const psplat_mesh *mesh,
                        const psplat_texture_info *texture, int slot, psplat_drawn_group *group) {
    static const double none[6];
    int has_coordinates =
        texture->texcoord < PSPLAT_TEXCOORDS && mesh->corner_uvs[texture->texcoord];
    if (!texture->image || !texture->image->pixels || !has_coordinates) return;
    int same = memcmp(texture->transform, none, sizeof none) == 0;
    for (int row = 0; row < 2; ++row)
        for (int k = 0; k < 3; ++k)
            group->transforms[slot][row][k] =
                same ? (row == k ? 1.f : 0.f) : (GLfloat)texture->transform[3 * row + k];
    group->sets[slot] = (GLint)texture->texcoord;
    group->textures[slot] = upload(gl, texture, slot == 0 || slot == 4);
    if (slot == 2) group->strengths[0] = texture->strength;
    if (slot == 3) group->strengths[1] = texture->strength;
}

psplat_result psplat_drawn_groups_create(const psplat_mesh_programs *gl, const psplat_mesh *mesh,
                                         const psplat_vertex_buffer *vertices,
                                         psplat_drawn_group **groups, size_t *count,
                                         psplat_error *error) {
    psplat_drawn_group *made = calloc(vertices->range_count + 1, sizeof *made);
    *groups = made;
    *count = 0;
    if (!made)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a mesh's materials");
    for (size_t i = 0; i < vertices->range_count; ++i) {
        const psplat_group_range *range = &vertices->ranges[i];
        psplat_drawn_group *group = &made[(*count)++];
        group->first_index = range->first;
        group->index_count = (GLsizei)range->count;
        group->material = mesh->material;
        for (int slot = 0; slot < PSPLAT_MATERIAL_TEXTURES; ++slot) group->sets[slot] = -1;
        if (!mesh->source_material_count) continue;
        const psplat_source_material *source_material = &mesh->source_materials[range->group];
        group->material = source_material->material;
        group->material.double_sided |= psplat_mesh_shows_both_sides(mesh, range->group);
        for (int slot = 0; slot < PSPLAT_MATERIAL_TEXTURES; ++slot)
            set_texture(gl, mesh, texture_of(source_material, slot), slot, group);
    }
    return psplat_mesh_programs_errors(gl, error);
}

void psplat_drawn_groups_destroy(const psplat_mesh_programs *gl, psplat_drawn_group *groups,
                                 size_t count) {
    for (size_t i = 0; i < count; ++i)
        gl->DeleteTextures(PSPLAT_MATERIAL_TEXTURES, groups[i].textures);
    free(groups);
}

void psplat_drawn_group_bind(const psplat_mesh_programs *gl, const psplat_drawn_group *group,
                             GLuint program) {
    static const GLint units[PSPLAT_MATERIAL_TEXTURES] = {0, 1, 2, 3, 4};
    const psplat_material *m = &group->material;
    const GLfloat surface[3] = {m->metallic, m->roughness, m->unlit ? 1.f : 0.f};
    gl->Uniform3fv(gl->GetUniformLocation(program, "u_base_color"), 1, m->base_color);
    gl->Uniform3fv(gl->GetUniformLocation(program, "u_emissive"), 1, m->emissive);
    gl->Uniform3fv(gl->GetUniformLocation(program, "u_surface"), 1, surface);
    gl->Uniform3fv(gl->GetUniformLocation(program, "u_strengths"), 1, group->strengths);
    gl->Uniform1iv(gl->GetUniformLocation(program, "u_textures"), PSPLAT_MATERIAL_TEXTURES, units);
    gl->Uniform1iv(gl->GetUniformLocation(program, "u_sets"), PSPLAT_MATERIAL_TEXTURES,
                   group->sets);
    gl->Uniform3fv(gl->GetUniformLocation(program, "u_transforms"), 2 * PSPLAT_MATERIAL_TEXTURES,
                   &group->transforms[0][0][0]);
    for (GLuint i = 0; i < PSPLAT_MATERIAL_TEXTURES; ++i) {
        gl->ActiveTexture(GL_TEXTURE0 + i);
        gl->BindTexture(GL_TEXTURE_2D, group->textures[i]);
    }
}

void psplat_drawn_group_unbind(const psplat_mesh_programs *gl) {
    for (GLuint i = PSPLAT_MATERIAL_TEXTURES; i-- > 0;) {
        gl->ActiveTexture(GL_TEXTURE0 + i);
        gl->BindTexture(GL_TEXTURE_2D, 0);
    }
}

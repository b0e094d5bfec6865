/* SPDX-License-Identifier: MIT
 *
 * maps.glsl - the textures of a splat's material (spec 3.11): where a fragment lies on the images,
 * and what they make of its colour, material and normal. Only programs of batches with texture
 * coordinates have this file.
 *
 * A splat's coordinates are fetched here and not handed on by the vertex shader, because some GLs
 * have no varyings left for them. Gradients are passed to every lookup, as it may follow a discard.
 *
 * gl_program.c defines FIELD, MASK, BASE_MAP, SURFACE_MAP, NORMAL_MAP, OCCLUSION_MAP, EMISSIVE_MAP,
 * TEXCOORD_BEND and MAP_TRANSFORM. texels.glsl comes before this file.
 */
uniform highp sampler2D u_texcoords; /* layout.h */
#if BASE_MAP
uniform highp sampler2D u_base_map;
#endif
#if SURFACE_MAP
uniform highp sampler2D u_surface_map;
#endif
#if NORMAL_MAP
uniform highp sampler2D u_normal_map;
#endif
#if OCCLUSION_MAP
uniform highp sampler2D u_occlusion_map;
#endif
#if EMISSIVE_MAP
uniform highp sampler2D u_emissive_map;
#endif
#if MAP_TRANSFORM
uniform vec3 u_map_transform[2 * PSPLAT_MAP_COUNT]; /* psplat_texture.transform, row by row */
#endif
uniform vec2 u_map_strength; /* of the normal texture, of the occlusion texture */
uniform vec2 u_mask;         /* alpha of the base colour factor, alphaCutoff */

flat in float v_splat;

/* A place on the images. */
struct Place {
    vec2 at;    /* T of eq. (4c) */
    mat2 slope; /* its derivatives by u and by v */
    mat2 reach; /* its derivatives by window x and y */
    float alpha; /* of COLOR_0 */
};

/* Returns the place of a point of the splat. The columns of reach are the derivatives of (u, v) by
 * window x and y. */
Place place_on_maps(vec2 uv, mat2 reach) {
    ivec2 texel = place_of(int(v_splat));
    texel.x *= 2 + 2 * TEXCOORD_BEND;
    vec4 a = texelFetch(u_texcoords, texel, 0);
    vec3 b = texelFetch(u_texcoords, texel + ivec2(1, 0), 0).rgb;
    mat2 slope = mat2(a.z, b.x, b.y, b.z);
    vec2 at = a.xy + slope * uv;
#if TEXCOORD_BEND
    vec3 c = texelFetch(u_texcoords, texel + ivec2(2, 0), 0).rgb;
    vec3 d = texelFetch(u_texcoords, texel + ivec2(3, 0), 0).rgb;
    vec2 along_uu = c.xy, along_uv = vec2(c.z, d.x), along_vv = d.yz;
    at += uv.x * uv.x * along_uu + uv.x * uv.y * along_uv + uv.y * uv.y * along_vv;
    slope += mat2(2.0 * uv.x * along_uu + uv.y * along_uv,
                  uv.x * along_uv + 2.0 * uv.y * along_vv);
#endif
    return Place(at, slope, slope * reach, a.w);
}

#if MAP_TRANSFORM
mat2 turn_of(int slot) {
    vec3 s = u_map_transform[2 * slot], t = u_map_transform[2 * slot + 1];
    return mat2(s.x, t.x, s.y, t.y);
}
#endif

/* Samples the texture of a slot (psplat_texture_slot). */
vec4 sample_map(highp sampler2D map, int slot, Place place) {
#if MAP_TRANSFORM
    vec2 offset = vec2(u_map_transform[2 * slot].z, u_map_transform[2 * slot + 1].z);
    mat2 turn = turn_of(slot), reach = turn * place.reach;
    return textureGrad(map, turn * place.at + offset, reach[0], reach[1]);
#else
    return textureGrad(map, place.at, place.reach[0], place.reach[1]);
#endif
}

#if MASK
/* Returns whether a point of the splat is not there. */
bool is_masked(vec2 uv, mat2 reach) {
    Place place = place_on_maps(uv, reach);
    float alpha = u_mask.x * place.alpha;
#if BASE_MAP
    alpha *= sample_map(u_base_map, 0, place).a;
#endif
    return alpha < u_mask.y;
}
#endif

#if NORMAL_MAP
/* Returns the normal that the texture makes of another, eq. (4e). along_u and along_v are the
 * derivatives by u and by v of the point on the plane that touches the surface, in any one unit. */
vec3 turn_normal(Place place, vec3 normal, vec3 along_u, vec3 along_v) {
    mat2 slope = place.slope;
#if MAP_TRANSFORM
    slope = turn_of(2) * slope;
#endif
    float area = determinant(slope), size = length(normal);
    vec3 n = normal / size;
    /* dp/dS, times the magnitude of the area. */
    vec3 along_s = sign(area) * (along_u * slope[1].y - along_v * slope[0].y);
    vec3 along_t = sign(area) * (along_v * slope[0].x - along_u * slope[1].x);
    vec3 tangent = along_s - n * dot(n, along_s);
    float length2 = dot(tangent, tangent);
    if (!(length2 > 0.0)) return normal;
    tangent *= inversesqrt(length2);
    vec3 bitangent = cross(n, tangent);
    if (dot(bitangent, along_t) > 0.0) bitangent = -bitangent;
    vec3 turn = 2.0 * sample_map(u_normal_map, 2, place).rgb - 1.0;
    turn.xy *= u_map_strength.x;
    float turn2 = dot(turn, turn);
    if (!(turn2 > 0.0)) return normal;
    turn *= size * inversesqrt(turn2);
    return turn.x * tangent + turn.y * bitangent + turn.z * n;
}
#endif

/* Multiplies what eq. (4d) says: colour, occlusion with roughness and metallic, emission. */
void apply_maps(Place place, inout vec3 color, inout vec3 surface, inout vec3 emissive) {
#if BASE_MAP
    color *= sample_map(u_base_map, 0, place).rgb;
#endif
#if SURFACE_MAP
    surface.yz *= sample_map(u_surface_map, 1, place).gb;
#endif
#if OCCLUSION_MAP
    surface.x *= 1.0 + u_map_strength.y * (sample_map(u_occlusion_map, 3, place).r - 1.0);
#endif
#if EMISSIVE_MAP
    emissive *= sample_map(u_emissive_map, 4, place).rgb;
#endif
}

/* Returns where the textures of a fragment are sampled: at its own point, or for splats that have
 * one colour each at their centre, filtered over the splat (spec 5.7). */
Place place_of_colors(vec2 uv, mat2 reach) {
#if FIELD
    return place_on_maps(uv, reach);
#else
    return place_on_maps(vec2(0.0), mat2(1.0));
#endif
}

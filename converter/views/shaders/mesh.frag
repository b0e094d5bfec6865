/* SPDX-License-Identifier: MIT
 *
 * mesh.frag - the fragment shader of the mesh renderer. It writes the lit colour, with the textures of
 * glTF 2.0 section 3.9, or, if NORMALS is 1, the interpolated normal. It is written independently of
 * the converter's baking of textures (appearance.c).
 */
in vec3 v_position;
in vec3 v_ray;
in vec3 v_normal;
in vec3 v_color;
in vec4 v_texcoords;

uniform vec3 u_base_color;
uniform int u_two_sided;

/* The order of textures is base colour, metallic-roughness, normal, occlusion, emissive. */
uniform sampler2D u_textures[5];
uniform int u_sets[5];         /* of texture coordinates; -1 without a texture */
uniform vec3 u_transforms[10]; /* 2 x 3 matrices of (s, t, 1), by rows */
uniform vec3 u_strengths;      /* of the normal's and the occlusion's texture */

layout(location = 0) out vec4 o_color;

vec2 place(int slot) {
    vec3 uv = vec3(u_sets[slot] == 1 ? v_texcoords.zw : v_texcoords.xy, 1.0);
    return vec2(dot(u_transforms[2 * slot], uv), dot(u_transforms[2 * slot + 1], uv));
}

/* Returns the normal with the normal map applied: x of the map points along s, y against t. */
vec3 turned(vec3 normal) {
    vec2 st = place(2);
    vec3 across = dFdx(v_position), down = dFdy(v_position);
    vec2 st_across = dFdx(st), st_down = dFdy(st);
    float mirrored = st_across.x * st_down.y - st_down.x * st_across.y;
    vec3 n = normalize(normal);
    vec3 tangent = (across * st_down.y - down * st_across.y) * (mirrored < 0.0 ? -1.0 : 1.0);
    vec3 upward = (across * st_down.x - down * st_across.x) * (mirrored < 0.0 ? -1.0 : 1.0);
    tangent -= dot(tangent, n) * n;
    if (!(dot(tangent, tangent) > 0.0)) return normal;
    tangent = normalize(tangent);
    vec3 side = cross(n, tangent);
    if (dot(side, upward) < 0.0) side = -side;
    vec3 map = 2.0 * texture(u_textures[2], st).xyz - 1.0;
    return normalize(u_strengths.x * (map.x * tangent + map.y * side) + map.z * n);
}

#if !NORMALS
vec3 lit(vec3 normal) {
    surface s = plain_surface(u_base_color * v_color);
    if (u_sets[0] >= 0) s.color *= texture(u_textures[0], place(0)).rgb;
    if (u_sets[1] >= 0) {
        vec3 finish = texture(u_textures[1], place(1)).rgb;
        s.roughness *= finish.g;
        s.metallic *= finish.b;
    }
    if (u_sets[3] >= 0)
        s.occlusion = 1.0 + u_strengths.y * (texture(u_textures[3], place(3)).r - 1.0);
    if (u_sets[4] >= 0) s.emissive *= texture(u_textures[4], place(4)).rgb;
    return light_finished(normal, -normalize(v_ray), s);
}
#endif

void main() {
    vec3 normal = v_normal;
    if (u_sets[2] >= 0) normal = turned(normal);
#if NORMALS
    o_color = vec4(normal, 1.0);
#else
    o_color = vec4(encode(lit(u_two_sided != 0 && !gl_FrontFacing ? -normal : normal)), 1.0);
#endif
}

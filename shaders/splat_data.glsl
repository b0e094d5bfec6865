/* SPDX-License-Identifier: MIT
 *
 * splat_data.glsl - the head of both vertex shaders of splats: the textures that splats are pulled
 * from by gl_VertexID (layout.h), the matrices, and what both read in the same way.
 *
 * What depends on the item comes with each instance where INSTANCED is defined, so that one call
 * draws many items, and from uniforms where it is not, as in three.js.
 *
 * gl_program.c defines INSTANCED, WIDE, SHAPE, BENDS, COLOR, FINISH, FIELD and FADE. texels.glsl comes before
 * this file.
 */
uniform highp sampler2D u_splats;
uniform highp sampler2D u_clips;
uniform mat4 u_projection;
uniform vec3 u_half_viewport; /* half the width and height in pixels, half the depth range */
uniform vec3 u_shift; /* psplat_camera.shift, see shift_of(); where not INSTANCED z is epsilon() */
#ifdef INSTANCED
layout(location = PSPLAT_ATTRIBUTE_MODELVIEW) in mat3x4 a_modelview;
layout(location = PSPLAT_ATTRIBUTE_NORMAL) in mat3x4 a_normal;
layout(location = PSPLAT_ATTRIBUTE_FIRST) in ivec2 a_first;
#else
uniform mat4 u_modelview;
uniform mat3 u_normal_matrix;
uniform float u_unstretch;
uniform int u_first_index;
#endif
#if FADE
flat out float v_fade; /* the factor of weights; only programs of faded items have it */
#endif

/* Returns the matrix from object to eye space. */
mat4x3 modelview() {
#ifdef INSTANCED
    return transpose(a_modelview);
#else
    return mat4x3(u_modelview);
#endif
}

/* Returns the matrix of normals from object to eye space (spec 4). */
mat3 normal_matrix() {
#ifdef INSTANCED
    return transpose(mat3(a_normal));
#else
    return u_normal_matrix;
#endif
}

/* Returns epsilon of eq. (5) without its cosine, in eye space. */
float epsilon() {
#ifdef INSTANCED
    return a_normal[0].w;
#else
    return u_shift.z;
#endif
}

/* Returns what turns lengths in eye space into those of object space, on average. */
float unstretch() {
#ifdef INSTANCED
    return a_normal[1].w;
#else
    return u_unstretch;
#endif
}

/* Sets the factor of weights. Only instances are faded. */
void find_fade() {
#if FADE
    v_fade = a_normal[2].w;
#endif
}

/* Returns the first splat that is drawn. */
int first_splat() {
#ifdef INSTANCED
    return a_first.x;
#else
    return 0;
#endif
}

/* Returns the batch's first splat, counted over all batches. */
int first_index() {
#ifdef INSTANCED
    return a_first.y & 0x7fffffff;
#else
    return u_first_index;
#endif
}

/* Returns where all corners of a splat go that is not drawn. Mesa's llvmpipe takes all triangles of
 * a call through a slow path where one vertex lies outside of the view, and drops what lies outside
 * as a whole early on it. So they go into the view where next to no other vertex lies outside. */
vec4 nowhere() {
#ifdef INSTANCED
    if (a_first.y < 0) return vec4(2.0, 2.0, 2.0, 1.0);
#endif
    return vec4(0.0, 0.0, 0.0, 1.0);
}

/* Returns the first texel of a splat. */
ivec2 texel_of(ivec2 place) {
    return ivec2(place.x * (PSPLAT_SPLAT_TEXELS + WIDE + SHAPE), place.y);
}

/* Returns the rotation matrix of a quaternion times |q|^2: its columns are |q|^2 U, V, N. */
mat3 axes_of(vec4 q) {
    vec3 s = q.xyz * q.xyz;
    vec3 p = q.xyz * q.yzx; /* xy, yz, zx */
    vec3 w = q.xyz * q.w;
    float d = q.w * q.w;
    return mat3(vec3(d + s.x - s.y - s.z, 2.0 * (p.x + w.z), 2.0 * (p.z - w.y)),
                vec3(2.0 * (p.x - w.z), d - s.x + s.y - s.z, 2.0 * (p.y + w.x)),
                vec3(2.0 * (p.z + w.y), 2.0 * (p.y - w.x), d - s.x - s.y + s.z));
}

/* ---- rectangles around what is seen of a splat ---------------------------------------------- */

/* Four numbers say how far what is seen of the unit disc reaches: along a direction, against it, and to
 * both sides across it. */
const vec4 WHOLE_DISC = vec4(1.0), NOTHING = vec4(-1.0);

/* Cuts away what a line (a, b, c) does not keep, which is where a u + b v + c < 0. What is left
 * reaches as far as the circle, or as the end of the chord. Lines have a thousandth of the radius of
 * room. */
vec4 cut_disc(vec4 reach, vec2 aside, vec3 line) {
    float size = length(line.xy);
    if (line.z >= size) return reach;
    if (line.z < -size) return NOTHING;
    float offset = line.z / size + 1e-3, half_chord = sqrt(max(1.0 - offset * offset, 0.0));
    vec2 to = vec2(dot(line.xy, aside), aside.x * line.y - aside.y * line.x) / size;
    vec4 towards = vec4(to.x, -to.x, to.y, -to.y);
    vec4 chord = half_chord * abs(towards.zzxx) - offset * towards;
    return min(reach, mix(chord, vec4(1.0), greaterThanEqual(towards, vec4(-offset))));
}

/* Returns whether lines that exclude each other have left nothing. */
bool is_nothing(vec4 reach) {
    return min(reach.x + reach.y, reach.z + reach.w) < 0.0;
}

/* Returns the straight line, with (a, b) of length 1, that keeps what a line does of the disc; of a
 * bent one it keeps more. A point s beyond the centre towards (a, b) is kept where
 * s + c + kappa across^2 / 2 >= 0, and across^2 <= 1 - s^2; at the least s both are equal. Lines may
 * be so short that squares of a and b are 0. */
vec3 straightened(vec4 line) {
    float most = max(abs(line.x), abs(line.y));
    vec2 ab = line.xy / most;
    float size = length(ab), c = clamp(line.z / most / size, -1e3, 1e3);
#if BENDS
    float kappa = clamp(line.w * most * size, 0.0, 1e3);
    float square = 1.0 + kappa * (2.0 * c + kappa);
    c = square < -1e-5 ? -2.0 : (2.0 * c + kappa) / (1.0 + sqrt(max(square, 0.0)));
#endif
    return vec3(ab / size, c);
}

/* Returns by how much the half axes of a rectangle have to grow, as parts of themselves, so that
 * its sides move outwards by a 128th of a pixel: rasterisers round corners to a 256th. Its centre
 * and half axes are in clip space, without z. A centre beside the eye, where w is 0, has no pixels. */
vec2 room_of(vec3 center, vec3 across, vec3 along) {
    if (abs(center.z) <= 1e-4 * (abs(across.z) + abs(along.z))) return vec2(0.01);
    vec2 ndc = center.xy / center.z;
    vec2 p = u_half_viewport.xy * (across.xy - ndc * across.z) / center.z;
    vec2 q = u_half_viewport.xy * (along.xy - ndc * along.z) / center.z;
    float area = max(abs(p.x * q.y - p.y * q.x), 1e-12);
    return min(vec2(length(q), length(p)) / (128.0 * area), 100.0);
}

#if FINISH
/* The attributes of spec 3.10, without the factors that all splats share. */
struct Finish {
    vec3 color, color_u, color_v; /* color_u and color_v only for linear fields */
    vec3 surface;                 /* occlusion, roughness, metallic */
    vec3 emissive;
};

Finish finish_of(ivec2 place) {
    ivec2 texel = finish_texel_of(place);
    Finish finish = Finish(vec3(1.0), vec3(0.0), vec3(0.0), vec3(1.0), vec3(1.0));
    if ((u_finish & PSPLAT_FINISH_COLOR) > 0)
        finish.color = texelFetch(u_splats, texel_of(place) + ivec2(3, 0), 0).rgb;
    read_surface(texel, finish.surface, finish.emissive);
#if FIELD
    if ((u_finish & PSPLAT_FINISH_GRADIENT) > 0) {
        finish.color_u = texelFetch(u_finishes, texel, 0).rgb;
        finish.color_v = texelFetch(u_finishes, texel + ivec2(1, 0), 0).rgb;
    }
#endif
    return finish;
}
#endif

/* SPDX-License-Identifier: MIT
 *
 * Once per pixel: divides the sums by their weight (spec 5.4), shades (spec 5.6), writes colour and
 * the blended window depth (spec 5.5) into the host's framebuffer.
 *
 * Defined outside: PASS, MATERIALS, HALF_TARGETS.
 */
uniform highp sampler2D u_target0;
uniform highp sampler2D u_target1;
uniform highp sampler2D u_target2;
uniform highp sampler2D u_target3;
uniform highp sampler2D u_depth;
uniform ivec2 u_origin;
uniform mat3 u_ray;
uniform vec3 u_emissive;
uniform vec3 u_surface;
uniform int u_linear_output;

layout(location = 0) out vec4 o_color;

vec3 encode_srgb(vec3 linear) {
    vec3 c = clamp(linear, 0.0, 1.0);
    vec3 high = 1.055 * pow(max(c, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055;
    return mix(high, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

#if PASS == PSPLAT_PASS_PHONG
vec3 shade_sums(ivec2 pixel, vec4 sum0, vec4 sum1) {
    vec3 emissive = u_emissive;
    vec3 surface = u_surface;
#if MATERIALS
    vec4 sum2 = texelFetch(u_target2, pixel, 0) / sum0.a;
    vec4 sum3 = texelFetch(u_target3, pixel, 0) / sum0.a;
    emissive = sum2.rgb;
    surface = vec3(sum2.a, sum3.xy);
#endif
    vec3 view = -normalize(u_ray * vec3(gl_FragCoord.xy - vec2(u_origin), 1.0));
    return shade(sum0.xyz, view, sum1.rgb / sum0.a, emissive, surface);
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy) - u_origin;
    vec4 sum0 = texelFetch(u_target0, pixel, 0);
    if (!(sum0.a > 0.0)) discard;
    vec4 sum1 = texelFetch(u_target1, pixel, 0);

#if HALF_TARGETS
    /* Eleven bits are no depth: take that of the visibility pass, epsilon behind the nearest. */
    gl_FragDepth = texelFetch(u_depth, pixel, 0).r;
#else
    gl_FragDepth = sum1.a / sum0.a;
#endif

#if PASS == PSPLAT_PASS_PARAMETERS
    o_color = vec4(sum0.xyz, 1.0);
#else
#if PASS == PSPLAT_PASS_PHONG
    vec3 color = shade_sums(pixel, sum0, sum1);
#else
    vec3 color = sum0.rgb / sum0.a;
#endif
    o_color = vec4(u_linear_output != 0 ? color : encode_srgb(color), 1.0);
#endif
}

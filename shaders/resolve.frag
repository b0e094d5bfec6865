/* SPDX-License-Identifier: MIT
 *
 * resolve.frag - the resolve pass, deferred shading once per pixel: divides the sums by their
 * weight (spec 5.4), calls resolve() of one of the files resolve_*.glsl for a colour, and writes
 * the colour and the blended window depth (spec 5.5) to the host's framebuffer.
 *
 * gl_program.c defines AS_IS (the sum is a colour already), COLORS, MATERIALS, EMISSIVE, OCCLUSION,
 * HALF_TARGETS and ENCODE; and HOST_RESOLVE where a host's function takes the place of those files
 * and writes the outputs itself (psplat_resolve). resolve_inputs.glsl comes before this file.
 */
#ifndef EMISSIVE
#define EMISSIVE MATERIALS
#endif

#ifndef HANDED_ON
uniform highp sampler2D u_target0;
uniform highp sampler2D u_target1;
uniform highp sampler2D u_target2;
uniform highp sampler2D u_target3;
uniform highp sampler2D u_depth;
uniform ivec2 u_origin; /* lower left pixel of the view in the host's framebuffer */
uniform vec2 u_to_host; /* factor and offset from window depth to the host's window depth */
uniform vec3 u_base_color;
uniform vec3 u_emissive;
uniform vec3 u_surface; /* metallic, roughness, unlit */

vec4 target_at(highp sampler2D target, ivec2 at) {
    return texelFetch(target, at, 0);
}
#endif

#ifndef HOST_RESOLVE
layout(location = 0) out vec4 o_color;
#endif

/* The blended attributes of a pixel. */
struct Pixel {
    vec3 window;   /* pixel x and y in the view, window depth */
    vec3 normal;   /* of any length; in passes other than NORMALS, radiance or (u, v, index) */
    float weight;  /* 0: no splat covers the pixel, and the other members are undefined */
    vec3 color;    /* base colour */
    vec3 emissive;
    vec4 surface;  /* metallic, roughness, unlit, occlusion */
};

/* Reads the sums of a pixel and divides them by its weight. */
Pixel pixel_at(ivec2 at) {
    vec4 sum = target_at(u_target0, at);
    float behind = target_at(u_depth, at).r; /* 1: no splat covers the pixel (spec 5.3) */
    vec3 depth = target_at(u_target1, at).rgb;
    float scale = 1.0 / sum.a;
    Pixel pixel = Pixel(vec3(vec2(at) + 0.5, depth.r * scale), sum.rgb,
                        behind < 1.0 ? sum.a : 0.0, u_base_color, u_emissive, vec4(u_surface, 1.0));
#if HALF_TARGETS
    /* The eleven bits of a half float are too few for depth, so this is the depth of the visibility
     * pass, which is epsilon of eq. (5) behind the nearest splat. */
    pixel.window.z = behind;
#endif
#if COLORS
    vec4 colors = target_at(u_target2, at) * scale;
    pixel.color = colors.rgb;
#endif
#if EMISSIVE
    vec4 surface = target_at(u_target3, at) * scale;
    pixel.emissive = surface.rgb;
    pixel.surface.xyz = vec3(colors.a, surface.a, depth.g * scale);
#elif MATERIALS
    pixel.surface.xy = vec2(colors.a, depth.g * scale);
#endif
#if OCCLUSION
    pixel.surface.w = depth.b * scale;
#endif
    return pixel;
}

/* The sRGB transfer function. 1.055 c^(1/2.4) - 0.055 is a polynomial in the fourth root here, with
 * an error of at most 3.5e-5, less than a hundredth of a step of 8 bits. */
vec3 encode_srgb(vec3 linear) {
    vec3 c = clamp(linear, 0.0, 1.0);
    vec3 t = sqrt(sqrt(c));
    vec3 high = -0.0646115 + t * (0.1961359 + t * (1.1226817 + t * (-0.3355016 + t * 0.0813300)));
    return mix(high, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

/* Encodes a colour where the view asks for it. Shadings that show numbers do not call it. */
vec3 encode(vec3 linear) {
#if ENCODE
    return encode_srgb(linear);
#else
    return linear;
#endif
}

#ifdef HOST_RESOLVE
void resolve(Pixel pixel);
#else
/* Returns the colour of a pixel; the files resolve_*.glsl define it. */
vec3 resolve(Pixel pixel);
#endif

void main() {
    Pixel pixel = pixel_at(ivec2(gl_FragCoord.xy) - u_origin);
    if (!(pixel.weight > 0.0)) discard;
    gl_FragDepth = pixel.window.z * u_to_host.x + u_to_host.y;
#ifdef HOST_RESOLVE
    resolve(pixel);
#elif AS_IS
    o_color = vec4(encode(pixel.normal / pixel.weight), 1.0);
#else
    o_color = vec4(resolve(pixel), 1.0);
#endif
}

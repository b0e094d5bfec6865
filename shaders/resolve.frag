/* SPDX-License-Identifier: MIT
 *
 * Once per pixel: divides the sums by their weight (spec 5.4), lets one of the files resolve_*.glsl
 * make a colour of them, writes it and the blended window depth (spec 5.5) into the host's
 * framebuffer.
 *
 * Defined outside: AS_IS (what was summed is a colour), COLORS, MATERIALS, OCCLUSION, HALF_TARGETS, ENCODE.
 */
uniform highp sampler2D u_target0;
uniform highp sampler2D u_target1;
uniform highp sampler2D u_target2;
uniform highp sampler2D u_target3;
uniform highp sampler2D u_depth;
uniform ivec2 u_origin;
uniform vec2 u_to_host; /* window depth as the host's planes have it: factor, offset */
uniform vec3 u_base_color;
uniform vec3 u_emissive;
uniform vec3 u_surface;

layout(location = 0) out vec4 o_color;

/* What the splats of a pixel amount to. */
struct Pixel {
    vec3 window;   /* pixel x and y in the view, window depth */
    vec3 normal;   /* any length; of the other passes what they sum */
    float weight;  /* 0: nothing is here, and the rest is undefined */
    vec3 color;    /* base colour */
    vec3 emissive;
    vec4 surface;  /* metallic, roughness, unlit, occlusion */
};

Pixel pixel_at(ivec2 at) {
    vec4 sum = texelFetch(u_target0, at, 0);
    float behind = texelFetch(u_depth, at, 0).r; /* 1: no splat covers the pixel (spec 5.3) */
    vec3 depth = texelFetch(u_target1, at, 0).rgb;
    float scale = 1.0 / sum.a;
    Pixel pixel = Pixel(vec3(vec2(at) + 0.5, depth.r * scale), sum.rgb,
                        behind < 1.0 ? sum.a : 0.0, u_base_color, u_emissive, vec4(u_surface, 1.0));
#if HALF_TARGETS
    /* Eleven bits are no depth: take that of the visibility pass, epsilon behind the nearest. */
    pixel.window.z = behind;
#endif
#if COLORS
    vec4 colors = texelFetch(u_target2, at, 0) * scale;
    pixel.color = colors.rgb;
#endif
#if MATERIALS
    vec4 surface = texelFetch(u_target3, at, 0) * scale;
    pixel.emissive = surface.rgb;
    pixel.surface.xyz = vec3(colors.a, surface.a, depth.g * scale);
#endif
#if OCCLUSION
    pixel.surface.w = depth.b * scale;
#endif
    return pixel;
}

/* 1.055 c^(1/2.4) - 0.055 as a polynomial in the fourth root, which is off by 3.5e-5 at most, less
 * than a hundredth of a step of 8 bits. */
vec3 encode_srgb(vec3 linear) {
    vec3 c = clamp(linear, 0.0, 1.0);
    vec3 t = sqrt(sqrt(c));
    vec3 high = -0.0646115 + t * (0.1961359 + t * (1.1226817 + t * (-0.3355016 + t * 0.0813300)));
    return mix(high, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

/* For light; colours that stand for numbers are written as they are. */
vec3 encode(vec3 linear) {
#if ENCODE
    return encode_srgb(linear);
#else
    return linear;
#endif
}

/* Of the files resolve_*.glsl. */
vec3 resolve(Pixel pixel);

void main() {
    Pixel pixel = pixel_at(ivec2(gl_FragCoord.xy) - u_origin);
    if (!(pixel.weight > 0.0)) discard;
    gl_FragDepth = pixel.window.z * u_to_host.x + u_to_host.y;
#if AS_IS
    o_color = vec4(encode(pixel.normal / pixel.weight), 1.0);
#else
    o_color = vec4(resolve(pixel), 1.0);
#endif
}

/* SPDX-License-Identifier: MIT
 *
 * resolve_toon.glsl - toon shading: light in three steps, with black contours where depth or normal
 * jump (BHZK05 section 6). Depths are compared with the plane through the pixel, so that slanted
 * surfaces have no contours inside. Normals are compared between the pixel's neighbours on opposite
 * sides, because the pixel itself may blend both sides of a crease.
 */
/* Both bounds are chosen by hand. */
const float DEPTH_JUMP = 0.02;   /* part of the eye's distance; larger jumps are contours */
const float CREASE_COSINE = 0.7; /* between normals; creases with less are contours */

vec3 unit(vec3 v) {
    return v * inversesqrt(max(dot(v, v), 1e-30));
}

/* Returns whether the surface ends between the pixel and a neighbour. Where depth jumps, only the
 * nearer side gets the contour. */
bool ends(vec3 position, vec3 normal, Pixel other) {
    if (!(other.weight > 0.0)) return true;
    vec3 away = position_of(other.window) - position;
    return abs(dot(away, normal)) > DEPTH_JUMP * -position.z && away.z < 0.0;
}

bool is_contour(Pixel pixel, vec3 normal, ivec2 step) {
    ivec2 at = ivec2(pixel.window.xy);
    /* Neighbours beyond the edge of the view count as the pixel itself: no contour is there. */
    ivec2 last = textureSize(u_target0, 0) - 1;
    Pixel before = pixel_at(max(at - step, 0)), after = pixel_at(min(at + step, last));
    vec3 position = position_of(pixel.window);
    return ends(position, normal, before) || ends(position, normal, after) ||
           dot(unit(before.normal), unit(after.normal)) < CREASE_COSINE;
}

vec3 resolve(Pixel pixel) {
    vec3 normal = unit(pixel.normal);
    if (is_contour(pixel, normal, ivec2(1, 0)) || is_contour(pixel, normal, ivec2(0, 1)))
        return vec3(0.0);
    vec3 white = shade(normal, pixel.window, vec3(1.0), vec3(0.0), vec4(0.0, 1.0, 0.0, 1.0));
    float light = dot(white, vec3(0.2126, 0.7152, 0.0722));
    float level = light < 0.25 ? 0.3 : light < 0.65 ? 0.65 : 1.0;
    return encode(level * pixel.color + pixel.emissive);
}

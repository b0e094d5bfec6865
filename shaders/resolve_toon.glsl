/* SPDX-License-Identifier: MIT
 *
 * Light in three steps, black contours where depth or normal jump (BHZK05 section 6). Depths are
 * compared with the plane through the pixel, so that slanted surfaces have no contours inside;
 * normals across the pixel, as it may itself blend both sides of a crease.
 */
const float STEP = 0.02; /* of the distance: larger jumps of depth are contours */
const float TURN = 0.7;  /* cosine between normals below which a crease is a contour */

vec3 unit(vec3 v) {
    return v * inversesqrt(max(dot(v, v), 1e-30));
}

/* Whether the surface ends towards a neighbour; of a jump only the nearer side is drawn. */
bool ends(vec3 position, vec3 normal, Pixel other) {
    if (!(other.weight > 0.0)) return true;
    vec3 away = position_of(other.window) - position;
    return abs(dot(away, normal)) > STEP * -position.z && away.z < 0.0;
}

bool is_contour(Pixel pixel, vec3 normal, ivec2 step) {
    ivec2 at = ivec2(pixel.window.xy);
    ivec2 last = textureSize(u_target0, 0) - 1; /* surfaces go on beyond the edge of the view */
    Pixel before = pixel_at(max(at - step, 0)), after = pixel_at(min(at + step, last));
    vec3 position = position_of(pixel.window);
    return ends(position, normal, before) || ends(position, normal, after) ||
           dot(unit(before.normal), unit(after.normal)) < TURN;
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

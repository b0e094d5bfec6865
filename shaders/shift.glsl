/* SPDX-License-Identifier: MIT
 *
 * shift.glsl - view rays, and by how much the visibility pass moves a point away from the eye (spec
 * 5.3). Flat splats are shifted at their corners, curved ones at each fragment. The shading `splats`
 * shifts whole splats, too, so that those of one plane keep an order.
 */
uniform vec3 u_view_direction; /* of orthographic views, away from the eye; 0 0 0 in perspective */

/* Returns the view ray of a point, away from the eye and of any length. */
vec3 view_ray(vec3 eye) {
    return u_shift.y > 0.0 ? eye : u_view_direction;
}

#if PASS == PSPLAT_PASS_VISIBILITY
/* Returns 1 / max(|cos|, 1/2) of eq. (5) for the angle between the splat's normal and the view ray.
 */
float grazing_of(vec3 normal, vec3 ray) {
    float projected = dot(normal, ray), both = dot(normal, normal) * dot(ray, ray);
    return sqrt(both / max(projected * projected, 0.25 * both));
}

/* Returns what to add to gl_Position.z so that the point lies epsilon further along its own view
 * ray (spec 5.3). With p the point and s = 1 + epsilon / |p| the shifted point is s p, and
 * z'/w' = (z_row.xyz * s p + z_row.w) / (s w). Over the old w that is
 * z - z_row.w * epsilon / (|p| + epsilon). x, y and w stay, so both passes rasterise the same
 * pixels.
 *
 * Epsilon is at least 2^-20 of the distance times grazing (spec 5.3). The shift is at least 2^-20
 * of w, eight steps of a 24-bit depth buffer; but this least shift does not move a point beyond the
 * far plane, because then nothing would tell that the pixel is covered. Between the corners of a
 * splat of radius R at distance D the shift has an error of up to (2 R / D)^2 of epsilon. */
float shift_of(vec3 eye, vec2 zw, float grazing) {
    float distance = length(eye);
    float shift = max(epsilon(), 9.5367431640625e-7 * distance) * grazing;
    float bottom = u_shift.y > 0.0 ? distance + shift : 1.0;
    float room = zw.y * (1.0 - 1.1920929e-7) - zw.x;
    float least = abs(zw.y) * 9.5367431640625e-7;
    if (room > 0.0) least = min(least, room);
    return max(u_shift.x * shift / bottom, least);
}
#endif

#if PASS == PSPLAT_PASS_PARAMETERS
uniform float u_apart; /* of the depth range, in normalised device coordinates; 0: none */

/* Returns by how much a splat moves away from the eye so that, of several in one plane, the same one
 * is the nearest from everywhere. Otherwise rounding would decide, pixel by pixel. */
float apart_of(float index) {
    return u_apart * fract(index * 0.61803399);
}
#endif

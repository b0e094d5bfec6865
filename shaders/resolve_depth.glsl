/* SPDX-License-Identifier: MIT
 *
 * Distance along the view direction: 1 at the near plane, 0 at the far one; near / distance where
 * the far plane is at infinity.
 */
uniform vec3 u_planes; /* near, 1 / (far - near), whether far is finite */

vec3 resolve(Pixel pixel) {
    float distance = -position_of(pixel.window).z;
    float grey = u_planes.z > 0.0 ? 1.0 - (distance - u_planes.x) * u_planes.y
                                  : u_planes.x / distance;
    return vec3(grey);
}

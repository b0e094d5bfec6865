/* SPDX-License-Identifier: MIT
 *
 * resolve_depth.glsl - debug shading: the distance along the view direction as grey, 1 at the near
 * plane and 0 at the far one. Where the far plane is at infinity it is near / distance.
 */
uniform vec3 u_planes; /* near; 1 / (far - near); 1 where far is finite */

vec3 resolve(Pixel pixel) {
    float distance = -position_of(pixel.window).z;
    float grey = u_planes.z > 0.0 ? 1.0 - (distance - u_planes.x) * u_planes.y
                                  : u_planes.x / distance;
    return vec3(grey);
}

/* SPDX-License-Identifier: MIT
 *
 * depth.frag - writes depth as the four bytes of its float, lowest first, to an RGBA8 target. GLES
 * cannot read a depth buffer back, but every context can read bytes.
 */
uniform highp sampler2D u_depth;

layout(location = 0) out vec4 o_bytes;

void main() {
    uint bits = floatBitsToUint(texelFetch(u_depth, ivec2(gl_FragCoord.xy), 0).r);
    uvec4 bytes = uvec4(bits, bits >> 8, bits >> 16, bits >> 24) & 255u;
    o_bytes = vec4(bytes) / 255.0;
}

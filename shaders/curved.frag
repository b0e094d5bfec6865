/* SPDX-License-Identifier: MIT
 *
 * curved.frag - the fragments of one curved splat: finds where the view ray meets the patch, or the
 * wall under its rim (spec 5.1), in the splat's local coordinates (curved.vert), and writes the
 * point's depth and its part of the sums.
 *
 * Along the ray the height over the surface is F(t) = c + b t + a t^2, t being 0 at the billboard
 * and 1 the way from the eye to there. At its roots F' is -+sqrt(b^2 - 4 a c): at one of them the ray
 * comes from outside, and there the front is seen. F is set up at the billboard, beside the patch,
 * because from the eye its terms would cancel.
 *
 * Divisions and square roots are what a fragment costs, so that their number is kept low.
 *
 * gl_program.c defines PASS, CLIP_COUNT, SEAM_COUNT, BENDS, SHAPE, COLOR, FINISH, FIELD, TWO_SIDED, TEXTURED,
 * MASK and NORMAL_MAP. texels.glsl, maps.glsl where splats are textured, and sums.glsl come before
 * this file.
 */
#if defined(GL_ARB_conservative_depth) || defined(GL_EXT_conservative_depth)
/* GPUs can go on testing depth before they shade: curved.vert puts billboards before patches. */
layout(depth_greater) out highp float gl_FragDepth;
#endif

#if FINISH && CLIP_COUNT >= 3
uniform vec3 u_shift;       /* psplat_camera.shift */
uniform vec2 u_depth_range; /* half and middle of the depth range */
#else
flat in vec4 v_view; /* as in curved.vert */
#define u_shift v_view.xy
#define u_depth_range v_view.zw
#endif

in vec4 v_local;
flat in vec4 v_eye;
flat in vec4 v_shape;
flat in float v_room;
#if PASS == PSPLAT_PASS_VISIBILITY
in float v_distance;
flat in float v_epsilon;
flat in float v_unit;
#endif
#if PASS == PSPLAT_PASS_PARAMETERS
flat in float v_index;
flat in float v_apart;
#else
flat in vec3 v_normal_x;
flat in vec3 v_normal_y;
flat in vec3 v_normal_z;
#endif
#if PASS == PSPLAT_PASS_NORMALS || PASS == PSPLAT_PASS_RADIANCE
#if SHAPE
flat in float v_field_x;
flat in float v_field_y;
flat in float v_field_xx;
flat in float v_field_xy;
flat in float v_field_yy;
#endif
#if FINISH
flat in vec3 v_color;
#if FIELD
flat in vec3 v_color_u;
flat in vec3 v_color_v;
#endif
#if !READS_SURFACE
flat in vec3 v_surface;
flat in vec3 v_emissive;
#elif !TEXTURED
flat in float v_splat;
#endif
#elif COLOR
flat in vec3 v_color;
#endif
#endif
#if CLIP_COUNT > 0
flat in LINE_TYPE v_lines[CLIP_COUNT];
#endif

/* Where a ray meets the quadric or the wall. */
struct Hit {
    float t;
    vec2 uv;
    float inverse_w; /* of clip coordinates */
    float ndc;       /* z in normalised device coordinates */
    bool is_inside; /* the clip lines, and the near and the far plane */
    bool is_wall;
#if TWO_SIDED
    bool is_negated;  /* its normal is: it is a back */
    bool is_mirrored; /* its normal is: it is a back that only peeks out behind a contour */
#endif
};

/* Returns the gradient of a height field at uv. */
vec2 gradient(vec2 slope, vec3 second, vec2 uv) {
    return slope + uv.x * second.xy + uv.y * second.yz;
}

#if CLIP_COUNT > 0
float line_value(int i, vec2 uv) {
    float value = dot(v_lines[i].xy, uv) + v_lines[i].z;
#if BENDS
    float across = v_lines[i].x * uv.y - v_lines[i].y * uv.x;
    value += 0.5 * v_lines[i].w * across * across;
#endif
    return value;
}

/* Returns whether the lines that cut the splat's shape keep a point; the last ones are seams. */
bool is_kept(vec2 uv) {
    float least = 0.0;
    for (int i = 0; i < CLIP_COUNT - SEAM_COUNT; ++i) least = min(least, line_value(i, uv));
    return least >= 0.0;
}

#if SEAM_COUNT > 0
/* Returns the factor of what the material adds: 1 inside all seams, next to nothing beyond. */
float seam_of(vec2 uv) {
    float least = 0.0;
    for (int i = CLIP_COUNT - SEAM_COUNT; i < CLIP_COUNT; ++i)
        least = min(least, line_value(i, uv));
    return least >= 0.0 ? 1.0 : BEYOND_SEAMS;
}
#endif
#endif

/* In perspective the eye is 0 and clip coordinates are linear, so t more of the ray adds t times z
 * and w of the billboard's point, less t times what z is at the eye. In orthographic views t of the
 * ray adds t to z. */
Hit hit_at(vec3 ray, float t) {
    Hit hit;
    hit.t = t;
    hit.uv = v_local.xy + t * ray.xy;
    hit.inverse_w = gl_FragCoord.w / (1.0 + u_shift.y * t);
    float nearer = u_shift.y > 0.0 ? u_shift.x : 1.0;
    hit.ndc = gl_FragCoord.w * v_local.w + nearer * t * hit.inverse_w;
    hit.is_inside = hit.inverse_w > 0.0 && abs(hit.ndc) <= 1.0;
#if CLIP_COUNT > 0
    hit.is_inside = hit.is_inside && is_kept(hit.uv);
#endif
    return hit;
}

/* Finds where a ray goes into the cylinder of the rim. Returns whether that is on the wall: under the
 * rim, by no more than the wall's depth, and where the height falls, by `fall`. Next to the axis t is
 * -(uv . ray) / ray . ray and the ray |uv x ray| / |ray| from it, and half a chord of the unit circle
 * before that it goes in. */
bool meets_wall(float c, float b, float a, vec3 ray, out float t, out float fall) {
    vec2 at = v_local.xy;
    float length2 = dot(ray.xy, ray.xy), away = at.x * ray.y - at.y * ray.x;
    float square = length2 - away * away;
    t = -(dot(at, ray.xy) + sqrt(max(square, 0.0))) / length2;
    float over = c + t * (b + t * a);
    fall = -b - 2.0 * a * t;
    return square > 0.0 && fall > 0.0 && over < 0.0 && over > -PSPLAT_WALL * v_room;
}

#if TWO_SIDED
/* Returns whether a point is inside the ellipse and what hit_at() says of is_inside, but for rounding,
 * without its division. */
bool is_inside_at(vec3 ray, float t) {
    vec2 uv = v_local.xy + t * ray.xy;
    float w = 1.0 + u_shift.y * t, nearer = u_shift.y > 0.0 ? u_shift.x : 1.0;
    bool is_inside = dot(uv, uv) <= 1.0 && w > 0.0 &&
                     gl_FragCoord.w * abs(v_local.w * w + nearer * t) <= w;
#if CLIP_COUNT > 0
    is_inside = is_inside && is_kept(uv);
#endif
    return is_inside;
}
#endif

/* Finds the fragment: of the surface where only fronts are seen that of the root at which the ray
 * comes in, else the nearer one of those inside. Where none is inside the ellipse, it is that of the
 * wall. (A front that lines cut off has no wall before it: the ray comes from over the rim.) root is
 * by how much the height falls or rises there. Of the two forms of a root the one is used whose
 * terms do not cancel. */
bool find_hit(vec2 slope, vec3 second, out Hit hit, out float root) {
    vec3 at = v_local.xyz, ray = u_shift.y * at - v_eye.xyz;
    vec2 g = gradient(slope, second, at.xy);
    float c = at.z - 0.5 * dot(g + slope, at.xy), b = ray.z - dot(g, ray.xy);
    float a = -0.5 * dot(vec2(dot(second.xy, ray.xy), dot(second.yz, ray.xy)), ray.xy);
    float square = b * b - 4.0 * a * c, t;
    root = sqrt(max(square, 0.0));
    float half_sum = 0.5 * (b > 0.0 ? b + root : b - root);
#if TWO_SIDED
    float first = -half_sum / a, second_root = -c / half_sum;
    float front = b > 0.0 ? first : second_root;
    float nearer = min(first, second_root), farther = max(first, second_root);
    bool is_near = is_inside_at(ray, nearer);
    bool is_met = square >= 0.0 && (is_near || is_inside_at(ray, farther));
    t = is_near ? nearer : farther;
    bool is_back = is_met && t != front;
#else
    t = (b > 0.0 ? -half_sum : -c) / (b > 0.0 ? a : half_sum);
    vec2 uv = at.xy + t * ray.xy;
    bool is_met = square >= 0.0 && dot(uv, uv) <= 1.0;
#endif
    if (!is_met && !meets_wall(c, b, a, ray, t, root)) return false;
    hit = hit_at(ray, t);
    hit.is_wall = !is_met;
#if TWO_SIDED
    hit.is_mirrored = is_back && a > 0.0 && square <= 8.0 * a * v_room;
    hit.is_negated = is_back && !hit.is_mirrored;
    hit.is_inside = hit.is_inside || is_met; /* as is_inside_at() found, whatever rounding says */
#endif
    return hit.is_inside;
}

#if PASS != PSPLAT_PASS_PARAMETERS
/* Returns the normal, in eye space, of a height field of this gradient. */
vec3 normal_of(vec2 gradient) {
    return v_normal_z - gradient.x * v_normal_x - gradient.y * v_normal_y;
}
#endif

#if PASS == PSPLAT_PASS_VISIBILITY
/* Returns by how much the point that lies epsilon / max(cos, 1/2) further along the view ray is
 * deeper (spec 5.3), as shift_of() in shift.glsl explains. With r the ray's point at w = 1 the point
 * is w r, and with m = max(cos, 1/2) the shift is
 *
 *     u_shift.x (epsilon / w) / (m |r| + epsilon / w) / w
 *
 * in perspective, and u_shift.x epsilon / m / w in orthographic views, for which v_epsilon has the
 * factor |r|. |n . r| is the root, but for units, and both sides of the fraction are multiplied by
 * |n|. |r| itself counts only where cos is less than 1/2, and there an error of (R / D)^2 for splats
 * of radius R at distance D, as v_distance has, will do. */
float shift_of(Hit hit, vec3 normal, float root) {
    float inverse_w = u_shift.y > 0.0 ? gl_FragCoord.w : 1.0;
    float ray_length = v_distance * inverse_w, projected = root * v_unit * inverse_w;
    float size = sqrt(dot(normal, normal));
    float m = max(projected, 0.5 * ray_length * size);
    float epsilon = v_epsilon * (u_shift.y > 0.0 ? hit.inverse_w : 1.0);
    if (hit.is_wall) {
        float along = u_shift.y > 0.0 ? hit.inverse_w : v_distance;
        epsilon = max(epsilon, PSPLAT_WALL_SHIFT * v_room * v_unit * along);
    }
    epsilon = size * max(epsilon, u_shift.y * 9.5367431640625e-7 * ray_length);
    float shift = u_shift.x * epsilon * hit.inverse_w / (m + u_shift.y * epsilon);
    float room = max(1.0 - 1.1920929e-7 - hit.ndc, 0.0);
    return max(shift, min(room, 9.5367431640625e-7));
}
#endif

#if TEXTURED
/* Returns the derivatives of (u, v) by window x and y, of which the billboard's point has those
 * given, along the plane that touches the patch or the wall. Neighbours of the pixel may not meet
 * the patch, so that the roots themselves have no derivatives. With the point p = e + k d on a ray d
 * from the eye e, dp = k dd + d dk has no part along the normal, which gives dk. On a contour it is
 * infinite; there it stays a number, or GLs might sample anything. */
mat2 reach_of(Hit hit, vec2 slope, vec3 second, vec3 by_x, vec3 by_y) {
    vec3 ray = u_shift.y * v_local.xyz - v_eye.xyz;
    vec3 normal =
        hit.is_wall ? vec3(hit.uv, 0.0) : vec3(-gradient(slope, second, hit.uv), 1.0);
    float facing = dot(normal, ray);
    vec2 along = ray.xy / (abs(facing) > 1e-12 ? facing : 1e-12);
    float k = 1.0 + u_shift.y * hit.t;
    return mat2(k * (by_x.xy - dot(normal, by_x) * along),
                k * (by_y.xy - dot(normal, by_y) * along));
}
#endif

#if PASS == PSPLAT_PASS_NORMALS || PASS == PSPLAT_PASS_RADIANCE
#if TWO_SIDED || NORMAL_MAP
/* Returns the matrix from local coordinates to eye space, but for a positive factor: its columns are
 * cross products of those for normals. */
mat3 to_eye_space() {
    vec3 x = cross(v_normal_y, v_normal_z);
    return sign(dot(x, v_normal_x)) *
           mat3(x, cross(v_normal_z, v_normal_x), cross(v_normal_x, v_normal_y));
}
#endif

#if NORMAL_MAP
/* Returns the normal that the texture makes of another. */
vec3 turn_by_map(Place place, vec3 normal, vec2 gradient) {
    mat3 to_eye = to_eye_space();
    return turn_normal(place, normal, to_eye[0] + gradient.x * to_eye[2],
                       to_eye[1] + gradient.y * to_eye[2]);
}
#endif

#if TWO_SIDED
/* Returns the normal of the side that is seen (spec 5.2). */
vec3 face(Hit hit, vec3 normal) {
    if (hit.is_negated) return -normal;
    if (!hit.is_mirrored) return normal;
    vec3 ray = to_eye_space() * (u_shift.y * v_local.xyz - v_eye.xyz);
    return normal - 2.0 * max(dot(normal, ray), 0.0) / dot(ray, ray) * ray;
}
#endif
#endif

void main() {
#if TEXTURED
    vec3 by_x = dFdx(v_local.xyz), by_y = dFdy(v_local.xyz);
#endif
    vec2 slope = v_shape.xy;
    vec3 second = vec3(v_shape.zw, v_eye.w);
    Hit hit;
    float root;
    if (!find_hit(slope, second, hit, root)) discard;
#if TEXTURED
    mat2 reach = reach_of(hit, slope, second, by_x, by_y);
#endif
#if MASK
    if (is_masked(hit.uv, reach)) discard;
#endif
#if PASS == PSPLAT_PASS_VISIBILITY
    vec3 normal = normal_of(gradient(slope, second, hit.uv));
    gl_FragDepth = u_depth_range.x * (hit.ndc + shift_of(hit, normal, root)) + u_depth_range.y;
#else
    float ndc = hit.ndc;
#if PASS == PSPLAT_PASS_PARAMETERS
    ndc += min(v_apart, max(1.0 - 1.1920929e-7 - ndc, 0.0));
#endif
    float depth = u_depth_range.x * ndc + u_depth_range.y;
    gl_FragDepth = depth;
#endif
#if PASS == PSPLAT_PASS_PARAMETERS
    write_parameters(hit.uv, v_index, depth);
#elif PASS != PSPLAT_PASS_VISIBILITY
#if NORMAL_MAP
    vec2 rise = gradient(slope, second, hit.uv);
#endif
#if SHAPE
    slope = vec2(v_field_x, v_field_y);
    second = vec3(v_field_xx, v_field_xy, v_field_yy);
#endif
    vec3 normal = normal_of(FIELD == 1 ? gradient(slope, second, hit.uv) : slope);
    vec3 color = vec3(1.0), surface = vec3(1.0), emissive = vec3(1.0);
#if FINISH
    color = v_color;
#if FIELD
    color += hit.uv.x * v_color_u + hit.uv.y * v_color_v;
#endif
    color = clamp(color, 0.0, 1.0);
#if READS_SURFACE
    ivec2 texel = finish_texel_of(place_of(int(v_splat)));
    read_surface(texel, surface, emissive);
#else
    surface = v_surface;
    emissive = v_emissive;
#endif
#elif COLOR
    color = v_color;
#endif
#if TEXTURED
    Place place = place_of_colors(hit.uv, reach);
    apply_maps(place, color, surface, emissive);
#endif
#if NORMAL_MAP
    normal = turn_by_map(place, normal, rise);
#endif
#if TWO_SIDED
    normal = face(hit, normal);
#endif
    float weight = weight_of(dot(hit.uv, hit.uv), 1.0);
#if SEAM_COUNT > 0
    weight = beyond_seam(seam_of(hit.uv), weight, normal);
#endif
    write_sums(weight, depth, normal, color, surface, emissive);
#endif
}

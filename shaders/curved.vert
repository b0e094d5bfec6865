/* SPDX-License-Identifier: MIT
 *
 * curved.vert - draws a curved splat as a billboard: a rectangle in a plane through its centre that
 * hides what is seen of its patch, and of the wall under its rim, from the eye. The fragment shader
 * finds where the view ray meets the patch (compare Sigg, Weyrich, Botsch, Gross: GPU-Based Ray-Casting of Quadratic
 * Surfaces, 2006, whose primitives are bounded by screen rectangles instead).
 *
 * Everything happens in the splat's local coordinates (u, v, h / r_u), in which its ellipse is the
 * unit disc and its patch the height field h = slope . uv + uv H uv / 2. They are an affine image of
 * eye space, whatever the model matrix is; rays, order along rays and sides stay what they are.
 *
 * gl_program.c defines PASS, CLIP_COUNT, LINE_COUNT, BENDS, WIDE, SHAPE, COLOR, FINISH, FIELD, GAMMA,
 * TWO_SIDED and TEXTURED. texels.glsl, splat_data.glsl and shift.glsl come before this file.
 */
uniform mat3 u_ray;         /* from (pixel x, pixel y, 1) to the view ray */

#if !(FINISH && CLIP_COUNT >= 3)
/* Uniforms for fragments, which GLs in software fetch faster where they are flat. With all
 * attributes and lines there is no room for them, as some GLs have only 15 vectors for varyings. */
uniform vec2 u_depth_range; /* half and middle of the depth range */
flat out vec4 v_view;       /* the first two numbers of psplat_camera.shift; u_depth_range */
#endif
out vec4 v_local;           /* local coordinates of the billboard's point; z of clip space */
flat out vec4 v_eye;        /* local coordinates of the eye, in orthographic views the direction to
                               it; the last element of H */
flat out vec4 v_shape;      /* slope; the first two elements of H */
flat out float v_room;      /* the depth tolerance, in local coordinates */
#if PASS == PSPLAT_PASS_VISIBILITY
out float v_distance;       /* of the billboard's point, in perspective */
flat out float v_epsilon;   /* in orthographic views times the length of u_view_direction */
flat out float v_unit;      /* turns local normals times local rays into those of eye space */
#endif
#if PASS == PSPLAT_PASS_PARAMETERS
flat out float v_index;
flat out float v_apart;
#else
flat out vec3 v_normal_x;   /* the columns of the matrix from local normals to eye space */
flat out vec3 v_normal_y;
flat out vec3 v_normal_z;
#endif
#if PASS == PSPLAT_PASS_NORMALS || PASS == PSPLAT_PASS_RADIANCE
#if SHAPE
/* The normal field where it is not that of the surface, as slopes of a height. These are single
 * numbers because they fill gaps between vectors where a GL has only 15 of them for varyings. */
flat out float v_field_x;
flat out float v_field_y;
flat out float v_field_xx;
flat out float v_field_xy;
flat out float v_field_yy;
#endif
#if FINISH
flat out vec3 v_color;      /* not clamped */
#if FIELD
flat out vec3 v_color_u;
flat out vec3 v_color_v;
#endif
#if !READS_SURFACE
flat out vec3 v_surface;
flat out vec3 v_emissive;
#endif
#elif COLOR
flat out vec3 v_color;
#endif
#endif
#if TEXTURED || READS_SURFACE
flat out float v_splat;     /* the splat's index in the batch; below 2^24, so that it is exact */
#endif
#if CLIP_COUNT > 0
flat out LINE_TYPE v_lines[CLIP_COUNT];
#endif

/* A splat's surface in local coordinates. */
struct Surface {
    vec2 slope;
    vec3 second;    /* H: d2h/du2, d2h/dudv, d2h/dv2 */
    float wall;     /* the depth of the wall */
    vec2 low_high;  /* bounds of uv H uv / 2 over the unit disc, with some room, the lower one with
                       the wall */
};

/* Returns slopes and second derivatives of the height whose gradient is a field (spec 3.5). */
void find_height(vec2 xy, vec3 alpha_beta_gamma, float ratio, out vec2 slope, out vec3 second) {
    slope = -vec2(xy.x, ratio * xy.y);
    second = -vec3(alpha_beta_gamma.x, ratio * alpha_beta_gamma.z, ratio * alpha_beta_gamma.y);
}

Surface surface_of(vec4 field, float gamma, ivec2 texel, float ratio, float wall) {
    Surface surface;
#if SHAPE
    vec3 shape = texelFetch(u_splats, texel + ivec2(PSPLAT_SPLAT_TEXELS + WIDE, 0), 0).xyz;
    find_height(vec2(0.0), shape, ratio, surface.slope, surface.second);
#else
    find_height(field.xy, vec3(field.zw, gamma), ratio, surface.slope, surface.second);
#endif
    vec3 h = surface.second;
    float mean = 0.5 * (h.x + h.z), root = length(vec2(0.5 * (h.x - h.z), h.y));
    surface.wall = wall;
    surface.low_high = vec2(0.5 * min(mean - root, 0.0) - 1e-3 - wall,
                            0.5 * max(mean + root, 0.0) + 1e-3);
    return surface;
}

/* The direction from the centre to the eye and the distance, in coordinates that are sheared so
 * that the tangent plane lies flat: along aside, a direction in that plane, and along the normal. */
struct Axis {
    vec2 aside;
    float sine, cosine, distance;
};

Axis axis_to(Surface surface, vec3 eye) {
    vec3 sheared = vec3(eye.xy, eye.z - dot(surface.slope, eye.xy));
    float distance = length(sheared), sine = length(sheared.xy) / distance;
    vec2 aside = sine > 1e-5 ? normalize(sheared.xy) : vec2(1.0, 0.0);
    return Axis(aside, sine, sheared.z / distance, distance);
}

/* Cuts away where the eye sees the patch from behind: where n . (eye - point), which is
 * eye.z - slope . eye.xy - uv H eye.xy + uv H uv / 2, is negative, also at points down to the foot
 * of the wall. In orthographic views eye is a direction, and the last terms are not there. */
vec4 cut_backs(vec4 reach, vec2 aside, Surface surface, vec3 eye) {
    vec3 h = surface.second;
    float most = eye.z - dot(surface.slope, eye.xy);
    most += u_shift.y * (surface.low_high.y + surface.wall);
    return cut_disc(reach, aside, vec3(-dot(h.xy, eye.xy), -dot(h.yz, eye.xy), most));
}

/* Returns the greatest value of a x^2 + b x + c between two ends. */
float greatest(float a, float b, float c, vec2 ends) {
    float middle = a < -1e-6 ? clamp(-0.5 * b / a, ends.x, ends.y) : ends.x;
    vec3 x = vec3(ends, middle), values = (a * x + b) * x + c;
    return max(max(values.x, values.y), values.z);
}

/* Returns how far the patch and its wall reach upwards, which is across the ray in the plane of the
 * normal and aside, and downwards. A point x along aside and y across it has the height
 * (haa x^2 + 2 hab x y + hbb y^2) / 2, where 2 |x y| <= x^2 + y^2 and y^2 <= 1 - x^2. */
vec2 heights_of(Surface surface, Axis axis, vec4 reach) {
    vec3 h = surface.second;
    vec2 ends = vec2(-reach.y, reach.x), a = axis.aside;
    vec2 ha = vec2(dot(h.xy, a), dot(h.yz, a));
    float haa = dot(ha, a), hbb = h.x + h.z - haa, hab = abs(a.x * ha.y - a.y * ha.x);
    float above = max(hbb + hab, 0.0), below = max(hab - hbb, 0.0), s = 0.5 * axis.sine;
    vec2 heights = vec2(greatest(s * (haa + hab - above), -axis.cosine, s * above, ends),
                        greatest(s * (hab - haa - below), axis.cosine, s * below, ends));
    return heights + vec2(1e-3, 1e-3 + axis.sine * surface.wall);
}

/* A billboard: the rectangle with these half axes around center. Perspective has made the patch
 * larger by enlarge at most. is_known is false where the eye is so near that there is none. */
struct Billboard {
    vec3 center, across, along;
    float enlarge;
    bool is_known;
};

/* Finds the rectangle across the ray to the centre that hides what is seen of the patch.
 * Perspective makes what is nearest to the eye largest, and what is farthest smallest. */
Billboard billboard_of(Surface surface, Axis axis, vec4 reach) {
    vec2 over = axis.cosine * surface.low_high, aside = axis.aside;
    vec2 nearer = axis.sine * vec2(-reach.y, reach.x) +
                  vec2(min(over.x, over.y), max(over.x, over.y)); /* at least and at most */
    vec2 scale = u_shift.y > 0.0 ? axis.distance / (axis.distance - nearer) : vec2(1.0);
    vec4 sides = vec4(heights_of(surface, axis, reach), reach.zw);
    sides *= mix(scale.xxxx, scale.yyyy, greaterThan(sides, vec4(0.0)));
    vec3 up = vec3(-axis.cosine * aside, axis.sine), right = vec3(-aside.y, aside.x, 0.0);
    up.z += dot(surface.slope, up.xy);
    right.z += dot(surface.slope, right.xy);
    Billboard b;
    /* Where the eye comes near to the cylinder of the whole disc, corners would lie far away. */
    b.is_known = u_shift.y == 0.0 || axis.distance > 1.01 * (axis.sine + max(over.x, over.y));
    b.enlarge = max(scale.y, 1.0);
    b.across = 0.5 * (sides.z + sides.w) * right;
    b.along = 0.5 * (sides.x + sides.y) * up;
    b.center = 0.5 * ((sides.x - sides.y) * up + (sides.z - sides.w) * right);
    return b;
}

/* Returns a z of clip space for a corner that lies between the planes, not behind any point of the
 * patch. zw is that of the centre, the columns of local_to_zw are those of the local axes. */
float safe_z(Surface surface, vec2 zw, mat3x2 local_to_zw, float w) {
    mat2 disc = mat2(local_to_zw[0] + surface.slope.x * local_to_zw[2],
                     local_to_zw[1] + surface.slope.y * local_to_zw[2]);
    vec2 room = vec2(length(vec2(disc[0].x, disc[1].x)), length(vec2(disc[0].y, disc[1].y))) +
                max(abs(surface.low_high.x), surface.low_high.y) * abs(local_to_zw[2]);
    float z = zw.x - room.x;
    float least = zw.y - (z > 0.0 ? -room.y : room.y);
    return least > 0.0 ? clamp(z / least - 1e-5, -1.0, 0.9999) * w : -w;
}

#if PART
/* Returns whether a clip line cuts a splat, as psplat_packed_uncut does. */
bool is_cut(ivec2 place) {
    for (int i = 0; i < LINE_COUNT; ++i) {
        vec4 line = texelFetch(u_clips, ivec2(place.x * LINE_COUNT + i, place.y), 0);
        if (line.xyz != vec3(1.0, 0.0, 1.0) || (BENDS == 1 && line.w != 0.0)) return true;
    }
    return false;
}
#endif

void main() {
    int billboard = gl_VertexID / 6, vertex = gl_VertexID - 6 * billboard;
    int splat = first_splat() + billboard;
    int corner = vertex < 3 ? vertex : 6 - vertex; /* 0 1 2, 3 2 1 */
    vec2 side = vec2(2 * (corner & 1) - 1, (corner & 2) - 1);
    ivec2 place = place_of(splat), texel = texel_of(place);
#if PART
    if (is_cut(place) != (PART == PSPLAT_PART_CUT)) {
        gl_Position = nowhere();
        return;
    }
#endif
    vec4 center = texelFetch(u_splats, texel, 0);
    vec4 rotation = texelFetch(u_splats, texel + ivec2(1, 0), 0);
    vec4 field = texelFetch(u_splats, texel + ivec2(2, 0), 0);
    float radius = dot(rotation, rotation), ratio = center.w, gamma = 0.0;
#if GAMMA
    gamma = texelFetch(u_splats, texel + ivec2(3, 0), 0).w;
#endif
    float unit = unstretch() / radius, room = epsilon() * unit, wall = PSPLAT_WALL * room;
    Surface surface = surface_of(field, gamma, texel, ratio, wall);

    mat3 axes = axes_of(rotation);
    vec3 eye_center = modelview() * vec4(center.xyz, 1.0);
    mat3 to_eye = mat3(modelview()) * mat3(axes[0], ratio * axes[1], axes[2]);
    /* Times a unit of eye space's length this is the transpose of the inverse of to_eye, by eq.
     * (2)'s own transform (spec 4). */
    mat3 normals = normal_matrix() * (axes / radius);
    normals[1] /= ratio;
    vec3 eye = u_shift.y > 0.0 ? -unit * (eye_center * normals)
                               : -unit * (u_view_direction * normals);
    Axis axis = axis_to(surface, eye);
    vec4 reach = WHOLE_DISC;
#if !TWO_SIDED
    reach = cut_backs(reach, axis.aside, surface, eye);
#endif
#if CLIP_COUNT > 0
    for (int i = 0; i < CLIP_COUNT; ++i) {
        vec4 line = texelFetch(u_clips, ivec2(place.x * LINE_COUNT + i, place.y), 0);
        v_lines[i] = LINE_TYPE(line);
        if (i < CLIP_COUNT - SEAM_COUNT) reach = cut_disc(reach, axis.aside, straightened(line));
    }
#endif
    if (is_nothing(reach)) {
        gl_Position = nowhere();
        return;
    }
    mat3x4 clip_axes = mat3x4(u_projection) * to_eye;
    vec4 clip_center = u_projection * vec4(eye_center, 1.0);
    Billboard b = billboard_of(surface, axis, reach);
    vec3 local, point;
    if (b.is_known) {
        mat3 xyw = mat3(clip_axes[0].xyw, clip_axes[1].xyw, clip_axes[2].xyw);
        vec3 middle = clip_center.xyw + xyw * b.center, p = xyw * b.across, q = xyw * b.along;
        vec2 grown = side * (1.0 + b.enlarge * room_of(middle, p, q));
        local = b.center + grown.x * b.across + grown.y * b.along;
        point = eye_center + to_eye * local;
    } else {
        /* The whole view, half a radius before the eye. */
        vec3 ray = u_ray * vec3((side + 1.0) * u_half_viewport.xy, 1.0);
        vec3 w = vec3(u_projection[0].w, u_projection[1].w, u_projection[2].w);
        point = ray * (0.5 * length(to_eye[0]) * length(w) / dot(w, ray));
        local = eye + unit * (point * normals);
    }
    gl_Position = u_projection * vec4(point, 1.0);
    v_local = vec4(local, gl_Position.z);
    mat3x2 zw = mat3x2(clip_axes[0].zw, clip_axes[1].zw, clip_axes[2].zw);
    gl_Position.z = safe_z(surface, clip_center.zw, zw, gl_Position.w);
    v_eye = vec4(eye, surface.second.z);
    v_shape = vec4(surface.slope, surface.second.xy);
    v_room = room;

    find_fade();
#if !(FINISH && CLIP_COUNT >= 3)
    v_view = vec4(u_shift.xy, u_depth_range);
#endif
#if TEXTURED || READS_SURFACE
    v_splat = float(splat);
#endif
#if PASS == PSPLAT_PASS_VISIBILITY
    v_distance = length(view_ray(point));
    v_epsilon = epsilon();
    if (u_shift.y == 0.0)
        v_epsilon = max(epsilon(), 9.5367431640625e-7 * length(eye_center)) * v_distance;
    v_unit = 1.0 / unit;
#endif
#if PASS == PSPLAT_PASS_PARAMETERS
    v_index = float(first_index() + splat);
    v_apart = apart_of(v_index);
#else
    v_normal_x = normals[0];
    v_normal_y = normals[1];
    v_normal_z = normals[2];
#endif
#if PASS == PSPLAT_PASS_NORMALS || PASS == PSPLAT_PASS_RADIANCE
#if SHAPE
    vec2 slope;
    vec3 second;
    find_height(field.xy, vec3(field.zw, gamma), ratio, slope, second);
    v_field_x = slope.x;
    v_field_y = slope.y;
    v_field_xx = second.x;
    v_field_xy = second.y;
    v_field_yy = second.z;
#endif
#if FINISH
    Finish finish = finish_of(place);
    v_color = finish.color;
#if FIELD
    v_color_u = finish.color_u;
    v_color_v = finish.color_v;
#endif
#if !READS_SURFACE
    v_surface = finish.surface;
    v_emissive = finish.emissive;
#endif
#elif COLOR
    v_color = texelFetch(u_splats, texel + ivec2(3, 0), 0).rgb;
#endif
#endif
}

/* SPDX-License-Identifier: MIT
 *
 * splat.vert - draws a flat splat as one triangle in its plane around its ellipse, whose corners are
 * constants in (u, v), or as a rectangle around what clip lines leave of it. The normal field and the
 * values of straight clip lines are linear in (u, v), so they are exact at the corners, and the
 * hardware interpolates them with perspective; of bent lines the fragment shader gets two linear
 * values. Curved splats whose curvature does not show are drawn by this shader too, as the ellipses in
 * their tangent planes (spec 5.1).
 *
 * gl_program.c defines PASS, BOX, CLIP_COUNT, CLIP_TYPE, LINE_COUNT, SEAM_COUNT, BENDS, WIDE, SHAPE, COLOR, FINISH, FIELD, GAMMA,
 * NEAR, TWO_SIDED, FILTER, TANGENT, TEXTURED and NORMAL_MAP. texels.glsl, splat_data.glsl and
 * shift.glsl come before this file.
 */
invariant gl_Position;

#if FILTER
out vec4 v_uv; /* u, v; ratio of areas; window depth that was subtracted (spec 5.8) */
#else
out vec2 v_uv;
#endif
#if PASS == PSPLAT_PASS_VISIBILITY
#if NEAR
out float v_near;
#endif
#elif PASS == PSPLAT_PASS_PARAMETERS
flat out float v_index;
#else
out vec3 v_normal;
#if FINISH
out vec3 v_color; /* not clamped */
flat out vec3 v_surface;
flat out vec3 v_emissive;
#elif COLOR
flat out vec3 v_color;
#endif
#endif
#if TEXTURED
flat out float v_splat;   /* the splat's index in the batch; below 2^24, so that it is exact */
#endif
#if NORMAL_MAP
flat out vec3 v_axis_u;   /* derivatives by u and v of the point in eye space, in radii */
flat out vec3 v_axis_v;
#endif
#if CLIP_COUNT > 0
out CLIP_TYPE v_clip;
#if BENDS
out CLIP_TYPE v_across;      /* a v - b u */
flat out CLIP_TYPE v_bend;   /* kappa / 2 */
#if FILTER
flat out CLIP_TYPE v_slope0; /* the square of the slope in pixels is a polynomial in v_across */
flat out CLIP_TYPE v_slope1;
flat out CLIP_TYPE v_slope2;
#endif
#endif
#endif

/* Returns a corner of an equilateral triangle, counter-clockwise seen from N. Its inscribed circle
 * is 1/256 larger than the unit circle. Rasterisers round corners to that part of a pixel, and
 * without it splats of about a pixel would lose fragments at the three points where the circle
 * touches the triangle. */
vec2 corner_uv(int corner) {
    return corner == 0 ? vec2(-1.7388, -1.0039)
                       : corner == 1 ? vec2(1.7388, -1.0039) : vec2(0.0, 2.0078);
}

#if BOX
/* A rectangle around what clip lines leave of the disc: its middle and half axes in (u, v). */
struct Box {
    vec2 middle, along, across;
    bool is_nothing; /* lines exclude each other */
};

/* Returns the least of the rectangles along lines; where is_whole, one around all of the disc. */
Box box_of(ivec2 place, bool is_whole) {
    vec3 lines[CLIP_COUNT - SEAM_COUNT];
    vec2 aside = vec2(1.0, 0.0);
    vec4 least = WHOLE_DISC;
    Box box;
    box.is_nothing = false;
    for (int i = 0; i < CLIP_COUNT - SEAM_COUNT; ++i)
        lines[i] = straightened(texelFetch(u_clips, ivec2(place.x * LINE_COUNT + i, place.y), 0));
    for (int k = 0; k < CLIP_COUNT - SEAM_COUNT && !is_whole; ++k) {
        vec4 reach = WHOLE_DISC;
        for (int i = 0; i < CLIP_COUNT - SEAM_COUNT; ++i)
            reach = cut_disc(reach, lines[k].xy, lines[i]);
        box.is_nothing = box.is_nothing || is_nothing(reach);
        if ((reach.x + reach.y) * (reach.z + reach.w) >=
            (least.x + least.y) * (least.z + least.w)) continue;
        least = reach;
        aside = lines[k].xy;
    }
    vec2 across = vec2(-aside.y, aside.x);
    box.middle = 0.5 * ((least.x - least.y) * aside + (least.z - least.w) * across);
    box.along = 0.5 * (least.x + least.y) * aside;
    box.across = 0.5 * (least.z + least.w) * across;
    return box;
}

/* Returns a corner of a box, which has room for rounding: a 64th of a pixel at its middle, since
 * perspective may halve it, but no more than a half axis, or what is seen along its plane would become
 * far too long. center and the columns of axes are the splat's in clip space, without z. */
vec2 corner_of(Box box, int vertex, vec3 center, mat2x3 axes) {
    int corner = vertex < 3 ? vertex : 6 - vertex; /* 0 1 2, 3 2 1 */
    vec2 side = vec2(2 * (corner & 1) - 1, (corner & 2) - 1);
    vec2 room = room_of(center + axes * box.middle, axes * box.along, axes * box.across);
    side *= 1.0 + min(2.0 * room, 1.0);
    return box.middle + side.x * box.along + side.y * box.across;
}
#endif

#if FILTER
/* The screen-space filter of spec 5.8. A 2 x 2 matrix is a rotation times q plus a reflection times
 * r. Its singular values are q + r and q - r (negative where it is seen from behind). A matrix with
 * other singular values and the same singular vectors has another q and r alone, so the vectors are
 * not needed. */
struct Footprint {
    mat2 widened; /* J' */
    mat2 change;  /* J' - J */
    float ratio;  /* det J / det J' */
    float nearer; /* in normalised device coordinates */
    float lines;  /* 1 / t of spec 5.8; 1e6 where clip lines are hard */
    bool is_known; /* false: the filter does not apply (spec 5.8) and the rest is not used */
};

Footprint footprint_of(vec4 center, vec4 along_u, vec4 along_v) {
    /* j is J times w, by the quotient rule at the centre. */
    vec3 ndc = center.xyz / center.w;
    vec3 by_u = along_u.xyz - ndc * along_u.w, by_v = along_v.xyz - ndc * along_v.w;
    mat2 j = mat2(u_half_viewport.xy * by_u.xy, u_half_viewport.xy * by_v.xy);
    vec2 turn = 0.5 * vec2(j[0].x + j[1].y, j[0].y - j[1].x);
    vec2 flip = 0.5 * vec2(j[0].x - j[1].y, j[0].y + j[1].x);
    float q = length(turn), r = length(flip), w = abs(center.w);
    float slope = length(vec2(by_u.z, by_v.z)) / w;

    Footprint result = Footprint(j / w, mat2(0.0), 1.0, 0.0, 1e6, true);
    result.is_known = ndc.z - 2.0 * slope > -1.0 && ndc.z < 1.0 &&
                      abs(along_u.w) + abs(along_v.w) < 0.25 * center.w;
    if (abs(q - r) < w) {
        float large = max(q + r, w);
        float small = q < r ? -w : w;
        turn *= 0.5 * (large + small) / max(q, 1e-30);
        flip *= 0.5 * (large - small) / max(r, 1e-30);
        result.widened =
            mat2(turn.x + flip.x, turn.y + flip.y, flip.y - turn.y, turn.x - flip.x) / w;
        result.change = result.widened - j / w;
        result.ratio = (q + r) * abs(q - r) / (large * w);
        result.lines = 1.0 / clamp(w / max(abs(q - r), 1e-30) - 1.0, 1e-6, 1.0);
        /* The splat is compared as if it were nearer by what its plane rises within a pixel, so
         * that slanted surfaces do not lose the near half of the kernel. It is limited by a slant
         * of 87 degrees for a splat of one pixel, and by the near plane. */
        result.nearer = min(1.1 * (w / max(abs(q - r), 0.05 * w) - 1.0) * slope,
                            ndc.z + 1.0 - 2.0 * slope);
    }
    return result;
}
#endif

#if CLIP_COUNT > 0
/* Returns |det J'| J'^-T (a, b), by cofactors. */
vec2 turned_of(vec2 ab, mat2 widened) {
    return ab.x * vec2(widened[1].y, -widened[1].x) + ab.y * vec2(-widened[0].y, widened[0].x);
}

/* What the fragment shader needs of a clip line. */
struct Line {
    float value;  /* of a straight line its signed distance: in (u, v), or with the filter in pixels
                     times the factor by which widened is scaled; of a bent one a u + b v + c */
    float across; /* the next three are for bent lines: a v - b u */
    float bend;   /* kappa / 2 */
    vec3 slope;   /* coefficients, by powers of across, of the square by which value has to be
                     divided with the filter */
};

Line line_of(ivec2 texel, vec2 uv, mat2 widened) {
    vec4 abc = texelFetch(u_clips, texel, 0);
    Line line = Line(dot(abc.xy, uv) + abc.z, 0.0, 0.0, vec3(0.0));
#if BENDS
    line.across = abc.x * uv.y - abc.y * uv.x;
    line.bend = 0.5 * abc.w;
#endif
#if FILTER
    vec2 turned = turned_of(abc.xy, widened);
    float area = abs(determinant(widened));
#if BENDS
    /* The gradient of (3b) is (a, b) + kappa across (-b, a). */
    vec2 along = turned_of(vec2(-abc.y, abc.x), widened) * (abc.w / area);
    turned /= area;
    line.slope = vec3(dot(turned, turned), 2.0 * dot(turned, along), dot(along, along));
#else
    line.value *= area * inversesqrt(dot(turned, turned));
#endif
#endif
    return line;
}

#if CLIP_COUNT == 1
#define OF_LINES(member) lines[0].member
#elif CLIP_COUNT == 2
#define OF_LINES(member) vec2(lines[0].member, lines[1].member)
#elif CLIP_COUNT == 3
#define OF_LINES(member) vec3(lines[0].member, lines[1].member, lines[2].member)
#else
#define OF_LINES(member) vec4(lines[0].member, lines[1].member, lines[2].member, lines[3].member)
#endif

/* Sets the outputs of the clip lines. */
void find_lines(ivec2 place, vec2 uv, mat2 widened) {
    Line lines[CLIP_COUNT];
    for (int i = 0; i < CLIP_COUNT; ++i)
        lines[i] = line_of(ivec2(place.x * LINE_COUNT + i, place.y), uv, widened);
    v_clip = OF_LINES(value);
#if BENDS
    v_across = OF_LINES(across);
    v_bend = OF_LINES(bend);
#if FILTER
    v_slope0 = OF_LINES(slope.x);
    v_slope1 = OF_LINES(slope.y);
    v_slope2 = OF_LINES(slope.z);
#endif
#endif
}
#endif

#if PASS != PSPLAT_PASS_VISIBILITY && PASS != PSPLAT_PASS_PARAMETERS
/* Returns the normal field at uv (spec 3.5) in eye space. */
vec3 normal_of(ivec2 texel, mat3 axes, float length2, float ratio, vec2 uv) {
    vec4 field = texelFetch(u_splats, texel + ivec2(2, 0), 0);
#if FIELD
    field.xy += field.zw * uv;
#if GAMMA
    field.xy += texelFetch(u_splats, texel + ivec2(3, 0), 0).w * vec2(ratio * uv.y, uv.x);
#endif
#endif
    return normal_matrix() * (axes * vec3(field.xy, 1.0) / length2);
}
#endif

#if TWO_SIDED
/* Returns the matrix that turns vectors of the splat to the side that is seen (spec 5.2): it negates
 * those of a back, and mirrors those of one that only peeks out behind a contour. unit turns lengths
 * of eye space into radii. */
mat3 facing_of(ivec2 texel, mat3 normals, vec3 normal, float ratio, float unit, vec3 eye_center) {
    vec3 ray = view_ray(eye_center);
    vec2 uv = unit * (ray * mat2x3(normals));
    uv.y /= ratio;
    vec2 bend = texelFetch(u_splats, texel + ivec2(2, 0), 0).zw * vec2(1.0, ratio);
    float first = unit * dot(ray, normal), second = dot(bend, uv * uv);
#if GAMMA
    second += 2.0 * ratio * texelFetch(u_splats, texel + ivec2(3, 0), 0).w * uv.x * uv.y;
#endif
    if (first <= 0.0) return mat3(1.0);
    if (second <= 0.0 || first * first > 4.0 * second * epsilon() * unit) return mat3(-1.0);
    return mat3(1.0) - outerProduct(2.0 / dot(ray, ray) * ray, ray);
}
#endif

void main() {
#if BOX
    int splat = first_splat() + gl_VertexID / 6;
#else
    int triangle = gl_VertexID / 3, splat = first_splat() + triangle;
    vec2 uv = corner_uv(gl_VertexID - 3 * triangle);
#endif
    ivec2 place = place_of(splat), texel = texel_of(place);
    vec4 center = texelFetch(u_splats, texel, 0);
    vec4 rotation = texelFetch(u_splats, texel + ivec2(1, 0), 0);
    mat3 axes = axes_of(rotation), plane = axes; /* the columns of plane lie in the ellipse */
    vec3 up = axes[2];
#if TANGENT
    vec2 slope = texelFetch(u_splats, texel + ivec2(2, 0), 0).xy;
    plane = mat3(axes[0] - slope.x * axes[2], axes[1] - slope.y * axes[2], axes[2]);
    up = axes * vec3(slope, 1.0);
#endif

    /* The position goes through eye space, so that z and w of a point, and with them its depth,
     * come from one rounded number. */
    vec3 eye_center = modelview() * vec4(center.xyz, 1.0);
#if FILTER || BOX
    vec4 clip_center = u_projection * vec4(eye_center, 1.0);
    vec4 along_u = u_projection * vec4(mat3(modelview()) * plane[0], 0.0);
    vec4 along_v = u_projection * vec4(mat3(modelview()) * (plane[1] * center.w), 0.0);
#endif
#if FILTER
    Footprint footprint = footprint_of(clip_center, along_u, along_v);
#endif
#if BOX
#if FILTER /* Lines of splats below a pixel are soft. */
    Box box = box_of(place, footprint.is_known && footprint.lines < 1e6);
#else
    Box box = box_of(place, false);
#endif
    if (box.is_nothing) {
        gl_Position = nowhere();
        return;
    }
    vec2 uv = corner_of(box, gl_VertexID % 6, clip_center.xyw, mat2x3(along_u.xyw, along_v.xyw));
#endif
    vec3 offset = plane[0] * uv.x + plane[1] * (center.w * uv.y);
    vec3 eye = eye_center + mat3(modelview()) * offset;
    gl_Position = u_projection * vec4(eye, 1.0);

    mat2 widened = mat2(1.0);
#if FILTER
    v_uv = vec4(uv, 1.0, 0.0);
    widened *= 1e6; /* clip lines are hard, as with Footprint.lines */
    if (footprint.is_known) {
        widened = footprint.lines * footprint.widened;
        gl_Position.xy += clip_center.w / u_half_viewport.xy * (footprint.change * uv);
        gl_Position.z -= footprint.nearer * gl_Position.w;
        v_uv.zw = vec2(footprint.ratio, footprint.nearer * u_half_viewport.z);
    }
#else
    v_uv = uv;
#endif
#if CLIP_COUNT > 0
    find_lines(place, uv, widened);
#endif

    /* The length is about 1 whatever the unit of the scene is, so that squares stay in the range of
     * float. */
    float length2 = dot(rotation, rotation);
    find_fade();
#if TEXTURED
    v_splat = float(splat);
#endif
#if NORMAL_MAP
    v_axis_u = mat3(modelview()) * plane[0] * (unstretch() / length2);
    v_axis_v = mat3(modelview()) * plane[1] * (unstretch() / length2 * center.w);
#endif
    vec3 normal = normal_matrix() * (up / length2);
#if PASS == PSPLAT_PASS_VISIBILITY
#if NEAR
    v_near = gl_Position.z + gl_Position.w;
#endif
    float grazing = grazing_of(normal, view_ray(eye_center));
    gl_Position.z += shift_of(eye, gl_Position.zw, grazing);
#elif PASS == PSPLAT_PASS_PARAMETERS
    v_index = float(first_index() + splat);
    float room = gl_Position.w * (1.0 - 1.1920929e-7) - gl_Position.z;
    gl_Position.z += min(gl_Position.w * apart_of(v_index), max(room, 0.0));
#else
    v_normal = normal_of(texel, axes, length2, center.w, uv);
#if TWO_SIDED
    mat3 normals = normal_matrix() * (axes / length2);
    mat3 facing =
        facing_of(texel, normals, normal, center.w, unstretch() / length2, eye_center);
    v_normal = facing * v_normal;
#if NORMAL_MAP
    v_axis_u = facing * v_axis_u; /* what the texture makes of the normal is turned, too */
    v_axis_v = facing * v_axis_v;
#endif
#endif
#if FINISH
    /* Eq. (4a) is linear in (u, v), so the rasteriser interpolates it exactly. */
    Finish finish = finish_of(place);
    v_color = finish.color + uv.x * finish.color_u + uv.y * finish.color_v;
    v_surface = finish.surface;
    v_emissive = finish.emissive;
#elif COLOR
    v_color = texelFetch(u_splats, texel + ivec2(3, 0), 0).rgb;
#endif
#endif
}

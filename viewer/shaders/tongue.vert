#version 410 core
#include "frame.glsl"
#include "studio.glsl"

uniform vec3 jaw_translation;   // jaw frame to head frame [m]
uniform sampler3D closeness;    // 1 where the mouth touches: r its parts in the head, g those in the jaw
uniform vec3 closeness_low;     // [m]
uniform vec3 closeness_scale;   // [1/m]

in vec3 in_position;   // jaw frame [m]
in vec3 in_normal;
in vec3 in_rest;       // rest position [m]: where the texture is fixed
in vec4 in_tissue;     // ambient occlusion, pallor, papillae, mottling
in float in_scalar;    // position along the colour map, 0 to 1

centroid out vec3 v_position;
centroid out vec3 v_normal;
centroid out vec3 v_rest;
centroid out vec4 v_tissue;
centroid out vec3 v_soft_light; // what the fill light and the surroundings give, which bumps do not change much
centroid out float v_scalar;
flat out float v_category;      // the scalar of one corner: categories do not mix

void main() {
    v_position = in_position + jaw_translation;
    v_normal = in_normal;
    v_rest = in_rest;
    v_tissue = in_tissue;
    v_scalar = v_category = in_scalar;
    float palate = textureLod(closeness, (v_position - closeness_low) * closeness_scale, 0.0).r;
    float teeth = textureLod(closeness, (in_position - closeness_low) * closeness_scale, 0.0).g;
    v_tissue.x *= (1.0 - 0.6 * palate * palate) * (1.0 - 0.45 * teeth * teeth);
    // Occluded tissue is lit by its red neighbours: occlusion dims red least.
    float occlusion = v_tissue.x;
    vec3 seen = mix(vec3(occlusion), vec3(sqrt(occlusion)), vec3(0.9, 0.25, 0.2));
    vec3 fill = wrapped(dot(in_normal, fill_direction.xyz)) * FILL_LIGHT * (0.22 + 0.78 * occlusion);
    v_soft_light = fill + ambient_light(in_normal) * seen;
    gl_Position = view_projection * vec4(v_position, 1.0);
    gl_ClipDistance[0] = dot(vec4(v_position, 1.0), clip_plane);
}

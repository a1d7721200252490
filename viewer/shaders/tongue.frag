#version 410 core
#include "frame.glsl"
#include "studio.glsl"

// Wet mucosa: light wraps around it as if it had travelled inside (studio.glsl), papillae roughen it,
// and a thin film of saliva that fills them half mirrors the studio.

uniform sampler3D papillae;        // rgb: gradient of a bump height (0.5 is zero), a: the height
uniform float papillae_per_metre;  // repeats of the texture
uniform sampler2D colour_map;
uniform bool field_shown;          // false: natural colours, true: the scalar's colours
uniform bool categories_shown;     // the scalar is a category's place along the map

centroid in vec3 v_position;
centroid in vec3 v_normal;
centroid in vec3 v_rest;
centroid in vec4 v_tissue;
centroid in vec3 v_soft_light;
centroid in float v_scalar;
flat in float v_category;

out vec4 colour_out;

const vec3 DORSUM = vec3(0.52, 0.205, 0.198);   // paler where papillae are keratinised
const vec3 FLESH = vec3(0.375, 0.092, 0.096);    // sides and underside

void main() {
    vec3 n = normalize(v_normal);
    vec3 view = normalize(eye.xyz - v_position);
    vec4 texel = texture(papillae, v_rest * papillae_per_metre);
    vec3 slope = (texel.rgb - 0.5) * v_tissue.z;
    vec3 bumped = normalize(n - 0.9 * (slope - n * dot(slope, n)));
    vec3 film = 0.62 * n + 0.38 * bumped;   // nearly of unit length

    float open = 0.22 + 0.78 * v_tissue.x;
    float lit = dot(bumped, key_direction.xyz);
    vec3 irradiance = wrapped(lit) * (KEY_LIGHT * open) + v_soft_light;

    float n_dot_v = clamp(dot(film, view), 0.0, 1.0);
    vec3 mirrored = reflect(-view, film);
    float back = clamp(dot(n, rim_direction.xyz), 0.0, 1.0);
    float turn = 1.0 - n_dot_v;
    vec3 gloss = KEY_LIGHT * (0.015 * lobe(dot(mirrored, key_direction.xyz), 4.0) * clamp(lit, 0.0, 1.0) * open)
        + surrounding(mirrored) * (fresnel(n_dot_v, 0.028) * v_tissue.x)
        + RIM_LIGHT * (0.55 * back * turn * turn * open);

    if (field_shown) {
        float place = categories_shown ? v_category : v_scalar;
        vec3 mapped = texture(colour_map, vec2(place * (255.0 / 256.0) + 0.5 / 256.0, 0.5)).rgb;
        float shade = sqrt(dot(irradiance, vec3(0.11, 0.22, 0.04)) + 0.22);
        colour_out = vec4(min(mapped * min(shade, 1.06) + 0.3 * sqrt(gloss), 1.0), 1.0);
    } else {
        float raised = (texel.a - 0.5) * v_tissue.z;
        vec3 tissue = mix(FLESH, DORSUM, v_tissue.y) * (1.0 + 0.35 * raised + v_tissue.w);
        colour_out = vec4(developed(tissue * irradiance + gloss), 1.0);
    }
}

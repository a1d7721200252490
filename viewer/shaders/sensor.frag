#version 410 core
#include "frame.glsl"
#include "studio.glsl"

uniform float strength;   // 1: drawn plainly; less: seen faintly through tissue

in vec3 v_position;
in vec3 v_normal;
in vec4 v_colour;

out vec4 colour_out;

void main() {
    vec3 n = normalize(v_normal);
    vec3 view = normalize(eye.xyz - v_position);
    float key = clamp(0.6 * dot(n, key_direction.xyz) + 0.4, 0.0, 1.0);
    float mirrored = dot(reflect(-view, n), key_direction.xyz);
    // Display values: a coil keeps its colour in any light.
    vec3 shown = v_colour.rgb * (0.66 + 0.36 * key) + 0.25 * exp2(18.0 * (mirrored - 1.0));
    float turn = 1.0 - clamp(dot(n, view), 0.0, 1.0);
    float alpha = strength * mix(v_colour.a, 1.0, turn * turn * step(v_colour.a, 0.99));
    colour_out = vec4(min(shown, 1.0) * alpha, alpha);
}

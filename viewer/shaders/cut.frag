#version 410 core
#include "frame.glsl"
#include "studio.glsl"

// The inside of the tongue seen through the clipping plane: the eye's ray is carried on to the plane
// and the muscle is drawn there, so that the open skin looks like a cut.

centroid in vec3 v_position;
centroid in vec3 v_normal;
centroid in vec3 v_rest;
centroid in vec4 v_tissue;
centroid in float v_scalar;

out vec4 colour_out;

const vec3 MUSCLE = vec3(0.36, 0.088, 0.084);
const vec3 MUCOSA = vec3(0.52, 0.235, 0.220);

void main() {
    vec3 ray = v_position - eye.xyz;
    float to_plane = -dot(vec4(eye.xyz, 1.0), clip_plane) / dot(ray, clip_plane.xyz);
    vec3 at = eye.xyz + to_plane * ray;
    vec4 clip = view_projection * vec4(at, 1.0);
    gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
    vec2 mm = 1000.0 * at.xz;
    float fan = atan(mm.y + 48.0, mm.x + 28.0);   // genioglossus spreads from the chin
    float fibres = sin(57.0 * fan + 1.6 * sin(0.17 * mm.x + 0.11 * mm.y)) * sin(131.0 * fan + 2.0 * sin(0.2 * mm.y));
    // Near its border the cut is thin before the skin behind it: mucosa there, muscle further in.
    float depth = distance(v_position, at);
    vec3 flesh = mix(MUCOSA, MUSCLE * (1.0 + 0.085 * fibres), smoothstep(0.0012, 0.0045, depth));
    vec3 light = flesh * (0.86 + 0.14 * smoothstep(0.004, 0.02, depth)) * (0.55 + 0.9 * abs(dot(clip_plane.xyz, key_direction.xyz)));
    colour_out = vec4(developed(1.6 * light), 1.0);
}

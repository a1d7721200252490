#version 410 core
#include "frame.glsl"

in vec3 in_position;   // head frame [m]
in float in_scalar;    // position along the colour map, 0 to 1

centroid out float v_scalar;

void main() {
    v_scalar = in_scalar;
    gl_Position = view_projection * vec4(in_position, 1.0);
    gl_Position.z -= 2e-4 * gl_Position.w;   // before the muscle of cut.frag, in the same plane
}

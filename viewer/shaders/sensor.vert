#version 410 core
#include "frame.glsl"

in vec3 in_vertex;     // unit sphere
in vec4 in_sphere;     // per instance: centre in the head frame [m], radius [m]
in vec4 in_colour;     // per instance: display colour, opacity

out vec3 v_position;
out vec3 v_normal;
out vec4 v_colour;

void main() {
    v_position = in_sphere.xyz + in_sphere.w * in_vertex;
    v_normal = in_vertex;
    v_colour = in_colour;
    gl_Position = view_projection * vec4(v_position, 1.0);
}

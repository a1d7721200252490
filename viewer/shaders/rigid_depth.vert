#version 410 core
#include "frame.glsl"

uniform vec3 jaw_translation;   // jaw frame to head frame [m]

in vec3 in_position;   // the part's own frame [m]
in vec4 in_kind;       // z: 1 where the part moves with the jaw

invariant gl_Position;   // to the bit as in rigid.vert

void main() {
    vec3 at = in_position + in_kind.z * jaw_translation;
    gl_Position = view_projection * vec4(at, 1.0);
    gl_ClipDistance[0] = dot(vec4(at, 1.0), clip_plane);
}

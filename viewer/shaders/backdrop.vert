#version 410 core

out vec2 v_at;   // picture coordinates, -1 to 1

void main() {
    // One triangle that covers the picture, at the far plane.
    v_at = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(v_at, 1.0, 1.0);
}

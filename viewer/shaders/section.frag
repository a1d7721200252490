#version 410 core

uniform sampler2D colour_map;

centroid in float v_scalar;

out vec4 colour_out;

void main() {
    colour_out = vec4(texture(colour_map, vec2(v_scalar * (255.0 / 256.0) + 0.5 / 256.0, 0.5)).rgb, 1.0);
}

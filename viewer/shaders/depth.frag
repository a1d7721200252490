#version 410 core

out vec4 colour_out;

void main() {
    colour_out = vec4(0.0);   // where there is colour, blending leaves it as it is
}

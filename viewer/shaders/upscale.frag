#version 410 core

in vec2 v_at;

uniform sampler2D picture;

out vec4 colour_out;

void main() {
    colour_out = texture(picture, 0.5 + 0.5 * v_at);
}

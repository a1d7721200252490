#version 410 core
#include "frame.glsl"

in vec2 v_at;

out vec4 colour_out;

void main() {
    // A pool of light on a paper roll, a little above the middle. Grain of less than a display step
    // hides the bands of so slow a gradient (Jimenez 2014).
    vec2 from_pool = v_at - vec2(0.0, 0.12);
    float away = min(0.52 * dot(from_pool, from_pool), 1.0);
    float grain = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    vec3 colour = mix(backdrop_centre.rgb, backdrop_edge.rgb, away * (2.0 - away));
    colour_out = vec4(colour + (grain - 0.5) / 255.0, 1.0) * backdrop_edge.a;
}

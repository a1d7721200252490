#version 410 core
#include "frame.glsl"
#include "studio.glsl"

// Bone and palate like stained glass: clear where they face the eye, dense where they turn away; teeth
// and gums nearly opaque. Colour is premultiplied by opacity so that highlights stay bright on clear parts.

centroid in vec3 v_position;
centroid in vec3 v_normal;
centroid in vec3 v_body;
centroid in float v_back_light;
centroid in vec3 v_surface;   // opacity facing the eye, at grazing view; gloss

out vec4 colour_out;

void main() {
    vec3 n = normalize(gl_FrontFacing ? v_normal : -v_normal);
    vec3 view = normalize(eye.xyz - v_position);
    float cosine = dot(n, view);
    float turn = 1.0 - clamp(cosine, 0.0, 1.0);
    // A triangle that faces the eye while its normal does not is roughness of the mesh: it fades out.
    float alpha = mix(v_surface.x, v_surface.y, turn * turn) * clamp(1.0 + 8.0 * cosine, 0.0, 1.0);
    float mirrored = 2.0 * cosine * dot(n, key_direction.xyz) - dot(view, key_direction.xyz);
    float shine = v_surface.z * (0.030 * lobe(mirrored, 23.0) + 0.5 * turn * turn * turn * v_back_light);
    shine = min(sqrt(shine), 1.0) * min(8.0 * alpha, 1.0);   // to display values
    vec3 body = v_body * alpha;
    colour_out = vec4(body + shine * (1.0 - body), alpha);
}

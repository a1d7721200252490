#version 410 core
#include "frame.glsl"
#include "studio.glsl"

uniform vec3 jaw_translation;   // jaw frame to head frame [m]
uniform vec3 reflectance[3];    // per kind of tissue: diffuse
uniform vec3 surface[3];        // per kind of tissue: opacity facing the eye, at grazing view; gloss
uniform vec2 at_teeth[3];       // the same opacities where it covers teeth

in vec3 in_position;   // the part's own frame [m]
in vec3 in_normal;
in vec4 in_kind;       // ambient occlusion, kind of tissue, 1 where the part moves with the jaw, gum

centroid out vec3 v_position;
centroid out vec3 v_normal;
centroid out vec3 v_body;         // diffuse colour, display values: smooth enough to be worked out per vertex
centroid out float v_back_light;
centroid out vec3 v_surface;

invariant gl_Position;   // to the bit as in rigid_depth.vert

void main() {
    int tissue = int(in_kind.y + 0.5);
    v_position = in_position + in_kind.z * jaw_translation;
    v_normal = in_normal;
    v_surface = vec3(mix(surface[tissue].xy, at_teeth[tissue], in_kind.w), surface[tissue].z);

    float key = clamp(0.8 * dot(in_normal, key_direction.xyz) + 0.2, 0.0, 1.0);
    float fill = clamp(0.8 * dot(in_normal, fill_direction.xyz) + 0.2, 0.0, 1.0);
    v_back_light = clamp(dot(in_normal, rim_direction.xyz), 0.0, 1.0);
    float open = 0.3 + 0.7 * in_kind.x;
    vec3 irradiance = (KEY_LIGHT * key + FILL_LIGHT * fill + RIM_LIGHT * (0.4 * v_back_light)) * open
        + ambient_light(in_normal) * in_kind.x;
    vec3 flesh = mix(reflectance[tissue], reflectance[2], tissue == 1 ? in_kind.w : 0.0);   // gum hides roots
    v_body = developed(flesh * irradiance);
    // Clear tissue before a light backdrop is read by its shade, not by its light.
    v_body *= mix(1.0, 0.60 + 0.40 * v_surface.x, step(0.5, backdrop_centre.g));

    gl_Position = view_projection * vec4(v_position, 1.0);
    gl_ClipDistance[0] = dot(vec4(v_position, 1.0), clip_plane);
}

// What is the same for everything drawn in one picture; written by frame_uniforms.py.
// Head frame [m]. Directions are unit vectors towards the light.
layout(std140) uniform Frame {
    mat4 view_projection;
    vec4 eye;               // xyz: position of the eye
    vec4 key_direction;
    vec4 key_side;          // with key_rise, the axes of the key light's box
    vec4 key_rise;
    vec4 fill_direction;
    vec4 rim_direction;
    vec4 clip_plane;        // a point p is kept when dot(vec4(p, 1), clip_plane) >= 0
    vec4 backdrop_centre;   // rgb: display values (sRGB)
    vec4 backdrop_edge;     // rgb: display values (sRGB); a: alpha of the backdrop
};

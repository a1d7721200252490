// The photographer's studio: three lights, an analytic surrounding, exposure and display encoding.

const float EXPOSURE = 0.66;
const vec3 KEY_LIGHT = vec3(2.70, 2.55, 2.32);     // large, warm, above and beside the camera
const vec3 FILL_LIGHT = vec3(0.42, 0.48, 0.58);    // cool, from the other side
const vec3 RIM_LIGHT = vec3(1.05, 1.12, 1.25);     // from behind
const vec3 SKY = vec3(0.52, 0.57, 0.64);           // light from above ...
const vec3 FLOOR = vec3(0.24, 0.16, 0.15);         // ... and reflected by warm tissue from below

// Light that arrives from everywhere around a surface with normal n.
vec3 ambient_light(vec3 n) {
    return mix(FLOOR, SKY, 0.5 + 0.5 * n.z);
}

// What a mirror sees in direction r: a dim gradient and one soft-edged box light around the key light.
vec3 surrounding(vec3 r) {
    vec2 at = abs(vec2(dot(r, key_side.xyz), dot(r, key_rise.xyz)));
    float box = (1.0 - smoothstep(0.20, 0.38, at.x)) * (1.0 - smoothstep(0.08, 0.20, at.y));
    box *= step(0.0, dot(r, key_direction.xyz));
    return mix(vec3(0.10, 0.085, 0.08), vec3(0.55, 0.60, 0.68), smoothstep(-0.5, 0.9, r.z)) + 12.0 * box;
}

// Reflectance of a dielectric of normal reflectance f0 (Schlick 1994).
float fresnel(float cosine, float f0) {
    float a = 1.0 - cosine, b = a * a;
    return f0 + (1.0 - f0) * b * b * a;
}

// A highlight: spherical Gaussian around the mirrored light, of unit energy for large sharpness.
float lobe(float mirrored_cosine, float sharpness) {
    return (sharpness + 0.5) * exp2(1.4427 * sharpness * (mirrored_cosine - 1.0));
}

// Light to display values: the filmic curve of Hejl and Burgess-Dawson (2010), which has the sRGB encoding
// in it and so needs no powers.
vec3 developed(vec3 light) {
    vec3 x = max(EXPOSURE * light - 0.004, 0.0);
    return x * (6.2 * x + 0.5) / (x * (6.2 * x + 1.7) + 0.06);
}

// Diffuse light on flesh. Light that enters red tissue leaves it elsewhere, red having gone furthest:
// each colour channel wraps around the terminator by its own amount, which makes the shadows' edge warm.
vec3 wrapped(float cosine) {
    const vec3 WRAP = vec3(0.55, 0.26, 0.20);
    vec3 d = clamp((cosine + WRAP) / (1.0 + WRAP), 0.0, 1.0);
    return d * d * (1.0 + 0.35 * WRAP);
}

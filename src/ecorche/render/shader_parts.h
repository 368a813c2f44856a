#pragma once

// Private to render's sources: pieces of GLSL that several shaders share.

#include <string>

namespace ecorche::render::glsl {

inline const std::string kVersion = "#version 330 core\n";

// Materials: two texels per item.
inline const std::string kMaterials = R"(
uniform samplerBuffer uMaterials;
vec4 materialColour(uint item) { return texelFetch(uMaterials, 2 * int(item)); }
// roughness, opacity at the edge, outward faces only, -
vec4 materialSurface(uint item) { return texelFetch(uMaterials, 2 * int(item) + 1); }
)";

// Geometry of the eye, shared by everything that turns depth into places.
inline const std::string kEye = R"(
uniform mat4 uInverse;      // clip space to world
uniform vec3 uEye;          // world; for parallel rays a point far back
uniform vec3 uForward;      // unit, away from the eye
uniform vec3 uRightAxis;
uniform vec3 uUpAxis;
uniform float uParallel;    // 1: orthographic
vec3 place(vec2 uv, float depth) {
  vec4 p = uInverse * vec4(2.0 * uv - 1.0, 2.0 * depth - 1.0, 1.0);
  return p.xyz / p.w;
}
vec3 towardsEye(vec3 p) { return uParallel > 0.5 ? -uForward : normalize(uEye - p); }
)";

inline const std::string kLights = R"(
#define MAX_LIGHTS 16
uniform int uLights;
uniform int uLamps;                     // the first ones make highlights
uniform vec3 uLightDirection[MAX_LIGHTS];
uniform vec3 uLightIrradiance[MAX_LIGHTS];

// Products of unit vectors exceed 1 by a rounding, and pow() of what is then below 0 is no number: hence the clamps.
// GGX with Smith's height-correlated masking [Walter et al. 2007; Heitz 2014], Schlick's Fresnel with F0 = 0.04.
float highlight(vec3 n, vec3 v, vec3 l, float roughness) {
  vec3 h = normalize(l + v);
  float nl = max(dot(n, l), 0.0), nv = max(dot(n, v), 0.05), nh = clamp(dot(n, h), 0.0, 1.0);
  float a = roughness * roughness, a2 = a * a;
  float d = nh * nh * (a2 - 1.0) + 1.0;
  float D = a2 / (3.14159265 * d * d);
  float V = 0.5 / (nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2) + 1e-5);
  float F = 0.04 + 0.96 * pow(1.0 - clamp(dot(v, h), 0.0, 1.0), 5.0);
  return D * V * F * nl;
}
)";

inline const std::string kOutline = R"(
uniform sampler2D uNormalMap;
uniform sampler2D uDepthMap;
uniform float uOutline;
uniform float uPixel;
float eyeDepth(vec2 uv, float depth) { return depth >= 1.0 ? 1e30 : dot(place(uv, depth) - uEye, uForward); }
// How much of an outline lies at a pixel: where another thing begins, on the nearer of the two
float edgeAt(ivec2 at, vec3 p, float nv, float own) {
  float here = dot(p - uEye, uForward);
  float step = 3.0 * uPixel * (uParallel > 0.5 ? 1.0 : here) / max(nv, 0.12);
  float edge = 0.0;
  ivec2 last = textureSize(uDepthMap, 0) - 1;
  for (int k = 0; k < 4; ++k) {
    ivec2 d = ivec2(k == 0 ? 1 : k == 1 ? -1 : 0, k == 2 ? 1 : k == 3 ? -1 : 0);
    ivec2 q = clamp(at + d, ivec2(0), last);
    float there = eyeDepth((vec2(q) + 0.5) / vec2(last + 1), texelFetch(uDepthMap, q, 0).r);
    float item = texelFetch(uNormalMap, q, 0).a;
    bool other = abs(item) > 0.5 && item != own;
    // Bumps of one tissue are not another thing
    bool far = there > here + (own < -0.5 && item == own ? 5.0 : 1.0) * step;
    if (far) edge = 1.0;
    else if (other && there > here - step) edge = max(edge, 0.7);
  }
  return abs(own) < 0.5 ? 0.0 : edge;
}
)";

// What lights a picture of colours, normals and depth, with or without shadows.
inline const std::string kLighting = R"(
in vec2 vUv;
layout(location = 0) out vec4 oLight;    // premultiplied
uniform sampler2D uColourMap;
uniform vec3 uSkyAbove;                  // irradiance of a surface that faces up
uniform vec3 uSkyBelow;
)";

}  // namespace ecorche::render::glsl

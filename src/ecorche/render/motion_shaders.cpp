// Shaders of pictures in motion.
#include <ecorche/render/shader_parts.h>
#include <ecorche/render/shaders.h>

namespace ecorche::render::glsl {

// Openness of what lies around a pixel, from the picture's depth alone: scalable ambient obscurance
// [McGuire, Mara, Luebke 2012], at half the size. Four pixels that touch look in different
// directions; who reads this takes their mean.
std::string openFragment() {
  return kVersion + kEye + R"(
layout(location = 0) out vec2 oOpen;     // openness, distance from the eye
uniform sampler2D uNormalMap;
uniform sampler2D uDepthMap;
uniform float uReach;                    // how far a neighbour shades [m]
uniform float uPixel;
uniform ivec2 uSize2;
const int kSteps = 7;
void main() {
  ivec2 half2 = ivec2(gl_FragCoord.xy);
  ivec2 at = min(2 * half2, uSize2 - 1);
  float depth = texelFetch(uDepthMap, at, 0).r;
  if (depth >= 1.0) { oOpen = vec2(1.0, 1e30); return; }
  vec2 scale = 1.0 / vec2(uSize2);
  vec3 p = place((vec2(at) + 0.5) * scale, depth);
  vec3 n = texelFetch(uNormalMap, at, 0).xyz;
  float away = dot(p - uEye, uForward);
  float reach = min(uReach / (uPixel * (uParallel > 0.5 ? 1.0 : away)), 90.0);   // pixels
  float turn = 1.5707963 * float((half2.x & 1) + 2 * (half2.y & 1)) / 4.0 * 1.37;
  float sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    float r = (float(i) + 0.5 + 0.25 * float((half2.x ^ half2.y) & 1)) / float(kSteps);
    float phi = turn + 2.3999632 * float(i);
    ivec2 q = at + ivec2(r * reach * vec2(cos(phi), sin(phi)));
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, uSize2))) continue;
    float d = texelFetch(uDepthMap, q, 0).r;
    vec3 v = (place((vec2(q) + 0.5) * scale, d) - p) / uReach;
    float vv = dot(v, v);
    float falloff = max(1.0 - vv, 0.0);
    sum += falloff * falloff * falloff * max(dot(v, n) - 0.02, 0.0) / (vv + 0.01);
  }
  oOpen = vec2(max(0.0, 1.0 - 1.6 * sum / float(kSteps)), away);
}
)";
}

// Light for a view in motion: lamps without shadows, a sky dimmed by openness.
std::string motionFragment() {
  return kVersion + kEye + kLights + kOutline + kLighting + R"(
uniform sampler2D uOpenMap;
// What an opening lets in when its walls have a colour of their own [Jimenez et al. 2016]
vec3 coloured(float open, vec3 albedo) {
  vec3 a = 2.0404 * albedo - 0.3324, b = -4.7951 * albedo + 0.6417, c = 2.7552 * albedo + 0.6903;
  return max(vec3(open), ((open * a + b) * open + c) * open);
}
float openAt(ivec2 at, float away, float step) {
  ivec2 base = (at - 1) / 2;
  ivec2 last = textureSize(uOpenMap, 0) - 1;
  float sum = 0.0, weight = 0.0;
  for (int k = 0; k < 4; ++k) {
    vec2 o = texelFetch(uOpenMap, clamp(base + ivec2(k & 1, k >> 1), ivec2(0), last), 0).xy;
    float w = abs(o.y - away) < 4.0 * step ? 1.0 : 1e-3;
    sum += w * o.x;
    weight += w;
  }
  return sum / weight;
}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float depth = texelFetch(uDepthMap, at, 0).r;
  if (depth >= 1.0) { oLight = vec4(0.0); return; }
  vec4 base = texelFetch(uColourMap, at, 0);
  vec4 normalItem = texelFetch(uNormalMap, at, 0);
  vec3 p = place(vUv, depth);
  vec3 v = towardsEye(p);
  vec3 n = normalItem.xyz;
  float nv = dot(n, v);
  if (nv < 0.02) { n = normalize(n + (0.02 - nv) * v); nv = dot(n, v); }
  vec3 albedo = base.rgb;
  float away = dot(p - uEye, uForward);
  float open = openAt(at, away, 3.0 * uPixel * (uParallel > 0.5 ? 1.0 : away) / max(nv, 0.12));

  vec3 direct = vec3(0.0), glint = vec3(0.0);
  for (int i = 0; i < uLamps; ++i) {
    float nl = dot(n, uLightDirection[i]);
    if (nl <= 0.0) continue;
    direct += uLightIrradiance[i] * nl;
    glint += uLightIrradiance[i] * (3.14159265 * highlight(n, v, uLightDirection[i], base.a));
  }
  vec3 sky = mix(uSkyBelow, uSkyAbove, 0.5 + 0.5 * dot(n, uUpAxis));
  vec3 passed = coloured(open, albedo);
  vec3 mirror = reflect(-v, n);
  float gloss = 1.0 - base.a;
  float fresnel = 0.04 + (max(gloss, 0.04) - 0.04) * pow(1.0 - clamp(nv, 0.0, 1.0), 5.0);
  glint += mix(uSkyBelow, 2.0 * uSkyAbove, smoothstep(-0.4, 0.9, dot(mirror, uUpAxis))) * (fresnel * gloss);
  vec3 light = albedo * (direct * mix(vec3(1.0), passed, 0.7) + sky * passed) + glint * open;
  oLight = vec4(light * (1.0 - uOutline * edgeAt(at, p, nv, normalItem.a)), 1.0);
}
)";
}

// Smooths stairs along edges [Lottes 2009, FXAA]: an edge is followed to both its ends; how near
// the pixel is to an end tells how far the thing beside it reaches into it.
std::string smoothFragment() {
  return kVersion + R"(
uniform sampler2D uSource;
layout(location = 0) out vec4 oLight;
const int kSearch = 10;                  // pixels along the edge, either way
vec4 tap(ivec2 q) { return texelFetch(uSource, clamp(q, ivec2(0), textureSize(uSource, 0) - 1), 0); }
// As the eye takes it; what is empty is as bright as paper
float lightness(vec4 c) { return sqrt(min(dot(c.rgb, vec3(0.3, 0.59, 0.11)) + 1.0 - c.a, 1.0)); }
float at(ivec2 q) { return lightness(tap(q)); }
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  vec4 c = tap(here);
  float lc = lightness(c);
  float n = at(here + ivec2(0, 1)), s = at(here - ivec2(0, 1)), e = at(here + ivec2(1, 0)), w = at(here - ivec2(1, 0));
  float range = max(max(max(n, s), max(e, w)), lc) - min(min(min(n, s), min(e, w)), lc);
  if (range < 0.05) { oLight = c; return; }
  float ne = at(here + ivec2(1, 1)), nw = at(here + ivec2(-1, 1)), se = at(here + ivec2(1, -1)), sw = at(here - ivec2(1, 1));
  float flatly = abs(nw + sw - 2.0 * w) + 2.0 * abs(n + s - 2.0 * lc) + abs(ne + se - 2.0 * e);
  float upright = abs(nw + ne - 2.0 * n) + 2.0 * abs(w + e - 2.0 * lc) + abs(sw + se - 2.0 * s);
  bool lies = flatly >= upright;         // the edge runs from left to right
  float before = lies ? s : w, behind = lies ? n : e;
  bool back = abs(before - lc) >= abs(behind - lc);
  ivec2 across = (lies ? ivec2(0, 1) : ivec2(1, 0)) * (back ? -1 : 1);
  ivec2 along = lies ? ivec2(1, 0) : ivec2(0, 1);
  float other = back ? before : behind;
  float level = 0.5 * (lc + other), gap = 0.25 * abs(other - lc);

  float ends[2];
  bool lower[2];
  for (int k = 0; k < 2; ++k) {
    ends[k] = float(kSearch);
    lower[k] = false;
    for (int i = 1; i <= kSearch; ++i) {
      ivec2 q = here + along * (k == 0 ? -i : i);
      float l = 0.5 * (at(q) + at(q + across)) - level;
      if (abs(l) >= gap) { ends[k] = float(i); lower[k] = l < 0.0; break; }
    }
  }
  bool first = ends[0] < ends[1];
  bool good = (first ? lower[0] : lower[1]) != (lc < level);
  float share = good ? 0.5 - min(ends[0], ends[1]) / (ends[0] + ends[1]) : 0.0;
  // Single pixels and thin lines are softened instead
  float mean = (2.0 * (n + s + e + w) + ne + nw + se + sw) / 12.0;
  float lonely = smoothstep(0.0, 1.0, clamp(abs(mean - lc) / range, 0.0, 1.0));
  oLight = mix(c, tap(here + across), max(share, 0.6 * lonely * lonely));
}
)";
}

}  // namespace ecorche::render::glsl

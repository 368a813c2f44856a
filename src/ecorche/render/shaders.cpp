#include <ecorche/render/shader_parts.h>
#include <ecorche/render/shaders.h>

namespace ecorche::render::glsl {

std::string lightFunctions() { return kLights; }

std::string meshVertex() {
  return kVersion + R"(
layout(location = 0) in vec3 aPosition;
layout(location = 1) in vec3 aNormal;
layout(location = 2) in uint aItem;
layout(location = 3) in vec4 aColour;
uniform mat4 uViewProjection;
uniform vec4 uClip;
out vec3 vNormal;
out vec3 vPosition;
out vec4 vColour;
flat out uint vItem;
void main() {
  gl_Position = uViewProjection * vec4(aPosition, 1.0);
  gl_ClipDistance[0] = (aItem & 0x8000u) != 0u ? 1.0 : dot(uClip.xyz, aPosition) + uClip.w;
  vNormal = aNormal;
  vPosition = aPosition;
  vColour = aColour;
  vItem = aItem & 0x7fffu;
}
)";
}

std::string meshFragment() {
  return kVersion + kMaterials + R"(
in vec3 vNormal;
in vec3 vPosition;
in vec4 vColour;
flat in uint vItem;
layout(location = 0) out vec4 oColour;   // linear colour, roughness
layout(location = 1) out vec4 oNormal;   // normal, item + 1
void main() {
  vec4 surface = materialSurface(vItem);
  if (surface.z > 0.5 && !gl_FrontFacing) discard;
  vec3 n = gl_FrontFacing ? vNormal : -vNormal;
  oColour = vec4(materialColour(vItem).rgb * vColour.rgb, surface.x);
  oNormal = vec4(n * inversesqrt(max(dot(n, n), 1e-20)), float(vItem % 2000u) + 1.0);
}
)";
}

std::string shadowVertex() {
  return kVersion + R"(
layout(location = 0) in vec3 aPosition;
layout(location = 2) in uint aItem;
uniform mat4 uViewProjection;
uniform vec4 uClip;
void main() {
  gl_Position = uViewProjection * vec4(aPosition, 1.0);
  gl_ClipDistance[0] = (aItem & 0x8000u) != 0u ? 1.0 : dot(uClip.xyz, aPosition) + uClip.w;
}
)";
}

std::string shadowFragment() { return kVersion + "void main() {}\n"; }

// A tube is a rectangle that faces the eye and covers the segment with round ends. Instance: two
// ends, colour, radius in pixels (x) or metres (y).
std::string tubeVertex() {
  return kVersion + R"(
layout(location = 0) in vec3 aFrom;
layout(location = 1) in vec3 aTo;
layout(location = 2) in vec4 aColour;
layout(location = 3) in vec2 aRadius;
uniform mat4 uViewProjection;
uniform vec2 uSize;            // of the picture, pixels
uniform vec3 uEye;
uniform vec3 uForward;
uniform float uParallel;
uniform float uPixel;          // metres per pixel: at distance 1, or everywhere where rays are parallel
flat out vec4 vColour;
flat out vec2 vA;              // ends, pixels
flat out vec2 vB;
flat out vec2 vDepth;
flat out float vRadius;        // pixels
float pixelAt(vec3 p) { return uParallel > 0.5 ? uPixel : uPixel * max(dot(p - uEye, uForward), 1e-9); }
// The end towards the eye by the tube's radius, so that a line drawn on a surface is not half sunk in it.
vec3 lifted(vec3 p, float radius) {
  vec3 v = uParallel > 0.5 ? -uForward : normalize(uEye - p);
  return p + v * radius;
}
void main() {
  float metres = aRadius.y > 0.0 ? aRadius.y : aRadius.x * pixelAt(0.5 * (aFrom + aTo));
  vec4 a = uViewProjection * vec4(lifted(aFrom, metres), 1.0);
  vec4 b = uViewProjection * vec4(lifted(aTo, metres), 1.0);
  vColour = aColour;
  vRadius = max(metres / pixelAt(0.5 * (aFrom + aTo)), 0.5);
  bool gone = a.w <= 0.0 || b.w <= 0.0;
  vA = (0.5 * a.xy / a.w + 0.5) * uSize;
  vB = (0.5 * b.xy / b.w + 0.5) * uSize;
  vDepth = 0.5 * vec2(a.z / a.w, b.z / b.w) + 0.5;
  vec2 along = vB - vA;
  along = dot(along, along) > 1e-12 ? normalize(along) : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  float reach = vRadius + 1.0;
  vec2 corner = (gl_VertexID & 1) == 0 ? vA - along * reach : vB + along * reach;
  corner += across * ((gl_VertexID & 2) == 0 ? -reach : reach);
  gl_Position = gone ? vec4(2.0, 2.0, 2.0, 1.0) : vec4(2.0 * corner / uSize - 1.0, 0.0, 1.0);
}
)";
}

std::string tubeFragment(bool onTop) {
  return kVersion + R"(
flat in vec4 vColour;
flat in vec2 vA;
flat in vec2 vB;
flat in vec2 vDepth;
flat in float vRadius;
uniform vec3 uRightAxis;
uniform vec3 uUpAxis;
uniform vec3 uForward;
)" +
         (onTop ? R"(layout(location = 0) out vec4 oColour;)"
                : R"(layout(location = 0) out vec4 oColour;
layout(location = 1) out vec4 oNormal;)") +
         R"(
void main() {
  vec2 along = vB - vA;
  float length2 = dot(along, along);
  float t = length2 > 1e-12 ? clamp(dot(gl_FragCoord.xy - vA, along) / length2, 0.0, 1.0) : 0.0;
  vec2 off = (gl_FragCoord.xy - vA - t * along) / vRadius;
  float r2 = dot(off, off);
  if (r2 > 1.0) discard;
  vec3 n = off.x * uRightAxis + off.y * uUpAxis - sqrt(1.0 - r2) * uForward;
)" +
         (onTop ? R"(
  float light = 0.62 + 0.38 * sqrt(1.0 - r2);
  oColour = vec4(vColour.rgb * light, 1.0) * vColour.a;
)"
                : R"(
  gl_FragDepth = mix(vDepth.x, vDepth.y, t);
  oColour = vec4(vColour.rgb, 0.55);
  oNormal = vec4(n, 0.0);
)") + "}\n";
}

// A ball is a square that faces the eye. Instance: centre, colour, radius in pixels.
std::string ballVertex() {
  return kVersion + R"(
layout(location = 0) in vec3 aCentre;
layout(location = 1) in vec4 aColour;
layout(location = 2) in float aRadius;
uniform mat4 uViewProjection;
uniform vec2 uSize;
uniform vec3 uEye;
uniform vec3 uForward;
uniform float uParallel;
uniform float uPixel;
flat out vec4 vColour;
flat out vec2 vCentre;
flat out float vRadius;
flat out float vDepth;
void main() {
  float pixel = uParallel > 0.5 ? uPixel : uPixel * max(dot(aCentre - uEye, uForward), 1e-9);
  vec3 v = uParallel > 0.5 ? -uForward : normalize(uEye - aCentre);
  vec4 c = uViewProjection * vec4(aCentre + v * aRadius * pixel, 1.0);
  vColour = aColour;
  vRadius = aRadius;
  vCentre = (0.5 * c.xy / c.w + 0.5) * uSize;
  vDepth = 0.5 * c.z / c.w + 0.5;
  vec2 corner = vec2((gl_VertexID & 1) == 0 ? -1.0 : 1.0, (gl_VertexID & 2) == 0 ? -1.0 : 1.0);
  gl_Position = c.w <= 0.0 ? vec4(2.0, 2.0, 2.0, 1.0)
                           : vec4(2.0 * (vCentre + corner * (aRadius + 1.0)) / uSize - 1.0, 0.0, 1.0);
}
)";
}

std::string ballFragment(bool onTop) {
  return kVersion + R"(
flat in vec4 vColour;
flat in vec2 vCentre;
flat in float vRadius;
flat in float vDepth;
uniform vec3 uRightAxis;
uniform vec3 uUpAxis;
uniform vec3 uForward;
)" +
         (onTop ? R"(layout(location = 0) out vec4 oColour;)"
                : R"(layout(location = 0) out vec4 oColour;
layout(location = 1) out vec4 oNormal;)") +
         R"(
void main() {
  vec2 off = (gl_FragCoord.xy - vCentre) / vRadius;
  float r2 = dot(off, off);
  if (r2 > 1.0) discard;
  vec3 n = off.x * uRightAxis + off.y * uUpAxis - sqrt(1.0 - r2) * uForward;
)" +
         (onTop ? R"(
  float light = 0.55 + 0.45 * max(dot(n, normalize(uUpAxis - 0.5 * uRightAxis - uForward)), 0.0);
  oColour = vec4(vColour.rgb * light, 1.0) * vColour.a;
)"
                : R"(
  gl_FragDepth = vDepth;
  oColour = vec4(vColour.rgb, 0.4);
  oNormal = vec4(n, 0.0);
)") + "}\n";
}

// One triangle over all of a target. uDepth stands before or behind what a depth test compares.
std::string screenVertex() {
  return kVersion + R"(
out vec2 vUv;
uniform float uDepth;
void main() {
  vUv = vec2((gl_VertexID & 1) == 0 ? 0.0 : 2.0, (gl_VertexID & 2) == 0 ? 0.0 : 2.0);
  gl_Position = vec4(2.0 * vUv - 1.0, uDepth, 1.0);
}
)";
}

std::string shadeFragment() {
  return kVersion + kEye + kLights + kOutline + kLighting + R"(
uniform sampler2DArrayShadow uShadows;
uniform mat4 uShadowMatrix[MAX_LIGHTS];  // world to (u, v, depth)
uniform vec2 uTexel;                     // metres of a shadow texel; share of a map's depth for the same length
uniform float uBounce;                   // how much of blocked light comes back from the neighbour that blocks it
uniform vec4 uGround;                    // unit normal and offset
uniform float uGroundShade;              // 0: no ground

float litShare(int i, vec3 p, vec3 n, float nl) {
  float slope = clamp(sqrt(max(1.0 - nl * nl, 0.0)) / max(nl, 0.15), 0.0, 3.0);
  vec4 s = uShadowMatrix[i] * vec4(p + n * (1.2 * uTexel.x), 1.0);
  // Float depth maps do not clamp what they compare: beyond the far side nothing shades
  return texture(uShadows, vec4(s.xy, float(i), min(s.z - (0.6 + 0.8 * slope) * uTexel.y, 1.0)));
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float depth = texelFetch(uDepthMap, at, 0).r;
  bool seen = depth < 1.0;

  // Ground: what the lamps would give there and do not becomes a shadow over the background
  if (!seen && uGroundShade > 0.0) {
    vec3 from = place(vUv, 0.0);
    vec3 ray = uParallel > 0.5 ? uForward : normalize(from - uEye);
    float down = dot(uGround.xyz, ray);
    float height = dot(uGround.xyz, from) + uGround.w;
    if (down < -1e-3 && height > 0.0) {
      vec3 p = from - ray * (height / down);
      float open = 0.0, all = 0.0;
      for (int i = 0; i < uLights; ++i) {
        float nl = max(dot(uGround.xyz, uLightDirection[i]), 0.0);
        float e = nl * uLightIrradiance[i].g;
        all += e;
        if (nl > 0.0) open += e * litShare(i, p, uGround.xyz, nl);
      }
      float shade = uGroundShade * max(0.0, 1.0 - 1.04 * open / max(all, 1e-6));
      oLight = vec4(vec3(0.05, 0.04, 0.045) * shade, shade);
      return;
    }
  }

  vec4 base = texelFetch(uColourMap, at, 0);
  vec4 normalItem = texelFetch(uNormalMap, at, 0);
  vec3 p = place(vUv, depth);
  vec3 v = towardsEye(p);
  vec3 n = normalItem.xyz;
  float nv = dot(n, v);
  if (nv < 0.02) { n = normalize(n + (0.02 - nv) * v); nv = dot(n, v); }
  vec3 albedo = base.rgb;

  vec3 received = vec3(0.0), glint = vec3(0.0);
  float open = 0.0, all = 1e-6;
  int count = seen ? uLights : 0;
  for (int i = 0; i < count; ++i) {
    vec3 l = uLightDirection[i];
    float nl = dot(n, l);
    if (nl > 0.0) {
      float lit = litShare(i, p, n, nl);
      vec3 e = uLightIrradiance[i] * nl;
      open += e.g * lit;
      all += e.g;
      received += e * (lit + (1.0 - lit) * uBounce * albedo);
      if (i < uLamps) glint += uLightIrradiance[i] * (lit * 3.14159265 * highlight(n, v, l, base.a));
    }
  }
  if (!seen) { oLight = vec4(0.0); return; }

  // The sky mirrored in a moist surface
  vec3 mirror = reflect(-v, n);
  vec3 sky = mix(uSkyBelow, uSkyAbove, smoothstep(-0.4, 0.9, dot(mirror, uUpAxis)));
  float gloss = 1.0 - base.a;
  float fresnel = 0.04 + (max(gloss, 0.04) - 0.04) * pow(1.0 - clamp(nv, 0.0, 1.0), 5.0);
  glint += sky * (fresnel * gloss * open / all);

  vec3 light = albedo * received + glint;

  float edge = edgeAt(at, p, nv, normalItem.a);
  oLight = vec4(light * (1.0 - uOutline * edge), 1.0);
}
)";
}

// Transparent things are lit by the lamps without shadows. Peeled front to back: what lies before
// the last layer goes.
std::string veilFragment() {
  return kVersion + kMaterials + kEye + kLights + R"(
in vec3 vNormal;
in vec3 vPosition;
in vec4 vColour;
flat in uint vItem;
layout(location = 0) out vec4 oLight;    // premultiplied
uniform sampler2D uDepthMap;
uniform sampler2D uLastLayer;
uniform vec3 uSkyAbove;
uniform vec3 uSkyBelow;
void main() {
  vec4 surface = materialSurface(vItem);
  if (surface.z > 0.5 && !gl_FrontFacing) discard;
  ivec2 at = ivec2(gl_FragCoord.xy);
  if (gl_FragCoord.z >= texelFetch(uDepthMap, at, 0).r) discard;
  if (gl_FragCoord.z <= texelFetch(uLastLayer, at, 0).r) discard;

  vec4 colour = materialColour(vItem) * vColour;
  vec3 v = towardsEye(vPosition);
  vec3 n = normalize(gl_FrontFacing ? vNormal : -vNormal);
  float nv = max(dot(n, v), 0.02);
  vec3 received = vec3(0.0), glint = vec3(0.0);
  for (int i = 0; i < uLamps; ++i) {
    float nl = dot(n, uLightDirection[i]);
    received += uLightIrradiance[i] * max(nl, 0.0);
    if (nl > 0.0)
      glint += uLightIrradiance[i] * (3.14159265 * highlight(n, v, uLightDirection[i], surface.x));
  }
  received += mix(uSkyBelow, uSkyAbove, 0.5 + 0.5 * dot(n, uUpAxis));
  float opacity = surface.y < 0.0 ? colour.a
                                  : mix(colour.a, max(surface.y, colour.a), pow(1.0 - clamp(nv, 0.0, 1.0), 2.5));
  oLight = vec4(colour.rgb * received * opacity + glint * min(1.0, 2.0 * opacity), opacity);
}
)";
}

std::string copyFragment() {
  return kVersion + R"(
uniform sampler2D uSource;
uniform float uWeight;
layout(location = 0) out vec4 oLight;
void main() {
  vec4 light = texelFetch(uSource, ivec2(gl_FragCoord.xy), 0);
  if (light.a == 0.0) discard;
  oLight = uWeight * light;
}
)";
}

// Tone curve: the identity up to `knee`, then a shoulder that reaches 1 at infinity with the same
// slope at the knee. Colours keep their hue: the largest channel takes the curve, what it loses is
// partly given to white.
std::string resolveFragment() {
  return kVersion + R"(
in vec2 vUv;
uniform sampler2D uSum;       // premultiplied light, summed over passes
uniform float uWeight;        // 1 / passes
uniform vec4 uBackground;     // linear, straight alpha
uniform vec4 uBackgroundEdge; // at the corners
uniform ivec2 uOffset;        // of the viewport
layout(location = 0) out vec4 oColour;
const float knee = 0.72;
float curve(float x) { return x <= knee ? x : knee + (1.0 - knee) * (1.0 - exp(-(x - knee) / (1.0 - knee))); }
vec3 tone(vec3 c) {
  float m = max(c.r, max(c.g, c.b));
  if (m <= knee) return c;
  float t = curve(m);
  return mix(c * (t / m), vec3(t), 0.45 * (1.0 - t / m));
}
float encoded(float x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055; }
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy) - uOffset;
  vec4 sum = uWeight * texelFetch(uSum, at, 0);
  float a = clamp(sum.a, 0.0, 1.0);
  vec3 c = tone(sum.rgb / max(a, 1e-4)) * a;
  vec2 off = 2.0 * vUv - 1.0;
  vec4 back = mix(uBackground, uBackgroundEdge, smoothstep(0.2, 1.5, length(off + vec2(0.15, -0.25))));
  float alpha = a + back.a * (1.0 - a);
  vec3 out3 = (c + back.rgb * back.a * (1.0 - a)) / max(alpha, 1e-4);
  // Ordered dither of half a step hides bands in soft gradients; flat colours stay flat
  const int bayer[16] = int[16](0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5);
  float d = (float(bayer[(at.y & 3) * 4 + (at.x & 3)]) - 7.5) / 16.0 / 255.0 * 0.98;
  vec3 e = vec3(encoded(out3.r), encoded(out3.g), encoded(out3.b));
  bool flatBack = a == 0.0 && uBackground == uBackgroundEdge;
  oColour = vec4(flatBack ? e : clamp(e + d, 0.0, 1.0), alpha);
}
)";
}

}  // namespace ecorche::render::glsl

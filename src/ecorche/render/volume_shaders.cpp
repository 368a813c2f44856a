#include <ecorche/render/shader_parts.h>
#include <ecorche/render/shaders.h>
#include <ecorche/render/volume_shaders.h>

namespace ecorche::render::glsl {
namespace {

const std::string kRecords = R"(
uniform usamplerBuffer uRecords;
uniform vec3 uEye;
uniform vec3 uForward;
uniform float uParallel;
uniform vec4 uClip;           // what is above 0 stays; 0 0 0 1: everything
uniform float uSlack;         // a length that rounding does not reach [m]

struct Tet {
  int record;
  int seen, count;            // candidates: seen ones first
  int boundary;               // faces on the boundary, a bit each
  uvec4 meta;
  mat3 gradient;              // of barycentric coordinates 1 to 3, as columns
  vec3 corner;
};
Tet tetAt(int record) {
  vec4 a = uintBitsToFloat(texelFetch(uRecords, record));
  vec4 b = uintBitsToFloat(texelFetch(uRecords, record + 1));
  vec4 c = uintBitsToFloat(texelFetch(uRecords, record + 2));
  uvec4 m = texelFetch(uRecords, record + 3);
  int seen = int(m.x & 0xffu);
  return Tet(record, seen, seen + int(m.x >> 8 & 0xffu), int(m.x >> 16), m, mat3(a.xyz, b.xyz, c.xyz),
             vec3(a.w, b.w, c.w));
}
vec4 barycentric(Tet t, vec3 p) {
  vec3 x = (p - t.corner) * t.gradient;
  return vec4(1.0 - x.x - x.y - x.z, x);
}
vec4 barycentricRate(Tet t, vec3 d) {
  vec3 x = d * t.gradient;
  return vec4(-x.x - x.y - x.z, x);
}
// A candidate's field at the corners, less the first candidate's
vec4 valuesOf(Tet t, int i) {
  return i == 0 ? vec4(0.0) : uintBitsToFloat(texelFetch(uRecords, t.record + 3 + i));
}
)";

// Streaks along the fibres: noise averaged along a piece of the direction at each place, the line
// integral convolution of Cabral and Leedom [1993] with straight lines. It belongs to the place, so
// that it stays on the muscle when the eye moves.
const std::string kStreaks = R"(
uniform isamplerBuffer uTets;
uniform samplerBuffer uFlow;
uniform float uGrain;         // width of a streak [m]; 0: none
uniform float uPixel;         // metres per pixel: at distance 1, or everywhere where rays are parallel
float hash(ivec3 q) {
  uint h = uint(q.x) * 0x8da6b343u ^ uint(q.y) * 0xd8163841u ^ uint(q.z) * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return float((h ^ (h >> 15)) & 0xffffu) / 65535.0;
}
float noise(vec3 p) {
  vec3 cell = floor(p), f = p - cell;
  ivec3 c = ivec3(cell);
  f = f * f * (3.0 - 2.0 * f);
  vec4 x = mix(vec4(hash(c), hash(c + ivec3(0, 1, 0)), hash(c + ivec3(0, 0, 1)), hash(c + ivec3(0, 1, 1))),
               vec4(hash(c + ivec3(1, 0, 0)), hash(c + ivec3(1, 1, 0)), hash(c + ivec3(1, 0, 1)),
                    hash(c + ivec3(1, 1, 1))), f.x);
  vec2 y = mix(x.xz, x.yw, f.y);
  return mix(y.x, y.y, f.z);
}
// -1 … 1, about 0
float streak(Surface s) {
  if (uGrain <= 0.0) return 0.0;
  ivec4 v = texelFetch(uTets, s.tet);
  vec3 d = vec3(0.0), first = texelFetch(uFlow, v.x).xyz;
  for (int k = 0; k < 4; ++k) {
    vec3 own = texelFetch(uFlow, v[k]).xyz;
    d += s.weight[k] * (dot(own, first) < 0.0 ? -own : own);   // a fibre has no sign here
  }
  float size = length(d);
  if (size < 0.05) return 0.0;
  // No streak is narrower than two pixels, in steps of two
  float finest = 2.0 * uPixel * (uParallel > 0.5 ? 1.0 : distance(s.at, uEye));
  float grain = uGrain * exp2(max(0.0, ceil(log2(finest / uGrain))));
  float sum = 0.0;
  // Steps shorter than the noise, or the mean would change as much along as across
  for (int i = -8; i <= 8; ++i) sum += noise((s.at + d * (float(i) * 0.6 * grain / size)) / grain);
  return clamp((sum / 17.0 - 0.5) * 5.0, -1.0, 1.0);
}
)";

// What the fragments of a screen need to look records up.
const std::string kFound = R"(
in vec2 vUv;
uniform usampler2D uFound;
uniform mat4 uInverse;        // clip space to the volume
uniform mat4 uViewProjection;
uniform samplerBuffer uTissues;

int boundaryFaces(Tet t) {
  return (t.boundary & 1) + (t.boundary >> 1 & 1) + (t.boundary >> 2 & 1) + (t.boundary >> 3 & 1);
}
uint columnOf(Tet t, int i) {   // with the bit that marks what shows in cuts
  if (i < 4) return ((i < 2 ? t.meta.z : t.meta.w) >> uint(16 * (i & 1))) & 0xffffu;
  int at = t.record + 3 + t.count + t.seen * (t.count - t.seen) + boundaryFaces(t) + (i - 4) / 8;
  int k = (i - 4) % 8;
  return (texelFetch(uRecords, at)[k / 2] >> uint(16 * (k & 1))) & 0xffffu;
}
vec3 unpacked(uint word) {
  if (word == 0x80008000u) return vec3(0.0);
  vec2 p = vec2(float(int(word << 16) >> 16), float(int(word) >> 16)) / 32767.0;
  vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
  return normalize(n);
}
// The largest of candidates [from, to) at a place
int largest(Tet t, vec4 at, int from, int to) {
  int best = from;
  float most = -3e38;
  for (int i = from; i < to; ++i) {
    float x = dot(valuesOf(t, i), at);
    if (x > most) { most = x; best = i; }
  }
  return best;
}

vec3 placeAt(float distance, vec2 uv) {
  vec4 near = uInverse * vec4(2.0 * uv - 1.0, -1.0, 1.0);
  vec3 from = near.xyz / near.w;
  return uParallel > 0.5 ? from + uForward * (distance - dot(from - uEye, uForward))
                         : uEye + normalize(from - uEye) * distance;
}

struct Surface {
  vec3 at, normal;
  uint column;
  bool cut;
  int tet;
  vec4 weight;                // barycentric
};
// False where nothing was found
bool surfaceHere(out Surface s) {
  uvec2 found = texelFetch(uFound, ivec2(gl_FragCoord.xy), 0).xy;
  if (found.x == 0xffffffffu) return false;
  s.at = placeAt(uintBitsToFloat(found.y), vUv);
  vec3 ray = uParallel > 0.5 ? uForward : normalize(s.at - uEye);

  Tet t = tetAt(int(found.x >> 3));
  int kind = int(found.x & 7u);
  vec4 at = barycentric(t, s.at);
  vec4 behind = barycentric(t, s.at + ray * uSlack);
  s.cut = kind == 6;
  s.tet = int(t.meta.y);
  s.weight = at;
  if (s.cut) {
    s.column = columnOf(t, largest(t, behind, 0, t.count)) & 0x7fffu;
    s.normal = -uClip.xyz;
    return true;
  }
  int i = largest(t, behind, 0, t.seen);
  s.column = columnOf(t, i) & 0x7fffu;
  vec3 flatNormal, smoothNormal;
  if (kind > 0) {
    int face = kind - 1, row = 0;
    for (int k = 0; k < face; ++k) row += t.boundary >> k & 1;
    uvec4 n = texelFetch(uRecords, t.record + 3 + t.count + t.seen * (t.count - t.seen) + row);
    vec3 w = face == 0 ? at.yzw : face == 1 ? at.xwz : face == 2 ? at.xyw : at.xzy;
    smoothNormal = w.x * unpacked(n.x) + w.y * unpacked(n.y) + w.z * unpacked(n.z);
    flatNormal = face == 0 ? t.gradient[0] + t.gradient[1] + t.gradient[2] : -t.gradient[max(face - 1, 0)];
  } else {
    vec4 before = barycentric(t, s.at - ray * uSlack);
    int j = largest(t, before, t.seen, t.count);
    uvec4 n = texelFetch(uRecords, t.record + 3 + t.count + i * (t.count - t.seen) + j - t.seen);
    smoothNormal = at.x * unpacked(n.x) + at.y * unpacked(n.y) + at.z * unpacked(n.z) + at.w * unpacked(n.w);
    vec4 g = valuesOf(t, j) - valuesOf(t, i);
    flatNormal = t.gradient * (g.yzw - g.x);
  }
  // Fields that are equal all over the tet have no surface of their own
  float size = length(smoothNormal), steep = length(flatNormal);
  if (steep > 0.0) flatNormal /= steep;
  bool trusted = size > 0.0 && (steep == 0.0 || dot(smoothNormal, flatNormal) >= -0.1 * size);
  s.normal = trusted ? smoothNormal / size : steep > 0.0 ? flatNormal : -ray;
  return true;
}
float windowDepth(vec3 p) {
  vec4 c = uViewProjection * vec4(p, 1.0);
  return 0.5 * c.z / c.w + 0.5;
}
)";

}  // namespace

std::string volumeVertex() {
  return kVersion + R"(
layout(location = 0) in uvec2 aCorner;   // vertex; record and face
uniform samplerBuffer uPositions;
uniform mat4 uViewProjection;
flat out uint vTag;
out vec3 vPosition;
void main() {
  vPosition = texelFetch(uPositions, int(aCorner.x)).xyz;
  vTag = aCorner.y;
  gl_Position = uViewProjection * vec4(vPosition, 1.0);
}
)";
}

std::string volumeFragment() {
  return kVersion + kRecords + R"(
flat in uint vTag;
in vec3 vPosition;
layout(location = 0) out uvec2 oFound;   // record and kind: 0 step, 1 + k boundary face, 6 cut; distance
// A candidate that shows where the plane cuts it
bool showsInCut(Tet t, int i) {
  if (i < t.seen) return true;
  if (i < 4) return (((i < 2 ? t.meta.z : t.meta.w) >> uint(16 * (i & 1))) & 0x8000u) != 0u;
  int faces = (t.boundary & 1) + (t.boundary >> 1 & 1) + (t.boundary >> 2 & 1) + (t.boundary >> 3 & 1);
  int at = t.record + 3 + t.count + t.seen * (t.count - t.seen) + faces + (i - 4) / 8;
  int k = (i - 4) % 8;
  return ((texelFetch(uRecords, at)[k / 2] >> uint(16 * (k & 1))) & 0x8000u) != 0u;
}
void main() {
  vec3 d = uParallel > 0.5 ? uForward : normalize(vPosition - uEye);
  float base = uParallel > 0.5 ? dot(vPosition - uEye, d) : length(vPosition - uEye);
  Tet t = tetAt(int(vTag >> 3));
  vec4 at = max(barycentric(t, vPosition), 0.0);
  vec4 rate = barycentricRate(t, d);

  // The ray is inside until the first coordinate falls to zero
  float leave = 3e38;
  for (int k = 0; k < 4; ++k)
    if (rate[k] < 0.0) leave = min(leave, -at[k] / rate[k]);
  float from = 0.0;
  int begin = int(vTag & 7u);
  float kept = dot(uClip.xyz, vPosition) + uClip.w;
  float keptRate = dot(uClip.xyz, d);
  if (kept < 0.0) {
    if (keptRate <= 0.0) discard;
    from = -kept / keptRate;
    if (from > leave + uSlack) discard;
    begin = 6;
  } else if (keptRate < 0.0) {
    leave = min(leave, -kept / keptRate);
  }

  if (begin != 0) {
    // What begins here belongs to whoever is on top just behind
    vec4 behind = at + (from + uSlack) * rate;
    int best = 0;
    float most = 0.0;
    for (int i = 1; i < t.count; ++i) {
      float x = dot(valuesOf(t, i), behind);
      if (x > most) { most = x; best = i; }
    }
    if (best < t.seen || (begin == 6 && showsInCut(t, best))) {
      oFound = uvec2((vTag & ~7u) | uint(begin), floatBitsToUint(base + from));
      return;
    }
  } else {
    from = -uSlack;
  }

  // Every field is a line over s. A seen one is above all hidden ones on an interval; the first
  // beginning of such an interval is the step. Where it is above at once, the step lies before.
  float first = 3e38;
  for (int i = 0; i < t.seen; ++i) {
    vec4 mine = valuesOf(t, i);
    float lo = from, hi = leave + uSlack;
    for (int j = t.seen; j < t.count; ++j) {
      vec4 g = mine - valuesOf(t, j);
      float a = dot(g, at), b = dot(g, rate);
      if (b > 0.0) lo = max(lo, -a / b);
      else if (b < 0.0) hi = min(hi, -a / b);
      else if (a < 0.0) hi = -3e38;
    }
    if (lo <= hi) first = min(first, lo);
  }
  if (first <= from || first > 1e38 || t.seen == t.count) discard;
  oFound = uvec2(vTag & ~7u, floatBitsToUint(base + first));
}
)";
}

std::string volumeSurfaceFragment(bool withDepth) {
  return kVersion + kRecords + kFound + kStreaks + R"(
layout(location = 0) out vec4 oColour;   // linear colour, roughness
layout(location = 1) out vec4 oNormal;   // normal, minus the tissue's id
void main() {
  Surface s;
  if (!surfaceHere(s)) discard;
  vec4 look = texelFetch(uTissues, 2 * int(s.column));
  float line = s.cut ? 0.0 : streak(s);
  oColour = vec4(look.rgb * (1.0 + 0.3 * line), s.cut ? max(look.a, 0.75) : clamp(look.a - 0.06 * line, 0.05, 1.0));
  oNormal = vec4(s.normal, -float(s.column) - 1.0);
)" + (withDepth ? "  gl_FragDepth = windowDepth(s.at);\n}\n" : "}\n");
}

std::string volumeDepthFragment() {
  return kVersion + kRecords + kFound + R"(
void main() {
  uvec2 found = texelFetch(uFound, ivec2(gl_FragCoord.xy), 0).xy;
  if (found.x == 0xffffffffu) discard;
  gl_FragDepth = windowDepth(placeAt(uintBitsToFloat(found.y), vUv));
}
)";
}

std::string volumeVeilFragment() {
  return kVersion + kRecords + kFound + lightFunctions() + R"(
layout(location = 0) out vec4 oLight;    // premultiplied
uniform sampler2D uDepthMap;
uniform vec3 uSkyAbove;
uniform vec3 uSkyBelow;
uniform vec3 uUpAxis;
void main() {
  Surface s;
  if (!surfaceHere(s)) discard;
  if (windowDepth(s.at) >= texelFetch(uDepthMap, ivec2(gl_FragCoord.xy), 0).r) discard;
  vec4 look = texelFetch(uTissues, 2 * int(s.column));
  float opacity = texelFetch(uTissues, 2 * int(s.column) + 1).x;
  vec3 v = uParallel > 0.5 ? -uForward : normalize(uEye - s.at);
  float nv = max(dot(s.normal, v), 0.02);
  vec3 received = vec3(0.0), glint = vec3(0.0);
  for (int i = 0; i < uLamps; ++i) {
    float nl = dot(s.normal, uLightDirection[i]);
    received += uLightIrradiance[i] * max(nl, 0.0);
    if (nl > 0.0) glint += uLightIrradiance[i] * (3.14159265 * highlight(s.normal, v, uLightDirection[i], look.a));
  }
  received += mix(uSkyBelow, uSkyAbove, 0.5 + 0.5 * dot(s.normal, uUpAxis));
  float alpha = mix(opacity, max(opacity, 0.85), pow(1.0 - clamp(nv, 0.0, 1.0), 2.5));
  oLight = vec4(look.rgb * received * alpha + glint * min(1.0, 2.0 * alpha), alpha);
}
)";
}

}  // namespace ecorche::render::glsl

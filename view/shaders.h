#pragma once

/// The shaders, OpenGL 3.3 core.
namespace tandem::view::shaders {

inline constexpr const char* kSolidVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 model;        // to the world
uniform mat3 normal_model;
uniform mat4 world;        // to clip
out vec3 n;
out vec3 p;
void main() {
  vec4 at = model * vec4(position, 1.0);
  n = normal_model * normal;
  p = at.xyz;
  gl_Position = world * at;
}
)";

// Light from above left, a bluish sky, a warm ground, a soft highlight, and darker edges.
inline constexpr const char* kSolidFragment = R"(#version 330 core
in vec3 n;
in vec3 p;
uniform vec3 eye;
uniform vec3 light;        // unit, towards the light
uniform vec4 colour;
out vec4 result;
void main() {
  vec3 N = normalize(n);
  vec3 V = normalize(eye - p);
  if (dot(N, V) < 0.0) N = -N;
  float sky = 0.5 + 0.5 * N.z;
  vec3 ambient = mix(vec3(0.40, 0.38, 0.36), vec3(0.52, 0.56, 0.62), sky);
  float lit = max(dot(N, light), 0.0);
  float shine = pow(max(dot(N, normalize(light + V)), 0.0), 40.0);
  vec3 c = colour.rgb * (ambient + 0.58 * lit) + vec3(0.16) * shine;
  result = vec4(c, colour.a);
}
)";

inline constexpr const char* kFlatFragment = R"(#version 330 core
in vec3 n;
in vec3 p;
uniform vec4 colour;
out vec4 result;
void main() { result = colour; }
)";

inline constexpr const char* kScreenVertex = R"(#version 330 core
out vec2 at;
void main() {
  vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  at = corner;
  gl_Position = vec4(corner * 2.0 - 1.0, 0.9999, 1.0);
}
)";

inline constexpr const char* kSkyFragment = R"(#version 330 core
in vec2 at;
out vec4 result;
void main() {
  result = vec4(mix(vec3(0.925, 0.935, 0.945), vec3(0.78, 0.83, 0.89), smoothstep(0.2, 1.0, at.y)), 1.0);
}
)";

inline constexpr const char* kGroundVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 world;
uniform vec3 middle;
uniform float reach;
out vec2 p;
void main() {
  vec3 at = middle + position * reach;
  p = at.xy;
  gl_Position = world * vec4(at, 1.0);
}
)";

// Lines every `grid`, stronger every fifth, as wide as a pixel whatever the distance; all of it
// fades into the background.
inline constexpr const char* kGroundFragment = R"(#version 330 core
in vec2 p;
uniform vec3 middle;
uniform float reach;
uniform float grid;
out vec4 result;
float lines(vec2 at, float width) {
  vec2 slope = fwidth(at);
  vec2 away = abs(fract(at - 0.5) - 0.5) / max(slope, vec2(1e-6));
  float line = 1.0 - min(min(away.x, away.y) / width, 1.0);
  return line * (1.0 - smoothstep(0.15, 0.5, max(slope.x, slope.y)));
}
void main() {
  float far = length(p - middle.xy) / reach;
  float fade = 1.0 - smoothstep(0.35, 0.95, far);
  vec3 floor_colour = vec3(0.965, 0.968, 0.972);
  float fine = 0.22 * lines(p / grid, 1.0);
  float strong = 0.42 * lines(p / (5.0 * grid), 1.3);
  vec3 c = mix(floor_colour, vec3(0.42, 0.48, 0.56), max(fine, strong));
  result = vec4(c, fade);
}
)";

// A line is a thin quad that faces the eye: ends a and b, a corner along (x) and across (y).
inline constexpr const char* kLineVertex = R"(#version 330 core
layout(location = 0) in vec3 a;
layout(location = 1) in vec3 b;
layout(location = 2) in vec4 line_colour;
layout(location = 3) in float width;
layout(location = 4) in vec2 corner;
uniform mat4 world;
uniform vec2 viewport;
uniform float nearer;      // towards the eye, so that edges are not lost in their own box
out vec4 colour;
void main() {
  vec4 ca = world * vec4(a, 1.0), cb = world * vec4(b, 1.0);
  float front = 1e-4;
  if (ca.w < front && cb.w < front) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); colour = vec4(0.0); return; }
  if (ca.w < front) ca = mix(cb, ca, (cb.w - front) / (cb.w - ca.w));
  if (cb.w < front) cb = mix(ca, cb, (ca.w - front) / (ca.w - cb.w));
  vec2 along = (cb.xy / cb.w - ca.xy / ca.w) * viewport;
  float size = length(along);
  along = size > 1e-5 ? along / size : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  vec4 at = corner.x < 0.5 ? ca : cb;
  vec2 shift = across * corner.y * 0.5 * width + along * (corner.x - 0.5) * 0.5 * width;
  at.xy += 2.0 * shift / viewport * at.w;
  at.z -= nearer * at.w;
  gl_Position = at;
  colour = line_colour;
}
)";

inline constexpr const char* kLineFragment = R"(#version 330 core
in vec4 colour;
out vec4 result;
void main() { result = colour; }
)";

}  // namespace tandem::view::shaders

#include "view/renderer.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <epoxy/gl.h>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>

#include "view/gl_window.h"
#include "view/meshes.h"
#include "view/shader.h"
#include "view/shaders.h"

namespace tandem::view {
namespace {

constexpr int kMeshes = 5;

struct Buffer {
  GLuint array = 0, vertices = 0;
  GLsizei count = 0;
};

/// One corner of a line's quad.
struct LineVertex {
  glm::vec3 a, b;
  glm::vec4 colour;
  float width;
  glm::vec2 corner;
};

[[nodiscard]] const glm::dvec3& towards_light() {
  static const glm::dvec3 light = glm::normalize(glm::dvec3{-0.45, -0.35, 0.95});
  return light;
}

/// Flattens the world onto the ground, along the light.
[[nodiscard]] glm::dmat4 shadow_matrix(double ground) {
  const glm::dvec3 l = towards_light();
  glm::dmat4 m(1.0);
  m[2][0] = -l.x / l.z;
  m[2][1] = -l.y / l.z;
  m[2][2] = 0.0;
  m[3][0] = ground * l.x / l.z;
  m[3][1] = ground * l.y / l.z;
  m[3][2] = ground;
  return m;
}

}  // namespace

struct Renderer::Gl {
  Shader solid{"solid", shaders::kSolidVertex, shaders::kSolidFragment};
  Shader flat{"flat", shaders::kSolidVertex, shaders::kFlatFragment};
  Shader sky{"sky", shaders::kScreenVertex, shaders::kSkyFragment};
  Shader floor{"ground", shaders::kGroundVertex, shaders::kGroundFragment};
  Shader line{"line", shaders::kLineVertex, shaders::kLineFragment};
  std::array<Buffer, kMeshes> meshes{};
  Buffer quad, lines, nothing;
  int samples = 0, width = 0, height = 0;
  GLuint smooth = 0, smooth_colour = 0, smooth_depth = 0;  // several samples a pixel
  GLuint plain = 0, plain_colour = 0;                      // one

  void upload_meshes();
  void size_to(int w, int h);
  void forget_picture();
  void draw_items(const Drawing& drawing, const glm::dmat4& world, const Picture& picture,
                  bool xray);
  void draw_shadows(const Drawing& drawing, const glm::dmat4& world);
  void draw_ground(const Drawing& drawing, const glm::dmat4& world);
  void draw_lines(const Drawing& drawing, const glm::dmat4& world, const Picture& picture,
                  double scale, bool xray);
  void set_item(const Shader& shader, const Item& item, const glm::dmat4& world) const;
};

Renderer::Renderer(int samples) : gl_(std::make_unique<Gl>()) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &most);
  gl_->samples = std::clamp(samples, 0, static_cast<int>(most));
  gl_->upload_meshes();
}

Renderer::~Renderer() { gl_->forget_picture(); }

void Renderer::Gl::upload_meshes() {
  for (int m = 0; m < kMeshes; ++m) {
    const auto triangles = triangles_of(static_cast<Mesh>(m));
    Buffer& b = meshes[static_cast<std::size_t>(m)];
    glGenVertexArrays(1, &b.array);
    glGenBuffers(1, &b.vertices);
    glBindVertexArray(b.array);
    glBindBuffer(GL_ARRAY_BUFFER, b.vertices);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(triangles.size() * sizeof(Vertex)),
                 triangles.data(), GL_STATIC_DRAW);
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex), nullptr);
    glEnableVertexAttribArray(1);
    glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                          reinterpret_cast<const void*>(offsetof(Vertex, normal)));
    b.count = static_cast<GLsizei>(triangles.size());
  }
  const float corners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0};
  glGenVertexArrays(1, &quad.array);
  glGenBuffers(1, &quad.vertices);
  glBindVertexArray(quad.array);
  glBindBuffer(GL_ARRAY_BUFFER, quad.vertices);
  glBufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STATIC_DRAW);
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 12, nullptr);

  glGenVertexArrays(1, &nothing.array);
  glGenVertexArrays(1, &lines.array);
  glGenBuffers(1, &lines.vertices);
  glBindVertexArray(lines.array);
  glBindBuffer(GL_ARRAY_BUFFER, lines.vertices);
  const auto attribute = [](GLuint at, GLint size, std::size_t offset) {
    glEnableVertexAttribArray(at);
    glVertexAttribPointer(at, size, GL_FLOAT, GL_FALSE, sizeof(LineVertex),
                          reinterpret_cast<const void*>(offset));
  };
  attribute(0, 3, offsetof(LineVertex, a));
  attribute(1, 3, offsetof(LineVertex, b));
  attribute(2, 4, offsetof(LineVertex, colour));
  attribute(3, 1, offsetof(LineVertex, width));
  attribute(4, 2, offsetof(LineVertex, corner));
}

void Renderer::Gl::forget_picture() {
  glDeleteFramebuffers(1, &smooth);
  glDeleteFramebuffers(1, &plain);
  glDeleteRenderbuffers(1, &smooth_colour);
  glDeleteRenderbuffers(1, &smooth_depth);
  glDeleteRenderbuffers(1, &plain_colour);
  smooth = plain = smooth_colour = smooth_depth = plain_colour = 0;
}

void Renderer::Gl::size_to(int w, int h) {
  if (w == width && h == height) return;
  forget_picture();
  width = w;
  height = h;
  const auto storage = [&](GLuint& buffer, GLenum format, int n) {
    glGenRenderbuffers(1, &buffer);
    glBindRenderbuffer(GL_RENDERBUFFER, buffer);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, n, format, w, h);
  };
  storage(smooth_colour, GL_RGBA8, samples);
  storage(smooth_depth, GL_DEPTH24_STENCIL8, samples);
  storage(plain_colour, GL_RGBA8, 0);
  glGenFramebuffers(1, &smooth);
  glBindFramebuffer(GL_FRAMEBUFFER, smooth);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, smooth_colour);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER,
                            smooth_depth);
  const GLenum first = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  glGenFramebuffers(1, &plain);
  glBindFramebuffer(GL_FRAMEBUFFER, plain);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, plain_colour);
  if (first != GL_FRAMEBUFFER_COMPLETE ||
      glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw WindowError("the graphics driver cannot make a picture of " + std::to_string(w) + " x " +
                      std::to_string(h) + " with " + std::to_string(samples) +
                      " samples; try --samples 0 or a smaller --size");
}

void Renderer::begin(int width, int height) {
  gl_->size_to(std::max(width, 1), std::max(height, 1));
  glBindFramebuffer(GL_FRAMEBUFFER, gl_->smooth);
  glViewport(0, 0, gl_->width, gl_->height);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_MULTISAMPLE);
  glDepthMask(GL_TRUE);
  glClearColor(0.93f, 0.94f, 0.95f, 1.0f);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
}

void Renderer::Gl::set_item(const Shader& shader, const Item& item, const glm::dmat4& world) const {
  const glm::mat4 model(item.model);
  const glm::mat3 normal(glm::inverseTranspose(glm::dmat3(item.model)));
  const glm::mat4 to_clip(world);
  glUniformMatrix4fv(shader.at("model"), 1, GL_FALSE, glm::value_ptr(model));
  glUniformMatrix3fv(shader.at("normal_model"), 1, GL_FALSE, glm::value_ptr(normal));
  glUniformMatrix4fv(shader.at("world"), 1, GL_FALSE, glm::value_ptr(to_clip));
  glUniform4fv(shader.at("colour"), 1, glm::value_ptr(item.colour));
  const Buffer& mesh = meshes[static_cast<std::size_t>(item.mesh)];
  glBindVertexArray(mesh.array);
  glDrawArrays(GL_TRIANGLES, 0, mesh.count);
}

void Renderer::Gl::draw_items(const Drawing& drawing, const glm::dmat4& world,
                              const Picture& picture, bool xray) {
  solid.use();
  const glm::vec3 eye(picture.eye()), light(towards_light());
  glUniform3fv(solid.at("eye"), 1, glm::value_ptr(eye));
  glUniform3fv(solid.at("light"), 1, glm::value_ptr(light));
  for (const bool opaque : {true, false}) {
    glDepthMask(opaque ? GL_TRUE : GL_FALSE);
    for (const Item& item : drawing.items)
      if (item.xray == xray && (item.colour.w > 0.99f) == opaque) set_item(solid, item, world);
  }
  glDepthMask(GL_TRUE);
}

void Renderer::Gl::draw_shadows(const Drawing& drawing, const glm::dmat4& world) {
  flat.use();
  const glm::dmat4 flattened = world * shadow_matrix(drawing.ground + 1e-4 * drawing.reach);
  // The stencil lets each sample be darkened once, however many shadows fall on it.
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_EQUAL, 0, 0xff);
  glStencilOp(GL_KEEP, GL_KEEP, GL_INCR);
  glDepthMask(GL_FALSE);
  for (Item item : drawing.items) {
    if (!item.casts_shadow) continue;
    item.colour = {0.10f, 0.13f, 0.18f, 0.24f};
    set_item(flat, item, flattened);
  }
  glDepthMask(GL_TRUE);
  glDisable(GL_STENCIL_TEST);
}

void Renderer::Gl::draw_ground(const Drawing& drawing, const glm::dmat4& world) {
  floor.use();
  const glm::mat4 to_clip(world);
  const glm::vec3 middle(glm::dvec3{drawing.middle.x, drawing.middle.y, drawing.ground});
  glUniformMatrix4fv(floor.at("world"), 1, GL_FALSE, glm::value_ptr(to_clip));
  glUniform3fv(floor.at("middle"), 1, glm::value_ptr(middle));
  glUniform1f(floor.at("reach"), static_cast<float>(6.0 * drawing.reach));
  glUniform1f(floor.at("grid"), static_cast<float>(drawing.grid));
  glDepthMask(GL_FALSE);  // it is behind everything, and seen from below through
  glBindVertexArray(quad.array);
  glDrawArrays(GL_TRIANGLES, 0, 6);
  glDepthMask(GL_TRUE);
}

void Renderer::Gl::draw_lines(const Drawing& drawing, const glm::dmat4& world,
                              const Picture& picture, double scale, bool xray) {
  std::vector<LineVertex> vertices;
  vertices.reserve(drawing.lines.size() * 6);
  for (const Line& l : drawing.lines) {
    if (l.xray != xray) continue;
    for (const glm::vec2 corner : {glm::vec2{0, -1}, glm::vec2{1, -1}, glm::vec2{1, 1},
                                   glm::vec2{0, -1}, glm::vec2{1, 1}, glm::vec2{0, 1}})
      vertices.push_back(
          {glm::vec3(l.a), glm::vec3(l.b), l.colour, l.width * static_cast<float>(scale), corner});
  }
  if (vertices.empty()) return;
  line.use();
  const glm::mat4 to_clip(world);
  glUniformMatrix4fv(line.at("world"), 1, GL_FALSE, glm::value_ptr(to_clip));
  glUniform2f(line.at("viewport"), static_cast<float>(picture.width),
              static_cast<float>(picture.height));
  glUniform1f(line.at("nearer"), 4e-4f);
  glBindVertexArray(lines.array);
  glBindBuffer(GL_ARRAY_BUFFER, lines.vertices);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(LineVertex)),
               vertices.data(), GL_STREAM_DRAW);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices.size()));
}

void Renderer::draw(const Drawing& drawing, const Picture& picture, double line_scale) {
  const glm::dmat4 world = picture.matrix();
  glViewport(picture.x, picture.y, picture.width, picture.height);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDisable(GL_DEPTH_TEST);
  gl_->sky.use();
  glBindVertexArray(gl_->nothing.array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  gl_->draw_ground(drawing, world);
  gl_->draw_shadows(drawing, world);
  gl_->draw_items(drawing, world, picture, false);
  gl_->draw_lines(drawing, world, picture, line_scale, false);
  glDisable(GL_DEPTH_TEST);
  gl_->draw_items(drawing, world, picture, true);
  gl_->draw_lines(drawing, world, picture, line_scale, true);
}

void Renderer::resolve() {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, gl_->smooth);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, gl_->plain);
  glBlitFramebuffer(0, 0, gl_->width, gl_->height, 0, 0, gl_->width, gl_->height,
                    GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, gl_->plain);
  glViewport(0, 0, gl_->width, gl_->height);
}

void Renderer::present(int window_width, int window_height) {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, gl_->plain);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  glBlitFramebuffer(0, 0, gl_->width, gl_->height, 0, 0, window_width, window_height,
                    GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

Image Renderer::read() const {
  Image image{gl_->width, gl_->height, {}};
  const auto row = static_cast<std::size_t>(image.width) * 3;
  image.rgb.resize(row * static_cast<std::size_t>(image.height));
  std::vector<unsigned char> upside_down(image.rgb.size());
  glBindFramebuffer(GL_READ_FRAMEBUFFER, gl_->plain);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, image.width, image.height, GL_RGB, GL_UNSIGNED_BYTE, upside_down.data());
  for (int y = 0; y < image.height; ++y)
    std::copy_n(upside_down.data() + row * static_cast<std::size_t>(image.height - 1 - y), row,
                image.rgb.data() + row * static_cast<std::size_t>(y));
  return image;
}

}  // namespace tandem::view

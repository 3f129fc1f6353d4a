#pragma once

#include <epoxy/gl.h>
#include <string>

namespace tandem::view {

/// A vertex and a fragment shader, linked. Throws WindowError with the name of the shader, the
/// driver's words and the line they are about.
class Shader {
 public:
  Shader(const char* name, const char* vertex, const char* fragment);
  ~Shader() { glDeleteProgram(program_); }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;

  void use() const { glUseProgram(program_); }
  [[nodiscard]] GLint at(const char* uniform) const {
    return glGetUniformLocation(program_, uniform);
  }

 private:
  GLuint program_ = 0;
};

}  // namespace tandem::view

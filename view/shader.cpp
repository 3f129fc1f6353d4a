#include "view/shader.h"

#include <cstdlib>
#include <vector>

#include "view/gl_window.h"

namespace tandem::view {
namespace {

/// A compiled shader or the driver's words about it.
GLuint compile(GLenum kind, const char* name, const char* source) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return shader;
  GLint length = 0;
  glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  std::vector<char> log(static_cast<std::size_t>(length) + 1, '\0');
  glGetShaderInfoLog(shader, length, nullptr, log.data());
  glDeleteShader(shader);
  throw WindowError(std::string("the graphics driver does not take the ") +
                    (kind == GL_VERTEX_SHADER ? "vertex" : "fragment") + " shader \"" + name +
                    "\": " + log.data() +
                    "Please report this with the driver's name; LIBGL_ALWAYS_SOFTWARE=1 draws in "
                    "software instead.");
}

}  // namespace

Shader::Shader(const char* name, const char* vertex, const char* fragment) {
  const GLuint v = compile(GL_VERTEX_SHADER, name, vertex);
  const GLuint f = compile(GL_FRAGMENT_SHADER, name, fragment);
  program_ = glCreateProgram();
  glAttachShader(program_, v);
  glAttachShader(program_, f);
  glLinkProgram(program_);
  glDeleteShader(v);
  glDeleteShader(f);
  GLint ok = 0;
  glGetProgramiv(program_, GL_LINK_STATUS, &ok);
  if (ok == GL_TRUE) return;
  char log[512] = "";
  glGetProgramInfoLog(program_, sizeof log, nullptr, log);
  glDeleteProgram(program_);
  throw WindowError(std::string("the graphics driver cannot link the shader \"") + name +
                    "\": " + log);
}

}  // namespace tandem::view

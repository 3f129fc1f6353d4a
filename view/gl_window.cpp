#include "view/gl_window.h"

#include <cstdio>
#include <cstdlib>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#define GLFW_INCLUDE_NONE
#include <X11/Xlib.h>

#include <GLFW/glfw3.h>

// As in GLFW/glfw3native.h, which wants every extension of X installed.
extern "C" Display* glfwGetX11Display(void);

namespace tandem::view {
namespace {

std::string glfw_said;  // the newest error of a library that reports by callback
std::function<void()> display_lost;

void note_error(int, const char* text) { glfw_said = text == nullptr ? "" : text; }

/// Xlib's own answer to a dead server is exit(1), with a force loop running beside it.
int say_nothing(Display*) { return 0; }
void on_io_error(Display*, void*) {
  if (display_lost) display_lost();
  std::fputs("view: the display is gone (its server has ended)\n", stderr);
  std::_Exit(1);
}

[[nodiscard]] std::string software_hint() {
  return "Tandem's viewer needs OpenGL 3.3. On Debian the package libgl1-mesa-dri draws in "
         "software "
         "(LIBGL_ALWAYS_SOFTWARE=1 chooses it where the graphics driver is too old).";
}

}  // namespace

bool has_display() {
  const auto set = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  return set("DISPLAY");
}

struct GlWindow::Egl {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  ~Egl() {
    if (display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    eglTerminate(display);
  }
};

GlWindow::GlWindow(const Options& options) : options_(options) {
  if (has_display() && !options_.offscreen)
    open_window(options_);
  else
    open_offscreen();
  const int version = epoxy_gl_version();
  if (version < 33)
    throw WindowError("the display offers OpenGL " + std::to_string(version / 10) + "." +
                      std::to_string(version % 10) + " (" + description() + "). " +
                      software_hint());
}

GlWindow::~GlWindow() {
  display_lost = nullptr;
  if (window_ != nullptr) {
    glfwDestroyWindow(window_);
    glfwTerminate();
  }
}

void GlWindow::open_window(const Options& options) {
  glfwSetErrorCallback(note_error);
  if (glfwInit() != GLFW_TRUE)
    throw WindowError("cannot open display " + std::string(std::getenv("DISPLAY")) + ": " +
                      glfw_said + ". Unset DISPLAY to draw without a window (--screenshot).");
  display_lost = options.on_display_lost;
  XSetIOErrorHandler(say_nothing);
  XSetIOErrorExitHandler(glfwGetX11Display(), on_io_error, nullptr);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_VISIBLE, options.visible ? GLFW_TRUE : GLFW_FALSE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_FALSE);
  window_ =
      glfwCreateWindow(options.width, options.height, options.title.c_str(), nullptr, nullptr);
  if (window_ == nullptr) {
    glfwTerminate();
    throw WindowError("no OpenGL 3.3 on display " + std::string(std::getenv("DISPLAY")) + ": " +
                      glfw_said + ". " + software_hint());
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(options.visible ? 1 : 0);
}

void GlWindow::open_offscreen() {
  egl_ = std::make_unique<Egl>();
  const auto fail = [](const std::string& what) {
    throw WindowError("no display (DISPLAY is not set), and drawing without one failed: " + what +
                      ". It needs the Debian packages libegl1 and libgl1-mesa-dri.");
  };
  if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
    fail("EGL offers no surfaceless platform");
  egl_->display =
      eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (egl_->display == EGL_NO_DISPLAY || !eglInitialize(egl_->display, nullptr, nullptr))
    fail("EGL cannot be initialised");
  eglBindAPI(EGL_OPENGL_API);
  const EGLint choose[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                           EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(egl_->display, choose, &config, 1, &count) || count < 1)
    fail("EGL has no configuration for OpenGL");
  const EGLint wish[] = {EGL_CONTEXT_MAJOR_VERSION,
                         3,
                         EGL_CONTEXT_MINOR_VERSION,
                         3,
                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                         EGL_NONE};
  egl_->context = eglCreateContext(egl_->display, config, EGL_NO_CONTEXT, wish);
  if (egl_->context == EGL_NO_CONTEXT) fail("no OpenGL 3.3 core context. " + software_hint());
  if (!eglMakeCurrent(egl_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl_->context))
    fail("the context cannot be used without a surface");
}

int GlWindow::width() const {
  if (window_ == nullptr) return options_.width;
  int w = 0, h = 0;
  glfwGetFramebufferSize(window_, &w, &h);
  return w;
}

int GlWindow::height() const {
  if (window_ == nullptr) return options_.height;
  int w = 0, h = 0;
  glfwGetFramebufferSize(window_, &w, &h);
  return h;
}

double GlWindow::content_scale() const {
  if (window_ == nullptr) return 1.0;
  float x = 1.0f, y = 1.0f;
  glfwGetWindowContentScale(window_, &x, &y);
  return x > 0.0f ? static_cast<double>(x) : 1.0;
}

bool GlWindow::wants_to_close() const {
  return window_ != nullptr && glfwWindowShouldClose(window_) == GLFW_TRUE;
}

void GlWindow::show() {
  if (window_ != nullptr)
    glfwSwapBuffers(window_);
  else
    glFinish();
}

void GlWindow::poll() {
  if (window_ != nullptr) glfwPollEvents();
}

std::string GlWindow::description() const {
  const auto text = [](GLenum what) {
    const auto* s = reinterpret_cast<const char*>(glGetString(what));
    return std::string(s == nullptr ? "unknown" : s);
  };
  return text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
}

bool GlWindow::in_software() const {
  const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  const std::string name(renderer == nullptr ? "" : renderer);
  for (const char* software : {"llvmpipe", "softpipe", "swrast", "SWR"})
    if (name.find(software) != std::string::npos) return true;
  return false;
}

}  // namespace tandem::view

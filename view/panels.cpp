#include "view/panels.h"

#include <algorithm>
#include <cmath>
#include <unistd.h>

#include <fmt/format.h>

#define GLFW_INCLUDE_NONE
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <GLFW/glfw3.h>

namespace tandem::view {
namespace {

[[nodiscard]] ImU32 colour(const Colour& c, float opacity = 1.0f) {
  return ImGui::ColorConvertFloat4ToU32({c.x, c.y, c.z, c.w * opacity});
}

[[nodiscard]] ImU32 grey(float value, float opacity) {
  return ImGui::ColorConvertFloat4ToU32({value, value, value, opacity});
}

/// A round number that is not below x: 1, 2 or 5 times a power of ten.
[[nodiscard]] double round_up(double x) {
  const double power = std::pow(10.0, std::floor(std::log10(std::max(x, 1e-9))));
  for (const double m : {1.0, 2.0, 5.0, 10.0})
    if (m * power >= x * 0.999) return m * power;
  return 10.0 * power;
}

/// One small plot: name and newest values above, the last seconds below.
void plot(const char* name, const char* unit, const std::vector<Series>& all, bool from_zero,
          double least, float width, float height) {
  double newest = -1e300, low = from_zero ? 0.0 : 1e300, high = from_zero ? least : -1e300;
  bool any = false;
  for (const Series& s : all)
    for (const Series::Point& p : s.points) {
      any = true;
      newest = std::max(newest, p.time);
      low = std::min(low, p.value);
      high = std::max(high, p.value);
    }
  if (!any) return;
  if (from_zero) {
    high = round_up(high);
  } else {
    const double middle = 0.5 * (low + high);
    const double half = 0.5 * round_up(std::max(1.15 * (high - low), least));
    low = middle - half;
    high = middle + half;
  }
  ImGui::TextUnformatted(name);
  for (const Series& s : all) {
    if (s.points.empty()) continue;
    ImGui::SameLine();
    const Colour c =
        s.colour_of >= 0 ? colour_of_site(s.colour_of) : Colour{0.25f, 0.29f, 0.36f, 1};
    const std::string label = all.size() > 1 ? s.name + " " : "";
    ImGui::TextColored({c.x, c.y, c.z, 1.0f}, "%s%.3g", label.c_str(), s.points.back().value);
  }
  ImGui::SameLine();
  ImGui::TextDisabled("%s", unit);

  const ImVec2 corner = ImGui::GetCursorScreenPos();
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled(corner, {corner.x + width, corner.y + height}, grey(1.0f, 0.55f), 3.0f);
  const auto at = [&](const Series::Point& p) {
    return ImVec2{corner.x + width * static_cast<float>(1.0 - (newest - p.time) / History::kSpan),
                  corner.y + height * static_cast<float>(1.0 - (p.value - low) / (high - low))};
  };
  int shade = 0;
  for (const Series& s : all) {
    const float dark = 0.22f + 0.22f * static_cast<float>(shade++);
    const ImU32 c = s.colour_of >= 0 ? colour(colour_of_site(s.colour_of)) : grey(dark, 1.0f);
    // Not more points than pixels.
    const std::size_t step =
        std::max<std::size_t>(1, s.points.size() / static_cast<std::size_t>(width));
    list->PathClear();
    for (std::size_t i = 0; i < s.points.size(); i += step) list->PathLineTo(at(s.points[i]));
    if (!s.points.empty()) list->PathLineTo(at(s.points.back()));
    list->PathStroke(c, 0, std::max(1.0f, height / 32.0f));
  }
  list->AddText({corner.x + 3, corner.y}, grey(0.45f, 1.0f), fmt::format("{:.4g}", high).c_str());
  ImGui::Dummy({width, height});
}

}  // namespace

Panels::Panels(GlWindow& window) : window_(window) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  ImGui::StyleColorsLight();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 6.0f;
  style.WindowBorderSize = 0.0f;
  style.FrameRounding = 3.0f;
  style.Colors[ImGuiCol_WindowBg] = {0.97f, 0.975f, 0.985f, 0.80f};
  style.Colors[ImGuiCol_Text] = {0.13f, 0.15f, 0.19f, 1.0f};
  style.Colors[ImGuiCol_TextDisabled] = {0.42f, 0.45f, 0.50f, 1.0f};
  if (window_.glfw() != nullptr) ImGui_ImplGlfw_InitForOpenGL(window_.glfw(), true);
  if (!ImGui_ImplOpenGL3_Init("#version 330 core"))
    throw WindowError("the panels cannot be set up on " + window_.description());
}

Panels::~Panels() {
  ImGui_ImplOpenGL3_Shutdown();
  if (window_.glfw() != nullptr) ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

void Panels::load_font() {
  if (std::abs(font_scale_ / scale_ - 1.0) < 0.08) return;
  font_scale_ = scale_;
  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  const auto size = static_cast<float>(std::round(14.0 * scale_));
  if (access(kFont, R_OK) != 0 || io.Fonts->AddFontFromFileTTF(kFont, size) == nullptr) {
    ImFontConfig config;
    config.SizePixels = size;
    io.Fonts->AddFontDefault(&config);
  }
  io.Fonts->Build();
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
}

void Panels::begin(int width, int height, double seconds_since_last) {
  width_ = width;
  height_ = height;
  // As the display says, and never so small or large that a picture of this size cannot be read.
  const double by_size = std::min(width / 1280.0, height / 720.0);
  scale_ = std::clamp(std::max(window_.content_scale(), by_size), 0.8, 4.0);
  if (by_size < 1.0) scale_ = std::clamp(scale_, 0.8, std::max(0.8, 1.4 * by_size));
  load_font();
  ImGui_ImplOpenGL3_NewFrame();
  if (window_.glfw() != nullptr) ImGui_ImplGlfw_NewFrame();
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
  io.DisplayFramebufferScale = {1.0f, 1.0f};
  if (window_.glfw() == nullptr)
    io.DeltaTime = static_cast<float>(std::max(seconds_since_last, 1e-3));
  ImGui::NewFrame();
}

void Panels::labels(const Drawing& drawing, const Picture& picture) {
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  for (const Label& label : drawing.labels) {
    const auto at = picture.pixel(label.at);
    if (!at) continue;
    const ImVec2 size = ImGui::CalcTextSize(label.text.c_str());
    const auto pad = static_cast<float>(4.0 * scale_);
    const auto x = static_cast<float>(picture.x + at->x) - 0.5f * size.x;
    // The picture's y is from the lower edge of the window, words' from the upper one.
    const auto y = static_cast<float>(height_ - picture.y - picture.height + at->y) - size.y;
    list->AddRectFilled({x - pad, y - 0.5f * pad}, {x + size.x + pad, y + size.y + 0.5f * pad},
                        ImGui::ColorConvertFloat4ToU32({1, 1, 1, 0.78f}), pad);
    list->AddText({x, y}, colour(label.colour), label.text.c_str());
  }
}

void Panels::plots(const History& history, const PanelText& text) {
  const auto s = static_cast<float>(scale_);
  const float width = 236.0f * s;
  ImGui::SetNextWindowPos({8.0f * s, 8.0f * s});
  ImGui::SetNextWindowSize({width + 20.0f * s, 0.0f});
  constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                      ImGuiWindowFlags_NoSavedSettings |
                                      ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;
  ImGui::Begin("plots", nullptr, kFixed);
  ImGui::PushTextWrapPos(width + 8.0f * s);
  ImGui::TextUnformatted(text.title.c_str());
  if (!text.margin.empty()) ImGui::TextDisabled("%s", text.margin.c_str());
  ImGui::PopTextWrapPos();
  ImGui::Spacing();
  const float tall =
      std::clamp((static_cast<float>(height_) - 330.0f * s) / 6.0f, 20.0f * s, 46.0f * s);
  plot("force on a hand", "N", history.force, true, 1.0, width, tall);
  plot("object", "mm", history.position, false, 2.0, width, tall);
  plot("replica gap", "mm", history.gap, true, 0.1, width, tall);
  plot("tick late", "us", history.lateness, true, 50.0, width, tall);
  plot("delay", "ms", history.delay, true, 10.0, width, tall);
  plot("loss", "%", history.loss, true, 1.0, width, tall);
  ImGui::End();

  ImGui::SetNextWindowPos({static_cast<float>(width_) - 8.0f * s, 8.0f * s}, 0, {1.0f, 0.0f});
  ImGui::Begin("notes", nullptr, kFixed | ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::TextUnformatted(text.legend.c_str());
  if (!text.status.empty()) ImGui::TextDisabled("%s", text.status.c_str());
  ImGui::PushStyleColor(ImGuiCol_Text, {0.72f, 0.20f, 0.12f, 1.0f});
  ImGui::PushTextWrapPos(320.0f * s);
  for (const std::string& line : history.news) ImGui::TextUnformatted(line.c_str());
  ImGui::PopTextWrapPos();
  ImGui::PopStyleColor();
  ImGui::End();
}

void Panels::player(Playback& playback) {
  const auto s = static_cast<float>(scale_);
  ImGui::SetNextWindowPos(
      {0.5f * static_cast<float>(width_), static_cast<float>(height_) - 10.0f * s}, 0,
      {0.5f, 1.0f});
  ImGui::SetNextWindowSize({0.55f * static_cast<float>(width_), 0.0f});
  ImGui::Begin("player", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove);
  if (ImGui::Button(playback.paused ? "play" : "pause")) playback.paused = !playback.paused;
  ImGui::SameLine();
  auto time = static_cast<float>(playback.time);
  ImGui::SetNextItemWidth(0.36f * static_cast<float>(width_));
  if (ImGui::SliderFloat("##time", &time, 0.0f, static_cast<float>(playback.length), "%.2f s"))
    playback.time = static_cast<double>(time);
  ImGui::SameLine();
  auto speed = static_cast<float>(playback.speed);
  ImGui::SetNextItemWidth(-1.0f);
  if (ImGui::SliderFloat("##speed", &speed, 0.05f, 4.0f, "speed %.2f",
                         ImGuiSliderFlags_Logarithmic))
    playback.speed = static_cast<double>(speed);
  ImGui::End();
}

void Panels::draw() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Panels::measure_only() { ImGui::EndFrame(); }

bool Panels::takes_mouse() const { return ImGui::GetIO().WantCaptureMouse; }
bool Panels::takes_keys() const { return ImGui::GetIO().WantCaptureKeyboard; }

}  // namespace tandem::view

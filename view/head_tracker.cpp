#include "view/head_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <vector>

#include <glm/gtc/quaternion.hpp>

namespace tandem::view {

Rigid parse_head(std::string_view line) {
  const auto wrong = [&](const std::string& what) -> std::invalid_argument {
    std::string shown;
    for (const char c : line.substr(0, 80)) shown += c >= ' ' && c < 127 ? c : '?';
    return std::invalid_argument("\"" + shown + "\": " + what);
  };
  std::string text(line);
  std::replace(text.begin(), text.end(), ',', ' ');
  std::vector<double> numbers;
  const char* at = text.c_str();
  while (true) {
    while (*at == ' ' || *at == '\t' || *at == '\r' || *at == '\n') ++at;
    if (*at == '\0') break;
    char* end = nullptr;
    const double x = std::strtod(at, &end);
    if (end == at || numbers.size() == 7 || !std::isfinite(x))
      throw wrong("a head is X Y Z [m], or X Y Z QW QX QY QZ");
    numbers.push_back(x);
    at = end;
  }
  if (numbers.size() != 3 && numbers.size() != 7)
    throw wrong("has " + std::to_string(numbers.size()) +
                " numbers; a head is X Y Z [m], or X Y Z QW QX QY QZ");
  Rigid head;
  for (int i = 0; i < 3; ++i) {
    head.t[i] = numbers[static_cast<std::size_t>(i)];
    if (std::abs(head.t[i]) > 100.0) throw wrong("a head is at most 100 m away; are these metres?");
  }
  if (numbers.size() == 3) return head;
  head.q = Quat(numbers[3], numbers[4], numbers[5], numbers[6]);
  const double length = std::sqrt(glm::dot(head.q, head.q));
  if (!(std::abs(length - 1.0) < 0.01))
    throw wrong("QW QX QY QZ has length " + std::to_string(length) + "; a turn has length 1");
  head.q = glm::normalize(head.q);
  return head;
}

HeadTracker::HeadTracker(const std::string& bind)
    : link_(bind.find(':') == std::string::npos ? "127.0.0.1:" + bind : bind) {}

std::string HeadTracker::address() const { return net::to_string(link_.local()); }

bool HeadTracker::update(double now, Rigid& head) {
  bool any = false;
  std::array<std::uint8_t, 512> buffer{};
  net::Endpoint from;
  // Not for ever: a picture waits for this.
  for (int i = 0; i < 1000; ++i) {
    const auto size = link_.receive(from, buffer);
    if (!size) break;
    try {
      head = parse_head({reinterpret_cast<const char*>(buffer.data()), *size});
      ++accepted_;
      last_ = now;
      any = true;
    } catch (const std::invalid_argument& e) {
      ++refused_;
      refusal_ = e.what();
    }
  }
  return any;
}

}  // namespace tandem::view

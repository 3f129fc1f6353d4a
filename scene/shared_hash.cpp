#include "scene/shared_hash.h"

#include <bit>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "scene/scene_fields.h"

namespace tandem::scene {
namespace {

class Hasher {
 public:
  void where(std::string_view) {}

  template <typename T>
  void value(const Field& field, T& value) {
    if (field.local) return;
    if constexpr (std::is_same_v<T, double>)
      add(std::bit_cast<std::uint64_t>(value + 0.0));  // -0 + 0 = 0
    else if constexpr (std::is_same_v<T, std::string>)
      add_text(value);
    else
      add(static_cast<std::uint64_t>(static_cast<std::int64_t>(value)));
  }

  template <typename Fn>
  void group(const Field& field, Fn&& fn) {
    if (!field.local) fn(*this);
  }

  template <typename T, typename Fn>
  void optional_group(const Field& field, std::optional<T>& part, Fn&& fn) {
    if (field.local) return;
    add(part.has_value() ? 1 : 0);
    if (part) fn(*part, *this);
  }

  template <typename T, typename Fn>
  void list(const Field& field, std::vector<T>& entries, int /*max*/, Fn&& fn) {
    if (field.local) return;
    add(entries.size());
    for (T& entry : entries) fn(entry, *this);
  }

  [[nodiscard]] std::uint64_t hash() const { return hash_; }

 private:
  void add_byte(std::uint64_t byte) { hash_ = (hash_ ^ byte) * 0x100000001b3; }
  void add(std::uint64_t number) {
    for (int shift = 0; shift < 64; shift += 8) add_byte((number >> shift) & 0xff);
  }
  void add_text(const std::string& text) {
    add(text.size());
    for (const char c : text) add_byte(static_cast<unsigned char>(c));
  }

  std::uint64_t hash_ = 0xcbf29ce484222325;
};

}  // namespace

std::uint64_t shared_hash(const core::Scene& scene) {
  core::Scene copy = scene;  // the list of fields is written for readers, too
  Hasher hasher;
  visit_scene(copy, hasher);
  return hasher.hash();
}

}  // namespace tandem::scene

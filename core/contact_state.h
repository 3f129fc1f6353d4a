#pragma once

#include <cstdint>

namespace tandem::core {

/// States of one contact, thesis Fig. 7.4.
enum class ContactState : std::uint8_t {
  kFree = 0,
  kMomentCancellation = 1,
  kPreSlide = 2,
  kSlide = 3,
};

inline constexpr int kMaxPackedContacts = 8;

/// Contacts in one word, 4 bits each, contact 0 lowest: bits 0-1 the state, bits 2-3 the side that
/// is touched (0 +x, 1 -x, 2 +y, 3 -y of the box). `index` is in 0 .. 7; others change nothing.
[[nodiscard]] constexpr std::uint32_t with_contact(std::uint32_t contact_bits, int index,
                                                   ContactState state, int side = 0) noexcept {
  if (index < 0 || index >= kMaxPackedContacts) return contact_bits;
  const auto nibble =
      (static_cast<std::uint32_t>(state) & 3u) | ((static_cast<std::uint32_t>(side) & 3u) << 2);
  return (contact_bits & ~(0xfu << (4 * index))) | (nibble << (4 * index));
}

/// Contacts of a site: finger f on object o is contact 4 o + f, so that two objects have room; on
/// further objects they are felt but not told.
inline constexpr int kPackedFingers = 4;
[[nodiscard]] constexpr std::uint32_t contact_word(std::uint32_t contact, int object,
                                                   int finger) noexcept {
  return with_contact(0, object * kPackedFingers + finger, static_cast<ContactState>(contact & 3u),
                      static_cast<int>(contact >> 2));
}

/// The contact of a site's finger: the first object it touches, or contact `finger` where it
/// touches none.
[[nodiscard]] constexpr int contact_of_finger(std::uint32_t contact_bits, int finger) noexcept {
  for (int i = finger; i < kMaxPackedContacts; i += kPackedFingers)
    if (((contact_bits >> (4 * i)) & 3u) != 0) return i;
  return finger;
}

[[nodiscard]] constexpr ContactState contact_state(std::uint32_t contact_bits, int index) noexcept {
  if (index < 0 || index >= kMaxPackedContacts) return ContactState::kFree;
  return static_cast<ContactState>((contact_bits >> (4 * index)) & 3u);
}

[[nodiscard]] constexpr int contact_side(std::uint32_t contact_bits, int index) noexcept {
  if (index < 0 || index >= kMaxPackedContacts) return 0;
  return static_cast<int>((contact_bits >> (4 * index + 2)) & 3u);
}

}  // namespace tandem::core

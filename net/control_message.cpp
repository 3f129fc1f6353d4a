#include "net/control_message.h"

#include <algorithm>

#include "core/packet.h"
#include "core/scene.h"
#include "net/wire.pb.h"

namespace tandem::net {
namespace {

/// Names and texts reach terminals and log files: no escape sequences, no line breaks.
[[nodiscard]] bool printable(const std::string& text, std::size_t max_bytes) {
  return text.size() <= max_bytes && std::none_of(text.begin(), text.end(), [](char c) {
           return static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
         });
}

[[nodiscard]] std::string clean(const std::string& text, std::size_t max_bytes) {
  std::string out = text.substr(0, max_bytes);
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  return out;
}

[[nodiscard]] bool valid(const ControlMessage& m) {
  switch (m.type) {
    case ControlType::kHello:
    case ControlType::kSpectate:
      return m.nonce != 0;
    case ControlType::kWelcome:
      return m.nonce != 0 && m.session != 0 && m.packet_hz > 0.0 && m.packet_hz <= 1e5 &&
             m.user_index < core::kMaxUsers &&
             (m.host_sender < core::kMaxUsers || m.host_sender == core::kServerSender);
    case ControlType::kRefuse:
      return m.reason != RefuseReason::kNone;
    case ControlType::kSceneRequest:
      return m.session != 0;
    case ControlType::kSceneChunk:
      return m.session != 0 && m.total <= kMaxSceneBytes && !m.chunk.empty() &&
             m.chunk.size() <= kMaxChunkBytes && m.offset < m.total &&
             m.chunk.size() <= m.total - m.offset;
    case ControlType::kKeepAlive:
    case ControlType::kLeave:
      return m.session != 0;
  }
  return false;
}

}  // namespace

const char* name_of(RefuseReason reason) noexcept {
  switch (reason) {
    case RefuseReason::kNone:
      return "none";
    case RefuseReason::kWrongVersion:
      return "wrong version";
    case RefuseReason::kOtherScene:
      return "other scene";
    case RefuseReason::kServerFull:
      return "server full";
    case RefuseReason::kUserNameTaken:
      return "user name taken";
    case RefuseReason::kUnknownUserName:
      return "unknown user name";
    case RefuseReason::kUnknownSession:
      return "unknown session";
    case RefuseReason::kWrongRole:
      return "wrong role";
  }
  return "reason unknown to this version";
}

std::vector<std::uint8_t> encode_control(const ControlMessage& message) {
  wire::Control m;
  m.set_type(static_cast<wire::Control_Type>(message.type));
  m.set_session(message.session);
  m.set_nonce(message.nonce);
  m.set_scene_hash(message.scene_hash);
  m.set_user_name(clean(message.user_name, kMaxNameBytes));
  m.set_program_version(clean(message.program_version, kMaxNameBytes));
  m.set_packet_hz(message.packet_hz);
  m.set_reason(static_cast<std::uint32_t>(message.reason));
  m.set_text(clean(message.text, kMaxTextBytes));
  m.set_user_index(message.user_index);
  m.set_host_sender(message.host_sender);
  m.set_offset(message.offset);
  m.set_total(message.total);
  m.set_chunk(message.chunk.substr(0, kMaxChunkBytes));
  const std::size_t bytes = m.ByteSizeLong();
  std::vector<std::uint8_t> datagram(kPrefixBytes + bytes);
  write_prefix(datagram, Kind::kControl, bytes, message.version);
  m.SerializeWithCachedSizesToArray(datagram.data() + kPrefixBytes);
  return datagram;
}

std::optional<ControlMessage> decode_control(std::span<const std::uint8_t> datagram) {
  Prefix prefix;
  if (read_prefix(datagram, prefix) != PrefixFault::kNone || prefix.kind != Kind::kControl)
    return std::nullopt;
  wire::Control m;
  if (!m.ParseFromArray(datagram.data() + kPrefixBytes,
                        static_cast<int>(datagram.size() - kPrefixBytes)))
    return std::nullopt;

  ControlMessage out;
  out.version = prefix.version;
  out.type = static_cast<ControlType>(m.type());
  out.session = m.session();
  out.nonce = m.nonce();
  out.reason = static_cast<RefuseReason>(m.reason());
  if (m.type() < 1 || m.type() > 8 || !printable(m.text(), kMaxTextBytes)) return std::nullopt;
  out.text = m.text();
  if (prefix.version != kProtocolVersion) return out;

  if (!printable(m.user_name(), kMaxNameBytes) || !printable(m.program_version(), kMaxNameBytes))
    return std::nullopt;
  out.scene_hash = m.scene_hash();
  out.user_name = m.user_name();
  out.program_version = m.program_version();
  out.packet_hz = m.packet_hz();
  out.user_index = m.user_index();
  out.host_sender = m.host_sender();
  out.offset = m.offset();
  out.total = m.total();
  out.chunk = m.chunk();
  if (!valid(out)) return std::nullopt;
  return out;
}

}  // namespace tandem::net

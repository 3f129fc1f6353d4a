#include "net/endpoint.h"

#include <arpa/inet.h>
#include <charconv>
#include <stdexcept>

namespace tandem::net {

std::string to_string(const Endpoint& endpoint) {
  char text[INET6_ADDRSTRLEN] = "?";
  inet_ntop(endpoint.is_v6 ? AF_INET6 : AF_INET, endpoint.ip.data(), text, sizeof text);
  const std::string address = endpoint.is_v6 ? "[" + std::string(text) + "]" : text;
  return address + ":" + std::to_string(endpoint.port);
}

HostPort parse_host_port(std::string_view text) {
  const auto refuse = [&](const std::string& what) {
    return std::invalid_argument("address '" + std::string(text) + "': " + what +
                                 " (write HOST:PORT, for example 192.168.1.5:7000 or [::1]:7000)");
  };
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) throw refuse("the port is missing");
  std::string_view host = text.substr(0, colon);
  const std::string_view port_text = text.substr(colon + 1);
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']')
    host = host.substr(1, host.size() - 2);
  else if (host.find(':') != std::string_view::npos)
    throw refuse("an IPv6 address needs square brackets");
  if (host.empty()) throw refuse("the host is missing");

  unsigned port = 0;
  const auto [end, error] =
      std::from_chars(port_text.data(), port_text.data() + port_text.size(), port);
  if (error != std::errc{} || end != port_text.data() + port_text.size() || port > 65535)
    throw refuse("the port '" + std::string(port_text) + "' is not a number from 0 to 65535");
  return {std::string(host), static_cast<std::uint16_t>(port)};
}

}  // namespace tandem::net

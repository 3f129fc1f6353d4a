#include "net/udp_socket.h"

#include <algorithm>
#include <ctime>
#include <poll.h>
#include <stdexcept>
#include <utility>  // before Asio: its 1.8x headers use std::exchange without including it

// No handler ever runs here, so Asio's fences have nothing to order; thread sanitizer's compiler
// does not know them and would warn.
#define BOOST_ASIO_DISABLE_FENCED_BLOCK
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>

namespace tandem::net {
namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

namespace {

Endpoint from_asio(const udp::endpoint& e) noexcept {
  Endpoint out;
  out.port = e.port();
  out.is_v6 = e.address().is_v6();
  if (out.is_v6) {
    const auto bytes = e.address().to_v6().to_bytes();
    std::copy(bytes.begin(), bytes.end(), out.ip.begin());
  } else {
    const auto bytes = e.address().to_v4().to_bytes();
    std::copy(bytes.begin(), bytes.end(), out.ip.begin());
  }
  return out;
}

udp::endpoint to_asio(const Endpoint& e) noexcept {
  if (e.is_v6) return {asio::ip::address_v6(e.ip), e.port};
  return {asio::ip::address_v4({e.ip[0], e.ip[1], e.ip[2], e.ip[3]}), e.port};
}

}  // namespace

struct UdpLink::Socket {
  asio::io_context context{1};
  udp::socket socket{context};
};

UdpLink::UdpLink(const std::string& bind) : socket_(std::make_unique<Socket>()) {
  const HostPort wanted = parse_host_port(bind);
  const auto refuse = [&](const std::string& what) {
    return std::runtime_error("cannot listen on " + bind + ": " + what);
  };
  error_code error;
  udp::resolver resolver(socket_->context);
  const auto found = resolver.resolve(wanted.host, std::to_string(wanted.port), error);
  if (error || found.empty())
    throw refuse("the name '" + wanted.host + "' cannot be resolved (" + error.message() +
                 "); give one of this machine's addresses, or 0.0.0.0 for all of them");
  const udp::endpoint own = found.begin()->endpoint();

  socket_->socket.open(own.protocol(), error);
  if (error) throw refuse(error.message());
  socket_->socket.bind(own, error);
  if (error == asio::error::address_in_use)
    throw refuse(
        "the port is in use by another program; choose another port with --bind, or stop "
        "that program (ss -lunp shows it)");
  if (error == boost::system::errc::address_not_available)
    throw refuse(
        "this is not an address of this machine; 'ip address' lists them, 0.0.0.0 means "
        "all of them");
  if (error == asio::error::access_denied)
    throw refuse("permission denied; ports below 1024 need root, choose a higher one");
  if (error) throw refuse(error.message());
  socket_->socket.non_blocking(true, error);
  if (error) throw refuse(error.message());
}

UdpLink::~UdpLink() = default;

bool UdpLink::send(const Endpoint& to, std::span<const std::uint8_t> datagram) noexcept {
  error_code error;
  socket_->socket.send_to(asio::buffer(datagram.data(), datagram.size()), to_asio(to), 0, error);
  return !error;
}

std::optional<std::size_t> UdpLink::receive(Endpoint& from,
                                            std::span<std::uint8_t> buffer) noexcept {
  error_code error;
  udp::endpoint sender;
  const std::size_t size =
      socket_->socket.receive_from(asio::buffer(buffer.data(), buffer.size()), sender, 0, error);
  if (error) return std::nullopt;
  from = from_asio(sender);
  return size;
}

void UdpLink::wait(std::int64_t timeout_ns) noexcept {
  pollfd waiting{.fd = socket_->socket.native_handle(), .events = POLLIN, .revents = 0};
  timeout_ns = std::max<std::int64_t>(timeout_ns, 0);
  const timespec timeout{.tv_sec = timeout_ns / 1'000'000'000,
                         .tv_nsec = timeout_ns % 1'000'000'000};
  ppoll(&waiting, 1, &timeout, nullptr);
}

Endpoint UdpLink::local() const noexcept {
  error_code error;
  return from_asio(socket_->socket.local_endpoint(error));
}

Endpoint UdpLink::resolve(const std::string& host_port) const {
  const HostPort wanted = parse_host_port(host_port);
  if (wanted.port == 0)
    throw std::invalid_argument("address '" + host_port +
                                "': port 0 cannot be reached (1 to 65535)");
  error_code error;
  const udp family = local().is_v6 ? udp::v6() : udp::v4();
  udp::resolver resolver(socket_->context);
  const auto found = resolver.resolve(family, wanted.host, std::to_string(wanted.port), error);
  if (error || found.empty())
    throw std::runtime_error("cannot reach " + host_port + ": the name '" + wanted.host +
                             "' cannot be resolved to an " + (local().is_v6 ? "IPv6" : "IPv4") +
                             " address (" + error.message() +
                             "); check the spelling, give the address in numbers, or --bind to an "
                             "address of the other family");
  return from_asio(found.begin()->endpoint());
}

}  // namespace tandem::net

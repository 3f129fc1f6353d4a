// A peer of `tandem bench latency`: plain Boost.Asio, blocking send_to and receive_from.
#include <memory>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>

#include "bench/latency_peer.h"

int main(int words, char** word) {
  using boost::asio::ip::udp;
  using namespace tandem::bench;
  static boost::asio::io_context context;
  const auto loopback = boost::asio::ip::address_v4::loopback();
  return run_peer(
      words, word,
      [&](const PeerRun& run, PeerReport& report) {
        udp::socket socket(context, udp::endpoint(loopback, 0));
        report.ready(socket.local_endpoint().port());
        std::vector<char> message(static_cast<std::size_t>(run.bytes));
        udp::endpoint from;
        do socket.receive_from(boost::asio::buffer(message), from);
        while (report.take(message.data()));
      },
      [&](const PeerRun&, int port) {
        auto socket = std::make_shared<udp::socket>(context, udp::endpoint(loopback, 0));
        const udp::endpoint to(loopback, static_cast<unsigned short>(port));
        return [=](const char* message, std::size_t bytes) {
          socket->send_to(boost::asio::buffer(message, bytes), to);
        };
      });
}

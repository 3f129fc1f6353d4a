// A peer of `tandem bench latency`: ENet, unreliable sequenced packets, enet_host_service that
// blocks.
#include <enet/enet.h>

#include "bench/latency_peer.h"

namespace {

constexpr enet_uint32 kPatience_ms = 10'000;

[[noreturn]] void give_up(const char* why) {
  std::fprintf(stderr, "bench_latency_enet: %s\n", why);
  std::_Exit(1);
}

}  // namespace

int main(int words, char** word) {
  using namespace tandem::bench;
  return run_peer(
      words, word,
      [](const PeerRun&, PeerReport& report) {
        enet_initialize();
        ENetAddress address{};
        enet_address_set_host(&address, "127.0.0.1");
        address.port = ENET_PORT_ANY;
        ENetHost* host = enet_host_create(&address, 1, 1, 0, 0);
        if (host == nullptr) give_up("no host");
        ENetAddress own{};
        enet_socket_get_address(host->socket, &own);
        report.ready(own.port);
        ENetEvent event;
        while (enet_host_service(host, &event, kPatience_ms) > 0) {
          if (event.type != ENET_EVENT_TYPE_RECEIVE) continue;
          const bool more = report.take(event.packet->data);
          enet_packet_destroy(event.packet);
          if (!more) break;
        }
      },
      [](const PeerRun&, int port) {
        enet_initialize();
        ENetHost* host = enet_host_create(nullptr, 1, 1, 0, 0);
        ENetAddress address{};
        enet_address_set_host(&address, "127.0.0.1");
        address.port = static_cast<enet_uint16>(port);
        ENetPeer* peer = enet_host_connect(host, &address, 1, 0);
        ENetEvent event;
        if (peer == nullptr || enet_host_service(host, &event, kPatience_ms) <= 0 ||
            event.type != ENET_EVENT_TYPE_CONNECT)
          give_up("no connection");
        return [=](const char* message, std::size_t bytes) {
          enet_peer_send(peer, 0, enet_packet_create(message, bytes, 0));
          enet_host_flush(host);
          // What the other side answers by itself: pings, bandwidth.
          ENetEvent ignored;
          while (enet_host_service(host, &ignored, 0) > 0) {
          }
        };
      });
}

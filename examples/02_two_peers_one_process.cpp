// 02 - Two people hold the same mass over a link, each with a copy of it, in one process.
//
//   hand 1 ──coupler── copy 1 ══ link ══ copy 2 ──coupler── hand 2
//
// Shows:   arch_distributed, the modelled link, what the packet rate costs.
// Run:     ./build/release/examples/02_two_peers_one_process [round trip in packet periods, 0-7]
// You see: user 1 pushes with 0.1 N for five seconds; how far the hand gets, against what the
//          plain mass would do, with held packets and with extrapolated ones.

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "arch_distributed/distributed_loop.h"
#include "core/axis_world.h"
#include "scene/load_scene.h"

namespace {

double travel(const tandem::core::Scene& scene, double delay_packets) {
  tandem::core::NetworkModel network;
  network.set_round_trip(delay_packets, scene.ticks_per_packet());
  tandem::distributed::DistributedLoop<tandem::core::AxisWorld> loop(scene, network);
  loop.hands().finger(0, 0).set_external_force(0.1);
  while (loop.time() < 5.0) loop.advance_packet_period();
  return loop.hands().finger(0, 0).position();
}

}  // namespace

int main(int argc, char** argv) try {
  const double delay = argc > 1 ? std::atof(argv[1]) : 1.0;
  tandem::core::Scene scene = tandem::scene::load_scene("axis_distributed_split");
  const double held = travel(scene, delay);
  scene.reconstruction.kind = tandem::core::ReconstructionKind::kExtrapolate;
  const double extrapolated = travel(scene, delay);
  const double mass = scene.objects[0].mass + scene.users[0].mass + scene.users[1].mass;
  const double ideal = 0.5 * 0.1 / mass * 25.0;
  std::printf("round trip %.1f packet periods; 0.1 N for 5 s on %.1f kg\n", delay, mass);
  std::printf("  a plain mass        %.3f m\n", ideal);
  std::printf("  held packets        %.3f m\n", held);
  std::printf("  extrapolated        %.3f m\n", extrapolated);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 2;
}

// A session of two users from a scene that was installed with Tandem, run for two seconds of
// virtual time by a program that knows nothing but the installed headers and libraries.

#include <cmath>
#include <cstdio>
#include <exception>

#include "arch_central/central_loop.h"
#include "arch_distributed/distributed_loop.h"
#include "core/axis_world.h"
#include "core/scene.h"
#include "devices/haptic_device.h"
#include "net/endpoint.h"
#include "scene/load_scene.h"

int main() {
  try {
    const tandem::core::Scene scene = tandem::scene::load_scene("axis_distributed");
    tandem::distributed::DistributedLoop<tandem::core::AxisWorld> loop(scene);
    while (loop.time() < 2.0) loop.tick();
    const auto sent = static_cast<long long>(loop.packets_sent());
    std::printf("outside project: %.3f s of %s, %lld packets\n", loop.time(), scene.name.c_str(),
                sent);
    // Two users, one packet each in every packet period.
    const double wanted = 2.0 * 2.0 * scene.rates.packet_hz;
    return std::fabs(static_cast<double>(sent) - wanted) < 0.5 ? 0 : 1;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}

#include "node/recording_header.h"

#include <cstdio>

#include <fmt/format.h>

#include "node/site_name.h"
#include "scene/scene_text.h"
#include "scene/shared_hash.h"

namespace tandem::node {

recording::RecordingHeader recording_header(const SessionSetup& setup, std::int64_t start_ns) {
  recording::RecordingHeader header;
  header.scene_text = scene::to_text(setup.scene);
  header.scene_hash = fmt::format("{:016x}", scene::shared_hash(setup.scene));
  header.git_revision = setup.options.git_revision;
  header.program_version = setup.options.program_version;
  header.user = setup.user;
  header.local_rate_hz = setup.scene.rates.local_hz;
  header.start_ns = start_ns;
  return header;
}

void tell_realtime(const SessionSetup& setup, const NodeReport& report) {
  for (const core::RealtimeSetting& s : report.realtime)
    if (!s.granted)
      std::fprintf(stderr, "%s: real-time: asked %s %s: not granted: %s; to get it: %s\n",
                   site_name(setup.role, setup.user).c_str(), s.name.c_str(), s.asked.c_str(),
                   s.refusal.c_str(), s.to_get_it.c_str());
  std::fprintf(
      stderr,
      "%s: spins the last %.0f us of every wait, up to %.0f %% of a processor (--spin-us)\n",
      site_name(setup.role, setup.user).c_str(), 1e-3 * static_cast<double>(report.spin_ns),
      1e-7 * static_cast<double>(report.spin_ns) * setup.scene.rates.local_hz);
}

}  // namespace tandem::node

#include "bench/latency_stages.h"

#include <algorithm>

#include "core/random.h"

namespace tandem::bench {
namespace {

double us(std::int64_t from, std::int64_t to) { return 1e-3 * static_cast<double>(to - from); }

std::vector<double>& of(Stages& stages, Stage stage) {
  return stages.us[static_cast<std::size_t>(stage)];
}

}  // namespace

void add_run(const PathRun& run, int motions, std::uint64_t seed, Stages& stages) {
  if (run.wakes.empty() || run.packets.empty()) return;
  for (const PathPacket& p : run.packets) {
    of(stages, Stage::kPublish).push_back(us(p.sampled, p.published));
    of(stages, Stage::kLink).push_back(us(p.published, p.sent));
    of(stages, Stage::kWire).push_back(us(p.sent, p.arrived));
    of(stages, Stage::kApply).push_back(us(p.arrived, p.used));
    of(stages, Stage::kForce).push_back(us(p.used, p.felt));
    stages.handed_over.push_back(us(p.published, p.arrived));
  }
  core::Random random(seed);
  const double first = static_cast<double>(run.wakes.front());
  const double last = static_cast<double>(run.packets.back().sampled);
  const double before = static_cast<double>(stages.total.size());
  std::array<double, kStages> sums{};
  double total = 0.0;
  for (int m = 0; m < motions; ++m) {
    const auto moved = static_cast<std::int64_t>(random.uniform(first, last));
    const auto wake = std::lower_bound(run.wakes.begin(), run.wakes.end(), moved);
    const auto packet =
        std::lower_bound(run.packets.begin(), run.packets.end(), *wake,
                         [](const PathPacket& p, std::int64_t at) { return p.sampled < at; });
    const std::array<std::int64_t, kStages + 1> stamps{
        moved,        *wake,           packet->sampled, packet->published,
        packet->sent, packet->arrived, packet->used,    packet->felt};
    for (std::size_t s = 0; s < kStages; ++s) sums[s] += us(stamps[s], stamps[s + 1]);
    of(stages, Stage::kSample).push_back(us(stamps[0], stamps[1]));
    of(stages, Stage::kSlot).push_back(us(stamps[1], stamps[2]));
    stages.total.push_back(us(stamps.front(), stamps.back()));
    total += stages.total.back();
  }
  const double after = static_cast<double>(stages.total.size());
  const auto blend = [&](double& mean, double sum) { mean = (mean * before + sum) / after; };
  for (std::size_t s = 0; s < kStages; ++s) blend(stages.mean_us[s], sums[s]);
  blend(stages.mean_total_us, total);
}

}  // namespace tandem::bench

#include "cli/replay_recording.h"

#include <bit>
#include <utility>

#include <fmt/format.h>

#include "cli/recorded_ticks.h"
#include "cli/replayed_site.h"
#include "core/with_world.h"
#include "scene/load_scene.h"

namespace tandem::cli {
namespace {

/// Compares in the order of the record; remembers the first difference.
class Comparison {
 public:
  explicit Comparison(std::int64_t slot) : slot_(slot) {}

  void value(const std::string& quantity, double expected, double got) {
    const auto a = std::bit_cast<std::uint64_t>(expected), b = std::bit_cast<std::uint64_t>(got);
    if (a != b)
      note(quantity, fmt::format("{} ({:016x})", expected, a), fmt::format("{} ({:016x})", got, b));
  }
  void bits(const std::string& quantity, std::uint32_t expected, std::uint32_t got) {
    if (expected != got)
      note(quantity, fmt::format("{:08x}", expected), fmt::format("{:08x}", got));
  }
  [[nodiscard]] std::optional<ReplayDifference> result() const { return difference_; }

 private:
  void note(const std::string& quantity, std::string expected, std::string got) {
    if (!difference_)
      difference_ = ReplayDifference{slot_, quantity, std::move(expected), std::move(got)};
  }

  std::int64_t slot_;
  std::optional<ReplayDifference> difference_;
};

constexpr auto kLawFaults = static_cast<std::uint32_t>(
    core::Fault::kNotFinite | core::Fault::kForceSaturated | core::Fault::kForceSlewed);

std::optional<ReplayDifference> compare(const core::TickRecord& recorded,
                                        const core::TickRecord& got,
                                        const recording::RecordColumns& columns) {
  Comparison comparison(recorded.slot);
  for (int f = 0; f < columns.fingers; ++f)
    for (int i = 0; i < columns.hand_values; ++i)
      comparison.value(fmt::format("command[{}].{}", f, "xyz"[i]), recorded.command[f][i],
                       got.command[f][i]);
  for (int o = 0; o < columns.objects; ++o)
    for (int i = 0; i < columns.object_values; ++i)
      comparison.value(fmt::format("object[{}][{}]", o, i), recorded.objects[o][i],
                       got.objects[o][i]);
  if (columns.objects > 0)
    comparison.bits("contact_bits[0]", recorded.contact_bits[0], got.contact_bits[0]);
  comparison.bits("faults", recorded.faults & kLawFaults, got.faults & kLawFaults);
  return comparison.result();
}

template <typename Site>
void run(recording::RecordingReader& reader, Site&& site, ReplayResult& result) {
  RecordedTicks ticks(reader);
  while (!result.difference && ticks.next()) {
    const core::TickRecord& tick = ticks.tick();
    const core::TickRecord got = site.step(tick, ticks.packets());
    result.difference = compare(tick, got, reader.columns());
    if (result.ticks == 0)
      result.first_slot = tick.slot;
    else
      result.skipped_slots += tick.slot - result.last_slot - 1;
    result.last_slot = tick.slot;
    ++result.ticks;
    result.packets += ticks.packets().size();
  }
}

}  // namespace

ReplayResult replay_recording(const std::string& file) {
  recording::RecordingReader reader(file);
  ReplayResult result;
  result.user = reader.header().user;
  result.scene = scene::load_scene_text(reader.header().scene_text, "scene in " + file);
  result.complete = reader.complete();
  result.records_lost = reader.records_lost();
  const bool central = result.scene.architecture == core::Architecture::kCentral ||
                       result.scene.architecture == core::Architecture::kSingle;
  result.role = !central ? "replica" : result.user == "server" ? "server" : "client";
  core::with_world(result.scene, [&]<typename World>(World) {
    if (!central)
      run(reader, ReplayedReplica<World>(result.scene, result.user), result);
    else if (result.user == "server")
      run(reader, ReplayedServer<World>(result.scene, result.user), result);
    else
      run(reader, ReplayedClient<World>(result.scene, result.user), result);
  });
  return result;
}

}  // namespace tandem::cli
